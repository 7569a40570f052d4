/* pith render: a picture of the cut model, of its surfaces or through it. */
#include "cli.h"

typedef struct render_flags {
    const char *out;
    cli_camera camera;
    cli_cut cut;
    bool volume, surface, lines, no_lines;
} render_flags;

static pith_status write_picture(pith_image *image, const char *out, pith_error *err)
{
    const pith_status status = cli_write_picture(image, out, err);
    pith_image_destroy(image);
    return status;
}

static pith_status nothing_left(const cli_line *line, pith_error *err)
{
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: the cuts leave nothing of the model to look at", line->word[0]);
}

/* A picture of nothing is not what anybody wants. */
static pith_status check_view(const cli_line *line, const pith_camera *camera, const pith_box *box, double aspect,
                              pith_error *err)
{
    const bool nowhere = !(pith_distance(camera->eye, camera->target) > 0.0); /* told by the renderer */
    if (!pith_finite(camera->eye) || nowhere || pith_camera_sees(camera, box, aspect)) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT,
                     "%s: the camera at (%g, %g, %g) sees nothing: the model, from (%g, %g, %g) to (%g, %g, %g), lies "
                     "behind it or beside the picture; move the eye or the target, or give a direction alone",
                     line->word[0], camera->eye.x, camera->eye.y, camera->eye.z, box->low.x, box->low.y, box->low.z,
                     box->high.x, box->high.y, box->high.z);
}

static pith_status render_surface(const cli_model *opened, const cli_line *line, const render_flags *asked,
                                  pith_error *err)
{
    pith_render_options options;
    const pith_render_item *items;
    size_t count;
    PITH_TRY(pith_model_scene(opened->model, &items, &count, err));
    if (count == 0) return nothing_left(line, err);
    PITH_TRY(pith_model_view(opened->model, &(pith_camera){ 0 }, &options, err));
    cli_apply_params(line, &pith_render_params, &options);
    const pith_box box = pith_render_box(items, count);
    const double aspect = (double)options.width / options.height;
    const pith_camera camera = cli_place_camera(&asked->camera, opened->document, &box, aspect);
    PITH_TRY(check_view(line, &camera, &box, aspect, err));
    pith_image *image = NULL;
    PITH_TRY(pith_render(items, count, &camera, &options, cli_progress(), &image, err));
    const pith_line_options standard = pith_line_options_default(), *said = pith_document_lines(opened->document);
    pith_status status = PITH_OK;
    if ((said || asked->lines) && !asked->no_lines)
        status = pith_render_lines(items, count, NULL, &camera, said ? said : &standard, cli_progress(), image, err);
    if (status == PITH_OK) return write_picture(image, asked->out, err);
    pith_image_destroy(image);
    return status;
}

static pith_status render_volume(const cli_model *opened, const cli_line *line, const render_flags *asked,
                                 pith_error *err)
{
    pith_volume_options options;
    const pith_volume_item *items;
    const pith_transfer_point *transfer;
    size_t count, transfer_count;
    PITH_TRY(pith_model_volume_items(opened->model, &items, &count, err));
    if (count == 0) return nothing_left(line, err);
    PITH_TRY(pith_model_volume_view(opened->model, &(pith_camera){ 0 }, &options, &transfer, &transfer_count, err));
    cli_apply_params(line, &pith_volume_params, &options);
    pith_box box = pith_box_empty();
    for (size_t i = 0; i < count; ++i) {
        const pith_part_view part = pith_part_look(items[i].part);
        for (uint32_t v = 0; v < part.vertex_count; ++v)
            pith_box_add(&box, pith_add(part.positions[v], items[i].offset));
    }
    const double aspect = (double)options.width / options.height;
    const pith_camera camera = cli_place_camera(&asked->camera, opened->document, &box, aspect);
    PITH_TRY(check_view(line, &camera, &box, aspect, err));
    pith_image *image = NULL;
    PITH_TRY(
        pith_render_volume(items, count, &camera, &options, transfer, transfer_count, cli_progress(), &image, err));
    return write_picture(image, asked->out, err);
}

/* Flags of the kind of picture that is not made would change nothing without a word. */
static int check_kind(const cli_line *line, bool through)
{
    const char *other = cli_only_of(line, through ? &pith_render_params : &pith_volume_params);
    if (!other) return CLI_GO_ON;
    return through ? cli_misuse("render",
                                "%s is of pictures of surfaces, and the document is translucent; --surface makes "
                                "one",
                                other)
                   : cli_misuse("render", "%s is of translucent pictures, and the document is not; --volume makes one",
                                other);
}

static int check_flags(const cli_line *line, const render_flags *asked)
{
    const char *out = asked->out;
    if (!out || !cli_is_picture(out))
        return cli_misuse("render", "expected -o FILE ending in .png, .jpg or .exr%s%s", out ? ", got " : "",
                          out ? out : "");
    if (asked->lines && asked->no_lines) return cli_misuse("render", "--lines and --no-lines exclude one another");
    if (asked->volume && asked->surface) return cli_misuse("render", "--volume and --surface exclude one another");
    int code = cli_check_camera("render", &asked->camera);
    if (code == CLI_GO_ON) code = cli_check_cut(line, &asked->cut);
    if (code == CLI_GO_ON && cli_check_out("render", out) != CLI_GO_ON) code = EXIT_FAILED;
    return code;
}

int verb_render(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    render_flags asked = { 0 };
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &asked.out, "FILE", "the picture: .png, .jpg or .exr", 0, 0, NULL },
        CLI_CAMERA_FLAGS(asked.camera),
        CLI_CUT_FLAGS(asked.cut),
        { "volume", 0, CLI_SWITCH, &asked.volume, NULL, "look through the model, though the document does not say so",
          0, 0, NULL },
        { "surface", 0, CLI_SWITCH, &asked.surface, NULL, "look at its surfaces, though the document is translucent", 0,
          0, NULL },
        { "lines", 0, CLI_SWITCH, &asked.lines, NULL, "draw lines over the picture, as the document's \"lines\" say or "
          "in the standard way", 0, 0, NULL },
        { "no-lines", 0, CLI_SWITCH, &asked.no_lines, NULL, "draw none, though the document has \"lines\"", 0, 0, NULL },
        { "no-displacement", 0, CLI_SWITCH, &common.no_displacement, NULL,
          "leave the skin where it is, whatever the document says", 0, 0, NULL },
        CLI_THREADS_FLAG(common),
        CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "render",
        .words = "DOCUMENT -o FILE",
        .least_words = 1,
        .most_words = 1,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .tables = { &pith_cut_step_params, &pith_render_params, &pith_volume_params },
        .summary =
            "Makes a picture of the model with the document's cuts, camera and options: ray-traced surfaces, or a\n"
            "translucent picture when the document has \"volume\". Every option of either can be given here too.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code == CLI_GO_ON) code = check_flags(&line, &asked);
    if (code != CLI_GO_ON) return code;
    cli_model opened;
    code = cli_open("render", line.word[0], &common, &opened);
    if (code != CLI_GO_ON) return code;
    const bool through = asked.volume || (!asked.surface && pith_document_translucent(opened.document));
    int result = check_kind(&line, through);
    if (result == CLI_GO_ON) {
        pith_error err;
        pith_status status = cli_apply_cut(&line, &asked.cut, opened.model, &err);
        if (status == PITH_OK)
            status =
                through ? render_volume(&opened, &line, &asked, &err) : render_surface(&opened, &line, &asked, &err);
        result = status == PITH_OK ? EXIT_DONE : cli_fail("render", &err);
    }
    cli_close(&opened);
    return result;
}
