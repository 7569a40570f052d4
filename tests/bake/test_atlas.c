/* Texture atlases against geometry, counting and the solid itself: what holds of density, charts and texels is checked
   from the mesh and the picture alone. */
#include "cut/bodies.h"
#include "pith/bake.h"

#include <string.h>

static pith_error err;

/* ---- what is baked ----------------------------------------------------------------------------------------------- */

/* Colours that change smoothly over [-1.6, 1.6]^3; opacity 1, or changing too. */
static pith_solid *smooth_solid(bool clear)
{
    const uint32_t size[3] = { 12, 12, 12 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 4, &grid, &err));
    grid->origin = pith_v3(-1.6, -1.6, -1.6);
    grid->spacing = pith_v3(3.2 / 12, 3.2 / 12, 3.2 / 12);
    for (uint32_t k = 0; k < 12; ++k)
        for (uint32_t j = 0; j < 12; ++j)
            for (uint32_t i = 0; i < 12; ++i) {
                float *v = grid->values + 4 * ((k * 12 + j) * 12 + i);
                v[0] = 0.5f + 0.4f * sinf(0.8f * (float)i);
                v[1] = 0.5f + 0.4f * cosf(0.7f * (float)j);
                v[2] = 0.1f + 0.07f * (float)k;
                v[3] = clear ? 0.25f + 0.05f * (float)i : 1.0f;
            }
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

/* The part of a ball below a slanted plane: skin and a section. */
static pith_shell *half_ball(uint32_t n)
{
    pith_part *part = body_part(n, true);
    double *values = calloc(pith_part_look(part).vertex_count, sizeof *values);
    const pith_plane plane = { { 0, 0, 0.07 }, { 0.1, 0.2, 1 } };
    CHECK_OK(pith_part_plane_values(part, &plane, values, &err));
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_cut(part, values, &shell, NULL, &err));
    free(values);
    pith_part_destroy(part);
    return shell;
}

/* A winding staircase without steps: a slab of two turns that rises by `rise` a turn. Its top looks up everywhere. */
static pith_shell *ramp(double rise)
{
    static const int orders[6][3] = { { 0, 1, 2 }, { 0, 2, 1 }, { 1, 0, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 2, 1, 0 } };
    enum { LONG = 48, WIDE = 3, HIGH = 1, SIDE = LONG + 1, ROW = SIDE * (WIDE + 1) };
    pith_vec3 positions[ROW * (HIGH + 1)];
    static uint32_t tets[LONG * WIDE * HIGH * 6][4];
    for (int k = 0; k <= HIGH; ++k)
        for (int j = 0; j <= WIDE; ++j)
            for (int i = 0; i <= LONG; ++i) {
                const double angle = 4.0 * M_PI * i / LONG, radius = 0.5 + 0.5 * j / WIDE;
                positions[k * ROW + j * SIDE + i] =
                    pith_v3(radius * cos(angle), radius * sin(angle), rise * angle / (2 * M_PI) + 0.3 * rise * k);
            }
    const uint32_t step[3] = { 1, SIDE, ROW };
    uint32_t count = 0;
    for (int j = 0; j < WIDE; ++j)
        for (int i = 0; i < LONG; ++i)
            for (int o = 0; o < 6; ++o, ++count) {
                tets[count][0] = (uint32_t)(j * SIDE + i);
                for (int a = 0; a < 3; ++a) tets[count][a + 1] = tets[count][a] + step[orders[o][a]];
            }
    const pith_tets_view view = {
        .positions = positions, .tets = (const uint32_t(*)[4])tets, .vertex_count = ROW * (HIGH + 1), .tet_count = count
    };
    pith_tets *made = NULL;
    pith_part *part = NULL;
    pith_shell *shell = NULL;
    CHECK_OK(pith_tets_create(&view, &made, &err));
    CHECK_OK(pith_part_whole(made, &part, &err));
    CHECK_OK(pith_part_shell(part, &shell, &err));
    pith_part_destroy(part);
    pith_tets_destroy(made);
    return shell;
}

static pith_textured *bake(const pith_shell *shell, const pith_solid *solid, const pith_atlas_options *options,
                           pith_atlas_report *report)
{
    const pith_atlas_item item = { shell, solid, { 0, 0, 0 } };
    pith_textured *textured = NULL;
    CHECK_OK(pith_bake_atlas(&item, 1, options, NULL, &textured, report, &err));
    assert_non_null(textured);
    return textured;
}

/* ---- geometry, seen from outside --------------------------------------------------------------------------------- */

