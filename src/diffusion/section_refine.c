/* Colours in a section's triangulation, and its refinement: in rounds, the colours in the middle of all doubtful edges
   are asked for at once, and where one is not what interpolation makes of it, it becomes a vertex. The longest edges are
   tested (Rivara, "New longest-edge algorithms for the refinement and/or improvement of unstructured triangulations",
   1997), and flips keep the triangles Delaunay. */
#include "section_internal.h"

#include <stdlib.h>
#include <string.h>

/* A border vertex nearer to a sheet than this, in radii of the scene, lies on it: rays from there would see either side. */
#define ON_SHEET 1e-6

enum { MOST_ROUNDS = 64 };

/* ---- colours of corners ----------------------------------------------------------------------------------------------- */

static paint mark_colour(const section_work *work, uint32_t mark, pith_vec3 p)
{
    const sheets *all = &work->diffusion->sheets;
    pith_vec3 corner[3];
    double weights[3];
    for (int k = 0; k < 3; ++k) corner[k] = all->positions[all->triangles[mark / 2][k]];
    pith_nearest_on_triangle(corner, p, weights);
    return sheet_colour(work->diffusion, mark / 2, mark % 2 == 1, weights);
}

/* The marks of the cuts between which the corner lies: the first to the right and the first to the left. */
static void bounding_marks(const pith_facets_view *view, uint32_t h, uint32_t marks[2])
{
    marks[0] = marks[1] = PITH_NONE;
    for (uint32_t e = h;;) {
        marks[0] = mark_of(view, e);
        const uint32_t g = mate_of(view, e);
        if (marks[0] != PITH_NONE || g == PITH_NONE) break;
        e = next_of(g);
        if (e == h) return;
    }
    for (uint32_t e = h;;) {
        const uint32_t arriving = former_of(e);
        marks[1] = mark_of(view, arriving);
        e = mate_of(view, arriving);
        if (marks[1] != PITH_NONE || e == PITH_NONE) break;
    }
}

paint corner_colour(const section_work *work, const pith_facets_view *view, uint32_t h)
{
    const uint32_t v = from_of(view, h);
    paint colour;
    if (work->kinds[v] != VERTEX_CUT) {
        memcpy(&colour, work->colours[v], sizeof colour);
        return colour;
    }
    uint32_t marks[2];
    bounding_marks(view, h, marks);
    if (marks[0] == PITH_NONE && marks[1] == PITH_NONE) /* a fan that only touches the cut in this vertex */
        marks[0] = work->some_mark[v];
    const pith_vec3 p = view->positions[v];
    if (marks[0] == PITH_NONE || marks[1] == PITH_NONE || marks[0] == marks[1])
        return mark_colour(work, marks[0] == PITH_NONE ? marks[1] : marks[0], p);
    return 0.5f * (mark_colour(work, marks[0], p) + mark_colour(work, marks[1], p));
}

/* ---- asking ----------------------------------------------------------------------------------------------------------- */

/* On a sheet: the colour of the side that `inward` points to. */
static bool colour_on_sheet(const section_work *work, pith_vec3 p, pith_vec3 inward, float colour[4])
{
    const pith_vec3 q = diffusion_to_scene(work->diffusion, p);
    if (!diffusion_reaches(q)) return false;
    const nearest_sheet near = scene_nearest(work->diffusion, q, ON_SHEET);
    if (near.triangle == PITH_NONE || !(near.distance <= ON_SHEET)) return false;
    const paint found = sheet_colour(work->diffusion, near.triangle,
                                     nearest_sheet_behind(work->diffusion, &near, inward), near.weights);
    memcpy(colour, &found, sizeof found);
    return true;
}

static pith_status make_room(section_work *work, uint32_t vertices, pith_error *err)
{
    if (pith_grow((void **)&work->colours, &work->colour_room, vertices, sizeof *work->colours) &&
        pith_grow((void **)&work->kinds, &work->kind_room, vertices, sizeof *work->kinds) &&
        pith_grow((void **)&work->some_mark, &work->mark_room, vertices, sizeof *work->some_mark))
        return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "a section's colours");
}

/* The vertices of cut segments, and of those of the border the way into the section. */
static void look_round(section_work *work, const pith_facets_view *view, bool *used, bool *border, pith_vec3 *inward)
{
    for (uint32_t h = 0; h < 3 * view->triangle_count; ++h) {
        const uint32_t v = from_of(view, h), w = from_of(view, next_of(h)), mark = mark_of(view, h);
        const pith_vec3 p = view->positions[v];
        used[v] = true;
        if (mate_of(view, h) == PITH_NONE) border[v] = border[w] = true;
        for (int k = 0; k < 3; ++k)
            inward[v] = pith_add(inward[v], pith_sub(view->positions[view->triangles[h / 3][k]], p));
        if (mark == PITH_NONE) continue;
        work->kinds[v] = work->kinds[w] = VERTEX_CUT;
        work->some_mark[v] = work->some_mark[w] = mark;
    }
}

