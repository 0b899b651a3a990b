/* Bounds, three axes at a time: encoding, overlap, containment.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each function stands here twice: for machines with SSE2, and in portable C. Both
 * give the same. The vectors have a fourth value: what follows the bounds in their
 * struct is read along, and mostly its result is left out. */
#ifndef MSAP_BOUNDS_H
#define MSAP_BOUNDS_H

#include "multisap.h"

#include <string.h>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

/* A function that is made anew wherever it is called: it knows constants that are told there, and what it returns
 * need not be stored. (But where coverage is counted there is one of each.) */
#if defined(__GNUC__) && !defined(ALWAYS_INLINE)
#define ALWAYS_INLINE inline __attribute__((always_inline))
#elif !defined(ALWAYS_INLINE)
#define ALWAYS_INLINE inline
#endif

/* Asks for memory that will soon be read. Were it not for the empty assembly, a compiler might take a function
 * that does only this for one that does nothing, and drop it. */
static inline void prefetch(const void *at)
{
#if defined(__GNUC__)
    __builtin_prefetch(at);
    __asm__ volatile("");
#else
    (void)at;
#endif
}

/* Bounds as integers of the same order as the floats, -0 being +0; in 2D worlds
 * min[2] = max[2] = 0. */
struct bounds {
    int32_t min[3], max[3];
};

/* +inf and -inf encoded: what is above or below them is a NaN. */
enum { ORDERED_INF = 0x7f800000, ORDERED_MINUS_INF = -0x7f800000 - 1 };

/* A float's bits as an integer of the same order, and back (paper, appendix A). */
static inline int32_t ordered_from_float_bits(uint32_t bits)
{
    bits = bits == 0x80000000u ? 0 : bits;
    return (int32_t)(bits ^ (0u - (bits >> 31)) >> 1);
}
static inline uint32_t float_bits_from_ordered(int32_t ordered)
{
    uint32_t bits = (uint32_t)ordered;
    return bits ^ (0u - (bits >> 31)) >> 1;
}
static inline float float_from_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline uint32_t load_bits(const char *at)
{
    uint32_t bits;
    memcpy(&bits, at, sizeof bits);
    return bits;
}

#if defined(__SSE2__)

typedef __m128i lanes, gaps;

static inline lanes load_bounds(const int32_t *at) { return _mm_loadu_si128((const __m128i *)(const void *)at); }

static inline void store_four(int32_t *to, lanes values) { _mm_storeu_si128((__m128i *)(void *)to, values); }

static inline void set_four(uint32_t *to, uint32_t value)
{
    _mm_storeu_si128((__m128i *)(void *)to, _mm_set1_epi32((int32_t)value));
}
static inline void count_four(uint32_t *to, uint32_t from)
{
    __m128i steps = _mm_set_epi32(3, 2, 1, 0);
    _mm_storeu_si128((__m128i *)(void *)to, _mm_add_epi32(_mm_set1_epi32((int32_t)from), steps));
}
static inline void copy_four(uint32_t *to, const uint32_t *from)
{
    _mm_storeu_si128((__m128i *)(void *)to, _mm_loadu_si128((const __m128i *)(const void *)from));
}

/* self << 32 | other[i], for four. */
static inline void pairs_of_four(uint64_t *to, uint32_t self, const uint32_t *other)
{
    lanes low = _mm_loadu_si128((const __m128i *)(const void *)other), high = _mm_set1_epi32((int32_t)self);
    _mm_storeu_si128((__m128i *)(void *)to, _mm_unpacklo_epi32(low, high));
    _mm_storeu_si128((__m128i *)(void *)(to + 2), _mm_unpackhi_epi32(low, high));
}

/* a[i] << 32 | b[i], for four; with the upper bit of the lower half where `marked` has a bit. */
static inline void marked_pairs_of_four(uint64_t *to, const uint32_t *a, const uint32_t *b, uint32_t marked)
{
    lanes bit = _mm_set_epi32(8, 4, 2, 1), are = _mm_and_si128(_mm_set1_epi32((int32_t)marked), bit);
    lanes marks = _mm_slli_epi32(_mm_cmpeq_epi32(are, bit), 31);
    lanes low = _mm_or_si128(_mm_loadu_si128((const __m128i *)(const void *)b), marks);
    lanes high = _mm_loadu_si128((const __m128i *)(const void *)a);
    _mm_storeu_si128((__m128i *)(void *)to, _mm_unpacklo_epi32(low, high));
    _mm_storeu_si128((__m128i *)(void *)(to + 2), _mm_unpackhi_epi32(low, high));
}

/* a where the bits of `which` are set, else b. */
static inline lanes choose_lanes(lanes which, lanes a, lanes b)
{
    return _mm_or_si128(_mm_and_si128(which, a), _mm_andnot_si128(which, b));
}

static inline lanes lanes_of(uint32_t x, uint32_t y, uint32_t z)
{
    return _mm_set_epi32(0, (int32_t)z, (int32_t)y, (int32_t)x);
}

