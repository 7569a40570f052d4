/* Surfaces that colours flow between in documents: what becomes of them, the shape they bound, solids made of them, bodies
   like others, cuts of one body, and what is refused and where. */
#include "opened.h"

#include "pith/diffusion_files.h"

/* A ball of radius 1 and one of radius 0.4 in it, on which colours are constant: between them the colour is known. */
#define BALL(name, r, colours)                                                                                         \
    "{ \"name\": \"" name "\", \"kind\": \"around\", \"across\": 64, \"along\": 48, \"vertical\": [ [0, " r "], ["     \
    "0.38268 , 0.92388], [0.70711, 0.70711], [0.92388, 0.38268], [1, 0], [0.92388, -0.38268], [0.70711, -0.70711], "   \
    "[0.38268, -0.92388], [0, -" r "] ], \"colours\": { " colours " } }"
#define SMALL(name, colours)                                                                                           \
    "{ \"name\": \"" name "\", \"kind\": \"around\", \"across\": 64, \"along\": 48, \"vertical\": [ [0, 0.4], "       \
    "[0.15307, 0.36955], [0.28284, 0.28284], [0.36955, 0.15307], [0.4, 0], [0.36955, -0.15307], [0.28284, -0.28284], "  \
    "[0.15307, -0.36955], [0, -0.4] ], \"colours\": { " colours " } }"
#define BODY(surfaces, more)                                                                                           \
    "{ \"pith\": 1, \"surfaces\": [ " surfaces " ], \"shape\": { \"surfaces\": [\"skin\"], \"tets\": { "               \
    "\"tetrahedra\": 500 } }, \"solids\": [ { \"name\": \"inside\", \"kind\": \"diffusion\" } ]" more " }"
#define SKIN BALL("skin", "1", "\"front\": \"#ffffff\", \"back\": \"#ff0000\"")
#define CORE SMALL("core", "\"front\": \"#0000ff\", \"back\": \"#00ff00\"")

static void sample(pith_model *model, pith_vec3 point, const pith_vec3 *normal, float out[4])
{
    const pith_solid *solid = NULL;
    CHECK_OK(pith_model_solid(model, &solid, &err));
    const pith_query query = { .points = &point, .normals = normal, .count = 1 };
    CHECK_OK(pith_solid_sample(solid, &query, out, &err));
}

/* ---- what is built ------------------------------------------------------------------------------------------------------ */

/* A model of the same document but for its title, which shares what the other has built. */
static opened with_another_title(const opened *m)
{
    static const char operation[] = "{ \"op\": \"set\", \"path\": \"title\", \"value\": \"other\" }";
    opened made = { 0 };
    CHECK_OK(pith_document_apply(m->document, operation, strlen(operation), &made.document, &err));
    CHECK_OK(pith_model_create(made.document, NULL, NULL, &made.model, &err));
    pith_model_share(made.model, m->model);
    return made;
}

static void test_colours_flow_between_drawn_balls(void **state)
{
    (void)state;
    opened m = open_text(BODY(SKIN ", " CORE, ""));
    const pith_diffusion_surface *surfaces;
    size_t count;
    CHECK_OK(pith_model_surfaces(m.model, &surfaces, &count, &err));
    assert_int_equal(count, 2);
    assert_string_equal(surfaces[1].name, "core");
    const pith_mesh_report *report;
    CHECK_OK(pith_model_mesh(m.model, NULL, &report, &err));
    assert_true(report->closed);
    CHECK_NEAR(report->volume, 4.0 / 3.0 * M_PI, 0.02 * 4.2);

    float out[4];
    sample(m.model, pith_v3(0.1, 0, 0), NULL, out); /* in the core only its inside is seen */
    CHECK_NEAR(out[0], 0, 0);
    CHECK_NEAR(out[1], 1, 0);
    CHECK_NEAR(out[3], 1, 0);
    sample(m.model, pith_v3(0, 0.7, 0), NULL, out); /* between, red and blue share */
    CHECK_NEAR(out[0] + out[2], 1, 1e-5);
    CHECK_NEAR(out[1], 0, 0);
    CHECK_AT_LEAST(out[0], 0.1);
    CHECK_AT_LEAST(out[2], 0.1);
    /* On the skin the side that the normal points to. */
    const pith_vec3 on = surfaces[0].mesh.positions[surfaces[0].mesh.triangles[40][0]];
    const pith_vec3 away = pith_unit(on), towards = pith_scale(away, -1.0);
    sample(m.model, on, &away, out);
    CHECK_NEAR(out[2], 1, 1e-6);
    sample(m.model, on, &towards, out);
    CHECK_NEAR(out[2], 0, 1e-6);
    CHECK_NEAR(out[0], 1, 1e-6);
    close_model(&m);
}