static double cross2(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Corners in texels, y upwards. */
static void corners_of(const pith_textured *textured, uint32_t triangle, double p[3][2])
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    for (int k = 0; k < 3; ++k) {
        p[k][0] = (double)m.texcoords[m.triangles[triangle][k]][0] * textured->texture->width;
        p[k][1] = (double)m.texcoords[m.triangles[triangle][k]][1] * textured->texture->height;
    }
}

/* The point of a triangle nearest to a place by brute force over its edges; weights of it; distance in texels. */
static double nearest_on(double p[3][2], const double at[2], double weights[3])
{
    const double area = cross2(p[0], p[1], p[2]);
    for (int k = 0; k < 3; ++k) weights[k] = cross2(p[(k + 1) % 3], p[(k + 2) % 3], at) / area;
    if (area > 0 && weights[0] >= 0 && weights[1] >= 0 && weights[2] >= 0) return 0.0;
    double best = INFINITY;
    for (int k = 0; k < 3; ++k) {
        const double *a = p[k], *b = p[(k + 1) % 3], e[2] = { b[0] - a[0], b[1] - a[1] };
        const double t =
            fmin(1, fmax(0, ((at[0] - a[0]) * e[0] + (at[1] - a[1]) * e[1]) / fmax(1e-300, e[0] * e[0] + e[1] * e[1])));
        const double distance = hypot(a[0] + t * e[0] - at[0], a[1] + t * e[1] - at[1]);
        if (!(distance < best)) continue;
        best = distance;
        weights[k] = 1 - t;
        weights[(k + 1) % 3] = t;
        weights[(k + 2) % 3] = 0;
    }
    return best;
}

/* Singular values of the map from the surface to the atlas, texels per unit, by trying directions: the length of the
   image of a unit vector has its extremes there. */
static void extreme_densities(const pith_textured *textured, uint32_t triangle, double *least, double *most)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    const uint32_t *v = m.triangles[triangle];
    double p[3][2];
    corners_of(textured, triangle, p);
    const pith_vec3 e = pith_sub(m.positions[v[1]], m.positions[v[0]]),
                    f = pith_sub(m.positions[v[2]], m.positions[v[0]]);
    const pith_vec3 x = pith_unit(e), n = pith_unit(pith_cross(e, f)), y = pith_cross(n, x);
    const double det = pith_dot(e, x) * pith_dot(f, y);
    *least = INFINITY;
    *most = 0;
    for (int i = 0; i < 720; ++i) {
        const double angle = M_PI * i / 720, dx = cos(angle), dy = sin(angle);
        /* dx x + dy y = s e + t f */
        const double t = dy / pith_dot(f, y), s = (dx * pith_dot(f, y) - dy * pith_dot(f, x)) / det;
        const double length =
            hypot(s * (p[1][0] - p[0][0]) + t * (p[2][0] - p[0][0]), s * (p[1][1] - p[0][1]) + t * (p[2][1] - p[0][1]));
        *least = fmin(*least, length);
        *most = fmax(*most, length);
    }
}

/* Height over the longest edge, texels: how exactly single-precision coordinates can say the density. */
static double thickness(double p[3][2])
{
    double longest = 0;
    for (int k = 0; k < 3; ++k)
        longest = fmax(longest, hypot(p[k][0] - p[(k + 1) % 3][0], p[k][1] - p[(k + 1) % 3][1]));
    return fabs(cross2(p[0], p[1], p[2])) / longest;
}

static void check_density(const pith_textured *textured, const pith_atlas_options *o, const pith_atlas_report *report)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    double least = INFINITY, most = 0, allowed = 0;
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        double p[3][2], low, high;
        corners_of(textured, t, p);
        const double rounding = 1e-7 * textured->texture->height / thickness(p);
        if (!(rounding < 0.01)) continue;
        allowed = fmax(allowed, rounding);
        extreme_densities(textured, t, &low, &high);
        CHECK_AT_LEAST(low, o->density * (1 - rounding - 1e-9));
        CHECK_AT_MOST(high, o->density * o->stretch * (1 + rounding + 1e-6));
        least = fmin(least, low);
        most = fmax(most, high);
    }
    CHECK_NEAR(report->least_density, least,
               (1e-4 + allowed) * least); /* directions are tried a quarter of a degree apart */
    CHECK_NEAR(report->most_density, most, (1e-4 + allowed) * most);
}

