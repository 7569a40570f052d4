/* Grains strewn over a surface: Poisson disc samples by dart throwing, and a frame for each.

   Source: Cline, Jeschke, White, Razdan and Wonka, "Dart throwing on surfaces", 2009; after White, Cline and Egbert,
   "Poisson disk point sets by hierarchical dart throwing", 2007. Darts are thrown at fragments of triangles that are not
   wholly within the disc of one grain, each as often as its area is large. A dart that no grain forbids becomes one. The
   fragment is then halved, and halves that lie within one disc are given up. What is given up holds no place for a grain,
   so that every dart falls evenly on what is still free, and when no fragment is left there is no free place.

   Frames: Takayama's thesis (2011), §6.3.2: by the surface's normal and the axis of symmetry. */
#include "sketch_internal.h"
#include "surface_internal.h"

#include <string.h>

static const pith_param grains_items[] = {
    { "radius", "model units", "no two grains are nearer to each other; more of it strews fewer", PITH_PARAM_DOUBLE,
      1e-9, 0.1, 1e9, offsetof(pith_grains_options, radius), NULL },
    { "scale", "1", "factor on the grain's size", PITH_PARAM_DOUBLE, 1e-9, 1, 1e9, offsetof(pith_grains_options, scale),
      NULL },
    { "scale_spread", "1", "more of it makes sizes differ: 0 all alike, 1 between 0 and twice", PITH_PARAM_DOUBLE, 0, 0,
      1, offsetof(pith_grains_options, scale_spread), NULL },
    { "turn_spread", "degrees", "each is turned about the normal by up to so much, either way", PITH_PARAM_DOUBLE, 0, 0,
      180, offsetof(pith_grains_options, turn_spread), NULL },
    { "offset", "model units", "from the surface along its normal; more of it lifts them off", PITH_PARAM_DOUBLE, -1e9,
      0, 1e9, offsetof(pith_grains_options, offset), NULL },
    { "seed", "1", "another one strews them elsewhere", PITH_PARAM_SEED, 0, 1, 0x1p53,
      offsetof(pith_grains_options, seed), NULL },
};
const pith_params pith_grains_params = { "grains", grains_items, sizeof grains_items / sizeof *grains_items,
                                         sizeof(pith_grains_options) };

pith_grains_options pith_grains_options_default(void)
{
    pith_grains_options options;
    pith_params_defaults(&pith_grains_params, &options);
    return options;
}

enum { MOST_GRAINS = 1000000 };

/* Darts fill this much of a large surface: discs of half the radius cover 0.547 of the plane (Feder 1980) when no more fit
   in, each of them pi/4 radius². */
static const double grains_per_square_radius = 0.547 * 4.0 / M_PI;

/* ---- grains near a place ------------------------------------------------------------------------------------------------- */

typedef struct sown {
    pith_vec3 at;
    uint32_t triangle, next;
    double weight[3];
} sown; /* next: in the chain of its cell */

/* Grains by cells as wide as a disc, of which a disc meets eight at most; cells of one hash share a chain, which costs
   time and nothing else. */
typedef struct field {
    double radius, square;
    pith_vec3 low;
    sown *grains; /* [count] */
    size_t count, room;
    uint32_t *chains; /* [mask + 1] first grain of a chain, PITH_NONE */
    size_t mask;
} field;

static size_t chain_of(const field *f, int64_t x, int64_t y, int64_t z)
{
    return pith_mix64((uint64_t)x * 0x9e3779b97f4a7c15u ^ (uint64_t)y * 0xc2b2ae3d27d4eb4fu ^ (uint64_t)z) & f->mask;
}

/* Very far away all is one cell. */
static int64_t cell_of(const field *f, double at, double low)
{
    return (int64_t)fmin(fmax(floor(0.5 * (at - low) / f->radius), -0x1p52), 0x1p52);
}

static void hang(field *f, uint32_t i)
{
    const pith_vec3 p = f->grains[i].at;
    uint32_t *first =
        &f->chains[chain_of(f, cell_of(f, p.x, f->low.x), cell_of(f, p.y, f->low.y), cell_of(f, p.z, f->low.z))];
    f->grains[i].next = *first;
    *first = i;
}

/* As many chains as twice the grains at least. */
static bool grow_chains(field *f)
{
    if (f->chains && 2 * f->count <= f->mask) return true;
    const size_t size = f->chains ? 4 * (f->mask + 1) : 1024;
    uint32_t *chains = pith_alloc(size, sizeof *chains);
    if (!chains) return false;
    memset(chains, 0xff, size * sizeof *chains);
    pith_free(f->chains);
    f->chains = chains;
    f->mask = size - 1;
    for (uint32_t i = 0; i < f->count; ++i) hang(f, i);
    return true;
}

