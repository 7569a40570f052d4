/* The tetrahedral mesh itself: making, looking, adjacency, boundary, measures. */
#include "tets_internal.h"

#include <string.h>

/* ---- adjacency ------------------------------------------------------------------------------------------------- */

static pith_face_key face_key(const uint32_t corners[4], int k)
{
    const uint8_t *f = pith_tet_faces[k];
    return pith_face_key_of(corners[f[0]], corners[f[1]], corners[f[2]]);
}

/* Do the three vertices of face k, counter-clockwise seen from outside, run like their ascending order? Neighbours lie
   on opposite sides of a face, so one says yes and the other no. */
static bool face_ascends(const uint32_t corners[4], int k)
{
    const uint8_t *f = pith_tet_faces[k];
    const uint32_t a = corners[f[0]], b = corners[f[1]], c = corners[f[2]];
    return (a < b) + (b < c) + (c < a) == 2;
}

/* Joins half face k of t with its partner; refuses a third one, and a partner on the same side. */
static pith_status join_faces(const uint32_t (*corners)[4], uint32_t (*neighbours)[4], uint32_t t, int k,
                              uint32_t other, int face, pith_error *err)
{
    const pith_face_key key = face_key(corners[t], k);
    if (neighbours[other][face] != PITH_NONE)
        return pith_fail(err, PITH_BAD_MESH, "the face %u %u %u belongs to tetrahedra %u, %u and %u; a face may have "
                         "two", key.v[0], key.v[1], key.v[2], other, neighbours[other][face], t);
    if (face_ascends(corners[t], k) == face_ascends(corners[other], face))
        return pith_fail(err, PITH_BAD_MESH, "tetrahedra %u and %u lie on the same side of their common face %u %u "
                         "%u: they overlap", other, t, key.v[0], key.v[1], key.v[2]);
    neighbours[other][face] = t;
    neighbours[t][k] = other;
    return PITH_OK;
}

pith_status pith_tets_link(const uint32_t (*corners)[4], uint32_t tet_count, uint32_t (*neighbours)[4],
                           pith_error *err)
{
    /* Open addressing; a slot holds the half face 4 t + k + 1 that came first, 0 when free. The partner of a face is
       found through neighbours, so that a third half face meets a slot whose face is already taken. */
    const size_t slots = pith_table_size(4 * (size_t)tet_count);
    uint64_t *table = pith_alloc(slots, sizeof *table);
    if (!table) return PITH_OUT_OF_MEMORY(err, "the face table");
    pith_status status = PITH_OK;
    for (uint32_t t = 0; t < tet_count; ++t)
        for (int k = 0; k < 4; ++k) neighbours[t][k] = PITH_NONE;
    for (uint64_t half = 0; half < 4 * (uint64_t)tet_count && status == PITH_OK; ++half) {
        const uint32_t t = (uint32_t)(half / 4);
        const int k = (int)(half % 4);
        const pith_face_key key = face_key(corners[t], k);
        for (size_t slot = pith_face_hash(key) & (slots - 1);; slot = (slot + 1) & (slots - 1)) {
            if (table[slot] == 0) {
                table[slot] = half + 1;
                break;
            }
            const uint32_t other = (uint32_t)((table[slot] - 1) / 4);
            const int face = (int)((table[slot] - 1) % 4);
            if (!pith_face_same(face_key(corners[other], face), key)) continue;
            status = join_faces(corners, neighbours, t, k, other, face, err);
            break;
        }
    }
    pith_free(table);
    return status;
}

/* ---- making ---------------------------------------------------------------------------------------------------- */

double pith_tets_volume_of(const pith_tets_view *tets, uint32_t t)
{
    const uint32_t *v = tets->tets[t];
    return pith_volume6(tets->positions[v[0]], tets->positions[v[1]], tets->positions[v[2]], tets->positions[v[3]]) /
           6.0;
}

