/* Harness: numbers. Any bits as bounds, floats and doubles: which are refused and for
 * what, how doubles are rounded, what is read back, which boxes overlap; the encoding
 * of floats; and the shift of the origin, to the last bit.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "scene.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { MOST = 12 };

/* ----------------------------------------------------------------- encoding */

static uint32_t is_nan(float x) { return (bits_of(x) & 0x7FFFFFFF) > 0x7F800000; }

/* NaNs lie beyond the infinities, by sign. */
static void check_encoding(float x, float y)
{
    uint32_t a = msap_encode_float(x), b = msap_encode_float(y);
    if (msap_encode_float(msap_decode_float(a)) != a)
        fuzz_check("an encoded float is another after decoding");
    if (is_nan(x)) {
        int beyond = bits_of(x) >> 31 ? a < msap_encode_float(-INFINITY) : a > msap_encode_float(INFINITY);
        if (!beyond || bits_of(msap_decode_float(a)) != bits_of(x))
            fuzz_check("a NaN is encoded among the numbers");
        return;
    }
    if (msap_decode_float(a) != x || (x == 0 && bits_of(msap_decode_float(a)) != 0))
        fuzz_check("a float is not what it was encoded from");
    if (!is_nan(y) && ((x < y) != (a < b) || (x == y) != (a == b)))
        fuzz_check("encoded floats are in another order");
}

/* ------------------------------------------------------------------- bounds */

/* A box as it is given: floats or doubles. */
typedef struct given {
    double min[3], max[3];
} given;

static double take_bound(input *in, uint32_t scalar, uint32_t shape)
{
    if (scalar == MSAP_FLOAT || shape == 0)
        return shape % 2 ? take_float(in) : take_hard(in);
    if (shape % 2)
        return take_double(in);
    return (double)take_hard(in) * (1 + ((double)take(in, 1) - 128) * DBL_EPSILON);
}

static given take_given(input *in, uint32_t scalar)
{
    uint32_t shape = (uint32_t)take(in, 1);
    given g;
    int c;
    for (c = 0; c < 3; c++) {
        g.min[c] = take_bound(in, scalar, shape & 3);
        g.max[c] = shape & 4 ? g.min[c] : take_bound(in, scalar, shape & 3);
        if ((shape & 8) && g.min[c] > g.max[c]) {
            double swap = g.min[c];
            g.min[c] = g.max[c];
            g.max[c] = swap;
        }
    }
    return g;
}

/* What is wrong with bound c of a box; of an inverted axis, the min is. */
static msap_status fault(const given *g, uint32_t dims, uint32_t c)
{
    if (c % 3 >= dims)
        return MSAP_OK;
    if (isnan(c < 3 ? g->min[c] : g->max[c - 3]))
        return MSAP_ERROR_NAN;
    return c < 3 && g->min[c] > g->max[c] ? MSAP_ERROR_INVERTED : MSAP_OK;
}

/* What the contract says of a box: a NaN goes before inverted bounds. */
static msap_status verdict(const given *g, uint32_t dims)
{
    msap_status status = MSAP_OK;
    uint32_t c;
    for (c = 0; c < 6; c++)
        if (fault(g, dims, c) == MSAP_ERROR_NAN)
            return MSAP_ERROR_NAN;
        else if (fault(g, dims, c) != MSAP_OK)
            status = MSAP_ERROR_INVERTED;
    return status;
}

static float next_down(float x) { return nextafterf(x, -INFINITY); }
static float next_up(float x) { return nextafterf(x, INFINITY); }

