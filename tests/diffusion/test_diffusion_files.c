/* Diffusion surfaces in files: there and back, files written by hand, and those that are wrong. */
#include "shapes.h"

#include "pith/diffusion_files.h"
#include "pith/shape_parts.h"

#include <sys/stat.h>
#include <unistd.h>

static char folder[] = "/tmp/pith-surfaces-XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[100];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static const char *in_folder(const char *name)
{
    static char path[200];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

/* ---- there and back ------------------------------------------------------------------------------------------------ */

static void some_colour(pith_vec3 p, const double *with, float colour[4])
{
    colour[0] = (float)(0.5 + 0.4 * sin(7.0 * p.x + with[0]));
    colour[1] = (float)(3.0 + p.y); /* more than a screen shows */
    colour[2] = (float)(-0.25 * p.z);
    colour[3] = (float)(0.5 + 0.5 * cos(3.0 * p.z));
}

static void check_floats(const float (*a)[4], const float (*b)[4], size_t count)
{
    assert_int_equal(a != NULL, b != NULL);
    if (a) assert_memory_equal(a, b, count * sizeof *a);
}

/* Positions and blur to `digits` relative, all else bit for bit. */
static void check_same(const pith_diffusion_surface *a, const pith_diffusion_surface *b, double digits)
{
    assert_int_equal(a->mesh.vertex_count, b->mesh.vertex_count);
    assert_int_equal(a->mesh.triangle_count, b->mesh.triangle_count);
    assert_memory_equal(a->mesh.triangles, b->mesh.triangles, a->mesh.triangle_count * sizeof *a->mesh.triangles);
    for (uint32_t v = 0; v < a->mesh.vertex_count; ++v) {
        CHECK_AT_MOST(pith_distance(a->mesh.positions[v], b->mesh.positions[v]),
                      digits * pith_length(a->mesh.positions[v]));
        if (a->blur) CHECK_NEAR(b->blur[v], a->blur[v], digits * a->blur[v]);
    }
    check_floats(a->front, b->front, a->mesh.vertex_count);
    check_floats(a->back, b->back, a->mesh.vertex_count);
    assert_int_equal(a->blur != NULL, b->blur != NULL);
    assert_int_equal(a->hide_front, b->hide_front);
    assert_int_equal(a->hide_back, b->hide_back);
    assert_int_equal(a->name != NULL, b->name != NULL);
    if (a->name) assert_string_equal(a->name, b->name);
}

static void test_there_and_back(void **state)
{
    (void)state;
    shape ball = make_ball(1.3, 2), patch = make_patch(3, 0.1), block = make_block(1.0, 0.7, 0.3, 2);
    shape *const all[3] = { &ball, &patch, &block };
    pith_diffusion_surface surfaces[3];
    for (int i = 0; i < 3; ++i) {
        shape_paint(all[i], all[i]->front, some_colour, (const double[1]){ i });
        shape_paint(all[i], all[i]->back, some_colour, (const double[1]){ i + 10.0 });
        const pith_mesh_view view = pith_mesh_look(all[i]->mesh);
        for (uint32_t v = 0; v < view.vertex_count; ++v) all[i]->blur[v] = 0.01 * fabs(view.positions[v].x) / 3.0;
        surfaces[i] = shape_surface(all[i]);
    }
    surfaces[0].name = "the skin of a plum \"Zwetschge\" \xc3\xa4";
    surfaces[0].blur = ball.blur;
    surfaces[0].hide_front = true;
    surfaces[1].front = NULL;
    surfaces[1].name = "sheet";
    surfaces[2].back = NULL;
    surfaces[2].blur = block.blur;
    surfaces[2].hide_back = true;

    pith_diffusion_surfaces *read = NULL;
    CHECK_OK(pith_diffusion_surfaces_write(surfaces, 3, in_folder("all.glb"), &err));
    CHECK_OK(pith_diffusion_surfaces_read(in_folder("all.glb"), &read, &err));
    pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    assert_int_equal(view.count, 3);
    for (int i = 0; i < 3; ++i) check_same(&surfaces[i], &view.surfaces[i], 1.2e-7);
    assert_true(view.found[0].front && view.found[0].back && view.found[0].blur && view.found[0].colours);
    assert_true(!view.found[1].front && view.found[1].back && !view.found[1].blur);
    CHECK_OK(pith_diffusion_surfaces_coloured(read, &err));
    pith_diffusion *diffusion = make_diffusion(view.surfaces, view.count);
    pith_diffusion_destroy(diffusion);
    pith_diffusion_surfaces_destroy(read);

    for (int i = 0; i < 3; ++i) {
        CHECK_OK(pith_diffusion_surfaces_write(&surfaces[i], 1, in_folder("one.ply"), &err));
        CHECK_OK(pith_diffusion_surfaces_read(in_folder("one.ply"), &read, &err));
        view = pith_diffusion_surfaces_look(read);
        assert_int_equal(view.count, 1);
        check_same(&surfaces[i], view.surfaces, 0.0);
        pith_diffusion_surfaces_destroy(read);
    }
    for (int i = 0; i < 3; ++i) shape_free(all[i]);
}

static size_t size_of(const char *path)
{
    struct stat found;
    assert_int_equal(stat(path, &found), 0);
    return (size_t)found.st_size;
}

/* A number less a vertex, and the same colours again. */
static void test_opaque_colours_are_written_without_opacity(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 3);
    const size_t count = pith_mesh_look(ball.mesh).vertex_count;
    pith_diffusion_surface surface = shape_surface(&ball);
    static const char *const names[2] = { "opaque.glb", "opaque.ply" };
    for (int format = 0; format < 2; ++format) {
        size_t sizes[2];
        for (int opaque = 0; opaque < 2; ++opaque) {
            shape_paint(&ball, ball.front, plain_colour, (const double[4]){ 0.25, 0.5, 2, opaque ? 1 : 0.5 });
            shape_paint(&ball, ball.back, plain_colour, (const double[4]){ 0.75, 0, 0.125, 1 });
            pith_diffusion_surfaces *read = NULL;
            CHECK_OK(pith_diffusion_surfaces_write(&surface, 1, in_folder(names[format]), &err));
            CHECK_OK(pith_diffusion_surfaces_read(in_folder(names[format]), &read, &err));
            check_same(&surface, pith_diffusion_surfaces_look(read).surfaces, 1.2e-7);
            pith_diffusion_surfaces_destroy(read);
            sizes[opaque] = size_of(in_folder(names[format]));
        }
        CHECK_NEAR(sizes[0] - sizes[1], 4.0 * (double)count, 64.0); /* the head differs by some words, too */
    }
    shape_free(&ball);
}

