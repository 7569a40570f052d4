/* What verbs that show a model share: which body, where the camera stands, where it is cut. */
#include "cli.h"

#include <string.h>

/* ---- bodies ------------------------------------------------------------------------------------------------------ */

int cli_choose_body(const char *verb, const cli_model *opened, const char *name, pith_model **body)
{
    const size_t count = pith_model_bodies(opened->model);
    size_t chosen = count;
    for (size_t i = 0; name && i < count; ++i)
        if (strcmp(pith_document_body_name(opened->document, i), name) == 0) chosen = i;
    if (!name && count == 1) chosen = 0;
    if (chosen < count) {
        pith_error err;
        return pith_model_body(opened->model, chosen, body, &err) == PITH_OK ? CLI_GO_ON : cli_fail(verb, &err);
    }
    if (count == 1 && pith_document_body_name(opened->document, 0)[0] == 0)
        return cli_misuse(verb, "there is no body \"%s\": the document has one body, without a name", name);
    char names[400] = "";
    for (size_t i = 0; i < count; ++i) {
        const size_t length = strlen(names);
        snprintf(names + length, sizeof names - length, "%s%s", i ? ", " : "",
                 pith_document_body_name(opened->document, i));
    }
    if (name) return cli_misuse(verb, "there is no body \"%s\", expected one of %s", name, names);
    return cli_misuse(verb, "the document has %zu bodies, choose one with --body: %s", count, names);
}

size_t cli_body_of_solid(const cli_model *opened, const pith_solid *solid)
{
    for (size_t i = 0; i < pith_model_bodies(opened->model); ++i) {
        pith_model *body;
        const pith_solid *own;
        if (pith_model_body(opened->model, i, &body, NULL) == PITH_OK &&
            pith_model_solid(body, &own, NULL) == PITH_OK && own == solid)
            return i;
    }
    return 0;
}

bool cli_states(const cli_model *opened, const pith_model *body, const char *key)
{
    char *text = NULL;
    if (pith_document_json_full(opened->document, &text, NULL) != PITH_OK) return false;
    json_t *root = json_loads(text, 0, NULL), *bodies = json_object_get(root, "bodies"), *from = root;
    pith_free(text);
    for (size_t i = 0; bodies && i < pith_model_bodies(opened->model); ++i) {
        pith_model *other;
        if (pith_model_body(opened->model, i, &other, NULL) == PITH_OK && other == body)
            from = json_array_get(bodies, i);
    }
    const bool states = json_object_get(from, key) != NULL;
    json_decref(root);
    return states;
}

/* ---- camera ------------------------------------------------------------------------------------------------------ */

int cli_check_camera(const char *verb, const cli_camera *flags)
{
    if (flags->has_eye && flags->has_direction)
        return cli_misuse(verb, "--eye and --direction both say where the camera stands; give one of them");
    if (flags->has_direction && !(pith_length(flags->direction) > 0.0))
        return cli_misuse(verb, "--direction is 0,0,0, expected a vector with a length");
    if (flags->has_up && !(pith_length(flags->up) > 0.0))
        return cli_misuse(verb, "--up is 0,0,0, expected a vector with a length");
    return CLI_GO_ON;
}

pith_camera cli_place_camera(const cli_camera *flags, const pith_document *document, const pith_box *box, double aspect)
{
    pith_camera stated;
    const bool placed = pith_document_camera(document, &stated);
    const pith_vec3 up = flags->has_up ? flags->up : stated.up;
    const double field_of_view = flags->has_field_of_view ? flags->field_of_view : stated.field_of_view;
    const pith_vec3 middle = pith_lerp(box->low, box->high, 0.5);
    if (flags->has_eye || (placed && !flags->has_direction)) {
        const pith_vec3 target = placed ? stated.target : middle;
        return (pith_camera){ flags->has_eye ? flags->eye : stated.eye, flags->has_target ? flags->target : target, up,
                              field_of_view };
    }
    const pith_vec3 direction = flags->has_direction ? flags->direction : stated.eye;
    pith_camera fitted = pith_camera_fit(box, direction, up, field_of_view, aspect);
    if (flags->has_target) { /* the same view of another place */
        fitted.eye = pith_add(fitted.eye, pith_sub(flags->target, fitted.target));
        fitted.target = flags->target;
    }
    return fitted;
}

/* ---- cuts -------------------------------------------------------------------------------------------------------- */

int cli_check_cut(const cli_line *line, const cli_cut *flags)
{
    if (flags->has_plane && flags->has_stroke)
        return cli_misuse(line->verb,
                          "--plane and --stroke are two cuts; give one of them, or write both into the document");
    const char *of_cut = cli_only_of(line, &pith_cut_step_params);
    if (of_cut && !flags->has_plane && !flags->has_stroke)
        return cli_misuse(line->verb, "%s goes with --plane or --stroke; without them the document's own cuts hold",
                          of_cut);
    return CLI_GO_ON;
}

pith_status cli_apply_cut(const cli_line *line, const cli_cut *flags, pith_model *model, pith_error *err)
{
    if (!flags->has_plane && !flags->has_stroke) return PITH_OK;
    pith_cut_step cut;
    pith_params_defaults(&pith_cut_step_params, &cut);
    cli_apply_params(line, &pith_cut_step_params, &cut);
    cut.follow = pith_cut_stroke_options_default();
    if (flags->has_plane) cut.plane = flags->plane;
    else cut.stroke = (pith_cut_stroke){ flags->stroke.eye, flags->stroke.points, flags->stroke.count };
    return pith_model_set_cuts(model, &cut, 1, err);
}
