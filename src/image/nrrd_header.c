/* The text part of NRRD: fields, one a line, up to an empty line. Fields that do not bear on a grid of samples
   (content, labels, units, ...) are passed over, as the format asks of readers that do not need them. */
#include "nrrd_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define AXES_MAX 4

/* The header while it is read: per axis, channel axis included. */
typedef struct draft {
    const char *name;
    pith_error *err;
    int dimension;                      /* 0: not yet said */
    bool has_type, has_encoding, has_endian, big_endian;
    nrrd_type type;
    bool gzip, srgb;
    uint64_t sizes[AXES_MAX];           /* 0: not yet said */
    double spacings[AXES_MAX];          /* NaN: none */
    const char *directions, *origin;    /* read once the dimension is known */
    const char *data_file;
    long long line_skip, byte_skip;
} draft;

static pith_status bad(const draft *d, const char *field, const char *value, const char *expected)
{
    return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD field \"%s\" is \"%.60s\", expected %s", d->name, field, value,
                     expected);
}

/* ---- single fields ------------------------------------------------------------------------------------------- */

static pith_status parse_type(draft *d, const char *value)
{
    static const struct { const char *word; nrrd_type type; } words[] = {
        { "signed char", NRRD_INT8 }, { "int8", NRRD_INT8 }, { "int8_t", NRRD_INT8 }, { "uchar", NRRD_UINT8 },
        { "unsigned char", NRRD_UINT8 }, { "uint8", NRRD_UINT8 }, { "uint8_t", NRRD_UINT8 }, { "short", NRRD_INT16 },
        { "short int", NRRD_INT16 }, { "signed short", NRRD_INT16 }, { "signed short int", NRRD_INT16 },
        { "int16", NRRD_INT16 }, { "int16_t", NRRD_INT16 }, { "ushort", NRRD_UINT16 },
        { "unsigned short", NRRD_UINT16 }, { "unsigned short int", NRRD_UINT16 }, { "uint16", NRRD_UINT16 },
        { "uint16_t", NRRD_UINT16 }, { "int", NRRD_INT32 }, { "signed int", NRRD_INT32 }, { "int32", NRRD_INT32 },
        { "int32_t", NRRD_INT32 }, { "uint", NRRD_UINT32 }, { "unsigned int", NRRD_UINT32 },
        { "uint32", NRRD_UINT32 }, { "uint32_t", NRRD_UINT32 }, { "float", NRRD_FLOAT }, { "double", NRRD_DOUBLE },
    };
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (strcasecmp(words[i].word, value) == 0) {
            d->type = words[i].type;
            d->has_type = true;
            return PITH_OK;
        }
    return bad(d, "type", value, "an integer of 8, 16 or 32 bit, float or double");
}

static pith_status parse_encoding(draft *d, const char *value)
{
    d->gzip = strcasecmp(value, "gzip") == 0 || strcasecmp(value, "gz") == 0;
    d->has_encoding = true;
    if (!d->gzip && strcasecmp(value, "raw") != 0) return bad(d, "encoding", value, "raw or gzip");
    return PITH_OK;
}

static pith_status parse_endian(draft *d, const char *value)
{
    d->big_endian = strcasecmp(value, "big") == 0;
    d->has_endian = true;
    if (!d->big_endian && strcasecmp(value, "little") != 0) return bad(d, "endian", value, "little or big");
    return PITH_OK;
}

static pith_status parse_dimension(draft *d, const char *value)
{
    if (strcmp(value, "3") != 0 && strcmp(value, "4") != 0)
        return bad(d, "dimension", value, "3, or 4 with the channels as first axis");
    d->dimension = value[0] - '0';
    return PITH_OK;
}

static pith_status parse_sizes(draft *d, const char *value)
{
    const char *at = value;
    for (int axis = 0; axis < d->dimension; ++axis) {
        char *end;
        errno = 0;
        const long long size = strtoll(at, &end, 10);
        if (end == at || errno || size < 1 || size > UINT32_MAX)
            return bad(d, "sizes", value, "one positive number an axis");
        d->sizes[axis] = (uint64_t)size;
        at = end;
    }
    if (at[strspn(at, " \t")] != 0) return bad(d, "sizes", value, "as many numbers as there are axes");
    return PITH_OK;
}

