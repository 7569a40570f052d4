/* pith cut: the pieces that a cut leaves as meshes with a colour at every vertex. */
#include "cli.h"

#include <ctype.h>
#include <string.h>

enum { STEM_ROOM = 1000 };

typedef struct cut_flags {
    const char *out, *format;
    double edge;
    int max_triangles;
    bool watertight;
    cli_cut cut;
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

/* ---- names ------------------------------------------------------------------------------------------------------- */

/* What comes before the number: BASE, or BASE-BODY where there are several bodies. */
static void stem_of(const cli_model *opened, const char *base, size_t body, char stem[STEM_ROOM])
{
    snprintf(stem, STEM_ROOM, "%s", base);
    if (pith_model_bodies(opened->model) < 2) return;
    const size_t length = strlen(stem);
    snprintf(stem + length, STEM_ROOM - length, "-%s", pith_document_body_name(opened->document, body));
    for (char *at = stem + length; *at; ++at) /* names may hold what file names should not */
        if (!isalnum((unsigned char)*at) && !strchr("-_.+", *at) && (unsigned char)*at < 128) *at = '_';
}

/* How many files of the report have this stem. */
static size_t written_of(const json_t *report, const char *stem)
{
    size_t i, same = 0;
    json_t *row;
    json_array_foreach((json_t *)report, i, row) {
        const char *file = json_string_value(json_object_get(row, "file")), *dash = strrchr(file, '-');
        same += (size_t)(dash - file) == strlen(stem) && strncmp(file, stem, strlen(stem)) == 0;
    }
    return same;
}

/* Files of an earlier run that this one did not write would be taken for its own. */
static void warn_of_stale(const json_t *report, const char *stem, const char *format)
{
    char path[STEM_ROOM + 40], list[2000] = "";
    /* Numbers were given one by one; a short gap is what somebody deleted. */
    for (size_t number = written_of(report, stem) + 1, missing = 0; missing < 16; ++number) {
        snprintf(path, sizeof path, "%s-%zu.%s", stem, number, format);
        if (!pith_file_exists(path)) {
            ++missing;
            continue;
        }
        if (strlen(list) + strlen(path) + 3 > sizeof list) break;
        if (list[0]) strcat(list, ", ");
        strcat(list, path);
    }
    if (list[0]) fprintf(stderr, "pith cut: left from an earlier run, and not part of this one: %s\n", list);
}

/* ---- files ------------------------------------------------------------------------------------------------------- */

static pith_status write_all(const cli_model *opened, const cut_flags *asked, const char *base, json_t *report,
                             pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    char stem[STEM_ROOM], path[STEM_ROOM + 40];
    PITH_TRY(pith_model_items(opened->model, &items, &count, err));
    if (count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "nothing is left of the model after the cuts; the plane or stroke misses "
                         "it, and the side that is kept is the empty one");
    for (size_t i = 0; i < count; ++i) {
        stem_of(opened, base, cli_body_of_solid(opened, items[i].solid), stem);
        snprintf(path, sizeof path, "%s-%zu.%s", stem, written_of(report, stem) + 1, asked->format);
        PITH_TRY(write_shell(&items[i], asked, path, report, err));
    }
    cli_progress_done();
    for (size_t body = 0; body < pith_model_bodies(opened->model); ++body) {
        stem_of(opened, base, body, stem);
        warn_of_stale(report, stem, asked->format);
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

/* BASE: as asked, else the document's name without its ending. */
static void base_of(const char *asked, const char *document, char *base, size_t capacity)
{
    const size_t length = strlen(document), stem = pith_path_has_extension(document, "pith") ? length - 5 : length;
    snprintf(base, capacity, "%.*s", (int)(asked ? strlen(asked) : stem), asked ? asked : document);
}

static int run(const cli_model *opened, const cli_line *line, const cut_flags *asked, bool json)
{
    char base[800];
    base_of(asked->out, line->word[0], base, sizeof base);
    pith_error err;
    json_t *report = json_array();
    pith_status status = cli_apply_cut(line, &asked->cut, opened->model, &err);
    if (status == PITH_OK) status = write_all(opened, asked, base, report, &err);
    int result;
    if (status != PITH_OK) {
        result = cli_fail("cut", &err);
    } else if (json) {
        const double seconds = pith_model_timing(opened->model)->cut;
        result = cli_print_json(json_pack("{sf sO}", "cut_seconds", seconds, "files", report));
    } else {
        cli_progress_done();
        print_report(report);
        result = cli_finish_output("cut");
    }
    json_decref(report);
    return result;
}

int verb_cut(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    cut_flags asked = { .format = "glb", .max_triangles = 2000000 };
    const cli_flag flags[] = {
        CLI_CUT_FLAGS(asked.cut),
        { "out", 'o', CLI_TEXT, &asked.out, "BASE", "files are BASE-1.glb, BASE-2.glb, …; default: the document's",
          0, 0, NULL },
        { "format", 0, CLI_TEXT, &asked.format, "glb|ply|obj", "kind of file; default glb", 0, 0, NULL },
        { "edge", 0, CLI_NUMBER, &asked.edge, "X", "divide triangles until no edge is longer; 0: as cut", 0, 1e300,
          NULL },
        { "max-triangles", 0, CLI_WHOLE, &asked.max_triangles, "N", "refuse to make more than this a half", 1, 1e9,
          NULL },
        { "watertight", 0, CLI_SWITCH, &asked.watertight, NULL, "skin and section share the vertices of their border",
          0, 0, NULL },
        { "no-displacement", 0, CLI_SWITCH, &common.no_displacement, NULL,
          "leave the skin where it is, whatever the document says", 0, 0, NULL },
        CLI_JSON_FLAG(common),
        CLI_THREADS_FLAG(common),
        CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "cut",
        .words = "DOCUMENT",
        .least_words = 1,
        .most_words = 1,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .tables = { &pith_cut_step_params },
        .summary =
            "Cuts the model along a plane or a stroke and writes what is left as meshes coloured by the solid, first\n"
            "the side the normal points away from (of a stroke: its left). A document of several bodies gives files\n"
            "BASE-BODY-1.glb, … for each. A colour sits at every vertex: --edge sets how fine the picture on the\n"
            "section becomes.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (strcmp(asked.format, "glb") != 0 && strcmp(asked.format, "ply") != 0 && strcmp(asked.format, "obj") != 0)
        return cli_misuse("cut", "--format is \"%s\", expected glb, ply or obj", asked.format);
    code = cli_check_cut(&line, &asked.cut);
    if (code != CLI_GO_ON) return code;
    if (asked.out && cli_check_out("cut", asked.out) != CLI_GO_ON) return EXIT_FAILED;
    cli_model opened;
    code = cli_open("cut", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    code = run(&opened, &line, &asked, common.json);
    cli_close(&opened);
    return code;
}