/* Whether none of the first three of a is above that of b. */
static inline int none_above(lanes a, lanes b, lanes c, lanes d)
{
    lanes above = _mm_or_si128(_mm_cmpgt_epi32(a, b), _mm_cmpgt_epi32(c, d));
    return !(_mm_movemask_ps(_mm_castsi128_ps(above)) & 7);
}

static inline int overlap(const struct bounds *a, const struct bounds *b)
{
    return none_above(load_bounds(a->min), load_bounds(b->max), load_bounds(b->min), load_bounds(a->max));
}

/* On which of the first three axes bounds are apart; and on the fourth, whether the max of one is above the word
 * behind the other's. */
static inline gaps gaps_of(const struct bounds *a, const struct bounds *b)
{
    return _mm_or_si128(_mm_cmpgt_epi32(load_bounds(a->min), load_bounds(b->max)),
                        _mm_cmpgt_epi32(load_bounds(b->min), load_bounds(a->max)));
}

/* Gaps that are told on the fourth axis. They have been. */
static inline gaps gaps_and_fourth(gaps g, int fourth)
{
    (void)fourth;
    return g;
}

/* Which of four pairs of bounds, with such gaps, overlap: a bit each. *fourth becomes which are apart on the
 * fourth axis. */
static inline uint32_t overlaps_and_fourth(gaps gaps0, gaps gaps1, gaps gaps2, gaps gaps3, uint32_t *fourth)
{
    lanes bytes = _mm_packs_epi16(_mm_packs_epi32(gaps0, gaps1), _mm_packs_epi32(gaps2, gaps3));
    lanes none = _mm_cmpeq_epi32(_mm_and_si128(bytes, _mm_set1_epi32(0xffffff)), _mm_setzero_si128());
    *fourth = (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(bytes));
    return (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(none));
}

/* The upper bits of the lower halves of four. */
static inline uint32_t marks_of_four(const uint64_t *at)
{
    __m128 low = _mm_loadu_ps((const float *)(const void *)at),
           high = _mm_loadu_ps((const float *)(const void *)(at + 2));
    return (uint32_t)_mm_movemask_ps(_mm_shuffle_ps(low, high, _MM_SHUFFLE(2, 0, 2, 0)));
}

/* The upper bits of four. */
static inline uint32_t upper_bits_of_four(const uint32_t *at)
{
    return (uint32_t)_mm_movemask_ps(_mm_loadu_ps((const float *)(const void *)at));
}

static inline int contains(const struct bounds *outer, const struct bounds *inner)
{
    return none_above(load_bounds(outer->min), load_bounds(inner->min), load_bounds(inner->max),
                      load_bounds(outer->max));
}

static inline lanes load_floats(const char *at, ptrdiff_t step, uint32_t dims)
{
    if (step != (ptrdiff_t)sizeof(float))
        return lanes_of(load_bits(at), load_bits(at + step), dims == 3 ? load_bits(at + 2 * step) : 0);
    lanes two = _mm_loadl_epi64((const __m128i *)(const void *)at);
    return dims == 3 ? _mm_unpacklo_epi64(two, _mm_cvtsi32_si128((int)load_bits(at + 2 * sizeof(float)))) : two;
}

static inline lanes encode_lanes(lanes bits)
{
    bits = _mm_andnot_si128(_mm_cmpeq_epi32(bits, _mm_set1_epi32(INT32_MIN)), bits);
    return _mm_xor_si128(bits, _mm_srli_epi32(_mm_srai_epi32(bits, 31), 1));
}

static inline void store_lanes(int32_t out[3], lanes values)
{
    _mm_storel_epi64((__m128i *)(void *)out, values);
    out[2] = _mm_cvtsi128_si32(_mm_shuffle_epi32(values, _MM_SHUFFLE(2, 2, 2, 2)));
}

/* Both; what the first store writes too many the second one overwrites. */
static inline void store_bounds(struct bounds *out, lanes min, lanes max)
{
    _mm_storeu_si128((__m128i *)(void *)out->min, min);
    store_lanes(out->max, max);
}

/* Stores encoded bounds. Returns 1 if they are legal: since a NaN is above +inf or below
 * -inf, none stands between -inf <= min <= max <= +inf. */
static inline int put_encoded(lanes min, lanes max, struct bounds *out)
{
    store_bounds(out, min, max);
    lanes nan = _mm_or_si128(_mm_cmpgt_epi32(_mm_set1_epi32(ORDERED_MINUS_INF), min),
                             _mm_cmpgt_epi32(max, _mm_set1_epi32(ORDERED_INF)));
    return !(_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(nan, _mm_cmpgt_epi32(min, max)))) & 7);
}

static inline int encode(lanes min, lanes max, struct bounds *out)
{
    return put_encoded(encode_lanes(min), encode_lanes(max), out);
}

/* The same; *is_within becomes whether the bounds are within `outer`, which is legal. If they are, no NaN is
 * among them. */
