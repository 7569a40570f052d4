/* The packet `solid`: what the surface of a body is composed from on the graphics card. Of a lapped solid its masks,
   patches and exemplars; a grid's voxels; every other kind is baked into voxels. */
#include "pack_internal.h"

#include <string.h>

/* ---- lapped: masks ----------------------------------------------------------------------------------------------- */

enum { MASK_BYTES = PITH_LAPPED_MASK * PITH_LAPPED_MASK * PITH_LAPPED_MASK };

/* Pastes have masks of their own, most of them equal: equal ones are sent once. number [mask_count]: which of the sent
   ones each is; returns how many are sent. */
static uint32_t unlike_masks(const pith_lapped_view *view, uint32_t *number, uint32_t *first)
{
    uint32_t count = 0;
    for (uint32_t m = 0; m < view->mask_count; ++m) {
        const uint8_t *mask = pith_lapped_mask_look(view, m);
        number[m] = 0;
        while (number[m] < count && memcmp(pith_lapped_mask_look(view, first[number[m]]), mask, MASK_BYTES) != 0)
            ++number[m];
        if (number[m] == count) first[count++] = m;
    }
    return count;
}

/* The same for exemplars: pastes often set the same one many times. */
static bool same_exemplar(const pith_lapped_exemplar *a, const pith_lapped_exemplar *b)
{
    if (memcmp(a->size, b->size, sizeof a->size) != 0 || a->channels != b->channels || a->wraps != b->wraps) return false;
    const size_t cells = (size_t)a->size[0] * a->size[1] * a->size[2];
    return memcmp(a->values, b->values, cells * a->channels * sizeof(float)) == 0;
}

static uint32_t unlike_exemplars(const pith_lapped_view *view, uint32_t *number, uint32_t *first)
{
    uint32_t count = 0;
    for (uint32_t e = 0; e < view->exemplar_count; ++e) {
        const pith_lapped_exemplar own = pith_lapped_exemplar_look(view, e);
        for (number[e] = 0; number[e] < count; ++number[e]) {
            const pith_lapped_exemplar other = pith_lapped_exemplar_look(view, first[number[e]]);
            if (number[e] > 0 && same_exemplar(&own, &other)) break; /* 0 is the fill's, which is no paste's */
        }
        if (number[e] == count) first[count++] = e;
    }
    return count;
}

/* ---- lapped: arrays ---------------------------------------------------------------------------------------------- */

static void put_masks(packet_maker *maker, const pith_lapped_view *view, const uint32_t *first, uint32_t count)
{
    uint8_t *masks = packet_room(maker, "masks", PACKET_U8, (size_t)count * MASK_BYTES);
    for (uint32_t m = 0; masks && m < count; ++m)
        memcpy(masks + (size_t)m * MASK_BYTES, pith_lapped_mask_look(view, first[m]), MASK_BYTES);
}

/* Offsets, and mask + 1024 exemplar: whole numbers that a float holds exactly. */
static void put_patches(packet_maker *maker, const pith_lapped_view *view, const uint32_t *mask, const uint32_t *exemplar)
{
    float(*patches)[4] = packet_room(maker, "patches", PACKET_F32, (size_t)view->patch_count * 4);
    for (uint32_t p = 0; patches && p < view->patch_count; ++p) {
        const pith_lapped_patch patch = pith_lapped_patch_look(view, p);
        for (int k = 0; k < 3; ++k) patches[p][k] = patch.offset[k];
        patches[p][3] = (float)(mask[patch.mask] + 1024 * exemplar[patch.exemplar]);
    }
}

/* The outlines of patches that were cut to fit: those of the fill, which come first. */
static uint32_t put_cuts(packet_maker *maker, const pith_lapped_view *view)
{
    uint32_t count = 0;
    while (count < view->patch_count && pith_lapped_patch_look(view, count).cut) ++count;
    const size_t words = (size_t)PITH_LAPPED_CUT * PITH_LAPPED_CUT;
    uint32_t *cuts = count ? packet_room(maker, "cuts", PACKET_U32, count * words) : NULL;
    for (uint32_t p = 0; cuts && p < count; ++p)
        memcpy(cuts + p * words, pith_lapped_patch_look(view, p).cut, words * sizeof *cuts);
    return count;
}

