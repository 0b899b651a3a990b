/* The sweep over a cell: eight boxes at a time where the machine can.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each function gives the slots, among rows first ... last - 1, whose bounds overlap
 * those asked for, in the order of the rows; all give the same. Of a block of eight,
 * what lies outside those rows is read and left out. */
#include "internal.h"

/* The columns of a block of rows from `block` on that are among first ... last - 1. */
static inline uint32_t columns_in(uint32_t block, uint32_t first, uint32_t last)
{
    uint32_t columns = 255;
    if (first > block) columns &= 255u << (first - block);
    if (last - block < 8) columns &= (1u << (last - block)) - 1;
    return columns;
}

static size_t sweep_portable(const struct cell *c, uint32_t first, uint32_t last, const struct bounds *b,
                             uint32_t *out)
{
    size_t n = 0;
    for (uint32_t row = first; row < last; row++) {
        const struct cell_block *at = &c->block[row / 8];
        uint32_t i = row % 8;
        int apart = (at->min[0][i] > b->max[0]) | (at->min[1][i] > b->max[1]) | (at->min[2][i] > b->max[2]) |
                    (b->min[0] > at->max[0][i]) | (b->min[1] > at->max[1][i]) | (b->min[2] > at->max[2][i]);
        out[n] = at->id[i];
        n += !apart;
    }
    return n;
}

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

#define LOAD128(array) _mm_loadu_si128((const __m128i *)(const void *)(array))
#define LOAD256(array) _mm256_loadu_si256((const __m256i *)(const void *)(array))

/* The columns of half a block, from `half` on, that overlap. */
static inline uint32_t overlapping128(const struct cell_block *at, int half, const __m128i min[3],
                                      const __m128i max[3])
{
    __m128i apart = _mm_setzero_si128();
    for (int k = 0; k < 3; k++) {
        __m128i below = _mm_cmpgt_epi32(LOAD128(at->min[k] + half), max[k]);
        apart = _mm_or_si128(apart, _mm_or_si128(below, _mm_cmpgt_epi32(min[k], LOAD128(at->max[k] + half))));
    }
    return ~(uint32_t)_mm_movemask_ps(_mm_castsi128_ps(apart)) & 15;
}

static size_t sweep_sse2(const struct cell *c, uint32_t first, uint32_t last, const struct bounds *b,
                         uint32_t *out)
{
    size_t n = 0;
    __m128i min[3], max[3];
    for (int k = 0; k < 3; k++) {
        min[k] = _mm_set1_epi32(b->min[k]);
        max[k] = _mm_set1_epi32(b->max[k]);
    }
    for (uint32_t row = first & ~7u; row < last; row += 8) {
        const struct cell_block *at = &c->block[row / 8];
        uint32_t found = overlapping128(at, 0, min, max) | overlapping128(at, 4, min, max) << 4;
        for (found &= columns_in(row, first, last); found; found &= found - 1)
            out[n++] = at->id[(uint32_t)__builtin_ctz(found)];
    }
    return n;
}

__attribute__((target("avx2"))) static size_t sweep_avx2(const struct cell *c, uint32_t first, uint32_t last,
                                                         const struct bounds *b, uint32_t *out)
{
    size_t n = 0;
    __m256i min[3], max[3];
    for (int k = 0; k < 3; k++) {
        min[k] = _mm256_set1_epi32(b->min[k]);
        max[k] = _mm256_set1_epi32(b->max[k]);
    }
    for (uint32_t row = first & ~7u; row < last; row += 8) {
        const struct cell_block *at = &c->block[row / 8];
        __m256i apart = _mm256_setzero_si256();
        for (int k = 0; k < 3; k++) {
            __m256i below = _mm256_cmpgt_epi32(LOAD256(at->min[k]), max[k]);
            apart =
                _mm256_or_si256(apart, _mm256_or_si256(below, _mm256_cmpgt_epi32(min[k], LOAD256(at->max[k]))));
        }
        uint32_t found = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(apart));
        for (found &= columns_in(row, first, last); found; found &= found - 1)
            out[n++] = at->id[(uint32_t)__builtin_ctz(found)];
    }
    return n;
}
#endif

/* ------------------------------------------------------------- sweeping rows */

