/* Faces of a body: which triangles of its cleaned mesh are painted and how deep, and which of them the faces of its tets
   are. */
#include "model_internal.h"

#include <string.h>

/* ---- which triangles a constraint is about ----------------------------------------------------------------------------- */

/* Marks the triangles of the cleaned mesh that constraint i lists. */
static pith_status choose_listed(const pith_model *model, size_t i, const pith_mesh_view *mesh, bool *chosen,
                                 pith_error *err)
{
    const pith_depth_constraint *c = &model->body->constraints[i];
    for (size_t f = 0; f < c->count; ++f) {
        if (c->faces[f] >= mesh->triangle_count)
            return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %sdepth.constraints[%zu].faces[%zu]: is %u, but the cleaned "
                             "mesh has %u triangles", model->document->path, model->body->place, i, f, c->faces[f],
                             mesh->triangle_count);
        chosen[c->faces[f]] = true;
    }
    return PITH_OK;
}

size_t facing_mark(const document_facing *to, const pith_mesh_view *mesh, bool *marked)
{
    const double least = cos(to->within * M_PI / 180.0);
    size_t count = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corner = mesh->triangles[t];
        const pith_vec3 a = mesh->positions[corner[0]];
        const pith_vec3 across = pith_cross(pith_sub(mesh->positions[corner[1]], a),
                                            pith_sub(mesh->positions[corner[2]], a));
        const double size = pith_length(across);
        marked[t] = size > 0.0 && pith_dot(across, to->direction) >= least * size;
        count += marked[t];
    }
    return count;
}

/* The same for one that says where its triangles look. */
static pith_status choose_facing(const pith_model *model, size_t i, const pith_mesh_view *mesh, bool *chosen,
                                 pith_error *err)
{
    const document_facing *to = &model->body->facing[i];
    if (facing_mark(to, mesh, chosen) > 0) return PITH_OK;
    return pith_fail(err, PITH_BAD_DOCUMENT, "%s: %sdepth.constraints[%zu].facing: no triangle faces [%g, %g, %g] within "
                     "%g degrees; turn it, or make \"within\" larger", model->document->path, model->body->place, i,
                     to->direction.x, to->direction.y, to->direction.z, to->within);
}

/* Marks the triangles that constraint i is about, and no others. It is one of faces. */
static pith_status choose(const pith_model *model, size_t i, const pith_mesh_view *mesh, bool *chosen, pith_error *err)
{
    const pith_depth_constraint *c = &model->body->constraints[i];
    memset(chosen, c->kind == PITH_DEPTH_ALL_FACES, mesh->triangle_count * sizeof *chosen);
    if (c->kind == PITH_DEPTH_ALL_FACES) return PITH_OK;
    return c->faces ? choose_listed(model, i, mesh, chosen, err) : choose_facing(model, i, mesh, chosen, err);
}

/* ---- what is painted ----------------------------------------------------------------------------------------------------- */

/* Where several constraints are about a face, the last holds, as when faces are painted over. */
static pith_status paint(const pith_model *model, const pith_mesh_view *mesh, float *depth, pith_error *err)
{
    const document_body *body = model->body;
    bool *chosen = pith_alloc(mesh->triangle_count, sizeof *chosen);
    if (!chosen) return PITH_OUT_OF_MEMORY(err, "painted faces");
    for (uint32_t f = 0; f < mesh->triangle_count; ++f) depth[f] = NAN;
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < body->constraint_count; ++i) {
        const pith_depth_constraint *c = &body->constraints[i];
        if (c->kind != PITH_DEPTH_FACES && c->kind != PITH_DEPTH_ALL_FACES) continue;
        status = choose(model, i, mesh, chosen, err);
        for (uint32_t f = 0; status == PITH_OK && f < mesh->triangle_count; ++f)
            if (chosen[f]) depth[f] = (float)c->depth;
    }
    pith_free(chosen);
    return status;
}

pith_status pith_model_painted(pith_model *model, const float **depth, uint32_t *count, pith_error *err)
{
    const pith_mesh *mesh;
    PITH_TRY(pith_model_mesh(model, &mesh, NULL, err));
    const pith_mesh_view view = pith_mesh_look(mesh);
    if (!model->painted) {
        float *made = pith_alloc(view.triangle_count, sizeof *made);
        if (!made) return PITH_OUT_OF_MEMORY(err, "painted faces");
        const pith_status status = paint(model, &view, made, err);
        if (status != PITH_OK) {
            pith_free(made);
            return status;
        }
        PITH_TRY(model_hold(model, STAGE_PAINTED, made, err));
    }
    if (depth) *depth = model->painted;
    if (count) *count = view.triangle_count;
    return PITH_OK;
}

/* ---- which triangles the tets' faces are ----------------------------------------------------------------------------------- */

