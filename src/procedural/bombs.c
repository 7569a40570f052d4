/* Bombing in three dimensions (Peachey 1985, section 4.1; Schachter and Ahuja, "Random pattern generation processes",
   CGIP 10, 1979): balls, or shapes given as small tables, dropped at random places of a cube that repeats. A grid of
   cells with lists replaces the search through all bombs. Inside, the cube has the edge 1. */
#include "bomb_shape.h"

#include <string.h>

typedef enum bombs_what { BOMBS_INSIDE, BOMBS_DEPTH, BOMBS_NUMBER } bombs_what;

typedef struct bombs_options {
    uint32_t count;
    double period, lowest, highest, slope;
    uint32_t what;
    uint64_t seed;
} bombs_options;

static const char *const what_words[] = { "inside", "depth", "number", NULL };

static const pith_param bombs_items[] = {
    { "count", "1", "bombs dropped into one period", PITH_PARAM_UINT, 1, 200, 100000, offsetof(bombs_options, count),
      NULL },
    { "period", "model units", "edge of the cube that repeats", PITH_PARAM_DOUBLE, 1e-6, 1, 1e6,
      offsetof(bombs_options, period), NULL },
    { "lowest", "model units", "least radius; of a table half its edge", PITH_PARAM_DOUBLE, 1e-9, 0.03, 1e6,
      offsetof(bombs_options, lowest), NULL },
    { "highest", "model units", "greatest radius", PITH_PARAM_DOUBLE, 1e-9, 0.08, 1e6, offsetof(bombs_options, highest),
      NULL },
    { "slope", "1", "how rare large bombs are: numbers fall with the radius to this power; 0: all radii alike",
      PITH_PARAM_DOUBLE, 0, 0, 8, offsetof(bombs_options, slope), NULL },
    { "what", "1",
      "inside: 1 in bombs, 0 beside them; depth: from 0 at the edge to 1 in the middle; number: 0 to 1, of the bomb on "
      "top",
      PITH_PARAM_CHOICE, 0, 0, 2, offsetof(bombs_options, what), what_words },
    { "seed", "1", "another seed, other bombs", PITH_PARAM_SEED, 0, 1, 9007199254740992.0,
      offsetof(bombs_options, seed), NULL },
};
static const pith_params bombs_params = { "bombs", bombs_items, sizeof bombs_items / sizeof *bombs_items,
                                          sizeof(bombs_options) };

typedef struct bomb {
    pith_vec3 middle;
    double radius, reach; /* reach: of the ball that holds it */
    float number;         /* in 0..1, the bomb's own */
    float turn[3][3];     /* of a table: rows, from the cube to the table's unit cube about its middle */
} bomb;

/* A bomb, or a copy of it beyond the border, as a cell sees it. */
typedef struct drop {
    float middle[3], radius;
    uint32_t bomb;
} drop;

typedef struct bombs {
    bombs_what what;
    double inverse;  /* 1 / period */
    uint32_t cells;  /* along an edge */
    uint32_t *start; /* [cells³ + 1] into drops */
    drop *drops;     /* of each cell, the last dropped first: it lies on top */
    bomb *bombs;     /* [count] */
    bool tables;
    bomb_shape shape; /* the table's */
    float *texels;    /* base of the pyramid: 1 channel, or number * cover and cover */
    pyramid means;    /* for footprints that reach beyond the lists */
    float listed;     /* footprints up to this one are answered from the lists */
} bombs;

/* ---- one bomb under a filter ------------------------------------------------------------------------------------- */

/* The integral of (1 + k v)(1 - v²)(a - b v). */
static inline double shell_sum(double v, double k, double a, double b)
{
    const double c1 = k * a - b, c2 = -k * b - a, c4 = k * b;
    return v * (a + v * (0.5 * c1 + v * (c2 / 3.0 + v * (-0.25 * c1 + v * 0.2 * c4))));
}

