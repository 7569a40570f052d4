/* From tetrahedra that share vertices across sheets to such that do not: every fan of tetrahedra about a vertex that can be
   walked through without passing a sheet gets a vertex of its own, and with it a colour of its own. Round the rim of an open
   surface there is one fan. */
#include "poisson_internal.h"

#include <string.h>

#define NO_WALL   PITH_NONE
#define BALL_WALL (PITH_NONE - 1)

typedef struct work {
    const pith_diffusion *diffusion;
    const facets *all;
    pith_tets_view tets;
    uint32_t *wall;    /* [4 * tet_count] the sheets' triangle that the face opposite a corner lies on, or the above */
    uint32_t *fan;     /* [4 * tet_count] union-find over corners, then the number of the fan */
    uint32_t *region;  /* [tet_count] */
    uint32_t *queue;   /* [tet_count] */
    bool *seen_region; /* [region_count] something is to be seen in it */
    uint32_t region_count, fan_count, outside;
    pith_vec3 *positions;    /* [fan_count] */
    double (*sum)[CHANNELS]; /* [fan_count] of values, measured from the first that the fan met */
    double (*first)[CHANNELS];
    uint32_t *met;                 /* [fan_count] faces of sheets, three to each */
    double (*bounds)[CHANNELS][2]; /* [region_count] */
} work;

static void work_free(work *gone)
{
    pith_free(gone->wall);
    pith_free(gone->fan);
    pith_free(gone->region);
    pith_free(gone->queue);
    pith_free(gone->seen_region);
    pith_free(gone->positions);
    pith_free(gone->sum);
    pith_free(gone->first);
    pith_free(gone->met);
    pith_free(gone->bounds);
}

/* ---- walls ---------------------------------------------------------------------------------------------------------------- */

static void sort_three(uint32_t v[3])
{
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k + 1 < 3; ++k)
            if (v[k] > v[k + 1]) {
                const uint32_t held = v[k];
                v[k] = v[k + 1], v[k + 1] = held;
            }
}

/* Pieces of facets by their vertices: open addressing over sorted triples. */
typedef struct face_table {
    uint32_t (*key)[3];
    uint32_t *facet; /* + 1; 0 free */
    size_t slots;
} face_table;

static size_t face_slot(const face_table *table, const uint32_t key[3])
{
    size_t slot = pith_hash_bytes(key, 3 * sizeof *key, 0) & (table->slots - 1);
    while (table->facet[slot] && memcmp(table->key[slot], key, 3 * sizeof *key) != 0)
        slot = (slot + 1) & (table->slots - 1);
    return slot;
}

static pith_status find_walls(work *w, const pith_conforming *filled, pith_error *err)
{
    face_table table = { .slots = 16 };
    while (table.slots < 2 * (size_t)filled->face_count) table.slots *= 2;
    table.key = pith_alloc(table.slots, sizeof *table.key);
    table.facet = pith_alloc(table.slots, sizeof *table.facet);
    const bool made = table.key && table.facet;
    for (uint32_t f = 0; made && f < filled->face_count; ++f) {
        uint32_t key[3];
        memcpy(key, filled->faces[f], sizeof key);
        sort_three(key);
        const size_t slot = face_slot(&table, key);
        memcpy(table.key[slot], key, sizeof key);
        table.facet[slot] = filled->facet[f] + 1;
    }
    for (size_t i = 0; made && i < 4 * (size_t)w->tets.tet_count; ++i) {
        const uint32_t *v = w->tets.tets[i / 4];
        const uint8_t *c = pith_tet_faces[i % 4];
        uint32_t key[3] = { v[c[0]], v[c[1]], v[c[2]] };
        sort_three(key);
        const uint32_t facet = table.facet[face_slot(&table, key)];
        const uint32_t source = facet ? w->all->source[facet - 1] : PITH_NONE;
        w->wall[i] = !facet ? NO_WALL : source == PITH_NONE ? BALL_WALL : source;
    }
    pith_free(table.key);
    pith_free(table.facet);
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the faces on sheets");
}

/* ---- fans ----------------------------------------------------------------------------------------------------------------- */

