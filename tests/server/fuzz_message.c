/* Fuzz target: whatever a page says, the editor answers and lives. The first byte says how the rest is read: as one
   text, as one packet, or as choices from which requests of known verbs, keys and operations are put together, so
   that the checks behind the first one are reached, too. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "editor.h"

static const char document[] =
    "{\"pith\": 1, \"shape\": {\"fruit\": {\"detail\": 1}, \"tets\": {\"tetrahedra\": 60}}, \"depth\": "
    "{\"constraints\": "
    "[{\"faces\": \"all\", \"depth\": 0}, {\"stroke\": [[0, 0, -0.5], [0, 0, 0.5]], \"depth\": 1}]}, \"solids\": "
    "[{\"name\": "
    "\"flesh\", \"kind\": \"lapped\", \"type\": \"1-A\", \"exemplar\": {\"layered\": {\"size\": [8, 8, 8], \"stops\": "
    "[{\"depth\": 0, \"colour\": \"#804020\"}]}}}]}";

static char folder[] = "/tmp/pith-fuzz-XXXXXX";
static editor *own;
static outbox *out;

static void drain(void)
{
    uint32_t socket;
    packet *content;
    editor_woken(own);
    while (outbox_take(out, &socket, &content)) packet_release(content);
}

static void end(void)
{
    char line[100];
    snprintf(line, sizeof line, "rm -rf %s", folder);
    editor_close(own); /* its threads must not run on while the process ends */
    outbox_destroy(out);
    if (system(line) != 0) _exit(1);
}

/* A new editor now and then: histories and folders would grow without end. */
static void renew(void)
{
    char path[100], line[100];
    static int runs;
    if (own && ++runs % 500 != 0) return;
    if (own) {
        editor_close(own);
        outbox_destroy(out);
    } else if (!mkdtemp(folder)) {
        abort();
    } else {
        atexit(end);
    }
    snprintf(line, sizeof line, "rm -rf %s", folder);
    snprintf(path, sizeof path, "%s/kiwi.pith", folder);
    const editor_options options = { NULL, false, false };
    if (system(line) != 0 || mkdir(folder, 0700) != 0) abort();
    if (pith_file_write(path, document, sizeof document - 1, NULL) != PITH_OK) abort();
    if (outbox_create(NULL, NULL, &out, NULL) != PITH_OK) abort();
    if (editor_open(path, &options, out, NULL, NULL, &own, NULL) != PITH_OK) abort();
}

/* ---- requests from choices --------------------------------------------------------------------------------------- */

typedef struct choices { const uint8_t *bytes; size_t size; } choices;

static unsigned choose(choices *from, unsigned count)
{
    if (from->size == 0) return 0;
    --from->size;
    return *from->bytes++ % count;
}

static json_t *value(choices *from, int depth);

static json_t *operation(choices *from)
{
    static const char *const names[] = { "depth.fill", "depth.face", "depth.erase", "depth.stroke", "depth.points",
                                         "direction.stroke", "direction.clear", "vectors.inside", "scale.point",
                                         "stroke.remove", "paste.add", "paste.move", "cut.plane", "cut.stroke",
                                         "cut.remove", "part.hide", "part.move", "solid.choose", "solid.type", "set",
                                         "remove" };
    static const char *const keys[] = { "body",  "face", "faces", "ray",   "points", "depth",  "crease",
                                        "point", "size", "index", "list",  "plane",  "stroke", "keep",
                                        "name",  "type", "path",  "value", "part",   "offset" };
    json_t *made = json_object();
    json_object_set_new(made, "op", json_string(names[choose(from, sizeof names / sizeof *names)]));
    for (unsigned i = choose(from, 4); i > 0; --i)
        json_object_set_new(made, keys[choose(from, sizeof keys / sizeof *keys)], value(from, 2));
    return made;
}

