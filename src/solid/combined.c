/* Solid of kind "combined": one solid's colour, with the grain of others on it.

   Source: Takayama, "Algorithms and Interfaces for Volumetric Modeling", thesis, 2011, §6.4 (noise whose weight in each
   band follows the colour) and §7.3.1 (detail in colours that flow between surfaces). */
#include "pith/solid_kind.h"

#include <string.h>

/* Floats of scratch for answers; a solid of more channels than ROOM / SOLID_BLOCK is asked fewer points at a time. */
enum { ROOM = 8 * SOLID_BLOCK };

static const char *const way_words[] = { "shade", "tint", "cover", NULL };
static const pith_param detail_items[] = {
    { "way", "1", "what the detail does: lighten and darken, tint, or lie over the colour", PITH_PARAM_CHOICE, 0,
      PITH_DETAIL_SHADE, 2, offsetof(pith_detail_options, way), way_words },
    { "amount", "1", "how much of the detail there is; more than 1 exaggerates", PITH_PARAM_DOUBLE, 0, 1, 100,
      offsetof(pith_detail_options, amount), NULL },
};
const pith_params pith_detail_params = { "detail", detail_items, sizeof detail_items / sizeof *detail_items,
                                         sizeof(pith_detail_options) };

pith_detail_options pith_detail_options_default(void)
{
    pith_detail_options options;
    pith_params_defaults(&pith_detail_params, &options);
    return options;
}

/* ---- the solid --------------------------------------------------------------------------------------------------- */

typedef struct weight {
    double lab[3], weight;
} weight;

typedef struct detail {
    const pith_solid *solid;
    uint32_t way;
    double amount;
    double mean, mean_lab[3]; /* luminance; Oklab */
    const weight *weights;    /* [weight_count], in the solid's own list */
    size_t weight_count;
    uint32_t passed; /* channels from this one on are the first of their number */
} detail;

typedef struct combined_solid {
    pith_solid base;
    const pith_solid *colour;
    detail *details; /* [count] */
    size_t count;
    weight *weights; /* of all details */
    bool weighted;   /* any has some */
} combined_solid;

static double luminance(const float c[3])
{
    return 0.2126 * (double)c[0] + 0.7152 * (double)c[1] + 0.0722 * (double)c[2];
}

static void lab_of(const float c[3], double lab[3])
{
    const double rgb[3] = { (double)c[0], (double)c[1], (double)c[2] };
    pith_oklab_from_rgb(rgb, lab);
}

/* Nearer than this in Oklab, two colours are the same one. */
static const double same_colour = 1e-6;

static double weight_at(const detail *d, const double lab[3])
{
    double sum = 0.0, all = 0.0;
    for (size_t i = 0; i < d->weight_count; ++i) {
        const weight *w = &d->weights[i];
        const double off[3] = { lab[0] - w->lab[0], lab[1] - w->lab[1], lab[2] - w->lab[2] };
        const double square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
        if (square < same_colour * same_colour) return w->weight;
        sum += w->weight / square;
        all += 1.0 / square;
    }
    return sum / all;
}

/* ---- what details do ---------------------------------------------------------------------------------------------- */

static void shade(const detail *d, double a, const float answer[3], float colour[3])
{
    const double factor = 1.0 + a * ((luminance(answer) - d->mean) / d->mean);
    for (int k = 0; k < 3; ++k) colour[k] = factor > 0.0 ? (float)((double)colour[k] * factor) : 0.0f;
}

static bool inside_gamut(const double rgb[3], double low, double high)
{
    for (int k = 0; k < 3; ++k)
        if (!(rgb[k] >= low && rgb[k] <= high)) return false;
    return true;
}

/* Makes the colour greyer, in its own hue and lightness, until it is one that can be shown. */
static void into_gamut(double lab[3], double low, double high, double rgb[3])
{
    pith_oklab_to_rgb(lab, rgb);
    if (inside_gamut(rgb, low, high)) return;
    lab[0] = fmin(cbrt(high), fmax(cbrt(low), lab[0]));
    double kept = 0.0;
    for (double step = 0.5; step > 1e-5; step *= 0.5) {
        const double tried[3] = { lab[0], (kept + step) * lab[1], (kept + step) * lab[2] };
        pith_oklab_to_rgb(tried, rgb);
        if (inside_gamut(rgb, low, high)) kept += step;
    }
    const double found[3] = { lab[0], kept * lab[1], kept * lab[2] };
    pith_oklab_to_rgb(found, rgb);
    for (int k = 0; k < 3; ++k) rgb[k] = fmin(high, fmax(low, rgb[k]));
}

