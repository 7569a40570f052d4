/* The sketch and the surfaces of a body: from checked JSON to plain structs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "document_internal.h"

/* ---- curves and brushes --------------------------------------------------------------------------------------------- */

static pith_status build_curve(pith_document *made, const json_t *list, bool closed, pith_curve *to, pith_error *err)
{
    const size_t count = json_array_size(list);
    pith_vec2 *points = arena_alloc(&made->memory, count, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "a curve");
    for (size_t i = 0; i < count; ++i) {
        const json_t *point = json_array_get(list, i);
        points[i] = (pith_vec2){ json_number_value(json_array_get(point, 0)),
                                 json_number_value(json_array_get(point, 1)) };
    }
    *to = (pith_curve){ points, count, closed };
    return PITH_OK;
}

static pith_status build_brush(pith_document *made, const json_t *from, pith_brush *to, pith_error *err)
{
    json_options(from, &pith_brush_params, to);
    return document_points(made, json_object_get(from, "points"), &to->points, &to->count, err);
}

/* ---- what is done to a surface ---------------------------------------------------------------------------------------- */

static pith_status build_paint(pith_document *made, reader *in, const json_t *from, document_paint *to)
{
    const json_t *front = json_object_get(from, "front"), *back = json_object_get(from, "back");
    paint_value value;
    json_options(from, &document_paint_params, &value);
    to->blur = value.blur;
    to->has_blur = json_object_get(from, "blur");
    to->has_front = front;
    to->has_back = back;
    if (front) json_colour(front, to->front);
    if (back) json_colour(back, to->back);
    if (!front && !back && !to->has_blur)
        return reader_fail(in, "paints nothing; give \"front\", \"back\" or \"blur\"");
    return build_brush(made, json_object_get(from, "brush"), &to->brush, in->err);
}

