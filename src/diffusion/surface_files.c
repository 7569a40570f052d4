/* Diffusion surfaces in GLB and PLY files: what their values and marks are called, and back. */
#include "diffusion_internal.h"

#include "pith/diffusion_files.h"
#include "pith/shape_parts.h"

#include <string.h>
#include <strings.h>

/* The names of front, back and blur in a GLB, and of their components in a PLY. The last of colours is their opacity, 1
   where it is not there. */
enum { FRONT, BACK, BLUR, KINDS };
static const struct {
    const char *attribute;
    uint32_t least, most; /* components */
    const char *properties[4];
} kinds[KINDS] = {
    [FRONT] = { "_FRONT", 3, 4, { "front_red", "front_green", "front_blue", "front_alpha" } },
    [BACK] = { "_BACK", 3, 4, { "back_red", "back_green", "back_blue", "back_alpha" } },
    [BLUR] = { "_BLUR", 1, 1, { "blur" } },
};

/* ---- reading --------------------------------------------------------------------------------------------------------- */

typedef struct read_surface {
    pith_mesh *mesh;
    char *name;
    float (*colours[2])[4]; /* front, back */
    double *blur;
} read_surface;

struct pith_diffusion_surfaces {
    read_surface *own;                /* [count] */
    pith_diffusion_surface *surfaces; /* [count] */
    pith_diffusion_found *found;      /* [count] */
    size_t count;
};

void pith_diffusion_surfaces_destroy(pith_diffusion_surfaces *gone)
{
    if (!gone) return;
    for (size_t i = 0; i < gone->count; ++i) {
        pith_mesh_destroy(gone->own[i].mesh);
        pith_free(gone->own[i].name);
        for (int side = 0; side < 2; ++side) pith_free(gone->own[i].colours[side]);
        pith_free(gone->own[i].blur);
    }
    pith_free(gone->own);
    pith_free(gone->surfaces);
    pith_free(gone->found);
    pith_free(gone);
}

static const pith_part_values *find_values(const pith_part *part, const char *name)
{
    for (size_t i = 0; i < part->value_count; ++i)
        if (strcmp(part->values[i].name, name) == 0) return &part->values[i];
    return NULL;
}

/* Where each component of a kind is found: values and the step from one vertex to the next; NULL: it is 1. */
typedef struct component_source {
    const double *values;
    uint32_t step;
} component_source;

/* An attribute with all components of a kind. */
static pith_status find_whole(const pith_part_values *whole, int kind, const char *title, component_source from[4],
                              pith_error *err)
{
    const uint32_t least = kinds[kind].least, most = kinds[kind].most;
    if (whole->type == PITH_PART_WHOLE || whole->components < least || whole->components > most)
        return pith_fail(err, PITH_BAD_FILE, "diffusion surface %s: %s must be %s a vertex", title, whole->name,
                         most > 1 ? "3 or 4 floating-point numbers" : "1 floating-point number");
    for (uint32_t k = 0; k < whole->components; ++k)
        from[k] = (component_source){ whole->values + k, whole->components };
    return PITH_OK;
}

/* None, or all components of a kind. */
static pith_status find_components(const pith_part *part, int kind, const char *title, component_source from[4],
                                   bool *any, pith_error *err)
{
    const pith_part_values *whole = find_values(part, kinds[kind].attribute);
    memset(from, 0, 4 * sizeof *from);
    *any = whole != NULL;
    if (whole) return find_whole(whole, kind, title, from, err);
    const char *missing = NULL;
    for (uint32_t k = 0; k < kinds[kind].most; ++k) {
        const char *name = kinds[kind].properties[k];
        const pith_part_values *single = find_values(part, name);
        if (!single) {
            if (k < kinds[kind].least) missing = name;
            continue;
        }
        if (single->components != 1 || single->type == PITH_PART_WHOLE)
            return pith_fail(err, PITH_BAD_FILE, "diffusion surface %s: %s must be 1 floating-point number a vertex",
                             title, name);
        from[k] = (component_source){ single->values, 1 };
        *any = true;
    }
    if (*any && missing)
        return pith_fail(err, PITH_BAD_FILE, "diffusion surface %s: %s is missing beside the others of its colour",
                         title, missing);
    return PITH_OK;
}

