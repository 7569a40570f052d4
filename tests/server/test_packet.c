/* Packets: the layout that docs/protocol.md states, read back by hand; damaged ones; counting. */
#include "check.h"

#include "packet.h"

/* A packet taken apart without the code under test: its JSON, and where its arrays begin. */
static json_t *take_apart(const packet *made, const unsigned char **arrays, size_t *size)
{
    size_t all;
    const unsigned char *bytes = packet_bytes(made, &all);
    const size_t length = bytes[0] | (size_t)bytes[1] << 8 | (size_t)bytes[2] << 16 | (size_t)bytes[3] << 24;
    assert_int_equal(length % 4, 0);
    assert_true(4 + length <= all);
    *arrays = bytes + 4 + length;
    *size = all - 4 - length;
    json_t *text = json_loadb((const char *)bytes + 4, length, 0, NULL);
    assert_non_null(text);
    return text;
}

static void check_entry(const json_t *text, const char *name, json_int_t offset, const char *type, json_int_t count)
{
    const json_t *entry = json_object_get(json_object_get(text, "arrays"), name);
    assert_int_equal(json_array_size(entry), 3);
    assert_int_equal(json_integer_value(json_array_get(entry, 0)), offset);
    assert_string_equal(json_string_value(json_array_get(entry, 1)), type);
    assert_int_equal(json_integer_value(json_array_get(entry, 2)), count);
}

static void test_arrays_lie_where_the_text_says(void **state)
{
    (void)state;
    pith_error err;
    packet_maker *maker = packet_begin("mesh");
    json_object_set_new(packet_text(maker), "body", json_string("flesh"));
    static const float numbers[3] = { 1.5f, -2.0f, 0.25f };
    unsigned char *given = pith_alloc(5, 1);
    memcpy(given, "\1\2\3\4\5", 5);
    packet_borrow(maker, "numbers", PACKET_F32, numbers, 3);
    packet_give(maker, "bytes", PACKET_U8, given, 5);
    packet_borrow(maker, "none", PACKET_U16, NULL, 0);
    int16_t *room = packet_room(maker, "room", PACKET_I16, 2);
    assert_non_null(room);
    room[0] = -7;
    room[1] = 300;
    packet *made = NULL;
    CHECK_OK(packet_finish(maker, &made, &err));
    assert_true(packet_is_binary(made));
    assert_string_equal(packet_slot(made), "");
    packet_set_slot(made, "mesh/%s", "flesh");
    assert_string_equal(packet_slot(made), "mesh/flesh");
    packet_set_slot(made, "mesh/%0250d", 1); /* too long to be told from others */
    assert_string_equal(packet_slot(made), "");

    const unsigned char *arrays;
    size_t size;
    json_t *text = take_apart(made, &arrays, &size);
    assert_string_equal(json_string_value(json_object_get(text, "kind")), "mesh");
    assert_string_equal(json_string_value(json_object_get(text, "body")), "flesh");
    check_entry(text, "numbers", 0, "f32", 3);
    check_entry(text, "bytes", 12, "u8", 5);    /* 5 bytes take 8 */
    check_entry(text, "none", 20, "u16", 0);
    check_entry(text, "room", 20, "i16", 2);
    assert_int_equal(size, 24);
    assert_memory_equal(arrays, numbers, sizeof numbers);
    assert_memory_equal(arrays + 12, "\1\2\3\4\5\0\0\0", 8);
    assert_memory_equal(arrays + 20, "\xf9\xff\x2c\x01", 4);
    json_decref(text);
    packet_release(made);
}

static void test_what_was_made_is_read(void **state)
{
    (void)state;
    pith_error err;
    packet_maker *maker = packet_begin("upload");
    packet_borrow(maker, "bytes", PACKET_U8, "abcdefg", 7);
    packet *made = NULL;
    CHECK_OK(packet_finish(maker, &made, &err));
    size_t size, count = 0;
    const unsigned char *bytes = packet_bytes(made, &size);
    packet_view view;
    const void *values = NULL;
    CHECK_OK(packet_read(bytes, size, &view, &err));
    CHECK_OK(packet_view_array(&view, "bytes", PACKET_U8, &values, &count, &err));
    assert_int_equal(count, 7);
    assert_memory_equal(values, "abcdefg", 7);
    CHECK_FAILS(packet_view_array(&view, "bytes", PACKET_F32, &values, &count, &err), PITH_BAD_ARGUMENT, "type u8");
    CHECK_FAILS(packet_view_array(&view, "bites", PACKET_U8, &values, &count, &err), PITH_BAD_ARGUMENT, "missing");
    packet_view_end(&view);

    /* Cut off anywhere, it is refused or, where only padding went, still whole. */
    for (size_t cut = 0; cut < size - 1; ++cut)
        CHECK_FAILS(packet_read(bytes, cut, &view, &err), PITH_BAD_ARGUMENT, "");
    packet_release(made);
}

