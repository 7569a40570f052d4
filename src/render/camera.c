/* Cameras: the frame rays are made in, and where the light stands in it. */
#include "render_internal.h"

/* Unit axes of a camera that looks along `forward`; up is bent where it must be. */
static void camera_axes(pith_vec3 forward, pith_vec3 up, pith_vec3 *right, pith_vec3 *above)
{
    pith_vec3 side = pith_cross(forward, pith_unit(up));
    if (!(pith_length(side) > 1e-9)) side = pith_perpendicular(forward);
    *right = pith_unit(side);
    *above = pith_cross(*right, forward);
}

static pith_vec3 box_corner(const pith_box *box, int i)
{
    return pith_v3(i & 1 ? box->high.x : box->low.x, i & 2 ? box->high.y : box->low.y,
                   i & 4 ? box->high.z : box->low.z);
}

pith_camera pith_camera_fit(const pith_box *box, pith_vec3 direction, pith_vec3 up, double field_of_view, double aspect)
{
    const double margin = 1.12; /* a picture wants air round its subject */
    const pith_vec3 middle = pith_scale(pith_add(box->low, box->high), 0.5);
    pith_vec3 back = pith_unit(direction), right, above;
    if (!(pith_dot(back, back) > 0.0)) back = pith_v3(0, -1, 0);
    camera_axes(pith_scale(back, -1.0), up, &right, &above);

    const double tall = tan(0.5 * field_of_view * (M_PI / 180.0)), wide = tall * aspect;
    double distance = 0.0;
    for (int i = 0; i < 8; ++i) {
        const pith_vec3 d = pith_sub(box_corner(box, i), middle);
        const double needs = fmax(fabs(pith_dot(d, right)) / wide, fabs(pith_dot(d, above)) / tall);
        distance = fmax(distance, margin * needs + pith_dot(d, back));
    }
    if (!(distance > 0.0)) distance = 1.0; /* a point, or nothing: look at it from somewhere */
    return (pith_camera){ pith_madd(middle, back, distance), middle, up, field_of_view };
}

bool pith_camera_sees(const pith_camera *camera, const pith_box *box, double aspect)
{
    const pith_vec3 forward = pith_unit(pith_sub(camera->target, camera->eye));
    pith_vec3 right, above;
    camera_axes(forward, camera->up, &right, &above);
    const double tall = tan(0.5 * camera->field_of_view * (M_PI / 180.0)), wide = tall * aspect;
    int behind = 0, beyond[4] = { 0 };
    for (int i = 0; i < 8; ++i) {
        const pith_vec3 d = pith_sub(box_corner(box, i), camera->eye);
        const double depth = pith_dot(d, forward), x = pith_dot(d, right), y = pith_dot(d, above);
        behind += !(depth > 0.0);
        beyond[0] += x<-wide * depth, beyond[1] += x> wide * depth;
        beyond[2] += y<-tall * depth, beyond[3] += y> tall * depth;
    }
    return behind < 8 && beyond[0] < 8 && beyond[1] < 8 && beyond[2] < 8 && beyond[3] < 8;
}

pith_status render_view_make(render_view *view, const pith_camera *camera, uint32_t height, const double light[2],
                             pith_error *err)
{
    const pith_vec3 toward = pith_sub(camera->target, camera->eye);
    if (!pith_finite(camera->eye) || !pith_finite(toward) || !(pith_length(toward) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the camera at (%g, %g, %g) looks at (%g, %g, %g): give two different, finite points",
                         camera->eye.x, camera->eye.y, camera->eye.z, camera->target.x, camera->target.y,
                         camera->target.z);
    if (!pith_finite(camera->up) || !(pith_length(camera->up) > 0.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the camera's up is (%g, %g, %g), expected a direction", camera->up.x,
                         camera->up.y, camera->up.z);
    if (!(camera->field_of_view >= 0.1 && camera->field_of_view <= 170.0))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the camera's field of view is %g degrees, expected 0.1 to 170",
                         camera->field_of_view);
    view->eye = camera->eye;
    view->forward = pith_unit(toward);
    view->sky = pith_unit(camera->up);
    camera_axes(view->forward, camera->up, &view->right, &view->up);

    /* The light turns with the camera: azimuth 0 lies over the photographer's shoulder. */
    const double azimuth = light[0] * (M_PI / 180.0), elevation = light[1] * (M_PI / 180.0);
    const pith_vec3 front = pith_cross(view->right, view->sky); /* level, from the target to the camera's side */
    const pith_vec3 level = pith_madd(pith_scale(front, cos(azimuth)), view->right, sin(azimuth));
    view->light = pith_unit(pith_madd(pith_scale(level, cos(elevation)), view->sky, sin(elevation)));

    const double pixel = 2.0 * tan(0.5 * camera->field_of_view * (M_PI / 180.0)) / height;
    view->right = pith_scale(view->right, pixel);
    view->up = pith_scale(view->up, pixel);
    return PITH_OK;
}
