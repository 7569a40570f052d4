/* Filling a surface with tetrahedra: options, the choice of the mesher, and the way to the wanted number. */
#include "tets_internal.h"

#include <limits.h>
#include <stdio.h>
#include <string.h>

/* ---- options --------------------------------------------------------------------------------------------------- */

static const char *const mesher_words[] = { "auto", "tetgen", "stuffing", NULL };

static const pith_param tets_items[] = {
    { "mesher", "1", "who fills the surface; auto takes TetGen, and stuffing where the surface is dirty or TetGen fails",
      PITH_PARAM_CHOICE, 0, PITH_MESHER_AUTO, 2, offsetof(pith_tets_options, mesher), mesher_words },
    { "tetrahedra", "1", "wanted number of tetrahedra; 0 leaves it to edge_length or the surface's own resolution",
      PITH_PARAM_UINT, 0, 0, 2e7, offsetof(pith_tets_options, tetrahedra), NULL },
    { "edge_length", "model units", "wanted length of edges, when tetrahedra is 0; 0: not given",
      PITH_PARAM_DOUBLE, 0, 0, 1e60, offsetof(pith_tets_options, edge_length), NULL },
    { "radius_edge", "1", "TetGen's bound on circumradius over shortest edge; smaller gives rounder and more tetrahedra",
      PITH_PARAM_DOUBLE, 1.1, 1.2, 10, offsetof(pith_tets_options, radius_edge), NULL },
    { "time_limit", "s", "seconds that one run of the mesher process may take",
      PITH_PARAM_DOUBLE, 0.01, 300, 86400, offsetof(pith_tets_options, time_limit), NULL },
    { "memory_limit", "MiB", "memory that the mesher process may use",
      PITH_PARAM_DOUBLE, 16, 8192, 1048576, offsetof(pith_tets_options, memory_limit), NULL },
};

const pith_params pith_tets_params = { "tets", tets_items, sizeof tets_items / sizeof *tets_items,
                                       sizeof(pith_tets_options) };

pith_tets_options pith_tets_options_default(void)
{
    pith_tets_options options;
    pith_params_defaults(&pith_tets_params, &options);
    return options;
}

/* ---- one job --------------------------------------------------------------------------------------------------- */

enum { MOST_RUNS = 3 };
static const double most_tets = 2e7;    /* more than any consumer here holds */
static const double near_enough = 0.08; /* of the wanted number */

typedef struct filling {
    pith_mesh *surface;                 /* cleaned */
    pith_mesh_view view;
    pith_mesh_report report;
    pith_winding *winding;
    const pith_vec3 *interior;
    size_t interior_count;
    const pith_tets_options *options;
    const pith_progress *progress;
    double volume;                      /* enclosed, estimated */
    double wanted;                      /* number of tetrahedra; 0: no wish */
} filling;

/* Wanted number from the options; an edge length L counts as tetrahedra of the volume L^3 / (6 sqrt 2) of a regular
   one. */
static pith_status choose_wanted(filling *f, pith_error *err)
{
    const double edge = f->options->edge_length;
    f->wanted = f->options->tetrahedra;
    if (f->options->tetrahedra > 0 || !(edge > 0.0)) return PITH_OK;
    f->wanted = f->volume * 6.0 * sqrt(2.0) / (edge * edge * edge);
    if (!(f->wanted <= most_tets))
        return pith_fail(err, PITH_BAD_ARGUMENT, "edge_length %g would take about %.3g tetrahedra, the most is %.3g; "
                         "choose %.3g or more", edge, f->wanted, most_tets,
                         cbrt(f->volume * 6.0 * sqrt(2.0) / most_tets));
    if (f->wanted < 1.0) f->wanted = 1.0;
    return PITH_OK;
}

