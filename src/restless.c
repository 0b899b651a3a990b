/* Pruning a few: the commit of a scene in which few boxes jump among many that stay.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * After a jump (jump.c) the rows hold all boxes but the wide ones. Where few of them move then, but so wildly that
 * it would not pay to track them, the others need not be pruned again. Boxes that change are restless
 * from then on, and wide ones are, until all are pruned once more, or until they are calmed: when those that stand
 * still by now have cost as much as that (calm.c).
 *
 * 1. Restless boxes are sorted into rows of their own, but for wide ones: the same rows as those of the others.
 * 2. These rows are swept: a batch insertion (paper I.4b) that is undone before the next one; and from each box in
 *    them the others in the same row (paper I.4c, bipartite). What rows hold of restless boxes is passed over.
 * 3. Wide ones are tested against each other and these rows (wide.c), and ask those of the others.
 * 4. The known pairs are touched. */
#include "rows.h"

/* One call at work. */
struct restless_pruning {
    struct grid *grid;
    struct pruning pruning;
};

/* ------------------------------------------------------------------- step 1 */

/* A live box is restless from now on; there is room for it. */
static void disturb(struct grid *g, uint32_t slot)
{
    struct restless *r = &g->restless;
    struct box *b = &g->boxes->at[slot];
    if (!is_calm(b)) return;
    b->flags |= BOX_RESTLESS;
    r->slot[r->n++] = slot;
}

/* Before the first ones: wide boxes, which are in no row, are among them, and the bounds before of all that have not
 * changed become what they are now. Returns 0 without memory. */
static int begin(struct grid *g, struct memory *m)
{
    for (size_t i = 0; i < g->n_wide; i++) disturb(g, g->wide[i]);
    msap_boxes_complete_before(g->boxes);
    return msap_rows_note_reach(&g->row_set, &g->rows, m);
}

/* Drops those that were removed, and whose slot another box may have got; the bounds before of those that stand still
 * become what they are now. */
static void go_through(struct grid *g)
{
    enum { AHEAD = 12 };
    struct restless *r = &g->restless;
    struct box_table *t = g->boxes;
    size_t n = 0;
    for (size_t i = 0; i < r->n; i++) {
        uint32_t slot = r->slot[i];
        if (r->n - i > AHEAD) prefetch(&t->at[r->slot[i + AHEAD]]);
        if (!box_is_changed(t, slot)) t->past[slot].before = t->at[slot].now;
        r->slot[n] = slot;
        n += (t->at[slot].flags & (BOX_LIVE | BOX_RESTLESS)) == (BOX_LIVE | BOX_RESTLESS);
    }
    r->n = n;
}

/* Counts how many join them and how many stand still. Returns 0 without memory. */
static int gather(struct grid *g, const struct job *job)
{
    const struct box_table *t = job->boxes;
    struct restless *r = &g->restless;
    go_through(g);
    size_t n = r->n, most = n + t->n_changed + (n == 0 ? g->n_wide : 0);
    if (!msap_memory_reserve(job->memory, &r->slot, &r->room, most, n, sizeof *r->slot)) return 0;
    size_t joined_first = msap_count_newcomers(g);
    if (n == 0 && !begin(g, job->memory)) return 0;
    for (size_t i = 0; i < t->n_changed; i++) disturb(g, t->changed[i]);
    r->newcomers = n > 0 ? r->n - n : joined_first;
    if (r->n > t->n_changed + r->wide) r->idle += r->n - t->n_changed - r->wide;
    return 1;
}

/* Sorts n of them into rows of their own. Returns 0 without memory. */
int msap_restless_list(struct grid *g, struct job *job, struct pruning *p, const uint32_t *slot, size_t n)
{
    const struct pruning few = {.job = job,
                                .rows = &g->rows,
                                .set = &g->restless.set,
                                .slots = job->boxes->used,
                                .bounds = bounds_now(job->boxes)};
    *p = few;
    if (!msap_rows_count_few(p, slot, n, job->scratch) || !msap_rows_sort(p)) return 0;
    msap_rows_list(p);
    msap_rows_fill(p);
    return 1;
}

/* --------------------------------------------------------------- steps 2, 3 */

static void take(const void *context, struct worker *w, const struct pair_buffer *found)
{
    (void)context;
    msap_settle_found(&w->settler, found);
}

/* Settles those of the pairs from the i-th on that are new, a bit each, unless the second one is restless: then the
 * rows hold it as it was. */
static inline void settle_calm(struct settler *s, const struct pair_buffer *found, size_t i, uint32_t fresh)
{
    for (; fresh > 0; i++, fresh >>= 1)
        if ((fresh & 1) && is_calm(&s->boxes->at[found->b[i]]))
            msap_settle_change(s, pair_key(found->a[i], found->b[i]), 1);
}

