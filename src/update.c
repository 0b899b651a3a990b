/* Updating boxes: check everything, then change everything.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A single call is a batch of one. A batch is applied whole or not at all: what it did
 * before the first offender is undone.
 *
 * A large batch is shared by all workers (paper II.3d): each goes through all handles and
 * updates the boxes in its part of the table, so that no two of them ever have the same box, in
 * whatever order boxes come and however often. Should any of them not be as nearly all are, all
 * is undone, and the calling thread, which sees to everything, does it alone. */
#include "internal.h"

/* Puts the first n boxes of a batch back: those that it put on the lists, behind the first
 * `n_changed` and `n_left`, were as at the last commit. */
static void undo_update(struct box_table *t, size_t n_changed, size_t n_left)
{
    while (t->n_changed > n_changed) {
        uint32_t slot = t->changed[--t->n_changed];
        t->at[slot].now = t->past[slot].before;
        t->at[slot].left = STAYED;
        t->at[slot].changed_in = 0;
    }
    t->n_left = n_left;
}

/* ---------------------------------------------------------- as nearly all are */

/* Whether bounds are floats side by side, min and max in rows equally far apart. */
static int is_plain(const msap_boxes *boxes)
{
    return boxes->scalar == MSAP_FLOAT && boxes->min_component == sizeof(float) &&
           boxes->max_component == sizeof(float) && boxes->min_row == boxes->max_row;
}

/* The slots first ... first + more. */
struct part {
    uint32_t first, more;
};

/* Whether the boxes of a batch lie here and there in the table instead of one behind the other, as they
 * mostly do: by some of them. */
static int are_scattered(const msap_handle *handles, size_t k)
{
    enum { SAMPLES = 8, NEAR = 4 };
    size_t step = k / SAMPLES + 1, n = 0, far = 0;
    for (size_t i = 0; i + 1 < k; i += step, n++) far += slot_of(handles[i + 1]) - slot_of(handles[i]) > NEAR;
    return far > n / 2;
}

/* Updates the boxes of a plain batch in a part of the slots, from the i-th of the batch on, as long as
 * each is live, was not changed yet and gets legal bounds: nearly always all of them, so all that loops
 * need not ask is asked before. Returns the first that is not such a box. */
static ALWAYS_INLINE size_t update_plain(struct box_table *table, const struct part *part,
                                         const msap_handle *handles, const msap_boxes *from, size_t i, size_t k,
                                         uint32_t dims, int scattered)
{
    enum { AHEAD = 24 };
    struct box_table t = *table;
    const struct part own = *part;
    const char *min = from->min, *max = from->max;
    const ptrdiff_t row = from->min_row;
    const msap_handle *h = handles + i, *end = handles + k;
    for (ptrdiff_t at = (ptrdiff_t)i * row; h < end; h++, at += row) {
        uint32_t slot = slot_of(*h);
        if (scattered && end - h > AHEAD) box_fetch(&t, h[AHEAD]);
        if (slot - own.first > own.more) continue;
        struct box *b = box_find(&t, *h, BOX_LIVE);
        int is_within;
        if (!b || box_is_changed(&t, slot)) break;
        t.past[slot].before = b->now;
        if (!encode_within(load_floats(min + at, sizeof(float), dims), load_floats(max + at, sizeof(float), dims),
                           &b->fat, &b->now, &is_within)) {
            b->now = t.past[slot].before;
            break;
        }
        box_list_changed(&t, slot);
        if (!is_within) box_mark_left(&t, slot);
    }
    table->n_changed = t.n_changed;
    table->n_left = t.n_left;
    return (size_t)(h - handles);
}

/* The same in a world of 2 or 3 axes, some boxes after others. */
static ALWAYS_INLINE size_t update_part(struct box_table *t, const struct part *part, const msap_handle *handles,
                                        const msap_boxes *from, size_t i, size_t k, uint32_t dims)
{
    enum { SOME = 256 };
    size_t end = i;
    while (i == end && i < k) {
        end = k - i < SOME ? k : i + SOME;
        int scattered = are_scattered(handles + i, end - i);
        if (dims == 3 && scattered) i = update_plain(t, part, handles, from, i, end, 3, 1);
        else if (dims == 3) i = update_plain(t, part, handles, from, i, end, 3, 0);
        else if (scattered) i = update_plain(t, part, handles, from, i, end, 2, 1);
        else i = update_plain(t, part, handles, from, i, end, 2, 0);
    }
    return i;
}

