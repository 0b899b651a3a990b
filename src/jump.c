/* Pruning everything: the commit of a scene in which most boxes jump.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * When most boxes leave their places in every commit, nothing that could be kept
 * between commits would be worth keeping. So no cells and lists are: all boxes are pruned
 * completely (paper I.4c). Then either the pairs found and those known from before are
 * settled, or, where many pairs are others than before, both are compared (compare.c).
 *
 * In the same way boxes are pruned with skins that they just got (renew.c): then what is found are
 * candidates, which are kept, and those of them that are pairs are settled.
 *
 * Where only few boxes jump, mostly the same ones each time, they alone are pruned then (restless.c).
 *
 * 1. The boxes are sorted into rows (rows.c); or, where most are in the same ones as at the last pruning, these
 *    are brought up to date (kept.c).
 * 2. Each row is swept: from each box over those behind it until one starts after its
 *    end, up to sixteen at a time. Two boxes that meet in several rows are taken where, on both
 *    axes across, one of them starts: that is one row.
 * 3. Wide boxes, which touch many rows, are in none; each is tested against all (wide.c). Where there
 *    are many such boxes this is not the way, and the grid must be rebuilt. */
#include "rows.h"

/* One call at work. */
struct jump {
    struct grid *grid;
    struct job *job;
    struct pruning pruning;
    int is_comparing; /* the pairs found are kept instead of settled */
    int has_skins;    /* the rows hold skins, and what is found are candidates, which are kept */
};

static void keep_taken(struct worker *w, const struct pair_buffer *taken)
{
    if (taken->n == 0 || !msap_worker_has_room(w, taken->n, 0)) return;
    uint64_t *out = w->pairs.at + w->pairs.n;
    for (size_t i = 0; i < taken->n; i++) out[i] = pair_key(taken->a[i], taken->b[i]);
    w->pairs.n += taken->n;
}

static inline gaps gaps_in(const struct box *box, const struct pair_buffer *taken, size_t i)
{
    return gaps_of(&box[taken->a[i]].now, &box[taken->b[i]].now);
}

/* Settles those of the four candidates from the i-th on that are pairs, a bit each, and were none. Where there
 * was no pair all of them are new. */
static inline void settle_among(struct settler *s, const struct pair_buffer *taken, size_t i, uint32_t are,
                                int had_pairs)
{
    if (had_pairs) are &= ~known_among(s->boxes->past, taken->a + i, taken->b + i);
    for (; are > 0; i++, are >>= 1)
        if (are & 1) msap_settle_change(s, pair_key(taken->a[i], taken->b[i]), 1);
}

/* Keeps candidates, by fours, and settles those that are pairs. */
static void keep_candidates(struct worker *w, const struct pair_buffer *taken, int had_pairs)
{
    const struct box *box = w->settler.boxes->at;
    size_t i = 0;
    if (taken->n == 0 || !msap_worker_has_room(w, taken->n, 0)) return;
    uint64_t *out = w->pairs.at + w->pairs.n;
    for (; taken->n - i >= 4; i += 4) {
        uint32_t are = overlaps_of(gaps_in(box, taken, i), gaps_in(box, taken, i + 1), gaps_in(box, taken, i + 2),
                                   gaps_in(box, taken, i + 3));
        marked_pairs_of_four(out + i, taken->a + i, taken->b + i, are);
        if (are) settle_among(&w->settler, taken, i, are, had_pairs);
    }
    for (; i < taken->n; i++) {
        uint32_t a = taken->a[i], b = taken->b[i], is = (uint32_t)overlap(&box[a].now, &box[b].now);
        out[i] = (uint64_t)a << 32 | b | is << 31;
        if (is) settle_found(&w->settler, a, b);
    }
    w->settler.touched += taken->n;
    w->pairs.n += taken->n;
}

static void take(const void *context, struct worker *w, const struct pair_buffer *found)
{
    const struct jump *j = context;
    if (j->has_skins) keep_candidates(w, found, j->job->pairs->active > 0);
    else if (j->is_comparing) keep_taken(w, found);
    else msap_settle_found(&w->settler, found);
}

/* Sweeps from entries first ... last - 1. */
static void sweep_rows(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    msap_rows_sweep(j->pruning.set, j->pruning.rows, j->grid->sweeps.row, first, last, take, j, w);
}

