/* pith bench: the table of benches, and the three ways their cases are printed. */
#include "bench.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef struct bench { const char *name, *help; bench_run *run; } bench;

static const bench benches[] = {
    { "lapped", "meshing, fields, fill, cut, saved size and sampling of the shipped models", bench_lapped },
    { "fields", "RBF solves and evaluation, Laplacian smoothing", bench_fields },
    { "render", "pictures of the shipped kiwi", bench_render },
    { "cut", "cuts and splits along planes and strokes, bodies", bench_cut },
    { "layers", "the patches over each triangle of a kiwi's section and skin, for composers", bench_layers },
    { "blend", "contrast where patches overlap, and what keeping it costs", bench_blend },
    { "volume", "translucent pictures of a fibrous tube", bench_volume },
    { "procedural", "noise and the functions on it: points per second on one core", bench_procedural },
    { "atlas", "texture atlases of shipped models: texels a second, charts, use of the atlas", bench_atlas },
    { "lines", "lines over pictures of shipped models, beside the pictures", bench_lines },
    { "diffusion", "colours between surfaces, by rays and by walks: points per second and errors", bench_diffusion },
    { "sketch_surface", "grains, painting and erasing: seconds over sizes", bench_sketch_surface },
    { "methods", "the three ways colours flow between surfaces: times, memory, and how far apart they are", bench_methods },
    { "sketch", "surfaces swept from curves, curves checked and dragged, random variations", bench_sketch },
};
enum { BENCH_COUNT = sizeof benches / sizeof *benches };

/* ---- times and memory --------------------------------------------------------------------------------------------------- */

