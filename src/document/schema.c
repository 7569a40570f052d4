/* The grammar told to others: as a JSON Schema (draft 2020-12) for editors and validators, and as the Markdown tables
   of docs/document.md for people. */
#include <stdio.h>
#include <string.h>

#include "document_internal.h"

/* ---- JSON Schema ------------------------------------------------------------------------------------------------------ */

/* Every value goes through put or append, which remember when memory ran out; the caller looks once, at the end. Every
   object but the document itself is written once, under its name in "$defs", and referred to. */
enum { MOST_GRAMMARS = 192 };
typedef struct schema_maker {
    bool failed;
    json_t *definitions;
    const grammar *known[MOST_GRAMMARS];
    size_t known_count;
} schema_maker;

static json_t *schema_of(schema_maker *maker, const grammar *rules);

static void put(schema_maker *maker, json_t *object, const char *name, json_t *value)
{
    if (json_object_set_new(object, name, value) != 0) maker->failed = true;
}

static void append(schema_maker *maker, json_t *list, json_t *value)
{
    if (json_array_append_new(list, value) != 0) maker->failed = true;
}

static json_t *option_schema(schema_maker *maker, const pith_param *param)
{
    json_t *schema = json_object();
    if (strcmp(param->unit, "1") == 0) put(maker, schema, "description", json_string(param->help));
    else put(maker, schema, "description", json_sprintf("%s (%s)", param->help, param->unit));
    if (param->type == PITH_PARAM_BOOL) {
        put(maker, schema, "type", json_string("boolean"));
        put(maker, schema, "default", json_boolean(param->standard != 0.0));
        return schema;
    }
    if (param->type == PITH_PARAM_CHOICE) {
        json_t *words = json_array();
        for (size_t i = 0; param->choices[i]; ++i) append(maker, words, json_string(param->choices[i]));
        put(maker, schema, "enum", words);
        put(maker, schema, "default", json_string(param->choices[(size_t)param->standard]));
        return schema;
    }
    put(maker, schema, "type", json_string(param->type == PITH_PARAM_DOUBLE ? "number" : "integer"));
    const char *const names[3] = { "minimum", "maximum", "default" };
    const double values[3] = { param->lowest, param->highest, param->standard };
    for (int i = 0; i < 3; ++i) {
        const bool whole = fabs(values[i]) <= 0x1p53 && values[i] == floor(values[i]);
        put(maker, schema, names[i], whole ? json_integer((json_int_t)values[i]) : json_real(values[i]));
    }
    return schema;
}

static json_t *point_schema(void)
{
    return json_pack("{ss s{ss} si si}", "type", "array", "items", "type", "number", "minItems", 3, "maxItems", 3);
}

static json_t *pair_schema(void)
{
    return json_pack("{ss s{ss} si si}", "type", "array", "items", "type", "number", "minItems", 2, "maxItems", 2);
}

static json_t *list_schema(json_t *items, int least)
{
    return json_pack("{ss so si}", "type", "array", "items", items, "minItems", least);
}

static json_t *input_schema(void) { return json_pack("{s[ss]}", "type", "string", "number"); }

/* Functions and kinds of surfaces are called as other objects are, too. */
static json_t *name_of(const grammar *rules)
{
    for (const grammar *surface = grammar_surfaces; surface->name; ++surface)
        if (rules == surface) return json_sprintf("surface_%s", rules->name);
    const bool function = rules >= grammar_functions && rules < grammar_functions + MOST_FUNCTIONS;
    return function ? json_sprintf("function_%s", rules->name) : json_string(rules->name);
}

/* A reference to the object's definition, which is made when it is not there yet. The word of a kind is fixed in it. */
static json_t *reference(schema_maker *maker, const grammar *rules, bool is_kind)
{
    json_t *name = name_of(rules);
    size_t at = 0;
    while (at < maker->known_count && maker->known[at] != rules) ++at;
    if (at == maker->known_count) {
        json_t *made = schema_of(maker, rules);
        if (is_kind)
            put(maker, json_object_get(json_object_get(made, "properties"), kinds_word(rules)), "const",
                json_string(rules->name));
        /* Two grammars of one name, or too many: the schema would be wrong. */
        if (maker->known_count == MOST_GRAMMARS || json_object_get(maker->definitions, json_string_value(name)))
            maker->failed = true;
        else maker->known[maker->known_count++] = rules;
        put(maker, maker->definitions, json_string_value(name), made);
    }
    json_t *to = json_pack("{s: s+}", "$ref", "#/$defs/", json_string_value(name));
    json_decref(name);
    return to;
}

