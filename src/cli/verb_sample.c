/* pith sample: the whole system as a filter. Points in, colours out. */
#include "cli.h"

#include <errno.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { BATCH = 65536, LONGEST_LINE = 1000, CHUNK = 1 << 20 };

typedef struct sampler {
    const pith_solid **solids;  /* [solid_count] the first that has something at a point answers */
    size_t solid_count;
    uint32_t channels;          /* the most of any solid; what one has not is 0 */
    int in;                     /* descriptor: what is not there yet must not be waited for with answers held back */
    const char *name;           /* of the input, for messages */
    pith_vec3 *points, *normals;
    float *colours;
    pith_vec3 *open_points, *open_normals; /* of the points that no solid has answered yet, */
    uint32_t *open;                         /* which they are, */
    float *answers;                         /* and what the next solid says */
    char *chunk;                /* [CHUNK] input that was read, */
    size_t begin, end;          /* and what of it is not used yet */
    bool ended;
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

/* ---- answers ----------------------------------------------------------------------------------------------------- */

/* One solid about the points still open; those it has something at are taken off. */
static pith_status ask_one(sampler *s, const pith_solid *solid, bool with_normals, size_t *open, pith_error *err)
{
    const uint32_t channels = pith_solid_channels(solid);
    const pith_query query = { .points = s->open_points,
                               .normals = with_normals ? s->open_normals : NULL,
                               .count = *open };
    PITH_TRY(pith_solid_sample(solid, &query, s->answers, err));
    size_t left = 0;
    for (size_t i = 0; i < *open; ++i) {
        const float *answer = s->answers + i * channels;
        if (answer[3] > 0.0f || s->solid_count == 1) {
            memcpy(s->colours + (size_t)s->open[i] * s->channels, answer, channels * sizeof *answer);
            continue;
        }
        s->open[left] = s->open[i];
        s->open_points[left] = s->open_points[i];
        s->open_normals[left++] = s->open_normals[i];
    }
    *open = left;
    return PITH_OK;
}

/* The colours of points first … first + count. */
static pith_status ask(sampler *s, size_t first, size_t count, bool with_normals, pith_error *err)
{
    memset(s->colours, 0, count * s->channels * sizeof *s->colours);
    memcpy(s->open_points, s->points + first, count * sizeof *s->points);
    memcpy(s->open_normals, s->normals + first, count * sizeof *s->normals);
    for (size_t i = 0; i < count; ++i) s->open[i] = (uint32_t)i;
    size_t open = count;
    for (size_t k = 0; k < s->solid_count && open; ++k)
        PITH_TRY(ask_one(s, s->solids[k], with_normals, &open, err));
    return PITH_OK;
}

/* Prints the answers to some points of the batch. */
static pith_status answer_lines(sampler *s, size_t first, size_t count, bool with_normals, pith_error *err)
{
    PITH_TRY(ask(s, first, count, with_normals, err));
    for (size_t i = 0; i < count; ++i)
        for (uint32_t c = 0; c < s->channels; ++c)
            printf("%.9g%c", (double)s->colours[i * s->channels + c], c + 1 < s->channels ? ' ' : '\n');
    return PITH_OK;
}

/* ---- input ------------------------------------------------------------------------------------------------------- */

/* Reads what there is behind what is not used yet; waits until there is something. */
static pith_status read_more(sampler *s, pith_error *err)
{
    memmove(s->chunk, s->chunk + s->begin, s->end - s->begin);
    s->end -= s->begin;
    s->begin = 0;
    ssize_t got;
    do got = read(s->in, s->chunk + s->end, CHUNK - s->end);
    while (got < 0 && errno == EINTR);
    if (got < 0) return pith_fail(err, PITH_IO, "%s: cannot be read: %s", s->name, strerror(errno));
    s->ended = got == 0;
    s->end += (size_t)got;
    return PITH_OK;
}

/* Does the input pause? Then whoever writes it may be waiting for an answer. */
static bool pauses(const sampler *s)
{
    struct pollfd at = { .fd = s->in, .events = POLLIN };
    return !s->ended && poll(&at, 1, 0) == 0;
}

/* The next line, ended by a zero; NULL when there is no whole one yet, or no more. */
static char *next_line(sampler *s, size_t *length)
{
    char *from = s->chunk + s->begin, *newline = memchr(from, '\n', s->end - s->begin);
    if (!newline && (!s->ended || s->begin == s->end)) return NULL;
    *length = newline ? (size_t)(newline - from) : s->end - s->begin;
    from[*length] = 0; /* the chunk has room for one more */
    s->begin += *length + (newline != NULL);
    return from;
}

/* One line more in the batch of `count`. */
static pith_status take_line(sampler *s, size_t number, size_t *count, char *text, size_t length, pith_error *err)
{
    if (length > LONGEST_LINE - 2)
        return pith_fail(err, PITH_BAD_FILE, "%s: line %zu is longer than %d letters", s->name, number,
                         LONGEST_LINE - 2);
    const size_t blank = strspn(text, " \t\r\n");
    if (blank == length || text[blank] == '#') return PITH_OK;
    if (strlen(text) != length || !read_line(text, &s->points[*count], &s->normals[*count]))
        return pith_fail(err, PITH_BAD_FILE, "%s: line %zu: expected \"x y z\" or \"x y z nx ny nz\"", s->name, number);
    if (pith_length(s->normals[*count]) > 0.0) s->normals[*count] = pith_unit(s->normals[*count]);
    ++*count;
    return PITH_OK;
}

/* Answers the batch, runs of points with and without normals apart: what a point is told must not hang on its
   neighbours. */
static pith_status answer_batch(sampler *s, size_t *count, pith_error *err)
{
    for (size_t first = 0, end; first < *count; first = end) {
        const bool with_normals = pith_length(s->normals[first]) > 0.0;
        for (end = first + 1; end < *count && (pith_length(s->normals[end]) > 0.0) == with_normals;) ++end;
        PITH_TRY(answer_lines(s, first, end - first, with_normals, err));
    }
    *count = 0;
    fflush(stdout); /* nobody waits for answers longer */
    return PITH_OK;
}

/* Lines are answered in large batches while they come fast, and at once when they pause. What stands before a line that
   is no point is answered, too. */
static pith_status sample_lines(sampler *s, pith_error *err)
{
    size_t number = 0, count = 0, length;
    pith_status status = PITH_OK;
    while (status == PITH_OK && !s->ended) {
        PITH_TRY(read_more(s, err));
        for (char *text; status == PITH_OK && (text = next_line(s, &length));) {
            status = take_line(s, ++number, &count, text, length, err);
            if (count == BATCH) PITH_TRY(answer_batch(s, &count, err));
        }
        if (status == PITH_OK && s->end - s->begin >= LONGEST_LINE)
            status = take_line(s, number + 1, &count, s->chunk, LONGEST_LINE, err);
        if (status == PITH_OK && (s->ended || pauses(s))) PITH_TRY(answer_batch(s, &count, err));
    }
    if (status != PITH_OK) answer_batch(s, &count, NULL);
    return status;
}

static pith_status answer_binary(sampler *s, size_t count, pith_error *err)
{
    memcpy(s->points, s->chunk + s->begin, count * sizeof *s->points);
    s->begin += count * sizeof *s->points;
    for (size_t i = 0; i < count; ++i)
        if (!pith_finite(s->points[i])) return pith_fail(err, PITH_BAD_FILE, "%s: a point is not finite", s->name);
    PITH_TRY(ask(s, 0, count, false, err));
    if (fwrite(s->colours, sizeof(float) * s->channels, count, stdout) != count || fflush(stdout) != 0)
        return pith_fail(err, PITH_IO, "the standard output cannot be written: %s", strerror(errno));
    return PITH_OK;
}

static pith_status sample_binary(sampler *s, pith_error *err)
{
    while (!s->ended) {
        PITH_TRY(read_more(s, err));
        if (!s->ended && s->end < CHUNK && !pauses(s)) continue; /* a fuller batch costs nobody's patience */
        for (size_t whole; (whole = (s->end - s->begin) / sizeof *s->points) > 0;)
            PITH_TRY(answer_binary(s, whole < BATCH ? whole : BATCH, err));
    }
    if (s->end > s->begin)
        return pith_fail(err, PITH_BAD_FILE, "%s: ends in the middle of a point; expected triples of 64-bit floats",
                         s->name);
    return PITH_OK;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

/* The solids of the body asked for, or of all. */
static pith_status find_solids(const cli_model *opened, pith_model *body, sampler *s, pith_error *err)
{
    const size_t count = body ? 1 : pith_model_bodies(opened->model);
    s->solids = pith_alloc(count, sizeof *s->solids);
    if (!s->solids) return PITH_OUT_OF_MEMORY(err, "solids");
    for (size_t i = 0; i < count; ++i) {
        pith_model *from = body;
        if (!from) PITH_TRY(pith_model_body(opened->model, i, &from, err));
        PITH_TRY(pith_model_solid(from, &s->solids[i], err));
        const uint32_t channels = pith_solid_channels(s->solids[i]);
        if (channels > s->channels) s->channels = channels;
    }
    s->solid_count = count;
    return PITH_OK;
}

static pith_status run(const cli_model *opened, pith_model *body, int in, const char *name, bool binary,
                       pith_error *err)
{
    sampler s = { .in = in, .name = name };
    pith_status status = find_solids(opened, body, &s, err);
    cli_progress_done();
    if (status == PITH_OK) {
        s.points = pith_alloc(BATCH, sizeof *s.points);
        s.normals = pith_alloc(BATCH, sizeof *s.normals);
        s.open_points = pith_alloc(BATCH, sizeof *s.open_points);
        s.open_normals = pith_alloc(BATCH, sizeof *s.open_normals);
        s.open = pith_alloc(BATCH, sizeof *s.open);
        s.colours = pith_alloc((size_t)BATCH * s.channels, sizeof *s.colours);
        s.answers = pith_alloc((size_t)BATCH * s.channels, sizeof *s.answers);
        s.chunk = pith_alloc(CHUNK + 1, 1);
        if (!s.points || !s.normals || !s.open_points || !s.open_normals || !s.open || !s.colours || !s.answers ||
            !s.chunk)
            status = PITH_OUT_OF_MEMORY(err, "points");
    }
    if (status == PITH_OK) status = binary ? sample_binary(&s, err) : sample_lines(&s, err);
    pith_free(s.solids);
    pith_free(s.points);
    pith_free(s.normals);
    pith_free(s.open_points);
    pith_free(s.open_normals);
    pith_free(s.open);
    pith_free(s.colours);
    pith_free(s.answers);
    pith_free(s.chunk);
    return status;
}

int verb_sample(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    bool binary = false;
    const char *name = NULL;
    const cli_flag flags[] = {
        { "body", 0, CLI_TEXT, &name, "NAME",
          "of several bodies only this one; default: the first that has something at "
          "the point",
          0, 0, NULL },
        { "binary", 0, CLI_SWITCH, &binary, NULL, "64-bit float triples in, 32-bit float tuples out, nothing between",
          0, 0, NULL },
        CLI_THREADS_FLAG(common),
        CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "sample",
        .words = "DOCUMENT [FILE|-]",
        .least_words = 1,
        .most_words = 2,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary =
            "Reads points, one \"x y z [nx ny nz]\" a line, and prints the solid there, one \"r g b a ...\" a line:\n"
            "linear RGB, opacity, further channels. Outside the shape all are 0. Empty lines and lines that\n"
            "begin with # are skipped. Without FILE, or with -, reads the standard input, and answers as soon as\n"
            "the input pauses, so that another program can talk with it.",
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
        pith_model *body = NULL;
        if (name) result = cli_choose_body("sample", &opened, name, &body);
        if (result == CLI_GO_ON) {
            const char *input = from_file ? line.word[1] : "standard input";
            const pith_status status = run(&opened, body, fileno(in), input, binary, &err);
            const int written = cli_finish_output("sample");
            result = status != PITH_OK ? cli_fail("sample", &err) : written;
        }
        cli_close(&opened);
    }
    if (from_file) fclose(in);
    return result;
}