static pith_status read_values(const pith_part *part, const char *title, read_surface *to, pith_diffusion_found *found,
                               pith_error *err)
{
    const uint32_t count = part->mesh.vertex_count;
    bool *const there[KINDS] = { &found->front, &found->back, &found->blur };
    for (int kind = 0; kind < KINDS; ++kind) {
        component_source from[4];
        PITH_TRY(find_components(part, kind, title, from, there[kind], err));
        if (!*there[kind]) continue;
        if (kind == BLUR) {
            to->blur = pith_alloc(count, sizeof *to->blur);
            if (!to->blur) return PITH_OUT_OF_MEMORY(err, "blur");
            for (uint32_t v = 0; v < count; ++v) to->blur[v] = part->scale * from[0].values[v * (size_t)from[0].step];
            continue;
        }
        to->colours[kind] = pith_alloc(count, sizeof **to->colours);
        if (!to->colours[kind]) return PITH_OUT_OF_MEMORY(err, "colours");
        for (uint32_t v = 0; v < count; ++v)
            for (int k = 0; k < 4; ++k)
                to->colours[kind][v][k] = from[k].values ? (float)from[k].values[v * (size_t)from[k].step] : 1.0f;
    }
    found->colours = part->mesh.colours != NULL;
    if (found->front || found->back || !found->colours) return PITH_OK;
    to->colours[FRONT] = pith_alloc(count, sizeof **to->colours);
    if (!to->colours[FRONT]) return PITH_OUT_OF_MEMORY(err, "colours");
    memcpy(to->colours[FRONT], part->mesh.colours, count * sizeof **to->colours);
    return PITH_OK;
}

static bool has_mark(const pith_part *part, const char *mark)
{
    for (size_t i = 0; i < part->mark_count; ++i)
        if (strcmp(part->marks[i], mark) == 0) return true;
    return false;
}

/* ---- seams ----------------------------------------------------------------------------------------------------------- */

/* All that is known of a vertex, as bytes to compare. */
typedef struct vertex_record {
    double position[3], blur;
    float colours[2][4];
} vertex_record;

static void record_vertex(const read_surface *own, const pith_mesh_view *view, uint32_t v, vertex_record *record)
{
    const pith_vec3 p = view->positions[v];
    *record = (vertex_record){ .position = { p.x + 0.0, p.y + 0.0, p.z + 0.0 }, /* -0 and 0 are one place */
                               .blur = own->blur ? own->blur[v] : 0.0 };
    for (int side = 0; side < 2; ++side)
        if (own->colours[side]) memcpy(record->colours[side], own->colours[side][v], sizeof record->colours[side]);
}

/* The first vertex with the same record for each, and their number without repetitions. */
static pith_status find_first(const read_surface *own, const pith_mesh_view *view, uint32_t *first, uint32_t *distinct,
                              pith_error *err)
{
    size_t slots = 16;
    while (slots < 2 * (size_t)view->vertex_count) slots *= 2;
    uint32_t *table = pith_alloc(slots, sizeof *table); /* vertex + 1 */
    if (!table) return PITH_OUT_OF_MEMORY(err, "a surface's seams");
    *distinct = 0;
    for (uint32_t v = 0; v < view->vertex_count; ++v) {
        vertex_record record, other;
        record_vertex(own, view, v, &record);
        size_t slot = pith_hash_bytes(&record, sizeof record, 0) & (slots - 1);
        for (; table[slot]; slot = (slot + 1) & (slots - 1)) {
            record_vertex(own, view, table[slot] - 1, &other);
            if (memcmp(&record, &other, sizeof record) == 0) break;
        }
        first[v] = table[slot] ? table[slot] - 1 : v;
        if (table[slot]) continue;
        table[slot] = v + 1;
        ++*distinct;
    }
    pith_free(table);
    return PITH_OK;
}