/* The mean of g(s) = a - b s (s < r, else 0) over a ball of radius R at distance d from the middle of g. Of the
   sphere of radius s = d + R v, the share (R² - (s - d)²) / (4 s d) lies in the ball; spheres up to R - d lie in it as
   a whole. Exact. */
static double mean_over_ball(double d, double R, double r, double a, double b)
{
    const double inner = d < R ? fmin(R - d, r) : 0.0, t = inner / R;
    double sum = t * t * t * (a - 0.75 * b * inner);
    if (d > 1e-4 * R) {
        const double from = d < R ? 1.0 - 2.0 * d / R : -1.0, to = fmin(1.0, (r - d) / R), k = R / d;
        if (to > from) sum += 0.75 * (shell_sum(to, k, a - b * d, b * R) - shell_sum(from, k, a - b * d, b * R));
    }
    return sum;
}

static inline bomb_hit hit_ball(const drop *b, const float p[3], float diameter, bool depth)
{
    const float x = p[0] - b->middle[0], y = p[1] - b->middle[1], z = p[2] - b->middle[2], r = b->radius;
    const float square = x * x + y * y + z * z, R = 0.5f * diameter;
    bomb_hit h = { 0.0f, 0.0f };
    if (!(square < (r + R) * (r + R))) return h;
    const float d = sqrtf(square);
    if (d + R <= r && (d >= R || !depth)) { /* wholly inside; the mean distance over a ball is d + R² / 5d */
        h.cover = 1.0f;
        if (depth) h.depth = 1.0f - (R > 0.0f ? d + 0.2f * R * R / d : d) / r;
        return h;
    }
    h.cover = clamp_unit((float)mean_over_ball((double)d, (double)R, (double)r, 1.0, 0.0));
    if (depth) h.depth = clamp_unit((float)mean_over_ball((double)d, (double)R, (double)r, 1.0, 1.0 / (double)r));
    return h;
}

static bomb_hit hit_table(const bombs *all, const drop *one, const float p[3], float diameter)
{
    const bomb *b = &all->bombs[one->bomb];
    const float from[3] = { p[0] - one->middle[0], p[1] - one->middle[1], p[2] - one->middle[2] };
    float at[3];
    for (int a = 0; a < 3; ++a)
        at[a] = 0.5f + b->turn[a][0] * from[0] + b->turn[a][1] * from[1] + b->turn[a][2] * from[2];
    return bomb_shape_at(&all->shape, at, diameter / (2.0f * one->radius));
}

/* ---- all bombs at a place ---------------------------------------------------------------------------------------- */

/* From the lists: out[0] the answer, for a number out[0] = number * cover and out[1] = cover. Bombs are taken to cover
   a footprint independently of each other: what is left clear is the product of what each leaves. */
INLINE void listed_at(const bombs *all, const float p[3], float diameter, bombs_what what, bool tables, float out[2])
{
    const float n = (float)all->cells;
    uint32_t cell[3];
    for (int a = 0; a < 3; ++a) {
        cell[a] = (uint32_t)(p[a] * n);
        cell[a] = cell[a] < all->cells ? cell[a] : all->cells - 1;
    }
    const size_t at = ((size_t)cell[2] * all->cells + cell[1]) * all->cells + cell[0];
    float clear = 1.0f, sum = 0.0f;
    for (uint32_t i = all->start[at]; i < all->start[at + 1] && clear > 0.0f; ++i) {
        const drop *d = &all->drops[i];
        const bomb_hit h = tables ? hit_table(all, d, p, diameter) : hit_ball(d, p, diameter, what == BOMBS_DEPTH);
        const float share = what == BOMBS_DEPTH ? h.depth : h.cover;
        if (what == BOMBS_NUMBER && share > 0.0f) sum += clear * share * all->bombs[d->bomb].number;
        clear *= 1.0f - share;
    }
    out[0] = what == BOMBS_NUMBER ? sum : 1.0f - clear;
    out[1] = 1.0f - clear;
}

