/* pith sample: the whole system as a filter. Points in, colours out. */
#include "cli.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

enum { BATCH = 65536, LONGEST_LINE = 1000 };

typedef struct sampler {
    const pith_solid *solid;
    uint32_t channels;
    FILE *in;
    const char *name;           /* of the input, for messages */
    pith_vec3 *points, *normals;
    float *colours;
} sampler;

/* "x y z" or "x y z nx ny nz"; anything else is no line of points. */
static bool read_line(const char *text, pith_vec3 *point, pith_vec3 *normal)
{
    double v[6] = { 0 };
    int count = 0;
    for (char *end; count < 6; ++count, text = end) {
        v[count] = strtod(text, &end);
        if (end == text) break;
        if (!isfinite(v[count])) return false;
    }
    if (text[strspn(text, " \t\r\n")] != 0) return false;
    *point = pith_v3(v[0], v[1], v[2]);
    *normal = pith_v3(v[3], v[4], v[5]);
    return count == 3 || count == 6;
}

static pith_status ask(const sampler *s, size_t count, bool with_normals, pith_error *err)
{
    const pith_query query = { .points = s->points, .normals = with_normals ? s->normals : NULL, .count = count };
    return pith_solid_sample(s->solid, &query, s->colours, err);
}

/* Prints the answers to the batch collected so far. */
static pith_status answer_lines(const sampler *s, size_t count, bool with_normals, pith_error *err)
{
    PITH_TRY(ask(s, count, with_normals, err));
    for (size_t i = 0; i < count; ++i)
        for (uint32_t c = 0; c < s->channels; ++c)
            printf("%.9g%c", (double)s->colours[i * s->channels + c], c + 1 < s->channels ? ' ' : '\n');
    return PITH_OK;
}

static pith_status sample_lines(const sampler *s, pith_error *err)
{
    char text[LONGEST_LINE];
    size_t number = 0, count = 0;
    bool with_normals = true;
    while (fgets(text, sizeof text, s->in)) {
        ++number;
        if (!strchr(text, '\n') && !feof(s->in))
            return pith_fail(err, PITH_BAD_FILE, "%s: line %zu is longer than %d letters", s->name, number,
                             LONGEST_LINE - 2);
        const size_t blank = strspn(text, " \t\r\n");
        if (text[blank] == 0 || text[blank] == '#') continue;
        if (!read_line(text, &s->points[count], &s->normals[count]))
            return pith_fail(err, PITH_BAD_FILE, "%s: line %zu: expected \"x y z\" or \"x y z nx ny nz\"", s->name,
                             number);
        with_normals = with_normals && pith_length(s->normals[count]) > 0.0;
        if (++count < BATCH) continue;
        PITH_TRY(answer_lines(s, count, with_normals, err));
        count = 0;
        with_normals = true;
    }
    if (ferror(s->in)) return pith_fail(err, PITH_IO, "%s: cannot be read: %s", s->name, strerror(errno));
    return count ? answer_lines(s, count, with_normals, err) : PITH_OK;
}

static pith_status sample_binary(const sampler *s, pith_error *err)
{
    for (;;) {
        const size_t bytes = fread(s->points, 1, BATCH * sizeof *s->points, s->in);
        const size_t count = bytes / sizeof *s->points;
        if (ferror(s->in)) return pith_fail(err, PITH_IO, "%s: cannot be read: %s", s->name, strerror(errno));
        if (bytes % sizeof *s->points)
            return pith_fail(err, PITH_BAD_FILE, "%s: ends in the middle of a point; expected triples of 64-bit floats",
                             s->name);
        if (count == 0) return PITH_OK;
        for (size_t i = 0; i < count; ++i)
            if (!pith_finite(s->points[i]))
                return pith_fail(err, PITH_BAD_FILE, "%s: a point is not finite", s->name);
        PITH_TRY(ask(s, count, false, err));
        if (fwrite(s->colours, sizeof(float) * s->channels, count, stdout) != count)
            return pith_fail(err, PITH_IO, "the standard output cannot be written: %s", strerror(errno));
    }
}

static pith_status run(const cli_model *opened, FILE *in, const char *name, bool binary, pith_error *err)
{
    sampler s = { .in = in, .name = name };
    PITH_TRY(pith_model_solid(opened->model, &s.solid, err));
    cli_progress_done();
    s.channels = pith_solid_channels(s.solid);
    s.points = pith_alloc(BATCH, sizeof *s.points);
    s.normals = pith_alloc(BATCH, sizeof *s.normals);
    s.colours = pith_alloc((size_t)BATCH * s.channels, sizeof *s.colours);
    pith_status status = s.points && s.normals && s.colours ? PITH_OK : PITH_OUT_OF_MEMORY(err, "points");
    if (status == PITH_OK) status = binary ? sample_binary(&s, err) : sample_lines(&s, err);
    pith_free(s.points);
    pith_free(s.normals);
    pith_free(s.colours);
    return status;
}

int verb_sample(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    bool binary = false;
    const cli_flag flags[] = {
        { "binary", 0, CLI_SWITCH, &binary, NULL, "64-bit float triples in, 32-bit float tuples out, nothing between", 0, 0,
          NULL },
        CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "sample", .words = "DOCUMENT [FILE|-]", .least_words = 1, .most_words = 2, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Reads points, one \"x y z [nx ny nz]\" a line, and prints the solid there, one \"r g b a ...\" a line:\n"
                   "linear RGB, opacity, further channels. Outside the shape all are 0. Empty lines and lines that\n"
                   "begin with # are skipped. Without FILE, or with -, reads the standard input.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;

    const bool from_file = line.word_count > 1 && strcmp(line.word[1], "-") != 0;
    FILE *in = from_file ? fopen(line.word[1], "rb") : stdin;
    pith_error err;
    if (!in) {
        pith_fail(&err, PITH_IO, "%s: cannot be opened: %s", line.word[1], strerror(errno));
        return cli_fail("sample", &err);
    }
    cli_model opened;
    int result = cli_open("sample", line.word[0], &common, &opened);
    if (result == CLI_GO_ON) {
        const char *name = from_file ? line.word[1] : "standard input";
        const pith_status status = run(&opened, in, name, binary, &err);
        const int written = cli_finish_output("sample");
        result = status != PITH_OK ? cli_fail("sample", &err) : written;
        cli_close(&opened);
    }
    if (from_file) fclose(in);
    return result;
}
