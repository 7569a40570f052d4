/* VTU files: what we write, checked byte by byte; what others write; what nobody should. */
#include "tets_internal.h"
#include "tets_samples.h"

#include <unistd.h>

static char path[] = "/tmp/pith-vtu-XXXXXX";

static int make_path(void **state)
{
    (void)state;
    const int file = mkstemp(path);
    return file < 0 ? -1 : close(file);
}

static int remove_path(void **state)
{
    (void)state;
    return unlink(path);
}

static void check_same(const pith_tets *one, const pith_tets *other)
{
    const pith_tets_view a = pith_tets_look(one), b = pith_tets_look(other);
    assert_int_equal(a.vertex_count, b.vertex_count);
    assert_int_equal(a.tet_count, b.tet_count);
    assert_memory_equal(a.positions, b.positions, a.vertex_count * sizeof *a.positions);
    assert_memory_equal(a.tets, b.tets, a.tet_count * sizeof *a.tets);
    assert_memory_equal(a.neighbours, b.neighbours, a.tet_count * sizeof *a.neighbours);
}

static void test_what_is_written_comes_back(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(3), *back = NULL;
    CHECK_OK(pith_tets_write_vtu(tets, NULL, 0, NULL, 0, path, &err));
    CHECK_OK(pith_tets_read_vtu(path, &back, &err));
    check_same(tets, back);
    pith_tets_destroy(back);
    pith_tets_destroy(tets);
}

/* An independent look at the bytes: the offset declared for an array leads to its length and its first values. */
static const unsigned char *appended_array(const unsigned char *bytes, const char *name, uint64_t *length)
{
    char key[80];
    snprintf(key, sizeof key, "Name=\"%s\"", name);
    const char *text = (const char *)bytes, *declared = strstr(text, key);
    assert_non_null(declared);
    const char *offset = strstr(declared, "offset=\"");
    assert_non_null(offset);
    const char *data = strstr(text, "<AppendedData encoding=\"raw\">");
    assert_non_null(data);
    const unsigned char *at = (const unsigned char *)strchr(data, '_') + 1 + strtoull(offset + 8, NULL, 10);
    memcpy(length, at, 8); /* little endian, as the machines we test on */
    return at + 8;
}

static void test_offsets_lead_to_the_values(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(2), *back = NULL;
    const pith_tets_view view = pith_tets_look(tets);
    double *depth = pith_alloc(view.vertex_count, sizeof *depth), *axis = pith_alloc(3 * view.tet_count, sizeof *axis);
    for (uint32_t i = 0; i < view.vertex_count; ++i) depth[i] = 0.5 * i;
    for (uint32_t i = 0; i < 3 * view.tet_count; ++i) axis[i] = 1000.0 + i;
    const pith_attribute point_data = { "depth", 1, depth }, cell_data = { "a <b> & \"c\"", 3, axis };
    CHECK_OK(pith_tets_write_vtu(tets, &point_data, 1, &cell_data, 1, path, &err));
    unsigned char *bytes = NULL;
    size_t size = 0;
    CHECK_OK(pith_file_read(path, &bytes, &size, &err));

    uint64_t length;
    const unsigned char *at = appended_array(bytes, "depth", &length);
    assert_int_equal(length, 8 * view.vertex_count);
    assert_memory_equal(at, depth, length);
    at = appended_array(bytes, "a &lt;b&gt; &amp; &quot;c&quot;", &length);
    assert_int_equal(length, 24 * view.tet_count);
    assert_memory_equal(at, axis, length);
    at = appended_array(bytes, "Points", &length);
    assert_int_equal(length, 24 * view.vertex_count);
    assert_memory_equal(at, view.positions, length);
    at = appended_array(bytes, "connectivity", &length);
    assert_int_equal(length, 16 * view.tet_count);
    assert_memory_equal(at, view.tets, length);
    at = appended_array(bytes, "offsets", &length);
    assert_int_equal(length, 4 * view.tet_count);
    for (uint32_t i = 0; i < view.tet_count; ++i) {
        uint32_t end;
        memcpy(&end, at + 4 * i, 4);
        assert_int_equal(end, 4 * (i + 1));
    }
    at = appended_array(bytes, "types", &length);
    assert_int_equal(length, view.tet_count);
    for (uint32_t i = 0; i < view.tet_count; ++i) assert_int_equal(at[i], 10);
    assert_memory_equal(at + length, "\n</AppendedData>", 16);

    CHECK_OK(pith_tets_read_vtu(path, &back, &err));
    check_same(tets, back);
    pith_tets_destroy(back);
    pith_free(bytes);
    pith_free(depth);
    pith_free(axis);
    pith_tets_destroy(tets);
}

/* ---- other writers' files -------------------------------------------------------------------------------------- */