static void tint(const detail *d, double a, const float answer[3], float colour[3])
{
    double own[3], lab[3], rgb[3], low = 0.0, high = 1.0;
    lab_of(answer, own);
    for (int k = 0; k < 3; ++k) own[k] -= d->mean_lab[k];
    if (own[0] == 0.0 && own[1] == 0.0 && own[2] == 0.0) return; /* the way to Oklab and back would round */
    lab_of(colour, lab);
    for (int k = 0; k < 3; ++k) {
        lab[k] += a * own[k];
        low = fmin(low, (double)colour[k]);
        high = fmax(high, (double)colour[k]);
    }
    into_gamut(lab, low, high, rgb);
    for (int k = 0; k < 3; ++k) colour[k] = (float)rgb[k];
}

static void cover(double a, const float answer[3], float colour[3])
{
    const double part = fmin(1.0, a);
    for (int k = 0; k < 3; ++k)
        colour[k] =
            part == 1.0 ? answer[k] : (float)((double)colour[k] + part * ((double)answer[k] - (double)colour[k]));
}

/* Lays one detail on a point: its answer, and the colour's lab where details have weights. */
static void lay_on(const detail *d, uint32_t channels, const float *answer, const double lab[3], float *out)
{
    const double w = d->weight_count ? weight_at(d, lab) : 1.0;
    for (uint32_t c = d->passed; c < channels; ++c) out[c] = w == 1.0 ? answer[c] : (float)(w * (double)answer[c]);
    const double a = d->amount * w * (double)answer[3];
    if (!(a > 0.0)) return;
    if (d->way == PITH_DETAIL_SHADE)
        shade(d, a, answer, out);
    else if (d->way == PITH_DETAIL_TINT)
        tint(d, a, answer, out);
    else
        cover(a, answer, out);
}

/* ---- sampling ----------------------------------------------------------------------------------------------------- */

static void sample_some(const combined_solid *self, const pith_query *query, float *out)
{
    float answers[ROOM];
    double lab[SOLID_BLOCK][3];
    const uint32_t channels = self->base.channels, own = self->colour->channels;
    self->colour->class->sample(self->colour, query, answers);
    for (size_t i = 0; i < query->count; ++i) {
        memcpy(out + i * channels, answers + i * own, own * sizeof *out);
        memset(out + i * channels + own, 0, (channels - own) * sizeof *out);
        if (self->weighted) lab_of(answers + i * own, lab[i]);
    }
    for (size_t k = 0; k < self->count; ++k) {
        const detail *d = &self->details[k];
        const uint32_t of = d->solid->channels;
        d->solid->class->sample(d->solid, query, answers);
        for (size_t i = 0; i < query->count; ++i) lay_on(d, of, answers + i * of, lab[i], out + i * channels);
    }
}

static void combined_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const combined_solid *self = (const combined_solid *)solid;
    const size_t fit = ROOM / self->base.channels, most = fit < SOLID_BLOCK ? fit : SOLID_BLOCK;
    for (size_t first = 0; first < query->count; first += most) {
        const size_t left = query->count - first;
        const pith_query some = pith_query_part(query, first, left < most ? left : most);
        sample_some(self, &some, out + first * self->base.channels);
    }
}

static void combined_destroy(pith_solid *solid)
{
    combined_solid *self = (combined_solid *)solid;
    pith_free(self->details);
    pith_free(self->weights);
    pith_free(self);
}

static const pith_solid_class combined_class = { "combined", combined_sample, combined_destroy };

/* ---- making one --------------------------------------------------------------------------------------------------- */

static bool finite_colour(const float c[3]) { return isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]); }

