/* pith bake: the solid as a voxel grid, the surface with a picture of it, or the tetrahedra with what pith knows of
   them. */
#include "bake_atlas.h"

#include <string.h>

/* ---- voxels ------------------------------------------------------------------------------------------------------ */

/* A grid over all bodies: cubic voxels, `longest` along the longest side; the channels of the solid that has most. */
static pith_status make_grid(const cli_model *opened, uint32_t longest, pith_grid **grid, pith_error *err)
{
    pith_box box = pith_box_empty();
    uint32_t channels = 4, size[3];
    for (size_t i = 0; i < pith_model_bodies(opened->model); ++i) {
        pith_model *body;
        const pith_tets *tets;
        const pith_solid *solid;
        PITH_TRY(pith_model_body(opened->model, i, &body, err));
        PITH_TRY(pith_model_solid(body, &solid, err));
        PITH_TRY(pith_model_tets(body, &tets, NULL, err));
        const pith_tets_view view = pith_tets_look(tets);
        for (uint32_t v = 0; v < view.vertex_count; ++v) pith_box_add(&box, view.positions[v]);
        if (pith_solid_channels(solid) > channels) channels = pith_solid_channels(solid);
    }
    const pith_vec3 extent = pith_sub(box.high, box.low);
    const double sides[3] = { extent.x, extent.y, extent.z },
                 spacing = fmax(fmax(extent.x, extent.y), extent.z) / longest;
    double shift[3], bytes = sizeof(float) * channels;
    for (int k = 0; k < 3; ++k) { /* shorter sides are rounded up and centred */
        size[k] = (uint32_t)fmin(fmax(ceil(sides[k] / spacing - 1e-9), 1.0), longest);
        shift[k] = 0.5 * (sides[k] - size[k] * spacing);
        bytes *= size[k];
    }
    if (bytes > 8.0 * 1024 * 1024 * 1024)
        return pith_fail(err, PITH_BAD_ARGUMENT,
                         "%u x %u x %u voxels of %u channels are %.1f GiB, 8 GiB are allowed; ask for "
                         "fewer with --voxels",
                         size[0], size[1], size[2], channels, bytes / (1024.0 * 1024 * 1024));
    PITH_TRY(pith_grid_create(size, channels, grid, err));
    (*grid)->origin = pith_add(box.low, pith_v3(shift[0], shift[1], shift[2]));
    (*grid)->spacing = pith_v3(spacing, spacing, spacing);
    return PITH_OK;
}

/* What one layer of voxels needs. */
typedef struct bake_layer {
    pith_vec3 *centres;
    uint32_t *tets, *cells;     /* of voxels inside the body that are still empty */
    double (*weights)[4];
    float *footprints, *answers;
} bake_layer;

/* Voxels of layer z that lie in this body and in none before it. */
static size_t find_cells(const pith_grid *grid, uint32_t z, const pith_locator *locator, bake_layer *layer)
{
    const uint32_t cells = grid->size[0] * grid->size[1];
    for (uint32_t c = 0; c < cells; ++c)
        layer->centres[c] = pith_v3(grid->origin.x + grid->spacing.x * (c % grid->size[0] + 0.5),
                                    grid->origin.y + grid->spacing.y * (c / grid->size[0] + 0.5),
                                    grid->origin.z + grid->spacing.z * (z + 0.5));
    pith_locator_find(locator, layer->centres, cells, 0.0, layer->tets, layer->weights);
    size_t count = 0;
    for (uint32_t c = 0; c < cells; ++c) {
        const float *voxel = grid->values + ((size_t)z * cells + c) * grid->channels;
        if (layer->tets[c] == PITH_NONE || voxel[3] > 0.0f) continue;
        layer->centres[count] = layer->centres[c];
        layer->tets[count] = layer->tets[c];
        memcpy(layer->weights[count], layer->weights[c], sizeof *layer->weights);
        layer->footprints[count] = (float)grid->spacing.x;
        layer->cells[count++] = c;
    }
    return count;
}