/* The chart nearest to each texel's middle, by distance; and no texel is in two, nor covered twice. Returns how many are
   within the margin. charts [height][width], y upwards; PITH_NONE: none within the margin. */
static size_t paint_charts(const pith_textured *textured, double margin, uint32_t *charts)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    const uint32_t width = textured->texture->width, height = textured->texture->height;
    bool *covered = calloc((size_t)width * height, sizeof *covered);
    size_t painted = 0;
    memset(charts, 0xff, (size_t)width * height * sizeof *charts);
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        double p[3][2];
        corners_of(textured, t, p);
        const double low[2] = { fmin(fmin(p[0][0], p[1][0]), p[2][0]), fmin(fmin(p[0][1], p[1][1]), p[2][1]) };
        const double high[2] = { fmax(fmax(p[0][0], p[1][0]), p[2][0]), fmax(fmax(p[0][1], p[1][1]), p[2][1]) };
        CHECK_AT_LEAST(fmin(low[0], low[1]), margin - 1e-3); /* the margin lies in the picture too */
        CHECK_AT_MOST(high[0], width - margin + 1e-3);
        CHECK_AT_MOST(high[1], height - margin + 1e-3);
        for (uint32_t y = (uint32_t)fmax(0, low[1] - margin); y < height && y <= high[1] + margin; ++y)
            for (uint32_t x = (uint32_t)fmax(0, low[0] - margin); x < width && x <= high[0] + margin; ++x) {
                const double at[2] = { x + 0.5, y + 0.5 };
                double weights[3];
                const double distance = nearest_on(p, at, weights);
                if (distance > margin) continue;
                uint32_t *chart = &charts[(size_t)y * width + x];
                if (*chart != PITH_NONE && *chart != textured->charts[t])
                    fail_msg("texel %u, %u belongs to charts %u and %u", x, y, *chart, textured->charts[t]);
                painted += *chart == PITH_NONE;
                *chart = textured->charts[t];
                if (weights[0] > 1e-3 && weights[1] > 1e-3 && weights[2] > 1e-3) { /* well inside */
                    if (covered[(size_t)y * width + x]) fail_msg("texel %u, %u is covered twice", x, y);
                    covered[(size_t)y * width + x] = true;
                }
            }
    }
    free(covered);
    return painted;
}

static void check_layout(const pith_shell *shell, const pith_solid *solid, const pith_atlas_options *o)
{
    pith_atlas_report report;
    pith_textured *textured = bake(shell, solid, o, &report);
    const pith_image *image = textured->texture;
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    const pith_shell_view s = pith_shell_look(shell);
    CHECK_NEAR(report.width, image->width, 0);
    CHECK_NEAR(report.height, image->height, 0);
    CHECK_AT_MOST(fmax(image->width, image->height), o->max_size);

    /* The mesh is the shell, but for its seams; a chart is skin or section. */
    CHECK_NEAR(m.triangle_count, s.triangle_count, 0);
    uint8_t *kind = calloc(report.charts, 1);
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            CHECK_NEAR(pith_distance(m.positions[m.triangles[t][k]], s.positions[s.triangles[t][k]]), 0, 0);
            CHECK_NEAR(pith_length(m.normals[m.triangles[t][k]]), 1, 1e-12);
        }
        assert_true(textured->charts[t] < report.charts);
        kind[textured->charts[t]] |= (uint8_t)(1 << s.kinds[t]);
    }
    for (uint32_t c = 0; c < report.charts; ++c) assert_true(kind[c] == 1 || kind[c] == 2);
    free(kind);
    for (size_t i = 0; i < (size_t)image->width * image->height * image->channels; ++i)
        assert_true(image->pixels[i] >= 0.0f && image->pixels[i] <= 1.0f); /* gaps between charts too */
    check_density(textured, o, &report);
    uint32_t *charts = malloc((size_t)image->width * image->height * sizeof *charts);
    const double painted = (double)paint_charts(textured, o->margin, charts);
    const double filled = report.filled * image->width * image->height;
    /* Texels are filled whose samples, not middles, are near: half a texel more round every chart. */
    CHECK_AT_LEAST(filled, painted);
    CHECK_AT_MOST(filled, 1.25 * painted);
    print_message(
        "%u triangles at %g: %u charts, %u x %u, %.0f %% surface, %.0f %% filled, %.4g to %.4g texels a unit\n",
        m.triangle_count, o->density, report.charts, report.width, report.height, 100 * report.covered,
        100 * report.filled, report.least_density, report.most_density);
    free(charts);
    pith_textured_destroy(textured);
}

