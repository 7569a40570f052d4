/* What the files of the bake room share: questions about corners of a shell. */
#ifndef PITH_BAKE_INTERNAL_H
#define PITH_BAKE_INTERNAL_H

#include "pith/bake.h"

/* Corners of a shell's triangles at which a solid is to be asked. */
typedef struct bake_corners {
    const pith_shell *shell;
    const pith_solid *solid;
    const uint32_t *corners;        /* [count] 3 * triangle + corner */
    const pith_vec3 *normals;       /* [count] */
    uint32_t count;
    float footprint;                /* model units */
} bake_corners;

/* Gets the answers to corners first .. first + count - 1, [count][channels]. */
typedef void bake_take(void *user, size_t first, size_t count, const float *answers, uint32_t channels);

/* Asks stretch by stretch, telling the solid in which tet each corner lies. */
pith_status bake_ask_corners(const bake_corners *corners, const pith_progress *progress, bake_take *take, void *user,
                             pith_error *err);

#endif