static pith_status bake_body(pith_model *body, pith_grid *grid, bake_layer *layer, pith_error *err)
{
    const pith_solid *solid;
    const pith_locator *locator;
    PITH_TRY(pith_model_solid(body, &solid, err));
    PITH_TRY(pith_model_locator(body, &locator, err));
    const uint32_t cells = grid->size[0] * grid->size[1], channels = pith_solid_channels(solid);
    for (uint32_t z = 0; z < grid->size[2]; ++z) {
        PITH_TRY(pith_progress_step(cli_progress(), (double)z / grid->size[2], "voxels", err));
        const size_t count = find_cells(grid, z, locator, layer);
        const pith_query query = { .points = layer->centres, .footprints = layer->footprints, .tets = layer->tets,
                                   .weights = (const double (*)[4])layer->weights, .count = count };
        PITH_TRY(pith_solid_sample(solid, &query, layer->answers, err));
        for (size_t i = 0; i < count; ++i)
            memcpy(grid->values + ((size_t)z * cells + layer->cells[i]) * grid->channels, layer->answers + i * channels,
                   channels * sizeof *layer->answers);
    }
    return PITH_OK;
}

/* Several bodies in one grid; where they overlap the first that has something there is seen, as in pith sample. */
static pith_status bake_bodies(const cli_model *opened, uint32_t voxels, pith_grid **grid, pith_error *err)
{
    pith_grid *made = NULL;
    PITH_TRY(make_grid(opened, voxels, &made, err));
    const size_t cells = (size_t)made->size[0] * made->size[1];
    bake_layer layer = { .centres = pith_alloc(cells, sizeof *layer.centres),
                         .tets = pith_alloc(cells, sizeof *layer.tets),
                         .cells = pith_alloc(cells, sizeof *layer.cells),
                         .weights = pith_alloc(cells, sizeof *layer.weights),
                         .footprints = pith_alloc(cells, sizeof *layer.footprints),
                         .answers = pith_alloc(cells * made->channels, sizeof *layer.answers) };
    pith_status status =
        layer.centres && layer.tets && layer.cells && layer.weights && layer.footprints && layer.answers
            ? PITH_OK
            : PITH_OUT_OF_MEMORY(err, "a layer of voxels");
    for (size_t i = 0; status == PITH_OK && i < pith_model_bodies(opened->model); ++i) {
        pith_model *body = NULL;
        status = pith_model_body(opened->model, i, &body, err);
        if (status == PITH_OK) status = bake_body(body, made, &layer, err);
    }
    pith_free(layer.centres);
    pith_free(layer.tets);
    pith_free(layer.cells);
    pith_free(layer.weights);
    pith_free(layer.footprints);
    pith_free(layer.answers);
    if (status == PITH_OK) *grid = made;
    else pith_grid_destroy(made);
    return status;
}

static pith_status bake_one(pith_model *body, uint32_t voxels, pith_grid **grid, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const pith_locator *locator;
    PITH_TRY(pith_model_solid(body, &solid, err));
    PITH_TRY(pith_model_tets(body, &tets, NULL, err));
    PITH_TRY(pith_model_locator(body, &locator, err));
    return pith_bake_voxels(solid, tets, locator, voxels, cli_progress(), grid, err);
}

/* body NULL: all bodies. */
static pith_status bake_voxels(const cli_model *opened, pith_model *body, const char *out, uint32_t voxels, bool bytes,
                               pith_error *err)
{
    pith_grid *grid = NULL;
    PITH_TRY(body ? bake_one(body, voxels, &grid, err) : bake_bodies(opened, voxels, &grid, err));
    const pith_status status = pith_grid_write_nrrd(grid, out, bytes ? PITH_NRRD_UCHAR_SRGB : PITH_NRRD_FLOAT, true,
                                                    err);
    pith_grid_destroy(grid);
    return status;
}

/* ---- tetrahedra -------------------------------------------------------------------------------------------------- */

