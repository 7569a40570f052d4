/* Meshes with a picture: one GLB, or an OBJ with its material (.mtl) and picture (.png) beside it. */
#include "mesh_internal.h"

#include <string.h>

/* The path with another extension; caller frees with pith_free. */
static char *beside(const char *path, const char *extension)
{
    const size_t stem = (size_t)(strrchr(path, '.') - path) + 1;
    char *made = pith_alloc(stem + strlen(extension) + 1, 1);
    if (!made) return NULL;
    memcpy(made, path, stem);
    strcpy(made + stem, extension);
    return made;
}

static const char *name_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* Wavefront's material, with the roughness and metalness of its extension for physically based rendering, which readers
   that do not know them pass over. */
static void write_material(const pith_texture *texture, const char *picture, mesh_bytes *bytes)
{
    mesh_bytes_text(bytes, "# pith\nnewmtl pith\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nPr ");
    mesh_bytes_number(bytes, texture->roughness);
    mesh_bytes_text(bytes, "\nPm 0\nmap_Kd ");
    mesh_bytes_text(bytes, picture);
    if (texture->transparent) {
        mesh_bytes_text(bytes, "\nmap_d ");
        mesh_bytes_text(bytes, picture);
    }
    mesh_bytes_text(bytes, "\n");
}

static pith_status write_obj(const pith_mesh_view *view, const pith_texture *texture, const char *path, pith_error *err)
{
    char *material = beside(path, "mtl"), *picture = beside(path, "png");
    mesh_bytes obj = { 0 }, mtl = { 0 };
    pith_status status = PITH_OUT_OF_MEMORY(err, path);
    if (material && picture) {
        mesh_write_obj_material(view, name_of(material), "pith", &obj);
        write_material(texture, name_of(picture), &mtl);
        const pith_file_part files[] = { { picture, texture->png, texture->size },
                                         { material, mtl.data, mtl.size },
                                         { path, obj.data, obj.size } };
        if (!obj.failed && !mtl.failed) status = pith_files_write(files, sizeof files / sizeof *files, err);
    }
    mesh_bytes_free(&obj);
    mesh_bytes_free(&mtl);
    pith_free(material);
    pith_free(picture);
    return status;
}

static pith_status write_glb(const pith_mesh_view *view, const pith_texture *texture, const char *path, pith_error *err)
{
    mesh_bytes bytes = { 0 };
    pith_status status = mesh_write_glb_textured(view, texture, &bytes, err);
    if (status == PITH_OK && bytes.failed) status = PITH_OUT_OF_MEMORY(err, path);
    if (status == PITH_OK) status = pith_file_write(path, bytes.data, bytes.size, err);
    mesh_bytes_free(&bytes);
    return status;
}

pith_status pith_mesh_write_textured(const pith_mesh *mesh, const pith_texture *texture, const char *path,
                                     pith_error *err)
{
    const pith_mesh_view view = pith_mesh_look(mesh);
    if (!texture || !texture->png || texture->size == 0)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: there is no picture to go with the mesh", path);
    if (!view.texcoords)
        return pith_fail(err, PITH_BAD_ARGUMENT, "%s: the mesh has no texture coordinates for its picture", path);
    if (pith_path_has_extension(path, "glb")) return write_glb(&view, texture, path, err);
    if (pith_path_has_extension(path, "obj")) return write_obj(&view, texture, path, err);
    return pith_fail(err, PITH_BAD_ARGUMENT, "%s: a mesh with a picture can be written as .glb or .obj only", path);
}
