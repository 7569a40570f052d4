/* The sRGB transfer function, which every reader and writer of colours meets, in double, because the two branches must
   meet where the standard says they do; and Oklab, for whoever compares colours as people do. */
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

static void multiply(const double matrix[3][3], const double from[3], double to[3])
{
    for (int i = 0; i < 3; ++i) to[i] = matrix[i][0] * from[0] + matrix[i][1] * from[1] + matrix[i][2] * from[2];
}

void pith_oklab_from_rgb(const double rgb[3], double lab[3])
{
    static const double to_cones[3][3] = { { 0.4122214708, 0.5363325363, 0.0514459929 },
                                           { 0.2119034982, 0.6806995451, 0.1073969566 },
                                           { 0.0883024619, 0.2817188376, 0.6299787005 } };
    static const double to_lab[3][3] = { { 0.2104542553, 0.7936177850, -0.0040720468 },
                                         { 1.9779984951, -2.4285922050, 0.4505937099 },
                                         { 0.0259040371, 0.7827717662, -0.8086757660 } };
    double cones[3];
    multiply(to_cones, rgb, cones);
    for (int i = 0; i < 3; ++i) cones[i] = cbrt(cones[i]);
    multiply(to_lab, cones, lab);
}

void pith_oklab_to_rgb(const double lab[3], double rgb[3])
{
    static const double to_cones[3][3] = { { 1.0, 0.3963377774, 0.2158037573 },
                                           { 1.0, -0.1055613458, -0.0638541728 },
                                           { 1.0, -0.0894841775, -1.2914855480 } };
    static const double to_rgb[3][3] = { { 4.0767416621, -3.3077115913, 0.2309699292 },
                                         { -1.2684380046, 2.6097574011, -0.3413193965 },
                                         { -0.0041960863, -0.7034186147, 1.7076147010 } };
    double cones[3];
    multiply(to_cones, lab, cones);
    for (int i = 0; i < 3; ++i) cones[i] = cones[i] * cones[i] * cones[i];
    multiply(to_rgb, cones, rgb);
}
