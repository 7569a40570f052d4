/* Streamlines and arrows, in the whole body, on layers of depth, or on what is seen. */
#include "look_internal.h"

#include <string.h>

/* ---- places all over a body -------------------------------------------------------------------------------------- */

typedef struct places { pith_vec3 *points; size_t count, room; } places;

static pith_status add_place(places *to, pith_vec3 point, pith_error *err)
{
    if (!pith_grow((void **)&to->points, &to->room, to->count + 1, sizeof *to->points))
        return PITH_OUT_OF_MEMORY(err, "places");
    to->points[to->count++] = point;
    return PITH_OK;
}

/* Points of a grid that lie inside the body. */
static pith_status places_of_body(const pith_look *look, double pitch, places *to, pith_error *err)
{
    const pith_box *box = &look->view.box;
    const pith_vec3 extent = pith_sub(box->high, box->low);
    const int nx = 1 + (int)(extent.x / pitch), ny = 1 + (int)(extent.y / pitch), nz = 1 + (int)(extent.z / pitch);
    const pith_vec3 first = pith_madd(pith_lerp(box->low, box->high, 0.5), pith_v3(nx - 1, ny - 1, nz - 1),
                                      -0.5 * pitch);
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                const pith_vec3 point = pith_madd(first, pith_v3(x, y, z), pitch);
                uint32_t tet;
                double weights[1][4];
                pith_locator_find(look->view.locator, &point, 1, 0.0, &tet, weights);
                if (tet != PITH_NONE) PITH_TRY(add_place(to, point, err));
            }
    return PITH_OK;
}

/* The middles of all tets: where streamlines may begin. */
static pith_status places_of_tets(const pith_look *look, places *to, pith_error *err)
{
    for (uint32_t t = 0; t < look->tets.tet_count; ++t) {
        pith_vec3 sum = { 0, 0, 0 };
        for (int k = 0; k < 4; ++k) sum = pith_add(sum, look->tets.positions[look->tets.tets[t][k]]);
        PITH_TRY(add_place(to, pith_scale(sum, 0.25), err));
    }
    return PITH_OK;
}

/* Keeps the first points of which none is nearer than `distance` to another, by a grid of cells of that size. */
static pith_status thin(places *from, double distance, pith_error *err)
{
    const pith_box box = pith_box_of(from->points, from->count);
    const pith_vec3 extent = pith_sub(box.high, box.low);
    const size_t n[3] = { 1 + (size_t)(extent.x / distance), 1 + (size_t)(extent.y / distance),
                          1 + (size_t)(extent.z / distance) };
    uint32_t *head = pith_alloc(n[0] * n[1] * n[2], sizeof *head), *next = pith_alloc(from->count, sizeof *next);
    if (!head || !next) {
        pith_free(head);
        pith_free(next);
        return PITH_OUT_OF_MEMORY(err, "arrows");
    }
    size_t kept = 0;
    for (size_t i = 0; i < from->count; ++i) {
        const pith_vec3 p = from->points[i], at = pith_scale(pith_sub(p, box.low), 1.0 / distance);
        const long c[3] = { (long)at.x, (long)at.y, (long)at.z };
        bool near = false;
        for (int o = 0; o < 27 && !near; ++o) {
            const long x = c[0] + o % 3 - 1, y = c[1] + o / 3 % 3 - 1, z = c[2] + o / 9 - 1;
            if (x < 0 || y < 0 || z < 0 || (size_t)x >= n[0] || (size_t)y >= n[1] || (size_t)z >= n[2]) continue;
            for (uint32_t k = head[((size_t)z * n[1] + (size_t)y) * n[0] + (size_t)x]; k && !near; k = next[k - 1])
                near = pith_distance(from->points[k - 1], p) < distance;
        }
        if (near) continue;
        uint32_t *cell = &head[((size_t)c[2] * n[1] + (size_t)c[1]) * n[0] + (size_t)c[0]];
        next[kept] = *cell;
        from->points[kept++] = p;
        *cell = (uint32_t)kept; /* one more than the index; 0 is none */
    }
    from->count = kept;
    pith_free(head);
    pith_free(next);
    return PITH_OK;
}

/* ---- directions on a layer --------------------------------------------------------------------------------------- */

/* The field tangent to the layers, and nothing far from one of them. */
typedef struct on_layer { const pith_look *look; double level; } on_layer;

