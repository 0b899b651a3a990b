/* Candidates: the pairs whose skins overlap, while boxes rest in skins (renew.c).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The candidates are exactly the pairs of boxes in the grid, not both static, whose fat bounds overlap, each
 * once and in any order; its entry tells whether it was a pair at the last commit. (Between a renewal in steps
 * and the next commit none knows yet, and some are void.) So no box needs a list of its neighbours, and a
 * commit goes through one array:
 *
 * 1. All candidates are touched. Those of a box that left its skin are dropped.
 * 2. Boxes that left get new skins and are put into cells (move.c).
 * 3. They ask cells and rows what their candidates are now. Of two that left the lower one does.
 *
 * A pair that overlapped before was a candidate and is touched in step 1. One that overlaps now is touched there
 * or is found in step 3, if a box of it left. */
#include "cells.h"

/* Besides the index of a candidate that is named: a box of it left. */
#define VACANT ((uint64_t)1 << 32)

/* Fetches the boxes of a candidate further on and, as told, where they were. */
static ALWAYS_INLINE void fetch_ahead(const struct box_table *t, const uint64_t *c, size_t i, size_t last,
                                      int with_past)
{
    enum { AHEAD = 48 };
    if (i + AHEAD >= last) return;
    uint32_t a = (uint32_t)(c[i + AHEAD] >> 32), b = near_slot((uint32_t)c[i + AHEAD]);
    prefetch(&t->at[a]);
    prefetch(&t->at[b]);
    if (with_past) prefetch(&t->past[a]);
    if (with_past) prefetch(&t->past[b]);
}

/* ------------------------------------------------------------------- step 1 */

/* Candidates that are touched: from one on. */
struct touching {
    struct grid *grid;
    size_t from;
};

/* Names and settles a candidate that is not what it was. */
static inline void take_changed(struct worker *w, uint64_t candidate, size_t i)
{
    uint32_t a = (uint32_t)(candidate >> 32), entry = (uint32_t)candidate;
    msap_worker_put(w, i);
    msap_settle_change(&w->settler, pair_key(a, near_slot(entry)), !(entry & NEAR_PAIR));
}

/* The same of one that a box of it left, whatever it is: its place is vacant. */
static void take_left(const struct box *boxes, struct worker *w, uint64_t candidate, size_t i)
{
    uint32_t a = (uint32_t)(candidate >> 32), entry = (uint32_t)candidate, b = near_slot(entry);
    const struct box *p = &boxes[a], *q = &boxes[b];
    int is = (p->flags & q->flags & BOX_LIVE) && overlap(&p->now, &q->now);
    msap_worker_put(w, i | VACANT);
    if (is != (int)(entry >> 31)) msap_settle_change(&w->settler, pair_key(a, b), is);
}

/* Names and settles a candidate that changed, or that a box of it left. */
static void touch_one(const struct box *boxes, struct worker *w, uint64_t candidate, size_t i)
{
    uint32_t a = (uint32_t)(candidate >> 32), entry = (uint32_t)candidate, b = near_slot(entry);
    const struct box *p = &boxes[a], *q = &boxes[b];
    if (box_has_left(p) || box_has_left(q)) take_left(boxes, w, candidate, i);
    else if (overlap(&p->now, &q->now) != (int)(entry >> 31)) take_changed(w, candidate, i);
}

static ALWAYS_INLINE gaps gaps_at(const struct box *boxes, uint64_t c)
{
    return gaps_of_boxes(&boxes[c >> 32], &boxes[near_slot((uint32_t)c)]);
}

/* Settles candidates i ... end - 1; names those that changed and those with a box that left. Nearly all are as
 * they were: so they are looked at by fours. */
static ALWAYS_INLINE void touch_some(const struct grid *g, struct worker *w, size_t i, size_t end, int fetches)
{
    const struct box *boxes = g->boxes->at;
    const uint64_t *c = g->candidates.at;
    for (; end - i >= 4; i += 4) {
        for (size_t k = 0; fetches && k < 4; k++) fetch_ahead(g->boxes, c, i + k, end, 0);
        uint32_t left, are = overlaps_and_fourth(gaps_at(boxes, c[i]), gaps_at(boxes, c[i + 1]),
                                                 gaps_at(boxes, c[i + 2]), gaps_at(boxes, c[i + 3]), &left);
        uint32_t changed = left | (are ^ marks_of_four(c + i));
        for (size_t k = i; changed > 0; k++, changed >>= 1, left >>= 1) {
            if (left & 1) take_left(boxes, w, c[k], k);
            else if (changed & 1) take_changed(w, c[k], k);
        }
    }
    for (; i < end; i++) touch_one(boxes, w, c[i], i);
}