/* The solid's RGBA at every vertex, in double as VTU wants it. Caller frees. */
static pith_status vertex_colours(const pith_solid *solid, const pith_tets_view *tets, double **colours,
                                  pith_error *err)
{
    const uint32_t channels = pith_solid_channels(solid);
    float *answers = pith_alloc((size_t)tets->vertex_count * channels, sizeof *answers);
    double *made = pith_alloc((size_t)tets->vertex_count * 4, sizeof *made);
    const pith_query query = { .points = tets->positions, .count = tets->vertex_count };
    pith_status status = !answers || !made ? PITH_OUT_OF_MEMORY(err, "the vertices' colours")
                                           : pith_solid_sample(solid, &query, answers, err);
    for (uint32_t v = 0; status == PITH_OK && v < tets->vertex_count; ++v)
        for (int c = 0; c < 4; ++c) made[4 * (size_t)v + c] = (double)answers[(size_t)v * channels + c];
    pith_free(answers);
    if (status == PITH_OK) *colours = made;
    else pith_free(made);
    return status;
}

/* Tetrahedra with colour, and all the fields that the body has. */
static pith_status bake_tets(const cli_model *opened, pith_model *body, const char *out, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const double *depth = NULL, *scale = NULL;
    const pith_vec3 *gradient = NULL, *secondary = NULL, *directions = NULL;
    PITH_TRY(pith_model_solid(body, &solid, err));
    PITH_TRY(pith_model_tets(body, &tets, NULL, err));
    if (cli_states(opened, body, "depth")) PITH_TRY(pith_model_fields(body, &depth, &gradient, &secondary, err));
    PITH_TRY(pith_model_directions(body, &directions, err));
    PITH_TRY(pith_model_scale(body, &scale, err));
    const pith_tets_view view = pith_tets_look(tets);
    double *colours = NULL;
    PITH_TRY(vertex_colours(solid, &view, &colours, err));
    pith_attribute data[6] = { { "rgba", 4, colours } };
    size_t count = 1;
    if (depth) data[count++] = (pith_attribute){ "depth", 1, depth };
    if (gradient) data[count++] = (pith_attribute){ "depth_gradient", 3, &gradient->x };
    if (secondary) data[count++] = (pith_attribute){ "secondary", 3, &secondary->x };
    if (directions) data[count++] = (pith_attribute){ "vectors", 3, &directions->x };
    if (scale) data[count++] = (pith_attribute){ "scale", 1, scale };
    const pith_status status = pith_tets_write_vtu(tets, data, count, NULL, 0, out, err);
    pith_free(colours);
    return status;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

typedef enum bake_kind { BAKE_NOTHING, BAKE_VOXELS, BAKE_TETS, BAKE_ATLAS } bake_kind;

typedef struct bake_flags {
    const char *out, *type, *body;
    int voxels;
    bool has_voxels, has_type, atlas;
    cli_cut cut;
} bake_flags;

static bake_kind kind_of(const char *out)
{
    if (!out) return BAKE_NOTHING;
    if (pith_path_has_extension(out, "nrrd")) return BAKE_VOXELS;
    if (pith_path_has_extension(out, "vtu")) return BAKE_TETS;
    return pith_path_has_extension(out, "glb") || pith_path_has_extension(out, "obj") ? BAKE_ATLAS : BAKE_NOTHING;
}

/* Flags of another kind of file would change nothing without a word. */
static int check_flags(const cli_line *line, const bake_flags *asked, bake_kind kind)
{
    if (kind == BAKE_NOTHING)
        return cli_misuse("bake", "expected -o FILE ending in .nrrd, .vtu, .glb or .obj%s%s", asked->out ? ", got " : "",
                          asked->out ? asked->out : "");
    if (strcmp(asked->type, "uchar") != 0 && strcmp(asked->type, "float") != 0)
        return cli_misuse("bake", "--type is \"%s\", expected uchar or float", asked->type);
    if (kind != BAKE_VOXELS && (asked->has_voxels || asked->has_type))
        return cli_misuse("bake", "--%s is of voxel grids, and %s is none", asked->has_voxels ? "voxels" : "type",
                          asked->out);
    const char *of_atlas = asked->atlas ? "--atlas" : cli_only_of(line, &pith_atlas_params);
    if (kind != BAKE_ATLAS && of_atlas)
        return cli_misuse("bake", "%s is of texture atlases, which are .glb or .obj; %s is neither", of_atlas,
                          asked->out);
    if (kind != BAKE_ATLAS && (asked->cut.has_plane || asked->cut.has_stroke))
        return cli_misuse("bake", "%s is baked uncut; --plane and --stroke go with .glb and .obj", asked->out);
    const int code = cli_check_cut(line, &asked->cut);
    return code == CLI_GO_ON ? cli_check_out("bake", asked->out) == CLI_GO_ON ? CLI_GO_ON : EXIT_FAILED : code;
}

static int run(const cli_model *opened, const cli_line *line, const bake_flags *asked, bake_kind kind, bool json)
{
    pith_error err;
    pith_status status;
    pith_model *body = NULL;
    json_t *told = NULL;
    if (asked->body || kind == BAKE_TETS || (kind == BAKE_VOXELS && pith_model_bodies(opened->model) == 1)) {
        const int code = cli_choose_body("bake", opened, asked->body, &body);
        if (code != CLI_GO_ON) return code;
    }
    if (kind == BAKE_TETS) status = bake_tets(opened, body, asked->out, &err);
    else if (kind == BAKE_VOXELS)
        status = bake_voxels(opened, body, asked->out, (uint32_t)asked->voxels, strcmp(asked->type, "uchar") == 0, &err);
    else status = bake_atlas(opened, line, &asked->cut, asked->body, asked->out, json ? &told : NULL, &err);
    if (status != PITH_OK) return cli_fail("bake", &err);
    if (!json) return EXIT_DONE;
    return cli_print_json(told ? told : json_pack("{ss}", "file", asked->out));
}

int verb_bake(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    bake_flags asked = { .type = "uchar", .voxels = 128 };
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &asked.out, "FILE",
          ".nrrd: a gzipped grid; .glb, .obj: a texture atlas; .vtu: the tetrahedra, for ParaView", 0, 0, NULL },
        { "body", 0, CLI_TEXT, &asked.body, "NAME", "of several bodies only this one; a .vtu holds one", 0, 0, NULL },
        { "voxels", 0, CLI_WHOLE, &asked.voxels, "N", "along the longest side; default 128", 2, 2048,
          &asked.has_voxels },
        { "type", 0, CLI_TEXT, &asked.type, "uchar|float",
          "voxels in 8-bit sRGB, or linear 32-bit floats; default uchar", 0, 0, &asked.has_type },
        { "atlas", 0, CLI_SWITCH, &asked.atlas, NULL, "a texture atlas: what .glb and .obj are without saying so", 0, 0,
          NULL },
        CLI_CUT_FLAGS(asked.cut),
        { "no-displacement", 0, CLI_SWITCH, &common.no_displacement, NULL,
          "leave the skin where it is, whatever the document says", 0, 0, NULL },
        CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "bake",
        .words = "DOCUMENT -o FILE",
        .least_words = 1,
        .most_words = 1,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .tables = { &pith_cut_step_params, &pith_atlas_params },
        .summary =
            "Asks the solid at the middle of every voxel that lies inside the shape, and writes an NRRD with the\n"
            "shape's own coordinates, over all bodies when there are several. Voxels outside have opacity 0.\n"
            "\n"
            "Into a .glb or .obj goes the surface that the cuts leave, skin and sections, with a picture of the solid\n"
            "on it for programs that know nothing of solids: charts that never overlap, at least --density texels per\n"
            "model unit everywhere. An .obj comes with an .mtl and a .png beside it.\n"
            "\n"
            "Into a .vtu go the tetrahedra of a body, with colour and all its fields at their vertices.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    const bake_kind kind = kind_of(asked.out);
    code = check_flags(&line, &asked, kind);
    if (code != CLI_GO_ON) return code;
    cli_model opened;
    code = cli_open("bake", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    code = run(&opened, &line, &asked, kind, common.json);
    cli_close(&opened);
    return code;
}