static uint32_t root_of(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

/* Joins the corners that two neighbours have at the vertices they share. */
static void join_corners(work *w, uint32_t t, int k, uint32_t other)
{
    for (int c = 0; c < 4; ++c) {
        if (c == k) continue;
        for (int d = 0; d < 4; ++d) {
            if (w->tets.tets[other][d] != w->tets.tets[t][c]) continue;
            const uint32_t a = root_of(w->fan, 4 * t + (uint32_t)c), b = root_of(w->fan, 4 * other + (uint32_t)d);
            if (a < b)
                w->fan[b] = a;
            else
                w->fan[a] = b;
        }
    }
}

/* Numbers fans in the order of their first corners. */
static void find_fans(work *w)
{
    const uint32_t corners = 4 * w->tets.tet_count;
    for (uint32_t i = 0; i < corners; ++i) w->fan[i] = i;
    for (uint32_t i = 0; i < corners; ++i) {
        const uint32_t other = w->tets.neighbours[i / 4][i % 4];
        if (w->wall[i] == NO_WALL && other != PITH_NONE && other > i / 4) join_corners(w, i / 4, (int)(i % 4), other);
    }
    for (uint32_t i = 0; i < corners; ++i) /* parents have the lower index, and have been numbered */
        w->fan[i] = w->fan[i] == i ? w->fan_count++ : w->fan[w->fan[i]];
}

static void find_regions(work *w)
{
    for (uint32_t t = 0; t < w->tets.tet_count; ++t) w->region[t] = PITH_NONE;
    w->outside = PITH_NONE;
    for (uint32_t seed = 0; seed < w->tets.tet_count; ++seed) {
        if (w->region[seed] != PITH_NONE) continue;
        uint32_t count = 0;
        w->queue[count++] = seed;
        w->region[seed] = w->region_count;
        for (uint32_t i = 0; i < count; ++i)
            for (uint32_t k = 0; k < 4; ++k) {
                const uint32_t t = w->queue[i], other = w->tets.neighbours[t][k];
                if (w->wall[4 * (size_t)t + k] == BALL_WALL) w->outside = w->region_count;
                if (w->wall[4 * (size_t)t + k] != NO_WALL || other == PITH_NONE || w->region[other] != PITH_NONE)
                    continue;
                w->region[other] = w->region_count;
                w->queue[count++] = other;
            }
        ++w->region_count;
    }
}

/* ---- colours at walls ------------------------------------------------------------------------------------------------------- */

/* The colour of a side of a sheet at a point of one of its triangles. */
static paint colour_at(const pith_diffusion *diffusion, uint32_t triangle, bool back, pith_vec3 p)
{
    double weights[3];
    pith_nearest_on_triangle(diffusion->placed[triangle].corner, p, weights);
    return sheet_colour(diffusion, triangle, back, weights);
}

static void add_value(work *w, uint32_t fan, uint32_t region, paint colour)
{
    double q[CHANNELS];
    for (int k = 0; k < 3; ++k) q[k] = (double)colour[k] * (double)colour[3];
    q[3] = (double)colour[3];
    if (w->met[fan]++ == 0) memcpy(w->first[fan], q, sizeof q);
    for (int k = 0; k < CHANNELS; ++k) w->sum[fan][k] += q[k] - w->first[fan][k];
    const bool seen = colour[3] > 0.0f;
    w->seen_region[region] = w->seen_region[region] || seen;
    for (int k = seen ? 0 : 3; k < CHANNELS; ++k) { /* what has no opacity has no colour */
        double *bounds = w->bounds[region][k];
        bounds[0] = fmin(bounds[0], (double)colour[k]);
        bounds[1] = fmax(bounds[1], (double)colour[k]);
    }
}

/* A tetrahedron behind a triangle has the face's outward normal in common with it, and sees its back. */
static void colour_walls(work *w)
{
    for (uint32_t i = 0; i < 4 * w->tets.tet_count; ++i) {
        if (w->wall[i] == NO_WALL || w->wall[i] == BALL_WALL) continue;
        const uint32_t triangle = w->wall[i], t = i / 4, *v = w->tets.tets[t];
        const uint8_t *c = pith_tet_faces[i % 4];
        const pith_vec3 *p = w->tets.positions, a = p[v[c[0]]];
        const pith_vec3 outward = pith_cross(pith_sub(p[v[c[1]]], a), pith_sub(p[v[c[2]]], a));
        const bool back = pith_dot(outward, w->diffusion->placed[triangle].normal) > 0.0;
        for (int k = 0; k < 3; ++k)
            add_value(w, w->fan[4 * t + c[k]], w->region[t], colour_at(w->diffusion, triangle, back, p[v[c[k]]]));
    }
}

/* ---- what is kept -------------------------------------------------------------------------------------------------------------- */

void sided_free(sided *gone)
{
    pith_free(gone->positions);
    pith_free(gone->tets);
    pith_free(gone->fixed);
    pith_free(gone->value);
    pith_free(gone->region);
    pith_free(gone->bounds);
    pith_free(gone->rim);
    *gone = (sided){ 0 };
}

/* Room for all, though regions may be left out. */
static pith_status sided_allocate(const work *w, sided *made, pith_error *err)
{
    uint32_t rim = 0;
    for (size_t i = 0; i < 4 * (size_t)w->tets.tet_count; ++i) rim += w->wall[i] == BALL_WALL;
    made->positions = pith_alloc(w->fan_count, sizeof *made->positions);
    made->tets = pith_alloc(w->tets.tet_count, sizeof *made->tets);
    made->fixed = pith_alloc(w->fan_count, sizeof *made->fixed);
    made->value = pith_alloc(w->fan_count, sizeof *made->value);
    made->region = pith_alloc(w->tets.tet_count, sizeof *made->region);
    made->bounds = pith_alloc(w->region_count, sizeof *made->bounds);
    made->rim = pith_alloc(rim, sizeof *made->rim);
    if (made->positions && made->tets && made->fixed && made->value && made->region && made->bounds && made->rim)
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "tetrahedra with sides");
}

