/* Parts of a surface erased: what lies on one side of a plane, of a stroke over the picture, or of a curve that is drawn
   in one of the two panes.

   Source: Takayama's thesis (2011), §6.3.1 "Partial Deletion", which asks for the stroke alone.

   Each erase is a scalar of space, and its zero is found on the edges themselves: values at their ends tell which are
   crossed, and then the crossing is searched along the edge, so that new vertices lie on what was drawn however curved it
   is and however long the edges are. Signs of vertices, -1, 0 or 1, alone decide the topology: triangles that share an
   edge agree about it. */
#include "surface_internal.h"

#include <string.h>

/* A crossing nearer than this to an edge's end, as a fraction of its length, goes through the end: slivers would be of
   no use to what is computed on the surface, and the border is off by less than anyone sees. */
static const double near_end = 1e-4;
/* Of the mesh's diagonal: as far as values are rounding, and as far as a crossing may be from the zero. */
static const double rounding = 1e-12, found_near = 1e-10;

enum { CURVE_SAMPLES = 513, MOST_STEPS = 40 };

/* ---- the scalar of an erase ---------------------------------------------------------------------------------------------- */

typedef struct scalar {
    const pith_erase *erase;
    pith_vec2 *samples;      /* [CURVE_SAMPLES] of a pane's curve */
    pith_cut_scalar *stroke; /* of a stroke, continued to the outline of the mesh as it was given */
} scalar;

static pith_status plane_values(const pith_plane *plane, const pith_vec3 *points, size_t count, double *values,
                                pith_error *err)
{
    const pith_vec3 n = pith_unit(plane->normal);
    if (!pith_finite(plane->point) || !(pith_length(n) > 0.5))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the plane through (%g, %g, %g) has the normal (%g, %g, %g); both must be "
                         "finite and the normal longer than 0",
                         plane->point.x, plane->point.y, plane->point.z, plane->normal.x, plane->normal.y,
                         plane->normal.z);
    for (size_t i = 0; i < count; ++i) values[i] = pith_dot(n, pith_sub(points[i], plane->point));
    return PITH_OK;
}

static pith_status pane_values(const scalar *s, const pith_vec3 *points, size_t count, double *values, pith_error *err)
{
    const bool vertical = s->erase->kind == PITH_ERASE_VERTICAL, closed = s->erase->curve.closed;
    pith_vec2 *seen = pith_alloc(count, sizeof *seen);
    if (!seen) return PITH_OUT_OF_MEMORY(err, "points in a pane");
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 p = points[i];
        seen[i] = vertical ? (pith_vec2){ hypot(p.x, p.y), p.z } : (pith_vec2){ p.x, p.y };
    }
    const pith_status status = pith_cut_curve_distances(s->samples, CURVE_SAMPLES, closed, seen, count, values, err);
    pith_free(seen);
    return status;
}

/* Positive where it is to be erased. */
static pith_status evaluate(const scalar *s, const pith_vec3 *points, size_t count, double *values, pith_error *err)
{
    const pith_erase *e = s->erase;
    switch ((pith_erase_kind)e->kind) {
    case PITH_ERASE_PLANE:
        PITH_TRY(plane_values(&e->plane, points, count, values, err));
        break;
    case PITH_ERASE_STROKE:
        PITH_TRY(pith_cut_scalar_values(s->stroke, points, count, values, err));
        break;
    case PITH_ERASE_VERTICAL:
    case PITH_ERASE_HORIZONTAL:
        PITH_TRY(pane_values(s, points, count, values, err));
        break;
    default:
        return pith_fail(err, PITH_BAD_ARGUMENT, "the kind of an erase is %u, expected 0 to 3", e->kind);
    }
    for (size_t i = 0; i < count && !e->positive; ++i) values[i] = -values[i];
    return PITH_OK;
}

/* ---- the surface while it is worked on ----------------------------------------------------------------------------------- */

typedef struct working {
    pith_vec3 *positions;     /* [vertex_count] */
    pith_erased *ends;        /* [vertex_count] */
    bool *touched;            /* [vertex_count] something was cut off at this very vertex */
    uint32_t (*triangles)[3]; /* [triangle_count] */
    size_t vertex_count, vertex_room, triangle_count, triangle_room;
    size_t ends_room, touched_room;
} working;

