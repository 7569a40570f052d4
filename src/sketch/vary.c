/* Random variations of a sketch: its copy, with other horizontal loops, made less different until nothing crosses. */
#include "vary_internal.h"

#include <string.h>

static const pith_param variation_items[] = {
    { "seed", "1", "chooses the individual", PITH_PARAM_SEED, 0, 0, 9007199254740992.0,
      offsetof(pith_variation_options, seed), NULL },
    { "strength", "1", "0 as it was drawn, 1 as different as the drawing's own unevenness", PITH_PARAM_DOUBLE, 0, 1, 3,
      offsetof(pith_variation_options, strength), NULL },
};
const pith_params pith_variation_params = { "variation", variation_items,
                                            sizeof variation_items / sizeof *variation_items,
                                            sizeof(pith_variation_options) };

/* ---- the copy ------------------------------------------------------------------------------------------------------------- */

void *vary_own(pith_varied_sketch *varied, size_t count, size_t size)
{
    if (!pith_grow((void **)&varied->owned, &varied->owned_capacity, varied->owned_count + 1, sizeof *varied->owned))
        return NULL;
    void *made = pith_alloc(count, size);
    if (made) varied->owned[varied->owned_count++] = made;
    return made;
}

static pith_status copy_curve(pith_varied_sketch *to, const pith_curve *from, pith_curve *copy, pith_error *err)
{
    pith_vec2 *points = vary_own(to, from->count, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "a copied curve");
    memcpy(points, from->points, from->count * sizeof *points);
    *copy = (pith_curve){ points, from->count, from->closed };
    return PITH_OK;
}

static pith_status copy_feature(pith_varied_sketch *to, const pith_feature *from, pith_feature *copy, pith_error *err)
{
    *copy = *from;
    if (from->name) {
        char *name = vary_own(to, strlen(from->name) + 1, 1);
        if (!name) return PITH_OUT_OF_MEMORY(err, "a copied name");
        strcpy(name, from->name);
        copy->name = name;
    }
    PITH_TRY(copy_curve(to, &from->vertical, &copy->vertical, err));
    pith_curve *loops = vary_own(to, from->horizontal_count, sizeof *loops);
    if (!loops) return PITH_OUT_OF_MEMORY(err, "copied loops");
    for (size_t i = 0; i < from->horizontal_count; ++i) PITH_TRY(copy_curve(to, &from->horizontal[i], &loops[i], err));
    copy->horizontal = loops;
    return PITH_OK;
}

static pith_status copy_sketch(const pith_sketch *from, pith_varied_sketch **copy, pith_error *err)
{
    pith_varied_sketch *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a varied sketch");
    made->features = vary_own(made, from->feature_count, sizeof *made->features);
    pith_status status = made->features ? PITH_OK : PITH_OUT_OF_MEMORY(err, "copied features");
    made->sketch = *from;
    made->sketch.features = made->features;
    for (size_t i = 0; status == PITH_OK && i < from->feature_count; ++i)
        status = copy_feature(made, &from->features[i], &made->features[i], err);
    if (status == PITH_OK)
        *copy = made;
    else
        pith_varied_sketch_destroy(made);
    return status;
}

const pith_sketch *pith_varied_sketch_look(const pith_varied_sketch *varied) { return &varied->sketch; }

double pith_varied_sketch_strength(const pith_varied_sketch *varied) { return varied->strength; }

void pith_varied_sketch_destroy(pith_varied_sketch *varied)
{
    if (!varied) return;
    for (size_t i = 0; i < varied->owned_count; ++i) pith_free(varied->owned[i]);
    pith_free(varied->owned);
    pith_free(varied);
}

/* ---- loops ------------------------------------------------------------------------------------------------------------------- */

pith_status vary_set_loop(pith_varied_sketch *varied, size_t feature, size_t which, const pith_vec2 *points,
                          const bool *corners, size_t count, pith_error *err)
{
    pith_vec2 *own = vary_own(varied, 2 * count, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "a varied loop");
    size_t n = 0;
    for (size_t i = 0; i < count; ++i) {
        own[n++] = points[i];
        if (corners[i]) own[n++] = points[i];
    }
    /* The copy's own array of loops; only the sketch that is looked at calls it constant. */
    pith_curve *loops = (pith_curve *)varied->features[feature].horizontal;
    loops[which] = (pith_curve){ own, n, true };
    return PITH_OK;
}

