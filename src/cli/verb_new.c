/* pith new: a document to start from. Templates are the shipped examples with their recipe written into them, so that
   the new document stands alone; for a mesh, a kiwi whose core follows the mesh's longest axis. */
#include "cli.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static const char *const template_names[] = { "kiwi", "carrot", "tree", "watermelon", NULL };

/* ---- JSON files -------------------------------------------------------------------------------------------------------- */

static pith_status load_json(const char *path, json_t **root, pith_error *err)
{
    json_error_t problem;
    *root = json_load_file(path, JSON_REJECT_DUPLICATES, &problem);
    if (*root) return PITH_OK;
    return pith_fail(err, PITH_BAD_FILE, "%s: line %d: %s", path, problem.line, problem.text);
}

/* Checks the document as a reader will, then writes it in the house's layout. */
static pith_status save_checked(const json_t *root, const char *out, pith_error *err)
{
    char *text = json_dumps(root, 0);
    if (!text) return pith_fail(err, PITH_NO_MEMORY, "out of memory for the new document");
    pith_document *document = NULL;
    pith_status status = pith_document_parse(out, text, strlen(text), &document, err);
    free(text);
    if (status == PITH_OK) status = pith_document_save(document, out, err);
    pith_document_destroy(document);
    return status;
}

/* A photograph that the recipe names is copied beside the new document. */
static pith_status copy_strip(json_t *recipe, const char *recipe_path, const char *out, pith_error *err)
{
    const char *strip = json_string_value(json_object_get(recipe, "strip"));
    if (!strip) return PITH_OK;
    const char *slash = strrchr(strip, '/'), *name = slash ? slash + 1 : strip;
    char *from = pith_path_join(recipe_path, strip), *to = pith_path_join(out, name);
    unsigned char *bytes = NULL;
    size_t size;
    pith_status status = from && to ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for a path");
    if (status == PITH_OK) status = pith_file_read(from, &bytes, &size, err);
    if (status == PITH_OK && !pith_file_exists(to)) status = pith_file_write(to, bytes, size, err);
    if (status == PITH_OK) json_object_set_new(recipe, "strip", json_string(name));
    pith_free(bytes);
    pith_free(from);
    pith_free(to);
    return status;
}

/* Replaces {"recipe": path} of every solid by the recipe itself. */
static pith_status inline_recipes(json_t *root, const char *template_path, const char *out, pith_error *err)
{
    size_t i;
    json_t *solid;
    json_array_foreach(json_object_get(root, "solids"), i, solid) {
        json_t *exemplar = json_object_get(solid, "exemplar"), *recipe = NULL;
        const char *written = json_string_value(json_object_get(exemplar, "recipe"));
        if (!written) continue;
        char *path = pith_path_join(template_path, written);
        pith_status status = path ? load_json(path, &recipe, err) : pith_fail(err, PITH_NO_MEMORY, "out of memory");
        if (status == PITH_OK) status = copy_strip(recipe, path, out, err);
        pith_free(path);
        if (status != PITH_OK) {
            json_decref(recipe);
            return status;
        }
        json_object_set_new(solid, "exemplar", json_pack("{so}", "layered", recipe));
    }
    return PITH_OK;
}

static pith_status new_from_template(const char *name, const char *out, pith_error *err)
{
    char file[100], path[1000];
    snprintf(file, sizeof file, "%s.pith", name);
    if (!cli_find_example(file, path, sizeof path))
        return pith_fail(err, PITH_IO, "the template %s is not beside the program nor where its source was", file);
    json_t *root = NULL;
    PITH_TRY(load_json(path, &root, err));
    pith_status status = inline_recipes(root, path, out, err);
    if (status == PITH_OK) status = save_checked(root, out, err);
    json_decref(root);
    return status;
}

/* ---- an axis through a mesh ------------------------------------------------------------------------------------------ */

/* Direction of the largest spread of the surface about its middle: the first eigenvector of its covariance, by repeated
   multiplication, which is enough where any of several equal axes will do. */
