/* What is cut and asked in the benches of diffusion surfaces. */
#ifndef PITH_BENCH_DIFFUSION_OBJECT_H
#define PITH_BENCH_DIFFUSION_OBJECT_H

#include "bench.h"

#include "pith/diffusion.h"

enum { SURFACES = 64 };

typedef struct diffusion_object {
    const char *name;
    pith_mesh *meshes[SURFACES];
    float (*colours[SURFACES][2])[4]; /* front, back */
    pith_diffusion_surface surfaces[SURFACES];
    size_t count;
    pith_diffusion *diffusion;
} diffusion_object;

typedef pith_status diffusion_object_make(diffusion_object *to, uint32_t detail, pith_error *err);
/* One ball in another; a fruit with skin, wall, core and 27 seeds. Each detail has four times as many triangles. */
diffusion_object_make diffusion_object_balls, diffusion_object_fruit;
/* To be freed after failures, too. */
pith_status diffusion_object_create(diffusion_object *to, diffusion_object_make *make, uint32_t detail,
                                    pith_error *err);
void diffusion_object_free(diffusion_object *gone);

#endif
