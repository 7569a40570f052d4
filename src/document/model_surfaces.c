/* The surfaces of a body that colours flow between: drawn, varied, erased, painted, strewn with grains, and placed. */
#include "model_internal.h"

#include "pith/diffusion_files.h"

#include <stdio.h>
#include <string.h>

/* A surface on its way. The drawn mesh is where it was drawn, and the other where it stands after variation; vertex i of
   the one is vertex i of the other. */
typedef struct made_surface {
    char *name;                     /* the document that says it may go before this does */
    pith_mesh *drawn, *mesh;
    pith_mesh *grain;               /* of grains: the one that stands in the mesh so often; else NULL */
    float (*front)[4], (*back)[4];  /* [vertex_count]; back is NULL when the surface has one colour */
    double *blur;                   /* [vertex_count], or NULL */
    bool hide_front, hide_back;     /* a file says so */
} made_surface;

struct body_surfaces {
    made_surface *items;            /* [count] */
    pith_diffusion_surface *views;  /* [count] of them */
    size_t count;
    double strength;                /* that the variation ended with */
};

static void surface_clear(made_surface *gone)
{
    pith_free(gone->name);
    if (gone->mesh != gone->drawn) pith_mesh_destroy(gone->mesh);
    pith_mesh_destroy(gone->drawn);
    pith_mesh_destroy(gone->grain);
    pith_free(gone->front);
    pith_free(gone->back);
    pith_free(gone->blur);
}

void body_surfaces_destroy(body_surfaces *gone)
{
    if (!gone) return;
    for (size_t i = 0; gone->items && i < gone->count; ++i) surface_clear(&gone->items[i]);
    pith_free(gone->items);
    pith_free(gone->views);
    pith_free(gone);
}

/* ---- form ------------------------------------------------------------------------------------------------------------ */

/* The mesh with its vertices where the ends lie on `positions`; what erasing left of another surface of the same
   connectivity. */
static pith_status carry_over(const pith_mesh *left, const pith_erased *ends, const pith_vec3 *positions,
                              pith_mesh **moved, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(left);
    pith_vec3 *places = pith_alloc(view.vertex_count, sizeof *places);
    if (!places) return PITH_OUT_OF_MEMORY(err, "a surface");
    for (uint32_t v = 0; v < view.vertex_count; ++v)
        for (int k = 0; k < 3; ++k)
            places[v] = pith_madd(places[v], positions[ends[v].corner[k]], ends[v].weight[k]);
    view.positions = places;
    view.normals = NULL;
    const pith_status status = pith_mesh_create(&view, moved, err);
    pith_free(places);
    return status;
}

/* Takes away what the surface's entries of "erase" say, of the drawn mesh and of the other in the same way. kept (may be
   NULL): where the vertices that are left were, for the caller to free; stays as it is when nothing is erased. */
static pith_status erase_parts(const document_surface *from, made_surface *at, pith_erased **kept, pith_error *err)
{
    if (from->erase_count == 0) return PITH_OK;
    pith_mesh *left = NULL, *moved = NULL;
    pith_erased *ends = NULL;
    PITH_TRY(pith_mesh_erase(at->drawn, from->erase, from->erase_count, &left, &ends, err));
    pith_status status = PITH_OK;
    if (at->mesh == at->drawn) moved = left;
    else status = carry_over(left, ends, pith_mesh_look(at->mesh).positions, &moved, err);
    if (kept && status == PITH_OK) *kept = ends;
    else pith_free(ends);
    if (status != PITH_OK) {
        pith_mesh_destroy(left);
        return status;
    }
    if (at->mesh != at->drawn) pith_mesh_destroy(at->mesh);
    pith_mesh_destroy(at->drawn);
    at->drawn = left;
    at->mesh = moved;
    return PITH_OK;
}

static pith_status draw_feature(const document_body *body, const document_surface *from, const pith_sketch *varied,
                                made_surface *to, pith_error *err)
{
    PITH_TRY(pith_sketch_surface(&body->sketch.drawn, from->feature, &to->drawn, err));
    if (!varied) {
        to->mesh = to->drawn;
        return PITH_OK;
    }
    return pith_sketch_surface(varied, from->feature, &to->mesh, err);
}

