/* Projections: each map's own property from its Jacobian, by differences of the answers; orientation, borders,
   filters. */
#include "pattern_runs.h"

enum { SIDE = 64 };

/* An image whose red and green are the place in it, from the lower left corner: bilinear values are then exact but for
   half a pixel at the border. */
static pith_image *places(uint32_t width, uint32_t height)
{
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(width, height, 3, &image, &err));
    for (uint32_t j = 0; j < height; ++j)
        for (uint32_t i = 0; i < width; ++i) {
            float *to = image->pixels + ((size_t)j * width + i) * 3;
            to[0] = (float)((i + 0.5) / width), to[1] = (float)(1 - (j + 0.5) / height), to[2] = 0.25f;
        }
    return image;
}

static pith_image *squares(uint32_t width, uint32_t height, uint32_t edge, uint32_t channels)
{
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(width, height, channels, &image, &err));
    for (uint32_t j = 0; j < height; ++j)
        for (uint32_t i = 0; i < width; ++i)
            for (uint32_t c = 0; c < channels; ++c)
                image->pixels[((size_t)j * width + i) * channels + c] =
                    c == 3 ? 1.0f : (float)((i / edge + j / edge) & 1);
    return image;
}

static void place_at(const pattern *p, pith_vec3 at, double uv[2])
{
    const float point[1][3] = { { (float)at.x, (float)at.y, (float)at.z } };
    float out[1][4];
    ask(p, point, NULL, 1, out);
    uv[0] = (double)out[0][0], uv[1] = (double)out[0][1];
}

/* A point of the unit sphere by longitude and latitude, and the unit vectors to the east and north there. */
static pith_vec3 sphere(double longitude, double latitude, pith_vec3 *east, pith_vec3 *north)
{
    const double c = cos(longitude), s = sin(longitude), k = cos(latitude), h = sin(latitude);
    if (east) *east = pith_v3(-s, c, 0);
    if (north) *north = pith_v3(-h * c, -h * s, k);
    return pith_v3(k * c, k * s, h);
}

/* Columns of the Jacobian to the east and north, in pixels per unit, by central differences along great circles. */
static void jacobian(const pattern *p, double longitude, double latitude, const double pixels[2], double to[2][2])
{
    const double h = 0.02;
    pith_vec3 way[2];
    const pith_vec3 at = sphere(longitude, latitude, &way[0], &way[1]);
    for (int w = 0; w < 2; ++w) {
        double ahead[2][2], behind[2][2]; /* at h and 2 h: fourth order */
        for (int k = 0; k < 2; ++k) {
            const double a = (k + 1) * h;
            place_at(p, pith_add(pith_scale(at, cos(a)), pith_scale(way[w], sin(a))), ahead[k]);
            place_at(p, pith_sub(pith_scale(at, cos(a)), pith_scale(way[w], sin(a))), behind[k]);
        }
        for (int c = 0; c < 2; ++c)
            to[c][w] = pixels[c] * (8 * (ahead[0][c] - behind[0][c]) - (ahead[1][c] - behind[1][c])) / (12 * h);
    }
}

enum { CONFORMAL = 1, EQUAL_AREA = 2, MERIDIANS = 4 };

static void test_maps_keep_what_they_promise(void **state)
{
    (void)state;
    static const struct {
        const char *words;
        int keeps;
        double low, high;
    } maps[] = {
        { "projection=mercator", CONFORMAL, -1.1, 1.1 },
        { "projection=stereographic reach=150", CONFORMAL, -0.7, 1.4 },
        { "projection=lambert_cylindrical", EQUAL_AREA, -1.1, 1.1 },
        { "projection=lambert_azimuthal reach=170", EQUAL_AREA, -0.9, 1.4 },
        { "projection=spherical", MERIDIANS, -1.1, 1.1 },
        { "projection=azimuthal_equidistant reach=180", MERIDIANS, -0.9, 1.4 },
    };
    for (int image_kind = 0; image_kind < 2; ++image_kind) {
        const double pixels[2] = { 2 * SIDE, image_kind ? 3 * SIDE : 2 * SIDE };
        pith_image *image = places((uint32_t)pixels[0], (uint32_t)pixels[1]);
        const pith_node assets = { .image = image };
        for (int m = 0; m < 6; ++m) {
            pattern p = make_from(&node_project, maps[m].words, &assets);
            double first_area = NAN, first_meridian = NAN, angle = 0.0, area = 0.0, meridian = 0.0;
            bool conformal = true, equivalent = true, equidistant = true;
            for (int n = 0; n < 200; ++n) {
                const double longitude = -2.4 + 4.8 * (n % 20) / 19,
                             latitude = maps[m].low + (maps[m].high - maps[m].low) * (n / 20) / 9;
                double j[2][2];
                jacobian(&p, longitude, latitude, pixels, j);
                const double ee = j[0][0] * j[0][0] + j[1][0] * j[1][0], nn = j[0][1] * j[0][1] + j[1][1] * j[1][1];
                const double en = j[0][0] * j[0][1] + j[1][0] * j[1][1], det = j[0][0] * j[1][1] - j[0][1] * j[1][0];
                if (n == 0) first_area = det, first_meridian = sqrt(nn);
                const double skew = fmax(fabs(ee - nn), 2 * fabs(en)) / (ee + nn);
                angle = fmax(angle, skew), area = fmax(area, fabs(fabs(det / first_area) - 1));
                meridian = fmax(meridian, fabs(sqrt(nn) / first_meridian - 1));
                assert_true(det > 0); /* seen from outside, nothing is mirrored */
            }
            conformal = angle < 2e-3, equivalent = area < 2e-3, equidistant = meridian < 2e-3;
            print_message("    %s: angles %.1e, areas %.1e, meridians %.1e\n", maps[m].words, angle, area, meridian);
            assert_int_equal(conformal, (maps[m].keeps & CONFORMAL) != 0);
            assert_int_equal(equivalent, (maps[m].keeps & EQUAL_AREA) != 0);
            assert_int_equal(equidistant, (maps[m].keeps & MERIDIANS) != 0);
            release(&p);
        }
        pith_image_destroy(image);
    }
}

