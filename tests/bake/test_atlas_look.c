/* A baked surface looks as its solid does: both are ray-traced, the solid itself and the atlas, whose texels are laid on
   a mesh finer than they are; and the finer the atlas the nearer they come. */
#include "check.h"
#include "pith/bake.h"
#include "pith/document.h"

#include <unistd.h>

static pith_error err;

/* Bilinear, as graphics cards do it: texel centres at halves, origin of the coordinates at the lower left. */
static void look_up(const pith_image *image, double u, double v, float out[4])
{
    const double x = u * image->width - 0.5, y = (1.0 - v) * image->height - 0.5;
    const double x0 = floor(x), y0 = floor(y);
    double sum[4] = { 0, 0, 0, image->channels == 4 ? 0.0 : 1.0 };
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const double weight = (i ? x - x0 : 1.0 - x + x0) * (j ? y - y0 : 1.0 - y + y0);
            const double column = fmin(image->width - 1, fmax(0, x0 + i)),
                         row = fmin(image->height - 1, fmax(0, y0 + j));
            const float *p = image->pixels + ((size_t)row * image->width + (size_t)column) * image->channels;
            for (uint32_t c = 0; c < image->channels; ++c) sum[c] += weight * (double)p[c];
        }
    for (int c = 0; c < 4; ++c) out[c] = (float)sum[c];
}

/* Every triangle divided evenly until its pieces are half a texel, with the atlas's colours at their corners. */
static pith_mesh *coloured(const pith_textured *textured, double density)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    uint32_t *parts = malloc(m.triangle_count * sizeof *parts), vertices = 0, triangles = 0;
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        double longest = 0.0;
        for (int k = 0; k < 3; ++k)
            longest =
                fmax(longest, pith_distance(m.positions[m.triangles[t][k]], m.positions[m.triangles[t][(k + 1) % 3]]));
        parts[t] = (uint32_t)ceil(fmax(1.0, 2.0 * longest * density));
        vertices += (parts[t] + 1) * (parts[t] + 2) / 2;
        triangles += parts[t] * parts[t];
    }
    pith_vec3 *positions = malloc(vertices * sizeof *positions), *normals = malloc(vertices * sizeof *normals);
    float(*colours)[4] = malloc(vertices * sizeof *colours);
    uint32_t(*list)[3] = malloc(triangles * sizeof *list), vertex = 0, triangle = 0;
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        const uint32_t *v = m.triangles[t], n = parts[t];
        for (uint32_t j = 0; j <= n; ++j)
            for (uint32_t i = 0; i + j <= n; ++i, ++vertex) {
                const double w[3] = { 1.0 - (double)(i + j) / n, (double)i / n, (double)j / n };
                double uv[2] = { 0, 0 };
                positions[vertex] = normals[vertex] = pith_v3(0, 0, 0);
                for (int k = 0; k < 3; ++k) {
                    positions[vertex] = pith_madd(positions[vertex], m.positions[v[k]], w[k]);
                    normals[vertex] = pith_madd(normals[vertex], m.normals[v[k]], w[k]);
                    for (int d = 0; d < 2; ++d) uv[d] += w[k] * (double)m.texcoords[v[k]][d];
                }
                normals[vertex] = pith_unit(normals[vertex]);
                look_up(textured->texture, uv[0], uv[1], colours[vertex]);
                const uint32_t right = vertex + 1, up = vertex + n + 1 - j;
                if (i + j < n) memcpy(list[triangle++], ((uint32_t[3]){ vertex, right, up }), sizeof *list);
                if (i + j + 1 < n) memcpy(list[triangle++], ((uint32_t[3]){ right, up + 1, up }), sizeof *list);
            }
    }
    const pith_mesh_view view = { .positions = positions,
                                  .normals = normals,
                                  .colours = (const float(*)[4])colours,
                                  .triangles = (const uint32_t(*)[3])list,
                                  .vertex_count = vertices,
                                  .triangle_count = triangles };
    pith_mesh *mesh = NULL;
    assert_true(vertex == vertices && triangle == triangles);
    CHECK_OK(pith_mesh_create(&view, &mesh, &err));
    free(parts);
    free(positions);
    free(normals);
    free(colours);
    free(list);
    return mesh;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return x < y ? -1 : x > y;
}

typedef struct difference {
    double mean, worst_percent;
} difference;

