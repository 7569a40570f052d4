/* The server on a real socket: who is let in, what may be asked, and what a client can do wrong. After each wrong a
   fresh client is answered at once. */
#include "server_samples.h"

#include <jansson.h>
#include <pthread.h>

#include "pith/server.h"
#include "ws_client.h"

static const double at_once = 0.2; /* seconds in which a fresh client is answered */
static pith_error err;

/* ---- a server for all tests -------------------------------------------------------------------------------------- */

static pith_server *server;
static pthread_t serving;
static unsigned port;
static char token[40], host[40], socket_path[100];

static void *serve(void *user)
{
    (void)user;
    pith_error failure;
    return pith_server_run(server, &failure) == PITH_OK ? NULL : &server;
}

static int start_server(void **state)
{
    if (make_folder(state) != 0) return -1;
    mkdir(in_folder("page"), 0700);
    mkdir(in_folder("page/assets"), 0700);
    mkdir(in_folder("secret"), 0700);
    write_text("kiwi.pith", SAMPLE_DOCUMENT);
    write_text("page/index.html", "<p>page</p>");
    write_text("page/page.js", "let a = 1;");
    write_text("page/page.js.gz", "(zipped)");
    write_text("page/assets/style.css", "p {}");
    write_text("page/.hidden.js", "no");
    write_text("page/notes.pith", "no");
    write_text("secret/key.js", "no");
    pith_server_options options = pith_server_options_default();
    options.page = in_folder("page");
    options.automatic = false;
    if (pith_server_create(in_folder("kiwi.pith"), &options, &server, &err) != PITH_OK) return -1;
    if (sscanf(pith_server_address(server), "http://127.0.0.1:%u/#%39s", &port, token) != 2) return -1;
    snprintf(host, sizeof host, "127.0.0.1:%u", port);
    snprintf(socket_path, sizeof socket_path, "/socket?token=%s", token);
    return pthread_create(&serving, NULL, serve, NULL);
}

static int stop_server(void **state)
{
    void *failed = NULL;
    pith_server_stop(server);
    pthread_join(serving, &failed);
    pith_server_destroy(server);
    return drop_folder(state) || failed;
}

#define PITH_PROTOCOL "Sec-WebSocket-Protocol: pith\r\n"

static int open_socket(void)
{
    int status;
    const int fd = client_upgrade(port, socket_path, host, PITH_PROTOCOL, &status);
    assert_int_equal(status, 101);
    assert_true(fd >= 0);
    return fd;
}

/* Says something and waits for the answer with this id; packets and events are passed over. */
static json_t *ask(int fd, json_int_t id, const char *keys)
{
    char text[1000];
    snprintf(text, sizeof text, "{\"id\": %lld, %s}", (long long)id, keys);
    assert_true(client_text(fd, text));
    for (;;) {
        unsigned char *bytes = NULL;
        size_t size = 0;
        const int kind = client_message(fd, &bytes, &size);
        assert_true(kind == WS_TEXT || kind == WS_BINARY);
        json_t *heard = kind == WS_TEXT ? json_loadb((const char *)bytes, size, 0, NULL) : NULL;
        free(bytes);
        if (heard && json_integer_value(json_object_get(heard, "id")) == id && json_object_get(heard, "id"))
            return heard;
        json_decref(heard);
    }
}

/* The server is well: a fresh client gets the page, and a fresh socket an answer, at once. On a machine that is busy
   with other things one of a few tries has to be. */
static void check_well(void)
{
    double best = INFINITY;
    for (int tries = 0; tries < 8 && !(best <= at_once); ++tries) {
        const double start = pith_seconds();
        assert_int_equal(client_get(port, "/", host), 200);
        const int fd = open_socket();
        json_decref(ask(fd, 1, "\"do\": \"files\", \"kind\": \"mesh\""));
        close(fd);
        best = fmin(best, pith_seconds() - start);
    }
    CHECK_AT_MOST(best, at_once);
}

/* ---- HTTP -------------------------------------------------------------------------------------------------------- */

