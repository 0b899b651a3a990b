/* The box table: slots, handles, and which boxes changed.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A slot is given out by box_add, emptied by box_remove and returned to the queue
 * of free slots once the commit that reports the removal has run, so that a slot
 * means one box to a commit. Every function but boxes_reserve works without
 * allocating: there is room on its lists for every slot. */
#include "internal.h"

static void set_next(struct box *b, uint32_t slot) { b->now.min[0] = (int32_t)slot; }
static void set_ahead(struct box *b, uint32_t slot) { b->now.min[1] = (int32_t)slot; }

static void queue_put(struct box_table *t, struct slot_queue *q, uint32_t slot)
{
    uint32_t *latest = &q->latest[q->put++ % QUEUE_AHEAD];
    if (q->n >= QUEUE_AHEAD) set_ahead(&t->at[*latest], slot);
    *latest = slot;
    set_next(&t->at[slot], NONE);
    set_ahead(&t->at[slot], NONE);
    if (q->head == NONE) q->head = slot;
    else set_next(&t->at[q->tail], slot);
    q->tail = slot;
    q->n++;
}

/* Takes back that a slot was taken, last of all. */
static void queue_put_back(struct box_table *t, struct slot_queue *q, uint32_t slot)
{
    set_next(&t->at[slot], q->head);
    set_ahead(&t->at[slot], NONE);
    if (q->head == NONE) q->tail = slot;
    q->head = slot;
    q->n++;
}

/* What will be taken soon is fetched into the cache: queues are long when many boxes come or go, and in any
 * order. */
static uint32_t queue_take(struct box_table *t, struct slot_queue *q)
{
    uint32_t slot = q->head, ahead = box_ahead(&t->at[slot]);
    q->head = box_next(&t->at[slot]);
    q->n--;
    if (ahead == NONE) return slot;
    prefetch(&t->at[ahead]);
    prefetch(&t->past[ahead]);
    return slot;
}

void msap_boxes_init(struct box_table *t)
{
    struct box_table empty = {0};
    empty.removed.head = empty.removed.tail = NONE;
    empty.free = empty.removed;
    empty.first_generation = empty.epoch = 1;
    *t = empty;
}

void msap_boxes_free(struct box_table *t, struct memory *m)
{
    msap_memory_free(m, t->at, t->room, sizeof *t->at);
    msap_memory_free(m, t->past, t->room_past, sizeof *t->past);
    msap_memory_free(m, t->user_data, t->room_user, sizeof *t->user_data);
    msap_memory_free(m, t->changed, t->room_changed, sizeof *t->changed);
    msap_memory_free(m, t->left, t->room_left, sizeof *t->left);
}

/* User data from now on, for so many slots: what is there stays. Returns 0 without memory. */
int msap_boxes_hold_user_data(struct box_table *t, struct memory *m, size_t slots)
{
    size_t had = t->user_data ? t->used : 0;
    if (!msap_memory_reserve(m, &t->user_data, &t->room_user, slots, had, sizeof *t->user_data)) return 0;
    for (size_t slot = had; slot < t->used; slot++) t->user_data[slot] = NULL;
    return 1;
}

int msap_boxes_reserve(struct box_table *t, struct memory *m, size_t slots)
{
    if (t->user_data && !msap_boxes_hold_user_data(t, m, slots)) return 0;
    return msap_memory_reserve(m, &t->at, &t->room, slots, t->used, sizeof *t->at) &&
           msap_memory_reserve(m, &t->past, &t->room_past, slots, t->used, sizeof *t->past) &&
           msap_memory_reserve(m, &t->changed, &t->room_changed, slots, t->n_changed, sizeof *t->changed) &&
           msap_memory_reserve(m, &t->left, &t->room_left, slots, t->n_left, sizeof *t->left);
}

static int is_free(const struct box *b) { return b->flags == 0 && b->generation != 0; }

/* Forgets the free slots at the end of the table. A slot that is later given out in
 * place of one has a generation that no handle of it had. */
static void forget_slots(struct box_table *t)
{
    struct slot_queue kept = {.head = NONE, .tail = NONE};
    while (t->used > 0 && is_free(&t->at[t->used - 1])) {
        uint32_t generation = t->at[--t->used].generation;
        if (generation > t->first_generation) t->first_generation = generation;
    }
    while (t->free.head != NONE) {
        uint32_t slot = queue_take(t, &t->free);
        if (slot < t->used) queue_put(t, &kept, slot);
    }
    t->free = kept;
}

