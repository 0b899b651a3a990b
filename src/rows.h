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

#endif