/* A packet of this text, whose length is stated as it is or otherwise. */
static size_t lay_out(unsigned char *bytes, const char *text, size_t behind, uint32_t stated)
{
    memset(bytes, 0, 400);
    const uint32_t length = (uint32_t)(strlen(text) + 3) / 4 * 4;
    const uint32_t told = stated ? stated : length;
    memcpy(bytes, &told, 4);
    memset(bytes + 4, ' ', length);
    memcpy(bytes + 4, text, strlen(text));
    return 4 + length + behind;
}

static void test_damaged_packets_are_refused(void **state)
{
    (void)state;
    static const struct { const char *text; size_t behind; uint32_t stated; const char *words; } wrong[] = {
        { "{}", 0, 0xfffffffc, "bytes, expected" },
        { "{}", 4, 6, "multiple of 4" },
        { "{", 0, 0, "not a JSON object" },
        { "[1]", 0, 0, "not a JSON object" },
        { "{\"a\":1,\"a\":2}", 0, 0, "not a JSON object" },
        { "{\"a\":\"\xc3\x28\"}", 0, 0, "not a JSON object" },
        { "{\"arrays\":[1]}", 0, 0, "expected an object" },
        { "{\"arrays\":{\"x\":[0,\"f64\",1]}}", 8, 0, "arrays.x" },
        { "{\"arrays\":{\"x\":[0,\"f32\"]}}", 8, 0, "arrays.x" },
        { "{\"arrays\":{\"x\":[0,\"f32\",3]}}", 8, 0, "3 values" },
        { "{\"arrays\":{\"x\":[4,\"f32\",2]}}", 8, 0, "do not lie" },
        { "{\"arrays\":{\"x\":[2,\"u8\",1]}}", 8, 0, "do not lie" },
        { "{\"arrays\":{\"x\":[-4,\"u8\",1]}}", 8, 0, "do not lie" },
        { "{\"arrays\":{\"x\":[12,\"u8\",0]}}", 8, 0, "do not lie" },
        { "{\"arrays\":{\"x\":[0,\"f32\",4611686018427387905]}}", 8, 0, "do not lie" },
    };
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; ++i) {
        unsigned char bytes[400];
        pith_error err;
        packet_view view;
        const size_t size = lay_out(bytes, wrong[i].text, wrong[i].behind, wrong[i].stated);
        CHECK_FAILS(packet_read(bytes, size, &view, &err), PITH_BAD_ARGUMENT, wrong[i].words);
    }
}

static void test_texts_and_counting(void **state)
{
    (void)state;
    pith_error err;
    packet *made = NULL;
    CHECK_OK(packet_of_json(json_pack("{si}", "id", 7), &made, &err));
    size_t size;
    const unsigned char *bytes = packet_bytes(made, &size);
    assert_int_equal(size, 8);
    assert_memory_equal(bytes, "{\"id\":7}", 8);
    assert_false(packet_is_binary(made));
    packet *again = packet_hold(made);
    packet_release(made);
    assert_memory_equal(packet_bytes(again, &size), "{\"id\":7}", 8); /* still there; the sanitizer would tell */
    packet_release(again);
    packet_release(packet_hold(NULL));
}

/* Whatever allocation fails, nothing is leaked and the sentence is there. */
static void test_out_of_memory_is_told_once_at_the_end(void **state)
{
    (void)state;
    int failures = 0;
    for (size_t after = 0; after < 40; ++after) {
        pith_error err = { PITH_OK, "" };
        packet *made = NULL;
        pith_memory_fail_after(after);
        packet_maker *maker = packet_begin("view");
        json_object_set_new(packet_text(maker), "serial", json_integer(1));
        packet_room(maker, "a", PACKET_F32, 10);
        packet_give(maker, "b", PACKET_U8, pith_alloc(3, 1), 3);
        packet_borrow(maker, "c", PACKET_U8, "xyz", 3);
        const pith_status status = packet_finish(maker, &made, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) packet_release(made);
        else {
            ++failures;
            assert_int_equal(status, PITH_NO_MEMORY);
            assert_non_null(strstr(err.message, "memory"));
            assert_null(made);
        }
    }
    assert_true(failures >= 4 && failures < 40);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrays_lie_where_the_text_says),
        cmocka_unit_test(test_what_was_made_is_read),
        cmocka_unit_test(test_damaged_packets_are_refused),
        cmocka_unit_test(test_texts_and_counting),
        cmocka_unit_test(test_out_of_memory_is_told_once_at_the_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
