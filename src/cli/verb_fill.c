/* pith fill: builds the model a document describes and saves it beside the document. */
#include "cli.h"

static void print_seconds(const char *what, double seconds)
{
    if (seconds >= 0) printf("  %-22s %.3f s\n", what, seconds);
    else printf("  %-22s from the saved model\n", what);
}

static void print_report(const cli_model *opened, const pith_tets_report *tets)
{
    const pith_model_times *times = pith_model_timing(opened->model);
    const pith_lapped_report *fill = pith_model_fill_report(opened->model);
    printf("%s\n", pith_document_title(opened->document));
    printf("  %-22s %u\n", "tetrahedra", tets->tetrahedra);
    if (fill) {
        printf("  %-22s %u (%u rounds of re-growing)\n", "patches", fill->patches, fill->regrown);
        printf("  %-22s %.1f tetrahedra\n", "patch size", fill->clump);
        printf("  %-22s %.2f patches visible in a tetrahedron\n", "overlap", fill->overlap);
        printf("  %-22s %.1f degrees mean, %.1f at 95 %%\n", "axes off the frame", fill->angle_mean, fill->angle_95);
        printf("  %-22s %.1f MB in memory\n", "solid", 1e-6 * (double)fill->bytes);
    }
    if (times->shape >= 0) print_seconds("shape", times->shape);
    print_seconds("tetrahedralising", times->tets);
    if (fill) print_seconds("fields", times->fields);
    if (fill) print_seconds("exemplar", times->exemplar);
    if (fill) print_seconds("fill", times->fill);
    const size_t saved = pith_model_saved_size(opened->model);
    if (saved) printf("  %-22s %.2f MB\n", "saved model", 1e-6 * (double)saved);
}

static json_t *seconds_json(const pith_model_times *t)
{
    return json_pack("{sf sf sf sf sf}", "shape", t->shape, "tets", t->tets, "fields", t->fields, "exemplar",
                     t->exemplar, "fill", t->fill);
}

static json_t *fill_json(const pith_lapped_report *fill)
{
    return json_pack("{si si si sf sf sf sf sI}", "patches", (int)fill->patches, "regrown", (int)fill->regrown,
                     "pastes", (int)fill->pastes, "overlap", fill->overlap, "clump", fill->clump, "angle_mean_degrees",
                     fill->angle_mean, "angle_95_degrees", fill->angle_95, "solid_bytes", (json_int_t)fill->bytes);
}

static json_t *report_json(const cli_model *opened, const pith_tets_report *tets)
{
    const pith_lapped_report *fill = pith_model_fill_report(opened->model);
    json_t *report = json_pack("{ss si sI}", "title", pith_document_title(opened->document), "tetrahedra",
                               (int)tets->tetrahedra, "saved_bytes", (json_int_t)pith_model_saved_size(opened->model));
    json_object_set_new(report, "seconds", seconds_json(pith_model_timing(opened->model)));
    if (fill) json_object_set_new(report, "fill", fill_json(fill));
    return report;
}

/* ---- several bodies ---------------------------------------------------------------------------------------------- */

/* Seconds of one body, "saved" where nothing had to be built. */
static void print_column(double seconds)
{
    if (seconds >= 0) printf(" %9.3f", seconds);
    else printf(" %9s", "saved");
}

static void print_bodies(const cli_model *opened, json_t *bodies)
{
    size_t i;
    json_t *body;
    printf("%s\n  %-24s %10s %8s %8s %9s %9s %9s %9s\n", pith_document_title(opened->document), "body", "tetrahedra",
           "patches", "overlap", "meshing", "fields", "exemplar", "fill");
    json_array_foreach(bodies, i, body) {
        const json_t *fill = json_object_get(body, "fill"), *seconds = json_object_get(body, "seconds");
        printf("  %-24s %10d", json_string_value(json_object_get(body, "name")),
               (int)json_integer_value(json_object_get(body, "tetrahedra")));
        if (fill) printf(" %8d %8.2f", (int)json_integer_value(json_object_get(fill, "patches")),
                         json_real_value(json_object_get(fill, "overlap")));
        else printf(" %8s %8s", "-", "-");
        static const char *const stages[] = { "tets", "fields", "exemplar", "fill" };
        for (int k = 0; k < 4; ++k) print_column(json_real_value(json_object_get(seconds, stages[k])));
        printf("\n");
    }
    const size_t saved = pith_model_saved_size(opened->model);
    if (saved) printf("  saved model: %.2f MB\n", 1e-6 * (double)saved);
}

/* Fills all bodies, one after the other. */
static pith_status fill_bodies(const cli_model *opened, json_t *bodies, pith_error *err)
{
    for (size_t i = 0; i < pith_model_bodies(opened->model); ++i) {
        pith_model *body;
        const pith_tets_report *tets;
        PITH_TRY(pith_model_body(opened->model, i, &body, err));
        PITH_TRY(pith_model_solid(body, NULL, err));
        PITH_TRY(pith_model_tets(body, NULL, &tets, err));
        const pith_lapped_report *fill = pith_model_fill_report(body);
        json_t *row = json_pack("{ss si so}", "name", pith_document_body_name(opened->document, i), "tetrahedra",
                                (int)tets->tetrahedra, "seconds", seconds_json(pith_model_timing(body)));
        if (fill) json_object_set_new(row, "fill", fill_json(fill));
        json_array_append_new(bodies, row);
    }
    return PITH_OK;
}

static int run_bodies(const cli_model *opened, bool json)
{
    pith_error err;
    json_t *bodies = json_array();
    int result = EXIT_DONE;
    if (fill_bodies(opened, bodies, &err) != PITH_OK) {
        result = cli_fail("fill", &err);
    } else if (json) {
        result = cli_print_json(json_pack("{ss sI sO}", "title", pith_document_title(opened->document), "saved_bytes",
                                          (json_int_t)pith_model_saved_size(opened->model), "bodies", bodies));
    } else {
        cli_progress_done();
        print_bodies(opened, bodies);
        result = cli_finish_output("fill");
    }
    json_decref(bodies);
    return result;
}

static int run_one(const cli_model *opened, bool json)
{
    pith_error err;
    const pith_tets_report *tets;
    pith_status status = pith_model_solid(opened->model, NULL, &err);
    if (status == PITH_OK) status = pith_model_tets(opened->model, NULL, &tets, &err);
    if (status != PITH_OK) return cli_fail("fill", &err);
    if (json) return cli_print_json(report_json(opened, tets));
    cli_progress_done();
    print_report(opened, tets);
    return cli_finish_output("fill");
}

int verb_fill(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const cli_flag flags[] = { CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common) };
    cli_line line = {
        .verb = "fill",
        .words = "DOCUMENT",
        .least_words = 1,
        .most_words = 1,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary =
            "Builds what the document describes (tetrahedra, fields, exemplar, solid; of every body), saves it\n"
            "beside the document (kiwi.pith -> kiwi.pithc), and reports. What is saved and still fits is not built\n"
            "again.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    cli_model opened;
    const int open = cli_open("fill", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;
    const int result = pith_model_bodies(opened.model) > 1 ? run_bodies(&opened, common.json)
                                                           : run_one(&opened, common.json);
    cli_close(&opened);
    return result;
}