static pith_status ask(section_work *work, const pith_vec3 *points, size_t count, float (*colours)[4], pith_error *err)
{
    work->asked += (uint32_t)count;
    return pith_diffusion_colours(work->diffusion, work->how, points, count, colours, err);
}

static pith_status colour_vertices(section_work *work, pith_error *err)
{
    const pith_facets_view view = pith_facets_look(work->facets);
    const size_t n = view.vertex_count;
    PITH_TRY(make_room(work, view.vertex_count, err));
    bool *used = pith_alloc(n, sizeof *used), *border = pith_alloc(n, sizeof *border);
    pith_vec3 *inward = pith_alloc(n, sizeof *inward), *points = pith_alloc(n, sizeof *points);
    uint32_t *which = pith_alloc(n, sizeof *which), count = 0;
    float(*colours)[4] = pith_alloc(n, sizeof *colours);
    pith_status status = used && border && inward && points && which && colours
                             ? PITH_OK
                             : PITH_OUT_OF_MEMORY(err, "a section's colours");
    if (status == PITH_OK) {
        look_round(work, &view, used, border, inward);
        for (uint32_t v = 0; v < n; ++v) {
            if (!used[v] || work->kinds[v] == VERTEX_CUT) continue;
            work->kinds[v] = VERTEX_COLOURED;
            if (border[v] && colour_on_sheet(work, view.positions[v], inward[v], work->colours[v])) continue;
            points[count] = view.positions[v];
            which[count++] = v;
        }
        status = ask(work, points, count, colours, err);
        for (uint32_t i = 0; status == PITH_OK && i < count; ++i)
            memcpy(work->colours[which[i]], colours[i], sizeof colours[i]);
    }
    pith_free(used);
    pith_free(border);
    pith_free(inward);
    pith_free(points);
    pith_free(which);
    pith_free(colours);
    return status;
}

/* ---- which edges are doubtful -------------------------------------------------------------------------------------------- */

typedef struct doubt {
    uint32_t edge;
    uint32_t split; /* the edge that is divided if need be: this one, or one beside it that must stay */
    uint32_t split_from, split_to;
    uint32_t leader; /* the doubt whose colour answers this one, too; itself: asks */
    bool forced;     /* too long, whatever its colours are */
    bool cut;        /* the middle's colour is the sheet's */
    double length, error;
    pith_vec3 middle;
    float colour[4];
} doubt;

typedef struct refining {
    doubt *doubts;
    uint32_t (*good)[3]; /* [triangle_count] the corners of the triangle when it was found good */
    uint32_t *doubt_of;  /* [3 * triangle_count] 1 + the doubt about an edge, by the edge's name */
    pith_vec3 *points;
    float (*colours)[4];
    uint32_t *which;
    size_t doubt_room, good_room, of_room, point_room, colour_room, which_room;
    uint32_t count;
} refining;

static double edge_length(const pith_facets_view *view, uint32_t h)
{
    return pith_distance(view->positions[from_of(view, h)], view->positions[from_of(view, next_of(h))]);
}

/* The same edge seen from its neighbour has the same name. */
static uint32_t edge_name(const pith_facets_view *view, uint32_t h)
{
    const uint32_t g = mate_of(view, h);
    return g < h ? g : h; /* PITH_NONE is the largest */
}

static uint32_t longest_edge(const pith_facets_view *view, uint32_t t, bool open)
{
    uint32_t longest = PITH_NONE;
    double most = -1.0;
    for (uint32_t h = 3 * t; h < 3 * t + 3; ++h) {
        const double length = edge_length(view, h);
        if (!(length > most) || (open && is_cut(view, h))) continue;
        most = length;
        longest = h;
    }
    return longest;
}

/* What is in doubt about a triangle: its longest edge when that is too long, else the longest that no cut runs along.
   False: nothing to be done. */
static bool find_doubt(const section_work *work, const pith_facets_view *view, uint32_t t, doubt *found)
{
    const uint32_t longest = longest_edge(view, t, false);
    if (edge_length(view, longest) > work->longest) {
        *found = (doubt){ .edge = edge_name(view, longest), .forced = true };
        return true;
    }
    const uint32_t open = longest_edge(view, t, true);
    if (open == PITH_NONE || !(edge_length(view, open) > 2.0 * work->shortest)) return false;
    *found = (doubt){ .edge = edge_name(view, open) };
    return true;
}

