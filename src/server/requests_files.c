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
