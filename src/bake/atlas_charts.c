/* Charts: connected pieces of skin or of section whose facets all look about one way, so that laying them flat along that
   way stretches them by a known factor at most.

   They grow from seeds, nearest first, with the angle to the chart's axis as part of the distance, so that borders come
   to lie in folds; axes and seeds are then moved to the middle of what grew, and everything grows again (after
   Cohen-Steiner, Alliez and Desbrun, "Variational Shape Approximation", SIGGRAPH 2004, with a hard limit on the angle);
   neighbours that fit within one cone are made one. */
#include "atlas_internal.h"

#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 2, RELAXATIONS = 3 };
static const double fold_cost = 3.0; /* a step to a facet at the limit counts as this many more along the axis */

double atlas_cone_cosine(const pith_atlas_options *options) { return 1.0 / options->stretch; }

/* ---- cones ------------------------------------------------------------------------------------------------------- */

static double farthest(const pith_vec3 *directions, size_t count, pith_vec3 axis, size_t *index)
{
    double least = 1.0;
    *index = 0;
    for (size_t i = 0; i < count; ++i) {
        const double cosine = pith_dot(directions[i], axis);
        if (cosine < least && pith_dot(directions[i], directions[i]) > 0.0) {
            least = cosine;
            *index = i;
        }
    }
    return least;
}

/* Bădoiu and Clarkson, "Smaller Core-Sets for Balls", SODA 2003: again and again a shorter step to the farthest one. */
double atlas_cone(const pith_vec3 *directions, size_t count, pith_vec3 *axis)
{
    size_t index;
    pith_vec3 at = *axis;
    double best = farthest(directions, count, at, &index);
    for (int step = 1; step <= 60 && count > 1; ++step) {
        at = pith_unit(pith_madd(at, pith_sub(directions[index], at), 1.0 / (step + 1)));
        const double cosine = farthest(directions, count, at, &index);
        if (cosine > best) {
            best = cosine;
            *axis = at;
        }
    }
    return best;
}

/* ---- growing ----------------------------------------------------------------------------------------------------- */

/* A triangle that a chart could take next. */
typedef struct step {
    double cost;
    uint32_t triangle, chart;
} step;
typedef struct growth {
    atlas *atlas;
    step *heap;
    size_t count, room;
    double cosine;
} growth;

static bool before(const step *a, const step *b)
{
    if (a->cost != b->cost) return a->cost < b->cost;
    return a->triangle != b->triangle ? a->triangle < b->triangle : a->chart < b->chart;
}

static pith_status push(growth *g, double cost, uint32_t triangle, uint32_t chart, pith_error *err)
{
    if (!pith_grow((void **)&g->heap, &g->room, g->count + 1, sizeof *g->heap))
        return PITH_OUT_OF_MEMORY(err, "growing charts");
    const step added = { cost, triangle, chart };
    size_t at = g->count++;
    for (size_t up; at > 0 && before(&added, &g->heap[up = (at - 1) / 2]); at = up) g->heap[at] = g->heap[up];
    g->heap[at] = added;
    return PITH_OK;
}

static step pop(growth *g)
{
    const step least = g->heap[0], last = g->heap[--g->count];
    size_t at = 0;
    for (size_t child = 1; child < g->count; child = 2 * at + 1) {
        if (child + 1 < g->count && before(&g->heap[child + 1], &g->heap[child])) ++child;
        if (!before(&g->heap[child], &last)) break;
        g->heap[at] = g->heap[child];
        at = child;
    }
    g->heap[at] = last;
    return least;
}

static bool fits(const growth *g, uint32_t triangle, pith_vec3 axis)
{
    const pith_vec3 facet = g->atlas->surface.facets[triangle];
    return pith_dot(facet, axis) >= g->cosine || !(pith_dot(facet, facet) > 0.0);
}

/* Lets everything grow that was pushed. */
static pith_status spread(growth *g, pith_error *err)
{
    const atlas_surface *s = &g->atlas->surface;
    while (g->count > 0) {
        const step at = pop(g);
        if (g->atlas->chart_of[at.triangle] != PITH_NONE) continue;
        g->atlas->chart_of[at.triangle] = at.chart;
        const pith_vec3 axis = g->atlas->charts[at.chart].axis;
        for (int k = 0; k < 3; ++k) {
            const uint32_t next = s->mates[at.triangle][k];
            if (next == PITH_NONE || g->atlas->chart_of[next] != PITH_NONE || !fits(g, next, axis)) continue;
            const double turned = fmax(0.0, 1.0 - pith_dot(s->facets[next], axis)) / (1.0 - g->cosine);
            const double far = pith_distance(s->middles[at.triangle], s->middles[next]);
            PITH_TRY(push(g, at.cost + far * (1.0 + fold_cost * turned), next, at.chart, err));
        }
    }
    return PITH_OK;
}

