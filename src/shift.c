/* Shifting the origin: every bound minus an offset, exact, then rounded outward.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The difference of a float and a double has more digits than either has room for,
 * and the host may round in any direction; so it is computed in integers. What falls
 * below the last bit of the integer is remembered as `more`, which is all that
 * rounding outward must know. */
#include "internal.h"

enum { FLOAT_MAX = 0x7f7fffff, INFINITE = 0x7ff };

/* (-1)^negative * (mantissa + t) * 2^exponent, with 0 < t < 1 if more, else t = 0. */
struct number {
    unsigned negative, more;
    uint64_t mantissa;
    int exponent;
};

static struct number number_of(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    int field = (int)(bits >> 52 & 0x7ff);
    struct number n = {(unsigned)(bits >> 63), 0, bits & 0xfffffffffffffu, field ? field - 1075 : -1074};
    if (field) n.mantissa |= (uint64_t)1 << 52;
    while (n.mantissa && !(n.mantissa >> 61)) {
        n.mantissa <<= 1;
        n.exponent--;
    }
    return n;
}

/* Lowers the exponent's distance to `exponent` by dropping bits into `more`. */
static void align(struct number *n, int exponent)
{
    int shift = exponent - n->exponent;
    if (shift <= 0) return;
    uint64_t kept = shift > 63 ? 0 : n->mantissa >> shift;
    n->more = shift > 63 ? n->mantissa != 0 : (kept << shift) != n->mantissa;
    n->mantissa = kept;
    n->exponent = exponent;
}

/* The sum of two numbers of number_of, whose mantissas are 0 or in [2^61, 2^62). */
static struct number add(struct number a, struct number b)
{
    int exponent = a.mantissa == 0                              ? b.exponent
                   : b.mantissa == 0 || a.exponent > b.exponent ? a.exponent
                                                                : b.exponent;
    align(&a, exponent);
    align(&b, exponent);
    if (a.mantissa < b.mantissa) {
        struct number swap = a;
        a = b;
        b = swap;
    }
    a.exponent = exponent;
    if (a.negative == b.negative) a.mantissa += b.mantissa;
    else a.mantissa -= b.mantissa + b.more; /* the larger one dropped nothing */
    a.more |= b.more;
    return a;
}

/* Bits of the nearest float that is not above (up = 0) or not below (up = 1). */
static uint32_t round_outward(struct number n, unsigned up)
{
    uint32_t magnitude = 0;
    while (n.mantissa && !(n.mantissa >> 63)) {
        n.mantissa <<= 1;
        n.exponent--;
    }
    int top = n.exponent + 63, shift = top >= -126 ? 40 : 40 - 126 - top;
    if (n.mantissa && top > 127) {
        magnitude = FLOAT_MAX;
        n.more = 1;
    } else if (n.mantissa && shift < 64) {
        magnitude = (uint32_t)(n.mantissa >> shift) + (top >= -126 ? (uint32_t)(top + 126) << 23 : 0);
        n.more |= (n.mantissa & (((uint64_t)1 << shift) - 1)) != 0;
    } else n.more |= n.mantissa != 0;
    if (n.more && n.negative != up) magnitude++;
    return (uint32_t)n.negative << 31 | magnitude;
}

static int32_t shifted(int32_t ordered, struct number minus_offset, unsigned up)
{
    double value = msap_value_of(ordered);
    struct number n = number_of(value);
    if (float_bits_from_ordered(ordered) << 1 == 0xff000000u) return ordered; /* infinite */
    return ordered_from_float_bits(round_outward(add(n, minus_offset), up));
}

static void shift_box(struct box_table *t, uint32_t slot, const struct number *minus_offset, uint32_t dims)
{
    struct bounds b = t->at[slot].now;
    for (uint32_t k = 0; k < dims; k++) {
        b.min[k] = shifted(b.min[k], minus_offset[k], 0);
        b.max[k] = shifted(b.max[k], minus_offset[k], 1);
    }
    box_change(t, slot, &b);
}

static int is_finite(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (bits >> 52 & 0x7ff) != INFINITE;
}

msap_status msap_shift_origin(msap_world *world, const double *offset)
{
    struct number minus_offset[3];
    if (!world) return MSAP_ERROR_NULL;
    if (world->busy) return msap_world_fail(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    if (!offset) return msap_world_fail(world, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND);
    for (uint32_t k = 0; k < world->config.dims; k++) {
        if (!is_finite(offset[k])) return msap_world_fail(world, MSAP_ERROR_CONFIG, 0, k);
        minus_offset[k] = number_of(offset[k]);
        minus_offset[k].negative ^= 1;
    }
    for (uint32_t slot = 0; slot < world->boxes.used; slot++)
        if (world->boxes.at[slot].flags & BOX_LIVE)
            shift_box(&world->boxes, slot, minus_offset, world->config.dims);
    return MSAP_OK;
}