static pith_vec3 longest_axis(const pith_mesh_view *mesh, pith_vec3 *middle)
{
    double area = 0, c[6] = { 0 };
    pith_vec3 sum = { 0, 0, 0 };
    for (int pass = 0; pass < 2; ++pass) {
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            const pith_vec3 a = mesh->positions[mesh->triangles[t][0]], b = mesh->positions[mesh->triangles[t][1]];
            const pith_vec3 d = mesh->positions[mesh->triangles[t][2]];
            const double weight = 0.5 * pith_length(pith_cross(pith_sub(b, a), pith_sub(d, a)));
            const pith_vec3 centre = pith_scale(pith_add(pith_add(a, b), d), 1.0 / 3.0);
            if (pass == 0) {
                area += weight;
                sum = pith_madd(sum, centre, weight);
            } else {
                const pith_vec3 p = pith_sub(centre, *middle);
                const double products[6] = { p.x * p.x, p.y * p.y, p.z * p.z, p.x * p.y, p.x * p.z, p.y * p.z };
                for (int k = 0; k < 6; ++k) c[k] += weight * products[k];
            }
        }
        *middle = pith_scale(sum, 1.0 / area);
    }
    pith_vec3 axis = pith_unit(pith_v3(c[0] + 1e-3 * c[1], c[1], c[2]));
    for (int i = 0; i < 200; ++i)
        axis = pith_unit(pith_v3(c[0] * axis.x + c[3] * axis.y + c[4] * axis.z,
                                 c[3] * axis.x + c[1] * axis.y + c[5] * axis.z,
                                 c[4] * axis.x + c[5] * axis.y + c[2] * axis.z));
    return axis;
}

/* The longest stretch inside the mesh of the line through middle, drawn in by a fifth of itself at either end so that the
   core keeps away from the skin. False when the line misses the inside. */
static pith_status core_segment(const pith_mesh *mesh, pith_vec3 middle, pith_vec3 axis, double reach, pith_vec3 ends[2],
                                pith_error *err)
{
    enum { SAMPLES = 401 };
    static pith_vec3 points[SAMPLES];
    static bool inside[SAMPLES];
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_tracer *tracer = NULL;
    PITH_TRY(pith_tracer_create(&view, &tracer, err));
    for (int i = 0; i < SAMPLES; ++i) points[i] = pith_madd(middle, axis, reach * (2.0 * i / (SAMPLES - 1) - 1.0));
    pith_tracer_inside(tracer, points, SAMPLES, inside);
    pith_tracer_destroy(tracer);

    int best = 0, best_start = 0;
    for (int i = 0, run = 0; i < SAMPLES; ++i) {
        run = inside[i] ? run + 1 : 0;
        if (run > best) best = run, best_start = i - run + 1;
    }
    if (best < 5)
        return pith_fail(err, PITH_BAD_MESH, "the mesh's longest axis does not run through its inside; start from a "
                         "template (pith new kiwi) and draw the core's stroke by hand");
    ends[0] = points[best_start + best / 5];
    ends[1] = points[best_start + best - 1 - best / 5];
    return PITH_OK;
}

/* ---- meshes ------------------------------------------------------------------------------------------------------------- */

static json_t *segment_json(const pith_vec3 ends[2])
{
    return json_pack("[oo]", cli_point_json(ends[0]), cli_point_json(ends[1]));
}

/* How the new document names the mesh: by its name alone when they lie in one folder, else by its full path. */
static const char *mesh_name(const char *mesh_path, const char *out, char full[PATH_MAX])
{
    const char *slash = strrchr(mesh_path, '/'), *other = strrchr(out, '/');
    const size_t length = slash ? (size_t)(slash - mesh_path) : 0, other_length = other ? (size_t)(other - out) : 0;
    if (length == other_length && strncmp(mesh_path, out, length) == 0) return slash ? slash + 1 : mesh_path;
    return realpath(mesh_path, full) ? full : mesh_path;
}

