/* What a page asks: read, checked against the table of verbs, answered. */
#ifndef PITH_SERVER_REQUEST_H
#define PITH_SERVER_REQUEST_H

#include "packet.h"

typedef struct editor editor;   /* editor.h */

typedef enum argument_kind {
    ARGUMENT_TEXT, ARGUMENT_NUMBER, ARGUMENT_WHOLE, ARGUMENT_SWITCH, ARGUMENT_POINT, ARGUMENT_OBJECT, ARGUMENT_LIST
} argument_kind;

/* A key of a request beside "id" and "do". */
typedef struct argument {
    const char *name;
    argument_kind kind;
    bool needed;
    double lowest, highest;     /* of numbers; of texts the longest is `highest` bytes, 0: 4000 */
    const char *const *words;   /* what a text may be, NULL-terminated; NULL: anything */
} argument;

/* A request under way. */
typedef struct request {
    uint32_t socket;
    json_int_t id;              /* 0: the page gave none that could be read */
    const json_t *body;         /* borrowed, checked */
    const packet_view *upload;  /* of a binary message; NULL for texts */
    json_t *answer;             /* an object to be filled with what the answer has beside "id" and "ok" */
    const char *refusal;        /* "stale"…: the status of a failure, where it is none of pith_status; else NULL */
    bool later;                 /* set when it was answered already, or another thread will */
} request;

typedef struct verb {
    const char *name;
    bool upload;                /* comes as a binary message */
    const argument *arguments;  /* the last has no name */
    bool open;                  /* further keys are the verb's own business */
    pith_status (*run)(editor *own, request *asked, pith_error *err);
} verb;

/* Arguments that were checked; the standard where they were left out. */
const char *request_text(const request *asked, const char *name, const char *standard);
double request_number(const request *asked, const char *name, double standard);
bool request_switch(const request *asked, const char *name, bool standard);

/* Finds the verb (the table's last has no name) and checks the keys: PITH_BAD_ARGUMENT names the first that is wrong,
   missing or unknown. */
pith_status request_check(const verb *verbs, request *asked, const verb **found, pith_error *err);

/* The answers: {"id", "ok": true, …} with the keys of `keys` (taken over; may be NULL), and {"id", "ok": false,
   "status", "message"}. NULL when memory is out. */
packet *request_success(json_int_t id, json_t *keys);
packet *request_failure(json_int_t id, const char *status, const char *message);

#endif
