/* Looks at the fields of bodies whose fields are known: a slab in which depth is linear in z, so that every layer is
   flat and every line straight, and a ball whose depth is radial. */
#include "document_samples.h"
#include "field/line_measures.h"

static pith_error err;

/* Two planes of points: the thin plate through them is the plane z = 0.8 (1 - depth). */
#define SLAB(more)                                                                                                     \
    "{ \"pith\": 1, \"shape\": { \"slab\": { \"radius_x\": 1, \"radius_y\": 0.7, \"power\": 20, \"bottom\": 0,"        \
    " \"top\": 0.8, \"detail\": 16 }, \"tets\": { \"tetrahedra\": 2000 } }" more " }"
#define DEPTH                                                                                                          \
    ", \"depth\": { \"constraints\": [ { \"depth\": 0, \"points\":"                                                    \
    " [[-0.8, -0.5, 0.8], [-0.8, 0.5, 0.8], [0.8, -0.5, 0.8], [0.8, 0.5, 0.8]] }, { \"depth\": 1, \"points\":"         \
    " [[-0.8, -0.5, 0], [-0.8, 0.5, 0], [0.8, -0.5, 0], [0.8, 0.5, 0]] } ] }"
#define STROKE ", \"direction\": { \"strokes\": [ [[-0.9, 0, 0.4], [0.9, 0, 0.4]] ] }"
#define VECTORS ", \"vectors\": { \"voxels\": 24, \"inside\": [ [[0, -0.6, 0.4], [0, 0.6, 0.4]] ] }"
static const char slab[] = SLAB(DEPTH STROKE), bare[] = SLAB(DEPTH), flow[] = SLAB(DEPTH VECTORS);
static const char only_flow[] = SLAB(VECTORS), all[] = SLAB(DEPTH STROKE VECTORS), none[] = SLAB("");
static const char ball[] =
    "{ \"pith\": 1, \"shape\": { \"fruit\": { \"detail\": 3 }, \"tets\": { \"tetrahedra\": 2500 } }, \"depth\": {"
    " \"constraints\": [ { \"faces\": \"all\", \"depth\": 0 }, { \"points\": [[0, 0, 0]], \"depth\": 1 } ] } }";
static const double diagonal = 2.5690465157330259; /* of 2 x 1.4 x 0.8 */

typedef struct looked { pith_document *document; pith_model *model; pith_look *look; pith_look_view view; } looked;

static pith_status open_look(const char *text, pith_look_of of, bool layers, looked *l)
{
    *l = (looked){ 0 };
    CHECK_OK(parse_text(text, &l->document, &err));
    const pith_model_options uncached = { .cache = false };
    CHECK_OK(pith_model_create(l->document, &uncached, NULL, &l->model, &err));
    pith_look_options options = pith_look_options_default();
    options.of = of;
    options.layers = layers;
    const pith_status status = pith_look_create(l->model, &options, &l->look, &err);
    if (status == PITH_OK) l->view = pith_look_see(l->look);
    return status;
}

static void close_look(looked *l)
{
    pith_look_destroy(l->look);
    pith_model_destroy(l->model);
    pith_document_destroy(l->document);
}

/* ---- what is looked at ------------------------------------------------------------------------------------------- */

