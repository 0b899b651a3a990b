/* Resting: boxes stay in the rows in which all were pruned until they move.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * After a jump (jump.c) the rows hold every box but the wide ones, sorted: that is a broad phase
 * of its own for boxes that stay where they are. So when only few boxes move after a jump, no cells and lists
 * are made for all. Each box goes over to the cells when it moves for the first time, and what it finds
 * there and in the rows become its neighbours; then it is as any other (track.c). To load a level costs what
 * one pruning does.
 *
 * A box of the last commit that is in no cell rests: the rows hold it as it was then, or with its skin. Two
 * boxes that rest are not in each other's lists. A box that rests and moves finds the
 * pairs that it had with others that rest where it was, in the rows or, where many have moved, in a list of
 * all such pairs (partners.c). What rows hold of boxes that do not rest
 * any more is passed over. If they rest in skins (renew.c), what all boxes are to each other candidates tell. */
#include "rows.h"

/* ------------------------------------------------------------------- asking */

/* The first box of a row, but for REACH, that may reach a value. */
static uint32_t first_that_reaches(const struct row_set *set, size_t row, int32_t value)
{
    uint32_t start = row_start(set, row), low = 0, high = (set->end[row] - start + REACH - 1) / REACH;
    const int32_t *reach = set->reach + reach_of(row, start);
    while (low < high) {
        uint32_t middle = (low + high) / 2;
        if (reach[middle] < value) low = middle + 1;
        else high = middle;
    }
    return start + low * REACH;
}

/* Drops, of the boxes found from the n-th on, those that do not rest, lack flags, or are apart although their
 * skins, which the rows may hold, are not; returns how many are left. */
static size_t keep_resting(const struct grid *g, const struct bounds *where, uint32_t flags, uint32_t *found,
                           size_t n, size_t end)
{
    for (size_t i = n; i < end; i++) {
        uint32_t slot = found[i];
        found[n] = slot;
        n += rests(g, &g->boxes->at[slot]) && (g->boxes->at[slot].flags & flags) == flags &&
             overlap(bounds_in_grid(g, slot), where);
    }
    return n;
}

/* Asks a row. What is found is fetched, and is looked at when all rows have been asked. */
static size_t ask_row(const void *context, struct worker *w, const struct row_question *q, size_t row, size_t n)
{
    const struct grid *g = context;
    struct row_sweep at = {.i = first_that_reaches(&g->row_set, row, q->min[0]), .end = g->row_set.end[row]};
    while (at.i < at.end) {
        if (!msap_worker_room_to_find(w, n, ENTRIES_ASKED)) return SIZE_MAX;
        size_t end = n + g->sweeps.ask_row(&g->row_set, q, &at, w->found + n);
        for (; n < end; n++) prefetch(&g->boxes->at[w->found[n]]);
    }
    return n;
}

/* Writes behind the first n that the worker has found what the rows hold that overlaps `where`; for a static
 * box what is not static. In most cases each is written once. Returns how many are found then, or SIZE_MAX
 * without room. */
size_t msap_rest_ask(const struct grid *g, struct worker *w, const struct bounds *where, int is_static, size_t n)
{
    struct row_question q = {.lacks = is_static ? ROW_MOVES : 0};
    return msap_rows_ask(&g->rows, where, &q, ask_row, g, w, n);
}

/* The same of the boxes that rest, have all of the flags and whose own bounds overlap `where`. */
size_t msap_rest_find(const struct grid *g, struct worker *w, const struct bounds *where, int is_static,
                      uint32_t flags, size_t n)
{
    size_t end = msap_rest_ask(g, w, where, is_static, n);
    return end == SIZE_MAX ? SIZE_MAX : keep_resting(g, where, flags, w->found, n, end);
}

/* ------------------------------------------------------------ going elsewhere */

/* Puts boxes that rest and changed on the list of those that left. */
void msap_rest_mark(const struct grid *g, struct box_table *t)
{
    for (size_t i = 0; i < t->n_changed; i++)
        if (rests(g, &t->at[t->changed[i]])) box_mark_left(t, t->changed[i]);
}

/* A box that rests is about to go elsewhere: settles what it was to others that rest. Returns 0 without
 * memory. */