static void test_surfaces_stand_where_the_body_does(void **state)
{
    (void)state;
    opened m = open_text(
        "{ \"pith\": 1, \"surfaces\": [ " SKIN " ], \"shape\": { \"surfaces\": [\"skin\"], \"place\": { \"scale\": 2, "
        "\"move_x\": 10 } }, \"solids\": [ { \"name\": \"inside\", \"kind\": \"diffusion\" } ] }");
    const pith_mesh_report *report;
    CHECK_OK(pith_model_mesh(m.model, NULL, &report, &err));
    CHECK_NEAR(report->box.low.x, 8, 0.02);
    CHECK_NEAR(report->box.high.x, 12, 0.02);
    float out[4];
    sample(m.model, pith_v3(11, 0, 0), NULL, out);
    CHECK_NEAR(out[0], 1, 0);
    CHECK_NEAR(out[3], 1, 0);
    close_model(&m);
}

/* Painted at the poles in two colours, a surface takes the mean of both half way. */
static void test_paint_is_spread(void **state)
{
    (void)state;
    opened m = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"surfaces\": [ { \"name\": \"tube\", \"kind\": \"around\", "
                         "\"along\": 33, \"vertical\": [ [0.5, 1], [0.5, 0], [0.5, -1] ], \"colours\": { \"front\": "
                         "\"#808080\" }, \"paint\": [ { \"brush\": { \"points\": [ [0.5, 0, 1] ], \"repeat\": \"around\" }, "
                         "\"front\": \"#ff0000\" }, { \"brush\": { \"points\": [ [0.5, 0, -1] ], \"repeat\": \"around\" }, "
                         "\"front\": \"#0000ff\", \"blur\": 0.01 } ] } ] }");
    const pith_diffusion_surface *surfaces;
    CHECK_OK(pith_model_surfaces(m.model, &surfaces, NULL, &err));
    const pith_mesh_view mesh = surfaces[0].mesh;
    for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
        const double up = 0.5 + 0.5 * mesh.positions[v].z;
        CHECK_NEAR(surfaces[0].front[v][0], up, 1e-3);
        CHECK_NEAR(surfaces[0].front[v][2], 1 - up, 1e-3);
        CHECK_NEAR(surfaces[0].blur[v], 0.01, 1e-9); /* painted once, it is so everywhere */
    }
    assert_null(surfaces[0].back);
    close_model(&m);
}

static void test_erased_parts_are_gone(void **state)
{
    (void)state;
    opened m = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", \"surfaces\": [ { \"name\": \"half\", \"kind\": \"around\", "
                         "\"vertical\": [ [0, 1], [0.8, 0.6], [1, 0], [0.8, -0.6], [0, -1] ], \"colours\": { \"front\": "
                         "\"#ff0000\" }, \"erase\": [ { \"plane\": { \"point\": [0, 0, 0.1], \"normal\": [0, 0, 1] }, "
                         "\"side\": \"positive\" } ] } ] }");
    const pith_diffusion_surface *surfaces;
    CHECK_OK(pith_model_surfaces(m.model, &surfaces, NULL, &err));
    double highest = -1.0;
    for (uint32_t v = 0; v < surfaces[0].mesh.vertex_count; ++v)
        highest = fmax(highest, surfaces[0].mesh.positions[v].z);
    CHECK_NEAR(highest, 0.1, 1e-9);
    close_model(&m);
}

