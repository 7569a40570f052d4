/* The patches on every triangle of a view, as records of four words: texture coordinates as 16-bit numbers in a unit
   that the greatest of them fits, so that a section of ten thousand triangles is well under a megabyte. Neighbours share
   the coordinates of their common corners, and round them alike: no seams. */
#include "pack_internal.h"

#include <string.h>

enum { WORDS = 4 };
static const uint32_t spare_bit = 1u << 24, whole_bit = 1u << 25, more_bit = 1u << 31;
enum { MOST_PATCHES = 1 << 24 };

/* The layers of one piece. */
typedef struct piece_layers {
    uint32_t *start;            /* [triangle_count + 1] */
    pith_lapped_layer *layers;
    pith_lapped_view solid;     /* whose layers they are; empty where there are none */
} piece_layers;

static pith_status layers_of(const pack_piece *piece, piece_layers *made, pith_error *err)
{
    made->start = pith_alloc((size_t)piece->view.triangle_count + 1, sizeof *made->start);
    if (!made->start) return PITH_OUT_OF_MEMORY(err, "layers");
    const pith_solid *solid;
    if (!piece->shell || !pith_model_built(piece->body).solid) return PITH_OK;
    PITH_TRY(pith_model_solid(piece->body, &solid, err));
    if (strcmp(pith_solid_kind(solid), "lapped") != 0) return PITH_OK;
    PITH_TRY(pith_lapped_look(solid, &made->solid, err));
    if (made->solid.patch_count > MOST_PATCHES)
        return pith_fail(err, PITH_BAD_ARGUMENT, "the solid has %u patches, and the page can tell %d apart; a larger "
                         "exemplar or scale makes fewer", (unsigned)made->solid.patch_count, MOST_PATCHES);
    return pith_lapped_layers(solid, piece->view.source_tet, (const double (*)[3][4])piece->weights,
                              piece->view.triangle_count, made->start, &made->layers, err);
}

/* Does a layer need its second record: a fade, or s of its own, as everything in a homogeneous solid has it and pastes
   in any? */
static bool needs_more(const pith_lapped_layer *layer, const pith_lapped_view *solid)
{
    return solid->homogeneous || layer->corners[0][3] < 1.0f || layer->corners[1][3] < 1.0f ||
           layer->corners[2][3] < 1.0f || pith_lapped_patch_look(solid, layer->patch).exemplar > 0;
}

/* Greatest |r| or |t|, and greatest |s|. */
static void measure(const piece_layers *from, uint32_t count, float *most_rt, float *most_s)
{
    for (uint32_t i = 0; i < count; ++i)
        for (int k = 0; k < 3; ++k) {
            const float *at = from->layers[i].corners[k];
            *most_rt = fmaxf(*most_rt, fmaxf(fabsf(at[0]), fabsf(at[2])));
            *most_s = fmaxf(*most_s, fabsf(at[1]));
        }
}

static uint32_t pair(float low, float high, float scale)
{
    const int32_t a = (int32_t)lrintf(low * scale), b = (int32_t)lrintf(high * scale);
    return (uint32_t)(uint16_t)(int16_t)a | (uint32_t)(uint16_t)(int16_t)b << 16;
}

static uint32_t fade_word(float fade) { return (uint32_t)lrintf(fminf(fmaxf(fade, 0.0f), 1.0f) * 65535.0f); }

/* Writes one layer, and says how many records it took. */
static uint32_t write_layer(const pith_lapped_layer *layer, const pith_lapped_view *solid, float rt_scale,
                            float s_scale, uint32_t (*to)[WORDS])
{
    const float (*c)[4] = layer->corners;
    const bool more = needs_more(layer, solid);
    for (int k = 0; k < 3; ++k) to[0][k] = pair(c[k][0], c[k][2], rt_scale);
    to[0][3] = layer->patch | (layer->role == PITH_LAYER_SPARE ? spare_bit : 0) |
               (layer->role == PITH_LAYER_WHOLE ? whole_bit : 0) | (more ? more_bit : 0);
    if (!more) return 1;
    to[1][0] = pair(c[0][1], c[1][1], s_scale);
    to[1][1] = (pair(c[2][1], 0.0f, s_scale) & 0xffff) | fade_word(c[0][3]) << 16;
    to[1][2] = fade_word(c[1][3]) | fade_word(c[2][3]) << 16;
    to[1][3] = 0;
    return 2;
}

/* First records of the triangles of all pieces; returns the number of records. */
static uint32_t count_records(const pack_piece *pieces, const piece_layers *all, size_t count, uint32_t *start)
{
    uint32_t records = 0;
    size_t triangle = 0;
    for (size_t p = 0; p < count; ++p)
        for (uint32_t t = 0; pieces[p].shell && t < pieces[p].view.triangle_count; ++t) {
            start[triangle++] = records;
            for (uint32_t i = all[p].start[t]; i < all[p].start[t + 1]; ++i)
                records += needs_more(&all[p].layers[i], &all[p].solid) ? 2 : 1;
        }
    start[triangle] = records;
    return records;
}

static void write_all(const pack_piece *pieces, const piece_layers *all, size_t count, const uint32_t *start,
                      float rt_scale, float s_scale, uint32_t (*records)[WORDS])
{
    size_t first = 0;
    for (size_t p = 0; p < count; ++p) {
        if (!pieces[p].shell) continue;
        const uint32_t triangles = pieces[p].view.triangle_count;
#pragma omp parallel for num_threads(pith_threads()) schedule(static)
        for (uint32_t t = 0; t < triangles; ++t) {
            uint32_t at = start[first + t];
            for (uint32_t i = all[p].start[t]; i < all[p].start[t + 1]; ++i)
                at += write_layer(&all[p].layers[i], &all[p].solid, rt_scale, s_scale, records + at);
        }
        first += triangles;
    }
}

pith_status pack_layers(packet_maker *maker, const pack_piece *pieces, size_t count, size_t triangles, pith_error *err)
{
    piece_layers *all = pith_alloc(count + 1, sizeof *all);
    pith_status status = all ? PITH_OK : PITH_OUT_OF_MEMORY(err, "layers");
    float most_rt = 1e-6f, most_s = 1e-6f;
    for (size_t p = 0; status == PITH_OK && p < count; ++p) {
        status = layers_of(&pieces[p], &all[p], err);
        if (status == PITH_OK) measure(&all[p], all[p].start[pieces[p].view.triangle_count], &most_rt, &most_s);
    }
    uint32_t *start = status == PITH_OK ? packet_room(maker, "layer_start", PACKET_U32, triangles + 1) : NULL;
    if (start) {
        const uint32_t records = count_records(pieces, all, count, start);
        uint32_t(*words)[WORDS] = packet_room(maker, "layers", PACKET_U32, (size_t)records * WORDS);
        if (words) write_all(pieces, all, count, start, 32767.0f / most_rt, 32767.0f / most_s, words);
        json_object_set_new(packet_text(maker), "rt_unit", json_real((double)most_rt / 32767.0));
        json_object_set_new(packet_text(maker), "s_unit", json_real((double)most_s / 32767.0));
    }
    for (size_t p = 0; all && p < count; ++p) {
        pith_free(all[p].start);
        pith_free(all[p].layers);
    }
    pith_free(all);
    return status;
}
