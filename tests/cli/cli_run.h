/* Running the built program from a test, in a folder of its own. */
#ifndef PITH_CLI_RUN_H
#define PITH_CLI_RUN_H

#include <sys/wait.h>
#include <unistd.h>

#include "check.h"

static char run_folder[] = "/tmp/pith-cli-XXXXXX";
static char run_out[200000], run_err[20000]; /* what the last command printed */

static inline void run_take(const char *name, char *text, size_t capacity)
{
    char path[300];
    snprintf(path, sizeof path, "%s/%s", run_folder, name);
    FILE *file = fopen(path, "rb");
    const size_t size = file ? fread(text, 1, capacity - 1, file) : 0;
    text[size] = 0;
    if (file) fclose(file);
}

/* Runs a shell command in the folder, where `build` and the source's folders can be reached; returns its exit code, or
   -1 when a signal ended it. */
static inline int run(const char *format, ...)
{
    char command[2000], line[3000];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(command, sizeof command, format, arguments);
    va_end(arguments);
    snprintf(line, sizeof line, "cd %s && { %s\n} >stdout.txt 2>stderr.txt </dev/null", run_folder, command);
    const int status = system(line);
    run_take("stdout.txt", run_out, sizeof run_out);
    run_take("stderr.txt", run_err, sizeof run_err);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

#define CHECK_RUN(expected, ...)                                                                                       \
    do {                                                                                                               \
        const int code_ = run(__VA_ARGS__);                                                                            \
        if (code_ != (expected)) {                                                                                     \
            print_error("%s:%d exit code %d, expected %d\n%s\n%s\n", __FILE__, __LINE__, code_, (expected), run_out,   \
                        run_err);                                                                                      \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

#define CHECK_SAYS(text, words)                                                                                        \
    do {                                                                                                               \
        if (!strstr((text), (words))) {                                                                                \
            print_error("%s:%d expected \"%s\" in\n%s\n", __FILE__, __LINE__, (words), (text));                        \
            fail();                                                                                                    \
        }                                                                                                              \
    } while (0)

static inline int run_set_up(void **state)
{
    (void)state;
    if (!mkdtemp(run_folder)) return -1;
    char line[2000];
    snprintf(line, sizeof line, "cd %s && ln -s %s build && cp -r %s/examples . && cp -r %s/data . && rm -f examples/*.pithc",
             run_folder, PITH_BINARY_DIR, PITH_SOURCE_DIR, PITH_SOURCE_DIR);
    return system(line);
}

static inline int run_tear_down(void **state)
{
    (void)state;
    char line[300];
    snprintf(line, sizeof line, "rm -r %s", run_folder);
    return system(line);
}

#endif
