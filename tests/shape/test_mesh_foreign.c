/* The meshes we write, read by a library that is not ours (assimp): counts, places, normals, colours, coordinates. */
#include "check.h"
#include "pith/shape.h"

#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <sys/stat.h>
#include <unistd.h>

static pith_error err;

/* A dented fruit with every attribute; colours and coordinates are functions of the place, so that a reader may reorder
   vertices as it likes. */
static void colour_at(pith_vec3 p, float colour[4])
{
    colour[0] = (float)(0.5 + 0.4 * p.x);
    colour[1] = (float)(0.5 + 0.4 * p.y);
    colour[2] = (float)(0.5 + 0.4 * p.z);
    colour[3] = 1.0f;
}

static pith_mesh *make_mesh(void)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.detail = 3;
    options.dent = 0.3;
    pith_mesh *fruit = NULL, *mesh = NULL;
    CHECK_OK(pith_mesh_fruit(&options, &fruit, &err));
    pith_mesh_view view = pith_mesh_look(fruit);
    pith_vec3 *normals = malloc(view.vertex_count * sizeof *normals);
    float(*colours)[4] = malloc(view.vertex_count * sizeof *colours);
    float(*texcoords)[2] = malloc(view.vertex_count * sizeof *texcoords);
    pith_mesh_vertex_normals(&view, normals);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        colour_at(view.positions[v], colours[v]);
        texcoords[v][0] = (float)view.positions[v].x;
        texcoords[v][1] = (float)view.positions[v].z;
    }
    view.normals = normals;
    view.colours = (const float(*)[4])colours;
    view.texcoords = (const float(*)[2])texcoords;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(normals);
    free(colours);
    free(texcoords);
    pith_mesh_destroy(fruit);
    return mesh;
}

