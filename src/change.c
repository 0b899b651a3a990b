/* Adding and removing boxes: check everything, then change everything.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A single call is a batch of one. A batch is applied whole or not at all: what it did
 * before the first offender is undone. */
#include "internal.h"

/* ------------------------------------------------------------------- adding */

/* Whether any of k boxes has user data. */
static int is_any(size_t k, void *const *user_data)
{
    for (size_t i = 0; user_data && i < k; i++)
        if (user_data[i]) return 1;
    return 0;
}

static msap_status reserve(msap_world *w, size_t k, void *const *user_data)
{
    size_t slots = msap_boxes_slots_for(&w->boxes, k);
    if (slots > MSAP_MAX_BOXES) return MSAP_ERROR_FULL;
    if (!msap_boxes_reserve(&w->boxes, &w->memory, slots)) return MSAP_ERROR_MEMORY;
    if (is_any(k, user_data) && !msap_boxes_hold_user_data(&w->boxes, &w->memory, slots)) return MSAP_ERROR_MEMORY;
    int done = is_grid(&w->config) ? msap_grid_reserve(&w->grid, &w->memory, slots) &&
                                         msap_crew_reserve(&w->crew, &w->memory, slots)
                                   : msap_sap_reserve(&w->sap, &w->memory, slots);
    size_t words = is_grid(&w->config) ? GRID_WORDS(slots) : SCRATCH_WORDS(slots);
    msap_scratch_get(&w->scratch, &w->memory, words); /* if there is none now, commits do without */
    return done ? MSAP_OK : MSAP_ERROR_MEMORY;
}

/* Adds a row of a batch; the caller's memory is read once. */
static msap_status add_one(msap_world *w, const msap_boxes *boxes, size_t row, uint32_t flags, void *user_data,
                           uint32_t *bound)
{
    struct bounds bounds;
    msap_status status = bounds_read(boxes, row, w->config.dims, &bounds, bound);
    if (status == MSAP_OK && (flags & ~MSAP_STATIC)) status = MSAP_ERROR_CONFIG;
    if (status == MSAP_OK) msap_box_add(&w->boxes, &bounds, flags, user_data);
    return status;
}

/* Adds the boxes of a batch, for which there is room, or none of them. */
static msap_status add_all(msap_world *w, size_t k, const msap_boxes *boxes, const uint32_t *flags,
                           void *const *user_data)
{
    struct box_table *t = &w->boxes;
    size_t used = t->used, n_changed = t->n_changed, n_left = t->n_left;
    for (size_t i = 0; i < k; i++) {
        uint32_t bound = MSAP_NO_BOUND;
        msap_status status = add_one(w, boxes, i, flags ? flags[i] : 0, user_data ? user_data[i] : NULL, &bound);
        if (status == MSAP_OK) continue;
        msap_boxes_undo_add(t, used, n_changed, n_left);
        return msap_world_fail(w, status, i, bound);
    }
    return MSAP_OK;
}

static msap_status add_many(msap_world *w, size_t k, const msap_boxes *boxes, const uint32_t *flags,
                            void *const *user_data, msap_handle *handles)
{
    msap_status status = msap_boxes_check(boxes, k);
    size_t places = w->config.max_boxes - w->boxes.live, n_changed = w->boxes.n_changed;
    if (status == MSAP_OK && k > 0 && !handles) status = MSAP_ERROR_NULL;
    if (status != MSAP_OK) return msap_world_fail(w, status, 0, MSAP_NO_BOUND);
    if (k > places) return msap_world_fail(w, MSAP_ERROR_FULL, places, MSAP_NO_BOUND);
    status = reserve(w, k, user_data);
    if (status != MSAP_OK) return msap_world_fail(w, status, 0, MSAP_NO_BOUND);
    status = add_all(w, k, boxes, flags, user_data);
    for (size_t i = 0; i < k && status == MSAP_OK; i++)
        handles[i] = handle_of(&w->boxes, w->boxes.changed[n_changed + i]);
    return status;
}

msap_status msap_add_many(msap_world *world, size_t k, const msap_boxes *boxes, const uint32_t *flags,
                          void *const *user_data, msap_handle *handles)
{
    msap_status status = msap_world_begin(world);
    return status == MSAP_OK ? msap_world_end(world, add_many(world, k, boxes, flags, user_data, handles))
                             : status;
}

msap_status msap_add(msap_world *world, const float *min, const float *max, uint32_t flags, void *user_data,
                     msap_handle *handle)
{
    msap_boxes one = msap_boxes_of_one(min, max);
    return msap_add_many(world, 1, &one, &flags, &user_data, handle);
}

/* ----------------------------------------------------------------- removing */

/* Boxes are fetched so far ahead of the one that is seen to. */
enum { AHEAD = 24 };

/* Takes BOX_LIVE from all of them, so that a handle that comes twice is stale the
 * second time; an offender gives it back to those before it. */
static msap_status check_remove(msap_world *w, size_t k, const msap_handle *handles)
{
    for (size_t i = 0; i < k; i++) {
        struct box *b = box_find(&w->boxes, handles[i], BOX_LIVE);
        if (k - i > AHEAD) box_fetch(&w->boxes, handles[i + AHEAD]);
        if (!b) {
            for (size_t j = 0; j < i; j++) w->boxes.at[slot_of(handles[j])].flags |= BOX_LIVE;
            return msap_world_fail(w, MSAP_ERROR_HANDLE, i, MSAP_NO_BOUND);
        }
        b->flags &= ~(uint32_t)BOX_LIVE;
    }
    return MSAP_OK;
}

static msap_status remove_many(msap_world *w, size_t k, const msap_handle *handles)
{
    if (k > 0 && !handles) return msap_world_fail(w, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND);
    msap_status status = check_remove(w, k, handles);
    for (size_t i = 0; i < k && status == MSAP_OK; i++) {
        if (k - i > AHEAD) box_fetch(&w->boxes, handles[i + AHEAD]);
        msap_box_remove(&w->boxes, slot_of(handles[i]));
    }
    return status;
}

msap_status msap_remove_many(msap_world *world, size_t k, const msap_handle *handles)
{
    msap_status status = msap_world_begin(world);
    return status == MSAP_OK ? msap_world_end(world, remove_many(world, k, handles)) : status;
}

msap_status msap_remove(msap_world *world, msap_handle handle) { return msap_remove_many(world, 1, &handle); }
