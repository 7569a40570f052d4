/* Which pieces of lines are near: a hash of cells about as large as the distances asked for. */
#include "streamlines_internal.h"

enum { FIRST_SLOTS = 1024, CELL_BITS = 21 };

near_grid near_make(pith_vec3 origin, double cell, double longest)
{
    return (near_grid){ .origin = origin, .cell = cell, .reach = 0.5 * longest * (1.0 + 1e-9) };
}

void near_free(near_grid *grid)
{
    pith_free(grid->pieces);
    pith_free(grid->keys);
    pith_free(grid->first);
}

/* ---- the hash ---------------------------------------------------------------------------------------------------- */

/* Cells a million from the origin and beyond share the outermost ones: slower, not wrong. */
static int64_t cell_along(const near_grid *grid, double x)
{
    const double limit = (double)(1 << (CELL_BITS - 1)) - 2.0;
    return (int64_t)floor(fmin(fmax(x / grid->cell, -limit), limit));
}

static uint64_t cell_key(int64_t x, int64_t y, int64_t z)
{
    const uint64_t mask = (1u << CELL_BITS) - 1;
    return (((uint64_t)x & mask) << (2 * CELL_BITS) | ((uint64_t)y & mask) << CELL_BITS | ((uint64_t)z & mask)) + 1;
}

/* The slot of the cell, or the free one where it would be. */
static size_t slot_of(const near_grid *grid, uint64_t key)
{
    size_t slot = pith_mix64(key) & (grid->slots - 1);
    while (grid->keys[slot] && grid->keys[slot] != key) slot = (slot + 1) & (grid->slots - 1);
    return slot;
}

static bool grow_slots(near_grid *grid)
{
    near_grid larger = *grid;
    larger.slots = grid->slots ? 2 * grid->slots : FIRST_SLOTS;
    larger.keys = pith_alloc(larger.slots, sizeof *larger.keys);
    larger.first = pith_alloc(larger.slots, sizeof *larger.first);
    if (!larger.keys || !larger.first) {
        pith_free(larger.keys);
        pith_free(larger.first);
        return false;
    }
    for (size_t s = 0; s < grid->slots; ++s) {
        if (!grid->keys[s]) continue;
        const size_t slot = slot_of(&larger, grid->keys[s]);
        larger.keys[slot] = grid->keys[s];
        larger.first[slot] = grid->first[s];
    }
    pith_free(grid->keys);
    pith_free(grid->first);
    *grid = larger;
    return true;
}

static uint64_t key_of(const near_grid *grid, const near_piece *piece)
{
    const pith_vec3 middle = pith_sub(pith_lerp(piece->a, piece->b, 0.5), grid->origin);
    return cell_key(cell_along(grid, middle.x), cell_along(grid, middle.y), cell_along(grid, middle.z));
}

bool near_add(near_grid *grid, const near_piece *piece)
{
    if (2 * (grid->used + 1) > grid->slots && !grow_slots(grid)) return false;
    if (!pith_grow((void **)&grid->pieces, &grid->room, grid->count + 1, sizeof *grid->pieces)) return false;
    const uint64_t key = key_of(grid, piece);
    const size_t slot = slot_of(grid, key);
    if (!grid->keys[slot]) {
        grid->keys[slot] = key;
        grid->first[slot] = PITH_NONE;
        ++grid->used;
    }
    grid->pieces[grid->count] = *piece;
    grid->pieces[grid->count].next = grid->first[slot];
    grid->first[slot] = (uint32_t)grid->count++;
    return true;
}

void near_drop(near_grid *grid, size_t count)
{
    while (grid->count > count) { /* each is the first of its cell when those behind it are gone */
        const near_piece *piece = &grid->pieces[--grid->count];
        grid->first[slot_of(grid, key_of(grid, piece))] = piece->next;
    }
}

/* ---- distances --------------------------------------------------------------------------------------------------- */

