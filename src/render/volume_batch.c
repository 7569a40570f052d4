/* Samples: what solids answer, what is seen of it, and how it is laid over one another.

   Emission and absorption: a sample stands for the stretch of its ray between two planes. Compositing front to back:
   Levoy, "Display of surfaces from volume data", IEEE CG&A 8(3), 1988; Porter, Duff, "Compositing digital images",
   SIGGRAPH 1984. Takayama et al. 2008 §5.1.2 lay slices of equal depth over one another, which is the same sum. */
#include "volume_internal.h"

static const double ambient = 0.35;     /* of a sample that faces away from the light */
static const double wrap = 0.22;        /* cosine beyond the terminator at which the light ends, as in pith_render */
static const double soft = 0.06;        /* difference of opacity at which shading reaches half of its strength */

enum { SIDES = 6 }; /* points asked round a sample: two along each axis */

void volume_batch_free(volume_batch *b)
{
    if (!b) return;
    pith_free(b->points);
    pith_free(b->weights);
    pith_free(b->footprints);
    pith_free(b->tets);
    pith_free(b->body);
    pith_free(b->plane);
    pith_free(b->ray);
    pith_free(b->order);
    pith_free(b->seen);
    if (b->ask) {
        pith_free(b->ask->points);
        pith_free(b->ask->weights);
        pith_free(b->ask->footprints);
        pith_free(b->ask->tets);
        pith_free(b->ask);
    }
    pith_free(b->chosen);
    pith_free(b->answers);
    pith_free(b);
}

volume_batch *volume_batch_new(const volume_scene *scene)
{
    volume_batch *b = pith_alloc(1, sizeof *b);
    if (!b) return NULL;
    /* One ray's samples of one plane always fit. */
    const size_t n = scene->body_count > VOLUME_BATCH / 8 ? 8 * (size_t)scene->body_count : VOLUME_BATCH;
    const size_t asked = scene->options->shading > 0.0 ? SIDES * n : n;
    *b = (volume_batch){
        .capacity = n,
        .points = pith_alloc(n, sizeof *b->points),
        .weights = pith_alloc(n, sizeof *b->weights),
        .footprints = pith_alloc(n, sizeof *b->footprints),
        .tets = pith_alloc(n, sizeof *b->tets),
        .body = pith_alloc(n, sizeof *b->body),
        .plane = pith_alloc(n, sizeof *b->plane),
        .ray = pith_alloc(n, sizeof *b->ray),
        .order = pith_alloc(n, sizeof *b->order),
        .seen = pith_alloc(n, sizeof *b->seen),
        .ask = pith_alloc(1, sizeof *b->ask),
        .chosen = pith_alloc(n, sizeof *b->chosen),
        .answers = pith_alloc(asked * scene->channels, sizeof *b->answers),
    };
    if (b->ask)
        *b->ask = (volume_question){
            .points = pith_alloc(asked, sizeof *b->ask->points),
            .weights = pith_alloc(n, sizeof *b->ask->weights),
            .footprints = pith_alloc(asked, sizeof *b->ask->footprints),
            .tets = pith_alloc(n, sizeof *b->ask->tets),
        };
    if (b->points && b->weights && b->footprints && b->tets && b->body && b->plane && b->ray && b->order && b->seen &&
        b->ask && b->ask->points && b->ask->weights && b->ask->footprints && b->ask->tets && b->chosen && b->answers)
        return b;
    volume_batch_free(b);
    return NULL;
}

/* ---- what is seen ----------------------------------------------------------------------------------------------- */

/* Colour and opacity of a value: between the two points round it. */
static void transfer_at(const volume_scene *scene, double value, float out[4])
{
    const pith_transfer_point *p = scene->transfer;
    size_t low = 0, high = scene->transfer_count - 1;
    if (!(value > p[low].value)) high = low; /* not-a-number takes the first */
    if (value >= p[high].value) low = high;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (value < p[middle].value) high = middle;
        else low = middle;
    }
    const float x = low == high ? 0.0f : (float)((value - p[low].value) / (p[high].value - p[low].value));
    for (int k = 0; k < 3; ++k) out[k] = p[low].colour[k] + x * (p[high].colour[k] - p[low].colour[k]);
    out[3] = p[low].opacity + x * (p[high].opacity - p[low].opacity);
}

/* Colour with the exposure's gain, kept below 1 with its hue; opacity with the options' factor. */
static void see(const volume_scene *scene, const float *answer, float out[4])
{
    float rgba[4] = { answer[0], answer[1], answer[2], answer[3] };
    if (scene->transfer) transfer_at(scene, (double)answer[scene->options->channel], rgba);
    const float gain = (float)scene->gain;
    for (int k = 0; k < 3; ++k) out[k] = rgba[k] > 0.0f ? gain * rgba[k] : 0.0f; /* not-a-number becomes black */
    const float pair = out[0] > out[1] ? out[0] : out[1], most = pair > out[2] ? pair : out[2];
    if (most > 1.0f)
        for (int k = 0; k < 3; ++k) out[k] = isinf(most) ? 1.0f : out[k] / most;
    const float opacity = (float)scene->options->opacity * rgba[3];
    out[3] = opacity > 1.0f ? 1.0f : opacity > 0.0f ? opacity : 0.0f;
}

