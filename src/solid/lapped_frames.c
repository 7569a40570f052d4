/* What a fill knows of the mesh before the first patch: a frame, a scale and a confidence per tet, and edge numbers.
   Frames are averages over a tet's vertices (thesis §5.3.2, "Constructing a Frame Field"). The scale is the user's for types
   0; for types 1 it is the inverse of the depth gradient's magnitude ("Creation of Depth-Varying Solid Models"), bounded
   above where the gradient vanishes and below where the model thins out. */
#include "lapped_internal.h"

#include <stdlib.h>
#include <string.h>

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Median of the vertices' inverse gradient magnitudes: the scale that most of the model has. */
static pith_status median_scale(const pith_lapped_input *input, uint32_t vertex_count, double *median, pith_error *err)
{
    double *magnitudes = pith_alloc(vertex_count, sizeof *magnitudes);
    if (!magnitudes) return PITH_OUT_OF_MEMORY(err, "the scale field");
    for (uint32_t v = 0; v < vertex_count; ++v) magnitudes[v] = pith_length(input->gradient[v]);
    qsort(magnitudes, vertex_count, sizeof *magnitudes, by_value);
    const double middle = vertex_count ? magnitudes[vertex_count / 2] : 0.0;
    pith_free(magnitudes);
    if (!(middle > 0.0 && isfinite(middle)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the depth field does not change over most of the model (median "
                         "gradient %g): give depth constraints of at least two different values", middle);
    *median = 1.0 / middle;
    return PITH_OK;
}

/* What a tet's frame is made from: means over its corners. */
typedef struct corner_means {
    pith_vec3 gradient;     /* of the gradients as they are (types 1), of their directions (0-C) */
    double magnitude;       /* of the gradients */
    pith_vec3 direction;
    double scale;
} corner_means;

static corner_means means_of(const pith_lapped_input *input, const uint32_t corners[4], bool homogeneous)
{
    corner_means mean = { { 0, 0, 0 }, 0.0, { 0, 0, 0 }, 0.0 };
    for (int k = 0; k < 4; ++k) {
        const uint32_t v = corners[k];
        if (input->gradient) {
            const pith_vec3 g = input->gradient[v];
            mean.gradient = pith_madd(mean.gradient, homogeneous ? pith_unit(g) : g, 0.25);
            mean.magnitude += 0.25 * pith_length(g);
        }
        if (input->direction) mean.direction = pith_madd(mean.direction, input->direction[v], 0.25);
        if (input->scale) mean.scale += 0.25 * input->scale[v];
    }
    return mean;
}

/* Frame, scale and confidence of one tet. Near the core the vertices' gradients point every way and cancel: what is left
   of the mean, against the bound on the scale, says how far the frame there is to be trusted. Where a vector field turns
   on the spot its directions cancel likewise. */
static lapped_tet tet_frame(const pith_lapped_input *input, uint32_t type, const uint32_t corners[4],
                            const double scale_range[2])
{
    const corner_means mean = means_of(input, corners, lapped_homogeneous(type));
    lapped_tet tet = { pith_v3(0, 0, 1), pith_v3(1, 0, 0), mean.scale, 1.0 };
    double trust = 1.0;
    if (type == PITH_TYPE_0B) {
        trust = pith_length(mean.direction);
        if (trust > 1e-9) tet.secondary = pith_unit(mean.direction);
    } else if (type != PITH_TYPE_0A) {
        if (!lapped_homogeneous(type))
            tet.scale = mean.magnitude * scale_range[1] > 1.0 ? fmax(1.0 / mean.magnitude, scale_range[0])
                                                              : scale_range[1];
        if (pith_length(mean.gradient) > 0.0) tet.primary = pith_unit(mean.gradient);
        const pith_vec3 across = pith_reject(mean.direction, tet.primary);
        tet.secondary = pith_length(across) > 1e-9 ? pith_unit(across) : pith_perpendicular(tet.primary);
        trust = pith_length(mean.gradient) * (lapped_homogeneous(type) ? 1.0 : tet.scale);
    }
    tet.confidence = fmax(0.02, fmin(1.0, trust * trust));
    return tet;
}

static int by_number(const void *a, const void *b)
{
    const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Numbers the mesh's edges: vertices in buckets of their lower end, sorted and made unique. O(tets). */
static pith_status number_edges(lapped_context *context, pith_error *err)
{
    const pith_tets_view *tets = &context->tets;
    const size_t pairs = (size_t)tets->tet_count * 6;
    uint32_t *start = pith_alloc((size_t)tets->vertex_count + 2, sizeof *start);
    uint32_t *upper = pith_alloc(pairs, sizeof *upper), *first = pith_alloc((size_t)tets->vertex_count + 1, sizeof *first);
    context->tet_edges = pith_alloc(tets->tet_count, sizeof *context->tet_edges);
    if (!start || !upper || !first || !context->tet_edges) {
        pith_free(start), pith_free(upper), pith_free(first);
        return PITH_OUT_OF_MEMORY(err, "the edges of the mesh");
    }

    /* Count, then place the upper end of every tet's every edge in its lower end's bucket. */
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t t = 0; t < tets->tet_count; ++t)
            for (int e = 0; e < 6; ++e) {
                const uint32_t a = tets->tets[t][lapped_edge_corners[e][0]], b = tets->tets[t][lapped_edge_corners[e][1]];
                const uint32_t low = a < b ? a : b, high = a < b ? b : a;
                if (pass == 0) ++start[low + 2];
                else upper[start[low + 1]++] = high;
            }
        if (pass == 0)
            for (uint32_t v = 0; v < tets->vertex_count; ++v) start[v + 2] += start[v + 1];
    }

    /* Sort each bucket and drop repetitions; first[v] becomes the number of v's first edge. */
    uint32_t edges = 0;
    for (uint32_t v = 0; v < tets->vertex_count; ++v) {
        const uint32_t begin = start[v], end = start[v + 1];
        qsort(upper + begin, end - begin, sizeof *upper, by_number);
        first[v] = edges;
        for (uint32_t i = begin; i < end; ++i)
            if (i == begin || upper[i] != upper[i - 1]) upper[edges++] = upper[i]; /* edges <= i: never ahead */
    }
    first[tets->vertex_count] = edges;
    context->edge_count = edges;

#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int e = 0; e < 6; ++e) {
            const uint32_t a = tets->tets[t][lapped_edge_corners[e][0]], b = tets->tets[t][lapped_edge_corners[e][1]];
            const uint32_t low = a < b ? a : b, high = a < b ? b : a;
            uint32_t at = first[low];
            while (upper[at] != high) ++at;
            context->tet_edges[t][e] = at;
        }
    pith_free(start), pith_free(upper), pith_free(first);
    return PITH_OK;
}

pith_status lapped_context_make(const pith_lapped_input *input, const pith_lapped_options *options,
                                lapped_context *context, pith_error *err)
{
    memset(context, 0, sizeof *context);
    const bool homogeneous = lapped_homogeneous(options->type);
    context->tets = pith_tets_look(input->tets);
    context->depth = homogeneous ? NULL : input->depth;
    context->options = options;
    context->components = homogeneous ? 3 : 2;
    context->cos_limit = cos(options->angle_limit * M_PI / 180.0);
    double median = 0.0;
    if (!homogeneous) PITH_TRY(median_scale(input, context->tets.vertex_count, &median, err));
    const double scale_range[2] = { options->scale_floor * median, options->scale_bound * median };
    context->frames = pith_alloc(context->tets.tet_count, sizeof *context->frames);
    if (!context->frames) return PITH_OUT_OF_MEMORY(err, "the frame field");
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
    for (uint32_t t = 0; t < context->tets.tet_count; ++t)
        context->frames[t] = tet_frame(input, options->type, context->tets.tets[t], scale_range);
    return number_edges(context, err);
}

void lapped_context_free(lapped_context *context)
{
    pith_free(context->frames);
    pith_free(context->tet_edges);
}
