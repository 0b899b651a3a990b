/* Pruning everything: the commit of a scene in which most boxes jump.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * When most boxes leave their places in every commit, nothing that could be kept
 * between commits would be worth keeping. So no cells and lists are: all boxes are pruned
 * completely (paper I.4c). Then either the pairs found and those known from before are
 * settled, or, where most pairs are others each time, both are compared (compare.c).
 *
 * 1. All axes but one, the one on which boxes are finest compared with the scene, cut
 *    space into rows along that one: the paper's grid, one SAP a row (II.2). Rows wrap
 *    around, as cells do (grid.c). The boxes of each row are counted.
 * 2. The boxes are sorted by their min on that axis and named, in this order, in the
 *    rows that they touch: so every row is sorted. Then their bounds are written into the
 *    rows, one after another.
 * 3. Each row is swept: from each box over those behind it until one starts after its
 *    end, up to sixteen at a time. Two boxes that meet in several rows are taken where, on both
 *    axes across, one of them starts: that is one row, unless rows wrap around so soon
 *    that the boxes meet at both ends.
 * 4. Boxes that touch many rows are in none; each is tested against all. Where there
 *    are many such boxes this is not the way, and the grid must be rebuilt.
 *
 * Naming takes the calling thread, the rest all workers. */
#include "rows.h"

enum { MOST_ROWS = 8, MOST_ACTIVE = 8 };

/* The rows that a box touches: from which one and, of a box that is not wide, how many more on
 * each axis across. */
struct row_range {
    uint32_t row;
    uint8_t more[2];
    uint8_t is_static, is_new;
};

/* What a worker has counted of the slots from the first on. */
struct counted {
    size_t first, n, n_wide, entries;
    uint32_t *end; /* [rows] boxes; NULL: it was not at work */
};

/* One call at work. */
struct jump {
    struct grid *grid;
    struct job *job;
    uint64_t *order;         /* [n] keys of the boxes by their min on the sweep axis */
    struct row_range *range; /* [slots] */
    uint32_t *wide;          /* [n_wide] slots of the boxes of step 4 */
    size_t n, n_wide;
    uint32_t *end;    /* [rows] behind the last box of each row */
    uint32_t *end_by; /* [rows] the same of each worker but the calling thread's */
    struct counted by[1 + MOST_WORKERS];
    struct row_set set; /* the boxes, row after row */
    int is_comparing;   /* the pairs found are kept instead of settled */
};

/* ------------------------------------------------------------------ layout */

static uint32_t finest_axis(const struct spread s[3])
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < 3; k++)
        if (s[k].extent * s[best].size > s[best].extent * s[k].size) best = k;
    return best;
}

/* Rows are half as wide again as most boxes or more, and wider while a sweep would meet only few
 * boxes at a time. */
static void choose_rows(struct rows *r, const struct box_table *boxes)
{
    struct spread s[3];
    msap_spread_of(boxes, s);
    double active = (double)boxes->live;
    for (uint32_t k = 0; k < 3; k++) {
        s[k].exponent = msap_exponent_for(1.5 * s[k].size);
        if (s[k].extent > 0) active *= 2 * s[k].size / s[k].extent;
    }
    for (uint32_t k = 0; k < 3; k++) r->axis[k] = (finest_axis(s) + k) % 3;
    struct spread *x = &s[r->axis[0]], *y = &s[r->axis[1]], *z = &s[r->axis[2]];
    r->low = (float)(x->low - x->extent / 8); /* with room for the others */
    r->extent = (float)(x->extent * 1.25);
    for (; active < MOST_ACTIVE && msap_cells_on(y) * msap_cells_on(z) > 1; active *= 2)
        ++*(msap_cells_on(y) > msap_cells_on(z) ? &y->exponent : &z->exponent);
    for (uint32_t k = 0; k < 2; k++) {
        const struct spread *across = k == 0 ? y : z;
        r->count[k] = across->exponent > WIDEST_CELL ? 1 : msap_count_for(msap_cells_on(across));
        r->scale[k] = r->count[k] == 1 ? 0 : (float)msap_power_of_two(-across->exponent);
    }
    r->chosen_for = boxes->live + 1;
}

/* --------------------------------------------------------------- steps 1, 2 */

/* The rows that a box touches; returns how many. */
static inline uint64_t range_rows(const struct rows *r, const struct bounds *b, struct row_range *range)
{
    struct row_span span = rows_of(r, b);
    range->row = span.row;
    range->more[0] = (uint8_t)span.more[0];
    range->more[1] = (uint8_t)span.more[1];
    return ((uint64_t)span.more[0] + 1) * (span.more[1] + 1);
}

