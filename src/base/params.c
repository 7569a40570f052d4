/* Parameter tables: one row an option, read by checks, documents, help and docs. */
#include "pith/base.h"

#include <stdio.h>
#include <string.h>

double pith_param_get(const pith_param *param, const void *options)
{
    const char *at = (const char *)options + param->offset;
    switch (param->type) {
    case PITH_PARAM_DOUBLE: { double v; memcpy(&v, at, sizeof v); return v; }
    case PITH_PARAM_UINT:
    case PITH_PARAM_CHOICE: { uint32_t v; memcpy(&v, at, sizeof v); return (double)v; }
    case PITH_PARAM_SEED: { uint64_t v; memcpy(&v, at, sizeof v); return (double)v; }
    case PITH_PARAM_BOOL: { bool v; memcpy(&v, at, sizeof v); return v ? 1.0 : 0.0; }
    }
    return NAN;
}

static void store(const pith_param *param, void *options, double value)
{
    char *at = (char *)options + param->offset;
    switch (param->type) {
    case PITH_PARAM_DOUBLE: memcpy(at, &value, sizeof value); break;
    case PITH_PARAM_UINT:
    case PITH_PARAM_CHOICE: { const uint32_t v = (uint32_t)value; memcpy(at, &v, sizeof v); break; }
    case PITH_PARAM_SEED: { const uint64_t v = (uint64_t)value; memcpy(at, &v, sizeof v); break; }
    case PITH_PARAM_BOOL: { const bool v = value != 0.0; memcpy(at, &v, sizeof v); break; }
    }
}

static pith_status check_value(const pith_param *param, double value, pith_error *err)
{
    if (!(value >= param->lowest && value <= param->highest))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s is %.10g, expected %.10g to %.10g (default %.10g)", param->name,
                         value, param->lowest, param->highest, param->standard);
    if (param->type != PITH_PARAM_DOUBLE && value != floor(value))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s is %.10g, expected a whole number from %.10g to %.10g",
                         param->name, value, param->lowest, param->highest);
    return PITH_OK;
}

void pith_params_defaults(const pith_params *table, void *options)
{
    memset(options, 0, table->size);
    for (size_t i = 0; i < table->count; ++i) store(&table->items[i], options, table->items[i].standard);
}

pith_status pith_params_check(const pith_params *table, const void *options, pith_error *err)
{
    for (size_t i = 0; i < table->count; ++i)
        PITH_TRY(check_value(&table->items[i], pith_param_get(&table->items[i], options), err));
    return PITH_OK;
}

const pith_param *pith_params_find(const pith_params *table, const char *name)
{
    for (size_t i = 0; i < table->count; ++i)
        if (strcmp(table->items[i].name, name) == 0) return &table->items[i];
    return NULL;
}

pith_status pith_param_set(const pith_param *param, void *options, double value, pith_error *err)
{
    PITH_TRY(check_value(param, value, err));
    store(param, options, value);
    return PITH_OK;
}

pith_status pith_param_set_word(const pith_param *param, void *options, const char *word, pith_error *err)
{
    if (param->type != PITH_PARAM_CHOICE)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s is \"%s\", expected a number", param->name, word);
    char words[300] = "";
    for (size_t i = 0; param->choices[i]; ++i) {
        if (strcmp(param->choices[i], word) == 0) return pith_param_set(param, options, (double)i, err);
        const size_t length = strlen(words);
        snprintf(words + length, sizeof words - length, "%s%s", i ? ", " : "", param->choices[i]);
    }
    const char *near = pith_nearest_word(word, param->choices);
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s is \"%s\", expected one of %s%s%s%s", param->name, word, words,
                     near ? "; did you mean \"" : "", near ? near : "", near ? "\"?" : "");
}

/* Levenshtein distance of words of at most 63 letters; longer ones count as far away. */
static size_t edit_distance(const char *a, const char *b)
{
    const size_t la = strlen(a), lb = strlen(b);
    size_t row[64];
    if (la > 63 || lb > 63) return SIZE_MAX;
    for (size_t j = 0; j <= lb; ++j) row[j] = j;
    for (size_t i = 1; i <= la; ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= lb; ++j) {
            const size_t change = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            const size_t shift = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            row[j] = change < shift ? change : shift;
        }
    }
    return row[lb];
}

const char *pith_nearest_word(const char *word, const char *const *candidates)
{
    const char *best = NULL;
    size_t best_distance = SIZE_MAX;
    for (size_t i = 0; candidates[i]; ++i) {
        const size_t distance = edit_distance(word, candidates[i]);
        if (distance < best_distance) best = candidates[i], best_distance = distance;
    }
    /* Farther than half the word's letters is no help but a riddle. */
    return best && best_distance <= (strlen(word) + 1) / 2 ? best : NULL;
}