#define FOLDED                                                                                                         \
    "\"sketch\": { \"folds\": 4 }, \"surfaces\": [ { \"name\": \"skin\", \"kind\": \"around\", \"vertical\": [ [0, 1], " \
    "[1, 0], [0, -1] ], \"horizontal\": [ [1, 0], [0.8, 0.8], [0, 1.1], [-0.7, 0.7], [-0.9, 0], [-0.8, -0.6], [0, -1], " \
    "[0.7, -0.8] ] }, { \"name\": \"rooms\", \"kind\": \"chambers\", \"vertical\": [ [0.2, 0], [0.4, 0.2], [0.6, 0], "    \
    "[0.4, -0.2] ] }, { \"name\": \"seeds\", \"kind\": \"grains\", \"on\": \"rooms\", \"radius\": 0.1, \"grain\": { "   \
    "\"profile\": [ [-0.02, 0], [0, 0.03], [0.02, 0], [0, -0.03] ] } } ]"

/* What is varied keeps its connectivity, so that paint stays where it was; the same seed gives the same. */
static void test_variation_keeps_connectivity(void **state)
{
    (void)state;
    opened drawn = open_text("{ \"pith\": 1, " SAMPLE_SHAPE ", " FOLDED " }");
    static const char vary[] = "{ \"op\": \"sketch.vary\", \"seed\": 7 }";
    pith_document *edited = NULL;
    pith_model *varied = NULL;
    CHECK_OK(pith_document_apply(drawn.document, vary, strlen(vary), &edited, &err));
    CHECK_OK(pith_model_create(edited, NULL, NULL, &varied, &err));
    const pith_diffusion_surface *before, *after;
    size_t count;
    CHECK_OK(pith_model_surfaces(drawn.model, &before, &count, &err));
    CHECK_OK(pith_model_surfaces(varied, &after, &count, &err));
    assert_int_equal(count, 3);
    double moved = 0.0;
    for (size_t i = 0; i < 2; ++i) {
        assert_int_equal(before[i].mesh.triangle_count, after[i].mesh.triangle_count);
        assert_memory_equal(before[i].mesh.triangles, after[i].mesh.triangles,
                            before[i].mesh.triangle_count * sizeof *before[i].mesh.triangles);
        for (uint32_t v = 0; v < before[i].mesh.vertex_count; ++v)
            moved = fmax(moved, pith_distance(before[i].mesh.positions[v], after[i].mesh.positions[v]));
    }
    CHECK_AT_LEAST(moved, 0.01);
    assert_true(after[2].mesh.triangle_count > 0);
    pith_model_destroy(varied);
    pith_document_destroy(edited);
    close_model(&drawn);
}

/* Written to a file and read again, surfaces are the same. */
static void test_surfaces_of_files(void **state)
{
    (void)state;
    opened m = open_text(BODY(SKIN ", " CORE, ""));
    const pith_diffusion_surface *surfaces, *again;
    size_t count;
    CHECK_OK(pith_model_surfaces(m.model, &surfaces, &count, &err));
    char path[400], text[1500];
    snprintf(path, sizeof path, "%s/tests/surfaces.glb", PITH_BINARY_DIR);
    CHECK_OK(pith_diffusion_surfaces_write(surfaces, count, path, &err));
    snprintf(text, sizeof text, "{ \"pith\": 1, " SAMPLE_SHAPE ", \"surfaces\": [ { \"name\": \"a\", \"kind\": \"file\", "
             "\"mesh\": \"%s\", \"part\": \"core\" } ] }", path);
    opened read = open_text(text);
    CHECK_OK(pith_model_surfaces(read.model, &again, NULL, &err));
    assert_int_equal(again[0].mesh.vertex_count, surfaces[1].mesh.vertex_count);
    CHECK_NEAR(again[0].back[5][1], 1, 1e-6);
    close_model(&read);
    snprintf(text, sizeof text, "{ \"pith\": 1, " SAMPLE_SHAPE ", \"surfaces\": [ { \"name\": \"a\", \"kind\": \"file\", "
             "\"mesh\": \"%s\" } ] }", path);
    read = open_text(text);
    CHECK_FAILS(pith_model_surfaces(read.model, &again, NULL, &err), PITH_BAD_DOCUMENT, "has 2 surfaces; say which");
    assert_non_null(strstr(err.message, "surfaces[0]"));
    close_model(&read);
    close_model(&m);
}

