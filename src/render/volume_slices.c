/* Slices: iso-surfaces of the depth along the line of sight, tet by tet, filled row by row and laid over one another
   from the front (Takayama 2008 §5.1.2; thesis §5.3.1, "Volume Rendering").

   Where a plane of equal depth passes through a tet it cuts out a triangle or a quadrilateral with corners on the
   tet's edges (marching tetrahedra, Treece et al. 1999). A corner is computed from the edge's lower vertex to its
   higher one, and a side from its upper corner to its lower one, so that pieces that share it compute the same bits;
   a row takes the pixels from one crossing, rounded up, to the next, rounded up. So the pieces of a slice leave no
   pixel out and take none twice, and no slice is ever held as a mesh. */
#include "volume_internal.h"

#include <string.h>

/* A tet while slices pass through it: what is mixed at a point p of it is base + slope * (p - corner). */
typedef struct piece {
    uint32_t body, tet, source, end; /* end: the slice beyond the last that crosses it */
    pith_vec3 corner;
    double base[VOLUME_MIX];
    pith_vec3 slope[VOLUME_MIX];
} piece;

struct volume_slicer {
    piece *pieces;              /* as many as the tile's bin has */
    size_t piece_capacity, list_capacity, slice_capacity, active_capacity;
    uint32_t *list;             /* the bin's elements by their first slice */
    uint32_t *slice_start;      /* [slices + 1] into list */
    uint32_t *active;           /* elements that the slice may cross */
};

volume_slicer *volume_slicer_new(void) { return pith_alloc(1, sizeof(volume_slicer)); }

void volume_slicer_free(volume_slicer *s)
{
    if (!s) return;
    pith_free(s->pieces);
    pith_free(s->list);
    pith_free(s->slice_start);
    pith_free(s->active);
    pith_free(s);
}

/* ---- lists ------------------------------------------------------------------------------------------------------ */

/* Slices that cross a tet: first .. end - 1. */
static void slices_of(const volume_scene *scene, volume_element e, uint32_t *first, uint32_t *end)
{
    const volume_body *body = &scene->bodies[e.body];
    double near = INFINITY, far = -INFINITY;
    for (int k = 0; k < 4; ++k) {
        const double z = body->eye[body->part.tets[e.tet][k]].z;
        near = fmin(near, z), far = fmax(far, z);
    }
    *first = volume_planes_to(scene, 0.5, near);
    *end = volume_planes_to(scene, 0.5, far);
}

static pith_status make_lists(const volume_scene *scene, volume_slicer *s, uint32_t tile, pith_error *err)
{
    const volume_element *bin = scene->bins + scene->bin_start[tile];
    const uint32_t count = scene->bin_start[tile + 1] - scene->bin_start[tile], slices = scene->options->slices;
    if (!pith_grow((void **)&s->pieces, &s->piece_capacity, count, sizeof *s->pieces) ||
        !pith_grow((void **)&s->list, &s->list_capacity, count, sizeof *s->list) ||
        !pith_grow((void **)&s->active, &s->active_capacity, count, sizeof *s->active) ||
        !pith_grow((void **)&s->slice_start, &s->slice_capacity, (size_t)slices + 2, sizeof *s->slice_start))
        return PITH_OUT_OF_MEMORY(err, "the tets of a tile");
    memset(s->slice_start, 0, ((size_t)slices + 2) * sizeof *s->slice_start);
    uint32_t first, end;
    for (uint32_t i = 0; i < count; ++i) {
        slices_of(scene, bin[i], &first, &end);
        ++s->slice_start[first + 2];
    }
    for (uint32_t k = 2; k < slices + 2; ++k) s->slice_start[k] += s->slice_start[k - 1];
    for (uint32_t i = 0; i < count; ++i) {
        slices_of(scene, bin[i], &first, &end);
        s->list[s->slice_start[first + 1]++] = i;
    }
    return PITH_OK;
}