static json_t *value(choices *from, int depth)
{
    static const char *const texts[] = {
        "",          "all",         "flesh",     "positive", "1-B",  "title",  "solids[0]", "cuts", "render.samples",
        "../x.json", "/etc/passwd", "kiwi.pith", "depth",    "both", "fields", "solid",     "body", "layer",
        "mesh",      "volume",      "new/x.pith", "../x.pith", "new/../../x.pith", "ein Baum \xc3\xbc.pith",
        "kiwi.pith/x.pith", "a\tb.pith", "nah\xc3\xa4/er/x.pith", "solids[0].exemplar"
    };
    switch (choose(from, depth > 0 ? 11 : 5)) {
    case 0: return json_integer((int)choose(from, 20) - 2);
    case 1: return json_real((choose(from, 100) - 20.0) / 25.0);
    case 2: return json_string(texts[choose(from, sizeof texts / sizeof *texts)]);
    case 3: return json_boolean(choose(from, 2));
    case 4: return json_null();
    case 5: return json_pack("[fff]", choose(from, 9) / 4.0 - 1, choose(from, 9) / 4.0 - 1, choose(from, 9) / 4.0 - 1);
    case 6:
        return json_pack("{s[fff] s[fff]}", "point", choose(from, 9) / 9.0, 0.0, 0.0, "normal", choose(from, 3) - 1.0,
                         1.0, 0.0);
    case 7: return json_pack("{s[fff] s[fff]}", "origin", 5.0, 0.1, 0.0, "direction", choose(from, 3) - 2.0, 0.0, 0.0);
    case 8: return json_pack("{ss}", choose(from, 2) ? "file" : "recipe", texts[choose(from, sizeof texts / sizeof *texts)]);
    case 9: {
        json_t *points = json_array();
        for (unsigned i = 2 + choose(from, 8); i > 0; --i)
            json_array_append_new(points, json_pack("[fff]", choose(from, 33) / 8.0 - 2, choose(from, 33) / 8.0 - 2, 0.0));
        return json_pack("{s[fff] so}", "eye", 0.0, 0.0, 9.0, "points", points);
    }
    default: {
        json_t *list = json_array();
        for (unsigned i = choose(from, 4); i > 0; --i) json_array_append_new(list, value(from, depth - 1));
        return list;
    }
    }
}

static void say_chosen(choices *from)
{
    static const char *const keys[] = { "name",   "what",  "job",    "on",      "kind",    "file",     "force", "body",
                                        "solid",  "depth", "where",  "of",      "spacing", "exemplar", "path",  "how",
                                        "camera", "width", "height", "samples", "stream",  "plane" };
    size_t verbs = 0;
    while (editor_verbs[verbs].name) ++verbs;
    json_t *made = json_object(), *operations = json_array();
    json_object_set_new(made, "id", json_integer(1 + choose(from, 3)));
    json_object_set_new(made, "do", json_string(editor_verbs[choose(from, (unsigned)verbs)].name));
    json_object_set_new(made, "revision",
                        json_integer((json_int_t)session_revision(own->opened) - (choose(from, 10) == 0)));
    for (unsigned i = choose(from, 4); i > 0; --i) json_array_append_new(operations, operation(from));
    if (json_array_size(operations)) {
        json_object_set(made, "operations", operations);
        json_object_set_new(made, "name", json_string("x"));
    }
    if (choose(from, 2)) json_object_del(made, "revision");
    for (unsigned i = choose(from, 4); i > 0; --i)
        json_object_set_new(made, keys[choose(from, sizeof keys / sizeof *keys)], value(from, 2));
    char *text = json_dumps(made, 0);
    if (text) editor_message(own, 1, false, (const unsigned char *)text, strlen(text), NULL, NULL);
    free(text);
    json_decref(operations);
    json_decref(made);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    renew();
    if (size == 0) return 0;
    if (data[0] < 2) {
        editor_message(own, 1, data[0] == 1, data + 1, size - 1, NULL, NULL);
    } else {
        choices from = { data + 1, size - 1 };
        while (from.size > 0) say_chosen(&from);
    }
    drain();
    return 0;
}
