/* From bounds to cells: the innermost steps of a grid, inline.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Cell numbers are found without rounding, so that a box is always looked for where
 * it was put: a power of two scales the coordinate to units, what lies beyond 2^30
 * units counts as 2^30, and what is nearer to 0 than 2^-30 units counts as 0, whether
 * or not the host's floating point flushes subnormals. */
#ifndef MSAP_CELLS_H
#define MSAP_CELLS_H

#include "internal.h"

/* ------------------------------------------------------------------- units */

#define MOST_UNITS 1073741824.0f
#define LEAST_UNITS (1.0f / 1073741824.0f)
#define MOST_FLOAT 3.402823466e38f

/* floor(x * scale) of four. */
#if defined(__SSE2__)
static inline void four_units(const float scale[4], const int32_t *ordered, int32_t units[4])
{
    __m128i bits = load_bounds(ordered);
    bits = _mm_xor_si128(bits, _mm_srli_epi32(_mm_srai_epi32(bits, 31), 1));
    __m128 x = _mm_castsi128_ps(bits), most = _mm_set1_ps(MOST_UNITS), most_float = _mm_set1_ps(MOST_FLOAT);
    x = _mm_max_ps(_mm_min_ps(x, most_float), _mm_set1_ps(-MOST_FLOAT));
    x = _mm_mul_ps(x, _mm_loadu_ps(scale));
    __m128 magnitude = _mm_andnot_ps(_mm_set1_ps(-0.0f), x);
    x = _mm_and_ps(x, _mm_cmpge_ps(magnitude, _mm_set1_ps(LEAST_UNITS)));
    x = _mm_max_ps(_mm_min_ps(x, most), _mm_set1_ps(-MOST_UNITS));
    __m128i whole = _mm_cvttps_epi32(x);
    whole = _mm_add_epi32(whole, _mm_castps_si128(_mm_cmplt_ps(x, _mm_cvtepi32_ps(whole))));
    _mm_storeu_si128((__m128i *)(void *)units, whole);
}

/* floor(x * scale) on all axes. */
static inline void units_of(const float scale[4], const int32_t *ordered, int32_t units[4])
{
    four_units(scale, ordered, units);
}
#else
static inline int32_t unit_of(float scale, int32_t ordered)
{
    float x = float_from_bits(float_bits_from_ordered(ordered));
    x = x > MOST_FLOAT ? MOST_FLOAT : x < -MOST_FLOAT ? -MOST_FLOAT : x;
    x *= scale;
    if (!(x >= LEAST_UNITS || x <= -LEAST_UNITS)) x = 0;
    x = x > MOST_UNITS ? MOST_UNITS : x < -MOST_UNITS ? -MOST_UNITS : x;
    return (int32_t)x - ((float)(int32_t)x > x);
}

static inline void four_units(const float scale[4], const int32_t *ordered, int32_t units[4])
{
    for (int i = 0; i < 4; i++) units[i] = unit_of(scale[i], ordered[i]);
}

static inline void units_of(const float scale[4], const int32_t *ordered, int32_t units[4])
{
    for (int k = 0; k < 3; k++) units[k] = unit_of(scale[k], ordered[k]);
}
#endif

/* ------------------------------------------------------------------ ranges */

/* The cells of level 0 that a box touches; its bounds stand in a larger struct, as all
 * that vectors read do (bounds.h). */
static inline struct range range_of(const struct layout *l, const struct bounds *b)
{
    int32_t low[4], high[4];
    units_of(l->scale, b->min, low);
    units_of(l->scale, b->max, high);
    struct range r = {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
    return l->is_told ? msap_range_as_told(l, r) : r;
}

/* floor(a / 2^shift) */
static inline int32_t floor_shift(int32_t a, uint32_t shift)
{
    uint32_t sign = 0 - (uint32_t)(a < 0); /* no branch: half of all coordinates are negative */
    return (int32_t)(((uint32_t)a ^ sign) >> shift ^ sign);
}

/* The same on another level, without naming a wrapped cell twice: a range around all
 * cells starts below every other. */
static inline struct range range_on(const struct layout *layout, struct range base, uint32_t level)
{
    const struct level *l = &layout->level[level];
    uint32_t shift = LEVEL_SHIFT * level;
    for (uint32_t k = 0; k < 3; k++) {
        if (level > 0) {
            base.low[k] = floor_shift(base.low[k], shift);
            base.high[k] = floor_shift(base.high[k], shift);
        }
        if ((uint32_t)base.high[k] - (uint32_t)base.low[k] < l->count[k]) continue;
        base.low[k] = -CELL_LIMIT;
        base.high[k] = (int32_t)l->count[k] - 1 - CELL_LIMIT;
    }
    return base;
}

static inline uint32_t wrap(int32_t at, uint32_t count)
{
    if ((count & (count - 1)) == 0) return (uint32_t)at & (count - 1);
    int64_t rest = (int64_t)at % (int64_t)count;
    return (uint32_t)(rest < 0 ? rest + count : rest);
}

/* The cells of a level at some height and depth. */
static inline struct cell *cell_row(const struct level *l, int32_t y, int32_t z)
{
    return l->cell + (wrap(z, l->count[2]) * (size_t)l->count[1] + wrap(y, l->count[1])) * l->count[0];
}

static inline struct cell *cell_at(const struct level *l, const int32_t at[3])
{
    return cell_row(l, at[1], at[2]) + wrap(at[0], l->count[0]);
}

/* Visits the cells of a range row by row. */
struct cell_walk {
    const struct level *level;
    struct range range;
    int32_t x, y, z; /* of the next cell */
    struct cell *row;
};

static inline struct cell_walk cell_walk(const struct level *l, struct range r)
{
    struct cell_walk w = {l, r, r.low[0], r.low[1], r.low[2], cell_row(l, r.low[1], r.low[2])};
    return w;
}

/* Goes to the next row of the range; returns 0 behind the last. */
static inline int cell_walk_row(struct cell_walk *w)
{
    if (++w->y > w->range.high[1]) {
        w->y = w->range.low[1];
        if (++w->z > w->range.high[2]) return 0;
    }
    w->x = w->range.low[0];
    w->row = cell_row(w->level, w->y, w->z);
    return 1;
}

/* The next cell, or NULL. */
static inline struct cell *cell_next(struct cell_walk *w)
{
    if (w->x > w->range.high[0] && !cell_walk_row(w)) return NULL;
    return &w->row[wrap(w->x++, w->level->count[0])];
}

#endif