enum { BLOCK = 64 };
static const double layer_band = 0.06; /* of depth, to either side */

static void layer_sample(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const on_layer *on = user;
    const pith_look_view *view = &on->look->view;
    view->directions.sample(view->directions.user, points, count, vectors);
    for (size_t first = 0; first < count; first += BLOCK) {
        uint32_t tets[BLOCK];
        double weights[BLOCK][4];
        const size_t size = count - first < BLOCK ? count - first : BLOCK;
        pith_locator_find(view->locator, points + first, size, 0.0, tets, weights);
        for (size_t i = 0; i < size; ++i) {
            pith_vec3 *vector = &vectors[first + i];
            const look_slope slope = look_slope_at(on->look, tets[i], weights[i]);
            if (tets[i] == PITH_NONE || !(fabs(slope.depth - on->level) < layer_band)) *vector = pith_v3(0, 0, 0);
            else *vector = pith_reject(*vector, pith_unit(slope.gradient));
        }
    }
}

/* Lines drift off their layer a little; each point is moved back along the gradient. */
static pith_status snap(const pith_look *look, double level, pith_polylines **lines, pith_error *err)
{
    const pith_polylines_view view = pith_polylines_look(*lines);
    const size_t count = view.start[view.line_count];
    pith_vec3 *points = pith_alloc(count, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "lines");
    memcpy(points, view.points, count * sizeof *points);
    for (size_t i = 0; i < count; ++i)
        for (int round = 0; round < 3; ++round) {
            uint32_t tet;
            double weights[1][4];
            pith_locator_find(look->view.locator, &points[i], 1, INFINITY, &tet, weights);
            const look_slope at = look_slope_at(look, tet, weights[0]);
            const double steep = pith_dot(at.gradient, at.gradient);
            if (!(steep > 0.0)) break;
            pith_vec3 step = pith_scale(at.gradient, (level - at.depth) / steep);
            const double most = 0.02 * look->diagonal;
            if (pith_length(step) > most) step = pith_scale(pith_unit(step), most);
            points[i] = pith_add(points[i], step);
        }
    pith_polylines *moved = NULL;
    const pith_status status =
        pith_polylines_create(&(pith_polylines_view){ points, view.start, view.line_count }, &moved, err);
    pith_free(points);
    if (status != PITH_OK) return status;
    pith_polylines_destroy(*lines);
    *lines = moved;
    return PITH_OK;
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static pith_status check_asked(const pith_look *look, const pith_look_place *place,
                               const pith_streamline_options *options, pith_error *err)
{
    PITH_TRY(pith_params_check(&pith_streamline_params, options, err));
    if (!look->view.directions.sample)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "lines and arrows on layers follow strokes, and the document has neither "
                         "\"direction\" nor \"vectors\" for the body; the layers themselves need none");
    if (place->kind == PITH_LOOK_LAYER && look->view.of == PITH_LOOK_PRIMARY)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "primary directions run across the layers; secondary, tertiary or "
                         "vectors have lines on a layer");
    return PITH_OK;
}

static pith_status lines_in_body(const pith_look *look, const pith_streamline_options *options,
                                 const pith_progress *progress, pith_polylines **lines, pith_error *err)
{
    places candidates = { 0 };
    pith_status status = places_of_tets(look, &candidates, err);
    if (status == PITH_OK)
        status = pith_streamlines(&look->view.directions, candidates.points, candidates.count, options, progress, lines,
                                  err);
    pith_free(candidates.points);
    return status;
}

static pith_status lines_on_layer(const pith_look *look, const pith_look_place *place,
                                  const pith_streamline_options *options, const pith_progress *progress,
                                  pith_polylines **lines, pith_error *err)
{
    const double spacing = options->spacing * look->diagonal;
    const on_layer on = { look, place->level };
    const pith_directions tangent = { layer_sample, &on };
    pith_vec3 *candidates = NULL;
    size_t count = 0;
    pith_polylines *made = NULL;
    PITH_TRY(pith_mesh_scatter(place->layer, spacing * spacing, options->seed, &candidates, &count, err));
    pith_status status = pith_streamlines(&tangent, candidates, count, options, progress, &made, err);
    if (status == PITH_OK) status = snap(look, place->level, &made, err);
    pith_free(candidates);
    if (status == PITH_OK) *lines = made;
    else pith_polylines_destroy(made);
    return status;
}

