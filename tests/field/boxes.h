/* Tetrahedral boxes whose geometry is known: every cell of a grid cut into the six tetrahedra round its diagonal. */
#ifndef PITH_TEST_BOXES_H
#define PITH_TEST_BOXES_H

#include "check.h"
#include "pith/field.h"

/* boxes boxes side by side with a gap between them, each of g³ cells and unit side, times scale. */
static inline pith_tets *make_boxes(uint32_t boxes, uint32_t g, double scale)
{
    static const int paths[6][4] = { { 0, 1, 3, 7 }, { 0, 3, 2, 7 }, { 0, 2, 6, 7 },
                                     { 0, 6, 4, 7 }, { 0, 4, 5, 7 }, { 0, 5, 1, 7 } };
    const uint32_t side = g + 1, per_box = side * side * side;
    const uint32_t vertex_count = boxes * per_box, tet_count = boxes * 6 * g * g * g;
    pith_vec3 *positions = malloc(vertex_count * sizeof *positions);
    uint32_t (*tets)[4] = malloc(tet_count * sizeof *tets);
    assert_true(positions && tets);
    uint32_t filled = 0;
    for (uint32_t b = 0; b < boxes; ++b) {
        for (uint32_t i = 0; i < per_box; ++i)
            positions[b * per_box + i] = pith_v3(scale * (1.5 * b + (double)(i % side) / g),
                                                 scale * (double)(i / side % side) / g,
                                                 scale * (double)(i / side / side) / g);
        for (uint32_t c = 0; c < g * g * g; ++c) {
            const uint32_t x = c % g, y = c / g % g, z = c / g / g;
            for (int p = 0; p < 6; ++p, ++filled)
                for (int k = 0; k < 4; ++k) {
                    const int bits = paths[p][k];
                    tets[filled][k] = b * per_box + (x + (bits & 1)) + (y + (bits >> 1 & 1)) * side
                                      + (z + (bits >> 2 & 1)) * side * side;
                }
        }
    }
    pith_error err;
    pith_tets *made = NULL;
    const pith_tets_view view = { positions, (const uint32_t (*)[4])tets, NULL, vertex_count, tet_count };
    CHECK_OK(pith_tets_create(&view, &made, &err));
    free(positions);
    free(tets);
    return made;
}

static inline pith_locator *make_locator(const pith_tets *tets)
{
    pith_error err;
    pith_locator *made = NULL;
    CHECK_OK(pith_locator_create(tets, &made, &err));
    return made;
}

#endif
