/* JPEG by TurboJPEG. Every warning of the decoder counts as an error: libjpeg goes on with grey after data that ran
   out, and remembers only its first warning's words, so a cut-off picture cannot be told from a merely untidy one. */
#include "image_internal.h"

#include <turbojpeg.h>

bool jpeg_recognise(const unsigned char *bytes, size_t size)
{
    return size >= 3 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff;
}

static pith_status decode(tjhandle codec, const char *name, const unsigned char *bytes, size_t size, raw_image *raw,
                          pith_error *err)
{
    int width, height, subsampling, space;
    if (tjDecompressHeader3(codec, bytes, size, &width, &height, &subsampling, &space) != 0)
        return pith_fail(err, PITH_BAD_FILE, "%s: JPEG cannot be decoded: %s", name, tjGetErrorStr2(codec));
    if (space == TJCS_CMYK || space == TJCS_YCCK)
        return pith_fail(err, PITH_BAD_FILE, "%s: is a CMYK JPEG; convert it to RGB or grey first", name);
    /* An 8x8 block takes at least one bit of entropy-coded data. */
    PITH_TRY(image_check_claim(name, width < 0 ? 0 : (uint64_t)width, height < 0 ? 0 : (uint64_t)height, 8.0 * 64.0,
                               size, err));

    const uint32_t channels = space == TJCS_GRAY ? 1 : 3;
    unsigned char *samples = pith_alloc((size_t)width * (size_t)height, channels);
    if (!samples) return PITH_OUT_OF_MEMORY(err, name);
    if (tjDecompress2(codec, bytes, size, samples, width, 0, height, channels == 1 ? TJPF_GRAY : TJPF_RGB,
                      TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS) != 0) {
        pith_free(samples);
        return pith_fail(err, PITH_BAD_FILE, "%s: JPEG cannot be decoded: %s", name, tjGetErrorStr2(codec));
    }
    *raw = (raw_image){ .width = (uint32_t)width, .height = (uint32_t)height, .channels = channels, .bits = 8,
                        .samples = samples };
    return PITH_OK;
}

pith_status jpeg_decode(const char *name, const unsigned char *bytes, size_t size, raw_image *raw, pith_error *err)
{
    tjhandle codec = tjInitDecompress();
    if (!codec) return PITH_OUT_OF_MEMORY(err, "TurboJPEG");
    const pith_status status = decode(codec, name, bytes, size, raw, err);
    tjDestroy(codec);
    return status;
}

pith_status jpeg_encode(const raw_image *raw, int quality, unsigned char **bytes, size_t *size, pith_error *err)
{
    /* No chroma subsampling: strips of texture are small and their colours sharp. */
    const int sampling = raw->channels == 1 ? TJSAMP_GRAY : TJSAMP_444;
    const int format = raw->channels == 1 ? TJPF_GRAY : TJPF_RGB;
    unsigned long capacity = tjBufSize((int)raw->width, (int)raw->height, sampling);
    tjhandle codec = tjInitCompress();
    unsigned char *out = codec && capacity != (unsigned long)-1 ? pith_alloc(capacity, 1) : NULL;
    pith_status status = PITH_OK;
    if (!out)
        status = PITH_OUT_OF_MEMORY(err, "a JPEG");
    else if (tjCompress2(codec, raw->samples, (int)raw->width, 0, (int)raw->height, format, &out, &capacity, sampling,
                         quality, TJFLAG_ACCURATEDCT | TJFLAG_NOREALLOC) != 0)
        status = pith_fail(err, PITH_EXTERNAL, "JPEG cannot be encoded: %s", tjGetErrorStr2(codec));
    if (codec) tjDestroy(codec);
    if (status == PITH_OK) {
        *bytes = out;
        *size = capacity;
    } else {
        pith_free(out);
    }
    return status;
}
