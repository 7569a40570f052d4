/* Streamlines and arrows, in the whole body or on layers of depth. */
#include "field.h"

#include <string.h>

/* ---- places all over a layer or a body --------------------------------------------------------------------------- */

typedef struct places { pith_vec3 *points; size_t count, room; } places;

static pith_status add_place(places *to, pith_vec3 point, pith_error *err)
{
    if (!pith_grow((void **)&to->points, &to->room, to->count + 1, sizeof *to->points))
        return PITH_OUT_OF_MEMORY(err, "places");
    to->points[to->count++] = point;
    return PITH_OK;
}

/* Points of a surface at random, about `each` of area for one, at least one in every triangle. */
static pith_status places_of_mesh(const pith_mesh *mesh, double each, uint64_t seed, places *to, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    pith_rng rng = pith_rng_make(seed, 7);
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        const pith_vec3 a = view.positions[view.triangles[t][0]], b = view.positions[view.triangles[t][1]];
        const pith_vec3 c = view.positions[view.triangles[t][2]];
        const double area = 0.5 * pith_length(pith_cross(pith_sub(b, a), pith_sub(c, a)));
        const uint32_t count = 1 + (uint32_t)fmin(area / each, 1000.0);
        for (uint32_t i = 0; i < count; ++i) {
            const double root = sqrt(pith_rng_unit(&rng)), along = pith_rng_unit(&rng);
            PITH_TRY(add_place(to, pith_madd(pith_madd(a, pith_sub(b, a), root * (1.0 - along)), pith_sub(c, a),
                                             root * along), err));
        }
    }
    return PITH_OK;
}

/* Points of a grid that lie inside the body. */
static pith_status places_of_body(const field *from, double pitch, places *to, pith_error *err)
{
    const pith_vec3 extent = pith_sub(from->box.high, from->box.low);
    const int nx = 1 + (int)(extent.x / pitch), ny = 1 + (int)(extent.y / pitch), nz = 1 + (int)(extent.z / pitch);
    const pith_vec3 first = pith_madd(pith_lerp(from->box.low, from->box.high, 0.5),
                                      pith_v3(nx - 1, ny - 1, nz - 1), -0.5 * pitch);
    for (int z = 0; z < nz; ++z)
        for (int y = 0; y < ny; ++y)
            for (int x = 0; x < nx; ++x) {
                const pith_vec3 point = pith_madd(first, pith_v3(x, y, z), pitch);
                uint32_t tet;
                double weights[1][4];
                pith_locator_find(from->locator, &point, 1, 0.0, &tet, weights);
                if (tet != PITH_NONE) PITH_TRY(add_place(to, point, err));
            }
    return PITH_OK;
}

