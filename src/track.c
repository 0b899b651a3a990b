/* The Multi-SAP's commit: brings cells and neighbour lists up to date and touches
 * every pair whose overlap may have changed (paper, part II).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. Removed boxes leave their cells; their neighbours are touched.
 * 2. New boxes, and boxes that have left their skin, are put into the cells of their
 *    new fat bounds and get a new neighbour list; neighbours lost are touched.
 * 3. Every changed box touches all its neighbours.
 *
 * A pair that overlaps now are neighbours after step 2, and are touched in step 3
 * if one of them changed. A pair that overlapped before were neighbours before, and
 * either still are or are touched when they part. So no pair is missed, wherever
 * the cells and however wide the skins are; a pair seen in several cells is one
 * pair, since a list holds it once (II.3b).
 *
 * If most boxes would have to be put elsewhere, all cells and lists are made anew
 * instead, with a layout that suits the boxes of now; known pairs are touched then,
 * since the old lists are gone. */
#include "internal.h"


static int is_static(const struct box *b) { return (b->flags & BOX_STATIC) != 0; }

/* ----------------------------------------------------------- box after box */

/* A box leaves the grid. */
static void leave(struct grid *g, const struct job *job, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    grid_take(g, job->memory, slot, is_static(&job->boxes->at[slot]), grid_range(g, &g->place[slot].fat));
    for (uint32_t i = 0; i < l->n; i++) {
        settle(job->settler, slot, l->at[i]);
        near_remove(&g->near, l->at[i], slot);
    }
    near_drop(&g->near, job->memory, slot);
}

/* Drops from the list of a box what its last query did not find. */
static void part_from_old(struct grid *g, const struct job *job, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    for (uint32_t i = 0; i < l->n;) {
        uint32_t other = l->at[i];
        if (g->tag[other] == g->token) {
            g->tag[other] = g->token + 1; /* found, and known */
            i++;
            continue;
        }
        settle(job->settler, slot, other);
        near_remove(&g->near, other, slot);
        near_take_out(l, i);
    }
}

/* Makes the list of a box what its fat bounds say. Returns 0 without memory. */
static int renew_list(struct grid *g, const struct job *job, uint32_t slot, struct range base)
{
    grid_new_token(g);
    size_t n = grid_query(g, slot, is_static(&job->boxes->at[slot]), base, 0);
    part_from_old(g, job, slot);
    for (size_t i = 0; i < n; i++) {
        uint32_t other = g->found[i];
        if (g->tag[other] != g->token) continue;
        if (!near_add(&g->near, job->memory, slot, other)) return 0;
        if (!near_add(&g->near, job->memory, other, slot)) return 0;
    }
    return 1;
}

static uint32_t count_vain(const struct grid *g, const struct box *boxes, uint32_t slot)
{
    const struct near_list *l = &g->near.of[slot];
    uint32_t vain = 0;
    for (uint32_t i = 0; i < l->n; i++) vain += !overlap(&boxes[slot].now, &boxes[l->at[i]].now);
    return vain;
}

/* A box enters the grid, or moves in it because it has left its skin. */
static int relocate(struct grid *g, const struct job *job, uint32_t slot)
{
    struct place *p = &g->place[slot];
    const struct box *b = &job->boxes->at[slot];
    struct range base, old = grid_range(g, &p->fat);
    int done;
    if (p->level == NO_LEVEL) {
        skin_first(p, b, g->commit);
        base = grid_range(g, &p->fat);
        p->level = (uint8_t)grid_level_for(base);
        done = grid_put(g, job->memory, slot, is_static(b), base);
    } else {
        skin_renew(p, b, slot, g->commit, count_vain(g, job->boxes->at, slot));
        base = grid_range(g, &p->fat);
        done = grid_move(g, job->memory, slot, is_static(b), old, base);
    }
    return done && renew_list(g, job, slot, base);
}

static int is_misplaced(const struct grid *g, const struct box_table *t, uint32_t slot)
{
    const struct place *p = &g->place[slot];
    if (!(t->at[slot].flags & BOX_LIVE)) return p->level != NO_LEVEL;
    return p->level == NO_LEVEL || !contains(&p->fat, &t->at[slot].now);
}

/* Puts the misplaced ones of the changed boxes first. Returns how many they are. */
static size_t misplaced_first(const struct grid *g, const struct box_table *t)
{
    size_t n = 0;
    for (size_t i = 0; i < t->n_changed; i++) {
        uint32_t slot = t->changed[i];
        if (!is_misplaced(g, t, slot)) continue;
        t->changed[i] = t->changed[n];
        t->changed[n++] = slot;
    }
    return n;
}

/* Steps 1 and 2, for the first n changed boxes. */
static int place_misplaced(struct grid *g, const struct job *job, size_t n)
{
    const struct box_table *t = job->boxes;
    for (size_t i = 0; i < n; i++)
        if (!(t->at[t->changed[i]].flags & BOX_LIVE)) leave(g, job, t->changed[i]);
    for (size_t i = 0; i < n; i++)
        if ((t->at[t->changed[i]].flags & BOX_LIVE) && !relocate(g, job, t->changed[i])) return 0;
    return 1;
}

/* --------------------------------------------------------------- step 3 */

/* Every pair once, from the lower box. */
static void touch_all(const struct grid *g, const struct job *job)
{
    const struct box *boxes = job->boxes->at;
    for (uint32_t slot = 0; slot < job->boxes->used; slot++) {
        const struct near_list *l = &g->near.of[slot];
        for (uint32_t i = 0; i < l->n_above; i++)
            if ((boxes[slot].flags | boxes[l->at[i]].flags) & BOX_CHANGED) settle(job->settler, slot, l->at[i]);
    }
}

/* Every pair of a changed box; of two changed boxes from the lower one. */
static void touch_changed(const struct grid *g, const struct job *job)
{
    const struct box_table *t = job->boxes;
    for (size_t c = 0; c < t->n_changed; c++) {
        uint32_t slot = t->changed[c];
        const struct near_list *l = &g->near.of[slot];
        for (uint32_t i = 0; i < l->n; i++)
            if (i < l->n_above || !(t->at[l->at[i]].flags & BOX_CHANGED)) settle(job->settler, slot, l->at[i]);
    }
}

/* ---------------------------------------------------------------- choosing */

/* Whether so many boxes must be put elsewhere that to rebuild is cheaper. */
static int is_upheaval(const struct grid *g, const struct box_table *t, size_t misplaced, uint32_t strategy)
{
    if (g->laid_out_for == 0 || strategy == MSAP_STRATEGY_SWEEP) return 1;
    return strategy == MSAP_STRATEGY_AUTO && misplaced > 64 && misplaced * 2 > t->live;
}

/* Returns the strategy that was taken, or 0 without memory: then the grid must be
 * rebuilt. */
uint32_t grid_update(struct grid *g, const struct job *job, uint32_t strategy)
{
    size_t misplaced = misplaced_first(g, job->boxes);
    int upheaval = is_upheaval(g, job->boxes, misplaced, strategy), again = g->upheaval;
    g->commit++;
    g->upheaval = upheaval;
    if (upheaval || !g->has_lists) {
        if (!grid_rebuild(g, job, !(upheaval && again))) return 0;
    } else if (!place_misplaced(g, job, misplaced))
        return 0;
    if (!g->has_lists) return MSAP_STRATEGY_SWEEP;
    if (job->boxes->n_changed * 2 > job->boxes->live) touch_all(g, job);
    else touch_changed(g, job);
    return upheaval ? MSAP_STRATEGY_SWEEP : MSAP_STRATEGY_SLIDE;
}
