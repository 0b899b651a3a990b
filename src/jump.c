/* Pruning everything: the commit of a scene in which most boxes jump.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * When most boxes leave their places in every commit, nothing that could be kept
 * between commits would be worth keeping. So nothing is: all boxes are pruned
 * completely (paper I.4c), and the pairs known from before are tested once more.
 *
 * 1. All axes but one, the one on which boxes are finest compared with the scene, cut
 *    space into rows along that one: the paper's grid, one SAP a row (II.2). Rows wrap
 *    around, as cells do (grid.c). The boxes of each row are counted.
 * 2. The boxes are sorted by their min on that axis and written, in this order, into
 *    the rows that they touch: so every row is sorted.
 * 3. Each row is swept: from each box over those behind it until one starts after its
 *    end, eight at a time. Two boxes that meet in several rows are taken where, on both
 *    axes across, one of them starts: that is one row, unless rows wrap around so soon
 *    that the boxes meet at both ends.
 * 4. Boxes that touch many rows are in none; each is tested against all. Where there
 *    are many such boxes this is not the way, and the grid must be rebuilt.
 *
 * Sorting and filling take the calling thread, sweeps and tests all workers. */
#include "cells.h"

enum { MOST_ROWS = 8, MOST_ACTIVE = 8, MOST_WIDE = 64 };

/* With a slot, in a row: its box starts there on the first or the second axis across. */
#define STARTS_1 0x80000000u
#define STARTS_2 0x40000000u
#define STARTS (STARTS_1 | STARTS_2)

/* The rows that a box touches. */
struct row_range {
    int32_t low[2], high[2];
};

/* One call at work. */
struct jump {
    struct grid *grid;
    struct job *job;
    uint64_t *order;         /* [n] keys of the boxes by their min on the sweep axis */
    struct row_range *range; /* [slots] */
    uint32_t *wide;          /* [n_wide] slots of the boxes of step 4 */
    size_t n, n_wide;
    uint32_t *end;      /* [rows] behind the last box of each row */
    struct row_set set; /* the boxes, row after row */
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
    struct spread *y = &s[r->axis[1]], *z = &s[r->axis[2]];
    for (; active < MOST_ACTIVE && msap_cells_on(y) * msap_cells_on(z) > 1; active *= 2)
        ++*(msap_cells_on(y) > msap_cells_on(z) ? &y->exponent : &z->exponent);
    for (uint32_t k = 0; k < 2; k++) {
        const struct spread *across = k == 0 ? y : z;
        r->count[k] = across->exponent > WIDEST_CELL ? 1 : msap_count_for(msap_cells_on(across));
        r->scale[r->axis[1 + k]] = r->count[k] == 1 ? 0 : (float)msap_power_of_two(-across->exponent);
    }
    r->scale[r->axis[0]] = 0;
    for (r->shift = 0; 1u << r->shift < r->count[0];) r->shift++;
    r->chosen_for = boxes->live + 1;
}

/* --------------------------------------------------------------- steps 1, 2 */

/* The numbers of rows are powers of two. */
static inline size_t row_at(const struct rows *r, int32_t y, int32_t z)
{
    return (size_t)((uint32_t)z & (r->count[1] - 1)) << r->shift | ((uint32_t)y & (r->count[0] - 1));
}

/* The rows from unit `low` to unit `high` across: all around, starting below every
 * other, if they are as many as there are. Returns how many they are. */
static inline uint64_t range_across(struct row_range *range, uint32_t k, int32_t low, int32_t high, uint32_t count)
{
    uint32_t more = (uint32_t)high - (uint32_t)low;
    int is_all = more >= count;
    range->low[k] = is_all ? -CELL_LIMIT : low;
    range->high[k] = is_all ? (int32_t)count - 1 - CELL_LIMIT : high;
    return is_all ? count : (uint64_t)more + 1;
}

/* The rows that a box touches; returns how many. */
static inline uint64_t range_rows(const struct rows *r, const struct bounds *b, struct row_range *range)
{
    int32_t low[4], high[4];
    uint32_t y = r->axis[1], z = r->axis[2];
    units_of(r->scale, b->min, low);
    units_of(r->scale, b->max, high);
    return range_across(range, 0, low[y], high[y], r->count[0]) *
           range_across(range, 1, low[z], high[z], r->count[1]);
}

/* Finds the rows of each box, counts the boxes of each row into `end`, puts the wide boxes
 * aside, and completes the bounds before. Returns the number of entries in all rows. */