static void working_free(working *w)
{
    pith_free(w->positions);
    pith_free(w->ends);
    pith_free(w->touched);
    pith_free(w->triangles);
}

static bool grow_vertices(working *w, size_t needed)
{
    return pith_grow((void **)&w->positions, &w->vertex_room, needed, sizeof *w->positions) &&
           pith_grow((void **)&w->ends, &w->ends_room, needed, sizeof *w->ends) &&
           pith_grow((void **)&w->touched, &w->touched_room, needed, sizeof *w->touched);
}

static bool grow_triangles(working *w, size_t needed)
{
    return pith_grow((void **)&w->triangles, &w->triangle_room, needed, sizeof *w->triangles);
}

static pith_status begin(working *w, const pith_mesh_view *mesh, pith_error *err)
{
    if (!grow_vertices(w, (size_t)mesh->vertex_count + 1) || !grow_triangles(w, (size_t)mesh->triangle_count + 1))
        return PITH_OUT_OF_MEMORY(err, "what is left of a surface");
    w->vertex_count = mesh->vertex_count;
    w->triangle_count = mesh->triangle_count;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
        w->positions[v] = mesh->positions[v];
        w->ends[v] = (pith_erased){ { v, v, v }, { 1.0, 0.0, 0.0 } };
    }
    if (mesh->triangle_count) memcpy(w->triangles, mesh->triangles, mesh->triangle_count * sizeof *w->triangles);
    return PITH_OK;
}

/* Adds weight to a corner, which is one of the three or takes a free place among them. */
static void add_corner(pith_erased *to, uint32_t corner, double weight, int *used)
{
    if (weight == 0.0) return;
    int k = 0;
    while (k < *used && to->corner[k] != corner) ++k;
    if (k == 3) return; /* an edge of the working surface lies in one triangle of the mesh, which has no more */
    if (k == *used) {
        to->corner[(*used)++] = corner;
        to->weight[k] = 0.0;
    }
    to->weight[k] += weight;
}

/* Where a point of the edge between two vertices was. */
static pith_erased mix(const pith_erased *a, const pith_erased *b, double t)
{
    pith_erased made;
    int used = 0;
    for (int k = 0; k < 3; ++k) add_corner(&made, a->corner[k], (1.0 - t) * a->weight[k], &used);
    for (int k = 0; k < 3; ++k) add_corner(&made, b->corner[k], t * b->weight[k], &used);
    for (; used < 3; ++used) {
        made.corner[used] = made.corner[0];
        made.weight[used] = 0.0;
    }
    return made;
}

/* ---- crossings of edges -------------------------------------------------------------------------------------------------- */

/* The edges whose ends are on either side, and where on them the zero is. */
typedef struct crossings {
    uint32_t *edge;   /* [count] */
    double *t;        /* [count] from the lower end, 0..1 */
    uint32_t *vertex; /* [edges] the vertex made on an edge, PITH_NONE */
    uint32_t count;
} crossings;

static void crossings_free(crossings *c)
{
    pith_free(c->edge);
    pith_free(c->t);
    pith_free(c->vertex);
}

/* What is left of an edge, and the values at its ends, of which Illinois' rule halves the one that stays twice. */
typedef struct bracket {
    double low, high, low_value, high_value;
    int stayed;
} bracket;

static void narrow(bracket *b, double t, double value)
{
    if ((value < 0.0) == (b->low_value < 0.0)) {
        b->low = t, b->low_value = value;
        if (b->stayed > 0) b->high_value *= 0.5;
        b->stayed = 1;
    } else {
        b->high = t, b->high_value = value;
        if (b->stayed < 0) b->low_value *= 0.5;
        b->stayed = -1;
    }
}

/* Finds the zeros on all crossed edges at once by false position with Illinois' rule (Dowell and Jarratt 1971); those that
   are found drop out. A plane's are where the first straight line says. size: the mesh's diagonal. */
