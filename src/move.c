/* Moving: boxes get new skins, new cells and new neighbours.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * These are steps 2 to 4 of track.c, for a few boxes. They are taken by the calling thread,
 * which may change everything, or by one of several workers, each in a region of its own
 * (share.c). What a worker may not do it leaves: a box as it was, or, if it is in its new cells,
 * its list as far as it has come. Every change to lists is made on both sides and settled, so
 * they are in order in between, and when the calling thread goes on it comes to the same. */
#include "cells.h"

static int is_static(const struct box *b) { return (b->flags & BOX_STATIC) != 0; }

/* -------------------------------------------------- what a worker may change */

/* Whether cells lie in a region, so many layers or more from its ends. */
static int is_within(const struct region *own, const struct layout *l, const struct range *base, uint32_t inside)
{
    uint32_t count = l->level[0].count[own->axis], first = wrap(base->low[own->axis], count);
    uint32_t more = (uint32_t)base->high[own->axis] - (uint32_t)base->low[own->axis];
    uint32_t from_first = first >= own->first ? first - own->first : first + count - own->first;
    return own->layers > inside && from_first >= inside && from_first < own->layers - inside &&
           more < own->layers - inside - from_first;
}

enum { INSIDE = 1 /* layer: then nearly all neighbours lie in the region, too */ };

/* Whether a box, which was in cells `from`, may be put elsewhere: none of them belongs to
 * another worker, and no memory is taken or given back. */
static int may_place(const struct grid *g, const struct region *own, struct range from, const struct spot *spot)
{
    const struct layout *l = &g->layout[g->current];
    struct cell_walk left = cell_walk(&l->level[0], from), entered = cell_walk(&l->level[0], spot->base);
    if (is_same_range(&from, &spot->base)) return 1;
    if (!is_within(own, l, &spot->base, INSIDE) || spot->level != 0) return 0;
    for (const struct cell *c; (c = cell_next(&left)) != NULL;)
        if (c->n == 1) return 0;
    for (const struct cell *c; (c = cell_next(&entered)) != NULL;)
        if (c->n == c->room) return 0;
    return 1;
}

/* Whether a box lies in a region. */
static int is_own(const struct grid *g, const struct region *own, const struct box *b)
{
    const struct layout *l = &g->layout[g->current];
    struct range base = range_of(l, &b->fat);
    return is_within(own, l, &base, 0);
}

/* Whether the lists of a box and another one, its neighbour, may be changed. Long ones may have to be
 * noted, or take more room than a worker has. */
static int may_change(const struct grid *g, const struct region *own, uint32_t slot, uint32_t other)
{
    return is_own(g, own, &g->boxes->at[other]) && g->near.of[slot].n <= NEAR_LONG &&
           g->near.of[other].n <= NEAR_LONG;
}

/* ------------------------------------------------------------ skins and cells */

/* How many neighbours of a box it does not overlap: those above as of the last commit. */
static uint32_t count_vain(const struct near_list *l, const struct box *boxes, uint32_t slot)
{
    uint32_t vain = 0;
    for (uint32_t i = 0; i < l->n_above; i++) vain += !(l->at[i] & NEAR_PAIR);
    for (uint32_t i = l->n_above; i < l->n; i++) vain += !overlap(&boxes[slot].now, &boxes[l->at[i]].now);
    return vain;
}

static void renew_skin(const struct grid *g, uint32_t slot)
{
    msap_skin_renew(g, slot, count_vain(&g->near.of[slot], g->boxes->at, slot));
}

/* A box enters the grid with the fat bounds that it has; *spot becomes where it is then. Returns 0 without
 * memory. */
static int enter(struct grid *g, const struct job *job, uint32_t slot, struct spot *spot)
{
    struct box *b = &job->boxes->at[slot];
    spot_of(&g->layout[g->current], &b->fat, spot);
    b->layout = g->current & 1;
    b->level = (uint8_t)spot->level;
    return msap_grid_put(g, job->memory, slot, is_static(b), spot);
}

/* n boxes do, and get no lists. Returns 0 without memory. */
int msap_enter_all(struct grid *g, const struct job *job, const uint32_t *slot, size_t n)
{
    struct spot spot;
    for (size_t i = 0; i < n; i++)
        if (!enter(g, job, slot[i], &spot)) return 0;
    return 1;
}

/* A box enters the grid, or gets a new skin and moves in it; *spot becomes where it is then. Returns 0
 * without memory. */
