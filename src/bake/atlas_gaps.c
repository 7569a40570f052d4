/* What no chart needs is filled from what is near, coarser and coarser with the distance, so that the mip levels beyond
   those the margins are for mix a chart with its own colours first (pull and push; Gortler, Grzeszczuk, Szeliski and
   Cohen, "The Lumigraph", SIGGRAPH 1996, section 3.4). */
#include "atlas_internal.h"

#include <string.h>

enum { LEVELS = 16 };

typedef struct level {
    float (*texels)[4]; /* [height][width]; opacity below 0: nothing there */
    uint32_t width, height;
} level;

/* Each texel the mean of what there is of four. */
static void pull(const level *from, level *to)
{
    for (uint32_t y = 0; y < to->height; ++y)
        for (uint32_t x = 0; x < to->width; ++x) {
            float sum[4] = { 0.0f }, *out = to->texels[(size_t)y * to->width + x];
            int count = 0;
            for (uint32_t j = 2 * y; j < from->height && j < 2 * y + 2; ++j)
                for (uint32_t i = 2 * x; i < from->width && i < 2 * x + 2; ++i) {
                    const float *in = from->texels[(size_t)j * from->width + i];
                    if (!(in[3] >= 0.0f)) continue;
                    for (int c = 0; c < 4; ++c) sum[c] += in[c];
                    ++count;
                }
            for (int c = 0; c < 4; ++c) out[c] = count ? sum[c] / (float)count : -1.0f;
        }
}

/* What is missing from the level above. */
static void push(const level *from, level *to)
{
    for (uint32_t y = 0; y < to->height; ++y)
        for (uint32_t x = 0; x < to->width; ++x) {
            float *out = to->texels[(size_t)y * to->width + x];
            if (!(out[3] >= 0.0f)) memcpy(out, from->texels[(size_t)(y / 2) * from->width + x / 2], sizeof *to->texels);
        }
}

pith_status atlas_fill_gaps(pith_image *image, pith_error *err)
{
    level levels[LEVELS] = { { (float(*)[4])image->pixels, image->width, image->height } };
    int count = 1;
    bool made = true;
    for (; made && (levels[count - 1].width > 1 || levels[count - 1].height > 1); ++count) {
        const uint32_t width = (levels[count - 1].width + 1) / 2, height = (levels[count - 1].height + 1) / 2;
        levels[count] = (level){ pith_alloc((size_t)width * height, sizeof *levels[count].texels), width, height };
        made = levels[count].texels != NULL;
        if (made) pull(&levels[count - 1], &levels[count]);
    }
    for (int i = count - 1; i > 0; --i) {
        if (made) push(&levels[i], &levels[i - 1]);
        pith_free(levels[i].texels);
    }
    return made ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the atlas's mip levels");
}
