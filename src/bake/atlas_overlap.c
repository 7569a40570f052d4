/* Charts that would lie over themselves: a surface that winds up like a screw looks one way everywhere, and still cannot
   be laid flat. Found on the raster: no texel may be covered twice, and what a texel mixes, as far as its neighbours,
   must be near in space too. Of two triangles that meet so, the later one has to leave. */
#include "atlas_internal.h"

static const double reach = 1.0; /* texels: what bilinear filtering can mix */
static const double apart = 4.0; /* texels in space; on one sheet 2 would be the most */

bool atlas_covers(const atlas *a, uint32_t triangle, const double at[2])
{
    const uint32_t *v = a->surface.triangles[triangle];
    const double(*p)[2] = (const double(*)[2])a->places[triangle];
    for (int k = 0; k < 3; ++k) {
        const int l = (k + 1) % 3;
        const bool forward = v[k] < v[l];
        const double side = forward ? atlas_cross(p[k], p[l], at) : -atlas_cross(p[l], p[k], at);
        if (!(side > 0.0) && !(side == 0.0 && forward)) return false;
    }
    return true;
}

double atlas_segment(const double a[2], const double b[2], const double p[2], double *along)
{
    const double e[2] = { b[0] - a[0], b[1] - a[1] }, length = e[0] * e[0] + e[1] * e[1];
    const double t = length > 0.0 ? ((p[0] - a[0]) * e[0] + (p[1] - a[1]) * e[1]) / length : 0.0;
    *along = fmin(1.0, fmax(0.0, t));
    const double d[2] = { a[0] + *along * e[0] - p[0], a[1] + *along * e[1] - p[1] };
    return d[0] * d[0] + d[1] * d[1];
}

double atlas_nearest(const atlas *a, uint32_t triangle, const double at[2], double weights[3])
{
    const double(*p)[2] = (const double(*)[2])a->places[triangle];
    const double area = atlas_cross(p[0], p[1], p[2]);
    const double part[3] = { atlas_cross(p[1], p[2], at), atlas_cross(p[2], p[0], at), atlas_cross(p[0], p[1], at) };
    if (area > 0.0 && part[0] >= 0.0 && part[1] >= 0.0 && part[2] >= 0.0) {
        for (int k = 0; k < 3; ++k) weights[k] = part[k] / area;
        return 0.0;
    }
    double best = INFINITY;
    for (int k = 0; k < 3; ++k) {
        double t;
        const double square = atlas_segment(p[k], p[(k + 1) % 3], at, &t);
        if (!(square < best)) continue;
        best = square;
        weights[k] = 1.0 - t;
        weights[(k + 1) % 3] = t;
        weights[(k + 2) % 3] = 0.0;
    }
    return best;
}

static pith_vec3 in_space(const atlas *a, uint32_t triangle, const double weights[3])
{
    pith_vec3 sum = pith_v3(0, 0, 0);
    for (int k = 0; k < 3; ++k)
        sum = pith_madd(sum, a->surface.positions[a->surface.triangles[triangle][k]], weights[k]);
    return sum;
}

static bool are_mates(const atlas *a, uint32_t t, uint32_t u)
{
    const uint32_t *mates = a->surface.mates[t];
    return mates[0] == u || mates[1] == u || mates[2] == u;
}

/* Texels whose middles a triangle may cover or be near to: low .. high - 1. */
static void texels_near(const atlas *a, const atlas_chart *chart, uint32_t triangle, uint32_t low[2], uint32_t high[2])
{
    const uint32_t size[2] = { chart->width, chart->height };
    for (int d = 0; d < 2; ++d) {
        const double p = a->places[triangle][0][d], q = a->places[triangle][1][d], r = a->places[triangle][2][d];
        low[d] = (uint32_t)fmax(0.0, floor(fmin(fmin(p, q), r) - reach - 0.5));
        high[d] = (uint32_t)fmin(size[d], ceil(fmax(fmax(p, q), r) + reach + 0.5));
    }
}

/* claims: [height][width] the triangle that has the texel, plus 1. False when t must not have one of its texels; with
   `claim` it takes them. */
static bool visit(const atlas *a, const atlas_chart *chart, uint32_t t, uint32_t *claims, bool claim)
{
    uint32_t low[2], high[2];
    texels_near(a, chart, t, low, high);
    for (uint32_t y = low[1]; y < high[1]; ++y)
        for (uint32_t x = low[0]; x < high[0]; ++x) {
            const double at[2] = { x + 0.5, y + 0.5 };
            uint32_t *has = &claims[(size_t)y * chart->width + x];
            if (!claim && !*has) continue;
            const bool covers = atlas_covers(a, t, at);
            if (claim && *has && !covers) continue;
            double own[3], other[3];
            if (!covers && atlas_nearest(a, t, at, own) > reach * reach) continue;
            if (claim) {
                *has = t + 1; /* what covers a texel comes before what is only near */
                continue;
            }
            const uint32_t u = *has - 1;
            if (covers && atlas_covers(a, u, at)) return false;
            if (are_mates(a, t, u)) continue;
            atlas_nearest(a, t, at, own);
            atlas_nearest(a, u, at, other);
            if (pith_distance(in_space(a, t, own), in_space(a, u, other)) * a->options->density > apart) return false;
        }
    return true;
}

/* Triangles that leave the chart: their chart_of becomes PITH_NONE. Returns their number, or PITH_NONE without memory. */
static uint32_t part_chart(atlas *a, const atlas_chart *chart)
{
    uint32_t *claims = pith_alloc((size_t)chart->width * chart->height, sizeof *claims), removed = 0;
    if (!claims) return PITH_NONE;
    for (uint32_t i = 0; i < chart->count; ++i) {
        const uint32_t t = a->order[chart->first + i];
        if (visit(a, chart, t, claims, false)) {
            visit(a, chart, t, claims, true);
        } else {
            a->chart_of[t] = PITH_NONE;
            ++removed;
        }
    }
    pith_free(claims);
    return removed;
}

pith_status atlas_part_overlaps(atlas *a, uint32_t *removed, pith_error *err)
{
    uint32_t sum = 0;
    bool made = true;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 1) reduction(+ : sum) reduction(&& : made)
    for (size_t c = 0; c < a->chart_count; ++c) {
        atlas_chart *chart = &a->charts[c];
        if (chart->flat) continue;
        const uint32_t left = part_chart(a, chart);
        if (left == PITH_NONE)
            made = false;
        else
            sum += left;
        chart->flat = left == 0;
    }
    *removed = sum;
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a chart's raster");
}