static void test_what_is_followed(void **state)
{
    (void)state;
    static const struct { const char *text; pith_look_of any, any_layers; int follows;
    } cases[] = {
        { slab, PITH_LOOK_SECONDARY, PITH_LOOK_SECONDARY, 0 },
        { bare, PITH_LOOK_PRIMARY, PITH_LOOK_SECONDARY, 2 },
        { flow, PITH_LOOK_VECTORS, PITH_LOOK_VECTORS, 1 },
        { all, PITH_LOOK_VECTORS, PITH_LOOK_SECONDARY, 1 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        looked l;
        CHECK_OK(open_look(cases[i].text, PITH_LOOK_ANY, false, &l));
        assert_int_equal(l.view.of, cases[i].any);
        assert_int_equal(l.view.has_depth, true);
        assert_int_equal(l.view.has_direction, strstr(cases[i].text, "direction") != NULL);
        assert_int_equal(l.view.has_vectors, strstr(cases[i].text, "vectors") != NULL);
        assert_int_equal(l.view.runs_on_layers, cases[i].any != PITH_LOOK_PRIMARY);
        CHECK_NEAR(l.view.lowest, 0, 1e-6);
        CHECK_NEAR(l.view.highest, 1, 1e-6);
        CHECK_NEAR(pith_distance(l.view.box.low, l.view.box.high), diagonal, 1e-9);
        assert_int_equal(l.view.singular, 0); /* all frames are the same */
        const pith_vec3 middle = { 0.1, 0.05, 0.4 }, outside = { 0.1, 0.05, 0.9 };
        pith_vec3 v[2];
        l.view.directions.sample(l.view.directions.user, &middle, 1, &v[0]);
        l.view.directions.sample(l.view.directions.user, &outside, 1, &v[1]);
        CHECK_AT_LEAST(fabs((&v[0].x)[cases[i].follows]) / pith_length(v[0]), cos(0.02));
        CHECK_NEAR(pith_length(v[1]), 0, 0);
        close_look(&l);
        CHECK_OK(open_look(cases[i].text, PITH_LOOK_ANY, true, &l));
        assert_int_equal(l.view.of, cases[i].any_layers);
        assert_int_equal(l.view.directions.sample != NULL, cases[i].any != PITH_LOOK_PRIMARY);
        assert_int_equal(l.view.runs_on_layers, l.view.directions.sample != NULL);
        close_look(&l);
    }
    looked l; /* the tertiary ones are across both */
    CHECK_OK(open_look(slab, PITH_LOOK_TERTIARY, false, &l));
    const pith_vec3 middle = { 0.1, 0.05, 0.4 };
    pith_vec3 v;
    l.view.directions.sample(l.view.directions.user, &middle, 1, &v);
    CHECK_AT_LEAST(fabs(v.y), cos(0.02));
    close_look(&l);
}

static void test_depths_and_colours(void **state)
{
    (void)state;
    looked l;
    CHECK_OK(open_look(bare, PITH_LOOK_ANY, false, &l));
    /* Inside, on the skin, above and below it. */
    const pith_vec3 points[] = { { 0.3, 0.2, 0.6 }, { -0.7, -0.4, 0.1 }, { 0, 0, 0.8 }, { 0, 0, 2 }, { 0, 0, -2 } };
    const double expected[] = { 0.25, 0.875, 0, 0, 1 };
    double depths[5];
    CHECK_OK(pith_look_depths(l.look, points, 5, depths, &err));
    for (int i = 0; i < 5; ++i) CHECK_NEAR(depths[i], expected[i], 1e-6);
    close_look(&l);
    CHECK_OK(open_look(only_flow, PITH_LOOK_ANY, false, &l));
    CHECK_OK(pith_look_depths(l.look, points, 5, depths, &err));
    for (int i = 0; i < 5; ++i) CHECK_NEAR(depths[i], 0, 0);
    assert_null(l.view.depth);
    assert_int_equal(l.view.singular, PITH_NONE);
    close_look(&l);

    static const struct { double depth; float colour[3]; } stops[] = {
        { 0, { 1, 0, 0 } }, { 0.25, { 1, 1, 0 } }, { 0.5, { 0, 1, 0 } }, { 0.75, { 0, 1, 1 } }, { 1, { 0, 0, 1 } },
        { -1, { 1, 0, 0 } }, { 7, { 0, 0, 1 } }, { 0.125, { 1, 0.21404114f, 0 } }, /* half as sRGB: IEC 61966-2-1 */
    };
    for (size_t i = 0; i < sizeof stops / sizeof *stops; ++i) {
        float colour[3];
        pith_look_colour(stops[i].depth, colour);
        for (int c = 0; c < 3; ++c) CHECK_NEAR(colour[c], stops[i].colour[c], 1e-6);
    }
}

/* What of the body is behind the plane: skin all around, a section on top. */
static pith_shell *half_shell(const looked *l, pith_plane plane)
{
    pith_shell *shell = NULL;
    double *values = pith_alloc(pith_part_look(l->view.part).vertex_count, sizeof *values);
    CHECK_OK(pith_part_plane_values(l->view.part, &plane, values, &err));
    CHECK_OK(pith_part_cut(l->view.part, values, &shell, NULL, &err));
    pith_free(values);
    return shell;
}

/* ---- surfaces ---------------------------------------------------------------------------------------------------- */

static double area_of(const pith_mesh *mesh)
{
    pith_mesh_report report;
    CHECK_OK(pith_mesh_measure(mesh, &report, &err));
    return report.area;
}

static void test_layers(void **state)
{
    (void)state;
    looked l;
    pith_mesh *mesh = NULL;
    CHECK_OK(open_look(bare, PITH_LOOK_ANY, true, &l));
    CHECK_OK(pith_look_layer(l.look, NULL, 0.25, &mesh, &err));
    pith_mesh_view view = pith_mesh_look(mesh);
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        CHECK_NEAR(view.positions[v].z, 0.6, 1e-6);
        CHECK_NEAR(view.normals[v].z, 1, 1e-6); /* outwards is where depth falls */
        for (int c = 0; c < 4; ++c) CHECK_NEAR(view.colours[v][c], c != 2, 1e-4); /* yellow */
    }
    CHECK_NEAR(area_of(mesh), 0.996 * 4 * 0.7, 0.05); /* a superellipse of power 20 */
    pith_mesh_destroy(mesh);

    /* Of half the body half the layer, and what of the split's face is deeper; of a part above it nothing. */
    const pith_part_view whole = pith_part_look(l.view.part);
    double *values = pith_alloc(whole.vertex_count, sizeof *values);
    const pith_plane planes[] = { { { 0, 0, 0.4 }, { 1, 0, 0 } }, { { 0, 0, 0.65 }, { 0, 0, -1 } } };
    for (int i = 0; i < 2; ++i) {
        pith_part *half = NULL;
        CHECK_OK(pith_part_plane_values(l.view.part, &planes[i], values, &err));
        CHECK_OK(pith_part_split(l.view.part, values, &half, NULL, &err));
        CHECK_OK(pith_look_layer(l.look, half, 0.25, &mesh, &err));
        CHECK_NEAR(area_of(mesh), i == 0 ? 0.996 * 2 * 0.7 + 1.4 * 0.6 : 0, 0.03);
        assert_int_equal(pith_mesh_look(mesh).triangle_count > 0, i == 0);
        pith_mesh_destroy(mesh);
        pith_part_destroy(half);
    }
    pith_free(values);
    close_look(&l);

    /* In the ball layers are spheres about the middle, and depth is what the layer's is all over it. */
    CHECK_OK(open_look(ball, PITH_LOOK_ANY, false, &l));
    CHECK_OK(pith_look_layer(l.look, NULL, 0.5, &mesh, &err));
    view = pith_mesh_look(mesh);
    double *depths = pith_alloc(view.vertex_count, sizeof *depths);
    CHECK_OK(pith_look_depths(l.look, view.positions, view.vertex_count, depths, &err));
    const double radius = sqrt(area_of(mesh) / (4 * M_PI));
    for (uint32_t v = 0; v < view.vertex_count; ++v) {
        CHECK_NEAR(depths[v], 0.5, 1e-9);
        CHECK_NEAR(pith_length(view.positions[v]), radius, 0.03);
        CHECK_AT_LEAST(pith_dot(view.normals[v], view.positions[v]), 0.98 * pith_length(view.positions[v]));
    }
    pith_free(depths);
    pith_mesh_destroy(mesh);
    close_look(&l);
}

