/* A solid that answers one colour and writes down what it was asked. For one thread. */
#ifndef PITH_TESTS_PROBE_H
#define PITH_TESTS_PROBE_H

#include "pith/solid_kind.h"
#include "check.h"

enum { PROBE_ROOM = 1 << 16 };

typedef struct probe {
    struct pith_solid base;
    float colour[4];
    size_t count;
    bool tets; /* the last question named them */
    pith_vec3 points[PROBE_ROOM], normals[PROBE_ROOM], views[PROBE_ROOM], lights[PROBE_ROOM];
    float footprints[PROBE_ROOM];
} probe;

static void probe_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    probe *p = (probe *)solid;
    p->tets = query->tets != NULL;
    for (size_t i = 0; i < query->count; ++i) {
        memcpy(out + 4 * i, p->colour, sizeof p->colour);
        if (p->count == PROBE_ROOM) continue;
        assert_true(query->normals && query->views && query->lights && query->footprints);
        p->points[p->count] = query->points[i];
        p->normals[p->count] = query->normals[i];
        p->views[p->count] = query->views[i];
        p->lights[p->count] = query->lights[i];
        p->footprints[p->count++] = query->footprints[i];
    }
}

static void probe_destroy(pith_solid *solid) { free(solid); }

static inline probe *probe_make(float red, float green, float blue, float alpha)
{
    static const pith_solid_class class = { "probe", probe_sample, probe_destroy };
    probe *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->base = (struct pith_solid){ &class, 4 };
    p->colour[0] = red;
    p->colour[1] = green;
    p->colour[2] = blue;
    p->colour[3] = alpha;
    return p;
}

#endif
