/* Settling: what a touched pair comes to (the decision itself is in internal.h, since
 * it is made for every touch).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Whatever touched the pair, and in which order axes and boxes were processed, the
 * decision is made from the boxes alone, as they were at the last commit and
 * as they are now. So nothing is ever decided by half-updated data, a pair that
 * begins and ceases to overlap between two commits leaves no trace, and "start
 * before stop" (paper I.3) is no rule that anybody must keep. The test of `before` is
 * the paper's overlap test prior to a removal (I.3): of all the crossings that look
 * like removals it lets only the real ones through. Where a neighbour list remembers
 * what the last commit decided (near.c), that test is spared. */
#include "internal.h"

static void drop_repeats(struct keys *list)
{
    msap_sort_keys(list->at, list->n, NULL);
    list->n = msap_unique_keys(list->at, list->n);
}

/* Makes room in a full list of the calling thread. Where one pair may be touched often,
 * the list first drops repeats, and grows unless they were half of it or more: so it
 * grows only if more pairs changed than ever before, however often they were touched.
 * Without memory it can still drop repeats. */
static int make_room(struct settler *s, struct keys *list)
{
    if (s->has_repeats) drop_repeats(list);
    if (list->n > list->room / 2 || list->room == 0) {
        if (msap_keys_reserve(list, s->memory, list->room + 64)) return 1;
        if (!s->has_repeats) drop_repeats(list);
    }
    return list->n < list->room;
}

/* The list is full. A worker counts on (phase.c). On the calling thread the list
 * of fresh pairs may lack memory, and then this commit fails; that of the doomed holds
 * all known pairs when it has no room left, this one among them. */
static void put_into_full(struct settler *s, struct keys *list, uint64_t key, int is)
{
    if (!s->memory) {
        s->lost = 1;
        list->n++;
        return;
    }
    if (s->lost || (!is && s->has_all_doomed)) return;
    if (make_room(s, list)) list->at[list->n++] = key;
    else if (is) s->lost = 1;
    else s->has_all_doomed = 1;
}

/* A pair that overlaps now and did not before, or the other way round. */
void msap_settle_change(struct settler *s, uint64_t key, int is)
{
    struct keys *list = is ? &s->fresh : &s->doomed;
    if (list->n < list->room) list->at[list->n++] = key;
    else put_into_full(s, list, key, is);
}

/* Notes the entry of a neighbour list that tells of a pair that changed. Without memory for it the calling
 * thread does without notes. */
void msap_settle_note(struct settler *s, uint32_t slot, uint32_t index)
{
    struct keys *list = &s->notes;
    if (list->n < list->room || (s->memory && msap_keys_reserve(list, s->memory, list->room + 64))) {
        list->at[list->n++] = (uint64_t)slot << 32 | index;
    } else if (s->memory) {
        s->has_no_notes = 1;
    } else {
        s->lost = 1;
        list->n++; /* a worker counts on */
    }
}

/* Settles pairs that overlap now, not both static, nearly all of which are known, when the bounds before of all
 * boxes are in `past`: so they are looked at by fours. */
void msap_settle_found(struct settler *s, const struct pair_buffer *found)
{
    size_t i = 0;
    s->touched += found->n;
    for (; found->n - i >= 4; i += 4) {
        uint32_t fresh = known_among(s->boxes->past, found->a + i, found->b + i) ^ 15;
        for (size_t k = i; fresh > 0; k++, fresh >>= 1)
            if (fresh & 1) msap_settle_change(s, pair_key(found->a[k], found->b[k]), 1);
    }
    for (; i < found->n; i++) settle_found(s, found->a[i], found->b[i]);
}

/* Whether the boxes of a pair are both live; they are if none was removed. */
static inline int are_live(const struct box_table *t, uint32_t a, uint32_t b)
{
    return t->removed.head == NONE || (t->at[a].flags & t->at[b].flags & BOX_LIVE);
}

static void touch_known_pair(const struct box_table *t, struct settler *s, const msap_pair *pair)
{
    uint32_t a = slot_of(pair->a), b = slot_of(pair->b);
    if (!overlap(&t->at[a].now, &t->at[b].now) || !are_live(t, a, b)) msap_settle_change(s, pair_key(a, b), 0);
}

static inline gaps gaps_between(const struct box *box, const msap_pair *pair)
{
    return gaps_of(&box[slot_of(pair->a)].now, &box[slot_of(pair->b)].now);
}

/* Of four pairs of live boxes, settles those that do not overlap now. */
static inline void touch_four(struct settler *s, const struct box *box, const msap_pair *pair)
{
    uint32_t are = overlaps_of(gaps_between(box, pair), gaps_between(box, pair + 1), gaps_between(box, pair + 2),
                               gaps_between(box, pair + 3));
    for (uint32_t gone = are ^ 15; gone > 0; gone >>= 1, pair++)
        if (gone & 1) msap_settle_change(s, pair_key(slot_of(pair->a), slot_of(pair->b)), 0);
}

/* Nearly all known pairs are still pairs: so, where no box was removed, they are looked at by fours. */
static void touch_known(void *context, struct worker *w, size_t first, size_t last)
{
    const struct job *job = context;
    const struct box_table *t = job->boxes;
    const msap_pair *pair = job->pairs->at;
    size_t i = first, fours = t->removed.head == NONE ? (last - first) / 4 : 0;
    w->settler.touched += last - first;
    for (; fours > 0; fours--, i += 4) touch_four(&w->settler, t->at, pair + i);
    for (; i < last; i++) touch_known_pair(t, &w->settler, &pair[i]);
}

/* Touches the known pairs. It cannot lack memory: the list of the doomed has room for them all. */
void msap_touch_known_pairs(struct job *job)
{
    msap_phase_run(job->crew, job->memory, touch_known, job, job->pairs->active, WEIGHT_KNOWN);
}

/* The last resort, when there is no memory for anything better: touches every pair
 * that a changed box could make. */
void msap_touch_all_boxes(const struct job *job)
{
    const struct box_table *t = job->boxes;
    for (size_t i = 0; i < t->n_changed; i++)
        for (uint32_t other = 0; other < t->used; other++)
            if (other != t->changed[i]) settle(&job->worker->settler, t->changed[i], other);
}