static int place(struct grid *g, const struct job *job, uint32_t slot, struct spot *spot)
{
    struct box *b = &job->boxes->at[slot];
    if (b->level != NO_LEVEL) {
        struct range from = range_of(&g->layout[b->layout], &b->fat);
        renew_skin(g, slot);
        spot_of(&g->layout[g->current], &b->fat, spot);
        return msap_grid_move(g, job->memory, slot, is_static(b), from, spot);
    }
    if (rests(g, b) && !g->in_skins && !msap_rest_part(g, job, slot)) return 0;
    if (rests(g, b) && g->in_skins && b->flags & BOX_FITTED) renew_skin(g, slot);
    else msap_skin_first(g, slot);
    return enter(g, job, slot, spot);
}

/* n boxes are put elsewhere that get no lists. Returns 0 without memory. */
int msap_place_all(struct grid *g, const struct job *job, const uint32_t *slot, size_t n)
{
    struct spot spot;
    for (size_t i = 0; i < n; i++)
        if (!place(g, job, slot[i], &spot)) return 0;
    return 1;
}

/* The same by a worker, while all boxes that are in cells are in the current layout. Returns 0, with nothing done,
 * if it may not. */
static int place_own(struct grid *g, const struct region *own, uint32_t slot, struct spot *spot)
{
    struct box *b = &g->boxes->at[slot], before = *b;
    const struct past past = g->boxes->past[slot];
    const struct layout *l = &g->layout[g->current];
    if (b->level != 0) return 0;
    struct range from = range_of(l, &b->fat);
    if (!is_within(own, l, &from, INSIDE)) return 0;
    renew_skin(g, slot);
    spot_of(l, &b->fat, spot);
    if (may_place(g, own, from, spot)) return msap_grid_move(g, NULL, slot, is_static(b), from, spot);
    b->fat = before.fat;
    b->horizon = before.horizon;
    b->wobble = before.wobble;
    g->boxes->past[slot] = past;
    return 0;
}

/* ---------------------------------------------------------------------- lists */

/* A pair that parts. If the two overlap, one of them is yet to move, and they will be neighbours again. */
static void settle_parted(struct settler *s, uint32_t a, uint32_t b)
{
    const struct box *box = s->boxes->at;
    s->touched++;
    if (were_pair(s->boxes, a, b) && !overlap(&box[a].now, &box[b].now)) msap_settle_change(s, pair_key(a, b), 0);
}

/* Drops from the list of a box what is not tagged, and tags the rest as known. Returns 0 if a
 * worker may not. */
static int part_from_old(struct grid *g, const struct job *job, const struct region *own, uint32_t slot)
{
    struct near_list *l = &g->near.of[slot];
    struct worker *w = job->worker;
    for (uint32_t i = 0; i < l->n;) {
        uint32_t other = near_slot(l->at[i]);
        if (w->tag[other] == w->token) {
            w->tag[other] = w->token + 1;
            i++;
            continue;
        }
        if (own && !(may_change(g, own, slot, other) && w->settler.doomed.n < w->settler.doomed.room)) return 0;
        settle_parted(&w->settler, slot, other);
        msap_near_remove(&g->near, other, slot);
        msap_near_take_out(l, i);
    }
    return 1;
}

/* Makes two boxes neighbours. Returns 0 without memory, and if a worker may not. */
static int join(struct grid *g, const struct job *job, const struct region *own, uint32_t slot, uint32_t other)
{
    struct pool *room = own ? &job->worker->stock : &g->near.pool;
    if (own && !may_change(g, own, slot, other)) return 0;
    return msap_near_join(&g->near, room, job->memory, slot, other, were_pair(job->boxes, slot, other));
}

/* Tags those of n boxes found that are near. */
static void tag_near(struct worker *w, const struct near_list *of, const struct box *box, uint32_t slot, size_t n)
{
    msap_worker_new_token(w);
    const struct box self = box[slot];
    const uint32_t *found = w->found, token = w->token;
    uint32_t *tag = w->tag;
    for (size_t i = 0; i < n; i++) {
        tag[found[i]] = overlap(&self.fat, &box[found[i]].fat) ? token : tag[found[i]];
        prefetch(&of[found[i]]);
    }
    tag[slot] = token + 1; /* it finds itself */
}

/* Gives a box that is placed the list of its neighbours. Returns 0 without memory, and if a worker
 * may not. */
static int renew_list(struct grid *g, const struct job *job, const struct region *own, uint32_t slot,
                      const struct spot *spot)
{
    struct worker *w = job->worker;
    size_t n = msap_grid_find(g, w, slot, is_static(&job->boxes->at[slot]), spot);
    if (n == SIZE_MAX) return 0;
    tag_near(w, g->near.of, job->boxes->at, slot, n);
    if (!part_from_old(g, job, own, slot)) return 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t other = w->found[i];
        if (w->tag[other] != w->token) continue;
        w->tag[other] = w->token + 1;
        if (!join(g, job, own, slot, other)) return 0;
    }
    return 1;
}

