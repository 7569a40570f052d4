/* The packets `view` and `section`: the shells of all parts, as a graphics card takes them. Vertices and triangles of
   all parts lie behind one another; a part says which are its own. */
#include "pack_internal.h"

#include <string.h>

static const double crease = 40.0; /* edges that bend more stay sharp, degrees */

/* The shells a packet is about. */
typedef struct pack_scene {
    pack_piece *pieces;             /* [count] */
    size_t count, vertices, triangles;
    bool has_depth, moved;
} pack_scene;

/* ---- gathering --------------------------------------------------------------------------------------------------- */

static pith_status scene_make(pack_scene *scene, size_t count, pith_error *err)
{
    *scene = (pack_scene){ .pieces = pith_alloc(count + 1, sizeof *scene->pieces) };
    return scene->pieces ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a view");
}

static void scene_clear(pack_scene *scene)
{
    for (size_t i = 0; i < scene->count; ++i) pith_free(scene->pieces[i].weights);
    pith_free(scene->pieces);
}

/* The depth field of a body, where it is built; NULL without one. */
static const double *depth_of(pith_model *body)
{
    const double *depth = NULL;
    if (!pith_model_built(body).fields || pith_model_fields(body, &depth, NULL, NULL, NULL) != PITH_OK) return NULL;
    return depth;
}

/* Takes a piece in; with a shell it has triangles and their weights. */
static pith_status scene_add(pack_scene *scene, const pack_piece *piece, pith_error *err)
{
    pack_piece *to = &scene->pieces[scene->count++];
    *to = *piece;
    if (!to->shell) return PITH_OK;
    to->view = pith_shell_look(to->shell);
    to->weights = pith_alloc((size_t)to->view.triangle_count + 1, sizeof *to->weights);
    if (!to->weights) return PITH_OUT_OF_MEMORY(err, "a view");
    pith_shell_weights(to->shell, to->weights);
    scene->vertices += to->view.vertex_count;
    scene->triangles += to->view.triangle_count;
    scene->has_depth = scene->has_depth || depth_of(to->body);
    scene->moved = scene->moved || memcmp(to->view.positions, to->view.material,
                                          to->view.vertex_count * sizeof *to->view.positions) != 0;
    return PITH_OK;
}

/* ---- arrays ------------------------------------------------------------------------------------------------------ */

static void put_points(packet_maker *maker, const char *name, const pack_scene *scene, bool material)
{
    float *to = packet_room(maker, name, PACKET_F32, scene->vertices * 3);
    for (size_t p = 0; to && p < scene->count; ++p) {
        const pith_shell_view *view = &scene->pieces[p].view;
        const pith_vec3 *from = material ? view->material : view->positions;
        for (uint32_t v = 0; v < view->vertex_count; ++v) {
            *to++ = (float)from[v].x;
            *to++ = (float)from[v].y;
            *to++ = (float)from[v].z;
        }
    }
}

static void put_triangles(packet_maker *maker, const pack_scene *scene)
{
    uint32_t *corners = packet_room(maker, "corners", PACKET_U32, scene->triangles * 3), first = 0;
    uint8_t *kinds = packet_room(maker, "kinds", PACKET_U8, scene->triangles);
    for (size_t p = 0; corners && kinds && p < scene->count; ++p) {
        const pith_shell_view *view = &scene->pieces[p].view;
        for (uint32_t t = 0; t < view->triangle_count; ++t)
            for (int k = 0; k < 3; ++k) *corners++ = first + view->triangles[t][k];
        if (view->triangle_count) memcpy(kinds, view->kinds, view->triangle_count);
        kinds += view->triangle_count;
        first += view->vertex_count;
    }
}

/* Octahedral coordinates of a unit vector as 16-bit numbers (Cigolle et al., "Survey of Efficient Representations for
   Independent Unit Vectors", JCGT 2014). */
