/* The byte sink that mesh writers fill. After a failed allocation it swallows everything, so that a writer reads as one
   straight list and the failure is asked for once, at its end. */
#include "mesh_internal.h"

#include <endian.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void mesh_bytes_add(mesh_bytes *bytes, const void *data, size_t size)
{
    if (bytes->failed || size == 0) return;
    if (!pith_grow((void **)&bytes->data, &bytes->room, bytes->size + size, 1)) {
        bytes->failed = true;
        return;
    }
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size += size;
}

void mesh_bytes_text(mesh_bytes *bytes, const char *text) { mesh_bytes_add(bytes, text, strlen(text)); }

/* The caller's locale may write a comma for the point; whatever is no part of a number otherwise stands for it. */
static void add_number(mesh_bytes *bytes, char *text)
{
    for (char *c = text; *c; ++c)
        if (!strchr("0123456789+-e", *c)) *c = '.';
    mesh_bytes_text(bytes, text);
}

void mesh_bytes_number(mesh_bytes *bytes, double value)
{
    char text[40];
    for (int digits = 15; digits <= 17; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value) break;
    }
    add_number(bytes, text);
}

void mesh_bytes_float(mesh_bytes *bytes, float value)
{
    char text[40];
    for (int digits = 6; digits <= 9; ++digits) {
        snprintf(text, sizeof text, "%.*g", digits, (double)value);
        if (strtof(text, NULL) == value) break;
    }
    add_number(bytes, text);
}

void mesh_bytes_integer(mesh_bytes *bytes, uint64_t value)
{
    char text[24];
    snprintf(text, sizeof text, "%llu", (unsigned long long)value);
    mesh_bytes_text(bytes, text);
}

void mesh_bytes_u32(mesh_bytes *bytes, uint32_t value)
{
    const uint32_t little = htole32(value);
    mesh_bytes_add(bytes, &little, sizeof little);
}

void mesh_bytes_f32(mesh_bytes *bytes, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    mesh_bytes_u32(bytes, bits);
}

void mesh_bytes_f64(mesh_bytes *bytes, double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    bits = htole64(bits);
    mesh_bytes_add(bytes, &bits, sizeof bits);
}

void mesh_bytes_free(mesh_bytes *bytes) { pith_free(bytes->data); }
