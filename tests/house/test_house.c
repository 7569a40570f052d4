/* The house against its own plan: who may include whom, how long files may be, and no words of unfinished work.

   The table below is the plan's, floor by floor: a room sees only the rooms it names and what those see. */
#include "check.h"

#include <dirent.h>
#include <regex.h>

typedef struct room { const char *name; int floor; } room;

static const room rooms[] = {
    { "base", 0 },
    { "shape", 1 }, { "image", 1 }, { "solve", 1 },
    { "field", 2 }, { "cut", 2 },
    { "solid", 3 }, { "exemplar", 3 }, { "sketch", 3 },
    { "procedural", 4 }, { "diffusion", 4 }, { "render", 4 }, { "bake", 4 }, { "body", 4 }, { "heart", 4 }, { "head", 4 },
    { "document", 5 },
    { "server", 6 },
    { "cli", 7 },
};
enum { ROOM_COUNT = sizeof rooms / sizeof *rooms, LONGEST_FILE = 900 };

static int room_of(const char *name, size_t length)
{
    for (int i = 0; i < ROOM_COUNT; ++i)
        if (strlen(rooms[i].name) == length && strncmp(rooms[i].name, name, length) == 0) return i;
    return -1;
}

static bool is_source(const char *name)
{
    static const char *const endings[] = { "c", "h", "cc", "py", NULL };
    for (size_t i = 0; endings[i]; ++i)
        if (pith_path_has_extension(name, endings[i])) return true;
    return false;
}

/* Calls visit(path, text) for every source file under a folder of the tree, in a depth-first walk; returns the number. */
static int walk(const char *folder, void (*visit)(const char *path, char *text))
{
    char at[1000];
    snprintf(at, sizeof at, "%s/%s", PITH_SOURCE_DIR, folder);
    DIR *directory = opendir(at);
    if (!directory) return 0;
    int seen = 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        if (entry->d_name[0] == '.') continue;
        char inner[600];
        snprintf(inner, sizeof inner, "%s/%s", folder, entry->d_name);
        if (!strchr(entry->d_name, '.')) seen += walk(inner, visit);
        if (!is_source(entry->d_name)) continue;
        snprintf(at, sizeof at, "%s/%s", PITH_SOURCE_DIR, inner);
        unsigned char *text;
        size_t size;
        pith_error err;
        CHECK_OK(pith_file_read(at, &text, &size, &err));
        visit(inner, (char *)text);
        pith_free(text);
        ++seen;
    }
    closedir(directory);
    return seen;
}

static int complaints;

/* The room a file belongs to: src/<room>/…, include/pith/<room>.h or <room>_….h. */
static int home_of(const char *path)
{
    const char *name = strncmp(path, "src/", 4) == 0 ? path + 4 : path + strlen("include/pith/");
    return room_of(name, strcspn(name, "/._"));
}

static void check_includes(const char *path, char *text)
{
    const int home = home_of(path);
    if (home < 0) {
        print_error("%s: lies in no room of the plan\n", path);
        ++complaints;
        return;
    }
    static const char opening[] = "#include \"";
    for (char *at = text; (at = strstr(at, opening)); ++at) {
        const char *name = at + strlen(opening);
        const size_t length = strcspn(name, "\"\n");
        const bool public = strncmp(name, "pith/", 5) == 0;
        if (!public && memchr(name, '/', length)) {
            print_error("%s includes %.*s: a room's inner headers are its own\n", path, (int)length, name);
            ++complaints;
        }
        if (!public) continue;
        const int other = room_of(name + 5, strcspn(name + 5, "._\"\n"));
        if (other < 0 || (other != home && rooms[other].floor >= rooms[home].floor)) {
            print_error("%s (floor %d) includes %.*s, which is not on a lower floor\n", path, rooms[home].floor,
                        (int)length, name);
            ++complaints;
        }
    }
}

static void test_rooms_include_only_lower_floors(void **state)
{
    (void)state;
    complaints = 0;
    CHECK_AT_LEAST(walk("src", check_includes), 7);
    CHECK_AT_LEAST(walk("include/pith", check_includes), 11);
    assert_int_equal(complaints, 0);
}

static void check_length(const char *path, char *text)
{
    int lines = 0;
    for (const char *at = text; (at = strchr(at, '\n')); ++at) ++lines;
    if (lines > LONGEST_FILE) {
        print_error("%s has %d lines; the house's measure is 300 to 800, %d the end\n", path, lines, LONGEST_FILE);
        ++complaints;
    }
}

/* A source file opens with a comment that says what it is for. */
static void check_head(const char *path, char *text)
{
    const bool script = pith_path_has_extension(path, "py");
    const char *at = script && strncmp(text, "#!", 2) == 0 ? strchr(text, '\n') + 1 : text;
    if (strncmp(at, "/*", 2) != 0 && strncmp(at, "//", 2) != 0 && at[0] != '#' && strncmp(at, "\"\"\"", 3) != 0) {
        print_error("%s does not open with a comment that says what it is for\n", path);
        ++complaints;
    }
}

static regex_t unfinished;

static void check_words(const char *path, char *text)
{
    int line = 1;
    for (char *save = NULL, *at = strtok_r(text, "\n", &save); at; at = strtok_r(NULL, "\n", &save), ++line)
        if (regexec(&unfinished, at, 0, NULL, 0) == 0) {
            print_error("%s: unfinished work: %s\n", path, at);
            ++complaints;
        }
}

static void visit_all(void (*visit)(const char *path, char *text))
{
    static const char *const folders[] = { "src", "include", "tests", "bench", "examples", "tools", NULL };
    for (size_t i = 0; folders[i]; ++i) walk(folders[i], visit);
}

static void test_files_are_short_and_introduce_themselves(void **state)
{
    (void)state;
    complaints = 0;
    visit_all(check_length);
    visit_all(check_head);
    assert_int_equal(complaints, 0);
}

static void test_nothing_is_left_unfinished(void **state)
{
    (void)state;
    complaints = 0;
    /* Spelt so that this file does not find itself. */
    const char *pattern = "(^|[^A-Za-z])(TO" "DO|FIX" "ME|XX" "X|HA" "CK|st" "ub(bed)?|not imple" "mented|place" "holder|for n" "ow)"
                          "($|[^A-Za-z])";
    assert_int_equal(regcomp(&unfinished, pattern, REG_EXTENDED | REG_NOSUB), 0);
    visit_all(check_words);
    regfree(&unfinished);
    assert_int_equal(complaints, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rooms_include_only_lower_floors),
        cmocka_unit_test(test_files_are_short_and_introduce_themselves),
        cmocka_unit_test(test_nothing_is_left_unfinished),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
