/* Surfaces of features: what is refused of a sketch, and loops swept along the axis. */
#include "sketch_internal.h"

/* ---- options -------------------------------------------------------------------------------------------------------------- */

static const pith_param feature_items[] = {
    { "across", "1", "samples of each horizontal curve; more are finer", PITH_PARAM_UINT, 8, 96, 2048,
      offsetof(pith_feature, across), NULL },
    { "along", "1", "samples of the vertical curve; more are finer", PITH_PARAM_UINT, 4, 48, 1024,
      offsetof(pith_feature, along), NULL },
};
const pith_params pith_feature_params = { "feature", feature_items, sizeof feature_items / sizeof *feature_items,
                                          sizeof(pith_feature) };

static const pith_param sketch_items[] = {
    { "folds", "1", "how often the structure repeats round the axis; 0: all round alike", PITH_PARAM_UINT, 0, 0, 64,
      offsetof(pith_sketch, folds), NULL },
    { "fold_angle", "degrees", "from x to the line that the first fold begins at", PITH_PARAM_DOUBLE, -360, 0, 360,
      offsetof(pith_sketch, fold_angle), NULL },
};
const pith_params pith_sketch_params = { "sketch", sketch_items, sizeof sketch_items / sizeof *sketch_items,
                                         sizeof(pith_sketch) };

/* ---- checks ---------------------------------------------------------------------------------------------------------------- */

static pith_status check_vertical(const pith_feature *feature, pith_error *err)
{
    if (feature->kind == PITH_FEATURE_CHAMBERS && !feature->vertical.closed)
        return pith_fail(err, PITH_BAD_ARGUMENT, "chambers have a closed loop, and this one is open");
    return sketch_curve_check(&feature->vertical, SKETCH_HALF_PLANE, err);
}

static pith_status check_loop(const pith_sketch *sketch, const pith_feature *feature, size_t i, uint64_t *folds_taken,
                              pith_error *err)
{
    sketch_loop loop;
    uint32_t fold = 0;
    pith_status status = sketch_loop_make(&feature->horizontal[i], &loop, err);
    if (status == PITH_OK && feature->kind == PITH_FEATURE_AROUND && !loop.winds)
        status = pith_fail(err, PITH_BAD_ARGUMENT,
                           "the loop does not run round the axis; draw it round the middle of the picture");
    if (status == PITH_OK && feature->kind == PITH_FEATURE_CHAMBERS) {
        status = sketch_loop_fold(sketch, &loop, &fold, err);
        if (status == PITH_OK && (*folds_taken >> fold & 1))
            status = pith_fail(err, PITH_BAD_ARGUMENT, "a second loop in fold %u; each fold has one", fold);
        *folds_taken |= (uint64_t)1 << fold;
    }
    sketch_loop_free(&loop);
    return status;
}

static pith_status check_feature(const pith_sketch *sketch, const pith_feature *feature, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_feature_params, feature, err));
    if (feature->kind > PITH_FEATURE_CHAMBERS)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is no kind %u of features", feature->kind);
    const bool chambers = feature->kind == PITH_FEATURE_CHAMBERS;
    if (chambers && sketch->folds == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "chambers lie in folds, and the sketch has none; set folds");
    if (chambers && feature->horizontal_count != 1 && feature->horizontal_count != sketch->folds)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%zu horizontal loops; expected one in each of the %u folds, or one that stands for all",
                         feature->horizontal_count, sketch->folds);
    if (!chambers && feature->horizontal_count > 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu horizontal loops; what surrounds the axis has one, or none",
                         feature->horizontal_count);
    if (feature->horizontal_count > 0 && !feature->horizontal)
        return pith_fail(err, PITH_BAD_ARGUMENT, "horizontal loops are missing");
    pith_status status = check_vertical(feature, err);
    if (status != PITH_OK) return pith_fail_in(err, status, "vertical curve");
    uint64_t folds_taken = 0;
    for (size_t i = 0; i < feature->horizontal_count; ++i) {
        status = check_loop(sketch, feature, i, &folds_taken, err);
        if (status == PITH_OK) continue;
        return feature->horizontal_count > 1 ? pith_fail_in(err, status, "horizontal curve %zu", i)
                                             : pith_fail_in(err, status, "horizontal curve");
    }
    return PITH_OK;
}

