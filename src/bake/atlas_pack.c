/* Packing: charts, largest first, each in the turn and at the place where it comes to lie lowest, then leftmost, between
   those that lie already, holes among them (bottom-left; Baker, Coffman and Rivest, "Orthogonal packings in two
   dimensions", SIAM Journal on Computing 9(4), 1980, with outlines instead of boxes). Places are multiples of a cell;
   several widths are tried, and the smallest atlas is taken. */
#include "atlas_internal.h"

#include <stdlib.h>
#include <string.h>

enum { ATTEMPTS = 12, CELLS = 400, HINTS = 48 };

/* What a chart takes up with its margin: in each column the lowest row and the one above the highest, in each row the
   same of columns. */
typedef struct outline {
    uint32_t *low[2], *high[2]; /* [0]: by column, [1]: by row */
} outline;

typedef struct spot {
    uint32_t turn, x, y;
} spot; /* texels */

typedef struct packing {
    const atlas *atlas;
    outline *outlines;
    uint32_t *numbers;            /* all outlines' */
    uint32_t *order;              /* charts, largest first */
    uint32_t cell, width, height; /* texels of a cell's side; cells across the atlas, and room upwards */
    uint16_t *room;               /* [height][width] free cells from here to the right */
    uint32_t *low, *high; /* one turned outline in cells: in each row the first column and the one after the last */
    uint32_t *hints;      /* [HINTS][HINTS] by size in cells: below, one of this size found no place */
    spot *spots, *best;
} packing;

static void packing_free(packing *p)
{
    pith_free(p->outlines);
    pith_free(p->numbers);
    pith_free(p->order);
    pith_free(p->room);
    pith_free(p->low);
    pith_free(p->high);
    pith_free(p->hints);
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
            const double(*p)[2] = (const double(*)[2])a->places[a->order[chart->first + i]];
            for (int by = 0; by < 2; ++by) add_edge(o, by, p[k], p[(k + 1) % 3]);
        }
    for (int by = 0; by < 2; ++by) add_margin(o->low[by], o->high[by], size[by], a->options->margin, scratch);
}

/* ---- placing ----------------------------------------------------------------------------------------------------- */

/* The outline by rows after quarter turns, counter-clockwise, in cells; size: columns and rows. */
static void turn_outline(const packing *p, const atlas_chart *chart, const outline *o, uint32_t turn, uint32_t size[2])
{
    const uint32_t across = turn % 2 ? chart->height : chart->width, up = turn % 2 ? chart->width : chart->height;
    const bool by_row = turn % 2 == 0, upside_down = turn == 2 || turn == 3, mirrored = turn == 1 || turn == 2;
    size[0] = (across + p->cell - 1) / p->cell;
    size[1] = (up + p->cell - 1) / p->cell;
    memset(p->low, 0xff, size[1] * sizeof *p->low);
    memset(p->high, 0, size[1] * sizeof *p->high);
    for (uint32_t i = 0; i < up; ++i) {
        const uint32_t from = upside_down ? up - 1 - i : i, row = i / p->cell;
        const uint32_t l = o->low[by_row][from], h = o->high[by_row][from];
        const uint32_t low = (mirrored ? across - h : l) / p->cell;
        const uint32_t high = ((mirrored ? across - l : h) + p->cell - 1) / p->cell;
        p->low[row] = low < p->low[row] ? low : p->low[row];
        p->high[row] = high > p->high[row] ? high : p->high[row];
    }
}

/* The first column from x on at which the turned outline fits in rows y and up; PITH_NONE. */
static uint32_t fit_row(const packing *p, uint32_t y, const uint32_t size[2])
{
    uint32_t x = 0;
    for (uint32_t row = 0; row < size[1];) {
        if (x + size[0] > p->width) return PITH_NONE;
        const uint16_t *room = p->room + (size_t)(y + row) * p->width;
        const uint32_t first = x + p->low[row], wanted = p->high[row] - p->low[row];
        if (room[first] >= wanted) {
            ++row;
            continue;
        }
        uint32_t free = first + room[first]; /* taken here: on behind that, from the first row again */
        while (free < p->width && room[free] == 0) ++free;
        x = free - p->low[row];
        row = 0;
    }
    return x;
}