static void test_a_hollow_is_no_material(void **state)
{
    (void)state;
    opened m = open_text("{ \"pith\": 1, \"surfaces\": [ " SKIN ", " SMALL("hollow", "\"front\": \"#0000ff\", \"hide\": "
                         "\"back\"") " ], \"shape\": { \"surfaces\": [\"skin\", \"hollow\"] }, \"solids\": [ { \"name\": "
                         "\"inside\", \"kind\": \"diffusion\" } ] }");
    const pith_tets_report *report;
    CHECK_OK(pith_model_tets(m.model, NULL, &report, &err));
    CHECK_NEAR(report->volume, 4.0 / 3.0 * M_PI * (1 - 0.064), 0.1);
    /* The wall of the hollow shows its only colour, whichever way it is asked. */
    const pith_diffusion_surface *surfaces;
    CHECK_OK(pith_model_surfaces(m.model, &surfaces, NULL, &err));
    float out[4];
    const pith_vec3 on = surfaces[1].mesh.positions[9], into = pith_scale(pith_unit(on), -1.0);
    sample(m.model, on, &into, out);
    CHECK_NEAR(out[2], 1, 1e-6);
    CHECK_NEAR(out[3], 1, 0);
    close_model(&m);
}

/* ---- combined solids ------------------------------------------------------------------------------------------------------ */

#define COMBINED(details)                                                                                              \
    "{ \"pith\": 1, \"surfaces\": [ " SKIN ", " CORE " ], \"shape\": { \"surfaces\": [\"skin\"] }, \"solids\": [ "     \
    COMBINED_SOLIDS(details) " ] }"
#define COMBINED_SOLIDS(details)                                                                                       \
    "{ \"name\": \"look\", \"kind\": \"combined\", \"colour\": \"inside\", \"details\": [ " details " ] }, "           \
    "{ \"name\": \"inside\", \"kind\": \"diffusion\" }, { \"name\": \"grain\", \"kind\": \"procedural\", \"nodes\": [ "  \
    "{ \"name\": \"x\", \"function\": \"component\", \"what\": \"x\" }, { \"name\": \"g\", \"function\": \"combine\", "  \
    "\"of\": [ \"x\", 2 ] } ], \"colour\": \"g\" }"

static void test_detail_lies_over_the_colour(void **state)
{
    (void)state;
    opened m = open_text(COMBINED("{ \"solid\": \"grain\", \"way\": \"shade\", \"amount\": 1 }"));
    opened plain = open_text(BODY(SKIN ", " CORE, ""));
    float here[4], there[4], without[4];
    const pith_vec3 right = pith_v3(0.7, 0, 0), left = pith_v3(-0.7, 0, 0);
    sample(m.model, right, NULL, here);
    sample(m.model, left, NULL, there);
    sample(plain.model, right, NULL, without);
    /* The grain is 2 + x, its mean 2. */
    CHECK_NEAR(here[0] / without[0], 1.35, 0.03);
    sample(plain.model, left, NULL, without);
    CHECK_NEAR(there[0] / without[0], 0.65, 0.03);
    close_model(&plain);

    /* The same again after an edit of the camera: nothing is built anew. */
    opened next = with_another_title(&m);
    assert_true(pith_model_built(next.model).solid);
    close_model(&m); /* what is shared lives on */
    float again[4];
    sample(next.model, right, NULL, again);
    assert_memory_equal(again, here, sizeof here);
    close_model(&next);
}