static void test_shells(void **state)
{
    (void)state;
    looked l;
    CHECK_OK(open_look(bare, PITH_LOOK_ANY, false, &l));
    pith_shell *shell = half_shell(&l, (pith_plane){ { 0, 0, 0.4 }, { 0, 0, 1 } });
    double skin, section;
    pith_shell_measure(shell, &skin, &section, NULL);
    const double expected[] = { skin, section, skin + section };
    for (uint32_t kinds = 1; kinds <= 3; ++kinds) {
        pith_mesh *mesh = NULL;
        CHECK_OK(pith_look_shell(l.look, shell, kinds, &mesh, &err));
        CHECK_NEAR(area_of(mesh), expected[kinds - 1], 1e-9);
        const pith_mesh_view view = pith_mesh_look(mesh);
        for (uint32_t v = 0; v < view.vertex_count; ++v) {
            float colour[3];
            pith_look_colour(1 - view.positions[v].z / 0.8, colour);
            for (int c = 0; c < 3; ++c) CHECK_NEAR(view.colours[v][c], colour[c], 1e-4);
            CHECK_NEAR(pith_length(view.normals[v]), 1, 1e-12);
            if (kinds == PITH_LOOK_AT(PITH_SECTION)) CHECK_NEAR(view.normals[v].z, 1, 1e-9);
        }
        pith_mesh_destroy(mesh);
    }
    pith_shell_destroy(shell);
    close_look(&l);
    CHECK_OK(open_look(only_flow, PITH_LOOK_ANY, false, &l)); /* without depth: grey */
    shell = half_shell(&l, (pith_plane){ { 0, 0, 0.4 }, { 0, 0, 1 } });
    pith_mesh *mesh = NULL;
    CHECK_OK(pith_look_shell(l.look, shell, PITH_LOOK_AT(PITH_SKIN), &mesh, &err));
    for (int c = 0; c < 4; ++c) CHECK_NEAR(pith_mesh_look(mesh).colours[0][c], c < 3 ? 0.5 : 1, 0);
    pith_mesh_destroy(mesh);
    pith_shell_destroy(shell);
    close_look(&l);
}