static pith_status add_chart(atlas *a, pith_vec3 axis, pith_error *err)
{
    if (!pith_grow((void **)&a->charts, &a->chart_room, a->chart_count + 1, sizeof *a->charts))
        return PITH_OUT_OF_MEMORY(err, "charts");
    a->charts[a->chart_count++] = (atlas_chart){ .axis = axis };
    return PITH_OK;
}

typedef struct ranked {
    double key;
    uint32_t index;
} ranked;

static int by_key_down(const void *a, const void *b)
{
    const ranked *x = a, *y = b;
    if (x->key != y->key) return x->key > y->key ? -1 : 1;
    return x->index < y->index ? -1 : x->index > y->index;
}

/* One chart after the other for what is in none, from the largest triangle on. */
static pith_status grow_rest(growth *g, pith_error *err)
{
    atlas *a = g->atlas;
    const atlas_surface *s = &a->surface;
    size_t count = 0;
    for (uint32_t t = 0; t < s->triangle_count; ++t) count += a->chart_of[t] == PITH_NONE;
    ranked *seeds = pith_alloc(count, sizeof *seeds);
    if (!seeds) return PITH_OUT_OF_MEMORY(err, "seeds of charts");
    count = 0;
    for (uint32_t t = 0; t < s->triangle_count; ++t)
        if (a->chart_of[t] == PITH_NONE) seeds[count++] = (ranked){ s->areas[t], t };
    qsort(seeds, count, sizeof *seeds, by_key_down);
    pith_status status = PITH_OK;
    for (size_t i = 0; status == PITH_OK && i < count; ++i) {
        const uint32_t seed = seeds[i].index;
        if (a->chart_of[seed] != PITH_NONE) continue;
        pith_vec3 axis = s->facets[seed];
        for (int k = 0; k < 3; ++k) {
            const uint32_t mate = s->mates[seed][k];
            if (mate != PITH_NONE && a->chart_of[mate] == PITH_NONE) axis = pith_add(axis, s->facets[mate]);
        }
        axis = pith_unit(axis);
        if (!fits(g, seed, axis)) axis = s->facets[seed];
        if (!(pith_dot(axis, axis) > 0.0)) axis = pith_v3(0, 0, 1);
        status = add_chart(a, axis, err);
        if (status == PITH_OK) status = push(g, 0.0, seed, (uint32_t)a->chart_count - 1, err);
        if (status == PITH_OK) status = spread(g, err);
    }
    pith_free(seeds);
    return status;
}

/* ---- members ----------------------------------------------------------------------------------------------------- */

/* Charts without triangles go, the others are numbered by their first triangle. */
static pith_status renumber(atlas *a, pith_error *err)
{
    uint32_t *number = pith_alloc(a->chart_count, sizeof *number), count = 0;
    atlas_chart *kept = pith_alloc(a->chart_count, sizeof *kept);
    if (!number || !kept) {
        pith_free(number);
        pith_free(kept);
        return PITH_OUT_OF_MEMORY(err, "charts");
    }
    memset(number, 0xff, a->chart_count * sizeof *number);
    for (uint32_t t = 0; t < a->surface.triangle_count; ++t) {
        uint32_t *chart = &a->chart_of[t];
        if (*chart == PITH_NONE) continue;
        if (number[*chart] == PITH_NONE) {
            kept[count] = a->charts[*chart];
            number[*chart] = count++;
        }
        *chart = number[*chart];
    }
    memcpy(a->charts, kept, count * sizeof *kept);
    a->chart_count = count;
    pith_free(number);
    pith_free(kept);
    return PITH_OK;
}

/* Lists every chart's triangles in order, by number. */
static void list_members(atlas *a)
{
    for (size_t c = 0; c < a->chart_count; ++c) a->charts[c].count = 0;
    for (uint32_t t = 0; t < a->surface.triangle_count; ++t) ++a->charts[a->chart_of[t]].count;
    uint32_t first = 0;
    for (size_t c = 0; c < a->chart_count; ++c) {
        a->charts[c].first = first;
        first += a->charts[c].count;
        a->charts[c].count = 0;
    }
    for (uint32_t t = 0; t < a->surface.triangle_count; ++t) {
        atlas_chart *chart = &a->charts[a->chart_of[t]];
        a->order[chart->first + chart->count++] = t;
    }
}

