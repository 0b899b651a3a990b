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
 * It takes several times as long as other commits do. So where skins last long it is
 * done in steps, one after each of some commits, while the present skins serve; nothing of it shows before the
 * last one.
 *
 * 1. The skins to come are made, in two steps.
 * 2. The boxes are sorted into rows by them (rows.c), in four steps.
 * 3. The rows are swept, and wide boxes tested (wide.c), in one step or several.
 * 4. The new skins, rows and candidates take the place of the present ones. All boxes leave their cells,
 *    and rest in the rows, but for wide ones, which are put into cells. Then those that have come meanwhile, or are
 *    outside their new skin already, are put there, too (move.c).
 *
 * Where the present skins or those to come do not last long, some commits take two of these steps.
 *
 * Where skins last a few commits only, and when a world is loaded, a commit prunes all boxes with their new skins
 * at once (jump.c): steps 1 and 2 come in it, and instead of step 3 it finds candidates and pairs together.
 * Step 4 comes after it.
 *
 * While all boxes are pruned, that is tried first: some boxes get skins, and some commits later it is counted how
 * many have left them.
 *
 * From then on there are candidates instead of lists (candidates.c): a box that leaves its skin finds in cells and
 * rows what others it has. */
#include "rows.h"

/* ------------------------------------------------------------------- step 1 */

/* Boxes that get skins: from a slot on. */
struct fitting {
    struct grid *grid;
    size_t from;
};

/* Makes the skins of the boxes first ... last - 1 from there on. */
static void fit(void *context, struct worker *w, size_t first, size_t last)
{
    const struct fitting *f = context;
    (void)w;
    msap_skins_make(f->grid, f->grid->renewal.fat, f->from + first, f->from + last, 1);
}

static void fit_all(struct grid *g, struct job *job, size_t from, size_t to)
{
    struct fitting f = {g, from};
    msap_phase_run(job->crew, job->memory, fit, &f, to - from, WEIGHT_SKIN); /* it finds nothing */
}

/* Room for the skins of all boxes, and for one more, which vectors may read. Returns 0 without memory. */
static int prepare_skins(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    const struct box_table *t = job->boxes;
    if (t->used > ROW_MOVES) /* GCOVR_EXCL_BR_LINE: 2^29 boxes, and a slot has no bits to spare */
        return 0;            /* GCOVR_EXCL_LINE: the same */
    if (!msap_memory_reserve(job->memory, &r->fat, &r->room_fat, t->used + 1, 0, sizeof *r->fat)) return 0;
    memset(&r->fat[t->used], 0, sizeof *r->fat);
    r->slots = t->used;
    msap_upkeep_begins(g);
    return 1;
}

/* Those of the first half. Returns 0 without memory. */
static int make_skins(struct grid *g, struct job *job)
{
    if (!prepare_skins(g, job)) return 0;
    fit_all(g, job, 0, g->renewal.slots / 2);
    return 1;
}

/* Those of the other half. */
static int make_more_skins(struct grid *g, struct job *job)
{
    fit_all(g, job, g->renewal.slots / 2, g->renewal.slots);
    return 1;
}

/* ------------------------------------------------------------------- trial */

/* Of boxes in so many slots one in so many is tried. */
static size_t one_in(size_t slots)
{
    enum { SAMPLES = 128 };
    return slots / SAMPLES + 1;
}

/* While all boxes are pruned: some get skins, to see whether they leave them. Returns 0 without memory. */
static int try_skins(struct grid *g, struct job *job)
{
    if (!prepare_skins(g, job)) return 0;
    msap_skins_make(g, g->renewal.fat, 0, g->renewal.slots, one_in(g->renewal.slots));
    return 1;
}

/* How many boxes would have left their skins by now, if all were as those that were tried. */
int64_t msap_trial_count(const struct grid *g)
{
    const struct renewal *r = &g->renewal;
    const struct box_table *t = g->boxes;
    size_t step = one_in(r->slots), n = 0;
    for (size_t slot = 0; slot < r->slots; slot += step) {
        if ((t->at[slot].flags & (BOX_LIVE | BOX_FITTED)) != (BOX_LIVE | BOX_FITTED)) continue;
        const struct readable skin = {r->fat[slot], 0};
        n += !contains(&skin.bounds, &t->at[slot].now);
    }
    return (int64_t)(n * step);
}

/* ------------------------------------------------------------------- step 2 */

/* While boxes are sorted, the world's scratch room is the renewal's. */
static void lend_scratch(struct renewal *r, struct job *job)
{
    const struct scratch words = r->words;
    r->words = *job->scratch;
    *job->scratch = words;
}