static pith_status ask_body(const volume_scene *scene, volume_batch *b, uint32_t body, pith_error *err)
{
    const pith_solid *solid = scene->bodies[body].solid;
    const uint32_t channels = pith_solid_channels(solid);
    if (scene->body_count == 1) {
        const pith_query query = { .points = b->points, .footprints = b->footprints, .tets = b->tets,
                                   .weights = (const double (*)[4])b->weights, .count = b->count };
        PITH_TRY(pith_solid_sample(solid, &query, b->answers, err));
        for (size_t i = 0; i < b->count; ++i) see(scene, b->answers + i * channels, b->seen[i]);
        return PITH_OK;
    }
    size_t count = 0;
    for (size_t i = 0; i < b->count; ++i) {
        if (b->body[i] != body) continue;
        b->ask->points[count] = b->points[i];
        for (int k = 0; k < 4; ++k) b->ask->weights[count][k] = b->weights[i][k];
        b->ask->footprints[count] = b->footprints[i];
        b->ask->tets[count] = b->tets[i];
        b->chosen[count++] = (uint32_t)i;
    }
    const pith_query query = { .points = b->ask->points, .footprints = b->ask->footprints, .tets = b->ask->tets,
                               .weights = (const double (*)[4])b->ask->weights, .count = count };
    if (count) PITH_TRY(pith_solid_sample(solid, &query, b->answers, err));
    for (size_t i = 0; i < count; ++i) see(scene, b->answers + i * channels, b->seen[b->chosen[i]]);
    return PITH_OK;
}

/* ---- shading ---------------------------------------------------------------------------------------------------- */

/* Light of a sample from opacity on its six sides: where opacity grows fast there is a surface, seen from where it is
   low; where it is even there is none, and the colour stays. */
static float light_of(const volume_scene *scene, const float side[SIDES])
{
    const pith_vec3 rise = pith_v3((double)(side[1] - side[0]), (double)(side[3] - side[2]),
                                   (double)(side[5] - side[4]));
    const double length = pith_length(rise);
    if (!(length > 0.0)) return 1.0f;
    const double facing = -pith_dot(rise, scene->view.light) / length;
    const double lit = ambient + (1.0 - ambient) * fmax(0.0, (facing + wrap) / (1.0 + wrap));
    return (float)(1.0 - scene->options->shading * length / (length + soft) * (1.0 - lit));
}

/* Differences over a step to either side, in material coordinates: parts are moved but not turned. */
static pith_status shade_body(const volume_scene *scene, volume_batch *b, uint32_t body, pith_error *err)
{
    const pith_solid *solid = scene->bodies[body].solid;
    const uint32_t channels = pith_solid_channels(solid);
    const double h = scene->step;
    size_t count = 0;
    for (size_t i = 0; i < b->count; ++i) {
        if (b->body[i] != body || !(b->seen[i][3] > 0.0f)) continue;
        for (int k = 0; k < SIDES; ++k) {
            const double d = k % 2 ? h : -h;
            b->ask->points[SIDES * count + k] = pith_add(b->points[i], pith_v3(k / 2 == 0 ? d : 0.0,
                                                         k / 2 == 1 ? d : 0.0, k / 2 == 2 ? d : 0.0));
            b->ask->footprints[SIDES * count + k] = b->footprints[i];
        }
        b->chosen[count++] = (uint32_t)i;
    }
    const pith_query query = { .points = b->ask->points, .footprints = b->ask->footprints, .count = SIDES * count };
    if (count) PITH_TRY(pith_solid_sample(solid, &query, b->answers, err));
    for (size_t i = 0; i < count; ++i) {
        float side[SIDES], *seen = b->seen[b->chosen[i]], rgba[4];
        for (int k = 0; k < SIDES; ++k) {
            see(scene, b->answers + (SIDES * i + k) * channels, rgba);
            side[k] = rgba[3];
        }
        const float light = light_of(scene, side);
        for (int k = 0; k < 3; ++k) seen[k] *= light;
    }
    return PITH_OK;
}

/* ---- composition ------------------------------------------------------------------------------------------------ */

static void compose(volume_batch *b, volume_rays *rays)
{
    for (size_t i = 0; i < b->count; ++i) {
        const uint32_t at = b->order[i], ray = b->ray[at];
        const float *seen = b->seen[at];
        const double through = rays->through[ray];
        if (!(seen[3] > 0.0f) || !(through > volume_opaque)) continue;
        const double alpha = seen[3] < 1.0f ? (double)-expm1f(rays->stretch[ray] * log1pf(-seen[3])) : 1.0;
        for (int k = 0; k < 3; ++k) rays->colour[ray][k] += through * alpha * (double)seen[k];
        rays->through[ray] = through * (1.0 - alpha);
    }
}

pith_status volume_batch_flush(const volume_scene *scene, volume_batch *b, volume_rays *rays, pith_error *err)
{
    if (!b->count) return PITH_OK;
    for (uint32_t body = 0; body < scene->body_count; ++body) {
        PITH_TRY(ask_body(scene, b, body, err));
        if (scene->options->shading > 0.0) PITH_TRY(shade_body(scene, b, body, err));
    }
    compose(b, rays);
    b->count = 0;
    return PITH_OK;
}
