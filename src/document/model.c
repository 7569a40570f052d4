/* Models: their life, their bodies, and what they keep. A body is built stage by stage: shape, tets, fields, exemplar,
   solid. Each stage first looks into the saved model, and what it had to build it puts there.

   A model from the cache is the fresh model bit for bit: positions and fields are kept in full, and the exemplar is
   rounded to what the cache holds before anything is filled with it. */
#include "model_internal.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- notes, messages, times -------------------------------------------------------------------------------------------- */

void model_note(pith_model *model, const char *format, ...)
{
    char *notes = model->owner->notes;
    const size_t length = strlen(notes);
    if (length + 2 >= sizeof model->notes) return;
    char sentence[700];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    const size_t own = strlen(sentence);
    for (const char *at = notes; (at = strstr(at, sentence)) != NULL; ++at)
        if ((at == notes || at[-1] == '\n') && (at[own] == '\n' || at[own] == '\0')) return;
    snprintf(notes + length, sizeof model->notes - length, "%s%s", length ? "\n" : "", sentence);
}

pith_status model_one_body(const pith_model *model, pith_error *err)
{
    if (model->body) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: the model has %zu bodies, and this asks for what one body has; "
                     "choose one of them, e.g. \"%s\"", model->document->path, model->body_count,
                     model->document->bodies[0].name);
}

pith_status model_fail_at(const pith_model *model, pith_status status, const char *key, const char *word,
                          const char *list, pith_error *err)
{
    if (status == PITH_CANCELLED || !err) return status;
    const char *path = model->document->path, *place = model->body->place;
    const size_t length = word ? strlen(word) : 0;
    if (word && strncmp(err->message, word, length) == 0 && err->message[length] == ' ' &&
        isdigit((unsigned char)err->message[length + 1]))
        return pith_fail_in(err, status, "%s: %s%s[%lu]", path, place, list, strtoul(err->message + length, NULL, 10));
    return pith_fail_in(err, status, "%s: %s%s", path, place, key);
}

/* Stages that are built in several steps add up; a whole is the sum of its bodies. */
void model_took(pith_model *model, size_t member, double start)
{
    const double took = pith_seconds() - start;
    double *own = (double *)(void *)((char *)&model->times + member);
    *own = fmax(*own, 0.0) + took;
    if (model->owner == model) return;
    double *all = (double *)(void *)((char *)&model->owner->times + member);
    *all = fmax(*all, 0.0) + took;
}

/* ---- the cache ----------------------------------------------------------------------------------------------------------- */

enum { SECTION_NAME = 16 };

/* What the cache calls a stage of a body: a single body's stages have their plain names. The exemplars and patches of
   solids under a combined one have the number of the solid behind them. */
static void section_name(const pith_model *model, const char *stage, char name[SECTION_NAME])
{
    const bool several = model->owner->body_count > 0;
    const size_t length = several ? (size_t)snprintf(name, SECTION_NAME, "%zu:%s", model->index, stage)
                                  : (size_t)snprintf(name, SECTION_NAME, "%s", stage);
    if (model->other && length < SECTION_NAME)
        snprintf(name + length, SECTION_NAME - length, ".%zu", model->body->solid);
}

static bool section_wanted(const char *name, const void *user)
{
    const pith_model *whole = user;
    const char *colon = strchr(name, ':');
    return colon ? strtoul(name, NULL, 10) < whole->body_count : whole->body_count == 0;
}

static void flush(pith_model *owner)
{
    pith_error err;
    if (cache_flush(owner->store, &err) == PITH_OK || owner->told_unsaved) return;
    model_note(owner, "the model could not be saved: %s", err.message);
    owner->told_unsaved = true;
}

/* Keeping a stage can fail (a full disk, a folder that may not be written); the model is good all the same. The file is
   written after every stage, so that little is lost when somebody stops the program; of several bodies only after the
   solid of each, since every time the whole file is written. */
void model_keep(pith_model *model, const char *stage, uint64_t key, byte_writer *bytes)
{
    pith_error err;
    char name[SECTION_NAME];
    section_name(model, stage, name);
    pith_model *owner = model->owner;
    pith_status status = bytes->failed ? PITH_OUT_OF_MEMORY(&err, stage) : PITH_OK;
    if (status == PITH_OK) status = cache_put(owner->store, name, key, bytes->bytes, bytes->size, &err);
    if (status != PITH_OK && !owner->told_unsaved) {
        model_note(model, "the model could not be saved: %s", err.message);
        owner->told_unsaved = true;
    }
    if (status == PITH_OK && (owner == model || strcmp(stage, "patches") == 0)) flush(owner);
    pith_free(bytes->bytes);
}

bool model_recall(const pith_model *model, const char *stage, uint64_t key, byte_reader *in)
{
    char name[SECTION_NAME];
    section_name(model, stage, name);
    memset(in, 0, sizeof *in);
    if (model->owner->store) in->bytes = cache_get(model->owner->store, name, key, &in->size);
    return in->bytes != NULL;
}

void model_release(byte_reader *in) { pith_free((void *)in->bytes); }

void model_note_damage(pith_model *model, const char *what, const pith_error *err)
{
    model_note(model, "the saved %s could not be used and are built again: %s", what, err->message);
}