static void test_charts_never_overlap_and_keep_their_density(void **state)
{
    (void)state;
    pith_solid *solid = smooth_solid(false);
    pith_shell *ball = half_ball(8), *winding = ramp(0.6), *steep = ramp(0.05);
    pith_atlas_options o = pith_atlas_options_default();
    const double stretches[] = { 1.05, 1.3, 2.0 }, densities[] = { 7, 40, 150 };
    for (int s = 0; s < 3; ++s)
        for (int d = 0; d < 3; ++d) {
            o.stretch = stretches[s];
            o.density = densities[d];
            o.margin = 1 + 3 * (uint32_t)d;
            check_layout(ball, solid, &o);
        }
    for (int d = 0; d < 3; ++d) {
        o.density = densities[d];
        check_layout(winding, solid, &o);
        check_layout(steep, solid, &o);
    }
    pith_shell_destroy(ball);
    pith_shell_destroy(winding);
    pith_shell_destroy(steep);
    pith_solid_destroy(solid);
}

/* ---- texels ------------------------------------------------------------------------------------------------------ */

static void sample_at(const pith_solid *solid, pith_vec3 point, float out[4])
{
    CHECK_OK(pith_solid_sample(solid, &(pith_query){ .points = &point, .count = 1 }, out, &err));
}

static const float *texel(const pith_image *image, uint32_t x, uint32_t y)
{
    return image->pixels + ((size_t)(image->height - 1 - y) * image->width + x) * image->channels;
}

/* Asked once a texel, each holds the solid's answer at the nearest point of its chart. */
static void test_texels_are_the_solid_where_they_lie_and_in_the_margin(void **state)
{
    (void)state;
    pith_shell *shell = half_ball(6);
    pith_atlas_options o = pith_atlas_options_default();
    o.density = 30;
    o.samples = 1;
    o.margin = 5;
    for (int clear = 0; clear < 2; ++clear) {
        pith_solid *solid = smooth_solid(clear);
        pith_textured *textured = bake(shell, solid, &o, NULL);
        const pith_image *image = textured->texture;
        const pith_mesh_view m = pith_mesh_look(textured->mesh);
        CHECK_NEAR(image->channels, clear ? 4 : 3, 0);
        size_t inside = 0, beside = 0;
        double worst = 0;
        for (uint32_t y = 0; y < image->height; ++y)
            for (uint32_t x = 0; x < image->width; ++x) {
                const double at[2] = { x + 0.5, y + 0.5 };
                double best = INFINITY, weights[3] = { 0 };
                pith_vec3 point = { 0 };
                for (uint32_t t = 0; t < m.triangle_count; ++t) {
                    double p[3][2], w[3];
                    corners_of(textured, t, p);
                    const double distance = nearest_on(p, at, w);
                    if (!(distance < best)) continue;
                    best = distance;
                    memcpy(weights, w, sizeof w);
                    point = pith_v3(0, 0, 0);
                    for (int k = 0; k < 3; ++k) point = pith_madd(point, m.positions[m.triangles[t][k]], w[k]);
                }
                if (best > o.margin - 1e-3) continue;
                float expected[4];
                sample_at(solid, point, expected);
                for (uint32_t c = 0; c < image->channels; ++c)
                    worst = fmax(worst, fabs((double)texel(image, x, y)[c] - (double)expected[c]));
                *(best > 0 ? &beside : &inside) += 1;
            }
        print_message("%zu texels on the surface, %zu beside it, worst off by %.2g\n", inside, beside, worst);
        CHECK_AT_MOST(worst, 2e-4); /* single-precision coordinates */
        CHECK_AT_LEAST((double)inside, 5000);
        CHECK_AT_LEAST((double)beside, 1500);
        pith_textured_destroy(textured);
        pith_solid_destroy(solid);
    }
    pith_shell_destroy(shell);
}

/* Stripes in x, finer than texels can show. */
static pith_solid *striped_solid(uint32_t stripes)
{
    const uint32_t size[3] = { stripes, 1, 1 };
    pith_grid *grid = NULL;
    CHECK_OK(pith_grid_create(size, 3, &grid, &err));
    grid->origin = pith_v3(0, 0, 0);
    grid->spacing = pith_v3(1.0 / stripes, 1, 1);
    for (uint32_t i = 0; i < stripes; ++i)
        for (int c = 0; c < 3; ++c) grid->values[3 * i + c] = i % 2 ? 1.0f : 0.0f;
    pith_solid *solid = NULL;
    CHECK_OK(pith_solid_grid(grid, true, &solid, &err));
    pith_grid_destroy(grid);
    return solid;
}