/* Before its solid is built and after. */
static void test_a_combined_solid_gives_the_diffusion_of_its_colour(void **state)
{
    (void)state;
    opened m = open_text(COMBINED("{ \"solid\": \"grain\", \"way\": \"shade\", \"amount\": 1 }"));
    opened plain = open_text(BODY(SKIN ", " CORE, ""));
    const pith_vec3 at = pith_v3(0.7, 0.1, -0.2);
    float wanted[4], found[4];
    sample(plain.model, at, NULL, wanted);
    for (int built = 0; built < 2; ++built) {
        const pith_diffusion *diffusion = NULL;
        const pith_diffusion_options *how = NULL;
        CHECK_OK(pith_model_diffusion(m.model, &diffusion, &how, &err));
        CHECK_OK(pith_diffusion_colours(diffusion, how, &at, 1, &found, &err));
        assert_memory_equal(found, wanted, sizeof found);
        CHECK_OK(pith_model_solid(m.model, NULL, &err));
    }
    close_model(&plain);
    close_model(&m);

    m = open_text("{ \"pith\": 1, \"surfaces\": [ " SKIN " ], \"shape\": { \"surfaces\": [\"skin\"] }, \"solids\": [ { \"name\": "
                  "\"look\", \"kind\": \"combined\", \"colour\": \"grain\", \"details\": [] }, { \"name\": \"grain\", \"kind\": "
                  "\"procedural\", \"nodes\": [ { \"name\": \"x\", \"function\": \"component\", \"what\": \"x\" } ], \"colour\": "
                  "\"x\" } ] }");
    const pith_diffusion *none = NULL;
    const pith_diffusion_options *how = NULL;
    CHECK_FAILS(pith_model_diffusion(m.model, &none, &how, &err), PITH_BAD_DOCUMENT,
                "solids[1]: \"grain\" is of another kind than \"diffusion\"");
    assert_null(none);
    close_model(&m);
}

/* Chambers with a corner on the line of their fold: there is no room for others. */
#define TIGHT(solids)                                                                                                  \
    "{ \"pith\": 1, \"sketch\": { \"folds\": 4, \"variation\": { \"seed\": 3 } }, \"surfaces\": [ " SKIN ", { \"name\": " \
    "\"rooms\", \"kind\": \"chambers\", \"vertical\": [ [0.3, 0], [0.5, 0.2], [0.7, 0], [0.5, -0.2] ], "               \
    "\"horizontals\": [ "                                                                                              \
    "[ [0.4, -2e-10], [0.4, -2e-10], [0.7, 0.3], [0.7, 0.3], [0.3, 0.4], [0.3, 0.4] ], "                               \
    "[ [2.04e-10, 0.408], [2.04e-10, 0.408], [-0.306, 0.714], [-0.306, 0.714], [-0.408, 0.306], [-0.408, 0.306] ], "   \
    "[ [-0.432, 2.16e-10], [-0.432, 2.16e-10], [-0.756, -0.324], [-0.756, -0.324], [-0.324, -0.432], [-0.324, -0.432] ], " \
    "[ [-2.36e-10, -0.472], [-2.36e-10, -0.472], [0.354, -0.826], [0.354, -0.826], [0.472, -0.354], [0.472, -0.354] ] "\
    "] } ], \"shape\": { \"surfaces\": [\"skin\"] }, \"solids\": [ " solids " ] }"

static size_t times_in(const char *text, const char *words)
{
    size_t times = 0;
    while ((text = strstr(text, words)) != NULL) ++times, ++text;
    return times;
}

/* A variation that had to stay as it was drawn says so, once, however many models share the surfaces. */
static void test_a_variation_that_cannot_be_is_noted(void **state)
{
    (void)state;
    static const char words[] = "sketch.variation: all is as it was drawn";
    opened m = open_text(TIGHT(COMBINED_SOLIDS("{ \"solid\": \"grain\", \"way\": \"shade\", \"amount\": 1 }")));
    const pith_solid *solid;
    CHECK_OK(pith_model_solid(m.model, &solid, &err)); /* by a model for each of the two solids */
    assert_int_equal(times_in(pith_model_notes(m.model), words), 1);
    opened next = with_another_title(&m);
    CHECK_OK(pith_model_surfaces(next.model, NULL, NULL, &err));
    assert_int_equal(times_in(pith_model_notes(next.model), words), 1);
    close_model(&m);
    close_model(&next);
}

/* ---- several bodies --------------------------------------------------------------------------------------------------------- */

