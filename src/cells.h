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
static inline __m128i units_lanes(__m128 scale, __m128i ordered)
{
    __m128i bits = _mm_xor_si128(ordered, _mm_srli_epi32(_mm_srai_epi32(ordered, 31), 1));
    __m128 x = _mm_castsi128_ps(bits), most = _mm_set1_ps(MOST_UNITS), most_float = _mm_set1_ps(MOST_FLOAT);
    x = _mm_max_ps(_mm_min_ps(x, most_float), _mm_set1_ps(-MOST_FLOAT));
    x = _mm_mul_ps(x, scale);
    __m128 magnitude = _mm_andnot_ps(_mm_set1_ps(-0.0f), x);
    x = _mm_and_ps(x, _mm_cmpge_ps(magnitude, _mm_set1_ps(LEAST_UNITS)));
    x = _mm_max_ps(_mm_min_ps(x, most), _mm_set1_ps(-MOST_UNITS));
    __m128i whole = _mm_cvttps_epi32(x);
    return _mm_add_epi32(whole, _mm_castps_si128(_mm_cmplt_ps(x, _mm_cvtepi32_ps(whole))));
}

static inline void four_units(const float scale[4], const int32_t *ordered, int32_t units[4])
{
    _mm_storeu_si128((__m128i *)(void *)units, units_lanes(_mm_loadu_ps(scale), load_bounds(ordered)));
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
    struct range r = {{0}, {0}};
    units_of(l->scale, b->min, r.low);
    units_of(l->scale, b->max, r.high);
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
#if defined(__SSE2__)
static inline struct range range_on(const struct layout *layout, const struct range *base, uint32_t level)
{
    const __m128i shift = _mm_cvtsi32_si128((int)(LEVEL_SHIFT * level)), first = _mm_set1_epi32(-CELL_LIMIT);
    __m128i low = _mm_sra_epi32(load_bounds(base->low), shift),
            high = _mm_sra_epi32(load_bounds(base->high), shift);
    __m128i more = _mm_sub_epi32(high, low),
            last = _mm_sub_epi32(load_bounds((const int32_t *)layout->level[level].count), _mm_set1_epi32(1));
    __m128i is_all = _mm_or_si128(_mm_cmpgt_epi32(more, last), _mm_srai_epi32(more, 31)); /* at most 2^31 more */
    struct range r;
    _mm_storeu_si128((__m128i *)(void *)r.low, choose_lanes(is_all, first, low));
    _mm_storeu_si128((__m128i *)(void *)r.high, choose_lanes(is_all, _mm_add_epi32(first, last), high));
    return r;
}
#else
static inline struct range range_on(const struct layout *layout, const struct range *base, uint32_t level)
{
    const struct level *l = &layout->level[level];
    struct range r;
    for (uint32_t k = 0; k < 3; k++) {
        r.low[k] = floor_shift(base->low[k], LEVEL_SHIFT * level);
        r.high[k] = floor_shift(base->high[k], LEVEL_SHIFT * level);
        if ((uint32_t)r.high[k] - (uint32_t)r.low[k] < l->count[k]) continue;
        r.low[k] = -CELL_LIMIT;
        r.high[k] = (int32_t)l->count[k] - 1 - CELL_LIMIT;
    }
    return r;
}
#endif

/* ----------------------------------------------------------------- rounding */

/* Rounds fat bounds for the cells of a level. Boxes that overlap still do: what is rounded down or
 * counts as if it were less far out keeps its order, and a difference that is modulo 2^16 keeps its sign
 * while both boxes are short. Returns whether this one is; all that stand in cells are. */
#if defined(__SSE2__)
static inline __m128i steps_on(const struct level *l, const int32_t *steps, uint32_t level)
{
    __m128i at = _mm_sra_epi32(load_bounds(steps), _mm_cvtsi32_si128((int)(LEVEL_SHIFT * level)));
    __m128i first = load_bounds(l->first_step), last = load_bounds(l->last_step);
    __m128i below = _mm_cmpgt_epi32(first, at), above = _mm_cmpgt_epi32(at, last);
    return choose_lanes(above, last, choose_lanes(below, first, at));
}

static inline int rounded_on(const struct layout *l, uint32_t level, const struct spot *s, struct rounded *r)
{
    __m128i low = steps_on(&l->level[level], s->low, level), high = steps_on(&l->level[level], s->high, level);
    __m128i is_long = _mm_cmpgt_epi32(_mm_sub_epi32(high, low), _mm_set1_epi32(MOST_STEPS));
    low = _mm_srai_epi32(_mm_slli_epi32(low, 16), 16);
    high = _mm_srai_epi32(_mm_slli_epi32(_mm_sub_epi32(_mm_setzero_si128(), high), 16), 16);
    _mm_storeu_si128((__m128i *)(void *)r, _mm_packs_epi32(low, high));
    return !(_mm_movemask_ps(_mm_castsi128_ps(is_long)) & 7);
}
#else
static inline int32_t step_on(const struct level *l, uint32_t k, int32_t step, uint32_t level)
{
    step = floor_shift(step, LEVEL_SHIFT * level);
    return step < l->first_step[k] ? l->first_step[k] : step > l->last_step[k] ? l->last_step[k] : step;
}

static inline int rounded_on(const struct layout *l, uint32_t level, const struct spot *s, struct rounded *r)
{
    int is_short = 1;
    for (uint32_t k = 0; k < 3; k++) {
        int32_t low = step_on(&l->level[level], k, s->low[k], level);
        int32_t high = step_on(&l->level[level], k, s->high[k], level);
        is_short &= high - low <= MOST_STEPS;
        r->low[k] = (uint16_t)low;
        r->high[k] = (uint16_t)(0u - (uint32_t)high);
    }
    return is_short;
}
#endif

static inline int is_same_range(const struct range *a, const struct range *b)
{
    return memcmp(a->low, b->low, 3 * sizeof *a->low) == 0 && memcmp(a->high, b->high, 3 * sizeof *a->high) == 0;
}

/* ------------------------------------------------------------------- cells */

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

/* ------------------------------------------------------- the cells of a box */

static inline struct span span_on(const struct layout *l, const struct range *base, uint32_t level)
{
    struct range r = range_on(l, base, level);
    struct span s = {{0}, {0}, (uint8_t)level, 0};
    for (int k = 0; k < 3; k++) {
        s.low[k] = (uint16_t)wrap(r.low[k], l->level[level].count[k]);
        s.more[k] = (uint8_t)(r.high[k] - r.low[k]);
    }
    return s;
}

/* From a cell to the next one on an axis, which are so many apart, around the end. */
static inline uint32_t step_from(uint32_t at, uint32_t count, uint32_t apart)
{
    return at + 1 < count ? apart : apart - count * apart;
}

/* The same as cells_of for a span of two cells on each axis at the most, without a question: how
 * many they are follows no pattern. */
static inline uint32_t cells_of_few(const struct span *s, uint32_t first, const uint32_t count[3],
                                    uint32_t cell[MOST_CELLS])
{
    uint32_t x = step_from(s->low[0], count[0], 1), y = step_from(s->low[1], count[1], count[0]),
             z = step_from(s->low[2], count[2], count[0] * count[1]), n = 1u << s->more[0];
    cell[0] = first + (s->low[2] * count[1] + s->low[1]) * count[0] + s->low[0];
    cell[1] = cell[0] + x;
    for (uint32_t i = 0; i < 2; i++) cell[n + i] = cell[i] + y;
    n <<= s->more[1];
    for (uint32_t i = 0; i < 4; i++) cell[n + i] = cell[i] + z;
    return n << s->more[2];
}

/* Writes the numbers, among all, of the cells of a span; returns how many they are. */
static inline uint32_t cells_of(const struct layout *l, const struct span *s, uint32_t cell[MOST_CELLS])
{
    const struct level *level = &l->level[s->level];
    const uint32_t *count = level->count, first = (uint32_t)(level->cell - l->cell);
    uint32_t n = 0;
    if ((s->more[0] | s->more[1] | s->more[2]) <= 1) return cells_of_few(s, first, count, cell);
    for (uint32_t k = 0, z = s->low[2]; k <= s->more[2]; k++, z = z + 1 < count[2] ? z + 1 : 0)
        for (uint32_t j = 0, y = s->low[1]; j <= s->more[1]; j++, y = y + 1 < count[1] ? y + 1 : 0)
            for (uint32_t i = 0, x = s->low[0]; i <= s->more[0]; i++, x = x + 1 < count[0] ? x + 1 : 0)
                cell[n++] = first + (z * count[1] + y) * count[0] + x;
    return n;
}

/* Where fat bounds are to be in a layout, but for their cells. */
static inline void steps_of(const struct layout *l, const struct bounds *fat, struct spot *s)
{
    s->base = range_of(l, fat);
    units_of(l->fine, fat->min, s->low);
    units_of(l->fine, fat->max, s->high);
    s->level = msap_level_for(&s->base);
    rounded_on(l, s->level, s, &s->rounded);
}

/* Where fat bounds are to be in a layout. */
static inline void spot_of(const struct layout *l, const struct bounds *fat, struct spot *s)
{
    steps_of(l, fat, s);
    struct span span = span_on(l, &s->base, s->level);
    s->cells = cells_of(l, &span, s->cell);
}

#endif
