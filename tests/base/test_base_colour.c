/* Colour spaces: sRGB's fixed points, Oklab's published pairs, its axes, and the way back. */
#include "check.h"

static void test_srgb_keeps_its_ends_and_its_grey(void **state)
{
    (void)state;
    CHECK_NEAR((double)pith_srgb_decode(0), 0, 0);
    CHECK_NEAR((double)pith_srgb_decode(1), 1, 0);
    CHECK_NEAR((double)pith_srgb_decode(0.5), 0.21404114048223255, 1e-7); /* ((0.5 + 0.055) / 1.055)^2.4 */
    CHECK_NEAR((double)pith_srgb_encode(0.21404114048223255), 0.5, 1e-7);
    CHECK_NEAR((double)pith_srgb_decode((double)NAN), 0, 0);
}

/* Pairs of XYZ (D65) and Oklab as the source prints them, three digits; XYZ to linear sRGB by IEC 61966-2-1. */
static void test_the_published_pairs(void **state)
{
    (void)state;
    static const double pairs[4][2][3] = { { { 0.950, 1.000, 1.089 }, { 1.000, 0.000, 0.000 } },
                                           { { 1.000, 0.000, 0.000 }, { 0.450, 1.236, -0.019 } },
                                           { { 0.000, 1.000, 0.000 }, { 0.922, -0.671, 0.263 } },
                                           { { 0.000, 0.000, 1.000 }, { 0.153, -1.415, -0.449 } } };
    static const double to_rgb[3][3] = { { 3.2404542, -1.5371385, -0.4985314 },
                                         { -0.9692660, 1.8760108, 0.0415560 },
                                         { 0.0556434, -0.2040259, 1.0572252 } };
    for (int i = 0; i < 4; ++i) {
        double rgb[3] = { 0 }, lab[3] = { NAN, NAN, NAN };
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) rgb[r] += to_rgb[r][c] * pairs[i][0][c];
        pith_oklab_from_rgb(rgb, lab);
        for (int k = 0; k < 3; ++k) CHECK_NEAR(lab[k], pairs[i][1][k], 2e-3);
    }
}

static void test_greys_have_no_hue_and_their_cube_root_for_lightness(void **state)
{
    (void)state;
    for (int i = 0; i <= 20; ++i) {
        const double v = 0.1 * i, grey[3] = { v, v, v };
        double lab[3] = { NAN, NAN, NAN };
        pith_oklab_from_rgb(grey, lab);
        CHECK_NEAR(lab[0], cbrt(v), 2e-7);
        CHECK_NEAR(lab[1], 0, 2e-7);
        CHECK_NEAR(lab[2], 0, 2e-7);
    }
}

static void test_there_and_back(void **state)
{
    (void)state;
    pith_rng rng = pith_rng_make(3, 0);
    for (int i = 0; i < 2000; ++i) {
        double rgb[3], lab[3], back[3] = { NAN, NAN, NAN };
        for (int k = 0; k < 3; ++k) rgb[k] = 3.0 * pith_rng_unit(&rng) - 1.0;
        pith_oklab_from_rgb(rgb, lab);
        pith_oklab_to_rgb(lab, back);
        for (int k = 0; k < 3; ++k) CHECK_NEAR(back[k], rgb[k], 5e-6);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_srgb_keeps_its_ends_and_its_grey),
        cmocka_unit_test(test_the_published_pairs),
        cmocka_unit_test(test_greys_have_no_hue_and_their_cube_root_for_lightness),
        cmocka_unit_test(test_there_and_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
