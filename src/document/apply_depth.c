/* Painting depth: the multi-face-fill, the single-face-fill and the stroke tool of Takayama 2008, §4.3, and the points
   of Takayama 2011, §4.4.1. A face has one depth at most: painting takes it out of the constraint it was in. */
#include <string.h>

#include "apply_internal.h"

/* The paint at hand. */
typedef struct painter {
    edit *at;
    const pith_mesh *mesh;
    pith_mesh_view view;
    bool *chosen;           /* [triangle_count] the faces the operation is about */
} painter;

static json_t *constraints_of(const edit *at)
{
    return json_object_get(json_object_get(at->body, "depth"), "constraints");
}

/* ---- which faces ------------------------------------------------------------------------------------------------- */

static pith_status face_of_ray(const painter *from, const json_t *ray, uint32_t *face)
{
    const pith_ray asked = { json_point(json_object_get(ray, "origin")), json_point(json_object_get(ray, "direction")),
                             0.0, INFINITY };
    if (!(pith_length(asked.direction) > 0.0))
        return edit_refuse(from->at, "ray.direction", "has no length; any other vector will do");
    pith_tracer *tracer = NULL;
    PITH_TRY(pith_tracer_create(&from->view, &tracer, from->at->in.err));
    pith_hit hit;
    pith_tracer_hits(tracer, &asked, 1, &hit);
    pith_tracer_destroy(tracer);
    if (hit.triangle == PITH_NONE) return edit_refuse(from->at, "ray", "does not meet the body");
    *face = hit.triangle;
    return PITH_OK;
}

static pith_status check_face(const painter *from, const char *place, json_int_t face)
{
    if (face < from->view.triangle_count) return PITH_OK;
    return edit_refuse(from->at, place, "is %lld, but the cleaned mesh has %u triangles, counted from 0",
                       (long long)face, from->view.triangle_count);
}

/* The face of "face" or "ray". */
static pith_status one_face(const painter *from, uint32_t *face)
{
    const json_t *ray = json_object_get(from->at->asked, "ray");
    if (ray) return face_of_ray(from, ray, face);
    const json_int_t asked = json_integer_value(json_object_get(from->at->asked, "face"));
    PITH_TRY(check_face(from, "face", asked));
    *face = (uint32_t)asked;
    return PITH_OK;
}

/* Chooses what "face", "faces" or "ray" say. */
static pith_status choose(painter *from)
{
    const json_t *faces = json_object_get(from->at->asked, "faces");
    if (!faces) {
        uint32_t face;
        PITH_TRY(one_face(from, &face));
        from->chosen[face] = true;
        return PITH_OK;
    }
    if (json_is_string(faces)) memset(from->chosen, true, from->view.triangle_count);
    for (size_t i = 0; i < json_array_size(faces); ++i) {
        char place[40];
        snprintf(place, sizeof place, "faces[%zu]", i);
        const json_int_t face = json_integer_value(json_array_get(faces, i));
        PITH_TRY(check_face(from, place, face));
        from->chosen[face] = true;
    }
    return PITH_OK;
}

/* Which constraint has each face, as the index of the first one of that depth; -1: none. */
static void label_faces(const painter *from, int32_t *labels)
{
    const json_t *constraints = constraints_of(from->at);
    for (uint32_t f = 0; f < from->view.triangle_count; ++f) labels[f] = -1;
    for (size_t i = 0; i < json_array_size(constraints); ++i) {
        const json_t *constraint = json_array_get(constraints, i), *faces = json_object_get(constraint, "faces");
        const double depth = json_number_value(json_object_get(constraint, "depth"));
        size_t first = 0;
        while (json_number_value(json_object_get(json_array_get(constraints, first), "depth")) != depth) ++first;
        for (uint32_t f = 0; json_is_string(faces) && f < from->view.triangle_count; ++f) labels[f] = (int32_t)first;
        for (size_t k = 0; k < json_array_size(faces); ++k)
            labels[json_integer_value(json_array_get(faces, k))] = (int32_t)first;
    }
}

/* Chooses what a fill reaches from its face. */
static pith_status flood(painter *from)
{
    pith_error *err = from->at->in.err;
    uint32_t face;
    PITH_TRY(one_face(from, &face));
    const json_t *asked = json_object_get(from->at->asked, "crease");
    const double crease = asked ? json_number_value(asked)
                                : pith_params_find(from->at->how->rules.params, "crease")->standard;
    int32_t *labels = pith_alloc(from->view.triangle_count, sizeof *labels);
    if (!labels) return PITH_OUT_OF_MEMORY(err, "painted faces");
    label_faces(from, labels);
    uint32_t *faces = NULL;
    size_t count = 0;
    const pith_status status = pith_faces_fill(from->mesh, face, labels, crease, &faces, &count, err);
    for (size_t i = 0; i < count; ++i) from->chosen[faces[i]] = true;
    pith_free(faces);
    pith_free(labels);
    return status == PITH_OK ? PITH_OK : pith_fail_in(err, status, "%s", from->at->in.file);
}

