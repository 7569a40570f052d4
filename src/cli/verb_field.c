/* pith field: the fields of a body as lines, arrows, layers and pictures. */
#include "field.h"

#include <string.h>

static const char *const outline_words[] = { "open", "whole", "none", NULL };
static const char *const colour_words[] = { "depth", "direction", NULL };

/* The words of --of; the field's number is one more than its place here. */
static const char *const *of_words(void) { return pith_params_find(&pith_look_params, "of")->choices + 1; }

typedef enum field_kind { KIND_LINES, KIND_MESH, KIND_PICTURE, KIND_NONE } field_kind;

/* What goes into a file, by its extension. */
static field_kind kind_of(const char *path, bool glyphs)
{
    if (cli_is_picture(path)) return KIND_PICTURE;
    if (pith_path_has_extension(path, "vtp")) return KIND_LINES;
    if (pith_path_has_extension(path, "glb")) return glyphs ? KIND_MESH : KIND_LINES;
    return pith_path_has_extension(path, "ply") || pith_path_has_extension(path, "obj") ? KIND_MESH : KIND_NONE;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------ */

/* Several meshes as one. */
static pith_status join(pith_mesh *const *meshes, int count, pith_mesh **joined, pith_error *err)
{
    uint32_t vertices = 0, triangles = 0, vertex = 0, triangle = 0;
    for (int i = 0; i < count; ++i) {
        vertices += pith_mesh_look(meshes[i]).vertex_count;
        triangles += pith_mesh_look(meshes[i]).triangle_count;
    }
    pith_vec3 *positions = pith_alloc(vertices, sizeof *positions), *normals = pith_alloc(vertices, sizeof *normals);
    float (*colours)[4] = pith_alloc(vertices, sizeof *colours);
    uint32_t (*corners)[3] = pith_alloc(triangles, sizeof *corners);
    pith_status status = positions && normals && colours && corners ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a mesh");
    for (int i = 0; status == PITH_OK && i < count; ++i) {
        const pith_mesh_view from = pith_mesh_look(meshes[i]);
        memcpy(positions + vertex, from.positions, from.vertex_count * sizeof *positions);
        memcpy(colours + vertex, from.colours, from.vertex_count * sizeof *colours);
        if (from.normals) memcpy(normals + vertex, from.normals, from.vertex_count * sizeof *normals);
        else pith_mesh_vertex_normals(&from, normals + vertex);
        for (uint32_t t = 0; t < from.triangle_count; ++t, ++triangle)
            for (int k = 0; k < 3; ++k) corners[triangle][k] = vertex + from.triangles[t][k];
        vertex += from.vertex_count;
    }
    const pith_mesh_view view = { .positions = positions, .normals = normals, .colours = (const float (*)[4])colours,
                                  .triangles = (const uint32_t (*)[3])corners, .vertex_count = vertices,
                                  .triangle_count = triangles };
    if (status == PITH_OK) status = pith_mesh_create(&view, joined, err);
    pith_free(positions);
    pith_free(normals);
    pith_free(colours);
    pith_free(corners);
    return status;
}

/* The layers; without layers tubes, or arrows. */
static pith_status write_mesh(const field *from, const char *path, pith_error *err)
{
    pith_mesh *own[CLI_MOST_OF_A_KIND] = { NULL }, *parts[CLI_MOST_OF_A_KIND] = { NULL }, *joined = NULL;
    const bool layers = from->layered && !from->asked->glyphs;
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i < from->layer_count; ++i) {
        if (!layers) status = field_line_mesh(from, &from->layers[i], &own[i], err);
        parts[i] = layers ? from->layers[i].mesh : own[i];
    }
    if (status == PITH_OK) status = join(parts, from->layer_count, &joined, err);
    if (status == PITH_OK) status = pith_mesh_write(joined, path, err);
    pith_mesh_destroy(joined);
    for (int i = 0; i < from->layer_count; ++i) pith_mesh_destroy(own[i]);
    return status;
}

static pith_status write_lines(const field *from, const char *path, pith_error *err)
{
    pith_polylines *lines = NULL;
    float (*colours)[3] = NULL;
    PITH_TRY(field_all_lines(from, &lines, &colours, err));
    const pith_status status = pith_polylines_write(lines, (const float (*)[3])colours, path, err);
    pith_polylines_destroy(lines);
    pith_free(colours);
    return status;
}