/* The nearest floats outward, as signless zeros; exact, so no arithmetic is needed. */
static void check_bounds(const given *g, const box *b, uint32_t dims)
{
    uint32_t c;
    for (c = 0; c < dims; c++) {
        if (!(b->min[c] <= g->min[c]) || (b->min[c] < INFINITY && next_up(b->min[c]) <= g->min[c]))
            fuzz_check("a min is not the nearest float at or below what was given");
        if (!(b->max[c] >= g->max[c]) || (b->max[c] > -INFINITY && next_down(b->max[c]) >= g->max[c]))
            fuzz_check("a max is not the nearest float at or above what was given");
        if (bits_of(b->min[c]) == 0x80000000u || bits_of(b->max[c]) == 0x80000000u)
            fuzz_check("-0 was not made +0");
    }
}

/* -------------------------------------------------------------------- shift */

/* How far value - offset is from `bound`: less than 0, 0 or more. Both sums are exact
 * in two parts, and the second part is at most half a unit of the first. */
static double compare_difference(double value, double offset, double bound)
{
    double sum = value - offset, part = sum - value, rest = (value - (sum - part)) + (-offset - part);
    return sum != bound ? sum - bound : rest;
}

static void check_shifted(float from, float to, double offset, int up)
{
    double side = up ? 1 : -1;
    float inner = up ? next_down(to) : next_up(to);
    if (isinf(from)) {
        fuzz_check(from == to ? NULL : "an infinite bound was shifted");
        return;
    }
    if (!isinf(to) && compare_difference(from, offset, to) * side > 0)
        fuzz_check("a shifted bound was rounded inward");
    if (isinf(to) && to * side < 0)
        fuzz_check("a shifted bound became the wrong infinity");
    if (!isinf(inner) && compare_difference(from, offset, inner) * side <= 0)
        fuzz_check("a shifted bound was rounded further than to the next float");
}

/* ------------------------------------------------------------------ a world */

typedef struct range {
    msap_world *world;
    uint32_t dims;
    size_t n;
    msap_handle handle[MOST];
    box bounds[MOST]; /* as the world has them */
} range;

static void read_back(const range *r, size_t i, box *b)
{
    if (msap_get_bounds(r->world, r->handle[i], b->min, b->max) != MSAP_OK)
        fuzz_check("msap_get_bounds failed");
}

/* The error names the box at fault, and one of its bounds that are. */
static void refused_for(const range *r, msap_status status, const given *g, uint64_t index)
{
    msap_error error;
    error.struct_size = sizeof error;
    if (msap_last_error(r->world, &error) != MSAP_OK || error.status != (uint32_t)status || error.index != index)
        fuzz_check("the last error names another status or box");
    if (error.bound >= 6 || fault(&g[index], r->dims, error.bound) != status)
        fuzz_check("the last error names a bound that is not at fault");
}

/* As floats or doubles, with strides that leave gaps. */
static msap_boxes spaced_out(const given *g, size_t k, uint32_t scalar, unsigned char *memory)
{
    size_t size = scalar == MSAP_FLOAT ? sizeof(float) : sizeof(double), row = 7 * size + 1, i, c;
    msap_boxes boxes = {sizeof boxes, 0, NULL, NULL, 0, 0, 0, 0};
    boxes.scalar = scalar;
    boxes.min = memory;
    boxes.max = memory + 4 * size;
    boxes.min_row = boxes.max_row = (ptrdiff_t)row;
    boxes.min_component = boxes.max_component = (ptrdiff_t)size;
    for (i = 0; i < k; i++)
        for (c = 0; c < 6; c++) {
            double value = c < 3 ? g[i].min[c] : g[i].max[c - 3];
            float narrow = (float)value;
            memcpy(memory + i * row + (c < 3 ? c : c + 1) * size, scalar == MSAP_FLOAT ? (void *)&narrow : &value,
                   size);
        }
    return boxes;
}

