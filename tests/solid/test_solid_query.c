/* How a question reaches a kind: block by block, every array in step, absent ones absent. */
#include "check.h"

#include "pith/solid_kind.h"

enum { POINTS = 5 * SOLID_BLOCK + 37 };

/* Answers are sums that tell apart which element of which array was seen. */
static void sum_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    assert_in_range(query->count, 1, SOLID_BLOCK);
    for (size_t i = 0; i < query->count; ++i, out += solid->channels) {
        out[0] = (float)query->points[i].x;
        out[1] = query->normals ? (float)query->normals[i].x : -1;
        out[2] = query->views ? (float)query->views[i].y : -1;
        out[3] = query->lights ? (float)query->lights[i].z : -1;
        out[4] = query->footprints ? query->footprints[i] : -1;
        out[5] = query->tets ? (float)query->tets[i] : -1;
        out[6] = query->weights ? (float)query->weights[i][2] : -1;
    }
}

static void keep(pith_solid *solid) { (void)solid; }

static const pith_solid_class class = { "sum", sum_sample, keep };

static void test_every_array_goes_along(void **state)
{
    (void)state;
    pith_error err;
    const struct pith_solid solid = { &class, 7 };
    static pith_vec3 points[POINTS], normals[POINTS], views[POINTS], lights[POINTS];
    static float footprints[POINTS], out[POINTS][7];
    static uint32_t tets[POINTS];
    static double weights[POINTS][4];
    for (int i = 0; i < POINTS; ++i) {
        points[i].x = i;
        normals[i].x = i + 10000;
        views[i].y = i + 20000;
        lights[i].z = i + 30000;
        footprints[i] = (float)(i + 40000);
        tets[i] = (uint32_t)i + 50000;
        weights[i][2] = i + 60000;
    }
    for (int without = 0; without <= 6; ++without) {
        const pith_query query = { .points = points,
                                   .normals = without == 1 ? NULL : normals,
                                   .views = without == 2 ? NULL : views,
                                   .lights = without == 3 ? NULL : lights,
                                   .footprints = without == 4 ? NULL : footprints,
                                   .tets = without >= 5 ? NULL : tets,
                                   .weights = without >= 5 ? NULL : (const double(*)[4])weights,
                                   .count = POINTS };
        CHECK_OK(pith_solid_sample(&solid, &query, &out[0][0], &err));
        for (int i = 0; i < POINTS; ++i)
            for (int k = 0; k < 7; ++k)
                CHECK_NEAR(out[i][k], k && (k == without || (k >= 5 && without >= 5)) ? -1 : i + 10000 * k, 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_every_array_goes_along) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
