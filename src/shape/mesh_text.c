/* Words and numbers from mesh files in text: bounded by the end of the buffer, counting lines, the same in every
   locale, and fast, since a scan is a million numbers. */
#define _GNU_SOURCE /* strtod_l */
#include "mesh_internal.h"

#include <locale.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_blank(unsigned char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }
static bool is_digit(unsigned char c) { return c >= '0' && c <= '9'; }

void mesh_text_blanks(mesh_text *text)
{
    while (text->at < text->end) {
        if (is_blank(*text->at)) {
            ++text->at;
        } else if (*text->at == '\\') { /* OBJ joins a line to the next one with a backslash */
            const unsigned char *after = text->at + 1;
            while (after < text->end && *after == '\r') ++after;
            if (after >= text->end || *after != '\n') return;
            text->at = after + 1;
            ++text->line;
        } else {
            return;
        }
    }
}

bool mesh_text_line_ends(mesh_text *text)
{
    mesh_text_blanks(text);
    return text->at >= text->end || *text->at == '\n' || *text->at == '#';
}

void mesh_text_next_line(mesh_text *text)
{
    const unsigned char *stop = text->at < text->end ? memchr(text->at, '\n', (size_t)(text->end - text->at)) : NULL;
    if (stop) ++text->line;
    text->at = stop ? stop + 1 : text->end;
}

void mesh_text_space(mesh_text *text)
{
    while (text->at < text->end && mesh_text_line_ends(text) && text->at < text->end) mesh_text_next_line(text);
}

bool mesh_text_word(mesh_text *text, char *word, size_t capacity)
{
    mesh_text_blanks(text);
    size_t length = 0;
    while (text->at < text->end && *text->at != '\n' && !is_blank(*text->at)) {
        if (length + 1 < capacity) word[length++] = (char)*text->at;
        ++text->at;
    }
    word[length] = 0;
    return length > 0;
}

static locale_t c_locale;
static pthread_once_t c_locale_once = PTHREAD_ONCE_INIT;
static void make_c_locale(void) { c_locale = newlocale(LC_ALL_MASK, "C", (locale_t)0); }

/* The general case, for the few numbers with more digits or larger exponents than the fast path can hold exactly. */
static bool slow_double(const unsigned char *from, const unsigned char *to, double *value)
{
    char copy[400]; /* more characters than a double ever needs; longer ones are cut by the caller's refusal */
    const size_t length = (size_t)(to - from);
    if (length >= sizeof copy) return false;
    memcpy(copy, from, length);
    copy[length] = 0;
    pthread_once(&c_locale_once, make_c_locale);
    if (!c_locale) return false;
    char *stop;
    *value = strtod_l(copy, &stop, c_locale);
    return stop == copy + length;
}

/* "nan", "inf" and their kin: files contain them, and the caller refuses them in better words than "no number". */
static bool named_double(mesh_text *text, double *value)
{
    const unsigned char *stop = text->at;
    while (stop<text->end && * stop> ' ' && *stop != '#') ++stop;
    const size_t length = (size_t)(stop - text->at);
    if (length < 3 || length > 10 || !slow_double(text->at, stop, value) || isfinite(*value)) return false;
    text->at = stop;
    return true;
}

bool mesh_text_double(mesh_text *text, double *value)
{
    static const double powers[] = { 1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                     1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22 };
    mesh_text_blanks(text);
    const unsigned char *at = text->at, *end = text->end;
    const bool negative = at < end && *at == '-';
    if (at < end && (*at == '-' || *at == '+')) ++at;

    /* Digits into an integer, as long as it stays below 2^53 and so exact in a double. */
    uint64_t mantissa = 0;
    int64_t digits = 0, exponent = 0;
    bool exact = true;
    for (int fraction = 0; fraction < 2; ++fraction) {
        if (fraction && (at >= end || *at != '.')) break;
        at += fraction;
        for (; at < end && is_digit(*at); ++at, ++digits) {
            if (mantissa < (UINT64_C(1) << 53) / 10 - 1) {
                mantissa = mantissa * 10 + (uint64_t)(*at - '0');
                exponent -= fraction;
            } else {
                exact = false;
            }
        }
    }
    if (digits == 0) return named_double(text, value);

    if (at + 1 < end && (*at == 'e' || *at == 'E')) {
        const unsigned char *power = at + 1;
        const bool down = *power == '-';
        if (*power == '-' || *power == '+') ++power;
        if (power < end && is_digit(*power)) {
            int64_t e = 0;
            for (; power < end && is_digit(*power); ++power) e = e < 10000 ? e * 10 + (*power - '0') : e;
            exponent += down ? -e : e;
            at = power;
        }
    }

    /* An exact integer times or over an exact power of ten rounds once: the nearest double (Clinger, "How to read
       floating point numbers accurately", PLDI 1990). */
    if (exact && exponent >= -22 && exponent <= 22) {
        const double m = (double)mantissa;
        const double size = exponent < 0 ? m / powers[-exponent] : m * powers[exponent];
        *value = negative ? -size : size;
    } else if (!slow_double(text->at, at, value)) {
        return false;
    }
    text->at = at;
    return true;
}

bool mesh_text_integer(mesh_text *text, int64_t *value)
{
    mesh_text_blanks(text);
    const unsigned char *at = text->at;
    const bool negative = at < text->end && *at == '-';
    if (at < text->end && (*at == '-' || *at == '+')) ++at;
    if (at >= text->end || !is_digit(*at)) return false;
    int64_t number = 0;
    for (; at < text->end && is_digit(*at); ++at) {
        if (number > (INT64_MAX - 9) / 10) return false;
        number = number * 10 + (*at - '0');
    }
    *value = negative ? -number : number;
    text->at = at;
    return true;
}

pith_status mesh_text_fail(const mesh_text *text, pith_error *err, const char *format, ...)
{
    char sentence[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(sentence, sizeof sentence, format, arguments);
    va_end(arguments);
    return pith_fail(err, PITH_BAD_FILE, "%s, line %u: %s", text->name, text->line, sentence);
}
