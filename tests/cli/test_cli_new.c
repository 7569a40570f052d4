/* pith new for meshes: every texture type fills at once, every component has a core, paths are relative. */
#include "cli_run.h"

#include <jansson.h>

#include "pith/shape.h"

static json_t *read_json(const char *name)
{
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    json_t *root = json_load_file(path, 0, NULL);
    assert_non_null(root);
    return root;
}

/* With small exemplars, so that the test measures the documents and not the recipes. */
static void test_every_type_fills_at_once(void **state)
{
    (void)state;
    static const struct { const char *type; bool depth, direction, vectors, scale; } types[] = {
        { "0-A", false, false, false, true }, { "0-B", false, false, true, true }, { "0-C", true, true, false, true },
        { "1-A", true, false, false, false }, { "1-B", true, true, false, false },
    };
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        CHECK_RUN(0,
                  "build/pith new %s x.pith --force --type %s --tetrahedra 400 && sed -i 's/\"size\": \\[[0-9, "
                  "]*\\]/\"size\":"
                  " [16, 16, 16]/; s/\"density\": [0-9.]*/\"density\": 4/' x.pith && build/pith fill x.pith --json "
                  "--no-cache",
                  i % 2 ? "slab" : "data/meshes/patella.obj", types[i].type);
        json_t *report = json_loads(run_out, 0, NULL), *root = read_json("x.pith");
        CHECK_AT_LEAST(json_integer_value(json_object_get(json_object_get(report, "fill"), "patches")), 1);
        assert_int_equal(json_object_get(root, "depth") != NULL, types[i].depth);
        assert_int_equal(json_object_get(root, "direction") != NULL, types[i].direction);
        assert_int_equal(json_object_get(root, "vectors") != NULL, types[i].vectors);
        assert_int_equal(json_object_get(root, "scale") != NULL, types[i].scale);
        json_t *solid = json_array_get(json_object_get(root, "solids"), 0);
        assert_string_equal(json_string_value(json_object_get(solid, "type")), types[i].type);
        assert_null(json_object_get(json_object_get(solid, "exemplar"), "recipe")); /* it stands alone */
        json_decref(report);
        json_decref(root);
    }
}

static void append(pith_mesh_view *to, pith_vec3 *positions, uint32_t (*triangles)[3], double radius, double shift,
                   bool inward)
{
    pith_error err;
    pith_mesh *ball = NULL;
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = 2 * radius, options.radius_y = options.radius_z = radius;
    options.detail = 2;
    CHECK_OK(pith_mesh_fruit(&options, &ball, &err));
    const pith_mesh_view view = pith_mesh_look(ball);
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        positions[to->vertex_count + v] = pith_add(view.positions[v], pith_v3(0, shift, 0));
    for (uint32_t t = 0; t < view.triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            triangles[to->triangle_count + t][inward ? 2 - k : k] = to->vertex_count + view.triangles[t][k];
    to->vertex_count += view.vertex_count;
    to->triangle_count += view.triangle_count;
    pith_mesh_destroy(ball);
}

/* Two ellipsoids, one of them with a cavity off its axis: two cores, each inside its body and along x. */
static void test_every_component_has_a_core(void **state)
{
    (void)state;
    pith_vec3 *positions = pith_alloc(2000, sizeof *positions);
    uint32_t (*triangles)[3] = pith_alloc(4000, sizeof *triangles);
    pith_mesh_view view = { .positions = positions, .triangles = (const uint32_t (*)[3])triangles };
    append(&view, positions, triangles, 1, 0, false);
    append(&view, positions, triangles, 0.5, 3, false);
    append(&view, positions, triangles, 0.1, 0.7, true);
    pith_error err;
    pith_mesh *mesh = NULL;
    char path[300];
    snprintf(path, sizeof path, "%s/two.obj", run_folder);
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    CHECK_OK(pith_mesh_write(mesh, path, &err));
    pith_mesh_destroy(mesh);
    pith_free(positions);
    pith_free(triangles);
    CHECK_RUN(0, "build/pith new two.obj two.pith --tetrahedra 600 && build/pith validate two.pith");
    json_t *root = read_json("two.pith"), *constraints = json_object_get(json_object_get(root, "depth"), "constraints");
    assert_int_equal(json_array_size(constraints), 3); /* the skin, and two cores */
    assert_int_equal(json_array_size(json_object_get(json_object_get(root, "direction"), "strokes")), 2);
    for (size_t i = 0; i < 2; ++i)
        for (size_t end = 0; end < 2; ++end) {
            const json_t *at = json_array_get(json_object_get(json_array_get(constraints, 1 + i), "stroke"), end);
            const double size = i ? 0.5 : 1;
            CHECK_NEAR(fabs(json_number_value(json_array_get(at, 0))), 0.6 * 2 * size, 0.05 * size);
            CHECK_NEAR(json_number_value(json_array_get(at, 1)), i ? 3 : 0, 0.02);
        }
    json_decref(root);
    CHECK_RUN(0, "build/pith field two.pith --json"); /* depth and directions in both */
}

static void test_meshes_are_named_relatively(void **state)
{
    (void)state;
    static const char *const cases[][3] = {
        { "data/meshes/patella.obj", "p.pith", "data/meshes/patella.obj" },
        { "data/meshes/patella.obj", "deep/er/p.pith", "../../data/meshes/patella.obj" },
        { "./data/../data/meshes/patella.obj", "data/p.pith", "meshes/patella.obj" },
        { "data/meshes/patella.obj", "data/meshes/p.pith", "patella.obj" },
    };
    CHECK_RUN(0, "mkdir -p deep/er");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CHECK_RUN(0, "build/pith new %s %s && build/pith validate %s", cases[i][0], cases[i][1], cases[i][1]);
        json_t *root = read_json(cases[i][1]);
        assert_string_equal(json_string_value(json_object_get(json_object_get(root, "shape"), "mesh")), cases[i][2]);
        json_decref(root);
    }
}