static pith_status search(const scalar *s, const working *w, const surface_edges *edges, const double *values,
                          double size, crossings *c, pith_error *err)
{
    bracket *b = pith_alloc(c->count, sizeof *b);
    uint32_t *open = pith_alloc(c->count, sizeof *open);
    pith_vec3 *points = pith_alloc(c->count, sizeof *points);
    double *found = pith_alloc(c->count, sizeof *found);
    pith_status status = PITH_OK;
    if (!b || !open || !points || !found) {
        status = PITH_OUT_OF_MEMORY(err, "crossed edges");
        goto done;
    }
    uint32_t count = c->count;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t *end = edges->ends[c->edge[i]];
        b[i] = (bracket){ 0.0, 1.0, values[end[0]], values[end[1]], 0 };
        open[i] = i;
    }
    for (int step = 0; count > 0 && step < MOST_STEPS; ++step) {
        for (uint32_t k = 0; k < count; ++k) {
            const uint32_t i = open[k], *end = edges->ends[c->edge[i]];
            c->t[i] = b[i].low + (b[i].high - b[i].low) * (b[i].low_value / (b[i].low_value - b[i].high_value));
            points[k] = pith_lerp(w->positions[end[0]], w->positions[end[1]], c->t[i]);
        }
        if (s->erase->kind == PITH_ERASE_PLANE) break;
        PITH_TRY_OR(done, evaluate(s, points, count, found, err));
        uint32_t left = 0;
        for (uint32_t k = 0; k < count; ++k) {
            if (fabs(found[k]) <= found_near * size) continue;
            narrow(&b[open[k]], c->t[open[k]], found[k]);
            open[left++] = open[k];
        }
        count = left;
    }
done:
    pith_free(b);
    pith_free(open);
    pith_free(points);
    pith_free(found);
    return status;
}

/* Crossings that are nearly at a vertex go through it: it gets the sign 0, and the edge is crossed no more. */
static void snap(const surface_edges *edges, crossings *c, int8_t *signs)
{
    for (uint32_t i = 0; i < c->count; ++i) {
        if (c->t[i] < near_end) signs[edges->ends[c->edge[i]][0]] = 0;
        if (c->t[i] > 1.0 - near_end) signs[edges->ends[c->edge[i]][1]] = 0;
    }
}

/* A vertex on every edge that is still crossed. */
static pith_status add_vertices(working *w, const surface_edges *edges, const int8_t *signs, crossings *c,
                                pith_error *err)
{
    if (!grow_vertices(w, w->vertex_count + c->count)) return PITH_OUT_OF_MEMORY(err, "vertices along an erase");
    for (uint32_t e = 0; e < edges->count; ++e) c->vertex[e] = PITH_NONE;
    for (uint32_t i = 0; i < c->count; ++i) {
        const uint32_t a = edges->ends[c->edge[i]][0], b = edges->ends[c->edge[i]][1];
        if (signs[a] * signs[b] >= 0) continue;
        const size_t v = w->vertex_count++;
        w->positions[v] = pith_lerp(w->positions[a], w->positions[b], c->t[i]);
        w->ends[v] = mix(&w->ends[a], &w->ends[b], c->t[i]);
        w->touched[v] = false;
        c->vertex[c->edge[i]] = (uint32_t)v;
    }
    return PITH_OK;
}

static pith_status find_crossings(const scalar *s, working *w, const surface_edges *edges, const double *values,
                                  double size, int8_t *signs, crossings *c, pith_error *err)
{
    c->edge = pith_alloc(edges->count, sizeof *c->edge);
    c->t = pith_alloc(edges->count, sizeof *c->t);
    c->vertex = pith_alloc(edges->count, sizeof *c->vertex);
    if (!c->edge || !c->t || !c->vertex) return PITH_OUT_OF_MEMORY(err, "crossed edges");
    for (uint32_t e = 0; e < edges->count; ++e)
        if (signs[edges->ends[e][0]] * signs[edges->ends[e][1]] < 0) c->edge[c->count++] = e;
    PITH_TRY(search(s, w, edges, values, size, c, err));
    snap(edges, c, signs);
    return add_vertices(w, edges, signs, c, err);
}

/* ---- dividing triangles -------------------------------------------------------------------------------------------------- */

