/* Rebuilding a grid: all boxes into cells at once, all neighbours from sweeps of
 * whole cells. What the paper's batch insertion and complete box pruning (I.4) are
 * to a single SAP, this is to a grid of them.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. Each box gets its fat bounds, its level and the range of its cells; the boxes
 *    of each cell are counted.
 * 2. The cells get memory of the right size and are filled.
 * 3. Each cell is swept. Two boxes that meet in several cells of their level are
 *    taken in one: the one that holds the higher of their two low corners, which
 *    lies in both ranges and is visited once.
 * 4. Boxes of different levels are found by asking: for each box the coarser levels or,
 *    where few boxes are on coarse levels, for each of those the finer ones.
 *
 * A pair that is found becomes two entries of neighbour lists. Skins are fitted, cells
 * swept and coarser levels asked by all workers (II.3d). */
#include "cells.h"

struct rebuild {
    struct grid *grid;
    struct layout *layout; /* the current one */
    struct job *job;
    struct range *range; /* [slots] of each live box, on its level */
};

static int is_live(const struct rebuild *r, size_t slot)
{
    return (r->job->boxes->at[slot].flags & BOX_LIVE) != 0;
}
static uint32_t is_static(const struct rebuild *r, size_t slot)
{
    return (r->job->boxes->at[slot].flags & BOX_STATIC) != 0;
}

/* ---------------------------------------------------------- steps 1 and 2 */

/* Fits the skins of the boxes in slots first ... last - 1 and finds their cells. */
static void fit(void *context, struct worker *w, size_t first, size_t last)
{
    struct rebuild *r = context;
    struct grid *g = r->grid;
    (void)w;
    for (size_t slot = first; slot < last; slot++) {
        struct place *p = &g->place[slot];
        const struct box *b = &r->job->boxes->at[slot];
        if (!is_live(r, slot)) continue;
        if (p->horizon == NO_HORIZON) msap_skin_first(p, b, g, (uint32_t)slot);
        else if (!contains(&p->fat, &b->now) || skin_is_baggy(p, b, g))
            msap_skin_renew(p, b, g, (uint32_t)slot, 0);
        struct range base = range_of(r->layout, &p->fat);
        p->layout = (uint8_t)g->current;
        p->level = (uint8_t)msap_level_for(base);
        r->range[slot] = range_on(r->layout, base, p->level);
    }
}

/* Counts the boxes of each cell. */
static void count(struct rebuild *r)
{
    struct grid *g = r->grid;
    for (size_t slot = 0; slot < r->job->boxes->used; slot++) {
        if (!is_live(r, slot)) continue;
        struct level *l = &r->layout->level[g->place[slot].level];
        struct cell_walk w = cell_walk(l, r->range[slot]);
        l->boxes++;
        r->layout->boxes++;
        for (struct cell *c; (c = cell_next(&w)) != NULL;) {
            c->n++;
            c->n_moving += !is_static(r, slot);
        }
    }
}

/* Turns the counts into cells with room: n_moving is where the next box that moves
 * is put, n where the next static one. Returns 0 without memory. */
static int make_cells(struct layout *l, struct pool *p, struct memory *m)
{
    for (size_t i = 0; i < l->n_cells; i++) {
        struct cell *c = &l->cell[i];
        if (c->n > 0 && !msap_cell_make_room(c, p, m, c->n)) return 0;
        c->n = c->n_moving;
        c->n_moving = 0;
    }
    return 1;
}

static void fill_cells(struct rebuild *r)
{
    for (uint32_t slot = 0; slot < r->job->boxes->used; slot++) {
        const struct place *p = &r->grid->place[slot];
        if (!is_live(r, slot)) continue;
        struct cell_walk w = cell_walk(&r->layout->level[p->level], r->range[slot]);
        for (struct cell *c; (c = cell_next(&w)) != NULL;)
            msap_cell_put_row(c, is_static(r, slot) ? c->n++ : c->n_moving++, &p->fat, slot);
    }
}

/* ---------------------------------------------------------- steps 3 and 4 */

/* Whether cell `at` of a level is the one in which two of its boxes are taken. */
static int is_meeting_cell(const struct rebuild *r, const struct level *l, const uint32_t at[3], uint32_t a,
                           uint32_t b)
{
    const int32_t *p = r->range[a].low, *q = r->range[b].low;
    for (int k = 0; k < 3; k++)
        if (wrap(p[k] > q[k] ? p[k] : q[k], l->count[k]) != at[k]) return 0;
    return 1;
}