static double encode(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static pith_vec3 from_ai(struct aiVector3D v) { return pith_v3((double)v.x, (double)v.y, (double)v.z); }

/* Reads the file with assimp and compares; `encoded` when the format carries sRGB colours. */
static void check_foreign(const char *extension, bool encoded)
{
    pith_mesh *mesh = make_mesh();
    const pith_mesh_view view = pith_mesh_look(mesh);
    char path[400];
    snprintf(path, sizeof path, "%s/foreign_%ld.%s", PITH_BINARY_DIR, (long)getpid(), extension);
    CHECK_OK(pith_mesh_write(mesh, path, &err));
    const struct aiScene *scene = aiImportFile(path, 0);
    if (!scene) fail_msg("%s: %s", path, aiGetErrorString());
    CHECK_NEAR(scene->mNumMeshes, 1, 0);
    const struct aiMesh *read = scene->mMeshes[0];
    CHECK_NEAR(read->mNumFaces, view.triangle_count, 0);
    double volume6 = 0.0, worst_normal = 0.0;
    for (unsigned f = 0; f < read->mNumFaces; ++f) {
        CHECK_NEAR(read->mFaces[f].mNumIndices, 3, 0);
        pith_vec3 p[3];
        for (int k = 0; k < 3; ++k) {
            const unsigned v = read->mFaces[f].mIndices[k];
            const uint32_t own = view.triangles[f][k]; /* triangles keep their order and first corner */
            p[k] = from_ai(read->mVertices[v]);
            CHECK_NEAR(pith_distance(p[k], view.positions[own]), 0.0, 1e-6);
            worst_normal = fmax(worst_normal, pith_distance(from_ai(read->mNormals[v]), view.normals[own]));
            CHECK_NEAR((double)read->mTextureCoords[0][v].x, (double)view.texcoords[own][0], 1e-6);
            CHECK_NEAR((double)read->mTextureCoords[0][v].y, (double)view.texcoords[own][1], 1e-6);
            const struct aiColor4D c = read->mColors[0][v];
            const float got[3] = { c.r, c.g, c.b };
            for (int k2 = 0; k2 < 3; ++k2) {
                const double linear = (double)view.colours[own][k2];
                CHECK_NEAR((double)got[k2], encoded ? encode(linear) : linear, encoded ? 0.5 / 255 + 1e-6 : 1e-6);
            }
        }
        volume6 += pith_dot(p[0], pith_cross(p[1], p[2]));
    }
    CHECK_AT_MOST(worst_normal, 1e-6);
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    CHECK_NEAR(volume6 / 6.0, report.volume, 1e-5);
    aiReleaseImport(scene);
    remove(path);
    pith_mesh_destroy(mesh);
}

static void test_ply(void **state)
{
    (void)state;
    check_foreign("ply", true);
}
static void test_obj(void **state)
{
    (void)state;
    check_foreign("obj", true);
}
static void test_glb(void **state)
{
    (void)state;
    check_foreign("glb", false);
}

/* Lines: each a mesh of segments in assimp's eyes. */
static void test_glb_of_lines(void **state)
{
    (void)state;
    const pith_vec3 points[] = { { 0, 0, 0 }, { 1, 0.5, 0.25 }, { 2, 0, 1 }, { 3, 3, 3 }, { 3, 4, 3 } };
    const uint32_t starts[] = { 0, 3, 5 };
    const float colours[][3] = { { 1.0f, 0.5f, 0.0f }, { 0.25f, 0.0f, 1.0f } };
    pith_polylines *lines = NULL;
    CHECK_OK(pith_polylines_create(&(pith_polylines_view){ points, starts, 2 }, &lines, &err));
    char path[400];
    snprintf(path, sizeof path, "%s/foreign_lines_%ld.glb", PITH_BINARY_DIR, (long)getpid());
    CHECK_OK(pith_polylines_write(lines, colours, path, &err));
    const struct aiScene *scene = aiImportFile(path, 0);
    if (!scene) fail_msg("%s: %s", path, aiGetErrorString());
    CHECK_NEAR(scene->mNumMeshes, 2, 0);
    for (unsigned line = 0; line < 2; ++line) {
        const struct aiMesh *read = scene->mMeshes[line];
        CHECK_NEAR(read->mPrimitiveTypes, aiPrimitiveType_LINE, 0);
        CHECK_NEAR(read->mNumFaces, starts[line + 1] - starts[line] - 1, 0);
        for (unsigned f = 0; f < read->mNumFaces; ++f)
            for (unsigned k = 0; k < 2; ++k) {
                CHECK_NEAR(read->mFaces[f].mNumIndices, 2, 0);
                const unsigned v = read->mFaces[f].mIndices[k];
                CHECK_NEAR(pith_distance(from_ai(read->mVertices[v]), points[starts[line] + f + k]), 0.0, 1e-6);
                const struct aiColor4D c = read->mColors[0][v];
                CHECK_NEAR((double)c.r, (double)colours[line][0], 1e-6);
                CHECK_NEAR((double)c.g, (double)colours[line][1], 1e-6);
                CHECK_NEAR((double)c.b, (double)colours[line][2], 1e-6);
            }
    }
    aiReleaseImport(scene);
    remove(path);
    pith_polylines_destroy(lines);
}

/* ---- meshes with a picture --------------------------------------------------------------------------------------- */

/* One grey pixel. */
static const unsigned char picture[] = {
    0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n', 0, 0, 0, 13, 'I', 'H', 'D', 'R', 0, 0, 0, 1, 0, 0, 0, 1, 8, 0, 0, 0, 0,
    0x3a, 0x7e, 0x9b, 0x55, 0, 0, 0, 10, 'I', 'D', 'A', 'T', 0x78, 0x9c, 0x63, 0x68, 0, 0, 0, 0x82, 0, 0x81, 0x77, 0xcd,
    0x72, 0xb6, 0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xae, 0x42, 0x60, 0x82,
};

static void path_of(char path[400], const char *extension)
{
    snprintf(path, 400, "%s/foreign_textured_%ld.%s", PITH_BINARY_DIR, (long)getpid(), extension);
}

static void check_coordinates(const struct aiMesh *read, const pith_mesh *mesh)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    CHECK_NEAR(read->mNumFaces, view.triangle_count, 0);
    assert_non_null(read->mTextureCoords[0]);
    for (unsigned f = 0; f < read->mNumFaces; ++f)
        for (int k = 0; k < 3; ++k) {
            const unsigned v = read->mFaces[f].mIndices[k];
            const uint32_t own = view.triangles[f][k];
            CHECK_NEAR(pith_distance(from_ai(read->mVertices[v]), view.positions[own]), 0.0, 1e-6);
            CHECK_NEAR((double)read->mTextureCoords[0][v].x, (double)view.texcoords[own][0], 1e-6);
            CHECK_NEAR((double)read->mTextureCoords[0][v].y, (double)view.texcoords[own][1], 1e-6);
        }
}

static void test_a_picture_inside_glb(void **state)
{
    (void)state;
    pith_mesh *mesh = make_mesh(), *back = NULL;
    const pith_texture texture = { picture, sizeof picture, 0.25, false };
    char path[400];
    path_of(path, "glb");
    CHECK_OK(pith_mesh_write_textured(mesh, &texture, path, &err));
    const struct aiScene *scene = aiImportFile(path, 0);
    if (!scene) fail_msg("%s: %s", path, aiGetErrorString());
    CHECK_NEAR(scene->mNumMeshes, 1, 0);
    check_coordinates(scene->mMeshes[0], mesh);
    CHECK_NEAR(scene->mNumTextures, 1, 0);
    CHECK_NEAR(scene->mTextures[0]->mHeight, 0, 0); /* a file, not pixels */
    CHECK_NEAR(scene->mTextures[0]->mWidth, sizeof picture, 0);
    assert_memory_equal(scene->mTextures[0]->pcData, picture, sizeof picture);
    assert_string_equal(scene->mTextures[0]->achFormatHint, "png");
    const struct aiMaterial *material = scene->mMaterials[scene->mMeshes[0]->mMaterialIndex];
    struct aiString name;
    assert_int_equal(aiGetMaterialString(material, AI_MATKEY_TEXTURE(aiTextureType_DIFFUSE, 0), &name), aiReturn_SUCCESS);
    assert_string_equal(name.data, "*0");
    ai_real roughness = NAN, metal = NAN;
    assert_int_equal(aiGetMaterialFloat(material, AI_MATKEY_ROUGHNESS_FACTOR, &roughness), aiReturn_SUCCESS);
    assert_int_equal(aiGetMaterialFloat(material, AI_MATKEY_METALLIC_FACTOR, &metal), aiReturn_SUCCESS);
    CHECK_NEAR((double)roughness, 0.25, 1e-6);
    CHECK_NEAR((double)metal, 0.0, 0);
    aiReleaseImport(scene);
    CHECK_OK(pith_mesh_read(path, &back, &err)); /* our own reader passes the picture over */
    CHECK_NEAR(pith_mesh_look(back).triangle_count, pith_mesh_look(mesh).triangle_count, 0);
    assert_non_null(pith_mesh_look(back).texcoords);
    pith_mesh_destroy(back);
    pith_mesh_destroy(mesh);
    remove(path);
}

