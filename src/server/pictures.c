/* Pictures of a model, coarse to fine: first one ray a pixel, then as many as were asked for. */
#include "builder.h"

static pith_status render_surfaces(pith_model *model, bool coarse, const pith_progress *progress, pith_image **image,
                                   pith_error *err)
{
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options options;
    PITH_TRY(pith_model_scene(model, &items, &count, err));
    PITH_TRY(pith_model_view(model, &camera, &options, err));
    if (coarse) options.samples = 1;
    const pith_line_options *lines = coarse ? NULL : pith_model_lines(model);
    pith_image *made = NULL;
    PITH_TRY(pith_render(items, count, &camera, &options, progress, &made, err));
    pith_status status = PITH_OK;
    if (lines) status = pith_render_lines(items, count, NULL, &camera, lines, progress, made, err);
    if (status == PITH_OK)
        *image = made;
    else
        pith_image_destroy(made);
    return status;
}

static pith_status render_through(pith_model *model, bool coarse, const pith_progress *progress, pith_image **image,
                                  pith_error *err)
{
    const pith_volume_item *items;
    const pith_transfer_point *transfer;
    size_t count, transfer_count;
    pith_camera camera;
    pith_volume_options options;
    PITH_TRY(pith_model_volume_items(model, &items, &count, err));
    PITH_TRY(pith_model_volume_view(model, &camera, &options, &transfer, &transfer_count, err));
    if (coarse) options.samples = 1;
    return pith_render_volume(items, count, &camera, &options, transfer, transfer_count, progress, image, err);
}

static pith_status pack_picture(const pith_image *image, uint32_t job, bool final, packet **made, pith_error *err)
{
    unsigned char *bytes = NULL;
    size_t size = 0;
    PITH_TRY(pith_image_encode_png(image, &bytes, &size, err));
    packet_maker *maker = packet_begin("picture");
    json_t *text = packet_text(maker);
    json_object_set_new(text, "job", json_integer(job));
    json_object_set_new(text, "width", json_integer(image->width));
    json_object_set_new(text, "height", json_integer(image->height));
    json_object_set_new(text, "final", json_boolean(final));
    packet_give(maker, "png", PACKET_U8, bytes, size);
    return packet_finish(maker, made, err);
}

pith_status picture_make(const picture_wish *wish, uint32_t job, pith_model *model, const pith_progress *progress,
                         outbox *out, pith_error *err)
{
    for (int coarse = wish->samples > 1; coarse >= 0; --coarse) {
        pith_image *image = NULL;
        packet *made = NULL;
        PITH_TRY((wish->through ? render_through : render_surfaces)(model, coarse != 0, progress, &image, err));
        const pith_status status = pack_picture(image, job, coarse == 0, &made, err);
        pith_image_destroy(image);
        if (status != PITH_OK) return status;
        packet_set_slot(made, "picture/%u", job);
        outbox_put(out, wish->socket, made);
    }
    return PITH_OK;
}
