/* Distinct elements of an exemplar - seeds, vesicles, fibres - as ellipsoids and drops. Centres are Poisson-disc darts
   on a torus: dart throwing after Cook, "Stochastic Sampling in Computer Graphics", ACM TOG 5(1), 1986. */
#include "exemplar_internal.h"

#define DART_TRIES 40       /* darts for one particle before the layer counts as full */
#define LEAST_NARROW 0.05   /* a drop never thins to nothing */
#define CELLS_MAX 64        /* a side of the lattice that neighbours are looked up in */

/* ---- throwing ------------------------------------------------------------------------------------------------ */

/* Centres by cell, so that a dart meets its neighbours only. Cells wrap along the axes that repeat. */
typedef struct dart_board {
    const pith_particle_layer *layer;
    const particle *particles;
    bool wraps[3];
    double reach[3];            /* least distance along each axis */
    uint32_t cells[3];
    uint32_t *first, *next;     /* chains of particles: [cells], [particles]; PITH_NONE ends */
} dart_board;

static uint32_t cell_of(const dart_board *b, const double centre[3], int axis)
{
    const uint32_t cell = (uint32_t)(centre[axis] * b->cells[axis]);
    return cell < b->cells[axis] ? cell : b->cells[axis] - 1;
}

/* Squared distance with each axis in units of the least distance; the short way round where it repeats. */
static double scaled_distance2(const dart_board *b, const double p[3], const double q[3])
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
        double d = fabs(p[axis] - q[axis]);
        if (b->wraps[axis] && d > 0.5) d = 1.0 - d;
        d /= b->reach[axis];
        sum += d * d;
    }
    return sum;
}

static bool has_room(const dart_board *b, const double centre[3])
{
    if (!(b->layer->spacing > 0.0)) return true;
    uint32_t low[3], span[3];
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t cell = cell_of(b, centre, axis), n = b->cells[axis];
        if (!b->wraps[axis]) {
            low[axis] = cell ? cell - 1 : 0;
            span[axis] = (cell + 1 < n ? cell + 1 : n - 1) - low[axis] + 1;
        } else {
            low[axis] = n > 3 ? cell + n - 1 : 0; /* three cells or fewer: all of them, each once */
            span[axis] = n > 3 ? 3 : n;
        }
    }
    for (uint32_t c = 0; c < span[2]; ++c)
        for (uint32_t j = 0; j < span[1]; ++j)
            for (uint32_t a = 0; a < span[0]; ++a) {
                const uint32_t at[3] = { (low[0] + a) % b->cells[0], (low[1] + j) % b->cells[1],
                                         (low[2] + c) % b->cells[2] };
                uint32_t p = b->first[((size_t)at[2] * b->cells[1] + at[1]) * b->cells[0] + at[0]];
                for (; p != PITH_NONE; p = b->next[p])
                    if (scaled_distance2(b, centre, b->particles[p].centre) < 1.0) return false;
            }
    return true;
}

static void remember(dart_board *b, const double centre[3], uint32_t index)
{
    uint32_t *cell = &b->first[((size_t)cell_of(b, centre, 2) * b->cells[1] + cell_of(b, centre, 1)) * b->cells[0] +
                               cell_of(b, centre, 0)];
    b->next[index] = *cell;
    *cell = index;
}

/* Everything but the centre: turn, size, shade, and the box it may touch. Takes the same draws for every particle. */
static void furnish(const pith_particle_layer *layer, const uint32_t voxels[3], pith_rng *rng, particle *p)
{
    const double size = 1.0 - layer->size_variation * pith_rng_unit(rng);
    p->shade = (float)(1.0 - layer->colour_variation * pith_rng_unit(rng));
    const pith_vec3 axis = pith_rng_direction(rng);
    const double angle = layer->tilt * (3.14159265358979323846 / 180.0) * pith_rng_unit(rng);
    const double c = cos(angle), s = sin(angle), n[3] = { axis.x, axis.y, axis.z };
    const double radii[3] = { layer->radius_r, layer->radius_s, layer->radius_t };
    for (int i = 0; i < 3; ++i) {
        p->radius[i] = radii[i] * size;
        /* Rodrigues' rotation of the i-th axis about n. */
        const double e[3] = { i == 0, i == 1, i == 2 };
        const double cross[3] = { n[1] * e[2] - n[2] * e[1], n[2] * e[0] - n[0] * e[2], n[0] * e[1] - n[1] * e[0] };
        for (int k = 0; k < 3; ++k) p->axes[i][k] = c * e[k] + s * cross[k] + (1.0 - c) * n[i] * n[k];
    }
    /* The distance grows by at most 1 over the least half axis, be it that of a drop's tip. */
    const double thin = fmax(1.0 - layer->taper, LEAST_NARROW) * fmin(p->radius[0], fmin(p->radius[1], p->radius[2]));
    const double voxel = 1.0 / fmin(voxels[0], fmin(voxels[1], voxels[2]));
    p->edge = 0.5 * fmax(voxel / thin, layer->softness) + 1e-6;
    const double reach = 1.0 + fmax(layer->halo > 0.0 ? layer->halo_width : 0.0, 0.5 * layer->softness);
    for (int k = 0; k < 3; ++k) {
        double sum = 0.0;
        for (int i = 0; i < 3; ++i) sum += p->axes[i][k] * p->axes[i][k] * p->radius[i] * p->radius[i];
        p->extent[k] = reach * sqrt(sum) + 1.0 / voxels[k]; /* and the voxel's width of an edge */
    }
}

