/* The sRGB transfer function, which every reader and writer of colours meets. In double, because the two branches
   must meet where the standard says they do. */
#include "pith/base.h"

static double clamp_unit(double value) { return value > 0.0 ? (value < 1.0 ? value : 1.0) : 0.0; } /* NaN becomes 0 */

float pith_srgb_decode(double encoded)
{
    const double v = clamp_unit(encoded);
    return (float)(v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4));
}

float pith_srgb_encode(double linear)
{
    const double v = clamp_unit(linear);
    return (float)(v <= 0.0031308 ? v * 12.92 : 1.055 * pow(v, 1.0 / 2.4) - 0.055);
}
