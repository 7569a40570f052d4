/* pith cut: the cut halves as meshes with a colour at every vertex. */
#include "cli.h"

#include <string.h>

typedef struct cut_flags {
    const char *out, *format;
    double edge;
    int max_triangles;
    bool watertight;
} cut_flags;

/* Writes one shell; its measures go into the report. */
static pith_status write_shell(const pith_render_item *item, const cut_flags *asked, const char *path, json_t *report,
                               pith_error *err)
{
    pith_mesh *mesh = NULL;
    PITH_TRY(pith_bake_vertices(item->shell, item->solid, asked->edge, (uint32_t)asked->max_triangles,
                                !asked->watertight, cli_progress(), &mesh, err));
    const pith_status status = pith_mesh_write(mesh, path, err);
    const pith_mesh_view view = pith_mesh_look(mesh);
    double skin, section, volume;
    pith_shell_measure(item->shell, &skin, &section, &volume);
    json_array_append_new(report, json_pack("{ss si si sf sf sf}", "file", path, "vertices", (int)view.vertex_count,
                                            "triangles", (int)view.triangle_count, "skin_area", skin, "section_area",
                                            section, "volume", volume));
    pith_mesh_destroy(mesh);
    return status;
}

static pith_status write_all(const cli_model *opened, const cut_flags *asked, const char *base, json_t *report,
                             pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    PITH_TRY(pith_model_items(opened->model, &items, &count, err));
    for (size_t i = 0; i < count; ++i) {
        char path[1000];
        snprintf(path, sizeof path, "%s-%zu.%s", base, i + 1, asked->format);
        PITH_TRY(write_shell(&items[i], asked, path, report, err));
    }
    return PITH_OK;
}

static void print_report(const json_t *report)
{
    size_t i;
    json_t *row;
    json_array_foreach((json_t *)report, i, row)
        printf("%s: %d triangles, section %.6g, volume %.6g\n", json_string_value(json_object_get(row, "file")),
               (int)json_integer_value(json_object_get(row, "triangles")),
               json_real_value(json_object_get(row, "section_area")), json_real_value(json_object_get(row, "volume")));
}

int verb_cut(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    cut_flags asked = { .format = "glb", .max_triangles = 2000000 };
    pith_cut_step cut;
    pith_params_defaults(&pith_cut_step_params, &cut);
    bool has_plane = false;
    const cli_flag flags[] = {
        { "plane", 0, CLI_PLANE, &cut.plane, "PX,..,NZ", "point and normal of the cut; default: the document's cuts", 0, 0,
          &has_plane },
        { "out", 'o', CLI_TEXT, &asked.out, "BASE", "files are BASE-1.glb, BASE-2.glb, …; default: the document's name",
          0, 0, NULL },
        { "format", 0, CLI_TEXT, &asked.format, "glb|ply|obj", "kind of file; default glb", 0, 0, NULL },
        { "edge", 0, CLI_NUMBER, &asked.edge, "X", "divide triangles until no edge is longer; 0: as cut", 0, 1e300, NULL },
        { "max-triangles", 0, CLI_WHOLE, &asked.max_triangles, "N", "refuse to make more than this a half", 1, 1e9, NULL },
        { "watertight", 0, CLI_SWITCH, &asked.watertight, NULL, "skin and section share the vertices of their border", 0,
          0, NULL },
        CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "cut", .words = "DOCUMENT", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags, .params = &pith_cut_step_params,
        .summary = "Cuts the model along a plane and writes what is left as meshes coloured by the solid, first the side\n"
                   "the normal points away from. A colour sits at every vertex: --edge sets how fine the picture on the\n"
                   "section becomes.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (strcmp(asked.format, "glb") != 0 && strcmp(asked.format, "ply") != 0 && strcmp(asked.format, "obj") != 0)
        return cli_misuse("cut", "--format is \"%s\", expected glb, ply or obj", asked.format);
    cli_apply_params(&line, &cut);
    cli_model opened;
    const int open = cli_open("cut", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;

    char base[800];
    const size_t length = strlen(line.word[0]);
    const size_t stem = pith_path_has_extension(line.word[0], "pith") ? length - 5 : length;
    snprintf(base, sizeof base, "%.*s", (int)(asked.out ? strlen(asked.out) : stem), asked.out ? asked.out : line.word[0]);
    pith_error err;
    json_t *report = json_array();
    pith_status status = has_plane ? pith_model_set_cuts(opened.model, &cut, 1, &err) : PITH_OK;
    if (status == PITH_OK) status = write_all(&opened, &asked, base, report, &err);
    int result;
    if (status != PITH_OK) {
        result = cli_fail("cut", &err);
    } else if (common.json) {
        const double seconds = pith_model_timing(opened.model)->cut;
        result = cli_print_json(json_pack("{sf sO}", "cut_seconds", seconds, "files", report));
    } else {
        cli_progress_done();
        print_report(report);
        result = cli_finish_output("cut");
    }
    json_decref(report);
    cli_close(&opened);
    return result;
}