/* The same of first ... last - 1 from there on. */
static void touch(void *context, struct worker *w, size_t first, size_t last)
{
    const struct touching *t = context;
    size_t i = t->from + first, end = t->from + last;
    w->settler.touched += last - first;
    if (t->grid->boxes->used > MANY_BOXES) touch_some(t->grid, w, i, end, 1);
    else touch_some(t->grid, w, i, end, 0);
}

/* Settles a candidate that does not know what it was, and lets it know what it is. It is named if it means nothing,
 * or if a box of it left: then its place is vacant. */
static void tell_one(const struct box_table *t, struct worker *w, uint64_t *c, size_t i)
{
    uint32_t a = (uint32_t)(c[i] >> 32), b = near_slot((uint32_t)c[i]);
    const struct box *p = &t->at[a], *q = &t->at[b];
    int is_void = candidate_is_void(t, a, b), is = (p->flags & q->flags & BOX_LIVE) && overlap(&p->now, &q->now);
    if (is_void || box_has_left(p) || box_has_left(q)) msap_worker_put(w, i | VACANT);
    if (is_void) return;
    c[i] = (uint64_t)a << 32 | b | (is ? NEAR_PAIR : 0);
    if (is != were_pair(t, a, b)) msap_settle_change(&w->settler, pair_key(a, b), is);
}

static ALWAYS_INLINE gaps gaps_before(const struct past *past, uint64_t c)
{
    return gaps_of(&past[c >> 32].before, &past[near_slot((uint32_t)c)].before);
}

static ALWAYS_INLINE uint32_t is_void_at(const struct box_table *t, uint64_t c)
{
    return (uint32_t)candidate_is_void(t, (uint32_t)(c >> 32), near_slot((uint32_t)c));
}

/* The same of candidates i ... end - 1, when the bounds before of all boxes are in `past`. Nearly all are as they
 * were: so they are looked at by fours. */
static ALWAYS_INLINE void tell_some(const struct box_table *t, struct worker *w, uint64_t *c, size_t i, size_t end,
                                    int fetches)
{
    for (; end - i >= 4; i += 4) {
        for (size_t k = 0; fetches && k < 4; k++) fetch_ahead(t, c, i + k, end, 1);
        uint32_t left, are = overlaps_and_fourth(gaps_at(t->at, c[i]), gaps_at(t->at, c[i + 1]),
                                                 gaps_at(t->at, c[i + 2]), gaps_at(t->at, c[i + 3]), &left);
        uint32_t were = overlaps_of(gaps_before(t->past, c[i]), gaps_before(t->past, c[i + 1]),
                                    gaps_before(t->past, c[i + 2]), gaps_before(t->past, c[i + 3]));
        uint32_t odd = left | (are ^ were) | is_void_at(t, c[i]) | is_void_at(t, c[i + 1]) << 1 |
                       is_void_at(t, c[i + 2]) << 2 | is_void_at(t, c[i + 3]) << 3;
        for (size_t k = 0; k < 4; k++, odd >>= 1, are >>= 1) {
            if (odd & 1) tell_one(t, w, c, i + k);
            else c[i + k] |= (uint64_t)(are & 1) << 31; /* if once more, the same */
        }
    }
    for (; i < end; i++) tell_one(t, w, c, i);
}

/* The same of the first ones, which do not know what they were. Those with a box that did not rest when all got
 * skins mean nothing: others were found for it (renew.c). */
static void touch_untold(void *context, struct worker *w, size_t first, size_t last)
{
    const struct touching *t = context;
    const struct box_table *boxes = t->grid->boxes;
    uint64_t *c = t->grid->candidates.at;
    w->settler.touched += last - first;
    if (boxes->used > MANY_BOXES) tell_some(boxes, w, c, first, last, 1);
    else tell_some(boxes, w, c, first, last, 0);
}

/* Of the candidates that the worker has named, lets those that changed tell so. The others stay named: their
 * places are vacant. */
static void tell_changed(const struct grid *g, struct keys *named)
{
    size_t n = 0;
    for (size_t i = 0; i < named->n; i++) {
        if (named->at[i] & VACANT) named->at[n++] = (uint32_t)named->at[i];
        else g->candidates.at[named->at[i]] ^= NEAR_PAIR;
    }
    named->n = n;
}

/* Touches the candidates. Those of boxes that left are dropped by msap_candidates_find, until which the worker
 * names their places. Returns 0 without memory. */
