/* OpenEXR by the C core of its library: flat pictures in scanlines, whose compression loses nothing. A file's colours
   are linear and premultiplied with its alpha, as the format wants them; ours are not premultiplied. Errors come
   through a callback, whose words go into the message. */
#include "image_internal.h"

#include <openexr.h>
#include <stdio.h>
#include <string.h>

typedef struct exr_job {
    const char *name;
    exr_context_t context;
    char reason[300];           /* the library's own words */
    const unsigned char *bytes; /* reading: the file */
    size_t size;
    unsigned char *out; /* writing: what was produced so far */
    size_t out_size, out_capacity;
    bool no_memory;
} exr_job;

bool exr_recognise(const unsigned char *bytes, size_t size)
{
    static const unsigned char magic[4] = { 0x76, 0x2f, 0x31, 0x01 };
    return size >= sizeof magic && memcmp(bytes, magic, sizeof magic) == 0;
}

/* The job of this thread: the library may tell errors with its own lock held, and asking it for the job would wait for
   that for ever. */
static _Thread_local exr_job *current;

static void on_error(exr_const_context_t context, exr_result_t code, const char *message)
{
    (void)context;
    if (code == EXR_ERR_OUT_OF_MEMORY) current->no_memory = true;
    snprintf(current->reason, sizeof current->reason, "%s", message);
}

static void *allocate(size_t size) { return pith_alloc(1, size); }

static exr_context_initializer_t begin(exr_job *job)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    current = job;
    init.error_handler_fn = on_error;
    init.alloc_fn = allocate;
    init.free_fn = pith_free;
    init.user_data = job;
    init.max_image_width = init.max_image_height = (int)IMAGE_SIDE_MAX;
    init.zip_level = 6; /* said aloud: the bytes must not depend on a library's default */
    return init;
}

/* Of a call that failed, in one sentence. */
static pith_status explain(const exr_job *job, exr_result_t code, pith_status kind, pith_error *err)
{
    if (job->no_memory || code == EXR_ERR_OUT_OF_MEMORY)
        return pith_fail(err, PITH_NO_MEMORY, "%s: out of memory for an EXR picture", job->name);
    return pith_fail(err, kind, "%s: EXR cannot be %s: %s", job->name, kind == PITH_BAD_FILE ? "decoded" : "encoded",
                     job->reason[0] ? job->reason : exr_get_default_error_message(code));
}

/* The channels of a picture of so many in a file, and their names. */
static const char *const channel_names[5][4] = {
    { NULL }, { "Y" }, { "Y", "A" }, { "R", "G", "B" }, { "R", "G", "B", "A" }
};

/* ---- reading ------------------------------------------------------------------------------------------------- */

static int64_t read_bytes(exr_const_context_t context, void *user, void *to, uint64_t count, uint64_t offset,
                          exr_stream_error_func_ptr_t fail)
{
    (void)context, (void)fail;
    const exr_job *job = user;
    if (offset >= job->size) return 0;
    const uint64_t left = job->size - offset, taken = count < left ? count : left;
    memcpy(to, job->bytes + offset, taken);
    return (int64_t)taken;
}

static int64_t tell_size(exr_const_context_t context, void *user)
{
    (void)context;
    return (int64_t)((const exr_job *)user)->size;
}

static const exr_attr_chlist_entry_t *find_channel(const exr_attr_chlist_t *list, const char *name)
{
    for (int i = 0; i < list->num_channels; ++i)
        if (strcmp(list->entries[i].name.str, name) == 0) return &list->entries[i];
    return NULL;
}

