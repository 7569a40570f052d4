/* Pieces that the document hides or moves. An entry names a piece by a point in it, and by how many cuts had been made;
   what later cuts make of the piece inherits what was done to it, and may have an entry of its own. */
#include "model_internal.h"

#include <string.h>

/* Less than this outside a tet is rounding; barycentric. */
static const double tiny = 1e-9;

/* ---- where a point is ------------------------------------------------------------------------------------------------ */

/* Are all corners of a tet on one side of the point, along an axis? */
static bool is_beside(const pith_vec3 *material, const uint32_t v[4], pith_vec3 at)
{
    const pith_vec3 a = material[v[0]], b = material[v[1]], c = material[v[2]], d = material[v[3]];
    return (a.x < at.x && b.x < at.x && c.x < at.x && d.x < at.x) ||
           (a.x > at.x && b.x > at.x && c.x > at.x && d.x > at.x) ||
           (a.y < at.y && b.y < at.y && c.y < at.y && d.y < at.y) ||
           (a.y > at.y && b.y > at.y && c.y > at.y && d.y > at.y) ||
           (a.z < at.z && b.z < at.z && c.z < at.z && d.z < at.z) ||
           (a.z > at.z && b.z > at.z && c.z > at.z && d.z > at.z);
}

/* The tet of a piece that contains the point best. Going through all of them takes less than a millisecond for
   200 000 tets, and nothing has to be made first: a locator would be half a second. */
static void look_in_piece(const piece *in, size_t index, pith_vec3 at, double *best, piece_place *place)
{
    const pith_part_view part = pith_part_look(in->part->what);
    for (uint32_t t = 0; t < part.tet_count; ++t) {
        const uint32_t *v = part.tets[t];
        double weights[4];
        if (is_beside(part.material, v, at)) continue;
        if (!pith_barycentric(part.material[v[0]], part.material[v[1]], part.material[v[2]], part.material[v[3]], at,
                              weights)) continue;
        const double least = fmin(fmin(weights[0], weights[1]), fmin(weights[2], weights[3]));
        if (!(least >= -tiny && least > *best)) continue;
        *best = least;
        *place = (piece_place){ .piece = index, .tet = t };
        memcpy(place->weights, weights, sizeof weights);
    }
}

static bool box_has(const pith_box *box, pith_vec3 at)
{
    return at.x >= box->low.x && at.x <= box->high.x && at.y >= box->low.y && at.y <= box->high.y &&
           at.z >= box->low.z && at.z <= box->high.z;
}

/* Looks in the pieces of one body. */
static bool look_in_body(size_t body, const cut_level *level, pith_vec3 at, piece_place *place)
{
    double best = -INFINITY;
    for (size_t i = 0; i < level->count; ++i)
        if (level->pieces[i].body == body && box_has(&level->pieces[i].box, at))
            look_in_piece(&level->pieces[i], i, at, &best, place);
    return best > -INFINITY;
}

/* The piece that an entry is about: of the body it names, or of the first that has one there. */
static bool find_piece(const pith_model *model, const document_part *entry, const cut_level *level, piece_place *place)
{
    for (size_t i = 0; i < pith_model_bodies(model); ++i) {
        if (entry->body != SIZE_MAX && entry->body != model_number(model, i)) continue;
        if (look_in_body(i, level, entry->at, place)) return true;
    }
    return false;
}

/* ---- what is done to it ------------------------------------------------------------------------------------------------ */

/* Is the entry about pieces of the model's cuts, and about those after `count` of them? */
static bool is_about(const pith_model *model, const document_part *entry, size_t count)
{
    return entry->after == count && (count == 0 || model_cuts(model)->from_document);
}

static void apply_entry(const document_part *entry, piece_state *state)
{
    if (entry->says_hidden) state->hidden = entry->hidden;
    state->offset = pith_add(state->offset, entry->offset);
}

/* A model of one of several bodies need not have the piece, so the whole tells it. */
static void tell_no_effect(pith_model *model, size_t index)
{
    const document_part *entry = &model->document->parts[index];
    if (model->owner != model || model->told_parts[index]) return;
    model->told_parts[index] = true;
    model_note(model, "%s: parts[%zu]: no piece has [%g, %g, %g] in it after %zu cut%s, so the entry changes nothing",
               model->document->path, index, entry->at.x, entry->at.y, entry->at.z, entry->after,
               entry->after == 1 ? "" : "s");
}

void model_apply_parts(pith_model *model, size_t count, const cut_level *level, piece_state *states)
{
    for (size_t i = 0; i < model->document->part_count; ++i) {
        const document_part *entry = &model->document->parts[i];
        piece_place place;
        if (!is_about(model, entry, count)) continue;
        if (find_piece(model, entry, level, &place)) apply_entry(entry, &states[place.piece]);
        else tell_no_effect(model, i);
    }
}

/* The shell that was made of a place in the level before the last cut. */
static size_t shell_of(const cut_shells *shells, const piece_place *place)
{
    const double *values = shells->values[place->piece];
    const cut_level *level = shells->level->what;
    const pith_part_view part = pith_part_look(level->pieces[place->piece].part->what);
    double value = 0.0;
    for (int k = 0; values && k < 4; ++k) value += place->weights[k] * values[part.tets[place->tet][k]];
    const piece_side side = value < 0.0 ? SIDE_NEGATIVE : SIDE_POSITIVE;
    for (size_t i = 0; i < shells->count; ++i)
        if (shells->items[i].parent == place->piece && (!values || shells->items[i].side == side)) return i;
    return SIZE_MAX;
}

void model_apply_parts_to_shells(pith_model *model, const cut_shells *shells, piece_state *states)
{
    for (size_t i = 0; i < model->document->part_count; ++i) {
        const document_part *entry = &model->document->parts[i];
        piece_place place;
        if (!is_about(model, entry, model_cuts(model)->count)) continue;
        const bool found = find_piece(model, entry, shells->level->what, &place);
        const size_t shell = found ? shell_of(shells, &place) : SIZE_MAX;
        if (shell != SIZE_MAX) apply_entry(entry, &states[shell]);
        else tell_no_effect(model, i);
    }
}
