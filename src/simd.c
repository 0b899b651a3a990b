/* The sweeps: eight boxes at a time or sixteen where the machine can.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Over a cell, each function gives the slots, among rows first ... last - 1, whose rounded bounds
 * overlap those asked for, in the order of the rows; all give the same. Of a block of
 * eight or sixteen, what lies outside those rows is read and left out. So it is with the sweeps
 * over the rows of jump.c below. */
#include "internal.h"

/* The columns of the block from `row` on that are among the rows before `last`. */
static inline uint32_t columns_before(uint32_t last, uint32_t row)
{
    uint32_t left = last - row < 8 ? last - row : 8;
    return 255u >> (8 - left);
}

static size_t sweep_portable(const struct cell *c, uint32_t first, uint32_t last, const struct rounded *r,
                             uint32_t *out)
{
    size_t n = 0;
    const struct rounded f = facing(r);
    for (uint32_t row = first; row < last; row++) {
        const struct cell_block *at = &c->block[row / 8];
        uint32_t i = row % 8, sign = 0;
        for (int k = 0; k < 3; k++)
            sign |= ((uint32_t)f.low[k] - at->low[k][i]) | ((uint32_t)f.high[k] - at->high[k][i]);
        out[n] = at->id[i];
        n += !(sign & 0x8000);
    }
    return n;
}

/* Four integers, on the machines that have them at all times: SSE2, NEON. */
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define HAS_AVX2 1
#define HAS_FOUR 1
#if __GNUC__ >= 8 || defined(__clang__)
#define HAS_AVX512 1
#endif

typedef __m128i four, four_mask;
static inline four four_at(const int32_t *at) { return _mm_loadu_si128((const __m128i *)(const void *)at); }
static inline four four_of(int32_t value) { return _mm_set1_epi32(value); }
static inline four_mask above(four a, four b) { return _mm_cmpgt_epi32(a, b); }
static inline four_mask either(four_mask a, four_mask b) { return _mm_or_si128(a, b); }
static inline four both(four a, four b) { return _mm_and_si128(a, b); }
static inline four_mask same(four a, four b) { return _mm_cmpeq_epi32(a, b); }
static inline uint32_t bits_of(four_mask m) { return (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(m)); }

/* As facing (internal.h) */
static inline __m128i facing_lanes(const struct rounded *r)
{
    __m128i negated = _mm_sub_epi16(_mm_setzero_si128(), _mm_loadu_si128((const __m128i *)(const void *)r));
    return _mm_shuffle_epi32(negated, _MM_SHUFFLE(1, 0, 3, 2));
}

typedef __m128i eight; /* 16 bits each */
static inline eight eight_at(const uint16_t *at) { return _mm_loadu_si128((const __m128i *)(const void *)at); }
static inline eight eight_of(uint16_t value) { return _mm_set1_epi16((int16_t)value); }
static inline eight minus(eight a, eight b) { return _mm_sub_epi16(a, b); }
static inline eight any_of(eight a, eight b) { return _mm_or_si128(a, b); }
static inline uint32_t signs_of(eight v) { return (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(v, v)) & 255; }
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