/* The triangle of the cleaned mesh nearest to the middle of each surface triangle. */
static pith_status find_nearest(const pith_mesh_view *mesh, const pith_mesh_view *surface, pith_nearest *nearest,
                                pith_error *err)
{
    pith_vec3 *middles = pith_alloc(surface->triangle_count, sizeof *middles);
    if (!middles) return PITH_OUT_OF_MEMORY(err, "faces");
    for (uint32_t t = 0; t < surface->triangle_count; ++t) {
        const uint32_t *corner = surface->triangles[t];
        const pith_vec3 sum = pith_add(pith_add(surface->positions[corner[0]], surface->positions[corner[1]]),
                                       surface->positions[corner[2]]);
        middles[t] = pith_scale(sum, 1.0 / 3.0);
    }
    pith_tracer *tracer = NULL;
    const pith_status status = pith_tracer_create(mesh, &tracer, err);
    if (status == PITH_OK) pith_tracer_nearest(tracer, middles, surface->triangle_count, nearest);
    pith_tracer_destroy(tracer);
    pith_free(middles);
    return status;
}

/* faces: [tet_count][4]. The surface of the tets may be ordered otherwise than the mesh, refined, or remeshed: a face
   belongs to the triangle nearest to its middle, which for a face of the mesh is that face. */
static pith_status find_faces(const pith_mesh *mesh, const pith_tets *tets, uint32_t (*faces)[4], pith_error *err)
{
    pith_mesh *surface = NULL;
    PITH_TRY(pith_tets_surface(tets, &surface, NULL, NULL, err));
    const pith_mesh_view inner = pith_mesh_look(mesh), outer = pith_mesh_look(surface);
    const pith_tets_view view = pith_tets_look(tets);
    pith_nearest *nearest = pith_alloc(outer.triangle_count, sizeof *nearest);
    const pith_status status = nearest ? find_nearest(&inner, &outer, nearest, err) : PITH_OUT_OF_MEMORY(err, "faces");
    uint32_t next = 0; /* the surface's triangles are in the order of tets and, of a tet, of corners */
    for (uint32_t t = 0; status == PITH_OK && t < view.tet_count; ++t)
        for (int k = 0; k < 4; ++k)
            faces[t][k] = view.neighbours[t][k] == PITH_NONE ? nearest[next++].triangle : PITH_NONE;
    pith_free(nearest);
    pith_mesh_destroy(surface);
    return status;
}

static pith_status build_faces(const pith_model *model, const pith_tets *tets, uint32_t (**faces)[4], pith_error *err)
{
    uint32_t(*made)[4] = pith_alloc(pith_tets_look(tets).tet_count, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "faces");
    const pith_status status = find_faces(model->mesh, tets, made, err);
    if (status == PITH_OK) *faces = made;
    else pith_free(made);
    return status;
}

pith_status pith_model_surface_faces(pith_model *model, const uint32_t (**faces)[4], pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    PITH_TRY(pith_model_mesh(model, NULL, NULL, err));
    if (!model->faces) {
        uint32_t(*made)[4] = NULL;
        PITH_TRY(build_faces(model, model->tets, &made, err));
        PITH_TRY(model_hold(model, STAGE_FACES, made, err));
    }
    if (faces) *faces = (const uint32_t(*)[4])model->faces;
    return PITH_OK;
}

/* ---- painted faces of tets ------------------------------------------------------------------------------------------------ */

/* Makes the constraint one of the surface's triangles that belong to chosen ones. */
static pith_status map_chosen(const pith_tets_view *tets, const uint32_t (*faces)[4], const bool *chosen, arena *memory,
                              pith_depth_constraint *c, pith_error *err)
{
    uint32_t surface_count = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) surface_count += tets->neighbours[t][k] == PITH_NONE;
    uint32_t *mapped = arena_alloc(memory, surface_count, sizeof *mapped);
    if (!mapped) return PITH_OUT_OF_MEMORY(err, "painted faces");
    uint32_t next = 0;
    c->count = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            if (tets->neighbours[t][k] != PITH_NONE) continue;
            if (faces[t][k] != PITH_NONE && chosen[faces[t][k]]) mapped[c->count++] = next;
            ++next;
        }
    c->faces = mapped;
    return PITH_OK;
}

pith_status model_map_faces(pith_model *model, const pith_tets *tets, pith_depth_constraint *constraints, size_t count,
                            arena *memory, pith_error *err)
{
    bool any = false;
    for (size_t i = 0; i < count; ++i) any |= constraints[i].kind == PITH_DEPTH_FACES;
    if (!any) return PITH_OK;

    const uint32_t(*faces)[4];
    uint32_t(*own)[4] = NULL; /* of tets that are still being refined */
    PITH_TRY(pith_model_mesh(model, NULL, NULL, err));
    if (tets == model->tets) PITH_TRY(pith_model_surface_faces(model, &faces, err));
    else PITH_TRY(build_faces(model, tets, &own, err));
    if (own) faces = (const uint32_t(*)[4])own;

    const pith_mesh_view mesh = pith_mesh_look(model->mesh);
    const pith_tets_view view = pith_tets_look(tets);
    bool *chosen = arena_alloc(memory, mesh.triangle_count, sizeof *chosen);
    pith_status status = chosen ? PITH_OK : PITH_OUT_OF_MEMORY(err, "painted faces");
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        if (constraints[i].kind != PITH_DEPTH_FACES) continue;
        status = choose(model, i, &mesh, chosen, err);
        if (status == PITH_OK) status = map_chosen(&view, faces, chosen, memory, &constraints[i], err);
    }
    pith_free(own);
    return status;
}
