/* pith bench layers: the patches over each triangle of what a cut lays open and of the skin beside it, which stand
   between a cutting stroke and its picture where the picture is composed on a graphics card (Takayama et al. 2008 §5.1:
   10 to 20 layers a triangle). */
#include "bench.h"

#include <string.h>

/* The triangles of one kind of a shell. */
typedef struct triangles { uint32_t *tets; double (*weights)[3][4]; size_t count; } triangles;

static pith_status triangles_of(const pith_shell *shell, pith_face_kind kind, triangles *of, pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    double(*weights)[3][4] = pith_alloc(view.triangle_count, sizeof *weights);
    of->tets = pith_alloc(view.triangle_count, sizeof *of->tets);
    of->weights = pith_alloc(view.triangle_count, sizeof *of->weights);
    of->count = 0;
    if (!weights || !of->tets || !of->weights) {
        pith_free(weights);
        return pith_fail(err, PITH_NO_MEMORY, "out of memory for triangles");
    }
    pith_shell_weights(shell, weights);
    for (uint32_t i = 0; i < view.triangle_count; ++i) {
        if (view.kinds[i] != kind) continue;
        memcpy(of->weights[of->count], weights[i], sizeof weights[i]);
        of->tets[of->count++] = view.source_tet[i];
    }
    pith_free(weights);
    return PITH_OK;
}

static pith_status time_layers(const pith_solid *solid, const triangles *of, int repeats, json_t *row, pith_error *err)
{
    uint32_t *start = pith_alloc(of->count + 1, sizeof *start);
    if (!start) return pith_fail(err, PITH_NO_MEMORY, "out of memory for triangles");
    pith_lapped_layer *layers = NULL;
    pith_status status = PITH_OK;
    const int all = pith_threads();
    static const char *const names[2] = { "layers_1_thread_ms", "layers_all_threads_ms" };
    double least = 0;
    for (int many = 0; status == PITH_OK && many < 2; ++many) {
        bench_times times = { .count = 0 };
        pith_threads_set(many ? all : 1);
        for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
            pith_free(layers);
            layers = NULL;
            const double begin = pith_seconds();
            status = pith_lapped_layers(solid, of->tets, (const double(*)[3][4])of->weights, of->count, start, &layers,
                                        err);
            if (i > 0) bench_add(&times, pith_seconds() - begin);
        }
        if (!many) least = bench_min(&times);
        json_object_set_new(row, names[many], json_real(1e3 * bench_min(&times)));
    }
    pith_threads_set(all);
    if (status == PITH_OK) {
        const double count = (double)of->count, total = start[of->count];
        double spare = 0;
        for (size_t i = 0; i < start[of->count]; ++i) spare += layers[i].role == PITH_LAYER_SPARE;
        json_object_set_new(row, "layers_1_thread_ms_per_10000", json_real(1e7 * least / count));
        json_object_set_new(row, "triangles", json_integer((json_int_t)of->count));
        json_object_set_new(row, "layers_per_triangle", json_real((total - spare) / count));
        json_object_set_new(row, "spare_per_triangle", json_real(spare / count));
        json_object_set_new(row, "layers_bytes", json_real(total * sizeof *layers + (count + 1) * sizeof *start));
    }
    pith_free(layers);
    pith_free(start);
    return status;
}

static pith_status measure_half(const char *name, const pith_solid *solid, const pith_shell *half, int repeats,
                                json_t *cases, pith_error *err)
{
    static const char *const kinds[2] = { "skin", "section" };
    pith_status status = PITH_OK;
    for (int kind = PITH_SKIN; status == PITH_OK && kind <= PITH_SECTION; ++kind) {
        char title[100];
        snprintf(title, sizeof title, "%s, %s", name, kinds[kind]);
        json_t *row = json_pack("{ss}", "name", title);
        triangles of = { .count = 0 };
        status = triangles_of(half, kind, &of, err);
        if (status == PITH_OK) status = time_layers(solid, &of, repeats, row, err);
        pith_free(of.tets), pith_free(of.weights);
        if (status == PITH_OK) json_array_append(cases, row);
        json_decref(row);
    }
    return status;
}

/* A kiwi cut lengthwise, the cut off every vertex. */
static pith_status run_kiwi(const char *name, const char *path, bench_fineness as, const bench_options *options,
                            json_t *cases, pith_error *err)
{
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_solid *solid = NULL;
    const pith_part *part = NULL;
    pith_shell *half = NULL;
    double *values = NULL;
    PITH_TRY(bench_load(path, bench_set_fineness, &as, &document, err));
    pith_status status = pith_model_create(document, NULL, NULL, &model, err);
    if (status == PITH_OK) status = pith_model_solid(model, &solid, err);
    if (status == PITH_OK) status = pith_model_part(model, &part, err);
    if (status == PITH_OK) {
        const pith_plane plane = { { 0.013, 0.021, 0.0 }, { 1.0, 0.1, 0.07 } };
        values = pith_alloc(pith_part_look(part).vertex_count, sizeof *values);
        status = values ? pith_part_plane_values(part, &plane, values, err)
                        : pith_fail(err, PITH_NO_MEMORY, "out of memory for a cut");
    }
    if (status == PITH_OK) status = pith_part_cut(part, values, &half, NULL, err);
    if (status == PITH_OK) status = measure_half(name, solid, half, options->repeats, cases, err);
    pith_shell_destroy(half);
    pith_free(values);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

pith_status bench_layers(const bench_options *options, json_t *cases, pith_error *err)
{
    static const bench_fineness sizes[] = { { 5000, 4 }, { 200000, 5 } };
    char path[1000], name[60];
    if (!cli_find_example("kiwi.pith", path, sizeof path))
        return pith_fail(err, PITH_IO, "the example kiwi.pith is not beside the program nor where its source was");
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; ++i) {
        snprintf(name, sizeof name, "kiwi at %d", sizes[i].tetrahedra);
        PITH_TRY(run_kiwi(name, path, sizes[i], options, cases, err));
    }
    return PITH_OK;
}
