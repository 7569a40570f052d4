/* Texture atlases: the surfaces that the cuts leave, as one mesh with a picture. */
#include "bake_atlas.h"

#include <string.h>

/* The pieces to bake: all, or those of one body. */
static pith_status choose_items(const cli_model *opened, const char *name, pith_atlas_item **chosen, size_t *count,
                                pith_error *err)
{
    const pith_render_item *items;
    size_t all, kept = 0;
    PITH_TRY(pith_model_items(opened->model, &items, &all, err));
    pith_atlas_item *made = pith_alloc(all, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, "pieces");
    for (size_t i = 0; i < all; ++i) {
        const char *body = pith_document_body_name(opened->document, cli_body_of_solid(opened, items[i].solid));
        if (!name || strcmp(name, body) == 0)
            made[kept++] = (pith_atlas_item){ items[i].shell, items[i].solid, items[i].offset };
    }
    if (kept == 0) {
        pith_free(made);
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: the cuts leave nothing of the model to bake",
                         pith_document_title(opened->document));
    }
    *chosen = made;
    *count = kept;
    return PITH_OK;
}

static json_t *report_json(const char *out, const pith_textured *textured, const pith_atlas_report *report)
{
    const pith_mesh_view mesh = pith_mesh_look(textured->mesh);
    return json_pack("{ss si si si si si sf sf sf sf sf sf sf}", "file", out, "triangles", (int)mesh.triangle_count,
                     "vertices", (int)mesh.vertex_count, "charts", (int)report->charts, "width", (int)report->width,
                     "height", (int)report->height, "covered", report->covered, "filled", report->filled,
                     "least_density", report->least_density, "mean_density", report->mean_density, "most_density",
                     report->most_density, "layout_seconds", report->layout_seconds, "ask_seconds",
                     report->ask_seconds);
}

pith_status bake_atlas(const cli_model *opened, const cli_line *line, const cli_cut *cut, const char *name,
                       const char *out, json_t **told, pith_error *err)
{
    pith_atlas_options options = pith_atlas_options_default();
    cli_apply_params(line, &pith_atlas_params, &options);
    pith_atlas_item *items = NULL;
    size_t count = 0;
    pith_textured *textured = NULL;
    pith_atlas_report report;
    PITH_TRY(cli_apply_cut(line, cut, opened->model, err));
    PITH_TRY(choose_items(opened, name, &items, &count, err));
    pith_status status = pith_bake_atlas(items, count, &options, cli_progress(), &textured, &report, err);
    if (status == PITH_OK) status = pith_textured_write(textured, out, err);
    if (status == PITH_OK && told) *told = report_json(out, textured, &report);
    pith_textured_destroy(textured);
    pith_free(items);
    return status;
}
