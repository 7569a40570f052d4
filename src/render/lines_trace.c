/* Where lines pass between pixels: a ray through every pixel, and more between two that see different things, halving
   the distance until the place is known. Tiles in parallel; a tile owns the edges that begin at its samples. */
#include "lines_internal.h"

#include <stdlib.h>
#include <string.h>

enum {
    SIDE = RENDER_TILE + 1, /* samples along a tile's side: its own, and the next tile's first */
    PAIRS = 2 * RENDER_TILE * RENDER_TILE,
    HALVINGS = 7 /* to 1/128 of a pixel */
};
_Static_assert(SIDE *SIDE <= (int)RENDER_BATCH && (int)PAIRS <= (int)RENDER_BATCH, "a tile is one batch");

static const double least_step = 1.0;  /* pixels off a surface's plane that make a silhouette */
static const double likely_step = 0.2; /* that make two neighbours worth a closer look */
static const float opaque = 0.5f;      /* less is seen through */

/* Two neighbours and what is looked for between them. */
typedef struct pair {
    lines_sample a, b;
    pith_vec2 from, to; /* where a and b are */
    uint64_t edge;
} pair;

typedef struct line_scratch {
    render_scratch *render;
    lines_sample *samples; /* [SIDE * SIDE] */
    lines_sample *middles; /* [PAIRS] */
    pith_vec2 *places;     /* [RENDER_BATCH] */
    pair *pairs, *calm;    /* [PAIRS] being looked at; those that nothing was found in yet */
} line_scratch;

/* ---- what a ray sees --------------------------------------------------------------------------------------------- */

static stretch ray_through(const lines_trace *trace, pith_vec2 spot, uint32_t index)
{
    const render_view *view = &trace->scene.view;
    const double across = spot.x - 0.5 * trace->render.width, down = spot.y - 0.5 * trace->render.height;
    const pith_vec3 to = pith_madd(pith_madd(view->forward, view->right, across), view->up, -down);
    const pith_ray ray = { view->eye, pith_unit(to), 0.0, INFINITY };
    return (stretch){ .ray = ray, .path = index, .spread = trace->pixel * pith_dot(ray.direction, view->forward) };
}

static void take_sample(const render_scratch *s, size_t i, bool colours, lines_sample *to)
{
    const place *at = &s->places[i];
    const pith_ray *ray = &s->active[i].ray;
    *to = (lines_sample){ .item = at->item,
                          .skin = at->skin,
                          .at = pith_madd(ray->origin, ray->direction, s->hits[i].distance),
                          .facet = at->facet,
                          .normal = at->normal };
    if (!colours) return;
    const double rgb[3] = { (double)at->albedo[0], (double)at->albedo[1], (double)at->albedo[2] };
    pith_oklab_from_rgb(rgb, to->lab);
}

pith_status lines_see(const lines_trace *trace, render_scratch *s, const pith_vec2 *places, size_t count,
                      lines_sample *samples, pith_error *err)
{
    for (size_t i = 0; i < count; ++i) {
        s->active[i] = ray_through(trace, places[i], (uint32_t)i);
        samples[i] = (lines_sample){ .item = PITH_NONE };
    }
    for (size_t active = count; active > 0;) {
        render_trace(&trace->scene, s, active);
        PITH_TRY(render_find_places(&trace->scene, s, active, err));
        size_t next = 0;
        for (size_t i = 0; i < active; ++i) {
            const stretch from = s->active[i];
            if (s->hits[i].triangle == PITH_NONE) continue;
            if (s->places[i].alpha >= opaque) {
                take_sample(s, i, trace->options->colours, &samples[from.path]);
            } else if (from.layer + 1 < RENDER_LAYERS) {
                s->active[next] = from;
                s->active[next].ray.nearest = s->hits[i].distance + trace->scene.offset;
                ++s->active[next++].layer;
            }
        }
        active = next;
    }
    return PITH_OK;
}

/* ---- how two samples differ -------------------------------------------------------------------------------------- */

static bool other_thing(const lines_sample *a, const lines_sample *b)
{
    return a->item != b->item || (a->item != PITH_NONE && a->skin != b->skin);
}

