/** pith/solid_kind.h: what a kind of solid implements, for rooms and programs that make a kind of their own. It fills a
 *  pith_solid_class and has a function that creates the solid; whoever asks never sees the difference. */
#ifndef PITH_SOLID_KIND_H
#define PITH_SOLID_KIND_H

#include "pith/solid.h"

/* Most points a kind is asked in one go; kinds may keep scratch of this size on the stack. */
enum { SOLID_BLOCK = 512 };

typedef struct pith_solid_class {
    const char *kind;
    /* Answers query->count <= SOLID_BLOCK points into out [count][channels]; called concurrently, allocates nothing. */
    void (*sample)(const pith_solid *solid, const pith_query *query, float *out);
    void (*destroy)(pith_solid *solid); /* frees everything including the solid itself */
} pith_solid_class;

/* Every kind's struct begins with this. */
struct pith_solid {
    const pith_solid_class *class;
    uint32_t channels; /* >= 4 */
};

/** The part of a query that begins at `first`; borrows its arrays. */
static inline pith_query pith_query_part(const pith_query *query, size_t first, size_t count)
{
    return (pith_query){
        .points = query->points + first,
        .normals = query->normals ? query->normals + first : NULL,
        .views = query->views ? query->views + first : NULL,
        .lights = query->lights ? query->lights + first : NULL,
        .footprints = query->footprints ? query->footprints + first : NULL,
        .tets = query->tets ? query->tets + first : NULL,
        .weights = query->weights ? query->weights + first : NULL,
        .count = count,
    };
}

#endif