/* Joins vertices of one place and the same values; triangles that lose a corner by it go. */
static pith_status join_seams(read_surface *own, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(own->mesh);
    uint32_t *first = pith_alloc(view.vertex_count, sizeof *first), distinct = 0, triangles = 0;
    uint32_t(*corners)[3] = pith_alloc(view.triangle_count, sizeof *corners);
    pith_vec3 *positions = pith_alloc(view.vertex_count, sizeof *positions);
    pith_status status = PITH_OK;
    if (!first || !corners || !positions) {
        status = PITH_OUT_OF_MEMORY(err, "a surface's seams");
        goto done;
    }
    PITH_TRY_OR(done, find_first(own, &view, first, &distinct, err));
    /* A kept vertex moves forward in its arrays, never over one that is still to be looked at. */
    uint32_t kept = 0;
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        if (first[v] != v) {
            first[v] = first[first[v]]; /* its new place */
            continue;
        }
        positions[kept] = view.positions[v];
        for (int side = 0; side < 2; ++side)
            if (own->colours[side]) memmove(own->colours[side][kept], own->colours[side][v], sizeof **own->colours);
        if (own->blur) own->blur[kept] = own->blur[v];
        first[v] = kept++;
    }
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        uint32_t *c = corners[triangles];
        for (int k = 0; k < 3; ++k) c[k] = first[view.triangles[t][k]];
        triangles += c[0] != c[1] && c[1] != c[2] && c[2] != c[0];
    }
    pith_mesh *joined = NULL;
    PITH_TRY_OR(done, pith_mesh_create(&(pith_mesh_view){ .positions = positions,
                                                          .triangles = (const uint32_t(*)[3])corners,
                                                          .vertex_count = kept,
                                                          .triangle_count = triangles },
                                       &joined, err));
    pith_mesh_destroy(own->mesh);
    own->mesh = joined;
done:
    pith_free(first);
    pith_free(corners);
    pith_free(positions);
    return status;
}

/* ---- a file ---------------------------------------------------------------------------------------------------------- */

static pith_status read_surface_of(const pith_part *part, const char *title, bool seams, read_surface *own,
                                   pith_diffusion_surface *surface, pith_diffusion_found *found, pith_error *err)
{
    PITH_TRY(pith_mesh_create(&(pith_mesh_view){ .positions = part->mesh.positions,
                                                 .triangles = part->mesh.triangles,
                                                 .vertex_count = part->mesh.vertex_count,
                                                 .triangle_count = part->mesh.triangle_count },
                              &own->mesh, err));
    PITH_TRY(read_values(part, title, own, found, err));
    if (part->name) {
        own->name = pith_alloc(strlen(part->name) + 1, 1);
        if (!own->name) return PITH_OUT_OF_MEMORY(err, "a name");
        strcpy(own->name, part->name);
    }
    *surface = (pith_diffusion_surface){ .name = own->name,
                                         .mesh = part->mesh,
                                         .front = (const float(*)[4])own->colours[FRONT],
                                         .back = (const float(*)[4])own->colours[BACK],
                                         .blur = own->blur,
                                         .hide_front = has_mark(part, "hide_front"),
                                         .hide_back = has_mark(part, "hide_back") };
    PITH_TRY(surface_check_values(surface, title, err));
    if (seams || part->mesh.normals || part->mesh.texcoords) PITH_TRY(join_seams(own, err));
    surface->mesh = pith_mesh_look(own->mesh);
    return PITH_OK;
}

