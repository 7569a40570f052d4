/* Parts and shells: making, looking, measuring. */
#include "cut_internal.h"

#include <string.h>

/* ---- the common origin ------------------------------------------------------------------------------------------ */

static cut_origin *origin_share(cut_origin *origin)
{
    if (origin) atomic_fetch_add(&origin->users, 1);
    return origin;
}

static void origin_release(cut_origin *origin)
{
    if (!origin || atomic_fetch_sub(&origin->users, 1) != 1) return;
    pith_free(origin->positions);
    pith_free(origin->guides);
    pith_free(origin->tets);
    pith_free(origin);
}

static pith_status origin_new(const pith_tets_view *view, cut_origin **origin, pith_error *err)
{
    cut_origin *o = pith_alloc(1, sizeof *o);
    if (!o) return PITH_OUT_OF_MEMORY(err, "a part's origin");
    atomic_init(&o->users, 1);
    o->vertex_count = view->vertex_count;
    o->positions = pith_alloc(view->vertex_count, sizeof *o->positions);
    o->guides = pith_alloc(view->vertex_count, sizeof *o->guides);
    o->tets = pith_alloc(view->tet_count, sizeof *o->tets);
    if (!o->positions || !o->guides || !o->tets) {
        origin_release(o);
        return PITH_OUT_OF_MEMORY(err, "a part's origin");
    }
    const pith_status status = cut_origin_guides(view, o->guides, err);
    if (status != PITH_OK) {
        origin_release(o);
        return status;
    }
    memcpy(o->positions, view->positions, view->vertex_count * sizeof *o->positions);
    memcpy(o->tets, view->tets, view->tet_count * sizeof *o->tets);
    *origin = o;
    return PITH_OK;
}

/* ---- parts ------------------------------------------------------------------------------------------------------ */

void pith_part_destroy(pith_part *part)
{
    if (!part) return;
    origin_release(part->origin);
    pith_free(part->positions);
    pith_free(part->material);
    pith_free(part->tets);
    pith_free(part->source_tet);
    pith_free(part->faces);
    pith_free(part);
}

pith_status cut_part_new(cut_origin *origin, uint32_t vertex_count, uint32_t tet_count, pith_part **part,
                         pith_error *err)
{
    pith_part *p = pith_alloc(1, sizeof *p);
    if (!p) return PITH_OUT_OF_MEMORY(err, "a part");
    p->origin = origin_share(origin);
    p->vertex_count = vertex_count;
    p->tet_count = tet_count;
    p->positions = pith_alloc(vertex_count, sizeof *p->positions);
    p->material = pith_alloc(vertex_count, sizeof *p->material);
    p->tets = pith_alloc(tet_count, sizeof *p->tets);
    p->source_tet = pith_alloc(tet_count, sizeof *p->source_tet);
    p->faces = pith_alloc(tet_count, sizeof *p->faces);
    if (!p->positions || !p->material || !p->tets || !p->source_tet || !p->faces) {
        pith_part_destroy(p);
        return PITH_OUT_OF_MEMORY(err, "a part's vertices and tets");
    }
    *part = p;
    return PITH_OK;
}

pith_status pith_part_whole(const pith_tets *tets, pith_part **part, pith_error *err)
{
    if (!tets || !part)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_whole: %s is NULL", tets ? "part" : "tets");
    const pith_tets_view view = pith_tets_look(tets);
    cut_origin *origin = NULL;
    PITH_TRY(origin_new(&view, &origin, err));
    pith_part *p;
    const pith_status status = cut_part_new(origin, view.vertex_count, view.tet_count, &p, err);
    origin_release(origin); /* the part keeps it, or nobody does */
    if (status != PITH_OK) return status;

    memcpy(p->positions, view.positions, view.vertex_count * sizeof *p->positions);
    memcpy(p->material, view.positions, view.vertex_count * sizeof *p->material);
    memcpy(p->tets, view.tets, view.tet_count * sizeof *p->tets);
    for (uint32_t t = 0; t < view.tet_count; ++t) {
        p->source_tet[t] = t;
        for (unsigned k = 0; k < 4; ++k)
            if (view.neighbours[t][k] == PITH_NONE) p->faces[t] |= cut_face_bits(1 + PITH_SKIN, k);
    }
    *part = p;
    return PITH_OK;
}

pith_part_view pith_part_look(const pith_part *part)
{
    if (!part) return (pith_part_view){ 0 };
    return (pith_part_view){ part->positions, part->material, (const uint32_t (*)[4])part->tets, part->source_tet,
                             part->vertex_count, part->tet_count };
}

double pith_part_volume(const pith_part *part)
{
    double six = 0.0;
    for (uint32_t t = 0; part && t < part->tet_count; ++t) {
        const uint32_t *v = part->tets[t];
        six += pith_volume6(part->positions[v[0]], part->positions[v[1]], part->positions[v[2]],
                            part->positions[v[3]]);
    }
    return six / 6.0;
}

