/* Any bytes as the saved tetrahedra or the saved exemplar of a model: an error or a whole one. The first byte chooses. */
#include "document_internal.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size == 0) return 0;
    byte_reader in = { .bytes = data + 1, .size = size - 1 };
    pith_error err;
    if (data[0] & 1) {
        pith_tets *tets = NULL;
        pith_tets_report report;
        if (stage_load_tets(&in, &tets, &report, &err) == PITH_OK) pith_tets_destroy(tets);
    } else {
        pith_grid *exemplar = NULL;
        if (exemplar_unpack(&in, &exemplar, &err) == PITH_OK) pith_grid_destroy(exemplar);
    }
    return 0;
}