/* check_feature with the feature's name before its sentence. */
static pith_status check_named_feature(const pith_sketch *sketch, size_t i, pith_error *err)
{
    const pith_feature *feature = &sketch->features[i];
    const pith_status status = check_feature(sketch, feature, err);
    if (status == PITH_OK) return PITH_OK;
    return feature->name ? pith_fail_in(err, status, "feature %s", feature->name)
                         : pith_fail_in(err, status, "feature %zu", i);
}

pith_status pith_sketch_check(const pith_sketch *sketch, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_sketch_params, sketch, err));
    if (sketch->feature_count > 0 && !sketch->features)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a sketch of %zu features lists none", sketch->feature_count);
    for (size_t i = 0; i < sketch->feature_count; ++i) PITH_TRY(check_named_feature(sketch, i, err));
    return PITH_OK;
}

/* ---- rings ------------------------------------------------------------------------------------------------------------------- */

typedef uint32_t corners[3];

static void add_triangle(corners *triangles, size_t *count, size_t a, size_t b, size_t c)
{
    corners *t = &triangles[(*count)++];
    (*t)[0] = (uint32_t)a, (*t)[1] = (uint32_t)b, (*t)[2] = (uint32_t)c;
}

/* The triangles of one copy whose vertices begin at `from`. */
static void list_triangles(const sketch_rings *of, size_t from, corners *triangles, size_t *count)
{
    const size_t n = of->across, first = from + of->top, last = first + n * (of->rings - 1);
    for (size_t j = 0; of->top && j < n; ++j) add_triangle(triangles, count, from, first + j, first + (j + 1) % n);
    for (size_t i = 0; i + !of->wrap < of->rings; ++i) {
        const size_t above = first + n * i, below = first + n * ((i + 1) % of->rings);
        for (size_t j = 0; j < n; ++j) {
            const size_t k = (j + 1) % n;
            add_triangle(triangles, count, above + j, below + j, below + k);
            add_triangle(triangles, count, above + j, below + k, above + k);
        }
    }
    for (size_t j = 0; of->bottom && j < n; ++j) add_triangle(triangles, count, last + j, last + n, last + (j + 1) % n);
}

static double volume_of(const pith_vec3 *positions, corners *triangles, size_t count)
{
    double sum = 0.0;
    const pith_vec3 from = positions[triangles[0][0]];
    for (size_t t = 0; t < count; ++t)
        sum += pith_dot(
            pith_sub(positions[triangles[t][0]], from),
            pith_cross(pith_sub(positions[triangles[t][1]], from), pith_sub(positions[triangles[t][2]], from)));
    return sum;
}

pith_status sketch_rings_mesh(const sketch_rings *of, const pith_vec3 *positions, pith_mesh **mesh, pith_error *err)
{
    const size_t vertices = sketch_rings_vertices(of);
    const size_t strips = of->wrap ? of->rings : of->rings - 1;
    const size_t each = of->across * (2 * strips + of->top + of->bottom);
    if (each * of->copies > UINT32_MAX / 4)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%zu triangles are too many; take fewer samples", each * of->copies);
    corners *triangles = pith_alloc(each * of->copies, sizeof *triangles);
    if (!triangles) return PITH_OUT_OF_MEMORY(err, "triangles");
    size_t count = 0;
    for (size_t i = 0; i < of->copies; ++i) list_triangles(of, i * vertices, triangles, &count);
    const bool closed = of->wrap || (of->top && of->bottom);
    for (size_t i = 0; i < of->copies; ++i) {
        corners *own = triangles + i * each;
        if (closed ? volume_of(positions, own, each) >= 0.0 : !of->turned) continue;
        for (size_t t = 0; t < each; ++t) {
            const uint32_t second = own[t][1];
            own[t][1] = own[t][2], own[t][2] = second;
        }
    }
    const pith_mesh_view view = { .positions = positions,
                                  .triangles = (const uint32_t(*)[3])triangles,
                                  .vertex_count = (uint32_t)(vertices * of->copies),
                                  .triangle_count = (uint32_t)count };
    const pith_status status = pith_mesh_create(&view, mesh, err);
    pith_free(triangles);
    return status;
}