static json_t *kinds_schema(schema_maker *maker, const grammar *kinds)
{
    json_t *all = json_array();
    for (size_t i = 0; kinds[i].name; ++i) append(maker, all, reference(maker, &kinds[i], true));
    return json_pack("{ss s{so}}", "type", "array", "items", "oneOf", all);
}

/* What is like something else need not be complete: all that can be said is that it is an object. */
static json_t *entry_schema(schema_maker *maker, const grammar *rules)
{
    json_t *complete = reference(maker, rules, false);
    for (size_t i = 0; i < rules->key_count; ++i)
        if (strcmp(rules->keys[i].name, "like") == 0)
            return json_pack("{s{s[s]} s{ss} so}", "if", "required", "like", "then", "type", "object", "else", complete);
    return complete;
}

static json_t *value_schema(schema_maker *maker, const grammar_key *key)
{
    switch (key->kind) {
    case VALUE_VERSION: return json_pack("{si}", "const", 1);
    case VALUE_TEXT:
    case VALUE_FILE:
    case VALUE_RECIPE: return json_pack("{ss si}", "type", "string", "minLength", 1);
    case VALUE_COLOUR: return json_pack("{ss ss}", "type", "string", "pattern", "^#[0-9a-fA-F]{6}$");
    case VALUE_POINT: return point_schema();
    case VALUE_POINTS: return list_schema(point_schema(), 1);
    case VALUE_LINE: return list_schema(point_schema(), 2);
    case VALUE_LINES: return list_schema(list_schema(point_schema(), 2), 1);
    case VALUE_CURVE: return list_schema(pair_schema(), 2);
    case VALUE_CURVES: return list_schema(list_schema(pair_schema(), 2), 1);
    case VALUE_NAMES:
        return json_pack("{ss s{ss si} si sb}", "type", "array", "items", "type", "string", "minLength", 1, "minItems", 1,
                         "uniqueItems", 1);
    case VALUE_FACES:
        return json_pack("{s[{ss} o]}", "oneOf", "const", "all",
                         list_schema(json_pack("{ss si}", "type", "integer", "minimum", 0), 1));
    case VALUE_SIZES:
        return json_pack("{ss s{ss si si} si si}", "type", "array", "items", "type", "integer", "minimum", 8, "maximum",
                         256, "minItems", 3, "maxItems", 3);
    case VALUE_INDEX: return json_pack("{ss si}", "type", "integer", "minimum", 0);
    case VALUE_FLAG: return json_pack("{ss}", "type", "boolean");
    case VALUE_MATRIX:
        return json_pack("{ss s{ss s{ss} si si} si si}", "type", "array", "items", "type", "array", "items", "type",
                         "number", "minItems", 4, "maxItems", 4, "minItems", 3, "maxItems", 4);
    case VALUE_INPUT: return input_schema();
    case VALUE_INPUTS: return json_pack("{s[oo]}", "anyOf", input_schema(), list_schema(input_schema(), 1));
    case VALUE_ANY: return json_object();
    case VALUE_OBJECT: return reference(maker, key->inner, false);
    case VALUE_LIST: return list_schema(entry_schema(maker, key->inner), 0);
    case VALUE_KINDS: return kinds_schema(maker, key->inner);
    }
    return NULL;
}

/* The names as they are, or as alternatives of which one is required. */
static json_t *names_schema(schema_maker *maker, const char *const *names, bool alternatives)
{
    json_t *list = json_array();
    for (size_t i = 0; names[i]; ++i)
        append(maker, list, alternatives ? json_pack("{s[s]}", "required", names[i]) : json_string(names[i]));
    return list;
}