/* The part of a triangle that is kept, in its turn: up to four vertices; 0 when nothing is. */
static int clip(const working *w, const surface_edges *edges, const crossings *c, const int8_t *signs, size_t t,
                uint32_t polygon[4])
{
    const uint32_t *v = w->triangles[t];
    int erased = 0, kept = 0, count = 0;
    for (int k = 0; k < 3; ++k) {
        erased += signs[v[k]] > 0;
        kept += signs[v[k]] < 0;
    }
    if (erased && !kept) return 0;
    for (int k = 0; k < 3; ++k) {
        const int next = (k + 1) % 3;
        if (signs[v[k]] <= 0) polygon[count++] = v[k];
        if (signs[v[k]] * signs[v[next]] < 0) polygon[count++] = c->vertex[edges->of[t][(k + 2) % 3]];
    }
    return count;
}

static pith_status divide(working *w, const surface_edges *edges, const crossings *c, const int8_t *signs,
                          pith_error *err)
{
    working made = { 0 };
    if (!grow_triangles(&made, 2 * w->triangle_count + 1)) return PITH_OUT_OF_MEMORY(err, "what is left of a surface");
    for (size_t t = 0; t < w->triangle_count; ++t) {
        uint32_t p[4];
        const int count = clip(w, edges, c, signs, t, p);
        if (count < 3) continue;
        /* Four corners are parted by the shorter diagonal. */
        const pith_vec3 *at = w->positions;
        const int from = count == 4 && pith_distance(at[p[1]], at[p[3]]) < pith_distance(at[p[0]], at[p[2]]);
        for (int k = 1; k + 1 < count; ++k) {
            uint32_t *to = made.triangles[made.triangle_count++];
            to[0] = p[from], to[1] = p[(from + k) % 4], to[2] = p[(from + k + 1) % 4];
        }
    }
    pith_free(w->triangles);
    w->triangles = made.triangles;
    w->triangle_count = made.triangle_count;
    w->triangle_room = made.triangle_room;
    return PITH_OK;
}

/* One erase from beginning to end. */
static pith_status erase_one(const scalar *s, working *w, double size, pith_error *err)
{
    surface_edges edges;
    PITH_TRY(surface_edges_find((const uint32_t(*)[3])w->triangles, (uint32_t)w->triangle_count,
                                (uint32_t)w->vertex_count, &edges, err));
    const size_t vertices = w->vertex_count;
    double *values = pith_alloc(vertices, sizeof *values);
    int8_t *signs = pith_alloc(vertices, sizeof *signs);
    crossings c = { 0 };
    pith_status status = PITH_OK;
    if (!values || !signs) {
        status = PITH_OUT_OF_MEMORY(err, "which side vertices are on");
        goto done;
    }
    PITH_TRY_OR(done, evaluate(s, w->positions, vertices, values, err));
    for (size_t v = 0; v < vertices; ++v)
        signs[v] = (int8_t)((values[v] > rounding * size) - (values[v] < -rounding * size));
    PITH_TRY_OR(done, find_crossings(s, w, &edges, values, size, signs, &c, err));
    PITH_TRY_OR(done, divide(w, &edges, &c, signs, err));
    for (size_t v = 0; v < vertices; ++v) w->touched[v] |= signs[v] == 0;
done:
    surface_edges_free(&edges);
    crossings_free(&c);
    pith_free(values);
    pith_free(signs);
    return status;
}

/* ---- what is left -------------------------------------------------------------------------------------------------------- */

/* The corner of a triangle (3 * triangle + place) at a vertex. */
static uint32_t corner_at(const working *w, uint32_t t, uint32_t vertex)
{
    const uint32_t *v = w->triangles[t];
    return 3 * t + (v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2);
}

/* Corners of one vertex belong together when an edge from it joins their triangles. first [edges]: scratch. */
static void join_corners(const working *w, const surface_edges *edges, uint32_t *first, uint32_t *parent)
{
    for (uint32_t e = 0; e < edges->count; ++e) first[e] = PITH_NONE;
    for (uint32_t i = 0; i < 3 * w->triangle_count; ++i) parent[i] = i;
    for (uint32_t t = 0; t < w->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t e = edges->of[t][k];
            if (first[e] == PITH_NONE) {
                first[e] = t;
                continue;
            }
            for (int end = 0; end < 2; ++end)
                surface_unite(parent, corner_at(w, t, edges->ends[e][end]),
                              corner_at(w, first[e], edges->ends[e][end]));
        }
}

