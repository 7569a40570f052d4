/* Files of one mesh or several with what stands beside their geometry: reading into parts, and the way to a writer. */
#include "mesh_internal.h"

#include <string.h>

struct pith_parts {
    pith_part *parts; /* [count] */
    size_t count;
    pith_mesh **meshes;        /* [count] */
    mesh_named *named;         /* [count] */
    pith_part_values **values; /* [count] */
};

/* ---- reading ----------------------------------------------------------------------------------------------------- */

mesh_part *mesh_part_begin(mesh_part_list *list, const char *name)
{
    if (!pith_grow((void **)&list->items, &list->room, list->count + 1, sizeof *list->items)) return NULL;
    mesh_part *made = pith_alloc(1, sizeof *made);
    if (!made) return NULL;
    made->scale = 1.0;
    made->builder.name = name;
    made->builder.named = &made->named;
    list->items[list->count++] = made;
    return made;
}

static void free_list(mesh_part_list *list)
{
    for (size_t i = 0; i < list->count; ++i) {
        mesh_builder_free(&list->items[i]->builder);
        mesh_named_free(&list->items[i]->named);
        pith_free(list->items[i]);
    }
    pith_free(list->items);
}

void pith_parts_destroy(pith_parts *parts)
{
    if (!parts) return;
    for (size_t i = 0; i < parts->count; ++i) {
        pith_mesh_destroy(parts->meshes[i]);
        mesh_named_free(&parts->named[i]);
        pith_free(parts->values[i]);
    }
    pith_free(parts->parts);
    pith_free(parts->meshes);
    pith_free(parts->named);
    pith_free(parts->values);
    pith_free(parts);
}

/* One more part, which takes over what is named. */
static pith_status finish_part(pith_parts *made, mesh_part *from, pith_error *err)
{
    const size_t i = made->count++;
    made->named[i] = from->named;
    from->named = (mesh_named){ 0 };
    mesh_named *named = &made->named[i];
    PITH_TRY(mesh_builder_finish(&from->builder, &made->meshes[i], err));
    made->values[i] = pith_alloc(named->value_count, sizeof *made->values[i]);
    if (!made->values[i] || !mesh_named_finish(named, from->builder.vertex_count))
        return PITH_OUT_OF_MEMORY(err, from->builder.name);
    for (size_t k = 0; k < named->value_count; ++k)
        made->values[i][k] = (pith_part_values){ named->values[k].name, named->values[k].components,
                                                 named->values[k].type, named->values[k].values };
    made->parts[i] = (pith_part){ named->title,       pith_mesh_look(made->meshes[i]),   made->values[i],
                                  named->value_count, (const char *const *)named->marks, named->mark_count,
                                  from->scale };
    return PITH_OK;
}

static pith_status finish_list(mesh_part_list *list, const char *name, pith_parts **parts, pith_error *err)
{
    pith_parts *made = pith_alloc(1, sizeof *made);
    if (!made) return PITH_OUT_OF_MEMORY(err, name);
    made->parts = pith_alloc(list->count, sizeof *made->parts);
    made->meshes = pith_alloc(list->count, sizeof *made->meshes);
    made->named = pith_alloc(list->count, sizeof *made->named);
    made->values = pith_alloc(list->count, sizeof *made->values);
    pith_status status = PITH_OK;
    if (!made->parts || !made->meshes || !made->named || !made->values) status = PITH_OUT_OF_MEMORY(err, name);
    for (size_t i = 0; status == PITH_OK && i < list->count; ++i)
        if (list->items[i]->builder.vertex_count > 0) /* a node may hold lines alone */
            status = finish_part(made, list->items[i], err);
    if (status == PITH_OK && made->count == 0) status = pith_fail(err, PITH_BAD_FILE, "%s: holds no triangle", name);
    if (status != PITH_OK) {
        pith_parts_destroy(made);
        return status;
    }
    *parts = made;
    return PITH_OK;
}

