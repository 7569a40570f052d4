/* Hiding pieces, moving them, and taking that back. An operation is about the piece as it is after all the cuts there
   are, and the entry it makes says so: later cuts leave it alone. */
#include "apply_internal.h"

/* Is an entry about this piece: the same point after the same cuts (left out: all), and of the same body? */
static bool is_about(const edit *at, const json_t *entry, const json_t *wanted)
{
    const json_t *after = json_object_get(entry, "after");
    const json_t *bodies[2] = { json_object_get(entry, "body"), json_object_get(wanted, "body") };
    if (after && !json_equal(after, json_object_get(wanted, "after"))) return false;
    if ((bodies[0] || bodies[1]) && !json_equal(bodies[0], bodies[1])) return false;
    return edit_same_place(json_object_get(entry, "at"), json_object_get(at->asked, "at"));
}

/* The entry of the operation's piece, made when there is none; NULL after a failure. */
static json_t *entry_of(edit *at)
{
    json_t *wanted = json_pack("{sO sI}", "at", json_object_get(at->asked, "at"), "after",
                               (json_int_t)json_array_size(json_object_get(at->root, "cuts")));
    json_t *body = json_object_get(at->asked, "body"), *list = edit_child(at, at->root, "parts", json_array);
    if (!wanted) at->failed = true;
    if (body) edit_put(at, wanted, "body", json_incref(body));
    for (size_t i = 0; i < json_array_size(list); ++i) {
        json_t *entry = json_array_get(list, i);
        if (!is_about(at, entry, wanted)) continue;
        json_decref(wanted);
        return entry;
    }
    edit_append(at, list, wanted);
    return at->failed ? NULL : wanted;
}

/* Entries that say nothing more go, and the list with the last. */
static void drop_empty(edit *at)
{
    json_t *list = json_object_get(at->root, "parts");
    for (size_t i = json_array_size(list); i-- > 0;) {
        const json_t *entry = json_array_get(list, i);
        if (!json_object_get(entry, "hidden") && !json_object_get(entry, "offset")) json_array_remove(list, i);
    }
    if (json_array_size(list) == 0) json_object_del(at->root, "parts");
}

/* Takes the key out of all entries. */
static void drop_key(edit *at, const char *key)
{
    json_t *list = json_object_get(at->root, "parts");
    for (size_t i = 0; i < json_array_size(list); ++i) json_object_del(json_array_get(list, i), key);
    drop_empty(at);
}

pith_status apply_part_hide(edit *at)
{
    json_t *entry = entry_of(at);
    if (entry) edit_put(at, entry, "hidden", json_true());
    return PITH_OK;
}

/* Does an entry other than this one hide anything? */
static bool others_hide(const edit *at, const json_t *entry)
{
    const json_t *list = json_object_get(at->root, "parts");
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *other = json_array_get(list, i);
        if (other != entry && json_is_true(json_object_get(other, "hidden"))) return true;
    }
    return false;
}

/* A piece that was cut from a hidden one is hidden because that is: then it is said that this one is not. */
pith_status apply_part_show(edit *at)
{
    const json_t *all = json_object_get(at->asked, "all");
    if (json_is_false(all)) return edit_refuse(at, "all", "is false, expected true, or \"at\" instead");
    if (all) {
        drop_key(at, "hidden");
        return PITH_OK;
    }
    json_t *entry = entry_of(at);
    if (!entry) return PITH_OK;
    if (others_hide(at, entry)) edit_put(at, entry, "hidden", json_false());
    else json_object_del(entry, "hidden");
    drop_empty(at);
    return PITH_OK;
}

pith_status apply_part_move(edit *at)
{
    const json_t *offset = json_object_get(at->asked, "offset");
    json_t *entry = entry_of(at);
    if (!entry) return PITH_OK;
    if (pith_length(json_point(offset)) > 0.0) edit_put(at, entry, "offset", json_deep_copy(offset));
    else json_object_del(entry, "offset");
    drop_empty(at);
    return PITH_OK;
}

pith_status apply_part_together(edit *at)
{
    drop_key(at, "offset");
    return PITH_OK;
}

void edit_forget_cut(edit *at, size_t index)
{
    json_t *list = json_object_get(at->root, "parts");
    for (size_t i = json_array_size(list); i-- > 0;) {
        json_t *entry = json_array_get(list, i);
        const json_int_t after = json_integer_value(json_object_get(entry, "after")), cut = (json_int_t)index + 1;
        if (after == cut) json_array_remove(list, i);
        if (after > cut) edit_put(at, entry, "after", json_integer(after - 1));
    }
    drop_empty(at);
}