/* Any program shows the side that is seen. */
static void test_others_see_vertex_colours(void **state)
{
    (void)state;
    shape ball = make_ball(1.0, 1);
    shape_paint(&ball, ball.front, plain_colour, (const double[4]){ 0.25, 0.5, 2, 1 });
    shape_paint(&ball, ball.back, plain_colour, (const double[4]){ 0.75, 0, 0.125, 0.5 });
    pith_diffusion_surface surface = shape_surface(&ball);
    static const char *const names[2] = { "seen.glb", "seen.ply" };
    for (int hidden = 0; hidden < 2; ++hidden)
        for (int format = 0; format < 2; ++format) {
            surface.hide_front = hidden;
            const float expected[2][4] = { { 0.25f, 0.5f, 1.0f, 1.0f }, { 0.75f, 0.0f, 0.125f, 0.5f } };
            pith_mesh *mesh = NULL;
            CHECK_OK(pith_diffusion_surfaces_write(&surface, 1, in_folder(names[format]), &err));
            CHECK_OK(pith_mesh_read(in_folder(names[format]), &mesh, &err));
            for (int k = 0; k < 4; ++k)
                CHECK_NEAR(pith_mesh_look(mesh).colours[3][k], expected[hidden][k], format ? 0.005 : 0.0);
            pith_mesh_destroy(mesh);
        }
    shape_free(&ball);
}

