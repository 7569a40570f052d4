/* Coverage of a mesh by patches (Takayama et al. 2008 §5.2.6): alpha gathered at 165 points of every tet, and the list of
   tets that are not covered yet (§5.2.3). */
#include "lapped_internal.h"

#include <string.h>

enum { LATTICE = 8 };

/* The lattice's points (a,b,c,d)/8, a+b+c+d = 8, sorted by distance from the barycentre. */
static void make_lattice(lapped_coverage *cover)
{
    int points[LAPPED_SAMPLES][5], n = 0;
    for (int a = 0; a <= LATTICE; ++a)
        for (int b = 0; a + b <= LATTICE; ++b)
            for (int c = 0; a + b + c <= LATTICE; ++c) {
                const int at[4] = { a, b, c, LATTICE - a - b - c };
                int far = 0, i = n++;
                for (int k = 0; k < 4; ++k) far += (at[k] - LATTICE / 4) * (at[k] - LATTICE / 4);
                while (i > 0 && points[i - 1][4] > far) memcpy(points[i], points[i - 1], sizeof points[i]), --i;
                for (int k = 0; k < 4; ++k) points[i][k] = at[k];
                points[i][4] = far;
            }
    for (int i = 0; i < LAPPED_SAMPLES; ++i)
        for (int k = 0; k < 4; ++k) cover->weights[i][k] = (float)points[i][k] / LATTICE;
}

void lapped_coverage_free(lapped_coverage *cover)
{
    if (!cover) return;
    pith_free(cover->alpha), pith_free(cover->left), pith_free(cover->open), pith_free(cover->place);
    pith_free(cover);
}

lapped_coverage *lapped_coverage_make(uint32_t tet_count)
{
    lapped_coverage *cover = pith_alloc(1, sizeof *cover);
    if (!cover) return NULL;
    cover->alpha = pith_alloc(tet_count, sizeof *cover->alpha);
    cover->left = pith_alloc(tet_count, 1);
    cover->open = pith_alloc(tet_count, sizeof *cover->open);
    cover->place = pith_alloc(tet_count, sizeof *cover->place);
    if (!cover->alpha || !cover->left || !cover->open || !cover->place) {
        lapped_coverage_free(cover);
        return NULL;
    }
    make_lattice(cover);
    memset(cover->left, LAPPED_SAMPLES, tet_count);
    for (uint32_t t = 0; t < tet_count; ++t) cover->open[t] = cover->place[t] = t;
    cover->open_count = tet_count;
    return cover;
}

void lapped_coverage_close(lapped_coverage *cover, uint32_t tet)
{
    const uint32_t at = cover->place[tet];
    if (cover->left[tet] > 0 || at == PITH_NONE) return;
    const uint32_t last = cover->open[--cover->open_count];
    cover->open[at] = last;
    cover->place[last] = at;
    cover->place[tet] = PITH_NONE;
}

int lapped_coverage_weakest(const lapped_coverage *cover, uint32_t tet)
{
    int best = 0;
    for (int i = 1; i < LAPPED_SAMPLES; ++i)
        if (cover->alpha[tet][i] < cover->alpha[tet][best]) best = i;
    return best;
}

void lapped_coverage_force(lapped_coverage *cover, uint32_t tet, int sample)
{
    uint8_t *alpha = &cover->alpha[tet][sample];
    if (*alpha == 255) return;
    *alpha = 255;
    --cover->left[tet];
}
