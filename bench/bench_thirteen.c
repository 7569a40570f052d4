/* pith bench diffusion, third part: the thirteen objects of Takayama 2011, table 6.1, as the shipped documents have them:
   how long their sections take, how far the colours are from those of a million rays, and how large the documents are.
   Beside each figure stands the thesis's. */
#include "bench.h"

#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "pith/diffusion_section.h"

enum { CHECKED = 24, REFERENCE_RAYS = 1 << 20 };

typedef struct row {
    const char *name;
    double cut_s; /* table 6.1, as the columns that follow */
    int faces, kilobytes;
    const char *mesh; /* what the document reads beside itself; NULL: nothing */
} row;

static const row table[] = {
    { "tomato", 6.1, 20412, 669, NULL },        { "onion", 1.9, 8110, 264, NULL },
    { "persimmon", 8.1, 18208, 584, NULL },     { "pepper", 6.8, 18328, 592, NULL },
    { "avocado", 0.8, 5341, 172, NULL },        { "apple", 3.3, 7685, 255, NULL },
    { "okra", 3.7, 18480, 597, NULL },          { "star_fruit", 3.2, 12190, 400, NULL },
    { "strawberry", 7.7, 32049, 1110, NULL },   { "cucumber", 7.9, 28592, 942, NULL },
    { "kiwi", 27.7, 38688, 1321, NULL },        { "volcano", 10.9, 20673, 690, NULL },
    { "kidney", 3.9, 5694, 185, "kidney.glb" },
};

/* ---- how far off ----------------------------------------------------------------------------------------------------- */

static double squared_distance(const float a[4], const float b[4])
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        const double off = (double)pith_srgb_encode((double)a[k]) - (double)pith_srgb_encode((double)b[k]);
        sum += off * off / 3.0;
    }
    return sum;
}

static double triangle_area(const pith_diffusion_section_view *view, uint32_t t)
{
    const uint32_t *c = view->triangles[t];
    const pith_vec3 *p = view->positions;
    return 0.5 * pith_length(pith_cross(pith_sub(p[c[1]], p[c[0]]), pith_sub(p[c[2]], p[c[0]])));
}

/* Points of the section, even over its area, with the colours that it shows there. */
static void strew(const pith_diffusion_section_view *view, pith_rng *rng, pith_vec3 *points, float (*colours)[4])
{
    double area = 0.0, passed = 0.0;
    uint32_t t = 0;
    for (uint32_t each = 0; each < view->triangle_count; ++each) area += triangle_area(view, each);
    for (int i = 0; i < CHECKED; ++i) {
        const double at = (i + pith_rng_unit(rng)) / CHECKED * area;
        while (t + 1 < view->triangle_count && passed + triangle_area(view, t) < at) passed += triangle_area(view, t++);
        const double u = sqrt(pith_rng_unit(rng)), v = pith_rng_unit(rng), w[3] = { 1.0 - u, u * (1.0 - v), u * v };
        points[i] = pith_v3(0, 0, 0);
        memset(colours[i], 0, sizeof colours[i]);
        for (int k = 0; k < 3; ++k) {
            const uint32_t c = view->triangles[t][k];
            points[i] = pith_add(points[i], pith_scale(view->positions[c], w[k]));
            for (int channel = 0; channel < 4; ++channel)
                colours[i][channel] += (float)(w[k] * (double)view->colours[c][channel]);
        }
    }
}

/* The sum of squares at all of them; that of colours between vertices has the share of the interpolation, too. */
static pith_status add_errors(const pith_diffusion *diffusion, const pith_diffusion_options *how,
                              const pith_diffusion_section_view *view, double *sum, pith_error *err)
{
    static pith_vec3 points[CHECKED];
    static float shown[CHECKED][4], wanted[CHECKED][4];
    pith_rng rng = pith_rng_make(11, 0);
    strew(view, &rng, points, shown);
    pith_diffusion_options fine = *how;
    fine.rays = REFERENCE_RAYS;
    fine.seed = 99; /* other directions than those that are judged */
    PITH_TRY(pith_diffusion_colours(diffusion, &fine, points, CHECKED, wanted, err));
    for (size_t i = 0; i < CHECKED; ++i) *sum += squared_distance(shown[i], wanted[i]);
    return PITH_OK;
}

/* ---- an object --------------------------------------------------------------------------------------------------------- */

typedef struct measured {
    bench_times times;
    double off; /* sum over the bodies, sRGB */
    int bodies, triangles, vertices, asked;
} measured;