static pith_status parse_spacings(draft *d, const char *value)
{
    const char *at = value;
    for (int axis = 0; axis < d->dimension; ++axis) {
        char *end;
        d->spacings[axis] = strtod(at, &end);
        if (end == at) return bad(d, "spacings", value, "one number an axis, NaN for the channels");
        at = end;
    }
    return PITH_OK;
}

static pith_status parse_skip(draft *d, const char *field, const char *value, long long lowest, long long *skip)
{
    char *end;
    errno = 0;
    *skip = strtoll(value, &end, 10);
    if (end == value || *end || errno || *skip < lowest) return bad(d, field, value, "a number of lines or bytes");
    return PITH_OK;
}

/* A vector "(a,b,c)"; *at moves behind it. */
static bool parse_vector(const char **at, double vector[3])
{
    const char *p = *at + strspn(*at, " \t");
    if (*p++ != '(') return false;
    for (int i = 0; i < 3; ++i) {
        char *end;
        vector[i] = strtod(p, &end);
        if (end == p || !isfinite(vector[i])) return false;
        p = end + strspn(end, " \t");
        if (*p++ != (i < 2 ? ',' : ')')) return false;
    }
    *at = p;
    return true;
}

/* The grid's axes are those of space: what is turned or mirrored would need resampling. */
static pith_status parse_directions(draft *d)
{
    static const char expected[] = "\"none\" for the channels, then (x,0,0) (0,y,0) (0,0,z) with positive x, y, z; "
                                   "resample a turned or mirrored volume first";
    const char *at = d->directions;
    for (int axis = 0; axis < d->dimension; ++axis) {
        at += strspn(at, " \t");
        const int space_axis = axis - (d->dimension - 3);
        if (space_axis < 0) {
            if (strncasecmp(at, "none", 4) != 0) return bad(d, "space directions", d->directions, expected);
            at += 4;
            continue;
        }
        double v[3];
        if (!parse_vector(&at, v)) return bad(d, "space directions", d->directions, expected);
        const double diagonal = v[space_axis];
        for (int i = 0; i < 3; ++i)
            if (i != space_axis && !(fabs(v[i]) <= 1e-6 * diagonal))
                return bad(d, "space directions", d->directions, expected);
        d->spacings[axis] = diagonal;
    }
    return PITH_OK;
}

/* ---- lines --------------------------------------------------------------------------------------------------- */

static pith_status parse_field(draft *d, const char *field, char *value)
{
    const bool per_axis = !strcasecmp(field, "sizes") || !strcasecmp(field, "spacings");
    if (per_axis && !d->dimension)
        return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD field \"%s\" stands before \"dimension\"", d->name, field);
    if (!strcasecmp(field, "type")) return parse_type(d, value);
    if (!strcasecmp(field, "encoding")) return parse_encoding(d, value);
    if (!strcasecmp(field, "endian")) return parse_endian(d, value);
    if (!strcasecmp(field, "dimension")) return parse_dimension(d, value);
    if (!strcasecmp(field, "sizes")) return parse_sizes(d, value);
    if (!strcasecmp(field, "spacings")) return parse_spacings(d, value);
    if (!strcasecmp(field, "line skip") || !strcasecmp(field, "lineskip"))
        return parse_skip(d, field, value, 0, &d->line_skip);
    if (!strcasecmp(field, "byte skip") || !strcasecmp(field, "byteskip"))
        return parse_skip(d, field, value, -1, &d->byte_skip);
    if (!strcasecmp(field, "space directions")) d->directions = value;
    if (!strcasecmp(field, "space origin")) d->origin = value;
    if (!strcasecmp(field, "data file") || !strcasecmp(field, "datafile")) d->data_file = value;
    return PITH_OK;
}

static pith_status parse_line(draft *d, char *line)
{
    if (line[0] == '#') return PITH_OK;
    char *mark = strchr(line, ':');
    if (mark && mark[1] == '=') {
        *mark = 0;
        if (!strcmp(line, NRRD_ENCODING_KEY)) d->srgb = strcasecmp(mark + 2, "sRGB") == 0;
        return PITH_OK;
    }
    if (!mark || mark[1] != ' ')
        return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD header line \"%.60s\" is no \"field: value\"", d->name,
                         line);
    *mark = 0;
    char *value = mark + 2 + strspn(mark + 2, " \t");
    for (size_t length = strlen(value); length && strchr(" \t", value[length - 1]);) value[--length] = 0;
    return parse_field(d, line, value);
}