static pith_status open_cache(pith_model *model, const char *cache_file, pith_error *err)
{
    const char *beside = model->document->path;
    char *path = pith_alloc(strlen(cache_file ? cache_file : beside) + 2, 1);
    if (!path) return PITH_OUT_OF_MEMORY(err, "a path");
    sprintf(path, "%s%s", cache_file ? cache_file : beside, cache_file ? "" : "c");
    pith_status status = cache_create(path, &model->store, err);
    pith_free(path);
    if (status != PITH_OK) return status;
    char complaint[500];
    status = cache_load(model->store, complaint, sizeof complaint, err);
    if (complaint[0]) model_note(model, "%s", complaint);
    cache_keep_only(model->store, section_wanted, model);
    return status;
}

/* ---- life ------------------------------------------------------------------------------------------------------------- */

/* Progress of one body among several: its name says what the fraction is of. */
static bool report_named(void *user, double fraction, const char *what)
{
    const pith_model *model = user;
    const pith_progress *progress = model->owner->progress;
    char text[200];
    snprintf(text, sizeof text, "%.60s: %s", model->body->name, what);
    return progress->report(progress->user, fraction, text);
}

static pith_model *new_model(const pith_document *document, const pith_progress *progress)
{
    pith_model *made = pith_alloc(1, sizeof *made);
    if (!made) return NULL;
    made->document = document;
    made->owner = made;
    made->progress = progress;
    made->times = (pith_model_times){ -1, -1, -1, -1, -1, -1 };
    return made;
}

pith_model *model_new_inner(pith_model *model, size_t solid, pith_error *err)
{
    pith_model *made = new_model(model->document, model->progress);
    if (made) made->other = pith_alloc(1, sizeof *made->other);
    if (!made || !made->other) {
        pith_free(made);
        PITH_OUT_OF_MEMORY(err, "a solid under another");
        return NULL;
    }
    *made->other = *model->body;
    made->other->solid = solid;
    made->body = made->other;
    made->owner = model->owner;
    made->index = model->index;
    return made;
}

static pith_status add_bodies(pith_model *owner, pith_error *err)
{
    const pith_document *document = owner->document;
    owner->bodies = pith_alloc(document->body_count, sizeof *owner->bodies);
    if (!owner->bodies) return PITH_OUT_OF_MEMORY(err, "bodies");
    for (size_t i = 0; i < document->body_count; ++i) {
        pith_model *body = new_model(document, NULL);
        if (!body) return PITH_OUT_OF_MEMORY(err, "a body");
        owner->bodies[owner->body_count++] = body;
        body->body = &document->bodies[i];
        body->owner = owner;
        body->index = i;
        body->named = (pith_progress){ report_named, body };
        if (owner->progress && owner->progress->report) body->progress = &body->named;
        PITH_TRY(stage_keys_of(body->body, &body->keys, err));
    }
    return PITH_OK;
}

static pith_status fill_model(pith_model *made, const pith_model_options *options, pith_error *err)
{
    const pith_document *document = made->document;
    if (document->body_count > 1) {
        PITH_TRY(add_bodies(made, err));
    } else {
        made->body = &document->bodies[0];
        PITH_TRY(stage_keys_of(made->body, &made->keys, err));
    }
    made->told_parts = pith_alloc(document->part_count, sizeof *made->told_parts);
    if (!made->told_parts) return PITH_OUT_OF_MEMORY(err, "parts");
    PITH_TRY(pith_model_set_cuts(made, document->cuts, document->cut_count, err));
    made->cuts.from_document = true;
    return options && options->cache ? open_cache(made, options->cache_file, err) : PITH_OK;
}

pith_status pith_model_create(const pith_document *document, const pith_model_options *options,
                              const pith_progress *progress, pith_model **model, pith_error *err)
{
    pith_model *made = new_model(document, progress);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a model");
    const pith_status status = fill_model(made, options, err);
    if (status == PITH_OK) *model = made;
    else pith_model_destroy(made);
    return status;
}

void pith_model_destroy(pith_model *model)
{
    if (!model) return;
    model_drop_items(model);
    if (model->store) flush(model);
    pith_free(model->told_parts);
    for (size_t i = 0; i < model->body_count; ++i) pith_model_destroy(model->bodies[i]);
    pith_free(model->bodies);
    if (model->body) model_drop_inner(model);
    pith_free(model->other);
    model_release_levels(model);
    cut_list_clear(&model->cuts);
    pith_free(model->quadrics);
    model_release_stages(model);
    cache_destroy(model->store);
    pith_free(model);
}

/* ---- what is known of a model -------------------------------------------------------------------------------------------- */

pith_model *model_body(pith_model *model, size_t index) { return model->body ? model : model->bodies[index]; }

size_t model_number(const pith_model *model, size_t body) { return model->body ? model->index : body; }

size_t pith_model_bodies(const pith_model *model) { return model->body ? 1 : model->body_count; }

pith_status pith_model_body(pith_model *model, size_t index, pith_model **body, pith_error *err)
{
    if (index >= pith_model_bodies(model))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: there is no body %zu; the model has %zu, counted from 0",
                         model->document->path, index, pith_model_bodies(model));
    *body = model_body(model, index);
    return PITH_OK;
}

const pith_lapped_report *pith_model_fill_report(const pith_model *model)
{
    return model->has_fill_report ? &model->fill_report : NULL;
}

const pith_model_times *pith_model_timing(const pith_model *model) { return &model->times; }
const char *pith_model_notes(const pith_model *model) { return model->owner->notes; }

size_t pith_model_saved_size(const pith_model *model)
{
    return model->owner->store ? cache_size(model->owner->store) : 0;
}