static void take_calm(const void *context, struct worker *w, const struct pair_buffer *found)
{
    const struct past *past = w->settler.boxes->past;
    size_t i = 0;
    (void)context;
    w->settler.touched += found->n;
    for (; found->n - i >= 4; i += 4)
        settle_calm(&w->settler, found, i, known_among(past, found->a + i, found->b + i) ^ 15);
    for (; i < found->n; i++)
        settle_calm(&w->settler, found, i, !overlap(&past[found->a[i]].before, &past[found->b[i]].before));
}

/* Sweeps from entries first ... last - 1. */
static void sweep(void *context, struct worker *w, size_t first, size_t last)
{
    const struct restless_pruning *all = context;
    const struct grid *g = all->grid;
    msap_rows_sweep(&g->restless.set, &g->rows, g->sweeps.row, first, last, take, NULL, w);
    msap_rows_sweep_between(&g->restless.set, &g->row_set, &g->rows, g->sweeps.between, first, last, take_calm,
                            NULL, w);
}

/* Tests wide boxes first ... last - 1 against those before and all that are in rows. */
static void test_wide(void *context, struct worker *w, size_t first, size_t last)
{
    const struct restless_pruning *all = context;
    const struct grid *g = all->grid;
    msap_wide_test(&all->pruning, &g->sweeps, first, last, take, NULL, w);
    for (size_t i = first; i < last; i++) {
        uint32_t slot = all->pruning.wide[i];
        const struct readable now = {g->boxes->at[slot].now, 0};
        size_t n = msap_rest_ask(g, w, &now.bounds, (g->boxes->at[slot].flags & BOX_STATIC) != 0, 0);
        if (n == SIZE_MAX) w->settler.lost = 1;
        for (size_t k = 0; k < n && n != SIZE_MAX; k++)
            if (is_calm(&g->boxes->at[w->found[k]])) settle(&w->settler, slot, w->found[k]);
    }
}

/* ---------------------------------------------------------------- the whole */

/* While the rows hold all boxes that are not restless: finds the events; if it calms, those that stand still are
 * restless no more. Returns 0 without memory. */
int msap_grid_prune_restless(struct grid *g, struct job *job, int calms)
{
    struct restless_pruning all = {.grid = g};
    struct restless *r = &g->restless;
    struct pruning *p = &all.pruning;
    if (!gather(g, job) || (calms && !msap_calm(g, job))) return 0;
    g->moves = r->n;
    if (!msap_restless_list(g, job, p, r->slot, r->n) ||
        !msap_phase_run(job->crew, job->memory, sweep, &all, p->entries, 2 * WEIGHT_ROW_BOX) ||
        !msap_phase_run(job->crew, job->memory, test_wide, &all, p->n_wide, job->boxes->live * WEIGHT_TOUCH))
        return 0;
    r->wide = p->n_wide;
    msap_touch_known_pairs(job);
    return 1;
}

/* The rows hold all boxes again, or none. */
void msap_restless_forget(struct grid *g)
{
    struct restless *r = &g->restless;
    for (size_t i = 0; i < r->n; i++)
        if (r->slot[i] < g->boxes->used) g->boxes->at[r->slot[i]].flags &= ~(uint32_t)BOX_RESTLESS;
    r->n = r->idle = r->wide = 0;
}

void msap_restless_free(struct grid *g, struct memory *m)
{
    struct restless *r = &g->restless;
    msap_restless_forget(g);
    msap_memory_free(m, r->slot, r->room, sizeof *r->slot);
    r->slot = NULL;
    r->room = 0;
    msap_row_set_free(&r->set, m);
}

/* ------------------------------------------------------------------ checking */

/* Whether the bounds before of a calm box that has not changed are not what it is now. */
static int is_before_broken(const struct box_table *t, uint32_t slot)
{
    return is_calm(&t->at[slot]) && !box_is_changed(t, slot) &&
           memcmp(&t->past[slot].before, &t->at[slot].now, sizeof(struct bounds)) != 0;
}

/* The first broken invariant, or NULL. */
const char *msap_restless_broken(const struct grid *g)
{
    const struct restless *r = &g->restless;
    const struct box_table *t = g->boxes;
    size_t marked = 0, listed = 0;
    for (size_t i = 0; i < g->watch.n; i++)
        if (g->watch.slot[i] >= t->used) return "a watched box is in no slot of the table";
    if (r->n > 0 && !g->is_jumping) return "boxes are restless while others are tracked";
    if (r->n > 0 && g->renewal.next != NO_RENEWAL) return "boxes are restless during a renewal";
    for (uint32_t slot = 0; slot < t->used; slot++) {
        if (r->n > 0 && is_before_broken(t, slot)) return "a calm box was elsewhere before";
        marked += (t->at[slot].flags & (BOX_WAS | BOX_RESTLESS)) == (BOX_WAS | BOX_RESTLESS);
    }
    for (size_t i = 0; i < r->n; i++)
        listed += (t->at[r->slot[i]].flags & (BOX_WAS | BOX_RESTLESS)) == (BOX_WAS | BOX_RESTLESS);
    if (listed != marked) return "a restless box is not listed";
    return r->n > 0 ? msap_rest_broken(g) : NULL;
}
