/* March: rays walk from tet to tet, from each boundary face they enter through to where they leave.

   On which side of an edge a ray passes is one determinant, of its direction and the edge's ends seen from the eye. It
   is evaluated in the same way by every tet round the edge, and zero is decided by moving the ray by nothing in a fixed
   direction, so that faces that meet neither miss a ray between them nor both take it (Edelsbrunner and Mücke,
   "Simulation of simplicity", 1990). The same determinants weigh a face's corners where the ray crosses it; between two
   faces of a tet everything is linear. */
#include "volume_internal.h"

#include <float.h>
#include <string.h>

enum { WINDOW = 8 }; /* planes a ray goes on for before it is looked at whether it has become opaque */

/* A ray's way through one body, from entering to leaving: where it stands. */
typedef struct visit {
    double z;                   /* depth at which it entered the tet */
    double at[4];               /* barycentric coordinates there */
    uint32_t ray, body, tet, apex; /* apex: the corner opposite the face it entered through */
    uint32_t plane, steps;      /* planes no deeper than z; tets behind it */
    bool done;
} visit;

struct volume_march {
    visit *found, *visits;      /* of the tile; the second list by ray and depth */
    size_t found_capacity, visits_capacity, count;
    uint32_t first[VOLUME_PIXELS + 1];  /* of each ray's visits */
    double shift[VOLUME_PIXELS];        /* of its planes, in steps */
};

volume_march *volume_march_new(void) { return pith_alloc(1, sizeof(volume_march)); }

void volume_march_free(volume_march *m)
{
    if (!m) return;
    pith_free(m->found);
    pith_free(m->visits);
    pith_free(m);
}

/* ---- sides ------------------------------------------------------------------------------------------------------ */

/* The plane through the eye and the edge from the lower to the higher vertex. */
static inline pith_vec3 edge_plane(const volume_body *body, uint32_t a, uint32_t b)
{
    return a < b ? pith_cross(body->eye[a], body->eye[b]) : pith_cross(body->eye[b], body->eye[a]);
}

/* Positive or negative, never zero. */
static inline double plane_side(pith_vec3 n, double x, double y)
{
    const double s = x * n.x + y * n.y + n.z;
    if (s != 0.0) return s;
    return n.x != 0.0 ? copysign(DBL_MIN, n.x) : n.y != 0.0 ? copysign(DBL_MIN, n.y) : DBL_MIN;
}

static inline double edge_side(const volume_body *body, uint32_t a, uint32_t b, double x, double y)
{
    const double s = plane_side(edge_plane(body, a, b), x, y);
    return a < b ? s : -s;
}

/* ---- entering --------------------------------------------------------------------------------------------------- */

/* Columns or rows of the tile that a face may cover, from its corners' places seen from the eye. */
static void cover(const double at[3], const double z[3], const double *lines, uint32_t count, uint32_t *first,
                  uint32_t *end)
{
    *first = 0;
    *end = count;
    const bool before = z[0] > 0.0 && z[1] > 0.0 && z[2] > 0.0, behind = z[0] < 0.0 && z[1] < 0.0 && z[2] < 0.0;
    if (!before && !behind) return;
    const double a = at[0] / z[0], b = at[1] / z[1], c = at[2] / z[2];
    const double low = fmin(a, fmin(b, c)), high = fmax(a, fmax(b, c)), air = 1e-9 * (fabs(low) + fabs(high));
    while (*first < count && lines[*first] < low - air) ++*first;
    while (*end > *first && lines[*end - 1] > high + air) --*end;
}

static pith_status add_visit(volume_march *m, const visit *v, pith_error *err)
{
    if (m->count == m->found_capacity &&
        !pith_grow((void **)&m->found, &m->found_capacity, m->count + 1, sizeof *m->found))
        return PITH_OUT_OF_MEMORY(err, "rays that enter a body");
    m->found[m->count++] = *v;
    return PITH_OK;
}

