/* What a plane would lay open of the pieces that the cuts leave: a look before the cut. */
#include "model_internal.h"

/* The section of one piece; NULL where the plane misses it. */
static pith_status section_of(const piece *from, const pith_cut_step *cut, pith_shell **section, pith_error *err)
{
    piece_side side;
    double *values = NULL;
    *section = NULL;
    PITH_TRY(piece_side_of(from, cut, &side, &values, err));
    if (side != SIDE_BOTH) return PITH_OK;
    const pith_status status = pith_part_section(from->part->what, values, section, err);
    pith_free(values);
    return status;
}

pith_status pith_model_section(pith_model *model, const pith_plane *plane, pith_model_piece **sections, size_t *count,
                               pith_error *err)
{
    if (!pith_finite(plane->point) || !pith_finite(plane->normal) || !(pith_length(plane->normal) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "plane: point and normal must be finite numbers, and the normal not zero");
    for (size_t i = 0; i < pith_model_bodies(model); ++i) PITH_TRY(pith_model_part(model_body(model, i), NULL, err));
    const pith_cut_step cut = { .plane = *plane };
    holding *held = NULL;
    piece_state *states = NULL;
    model->keeps_levels = true; /* the next plane is asked for in a moment */
    PITH_TRY(model_cut(model, model_cuts(model)->count, &held, &states, err));
    const cut_level *level = held->what;
    pith_model_piece *made = pith_alloc(level->count, sizeof *made);
    size_t found = 0;
    pith_status status = made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "sections");
    for (size_t i = 0; status == PITH_OK && i < level->count; ++i) {
        pith_shell *section = NULL;
        if (!states[i].hidden) status = section_of(&level->pieces[i], &cut, &section, err);
        if (!section) continue;
        made[found++] = (pith_model_piece){ .shell = section, .body = level->pieces[i].body, .offset = states[i].offset };
    }
    holding_release(held);
    pith_free(states);
    if (status == PITH_OK) {
        *sections = made;
        *count = found;
    } else {
        pith_sections_free(made, found);
    }
    return status;
}

void pith_sections_free(pith_model_piece *sections, size_t count)
{
    for (size_t i = 0; sections && i < count; ++i) pith_shell_destroy((pith_shell *)sections[i].shell);
    pith_free(sections);
}