static void test_the_page_has_its_files_and_their_headers(void **state)
{
    (void)state;
    char head[4000], body[100] = "";
    const int fd = client_connect(port);
    client_say(fd, "GET /page.js HTTP/1.1\r\nHost: localhost:%u\r\n\r\n", port);
    assert_int_equal(client_head(fd, head, sizeof head), 200);
    assert_true(client_take(fd, body, 10));
    assert_string_equal(body, "let a = 1;");
    static const char *const headers[] = {
        "content-type: text/javascript",
        "x-content-type-options: nosniff",
        "cache-control: no-store",
        "referrer-policy: no-referrer",
        "content-security-policy: default-src 'self'; connect-src 'self' ws://127.0.0.1:",
        "frame-ancestors 'none'",
        "img-src 'self' blob: data:",
    };
    for (size_t i = 0; i < sizeof headers / sizeof *headers; ++i)
        if (!strstr(head, headers[i])) {
            print_error("%s is missing from\n%s\n", headers[i], head);
            fail();
        }
    assert_null(strstr(head, "unsafe"));
    /* The same connection goes on. */
    client_say(fd, "GET /page.js HTTP/1.1\r\nHost: %s\r\nAccept-Encoding: br, gzip\r\n\r\n", host);
    assert_int_equal(client_head(fd, head, sizeof head), 200);
    assert_non_null(strstr(head, "content-encoding: gzip"));
    memset(body, 0, sizeof body);
    assert_true(client_take(fd, body, 8));
    assert_string_equal(body, "(zipped)");
    close(fd);
    assert_int_equal(client_get(port, "/", host), 200);
    assert_int_equal(client_get(port, "/assets/style.css", host), 200);
}

static void test_nothing_else_can_be_had(void **state)
{
    (void)state;
    static const char *const targets[] = {
        "/none.js", "/.hidden.js", "/notes.pith", "/page.js.gz", "/assets", "/assets/", "/socket",
        "/../kiwi.pith", "/../secret/key.js", "/assets/../../secret/key.js", "/%2e%2e/secret/key.js",
        "/..%2fsecret%2fkey.js", "/%2e%2e%2fkiwi.pith", "//etc/passwd", "/etc/passwd", "/\\..\\kiwi.pith",
        "/index.html%00.js", "/./././../kiwi.pith", "/assets/%2e%2e/%2e%2e/kiwi.pith", "/?/../kiwi.pith/x",
    };
    for (size_t i = 0; i < sizeof targets / sizeof *targets; ++i) {
        const int status = client_get(port, targets[i], host);
        /* "/?…" is the page with an argument; what cannot be a path may be hung up on. */
        const bool right = targets[i][1] == '?' ? status == 200 : status == 404 || status == 403 || status == 0;
        if (right) continue;
        print_error("GET %s: %d\n", targets[i], status);
        fail();
    }
    check_well();
}

static void test_other_hosts_and_methods_are_refused(void **state)
{
    (void)state;
    char other[60], head[2000];
    assert_int_equal(client_get(port, "/", "evil.example"), 403);
    snprintf(other, sizeof other, "evil.example:%u", port);
    assert_int_equal(client_get(port, "/", other), 403);
    snprintf(other, sizeof other, "127.0.0.1:%u", port + 1);
    assert_int_equal(client_get(port, "/", other), 403);
    assert_int_equal(client_get(port, "/", "127.0.0.1"), 403);
    static const char *const methods[] = { "POST", "PUT", "DELETE", "OPTIONS", "PATCH" };
    for (size_t i = 0; i < sizeof methods / sizeof *methods; ++i) {
        const int fd = client_connect(port);
        client_say(fd, "%s / HTTP/1.1\r\nHost: %s\r\nContent-Length: 0\r\n\r\n", methods[i], host);
        const int status = client_head(fd, head, sizeof head);
        assert_true(status == 405 || status == 0 || status == 403);
        close(fd);
    }
    const int fd = client_connect(port); /* no Host at all */
    client_say(fd, "GET / HTTP/1.0\r\n\r\n");
    const int status = client_head(fd, head, sizeof head);
    assert_true(status == 403 || status == 0);
    close(fd);
    check_well();
}

/* ---- who gets a WebSocket ---------------------------------------------------------------------------------------- */

