/* Normals of a shell that are smooth where it is smooth and break where it breaks: at the border of skin and section
   and at sharp edges.

   Source of the weights: Thürmer, Wüthrich, "Computing vertex normals from polygonal facets", Journal of Graphics Tools
   3(1), 1998: a triangle counts by its angle at the corner, so that the way a polygon was cut into triangles, which
   after a cut is arbitrary, does not show. */
#include "cut_internal.h"

void cut_corners_free(cut_corners *c)
{
    pith_free(c->first);
    pith_free(c->items);
    pith_free(c->facets);
}

pith_status cut_corners_make(const pith_shell *shell, cut_corners *c, pith_error *err)
{
    c->first = pith_alloc((size_t)shell->vertex_count + 2, sizeof *c->first);
    c->items = pith_alloc(shell->triangle_count, 3 * sizeof *c->items);
    c->facets = pith_alloc(shell->triangle_count, sizeof *c->facets);
    if (!c->first || !c->items || !c->facets) return PITH_OUT_OF_MEMORY(err, "triangles round vertices");

    /* Counted two places up, summed, and filled so that each start ends up one place up. */
    for (uint32_t i = 0; i < shell->triangle_count; ++i)
        for (int k = 0; k < 3; ++k) ++c->first[shell->triangles[i][k] + 2];
    for (uint32_t v = 2; v < shell->vertex_count + 2; ++v) c->first[v] += c->first[v - 1];
    for (uint32_t i = 0; i < shell->triangle_count; ++i)
        for (uint32_t k = 0; k < 3; ++k) c->items[c->first[shell->triangles[i][k] + 1]++] = 3 * i + k;

    for (uint32_t i = 0; i < shell->triangle_count; ++i) {
        const uint32_t *v = shell->triangles[i];
        const pith_vec3 ab = pith_sub(shell->positions[v[1]], shell->positions[v[0]]);
        const pith_vec3 ac = pith_sub(shell->positions[v[2]], shell->positions[v[0]]);
        const pith_vec3 n = pith_cross(ab, ac);
        const double longest = fmax(pith_dot(ab, ab), pith_dot(ac, ac));
        if (pith_length(n) > 1e-10 * longest) c->facets[i] = pith_unit(n);
    }
    return PITH_OK;
}

static double angle_at(const pith_shell *shell, uint32_t corner)
{
    const uint32_t *v = shell->triangles[corner / 3], k = corner % 3;
    const pith_vec3 p = shell->positions[v[k]];
    const pith_vec3 e = pith_sub(shell->positions[v[(k + 1) % 3]], p);
    const pith_vec3 f = pith_sub(shell->positions[v[(k + 2) % 3]], p);
    return atan2(pith_length(pith_cross(e, f)), pith_dot(e, f));
}

pith_status pith_shell_normals(const pith_shell *shell, double crease, pith_vec3 (*normals)[3], pith_error *err)
{
    if (!shell || !normals)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_shell_normals: %s is NULL", shell ? "normals" : "shell");
    if (!(crease >= 0.0 && crease <= 180.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "crease is %g degrees, expected 0 to 180", crease);
    pith_status status = PITH_OK;
    cut_corners c = { 0 };
    PITH_TRY_OR(done, cut_corners_make(shell, &c, err));

    const double turn = cos(crease * (M_PI / 180.0));
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (shell->triangle_count > 4096)
    for (uint32_t corner = 0; corner < 3 * shell->triangle_count; ++corner) {
        const uint32_t triangle = corner / 3, v = shell->triangles[triangle][corner % 3];
        const pith_vec3 own = c.facets[triangle];
        const bool flat = pith_dot(own, own) > 0.0; /* else it has no say and takes what its neighbours agree on */
        pith_vec3 sum = pith_v3(0, 0, 0);
        for (uint32_t j = c.first[v]; j < c.first[v + 1]; ++j) {
            const uint32_t other = c.items[j] / 3;
            if (shell->kinds[other] != shell->kinds[triangle]) continue;
            if (flat && !(pith_dot(own, c.facets[other]) >= turn) && other != triangle) continue;
            sum = pith_madd(sum, c.facets[other], angle_at(shell, c.items[j]));
        }
        sum = pith_unit(sum);
        normals[triangle][corner % 3] = pith_dot(sum, sum) > 0.0 ? sum : flat ? own : pith_v3(0, 0, 1);
    }
done:
    cut_corners_free(&c);
    return status;
}