static pith_status build_paints(pith_document *made, reader *in, const json_t *list, document_surface *to)
{
    const size_t count = json_array_size(list);
    to->paint = arena_alloc(&made->memory, count, sizeof *to->paint);
    if (!to->paint) return PITH_OUT_OF_MEMORY(in->err, "paint");
    to->paint_count = count;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = reader_enter(in, "paint");
        reader_enter_at(in, i);
        PITH_TRY(build_paint(made, in, json_array_get(list, i), &to->paint[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static pith_status build_erase(pith_document *made, reader *in, const json_t *from, pith_erase *to)
{
    const json_t *plane = json_object_get(from, "plane"), *stroke = json_object_get(from, "stroke");
    const json_t *vertical = json_object_get(from, "vertical"), *horizontal = json_object_get(from, "horizontal");
    const json_t *closed = json_object_get(from, "closed");
    erase_options options;
    json_options(from, &document_erase_params, &options);
    to->positive = options.side == 1;
    if (closed && !vertical && !horizontal) {
        reader_enter(in, "closed");
        return reader_fail(in, "belongs to a curve, \"vertical\" or \"horizontal\"; leave it out");
    }
    json_options(stroke, &pith_cut_stroke_params, &to->follow);
    to->kind = vertical ? PITH_ERASE_VERTICAL : horizontal ? PITH_ERASE_HORIZONTAL : stroke ? PITH_ERASE_STROKE
                                                                                            : PITH_ERASE_PLANE;
    if (vertical || horizontal)
        return build_curve(made, vertical ? vertical : horizontal, json_is_true(closed), &to->curve, in->err);
    if (stroke) {
        to->stroke.eye = json_point(json_object_get(stroke, "eye"));
        return document_points(made, json_object_get(stroke, "points"), &to->stroke.points, &to->stroke.count, in->err);
    }
    return document_plane(in, plane, &to->plane);
}

static pith_status build_erases(pith_document *made, reader *in, const json_t *list, document_surface *to)
{
    const size_t count = json_array_size(list);
    to->erase = arena_alloc(&made->memory, count, sizeof *to->erase);
    if (!to->erase) return PITH_OUT_OF_MEMORY(in->err, "what is erased");
    to->erase_count = count;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = reader_enter(in, "erase");
        reader_enter_at(in, i);
        PITH_TRY(build_erase(made, in, json_array_get(list, i), &to->erase[i]));
        reader_leave(in, length);
    }
    return PITH_OK;
}

static const float white[3] = { 1, 1, 1 };

static void build_colours(const json_t *from, document_surface *to)
{
    const json_t *front = json_object_get(from, "front"), *back = json_object_get(from, "back");
    json_options(from, &document_look_params, &to->look);
    to->coloured = front || back;
    to->two_sided = back;
    memcpy(to->front, white, sizeof white);
    if (front) json_colour(front, to->front);
    memcpy(to->back, to->front, sizeof to->back);
    if (back) json_colour(back, to->back);
    if (!front && back) memcpy(to->front, to->back, sizeof to->front);
    for (size_t i = 0; i < to->paint_count; ++i) to->two_sided |= to->paint[i].has_back;
}

/* ---- surfaces -------------------------------------------------------------------------------------------------------- */

/* The body's surface of that name among the first `count`. `in` stands at the name. */
static pith_status find_surface(reader *in, const char *name, const document_body *body, size_t count, size_t *found)
{
    name_list names = { .count = 0 };
    for (size_t i = 0; i < count; ++i) {
        if (strcmp(body->surfaces[i].name, name) == 0) {
            *found = i;
            return PITH_OK;
        }
        name_list_add(&names, body->surfaces[i].name);
    }
    return reader_fail_name(in, count < body->surface_count ? "surface before this one" : "surface", name, &names);
}

pith_status surfaces_named(pith_document *made, reader *in, const json_t *names, const document_body *body,
                           size_t **surfaces, size_t *count)
{
    const size_t wanted = names ? json_array_size(names) : body->surface_count;
    size_t *list = arena_alloc(&made->memory, wanted, sizeof *list);
    if (!list) return PITH_OUT_OF_MEMORY(in->err, "surfaces");
    for (size_t i = 0; i < wanted; ++i) {
        list[i] = i;
        if (!names) continue;
        const size_t length = reader_enter_at(in, i);
        PITH_TRY(find_surface(in, json_string_value(json_array_get(names, i)), body, body->surface_count, &list[i]));
        reader_leave(in, length);
    }
    *surfaces = list;
    *count = wanted;
    return PITH_OK;
}

/* The oval that stands for the loops of chambers that have none: as wide as the vertical loop reaches, within its fold. */
static pith_status default_oval(pith_document *made, const pith_sketch *sketch, const pith_curve *vertical, pith_curve *to,
                                pith_error *err)
{
    enum { POINTS = 24 };
    double low = INFINITY, high = 0.0;
    for (size_t i = 0; i < vertical->count; ++i) {
        low = fmin(low, vertical->points[i].x);
        high = fmax(high, vertical->points[i].x);
    }
    const double folds = sketch->folds > 0 ? sketch->folds : 1.0, turn = M_PI / 180.0 * sketch->fold_angle + M_PI / folds;
    const double middle = 0.5 * (low + high), deep = 0.5 * (high - low);
    const double wide = folds > 2.0 ? fmin(deep, 0.75 * middle * tan(M_PI / folds)) : deep;
    pith_vec2 *points = arena_alloc(&made->memory, POINTS, sizeof *points);
    if (!points) return PITH_OUT_OF_MEMORY(err, "a curve");
    for (int i = 0; i < POINTS; ++i) {
        const double angle = 2.0 * M_PI * i / POINTS, out = middle + deep * cos(angle), beside = wide * sin(angle);
        points[i] = (pith_vec2){ out * cos(turn) - beside * sin(turn), out * sin(turn) + beside * cos(turn) };
    }
    *to = (pith_curve){ points, POINTS, true };
    return PITH_OK;
}

static pith_status build_feature(pith_document *made, reader *in, const json_t *from, const pith_sketch *sketch,
                                 const document_surface *surface, pith_feature *to)
{
    const json_t *one = json_object_get(from, "horizontal"), *several = json_object_get(from, "horizontals");
    const bool chambers = surface->kind == SURFACE_CHAMBERS;
    json_options(from, &pith_feature_params, to);
    to->name = surface->name;
    to->kind = chambers ? PITH_FEATURE_CHAMBERS : PITH_FEATURE_AROUND;
    const bool closed = chambers || json_is_true(json_object_get(from, "closed"));
    PITH_TRY(build_curve(made, json_object_get(from, "vertical"), closed, &to->vertical, in->err));
    const size_t count = one || (chambers && !several) ? 1 : json_array_size(several);
    pith_curve *loops = arena_alloc(&made->memory, count, sizeof *loops);
    if (!loops) return PITH_OUT_OF_MEMORY(in->err, "curves");
    if (chambers && !several) PITH_TRY(default_oval(made, sketch, &to->vertical, &loops[0], in->err));
    else
        for (size_t i = 0; i < count; ++i)
            PITH_TRY(build_curve(made, one ? one : json_array_get(several, i), true, &loops[i], in->err));
    to->horizontal = loops;
    to->horizontal_count = count;
    return PITH_OK;
}

/* A grain without an outline is as thick as it is long. */
static pith_status build_grains(pith_document *made, reader *in, const json_t *from, const document_body *body,
                                document_surface *to)
{
    const json_t *grain = json_object_get(from, "grain"), *region = json_object_get(from, "region");
    const json_t *outline = json_object_get(grain, "outline");
    json_options(from, &pith_grains_params, &to->grains);
    json_options(grain, &document_grain_params, &to->grain);
    const size_t length = reader_enter(in, "on");
    PITH_TRY(find_surface(in, json_string_value(json_object_get(from, "on")), body, (size_t)(to - body->surfaces),
                          &to->on));
    reader_leave(in, length);
    PITH_TRY(build_curve(made, json_object_get(grain, "profile"), true, &to->profile, in->err));
    to->outline = to->profile;
    if (outline) PITH_TRY(build_curve(made, outline, true, &to->outline, in->err));
    to->region_count = json_array_size(region);
    to->region = arena_alloc(&made->memory, to->region_count, sizeof *to->region);
    if (!to->region) return PITH_OUT_OF_MEMORY(in->err, "a region");
    for (size_t i = 0; i < to->region_count; ++i)
        PITH_TRY(build_brush(made, json_array_get(region, i), &to->region[i], in->err));
    return PITH_OK;
}

static pith_status build_surface(pith_document *made, reader *in, const json_t *from, document_body *body,
                                 pith_feature *features, document_surface *to)
{
    static const char *const words[] = { "around", "chambers", "grains", "file", "body" };
    PITH_TRY(document_text(made, json_object_get(from, "name"), &to->name, in->err));
    for (const document_surface *other = body->surfaces; other < to; ++other)
        if (strcmp(other->name, to->name) == 0) {
            reader_enter(in, "name");
            return reader_fail(in, "is \"%s\", as surfaces[%td] already is; names must differ", to->name,
                               other - body->surfaces);
        }
    while (strcmp(words[to->kind], json_string_value(json_object_get(from, "kind"))) != 0) ++to->kind;
    if (to->kind == SURFACE_AROUND || to->kind == SURFACE_CHAMBERS) {
        to->feature = body->sketch.drawn.feature_count++;
        PITH_TRY(build_feature(made, in, from, &body->sketch.drawn, to, &features[to->feature]));
    }
    if (to->kind == SURFACE_GRAINS) PITH_TRY(build_grains(made, in, from, body, to));
    if (to->kind == SURFACE_FILE) PITH_TRY(document_path(made, from, "mesh", &to->file, in->err));
    const json_t *part = json_object_get(from, "part");
    if (part) PITH_TRY(document_text(made, part, &to->part, in->err));
    PITH_TRY(build_paints(made, in, json_object_get(from, "paint"), to));
    PITH_TRY(build_erases(made, in, json_object_get(from, "erase"), to));
    build_colours(json_object_get(from, "colours"), to);
    return PITH_OK;
}

/* Curves that no surface can be made of are refused when the document is read. */
static pith_status check_sketch(reader *in, const document_body *body)
{
    pith_error why;
    const pith_status status = pith_sketch_check(&body->sketch.drawn, &why);
    if (status == PITH_OK) return PITH_OK;
    if (status == PITH_NO_MEMORY) return PITH_OUT_OF_MEMORY(in->err, "a sketch");
    reader_enter(in, "surfaces");
    return reader_fail(in, "%s", why.message);
}

static pith_status check_bounds(pith_document *made, reader *in, const json_t *names, document_body *to)
{
    if (!names) return PITH_OK;
    const size_t length = reader_enter(in, "shape");
    reader_enter(in, "surfaces");
    PITH_TRY(surfaces_named(made, in, names, to, &to->bounds, &to->bound_count));
    for (size_t i = 0; i < to->surface_count; ++i)
        if (to->surfaces[i].kind == SURFACE_BODY)
            return reader_fail(in, "cannot be while surface \"%.60s\" is of kind \"body\": the one would be made from "
                               "the other", to->surfaces[i].name);
    reader_leave(in, length);
    return PITH_OK;
}

static pith_status hash_json(const json_t *all, uint64_t *hash, pith_error *err)
{
    char *text = all ? json_dumps(all, JSON_SORT_KEYS | JSON_COMPACT) : NULL;
    if (!text) return PITH_OUT_OF_MEMORY(err, "surfaces");
    *hash = pith_hash_bytes(text, strlen(text), 0);
    free(text);
    return PITH_OK;
}

static bool has_name(const json_t *names, const char *name)
{
    for (size_t i = 0; i < json_array_size(names); ++i)
        if (strcmp(json_string_value(json_array_get(names, i)), name) == 0) return true;
    return false;
}

/* Leaves of the list what the form of the surfaces of these names depends on: themselves and what grains among them lie
   on, without colours; and, where they vary together, the curves of all. False: no memory. */
static bool keep_form(json_t *list, const json_t *bounds, bool varied)
{
    json_t *names = json_copy((json_t *)bounds);
    bool good = !bounds || names;
    for (size_t i = json_array_size(list); good && i-- > 0;) { /* grains come behind what they lie on */
        json_t *surface = json_array_get(list, i), *on = json_object_get(surface, "on");
        const bool needed = has_name(names, json_string_value(json_object_get(surface, "name")));
        json_object_del(surface, "colours");
        json_object_del(surface, "paint");
        if (needed && on) good = json_array_append(names, on) == 0;
        if (needed) continue;
        json_object_del(surface, "erase");
        if (!varied || !json_object_get(surface, "vertical")) json_array_remove(list, i);
    }
    json_decref(names);
    return good;
}

/* Pictures that curves are drawn over do not count. bounds: names of the surfaces that bound the body, or NULL. */
static pith_status hash_sketch(const json_t *sketch, const json_t *surfaces, const json_t *bounds, document_sketch *to,
                               pith_error *err)
{
    json_t *all = json_pack("{so* so*}", "sketch", json_copy((json_t *)sketch), "surfaces", json_array());
    json_t *drawn = json_object_get(all, "sketch"), *list = json_object_get(all, "surfaces");
    const bool varied = json_object_get(sketch, "variation") != NULL;
    if (drawn) json_object_del(drawn, "vertical");
    if (drawn) json_object_del(drawn, "horizontal");
    for (size_t i = 0; list && i < json_array_size(surfaces); ++i)
        if (json_array_append_new(list, json_copy(json_array_get(surfaces, i))) != 0) list = NULL;
    pith_status status = hash_json(list ? all : NULL, &to->hash, err);
    if (status == PITH_OK) status = hash_json(keep_form(list, bounds, varied) ? all : NULL, &to->form_hash, err);
    json_decref(all);
    return status;
}

pith_status surfaces_build(pith_document *made, reader *in, const json_t *from, document_body *to)
{
    const json_t *sketch = json_object_get(from, "sketch"), *list = json_object_get(from, "surfaces");
    const json_t *variation = json_object_get(sketch, "variation");
    const size_t count = json_array_size(list);
    const json_t *bounds = json_object_get(json_object_get(from, "shape"), "surfaces");
    PITH_TRY(hash_sketch(sketch, list, bounds, &to->sketch, in->err));
    json_options(sketch, &pith_sketch_params, &to->sketch.drawn);
    to->sketch.varied = variation != NULL;
    json_options(variation, &pith_variation_params, &to->sketch.variation);
    pith_feature *features = arena_alloc(&made->memory, count, sizeof *features);
    to->surfaces = arena_alloc(&made->memory, count, sizeof *to->surfaces);
    if (!features || !to->surfaces) return PITH_OUT_OF_MEMORY(in->err, "surfaces");
    to->sketch.drawn.features = features;
    to->surface_count = count;
    for (size_t i = 0; i < count; ++i) {
        const size_t length = reader_enter(in, "surfaces");
        reader_enter_at(in, i);
        PITH_TRY(build_surface(made, in, json_array_get(list, i), to, features, &to->surfaces[i]));
        reader_leave(in, length);
    }
    if (to->sketch.drawn.feature_count > 0) PITH_TRY(check_sketch(in, to));
    return check_bounds(made, in, bounds, to);
}
