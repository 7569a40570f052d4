/* pith section: what a cut lays open of bodies whose colours flow between surfaces, as a mesh that follows the surfaces. */
#include "cli.h"

#include "pith/diffusion_section.h"

typedef struct section_flags {
    const char *out;
    cli_cut cut;
    pith_diffusion_section_options options;
} section_flags;

/* All sections as one mesh, as it grows. */
typedef struct joined {
    pith_vec3 *positions;
    float (*colours)[4];
    uint32_t (*triangles)[3];
    uint32_t vertices, count;
    size_t position_room, colour_room, triangle_room;
    uint32_t asked, segments;
} joined;

static void joined_clear(joined *gone)
{
    pith_free(gone->positions);
    pith_free(gone->colours);
    pith_free(gone->triangles);
}

/* Solids are asked where the material is; the mesh stands where the piece does. */
static pith_status join(joined *to, const pith_diffusion_section_view *from, pith_vec3 offset, pith_error *err)
{
    const size_t vertices = (size_t)to->vertices + from->vertex_count, count = (size_t)to->count + from->triangle_count;
    if (!pith_grow((void **)&to->positions, &to->position_room, vertices, sizeof *to->positions) ||
        !pith_grow((void **)&to->colours, &to->colour_room, vertices, sizeof *to->colours) ||
        !pith_grow((void **)&to->triangles, &to->triangle_room, count, sizeof *to->triangles))
        return pith_fail(err, PITH_NO_MEMORY, "no memory for the section");
    for (uint32_t v = 0; v < from->vertex_count; ++v) {
        to->positions[to->vertices + v] = pith_add(from->positions[v], offset);
        for (int c = 0; c < 4; ++c) to->colours[to->vertices + v][c] = from->colours[v][c];
    }
    for (uint32_t t = 0; t < from->triangle_count; ++t)
        for (int k = 0; k < 3; ++k) to->triangles[to->count + t][k] = to->vertices + from->triangles[t][k];
    to->vertices = (uint32_t)vertices;
    to->count = (uint32_t)count;
    to->asked += from->asked;
    to->segments += from->segment_count;
    return PITH_OK;
}

/* The section's triangles of a shell, at their material coordinates. The caller frees them. */
static pith_status cutting_surface(const pith_shell *shell, pith_mesh_view *surface, uint32_t (**triangles)[3],
                                   pith_error *err)
{
    const pith_shell_view view = pith_shell_look(shell);
    uint32_t count = 0;
    *triangles = pith_alloc(view.triangle_count, sizeof **triangles);
    if (!*triangles) return pith_fail(err, PITH_NO_MEMORY, "no memory for the section");
    for (uint32_t t = 0; t < view.triangle_count; ++t) {
        if (view.kinds[t] != PITH_SECTION) continue;
        for (int k = 0; k < 3; ++k) (*triangles)[count][k] = view.triangles[t][k];
        ++count;
    }
    *surface = (pith_mesh_view){ .positions = view.material, .triangles = (const uint32_t(*)[3])*triangles,
                                 .vertex_count = view.vertex_count, .triangle_count = count };
    return PITH_OK;
}

static pith_status section_of_piece(const cli_model *opened, const section_flags *asked, const pith_model_piece *piece,
                                    joined *to, pith_error *err)
{
    pith_model *body;
    const pith_diffusion *diffusion;
    const pith_diffusion_options *how;
    pith_mesh_view surface;
    uint32_t(*triangles)[3] = NULL;
    pith_diffusion_section *section = NULL;
    PITH_TRY(pith_model_body(opened->model, piece->body, &body, err));
    PITH_TRY(pith_model_diffusion(body, &diffusion, &how, err));
    pith_status status = cutting_surface(piece->shell, &surface, &triangles, err);
    if (status == PITH_OK)
        status = pith_diffusion_section_create(diffusion, how, &asked->options, &surface, cli_progress(), &section, err);
    pith_free(triangles);
    if (status != PITH_OK) return status;
    const pith_diffusion_section_view view = pith_diffusion_section_look(section);
    status = join(to, &view, piece->offset, err);
    pith_diffusion_section_destroy(section);
    return status;
}

static pith_status make_section(const cli_model *opened, const cli_line *line, const section_flags *asked, joined *made,
                                pith_error *err)
{
    const pith_model_piece *pieces;
    size_t count;
    PITH_TRY(cli_apply_cut(line, &asked->cut, opened->model, err));
    PITH_TRY(pith_model_pieces(opened->model, false, &pieces, &count, err));
    for (size_t i = 0; i < count; ++i)
        if (!pieces[i].hidden) PITH_TRY(section_of_piece(opened, asked, &pieces[i], made, err));
    if (made->count == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: nothing is laid open: the document has no cut that meets the model; "
                         "give one with --plane or --stroke", line->word[0]);
    pith_mesh *mesh = NULL;
    const pith_mesh_view view = { .positions = made->positions, .colours = (const float(*)[4])made->colours,
                                  .triangles = (const uint32_t(*)[3])made->triangles, .vertex_count = made->vertices,
                                  .triangle_count = made->count };
    PITH_TRY(pith_mesh_create(&view, &mesh, err));
    const pith_status status = pith_mesh_write(mesh, asked->out, err);
    pith_mesh_destroy(mesh);
    return status;
}

static int run(const cli_model *opened, const cli_line *line, const section_flags *asked, bool json)
{
    joined made = { 0 };
    pith_error err;
    const pith_status status = make_section(opened, line, asked, &made, &err);
    joined_clear(&made);
    if (status != PITH_OK) return cli_fail("section", &err);
    cli_progress_done();
    if (!json) return EXIT_DONE;
    return cli_print_json(json_pack("{ss si si si si}", "file", asked->out, "vertices", (int)made.vertices, "triangles",
                                    (int)made.count, "segments", (int)made.segments, "asked", (int)made.asked));
}

int verb_section(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    section_flags asked = { .options = pith_diffusion_section_options_default() };
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &asked.out, "FILE", "the mesh: .glb, .ply or .obj", 0, 0, NULL },
        CLI_CUT_FLAGS(asked.cut),
        CLI_JSON_FLAG(common), CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "section", .words = "DOCUMENT -o FILE", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .tables = { &pith_cut_step_params, &pith_diffusion_section_params },
        .summary = "Writes what the cuts lay open of bodies whose solids are of kind \"diffusion\", as a mesh with a colour at\n"
                   "every vertex: edges run along the surfaces, where vertices stand twice with the colour of either\n"
                   "side, and triangles are as large as the colours allow. Of combined solids it is the colour, without\n"
                   "the detail on it. pith cut writes whole pieces of any model.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (!asked.out || !(pith_path_has_extension(asked.out, "glb") || pith_path_has_extension(asked.out, "ply") ||
                        pith_path_has_extension(asked.out, "obj")))
        return cli_misuse("section", "expected -o FILE ending in .glb, .ply or .obj%s%s", asked.out ? ", got " : "",
                          asked.out ? asked.out : "");
    code = cli_check_cut(&line, &asked.cut);
    if (code != CLI_GO_ON) return code;
    if (cli_check_out("section", asked.out) != CLI_GO_ON) return EXIT_FAILED;
    cli_apply_params(&line, &pith_diffusion_section_params, &asked.options);
    cli_model opened;
    code = cli_open("section", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    code = run(&opened, &line, &asked, common.json);
    cli_close(&opened);
    return code;
}