static void sweep_cell(const struct rebuild *r, struct worker *w, const struct level *l, const struct cell *c)
{
    size_t i = (size_t)(c - l->cell), row_length = l->count[0], rows = l->count[1];
    const uint32_t at[3] = {(uint32_t)(i % row_length), (uint32_t)(i / row_length % rows),
                            (uint32_t)(i / row_length / rows)};
    for (uint32_t row = 0; row < c->n_moving; row++) {
        struct bounds b;
        uint32_t slot = msap_cell_row(c, row, &b);
        size_t n = r->grid->sweep(c, row + 1, c->n, &b, w->found);
        for (size_t i = 0; i < n; i++)
            if (is_meeting_cell(r, l, at, slot, w->found[i]))
                msap_worker_put(w, (uint64_t)slot << 32 | w->found[i]);
    }
}

/* Sweeps cells first ... last - 1 of all levels. */
static void sweep_cells(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    const struct layout *l = r->layout;
    uint32_t level = 0;
    for (size_t i = first; i < last; i++) {
        while (level < TOP && &l->cell[i] >= l->level[level + 1].cell) level++;
        if (l->cell[i].n > 1) sweep_cell(r, w, &l->level[level], &l->cell[i]);
    }
}

/* Asks the coarser levels for the boxes in slots first ... last - 1. */
static void ask_coarser(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    const struct grid *g = r->grid;
    for (size_t slot = first; slot < last; slot++)
        if (is_live(r, slot))
            msap_grid_query(g, w, (uint32_t)slot, (int)is_static(r, slot), g->place[slot].level + 1u, LEVELS);
}

/* Asks the finer levels for the boxes in slots first ... last - 1. */
static void ask_finer(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    const struct grid *g = r->grid;
    for (size_t slot = first; slot < last; slot++)
        if (is_live(r, slot) && g->place[slot].level > 0)
            msap_grid_query(g, w, (uint32_t)slot, (int)is_static(r, slot), 0, g->place[slot].level);
}

static int ask(struct rebuild *r)
{
    enum { FEW = 64 }; /* cells that a coarse box would have to visit, more or less */
    size_t coarse = r->layout->boxes - r->layout->level[0].boxes;
    phase_fn run = coarse < r->layout->boxes / FEW ? ask_finer : ask_coarser;
    return coarse == 0 || msap_phase_run(r->job->crew, r->job->memory, run, r, r->job->boxes->used, WEIGHT_LEVELS);
}

/* Makes the pairs that were found neighbours, each once: repeats come together. */
static int make_lists(struct grid *g, struct job *job)
{
    const struct keys *found = &job->crew->worker[0].pairs;
    const struct box *boxes = job->boxes->at;
    for (size_t i = 0; i < found->n; i++) {
        uint32_t a = (uint32_t)(found->at[i] >> 32), b = (uint32_t)found->at[i];
        if (i == 0 || a != found->at[i - 1] >> 32) msap_grid_new_token(g);
        if (g->tag[b] == g->token) continue;
        g->tag[b] = g->token;
        if (!msap_near_join(&g->near, job->memory, a, b, were_pair(&boxes[a], &boxes[b]))) return 0;
    }
    return 1;
}

static int find_pairs(struct rebuild *r)
{
    struct grid *g = r->grid;
    struct crew *crew = r->job->crew;
    struct memory *m = r->job->memory;
    size_t n = r->layout->n_cells, weight = r->layout->boxes * WEIGHT_CELL_BOX / (n + 1) + 1;
    crew->worker[0].pairs.n = 0;
    if (!msap_phase_run(crew, m, sweep_cells, r, n, weight)) return 0;
    return ask(r) && make_lists(g, r->job);
}

/* ---------------------------------------------------------------- the whole */

/* Boxes that are not in the grid have no past in it. */
static void forget_absent(struct grid *g, size_t slots)
{
    for (size_t slot = 0; slot < slots; slot++)
        if (g->place[slot].level == NO_LEVEL) g->place[slot].horizon = NO_HORIZON;
}

/* Whether the layout should be chosen again, since it costs little now. */
static int is_stale(const struct layout *l, uint32_t commit, size_t boxes)
{
    enum { COMMITS = 4 };
    return msap_is_outgrown(l->chosen_for, boxes) || commit - l->chosen_at > COMMITS;
}

/* Returns 0 without memory. */
int msap_grid_rebuild(struct grid *g, struct job *job)
{
    struct box_table *t = job->boxes;
    struct layout *l = &g->layout[g->current];
    struct rebuild r = {g, l, job, NULL};
    forget_absent(g, t->used);
    msap_grid_empty(g, job->memory);
    g->moves = t->live;
    msap_layout_free(&g->layout[1 - g->current], job->memory);
    if (is_stale(l, g->commit, t->live) && !msap_layout_choose(g, job->memory, t)) return 0;
    r.range = msap_scratch_get(job->scratch, job->memory, SCRATCH_WORDS(t->used));
    if (!r.range || !msap_phase_run(job->crew, job->memory, fit, &r, t->used, WEIGHT_SKIN)) return 0;
    count(&r);
    if (!make_cells(l, &g->pool, job->memory)) return 0;
    fill_cells(&r);
    g->is_tracking = find_pairs(&r) && msap_touch_known_pairs(job);
    return g->is_tracking;
}