/* Rays that enter a body through the face. */
static pith_status enter_face(const volume_scene *scene, volume_march *m, volume_element e, const volume_rays *rays,
                              pith_error *err)
{
    const volume_body *body = &scene->bodies[e.body];
    const uint8_t *c = pith_tet_faces[e.corner];
    const uint32_t *tet = body->part.tets[e.tet], v[3] = { tet[c[0]], tet[c[1]], tet[c[2]] };
    const pith_vec3 p[3] = { body->eye[v[0]], body->eye[v[1]], body->eye[v[2]] };
    const double x[3] = { p[0].x, p[1].x, p[2].x }, y[3] = { p[0].y, p[1].y, p[2].y };
    const double z[3] = { p[0].z, p[1].z, p[2].z };
    uint32_t left, right, top, bottom;
    cover(x, z, rays->across, rays->width, &left, &right);
    cover(y, z, rays->down, rays->height, &top, &bottom);

    pith_vec3 planes[3]; /* of the edge opposite corner k */
    bool turned[3];
    for (int k = 0; k < 3; ++k) {
        const uint32_t a = v[(k + 1) % 3], b = v[(k + 2) % 3];
        planes[k] = edge_plane(body, a, b);
        turned[k] = a > b;
    }
    for (uint32_t j = top; j < bottom; ++j)
        for (uint32_t i = left; i < right; ++i) {
            double s[3];
            for (int k = 0; k < 3; ++k) {
                s[k] = plane_side(planes[k], rays->across[i], rays->down[j]);
                if (turned[k]) s[k] = -s[k];
            }
            if (!(s[0] < 0.0 && s[1] < 0.0 && s[2] < 0.0)) continue; /* counter-clockwise: negative where rays enter */
            const double sum = s[0] + s[1] + s[2];
            visit in = { .ray = j * RENDER_TILE + i, .body = e.body, .tet = e.tet, .apex = e.corner };
            for (int k = 0; k < 3; ++k) {
                in.at[c[k]] = s[k] / sum;
                in.z += s[k] / sum * z[k];
            }
            in.plane = volume_planes_to(scene, m->shift[in.ray], in.z);
            PITH_TRY(add_visit(m, &in, err));
        }
    return PITH_OK;
}

/* Brings the visits found into the order of rays, and of depth along each. */
static pith_status sort_visits(volume_march *m, pith_error *err)
{
    if (m->count > m->visits_capacity &&
        !pith_grow((void **)&m->visits, &m->visits_capacity, m->count, sizeof *m->visits))
        return PITH_OUT_OF_MEMORY(err, "rays that enter a body");
    memset(m->first, 0, sizeof m->first);
    for (size_t i = 0; i < m->count; ++i) ++m->first[m->found[i].ray + 1];
    for (uint32_t r = 0; r < VOLUME_PIXELS; ++r) m->first[r + 1] += m->first[r];
    for (size_t i = m->count; i-- > 0;) {
        /* Filled from the back, first[ray + 1] is lowered to the ray's own start. */
        const visit in = m->found[i];
        m->visits[--m->first[in.ray + 1]] = in;
    }
    memmove(m->first, m->first + 1, sizeof m->first - sizeof *m->first);
    m->first[VOLUME_PIXELS] = (uint32_t)m->count;
    for (uint32_t r = 0; r < VOLUME_PIXELS; ++r)
        for (uint32_t i = m->first[r] + 1; i < m->first[r + 1]; ++i) {
            const visit in = m->visits[i];
            uint32_t j = i;
            for (; j > m->first[r] && m->visits[j - 1].z > in.z; --j) m->visits[j] = m->visits[j - 1];
            m->visits[j] = in;
        }
    return PITH_OK;
}

/* ---- walking ---------------------------------------------------------------------------------------------------- */

/* Where a ray leaves a tet. */
typedef struct exit_place { double z, at[4]; uint32_t corner; /* opposite the face */ } exit_place;

