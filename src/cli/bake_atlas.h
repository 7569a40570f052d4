/* The atlas half of pith bake: the surfaces that the cuts leave, as one mesh with a picture. */
#ifndef PITH_CLI_BAKE_ATLAS_H
#define PITH_CLI_BAKE_ATLAS_H

#include "cli.h"

/* Bakes what is left of the model, or of one of its bodies (name, may be NULL), into out. Options and cut are the line's;
   told: where a report as JSON goes, may be NULL. */
pith_status bake_atlas(const cli_model *opened, const cli_line *line, const cli_cut *cut, const char *name,
                       const char *out, json_t **told, pith_error *err);

#endif