static pith_status take_parts(const pith_parts *parts, const char *name, bool seams, pith_diffusion_surfaces *made,
                              pith_error *err)
{
    size_t count;
    const pith_part *from = pith_parts_look(parts, &count);
    made->own = pith_alloc(count, sizeof *made->own);
    made->surfaces = pith_alloc(count, sizeof *made->surfaces);
    made->found = pith_alloc(count, sizeof *made->found);
    if (!made->own || !made->surfaces || !made->found) return PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    for (; made->count < count; ++made->count) {
        const size_t i = made->count;
        char title[SURFACE_TITLE];
        surface_title(&(pith_diffusion_surface){ .name = from[i].name }, i, title);
        pith_error inner;
        const pith_status status =
            read_surface_of(&from[i], title, seams, &made->own[i], &made->surfaces[i], &made->found[i], &inner);
        if (status == PITH_OK) continue;
        ++made->count; /* what it holds already is freed */
        return pith_fail(err, status == PITH_BAD_ARGUMENT ? PITH_BAD_FILE : status, "%s: %s", name, inner.message);
    }
    return PITH_OK;
}

static pith_status finish_read(pith_parts *parts, const char *name, bool seams, pith_diffusion_surfaces **surfaces,
                               pith_error *err)
{
    pith_diffusion_surfaces *made = pith_alloc(1, sizeof *made);
    const pith_status status =
        made ? take_parts(parts, name, seams, made, err) : PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    pith_parts_destroy(parts);
    if (status == PITH_OK)
        *surfaces = made;
    else
        pith_diffusion_surfaces_destroy(made);
    return status;
}

pith_status pith_diffusion_surfaces_parse(const char *name, const char *format, const void *bytes, size_t size,
                                          pith_diffusion_surfaces **surfaces, pith_error *err)
{
    if (!name || !format || !surfaces)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_surfaces_parse: a pointer is NULL");
    pith_parts *parts = NULL;
    PITH_TRY(pith_parts_parse(name, format, bytes, size, &parts, err));
    return finish_read(parts, name, strcasecmp(format, "stl") == 0, surfaces, err);
}

pith_status pith_diffusion_surfaces_read(const char *path, pith_diffusion_surfaces **surfaces, pith_error *err)
{
    if (!path || !surfaces) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_surfaces_read: a pointer is NULL");
    pith_parts *parts = NULL;
    PITH_TRY(pith_parts_read(path, &parts, err));
    return finish_read(parts, path, pith_path_has_extension(path, "stl"), surfaces, err);
}

pith_diffusion_surfaces_view pith_diffusion_surfaces_look(const pith_diffusion_surfaces *surfaces)
{
    return (pith_diffusion_surfaces_view){ surfaces->surfaces, surfaces->found, surfaces->count };
}

pith_status pith_diffusion_surfaces_coloured(const pith_diffusion_surfaces *surfaces, pith_error *err)
{
    for (size_t i = 0; i < surfaces->count; ++i) {
        if (surfaces->surfaces[i].front || surfaces->surfaces[i].back) continue;
        char title[SURFACE_TITLE];
        surface_title(&surfaces->surfaces[i], i, title);
        return pith_fail(
            err, PITH_BAD_FILE,
            "diffusion surface %s has no colour in its file; a GLB gives it by the attributes _FRONT and _BACK "
            "(VEC3 or VEC4 of floats), a PLY by the properties front_red, front_green, front_blue and back_red … "
            "back_blue (float), and both by vertex colours",
            title);
    }
    return PITH_OK;
}

/* ---- writing --------------------------------------------------------------------------------------------------------- */

/* One surface as a part; its arrays are freed after the file is written. */
typedef struct written {
    double *values[2 * 4 + 1]; /* of the values below */
    pith_part_values named[2 * 4 + 1];
    float (*colours)[4]; /* of the side that is seen, for other programs */
    const char *marks[2];
} written;

static void written_free(written *gone)
{
    for (size_t i = 0; i < sizeof gone->values / sizeof *gone->values; ++i) pith_free(gone->values[i]);
    pith_free(gone->colours);
}

/* Room for values of a name. */
static double *add_values(written *to, pith_part *part, const char *name, uint32_t components, pith_part_type type)
{
    const size_t i = part->value_count;
    to->values[i] = pith_alloc((size_t)part->mesh.vertex_count * components, sizeof **to->values);
    if (!to->values[i]) return NULL;
    to->named[i] = (pith_part_values){ name, components, type, to->values[i] };
    ++part->value_count;
    return to->values[i];
}