/* ---- report ------------------------------------------------------------------------------------------------------ */

static json_t *length_json(const field *from, size_t *lines, size_t *points)
{
    double total = 0.0, longest = 0.0, shortest = INFINITY;
    for (int i = 0; i < from->layer_count; ++i) {
        const pith_polylines_view view = pith_polylines_look(from->layers[i].lines);
        for (uint32_t l = 0; l < view.line_count; ++l) {
            double length = 0.0;
            for (uint32_t p = view.start[l]; p + 1 < view.start[l + 1]; ++p)
                length += pith_distance(view.points[p], view.points[p + 1]);
            total += length;
            longest = fmax(longest, length);
            shortest = fmin(shortest, length);
        }
        *lines += view.line_count;
        *points += view.start[view.line_count];
    }
    return json_pack("{sf sf sf sf}", "total", total, "mean", total / (double)*lines, "longest", longest, "shortest",
                     shortest);
}

static json_t *layers_json(const field *from)
{
    json_t *list = json_array();
    for (int i = 0; from->layered && i < from->layer_count; ++i) {
        const pith_mesh_view view = pith_mesh_look(from->layers[i].mesh);
        double area = 0.0;
        for (uint32_t t = 0; t < view.triangle_count; ++t) {
            const pith_vec3 a = view.positions[view.triangles[t][0]];
            area += 0.5 * pith_length(pith_cross(pith_sub(view.positions[view.triangles[t][1]], a),
                                                 pith_sub(view.positions[view.triangles[t][2]], a)));
        }
        json_array_append_new(list, json_pack("{sf si sf}", "depth", from->layers[i].level, "triangles",
                                              (int)view.triangle_count, "area", area));
    }
    return list;
}

static json_t *report_json(const field *from)
{
    json_t *report = json_pack("{ss si}", "of", of_words()[from->view.of - 1], "tetrahedra",
                               (int)pith_tets_look(from->view.tets).tet_count);
    if (from->view.singular != PITH_NONE)
        json_object_set_new(report, "singular_tetrahedra", json_integer(from->view.singular));
    if (from->layers[0].lines) {
        size_t lines = 0, points = 0;
        json_t *length = length_json(from, &lines, &points);
        json_object_set_new(report, "lines", json_integer((json_int_t)lines));
        json_object_set_new(report, "points", json_integer((json_int_t)points));
        json_object_set_new(report, "length", length);
    }
    if (from->layers[0].vectors) {
        size_t arrows = 0;
        for (int i = 0; i < from->layer_count; ++i)
            for (size_t k = 0; k < from->layers[i].count; ++k) arrows += pith_length(from->layers[i].vectors[k]) > 0.0;
        json_object_set_new(report, "arrows", json_integer((json_int_t)arrows));
    }
    json_object_set_new(report, "layers", layers_json(from));
    json_object_set_new(report, "seconds", json_pack("{sf sf}", "fields", from->field_seconds, "lines",
                                                     from->line_seconds));
    json_t *files = json_array();
    for (int i = 0; i < from->asked->out.count; ++i)
        json_array_append_new(files, json_string(from->asked->out.items[i]));
    json_object_set_new(report, "files", files);
    return report;
}

