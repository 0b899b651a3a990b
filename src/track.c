/* The Multi-SAP's commit: brings cells and neighbour lists up to date and touches
 * every pair whose overlap may have changed (paper, part II).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. Removed boxes leave their cells; their neighbours are touched.
 * 2. New boxes, and boxes that have left their skin, are put into the cells of their
 *    new fat bounds.
 * 3. They ask their cells what their neighbours are now.
 * 4. Their lists are changed accordingly; neighbours lost are touched.
 * 5. Every changed box touches all its neighbours (touch.c).
 *
 * Steps 2 to 4 are taken for a few boxes at a time, whose cells are still in the cache
 * when they are asked. It comes to the same as for all at once, since what two boxes are to
 * each other is decided anew by each that is moved, and so by the last one of them, when
 * both have their new fat bounds.
 *
 * A pair that overlaps now are neighbours after step 4, and are touched in step 5
 * if one of them changed. A pair that overlapped before were neighbours before, and
 * either still are or are touched when they part. So no pair is missed, wherever
 * the cells and however wide the skins are; a pair seen in several cells is one
 * pair, since a list holds it once (II.3b).
 *
 * Step 5 runs on all workers. Where too many boxes would have to be put
 * elsewhere, one by one is not the way (choose.c). */
#include "cells.h"

static int is_static(const struct box *b) { return (b->flags & BOX_STATIC) != 0; }

/* ---------------------------------------------------------- steps 1 and 2 */

/* Marks the baggy ones of every step-th changed box; returns how many they are. */
static size_t mark_some_baggy(const struct grid *g, struct box_table *t, size_t first, size_t step)
{
    size_t n = 0;
    for (size_t i = first; i < t->n_changed; i += step) {
        const struct box *b = &t->at[t->changed[i]];
        if (!(b->flags & BOX_LIVE) || b->level == NO_LEVEL || !skin_is_baggy(b, g)) continue;
        box_mark_left(t, t->changed[i]);
        n++;
    }
    return n;
}

/* Boxes that have shrunk in their skins are to get new ones too. Some of those that changed
 * are looked at, others in the next commit; if one has shrunk, all are. */
static void mark_baggy(const struct grid *g, struct box_table *t)
{
    enum { ONE_IN = 16 };
    if (mark_some_baggy(g, t, g->commit % ONE_IN, ONE_IN) > 0) mark_some_baggy(g, t, 0, 1);
}

/* Whether a box that left is to be put elsewhere: not one that came and went between two
 * commits. */
static int is_misplaced(const struct box *b) { return b->flags & BOX_LIVE || b->level != NO_LEVEL; }

/* Puts the misplaced ones of those that left first. Returns how many they are. */
static size_t misplaced_first(const struct grid *g, struct box_table *t)
{
    size_t n = 0;
    mark_baggy(g, t);
    for (size_t i = 0; i < t->n_left; i++) {
        uint32_t slot = t->left[i];
        prefetch(&g->near.of[slot]);
        if (!is_misplaced(&t->at[slot])) continue;
        t->left[i] = t->left[n];
        t->left[n++] = slot;
    }
    return n;
}

/* Orders the boxes first ... last - 1 of those that left by the cell that they were in or, of those that come,
 * are in now, so that what is near in space is near in time. Without memory they stay as
 * they are. */
static void order_by_cell(const struct grid *g, const struct job *job, size_t first, size_t last)
{
    uint32_t *left = job->boxes->left + first;
    size_t n = last - first;
    uint64_t *key = msap_scratch_get(job->scratch, job->memory, SCRATCH_WORDS(job->boxes->used));
    if (!key || n == 0) return;
    for (size_t i = 0; i < n; i++) {
        const struct layout *l = &g->layout[g->current];
        const struct box *b = &job->boxes->at[left[i]];
        struct range base = range_of(l, b->level == NO_LEVEL ? &b->now : &b->fat);
        key[i] = (uint64_t)(cell_at(&l->level[0], base.low) - l->cell) << 32 | left[i];
    }
    msap_sort_keys(key, n, key + n);
    for (size_t i = 0; i < n; i++) left[i] = (uint32_t)key[i];
}

/* A box leaves the grid. */
static void leave(struct grid *g, const struct job *job, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    struct box *b = &job->boxes->at[slot];
    msap_grid_take(g, job->memory, slot, is_static(b), range_of(&g->layout[b->layout], &b->fat));
    box_forget_place(b);
    for (uint32_t i = 0; i < l->n; i++) {
        settle(job->settler, slot, near_slot(l->at[i]));
        msap_near_remove(&g->near, near_slot(l->at[i]), slot);
    }
    msap_near_drop(&g->near, job->memory, slot);
}