static int upgrade_status(const char *target, const char *at, const char *headers)
{
    int status;
    const int fd = client_upgrade(port, target, at, headers, &status);
    if (fd >= 0) close(fd);
    return status;
}

static void test_sockets_need_token_origin_and_host(void **state)
{
    (void)state;
    char target[100], headers[300], other[60];
    assert_int_equal(upgrade_status(socket_path, host, PITH_PROTOCOL), 101);
    snprintf(other, sizeof other, "localhost:%u", port);
    snprintf(headers, sizeof headers, PITH_PROTOCOL "Origin: http://localhost:%u\r\n", port);
    assert_int_equal(upgrade_status(socket_path, other, headers), 101);
    snprintf(headers, sizeof headers, PITH_PROTOCOL "Origin: http://127.0.0.1:%u\r\n", port);
    assert_int_equal(upgrade_status(socket_path, host, headers), 101);

    snprintf(target, sizeof target, "/socket?token=%s0", token);
    assert_int_equal(upgrade_status(target, host, PITH_PROTOCOL), 403);
    snprintf(target, sizeof target, "/socket?token=%.31s%c", token, token[31] == '0' ? '1' : '0');
    assert_int_equal(upgrade_status(target, host, PITH_PROTOCOL), 403);
    assert_int_equal(upgrade_status("/socket?token=", host, PITH_PROTOCOL), 403);
    assert_int_equal(upgrade_status("/socket", host, PITH_PROTOCOL), 403);
    snprintf(target, sizeof target, "/?token=%s", token);
    assert_int_equal(upgrade_status(target, host, PITH_PROTOCOL), 404);

    static const char *const origins[] = { "http://evil.example", "https://127.0.0.1:%u", "http://127.0.0.1", "null",
                                           "http://127.0.0.1:%u.evil.example", "http://127.0.0.1:%u/", "" };
    for (size_t i = 0; i < sizeof origins / sizeof *origins; ++i) {
        char origin[80];
        snprintf(origin, sizeof origin, origins[i], port); /* each has one number at most */
        snprintf(headers, sizeof headers, PITH_PROTOCOL "Origin: %s\r\n", origin);
        const int status = upgrade_status(socket_path, host, headers);
        if (status == 403 || (origins[i][0] == 0 && status == 101)) continue; /* an empty header is none */
        print_error("origin %s: %d\n", origin, status);
        fail();
    }
    snprintf(other, sizeof other, "evil.example:%u", port); /* a name that its owner points at this machine */
    assert_int_equal(upgrade_status(socket_path, other, PITH_PROTOCOL), 403);
    assert_int_equal(upgrade_status(socket_path, host, ""), 400);
    assert_int_equal(upgrade_status(socket_path, host, "Sec-WebSocket-Protocol: other\r\n"), 400);
    check_well();
}

static void test_sixteen_sockets_and_no_more(void **state)
{
    (void)state;
    int open[16];
    for (int i = 0; i < 16; ++i) open[i] = open_socket();
    assert_int_equal(upgrade_status(socket_path, host, PITH_PROTOCOL), 503);
    assert_int_equal(client_get(port, "/", host), 200); /* the page is still to be had */
    json_decref(ask(open[15], 1, "\"do\": \"files\", \"kind\": \"mesh\""));
    for (int i = 0; i < 16; ++i) close(open[i]);
    for (int tries = 0; tries < 100 && upgrade_status(socket_path, host, PITH_PROTOCOL) != 101; ++tries)
        usleep(10000); /* until the server has noticed */
    check_well();
}

/* ---- what a client can do wrong ---------------------------------------------------------------------------------- */

/* The socket is closed by the server, perhaps with a close frame before; nothing else is heard. */
static void expect_closed(int fd)
{
    unsigned char *bytes = NULL;
    size_t size;
    int kind = client_message(fd, &bytes, &size);
    if (kind == WS_CLOSE) {
        free(bytes);
        client_frame(fd, WS_CLOSE | WS_FINAL, "\x03\xe8", 2, true);
        kind = client_message(fd, &bytes, &size);
    }
    if (kind > 0) free(bytes);
    assert_int_equal(kind, 0);
    close(fd);
    check_well();
}

