/* A shell as a mesh with normals and a colour per vertex. */
#include "bake_internal.h"

#include <string.h>

static const double crease_degrees = 40.0; /* sharper edges of skin or section keep two normals */

/* The mesh being made. A vertex of the surface becomes one vertex here, or with split borders one for each normal that
   its triangles have there; copies of a vertex are chained. */
typedef struct output {
    pith_vec3 *positions, *normals;
    float (*colours)[4];
    uint32_t (*triangles)[3];
    uint32_t *corner;           /* [vertex_count] 3 * triangle + corner of the surface as which the vertex is asked */
    uint32_t *next;             /* [vertex_count] another copy of the same vertex, or PITH_NONE */
    uint32_t vertex_count;
} output;

static void output_free(output *o)
{
    pith_free(o->positions);
    pith_free(o->normals);
    pith_free(o->colours);
    pith_free(o->triangles);
    pith_free(o->corner);
    pith_free(o->next);
}

static bool same(pith_vec3 a, pith_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* The copy of a surface vertex that serves this corner, made when there is none. Without splitting there is one copy,
   whose normal is the sum of its corners'. Equal normals are equal to the bit: the same sum in the same order. */
static uint32_t copy_for(output *o, uint32_t *first, uint32_t vertex, uint32_t corner, pith_vec3 normal, bool split)
{
    uint32_t *link = &first[vertex];
    while (*link != PITH_NONE && split && !same(o->normals[*link], normal)) link = &o->next[*link];
    if (*link == PITH_NONE) {
        *link = o->vertex_count++;
        o->next[*link] = PITH_NONE;
        o->corner[*link] = corner;
        o->normals[*link] = normal;
    } else if (!split) {
        o->normals[*link] = pith_add(o->normals[*link], normal);
    }
    return *link;
}

static pith_status number_vertices(const pith_shell_view *s, const pith_vec3 (*normals)[3], bool split, output *o,
                                   pith_error *err)
{
    const size_t most = split ? 3 * (size_t)s->triangle_count : s->vertex_count;
    if (most >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has more vertices than 32-bit indices can name");
    uint32_t *first = pith_alloc(s->vertex_count, sizeof *first);
    o->triangles = pith_alloc(s->triangle_count, sizeof *o->triangles);
    o->normals = pith_alloc(most, sizeof *o->normals);
    o->corner = pith_alloc(most, sizeof *o->corner);
    o->next = pith_alloc(most, sizeof *o->next);
    if (!first || !o->triangles || !o->normals || !o->corner || !o->next) {
        pith_free(first);
        return PITH_OUT_OF_MEMORY(err, "the baked mesh");
    }
    memset(first, 0xff, s->vertex_count * sizeof *first); /* PITH_NONE */
    for (uint32_t i = 0; i < s->triangle_count; ++i)
        for (uint32_t k = 0; k < 3; ++k)
            o->triangles[i][k] = copy_for(o, first, s->triangles[i][k], 3 * i + k, normals[i][k], split);
    pith_free(first);

    o->positions = pith_alloc(o->vertex_count, sizeof *o->positions);
    o->colours = pith_alloc(o->vertex_count, sizeof *o->colours);
    if (!o->positions || !o->colours) return PITH_OUT_OF_MEMORY(err, "the baked mesh");
    for (uint32_t i = 0; i < o->vertex_count; ++i) {
        o->positions[i] = s->positions[s->triangles[o->corner[i] / 3][o->corner[i] % 3]];
        if (!split) o->normals[i] = pith_unit(o->normals[i]);
    }
    return PITH_OK;
}

/* Divides the shell, and its normals with it. */
static pith_status divided_shell(const pith_shell *shell, double edge, uint32_t max_triangles, pith_shell **divided,
                                 pith_vec3 (**divided_normals)[3], pith_error *err)
{
    pith_vec3(*normals)[3] = pith_alloc(pith_shell_look(shell).triangle_count, sizeof *normals);
    if (!normals) return PITH_OUT_OF_MEMORY(err, "normals of the surface");
    pith_status status = pith_shell_normals(shell, crease_degrees, normals, err);
    if (status == PITH_OK)
        status = pith_shell_divide_normals(shell, (const pith_vec3(*)[3])normals, edge, max_triangles, divided,
                                           divided_normals, err);
    pith_free(normals);
    return status;
}

static void take_colours(void *user, size_t first, size_t count, const float *answers, uint32_t channels)
{
    output *o = user;
    for (size_t i = 0; i < count; ++i)
        memcpy(o->colours[first + i], answers + i * channels, sizeof o->colours[0]);
}

pith_status pith_bake_vertices(const pith_shell *shell, const pith_solid *solid, double edge, uint32_t max_triangles,
                               bool split_border, const pith_progress *progress, pith_mesh **mesh, pith_error *err)
{
    if (!shell || !solid || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_vertices: %s is NULL",
                         !shell ? "shell" : !solid ? "solid" : "mesh");
    pith_status status = PITH_OK;
    pith_shell *divided = NULL;
    pith_vec3(*normals)[3] = NULL;
    output o = { 0 };
    PITH_TRY_OR(done, pith_progress_step(progress, 0.0, "dividing triangles", err));
    PITH_TRY_OR(done, divided_shell(shell, edge, max_triangles, &divided, &normals, err));
    const pith_shell_view s = pith_shell_look(divided);
    PITH_TRY_OR(done, number_vertices(&s, (const pith_vec3(*)[3])normals, split_border, &o, err));
    const bake_corners corners = { divided, solid, o.corner, o.normals, o.vertex_count, (float)edge };
    PITH_TRY_OR(done, bake_ask_corners(&corners, progress, take_colours, &o, err));

    const pith_mesh_view view = { .positions = o.positions, .normals = o.normals,
                                  .colours = (const float (*)[4])o.colours,
                                  .triangles = (const uint32_t (*)[3])o.triangles, .vertex_count = o.vertex_count,
                                  .triangle_count = s.triangle_count };
    status = pith_mesh_create(&view, mesh, err);
done:
    pith_shell_destroy(divided);
    pith_free(normals);
    output_free(&o);
    return status;
}