/* Where an erase went through a vertex, the fans of triangles round it that hang together by nothing else get a vertex
   each: the border runs past, not through itself. */
static pith_status part_fans(working *w, pith_error *err)
{
    surface_edges edges;
    PITH_TRY(surface_edges_find((const uint32_t(*)[3])w->triangles, (uint32_t)w->triangle_count,
                                (uint32_t)w->vertex_count, &edges, err));
    const size_t corners = 3 * w->triangle_count, vertices = w->vertex_count;
    uint32_t *first = pith_alloc(edges.count, sizeof *first), *parent = pith_alloc(corners, sizeof *parent);
    uint32_t *vertex = pith_alloc(corners, sizeof *vertex); /* of a fan, at its root */
    bool *taken = pith_alloc(vertices, sizeof *taken);
    pith_status status = PITH_OK;
    if (!first || !parent || !vertex || !taken) {
        status = PITH_OUT_OF_MEMORY(err, "the border of what is left");
        goto done;
    }
    join_corners(w, &edges, first, parent);
    for (size_t i = 0; i < corners; ++i) vertex[i] = PITH_NONE;
    for (uint32_t i = 0; i < corners; ++i) {
        uint32_t *v = &w->triangles[i / 3][i % 3];
        if (!w->touched[*v]) continue;
        uint32_t *own = &vertex[surface_root(parent, i)];
        if (*own == PITH_NONE && !taken[*v]) {
            taken[*v] = true;
            *own = *v;
        } else if (*own == PITH_NONE) {
            if (!grow_vertices(w, w->vertex_count + 1)) {
                status = PITH_OUT_OF_MEMORY(err, "the border of what is left");
                goto done;
            }
            *own = (uint32_t)w->vertex_count++;
            w->positions[*own] = w->positions[*v];
            w->ends[*own] = w->ends[*v];
        }
        *v = *own;
    }
done:
    surface_edges_free(&edges);
    pith_free(first);
    pith_free(parent);
    pith_free(vertex);
    pith_free(taken);
    return status;
}

/* Keeps the vertices that are used, in their order. */
static pith_status compact(working *w, pith_error *err)
{
    uint32_t *number = pith_alloc(w->vertex_count, sizeof *number);
    if (!number) return PITH_OUT_OF_MEMORY(err, "what is left of a surface");
    for (size_t t = 0; t < w->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) number[w->triangles[t][k]] = 1;
    uint32_t count = 0;
    for (size_t v = 0; v < w->vertex_count; ++v) {
        if (!number[v]) continue;
        w->positions[count] = w->positions[v];
        w->ends[count] = w->ends[v];
        number[v] = count++;
    }
    for (size_t t = 0; t < w->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) w->triangles[t][k] = number[w->triangles[t][k]];
    w->vertex_count = count;
    pith_free(number);
    return PITH_OK;
}

/* The mesh, with what the vertices carry mixed as they are. */
static pith_status finish(const working *w, const pith_mesh_view *from, pith_mesh **left, pith_error *err)
{
    const size_t n = w->vertex_count;
    pith_vec3 *normals = from->normals ? pith_alloc(n, sizeof *normals) : NULL;
    float(*colours)[4] = from->colours ? pith_alloc(n, sizeof *colours) : NULL;
    float(*texcoords)[2] = from->texcoords ? pith_alloc(n, sizeof *texcoords) : NULL;
    pith_status status = PITH_OK;
    if ((from->normals && !normals) || (from->colours && !colours) || (from->texcoords && !texcoords)) {
        status = PITH_OUT_OF_MEMORY(err, "what is left of a surface");
        goto done;
    }
    for (size_t v = 0; v < n; ++v) {
        const pith_erased *e = &w->ends[v];
        for (int k = 0; k < 3; ++k) {
            const uint32_t corner = e->corner[k];
            const float weight = (float)e->weight[k];
            if (normals) normals[v] = pith_madd(normals[v], from->normals[corner], e->weight[k]);
            for (int i = 0; colours && i < 4; ++i) colours[v][i] += weight * from->colours[corner][i];
            for (int i = 0; texcoords && i < 2; ++i) texcoords[v][i] += weight * from->texcoords[corner][i];
        }
        if (normals) normals[v] = pith_unit(normals[v]);
    }
    const pith_mesh_view view = { .positions = w->positions,
                                  .normals = normals,
                                  .colours = (const float(*)[4])colours,
                                  .texcoords = (const float(*)[2])texcoords,
                                  .triangles = (const uint32_t(*)[3])w->triangles,
                                  .vertex_count = (uint32_t)n,
                                  .triangle_count = (uint32_t)w->triangle_count };
    status = pith_mesh_create(&view, left, err);
done:
    pith_free(normals);
    pith_free(colours);
    pith_free(texcoords);
    return status;
}

