/* Renewing: all boxes get new skins together, little by little.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * To put a box elsewhere costs as much as to prune ten (choose.c). Where all boxes move, and so
 * leave their skins sooner or later, it is cheaper to give all of them new ones before they do, and
 * to prune them with these. What is found are the candidates, the pairs whose skins overlap: until the next
 * renewal a commit has to test these and to put the few boxes elsewhere that do leave
 * their skins, into cells.
 *
 * In one commit that would take several times as long as others do. So it is
 * done in steps, one after each of some commits, while the present skins serve; nothing of it shows before the
 * last one.
 *
 * 1. The skins to come are made.
 * 2. The boxes are sorted into rows by them (rows.c), in two steps.
 * 3. The rows are swept.
 * 4. The new skins, rows and candidates take the place of the present ones. All boxes leave their cells,
 *    and rest in the rows. Then those that have come meanwhile, or are outside their new skin
 *    already, are put into cells (move.c), and so are wide ones, which are in no row.
 *
 * From then on there are candidates instead of lists (candidates.c): a box that leaves its skin finds in cells and
 * rows what others it has. */
#include "rows.h"

/* ------------------------------------------------------------------- step 1 */

/* Makes the skins of the boxes in slots first ... last - 1. */
static void fit(void *context, struct worker *w, size_t first, size_t last)
{
    struct grid *g = context;
    (void)w;
    for (size_t slot = first; slot < last; slot++) {
        if (!(g->boxes->at[slot].flags & BOX_LIVE)) continue;
        msap_skin_ahead(g, (uint32_t)slot, &g->renewal.fat[slot]);
        g->boxes->at[slot].flags |= BOX_FITTED;
    }
}

/* Returns 0 without memory. */
static int make_skins(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    const struct box_table *t = job->boxes;
    if (t->used > ROW_NEW) /* GCOVR_EXCL_BR_LINE: 2^28 boxes, and a slot has no bits to spare */
        return 0;          /* GCOVR_EXCL_LINE: the same */
    if (!msap_memory_reserve(job->memory, &r->fat, &r->room_fat, t->used, 0, sizeof *r->fat)) return 0;
    r->slots = t->used;
    msap_upkeep_begins(g);
    msap_phase_run(job->crew, job->memory, fit, g, t->used, WEIGHT_SKIN); /* it finds nothing */
    return 1;
}

/* ------------------------------------------------------------------- step 2 */

static struct pruning pruning_of(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    const struct pruning p = {.job = job,
                              .rows = &r->rows,
                              .set = &r->set,
                              .slots = r->slots,
                              .flags = BOX_LIVE | BOX_FITTED,
                              .bounds = r->fat,
                              .step = sizeof *r->fat};
    return p;
}

/* The first half. Returns 0 without memory, and where there are many wide boxes. */
static int count_rows(struct grid *g, struct job *job)
{
    enum { COMMITS = 256 };
    struct renewal *r = &g->renewal;
    struct pruning p = pruning_of(g, job);
    r->rows = g->rows;
    msap_rows_choose(&r->rows, job->boxes, g->commit, COMMITS);
    if (!msap_rows_count(&p, &r->words) || p.n_wide > MOST_WIDE) return 0;
    for (size_t i = 0; i < p.n_wide; i++) job->boxes->at[p.wide[i]].flags &= ~(uint32_t)BOX_FITTED;
    r->order = p.order;
    r->range = p.range;
    r->n = p.n;
    r->entries = p.entries;
    return msap_rows_sort(&p);
}

/* The second half, of the same boxes, whatever has become of them. */
static int fill_rows(struct grid *g, struct job *job)
{
    const struct renewal *r = &g->renewal;
    struct pruning p = pruning_of(g, job);
    p.order = r->order;
    p.range = r->range;
    p.n = r->n;
    p.entries = r->entries;
    p.end = r->set.end;
    msap_rows_fill(&p);
    return 1;
}

/* ------------------------------------------------------------------- step 3 */

static void take(const void *context, struct worker *w, const struct pair_buffer *found)
{
    (void)context;
    if (found->n == 0 || !msap_worker_has_room(w, found->n, 0)) return;
    uint64_t *out = w->pairs.at + w->pairs.n;
    for (size_t i = 0; i < found->n; i++) out[i] = (uint64_t)found->a[i] << 32 | found->b[i];
    w->pairs.n += found->n;
}

/* Sweeps from entries first ... last - 1. */
static void sweep(void *context, struct worker *w, size_t first, size_t last)
{
    const struct grid *g = context;
    const struct renewal *r = &g->renewal;
    msap_rows_sweep(&r->set, &r->rows, g->sweep_row, first, last, take, NULL, w);
}

/* Returns 0 without memory. */
static int find_candidates(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    struct keys *pairs = &job->worker->pairs;
    pairs->n = 0;
    if (!msap_phase_run(job->crew, job->memory, sweep, g, r->entries, WEIGHT_ROW_BOX)) return 0;
    if (pairs->n > UINT32_MAX) /* GCOVR_EXCL_BR_LINE: notes could not name them; they take 32 GB */
        return 0;              /* GCOVR_EXCL_LINE: the same */
    const struct keys found = *pairs;
    *pairs = r->found; /* it does not matter what of */
    r->found = found;
    return 1;
}

