/* PNG by libpng's full interface: the simplified one reduces 16 bits or premultiplies them. libpng reports errors by
   longjmp; each jump lands in the function that called setjmp here, whose state lives in a job of its caller's frame,
   so that no local of the jumping function is read after the jump. */
#include "image_internal.h"

#include <png.h>
#include <setjmp.h>
#include <stdio.h>
#include <string.h>

typedef struct png_job {
    png_structp png;
    png_infop info;
    const char *name;
    char reason[160];              /* libpng's own words */
    const unsigned char *bytes;    /* reading: the file, its size, and how far it was read */
    size_t size, at;
    raw_image *raw;
    unsigned char **rows;          /* [raw->height] */
    unsigned char *out;            /* writing: what was produced so far */
    size_t out_size, out_capacity;
    bool no_memory;
    pith_status status;            /* of a refusal in our own words */
} png_job;

static void on_error(png_structp png, png_const_charp message)
{
    png_job *job = png_get_error_ptr(png);
    snprintf(job->reason, sizeof job->reason, "%s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) { (void)png, (void)message; }

bool png_recognise(const unsigned char *bytes, size_t size) { return size >= 8 && png_sig_cmp(bytes, 0, 8) == 0; }

/* ---- reading ------------------------------------------------------------------------------------------------- */

static void read_bytes(png_structp png, png_bytep to, size_t count)
{
    png_job *job = png_get_io_ptr(png);
    if (count > job->size - job->at) png_error(png, "the file ends too early");
    memcpy(to, job->bytes + job->at, count);
    job->at += count;
}

/* After the header: every colour type becomes grey or RGB, with alpha if the file knows transparency, 8 or 16 bit. */
static void ask_for_plain_samples(png_structp png, png_infop info)
{
    const bool transparency = png_get_valid(png, info, PNG_INFO_tRNS) != 0;
    const png_byte depth = png_get_bit_depth(png, info), type = png_get_color_type(png, info);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
    if (type == PNG_COLOR_TYPE_GRAY && depth < 8) png_set_expand_gray_1_2_4_to_8(png);
    if (transparency) png_set_tRNS_to_alpha(png);
    const uint16_t probe = 1;
    if (depth == 16 && *(const unsigned char *)&probe == 1) png_set_swap(png);
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
}

/* Runs under the setjmp of `read_png`; returns by jumping on any error of the file. */
static void read_rows(png_job *job, pith_error *err)
{
    png_read_info(job->png, job->info);
    const png_uint_32 width = png_get_image_width(job->png, job->info),
                      height = png_get_image_height(job->png, job->info);
    /* Deflate packs at most 1032 bytes into one; a byte of a row holds at most eight pixels. */
    job->status = image_check_claim(job->name, width, height, 8.0 * 1032.0, job->size, err);
    if (job->status != PITH_OK) return;

    ask_for_plain_samples(job->png, job->info);
    raw_image *raw = job->raw;
    raw->width = width, raw->height = height;
    raw->channels = png_get_channels(job->png, job->info);
    raw->bits = png_get_bit_depth(job->png, job->info);
    const size_t row_bytes = png_get_rowbytes(job->png, job->info);
    raw->samples = pith_alloc(height, row_bytes);
    job->rows = pith_alloc(height, sizeof *job->rows);
    if (!raw->samples || !job->rows) {
        job->status = PITH_OUT_OF_MEMORY(err, job->name);
        return;
    }
    for (size_t y = 0; y < height; ++y) job->rows[y] = raw->samples + y * row_bytes;
    png_read_image(job->png, job->rows);
    png_read_end(job->png, NULL);
}

static void read_png(png_job *job, pith_error *err)
{
    if (setjmp(png_jmpbuf(job->png))) {
        job->status = pith_fail(err, PITH_BAD_FILE, "%s: PNG cannot be decoded: %s", job->name, job->reason);
        return;
    }
    png_set_read_fn(job->png, job, read_bytes);
    png_set_user_limits(job->png, IMAGE_SIDE_MAX, IMAGE_SIDE_MAX);
    png_set_chunk_malloc_max(job->png, 8u << 20); /* ancillary text and profiles: nothing here reads them */
    read_rows(job, err);
}

pith_status png_decode(const char *name, const unsigned char *bytes, size_t size, raw_image *raw, pith_error *err)
{
    raw_image made = { 0 };
    png_job job = { .name = name, .bytes = bytes, .size = size, .raw = &made };
    job.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    if (job.info)
        read_png(&job, err);
    else
        job.status = PITH_OUT_OF_MEMORY(err, "libpng");
    png_destroy_read_struct(&job.png, &job.info, NULL);
    pith_free(job.rows);
    if (job.status == PITH_OK)
        *raw = made;
    else
        pith_free(made.samples);
    return job.status;
}

/* ---- writing ------------------------------------------------------------------------------------------------- */

static void write_bytes(png_structp png, png_bytep from, size_t count)
{
    png_job *job = png_get_io_ptr(png);
    void *out = job->out;
    if (!pith_grow(&out, &job->out_capacity, job->out_size + count, 1)) {
        job->no_memory = true;
        png_error(png, "out of memory");
    }
    job->out = out;
    memcpy(job->out + job->out_size, from, count);
    job->out_size += count;
}

static void flush_nothing(png_structp png) { (void)png; }

static void write_png(png_job *job, pith_error *err)
{
    static const int types[5] = { 0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                  PNG_COLOR_TYPE_RGB_ALPHA };
    if (setjmp(png_jmpbuf(job->png))) {
        job->status = pith_fail(err, job->no_memory ? PITH_NO_MEMORY : PITH_EXTERNAL, "PNG cannot be encoded: %s",
                                job->reason);
        return;
    }
    const raw_image *raw = job->raw;
    png_set_write_fn(job->png, job, write_bytes, flush_nothing);
    png_set_compression_level(job->png, 6); /* said aloud: the bytes must not depend on a library's default */
    png_set_IHDR(job->png, job->info, raw->width, raw->height, 8, types[raw->channels], PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(job->png, job->info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(job->png, job->info);
    png_write_image(job->png, job->rows);
    png_write_end(job->png, NULL);
}

pith_status png_encode(const raw_image *raw, unsigned char **bytes, size_t *size, pith_error *err)
{
    raw_image copy = *raw;
    png_job job = { .raw = &copy };
    job.rows = pith_alloc(raw->height, sizeof *job.rows);
    job.png = png_create_write_struct(PNG_LIBPNG_VER_STRING, &job, on_error, on_warning);
    job.info = job.png ? png_create_info_struct(job.png) : NULL;
    if (job.info && job.rows) {
        for (size_t y = 0; y < raw->height; ++y) job.rows[y] = raw->samples + y * raw->width * raw->channels;
        write_png(&job, err);
    } else {
        job.status = PITH_OUT_OF_MEMORY(err, "libpng");
    }
    png_destroy_write_struct(&job.png, &job.info);
    pith_free(job.rows);
    if (job.status == PITH_OK) {
        *bytes = job.out;
        *size = job.out_size;
    } else {
        pith_free(job.out);
    }
    return job.status;
}
