/* The document under edit.

   A killed program loses at most what it was asked in that moment: what comes out of a change is written beside the
   document, whole, before anybody is told that it was made. */
#include "session.h"

#include <dirent.h>
#include <errno.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

/* Steps whose documents stay in memory, and what texts may take: beyond, the oldest steps are forgotten. */
enum { KEPT_DOCUMENTS = 24, NAME_ROOM = 120 };
static const size_t most_text = (size_t)256 << 20;

/* ---- counted documents ------------------------------------------------------------------------------------------- */

typedef struct counted { held_document shown; atomic_int holders; } counted;

held_document *document_hold(held_document *shared)
{
    if (shared) atomic_fetch_add_explicit(&((counted *)shared)->holders, 1, memory_order_relaxed);
    return shared;
}

void document_release(held_document *shared)
{
    counted *own = (counted *)shared;
    if (!own || atomic_fetch_sub_explicit(&own->holders, 1, memory_order_acq_rel) != 1) return;
    pith_document_destroy(shared->document);
    json_decref(shared->root);
    json_decref(shared->bodies);
    pith_free(shared->text);
    pith_free(own);
}

/* The document's bodies, those that are like others in full. */
static pith_status fill_bodies(held_document *made, pith_error *err)
{
    char *text = NULL;
    if (!json_object_get(made->root, "bodies")) return PITH_OK;
    PITH_TRY(pith_document_json_full(made->document, &text, err));
    json_t *full = json_loads(text, 0, NULL);
    pith_free(text);
    if (!full) return PITH_OUT_OF_MEMORY(err, "bodies");
    made->bodies = json_incref(json_object_get(full, "bodies"));
    json_decref(full);
    return PITH_OK;
}

pith_status document_count(pith_document *document, held_document **made, pith_error *err)
{
    counted *own = pith_alloc(1, sizeof *own);
    if (!own) {
        pith_document_destroy(document);
        return PITH_OUT_OF_MEMORY(err, "a document");
    }
    atomic_init(&own->holders, 1);
    own->shown.document = document;
    pith_status status = pith_document_json(document, &own->shown.text, err);
    if (status == PITH_OK && !(own->shown.root = json_loads(own->shown.text, 0, NULL)))
        status = PITH_OUT_OF_MEMORY(err, "a document");
    if (status == PITH_OK) status = fill_bodies(&own->shown, err);
    if (status == PITH_OK) *made = &own->shown;
    else document_release(&own->shown);
    return status;
}

static void take_out(char *sentence, const char *words, size_t length)
{
    for (char *at = sentence; length > 0 && (at = strstr(at, words));) {
        const bool begins = at == sentence || strchr(" \"'(", at[-1]); /* and is not the end of a longer path */
        if (begins) memmove(at, at + length, strlen(at + length) + 1);
        else at += length;
    }
}

void document_plain(const char *path, char *sentence)
{
    char words[PATH_MAX + 3];
    const char *slash = strrchr(path, '/');
    take_out(sentence, words, (size_t)snprintf(words, sizeof words, "%s: ", path));
    if (!slash || slash == path) return; /* every path begins with the folder "/" */
    take_out(sentence, words, (size_t)snprintf(words, sizeof words, "%.*s", (int)(slash + 1 - path), path));
}

/* ---- the session ------------------------------------------------------------------------------------------------- */

typedef struct step {
    char name[NAME_ROOM];
    char *text;                 /* of the document */
    size_t size;                /* of the text */
    held_document *held;        /* NULL: only the text is kept */
} step;

struct session {
    char path[PATH_MAX], folder[PATH_MAX], unsaved[PATH_MAX + 16];
    char note[700];
    int claim;                  /* a socket whose name says that this document is under edit; -1: none */
    step *steps;
    size_t count, capacity, at;
    held_document *present;     /* that of steps[at] */
    uint64_t revision;
    char *disk_text;            /* of the document as it was last read from or written to the file */
    uint64_t disk_hash;         /* of that file's bytes */
    bool recovered;
};

const char *session_path(const session *opened) { return opened->path; }
const char *session_folder(const session *opened) { return opened->folder; }
const char *session_file(const session *opened) { return opened->path + strlen(opened->folder); }
const char *session_note(const session *opened) { return opened->note; }
held_document *session_present(const session *opened) { return opened->present; }
uint64_t session_revision(const session *opened) { return opened->revision; }
bool session_recovered(const session *opened) { return opened->recovered; }
bool session_saved(const session *opened) { return strcmp(opened->present->text, opened->disk_text) == 0; }
const char *session_step_name(const session *opened) { return opened->steps[opened->at].name; }

