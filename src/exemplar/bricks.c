/* Courses of blocks with joints between them: the structured exemplar on which lapped textures fail (Takayama et al.
   2008, Fig. 15). A block is a box with rounded edges, seen through its distance function, so that its edges are as
   soft as told and never jagged. */
#include "exemplar_internal.h"

pith_status brickwork_make(const pith_brick_layer *layer, const exemplar_space *space, uint64_t seed, brickwork *made,
                           pith_error *err)
{
    brickwork w = { .layer = layer, .seed = seed, .repeats_s = space->repeats_s };
    const double sizes[3] = { layer->size_r, layer->size_s, layer->size_t_ };
    double least = INFINITY;
    for (int axis = 0; axis < 3; ++axis) {
        w.voxel[axis] = 1.0 / space->voxels[axis];
        w.count[axis] = cells_of_period(sizes[axis]);
        /* Every second course is shifted, so that only an even number of them repeats. */
        if (axis == 1 && w.repeats_s && w.count[1]) w.count[1] = 2 * (uint32_t)fmax(round(0.5 / layer->size_s), 1.0);
        if (!w.count[axis]) continue;
        const double size = 1.0 / w.count[axis], joint = fmax(layer->joint, w.voxel[axis]);
        if (!(joint < size))
            return pith_fail(err, PITH_BAD_ARGUMENT, "a joint of %g leaves nothing of blocks of %g along %c; give larger "
                             "blocks or thinner joints", joint, size, "rst"[axis]);
        w.half[axis] = 0.5 * (size - joint);
        least = fmin(least, w.half[axis]);
    }
    w.radius = isfinite(least) ? layer->roundness * least : 0.0;
    *made = w;
    return PITH_OK;
}

/* A coordinate in blocks: the block's number within the exemplar, and the offset from its middle, texture units. */
static int64_t block_at(double x, double shift, uint32_t count, double *offset)
{
    const double at = x * count + shift, low = floor(at);
    *offset = (at - low - 0.5) / count;
    const int64_t n = count, block = (int64_t)low % n;
    return block < 0 ? block + n : block;
}

/* Signed distance from a rounded box, and how much it grows over a voxel. */
static double block_distance(const brickwork *w, const double offset[3], double *growth)
{
    double beyond[3] = { 0, 0, 0 }, sum = 0.0, nearest = -INFINITY;
    *growth = w->voxel[0];
    for (int axis = 0; axis < 3; ++axis) {
        if (!w->count[axis]) continue;
        const double past = fabs(offset[axis]) - (w->half[axis] - w->radius);
        if (past > nearest) nearest = past, *growth = w->voxel[axis];
        beyond[axis] = fmax(past, 0.0);
        sum += beyond[axis] * beyond[axis];
    }
    if (!(sum > 0.0)) return nearest - w->radius;
    double slope = 0.0;
    for (int axis = 0; axis < 3; ++axis) slope += beyond[axis] * beyond[axis] * w->voxel[axis] * w->voxel[axis];
    *growth = sqrt(slope / sum);
    return sqrt(sum) - w->radius;
}

void brickwork_paint(const brickwork *w, double r, double s, double t, float *value, uint32_t channels)
{
    const pith_brick_layer *layer = w->layer;
    double offset[3] = { 0, 0, 0 };
    int64_t block[3] = { 0, 0, 0 };
    if (w->count[1]) block[1] = block_at(s, 0.0, w->count[1], &offset[1]);
    const double shift = block[1] & 1 ? 0.5 : 0.0;
    if (w->count[0]) block[0] = block_at(r, shift, w->count[0], &offset[0]);
    if (w->count[2]) block[2] = block_at(t, shift, w->count[2], &offset[2]);

    double growth;
    const double distance = block_distance(w, offset, &growth), width = fmax(growth, layer->softness);
    const float cover = (float)fmin(fmax(0.5 - distance / width, 0.0), 1.0);
    const uint64_t number = (uint64_t)((block[2] * 4096 + block[1]) * 4096 + block[0]);
    const double dark = (double)(pith_mix64(w->seed ^ number) >> 11) * 0x1p-53;
    const float shade = (float)(1.0 - layer->colour_variation * dark);
    for (int c = 0; c < 3; ++c)
        value[c] = layer->joint_colour[c] + cover * (shade * layer->colour[c] - layer->joint_colour[c]);
    value[3] = 1.0f;
    if (channels > 4) value[4] += cover * (float)layer->displacement;
}