/* ---- the whole ----------------------------------------------------------------------------------------------------------- */

static pith_status make_erase(const pith_erase *erase, const pith_mesh_view *mesh, double size, working *w,
                              pith_error *err)
{
    scalar s = { .erase = erase };
    pith_status status = PITH_OK;
    if (erase->kind == PITH_ERASE_VERTICAL || erase->kind == PITH_ERASE_HORIZONTAL) {
        PITH_TRY(pith_curve_check(&erase->curve, err));
        s.samples = pith_alloc(CURVE_SAMPLES, sizeof *s.samples);
        if (!s.samples) return PITH_OUT_OF_MEMORY(err, "samples of a curve");
        status = pith_curve_sample(&erase->curve, CURVE_SAMPLES, s.samples, NULL, err);
    }
    if (erase->kind == PITH_ERASE_STROKE)
        status =
            pith_cut_scalar_create(&erase->stroke, &erase->follow, mesh->positions, mesh->vertex_count, &s.stroke, err);
    if (status == PITH_OK) status = erase_one(&s, w, size, err);
    pith_cut_scalar_destroy(s.stroke);
    pith_free(s.samples);
    return status;
}

static void drop_degenerate(working *w)
{
    size_t count = 0;
    for (size_t t = 0; t < w->triangle_count; ++t) {
        const uint32_t *v = w->triangles[t];
        if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
        if (count != t) memcpy(w->triangles[count], v, sizeof *w->triangles);
        ++count;
    }
    w->triangle_count = count;
}

pith_status pith_mesh_erase(const pith_mesh *mesh, const pith_erase *erases, size_t count, pith_mesh **left,
                            pith_erased **ends, pith_error *err)
{
    if (!mesh || (count && !erases) || !left)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_erase: %s is NULL",
                         !mesh   ? "mesh"
                         : !left ? "left"
                                 : "erases");
    const pith_mesh_view view = pith_mesh_look(mesh);
    const pith_box box = pith_box_of(view.positions, view.vertex_count);
    const double size = view.vertex_count ? pith_distance(box.low, box.high) : 0.0;
    working w = { 0 };
    pith_status status = PITH_OK;
    PITH_TRY_OR(done, begin(&w, &view, err));
    drop_degenerate(&w);
    for (size_t i = 0; i < count; ++i) {
        status = make_erase(&erases[i], &view, size, &w, err);
        if (status != PITH_OK) {
            status = pith_fail_in(err, status, "erase %zu", i);
            goto done;
        }
        if (w.triangle_count > 0) continue;
        status = pith_fail(err, PITH_BAD_ARGUMENT,
                           "erase %zu leaves nothing of the surface: all of it is on the %s side; "
                           "erase the other side, or draw it elsewhere",
                           i, erases[i].positive ? "positive" : "negative");
        goto done;
    }
    PITH_TRY_OR(done, part_fans(&w, err));
    PITH_TRY_OR(done, compact(&w, err));
    pith_mesh *made;
    PITH_TRY_OR(done, finish(&w, &view, &made, err));
    *left = made;
    if (ends) {
        *ends = w.ends;
        w.ends = NULL;
    }
done:
    working_free(&w);
    return status;
}
