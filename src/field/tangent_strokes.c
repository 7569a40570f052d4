/* From strokes to constraints: small pieces with a direction, gathered by the vertex or voxel they speak for.
 * Takayama's thesis (2011), section 4.3.2, figure 4.10.
 */
#include "volume_internal.h"

#include <stdlib.h>

/* Directions of two strokes at one site contradict each other when they differ by more than 170 degrees. */
static const double opposite = -0.985;
/* Of a stroke's length, within a piece or at a site, less than this is left when it turns back on itself there. */
static const double turned_back = 0.1;

void stroke_pieces_free(stroke_pieces *pieces)
{
    pith_free(pieces->middle);
    pith_free(pieces->direction);
    pith_free(pieces->stroke);
    pith_free(pieces->site);
    *pieces = (stroke_pieces){ 0 };
}

static pith_status check_stroke(const pith_stroke *stroke, size_t index, pith_error *err)
{
    for (size_t i = 0; i < stroke->count; ++i)
        if (!stroke->points || !pith_finite(stroke->points[i]))
            return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu, point %zu is not a finite position; draw the stroke "
                             "anew", index, i);
    const double length = stroke->count > 0 ? polyline_length(stroke->points, stroke->count) : 0.0;
    if (!(length > 0.0 && length < INFINITY))
        return pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu has %zu points and the length %g; a direction needs two "
                         "different points", index, stroke->count, length);
    return PITH_OK;
}

/* Appends the pieces of one stroke; points is scratch for its samples. */
static void cut_stroke(const pith_stroke *stroke, uint32_t index, size_t samples, pith_vec3 *points,
                       stroke_pieces *pieces)
{
    const double length = polyline_length(stroke->points, stroke->count), step = length / (double)(samples - 1);
    polyline_resample(stroke->points, stroke->count, length, samples, points);
    for (size_t i = 0; i + 1 < samples; ++i) {
        const pith_vec3 across = pith_sub(points[i + 1], points[i]), along = pith_unit(across);
        if (!(pith_length(across) > turned_back * step)) continue; /* a hairpin */
        pieces->middle[pieces->count] = pith_lerp(points[i], points[i + 1], 0.5);
        pieces->direction[pieces->count] = along;
        pieces->stroke[pieces->count] = index;
        pieces->site[pieces->count] = PITH_NONE;
        ++pieces->count;
    }
}

pith_status stroke_pieces_make(const pith_stroke *strokes, size_t count, double spacing, stroke_pieces *pieces,
                               pith_error *err)
{
    size_t most = 0, total = 0;
    if (count > UINT32_MAX / 2 || (count > 0 && !strokes))
        return pith_fail(err, PITH_BAD_ARGUMENT, "there are %zu strokes and no list of them", count);
    for (size_t s = 0; s < count; ++s) {
        PITH_TRY(check_stroke(&strokes[s], s, err));
        const size_t samples = polyline_sample_count(polyline_length(strokes[s].points, strokes[s].count), spacing);
        total += samples;
        most = samples > most ? samples : most;
    }
    stroke_pieces made = { pith_alloc(total, sizeof *made.middle), pith_alloc(total, sizeof *made.direction),
                           pith_alloc(total, sizeof *made.stroke), pith_alloc(total, sizeof *made.site), 0 };
    pith_vec3 *points = pith_alloc(most, sizeof *points);
    if (!made.middle || !made.direction || !made.stroke || !made.site || !points) {
        stroke_pieces_free(&made);
        pith_free(points);
        return PITH_OUT_OF_MEMORY(err, "the strokes");
    }
    for (size_t s = 0; s < count; ++s)
        cut_stroke(&strokes[s], (uint32_t)s,
                   polyline_sample_count(polyline_length(strokes[s].points, strokes[s].count), spacing), points, &made);
    pith_free(points);
    *pieces = made;
    return PITH_OK;
}

/* ---- gathering by site ------------------------------------------------------------------------------------------- */

/* What one stroke says at one site. */
typedef struct saying {
    uint32_t site, stroke, number, pieces; /* number: where it was before sorting */
    pith_vec3 sum, at;          /* of the unit directions; the middle of the first piece */
} saying;

static int by_site_then_stroke(const void *a, const void *b)
{
    const saying *left = a, *right = b;
    if (left->site != right->site) return left->site < right->site ? -1 : 1;
    if (left->stroke != right->stroke) return left->stroke < right->stroke ? -1 : 1;
    return left->number < right->number ? -1 : left->number > right->number; /* the same order from any qsort */
}