static void ask_lists(const bombs *all, const float p[3], float diameter, float out[2])
{
    switch (all->what) {
    case BOMBS_INSIDE:
        all->tables ? listed_at(all, p, diameter, BOMBS_INSIDE, true, out)
                    : listed_at(all, p, diameter, BOMBS_INSIDE, false, out);
        break;
    case BOMBS_DEPTH:
        all->tables ? listed_at(all, p, diameter, BOMBS_DEPTH, true, out)
                    : listed_at(all, p, diameter, BOMBS_DEPTH, false, out);
        break;
    case BOMBS_NUMBER:
        all->tables ? listed_at(all, p, diameter, BOMBS_NUMBER, true, out)
                    : listed_at(all, p, diameter, BOMBS_NUMBER, false, out);
        break;
    }
}

/* ---- preparing --------------------------------------------------------------------------------------------------- */

/* Uniform among rotations (Shoemake, Graphics Gems III, 1992), scaled so that the table's cube becomes the unit cube.
   */
static void random_turn(pith_rng *rng, double radius, float turn[3][3])
{
    const double u = pith_rng_unit(rng), a = 6.283185307179586 * pith_rng_unit(rng),
                 b = 6.283185307179586 * pith_rng_unit(rng), p = sqrt(1.0 - u), q = sqrt(u);
    const double x = p * sin(a), y = p * cos(a), z = q * sin(b), w = q * cos(b), k = 0.5 / radius;
    const double rows[3][3] = {
        { 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w) },
        { 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w) },
        { 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y) },
    };
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) turn[i][j] = (float)(k * rows[i][j]);
}

/* A radius with a density that falls as radius^-slope between two. */
static double random_radius(const bombs_options *o, double u)
{
    const double ratio = o->highest / o->lowest, e = 1.0 - o->slope;
    if (fabs(e) < 1e-9) return o->lowest * pow(ratio, u);
    return o->lowest * pow(1.0 + u * (pow(ratio, e) - 1.0), 1.0 / e);
}

/* Each bomb has its own stream: it stays what it is when others are added. */
static void drop_bombs(const node_build *build, const bombs_options *o, bombs *all)
{
    for (uint32_t i = 0; i < o->count; ++i) {
        pith_rng rng = pith_rng_make(node_seed(build, o->seed), i);
        bomb *b = &all->bombs[i];
        b->middle.x = pith_rng_unit(&rng);
        b->middle.y = pith_rng_unit(&rng);
        b->middle.z = pith_rng_unit(&rng);
        b->radius = random_radius(o, pith_rng_unit(&rng)) * all->inverse;
        b->number = (float)pith_rng_below(&rng, 1u << 24) * 0x1p-24f;
        b->reach = b->radius;
        if (!all->tables) continue;
        b->reach = b->radius * sqrt(3.0);
        random_turn(&rng, b->radius, b->turn);
    }
}

/* Calls for every cell that a bomb, widened by margin, reaches: counts them in start[cell + 1] or fills them in at
   start[cell]++. */
static void list_bomb(bombs *all, uint32_t index, double margin, bool fill)
{
    const bomb *b = &all->bombs[index];
    const int64_t n = all->cells;
    const double edge = 1.0 / (double)n, reach = b->reach + margin, c[3] = { b->middle.x, b->middle.y, b->middle.z };
    int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a)
        low[a] = (int64_t)floor((c[a] - reach) / edge), high[a] = (int64_t)floor((c[a] + reach) / edge);
    int64_t at[3];
    for (at[2] = low[2]; at[2] <= high[2]; ++at[2])
        for (at[1] = low[1]; at[1] <= high[1]; ++at[1])
            for (at[0] = low[0]; at[0] <= high[0]; ++at[0]) {
                double square = 0.0, middle[3];
                size_t cell = 0;
                for (int a = 2; a >= 0; --a) {
                    const double from = (double)at[a] * edge, away = fmax(fmax(from - c[a], c[a] - from - edge), 0.0);
                    const int64_t turns = at[a] >= 0 ? at[a] / n : -((n - 1 - at[a]) / n);
                    square += away * away;
                    middle[a] = c[a] - (double)turns;
                    cell = cell * (size_t)n + (size_t)(at[a] - turns * n);
                }
                if (square > reach * reach) continue;
                if (fill)
                    all->drops[all->start[cell]++] =
                        (drop){ { (float)middle[0], (float)middle[1], (float)middle[2] }, (float)b->radius, index };
                else
                    ++all->start[cell + 1];
            }
}

