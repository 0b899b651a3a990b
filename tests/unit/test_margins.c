/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a margin is added outward and never falls short of what was asked, at any
 * magnitude, in any environment of hard.h; where the sum is beyond the floats, it is
 * infinite; and whatever the margin, the events are exact.
 *
 * The function that adds margins is tested from inside (src/internal.h has a struct
 * box of its own, so this file does without checks.h), and what follows from it by
 * msap_stats: boxes within twice the margin of each other are candidates, and a box
 * that has moved by the margin is still where it was put.
 */
#include <check.h>
#include <stdlib.h>

#include "hard.h"

#include "../../src/internal.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))
#define ok(call) ck_assert_int_eq(call, MSAP_OK)

static uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static float float_of_ordered(int32_t ordered)
{
    return float_from_bits(float_bits_from_ordered(ordered));
}

/* ------------------------------------------------------- the sum, from inside */

/* Whether a + b <= limit as real numbers; what is lost in the sum of doubles is known
 * exactly (Knuth's two-sum). */
static int sum_not_above(double a, double b, double limit)
{
    volatile double sum = a + b, part = sum - a;
    volatile double rest_a = a - (sum - part), rest_b = b - part;
    double lost = rest_a + rest_b;
    return sum < limit || (sum == limit && lost <= 0);
}

/* Whether `wide` is `from` and a margin or more, but by a few floats at most. */
static int is_widened(float wide, float from, float margin)
{
    int32_t ordered = ordered_from_float_bits(bits_of(wide));
    if (margin == 0)
        return wide == from;
    return sum_not_above((double)from, (double)margin, (double)wide) &&
           !sum_not_above((double)from, (double)margin, (double)float_of_ordered(ordered - 4));
}

/* Mantissas of all kinds, for every 3rd exponent; the margin's is every 3rd too, so
 * that bounds meet larger, smaller and equal margins, subnormals among both. */
enum { EXPONENTS = 85, MANTISSAS = 4, VALUES = EXPONENTS * MANTISSAS };

static float value_of_row(int row)
{
    static const uint32_t mantissas[MANTISSAS] = {0, 1, 0x2AAAAB, 0x7FFFFF};
    return float_from_bits((uint32_t)(row / MANTISSAS) * 3 << 23 | mantissas[row % MANTISSAS]);
}

/* From -value to value on x, at value on y, at -value on z. */
static struct bounds bounds_of_value(float value)
{
    int32_t up = ordered_from_float_bits(bits_of(value)), down = ordered_from_float_bits(bits_of(-value));
    struct bounds b;
    b.min[0] = b.min[2] = b.max[2] = down;
    b.max[0] = b.max[1] = b.min[1] = up;
    return b;
}

START_TEST(never_smaller_than_asked_and_hardly_larger)
{
    static struct bounds wide[VALUES];
    int i, m, k, wrong = 0;
    for (m = 0; m < VALUES; m++) {
        environment_enter(&environments[_i]);
        for (i = 0; i < VALUES; i++) {
            struct bounds b = bounds_of_value(value_of_row(i));
            wide[i] = msap_bounds_widened(&b, value_of_row(m));
        }
        environment_leave(&environments[_i]);
        for (i = 0; i < VALUES; i++)
            for (k = 0; k < 3; k++) {
                float value = value_of_row(i), margin = value_of_row(m);
                wrong += !is_widened(float_of_ordered(wide[i].max[k]), k == 2 ? -value : value, margin);
                wrong += !is_widened(-float_of_ordered(wide[i].min[k]), k == 1 ? -value : value, margin);
            }
    }
    ck_assert_int_eq(wrong, 0);
}
END_TEST

/* Infinite bounds stay or go outward; what passes FLT_MAX becomes infinite. */
START_TEST(beyond_the_floats)
{
    float inf = float_from_bits(0x7F800000), max = float_from_bits(0x7F7FFFFF), tiny = float_from_bits(1);
    struct bounds infinite = bounds_of_value(inf), last = bounds_of_value(max), a, b, c;
    environment_enter(&environments[_i]);
    a = msap_bounds_widened(&infinite, max);
    b = msap_bounds_widened(&last, max);
    c = msap_bounds_widened(&last, tiny);
    environment_leave(&environments[_i]);
    for (int k = 0; k < 3; k++) /* one by one: vectors read past a box that stands alone */
        ck_assert(a.min[k] <= infinite.min[k] && infinite.max[k] <= a.max[k]);
    ck_assert(b.min[0] == infinite.min[0] && b.max[0] == infinite.max[0]);
    ck_assert(b.max[1] == infinite.max[1] && b.min[2] == infinite.min[2]);
    ck_assert(float_of_ordered(b.min[1]) <= 0 && float_of_ordered(b.min[1]) >= -tiny);
    ck_assert(float_of_ordered(b.max[2]) >= 0 && float_of_ordered(b.max[2]) <= tiny);
    ck_assert(c.min[0] == infinite.min[0] && c.max[1] == infinite.max[1]);
}
END_TEST