pith_status pith_parts_parse(const char *name, const char *format, const void *bytes, size_t size, pith_parts **parts,
                             pith_error *err)
{
    if (!bytes) return pith_fail(err, PITH_BAD_ARGUMENT, "%s: no bytes to read (NULL)", name);
    mesh_reader *read = mesh_reader_of(name, format, err);
    if (!read) return PITH_BAD_FILE;
    mesh_part_list list = { 0 };
    pith_status status;
    if (read == mesh_read_glb) {
        status = mesh_read_glb_parts(name, bytes, size, &list, err);
    } else {
        mesh_part *only = mesh_part_begin(&list, name);
        status = only ? read(&only->builder, bytes, size, err) : PITH_OUT_OF_MEMORY(err, name);
    }
    if (status == PITH_OK) status = finish_list(&list, name, parts, err);
    free_list(&list);
    return status;
}

pith_status pith_parts_read(const char *path, pith_parts **parts, pith_error *err)
{
    const char *format;
    unsigned char *bytes;
    size_t size;
    PITH_TRY(mesh_load(path, &format, &bytes, &size, err));
    const pith_status status = pith_parts_parse(path, format, bytes, size, parts, err);
    pith_free(bytes);
    return status;
}

const pith_part *pith_parts_look(const pith_parts *parts, size_t *count)
{
    *count = parts->count;
    return parts->parts;
}

/* ---- writing ----------------------------------------------------------------------------------------------------- */

/* Words of letters, digits and '_' are the same in every format. */
static bool is_word(const char *text)
{
    return *text && text[strspn(text, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_")] == 0;
}

static pith_status check_part(const pith_part *part, const char *path, bool ply, pith_error *err)
{
    for (const char *c = part->name; c && *c; ++c)
        if ((unsigned char)*c < ' ')
            return pith_fail(err, PITH_BAD_ARGUMENT, "%s: a name with control characters cannot be written", path);
    for (size_t i = 0; i < part->mark_count; ++i)
        if (!is_word(part->marks[i]) || (ply && !mesh_ply_is_mark(part->marks[i])))
            return pith_fail(err, PITH_BAD_ARGUMENT, "%s: \"%s\" is no mark; letters, digits and '_' are%s", path,
                             part->marks[i], ply ? ", up to 31 that are not \"name\"" : "");
    for (size_t i = 0; i < part->value_count; ++i) {
        const pith_part_values *values = &part->values[i];
        if (!is_word(values->name) || (!ply && values->name[0] != '_'))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "%s: values cannot be called \"%s\"; expected letters, digits and "
                             "'_'%s",
                             path, values->name, ply ? "" : ", which comes first");
        if (ply && !mesh_ply_is_free(values->name))
            return pith_fail(err, PITH_BAD_ARGUMENT,
                             "%s: values cannot be called \"%s\" in a PLY file: it has more than 31 letters or means "
                             "something else there",
                             path, values->name);
        for (size_t k = 0; k < i; ++k)
            if (strcmp(part->values[k].name, values->name) == 0)
                return pith_fail(err, PITH_BAD_ARGUMENT, "%s: two arrays of values are called \"%s\"", path,
                                 values->name);
        if (values->components < 1 || values->components > (ply ? 1u : 4u) || values->type == PITH_PART_WHOLE)
            return pith_fail(err, PITH_BAD_ARGUMENT, "%s: values called \"%s\" must be %s floats to be written", path,
                             values->name, ply ? "single" : "one to four");
    }
    return mesh_check(&part->mesh, path, err);
}

pith_status pith_parts_write(const pith_part *parts, size_t count, const char *path, pith_error *err)
{
    const bool ply = pith_path_has_extension(path, "ply");
    if (!ply && !pith_path_has_extension(path, "glb"))
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: meshes with values of their own can be written as .glb or .ply",
                         path);
    if (count == 0 || !parts) return pith_fail(err, PITH_BAD_ARGUMENT, "%s: there is no mesh to write", path);
    if (ply && count > 1)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: a PLY file holds one mesh, not %zu; write .glb or a file each",
                         path, count);
    for (size_t i = 0; i < count; ++i) PITH_TRY(check_part(&parts[i], path, ply, err));
    mesh_bytes bytes = { 0 };
    pith_status status =
        ply ? mesh_write_ply_part(parts, &bytes, err) : mesh_write_glb_parts(parts, count, &bytes, err);
    if (status == PITH_OK && bytes.failed) status = PITH_OUT_OF_MEMORY(err, path);
    if (status == PITH_OK) status = pith_file_write(path, bytes.data, bytes.size, err);
    mesh_bytes_free(&bytes);
    return status;
}