/* How many neighbours of a box it does not overlap: those above as of the last commit. */
static uint32_t count_vain(const struct near_list *l, const struct box *boxes, uint32_t slot)
{
    uint32_t vain = 0;
    for (uint32_t i = 0; i < l->n_above; i++) vain += !(l->at[i] & NEAR_PAIR);
    for (uint32_t i = l->n_above; i < l->n; i++) vain += !overlap(&boxes[slot].now, &boxes[l->at[i]].now);
    return vain;
}

/* A box enters the grid, or gets a new skin and moves in it. Returns 0 without memory. */
static int relocate(struct grid *g, const struct job *job, uint32_t slot)
{
    struct box *b = &job->boxes->at[slot];
    if (b->level != NO_LEVEL) {
        struct range from = range_of(&g->layout[b->layout], &b->fat);
        msap_skin_renew(g, slot, count_vain(&g->near.of[slot], job->boxes->at, slot));
        return msap_grid_move(g, job->memory, slot, is_static(b), from);
    }
    msap_skin_first(g, slot);
    struct range base = range_of(&g->layout[g->current], &b->fat);
    b->layout = (uint8_t)g->current;
    b->level = (uint8_t)msap_level_for(base);
    return msap_grid_put(g, job->memory, slot, is_static(b), base);
}

/* Of the first n boxes that left, puts those that were removed first. Returns how many they
 * are. */
static size_t removed_first(const struct box_table *t, size_t n)
{
    size_t gone = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t slot = t->left[i];
        if (t->at[slot].flags & BOX_LIVE) continue;
        t->left[i] = t->left[gone];
        t->left[gone++] = slot;
    }
    return gone;
}

/* Settles the pairs of the tagged boxes, which are removed, and takes these out of all lists:
 * the entries tell what the pairs were, so no box need be looked at. */
static void leave_lists(struct grid *g, const struct job *job)
{
    for (uint32_t slot = 0; slot < job->boxes->used; slot++) {
        struct near_list *l = &g->near.of[slot];
        int is_gone = g->tag[slot] == g->token;
        for (uint32_t i = l->n; i-- > 0;) {
            uint32_t other = near_slot(l->at[i]);
            if (!is_gone && g->tag[other] != g->token) continue;
            job->settler->touched += i < l->n_above;
            if (l->at[i] & NEAR_PAIR) msap_settle_change(job->settler, pair_key(slot, other), 0);
            if (!is_gone) msap_near_take_out(l, i);
        }
        if (is_gone) msap_near_drop(&g->near, job->memory, slot);
    }
}

/* The first `gone` boxes that left, which were removed, leave the grid together: all lists
 * and cells are gone through once, in order, instead of being searched for each box. It
 * needs no memory. */
static void leave_together(struct grid *g, const struct job *job, size_t gone)
{
    msap_grid_new_token(g);
    for (size_t i = 0; i < gone; i++) {
        struct box *b = &job->boxes->at[job->boxes->left[i]];
        struct layout *l = &g->layout[b->layout];
        g->tag[job->boxes->left[i]] = g->token;
        l->level[b->level].boxes--;
        l->boxes--;
        box_forget_place(b);
    }
    leave_lists(g, job);
    for (int i = 0; i < 2; i++)
        for (size_t c = 0; c < g->layout[i].n_cells; c++)
            msap_cell_sift(&g->layout[i].cell[c], &g->pool, job->memory, g->tag, g->token);
}

/* The same one by one. */
static void leave_each(struct grid *g, const struct job *job, size_t gone, int by_cell)
{
    if (by_cell) order_by_cell(g, job, 0, gone);
    for (size_t i = 0; i < gone; i++) leave(g, job, job->boxes->left[i]);
}

/* Whether so many of the boxes leave that to go through all lists and cells should cost
 * less than to search for each. */
static int is_exodus(const struct box_table *t, size_t gone)
{
    enum { FEW = 64, SHARE = 8 };
    return gone > FEW && gone > t->used / SHARE;
}

/* Of the first n boxes that left, those that were removed leave the grid, and are put first.
 * Returns how many they are. */
static size_t leave_first(struct grid *g, const struct job *job, size_t n, int by_cell)
{
    size_t gone = removed_first(job->boxes, n);
    if (is_exodus(job->boxes, gone)) leave_together(g, job, gone);
    else leave_each(g, job, gone, by_cell);
    if (by_cell) order_by_cell(g, job, gone, n);
    return gone;
}

/* ---------------------------------------------------------- steps 3 and 4 */

/* Drops from the list of a box what is not tagged, and tags the rest as known. */
static void part_from_old(struct grid *g, const struct job *job, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    for (uint32_t i = 0; i < l->n;) {
        uint32_t other = near_slot(l->at[i]);
        if (g->tag[other] == g->token) {
            g->tag[other] = g->token + 1;
            i++;
            continue;
        }
        settle(job->settler, slot, other);
        msap_near_remove(&g->near, other, slot);
        msap_near_take_out(l, i);
    }
}

