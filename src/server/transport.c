/* The sockets, by libwebsockets. What it leaves to its user is done here: who may connect (Host, Origin, token), how
   large a message may be, how much may wait for a page that does not read.

   It takes frames without a mask, which a browser never sends, for what they say; they still need the token. */
#include "transport.h"

#include <errno.h>
#include <libwebsockets.h>
#include <netinet/in.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include "outbox.h"

enum { AT_ONCE = 128 * 1024, MOST_WAITING = 4096, KEPT_ROOM = 1 << 20 };
static const size_t most_received = (size_t)64 << 20, most_waiting_bytes = (size_t)1 << 30;

/* A packet that waits at a socket. */
typedef struct waiting { packet *content; struct waiting *next; } waiting;

/* A WebSocket. */
typedef struct seat {
    uint32_t number;
    struct lws *wsi;
    bool admitted, overrun;
    unsigned char *received;        /* a message of several frames so far */
    size_t received_size, received_capacity;
    waiting *first;                 /* the first is under way when sent > 0 or begun */
    size_t waiting_count, waiting_bytes, sent;
    bool begun;
} seat;

/* An HTTP request under way. */
typedef struct visit { const unsigned char *bytes; size_t size, sent; } visit;

struct transport {
    struct lws_context *context;
    const page_files *files;
    transport_calls calls;
    uint32_t port, last_number;
    char token[TOKEN_SIZE];
    char policy[600];               /* Content-Security-Policy */
    seat *seats[MOST_SOCKETS];
    atomic_int stopped;
    unsigned char scratch[LWS_PRE + AT_ONCE];
};

/* ---- who may come in --------------------------------------------------------------------------------------------- */

/* A header that is not there, or is longer than anything right could be, is "". */
static void copy_header(struct lws *wsi, enum lws_token_indexes token, char *text, int capacity)
{
    if (lws_hdr_copy(wsi, text, capacity, token) <= 0) text[0] = 0;
}

/* "127.0.0.1:PORT" or "localhost:PORT" behind the prefix, and nothing else. */
static bool is_own_address(const transport *server, const char *text, const char *prefix)
{
    char own[2][60];
    snprintf(own[0], sizeof own[0], "%s127.0.0.1:%u", prefix, server->port);
    snprintf(own[1], sizeof own[1], "%slocalhost:%u", prefix, server->port);
    return strcmp(text, own[0]) == 0 || strcmp(text, own[1]) == 0;
}

static bool host_is_own(const transport *server, struct lws *wsi)
{
    char host[60];
    copy_header(wsi, WSI_TOKEN_HOST, host, sizeof host);
    return is_own_address(server, host, "");
}

/* Browsers always say where a page that opens a socket came from; programs need not. */
static bool origin_is_own(const transport *server, struct lws *wsi)
{
    char origin[80];
    if (lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) <= 0) return true;
    copy_header(wsi, WSI_TOKEN_ORIGIN, origin, sizeof origin);
    return is_own_address(server, origin, "http://");
}

/* In a time that does not depend on how much of it is right. */
static bool token_is_right(const transport *server, struct lws *wsi)
{
    char given[80] = "";
    bool right = false;
    for (int i = 0; lws_hdr_copy_fragment(wsi, given, sizeof given, WSI_TOKEN_HTTP_URI_ARGS, i) > 0; ++i) {
        if (strncmp(given, "token=", 6) != 0 || strlen(given) != 6 + TOKEN_SIZE - 1) continue;
        unsigned char different = 0;
        for (int k = 0; k < TOKEN_SIZE - 1; ++k) different |= (unsigned char)(given[6 + k] ^ server->token[k]);
        right |= different == 0;
    }
    return right;
}

static bool speaks_pith(struct lws *wsi)
{
    char offered[200], *save = NULL;
    copy_header(wsi, WSI_TOKEN_PROTOCOL, offered, sizeof offered);
    for (char *word = strtok_r(offered, ", ", &save); word; word = strtok_r(NULL, ", ", &save))
        if (strcmp(word, "pith") == 0) return true;
    return false;
}