static size_t count_rows(struct jump *j)
{
    const struct rows *r = &j->grid->rows;
    const struct box_table *t = j->job->boxes;
    uint32_t sweep_axis = r->axis[0];
    size_t entries = 0;
    memset(j->end, 0, (size_t)r->count[0] * r->count[1] * sizeof *j->end);
    for (uint32_t slot = 0; slot < t->used; slot++) {
        const struct box *b = &t->at[slot];
        struct row_range *range = &j->range[slot];
        if (!(b->flags & BOX_LIVE)) continue;
        if (!box_is_changed(t, slot)) t->past[slot].before = b->now;
        uint64_t rows = range_rows(r, &b->now, range);
        if (rows > MOST_ROWS) {
            j->wide[j->n_wide++] = slot;
            continue;
        }
        j->order[j->n++] = key_make(b->now.min[sweep_axis], 0, slot);
        entries += rows;
        for (int32_t z = range->low[1]; z <= range->high[1]; z++)
            for (int32_t y = range->low[0]; y <= range->high[0]; y++) j->end[row_at(r, y, z)]++;
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

static void fill_rows(struct jump *j)
{
    const struct rows *r = &j->grid->rows;
    const struct box *boxes = j->job->boxes->at;
    const uint32_t axis[3] = {r->axis[0], r->axis[1], r->axis[2]};
    struct row_set set = j->set;
    for (size_t i = 0; i < j->n; i++) {
        uint32_t slot = key_box(j->order[i]);
        const struct row_range *range = &j->range[slot];
        for (int32_t z = range->low[1]; z <= range->high[1]; z++)
            for (int32_t y = range->low[0]; y <= range->high[0]; y++) {
                uint32_t starts = (y == range->low[0] ? STARTS_1 : 0) | (z == range->low[1] ? STARTS_2 : 0);
                row_set_put(&set, j->end[row_at(r, y, z)]++, &boxes[slot].now, axis, slot | starts);
            }
    }
}

/* --------------------------------------------------------------- steps 3, 4 */

/* Settles the pairs that were found in a row and are taken there. */
static void settle_row_pairs(struct settler *s, const struct pair_buffer *found)
{
    for (size_t i = 0; i < found->n; i++) {
        uint32_t a = found->a[i], b = found->b[i];
        if (((a | b) & STARTS) == STARTS) settle_found(s, a & ~STARTS, b & ~STARTS);
    }
}

/* Sweeps rows first ... last - 1. */
static void sweep_rows(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    struct pair_buffer found;
    for (size_t row = first; row < last; row++) {
        uint32_t start = row ? j->end[row - 1] : 0, end = j->end[row];
        for (struct row_sweep at = {start, start + 1}; at.i < end;) {
            j->grid->sweep_row(&j->set, &at, end, &found);
            settle_row_pairs(&w->settler, &found);
        }
    }
}

/* Tests wide boxes first ... last - 1 against all. */
static void test_wide(void *context, struct worker *w, size_t first, size_t last)
{
    const struct jump *j = context;
    for (size_t i = first; i < last; i++) {
        for (size_t other = 0; other < i; other++) settle(&w->settler, j->wide[i], j->wide[other]);
        for (size_t other = 0; other < j->n; other++) settle(&w->settler, j->wide[i], key_box(j->order[other]));
    }
}

/* ---------------------------------------------------------------- the whole */

/* Cuts the arrays of a call out of scratch memory. Returns 0 without it. */
static int place_arrays(struct jump *j)
{
    size_t slots = j->job->boxes->used, rows = (size_t)j->grid->rows.count[0] * j->grid->rows.count[1];
    size_t words = 2 * slots + 2 * slots + slots / 2 + 1 + rows / 2 + 1;
    uint64_t *at = msap_scratch_get(j->job->scratch, j->job->memory, words);
    if (!at) return 0;
    j->order = at;
    j->range = (struct row_range *)(void *)(at + 2 * slots);
    j->wide = (uint32_t *)(void *)(at + 4 * slots);
    j->end = (uint32_t *)(void *)(at + 4 * slots + slots / 2 + 1);
    return 1;
}

/* Touches all pairs that overlap and all that did. Returns 0 without memory, and
 * UNSUITED, with nothing done, where there are many wide boxes. */
int msap_grid_jump(struct grid *g, struct job *job)
{
    enum { COMMITS = 16 };
    struct jump j = {.grid = g, .job = job};
    struct rows *r = &g->rows;
    if (job->boxes->used > STARTS_2) return UNSUITED; /* a slot has no bits to spare */
    if (msap_is_outgrown(r->chosen_for, job->boxes->live) || g->commit - r->chosen_at > COMMITS) {
        choose_rows(r, job->boxes);
        r->chosen_at = g->commit;
    }
    if (!place_arrays(&j)) return 0;
    size_t entries = count_rows(&j);
    if (j.n_wide > MOST_WIDE) return UNSUITED;
    if (g->is_tracking) msap_grid_empty(g, job->memory);
    g->moves = job->boxes->live;
    if (!msap_row_set_make(&g->row_set, job->memory, entries)) return 0;
    msap_sort_values(j.order, j.n, j.order + job->boxes->used);
    j.set = g->row_set;
    size_t rows = (size_t)r->count[0] * r->count[1];
    start_rows(&j, rows);
    fill_rows(&j);
    if (!msap_phase_run(job->crew, job->memory, sweep_rows, &j, rows, entries * WEIGHT_ROW_BOX / rows + 1) ||
        !msap_phase_run(job->crew, job->memory, test_wide, &j, j.n_wide, j.n * WEIGHT_TOUCH))
        return 0;
    msap_touch_known_pairs(job);
    return 1;
}
