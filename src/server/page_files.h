/* The files of the page, read into memory once: what plain HTTP can ask for, and nothing else. */
#ifndef PITH_SERVER_PAGE_FILES_H
#define PITH_SERVER_PAGE_FILES_H

#include "pith/base.h"

typedef struct page_file {
    char *name;                 /* as an address names it, with a slash in front: "/index.html", "/assets/page.js" */
    const char *type;           /* MIME */
    unsigned char *bytes;
    size_t size;
    unsigned char *zipped;      /* the same as gzip, from NAME.gz beside it; NULL when there is none */
    size_t zipped_size;
} page_file;

typedef struct page_files page_files;
/* Reads the files of a folder and the folders in it that have an extension a page needs; names that begin with a dot
   are passed over. PITH_IO when there is no index.html, or when they are more than 64 MiB or 1000 files. */
pith_status page_files_read(const char *folder, page_files **files, pith_error *err);
void page_files_destroy(page_files *files);
/* The file of exactly this name, "/" being "/index.html"; NULL when there is none. */
const page_file *page_files_find(const page_files *files, const char *name);

#endif
