/* What a mesh file says beside its geometry: a title, marks, and values of any name at the vertices. */
#include "mesh_internal.h"

#include <string.h>

static char *copy_text(const char *text, size_t length)
{
    char *copy = pith_alloc(length + 1, 1);
    if (copy) memcpy(copy, text, length);
    return copy;
}

uint32_t mesh_named_find(mesh_named *named, const char *name, uint32_t components, pith_part_type type)
{
    for (size_t i = 0; i < named->value_count; ++i)
        if (strcmp(named->values[i].name, name) == 0 && named->values[i].components == components &&
            named->values[i].type == type)
            return (uint32_t)i;
    if (!pith_grow((void **)&named->values, &named->value_room, named->value_count + 1, sizeof *named->values))
        return PITH_NONE;
    char *copy = copy_text(name, strlen(name));
    if (!copy) return PITH_NONE;
    named->values[named->value_count] = (mesh_named_values){ .name = copy, .components = components, .type = type };
    return (uint32_t)named->value_count++;
}

/* Room for `count` vertices; those that are new have NaN. */
static bool fill_to(mesh_named_values *values, size_t count)
{
    if (!pith_grow((void **)&values->values, &values->room, count * values->components, sizeof *values->values))
        return false;
    for (; values->count < count; ++values->count)
        for (uint32_t k = 0; k < values->components; ++k) values->values[values->count * values->components + k] = NAN;
    return true;
}

bool mesh_named_set(mesh_named *named, uint32_t which, size_t vertex, const double *values)
{
    mesh_named_values *to = &named->values[which];
    if (!fill_to(to, vertex + 1)) return false;
    memcpy(to->values + vertex * to->components, values, to->components * sizeof *values);
    return true;
}

bool mesh_named_title(mesh_named *named, const char *title, size_t length)
{
    pith_free(named->title);
    named->title = copy_text(title, length);
    return named->title != NULL;
}

bool mesh_named_mark(mesh_named *named, const char *mark, size_t length)
{
    if (!pith_grow((void **)&named->marks, &named->mark_room, named->mark_count + 1, sizeof *named->marks))
        return false;
    char *copy = copy_text(mark, length);
    if (copy) named->marks[named->mark_count++] = copy;
    return copy != NULL;
}

bool mesh_named_finish(mesh_named *named, size_t vertex_count)
{
    for (size_t i = 0; i < named->value_count; ++i)
        if (!fill_to(&named->values[i], vertex_count)) return false;
    return true;
}

void mesh_named_free(mesh_named *named)
{
    for (size_t i = 0; i < named->value_count; ++i) {
        pith_free(named->values[i].name);
        pith_free(named->values[i].values);
    }
    for (size_t i = 0; i < named->mark_count; ++i) pith_free(named->marks[i]);
    pith_free(named->values);
    pith_free(named->marks);
    pith_free(named->title);
    *named = (mesh_named){ 0 };
}