static void begin_piece(const volume_scene *scene, volume_element e, piece *p)
{
    const volume_body *body = &scene->bodies[e.body];
    const uint32_t *tet = body->part.tets[e.tet];
    p->body = e.body;
    p->tet = e.tet;
    p->source = body->part.source_tet[e.tet];
    p->corner = body->eye[tet[0]];
    uint32_t first;
    slices_of(scene, e, &first, &p->end);
    pith_vec3 gradients[4];
    const bool solid = pith_barycentric_gradients(body->eye[tet[0]], body->eye[tet[1]], body->eye[tet[2]],
                                                  body->eye[tet[3]], gradients);
    double mix[4][VOLUME_MIX];
    for (int c = 0; c < 4; ++c) volume_corner_mix(body, e.tet, c, mix[c]);
    for (int k = 0; k < VOLUME_MIX; ++k) {
        p->base[k] = mix[0][k];
        p->slope[k] = pith_v3(0, 0, 0); /* without volume it has hardly a pixel to answer for */
        for (int c = 0; solid && c < 4; ++c) p->slope[k] = pith_madd(p->slope[k], gradients[c], mix[c][k]);
    }
}

/* ---- one piece of one slice ------------------------------------------------------------------------------------- */

typedef struct spot { double x, y; } spot; /* X and Y */

/* Corners of the plane's polygon in the tet, in order round it; returns how many. */
static int cut_out(const volume_body *body, const uint32_t tet[4], double z, spot corners[4])
{
    int near[4], far[4], nears = 0, fars = 0;
    for (int k = 0; k < 4; ++k)
        if (body->eye[tet[k]].z < z) near[nears++] = k;
        else far[fars++] = k;
    if (!nears || !fars) return 0;
    int edges[4][2], count = 0;
    for (int i = 0; i < nears; ++i)
        for (int j = 0; j < fars; ++j) {
            edges[count][0] = near[i];
            edges[count++][1] = far[nears == 2 && i == 1 ? 1 - j : j]; /* round the quadrilateral, not across it */
        }
    for (int i = 0; i < count; ++i) {
        uint32_t low = tet[edges[i][0]], high = tet[edges[i][1]];
        if (low > high) { const uint32_t swap = low; low = high; high = swap; }
        const pith_vec3 a = body->eye[low], b = body->eye[high];
        const double t = (z - a.z) / (b.z - a.z);
        corners[i] = (spot){ (a.x + t * (b.x - a.x)) / z, (a.y + t * (b.y - a.y)) / z };
    }
    return count;
}

/* First of the tile's columns or rows at or beyond a place. */
static uint32_t line_from(const double *lines, uint32_t count, double pixel, double at)
{
    const double guess = ceil((at - lines[0]) / pixel);
    uint32_t i = !(guess > 0.0) ? 0 : guess >= count ? count : (uint32_t)guess;
    while (i > 0 && lines[i - 1] >= at) --i; /* the division rounds: the comparison decides */
    while (i < count && lines[i] < at) ++i;
    return i;
}

typedef struct spans { uint32_t top, bottom; double low[RENDER_TILE], high[RENDER_TILE]; } spans;

/* Where the polygon's sides cross each row: a row at y belongs to a side from its upper corner to before its lower. */
static void find_spans(const volume_rays *rays, double pixel, const spot *corners, int count, spans *s)
{
    uint32_t row[4]; /* the first that is not above the corner */
    s->top = rays->height;
    s->bottom = 0;
    for (int i = 0; i < count; ++i) {
        row[i] = line_from(rays->down, rays->height, pixel, corners[i].y);
        if (row[i] < s->top) s->top = row[i];
        if (row[i] > s->bottom) s->bottom = row[i];
    }
    for (uint32_t j = s->top; j < s->bottom; ++j) s->low[j] = INFINITY, s->high[j] = -INFINITY;
    for (int i = 0; i < count; ++i) {
        int upper = i, lower = (i + 1) % count;
        if (corners[upper].y > corners[lower].y) lower = i, upper = (i + 1) % count;
        if (row[upper] == row[lower]) continue;
        const spot a = corners[upper], b = corners[lower];
        const double slope = (b.x - a.x) / (b.y - a.y);
        for (uint32_t j = row[upper]; j < row[lower]; ++j) {
            const double x = a.x + (rays->down[j] - a.y) * slope;
            if (x < s->low[j]) s->low[j] = x;
            if (x > s->high[j]) s->high[j] = x;
        }
    }
}