static const char ascii_file[] =
    "<?xml version='1.0'?>\n<!-- a comment with <tags> -->\n"
    "<VTKFile byte_order='LittleEndian' version='0.1' type='UnstructuredGrid'>\n <UnstructuredGrid>\n"
    "  <FieldData><DataArray type='String' Name='note' format='ascii'>65 66 0</DataArray></FieldData>\n"
    "  <Piece NumberOfCells='1' NumberOfPoints=' 4 '>\n"
    "   <Cells>\n    <DataArray format='ascii' Name='types' type='UInt8'> 10 </DataArray>\n"
    "    <DataArray Name='connectivity' type='Int64' format='ascii'>\n0 1\n 2 3 </DataArray>\n"
    "    <DataArray Name='offsets' type='Int64' format='ascii'>4</DataArray>\n   </Cells>\n"
    "   <PointData><DataArray type='Float32' Name='Points' format='ascii'>9 9 9</DataArray></PointData>\n"
    "   <Points><DataArray NumberOfComponents='3' type='Float32' Name='p' format='ascii'>\n"
    "0 0 0  1.5 0 0\n0 2.5e0 0   0 0 -3\n</DataArray></Points>\n  </Piece>\n </UnstructuredGrid>\n</VTKFile>\n";

static void check_little_tet(const pith_tets *tets)
{
    const pith_tets_view view = pith_tets_look(tets);
    assert_int_equal(view.vertex_count, 4);
    assert_int_equal(view.tet_count, 1);
    CHECK_NEAR(pith_tets_volume_of(&view, 0), 1.5 * 2.5 * 3.0 / 6.0, 1e-15); /* turned to be positive */
}

static void test_ascii_with_attributes_in_any_order(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = NULL;
    CHECK_OK(pith_tets_parse_vtu("ascii", ascii_file, sizeof ascii_file - 1, &tets, &err));
    check_little_tet(tets);
    pith_tets_destroy(tets);
}

