/* Requests about files. */
#include "editor.h"
#include "files.h"

pith_status do_files(editor *own, request *asked, pith_error *err)
{
    (void)err;
    const file_places places = editor_places(own);
    json_object_set_new(asked->answer, "files", files_list(&places, request_text(asked, "kind", "")));
    return PITH_OK;
}

pith_status do_file_put(editor *own, request *asked, pith_error *err)
{
    const void *bytes = NULL;
    size_t size;
    const file_places places = editor_places(own);
    const char *name = request_text(asked, "name", "");
    PITH_TRY(packet_view_array(asked->upload, "bytes", PACKET_U8, &bytes, &size, err));
    PITH_TRY(files_put(&places, name, bytes, size, err));
    json_object_set_new(asked->answer, "path", json_string(name));
    return PITH_OK;
}

pith_status find_asked_file(editor *own, request *asked, char **whole, pith_error *err)
{
    const char *path = request_text(asked, "path", "");
    const file_places places = editor_places(own);
    json_t *wanted = json_string(path);
    const pith_status status = files_check(&places, wanted, session_present(own->opened)->root, err);
    json_decref(wanted);
    if (status != PITH_OK) return status;
    *whole = pith_path_join(session_path(own->opened), path);
    return *whole ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a path");
}

/* The file as it is: pages read PNG and JPEG themselves. */
pith_status do_image(editor *own, request *asked, pith_error *err)
{
    const char *path = request_text(asked, "path", "");
    if (!files_has_kind(path, "image"))
        return pith_fail(err, PITH_BAD_ARGUMENT, "path: %.300s is no picture, expected a .png, .jpg or .jpeg", path);
    unsigned char *bytes = NULL;
    size_t size;
    char *whole = NULL;
    PITH_TRY(find_asked_file(own, asked, &whole, err));
    const pith_status status = pith_file_read(whole, &bytes, &size, err);
    pith_free(whole);
    if (status != PITH_OK) return status;
    packet *made = NULL;
    packet_maker *maker = packet_begin("image");
    if (!maker) {
        pith_free(bytes);
        return PITH_OUT_OF_MEMORY(err, "a picture");
    }
    json_object_set_new(packet_text(maker), "id", json_integer(asked->id));
    json_object_set_new(packet_text(maker), "path", json_string(path));
    packet_give(maker, "bytes", PACKET_U8, bytes, size);
    PITH_TRY(packet_finish(maker, &made, err));
    outbox_put(own->out, asked->socket, made);
    asked->later = true;
    return PITH_OK;
}
