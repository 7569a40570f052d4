/* libFuzzer target: any bytes as a VTU file give a mesh or a sentence. */
#include "../../src/shape/tets_internal.h"

#include <stdlib.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pith_error err = { PITH_OK, "" };
    pith_tets *tets = NULL;
    const pith_status status = pith_tets_parse_vtu("fuzz", data, size, &tets, &err);
    if ((status == PITH_OK) != (tets != NULL) || (status != PITH_OK && !err.message[0])) abort();
    if (tets) {
        pith_tets_report report;
        pith_tets_measure(tets, &report);
    }
    pith_tets_destroy(tets);
    return 0;
}
