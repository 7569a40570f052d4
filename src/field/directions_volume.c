/* Directions at points from a field over voxels. */
#include "field_internal.h"

/* The voxel that a point lies in, along one axis; -1 outside. */
static int64_t voxel_along(double offset, double spacing, uint32_t size)
{
    const double at = floor(offset / spacing + 0.5);
    return at >= 0.0 && at < size ? (int64_t)at : -1;
}

/* The field itself goes on beyond the inner voxels; a line must end there. */
static void sample_volume(const void *user, const pith_vec3 *points, size_t count, pith_vec3 *vectors)
{
    const pith_volume_field *field = user;
    const pith_volume_view view = pith_volume_field_look(field);
    pith_volume_field_sample(field, points, count, vectors);
    for (size_t i = 0; i < count; ++i) {
        const pith_vec3 d = pith_sub(points[i], view.origin);
        const int64_t x = voxel_along(d.x, view.spacing, view.size[0]);
        const int64_t y = voxel_along(d.y, view.spacing, view.size[1]);
        const int64_t z = voxel_along(d.z, view.spacing, view.size[2]);
        if (x < 0 || y < 0 || z < 0 || !view.inside[(z * view.size[1] + y) * view.size[0] + x])
            vectors[i] = pith_v3(0, 0, 0);
    }
}

pith_directions pith_directions_of_volume(const pith_volume_field *borrowed)
{
    return (pith_directions){ sample_volume, borrowed };
}
