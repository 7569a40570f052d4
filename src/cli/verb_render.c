/* pith render: a picture of the cut model. */
#include "cli.h"

static pith_status run(const cli_model *opened, const cli_line *line, const char *out, pith_error *err)
{
    pith_camera camera;
    pith_render_options options;
    const pith_render_item *items;
    size_t count;
    PITH_TRY(pith_model_items(opened->model, &items, &count, err));
    PITH_TRY(pith_model_view(opened->model, &camera, &options, err));
    cli_apply_params(line, &options);
    /* A fitted camera depends on the picture's shape, which a flag may have changed. */
    PITH_TRY(pith_model_camera(opened->model, (double)options.width / options.height, &camera, err));
    pith_image *image = NULL;
    PITH_TRY(pith_render(items, count, &camera, &options, cli_progress(), &image, err));
    const pith_status status = pith_image_write(image, out, 92, err);
    pith_image_destroy(image);
    return status;
}

int verb_render(int argc, char **argv)
{
    cli_model_flags common = { 0 };
    const char *out = NULL, *keep = "both";
    double gap = 0;
    pith_cut_step cut;
    pith_params_defaults(&pith_cut_step_params, &cut);
    bool has_plane = false, has_keep = false, has_gap = false;
    const cli_flag flags[] = {
        { "out", 'o', CLI_TEXT, &out, "FILE", "the picture: .png or .jpg", 0, 0, NULL },
        { "plane", 0, CLI_PLANE, &cut.plane, "PX,..,NZ", "cut here instead of where the document says", 0, 0, &has_plane },
        { "keep", 0, CLI_TEXT, &keep, "WORD", "with --plane: both, positive or negative", 0, 0, &has_keep },
        { "gap", 0, CLI_NUMBER, &gap, "X", "with --plane: how far the halves are moved apart", 0, 1e9,
          &has_gap },
        CLI_THREADS_FLAG(common), CLI_CACHE_FLAG(common),
    };
    cli_line line = {
        .verb = "render", .words = "DOCUMENT -o FILE", .least_words = 1, .most_words = 1, .flags = flags,
        .flag_count = sizeof flags / sizeof *flags, .params = &pith_render_params,
        .summary = "Makes a ray-traced picture of the model with the document's cuts, camera and render options; every\n"
                   "render option can be given here too.",
    };
    const int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    if (!out || !(pith_path_has_extension(out, "png") || pith_path_has_extension(out, "jpg") ||
                  pith_path_has_extension(out, "jpeg")))
        return cli_misuse("render", "expected -o FILE ending in .png or .jpg%s%s", out ? ", got " : "", out ? out : "");
    if ((has_keep || has_gap) && !has_plane)
        return cli_misuse("render", "--%s goes with --plane; without it the document's own cuts hold",
                          has_keep ? "keep" : "gap");
    pith_error err;
    if (pith_param_set_word(pith_params_find(&pith_cut_step_params, "keep"), &cut, keep, &err) != PITH_OK)
        return cli_misuse("render", "%s", err.message);
    cut.gap = gap;
    if (cli_check_out("render", out) != CLI_GO_ON) return EXIT_FAILED;
    cli_model opened;
    const int open = cli_open("render", line.word[0], &common, &opened);
    if (open != CLI_GO_ON) return open;
    pith_status status = has_plane ? pith_model_set_cuts(opened.model, &cut, 1, &err) : PITH_OK;
    if (status == PITH_OK) status = run(&opened, &line, out, &err);
    const int result = status == PITH_OK ? EXIT_DONE : cli_fail("render", &err);
    cli_close(&opened);
    return result;
}
