/* pith new: a document to start from. Templates are the shipped examples with their recipes written into them, so that
   the new document stands alone; for a mesh, an inside of the texture type asked for. */
#include "new.h"

#include <stdlib.h>
#include <string.h>

static const char *const template_names[] = { "kiwi", "carrot", "tree", "watermelon", "sponge", "tube", "muscle",
                                              "flattened", "bricks", "strata", "cake", "wood", "granite", "marble", "bubbles",
                                              "sketch", NULL };

/* ---- JSON files -------------------------------------------------------------------------------------------------- */

static pith_status load_json(const char *path, json_t **root, pith_error *err)
{
    json_error_t problem;
    *root = json_load_file(path, JSON_REJECT_DUPLICATES, &problem);
    if (*root) return PITH_OK;
    return pith_fail(err, PITH_BAD_FILE, "%s: line %d: %s", path, problem.line, problem.text);
}

/* Checks the document as a reader will, then writes it in the house's layout. */
static pith_status save_checked(const json_t *root, const char *out, pith_error *err)
{
    char *text = json_dumps(root, 0);
    if (!text) return pith_fail(err, PITH_NO_MEMORY, "out of memory for the new document");
    pith_document *document = NULL;
    pith_status status = pith_document_parse(out, text, strlen(text), &document, err);
    free(text);
    if (status == PITH_OK) status = pith_document_save(document, out, err);
    pith_document_destroy(document);
    return status;
}

/* A photograph that the recipe names is copied beside the new document. */
static pith_status copy_strip(json_t *recipe, const char *recipe_path, const char *out, pith_error *err)
{
    const char *strip = json_string_value(json_object_get(recipe, "strip"));
    if (!strip) return PITH_OK;
    const char *slash = strrchr(strip, '/'), *name = slash ? slash + 1 : strip;
    char *from = pith_path_join(recipe_path, strip), *to = pith_path_join(out, name);
    unsigned char *bytes = NULL;
    size_t size;
    pith_status status = from && to ? PITH_OK : pith_fail(err, PITH_NO_MEMORY, "out of memory for a path");
    if (status == PITH_OK) status = pith_file_read(from, &bytes, &size, err);
    if (status == PITH_OK && !pith_file_exists(to)) status = pith_file_write(to, bytes, size, err);
    if (status == PITH_OK) json_object_set_new(recipe, "strip", json_string(name));
    pith_free(bytes);
    pith_free(from);
    pith_free(to);
    return status;
}

/* One exemplar: {"recipe": path} becomes {"layered": recipe}. */
static pith_status inline_recipe(json_t *exemplar, const char *beside, const char *out, pith_error *err)
{
    const char *written = json_string_value(json_object_get(exemplar, "recipe"));
    if (!written) return PITH_OK;
    json_t *recipe = NULL;
    char *path = pith_path_join(beside, written);
    pith_status status = path ? load_json(path, &recipe, err) : pith_fail(err, PITH_NO_MEMORY, "out of memory");
    if (status == PITH_OK) status = copy_strip(recipe, path, out, err);
    pith_free(path);
    if (status == PITH_OK) {
        json_object_del(exemplar, "recipe");
        json_object_set(exemplar, "layered", recipe);
    }
    json_decref(recipe);
    return status;
}

pith_status new_inline_recipes(json_t *root, const char *beside, const char *out, pith_error *err)
{
    size_t i;
    const char *key;
    json_t *inner;
    if (json_is_array(root)) json_array_foreach(root, i, inner) PITH_TRY(new_inline_recipes(inner, beside, out, err));
    if (!json_is_object(root)) return PITH_OK;
    json_t *exemplar = json_object_get(root, "exemplar");
    if (exemplar) PITH_TRY(inline_recipe(exemplar, beside, out, err));
    json_object_foreach(root, key, inner) PITH_TRY(new_inline_recipes(inner, beside, out, err));
    return PITH_OK;
}

static pith_status new_from_template(const char *name, const char *out, pith_error *err)
{
    char file[100], path[1000];
    snprintf(file, sizeof file, "%s.pith", name);
    if (!cli_find_example(file, path, sizeof path))
        return pith_fail(err, PITH_IO, "the template %s is not beside the program nor where its source was", file);
    json_t *root = NULL;
    PITH_TRY(load_json(path, &root, err));
    pith_status status = new_inline_recipes(root, path, out, err);
    if (status == PITH_OK) status = save_checked(root, out, err);
    json_decref(root);
    return status;
}

