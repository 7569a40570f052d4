/* Shapes of bombs from tables: exact edges under small footprints, means under large ones. */
#include "bomb_shape.h"

/* The field at a place, and its gradient. Beyond the middles of the outermost cells it goes on as there. */
static float field_at(const bomb_shape *s, const float at[3], float gradient[3])
{
    uint32_t cell[3][2];
    float w[3], v[8];
    for (int a = 0; a < 3; ++a) {
        const float last = (float)(s->size[a] - 1);
        float place = at[a] * (float)s->size[a] - 0.5f;
        place = place > 0.0f ? (place < last ? place : last) : 0.0f;
        cell[a][0] = (uint32_t)place;
        cell[a][1] = cell[a][0] + 1 < s->size[a] ? cell[a][0] + 1 : cell[a][0];
        w[a] = place - (float)cell[a][0];
    }
    for (int c = 0; c < 8; ++c)
        v[c] = s->field[(((size_t)cell[2][c >> 2] * s->size[1] + cell[1][c >> 1 & 1]) * s->size[0] + cell[0][c & 1]) *
                        s->stride];
    /* Down to the four edges along x, the two faces, the point; slopes of what is left are differences. */
    float x[4], y[2];
    for (int c = 0; c < 4; ++c) x[c] = v[2 * c] + w[0] * (v[2 * c + 1] - v[2 * c]);
    for (int c = 0; c < 2; ++c) y[c] = x[2 * c] + w[1] * (x[2 * c + 1] - x[2 * c]);
    const float low = (1.0f - w[1]) * (v[1] - v[0]) + w[1] * (v[3] - v[2]);
    const float high = (1.0f - w[1]) * (v[5] - v[4]) + w[1] * (v[7] - v[6]);
    gradient[0] = ((1.0f - w[2]) * low + w[2] * high) * (float)s->size[0];
    gradient[1] = ((1.0f - w[2]) * (x[1] - x[0]) + w[2] * (x[3] - x[2])) * (float)s->size[1];
    gradient[2] = (y[1] - y[0]) * (float)s->size[2];
    return y[0] + w[2] * (y[1] - y[0]);
}

static inline float depth_of(float value) { return clamp_unit(2.0f * value - 1.0f); }

/* What each cell holds, from parts³ places in it. */
static void fill_cells(bomb_shape *s, int parts)
{
    const size_t rows = (size_t)s->size[1] * s->size[2];
    const float part = 1.0f / (float)(parts * parts * parts);
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (rows * s->size[0] > 10000)
    for (size_t r = 0; r < rows; ++r)
        for (uint32_t i = 0; i < s->size[0]; ++i) {
            const size_t cell[3] = { i, r % s->size[1], r / s->size[1] };
            float cover = 0.0f, depth = 0.0f, gradient[3];
            for (int n = 0; n < parts * parts * parts; ++n) {
                const int step[3] = { n % parts, n / parts % parts, n / parts / parts };
                float at[3];
                for (int a = 0; a < 3; ++a)
                    at[a] = ((float)cell[a] + ((float)step[a] + 0.5f) / (float)parts) / (float)s->size[a];
                const float value = field_at(s, at, gradient);
                cover += value >= 0.5f ? part : 0.0f, depth += part * depth_of(value);
            }
            s->cells[2 * (r * s->size[0] + i)] = cover, s->cells[2 * (r * s->size[0] + i) + 1] = depth;
        }
}

pith_status bomb_shape_make(const pith_grid *grid, bomb_shape *shape, pith_error *err)
{
    const uint32_t channels = grid->channels;
    if (channels != 1 && channels != 2 && channels != 4)
        return pith_fail(
            err, PITH_BAD_ARGUMENT,
            "grid: has %u channels; the shape of a bomb is a grid with 1, or the opacity of one with 2 or 4",
            (unsigned)channels);
    if (!grid->values || grid->size[0] < 1 || grid->size[1] < 1 || grid->size[2] < 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "grid: is empty");
    bomb_shape s = { .field = grid->values + (channels == 1 ? 0 : channels - 1), .stride = channels };
    pyramid_base base = { .stride = 2, .channels = 2, .wrap = { WRAP_CLAMP, WRAP_CLAMP, WRAP_CLAMP } };
    for (int a = 0; a < 3; ++a) {
        s.size[a] = base.size[a] = grid->size[a], base.texel[a] = 1.0 / grid->size[a];
        s.texel += (float)base.texel[a] / 3.0f;
    }
    const size_t cells = (size_t)s.size[0] * s.size[1] * s.size[2];
    s.cells = pith_alloc(cells, 2 * sizeof *s.cells);
    if (!s.cells) return PITH_OUT_OF_MEMORY(err, "the shape of bombs");
    fill_cells(&s, cells <= 32 * 32 * 32 ? 4 : 2);
    base.values = s.cells;
    const pith_status status = pyramid_make(&base, &s.means, err);
    if (status == PITH_OK)
        *shape = s;
    else
        pith_free(s.cells);
    return status;
}

void bomb_shape_free(bomb_shape *shape)
{
    pyramid_free(&shape->means);
    pith_free(shape->cells);
}

/* Of a ball that a plane cuts e radii from its middle, the share on the far side. */
static inline float cap_share(float e)
{
    const float held = e > -1.0f ? (e < 1.0f ? e : 1.0f) : -1.0f;
    return 0.25f * (1.0f - held) * (1.0f - held) * (2.0f + held);
}

bomb_hit bomb_shape_at(const bomb_shape *s, const float at[3], float footprint)
{
    bomb_hit h = { 0.0f, 0.0f };
    float share = 1.0f;
    for (int a = 0; a < 3; ++a) share *= share_inside(at[a], footprint * BALL_BOX);
    if (!(share > 0.0f)) return h;
    /* Up to a cell the edge is a plane as far away as the field's slope says; from sqrt 5 cells on, the means' own
       filter, they answer alone. */
    const float wide = footprint / s->texel, mean = clamp_unit((wide - 1.0f) / 1.236f),
                soft = clamp_unit(0.2f * wide * wide);
    if (mean < 1.0f) {
        float g[3];
        const float above = field_at(s, at, g) - 0.5f, slope = sqrtf(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        const float reach = 0.5f * footprint * slope;
        h.cover = reach > 1e-6f ? cap_share(-above / reach) : above >= 0.0f ? 1.0f : 0.0f;
        h.depth = clamp_unit(2.0f * above);
    }
    if (soft > 0.0f) {
        float cells[2];
        pyramid_at(&s->means, at, BALL_VARIANCE * footprint * footprint, cells);
        h.cover += mean * (cells[0] - h.cover), h.depth += soft * (cells[1] - h.depth);
    }
    h.cover *= share, h.depth *= share;
    return h;
}
