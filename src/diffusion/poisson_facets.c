/* The piecewise linear complex that tetrahedra conform to: all sheets, welded where they share places, inside a ball. */
#include "poisson_internal.h"

#include <string.h>

void facets_free(facets *gone)
{
    pith_free(gone->positions);
    pith_free(gone->sizes);
    pith_free(gone->triangles);
    pith_free(gone->source);
    *gone = (facets){ 0 };
}

/* ---- one vertex for each place ---------------------------------------------------------------------------------------------- */

static bool same_place(pith_vec3 a, pith_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* Adds the sheets' vertices without repetitions; number[v] is where v has gone. */
static pith_status add_places(const pith_diffusion *diffusion, facets *made, uint32_t *number, pith_error *err)
{
    const sheets *all = &diffusion->sheets;
    size_t slots = 16;
    while (slots < 2 * (size_t)all->vertex_count) slots *= 2;
    uint32_t *table = pith_alloc(slots, sizeof *table); /* place + 1 */
    if (!table) return PITH_OUT_OF_MEMORY(err, "the places of sheets");
    for (uint32_t v = 0; v < all->vertex_count; ++v) {
        const pith_vec3 p = diffusion_to_scene(diffusion, all->positions[v]);
        const double key[3] = { p.x + 0.0, p.y + 0.0, p.z + 0.0 }; /* -0 becomes 0 */
        size_t slot = pith_hash_bytes(key, sizeof key, 0) & (slots - 1);
        while (table[slot] && !same_place(made->positions[table[slot] - 1], p)) slot = (slot + 1) & (slots - 1);
        if (!table[slot]) {
            made->positions[made->vertex_count++] = pith_v3(key[0], key[1], key[2]);
            table[slot] = made->vertex_count;
        }
        number[v] = table[slot] - 1;
    }
    pith_free(table);
    return PITH_OK;
}

/* ---- names and places for messages -------------------------------------------------------------------------------------------- */

/* The title of the surface that a triangle of the sheets is from. */
static const char *title_of(const pith_diffusion *diffusion, uint32_t triangle)
{
    return diffusion->surfaces[scene_surface_of(diffusion, triangle)].title;
}

static pith_vec3 to_model(const pith_diffusion *diffusion, pith_vec3 p)
{
    return pith_madd(diffusion->centre, p, 1.0 / diffusion->scale);
}

/* Triangles without area have no sides, and no mesher keeps them. Those with two corners at one place are nothing but an
   edge of their neighbours and can go. */
static pith_status add_triangles(const pith_diffusion *diffusion, const uint32_t *number, facets *made, pith_error *err)
{
    const sheets *all = &diffusion->sheets;
    for (uint32_t t = 0; t < all->triangle_count; ++t) {
        uint32_t *c = made->triangles[made->triangle_count];
        for (int k = 0; k < 3; ++k) c[k] = number[all->triangles[t][k]];
        if (c[0] == c[1] || c[1] == c[2] || c[2] == c[0]) continue;
        const pith_vec3 normal = diffusion->placed[t].normal, at = all->positions[all->triangles[t][0]];
        if (!(pith_dot(normal, normal) > 0.0))
            return pith_fail(
                err, PITH_BAD_MESH,
                "diffusion surface %s has a triangle without area at (%g, %g, %g), which tetrahedra cannot "
                "conform to; clean the mesh first, or take the method pmvc or wos",
                title_of(diffusion, t), at.x, at.y, at.z);
        made->source[made->triangle_count++] = t;
    }
    return PITH_OK;
}

static pith_status check_crossings(const pith_diffusion *diffusion, const facets *made, pith_error *err)
{
    const pith_mesh_view view = { .positions = made->positions,
                                  .triangles = (const uint32_t(*)[3])made->triangles,
                                  .vertex_count = made->vertex_count,
                                  .triangle_count = made->triangle_count };
    uint32_t pair[2];
    pith_vec3 place;
    PITH_TRY(pith_mesh_crossing(&view, pair, &place, err));
    if (pair[0] == PITH_NONE) return PITH_OK;
    const char *one = title_of(diffusion, made->source[pair[0]]), *other = title_of(diffusion, made->source[pair[1]]);
    const pith_vec3 at = to_model(diffusion, place);
    if (one == other)
        return pith_fail(
            err, PITH_BAD_MESH,
            "the sheets of diffusion surface %s cross themselves or touch near (%g, %g, %g), and tetrahedra "
            "cannot conform to them; mend the surface, give it less blur, or take the method pmvc or wos",
            one, at.x, at.y, at.z);
    return pith_fail(err, PITH_BAD_MESH,
                     "diffusion surfaces %s and %s cross or touch near (%g, %g, %g), and tetrahedra cannot conform to "
                     "both; move them apart or let them share vertices there, or take the method pmvc or wos",
                     one, other, at.x, at.y, at.z);
}

/* ---- the ball ---------------------------------------------------------------------------------------------------------------- */

/* Coarse: colours change little out there. Vertices of shells in between say how fast tetrahedra may grow. */
enum { BALL_DETAIL = 2, SHELL_DETAIL = 1, BALL_VERTICES = 10 * 16 + 2, BALL_TRIANGLES = 20 * 16, SHELL_VERTICES = 42 };
static const double shells[] = { 1.2, 2.0 };
enum { SHELLS = sizeof shells / sizeof *shells };
#define GROWTH 0.3 /* of edges, for each radius away from the object */

static pith_status add_ball(facets *made, double radius, double edge, uint32_t detail, bool triangles, pith_error *err)
{
    pith_fruit_options options = pith_fruit_options_default();
    options.radius_x = options.radius_y = options.radius_z = radius;
    options.power = 2.0;
    options.dent = options.taper = options.bump = 0.0;
    options.detail = detail;
    pith_mesh *ball = NULL;
    PITH_TRY(pith_mesh_fruit(&options, &ball, err));
    const pith_mesh_view view = pith_mesh_look(ball);
    for (uint32_t t = 0; triangles && t < view.triangle_count; ++t) {
        for (int k = 0; k < 3; ++k)
            made->triangles[made->triangle_count][k] = made->vertex_count + view.triangles[t][k];
        made->source[made->triangle_count++] = PITH_NONE;
    }
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        made->sizes[made->vertex_count] = edge;
        made->positions[made->vertex_count++] = view.positions[v];
    }
    pith_mesh_destroy(ball);
    return PITH_OK;
}