/* Indices in range, finite positions, volumes made positive. */
static pith_status check_and_turn(const pith_vec3 *positions, uint32_t vertex_count, uint32_t (*corners)[4],
                                  uint32_t tet_count, pith_error *err)
{
    for (uint32_t i = 0; i < vertex_count; ++i)
        if (!pith_finite(positions[i]))
            return pith_fail(err, PITH_BAD_MESH, "vertex %u of the tetrahedral mesh is not finite", i);
    for (uint32_t t = 0; t < tet_count; ++t) {
        uint32_t *v = corners[t];
        for (int k = 0; k < 4; ++k)
            if (v[k] >= vertex_count)
                return pith_fail(err, PITH_BAD_MESH,
                                 "tetrahedron %u, corner %d points to vertex %u, but there are only %u vertices", t, k,
                                 v[k], vertex_count);
        const double volume = pith_volume6(positions[v[0]], positions[v[1]], positions[v[2]], positions[v[3]]);
        if (!(fabs(volume) > 0.0 && isfinite(volume)))
            return pith_fail(err, PITH_BAD_MESH, "tetrahedron %u (vertices %u %u %u %u) has no volume; remove it", t,
                             v[0], v[1], v[2], v[3]);
        if (volume < 0.0) {
            const uint32_t swap = v[2];
            v[2] = v[3];
            v[3] = swap;
        }
    }
    return PITH_OK;
}

pith_status pith_tets_adopt(pith_vec3 *positions, uint32_t vertex_count, uint32_t (*corners)[4], uint32_t tet_count,
                            pith_tets **tets, pith_error *err)
{
    pith_status status = PITH_OK;
    pith_tets *made = pith_alloc(1, sizeof *made);
    uint32_t (*neighbours)[4] = pith_alloc(tet_count, sizeof *neighbours);
    if (!made || !neighbours) {
        status = PITH_OUT_OF_MEMORY(err, "a tetrahedral mesh");
        goto fail;
    }
    PITH_TRY_OR(fail, check_and_turn(positions, vertex_count, corners, tet_count, err));
    PITH_TRY_OR(fail, pith_tets_link((const uint32_t (*)[4])corners, tet_count, neighbours, err));
    *made = (pith_tets){ positions, corners, neighbours, vertex_count, tet_count };
    *tets = made;
    return PITH_OK;
fail:
    pith_free(positions);
    pith_free(corners);
    pith_free(neighbours);
    pith_free(made);
    return status;
}

pith_status pith_tets_create(const pith_tets_view *from, pith_tets **tets, pith_error *err)
{
    if (!from || !tets || (from->vertex_count && !from->positions) || (from->tet_count && !from->tets))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_create: a pointer is NULL");
    pith_vec3 *positions = pith_alloc(from->vertex_count, sizeof *positions);
    uint32_t (*corners)[4] = pith_alloc(from->tet_count, sizeof *corners);
    if (!positions || !corners) {
        pith_free(positions);
        pith_free(corners);
        return PITH_OUT_OF_MEMORY(err, "a copy of the tetrahedra");
    }
    if (from->vertex_count) memcpy(positions, from->positions, from->vertex_count * sizeof *positions);
    if (from->tet_count) memcpy(corners, from->tets, from->tet_count * sizeof *corners);
    return pith_tets_adopt(positions, from->vertex_count, corners, from->tet_count, tets, err);
}

void pith_tets_destroy(pith_tets *tets)
{
    if (!tets) return;
    pith_free(tets->positions);
    pith_free(tets->tets);
    pith_free(tets->neighbours);
    pith_free(tets);
}

pith_tets_view pith_tets_look(const pith_tets *tets)
{
    return (pith_tets_view){ tets->positions, (const uint32_t (*)[4])tets->tets,
                             (const uint32_t (*)[4])tets->neighbours, tets->vertex_count, tets->tet_count };
}

/* ---- the boundary ---------------------------------------------------------------------------------------------- */

/* Numbers the vertices that boundary faces use, in their old order; returns how many, and the number of faces. */
static uint32_t number_boundary(const pith_tets *tets, uint32_t *new_index, uint32_t *face_count)
{
    uint32_t faces = 0, vertices = 0;
    for (uint32_t i = 0; i < tets->vertex_count; ++i) new_index[i] = PITH_NONE;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            if (tets->neighbours[t][k] != PITH_NONE) continue;
            ++faces;
            for (int c = 0; c < 3; ++c) new_index[tets->tets[t][pith_tet_faces[k][c]]] = 0;
        }
    for (uint32_t i = 0; i < tets->vertex_count; ++i)
        if (new_index[i] == 0) new_index[i] = vertices++;
    *face_count = faces;
    return vertices;
}