static void test_templates_and_refusals(void **state)
{
    (void)state;
    static const char *const names[] = { "sponge", "tube", "muscle", "flattened", "bricks", "strata", "cake" };
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i)
        CHECK_RUN(0, "build/pith new %s t.pith --force && build/pith validate t.pith && ! grep -q '\"recipe\"' t.pith",
                  names[i]);
    static const char *const cases[][2] = {
        { "kiwi k.pith --type 0-A", "--type goes with a mesh" },
        { "slab k.pith --type 2-A", "type" },
        { "slab k.pith --size 3", "--size goes with types 0" },
        { "slab k.pith --type 0-A --size -1", "from 1e-09" },
        { "slabb k.pith", "neither a template nor a file" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        CHECK_RUN(2, "build/pith new %s", cases[i][0]);
        CHECK_SAYS(run_err, cases[i][1]);
    }
    CHECK_RUN(0, "build/pith new slab z.pith --type 0-A --size 0.25");
    json_t *root = read_json("z.pith"), *points = json_object_get(json_object_get(root, "scale"), "points");
    CHECK_NEAR(json_number_value(json_object_get(json_array_get(points, 0), "size")), 0.25, 0);
    json_decref(root);
}

/* A surface without an inside is told to be open, before anybody asks where its axis runs. */
static void test_open_surfaces_are_told_to_be_open(void **state)
{
    (void)state;
    CHECK_RUN(0, "printf 'v 0 0 0\\nv 1 0 0\\nv 0 1 0\\nf 1 2 3\\n' > tri.obj");
    for (int i = 0; i < 2; ++i) {
        CHECK_RUN(1, i ? "mkdir -p page && touch page/index.html && build/pith edit tri.obj --no-open --page page"
                       : "build/pith new tri.obj tri.pith");
        CHECK_SAYS(run_err, "tri.obj: the mesh is not closed");
        CHECK_SAYS(run_err, "3 boundary edges in 1 loop");
    }
    CHECK_RUN(1, "test -e tri.pith");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_type_fills_at_once), cmocka_unit_test(test_every_component_has_a_core),
        cmocka_unit_test(test_meshes_are_named_relatively), cmocka_unit_test(test_templates_and_refusals),
        cmocka_unit_test(test_open_surfaces_are_told_to_be_open),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