/* Which of our kinds of picture the channels make; further channels are left alone. */
static pith_status choose_channels(const exr_job *job, const exr_attr_chlist_t *list, uint32_t *channels,
                                   pith_error *err)
{
    const bool colour = find_channel(list, "R") && find_channel(list, "G") && find_channel(list, "B");
    if (!colour && !find_channel(list, "Y"))
        return pith_fail(err, PITH_BAD_FILE, "%s: is an EXR file without the channels R, G, B or Y", job->name);
    *channels = (colour ? 3 : 1) + (find_channel(list, "A") ? 1 : 0);
    for (uint32_t c = 0; c < *channels; ++c) {
        const exr_attr_chlist_entry_t *entry = find_channel(list, channel_names[*channels][c]);
        if (entry->pixel_type != EXR_PIXEL_HALF && entry->pixel_type != EXR_PIXEL_FLOAT)
            return pith_fail(err, PITH_BAD_FILE, "%s: its EXR channel %s holds whole numbers, expected half or float",
                             job->name, entry->name.str);
        if (entry->x_sampling != 1 || entry->y_sampling != 1)
            return pith_fail(err, PITH_BAD_FILE, "%s: its EXR channel %s is subsampled; store it in full", job->name,
                             entry->name.str);
    }
    return PITH_OK;
}

/* What of the format is read here; the size is checked before memory is taken for it. */
static pith_status check_form(const exr_job *job, exr_attr_box2i_t *window, uint32_t *channels, pith_error *err)
{
    int parts = 0;
    exr_storage_t storage;
    exr_compression_t compression;
    const exr_attr_chlist_t *list = NULL;
    exr_result_t code = exr_get_count(job->context, &parts);
    if (code == EXR_ERR_SUCCESS) code = exr_get_storage(job->context, 0, &storage);
    if (code == EXR_ERR_SUCCESS) code = exr_get_compression(job->context, 0, &compression);
    if (code == EXR_ERR_SUCCESS) code = exr_get_channels(job->context, 0, &list);
    if (code == EXR_ERR_SUCCESS) code = exr_get_data_window(job->context, 0, window);
    if (code != EXR_ERR_SUCCESS) return explain(job, code, PITH_BAD_FILE, err);
    if (parts != 1 || storage != EXR_STORAGE_SCANLINE)
        return pith_fail(err, PITH_BAD_FILE, "%s: is an EXR file of %s; one flat part in scanlines can be read",
                         job->name,
                         parts != 1                     ? "several parts"
                         : storage == EXR_STORAGE_TILED ? "tiles"
                                                        : "deep samples");
    if (compression > EXR_COMPRESSION_PIZ)
        return pith_fail(
            err, PITH_BAD_FILE,
            "%s: its EXR compression loses precision or is unknown; none, RLE, ZIP, ZIPS and PIZ can be read",
            job->name);
    PITH_TRY(choose_channels(job, list, channels, err));
    /* Deflate packs at most 1032 bytes into one, and a pixel has at least two; PIZ packs flat pictures more, but not
       below a bit a pixel of what it stores in all. */
    const int64_t width = (int64_t)window->max.x - window->min.x + 1,
                  height = (int64_t)window->max.y - window->min.y + 1;
    return image_check_claim(job->name, width < 0 ? 0 : (uint64_t)width, height < 0 ? 0 : (uint64_t)height, 1032.0,
                             job->size, err);
}

/* Points the pipeline's channels to planes of their own. (Into interleaved pixels of four floats version 3.1.5 unpacks
   halves in the wrong order.) */
static void aim(exr_decode_pipeline_t *pipe, uint32_t channels, uint32_t width, size_t plane, float *planes)
{
    for (int i = 0; i < pipe->channel_count; ++i) {
        exr_coding_channel_info_t *to = &pipe->channels[i];
        to->decode_to_ptr = NULL;
        for (uint32_t c = 0; c < channels; ++c)
            if (strcmp(to->channel_name, channel_names[channels][c]) == 0)
                to->decode_to_ptr = (uint8_t *)(planes + c * plane);
        to->user_pixel_stride = to->user_bytes_per_element = sizeof(float);
        to->user_line_stride = (int32_t)(width * sizeof(float));
        to->user_data_type = EXR_PIXEL_FLOAT;
    }
}

