/* Programs at work: blocks of points through the steps. */
#include <float.h>
#include <string.h>

#include "program.h"

/* Behind the last point the last one is repeated, so that every lane holds something harmless. */
static void ask_vectors(const pith_vec3 *vectors, const float *footprints, size_t count, lanes *out)
{
    if (!vectors) {
        memset(out, 0, sizeof *out);
        return;
    }
    for (size_t i = 0; i < LANES; ++i) {
        const size_t k = i < count ? i : count - 1;
        const bool finite = pith_finite(vectors[k]);
        out->v[0][i] = finite ? (float)vectors[k].x : 0.0f;
        out->v[1][i] = finite ? (float)vectors[k].y : 0.0f;
        out->v[2][i] = finite ? (float)vectors[k].z : 0.0f;
        out->v[3][i] = footprints && footprints[k] > 0.0f ? footprints[k] : 0.0f;
    }
}

static void ask_direction(const program *own, const pith_query *query, size_t count, lanes *out)
{
    const pith_tets_view mesh = pith_tets_look(own->tets);
    memset(out, 0, sizeof *out);
    for (size_t i = 0; i < count; ++i) {
        uint32_t tet = PITH_NONE;
        double found[4];
        const double *weights = found;
        if (query->tets) {
            tet = query->tets[i];
            weights = query->weights[i];
        } else {
            pith_locator_find(own->locator, &query->points[i], 1, 0.0, &tet, &found);
        }
        if (tet >= mesh.tet_count) continue;
        pith_vec3 sum = { 0, 0, 0 };
        for (int k = 0; k < 4; ++k) sum = pith_add(sum, pith_scale(own->direction[mesh.tets[tet][k]], weights[k]));
        const double length = pith_length(sum);
        if (!(length > 0.0)) continue;
        out->v[0][i] = (float)(sum.x / length);
        out->v[1][i] = (float)(sum.y / length);
        out->v[2][i] = (float)(sum.z / length);
    }
}

static void ask(const program *own, const node_class *what, const pith_query *query, size_t count, lanes *out)
{
    if (what == &node_position)
        ask_vectors(query->points, query->footprints, count, out);
    else if (what == &node_normal)
        ask_vectors(query->normals, NULL, count, out);
    else if (what == &node_view)
        ask_vectors(query->views, NULL, count, out);
    else if (what == &node_light)
        ask_vectors(query->lights, NULL, count, out);
    else
        ask_direction(own, query, count, out);
}

static void run_steps(const program *own, const pith_query *query, size_t count, lanes *registers)
{
    const lanes *inputs[MOST_LINKS + 64];
    for (uint32_t s = 0; s < own->step_count; ++s) {
        const step *at = &own->steps[s];
        lanes *out = &registers[at->out];
        for (uint32_t k = 0; k < at->input_count; ++k) inputs[k] = &registers[own->inputs[at->first_input + k]];
        switch (at->kind) {
        case STEP_ASK:
            ask(own, at->class, query, count, out);
            break;
        case STEP_RUN:
            at->class->run(at->state, inputs, at->input_count, (uint32_t)count, out);
            break;
        case STEP_COLOURS:
            at->class->run_colours(at->state, inputs, at->input_count, (uint32_t)count, out);
            break;
        case STEP_GREY:
            for (int c = 0; c < 3; ++c) memcpy(out->v[c], inputs[0]->v[0], sizeof out->v[c]);
            for (int i = 0; i < LANES; ++i) out->v[3][i] = 1.0f;
            break;
        }
    }
}

/* Products may leave the range of numbers; nobody who asks should have to look for that. */
static float finite_number(float x) { return isnan(x) ? 0.0f : fminf(fmaxf(x, -FLT_MAX), FLT_MAX); }

/* A point that is not finite is outside of everything. */
static void give(const program *own, const pith_query *query, size_t count, const lanes *registers, float *out)
{
    const lanes *colour = &registers[own->colour];
    const lanes *opacity = own->opacity != PITH_NONE ? &registers[own->opacity] : NULL;
    const lanes *displacement = own->displacement != PITH_NONE ? &registers[own->displacement] : NULL;
    for (size_t i = 0; i < count; ++i, out += own->base.channels) {
        memset(out, 0, own->base.channels * sizeof *out);
        if (!pith_finite(query->points[i])) continue;
        for (int c = 0; c < 4; ++c) out[c] = colour->v[c][i];
        if (opacity) out[3] *= opacity->v[0][i];
        out[3] = fminf(fmaxf(out[3], 0.0f), 1.0f);
        if (displacement) out[4] = displacement->v[0][i];
        for (uint32_t c = 0; c < own->base.channels; ++c) out[c] = finite_number(out[c]);
    }
}

void program_sample(const pith_solid *solid, const pith_query *query, float *out)
{
    const program *own = (const program *)solid;
    lanes registers[MOST_REGISTERS];
    memset(registers, 0, own->register_count * sizeof *registers); /* lanes behind the last point hold something, too */
    for (size_t first = 0; first < query->count; first += LANES) {
        const size_t left = query->count - first, count = left < LANES ? left : LANES;
        const pith_query block = pith_query_part(query, first, count);
        run_steps(own, &block, count, registers);
        give(own, &block, count, registers, out + first * own->base.channels);
    }
}
