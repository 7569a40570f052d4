/** pith/base.h: what every room stands on.
 *
 *  Status and messages, memory, vectors, random numbers, threads, progress, parameter tables, whole-file reading and
 *  writing. Nothing here prints, exits or keeps state that changes a result.
 *
 *  Conventions of the whole library
 *  - a function that can fail returns pith_status; its last argument `pith_error *err` may be NULL and holds one
 *    sentence for a human after a failure. A failed call leaves its outputs untouched and leaks nothing.
 *  - the object a call creates is an out-pointer before `err`; the caller destroys it; destroying NULL is allowed.
 *  - geometry is double, in the unit of the input mesh; colours are float, linear RGB, not premultiplied.
 *  - indices are uint32_t; PITH_NONE marks "no such element".
 */
#ifndef PITH_BASE_H
#define PITH_BASE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define PITH_VERSION_TEXT "0.1.0"
#define PITH_NONE UINT32_MAX

/* ---- status -------------------------------------------------------------------------------------------------- */

typedef enum pith_status {
    PITH_OK = 0,
    PITH_BAD_ARGUMENT,  /* a value the caller passed is out of range or NULL */
    PITH_BAD_FILE,      /* a file's content is not what its format promises */
    PITH_IO,            /* the operating system refused: missing file, no permission, disk full */
    PITH_BAD_MESH,      /* geometry that cannot be used: open, not finite, index out of range */
    PITH_BAD_DOCUMENT,  /* a .pith document says something impossible; the message names the place */
    PITH_NO_MEMORY,
    PITH_NOT_CONVERGED, /* an iteration stopped before its tolerance */
    PITH_CANCELLED,     /* the progress callback said stop */
    PITH_EXTERNAL       /* a helper program or third-party library failed */
} pith_status;

typedef struct pith_error {
    pith_status status;
    char message[600];
} pith_error;