pith_box pith_part_model_box(const pith_part *part)
{
    return part->origin ? pith_box_of(part->origin->positions, part->origin->vertex_count) : pith_box_empty();
}

pith_status pith_part_plane_values(const pith_part *part, const pith_plane *plane, double *values, pith_error *err)
{
    if (!part || !plane || !values)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_plane_values: %s is NULL",
                         !part ? "part" : !plane ? "plane" : "values");
    const pith_vec3 n = plane->normal;
    const double largest = fmax(fabs(n.x), fmax(fabs(n.y), fabs(n.z)));
    if (!pith_finite(n) || !pith_finite(plane->point) || !(largest > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "a plane through (%g, %g, %g) with normal (%g, %g, %g) cannot cut; give finite numbers and a "
                         "normal that is not zero",
                         plane->point.x, plane->point.y, plane->point.z, n.x, n.y, n.z);

    /* Scaled before the length is taken, so that very long and very short normals neither overflow nor vanish. */
    const pith_vec3 unit = pith_unit(pith_scale(n, 1.0 / largest));
    const pith_box box = pith_box_of(part->positions, part->vertex_count);
    const double on_plane = part->vertex_count ? 1e-12 * pith_distance(box.low, box.high) : 0.0;
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (part->vertex_count > 16384)
    for (uint32_t i = 0; i < part->vertex_count; ++i) {
        const double d = pith_dot(pith_sub(part->positions[i], plane->point), unit);
        values[i] = fabs(d) <= on_plane ? 0.0 : d;
    }
    return PITH_OK;
}

/* ---- shells ----------------------------------------------------------------------------------------------------- */

void pith_shell_destroy(pith_shell *shell)
{
    if (!shell) return;
    origin_release(shell->origin);
    pith_free(shell->positions);
    pith_free(shell->material);
    pith_free(shell->triangles);
    pith_free(shell->source_tet);
    pith_free(shell->kinds);
    pith_free(shell);
}

pith_shell_view pith_shell_look(const pith_shell *shell)
{
    if (!shell) return (pith_shell_view){ 0 };
    return (pith_shell_view){ shell->positions, shell->material, (const uint32_t (*)[3])shell->triangles,
                              shell->source_tet, shell->kinds, shell->vertex_count, shell->triangle_count };
}

pith_status cut_soup_reserve(cut_soup *soup, size_t count, pith_error *err)
{
    return pith_grow((void **)&soup->items, &soup->capacity, count, sizeof *soup->items)
               ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a shell's triangles");
}

pith_status cut_soup_add(cut_soup *soup, const cut_triangle *triangle, pith_error *err)
{
    if (soup->count == soup->capacity) PITH_TRY(cut_soup_reserve(soup, soup->count + 1, err));
    soup->items[soup->count++] = *triangle;
    return PITH_OK;
}

pith_status cut_shell_new(cut_origin *origin, uint32_t vertex_count, uint32_t triangle_count, pith_shell **shell,
                          pith_error *err)
{
    pith_shell *s = pith_alloc(1, sizeof *s);
    if (!s) return PITH_OUT_OF_MEMORY(err, "a shell");
    s->origin = origin_share(origin);
    s->vertex_count = vertex_count;
    s->triangle_count = triangle_count;
    s->positions = pith_alloc(vertex_count, sizeof *s->positions);
    s->material = pith_alloc(vertex_count, sizeof *s->material);
    s->triangles = pith_alloc(triangle_count, sizeof *s->triangles);
    s->source_tet = pith_alloc(triangle_count, sizeof *s->source_tet);
    s->kinds = pith_alloc(triangle_count, sizeof *s->kinds);
    if (!s->positions || !s->material || !s->triangles || !s->source_tet || !s->kinds) {
        pith_shell_destroy(s);
        return PITH_OUT_OF_MEMORY(err, "a shell's vertices and triangles");
    }
    *shell = s;
    return PITH_OK;
}

pith_status cut_shell_make(const pith_part *part, const cut_march *march, const cut_soup *soup, pith_shell **shell,
                           pith_error *err)
{
    if (soup->count >= PITH_NONE / 3)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the shell would have %zu triangles; indices end at %u vertices",
                         soup->count, (unsigned)PITH_NONE);
    pith_status status = PITH_OK;
    pith_shell *s = NULL;
    const size_t codes = (size_t)part->vertex_count + (march ? march->edges.count : 0);
    uint32_t *number = pith_alloc(codes, sizeof *number); /* of a code's vertex, plus one; 0: not used yet */
    uint32_t *code_of = pith_alloc(codes < 3 * soup->count ? codes : 3 * soup->count, sizeof *code_of);
    if (!number || !code_of) {
        status = PITH_OUT_OF_MEMORY(err, "numbering a shell's vertices");
        goto done;
    }

    uint32_t vertex_count = 0;
    for (size_t i = 0; i < soup->count; ++i)
        for (int k = 0; k < 3; ++k) {
            const uint32_t code = soup->items[i].v[k];
            if (number[code]) continue;
            code_of[vertex_count] = code;
            number[code] = ++vertex_count;
        }
    PITH_TRY_OR(done, cut_shell_new(part->origin, vertex_count, (uint32_t)soup->count, &s, err));
    for (uint32_t i = 0; i < vertex_count; ++i) {
        if (code_of[i] < part->vertex_count) {
            s->positions[i] = part->positions[code_of[i]];
            s->material[i] = part->material[code_of[i]];
        } else {
            cut_march_vertex(march, code_of[i], &s->positions[i], &s->material[i]);
        }
    }
    for (size_t i = 0; i < soup->count; ++i) {
        for (int k = 0; k < 3; ++k) s->triangles[i][k] = number[soup->items[i].v[k]] - 1;
        s->source_tet[i] = soup->items[i].source_tet;
        s->kinds[i] = soup->items[i].kind;
    }
    *shell = s;
