/* Crossings linked into strokes, from cell to cell of the grid.

   A cell that two crossings lead into passes the line on. One with a single crossing is a free end, one with three or
   four a place where lines meet. Between such places run chains; the two that meet most smoothly go on as one stroke, and
   the others end on it (Northrup and Markosian 2000, linking in the picture). */
#include "lines_internal.h"

#include <stdlib.h>

static const double window = 8.0;    /* pixels of a chain that tell where it is going */
static const double islet = 6.0;     /* chains round smaller ones are one line */
static const double straight = 0.5;  /* cosine of the largest bend over which lines go on where more than two meet */
static const double kindred = 0.3;   /* what two of a kind have ahead */
static const double weak_step = 3.0; /* silhouettes that nowhere stand off more than this are not drawn, pixels */
static const double bridge = 5.0;    /* free ends nearer than this, that look at each other, are joined, pixels */

typedef struct visit {
    uint64_t cell;
    uint32_t crossing;
} visit;

/* Crossings from one place to the next. */
typedef struct chain {
    size_t first, count; /* in the list of crossings in order */
    uint32_t node[2];    /* PITH_NONE: beyond the grid; of a ring both */
    uint32_t next[2];    /* what its ends go on as: 2 * chain + end; PITH_NONE: they end */
    bool ring, gone, used;
    double length; /* pixels */
} chain;

typedef struct linker {
    const lines_trace *trace;
    visit *visits;   /* [2 * count] by cell */
    uint32_t *start; /* [cell_count + 1] into visits */
    uint32_t cell_count;
    uint32_t (*cells)[2]; /* [count] of each crossing; PITH_NONE: beyond the grid */
    bool *seen;           /* [count] */
    uint32_t *order;      /* [count] crossings along the chains */
    size_t ordered;
    chain *chains;
    size_t chain_count, chain_capacity;
    uint32_t *degree; /* [cell_count] ends of chains in a cell */
} linker;

static void linker_free(linker *l)
{
    pith_free(l->visits);
    pith_free(l->start);
    pith_free(l->cells);
    pith_free(l->seen);
    pith_free(l->order);
    pith_free(l->chains);
    pith_free(l->degree);
}

/* ---- cells -------------------------------------------------------------------------------------------------------- */

static int by_cell(const void *a, const void *b)
{
    const visit *x = a, *y = b;
    if (x->cell != y->cell) return (x->cell > y->cell) - (x->cell < y->cell);
    return (x->crossing > y->crossing) - (x->crossing < y->crossing);
}

/* The two cells at an edge of the grid, named by their first sample; UINT64_MAX beyond the grid. */
static void cells_of(const lines_trace *trace, uint64_t edge, uint64_t cells[2])
{
    const uint64_t at = edge / 2, column = at % trace->wide, row = at / trace->wide;
    const bool down = edge % 2 == 1;
    cells[0] = (down ? column : row) == 0 ? UINT64_MAX : at - (down ? 1 : trace->wide);
    cells[1] = (down ? column + 1 == trace->wide : row + 1 == trace->high) ? UINT64_MAX : at;
}

static pith_status make_cells(linker *l, pith_error *err)
{
    const size_t count = l->trace->count;
    l->visits = pith_alloc(2 * count, sizeof *l->visits);
    l->start = pith_alloc(2 * count + 1, sizeof *l->start);
    l->cells = pith_alloc(count, sizeof *l->cells);
    l->seen = pith_alloc(count, sizeof *l->seen);
    l->order = pith_alloc(count, sizeof *l->order);
    l->degree = pith_alloc(2 * count, sizeof *l->degree);
    if (!l->visits || !l->start || !l->cells || !l->seen || !l->order || !l->degree)
        return PITH_OUT_OF_MEMORY(err, "linking lines");
    size_t visits = 0;
    for (uint32_t i = 0; i < count; ++i) {
        uint64_t cells[2];
        cells_of(l->trace, l->trace->crossings[i].edge, cells);
        for (int k = 0; k < 2; ++k) {
            l->cells[i][k] = PITH_NONE;
            if (cells[k] != UINT64_MAX) l->visits[visits++] = (visit){ cells[k], i };
        }
    }
    qsort(l->visits, visits, sizeof *l->visits, by_cell);
    for (uint32_t v = 0; v < visits; ++v) {
        if (v == 0 || l->visits[v].cell != l->visits[v - 1].cell) l->start[l->cell_count++] = v;
        uint64_t cells[2];
        cells_of(l->trace, l->trace->crossings[l->visits[v].crossing].edge, cells);
        l->cells[l->visits[v].crossing][cells[1] == l->visits[v].cell] = l->cell_count - 1;
    }
    l->start[l->cell_count] = (uint32_t)visits;
    return PITH_OK;
}

