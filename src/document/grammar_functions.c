/* The grammar of the functions of procedural solids: made once, from what the functions tell of themselves. */
#include <stdio.h>
#include <string.h>

#include "document_internal.h"

static const pith_param stop_items[] = {
    { "at", "1", "the number", PITH_PARAM_DOUBLE, -1e9, 0, 1e9, offsetof(map_stop_value, at), NULL },
    { "opacity", "1", "0 is seen through … 1 opaque", PITH_PARAM_DOUBLE, 0, 1, 1, offsetof(map_stop_value, opacity),
      NULL },
};
const pith_params document_map_stop_params = { "map stop", stop_items, 2, sizeof(map_stop_value) };

static const pith_param wave_items[] = {
    { "amplitude", "1", "how strong it is", PITH_PARAM_DOUBLE, -1e6, 1, 1e6, offsetof(wave_value, amplitude), NULL },
    { "phase", "degree", "how far it is moved along itself", PITH_PARAM_DOUBLE, -1e6, 0, 1e6,
      offsetof(wave_value, phase), NULL },
};
const pith_params document_wave_params = { "wave", wave_items, 2, sizeof(wave_value) };

static const grammar map_stop = {
    "map_stop",
    "A colour and an opacity for a number; between stops both are blended.",
    KEYS({ "colour", VALUE_COLOUR, "the colour there", NULL }),
    &document_map_stop_params,
    NAMES("at", "colour"),
    NULL,
};
static const grammar wave = {
    "wave",
    "One sinusoid of a sum.",
    KEYS({ "frequency", VALUE_POINT, "cycles per model unit along x, y and z", NULL }),
    &document_wave_params,
    NAMES("frequency"),
    NULL,
};

static const struct {
    pith_asset asset;
    grammar_key key;
} asset_keys[] = {
    { PITH_ASSET_IMAGE, { "image", VALUE_FILE, "picture (PNG, JPEG)", NULL } },
    { PITH_ASSET_GRID, { "grid", VALUE_FILE, "voxels (NRRD)", NULL } },
    { PITH_ASSET_STOPS, { "stops", VALUE_LIST, "colours by ascending number", &map_stop } },
    { PITH_ASSET_WAVES, { "waves", VALUE_LIST, "the sinusoids", &wave } },
    { PITH_ASSET_MATRIX, { "matrix", VALUE_MATRIX, "maps the point to where the texture is looked up", NULL } },
};
enum { ASSETS = sizeof asset_keys / sizeof *asset_keys, MOST_KEYS = 20 };

grammar grammar_functions[MOST_FUNCTIONS + 1];
static grammar_key keys[MOST_FUNCTIONS][MOST_KEYS];
static const char *wanted[MOST_FUNCTIONS][MOST_KEYS + 1];

static void tell_function(size_t index, const pith_function *function)
{
    grammar *to = &grammar_functions[index];
    size_t count = 0, must = 0;
    keys[index][count++] = (grammar_key){ "name", VALUE_TEXT, "what other nodes call it", NULL };
    keys[index][count++] = (grammar_key){ "function", VALUE_TEXT, "what it computes: the word above", NULL };
    wanted[index][must++] = "name";
    wanted[index][must++] = "function";
    for (const pith_input *input = function->inputs; input->name; ++input) {
        keys[index][count++] =
            (grammar_key){ input->name, input->many ? VALUE_INPUTS : VALUE_INPUT, input->help, NULL };
        if (input->wanted) wanted[index][must++] = input->name;
    }
    for (size_t k = 0; k < ASSETS; ++k) {
        if (!(function->assets & asset_keys[k].asset)) continue;
        keys[index][count++] = asset_keys[k].key;
        if (!(function->assets & PITH_ASSET_OPTIONAL)) wanted[index][must++] = asset_keys[k].key.name;
    }
    *to = (grammar){ .name = function->name,
                     .help = function->help,
                     .keys = keys[index],
                     .key_count = count,
                     .params = function->params,
                     .required = wanted[index] };
}

/* Before anything is read: the tables never change afterwards. */
__attribute__((constructor)) static void tell_functions(void)
{
    size_t count;
    const pith_function *const *all = pith_functions(&count);
    size_t tables = 0;
    while (document_tables[tables]) ++tables;
    for (size_t i = 0; i < count && i < MOST_FUNCTIONS; ++i) {
        tell_function(i, all[i]);
        if (all[i]->params && tables < MOST_TABLES - 1) document_tables[tables++] = all[i]->params;
    }
}
