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
 * 4. Boxes of different levels are found by asking for each box the coarser levels.
 *
 * A pair that is found becomes two entries of neighbour lists. While boxes jump so
 * much that every commit rebuilds, no list would ever be used: then there are none,
 * and pairs that are found are touched at once. */
#include "internal.h"

struct rebuild {
    struct grid *grid;
    const struct job *job;
    struct range *range; /* [slots] of each live box, on its level */
};

/* ---------------------------------------------------------- steps 1 and 2 */

static void fit_skin(struct place *p, const struct box *b, uint32_t slot, uint32_t commit)
{
    if (p->horizon == NO_HORIZON) skin_first(p, b, commit);
    else if (!contains(&p->fat, &b->now)) skin_renew(p, b, slot, commit, 0);
}

static void count_cells(struct rebuild *r)
{
    struct grid *g = r->grid;
    const struct box_table *t = r->job->boxes;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        struct place *p = &g->place[slot];
        if (!(t->at[slot].flags & BOX_LIVE)) continue;
        fit_skin(p, &t->at[slot], slot, g->commit);
        struct range base = grid_range(g, &p->fat);
        p->level = (uint8_t)grid_level_for(base);
        r->range[slot] = grid_range_on(g, base, p->level);
        g->level[p->level].boxes++;
        struct cell_walk w = cell_walk(&g->level[p->level], r->range[slot]);
        for (struct cell *c; (c = cell_next(&w)) != NULL;) {
            c->n++;
            c->n_moving += !(t->at[slot].flags & BOX_STATIC);
        }
    }
}

/* Turns the counts into empty cells with room. */
static int make_cells(struct grid *g, struct memory *m)
{
    for (size_t i = 0; i < g->n_cells; i++) {
        struct cell *c = &g->cell[i];
        if (c->n > 0 && !cell_make_room(c, &g->pool, m, c->n)) return 0;
        c->n = c->n_moving; /* statics are filled in from here on */
        c->n_moving = 0;
    }
    return 1;
}

static void fill_cells(struct rebuild *r)
{
    const struct box_table *t = r->job->boxes;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        const struct place *p = &r->grid->place[slot];
        if (!(t->at[slot].flags & BOX_LIVE)) continue;
        struct cell_walk w = cell_walk(&r->grid->level[p->level], r->range[slot]);
        for (struct cell *c; (c = cell_next(&w)) != NULL;)
            cell_put_row(c, t->at[slot].flags & BOX_STATIC ? c->n++ : c->n_moving++, &p->fat, slot);
    }
}

/* ---------------------------------------------------------- steps 3 and 4 */

/* Returns 0 without memory. */
static int found_pair(struct rebuild *r, uint32_t a, uint32_t b)
{
    struct grid *g = r->grid;
    if (g->has_lists) return near_add(&g->near, r->job->memory, a, b) && near_add(&g->near, r->job->memory, b, a);
    settle(r->job->settler, a, b);
    return 1;
}

/* Whether a cell is the one in which two boxes of its level are taken. */
static int is_meeting_cell(const struct rebuild *r, const struct level *l, const struct cell *c, uint32_t a,
                           uint32_t b)
{
    const int32_t *p = r->range[a].low, *q = r->range[b].low;
    int32_t corner[3];
    for (int k = 0; k < 3; k++) corner[k] = p[k] > q[k] ? p[k] : q[k];
    return cell_at(l, corner) == c;
}

static int sweep_cell(struct rebuild *r, const struct level *l, const struct cell *c)
{
    struct grid *g = r->grid;
    for (uint32_t row = 0; row < c->n_moving; row++) {
        struct bounds b;
        uint32_t slot = cell_row(c, row, &b);
        size_t n = g->sweep(c, row + 1, c->n, &b, g->found);
        for (size_t i = 0; i < n; i++)
            if (is_meeting_cell(r, l, c, slot, g->found[i]) && !found_pair(r, slot, g->found[i])) return 0;
    }
    return 1;
}

static int sweep_cells(struct rebuild *r)
{
    for (uint32_t level = 0; level < LEVELS; level++) {
        const struct level *l = &r->grid->level[level];
        size_t cells = (size_t)l->count[0] * l->count[1] * l->count[2];
        for (size_t i = 0; i < cells && l->boxes > 0; i++)
            if (l->cell[i].n > 1 && !sweep_cell(r, l, &l->cell[i])) return 0;
    }
    return 1;
}

/* The coarsest level that holds boxes. */
static uint32_t last_level(const struct grid *g)
{
    uint32_t level = TOP;
    while (level > 0 && g->level[level].boxes == 0) level--;
    return level;
}

static int ask_coarser(struct rebuild *r)
{
    struct grid *g = r->grid;
    const struct box_table *t = r->job->boxes;
    uint32_t last = last_level(g);
    for (uint32_t slot = 0; slot < t->used; slot++) {
        if (!(t->at[slot].flags & BOX_LIVE) || g->place[slot].level >= last) continue;
        grid_new_token(g);
        size_t n = grid_query(g, slot, (t->at[slot].flags & BOX_STATIC) != 0, grid_range(g, &g->place[slot].fat),
                              g->place[slot].level + 1u);
        for (size_t i = 0; i < n; i++)
            if (!found_pair(r, slot, g->found[i])) return 0;
    }
    return 1;
}

/* ---------------------------------------------------------------- the whole */

/* Boxes that are not in the grid have no past in it. */
static void forget_absent(struct grid *g, size_t slots)
{
    for (size_t slot = 0; slot < slots; slot++)
        if (g->place[slot].level == NO_LEVEL) g->place[slot].horizon = NO_HORIZON;
}

/* The layout is good for a while, and for as many boxes as it was made for. */
static int layout_is_old(const struct grid *g, size_t boxes)
{
    enum { COMMITS = 64 };
    return g->laid_out_for == 0 || boxes > g->laid_out_for * 2 || boxes * 2 < g->laid_out_for ||
           g->commit - g->laid_out_at > COMMITS;
}

/* Returns 0 without memory. */
int grid_rebuild(struct grid *g, const struct job *job, int with_lists)
{
    struct rebuild r = {g, job, NULL};
    forget_absent(g, job->boxes->used);
    grid_empty(g, job->memory);
    g->has_lists = with_lists;
    if (layout_is_old(g, job->boxes->live) && !grid_layout(g, job->memory, job->boxes)) return 0;
    r.range = scratch_get(job->scratch, job->memory, job->boxes->used * sizeof *r.range / sizeof(uint64_t) + 1);
    if (!r.range) return 0;
    count_cells(&r);
    if (!make_cells(g, job->memory)) return 0;
    fill_cells(&r);
    if (!sweep_cells(&r) || !ask_coarser(&r)) return 0;
    touch_known_pairs(job);
    return 1;
}
