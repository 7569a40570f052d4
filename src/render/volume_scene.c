/* Bodies made ready for volume rendering: in camera space, with neighbours, and sorted into the tiles they cover. */
#include "volume_internal.h"

/* ---- bodies ----------------------------------------------------------------------------------------------------- */

static pith_status body_make(volume_scene *scene, volume_body *body, const pith_volume_item *item, pith_error *err)
{
    body->part = pith_part_look(item->part);
    body->solid = item->solid;
    body->model = pith_part_model_box(item->part);
    body->eye = pith_alloc(body->part.vertex_count, sizeof *body->eye);
    body->weights = pith_alloc(body->part.tet_count, sizeof *body->weights);
    if (!body->eye || !body->weights) return PITH_OUT_OF_MEMORY(err, "a body in camera space");

    const pith_vec3 right = pith_unit(scene->view.right), up = pith_unit(scene->view.up);
    const pith_vec3 eye = pith_sub(scene->view.eye, item->offset);
    body->nearest = INFINITY;
    body->farthest = -INFINITY;
    for (uint32_t i = 0; i < body->part.vertex_count; ++i) {
        const pith_vec3 p = pith_sub(body->part.positions[i], eye);
        body->eye[i] = pith_v3(pith_dot(p, right), -pith_dot(p, up), pith_dot(p, scene->view.forward));
        body->nearest = fmin(body->nearest, body->eye[i].z);
        body->farthest = fmax(body->farthest, body->eye[i].z);
    }
    pith_part_weights(item->part, body->weights);
    if (scene->channels < pith_solid_channels(item->solid)) scene->channels = pith_solid_channels(item->solid);
    return PITH_OK;
}

/* ---- neighbours ------------------------------------------------------------------------------------------------- */

/* Corners of the face opposite corner k in ascending order. */
static void face_key(const uint32_t tet[4], unsigned k, uint32_t key[3])
{
    int n = 0;
    for (unsigned c = 0; c < 4; ++c)
        if (c != k) key[n++] = tet[c];
    if (key[0] > key[1]) { const uint32_t swap = key[0]; key[0] = key[1]; key[1] = swap; }
    if (key[1] > key[2]) { const uint32_t swap = key[1]; key[1] = key[2]; key[2] = swap; }
    if (key[0] > key[1]) { const uint32_t swap = key[0]; key[0] = key[1]; key[1] = swap; }
}

/* Faces meet in a hash table with open addresses: a slot holds 1 + 4 tet + corner of a face still without partner; a
   pair keeps its slot, so that no other face's search ends early. */
static pith_status find_neighbours(volume_body *body, pith_error *err)
{
    const uint32_t (*tets)[4] = body->part.tets;
    size_t size = 16;
    while (size < 6 * (size_t)body->part.tet_count) size *= 2;
    uint64_t *slots = pith_alloc(size, sizeof *slots);
    body->neighbours = pith_alloc(body->part.tet_count, sizeof *body->neighbours);
    if (!slots || !body->neighbours) {
        pith_free(slots);
        return PITH_OUT_OF_MEMORY(err, "a body's neighbours");
    }
    for (uint32_t t = 0; t < body->part.tet_count; ++t)
        for (unsigned k = 0; k < 4; ++k) {
            uint32_t key[3], other[3];
            face_key(tets[t], k, key);
            body->neighbours[t][k] = PITH_NONE;
            size_t at = pith_mix64((uint64_t)key[0] << 32 ^ (uint64_t)key[1] << 16 ^ key[2]) & (size - 1);
            for (; slots[at]; at = (at + 1) & (size - 1)) {
                const uint32_t tet = (uint32_t)((slots[at] - 1) / 4);
                const unsigned corner = (slots[at] - 1) % 4;
                face_key(tets[tet], corner, other);
                if (key[0] != other[0] || key[1] != other[1] || key[2] != other[2]) continue;
                if (body->neighbours[tet][corner] != PITH_NONE) continue;
                body->neighbours[tet][corner] = t;
                body->neighbours[t][k] = tet;
                break;
            }
            if (!slots[at]) slots[at] = 1 + 4 * (uint64_t)t + k;
        }
    pith_free(slots);
    return PITH_OK;
}

