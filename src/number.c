/* Numbers: floats and doubles as integers of the same order, and bounds read from
 * the caller's memory.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A float is read as its bits and mapped to an integer of the same order (paper,
 * appendix A): negative floats have their value bits inverted. -0 becomes +0 first.
 * Everything here works on bits, also the rounding of doubles, so that the host's
 * rounding mode, flush-to-zero and compiler flags have no say. */
#include "internal.h"

enum { FLOAT_INF = 0x7f800000, FLOAT_MAX = 0x7f7fffff };

uint32_t msap_encode_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (uint32_t)ordered_from_float_bits(bits) ^ 0x80000000u;
}

float msap_decode_float(uint32_t code)
{
    uint32_t bits = code ^ 0x80000000u;
    return float_from_bits(bits ^ (0u - (bits >> 31)) >> 1);
}

/* Bits of the largest float magnitude that is not above that of the double;
 * *exact tells whether it is equal. The double is not a NaN. */
static uint32_t float_magnitude(uint64_t bits, int *exact)
{
    uint64_t mantissa = bits & 0xfffffffffffffu;
    int exponent = (int)(bits >> 52 & 0x7ff) - 1023;
    *exact = 1;
    if (exponent == 1024) return FLOAT_INF;
    if (exponent > 127) {
        *exact = 0;
        return FLOAT_MAX;
    }
    if (exponent >= -126) {
        *exact = (mantissa & 0x1fffffff) == 0;
        return (uint32_t)(exponent + 127) << 23 | (uint32_t)(mantissa >> 29);
    }
    int shift = 29 - 126 - exponent; /* 30 and more: the result is subnormal */
    if (exponent > -1023) mantissa |= (uint64_t)1 << 52;
    if (shift > 52) {
        *exact = mantissa == 0;
        return 0;
    }
    *exact = (mantissa & (((uint64_t)1 << shift) - 1)) == 0;
    return (uint32_t)(mantissa >> shift);
}

/* The nearest float bits at or below (up = 0) or at or above (up = 1) a double. */
static uint32_t float_bits_outward(uint64_t bits, unsigned up)
{
    if ((bits & 0x7fffffffffffffffu) > 0x7ff0000000000000u) return 0x7fc00000u;
    int exact;
    unsigned negative = (unsigned)(bits >> 63);
    uint32_t magnitude = float_magnitude(bits, &exact);
    if (!exact && negative != up) magnitude++; /* away from zero; past FLT_MAX comes infinity */
    return (uint32_t)negative << 31 | magnitude;
}

/* The value of an encoded float, also where the host takes subnormals for 0. */
double msap_value_of(int32_t ordered)
{
    uint32_t bits = float_bits_from_ordered(ordered), magnitude = bits & 0x7fffffffu;
    if (magnitude >= 0x800000u) return float_from_bits(bits);
    double value = (double)magnitude * 0x1p-149;
    return bits >> 31 ? -value : value;
}

/* The nearest encoded float at or below (up = 0) or at or above (up = 1) a value, which
 * is no NaN. */
int32_t msap_ordered_outward(double value, unsigned up)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return ordered_from_float_bits(float_bits_outward(bits, up));
}

/* ------------------------------------------------------------------- bounds */

static inline uint64_t load_wide(const char *at)
{
    uint64_t bits;
    memcpy(&bits, at, sizeof bits);
    return bits;
}

/* A double's bits as an integer of the same order, -0 being +0. */
static uint64_t order_wide(uint64_t bits)
{
    const uint64_t sign = (uint64_t)1 << 63;
    return bits > sign ? ~bits : bits | sign;
}

static inline uint32_t load_outward(const char *at, unsigned up) { return float_bits_outward(load_wide(at), up); }

static lanes load_doubles(const char *at, ptrdiff_t step, uint32_t dims, unsigned up)
{
    return lanes_of(load_outward(at, up), load_outward(at + step, up),
                    dims == 3 ? load_outward(at + 2 * step, up) : 0);
}

static int is_nan(int32_t ordered) { return ordered < ORDERED_MINUS_INF || ordered > ORDERED_INF; }

/* What is wrong with bounds that are not legal, NaNs before inverted bounds. */
static msap_status diagnose(const struct bounds *b, uint32_t *bound)
{
    for (uint32_t c = 0; c < 6; c++) {
        *bound = c;
        if (is_nan(c < 3 ? b->min[c] : b->max[c - 3])) return MSAP_ERROR_NAN;
    }
    *bound = 0;
    while (b->min[*bound] <= b->max[*bound]) ++*bound;
    return MSAP_ERROR_INVERTED;
}

/* Whether doubles are inverted that are not any more as floats; *bound becomes the min. */
static int doubles_inverted(const char *min, const char *max, const msap_boxes *boxes, uint32_t dims,
                            uint32_t *bound)
{
    for (*bound = 0; *bound < dims; ++*bound) {
        uint64_t low = load_wide(min + (ptrdiff_t)*bound * boxes->min_component);
        uint64_t high = load_wide(max + (ptrdiff_t)*bound * boxes->max_component);
        if (order_wide(low) > order_wide(high)) return 1;
    }
    return 0;
}

/* Reads bounds that are doubles or not legal. */
msap_status msap_bounds_read_with_care(const msap_boxes *boxes, const char *min, const char *max, uint32_t dims,
                                       struct bounds *out, uint32_t *bound)
{
    ptrdiff_t step_min = boxes->min_component, step_max = boxes->max_component;
    if (boxes->scalar == MSAP_FLOAT) {
        encode(load_floats(min, step_min, dims), load_floats(max, step_max, dims), out);
        return diagnose(out, bound);
    }
    if (!encode(load_doubles(min, step_min, dims, 0), load_doubles(max, step_max, dims, 1), out))
        return diagnose(out, bound);
    return doubles_inverted(min, max, boxes, dims, bound) ? MSAP_ERROR_INVERTED : MSAP_OK;
}

msap_boxes msap_boxes_of_one(const float *min, const float *max)
{
    msap_boxes one = {sizeof one, MSAP_FLOAT, min, max, 0, sizeof *min, 0, sizeof *max};
    return one;
}

msap_status msap_boxes_check(const msap_boxes *boxes, size_t k)
{
    if (!boxes) return MSAP_ERROR_NULL;
    if (boxes->struct_size != sizeof *boxes) return MSAP_ERROR_STRUCT_SIZE;
    if (boxes->scalar != MSAP_FLOAT && boxes->scalar != MSAP_DOUBLE) return MSAP_ERROR_CONFIG;
    if (k > 0 && (!boxes->min || !boxes->max)) return MSAP_ERROR_NULL;
    return MSAP_OK;
}

/* Bounds at least `margin` wider on each side. The sum is right to the last bit of a
 * double, in whatever direction that is rounded, and then goes one float outward: it
 * never falls short. */
struct bounds msap_bounds_widened(const struct bounds *b, float margin)
{
    struct bounds wide = *b;
    uint32_t margin_bits;
    memcpy(&margin_bits, &margin, sizeof margin_bits);
    double by = msap_value_of(ordered_from_float_bits(margin_bits));
    for (int k = 0; k < 3 && margin_bits != 0; k++) {
        wide.min[k] = msap_ordered_outward(msap_value_of(b->min[k]) - by, 0);
        wide.max[k] = msap_ordered_outward(msap_value_of(b->max[k]) + by, 1);
        wide.min[k] -= wide.min[k] > ORDERED_MINUS_INF;
        wide.max[k] += wide.max[k] < ORDERED_INF;
    }
    return wide;
}
