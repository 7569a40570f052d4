/* Sections as meshes: options, the steps from a cutting surface to a mesh with colours, and pictures to compare with. */
#include "section_internal.h"

#include <string.h>

#define AT(field) offsetof(pith_diffusion_section_options, field)

static const pith_param items[] = {
    { "edge", "extents", "longest edge; less finds smaller details between the surfaces", PITH_PARAM_DOUBLE, 1e-4, 0.06,
      1.0, AT(edge), NULL },
    { "shortest", "extents", "edges shorter than twice this are not divided; less follows steps more closely",
      PITH_PARAM_DOUBLE, 1e-6, 0.004, 1.0, AT(shortest), NULL },
    { "tolerance", "1", "largest error of an interpolated colour, sRGB; less makes more triangles", PITH_PARAM_DOUBLE,
      1e-4, 0.012, 1.0, AT(tolerance), NULL },
    { "most", "1", "vertices at which dividing ends", PITH_PARAM_UINT, 0, 200000, 1 << 28, AT(most), NULL },
};

const pith_params pith_diffusion_section_params = { "section", items, sizeof items / sizeof *items,
                                                    sizeof(pith_diffusion_section_options) };

pith_diffusion_section_options pith_diffusion_section_options_default(void)
{
    pith_diffusion_section_options options;
    pith_params_defaults(&pith_diffusion_section_params, &options);
    return options;
}

/* ---- making ------------------------------------------------------------------------------------------------------------ */

/* Far below what is seen, far above what rounding does. */
#define WELD 1e-9

static pith_status cut_sheets(section_work *work, const pith_mesh_view *cutting, double extent, pith_error *err)
{
    const sheets *all = &work->diffusion->sheets;
    const pith_mesh_view by = { .positions = all->positions,
                                .triangles = (const uint32_t(*)[3])all->triangles,
                                .vertex_count = all->vertex_count,
                                .triangle_count = all->triangle_count };
    PITH_TRY(pith_facets_create(cutting, extent > 0.0 ? WELD * extent : 1.0, &work->facets, err));
    return pith_facets_cut(work->facets, &by, err);
}

static pith_status make(section_work *work, const pith_mesh_view *cutting, const pith_progress *progress,
                        pith_diffusion_section *section, pith_error *err)
{
    pith_box box = pith_box_empty();
    for (uint32_t t = 0; t < cutting->triangle_count; ++t)
        for (int k = 0; k < 3; ++k)
            if (cutting->triangles[t][k] < cutting->vertex_count)
                pith_box_add(&box, cutting->positions[cutting->triangles[t][k]]);
    const pith_vec3 size = pith_sub(box.high, box.low);
    const double extent = cutting->triangle_count > 0 ? fmax(size.x, fmax(size.y, size.z)) : 0.0;
    work->longest = work->options->edge * extent;
    work->shortest = work->options->shortest * extent;
    PITH_TRY(pith_progress_step(progress, 0.0, "cut segments", err));
    PITH_TRY(cut_sheets(work, cutting, isfinite(extent) ? extent : 0.0, err));
    PITH_TRY(section_refine(work, progress, err));
    PITH_TRY(section_split(work, section, err));
    section->asked = work->asked;
    section->lost = pith_facets_look(work->facets).lost;
    return PITH_OK;
}

pith_status pith_diffusion_section_create(const pith_diffusion *diffusion, const pith_diffusion_options *how,
                                          const pith_diffusion_section_options *options, const pith_mesh_view *cutting,
                                          const pith_progress *progress, pith_diffusion_section **section,
                                          pith_error *err)
{
    if (!diffusion || !how || !options || !cutting || !section)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "pith_diffusion_section_create: diffusion, how, options, cutting and "
                         "section must not be NULL");
    if (cutting->triangle_count > 0 && (!cutting->positions || !cutting->triangles))
        return pith_fail(err, PITH_BAD_ARGUMENT, "the cutting surface lacks positions or triangles (NULL)");
    PITH_TRY(pith_params_check(&pith_diffusion_params, how, err));
    PITH_TRY(pith_params_check(&pith_diffusion_section_params, options, err));
    pith_diffusion_section *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "a section");
    section_work work = { .diffusion = diffusion, .how = how, .options = options };
    const pith_status status = make(&work, cutting, progress, made, err);
    pith_facets_destroy(work.facets);
    pith_free(work.colours);
    pith_free(work.kinds);
    pith_free(work.some_mark);
    if (status != PITH_OK) {
        pith_diffusion_section_destroy(made);
        return status;
    }
    *section = made;
    return PITH_OK;
}

void pith_diffusion_section_destroy(pith_diffusion_section *section)
{
    if (!section) return;
    pith_free(section->positions);
    pith_free(section->colours);
    pith_free(section->triangles);
    pith_free(section->sources);
    pith_free(section->segments);
    pith_free(section->segment_surfaces);
    pith_free(section);
}

pith_diffusion_section_view pith_diffusion_section_look(const pith_diffusion_section *section)
{
    return (pith_diffusion_section_view){ .positions = section->positions,
                                          .colours = (const float(*)[4])section->colours,
                                          .triangles = (const uint32_t(*)[3])section->triangles,
                                          .sources = section->sources,
                                          .segments = (const uint32_t(*)[2])section->segments,
                                          .segment_surfaces = section->segment_surfaces,
                                          .vertex_count = section->vertex_count,
                                          .triangle_count = section->triangle_count,
                                          .segment_count = section->segment_count,
                                          .asked = section->asked,
                                          .lost = section->lost };
}

pith_status pith_diffusion_section_mesh(const pith_diffusion_section *section, pith_mesh **mesh, pith_error *err)
{
    if (!section || !mesh)
        return pith_fail(err, PITH_BAD_ARGUMENT, "pith_diffusion_section_mesh: section and mesh must not be NULL");
    const pith_mesh_view view = { .positions = section->positions,
                                  .colours = (const float(*)[4])section->colours,
                                  .triangles = (const uint32_t(*)[3])section->triangles,
                                  .vertex_count = section->vertex_count,
                                  .triangle_count = section->triangle_count };
    return pith_mesh_create(&view, mesh, err);
}

/* ---- pictures ------------------------------------------------------------------------------------------------------------ */

pith_status pith_diffusion_picture(const pith_diffusion *diffusion, const pith_diffusion_options *how, pith_vec3 corner,
                                   pith_vec3 x, pith_vec3 y, uint32_t width, uint32_t height, float (*colours)[4],
                                   pith_error *err)
{
    const size_t count = (size_t)width * height;
    pith_vec3 *points = pith_alloc(count, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "the points of a picture");
    for (size_t i = 0; i < count; ++i) {
        const double u = ((double)(i % width) + 0.5) / width, v = ((double)(i / width) + 0.5) / height;
        points[i] = pith_madd(pith_madd(corner, x, u), y, v);
    }
    const pith_status status = pith_diffusion_colours(diffusion, how, points, count, colours, err);
    pith_free(points);
    return status;
}
