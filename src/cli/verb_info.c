/* pith info: what a mesh, a tetrahedral mesh or a document is like. */
#include "cli.h"

#include <string.h>

/* Reports as rows "name value", so that text and JSON say the same. */
typedef struct rows { json_t *object; } rows;

static void row_whole(rows *to, const char *name, uint32_t value)
{
    json_object_set_new(to->object, name, json_integer(value));
}

static void row_number(rows *to, const char *name, double value)
{
    json_object_set_new(to->object, name, isfinite(value) ? json_real(value) : json_null());
}

static void row_text(rows *to, const char *name, const char *value)
{
    json_object_set_new(to->object, name, json_string(value));
}

static json_t *mesh_rows(const pith_mesh_report *r)
{
    rows to = { json_object() };
    row_whole(&to, "vertices", r->vertices);
    row_whole(&to, "triangles", r->triangles);
    row_whole(&to, "components", r->components);
    json_object_set_new(to.object, "closed", json_boolean(r->closed));
    row_whole(&to, "boundary_edges", r->boundary_edges);
    row_whole(&to, "boundary_loops", r->boundary_loops);
    row_whole(&to, "nonmanifold_edges", r->nonmanifold_edges);
    row_whole(&to, "self_intersections", r->self_intersections);
    row_whole(&to, "welded_vertices", r->welded_vertices);
    row_whole(&to, "unused_vertices", r->unused_vertices);
    row_whole(&to, "degenerate_triangles", r->degenerate_triangles);
    row_whole(&to, "duplicate_triangles", r->duplicate_triangles);
    row_whole(&to, "flipped_triangles", r->flipped_triangles);
    row_number(&to, "area", r->area);
    row_number(&to, "volume", r->volume);
    json_object_set_new(to.object, "box_low", cli_point_json(r->box.low));
    json_object_set_new(to.object, "box_high", cli_point_json(r->box.high));
    char complaint[400];
    pith_mesh_complaint(r, complaint, sizeof complaint);
    row_text(&to, "complaint", complaint);
    return to.object;
}

static json_t *tets_rows(const pith_tets_report *r)
{
    rows to = { json_object() };
    row_whole(&to, "tetrahedra", r->tetrahedra);
    row_whole(&to, "vertices", r->vertices);
    row_number(&to, "volume", r->volume);
    row_number(&to, "least_volume", r->min_volume);
    row_number(&to, "least_dihedral_degrees", r->min_dihedral);
    row_number(&to, "greatest_dihedral_degrees", r->max_dihedral);
    row_number(&to, "share_below_10_degrees", r->below_10_degrees);
    if (r->why[0]) row_text(&to, "why_stuffing", r->why);
    return to.object;
}

static void print_rows(const char *title, const json_t *object)
{
    const char *name;
    json_t *value;
    printf("%s\n", title);
    json_object_foreach((json_t *)object, name, value) {
        if (json_is_string(value) && json_string_length(value) == 0) continue;
        char text[500];
        if (json_is_array(value))
            snprintf(text, sizeof text, "%.6g %.6g %.6g", json_number_value(json_array_get(value, 0)),
                     json_number_value(json_array_get(value, 1)), json_number_value(json_array_get(value, 2)));
        else if (json_is_boolean(value)) snprintf(text, sizeof text, "%s", json_is_true(value) ? "yes" : "no");
        else if (json_is_string(value)) snprintf(text, sizeof text, "%s", json_string_value(value));
        else snprintf(text, sizeof text, "%.8g", json_number_value(value));
        char label[60];
        snprintf(label, sizeof label, "%s", name);
        for (char *at = label; *at; ++at)
            if (*at == '_') *at = ' ';
        printf("  %-26s %s\n", label, text);
    }
}

static pith_status report_mesh(const char *path, json_t *report, pith_error *err)
{
    pith_mesh *raw = NULL, *clean = NULL;
    pith_mesh_report measured;
    PITH_TRY(pith_mesh_read(path, &raw, err));
    const pith_status status = pith_mesh_clean(raw, &clean, &measured, err);
    pith_mesh_destroy(raw);
    pith_mesh_destroy(clean);
    if (status == PITH_OK) json_object_set_new(report, "mesh", mesh_rows(&measured));
    return status;
}

static pith_status report_vtu(const char *path, json_t *report, pith_error *err)
{
    pith_tets *tets = NULL;
    PITH_TRY(pith_tets_read_vtu(path, &tets, err));
    pith_tets_report measured = { 0 };
    pith_tets_measure(tets, &measured);
    pith_tets_destroy(tets);
    json_object_set_new(report, "tets", tets_rows(&measured));
    return PITH_OK;
}

/* One body: its mesh and its tets. */
static pith_status report_body(pith_model *body, json_t *report, pith_error *err)
{
    const pith_mesh_report *mesh;
    const pith_tets_report *tets;
    PITH_TRY(pith_model_mesh(body, NULL, &mesh, err));
    PITH_TRY(pith_model_tets(body, NULL, &tets, err));
    json_object_set_new(report, "mesh", mesh_rows(mesh));
    json_object_set_new(report, "tets", tets_rows(tets));
    return PITH_OK;
}