/* All chunks, each by way of planes [channels][step][width]. */
static exr_result_t read_chunks(const exr_job *job, const exr_attr_box2i_t *window, uint32_t step, float *planes,
                                pith_image *image)
{
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    bool made = false;
    const size_t plane = (size_t)step * image->width;
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < image->height; y += step) {
        exr_chunk_info_t chunk;
        code = exr_read_scanline_chunk_info(job->context, 0, window->min.y + (int)y, &chunk);
        if (code != EXR_ERR_SUCCESS) break;
        code = made ? exr_decoding_update(job->context, 0, &chunk, &pipe)
                    : exr_decoding_initialize(job->context, 0, &chunk, &pipe);
        if (code != EXR_ERR_SUCCESS) break;
        aim(&pipe, image->channels, image->width, plane, planes);
        if (!made) code = exr_decoding_choose_default_routines(job->context, 0, &pipe);
        made = true;
        if (code == EXR_ERR_SUCCESS) code = exr_decoding_run(job->context, 0, &pipe);
        const uint32_t rows = image->height - y < step ? image->height - y : step;
        float *to = image->pixels + (size_t)y * image->width * image->channels;
        for (size_t i = 0; i < (size_t)rows * image->width; ++i)
            for (uint32_t c = 0; c < image->channels; ++c) *to++ = planes[c * plane + i];
    }
    if (made) exr_decoding_destroy(job->context, &pipe);
    return code;
}

/* Where alpha is 0 a colour is light without a body, and stays as it is. */
static void divide_by_alpha(pith_image *image)
{
    const uint32_t colours = colour_channels(image->channels);
    if (image->channels != 2 && image->channels != 4) return;
    const size_t pixels = (size_t)image->width * image->height;
    for (size_t p = 0; p < pixels; ++p) {
        float *pixel = image->pixels + p * image->channels;
        if (pixel[colours] != 0.0f && pixel[colours] != 1.0f)
            for (uint32_t c = 0; c < colours; ++c) pixel[c] /= pixel[colours];
    }
}

static pith_status read_picture(exr_job *job, pith_image **image, pith_error *err)
{
    exr_attr_box2i_t window = { .min.x = 0 };
    uint32_t channels = 0;
    PITH_TRY(check_form(job, &window, &channels, err));
    pith_image *made = NULL;
    PITH_TRY(pith_image_create((uint32_t)(window.max.x - window.min.x + 1), (uint32_t)(window.max.y - window.min.y + 1),
                               channels, &made, err));
    int32_t step = 1;
    exr_result_t code = exr_get_scanlines_per_chunk(job->context, 0, &step);
    float *planes = pith_alloc((size_t)step * made->width, channels * sizeof *planes);
    if (!planes) code = EXR_ERR_OUT_OF_MEMORY;
    if (code == EXR_ERR_SUCCESS) code = read_chunks(job, &window, (uint32_t)step, planes, made);
    pith_free(planes);
    if (code != EXR_ERR_SUCCESS) {
        pith_image_destroy(made);
        return explain(job, code, PITH_BAD_FILE, err);
    }
    divide_by_alpha(made);
    *image = made;
    return PITH_OK;
}