static bool add_grain(field *f, const sown *grain)
{
    if (!pith_grow((void **)&f->grains, &f->room, f->count + 1, sizeof *f->grains) || !grow_chains(f)) return false;
    f->grains[f->count] = *grain;
    hang(f, (uint32_t)f->count++);
    return true;
}

/* Does one grain's disc cover all of these points (strictly: a place exactly at the radius is free)? */
static bool covered(const field *f, const pith_vec3 *points, int count)
{
    if (count > 1 && pith_distance(points[0], points[1]) >= 2.0 * f->radius) return false;
    /* A grain that covers all of them covers their mean, so it lies in the cells round that. */
    pith_vec3 sum = points[0];
    for (int i = 1; i < count; ++i) sum = pith_add(sum, points[i]);
    const pith_vec3 mean = pith_scale(sum, 1.0 / count);
    const double r = f->radius;
    const int64_t low[3] = { cell_of(f, mean.x - r, f->low.x), cell_of(f, mean.y - r, f->low.y),
                             cell_of(f, mean.z - r, f->low.z) };
    const int64_t high[3] = { cell_of(f, mean.x + r, f->low.x), cell_of(f, mean.y + r, f->low.y),
                              cell_of(f, mean.z + r, f->low.z) };
    for (int64_t z = low[2]; z <= high[2]; ++z)
        for (int64_t y = low[1]; y <= high[1]; ++y)
            for (int64_t x = low[0]; x <= high[0]; ++x)
                for (uint32_t i = f->chains[chain_of(f, x, y, z)]; i != PITH_NONE; i = f->grains[i].next) {
                    int k = 0;
                    for (; k < count; ++k) {
                        const pith_vec3 off = pith_sub(points[k], f->grains[i].at);
                        if (!(pith_dot(off, off) < f->square)) break;
                    }
                    if (k == count) return true;
                }
    return false;
}

/* ---- fragments by size --------------------------------------------------------------------------------------------------- */

/* A piece of a triangle: barycentric coordinates of its corners there. */
typedef struct fragment {
    uint32_t triangle;
    double area;
    double corner[3][3];
} fragment;

/* Fragments whose areas are within a factor of two of each other, so that a choice by area needs two tries at most. */
typedef struct bin {
    fragment *items;
    size_t count, room;
    double area;
} bin;

enum { BINS = 96 };

typedef struct fragments {
    bin bins[BINS]; /* bin i: areas in (greatest / 2^(i + 1), greatest / 2^i]; the last all that are smaller */
    double greatest;
} fragments;

static void fragments_free(fragments *all)
{
    for (int i = 0; i < BINS; ++i) pith_free(all->bins[i].items);
}

static double greatest_of(const fragments *all, int i) { return ldexp(all->greatest, -i); }

static bool add_fragment(fragments *all, const fragment *f)
{
    int i = 0;
    while (i < BINS - 1 && f->area <= greatest_of(all, i + 1)) ++i;
    bin *b = &all->bins[i];
    if (!pith_grow((void **)&b->items, &b->room, b->count + 1, sizeof *b->items)) return false;
    b->items[b->count++] = *f;
    b->area += f->area;
    return true;
}

/* Takes out a fragment at random, each as likely as its area is large; false when none is left. */
static bool draw_fragment(fragments *all, pith_rng *rng, fragment *drawn)
{
    double whole = 0.0;
    for (int i = 0; i < BINS; ++i) whole += all->bins[i].area;
    double left = pith_rng_unit(rng) * whole;
    int chosen = -1;
    for (int i = 0; i < BINS; ++i) {
        if (all->bins[i].count == 0) continue;
        chosen = i;
        left -= all->bins[i].area;
        if (left < 0.0) break;
    }
    if (chosen < 0) return false;
    bin *b = &all->bins[chosen];
    size_t at;
    do at = pith_rng_below(rng, (uint32_t)b->count);
    while (chosen < BINS - 1 && pith_rng_unit(rng) * greatest_of(all, chosen) > b->items[at].area);
    *drawn = b->items[at];
    b->items[at] = b->items[--b->count];
    b->area = b->count ? fmax(b->area - drawn->area, 0.0) : 0.0; /* so that rounding never piles up in an empty bin */
    return true;
}