static uint32_t lines_in(const linker *l, uint32_t cell) { return l->start[cell + 1] - l->start[cell]; }

/* ---- chains ------------------------------------------------------------------------------------------------------- */

static const lines_crossing *crossing_of(const linker *l, const chain *c, size_t i)
{
    return &l->trace->crossings[l->order[c->first + i]];
}

static double apart(const lines_crossing *a, const lines_crossing *b) { return hypot(b->x - a->x, b->y - a->y); }

/* Follows the line from a crossing through one of its cells; returns the cell where it stops. */
static uint32_t follow(linker *l, uint32_t crossing, uint32_t cell)
{
    for (;;) {
        l->seen[crossing] = true;
        l->order[l->ordered++] = crossing;
        if (cell == PITH_NONE || lines_in(l, cell) != 2) return cell;
        const visit *pair = l->visits + l->start[cell];
        const uint32_t next = pair[pair[0].crossing == crossing].crossing;
        if (l->seen[next]) return cell; /* round a ring */
        cell = l->cells[next][l->cells[next][0] == cell];
        crossing = next;
    }
}

static bool add_chain(linker *l, uint32_t crossing, uint32_t from, uint32_t into, bool ring)
{
    void *chains = l->chains;
    if (!pith_grow(&chains, &l->chain_capacity, l->chain_count + 1, sizeof *l->chains)) return false;
    l->chains = chains;
    chain c = { .first = l->ordered, .node = { from, PITH_NONE }, .next = { PITH_NONE, PITH_NONE }, .ring = ring };
    const uint32_t end = follow(l, crossing, into);
    if (!ring)
        c.node[1] = end;
    else
        c.node[0] = PITH_NONE;
    c.count = l->ordered - c.first;
    for (size_t i = 1; i < c.count; ++i) c.length += apart(crossing_of(l, &c, i - 1), crossing_of(l, &c, i));
    for (int k = 0; k < 2; ++k)
        if (c.node[k] != PITH_NONE) ++l->degree[c.node[k]];
    l->chains[l->chain_count++] = c;
    return true;
}

static pith_status make_chains(linker *l, pith_error *err)
{
    for (int rings = 0; rings < 2; ++rings)
        for (uint32_t i = 0; i < l->trace->count; ++i)
            for (int k = 0; k < 2 && !l->seen[i]; ++k) {
                const uint32_t from = l->cells[i][k], into = l->cells[i][!k];
                if (!rings && from != PITH_NONE && lines_in(l, from) == 2) continue;
                if (!add_chain(l, i, from, into, rings)) return PITH_OUT_OF_MEMORY(err, "chains");
            }
    return PITH_OK;
}

/* ---- what is left out --------------------------------------------------------------------------------------------- */

static void drop(linker *l, chain *c)
{
    c->gone = true;
    for (int k = 0; k < 2; ++k)
        if (c->node[k] != PITH_NONE) --l->degree[c->node[k]];
}

static bool loose(const linker *l, uint32_t node) { return node != PITH_NONE && l->degree[node] == 1; }

/* A spur: short, with a free end, on a line that goes on without it. */
static bool is_spur(const linker *l, const chain *c)
{
    if (c->ring || c->length >= l->trace->options->shortest) return false;
    for (int k = 0; k < 2; ++k)
        if (loose(l, c->node[k]) && c->node[!k] != PITH_NONE && l->degree[c->node[!k]] >= 3) return true;
    return false;
}

static double least_gap(const linker *l, const chain *c)
{
    double gap = INFINITY;
    for (size_t i = 0; i < c->count; ++i) gap = fmin(gap, (double)crossing_of(l, c, i)->gap);
    return gap;
}

static int by_nodes(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    for (int k = 0; k < 3; ++k)
        if (x[k] != y[k]) return (x[k] > y[k]) - (x[k] < y[k]);
    return 0;
}

