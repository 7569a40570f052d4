/* Layers for composers: a composer written from the header against pith_solid_sample, on triangles at random and on
   what cuts lay open, for every type and way of blending; lists hardly longer than needed; threads; refusals. */
#include "models.h"

#include "composer.h"
#include "pith/cut.h"
#include "pith/document.h"

static pith_error err;

/* ---- solids ------------------------------------------------------------------------------------------------------ */

/* Waves along all three axes, in as many channels as wanted; the fourth is opacity. */
static pith_grid *wavy_exemplar(uint32_t size, uint32_t channels, bool clear)
{
    pith_grid *grid = NULL;
    const uint32_t sizes[3] = { size, size, size };
    CHECK_OK(pith_grid_create(sizes, channels, &grid, &err));
    float *v = grid->values;
    for (uint32_t k = 0; k < size; ++k)
        for (uint32_t j = 0; j < size; ++j)
            for (uint32_t i = 0; i < size; ++i, v += channels)
                for (uint32_t c = 0; c < channels; ++c) {
                    const double r = (i + 0.5) / size, s = (j + 0.5) / size, t = (k + 0.5) / size;
                    const double wave = sin(2 * M_PI * (r + c)) * sin(2 * M_PI * t + c) + sin(2 * M_PI * (s + 0.1 * c));
                    v[c] = (float)(0.5 + 0.24 * wave);
                    if (c == 3) v[c] = clear ? (float)held(1.5 - 4.0 * fabs(s - 0.5), 0.0, 1.0) : 1.0f;
                }
    return grid;
}

/* A solid to compare, and what it stands on. */
typedef struct scene {
    const char *name;
    model m;
    pith_grid *exemplar, *pasted[2];
    pith_vec3 pasted_at[2];
    double *scale;
    pith_solid *solid;
    const pith_solid *asked;    /* the solid, or the document's */
    pith_tets_view tets;
    const pith_tets *owner;
    pith_document *document;
    pith_model *built;
} scene;

typedef struct recipe {
    const char *name;
    uint32_t type, blend, boundary, channels;
    double size;        /* of the texture, types 0 */
    int fineness;       /* of the model */
    bool slab, pastes;
} recipe;

/* One paste that is clear in part, with as many channels as the fill, and an opaque one with four. */
static void paste_two(scene *s, uint32_t channels)
{
    s->pasted[0] = wavy_exemplar(8, channels, true);
    s->pasted[1] = wavy_exemplar(8, 4, false);
    const pith_vec3 middle = s->m.view.positions[s->m.view.tets[s->m.view.tet_count / 2][0]];
    const pith_vec3 other = s->m.view.positions[s->m.view.tets[s->m.view.tet_count / 3][1]];
    const pith_paste pastes[2] = {
        { .exemplar = s->pasted[1], .point = middle, .up = { 0, 1, 0 }, .along = { 1, 0.5, 1 }, .size = 0.9,
          .mask_radius = 0.5, .drop_off = 0.0 },
        { .exemplar = s->pasted[0], .point = pith_lerp(middle, other, 0.5), .up = { 1, 1, 0 }, .along = { 0, 0.5, 1 },
          .size = 1.1, .mask_radius = 0.45, .drop_off = 0.1 },
    };
    for (int i = 0; i < 2; ++i) s->pasted_at[i] = pastes[i].point;
    pith_solid *both = NULL;
    CHECK_OK(pith_lapped_paste(s->solid, pastes, 2, &both, &err));
    pith_solid_destroy(s->solid);
    s->solid = both;
}

static scene scene_of(const recipe *from)
{
    scene s = { .name = from->name, .m = from->slab ? slab_model(from->fineness) : ball_model(from->fineness),
                .exemplar = wavy_exemplar(12, from->channels, false) };
    s.scale = pith_alloc(s.m.view.vertex_count, sizeof *s.scale);
    for (uint32_t v = 0; v < s.m.view.vertex_count; ++v) s.scale[v] = from->size;
    pith_lapped_options options = pith_lapped_options_default();
    options.type = from->type;
    options.blend = from->blend;
    options.boundary = from->boundary;
    options.align = from->boundary == PITH_BOUNDARY_CUT ? 8 : 1;
    pith_lapped_input input = model_input(&s.m, s.exemplar);
    input.scale = s.scale;
    CHECK_OK(pith_solid_lapped(&input, &options, NULL, &s.solid, NULL, &err));
    if (from->pastes) paste_two(&s, from->channels);
    s.asked = s.solid;
    s.tets = s.m.view;
    s.owner = s.m.tets;
    return s;
}

