/* Turning triangles: all of a patch alike, closed patches outward, cavities inward. */
#include "mesh_internal.h"

#include <string.h>

typedef struct patch_facts {
    double volume; /* enclosed, once its triangles agree; about the patch's own centre when it is open */
    double area;
    pith_vec3 centre; /* area-weighted */
    pith_box box;
    uint32_t sample;  /* one of its triangles */
    uint32_t triangles, flipped;
    bool turn; /* the whole patch must turn once more */
} patch_facts;

static double sign_of_flip(const mesh_edges *edges, uint32_t t) { return edges->flip[t] ? -1.0 : 1.0; }

/* Volumes are taken about the patch's own centre: a small patch far from the origin keeps its digits. */
static void measure_patches(const pith_mesh_view *view, const mesh_edges *edges, patch_facts *facts)
{
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        patch_facts *fact = &facts[edges->patch[t]];
        const uint32_t *c = view->triangles[t];
        const double area = mesh_triangle_area(view, t);
        const pith_vec3 sum = pith_add(pith_add(view->positions[c[0]], view->positions[c[1]]), view->positions[c[2]]);
        fact->centre = pith_madd(fact->centre, sum, area / 3.0);
        fact->area += area;
        if (fact->triangles == 0) fact->box = pith_box_empty();
        for (int k = 0; k < 3; ++k) pith_box_add(&fact->box, view->positions[c[k]]);
        fact->sample = t;
        ++fact->triangles;
        fact->flipped += edges->flip[t];
    }
    for (uint32_t p = 0; p < edges->patch_count; ++p)
        facts[p].centre = pith_scale(facts[p].centre, facts[p].area > 0.0 ? 1.0 / facts[p].area : 0.0);
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        patch_facts *fact = &facts[edges->patch[t]];
        const uint32_t *c = view->triangles[t];
        fact->volume += sign_of_flip(edges, t) / 6.0 *
                        pith_volume6(fact->centre, view->positions[c[0]], view->positions[c[1]], view->positions[c[2]]);
    }
}

static bool box_within(pith_box inner, pith_box outer)
{
    return inner.low.x >= outer.low.x && inner.low.y >= outer.low.y && inner.low.z >= outer.low.z &&
           inner.high.x <= outer.high.x && inner.high.y <= outer.high.y && inner.high.z <= outer.high.z;
}

/* In how many closed patches patch p lies. A ray through an edge may miscount, so three rays vote on each. The ray asks
   for one place of p; two bodies that cross are told from a cavity by p's box, which a cavity has within the other's. */
static uint32_t nesting_depth(const pith_mesh_view *view, const mesh_tree *tree, const uint32_t *label, uint32_t p,
                              const patch_facts *facts, mesh_stab *stab, mesh_stab *votes)
{
    const uint32_t *c = view->triangles[facts[p].sample];
    const pith_vec3 sum = pith_add(pith_add(view->positions[c[0]], view->positions[c[1]]), view->positions[c[2]]);
    pith_rng rng = pith_rng_make(p, 0x6e657374); /* "nest" */
    for (int ray = 0; ray < 3; ++ray) {
        mesh_tree_stab(tree, view, pith_scale(sum, 1.0 / 3.0), pith_rng_direction(&rng), label, stab);
        for (uint32_t i = 0; i < stab->touched_count; ++i) {
            const uint32_t other = stab->touched[i];
            if (other == p || stab->count[other] % 2 == 0) continue;
            if (votes->count[other]++ == 0) votes->touched[votes->touched_count++] = other;
        }
        mesh_stab_clear(stab);
    }
    uint32_t depth = 0;
    for (uint32_t i = 0; i < votes->touched_count; ++i) {
        const uint32_t other = votes->touched[i];
        depth += votes->count[other] >= 2 && box_within(facts[p].box, facts[other].box);
    }
    mesh_stab_clear(votes);
    return depth;
}

/* Decides for each closed patch by its nesting, for each open one by the side that bulges. */
static void decide(const pith_mesh_view *view, const mesh_edges *edges, const mesh_tree *tree, const uint32_t *label,
                   patch_facts *facts, mesh_stab *stab, mesh_stab *votes)
{
    uint32_t closed = 0;
    for (uint32_t p = 0; p < edges->patch_count; ++p) closed += edges->patch_closed[p];
    for (uint32_t p = 0; p < edges->patch_count; ++p) {
        if (edges->patch_closed[p]) {
            const uint32_t depth = closed > 1 ? nesting_depth(view, tree, label, p, facts, stab, votes) : 0;
            facts[p].turn = (facts[p].volume < 0.0) != (depth % 2 == 1);
        } else {
            /* A bowl or a holed ball bulges by a good part of the volume a sphere of its area has; a sheet does not,
               and stays as most of its triangles were. */
            const double sphere = facts[p].area * sqrt(facts[p].area) / (6.0 * sqrt(M_PI));
            facts[p].turn = facts[p].volume < -0.01 * sphere;
        }
    }
}

static bool make_stab(mesh_stab *stab, uint32_t labels)
{
    stab->count = pith_alloc(labels, sizeof *stab->count);
    stab->touched = pith_alloc(labels, sizeof *stab->touched);
    return stab->count && stab->touched;
}

static pith_status decide_turns(const pith_mesh_view *view, const mesh_edges *edges, patch_facts *facts,
                                pith_error *err)
{
    mesh_tree tree = { 0 };
    mesh_stab stab = { 0 }, votes = { 0 };
    uint32_t *label = pith_alloc(view->triangle_count, sizeof *label);
    pith_status status = PITH_OK;
    if (!label || !make_stab(&stab, edges->patch_count) || !make_stab(&votes, edges->patch_count))
        status = PITH_OUT_OF_MEMORY(err, "turning the triangles");
    if (status == PITH_OK) status = mesh_tree_build(view, &tree, err);
    if (status == PITH_OK) {
        for (uint32_t t = 0; t < view->triangle_count; ++t)
            label[t] = edges->patch_closed[edges->patch[t]] ? edges->patch[t] : PITH_NONE;
        measure_patches(view, edges, facts);
        decide(view, edges, &tree, label, facts, &stab, &votes);
    }
    mesh_tree_free(&tree);
    pith_free(label);
    pith_free(stab.count);
    pith_free(stab.touched);
    pith_free(votes.count);
    pith_free(votes.touched);
    return status;
}

pith_status mesh_turn(pith_mesh *mesh, uint32_t *flipped, pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    mesh_edges edges;
    PITH_TRY(mesh_edges_find(&view, &edges, err));
    patch_facts *facts = pith_alloc(edges.patch_count, sizeof *facts);
    pith_status status = facts ? decide_turns(&view, &edges, facts, err) : PITH_OUT_OF_MEMORY(err, "the patches");
    for (uint32_t t = 0; status == PITH_OK && t < mesh->triangle_count; ++t) {
        if (edges.flip[t] == facts[edges.patch[t]].turn) continue;
        uint32_t *c = mesh->triangles[t];
        const uint32_t swapped = c[1];
        c[1] = c[2];
        c[2] = swapped;
        ++*flipped;
    }
    pith_free(facts);
    mesh_edges_free(&edges);
    return status;
}