static pith_status mesh_document(const pith_mesh *mesh, const pith_mesh_report *report, const char *name, json_t *root,
                                 pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_vec3 middle, ends[2];
    const pith_vec3 axis = longest_axis(&view, &middle);
    const double reach = pith_distance(report->box.low, report->box.high);
    PITH_TRY(core_segment(mesh, middle, axis, reach, ends, err));
    const char *slash = strrchr(name, '/');
    json_object_set_new(root, "title", json_string(slash ? slash + 1 : name));
    json_object_set_new(root, "shape", json_pack("{sss{si}}", "mesh", name, "tets", "tetrahedra", 5000));
    json_object_set_new(root, "depth",
                        json_pack("{s[{sssi}{sosi}]}", "constraints", "faces", "all", "depth", 0, "stroke",
                                  segment_json(ends), "depth", 1));
    json_object_set_new(root, "direction", json_pack("{s[o]}", "strokes", segment_json(ends)));
    json_object_set_new(root, "cuts",
                        json_pack("[{s{soso}ss}]", "plane", "point", cli_point_json(pith_lerp(ends[0], ends[1], 0.5)),
                                  "normal", cli_point_json(axis), "keep", "negative"));
    /* The far half stays and shows its section; upright is y as in most scans, or z where the axis runs along y. */
    const pith_vec3 up = fabs(axis.y) < 0.8 ? pith_v3(0, 1, 0) : pith_v3(0, 0, 1);
    const pith_vec3 side = pith_unit(pith_cross(up, axis));
    const pith_vec3 view_from = pith_madd(pith_madd(axis, up, 0.35), side, 0.35);
    json_object_set_new(root, "camera", json_pack("{soso}", "direction", cli_point_json(view_from), "up",
                                                  cli_point_json(up)));
    return PITH_OK;
}

static pith_status new_from_mesh(const char *mesh_path, const char *out, pith_error *err)
{
    char template_path[1000], full[PATH_MAX];
    if (!cli_find_example("kiwi.pith", template_path, sizeof template_path))
        return pith_fail(err, PITH_IO, "the template kiwi.pith is not beside the program nor where its source was");
    pith_mesh *raw = NULL, *mesh = NULL;
    pith_mesh_report report;
    json_t *root = NULL;
    pith_status status = pith_mesh_read(mesh_path, &raw, err);
    if (status == PITH_OK) status = pith_mesh_clean(raw, &mesh, &report, err);
    if (status == PITH_OK) status = load_json(template_path, &root, err);
    if (status == PITH_OK) status = inline_recipes(root, template_path, out, err);
    if (status == PITH_OK) {
        json_object_del(root, "render");
        status = mesh_document(mesh, &report, mesh_name(mesh_path, out, full), root, err);
    }
    if (status == PITH_OK) status = save_checked(root, out, err);
    json_decref(root);
    pith_mesh_destroy(mesh);
    pith_mesh_destroy(raw);
    return status;
}

int verb_new(int argc, char **argv)
{
    bool force = false;
    const cli_flag flags[] = {
        { "force", 'f', CLI_SWITCH, &force, NULL, "replace OUT when it exists", 0, 0, NULL },
    };
    cli_line line = {
        .verb = "new", .words = "kiwi|carrot|tree|watermelon|MESH OUT", .least_words = 2, .most_words = 2, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary = "Writes a new document: a template, or a kiwi's inside for a mesh of yours, its core along the mesh's\n"
                   "longest axis. Edit it from there; docs/document.md explains every key.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    const char *from = line.word[0], *out = line.word[1];
    bool is_template = false;
    for (size_t i = 0; template_names[i]; ++i) is_template |= strcmp(from, template_names[i]) == 0;
    if (!is_template && !pith_file_exists(from)) {
        const char *near = pith_nearest_word(from, template_names);
        return cli_misuse("new", "\"%s\" is neither a template nor a file%s%s%s", from, near ? "; did you mean \"" : "",
                          near ? near : "", near ? "\"?" : "");
    }
    pith_error err;
    if (!force && pith_file_exists(out)) {
        pith_fail(&err, PITH_BAD_ARGUMENT, "%s exists; --force replaces it", out);
        return cli_fail("new", &err);
    }
    const pith_status status = is_template ? new_from_template(from, out, &err) : new_from_mesh(from, out, &err);
    return status == PITH_OK ? EXIT_DONE : cli_fail("new", &err);
}
