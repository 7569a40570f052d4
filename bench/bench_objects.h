/* Objects of diffusion surfaces that benches ask for colours. */
#ifndef PITH_BENCH_OBJECTS_H
#define PITH_BENCH_OBJECTS_H

#include "bench.h"

#include "pith/diffusion.h"

enum { BENCH_SURFACES = 64 };

typedef struct bench_object {
    const char *name;
    pith_mesh *meshes[BENCH_SURFACES];
    float (*colours[BENCH_SURFACES][2])[4]; /* front, back */
    double *blur[BENCH_SURFACES];
    pith_diffusion_surface surfaces[BENCH_SURFACES];
    size_t count;
    pith_diffusion *diffusion;
} bench_object;

/* Each adds its surfaces; 20 * 4^detail triangles for the largest of them. */
typedef pith_status bench_make_object(bench_object *to, uint32_t detail, pith_error *err);
bench_make_object bench_balls, bench_fruit, bench_onion, bench_persimmon;
/* Makes it and the diffusion between its surfaces; to be freed after failures, too. */
pith_status bench_object_create(bench_object *to, bench_make_object *make, uint32_t detail, pith_error *err);
void bench_object_free(bench_object *gone);

#endif
