/* Digitised solid textures (Peachey 1985, section 4): a grid of values placed in the model. */
#include "patterns.h"

typedef enum table_wrap { TABLE_REPEAT, TABLE_CLAMP, TABLE_EMPTY } table_wrap;

typedef struct table_options {
    uint32_t wrap;
} table_options;

static const char *const wrap_words[] = { "repeat", "clamp", "empty", NULL };

static const pith_param table_items[] = {
    { "wrap", "1", "beyond the table: it repeats, its border goes on, or nothing (clear)", PITH_PARAM_CHOICE, 0, 0, 2,
      offsetof(table_options, wrap), wrap_words },
};
static const pith_params table_params = { "table", table_items, 1, sizeof(table_options) };

typedef struct table {
    table_wrap wrap;
    double origin[3], inverse[3]; /* inverse: 1 / edge of the whole table */
    pyramid values;
} table;

static pith_status check_grid(const pith_grid *g, pith_error *err)
{
    if (!g) return pith_fail(err, PITH_BAD_ARGUMENT, "grid: is missing; a table is made of one");
    if (!g->values || g->channels < 1 || g->size[0] < 1 || g->size[1] < 1 || g->size[2] < 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "grid: %u x %u x %u cells with %u channels hold no values",
                         (unsigned)g->size[0], (unsigned)g->size[1], (unsigned)g->size[2], (unsigned)g->channels);
    const pith_vec3 s = g->spacing;
    if (!(s.x > 0 && s.y > 0 && s.z > 0) || !pith_finite(s) || !pith_finite(g->origin))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "grid: spacing is (%g, %g, %g) from (%g, %g, %g), expected positive and finite numbers", s.x,
                         s.y, s.z, g->origin.x, g->origin.y, g->origin.z);
    return PITH_OK;
}

static pith_status table_prepare(const node_build *build, void **state, pith_error *err)
{
    const table_options *o = build->options;
    const pith_grid *g = build->node->grid;
    PITH_TRY(check_grid(g, err));
    table *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a table");
    made->wrap = (table_wrap)o->wrap;
    const double spacing[3] = { g->spacing.x, g->spacing.y, g->spacing.z };
    const double origin[3] = { g->origin.x, g->origin.y, g->origin.z };
    const uint32_t channels = g->channels < 4 ? g->channels : 4;
    pyramid_base base = {
        .values = g->values, .stride = g->channels, .channels = channels, .clear = channels == 2 || channels == 4
    };
    double squares = 0.0;
    int axes = 0;
    for (int a = 0; a < 3; ++a) {
        made->origin[a] = origin[a], made->inverse[a] = 1.0 / (spacing[a] * g->size[a]);
        base.size[a] = g->size[a], base.texel[a] = spacing[a];
        base.wrap[a] = made->wrap == TABLE_REPEAT ? WRAP_REPEAT : WRAP_CLAMP;
        if (g->size[a] > 1) squares += spacing[a] * spacing[a], ++axes;
    }
    base.spent = axes ? 0.25 * squares / axes : 0.0; /* values between cells are mixed already */
    const pith_status status = pyramid_make(&base, &made->values, err);
    if (status == PITH_OK)
        *state = made;
    else
        pith_free(made);
    return status;
}

static void table_release(void *state)
{
    table *made = state;
    if (made) pyramid_free(&made->values);
    pith_free(made);
}

static void table_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    const table *t = state;
    const lanes *at = inputs[0];
    _Alignas(32) float unit[3][LANES];
    for (int a = 0; a < 3; ++a)
        unit_places(at->v[a], count, t->origin[a], t->inverse[a], t->wrap == TABLE_REPEAT, unit[a]);
    for (uint32_t i = 0; i < count; ++i) {
        const float d = footprint_of(at, i), place[3] = { unit[0][i], unit[1][i], unit[2][i] };
        float share = 1.0f, value[4], rgba[4] = { 0 };
        if (t->wrap == TABLE_EMPTY)
            for (int a = 0; a < 3; ++a) share *= share_inside(place[a], d * BALL_BOX * (float)t->inverse[a]);
        if (share > 0.0f) {
            pyramid_at(&t->values, place, BALL_VARIANCE * d * d, value);
            spread_channels(value, t->values.channels, rgba);
            rgba[3] *= share;
        }
        for (int c = 0; c < 4; ++c) out->v[c][i] = rgba[c];
    }
}

const node_class node_table = {
    .shown = { "table",
               "A grid of values in its place: 1 channel is grey, 2 grey and opacity, 3 colour, 4 colour and opacity.",
               PITH_VALUE_COLOUR, pattern_inputs, &table_params, PITH_ASSET_GRID },
    .prepare = table_prepare,
    .run = table_run,
    .release = table_release,
};