/* What the document says a body is made of. */
static void solid_rows(rows *to, const json_t *body)
{
    const json_t *solids = json_object_get(body, "solids");
    const char *chosen = json_string_value(json_object_get(body, "solid"));
    size_t i;
    json_t *solid;
    json_array_foreach((json_t *)solids, i, solid) {
        const char *name = json_string_value(json_object_get(solid, "name"));
        if (chosen ? strcmp(name, chosen) != 0 : i != 0) continue;
        const char *kind = json_string_value(json_object_get(solid, "kind"));
        const char *type = json_string_value(json_object_get(solid, "type"));
        row_text(to, "solid", name);
        row_text(to, "kind", kind);
        if (strcmp(kind, "lapped") == 0) row_text(to, "type", type ? type : "1-B");
    }
}

static pith_status report_document(const cli_model *opened, json_t *report, pith_error *err)
{
    char *text = NULL;
    PITH_TRY(pith_document_json_full(opened->document, &text, err));
    json_t *root = json_loads(text, 0, NULL), *bodies = json_object_get(root, "bodies");
    pith_free(text);
    rows document = { json_object() };
    row_text(&document, "title", pith_document_title(opened->document));
    for (size_t i = 0; i < pith_document_solids(opened->document); ++i) {
        char name[40];
        snprintf(name, sizeof name, "solid_%zu", i);
        row_text(&document, name, pith_document_solid_name(opened->document, i));
    }
    json_object_set_new(document.object, "translucent", json_boolean(pith_document_translucent(opened->document)));
    if (!bodies) solid_rows(&document, root);
    json_object_set_new(report, "document", document.object);
    pith_status status = PITH_OK;
    if (!bodies) {
        status = report_body(opened->model, report, err);
    } else {
        json_t *list = json_array();
        json_object_set_new(report, "bodies", list);
        for (size_t i = 0; status == PITH_OK && i < json_array_size(bodies); ++i) {
            pith_model *body = NULL;
            rows own = { json_object() };
            json_array_append_new(list, own.object);
            row_text(&own, "name", pith_document_body_name(opened->document, i));
            solid_rows(&own, json_array_get(bodies, i));
            status = pith_model_body(opened->model, i, &body, err);
            if (status == PITH_OK) status = report_body(body, own.object, err);
        }
    }
    json_decref(root);
    return status;
}

/* Several bodies, a line each. */
static void print_bodies(const json_t *list)
{
    printf("bodies\n  %-24s %-16s %-6s %10s %12s %12s  %s\n", "name", "solid", "type", "triangles", "tetrahedra",
           "volume", "surface");
    size_t i;
    json_t *body;
    json_array_foreach((json_t *)list, i, body) {
        const json_t *mesh = json_object_get(body, "mesh"), *tets = json_object_get(body, "tets");
        const char *solid = json_string_value(json_object_get(body, "solid"));
        const char *type = json_string_value(json_object_get(body, "type"));
        printf("  %-24s %-16s %-6s %10d %12d %12.6g  %s\n", json_string_value(json_object_get(body, "name")),
               solid ? solid : "-", type ? type : "-", (int)json_integer_value(json_object_get(mesh, "triangles")),
               (int)json_integer_value(json_object_get(tets, "tetrahedra")),
               json_real_value(json_object_get(tets, "volume")),
               json_is_true(json_object_get(mesh, "closed")) ? "closed" : "not closed");
    }
}

int verb_info(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const cli_flag flags[] = { CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common) };
    cli_line line = {
        .verb = "info", .words = "FILE", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Reports on a triangle mesh (OBJ, PLY, STL, OFF, GLB), a tetrahedral mesh (VTU) or a document:\n"
                   "what cleaning found and repaired, what is still wrong and where, sizes, quality of the tetrahedra.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;

    pith_error err;
    json_t *report = json_object();
    cli_model opened = { 0 };
    pith_status status;
    if (pith_path_has_extension(line.word[0], "pith")) {
        code = cli_open("info", line.word[0], &common, &opened);
        if (code != CLI_GO_ON) {
            json_decref(report);
            return code;
        }
        status = report_document(&opened, report, &err);
        cli_close(&opened);
    } else {
        status = pith_path_has_extension(line.word[0], "vtu") ? report_vtu(line.word[0], report, &err)
                                                              : report_mesh(line.word[0], report, &err);
    }
    if (status != PITH_OK) {
        json_decref(report);
        return cli_fail("info", &err);
    }
    if (common.json) return cli_print_json(report);
    const char *title;
    json_t *section;
    json_object_foreach(report, title, section) {
        if (json_is_array(section)) print_bodies(section);
        else print_rows(title, section);
    }
    json_decref(report);
    return cli_finish_output("info");
}