/* The HTTP status for somebody who wants a WebSocket; 0: welcome. */
static unsigned int judge_upgrade(const transport *server, struct lws *wsi, const char *upgrade)
{
    char path[80];
    if (!host_is_own(server, wsi)) return HTTP_STATUS_FORBIDDEN;
    copy_header(wsi, WSI_TOKEN_GET_URI, path, sizeof path);
    if (strcasecmp(upgrade, "websocket") != 0 || strcmp(path, "/socket") != 0) return HTTP_STATUS_NOT_FOUND;
    if (!origin_is_own(server, wsi) || !token_is_right(server, wsi)) return HTTP_STATUS_FORBIDDEN;
    if (!speaks_pith(wsi)) return HTTP_STATUS_BAD_REQUEST;
    for (int i = 0; i < MOST_SOCKETS; ++i)
        if (!server->seats[i]) return 0;
    return HTTP_STATUS_SERVICE_UNAVAILABLE;
}

/* ---- HTTP -------------------------------------------------------------------------------------------------------- */

/* An answer's head with the headers that every answer has. */
static int send_head(transport *server, struct lws *wsi, unsigned int status, const char *type, size_t size,
                     bool zipped)
{
    static const char *const headers[][2] = {
        { "cache-control:", "no-store" },       { "x-content-type-options:", "nosniff" },
        { "referrer-policy:", "no-referrer" },  { "x-frame-options:", "DENY" },
        { "cross-origin-opener-policy:", "same-origin" }, { "cross-origin-resource-policy:", "same-origin" },
    };
    unsigned char *start = server->scratch + LWS_PRE, *at = start, *end = start + 4000;
    const char *encoding = "gzip";
    int bad = lws_add_http_common_headers(wsi, status, type, size, &at, end);
    for (size_t i = 0; i < sizeof headers / sizeof *headers; ++i)
        bad |= lws_add_http_header_by_name(wsi, (const unsigned char *)headers[i][0],
                                           (const unsigned char *)headers[i][1], (int)strlen(headers[i][1]), &at, end);
    bad |= lws_add_http_header_by_name(wsi, (const unsigned char *)"content-security-policy:",
                                       (const unsigned char *)server->policy, (int)strlen(server->policy), &at, end);
    if (zipped)
        bad |= lws_add_http_header_by_token(wsi, WSI_TOKEN_HTTP_CONTENT_ENCODING, (const unsigned char *)encoding,
                                            (int)strlen(encoding), &at, end);
    return bad || lws_finalize_write_http_header(wsi, start, &at, end);
}

/* Begins an answer; the body follows as the socket takes it. */
static int answer(transport *server, struct lws *wsi, visit *under_way, unsigned int status, const char *type,
                  const void *bytes, size_t size, bool zipped)
{
    *under_way = (visit){ bytes, size, 0 };
    if (send_head(server, wsi, status, type, size, zipped)) return -1;
    lws_callback_on_writable(wsi);
    return 0;
}

static int refuse(transport *server, struct lws *wsi, visit *under_way, unsigned int status)
{
    static const char sentences[][60] = { "not found\n", "only GET is answered here\n",
                                          "this server answers its own page only\n" };
    const char *sentence = sentences[status == HTTP_STATUS_NOT_FOUND ? 0 : status == HTTP_STATUS_FORBIDDEN ? 2 : 1];
    return answer(server, wsi, under_way, status, "text/plain; charset=utf-8", sentence, strlen(sentence), false);
}

static int on_http(transport *server, struct lws *wsi, visit *under_way, const char *name)
{
    if (!host_is_own(server, wsi)) return refuse(server, wsi, under_way, HTTP_STATUS_FORBIDDEN);
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0)
        return refuse(server, wsi, under_way, HTTP_STATUS_METHOD_NOT_ALLOWED);
    const page_file *file = page_files_find(server->files, name);
    if (!file) return refuse(server, wsi, under_way, HTTP_STATUS_NOT_FOUND);
    char accepted[200];
    copy_header(wsi, WSI_TOKEN_HTTP_ACCEPT_ENCODING, accepted, sizeof accepted);
    if (file->zipped && strstr(accepted, "gzip"))
        return answer(server, wsi, under_way, HTTP_STATUS_OK, file->type, file->zipped, file->zipped_size, true);
    return answer(server, wsi, under_way, HTTP_STATUS_OK, file->type, file->bytes, file->size, false);
}

