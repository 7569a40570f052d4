/* Messages of the editor's protocol as they go over a socket: texts, and binary packets of a JSON text with typed
   arrays behind it (docs/protocol.md, "Transport").
   A packet is made once, is never changed, and is counted: one goes to many sockets, and threads hand it on. */
#ifndef PITH_SERVER_PACKET_H
#define PITH_SERVER_PACKET_H

#include <jansson.h>

#include "pith/base.h"

typedef enum packet_type {
    PACKET_F32, PACKET_U32, PACKET_I16, PACKET_U16, PACKET_I8, PACKET_U8, PACKET_TYPE_COUNT
} packet_type;

/* A finished message. */
typedef struct packet packet;
packet *packet_hold(packet *shared);    /* NULL is allowed, in both; from any thread */
void packet_release(packet *shared);
const unsigned char *packet_bytes(const packet *made, size_t *size);
bool packet_is_binary(const packet *made);
/* What a packet tells that a newer one tells better: "view", "job/7". A newer packet takes the place of those of the
   same slot that wait at a socket whose page is slow, and of those of slots below it: "mesh/0" of "mesh/0/paint",
   too. "", as made: of none. Set before the packet is shared. */
const char *packet_slot(const packet *made);
void packet_set_slot(packet *made, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* A sentence as JSON: bytes that are no UTF-8, such as half a character at the end of a sentence that was cut off, become
   '?'. NULL: no memory. */
json_t *sentence_json(const char *sentence);

/* A text message of this JSON, whose reference is taken also after a failure. */
pith_status packet_of_json(json_t *message, packet **made, pith_error *err);

/* ---- making binary packets --------------------------------------------------------------------------------------- */

/* A packet under way. Failures (no memory, too large) stick and are told by packet_finish, so that callers need not ask
   after every step; they only must not write into an array that is NULL. Not for several threads at a time. */
typedef struct packet_maker packet_maker;
packet_maker *packet_begin(const char *kind); /* NULL: no memory; the calls below allow it, packet_finish then fails */
/* The JSON object in front, for the caller to add keys to; borrowed. A harmless empty object after a failure; never
   NULL unless packet_begin was, so pass it to json_object_set_new as it is (which then fails and frees). */
json_t *packet_text(packet_maker *maker);
/* An array of `count` zeroed values to be filled before packet_finish; 64-byte aligned. NULL after a failure. Names are
   copied and must differ. */
void *packet_room(packet_maker *maker, const char *name, packet_type type, size_t count);
/* An array that exists already: given away (from pith_alloc or pith_grow, freed also after a failure), or borrowed
   until packet_finish. values may be NULL only when count is 0. */
void packet_give(packet_maker *maker, const char *name, packet_type type, void *values, size_t count);
void packet_borrow(packet_maker *maker, const char *name, packet_type type, const void *values, size_t count);
/* Lays text and arrays out behind one another, each array at a multiple of 4 bytes, and ends the maker, also after a
   failure. PITH_NO_MEMORY, or PITH_BAD_ARGUMENT for what is beyond 4 GiB. */
pith_status packet_finish(packet_maker *maker, packet **made, pith_error *err);
/* Ends a maker without a packet; NULL is allowed. */
void packet_abandon(packet_maker *maker);

/* ---- reading binary packets -------------------------------------------------------------------------------------- */

/* A packet of somebody else (an upload): its text, checked to be an object with arrays that lie inside it. */
typedef struct packet_view {
    json_t *text;               /* owned; packet_view_end releases it */
    const unsigned char *arrays;/* borrowed: what follows the text */
    size_t arrays_size;
} packet_view;
/* PITH_BAD_ARGUMENT with a sentence for everything that is not laid out as a packet; all arrays are checked. */
pith_status packet_read(const unsigned char *bytes, size_t size, packet_view *view, pith_error *err);
void packet_view_end(packet_view *view);
/* The values of an array of this type, borrowed from the bytes; PITH_BAD_ARGUMENT when there is none. */
pith_status packet_view_array(const packet_view *view, const char *name, packet_type type, const void **values,
                              size_t *count, pith_error *err);

#endif