/* ---- the verb ---------------------------------------------------------------------------------------------------- */

pith_status new_write_for_mesh(const new_wish *wish, pith_error *err)
{
    json_t *root = NULL;
    PITH_TRY(new_for_mesh(wish, &root, err));
    const pith_status status = save_checked(root, wish->out, err);
    json_decref(root);
    return status;
}

/* What OUT is made from: a template, one of the program's shapes, or a file. */
static int check_from(const char *from, bool *is_template)
{
    *is_template = false;
    for (size_t i = 0; template_names[i]; ++i) *is_template |= strcmp(from, template_names[i]) == 0;
    if (*is_template || strcmp(from, "slab") == 0 || strcmp(from, "fruit") == 0 || pith_file_exists(from))
        return CLI_GO_ON;
    const char *near = pith_nearest_word(from, template_names);
    return cli_misuse("new", "\"%s\" is neither a template nor a file%s%s%s", from, near ? "; did you mean \"" : "",
                      near ? near : "", near ? "\"?" : "");
}

static int check_type(const char *word, bool is_template, bool has_size, new_wish *wish)
{
    pith_error err;
    pith_lapped_options options = pith_lapped_options_default();
    if (word && pith_param_set_word(pith_params_find(&pith_lapped_params, "type"), &options, word, &err) != PITH_OK)
        return cli_misuse("new", "%s", err.message);
    if ((word || has_size) && is_template)
        return cli_misuse("new", "--%s goes with a mesh, slab or fruit; a template is what it is",
                          word ? "type" : "size");
    wish->type = options.type;
    if (has_size && (wish->type == PITH_TYPE_1A || wish->type == PITH_TYPE_1B))
        return cli_misuse("new", "--size goes with types 0; of types 1 the depth field says how large the exemplar is");
    return CLI_GO_ON;
}

int verb_new(int argc, char **argv)
{
    bool force = false, has_size = false, is_template;
    const char *type = NULL;
    new_wish wish = { .tetrahedra = NEW_TETRAHEDRA };
    const cli_flag flags[] = {
        { "type", 0, CLI_TEXT, &type, "0-A|..|1-B", "texture type of a mesh's inside; default 1-B", 0, 0, NULL },
        { "size", 0, CLI_NUMBER, &wish.size, "X",
          "edge of the exemplar's cube, types 0; default: half as wide as the body", 1e-9, 1e9, &has_size },
        { "tetrahedra", 0, CLI_WHOLE, &wish.tetrahedra, "N", "of a mesh's inside; default 5000", 50, 20000000, NULL },
        { "force", 'f', CLI_SWITCH, &force, NULL, "replace OUT when it exists", 0, 0, NULL },
    };
    cli_line line = {
        .verb = "new",
        .words = "NAME|slab|fruit|MESH OUT",
        .least_words = 2,
        .most_words = 2,
        .flags = flags,
        .flag_count = sizeof flags / sizeof *flags,
        .summary =
            "Writes a new document: a copy of a template (kiwi, carrot, tree, watermelon, sponge, tube, muscle,\n"
            "flattened, bricks, strata, cake, wood, granite, marble, bubbles), or an inside for a mesh of yours,\n"
            "for a slab or for a fruit:\n"
            "  0-A  sponge, the same everywhere        1-A  watermelon, by depth\n"
            "  0-B  muscle, along the core             1-B  kiwi, by depth and along the core\n"
            "  0-C  flattened fibres, along the core and flat in its layers\n"
            "The core of each component runs along its longest axis. Edit it from there; docs/document.md explains\n"
            "every key.",
    };
    int code = cli_parse(&line, argc, argv);
    if (code != CLI_GO_ON) return code;
    wish.from = line.word[0];
    wish.out = line.word[1];
    code = check_from(wish.from, &is_template);
    if (code == CLI_GO_ON) code = check_type(type, is_template, has_size, &wish);
    if (code != CLI_GO_ON) return code;
    pith_error err;
    if (!force && pith_file_exists(wish.out)) {
        pith_fail(&err, PITH_BAD_ARGUMENT, "%s exists; --force replaces it", wish.out);
        return cli_fail("new", &err);
    }
    const pith_status status = is_template ? new_from_template(wish.from, wish.out, &err) : new_write_for_mesh(&wish, &err);
    return status == PITH_OK ? EXIT_DONE : cli_fail("new", &err);
}
