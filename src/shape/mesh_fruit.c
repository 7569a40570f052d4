/* Fruit-like test bodies: an icosphere pushed through a superellipsoid, with dented poles and smooth unevenness. */
#include "mesh_internal.h"

#include <string.h>

#define OPTION(member) offsetof(pith_fruit_options, member)

static const pith_param fruit_items[] = {
    { "radius_x", "model units", "half the width along x", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6, OPTION(radius_x), NULL },
    { "radius_y", "model units", "half the width along y", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6, OPTION(radius_y), NULL },
    { "radius_z", "model units", "half the height along z, from pole to pole", PITH_PARAM_DOUBLE, 1e-6, 1.0, 1e6,
      OPTION(radius_z), NULL },
    { "power", "1", "2 is an ellipsoid; more makes it boxier", PITH_PARAM_DOUBLE, 1.0, 2.0, 16.0, OPTION(power), NULL },
    { "dent", "1", "how far both poles are pulled in, as a fraction of radius_z", PITH_PARAM_DOUBLE, 0.0, 0.0, 0.8,
      OPTION(dent), NULL },
    { "taper", "1", "how much narrower the lower pole's end is: 0 not at all, 1 runs to a point", PITH_PARAM_DOUBLE, 0.0, 0.0,
      1.0, OPTION(taper), NULL },
    { "bump", "1", "smooth unevenness, as a fraction of the radius", PITH_PARAM_DOUBLE, 0.0, 0.0, 0.3, OPTION(bump),
      NULL },
    { "detail", "1", "how often the icosahedron is subdivided: 20 * 4^detail triangles", PITH_PARAM_UINT, 0, 4, 8,
      OPTION(detail), NULL },
    { "seed", "1", "chooses the unevenness", PITH_PARAM_SEED, 0, 1, 9007199254740992.0, OPTION(seed), NULL },
};
const pith_params pith_fruit_params = { "fruit", fruit_items, sizeof fruit_items / sizeof *fruit_items,
                                        sizeof(pith_fruit_options) };

pith_fruit_options pith_fruit_options_default(void)
{
    pith_fruit_options options;
    pith_params_defaults(&pith_fruit_params, &options);
    return options;
}

/* ---- the icosphere ----------------------------------------------------------------------------------------------- */

static void make_icosahedron(pith_mesh *mesh)
{
    static const uint32_t faces[20][3] = {
        { 0, 11, 5 },  { 0, 5, 1 },  { 0, 1, 7 },  { 0, 7, 10 }, { 0, 10, 11 }, { 1, 5, 9 }, { 5, 11, 4 },
        { 11, 10, 2 }, { 10, 7, 6 }, { 7, 1, 8 },  { 3, 9, 4 },  { 3, 4, 2 },   { 3, 2, 6 }, { 3, 6, 8 },
        { 3, 8, 9 },   { 4, 9, 5 },  { 2, 4, 11 }, { 6, 2, 10 }, { 8, 6, 7 },   { 9, 8, 1 },
    };
    const double g = (1.0 + sqrt(5.0)) / 2.0;
    const pith_vec3 corners[12] = { { -1, g, 0 }, { 1, g, 0 }, { -1, -g, 0 }, { 1, -g, 0 },
                                    { 0, -1, g }, { 0, 1, g }, { 0, -1, -g }, { 0, 1, -g },
                                    { g, 0, -1 }, { g, 0, 1 }, { -g, 0, -1 }, { -g, 0, 1 } };
    for (int v = 0; v < 12; ++v) mesh->positions[v] = pith_unit(corners[v]);
    memcpy(mesh->triangles, faces, sizeof faces);
}

/* Index of the vertex in the middle of an edge: a hash table from the edge's ends to it. */
typedef struct middle_table {
    uint64_t *keys; /* (low << 32 | high) + 1; 0: free. low < high, so the sum never wraps to 0 */
    uint32_t *middles;
    size_t mask;
} middle_table;

static uint32_t middle_of(middle_table *table, pith_mesh *mesh, uint32_t *vertex_count, uint32_t a, uint32_t b)
{
    const uint64_t key = ((uint64_t)(a < b ? a : b) << 32 | (a < b ? b : a)) + 1;
    size_t slot = pith_mix64(key) & table->mask;
    while (table->keys[slot] && table->keys[slot] != key) slot = (slot + 1) & table->mask;
    if (!table->keys[slot]) {
        table->keys[slot] = key;
        table->middles[slot] = *vertex_count;
        mesh->positions[(*vertex_count)++] = pith_unit(pith_add(mesh->positions[a], mesh->positions[b]));
    }
    return table->middles[slot];
}