/* The vertices of the surface that brushes meet; NULL without brushes. */
static pith_status mark_region(const document_body *body, const document_surface *from, const pith_mesh_view *drawn,
                               bool **marked, pith_error *err)
{
    *marked = NULL;
    if (from->region_count == 0) return PITH_OK;
    *marked = pith_alloc(drawn->vertex_count, sizeof **marked);
    if (!*marked) return PITH_OUT_OF_MEMORY(err, "a region");
    for (size_t i = 0; i < from->region_count; ++i)
        pith_brush_mark(&from->region[i], &body->sketch.drawn, drawn, *marked);
    return PITH_OK;
}

/* Grains over a surface made before. The grain itself is `grain`, on which paint goes; `copies` says how often. */
static pith_status strew_grains(const document_body *body, const document_surface *from, const made_surface *on,
                                const pith_mesh *grain, made_surface *to, size_t *copies, pith_error *err)
{
    const pith_mesh_view drawn = pith_mesh_look(on->drawn), base = pith_mesh_look(on->mesh);
    bool *marked = NULL;
    pith_grain *grains = NULL;
    pith_status status = mark_region(body, from, &drawn, &marked, err);
    if (status == PITH_OK) status = pith_mesh_grains(&base, marked, &from->grains, &grains, copies, err);
    if (status == PITH_OK && *copies == 0)
        status = pith_fail(err, PITH_BAD_DOCUMENT, "not one grain has room; the region holds no whole triangle of "
                           "\"%s\": widen a brush, or give that surface more samples", body->surfaces[from->on].name);
    if (status == PITH_OK) status = pith_grains_mesh(grain, grains, *copies, &to->drawn, err);
    to->mesh = to->drawn;
    pith_free(marked);
    pith_free(grains);
    return status;
}

/* ---- colours --------------------------------------------------------------------------------------------------------- */

/* What is painted of one surface: values by channel, [channels][vertices], and where they are fixed. */
typedef struct coat { bool *fixed; double *values; uint32_t channels; } coat;
enum { COAT_FRONT, COAT_BACK, COAT_BLUR, COATS };

/* The values of all coats lie behind one another. */
static pith_status coats_make(coat coats[COATS], uint32_t vertices, const double base[COATS][4], pith_error *err)
{
    static const uint32_t channels[COATS] = { 4, 4, 1 };
    double *values = pith_alloc((size_t)9 * vertices, sizeof *values);
    if (!values) return PITH_OUT_OF_MEMORY(err, "paint");
    for (int k = 0; k < COATS; ++k) {
        coats[k] = (coat){ pith_alloc(vertices, sizeof *coats[k].fixed), values, channels[k] };
        for (uint32_t c = 0; c < channels[k]; ++c)
            for (uint32_t v = 0; v < vertices; ++v) *values++ = base[k][c];
    }
    const bool made = coats[COAT_FRONT].fixed && coats[COAT_BACK].fixed && coats[COAT_BLUR].fixed;
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "paint");
}

static void coats_clear(coat coats[COATS])
{
    for (int k = 0; k < COATS; ++k) pith_free(coats[k].fixed);
    pith_free(coats[COAT_FRONT].values);
}

static void coat_paint(coat *to, const bool *met, uint32_t vertices, const double *value)
{
    for (uint32_t v = 0; v < vertices; ++v) {
        if (!met[v]) continue;
        to->fixed[v] = true;
        for (uint32_t c = 0; c < to->channels; ++c) to->values[(size_t)c * vertices + v] = value[c];
    }
}

/* Coats that are fixed at the same vertices are spread at once. */
static pith_status coats_spread(coat coats[COATS], const pith_mesh_view *mesh, pith_error *err)
{
    for (int k = 0, next; k < COATS; k = next) {
        uint32_t channels = coats[k].channels;
        bool any = false;
        for (next = k + 1; next < COATS; channels += coats[next++].channels)
            if (memcmp(coats[k].fixed, coats[next].fixed, mesh->vertex_count * sizeof(bool)) != 0) break;
        for (uint32_t v = 0; v < mesh->vertex_count; ++v) any |= coats[k].fixed[v];
        if (any) PITH_TRY(pith_mesh_spread(mesh, coats[k].fixed, channels, coats[k].values, err));
    }
    return PITH_OK;
}

