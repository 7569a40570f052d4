/* Running pith edit from a test, and talking to it. */
#ifndef PITH_EDIT_RUN_H
#define PITH_EDIT_RUN_H

#include <jansson.h>
#include <signal.h>

#include "cli_run.h"
#include "server/ws_client.h"

typedef struct edit_run {
    pid_t child;
    int out;                    /* what it prints */
    unsigned port;
    char token[40];
    int fd;                     /* the WebSocket; -1: none */
    json_int_t id;
} edit_run;

/* Starts the program in the folder of the run, with these further words (may be NULL), and reads the address. */
static inline void edit_start(edit_run *to, const char *document, const char *word)
{
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    to->child = fork();
    assert_true(to->child >= 0);
    if (to->child == 0) {
        dup2(ends[1], 1);
        close(ends[0]);
        close(ends[1]);
        if (chdir(run_folder) != 0) _exit(99);
        execl(PITH_BINARY_DIR "/pith", "pith", "edit", document, "--no-open", "--page", "page", word, (char *)NULL);
        _exit(99);
    }
    close(ends[1]);
    to->out = ends[0];
    to->fd = -1;
    to->id = 0;
    char line[300] = "";
    for (size_t i = 0; i + 1 < sizeof line && !strchr(line, '\n'); ++i)
        if (read(to->out, line + i, 1) != 1) break;
    const char *address = strstr(line, "http://");
    if (!address || sscanf(address, "http://127.0.0.1:%u/#%32s", &to->port, to->token) != 2) {
        print_error("pith edit printed \"%s\"\n", line);
        fail();
    }
}

static inline bool edit_connect(edit_run *to)
{
    char target[100], host[40];
    int status;
    snprintf(target, sizeof target, "/socket?token=%s", to->token);
    snprintf(host, sizeof host, "127.0.0.1:%u", to->port);
    to->fd = client_upgrade(to->port, target, host, "Sec-WebSocket-Protocol: pith\r\n", &status);
    return to->fd >= 0;
}

/* Ends it by a signal; gives its exit code, or minus the signal that ended it. */
static inline int edit_end(edit_run *to, int number)
{
    int status = 0;
    kill(to->child, number);
    assert_int_equal(waitpid(to->child, &status, 0), to->child);
    if (to->fd >= 0) close(to->fd);
    close(to->out);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

/* Sends a request; keys without "id". */
static inline bool edit_say(edit_run *to, const char *format, ...)
{
    char keys[2000], text[2200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(keys, sizeof keys, format, arguments);
    va_end(arguments);
    snprintf(text, sizeof text, "{\"id\": %lld, %s}", (long long)++to->id, keys);
    return client_text(to->fd, text);
}

/* The answer to the last request, or NULL when the socket has ended. Release it. */
static inline json_t *edit_hear(edit_run *to)
{
    for (;;) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        const int kind = client_message(to->fd, &bytes, &size);
        if (kind != WS_TEXT && kind != WS_BINARY) {
            if (kind > 0) free(bytes);
            return NULL;
        }
        json_t *heard = kind == WS_TEXT ? json_loadb((const char *)bytes, size, 0, NULL) : NULL;
        free(bytes);
        const json_t *id = json_object_get(heard, "id");
        if (id && json_integer_value(id) == to->id) return heard;
        json_decref(heard);
    }
}

#endif