/* The section of one body; the first time it is looked at, too. */
static pith_status section_of(pith_model *model, const pith_model_piece *piece, bool first, measured *to,
                              pith_error *err)
{
    pith_model *body = NULL;
    const pith_diffusion *diffusion = NULL;
    const pith_diffusion_options *how = NULL;
    const pith_diffusion_section_options options = pith_diffusion_section_options_default();
    pith_diffusion_section *made = NULL;
    PITH_TRY(pith_model_body(model, piece->body, &body, err));
    PITH_TRY(pith_model_diffusion(body, &diffusion, &how, err));
    const pith_shell_view shell = pith_shell_look(piece->shell);
    const pith_mesh_view cutting = { .positions = shell.material,
                                     .triangles = shell.triangles,
                                     .vertex_count = shell.vertex_count,
                                     .triangle_count = shell.triangle_count };
    const double begin = pith_seconds();
    PITH_TRY(pith_diffusion_section_create(diffusion, how, &options, &cutting, NULL, &made, err));
    to->times.seconds[to->times.count] += pith_seconds() - begin;
    const pith_diffusion_section_view view = pith_diffusion_section_look(made);
    pith_status status = PITH_OK;
    if (first && view.triangle_count > 0) {
        status = add_errors(diffusion, how, &view, &to->off, err);
        ++to->bodies;
        to->triangles += (int)pith_diffusion_triangles(diffusion);
        to->vertices += (int)view.vertex_count;
        to->asked += (int)view.asked;
    }
    pith_diffusion_section_destroy(made);
    return status;
}

/* All bodies that the plane meets, as `repeats` times and once before. */
static pith_status measure_plane(pith_model *model, const pith_plane *plane, int repeats, measured *to, pith_error *err)
{
    pith_model_piece *sections = NULL;
    size_t count = 0;
    PITH_TRY(pith_model_section(model, plane, &sections, &count, err));
    pith_status status = PITH_OK;
    for (int i = 0; status == PITH_OK && i <= repeats; ++i) {
        to->times.seconds[to->times.count] = 0.0;
        for (size_t k = 0; status == PITH_OK && k < count; ++k)
            status = section_of(model, &sections[k], i == 0, to, err);
        if (i > 0) ++to->times.count; /* the first is a warm-up, and written over */
    }
    pith_sections_free(sections, count);
    return status;
}

static double kilobytes(const char *name, const char *ending)
{
    char path[600];
    struct stat found;
    snprintf(path, sizeof path, PITH_SOURCE_DIR "/examples/surfaces/%s%s", name, ending);
    return stat(path, &found) == 0 ? (double)found.st_size / 1024.0 : NAN;
}

static pith_status run_object(const row *of, int repeats, json_t *cases, pith_error *err)
{
    static const struct {
        const char *name;
        pith_plane plane;
    } cuts[] = {
        { "along", { { 0.01, 0.03, 0.0 }, { 0, -1, 0 } } },
        { "across", { { 0.0, 0.0, 0.03 }, { 0, 0, 1 } } },
        { "oblique", { { 0.02, 0.01, 0.03 }, { 0.4, -0.5, 0.77 } } },
    };
    char path[600];
    pith_document *document = NULL;
    pith_model *model = NULL;
    static const pith_model_options options = { .cache = false };
    snprintf(path, sizeof path, PITH_SOURCE_DIR "/examples/surfaces/%s.pith", of->name);
    pith_status status = pith_document_load(path, &document, err);
    if (status == PITH_OK) status = pith_model_create(document, &options, NULL, &model, err);
    if (status == PITH_OK) status = pith_model_set_cuts(model, NULL, 0, err);
    for (size_t i = 0; status == PITH_OK && i < sizeof cuts / sizeof *cuts; ++i) {
        measured found = { 0 };
        char name[100];
        status = measure_plane(model, &cuts[i].plane, repeats, &found, err);
        if (status != PITH_OK) break;
        snprintf(name, sizeof name, "section, %s, %s", of->name, cuts[i].name);
        json_array_append_new(
            cases,
            json_pack("{ss si si sf sf sf si si sf sf si}", "name", name, "triangles", found.triangles,
                      "thesis_triangles", of->faces, "section_s", bench_min(&found.times), "section_median_s",
                      bench_median(&found.times), "thesis_section_s", of->cut_s, "vertices", found.vertices,
                      "asked_points", found.asked, "rms_error_srgb", sqrt(found.off / (CHECKED * (double)found.bodies)),
                      "document_kib", kilobytes(of->name, ".pith") + (of->mesh ? kilobytes(of->mesh, "") : 0.0),
                      "thesis_kib", of->kilobytes));
    }
    pith_model_destroy(model);
    pith_document_destroy(document);
    return status;
}

pith_status bench_thirteen(const bench_options *options, json_t *cases, pith_error *err)
{
    for (size_t i = 0; i < sizeof table / sizeof *table; ++i)
        PITH_TRY(run_object(&table[i], options->repeats, cases, err));
    return PITH_OK;
}