/* Gives back what the boxes do not need. */
void msap_boxes_trim(struct box_table *t, struct memory *m)
{
    forget_slots(t);
    msap_memory_shrink(m, &t->at, &t->room, t->used, sizeof *t->at);
    msap_memory_shrink(m, &t->past, &t->room_past, t->used, sizeof *t->past);
    msap_memory_shrink(m, &t->user_data, &t->room_user, t->used, sizeof *t->user_data);
    msap_memory_shrink(m, &t->changed, &t->room_changed, t->used, sizeof *t->changed);
    msap_memory_shrink(m, &t->left, &t->room_left, t->used, sizeof *t->left);
}

/* How many slots the table needs to take k more boxes. */
size_t msap_boxes_slots_for(const struct box_table *t, size_t k)
{
    return t->used + (k > t->free.n ? k - t->free.n : 0);
}

static uint32_t take_slot(struct box_table *t)
{
    if (t->free.head != NONE) return queue_take(t, &t->free);
    t->at[t->used].generation = t->first_generation;
    return (uint32_t)t->used++;
}

/* The table has room. The slot comes to the ends of both lists. */
void msap_box_add(struct box_table *t, const struct bounds *bounds, uint32_t flags, void *user_data)
{
    static const struct box fresh = {
        .left = LEFT, .fat = EVERYWHERE, .level = NO_LEVEL, .horizon = HORIZON_FIRST, .wobble = 1};
    static const struct past none = {.before = NOWHERE};
    uint32_t slot = take_slot(t), is_static = flags & MSAP_STATIC ? BOX_STATIC : 0;
    struct box *b = &t->at[slot];
    uint32_t generation = b->generation;
    *b = fresh;
    b->now = *bounds;
    b->generation = generation;
    b->flags = (uint8_t)(BOX_LIVE | is_static);
    if (t->user_data) t->user_data[slot] = user_data;
    t->live++;
    t->live_static += is_static != 0;
    t->past[slot] = none;
    box_list_changed(t, slot);
    t->left[t->n_left++] = slot;
}

/* Takes back the additions since the table had so many slots used and so many boxes on its
 * lists: the last ones come off its end, the others go to the head of the free queue. */
void msap_boxes_undo_add(struct box_table *t, size_t used, size_t n_changed, size_t n_left)
{
    t->n_left = n_left;
    while (t->n_changed > n_changed) {
        uint32_t slot = t->changed[--t->n_changed];
        t->live--;
        t->live_static -= (t->at[slot].flags & BOX_STATIC) != 0;
        t->at[slot].flags = 0;
        t->at[slot].left = STAYED;
        t->at[slot].changed_in = 0;
        if (slot >= used) t->used--;
        else queue_put_back(t, &t->free, slot);
    }
}

void msap_box_remove(struct box_table *t, uint32_t slot)
{
    t->at[slot].flags = (t->at[slot].flags & ~(uint32_t)BOX_LIVE) | BOX_REMOVED;
    t->live--;
    t->live_static -= (t->at[slot].flags & BOX_STATIC) != 0;
    box_mark_changed(t, slot);
    box_mark_left(t, slot);
    queue_put(t, &t->removed, slot);
}

/* After 2^32 commits no box may seem to have changed. */
static void next_epoch(struct box_table *t)
{
    if (++t->epoch != 0) return;
    for (size_t slot = 0; slot < t->used; slot++) t->at[slot].changed_in = 0;
    t->epoch = 1;
}

/* Puts the bounds before of the others into `past` too. */
void msap_boxes_complete_before(struct box_table *t)
{
    if (t->n_changed == t->live && t->removed.head == NONE) return; /* all have changed */
    for (uint32_t slot = 0; slot < t->used; slot++)
        if (!box_is_changed(t, slot)) t->past[slot].before = t->at[slot].now;
}

/* The commit succeeded: nothing is changed, and what is now was before. */
void msap_boxes_committed(struct box_table *t)
{
    enum { AHEAD = 24 };
    for (size_t i = 0; i < t->n_left; i++) {
        struct box *b = &t->at[t->left[i]];
        if (t->n_left - i > AHEAD) prefetch(&t->at[t->left[i + AHEAD]]);
        b->left = STAYED;
        b->flags &= ~(uint32_t)BOX_WAS;
        if (b->flags & BOX_LIVE) b->flags |= BOX_WAS;
    }
    t->n_changed = t->n_left = 0;
    next_epoch(t);
}

/* Gives the removed slots back for use under their next generation. */
void msap_boxes_free_removed(struct box_table *t)
{
    while (t->removed.head != NONE) {
        uint32_t slot = queue_take(t, &t->removed);
        struct box *b = &t->at[slot];
        b->flags = 0;
        if (++b->generation != 0) queue_put(t, &t->free, slot);
    }
}
