/* What the benches share: one table (bench.c), one file a bench, cases as JSON objects so that text, JSON and CSV come
   from the same numbers. Measures are named with their unit: fill_s, cut_median_ms, sample_all_points_per_s. */
#ifndef PITH_BENCH_H
#define PITH_BENCH_H

#include "cli.h"

typedef struct bench_options {
    int repeats;    /* timed runs after one warm-up */
    bool curve;     /* lapped, cut: from 5 000 to 500 000 tetrahedra */
    int largest;    /* lapped, cut: the curve stops here */
    const char *picture; /* methods: the file for sections side by side; NULL: none */
} bench_options;

/* Appends cases {"name": …, measures…} to the list. */
typedef pith_status bench_run(const bench_options *options, json_t *cases, pith_error *err);
bench_run bench_lapped, bench_fields, bench_render, bench_cut, bench_layers, bench_blend, bench_volume,
    bench_procedural, bench_atlas, bench_lines, bench_diffusion, bench_sketch_surface, bench_methods, bench_sketch;

/* Accuracy of orientations recovered from strokes; part of bench_fields. */
bench_run bench_orientation;
/* Sections of diffusion surfaces as meshes, and those of the shipped objects; parts of bench_diffusion. */
bench_run bench_section, bench_thirteen;
/* The shipped computed solids and a picture of them; part of bench_procedural. */
bench_run bench_scene;
/* Streamlines on sections and skins; the same. */
bench_run bench_look;
/* A closed surface: the profile (radius, height), from axis to axis, turned about z; and a cylinder of radius 1. */
pith_status bench_revolve(const double (*profile)[2], uint32_t count, uint32_t sides, pith_mesh **mesh, pith_error *err);
pith_status bench_cylinder(uint32_t rings, uint32_t sides, pith_mesh **mesh, pith_error *err);

/* A fruit's document with so many tetrahedra and so fine a surface (0: as the file has them), for bench_load. */
typedef struct bench_fineness { int tetrahedra, detail; } bench_fineness;
void bench_set_fineness(json_t *root, const void *user);

/* Times of repeated runs. */
typedef struct bench_times { double seconds[64]; int count; } bench_times;
void bench_add(bench_times *times, double seconds);
double bench_min(const bench_times *times);
double bench_median(const bench_times *times);

/* A document as its file has it, but for what `change` does to its JSON. */
pith_status bench_load(const char *path, void (*change)(json_t *root, const void *user), const void *user,
                       pith_document **document, pith_error *err);

/* Largest resident set since the last reset, bytes (of the whole process where the system cannot reset it). */
void bench_reset_peak(void);
double bench_peak(void);

#endif