static scene scene_of_document(const char *name)
{
    scene s = { .name = name };
    char path[400];
    snprintf(path, sizeof path, "%s/examples/%s.pith", PITH_SOURCE_DIR, name);
    CHECK_OK(pith_document_load(path, &s.document, &err));
    const pith_model_options options = { .cache = false };
    CHECK_OK(pith_model_create(s.document, &options, NULL, &s.built, &err));
    CHECK_OK(pith_model_solid(s.built, &s.asked, &err));
    CHECK_OK(pith_model_tets(s.built, &s.owner, NULL, &err));
    s.tets = pith_tets_look(s.owner);
    return s;
}

static void scene_free(scene *s)
{
    pith_solid_destroy(s->solid);
    pith_grid_destroy(s->exemplar), pith_grid_destroy(s->pasted[0]), pith_grid_destroy(s->pasted[1]);
    pith_free(s->scale);
    if (s->m.tets) model_free(&s->m);
    pith_model_destroy(s->built);
    pith_document_destroy(s->document);
}

/* ---- triangles --------------------------------------------------------------------------------------------------- */

typedef struct triangles { uint32_t *tets; double (*weights)[3][4]; size_t count; } triangles;

static triangles triangles_of(size_t count)
{
    return (triangles){ pith_alloc(count, sizeof(uint32_t)), pith_alloc(count, sizeof(double[3][4])), count };
}

static void triangles_free(triangles *of) { pith_free(of->tets), pith_free(of->weights); }

static void random_weights(pith_rng *rng, double w[4])
{
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += w[k] = -log(1.0 - pith_rng_unit(rng));
    for (int k = 0; k < 4; ++k) w[k] /= sum;
}

static bool near_paste(const scene *s, uint32_t tet)
{
    const pith_vec3 corner = s->tets.positions[s->tets.tets[tet][0]];
    return pith_distance(corner, s->pasted_at[0]) < 0.8 || pith_distance(corner, s->pasted_at[1]) < 0.8;
}

/* Triangles in random tets, of all sizes down to points; where there are pastes, most of them there. */
static triangles random_triangles(const scene *s, size_t count)
{
    triangles of = triangles_of(count);
    pith_rng rng = pith_rng_make(5, 1);
    for (size_t i = 0; i < count; ++i) {
        do of.tets[i] = pith_rng_below(&rng, s->tets.tet_count);
        while (s->pasted[0] && i % 4 > 0 && !near_paste(s, of.tets[i]));
        const double size = pow(0.001, pith_rng_unit(&rng));
        random_weights(&rng, of.weights[i][0]);
        for (int c = 1; c < 3; ++c) {
            double w[4];
            random_weights(&rng, w);
            for (int k = 0; k < 4; ++k) of.weights[i][c][k] = of.weights[i][0][k] * (1.0 - size) + w[k] * size;
        }
    }
    return of;
}

/* Skin and section of a half of the model, cut askew. */
static triangles half_triangles(const scene *s)
{
    const pith_box box = pith_box_of(s->tets.positions, s->tets.vertex_count);
    const pith_plane plane = { pith_lerp(box.low, box.high, 0.47), { 0.3, 0.2, 1 } };
    pith_part *part = NULL;
    pith_shell *half = NULL;
    CHECK_OK(pith_part_whole(s->owner, &part, &err));
    double *values = pith_alloc(s->tets.vertex_count, sizeof *values);
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    CHECK_OK(pith_part_cut(part, values, &half, NULL, &err));
    const pith_shell_view view = pith_shell_look(half);
    triangles of = triangles_of(view.triangle_count);
    memcpy(of.tets, view.source_tet, view.triangle_count * sizeof *of.tets);
    pith_shell_weights(half, of.weights);
    assert_true(of.count > 0);
    pith_shell_destroy(half);
    pith_part_destroy(part);
    pith_free(values);
    return of;
}