/* The skins of wide boxes are made anew, now that it is known which these are: most others are no larger than a row
 * is wide. */
static void fit_wide(struct grid *g)
{
    const struct renewal *r = &g->renewal;
    const float *scale = r->rows.scale;
    float finest = scale[0] > scale[1] ? scale[0] : scale[1];
    for (size_t i = 0; i < r->pruning.n_wide; i++) msap_skin_make_wide(g, r->fat, r->wide[i], 1 / finest);
}

/* Returns 0 without memory, and where there are many wide boxes. */
static int count_rows(struct grid *g, struct job *job)
{
    enum { COMMITS = 256 };
    struct renewal *r = &g->renewal;
    struct pruning *p = &r->pruning;
    const struct pruning all = {.job = job,
                                .rows = &r->rows,
                                .set = &r->set,
                                .last = &g->row_set,
                                .slots = r->slots,
                                .bounds = {r->fat, sizeof *r->fat, BOX_LIVE | BOX_FITTED}};
    *p = all;
    msap_rows_choose(p, g->commit, COMMITS);
    lend_scratch(r, job);
    if (!msap_rows_count(p, &r->words)) return 0;
    msap_wide_note(g, p);
    if (p->n_wide > MOST_WIDE) return 0;
    memcpy(r->wide, p->wide, p->n_wide * sizeof *r->wide);
    p->wide = r->wide; /* which outlasts the room that it stood in */
    fit_wide(g);
    return 1;
}

/* The pruning of a step before, of the same boxes, whatever has become of them; the last rows, which it may keep,
 * are the same. */
static struct pruning *pruning_of(struct grid *g, struct job *job)
{
    g->renewal.pruning.job = job;
    return &g->renewal.pruning;
}

/* Returns 0 without memory. */
static int sort_rows(struct grid *g, struct job *job) { return msap_rows_sort(pruning_of(g, job)); }

static int list_rows(struct grid *g, struct job *job)
{
    msap_rows_list(pruning_of(g, job));
    lend_scratch(&g->renewal, job);
    return 1;
}