/* ---- around the axis ------------------------------------------------------------------------------------------------------- */

/* The horizontal curve with radius 1 along x. */
static pith_status unit_loop(const pith_sketch *sketch, const pith_feature *feature, pith_vec2 *samples,
                             pith_error *err)
{
    if (feature->horizontal_count == 0) {
        for (uint32_t i = 0; i < feature->across; ++i) {
            const double angle = 2.0 * M_PI * i / feature->across;
            samples[i] = v2(cos(angle), sin(angle));
        }
        return PITH_OK;
    }
    sketch_loop loop;
    pith_status status = sketch_loop_make(&feature->horizontal[0], &loop, err);
    if (status == PITH_OK) status = sketch_loop_around(sketch, &loop, feature->across, samples, err);
    sketch_loop_free(&loop);
    PITH_TRY(status);
    const double radius = samples[0].x;
    for (uint32_t i = 0; i < feature->across; ++i) samples[i] = v2(samples[i].x / radius, samples[i].y / radius);
    return PITH_OK;
}

static pith_status sweep_around(const pith_sketch *sketch, const pith_feature *feature, pith_mesh **mesh,
                                pith_error *err)
{
    const size_t across = feature->across, along = feature->along;
    pith_vec2 *loop = pith_alloc(across, sizeof *loop), *profile = pith_alloc(along, sizeof *profile);
    pith_vec3 *positions = pith_alloc(across * along, sizeof *positions);
    pith_status status = loop && profile && positions ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a surface");
    if (status == PITH_OK) status = unit_loop(sketch, feature, loop, err);
    if (status == PITH_OK) status = pith_feature_profile(feature, along, profile, err);
    if (status == PITH_OK) {
        sketch_rings rings = { .across = across, .copies = 1, .wrap = feature->vertical.closed };
        rings.top = !rings.wrap && profile[0].x == 0.0;
        rings.bottom = !rings.wrap && profile[along - 1].x == 0.0;
        rings.rings = along - rings.top - rings.bottom;
        /* Away from the axis on the whole: downward in the sum of r dz. */
        double down = 0.0;
        for (size_t i = 1; i < along; ++i)
            down += (profile[i - 1].x + profile[i].x) * (profile[i - 1].y - profile[i].y);
        rings.turned = down < 0.0;
        size_t n = 0;
        for (size_t i = 0; i < along; ++i) {
            const pith_vec2 at = profile[i];
            const bool pole = (i == 0 && rings.top) || (i + 1 == along && rings.bottom);
            for (size_t j = 0; j < (pole ? 1 : across); ++j)
                positions[n++] = pole ? pith_v3(0, 0, at.y) : pith_v3(loop[j].x * at.x, loop[j].y * at.x, at.y);
        }
        status = sketch_rings_mesh(&rings, positions, mesh, err);
    }
    pith_free(loop);
    pith_free(profile);
    pith_free(positions);
    return status;
}

pith_status pith_sketch_surface(const pith_sketch *sketch, size_t feature, pith_mesh **mesh, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_sketch_params, sketch, err));
    if (feature >= sketch->feature_count || !sketch->features)
        return pith_fail(err, PITH_BAD_ARGUMENT, "there is no feature %zu in a sketch of %zu", feature,
                         sketch->feature_count);
    PITH_TRY(check_named_feature(sketch, feature, err));
    const pith_feature *of = &sketch->features[feature];
    return of->kind == PITH_FEATURE_CHAMBERS ? sketch_chambers(sketch, of, mesh, err)
                                             : sweep_around(sketch, of, mesh, err);
}