static void place_corners(const pith_mesh_view *mesh, const fragment *f, pith_vec3 points[3])
{
    const uint32_t *v = mesh->triangles[f->triangle];
    for (int k = 0; k < 3; ++k) {
        points[k] = pith_scale(mesh->positions[v[0]], f->corner[k][0]);
        for (int i = 1; i < 3; ++i) points[k] = pith_madd(points[k], mesh->positions[v[i]], f->corner[k][i]);
    }
}

/* ---- throwing ------------------------------------------------------------------------------------------------------------ */

static pith_status too_many(double radius, double enough, pith_error *err)
{
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "a radius of %g strews more than a million grains over this surface; %.2g would "
                     "do",
                     radius, enough);
}

/* Every marked triangle as a fragment. */
static pith_status begin(const pith_mesh_view *mesh, const bool *marked, double radius, fragments *all, pith_error *err)
{
    double area = 0.0;
    for (int pass = 0; pass < 2; ++pass)
        for (uint32_t t = 0; t < mesh->triangle_count; ++t) {
            const uint32_t *v = mesh->triangles[t];
            if (marked && !(marked[v[0]] && marked[v[1]] && marked[v[2]])) continue;
            const pith_vec3 a = mesh->positions[v[0]];
            const fragment f = { t,
                                 0.5 * pith_length(pith_cross(pith_sub(mesh->positions[v[1]], a),
                                                              pith_sub(mesh->positions[v[2]], a))),
                                 { { 1, 0, 0 }, { 0, 1, 0 }, { 0, 0, 1 } } };
            if (!(f.area > 0.0)) continue;
            if (pass == 0) {
                area += f.area;
                all->greatest = fmax(all->greatest, f.area);
            } else if (!add_fragment(all, &f)) {
                return PITH_OUT_OF_MEMORY(err, "pieces of a surface");
            }
        }
    const double most = grains_per_square_radius * area / (radius * radius);
    if (most > MOST_GRAINS) return too_many(radius, 1.05 * radius * sqrt(most / MOST_GRAINS), err);
    return PITH_OK;
}

/* Halves a fragment across its longest edge and keeps the halves that hold places for grains, but for those so small that
   a gap there does not show. */
static bool halve(const pith_mesh_view *mesh, const field *near, const fragment *f, const pith_vec3 points[3],
                  fragments *all)
{
    double longest = 0.0;
    int across = 0; /* the corner opposite the longest edge */
    for (int k = 0; k < 3; ++k) {
        const double length = pith_distance(points[(k + 1) % 3], points[(k + 2) % 3]);
        if (length > longest) longest = length, across = k;
    }
    if (longest < 1e-4 * near->radius) return true;
    const int ends[2] = { (across + 1) % 3, (across + 2) % 3 };
    for (int half = 0; half < 2; ++half) {
        fragment made = *f;
        made.area = 0.5 * f->area;
        for (int i = 0; i < 3; ++i) made.corner[ends[half]][i] = 0.5 * (f->corner[ends[0]][i] + f->corner[ends[1]][i]);
        pith_vec3 corners[3];
        place_corners(mesh, &made, corners);
        if (!covered(near, corners, 3) && !add_fragment(all, &made)) return false;
    }
    return true;
}

static pith_status throw_darts(const pith_mesh_view *mesh, fragments *all, uint64_t seed, field *strewn,
                               pith_error *err)
{
    pith_rng rng = pith_rng_make(seed, 0x67726169); /* "grai" */
    fragment f;
    while (draw_fragment(all, &rng, &f)) {
        pith_vec3 points[3];
        place_corners(mesh, &f, points);
        const double root = sqrt(pith_rng_unit(&rng)), along = pith_rng_unit(&rng);
        const double w[3] = { 1.0 - root, root * (1.0 - along), root * along };
        sown dart = { .triangle = f.triangle, .at = pith_scale(points[0], w[0]) };
        for (int k = 1; k < 3; ++k) dart.at = pith_madd(dart.at, points[k], w[k]);
        for (int i = 0; i < 3; ++i)
            for (int k = 0; k < 3; ++k) dart.weight[i] += w[k] * f.corner[k][i];
        if (!covered(strewn, &dart.at, 1)) {
            if (strewn->count == MOST_GRAINS) return too_many(strewn->radius, 2.0 * strewn->radius, err);
            if (!add_grain(strewn, &dart)) return PITH_OUT_OF_MEMORY(err, "grains");
        }
        if (covered(strewn, points, 3)) continue;
        if (!halve(mesh, strewn, &f, points, all)) return PITH_OUT_OF_MEMORY(err, "pieces of a surface");
    }
    return PITH_OK;
}

