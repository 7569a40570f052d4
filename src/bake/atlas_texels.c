/* Texels: every place of the atlas that shows surface, or lies in the margin of what does, is asked of the solid at the
   point of the surface that is there, or nearest. Peachey, "Solid texturing of complex surfaces", SIGGRAPH 1985,
   section 5: sampled finer than the picture is, and brought to its resolution by a weighted mean: a tent two texels wide.

   Tile by tile, each with a rim of one texel for the filter: a tile depends on nothing but the charts. */
#include "atlas_internal.h"

#include <string.h>

enum { RIM = 1 };

/* What is read by all threads. */
typedef struct fill {
    const atlas *atlas;
    const pith_progress *progress;
    uint32_t side;               /* of a tile, texels: fewer where each has many samples */
    uint32_t columns, rows;      /* of tiles */
    uint32_t *first, *triangles; /* [tiles + 1]; those that a tile may need */
    double (**weights)[3][4];    /* [item_count] of shells */
    pith_image *image;
    uint32_t channels; /* most of any solid */
    float footprint;
} fill;

/* One tile's samples, row by row from below, and what is asked of a solid. */
typedef struct tile {
    double *squares;     /* distance from the chart, texels²; 0: covered; infinite: nothing near */
    double (*places)[3]; /* barycentric */
    uint32_t *triangles;
    float (*colours)[4];
    uint32_t *asked; /* samples of the item being asked */
    pith_vec3 *points, *normals;
    float *footprints, *answers;
    uint32_t *tets;
    double (*weights)[4];
    double left, bottom; /* texels; of the rim */
    uint64_t filled;
} tile;

static uint32_t tile_side(const fill *f) { return (f->side + 2 * RIM) * f->atlas->options->samples; }

static void tile_free(tile *t)
{
    pith_free(t->squares);
    pith_free(t->places);
    pith_free(t->triangles);
    pith_free(t->colours);
    pith_free(t->asked);
    pith_free(t->points);
    pith_free(t->normals);
    pith_free(t->footprints);
    pith_free(t->answers);
    pith_free(t->tets);
    pith_free(t->weights);
}

static pith_status tile_make(tile *t, const fill *f, pith_error *err)
{
    const size_t count = (size_t)tile_side(f) * tile_side(f);
    *t = (tile){ .squares = pith_alloc(count, sizeof *t->squares),
                 .places = pith_alloc(count, sizeof *t->places),
                 .triangles = pith_alloc(count, sizeof *t->triangles),
                 .colours = pith_alloc(count, sizeof *t->colours),
                 .asked = pith_alloc(count, sizeof *t->asked),
                 .points = pith_alloc(count, sizeof *t->points),
                 .normals = pith_alloc(count, sizeof *t->normals),
                 .footprints = pith_alloc(count, sizeof *t->footprints),
                 .answers = pith_alloc(count, f->channels * sizeof *t->answers),
                 .tets = pith_alloc(count, sizeof *t->tets),
                 .weights = pith_alloc(count, sizeof *t->weights) };
    if (t->squares && t->places && t->triangles && t->colours && t->asked && t->points && t->normals && t->footprints &&
        t->answers && t->tets && t->weights)
        return PITH_OK;
    tile_free(t);
    return PITH_OUT_OF_MEMORY(err, "a tile of the atlas");
}

/* ---- which triangle is where ------------------------------------------------------------------------------------- */

/* Samples of a tile, along one axis, that lie within `reach` of low .. high. */
static void samples_near(const fill *f, double start, double low, double high, double reach, uint32_t range[2])
{
    const double k = f->atlas->options->samples, side = tile_side(f);
    range[0] = (uint32_t)fmin(side, fmax(0.0, floor((low - reach - start) * k - 0.5)));
    range[1] = (uint32_t)fmin(side, fmax(0.0, ceil((high + reach - start) * k + 0.5)));
}

static void sample_at(const fill *f, const tile *t, uint32_t x, uint32_t y, double at[2])
{
    const double k = f->atlas->options->samples;
    at[0] = t->left + (x + 0.5) / k;
    at[1] = t->bottom + (y + 0.5) / k;
}

static void cover(const fill *f, tile *t, uint32_t triangle)
{
    const double(*p)[2] = (const double(*)[2])f->atlas->places[triangle];
    uint32_t xs[2], ys[2];
    samples_near(f, t->left, fmin(fmin(p[0][0], p[1][0]), p[2][0]), fmax(fmax(p[0][0], p[1][0]), p[2][0]), 0.0, xs);
    samples_near(f, t->bottom, fmin(fmin(p[0][1], p[1][1]), p[2][1]), fmax(fmax(p[0][1], p[1][1]), p[2][1]), 0.0, ys);
    for (uint32_t y = ys[0]; y < ys[1]; ++y)
        for (uint32_t x = xs[0]; x < xs[1]; ++x) {
            const size_t i = (size_t)y * tile_side(f) + x;
            double at[2];
            sample_at(f, t, x, y, at);
            if (!(t->squares[i] > 0.0) || !atlas_covers(f->atlas, triangle, at)) continue;
            atlas_nearest(f->atlas, triangle, at, t->places[i]);
            t->squares[i] = 0.0;
            t->triangles[i] = triangle;
        }
}

