/* From bounds to the rows of jump.c and rest.c, inline.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Rows wrap around, as cells do (grid.c): their numbers on an axis across are modulo a power of two. */
#ifndef MSAP_ROWS_H
#define MSAP_ROWS_H

#include "cells.h"

/* The rows that bounds touch: from which one, and how many more on each axis across. */
struct row_span {
    uint32_t row, more[2];
};

/* The row behind one on the first axis across, and on the second, around the end. */
static inline uint32_t next_row(const struct rows *r, uint32_t row)
{
    uint32_t last = r->count[0] - 1;
    return (row & ~last) | ((row + 1) & last);
}
static inline uint32_t next_line(const struct rows *r, uint32_t row)
{
    return (row + r->count[0]) & (r->count[0] * r->count[1] - 1);
}

/* Where the first of the rows from unit `low` on is, *more of them besides: at the start if those
 * are all, all around. */
static inline uint32_t first_of(int32_t low, uint32_t *more, uint32_t count)
{
    if (*more < count) return (uint32_t)low & (count - 1);
    *more = count - 1;
    return 0;
}

static inline struct row_span rows_of(const struct rows *r, const struct bounds *b)
{
    const float scale[4] = {r->scale[0], r->scale[1], r->scale[0], r->scale[1]};
    const int32_t end[4] = {b->min[r->axis[1]], b->min[r->axis[2]], b->max[r->axis[1]], b->max[r->axis[2]]};
    int32_t at[4];
    four_units(scale, end, at);
    struct row_span s = {0, {(uint32_t)at[2] - (uint32_t)at[0], (uint32_t)at[3] - (uint32_t)at[1]}};
    uint32_t y = first_of(at[0], &s.more[0], r->count[0]), z = first_of(at[1], &s.more[1], r->count[1]);
    s.row = z * r->count[0] + y;
    return s;
}

/* ------------------------------------------------ rows.c, ranges.c, kept.c, wide.c */

enum { MOST_ROWS = 8 }; /* that a box may touch which is not wide */

/* How many rows a box touches. */
static inline uint64_t rows_in(const struct row_span *s)
{
    return ((uint64_t)s->more[0] + 1) * (s->more[1] + 1);
}

/* Where the reach of the first boxes of a row stands. */
static inline size_t reach_of(size_t row, size_t start) { return start / REACH + row; }

/* Where a row starts. */
static inline uint32_t row_start(const struct row_set *set, size_t row) { return row > 0 ? set->end[row - 1] : 0; }

/* Boxes that are not restless (restless.c): the rows hold them as they are. */
static inline int is_calm(const struct box *b) { return (b->flags & (BOX_LIVE | BOX_RESTLESS)) == BOX_LIVE; }

/* Asks a row, when n have been found in others. Returns how many are found then, or SIZE_MAX without room. */
typedef size_t (*ask_one_row_fn)(const void *context, struct worker *w, const struct row_question *q, size_t row,
                                 size_t n);

/* Receives pairs that are found. */
typedef void (*take_pairs_fn)(const void *context, struct worker *w, const struct pair_buffer *found);

void msap_wide_test(const struct pruning *p, const struct sweeps *sweeps, size_t first, size_t last,
                    take_pairs_fn take, const void *context, struct worker *w);

int msap_kept_are_told(const struct pruning *p);
int msap_kept_are_most(const struct pruning *p);
size_t msap_kept_words(const struct pruning *p);
uint64_t *msap_kept_place(struct pruning *p, uint64_t *words);
void msap_kept_merge(struct pruning *p, const uint32_t *coming);

int msap_restless_list(struct grid *g, struct job *job, struct pruning *p, const uint32_t *slot, size_t n);
int msap_calm(struct grid *g, struct job *job);

void msap_rows_choose(struct pruning *p, uint32_t commit, uint32_t most);
int msap_rows_count(struct pruning *p, struct scratch *words);
int msap_rows_count_few(struct pruning *p, const uint32_t *slot, size_t n, struct scratch *words);
int msap_rows_sort(struct pruning *p);
void msap_rows_list(struct pruning *p);
void msap_rows_fill(struct pruning *p);
int msap_rows_note_reach(struct row_set *set, const struct rows *r, struct memory *m);
void msap_rows_sweep(const struct row_set *set, const struct rows *r, sweep_row_fn sweep, size_t first,
                     size_t last, take_pairs_fn take, const void *context, struct worker *w);
void msap_rows_sweep_between(const struct row_set *set, const struct row_set *other, const struct rows *r,
                             sweep_between_fn sweep, size_t first, size_t last, take_pairs_fn take,
                             const void *context, struct worker *w);
size_t msap_rows_ask(const struct rows *r, const struct bounds *where, const struct row_question *q,
                     ask_one_row_fn ask, const void *context, struct worker *w, size_t n);

#endif
