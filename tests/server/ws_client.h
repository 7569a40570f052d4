/* A small HTTP and WebSocket client on bare sockets, which can also do everything wrong. */
#ifndef PITH_WS_CLIENT_H
#define PITH_WS_CLIENT_H

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "check.h"

/* A connection, or -1. */
static inline int client_connect(unsigned port)
{
    const int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    struct sockaddr_in address = { .sin_family = AF_INET, .sin_port = htons((uint16_t)port),
                                   .sin_addr.s_addr = htonl(INADDR_LOOPBACK) };
    if (fd >= 0 && connect(fd, (struct sockaddr *)&address, sizeof address) == 0) return fd;
    if (fd >= 0) close(fd);
    return -1;
}

/* False when the other side has closed. */
static inline bool client_send(int fd, const void *bytes, size_t size)
{
    const char *at = bytes;
    while (size > 0) {
        const ssize_t sent = send(fd, at, size, MSG_NOSIGNAL);
        if (sent <= 0) return false;
        at += sent;
        size -= (size_t)sent;
    }
    return true;
}

static inline bool client_say(int fd, const char *format, ...)
{
    char text[20000];
    va_list arguments;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return client_send(fd, text, (size_t)length);
}

/* Reads what comes within so many seconds, up to capacity; -1: nothing came, 0: closed. */
static inline ssize_t client_read(int fd, void *bytes, size_t capacity, double seconds)
{
    struct pollfd wait = { .fd = fd, .events = POLLIN };
    if (poll(&wait, 1, (int)(1000 * seconds)) <= 0) return -1;
    const ssize_t got = recv(fd, bytes, capacity, 0);
    return got < 0 ? 0 : got; /* a reset is an end, too */
}

/* Reads exactly so much; false when it does not come within ten seconds. */
static inline bool client_take(int fd, void *bytes, size_t size)
{
    char *at = bytes;
    while (size > 0) {
        const ssize_t got = client_read(fd, at, size, 10.0);
        if (got <= 0) return false;
        at += got;
        size -= (size_t)got;
    }
    return true;
}

/* Reads an answer's head, and what comes with it, into text; gives the status of HTTP, 0 when there is none. */
static inline int client_head(int fd, char *text, size_t capacity)
{
    size_t size = 0;
    int status = 0;
    text[0] = 0;
    while (size + 1 < capacity && !strstr(text, "\r\n\r\n")) {
        const ssize_t got = client_read(fd, text + size, 1, 2.0); /* byte by byte: what follows is left */
        if (got <= 0) return 0;
        text[++size] = 0;
    }
    return sscanf(text, "HTTP/1.%*d %d", &status) == 1 ? status : 0;
}

/* The status of GET for this target with this Host. */
static inline int client_get(unsigned port, const char *target, const char *host)
{
    char head[4000];
    const int fd = client_connect(port);
    if (fd < 0) return -1;
    client_say(fd, "GET %s HTTP/1.1\r\nHost: %s\r\nConnection: close\r\n\r\n", target, host);
    const int status = client_head(fd, head, sizeof head);
    close(fd);
    return status;
}

/* Asks for a WebSocket; headers: further lines, each with its end. Gives the connection, and the status; fd -1 unless
   the status is 101. */
static inline int client_upgrade(unsigned port, const char *target, const char *host, const char *headers, int *status)
{
    char head[4000];
    const int fd = client_connect(port);
    *status = 0;
    if (fd < 0) return -1;
    client_say(fd,
               "GET %s HTTP/1.1\r\nHost: %s\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
               "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n%s\r\n",
               target, host, headers);
    *status = client_head(fd, head, sizeof head);
    /* The key is that of RFC 6455, §1.3, which says the answer to it. */
    if (*status == 101 && strstr(head, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=")) return fd;
    close(fd);
    return -1;
}

enum { WS_MORE = 0, WS_TEXT = 1, WS_BINARY = 2, WS_CLOSE = 8, WS_PING = 9, WS_PONG = 10, WS_FINAL = 0x80 };

/* A frame with its first byte as given (opcode, WS_FINAL), masked or not. */
static inline bool client_frame(int fd, int first, const void *bytes, size_t size, bool masked)
{
    unsigned char head[14] = { (unsigned char)first }, mask[4] = { 7, 99, 200, 31 };
    size_t length = 2;
    if (size < 126) {
        head[1] = (unsigned char)size;
    } else if (size < 65536) {
        head[1] = 126;
        head[2] = (unsigned char)(size >> 8);
        head[3] = (unsigned char)size;
        length = 4;
    } else {
        head[1] = 127;
        for (int i = 0; i < 8; ++i) head[2 + i] = (unsigned char)((uint64_t)size >> (56 - 8 * i));
        length = 10;
    }
    if (!masked) return client_send(fd, head, length) && client_send(fd, bytes, size);
    head[1] |= 0x80;
    memcpy(head + length, mask, 4);
    unsigned char *hidden = malloc(size + 1);
    for (size_t i = 0; i < size; ++i) hidden[i] = ((const unsigned char *)bytes)[i] ^ mask[i % 4];
    const bool sent = client_send(fd, head, length + 4) && client_send(fd, hidden, size);
    free(hidden);
    return sent;
}

static inline bool client_text(int fd, const char *text)
{
    return client_frame(fd, WS_TEXT | WS_FINAL, text, strlen(text), true);
}

/* The next whole message, fragments put together, control frames passed over; its opcode, 0 when the socket is closed,
   -1 when nothing comes within ten seconds. bytes has one zero byte behind; free it. A close frame gives WS_CLOSE. */
static inline int client_message(int fd, unsigned char **bytes, size_t *size)
{
    unsigned char *all = calloc(1, 1), head[2], more[8];
    size_t total = 0;
    int opcode = 0;
    for (;;) {
        const ssize_t first = client_read(fd, head, 1, 10.0);
        if (first <= 0 || !client_take(fd, head + 1, 1)) {
            free(all);
            return first < 0 ? -1 : 0;
        }
        uint64_t length = head[1] & 0x7f;
        const int width = length == 126 ? 2 : length == 127 ? 8 : 0;
        bool good = (head[1] & 0x80) == 0 && client_take(fd, more, (size_t)width); /* a server does not mask */
        if (width) length = 0;
        for (int i = 0; i < width; ++i) length = length << 8 | more[i];
        unsigned char *grown = good && length < 1u << 30 ? realloc(all, total + length + 1) : NULL;
        if (grown) all = grown;
        good = grown && client_take(fd, all + total, length);
        if (!good) {
            free(all);
            return 0;
        }
        const int kind = head[0] & 0x0f;
        if (kind == WS_PING || kind == WS_PONG) continue;
        if (kind != WS_MORE) opcode = kind;
        total += length;
        all[total] = 0;
        if (!(head[0] & WS_FINAL)) continue;
        *bytes = all;
        *size = total;
        return opcode;
    }
}

#endif
