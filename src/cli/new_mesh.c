/* A document for a mesh: the core of every component along its longest axis, and from there depth, directions, a cut
   and a camera; what a texture type needs and no more. */
#include "new.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* ---- an axis through a mesh -------------------------------------------------------------------------------------- */

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

/* The longest stretch inside the mesh of the line through middle, drawn in by a fifth of itself at either end so that
   the core keeps away from the skin. False when the line misses the inside. */
static bool core_segment(const pith_tracer *tracer, pith_vec3 middle, pith_vec3 axis, double reach, pith_vec3 ends[2])
{
    enum { SAMPLES = 401 };
    static pith_vec3 points[SAMPLES];
    static bool inside[SAMPLES];
    for (int i = 0; i < SAMPLES; ++i) points[i] = pith_madd(middle, axis, reach * (2.0 * i / (SAMPLES - 1) - 1.0));
    pith_tracer_inside(tracer, points, SAMPLES, inside);
    int best = 0, best_start = 0;
    for (int i = 0, run = 0; i < SAMPLES; ++i) {
        run = inside[i] ? run + 1 : 0;
        if (run > best) best = run, best_start = i - run + 1;
    }
    if (best < 5) return false;
    ends[0] = points[best_start + best / 5];
    ends[1] = points[best_start + best - 1 - best / 5];
    return true;
}

/* ---- components -------------------------------------------------------------------------------------------------- */

enum { MOST_CORES = 64 };

/* The core of every component. */
typedef struct cores { pith_vec3 ends[MOST_CORES][2]; int count, missed; } cores;

static uint32_t root_of(uint32_t *parents, uint32_t v)
{
    while (parents[v] != v) v = parents[v] = parents[parents[v]];
    return v;
}

/* Which component a vertex belongs to: the lowest vertex of it. */
static uint32_t *find_components(const pith_mesh_view *mesh)
{
    uint32_t *parents = pith_alloc(mesh->vertex_count, sizeof *parents);
    for (uint32_t v = 0; parents && v < mesh->vertex_count; ++v) parents[v] = v;
    for (uint32_t t = 0; parents && t < mesh->triangle_count; ++t)
        for (int k = 0; k < 2; ++k) {
            const uint32_t a = root_of(parents, mesh->triangles[t][k]), b = root_of(parents, mesh->triangles[t][k + 1]);
            parents[a > b ? a : b] = a > b ? b : a;
        }
    for (uint32_t v = 0; parents && v < mesh->vertex_count; ++v) parents[v] = root_of(parents, v);
    return parents;
}

/* The core of the component of vertex `root`, whose triangles are gathered in `own`. Cavities have none. */
static void add_core(const pith_mesh_view *mesh, const uint32_t *parents, uint32_t root, uint32_t (*own)[3],
                     const pith_tracer *tracer, cores *found)
{
    pith_mesh_view component = *mesh;
    component.triangles = (const uint32_t (*)[3])own;
    component.triangle_count = 0;
    pith_box box = pith_box_empty();
    double volume = 0;
    for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
        const uint32_t *corners = mesh->triangles[t];
        if (parents[corners[0]] != root) continue;
        memcpy(own[component.triangle_count++], corners, sizeof *own);
        const pith_vec3 a = mesh->positions[corners[0]], b = mesh->positions[corners[1]],
                        c = mesh->positions[corners[2]];
        volume += pith_dot(a, pith_cross(b, c)) / 6.0;
        pith_box_add(&box, a);
        pith_box_add(&box, b);
        pith_box_add(&box, c);
    }
    if (component.triangle_count == 0 || !(volume > 0.0)) return;
    pith_vec3 middle;
    const pith_vec3 axis = longest_axis(&component, &middle);
    if (core_segment(tracer, middle, axis, pith_distance(box.low, box.high), found->ends[found->count])) ++found->count;
    else ++found->missed;
}

/* No component has a core: a surface that is not closed may well have no inside at all, and that comes first. */
static pith_status refuse_coreless(const char *from, const pith_mesh_report *report, pith_error *err)
{
    char complaint[300];
    if (report->closed)
        return pith_fail(err, PITH_BAD_MESH, "%s: the mesh's longest axis does not run through its inside; start from a "
                         "template (pith new kiwi) and draw the core's stroke by hand", from);
    pith_mesh_complaint(report, complaint, sizeof complaint);
    return pith_fail(err, PITH_BAD_MESH, "%s: the mesh is not closed and has no inside to be filled: %s; close its holes "
                     "first", from, complaint);
}