static void test_what_cannot_be_written(void **state)
{
    (void)state;
    shape patch = make_patch(1, 0.0);
    pith_diffusion_surface two[2] = { shape_surface(&patch), shape_surface(&patch) };
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 2, in_folder("x.ply"), &err), PITH_BAD_ARGUMENT, "holds one mesh");
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 2, in_folder("x.obj"), &err), PITH_BAD_ARGUMENT, ".glb or .ply");
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 0, in_folder("x.glb"), &err), PITH_BAD_ARGUMENT, "no mesh");
    two[0].name = "two\nlines";
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 2, in_folder("x.glb"), &err), PITH_BAD_ARGUMENT, "control");
    two[0].name = "\xff\xfe";
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 2, in_folder("x.glb"), &err), PITH_BAD_ARGUMENT, "UTF-8");
    two[0].name = "leaf";
    patch.front[2][1] = NAN;
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 1, in_folder("x.glb"), &err), PITH_BAD_ARGUMENT,
                "\"leaf\": the front");
    two[0].front = two[0].back = NULL;
    CHECK_FAILS(pith_diffusion_surfaces_write(two, 1, in_folder("x.ply"), &err), PITH_BAD_ARGUMENT, "no colour");
    assert_int_not_equal(access(in_folder("x.glb"), F_OK), 0);
    shape_free(&patch);
}

/* ---- by hand --------------------------------------------------------------------------------------------------------- */

static pith_diffusion_surfaces *parse_text(const char *format, const char *text)
{
    pith_diffusion_surfaces *made = NULL;
    CHECK_OK(pith_diffusion_surfaces_parse("sample", format, text, strlen(text), &made, &err));
    return made;
}

static void refuses(const char *format, const char *text, const char *words)
{
    pith_diffusion_surfaces *made = NULL;
    CHECK_FAILS(pith_diffusion_surfaces_parse("sample", format, text, strlen(text), &made, &err), PITH_BAD_FILE, words);
    assert_null(made);
}

#define PLY_OF(comments, properties, a, b, c)                                                                          \
    "ply\nformat ascii 1.0\n" comments                                                                                 \
    "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n" properties                              \
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 " a "\n1 0 0 " b "\n0 1 0 " c           \
    "\n3 0 1 2\n"
#define SIDE_OF(side, type)                                                                                            \
    "property " type " " side "_red\nproperty " type " " side "_green\nproperty " type " " side                        \
    "_blue\nproperty " type " " side "_alpha\n"

static void test_ply_by_hand(void **state)
{
    (void)state;
    pith_diffusion_surfaces *read =
        parse_text("ply", PLY_OF("comment from another program\ncomment pith hide_back\ncomment pith name a  leaf\n",
                                 "property double blur\n" SIDE_OF("front", "float"), "0.1 1 0.5 0 1", "0 2 0 0 0.5",
                                 "0.2 0 0 -1 0"));
    const pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    const pith_diffusion_surface *leaf = view.surfaces;
    assert_int_equal(view.count, 1);
    assert_string_equal(leaf->name, "a  leaf");
    assert_true(leaf->hide_back && !leaf->hide_front && leaf->front && !leaf->back);
    assert_true(leaf->blur[0] == 0.1 && leaf->blur[1] == 0.0 && leaf->blur[2] == 0.2);
    const float expected[3][4] = { { 1, 0.5f, 0, 1 }, { 2, 0, 0, 0.5f }, { 0, 0, -1, 0 } };
    assert_memory_equal(leaf->front, expected, sizeof expected);
    assert_true(view.found[0].front && !view.found[0].back && view.found[0].blur && !view.found[0].colours);
    pith_diffusion_surfaces_destroy(read);
}