static bool prepare_board(dart_board *b, uint32_t wanted)
{
    const double radii[3] = { b->layer->radius_r, b->layer->radius_s, b->layer->radius_t };
    size_t cells = 1;
    for (int axis = 0; axis < 3; ++axis) {
        /* A sphere of this scaled radius must not reach beyond the neighbouring cells. */
        b->reach[axis] = b->layer->spacing * radii[axis];
        const double fit = b->reach[axis] > 0.0 ? floor(1.0 / b->reach[axis]) : 1.0;
        b->cells[axis] = fit < 1.0 ? 1 : (fit < CELLS_MAX ? (uint32_t)fit : CELLS_MAX);
        cells *= b->cells[axis];
    }
    b->first = pith_alloc(cells, sizeof *b->first);
    b->next = pith_alloc(wanted, sizeof *b->next);
    if (!b->first || !b->next) return false;
    for (size_t i = 0; i < cells; ++i) b->first[i] = PITH_NONE;
    return true;
}

pith_status particles_throw(const pith_particle_layer *layer, const exemplar_space *space, uint64_t seed,
                            uint64_t stream, particle **particles, size_t *count, pith_error *err)
{
    const uint32_t wanted = (uint32_t)layer->density;
    particle *made = pith_alloc(wanted, sizeof *made);
    dart_board board = { .layer = layer, .particles = made, .wraps = { true, space->repeats_s, true } };
    if (!made || !prepare_board(&board, wanted)) {
        pith_free(made);
        pith_free(board.first);
        pith_free(board.next);
        return PITH_OUT_OF_MEMORY(err, "particles");
    }
    pith_rng rng = pith_rng_make(seed, stream);
    uint32_t thrown = 0;
    for (bool full = false; thrown < wanted && !full;) {
        particle p;
        full = true;
        for (int dart = 0; dart < DART_TRIES && full; ++dart) {
            p.centre[0] = layer->r_low + (layer->r_high - layer->r_low) * pith_rng_unit(&rng);
            p.centre[1] = layer->depth_low + (layer->depth_high - layer->depth_low) * pith_rng_unit(&rng);
            p.centre[2] = layer->t_low + (layer->t_high - layer->t_low) * pith_rng_unit(&rng);
            full = !has_room(&board, p.centre);
        }
        if (full) break;
        furnish(layer, space->voxels, &rng, &p);
        made[thrown] = p;
        remember(&board, p.centre, thrown++);
    }
    pith_free(board.first);
    pith_free(board.next);
    *particles = made;
    *count = thrown;
    return PITH_OK;
}

/* ---- painting ------------------------------------------------------------------------------------------------ */

/* How deep a point lies in a particle: distance 0 at the middle, 1 on its surface, and its growth over one voxel (0 where
   the point is no part of the edge). */
static double particle_distance(const pith_particle_layer *layer, const particle *p, const double offset[3],
                                const double voxel[3], double *growth)
{
    double q[3];
    for (int i = 0; i < 3; ++i)
        q[i] = (p->axes[i][0] * offset[0] + p->axes[i][1] * offset[1] + p->axes[i][2] * offset[2]) / p->radius[i];
    /* A drop thins towards its inner end: the section at height q_s is narrowed by up to `taper` there. */
    const double height = q[1] > -1.0 ? (q[1] < 1.0 ? q[1] : 1.0) : -1.0;
    const double narrow = fmax(1.0 - layer->taper * 0.5 * (1.0 + height), LEAST_NARROW);
    q[0] /= narrow, q[2] /= narrow;
    const double d = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
    *growth = 0.0;
    if (fabs(d - 1.0) > p->edge) return d;

    /* Gradient of d, ignoring that `narrow` changes with height: it only sets how wide the edge is. */
    const double slope[3] = { q[0] / (p->radius[0] * narrow), q[1] / p->radius[1], q[2] / (p->radius[2] * narrow) };
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double g = 0.0;
        for (int i = 0; i < 3; ++i) g += p->axes[i][k] * slope[i];
        sum += g * g * voxel[k] * voxel[k];
    }
    *growth =
        d > 0.0 ? sqrt(sum) / d : fmax(voxel[0] / p->radius[0], fmax(voxel[1] / p->radius[1], voxel[2] / p->radius[2]));
    return d;
}