/* Cuts the next line off; NULL at the end of the text. Lines end with \n, \r\n, or the text, which has a zero there. */
static char *next_line(char **at, char *end)
{
    if (*at == end) return NULL;
    char *line = *at, *stop = memchr(line, '\n', (size_t)(end - line));
    if (!stop) stop = end;
    *at = stop < end ? stop + 1 : end;
    *stop = 0;
    if (stop > line && stop[-1] == '\r') stop[-1] = 0;
    return line;
}

/* ---- the whole ----------------------------------------------------------------------------------------------- */

/* What the fields must say together, and the grid's frame from them. */
static pith_status finish(draft *d, bool normalise, nrrd_header *header)
{
    const char *missing = !d->has_type ? "type" : !d->dimension ? "dimension" : !d->sizes[0] ? "sizes"
                          : !d->has_encoding ? "encoding" : NULL;
    if (missing) return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD header has no field \"%s\"", d->name, missing);
    if (nrrd_type_size(d->type) > 1 && !d->has_endian)
        return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD header has no field \"endian\", but values of %zu bytes",
                         d->name, nrrd_type_size(d->type));
    if (d->directions) PITH_TRY(parse_directions(d));

    const uint16_t probe = 1;
    const bool machine_big = *(const unsigned char *)&probe == 0;
    const int first = d->dimension - 3; /* the first axis of space */
    double origin[3] = { 0, 0, 0 };
    const char *at = d->origin;
    if (at && !parse_vector(&at, origin)) return bad(d, "space origin", d->origin, "(x,y,z)");
    double spacing[3];
    for (int i = 0; i < 3; ++i) {
        spacing[i] = isnan(d->spacings[first + i]) ? 1.0 : d->spacings[first + i];
        if (!(spacing[i] > 0.0 && isfinite(spacing[i])))
            return pith_fail(d->err, PITH_BAD_FILE, "%s: NRRD spacing of axis %d is %g, expected a positive number",
                             d->name, first + i, spacing[i]);
        header->size[i] = (uint32_t)d->sizes[first + i];
        if (d->origin) origin[i] -= 0.5 * spacing[i]; /* the file gives the first sample's centre */
    }
    header->channels = first ? (uint32_t)d->sizes[0] : 1;
    header->origin = pith_v3(origin[0], origin[1], origin[2]);
    header->spacing = pith_v3(spacing[0], spacing[1], spacing[2]);
    header->type = d->type;
    header->gzip = d->gzip;
    header->srgb = d->srgb;
    header->normalise = (normalise || d->srgb) && (d->type == NRRD_UINT8 || d->type == NRRD_UINT16);
    header->swap = nrrd_type_size(d->type) > 1 && d->big_endian != machine_big;
    header->data_file = d->data_file;
    header->line_skip = d->line_skip;
    header->byte_skip = d->byte_skip;
    return PITH_OK;
}

pith_status nrrd_parse_header(const char *name, char *text, size_t size, bool normalise, nrrd_header *header,
                              pith_error *err)
{
    if (size < 8 || memcmp(text, "NRRD000", 7) != 0 || text[7] < '1' || text[7] > '9')
        return pith_fail(err, PITH_BAD_FILE, "%s: is no NRRD file: it does not begin with NRRD0001 to NRRD0009", name);
    draft d = { .name = name, .err = err, .spacings = { NAN, NAN, NAN, NAN } };
    char *at = text, *end = text + size;
    next_line(&at, end); /* the magic */
    for (;;) {
        char *line = next_line(&at, end);
        if (!line && d.data_file) break; /* a detached header may end with its file */
        if (!line) return pith_fail(err, PITH_BAD_FILE, "%s: NRRD header has no end; is the file cut off?", name);
        if (!line[0]) break;
        PITH_TRY(parse_line(&d, line));
    }
    PITH_TRY(finish(&d, normalise, header));
    header->data_at = (size_t)(at - text);
    return PITH_OK;
}