/* Is a side that is not hidden seen from around? A side that these looks miss is answered as well, from larger
   tetrahedra. */
static pith_status look_from_outside(const pith_diffusion *diffusion, bool *seen, pith_error *err)
{
    enum { PLACES = 64, RAYS = 256 };
    asker with = { .diffusion = diffusion };
    directions places = { 0 };
    PITH_TRY(directions_make(RAYS, 0, &with.directions, err));
    pith_status status = directions_make(PLACES, 1, &places, err);
    pith_vec3 points[PLACES];
    uint32_t order[PLACES];
    float colours[PLACES][4];
    for (uint32_t i = 0; status == PITH_OK && i < PLACES; ++i) {
        const float *d = places.unit[i];
        points[i] = to_model(diffusion, pith_scale(pith_v3((double)d[0], (double)d[1], (double)d[2]), shells[0]));
        order[i] = i;
    }
    *seen = false;
    if (status == PITH_OK) pmvc_answer(&with, points, order, PLACES, colours);
    for (uint32_t i = 0; status == PITH_OK && i < PLACES; ++i) *seen = *seen || colours[i][3] > 0.0f;
    directions_free(&with.directions);
    directions_free(&places);
    return status;
}

static pith_status add_surroundings(const pith_diffusion *diffusion, double edge, facets *made, pith_error *err)
{
    bool seen;
    PITH_TRY(look_from_outside(diffusion, &seen, err));
    const double growth = seen ? GROWTH : 1.0;
    for (int i = 0; seen && i < SHELLS; ++i)
        PITH_TRY(add_ball(made, shells[i], edge + growth * (shells[i] - 1.0), SHELL_DETAIL, false, err));
    return add_ball(made, HORIZON, edge + growth * (HORIZON - 1.0), BALL_DETAIL, true, err);
}

/* Tetrahedra cannot grow much within a facet's length of it; to ask for more only costs the mesher time, as it looks for
   everything within that length of each new vertex. */
#define MOST_FACETS 3.0

/* The wanted length, or a few times the mean of the facets' edges at a vertex where they are short. */
static pith_status choose_sizes(facets *made, double edge, pith_error *err)
{
    uint32_t *edges = pith_alloc(made->vertex_count, sizeof *edges);
    if (!edges) return PITH_OUT_OF_MEMORY(err, "the facets of sheets");
    for (uint32_t t = 0; t < made->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t a = made->triangles[t][k], b = made->triangles[t][(k + 1) % 3];
            const double length = pith_distance(made->positions[a], made->positions[b]);
            made->sizes[a] += length, made->sizes[b] += length;
            ++edges[a], ++edges[b];
        }
    for (uint32_t v = 0; v < made->vertex_count; ++v)
        made->sizes[v] = edges[v] ? fmin(edge, MOST_FACETS * made->sizes[v] / edges[v]) : edge;
    pith_free(edges);
    return PITH_OK;
}

pith_status facets_make(const pith_diffusion *diffusion, double edge, facets *made, pith_error *err)
{
    const size_t vertices = (size_t)diffusion->sheets.vertex_count + BALL_VERTICES + SHELLS * SHELL_VERTICES;
    const size_t triangles = (size_t)diffusion->sheets.triangle_count + BALL_TRIANGLES;
    facets own = { .positions = pith_alloc(vertices, sizeof *own.positions),
                   .sizes = pith_alloc(vertices, sizeof *own.sizes),
                   .triangles = pith_alloc(triangles, sizeof *own.triangles),
                   .source = pith_alloc(triangles, sizeof *own.source) };
    uint32_t *number = pith_alloc(diffusion->sheets.vertex_count, sizeof *number);
    pith_status status = PITH_OK;
    if (!own.positions || !own.sizes || !own.triangles || !own.source || !number)
        status = PITH_OUT_OF_MEMORY(err, "the facets of sheets");
    if (status == PITH_OK) status = add_places(diffusion, &own, number, err);
    if (status == PITH_OK) status = add_triangles(diffusion, number, &own, err);
    if (status == PITH_OK) status = check_crossings(diffusion, &own, err);
    if (status == PITH_OK) status = choose_sizes(&own, edge, err);
    if (status == PITH_OK) status = add_surroundings(diffusion, edge, &own, err);
    pith_free(number);
    if (status == PITH_OK)
        *made = own;
    else
        facets_free(&own);
    return status;
}