static json_t *schema_of(schema_maker *maker, const grammar *rules)
{
    json_t *properties = json_object();
    for (size_t i = 0; i < rules->key_count; ++i) {
        json_t *value = value_schema(maker, &rules->keys[i]);
        put(maker, value, "description", json_string(rules->keys[i].help));
        put(maker, properties, rules->keys[i].name, value);
    }
    for (size_t i = 0; rules->params && i < rules->params->count; ++i)
        put(maker, properties, rules->params->items[i].name, option_schema(maker, &rules->params->items[i]));
    json_t *schema = json_object();
    put(maker, schema, "type", json_string("object"));
    put(maker, schema, "description", json_string(rules->help));
    put(maker, schema, "properties", properties);
    put(maker, schema, "additionalProperties", json_false());
    if (rules->required) put(maker, schema, "required", names_schema(maker, rules->required, false));
    if (rules->one_of) put(maker, schema, "oneOf", names_schema(maker, rules->one_of, true));
    return schema;
}

static pith_status give_text(text_buffer *buffer, char **text, const char *what, pith_error *err)
{
    if (buffer->failed) {
        pith_free(buffer->text);
        return PITH_OUT_OF_MEMORY(err, what);
    }
    *text = buffer->text;
    return PITH_OK;
}

pith_status pith_document_schema(char **text, pith_error *err)
{
    schema_maker maker = { .definitions = json_object() };
    json_t *root = json_pack("{ss ss}", "$schema", "https://json-schema.org/draft/2020-12/schema", "title",
                             "A pith document, version 1");
    json_t *schema = schema_of(&maker, &grammar_document);
    const bool good = !maker.failed && json_object_update(root, schema) == 0 &&
                      json_object_set(root, "$defs", maker.definitions) == 0;
    text_buffer buffer = { .failed = !good };
    if (good) text_add_json(&buffer, root, 0);
    text_add(&buffer, "\n");
    json_decref(maker.definitions);
    json_decref(schema);
    json_decref(root);
    return give_text(&buffer, text, "the schema", err);
}

/* ---- Markdown ----------------------------------------------------------------------------------------------------------- */

static const char *word_of(value_kind kind)
{
    switch (kind) {
    case VALUE_VERSION: return "1";
    case VALUE_TEXT: return "text";
    case VALUE_FILE: return "path of a file";
    case VALUE_RECIPE: return "path of a recipe";
    case VALUE_COLOUR: return "`\"#rrggbb\"`";
    case VALUE_POINT: return "`[x, y, z]`";
    case VALUE_POINTS: return "list of points";
    case VALUE_LINE: return "list of two or more points";
    case VALUE_LINES: return "list of lists of points";
    case VALUE_CURVE: return "list of two or more `[a, b]`";
    case VALUE_CURVES: return "list of lists of `[a, b]`";
    case VALUE_NAMES: return "list of names";
    case VALUE_FACES: return "`\"all\"` or list of indices";
    case VALUE_SIZES: return "`[r, s, t]`";
    case VALUE_INDEX: return "whole number from 0";
    case VALUE_FLAG: return "true or false";
    case VALUE_MATRIX: return "rows of a matrix";
    case VALUE_INPUT: return "node, number or colour";
    case VALUE_INPUTS: return "node, number or colour, or list of these";
    case VALUE_ANY: return "any JSON";
    case VALUE_OBJECT: return "object";
    case VALUE_LIST: return "list of objects";
    case VALUE_KINDS: return "list of objects by kind";
    }
    return "";
}

static bool among(const char *name, const char *const *names)
{
    for (size_t i = 0; names && names[i]; ++i)
        if (strcmp(names[i], name) == 0) return true;
    return false;
}

static void add_option(text_buffer *out, const grammar *rules, const pith_param *param)
{
    text_add(out, "| `%s` | ", param->name);
    if (param->type == PITH_PARAM_BOOL) text_add(out, "true or false");
    for (size_t i = 0; param->type == PITH_PARAM_CHOICE && param->choices[i]; ++i)
        text_add(out, "%s`\"%s\"`", i ? ", " : "", param->choices[i]);
    if (param->type != PITH_PARAM_BOOL && param->type != PITH_PARAM_CHOICE) {
        text_add(out, "%.10g … %.10g", param->lowest, param->highest);
        if (strcmp(param->unit, "1") != 0) text_add(out, " %s", param->unit);
    }
    text_add(out, " | ");
    if (among(param->name, rules->required)) text_add(out, "must be given");
    else if (param->type == PITH_PARAM_BOOL) text_add(out, "%s", param->standard != 0.0 ? "true" : "false");
    else if (param->type == PITH_PARAM_CHOICE) text_add(out, "`\"%s\"`", param->choices[(size_t)param->standard]);
    else text_add(out, "%.10g", param->standard);
    text_add(out, " | %s |\n", param->help);
}