/* Adds or updates up to 4 boxes in one call and compares what comes of it. */
static void give_boxes(range *r, input *in)
{
    static unsigned char memory[4 * (7 * sizeof(double) + 1)];
    uint32_t how = (uint32_t)take(in, 1), scalar = how & 1;
    int is_update = (how & 2) && r->n >= 4;
    size_t k = 1 + (how >> 2) % 4, at, bad = 0, i;
    given g[4];
    msap_boxes boxes;
    msap_status expected = MSAP_OK, status;
    if (!is_update && r->n + k > MOST)
        return;
    at = is_update ? (how >> 4) % (r->n - k + 1) : r->n;
    for (i = 0; i < k; i++) {
        g[i] = take_given(in, scalar);
        if (expected == MSAP_OK) {
            expected = verdict(&g[i], r->dims);
            bad = i;
        }
    }
    boxes = spaced_out(g, k, scalar, memory);
    status = is_update ? msap_update_many(r->world, k, r->handle + at, &boxes)
                       : msap_add_many(r->world, k, &boxes, NULL, NULL, r->handle + at);
    if (status != expected)
        fuzz_check("bounds came to another status");
    if (status != MSAP_OK) {
        refused_for(r, status, g, bad);
        return;
    }
    for (i = 0; i < k; i++) {
        read_back(r, at + i, &r->bounds[at + i]);
        check_bounds(&g[i], &r->bounds[at + i], r->dims);
    }
    r->n += is_update ? 0 : k;
}

static void shift(range *r, input *in)
{
    double offset[3];
    size_t i;
    uint32_t c, is_finite = 1, shape = (uint32_t)take(in, 1);
    msap_status status;
    for (c = 0; c < 3; c++) {
        offset[c] = take_bound(in, MSAP_DOUBLE, shape & 3);
        is_finite &= c >= r->dims || isfinite(offset[c]);
    }
    status = msap_shift_origin(r->world, offset);
    if (status != (is_finite ? MSAP_OK : MSAP_ERROR_CONFIG))
        fuzz_check("msap_shift_origin came to another status");
    for (i = 0; i < r->n; i++) {
        box from = r->bounds[i];
        read_back(r, i, &r->bounds[i]);
        for (c = 0; c < r->dims; c++) {
            check_shifted(from.min[c], r->bounds[i].min[c], is_finite ? offset[c] : 0, 0);
            check_shifted(from.max[c], r->bounds[i].max[c], is_finite ? offset[c] : 0, 1);
        }
    }
}

static void commit(const range *r)
{
    size_t i, j, overlaps = 0;
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    const char *what = NULL;
    if (msap_commit(r->world, NULL, &counts) != MSAP_OK || msap_validate(r->world, &what) != MSAP_OK)
        fuzz_check(what ? what : "msap_commit failed");
    for (i = 0; i < r->n; i++)
        for (j = i + 1; j < r->n; j++) {
            void *data;
            msap_status status = msap_get_pair_data(r->world, 1, &r->handle[i], &r->handle[j], &data);
            int is_pair = boxes_overlap(&r->bounds[i], &r->bounds[j], r->dims);
            overlaps += (size_t)is_pair;
            if (status != (is_pair ? MSAP_OK : MSAP_ERROR_NOT_A_PAIR))
                fuzz_check("the world has another opinion on an overlap");
        }
    if (counts.active != overlaps)
        fuzz_check("the world counts other pairs");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = {data, data + size};
    msap_config config;
    range r;
    memset(&r, 0, sizeof r);
    r.dims = take(&in, 1) & 1 ? 2 : 3;
    config = take_config(&in, r.dims);
    if (msap_create(&config, &r.world) != MSAP_OK)
        fuzz_check("msap_create failed");
    while (in.at < in.end) {
        uint32_t what = (uint32_t)take(&in, 1);
        if (what % 8 == 0) {
            float x = take_float(&in);
            check_encoding(x, what & 8 ? float_of(bits_of(x) + 1) : what & 16 ? take_hard(&in) : take_float(&in));
        } else if (what % 8 == 1)
            shift(&r, &in);
        else if (what % 8 < 4)
            commit(&r);
        else
            give_boxes(&r, &in);
    }
    commit(&r);
    msap_destroy(r.world);
    return 0;
}