/* How far texels are from the mean of the stripes, on the four sides of the cube that have all of them. */
static double unrest(const pith_textured *textured)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    double sum = 0, count = 0;
    for (uint32_t t = 0; t < m.triangle_count; ++t) {
        double p[3][2], w[3];
        corners_of(textured, t, p);
        if (fabs(m.normals[m.triangles[t][0]].x) > 0.5) continue;
        for (uint32_t y = 0; y < textured->texture->height; ++y)
            for (uint32_t x = 0; x < textured->texture->width; ++x) {
                if (nearest_on(p, (double[2]){ x + 0.5, y + 0.5 }, w) > 0) continue;
                sum += pow((double)texel(textured->texture, x, y)[0] - 0.5, 2);
                count += 1;
            }
    }
    return sqrt(sum / count);
}

static void test_more_samples_filter_what_texels_cannot_show(void **state)
{
    (void)state;
    pith_part *part = body_part(2, false);
    pith_shell *shell = NULL;
    CHECK_OK(pith_part_shell(part, &shell, &err));
    pith_solid *solid = striped_solid(178);
    pith_atlas_options o = pith_atlas_options_default();
    o.density = 61;
    double before = INFINITY;
    for (uint32_t samples = 1; samples <= 8; samples *= 2) {
        o.samples = samples;
        pith_textured *textured = bake(shell, solid, &o, NULL);
        const double now = unrest(textured);
        print_message("%u x %u samples: %.4f\n", samples, samples, now);
        CHECK_AT_MOST(now, 0.75 * before);
        before = now;
        pith_textured_destroy(textured);
    }
    CHECK_AT_MOST(before, 0.03);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
    pith_part_destroy(part);
}

/* ---- several ----------------------------------------------------------------------------------------------------- */

static void test_several_surfaces_share_an_atlas(void **state)
{
    (void)state;
    pith_shell *shells[2] = { half_ball(4), ramp(0.4) };
    pith_solid *solids[2] = { smooth_solid(false), striped_solid(3) };
    const pith_atlas_item items[2] = { { shells[0], solids[0], { 0, 0, 0 } }, { shells[1], solids[1], { 3, 4, 5 } } };
    pith_atlas_options o = pith_atlas_options_default();
    o.density = 50;
    o.samples = 1;
    pith_textured *textured = NULL;
    CHECK_OK(pith_bake_atlas(items, 2, &o, NULL, &textured, NULL, &err));
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    const uint32_t first = pith_shell_look(shells[0]).triangle_count;
    CHECK_NEAR(m.triangle_count, first + pith_shell_look(shells[1]).triangle_count, 0);
    size_t compared = 0;
    for (uint32_t t = 0; t < m.triangle_count; ++t) { /* at the texel's middle nearest to each triangle's own */
        const int which = t >= first;
        double p[3][2], w[3];
        corners_of(textured, t, p);
        const double at[2] = { floor((p[0][0] + p[1][0] + p[2][0]) / 3) + 0.5,
                               floor((p[0][1] + p[1][1] + p[2][1]) / 3) + 0.5 };
        if (nearest_on(p, at, w) > 0) continue;
        pith_vec3 point = pith_scale(items[which].offset, -1);
        for (int k = 0; k < 3; ++k) point = pith_madd(point, m.positions[m.triangles[t][k]], w[k]);
        float expected[4];
        sample_at(solids[which], point, expected);
        for (int c = 0; c < 3; ++c)
            CHECK_NEAR((double)texel(textured->texture, (uint32_t)at[0], (uint32_t)at[1])[c], (double)expected[c],
                       1e-3);
        ++compared;
    }
    CHECK_AT_LEAST((double)compared, 0.5 * m.triangle_count);
    pith_textured_destroy(textured);
    for (int i = 0; i < 2; ++i) {
        pith_shell_destroy(shells[i]);
        pith_solid_destroy(solids[i]);
    }
}

static uint64_t hash_of(const pith_textured *textured)
{
    const pith_mesh_view m = pith_mesh_look(textured->mesh);
    const pith_image *i = textured->texture;
    uint64_t hash = pith_hash_bytes(i->pixels, (size_t)i->width * i->height * i->channels * sizeof *i->pixels, 0);
    hash = pith_hash_bytes(m.texcoords, m.vertex_count * sizeof *m.texcoords, hash);
    hash = pith_hash_bytes(m.triangles, m.triangle_count * sizeof *m.triangles, hash);
    return pith_hash_bytes(textured->charts, m.triangle_count * sizeof *textured->charts, hash);
}

