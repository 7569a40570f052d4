/* Displacement mapping: a shell whose skin is moved by a channel of its solid.

   Source: Takayama et al. 2008, section 6. */
#include "bake_internal.h"

#include <string.h>

#define OPTION(field) offsetof(pith_displacement_options, field)

static const pith_param displacement_items[] = {
    { "channel", "1", "channel of the solid that says how far, counted from 0; 4 is the first beyond colour, opacity",
      PITH_PARAM_UINT, 0, 4, 63, OPTION(channel), NULL },
    { "amount", "model units", "how far the skin moves out when the channel is 1 above the middle; below 0: inwards",
      PITH_PARAM_DOUBLE, -1e9, 1, 1e9, OPTION(amount), NULL },
    { "middle", "1", "value of the channel at which the skin stays; more of it moves everything inwards",
      PITH_PARAM_DOUBLE, -1e6, 0, 1e6, OPTION(middle), NULL },
    { "edge", "model units", "longest edge after dividing; longer ones are quicker and lose detail, 0 divides nothing",
      PITH_PARAM_DOUBLE, 0, 0.02, 1e9, OPTION(edge), NULL },
    { "max_triangles", "1", "triangles after dividing; when more would be needed the call is refused", PITH_PARAM_UINT,
      4, 4000000, 100000000, OPTION(max_triangles), NULL },
};

const pith_params pith_displacement_params = { "displacement", displacement_items,
                                               sizeof displacement_items / sizeof *displacement_items,
                                               sizeof(pith_displacement_options) };

pith_displacement_options pith_displacement_options_default(void)
{
    pith_displacement_options options;
    pith_params_defaults(&pith_displacement_params, &options);
    return options;
}

/* The vertices of the skin, each once. */
typedef struct skin {
    const pith_displacement_options *options;
    uint32_t *corners, *vertices;   /* [count] a corner of the skin at the vertex, and the vertex */
    pith_vec3 *normals;             /* [count] unit */
    double *amounts;                /* [vertex_count] of the shell; the result */
    uint32_t count;
} skin;

static void skin_free(skin *s)
{
    pith_free(s->corners);
    pith_free(s->vertices);
    pith_free(s->normals);
    pith_free(s->amounts);
}

static pith_status skin_make(const pith_shell_view *view, const pith_vec3 (*normals)[3], skin *s, pith_error *err)
{
    bool *known = pith_alloc(view->vertex_count, sizeof *known);
    s->corners = pith_alloc(view->vertex_count, sizeof *s->corners);
    s->vertices = pith_alloc(view->vertex_count, sizeof *s->vertices);
    s->normals = pith_alloc(view->vertex_count, sizeof *s->normals);
    s->amounts = pith_alloc(view->vertex_count, sizeof *s->amounts);
    if (!known || !s->corners || !s->vertices || !s->normals || !s->amounts) {
        pith_free(known);
        return PITH_OUT_OF_MEMORY(err, "the skin's vertices");
    }
    for (uint32_t i = 0; i < view->triangle_count; ++i)
        for (uint32_t k = 0; k < 3 && view->kinds[i] == PITH_SKIN; ++k) {
            const uint32_t v = view->triangles[i][k];
            if (known[v]) continue;
            known[v] = true;
            s->corners[s->count] = 3 * i + k;
            s->vertices[s->count] = v;
            s->normals[s->count++] = normals[i][k];
        }
    pith_free(known);
    return PITH_OK;
}

static void take_amounts(void *user, size_t first, size_t count, const float *answers, uint32_t channels)
{
    skin *s = user;
    for (size_t i = 0; i < count; ++i)
        s->amounts[s->vertices[first + i]] =
            s->options->amount * ((double)answers[i * channels + s->options->channel] - s->options->middle);
}

static pith_status check_displacement(const pith_shell *shell, const pith_solid *solid,
                                      const pith_displacement_options *options, pith_shell **displaced,
                                      pith_error *err)
{
    if (!shell || !solid || !options || !displaced)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_displaced: %s is NULL",
                         !shell ? "shell" : !solid ? "solid" : !options ? "options" : "displaced");
    PITH_TRY(pith_params_check(&pith_displacement_params, options, err));
    const uint32_t channels = pith_solid_channels(solid);
    if (options->channel >= channels)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "displacement by channel %u, but the solid has channels 0 to %u; fill it with an exemplar "
                         "that has a displacement channel, or name another one",
                         (unsigned)options->channel, (unsigned)(channels - 1));
    return PITH_OK;
}

pith_status pith_bake_displaced(const pith_shell *shell, const pith_solid *solid,
                                const pith_displacement_options *options, pith_shell **displaced, pith_error *err)
{
    PITH_TRY(check_displacement(shell, solid, options, displaced, err));
    pith_status status = PITH_OK;
    pith_shell *divided = NULL;
    pith_vec3(*normals)[3] = NULL;
    skin s = { .options = options };
    PITH_TRY_OR(done, pith_shell_divide(shell, options->edge, options->max_triangles, &divided, err));
    const pith_shell_view view = pith_shell_look(divided);
    normals = pith_alloc(view.triangle_count, sizeof *normals);
    if (!normals) {
        status = PITH_OUT_OF_MEMORY(err, "normals of the skin");
        goto done;
    }
    PITH_TRY_OR(done, pith_shell_normals(divided, 180.0, normals, err));
    PITH_TRY_OR(done, skin_make(&view, (const pith_vec3(*)[3])normals, &s, err));
    const bake_corners corners = { divided, solid, s.corners, s.normals, s.count, (float)options->edge };
    PITH_TRY_OR(done, bake_ask_corners(&corners, NULL, take_amounts, &s, err));
    status = pith_shell_displace(divided, s.amounts, displaced, err);
done:
    pith_shell_destroy(divided);
    pith_free(normals);
    skin_free(&s);
    return status;
}
