/* Small files of every format, for the tests of reading and of malformed input: the same tetrahedron, volume 1/6. */
#ifndef PITH_TESTS_MESH_SAMPLES_H
#define PITH_TESTS_MESH_SAMPLES_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct mesh_sample {
    const char *format;
    unsigned char *bytes;
    size_t size;
} mesh_sample;

static const double sample_corners[4][3] = { { 0, 0, 0 }, { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } };
static const uint32_t sample_faces[4][3] = { { 0, 2, 1 }, { 0, 1, 3 }, { 0, 3, 2 }, { 1, 2, 3 } };

static inline mesh_sample sample_text(const char *format, const char *text)
{
    mesh_sample sample = { format, malloc(strlen(text)), strlen(text) };
    memcpy(sample.bytes, text, sample.size);
    return sample;
}

static inline void sample_add(mesh_sample *sample, const void *bytes, size_t size)
{
    sample->bytes = realloc(sample->bytes, sample->size + size);
    memcpy(sample->bytes + sample->size, bytes, size);
    sample->size += size;
}

/* A number in the given byte order, independent of this machine's. */
static inline void sample_number(mesh_sample *sample, const void *value, size_t size, int big)
{
    unsigned char b[8];
    memcpy(b, value, size);
    const uint16_t probe = 1;
    const int machine_big = *(const unsigned char *)&probe == 0;
    for (size_t k = 0; k < size / 2 && big != machine_big; ++k) {
        const unsigned char swapped = b[k];
        b[k] = b[size - 1 - k];
        b[size - 1 - k] = swapped;
    }
    sample_add(sample, b, size);
}

static inline mesh_sample sample_obj(void)
{
    return sample_text("obj",
                       "# a comment\nmtllib x.mtl\nv 0 0 0\nv 1.0 0 0\r\nv 0 1e0 0\nv 0 0 1 1\nvt 0 0\nvt 1 0\nvt 0 1\n"
                       "vn 0 0 -1\nvn 0 -1 0\no body\ns off\nf 1/1/1 3/3/1 2/2/1\nf 1//2 2//2 4//2\nf -4 -1 \\\n"
                       " -2\nf 2/1 3/2 4/3\n");
}

static inline mesh_sample sample_off(void)
{
    return sample_text("off",
                       "OFF # the keyword\n\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 255 0 0\n3 0 1 3\n3 0 3 2\n"
                       "3 1 2 3\n");
}

static inline mesh_sample sample_ply_ascii(void)
{
    return sample_text("ply",
                       "ply\nformat ascii 1.0\ncomment x\nelement vertex 4\nproperty uchar red\nproperty float z\n"
                       "property double y\nproperty list uchar int extra\nproperty float x\nproperty uchar green\n"
                       "property uchar blue\nelement other 2\nproperty int a\nelement face 4\nproperty uchar flag\n"
                       "property list uchar int vertex_indices\nend_header\n255 0 0 0 0 0 0\n188 0 0 2 7 8 1 0 0\n"
                       "0 0 1 0 0 255 0\n0 1 0 0 0 0 255\n5\n6\n1 3 0 2 1\n1 3 0 1 3\n1 3 0 3 2\n1 3 1 2 3\n");
}

static inline mesh_sample sample_ply_binary(int big)
{
    char header[400];
    snprintf(
        header, sizeof header,
        "ply\nformat binary_%s_endian 1.0\nelement vertex 4\nproperty float x\nproperty short y\nproperty double z\n"
        "property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n"
        "element face 4\nproperty list ushort uint vertex_index\nend_header\n",
        big ? "big" : "little");
    mesh_sample sample = sample_text("ply", header);
    for (int v = 0; v < 4; ++v) {
        const float x = (float)sample_corners[v][0], normal[3] = { 0, 0, 2 }, uv[2] = { 0.25f * (float)v, 0.5f };
        const int16_t y = (int16_t)sample_corners[v][1];
        sample_number(&sample, &x, 4, big);
        sample_number(&sample, &y, 2, big);
        sample_number(&sample, &sample_corners[v][2], 8, big);
        for (int k = 0; k < 3; ++k) sample_number(&sample, &normal[k], 4, big);
        for (int k = 0; k < 2; ++k) sample_number(&sample, &uv[k], 4, big);
    }
    for (int f = 0; f < 4; ++f) {
        const uint16_t count = 3;
        sample_number(&sample, &count, 2, big);
        for (int k = 0; k < 3; ++k) sample_number(&sample, &sample_faces[f][k], 4, big);
    }
    return sample;
}