static int on_http_writeable(transport *server, struct lws *wsi, visit *under_way)
{
    if (!under_way->bytes) return 0;
    const size_t left = under_way->size - under_way->sent, now = left < AT_ONCE ? left : AT_ONCE;
    memcpy(server->scratch + LWS_PRE, under_way->bytes + under_way->sent, now);
    const bool last = now == left;
    if (lws_write(wsi, server->scratch + LWS_PRE, now, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < (int)now)
        return -1;
    under_way->sent += now;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    under_way->bytes = NULL;
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

static int on_http_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    transport *server = lws_context_user(lws_get_context(wsi));
    switch (reason) {
    case LWS_CALLBACK_HTTP: return on_http(server, wsi, user, in);
    case LWS_CALLBACK_HTTP_WRITEABLE: return on_http_writeable(server, wsi, user);
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE: {
        const unsigned int status = judge_upgrade(server, wsi, in);
        if (status == 0) return 0;
        return send_head(server, wsi, status, "text/plain", 0, false) ? -1 : 1;
    }
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION: return -1; /* judge_upgrade let in only those who speak pith */
    case LWS_CALLBACK_HTTP_BODY: return -1;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        server->calls.woken(server->calls.user);
        return 0;
    default: return lws_callback_http_dummy(wsi, reason, user, in, size);
    }
}

/* ---- WebSockets: what comes in ----------------------------------------------------------------------------------- */

static int on_established(transport *server, seat *own, struct lws *wsi)
{
    memset(own, 0, sizeof *own);
    own->wsi = wsi;
    for (int i = 0; i < MOST_SOCKETS; ++i) {
        if (server->seats[i]) continue;
        server->seats[i] = own;
        own->number = ++server->last_number;
        return 0;
    }
    lws_close_reason(wsi, LWS_CLOSE_STATUS_GOINGAWAY, NULL, 0);
    return -1;
}

static void drop_first(seat *own)
{
    waiting *gone = own->first;
    size_t size;
    packet_bytes(gone->content, &size);
    own->first = gone->next;
    --own->waiting_count;
    own->waiting_bytes -= size;
    own->sent = 0;
    own->begun = false;
    packet_release(gone->content);
    pith_free(gone);
}

static void on_closed(transport *server, seat *own)
{
    bool known = false;
    for (int i = 0; i < MOST_SOCKETS; ++i) {
        if (server->seats[i] != own) continue;
        server->seats[i] = NULL;
        known = true;
    }
    while (own->first) drop_first(own);
    pith_free(own->received);
    own->received = NULL;
    if (known) server->calls.closed(server->calls.user, own->number);
}

static int on_receive(transport *server, seat *own, const void *bytes, size_t size)
{
    struct lws *wsi = own->wsi;
    if (size > most_received - own->received_size ||
        !pith_grow((void **)&own->received, &own->received_capacity, own->received_size + size + 1, 1)) {
        lws_close_reason(wsi, LWS_CLOSE_STATUS_MESSAGE_TOO_LARGE, NULL, 0);
        return -1;
    }
    if (size) memcpy(own->received + own->received_size, bytes, size);
    own->received_size += size;
    if (lws_remaining_packet_payload(wsi) > 0 || !lws_is_final_fragment(wsi)) return 0;
    server->calls.message(server->calls.user, own->number, lws_frame_is_binary(wsi), own->received,
                          own->received_size);
    own->received_size = 0;
    if (own->received_capacity > KEPT_ROOM) {
        pith_free(own->received);
        own->received = NULL;
        own->received_capacity = 0;
    }
    return 0;
}

/* ---- WebSockets: what goes out ----------------------------------------------------------------------------------- */

/* The next piece of the first packet. It is copied, since the library writes its frame's head in front of it, and other
   sockets send the same packet. */
static int on_writeable(transport *server, seat *own)
{
    if (own->overrun) {
        lws_close_reason(own->wsi, LWS_CLOSE_STATUS_POLICY_VIOLATION, NULL, 0);
        return -1;
    }
    if (!own->first) return 0;
    size_t size;
    const packet *content = own->first->content;
    const unsigned char *bytes = packet_bytes(content, &size);
    const size_t left = size - own->sent, now = left < AT_ONCE ? left : AT_ONCE;
    int kind = own->begun ? LWS_WRITE_CONTINUATION : packet_is_binary(content) ? LWS_WRITE_BINARY : LWS_WRITE_TEXT;
    if (now < left) kind |= LWS_WRITE_NO_FIN;
    memcpy(server->scratch + LWS_PRE, bytes + own->sent, now);
    if (lws_write(own->wsi, server->scratch + LWS_PRE, now, (enum lws_write_protocol)kind) < (int)now) return -1;
    own->begun = true;
    own->sent += now;
    if (now == left) drop_first(own);
    if (own->first) lws_callback_on_writable(own->wsi);
    return 0;
}

/* Is this slot the other, or below it? */
static bool is_in_slot(const char *own, const char *slot)
{
    const size_t length = strlen(slot);
    return strncmp(own, slot, length) == 0 && (own[length] == 0 || own[length] == '/');
}

/* Takes out what waits in the slot and is not under way. */
static void drop_slot(seat *own, const char *slot)
{
    waiting **at = &own->first;
    if (*at && own->begun) at = &(*at)->next;
    while (*at) {
        waiting *here = *at;
        if (!is_in_slot(packet_slot(here->content), slot)) {
            at = &here->next;
            continue;
        }
        size_t size;
        packet_bytes(here->content, &size);
        *at = here->next;
        --own->waiting_count;
        own->waiting_bytes -= size;
        packet_release(here->content);
        pith_free(here);
    }
}

static void queue(seat *own, packet *sent)
{
    size_t size;
    packet_bytes(sent, &size);
    if (packet_slot(sent)[0]) drop_slot(own, packet_slot(sent));
    waiting *made = pith_alloc(1, sizeof *made), **end = &own->first;
    if (!made || own->waiting_count >= MOST_WAITING || own->waiting_bytes + size > most_waiting_bytes) {
        pith_free(made);
        own->overrun = true;
    } else {
        *made = (waiting){ packet_hold(sent), NULL };
        while (*end) end = &(*end)->next;
        *end = made;
        ++own->waiting_count;
        own->waiting_bytes += size;
    }
    lws_callback_on_writable(own->wsi);
}

void transport_send(transport *server, uint32_t socket, packet *sent)
{
    for (int i = 0; i < MOST_SOCKETS; ++i) {
        seat *own = server->seats[i];
        if (own && !own->overrun && (socket == OUTBOX_ALL ? own->admitted : own->number == socket)) queue(own, sent);
    }
}

void transport_admit(transport *server, uint32_t socket)
{
    for (int i = 0; i < MOST_SOCKETS; ++i)
        if (server->seats[i] && server->seats[i]->number == socket) server->seats[i]->admitted = true;
}

static int on_socket_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    transport *server = lws_context_user(lws_get_context(wsi));
    switch (reason) {
    case LWS_CALLBACK_ESTABLISHED: return on_established(server, user, wsi);
    case LWS_CALLBACK_CLOSED: on_closed(server, user); return 0;
    case LWS_CALLBACK_RECEIVE: return on_receive(server, user, in, size);
    case LWS_CALLBACK_SERVER_WRITEABLE: return on_writeable(server, user);
    default: return 0;
    }
}