/* What a file says at the vertices of a surface: some of it may have been erased (ends not NULL). */
typedef struct given_attributes {
    const pith_diffusion_surface *read;
    const pith_erased *ends;
} given_attributes;

/* What is given stays where nothing is painted: it is fixed everywhere. */
static void coat_take(coat *to, uint32_t vertices, const pith_erased *ends, const float (*colours)[4], const double *blur)
{
    for (uint32_t v = 0; v < vertices; ++v) {
        to->fixed[v] = true;
        for (uint32_t c = 0; c < to->channels; ++c) {
            double *value = &to->values[(size_t)c * vertices + v];
            if (!ends) {
                *value = colours ? colours[v][c] : blur[v];
                continue;
            }
            *value = 0.0;
            for (int k = 0; k < 3; ++k) {
                const uint32_t corner = ends[v].corner[k];
                *value += ends[v].weight[k] * (colours ? colours[corner][c] : blur[corner]);
            }
        }
    }
}

static void coats_take(const document_surface *from, const given_attributes *given, uint32_t vertices, coat coats[COATS])
{
    const pith_diffusion_surface *read = given->read;
    const float(*front)[4] = read->front ? read->front : read->back, (*back)[4] = read->back ? read->back : front;
    if (front && !from->coloured) {
        coat_take(&coats[COAT_FRONT], vertices, given->ends, front, NULL);
        coat_take(&coats[COAT_BACK], vertices, given->ends, back, NULL);
    }
    if (read->blur && !(from->look.blur > 0.0))
        coat_take(&coats[COAT_BLUR], vertices, given->ends, NULL, read->blur);
}

static pith_status coats_paint(const document_body *body, const document_surface *from, const pith_mesh_view *mesh,
                               const given_attributes *given, coat coats[COATS], pith_error *err)
{
    const uint32_t vertices = mesh->vertex_count;
    const double opacity = from->look.opacity;
    const double base[COATS][4] = { { from->front[0], from->front[1], from->front[2], opacity },
                                    { from->back[0], from->back[1], from->back[2], opacity },
                                    { from->look.blur } };
    PITH_TRY(coats_make(coats, vertices, base, err));
    if (given) coats_take(from, given, vertices, coats);
    bool *met = pith_alloc(vertices, sizeof *met);
    if (!met) return PITH_OUT_OF_MEMORY(err, "paint");
    for (size_t i = 0; i < from->paint_count; ++i) {
        const document_paint *paint = &from->paint[i];
        const double values[COATS][4] = { { paint->front[0], paint->front[1], paint->front[2], opacity },
                                          { paint->back[0], paint->back[1], paint->back[2], opacity },
                                          { paint->blur } };
        memset(met, 0, vertices * sizeof *met);
        pith_brush_mark(&paint->brush, &body->sketch.drawn, mesh, met);
        if (paint->has_front) coat_paint(&coats[COAT_FRONT], met, vertices, values[COAT_FRONT]);
        if (paint->has_back) coat_paint(&coats[COAT_BACK], met, vertices, values[COAT_BACK]);
        if (paint->has_blur) coat_paint(&coats[COAT_BLUR], met, vertices, values[COAT_BLUR]);
    }
    pith_free(met);
    return coats_spread(coats, mesh, err);
}

/* Colours of one side, once for each copy of the vertices. */
static pith_status colours_of(const coat *from, uint32_t vertices, size_t copies, float (**colours)[4], pith_error *err)
{
    float(*made)[4] = pith_alloc(vertices * copies, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "colours");
    for (size_t i = 0; i < vertices * copies; ++i)
        for (size_t c = 0; c < 4; ++c) made[i][c] = (float)from->values[c * vertices + i % vertices];
    *colours = made;
    return PITH_OK;
}

static pith_status blur_of(const coat *from, uint32_t vertices, size_t copies, double scale, double **blur,
                           pith_error *err)
{
    bool any = false;
    for (uint32_t v = 0; v < vertices; ++v) any |= from->values[v] > 0.0;
    if (!any) return PITH_OK;
    *blur = pith_alloc(vertices * copies, sizeof **blur);
    if (!*blur) return PITH_OUT_OF_MEMORY(err, "blur");
    for (size_t i = 0; i < vertices * copies; ++i) (*blur)[i] = scale * from->values[i % vertices];
    return PITH_OK;
}

