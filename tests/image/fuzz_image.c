/* libFuzzer: any bytes as a picture. */
#include "pith/image.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size)
{
    pith_image *image = NULL;
    pith_error err;
    if (pith_image_decode("fuzz", bytes, size, &image, &err) == PITH_OK) pith_image_destroy(image);
    return 0;
}