static pith_status find_cores(const char *from, const pith_mesh *mesh, const pith_mesh_report *report, cores *found,
                              pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    uint32_t *parents = find_components(&view), (*own)[3] = pith_alloc(view.triangle_count, sizeof *own);
    pith_tracer *tracer = NULL;
    pith_status status =
        parents && own ? pith_tracer_create(&view, &tracer, err) : PITH_OUT_OF_MEMORY(err, "components");
    for (uint32_t v = 0; status == PITH_OK && v < view.vertex_count && found->count + found->missed < MOST_CORES; ++v)
        if (parents[v] == v) add_core(&view, parents, v, own, tracer, found);
    pith_tracer_destroy(tracer);
    pith_free(parents);
    pith_free(own);
    if (status == PITH_OK && found->count == 0) status = refuse_coreless(from, report, err);
    if (status == PITH_OK && found->missed)
        fprintf(stderr,
                "pith new: of %d components of the mesh the longest axis does not run through the inside; draw their "
                "strokes by hand\n",
                found->missed);
    return status;
}

/* ---- documents --------------------------------------------------------------------------------------------------- */

static json_t *segment_json(const pith_vec3 ends[2])
{
    return json_pack("[oo]", cli_point_json(ends[0]), cli_point_json(ends[1]));
}

/* The mesh's path as seen from the new document. */
static void mesh_name(const char *mesh_path, const char *out, char *name, size_t capacity)
{
    char mesh[PATH_MAX], folder[PATH_MAX];
    char *beside = pith_path_join(out, ".");
    const bool known = beside && realpath(mesh_path, mesh) && realpath(beside, folder);
    pith_free(beside);
    if (!known) {
        snprintf(name, capacity, "%s", mesh_path);
        return;
    }
    size_t same = 0; /* what both have in common, up to a slash */
    strncat(folder, "/", sizeof folder - strlen(folder) - 1);
    for (size_t i = 0; mesh[i] && mesh[i] == folder[i]; ++i)
        if (mesh[i] == '/') same = i + 1;
    if (same <= 1) { /* nothing in common: the whole path is plainer */
        snprintf(name, capacity, "%s", mesh);
        return;
    }
    name[0] = 0;
    for (const char *at = folder + same; (at = strchr(at, '/')); ++at)
        if (strlen(name) + 4 < capacity) strcat(name, "../");
    snprintf(name + strlen(name), capacity - strlen(name), "%s", mesh + same);
}

static pith_status make_mesh(const new_wish *wish, pith_mesh **mesh, pith_mesh_report *report, json_t **shape,
                             pith_error *err)
{
    char name[2 * PATH_MAX];
    pith_mesh *raw = NULL;
    const pith_slab_options slab = pith_slab_options_default();
    const pith_fruit_options fruit = pith_fruit_options_default();
    if (strcmp(wish->from, "slab") == 0) {
        PITH_TRY(pith_mesh_slab(&slab, &raw, err));
        *shape = json_pack("{s{}}", "slab");
    } else if (strcmp(wish->from, "fruit") == 0) {
        PITH_TRY(pith_mesh_fruit(&fruit, &raw, err));
        *shape = json_pack("{s{}}", "fruit");
    } else {
        PITH_TRY(pith_mesh_read(wish->from, &raw, err));
        mesh_name(wish->from, wish->out, name, sizeof name);
        *shape = json_pack("{ss}", "mesh", name);
    }
    json_object_set_new(*shape, "tets", json_pack("{si}", "tetrahedra", wish->tetrahedra));
    const pith_status status = pith_mesh_clean(raw, mesh, report, err);
    pith_mesh_destroy(raw);
    return status;
}

/* Depth 0 on the skin and 1 along every core. */
static json_t *depth_json(const cores *found)
{
    json_t *list = json_pack("[{sssi}]", "faces", "all", "depth", 0);
    for (int i = 0; i < found->count; ++i)
        json_array_append_new(list, json_pack("{sosi}", "stroke", segment_json(found->ends[i]), "depth", 1));
    return json_pack("{so}", "constraints", list);
}

static json_t *strokes_json(const cores *found)
{
    json_t *list = json_array();
    for (int i = 0; i < found->count; ++i) json_array_append_new(list, segment_json(found->ends[i]));
    return list;
}

