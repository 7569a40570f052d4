/* Surfaces that colours flow between, as an editor draws them: their curves, their paint, what is erased (Takayama 2011,
   §6.3). */
#include <string.h>

#include "apply_internal.h"

/* ---- which surface, which curve --------------------------------------------------------------------------------------- */

static pith_status find_surface(const edit *at, json_t **surface)
{
    const json_t *list = json_object_get(at->body, "surfaces");
    const char *name = json_string_value(json_object_get(at->asked, "surface"));
    for (size_t i = 0; i < json_array_size(list); ++i) {
        *surface = json_array_get(list, i);
        if (strcmp(json_string_value(json_object_get(*surface, "name")), name) == 0) return PITH_OK;
    }
    if (json_array_size(list) == 0)
        return edit_refuse(at, "surface", "is \"%.60s\", but the body has no surfaces of its own", name);
    return edit_refuse_name(at, "surface", "surface", name, list);
}

/* A curve of a surface in the document: the list of its points, and what says whether it is closed. */
typedef struct curve_place {
    json_t *holder;             /* the object or list it is in */
    const char *key;            /* of an object */
    size_t index;               /* of a list */
    bool closed, vertical;
} curve_place;

static json_t *curve_at(const curve_place *place)
{
    return place->key ? json_object_get(place->holder, place->key) : json_array_get(place->holder, place->index);
}

/* Where the asked curve is or, with `make`, will be. */
static pith_status find_curve(edit *at, bool make, curve_place *place)
{
    json_t *surface = NULL;
    PITH_TRY(find_surface(at, &surface));
    const char *kind = json_string_value(json_object_get(surface, "kind"));
    const json_t *pane = json_object_get(at->asked, "pane"), *index = json_object_get(at->asked, "index");
    const bool chambers = strcmp(kind, "chambers") == 0;
    if (!chambers && strcmp(kind, "around") != 0)
        return edit_refuse(at, "surface", "is of kind \"%s\", which has no curves", kind);
    *place = (curve_place){ .holder = surface, .key = "vertical", .vertical = true,
                            .closed = chambers || json_is_true(json_object_get(surface, "closed")) };
    if (pane && strcmp(json_string_value(pane), "horizontal") == 0) {
        *place = (curve_place){ .holder = surface, .key = "horizontal", .closed = true };
        if (chambers) {
            *place = (curve_place){ .holder = edit_child(at, surface, "horizontals", json_array), .closed = true };
            place->index = index ? (size_t)json_integer_value(index) : 0;
        }
    }
    const size_t count = place->key ? 1 : json_array_size(place->holder);
    if (index && place->key && json_integer_value(index) > 0)
        return edit_refuse(at, "index", "is %" JSON_INTEGER_FORMAT ", but there is one curve, 0",
                           json_integer_value(index));
    if (place->index > count || (place->index == count && !make))
        return edit_refuse(at, "index", "is %zu, but there %s %zu, counted from 0%s", place->index,
                           count == 1 ? "is" : "are", count, make ? "; the next one appends" : "");
    if (!make && !curve_at(place)) return edit_refuse(at, "pane", "has no curve of this surface yet; draw one first");
    return PITH_OK;
}

/* The points of a curve out of JSON, [count]; the caller frees them. */
static pith_status read_points(const edit *at, const json_t *list, pith_vec2 **points, size_t *count)
{
    *count = json_array_size(list);
    *points = pith_alloc(*count, sizeof **points);
    if (!*points) return PITH_OUT_OF_MEMORY(at->in.err, "a curve");
    for (size_t i = 0; i < *count; ++i) {
        const json_t *point = json_array_get(list, i);
        (*points)[i] = (pith_vec2){ json_number_value(json_array_get(point, 0)),
                                    json_number_value(json_array_get(point, 1)) };
    }
    return PITH_OK;
}

static void write_points(edit *at, const curve_place *place, const pith_vec2 *points, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) edit_append(at, list, json_pack("[ff]", points[i].x, points[i].y));
    if (place->key) edit_put(at, place->holder, place->key, list);
    else if (place->index == json_array_size(place->holder)) edit_append(at, place->holder, list);
    else if (json_array_set_new(place->holder, place->index, list) != 0) at->failed = true;
}

/* ---- curves -------------------------------------------------------------------------------------------------------------- */

pith_status apply_surface_curve(edit *at)
{
    curve_place place;
    curve_edit how;
    pith_vec2 *points = NULL;
    size_t count;
    json_options(at->asked, &document_curve_edit_params, &how);
    PITH_TRY(find_curve(at, true, &place));
    PITH_TRY(read_points(at, json_object_get(at->asked, "points"), &points, &count));
    if (place.vertical) pith_curve_snap(points, count, place.closed, how.snap);
    write_points(at, &place, points, count);
    pith_free(points);
    return PITH_OK;
}

pith_status apply_surface_smooth(edit *at)
{
    curve_place place;
    smooth_edit how;
    pith_vec2 *points = NULL;
    size_t count;
    json_options(at->asked, &document_smooth_edit_params, &how);
    PITH_TRY(find_curve(at, false, &place));
    PITH_TRY(read_points(at, curve_at(&place), &points, &count));
    pith_curve_smooth(points, count, place.closed, how.amount);
    if (place.vertical) pith_curve_snap(points, count, place.closed, 0.0);
    write_points(at, &place, points, count);
    pith_free(points);
    return PITH_OK;
}