const char *session_undo_name(const session *opened, size_t i)
{
    return i < opened->at ? opened->steps[opened->at - i].name : NULL;
}

const char *session_redo_name(const session *opened, size_t i)
{
    return i + 1 < opened->count - opened->at ? opened->steps[opened->at + 1 + i].name : NULL;
}

static void clear_step(step *gone)
{
    pith_free(gone->text);
    document_release(gone->held);
    *gone = (step){ .text = NULL };
}

/* A name is cut at a whole character. */
static void copy_name(char to[NAME_ROOM], const char *name)
{
    size_t length = strnlen(name, NAME_ROOM);
    if (length == NAME_ROOM)
        for (--length; length > 0 && ((unsigned char)name[length] & 0xc0) == 0x80; --length) continue;
    memcpy(to, name, length);
    to[length] = 0;
}

/* ---- the file beside the document -------------------------------------------------------------------------------- */

/* Keeps this text for the next start; nothing is kept that the document's file says as well. */
static pith_status keep_unsaved(const session *own, const char *text, pith_error *err)
{
    if (strcmp(text, own->disk_text) != 0) return pith_file_write(own->unsaved, text, strlen(text), err);
    if (remove(own->unsaved) == 0 || errno == ENOENT) return PITH_OK;
    return pith_fail(err, PITH_IO, "%s: cannot be removed: %s", own->unsaved, strerror(errno));
}

/* What a killed program left half written: NAME.unsaved.PID.part and NAME.PID.part. This session has claimed the
   document, so that nobody is writing one. */
static void sweep_parts(const session *own)
{
    DIR *directory = opendir(own->folder);
    const char *file = session_file(own);
    const size_t length = strlen(file);
    for (struct dirent *entry; directory && (entry = readdir(directory));) {
        const char *name = entry->d_name, *rest = name + length;
        if (strncmp(name, file, length) != 0) continue;
        if (strncmp(rest, ".unsaved", 8) == 0) rest += 8;
        if (rest[0] != '.') continue;
        const size_t digits = strspn(rest + 1, "0123456789");
        if (digits == 0 || strcmp(rest + 1 + digits, ".part") != 0) continue;
        char path[2 * PATH_MAX];
        snprintf(path, sizeof path, "%s%s", own->folder, name);
        remove(path);
    }
    if (directory) closedir(directory);
}

/* An abstract socket of the document's name: the kernel takes it away with the program, however that ends. A mesher that
   a killed program was just starting may hold it for a moment longer, so it is asked for again a few times. */
static pith_status claim(session *own, pith_error *err)
{
    struct sockaddr_un address = { .sun_family = AF_UNIX };
    const int length = snprintf(address.sun_path + 1, sizeof address.sun_path - 1, "pith-edit-%016llx",
                                (unsigned long long)pith_hash_bytes(own->path, strlen(own->path), 0));
    own->claim = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (own->claim < 0) return pith_fail(err, PITH_IO, "no socket can be made: %s", strerror(errno));
    const socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length);
    for (int tries = 0; tries < 10; ++tries) {
        if (bind(own->claim, (struct sockaddr *)&address, size) == 0) return PITH_OK;
        nanosleep(&(struct timespec){ .tv_nsec = 50 * 1000 * 1000 }, NULL);
    }
    return pith_fail(err, PITH_IO, "%s is being edited by another pith edit already; use its page, or end it first",
                     own->path);
}

/* ---- history ----------------------------------------------------------------------------------------------------- */

/* Old documents go, their texts stay; when even texts are too many, the oldest steps go. */
static void forget_old(session *own)
{
    size_t text = 0;
    for (size_t i = 0; i < own->count; ++i) {
        text += own->steps[i].size;
        const size_t distance = i < own->at ? own->at - i : i - own->at;
        if (distance <= KEPT_DOCUMENTS) continue;
        document_release(own->steps[i].held);
        own->steps[i].held = NULL;
    }
    while (text > most_text && own->at > 0) {
        text -= own->steps[0].size;
        clear_step(&own->steps[0]);
        memmove(own->steps, own->steps + 1, --own->count * sizeof *own->steps);
        own->steps[own->count] = (step){ .text = NULL };
        --own->at;
    }
}

/* Takes the document over: it is that of the step. */
static void set_present(session *own, size_t index, held_document *held)
{
    ++own->revision;
    own->at = index;
    document_release(own->present);
    own->present = held;
    forget_old(own);
}