/* What a type starts with: which fields, and an exemplar of the shipped ones that it suits. */
typedef struct new_type { const char *word, *exemplar; bool depth, direction, vectors, scale; } new_type;
static const new_type new_types[] = {
    { "0-A", "sponge", false, false, false, true },
    { "0-B", "muscle", false, false, true, true },
    { "0-C", "flattened", true, true, false, true },
    { "1-A", "watermelon", true, false, false, false },
    { "1-B", "kiwi", true, true, false, false },
};

static void add_fields(const new_wish *wish, const pith_mesh_report *report, const cores *found, json_t *root)
{
    const new_type *type = &new_types[wish->type];
    const pith_vec3 middle = pith_lerp(found->ends[0][0], found->ends[0][1], 0.5);
    if (type->depth) json_object_set_new(root, "depth", depth_json(found));
    if (type->direction) json_object_set_new(root, "direction", json_pack("{so}", "strokes", strokes_json(found)));
    if (type->vectors) json_object_set_new(root, "vectors", json_pack("{so}", "inside", strokes_json(found)));
    if (!type->scale) return;
    /* About half as wide as the body is thick: the exemplar is seen several times. */
    const double volume = report->closed ? report->volume : 0.0,
                 diagonal = pith_distance(report->box.low, report->box.high);
    const double fitted = volume > 0.0 ? 0.5 * cbrt(volume) : 0.25 * diagonal;
    json_object_set_new(root, "scale", json_pack("{s[{sosf}]}", "points", "point", cli_point_json(middle), "size",
                                                 wish->size > 0.0 ? wish->size : fitted));
}

/* A cut across the first core, and a camera that looks at its section. */
static void add_view(const cores *found, json_t *root)
{
    const pith_vec3 *ends = found->ends[0], axis = pith_unit(pith_sub(ends[1], ends[0]));
    json_object_set_new(root, "cuts",
                        json_pack("[{s{soso}ss}]", "plane", "point", cli_point_json(pith_lerp(ends[0], ends[1], 0.5)),
                                  "normal", cli_point_json(axis), "keep", "negative"));
    /* Upright is y as in most scans, or z where the axis runs along y. */
    const pith_vec3 up = fabs(axis.y) < 0.8 ? pith_v3(0, 1, 0) : pith_v3(0, 0, 1);
    const pith_vec3 side = pith_unit(pith_cross(up, axis));
    const pith_vec3 view_from = pith_madd(pith_madd(axis, up, 0.35), side, 0.35);
    json_object_set_new(root, "camera", json_pack("{soso}", "direction", cli_point_json(view_from), "up",
                                                  cli_point_json(up)));
}

static pith_status add_solid(const new_wish *wish, json_t *root, pith_error *err)
{
    const new_type *type = &new_types[wish->type];
    char recipe[100], path[1000];
    snprintf(recipe, sizeof recipe, "exemplars/%s.json", type->exemplar);
    if (!cli_find_example(recipe, path, sizeof path))
        return pith_fail(err, PITH_IO, "the exemplar %s is not beside the program nor where its source was", recipe);
    json_t *solid = json_pack("{ss ss ss s{ss}}", "name", type->exemplar, "kind", "lapped", "type", type->word,
                              "exemplar", "recipe", path);
    if (type->scale) json_object_set_new(solid, "blend", json_string("variance"));
    json_object_set_new(root, "solids", json_pack("[o]", solid));
    return new_inline_recipes(root, path, wish->out, err);
}

pith_status new_for_mesh(const new_wish *wish, json_t **root, pith_error *err)
{
    pith_mesh *mesh = NULL;
    pith_mesh_report report;
    json_t *shape = NULL;
    cores *found = pith_alloc(1, sizeof *found);
    if (!found) return PITH_OUT_OF_MEMORY(err, "a document");
    pith_status status = make_mesh(wish, &mesh, &report, &shape, err);
    if (status == PITH_OK) status = find_cores(wish->from, mesh, &report, found, err);
    json_t *made = NULL;
    if (status == PITH_OK) {
        const char *slash = strrchr(wish->from, '/');
        made = json_pack("{si ss sO}", "pith", 1, "title", slash ? slash + 1 : wish->from, "shape", shape);
        add_fields(wish, &report, found, made);
        status = add_solid(wish, made, err);
        add_view(found, made);
    }
    json_decref(shape);
    pith_mesh_destroy(mesh);
    pith_free(found);
    if (status == PITH_OK) *root = made;
    else json_decref(made);
    return status;
}