static inline int encode_within(lanes min, lanes max, const struct bounds *outer, struct bounds *out,
                                int *is_within)
{
    min = encode_lanes(min);
    max = encode_lanes(max);
    lanes outside =
        _mm_or_si128(_mm_cmpgt_epi32(load_bounds(outer->min), min), _mm_cmpgt_epi32(max, load_bounds(outer->max)));
    *is_within = !(_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(outside, _mm_cmpgt_epi32(min, max)))) & 7);
    if (!*is_within) return put_encoded(min, max, out);
    store_bounds(out, min, max);
    return 1;
}

#else

static inline void set_four(uint32_t *to, uint32_t value) { to[0] = to[1] = to[2] = to[3] = value; }
static inline void count_four(uint32_t *to, uint32_t from)
{
    for (uint32_t i = 0; i < 4; i++) to[i] = from + i;
}
static inline void copy_four(uint32_t *to, const uint32_t *from) { memcpy(to, from, 4 * sizeof *to); }
static inline void pairs_of_four(uint64_t *to, uint32_t self, const uint32_t *other)
{
    for (int i = 0; i < 4; i++) to[i] = (uint64_t)self << 32 | other[i];
}

/* a[i] << 32 | b[i], for four; with the upper bit of the lower half where `marked` has a bit. */
static inline void marked_pairs_of_four(uint64_t *to, const uint32_t *a, const uint32_t *b, uint32_t marked)
{
    for (int i = 0; i < 4; i++) to[i] = (uint64_t)a[i] << 32 | b[i] | (marked >> i & 1u) << 31;
}

typedef struct {
    uint32_t at[3];
} lanes;

static inline lanes lanes_of(uint32_t x, uint32_t y, uint32_t z)
{
    lanes l = {{x, y, z}};
    return l;
}

static inline int overlap(const struct bounds *a, const struct bounds *b)
{
    return (a->min[0] <= b->max[0]) & (b->min[0] <= a->max[0]) & (a->min[1] <= b->max[1]) &
           (b->min[1] <= a->max[1]) & (a->min[2] <= b->max[2]) & (b->min[2] <= a->max[2]);
}

typedef unsigned gaps;

/* Whether bounds are apart. */
static inline gaps gaps_of(const struct bounds *a, const struct bounds *b) { return !overlap(a, b); }

/* Gaps that are told on the fourth axis: by another bit. */
static inline gaps gaps_and_fourth(gaps g, int fourth) { return g | (gaps)fourth << 1; }

/* Which of four pairs of bounds, with such gaps, overlap: a bit each. *fourth becomes which are apart on the
 * fourth axis. */
static inline uint32_t overlaps_and_fourth(gaps gaps0, gaps gaps1, gaps gaps2, gaps gaps3, uint32_t *fourth)
{
    *fourth = gaps0 >> 1 | gaps1 >> 1 << 1 | gaps2 >> 1 << 2 | gaps3 >> 1 << 3;
    return (~gaps0 & 1) | (~gaps1 & 1) << 1 | (~gaps2 & 1) << 2 | (~gaps3 & 1) << 3;
}

/* The upper bits of the lower halves of four. */
static inline uint32_t marks_of_four(const uint64_t *at)
{
    return (uint32_t)((at[0] >> 31 & 1) | (at[1] >> 31 & 1) << 1 | (at[2] >> 31 & 1) << 2 |
                      (at[3] >> 31 & 1) << 3);
}

/* The upper bits of four. */
static inline uint32_t upper_bits_of_four(const uint32_t *at)
{
    return at[0] >> 31 | at[1] >> 31 << 1 | at[2] >> 31 << 2 | at[3] >> 31 << 3;
}

static inline int contains(const struct bounds *outer, const struct bounds *inner)
{
    return (outer->min[0] <= inner->min[0]) & (inner->max[0] <= outer->max[0]) & (outer->min[1] <= inner->min[1]) &
           (inner->max[1] <= outer->max[1]) & (outer->min[2] <= inner->min[2]) & (inner->max[2] <= outer->max[2]);
}

static inline lanes load_floats(const char *at, ptrdiff_t step, uint32_t dims)
{
    return lanes_of(load_bits(at), load_bits(at + step), dims == 3 ? load_bits(at + 2 * step) : 0);
}

static inline int encode(lanes min, lanes max, struct bounds *out)
{
    int legal = 1;
    for (int k = 0; k < 3; k++) {
        out->min[k] = ordered_from_float_bits(min.at[k]);
        out->max[k] = ordered_from_float_bits(max.at[k]);
        legal &= (ORDERED_MINUS_INF <= out->min[k]) & (out->min[k] <= out->max[k]) & (out->max[k] <= ORDERED_INF);
    }
    return legal;
}

static inline int encode_within(lanes min, lanes max, const struct bounds *outer, struct bounds *out,
                                int *is_within)
{
    int legal = encode(min, max, out);
    *is_within = contains(outer, out);
    return legal;
}

#endif

/* Which of four pairs of bounds, with such gaps, overlap: a bit each. */
static inline uint32_t overlaps_of(gaps gaps0, gaps gaps1, gaps gaps2, gaps gaps3)
{
    uint32_t fourth;
    return overlaps_and_fourth(gaps0, gaps1, gaps2, gaps3, &fourth);
}

#endif