static void base64(char *text, const void *data, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const unsigned char *b = data;
    for (size_t i = 0; i < size; i += 3) {
        const uint32_t group = (uint32_t)b[i] << 16 | (i + 1 < size ? (uint32_t)b[i + 1] << 8 : 0) |
                               (i + 2 < size ? b[i + 2] : 0);
        for (int k = 0; k < 4; ++k) *text++ = i + (size_t)k > size ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
    *text = 0;
}

/* length and values in base64: together, or one after the other with padding between, as some writers do. */
static void encode(char *text, const void *values, uint32_t size, bool apart)
{
    unsigned char all[200];
    memcpy(all, &size, 4);
    memcpy(all + 4, values, size);
    if (apart) {
        base64(text, all, 4);
        base64(text + strlen(text), all + 4, size);
    } else {
        base64(text, all, size + 4);
    }
}

static void test_inline_and_appended_base64(void **state)
{
    (void)state;
    pith_error err;
    static const double points[12] = { 0, 0, 0, 1.5, 0, 0, 0, 2.5, 0, 0, 0, 3 };
    static const int32_t corners[4] = { 0, 1, 2, 3 }, ends[1] = { 4 };
    static const uint8_t types[1] = { 10 };
    for (int variant = 0; variant < 3; ++variant) {
        char p[300], c[100], e[40], t[40], file[2000];
        encode(p, points, sizeof points, variant == 1);
        encode(c, corners, sizeof corners, variant == 1);
        encode(e, ends, sizeof ends, variant == 1);
        encode(t, types, sizeof types, variant == 1);
        static const char head[] = "<VTKFile type=\"UnstructuredGrid\" header_type=\"UInt32\"><UnstructuredGrid>"
                                   "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>";
        if (variant < 2)
            snprintf(file, sizeof file, "%s<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"binary\">\n %s\n"
                     "</DataArray></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">%s"
                     "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"binary\">%s</DataArray>"
                     "<DataArray type=\"UInt8\" Name=\"types\" format=\"binary\">%s</DataArray></Cells></Piece>"
                     "</UnstructuredGrid></VTKFile>", head, p, c, e, t);
        else
            snprintf(file, sizeof file, "%s<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"appended\" "
                     "offset=\"0\"/></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"appended\" "
                     "offset=\"%zu\"/><DataArray type=\"Int32\" Name=\"offsets\" format=\"appended\" offset=\"%zu\"/>"
                     "<DataArray type=\"UInt8\" Name=\"types\" format=\"appended\" offset=\"%zu\"/></Cells></Piece>"
                     "</UnstructuredGrid><AppendedData encoding=\"base64\">\n_%s%s%s%s</AppendedData></VTKFile>", head,
                     strlen(p), strlen(p) + strlen(c), strlen(p) + strlen(c) + strlen(e), p, c, e, t);
        pith_tets *tets = NULL;
        CHECK_OK(pith_tets_parse_vtu("base64", file, strlen(file), &tets, &err));
        check_little_tet(tets);
        pith_tets_destroy(tets);
    }
}

static void test_big_endian(void **state)
{
    (void)state;
    pith_error err;
    unsigned char file[1000];
    int n = snprintf((char *)file, sizeof file,
                     "<VTKFile type=\"UnstructuredGrid\" byte_order=\"BigEndian\" header_type=\"UInt64\">"
                     "<Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><Points>"
                     "<DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>"
                     "<Cells><DataArray type=\"Int16\" Name=\"connectivity\" format=\"appended\" offset=\"56\"/>"
                     "<DataArray type=\"UInt64\" Name=\"offsets\" format=\"appended\" offset=\"72\"/>"
                     "<DataArray type=\"UInt8\" Name=\"types\" format=\"appended\" offset=\"88\"/></Cells></Piece>"
                     "<AppendedData encoding=\"raw\">_");
    unsigned char *at = file + n;
    static const float points[12] = { 0, 0, 0, 1.5f, 0, 0, 0, 2.5f, 0, 0, 0, 3 };
    const uint64_t lengths[4] = { 48, 8, 8, 1 };
    for (int a = 0; a < 4; ++a) {
        for (int k = 7; k >= 0; --k) *at++ = (unsigned char)(lengths[a] >> 8 * k);
        for (int i = 0; a == 0 && i < 12; ++i) {
            uint32_t bits;
            memcpy(&bits, &points[i], 4);
            for (int k = 3; k >= 0; --k) *at++ = (unsigned char)(bits >> 8 * k);
        }
        for (int i = 0; a == 1 && i < 4; ++i) {
            *at++ = 0;
            *at++ = (unsigned char)i;
        }
        for (int k = 7; a == 2 && k >= 0; --k) *at++ = k ? 0 : 4;
        if (a == 3) *at++ = 10;
    }
    pith_tets *tets = NULL;
    CHECK_OK(pith_tets_parse_vtu("big", file, (size_t)(at - file), &tets, &err));
    check_little_tet(tets);
    pith_tets_destroy(tets);
}

/* ---- malformed files ------------------------------------------------------------------------------------------- */

/* ascii_file with the first occurrence of one text replaced by another. */
static pith_status parse_with(const char *from, const char *to, pith_error *err)
{
    char file[3000];
    const char *found = strstr(ascii_file, from);
    assert_non_null(found);
    snprintf(file, sizeof file, "%.*s%s%s", (int)(found - ascii_file), ascii_file, to, found + strlen(from));
    pith_tets *tets = NULL;
    const pith_status status = pith_tets_parse_vtu("file", file, strlen(file), &tets, err);
    pith_tets_destroy(tets);
    return status;
}

static void test_refusals_name_what_is_wrong(void **state)
{
    (void)state;
    pith_error err;
    CHECK_FAILS(parse_with("'UnstructuredGrid'", "'PolyData'", &err), PITH_BAD_FILE, "no unstructured grid");
    CHECK_FAILS(parse_with("version='0.1'", "compressor='vtkZLibDataCompressor'", &err), PITH_BAD_FILE, "compress");
    CHECK_FAILS(parse_with(" 10 ", " 12 ", &err), PITH_BAD_FILE, "VTK type 12");
    CHECK_FAILS(parse_with(" 2 3 ", " 2 4 ", &err), PITH_BAD_FILE, "points to point 4");
    CHECK_FAILS(parse_with(" 2 3 ", " 2 -1 ", &err), PITH_BAD_FILE, "points to point -1");
    CHECK_FAILS(parse_with(" 2 3 ", " 2 ", &err), PITH_BAD_FILE, "fewer numbers");
    CHECK_FAILS(parse_with(">4<", ">5<", &err), PITH_BAD_FILE, "offset of cell 0");
    CHECK_FAILS(parse_with("' 4 '", "'4000000000'", &err), PITH_BAD_FILE, "more points");
    CHECK_FAILS(parse_with("' 4 '", "'-4'", &err), PITH_BAD_FILE, "NumberOfPoints");
    CHECK_FAILS(parse_with("NumberOfComponents='3'", "NumberOfComponents='2'", &err), PITH_BAD_FILE, "three");
    CHECK_FAILS(parse_with("type='Int64' format='ascii'>\n0", "type='Odd' format='ascii'>\n0", &err), PITH_BAD_FILE,
                "unknown type");
    CHECK_FAILS(parse_with("format='ascii'>\n0 1", "format='appended'>\n0 1", &err), PITH_BAD_FILE, "offset");
    CHECK_FAILS(parse_with("1.5 0 0", "nan 0 0", &err), PITH_BAD_MESH, "not finite");
    CHECK_FAILS(parse_with("1.5 0 0", "0 0 0", &err), PITH_BAD_MESH, "no volume");
    CHECK_FAILS(parse_with("0.1'", "0.1", &err), PITH_BAD_FILE, "byte");
    CHECK_FAILS(parse_with("<VTKFile", "<Other", &err), PITH_BAD_FILE, "no VTU");
    pith_tets *tets = NULL;
    CHECK_FAILS(pith_tets_read_vtu("/nowhere/at.vtu", &tets, &err), PITH_IO, "/nowhere/at.vtu");
    CHECK_FAILS(pith_tets_parse_vtu("file", "", 0, &tets, &err), PITH_BAD_FILE, "no VTU");
    assert_null(tets);
}

/* In a heap block of exactly that size, so that the sanitizer sees every byte read behind it. */
static pith_status parse_exactly(const unsigned char *bytes, size_t size, pith_error *err)
{
    unsigned char *copy = malloc(size ? size : 1);
    assert_non_null(copy);
    memcpy(copy, bytes, size);
    pith_tets *tets = NULL;
    const pith_status status = pith_tets_parse_vtu("cut", copy, size, &tets, err);
    if ((status == PITH_OK) != (tets != NULL)) fail();
    pith_tets_destroy(tets);
    free(copy);
    return status;
}

static void test_truncated_at_every_length_and_spoilt(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(1);
    CHECK_OK(pith_tets_write_vtu(tets, NULL, 0, NULL, 0, path, &err));
    unsigned char *bytes = NULL;
    size_t size = 0;
    CHECK_OK(pith_file_read(path, &bytes, &size, &err));
    const size_t tail = strlen("\n</AppendedData>\n</VTKFile>\n");
    for (size_t n = 0; n + tail < size; ++n) assert_int_equal(parse_exactly(bytes, n, &err), PITH_BAD_FILE);
    for (size_t n = 0; n < sizeof ascii_file - 1; ++n) {
        const pith_status status = parse_exactly((const unsigned char *)ascii_file, n, &err);
        assert_true(status == PITH_BAD_FILE || strstr(ascii_file, "</DataArray></Points>") < ascii_file + n);
    }
    pith_rng rng = pith_rng_make(41, 0);
    int read = 0;
    for (int i = 0; i < 20000; ++i) {
        unsigned char old[4];
        size_t where[4];
        const uint32_t changes = 1 + pith_rng_below(&rng, 4);
        for (uint32_t k = 0; k < changes; ++k) {
            where[k] = pith_rng_below(&rng, (uint32_t)size);
            old[k] = bytes[where[k]];
            bytes[where[k]] = (unsigned char)pith_rng_u32(&rng);
        }
        read += parse_exactly(bytes, size, &err) == PITH_OK;
        for (uint32_t k = changes; k-- > 0;) bytes[where[k]] = old[k];
    }
    print_message("%d of 20000 spoilt files could still be read\n", read);
    pith_free(bytes);
    pith_tets_destroy(tets);
}

static void test_bad_arguments_and_no_memory(void **state)
{
    (void)state;
    pith_error err;
    pith_tets *tets = sample_cube(1), *back = NULL;
    const pith_attribute nameless = { NULL, 1, NULL };
    CHECK_FAILS(pith_tets_write_vtu(tets, &nameless, 1, NULL, 0, path, &err), PITH_BAD_ARGUMENT, "point array 0");
    CHECK_FAILS(pith_tets_write_vtu(NULL, NULL, 0, NULL, 0, path, &err), PITH_BAD_ARGUMENT, "NULL");
    CHECK_FAILS(pith_tets_write_vtu(tets, NULL, 0, NULL, 0, "/nowhere/at.vtu", &err), PITH_IO, "/nowhere");
    size_t n = 0;
    for (;; ++n) {
        pith_memory_fail_after(n);
        const pith_status status = pith_tets_parse_vtu("ascii", ascii_file, sizeof ascii_file - 1, &back, &err);
        pith_memory_fail_after(SIZE_MAX);
        if (status == PITH_OK) break;
        assert_int_equal(status, PITH_NO_MEMORY);
        assert_null(back);
    }
    assert_true(n >= 8);
    pith_tets_destroy(back);
    pith_tets_destroy(tets);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_is_written_comes_back),
        cmocka_unit_test(test_offsets_lead_to_the_values),
        cmocka_unit_test(test_ascii_with_attributes_in_any_order),
        cmocka_unit_test(test_inline_and_appended_base64),
        cmocka_unit_test(test_big_endian),
        cmocka_unit_test(test_refusals_name_what_is_wrong),
        cmocka_unit_test(test_truncated_at_every_length_and_spoilt),
        cmocka_unit_test(test_bad_arguments_and_no_memory),
    };
    return cmocka_run_group_tests_name("tets_vtu", tests, make_path, remove_path);
}
