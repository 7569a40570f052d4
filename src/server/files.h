/* Files that pages may know of and bring in: those in the document's folder and below it, and those shipped with
   pith. */
#ifndef PITH_SERVER_FILES_H
#define PITH_SERVER_FILES_H

#include "session.h"

/* Where a page may reach. */
typedef struct file_places {
    const char *folder;         /* the document's, as realpath gives it, with a slash at the end */
    const char *shipped;        /* the same of what is shipped, without the slash; "" for none */
} file_places;

/* Is this, as a document in the folder would write it, a file within reach once links are followed? */
bool files_reach(const file_places *places, const char *path);
/* Is it a file that there is, but out of reach? */
bool files_beyond(const file_places *places, const char *path);

/* Refuses JSON that has a text in it which names a file out of reach, unless `known` (may be NULL) has the same text.
   PITH_BAD_ARGUMENT names it. Asked before anything opens what a page named. */
pith_status files_check(const file_places *places, const json_t *value, const json_t *known, pith_error *err);

/* Has the name an extension of this kind of files? */
bool files_has_kind(const char *name, const char *kind);

/* {"path", "name", "shipped"} of every file within reach of this kind ("recipe", "mesh", "grid", "image", "document"),
   sorted; at most 2000. A new reference. */
json_t *files_list(const file_places *places, const char *kind);

/* Writes a new file into the document's folder. PITH_BAD_ARGUMENT: a name that is empty or longer than 200 bytes, begins
   with a dot, or has a slash or a control character in it; or an extension that pith does not read. PITH_IO: there is
   one of that name, or it cannot be written. */
pith_status files_put(const file_places *places, const char *name, const void *bytes, size_t size, pith_error *err);

/* Where a document is to be written. */
typedef struct file_place {
    char path[4096];            /* absolute */
    size_t missing;             /* where in it the first folder that there is not yet begins; 0: all are there */
} file_place;
/* The place `file`, relative to the folder and not out of it. PITH_BAD_ARGUMENT when it is no such name, or there is one
   and it may not be replaced. */
pith_status files_place(const file_places *places, const char *file, bool replace, file_place *place, pith_error *err);
/* Makes the folders that are missing: all of them, or none (PITH_IO). */
pith_status files_make_folders(file_place *place, pith_error *err);
/* Takes those away again that were made, whose names end before this byte of the path; those that have something in
   them stay. */
void files_drop_folders(file_place *place, size_t before);

#endif
