/* Exemplars and nodes for looking at. */
#include "errands.h"

#include <stdlib.h>
#include <string.h>

#include "node_picture.h"
#include "pack_internal.h"
#include "request.h"
#include "session.h"
#include "worker.h"

typedef struct errand {
    uint32_t socket;
    json_int_t id;
    json_t *thing;              /* an exemplar or, with `asked`, a solid that has the node */
    json_t *asked;              /* the keys of a request for a node; NULL: an exemplar is wanted */
    struct errand *next;
} errand;

struct errands {
    const char *path;
    outbox *out;
    worker work;
    errand *first, **end;       /* under the worker's lock */
};

/* ---- one exemplar ------------------------------------------------------------------------------------------------ */

/* Recipes repeat along r and t, and along s when they are made so; of other exemplars nobody says. */
static json_t *wraps(const errands *own, const json_t *exemplar)
{
    const json_t *layered = json_object_get(exemplar, "layered");
    const char *file = json_string_value(json_object_get(exemplar, "recipe"));
    bool homogeneous = json_is_true(json_object_get(layered, "homogeneous"));
    char *path = file ? pith_path_join(own->path, file) : NULL;
    pith_recipe *recipe = NULL;
    if (path && pith_recipe_load(path, &recipe, NULL) == PITH_OK) homogeneous = pith_recipe_look(recipe)->homogeneous;
    pith_recipe_destroy(recipe);
    pith_free(path);
    const bool made = layered || file;
    return json_pack("[bbb]", made, made && homogeneous, made);
}

static pith_status pack(const errands *own, const pith_grid *grid, const json_t *exemplar, json_int_t id,
                        packet **made, pith_error *err)
{
    const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    packet_maker *maker = packet_begin("exemplar");
    json_t *text = packet_text(maker);
    json_object_set_new(text, "id", json_integer(id));
    json_object_set_new(text, "size", json_pack("[iii]", (int)grid->size[0], (int)grid->size[1], (int)grid->size[2]));
    json_object_set_new(text, "channels", json_integer(grid->channels));
    json_object_set_new(text, "wraps", wraps(own, exemplar));
    uint8_t (*voxels)[4] = packet_room(maker, "voxels", PACKET_U8, 4 * count);
    if (voxels) pack_colours(grid->values, count, grid->channels, voxels);
    return packet_finish(maker, made, err);
}

/* A document that has nothing but this exemplar: its check and its stages are those of every other. */
static char *document_around(const json_t *exemplar)
{
    json_t *root = json_pack("{si s{s{}} s{s[{s[iii] si}]} s[{ss ss ss sO}]}", "pith", 1, "shape", "fruit", "scale",
                             "points", "point", 0, 0, 0, "size", 1, "solids", "name", "exemplar", "kind", "lapped",
                             "type", "0-A", "exemplar", (json_t *)exemplar);
    char *text = root ? json_dumps(root, JSON_COMPACT) : NULL;
    json_decref(root);
    return text;
}

static pith_status make_exemplar(const errands *own, const errand *at, packet **made, pith_error *err)
{
    char *text = document_around(at->thing);
    if (!text) return PITH_OUT_OF_MEMORY(err, "an exemplar");
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_grid *grid = NULL;
    const pith_model_options options = { .cache = false };
    pith_status status = pith_document_parse(own->path, text, strlen(text), &document, err);
    free(text);
    if (status == PITH_OK) status = pith_model_create(document, &options, NULL, &model, err);
    if (status == PITH_OK) status = pith_model_exemplar(model, &grid, err);
    if (status == PITH_OK) status = pack(own, grid, at->thing, at->id, made, err);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

static void run(errands *own, errand *at)
{
    /* The place is that in the document made for it; pages know the exemplar alone. */
    static const char prefix[] = "solids[0].";
    pith_error err = { PITH_OK, "" };
    packet *made = NULL;
    const pith_status status = at->asked ? node_picture(own->path, at->thing, at->asked, at->id, &made, &err)
                                         : make_exemplar(own, at, &made, &err);
    if (status != PITH_OK) {
        document_plain(own->path, err.message);
        const char *place = strstr(err.message, prefix);
        made = request_failure(at->id, pith_status_text(err.status), place ? place + strlen(prefix) : err.message);
    }
    outbox_put(own->out, at->socket, made);
}

/* ---- the thread -------------------------------------------------------------------------------------------------- */

static void errand_destroy(errand *gone)
{
    json_decref(gone->thing);
    json_decref(gone->asked);
    pith_free(gone);
}

static bool take_turn(void *user)
{
    errands *own = user;
    errand *at = own->first;
    if (!at) return false;
    own->first = at->next;
    if (!own->first) own->end = &own->first;
    worker_unlock(&own->work);
    run(own, at);
    errand_destroy(at);
    worker_lock(&own->work);
    return true;
}

static void send_out(errands *own, uint32_t socket, json_int_t id, json_t *thing, json_t *asked)
{
    errand *made = pith_alloc(1, sizeof *made);
    if (!made) {
        json_decref(thing);
        json_decref(asked);
        outbox_put(own->out, socket, request_failure(id, pith_status_text(PITH_NO_MEMORY), "out of memory"));
        return;
    }
    *made = (errand){ socket, id, thing, asked, NULL };
    worker_lock(&own->work);
    *own->end = made;
    own->end = &made->next;
    worker_call(&own->work);
    worker_unlock(&own->work);
}

void errands_exemplar(errands *own, uint32_t socket, json_int_t id, json_t *exemplar)
{
    send_out(own, socket, id, exemplar, NULL);
}

void errands_node(errands *own, uint32_t socket, json_int_t id, json_t *solid, json_t *asked)
{
    send_out(own, socket, id, solid, asked);
}

pith_status errands_create(const char *path, outbox *out, errands **made, pith_error *err)
{
    errands *own = pith_alloc(1, sizeof *own);
    if (!own) return PITH_OUT_OF_MEMORY(err, "a thread");
    own->path = path;
    own->out = out;
    own->end = &own->first;
    const pith_status status = worker_start(&own->work, take_turn, own, "exemplars", err);
    if (status == PITH_OK) *made = own;
    else pith_free(own);
    return status;
}

void errands_destroy(errands *gone)
{
    if (!gone) return;
    worker_stop(&gone->work);
    for (errand *at = gone->first, *next; at; at = next) {
        next = at->next;
        errand_destroy(at);
    }
    pith_free(gone);
}