static exit_place leave(const volume_body *body, const visit *v, double x, double y)
{
    const uint32_t *tet = body->part.tets[v->tet];
    const uint8_t *c = pith_tet_faces[v->apex];
    double side[3]; /* of the edges from the apex to the corners of the face it came through */
    for (int k = 0; k < 3; ++k) side[k] = edge_side(body, tet[v->apex], tet[c[k]], x, y);
    /* It passes between a corner with negative and the next with positive side; where rounding leaves none such, the
       edge it is nearest to is passed on the other side. */
    if ((side[0] < 0.0) == (side[1] < 0.0) && (side[1] < 0.0) == (side[2] < 0.0)) {
        const double size[3] = { fabs(side[0]), fabs(side[1]), fabs(side[2]) };
        const int least = size[0] <= size[1] ? (size[0] <= size[2] ? 0 : 2) : (size[1] <= size[2] ? 1 : 2);
        side[least] = side[least] < 0.0 ? DBL_MIN : -DBL_MIN;
    }
    int i = 0;
    while (!(side[i] < 0.0 && side[(i + 1) % 3] > 0.0)) ++i;
    const int j = (i + 1) % 3;

    exit_place out = { .corner = c[(i + 2) % 3] };
    const double toward_j = -side[i], toward_i = side[j];
    const double toward_apex = fmax(0.0, -edge_side(body, tet[c[i]], tet[c[j]], x, y));
    const double sum = toward_i + toward_j + toward_apex;
    out.at[c[i]] = toward_i / sum;
    out.at[c[j]] = toward_j / sum;
    out.at[v->apex] = toward_apex / sum;
    for (int k = 0; k < 4; ++k) out.z += out.at[k] * body->eye[tet[k]].z;
    out.z = fmax(out.z, v->z);
    return out;
}

/* Into the neighbour beyond the face it left through. */
static void step_over(const volume_scene *scene, const volume_body *body, visit *v, const exit_place *out, double shift)
{
    const uint32_t next = body->neighbours[v->tet][out->corner];
    v->done = next == PITH_NONE || ++v->steps >= body->part.tet_count; /* a straight line meets no tet twice */
    if (v->done) return;
    const uint32_t *from = body->part.tets[v->tet], *to = body->part.tets[next];
    v->apex = 0;
    for (uint32_t k = 0; k < 4; ++k) {
        int same = -1;
        for (int c = 0; c < 4; ++c)
            if (from[c] == to[k]) same = c;
        if (same < 0) v->apex = k;
        v->at[k] = same < 0 ? 0.0 : out->at[same];
    }
    v->tet = next;
    v->z = out->z;
    v->plane = volume_planes_to(scene, shift, out->z);
}

static void mix_at(const volume_body *body, uint32_t tet, const double at[4], double mix[VOLUME_MIX])
{
    for (int k = 0; k < VOLUME_MIX; ++k) mix[k] = 0.0;
    for (int c = 0; c < 4; ++c) {
        double corner[VOLUME_MIX];
        volume_corner_mix(body, tet, c, corner);
        for (int k = 0; k < VOLUME_MIX; ++k) mix[k] += at[c] * corner[k];
    }
}

/* Samples at planes first .. end - 1, which lie between where the ray entered the tet and where it leaves. */
static void add_samples(const volume_scene *scene, const visit *v, const exit_place *out, uint32_t first, uint32_t end,
                        double shift, volume_batch *batch)
{
    const volume_body *body = &scene->bodies[v->body];
    const uint32_t source = body->part.source_tet[v->tet];
    double from[VOLUME_MIX], to[VOLUME_MIX], mix[VOLUME_MIX];
    mix_at(body, v->tet, v->at, from);
    mix_at(body, v->tet, out->at, to);
    const double scale = 1.0 / (out->z - v->z);
    for (int k = 0; k < VOLUME_MIX; ++k) to[k] -= from[k];
    for (uint32_t plane = first; plane < end; ++plane) {
        const double z = volume_plane(scene, shift, plane), t = fmin(1.0, fmax(0.0, (z - v->z) * scale));
        for (int k = 0; k < VOLUME_MIX; ++k) mix[k] = from[k] + t * to[k];
        volume_batch_add(batch, v->body, source, plane, v->ray, (float)(scene->pixel * z), mix);
    }
}