/* The margin: samples near an edge at which a chart ends. */
static void surround(const fill *f, tile *t, uint32_t triangle, int edge)
{
    const double *p = f->atlas->places[triangle][edge], *q = f->atlas->places[triangle][(edge + 1) % 3];
    const double reach = f->atlas->options->margin + (double)RIM;
    uint32_t xs[2], ys[2];
    samples_near(f, t->left, fmin(p[0], q[0]), fmax(p[0], q[0]), reach, xs);
    samples_near(f, t->bottom, fmin(p[1], q[1]), fmax(p[1], q[1]), reach, ys);
    for (uint32_t y = ys[0]; y < ys[1]; ++y)
        for (uint32_t x = xs[0]; x < xs[1]; ++x) {
            const size_t i = (size_t)y * tile_side(f) + x;
            if (!(t->squares[i] > 0.0)) continue;
            double at[2], along;
            sample_at(f, t, x, y, at);
            const double square = atlas_segment(p, q, at, &along);
            if (!(square < t->squares[i] && square <= reach * reach)) continue;
            t->squares[i] = fmax(square, 1e-300); /* above 0: not covered */
            t->triangles[i] = triangle;
            t->places[i][edge] = 1.0 - along;
            t->places[i][(edge + 1) % 3] = along;
            t->places[i][(edge + 2) % 3] = 0.0;
        }
}

static void find_triangles(const fill *f, tile *t, uint32_t number)
{
    const atlas *a = f->atlas;
    const size_t count = (size_t)tile_side(f) * tile_side(f);
    for (size_t i = 0; i < count; ++i) {
        t->squares[i] = INFINITY;
        t->triangles[i] = PITH_NONE;
    }
    for (uint32_t j = f->first[number]; j < f->first[number + 1]; ++j) cover(f, t, f->triangles[j]);
    for (uint32_t j = f->first[number]; j < f->first[number + 1]; ++j)
        for (int k = 0; k < 3; ++k) {
            const uint32_t triangle = f->triangles[j], mate = a->surface.mates[triangle][k];
            if (mate == PITH_NONE || a->chart_of[mate] != a->chart_of[triangle]) surround(f, t, triangle, k);
        }
}

/* ---- asking ------------------------------------------------------------------------------------------------------ */

static pith_status ask_item(const fill *f, tile *t, uint32_t item, pith_error *err)
{
    const atlas_surface *s = &f->atlas->surface;
    const pith_shell_view *shell = &s->shells[item];
    const pith_solid *solid = s->items[item].solid;
    const uint32_t samples = tile_side(f) * tile_side(f), channels = pith_solid_channels(solid);
    size_t count = 0;
    for (uint32_t i = 0; i < samples; ++i) {
        if (t->triangles[i] == PITH_NONE || s->item[t->triangles[i]] != item) continue;
        const uint32_t triangle = t->triangles[i], local = triangle - s->first_triangle[item];
        pith_vec3 point = pith_v3(0, 0, 0), normal = point;
        double weights[4] = { 0.0 };
        for (int k = 0; k < 3; ++k) {
            const double part = t->places[i][k];
            point = pith_madd(point, shell->material[shell->triangles[local][k]], part);
            normal = pith_madd(normal, s->normals[triangle][k], part);
            for (int j = 0; j < 4; ++j) weights[j] += part * f->weights[item][local][k][j];
        }
        normal = pith_unit(normal);
        t->points[count] = point;
        t->normals[count] = pith_dot(normal, normal) > 0.0 ? normal : s->normals[triangle][0];
        t->footprints[count] = f->footprint;
        t->tets[count] = shell->source_tet[local];
        memcpy(t->weights[count], weights, sizeof weights);
        t->asked[count++] = i;
    }
    const pith_query query = { .points = t->points,
                               .normals = t->normals,
                               .footprints = t->footprints,
                               .tets = t->tets,
                               .weights = (const double(*)[4])t->weights,
                               .count = count };
    PITH_TRY(pith_solid_sample(solid, &query, t->answers, err));
    for (size_t i = 0; i < count; ++i)
        for (int c = 0; c < 4; ++c) /* fmax: not-a-number becomes black */
            t->colours[t->asked[i]][c] = fminf(1.0f, fmaxf(0.0f, t->answers[i * channels + c]));
    return PITH_OK;
}

