/* Pruning a few: the commit of a scene in which few boxes jump among many that stay.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * After a jump (jump.c) the rows hold all boxes but the wide ones. Where few of them move then, but so wildly that
 * it would not pay to track them, the others need not be pruned again. Boxes that change are restless
 * from then on, and wide ones are, until all are pruned once more: when those of them that stand still
 * by now have cost as much as that.
 *
 * 1. Restless boxes are sorted along the sweep axis, nearly as they were in the last commit, and make up a row of
 *    their own, which is swept: a batch insertion (paper I.4b) that is undone before the next one.
 * 2. Each asks the rows for the others. What these hold of restless boxes is passed over.
 * 3. The known pairs are touched. */
#include "rows.h"

/* Boxes that are not restless: the rows hold them as they are. */
static inline int is_calm(const struct box *b) { return (b->flags & (BOX_LIVE | BOX_RESTLESS)) == BOX_LIVE; }

/* ------------------------------------------------------------------- step 1 */

/* A live box is restless from now on. Returns 0 without memory. */
static int disturb(struct grid *g, struct memory *m, uint32_t slot)
{
    struct keys *order = &g->restless.order;
    struct box *b = &g->boxes->at[slot];
    if (!is_calm(b)) return 1;
    if (!msap_keys_reserve(order, m, order->n + 1)) return 0;
    b->flags |= BOX_RESTLESS;
    order->at[order->n++] = slot;
    return 1;
}

/* The first ones: those that are in no row. Returns 0 without memory. */
static int begin(struct grid *g, struct memory *m)
{
    for (size_t i = 0; i < g->n_wide; i++)
        if (!disturb(g, m, g->wide[i])) return 0;
    return msap_rows_note_reach(&g->row_set, &g->rows, m);
}

/* Drops those that were removed, and whose slot another box may have got. */
static void drop_removed(struct grid *g)
{
    struct keys *order = &g->restless.order;
    size_t n = 0;
    for (size_t i = 0; i < order->n; i++) {
        const struct box *b = &g->boxes->at[key_box(order->at[i])];
        order->at[n] = order->at[i];
        n += (b->flags & (BOX_LIVE | BOX_RESTLESS)) == (BOX_LIVE | BOX_RESTLESS);
    }
    order->n = n;
}

/* Counts how many join them, unless it is the first time. Returns 0 without memory. */
static int gather(struct grid *g, const struct job *job)
{
    const struct box_table *t = job->boxes;
    struct restless *r = &g->restless;
    drop_removed(g);
    size_t n = r->order.n;
    if (n == 0 && !begin(g, job->memory)) return 0;
    for (size_t i = 0; i < t->n_changed; i++)
        if (!disturb(g, job->memory, t->changed[i])) return 0;
    if (n > 0) r->newcomers = r->order.n - n;
    if (r->order.n > t->n_changed) r->idle += r->order.n - t->n_changed;
    return 1;
}

/* Sorts them by where they are now. */
static void sort(struct grid *g, const struct job *job)
{
    struct keys *order = &g->restless.order;
    for (size_t i = 0; i < order->n; i++) {
        uint32_t slot = key_box(order->at[i]);
        order->at[i] = key_make(job->boxes->at[slot].now.min[g->rows.axis[0]], 0, slot);
    }
    msap_sort_nearly_sorted(order->at, order->n, msap_scratch_get(job->scratch, job->memory, order->n));
}

/* And writes them into their row, with all marks: two static ones are told apart when they are settled. Returns 0
 * without memory. */
static int make_row(struct grid *g, struct job *job)
{
    struct restless *r = &g->restless;
    struct pruning p = {.job = job, .rows = &g->rows, .set = &r->row, .bounds = bounds_now(job->boxes)};
    p.entries = r->order.n;
    if (!msap_row_set_make(&r->row, job->memory, r->order.n)) return 0;
    for (size_t i = 0; i < r->order.n; i++) r->row.id[i] = key_box(r->order.at[i]) | ROW_MARKS;
    msap_rows_fill(&p);
    return 1;
}