/* Takes the document over, also after a failure: it becomes the step behind the present one. */
static pith_status add_step(session *own, const char *name, held_document *held, pith_error *err)
{
    const size_t length = strlen(held->text);
    char *text = pith_alloc(length + 1, 1);
    pith_status status = text ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a step");
    if (status == PITH_OK && !pith_grow((void **)&own->steps, &own->capacity, own->at + 2, sizeof *own->steps))
        status = PITH_OUT_OF_MEMORY(err, "the history");
    if (status == PITH_OK) status = keep_unsaved(own, held->text, err);
    if (status != PITH_OK) {
        pith_free(text);
        document_release(held);
        return status;
    }
    const size_t index = own->present ? own->at + 1 : 0;
    while (own->count > index) clear_step(&own->steps[--own->count]);
    memcpy(text, held->text, length + 1);
    step *to = &own->steps[index];
    copy_name(to->name, name);
    to->text = text;
    to->size = length;
    to->held = document_hold(held);
    own->count = index + 1;
    set_present(own, index, held);
    return PITH_OK;
}

/* Takes the document over, also after a failure. One that says the same is no step; but it takes the place of the one
   there is, because the recipes it names may say something else by now. */
static pith_status take_change(session *own, const char *name, held_document *held, pith_error *err)
{
    if (strcmp(held->text, own->present->text) != 0) return add_step(own, name, held, err);
    const pith_status status = keep_unsaved(own, held->text, err);
    if (status != PITH_OK) {
        document_release(held);
        return status;
    }
    document_release(own->steps[own->at].held);
    own->steps[own->at].held = document_hold(held);
    document_release(own->present);
    own->present = held;
    return PITH_OK;
}

pith_status session_apply(session *opened, const char *name, const char *operations, size_t size, session_check *check,
                          void *user, pith_error *err)
{
    pith_document *edited = NULL;
    held_document *held = NULL;
    const pith_document *before = opened->present->document;
    PITH_TRY(pith_document_apply(before, operations, size, &edited, err));
    const pith_status status = check ? check(user, before, edited, err) : PITH_OK;
    if (status != PITH_OK) {
        pith_document_destroy(edited);
        return status;
    }
    PITH_TRY(document_count(edited, &held, err));
    return take_change(opened, name, held, err);
}

/* Makes another step the present one. */
static pith_status go_to(session *own, size_t index, pith_error *err)
{
    step *to = &own->steps[index];
    if (!to->held) {
        pith_document *again = NULL;
        PITH_TRY(pith_document_parse(own->path, to->text, strlen(to->text), &again, err));
        PITH_TRY(document_count(again, &to->held, err));
    }
    PITH_TRY(keep_unsaved(own, to->held->text, err));
    set_present(own, index, document_hold(to->held));
    return PITH_OK;
}

pith_status session_undo(session *opened, pith_error *err)
{
    if (opened->at == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "There is nothing to undo: this is the first step there is");
    return go_to(opened, opened->at - 1, err);
}

pith_status session_redo(session *opened, pith_error *err)
{
    if (opened->at + 1 >= opened->count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "There is nothing to do again: this is the last step there is");
    return go_to(opened, opened->at + 1, err);
}

/* ---- the file ---------------------------------------------------------------------------------------------------- */

/* Reads the document's file; on success the session knows it. */
static pith_status read_disk(session *own, held_document **held, pith_error *err)
{
    unsigned char *bytes = NULL;
    size_t size;
    PITH_TRY(pith_file_read(own->path, &bytes, &size, err));
    pith_document *document = NULL;
    pith_status status = pith_document_parse(own->path, (const char *)bytes, size, &document, err);
    const uint64_t hash = pith_hash_bytes(bytes, size, 0);
    pith_free(bytes);
    held_document *made = NULL;
    if (status == PITH_OK) status = document_count(document, &made, err);
    char *text = NULL;
    if (status == PITH_OK) status = pith_document_json(made->document, &text, err);
    if (status != PITH_OK) {
        document_release(made);
        return status;
    }
    pith_free(own->disk_text);
    own->disk_text = text;
    own->disk_hash = hash;
    *held = made;
    return PITH_OK;
}

pith_status session_revert(session *opened, pith_error *err)
{
    held_document *held = NULL;
    PITH_TRY(read_disk(opened, &held, err));
    return take_change(opened, "Revert to the file", held, err);
}

