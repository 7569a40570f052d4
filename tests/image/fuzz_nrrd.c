/* libFuzzer: any bytes as an NRRD volume; what is read is also sampled. */
#include "pith/image.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    pith_grid *grid = NULL;
    pith_error err;
    if (pith_grid_parse_nrrd("fuzz", bytes, size, size & 1, &grid, &err) == PITH_OK) {
        static const pith_grid_wrap wrap[3] = { PITH_WRAP_REPEAT, PITH_WRAP_CLAMP, PITH_WRAP_REPEAT };
        const double at[3] = { 0.25 * grid->size[0], grid->size[1], -1.0 };
        float values[64];
        pith_grid_sample(grid, at, wrap, values);
        pith_grid_destroy(grid);
    }
    return 0;
}