static int join(struct grid *g, const struct job *job, uint32_t a, uint32_t b)
{
    return msap_near_join(&g->near, job->memory, a, b, were_pair(job->boxes, a, b));
}

/* Makes the list of a box what was found for it: the keys from *at on that name it, which
 * *at is left behind. */
static int renew_list(struct grid *g, const struct job *job, uint32_t slot, const struct keys *found, size_t *at)
{
    size_t first = *at, last = first;
    msap_grid_new_token(g);
    for (; last < found->n && found->at[last] >> 32 == slot; last++) g->tag[(uint32_t)found->at[last]] = g->token;
    g->tag[slot] = g->token + 1; /* it finds itself */
    part_from_old(g, job, slot);
    for (size_t i = first; i < last; i++) {
        uint32_t other = (uint32_t)found->at[i];
        if (g->tag[other] != g->token) continue;
        g->tag[other] = g->token + 1;
        if (!join(g, job, slot, other)) return 0;
    }
    *at = last;
    return 1;
}

/* Whether two boxes are neighbours by their fat bounds. */
static int is_near(const void *context, uint32_t a, uint32_t b)
{
    const struct grid *g = context;
    const struct box *p = &g->boxes->at[a], *q = &g->boxes->at[b];
    return q->level != NO_LEVEL && overlap(&p->fat, &q->fat);
}

/* Steps 2 to 4 for n slots. */
static int relocate_few(struct grid *g, struct job *job, const uint32_t *slot, size_t n)
{
    struct worker *own = &job->crew->worker[0];
    const struct keys *found = &own->pairs;
    own->pairs.n = 0;
    for (size_t i = 0; i < n; i++)
        if (!relocate(g, job, slot[i])) return 0;
    for (size_t i = 0; i < n; i++)
        msap_grid_query(g, own, slot[i], is_static(&job->boxes->at[slot[i]]), 0, LEVELS);
    if (own->settler.lost) return 0;
    for (size_t i = 0, at = 0; i < n; i++)
        if (!renew_list(g, job, slot[i], found, &at)) return 0;
    msap_near_tidy(&g->near, is_near, g);
    return 1;
}

/* ---------------------------------------------------------------- the whole */

static int track(struct grid *g, struct job *job, size_t misplaced, int by_cell)
{
    enum { FEW = 32 }; /* boxes whose cells are still in the cache when they are asked */
    const uint32_t *left = job->boxes->left;
    if (!msap_layout_adapt(g, job->memory, job->boxes)) return 0;
    g->moves = misplaced;
    size_t gone = leave_first(g, job, misplaced, by_cell);
    msap_near_tidy(&g->near, is_near, g);
    for (size_t i = gone, n; i < misplaced; i += n) {
        n = misplaced - i < FEW ? misplaced - i : FEW;
        if (!relocate_few(g, job, left + i, n)) return 0;
    }
    return msap_grid_touch(g, job);
}

/* Which way is taken by a strategy, if the first `misplaced` of those that left must be put
 * elsewhere. */
static enum way way_by(uint32_t strategy, struct grid *g, const struct job *job, size_t misplaced)
{
    if (strategy == MSAP_STRATEGY_AUTO) return msap_choose(g, job, misplaced);
    return strategy == MSAP_STRATEGY_SWEEP || !g->is_tracking ? REBUILD : TRACK;
}

static uint32_t update(struct grid *g, struct job *job, uint32_t strategy)
{
    enum { WORTH_ORDERING = 512 };
    size_t misplaced = g->is_tracking ? misplaced_first(g, job->boxes) : 0;
    enum way way = way_by(strategy, g, job, misplaced);
    g->commit++;
    if (way == JUMP_OR_TRACK || way == JUMP_OR_REBUILD) {
        int done = msap_grid_jump(g, job);
        if (done != UNSUITED) return done ? MSAP_STRATEGY_SWEEP : 0;
    }
    if (way == REBUILD || way == JUMP_OR_REBUILD) return msap_grid_rebuild(g, job) ? MSAP_STRATEGY_SWEEP : 0;
    if (strategy == MSAP_STRATEGY_AUTO)
        strategy = misplaced > WORTH_ORDERING ? MSAP_STRATEGY_MERGE : MSAP_STRATEGY_SLIDE;
    return track(g, job, misplaced, strategy == MSAP_STRATEGY_MERGE) ? strategy : 0;
}

/* Returns the strategy that was taken, or 0 without memory: then the grid is empty and must
 * be rebuilt. */
uint32_t msap_grid_update(struct grid *g, struct job *job, uint32_t strategy)
{
    uint32_t taken = update(g, job, strategy);
    if (!taken) msap_grid_empty(g, job->memory);
    return taken;
}