int msap_candidates_touch(struct grid *g, struct job *job)
{
    struct touching t = {g, g->untold};
    job->worker->pairs.n = 0;
    if (t.from > 0) msap_boxes_complete_before(job->boxes);
    if (!msap_phase_run(job->crew, job->memory, touch_untold, &t, t.from, 2 * WEIGHT_TOUCH) ||
        !msap_phase_run(job->crew, job->memory, touch, &t, g->candidates.n - t.from, WEIGHT_TOUCH))
        return 0;
    g->untold = 0;
    tell_changed(g, &job->worker->pairs);
    return 1;
}

/* ------------------------------------------------------------------- step 3 */

/* Boxes that ask. */
struct asking_boxes {
    const struct grid *grid;
    const uint32_t *slot;
};

/* Whether a box that asks and one that it has found are candidates, and it is up to it to say so. A static one
 * finds none that is static. */
static inline int is_candidate(const struct box *boxes, uint32_t slot, uint32_t other)
{
    const struct box *p = &boxes[slot], *q = &boxes[other];
    int is_asked_by_other = box_has_left(q) && other < slot;
    return other != slot && !is_asked_by_other && overlap(&p->fat, &q->fat);
}

/* Settles and keeps the candidates of a box among the first n that the worker has found. */
static void keep_candidates(const struct grid *g, struct worker *w, uint32_t slot, size_t n)
{
    const struct box *boxes = g->boxes->at;
    if (!msap_worker_has_room(w, n, 0)) return;
    msap_worker_new_token(w);
    for (size_t i = 0; i < n; i++) {
        uint32_t other = w->found[i];
        if (w->tag[other] == w->token) continue;
        w->tag[other] = w->token;
        if (!is_candidate(boxes, slot, other)) continue;
        int is = overlap(&boxes[slot].now, &boxes[other].now);
        w->settler.touched++;
        if (is && !were_pair(g->boxes, slot, other)) msap_settle_change(&w->settler, pair_key(slot, other), 1);
        w->pairs.at[w->pairs.n++] = pair_key(slot, other) | (is ? NEAR_PAIR : 0);
    }
}

/* Finds the candidates of boxes first ... last - 1. */
static void ask(void *context, struct worker *w, size_t first, size_t last)
{
    const struct asking_boxes *all = context;
    const struct grid *g = all->grid;
    for (size_t i = first; i < last; i++) {
        uint32_t slot = all->slot[i];
        const struct box *b = &g->boxes->at[slot];
        struct spot spot;
        spot_of(&g->layout[g->current], &b->fat, &spot);
        size_t n = msap_grid_find(g, w, slot, (b->flags & BOX_STATIC) != 0, &spot);
        if (n == SIZE_MAX) w->settler.lost = 1;
        else keep_candidates(g, w, slot, n);
    }
}

/* Puts what was found, keys vacant ... n - 1 of `pairs`, into the vacant places, which the keys before name
 * in ascending order, and behind the candidates. What is vacant then is closed from behind. Returns 0 without
 * memory. */
static int put_into_places(struct keys *candidates, struct memory *m, const struct keys *pairs, size_t vacant)
{
    size_t found = pairs->n - vacant, n = found < vacant ? found : vacant;
    if (candidates->n + found - n > UINT32_MAX) /* GCOVR_EXCL_BR_LINE: they could not be named; they take 32 GB */
        return 0;                               /* GCOVR_EXCL_LINE: the same */
    if (!msap_keys_reserve(candidates, m, candidates->n + found - n)) return 0;
    for (size_t i = 0; i < n; i++) candidates->at[pairs->at[i]] = pairs->at[vacant + i];
    for (size_t i = n; i < found; i++) candidates->at[candidates->n++] = pairs->at[vacant + i];
    for (size_t i = vacant; i > n; i--) candidates->at[pairs->at[i - 1]] = candidates->at[--candidates->n];
    return 1;
}

/* Finds the candidates of n boxes, which left their skins and have new ones, and settles them. Those that they
 * had, whose places the worker names, are dropped. Returns 0 without memory. */
int msap_candidates_find(struct grid *g, struct job *job, const uint32_t *slot, size_t n)
{
    struct keys *pairs = &job->worker->pairs;
    size_t vacant = pairs->n;
    struct asking_boxes all = {g, slot};
    return msap_phase_run(job->crew, job->memory, ask, &all, n, WEIGHT_QUERY) &&
           put_into_places(&g->candidates, job->memory, pairs, vacant);
}