static void test_vertex_colours_are_both_sides(void **state)
{
    (void)state;
    pith_diffusion_surfaces *read = parse_text("obj", "v 0 0 0 1 0 0\nv 1 0 0 1 0 0\nv 0 1 0 0 1 0\nf 1 2 3\n");
    pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    assert_true(view.found[0].colours && !view.found[0].front && view.surfaces[0].front && !view.surfaces[0].back);
    assert_true(view.surfaces[0].front[0][0] == 1.0f && view.surfaces[0].front[2][1] == 1.0f);
    CHECK_OK(pith_diffusion_surfaces_coloured(read, &err));
    pith_diffusion_surfaces_destroy(read);

    read = parse_text("obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    view = pith_diffusion_surfaces_look(read);
    assert_true(!view.found[0].colours && !view.surfaces[0].front && !view.surfaces[0].back);
    CHECK_FAILS(pith_diffusion_surfaces_coloured(read, &err), PITH_BAD_FILE, "_FRONT and _BACK");
    pith_diffusion *none = NULL;
    CHECK_FAILS(pith_diffusion_create(view.surfaces, 1, &none, &err), PITH_BAD_ARGUMENT, "no colour");
    pith_diffusion_surfaces_destroy(read);
}

/* A square of two triangles that share no vertex in the file: one edge inside, four outside. */
static void test_seams_are_joined(void **state)
{
    (void)state;
    pith_diffusion_surfaces *read = parse_text(
        "stl", "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n"
               "facet normal 0 0 1\nouter loop\nvertex -0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\n");
    const pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    const uint32_t expected[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    assert_int_equal(view.surfaces[0].mesh.vertex_count, 4);
    assert_memory_equal(view.surfaces[0].mesh.triangles, expected, sizeof expected);
    pith_diffusion_surfaces_destroy(read);

    /* With normals that differ along a seam; colours that do keep it. */
#define SEAM(last)                                                                                                     \
    "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nproperty float "   \
    "nx\n"                                                                                                             \
    "property float ny\nproperty float nz\nproperty float blur\n" SIDE_OF(                                             \
        "back",                                                                                                        \
        "float") "element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0 0 0 1 .1 1 0 0 1\n"        \
                 "1 0 0 0 0 1 .2 1 0 0 1\n1 1 0 0 0 1 .3 1 0 0 1\n1 1 0 0 1 0 .3 1 0 0 1\n0 1 0 0 1 0 .4 1 0 0 1\n"    \
                 "0 0 0 0 1 0 " last "\n3 0 1 2\n3 3 4 5\n"
    read = parse_text("ply", SEAM(".1 1 0 0 1"));
    assert_int_equal(pith_diffusion_surfaces_look(read).surfaces[0].mesh.vertex_count, 4);
    assert_true(fabs(pith_diffusion_surfaces_look(read).surfaces[0].blur[3] - 0.4) < 1e-6);
    pith_diffusion_surfaces_destroy(read);
    read = parse_text("ply", SEAM(".1 0 1 0 1"));
    assert_int_equal(pith_diffusion_surfaces_look(read).surfaces[0].mesh.vertex_count, 5);
    pith_diffusion_surfaces_destroy(read);
}

static void test_wrong_ply(void **state)
{
    (void)state;
#define FRONT_ONLY SIDE_OF("front", "float")
    refuses("ply", PLY_OF("", FRONT_ONLY, "1 1 1 nan", "1 1 1 1", "1 1 1 1"), "surface 0: the front of vertex 0");
    refuses("ply", PLY_OF("", FRONT_ONLY, "1 1 1 1", "1 1 1 1.5", "1 1 1 1"), "an opacity of 0 to 1");
    refuses("ply", PLY_OF("", FRONT_ONLY, "1 1 1 1", "1 1 1 1", "inf 1 1 1"), "the front of vertex 2");
    refuses("ply", PLY_OF("comment pith name rind\n", SIDE_OF("back", "uchar"), "1 1 1 1", "1 1 1 1", "1 1 1 1"),
            "surface \"rind\": back_red must be");
    refuses("ply",
            PLY_OF("", "property float front_red\nproperty float front_green\nproperty float front_alpha\n", "1 1 1",
                   "1 1 1", "1 1 1"),
            "front_blue is missing");
    refuses("ply", PLY_OF("", "property float blur\n", "0", "-0.1", "0"), "blur of vertex 1 is -0.1");
    refuses("ply", PLY_OF("", "property float blur\n", "0", "0", "nan"), "blur of vertex 2 is nan");
    refuses("ply", PLY_OF("", "property int blur\n", "0", "0", "0"), "blur must be 1 floating-point number");
    refuses("ply", PLY_OF("", "property float blur\nproperty double blur\n", "0 0", "0 0", "0 0"), "given twice");
    refuses("ply", PLY_OF("", FRONT_ONLY, "1 1 1 1", "1 1 1 x", "1 1 1 1"), "expected a number");
    refuses("ply", PLY_OF("comment pith hide_front\ncomment pith hide_back\n", "", "", "", ""),
            "both its sides hidden");
    refuses("ply", "ply\nformat ascii 1.0\n", "end_header");
}

/* A GLB with this JSON and a chunk of floats. */
static void make_glb(const char *json, const float *floats, uint32_t count, unsigned char *bytes, size_t *size)
{
    uint32_t length = (uint32_t)strlen(json);
    const uint32_t padded = (length + 3) / 4 * 4, binary = 4 * count, total = 12 + 8 + padded + 8 + binary;
    const uint32_t head[5] = { 0x46546C67, 2, total, padded, 0x4E4F534A }, chunk[2] = { binary, 0x004E4942 };
    memcpy(bytes, head, sizeof head);
    memset(bytes + 20, ' ', padded);
    memcpy(bytes + 20, json, length);
    memcpy(bytes + 20 + padded, chunk, sizeof chunk);
    memcpy(bytes + 28 + padded, floats, binary);
    *size = total;
}

/* Positions of a triangle, a front of red, green, blue, and a blur; attributes and what else by the caller. */
static void hand_glb(const char *attributes, const char *mesh, const char *node, const char *type,
                     const char *component, const char *count, float blur, unsigned char *bytes, size_t *size)
{
    const float floats[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 0.5f, 0.1f, 0.2f, blur };
    char json[3000];
    snprintf(json, sizeof json,
             "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0%s}],"
             "\"meshes\":[{\"name\":\"of the mesh\",\"primitives\":[{\"attributes\":{\"POSITION\":0%s}}]%s}],"
             "\"buffers\":[{\"byteLength\":96}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
             "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":84,\"byteLength\":12}],"
             "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
             "{\"bufferView\":1,\"componentType\":%s,\"count\":%s,\"type\":\"%s\"},"
             "{\"bufferView\":2,\"componentType\":5126,\"count\":3,\"type\":\"SCALAR\"}]}",
             node, attributes, mesh, component, count, type);
    make_glb(json, floats, sizeof floats / sizeof *floats, bytes, size);
}

static void refuses_glb(const char *attributes, const char *mesh, const char *type, const char *component,
                        const char *count, float blur, const char *words)
{
    unsigned char bytes[4000];
    size_t size;
    pith_diffusion_surfaces *made = NULL;
    hand_glb(attributes, mesh, "", type, component, count, blur, bytes, &size);
    CHECK_FAILS(pith_diffusion_surfaces_parse("sample", "glb", bytes, size, &made, &err), PITH_BAD_FILE, words);
    assert_null(made);
}

static void test_glb_by_hand(void **state)
{
    (void)state;
    unsigned char bytes[4000];
    size_t size;
    pith_diffusion_surfaces *read = NULL;
    hand_glb(",\"_FRONT\":1,\"_BLUR\":2,\"_OTHER\":2",
             ",\"extras\":{\"pith\":{\"hide_back\":true,\"hide_front\":false}}",
             ",\"scale\":[2,2,2],\"translation\":[0,0,5]", "VEC4", "5126", "3", 0.3f, bytes, &size);
    CHECK_OK(pith_diffusion_surfaces_parse("sample", "glb", bytes, size, &read, &err));
    const pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    const pith_diffusion_surface *surface = view.surfaces;
    assert_string_equal(surface->name, "of the mesh");
    assert_true(surface->hide_back && !surface->hide_front && !surface->back);
    const float expected[3][4] = { { 1, 0, 0, 1 }, { 0, 1, 0, 1 }, { 0, 0, 1, 0.5f } };
    assert_memory_equal(surface->front, expected, sizeof expected);
    CHECK_NEAR(surface->mesh.positions[1].x, 2.0, 1e-12);
    CHECK_NEAR(surface->mesh.positions[1].z, 5.0, 1e-12);
    CHECK_NEAR(surface->blur[2], 0.6, 1e-7); /* scaled as the mesh is */
    pith_diffusion_surfaces_destroy(read);

    hand_glb(",\"_BACK\":1", "", "", "VEC3", "5126", "3", 0.3f, bytes, &size);
    CHECK_OK(pith_diffusion_surfaces_parse("sample", "glb", bytes, size, &read, &err));
    const float opaque[3][4] = { { 1, 0, 0, 1 }, { 1, 0, 1, 1 }, { 0, 1, 0, 1 } };
    assert_memory_equal(pith_diffusion_surfaces_look(read).surfaces->back, opaque, sizeof opaque);
    pith_diffusion_surfaces_destroy(read);
}

static void test_wrong_glb(void **state)
{
    (void)state;
    refuses_glb(",\"_FRONT\":1", "", "VEC2", "5126", "3", 0, "_FRONT must be 3 or 4 floating-point numbers");
    refuses_glb(",\"_FRONT\":1", "", "VEC4", "5121", "3", 0, "_FRONT must be 3 or 4 floating-point numbers");
    refuses_glb(",\"_FRONT\":1", "", "VEC4", "5126", "2", 0, "_FRONT has 2 elements for 3 vertices");
    refuses_glb(",\"_FRONT\":1", "", "VEC4", "5126", "30", 0, "reaches beyond");
    refuses_glb(",\"_FRONT\":7", "", "VEC4", "5126", "3", 0, "accessor 7 does not exist");
    refuses_glb(",\"_FRONT\":\"1\"", "", "VEC4", "5126", "3", 0, "_FRONT is no accessor");
    refuses_glb(",\"_BLUR\":0", "", "VEC4", "5126", "3", 0, "_BLUR must be 1 floating-point number");
    refuses_glb(",\"_BLUR\":2", "", "VEC4", "5126", "3", -1, "\"of the mesh\": the blur of vertex 2 is -1");
    refuses_glb(",\"_BLUR\":2", "", "VEC4", "5126", "3", NAN, "the blur of vertex 2 is");
    refuses_glb("", ",\"extras\":{\"pith\":{\"hide_back\":\"yes\"}}", "VEC4", "5126", "3", 0, "must be true or false");
    refuses_glb("", ",\"extras\":{\"pith\":{\"hide_back\":true,\"hide_front\":true}}", "VEC4", "5126", "3", 0,
                "both its sides hidden");
}

/* Every length of a file that is cut off: a sentence or a result, nothing else; and no memory at every point. */
static void test_cut_off_and_without_memory(void **state)
{
    (void)state;
    unsigned char bytes[4000];
    size_t size;
    hand_glb(",\"_FRONT\":1,\"_BLUR\":2", ",\"extras\":{\"pith\":{\"hide_back\":true}}", "", "VEC4", "5126", "3", 0.3f,
             bytes, &size);
    pith_diffusion_surfaces *read = NULL;
    for (size_t length = 0; length < size; ++length)
        CHECK_FAILS(pith_diffusion_surfaces_parse("sample", "glb", bytes, length, &read, &err), PITH_BAD_FILE,
                    "sample");
    size_t tries = 0;
    for (;; ++tries) {
        pith_memory_fail_after(tries);
        const pith_status status = pith_diffusion_surfaces_parse("sample", "glb", bytes, size, &read, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    CHECK_AT_LEAST((double)tries, 10);
    const pith_diffusion_surfaces_view view = pith_diffusion_surfaces_look(read);
    for (tries = 0;; ++tries) {
        pith_memory_fail_after(tries);
        const pith_status status =
            pith_diffusion_surfaces_write(view.surfaces, view.count, in_folder("memory.ply"), &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
    }
    pith_diffusion_surfaces_destroy(read);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_opaque_colours_are_written_without_opacity),
        cmocka_unit_test(test_others_see_vertex_colours),
        cmocka_unit_test(test_what_cannot_be_written),
        cmocka_unit_test(test_ply_by_hand),
        cmocka_unit_test(test_vertex_colours_are_both_sides),
        cmocka_unit_test(test_seams_are_joined),
        cmocka_unit_test(test_wrong_ply),
        cmocka_unit_test(test_glb_by_hand),
        cmocka_unit_test(test_wrong_glb),
        cmocka_unit_test(test_cut_off_and_without_memory),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