static pith_status list_bombs(bombs *all, uint32_t count, double margin, pith_error *err)
{
    const size_t cells = (size_t)all->cells * all->cells * all->cells;
    double work = 0.0;
    for (uint32_t i = 0; i < count; ++i) work += pow(2.0 * (all->bombs[i].reach + margin) * all->cells + 1.0, 3.0);
    if (work > 6e7)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "count and highest: %u bombs of this size lie %.0f deep on each other; lower one of them",
                         (unsigned)count, work / (double)cells);
    all->start = pith_alloc(cells + 2, sizeof *all->start);
    if (!all->start) return PITH_OUT_OF_MEMORY(err, "lists of bombs");
    /* Counted one cell further on, so that filling, which moves each cell's start to its end, leaves starts. */
    uint32_t *start = all->start;
    all->start = start + 1;
    for (uint32_t i = 0; i < count; ++i) list_bomb(all, i, margin, false);
    for (size_t i = 0; i <= cells; ++i) start[i + 1] += start[i];
    all->drops = pith_alloc(start[cells + 1], sizeof *all->drops);
    if (all->drops)
        for (uint32_t i = count; i-- > 0;) list_bomb(all, i, margin, true);
    all->start = start;
    return all->drops ? PITH_OK : PITH_OUT_OF_MEMORY(err, "lists of bombs");
}

/* Means for footprints beyond the lists: texels, asked of the lists with a footprint as wide as a texel's box. */
static pith_status mean_bombs(bombs *all, uint32_t size, pith_error *err)
{
    const uint32_t channels = all->what == BOMBS_NUMBER ? 2 : 1;
    const double edge = 1.0 / size;
    all->texels = pith_alloc((size_t)size * size * size, channels * sizeof *all->texels);
    if (!all->texels) return PITH_OUT_OF_MEMORY(err, "the means of bombs");
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (size > 32)
    for (size_t r = 0; r < (size_t)size * size; ++r)
        for (uint32_t i = 0; i < size; ++i) {
            const float p[3] = { (float)((i + 0.5) * edge), (float)(((double)(r % size) + 0.5) * edge),
                                 (float)(((double)(r / size) + 0.5) * edge) };
            float out[2];
            ask_lists(all, p, (float)(edge * sqrt(20.0 / 12.0)), out);
            memcpy(all->texels + (r * size + i) * channels, out, channels * sizeof *out);
        }
    const pyramid_base base = {
        .values = all->texels,
        .size = { size, size, size },
        .stride = channels,
        .channels = channels,
        .texel = { edge, edge, edge },
        .wrap = { WRAP_REPEAT, WRAP_REPEAT, WRAP_REPEAT },
    };
    return pyramid_make(&base, &all->means, err);
}

static void bombs_release(void *state)
{
    bombs *all = state;
    if (!all) return;
    pyramid_free(&all->means);
    bomb_shape_free(&all->shape);
    pith_free(all->texels);
    pith_free(all->drops);
    pith_free(all->start);
    pith_free(all->bombs);
    pith_free(all);
}