static size_t sweep_row_portable(const struct row_set *s, uint32_t i, uint32_t end, uint32_t *out)
{
    int32_t stop = s->max[0][i], min1 = s->min[1][i], max1 = s->max[1][i], min2 = s->min[2][i],
            max2 = s->max[2][i];
    size_t n = 0;
    for (uint32_t j = i + 1; j < end && s->min[0][j] <= stop; j++) {
        out[n] = s->id[j];
        n += !((s->min[1][j] > max1) | (min1 > s->max[1][j]) | (s->min[2][j] > max2) | (min2 > s->max[2][j]));
    }
    return n;
}

#if defined(__x86_64__) && defined(__GNUC__)
static size_t sweep_row_sse2(const struct row_set *s, uint32_t i, uint32_t end, uint32_t *out)
{
    __m128i stop = _mm_set1_epi32(s->max[0][i]);
    __m128i min1 = _mm_set1_epi32(s->min[1][i]), max1 = _mm_set1_epi32(s->max[1][i]);
    __m128i min2 = _mm_set1_epi32(s->min[2][i]), max2 = _mm_set1_epi32(s->max[2][i]);
    size_t n = 0;
    for (uint32_t j = i + 1; j < end; j += 4) {
        __m128i past = _mm_cmpgt_epi32(LOAD128(s->min[0] + j), stop);
        __m128i apart = _mm_or_si128(_mm_or_si128(_mm_cmpgt_epi32(LOAD128(s->min[1] + j), max1),
                                                  _mm_cmpgt_epi32(min1, LOAD128(s->max[1] + j))),
                                     _mm_or_si128(_mm_cmpgt_epi32(LOAD128(s->min[2] + j), max2),
                                                  _mm_cmpgt_epi32(min2, LOAD128(s->max[2] + j))));
        uint32_t found = ~(uint32_t)_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(past, apart))) & 15;
        if (end - j < 4) found &= (1u << (end - j)) - 1;
        for (; found; found &= found - 1) out[n++] = s->id[j + (uint32_t)__builtin_ctz(found)];
        if (_mm_movemask_ps(_mm_castsi128_ps(past))) break;
    }
    return n;
}

__attribute__((target("avx2"))) static size_t sweep_row_avx2(const struct row_set *s, uint32_t i, uint32_t end,
                                                             uint32_t *out)
{
    __m256i stop = _mm256_set1_epi32(s->max[0][i]);
    __m256i min1 = _mm256_set1_epi32(s->min[1][i]), max1 = _mm256_set1_epi32(s->max[1][i]);
    __m256i min2 = _mm256_set1_epi32(s->min[2][i]), max2 = _mm256_set1_epi32(s->max[2][i]);
    size_t n = 0;
    for (uint32_t j = i + 1; j < end; j += 8) {
        __m256i past = _mm256_cmpgt_epi32(LOAD256(s->min[0] + j), stop);
        __m256i apart1 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[1] + j), max1),
                                         _mm256_cmpgt_epi32(min1, LOAD256(s->max[1] + j)));
        __m256i apart2 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[2] + j), max2),
                                         _mm256_cmpgt_epi32(min2, LOAD256(s->max[2] + j)));
        __m256i apart = _mm256_or_si256(past, _mm256_or_si256(apart1, apart2));
        uint32_t found = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(apart)) & 255;
        if (end - j < 8) found &= (1u << (end - j)) - 1;
        for (; found; found &= found - 1) out[n++] = s->id[j + (uint32_t)__builtin_ctz(found)];
        if (_mm256_movemask_ps(_mm256_castsi256_ps(past))) break;
    }
    return n;
}
#endif

sweep_row_fn msap_sweep_row_for(uint32_t simd)
{
#if defined(__x86_64__) && defined(__GNUC__)
    if ((simd == MSAP_SIMD_AUTO || simd >= MSAP_SIMD_256) && __builtin_cpu_supports("avx2")) return sweep_row_avx2;
    if (simd != MSAP_SIMD_NONE) return sweep_row_sse2;
#endif
    (void)simd;
    return sweep_row_portable;
}

/* The best sweep that the machine has, not above `simd`. */
sweep_fn msap_sweep_for(uint32_t simd)
{
#if defined(__x86_64__) && defined(__GNUC__)
    if ((simd == MSAP_SIMD_AUTO || simd >= MSAP_SIMD_256) && __builtin_cpu_supports("avx2")) return sweep_avx2;
    if (simd != MSAP_SIMD_NONE) return sweep_sse2;
#endif
    (void)simd;
    return sweep_portable;
}
