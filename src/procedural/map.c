/* Colour maps: a number becomes a colour. */
#include "node.h"

/* Colours of so many numbers are worked out beforehand; between them they are mixed. */
enum { ENTRIES = 1024 };

typedef struct map_state {
    float low, scale, entries[ENTRIES + 1][4];
} map_state;

typedef struct map_options {
    bool smooth;
} map_options;
static const pith_param map_items[] = {
    { "smooth", "1", "colours go over into one another; else each stays until the next begins", PITH_PARAM_BOOL, 0, 1,
      1, offsetof(map_options, smooth), NULL },
};
static const pith_params map_params = { "map", map_items, 1, sizeof(map_options) };
static const pith_input map_inputs[] = {
    { .name = "by", .help = "the number", .takes = PITH_VALUE_NUMBER, .wanted = true },
    { .name = NULL },
};

static pith_status check_stops(const node_build *build, pith_error *err)
{
    const pith_node *node = build->node;
    if (node->stop_count == 0) return pith_fail(err, PITH_BAD_ARGUMENT, "stops: there are none, expected one or more");
    for (size_t k = 0; k < node->stop_count; ++k) {
        const pith_stop *stop = &node->stops[k];
        if (!isfinite(stop->at)) return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu].at: is not a finite number", k);
        if (k > 0 && stop->at < stop[-1].at)
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "stops[%zu].at: is %g, below that of the one before (%g); stops "
                             "ascend",
                             k, stop->at, stop[-1].at);
        for (int c = 0; c < 4; ++c)
            if (!isfinite(stop->colour[c]))
                return pith_fail(err, PITH_BAD_ARGUMENT, "stops[%zu].colour: is not of finite numbers", k);
    }
    return PITH_OK;
}

static void colour_at(const pith_node *node, bool smooth, double at, float colour[4])
{
    size_t next = 0;
    while (next < node->stop_count && node->stops[next].at <= at) ++next;
    const pith_stop *a = &node->stops[next > 0 ? next - 1 : 0];
    const pith_stop *b = &node->stops[next < node->stop_count ? next : node->stop_count - 1];
    const double t = smooth && b->at > a->at ? (at - a->at) / (b->at - a->at) : 0.0;
    for (int c = 0; c < 4; ++c) colour[c] = (float)(a->colour[c] + t * (b->colour[c] - a->colour[c]));
}

static pith_status prepare_map(const node_build *build, void **state, pith_error *err)
{
    const pith_node *node = build->node;
    map_state *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a colour map");
    const double low = node->stops[0].at, span = node->stops[node->stop_count - 1].at - low;
    made->low = (float)low;
    made->scale = span > 0.0 ? (float)(ENTRIES / span) : 0.0f;
    const bool smooth = ((const map_options *)build->options)->smooth;
    for (int k = 0; k <= ENTRIES; ++k) colour_at(node, smooth, low + span * k / ENTRIES, made->entries[k]);
    *state = made;
    return PITH_OK;
}

static void run_map(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    const map_state *own = state;
    (void)input_count;
    for (uint32_t i = 0; i < count; ++i) {
        const float at = fminf(fmaxf((inputs[0]->v[0][i] - own->low) * own->scale, 0.0f), (float)ENTRIES);
        const int k = at < ENTRIES ? (int)at : ENTRIES - 1;
        const float part = at - (float)k, *a = own->entries[k], *b = own->entries[k + 1];
        for (int c = 0; c < 4; ++c) out->v[c][i] = a[c] + part * (b[c] - a[c]);
    }
}

const node_class node_map = {
    .shown = { "map", "The colour that belongs to a number.", PITH_VALUE_COLOUR, map_inputs, &map_params,
               PITH_ASSET_STOPS },
    .check = check_stops,
    .prepare = prepare_map,
    .run = run_map,
};