/* Where things are: formulas in double, at points of spheres of several radii. */
static void test_places_by_formula(void **state)
{
    (void)state;
    const double pi = 3.14159265358979;
    pith_image *image = places(256, 128);
    const pith_node assets = { .image = image };
    static const char *const words[] = { "orthogonal width=2 height=3",
                                         "cylindrical height=3",
                                         "spherical",
                                         "mercator",
                                         "lambert_cylindrical",
                                         "stereographic",
                                         "lambert_azimuthal reach=120",
                                         "azimuthal_equidistant reach=180" };
    pith_rng rng = pith_rng_make(4, 4);
    for (int m = 0; m < 8; ++m) {
        char text[100];
        snprintf(text, sizeof text, "projection=%s", words[m]);
        pattern p = make_from(&node_project, text, &assets);
        for (int n = 0; n < 2000; ++n) {
            const pith_vec3 q = pith_scale(pith_rng_direction(&rng), exp(6 * pith_rng_unit(&rng) - 3));
            const double l = atan2(q.y, q.x), f = asin(q.z / pith_length(q)), c = pi / 2 - f, aspect = 0.5;
            double u = l / (2 * pi) + 0.5, v = 0, r = 0, edge = 1;
            switch (m) {
            case 0:
                u = q.x / 2, v = q.y / 3;
                break;
            case 1:
                v = q.z / 3;
                break;
            case 2:
                v = f / pi + 0.5;
                break;
            case 3:
                v = atanh(sin(f)) / (2 * pi * aspect) + 0.5;
                break;
            case 4:
                v = 0.5 + 0.5 * sin(f);
                break;
            case 5:
                r = tan(c / 2), edge = tan(pi / 4);
                break;
            case 6:
                r = sin(c / 2), edge = sin(pi / 3);
                break;
            default:
                r = c, edge = pi;
                break;
            }
            if (m >= 5) u = 0.5 + 0.5 * r / edge * cos(l), v = 0.5 + 0.5 * r / edge * sin(l) / aspect;
            const float point[1][3] = { { (float)q.x, (float)q.y, (float)q.z } };
            float out[1][4];
            ask(&p, point, NULL, 1, out);
            const double margin = fmax(fabs(u - 0.5), fabs(v - 0.5));
            if (margin > 0.5001) CHECK_NEAR((double)out[0][3], 0, 0);
            if (margin > 0.495) continue; /* half a pixel from the border */
            CHECK_NEAR((double)out[0][0], u, 2e-6);
            CHECK_NEAR((double)out[0][1], v, 4e-6);
            CHECK_NEAR((double)out[0][2], 0.25, 1e-6);
            CHECK_NEAR((double)out[0][3], 1, 0);
        }
        release(&p);
    }
    pith_image_destroy(image);
}

/* The orthogonal one is the paper's R: 0 outside of [0, 1)², pixels are prisms along z; and the other wraps. */
static void test_borders(void **state)
{
    (void)state;
    pith_image *image = squares(8, 8, 1, 1);
    const pith_node assets = { .image = image };
    static const char *const words[] = { "wrap=empty", "wrap=repeat", "wrap=mirror", "wrap=clamp" };
    for (int w = 0; w < 4; ++w) {
        pattern p = make_from(&node_project, words[w], &assets);
        for (int j = -20; j < 20; ++j)
            for (int i = -20; i < 20; ++i) {
                const float at[1][3] = { { (i + 0.5f) / 8, (j + 0.5f) / 8, 3.7f * (float)i } };
                float out[1][4];
                ask(&p, at, NULL, 1, out);
                const bool inside = i >= 0 && i < 8 && j >= 0 && j < 8;
                int a = i, b = j;
                if (w == 1) a = i & 7, b = j & 7;
                if (w == 2) a = (i & 15) < 8 ? i & 15 : 15 - (i & 15), b = (j & 15) < 8 ? j & 15 : 15 - (j & 15);
                if (w == 3) a = i < 0 ? 0 : i > 7 ? 7 : i, b = j < 0 ? 0 : j > 7 ? 7 : j;
                const double shown = inside || w ? 1 : 0;
                CHECK_NEAR((double)out[0][3], shown, 0);
                CHECK_NEAR((double)out[0][0], shown * ((a + 7 - b) & 1), 2e-6);
            }
        const float corners[3][3] = { { 0, 0, 1 }, { 1, 0.5f, 1 }, { 0.5f, 1, 1 } };
        float out[3][4];
        ask(&p, corners, NULL, 3, out);
        if (w == 0)
            for (int c = 0; c < 3; ++c) CHECK_NEAR((double)out[c][3], c == 0 ? 1 : 0, 0);
        release(&p);
    }
    pith_image_destroy(image);
}