/* Returns 0 without memory. */
static int fill_rows(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    r->swept = r->found.n = r->by_rows = 0;
    msap_rows_fill(pruning_of(g, job));
    return msap_rows_note_reach(&r->set, &r->rows, job->memory) &&
           msap_keys_reserve(&r->found, job->memory, g->candidates.n); /* as many as now, mostly */
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

/* Entries, or wide boxes, from one on. */
struct swept {
    const struct grid *grid;
    size_t from;
};

/* Sweeps from entries first ... last - 1 from there on. */
static void sweep(void *context, struct worker *w, size_t first, size_t last)
{
    const struct swept *s = context;
    const struct renewal *r = &s->grid->renewal;
    msap_rows_sweep(&r->set, &r->rows, s->grid->sweeps.row, s->from + first, s->from + last, take, NULL, w);
}

/* Tests wide boxes first ... last - 1 from there on. */
static void test_wide(void *context, struct worker *w, size_t first, size_t last)
{
    const struct swept *s = context;
    msap_wide_test(&s->grid->renewal.pruning, &s->grid->sweeps, s->from + first, s->from + last, take, NULL, w);
}

/* As how many entries a wide box counts, and how many there are then. */
static size_t weight_of_wide(const struct pruning *p)
{
    enum { SHARE = 16 };
    return p->entries / SHARE + 1;
}

static size_t count_swept(const struct pruning *p) { return p->entries + p->n_wide * weight_of_wide(p); }

/* Which of the wide boxes is next when so much has been swept. */
static size_t next_wide(const struct pruning *p, size_t swept)
{
    return swept > p->entries ? (swept - p->entries) / weight_of_wide(p) : 0;
}

/* Finds candidates until so much has been swept. Returns 0 without memory. */
static int sweep_to(struct grid *g, struct job *job, size_t end)
{
    struct renewal *r = &g->renewal;
    const struct pruning *p = pruning_of(g, job);
    size_t last = end < p->entries ? end : p->entries, wide = next_wide(p, r->swept);
    struct swept entries = {g, r->swept}, wide_ones = {g, wide};
    if (entries.from < last) {
        if (!msap_phase_run(job->crew, job->memory, sweep, &entries, last - entries.from, WEIGHT_ROW_BOX))
            return 0;
        r->by_rows = job->worker->pairs.n;
    }
    r->swept = end;
    return msap_phase_run(job->crew, job->memory, test_wide, &wide_ones, next_wide(p, end) - wide,
                          job->boxes->live * WEIGHT_TOUCH);
}

/* The more candidates boxes have, the more steps it takes. Returns 0 without memory. */
static int find_candidates(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    size_t all = count_swept(&r->pruning), share = all / sweep_steps(job) + 1, left = all - r->swept;
    keys_exchange(&job->worker->pairs, &r->found);
    int done = sweep_to(g, job, r->swept + (share < left ? share : left));
    keys_exchange(&job->worker->pairs, &r->found);
    return done && r->found.n <= UINT32_MAX; /* GCOVR_EXCL_BR_LINE: what is named by more bits takes 32 GB */
}

/* ------------------------------------------------------------------- step 4 */

/* All boxes leave cells and lists, and what was made takes the place of what there is. Returns 0 without
 * memory. */
static int change_over(struct grid *g, struct job *job)
{
    enum { SHARE = 2, COMMITS = 256 }; /* of the boxes, that may come to be in cells; and the layout is old */
    struct renewal *r = &g->renewal;
    struct layout *l = &g->layout[g->current];
    const struct row_set set = g->row_set;
    const struct keys candidates = g->candidates;
    size_t boxes = job->boxes->live / SHARE;
    msap_restless_forget(g);
    msap_grid_empty_cells(g, job->memory);
    msap_layout_free(&g->layout[1 - g->current], job->memory);
    g->rows = r->rows;
    g->row_set = r->set;
    g->candidates = r->found;
    g->untold = r->is_told ? 0 : r->by_rows;
    r->set = set;
    r->found = candidates;
    g->is_tracking = g->is_resting = g->in_skins = g->rows_hold_skins = 1;
    g->is_jumping = g->is_empty = 0;
    g->quiet = 0;
    return !(msap_is_outgrown(l->chosen_for, boxes) || g->commit - l->chosen_at > COMMITS) ||
           msap_layout_choose(g, job->memory, job->boxes, boxes);
}

/* What a renewal works in holds half as much as all else. But where skins do not last it is soon needed again,
 * unless the first candidates took several times as much as those do that came now. */
static int has_much(const struct grid *g)
{
    enum { SEVERAL = 3 };
    const struct keys *c = &g->candidates;
    return g->boxes->used > VERY_MANY_BOXES && (!g->renewal.is_told || c->room / SEVERAL > c->n);
}

static void give_back(struct grid *g, struct job *job)
{
    struct keys *c = &g->candidates;
    msap_renewal_free(&g->renewal, job->memory);
    msap_scratch_free(job->scratch, job->memory);
    msap_memory_shrink(job->memory, &c->at, &c->room, c->n + c->n / 8, sizeof *c->at);
}

/* When a world is loaded: takes room for the rows and candidates of its first renewal and writes to it, so that
 * this does not wait for new pages. Where memory lacks it asks again. */
static void take_ahead(struct grid *g, struct memory *m)
{
    struct renewal *r = &g->renewal;
    if (msap_row_set_make(&r->set, m, r->pruning.entries))
        memset(r->set.words, 0, r->set.room * sizeof *r->set.words);
    if (msap_keys_reserve(&r->found, m, g->candidates.n + 1))
        memset(r->found.at, 0, r->found.room * sizeof *r->found.at);
}

/* The candidates of wide boxes, which are the last ones, are told what they are; those with a box that is outside
 * its new skin, or has none, are dropped: others will be found for it. */
static void tell_wide(struct grid *g)
{
    const struct box *box = g->boxes->at;
    struct keys *c = &g->candidates;
    size_t n = g->untold;
    for (size_t i = n; i < c->n; i++) {
        const struct box *p = &box[c->at[i] >> 32], *q = &box[(uint32_t)c->at[i]];
        c->at[n] = c->at[i] | (overlap(&p->now, &q->now) ? NEAR_PAIR : 0);
        n += (p->flags & q->flags & BOX_LIVE) && !box_has_left(p) && !box_has_left(q);
    }
    c->n = n;
}

/* The wide boxes that rest in their new skins are put into cells. Returns 0 without memory. */
static int enter_wide(struct grid *g, const struct job *job)
{
    struct renewal *r = &g->renewal;
    size_t n = 0;
    for (size_t i = 0; i < r->pruning.n_wide; i++) {
        const struct box *b = &g->boxes->at[r->wide[i]];
        r->wide[n] = r->wide[i];
        n += (b->flags & BOX_LIVE) && !box_has_left(b);
    }
    return msap_enter_all(g, job, r->wide, n);
}

/* Returns 0 without memory. */
static int install(struct grid *g, struct job *job)
{
    struct box_table *t = job->boxes;
    int are_new = !g->in_skins;
    g->moves += t->live;
    if (!change_over(g, job)) return 0;
    msap_skins_put_on(g, t, are_new);
    if (!g->renewal.is_told) tell_wide(g);
    job->worker->pairs.n = 0; /* no candidate is dropped any more */
    int done = enter_wide(g, job) && msap_place_all(g, job, t->left, t->n_left) &&
               msap_candidates_find(g, job, t->left, t->n_left);
    for (size_t i = 0; i < t->n_left; i++) t->at[t->left[i]].left = STAYED;
    t->n_left = 0;
    if (has_much(g)) give_back(g, job);
    if (t->used <= VERY_MANY_BOXES && g->upkeep.is_first && g->renewal.is_told) take_ahead(g, job->memory);
    return done;
}

/* ---------------------------------------------------------------- the whole */

/* The step after one that was done. */
static enum renewal_step step_after(const struct renewal *r, enum renewal_step now)
{
    if (now == SWEEP_ROWS && r->swept < count_swept(&r->pruning)) return now;
    return now == CHANGE_SKINS || now == TRY_SKINS ? NO_RENEWAL : now + 1;
}

/* Takes the next step. Without memory, and where there are many wide boxes, the skins to come are given up; in
 * the last step, all that is kept. */
static void take_step(struct grid *g, struct job *job)
{
    static int (*const steps[])(struct grid * g, struct job * job) = {
        [TRY_SKINS] = try_skins,   [MAKE_SKINS] = make_skins,      [MAKE_MORE_SKINS] = make_more_skins,
        [COUNT_ROWS] = count_rows, [SORT_ROWS] = sort_rows,        [LIST_ROWS] = list_rows,
        [FILL_ROWS] = fill_rows,   [SWEEP_ROWS] = find_candidates, [CHANGE_SKINS] = install};
    enum renewal_step now = g->renewal.next;
    int is_at_once = g->renewal.is_told, done = steps[now](g, job);
    g->renewal.next = done ? step_after(&g->renewal, now) : NO_RENEWAL;
    if (!done) msap_renewal_failed(g);
    else if (now == CHANGE_SKINS) msap_renewal_was_made(g, job, is_at_once);
    if (!done && now == CHANGE_SKINS) msap_grid_empty(g, job->memory);
}

/* Whether the step after this one is taken in the same commit. */
static int are_two(const struct renewal *r, enum renewal_step now)
{
    if (now == MAKE_SKINS) return r->pace != AT_EASE;
    if (now == LIST_ROWS) return r->pace == IN_A_HURRY;
    return r->pace == IN_A_RUSH && (now == SORT_ROWS || now == FILL_ROWS);
}

/* The next step; or two. */
void msap_renewal_go_on(struct grid *g, struct job *job)
{
    int is_followed = are_two(&g->renewal, g->renewal.next);
    take_step(g, job);
    if (is_followed && g->renewal.next != NO_RENEWAL) take_step(g, job);
}

/* The first step. */
void msap_renewal_begin(struct grid *g, struct job *job)
{
    g->renewal.is_told = 0;
    g->renewal.pace = msap_renewal_pace(g, job);
    g->renewal.next = MAKE_SKINS;
    msap_renewal_go_on(g, job);
}

/* Steps 1 and 2, for a commit that prunes all boxes with their new skins and finds the candidates itself (jump.c):
 * step 4 comes after it. Returns 0 without memory, and where there are many wide boxes. */
int msap_renewal_at_once(struct grid *g, struct job *job)
{
    struct renewal *r = &g->renewal;
    r->next = NO_RENEWAL;
    r->pruning.n_wide = 0;
    if (!make_skins(g, job)) return 0;
    make_more_skins(g, job);
    if (!count_rows(g, job) || !sort_rows(g, job)) return 0;
    list_rows(g, job);
    if (!fill_rows(g, job)) return 0;
    r->is_told = 1;
    r->next = CHANGE_SKINS;
    return 1;
}

void msap_renewal_free(struct renewal *r, struct memory *m)
{
    msap_memory_free(m, r->fat, r->room_fat, sizeof *r->fat);
    msap_row_set_free(&r->set, m);
    msap_keys_free(&r->found, m);
    msap_memory_free(m, r->words.at, r->words.room, sizeof *r->words.at);
    memset(r, 0, sizeof *r);
}