/* Counts a box in its rows: where it touches two on each axis at the most, without a question. */
static inline void count_in_rows(const struct rows *r, const struct row_range *range, uint32_t *end)
{
    uint32_t row = range->row, more_y = range->more[0], more_z = range->more[1];
    if ((more_y | more_z) <= 1) {
        end[row]++;
        end[next_row(r, row)] += more_y;
        if (r->count[1] == 1) return;
        row = next_line(r, row);
        end[row] += more_z;
        end[next_row(r, row)] += more_y & more_z;
        return;
    }
    for (uint32_t z = 0; z <= more_z; z++, row = next_line(r, row))
        for (uint32_t y = 0, at = row; y <= more_y; y++, at = next_row(r, at)) end[at]++;
}

/* Finds the rows of the boxes in slots first ... last - 1, counts the boxes of each row, names the
 * others in the worker's parts of the lists, and completes the bounds before. */
static void count_rows(void *context, struct worker *w, size_t first, size_t last)
{
    struct jump *j = context;
    const struct rows rows_now = j->grid->rows, *r = &rows_now;
    const struct box_table *t = j->job->boxes;
    uint32_t sweep_axis = r->axis[0];
    size_t worker = (size_t)(w - j->job->crew->worker), all_rows = (size_t)r->count[0] * r->count[1];
    struct counted c = {first, 0, 0, 0, worker == 0 ? j->end : j->end_by + (worker - 1) * all_rows};
    uint64_t *order = j->order + first;
    uint32_t *wide = j->wide + first;
    memset(c.end, 0, all_rows * sizeof *c.end);
    for (uint32_t slot = (uint32_t)first; slot < last; slot++) {
        const struct box *b = &t->at[slot];
        struct row_range *range = &j->range[slot];
        if (!(b->flags & BOX_LIVE)) continue;
        if (!box_is_changed(t, slot)) t->past[slot].before = b->now;
        uint64_t rows = range_rows(r, &b->now, range);
        range->is_static = (b->flags & BOX_STATIC) != 0;
        range->is_new = !(b->flags & BOX_WAS);
        if (rows > MOST_ROWS) {
            wide[c.n_wide++] = slot;
            continue;
        }
        order[c.n++] = key_make(b->now.min[sweep_axis], 0, slot);
        c.entries += rows;
        count_in_rows(r, range, c.end);
    }
    j->by[worker] = c;
}

/* Adds what the workers have counted up. Returns the number of entries in all rows. */
static size_t add_up(struct jump *j)
{
    size_t rows = (size_t)j->grid->rows.count[0] * j->grid->rows.count[1], entries = 0;
    if (!j->by[0].end) memset(j->end, 0, rows * sizeof *j->end);
    for (uint32_t i = 0; i <= MOST_WORKERS; i++) {
        const struct counted *c = &j->by[i];
        if (!c->end) continue;
        if (c->first > j->n) memmove(j->order + j->n, j->order + c->first, c->n * sizeof *j->order);
        memmove(j->wide + j->n_wide, j->wide + c->first, c->n_wide * sizeof *j->wide);
        j->n += c->n;
        j->n_wide += c->n_wide;
        entries += c->entries;
        for (size_t row = 0; i > 0 && row < rows; row++) j->end[row] += c->end[row];
    }
    return entries;
}

/* Turns the counts into where each row starts. */
static void start_rows(struct jump *j, size_t rows)
{
    uint32_t start = 0;
    for (size_t i = 0; i < rows; i++) {
        uint32_t n = j->end[i];
        j->end[i] = start; /* and moves to the end as the row is filled */
        start += n;
    }
}

/* Names a box in the rows that it touches. */
static void list_in_many(const struct rows *r, const struct row_range *range, uint32_t name, uint32_t *end,
                         uint32_t *id)
{
    for (uint32_t z = 0, line = range->row; z <= range->more[1]; z++, line = next_line(r, line))
        for (uint32_t y = 0, row = line; y <= range->more[0]; y++, row = next_row(r, row))
            id[end[row]++] = name | (y == 0 ? ROW_STARTS_1 : 0) | (z == 0 ? ROW_STARTS_2 : 0);
}

/* Names a box in a row if `is` is 1. If it is 0, what is written goes to `nowhere`, without a question. */
static inline void list_if(uint32_t is, uint32_t *end, uint32_t *id, uint32_t name, uint32_t nowhere)
{
    id[nowhere ^ ((*end ^ nowhere) & (0 - is))] = name;
    *end += is;
}