/* Sweeps from entries first ... last - 1. */
static void sweep(void *context, struct worker *w, size_t first, size_t last)
{
    const struct grid *g = context;
    struct pair_buffer found;
    struct row_sweep at = {(uint32_t)first, (uint32_t)first + 1, (uint32_t)last, (uint32_t)g->restless.order.n};
    while (at.i < at.last) {
        g->sweeps.row(&g->restless.row, &at, &found);
        for (size_t i = 0; i < found.n; i++) settle(&w->settler, found.a[i], found.b[i]);
    }
}

/* ------------------------------------------------------------------- step 2 */

/* Settles a box with the calm ones among the first n that the worker has found. */
static void settle_calm(const struct grid *g, struct worker *w, uint32_t slot, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (is_calm(&g->boxes->at[w->found[i]])) settle(&w->settler, slot, w->found[i]);
}

/* Asks for the boxes first ... last - 1. */
static void ask(void *context, struct worker *w, size_t first, size_t last)
{
    const struct grid *g = context;
    for (size_t i = first; i < last; i++) {
        uint32_t slot = key_box(g->restless.order.at[i]);
        const struct readable now = {g->boxes->at[slot].now, 0};
        size_t n = msap_rest_ask(g, w, &now.bounds, (g->boxes->at[slot].flags & BOX_STATIC) != 0, 0);
        if (n == SIZE_MAX) w->settler.lost = 1;
        else settle_calm(g, w, slot, n);
    }
}

/* ---------------------------------------------------------------- the whole */

/* While the rows hold all boxes that are not restless: finds the events. Returns 0 without memory. */
int msap_grid_prune_restless(struct grid *g, struct job *job)
{
    if (!gather(g, job)) return 0;
    size_t n = g->restless.order.n;
    sort(g, job);
    g->moves = n;
    if (!make_row(g, job) || !msap_phase_run(job->crew, job->memory, sweep, g, n, WEIGHT_ROW_BOX) ||
        !msap_phase_run(job->crew, job->memory, ask, g, n, WEIGHT_QUERY))
        return 0;
    msap_touch_known_pairs(job);
    return 1;
}

/* The rows hold all boxes again, or none. */
void msap_restless_forget(struct grid *g)
{
    struct keys *order = &g->restless.order;
    for (size_t i = 0; i < order->n; i++)
        if (key_box(order->at[i]) < g->boxes->used)
            g->boxes->at[key_box(order->at[i])].flags &= ~(uint32_t)BOX_RESTLESS;
    order->n = 0;
    g->restless.idle = 0;
}

void msap_restless_free(struct grid *g, struct memory *m)
{
    msap_restless_forget(g);
    msap_keys_free(&g->restless.order, m);
    msap_row_set_free(&g->restless.row, m);
}

/* ------------------------------------------------------------------ checking */

/* The first broken invariant, or NULL. */
const char *msap_restless_broken(const struct grid *g)
{
    const struct keys *order = &g->restless.order;
    size_t marked = 0, listed = 0;
    if (order->n > 0 && !g->is_jumping) return "boxes are restless while others are tracked";
    for (uint32_t slot = 0; slot < g->boxes->used; slot++)
        marked += (g->boxes->at[slot].flags & (BOX_WAS | BOX_RESTLESS)) == (BOX_WAS | BOX_RESTLESS);
    for (size_t i = 0; i < order->n; i++) {
        const struct box *b = &g->boxes->at[key_box(order->at[i])];
        if (i > 0 && order->at[i] <= order->at[i - 1]) return "the restless boxes are not in order";
        listed += (b->flags & (BOX_WAS | BOX_RESTLESS)) == (BOX_WAS | BOX_RESTLESS);
    }
    return listed == marked ? NULL : "a restless box is not listed";
}