static pith_status check_bombs(const bombs_options *o, bool tables, pith_error *err)
{
    if (o->lowest > o->highest)
        return pith_fail(err, PITH_BAD_ARGUMENT, "lowest is %g, above highest, which is %g", o->lowest, o->highest);
    const double most = 0.5 * o->period / (tables ? sqrt(3.0) : 1.0);
    if (o->highest > most)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "highest is %g: above %g a bomb would overlap its own copies a period of %g away", o->highest,
                         most, o->period);
    return PITH_OK;
}

static pith_status bombs_check(const node_build *build, pith_error *err)
{
    return check_bombs(build->options, build->node->grid != NULL, err);
}

static pith_status bombs_prepare(const node_build *build, void **state, pith_error *err)
{
    const bombs_options *o = build->options;
    const pith_grid *grid = build->node->grid;
    PITH_TRY(bombs_check(build, err));
    bombs *all = pith_alloc(1, sizeof *all);
    if (!all) return PITH_OUT_OF_MEMORY(err, "bombs");
    all->what = (bombs_what)o->what;
    all->inverse = 1.0 / o->period;
    all->tables = grid != NULL;
    /* Texels of the means so fine that there are some two cells to a bomb, each sqrt 5 texels wide: the lists then
       answer for footprints of a cell's edge, where the means' own filter, of half a texel's deviation, takes over. */
    uint32_t size = 16;
    while (size < 64 && pow(size / sqrt(5.0), 3.0) < 2.0 * o->count) size *= 2;
    all->cells = (uint32_t)(size / sqrt(5.0));
    all->listed = (float)(sqrt(5.0) / size);
    all->bombs = pith_alloc(o->count, sizeof *all->bombs);
    pith_status status = all->bombs ? PITH_OK : PITH_OUT_OF_MEMORY(err, "bombs");
    if (status == PITH_OK) {
        drop_bombs(build, o, all);
        if (grid) status = bomb_shape_make(grid, &all->shape, err);
    }
    if (status == PITH_OK) status = list_bombs(all, o->count, 0.5 * (double)all->listed, err);
    if (status == PITH_OK) status = mean_bombs(all, size, err);
    if (status == PITH_OK)
        *state = all;
    else
        bombs_release(all);
    return status;
}

/* ---- running ----------------------------------------------------------------------------------------------------- */

static void bombs_run(const void *state, const lanes *const *inputs, uint32_t input_count, uint32_t count, lanes *out)
{
    (void)input_count;
    const bombs *all = state;
    const lanes *at = inputs[0];
    _Alignas(32) float unit[3][LANES];
    for (int a = 0; a < 3; ++a) unit_places(at->v[a], count, 0.0, all->inverse, true, unit[a]);
    for (uint32_t i = 0; i < count; ++i) {
        const float p[3] = { unit[0][i], unit[1][i], unit[2][i] };
        const float diameter = footprint_of(at, i) * (float)all->inverse;
        /* From the lists to the means, over the last third of what the lists can answer. */
        const float wide = clamp_unit((diameter / all->listed - 0.7f) / 0.3f);
        float value[2] = { 0 }, mean[2] = { 0 };
        if (wide < 1.0f) ask_lists(all, p, diameter, value);
        if (wide > 0.0f) pyramid_at(&all->means, p, BALL_VARIANCE * diameter * diameter, mean);
        for (int c = 0; c < 2; ++c) value[c] += wide * (mean[c] - value[c]);
        const bool number = all->what == BOMBS_NUMBER;
        out->v[0][i] = !number ? value[0] : value[1] > 0.0f ? clamp_unit(value[0] / value[1]) : 0.0f;
    }
}

const node_class node_bombs = {
    .shown = { "bombs", "Bubbles, or shapes from a small table, dropped at random into a cube that repeats.",
               PITH_VALUE_NUMBER, pattern_inputs, &bombs_params, PITH_ASSET_GRID | PITH_ASSET_OPTIONAL },
    .check = bombs_check,
    .prepare = bombs_prepare,
    .run = bombs_run,
    .release = bombs_release,
};