static pith_status check_weights(const pith_detail *from, pith_error *err)
{
    if (from->weight_count > 0 && !from->weights)
        return pith_fail(err, PITH_BAD_ARGUMENT, "weights is NULL, and there are %zu", from->weight_count);
    for (size_t i = 0; i < from->weight_count; ++i) {
        const pith_detail_weight *w = &from->weights[i];
        if (!finite_colour(w->colour)) return pith_fail(err, PITH_BAD_ARGUMENT, "weight %zu has no finite colour", i);
        if (!(w->weight >= 0.0 && w->weight <= 100.0))
            return pith_fail(err, PITH_BAD_ARGUMENT, "weight %zu is %g, expected 0 to 100", i, w->weight);
    }
    return PITH_OK;
}

static pith_status check_detail(const pith_detail *from, pith_error *err)
{
    if (!from->solid) return pith_fail(err, PITH_BAD_ARGUMENT, "it has no solid");
    PITH_TRY(pith_params_check(&pith_detail_params, &from->options, err));
    PITH_TRY(check_weights(from, err));
    if (from->options.way == PITH_DETAIL_COVER) return PITH_OK;
    const double mean = luminance(from->mean);
    if (finite_colour(from->mean) && (from->options.way == PITH_DETAIL_TINT || mean > 0.0)) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "its mean colour is (%g, %g, %g): \"%s\" needs one that is finite%s; pith_solid_mean finds it",
                     (double)from->mean[0], (double)from->mean[1], (double)from->mean[2], way_words[from->options.way],
                     from->options.way == PITH_DETAIL_SHADE ? " and not black" : "");
}

static pith_status check_all(const pith_solid *colour, const pith_detail *details, size_t count, size_t *weights,
                             pith_error *err)
{
    uint32_t channels = pith_solid_channels(colour);
    for (size_t i = 0; i < count; ++i) {
        if (check_detail(&details[i], err) != PITH_OK)
            return details[i].name ? pith_fail_in(err, PITH_BAD_ARGUMENT, "detail \"%s\"", details[i].name)
                                   : pith_fail_in(err, PITH_BAD_ARGUMENT, "detail %zu", i);
        *weights += details[i].weight_count;
        if (channels < pith_solid_channels(details[i].solid)) channels = pith_solid_channels(details[i].solid);
    }
    if (channels > ROOM)
        return pith_fail(err, PITH_BAD_ARGUMENT, "a combined solid of %u channels, expected at most %d", channels,
                         ROOM);
    return PITH_OK;
}

static void fill(combined_solid *self, const pith_detail *from, size_t index, weight *weights)
{
    detail *to = &self->details[index];
    *to = (detail){ .solid = from->solid,
                    .way = from->options.way,
                    .amount = from->options.amount,
                    .mean = luminance(from->mean),
                    .weights = weights,
                    .weight_count = from->weight_count,
                    .passed = self->base.channels };
    lab_of(from->mean, to->mean_lab);
    for (size_t i = 0; i < from->weight_count; ++i) {
        lab_of(from->weights[i].colour, weights[i].lab);
        weights[i].weight = from->weights[i].weight;
    }
    if (self->base.channels < from->solid->channels) self->base.channels = from->solid->channels;
    self->weighted = self->weighted || from->weight_count > 0;
}

pith_status pith_solid_combined(const pith_solid *colour, const pith_detail *details, size_t count, pith_solid **solid,
                                pith_error *err)
{
    if (!colour || (count > 0 && !details) || !solid)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_solid_combined: %s is NULL",
                         !colour  ? "colour"
                         : !solid ? "solid"
                                  : "details");
    size_t weights = 0;
    PITH_TRY(check_all(colour, details, count, &weights, err));
    combined_solid *self = pith_alloc(1, sizeof *self);
    if (!self) return PITH_OUT_OF_MEMORY(err, "a combined solid");
    *self = (combined_solid){ .base = { &combined_class, colour->channels },
                              .colour = colour,
                              .details = pith_alloc(count, sizeof *self->details),
                              .count = count,
                              .weights = pith_alloc(weights, sizeof *self->weights) };
    if (!self->details || !self->weights) {
        combined_destroy(&self->base);
        return PITH_OUT_OF_MEMORY(err, "a combined solid");
    }
    size_t first = 0;
    for (size_t i = 0; i < count; ++i) {
        fill(self, &details[i], i, self->weights + first);
        first += details[i].weight_count;
    }
    *solid = &self->base;
    return PITH_OK;
}
