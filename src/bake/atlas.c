/* Texture atlases of shells: the steps one after the other, the mesh with its seams, and what is said of the result.

   Source: Peachey, "Solid texturing of complex surfaces", SIGGRAPH 1985, section 5 ("patch texture functions"). */
#include "atlas_internal.h"

#include <string.h>

#define OPTION(field) offsetof(pith_atlas_options, field)

static const pith_param atlas_items[] = {
    { "density", "texels per model unit", "everywhere on the surface at least so many; more shows finer detail",
      PITH_PARAM_DOUBLE, 1e-6, 100, 1e9, OPTION(density), NULL },
    { "stretch", "1", "and nowhere more than this many times as many; more gives fewer seams and a larger atlas",
      PITH_PARAM_DOUBLE, 1.05, 1.3, 2, OPTION(stretch), NULL },
    { "margin", "texels", "filled round every chart; more keeps more mip levels free of what lies beside",
      PITH_PARAM_UINT, 1, 4, 64, OPTION(margin), NULL },
    { "samples", "1", "the solid is asked this many times along either side of a texel; more is smoother and slower",
      PITH_PARAM_UINT, 1, 2, 8, OPTION(samples), NULL },
    { "max_size", "texels", "longest side of the atlas; when more would be needed the call is refused", PITH_PARAM_UINT,
      16, 8192, 16384, OPTION(max_size), NULL },
    { "roughness", "1", "of the material: 0 mirrors, 1 is chalk", PITH_PARAM_DOUBLE, 0, 0.6, 1, OPTION(roughness),
      NULL },
};

const pith_params pith_atlas_params = { "atlas", atlas_items, sizeof atlas_items / sizeof *atlas_items,
                                        sizeof(pith_atlas_options) };

pith_atlas_options pith_atlas_options_default(void)
{
    pith_atlas_options options;
    pith_params_defaults(&pith_atlas_params, &options);
    return options;
}

void pith_textured_destroy(pith_textured *textured)
{
    if (!textured) return;
    pith_mesh_destroy(textured->mesh);
    pith_image_destroy(textured->texture);
    pith_free(textured->charts);
    pith_free(textured);
}

/* ---- layout ------------------------------------------------------------------------------------------------------ */

void atlas_free(atlas *a)
{
    atlas_surface_free(&a->surface);
    pith_free(a->chart_of);
    pith_free(a->order);
    pith_free(a->places);
    pith_free(a->charts);
}

static pith_status atlas_begin(const pith_atlas_item *items, size_t count, atlas *a, pith_error *err)
{
    PITH_TRY(atlas_surface_make(items, count, &a->surface, err));
    a->chart_of = pith_alloc(a->surface.triangle_count, sizeof *a->chart_of);
    a->order = pith_alloc(a->surface.triangle_count, sizeof *a->order);
    a->places = pith_alloc(a->surface.triangle_count, sizeof *a->places);
    return a->chart_of && a->order && a->places ? PITH_OK : PITH_OUT_OF_MEMORY(err, "the atlas");
}

/* Charts and their places; triangles that would lie over others are taken out and make charts of their own, until none
   does: the first of a chart always stays. */
static pith_status lay_out(atlas *a, bool *fits, pith_error *err)
{
    a->chart_count = 0;
    PITH_TRY(atlas_make_charts(a, err));
    for (uint32_t removed = 1; removed > 0;) {
        PITH_TRY(atlas_flatten(a, fits, err));
        if (!*fits) return PITH_OK;
        PITH_TRY(atlas_part_overlaps(a, &removed, err));
        if (removed > 0) PITH_TRY(atlas_chart_rest(a, err));
    }
    return atlas_pack(a, fits, err);
}

/* Two digits, rounded down. */
static double round_down(double value)
{
    const double unit = pow(10.0, floor(log10(value)) - 1.0);
    return floor(value / unit * (1.0 + 1e-12)) * unit;
}

/* Says which density would do, having tried. */
static pith_status refuse_size(atlas *a, pith_error *err)
{
    const pith_atlas_options asked = *a->options;
    pith_atlas_options tried = asked;
    double area = 0.0;
    for (uint32_t t = 0; t < a->surface.triangle_count; ++t) area += a->surface.areas[t];
    a->options = &tried;
    /* A full atlas of nothing but charts first, then less and less. */
    double density = fmin(0.95 * asked.density, asked.max_size / sqrt(fmax(area, 1e-300)));
    bool fits = false;
    for (int i = 0; i < 40 && !fits && density > 0.0; ++i, density *= 0.85) {
        tried.density = round_down(density);
        PITH_TRY(lay_out(a, &fits, err));
    }
    if (!fits)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "the %zu charts of the surface do not fit into %u x %u texels at any density; allow a larger "
                         "max_size, a smaller margin than %u or more stretch than %g",
                         a->chart_count, (unsigned)asked.max_size, (unsigned)asked.max_size, (unsigned)asked.margin,
                         asked.stretch);
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "%g texels per model unit need an atlas larger than the %u x %u that max_size allows; %g would do",
                     asked.density, (unsigned)asked.max_size, (unsigned)asked.max_size, tried.density);
}