static json_t *put_exemplars(packet_maker *maker, const pith_lapped_view *view, const uint32_t *first, uint32_t count)
{
    json_t *list = json_array();
    for (uint32_t e = 0; e < count; ++e) {
        const pith_lapped_exemplar from = pith_lapped_exemplar_look(view, first[e]);
        const size_t cells = (size_t)from.size[0] * from.size[1] * from.size[2];
        char name[32];
        snprintf(name, sizeof name, "exemplar%u", (unsigned)e);
        uint8_t(*bytes)[4] = packet_room(maker, name, PACKET_U8, cells * 4);
        if (bytes) pack_colours(from.values, cells, from.channels, bytes);
        json_array_append_new(list, json_pack("{s[iii] sb}", "size", (int)from.size[0], (int)from.size[1],
                                              (int)from.size[2], "wraps", from.wraps));
    }
    return list;
}

/* The first four channels of the exemplar's normal variables and of their tables; null without. */
static json_t *put_normals(packet_maker *maker, const pith_lapped_view *view)
{
    const pith_lapped_exemplar from = pith_lapped_exemplar_look(view, 0);
    if (!from.blended) return json_null();
    const size_t cells = (size_t)from.size[0] * from.size[1] * from.size[2];
    float(*values)[4] = packet_room(maker, "gauss", PACKET_F32, cells * 4);
    for (size_t i = 0; values && i < cells; ++i)
        memcpy(values[i], from.normals.values + i * from.channels, sizeof values[i]);
    float(*tables)[PITH_LAPPED_TABLE] =
        packet_room(maker, "tables", PACKET_F32, (size_t)from.normals.rows * 4 * PITH_LAPPED_TABLE);
    for (uint32_t row = 0; tables && row < from.normals.rows; ++row)
        memcpy(tables + (size_t)row * 4, from.normals.tables + (size_t)row * from.channels, 4 * sizeof *tables);
    const float *m = from.normals.mean, (*a)[3] = from.normals.axes;
    return json_pack("{si si sf s[fff] s[[fff][fff][fff]]}", "rows", (int)from.normals.rows, "table", PITH_LAPPED_TABLE,
                     "reach", PITH_LAPPED_REACH, "mean", (double)m[0], (double)m[1], (double)m[2], "axes",
                     (double)a[0][0], (double)a[0][1], (double)a[0][2], (double)a[1][0], (double)a[1][1],
                     (double)a[1][2], (double)a[2][0], (double)a[2][1], (double)a[2][2]);
}

static json_t *fill_json(const pith_model *body)
{
    const pith_lapped_report *report = pith_model_fill_report(body);
    if (!report) return json_null();
    return json_pack("{si si sf sf sf sI sf}", "patches", (int)report->patches, "pastes", (int)report->pastes, "overlap",
                     report->overlap, "angle_mean", report->angle_mean, "angle_95", report->angle_95, "bytes",
                     (json_int_t)report->bytes, "seconds", report->seconds);
}

static pith_status put_lapped(packet_maker *maker, const pith_model *body, const pith_solid *solid, pith_error *err)
{
    pith_lapped_view view;
    PITH_TRY(pith_lapped_look(solid, &view, err));
    const size_t most = (size_t)view.mask_count + view.exemplar_count;
    uint32_t *room = pith_alloc(2 * most, sizeof *room);
    if (!room) return PITH_OUT_OF_MEMORY(err, "a solid");
    uint32_t *mask = room, *first_mask = mask + view.mask_count, *exemplar = first_mask + view.mask_count;
    uint32_t *first_exemplar = exemplar + view.exemplar_count;
    const uint32_t masks = unlike_masks(&view, mask, first_mask);
    const uint32_t exemplars = unlike_exemplars(&view, exemplar, first_exemplar);

    json_t *text = packet_text(maker);
    json_object_set_new(text, "type", json_string("lapped"));
    json_object_set_new(text, "homogeneous", json_boolean(view.homogeneous));
    json_object_set_new(text, "mask_size", json_integer(PITH_LAPPED_MASK));
    json_object_set_new(text, "mask_count", json_integer(masks));
    json_object_set_new(text, "cut_size", json_integer(PITH_LAPPED_CUT));
    json_object_set_new(text, "patch_count", json_integer(view.patch_count));
    put_masks(maker, &view, first_mask, masks);
    put_patches(maker, &view, mask, exemplar);
    json_object_set_new(text, "cut_count", json_integer(put_cuts(maker, &view)));
    json_object_set_new(text, "exemplars", put_exemplars(maker, &view, first_exemplar, exemplars));
    json_object_set_new(text, "gauss", put_normals(maker, &view));
    json_object_set_new(text, "report", fill_json(body));
    pith_free(room);
    return PITH_OK;
}

/* ---- other kinds ------------------------------------------------------------------------------------------------- */

/* Along the longest side; 8 MB at most. They are what is seen while the view moves: when it rests pages ask for colours
   point by point, which no number of voxels would give. FEW: of solids that answer slowly, some 50 000 of them. */
