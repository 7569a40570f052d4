/* Round tubes about polylines. The rings are carried along without turning about the line (parallel transport; Bishop,
   "There is more than one way to frame a curve", American Mathematical Monthly 82(3), 1975), so that tubes do not
   twist. */
#include "polylines_internal.h"

enum { MOST_SIDES = 256 };

/* One line without repeated points. */
typedef struct tube_path {
    pith_vec3 *points;      /* [count] */
    pith_vec3 *tangents;    /* [count] unit, along the middle between the two pieces that meet */
    pith_vec3 *across;      /* [count] unit, perpendicular to the tangents: where a ring begins */
    uint32_t count;
    bool closed;            /* the line ends where it began; that point is kept once */
} tube_path;

static void take_points(const pith_polylines *lines, uint32_t line, tube_path *path)
{
    path->count = 0;
    for (uint32_t i = lines->start[line]; i < lines->start[line + 1]; ++i)
        if (path->count == 0 || pith_distance(lines->points[i], path->points[path->count - 1]) > 0.0)
            path->points[path->count++] = lines->points[i];
    path->closed = path->count > 3 && pith_distance(path->points[0], path->points[path->count - 1]) == 0.0;
    path->count -= path->closed;
}

/* The direction of piece i, from point i to the next. */
static pith_vec3 piece(const tube_path *path, uint32_t i)
{
    return pith_unit(pith_sub(path->points[(i + 1) % path->count], path->points[i]));
}

static void find_tangents(tube_path *path)
{
    const uint32_t n = path->count;
    for (uint32_t i = 0; i < n; ++i) {
        const bool first = i == 0 && !path->closed, last = i + 1 == n && !path->closed;
        const pith_vec3 before = first ? piece(path, 0) : piece(path, (i + n - 1) % n);
        const pith_vec3 behind = last ? before : piece(path, i), sum = pith_add(before, behind);
        path->tangents[i] = pith_length(sum) > 1e-6 ? pith_unit(sum) : behind; /* a hairpin has no middle */
    }
}

/* v turned by the smallest rotation that takes the unit vector a to the unit vector b. */
static pith_vec3 carry(pith_vec3 v, pith_vec3 a, pith_vec3 b)
{
    const pith_vec3 axis = pith_cross(a, b);
    const double cosine = pith_dot(a, b);
    pith_vec3 turned = v; /* after a half turn about v it is still perpendicular */
    if (cosine > -1.0 + 1e-12)
        turned = pith_add(pith_madd(pith_scale(v, cosine), pith_cross(axis, v), 1.0),
                          pith_scale(axis, pith_dot(axis, v) / (1.0 + cosine)));
    const pith_vec3 kept = pith_unit(pith_reject(turned, b));
    return pith_length(kept) > 0.5 ? kept : pith_perpendicular(b);
}

/* Around a closed line the first ring does not come back to itself; what it is turned by is shared by all. */
static void spread_twist(tube_path *path)
{
    const uint32_t n = path->count;
    const pith_vec3 tangent = path->tangents[0], begin = path->across[0];
    const pith_vec3 end = carry(path->across[n - 1], path->tangents[n - 1], tangent);
    const double twist = atan2(pith_dot(pith_cross(end, begin), tangent), pith_dot(end, begin));
    for (uint32_t i = 1; i < n; ++i) {
        const double angle = twist * i / n;
        const pith_vec3 side = pith_cross(path->tangents[i], path->across[i]);
        path->across[i] = pith_madd(pith_scale(path->across[i], cos(angle)), side, sin(angle));
    }
}

static void find_rings(tube_path *path)
{
    find_tangents(path);
    path->across[0] = pith_perpendicular(path->tangents[0]);
    for (uint32_t i = 1; i < path->count; ++i)
        path->across[i] = carry(path->across[i - 1], path->tangents[i - 1], path->tangents[i]);
    if (path->closed) spread_twist(path);
}

static void add_triangle(pith_mesh *mesh, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *t = mesh->triangles[mesh->triangle_count++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

/* Rings, the walls between them, and a fan about each end's middle. Counts of the mesh grow as it is filled. */
static void add_tube(pith_mesh *mesh, const tube_path *path, double radius, uint32_t sides)
{
    const uint32_t base = mesh->vertex_count, n = path->count, spans = path->closed ? n : n - 1;
    for (uint32_t i = 0; i < n; ++i) {
        const pith_vec3 side = pith_cross(path->tangents[i], path->across[i]);
        for (uint32_t s = 0; s < sides; ++s) {
            const double angle = 2.0 * M_PI * s / sides;
            const pith_vec3 out = pith_madd(pith_scale(path->across[i], cos(angle)), side, sin(angle));
            mesh->positions[mesh->vertex_count++] = pith_madd(path->points[i], out, radius);
        }
    }
    for (uint32_t i = 0; i < spans; ++i)
        for (uint32_t s = 0; s < sides; ++s) {
            const uint32_t next = (s + 1) % sides, low = base + i * sides, high = base + (i + 1) % n * sides;
            add_triangle(mesh, low + s, low + next, high + next);
            add_triangle(mesh, low + s, high + next, high + s);
        }
    if (path->closed) return;
    const uint32_t start = mesh->vertex_count++, end = mesh->vertex_count++, last = base + (n - 1) * sides;
    mesh->positions[start] = path->points[0];
    mesh->positions[end] = path->points[n - 1];
    for (uint32_t s = 0; s < sides; ++s) {
        const uint32_t next = (s + 1) % sides;
        add_triangle(mesh, start, base + next, base + s);
        add_triangle(mesh, end, last + s, last + next);
    }
}

pith_status pith_polylines_tubes(const pith_polylines *lines, double radius, uint32_t sides, pith_mesh **mesh,
                                 pith_error *err)
{
    if (!lines || !mesh) return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_tubes: a pointer is NULL");
    if (!(radius > 0.0 && radius <= MESH_COORDINATE_LIMIT))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_tubes: the radius is %g, expected more than 0",
                         radius);
    if (sides < 3 || sides > MOST_SIDES)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_tubes: %u sides, expected 3 to %d", sides, MOST_SIDES);
    const uint64_t points = lines->start[lines->line_count], most = points * sides + 2 * (uint64_t)lines->line_count;
    if (2 * most > UINT32_MAX)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_polylines_tubes: %llu points with %u sides are too many for one "
                         "mesh; take fewer sides or lines", (unsigned long long)points, sides);
    tube_path path = { .points = pith_alloc(points, sizeof *path.points),
                       .tangents = pith_alloc(points, sizeof *path.tangents),
                       .across = pith_alloc(points, sizeof *path.across) };
    pith_mesh *made = mesh_new((uint32_t)most, (uint32_t)(2 * most), false, false, false);
    const bool ready = path.points && path.tangents && path.across && made;
    if (ready) {
        made->vertex_count = made->triangle_count = 0;
        for (uint32_t line = 0; line < lines->line_count; ++line) {
            take_points(lines, line, &path);
            find_rings(&path);
            add_tube(made, &path, radius, sides);
        }
        *mesh = made;
    } else {
        pith_mesh_destroy(made);
    }
    pith_free(path.points);
    pith_free(path.tangents);
    pith_free(path.across);
    return ready ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the tubes");
}