static pith_status ask(const fill *f, tile *t, pith_error *err)
{
    uint32_t least = PITH_NONE, most = 0;
    const size_t samples = (size_t)tile_side(f) * tile_side(f);
    for (size_t i = 0; i < samples; ++i) {
        if (t->triangles[i] == PITH_NONE) continue;
        const uint32_t item = f->atlas->surface.item[t->triangles[i]];
        least = item < least ? item : least;
        most = item > most ? item : most;
    }
    for (uint32_t item = least; least != PITH_NONE && item <= most; ++item) PITH_TRY(ask_item(f, t, item, err));
    return PITH_OK;
}

/* ---- filtering --------------------------------------------------------------------------------------------------- */

/* The chart a texel belongs to, by the nearest of its own samples; PITH_NONE: it is farther than the margin from all. */
static uint32_t texel_chart(const fill *f, const tile *t, uint32_t x, uint32_t y)
{
    const uint32_t k = f->atlas->options->samples, side = tile_side(f);
    const double margin = f->atlas->options->margin;
    double best = margin * margin;
    uint32_t triangle = PITH_NONE;
    for (uint32_t j = 0; j < k; ++j)
        for (uint32_t i = 0; i < k; ++i) {
            const size_t at = (size_t)((y + RIM) * k + j) * side + (x + RIM) * k + i;
            if (!(t->squares[at] < best || (triangle == PITH_NONE && t->squares[at] <= best))) continue;
            best = t->squares[at];
            triangle = t->triangles[at];
        }
    return triangle == PITH_NONE ? PITH_NONE : f->atlas->chart_of[triangle];
}

/* Mean of the chart's samples round a texel; colours count by their opacity. */
static void filter_texel(const fill *f, const tile *t, uint32_t x, uint32_t y, uint32_t chart, float *out)
{
    const uint32_t k = f->atlas->options->samples, side = tile_side(f);
    double sum[4] = { 0.0 }, plain[3] = { 0.0 }, all = 0.0;
    for (uint32_t j = 0; j < 3 * k; ++j)
        for (uint32_t i = 0; i < 3 * k; ++i) {
            const size_t at = (size_t)(y * k + j) * side + x * k + i;
            const double far[2] = { fabs((i + 0.5) / k - 1.5), fabs((j + 0.5) / k - 1.5) };
            if (!(far[0] < 1.0 && far[1] < 1.0) || t->triangles[at] == PITH_NONE) continue;
            if (f->atlas->chart_of[t->triangles[at]] != chart) continue;
            const double weight = (1.0 - far[0]) * (1.0 - far[1]);
            const float *colour = t->colours[at];
            for (int c = 0; c < 3; ++c) {
                plain[c] += weight * colour[c];
                sum[c] += weight * colour[3] * colour[c];
            }
            sum[3] += weight * colour[3];
            all += weight;
        }
    for (int c = 0; c < 3; ++c) out[c] = (float)(sum[3] > 0.0 ? sum[c] / sum[3] : plain[c] / all);
    out[3] = (float)fmin(1.0, sum[3] / all);
}

static pith_status fill_tile(const fill *f, tile *t, uint32_t number, pith_error *err)
{
    const uint32_t left = number % f->columns * f->side, bottom = number / f->columns * f->side;
    t->left = (double)left - RIM;
    t->bottom = (double)bottom - RIM;
    find_triangles(f, t, number);
    PITH_TRY(ask(f, t, err));
    for (uint32_t y = 0; y < f->side && bottom + y < f->image->height; ++y)
        for (uint32_t x = 0; x < f->side && left + x < f->image->width; ++x) {
            float *out =
                f->image->pixels + 4 * ((size_t)(f->image->height - 1 - bottom - y) * f->image->width + left + x);
            const uint32_t chart = texel_chart(f, t, x, y);
            out[3] = -1.0f; /* nothing here */
            if (chart == PITH_NONE) continue;
            filter_texel(f, t, x, y, chart, out);
            ++t->filled;
        }
    return PITH_OK;
}

/* ---- all tiles --------------------------------------------------------------------------------------------------- */

/* Tiles, along one axis, in which low .. high matters. */
static void tiles_near(const fill *f, double low, double high, uint32_t most, uint32_t range[2])
{
    const double reach = f->atlas->options->margin + 2.0 * RIM;
    range[0] = (uint32_t)fmax(0.0, floor((low - reach) / f->side));
    range[1] = (uint32_t)fmin(most, floor((high + reach) / f->side) + 1.0);
}