static void test_the_same_for_any_threads(void **state)
{
    (void)state;
    pith_shell *shell = half_ball(9);
    pith_solid *solid = smooth_solid(true);
    pith_atlas_options o = pith_atlas_options_default();
    o.density = 90;
    uint64_t first = 0;
    for (int threads = 1; threads <= 3; ++threads) {
        pith_threads_set(threads);
        pith_textured *textured = bake(shell, solid, &o, NULL);
        const uint64_t hash = hash_of(textured);
        if (threads == 1) first = hash;
        assert_true(hash == first);
        pith_textured_destroy(textured);
    }
    pith_threads_set(0);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static bool stop_late(void *user, double fraction, const char *what)
{
    (void)what;
    return ++*(int *)user < 3 || !(fraction > 0.2);
}

static void test_refusals_name_a_density_that_works(void **state)
{
    (void)state;
    pith_shell *shell = half_ball(5);
    pith_solid *solid = smooth_solid(false);
    const pith_atlas_item item = { shell, solid, { 0, 0, 0 } };
    pith_atlas_options o = pith_atlas_options_default();
    pith_textured *textured = NULL;
    const double densities[] = { 1e9, 5000, 150 };
    for (int i = 0; i < 3; ++i) {
        o.density = densities[i];
        o.max_size = 256;
        CHECK_FAILS(pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "would do");
        assert_null(textured);
        const char *at = strstr(err.message, "; ");
        assert_non_null(at);
        o.density = atof(at + 2);
        CHECK_AT_LEAST(o.density, 30); /* and is no silly one: 9.4 square units in 65 536 texels */
        CHECK_OK(pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err));
        pith_textured_destroy(textured);
        textured = NULL;
    }
    o.density = 1;
    o.margin = 64;
    CHECK_FAILS(pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "at any density");
    o = pith_atlas_options_default();
    CHECK_FAILS(pith_bake_atlas(&item, 0, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "no triangles");
    CHECK_FAILS(pith_bake_atlas(NULL, 0, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "items is NULL");
    const pith_atlas_item bad[2] = { item, { shell, NULL, { 0, 0, 0 } } }, far = { shell, solid, { 0, NAN, 0 } };
    CHECK_FAILS(pith_bake_atlas(bad, 2, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "solid of item 1 is NULL");
    CHECK_FAILS(pith_bake_atlas(&far, 1, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "offset of item 0");
    o.stretch = 1;
    CHECK_FAILS(pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "stretch is 1");
    o = pith_atlas_options_default();
    o.density = NAN;
    CHECK_FAILS(pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err), PITH_BAD_ARGUMENT, "density is");
    o.density = 60;
    int calls = 0;
    const pith_progress progress = { stop_late, &calls };
    assert_int_equal(pith_bake_atlas(&item, 1, &o, &progress, &textured, NULL, &err), PITH_CANCELLED);
    assert_null(textured);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

static void test_without_memory_nothing_is_made_and_nothing_leaks(void **state)
{
    (void)state;
    pith_shell *shell = half_ball(3);
    pith_solid *solid = smooth_solid(false);
    const pith_atlas_item item = { shell, solid, { 0, 0, 0 } };
    pith_atlas_options o = pith_atlas_options_default();
    o.density = 12;
    pith_threads_set(1);
    size_t n = 0;
    for (;; ++n) {
        pith_textured *textured = NULL;
        pith_memory_fail_after(n);
        const pith_status status = pith_bake_atlas(&item, 1, &o, NULL, &textured, NULL, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) {
            pith_textured_destroy(textured);
            break;
        }
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(textured);
    }
    pith_threads_set(0);
    CHECK_AT_LEAST((double)n, 50);
    pith_solid_destroy(solid);
    pith_shell_destroy(shell);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_charts_never_overlap_and_keep_their_density),
        cmocka_unit_test(test_texels_are_the_solid_where_they_lie_and_in_the_margin),
        cmocka_unit_test(test_more_samples_filter_what_texels_cannot_show),
        cmocka_unit_test(test_several_surfaces_share_an_atlas),
        cmocka_unit_test(test_the_same_for_any_threads),
        cmocka_unit_test(test_refusals_name_a_density_that_works),
        cmocka_unit_test(test_without_memory_nothing_is_made_and_nothing_leaks),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
