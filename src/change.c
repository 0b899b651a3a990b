/* Adding, updating and removing boxes: check everything, then change everything.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A single call is a batch of one. A batch is applied whole or not at all: what it did
 * before the first offender is undone. */
#include "internal.h"

/* Opens a call that changes the world, which msap_world.busy marks until it ends. */
static msap_status begin(msap_world *w)
{
    if (!w) return MSAP_ERROR_NULL;
    if (w->busy) return msap_world_fail(w, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    w->busy = 1;
    return MSAP_OK;
}

static msap_status end(msap_world *w, msap_status status)
{
    w->busy = 0;
    return status;
}

/* ------------------------------------------------------------------- adding */

static msap_status reserve(msap_world *w, size_t k)
{
    size_t slots = msap_boxes_slots_for(&w->boxes, k);
    if (slots > MSAP_MAX_BOXES) return MSAP_ERROR_FULL;
    if (!msap_boxes_reserve(&w->boxes, &w->memory, slots)) return MSAP_ERROR_MEMORY;
    int done = is_grid(&w->config) ? msap_grid_reserve(&w->grid, &w->memory, slots) &&
                                         msap_crew_reserve(&w->crew, &w->memory, slots)
                                   : msap_sap_reserve(&w->sap, &w->memory, slots);
    msap_scratch_get(&w->scratch, &w->memory, SCRATCH_WORDS(slots)); /* if there is none now, commits do without */
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
    status = reserve(w, k);
    if (status != MSAP_OK) return msap_world_fail(w, status, 0, MSAP_NO_BOUND);
    status = add_all(w, k, boxes, flags, user_data);
    for (size_t i = 0; i < k && status == MSAP_OK; i++)
        handles[i] = handle_of(&w->boxes, w->boxes.changed[n_changed + i]);
    return status;
}

msap_status msap_add_many(msap_world *world, size_t k, const msap_boxes *boxes, const uint32_t *flags,
                          void *const *user_data, msap_handle *handles)
{
    msap_status status = begin(world);
    return status == MSAP_OK ? end(world, add_many(world, k, boxes, flags, user_data, handles)) : status;
}

msap_status msap_add(msap_world *world, const float *min, const float *max, uint32_t flags, void *user_data,
                     msap_handle *handle)
{
    msap_boxes one = msap_boxes_of_one(min, max);
    return msap_add_many(world, 1, &one, &flags, &user_data, handle);
}

/* ----------------------------------------------------------------- updating */

/* Puts the first n boxes of a batch back: those that it put on the lists, behind the first
 * `n_changed` and `n_left`, were as at the last commit. */
static void undo_update(struct box_table *t, size_t n_changed, size_t n_left)
{
    while (t->n_changed > n_changed) {
        uint32_t slot = t->changed[--t->n_changed];
        t->at[slot].now = t->past[slot].before;
        t->at[slot].flags &= ~(uint32_t)BOX_LEFT;
        t->at[slot].changed_in = 0;
    }
    t->n_left = n_left;
}

/* Updates the boxes of a batch from the i-th on, as long as each is live, was not changed yet and
 * gets legal bounds, which are floats side by side: nearly always all of them, so all that loops
 * need not ask is asked before. Returns the first that is not such a box. */
static inline size_t update_plain(struct box_table *table, const msap_handle *handles, const msap_boxes *from,
                                  size_t i, size_t k, uint32_t dims)
{
    struct box_table t = *table;
    const ptrdiff_t row_min = from->min_row, row_max = from->max_row;
    const char *min = (const char *)from->min + (ptrdiff_t)i * row_min,
               *max = (const char *)from->max + (ptrdiff_t)i * row_max;
    for (; i < k; i++, min += row_min, max += row_max) {
        struct box *b = box_find(&t, handles[i], BOX_LIVE);
        uint32_t slot = slot_of(handles[i]);
        int is_within;
        if (!b || box_is_changed(&t, slot)) break;
        t.past[slot].before = b->now;
        if (!encode_within(load_floats(min, sizeof(float), dims), load_floats(max, sizeof(float), dims), &b->fat,
                           &b->now, &is_within)) {
            b->now = t.past[slot].before;
            break;
        }
        box_list_changed(&t, slot);
        if (!is_within) box_mark_left(&t, slot);
    }
    table->n_changed = t.n_changed;
    table->n_left = t.n_left;
    return i;
}

/* Updates the boxes of a batch that were not changed yet, and checks the others, of
 * which *others becomes the number. */
static msap_status update_unchanged(msap_world *w, size_t k, const msap_handle *handles, const msap_boxes *boxes,
                                    size_t *others)
{
    const msap_boxes from = *boxes;
    uint32_t dims = w->config.dims;
    int is_plain = from.scalar == MSAP_FLOAT && from.min_component == sizeof(float) &&
                   from.max_component == sizeof(float);
    size_t n_changed = w->boxes.n_changed, n_left = w->boxes.n_left;
    for (size_t i = 0; i < k; i++) {
        struct bounds bounds;
        uint32_t bound = MSAP_NO_BOUND;
        if (is_plain && dims == 3) i = update_plain(&w->boxes, handles, &from, i, k, 3);
        else if (is_plain) i = update_plain(&w->boxes, handles, &from, i, k, 2);
        if (i == k) break;
        msap_status status = MSAP_ERROR_HANDLE;
        if (box_find(&w->boxes, handles[i], BOX_LIVE)) status = bounds_read(&from, i, dims, &bounds, &bound);
        if (status == MSAP_OK && box_is_changed(&w->boxes, slot_of(handles[i]))) ++*others;
        else if (status == MSAP_OK) box_change(&w->boxes, slot_of(handles[i]), &bounds);
        if (status != MSAP_OK) {
            undo_update(&w->boxes, n_changed, n_left);
            return msap_world_fail(w, status, i, bound);
        }
    }
    return MSAP_OK;
}

/* Once all are known to be legal, those that had been changed before are done in a
 * second pass; the last update of a box is the last in either. */
static msap_status update_many(msap_world *w, size_t k, const msap_handle *handles, const msap_boxes *boxes)
{
    size_t others = 0;
    msap_status status = msap_boxes_check(boxes, k);
    if (status == MSAP_OK && k > 0 && !handles) status = MSAP_ERROR_NULL;
    if (status != MSAP_OK) return msap_world_fail(w, status, 0, MSAP_NO_BOUND);
    status = update_unchanged(w, k, handles, boxes, &others);
    for (size_t i = 0; i < k && others > 0 && status == MSAP_OK; i++) {
        struct bounds bounds;
        uint32_t bound;
        if (bounds_read(boxes, i, w->config.dims, &bounds, &bound) == MSAP_OK) /* GCOVR_EXCL_BR_LINE: as before */
            box_change(&w->boxes, slot_of(handles[i]), &bounds);
    }
    return status;
}

msap_status msap_update_many(msap_world *world, size_t k, const msap_handle *handles, const msap_boxes *boxes)
{
    msap_status status = begin(world);
    return status == MSAP_OK ? end(world, update_many(world, k, handles, boxes)) : status;
}

msap_status msap_update(msap_world *world, msap_handle handle, const float *min, const float *max)
{
    msap_boxes one = msap_boxes_of_one(min, max);
    return msap_update_many(world, 1, &handle, &one);
}

/* ----------------------------------------------------------------- removing */

/* Takes BOX_LIVE from all of them, so that a handle that comes twice is stale the
 * second time; an offender gives it back to those before it. */
static msap_status check_remove(msap_world *w, size_t k, const msap_handle *handles)
{
    for (size_t i = 0; i < k; i++) {
        struct box *b = box_find(&w->boxes, handles[i], BOX_LIVE);
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
    for (size_t i = 0; i < k && status == MSAP_OK; i++) msap_box_remove(&w->boxes, slot_of(handles[i]));
    return status;
}

msap_status msap_remove_many(msap_world *world, size_t k, const msap_handle *handles)
{
    msap_status status = begin(world);
    return status == MSAP_OK ? end(world, remove_many(world, k, handles)) : status;
}

msap_status msap_remove(msap_world *world, msap_handle handle) { return msap_remove_many(world, 1, &handle); }