/* How far either place lies off the plane of the other, pixels: nothing on a plane however steep. */
static double step_between(const lines_trace *trace, const lines_sample *a, const lines_sample *b)
{
    const pith_vec3 across = pith_sub(b->at, a->at);
    const double off = fmax(fabs(pith_dot(across, a->facet)), fabs(pith_dot(across, b->facet)));
    return off / fmin(lines_pixel(trace, a->at), lines_pixel(trace, b->at));
}

static double colour_between(const lines_sample *a, const lines_sample *b)
{
    const double d[3] = { a->lab[0] - b->lab[0], a->lab[1] - b->lab[1], a->lab[2] - b->lab[2] };
    return sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
}

typedef enum search { SEARCH_STEP, SEARCH_TURN, SEARCH_COLOUR } search;

/* The difference that is looked for; other things differ more than any step does. */
static double difference(const lines_trace *trace, search what, const lines_sample *a, const lines_sample *b)
{
    if (other_thing(a, b)) return INFINITY;
    if (a->item == PITH_NONE) return 0.0;
    if (what == SEARCH_STEP) return step_between(trace, a, b);
    return what == SEARCH_TURN ? -pith_dot(a->facet, b->facet) : colour_between(a, b);
}

static bool worth_a_look(const lines_trace *trace, search what, const lines_sample *a, const lines_sample *b)
{
    const pith_line_options *o = trace->options;
    if (what == SEARCH_STEP) return difference(trace, what, a, b) > likely_step;
    if (a->item == PITH_NONE || b->item == PITH_NONE) return false;
    if (what == SEARCH_TURN) return o->creases && pith_dot(a->facet, b->facet) < cos(o->crease_angle * (M_PI / 180.0));
    return o->colours && colour_between(a, b) > o->colour_step;
}

/* Closes in on the largest difference between the samples of every pair. */
static pith_status close_in(const lines_trace *trace, line_scratch *s, search what, size_t count, pith_error *err)
{
    for (int round = 0; round < HALVINGS; ++round) {
        for (size_t i = 0; i < count; ++i)
            s->places[i] = (pith_vec2){ 0.5 * (s->pairs[i].from.x + s->pairs[i].to.x),
                                        0.5 * (s->pairs[i].from.y + s->pairs[i].to.y) };
        PITH_TRY(lines_see(trace, s->render, s->places, count, s->middles, err));
        for (size_t i = 0; i < count; ++i) {
            pair *p = &s->pairs[i];
            const double before = difference(trace, what, &p->a, &s->middles[i]);
            if (before >= difference(trace, what, &s->middles[i], &p->b)) {
                p->b = s->middles[i];
                p->to = s->places[i];
            } else {
                p->a = s->middles[i];
                p->from = s->places[i];
            }
        }
    }
    return PITH_OK;
}

/* ---- crossings ---------------------------------------------------------------------------------------------------- */

static bool add_crossing(const lines_trace *trace, lines_tile *to, const pair *p, pith_stroke_kind kind, double step)
{
    void *list = to->list;
    if (!pith_grow(&list, &to->capacity, to->count + 1, sizeof *to->list)) return false;
    to->list = list;
    const bool nothing = p->a.item == PITH_NONE || p->b.item == PITH_NONE;
    const bool second =
        p->a.item == PITH_NONE || (!nothing && lines_depth(trace, p->b.at) < lines_depth(trace, p->a.at));
    const lines_sample *near = second ? &p->b : &p->a;
    /* Where two surfaces meet both are equally near: which of them is, would be left to rounding. */
    const bool meet = !nothing && kind != PITH_STROKE_SILHOUETTE;
    const pith_vec3 normal = meet ? pith_unit(pith_add(p->a.normal, p->b.normal)) : near->normal;
    to->list[to->count++] = (lines_crossing){
        .edge = p->edge,
        .x = 0.5 * (p->from.x + p->to.x),
        .y = 0.5 * (p->from.y + p->to.y),
        .at = near->at,
        .normal = { (float)normal.x, (float)normal.y, (float)normal.z },
        .step = kind == PITH_STROKE_SILHOUETTE ? (float)step : INFINITY,
        .gap = nothing ? INFINITY : (float)pith_distance(p->a.at, p->b.at),
        .kind = (uint8_t)kind,
    };
    return true;
}