/* Where each object is described: at the first place it may stand. */
typedef struct described { const grammar *rules; char path[200]; } described;
typedef struct keys_maker { text_buffer *out; described seen[MOST_GRAMMARS]; size_t count; } keys_maker;

static const char *seen_at(const keys_maker *maker, const grammar *rules)
{
    for (size_t i = 0; i < maker->count; ++i)
        if (maker->seen[i].rules == rules) return maker->seen[i].path;
    return NULL;
}

static void inner_path(const char *path, const grammar_key *key, char inner[200])
{
    snprintf(inner, 200, "%s%s%s%s", path, path[0] ? "." : "", key->name, key->kind == VALUE_OBJECT ? "" : "[]");
}

static void add_key(const keys_maker *maker, const grammar *rules, const grammar_key *key, const char *path)
{
    const char *need = among(key->name, rules->required) ? "must be given"
                       : among(key->name, rules->one_of) ? "one of these"
                                                         : "";
    char inner[200];
    inner_path(path, key, inner);
    const char *elsewhere = key->inner ? seen_at(maker, key->inner) : NULL;
    text_add(maker->out, "| `%s` | %s", key->name, word_of(key->kind));
    if (elsewhere && strcmp(elsewhere, inner) != 0) text_add(maker->out, ", see `%s`", elsewhere);
    text_add(maker->out, " | %s | %s |\n", need, key->help);
}

/* One table for the object at path ("" is the document itself), then those of the objects in it. */
static void add_section(keys_maker *maker, const grammar *rules, const char *path, bool is_kind)
{
    text_buffer *out = maker->out;
    if (maker->count == MOST_GRAMMARS) out->failed = true;
    if (out->failed) return;
    described *here = &maker->seen[maker->count++];
    here->rules = rules;
    snprintf(here->path, sizeof here->path, "%s", path);
    if (!path[0]) text_add(out, "### The document");
    else text_add(out, "\n### `%s`", path);
    if (is_kind) text_add(out, " of %s \"%s\"", kinds_word(rules), rules->name);
    text_add(out, "\n\n%s\n\n| key | value | default | |\n| --- | --- | --- | --- |\n", rules->help);
    for (size_t i = 0; i < rules->key_count; ++i) add_key(maker, rules, &rules->keys[i], path);
    for (size_t i = 0; rules->params && i < rules->params->count; ++i) add_option(out, rules, &rules->params->items[i]);

    for (size_t i = 0; i < rules->key_count; ++i) {
        const grammar_key *key = &rules->keys[i];
        char inner[200];
        inner_path(path, key, inner);
        if (!key->inner || seen_at(maker, key->inner)) continue;
        if (key->kind != VALUE_KINDS) add_section(maker, key->inner, inner, false);
        for (size_t k = 0; key->kind == VALUE_KINDS && key->inner[k].name; ++k)
            add_section(maker, &key->inner[k], inner, true);
    }
}

pith_status pith_document_keys(char **text, pith_error *err)
{
    text_buffer out = { 0 };
    keys_maker maker = { .out = &out };
    add_section(&maker, &grammar_document, "", false);
    return give_text(&out, text, "the keys", err);
}

/* Every operation in a section of its own; objects that documents have too are described there. */
pith_status pith_document_operations(char **text, pith_error *err)
{
    text_buffer document = { 0 }, out = { 0 };
    keys_maker maker = { .out = &document };
    add_section(&maker, &grammar_document, "", false);
    maker.out = &out;
    for (const document_operation *next = document_operations; next->rules.name; ++next)
        add_section(&maker, &next->rules, next->rules.name, false);
    if (document.failed) out.failed = true;
    pith_free(document.text);
    return give_text(&out, text, "the operations", err);
}