/* ---- report ------------------------------------------------------------------------------------------------------ */

/* Texels per model unit of a triangle in the directions where they are fewest and most: the singular values of the map
   from its plane to the atlas. */
static void densities(const atlas *a, uint32_t triangle, double *least, double *most)
{
    const atlas_surface *s = &a->surface;
    const uint32_t *v = s->triangles[triangle];
    const pith_vec3 e = pith_sub(s->positions[v[1]], s->positions[v[0]]),
                    f = pith_sub(s->positions[v[2]], s->positions[v[0]]);
    const pith_vec3 x = pith_unit(e), y = pith_cross(s->facets[triangle], x);
    const double ex = pith_dot(e, x), fx = pith_dot(f, x), fy = pith_dot(f, y);
    const double(*p)[2] = (const double(*)[2])a->places[triangle];
    double column[2][2]; /* images of x and y */
    for (int d = 0; d < 2; ++d) {
        column[0][d] = (p[1][d] - p[0][d]) / ex;
        column[1][d] = (p[2][d] - p[0][d] - column[0][d] * fx) / fy;
    }
    const double xx = column[0][0] * column[0][0] + column[0][1] * column[0][1];
    const double yy = column[1][0] * column[1][0] + column[1][1] * column[1][1];
    const double xy = column[0][0] * column[1][0] + column[0][1] * column[1][1];
    const double middle = 0.5 * (xx + yy), apart = sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
    *most = sqrt(middle + apart);
    *least = fabs(column[0][0] * column[1][1] - column[0][1] * column[1][0]) / *most; /* without cancellation */
}

static void measure(const atlas *a, pith_atlas_report *report)
{
    double area = 0.0, texels = 0.0;
    report->least_density = INFINITY;
    for (uint32_t t = 0; t < a->surface.triangle_count; ++t) {
        if (!(pith_dot(a->surface.facets[t], a->surface.facets[t]) > 0.0)) continue;
        double least, most;
        densities(a, t, &least, &most);
        report->least_density = fmin(report->least_density, least);
        report->most_density = fmax(report->most_density, most);
        area += a->surface.areas[t];
        texels += 0.5 * atlas_cross(a->places[t][0], a->places[t][1], a->places[t][2]);
    }
    report->charts = (uint32_t)a->chart_count;
    report->width = a->width;
    report->height = a->height;
    report->mean_density = sqrt(texels / area);
    report->covered = texels / ((double)a->width * a->height);
}

/* ---- mesh -------------------------------------------------------------------------------------------------------- */

/* The mesh being made: a vertex of the surface becomes one for each chart and normal its triangles have there; the copies
   of a vertex are chained. */
typedef struct seams {
    uint32_t (*triangles)[3];
    uint32_t *first, *next;         /* [vertex_count] of the surface; of the copies: another copy, or PITH_NONE */
    uint32_t *corner;               /* of the copies: 3 * triangle + corner of the surface */
    pith_vec3 *positions, *normals; /* of the copies */
    float (*texcoords)[2];
    uint32_t count;
} seams;

static void seams_free(seams *m)
{
    pith_free(m->triangles);
    pith_free(m->first);
    pith_free(m->next);
    pith_free(m->corner);
    pith_free(m->positions);
    pith_free(m->normals);
    pith_free(m->texcoords);
}

/* Equal normals are equal to the bit: the same sum in the same order. */
static bool same_vertex(const atlas *a, uint32_t corner, uint32_t other)
{
    const pith_vec3 n = a->surface.normals[corner / 3][corner % 3], o = a->surface.normals[other / 3][other % 3];
    return a->chart_of[corner / 3] == a->chart_of[other / 3] && n.x == o.x && n.y == o.y && n.z == o.z;
}

static void number_copies(const atlas *a, seams *m)
{
    memset(m->first, 0xff, a->surface.vertex_count * sizeof *m->first); /* PITH_NONE */
    for (uint32_t c = 0; c < 3 * a->surface.triangle_count; ++c) {
        uint32_t *link = &m->first[a->surface.triangles[c / 3][c % 3]];
        while (*link != PITH_NONE && !same_vertex(a, c, m->corner[*link])) link = &m->next[*link];
        if (*link == PITH_NONE) {
            *link = m->count;
            m->next[m->count] = PITH_NONE;
            m->corner[m->count++] = c;
        }
        m->triangles[c / 3][c % 3] = *link;
    }
}

