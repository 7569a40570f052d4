/* The list of functions: a new one is a line here. */
#include <string.h>

#include "node.h"

static const pith_function *const all[] = {
    &node_position.shown,  &node_normal.shown,    &node_view.shown,      &node_light.shown,      &node_direction.shown,
    &node_place.shown,     &node_transform.shown, &node_warp.shown,      &node_repeat.shown, &node_flatten.shown,     &node_point.shown,
    &node_noise.shown,     &node_slope.shown,     &node_fractal.shown,   &node_turbulence.shown, &node_cellular.shown,
    &node_phasor.shown,    &node_rings.shown,     &node_checks.shown,    &node_bombs.shown,      &node_waves.shown,
    &node_veins.shown,     &node_table.shown,     &node_project.shown,   &node_number.shown,     &node_colour.shown,
    &node_component.shown, &node_dot.shown,       &node_luminance.shown, &node_combine.shown,    &node_mix.shown,
    &node_curve.shown,     &node_map.shown,
};

const pith_function *const *pith_functions(size_t *count)
{
    *count = sizeof all / sizeof *all;
    return all;
}

const pith_function *pith_function_find(const char *name)
{
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        if (strcmp(all[i]->name, name) == 0) return all[i];
    return NULL;
}
