/* The sweep over a cell: eight boxes at a time where the machine can.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each function gives the slots, among rows first ... last - 1, whose bounds overlap
 * those asked for, in the order of the rows; all give the same. Of a block of eight,
 * what lies outside those rows is read and left out. So it is with the sweeps over the
 * rows of jump.c below. */
#include "internal.h"

/* The columns of a block of rows from `block` on that are among first ... last - 1. */
static inline uint32_t columns_in(uint32_t block, uint32_t first, uint32_t last)
{
    uint32_t before = first > block ? first - block : 0, left = last - block < 8 ? last - block : 8;
    return 255u << before & 255u >> (8 - left);
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

/* Four integers, on the machines that have them at all times: SSE2, NEON. */
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define HAS_AVX2 1
#define HAS_FOUR 1

typedef __m128i four, four_mask;
static inline four four_at(const int32_t *at) { return _mm_loadu_si128((const __m128i *)(const void *)at); }
static inline four four_of(int32_t value) { return _mm_set1_epi32(value); }
static inline four_mask above(four a, four b) { return _mm_cmpgt_epi32(a, b); }
static inline four_mask either(four_mask a, four_mask b) { return _mm_or_si128(a, b); }
static inline four both(four a, four b) { return _mm_and_si128(a, b); }
static inline four_mask same(four a, four b) { return _mm_cmpeq_epi32(a, b); }
static inline uint32_t bits_of(four_mask m) { return (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(m)); }
#elif defined(__aarch64__) && defined(__GNUC__)
#include <arm_neon.h>
#define HAS_FOUR 1

typedef int32x4_t four;
typedef uint32x4_t four_mask;
static inline four four_at(const int32_t *at) { return vld1q_s32(at); }
static inline four four_of(int32_t value) { return vdupq_n_s32(value); }
static inline four_mask above(four a, four b) { return vcgtq_s32(a, b); }
static inline four_mask either(four_mask a, four_mask b) { return vorrq_u32(a, b); }
static inline four both(four a, four b) { return vandq_s32(a, b); }
static inline four_mask same(four a, four b) { return vceqq_s32(a, b); }
static inline uint32_t bits_of(four_mask m)
{
    static const uint32_t bit[4] = {1, 2, 4, 8};
    return vaddvq_u32(vandq_u32(m, vld1q_u32(bit)));
}
#endif

#if defined(HAS_FOUR)
/* The columns of half a block, from `half` on, that overlap. */
static inline uint32_t overlapping(const struct cell_block *at, int half, const four min[3], const four max[3])
{
    four_mask x = either(above(four_at(at->min[0] + half), max[0]), above(min[0], four_at(at->max[0] + half)));
    four_mask y = either(above(four_at(at->min[1] + half), max[1]), above(min[1], four_at(at->max[1] + half)));
    four_mask z = either(above(four_at(at->min[2] + half), max[2]), above(min[2], four_at(at->max[2] + half)));
    return ~bits_of(either(either(x, y), z)) & 15;
}

static size_t sweep_fours(const struct cell *c, uint32_t first, uint32_t last, const struct bounds *b,
                          uint32_t *out)
{
    size_t n = 0;
    const four min[3] = {four_of(b->min[0]), four_of(b->min[1]), four_of(b->min[2])};
    const four max[3] = {four_of(b->max[0]), four_of(b->max[1]), four_of(b->max[2])};
    for (uint32_t row = first & ~7u; row < last; row += 8) {
        const struct cell_block *at = &c->block[row / 8];
        uint32_t found = overlapping(at, 0, min, max) | overlapping(at, 4, min, max) << 4;
        for (found &= columns_in(row, first, last); found; found &= found - 1)
            out[n++] = at->id[(uint32_t)__builtin_ctz(found)];
    }
    return n;
}
#endif

#if defined(HAS_AVX2)
#define LOAD256(array) _mm256_loadu_si256((const __m256i *)(const void *)(array))

/* For each set of columns, its columns in order, a byte each. */
#define HAS(set, column) (((set) >> (column)) & 1)
#define BEFORE(set, column) \
    (((column) > 0 && HAS(set, 0)) + ((column) > 1 && HAS(set, 1)) + ((column) > 2 && HAS(set, 2)) + \
     ((column) > 3 && HAS(set, 3)) + ((column) > 4 && HAS(set, 4)) + ((column) > 5 && HAS(set, 5)) + \
     ((column) > 6 && HAS(set, 6)))
#define PLACED(set, column) ((uint64_t)(HAS(set, column) * (column)) << 8 * BEFORE(set, column))
#define ORDER(set) \
    (PLACED(set, 1) | PLACED(set, 2) | PLACED(set, 3) | PLACED(set, 4) | PLACED(set, 5) | PLACED(set, 6) | \
     PLACED(set, 7))
#define ORDER_4(set) ORDER(set), ORDER((set) + 1), ORDER((set) + 2), ORDER((set) + 3)
#define ORDER_16(set) ORDER_4(set), ORDER_4((set) + 4), ORDER_4((set) + 8), ORDER_4((set) + 12)
#define ORDER_64(set) ORDER_16(set), ORDER_16((set) + 16), ORDER_16((set) + 32), ORDER_16((set) + 48)
static const uint64_t order[256] = {ORDER_64(0), ORDER_64(64), ORDER_64(128), ORDER_64(192)};

/* Writes those of eight values whose bits are set, and behind them what means nothing: eight in
 * all, without a branch. Returns how many they are. */
__attribute__((target("avx2"))) static inline size_t put_found(uint32_t *out, __m256i values, uint32_t found)
{
    __m128i columns = _mm_loadl_epi64((const __m128i *)(const void *)&order[found]);
    __m256i packed = _mm256_permutevar8x32_epi32(values, _mm256_cvtepu8_epi32(columns));
    _mm256_storeu_si256((__m256i *)(void *)out, packed);
    return (size_t)__builtin_popcount(found);
}

/* The columns of a block that are apart on axis k. */
#define APART256(at, k)                                                \
    _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256((at)->min[k]), max[k]), \
                    _mm256_cmpgt_epi32(min[k], LOAD256((at)->max[k])))