/* Where the triangle on that side of an edge sees a longer one that must stay under a blunt angle, that one is divided
   in its stead: else ever narrower triangles would come to lie on it (Ruppert, "A Delaunay refinement algorithm for
   quality 2-dimensional mesh generation", 1995). */
static void divide_instead(const pith_facets_view *view, doubt *d, uint32_t h)
{
    if (h == PITH_NONE) return;
    const uint32_t longest = longest_edge(view, h / 3, false), g = mate_of(view, longest);
    if (longest == h) return;
    if (g != PITH_NONE && view->facets[g / 3] == view->facets[h / 3] && !is_cut(view, longest)) return;
    double around = 0.0;
    for (uint32_t e = 3 * (h / 3); e < 3 * (h / 3) + 3; ++e) around += edge_length(view, e) * edge_length(view, e);
    const double length = edge_length(view, longest);
    if (2.0 * length * length > around) d->split = edge_name(view, longest);
}

static int by_edge(const void *a, const void *b)
{
    const doubt *x = a, *y = b;
    if (x->edge != y->edge) return x->edge < y->edge ? -1 : 1;
    return (int)y->forced - (int)x->forced;
}

static int by_length(const void *a, const void *b)
{
    const doubt *x = a, *y = b;
    if (x->length != y->length) return x->length > y->length ? -1 : 1;
    return x->edge < y->edge ? -1 : x->edge > y->edge;
}

static void list_doubts(const section_work *work, const pith_facets_view *view, refining *r)
{
    r->count = 0;
    for (uint32_t t = 0; t < view->triangle_count; ++t) {
        if (memcmp(r->good[t], view->triangles[t], sizeof *r->good) == 0) continue;
        if (find_doubt(work, view, t, &r->doubts[r->count]))
            ++r->count;
        else
            memcpy(r->good[t], view->triangles[t], sizeof *r->good);
    }
    if (r->count == 0) return;
    qsort(r->doubts, r->count, sizeof *r->doubts, by_edge);
    uint32_t kept = 0;
    for (uint32_t i = 0; i < r->count; ++i) {
        if (kept > 0 && r->doubts[kept - 1].edge == r->doubts[i].edge) continue;
        doubt *d = &r->doubts[kept++];
        *d = r->doubts[i];
        d->cut = is_cut(view, d->edge);
        d->length = edge_length(view, d->edge);
        d->split = d->edge;
        divide_instead(view, d, d->edge);
        divide_instead(view, d, mate_of(view, d->edge));
        d->split_from = from_of(view, d->split);
        d->split_to = from_of(view, next_of(d->split));
        d->middle =
            pith_lerp(view->positions[from_of(view, d->edge)], view->positions[from_of(view, next_of(d->edge))], 0.5);
    }
    r->count = kept;
    qsort(r->doubts, r->count, sizeof *r->doubts, by_length);
}

/* The longer of the triangle's other edges; PITH_NONE: a cut runs along it. */
static uint32_t other_long_edge(const pith_facets_view *view, uint32_t h)
{
    const uint32_t a = next_of(h), b = former_of(h);
    const uint32_t other = edge_length(view, a) > edge_length(view, b) ? a : b;
    return is_cut(view, other) ? PITH_NONE : other;
}

/* From an edge on over the narrow triangles beside it, whose long edges have their middles close together. */
static void lead(const pith_facets_view *view, refining *r, uint32_t leader, uint32_t h)
{
    const doubt *first = &r->doubts[leader];
    while (h != PITH_NONE) {
        h = other_long_edge(view, h);
        const uint32_t found = h == PITH_NONE ? 0 : r->doubt_of[edge_name(view, h)];
        if (found == 0) return;
        doubt *d = &r->doubts[found - 1];
        if (d->leader != PITH_NONE || d->cut || d->length < 0.7 * first->length ||
            pith_distance(d->middle, first->middle) > 0.3 * first->length)
            return;
        d->leader = leader;
        h = mate_of(view, h);
    }
}

/* Of edges side by side in a strip of narrow triangles one is asked for all, the longest. */
static void choose_leaders(const pith_facets_view *view, refining *r)
{
    for (uint32_t i = 0; i < r->count; ++i) {
        r->doubts[i].leader = PITH_NONE;
        r->doubt_of[r->doubts[i].edge] = i + 1;
    }
    for (uint32_t i = 0; i < r->count; ++i) {
        doubt *d = &r->doubts[i];
        if (d->leader != PITH_NONE) continue;
        d->leader = i;
        if (d->cut) continue;
        lead(view, r, i, d->edge);
        lead(view, r, i, mate_of(view, d->edge));
    }
    for (uint32_t i = 0; i < r->count; ++i) r->doubt_of[r->doubts[i].edge] = 0;
}