void bench_add(bench_times *times, double seconds)
{
    if (times->count < 64) times->seconds[times->count++] = seconds;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double bench_median(const bench_times *times)
{
    bench_times sorted = *times;
    qsort(sorted.seconds, (size_t)sorted.count, sizeof *sorted.seconds, by_value);
    const int half = sorted.count / 2;
    return sorted.count % 2 ? sorted.seconds[half] : 0.5 * (sorted.seconds[half - 1] + sorted.seconds[half]);
}

double bench_min(const bench_times *times)
{
    double least = INFINITY;
    for (int i = 0; i < times->count; ++i) least = fmin(least, times->seconds[i]);
    return least;
}

pith_status bench_load(const char *path, void (*change)(json_t *root, const void *user), const void *user,
                       pith_document **document, pith_error *err)
{
    json_error_t problem;
    json_t *root = json_load_file(path, 0, &problem);
    if (!root) return pith_fail(err, PITH_BAD_FILE, "%s: line %d: %s", path, problem.line, problem.text);
    change(root, user);
    char *text = json_dumps(root, 0);
    json_decref(root);
    if (!text) return pith_fail(err, PITH_NO_MEMORY, "out of memory for a document");
    const pith_status status = pith_document_parse(path, text, strlen(text), document, err);
    free(text);
    return status;
}

void bench_reset_peak(void)
{
    FILE *file = fopen("/proc/self/clear_refs", "w");
    if (!file) return;
    fputs("5", file);
    fclose(file);
}

double bench_peak(void)
{
    FILE *file = fopen("/proc/self/status", "r");
    double kib = 0;
    for (char text[200]; file && fgets(text, sizeof text, file);)
        if (sscanf(text, "VmHWM: %lf kB", &kib) == 1) break;
    if (file) fclose(file);
    return kib > 0 ? 1024 * kib : (double)pith_memory_peak();
}

static json_t *machine(void)
{
    char processor[200] = "unknown";
    FILE *file = fopen("/proc/cpuinfo", "r");
    for (char text[300]; file && fgets(text, sizeof text, file);)
        if (strncmp(text, "model name", 10) == 0) {
            const char *colon = strchr(text, ':');
            if (colon) snprintf(processor, sizeof processor, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    if (file) fclose(file);
    return json_pack("{ss si si ss ss}", "processor", processor, "processors", (int)sysconf(_SC_NPROCESSORS_ONLN), "threads",
                     pith_threads(), "compiler", __VERSION__, "pith", PITH_VERSION_TEXT);
}

/* ---- printing ------------------------------------------------------------------------------------------------------------ */

static void print_value(const json_t *value)
{
    if (json_is_string(value)) printf("%s", json_string_value(value));
    else printf("%.6g", json_number_value(value));
}

static void print_csv(const json_t *cases)
{
    size_t i;
    json_t *one, *value;
    const char *name;
    json_array_foreach((json_t *)cases, i, one) {
        if (i == 0) {
            size_t column = 0;
            json_object_foreach(one, name, value) printf("%s%s", column++ ? "," : "", name);
            printf("\n");
        }
        size_t column = 0;
        json_object_foreach(one, name, value) {
            if (column++) printf(",");
            print_value(value);
        }
        printf("\n");
    }
}

static void print_cases(const json_t *cases)
{
    size_t i;
    json_t *one, *value;
    const char *name;
    json_array_foreach((json_t *)cases, i, one) {
        printf("%s\n", json_string_value(json_object_get(one, "name")));
        json_object_foreach(one, name, value) {
            if (strcmp(name, "name") == 0) continue;
            printf("  %-34s ", name);
            print_value(value);
            printf("\n");
        }
    }
}

int verb_bench(int argc, char **argv)
{
    bench_options options = { .repeats = 5, .largest = 500000 };
    bool json = false, csv = false;
    int threads = 0;
    const cli_flag flags[] = {
        { "repeats", 'r', CLI_WHOLE, &options.repeats, "N", "timed runs after a warm-up; default 5", 1, 64, NULL },
        { "curve", 0, CLI_SWITCH, &options.curve, NULL, "lapped, cut: from 5 000 to 500 000 tetrahedra", 0, 0, NULL },
        { "largest", 0, CLI_WHOLE, &options.largest, "N", "lapped, cut: the curve stops at N tetrahedra", 5000, 500000, NULL },
        { "picture", 0, CLI_TEXT, &options.picture, "FILE", "methods: write sections side by side as PNG", 0, 0, NULL },
        { "threads", 0, CLI_WHOLE, &threads, "N", "threads to use", 1, 256, NULL },
        { "json", 0, CLI_SWITCH, &json, NULL, "print JSON", 0, 0, NULL },
        { "csv", 0, CLI_SWITCH, &csv, NULL, "print CSV, as kept in bench/results", 0, 0, NULL },
    };
    cli_line line = {
        .verb = "bench", .words = "lapped|fields|render|cut|layers|blend|volume|procedural|atlas|lines|diffusion|sketch_surface|methods|sketch",
        .least_words = 1, .most_words = 1,
        .flags = flags, .flag_count = sizeof flags / sizeof *flags,
        .summary = "Measures. Each case has times (least and median of repeated runs), a figure of quality beside them, and\n"
                   "the largest memory.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    const char *names[BENCH_COUNT + 1] = { NULL };
    const bench *chosen = NULL;
    for (int i = 0; i < BENCH_COUNT; ++i) {
        names[i] = benches[i].name;
        if (strcmp(line.word[0], benches[i].name) == 0) chosen = &benches[i];
    }
    if (!chosen) {
        const char *near = pith_nearest_word(line.word[0], names);
        return cli_misuse("bench", "there is no bench \"%s\"%s%s%s", line.word[0], near ? "; did you mean \"" : "",
                          near ? near : "", near ? "\"?" : "");
    }
    if (threads > 0) pith_threads_set(threads);
    pith_error err;
    json_t *cases = json_array();
    if (chosen->run(&options, cases, &err) != PITH_OK) {
        json_decref(cases);
        return cli_fail("bench", &err);
    }
    cli_progress_done();
    if (json) return cli_print_json(json_pack("{ss so so}", "bench", chosen->name, "machine", machine(), "cases", cases));
    if (csv) print_csv(cases);
    else print_cases(cases);
    json_decref(cases);
    return cli_finish_output("bench");
}