enum { VOXELS = 128, FEW = 48 };

/* Voxels outside the body are empty, and a surface between would look dark: those beside full ones take their mean. */
static void widen(uint8_t (*cells)[4], const uint32_t size[3])
{
    const long step[3] = { 1, (long)size[0], (long)size[0] * size[1] };
    for (int pass = 0; pass < 2; ++pass) {
        const uint8_t empty = 0, fresh = (uint8_t)(pass + 1); /* opacities that mark what this pass fills */
        for (long z = 0, i = 0; z < size[2]; ++z)
            for (long y = 0; y < size[1]; ++y)
                for (long x = 0; x < size[0]; ++x, ++i) {
                    if (cells[i][3] != empty) continue;
                    const long at[3] = { x, y, z };
                    int sum[3] = { 0, 0, 0 }, found = 0;
                    for (int side = 0; side < 6; ++side) {
                        const int axis = side / 2;
                        const long there = at[axis] + (side % 2 ? 1 : -1), j = i + (side % 2 ? step[axis] : -step[axis]);
                        if (there < 0 || there >= size[axis] || cells[j][3] == empty || cells[j][3] == fresh) continue;
                        for (int c = 0; c < 3; ++c) sum[c] += cells[j][c];
                        ++found;
                    }
                    if (!found) continue;
                    for (int c = 0; c < 3; ++c) cells[i][c] = (uint8_t)(sum[c] / found);
                    cells[i][3] = fresh;
                }
    }
}

/* Solids that answer slowly, as they are asked for voxels: of diffusion few rays are followed. NULL of others. */
static pith_status make_draft(pith_model *body, const pith_solid *solid, pith_solid **draft, pith_error *err)
{
    enum { ROUGH = 32 };
    const pith_diffusion *diffusion;
    const pith_diffusion_options *options;
    *draft = NULL;
    if (strcmp(pith_solid_kind(solid), "diffusion") != 0) return PITH_OK;
    PITH_TRY(pith_model_diffusion(body, &diffusion, &options, err));
    pith_diffusion_options rough = *options;
    rough.method = PITH_DIFFUSION_PMVC;
    rough.rays = rough.rays < ROUGH ? rough.rays : ROUGH;
    return pith_solid_diffusion(diffusion, &rough, draft, err);
}

static pith_status put_voxels(packet_maker *maker, pith_model *body, const pith_solid *solid, pith_error *err)
{
    const pith_tets *tets;
    const pith_locator *locator;
    pith_grid *grid = NULL;
    pith_solid *draft = NULL;
    PITH_TRY(pith_model_tets(body, &tets, NULL, err));
    PITH_TRY(pith_model_locator(body, &locator, err));
    PITH_TRY(make_draft(body, solid, &draft, err));
    const bool slow = draft || strcmp(pith_solid_kind(solid), "combined") == 0;
    const pith_status status = pith_bake_voxels(draft ? draft : solid, tets, locator, slow ? FEW : VOXELS, NULL, &grid, err);
    pith_solid_destroy(draft);
    PITH_TRY(status);
    const size_t cells = (size_t)grid->size[0] * grid->size[1] * grid->size[2];
    uint8_t(*bytes)[4] = packet_room(maker, "voxels", PACKET_U8, cells * 4);
    if (bytes) {
        pack_colours(grid->values, cells, grid->channels, bytes);
        widen(bytes, grid->size);
    }
    json_t *text = packet_text(maker);
    json_object_set_new(text, "type", json_string("grid"));
    json_object_set_new(text, "size", json_pack("[iii]", (int)grid->size[0], (int)grid->size[1], (int)grid->size[2]));
    json_object_set_new(text, "origin", pack_point(grid->origin));
    json_object_set_new(text, "spacing", pack_point(grid->spacing));
    pith_grid_destroy(grid);
    return PITH_OK;
}

pith_status pack_solid(pith_model *body, size_t index, const char *name, const pack_stamp *stamp, packet **made,
                       pith_error *err)
{
    const pith_solid *solid;
    PITH_TRY(pith_model_solid(body, &solid, err));
    packet_maker *maker = packet_begin("solid");
    pack_stamped(maker, stamp);
    json_object_set_new(packet_text(maker), "body", json_integer((json_int_t)index));
    json_object_set_new(packet_text(maker), "name", json_string(name));
    const pith_status status = strcmp(pith_solid_kind(solid), "lapped") == 0 ? put_lapped(maker, body, solid, err)
                                                                             : put_voxels(maker, body, solid, err);
    if (status == PITH_OK) return packet_finish(maker, made, err);
    packet_abandon(maker);
    return status;
}