/* ---- comparing --------------------------------------------------------------------------------------------------- */

typedef struct layered { pith_lapped_view view; uint32_t *start; pith_lapped_layer *layers; } layered;

static layered layers_of(const scene *s, const triangles *of)
{
    layered l = { .start = pith_alloc(of->count + 1, sizeof *l.start) };
    CHECK_OK(pith_lapped_look(s->asked, &l.view, &err));
    CHECK_OK(pith_lapped_layers(s->asked, of->tets, (const double(*)[3][4])of->weights, of->count, l.start, &l.layers,
                                &err));
    return l;
}

static void layers_free(layered *l) { pith_free(l->start), pith_free(l->layers); }

/* A point of a triangle, uniformly at random. */
static void random_place(pith_rng *rng, double at[3])
{
    const double root = sqrt(pith_rng_unit(rng)), part = pith_rng_unit(rng);
    at[0] = 1.0 - root, at[1] = root * (1.0 - part), at[2] = root * part;
}

/* edge: points left out, because rounding decides there between rules. */
typedef struct compared { size_t points, fallback, lacking, edge; double worst; } compared;

enum { EACH = 24 };

/* The roles keep their word at a point. */
static void check_roles(const pith_lapped_view *view, const pith_lapped_layer *layers, uint32_t count,
                        const double at[3])
{
    bool hidden = false, spare = false;
    for (uint32_t l = 0; l < count; ++l) {
        const pith_lapped_patch patch = pith_lapped_patch_look(view, layers[l].patch);
        double rstf[4];
        layer_place(&layers[l], at, rstf);
        const double alpha = layer_alpha(view, &patch, rstf);
        if (layers[l].role == PITH_LAYER_WHOLE) CHECK_NEAR(alpha, 1.0, 0.0);
        if (layers[l].role == PITH_LAYER_SPARE && !hidden) CHECK_NEAR(alpha, 0.0, 0.0);
        assert_true(!spare || layers[l].role == PITH_LAYER_SPARE);
        assert_true(!hidden || layers[l].role == PITH_LAYER_SPARE);
        spare |= layers[l].role == PITH_LAYER_SPARE;
        hidden |= layers[l].role == PITH_LAYER_WHOLE && patch.exemplar == 0;
    }
}

/* Are rules 5 and 6 needed here, but by so little that rounding may decide? They make jumps, where the last trace of a
   patch ends. */
static bool on_the_edge(const pith_lapped_view *view, const pith_lapped_layer *layers, uint32_t count,
                        const double at[3], composed how)
{
    bool edge = how.thin;
    for (int c = 0; c < 3 && (how.fallback || how.lacking); ++c) {
        double beside[3], colour[COMPOSED_CHANNELS];
        for (int k = 0; k < 3; ++k) beside[k] = at[k] * (1.0 - 1e-5) + (k == c ? 1e-5 : 0.0);
        const composed there = compose_layers(view, layers, count, beside, colour);
        edge |= there.fallback != how.fallback || there.lacking != how.lacking;
    }
    return edge;
}

/* EACH points on one triangle, asked from the solid and composed from the layers. */
static void compare_triangle(const scene *s, const triangles *of, size_t i, const layered *l, pith_rng *rng,
                             compared *to)
{
    const uint32_t channels = l->view.channels, count = l->start[i + 1] - l->start[i];
    pith_vec3 places[EACH];
    uint32_t tets[EACH];
    double weights[EACH][4], at[EACH][3];
    float asked[EACH * COMPOSED_CHANNELS];
    for (int p = 0; p < EACH; ++p) {
        random_place(rng, at[p]);
        tets[p] = of->tets[i];
        places[p] = pith_v3(0, 0, 0);
        for (int k = 0; k < 4; ++k) {
            weights[p][k] = 0.0;
            for (int c = 0; c < 3; ++c) weights[p][k] += at[p][c] * of->weights[i][c][k];
            places[p] = pith_madd(places[p], s->tets.positions[s->tets.tets[tets[p]][k]], weights[p][k]);
        }
    }
    const pith_query query = { .points = places, .tets = tets, .weights = (const double(*)[4])weights, .count = EACH };
    CHECK_OK(pith_solid_sample(s->asked, &query, asked, &err));
    for (int p = 0; p < EACH; ++p) {
        double colour[COMPOSED_CHANNELS];
        const composed how = compose_layers(&l->view, l->layers + l->start[i], count, at[p], colour);
        to->fallback += how.fallback;
        to->lacking += how.lacking;
        ++to->points;
        if (on_the_edge(&l->view, l->layers + l->start[i], count, at[p], how)) {
            ++to->edge;
            continue;
        }
        for (uint32_t c = 0; c < channels; ++c) {
            const double away = fabs(colour[c] - (double)asked[(uint32_t)p * channels + c]);
            if (!(away <= to->worst)) to->worst = away;
        }
    }
    check_roles(&l->view, l->layers + l->start[i], count, at[0]);
}