/* ---- lines ------------------------------------------------------------------------------------------------------- */

static void test_lines_in_the_body_and_on_layers(void **state)
{
    (void)state;
    static const struct { const char *text; pith_look_of of; int along; } cases[] = {
        { slab, PITH_LOOK_PRIMARY, 2 }, { slab, PITH_LOOK_SECONDARY, 0 }, { slab, PITH_LOOK_TERTIARY, 1 },
        { flow, PITH_LOOK_VECTORS, 1 },
    };
    const pith_streamline_options options = pith_streamline_options_default();
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        for (int on_layer = 0; on_layer < (cases[i].along == 2 ? 1 : 2); ++on_layer) {
            looked l;
            CHECK_OK(open_look(cases[i].text, cases[i].of, false, &l));
            pith_look_place place = { .kind = on_layer ? PITH_LOOK_LAYER : PITH_LOOK_BODY, .level = 0.75 };
            pith_mesh *mesh = NULL;
            pith_polylines *lines = NULL;
            if (on_layer) CHECK_OK(pith_look_layer(l.look, NULL, 0.75, &mesh, &err));
            place.layer = mesh;
            CHECK_OK(pith_look_lines(l.look, &place, &options, NULL, &lines, &err));
            const pith_polylines_view view = pith_polylines_look(lines);
            for (uint32_t line = 0; line < view.line_count; ++line)
                for (uint32_t p = view.start[line]; p < view.start[line + 1]; ++p) {
                    const pith_vec3 from = view.points[view.start[line]], at = view.points[p];
                    for (int k = 0; k < 3; ++k)
                        if (k != cases[i].along) CHECK_NEAR((&at.x)[k], (&from.x)[k], 0.03);
                    if (on_layer) CHECK_NEAR(at.z, 0.2, 1e-6);
                }
            CHECK_AT_LEAST(view.line_count, 10);
            pith_polylines_destroy(lines);
            pith_mesh_destroy(mesh);
            close_look(&l);
        }
}

/* Where depth bends, points still lie near their layer, on as few as 600 tets. */
static void test_lines_stay_on_bent_layers(void **state)
{
    (void)state;
    looked l;
    CHECK_OK(open_look(SAMPLE_DOCUMENT, PITH_LOOK_ANY, true, &l));
    pith_look_place place = { .kind = PITH_LOOK_LAYER, .level = 0.3 };
    pith_mesh *mesh = NULL;
    pith_polylines *lines = NULL;
    CHECK_OK(pith_look_layer(l.look, NULL, 0.3, &mesh, &err));
    place.layer = mesh;
    const pith_streamline_options options = pith_streamline_options_default();
    CHECK_OK(pith_look_lines(l.look, &place, &options, NULL, &lines, &err));
    const pith_polylines_view view = pith_polylines_look(lines);
    const size_t count = view.start[view.line_count];
    double *depths = pith_alloc(count, sizeof *depths), worst = 0;
    CHECK_OK(pith_look_depths(l.look, view.points, count, depths, &err));
    for (size_t i = 0; i < count; ++i) worst = fmax(worst, fabs(depths[i] - 0.3));
    CHECK_AT_MOST(worst, 0.02);
    CHECK_AT_LEAST(view.line_count, 20);
    pith_free(depths);
    pith_polylines_destroy(lines);
    pith_mesh_destroy(mesh);
    close_look(&l);
}

static void test_arrows(void **state)
{
    (void)state;
    looked l;
    CHECK_OK(open_look(slab, PITH_LOOK_SECONDARY, false, &l));
    pith_streamline_options options = pith_streamline_options_default();
    const double pitch = PITH_LOOK_ARROWS_APART * options.spacing * diagonal;
    for (int on_layer = 0; on_layer < 2; ++on_layer) {
        pith_look_place place = { .kind = on_layer ? PITH_LOOK_LAYER : PITH_LOOK_BODY, .level = 0.75 };
        pith_mesh *mesh = NULL;
        if (on_layer) CHECK_OK(pith_look_layer(l.look, NULL, 0.75, &mesh, &err));
        place.layer = mesh;
        pith_vec3 *points, *vectors;
        size_t count;
        CHECK_OK(pith_look_arrows(l.look, &place, &options, &points, &vectors, &count, &err));
        double least = INFINITY;
        for (size_t i = 0; i < count; ++i) {
            CHECK_NEAR(pith_length(vectors[i]), 1, 1e-12);
            CHECK_AT_LEAST(fabs(vectors[i].x), cos(0.02));
            if (on_layer) CHECK_NEAR(points[i].z, 0.2, 1e-6);
            for (size_t k = 0; k < i; ++k) least = fmin(least, pith_distance(points[i], points[k]));
        }
        CHECK_NEAR(least, on_layer ? 0.8 * pitch : pitch, on_layer ? 0.02 * pitch : 1e-9);
        /* As many as fit. On the grid, a count along every axis; on the layer, places at random of which none is nearer
           than d to another: discs of radius d / 2 about them jam at a coverage of 0.547 (random sequential adsorption,
           Feder 1980), and reach d / 2 over the rim; as many places as were tried come near that. */
        const double d = 0.8 * pitch;
        const double grid = (1 + floor(2 / pitch)) * (1 + floor(1.4 / pitch)) * (1 + floor(0.8 / pitch));
        const double jammed = 0.547 * 0.996 * (2 + d) * (1.4 + d) / (M_PI * d * d / 4);
        CHECK_NEAR((double)count, on_layer ? jammed : grid, (on_layer ? 0.15 : 0.05) * (on_layer ? jammed : grid));
        pith_free(points);
        pith_free(vectors);
        pith_mesh_destroy(mesh);
    }
    close_look(&l);
}