/* Raw bytes behind an upgrade: the socket is closed, or waits for more and does no harm. */
static void send_raw(const void *bytes, size_t size)
{
    const int fd = open_socket();
    client_send(fd, bytes, size);
    check_well();
    close(fd);
    check_well();
}

static void test_broken_frames_end_their_own_socket_only(void **state)
{
    (void)state;
    int fd = open_socket();
    client_frame(fd, 3 | WS_FINAL, "x", 1, true); /* an opcode that is none */
    expect_closed(fd);
    fd = open_socket();
    client_frame(fd, 0x70 | WS_TEXT | WS_FINAL, "x", 1, true); /* reserved bits */
    expect_closed(fd);
    fd = open_socket();
    client_frame(fd, WS_MORE | WS_FINAL, "x", 1, true); /* going on with what was not begun */
    expect_closed(fd);
    fd = open_socket();
    char long_ping[200] = { 0 };
    client_frame(fd, WS_PING | WS_FINAL, long_ping, sizeof long_ping, true); /* control frames are short */
    expect_closed(fd);
    fd = open_socket();
    client_frame(fd, WS_TEXT | WS_FINAL, "{\"id\": 1, \"do\": \"\xc3\x28\"}", 22, true); /* not UTF-8 */
    expect_closed(fd);
    send_raw("\x81\xfe", 2);                                         /* cut off in the head */
    send_raw("\x81\xff\x7f\xff\xff\xff\xff\xff\xff\xff", 10);        /* 2^63 bytes announced */
    send_raw("\x81\xff\xff\xff\xff\xff\xff\xff\xff\xff", 10);        /* more than there can be */
    send_raw("\x82\xff\x00\x00\x00\x00\xc0\x00\x00\x00\x01\x02\x03\x04zzzz", 18); /* 3 GiB announced, 4 bytes sent */
    send_raw("\x81\x85\x01\x02\x03", 5);                             /* cut off in the mask */
    send_raw("GET / HTTP/1.1\r\n\r\n", 18);                          /* HTTP where frames belong */
}

/* A frame without a mask says the same; a browser never sends one. */
static void test_unmasked_frames_do_no_harm(void **state)
{
    (void)state;
    const int fd = open_socket();
    static const char text[] = "{\"id\": 1, \"do\": \"nothing\"}";
    client_frame(fd, WS_TEXT | WS_FINAL, text, strlen(text), false);
    check_well();
    close(fd);
}

static void test_messages_may_come_in_pieces(void **state)
{
    (void)state;
    const int fd = open_socket();
    static const char text[] = "{\"id\": 3, \"do\": \"files\", \"kind\": \"mesh\"}";
    for (size_t i = 0; i + 1 < sizeof text; ++i) {
        const int first = (i == 0 ? WS_TEXT : WS_MORE) | (i + 2 == sizeof text ? WS_FINAL : 0);
        assert_true(client_frame(fd, first, text + i, 1, true));
        if (i == 5) assert_true(client_frame(fd, WS_PING | WS_FINAL, "hi", 2, true)); /* in between */
    }
    unsigned char *bytes = NULL;
    size_t size;
    assert_int_equal(client_message(fd, &bytes, &size), WS_TEXT);
    assert_non_null(strstr((char *)bytes, "\"id\":3"));
    free(bytes);
    close(fd);
}

static void test_a_message_is_at_most_64_mib(void **state)
{
    (void)state;
    const int fd = open_socket();
    enum { PIECE = 1 << 20 };
    char *piece = calloc(1, PIECE);
    bool taken = true;
    int sent = 0;
    for (; taken && sent < 80; ++sent)
        taken = client_frame(fd, sent == 0 ? WS_BINARY : WS_MORE, piece, PIECE, true);
    free(piece);
    assert_true(sent >= 64);
    unsigned char *bytes = NULL;
    size_t size;
    int kind = client_message(fd, &bytes, &size);
    if (kind == WS_CLOSE) {
        assert_int_equal(bytes[0] << 8 | bytes[1], 1009); /* too large (RFC 6455, §7.4.1) */
        free(bytes);
    } else {
        assert_int_equal(kind, 0);
    }
    close(fd);
    check_well();
}