static bool add_side(written *to, pith_part *part, int kind, const float (*colours)[4], bool ply)
{
    const uint32_t count = part->mesh.vertex_count;
    uint32_t components = 3; /* the fourth only where something is seen through */
    for (uint32_t v = 0; v < count; ++v)
        if (colours[v][3] != 1.0f) components = 4;
    for (uint32_t k = 0; ply && k < components; ++k) {
        double *values = add_values(to, part, kinds[kind].properties[k], 1, PITH_PART_FLOAT);
        if (!values) return false;
        for (uint32_t v = 0; v < count; ++v) values[v] = (double)colours[v][k];
    }
    if (ply) return true;
    double *values = add_values(to, part, kinds[kind].attribute, components, PITH_PART_FLOAT);
    for (size_t i = 0; values && i < components * (size_t)count; ++i)
        values[i] = (double)colours[i / components][i % components];
    return values != NULL;
}

static bool add_blur(written *to, pith_part *part, const double *blur, bool ply)
{
    double *values = add_values(to, part, ply ? kinds[BLUR].properties[0] : kinds[BLUR].attribute, 1, PITH_PART_DOUBLE);
    if (values) memcpy(values, blur, part->mesh.vertex_count * sizeof *blur);
    return values != NULL;
}

static bool add_colours(written *to, pith_part *part, const float (*colours)[4])
{
    to->colours = pith_alloc(part->mesh.vertex_count, sizeof *to->colours);
    if (!to->colours) return false;
    for (uint32_t v = 0; v < part->mesh.vertex_count; ++v)
        for (int k = 0; k < 4; ++k) to->colours[v][k] = fminf(fmaxf(colours[v][k], 0.0f), 1.0f);
    part->mesh.colours = (const float(*)[4])to->colours;
    return true;
}

static pith_status make_part(const pith_diffusion_surface *from, size_t number, bool ply, written *to, pith_part *part,
                             pith_error *err)
{
    char title[SURFACE_TITLE];
    surface_title(from, number, title);
    if (!from->front && !from->back)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "diffusion surface %s has no colour, neither on its front nor on its "
                         "back",
                         title);
    PITH_TRY(surface_check_values(from, title, err));
    *part = (pith_part){ .name = from->name,
                         .mesh = { .positions = from->mesh.positions,
                                   .triangles = from->mesh.triangles,
                                   .vertex_count = from->mesh.vertex_count,
                                   .triangle_count = from->mesh.triangle_count },
                         .values = to->named,
                         .marks = to->marks };
    if (from->hide_front) to->marks[part->mark_count++] = "hide_front";
    if (from->hide_back) to->marks[part->mark_count++] = "hide_back";
    const bool behind = from->hide_front ? from->back != NULL : !from->front;
    const bool made = (!from->front || add_side(to, part, FRONT, from->front, ply)) &&
                      (!from->back || add_side(to, part, BACK, from->back, ply)) &&
                      (!from->blur || add_blur(to, part, from->blur, ply)) &&
                      add_colours(to, part, behind ? from->back : from->front);
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the values of a diffusion surface");
}

pith_status pith_diffusion_surfaces_write(const pith_diffusion_surface *surfaces, size_t count, const char *path,
                                          pith_error *err)
{
    if (!path || (count > 0 && !surfaces))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_surfaces_write: a pointer is NULL");
    written *rooms = pith_alloc(count, sizeof *rooms);
    pith_part *parts = pith_alloc(count, sizeof *parts);
    pith_status status = rooms && parts ? PITH_OK : PITH_OUT_OF_MEMORY(err, "diffusion surfaces");
    const bool ply = pith_path_has_extension(path, "ply");
    for (size_t i = 0; status == PITH_OK && i < count; ++i)
        status = make_part(&surfaces[i], i, ply, &rooms[i], &parts[i], err);
    if (status == PITH_OK) status = pith_parts_write(parts, count, path, err);
    for (size_t i = 0; rooms && i < count; ++i) written_free(&rooms[i]);
    pith_free(rooms);
    pith_free(parts);
    return status;
}