/* Keeps the candidate when its number is nearer to the wanted one, else destroys it. */
static void keep_nearest(pith_tets **best, pith_tets *candidate, double wanted)
{
    if (*best && !(fabs(log(candidate->tet_count / wanted)) < fabs(log((*best)->tet_count / wanted)))) {
        pith_tets_destroy(candidate);
        return;
    }
    pith_tets_destroy(*best);
    *best = candidate;
}

/* ---- regions --------------------------------------------------------------------------------------------------- */

/* The surface's triangles in a hash table of index + 1. */
static pith_status hash_triangles(const pith_mesh_view *surface, uint32_t **table, size_t *slots, pith_error *err)
{
    *slots = pith_table_size(surface->triangle_count);
    *table = pith_alloc(*slots, sizeof **table);
    if (!*table) return PITH_OUT_OF_MEMORY(err, "the surface's triangles");
    for (uint32_t t = 0; t < surface->triangle_count; ++t) {
        const uint32_t *v = surface->triangles[t];
        size_t slot = pith_face_hash(pith_face_key_of(v[0], v[1], v[2])) & (*slots - 1);
        while ((*table)[slot]) slot = (slot + 1) & (*slots - 1);
        (*table)[slot] = t + 1;
    }
    return PITH_OK;
}

static bool is_surface_face(const pith_mesh_view *surface, const uint32_t *table, size_t slots, const uint32_t *tet,
                            int k)
{
    const uint8_t *f = pith_tet_faces[k];
    const pith_face_key key = pith_face_key_of(tet[f[0]], tet[f[1]], tet[f[2]]);
    if (key.v[2] >= surface->vertex_count) return false;
    for (size_t slot = pith_face_hash(key) & (slots - 1); table[slot]; slot = (slot + 1) & (slots - 1)) {
        const uint32_t *v = surface->triangles[table[slot] - 1];
        if (pith_face_same(key, pith_face_key_of(v[0], v[1], v[2]))) return true;
    }
    return false;
}

/* Is the region that tet `seed` belongs to part of the body? Asked at the middle of its largest tetrahedron, where the
   winding number is furthest from any doubt. */
static bool region_is_body(const filling *f, const pith_tets_view *tets, const uint32_t *members, uint32_t count)
{
    uint32_t largest = members[0];
    for (uint32_t i = 1; i < count; ++i)
        if (pith_tets_volume_of(tets, members[i]) > pith_tets_volume_of(tets, largest)) largest = members[i];
    const uint32_t *v = tets->tets[largest];
    pith_vec3 middle = pith_v3(0, 0, 0);
    for (int k = 0; k < 4; ++k) middle = pith_madd(middle, tets->positions[v[k]], 0.25);
    return pith_winding_at(f->winding, middle) > 0.5;
}

/* Marks the tetrahedra of regions outside the body; returns through *dropped how many. Regions are connected through
   faces that are not triangles of the surface. */
static pith_status mark_cavities(const filling *f, const pith_tets_view *tets, bool *drop, uint32_t *dropped,
                                 pith_error *err)
{
    uint32_t *table = NULL, *queue = pith_alloc(tets->tet_count, sizeof *queue);
    bool *seen = pith_alloc(tets->tet_count, sizeof *seen);
    size_t slots = 0;
    pith_status status = queue && seen ? hash_triangles(&f->view, &table, &slots, err)
                                       : PITH_OUT_OF_MEMORY(err, "the regions of the mesh");
    for (uint32_t seed = 0; seed < tets->tet_count && status == PITH_OK; ++seed) {
        if (seen[seed]) continue;
        uint32_t count = 0;
        queue[count++] = seed;
        seen[seed] = true;
        for (uint32_t i = 0; i < count; ++i)
            for (int k = 0; k < 4; ++k) {
                const uint32_t t = queue[i], n = tets->neighbours[t][k];
                if (n == PITH_NONE || seen[n] || is_surface_face(&f->view, table, slots, tets->tets[t], k)) continue;
                seen[n] = true;
                queue[count++] = n;
            }
        if (region_is_body(f, tets, queue, count)) continue;
        for (uint32_t i = 0; i < count; ++i) drop[queue[i]] = true;
        *dropped += count;
    }
    pith_free(table);
    pith_free(queue);
    pith_free(seen);
    return status;
}