/* At most `most` of the triangles, spread evenly over them. */
static void compare(const scene *s, const triangles *of, size_t most, compared *to)
{
    layered l = layers_of(s, of);
    pith_rng rng = pith_rng_make(6, 2);
    const size_t step = (of->count + most - 1) / most;
    for (size_t i = 0; i < of->count; i += step) compare_triangle(s, of, i, &l, &rng, to);
    layers_free(&l);
}

/* Triangles thrown into the model, and those of its half, within `tolerance` of what the solid answers. */
static compared compare_scene(const scene *s, size_t most, double tolerance)
{
    compared to = { 0 };
    triangles of = random_triangles(s, most);
    compare(s, &of, most, &to);
    triangles_free(&of);
    of = half_triangles(s);
    compare(s, &of, most, &to);
    triangles_free(&of);
    print_message("%s: %zu points, %zu by rule 5, %zu by rule 6, %zu left to rounding; off by at most %.2g\n", s->name,
                  to.points, to.fallback, to.lacking, to.edge, to.worst);
    CHECK_AT_MOST(to.worst, tolerance);
    CHECK_AT_MOST((double)to.edge, 1e-3 * (double)to.points);
    return to;
}

static const recipe recipes[] = {
    /* name, type, blend, boundary, channels, size, fineness, slab, pastes */
    { "0-A", PITH_TYPE_0A, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 4, 0.5, 5, false, false },
    { "0-B", PITH_TYPE_0B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 4, 0.7, 5, false, false },
    { "0-C cut to fit", PITH_TYPE_0C, PITH_BLEND_AVERAGE, PITH_BOUNDARY_CUT, 4, 0.8, 3, true, false },
    { "0-A variance", PITH_TYPE_0A, PITH_BLEND_VARIANCE, PITH_BOUNDARY_SPLOTCH, 4, 0.5, 5, false, false },
    { "1-A", PITH_TYPE_1A, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 3, 1, 6, false, false },
    { "1-B variance, five channels", PITH_TYPE_1B, PITH_BLEND_VARIANCE, PITH_BOUNDARY_SPLOTCH, 5, 1, 6, false, false },
    { "1-B cut to fit", PITH_TYPE_1B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_CUT, 4, 1, 3, true, false },
    { "1-B pastes", PITH_TYPE_1B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 4, 1, 3, true, true },
};

/* Pastes hide channels that they lack: rule 6. */
static const recipe lacking[] = {
    { "1-B pastes, five", PITH_TYPE_1B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 5, 1, 6, false, true },
    { "1-B pastes, variance, five", PITH_TYPE_1B, PITH_BLEND_VARIANCE, PITH_BOUNDARY_SPLOTCH, 5, 1, 3, true, true },
    { "0-B cut to fit, pastes, six", PITH_TYPE_0B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_CUT, 6, 0.6, 4, false, true },
};

/* Tets so large that patches lie between the samples of the coverage test: rule 5 is needed everywhere. Their texture
   coordinates run far beyond 0 and 1, so that single precision inside the solid is worth less. */
static const recipe coarse[] = {
    { "0-A, large tets", PITH_TYPE_0A, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 4, 0.12, 1, true, false },
    { "0-A variance, large tets", PITH_TYPE_0A, PITH_BLEND_VARIANCE, PITH_BOUNDARY_SPLOTCH, 5, 0.12, 1, true, false },
    { "0-B pastes, large tets", PITH_TYPE_0B, PITH_BLEND_AVERAGE, PITH_BOUNDARY_SPLOTCH, 4, 0.15, 1, true, true },
};