/* Colours and blur of the vertices of `painted`, which stands so often in the surface. */
static pith_status colour_surface(const document_body *body, const document_surface *from, const pith_mesh *painted,
                                  const given_attributes *given, size_t copies, made_surface *to, pith_error *err)
{
    const pith_mesh_view mesh = pith_mesh_look(painted);
    const double scale = body->placed ? body->placement.scale : 1.0;
    const bool two_sided = from->two_sided || (given && given->read->back && !from->coloured);
    coat coats[COATS] = { 0 };
    pith_status status = coats_paint(body, from, &mesh, given, coats, err);
    if (status == PITH_OK) status = colours_of(&coats[COAT_FRONT], mesh.vertex_count, copies, &to->front, err);
    if (status == PITH_OK && two_sided)
        status = colours_of(&coats[COAT_BACK], mesh.vertex_count, copies, &to->back, err);
    if (status == PITH_OK) status = blur_of(&coats[COAT_BLUR], mesh.vertex_count, copies, scale, &to->blur, err);
    coats_clear(coats);
    return status;
}

/* ---- one surface ----------------------------------------------------------------------------------------------------- */

static pith_status make_grains(const document_body *body, const document_surface *from, const made_surface *on,
                               made_surface *to, pith_error *err)
{
    size_t copies = 0;
    PITH_TRY(pith_grain_surface(&from->profile, &from->outline, from->grain.across, from->grain.along, &to->grain, err));
    PITH_TRY(strew_grains(body, from, on, to->grain, to, &copies, err));
    return colour_surface(body, from, to->grain, NULL, copies, to, err);
}

/* The file's surface that is meant. */
static pith_status choose_part(const document_surface *from, const pith_diffusion_surfaces_view *all, size_t *chosen,
                               pith_error *err)
{
    char list[300] = "";
    for (size_t i = 0; i < all->count; ++i) {
        const char *name = all->surfaces[i].name;
        *chosen = i;
        if (from->part && name && strcmp(name, from->part) == 0) return PITH_OK;
        const size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s\"%s\"", i ? ", " : "", name ? name : "");
    }
    if (!from->part && all->count == 1) return PITH_OK;
    if (!from->part)
        return pith_fail(err, PITH_BAD_DOCUMENT, "%s has %zu surfaces; say which with \"part\", one of %s", from->file,
                         all->count, list);
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s has no surface \"%s\", expected one of %s", from->file, from->part, list);
}

static pith_status make_from_file(const document_body *body, const document_surface *from, made_surface *to, pith_error *err)
{
    pith_diffusion_surfaces *read = NULL;
    PITH_TRY(pith_diffusion_surfaces_read(from->file, &read, err));
    const pith_diffusion_surfaces_view all = pith_diffusion_surfaces_look(read);
    size_t chosen = 0;
    pith_erased *ends = NULL;
    pith_status status = choose_part(from, &all, &chosen, err);
    if (status == PITH_OK) status = pith_mesh_create(&all.surfaces[chosen].mesh, &to->drawn, err);
    to->mesh = to->drawn;
    if (status == PITH_OK) status = erase_parts(from, to, &ends, err);
    const given_attributes given = { &all.surfaces[chosen], ends };
    /* Only this part's colours matter, not those of others in the file. */
    const bool bare = !from->coloured && from->paint_count == 0 && !given.read->front && !given.read->back;
    if (status == PITH_OK && bare)
        status = pith_diffusion_surfaces_coloured(read, err);
    if (status == PITH_OK) status = colour_surface(body, from, to->drawn, &given, 1, to, err);
    if (status == PITH_OK) {
        to->hide_front = given.read->hide_front;
        to->hide_back = given.read->hide_back;
    }
    pith_free(ends);
    pith_diffusion_surfaces_destroy(read);
    return status;
}