int msap_rest_part(struct grid *g, const struct job *job, uint32_t slot)
{
    struct worker *w = job->worker;
    const struct box_table *t = job->boxes;
    if (msap_partners_settle(g, &w->settler, slot)) return 1;
    size_t n = msap_rest_find(g, w, box_before(t, slot), (t->at[slot].flags & BOX_STATIC) != 0, BOX_WAS, 0);
    if (n == SIZE_MAX) return 0;
    for (size_t i = 0; i < n; i++)
        if (w->found[i] != slot) settle(&w->settler, slot, w->found[i]);
    return 1;
}

/* Wide boxes are in no row: what they were to each other is settled, and those that are live stay in `wide`. */
static void call_wide(struct grid *g, struct settler *s)
{
    size_t n = 0;
    for (size_t i = 0; i < g->n_wide; i++)
        for (size_t k = 0; k < i; k++) settle(s, g->wide[i], g->wide[k]);
    for (size_t i = 0; i < g->n_wide; i++) {
        g->wide[n] = g->wide[i];
        n += (g->boxes->at[g->wide[i]].flags & BOX_LIVE) != 0;
    }
    g->n_wide = n;
}

/* After a jump: from now on cells and lists are kept, at first of n boxes and of those in `wide`, which are to be
 * put into cells before all others. Returns 0 without memory. */
int msap_rest_begin(struct grid *g, struct job *job, size_t n)
{
    g->is_jumping = 0;
    g->is_tracking = g->is_resting = 1;
    g->gain = 0;
    g->renewal.next = NO_RENEWAL;
    msap_layout_free(&g->layout[1 - g->current], job->memory);
    g->is_empty = 0;
    call_wide(g, &job->worker->settler);
    return msap_rows_note_reach(&g->row_set, &g->rows, job->memory) &&
           msap_layout_choose(g, job->memory, job->boxes, n + g->n_wide);
}

/* ------------------------------------------------------------------ checking */

/* Whether the rows hold a box: it rests or, while some are restless, is calm. */
static int is_in_rows(const struct grid *g, const struct box *b)
{
    return rests(g, b) || (g->restless.n > 0 && is_calm(b) && (b->flags & BOX_WAS));
}

/* The bounds of such a box that the rows hold. */
static const struct bounds *bounds_in_rows(const struct grid *g, uint32_t slot)
{
    return g->rows_hold_skins ? &g->boxes->at[slot].fat : box_before(g->boxes, slot);
}

/* How many rows it touches. */
static uint64_t rows_touched(const struct grid *g, uint32_t slot)
{
    struct row_span span = rows_of(&g->rows, bounds_in_rows(g, slot));
    return rows_in(&span);
}

/* Whether an entry of such a box has other bounds than the box. */
static int is_entry_broken(const struct grid *g, uint32_t i)
{
    const struct row_set *set = &g->row_set;
    const struct bounds *b = bounds_in_rows(g, row_slot(set->id[i]));
    for (int k = 0; k < 3; k++)
        if (set->min[k][i] != b->min[g->rows.axis[k]] || set->max[k][i] != b->max[g->rows.axis[k]]) return 1;
    return 0;
}

/* Adds the entries of a row of such boxes to *entries. */
static const char *row_broken(const struct grid *g, size_t row, uint64_t *entries)
{
    const struct row_set *set = &g->row_set;
    uint32_t start = row_start(set, row);
    const int32_t *reach = set->reach + reach_of(row, start);
    int32_t most = INT32_MIN;
    for (uint32_t i = start; i < set->end[row]; i++) {
        uint32_t slot = row_slot(set->id[i]);
        most = set->max[0][i] > most ? set->max[0][i] : most;
        if (((i - start) % REACH == REACH - 1 || i + 1 == set->end[row]) && reach[(i - start) / REACH] != most)
            return "a row reaches elsewhere than is told";
        if (!is_in_rows(g, &g->boxes->at[slot])) continue;
        if (is_entry_broken(g, i)) return "a row has other bounds than a box in it";
        ++*entries;
    }
    return NULL;
}

/* The first broken invariant of the rows, or NULL. */
const char *msap_rest_broken(const struct grid *g)
{
    uint64_t expected = 0, entries = 0;
    size_t rows = (size_t)g->rows.count[0] * g->rows.count[1];
    for (uint32_t slot = 0; slot < g->boxes->used; slot++)
        if (is_in_rows(g, &g->boxes->at[slot])) expected += rows_touched(g, slot);
    for (size_t row = 0; row < rows; row++) {
        const char *broken = row_broken(g, row, &entries);
        if (broken) return broken;
    }
    return entries == expected ? NULL : "a box is not in all rows that it touches";
}