/* Triangles connected with the first one inside its chart, from `filled` on in the queue; returns the queue's new end. */
static uint32_t flood(const atlas *a, uint32_t first, uint32_t *queue, uint32_t filled, bool *seen)
{
    uint32_t next = filled;
    seen[first] = true;
    for (queue[filled++] = first; next < filled; ++next)
        for (int k = 0; k < 3; ++k) {
            const uint32_t mate = a->surface.mates[queue[next]][k];
            if (mate == PITH_NONE || seen[mate] || a->chart_of[mate] != a->chart_of[first]) continue;
            seen[mate] = true;
            queue[filled++] = mate;
        }
    return filled;
}

/* Puts every chart's triangles so that each lies beside an earlier one. What does not hang together with its chart's
   first triangle leaves the chart. */
static pith_status order_members(atlas *a, pith_error *err)
{
    bool *seen = pith_alloc(a->surface.triangle_count, sizeof *seen),
         *begun = pith_alloc(a->chart_count, sizeof *begun);
    uint32_t filled = 0;
    for (uint32_t t = 0; seen && begun && t < a->surface.triangle_count; ++t) {
        const uint32_t c = a->chart_of[t];
        if (c == PITH_NONE || seen[t]) continue;
        const uint32_t first = filled;
        filled = flood(a, t, a->order, filled, seen);
        if (!begun[c]) {
            a->charts[c].first = first;
            a->charts[c].count = filled - first;
            begun[c] = true;
            continue;
        }
        for (uint32_t i = first; i < filled; ++i) a->chart_of[a->order[i]] = PITH_NONE;
        filled = first;
    }
    const bool made = seen && begun;
    pith_free(seen);
    pith_free(begun);
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the charts' triangles");
}

/* Facets of a chart's triangles, one after the other; caller's array. */
static size_t gather_facets(const atlas *a, const atlas_chart *chart, pith_vec3 *facets)
{
    for (uint32_t i = 0; i < chart->count; ++i) facets[i] = a->surface.facets[a->order[chart->first + i]];
    return chart->count;
}

/* ---- relaxing ---------------------------------------------------------------------------------------------------- */

/* The triangle nearest to the middle of the chart's area, of those within its cone. */
static uint32_t middle_triangle(const growth *g, const atlas_chart *chart)
{
    const atlas_surface *s = &g->atlas->surface;
    const uint32_t *members = g->atlas->order + chart->first;
    pith_vec3 middle = pith_v3(0, 0, 0);
    double area = 0.0, nearest = INFINITY;
    for (uint32_t i = 0; i < chart->count; ++i) {
        middle = pith_madd(middle, s->middles[members[i]], s->areas[members[i]]);
        area += s->areas[members[i]];
    }
    uint32_t found = members[0];
    for (uint32_t i = 0; area > 0.0 && i < chart->count; ++i) {
        const double distance = pith_distance(s->middles[members[i]], pith_scale(middle, 1.0 / area));
        if (distance < nearest && fits(g, members[i], chart->axis) && s->areas[members[i]] > 0.0) {
            nearest = distance;
            found = members[i];
        }
    }
    return found;
}

/* Axes and seeds to the middle of what there is, then everything grows again. */
static pith_status relax(growth *g, pith_vec3 *facets, pith_error *err)
{
    atlas *a = g->atlas;
    list_members(a);
    for (uint32_t c = 0; c < a->chart_count; ++c) {
        atlas_chart *chart = &a->charts[c];
        const size_t count = gather_facets(a, chart, facets);
        atlas_cone(facets, count, &chart->axis);
        PITH_TRY(push(g, 0.0, middle_triangle(g, chart), c, err));
    }
    memset(a->chart_of, 0xff, a->surface.triangle_count * sizeof *a->chart_of);
    PITH_TRY(spread(g, err));
    PITH_TRY(grow_rest(g, err));
    return renumber(a, err);
}

/* ---- merging ----------------------------------------------------------------------------------------------------- */

typedef struct border {
    uint32_t a, b;
    double length;
} border;

static int by_pair(const void *x, const void *y)
{
    const border *p = x, *q = y;
    if (p->a != q->a) return p->a < q->a ? -1 : 1;
    return p->b < q->b ? -1 : p->b > q->b;
}

static int by_length_down(const void *x, const void *y)
{
    const border *p = x, *q = y;
    if (p->length != q->length) return p->length > q->length ? -1 : 1;
    return by_pair(x, y);
}