/* Where two surfaces run out beside each other, slivers of one show between the pixels of the other: short chains on both
   sides of an islet. One of them goes: the one with less behind it. */
static pith_status drop_islets(linker *l, pith_error *err)
{
    uint32_t(*short_ones)[3] = pith_alloc(l->chain_count, sizeof *short_ones);
    if (!short_ones) return PITH_OUT_OF_MEMORY(err, "chains");
    size_t count = 0;
    for (uint32_t i = 0; i < l->chain_count; ++i) {
        chain *c = &l->chains[i];
        if (c->ring || c->length >= islet || c->node[0] == PITH_NONE || c->node[1] == PITH_NONE) continue;
        if (c->node[0] == c->node[1]) {
            drop(l, c);
            continue;
        }
        const bool turned = c->node[0] > c->node[1];
        short_ones[count][0] = c->node[turned];
        short_ones[count][1] = c->node[!turned];
        short_ones[count++][2] = i;
    }
    qsort(short_ones, count, sizeof *short_ones, by_nodes);
    for (size_t i = 1; i < count; ++i) {
        if (short_ones[i][0] != short_ones[i - 1][0] || short_ones[i][1] != short_ones[i - 1][1]) continue;
        chain *a = &l->chains[short_ones[i - 1][2]], *b = &l->chains[short_ones[i][2]];
        const bool first = least_gap(l, a) < least_gap(l, b);
        drop(l, first ? a : b);
        if (!first) short_ones[i][2] = short_ones[i - 1][2]; /* the one that stays is what the next is held against */
    }
    pith_free(short_ones);
    return PITH_OK;
}

static void drop_spurs(linker *l)
{
    for (bool more = true; more;) {
        more = false;
        for (size_t i = 0; i < l->chain_count; ++i)
            if (!l->chains[i].gone && is_spur(l, &l->chains[i])) {
                drop(l, &l->chains[i]);
                more = true;
            }
    }
}

/* ---- what goes on as what ----------------------------------------------------------------------------------------- */

typedef struct loose_end {
    uint32_t chain, end;
    double x, y; /* where the chain goes from here, unit length */
    pith_vec2 at;
    uint8_t kind;
} loose_end;

static loose_end end_of(const linker *l, uint32_t index, uint32_t end)
{
    const chain *c = &l->chains[index];
    const size_t last = c->count - 1;
    const lines_crossing *from = crossing_of(l, c, end ? last : 0), *to = from;
    size_t kinds[PITH_STROKE_GIVEN + 1] = { 0 };
    for (size_t i = 1; i <= last && apart(from, to) < window; ++i) {
        to = crossing_of(l, c, end ? last - i : i);
        ++kinds[to->kind];
    }
    uint8_t kind = from->kind;
    for (uint8_t k = 0; k <= PITH_STROKE_GIVEN; ++k)
        if (kinds[k] > kinds[kind]) kind = k;
    const double length = apart(from, to);
    return (loose_end){ .chain = index,
                        .end = end,
                        .x = length > 0.0 ? (to->x - from->x) / length : 0.0,
                        .y = length > 0.0 ? (to->y - from->y) / length : 0.0,
                        .at = { from->x, from->y },
                        .kind = kind };
}

static void join(linker *l, const loose_end *a, const loose_end *b)
{
    l->chains[a->chain].next[a->end] = 2 * b->chain + b->end;
    l->chains[b->chain].next[b->end] = 2 * a->chain + a->end;
}

/* Joins the ends in one cell two by two, the straightest first. */
static void join_ends(linker *l, loose_end *ends, size_t count)
{
    while (count >= 2) {
        double best = -INFINITY, cosine = 0.0;
        size_t first = 0, second = 1;
        for (size_t i = 0; i < count; ++i)
            for (size_t j = i + 1; j < count; ++j) {
                const double c = -(ends[i].x * ends[j].x + ends[i].y * ends[j].y);
                const double score = c + (ends[i].kind == ends[j].kind ? kindred : 0.0);
                if (!(score > best)) continue;
                best = score, cosine = c, first = i, second = j;
            }
        if (count > 2 && cosine < straight) return;
        join(l, &ends[first], &ends[second]);
        ends[second] = ends[--count];
        ends[first] = ends[--count];
    }
}