/* The mesh without the marked tetrahedra and without the vertices that only they used; the surface's stay. */
static pith_status without(const pith_tets_view *tets, const bool *drop, uint32_t dropped, uint32_t keep_first,
                           pith_tets **rest, pith_error *err)
{
    uint32_t *new_index = pith_alloc(tets->vertex_count, sizeof *new_index), vertices = 0, count = 0;
    pith_vec3 *positions = pith_alloc(tets->vertex_count, sizeof *positions);
    uint32_t (*corners)[4] = pith_alloc(tets->tet_count - dropped, sizeof *corners);
    if (!new_index || !positions || !corners) {
        pith_free(new_index);
        pith_free(positions);
        pith_free(corners);
        return PITH_OUT_OF_MEMORY(err, "the mesh without its cavities");
    }
    for (uint32_t i = keep_first; i < tets->vertex_count; ++i) new_index[i] = PITH_NONE;
    for (uint32_t t = 0; t < tets->tet_count; ++t)
        for (int k = 0; k < 4 && !drop[t]; ++k) new_index[tets->tets[t][k]] = 0;
    for (uint32_t i = 0; i < tets->vertex_count; ++i)
        if (new_index[i] != PITH_NONE) {
            positions[vertices] = tets->positions[i];
            new_index[i] = vertices++;
        }
    for (uint32_t t = 0; t < tets->tet_count; ++t) {
        if (drop[t]) continue;
        for (int k = 0; k < 4; ++k) corners[count][k] = new_index[tets->tets[t][k]];
        ++count;
    }
    pith_free(new_index);
    return pith_tets_adopt(positions, vertices, corners, count, rest, err);
}

/* TetGen fills every region that the surface walls off from the outside, cavities too; those are taken out again. */
static pith_status drop_cavities(const filling *f, pith_tets **tets, pith_error *err)
{
    if (f->report.components < 2) return PITH_OK;
    const pith_tets_view view = pith_tets_look(*tets);
    bool *drop = pith_alloc(view.tet_count, sizeof *drop);
    if (!drop) return PITH_OUT_OF_MEMORY(err, "the regions of the mesh");
    uint32_t dropped = 0;
    pith_tets *rest = NULL;
    pith_status status = mark_cavities(f, &view, drop, &dropped, err);
    if (status == PITH_OK && dropped == view.tet_count)
        status = pith_fail(err, PITH_BAD_MESH, "the surface encloses nothing: every region lies outside by its "
                           "winding number; turn the surface outward");
    if (status == PITH_OK && dropped > 0)
        status = without(&view, drop, dropped, f->view.vertex_count, &rest, err);
    pith_free(drop);
    if (rest) {
        pith_tets_destroy(*tets);
        *tets = rest;
    }
    return status;
}

/* ---- TetGen ---------------------------------------------------------------------------------------------------- */

/* Interior points that may become vertices: inside, and further from the surface than 0.3 of the nearest triangle's
   edge, because the surface may not move out of their way. */
