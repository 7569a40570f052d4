/* Packing: charts fall, tallest first, onto the skyline of those that lie already, each in the turn and at the place where
   it comes to lie lowest, its own outline fitted to the skyline (Lévy, Petitjean, Ray and Maillot, "Least Squares
   Conformal Maps", SIGGRAPH 2002, section 4). Several widths are tried; the smallest atlas is taken. */
#include "atlas_internal.h"

#include <stdlib.h>
#include <string.h>

enum { ATTEMPTS = 9 };

/* What a chart takes up with its margin: in each column the lowest row and the one above the highest, in each row the
   same of columns. */
typedef struct outline { uint32_t *low[2], *high[2]; /* [0]: by column, [1]: by row */ } outline;

typedef struct spot { uint32_t turn, x, y; } spot;

typedef struct packing {
    const atlas *atlas;
    outline *outlines;
    uint32_t *numbers;          /* all outlines' */
    uint32_t *order;            /* charts, tallest first */
    uint32_t *low, *high;       /* one outline as it is turned */
    uint32_t *skyline;
    spot *spots, *best;
} packing;

static void packing_free(packing *p)
{
    pith_free(p->outlines);
    pith_free(p->numbers);
    pith_free(p->order);
    pith_free(p->low);
    pith_free(p->high);
    pith_free(p->skyline);
    pith_free(p->spots);
    pith_free(p->best);
}

/* ---- outlines ---------------------------------------------------------------------------------------------------- */

static void widen(outline *o, int by, double at, double value)
{
    const uint32_t i = (uint32_t)at, cell = (uint32_t)value;
    if (cell < o->low[by][i]) o->low[by][i] = cell;
    if (cell + 1 > o->high[by][i]) o->high[by][i] = cell + 1;
}

/* The edge pq, seen by columns (0) or by rows (1). */
static void add_edge(outline *o, int by, const double p[2], const double q[2])
{
    const double *left = p[by] <= q[by] ? p : q, *right = p[by] <= q[by] ? q : p;
    const double run = right[by] - left[by], slope = run > 0.0 ? (right[!by] - left[!by]) / run : 0.0;
    widen(o, by, floor(left[by]), left[!by]);
    widen(o, by, floor(right[by]), right[!by]);
    for (double at = floor(left[by]) + 1.0; at <= right[by]; at += 1.0) { /* both cells at each border between two */
        const double cross = left[!by] + slope * (at - left[by]);
        const double low = fmin(left[!by], right[!by]), high = fmax(left[!by], right[!by]);
        widen(o, by, at - 1.0, fmin(high, fmax(low, cross)));
        widen(o, by, at, fmin(high, fmax(low, cross)));
    }
}

/* Wider by the margin on all sides. */
static void add_margin(uint32_t *low, uint32_t *high, uint32_t count, uint32_t margin, uint32_t *scratch)
{
    for (int side = 0; side < 2; ++side) {
        uint32_t *line = side ? high : low;
        memcpy(scratch, line, count * sizeof *line);
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t reached = scratch[i];
            for (uint32_t j = i > margin ? i - margin : 0; j < count && j <= i + margin; ++j)
                if (side ? scratch[j] > reached : scratch[j] < reached) reached = scratch[j];
            line[i] = side ? reached + margin : reached - margin;
        }
    }
}

static void make_outline(const atlas *a, const atlas_chart *chart, outline *o, uint32_t *scratch)
{
    const uint32_t size[2] = { chart->width, chart->height };
    for (int by = 0; by < 2; ++by) {
        memset(o->low[by], 0xff, size[by] * sizeof *o->low[by]);
        memset(o->high[by], 0, size[by] * sizeof *o->high[by]);
    }
    for (uint32_t i = 0; i < chart->count; ++i)
        for (int k = 0; k < 3; ++k) {
            const double (*p)[2] = (const double (*)[2])a->places[a->order[chart->first + i]];
            for (int by = 0; by < 2; ++by) add_edge(o, by, p[k], p[(k + 1) % 3]);
        }
    for (int by = 0; by < 2; ++by) add_margin(o->low[by], o->high[by], size[by], a->options->margin, scratch);
}

/* ---- placing ----------------------------------------------------------------------------------------------------- */