void vary_find_corners(const sketch_spline *spline, const pith_vec2 *samples, size_t count, bool *corners)
{
    for (size_t i = 0; i < count; ++i) corners[i] = false;
    for (size_t k = 0; k < spline->knot_count; ++k)
        for (size_t i = 0; spline->corners[k] && i < count; ++i)
            corners[i] |= v2_distance(samples[i], spline->knots[k]) <= 1e-9 * spline->length;
}

/* All loops of a sketch in trees, feature by feature. */
typedef struct forest {
    sketch_spline *splines;
    sketch_tree *trees;
    size_t count;
} forest;

static void forest_free(forest *gone)
{
    for (size_t i = 0; i < gone->count; ++i) {
        sketch_tree_free(&gone->trees[i]);
        sketch_spline_free(&gone->splines[i]);
    }
    pith_free(gone->splines);
    pith_free(gone->trees);
}

static pith_status forest_make(const pith_sketch *of, forest *made, pith_error *err)
{
    size_t count = 0;
    for (size_t i = 0; i < of->feature_count; ++i) count += of->features[i].horizontal_count;
    *made = (forest){ pith_alloc(count, sizeof *made->splines), pith_alloc(count, sizeof *made->trees), 0 };
    if (!made->splines || !made->trees) return PITH_OUT_OF_MEMORY(err, "loops");
    for (size_t i = 0; i < of->feature_count; ++i)
        for (size_t k = 0; k < of->features[i].horizontal_count; ++k) {
            sketch_spline *spline = &made->splines[made->count];
            sketch_tree *tree = &made->trees[made->count++];
            PITH_TRY(sketch_spline_make(&of->features[i].horizontal[k], SKETCH_FREE, spline, err));
            PITH_TRY(sketch_tree_make(spline->line, spline->line_count - 1, true, tree, err));
        }
    return PITH_OK;
}

/* PITH_BAD_ARGUMENT when the varied sketch is not one, or loops cross that did not cross as they were drawn. */
static pith_status check_varied(const forest *drawn, const pith_sketch *varied, pith_error *err)
{
    PITH_TRY(pith_sketch_check(varied, err));
    forest now = { 0 };
    pith_status status = forest_make(varied, &now, err);
    for (size_t i = 0; status == PITH_OK && i < now.count; ++i)
        for (size_t k = i + 1; status == PITH_OK && k < now.count; ++k) {
            size_t pair[2];
            if (sketch_trees_cross(&now.trees[i], &now.trees[k], pair) &&
                !sketch_trees_cross(&drawn->trees[i], &drawn->trees[k], pair))
                status = pith_fail(err, PITH_BAD_ARGUMENT, "two loops cross");
        }
    forest_free(&now);
    return status;
}

/* ---- variation -------------------------------------------------------------------------------------------------------------- */

pith_status pith_sketch_vary(const pith_sketch *sketch, const pith_variation_options *options,
                             pith_varied_sketch **varied, pith_error *err)
{
    enum { TRIES = 8 };
    PITH_TRY(pith_params_check(&pith_variation_params, options, err));
    PITH_TRY(pith_sketch_check(sketch, err));
    forest drawn = { 0 };
    pith_varied_sketch *made = NULL;
    pith_status status = forest_make(sketch, &drawn, err);
    double strength = options->strength;
    for (int i = 0; status == PITH_OK && !made; ++i, strength *= 0.5) {
        if (i == TRIES) strength = 0.0; /* as it was drawn */
        PITH_TRY_OR(done, copy_sketch(sketch, &made, err));
        made->strength = strength;
        if (!(strength > 0.0)) break;
        pith_status fits = (sketch->folds == 0 ? vary_texture : vary_folds)(sketch, options->seed, strength, made, err);
        if (fits == PITH_OK) fits = check_varied(&drawn, &made->sketch, err);
        if (fits == PITH_OK) break;
        pith_varied_sketch_destroy(made);
        made = NULL;
        if (fits != PITH_BAD_ARGUMENT) status = fits;
    }
done:
    forest_free(&drawn);
    if (status == PITH_OK)
        *varied = made;
    else
        pith_varied_sketch_destroy(made);
    return status;
}
