/** pith/shape_parts.h: files of one mesh or several, each with a name, marks, and values of any name at its vertices.
 *
 *  What shape.h reads of a file is its geometry; here is the rest, for rooms that keep more at a vertex than a colour. */
#ifndef PITH_SHAPE_PARTS_H
#define PITH_SHAPE_PARTS_H

#include "pith/shape.h"

typedef enum pith_part_type { PITH_PART_FLOAT, PITH_PART_DOUBLE, PITH_PART_WHOLE } pith_part_type;

/** Values of one name at every vertex. In a GLB an attribute whose name begins with '_'; in a PLY a property of one
 *  number that is none of those pith_mesh_read looks for. */
typedef struct pith_part_values {
    const char *name;
    uint32_t components;  /* 1..4; of a PLY 1 */
    pith_part_type type;  /* in the file; whole numbers are only read, and doubles are floats in a GLB */
    const double *values; /* [vertex_count][components]; NaN where a primitive of a GLB's mesh lacks the attribute */
} pith_part_values;

typedef struct pith_part {
    const char *name; /* NULL: it has none */
    pith_mesh_view mesh;
    const pith_part_values *values; /* [value_count] */
    size_t value_count;
    const char *const *marks; /* [mark_count] words that are true of it */
    size_t mark_count;
    double scale; /* read: how many times longer its node has made lengths, which `values` know nothing of;
                               1 but in a GLB. Not written */
} pith_part;

typedef struct pith_parts pith_parts;

/** Reads what pith_mesh_read does, part by part: of a GLB every node with triangles is one, in the order of the scene;
 *  any other file is one part. A name is a node's or its mesh's, and a PLY's line "comment pith name NAME". Marks are the
 *  keys with the value true of {"pith": {...}} in a mesh's extras, and a PLY's lines "comment pith MARK". Errors are those
 *  of pith_mesh_read; PITH_BAD_FILE, too, for a mark that is neither true nor false. */
pith_status pith_parts_read(const char *path, pith_parts **parts, pith_error *err);
/** Same from memory; format is the extension without dot; name is used in messages. */
pith_status pith_parts_parse(const char *name, const char *format, const void *bytes, size_t size, pith_parts **parts,
                             pith_error *err);
void pith_parts_destroy(pith_parts *parts);
/** The parts' own arrays [*count], valid until they are destroyed. */
const pith_part *pith_parts_look(const pith_parts *parts, size_t *count);

/** Writes GLB, a node for each part, or PLY for one part alone, by extension, with the attributes of the meshes and the
 *  values. Triangles of a GLB are shown from both sides. The same parts give the same bytes. PITH_BAD_ARGUMENT: another
 *  extension, no part, several for a PLY, whole numbers, a name of a value or a mark that the format cannot hold, a name of a
 *  part with control characters or not in UTF-8. PITH_BAD_MESH: positions that single precision cannot hold. */
pith_status pith_parts_write(const pith_part *parts, size_t count, const char *path, pith_error *err);

#endif