static void print_report(json_t *report)
{
    const json_t *length = json_object_get(report, "length"),
                 *singular = json_object_get(report, "singular_tetrahedra");
    const char *of = json_string_value(json_object_get(report, "of"));
    if (length)
        printf("%s: %d lines of %d points, %.4g to %.4g long\n", of,
               (int)json_integer_value(json_object_get(report, "lines")),
               (int)json_integer_value(json_object_get(report, "points")),
               json_real_value(json_object_get(length, "shortest")),
               json_real_value(json_object_get(length, "longest")));
    if (json_object_get(report, "arrows"))
        printf("%s: %d arrows\n", of, (int)json_integer_value(json_object_get(report, "arrows")));
    size_t i;
    json_t *layer;
    json_array_foreach(json_object_get(report, "layers"), i, layer)
        printf("layer %g: %d triangles, area %.6g\n", json_real_value(json_object_get(layer, "depth")),
               (int)json_integer_value(json_object_get(layer, "triangles")),
               json_real_value(json_object_get(layer, "area")));
    if (singular)
        printf("%d of %d tetrahedra are singular\n", (int)json_integer_value(singular),
               (int)json_integer_value(json_object_get(report, "tetrahedra")));
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

/* Are lines or arrows wanted? Layers as files and the section need neither; a layer's picture has them if it can. */
static bool wants_lines(const field *from, const field_flags *asked)
{
    if (asked->depth) return false;
    bool wanted = asked->out.count == 0 && !from->layered;
    for (int i = 0; i < asked->out.count; ++i) {
        const field_kind kind = kind_of(asked->out.items[i], asked->glyphs);
        wanted |= kind == KIND_LINES || (kind == KIND_MESH && (!from->layered || asked->glyphs)) ||
                  (kind == KIND_PICTURE && (!from->layered || from->view.runs_on_layers));
    }
    return wanted;
}

static pith_status run(const cli_model *opened, const cli_line *line, pith_model *body, const field_flags *asked,
                       field *made, pith_error *err)
{
    PITH_TRY(field_open(body, asked, made, err));
    PITH_TRY(field_make_layers(made, err));
    if (wants_lines(made, asked)) PITH_TRY(asked->glyphs ? field_make_points(made, err) : field_make_lines(made, err));
    for (int i = 0; i < asked->out.count; ++i) {
        const char *path = asked->out.items[i];
        const field_kind kind = kind_of(path, asked->glyphs);
        PITH_TRY(kind == KIND_PICTURE ? field_picture(made, line, opened->document, path, err)
                 : kind == KIND_MESH  ? write_mesh(made, path, err)
                                      : write_lines(made, path, err));
    }
    return PITH_OK;
}

/* A word as its place in the list. */
static int read_word(const char *flag, const char *word, const char *const *words, uint32_t *index)
{
    char list[200] = "";
    for (uint32_t i = 0; words[i]; ++i) {
        if (word && strcmp(word, words[i]) == 0) {
            *index = i;
            return CLI_GO_ON;
        }
        const size_t length = strlen(list);
        snprintf(list + length, sizeof list - length, "%s%s", i ? ", " : "", words[i]);
    }
    return word ? cli_misuse("field", "--%s is \"%s\", expected one of %s", flag, word, list) : CLI_GO_ON;
}

static int check_flags(const field_flags *asked, bool json)
{
    if (asked->out.count == 0 && !json) return cli_misuse("field", "expected -o FILE, or --json");
    if (asked->depth && asked->layers.count)
        return cli_misuse("field", "--depth and --layer are different pictures; give one of them");
    for (int i = 0; i < asked->out.count; ++i) {
        const char *path = asked->out.items[i];
        const field_kind kind = kind_of(path, asked->glyphs);
        if (kind == KIND_NONE)
            return cli_misuse("field", "-o is %s, expected a file ending in .vtp, .glb, .ply, .obj, .png, .jpg or .exr",
                              path);
        if (asked->glyphs && kind == KIND_LINES)
            return cli_misuse("field", "%s: a .vtp holds lines; arrows go into .glb, .ply, .obj or a picture", path);
        if (asked->depth && kind != KIND_PICTURE)
            return cli_misuse("field",
                              "%s: --depth makes pictures, .png, .jpg or .exr; pith bake -o FILE.vtu writes the field",
                              path);
    }
    int code = cli_check_camera("field", &asked->camera);
    for (int i = 0; code == CLI_GO_ON && i < asked->out.count; ++i)
        if (cli_check_out("field", asked->out.items[i]) != CLI_GO_ON) code = EXIT_FAILED;
    return code;
}

static const char summary[] =
    "Follows the fields of a body and writes what there is to see, by the ending of FILE:\n"
    "  .vtp           streamlines, each with a colour, for ParaView\n"
    "  .glb           the same; with --glyphs arrows\n"
    "  .ply .obj      layers, as meshes with colours and normals; without --layer tubes or arrows\n"
    "  .png .jpg .exr a picture of all that, or with --depth of the depth on a section\n"
    "Colours of depth go from red outside by yellow, green and cyan to blue at the core.";

/* Flags that are words, before they are looked up. */
typedef struct field_words { const char *of, *outline, *colour; } field_words;

static int parse(int argc, char **argv, cli_line *line, field_flags *asked, cli_model_flags *common)
{
    field_words words = { NULL, NULL, NULL };
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXTS, &asked->out, "FILE", "what to write; may be given several times", 0, 0, NULL },
        { "of", 0, CLI_TEXT, &words.of, "FIELD",
          "primary (slope of depth), secondary (strokes), tertiary or vectors; "
          "default: what there is",
          0, 0, NULL },
        { "body", 0, CLI_TEXT, &asked->body, "NAME", "which body, of several", 0, 0, NULL },
        { "layer", 0, CLI_NUMBERS, &asked->layers, "D",
          "the layer of this depth, and lines on it; several times for more", 0, 1, NULL },
        { "glyphs", 0, CLI_SWITCH, &asked->glyphs, NULL, "arrows instead of lines", 0, 0, NULL },
        { "depth", 0, CLI_SWITCH, &asked->depth, NULL, "a picture of the depth on a section", 0, 0, NULL },
        { "plane", 0, CLI_PLANE, &asked->plane, "PX,..,NZ",
          "pictures are opened here, on the side the normal points to; "
          "default: in the middle",
          0, 0, &asked->has_plane },
        { "outline", 0, CLI_TEXT, &words.outline, "open|whole|none",
          "the skin in pictures: opened, a veil, or none; default "
          "open",
          0, 0, NULL },
        { "colour", 0, CLI_TEXT, &words.colour, "depth|direction",
          "of lines and arrows; default depth, where there is one", 0, 0, NULL },
        { "radius", 0, CLI_NUMBER, &asked->radius, "X", "of tubes, in spacings of lines; default 0.15", 0.001, 1,
          NULL },
        { "angle", 0, CLI_NUMBER, &asked->look.angle, "DEGREES",
          "tetrahedra count as singular where frames turn by more; default "
          "60",
          1, 90, NULL },
        CLI_CAMERA_FLAGS(asked->camera),
        CLI_JSON_FLAG(*common),
        CLI_THREADS_FLAG(*common),
        CLI_CACHE_FLAG(*common),
    };
    line->flags = flags;
    line->flag_count = sizeof flags / sizeof *flags;
    int code = cli_parse(line, argc, argv);
    uint32_t of = PITH_NONE, outline = OUTLINE_OPEN, colour = COLOUR_DEFAULT;
    if (code == CLI_GO_ON) code = read_word("of", words.of, of_words(), &of);
    if (code == CLI_GO_ON) code = read_word("outline", words.outline, outline_words, &outline);
    if (code == CLI_GO_ON) code = read_word("colour", words.colour, colour_words, &colour);
    if (of != PITH_NONE) asked->look.of = of + 1;
    asked->look.layers = asked->depth || asked->layers.count > 0;
    asked->outline = (field_outline)outline;
    asked->colour = (field_colour)colour;
    line->flags = NULL; /* they end here */
    line->flag_count = 0;
    return code;
}

