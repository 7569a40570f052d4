/* Lines and arrows of pith field in colour: as lines, as tubes, as glyphs. */
#include "field.h"

#include <string.h>

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static bool by_depth(const field *from)
{
    return from->asked->colour == COLOUR_DEPTH || (from->asked->colour == COLOUR_DEFAULT && from->view.has_depth);
}

/* Depth, or the direction with x red, y green, z blue. */
static void colour_of(const field *from, double depth, pith_vec3 direction, float colour[3])
{
    const pith_vec3 unit = pith_unit(direction);
    const double parts[3] = { fabs(unit.x), fabs(unit.y), fabs(unit.z) };
    if (by_depth(from)) pith_look_colour(depth, colour);
    else for (int c = 0; c < 3; ++c) colour[c] = pith_srgb_decode(0.15 + 0.85 * parts[c]);
}

pith_status field_all_lines(const field *from, pith_polylines **lines, float (**colours)[3], pith_error *err)
{
    size_t points = 0, count = 0, at = 0, line = 0;
    for (int i = 0; i < from->layer_count; ++i) {
        const pith_polylines_view view = pith_polylines_look(from->layers[i].lines);
        points += view.start[view.line_count];
        count += view.line_count;
    }
    pith_vec3 *all = pith_alloc(points, sizeof *all);
    uint32_t *start = pith_alloc(count + 1, sizeof *start);
    double *depths = pith_alloc(points, sizeof *depths);
    float (*made)[3] = pith_alloc(count, sizeof *made);
    pith_status status = all && start && depths && made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "lines");
    for (int i = 0; status == PITH_OK && i < from->layer_count; ++i) {
        const pith_polylines_view view = pith_polylines_look(from->layers[i].lines);
        const size_t size = view.start[view.line_count];
        memcpy(all + at, view.points, size * sizeof *all);
        for (uint32_t l = 0; l < view.line_count; ++l) start[++line] = (uint32_t)(at + view.start[l + 1]);
        at += size;
    }
    if (status == PITH_OK) status = pith_look_depths(from->look, all, points, depths, err);
    for (line = 0; status == PITH_OK && line < count; ++line) {
        double depth = 0.0;
        for (uint32_t p = start[line]; p < start[line + 1]; ++p) depth += depths[p] / (start[line + 1] - start[line]);
        colour_of(from, depth, pith_sub(all[start[line + 1] - 1], all[start[line]]), made[line]);
    }
    if (status == PITH_OK)
        status = pith_polylines_create(&(pith_polylines_view){ all, start, (uint32_t)count }, lines, err);
    pith_free(all);
    pith_free(start);
    pith_free(depths);
    if (status == PITH_OK) *colours = made;
    else pith_free(made);
    return status;
}

/* The mesh with a colour at every vertex, by the field there; dark on layers, so that lines show on them. */
static pith_status colour_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(*mesh);
    float (*colours)[4] = pith_alloc(view.vertex_count, sizeof *colours);
    double *depths = pith_alloc(view.vertex_count, sizeof *depths);
    pith_vec3 *vectors = pith_alloc(view.vertex_count, sizeof *vectors);
    pith_mesh *coloured = NULL;
    pith_status status = colours && depths && vectors ? PITH_OK : PITH_OUT_OF_MEMORY(err, "colours");
    if (status == PITH_OK) status = pith_look_depths(from->look, view.positions, view.vertex_count, depths, err);
    const pith_directions *follow = &from->view.directions;
    if (status == PITH_OK) follow->sample(follow->user, view.positions, view.vertex_count, vectors);
    for (uint32_t v = 0; status == PITH_OK && v < view.vertex_count; ++v) {
        /* Tubes stand out of the body a little, where the field is zero: the neighbour on the ring is near enough. */
        if (v > 0 && !(pith_length(vectors[v]) > 0.0)) vectors[v] = vectors[v - 1];
        colour_of(from, depths[v], vectors[v], colours[v]);
        for (int c = 0; layer->mesh && c < 3; ++c) colours[v][c] *= 0.25f;
        colours[v][3] = 1.0f;
    }
    view.colours = (const float (*)[4])colours;
    if (status == PITH_OK) status = pith_mesh_create(&view, &coloured, err);
    pith_free(colours);
    pith_free(depths);
    pith_free(vectors);
    if (status != PITH_OK) return status;
    pith_mesh_destroy(*mesh);
    *mesh = coloured;
    return PITH_OK;
}

pith_status field_line_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err)
{
    const double spacing = from->asked->lines.spacing * from->diagonal;
    pith_mesh *made = NULL;
    if (layer->vectors) {
        const double length = 0.8 * PITH_LOOK_ARROWS_APART * spacing;
        pith_vec3 *tails = pith_alloc(layer->count, sizeof *tails); /* arrows lie with their middle at their place */
        if (!tails) return PITH_OUT_OF_MEMORY(err, "arrows");
        for (size_t i = 0; i < layer->count; ++i)
            tails[i] = pith_madd(layer->points[i], layer->vectors[i], -0.5 * length);
        const pith_status status = pith_glyphs(tails, layer->vectors, layer->count, length, &made, err);
        pith_free(tails);
        PITH_TRY(status);
    } else {
        PITH_TRY(pith_polylines_tubes(layer->lines, from->asked->radius * spacing, 8, &made, err));
    }
    const pith_status status = colour_mesh(from, layer, &made, err);
    if (status == PITH_OK) *mesh = made;
    else pith_mesh_destroy(made);
    return status;
}