/* Of what is seen of the model, as encoded values of 0..1. */
static difference compare(const pith_image *a, const pith_image *b)
{
    const size_t pixels = (size_t)a->width * a->height;
    double *off = malloc(pixels * sizeof *off), sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (a->pixels[4 * i + 3] < 0.999f || b->pixels[4 * i + 3] < 0.999f) continue;
        off[count] = 0.0;
        for (int c = 0; c < 3; ++c)
            off[count] = fmax(off[count], fabs((double)pith_srgb_encode(a->pixels[4 * i + c]) -
                                               (double)pith_srgb_encode(b->pixels[4 * i + c])));
        sum += off[count++];
    }
    assert_true(count > pixels / 8);
    qsort(off, count, sizeof *off, by_value);
    const difference found = { sum / (double)count, off[count * 99 / 100] };
    free(off);
    return found;
}

/* The example as it is and as it is baked, seen with so many pixels per model unit. */
static difference bake_and_compare(const char *name, double density, uint32_t height)
{
    char path[500];
    snprintf(path, sizeof path, "%s/examples/%s.pith", PITH_SOURCE_DIR, name);
    pith_document *document = NULL;
    pith_model *model = NULL;
    const pith_model_options fresh = { .cache = false };
    const pith_render_item *items;
    size_t count;
    pith_camera camera;
    pith_render_options options;
    CHECK_OK(pith_document_load(path, &document, &err));
    CHECK_OK(pith_model_create(document, &fresh, NULL, &model, &err));
    CHECK_OK(pith_model_items(model, &items, &count, &err));
    CHECK_OK(pith_model_view(model, &camera, &options, &err));
    options.height = height;
    options.width = height * 4 / 3;
    options.samples = 9;
    options.gloss = 0; /* skin and section shine differently, and plain meshes do not know which they are */
    options.transparent = true;
    options.ground = false;

    pith_image *solid = NULL, *baked = NULL;
    CHECK_OK(pith_render(items, count, &camera, &options, NULL, &solid, &err));
    pith_atlas_item *surfaces = malloc(count * sizeof *surfaces);
    for (size_t i = 0; i < count; ++i)
        surfaces[i] = (pith_atlas_item){ items[i].shell, items[i].solid, items[i].offset };
    pith_atlas_options atlas = pith_atlas_options_default();
    atlas.density = density;
    pith_textured *textured = NULL;
    pith_atlas_report report;
    CHECK_OK(pith_bake_atlas(surfaces, count, &atlas, NULL, &textured, &report, &err));
    pith_mesh *mesh = coloured(textured, density);
    const pith_render_item item = { .mesh = mesh };
    CHECK_OK(pith_render(&item, 1, &camera, &options, NULL, &baked, &err));
    const difference found = compare(solid, baked);
    print_message("%s at %g texels a unit, %u charts, %u x %u: differs by %.4f in the mean, 1 %% by more than %.4f\n",
                  name, density, report.charts, report.width, report.height, found.mean, found.worst_percent);
    const char *pictures = getenv("PITH_TEST_PICTURES"); /* a folder: where to look at both */
    for (int i = 0; pictures && i < 2; ++i) {
        snprintf(path, sizeof path, "%s/%s_%g_%s.png", pictures, name, density, i ? "baked" : "solid");
        CHECK_OK(pith_image_write(i ? baked : solid, path, 90, &err));
    }
    pith_mesh_destroy(mesh);
    pith_textured_destroy(textured);
    free(surfaces);
    pith_image_destroy(solid);
    pith_image_destroy(baked);
    pith_model_destroy(model);
    pith_document_destroy(document);
    return found;
}

static void test_the_kiwi(void **state)
{
    (void)state;
    const difference coarse = bake_and_compare("kiwi", 40, 180), fine = bake_and_compare("kiwi", 120, 180);
    CHECK_AT_MOST(fine.mean, 0.006);
    CHECK_AT_MOST(fine.worst_percent, 0.06);
    CHECK_AT_MOST(fine.mean, 0.5 * coarse.mean);
}

/* Several bodies, layers of cake between smooth cream. */
static void test_the_cake(void **state)
{
    (void)state;
    const difference found = bake_and_compare("cake", 50, 180);
    CHECK_AT_MOST(found.mean, 0.01);
    CHECK_AT_MOST(found.worst_percent, 0.1);
}

int main(void)
{
    const struct CMUnitTest tests[] = { cmocka_unit_test(test_the_kiwi), cmocka_unit_test(test_the_cake) };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