int verb_field(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    field_flags asked = { .radius = 0.15, .look = pith_look_options_default(),
                          .lines = pith_streamline_options_default() };
    cli_line line = { .verb = "field",
                      .words = "DOCUMENT -o FILE",
                      .least_words = 1,
                      .most_words = 1,
                      .summary = summary,
                      .tables = { &pith_streamline_params, &pith_render_params } };
    int code = parse(argc, argv, &line, &asked, &common);
    if (code == CLI_GO_ON) code = check_flags(&asked, common.json);
    if (code != CLI_GO_ON) return code;
    cli_apply_params(&line, &pith_streamline_params, &asked.lines);
    cli_model opened;
    code = cli_open("field", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    pith_model *body;
    code = cli_choose_body("field", &opened, asked.body, &body);
    if (code == CLI_GO_ON) {
        field made = { 0 };
        pith_error err;
        const pith_status status = run(&opened, &line, body, &asked, &made, &err);
        cli_progress_done();
        json_t *report = status == PITH_OK ? report_json(&made) : NULL;
        if (status != PITH_OK) code = cli_fail("field", &err);
        else if (common.json) code = cli_print_json(json_incref(report));
        else print_report(report), code = cli_finish_output("field");
        json_decref(report);
        field_close(&made);
    }
    cli_close(&opened);
    return code;
}