/* Whether two boxes that were neighbours still are. */
int msap_is_near(const void *grid, uint32_t a, uint32_t b)
{
    const struct grid *g = grid;
    const struct box *q = &g->boxes->at[b];
    int is_in = q->level != NO_LEVEL || (rests(g, q) && q->flags & BOX_LIVE);
    return is_in && overlap(bounds_in_grid(g, a), bounds_in_grid(g, b));
}

/* ------------------------------------------------------------------ the whole */

/* Fetches n boxes with their lists, which no other worker may be changing, and their neighbours. */
static void fetch(const struct grid *g, const uint32_t *slot, size_t n)
{
    const struct box_table *t = g->boxes;
    const struct near_list *of = g->near.of;
    for (size_t i = 0; i < n; i++) {
        prefetch(&t->at[slot[i]]);
        prefetch(&t->past[slot[i]]);
        prefetch(&of[slot[i]]);
    }
    for (size_t i = 0; i < n; i++) prefetch(of[slot[i]].at);
    for (size_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < of[slot[i]].n; k++) prefetch(&t->at[near_slot(of[slot[i]].at[k])]);
}

/* Where there are many boxes, fetches the lists of the neighbours of n of them. */
static void fetch_lists(const struct grid *g, const uint32_t *slot, size_t n)
{
    const struct near_list *of = g->near.of;
    if (g->boxes->used <= MANY_BOXES) return;
    for (size_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < of[slot[i]].n; k++) prefetch(&of[near_slot(of[slot[i]].at[k])]);
    for (size_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < of[slot[i]].n; k++) prefetch(of[near_slot(of[slot[i]].at[k])].at);
}

/* Where there are many boxes, fetches the cells that n of them are in, and then what these hold. */
static void fetch_cells(const struct grid *g, const uint32_t *slot, size_t n)
{
    uint32_t cell[MOVES_AT_ONCE][MOST_CELLS], cells[MOVES_AT_ONCE];
    if (g->boxes->used <= MANY_BOXES) return;
    for (size_t i = 0; i < n; i++) {
        const struct box *b = &g->boxes->at[slot[i]];
        cells[i] = 0;
        if (b->level == NO_LEVEL) continue;
        const struct layout *l = &g->layout[b->layout];
        struct range base = range_of(l, &b->fat);
        struct span span = span_on(l, &base, b->level);
        cells[i] = cells_of(l, &span, cell[i]);
        for (uint32_t k = 0; k < cells[i]; k++) prefetch(&l->cell[cell[i][k]]);
    }
    for (size_t i = 0; i < n; i++)
        for (uint32_t k = 0; k < cells[i]; k++) {
            const struct cell *c = &g->layout[g->boxes->at[slot[i]].layout].cell[cell[i][k]];
            prefetch(c->block->low);
            prefetch(c->block->id);
        }
}

/* Moves those of n boxes that wait. Returns 0 without memory; a worker moves those that it may, and
 * returns 1. */
int msap_move_few(struct grid *g, const struct job *job, const struct region *own, const uint32_t *slot,
                  uint8_t *state, size_t n)
{
    struct spot spot[MOVES_AT_ONCE];
    if (!own) fetch(g, slot, n);
    if (!own) fetch_lists(g, slot, n);
    if (!own) fetch_cells(g, slot, n);
    for (size_t i = 0; i < n; i++) {
        if (state[i] != MOVE_WAITS) continue;
        if (own ? place_own(g, own, slot[i], &spot[i]) : place(g, job, slot[i], &spot[i])) state[i] = MOVE_PLACED;
        else if (!own) return 0;
    }
    for (size_t i = 0; i < n; i++) {
        if (state[i] != MOVE_PLACED) continue;
        state[i] = renew_list(g, job, own, slot[i], &spot[i]) ? MOVE_DONE : MOVE_STUCK;
        if (!own && state[i] == MOVE_STUCK) return 0;
    }
    return 1;
}

/* Gives a box that a worker has placed its list. Returns 0 without memory. */
int msap_finish_move(struct grid *g, const struct job *job, uint32_t slot)
{
    struct spot spot;
    spot_of(&g->layout[g->current], &job->boxes->at[slot].fat, &spot);
    return renew_list(g, job, NULL, slot, &spot);
}