static pith_status fill_piece(const volume_scene *scene, const piece *p, uint32_t slice, volume_batch *batch,
                              volume_rays *rays, pith_error *err)
{
    const volume_body *body = &scene->bodies[p->body];
    const double z = volume_plane(scene, 0.5, slice);
    spot corners[4];
    spans s;
    const int count = cut_out(body, body->part.tets[p->tet], z, corners);
    if (!count) return PITH_OK;
    find_spans(rays, scene->pixel, corners, count, &s);
    if (s.top >= s.bottom) return PITH_OK;
    if (batch->capacity - batch->count < VOLUME_PIXELS) PITH_TRY(volume_batch_flush(scene, batch, rays, err));

    const float footprint = (float)(scene->pixel * z);
    double row[VOLUME_MIX], along[VOLUME_MIX], mix[VOLUME_MIX];
    for (int k = 0; k < VOLUME_MIX; ++k) along[k] = z * p->slope[k].x;
    for (uint32_t j = s.top; j < s.bottom; ++j) {
        const uint32_t first = line_from(rays->across, rays->width, scene->pixel, s.low[j]);
        const uint32_t end = line_from(rays->across, rays->width, scene->pixel, s.high[j]);
        if (first >= end) continue;
        const pith_vec3 at = pith_sub(pith_v3(0, z * rays->down[j], z), p->corner);
        for (int k = 0; k < VOLUME_MIX; ++k) row[k] = p->base[k] + pith_dot(p->slope[k], at);
        for (uint32_t i = first; i < end; ++i) {
            const uint32_t ray = j * RENDER_TILE + i;
            if (!(rays->through[ray] > volume_opaque)) continue;
            for (int k = 0; k < VOLUME_MIX; ++k) mix[k] = row[k] + rays->across[i] * along[k];
            volume_batch_add(batch, p->body, p->source, slice, ray, footprint, mix);
        }
    }
    return PITH_OK;
}

/* ---- the tile --------------------------------------------------------------------------------------------------- */

/* Whether a pixel still lets light through. */
static bool any_open(const volume_rays *rays)
{
    for (uint32_t j = 0; j < rays->height; ++j)
        for (uint32_t i = 0; i < rays->width; ++i)
            if (rays->through[j * RENDER_TILE + i] > volume_opaque) return true;
    return false;
}

pith_status volume_slicer_tile(const volume_scene *scene, volume_slicer *s, uint32_t tile, volume_batch *batch,
                               volume_rays *rays, pith_error *err)
{
    const volume_element *bin = scene->bins + scene->bin_start[tile];
    PITH_TRY(make_lists(scene, s, tile, err));
    uint32_t active = 0;
    for (uint32_t slice = 0; slice < scene->options->slices; ++slice) {
        for (uint32_t i = s->slice_start[slice]; i < s->slice_start[slice + 1]; ++i) {
            begin_piece(scene, bin[s->list[i]], &s->pieces[s->list[i]]);
            s->active[active++] = s->list[i];
        }
        uint32_t kept = 0;
        for (uint32_t i = 0; i < active; ++i) {
            const piece *p = &s->pieces[s->active[i]];
            if (slice < p->end) PITH_TRY(fill_piece(scene, p, slice, batch, rays, err));
            if (slice + 1 < p->end) s->active[kept++] = s->active[i];
        }
        active = kept;
        if (batch->count == 0 && active > 0 && !any_open(rays)) break;
    }
    return volume_batch_flush(scene, batch, rays, err);
}