/* The outline by columns after quarter turns, counter-clockwise; returns the width. */
static uint32_t turn_outline(const atlas_chart *chart, const outline *o, uint32_t turn, uint32_t *low, uint32_t *high)
{
    const uint32_t w = chart->width, h = chart->height, width = turn % 2 ? h : w;
    for (uint32_t i = 0; i < width; ++i) {
        const uint32_t from = turn == 1 || turn == 2 ? width - 1 - i : i;
        const uint32_t l = o->low[turn % 2][from], u = o->high[turn % 2][from];
        low[i] = turn == 0 || turn == 1 ? l : turn == 2 ? h - u : w - u;
        high[i] = turn == 0 || turn == 1 ? u : turn == 2 ? h - l : w - l;
    }
    return width;
}

/* Height at which the outline comes to rest; not followed up once it is above `most`. */
static uint32_t rest(const packing *p, uint32_t x, uint32_t width, uint32_t most)
{
    uint32_t y = 0;
    for (uint32_t i = 0; i < width && y <= most; ++i)
        if (p->skyline[x + i] > p->low[i] + y) y = p->skyline[x + i] - p->low[i];
    return y;
}

/* Free texels shut in below the outline. */
static uint64_t waste(const packing *p, uint32_t x, uint32_t y, uint32_t width)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < width; ++i) sum += y + p->low[i] - p->skyline[x + i];
    return sum;
}

static void place_chart(packing *p, uint32_t c, uint32_t width)
{
    const atlas_chart *chart = &p->atlas->charts[c];
    uint64_t best_top = UINT64_MAX, best_waste = UINT64_MAX;
    for (uint32_t turn = 0; turn < 4; ++turn) {
        const uint32_t w = turn_outline(chart, &p->outlines[c], turn, p->low, p->high);
        const uint32_t h = turn % 2 ? chart->width : chart->height, step = w > 16 ? w / 16 : 1;
        if (w > width) continue;
        for (uint32_t i = 0; i <= (width - w + step - 1) / step; ++i) {
            const uint32_t x = i * step < width - w ? i * step : width - w;
            if (best_top < h) break;
            const uint64_t most = best_top == UINT64_MAX ? UINT32_MAX / 2 : best_top - h;
            const uint32_t y = rest(p, x, w, (uint32_t)most);
            if (y > most) continue;
            const uint64_t wasted = waste(p, x, y, w);
            if (y + (uint64_t)h == best_top && wasted >= best_waste) continue;
            best_top = y + (uint64_t)h;
            best_waste = wasted;
            p->spots[c] = (spot){ turn, x, y };
        }
    }
    const spot at = p->spots[c];
    const uint32_t w = turn_outline(chart, &p->outlines[c], at.turn, p->low, p->high);
    for (uint32_t i = 0; i < w; ++i) p->skyline[at.x + i] = at.y + p->high[i];
}