/* What a pair turned out to be once it was closed in on; false: nothing of what was looked for. */
static bool judge(const lines_trace *trace, search what, const pair *p, pith_stroke_kind *kind, double *step)
{
    const lines_sample *a = &p->a, *b = &p->b;
    const bool nothing = a->item == PITH_NONE || b->item == PITH_NONE;
    if (nothing && a->item == b->item) return false;
    *step = nothing ? INFINITY : step_between(trace, a, b);
    *kind = PITH_STROKE_SILHOUETTE;
    if (what == SEARCH_STEP) {
        if (*step >= least_step) return true;
        *kind = PITH_STROKE_RIM;
        return other_thing(a, b);
    }
    if (other_thing(a, b) || *step >= least_step) return false; /* a line of another kind, found by its own search */
    *kind = what == SEARCH_TURN ? PITH_STROKE_CREASE : PITH_STROKE_COLOUR;
    return worth_a_look(trace, what, a, b);
}

static bool wanted(const pith_line_options *o, pith_stroke_kind kind)
{
    return kind == PITH_STROKE_SILHOUETTE ? o->silhouettes : kind == PITH_STROKE_RIM ? o->rims : true;
}

/* One search among the calm pairs; what finds nothing stays, or becomes, calm. */
static pith_status search_pairs(const lines_trace *trace, line_scratch *s, search what, size_t *calm, lines_tile *to,
                                pith_error *err)
{
    size_t count = 0, kept = 0;
    for (size_t i = 0; i < *calm; ++i)
        if (worth_a_look(trace, what, &s->calm[i].a, &s->calm[i].b))
            s->pairs[count++] = s->calm[i];
        else
            s->calm[kept++] = s->calm[i];
    const size_t untouched = kept;
    /* The pairs as they were, behind the untouched: those in which nothing is found are moved up. */
    memcpy(s->calm + untouched, s->pairs, count * sizeof *s->pairs);
    PITH_TRY(close_in(trace, s, what, count, err));
    for (size_t i = 0; i < count; ++i) {
        pith_stroke_kind kind;
        double step;
        if (!judge(trace, what, &s->pairs[i], &kind, &step))
            s->calm[kept++] = s->calm[untouched + i];
        else if (wanted(trace->options, kind) && !add_crossing(trace, to, &s->pairs[i], kind, step))
            return PITH_OUT_OF_MEMORY(err, "lines");
    }
    *calm = kept;
    return PITH_OK;
}

/* ---- tiles -------------------------------------------------------------------------------------------------------- */

static void line_scratch_free(void *scratch)
{
    line_scratch *s = scratch;
    if (!s) return;
    render_scratch_free(s->render);
    pith_free(s->samples);
    pith_free(s->middles);
    pith_free(s->places);
    pith_free(s->pairs);
    pith_free(s->calm);
    pith_free(s);
}

static void *line_scratch_new(const void *of)
{
    const lines_trace *trace = of;
    line_scratch *s = pith_alloc(1, sizeof *s);
    if (!s) return NULL;
    *s = (line_scratch){ .render = render_scratch_new(&trace->scene),
                         .samples = pith_alloc(SIDE * SIDE, sizeof *s->samples),
                         .middles = pith_alloc(PAIRS, sizeof *s->middles),
                         .places = pith_alloc(RENDER_BATCH, sizeof *s->places),
                         .pairs = pith_alloc(PAIRS, sizeof *s->pairs),
                         .calm = pith_alloc(PAIRS, sizeof *s->calm) };
    if (s->render && s->samples && s->middles && s->places && s->pairs && s->calm) return s;
    line_scratch_free(s);
    return NULL;
}

static pith_vec2 place_of(uint32_t i, uint32_t j)
{
    return (pith_vec2){ (double)i + 0.5 - LINES_MARGIN, (double)j + 0.5 - LINES_MARGIN };
}

