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

static uint32_t read_float_bits(const char *at, uint32_t scalar, unsigned up)
{
    uint64_t wide;
    uint32_t bits;
    if (scalar == MSAP_DOUBLE) {
        memcpy(&wide, at, sizeof wide);
        return float_bits_outward(wide, up);
    }
    memcpy(&bits, at, sizeof bits);
    return bits;
}

/* ------------------------------------------------------------------- bounds */

enum { ORDERED_INF = FLOAT_INF, ORDERED_MINUS_INF = -FLOAT_INF - 1 };

/* Reads one row. Returns 1 if it is legal: a NaN is above +inf or below -inf, so that
 * no NaN stands between -inf <= min <= max <= +inf. */
static int read_row(const msap_boxes *boxes, size_t row, uint32_t dims, struct bounds *out)
{
    const char *min = (const char *)boxes->min + (ptrdiff_t)row * boxes->min_row;
    const char *max = (const char *)boxes->max + (ptrdiff_t)row * boxes->max_row;
    int legal = 1;
    out->min[2] = out->max[2] = 0;
    for (uint32_t c = 0; c < dims; c++) {
        uint32_t low = read_float_bits(min + (ptrdiff_t)c * boxes->min_component, boxes->scalar, 0);
        uint32_t high = read_float_bits(max + (ptrdiff_t)c * boxes->max_component, boxes->scalar, 1);
        out->min[c] = ordered_from_float_bits(low);
        out->max[c] = ordered_from_float_bits(high);
        legal &= (ORDERED_MINUS_INF <= out->min[c]) & (out->min[c] <= out->max[c]) & (out->max[c] <= ORDERED_INF);
    }
    return legal;
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

/* Reads row `row` of an array of boxes; of bounds that are not legal, *bound becomes
 * the one at fault. */
msap_status bounds_read(const msap_boxes *boxes, size_t row, uint32_t dims, struct bounds *out, uint32_t *bound)
{
    return read_row(boxes, row, dims, out) ? MSAP_OK : diagnose(out, bound);
}

msap_boxes boxes_of_one(const float *min, const float *max)
{
    msap_boxes one = {sizeof one, MSAP_FLOAT, min, max, 0, sizeof *min, 0, sizeof *max};
    return one;
}

msap_status boxes_check(const msap_boxes *boxes, size_t k)
{
    if (!boxes) return MSAP_ERROR_NULL;
    if (boxes->struct_size != sizeof *boxes) return MSAP_ERROR_STRUCT_SIZE;
    if (boxes->scalar != MSAP_FLOAT && boxes->scalar != MSAP_DOUBLE) return MSAP_ERROR_CONFIG;
    if (k > 0 && (!boxes->min || !boxes->max)) return MSAP_ERROR_NULL;
    return MSAP_OK;
}