/* ---- on what is seen --------------------------------------------------------------------------------------------- */

static pith_polylines *lines_on(const looked *l, const pith_shell *shell, uint32_t kinds)
{
    const pith_streamline_options options = pith_streamline_options_default();
    const pith_look_place place = { .kind = PITH_LOOK_SHELL, .shell = shell, .kinds = kinds };
    pith_polylines *lines = NULL;
    const double start = pith_seconds();
    CHECK_OK(pith_look_lines(l->look, &place, &options, NULL, &lines, &err));
    const pith_polylines_view view = pith_polylines_look(lines);
    print_message("%u triangles: %u lines, %u points, %.3f s\n", pith_shell_look(shell).triangle_count, view.line_count,
                  view.line_count ? view.start[view.line_count] : 0, pith_seconds() - start);
    return lines;
}

/* Directions of lines on the plane against the field as the whole body has it, made tangent: the greatest angle over
   pieces that are longer than a fifth of the spacing, degrees, and how many of these there are. */
static double off_the_field(const looked *l, const pith_polylines_view *lines, const pith_plane *plane, int *pieces)
{
    const double spacing = 0.03 * pith_distance(l->view.box.low, l->view.box.high);
    const pith_vec3 normal = pith_unit(plane->normal);
    double worst = 0;
    *pieces = 0;
    for (uint32_t line = 0; line < lines->line_count; ++line)
        for (uint32_t i = lines->start[line]; i + 1 < lines->start[line + 1]; ++i) {
            const pith_vec3 a = lines->points[i], b = lines->points[i + 1], middle = pith_lerp(a, b, 0.5);
            pith_vec3 there;
            CHECK_NEAR(pith_dot(pith_sub(b, plane->point), normal), 0, 1e-12);
            if (pith_distance(a, b) < 0.2 * spacing) continue;
            l->view.directions.sample(l->view.directions.user, &middle, 1, &there);
            const pith_vec3 expected = pith_reject(there, normal), found = pith_sub(b, a);
            if (pith_length(there) == 0) continue; /* outer voxels have none */
            worst = fmax(worst, atan2(pith_length(pith_cross(found, expected)), pith_dot(found, expected)));
            ++*pieces;
        }
    return worst * 180 / M_PI;
}

