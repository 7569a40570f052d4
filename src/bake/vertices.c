/* A shell as a mesh with normals and a colour per vertex. */
#include "bake_internal.h"

#include <string.h>

/* The mesh being made. A vertex of the surface becomes one vertex here, or with split borders one for each normal that
   its triangles have there; copies of a vertex are chained. */
typedef struct output {
    pith_vec3 *positions, *normals;
    float (*colours)[4];
    uint32_t (*triangles)[3];
    uint32_t *parent;           /* [vertex_count] triangle of the shell in which the vertex is asked, */
    double (*at)[2];            /* [vertex_count] and where in it */
    uint32_t *surface_vertex;   /* [vertex_count] */
    uint32_t *next;             /* [vertex_count] another copy of the same vertex, or PITH_NONE */
    uint32_t vertex_count;
} output;

static void output_free(output *o)
{
    pith_free(o->positions);
    pith_free(o->normals);
    pith_free(o->colours);
    pith_free(o->triangles);
    pith_free(o->parent);
    pith_free(o->at);
    pith_free(o->surface_vertex);
    pith_free(o->next);
}

static bool same(pith_vec3 a, pith_vec3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

/* The copy of a surface vertex that serves this corner, made when there is none. Without splitting there is one copy,
   whose normal is the sum of its corners'. Equal normals are equal to the bit: the same sum in the same order. */
static uint32_t copy_for(output *o, uint32_t *first, const bake_triangle *t, int k, bool split)
{
    const bake_corner *corner = &t->corners[k];
    uint32_t *link = &first[t->vertices[k]];
    while (*link != PITH_NONE && split && !same(o->normals[*link], corner->normal)) link = &o->next[*link];
    if (*link == PITH_NONE) {
        *link = o->vertex_count++;
        o->next[*link] = PITH_NONE;
        o->surface_vertex[*link] = t->vertices[k];
        o->parent[*link] = t->parent;
        o->at[*link][0] = corner->u;
        o->at[*link][1] = corner->v;
        o->normals[*link] = corner->normal;
    } else if (!split) {
        o->normals[*link] = pith_add(o->normals[*link], corner->normal);
    }
    return *link;
}

static pith_status number_vertices(const bake_surface *s, bool split, output *o, pith_error *err)
{
    const size_t most = split ? 3 * s->triangle_count : s->vertex_count;
    if (most >= PITH_NONE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the surface has more vertices than 32-bit indices can name");
    uint32_t *first = pith_alloc(s->vertex_count, sizeof *first);
    o->triangles = pith_alloc(s->triangle_count, sizeof *o->triangles);
    o->normals = pith_alloc(most, sizeof *o->normals);
    o->parent = pith_alloc(most, sizeof *o->parent);
    o->at = pith_alloc(most, sizeof *o->at);
    o->surface_vertex = pith_alloc(most, sizeof *o->surface_vertex);
    o->next = pith_alloc(most, sizeof *o->next);
    if (!first || !o->triangles || !o->normals || !o->parent || !o->at || !o->surface_vertex || !o->next) {
        pith_free(first);
        return PITH_OUT_OF_MEMORY(err, "the baked mesh");
    }
    memset(first, 0xff, s->vertex_count * sizeof *first); /* PITH_NONE */
    for (size_t i = 0; i < s->triangle_count; ++i)
        for (int k = 0; k < 3; ++k) o->triangles[i][k] = copy_for(o, first, &s->triangles[i], k, split);
    pith_free(first);

    o->positions = pith_alloc(o->vertex_count, sizeof *o->positions);
    o->colours = pith_alloc(o->vertex_count, sizeof *o->colours);
    if (!o->positions || !o->colours) return PITH_OUT_OF_MEMORY(err, "the baked mesh");
    for (uint32_t i = 0; i < o->vertex_count; ++i) {
        o->positions[i] = s->positions[o->surface_vertex[i]];
        if (!split) o->normals[i] = pith_unit(o->normals[i]);
    }
    return PITH_OK;
}

/* What a stretch of questions needs. */
enum { STRETCH = 65536 };
typedef struct questions {
    pith_vec3 *points;
    float *footprints, *answers;
    uint32_t *tets;
    double (*weights)[4];
} questions;

static void questions_free(questions *q)
{
    pith_free(q->points);
    pith_free(q->footprints);
    pith_free(q->answers);
    pith_free(q->tets);
    pith_free(q->weights);
}

static pith_status questions_make(questions *q, uint32_t channels, pith_error *err)
{
    q->points = pith_alloc(STRETCH, sizeof *q->points);
    q->footprints = pith_alloc(STRETCH, sizeof *q->footprints);
    q->answers = pith_alloc((size_t)STRETCH * channels, sizeof *q->answers);
    q->tets = pith_alloc(STRETCH, sizeof *q->tets);
    q->weights = pith_alloc(STRETCH, sizeof *q->weights);
    if (q->points && q->footprints && q->answers && q->tets && q->weights) return PITH_OK;
    return PITH_OUT_OF_MEMORY(err, "questions to the solid");
}

static pith_status ask_colours(const pith_shell *shell, const pith_solid *solid, const bake_surface *s, double edge,
                               output *o, const pith_progress *progress, pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    const uint32_t channels = pith_solid_channels(solid);
    pith_status status = PITH_OK;
    questions q = { 0 };
    double (*corner_weights)[3][4] = pith_alloc(view.triangle_count, sizeof *corner_weights);
    if (!corner_weights) {
        status = PITH_OUT_OF_MEMORY(err, "where the surface lies in its tets");
        goto done;
    }
    PITH_TRY_OR(done, questions_make(&q, channels, err));
    pith_shell_weights(shell, corner_weights);

    for (uint32_t first = 0; first < o->vertex_count; first += STRETCH) {
        const uint32_t rest = o->vertex_count - first, count = rest < STRETCH ? rest : STRETCH;
        PITH_TRY_OR(done, pith_progress_step(progress, 0.3 + 0.7 * first / o->vertex_count, "asking for colours", err));
        for (uint32_t i = 0; i < count; ++i) {
            const uint32_t vertex = first + i, parent = o->parent[vertex];
            const double u = o->at[vertex][0], v = o->at[vertex][1];
            q.points[i] = s->material[o->surface_vertex[vertex]];
            q.footprints[i] = (float)edge;
            q.tets[i] = view.source_tet[parent];
            for (int k = 0; k < 4; ++k)
                q.weights[i][k] = (1.0 - u - v) * corner_weights[parent][0][k] + u * corner_weights[parent][1][k] +
                                  v * corner_weights[parent][2][k];
        }
        const pith_query query = { .points = q.points, .normals = o->normals + first, .footprints = q.footprints,
                                   .tets = q.tets, .weights = (const double (*)[4])q.weights, .count = count };
        PITH_TRY_OR(done, pith_solid_sample(solid, &query, q.answers, err));
        for (uint32_t i = 0; i < count; ++i)
            memcpy(o->colours[first + i], q.answers + (size_t)i * channels, sizeof o->colours[0]);
    }
done:
    pith_free(corner_weights);
    questions_free(&q);
    return status;
}

pith_status pith_bake_vertices(const pith_shell *shell, const pith_solid *solid, double edge, uint32_t max_triangles,
                               bool split_border, const pith_progress *progress, pith_mesh **mesh, pith_error *err)
{
    if (!shell || !solid || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_vertices: %s is NULL",
                         !shell ? "shell" : !solid ? "solid" : "mesh");
    if (!(edge >= 0.0) || !isfinite(edge))
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "edge is %g model units, expected a length, or 0 to leave the triangles as they are", edge);
    pith_status status = PITH_OK;
    bake_surface surface = { 0 };
    output o = { 0 };
    PITH_TRY_OR(done, bake_surface_make(shell, &surface, err));
    PITH_TRY_OR(done, bake_surface_refine(&surface, edge, max_triangles, progress, err));
    PITH_TRY_OR(done, number_vertices(&surface, split_border, &o, err));
    PITH_TRY_OR(done, ask_colours(shell, solid, &surface, edge, &o, progress, err));

    const pith_mesh_view view = { .positions = o.positions, .normals = o.normals,
                                  .colours = (const float (*)[4])o.colours,
                                  .triangles = (const uint32_t (*)[3])o.triangles, .vertex_count = o.vertex_count,
                                  .triangle_count = (uint32_t)surface.triangle_count };
    status = pith_mesh_create(&view, mesh, err);
done:
    bake_surface_free(&surface);
    output_free(&o);
    return status;
}