static size_t nearest_point(const pith_vec2 *points, size_t count, pith_vec2 to)
{
    size_t best = 0;
    for (size_t i = 1; i < count; ++i)
        if (hypot(points[i].x - to.x, points[i].y - to.y) < hypot(points[best].x - to.x, points[best].y - to.y)) best = i;
    return best;
}

static pith_vec2 pair_of(const json_t *curve, size_t index)
{
    const json_t *point = json_array_get(curve, index);
    return (pith_vec2){ json_number_value(json_array_get(point, 0)), json_number_value(json_array_get(point, 1)) };
}

pith_status apply_surface_deform(edit *at)
{
    curve_place place;
    deform_edit how;
    pith_vec2 *points = NULL;
    size_t count;
    const json_t *drag = json_object_get(at->asked, "drag");
    if (json_array_size(drag) != 2)
        return edit_refuse(at, "drag", "has %zu points, expected two: from where, and where to", json_array_size(drag));
    json_options(at->asked, &document_deform_edit_params, &how);
    PITH_TRY(find_curve(at, false, &place));
    PITH_TRY(read_points(at, curve_at(&place), &points, &count));
    const size_t grabbed = nearest_point(points, count, pair_of(drag, 0));
    pith_status status = pith_curve_deform(points, count, place.closed, grabbed, pair_of(drag, 1), how.reach, at->in.err);
    if (status == PITH_OK) {
        if (place.vertical) pith_curve_snap(points, count, place.closed, 0.0);
        write_points(at, &place, points, count);
    } else {
        status = pith_fail_in(at->in.err, status, "%s: drag", at->in.file);
    }
    pith_free(points);
    return status;
}

/* ---- paint and erasing ------------------------------------------------------------------------------------------------- */

/* Adds the operation's other keys as an entry of one of the surface's lists. */
static pith_status add_entry(edit *at, const char *list)
{
    json_t *surface = NULL;
    PITH_TRY(find_surface(at, &surface));
    json_t *entry = edit_entry(at);
    json_object_del(entry, "surface");
    edit_append(at, edit_child(at, surface, list, json_array), entry);
    return PITH_OK;
}

pith_status apply_surface_paint(edit *at) { return add_entry(at, "paint"); }

pith_status apply_surface_erase(edit *at) { return add_entry(at, "erase"); }

/* Front becomes back and back front, where either is named. */
static void swap_colours(edit *at, json_t *object)
{
    json_t *front = json_incref(json_object_get(object, "front")), *back = json_incref(json_object_get(object, "back"));
    json_object_del(object, "front");
    json_object_del(object, "back");
    if (back) edit_put(at, object, "front", back);
    if (front) edit_put(at, object, "back", front);
}

pith_status apply_surface_flip(edit *at)
{
    json_t *surface = NULL;
    PITH_TRY(find_surface(at, &surface));
    json_t *colours = json_object_get(surface, "colours"), *paint = json_object_get(surface, "paint");
    /* One colour for both sides is so from either. */
    bool two_sided = json_object_get(colours, "back");
    for (size_t i = 0; i < json_array_size(paint); ++i) two_sided |= json_object_get(json_array_get(paint, i), "back") != NULL;
    if (!two_sided) return edit_refuse(at, "surface", "has one colour for both sides; give it a \"back\" first");
    if (colours && !json_object_get(colours, "back") && json_object_get(colours, "front"))
        edit_put(at, colours, "back", json_deep_copy(json_object_get(colours, "front")));
    swap_colours(at, colours);
    for (size_t i = 0; i < json_array_size(paint); ++i) swap_colours(at, json_array_get(paint, i));
    return PITH_OK;
}

/* ---- surfaces ------------------------------------------------------------------------------------------------------------ */

static void drop_name(json_t *holder, const char *key, const char *name)
{
    json_t *list = json_object_get(holder, key);
    for (size_t i = json_array_size(list); i-- > 0;)
        if (strcmp(json_string_value(json_array_get(list, i)), name) == 0) json_array_remove(list, i);
    if (list && json_array_size(list) == 0) json_object_del(holder, key);
}

pith_status apply_surface_remove(edit *at)
{
    json_t *surface = NULL, *list = json_object_get(at->body, "surfaces"), *solids = json_object_get(at->body, "solids");
    PITH_TRY(find_surface(at, &surface));
    const char *name = json_string_value(json_object_get(at->asked, "surface"));
    const json_t *bounds = json_object_get(json_object_get(at->body, "shape"), "surfaces");
    for (size_t i = 0; i < json_array_size(bounds); ++i)
        if (strcmp(json_string_value(json_array_get(bounds, i)), name) == 0)
            return edit_refuse(at, "surface", "bounds the body's shape; take it out of shape.surfaces first");
    size_t index = 0;
    for (size_t i = 0; i < json_array_size(list); ++i) {
        const json_t *other = json_array_get(list, i);
        const char *on = json_string_value(json_object_get(other, "on"));
        if (other == surface) index = i;
        if (on && strcmp(on, name) == 0)
            return edit_refuse(at, "surface", "has grains on it, \"%.60s\"; remove those first",
                               json_string_value(json_object_get(other, "name")));
    }
    for (size_t i = 0; i < json_array_size(solids); ++i) drop_name(json_array_get(solids, i), "surfaces", name);
    json_array_remove(list, index);
    if (json_array_size(list) == 0) json_object_del(at->body, "surfaces");
    return PITH_OK;
}

pith_status apply_sketch_vary(edit *at)
{
    json_t *variation = edit_entry(at);
    edit_put(at, edit_child(at, at->body, "sketch", json_object), "variation", variation);
    return PITH_OK;
}
