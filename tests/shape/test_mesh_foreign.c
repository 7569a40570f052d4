/* The meshes we write, read by a library that is not ours (assimp): counts, places, normals, colours, coordinates. */
#include "check.h"
#include "pith/shape.h"

#include <assimp/cimport.h>
#include <assimp/scene.h>
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

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_ply), cmocka_unit_test(test_obj),
                                        cmocka_unit_test(test_glb), cmocka_unit_test(test_glb_of_lines) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