static pith_status lines_on_shell(const pith_look *look, const pith_look_place *place,
                                  const pith_streamline_options *options, const pith_progress *progress,
                                  pith_polylines **lines, pith_error *err)
{
    pith_surface_directions *on = NULL;
    PITH_TRY(look_on_shell(look, place->shell, place->kinds, &on, NULL, err));
    const pith_status status = pith_surface_streamlines(on, look->diagonal, options, progress, lines, err);
    pith_surface_directions_destroy(on);
    return status;
}

pith_status pith_look_lines(const pith_look *look, const pith_look_place *place,
                            const pith_streamline_options *options, const pith_progress *progress,
                            pith_polylines **lines, pith_error *err)
{
    PITH_TRY(check_asked(look, place, options, err));
    switch (place->kind) {
    case PITH_LOOK_LAYER: return lines_on_layer(look, place, options, progress, lines, err);
    case PITH_LOOK_SHELL: return lines_on_shell(look, place, options, progress, lines, err);
    default: return lines_in_body(look, options, progress, lines, err);
    }
}

/* ---- arrows ------------------------------------------------------------------------------------------------------ */

static pith_status arrows_in_body(const pith_look *look, double pitch, places *at, pith_vec3 **vectors, pith_error *err)
{
    PITH_TRY(places_of_body(look, pitch, at, err));
    if (at->count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "arrows %g apart miss the body; a smaller spacing sets more", pitch);
    *vectors = pith_alloc(at->count, sizeof **vectors);
    if (!*vectors) return PITH_OUT_OF_MEMORY(err, "arrows");
    look->view.directions.sample(look->view.directions.user, at->points, at->count, *vectors);
    return PITH_OK;
}

/* Scattered on a surface, no nearer to each other than a little less than the pitch. */
static pith_status arrows_on(const pith_mesh *surface, const pith_directions *directions, double pitch, uint64_t seed,
                             places *at, pith_vec3 **vectors, pith_error *err)
{
    PITH_TRY(pith_mesh_scatter(surface, pitch * pitch / 20, seed, &at->points, &at->count, err));
    if (at->count > 0) PITH_TRY(thin(at, 0.8 * pitch, err));
    *vectors = pith_alloc(at->count, sizeof **vectors);
    if (!*vectors) return PITH_OUT_OF_MEMORY(err, "arrows");
    directions->sample(directions->user, at->points, at->count, *vectors);
    return PITH_OK;
}

static pith_status arrows_on_shell(const pith_look *look, const pith_look_place *place, double pitch, uint64_t seed,
                                   places *at, pith_vec3 **vectors, pith_error *err)
{
    pith_surface_directions *on = NULL;
    pith_mesh *surface = NULL;
    PITH_TRY(look_on_shell(look, place->shell, place->kinds, &on, &surface, err));
    const pith_directions tangent = pith_directions_of_surface(on);
    const pith_status status = arrows_on(surface, &tangent, pitch, seed, at, vectors, err);
    pith_mesh_destroy(surface);
    pith_surface_directions_destroy(on);
    return status;
}

pith_status pith_look_arrows(const pith_look *look, const pith_look_place *place,
                             const pith_streamline_options *options, pith_vec3 **points, pith_vec3 **vectors,
                             size_t *count, pith_error *err)
{
    PITH_TRY(check_asked(look, place, options, err));
    const double pitch = PITH_LOOK_ARROWS_APART * options->spacing * look->diagonal;
    const on_layer on = { look, place->level };
    const pith_directions tangent = { layer_sample, &on };
    places at = { 0 };
    pith_vec3 *made = NULL;
    pith_status status = PITH_OK;
    switch (place->kind) {
    case PITH_LOOK_LAYER: status = arrows_on(place->layer, &tangent, pitch, options->seed, &at, &made, err); break;
    case PITH_LOOK_SHELL: status = arrows_on_shell(look, place, pitch, options->seed, &at, &made, err); break;
    default: status = arrows_in_body(look, pitch, &at, &made, err);
    }
    if (status != PITH_OK) {
        pith_free(at.points);
        pith_free(made);
        return status;
    }
    for (size_t k = 0; k < at.count; ++k) made[k] = pith_unit(made[k]);
    *points = at.points;
    *vectors = made;
    *count = at.count;
    return PITH_OK;
}