static int by_node(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    return by_nodes((uint32_t[3]){ x[0], x[1], 0 }, (uint32_t[3]){ y[0], y[1], 0 });
}

static pith_status join_chains(linker *l, pith_error *err)
{
    uint32_t(*at)[2] = pith_alloc(2 * l->chain_count, sizeof *at); /* node, 2 * chain + end */
    if (!at) return PITH_OUT_OF_MEMORY(err, "chains");
    size_t count = 0;
    for (uint32_t i = 0; i < l->chain_count; ++i)
        for (uint32_t k = 0; k < 2; ++k) {
            if (l->chains[i].gone || l->chains[i].node[k] == PITH_NONE) continue;
            at[count][0] = l->chains[i].node[k];
            at[count++][1] = 2 * i + k;
        }
    qsort(at, count, sizeof *at, by_node);
    for (size_t i = 0; i < count;) {
        loose_end ends[8];
        size_t n = 0;
        const uint32_t node = at[i][0];
        for (; i < count && at[i][0] == node; ++i)
            if (n < 8) ends[n++] = end_of(l, at[i][1] / 2, at[i][1] % 2);
        join_ends(l, ends, n);
    }
    pith_free(at);
    return PITH_OK;
}

static int by_row(const void *a, const void *b)
{
    const loose_end *x = a, *y = b;
    if (x->at.y != y->at.y) return (x->at.y > y->at.y) - (x->at.y < y->at.y);
    if (x->at.x != y->at.x) return (x->at.x > y->at.x) - (x->at.x < y->at.x);
    return (x->chain > y->chain) - (x->chain < y->chain);
}

static bool face(const loose_end *a, const loose_end *b)
{
    const double x = b->at.x - a->at.x, y = b->at.y - a->at.y, length = hypot(x, y);
    if (!(length <= bridge) || a->chain == b->chain) return false;
    if (!(a->x * b->x + a->y * b->y < -0.8)) return false;
    return length < 1.0 || (a->x * x + a->y * y < -0.7 * length && b->x * x + b->y * y > 0.7 * length);
}

/* Joins free ends that look at each other over a small gap. */
static pith_status bridge_gaps(linker *l, pith_error *err)
{
    loose_end *ends = pith_alloc(2 * l->chain_count, sizeof *ends);
    if (!ends) return PITH_OUT_OF_MEMORY(err, "chains");
    size_t count = 0;
    for (uint32_t i = 0; i < l->chain_count; ++i)
        for (uint32_t k = 0; k < 2; ++k)
            if (!l->chains[i].gone && loose(l, l->chains[i].node[k])) ends[count++] = end_of(l, i, k);
    qsort(ends, count, sizeof *ends, by_row);
    for (size_t i = 0; i < count; ++i)
        for (size_t j = i + 1; j < count && ends[j].at.y - ends[i].at.y <= bridge; ++j) {
            if (l->chains[ends[i].chain].next[ends[i].end] != PITH_NONE) break;
            if (l->chains[ends[j].chain].next[ends[j].end] == PITH_NONE && face(&ends[i], &ends[j]))
                join(l, &ends[i], &ends[j]);
        }
    pith_free(ends);
    return PITH_OK;
}

/* ---- strokes ------------------------------------------------------------------------------------------------------ */

static double width_at(const lines_trace *trace, const lines_crossing *c)
{
    const pith_vec3 normal = pith_v3((double)c->normal[0], (double)c->normal[1], (double)c->normal[2]);
    return lines_width(trace, c->kind, (double)c->gap, c->at, normal);
}

static bool emit_crossing(const lines_trace *trace, const lines_crossing *c, lines_strokes *to)
{
    return lines_stroke_add(to, (lines_point){ c->x, c->y, c->at, width_at(trace, c) });
}