/* Height of the atlas of this width. */
static uint32_t pack_width(packing *p, uint32_t width)
{
    memset(p->skyline, 0, width * sizeof *p->skyline);
    for (size_t i = 0; i < p->atlas->chart_count; ++i) place_chart(p, p->order[i], width);
    uint32_t top = 0;
    for (uint32_t x = 0; x < width; ++x) top = p->skyline[x] > top ? p->skyline[x] : top;
    return top;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

typedef struct tall { uint32_t longest, shortest, chart; } tall;

static int by_height_down(const void *x, const void *y)
{
    const tall *a = x, *b = y;
    if (a->longest != b->longest) return a->longest > b->longest ? -1 : 1;
    if (a->shortest != b->shortest) return a->shortest > b->shortest ? -1 : 1;
    return a->chart < b->chart ? -1 : a->chart > b->chart;
}

static pith_status packing_make(packing *p, const atlas *a, pith_error *err)
{
    size_t numbers = 0;
    for (size_t c = 0; c < a->chart_count; ++c)
        numbers += 2 * ((size_t)a->charts[c].width + a->charts[c].height);
    const size_t side = a->options->max_size;
    tall *ranks = pith_alloc(a->chart_count, sizeof *ranks);
    *p = (packing){ .atlas = a,
                    .outlines = pith_alloc(a->chart_count, sizeof *p->outlines),
                    .numbers = pith_alloc(numbers, sizeof *p->numbers),
                    .order = pith_alloc(a->chart_count, sizeof *p->order),
                    .low = pith_alloc(side, sizeof *p->low),
                    .high = pith_alloc(side, sizeof *p->high),
                    .skyline = pith_alloc(side, sizeof *p->skyline),
                    .spots = pith_alloc(a->chart_count, sizeof *p->spots),
                    .best = pith_alloc(a->chart_count, sizeof *p->best) };
    if (!ranks || !p->outlines || !p->numbers || !p->order || !p->low || !p->high || !p->skyline || !p->spots ||
        !p->best) {
        pith_free(ranks);
        return PITH_OUT_OF_MEMORY(err, "packing charts");
    }
    uint32_t *at = p->numbers;
    for (size_t c = 0; c < a->chart_count; ++c) {
        const uint32_t w = a->charts[c].width, h = a->charts[c].height;
        p->outlines[c] = (outline){ { at, at + 2 * (size_t)w }, { at + w, at + 2 * (size_t)w + h } };
        at += 2 * ((size_t)w + h);
        make_outline(a, &a->charts[c], &p->outlines[c], p->skyline);
        ranks[c] = (tall){ w > h ? w : h, w > h ? h : w, (uint32_t)c };
    }
    qsort(ranks, a->chart_count, sizeof *ranks, by_height_down);
    for (size_t i = 0; i < a->chart_count; ++i) p->order[i] = ranks[i].chart;
    pith_free(ranks);
    return PITH_OK;
}

/* Moves the corners' places to where their chart lies. */
static void settle(atlas *a, const spot *spots)
{
    for (size_t c = 0; c < a->chart_count; ++c) {
        atlas_chart *chart = &a->charts[c];
        const spot at = spots[c];
        const double w = chart->width, h = chart->height;
        for (uint32_t m = 0; m < chart->count; ++m)
            for (int k = 0; k < 3; ++k) {
                double *p = a->places[a->order[chart->first + m]][k];
                const double x = p[0], y = p[1];
                p[0] = at.x + (at.turn == 0 ? x : at.turn == 1 ? h - y : at.turn == 2 ? w - x : y);
                p[1] = at.y + (at.turn == 0 ? y : at.turn == 1 ? x : at.turn == 2 ? h - y : w - x);
            }
        chart->x = at.x;
        chart->y = at.y;
        if (at.turn % 2) {
            chart->width = (uint32_t)h;
            chart->height = (uint32_t)w;
        }
    }
}

/* Sides are multiples of four, which block compression and row alignment like. */
static uint32_t round_up(uint32_t side, uint32_t most)
{
    const uint32_t rounded = (side + 3) / 4 * 4;
    return rounded < most ? rounded : most;
}

pith_status atlas_pack(atlas *a, bool *fits, pith_error *err)
{
    packing p;
    const pith_status status = packing_make(&p, a, err);
    double texels = 0.0;
    uint32_t narrowest = 1;
    for (size_t c = 0; status == PITH_OK && c < a->chart_count; ++c) {
        const atlas_chart *chart = &a->charts[c];
        const uint32_t shorter = chart->width < chart->height ? chart->width : chart->height;
        for (uint32_t x = 0; x < chart->width; ++x) texels += p.outlines[c].high[0][x] - p.outlines[c].low[0][x];
        narrowest = shorter > narrowest ? shorter : narrowest;
    }
    const uint32_t most = a->options->max_size;
    uint64_t best = UINT64_MAX;
    for (int i = 0; status == PITH_OK && i <= ATTEMPTS; ++i) {
        if (i == ATTEMPTS && best != UINT64_MAX) break; /* the widest of all is for when nothing else does */
        const double wanted = i < ATTEMPTS ? sqrt(texels / 0.85) * (0.8 + 0.5 * i / (ATTEMPTS - 1)) : most;
        uint32_t width = wanted >= most ? most : (uint32_t)wanted + 1;
        width = round_up(width > narrowest ? width : narrowest, most);
        const uint32_t top = pack_width(&p, width);
        if (top > most) continue;
        const uint32_t height = round_up(top, most);
        if ((uint64_t)width * height >= best) continue;
        best = (uint64_t)width * height;
        a->width = width;
        a->height = height;
        memcpy(p.best, p.spots, a->chart_count * sizeof *p.best);
    }
    *fits = best != UINT64_MAX;
    if (status == PITH_OK && *fits) settle(a, p.best);
    packing_free(&p);
    return status;
}