/* Borders between charts, each pair once, longest first. */
static pith_status find_borders(const atlas *a, border **borders, size_t *count, pith_error *err)
{
    const atlas_surface *s = &a->surface;
    border *list = NULL;
    size_t room = 0, n = 0, kept = 0;
    for (uint32_t t = 0; t < s->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) {
            const uint32_t mate = s->mates[t][k];
            if (mate == PITH_NONE || !(a->chart_of[t] < a->chart_of[mate])) continue;
            if (!pith_grow((void **)&list, &room, n + 1, sizeof *list)) {
                pith_free(list);
                return PITH_OUT_OF_MEMORY(err, "borders of charts");
            }
            const uint32_t *v = s->triangles[t];
            list[n++] = (border){ a->chart_of[t], a->chart_of[mate],
                                  pith_distance(s->positions[v[k]], s->positions[v[(k + 1) % 3]]) };
        }
    if (n) qsort(list, n, sizeof *list, by_pair);
    for (size_t i = 0; i < n; ++i) {
        if (kept > 0 && by_pair(&list[kept - 1], &list[i]) == 0)
            list[kept - 1].length += list[i].length;
        else
            list[kept++] = list[i];
    }
    if (kept) qsort(list, kept, sizeof *list, by_length_down);
    *borders = list;
    *count = kept;
    return PITH_OK;
}

/* Charts that became one: a list of them, by their first. */
typedef struct merging {
    uint32_t *root, *next, *last;
    pith_vec3 *facets;
} merging;

static uint32_t root_of(merging *m, uint32_t chart)
{
    while (m->root[chart] != chart) chart = m->root[chart] = m->root[m->root[chart]];
    return chart;
}

/* Joins b to a when all their facets fit within one cone. */
static void try_merge(growth *g, merging *m, uint32_t a, uint32_t b)
{
    atlas_chart *charts = g->atlas->charts;
    const double cosine_both = 2.0 * g->cosine * g->cosine - 1.0; /* of twice the limit */
    if (a == b || pith_dot(charts[a].axis, charts[b].axis) < cosine_both) return;
    size_t count = 0;
    for (int side = 0; side < 2; ++side)
        for (uint32_t c = side ? b : a; c != PITH_NONE; c = m->next[c])
            count += gather_facets(g->atlas, &charts[c], m->facets + count);
    pith_vec3 axis = pith_unit(pith_add(charts[a].axis, charts[b].axis));
    if (!(atlas_cone(m->facets, count, &axis) >= g->cosine)) return;
    m->root[b] = a;
    m->next[m->last[a]] = b;
    m->last[a] = m->last[b];
    charts[a].axis = axis;
}

static pith_status merge(growth *g, pith_vec3 *facets, pith_error *err)
{
    atlas *a = g->atlas;
    border *borders = NULL;
    size_t count = 0;
    pith_status status = PITH_OK;
    list_members(a);
    merging m = { .root = pith_alloc(a->chart_count, sizeof *m.root),
                  .next = pith_alloc(a->chart_count, sizeof *m.next),
                  .last = pith_alloc(a->chart_count, sizeof *m.last),
                  .facets = facets };
    if (!m.root || !m.next || !m.last) status = PITH_OUT_OF_MEMORY(err, "charts");
    if (status == PITH_OK) status = find_borders(a, &borders, &count, err);
    if (status == PITH_OK) {
        for (uint32_t c = 0; c < a->chart_count; ++c) {
            m.root[c] = m.last[c] = c;
            m.next[c] = PITH_NONE;
        }
        for (size_t i = 0; i < count; ++i) try_merge(g, &m, root_of(&m, borders[i].a), root_of(&m, borders[i].b));
        for (uint32_t t = 0; t < a->surface.triangle_count; ++t) a->chart_of[t] = root_of(&m, a->chart_of[t]);
        status = renumber(a, err);
    }
    pith_free(m.root);
    pith_free(m.next);
    pith_free(m.last);
    pith_free(borders);
    return status;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

pith_status atlas_chart_rest(atlas *a, pith_error *err)
{
    growth g = { .atlas = a, .cosine = atlas_cone_cosine(a->options) };
    pith_status status = order_members(a, err);
    if (status == PITH_OK) status = grow_rest(&g, err);
    if (status == PITH_OK) status = renumber(a, err);
    if (status == PITH_OK) status = order_members(a, err);
    pith_free(g.heap);
    return status;
}

pith_status atlas_make_charts(atlas *a, pith_error *err)
{
    growth g = { .atlas = a, .cosine = atlas_cone_cosine(a->options) };
    pith_status status = PITH_OK;
    pith_vec3 *facets = pith_alloc(a->surface.triangle_count, sizeof *facets);
    if (!facets) return PITH_OUT_OF_MEMORY(err, "facets of charts");
    memset(a->chart_of, 0xff, a->surface.triangle_count * sizeof *a->chart_of);
    PITH_TRY_OR(done, grow_rest(&g, err));
    for (int round = 0; round < ROUNDS; ++round) {
        for (int i = 0; i < RELAXATIONS; ++i) PITH_TRY_OR(done, relax(&g, facets, err));
        PITH_TRY_OR(done, merge(&g, facets, err));
    }
    status = order_members(a, err);
done:
    pith_free(facets);
    pith_free(g.heap);
    return status;
}
