/* The sweep over a cell: eight boxes at a time where the machine can.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each function gives the slots, among rows first ... last - 1, whose bounds
 * overlap those asked for, in the order of the rows; all give the same. The
 * arrays of bounds may be read up to seven elements past a row, never past the
 * cell's memory, since the array of slots comes last and is read one by one. */
#include "internal.h"

static size_t sweep_portable(const struct cell *c, uint32_t first, uint32_t last, const struct bounds *b,
                             uint32_t *out)
{
    const int32_t *at = c->at;
    size_t room = c->room, n = 0;
    const uint32_t *id = (const uint32_t *)(const void *)(at + 6 * room);
    for (size_t i = first; i < last; i++) {
        int apart = (at[i] > b->max[0]) | (at[room + i] > b->max[1]) | (at[2 * room + i] > b->max[2]) |
                    (b->min[0] > at[3 * room + i]) | (b->min[1] > at[4 * room + i]) |
                    (b->min[2] > at[5 * room + i]);
        out[n] = id[i];
        n += !apart;
    }
    return n;
}

#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>

static size_t sweep_sse2(const struct cell *c, uint32_t first, uint32_t last, const struct bounds *b,
                         uint32_t *out)
{
    const int32_t *at = c->at;
    size_t room = c->room, n = 0;
    const uint32_t *id = (const uint32_t *)(const void *)(at + 6 * room);
    __m128i min[3], max[3];
    for (int k = 0; k < 3; k++) {
        min[k] = _mm_set1_epi32(b->min[k]);
        max[k] = _mm_set1_epi32(b->max[k]);
    }
    for (size_t i = first; i < last; i += 4) {
        __m128i apart = _mm_setzero_si128();
        for (size_t k = 0; k < 3; k++) {
            __m128i low = _mm_loadu_si128((const __m128i *)(const void *)(at + k * room + i));
            __m128i high = _mm_loadu_si128((const __m128i *)(const void *)(at + (3 + k) * room + i));
            apart = _mm_or_si128(apart, _mm_or_si128(_mm_cmpgt_epi32(low, max[k]), _mm_cmpgt_epi32(min[k], high)));
        }
        uint32_t found = ~(uint32_t)_mm_movemask_ps(_mm_castsi128_ps(apart)) & 15;
        if (last - i < 4) found &= (1u << (last - i)) - 1;
        for (; found; found &= found - 1) out[n++] = id[i + (uint32_t)__builtin_ctz(found)];
    }
    return n;
}

__attribute__((target("avx2"))) static size_t sweep_avx2(const struct cell *c, uint32_t first, uint32_t last,
                                                         const struct bounds *b, uint32_t *out)
{
    const int32_t *at = c->at;
    size_t room = c->room, n = 0;
    const uint32_t *id = (const uint32_t *)(const void *)(at + 6 * room);
    __m256i min[3], max[3];
    for (int k = 0; k < 3; k++) {
        min[k] = _mm256_set1_epi32(b->min[k]);
        max[k] = _mm256_set1_epi32(b->max[k]);
    }
    for (size_t i = first; i < last; i += 8) {
        __m256i apart = _mm256_setzero_si256();
        for (size_t k = 0; k < 3; k++) {
            __m256i low = _mm256_loadu_si256((const __m256i *)(const void *)(at + k * room + i));
            __m256i high = _mm256_loadu_si256((const __m256i *)(const void *)(at + (3 + k) * room + i));
            apart = _mm256_or_si256(
                apart, _mm256_or_si256(_mm256_cmpgt_epi32(low, max[k]), _mm256_cmpgt_epi32(min[k], high)));
        }
        uint32_t found = ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(apart)) & 255;
        if (last - i < 8) found &= (1u << (last - i)) - 1;
        for (; found; found &= found - 1) out[n++] = id[i + (uint32_t)__builtin_ctz(found)];
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
#define LOAD128(array, j) _mm_loadu_si128((const __m128i *)(const void *)&(array)[j])
#define LOAD256(array, j) _mm256_loadu_si256((const __m256i *)(const void *)&(array)[j])

static size_t sweep_row_sse2(const struct row_set *s, uint32_t i, uint32_t end, uint32_t *out)
{
    __m128i stop = _mm_set1_epi32(s->max[0][i]);
    __m128i min1 = _mm_set1_epi32(s->min[1][i]), max1 = _mm_set1_epi32(s->max[1][i]);
    __m128i min2 = _mm_set1_epi32(s->min[2][i]), max2 = _mm_set1_epi32(s->max[2][i]);
    size_t n = 0;
    for (uint32_t j = i + 1; j < end; j += 4) {
        __m128i past = _mm_cmpgt_epi32(LOAD128(s->min[0], j), stop);
        __m128i apart = _mm_or_si128(_mm_or_si128(_mm_cmpgt_epi32(LOAD128(s->min[1], j), max1),
                                                  _mm_cmpgt_epi32(min1, LOAD128(s->max[1], j))),
                                     _mm_or_si128(_mm_cmpgt_epi32(LOAD128(s->min[2], j), max2),
                                                  _mm_cmpgt_epi32(min2, LOAD128(s->max[2], j))));
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
        __m256i past = _mm256_cmpgt_epi32(LOAD256(s->min[0], j), stop);
        __m256i apart1 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[1], j), max1),
                                         _mm256_cmpgt_epi32(min1, LOAD256(s->max[1], j)));
        __m256i apart2 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[2], j), max2),
                                         _mm256_cmpgt_epi32(min2, LOAD256(s->max[2], j)));
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