done:
    pith_free(number);
    pith_free(code_of);
    return status;
}

pith_status pith_part_shell(const pith_part *part, pith_shell **shell, pith_error *err)
{
    if (!part || !shell)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_part_shell: %s is NULL", part ? "shell" : "part");
    pith_status status = PITH_OK;
    cut_soup soup = { 0 };
    size_t outer = 0;
    for (uint32_t t = 0; t < part->tet_count; ++t)
        for (unsigned k = 0; part->faces[t] && k < 4; ++k) outer += cut_face_code(part->faces[t], k) != 0;
    PITH_TRY_OR(done, cut_soup_reserve(&soup, outer, err));
    for (uint32_t t = 0; t < part->tet_count; ++t) {
        for (unsigned k = 0; part->faces[t] && k < 4; ++k) {
            const unsigned code = cut_face_code(part->faces[t], k);
            if (!code) continue;
            const uint8_t *c = pith_tet_faces[k];
            const uint32_t *v = part->tets[t];
            const cut_triangle face = { { v[c[0]], v[c[1]], v[c[2]] }, part->source_tet[t], (uint8_t)(code - 1) };
            PITH_TRY_OR(done, cut_soup_add(&soup, &face, err));
        }
    }
    status = cut_shell_make(part, NULL, &soup, shell, err);
done:
    pith_free(soup.items);
    return status;
}

pith_status pith_shell_mesh(const pith_shell *shell, pith_mesh **mesh, pith_error *err)
{
    if (!shell || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_shell_mesh: %s is NULL", shell ? "mesh" : "shell");
    const pith_mesh_view view = { .positions = shell->positions,
                                  .triangles = (const uint32_t (*)[3])shell->triangles,
                                  .vertex_count = shell->vertex_count,
                                  .triangle_count = shell->triangle_count };
    return pith_mesh_create(&view, mesh, err);
}

void pith_shell_measure(const pith_shell *shell, double *skin, double *section, double *volume)
{
    double area[2] = { 0.0, 0.0 }, six = 0.0;
    /* Volumes are taken from a vertex of the shell: far from the origin they would be small differences of large. */
    const pith_vec3 apex = shell && shell->vertex_count ? shell->positions[0] : pith_v3(0, 0, 0);
    for (uint32_t i = 0; shell && i < shell->triangle_count; ++i) {
        const uint32_t *v = shell->triangles[i];
        const pith_vec3 a = pith_sub(shell->positions[v[0]], apex), b = pith_sub(shell->positions[v[1]], apex),
                        c = pith_sub(shell->positions[v[2]], apex);
        area[shell->kinds[i] == PITH_SECTION] += 0.5 * pith_length(pith_cross(pith_sub(b, a), pith_sub(c, a)));
        six += pith_dot(a, pith_cross(b, c));
    }
    if (skin) *skin = area[0];
    if (section) *section = area[1];
    if (volume) *volume = six / 6.0;
}

/* Of a point in one of the origin's tets; its middle for a tet without volume. */
static void origin_weights(const cut_origin *origin, uint32_t tet, pith_vec3 point, double w[4])
{
    const uint32_t *t = origin->tets[tet];
    const pith_vec3 *p = origin->positions;
    if (!pith_barycentric(p[t[0]], p[t[1]], p[t[2]], p[t[3]], point, w)) w[0] = w[1] = w[2] = w[3] = 0.25;
}

void pith_shell_weights(const pith_shell *shell, double (*weights)[3][4])
{
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (shell->triangle_count > 4096)
    for (uint32_t i = 0; i < shell->triangle_count; ++i)
        for (int k = 0; k < 3; ++k)
            origin_weights(shell->origin, shell->source_tet[i], shell->material[shell->triangles[i][k]], weights[i][k]);
}

void pith_part_weights(const pith_part *part, double (*weights)[4][4])
{
#pragma omp parallel for num_threads(pith_threads()) schedule(static) if (part->tet_count > 4096)
    for (uint32_t i = 0; i < part->tet_count; ++i)
        for (int k = 0; k < 4; ++k)
            origin_weights(part->origin, part->source_tet[i], part->material[part->tets[i][k]], weights[i][k]);
}