static void fold(pith_vec3 n, int16_t to[2])
{
    const double sum = fabs(n.x) + fabs(n.y) + fabs(n.z), scale = sum > 0.0 ? 1.0 / sum : 0.0;
    double x = n.x * scale, y = n.y * scale;
    if (n.z < 0.0) {
        const double u = (1.0 - fabs(y)) * (x >= 0.0 ? 1.0 : -1.0), v = (1.0 - fabs(x)) * (y >= 0.0 ? 1.0 : -1.0);
        x = u, y = v;
    }
    to[0] = (int16_t)lrint(x * 32767.0);
    to[1] = (int16_t)lrint(y * 32767.0);
}

static pith_status put_normals(packet_maker *maker, const pack_scene *scene, pith_error *err)
{
    int16_t(*to)[3][2] = packet_room(maker, "normals", PACKET_I16, scene->triangles * 6);
    pith_vec3(*normals)[3] = pith_alloc(scene->triangles + 1, sizeof *normals);
    pith_status status = normals ? PITH_OK : PITH_OUT_OF_MEMORY(err, "normals");
    for (size_t p = 0; status == PITH_OK && to && p < scene->count; ++p) {
        const pack_piece *piece = &scene->pieces[p];
        const uint32_t count = piece->view.triangle_count;
        if (!piece->shell) continue;
        status = pith_shell_normals(piece->shell, crease, normals, err);
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
        for (uint32_t t = 0; t < count; ++t)
            for (int k = 0; k < 3; ++k) fold(normals[t][k], to[t][k]);
        to += count;
    }
    pith_free(normals);
    return status;
}

/* Depth at the vertices: the field's, mixed in the tet of some triangle round each. */
static pith_status put_depths(packet_maker *maker, const pack_scene *scene, pith_error *err)
{
    json_object_set_new(packet_text(maker), "depth", json_boolean(scene->has_depth));
    if (!scene->has_depth) return PITH_OK;
    uint16_t *to = packet_room(maker, "depth", PACKET_U16, scene->vertices);
    for (size_t p = 0; to && p < scene->count; ++p) {
        const pack_piece *piece = &scene->pieces[p];
        const pith_shell_view *view = &piece->view;
        const pith_tets *tets;
        const double *depth = piece->shell ? depth_of(piece->body) : NULL;
        if (depth) PITH_TRY(pith_model_tets(piece->body, &tets, NULL, err));
        for (uint32_t t = 0; depth && t < view->triangle_count; ++t) {
            const uint32_t *corners = pith_tets_look(tets).tets[view->source_tet[t]];
            for (int k = 0; k < 3; ++k) {
                double sum = 0.0;
                for (int c = 0; c < 4; ++c) sum += piece->weights[t][k][c] * depth[corners[c]];
                to[view->triangles[t][k]] = (uint16_t)lrint(fmin(fmax(sum, 0.0), 1.0) * 65535.0);
            }
        }
        to += view->vertex_count;
    }
    return PITH_OK;
}

/* The face of its tet that a triangle of the skin lies on: that across from the corner it has no part of. */
static uint32_t face_of(const double weights[3][4], const uint32_t faces[4])
{
    double least = 1e-6;
    uint32_t found = PITH_NONE;
    for (int k = 0; k < 4; ++k) {
        const double most = fmax(fabs(weights[0][k]), fmax(fabs(weights[1][k]), fabs(weights[2][k])));
        if (faces[k] == PITH_NONE || !(most <= least)) continue;
        least = most;
        found = faces[k];
    }
    return found;
}

static pith_status put_faces(packet_maker *maker, const pack_scene *scene, pith_error *err)
{
    uint32_t *to = packet_room(maker, "faces", PACKET_U32, scene->triangles);
    for (size_t p = 0; to && p < scene->count; ++p) {
        const pack_piece *piece = &scene->pieces[p];
        const uint32_t(*faces)[4] = NULL;
        if (piece->shell) PITH_TRY(pith_model_surface_faces(piece->body, &faces, err));
        for (uint32_t t = 0; t < piece->view.triangle_count; ++t)
            *to++ = piece->view.kinds[t] == PITH_SKIN
                        ? face_of((const double(*)[4])piece->weights[t], faces[piece->view.source_tet[t]])
                        : PITH_NONE;
    }
    return PITH_OK;
}

