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
 * Steps 2 to 4 are taken for a few boxes at a time (move.c), whose cells are still in the cache
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
 * Boxes that rest (rest.c) are in no cell, but are found in step 3. One of them that changes
 * or is removed settles first what it was to the others, which no list tells; then it
 * is taken as one that is new. If they rest in skins (renew.c), only one that leaves its skin goes
 * elsewhere, and there are candidates instead of lists (candidates.c).
 *
 * Where there are many of them, steps 2 to 4 are shared by all workers (share.c), and step 5
 * is. Where too many boxes would have to be put elsewhere, one by one is not the way
 * (choose.c). */
#include "cells.h"

static int is_static(const struct box *b) { return (b->flags & BOX_STATIC) != 0; }

/* ---------------------------------------------------------- step 1 */

/* Marks the baggy ones of every step-th changed box; returns how many they are. */
static size_t mark_some_baggy(const struct grid *g, struct box_table *t, size_t first, size_t step)
{
    size_t n = 0;
    for (size_t i = first; i < t->n_changed; i += step) {
        const struct box *b = &t->at[t->changed[i]];
        if (!(b->flags & BOX_LIVE) || b->level == NO_LEVEL || !skin_is_baggy(g, t->changed[i])) continue;
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
static int is_misplaced(const struct grid *g, const struct box *b)
{
    return b->flags & BOX_LIVE || b->level != NO_LEVEL || rests(g, b);
}

/* Puts the misplaced ones of those that left first. Returns how many they are. */
static size_t misplaced_first(const struct grid *g, struct box_table *t)
{
    size_t n = 0;
    if (g->is_resting && !g->in_skins) msap_rest_mark(g, t);
    mark_baggy(g, t);
    for (size_t i = 0; i < t->n_left; i++) {
        uint32_t slot = t->left[i];
        prefetch(&g->near.of[slot]);
        if (!is_misplaced(g, &t->at[slot])) continue;
        t->left[i] = t->left[n];
        t->left[n++] = slot;
    }
    return n;
}

/* A box leaves the grid. Returns 0 without memory. */
static int leave(struct grid *g, const struct job *job, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    struct box *b = &job->boxes->at[slot];
    if (!rests(g, b)) {
        msap_grid_take(g, job->memory, slot, is_static(b), range_of(&g->layout[b->layout], &b->fat));
        box_forget_place(b);
    } else if (!g->in_skins && !msap_rest_part(g, job, slot)) {
        return 0;
    }
    for (uint32_t i = 0; i < l->n; i++) {
        settle(&job->worker->settler, slot, near_slot(l->at[i]));
        msap_near_remove(&g->near, near_slot(l->at[i]), slot);
    }
    msap_near_drop(&g->near, job->memory, slot);
    return 1;
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
    const struct worker *w = job->worker;
    for (uint32_t slot = 0; slot < job->boxes->used; slot++) {
        struct near_list *l = &g->near.of[slot];
        int is_gone = w->tag[slot] == w->token;
        for (uint32_t i = l->n; i-- > 0;) {
            uint32_t other = near_slot(l->at[i]);
            if (!is_gone && w->tag[other] != w->token) continue;
            job->worker->settler.touched += i < l->n_above;
            if (l->at[i] & NEAR_PAIR) msap_settle_change(&job->worker->settler, pair_key(slot, other), 0);
            if (!is_gone) msap_near_take_out(l, i);
        }
        if (is_gone) msap_near_drop(&g->near, job->memory, slot);
    }
}

/* A box that is in cells is to be taken out of them. */
static void forget_cells(struct grid *g, struct box *b)
{
    struct layout *l = &g->layout[b->layout];
    l->level[b->level].boxes--;
    l->boxes--;
    box_forget_place(b);
}

/* The first `gone` boxes that left, which were removed, leave the grid together: all lists
 * and cells are gone through once, in order, instead of being searched for each box. It
 * needs no memory but for boxes that rest. Returns 0 without it. */
static int leave_together(struct grid *g, const struct job *job, size_t gone)
{
    struct worker *w = job->worker;
    msap_worker_new_token(w);
    for (size_t i = 0; i < gone; i++) {
        uint32_t slot = job->boxes->left[i];
        w->tag[slot] = w->token;
        if (!rests(g, &job->boxes->at[slot])) forget_cells(g, &job->boxes->at[slot]);
        else if (!g->in_skins && !msap_rest_part(g, job, slot)) return 0;
    }
    leave_lists(g, job);
    for (int i = 0; i < 2; i++)
        for (size_t c = 0; c < g->layout[i].n_cells; c++)
            msap_cell_sift(&g->layout[i].cell[c], &g->pool, job->memory, w->tag, w->token);
    return 1;
}

/* The same one by one. */
static int leave_each(struct grid *g, const struct job *job, size_t gone, int by_cell)
{
    if (by_cell) msap_order_by_cell(g, job, job->boxes->left, gone);
    for (size_t i = 0; i < gone; i++)
        if (!leave(g, job, job->boxes->left[i])) return 0;
    return 1;
}

/* Whether so many of the boxes leave that to go through all lists and cells should cost
 * less than to search for each. */
static int is_exodus(const struct box_table *t, size_t gone)
{
    enum { FEW = 64, SHARE = 8 };
    return gone > FEW && gone > t->used / SHARE;
}

/* The first `gone` boxes that left, which were removed, leave the grid. Returns 0 without memory. */
static int leave_all(struct grid *g, const struct job *job, size_t gone, int by_cell)
{
    int done = is_exodus(job->boxes, gone) ? leave_together(g, job, gone) : leave_each(g, job, gone, by_cell);
    msap_near_tidy(&g->near, msap_is_near, g);
    return done;
}

/* ------------------------------------------------------------ steps 2 to 4 */

/* Boxes that workers have placed get their lists. Nothing is placed meanwhile, so a list that is noted
 * can wait until all others are as they should be. Returns 0 without memory. */
static int finish_placed(struct grid *g, const struct job *job, const uint32_t *slot, size_t n, uint8_t *state)
{
    for (size_t i = 0; i < n; i++)
        if (state[i] == MOVE_STUCK && !msap_finish_move(g, job, slot[i])) return 0;
    msap_near_tidy(&g->near, msap_is_near, g);
    return 1;
}

/* How many of n boxes are dealt with at once. */
static size_t few_of(size_t n) { return n < MOVES_AT_ONCE ? n : MOVES_AT_ONCE; }

/* n boxes are put elsewhere. Returns 0 without memory. */
static int move_all(struct grid *g, const struct job *job, const uint32_t *slot, size_t n, uint8_t *state)
{
    uint8_t waiting[MOVES_AT_ONCE];
    if (state && !finish_placed(g, job, slot, n, state)) return 0;
    for (size_t i = 0; i < n; i += MOVES_AT_ONCE) {
        uint8_t *now = state ? state + i : waiting;
        memset(waiting, MOVE_WAITS, sizeof waiting);
        if (!msap_move_few(g, job, NULL, slot + i, now, few_of(n - i))) return 0;
        msap_near_tidy(&g->near, msap_is_near, g);
    }
    return 1;
}

/* ---------------------------------------------------------------- the whole */

static int track(struct grid *g, struct job *job, size_t misplaced, int by_cell)
{
    if (!msap_layout_adapt(g, job->memory, job->boxes)) return 0;
    g->moves = misplaced;
    if (g->is_resting) msap_partners_note(g, job);
    size_t gone = removed_first(job->boxes, misplaced);
    if (!leave_all(g, job, gone, by_cell)) return 0;
    uint32_t *slot = job->boxes->left + gone;
    uint8_t *state = by_cell ? msap_share_moves(g, job, slot, misplaced - gone) : NULL;
    return move_all(g, job, slot, misplaced - gone, state) && msap_grid_touch(g, job);
}

/* The same while boxes rest in skins: there are candidates instead of lists. */
static int track_in_skins(struct grid *g, struct job *job, size_t misplaced, int by_cell)
{
    if (!msap_layout_adapt(g, job->memory, job->boxes) || !msap_candidates_touch(g, job)) return 0;
    g->moves = misplaced;
    size_t gone = removed_first(job->boxes, misplaced), n = misplaced - gone;
    uint32_t *slot = job->boxes->left + gone;
    leave_all(g, job, gone, by_cell); /* it takes memory only where boxes rest without skins */
    if (by_cell) msap_order_by_cell(g, job, slot, n);
    return msap_place_all(g, job, slot, n) && msap_candidates_find(g, job, slot, n);
}

/* Few boxes will be worked on from now on. */
static void give_back(struct grid *g, const struct job *job)
{
    g->candidates.n = 0;
    g->renewal.next = NO_RENEWAL;
    if (job->boxes->used <= VERY_MANY_BOXES) return;
    msap_keys_free(&g->candidates, job->memory);
    msap_renewal_free(&g->renewal, job->memory);
    msap_scratch_free(job->scratch, job->memory);
}

/* After a jump: boxes rest from now on, but for n. Returns 0 without memory. */
static int begin_resting(struct grid *g, struct job *job, size_t n)
{
    give_back(g, job);
    return msap_rest_begin(g, job, n) && move_all(g, job, g->wide, g->n_wide, NULL);
}

/* Boxes that rest in skins rest from now on as they are. Those that are in cells get lists. Returns 0 without
 * memory. */
static int rest_without_skins(struct grid *g, struct job *job)
{
    const struct box_table *t = job->boxes;
    size_t in_cells = g->layout[0].boxes + g->layout[1].boxes;
    give_back(g, job);
    g->in_skins = 0;
    g->untold = g->quiet = 0;
    g->gain = 0;
    for (uint32_t slot = 0; slot < t->used && in_cells > 0; slot++)
        if (t->at[slot].level != NO_LEVEL && !msap_finish_move(g, job, slot)) return 0;
    msap_near_tidy(&g->near, msap_is_near, g);
    return 1;
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
    if (way == PRUNE_RESTLESS || way == CALM_AND_PRUNE)
        return msap_grid_prune_restless(g, job, way == CALM_AND_PRUNE) ? MSAP_STRATEGY_SWEEP : 0;
    if (way == JUMP_INTO_SKINS) {
        int done = msap_grid_jump_into_skins(g, job);
        if (done != UNSUITED) return done ? MSAP_STRATEGY_SWEEP : 0;
        msap_renewal_failed(g);
        way = JUMP_OR_REBUILD;
    }
    if (way == JUMP_OR_TRACK || way == JUMP_OR_REBUILD) {
        int done = msap_grid_jump(g, job);
        if (done != UNSUITED) return done ? MSAP_STRATEGY_SWEEP : 0;
        if (g->is_resting) way = REBUILD; /* rows were counted anew */
    }
    if (way == REST) {
        if (!(g->in_skins ? rest_without_skins(g, job) : begin_resting(g, job, job->boxes->n_changed))) return 0;
        misplaced = misplaced_first(g, job->boxes);
    }
    if (way == REBUILD || way == JUMP_OR_REBUILD) return msap_grid_rebuild(g, job) ? MSAP_STRATEGY_SWEEP : 0;
    if (strategy == MSAP_STRATEGY_AUTO)
        strategy = misplaced > WORTH_ORDERING ? MSAP_STRATEGY_MERGE : MSAP_STRATEGY_SLIDE;
    int by_cell = strategy == MSAP_STRATEGY_MERGE;
    int done = g->in_skins ? track_in_skins(g, job, misplaced, by_cell) : track(g, job, misplaced, by_cell);
    return done ? strategy : 0;
}

/* Returns the strategy that was taken, or 0 without memory: then the grid is empty and must
 * be rebuilt. */
uint32_t msap_grid_update(struct grid *g, struct job *job, uint32_t strategy)
{
    uint32_t taken = update(g, job, strategy);
    if (!taken) msap_grid_empty(g, job->memory);
    return taken;
}

/* Puts boxes that rest and are not static on the list of those that left, which is empty. Returns how
 * many they are. */
static size_t list_not_static(const struct grid *g, struct box_table *t)
{
    size_t n = 0;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        t->left[n] = slot;
        n += rests(g, &t->at[slot]) && !is_static(&t->at[slot]);
    }
    return n;
}

/* After a commit that pruned all boxes, most of which are static: they rest from now on, and the others, which are
 * likely to move, are put into cells. Without memory that is left to later. */
static void rest_loaded(struct grid *g, struct job *job)
{
    struct box_table *t = job->boxes;
    if (!g->is_jumping) return;
    int done = begin_resting(g, job, t->live - t->live_static);
    size_t n = done ? list_not_static(g, t) : 0;
    if (n > 0) msap_order_by_cell(g, job, t->left, n);
    if (!done || !move_all(g, job, t->left, n, NULL)) msap_grid_empty(g, job->memory);
}

/* After a commit: does what makes those to come cheaper. */
void msap_grid_prepare(struct grid *g, struct job *job)
{
    if (g->will_rest) rest_loaded(g, job);
    if (g->renewal.next != NO_RENEWAL) msap_renewal_go_on(g, job);
    else if (g->is_tracking && msap_renewal_is_due(g, job)) msap_renewal_begin(g, job);
}