/* The middles of all tets: where streamlines may begin. */
static pith_status places_of_tets(const field *from, places *to, pith_error *err)
{
    for (uint32_t t = 0; t < from->view.tet_count; ++t) {
        pith_vec3 sum = { 0, 0, 0 };
        for (int k = 0; k < 4; ++k) sum = pith_add(sum, from->view.positions[from->view.tets[t][k]]);
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
typedef struct on_layer { const field *from; double level; } on_layer;

enum { BLOCK = 64 };
static const double layer_band = 0.06; /* of depth, to either side */

static void layer_sample(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const on_layer *on = user;
    const field *from = on->from;
    from->directions.sample(from->directions.user, points, count, vectors);
    for (size_t first = 0; first < count; first += BLOCK) {
        uint32_t tets[BLOCK];
        double weights[BLOCK][4];
        const size_t size = count - first < BLOCK ? count - first : BLOCK;
        pith_locator_find(from->locator, points + first, size, 0.0, tets, weights);
        for (size_t i = 0; i < size; ++i) {
            pith_vec3 *vector = &vectors[first + i], gradient = { 0, 0, 0 };
            double depth = 0.0;
            for (int k = 0; tets[i] != PITH_NONE && k < 4; ++k) {
                const uint32_t v = from->view.tets[tets[i]][k];
                depth += weights[i][k] * from->depth[v];
                gradient = pith_madd(gradient, from->gradient[v], weights[i][k]);
            }
            if (tets[i] == PITH_NONE || !(fabs(depth - on->level) < layer_band)) *vector = pith_v3(0, 0, 0);
            else *vector = pith_reject(*vector, pith_unit(gradient));
        }
    }
}

/* Lines drift off their layer a little; each point is moved back along the gradient. */
static pith_status snap(const field *from, double level, pith_polylines **lines, pith_error *err)
{
    const pith_polylines_view view = pith_polylines_look(*lines);
    const size_t count = view.start[view.line_count];
    pith_vec3 *points = pith_alloc(count, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "lines");
    memcpy(points, view.points, count * sizeof *points);
    for (size_t i = 0; i < count; ++i)
        for (int round = 0; round < 3; ++round) {
            uint32_t tet;
            double w[1][4], depth = 0.0;
            pith_vec3 gradient = { 0, 0, 0 };
            pith_locator_find(from->locator, &points[i], 1, INFINITY, &tet, w);
            for (int k = 0; k < 4; ++k) {
                const uint32_t v = from->view.tets[tet][k];
                depth += w[0][k] * from->depth[v];
                gradient = pith_madd(gradient, from->gradient[v], w[0][k]);
            }
            const double slope = pith_dot(gradient, gradient);
            if (!(slope > 0.0)) break;
            pith_vec3 step = pith_scale(gradient, (level - depth) / slope);
            const double most = 0.02 * from->diagonal;
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

static pith_status lines_of_layer(const field *from, field_layer *layer, pith_error *err)
{
    const pith_streamline_options *options = &from->asked->lines;
    const double spacing = options->spacing * from->diagonal;
    const on_layer on = { from, layer->level };
    const pith_directions tangent = { layer_sample, &on };
    places candidates = { 0 };
    pith_status status = layer->mesh ? places_of_mesh(layer->mesh, spacing * spacing, options->seed, &candidates, err)
                                     : places_of_tets(from, &candidates, err);
    if (status == PITH_OK)
        status = pith_streamlines(layer->mesh ? &tangent : &from->directions, candidates.points, candidates.count,
                                  options, cli_progress(), &layer->lines, err);
    if (status == PITH_OK && layer->mesh) status = snap(from, layer->level, &layer->lines, err);
    pith_free(candidates.points);
    return status;
}

static pith_status check_directions(const field *from, pith_error *err)
{
    if (!from->directions.sample)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "lines and arrows on layers follow strokes, and the document has neither "
                         "\"direction\" nor \"vectors\" for the body; the layers themselves go into .ply, .obj");
    if (from->layered && from->of == OF_PRIMARY)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "primary directions run across the layers; --of secondary, tertiary or "
                         "vectors have lines on a layer");
    return PITH_OK;
}

pith_status field_make_lines(field *to, pith_error *err)
{
    const double start = pith_seconds();
    PITH_TRY(check_directions(to, err));
    for (int i = 0; i < to->layer_count; ++i)
        if (!to->layers[i].lines) PITH_TRY(lines_of_layer(to, &to->layers[i], err));
    to->line_seconds = pith_seconds() - start;
    return PITH_OK;
}

/* ---- arrows ------------------------------------------------------------------------------------------------------ */

static const double arrow_pitch = 2.0; /* distance of arrows, in spacings of lines */

pith_status field_make_points(field *to, pith_error *err)
{
    const double start = pith_seconds(), pitch = arrow_pitch * to->asked->lines.spacing * to->diagonal;
    PITH_TRY(check_directions(to, err));
    for (int i = 0; i < to->layer_count; ++i) {
        field_layer *layer = &to->layers[i];
        const on_layer on = { to, layer->level };
        places at = { 0 };
        pith_status status = layer->mesh
                                 ? places_of_mesh(layer->mesh, pitch * pitch / 20, to->asked->lines.seed, &at, err)
                                 : places_of_body(to, pitch, &at, err);
        if (status == PITH_OK && at.count == 0)
            status = pith_fail(err, PITH_BAD_ARGUMENT, "arrows %g apart miss the body; a smaller --spacing sets more",
                               pitch);
        if (status == PITH_OK && layer->mesh) status = thin(&at, 0.8 * pitch, err);
        layer->points = at.points;
        layer->count = at.count;
        if (status == PITH_OK && !(layer->vectors = pith_alloc(at.count, sizeof *layer->vectors)))
            status = PITH_OUT_OF_MEMORY(err, "arrows");
        PITH_TRY(status);
        if (layer->mesh) layer_sample(&on, at.points, at.count, layer->vectors);
        else to->directions.sample(to->directions.user, at.points, at.count, layer->vectors);
        for (size_t k = 0; k < at.count; ++k) layer->vectors[k] = pith_unit(layer->vectors[k]);
    }
    to->line_seconds = pith_seconds() - start;
    return PITH_OK;
}

/* ---- colours ----------------------------------------------------------------------------------------------------- */

static bool by_depth(const field *from)
{
    return from->asked->colour == COLOUR_DEPTH || (from->asked->colour == COLOUR_DEFAULT && from->depth);
}

/* Depth, or the direction with x red, y green, z blue. */
static void colour_of(const field *from, double depth, pith_vec3 direction, float colour[3])
{
    const pith_vec3 unit = pith_unit(direction);
    const double parts[3] = { fabs(unit.x), fabs(unit.y), fabs(unit.z) };
    if (by_depth(from)) field_palette(depth, colour);
    else for (int c = 0; c < 3; ++c) colour[c] = pith_srgb_decode(0.15 + 0.85 * parts[c]);
}

pith_status field_all_lines(const field *from, pith_polylines **lines, float (**colours)[3], pith_error *err)
{
    size_t points = 0, count = 0, at = 0, line = 0;
    for (int i = 0; i < from->layer_count; ++i) {
        const pith_polylines_view view = pith_polylines_look(from->layers[i].lines);
        points += view.start[view.line_count];
        count += view.line_count;
    }
    pith_vec3 *all = pith_alloc(points, sizeof *all);
    uint32_t *start = pith_alloc(count + 1, sizeof *start);
    double *depths = pith_alloc(points, sizeof *depths);
    float (*made)[3] = pith_alloc(count, sizeof *made);
    pith_status status = all && start && depths && made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "lines");
    for (int i = 0; status == PITH_OK && i < from->layer_count; ++i) {
        const pith_polylines_view view = pith_polylines_look(from->layers[i].lines);
        const size_t size = view.start[view.line_count];
        memcpy(all + at, view.points, size * sizeof *all);
        for (uint32_t l = 0; l < view.line_count; ++l) start[++line] = (uint32_t)(at + view.start[l + 1]);
        at += size;
    }
    if (status == PITH_OK) status = field_depths(from, all, points, depths, err);
    for (line = 0; status == PITH_OK && line < count; ++line) {
        double depth = 0.0;
        for (uint32_t p = start[line]; p < start[line + 1]; ++p) depth += depths[p] / (start[line + 1] - start[line]);
        colour_of(from, depth, pith_sub(all[start[line + 1] - 1], all[start[line]]), made[line]);
    }
    if (status == PITH_OK)
        status = pith_polylines_create(&(pith_polylines_view){ all, start, (uint32_t)count }, lines, err);
    pith_free(all);
    pith_free(start);
    pith_free(depths);
    if (status == PITH_OK) *colours = made;
    else pith_free(made);
    return status;
}

/* The mesh with a colour at every vertex, by the field there; dark on layers, so that lines show on them. */
static pith_status colour_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err)
{
    pith_mesh_view view = pith_mesh_look(*mesh);
    float (*colours)[4] = pith_alloc(view.vertex_count, sizeof *colours);
    double *depths = pith_alloc(view.vertex_count, sizeof *depths);
    pith_vec3 *vectors = pith_alloc(view.vertex_count, sizeof *vectors);
    pith_mesh *coloured = NULL;
    pith_status status = colours && depths && vectors ? PITH_OK : PITH_OUT_OF_MEMORY(err, "colours");
    if (status == PITH_OK) status = field_depths(from, view.positions, view.vertex_count, depths, err);
    if (status == PITH_OK) from->directions.sample(from->directions.user, view.positions, view.vertex_count, vectors);
    for (uint32_t v = 0; status == PITH_OK && v < view.vertex_count; ++v) {
        /* Tubes stand out of the body a little, where the field is zero: the neighbour on the ring is near enough. */
        if (v > 0 && !(pith_length(vectors[v]) > 0.0)) vectors[v] = vectors[v - 1];
        colour_of(from, depths[v], vectors[v], colours[v]);
        for (int c = 0; layer->mesh && c < 3; ++c) colours[v][c] *= 0.25f;
        colours[v][3] = 1.0f;
    }
    view.colours = (const float (*)[4])colours;
    if (status == PITH_OK) status = pith_mesh_create(&view, &coloured, err);
    pith_free(colours);
    pith_free(depths);
    pith_free(vectors);
    if (status != PITH_OK) return status;
    pith_mesh_destroy(*mesh);
    *mesh = coloured;
    return PITH_OK;
}

pith_status field_line_mesh(const field *from, const field_layer *layer, pith_mesh **mesh, pith_error *err)
{
    const double spacing = from->asked->lines.spacing * from->diagonal;
    pith_mesh *made = NULL;
    if (layer->vectors) {
        const double length = 0.8 * arrow_pitch * spacing;
        pith_vec3 *tails = pith_alloc(layer->count, sizeof *tails); /* arrows lie with their middle at their place */
        if (!tails) return PITH_OUT_OF_MEMORY(err, "arrows");
        for (size_t i = 0; i < layer->count; ++i)
            tails[i] = pith_madd(layer->points[i], layer->vectors[i], -0.5 * length);
        const pith_status status = pith_glyphs(tails, layer->vectors, layer->count, length, &made, err);
        pith_free(tails);
        PITH_TRY(status);
    } else {
        PITH_TRY(pith_polylines_tubes(layer->lines, from->asked->radius * spacing, 8, &made, err));
    }
    const pith_status status = colour_mesh(from, layer, &made, err);
    if (status == PITH_OK) *mesh = made;
    else pith_mesh_destroy(made);
    return status;
}