/* The same of a box that touches two rows on each axis at the most. */
static inline void list_in_few(const struct rows *r, const struct row_range *range, uint32_t name, uint32_t *end,
                               uint32_t *id, uint32_t nowhere)
{
    uint32_t more_y = range->more[0], more_z = range->more[1], row = range->row;
    id[end[row]++] = name | ROW_STARTS_1 | ROW_STARTS_2;
    list_if(more_y, &end[next_row(r, row)], id, name | ROW_STARTS_2, nowhere);
    if (r->count[1] == 1) return;
    row = next_line(r, row);
    list_if(more_z, &end[row], id, name | ROW_STARTS_1, nowhere);
    list_if(more_y & more_z, &end[next_row(r, row)], id, name, nowhere);
}

/* Names the boxes of each row, in their order. */
static void list_rows(struct jump *j, uint32_t entries)
{
    enum { AHEAD = 8 };
    const struct rows rows_now = j->grid->rows, *r = &rows_now;
    const uint32_t news = j->is_comparing ? 0 : ROW_NEW;
    uint32_t *id = j->set.id, *end = j->end;
    for (size_t i = 0; i < j->n; i++) {
        uint32_t slot = key_box(j->order[i]);
        const struct row_range range = j->range[slot];
        if (i + AHEAD < j->n) prefetch(&j->range[key_box(j->order[i + AHEAD])]);
        uint32_t name = slot | (range.is_static ? 0 : ROW_MOVES) | (range.is_new ? news : 0);
        if ((range.more[0] | range.more[1]) <= 1) list_in_few(r, &range, name, end, id, entries);
        else list_in_many(r, &range, name, end, id);
    }
}

/* Writes the bounds of entries first ... last - 1. */
static void fill_rows(void *context, struct worker *w, size_t first, size_t last)
{
    enum { AHEAD = 8 };
    const struct jump *j = context;
    const struct box *boxes = j->job->boxes->at;
    const uint32_t *axis = j->grid->rows.axis, *id = j->set.id;
    int32_t *min[3], *max[3]; /* by axis of the boxes */
    (void)w;
    for (int k = 0; k < 3; k++) {
        min[axis[k]] = j->set.min[k];
        max[axis[k]] = j->set.max[k];
    }
    for (size_t i = first; i < last; i++) {
        const struct bounds *b = &boxes[row_slot(id[i])].now;
        if (i + AHEAD < last) prefetch(&boxes[row_slot(id[i + AHEAD])]);
        min[0][i] = b->min[0];
        min[1][i] = b->min[1];
        min[2][i] = b->min[2];
        max[0][i] = b->max[0];
        max[1][i] = b->max[1];
        max[2][i] = b->max[2];
    }
}

/* --------------------------------------------------------------- steps 3, 4 */

/* Pairs of a box that is new are new, wherever it was before. */
static void settle_taken(struct settler *s, const struct pair_buffer *taken)
{
    s->touched += taken->n;
    for (size_t i = 0; i < taken->n; i++) {
        uint32_t a = taken->a[i], b = taken->b[i];
        if ((a | b) & ROW_NEW) msap_settle_change(s, pair_key(row_slot(a), row_slot(b)), 1);
        else settle_found(s, a, b);
    }
}

static void keep_taken(struct worker *w, const struct pair_buffer *taken)
{
    if (taken->n == 0 || !msap_worker_has_room(w, taken->n, 0)) return;
    uint64_t *out = w->pairs.at + w->pairs.n;
    for (size_t i = 0; i < taken->n; i++) out[i] = pair_key(taken->a[i], taken->b[i]);
    w->pairs.n += taken->n;
}