static pith_status make_mesh(const atlas *a, pith_mesh **mesh, pith_error *err)
{
    const size_t corners = 3 * (size_t)a->surface.triangle_count;
    seams m = { .triangles = pith_alloc(a->surface.triangle_count, sizeof *m.triangles),
                .first = pith_alloc(a->surface.vertex_count, sizeof *m.first),
                .next = pith_alloc(corners, sizeof *m.next),
                .corner = pith_alloc(corners, sizeof *m.corner) };
    pith_status status = PITH_OUT_OF_MEMORY(err, "the mesh of the atlas");
    if (!m.triangles || !m.first || !m.next || !m.corner) goto done;
    number_copies(a, &m);
    m.positions = pith_alloc(m.count, sizeof *m.positions);
    m.normals = pith_alloc(m.count, sizeof *m.normals);
    m.texcoords = pith_alloc(m.count, sizeof *m.texcoords);
    if (!m.positions || !m.normals || !m.texcoords) goto done;
    for (uint32_t i = 0; i < m.count; ++i) {
        const uint32_t triangle = m.corner[i] / 3, k = m.corner[i] % 3;
        m.positions[i] = a->surface.positions[a->surface.triangles[triangle][k]];
        m.normals[i] = a->surface.normals[triangle][k];
        m.texcoords[i][0] = (float)(a->places[triangle][k][0] / a->width);
        m.texcoords[i][1] = (float)(a->places[triangle][k][1] / a->height);
    }
    const pith_mesh_view view = { .positions = m.positions,
                                  .normals = m.normals,
                                  .texcoords = (const float(*)[2])m.texcoords,
                                  .triangles = (const uint32_t(*)[3])m.triangles,
                                  .vertex_count = m.count,
                                  .triangle_count = a->surface.triangle_count };
    status = pith_mesh_create(&view, mesh, err);
done:
    seams_free(&m);
    return status;
}

/* ---- picture ----------------------------------------------------------------------------------------------------- */

static bool opaque(const pith_image *image)
{
    const size_t texels = (size_t)image->width * image->height;
    for (size_t i = 0; i < texels; ++i)
        if (image->pixels[4 * i + 3] < 1.0f - 1e-6f) return false;
    return true;
}

/* Leaves opacity out of a picture that does not need it. */
static void drop_opacity(pith_image *image)
{
    const size_t texels = (size_t)image->width * image->height;
    for (size_t i = 0; i < texels; ++i) memmove(image->pixels + 3 * i, image->pixels + 4 * i, 3 * sizeof(float));
    image->channels = 3;
}

/* ---- all of it --------------------------------------------------------------------------------------------------- */

static pith_status check_items(const pith_atlas_item *items, size_t count, const pith_atlas_options *options,
                               pith_textured *const *textured, pith_error *err)
{
    if (!items || !options || !textured)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_atlas: %s is NULL",
                         !items     ? "items"
                         : !options ? "options"
                                    : "textured");
    for (size_t i = 0; i < count; ++i)
        if (!items[i].shell || !items[i].solid || !pith_finite(items[i].offset))
            return pith_fail(err, PITH_BAD_ARGUMENT, "pith_bake_atlas: %s of item %zu is %s",
                             !items[i].shell   ? "shell"
                             : !items[i].solid ? "solid"
                                               : "offset",
                             i, !items[i].shell || !items[i].solid ? "NULL" : "not finite");
    return pith_params_check(&pith_atlas_params, options, err);
}

pith_status pith_bake_atlas(const pith_atlas_item *items, size_t count, const pith_atlas_options *options,
                            const pith_progress *progress, pith_textured **textured, pith_atlas_report *report,
                            pith_error *err)
{
    PITH_TRY(check_items(items, count, options, textured, err));
    pith_status status = PITH_OK;
    atlas a = { .options = options };
    pith_atlas_report told = { 0 };
    bool fits = false;
    const double start = pith_seconds();
    pith_textured *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "the atlas");
    made->roughness = options->roughness;

    /* Where everything lies. */
    PITH_TRY_OR(failed, pith_progress_step(progress, 0.0, "laying out charts", err));
    PITH_TRY_OR(failed, atlas_begin(items, count, &a, err));
    PITH_TRY_OR(failed, lay_out(&a, &fits, err));
    if (!fits) {
        status = refuse_size(&a, err);
        goto failed;
    }
    measure(&a, &told);
    PITH_TRY_OR(failed, make_mesh(&a, &made->mesh, err));
    told.layout_seconds = pith_seconds() - start;

    /* What is there. */
    PITH_TRY_OR(failed, pith_image_create(a.width, a.height, 4, &made->texture, err));
    PITH_TRY_OR(failed, atlas_fill(&a, progress, made->texture, &told, err));
    if (opaque(made->texture)) drop_opacity(made->texture);
    told.ask_seconds = pith_seconds() - start - told.layout_seconds;

    made->charts = a.chart_of;
    a.chart_of = NULL;
    atlas_free(&a);
    *textured = made;
    if (report) *report = told;
    return PITH_OK;
failed:
    atlas_free(&a);
    pith_textured_destroy(made);
    return status;
}

pith_status pith_textured_write(const pith_textured *textured, const char *path, pith_error *err)
{
    if (!textured || !path)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_textured_write: %s is NULL", textured ? "path" : "textured");
    unsigned char *png = NULL;
    size_t size = 0;
    PITH_TRY(pith_image_encode_png(textured->texture, &png, &size, err));
    const pith_texture texture = { png, size, textured->roughness, textured->texture->channels == 4 };
    const pith_status status = pith_mesh_write_textured(textured->mesh, &texture, path, err);
    pith_free(png);
    return status;
}