static pith_status make_surface(pith_model *model, const document_surface *from, const pith_sketch *varied,
                                const made_surface *before, made_surface *to, pith_error *err)
{
    const document_body *body = model->body;
    const size_t length = strlen(from->name);
    to->name = pith_alloc(length + 1, 1);
    if (!to->name) return PITH_OUT_OF_MEMORY(err, "a surface");
    memcpy(to->name, from->name, length);
    switch (from->kind) {
    case SURFACE_AROUND:
    case SURFACE_CHAMBERS: PITH_TRY(draw_feature(body, from, varied, to, err)); break;
    case SURFACE_GRAINS: PITH_TRY(make_grains(body, from, &before[from->on], to, err)); break;
    case SURFACE_FILE: return make_from_file(body, from, to, err);
    case SURFACE_BODY: {
        const pith_mesh *mesh;
        PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
        const pith_mesh_view view = pith_mesh_look(mesh);
        PITH_TRY(pith_mesh_create(&view, &to->drawn, err));
    }
    }
    if (!to->mesh) to->mesh = to->drawn;
    if (from->kind == SURFACE_GRAINS) return PITH_OK;
    PITH_TRY(erase_parts(from, to, NULL, err));
    return colour_surface(body, from, to->drawn, NULL, 1, to, err);
}

/* Surfaces stand where the body's "place" says; the body's own does already. */
static pith_status place_surface(const document_body *body, const document_surface *from, made_surface *at,
                                 pith_error *err)
{
    if (!body->placed || from->kind == SURFACE_BODY) return PITH_OK;
    pith_mesh *placed = NULL;
    PITH_TRY(pith_mesh_placed(at->mesh, &body->placement, &placed, err));
    if (at->mesh != at->drawn) pith_mesh_destroy(at->mesh);
    at->mesh = placed;
    return PITH_OK;
}

/* ---- all of them ------------------------------------------------------------------------------------------------------ */

static pith_status surface_fail(const pith_model *model, size_t index, pith_status status, pith_error *err)
{
    char place[40];
    snprintf(place, sizeof place, "surfaces[%zu]", index);
    return model_fail_at(model, status, place, NULL, NULL, err);
}

static pith_status make_surfaces(pith_model *model, body_surfaces *made, pith_error *err)
{
    const document_body *body = model->body;
    const document_sketch *sketch = &body->sketch;
    pith_varied_sketch *varied = NULL;
    if (sketch->varied && sketch->drawn.feature_count > 0) {
        const pith_status status = pith_sketch_vary(&sketch->drawn, &sketch->variation, &varied, err);
        if (status != PITH_OK) return model_fail_at(model, status, "sketch.variation", NULL, NULL, err);
        made->strength = pith_varied_sketch_strength(varied);
    }
    const pith_sketch *drawn = varied ? pith_varied_sketch_look(varied) : NULL;
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < made->count; ++i) {
        status = pith_progress_step(model->progress, (double)i / (double)made->count, "surfaces", err);
        if (status != PITH_OK) break;
        status = make_surface(model, &body->surfaces[i], drawn, made->items, &made->items[i], err);
        if (status != PITH_OK) status = surface_fail(model, i, status, err);
    }
    /* Only now: grains lie on surfaces that have not been placed. */
    for (size_t i = 0; status == PITH_OK && i < made->count; ++i)
        status = place_surface(body, &body->surfaces[i], &made->items[i], err);
    pith_varied_sketch_destroy(varied);
    return status;
}

void model_note_variation(pith_model *model)
{
    const document_sketch *sketch = &model->body->sketch;
    const double wanted = sketch->variation.strength, strength = model->surfaces->strength;
    if (!sketch->varied || sketch->drawn.feature_count == 0 || !(strength < wanted)) return;
    if (strength > 0.0)
        model_note(model, "%ssketch.variation: its strength is %.2g instead of %.2g, because curves would have crossed or "
                   "left their folds", model->body->place, strength, wanted);
    else
        model_note(model, "%ssketch.variation: all is as it was drawn, because curves would have crossed or left their "
                   "folds whatever the strength; leave more room between them", model->body->place);
}

static void look_at_surfaces(const document_body *body, body_surfaces *made)
{
    for (size_t i = 0; i < made->count; ++i) {
        const document_surface *from = &body->surfaces[i];
        const made_surface *at = &made->items[i];
        made->views[i] = (pith_diffusion_surface){
            .name = at->name, .mesh = pith_mesh_look(at->mesh),
            .front = (const float(*)[4])at->front, .back = (const float(*)[4])at->back, .blur = at->blur,
            .hide_front = at->hide_front || from->look.hide == HIDE_FRONT,
            .hide_back = at->hide_back || from->look.hide == HIDE_BACK,
        };
    }
}