static void test_composed_as_sampled(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; ++i) {
        scene s = scene_of(&recipes[i]);
        compare_scene(&s, 500, 1e-5);
        scene_free(&s);
    }
}

static void test_channels_that_pastes_lack(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof lacking / sizeof *lacking; ++i) {
        scene s = scene_of(&lacking[i]);
        const compared to = compare_scene(&s, 500, 1e-5);
        assert_true(to.lacking > 150);
        scene_free(&s);
    }
}

static void test_points_that_no_mask_reaches(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof coarse / sizeof *coarse; ++i) {
        scene s = scene_of(&coarse[i]);
        const compared to = compare_scene(&s, 100, 5e-5);
        assert_true(to.fallback > 200);
        scene_free(&s);
    }
}

/* How long the lists of a half's triangles are, and how many of the layers one of many points shows. */
static void measure_lists(const scene *s, double *listed, double *seen)
{
    enum { TRIANGLES = 150, POINTS = 300 };
    triangles of = half_triangles(s);
    layered l = layers_of(s, &of);
    pith_rng rng = pith_rng_make(7, 1);
    double spare = 0, count = 0;
    *listed = *seen = 0;
    for (size_t t = 0; t < of.count; t += of.count / TRIANGLES) {
        const uint32_t own = l.start[t + 1] - l.start[t];
        const pith_lapped_layer *layers = l.layers + l.start[t];
        uint32_t shown = 0;
        for (int p = 0; p < POINTS; ++p) {
            double at[3], colour[COMPOSED_CHANNELS];
            random_place(&rng, at);
            shown |= compose_layers(&l.view, layers, own, at, colour).shown;
        }
        for (uint32_t k = 0; k < own; ++k) *(layers[k].role == PITH_LAYER_SPARE ? &spare : listed) += 1;
        *seen += __builtin_popcount(shown);
        count += 1;
    }
    *listed /= count, *seen /= count;
    print_message("%s: of %.2f layers a triangle %.2f are seen; %.2f spare\n", s->name, *listed, *seen, spare / count);
    CHECK_AT_MOST(spare / count, 0.2);
    layers_free(&l);
    triangles_free(&of);
}

/* The solid reckons in single precision: with the steep slopes of finer exemplars that counts for more. Where triangles
   are small beside patches, as the kiwi's and the sponge's, lists are hardly longer than what is seen. */
static void test_shipped_models(void **state)
{
    (void)state;
    static const struct { const char *name; double longer; } models[] = {
        { "kiwi", 1.3 }, { "sponge", 1.3 }, { "muscle", 1.6 }, { "flattened", 1.6 }, { "bricks_fitted", 1.6 },
    };
    for (size_t i = 0; i < sizeof models / sizeof *models; ++i) {
        scene s = scene_of_document(models[i].name);
        double listed, seen;
        compare_scene(&s, 500, 3e-5);
        measure_lists(&s, &listed, &seen);
        CHECK_AT_MOST(listed, models[i].longer * seen);
        scene_free(&s);
    }
}

/* ---- threads, memory, refusals ----------------------------------------------------------------------------------- */

static void test_same_bits_for_any_number_of_threads(void **state)
{
    (void)state;
    scene s = scene_of(&recipes[0]);
    triangles of = random_triangles(&s, 5000);
    pith_threads_set(1);
    layered one = layers_of(&s, &of);
    for (int threads = 2; threads <= 3; ++threads) {
        pith_threads_set(threads);
        layered many = layers_of(&s, &of);
        assert_memory_equal(many.start, one.start, (of.count + 1) * sizeof *one.start);
        assert_memory_equal(many.layers, one.layers, one.start[of.count] * sizeof *one.layers);
        layers_free(&many);
    }
    pith_threads_set(0);
    /* A triangle's layers do not depend on the others. */
    for (size_t i = 0; i < of.count; i += 500) {
        uint32_t start[2];
        pith_lapped_layer *layers = NULL;
        const double(*weights)[3][4] = (const double(*)[3][4])of.weights + i;
        CHECK_OK(pith_lapped_layers(s.asked, of.tets + i, weights, 1, start, &layers, &err));
        assert_int_equal(start[1], one.start[i + 1] - one.start[i]);
        assert_memory_equal(layers, one.layers + one.start[i], start[1] * sizeof *layers);
        pith_free(layers);
    }
    layers_free(&one);
    triangles_free(&of);
    scene_free(&s);
}

