/* The commit: from pending changes to sorted events.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. The SAP is brought up to date and touches pairs; settled, they make the lists
 *    of fresh and doomed pairs.
 * 2. The lists are sorted and freed of repeats, if they are not so: these are the events.
 * 3. All memory that is still needed is taken. What fails up to here leaves the
 *    pairs, the events of the last commit and the pending changes as they were, and
 *    the world stale: the axes have moved on without their touches being kept, so
 *    the next commit sweeps everything.
 * 4. The pairs are changed and the changes are no longer pending. Nothing can fail
 *    from here on.
 * 5. The callbacks run; then the slots of removed boxes are free for reuse. */
#include "internal.h"

static void sort_events(struct keys *events, struct scratch *scratch, struct memory *m)
{
    msap_sort_keys(events->at, events->n, events->n > 0 ? msap_scratch_get(scratch, m, events->n) : NULL);
    events->n = msap_unique_keys(events->at, events->n);
}

/* Brings axes or cells up to date. Returns the strategy that did, or 0 if there was no
 * memory to. */
static uint32_t update(msap_world *w, struct job *job)
{
    uint32_t strategy = w->stale ? MSAP_STRATEGY_SWEEP : w->config.strategy;
    if (is_grid(&w->config)) return msap_grid_update(&w->grid, job, strategy);
    if (strategy == MSAP_STRATEGY_AUTO) strategy = msap_sap_choose(&w->sap, job);
    msap_sap_update(&w->sap, job, strategy);
    return strategy;
}

static void forget_events(struct settler *s)
{
    s->fresh.n = s->doomed.n = s->notes.n = 0;
    s->lost = s->has_all_doomed = s->has_no_notes = s->are_events = 0;
    s->touched = s->crossings = 0;
}

static struct job job_of(msap_world *w)
{
    struct job job = {&w->boxes,   &w->pairs, &w->crew.worker[0], &w->memory,
                      &w->scratch, &w->crew,  w->config.filters};
    return job;
}

/* Steps 1 and 2: fills the lists of events. */
static msap_status find_events(msap_world *w)
{
    struct job job = job_of(w);
    struct settler *s = &job.worker->settler;
    s->boxes = &w->boxes;
    s->memory = &w->memory;
    s->has_repeats = !is_grid(&w->config);
    uint32_t strategy = update(w, &job);
    w->stale = strategy == 0;
    w->strategy_used[strategy]++;
    if (strategy == 0) {
        forget_events(s);
        msap_touch_all_boxes(&job);
    }
    if (s->lost) return MSAP_ERROR_MEMORY;
    if (s->are_events) return MSAP_OK;
    sort_events(&s->fresh, &w->scratch, &w->memory);
    sort_events(&s->doomed, &w->scratch, &w->memory);
    return MSAP_OK;
}

/* Step 3: room for the events, and in the lists for as many again: with it they drop
 * repeats instead of growing (settle.c), and are sorted in scratch room for as many. The list
 * of the doomed has room for all pairs. */
static msap_status reserve_events(msap_world *w)
{
    struct settler *s = &w->crew.worker[0].settler;
    size_t active = w->pairs.active - s->doomed.n + s->fresh.n, times = s->has_repeats ? 2 : 1;
    if (active > MSAP_MAX_BOXES) return MSAP_ERROR_FULL;
    int has_room = msap_pairs_reserve(&w->pairs, &w->memory, s->fresh.n, s->doomed.n) &&
                   msap_keys_reserve(&s->fresh, &w->memory, times * s->fresh.n) &&
                   msap_keys_reserve(&s->doomed, &w->memory, times * w->pairs.most_active);
    if (s->has_repeats) msap_scratch_get(&w->scratch, &w->memory, larger_of(s->fresh.room, s->doomed.room));
    return has_room || s->fresh.n == 0 ? MSAP_OK : MSAP_ERROR_MEMORY; /* lost pairs have room where they were */
}

