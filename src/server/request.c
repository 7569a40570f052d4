/* Requests against the table of verbs. */
#include "request.h"

#include <stdio.h>
#include <string.h>

enum { LONGEST_TEXT = 4000, MOST_NAMES = 40 };

/* ---- one argument ------------------------------------------------------------------------------------------------ */

static pith_status check_text(const argument *rule, const json_t *value, pith_error *err)
{
    const size_t longest = rule->highest > 0 ? (size_t)rule->highest : LONGEST_TEXT;
    if (!json_is_string(value)) return pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected a text", rule->name);
    const char *text = json_string_value(value);
    if (json_string_length(value) > longest)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: has %zu bytes, expected at most %zu", rule->name,
                         json_string_length(value), longest);
    for (size_t i = 0; rule->words && rule->words[i]; ++i)
        if (strcmp(rule->words[i], text) == 0) return PITH_OK;
    if (!rule->words) return PITH_OK;
    char list[300] = "";
    for (size_t i = 0; rule->words[i]; ++i)
        snprintf(list + strlen(list), sizeof list - strlen(list), "%s%s", i ? ", " : "", rule->words[i]);
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: is \"%.100s\", expected one of %s", rule->name, text, list);
}

static pith_status check_number(const argument *rule, const json_t *value, pith_error *err)
{
    const bool whole = rule->kind == ARGUMENT_WHOLE;
    if (!(whole ? json_is_integer(value) : json_is_number(value)))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected a %snumber", rule->name, whole ? "whole " : "");
    const double number = json_number_value(value);
    if (number >= rule->lowest && number <= rule->highest) return PITH_OK;
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: is %g, expected %g to %g", rule->name, number, rule->lowest,
                     rule->highest);
}

static pith_status check_argument(const argument *rule, const json_t *value, pith_error *err)
{
    switch (rule->kind) {
    case ARGUMENT_TEXT: return check_text(rule, value, err);
    case ARGUMENT_NUMBER:
    case ARGUMENT_WHOLE: return check_number(rule, value, err);
    case ARGUMENT_SWITCH:
        return json_is_boolean(value) ? PITH_OK
                                      : pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected true or false", rule->name);
    case ARGUMENT_POINT:
        for (size_t i = 0; i < 3; ++i)
            if (json_array_size(value) != 3 || !json_is_number(json_array_get(value, i)))
                return pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected [x, y, z]", rule->name);
        return PITH_OK;
    case ARGUMENT_OBJECT:
        return json_is_object(value) ? PITH_OK
                                     : pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected an object", rule->name);
    case ARGUMENT_LIST:
        return json_is_array(value) ? PITH_OK : pith_fail(err, PITH_BAD_ARGUMENT, "%s: expected a list", rule->name);
    }
    return PITH_OK;
}

/* ---- the whole request ------------------------------------------------------------------------------------------- */

static const verb *find_verb(const verb *verbs, const char *name, const char **near)
{
    const char *names[MOST_NAMES + 1] = { NULL };
    for (size_t i = 0; verbs[i].name; ++i) {
        if (strcmp(verbs[i].name, name) == 0) return &verbs[i];
        if (i < MOST_NAMES) names[i] = verbs[i].name;
    }
    *near = pith_nearest_word(name, names);
    return NULL;
}

static pith_status unknown_key(const verb *found, const char *key, pith_error *err)
{
    const char *names[MOST_NAMES + 1] = { NULL };
    for (size_t i = 0; found->arguments[i].name && i < MOST_NAMES; ++i) names[i] = found->arguments[i].name;
    const char *near = pith_nearest_word(key, names);
    return pith_fail(err, PITH_BAD_ARGUMENT, "%.100s: is no key of \"%s\"%s%s%s", key, found->name,
                     near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

static bool is_own_key(const char *key)
{
    return strcmp(key, "id") == 0 || strcmp(key, "do") == 0 || strcmp(key, "arrays") == 0 || strcmp(key, "kind") == 0;
}

pith_status request_check(const verb *verbs, request *asked, const verb **found, pith_error *err)
{
    const json_t *id = json_object_get(asked->body, "id"), *name = json_object_get(asked->body, "do");
    if (!json_is_integer(id) || json_integer_value(id) < 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "id: expected a whole number from 1");
    asked->id = json_integer_value(id);
    if (!json_is_string(name)) return pith_fail(err, PITH_BAD_ARGUMENT, "do: expected what is to be done, a text");
    const char *near = NULL;
    const verb *known = find_verb(verbs, json_string_value(name), &near);
    if (!known)
        return pith_fail(err, PITH_BAD_ARGUMENT, "do: there is no \"%.60s\"%s%s%s", json_string_value(name),
                         near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
    if (known->upload != (asked->upload != NULL))
        return pith_fail(err, PITH_BAD_ARGUMENT, "do: \"%s\" is asked by a %s message", known->name,
                         known->upload ? "binary" : "text");
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)asked->body, key, value) {
        const argument *rule = known->arguments;
        while (rule->name && strcmp(rule->name, key) != 0) ++rule;
        if (rule->name) PITH_TRY(check_argument(rule, value, err));
        else if (!known->open && !is_own_key(key)) return unknown_key(known, key, err);
    }
    for (const argument *rule = known->arguments; rule->name; ++rule)
        if (rule->needed && !json_object_get(asked->body, rule->name))
            return pith_fail(err, PITH_BAD_ARGUMENT, "%s: is missing from \"%s\"", rule->name, known->name);
    *found = known;
    return PITH_OK;
}

const char *request_text(const request *asked, const char *name, const char *standard)
{
    const json_t *value = json_object_get(asked->body, name);
    return value ? json_string_value(value) : standard;
}

double request_number(const request *asked, const char *name, double standard)
{
    const json_t *value = json_object_get(asked->body, name);
    return value ? json_number_value(value) : standard;
}

bool request_switch(const request *asked, const char *name, bool standard)
{
    const json_t *value = json_object_get(asked->body, name);
    return value ? json_is_true(value) : standard;
}

/* ---- answers ----------------------------------------------------------------------------------------------------- */

packet *request_success(json_int_t id, json_t *keys)
{
    json_t *answer = json_pack("{sI sb}", "id", id, "ok", 1);
    if (keys) json_object_update(answer, keys);
    json_decref(keys);
    packet *made = NULL;
    packet_of_json(answer, &made, NULL);
    return made;
}

packet *request_failure(json_int_t id, const char *status, const char *message)
{
    packet *made = NULL;
    packet_of_json(json_pack("{sI sb ss so}", "id", id, "ok", 0, "status", status, "message", sentence_json(message)),
                   &made, NULL);
    return made;
}
