/* An editor without sockets: messages go in by hand, and what it says is taken out of its outbox. */
#ifndef PITH_TEST_DESK_H
#define PITH_TEST_DESK_H

#include <time.h>

#include "editor.h"
#include "server_samples.h"

enum { MOST_HEARD = 4000 };
static const double desk_patience = 60.0; /* seconds: a build under a sanitizer on a busy machine */

typedef struct desk {
    editor *own;
    outbox *out;
    struct heard { uint32_t socket; packet *content; json_t *text; } heard[MOST_HEARD];
    size_t count;
    json_int_t id;
    uint32_t admitted;
} desk;

static inline void desk_nap(void)
{
    const struct timespec millisecond = { 0, 1000000 };
    nanosleep(&millisecond, NULL);
}

/* The JSON of a message, be it text or in front of a packet. */
static inline json_t *desk_text(const packet *content)
{
    size_t size;
    uint32_t length;
    const unsigned char *bytes = packet_bytes(content, &size);
    if (!packet_is_binary(content)) return json_loadb((const char *)bytes, size, 0, NULL);
    memcpy(&length, bytes, 4);
    return json_loadb((const char *)bytes + 4, length, 0, NULL);
}

/* Takes all that is there. */
static inline void desk_listen(desk *at)
{
    uint32_t socket;
    packet *content;
    editor_woken(at->own);
    while (outbox_take(at->out, &socket, &content)) {
        assert_true(at->count < MOST_HEARD);
        at->heard[at->count] = (struct heard){ socket, content, desk_text(content) };
        assert_non_null(at->heard[at->count].text);
        ++at->count;
    }
}

static inline void desk_forget(desk *at)
{
    for (size_t i = 0; i < at->count; ++i) {
        packet_release(at->heard[i].content);
        json_decref(at->heard[i].text);
    }
    at->count = 0;
}

static inline desk *desk_open(bool automatic, bool cache)
{
    pith_error err;
    desk *made = calloc(1, sizeof *made);
    const editor_options options = { PITH_SOURCE_DIR "/examples", cache, automatic };
    CHECK_OK(outbox_create(NULL, NULL, &made->out, &err));
    CHECK_OK(editor_open(in_folder("kiwi.pith"), &options, made->out, NULL, NULL, &made->own, &err));
    return made;
}

static inline void desk_close(desk *gone)
{
    editor_close(gone->own);
    desk_forget(gone);
    outbox_destroy(gone->out);
    free(gone);
}

static inline void desk_admit(void *user, uint32_t socket) { ((desk *)user)->admitted = socket; }

static inline void desk_say(desk *at, const char *text)
{
    editor_message(at->own, 1, false, (const unsigned char *)text, strlen(text), desk_admit, at);
}

/* The first thing heard from `from` on that has these values: "event" and its word, or "kind"; waits for it. state
   may be NULL. Returns its index. */
static inline size_t desk_wait(desk *at, size_t from, const char *key, const char *word, const char *state)
{
    const double start = pith_seconds();
    for (size_t i = from;;) {
        desk_listen(at);
        for (; i < at->count; ++i) {
            const char *found = json_string_value(json_object_get(at->heard[i].text, key));
            const char *stands = json_string_value(json_object_get(at->heard[i].text, "state"));
            if (found && strcmp(found, word) == 0 && (!state || (stands && strcmp(stands, state) == 0))) return i;
        }
        if (!(pith_seconds() - start < desk_patience)) {
            print_error("nothing was heard with %s %s %s\n", key, word, state ? state : "");
            for (size_t k = from; k < at->count; ++k) {
                char *text = json_dumps(at->heard[k].text, JSON_COMPACT);
                print_error("  %.300s\n", text);
                free(text);
            }
            fail();
        }
        desk_nap();
    }
}

/* Sends a request of these keys ("\"do\": …"), and waits for its answer; borrowed until desk_forget. */
static inline const json_t *desk_ask(desk *at, const char *format, ...)
{
    char keys[4000], text[4200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(keys, sizeof keys, format, arguments);
    va_end(arguments);
    snprintf(text, sizeof text, "{\"id\": %lld, %s}", (long long)++at->id, keys);
    size_t i = at->count;
    desk_say(at, text);
    for (const double start = pith_seconds(); pith_seconds() - start < desk_patience; desk_nap()) {
        desk_listen(at);
        for (; i < at->count; ++i) {
            const json_t *id = json_object_get(at->heard[i].text, "id");
            if (id && json_integer_value(id) == at->id) return at->heard[i].text;
        }
    }
    print_error("%s was not answered\n", text);
    fail();
    return NULL;
}

static inline json_int_t whole_of(const json_t *from, const char *key)
{
    return json_integer_value(json_object_get(from, key));
}
static inline const char *text_of(const json_t *from, const char *key)
{
    const char *text = json_string_value(json_object_get(from, key));
    return text ? text : "(none)";
}

/* The request succeeds; gives its answer. */
#define ASK(at, ...) check_success(desk_ask(at, __VA_ARGS__), __FILE__, __LINE__)
static inline const json_t *check_success(const json_t *answer, const char *file, int line)
{
    if (json_object_get(answer, "kind") || json_is_true(json_object_get(answer, "ok"))) return answer;
    print_error("%s:%d refused: %s: %s\n", file, line, text_of(answer, "status"), text_of(answer, "message"));
    fail();
    return answer;
}

/* The request is refused with this status, by a sentence with the words. */
#define REFUSED(at, status, words, ...)                                                                                \
    do {                                                                                                               \
        const json_t *answer_ = desk_ask(at, __VA_ARGS__);                                                             \
        if (!json_is_false(json_object_get(answer_, "ok")) || strcmp(text_of(answer_, "status"), (status)) != 0 ||     \
            !strstr(text_of(answer_, "message"), (words))) {                                                           \
            print_error("%s:%d expected \"%s\" with \"%s\", got \"%s\" with \"%s\"\n", __FILE__, __LINE__, (status),   \
                        (words), text_of(answer_, "status"), text_of(answer_, "message"));                             \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

/* The newest revision there is. */
static inline long long desk_revision(const desk *at) { return (long long)session_revision(at->own->opened); }

#endif