static pith_status trace_tile(const void *of, void *scratch, uint32_t tile_x, uint32_t tile_y, pith_image *grid,
                              pith_error *err)
{
    const lines_trace *trace = of;
    line_scratch *s = scratch;
    const uint32_t left = tile_x * RENDER_TILE, top = tile_y * RENDER_TILE;
    const uint32_t width = trace->wide - left < SIDE ? trace->wide - left : SIDE;
    const uint32_t height = trace->high - top < SIDE ? trace->high - top : SIDE;
    for (uint32_t k = 0; k < width * height; ++k) s->places[k] = place_of(left + k % width, top + k / width);
    PITH_TRY(lines_see(trace, s->render, s->places, width * height, s->samples, err));

    size_t calm = 0;
    for (uint32_t j = 0; j < height && j < RENDER_TILE; ++j)
        for (uint32_t i = 0; i < width && i < RENDER_TILE; ++i)
            for (uint32_t direction = 0; direction < 2; ++direction) {
                if (direction ? j + 1 == height : i + 1 == width) continue;
                const uint32_t a = j * width + i, b = a + (direction ? width : 1);
                s->calm[calm++] = (pair){ .a = s->samples[a],
                                          .b = s->samples[b],
                                          .from = place_of(left + i, top + j),
                                          .to = place_of(left + i + !direction, top + j + direction),
                                          .edge = 2 * ((uint64_t)(top + j) * trace->wide + left + i) + direction };
            }
    const uint32_t tiles_wide = (grid->width + RENDER_TILE - 1) / RENDER_TILE;
    lines_tile *to = &trace->tiles[(size_t)tile_y * tiles_wide + tile_x];
    for (search what = SEARCH_STEP; what <= SEARCH_COLOUR; ++what)
        PITH_TRY(search_pairs(trace, s, what, &calm, to, err));
    return PITH_OK;
}

/* ---- all of it ---------------------------------------------------------------------------------------------------- */

static int by_edge(const void *a, const void *b)
{
    const uint64_t x = ((const lines_crossing *)a)->edge, y = ((const lines_crossing *)b)->edge;
    return (x > y) - (x < y);
}

static pith_status gather(lines_trace *trace, size_t tiles, pith_error *err)
{
    for (size_t i = 0; i < tiles; ++i) trace->count += trace->tiles[i].count;
    trace->crossings = pith_alloc(trace->count, sizeof *trace->crossings);
    if (!trace->crossings || trace->count >= PITH_NONE / 2) return PITH_OUT_OF_MEMORY(err, "lines");
    size_t count = 0;
    for (size_t i = 0; i < tiles; ++i) {
        if (trace->tiles[i].count)
            memcpy(trace->crossings + count, trace->tiles[i].list, trace->tiles[i].count * sizeof *trace->crossings);
        count += trace->tiles[i].count;
    }
    qsort(trace->crossings, trace->count, sizeof *trace->crossings, by_edge);
    return PITH_OK;
}

pith_status lines_trace_run(lines_trace *trace, const pith_progress *progress, pith_error *err)
{
    pith_image grid = { .width = trace->wide, .height = trace->high }; /* its size alone is looked at */
    const size_t across = (trace->wide + RENDER_TILE - 1) / RENDER_TILE;
    const size_t tiles = across * ((trace->high + RENDER_TILE - 1) / RENDER_TILE);
    trace->tiles = pith_alloc(tiles, sizeof *trace->tiles);
    if (!trace->tiles) return PITH_OUT_OF_MEMORY(err, "lines");
    const render_job job = { trace, line_scratch_new, line_scratch_free, trace_tile, "finding lines" };
    pith_status status = render_job_run(&job, progress, &grid, err);
    if (status == PITH_OK) status = gather(trace, tiles, err);
    for (size_t i = 0; i < tiles; ++i) pith_free(trace->tiles[i].list);
    pith_free(trace->tiles);
    trace->tiles = NULL;
    return status;
}

pith_status lines_trace_make(lines_trace *trace, const pith_render_item *items, size_t count, const pith_camera *camera,
                             uint32_t width, uint32_t height, const pith_line_options *options, pith_error *err)
{
    *trace = (lines_trace){ .options = options,
                            .render = pith_render_options_default(),
                            .wide = width + 2 * LINES_MARGIN,
                            .high = height + 2 * LINES_MARGIN };
    trace->render.width = width;
    trace->render.height = height;
    trace->render.ground = false;
    trace->render.bounces = 0;
    trace->render.light_azimuth = options->light_azimuth;
    trace->render.light_elevation = options->light_elevation;
    PITH_TRY(render_scene_make(&trace->scene, items, count, camera, &trace->render, err));
    trace->pixel = pith_length(trace->scene.view.up);
    return PITH_OK;
}

void lines_trace_free(lines_trace *trace)
{
    render_scene_free(&trace->scene);
    pith_free(trace->crossings);
    trace->crossings = NULL;
}