/* Marks the cells of a placed outline. */
static void take_cells(packing *p, uint32_t x, uint32_t y, const uint32_t size[2])
{
    for (uint32_t row = 0; row < size[1]; ++row) {
        uint16_t *room = p->room + (size_t)(y + row) * p->width;
        const uint32_t first = x + p->low[row], end = x + p->high[row];
        for (uint32_t i = first; i < end; ++i) room[i] = 0;
        for (uint32_t i = first; i > 0 && room[i - 1] > 0; --i) room[i - 1] = (uint16_t)(first - i + 1);
    }
}

/* False when there is no place below the room's end. */
static bool place_chart(packing *p, uint32_t c)
{
    const atlas_chart *chart = &p->atlas->charts[c];
    uint32_t best_top = p->height + 1, size[2];
    for (uint32_t turn = 0; turn < 4; ++turn) {
        turn_outline(p, chart, &p->outlines[c], turn, size);
        const bool small = size[0] < HINTS && size[1] < HINTS;
        uint32_t *hint = small ? &p->hints[size[0] * HINTS + size[1]] : NULL;
        for (uint32_t y = hint ? *hint : 0; size[0] <= p->width && y + size[1] < best_top; ++y) {
            const uint32_t x = fit_row(p, y, size);
            if (x == PITH_NONE) continue;
            best_top = y + size[1];
            p->spots[c] = (spot){ turn, x * p->cell, y * p->cell };
            if (hint) *hint = y;
        }
    }
    if (best_top > p->height) return false;
    const spot at = p->spots[c];
    turn_outline(p, chart, &p->outlines[c], at.turn, size);
    take_cells(p, at.x / p->cell, at.y / p->cell, size);
    return true;
}

/* Packs into this width and at most this height, texels; what it needs of both goes to used. PITH_OK with false: it is
   not enough. */