static pith_status usable_interior(const filling *f, pith_vec3 **usable, size_t *count, pith_error *err)
{
    pith_tracer *tracer = NULL;
    pith_nearest *nearest = pith_alloc(f->interior_count, sizeof *nearest);
    pith_vec3 *kept = pith_alloc(f->interior_count, sizeof *kept);
    pith_status status = nearest && kept ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the interior points");
    if (status == PITH_OK) status = pith_tracer_create(&f->view, &tracer, err);
    size_t used = 0;
    if (status == PITH_OK) {
        pith_tracer_nearest(tracer, f->interior, f->interior_count, nearest);
        for (size_t i = 0; i < f->interior_count; ++i) {
            const pith_vec3 p = f->interior[i];
            if (!pith_finite(p) || nearest[i].triangle >= f->view.triangle_count) continue;
            const uint32_t *v = f->view.triangles[nearest[i].triangle];
            const pith_vec3 a = f->view.positions[v[0]], b = f->view.positions[v[1]], c = f->view.positions[v[2]];
            const double edge = (pith_distance(a, b) + pith_distance(b, c) + pith_distance(c, a)) / 3.0;
            if (nearest[i].distance > 0.3 * edge && pith_winding_at(f->winding, p) > 0.5) kept[used++] = p;
        }
    }
    pith_tracer_destroy(tracer);
    pith_free(nearest);
    if (status != PITH_OK) {
        pith_free(kept);
        return status;
    }
    *usable = kept;
    *count = used;
    return PITH_OK;
}

/* TetGen's answer to a volume bound, as measured on fruits of 1 280 to 81 920 triangles: with x = volume / bound it makes
   about sqrt(floor^2 + (gain x)^2) tetrahedra, gain 2, where floor is what the surface's own triangles force: 3.7 for
   each of 1 280, about one more for each fourfold number of triangles. */
typedef struct size_model { double floor, gain; } size_model;

static size_model guess_size(uint32_t triangles)
{
    const double each = 3.7 + 0.95 * log2(triangles / 1280.0) / 2.0;
    return (size_model){ (each > 2.0 ? each : 2.0) * triangles, 2.0 };
}

/* volume / bound for a wanted number; 0, no bound, where the floor is above it. */
static double size_for(size_model model, double wanted)
{
    return wanted > model.floor ? sqrt(wanted * wanted - model.floor * model.floor) / model.gain : 0.0;
}

static void correct_size(size_model *model, double x, double count)
{
    if (!(x > 0.0) || count < 1.05 * model->floor) model->floor = x > 0.0 ? 0.9 * count : count;
    if (x > 0.0) model->gain = sqrt(count * count - model->floor * model->floor) / x;
}

/* Runs TetGen until the number is near enough to the wanted one, or cannot come nearer. */
static pith_status approach_number(const filling *f, const char *program, pith_tetgen_job *job, pith_tets **best,
                                   pith_error *err)
{
    size_model model = guess_size(f->view.triangle_count);
    double x = f->wanted > 0.0 ? size_for(model, f->wanted) : 0.0;
    for (int run = 0; run < MOST_RUNS; ++run) {
        pith_tets *made = NULL;
        job->volume_bound = x > 0.0 ? f->volume / x : 0.0;
        pith_status status = pith_tetgen_run(program, job, f->progress, &made, err);
        if (status == PITH_OK) status = drop_cavities(f, &made, err);
        if (status != PITH_OK) {
            pith_tets_destroy(made);
            return status;
        }
        const double count = made->tet_count;
        keep_nearest(best, made, f->wanted > 0.0 ? f->wanted : 1.0);
        if (!(f->wanted > 0.0) || fabs(count / f->wanted - 1.0) <= near_enough) break;
        correct_size(&model, x, count);
        const double next = size_for(model, f->wanted);
        if (fabs(next - x) <= 0.03 * x) break;
        x = next;
        job->check_intersections = false;
    }
    return PITH_OK;
}

static pith_status run_tetgen(const filling *f, pith_tets **tets, pith_error *err)
{
    char program[PATH_MAX];
    PITH_TRY(pith_tetgen_find(program, sizeof program, err));
    pith_vec3 *interior = NULL;
    size_t interior_count = 0;
    if (f->interior_count > 0) PITH_TRY(usable_interior(f, &interior, &interior_count, err));
    pith_tetgen_job job = { .surface = f->view, .interior = interior, .interior_count = interior_count,
                            .radius_edge = f->options->radius_edge, .time_limit = f->options->time_limit,
                            .memory_limit = f->options->memory_limit, .check_intersections = true };
    pith_tets *best = NULL;
    pith_status status = approach_number(f, program, &job, &best, err);
    pith_free(interior);
    /* A later run that fails, on a limit perhaps, leaves the earlier result; but not when somebody cancelled. */
    if (best && status != PITH_CANCELLED) status = PITH_OK;
    if (status == PITH_OK) *tets = best;
    else pith_tets_destroy(best);
    return status;
}

