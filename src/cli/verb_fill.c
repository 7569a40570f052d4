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

static json_t *report_json(const cli_model *opened, const pith_tets_report *tets)
{
    const pith_model_times *t = pith_model_timing(opened->model);
    const pith_lapped_report *fill = pith_model_fill_report(opened->model);
    json_t *report = json_pack("{ss si sI}", "title", pith_document_title(opened->document), "tetrahedra",
                               (int)tets->tetrahedra, "saved_bytes", (json_int_t)pith_model_saved_size(opened->model));
    json_object_set_new(report, "seconds", json_pack("{sf sf sf sf sf}", "shape", t->shape, "tets", t->tets, "fields",
                                                     t->fields, "exemplar", t->exemplar, "fill", t->fill));
    if (fill)
        json_object_set_new(report, "fill",
                            json_pack("{si si sf sf sf sf sI}", "patches", (int)fill->patches, "regrown",
                                      (int)fill->regrown, "overlap", fill->overlap, "clump", fill->clump,
                                      "angle_mean_degrees", fill->angle_mean, "angle_95_degrees", fill->angle_95,
                                      "solid_bytes", (json_int_t)fill->bytes));
    return report;
}

int verb_fill(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const cli_flag flags[] = { CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common) };
    cli_line line = {
        .verb = "fill", .words = "DOCUMENT", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Builds what the document describes (tetrahedra, fields, exemplar, solid), saves it beside the\n"
                   "document (kiwi.pith -> kiwi.pithc), and reports. What is saved and still fits is not built again.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    cli_model opened;
    const int open = cli_open("fill", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;

    pith_error err;
    const pith_tets_report *tets;
    pith_status status = pith_model_solid(opened.model, NULL, &err);
    if (status == PITH_OK) status = pith_model_tets(opened.model, NULL, &tets, &err);
    int result = EXIT_DONE;
    if (status != PITH_OK) {
        result = cli_fail("fill", &err);
    } else if (common.json) {
        result = cli_print_json(report_json(&opened, tets));
    } else {
        cli_progress_done();
        print_report(&opened, tets);
        result = cli_finish_output("fill");
    }
    cli_close(&opened);
    return result;
}
