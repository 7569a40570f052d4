/* Can a model be cut along the strokes of a document? Most strokes are good whatever the model's outline is, and need
   nothing but themselves to be told so. One that crosses itself may still do, when it does so outside of the outline:
   for such a one the meshes of the bodies are made. */
#include <pthread.h>

#include "document_internal.h"

/* What was found good with a mesh is not asked of the mesh again: documents are checked after every edit. */
enum { REMEMBERED = 256 };
static struct good_memory {
    pthread_mutex_t lock;
    uint64_t keys[REMEMBERED]; /* 0: none */
    size_t next;               /* the one that is forgotten next */
} good = { .lock = PTHREAD_MUTEX_INITIALIZER };

static bool is_known(uint64_t key)
{
    bool found = false;
    pthread_mutex_lock(&good.lock);
    for (size_t i = 0; !found && i < REMEMBERED; ++i) found = good.keys[i] == key;
    pthread_mutex_unlock(&good.lock);
    return found;
}

static void remember(uint64_t key)
{
    pthread_mutex_lock(&good.lock);
    good.keys[good.next] = key;
    good.next = (good.next + 1) % REMEMBERED;
    pthread_mutex_unlock(&good.lock);
}

/* Of everything that the answer depends on; 0 when a file cannot be read. */
static uint64_t key_of(const pith_document *made, const pith_cut_step *cut)
{
    const pith_cut_stroke *stroke = &cut->stroke;
    uint64_t hash = pith_hash_bytes(&stroke->eye, sizeof stroke->eye, 0);
    hash = pith_hash_bytes(stroke->points, stroke->count * sizeof *stroke->points, hash);
    hash = hash_options(&pith_cut_stroke_params, &cut->follow, hash);
    for (size_t i = 0; i < made->body_count; ++i) {
        stage_keys keys;
        if (stage_keys_of(&made->bodies[i], &keys, NULL) != PITH_OK) return 0;
        hash = pith_mix64(hash ^ keys.mesh);
    }
    return hash;
}

/* Against the outline of every body; refused: one of them cannot be cut so. Other failures are those of a mesh. */
static pith_status check_outlines(const pith_document *made, const pith_cut_step *cut, bool *refused, pith_error *err)
{
    const pith_model_options options = { .cache = false };
    pith_model *model = NULL;
    pith_status status = pith_model_create(made, &options, NULL, &model, err);
    for (size_t i = 0; status == PITH_OK && i < made->body_count; ++i) {
        pith_model *body;
        const pith_mesh *mesh;
        if (cut->one_body && cut->body != i) continue;
        PITH_TRY_OR(done, pith_model_body(model, i, &body, err));
        PITH_TRY_OR(done, pith_model_mesh(body, &mesh, NULL, err));
        const pith_mesh_view seen = pith_mesh_look(mesh);
        status = pith_cut_stroke_check(&cut->stroke, &cut->follow, seen.positions, seen.vertex_count, err);
        *refused = status == PITH_BAD_ARGUMENT;
    }
done:
    pith_model_destroy(model);
    return status;
}

/* PITH_BAD_DOCUMENT, with the stroke's fault in err, when a body cannot be cut along it. A body that has no mesh refuses
   nothing: what is wrong with it is told by those who build it. */
static pith_status check_stroke(const pith_document *made, const pith_cut_step *cut, pith_error *err)
{
    pith_status status = pith_cut_stroke_check(&cut->stroke, &cut->follow, NULL, 0, err);
    if (status != PITH_BAD_ARGUMENT) return status;
    const uint64_t key = key_of(made, cut);
    bool refused = false;
    if (key && is_known(key)) return PITH_OK;
    status = check_outlines(made, cut, &refused, err);
    if (status == PITH_OK && key) remember(key);
    if (refused) return PITH_BAD_DOCUMENT;
    return status == PITH_NO_MEMORY ? status : PITH_OK;
}

pith_status strokes_check(const pith_document *made, reader *in)
{
    for (size_t i = 0; i < made->cut_count; ++i) {
        const pith_cut_step *cut = &made->cuts[i];
        pith_error why;
        if (cut->stroke.count == 0) continue;
        const pith_status status = check_stroke(made, cut, &why);
        if (status == PITH_OK) continue;
        if (status != PITH_BAD_DOCUMENT) return pith_fail(in->err, status, "%s", why.message);
        reader_enter(in, "cuts");
        reader_enter_at(in, i);
        reader_enter(in, "stroke");
        return reader_fail(in, "%s", why.message);
    }
    return PITH_OK;
}