/* ---- stuffing -------------------------------------------------------------------------------------------------- */

/* Volume of the region of winding number above one half, on a lattice of some 30 000 points: for surfaces whose
   divergence theorem gives nonsense. */
static double sampled_volume(const filling *f)
{
    const pith_vec3 size = pith_sub(f->report.box.high, f->report.box.low);
    const double step = fmax(cbrt(size.x * size.y * size.z / 27000.0), 1e-3 * fmax(size.x, fmax(size.y, size.z)));
    const int nx = (int)ceil(size.x / step), ny = (int)ceil(size.y / step), nz = (int)ceil(size.z / step);
    const int cells = nx * ny * nz;
    int inside = 0;
#pragma omp parallel for num_threads(pith_threads()) schedule(dynamic, 256) reduction(+ : inside)
    for (int c = 0; c < cells; ++c) {
        const pith_vec3 at = pith_v3((c % nx + 0.5) / nx, (c / nx % ny + 0.5) / ny, (c / nx / ny + 0.5) / nz);
        const pith_vec3 p = pith_add(f->report.box.low, pith_v3(at.x * size.x, at.y * size.y, at.z * size.z));
        inside += pith_winding_at(f->winding, p) > 0.5;
    }
    return inside > 0 ? size.x * size.y * size.z * inside / cells : 0.0;
}

/* Without a wish, edges as long as the surface's own, within what fits in memory comfortably. */
static double default_number(const filling *f)
{
    const double triangle = f->report.area / f->view.triangle_count, edge = sqrt(triangle * 4.0 / sqrt(3.0));
    const double number = f->volume * 6.0 * sqrt(2.0) / (edge * edge * edge);
    return number > 500.0 ? fmin(number, 5e5) : 500.0;
}

/* The body-centred lattice has 12 tetrahedra to a cube; the boundary adds some, which the next runs correct. */
static pith_status run_stuffing(const filling *f, pith_tets **tets, pith_error *err)
{
    if (!(f->volume > 0.0))
        return pith_fail(err, PITH_BAD_MESH, "the surface encloses nothing: its winding number is nowhere above one "
                         "half; close it or turn it outward");
    const double wanted = f->wanted > 0.0 ? f->wanted : default_number(f);
    double spacing = cbrt(12.0 * f->volume / wanted);
    pith_tets *best = NULL;
    pith_status status = PITH_OK;
    for (int run = 0; run < MOST_RUNS; ++run) {
        pith_tets *made = NULL;
        status = pith_stuffing_run(&f->view, f->winding, spacing, f->progress, &made, err);
        if (status == PITH_BAD_MESH && run < MOST_RUNS - 1) { /* nothing met: the body is thinner than the lattice */
            spacing *= 0.5;
            continue;
        }
        if (status != PITH_OK) break;
        const double ratio = made->tet_count / wanted;
        keep_nearest(&best, made, wanted);
        if (fabs(ratio - 1.0) <= near_enough) break;
        spacing *= cbrt(ratio);
    }
    if (best && status != PITH_OK && status != PITH_CANCELLED) status = PITH_OK;
    if (status == PITH_OK) *tets = best;
    else pith_tets_destroy(best);
    return status;
}

/* ---- the choice ------------------------------------------------------------------------------------------------ */

/* TetGen keeps the surface's triangles, and puts no vertex near a large one: a cube of twelve stays six tets whatever
   is asked for. */
static bool too_coarse(const filling *f, const pith_tets *made) { return made->tet_count < 0.5 * f->wanted; }