/* The body hides what is under it up to its edge, which is as wide as a voxel or softer. */
static void paint_body(const pith_particle_layer *layer, const particle *p, double d, double growth, float *value,
                       uint32_t channels)
{
    const double width = fmax(growth, layer->softness);
    const float cover = growth > 0.0 ? (float)fmin(fmax((1.0 - d) / width + 0.5, 0.0), 1.0) : (d < 1.0 ? 1.0f : 0.0f);
    if (!(cover > 0.0f)) return;
    const float rim = (float)fmin(d * d, 1.0);
    float colour[3];
    for (int c = 0; c < 3; ++c) colour[c] = layer->core_colour[c] + rim * (layer->colour[c] - layer->core_colour[c]);
    mix_matter(value, colour, p->shade, (float)layer->opacity, cover);
    if (channels > 4) value[4] += cover * (float)layer->displacement;
}

/* The halo is full at the particle's surface and gone at its reach. It stains what is there, opaque or not. */
static void paint_halo(const pith_particle_layer *layer, double d, float *value)
{
    const double out = fmin(fmax((d - 1.0) / layer->halo_width, 0.0), 1.0);
    const float strength = (float)(layer->halo * (1.0 - out) * (1.0 - out) * (1.0 + 2.0 * out));
    for (int c = 0; c < 3; ++c) value[c] += strength * (layer->halo_colour[c] - value[c]);
}

/* One image of a particle: voxels of the slice inside its box. r wraps voxel by voxel, s too or is cut off at 0 and 1. */
static void paint_image(const pith_particle_layer *layer, const particle *p, bool halos, bool repeats_s,
                        pith_grid *exemplar, uint32_t k, double offset_t)
{
    const int64_t n_r = exemplar->size[0], n_s = exemplar->size[1];
    const double voxel[3] = { 1.0 / exemplar->size[0], 1.0 / exemplar->size[1], 1.0 / exemplar->size[2] };
    const int64_t i_low = (int64_t)ceil((p->centre[0] - p->extent[0]) * (double)n_r - 0.5);
    const int64_t i_high = (int64_t)floor((p->centre[0] + p->extent[0]) * (double)n_r - 0.5);
    int64_t j_low = (int64_t)ceil((p->centre[1] - p->extent[1]) * (double)n_s - 0.5);
    int64_t j_high = (int64_t)floor((p->centre[1] + p->extent[1]) * (double)n_s - 0.5);
    if (j_low < 0 && !repeats_s) j_low = 0;
    if (j_high > n_s - 1 && !repeats_s) j_high = n_s - 1;
    for (int64_t j = j_low; j <= j_high; ++j) {
        const int64_t row = ((j % n_s) + n_s) % n_s;
        for (int64_t i = i_low; i <= i_high; ++i) {
            const double offset[3] = { ((double)i + 0.5) * voxel[0] - p->centre[0],
                                       ((double)j + 0.5) * voxel[1] - p->centre[1], offset_t };
            double growth;
            const double d = particle_distance(layer, p, offset, voxel, &growth);
            const int64_t wrapped = ((i % n_r) + n_r) % n_r;
            float *value = exemplar->values + (((int64_t)k * n_s + row) * n_r + wrapped) * exemplar->channels;
            if (halos)
                paint_halo(layer, d, value);
            else
                paint_body(layer, p, d, growth, value, exemplar->channels);
        }
    }
}

void particles_paint_slice(const pith_particle_layer *layer, const particle *particles, size_t count, bool repeats_s,
                           pith_grid *exemplar, uint32_t k)
{
    const double t = (k + 0.5) / exemplar->size[2];
    /* All halos lie under all bodies: no particle is paled by its neighbour. */
    for (int pass = layer->halo > 0.0 ? 0 : 1; pass < 2; ++pass)
        for (size_t i = 0; i < count; ++i) {
            const particle *p = &particles[i];
            /* Every image of the particle, whole periods along t apart, that reaches this slice. */
            const double low = ceil(p->centre[2] - p->extent[2] - t), high = floor(p->centre[2] + p->extent[2] - t);
            for (double image = low; image <= high; image += 1.0)
                paint_image(layer, p, pass == 0, repeats_s, exemplar, k, t + image - p->centre[2]);
        }
}