/* Cuts each of the first `triangles` triangles in four; positions and triangles have room for the result. */
static bool subdivide(pith_mesh *mesh, uint32_t *vertex_count, uint32_t triangles)
{
    size_t slots = 64;
    while (slots < (size_t)triangles * 3) slots *= 2; /* 1.5 edges a triangle: at most half full */
    middle_table table = { pith_alloc(slots, sizeof *table.keys), pith_alloc(slots, sizeof *table.middles), slots - 1 };
    const bool ready = table.keys && table.middles;
    for (uint32_t t = triangles; ready && t-- > 0;) { /* from behind: children land on slots already read */
        uint32_t c[3], m[3];
        memcpy(c, mesh->triangles[t], sizeof c);
        for (int k = 0; k < 3; ++k) m[k] = middle_of(&table, mesh, vertex_count, c[k], c[(k + 1) % 3]);
        const uint32_t children[4][3] = {
            { c[0], m[0], m[2] }, { c[1], m[1], m[0] }, { c[2], m[2], m[1] }, { m[0], m[1], m[2] }
        };
        memcpy(mesh->triangles[4 * (size_t)t], children, sizeof children);
    }
    pith_free(table.keys);
    pith_free(table.middles);
    return ready;
}

/* ---- the body ---------------------------------------------------------------------------------------------------- */

enum { WAVES = 8 };
typedef struct fruit_waves {
    pith_vec3 frequency[WAVES];
    double phase[WAVES];
} fruit_waves;

static fruit_waves make_waves(uint64_t seed)
{
    fruit_waves waves;
    pith_rng rng = pith_rng_make(seed, 0x66727569); /* "frui": a stream of its own */
    for (int w = 0; w < WAVES; ++w) {
        const double pitch = 1.5 + 4.0 * pith_rng_unit(&rng); /* radians over the unit sphere's radius */
        waves.frequency[w] = pith_scale(pith_rng_direction(&rng), pitch);
        waves.phase[w] = 2.0 * M_PI * pith_rng_unit(&rng);
    }
    return waves;
}

/* From a point of the unit sphere to the fruit's surface. */
static pith_vec3 fruit_point(const pith_fruit_options *options, const fruit_waves *waves, pith_vec3 d)
{
    const double p = options->power;
    const double sum = pow(fabs(d.x), p) + pow(fabs(d.y), p) + pow(fabs(d.z), p);
    const double body = p == 2.0 ? 1.0 : pow(sum, -1.0 / p);
    double uneven = 0.0;
    for (int w = 0; w < WAVES; ++w) uneven += sin(pith_dot(waves->frequency[w], d) + waves->phase[w]) / WAVES;
    const double size = body * (1.0 + options->bump * uneven);

    /* The dent fades out with a continuous slope at 25 degrees from the pole. */
    const double reach = 25.0 * M_PI / 180.0, angle = atan2(hypot(d.x, d.y), fabs(d.z)) / reach;
    const double fade = angle < 1.0 ? (1.0 - angle * angle) * (1.0 - angle * angle) : 0.0;
    const double dented = size * (1.0 - options->dent * fade);
    const double narrow = size * (1.0 - options->taper * (0.5 - 0.5 * d.z));
    return pith_v3(options->radius_x * d.x * narrow, options->radius_y * d.y * narrow, options->radius_z * d.z * dented);
}

pith_status pith_mesh_fruit(const pith_fruit_options *options, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_fruit_params, options, err));
    const uint32_t triangles = 20u << (2 * options->detail);
    pith_mesh *made = mesh_new(triangles / 2 + 2, triangles, false, false, false); /* Euler: V = F / 2 + 2 */
    if (!made) return PITH_OUT_OF_MEMORY(err, "the fruit");
    make_icosahedron(made);
    uint32_t vertices = 12;
    for (uint32_t level = 0; level < options->detail; ++level)
        if (!subdivide(made, &vertices, 20u << (2 * level))) {
            pith_mesh_destroy(made);
            return PITH_OUT_OF_MEMORY(err, "the fruit's edges");
        }
    const fruit_waves waves = make_waves(options->seed);
    for (uint32_t v = 0; v < vertices; ++v) made->positions[v] = fruit_point(options, &waves, made->positions[v]);
    *mesh = made;
    return PITH_OK;
}
