/* pith surfaces: the surfaces that colours flow between, as a list and as a file. */
#include "cli.h"

#include "pith/diffusion_files.h"

/* What there is to say of one. */
static pith_status surface_row(const pith_diffusion_surface *surface, json_t *report, pith_error *err)
{
    pith_mesh *mesh = NULL;
    pith_mesh_report measured;
    PITH_TRY(pith_mesh_create(&surface->mesh, &mesh, err));
    const pith_status status = pith_mesh_measure(mesh, &measured, err);
    pith_mesh_destroy(mesh);
    PITH_TRY(status);
    double blur = 0.0;
    for (uint32_t v = 0; surface->blur && v < surface->mesh.vertex_count; ++v) blur = fmax(blur, surface->blur[v]);
    json_array_append_new(report, json_pack("{ss si si si sb sb sf sf ss}", "name", surface->name, "vertices",
                                            (int)measured.vertices, "triangles", (int)measured.triangles, "components",
                                            (int)measured.components, "closed", measured.closed, "two_sided",
                                            surface->back != NULL, "area", measured.area, "blur", blur, "hidden",
                                            surface->hide_front ? "front" : surface->hide_back ? "back" : "none"));
    return PITH_OK;
}

static pith_status look(pith_model *body, const char *out, json_t *report, pith_error *err)
{
    const pith_diffusion_surface *surfaces;
    size_t count;
    PITH_TRY(pith_model_surfaces(body, &surfaces, &count, err));
    for (size_t i = 0; i < count; ++i) PITH_TRY(surface_row(&surfaces[i], report, err));
    return out ? pith_diffusion_surfaces_write(surfaces, count, out, err) : PITH_OK;
}

static void print_report(const json_t *report)
{
    size_t i;
    json_t *row;
    json_array_foreach((json_t *)report, i, row) {
        const double blur = json_real_value(json_object_get(row, "blur"));
        const char *hidden = json_string_value(json_object_get(row, "hidden"));
        printf("%-16s %7d vertices %7d triangles  %s, %s", json_string_value(json_object_get(row, "name")),
               (int)json_integer_value(json_object_get(row, "vertices")),
               (int)json_integer_value(json_object_get(row, "triangles")),
               json_is_true(json_object_get(row, "closed")) ? "closed" : "open",
               json_is_true(json_object_get(row, "two_sided")) ? "two colours" : "one colour");
        if (blur > 0.0) printf(", blur up to %.4g", blur);
        if (hidden[0] != 'n') printf(", %s hidden", hidden);
        printf("\n");
    }
}

int verb_surfaces(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *name = NULL;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", ".glb, or .ply for a single one: with colours and blur at vertices", 0, 0,
          NULL },
        { "body", 0, CLI_TEXT, &name, "NAME", "whose, of several bodies", 0, 0, NULL },
        CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common),
    };
    cli_line line = {
        .verb = "surfaces", .words = "DOCUMENT", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Makes the surfaces that a body's colours flow between, as its sketch, curves, paint and grains say,\n"
                   "and lists them. With -o they are written as meshes that other programs can open and change: the\n"
                   "colours of either side and the blur are attributes of their vertices, and a surface of kind \"file\"\n"
                   "reads them again.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (out && !pith_path_has_extension(out, "glb") && !pith_path_has_extension(out, "ply"))
        return cli_misuse("surfaces", "expected -o FILE ending in .glb or .ply, got %s", out);
    if (out && cli_check_out("surfaces", out) != CLI_GO_ON) return EXIT_FAILED;
    cli_model opened;
    pith_model *body = NULL;
    pith_error err;
    common.no_cache = true;
    code = cli_open("surfaces", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    code = cli_choose_body("surfaces", &opened, name, &body);
    json_t *report = json_array();
    if (code == CLI_GO_ON && look(body, out, report, &err) != PITH_OK) code = cli_fail("surfaces", &err);
    if (code == CLI_GO_ON && common.json) {
        code = cli_print_json(json_incref(report));
    } else if (code == CLI_GO_ON) {
        cli_progress_done();
        print_report(report);
        code = cli_finish_output("surfaces");
    }
    json_decref(report);
    cli_close(&opened);
    return code;
}