/* ---- frames -------------------------------------------------------------------------------------------------------------- */

/* The direction along the axis within the surface. Where the surface lies across the axis, what it tends to beside: to
   the axis on top, away from it below; on the axis itself any. */
static pith_vec3 along_axis(pith_vec3 at, pith_vec3 normal)
{
    const pith_vec3 up = pith_reject(pith_v3(0, 0, 1), normal);
    if (pith_length(up) > 1e-3) return pith_unit(up);
    const pith_vec3 in = pith_reject(pith_v3(-at.x, -at.y, 0), normal);
    if (!(pith_length(in) > 0.0)) return pith_perpendicular(normal);
    return pith_scale(pith_unit(in), normal.z < 0.0 ? -1.0 : 1.0);
}

/* One of another seed, so that where grains stand does not depend on how they are turned. */
static pith_grain stand(const pith_mesh_view *mesh, const pith_vec3 *normals, const sown *grain,
                        const pith_grains_options *options, pith_rng *rng)
{
    const uint32_t *v = mesh->triangles[grain->triangle];
    pith_vec3 n = pith_v3(0, 0, 0);
    for (int k = 0; k < 3; ++k) n = pith_madd(n, normals[v[k]], grain->weight[k]);
    const pith_vec3 a = mesh->positions[v[0]];
    const pith_vec3 facet =
        pith_unit(pith_cross(pith_sub(mesh->positions[v[1]], a), pith_sub(mesh->positions[v[2]], a)));
    n = pith_unit(n);
    if (!(pith_dot(n, facet) > 0.0)) n = facet; /* normals that differ so much say nothing between them */
    const pith_vec3 along = along_axis(grain->at, n), across = pith_cross(along, n);
    const double turn = options->turn_spread * (M_PI / 180.0) * (2.0 * pith_rng_unit(rng) - 1.0);
    const double size = 1.0 + options->scale_spread * (2.0 * pith_rng_unit(rng) - 1.0);
    pith_grain made = { .origin = pith_madd(grain->at, n, options->offset),
                        .normal = n,
                        .scale = options->scale * size };
    made.along = pith_unit(pith_sub(pith_scale(along, cos(turn)), pith_scale(across, sin(turn))));
    made.across = pith_cross(made.along, n);
    return made;
}

static pith_status stand_all(const pith_mesh_view *mesh, const pith_grains_options *options, const field *strewn,
                             pith_grain **grains, pith_error *err)
{
    pith_vec3 *normals = pith_alloc(mesh->vertex_count, sizeof *normals);
    pith_grain *made = pith_alloc(strewn->count, sizeof *made);
    if (!normals || !made) {
        pith_free(normals);
        pith_free(made);
        return PITH_OUT_OF_MEMORY(err, "grains");
    }
    pith_mesh_vertex_normals(mesh, normals);
    pith_rng rng = pith_rng_make(options->seed, 0x7475726e); /* "turn" */
    for (size_t i = 0; i < strewn->count; ++i) made[i] = stand(mesh, normals, &strewn->grains[i], options, &rng);
    pith_free(normals);
    *grains = made;
    return PITH_OK;
}

pith_status pith_mesh_grains(const pith_mesh_view *base, const bool *marked, const pith_grains_options *options,
                             pith_grain **grains, size_t *count, pith_error *err)
{
    if (!base || !options || !grains || !count)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_mesh_grains: %s is NULL",
                         !base      ? "base"
                         : !options ? "options"
                         : !grains  ? "grains"
                                    : "count");
    PITH_TRY(pith_params_check(&pith_grains_params, options, err));
    PITH_TRY(surface_check_indices(base->triangles, base->triangle_count, base->vertex_count, err));
    const pith_box box = pith_box_of(base->positions, base->vertex_count);
    field f = { .radius = options->radius, .square = options->radius * options->radius, .low = box.low };
    fragments *all = pith_alloc(1, sizeof *all);
    pith_status status = PITH_OK;
    if (!all || !grow_chains(&f)) {
        status = PITH_OUT_OF_MEMORY(err, "grains");
        goto done;
    }
    PITH_TRY_OR(done, begin(base, marked, options->radius, all, err));
    PITH_TRY_OR(done, throw_darts(base, all, options->seed, &f, err));
    PITH_TRY_OR(done, stand_all(base, options, &f, grains, err));
    *count = f.count;