static void test_bodies_like_others_and_cuts_of_one(void **state)
{
    (void)state;
    opened m = open_text(
        "{ \"pith\": 1, \"bodies\": [ { \"name\": \"one\", \"shape\": { \"fruit\": { \"detail\": 2 } } }, { \"name\": "
        "\"two\", \"like\": \"one\", \"shape\": { \"place\": { \"move_x\": 5 } } }, { \"name\": \"three\", \"like\": "
        "\"two\", \"shape\": { \"fruit\": { \"radius_x\": 0.5 } } } ], \"cuts\": [ { \"plane\": { \"point\": [0, 0, 0], "
        "\"normal\": [0, 0, 1] }, \"body\": \"two\", \"gap\": 1 }, { \"plane\": { \"point\": [0, 0, 0], \"normal\": "
        "[0, 0, 1] }, \"body\": \"one\", \"keep\": \"negative\" } ] }");
    pith_model *two, *three;
    const pith_mesh_report *report;
    CHECK_OK(pith_model_body(m.model, 1, &two, &err));
    CHECK_OK(pith_model_mesh(two, NULL, &report, &err));
    CHECK_NEAR(report->box.low.x, 4, 0.05);
    CHECK_OK(pith_model_body(m.model, 2, &three, &err));
    CHECK_OK(pith_model_mesh(three, NULL, &report, &err));
    CHECK_NEAR(report->box.low.x, 4.5, 0.05);

    const pith_model_piece *pieces;
    size_t count, of[3] = { 0, 0, 0 };
    CHECK_OK(pith_model_pieces(m.model, false, &pieces, &count, &err));
    for (size_t i = 0; i < count; ++i) {
        ++of[pieces[i].body];
        CHECK_NEAR(fabs(pieces[i].offset.z), pieces[i].body == 1 ? 0.5 : 0.0, 0);
    }
    assert_int_equal(of[0], 1);
    assert_int_equal(of[1], 2);
    assert_int_equal(of[2], 1);
    /* Saved, it is as it was written. */
    char *text = NULL;
    CHECK_OK(pith_document_json(m.document, &text, &err));
    assert_non_null(strstr(text, "\"like\": \"two\""));
    pith_free(text);
    close_model(&m);
}

/* ---- operations --------------------------------------------------------------------------------------------------------------- */

static pith_document *apply(const pith_document *document, const char *operation)
{
    pith_document *edited = NULL;
    CHECK_OK(pith_document_apply(document, operation, strlen(operation), &edited, &err));
    return edited;
}

static void check_text(const pith_document *document, const char *words, bool there)
{
    char *text = NULL;
    CHECK_OK(pith_document_json(document, &text, &err));
    /* Points stand on lines of their own: blanks do not count. */
    char *to = text;
    for (const char *at = text; *at; ++at)
        if (*at != ' ' && *at != '\n') *to++ = *at;
    *to = 0;
    if (!strstr(text, words) == there) print_error("%s\nhas %s%s\n", text, there ? "not " : "", words);
    assert_true(!strstr(text, words) != there);
    pith_free(text);
}