/* Sums up neighbouring pieces of one stroke at one site. A stroke that comes back later makes another saying, which
   sorting brings beside the first: so sayings of one stroke are merged again there. Returns how many. */
static size_t list_sayings(const stroke_pieces *pieces, saying *list)
{
    size_t count = 0;
    for (size_t i = 0; i < pieces->count; ++i) {
        if (pieces->site[i] == PITH_NONE) continue;
        if (count == 0 || list[count - 1].site != pieces->site[i] || list[count - 1].stroke != pieces->stroke[i]) {
            list[count] = (saying){ pieces->site[i], pieces->stroke[i], (uint32_t)count, 0, pith_v3(0, 0, 0),
                                    pieces->middle[i] };
            ++count;
        }
        list[count - 1].sum = pith_add(list[count - 1].sum, pieces->direction[i]);
        ++list[count - 1].pieces;
    }
    qsort(list, count, sizeof *list, by_site_then_stroke);
    size_t kept = 0;
    for (size_t i = 0; i < count; ++i) {
        if (kept > 0 && list[kept - 1].site == list[i].site && list[kept - 1].stroke == list[i].stroke) {
            list[kept - 1].sum = pith_add(list[kept - 1].sum, list[i].sum);
            list[kept - 1].pieces += list[i].pieces;
        } else {
            list[kept++] = list[i];
        }
    }
    return kept;
}

/* Two sayings at one site that say opposite things? list holds those of one site. */
static pith_status check_contradiction(const saying *list, size_t count, const char *what, pith_error *err)
{
    for (size_t i = 0; i < count; ++i)
        for (size_t j = i + 1; j < count; ++j)
            if (!(pith_dot(pith_unit(list[i].sum), pith_unit(list[j].sum)) > opposite))
                return pith_fail(err, PITH_BAD_ARGUMENT, "strokes %u and %u contradict each other: they run in "
                                 "opposite directions at the same %s, near (%g, %g, %g); remove or turn one of them",
                                 list[i].stroke, list[j].stroke, what, list[i].at.x, list[i].at.y, list[i].at.z);
    return PITH_OK;
}

/* Drops sayings that have turned back on themselves. Refuses a stroke of which nothing is left. */
static pith_status drop_turned(saying *list, size_t *count, size_t stroke_count, pith_error *err)
{
    uint8_t *said = pith_alloc(stroke_count, sizeof *said); /* 1: something, 2: something that counts */
    if (!said) return PITH_OUT_OF_MEMORY(err, "the strokes");
    size_t kept = 0;
    for (size_t i = 0; i < *count; ++i) {
        const bool counts = pith_length(list[i].sum) > turned_back * list[i].pieces;
        said[list[i].stroke] |= counts ? 2 : 1;
        if (counts) list[kept++] = list[i];
    }
    *count = kept;
    pith_status status = PITH_OK;
    for (size_t s = 0; s < stroke_count && status == PITH_OK; ++s)
        if (said[s] == 1)
            status = pith_fail(err, PITH_BAD_ARGUMENT, "stroke %zu runs back over itself all along, so it has no "
                               "direction; draw it one way", s);
    pith_free(said);
    return status;
}

pith_status site_pins_make(const stroke_pieces *pieces, size_t stroke_count, const char *what, site_pin **pins,
                           size_t *count, pith_error *err)
{
    saying *list = pith_alloc(pieces->count, sizeof *list);
    site_pin *made = pith_alloc(pieces->count, sizeof *made);
    pith_status status = PITH_OK;
    if (!list || !made) {
        status = PITH_OUT_OF_MEMORY(err, "the strokes");
        goto done;
    }
    size_t sayings = list_sayings(pieces, list), sites = 0;
    PITH_TRY_OR(done, drop_turned(list, &sayings, stroke_count, err));
    for (size_t i = 0, end; i < sayings; i = end) {
        site_pin pin = { list[i].site, 0, pith_v3(0, 0, 0) };
        for (end = i; end < sayings && list[end].site == pin.site; ++end) {
            pin.direction = pith_add(pin.direction, list[end].sum);
            pin.pieces += list[end].pieces;
        }
        PITH_TRY_OR(done, check_contradiction(list + i, end - i, what, err));
        pin.direction = pith_scale(pin.direction, 1.0 / pin.pieces);
        made[sites++] = pin;
    }
    *pins = made;
    *count = sites;
    made = NULL;
done:
    pith_free(list);
    pith_free(made);
    return status;
}