/* A value measured from the reference is exactly 0 where all values are the same. */
static void keep_vertex(const work *w, uint32_t fan, pith_vec3 position, sided *made)
{
    const uint32_t v = made->vertex_count++;
    made->positions[v] = position;
    made->fixed[v] = w->met[fan] > 0;
    if (!made->fixed[v]) return;
    for (int k = 0; k < CHANNELS; ++k)
        made->value[v][k] = w->first[fan][k] - made->reference[k] + w->sum[fan][k] / w->met[fan];
}

static void keep(const work *w, uint32_t *number, sided *made)
{
    for (uint32_t i = 0; i < w->fan_count; ++i) number[i] = PITH_NONE;
    for (uint32_t t = 0; t < w->tets.tet_count; ++t) {
        if (!w->seen_region[w->region[t]]) continue;
        for (uint32_t k = 0; k < 4; ++k) {
            const uint32_t fan = w->fan[4 * (size_t)t + k];
            if (number[fan] == PITH_NONE) {
                number[fan] = made->vertex_count;
                keep_vertex(w, fan, w->tets.positions[w->tets.tets[t][k]], made);
            }
            made->tets[made->tet_count][k] = number[fan];
        }
        for (uint32_t k = 0; k < 4; ++k) {
            if (w->wall[4 * (size_t)t + k] != BALL_WALL) continue;
            for (int c = 0; c < 3; ++c)
                made->rim[made->rim_count][c] = made->tets[made->tet_count][pith_tet_faces[k][c]];
            ++made->rim_count;
        }
        made->region[made->tet_count++] = w->region[t];
    }
}

static bool work_allocate(work *w)
{
    const size_t tets = w->tets.tet_count;
    w->wall = pith_alloc(4 * tets, sizeof *w->wall);
    w->fan = pith_alloc(4 * tets, sizeof *w->fan);
    w->region = pith_alloc(tets, sizeof *w->region);
    w->queue = pith_alloc(tets, sizeof *w->queue);
    return w->wall && w->fan && w->region && w->queue;
}

static bool work_allocate_values(work *w)
{
    w->seen_region = pith_alloc(w->region_count, sizeof *w->seen_region);
    w->bounds = pith_alloc(w->region_count, sizeof *w->bounds);
    w->sum = pith_alloc(w->fan_count, sizeof *w->sum);
    w->first = pith_alloc(w->fan_count, sizeof *w->first);
    w->met = pith_alloc(w->fan_count, sizeof *w->met);
    for (size_t r = 0; w->bounds && r < w->region_count; ++r)
        for (int k = 0; k < CHANNELS; ++k) w->bounds[r][k][0] = INFINITY, w->bounds[r][k][1] = -INFINITY;
    return w->seen_region && w->bounds && w->sum && w->first && w->met;
}

/* The first value met of all that is kept. */
static void choose_reference(const work *w, sided *made)
{
    for (size_t i = 0; i < 4 * (size_t)w->tets.tet_count; ++i)
        if (w->met[w->fan[i]] > 0 && w->seen_region[w->region[i / 4]] && w->first[w->fan[i]][3] > 0.0) {
            memcpy(made->reference, w->first[w->fan[i]], sizeof made->reference);
            return;
        }
}

pith_status sided_make(const pith_diffusion *diffusion, const facets *all, const pith_conforming *filled, sided *made,
                       pith_error *err)
{
    work w = { .diffusion = diffusion, .all = all, .tets = pith_tets_look(filled->tets) };
    sided own = { .outside = PITH_NONE };
    uint32_t *number = NULL;
    pith_status status = PITH_OK;
    if (w.tets.tet_count > PITH_NONE / 4) {
        status = pith_fail(err, PITH_BAD_ARGUMENT, "%u tetrahedra are more than 32-bit indices can name; raise edge",
                           w.tets.tet_count);
        goto done;
    }
    if (!work_allocate(&w)) {
        status = PITH_OUT_OF_MEMORY(err, "the sides of sheets");
        goto done;
    }
    PITH_TRY_OR(done, find_walls(&w, filled, err));
    find_fans(&w);
    find_regions(&w);
    number = pith_alloc(w.fan_count, sizeof *number);
    if (!work_allocate_values(&w) || !number) {
        status = PITH_OUT_OF_MEMORY(err, "the sides of sheets");
        goto done;
    }
    colour_walls(&w);
    PITH_TRY_OR(done, sided_allocate(&w, &own, err));
    choose_reference(&w, &own);
    keep(&w, number, &own);
    own.region_count = w.region_count;
    memcpy(own.bounds, w.bounds, w.region_count * sizeof *own.bounds);
    if (w.outside != PITH_NONE && w.seen_region[w.outside]) own.outside = w.outside;
    *made = own;
    own = (sided){ 0 };
done:
    work_free(&w);
    sided_free(&own);
    pith_free(number);
    return status;
}