bool session_disk_is_known(const session *opened)
{
    unsigned char *bytes = NULL;
    size_t size;
    if (pith_file_read(opened->path, &bytes, &size, NULL) != PITH_OK) return false;
    const bool known = pith_hash_bytes(bytes, size, 0) == opened->disk_hash;
    pith_free(bytes);
    return known;
}

pith_status session_save(session *opened, pith_error *err)
{
    const char *text = opened->present->text;
    const size_t length = strlen(text);
    char *copy = pith_alloc(length + 1, 1);
    if (!copy) return PITH_OUT_OF_MEMORY(err, "the document");
    memcpy(copy, text, length);
    const pith_status status = pith_file_write(opened->path, text, length, err);
    if (status != PITH_OK) {
        pith_free(copy);
        return status;
    }
    pith_free(opened->disk_text);
    opened->disk_text = copy;
    opened->disk_hash = pith_hash_bytes(text, length, 0);
    return keep_unsaved(opened, text, err);
}

pith_status session_save_copy(session *opened, const char *path, pith_error *err)
{
    const char *text = opened->present->text;
    pith_document *there = NULL;
    PITH_TRY(pith_document_parse(path, text, strlen(text), &there, err));
    pith_document_destroy(there);
    return pith_file_write(path, text, strlen(text), err);
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* The document that a former session left unsaved becomes the second step. One that cannot be opened is put aside under
   another name, so that it is not written over. */
static pith_status recover(session *own, pith_error *err)
{
    if (!pith_file_exists(own->unsaved)) return PITH_OK;
    unsigned char *bytes = NULL;
    size_t size;
    pith_document *document = NULL;
    held_document *held = NULL;
    pith_error why;
    pith_status status = pith_file_read(own->unsaved, &bytes, &size, &why);
    if (status == PITH_OK) status = pith_document_parse(own->path, (const char *)bytes, size, &document, &why);
    pith_free(bytes);
    if (status == PITH_OK) status = document_count(document, &held, &why);
    if (status == PITH_OK && strcmp(held->text, own->disk_text) == 0) {
        document_release(held);
        return keep_unsaved(own, own->disk_text, err);
    }
    if (status == PITH_OK) {
        own->recovered = true;
        return add_step(own, "Recovered changes", held, err);
    }
    char aside[PATH_MAX + 40];
    snprintf(aside, sizeof aside, "%s-refused", own->unsaved);
    if (rename(own->unsaved, aside) != 0)
        return pith_fail(err, PITH_IO, "%s: unsaved changes cannot be opened (%.200s) nor put aside: %s", own->unsaved,
                         why.message, strerror(errno));
    snprintf(own->note, sizeof own->note, "unsaved changes were found but cannot be opened; they are kept in %.200s: "
             "%.300s", aside, why.message);
    return PITH_OK;
}

static pith_status fill_session(session *own, const char *path, pith_error *err)
{
    char found[PATH_MAX];
    if (!realpath(path, found)) return pith_fail(err, PITH_IO, "%s: cannot be opened: %s", path, strerror(errno));
    snprintf(own->path, sizeof own->path, "%s", found);
    snprintf(own->folder, sizeof own->folder, "%.*s", (int)(strrchr(found, '/') - found) + 1, found);
    snprintf(own->unsaved, sizeof own->unsaved, "%s.unsaved", found);
    PITH_TRY(claim(own, err));
    sweep_parts(own);
    held_document *held = NULL;
    PITH_TRY(read_disk(own, &held, err));
    /* The first step is what the file says; add_step would remove what a former session left unsaved. */
    if (!pith_grow((void **)&own->steps, &own->capacity, 1, sizeof *own->steps) ||
        !(own->steps[0].text = pith_alloc(strlen(held->text) + 1, 1))) {
        document_release(held);
        return PITH_OUT_OF_MEMORY(err, "the history");
    }
    own->steps[0].size = strlen(held->text);
    memcpy(own->steps[0].text, held->text, own->steps[0].size);
    own->steps[0].held = document_hold(held);
    own->count = 1;
    set_present(own, 0, held);
    return recover(own, err);
}

pith_status session_open(const char *path, session **opened, pith_error *err)
{
    session *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, path);
    made->claim = -1;
    const pith_status status = fill_session(made, path, err);
    if (status == PITH_OK) *opened = made;
    else session_close(made);
    return status;
}

void session_close(session *opened)
{
    if (!opened) return;
    for (size_t i = 0; i < opened->count; ++i) clear_step(&opened->steps[i]);
    pith_free(opened->steps);
    document_release(opened->present);
    pith_free(opened->disk_text);
    if (opened->claim >= 0) close(opened->claim);
    pith_free(opened);
}