static pith_status find_doubts(section_work *work, refining *r, pith_error *err)
{
    const pith_facets_view view = pith_facets_look(work->facets);
    const size_t n = view.triangle_count;
    if (!pith_grow((void **)&r->good, &r->good_room, n, sizeof *r->good) ||
        !pith_grow((void **)&r->doubts, &r->doubt_room, n, sizeof *r->doubts) ||
        !pith_grow((void **)&r->doubt_of, &r->of_room, 3 * n, sizeof *r->doubt_of))
        return PITH_OUT_OF_MEMORY(err, "a section's edges");
    list_doubts(work, &view, r);
    choose_leaders(&view, r);
    return PITH_OK;
}

/* ---- how good interpolation is --------------------------------------------------------------------------------------------- */

/* Of the mean of two colours, premultiplied, from what is there: in opacity, or in sRGB as far as it can be seen. */
static double mean_error(paint a, paint b, const float there[4])
{
    const float opacity = 0.5f * (a[3] + b[3]);
    double error = fabs((double)opacity - there[3]);
    if (!(opacity > 0.0f)) return error;
    const paint mean = (a * a[3] + b * b[3]) / (2.0f * opacity);
    for (int k = 0; k < 3; ++k)
        error = fmax(error, there[3] * fabs((double)pith_srgb_encode(mean[k]) - (double)pith_srgb_encode(there[k])));
    return error;
}

/* A triangle is good when the middle of the edge it was in doubt about is. */
static void note_good(const pith_facets_view *view, refining *r, const doubt *d)
{
    const uint32_t g = mate_of(view, d->edge);
    memcpy(r->good[d->edge / 3], view->triangles[d->edge / 3], sizeof *r->good);
    if (g != PITH_NONE) memcpy(r->good[g / 3], view->triangles[g / 3], sizeof *r->good);
}

/* The colours of some middles: those of the edges in doubt, or of those that are divided instead. */
static pith_status ask_middles(section_work *work, const pith_facets_view *view, refining *r, bool instead,
                               pith_error *err)
{
    if (!pith_grow((void **)&r->points, &r->point_room, r->count, sizeof *r->points) ||
        !pith_grow((void **)&r->colours, &r->colour_room, r->count, sizeof *r->colours) ||
        !pith_grow((void **)&r->which, &r->which_room, r->count, sizeof *r->which))
        return PITH_OUT_OF_MEMORY(err, "a section's colours");
    uint32_t count = 0;
    for (uint32_t i = 0; i < r->count; ++i) {
        doubt *d = &r->doubts[i];
        if (instead ? d->split == d->edge || is_cut(view, d->split) : d->leader != i || d->cut) continue;
        const uint32_t h = instead ? d->split : d->edge;
        const pith_vec3 middle =
            pith_lerp(view->positions[from_of(view, h)], view->positions[from_of(view, next_of(h))], 0.5);
        const pith_vec3 apex = view->positions[from_of(view, former_of(h))];
        if (mate_of(view, h) == PITH_NONE && colour_on_sheet(work, middle, pith_sub(apex, middle), d->colour)) continue;
        r->points[count] = middle;
        r->which[count++] = i;
    }
    PITH_TRY(ask(work, r->points, count, r->colours, err));
    for (uint32_t i = 0; i < count; ++i) memcpy(r->doubts[r->which[i]].colour, r->colours[i], sizeof r->colours[i]);
    return PITH_OK;
}

static pith_status judge(section_work *work, refining *r, pith_error *err)
{
    const pith_facets_view view = pith_facets_look(work->facets);
    PITH_TRY(ask_middles(work, &view, r, false, err));
    for (uint32_t i = 0; i < r->count; ++i) {
        doubt *d = &r->doubts[i];
        if (d->leader != i) continue;
        d->error = d->forced ? INFINITY
                             : mean_error(corner_colour(work, &view, d->edge),
                                          corner_colour(work, &view, next_of(d->edge)), d->colour);
    }
    uint32_t kept = 0; /* those to be divided */
    for (uint32_t i = 0; i < r->count; ++i) {
        doubt *d = &r->doubts[i];
        if (d->leader != i) d->error = d->forced ? INFINITY : r->doubts[d->leader].error;
        if (d->error <= work->options->tolerance) note_good(&view, r, d);
    }
    for (uint32_t i = 0; i < r->count; ++i)
        if (r->doubts[i].leader == i && r->doubts[i].error > work->options->tolerance) r->doubts[kept++] = r->doubts[i];
    r->count = kept;
    return ask_middles(work, &view, r, true, err);
}