static void test_no_triangles(void **state)
{
    (void)state;
    scene s = scene_of(&recipes[6]);
    uint32_t start[1] = { 7 };
    pith_lapped_layer *layers = NULL;
    CHECK_OK(pith_lapped_layers(s.asked, NULL, NULL, 0, start, &layers, &err));
    assert_int_equal(start[0], 0);
    assert_non_null(layers);
    pith_free(layers);
    scene_free(&s);
}

static void test_no_memory_leaves_all_as_it_was(void **state)
{
    (void)state;
    scene s = scene_of(&recipes[6]);
    triangles of = random_triangles(&s, 2000);
    uint32_t *start = pith_alloc(of.count + 1, sizeof *start);
    int failures = 0;
    for (size_t n = 0;; ++n) {
        pith_lapped_layer *layers = NULL;
        memset(start, 0xa5, (of.count + 1) * sizeof *start);
        pith_memory_fail_after(n);
        const pith_status status = pith_lapped_layers(s.asked, of.tets, (const double(*)[3][4])of.weights, of.count,
                                                      start, &layers, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_free(layers);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(layers);
        for (size_t i = 0; i <= of.count; ++i) assert_int_equal(start[i], 0xa5a5a5a5);
        ++failures;
    }
    assert_int_equal(failures, 5);
    pith_free(start);
    triangles_free(&of);
    scene_free(&s);
}

static void test_refusals(void **state)
{
    (void)state;
    scene s = scene_of(&recipes[6]);
    triangles of = random_triangles(&s, 20);
    const double(*weights)[3][4] = (const double(*)[3][4])of.weights;
    uint32_t start[21] = { 9 };
    pith_lapped_layer *layers = NULL;
    pith_solid *grid = NULL;
    pith_lapped_view view = { .patch_count = 77 };
    CHECK_OK(pith_solid_grid(s.exemplar, true, &grid, &err));
    CHECK_FAILS(pith_lapped_layers(grid, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT, "kind grid");
    CHECK_FAILS(pith_lapped_layers(NULL, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT, "kind NULL");
    CHECK_FAILS(pith_lapped_layers(s.asked, NULL, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT, "not be NULL");
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, NULL, 20, start, &layers, &err), PITH_BAD_ARGUMENT, "not be NULL");
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, NULL, &layers, &err), PITH_BAD_ARGUMENT, "be NULL");
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, start, NULL, &err), PITH_BAD_ARGUMENT, "not be NULL");
    of.weights[13][2][1] = NAN;
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT,
                "triangle 13 has weights");
    of.weights[13][2][1] = -INFINITY;
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT,
                "not finite");
    of.tets[12] = s.tets.tet_count;
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT,
                "triangle 12 lies in tetrahedron");
    of.tets[11] = PITH_NONE;
    CHECK_FAILS(pith_lapped_layers(s.asked, of.tets, weights, 20, start, &layers, &err), PITH_BAD_ARGUMENT,
                "triangle 11 lies in");
    CHECK_FAILS(pith_lapped_look(grid, &view, &err), PITH_BAD_ARGUMENT, "kind grid");
    CHECK_FAILS(pith_lapped_look(NULL, &view, &err), PITH_BAD_ARGUMENT, "kind NULL");
    CHECK_FAILS(pith_lapped_look(s.asked, NULL, &err), PITH_BAD_ARGUMENT, "view NULL");
    assert_null(layers);
    assert_int_equal(start[0], 9);
    assert_int_equal(view.patch_count, 77);
    pith_solid_destroy(grid);
    triangles_free(&of);
    scene_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_composed_as_sampled),
        cmocka_unit_test(test_channels_that_pastes_lack),
        cmocka_unit_test(test_points_that_no_mask_reaches),
        cmocka_unit_test(test_shipped_models),
        cmocka_unit_test(test_same_bits_for_any_number_of_threads),
        cmocka_unit_test(test_no_triangles),
        cmocka_unit_test(test_no_memory_leaves_all_as_it_was),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