/* Tests wide boxes first ... last - 1 (wide.c). */
static void test_wide(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    msap_wide_test(&j->pruning, &j->grid->sweeps, first, last, take, j, w);
}

/* ---------------------------------------------------------------- the whole */

/* Steps 2 and 3. Two static boxes are no pair: where there are no others, there is nothing to find. Returns 0
 * without memory. */
static int find_pairs(struct jump *j)
{
    struct job *job = j->job;
    const struct pruning *p = &j->pruning;
    job->worker->pairs.n = 0;
    if (job->boxes->live == job->boxes->live_static) return 1;
    return msap_phase_run(job->crew, job->memory, sweep_rows, j, p->entries, WEIGHT_ROW_BOX) &&
           msap_phase_run(job->crew, job->memory, test_wide, j, p->n_wide, job->boxes->live * WEIGHT_TOUCH);
}

/* Whether boxes were only removed: then no pair is new, and the rows hold all others. */
static int are_only_removed(const struct box_table *t)
{
    size_t n = 0;
    while (n < t->n_changed && !(t->at[t->changed[n]].flags & BOX_LIVE)) n++;
    return n == t->n_changed;
}

/* Counts the boxes of all rows, of which the set holds nothing any more. Returns 0 without memory, and
 * UNSUITED where there are many wide boxes. */
static int count_all(struct grid *g, struct job *job, struct pruning *p)
{
    enum { COMMITS = 16 };
    const struct pruning all = {.job = job,
                                .rows = &g->rows,
                                .set = &g->row_set,
                                .last = &g->row_set,
                                .slots = job->boxes->used,
                                .bounds = bounds_now(job->boxes)};
    if (job->boxes->used > ROW_MOVES) /* GCOVR_EXCL_BR_LINE: 2^29 boxes, and a slot has no bits to spare */
        return UNSUITED;              /* GCOVR_EXCL_LINE: the same */
    *p = all;
    msap_restless_forget(g);
    forget_rows_of_skins(g);
    msap_rows_choose(p, g->commit, COMMITS);
    if (!msap_rows_count(p, job->scratch)) return 0;
    msap_wide_note(g, p);
    if (p->n_wide > MOST_WIDE) return UNSUITED;
    g->n_wide = p->n_wide;
    memcpy(g->wide, p->wide, p->n_wide * sizeof *g->wide);
    return 1;
}

/* Finds the pairs that overlap, and the events. Returns 0 without memory, and UNSUITED where there are many wide
 * boxes: then nothing is done, but the set of rows holds nothing any more, and a renewal that might keep them is
 * given up. */
int msap_grid_jump(struct grid *g, struct job *job)
{
    struct jump j = {.grid = g, .job = job};
    struct pruning *p = &j.pruning;
    if (g->is_jumping && are_only_removed(job->boxes)) {
        msap_touch_known_pairs(job);
        return 1;
    }
    int done = count_all(g, job, p);
    if (done != 1) {
        g->renewal.next = NO_RENEWAL;
        return done;
    }
    if (g->is_tracking) msap_grid_empty(g, job->memory);
    g->is_jumping = 1;
    g->moves = job->boxes->live;
    j.is_comparing = msap_compare_is_worth_it(g, job);
    if (!j.is_comparing) msap_boxes_complete_before(job->boxes);
    if (!msap_rows_sort(p)) return 0;
    msap_rows_list(p);
    msap_rows_fill(p);
    if (!find_pairs(&j)) return 0;
    if (j.is_comparing) return msap_compare(g, job);
    msap_touch_known_pairs(job);
    return 1;
}

/* The same with new skins for all boxes, in which they rest from the end of the commit on (renew.c); wide
 * ones are put into cells then. Returns 0 without memory, and UNSUITED, with no pair looked at, where there are
 * many of these. */
int msap_grid_jump_into_skins(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    msap_boxes_complete_before(job->boxes);
    if (!msap_renewal_at_once(g, job)) return r->pruning.n_wide > MOST_WIDE ? UNSUITED : 0;
    struct jump j = {.grid = g, .job = job, .pruning = r->pruning, .has_skins = 1};
    keys_exchange(&job->worker->pairs, &r->found);
    int done = find_pairs(&j);
    keys_exchange(&job->worker->pairs, &r->found);
    if (!done) return 0;
    msap_touch_known_pairs(job);
    return 1;
}