/* The row of an entry. */
static size_t row_of(const struct jump *j, size_t entry)
{
    const struct rows *r = &j->grid->rows;
    size_t low = 0, high = (size_t)r->count[0] * r->count[1] - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (j->end[middle] <= entry) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Sweeps from entries first ... last - 1. */
static void sweep_rows(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    struct pair_buffer found;
    for (size_t row = row_of(j, first), i = first; i < last; i = j->end[row++]) {
        uint32_t end = j->end[row];
        struct row_sweep at = {(uint32_t)i, (uint32_t)i + 1, end < last ? end : (uint32_t)last, end};
        while (at.i < at.last) {
            j->grid->sweep_row(&j->set, &at, &found);
            if (j->is_comparing) keep_taken(w, &found);
            else settle_taken(&w->settler, &found);
        }
    }
}

/* Takes a pair that may overlap. */
static inline void test_pair(const struct jump *j, struct worker *w, uint32_t a, uint32_t b)
{
    const struct box *p = &j->job->boxes->at[a], *q = &j->job->boxes->at[b];
    if (!overlap(&p->now, &q->now) || (p->flags & q->flags & BOX_STATIC)) return;
    if (j->is_comparing) msap_worker_put(w, pair_key(a, b));
    else settle_found(&w->settler, a, b);
}

/* Tests wide boxes first ... last - 1 against all. */
static void test_wide(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    for (size_t i = first; i < last; i++) {
        for (size_t other = 0; other < i; other++) test_pair(j, w, j->wide[i], j->wide[other]);
        for (size_t other = 0; other < j->n; other++) test_pair(j, w, j->wide[i], key_box(j->order[other]));
        w->settler.touched += i + j->n;
    }
}

/* ---------------------------------------------------------------- the whole */

/* Cuts the arrays of a call out of scratch memory. Returns 0 without it. */
static int place_arrays(struct jump *j)
{
    size_t slots = j->job->boxes->used, rows = (size_t)j->grid->rows.count[0] * j->grid->rows.count[1];
    size_t ends = rows * msap_phase_tasks(j->job->crew, slots, WEIGHT_ROWS);
    struct row_set *set = &j->grid->row_set;
    size_t words = slots + slots + slots / 2 + 1 + ends / 2 + 1; /* a range is one */
    uint64_t *at = msap_scratch_get(j->job->scratch, j->job->memory, words);
    if (!at || !msap_memory_reserve(j->job->memory, &set->end, &set->room_end, rows, 0, sizeof *set->end))
        return 0;
    j->order = at;
    j->range = (struct row_range *)(void *)(at + slots);
    j->wide = (uint32_t *)(void *)(at + 2 * slots);
    j->end_by = (uint32_t *)(void *)(at + 2 * slots + slots / 2 + 1);
    j->end = set->end;
    return 1;
}

/* Steps 3 and 4. Two static boxes are no pair: where there are no others, there is nothing to find. Returns 0
 * without memory. */
static int find_pairs(struct jump *j, size_t entries)
{
    struct job *job = j->job;
    job->worker->pairs.n = 0;
    if (job->boxes->live == job->boxes->live_static) return 1;
    return msap_phase_run(job->crew, job->memory, sweep_rows, j, entries, WEIGHT_ROW_BOX) &&
           msap_phase_run(job->crew, job->memory, test_wide, j, j->n_wide, j->n * WEIGHT_TOUCH);
}

/* Whether boxes were only removed: then no pair is new, and the rows hold all others. */
static int are_only_removed(const struct box_table *t)
{
    size_t n = 0;
    while (n < t->n_changed && !(t->at[t->changed[n]].flags & BOX_LIVE)) n++;
    return n == t->n_changed;
}

/* Finds the pairs that overlap, and the events. Returns 0 without memory, and
 * UNSUITED, with nothing done, where there are many wide boxes. */
int msap_grid_jump(struct grid *g, struct job *job)
{
    enum { COMMITS = 16 };
    struct jump j = {.grid = g, .job = job};
    struct rows *r = &g->rows;
    if (g->is_jumping && are_only_removed(job->boxes)) {
        msap_touch_known_pairs(job);
        return 1;
    }
    if (job->boxes->used > ROW_NEW) /* GCOVR_EXCL_BR_LINE: 2^28 boxes, and a slot has no bits to spare */
        return UNSUITED;            /* GCOVR_EXCL_LINE: the same */
    if (msap_is_outgrown(r->chosen_for, job->boxes->live) || g->commit - r->chosen_at > COMMITS) {
        choose_rows(r, job->boxes);
        r->chosen_at = g->commit;
    }
    if (!place_arrays(&j)) return 0;
    msap_phase_run(job->crew, job->memory, count_rows, &j, job->boxes->used, WEIGHT_ROWS); /* it finds nothing */
    size_t entries = add_up(&j);
    g->n_wide = j.n_wide;
    if (j.n_wide > MOST_WIDE) return UNSUITED;
    memcpy(g->wide, j.wide, j.n_wide * sizeof *g->wide);
    if (g->is_tracking) msap_grid_empty(g, job->memory);
    g->is_jumping = 1;
    g->moves = job->boxes->live;
    if (!msap_row_set_make(&g->row_set, job->memory, entries)) return 0;
    j.set = g->row_set;
    msap_share_sort_values(job, j.order, j.n, (uint64_t *)(void *)j.set.words, r->low, r->extent);
    start_rows(&j, (size_t)r->count[0] * r->count[1]);
    j.is_comparing = msap_compare_is_worth_it(g, job->pairs);
    list_rows(&j, (uint32_t)entries);
    msap_phase_run(job->crew, job->memory, fill_rows, &j, entries, WEIGHT_FILL); /* it finds nothing */
    if (!find_pairs(&j, entries)) return 0;
    if (j.is_comparing) return msap_compare(g, job);
    msap_touch_known_pairs(job);
    return 1;
}