done:
    if (all) fragments_free(all);
    pith_free(all);
    pith_free(f.grains);
    pith_free(f.chains);
    return status;
}

/* ---- the grains' mesh ---------------------------------------------------------------------------------------------------- */

pith_status pith_grain_surface(const pith_curve *profile, const pith_curve *outline, uint32_t across, uint32_t along,
                               pith_mesh **mesh, pith_error *err)
{
    pith_mesh *swept = NULL;
    PITH_TRY(sketch_sweep_loops(profile, outline, across, along, &swept, err));
    /* The sweep has what is outward along x, what is across along y and the axis along z. */
    pith_mesh_view view = pith_mesh_look(swept);
    pith_vec3 *turned = pith_alloc(view.vertex_count, sizeof *turned);
    pith_status status = turned ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a grain");
    for (uint32_t v = 0; status == PITH_OK && v < view.vertex_count; ++v) {
        const pith_vec3 p = view.positions[v];
        turned[v] = pith_v3(p.y, p.z, p.x);
    }
    view.positions = turned;
    view.normals = NULL;
    if (status == PITH_OK) status = pith_mesh_create(&view, mesh, err);
    pith_free(turned);
    pith_mesh_destroy(swept);
    return status;
}

/* A direction of the grain's frame in space. */
static pith_vec3 turned(const pith_grain *g, pith_vec3 v)
{
    return pith_madd(pith_madd(pith_scale(g->across, v.x), g->along, v.y), g->normal, v.z);
}

pith_status pith_grains_mesh(const pith_mesh *grain, const pith_grain *grains, size_t count, pith_mesh **mesh,
                             pith_error *err)
{
    if (!grain || (count && !grains) || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_grains_mesh: %s is NULL",
                         !grain  ? "grain"
                         : !mesh ? "mesh"
                                 : "grains");
    const pith_mesh_view one = pith_mesh_look(grain);
    const double most = (double)count * fmax(one.vertex_count, one.triangle_count);
    if (!(most < 0x1p31))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%zu grains of %u vertices and %u triangles each are too many for a mesh; "
                         "use fewer samples for the grain or a larger radius",
                         count, one.vertex_count, one.triangle_count);
    const size_t n = count * one.vertex_count, m = count * one.triangle_count;
    pith_vec3 *positions = pith_alloc(n, sizeof *positions),
              *normals = one.normals ? pith_alloc(n, sizeof *normals) : NULL;
    float(*colours)[4] = one.colours ? pith_alloc(n, sizeof *colours) : NULL;
    float(*texcoords)[2] = one.texcoords ? pith_alloc(n, sizeof *texcoords) : NULL;
    uint32_t(*triangles)[3] = pith_alloc(m, sizeof *triangles);
    pith_status status = PITH_OK;
    if (!positions || !triangles || (one.normals && !normals) || (one.colours && !colours) ||
        (one.texcoords && !texcoords)) {
        status = PITH_OUT_OF_MEMORY(err, "a mesh of grains");
        goto done;
    }
    for (size_t i = 0; i < count; ++i) {
        const pith_grain *g = &grains[i];
        const size_t first = i * one.vertex_count;
        for (uint32_t v = 0; v < one.vertex_count; ++v) {
            positions[first + v] = pith_madd(g->origin, turned(g, one.positions[v]), g->scale);
            if (normals) normals[first + v] = turned(g, one.normals[v]);
            if (colours) memcpy(colours[first + v], one.colours[v], sizeof *colours);
            if (texcoords) memcpy(texcoords[first + v], one.texcoords[v], sizeof *texcoords);
        }
        for (uint32_t t = 0; t < one.triangle_count; ++t)
            for (int k = 0; k < 3; ++k)
                triangles[i * one.triangle_count + t][k] = (uint32_t)first + one.triangles[t][k];
    }
    const pith_mesh_view view = { .positions = positions,
                                  .normals = normals,
                                  .colours = (const float(*)[4])colours,
                                  .texcoords = (const float(*)[2])texcoords,
                                  .triangles = (const uint32_t(*)[3])triangles,
                                  .vertex_count = (uint32_t)n,
                                  .triangle_count = (uint32_t)m };
    status = pith_mesh_create(&view, mesh, err);
done:
    pith_free(positions);
    pith_free(normals);
    pith_free(colours);
    pith_free(texcoords);
    pith_free(triangles);
    return status;
}