/* ---- bins ------------------------------------------------------------------------------------------------------- */

/* right and bottom are beyond the last; empty: left == right */
typedef struct tile_box { uint32_t left, right, top, bottom; } tile_box;

/* The first tile, and the one beyond the last, that pixels low .. high reach. */
static void tile_range(double low, double high, uint32_t tiles, uint32_t *first, uint32_t *end)
{
    const double from = floor(low / RENDER_TILE), to = floor(high / RENDER_TILE) + 1.0;
    *first = !(from > 0.0) ? 0 : from >= tiles ? tiles : (uint32_t)from;
    *end = !(to > 0.0) ? 0 : to >= tiles ? tiles : (uint32_t)to;
}

/* Tiles that the lines through the eye and the corners' hull cross. What reaches up to the eye's plane covers any. */
static tile_box tiles_of(const volume_scene *scene, const volume_body *body, volume_element e, bool face)
{
    const tile_box none = { 0, 0, 0, 0 }, all = { 0, scene->tiles_wide, 0, scene->tiles_high };
    double left = INFINITY, right = -INFINITY, top = INFINITY, bottom = -INFINITY, near = INFINITY, far = -INFINITY;
    for (uint32_t c = 0; c < 4; ++c) {
        if (face && c == e.corner) continue;
        const pith_vec3 p = body->eye[body->part.tets[e.tet][c]];
        near = fmin(near, p.z), far = fmax(far, p.z);
        left = fmin(left, p.x / p.z), right = fmax(right, p.x / p.z);
        top = fmin(top, p.y / p.z), bottom = fmax(bottom, p.y / p.z);
    }
    if (!face && volume_planes_to(scene, 0.5, near) == volume_planes_to(scene, 0.5, far)) return none;
    const double zero = 1e-6 * scene->step;
    if (!(near > zero || (face && far < -zero))) return all;
    /* Rays may be placed anywhere in a pixel and half a pixel round it. */
    const double pixels = 1.0 / scene->pixel, x = 0.5 * scene->options->width, y = 0.5 * scene->options->height;
    tile_box box;
    tile_range(x + pixels * left - 1.5, x + pixels * right + 1.5, scene->tiles_wide, &box.left, &box.right);
    tile_range(y + pixels * top - 1.5, y + pixels * bottom + 1.5, scene->tiles_high, &box.top, &box.bottom);
    return box;
}

/* Counts (items NULL) or lists the element in the bins of its tiles. */
static void bin_element(volume_scene *scene, volume_element e, bool face, uint32_t *at, volume_element *items)
{
    const tile_box box = tiles_of(scene, &scene->bodies[e.body], e, face);
    for (uint32_t y = box.top; y < box.bottom; ++y)
        for (uint32_t x = box.left; x < box.right; ++x) {
            const size_t tile = (size_t)y * scene->tiles_wide + x;
            if (items) items[at[tile]] = e;
            ++at[tile];
        }
}

static void bin_all(volume_scene *scene, uint32_t *at, volume_element *items)
{
    for (uint32_t b = 0; b < scene->body_count; ++b) {
        const volume_body *body = &scene->bodies[b];
        if (!(body->farthest > 0.0)) continue;
        for (uint32_t t = 0; t < body->part.tet_count; ++t) {
            if (!body->neighbours) bin_element(scene, (volume_element){ b, t, 0 }, false, at, items);
            for (uint32_t k = 0; body->neighbours && k < 4; ++k)
                if (body->neighbours[t][k] == PITH_NONE)
                    bin_element(scene, (volume_element){ b, t, k }, true, at, items);
        }
    }
}