static pith_status fill_with(const filling *f, uint32_t mesher, uint32_t *used, char *why, size_t capacity,
                             pith_tets **tets, pith_error *err)
{
    const bool clean = f->report.closed && f->report.self_intersections == 0;
    char complaint[256] = "";
    if (!clean) pith_mesh_complaint(&f->report, complaint, sizeof complaint);
    if (mesher == PITH_MESHER_TETGEN && !clean)
        return pith_fail(err, PITH_BAD_MESH, "TetGen cannot fill this surface: %s", complaint);
    *used = mesher;
    if (mesher == PITH_MESHER_STUFFING) return run_stuffing(f, tets, err);
    if (clean) {
        pith_error reason = { PITH_OK, "" };
        const pith_status status = run_tetgen(f, tets, &reason);
        *used = PITH_MESHER_TETGEN;
        if (status == PITH_OK && (mesher == PITH_MESHER_TETGEN || !too_coarse(f, *tets))) return PITH_OK;
        if (status == PITH_OK) {
            pith_fail(&reason, PITH_OK, "keeping its %u triangles allows only %u of the %.0f tetrahedra wanted; give the "
                      "surface smaller triangles to have it kept", f->view.triangle_count, (*tets)->tet_count, f->wanted);
            pith_tets_destroy(*tets);
            *tets = NULL;
        } else if (mesher == PITH_MESHER_TETGEN || status == PITH_CANCELLED || status == PITH_NO_MEMORY)
            return pith_fail(err, status, "%s", reason.message);
        snprintf(why, capacity, "%.*s", (int)capacity - 1, reason.message);
    } else {
        snprintf(why, capacity, "%s", complaint);
    }
    *used = PITH_MESHER_STUFFING;
    return run_stuffing(f, tets, err);
}

static pith_status prepare(filling *f, const pith_mesh *surface, pith_error *err)
{
    PITH_TRY(pith_mesh_clean(surface, &f->surface, &f->report, err));
    f->view = pith_mesh_look(f->surface);
    if (f->view.triangle_count == 0)
        return pith_fail(err, PITH_BAD_MESH, "the surface has no triangle with an area; there is nothing to fill");
    PITH_TRY(pith_winding_create(&f->view, &f->winding, err));
    const bool clean = f->report.closed && f->report.self_intersections == 0;
    f->volume = clean && f->options->mesher != PITH_MESHER_STUFFING ? f->report.volume : sampled_volume(f);
    return choose_wanted(f, err);
}

pith_status pith_tets_mesh(const pith_mesh *surface, const pith_vec3 *interior, size_t interior_count,
                           const pith_tets_options *options, const pith_progress *progress, pith_tets **tets,
                           pith_tets_report *report, pith_error *err)
{
    if (!surface || !options || !tets || (interior_count && !interior))
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_tets_mesh: a pointer is NULL");
    PITH_TRY(pith_params_check(&pith_tets_params, options, err));
    filling f = { .interior = interior, .interior_count = interior_count, .options = options, .progress = progress };
    pith_tets_report made_report = { 0 };
    pith_tets *made = NULL;
    char why[sizeof made_report.why] = "";
    uint32_t used = 0;
    pith_status status = prepare(&f, surface, err);
    if (status == PITH_OK) status = fill_with(&f, options->mesher, &used, why, sizeof why, &made, err);
    /* TetGen's mesh begins with the surface's vertices; they keep their places. */
    if (status == PITH_OK)
        status = pith_tets_order(made, used == PITH_MESHER_TETGEN ? f.view.vertex_count : 0, err);
    pith_winding_destroy(f.winding);
    pith_mesh_destroy(f.surface);
    if (status != PITH_OK) {
        pith_tets_destroy(made);
        return status;
    }
    pith_tets_measure(made, &made_report);
    made_report.mesher = used;
    memcpy(made_report.why, why, sizeof why);
    if (report) *report = made_report;
    *tets = made;
    return PITH_OK;
}