pith_status pith_tets_surface(const pith_tets *tets, pith_mesh **surface, uint32_t **source_vertex,
                              uint32_t **source_tet, pith_error *err)
{
    pith_status status = PITH_OK;
    pith_vec3 *positions = NULL;
    uint32_t (*triangles)[3] = NULL, *vertex_of = NULL, *tet_of = NULL;
    uint32_t *new_index = pith_alloc(tets->vertex_count, sizeof *new_index), face_count = 0, vertex_count = 0;
    if (new_index) {
        vertex_count = number_boundary(tets, new_index, &face_count);
        positions = pith_alloc(vertex_count, sizeof *positions);
        vertex_of = pith_alloc(vertex_count, sizeof *vertex_of);
        triangles = pith_alloc(face_count, sizeof *triangles);
        tet_of = pith_alloc(face_count, sizeof *tet_of);
    }
    if (!new_index || !positions || !vertex_of || !triangles || !tet_of) {
        status = PITH_OUT_OF_MEMORY(err, "the boundary surface");
        goto done;
    }

    for (uint32_t i = 0; i < tets->vertex_count; ++i)
        if (new_index[i] != PITH_NONE) {
            positions[new_index[i]] = tets->positions[i];
            vertex_of[new_index[i]] = i;
        }
    uint32_t f = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4; ++k) {
            if (tets->neighbours[t][k] != PITH_NONE) continue;
            for (int c = 0; c < 3; ++c) triangles[f][c] = new_index[tets->tets[t][pith_tet_faces[k][c]]];
            tet_of[f++] = t;
        }
    const pith_mesh_view view = { .positions = positions, .triangles = (const uint32_t (*)[3])triangles,
                                  .vertex_count = vertex_count, .triangle_count = face_count };
    PITH_TRY_OR(done, pith_mesh_create(&view, surface, err));
    if (source_vertex) { *source_vertex = vertex_of; vertex_of = NULL; }
    if (source_tet) { *source_tet = tet_of; tet_of = NULL; }
done:
    pith_free(new_index);
    pith_free(positions);
    pith_free(triangles);
    pith_free(vertex_of);
    pith_free(tet_of);
    return status;
}

/* ---- measures -------------------------------------------------------------------------------------------------- */

/* Smallest and largest of the six dihedral angles, degrees. atan2 of the cross and dot products of the outward face
   normals keeps its accuracy near 0 and 180 degrees, where the arc cosine loses half the digits. */
static void dihedral_range(const pith_vec3 p[4], double *low, double *high)
{
    pith_vec3 normals[4];
    for (int k = 0; k < 4; ++k) {
        const uint8_t *f = pith_tet_faces[k];
        normals[k] = pith_cross(pith_sub(p[f[1]], p[f[0]]), pith_sub(p[f[2]], p[f[0]]));
    }
    *low = INFINITY;
    *high = -INFINITY;
    for (int e = 0; e < 6; ++e) {
        const pith_vec3 m = normals[pith_tet_edges[e][0]], n = normals[pith_tet_edges[e][1]];
        const double angle = atan2(pith_length(pith_cross(m, n)), -pith_dot(m, n)) * (180.0 / 3.14159265358979323846);
        *low = fmin(*low, angle);
        *high = fmax(*high, angle);
    }
}

void pith_tets_measure(const pith_tets *tets, pith_tets_report *report)
{
    pith_tets_report r = { .tetrahedra = tets->tet_count, .vertices = tets->vertex_count };
    r.min_volume = r.min_dihedral = tets->tet_count ? INFINITY : 0.0;
    const pith_tets_view view = pith_tets_look(tets);
    uint32_t below = 0;
    for (uint32_t t = 0; t < tets->tet_count; ++t) {
        const double volume = pith_tets_volume_of(&view, t);
        pith_vec3 p[4];
        double low, high;
        for (int k = 0; k < 4; ++k) p[k] = tets->positions[tets->tets[t][k]];
        dihedral_range(p, &low, &high);
        r.volume += volume;
        r.min_volume = fmin(r.min_volume, volume);
        r.min_dihedral = fmin(r.min_dihedral, low);
        r.max_dihedral = fmax(r.max_dihedral, high);
        below += low < 10.0;
    }
    r.below_10_degrees = tets->tet_count ? (double)below / tets->tet_count : 0.0;
    *report = r;
}