static pith_status fill_bins(volume_scene *scene, pith_error *err)
{
    const size_t tiles = (size_t)scene->tiles_wide * scene->tiles_high;
    scene->bin_start = pith_alloc(tiles + 1, sizeof *scene->bin_start);
    uint32_t *next = pith_alloc(tiles, sizeof *next);
    if (!scene->bin_start || !next) goto no_memory;
    bin_all(scene, next, NULL);
    size_t sum = 0;
    for (size_t i = 0; i < tiles; ++i) {
        scene->bin_start[i] = (uint32_t)sum;
        sum += next[i];
        next[i] = scene->bin_start[i];
    }
    if (sum >= PITH_NONE) goto no_memory;
    scene->bin_start[tiles] = (uint32_t)sum;
    scene->bins = pith_alloc(sum, sizeof *scene->bins);
    if (!scene->bins) goto no_memory;
    bin_all(scene, next, scene->bins);
    pith_free(next);
    return PITH_OK;
no_memory:
    pith_free(next);
    return PITH_OUT_OF_MEMORY(err, "what each tile meets");
}

/* ---- the scene -------------------------------------------------------------------------------------------------- */

/* Planes through the depth of everything before the eye; the unit from the size of the models in themselves, so that
   bodies moved apart, or the pieces of one that was cut, are as dense as before. */
static void place_planes(volume_scene *scene)
{
    double near = INFINITY, far = -INFINITY;
    pith_box box = pith_box_empty();
    for (uint32_t b = 0; b < scene->body_count; ++b) {
        const volume_body *body = &scene->bodies[b];
        near = fmin(near, body->nearest);
        far = fmax(far, body->farthest);
        pith_box_add(&box, body->model.low);
        pith_box_add(&box, body->model.high);
    }
    scene->near = fmax(near, 0.0);
    scene->step = (far - scene->near) / scene->options->slices; /* not positive: all is behind the eye, and not drawn */
    scene->unit = scene->options->unit * pith_distance(box.low, box.high);
}

void volume_scene_free(volume_scene *scene)
{
    for (uint32_t i = 0; scene->bodies && i < scene->body_count; ++i) {
        pith_free(scene->bodies[i].eye);
        pith_free(scene->bodies[i].weights);
        pith_free(scene->bodies[i].neighbours);
    }
    pith_free(scene->bodies);
    pith_free(scene->bin_start);
    pith_free(scene->bins);
    *scene = (volume_scene){ 0 };
}

pith_status volume_scene_make(volume_scene *scene, const pith_volume_item *items, size_t count,
                              const pith_camera *camera, pith_error *err)
{
    pith_status status = PITH_OK;
    const pith_volume_options *o = scene->options;
    const double light[2] = { o->light_azimuth, o->light_elevation };
    PITH_TRY(render_view_make(&scene->view, camera, o->height, light, err));
    scene->pixel = pith_length(scene->view.up);
    scene->gain = exp2(o->exposure);
    scene->background[0] = (double)pith_srgb_decode(o->background_red);
    scene->background[1] = (double)pith_srgb_decode(o->background_green);
    scene->background[2] = (double)pith_srgb_decode(o->background_blue);
    scene->tiles_wide = (o->width + RENDER_TILE - 1) / RENDER_TILE;
    scene->tiles_high = (o->height + RENDER_TILE - 1) / RENDER_TILE;
    scene->bodies = pith_alloc(count, sizeof *scene->bodies);
    if (!scene->bodies) return PITH_OUT_OF_MEMORY(err, "bodies");
    scene->body_count = (uint32_t)count;
    for (size_t i = 0; i < count; ++i) {
        PITH_TRY_OR(failed, body_make(scene, &scene->bodies[i], &items[i], err));
        if (o->method == PITH_VOLUME_MARCH) PITH_TRY_OR(failed, find_neighbours(&scene->bodies[i], err));
    }
    place_planes(scene);
    PITH_TRY_OR(failed, fill_bins(scene, err));
    return PITH_OK;
failed:
    volume_scene_free(scene);
    return status;
}