static void put_parts(packet_maker *maker, const pack_scene *scene)
{
    json_t *list = json_array();
    json_int_t vertex = 0, triangle = 0;
    pith_box box = pith_box_empty();
    for (size_t p = 0; p < scene->count; ++p) {
        const pack_piece *piece = &scene->pieces[p];
        const json_int_t vertices = piece->view.vertex_count, triangles = piece->view.triangle_count;
        json_array_append_new(list, json_pack("{sI so sb so s[II] s[II]}", "body", (json_int_t)piece->body_index, "offset",
                                              pack_point(piece->offset), "hidden", piece->hidden, "inside",
                                              pack_point(piece->inside), "triangles", triangle, triangles, "vertices",
                                              vertex, vertices));
        for (uint32_t v = 0; v < piece->view.vertex_count; ++v)
            pith_box_add(&box, pith_add(piece->view.positions[v], piece->offset));
        vertex += vertices;
        triangle += triangles;
    }
    json_object_set_new(packet_text(maker), "parts", list);
    json_object_set_new(packet_text(maker), "box", pack_box(&box));
}

static pith_status finish(const char *kind, const pack_scene *scene, const pack_stamp *stamp, double cut, packet **made,
                          pith_error *err)
{
    const double start = pith_seconds();
    packet_maker *maker = packet_begin(kind);
    pack_stamped(maker, stamp);
    json_object_set_new(packet_text(maker), "revision", json_integer((json_int_t)stamp->revision));
    put_parts(maker, scene);
    put_points(maker, "positions", scene, false);
    if (scene->moved) put_points(maker, "material", scene, true);
    put_triangles(maker, scene);
    pith_status status = put_normals(maker, scene, err);
    if (status == PITH_OK) status = put_depths(maker, scene, err);
    if (status == PITH_OK) status = put_faces(maker, scene, err);
    if (status == PITH_OK) status = pack_layers(maker, scene->pieces, scene->count, scene->triangles, err);
    json_object_set_new(packet_text(maker), "seconds",
                        json_pack("{sf sf}", "cut", cut, "pack", pith_seconds() - start));
    if (status == PITH_OK) return packet_finish(maker, made, err);
    packet_abandon(maker);
    return status;
}

/* ---- the view ---------------------------------------------------------------------------------------------------- */

pith_status pack_view(pith_model *model, const pack_stamp *stamp, packet **made, pith_error *err)
{
    const double start = pith_seconds();
    const pith_model_piece *from;
    size_t count;
    /* Displaced skins need the solids: until those are built, the bodies show as they were cut. */
    PITH_TRY(pith_model_pieces(model, pith_model_built(model).solid, &from, &count, err));
    const double cut = pith_seconds() - start;
    pack_scene scene;
    pith_status status = scene_make(&scene, count, err);
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        pack_piece piece = { .body_index = from[i].body, .shell = from[i].hidden ? NULL : from[i].shell,
                             .offset = from[i].offset, .inside = from[i].inside, .hidden = from[i].hidden };
        status = pith_model_body(model, from[i].body, &piece.body, err);
        if (status == PITH_OK) status = scene_add(&scene, &piece, err);
    }
    if (status == PITH_OK) status = finish("view", &scene, stamp, cut, made, err);
    scene_clear(&scene);
    return status;
}

/* ---- a section --------------------------------------------------------------------------------------------------- */

pith_status pack_section(pith_model *model, const pith_plane *plane, const pack_stamp *stamp, packet **made,
                         pith_error *err)
{
    const double start = pith_seconds();
    pith_model_piece *from = NULL;
    size_t count = 0;
    PITH_TRY(pith_model_section(model, plane, &from, &count, err));
    const double cut = pith_seconds() - start;
    pack_scene scene;
    pith_status status = scene_make(&scene, count, err);
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        pack_piece piece = { .body_index = from[i].body, .shell = from[i].shell, .offset = from[i].offset };
        status = pith_model_body(model, piece.body_index, &piece.body, err);
        if (status == PITH_OK) status = scene_add(&scene, &piece, err);
    }
    if (status == PITH_OK) status = finish("section", &scene, stamp, cut, made, err);
    scene_clear(&scene);
    pith_sections_free(from, count);
    return status;
}