/* ------------------------------------------------------------- what follows */

/* An empty world with this margin, in the environment of this row. */
static msap_world *margin_world(float margin, int fixed)
{
    msap_config config;
    msap_world *world = NULL;
    uint32_t k;
    ok(msap_config_init(&config, sizeof config));
    config.margin = margin;
    config.grid = fixed ? MSAP_GRID_FIXED : MSAP_GRID_AUTO;
    for (k = 0; k < 3 && fixed; k++) {
        config.grid_cells[k] = 8;
        config.grid_max[k] = 1;
    }
    ok(msap_create(&config, &world));
    return world;
}

/* A box from `low` to `high` on y, [0, 1] on the others. */
static msap_handle put(msap_world *world, msap_handle handle, float low, float high)
{
    float min[3] = {0, 0, 0}, max[3] = {1, 1, 1};
    min[1] = low;
    max[1] = high;
    if (handle)
        ok(msap_update(world, handle, min, max));
    else
        ok(msap_add(world, min, max, 0, NULL, &handle));
    return handle;
}

static msap_world_stats commit(msap_world *world, uint64_t pairs)
{
    msap_world_stats stats;
    ok(msap_commit(world, NULL, NULL));
    ok(msap_validate(world, NULL));
    stats.struct_size = sizeof stats;
    ok(msap_stats(world, &stats));
    ck_assert_uint_eq(stats.pairs, pairs);
    return stats;
}

/* One box ends at `high`, another is at `low`: no pair, and candidates or not. */
static void are_candidates(float margin, float high, float low, uint64_t expected)
{
    int fixed, swap;
    for (fixed = 0; fixed < 2; fixed++)
        for (swap = 0; swap < 2; swap++) {
            msap_world *world = margin_world(margin, fixed);
            put(world, 0, swap ? -high : low, swap ? -high : low);
            put(world, 0, swap ? -low : high, swap ? -low : high);
            ck_assert_uint_eq(commit(world, 0).candidates, expected);
            ok(msap_destroy(world));
        }
}

/* Volatile, so that it is not put off until the environment is another. */
static float times(uint32_t n, int exponent)
{
    volatile float value = (float)(n * msap_power_of_two(exponent));
    return value;
}

/* At 1 and 3 times a power of two, the gap is just twice the margin of that power; at
 * 1 and 9 times it is too wide. */
START_TEST(within_twice_the_margin_is_near)
{
    int exponent;
    for (exponent = -149; exponent <= 124; exponent += 13) {
        float one = times(1, exponent), three = times(3, exponent), nine = times(9, exponent);
        environment_enter(&environments[_i]);
        are_candidates(one, one, three, 1);
        are_candidates(one, one, nine, 0);
        environment_leave(&environments[_i]);
    }
}
END_TEST

/* A gap of one ulp, and a margin of half an ulp, which a sum of floats would lose. */
START_TEST(margins_below_an_ulp_count)
{
    static const int exponents[] = {-125, -60, -1, 0, 1, 24, 100, 126};
    size_t i;
    for (i = 0; i < COUNT(exponents); i++) {
        float at = times(1, exponents[i]), half = times(1, exponents[i] - 24), next = float_from_bits(bits_of(at) + 1);
        environment_enter(&environments[_i]);
        are_candidates(half, at, next, 1);
        are_candidates(0, at, next, 0);
        environment_leave(&environments[_i]);
    }
}
END_TEST

/* A box that moves by the margin stays in its skin, on either side; further on it gets
 * a new one. */
START_TEST(moving_by_the_margin_moves_nothing)
{
    int exponent;
    for (exponent = -149; exponent <= 124; exponent += 13) {
        float one = times(1, exponent), two = times(2, exponent), nine = times(9, exponent);
        msap_world *world;
        msap_handle handle;
        environment_enter(&environments[_i]);
        world = margin_world(one, 0);
        handle = put(world, 0, 0, one);
        commit(world, 0);
        put(world, handle, one, two);
        ck_assert_uint_eq(commit(world, 0).moves, 0);
        put(world, handle, -one, 0);
        ck_assert_uint_eq(commit(world, 0).moves, 0);
        put(world, handle, -one, nine);
        ck_assert_uint_eq(commit(world, 0).moves, 1);
        ok(msap_destroy(world));
        environment_leave(&environments[_i]);
    }
}
END_TEST

