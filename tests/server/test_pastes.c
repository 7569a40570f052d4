/* What pages are sent of pastes: the coordinates on the surface, against those that the paste's place says. */
#include "desk.h"

/* An array of a packet. */
static const void *array_of(const struct heard *heard, const char *name, size_t *count)
{
    size_t size;
    uint32_t length;
    const json_t *entry = json_object_get(json_object_get(heard->text, "arrays"), name);
    assert_int_equal(json_array_size(entry), 3);
    const unsigned char *bytes = packet_bytes(heard->content, &size);
    memcpy(&length, bytes, 4);
    *count = (size_t)json_integer_value(json_array_get(entry, 2));
    return bytes + 4 + length + json_integer_value(json_array_get(entry, 0));
}

static double signed16(uint32_t word, bool high) { return (double)(int16_t)(uint16_t)(high ? word >> 16 : word); }

/* The newest packet of this kind; waits for one. */
static const struct heard *newest(desk *at, const char *kind)
{
    desk_wait(at, 0, "kind", kind, NULL);
    size_t i = at->count;
    while (strcmp(text_of(at->heard[--i].text, "kind"), kind) != 0) continue;
    return &at->heard[i];
}

static void settle(desk *at)
{
    const double start = pith_seconds();
    for (;; desk_nap()) {
        desk_listen(at);
        const viewer_state *known = at->own->state;
        if (known && known->count && known->bodies[0].built.solid && known->bodies[0].shown) return;
        assert_true(pith_seconds() - start < desk_patience);
    }
}

/* The paste's cube: its middle at `point`, s along `up`, t along `along`. */
static const double point[3] = { 0.1, 0.05, -0.1 }, up[3] = { 0, 1, 0 }, along[3] = { 0, 0, 1 }, size_of_cube = 0.9;

static double place_along(const float *p, const double axis[3])
{
    double sum = 0.5;
    for (int k = 0; k < 3; ++k) sum += (p[k] - point[k]) * axis[k] / size_of_cube;
    return sum;
}

/* Checks every layer of the view that is pasted; says how many there are. */
static size_t check_pastes(const struct heard *solid, const struct heard *view)
{
    size_t counts[5];
    const float *patches = array_of(solid, "patches", &counts[0]), *positions = array_of(view, "positions", &counts[1]);
    const uint32_t *corners = array_of(view, "corners", &counts[2]),
                   *starts = array_of(view, "layer_start", &counts[3]);
    const uint32_t *layers = array_of(view, "layers", &counts[4]);
    const double rt = json_number_value(json_object_get(view->text, "rt_unit"));
    const double s = json_number_value(json_object_get(view->text, "s_unit"));
    size_t pasted = 0;
    assert_int_equal(counts[3], counts[2] / 3 + 1);
    for (size_t triangle = 0; triangle + 1 < counts[3]; ++triangle)
        for (uint32_t i = starts[triangle]; i < starts[triangle + 1];) {
            const uint32_t *record = layers + 4 * (size_t)i, *more = record + 4;
            const uint32_t patch = record[3] & 0xffffff;
            const bool has_more = record[3] >> 31;
            assert_true(4 * (size_t)patch + 3 < counts[0]);
            i += has_more ? 2 : 1;
            if (patches[4 * patch + 3] < 1024) continue; /* of the fill */
            ++pasted;
            if (!has_more) {
                print_error("triangle %zu: the paste's layer has no s of its own\n", triangle);
                fail();
            }
            const double seen[3] = { signed16(more[0], false) * s, signed16(more[0], true) * s,
                                     signed16(more[1], false) * s };
            for (int k = 0; k < 3; ++k) {
                const float *p = positions + 3 * (size_t)corners[3 * triangle + (size_t)k];
                CHECK_NEAR(seen[k], place_along(p, up), s + 1e-5);
                CHECK_NEAR(signed16(record[k], true) * rt, place_along(p, along), rt + 1e-5);
            }
        }
    return pasted;
}

static void test_a_paste_has_depth_of_its_own_in_every_type(void **state)
{
    (void)state;
    static const char *const types[] = { "0-A", "1-A", "1-B" };
    for (size_t i = 0; i < sizeof types / sizeof *types; ++i) {
        char text[2000];
        snprintf(
            text, sizeof text,
            "{\"pith\": 1, " SAMPLE_FIELDS ", \"scale\": {\"points\": [{\"point\": [0, 0, 0], \"size\": 0.7}]}, "
            "\"solids\": [{\"name\": \"flesh\", \"kind\": \"lapped\", \"type\": \"%s\", \"exemplar\": {\"layered\": "
            "{\"size\": [8, 8, 8], \"homogeneous\": %s, \"stops\": [{\"depth\": 0, \"colour\": \"#804020\"}]}}, "
            "\"pastes\": [{\"exemplar\": {\"layered\": " SAMPLE_RECIPE "}, \"point\": [%g, %g, %g], "
            "\"up\": [0, 1, 0], \"along\": [0, 0, 1], \"size\": %g}]}], "
            "\"cuts\": [{\"plane\": {\"point\": [0.08, 0, 0], \"normal\": [1, 0, 0]}, \"keep\": \"negative\"}]}",
            types[i], i == 0 ? "true" : "false", point[0], point[1], point[2], size_of_cube);
        write_text("kiwi.pith", text);
        desk *at = desk_open(true, false);
        settle(at);
        const size_t pasted = check_pastes(newest(at, "solid"), newest(at, "view"));
        if (pasted < 20) {
            print_error("type %s: %zu layers of the paste, expected at least 20\n", types[i], pasted);
            fail();
        }
        desk_close(at);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_a_paste_has_depth_of_its_own_in_every_type, fresh_document),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