static pith_status pack_into(packing *p, uint32_t width, uint32_t height, uint32_t used[2], bool *enough,
                             pith_error *err)
{
    p->width = width / p->cell;
    p->height = height / p->cell;
    p->room = pith_alloc((size_t)p->width * p->height, sizeof *p->room);
    if (!p->room) return PITH_OUT_OF_MEMORY(err, "packing charts");
    for (size_t i = 0; i < (size_t)p->width * p->height; ++i) p->room[i] = (uint16_t)(p->width - i % p->width);
    memset(p->hints, 0, HINTS * HINTS * sizeof *p->hints);
    used[0] = used[1] = 0;
    *enough = true;
    for (size_t i = 0; *enough && i < p->atlas->chart_count; ++i) {
        const uint32_t c = p->order[i];
        *enough = place_chart(p, c);
        if (!*enough) break;
        const spot at = p->spots[c];
        const uint32_t size[2] = { p->atlas->charts[c].width, p->atlas->charts[c].height };
        const uint32_t right = at.x + size[at.turn % 2], top = at.y + size[1 - at.turn % 2];
        used[0] = right > used[0] ? right : used[0];
        used[1] = top > used[1] ? top : used[1];
    }
    pith_free(p->room);
    p->room = NULL;
    return PITH_OK;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

typedef struct ranked {
    uint32_t size, chart;
} ranked; /* size: half the box's rim */

static int by_size_down(const void *x, const void *y)
{
    const ranked *a = x, *b = y;
    if (a->size != b->size) return a->size > b->size ? -1 : 1;
    return a->chart < b->chart ? -1 : a->chart > b->chart;
}

static pith_status packing_make(packing *p, const atlas *a, pith_error *err)
{
    size_t numbers = 0;
    for (size_t c = 0; c < a->chart_count; ++c) numbers += 2 * ((size_t)a->charts[c].width + a->charts[c].height);
    const size_t side = a->options->max_size;
    ranked *ranks = pith_alloc(a->chart_count, sizeof *ranks);
    *p = (packing){ .atlas = a,
                    .outlines = pith_alloc(a->chart_count, sizeof *p->outlines),
                    .numbers = pith_alloc(numbers, sizeof *p->numbers),
                    .order = pith_alloc(a->chart_count, sizeof *p->order),
                    .low = pith_alloc(side, sizeof *p->low),
                    .high = pith_alloc(side, sizeof *p->high),
                    .hints = pith_alloc(HINTS * HINTS, sizeof *p->hints),
                    .spots = pith_alloc(a->chart_count, sizeof *p->spots),
                    .best = pith_alloc(a->chart_count, sizeof *p->best) };
    if (!ranks || !p->outlines || !p->numbers || !p->order || !p->low || !p->high || !p->hints || !p->spots ||
        !p->best) {
        pith_free(ranks);
        return PITH_OUT_OF_MEMORY(err, "packing charts");
    }
    uint32_t *at = p->numbers;
    for (size_t c = 0; c < a->chart_count; ++c) {
        const uint32_t w = a->charts[c].width, h = a->charts[c].height;
        p->outlines[c] = (outline){ { at, at + 2 * (size_t)w }, { at + w, at + 2 * (size_t)w + h } };
        at += 2 * ((size_t)w + h);
        make_outline(a, &a->charts[c], &p->outlines[c], p->low);
        ranks[c] = (ranked){ w + h, (uint32_t)c };
    }
    qsort(ranks, a->chart_count, sizeof *ranks, by_size_down);
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

/* What all charts take up: texels, the width below which one does not fit, and how large they are in the mean. */
typedef struct demand {
    double texels, longest;
    uint32_t narrowest;
} demand;

static demand measure(const packing *p)
{
    demand d = { .narrowest = 1 };
    for (size_t c = 0; c < p->atlas->chart_count; ++c) {
        const uint32_t w = p->atlas->charts[c].width, h = p->atlas->charts[c].height;
        for (uint32_t x = 0; x < w; ++x) d.texels += p->outlines[c].high[0][x] - p->outlines[c].low[0][x];
        d.longest += (double)(w > h ? w : h) / (double)p->atlas->chart_count;
        d.narrowest = (w < h ? w : h) > d.narrowest ? (w < h ? w : h) : d.narrowest;
    }
    return d;
}

/* Cells are small beside the atlas and beside the charts. */
static uint32_t choose_cell(double side, double longest)
{
    return (uint32_t)fmax(1.0, fmin(side / CELLS, longest / 12.0));
}

pith_status atlas_pack(atlas *a, bool *fits, pith_error *err)
{
    packing p;
    pith_status status = packing_make(&p, a, err);
    uint64_t best = UINT64_MAX;
    const uint32_t most = a->options->max_size;
    const demand d = status == PITH_OK ? measure(&p) : (demand){ 0 };
    const double side = sqrt(d.texels / 0.88);
    for (int i = 0; status == PITH_OK && i <= ATTEMPTS; ++i) {
        const bool last = i == ATTEMPTS; /* all there may be is for when nothing less does */
        if (last && best != UINT64_MAX) break;
        p.cell = choose_cell(last ? most : side, d.longest);
        const double wanted = fmax(side * (0.75 + 0.5 * i / (ATTEMPTS - 1)), (double)d.narrowest) + p.cell;
        const double width = last ? most : fmin(most, wanted), height = last ? most : fmin(most, 3.0 * side + p.cell);
        uint32_t used[2] = { 0, 0 };
        bool enough = false;
        status = pack_into(&p, (uint32_t)width, (uint32_t)height, used, &enough, err);
        if (status != PITH_OK || !enough) continue;
        for (int k = 0; k < 2; ++k) used[k] = round_up(used[k], most);
        if ((uint64_t)used[0] * used[1] >= best) continue;
        best = (uint64_t)used[0] * used[1];
        a->width = used[0];
        a->height = used[1];
        memcpy(p.best, p.spots, a->chart_count * sizeof *p.best);
    }
    *fits = best != UINT64_MAX;
    if (status == PITH_OK && *fits) settle(a, p.best);
    packing_free(&p);
    return status;
}