/** Writes the sentence into err (when not NULL) and returns status. printf-checked. */
pith_status pith_fail(pith_error *err, pith_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/** Puts "context: " before the message already in err; returns err's status, or `status` when err is NULL. */
pith_status pith_fail_in(pith_error *err, pith_status status, const char *context, ...)
    __attribute__((format(printf, 3, 4)));

/** The status as a word, e.g. "bad mesh"; never NULL. */
const char *pith_status_text(pith_status status);

/** Runs a call, and returns its status from the calling function when it failed. */
#define PITH_TRY(call)                                                                                                 \
    do {                                                                                                               \
        const pith_status try_status_ = (call);                                                                        \
        if (try_status_ != PITH_OK) return try_status_;                                                                \
    } while (0)

/** The same for functions that clean up at a label: sets the variable `status` and jumps. */
#define PITH_TRY_OR(label, call)                                                                                       \
    do {                                                                                                               \
        status = (call);                                                                                               \
        if (status != PITH_OK) goto label;                                                                             \
    } while (0)

/* ---- memory -------------------------------------------------------------------------------------------------- */

/** count * size zeroed bytes, 64-byte aligned so that vector loads may be aligned; NULL when the product overflows or
 *  memory is out. count 0 gives a valid pointer. Free with pith_free. */
void *pith_alloc(size_t count, size_t size) __attribute__((malloc));
/** Frees what pith_alloc or pith_grow gave; NULL is allowed. */
void pith_free(void *pointer);
/** Makes room for `needed` elements of `size` bytes in *data (which holds *capacity), growing by half at a time; old
 *  content stays, new bytes are zero. Returns false, with everything unchanged, when memory is out. */
bool pith_grow(void **data, size_t *capacity, size_t needed, size_t size);
/** For tests: the n-th allocation from now on in this process fails, and every one after it; SIZE_MAX switches off. */
void pith_memory_fail_after(size_t n);
/** Largest resident set of this process so far, bytes (getrusage). */
size_t pith_memory_peak(void);

/** "pith_alloc failed" as a status, naming the function and what it wanted memory for. */
#define PITH_OUT_OF_MEMORY(err, what) pith_fail((err), PITH_NO_MEMORY, "%s: out of memory for %s", __func__, (what))

/* ---- vectors ------------------------------------------------------------------------------------------------- */

typedef struct pith_vec3 { double x, y, z; } pith_vec3;
typedef struct pith_vec2 { double x, y; } pith_vec2;
typedef struct pith_box { pith_vec3 low, high; } pith_box;   /* empty when low.x > high.x */
typedef struct pith_plane { pith_vec3 point, normal; } pith_plane; /* normal needs no unit length, must not be zero */

static inline pith_vec3 pith_v3(double x, double y, double z) { return (pith_vec3){ x, y, z }; }
static inline pith_vec3 pith_add(pith_vec3 a, pith_vec3 b) { return pith_v3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline pith_vec3 pith_sub(pith_vec3 a, pith_vec3 b) { return pith_v3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline pith_vec3 pith_scale(pith_vec3 a, double k) { return pith_v3(a.x * k, a.y * k, a.z * k); }
static inline pith_vec3 pith_madd(pith_vec3 a, pith_vec3 b, double k) { return pith_add(a, pith_scale(b, k)); }
static inline double pith_dot(pith_vec3 a, pith_vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline pith_vec3 pith_cross(pith_vec3 a, pith_vec3 b)
{
    return pith_v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline double pith_length(pith_vec3 a) { return sqrt(pith_dot(a, a)); }
static inline double pith_distance(pith_vec3 a, pith_vec3 b) { return pith_length(pith_sub(a, b)); }
static inline pith_vec3 pith_lerp(pith_vec3 a, pith_vec3 b, double t) { return pith_madd(a, pith_sub(b, a), t); }
static inline bool pith_finite(pith_vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
/** a / |a|; the zero vector stays zero. */
static inline pith_vec3 pith_unit(pith_vec3 a)
{
    const double l = pith_length(a);
    return l > 0.0 ? pith_scale(a, 1.0 / l) : pith_v3(0, 0, 0);
}
/** a without its part along the unit vector n. */
static inline pith_vec3 pith_reject(pith_vec3 a, pith_vec3 n) { return pith_madd(a, n, -pith_dot(a, n)); }
/** Some unit vector perpendicular to the unit vector n; a fixed, continuous-almost-everywhere choice. */
pith_vec3 pith_perpendicular(pith_vec3 n);
/** Six times the signed volume of the tetrahedron abcd; positive when d sees a,b,c counter-clockwise... from outside,
 *  that is when (b-a) x (c-a) points towards d. Every tetrahedron in pith is stored with a positive volume. */
static inline double pith_volume6(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d)
{
    return pith_dot(pith_cross(pith_sub(b, a), pith_sub(c, a)), pith_sub(d, a));
}
/** Barycentric coordinates of p in the tetrahedron (a,b,c,d); they sum to 1 and may be negative outside.
 *  Returns false, weights untouched, for a tetrahedron without volume. */
bool pith_barycentric(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, pith_vec3 p, double weights[4]);
/** Gradients (1/length unit) of the four barycentric coordinates; false when the tetrahedron has no volume. */
bool pith_barycentric_gradients(pith_vec3 a, pith_vec3 b, pith_vec3 c, pith_vec3 d, pith_vec3 gradients[4]);
static inline pith_box pith_box_empty(void)
{
    return (pith_box){ { INFINITY, INFINITY, INFINITY }, { -INFINITY, -INFINITY, -INFINITY } };
}
static inline void pith_box_add(pith_box *box, pith_vec3 p)
{
    box->low = pith_v3(fmin(box->low.x, p.x), fmin(box->low.y, p.y), fmin(box->low.z, p.z));
    box->high = pith_v3(fmax(box->high.x, p.x), fmax(box->high.y, p.y), fmax(box->high.z, p.z));
}
/** Box of count points; empty for count 0. */
pith_box pith_box_of(const pith_vec3 *points, size_t count);
/** The place of a cell along a curve that fills space and keeps neighbours near each other: the low 21 bits of its
 *  numbers, taken in turn. Morton, "A Computer Oriented Geodetic Data Base and a New Technique in File Sequencing", IBM,
 *  1966. */
uint64_t pith_morton(uint64_t x, uint64_t y, uint64_t z);

/* ---- colour ---------------------------------------------------------------------------------------------------- */

/** sRGB transfer function, IEC 61966-2-1: a stored colour value to a linear one and back; both clamp to 0..1, NaN gives
 *  0. Used at file borders only. */
float pith_srgb_decode(double encoded);
float pith_srgb_encode(double linear);

/** Oklab (Ottosson, "A perceptual color space for image processing", 2020) of linear sRGB and back: lightness, green to
 *  red, blue to yellow; equal distances look about equally different. White is (1, 0, 0). Any number goes in, negative
 *  ones too; the way there and back loses some 1e-7, which is what the published matrices hold. */
void pith_oklab_from_rgb(const double rgb[3], double lab[3]);
void pith_oklab_to_rgb(const double lab[3], double rgb[3]);

/* ---- random numbers ------------------------------------------------------------------------------------------ */

/** PCG32 (O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good Algorithms", 2014): small state,
 *  the same sequence on every machine. One generator per stream of choices; never shared between threads. */
typedef struct pith_rng { uint64_t state, increment; } pith_rng;
pith_rng pith_rng_make(uint64_t seed, uint64_t stream);
uint32_t pith_rng_u32(pith_rng *rng);
double pith_rng_unit(pith_rng *rng);                      /* [0, 1), 53 random bits */
uint32_t pith_rng_below(pith_rng *rng, uint32_t bound);   /* [0, bound) without bias; bound > 0 */
pith_vec3 pith_rng_direction(pith_rng *rng);              /* uniform on the unit sphere */
double pith_rng_normal(pith_rng *rng);                    /* mean 0, deviation 1 */
/** A well-mixed 64-bit hash of a value: random access where a sequence would depend on order (splitmix64 finaliser). */
uint64_t pith_mix64(uint64_t value);
/** 64-bit FNV-1a style hash of bytes, for cache keys and golden hashes; start with seed 0 or chain a former hash. */
uint64_t pith_hash_bytes(const void *bytes, size_t size, uint64_t seed);

/* ---- threads, progress, time --------------------------------------------------------------------------------- */

/** Threads that parallel loops use: pith_threads_set's value, else PITH_THREADS, else the processors of this machine.
 *  Never changes a result. Loops say `#pragma omp parallel for num_threads(pith_threads())`. */
int pith_threads(void);
void pith_threads_set(int threads);                       /* below 1: back to the default */
double pith_seconds(void);                                /* monotonic clock */

/** Called from the thread that runs the long call, never concurrently. fraction in 0..1, what in a few words.
 *  Returns false to cancel. */
typedef struct pith_progress {
    bool (*report)(void *user, double fraction, const char *what);
    void *user;
} pith_progress;
/** Reports when progress is not NULL; PITH_CANCELLED with a sentence when the callback said stop. */
pith_status pith_progress_step(const pith_progress *progress, double fraction, const char *what, pith_error *err);

/* ---- parameter tables ---------------------------------------------------------------------------------------- */

typedef enum pith_param_type {
    PITH_PARAM_DOUBLE,  /* double */
    PITH_PARAM_UINT,    /* uint32_t */
    PITH_PARAM_SEED,    /* uint64_t; range is all integers a double holds exactly, 0 .. 2^53 */
    PITH_PARAM_BOOL,    /* bool */
    PITH_PARAM_CHOICE   /* uint32_t index into choices */
} pith_param_type;

/** One option: feeds the range check, the document's keys and schema, the command line's help, the docs. */
typedef struct pith_param {
    const char *name;   /* as in documents and flags: lower case, words joined by '_' */
    const char *unit;   /* "1" for a pure number */
    const char *help;   /* one line, says what more of it does */
    pith_param_type type;
    double lowest, standard, highest; /* inclusive; for a choice 0 .. count-1 */
    size_t offset;      /* in the options struct */
    const char *const *choices; /* NULL-terminated words, for PITH_PARAM_CHOICE */
} pith_param;

typedef struct pith_params {
    const char *name;   /* the options' name, e.g. "lapped" */
    const pith_param *items;
    size_t count;
    size_t size;        /* sizeof the options struct */
} pith_params;

/** Fills every option of the table with its standard value; bytes outside the table become zero. */
void pith_params_defaults(const pith_params *table, void *options);
/** PITH_BAD_ARGUMENT naming option, value and range for the first option out of range (NaN is). */
pith_status pith_params_check(const pith_params *table, const void *options, pith_error *err);
/** The entry called name, or NULL. */
const pith_param *pith_params_find(const pith_params *table, const char *name);
/** Reads and writes one option as a number (bool: 0/1; choice: its index). Set checks the range. */
double pith_param_get(const pith_param *param, const void *options);
pith_status pith_param_set(const pith_param *param, void *options, double value, pith_error *err);
/** Sets a choice by its word; the message lists the words and offers the nearest. */
pith_status pith_param_set_word(const pith_param *param, void *options, const char *word, pith_error *err);
/** The candidate (NULL-terminated list) nearest to word by edit distance, or NULL when none is near. */
const char *pith_nearest_word(const char *word, const char *const *candidates);

/* ---- whole files --------------------------------------------------------------------------------------------- */

/** Reads a file; *bytes has one zero byte behind `size` so that text parsers may run to it. Free with pith_free.
 *  Files above 4 GiB are refused. */
pith_status pith_file_read(const char *path, unsigned char **bytes, size_t *size, pith_error *err);
/** Writes beside the target and renames over it: the file is old or new, never half. */
pith_status pith_file_write(const char *path, const void *bytes, size_t size, pith_error *err);
/** Files that belong together: all are written beside their targets before the first is renamed over its own, in order;
 *  when one cannot be written none is. */
typedef struct pith_file_part { const char *path; const void *bytes; size_t size; } pith_file_part;
pith_status pith_files_write(const pith_file_part *files, size_t count, pith_error *err);
/** Lower-case extension without the dot, "" when there is none; points into a static table of known ones or path. */
bool pith_path_has_extension(const char *path, const char *extension); /* case-insensitive, without the dot */
bool pith_file_exists(const char *path);
/** directory of `base` joined with `relative` (copied when absolute); caller frees with pith_free; NULL: no memory. */
char *pith_path_join(const char *base_file, const char *relative);

#endif
