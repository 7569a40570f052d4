/* What the patterns share: their input, and places in what repeats. */
#include "patterns.h"

const pith_input pattern_inputs[2] = {
    { "at", "where to look the pattern up; without it the position asked for", PITH_VALUE_POINT, false, false, false,
      0 },
    { 0 },
};

/* Double for the reduction: at 10^4 periods from the origin a float product is off by a thousandth of a period. */
INLINE void places(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit)
{
    const uint32_t whole = whole_lanes(count);
    if (wrap)
        for (uint32_t i = 0; i < whole; ++i) {
            double place = ((double)x[i] - origin) * inverse;
            place -= floor(place);
            const float near = (float)place;
            unit[i] = near < 1.0f ? near : 0.0f; /* rounded up to 1, and NaN */
        }
    else
        for (uint32_t i = 0; i < whole; ++i) unit[i] = (float)(((double)x[i] - origin) * inverse);
}

WIDE static void unit_places_wide(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit)
{
    places(x, count, origin, inverse, wrap, unit);
}

void unit_places_plain(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit)
{
    places(x, count, origin, inverse, wrap, unit);
}

void unit_places(const float *x, uint32_t count, double origin, double inverse, bool wrap, float *unit)
{
    if (machine_is_wide())
        unit_places_wide(x, count, origin, inverse, wrap, unit);
    else
        unit_places_plain(x, count, origin, inverse, wrap, unit);
}