static pith_status list_triangles(fill *f, pith_error *err)
{
    const atlas *a = f->atlas;
    f->first = pith_alloc((size_t)f->columns * f->rows + 2, sizeof *f->first);
    if (!f->first) return PITH_OUT_OF_MEMORY(err, "tiles of the atlas");
    for (int put = 0; put < 2; ++put) {
        uint64_t sum = 0;
        for (uint32_t t = 0; t < a->surface.triangle_count; ++t) {
            const double(*p)[2] = (const double(*)[2])a->places[t];
            uint32_t xs[2], ys[2];
            tiles_near(f, fmin(fmin(p[0][0], p[1][0]), p[2][0]), fmax(fmax(p[0][0], p[1][0]), p[2][0]), f->columns, xs);
            tiles_near(f, fmin(fmin(p[0][1], p[1][1]), p[2][1]), fmax(fmax(p[0][1], p[1][1]), p[2][1]), f->rows, ys);
            for (uint32_t y = ys[0]; y < ys[1]; ++y)
                for (uint32_t x = xs[0]; x < xs[1]; ++x, ++sum) {
                    if (put)
                        f->triangles[f->first[y * f->columns + x + 1]++] = t;
                    else
                        ++f->first[y * f->columns + x + 2];
                }
        }
        if (put) break;
        if (sum >= PITH_NONE) return PITH_OUT_OF_MEMORY(err, "triangles of tiles");
        for (size_t i = 2; i < (size_t)f->columns * f->rows + 2; ++i) f->first[i] += f->first[i - 1];
        f->triangles = pith_alloc(sum, sizeof *f->triangles);
        if (!f->triangles) return PITH_OUT_OF_MEMORY(err, "triangles of tiles");
    }
    return PITH_OK;
}

/* Tiles first .. end - 1 in parallel; of several failures the one of the lowest tile is told. */
static pith_status fill_tiles(const fill *f, uint32_t first, uint32_t end, uint64_t *filled, pith_error *err)
{
    uint32_t failed = PITH_NONE;
    pith_error worst = { .status = PITH_OK };
    uint64_t sum = 0;
#pragma omp parallel num_threads(pith_threads()) reduction(+ : sum)
    {
        tile t;
        pith_error own = { .status = PITH_OK };
        const bool ready = tile_make(&t, f, &own) == PITH_OK;
        uint32_t own_failed = ready ? PITH_NONE : first;
#pragma omp for schedule(dynamic, 1)
        for (uint32_t i = first; i < end; ++i)
            if (own_failed == PITH_NONE && fill_tile(f, &t, i, &own) != PITH_OK) own_failed = i;
#pragma omp critical(pith_fill_tiles)
        if (own_failed < failed) {
            failed = own_failed;
            worst = own;
        }
        if (ready) {
            sum = t.filled;
            tile_free(&t);
        }
    }
    *filled += sum;
    return failed == PITH_NONE ? PITH_OK : pith_fail(err, worst.status, "%s", worst.message);
}

pith_status atlas_fill(const atlas *a, const pith_progress *progress, pith_image *image, pith_atlas_report *report,
                       pith_error *err)
{
    pith_status status = PITH_OK;
    const uint32_t side = a->options->samples > 4 ? 32 : 64; /* some 70 000 samples a tile at most */
    fill f = { .atlas = a,
               .progress = progress,
               .side = side,
               .columns = (image->width + side - 1) / side,
               .rows = (image->height + side - 1) / side,
               .image = image,
               .channels = 4,
               .footprint = (float)(1.0 / (a->options->density * a->options->samples)) };
    f.weights = pith_alloc(a->surface.item_count, sizeof *f.weights);
    if (!f.weights) return PITH_OUT_OF_MEMORY(err, "the surface's tetrahedra");
    for (size_t i = 0; i < a->surface.item_count; ++i) {
        const uint32_t channels = pith_solid_channels(a->surface.items[i].solid);
        f.channels = channels > f.channels ? channels : f.channels;
        f.weights[i] = pith_alloc(a->surface.shells[i].triangle_count, sizeof *f.weights[i]);
        if (!f.weights[i]) {
            status = PITH_OUT_OF_MEMORY(err, "the surface's tetrahedra");
            goto done;
        }
        if (a->surface.shells[i].triangle_count) pith_shell_weights(a->surface.items[i].shell, f.weights[i]);
    }
    PITH_TRY_OR(done, list_triangles(&f, err));
    uint64_t filled = 0;
    const uint32_t tiles = f.columns * f.rows, group = tiles / 32 + 8;
    for (uint32_t first = 0; first < tiles; first += group) {
        PITH_TRY_OR(done, pith_progress_step(progress, 0.2 + 0.8 * first / tiles, "asking the solid", err));
        PITH_TRY_OR(done, fill_tiles(&f, first, tiles - first < group ? tiles : first + group, &filled, err));
    }
    PITH_TRY_OR(done, atlas_fill_gaps(image, err));
    report->filled = (double)filled / ((double)image->width * image->height);
done:
    for (size_t i = 0; i < a->surface.item_count; ++i) pith_free(f.weights[i]);
    pith_free(f.weights);
    pith_free(f.first);
    pith_free(f.triangles);
    return status;
}