/* -------------------------------------------------------------------- shared */

/* How many a worker has put on the lists, from its first slot on. */
struct listed {
    size_t first, n_changed, n_left;
};

/* A batch at work. */
struct updating {
    const msap_world *world;
    const msap_handle *handles;
    const msap_boxes *boxes;
    size_t k;
    struct listed by[1 + MOST_WORKERS];
};

/* Updates the boxes in slots first ... last - 1. */
static void update_slots(void *context, struct worker *w, size_t first, size_t last)
{
    struct updating *u = context;
    const struct part own = {(uint32_t)first, (uint32_t)(last - first - 1)};
    struct box_table t = u->world->boxes;
    t.changed += first;
    t.left += first;
    update_part(&t, &own, u->handles, u->boxes, 0, u->k, u->world->config.dims);
    const struct listed listed = {first, t.n_changed, t.n_left};
    u->by[w - u->world->crew.worker] = listed;
}

/* Appends to a list what stands further on in it. */
static void append(uint32_t *list, size_t *n, size_t first, size_t more)
{
    memmove(list + *n, list + first, more * sizeof *list);
    *n += more;
}

/* Updates the boxes of a batch that is worth it if they are as nearly all are. Returns 0, with nothing
 * done, if not. */
static int update_shared(msap_world *w, size_t k, const msap_handle *handles, const msap_boxes *boxes)
{
    struct box_table *t = &w->boxes;
    size_t tasks = msap_phase_tasks(&w->crew, k, WEIGHT_UPDATE);
    if (tasks < 2 || k < t->used / 2 || t->n_changed > 0 || !is_plain(boxes)) return 0;
    struct updating u = {.world = w, .handles = handles, .boxes = boxes, .k = k};
    msap_phase_run(&w->crew, &w->memory, update_slots, &u, t->used, WEIGHT_UPDATE);
    for (size_t i = 0; i <= MOST_WORKERS; i++) {
        append(t->changed, &t->n_changed, u.by[i].first, u.by[i].n_changed);
        append(t->left, &t->n_left, u.by[i].first, u.by[i].n_left);
    }
    if (t->n_changed == k) return 1;
    undo_update(t, 0, 0);
    return 0;
}

/* ----------------------------------------------------------------- the whole */

/* Updates the boxes of a batch that were not changed yet, and checks the others, of
 * which *others becomes the number. */
static msap_status update_unchanged(msap_world *w, size_t k, const msap_handle *handles, const msap_boxes *boxes,
                                    size_t *others)
{
    const msap_boxes from = *boxes;
    const struct part all = {0, UINT32_MAX};
    int plain = is_plain(boxes);
    size_t n_changed = w->boxes.n_changed, n_left = w->boxes.n_left;
    for (size_t i = 0; i < k; i++) {
        struct bounds bounds;
        uint32_t bound = MSAP_NO_BOUND;
        if (plain) i = update_part(&w->boxes, &all, handles, &from, i, k, w->config.dims);
        if (i == k) break;
        msap_status status = MSAP_ERROR_HANDLE;
        if (box_find(&w->boxes, handles[i], BOX_LIVE))
            status = bounds_read(&from, i, w->config.dims, &bounds, &bound);
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
    if (update_shared(w, k, handles, boxes)) return MSAP_OK;
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
    msap_status status = msap_world_begin(world);
    return status == MSAP_OK ? msap_world_end(world, update_many(world, k, handles, boxes)) : status;
}

msap_status msap_update(msap_world *world, msap_handle handle, const float *min, const float *max)
{
    msap_boxes one = msap_boxes_of_one(min, max);
    return msap_update_many(world, 1, &handle, &one);
}
