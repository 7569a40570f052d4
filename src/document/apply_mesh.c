/* The mesh that faces are counted in. Reading and cleaning it takes most of the time of painting a face, so documents
   that were painted keep it: the next click finds it made. */
#include "apply_internal.h"

struct kept_mesh {
    int holders;            /* changed atomically */
    json_t *form;           /* what it was made from: a document of nothing but the shape */
    pith_document *alone;   /* the same, read: what else the body has may be in the middle of being
                               edited */
    pith_model *model;      /* has made its mesh, and makes nothing else */
};

kept_mesh *kept_mesh_hold(kept_mesh *shared)
{
    if (shared) __atomic_add_fetch(&shared->holders, 1, __ATOMIC_RELAXED);
    return shared;
}

void kept_mesh_release(kept_mesh *shared)
{
    if (!shared || __atomic_sub_fetch(&shared->holders, 1, __ATOMIC_ACQ_REL) > 0) return;
    pith_model_destroy(shared->model);
    pith_document_destroy(shared->alone);
    json_decref(shared->form);
    pith_free(shared);
}

/* What of the body decides over its faces: its shape but for the tets, which leave them as they are, and the surfaces
   that may bound it. */
static json_t *form_of(const json_t *body)
{
    json_t *shape = json_deep_copy(json_object_get(body, "shape"));
    const bool bounded = json_object_get(shape, "surfaces");
    json_object_del(shape, "tets");
    json_object_del(shape, "refine");
    return json_pack("{si so sO* sO*}", "pith", 1, "shape", shape, "sketch",
                     bounded ? json_object_get(body, "sketch") : NULL, "surfaces",
                     bounded ? json_object_get(body, "surfaces") : NULL);
}

static pith_status fill_mesh(kept_mesh *made, const edit *at)
{
    text_buffer buffer = { 0 };
    text_add_json(&buffer, made->form, 0);
    pith_status status = buffer.failed ? PITH_OUT_OF_MEMORY(at->in.err, "a shape")
                                       : pith_document_parse(at->path, buffer.text, buffer.length, &made->alone,
                                                             at->in.err);
    pith_free(buffer.text);
    PITH_TRY(status);
    const pith_model_options options = { .cache = false };
    PITH_TRY(pith_model_create(made->alone, &options, NULL, &made->model, at->in.err));
    return pith_model_mesh(made->model, NULL, NULL, at->in.err);
}

pith_status edit_mesh(edit *at, const pith_mesh **mesh)
{
    json_t *form = form_of(at->body);
    if (!form) return PITH_OUT_OF_MEMORY(at->in.err, "a shape");
    if (at->mesh && json_equal(form, at->mesh->form)) {
        json_decref(form);
        return pith_model_mesh(at->mesh->model, mesh, NULL, at->in.err);
    }
    kept_mesh *made = pith_alloc(1, sizeof *made);
    if (!made) {
        json_decref(form);
        return PITH_OUT_OF_MEMORY(at->in.err, "a mesh");
    }
    *made = (kept_mesh){ .holders = 1, .form = form };
    const pith_status status = fill_mesh(made, at);
    if (status != PITH_OK) {
        kept_mesh_release(made);
        return pith_fail_in(at->in.err, status, "%s", at->in.file);
    }
    kept_mesh_release(at->mesh);
    at->mesh = made;
    return pith_model_mesh(made->model, mesh, NULL, at->in.err);
}