/* Gives back what the commit worked in, so that a smaller one may find memory. */
static void give_up(msap_world *w)
{
    w->stale = 1;
    msap_crew_trim(&w->crew, &w->memory, w->boxes.used, w->pairs.most_active);
    msap_renewal_free(&w->grid.renewal, &w->memory);
    msap_scratch_free(&w->scratch, &w->memory);
}

/* Steps 1 to 4. */
static msap_status apply_changes(msap_world *w)
{
    struct settler *s = &w->crew.worker[0].settler;
    forget_events(s);
    w->grid.moves = 0;
    w->grid.will_know_pairs = w->grid.will_rest = 0;
    int has_changed = w->boxes.n_changed > 0;
    if (has_changed) {
        msap_status status = find_events(w);
        if (status == MSAP_OK) status = reserve_events(w);
        if (status != MSAP_OK) {
            give_up(w);
            return status;
        }
    }
    if (is_grid(&w->config)) msap_grid_committed(&w->grid, s);
    msap_pairs_apply(&w->pairs, &w->boxes, &s->fresh, &s->doomed);
    msap_boxes_committed(&w->boxes);
    if (has_changed && is_grid(&w->config)) {
        struct job job = job_of(w);
        msap_grid_prepare(&w->grid, &job);
    }
    w->commits++;
    return MSAP_OK;
}

/* Gives memory back once the world has used far less than it holds for long. */
static void trim_if_idle(msap_world *w)
{
    enum { LONG = 256, FAR_LESS = 8, LITTLE = 1024 };
    int is_idle = w->boxes.used > LITTLE && w->boxes.live < w->boxes.used / FAR_LESS;
    w->idle_commits = is_idle ? w->idle_commits + 1 : 0;
    if (w->idle_commits < LONG || w->pairs.created + w->pairs.deleted > 0) return;
    msap_world_trim(w);
    w->idle_commits = 0;
}

static void call_back(msap_world *w, const msap_callbacks *callbacks)
{
    const struct pair_table *t = &w->pairs;
    if (t->deleted + t->created == 0) return;
    const struct box_table *box = &w->boxes;
    const msap_pair *deleted = t->at + t->active;
    for (size_t i = 0; callbacks->on_delete && i < t->deleted; i++)
        callbacks->on_delete(callbacks->context, deleted[i].a, deleted[i].b,
                             box_user_data(box, slot_of(deleted[i].a)), box_user_data(box, slot_of(deleted[i].b)),
                             deleted[i].user_data);
    msap_pair *created = t->at + (t->active - t->created);
    for (size_t i = 0; callbacks->on_create && i < t->created; i++)
        created[i].user_data = callbacks->on_create(callbacks->context, created[i].a, created[i].b,
                                                    box_user_data(box, slot_of(created[i].a)),
                                                    box_user_data(box, slot_of(created[i].b)));
}

msap_status msap_commit(msap_world *world, const msap_callbacks *callbacks, msap_counts *counts)
{
    if (!world) return MSAP_ERROR_NULL;
    if (world->busy) return msap_world_fail(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    if ((callbacks && callbacks->struct_size != sizeof *callbacks) ||
        (counts && counts->struct_size != sizeof *counts))
        return msap_world_fail(world, MSAP_ERROR_STRUCT_SIZE, 0, MSAP_NO_BOUND);
    world->busy = 1;
    msap_status status = apply_changes(world);
    if (status == MSAP_OK) {
        if (callbacks) call_back(world, callbacks);
        msap_boxes_free_removed(&world->boxes);
        trim_if_idle(world);
    }
    world->busy = 0;
    if (status != MSAP_OK) return msap_world_fail(world, status, 0, MSAP_NO_BOUND);
    if (counts) {
        counts->created = world->pairs.created;
        counts->deleted = world->pairs.deleted;
        counts->active = world->pairs.active;
    }
    return MSAP_OK;
}