static void test_lines_on_sections(void **state)
{
    (void)state;
    static const struct { const char *text; pith_look_of of; pith_plane plane; double bound; } cases[] = {
        { slab, PITH_LOOK_SECONDARY, { { 0.1, 0, 0.4 }, { 0.3, 0.5, 1 } }, 0.05 }, /* straight everywhere */
        { slab, PITH_LOOK_TERTIARY, { { 0.1, 0, 0.4 }, { 0.3, 0.5, 1 } }, 0.05 },
        { slab, PITH_LOOK_PRIMARY, { { 0.1, 0, 0.4 }, { 1, 0.5, 0.2 } }, 0.05 },
        { flow, PITH_LOOK_VECTORS, { { 0.1, 0, 0.4 }, { 1, 0.1, 0.2 } }, 0.05 },
        { SAMPLE_DOCUMENT, PITH_LOOK_SECONDARY, { { 0, 0.02, 0 }, { 0.1, 1, 0.2 } }, 0.5 }, /* bent */
        { SAMPLE_DOCUMENT, PITH_LOOK_PRIMARY, { { 0, 0.02, 0 }, { 0.1, 1, 0.2 } }, 0.5 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        looked l;
        CHECK_OK(open_look(cases[i].text, cases[i].of, false, &l));
        pith_shell *shell = half_shell(&l, cases[i].plane);
        pith_mesh *mesh = NULL;
        CHECK_OK(pith_look_shell(l.look, shell, PITH_LOOK_AT(PITH_SECTION), &mesh, &err));
        pith_polylines *lines = lines_on(&l, shell, PITH_LOOK_AT(PITH_SECTION));
        const pith_polylines_view view = pith_polylines_look(lines);
        const pith_mesh_view section = pith_mesh_look(mesh);
        const double spacing = 0.03 * pith_distance(l.view.box.low, l.view.box.high);
        double length = 0;
        int pieces;
        for (uint32_t line = 0; line < view.line_count; ++line) length += length_of(&view, line);
        for (uint32_t p = 0; p < view.start[view.line_count]; p += 7)
            CHECK_AT_MOST(off_triangles(&section, view.points[p]), 1e-12); /* inside the section's border */
        const double off = off_the_field(&l, &view, &cases[i].plane, &pieces);
        print_message("%.2f degrees off over %d pieces, %.2f spacings apart\n", off, pieces,
                      area_of(mesh) / length / spacing);
        CHECK_AT_MOST(off, cases[i].bound);
        CHECK_AT_LEAST(pieces, 200);
        CHECK_NEAR(area_of(mesh) / length, spacing, 0.3 * spacing); /* evenly, whatever the section's size */
        CHECK_AT_LEAST(least_distance(&view), 0.5 * spacing);
        pith_polylines_destroy(lines);
        pith_mesh_destroy(mesh);
        pith_shell_destroy(shell);
        close_look(&l);
    }
}

/* Along x on the skin of the slab: over top and bottom and along the sides, and nothing on the two ends, where the
   field stands. */
static void test_lines_on_the_skin(void **state)
{
    (void)state;
    looked l;
    pith_shell *shell = NULL;
    pith_mesh *mesh = NULL;
    CHECK_OK(open_look(slab, PITH_LOOK_SECONDARY, false, &l));
    CHECK_OK(pith_part_shell(l.view.part, &shell, &err));
    CHECK_OK(pith_look_shell(l.look, shell, PITH_LOOK_AT(PITH_SKIN), &mesh, &err));
    const pith_mesh_view skin = pith_mesh_look(mesh);
    pith_polylines *lines = lines_on(&l, shell, PITH_LOOK_AT(PITH_SKIN));
    const pith_polylines_view view = pith_polylines_look(lines);
    int top = 0, bottom = 0, sides = 0;
    double length = 0;
    for (uint32_t line = 0; line < view.line_count; ++line) {
        const uint32_t first = view.start[line], end = view.start[line + 1];
        const pith_vec3 middle = view.points[(first + end) / 2];
        top += fabs(middle.z - 0.8) < 1e-9;
        bottom += fabs(middle.z) < 1e-9;
        sides += fabs(fabs(middle.y) - 0.7) < 0.02;
        for (uint32_t p = first; p < end; p += 3) CHECK_AT_MOST(off_triangles(&skin, view.points[p]), 1e-12);
        length += length_of(&view, line);
    }
    print_message("%d lines on top, %d at the bottom, %d on the sides\n", top, bottom, sides);
    assert_true(top >= 15 && bottom >= 15 && sides >= 16);
    const double area = 2 * 2 * 1.4 + 2 * 2 * 0.8; /* without the ends */
    CHECK_NEAR(area / length, 0.03 * diagonal, 0.3 * 0.03 * diagonal);
    pith_polylines_destroy(lines);

    /* Of a shell that is cut, skin and section at once are as many as by themselves. */
    pith_shell_destroy(shell);
    shell = half_shell(&l, (pith_plane){ { 0, 0, 0.4 }, { 0, 0, 1 } });
    double lengths[4] = { 0, 0, 0, 0 };
    for (uint32_t kinds = 0; kinds < 4; ++kinds) {
        lines = lines_on(&l, shell, kinds);
        const pith_polylines_view some = pith_polylines_look(lines);
        for (uint32_t line = 0; line < some.line_count; ++line) lengths[kinds] += length_of(&some, line);
        pith_polylines_destroy(lines);
    }
    CHECK_NEAR(lengths[0], 0, 0); /* no triangles, no lines */
    CHECK_NEAR(lengths[3], lengths[1] + lengths[2], 0.1 * lengths[3]);
    pith_shell_destroy(shell);
    pith_mesh_destroy(mesh);
    close_look(&l);
}

/* A field that stands on the section leaves it empty; arrows are scattered, and lie in it. */
static void test_arrows_on_sections(void **state)
{
    (void)state;
    looked l;
    CHECK_OK(open_look(slab, PITH_LOOK_SECONDARY, false, &l));
    const pith_streamline_options options = pith_streamline_options_default();
    const double pitch = PITH_LOOK_ARROWS_APART * options.spacing * diagonal;
    const pith_plane planes[] = { { { 0.1, 0, 0.4 }, { 1, 0, 0 } }, { { 0.1, 0, 0.4 }, { 1, 0, 1 } } };
    for (int i = 0; i < 2; ++i) {
        pith_shell *shell = half_shell(&l, planes[i]);
        const pith_look_place place = { .kind = PITH_LOOK_SHELL, .shell = shell, .kinds = PITH_LOOK_AT(PITH_SECTION) };
        pith_polylines *lines = lines_on(&l, shell, place.kinds);
        assert_int_equal(pith_polylines_look(lines).line_count > 0, i);
        pith_polylines_destroy(lines);
        pith_vec3 *points = NULL, *vectors = NULL;
        size_t count;
        CHECK_OK(pith_look_arrows(l.look, &place, &options, &points, &vectors, &count, &err));
        assert_true(count > 30);
        for (size_t k = 0; k < count; ++k) {
            const pith_vec3 expected = i == 0 ? pith_v3(0, 0, 0) : pith_v3(sqrt(0.5), 0, -sqrt(0.5));
            CHECK_NEAR(pith_dot(pith_sub(points[k], planes[i].point), planes[i].normal), 0, 1e-12);
            CHECK_NEAR(pith_distance(vectors[k], expected), 0, i == 0 ? 0 : 0.03);
            for (size_t m = 0; m < k; ++m)
                CHECK_AT_LEAST(pith_distance(points[k], points[m]), 0.8 * pitch * (1 - 1e-12));
        }
        pith_free(points);
        pith_free(vectors);
        const pith_look_place nothing = { .kind = PITH_LOOK_SHELL, .shell = shell, .kinds = 0 };
        CHECK_OK(pith_look_arrows(l.look, &nothing, &options, &points, &vectors, &count, &err));
        assert_int_equal(count, 0);
        pith_free(points);
        pith_free(vectors);
        pith_shell_destroy(shell);
    }
    close_look(&l);
}

/* What is seen of another body is refused; failed calls leave nothing behind. */
static void test_refusals_on_shells(void **state)
{
    (void)state;
    looked small, large;
    CHECK_OK(open_look(SAMPLE_DOCUMENT, PITH_LOOK_SECONDARY, false, &small));
    CHECK_OK(open_look(slab, PITH_LOOK_SECONDARY, false, &large));
    const pith_plane plane = { { 0, 0.02, 0.3 }, { 0.1, 1, 0.2 } };
    pith_shell *other = half_shell(&large, plane), *own = half_shell(&small, plane);
    pith_streamline_options options = pith_streamline_options_default();
    pith_look_place place = { .kind = PITH_LOOK_SHELL, .shell = other, .kinds = PITH_LOOK_AT(PITH_SECTION) };
    pith_polylines *lines = NULL;
    pith_vec3 *points = NULL, *vectors = NULL;
    size_t count = 77;
    CHECK_FAILS(pith_look_lines(small.look, &place, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT,
                "give a shell of this body");
    CHECK_FAILS(pith_look_arrows(small.look, &place, &options, &points, &vectors, &count, &err), PITH_BAD_ARGUMENT,
                "give a shell of this body");
    place.shell = own;
    options.spacing = 0.2;
    int failures = 0;
    for (size_t n = 0; failures < 10000; ++n) {
        pith_memory_fail_after(n);
        pith_status status = pith_look_lines(small.look, &place, &options, NULL, &lines, &err);
        const bool traced = status == PITH_OK;
        if (traced) status = pith_look_arrows(small.look, &place, &options, &points, &vectors, &count, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (traced) pith_polylines_destroy(lines);
        else assert_null(lines);
        lines = NULL;
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_true(!points && !vectors && count == 77);
        ++failures;
    }
    assert_true(failures > 30 && failures < 10000 && count < 77);
    pith_free(points);
    pith_free(vectors);
    pith_shell_destroy(other);
    pith_shell_destroy(own);
    close_look(&small);
    close_look(&large);
}

/* ---- refusals ---------------------------------------------------------------------------------------------------- */

static void check_refused(const char *text, pith_look_of of, bool layers, const char *words)
{
    looked l;
    CHECK_FAILS(open_look(text, of, layers, &l), PITH_BAD_ARGUMENT, words);
    assert_null(l.look);
    assert_null(strstr(err.message, "--")); /* flags are the command line's */
    close_look(&l);
}

static void test_refusals(void **state)
{
    (void)state;
    check_refused(none, PITH_LOOK_ANY, false, "has no fields");
    check_refused(none, PITH_LOOK_ANY, true, "has no fields");
    check_refused(bare, PITH_LOOK_SECONDARY, false, "of is secondary, which needs \"direction\"");
    check_refused(bare, PITH_LOOK_TERTIARY, false, "of is tertiary, which needs \"direction\"");
    check_refused(bare, PITH_LOOK_VECTORS, false, "of is vectors, which needs \"vectors\"");
    check_refused(only_flow, PITH_LOOK_PRIMARY, false, "of is primary, which needs \"depth\"");
    check_refused(only_flow, PITH_LOOK_ANY, true, "has no \"depth\"");
    looked l;
    CHECK_FAILS(open_look("{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", \"shape\": { \"fruit\": {} } },"
                          " { \"name\": \"b\", \"shape\": { \"fruit\": {} } } ] }", PITH_LOOK_ANY, false, &l),
                PITH_BAD_ARGUMENT, "2 bodies");
    close_look(&l);

    const pith_streamline_options options = pith_streamline_options_default();
    pith_look_options wrong = pith_look_options_default();
    pith_look_place place = { .kind = PITH_LOOK_LAYER, .level = 0.5 };
    pith_polylines *lines = NULL;
    pith_mesh *mesh = NULL;
    pith_vec3 *points = NULL, *vectors = NULL;
    size_t count = 77;
    CHECK_OK(open_look(bare, PITH_LOOK_ANY, true, &l));
    wrong.angle = NAN;
    pith_look *untouched = NULL;
    CHECK_FAILS(pith_look_create(l.model, &wrong, &untouched, &err), PITH_BAD_ARGUMENT, "angle");
    CHECK_FAILS(pith_look_create(NULL, &wrong, &untouched, &err), PITH_BAD_ARGUMENT, "NULL");
    assert_null(untouched);
    CHECK_FAILS(pith_look_layer(l.look, NULL, 1.0, &mesh, &err), PITH_BAD_ARGUMENT, "no layer of depth 1 inside");
    CHECK_FAILS(pith_look_layer(l.look, NULL, NAN, &mesh, &err), PITH_BAD_ARGUMENT, "no layer of depth nan inside");
    CHECK_OK(pith_look_layer(l.look, NULL, 0.5, &mesh, &err));
    place.layer = mesh;
    CHECK_FAILS(pith_look_lines(l.look, &place, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT,
                "neither \"direction\" nor \"vectors\"");
    pith_mesh_destroy(mesh);
    close_look(&l);

    CHECK_OK(open_look(slab, PITH_LOOK_PRIMARY, false, &l));
    CHECK_OK(pith_look_layer(l.look, NULL, 0.5, &mesh, &err));
    place.layer = mesh;
    CHECK_FAILS(pith_look_lines(l.look, &place, &options, NULL, &lines, &err), PITH_BAD_ARGUMENT, "across the layers");
    CHECK_FAILS(pith_look_arrows(l.look, &place, &options, &points, &vectors, &count, &err), PITH_BAD_ARGUMENT,
                "across the layers");
    pith_streamline_options wide = options;
    wide.spacing = NAN;
    place.kind = PITH_LOOK_BODY;
    CHECK_FAILS(pith_look_arrows(l.look, &place, &wide, &points, &vectors, &count, &err), PITH_BAD_ARGUMENT, "spacing");
    CHECK_FAILS(pith_look_lines(l.look, &place, &wide, NULL, &lines, &err), PITH_BAD_ARGUMENT, "spacing");
    pith_mesh_destroy(mesh);
    close_look(&l);

    CHECK_OK(open_look(only_flow, PITH_LOOK_ANY, false, &l));
    mesh = NULL;
    CHECK_FAILS(pith_look_layer(l.look, NULL, 0.5, &mesh, &err), PITH_BAD_ARGUMENT, "needs a depth field");
    close_look(&l);
    assert_true(!lines && !mesh && !points && !vectors && count == 77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_followed), cmocka_unit_test(test_depths_and_colours),
        cmocka_unit_test(test_layers), cmocka_unit_test(test_shells),
        cmocka_unit_test(test_lines_in_the_body_and_on_layers),
        cmocka_unit_test(test_lines_stay_on_bent_layers), cmocka_unit_test(test_arrows),
        cmocka_unit_test(test_lines_on_sections),
        cmocka_unit_test(test_lines_on_the_skin), cmocka_unit_test(test_arrows_on_sections),
        cmocka_unit_test(test_refusals_on_shells), cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