/* With a margin of FLT_MAX all the world is near, and still only what touches is a pair. */
START_TEST(a_margin_that_overflows)
{
    float inf = float_from_bits(0x7F800000), max = float_from_bits(0x7F7FFFFF), below = float_from_bits(0x7F7FFFFE);
    msap_world *world;
    msap_handle handle;
    environment_enter(&environments[_i]);
    world = margin_world(max, 0);
    put(world, 0, max, max);
    put(world, 0, inf, inf);
    put(world, 0, -max, -below);
    put(world, 0, -inf, -inf);
    handle = put(world, 0, 0, 1);
    commit(world, 0);
    put(world, handle, 0, below);
    commit(world, 0);
    put(world, handle, -below, max);
    commit(world, 2);
    put(world, handle, -inf, inf);
    commit(world, 4);
    put(world, handle, max, inf);
    commit(world, 2);
    ok(msap_destroy(world));
    environment_leave(&environments[_i]);
}
END_TEST

/* ------------------------------------------------------------ exact as ever */

enum { BOXES = 60, FRAMES = 40 };

/* Moves, adds or removes some boxes of all worlds, in the same way. */
static void change(msap_world **worlds, size_t n, msap_handle (*handles)[BOXES], uint32_t *random)
{
    int i;
    size_t w;
    for (i = 0; i < BOXES; i++) {
        uint32_t r = *random = *random * 1664525u + 1013904223u;
        float low = (float)(int32_t)(r >> 24) - 128, high = low + (float)(r >> 20 & 15);
        for (w = 0; w < n; w++)
            if (r >> 16 & 7)
                handles[w][i] = put(worlds[w], handles[w][i], low, high);
            else if (handles[w][i]) {
                ok(msap_remove(worlds[w], handles[w][i]));
                handles[w][i] = 0;
            }
    }
}

static void same_pairs(const msap_pair *a, size_t n, const msap_pair *b, size_t m)
{
    size_t i;
    ck_assert_uint_eq(n, m);
    for (i = 0; i < n; i++)
        ck_assert(a[i].a == b[i].a && a[i].b == b[i].b);
}

static void same_events(const msap_world *a, const msap_world *b)
{
    const msap_pair *p, *q;
    size_t n, m;
    ok(msap_created(a, &p, &n));
    ok(msap_created(b, &q, &m));
    same_pairs(p, n, q, m);
    ok(msap_deleted(a, &p, &n));
    ok(msap_deleted(b, &q, &m));
    same_pairs(p, n, q, m);
}

START_TEST(the_events_are_those_without_a_margin)
{
    static const uint32_t margins[] = {0x00000000, 0x00000001, 0x00400000, 0x1E3CE508, 0x3F000000,
                                       0x3F800000, 0x41200000, 0x60AD78EC, 0x7F7FFFFF};
    enum { WORLDS = COUNT(margins) };
    msap_world *worlds[WORLDS];
    static msap_handle handles[WORLDS][BOXES];
    uint32_t random = 1;
    int frame, w;
    memset(handles, 0, sizeof handles);
    environment_enter(&environments[_i]);
    for (w = 0; w < WORLDS; w++)
        worlds[w] = margin_world(float_from_bits(margins[w]), 0);
    for (frame = 0; frame < FRAMES; frame++) {
        change(worlds, WORLDS, handles, &random);
        for (w = 0; w < WORLDS; w++) {
            ok(msap_commit(worlds[w], NULL, NULL));
            ok(msap_validate(worlds[w], NULL));
            same_events(worlds[0], worlds[w]);
        }
    }
    for (w = 0; w < WORLDS; w++)
        ok(msap_destroy(worlds[w]));
    environment_leave(&environments[_i]);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("margins");
    Suite *suite = suite_create("margins");
    SRunner *runner = srunner_create(suite);
    int failed;
    tcase_set_timeout(tests, 0);
    tcase_add_loop_test(tests, never_smaller_than_asked_and_hardly_larger, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, beyond_the_floats, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, within_twice_the_margin_is_near, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, margins_below_an_ulp_count, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, moving_by_the_margin_moves_nothing, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, a_margin_that_overflows, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, the_events_are_those_without_a_margin, 0, (int)ENVIRONMENTS);
    suite_add_tcase(suite, tests);
    srunner_run_all(runner, CK_ENV);
    failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