static void test_a_picture_beside_obj(void **state)
{
    (void)state;
    pith_mesh *mesh = make_mesh();
    const pith_texture texture = { picture, sizeof picture, 0.25, true };
    char path[400], beside[400];
    path_of(path, "obj");
    CHECK_OK(pith_mesh_write_textured(mesh, &texture, path, &err));
    const struct aiScene *scene = aiImportFile(path, 0);
    if (!scene) fail_msg("%s: %s", path, aiGetErrorString());
    CHECK_NEAR(scene->mNumMeshes, 1, 0);
    check_coordinates(scene->mMeshes[0], mesh);
    const struct aiMaterial *material = scene->mMaterials[scene->mMeshes[0]->mMaterialIndex];
    struct aiString name;
    path_of(beside, "png");
    assert_int_equal(aiGetMaterialString(material, AI_MATKEY_TEXTURE(aiTextureType_DIFFUSE, 0), &name), aiReturn_SUCCESS);
    assert_string_equal(name.data, strrchr(beside, '/') + 1);
    assert_int_equal(aiGetMaterialString(material, AI_MATKEY_TEXTURE(aiTextureType_OPACITY, 0), &name), aiReturn_SUCCESS);
    assert_string_equal(name.data, strrchr(beside, '/') + 1);
    aiReleaseImport(scene);
    unsigned char *bytes;
    size_t size;
    CHECK_OK(pith_file_read(beside, &bytes, &size, &err));
    CHECK_NEAR((double)size, sizeof picture, 0);
    assert_memory_equal(bytes, picture, sizeof picture);
    pith_free(bytes);
    pith_mesh_destroy(mesh);
    const char *const written[] = { "obj", "mtl", "png" };
    for (int i = 0; i < 3; ++i) {
        path_of(path, written[i]);
        assert_int_equal(remove(path), 0);
    }
}

static void test_of_three_files_all_are_written_or_none(void **state)
{
    (void)state;
    pith_mesh *mesh = make_mesh();
    const pith_texture texture = { picture, sizeof picture, 0.6, false };
    char path[400], other[400];
    const char *const written[] = { "obj", "mtl", "png" };
    for (int i = 0; i < 3; ++i) { /* a folder is in the way of one of them */
        path_of(other, written[i]);
        assert_int_equal(mkdir(other, 0777), 0);
        path_of(path, "obj");
        CHECK_FAILS(pith_mesh_write_textured(mesh, &texture, path, &err), PITH_IO, written[i]);
        for (int k = 0; k < 3; ++k) {
            path_of(other, written[k]);
            assert_false(pith_file_exists(other));
            snprintf(other + strlen(other), 40, ".%ld.part", (long)getpid());
            assert_false(pith_file_exists(other));
        }
        path_of(other, written[i]);
        assert_int_equal(rmdir(other), 0);
    }
    pith_mesh_view bare = pith_mesh_look(mesh);
    bare.texcoords = NULL;
    pith_mesh *without = NULL;
    CHECK_OK(pith_mesh_create(&bare, &without, &err));
    path_of(path, "glb");
    CHECK_FAILS(pith_mesh_write_textured(without, &texture, path, &err), PITH_BAD_ARGUMENT, "no texture coordinates");
    CHECK_FAILS(pith_mesh_write_textured(mesh, NULL, path, &err), PITH_BAD_ARGUMENT, "no picture");
    path_of(path, "ply");
    CHECK_FAILS(pith_mesh_write_textured(mesh, &texture, path, &err), PITH_BAD_ARGUMENT, ".glb or .obj only");
    pith_mesh_destroy(without);
    pith_mesh_destroy(mesh);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_ply),
        cmocka_unit_test(test_obj),
        cmocka_unit_test(test_glb),
        cmocka_unit_test(test_glb_of_lines),
        cmocka_unit_test(test_a_picture_inside_glb),
        cmocka_unit_test(test_a_picture_beside_obj),
        cmocka_unit_test(test_of_three_files_all_are_written_or_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