static inline mesh_sample sample_stl_ascii(void)
{
    mesh_sample sample = sample_text("stl", "solid tetrahedron\n");
    for (int f = 0; f < 4; ++f) {
        char facet[300];
        const double *a = sample_corners[sample_faces[f][0]], *b = sample_corners[sample_faces[f][1]];
        const double *c = sample_corners[sample_faces[f][2]];
        snprintf(facet, sizeof facet,
                 "facet normal 0 0 0\n outer loop\n  vertex %g %g %g\n  vertex %g %g %g\n  vertex %g %g %g\n endloop\n"
                 "endfacet\n",
                 a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]);
        sample_add(&sample, facet, strlen(facet));
    }
    sample_add(&sample, "endsolid\n", 9);
    return sample;
}

static inline mesh_sample sample_stl_binary(void)
{
    char header[80] = "solid, although this one is binary";
    const uint32_t count = 4;
    mesh_sample sample = sample_text("stl", "");
    sample_add(&sample, header, sizeof header);
    sample_number(&sample, &count, 4, 0);
    for (int f = 0; f < 4; ++f) {
        const float normal[3] = { 0, 0, 0 };
        sample_add(&sample, normal, sizeof normal);
        for (int k = 0; k < 3; ++k)
            for (int a = 0; a < 3; ++a) {
                const float x = (float)sample_corners[sample_faces[f][k]][a];
                sample_number(&sample, &x, 4, 0);
            }
        sample_add(&sample, "\0", 2);
    }
    return sample;
}

/* A GLB from its JSON and its binary chunk, both padded. */
static inline mesh_sample sample_glb_of(const char *json, const mesh_sample *binary)
{
    mesh_sample sample = sample_text("glb", "glTF");
    const size_t length = strlen(json), padding = (4 - length % 4) % 4;
    const uint32_t head[4] = { 2, (uint32_t)(12 + 8 + length + padding + 8 + binary->size),
                               (uint32_t)(length + padding), 0x4E4F534A };
    for (int k = 0; k < 4; ++k) sample_number(&sample, &head[k], 4, 0);
    sample_add(&sample, json, length);
    sample_add(&sample, "   ", padding);
    const uint32_t tail[2] = { (uint32_t)binary->size, 0x004E4942 };
    for (int k = 0; k < 2; ++k) sample_number(&sample, &tail[k], 4, 0);
    sample_add(&sample, binary->bytes, binary->size);
    return sample;
}

/* Corners, normals of no unit length, byte colours, then byte indices padded to four. */
static inline mesh_sample sample_glb_binary(void)
{
    mesh_sample binary = sample_text("", "");
    for (int v = 0; v < 4; ++v)
        for (int a = 0; a < 3; ++a) {
            const float x = (float)sample_corners[v][a];
            sample_number(&binary, &x, 4, 0);
        }
    for (int v = 0; v < 4; ++v) {
        const unsigned char colour[4] = { 255, (unsigned char)(51 * v), 0, 255 };
        sample_add(&binary, colour, 4);
    }
    for (int f = 0; f < 4; ++f)
        for (int k = 0; k < 3; ++k) {
            const unsigned char index = (unsigned char)sample_faces[f][k];
            sample_add(&binary, &index, 1);
        }
    return binary;
}

#define SAMPLE_GLB_ACCESSORS                                                                                           \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"                          \
    "{\"bufferView\":1,\"componentType\":5121,\"normalized\":true,\"count\":4,\"type\":\"VEC4\"},"                     \
    "{\"bufferView\":2,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}],"                                     \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,\"byteLength\":16},"            \
    "{\"buffer\":0,\"byteOffset\":64,\"byteLength\":12}],\"buffers\":[{\"byteLength\":76}]"

static inline mesh_sample sample_glb(const char *nodes)
{
    char json[2000];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":%s,\"meshes\":"
             "[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},\"indices\":2}]}]," SAMPLE_GLB_ACCESSORS
             "}",
             nodes);
    mesh_sample binary = sample_glb_binary(), sample = sample_glb_of(json, &binary);
    free(binary.bytes);
    return sample;
}

enum { SAMPLE_COUNT = 8 };
/* All samples; free each one's bytes. */
static inline void sample_all(mesh_sample samples[SAMPLE_COUNT])
{
    samples[0] = sample_obj();
    samples[1] = sample_off();
    samples[2] = sample_ply_ascii();
    samples[3] = sample_ply_binary(0);
    samples[4] = sample_ply_binary(1);
    samples[5] = sample_stl_ascii();
    samples[6] = sample_stl_binary();
    samples[7] = sample_glb("[{\"mesh\":0,\"scale\":[1,1,1]}]");
}

#endif
