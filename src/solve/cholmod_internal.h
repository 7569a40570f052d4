/* Shared by the files of the solve room that factor with CHOLMOD (least_squares.c, pinned.c). */
#ifndef PITH_CHOLMOD_INTERNAL_H
#define PITH_CHOLMOD_INTERNAL_H

#include "solve_internal.h"

#include <cholmod.h>

/* Settings for supernodal factors of that many unknowns; cholmod_finish ends them. */
void solve_cholmod_start(cholmod_common *common, uint32_t unknowns);
/* What the common block says went wrong, as a status. */
pith_status solve_cholmod_failure(const cholmod_common *common, uint32_t unknowns, pith_error *err);
/* A view of a matrix given by its lower triangle; borrows its arrays. */
cholmod_sparse solve_cholmod_view(const sparse *lower);

#endif