/* ---- paint on and off -------------------------------------------------------------------------------------------- */

/* The faces marked in `is` (or, with `is` false, those not marked), as a document has them. */
static json_t *faces_json(painter *from, const bool *marked, bool is)
{
    json_t *list = json_array();
    for (uint32_t f = 0; list && f < from->view.triangle_count; ++f)
        if (marked[f] == is) edit_append(from->at, list, json_integer(f));
    if (json_array_size(list) < from->view.triangle_count) return list;
    json_decref(list);
    return json_string("all");
}

/* Takes the chosen faces out of a constraint; false when none are left in it. */
static bool take_out(painter *from, json_t *constraint)
{
    const json_t *faces = json_object_get(constraint, "faces");
    json_t *left = NULL;
    if (json_is_string(faces)) {
        left = faces_json(from, from->chosen, false);
    } else {
        left = json_array();
        for (size_t i = 0; i < json_array_size(faces); ++i) {
            json_t *face = json_array_get(faces, i);
            if (!from->chosen[json_integer_value(face)]) edit_append(from->at, left, json_incref(face));
        }
    }
    const bool any = json_is_string(left) || json_array_size(left) > 0;
    edit_put(from->at, constraint, "faces", left);
    return any;
}

/* Adds the chosen faces to a constraint. */
static void join(painter *from, json_t *constraint)
{
    const json_t *faces = json_object_get(constraint, "faces");
    if (json_is_string(faces)) return;
    for (size_t i = 0; i < json_array_size(faces); ++i)
        from->chosen[json_integer_value(json_array_get(faces, i))] = true;
    edit_put(from->at, constraint, "faces", faces_json(from, from->chosen, true));
}

/* Gives the chosen faces this depth; NULL: none. */
static void paint(painter *from, const json_t *depth)
{
    json_t *holder = depth ? edit_child(from->at, from->at->body, "depth", json_object)
                           : json_object_get(from->at->body, "depth");
    json_t *constraints = depth ? edit_child(from->at, holder, "constraints", json_array) : constraints_of(from->at);
    json_t *same = NULL;
    for (size_t i = 0; i < json_array_size(constraints);) {
        json_t *constraint = json_array_get(constraints, i);
        const bool faces = json_object_get(constraint, "faces") != NULL;
        const bool alike = faces && depth && !same && json_number_value(json_object_get(constraint, "depth")) ==
                                                          json_number_value(depth);
        if (alike) same = constraint;
        if (!faces || alike || take_out(from, constraint)) ++i;
        else json_array_remove(constraints, i);
    }
    if (same) join(from, same);
    else if (depth)
        edit_append(from->at, constraints, json_pack("{so sO}", "faces", faces_json(from, from->chosen, true), "depth",
                                                     depth));
    else if (holder && json_array_size(constraints) == 0) edit_drop_list(from->at->body, "depth", "constraints");
}

/* ---- operations -------------------------------------------------------------------------------------------------- */

/* Every face a document names is there: what follows uses them as indices. */
static pith_status check_painted(const painter *from)
{
    const json_t *constraints = constraints_of(from->at);
    for (size_t i = 0; i < json_array_size(constraints); ++i) {
        const json_t *faces = json_object_get(json_array_get(constraints, i), "faces");
        for (size_t k = 0; k < json_array_size(faces); ++k) {
            const json_int_t face = json_integer_value(json_array_get(faces, k));
            if (face < from->view.triangle_count) continue;
            return pith_fail(from->at->in.err, PITH_BAD_DOCUMENT, "%s: %s: depth.constraints[%zu].faces[%zu]: is %lld, "
                             "but the cleaned mesh has %u triangles", from->at->in.file, from->at->path, i, k,
                             (long long)face, from->view.triangle_count);
        }
    }
    return PITH_OK;
}

static pith_status with_faces(edit *at, pith_status (*select)(painter *from))
{
    painter from = { .at = at };
    PITH_TRY(edit_mesh(at, &from.mesh));
    from.view = pith_mesh_look(from.mesh);
    from.chosen = pith_alloc(from.view.triangle_count, sizeof *from.chosen);
    if (!from.chosen) return PITH_OUT_OF_MEMORY(at->in.err, "painted faces");
    pith_status status = check_painted(&from);
    if (status == PITH_OK) status = select(&from);
    if (status == PITH_OK) paint(&from, json_object_get(at->asked, "depth"));
    pith_free(from.chosen);
    return status;
}

pith_status apply_depth_fill(edit *at) { return with_faces(at, flood); }
pith_status apply_depth_faces(edit *at) { return with_faces(at, choose); }
pith_status apply_depth_erase(edit *at) { return with_faces(at, choose); }