/* ---- life -------------------------------------------------------------------------------------------------------- */

/* Can the port be had? Asked before the library is, which does not say why not. Gives a free one for 0. */
static pith_status try_port(uint32_t *port, pith_error *err)
{
    const int probe = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0), yes = 1;
    if (probe < 0) return pith_fail(err, PITH_IO, "no socket can be made: %s", strerror(errno));
    struct sockaddr_in address = { .sin_family = AF_INET, .sin_port = htons((uint16_t)*port),
                                   .sin_addr.s_addr = htonl(INADDR_LOOPBACK) };
    socklen_t size = sizeof address;
    setsockopt(probe, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    pith_status status = PITH_OK;
    if (bind(probe, (struct sockaddr *)&address, size) != 0)
        status = pith_fail(err, PITH_IO, "port %u of 127.0.0.1 cannot be had: %s; choose another, or none for any free "
                           "one", *port, strerror(errno));
    else if (getsockname(probe, (struct sockaddr *)&address, &size) == 0)
        *port = ntohs(address.sin_port);
    close(probe);
    return status;
}

static pith_status make_token(char token[TOKEN_SIZE], pith_error *err)
{
    unsigned char random[(TOKEN_SIZE - 1) / 2];
    if (getrandom(random, sizeof random, 0) != sizeof random)
        return pith_fail(err, PITH_IO, "no random numbers can be had: %s", strerror(errno));
    for (size_t i = 0; i < sizeof random; ++i) sprintf(token + 2 * i, "%02x", random[i]);
    return PITH_OK;
}