/* Goes on up to plane `end`. */
static void walk(const volume_scene *scene, visit *v, uint32_t end, double x, double y, double shift,
                 volume_batch *batch, uint32_t from)
{
    const volume_body *body = &scene->bodies[v->body];
    while (!v->done && v->plane < end) {
        const exit_place out = leave(body, v, x, y);
        const uint32_t planes = volume_planes_to(scene, shift, out.z);
        const uint32_t first = v->plane > from ? v->plane : from, last = planes < end ? planes : end;
        if (first < last) add_samples(scene, v, &out, first, last, shift, batch);
        if (planes > end) return; /* goes on in this tet next time */
        step_over(scene, body, v, &out, shift);
    }
}

/* ---- the tile --------------------------------------------------------------------------------------------------- */

static void set_shifts(const volume_scene *scene, volume_march *m, const volume_rays *rays, uint32_t sample)
{
    const pith_volume_options *o = scene->options;
    for (uint32_t j = 0; j < rays->height; ++j)
        for (uint32_t i = 0; i < rays->width; ++i) {
            double pair[2] = { 0.5, 0.5 };
            const uint64_t at = (uint64_t)(rays->top + j) << 32 | (rays->left + i);
            if (o->jitter)
                render_pair(pith_mix64(o->seed ^ pith_mix64(at)), sample, o->samples, RENDER_LIGHT, pair);
            m->shift[j * RENDER_TILE + i] = pair[0];
        }
}

/* All visits of a ray up to plane `end`; false when nothing of it is left. Bodies that overlap give their samples one
   after the other: the order is mended. */
static bool go_on(const volume_scene *scene, volume_march *m, uint32_t ray, uint32_t from, uint32_t end,
                  const volume_rays *rays, volume_batch *batch)
{
    const size_t start = batch->count;
    const double x = rays->across[ray % RENDER_TILE], y = rays->down[ray / RENDER_TILE];
    bool left = false;
    for (uint32_t i = m->first[ray]; i < m->first[ray + 1]; ++i) {
        visit *v = &m->visits[i];
        if (!v->done && v->plane < end) walk(scene, v, end, x, y, m->shift[ray], batch, from);
        left = left || (!v->done && v->plane < scene->options->slices);
    }
    if (scene->body_count == 1) return left;
    for (size_t i = start + 1; i < batch->count; ++i) {
        const uint32_t at = batch->order[i];
        size_t j = i;
        for (; j > start && batch->plane[batch->order[j - 1]] > batch->plane[at]; --j)
            batch->order[j] = batch->order[j - 1];
        batch->order[j] = at;
    }
    return left;
}

pith_status volume_march_tile(const volume_scene *scene, volume_march *m, uint32_t tile, uint32_t sample,
                              volume_batch *batch, volume_rays *rays, pith_error *err)
{
    m->count = 0;
    set_shifts(scene, m, rays, sample);
    for (uint32_t i = scene->bin_start[tile]; i < scene->bin_start[tile + 1]; ++i)
        PITH_TRY(enter_face(scene, m, scene->bins[i], rays, err));
    PITH_TRY(sort_visits(m, err));

    uint32_t plane = scene->options->slices;
    for (size_t i = 0; i < m->count; ++i)
        if (m->visits[i].plane < plane) plane = m->visits[i].plane;
    const uint32_t slices = scene->options->slices;
    for (bool left = true; left && plane < slices; plane += WINDOW) {
        const uint32_t end = slices - plane < WINDOW ? slices : plane + WINDOW;
        left = false;
        for (uint32_t ray = 0; ray < VOLUME_PIXELS; ++ray) {
            if (m->first[ray] == m->first[ray + 1] || !(rays->through[ray] > volume_opaque)) continue;
            if (batch->capacity - batch->count < (size_t)WINDOW * scene->body_count)
                PITH_TRY(volume_batch_flush(scene, batch, rays, err));
            left = go_on(scene, m, ray, plane, end, rays, batch) || left;
        }
    }
    return volume_batch_flush(scene, batch, rays, err);
}
