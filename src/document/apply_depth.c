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
    bool *marked;           /* [triangle_count] scratch */
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

/* Marks the faces that a constraint of faces is about, and no others. */
static void mark_painted(const painter *from, const json_t *constraint, bool *marked)
{
    const json_t *faces = json_object_get(constraint, "faces"), *facing = json_object_get(constraint, "facing");
    memset(marked, json_is_string(faces), from->view.triangle_count);
    for (size_t i = 0; i < json_array_size(faces); ++i) marked[json_integer_value(json_array_get(faces, i))] = true;
    if (!facing) return;
    depth_value value;
    json_options(constraint, &document_constraint_params, &value);
    const document_facing to = { pith_unit(json_point(facing)), value.within };
    facing_mark(&to, &from->view, marked);
}

/* Is it one of faces, by list or by where they look? */
static bool is_painted(const json_t *constraint)
{
    return json_object_get(constraint, "faces") || json_object_get(constraint, "facing");
}

static double depth_of(const json_t *constraint) { return json_number_value(json_object_get(constraint, "depth")); }

/* Which constraint has each face, as the index of the first one of that depth; -1: none. */
static void label_faces(const painter *from, int32_t *labels)
{
    const json_t *constraints = constraints_of(from->at);
    for (uint32_t f = 0; f < from->view.triangle_count; ++f) labels[f] = -1;
    for (size_t i = 0; i < json_array_size(constraints); ++i) {
        const json_t *constraint = json_array_get(constraints, i);
        if (!is_painted(constraint)) continue;
        size_t first = 0;
        while (depth_of(json_array_get(constraints, first)) != depth_of(constraint)) ++first;
        mark_painted(from, constraint, from->marked);
        for (uint32_t f = 0; f < from->view.triangle_count; ++f)
            if (from->marked[f]) labels[f] = (int32_t)first;
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

/* Gives a constraint the marked faces, as a list. */
static void put_faces(painter *from, json_t *constraint)
{
    json_t *list = json_array();
    for (uint32_t f = 0; list && f < from->view.triangle_count; ++f)
        if (from->marked[f]) edit_append(from->at, list, json_integer(f));
    if (json_array_size(list) == from->view.triangle_count) {
        json_decref(list);
        list = json_string("all");
    }
    edit_put(from->at, constraint, "faces", list);
    json_object_del(constraint, "facing");
    json_object_del(constraint, "within");
}

/* Takes the chosen faces out of a constraint; false when that was all it had. */
static bool take_out(painter *from, json_t *constraint)
{
    size_t taken = 0, left = 0;
    mark_painted(from, constraint, from->marked);
    for (uint32_t f = 0; f < from->view.triangle_count; ++f) {
        if (!from->marked[f]) continue;
        from->marked[f] = !from->chosen[f];
        ++*(from->chosen[f] ? &taken : &left);
    }
    if (taken > 0 && left > 0) put_faces(from, constraint);
    return left > 0 || taken == 0;
}

/* Joins the chosen faces to the first constraint of that depth, or to a new one. Those that have it need not. */
static void join(painter *from, json_t *list, const json_t *depth)
{
    json_t *first = NULL;
    for (size_t i = json_array_size(list); i-- > 0;) {
        json_t *constraint = json_array_get(list, i);
        if (!is_painted(constraint) || depth_of(constraint) != json_number_value(depth)) continue;
        first = constraint;
        mark_painted(from, constraint, from->marked);
        for (uint32_t f = 0; f < from->view.triangle_count; ++f) from->chosen[f] &= !from->marked[f];
    }
    if (!memchr(from->chosen, true, from->view.triangle_count)) return;
    if (first) mark_painted(from, first, from->marked);
    else memset(from->marked, false, from->view.triangle_count);
    for (uint32_t f = 0; f < from->view.triangle_count; ++f) from->marked[f] |= from->chosen[f];
    if (!first) {
        edit_append(from->at, list, json_pack("{sO}", "depth", depth));
        first = json_array_get(list, json_array_size(list) - 1);
    }
    put_faces(from, first);
}

/* Gives the chosen faces this depth; NULL: none. They are taken out of what has another. */
static void paint(painter *from, const json_t *depth)
{
    edit *at = from->at;
    if (depth) edit_child(at, edit_child(at, at->body, "depth", json_object), "constraints", json_array);
    json_t *list = constraints_of(at);
    for (size_t i = 0; i < json_array_size(list);) {
        json_t *constraint = json_array_get(list, i);
        const bool other = is_painted(constraint) && !(depth && depth_of(constraint) == json_number_value(depth));
        if (!other || take_out(from, constraint)) ++i;
        else json_array_remove(list, i);
    }
    if (depth) join(from, list, depth);
    else if (list && json_array_size(list) == 0) edit_drop_list(at->body, "depth", "constraints");
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
    from.marked = pith_alloc(from.view.triangle_count, sizeof *from.marked);
    pith_status status = from.chosen && from.marked ? check_painted(&from)
                                                    : PITH_OUT_OF_MEMORY(at->in.err, "painted faces");
    if (status == PITH_OK) status = select(&from);
    if (status == PITH_OK) paint(&from, json_object_get(at->asked, "depth"));
    pith_free(from.chosen);
    pith_free(from.marked);
    return status;
}

pith_status apply_depth_fill(edit *at) { return with_faces(at, flood); }
pith_status apply_depth_faces(edit *at) { return with_faces(at, choose); }
pith_status apply_depth_erase(edit *at) { return with_faces(at, choose); }