static void test_operations_on_surfaces(void **state)
{
    (void)state;
    opened m = open_text(BODY(SKIN ", " CORE, ""));
    pith_document *next = apply(m.document, "{ \"op\": \"surface.curve\", \"surface\": \"core\", \"points\": [ [0.02, 0.5], "
                                "[0.3, 0], [0.01, -0.5] ], \"snap\": 0.05 }");
    check_text(next, "\"vertical\":[[0,0.5],[0.3,0],[0,-0.5]]", true);
    pith_document *after = apply(next, "{ \"op\": \"surface.deform\", \"surface\": \"core\", \"drag\": [ [0.3, 0], "
                                 "[0.35, 0.1] ], \"reach\": 1 }");
    check_text(after, "[0.35,0.1]", true);
    pith_document_destroy(next);
    next = apply(after, "{ \"op\": \"surface.paint\", \"surface\": \"core\", \"brush\": { \"points\": [ [0.3, 0, 0] ], "
                 "\"radius\": 0.1 }, \"front\": \"#123456\" }");
    check_text(next, "\"front\":\"#123456\"", true);
    pith_document_destroy(after);
    after = apply(next, "{ \"op\": \"surface.flip\", \"surface\": \"core\" }");
    check_text(after, "\"back\":\"#123456\"", true);
    check_text(after, "\"front\":\"#00ff00\",\"back\":\"#0000ff\"", true);
    pith_document_destroy(next);
    next = apply(after, "{ \"op\": \"surface.erase\", \"surface\": \"core\", \"vertical\": [ [0, 0.2], [1, 0.2] ], "
                 "\"side\": \"negative\" }");
    check_text(next, "\"erase\":[{\"vertical\":[[0,0.2],[1,0.2]],\"side\":\"negative\"}]", true);
    pith_document_destroy(after);
    after = apply(next, "{ \"op\": \"surface.remove\", \"surface\": \"core\" }");
    check_text(after, "core", false);

    static const struct { const char *operation, *words; } wrong[] = {
        { "{ \"op\": \"surface.remove\", \"surface\": \"skin\" }", "bounds the body's shape" },
        { "{ \"op\": \"surface.smooth\", \"surface\": \"cor\" }", "no surface is called \"cor\"; did you mean \"core\"?" },
        { "{ \"op\": \"surface.smooth\", \"surface\": \"core\", \"pane\": \"horizontal\" }", "draw one first" },
        { "{ \"op\": \"surface.paint\", \"surface\": \"core\", \"brush\": { \"points\": [ [0, 0, 0] ] } }", "paints nothing" },
        { "{ \"op\": \"surface.curve\", \"surface\": \"core\", \"points\": [ [0, 1], [1, 0], [1, 1], [0.2, 0] ] }", "cross" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        pith_document *none = NULL;
        const pith_status status = pith_document_apply(next, wrong[i].operation, strlen(wrong[i].operation), &none, &err);
        if (status == PITH_OK || !strstr(err.message, wrong[i].words))
            print_error("%s: \"%s\", expected \"%s\"\n", wrong[i].operation, err.message, wrong[i].words);
        assert_true(status != PITH_OK && strstr(err.message, wrong[i].words));
    }
    pith_document_destroy(after);
    pith_document_destroy(next);
    close_model(&m);
}

/* ---- refusals ------------------------------------------------------------------------------------------------------------------ */

/* Has the model of the edited document the mesh of the one before? */
static bool keeps_mesh(const opened *m, const pith_document *edited)
{
    const pith_model_options options = { .cache = false };
    pith_model *next = NULL;
    CHECK_OK(pith_model_create(edited, &options, NULL, &next, &err));
    pith_model_share(next, m->model);
    const bool kept = pith_model_built(next).mesh;
    pith_model_destroy(next);
    return kept;
}

static void test_the_mesh_depends_on_what_bounds_it(void **state)
{
    (void)state;
    static const struct { const char *operation; bool keeps, keeps_varied; } edits[] = {
        { "{\"op\": \"surface.paint\", \"surface\": \"skin\", \"front\": \"#00ff00\", \"brush\": {\"points\": "
          "[[0, 0, 1]]}}", true, true },
        { "{\"op\": \"surface.flip\", \"surface\": \"skin\"}", true, true },
        { "{\"op\": \"surface.erase\", \"surface\": \"core\", \"plane\": {\"point\": [0, 0, 0], \"normal\": "
          "[0, 0, 1]}}", true, true },
        { "{\"op\": \"surface.curve\", \"surface\": \"core\", \"points\": [[0, 0.3], [0.3, 0], [0, -0.3]]}", true,
          false },
        { "{\"op\": \"surface.curve\", \"surface\": \"skin\", \"points\": [[0, 1], [0.9, 0], [0, -1]]}", false, false },
        { "{\"op\": \"sketch.vary\", \"seed\": 3}", false, false },
    };
    for (size_t varied = 0; varied < 2; ++varied) {
        opened m = open_text(varied ? BODY(SKIN ", " CORE, ", \"sketch\": {\"variation\": {\"seed\": 2}}")
                                    : BODY(SKIN ", " CORE, ""));
        CHECK_OK(pith_model_mesh(m.model, NULL, NULL, &err));
        for (size_t i = 0; i < sizeof edits / sizeof *edits; ++i) {
            pith_document *edited = apply(m.document, edits[i].operation);
            const bool kept = keeps_mesh(&m, edited), expected = varied ? edits[i].keeps_varied : edits[i].keeps;
            if (kept != expected) print_error("varied %zu, %s\n", varied, edits[i].operation);
            assert_int_equal(kept, expected);
            pith_document_destroy(edited);
        }
        close_model(&m);
    }
}

static void test_refusals_name_the_place(void **state)
{
    (void)state;
#define ONE(surface) "{ \"pith\": 1, " SAMPLE_SHAPE ", \"surfaces\": [ " surface " ] }"
    static const struct { const char *text, *words; } wrong[] = {
        { ONE("{ \"name\": \"a\", \"kind\": \"arund\" }"), "surfaces[0].kind: is \"arund\"" },
        { ONE("{ \"name\": \"a\", \"kind\": \"around\", \"vertical\": [ [0, 1] ] }"),
          "surfaces[0].vertical: has 1 points, expected at least 2" },
        { ONE("{ \"name\": \"a\", \"kind\": \"around\", \"vertical\": [ [0, 1], [1, 2, 3] ] }"),
          "surfaces[0].vertical[1]: expected a point of the curve" },
        { ONE("{ \"name\": \"a\", \"kind\": \"around\", \"vertical\": [ [0, 1], [1, 0], [0, -1] ], \"colours\": { "
              "\"front\": \"red\" } }"), "surfaces[0].colours.front: is \"red\"" },
        { ONE("{ \"name\": \"a\", \"kind\": \"around\", \"vertical\": [ [0, 1], [1, 0], [0, -1] ], \"paint\": [ { "
              "\"brush\": { \"points\": [ [0, 0, 0] ] } } ] }"), "surfaces[0].paint[0]: paints nothing" },
        { ONE("{ \"name\": \"a\", \"kind\": \"grains\", \"on\": \"b\", \"grain\": { \"profile\": [ [0, 1], [1, 0], [0, "
              "-1] ] } }"), "surfaces[0].on: no surface before this one is called \"b\"" },
        { ONE("{ \"name\": \"a\", \"kind\": \"around\", \"vertical\": [ [-1, 1], [1, 0], [0, -1] ] }"), "surfaces: " },
        { ONE("{ \"name\": \"a\", \"kind\": \"chambers\", \"vertical\": [ [0.2, 0], [0.4, 0.2], [0.6, 0] ] }"), "surfaces: " },
        { ONE("{ \"name\": \"a\", \"kind\": \"body\" }, { \"name\": \"a\", \"kind\": \"body\" }"),
          "surfaces[1].name: is \"a\", as surfaces[0] already is" },
        { "{ \"pith\": 1, \"shape\": { \"surfaces\": [\"skin\"] } }", "shape.surfaces[0]: no surface is called \"skin\"" },
        { "{ \"pith\": 1, " SAMPLE_SHAPE ", \"solids\": [ { \"name\": \"a\", \"kind\": \"diffusion\" } ] }",
          "solids[0]: colours flow between surfaces, and the body has none" },
        { "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\", \"like\": \"b\" } ] }", "bodies[0].like: no body before this" },
        { "{ \"pith\": 1, \"bodies\": [ { \"name\": \"a\" } ] }", "bodies[0]" },
        { COMBINED("{ \"solid\": \"look\" }"), "solids[0].details[0].solid: is combined itself" },
        { COMBINED("{ \"solid\": \"grein\" }"), "did you mean \"grain\"?" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        pith_document *document = NULL;
        const pith_status status = parse_text(wrong[i].text, &document, &err);
        if (status == PITH_OK || !strstr(err.message, wrong[i].words))
            print_error("%zu: \"%s\", expected \"%s\"\n", i, status == PITH_OK ? "accepted" : err.message, wrong[i].words);
        assert_true(status != PITH_OK && strstr(err.message, wrong[i].words));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_colours_flow_between_drawn_balls),
        cmocka_unit_test(test_surfaces_stand_where_the_body_does),
        cmocka_unit_test(test_paint_is_spread),
        cmocka_unit_test(test_erased_parts_are_gone),
        cmocka_unit_test(test_variation_keeps_connectivity),
        cmocka_unit_test(test_surfaces_of_files),
        cmocka_unit_test(test_a_hollow_is_no_material),
        cmocka_unit_test(test_detail_lies_over_the_colour),
        cmocka_unit_test(test_a_combined_solid_gives_the_diffusion_of_its_colour),
        cmocka_unit_test(test_a_variation_that_cannot_be_is_noted),
        cmocka_unit_test(test_bodies_like_others_and_cuts_of_one),
        cmocka_unit_test(test_operations_on_surfaces),
        cmocka_unit_test(test_the_mesh_depends_on_what_bounds_it),
        cmocka_unit_test(test_refusals_name_the_place),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