/* ------------------------------------------------------------------- step 4 */

/* All boxes leave cells and lists, and what was made takes the place of what there is. Returns 0 without
 * memory. */
static int change_over(struct grid *g, struct job *job)
{
    enum { SHARE = 8, COMMITS = 256 }; /* so many boxes are expected in cells; and the layout is old */
    struct renewal *r = &g->renewal;
    struct layout *l = &g->layout[g->current];
    const struct row_set set = g->row_set;
    const struct keys candidates = g->candidates;
    size_t boxes = job->boxes->live / SHARE;
    msap_grid_empty_cells(g, job->memory);
    msap_layout_free(&g->layout[1 - g->current], job->memory);
    g->rows = r->rows;
    g->row_set = r->set;
    g->candidates = r->found;
    r->set = set;
    r->found = candidates;
    g->is_tracking = g->is_resting = g->in_skins = 1;
    g->is_jumping = g->is_empty = 0;
    g->quiet = 0;
    if ((msap_is_outgrown(l->chosen_for, boxes) || g->commit - l->chosen_at > COMMITS) &&
        !msap_layout_choose(g, job->memory, job->boxes, boxes))
        return 0;
    return msap_rest_note_reach(g, job->memory);
}

/* All boxes rest in their new skins. Those that are outside, or have none, are put on the list of those that
 * left, which is empty. */
static void put_on(struct grid *g, struct box_table *t, int is_first)
{
    const struct renewal *r = &g->renewal;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        struct box *b = &t->at[slot];
        if (!(b->flags & BOX_LIVE)) continue;
        b->level = NO_LEVEL;
        b->fat = b->flags & BOX_FITTED ? r->fat[slot] : b->now;
        if (b->flags & BOX_FITTED && contains(&b->fat, &b->now)) msap_skin_starts(g, slot, is_first);
        else box_mark_left(t, slot);
    }
}

/* Returns 0 without memory. */
static int install(struct grid *g, struct job *job)
{
    struct box_table *t = job->boxes;
    int is_first = !g->in_skins;
    g->moves += t->live;
    if (!change_over(g, job)) return 0;
    put_on(g, t, is_first);
    int done = msap_candidates_tell(g, job) && msap_place_all(g, job, t->left, t->n_left) &&
               msap_candidates_find(g, job, t->left, t->n_left);
    for (size_t i = 0; i < t->n_left; i++) t->at[t->left[i]].flags &= ~(uint32_t)BOX_LEFT;
    t->n_left = 0;
    return done;
}

/* ---------------------------------------------------------------- the whole */

/* The next step. Without memory, and where there are many wide boxes, the skins to come are given up; in
 * the last step, all that is kept. */
void msap_renewal_go_on(struct grid *g, struct job *job)
{
    static int (*const steps[])(struct grid * g, struct job * job) = {[COUNT_ROWS] = count_rows,
                                                                      [FILL_ROWS] = fill_rows,
                                                                      [SWEEP_ROWS] = find_candidates,
                                                                      [CHANGE_SKINS] = install};
    enum renewal_step now = g->renewal.next;
    g->renewal.next = NO_RENEWAL;
    int done = steps[now](g, job);
    if (!done && now == CHANGE_SKINS) msap_grid_empty(g, job->memory);
    if (!done) msap_renewal_failed(g);
    else if (now == CHANGE_SKINS) msap_renewal_was_made(g, job);
    else g->renewal.next = now + 1;
}

/* The first step. */
void msap_renewal_begin(struct grid *g, struct job *job)
{
    g->renewal.next = make_skins(g, job) ? COUNT_ROWS : NO_RENEWAL;
    if (g->renewal.next == NO_RENEWAL) msap_renewal_failed(g);
}

/* All steps, after a jump. When a world is loaded skins are made for any motion, and where boxes have many
 * pairs that would be dear. */
void msap_renewal_at_once(struct grid *g, struct job *job)
{
    enum { MANY = 12 };
    int is_first = g->upkeep.is_first;
    if (is_first && pairs_of_a_box(job) > MANY) return;
    g->renewal.next = make_skins(g, job) ? COUNT_ROWS : NO_RENEWAL;
    while (g->renewal.next != NO_RENEWAL) msap_renewal_go_on(g, job);
    g->upkeep.is_first = is_first;
    g->gain = 0;
}

void msap_renewal_free(struct renewal *r, struct memory *m)
{
    msap_memory_free(m, r->fat, r->room_fat, sizeof *r->fat);
    msap_row_set_free(&r->set, m);
    msap_keys_free(&r->found, m);
    msap_memory_free(m, r->words.at, r->words.room, sizeof *r->words.at);
    memset(r, 0, sizeof *r);
}