static void test_half_requests_and_idle_sockets_hold_up_nobody(void **state)
{
    (void)state;
    int half[20], idle[12];
    for (int i = 0; i < 20; ++i) {
        half[i] = client_connect(port);
        client_say(half[i], "GET / HTTP/1.1\r\nHost: %s\r\nX-Slow: ", host);
    }
    for (int i = 0; i < 12; ++i) idle[i] = open_socket();
    check_well();
    for (int i = 0; i < 20; ++i) close(half[i]);
    for (int i = 0; i < 12; ++i) close(idle[i]);

    int plain[20]; /* connections that never say anything */
    for (int i = 0; i < 20; ++i) plain[i] = client_connect(port);
    check_well();
    for (int i = 0; i < 20; ++i) close(plain[i]);
    check_well();
}

static void test_garbage_instead_of_http(void **state)
{
    (void)state;
    char head[2000], *large = malloc(200000);
    memset(large, 'a', 200000);
    int fd = client_connect(port);
    client_send(fd, "\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11); /* TLS */
    client_head(fd, head, sizeof head);
    close(fd);
    check_well();
    fd = client_connect(port); /* a header without end */
    client_say(fd, "GET / HTTP/1.1\r\nHost: %s\r\nX: ", host);
    client_send(fd, large, 200000);
    client_say(fd, "\r\n\r\n");
    const int status = client_head(fd, head, sizeof head);
    assert_true(status == 0 || status >= 400);
    close(fd);
    check_well();
    fd = client_connect(port); /* an address without end */
    client_say(fd, "GET /");
    client_send(fd, large, 200000);
    client_say(fd, " HTTP/1.1\r\nHost: %s\r\n\r\n", host);
    assert_int_not_equal(client_head(fd, head, sizeof head), 200);
    close(fd);
    free(large);
    check_well();
}

/* Makes the document some 150 kB large; gives its revision. */
static long long apply_many_points(int fd, long long revision)
{
    enum { POINTS = 5000, ROOM = POINTS * 40 };
    char *text = malloc(ROOM);
    int length = snprintf(text, ROOM,
                          "{\"id\": 2, \"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": "
                          "[{\"op\": \"depth.points\", \"depth\": 0.5, \"points\": [",
                          revision);
    for (int i = 0; i < POINTS; ++i)
        length += snprintf(text + length, (size_t)(ROOM - length), "%s[%.6f, 0.125, -0.0625]", i ? ", " : "", i * 1e-5);
    snprintf(text + length, (size_t)(ROOM - length), "]}]}");
    assert_true(client_text(fd, text));
    free(text);
    json_t *answer = ask(fd, 3, "\"do\": \"hello\"");
    const long long made = (long long)json_integer_value(json_object_get(answer, "revision"));
    assert_true(made > revision);
    json_decref(answer);
    return made;
}

/* A page that never reads costs the server the newest of each kind, not all there was. */
static void test_a_page_that_never_reads_does_no_harm(void **state)
{
    (void)state;
    enum { CHANGES = 150 };
    const int deaf = open_socket(), writer = open_socket();
    assert_true(client_text(deaf, "{\"id\": 1, \"do\": \"hello\"}"));
    json_t *hello = ask(writer, 1, "\"do\": \"hello\"");
    long long revision = apply_many_points(writer, (long long)json_integer_value(json_object_get(hello, "revision")));
    json_decref(hello);
    char keys[300];
    for (int i = 0; i < CHANGES; ++i) {
        snprintf(keys, sizeof keys, "\"do\": \"apply\", \"revision\": %lld, \"name\": \"x\", \"operations\": [{\"op\": "
                 "\"set\", \"path\": \"title\", \"value\": \"title %d\"}]", revision, i);
        json_t *answer = ask(writer, 10 + i, keys);
        revision = (long long)json_integer_value(json_object_get(answer, "revision"));
        assert_true(revision > 0);
        json_decref(answer);
    }
    check_well();
    /* When it reads at last, it gets what there is now, and not each change there was. */
    int documents = 0;
    for (bool last = false; !last; ++documents) {
        unsigned char *bytes = NULL;
        size_t size;
        const int kind = client_message(deaf, &bytes, &size);
        assert_true(kind == WS_TEXT || kind == WS_BINARY);
        last = strstr((char *)bytes, "\"title\":\"title 149\"") != NULL;
        free(bytes);
    }
    CHECK_AT_MOST(documents, CHANGES / 2); /* some were under way before its buffers were full */
    close(deaf);
    close(writer);
}

static void test_a_large_packet_arrives_whole(void **state)
{
    (void)state;
    const int fd = open_socket();
    assert_true(client_text(fd,
                            "{\"id\": 1, \"do\": \"exemplar\", \"exemplar\": {\"layered\": {\"size\": [128, 64, 128], "
                            "\"stops\": [{\"depth\": 0, \"colour\": \"#ffffff\"}]}}}"));
    unsigned char *bytes = NULL;
    size_t size = 0;
    assert_int_equal(client_message(fd, &bytes, &size), WS_BINARY);
    uint32_t length;
    memcpy(&length, bytes, 4);
    assert_int_equal(size, 4 + length + 4 * 128 * 64 * 128);
    size_t white = 0;
    for (size_t i = 4 + length; i < size; ++i) white += bytes[i] == 255;
    assert_int_equal(white, size - 4 - length);
    free(bytes);
    close(fd);
}

/* ---- creating ---------------------------------------------------------------------------------------------------- */

static void test_what_cannot_be_served_is_refused(void **state)
{
    (void)state;
    pith_server *other = NULL;
    pith_server_options options = pith_server_options_default();
    write_text("other.pith", SAMPLE_DOCUMENT);
    CHECK_FAILS(pith_server_create(in_folder("other.pith"), &options, &other, &err), PITH_BAD_ARGUMENT, "page");
    options.page = in_folder("secret");
    CHECK_FAILS(pith_server_create(in_folder("other.pith"), &options, &other, &err), PITH_IO, "index.html");
    options.page = in_folder("page");
    CHECK_FAILS(pith_server_create(in_folder("kiwi.pith"), &options, &other, &err), PITH_IO, "being edited");
    CHECK_FAILS(pith_server_create(in_folder("none.pith"), &options, &other, &err), PITH_IO, "none.pith");
    options.port = port;
    CHECK_FAILS(pith_server_create(in_folder("other.pith"), &options, &other, &err), PITH_IO, "cannot be had");
    options.port = 70000;
    CHECK_FAILS(pith_server_create(in_folder("other.pith"), &options, &other, &err), PITH_BAD_ARGUMENT, "70000");
    assert_null(other);
    options.port = 0;
    CHECK_OK(pith_server_create(in_folder("other.pith"), &options, &other, &err));
    assert_string_not_equal(pith_server_address(other), pith_server_address(server));
    pith_server_stop(other); /* before it runs */
    CHECK_OK(pith_server_run(other, &err));
    pith_server_destroy(other);
    check_well();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_page_has_its_files_and_their_headers),
        cmocka_unit_test(test_nothing_else_can_be_had),
        cmocka_unit_test(test_other_hosts_and_methods_are_refused),
        cmocka_unit_test(test_sockets_need_token_origin_and_host),
        cmocka_unit_test(test_sixteen_sockets_and_no_more),
        cmocka_unit_test(test_broken_frames_end_their_own_socket_only),
        cmocka_unit_test(test_unmasked_frames_do_no_harm),
        cmocka_unit_test(test_messages_may_come_in_pieces),
        cmocka_unit_test(test_a_message_is_at_most_64_mib),
        cmocka_unit_test(test_half_requests_and_idle_sockets_hold_up_nobody),
        cmocka_unit_test(test_garbage_instead_of_http),
        cmocka_unit_test(test_a_page_that_never_reads_does_no_harm),
        cmocka_unit_test(test_a_large_packet_arrives_whole),
        cmocka_unit_test(test_what_cannot_be_served_is_refused),
    };
    return cmocka_run_group_tests(tests, start_server, stop_server);
}