pith_status pith_model_surfaces(pith_model *model, const pith_diffusion_surface **surfaces, size_t *count,
                                pith_error *err)
{
    PITH_TRY(model_one_body(model, err));
    const size_t wanted = model->body->surface_count;
    if (!model->surfaces) {
        const double start = pith_seconds();
        body_surfaces *made = pith_alloc(1, sizeof *made);
        if (!made) return PITH_OUT_OF_MEMORY(err, "surfaces");
        made->count = wanted;
        made->items = pith_alloc(wanted, sizeof *made->items);
        made->views = pith_alloc(wanted, sizeof *made->views);
        pith_status status = made->items && made->views ? make_surfaces(model, made, err)
                                                        : PITH_OUT_OF_MEMORY(err, "surfaces");
        if (status != PITH_OK) {
            body_surfaces_destroy(made);
            return status;
        }
        look_at_surfaces(model->body, made);
        PITH_TRY(model_hold(model, STAGE_SURFACES, made, err));
        model_note_variation(model);
        model_took(model, offsetof(pith_model_times, shape), start);
    }
    if (surfaces) *surfaces = model->surfaces->views;
    if (count) *count = wanted;
    return PITH_OK;
}

pith_status pith_model_surface_drawn(pith_model *model, size_t index, pith_mesh_view *drawn, pith_error *err)
{
    size_t count = 0;
    PITH_TRY(pith_model_surfaces(model, NULL, &count, err));
    if (index >= count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "surface %zu is asked for, but the body has %zu", index, count);
    const made_surface *at = &model->surfaces->items[index];
    *drawn = pith_mesh_look(at->grain ? at->grain : at->drawn);
    return PITH_OK;
}

/* ---- the body's form, and its solid ------------------------------------------------------------------------------------ */

pith_status surfaces_mesh(pith_model *model, pith_mesh **mesh, pith_error *err)
{
    const pith_diffusion_surface *all;
    const document_body *body = model->body;
    PITH_TRY(pith_model_surfaces(model, &all, NULL, err));
    pith_mesh_view joined = { 0 };
    for (size_t i = 0; i < body->bound_count; ++i) {
        joined.vertex_count += all[body->bounds[i]].mesh.vertex_count;
        joined.triangle_count += all[body->bounds[i]].mesh.triangle_count;
    }
    pith_vec3 *positions = pith_alloc(joined.vertex_count, sizeof *positions);
    uint32_t(*triangles)[3] = pith_alloc(joined.triangle_count, sizeof *triangles);
    pith_status status = positions && triangles ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a shape");
    uint32_t vertices = 0, count = 0;
    for (size_t i = 0; status == PITH_OK && i < body->bound_count; ++i) {
        const pith_mesh_view from = all[body->bounds[i]].mesh;
        memcpy(positions + vertices, from.positions, from.vertex_count * sizeof *positions);
        for (uint32_t t = 0; t < from.triangle_count; ++t, ++count)
            for (int k = 0; k < 3; ++k) triangles[count][k] = vertices + from.triangles[t][k];
        vertices += from.vertex_count;
    }
    joined.positions = positions;
    joined.triangles = (const uint32_t(*)[3])triangles;
    if (status == PITH_OK) status = pith_mesh_create(&joined, mesh, err);
    pith_free(positions);
    pith_free(triangles);
    return status;
}

pith_status surfaces_diffusion(pith_model *model, const document_solid *solid, pith_diffusion **made, pith_error *err)
{
    const pith_diffusion_surface *all;
    PITH_TRY(pith_model_surfaces(model, &all, NULL, err));
    pith_diffusion_surface *used = pith_alloc(solid->surface_count, sizeof *used);
    if (!used) return PITH_OUT_OF_MEMORY(err, "surfaces");
    for (size_t i = 0; i < solid->surface_count; ++i) used[i] = all[solid->surfaces[i]];
    const pith_status status = pith_diffusion_create(used, solid->surface_count, made, err);
    pith_free(used);
    return status;
}