typedef uint16x8_t eight;
static inline eight eight_at(const uint16_t *at) { return vld1q_u16(at); }
static inline eight eight_of(uint16_t value) { return vdupq_n_u16(value); }
static inline eight minus(eight a, eight b) { return vsubq_u16(a, b); }
static inline eight any_of(eight a, eight b) { return vorrq_u16(a, b); }
static inline uint32_t signs_of(eight v)
{
    static const int16_t place[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    return vaddvq_u16(vshlq_u16(vshrq_n_u16(v, 15), vld1q_s16(place)));
}
#endif

#if defined(HAS_FOUR)
static size_t sweep_eights(const struct cell *c, uint32_t first, uint32_t last, const struct rounded *r,
                           uint32_t *out)
{
    size_t n = 0;
    const struct rounded f = facing(r);
    const eight low[3] = {eight_of(f.low[0]), eight_of(f.low[1]), eight_of(f.low[2])};
    const eight high[3] = {eight_of(f.high[0]), eight_of(f.high[1]), eight_of(f.high[2])};
    uint32_t columns = 255u << first % 8;
    for (uint32_t row = first & ~7u; row < last; row += 8, columns = 255) {
        const struct cell_block *at = &c->block[row / 8];
        eight x = any_of(minus(low[0], eight_at(at->low[0])), minus(high[0], eight_at(at->high[0])));
        eight y = any_of(minus(low[1], eight_at(at->low[1])), minus(high[1], eight_at(at->high[1])));
        eight z = any_of(minus(low[2], eight_at(at->low[2])), minus(high[2], eight_at(at->high[2])));
        uint32_t found = columns & columns_before(last, row) & ~signs_of(any_of(x, any_of(y, z)));
        for (; found; found &= found - 1) out[n++] = at->id[(uint32_t)__builtin_ctz(found)];
    }
    return n;
}
#endif

#if defined(HAS_AVX2)
#define LOAD256(array) _mm256_loadu_si256((const __m256i *)(const void *)(array))

/* For each set of columns, its columns in order, a byte each. */
#define HAS(set, column) (((set) >> (column)) & 1)
#define BEFORE(set, column)                                                                          \
    (((column) > 0 && HAS(set, 0)) + ((column) > 1 && HAS(set, 1)) + ((column) > 2 && HAS(set, 2)) + \
     ((column) > 3 && HAS(set, 3)) + ((column) > 4 && HAS(set, 4)) + ((column) > 5 && HAS(set, 5)) + \
     ((column) > 6 && HAS(set, 6)))
#define PLACED(set, column) ((uint64_t)(HAS(set, column) * (column)) << 8 * BEFORE(set, column))
#define ORDER(set)                                                                                         \
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

/* Two values of a row of eight values of 16 bits, each for one half. */
#define HALVES256(values, a, b)                                                                 \
    _mm256_shuffle_epi8(values, _mm256_setr_epi64x(0x0100010001000100 + (a)*0x0202020202020202, \
                                                   0x0100010001000100 + (a)*0x0202020202020202, \
                                                   0x0100010001000100 + (b)*0x0202020202020202, \
                                                   0x0100010001000100 + (b)*0x0202020202020202))

/* Two sides of eight boxes at a time: those that follow each other in a block. */
__attribute__((target("avx2"))) static size_t sweep_avx2(const struct cell *c, uint32_t first, uint32_t last,
                                                         const struct rounded *r, uint32_t *out)
{
    size_t n = 0;
    const __m256i both = _mm256_broadcastsi128_si256(facing_lanes(r));
    const __m256i first_two = HALVES256(both, 0, 1), next_two = HALVES256(both, 2, 4),
                  last_two = HALVES256(both, 5, 6);
    uint32_t columns = 255u << first % 8;
    for (uint32_t row = first & ~7u; row < last; row += 8, columns = 255) {
        const struct cell_block *at = &c->block[row / 8];
        __m256i apart = _mm256_or_si256(_mm256_sub_epi16(first_two, LOAD256(at->low[0])),
                                        _mm256_sub_epi16(next_two, LOAD256(at->low[2])));
        apart = _mm256_or_si256(apart, _mm256_sub_epi16(last_two, LOAD256(at->high[1])));
        __m128i any = _mm_or_si128(_mm256_castsi256_si128(apart), _mm256_extracti128_si256(apart, 1));
        uint32_t signs = (uint32_t)_mm_movemask_epi8(_mm_packs_epi16(any, any));
        n += put_found(out + n, LOAD256(at->id), columns & columns_before(last, row) & ~signs);
    }
    return n;
}
#endif

/* ------------------------------------------------------------- sweeping rows */

/* Each of these sweeps is made twice: within a row, from each entry through those behind it, where `reach` is NULL; and
 * from each entry of a row through those of the same row in another set. */

/* The entry of the other row from which on one that starts at `min` is to be tested: from j on, if it has been
 * tested against those before. */
static inline uint32_t first_to_test(struct row_reach *reach, uint32_t j, uint32_t end, int32_t min)
{
    while (reach->first < end && reach->at[(reach->first - reach->start) / REACH] < min) reach->first += REACH;
    return j > reach->first ? j : reach->first;
}

static ALWAYS_INLINE void sweep_ones(const struct row_set *s, const struct row_set *other, struct row_reach *reach,
                                     struct row_sweep *at, struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    uint32_t i = at->i, j = at->j;
    for (out->n = 0; i < last; i++, j = reach ? 0 : i + 1) {
        int32_t start = s->min[0][i], stop = s->max[0][i], min1 = s->min[1][i], max1 = s->max[1][i],
                min2 = s->min[2][i], max2 = s->max[2][i];
        if (reach) j = first_to_test(reach, j, end, start);
        for (; j < end && other->min[0][j] <= stop && out->n < MOST_BUFFERED; j++) {
            int apart = (other->min[1][j] > max1) | (min1 > other->max[1][j]) | (other->min[2][j] > max2) |
                        (min2 > other->max[2][j]);
            if (reach) apart |= start > other->max[0][j];
            out->a[out->n] = s->id[i] & ~ROW_MARKS;
            out->b[out->n] = other->id[j] & ~ROW_MARKS;
            out->n += !apart & (((s->id[i] | other->id[j]) & ROW_MARKS) == ROW_MARKS);
        }
        if (out->n == MOST_BUFFERED) break;
    }
    at->i = i;
    at->j = j;
}

static void sweep_row_portable(const struct row_set *s, struct row_sweep *at, struct pair_buffer *out)
{
    sweep_ones(s, s, NULL, at, out);
}

static void sweep_between_portable(const struct row_set *s, const struct row_set *other, struct row_reach *reach,
                                   struct row_sweep *at, struct pair_buffer *out)
{
    sweep_ones(s, other, reach, at, out);
}

#if defined(HAS_FOUR)
static ALWAYS_INLINE void sweep_fours(const struct row_set *s, const struct row_set *other,
                                      struct row_reach *reach, struct row_sweep *at, struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    uint32_t i = at->i, j = at->j;
    size_t n = 0;
    for (; i < last; i++, j = reach ? 0 : i + 1) {
        uint32_t found, is_past = 0;
        four lacks = four_of((int32_t)(~s->id[i] & ROW_MARKS));
        four start = four_of(s->min[0][i]), stop = four_of(s->max[0][i]);
        four min1 = four_of(s->min[1][i]), max1 = four_of(s->max[1][i]);
        four min2 = four_of(s->min[2][i]), max2 = four_of(s->max[2][i]);
        if (reach) j = first_to_test(reach, j, end, s->min[0][i]);
        for (; j < end && !is_past && n <= MOST_BUFFERED - 4; j += 4) {
            four_mask past = above(four_at(other->min[0] + j), stop);
            four_mask y = either(above(four_at(other->min[1] + j), max1), above(min1, four_at(other->max[1] + j)));
            four_mask z = either(above(four_at(other->min[2] + j), max2), above(min2, four_at(other->max[2] + j)));
            if (reach) y = either(y, above(start, four_at(other->max[0] + j)));
            four id = four_at((const int32_t *)(const void *)(other->id + j));
            found = bits_of(same(both(id, lacks), lacks)) & ~bits_of(either(past, either(y, z)));
            is_past = bits_of(past);
            if (end - j < 4) found &= (1u << (end - j)) - 1;
            for (; found; found &= found - 1) {
                out->a[n] = s->id[i] & ~ROW_MARKS;
                out->b[n++] = other->id[j + (uint32_t)__builtin_ctz(found)] & ~ROW_MARKS;
            }
        }
        if (j < end && !is_past) break;
    }
    at->i = i;
    at->j = j;
    out->n = n;
}

static void sweep_row_fours(const struct row_set *s, struct row_sweep *at, struct pair_buffer *out)
{
    sweep_fours(s, s, NULL, at, out);
}

static void sweep_between_fours(const struct row_set *s, const struct row_set *other, struct row_reach *reach,
                                struct row_sweep *at, struct pair_buffer *out)
{
    sweep_fours(s, other, reach, at, out);
}
#endif

#if defined(HAS_AVX2)
/* Which of the eight bounds from `min` and `max` on do not overlap those from `low` to `high`. */
__attribute__((target("avx2"))) static inline __m256i are_apart(const int32_t *min, const int32_t *max,
                                                                __m256i low, __m256i high)
{
    return _mm256_or_si256(_mm256_cmpgt_epi32(LOAD256(min), high), _mm256_cmpgt_epi32(low, LOAD256(max)));
}

__attribute__((target("avx2"))) static ALWAYS_INLINE void sweep_eights_of_row(const struct row_set *s,
                                                                              const struct row_set *other,
                                                                              struct row_reach *reach,
                                                                              struct row_sweep *at,
                                                                              struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    const __m256i marks = _mm256_set1_epi32((int32_t)ROW_MARKS);
    uint32_t i = at->i, j = at->j;
    size_t n = 0;
    for (; i < last; i++, j = reach ? 0 : i + 1) {
        uint32_t is_past = 0;
        __m256i self = _mm256_set1_epi32((int32_t)(s->id[i] & ~ROW_MARKS));
        __m256i lacks = _mm256_set1_epi32((int32_t)(~s->id[i] & ROW_MARKS));
        __m256i start = _mm256_set1_epi32(s->min[0][i]), stop = _mm256_set1_epi32(s->max[0][i]);
        __m256i min1 = _mm256_set1_epi32(s->min[1][i]), max1 = _mm256_set1_epi32(s->max[1][i]);
        __m256i min2 = _mm256_set1_epi32(s->min[2][i]), max2 = _mm256_set1_epi32(s->max[2][i]);
        if (reach) j = first_to_test(reach, j, end, s->min[0][i]);
        for (; j < end && !is_past && n <= MOST_BUFFERED - 8; j += 8) {
            __m256i past = _mm256_cmpgt_epi32(LOAD256(other->min[0] + j), stop);
            __m256i apart = _mm256_or_si256(past, are_apart(other->min[1] + j, other->max[1] + j, min1, max1));
            apart = _mm256_or_si256(apart, are_apart(other->min[2] + j, other->max[2] + j, min2, max2));
            if (reach) apart = _mm256_or_si256(apart, _mm256_cmpgt_epi32(start, LOAD256(other->max[0] + j)));
            __m256i ids = LOAD256(other->id + j), has = _mm256_cmpeq_epi32(_mm256_and_si256(ids, lacks), lacks);
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

__attribute__((target("avx2"))) static void sweep_row_avx2(const struct row_set *s, struct row_sweep *at,
                                                           struct pair_buffer *out)
{
    sweep_eights_of_row(s, s, NULL, at, out);
}

__attribute__((target("avx2"))) static void sweep_between_avx2(const struct row_set *s,
                                                               const struct row_set *other,
                                                               struct row_reach *reach, struct row_sweep *at,
                                                               struct pair_buffer *out)
{
    sweep_eights_of_row(s, other, reach, at, out);
}
#endif

/* Sixteen at a time; each comparison asks of those that the last one has left. */
#if defined(HAS_AVX512)
#define LOAD512(array) _mm512_loadu_si512((const void *)(array)) /* GCOVR_EXCL_START: as the machine is */

__attribute__((target("avx512f"))) static void sweep_row_avx512(const struct row_set *s, struct row_sweep *at,
                                                                struct pair_buffer *out)
{
    const uint32_t last = at->last, end = at->end;
    const __m512i marks = _mm512_set1_epi32((int32_t)ROW_MARKS);
    uint32_t i = at->i, j = at->j;
    size_t n = 0;
    for (; i < last; i++, j = i + 1) {
        int is_past = 0;
        __m512i self = _mm512_set1_epi32((int32_t)(s->id[i] & ~ROW_MARKS));
        __m512i lacks = _mm512_set1_epi32((int32_t)(~s->id[i] & ROW_MARKS));
        __m512i stop = _mm512_set1_epi32(s->max[0][i]);
        __m512i min1 = _mm512_set1_epi32(s->min[1][i]), max1 = _mm512_set1_epi32(s->max[1][i]);
        __m512i min2 = _mm512_set1_epi32(s->min[2][i]), max2 = _mm512_set1_epi32(s->max[2][i]);
        for (; j < end && !is_past && n <= MOST_BUFFERED - 16; j += 16) {
            __m512i ids = LOAD512(s->id + j);
            __mmask16 found = _mm512_cmple_epi32_mask(LOAD512(s->min[0] + j), stop);
            is_past = found != 65535;
            if (end - j < 16) found &= (__mmask16)((1u << (end - j)) - 1);
            found = _mm512_mask_cmple_epi32_mask(found, LOAD512(s->min[1] + j), max1);
            found = _mm512_mask_cmple_epi32_mask(found, min1, LOAD512(s->max[1] + j));
            found = _mm512_mask_cmple_epi32_mask(found, LOAD512(s->min[2] + j), max2);
            found = _mm512_mask_cmple_epi32_mask(found, min2, LOAD512(s->max[2] + j));
            found = _mm512_mask_cmpeq_epi32_mask(found, _mm512_and_si512(ids, lacks), lacks);
            ids = _mm512_maskz_compress_epi32(found, _mm512_andnot_si512(marks, ids));
            _mm512_storeu_si512((void *)(out->a + n), self);
            _mm512_storeu_si512((void *)(out->b + n), ids);
            n += (size_t)__builtin_popcount(found);
        }
        if (j < end && !is_past) break;
    }
    at->i = i;
    at->j = j;
    out->n = n;
}

/* GCOVR_EXCL_STOP */

/* AVX-512 of its second generation, by one of the parts that came with it: on the first it was not measured. */
static int use_avx512(uint32_t simd)
{
    int may = simd == MSAP_SIMD_AUTO || simd >= MSAP_SIMD_512;
    return may && __builtin_cpu_supports("avx512vbmi2"); /* GCOVR_EXCL_BR_LINE: as the machine is */
}
#endif

#if defined(HAS_AVX2)
static int use_avx2(uint32_t simd)
{
    int may = simd == MSAP_SIMD_AUTO || simd >= MSAP_SIMD_256;
    return may && __builtin_cpu_supports("avx2"); /* GCOVR_EXCL_BR_LINE: never false where there is AVX2 */
}
#endif

/* -------------------------------------------------------------- asking rows */

/* Behind the last entry that is asked this time. */
static uint32_t last_asked(const struct row_sweep *at)
{
    return at->end - at->i < ENTRIES_ASKED ? at->end : at->i + ENTRIES_ASKED;
}

static size_t ask_row_portable(const struct row_set *s, const struct row_question *q, struct row_sweep *at,
                               uint32_t *out)
{
    const uint32_t last = last_asked(at);
    uint32_t i = at->i;
    size_t n = 0;
    for (; i < last && s->min[0][i] <= q->max[0]; i++) {
        int apart = s->max[0][i] < q->min[0];
        for (int k = 1; k < 3; k++) apart |= (s->min[k][i] > q->max[k]) | (s->max[k][i] < q->min[k]);
        out[n] = row_slot(s->id[i]);
        n += !apart & ((s->id[i] & q->lacks) == q->lacks);
    }
    at->i = i < last ? at->end : last;
    return n;
}

#if defined(HAS_FOUR)
static size_t ask_row_fours(const struct row_set *s, const struct row_question *q, struct row_sweep *at,
                            uint32_t *out)
{
    const uint32_t last = last_asked(at);
    const four lacks = four_of((int32_t)q->lacks);
    uint32_t is_past = 0;
    size_t n = 0;
    for (uint32_t i = at->i; i < last && !is_past; i += 4) {
        four_mask past = above(four_at(s->min[0] + i), four_of(q->max[0]));
        four_mask apart = either(past, above(four_of(q->min[0]), four_at(s->max[0] + i)));
        for (int k = 1; k < 3; k++)
            apart = either(apart, either(above(four_at(s->min[k] + i), four_of(q->max[k])),
                                         above(four_of(q->min[k]), four_at(s->max[k] + i))));
        four id = four_at((const int32_t *)(const void *)(s->id + i));
        uint32_t found = bits_of(same(both(id, lacks), lacks)) & ~bits_of(apart);
        is_past = bits_of(past);
        if (last - i < 4) found &= (1u << (last - i)) - 1;
        for (; found; found &= found - 1) out[n++] = row_slot(s->id[i + (uint32_t)__builtin_ctz(found)]);
    }
    at->i = is_past ? at->end : last;
    return n;
}
#endif

#if defined(HAS_AVX2)
__attribute__((target("avx2"))) static size_t ask_row_avx2(const struct row_set *s, const struct row_question *q,
                                                           struct row_sweep *at, uint32_t *out)
{
    const struct row_set set = *s;
    const uint32_t last = last_asked(at);
    const __m256i min[3] = {_mm256_set1_epi32(q->min[0]), _mm256_set1_epi32(q->min[1]),
                            _mm256_set1_epi32(q->min[2])},
                  max[3] = {_mm256_set1_epi32(q->max[0]), _mm256_set1_epi32(q->max[1]),
                            _mm256_set1_epi32(q->max[2])},
                  lacks = _mm256_set1_epi32((int32_t)q->lacks), marks = _mm256_set1_epi32((int32_t)~row_slot(~0u));
    uint32_t is_past = 0;
    size_t n = 0;
    for (uint32_t i = at->i; i < last && !is_past; i += 8) {
        __m256i past = _mm256_cmpgt_epi32(LOAD256(set.min[0] + i), max[0]), ids = LOAD256(set.id + i);
        __m256i apart = are_apart(set.min[0] + i, set.max[0] + i, min[0], max[0]);
        apart = _mm256_or_si256(apart, are_apart(set.min[1] + i, set.max[1] + i, min[1], max[1]));
        apart = _mm256_or_si256(apart, are_apart(set.min[2] + i, set.max[2] + i, min[2], max[2]));
        __m256i has = _mm256_cmpeq_epi32(_mm256_and_si256(ids, lacks), lacks);
        uint32_t found = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_andnot_si256(apart, has)));
        is_past = (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(past));
        if (last - i < 8) found &= (1u << (last - i)) - 1;
        n += put_found(out + n, _mm256_andnot_si256(marks, ids), found);
    }
    at->i = is_past ? at->end : last;
    return n;
}
#endif

/* ----------------------------------------------------------------- choosing */

/* The best that the machine has, not above `simd`. */
struct sweeps msap_sweeps_for(uint32_t simd)
{
    struct sweeps s = {sweep_portable, sweep_row_portable, sweep_between_portable, ask_row_portable};
#if defined(HAS_FOUR)
    const struct sweeps fours = {sweep_eights, sweep_row_fours, sweep_between_fours, ask_row_fours};
    if (simd != MSAP_SIMD_NONE) s = fours;
#endif
#if defined(HAS_AVX2)
    const struct sweeps eights = {sweep_avx2, sweep_row_avx2, sweep_between_avx2, ask_row_avx2};
    if (use_avx2(simd)) s = eights;
#endif
#if defined(HAS_AVX512)
    if (use_avx512(simd)) s.row = sweep_row_avx512; /* GCOVR_EXCL_BR_LINE: as the machine is */
#endif
    (void)simd;
    return s;
}