/* ---- dividing --------------------------------------------------------------------------------------------------------------- */

static int by_error(const void *a, const void *b)
{
    const doubt *x = a, *y = b;
    if (x->error != y->error) return x->error > y->error ? -1 : 1;
    return x->edge < y->edge ? -1 : x->edge > y->edge;
}

/* The mark of an edge at the vertex, or PITH_NONE when no cut runs through it. */
static uint32_t find_mark(const pith_facets_view *view, uint32_t v)
{
    const uint32_t begin = view->leaving[v];
    uint32_t h = begin, g;
    do {
        if (mark_of(view, h) != PITH_NONE) return mark_of(view, h);
        if (mark_of(view, former_of(h)) != PITH_NONE) return mark_of(view, former_of(h));
        h = mate_of(view, former_of(h));
    } while (h != PITH_NONE && h != begin);
    if (h == begin) return PITH_NONE;
    for (h = begin; (g = mate_of(view, h)) != PITH_NONE;) {
        h = next_of(g);
        if (mark_of(view, h) != PITH_NONE) return mark_of(view, h);
        if (mark_of(view, former_of(h)) != PITH_NONE) return mark_of(view, former_of(h));
    }
    return PITH_NONE;
}

/* A vertex that this round has made lies so near to the middle of the edge that another would be of little use. */
static bool is_crowded(const pith_facets_view *view, const doubt *d, uint32_t first_new)
{
    const uint32_t g = mate_of(view, d->edge);
    const uint32_t apex[2] = { from_of(view, former_of(d->edge)), g == PITH_NONE ? 0 : from_of(view, former_of(g)) };
    for (int k = 0; k < 2; ++k)
        if (apex[k] >= first_new && pith_distance(view->positions[apex[k]], d->middle) < 0.4 * d->length) return true;
    return false;
}

/* Edges that former divisions have flipped away are passed over, and so are crowded ones: what is there instead is in
   doubt again in the next round. */
static pith_status divide(section_work *work, const doubt *d, uint32_t first_new, pith_error *err)
{
    pith_facets_view view = pith_facets_look(work->facets);
    uint32_t vertex;
    if (from_of(&view, d->split) != d->split_from || from_of(&view, next_of(d->split)) != d->split_to) return PITH_OK;
    if (d->split == d->edge && is_crowded(&view, d, first_new)) return PITH_OK;
    PITH_TRY(pith_facets_split(work->facets, d->split, &vertex, err));
    PITH_TRY(make_room(work, vertex + 1, err));
    view = pith_facets_look(work->facets);
    work->some_mark[vertex] = find_mark(&view, vertex);
    work->kinds[vertex] = work->some_mark[vertex] == PITH_NONE ? VERTEX_COLOURED : VERTEX_CUT;
    memcpy(work->colours[vertex], d->colour, sizeof d->colour);
    return PITH_OK;
}

static pith_status divide_all(section_work *work, refining *r, bool *any, pith_error *err)
{
    const uint32_t have = pith_facets_look(work->facets).vertex_count, most = work->options->most;
    const uint32_t left = have < most ? most - have : 0;
    if (r->count > left) {
        qsort(r->doubts, r->count, sizeof *r->doubts, by_error);
        r->count = left;
    }
    for (uint32_t i = 0; i < r->count; ++i) PITH_TRY(divide(work, &r->doubts[i], have, err));
    *any = r->count > 0;
    return PITH_OK;
}

static pith_status refine(section_work *work, refining *r, const pith_progress *progress, pith_error *err)
{
    bool any = true;
    for (int round = 0; round < MOST_ROUNDS && any; ++round) {
        PITH_TRY(pith_progress_step(progress, 1.0 - 1.0 / (1.0 + 0.5 * round), "colours of the section", err));
        PITH_TRY(find_doubts(work, r, err));
        PITH_TRY(judge(work, r, err));
        PITH_TRY(divide_all(work, r, &any, err));
    }
    return PITH_OK;
}

pith_status section_refine(section_work *work, const pith_progress *progress, pith_error *err)
{
    PITH_TRY(colour_vertices(work, err));
    refining r = { 0 };
    const pith_status status = refine(work, &r, progress, err);
    pith_free(r.doubts);
    pith_free(r.good);
    pith_free(r.doubt_of);
    pith_free(r.points);
    pith_free(r.colours);
    pith_free(r.which);
    return status;
}
