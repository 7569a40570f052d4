/* Every command that the docs show runs: lines with build/pith inside ```sh fences of README.md and of the pages under
   docs/, each page in a folder of its own, in the order they stand there. `make` itself and benches are left out. */
#include "cli_run.h"

/* pith edit serves until it is interrupted: it is, after some seconds, and must end well. Its page is not built here. */
static int run_editor(const char *line)
{
    const int length = (int)strcspn(line, "#");
    return run("mkdir -p page && touch page/index.html && timeout --foreground --preserve-status -s INT 4 %.*s --no-open --page page",
               length, line);
}

static int run_page(const char *page)
{
    char path[500];
    unsigned char *text;
    size_t size;
    pith_error err;
    snprintf(path, sizeof path, "%s/%s", PITH_SOURCE_DIR, page);
    CHECK_OK(pith_file_read(path, &text, &size, &err));
    int commands = 0;
    bool inside = false;
    char *save = NULL;
    for (char *line = strtok_r((char *)text, "\n", &save); line; line = strtok_r(NULL, "\n", &save)) {
        if (strncmp(line, "```", 3) == 0) inside = !inside && strcmp(line, "```sh") == 0;
        if (!inside || !strstr(line, "build/pith") || strstr(line, "bench") || strstr(line, "demo")) continue;
        const int code = strstr(line, "pith edit ") ? run_editor(line) : run("%s", line);
        if (code != 0) fail_msg("%s: %s\nexit code %d\n%s", page, line, code, run_err);
        ++commands;
    }
    pith_free(text);
    return commands;
}

static void test_the_readme(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("README.md"), 5);
}

/* The list of verbs at the end of the readme is that of the help, in its order. */
static void test_the_readme_lists_the_verbs(void **state)
{
    (void)state;
    unsigned char *text;
    size_t size;
    pith_error err;
    CHECK_OK(pith_file_read(PITH_SOURCE_DIR "/README.md", &text, &size, &err));
    CHECK_RUN(0, "build/pith --help | awk '/^  [a-z]/ { printf \"%%s%%s\", sep, $1; sep = \" \" }'");
    CHECK_AT_LEAST((int)strlen(run_out), 20);
    CHECK_SAYS((char *)text, run_out);
    pith_free(text);
}

static void test_the_tutorial(void **state)
{
    (void)state;
    CHECK_RUN(0, "rm -f my.pith*");
    CHECK_AT_LEAST(run_page("docs/tutorial/1_first_cut.md"), 4);
    CHECK_AT_LEAST(run_page("docs/tutorial/2_orientation.md"), 2);
    CHECK_AT_LEAST(run_page("docs/tutorial/3_computed.md"), 3);
    CHECK_RUN(0, "awk '/^```json/ { inside = 1; next } /^```/ { inside = 0 } inside' %s/docs/tutorial/4_flowing.md > peach.pith",
              PITH_SOURCE_DIR);
    CHECK_AT_LEAST(run_page("docs/tutorial/4_flowing.md"), 3);
}

static void test_the_editor(void **state)
{
    (void)state;
    CHECK_RUN(0, "rm -f my.pith*");
    CHECK_AT_LEAST(run_page("docs/editor.md"), 3);
}

static void test_cuts_and_volumes(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/cuts.md"), 4);
    CHECK_RUN(0, "test -f caps-2.ply -a ! -f caps-3.ply");
    CHECK_AT_LEAST(run_page("docs/volumes.md"), 3);
}

static void test_procedural(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/procedural.md"), 4);
    CHECK_RUN(0, "test -f block.png -a -f spindles.png");
}

static void test_diffusion(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/diffusion.md"), 6);
    CHECK_RUN(0, "test -f plum.png -a -f plum.glb -a -f section.glb");
}

static void test_baking(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/baking.md"), 5);
    CHECK_RUN(0, "test -f kiwi.glb -a -f kiwi.obj -a -f kiwi.mtl -a -f kiwi.png -a -f halves.glb -a -f kiwi.vtu");
}

static void test_editing(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/editing.md"), 7);
    CHECK_RUN(0, "test -f bark.png -a -f log.png -a -f split.png");
}

static void test_fields(void **state)
{
    (void)state;
    CHECK_AT_LEAST(run_page("docs/fields.md"), 7);
    CHECK_RUN(0, "test -f depth.png -a -f layers.png -a -f on_layer.vtp");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_readme),
        cmocka_unit_test(test_the_readme_lists_the_verbs),
        cmocka_unit_test(test_the_tutorial),
        cmocka_unit_test(test_cuts_and_volumes),
        cmocka_unit_test(test_diffusion),
        cmocka_unit_test(test_baking),
        cmocka_unit_test(test_the_editor),
        cmocka_unit_test(test_procedural),
        cmocka_unit_test(test_editing),
        cmocka_unit_test(test_fields),
    };
    return cmocka_run_group_tests(tests, run_set_up, run_tear_down);
}
