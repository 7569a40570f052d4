/* Hashes of files are of what is in them; those that lie still are read once. */
#include "document_samples.h"

static pith_error err;
static const uint64_t seed = 77;

static uint64_t plain_hash(const char *path)
{
    unsigned char *bytes;
    size_t size;
    CHECK_OK(pith_file_read(path, &bytes, &size, &err));
    const uint64_t hash = pith_hash_bytes(bytes, size, seed);
    pith_free(bytes);
    return hash;
}

/* Without memory a file cannot be read: what is answered then was remembered. */
static pith_status hash_without_reading(const char *path, uint64_t *hash)
{
    pith_memory_fail_after(0);
    const pith_status status = hash_file(path, hash, &err);
    pith_memory_fail_after(SIZE_MAX);
    return status;
}

static void test_a_file_that_lies_still_is_read_once(void **state)
{
    (void)state;
    static const char path[] = PITH_SOURCE_DIR "/data/meshes/pear.obj"; /* has been there for longer than the build */
    uint64_t first = seed, second = seed, other = seed + 1;
    CHECK_OK(hash_file(path, &first, &err));
    assert_true(first == plain_hash(path));
    CHECK_OK(hash_without_reading(path, &second));
    assert_true(second == first);
    assert_int_equal(hash_without_reading(path, &other), PITH_NO_MEMORY); /* what comes before it counts too */
    assert_true(other == seed + 1);
}

/* Far more files than are remembered: each still has its own hash. */
static void test_a_file_that_was_just_written_is_read_again(void **state)
{
    (void)state;
    const char *path = in_folder("f");
    for (int i = 0; i < 200; ++i) {
        char text[20];
        snprintf(text, sizeof text, "%04d", i); /* the same size, and as good as the same time */
        CHECK_OK(pith_file_write(path, text, strlen(text), &err));
        uint64_t hash = seed;
        CHECK_OK(hash_file(path, &hash, &err));
        assert_true(hash == plain_hash(path));
    }
    uint64_t hash = seed;
    assert_int_equal(hash_without_reading(path, &hash), PITH_NO_MEMORY);
    remove(path);
    CHECK_FAILS(hash_file(path, &hash, &err), PITH_IO, "f");
    assert_true(hash == seed);
}

static int drop_folder(void **state)
{
    (void)state;
    return rmdir(sample_folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_file_that_lies_still_is_read_once),
        cmocka_unit_test(test_a_file_that_was_just_written_is_read_again),
    };
    return cmocka_run_group_tests(tests, make_folder, drop_folder);
}