/* 0 to 7 */
#define COLUMNS256 _mm256_set_epi32(7, 6, 5, 4, 3, 2, 1, 0)

__attribute__((target("avx2"))) static size_t sweep_avx2(const struct cell *c, uint32_t first, uint32_t last,
                                                         const struct bounds *b, uint32_t *out)
{
    size_t n = 0;
    const __m256i min[3] = {_mm256_set1_epi32(b->min[0]), _mm256_set1_epi32(b->min[1]),
                            _mm256_set1_epi32(b->min[2])};
    const __m256i max[3] = {_mm256_set1_epi32(b->max[0]), _mm256_set1_epi32(b->max[1]),
                            _mm256_set1_epi32(b->max[2])};
    const __m256i from = _mm256_set1_epi32((int32_t)first), to = _mm256_set1_epi32((int32_t)last - 1);
    __m256i row_numbers = _mm256_add_epi32(_mm256_set1_epi32((int32_t)(first & ~7u)), COLUMNS256);
    for (uint32_t row = first & ~7u; row < last; row += 8) {
        const struct cell_block *at = &c->block[row / 8];
        __m256i apart = _mm256_or_si256(_mm256_or_si256(APART256(at, 0), APART256(at, 1)), APART256(at, 2));
        __m256i outside =
            _mm256_or_si256(_mm256_cmpgt_epi32(from, row_numbers), _mm256_cmpgt_epi32(row_numbers, to));
        apart = _mm256_or_si256(apart, outside);
        row_numbers = _mm256_add_epi32(row_numbers, _mm256_set1_epi32(8));
        n += put_found(out + n, LOAD256(at->id), 255 & ~(uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(apart)));
    }
    return n;
}
#endif

/* ------------------------------------------------------------- sweeping rows */

static void sweep_row_portable(const struct row_set *s, struct row_sweep *at, struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    uint32_t i = at->i, j = at->j;
    for (out->n = 0; i < last; i++, j = i + 1) {
        int32_t stop = s->max[0][i], min1 = s->min[1][i], max1 = s->max[1][i], min2 = s->min[2][i],
                max2 = s->max[2][i];
        for (; j < end && s->min[0][j] <= stop && out->n < MOST_BUFFERED; j++) {
            int apart =
                (s->min[1][j] > max1) | (min1 > s->max[1][j]) | (s->min[2][j] > max2) | (min2 > s->max[2][j]);
            out->a[out->n] = s->id[i] & ~ROW_MARKS;
            out->b[out->n] = s->id[j] & ~ROW_MARKS;
            out->n += !apart & (((s->id[i] | s->id[j]) & ROW_MARKS) == ROW_MARKS);
        }
        if (out->n == MOST_BUFFERED) break;
    }
    at->i = i;
    at->j = j;
}

