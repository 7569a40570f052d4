/* Computed solids in pictures from afar: one sample a pixel with the footprint that the ray tracer gives, against
   hundreds of the same solid asked without. */
#include "check.h"
#include "pith/procedural.h"
#include "pith/render.h"
#include "pith/solid_kind.h"

static pith_error err;

/* The same solid, asked without footprints. */
typedef struct bare_solid {
    pith_solid base;
    const pith_solid *inner;
} bare_solid;

static void bare_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    pith_query plain = *query;
    plain.footprints = NULL;
    pith_error none;
    (void)pith_solid_sample(((const bare_solid *)solid)->inner, &plain, out, &none);
}
static void bare_destroy(pith_solid *solid) { (void)solid; }
static const pith_solid_class bare_class = { "bare", bare_sample, bare_destroy };

/* A square in the plane z = 0, from -half to half. */
static pith_mesh *plane_mesh(double half)
{
    const pith_vec3 corners[4] = { { -half, -half, 0 }, { half, -half, 0 }, { half, half, 0 }, { -half, half, 0 } };
    const uint32_t triangles[2][3] = { { 0, 1, 2 }, { 0, 2, 3 } };
    const pith_mesh_view view = {
        .positions = corners, .triangles = triangles, .vertex_count = 4, .triangle_count = 2
    };
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    return mesh;
}

enum { WIDTH = 96, HEIGHT = 64, MANY = 900 };
/* Rows under the horizon where a pixel takes in a cell or more, up to dozens. */
enum { FAR = 28, ROWS = 12 };

/* Even light, no floor: what is seen is the solid's colour. */
static pith_image *picture(const pith_mesh *mesh, const pith_solid *solid, uint32_t samples)
{
    pith_render_options options = pith_render_options_default();
    options.width = WIDTH;
    options.height = HEIGHT;
    options.samples = samples;
    options.light_strength = 0;
    options.ambient = 1;
    options.gloss = 0;
    options.ground = false;
    const pith_render_item item = { .mesh = mesh, .solid = solid };
    /* Just above the plane, looking along it: from some pixels a cell to many cells a pixel. */
    const pith_camera camera = { { 0.3, -9.5, 1.2 }, { 0.1, 0, 0 }, { 0, 0, 1 }, 40 };
    pith_image *image = NULL;
    CHECK_OK(pith_render(&item, 1, &camera, &options, NULL, &image, &err));
    return image;
}

/* Root of the mean square difference of the first channel, over rows below the horizon. */
static double distance(const pith_image *a, const pith_image *b, size_t first_row, size_t rows)
{
    double sum = 0;
    size_t count = 0;
    for (size_t i = WIDTH * first_row; i < WIDTH * (first_row + rows); ++i, ++count) {
        const double d = (double)a->pixels[i * a->channels] - b->pixels[i * b->channels];
        sum += d * d;
    }
    return sqrt(sum / (double)count);
}

static pith_solid *one_node(const char *function, const char *option, double value, bool turned)
{
    double options[2][40];
    pith_node nodes[2] = { { .function = pith_function_find(function) }, { .function = pith_function_find("place") } };
    const pith_link link = { 0, 1 };
    for (int k = 0; k < 2; ++k) {
        assert_in_range(nodes[k].function->params->size, 1, sizeof options[k]);
        pith_params_defaults(nodes[k].function->params, options[k]);
        nodes[k].options = options[k];
    }
    CHECK_OK(pith_param_set(pith_params_find(nodes[0].function->params, option), options[0], value, &err));
    /* A trunk that lies in the plane, its axis below it. */
    if (turned) {
        CHECK_OK(pith_param_set(pith_params_find(nodes[1].function->params, "turn_x"), options[1], 80, &err));
        CHECK_OK(pith_param_set(pith_params_find(nodes[1].function->params, "move_z"), options[1], -0.7, &err));
    } else {
        CHECK_OK(pith_param_set(pith_params_find(nodes[1].function->params, "move_z"), options[1], 0.05, &err));
    }
    nodes[0].links = &link;
    nodes[0].link_count = 1;
    const pith_procedural graph = {
        .nodes = nodes, .count = 2, .colour = 0, .opacity = PITH_NONE, .displacement = PITH_NONE
    };
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_procedural(&graph, &solid, &err));
    return solid;
}

/* filtered: what one sample with a footprint may be off by; unfiltered: what it is off by at least without. */
static void compare(const char *function, const char *option, double value, bool turned, double filtered,
                    double unfiltered)
{
    pith_mesh *mesh = plane_mesh(10);
    pith_solid *solid = one_node(function, option, value, turned);
    bare_solid bare = { .base = { &bare_class, pith_solid_channels(solid) }, .inner = solid };
    pith_image *truth = picture(mesh, &bare.base, MANY), *one = picture(mesh, solid, 1);
    pith_image *plain = picture(mesh, &bare.base, 1);
    const double with = distance(one, truth, FAR, ROWS), without = distance(plain, truth, FAR, ROWS);
    print_message("%s: rms %.4f with footprints, %.4f without\n", function, with, without);
    CHECK_AT_MOST(with, filtered);
    CHECK_AT_LEAST(without, unfiltered);
    pith_image_destroy(plain);
    pith_image_destroy(one);
    pith_image_destroy(truth);
    pith_solid_destroy(solid);
    pith_mesh_destroy(mesh);
}

static void test_a_far_plane_of_checks(void **state)
{
    (void)state;
    compare("checks", "size", 0.11, false, 0.05, 0.4);
}

static void test_a_far_plane_of_thin_rings(void **state)
{
    (void)state;
    compare("rings", "spacing", 0.05, true, 0.03, 0.3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_far_plane_of_checks),
        cmocka_unit_test(test_a_far_plane_of_thin_rings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
