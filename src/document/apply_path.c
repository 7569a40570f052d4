/* Setting and removing any key: the path is the place as refusals print it, "solids[0].exemplar". */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "apply_internal.h"

/* One step of a path: a key of an object, or an index into a list. */
typedef struct path_step {
    char key[100];
    size_t index;
    bool is_index;
    size_t end;             /* how much of the path has been read after it */
} path_step;

/* Reads the step behind `from` characters of the path. */
static pith_status read_step(const edit *at, const char *path, size_t from, path_step *step)
{
    static const char example[] = "expected keys and indices such as solids[0].exemplar";
    const char *text = path + from;
    step->is_index = from > 0 && *text == '[';
    if (step->is_index) {
        char *end;
        const bool digit = text[1] >= '0' && text[1] <= '9';
        step->index = strtoul(text + 1, &end, 10);
        if (!digit || *end != ']') return edit_refuse(at, "path", "is \"%.100s\", %s", path, example);
        step->end = (size_t)(end + 1 - path);
    } else {
        if (from > 0 && *text == '.') ++text;
        else if (from > 0) return edit_refuse(at, "path", "is \"%.100s\", %s", path, example);
        const size_t length = strcspn(text, ".[]");
        if (length == 0 || length >= sizeof step->key || text[length] == ']')
            return edit_refuse(at, "path", "is \"%.100s\", %s", path, example);
        memcpy(step->key, text, length);
        step->key[length] = 0;
        step->end = (size_t)(text + length - path);
    }
    return PITH_OK;
}

static json_t *at_step(json_t *holder, const path_step *step)
{
    return step->is_index ? json_array_get(holder, step->index) : json_object_get(holder, step->key);
}

/* Is the holder what the step goes into? `length` characters of the path lead to the holder. */
static pith_status check_holder(const edit *at, const char *path, size_t length, const json_t *holder,
                                const path_step *step)
{
    const bool good = step->is_index ? json_is_array(holder) : json_is_object(holder);
    if (good) return PITH_OK;
    return edit_refuse(at, "path", "%.*s is no %s", (int)length, path, step->is_index ? "list" : "object");
}

static pith_status put_step(edit *at, const char *path, json_t *holder, const path_step *step, json_t *value)
{
    if (!step->is_index) {
        edit_put(at, holder, step->key, value);
        return PITH_OK;
    }
    const size_t count = json_array_size(holder);
    if (step->index > count) {
        json_decref(value);
        return edit_refuse(at, "path", "%.*s is not there: the list has %zu, and one after the last appends",
                           (int)step->end, path, count);
    }
    const bool done = step->index == count ? json_array_append_new(holder, value) == 0
                                           : json_array_set_new(holder, step->index, value) == 0;
    if (!done) at->failed = true;
    return PITH_OK;
}

/* Follows all of the path but its last step: that one, and the object or list it goes into. With `make`, objects and
   lists on the way that are missing are made. */
static pith_status walk(edit *at, const char *path, bool make, json_t **holder, path_step *last)
{
    json_t *here = at->root;
    path_step step, next;
    PITH_TRY(read_step(at, path, 0, &step));
    while (path[step.end]) {
        PITH_TRY(read_step(at, path, step.end, &next));
        json_t *child = at_step(here, &step);
        if (!child && make) {
            PITH_TRY(put_step(at, path, here, &step, next.is_index ? json_array() : json_object()));
            child = at_step(here, &step);
            if (!child) return PITH_OUT_OF_MEMORY(at->in.err, "a key");
        }
        if (!child) return edit_refuse(at, "path", "there is no %.*s", (int)step.end, path);
        PITH_TRY(check_holder(at, path, step.end, child, &next));
        here = child;
        step = next;
    }
    *holder = here;
    *last = step;
    return PITH_OK;
}

pith_status apply_set(edit *at)
{
    const char *path = json_string_value(json_object_get(at->asked, "path"));
    json_t *holder;
    path_step step;
    PITH_TRY(walk(at, path, true, &holder, &step));
    at->loose = true;
    return put_step(at, path, holder, &step, json_deep_copy(json_object_get(at->asked, "value")));
}

pith_status apply_remove(edit *at)
{
    const char *path = json_string_value(json_object_get(at->asked, "path"));
    json_t *holder;
    path_step step;
    PITH_TRY(walk(at, path, false, &holder, &step));
    if (!at_step(holder, &step)) return edit_refuse(at, "path", "there is no %s", path);
    at->loose = true;
    if (step.is_index) json_array_remove(holder, step.index);
    else json_object_del(holder, step.key);
    return PITH_OK;
}