static void test_projections_are_filtered(void **state)
{
    (void)state;
    pith_image *image = squares(256, 256, 11, 4);
    const pith_node assets = { .image = image };
    static const char *const words[] = {
        "projection=orthogonal wrap=repeat",
        "projection=orthogonal wrap=repeat width=0.25",
        "projection=cylindrical wrap=repeat",
        "projection=spherical",
        "projection=mercator wrap=repeat",
        "projection=lambert_cylindrical",
        "projection=stereographic reach=150 wrap=mirror",
        "projection=lambert_azimuthal reach=180",
        "projection=azimuthal_equidistant reach=180",
        "projection=orthogonal wrap=empty",
        "projection=cylindrical copies=3",
    };
    for (int m = 0; m < 11; ++m) {
        pattern p = make_from(&node_project, words[m], &assets);
        print_message("    %s\n", words[m]);
        for (double footprint = 0.02; footprint < 0.5; footprint *= 3) {
            const distances d = filter_distances(&p, NULL, 3, footprint, 150, 1);
            CHECK_AT_MOST(d.filtered, 0.045);
            CHECK_AT_MOST(d.filtered, 0.45 * d.plain);
        }
        release(&p);
    }
    pith_image_destroy(image);
}

/* White stays white, whatever the filter and the place, the poles and the seam included. */
static void test_constants_stay(void **state)
{
    (void)state;
    pith_image *image = NULL;
    CHECK_OK(pith_image_create(37, 23, 3, &image, &err));
    for (size_t i = 0; i < 37 * 23 * 3; ++i) image->pixels[i] = 0.7f;
    const pith_node assets = { .image = image };
    for (int m = 0; m < 8; ++m) {
        char text[100];
        snprintf(text, sizeof text, "wrap=clamp projection=%d", m);
        pattern p = make_from(&node_project, text, &assets);
        static const float points[][3] = { { 0, 0, 1 },       { 0, 0, -1 },         { 0, 0, 0 },
                                           { -1, 0, 0 },      { -1, -1e-9f, 0.2f }, { 0.3f, 0.2f, 5 },
                                           { 1e-20f, 0, -1 }, { 1e-4f, 1e-5f, -1 }, { 30, -40, 2 } };
        for (int i = 0; i < 9; ++i)
            for (float footprint = 0; footprint < 100; footprint = 3 * footprint + 0.01f) {
                float out[1][4];
                ask(&p, &points[i], &footprint, 1, out);
                for (int c = 0; c < 4; ++c) CHECK_NEAR((double)out[0][c], c < 3 ? 0.7 : 1, 1e-5);
            }
        release(&p);
    }
    pith_image_destroy(image);
}

static void test_refusals_and_the_rest(void **state)
{
    (void)state;
    pith_image *image = squares(40, 24, 3, 4);
    const pith_node assets = { .image = image };
    pattern p;
    CHECK_FAILS(prepare(&node_project, "", NULL, &p), PITH_BAD_ARGUMENT, "image: is missing");
    CHECK_FAILS(prepare(&node_project, "projection=stereographic reach=180", &assets, &p), PITH_BAD_ARGUMENT,
                "infinitely far");
    for (int m = 0; m < 8; ++m)
        for (int w = 0; w < 4; ++w) {
            char text[100];
            snprintf(text, sizeof text, "wrap=%d projection=%d", w, m);
            p = make_from(&node_project, text, &assets);
            check_lanes(&p, 2);
            check_odd_numbers(&p);
            release(&p);
        }
    p = make_from(&node_project, "wrap=repeat width=2 height=1", &assets);
    check_periodic(&p, 2);
    release(&p);
    check_options(&node_project);
    check_memory(&node_project, "", &assets);
    pith_image_destroy(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_maps_keep_what_they_promise),
        cmocka_unit_test(test_places_by_formula),
        cmocka_unit_test(test_borders),
        cmocka_unit_test(test_projections_are_filtered),
        cmocka_unit_test(test_constants_stay),
        cmocka_unit_test(test_refusals_and_the_rest),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