pith_status exr_decode(const char *name, const unsigned char *bytes, size_t size, pith_image **image, pith_error *err)
{
    exr_job job = { .name = name, .bytes = bytes, .size = size };
    exr_context_initializer_t init = begin(&job);
    init.read_fn = read_bytes;
    init.size_fn = tell_size;
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION; /* a cut-off file is refused, not guessed at */
    const exr_result_t code = exr_start_read(&job.context, "the file", &init);
    if (code != EXR_ERR_SUCCESS) {
        if (job.context) exr_finish(&job.context);
        return explain(&job, code, PITH_BAD_FILE, err);
    }
    const pith_status status = read_picture(&job, image, err);
    exr_finish(&job.context);
    return status;
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static int64_t write_bytes(exr_const_context_t context, void *user, const void *from, uint64_t count, uint64_t offset,
                           exr_stream_error_func_ptr_t fail)
{
    (void)context, (void)fail;
    exr_job *job = user;
    void *out = job->out;
    if (!pith_grow(&out, &job->out_capacity, offset + count, 1)) {
        job->no_memory = true;
        return -1;
    }
    job->out = out;
    memcpy(job->out + offset, from, count);
    if (job->out_size < offset + count) job->out_size = offset + count;
    return (int64_t)count;
}

static exr_result_t write_head(const exr_job *job, const pith_image *image)
{
    int part = 0;
    exr_result_t code = exr_add_part(job->context, NULL, EXR_STORAGE_SCANLINE, &part);
    if (code == EXR_ERR_SUCCESS)
        code = exr_initialize_required_attr_simple(job->context, part, (int32_t)image->width, (int32_t)image->height,
                                                   EXR_COMPRESSION_ZIP);
    /* In the alphabet's order, as the library wants them. */
    for (uint32_t c = image->channels; code == EXR_ERR_SUCCESS && c-- > 0;)
        code = exr_add_channel(job->context, part, channel_names[image->channels][c], EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return code == EXR_ERR_SUCCESS ? exr_write_header(job->context) : code;
}

/* A chunk's rows, premultiplied. */
static void multiply_by_alpha(const pith_image *image, uint32_t first, uint32_t rows, float *to)
{
    const uint32_t colours = colour_channels(image->channels);
    const size_t row = (size_t)image->width * image->channels;
    memcpy(to, image->pixels + first * row, rows * row * sizeof *to);
    if (image->channels != 2 && image->channels != 4) return;
    for (size_t p = 0; p < (size_t)rows * image->width; ++p) {
        float *pixel = to + p * image->channels;
        for (uint32_t c = 0; c < colours && pixel[colours] != 1.0f; ++c) pixel[c] *= pixel[colours];
    }
}

static exr_result_t write_chunks(const exr_job *job, const pith_image *image, uint32_t step, float *rows)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t code = EXR_ERR_SUCCESS;
    bool made = false;
    for (uint32_t y = 0; code == EXR_ERR_SUCCESS && y < image->height; y += step) {
        exr_chunk_info_t chunk;
        code = exr_write_scanline_chunk_info(job->context, 0, (int)y, &chunk);
        if (code != EXR_ERR_SUCCESS) break;
        code = made ? exr_encoding_update(job->context, 0, &chunk, &pipe)
                    : exr_encoding_initialize(job->context, 0, &chunk, &pipe);
        if (code != EXR_ERR_SUCCESS) break;
        multiply_by_alpha(image, y, (uint32_t)chunk.height, rows);
        for (int i = 0; i < pipe.channel_count; ++i) {
            exr_coding_channel_info_t *from = &pipe.channels[i];
            for (uint32_t c = 0; c < image->channels; ++c)
                if (strcmp(from->channel_name, channel_names[image->channels][c]) == 0)
                    from->encode_from_ptr = (const uint8_t *)(rows + c);
            from->user_pixel_stride = (int32_t)(image->channels * sizeof(float));
            from->user_line_stride = from->user_pixel_stride * (int32_t)image->width;
        }
        if (!made) code = exr_encoding_choose_default_routines(job->context, 0, &pipe);
        made = true;
        if (code == EXR_ERR_SUCCESS) code = exr_encoding_run(job->context, 0, &pipe);
    }
    if (made) exr_encoding_destroy(job->context, &pipe);
    return code;
}

pith_status exr_encode(const pith_image *image, unsigned char **bytes, size_t *size, pith_error *err)
{
    exr_job job = { .name = "picture" };
    exr_context_initializer_t init = begin(&job);
    init.write_fn = write_bytes;
    int32_t step = 1;
    float *rows = NULL;
    exr_result_t code = exr_start_write(&job.context, "the picture", EXR_WRITE_FILE_DIRECTLY, &init);
    if (code == EXR_ERR_SUCCESS) code = write_head(&job, image);
    if (code == EXR_ERR_SUCCESS) code = exr_get_scanlines_per_chunk(job.context, 0, &step);
    if (code == EXR_ERR_SUCCESS) {
        rows = pith_alloc((size_t)step * image->width, image->channels * sizeof *rows);
        code = rows ? write_chunks(&job, image, (uint32_t)step, rows) : EXR_ERR_OUT_OF_MEMORY;
    }
    pith_free(rows);
    if (job.context) { /* writes the table of chunks into its gap near the beginning */
        const exr_result_t finished = exr_finish(&job.context);
        if (code == EXR_ERR_SUCCESS) code = finished;
    }
    if (code == EXR_ERR_SUCCESS && !job.no_memory) {
        *bytes = job.out;
        *size = job.out_size;
        return PITH_OK;
    }
    pith_free(job.out);
    return explain(&job, code, PITH_EXTERNAL, err);
}
