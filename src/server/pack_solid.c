/* The packet `solid`: what a body is made of, as voxels. */
#include "pack.h"

enum { LONGEST = 64 };

static unsigned char to_byte(float value) { return (unsigned char)(fminf(fmaxf(value, 0.0f), 1.0f) * 255.0f + 0.5f); }

pith_status pack_solid(pith_model *body, size_t index, const char *name, const pack_stamp *stamp, packet **made, pith_error *err)
{
    const pith_solid *solid;
    const pith_tets *tets;
    const pith_locator *locator;
    pith_grid *grid = NULL;
    PITH_TRY(pith_model_solid(body, &solid, err));
    PITH_TRY(pith_model_tets(body, &tets, NULL, err));
    PITH_TRY(pith_model_locator(body, &locator, err));
    PITH_TRY(pith_bake_voxels(solid, tets, locator, LONGEST, NULL, &grid, err));
    const size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    packet_maker *maker = packet_begin("solid");
    json_t *text = packet_text(maker);
    json_object_set_new(text, "body", json_integer((json_int_t)index));
    json_object_set_new(text, "name", json_string(name));
    json_object_set_new(text, "serial", json_integer((json_int_t)stamp->serial));
    json_object_set_new(text, "type", json_string("grid"));
    json_object_set_new(text, "size", json_pack("[iii]", grid->size[0], grid->size[1], grid->size[2]));
    json_object_set_new(text, "origin", json_pack("[fff]", grid->origin.x, grid->origin.y, grid->origin.z));
    json_object_set_new(text, "spacing", json_pack("[fff]", grid->spacing.x, grid->spacing.y, grid->spacing.z));
    unsigned char *voxels = packet_room(maker, "voxels", PACKET_U8, 4 * count);
    for (size_t i = 0; voxels && i < count; ++i) {
        const float *value = grid->values + i * grid->channels;
        for (size_t c = 0; c < 4; ++c)
            voxels[4 * i + c] = c == 3 ? to_byte(value[c]) : to_byte(pith_srgb_encode(value[c]));
    }
    pith_grid_destroy(grid);
    return packet_finish(maker, made, err);
}