static double clamp_unit(double t) { return t > 0.0 ? (t < 1.0 ? t : 1.0) : 0.0; }

/* Nearest points of two segments (Ericson, "Real-Time Collision Detection", 2005, section 5.1.9). */
double near_distance(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    const pith_vec3 u = pith_sub(b, a), v = pith_sub(d, c), w = pith_sub(a, c);
    const double uu = pith_dot(u, u), vv = pith_dot(v, v), uv = pith_dot(u, v);
    const double uw = pith_dot(u, w), vw = pith_dot(v, w);
    double s = 0.0, t = 0.0;
    if (uu > 0.0 && vv > 0.0) {
        const double det = uu * vv - uv * uv;
        s = det > 1e-14 * uu * vv ? clamp_unit((uv * vw - uw * vv) / det) : 0.0;
        t = (uv * s + vw) / vv;
        if (!(t >= 0.0 && t <= 1.0)) {
            t = clamp_unit(t);
            s = clamp_unit((uv * t - uw) / uu);
        }
    } else if (uu > 0.0) {
        s = clamp_unit(-uw / uu);
    } else if (vv > 0.0) {
        t = clamp_unit(vw / vv);
    }
    return pith_distance(pith_madd(a, u, s), pith_madd(c, v, t));
}

/* Where normals differ by more, 75 degrees, the surface counts as another side; cosine. Lines on the two sides of a
   sheet, or of a right edge, do not keep their distance from each other. */
static const double same_side = 0.25;

/* far: of the middles, squared; beyond it the pieces cannot be near. */
static near_what judge(const near_piece *piece, const near_piece *other, double distance, double far, double apart)
{
    const pith_vec3 twice = pith_sub(pith_add(piece->a, piece->b), pith_add(other->a, other->b));
    if (pith_dot(twice, twice) > 4.0 * far) return NEAR_NOTHING;
    const bool own = other->line == piece->line;
    if (own) {
        const double both = pith_distance(piece->a, piece->b) + pith_distance(other->a, other->b);
        if (fabs(other->along - piece->along) - 0.5 * both <= apart) return NEAR_NOTHING;
    }
    if (!(near_distance(piece->a, piece->b, other->a, other->b) < distance)) return NEAR_NOTHING;
    return own && fabs(other->along) < apart ? NEAR_OWN_START : NEAR_LINE;
}

near_what near_find(const near_grid *grid, const near_piece *piece, double distance, double apart)
{
    if (grid->count == 0) return NEAR_NOTHING;
    const double margin = distance + grid->reach;
    int64_t low[3], high[3];
    const pith_vec3 from = pith_sub(piece->a, grid->origin), to = pith_sub(piece->b, grid->origin);
    const double a[3] = { from.x, from.y, from.z }, b[3] = { to.x, to.y, to.z };
    for (int k = 0; k < 3; ++k) {
        low[k] = cell_along(grid, fmin(a[k], b[k]) - margin);
        high[k] = cell_along(grid, fmax(a[k], b[k]) + margin);
    }
    const double between = margin + 0.5 * pith_distance(from, to), far = between * between;
    near_what found = NEAR_NOTHING;
    for (int64_t z = low[2]; z <= high[2]; ++z)
        for (int64_t y = low[1]; y <= high[1]; ++y)
            for (int64_t x = low[0]; x <= high[0]; ++x) {
                const size_t slot = slot_of(grid, cell_key(x, y, z));
                if (!grid->keys[slot]) continue;
                for (uint32_t i = grid->first[slot]; i != PITH_NONE; i = grid->pieces[i].next) {
                    const near_piece *other = &grid->pieces[i];
                    if (grid->faced && pith_dot(piece->normal, other->normal) < same_side) continue;
                    const near_what here = judge(piece, other, distance, far, apart);
                    if (here == NEAR_LINE) return here;
                    if (here != NEAR_NOTHING) found = here;
                }
            }
    return found;
}