/* The end of a stroke that goes on as nothing: beyond the border, free, or led up to the lines in its cell. */
static bool emit_end(const linker *l, const chain *c, uint32_t end, lines_stroke *stroke, int which, lines_strokes *to)
{
    const uint32_t node = c->node[end];
    if (node == PITH_NONE || loose(l, node)) {
        stroke->ends[which] = node == PITH_NONE ? LINES_OFF : LINES_FREE;
        return true;
    }
    /* The middle of the other crossings lies on the line that goes through, to a fraction of a pixel. */
    const lines_crossing *own = crossing_of(l, c, end ? c->count - 1 : 0), *near = own;
    double x = 0.0, y = 0.0, n = 0.0, widest = 0.0;
    for (uint32_t v = l->start[node]; v < l->start[node + 1]; ++v) {
        const lines_crossing *other = &l->trace->crossings[l->visits[v].crossing];
        if (other == own) continue;
        x += other->x, y += other->y, n += 1.0;
        widest = fmax(widest, width_at(l->trace, other));
        if (lines_depth(l->trace, other->at) < lines_depth(l->trace, near->at)) near = other;
    }
    stroke->ends[which] = LINES_JOINED;
    stroke->joined[which] = near->at;
    stroke->joined_width[which] = n > 0.0 ? widest : INFINITY;
    if (!(n > 0.0)) return true;
    lines_crossing met = *own;
    met.x = x / n, met.y = y / n;
    return emit_crossing(l->trace, &met, to);
}

/* A stroke from one end of a chain to wherever its last chain ends. */
static bool emit_stroke(linker *l, uint32_t index, uint32_t end, bool ring, lines_strokes *to)
{
    double lengths[PITH_STROKE_GIVEN + 1] = { 0 }, strongest = 0.0, all = 0.0;
    lines_stroke stroke = { .closed = ring };
    const size_t first = to->point_count;
    if (!lines_stroke_begin(to, stroke)) return false;
    if (!ring && !emit_end(l, &l->chains[index], end, &stroke, 0, to)) return false;
    for (uint32_t at = index, from = end;;) {
        chain *c = &l->chains[at];
        c->used = true;
        for (size_t i = 0; i < c->count; ++i) {
            const lines_crossing *crossing = crossing_of(l, c, from ? c->count - 1 - i : i);
            if (!emit_crossing(l->trace, crossing, to)) return false;
            lengths[crossing->kind] += 1.0;
            strongest = fmax(strongest, (double)crossing->step);
        }
        all += c->length;
        const uint32_t next = c->next[!from];
        if (next == PITH_NONE) {
            if (!ring && !emit_end(l, c, !from, &stroke, 1, to)) return false;
            break;
        }
        if (l->chains[next / 2].used) break;
        at = next / 2;
        from = next % 2;
    }
    for (uint8_t k = 0; k <= PITH_STROKE_GIVEN; ++k)
        if (lengths[k] > lengths[stroke.kind]) stroke.kind = k;
    stroke.first = first;
    stroke.count = to->point_count - first;
    to->list[to->count - 1] = stroke;
    /* Too short, or too faint, as a whole. */
    const bool bridging = !ring && stroke.ends[0] == LINES_JOINED && stroke.ends[1] == LINES_JOINED;
    if (strongest < weak_step || stroke.count < 2 || (!bridging && all < l->trace->options->shortest)) {
        to->point_count = first;
        --to->count;
    }
    return true;
}

/* Strokes begin where a chain ends; what is left then are rings. */
static pith_status emit_strokes(linker *l, lines_strokes *to, pith_error *err)
{
    for (int rings = 0; rings < 2; ++rings)
        for (uint32_t i = 0; i < l->chain_count; ++i)
            for (uint32_t k = 0; k < 2; ++k) {
                const chain *c = &l->chains[i];
                if (c->gone || c->used || (!rings && (c->ring || c->next[k] != PITH_NONE))) continue;
                if (!emit_stroke(l, i, k, rings, to)) return PITH_OUT_OF_MEMORY(err, "strokes");
            }
    return PITH_OK;
}

pith_status lines_link(const lines_trace *trace, lines_strokes *strokes, pith_error *err)
{
    linker l = { .trace = trace };
    pith_status status = make_cells(&l, err);
    if (status == PITH_OK) status = make_chains(&l, err);
    if (status == PITH_OK) status = drop_islets(&l, err);
    if (status == PITH_OK) {
        drop_spurs(&l);
        status = join_chains(&l, err);
    }
    if (status == PITH_OK) status = bridge_gaps(&l, err);
    if (status == PITH_OK) status = emit_strokes(&l, strokes, err);
    linker_free(&l);
    return status;
}