static pith_status listen_on(transport *made, pith_error *err)
{
    static const struct lws_protocols protocols[] = {
        { "http", on_http_event, sizeof(visit), 0, 0, NULL, 0 },
        { "pith", on_socket_event, sizeof(seat), 256 * 1024, 0, NULL, 0 },
        { NULL, NULL, 0, 0, 0, NULL, 0 },
    };
    snprintf(made->policy, sizeof made->policy,
             "default-src 'self'; connect-src 'self' ws://127.0.0.1:%u ws://localhost:%u; img-src 'self' blob: data:; "
             "worker-src 'self' blob:; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
             made->port, made->port);
    lws_set_log_level(0, NULL); /* the library prints nothing */
    const struct lws_context_creation_info info = {
        .port = (int)made->port,
        .iface = "127.0.0.1",
        .protocols = protocols,
        .options = LWS_SERVER_OPTION_DISABLE_IPV6 | LWS_SERVER_OPTION_VALIDATE_UTF8 |
                   LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND,
        .user = made,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
        .timeout_secs = 10,
        .keepalive_timeout = 10,
        .max_http_header_data = 8192,
        .fd_limit_per_thread = 512,
    };
    made->context = lws_create_context(&info);
    if (made->context) return PITH_OK;
    return pith_fail(err, PITH_IO, "port %u of 127.0.0.1 cannot be listened on", made->port);
}

pith_status transport_create(uint32_t port, const page_files *files, const transport_calls *calls, transport **server,
                             pith_error *err)
{
    if (port > 65535) return pith_fail(err, PITH_BAD_ARGUMENT, "port is %u, expected 0 to 65535", port);
    transport *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a server");
    made->files = files;
    made->calls = *calls;
    made->port = port;
    pith_status status = make_token(made->token, err);
    if (status == PITH_OK) status = try_port(&made->port, err);
    if (status == PITH_OK) status = listen_on(made, err);
    if (status == PITH_OK) *server = made;
    else transport_destroy(made);
    return status;
}

void transport_destroy(transport *server)
{
    if (!server) return;
    if (server->context) lws_context_destroy(server->context);
    pith_free(server);
}

uint32_t transport_port(const transport *server) { return server->port; }
const char *transport_token(const transport *server) { return server->token; }

pith_status transport_serve(transport *server, pith_error *err)
{
    while (!atomic_load(&server->stopped))
        if (lws_service(server->context, 0) < 0)
            return pith_fail(err, PITH_EXTERNAL, "libwebsockets gave up serving port %u", server->port);
    return PITH_OK;
}

void transport_wake(transport *server) { lws_cancel_service(server->context); }

void transport_stop(transport *server)
{
    atomic_store(&server->stopped, 1);
    lws_cancel_service(server->context);
}
