/* Combined solids: one solid of the body has the colour, others lie over it as detail. Each of them is built by an inner
   model, the same body made of that solid, with which the outer model shares its stages. */
#include "model_internal.h"

#include <string.h>

/* ---- inner models ------------------------------------------------------------------------------------------------------- */

/* The body made of its solid of that number instead. */
static pith_status inner_model(pith_model *model, size_t solid, pith_model **inner, pith_error *err)
{
    if (!model->inner) {
        model->inner = pith_alloc(model->body->solid_count, sizeof *model->inner);
        if (!model->inner) return PITH_OUT_OF_MEMORY(err, "the solids of a body");
    }
    pith_model *made = model->inner[solid];
    if (!made) {
        made = model_new_inner(model, solid, err);
        if (!made) return PITH_NO_MEMORY;
        model->inner[solid] = made;
        PITH_TRY(stage_keys_of(made->body, &made->keys, err));
    }
    model_share_body(made, model);
    *inner = made;
    return PITH_OK;
}

void model_drop_inner(pith_model *model)
{
    for (size_t i = 0; model->inner && i < model->body->solid_count; ++i) pith_model_destroy(model->inner[i]);
    pith_free(model->inner);
    model->inner = NULL;
}

void model_share_inner(pith_model *to, const pith_model *from)
{
    if (to->solid || !from->inner || to->body->solids[to->body->solid].kind != SOLID_COMBINED) return;
    for (size_t i = 0; i < from->body->solid_count; ++i) {
        const pith_model *there = from->inner[i];
        for (size_t k = 0; there && k < to->body->solid_count; ++k) {
            pith_model *here;
            if (strcmp(to->body->solids[k].name, from->body->solids[i].name) != 0) continue;
            if (to->body->solids[k].kind != from->body->solids[i].kind || inner_model(to, k, &here, NULL) != PITH_OK)
                continue; /* it is built again */
            model_share_body(here, there);
        }
    }
}

/* ---- the solid ------------------------------------------------------------------------------------------------------------ */

/* The solids under a combined one, held for as long as it lives. */
typedef struct solids_under { holding **held; size_t count; } solids_under;

static void drop_under(void *what)
{
    solids_under *under = what;
    for (size_t i = 0; under->held && i < under->count; ++i) holding_release(under->held[i]);
    pith_free(under->held);
    pith_free(under);
}

/* The outer model gets what was built of the body for it. */
pith_status model_inner_solid(pith_model *model, size_t solid, pith_model **inner, const pith_solid **made,
                              pith_error *err)
{
    PITH_TRY(inner_model(model, solid, inner, err));
    PITH_TRY(pith_model_solid(*inner, made, err));
    model_share_body(model, *inner);
    return PITH_OK;
}

static pith_status obtain_inner(pith_model *model, size_t solid, solids_under *under, const pith_solid **made,
                                pith_error *err)
{
    pith_model *inner = NULL;
    PITH_TRY(model_inner_solid(model, solid, &inner, made, err));
    under->held[under->count++] = holding_share(inner->held[STAGE_SOLID]);
    return PITH_OK;
}

/* Points of the body, the same for every detail. */
enum { MEAN_SAMPLES = 4000, MEAN_SEED = 1 };

static pith_status gather_details(pith_model *model, const document_solid *from, solids_under *under,
                                  pith_detail *details, pith_error *err)
{
    for (size_t i = 0; i < from->detail_count; ++i) {
        const document_detail *detail = &from->details[i];
        details[i] = (pith_detail){ .name = model->body->solids[detail->solid].name, .options = detail->options,
                                    .weights = detail->weights, .weight_count = detail->weight_count };
        PITH_TRY(obtain_inner(model, detail->solid, under, &details[i].solid, err));
        if (detail->options.way == PITH_DETAIL_COVER) continue;
        PITH_TRY(pith_solid_mean_inside(details[i].solid, model->tets, MEAN_SAMPLES, MEAN_SEED, details[i].mean, err));
    }
    return PITH_OK;
}

static pith_status build(pith_model *model, const document_solid *from, solids_under *under, pith_solid **made,
                         pith_error *err)
{
    const pith_solid *colour = NULL;
    pith_detail *details = pith_alloc(from->detail_count, sizeof *details);
    under->held = pith_alloc(from->detail_count + 1, sizeof(holding *));
    pith_status status = details && under->held ? PITH_OK : PITH_OUT_OF_MEMORY(err, "a combined solid");
    if (status == PITH_OK) status = obtain_inner(model, from->colour, under, &colour, err);
    if (status == PITH_OK) status = gather_details(model, from, under, details, err);
    if (status == PITH_OK) status = pith_solid_combined(colour, details, from->detail_count, made, err);
    pith_free(details);
    return status;
}

pith_status model_build_combined(pith_model *model, const document_solid *from, pith_error *err)
{
    PITH_TRY(pith_model_tets(model, NULL, NULL, err));
    solids_under *under = pith_alloc(1, sizeof *under);
    holding *held = NULL;
    pith_solid *made = NULL;
    if (!under) return PITH_OUT_OF_MEMORY(err, "a combined solid");
    pith_status status = build(model, from, under, &made, err);
    if (status != PITH_OK) {
        drop_under(under);
        return status;
    }
    status = holding_new(under, drop_under, NULL, &held, err);
    if (status == PITH_OK) status = model_hold_over(model, STAGE_SOLID, made, held, err);
    else pith_solid_destroy(made);
    holding_release(held);
    return status;
}