#if defined(HAS_FOUR)
static void sweep_row_fours(const struct row_set *s, struct row_sweep *at, struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    uint32_t i = at->i, j = at->j;
    size_t n = 0;
    for (; i < last; i++, j = i + 1) {
        uint32_t found, is_past = 0;
        four lacks = four_of((int32_t)(~s->id[i] & ROW_MARKS));
        four stop = four_of(s->max[0][i]);
        four min1 = four_of(s->min[1][i]), max1 = four_of(s->max[1][i]);
        four min2 = four_of(s->min[2][i]), max2 = four_of(s->max[2][i]);
        for (; j < end && !is_past && n <= MOST_BUFFERED - 4; j += 4) {
            four_mask past = above(four_at(s->min[0] + j), stop);
            four_mask y = either(above(four_at(s->min[1] + j), max1), above(min1, four_at(s->max[1] + j)));
            four_mask z = either(above(four_at(s->min[2] + j), max2), above(min2, four_at(s->max[2] + j)));
            four id = four_at((const int32_t *)(const void *)(s->id + j));
            found = bits_of(same(both(id, lacks), lacks)) & ~bits_of(either(past, either(y, z)));
            is_past = bits_of(past);
            if (end - j < 4) found &= (1u << (end - j)) - 1;
            for (; found; found &= found - 1) {
                out->a[n] = s->id[i] & ~ROW_MARKS;
                out->b[n++] = s->id[j + (uint32_t)__builtin_ctz(found)] & ~ROW_MARKS;
            }
        }
        if (j < end && !is_past) break;
    }
    at->i = i;
    at->j = j;
    out->n = n;
}
#endif

#if defined(HAS_AVX2)
__attribute__((target("avx2"))) static void sweep_row_avx2(const struct row_set *s, struct row_sweep *at,
                                                           struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    const __m256i marks = _mm256_set1_epi32((int32_t)ROW_MARKS);
    uint32_t i = at->i, j = at->j;
    size_t n = 0;
    for (; i < last; i++, j = i + 1) {
        uint32_t is_past = 0;
        __m256i self = _mm256_set1_epi32((int32_t)(s->id[i] & ~ROW_MARKS));
        __m256i lacks = _mm256_set1_epi32((int32_t)(~s->id[i] & ROW_MARKS));
        __m256i stop = _mm256_set1_epi32(s->max[0][i]);
        __m256i min1 = _mm256_set1_epi32(s->min[1][i]), max1 = _mm256_set1_epi32(s->max[1][i]);
        __m256i min2 = _mm256_set1_epi32(s->min[2][i]), max2 = _mm256_set1_epi32(s->max[2][i]);
        for (; j < end && !is_past && n <= MOST_BUFFERED - 8; j += 8) {
            __m256i past = _mm256_cmpgt_epi32(LOAD256(s->min[0] + j), stop);
            __m256i apart1 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[1] + j), max1),
                                             _mm256_cmpgt_epi32(min1, LOAD256(s->max[1] + j)));
            __m256i apart2 = _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(s->min[2] + j), max2),
                                             _mm256_cmpgt_epi32(min2, LOAD256(s->max[2] + j)));
            __m256i apart = _mm256_or_si256(past, _mm256_or_si256(apart1, apart2)), ids = LOAD256(s->id + j);
            __m256i has = _mm256_cmpeq_epi32(_mm256_and_si256(ids, lacks), lacks);
            uint32_t found = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_andnot_si256(apart, has)));
            is_past = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(past));
            if (end - j < 8) found &= (1u << (end - j)) - 1;
            _mm256_storeu_si256((__m256i *)(void *)(out->a + n), self);
            n += put_found(out->b + n, _mm256_andnot_si256(marks, ids), found);
        }
        if (j < end && !is_past) break;
    }
    at->i = i;
    at->j = j;
    out->n = n;
}
#endif

#if defined(HAS_AVX2)
static int use_avx2(uint32_t simd)
{
    int may = simd == MSAP_SIMD_AUTO || simd >= MSAP_SIMD_256;
    return may && __builtin_cpu_supports("avx2"); /* GCOVR_EXCL_BR_LINE: never false where there is AVX2 */
}
#endif

/* The best sweep that the machine has, not above `simd`. */
sweep_fn msap_sweep_for(uint32_t simd)
{
#if defined(HAS_AVX2)
    if (use_avx2(simd)) return sweep_avx2;
#endif
#if defined(HAS_FOUR)
    if (simd != MSAP_SIMD_NONE) return sweep_fours;
#endif
    (void)simd;
    return sweep_portable;
}

sweep_row_fn msap_sweep_row_for(uint32_t simd)
{
#if defined(HAS_AVX2)
    if (use_avx2(simd)) return sweep_row_avx2;
#endif
#if defined(HAS_FOUR)
    if (simd != MSAP_SIMD_NONE) return sweep_row_fours;
#endif
    (void)simd;
    return sweep_row_portable;
}
