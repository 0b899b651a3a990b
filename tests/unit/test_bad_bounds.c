/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a NaN, whatever its sign and payload, and a min above its max, be it by
 * one unit in the last place, are refused by every call that takes bounds; the error
 * names index and bound, and nothing else changed. (Box pruning: test_prune.c.)
 */
#include <string.h>

#include "checks.h"

static const uint32_t nans[] = {
    0x7FC00000, 0xFFC00000, 0x7F800001, 0xFF800001, 0x7FFFFFFF, 0xFFFFFFFF, 0x7FA12345, 0xFFA54321,
};

/* Neighbours, the lower first. */
static const uint32_t neighbours[][2] = {
    {0x00000000, 0x00000001}, {0x80000001, 0x00000000}, {0x80000001, 0x80000000}, {0x3F800000, 0x3F800001},
    {0xBF800001, 0xBF800000}, {0x007FFFFF, 0x00800000}, {0x7F7FFFFF, 0x7F800000}, {0xFF800000, 0xFF7FFFFF},
};

#define ROW 7

/* A world with a pair, a lonely box, one removed and one pending update; a row of
 * ROW good boxes; and the handles of ROW boxes of the world. */
typedef struct scenario {
    session s;
    msap_handle handles[ROW], removed;
    box row[ROW];
} scenario;

static void scenario_open(scenario *t, uint32_t dims)
{
    msap_config config = config_of(dims, DEFAULT);
    int i;
    right(session_open(&t->s, &config, 1, SCENE_GRID));
    for (i = 0; i < ROW; i++) {
        t->row[i] = bar((float)(3 * i), (float)(3 * i + i % 4));
        right(session_add(&t->s, &t->row[i], 0, &t->handles[i]));
    }
    right(session_add(&t->s, &t->row[3], 0, &t->removed));
    right(session_commit(&t->s));
    right(session_remove(&t->s, t->removed));
    right(session_update(&t->s, t->handles[2], &t->row[3]));
}

/* Nothing changed, and the next commit is the reference's. */
static void scenario_close(scenario *t)
{
    right(session_compare(&t->s));
    right(session_commit(&t->s));
    right(session_compare(&t->s));
    right(session_close(&t->s));
}

/* Every call refuses `bad`, with this status and bound. */
static void all_refuse(scenario *t, const box *bad, msap_status status, msap_bound bound)
{
    msap_handle handle = 77, handles[ROW] = {1, 2, 3, 4, 5, 6, 7};
    msap_boxes boxes = boxes_in_row(t->row);
    size_t i;
    refused(msap_add(t->s.world, bad->min, bad->max, 0, NULL, &handle), status);
    last_error(t->s.world, status, 0, bound);
    ck_assert_uint_eq(handle, 77);
    refused(msap_update(t->s.world, t->handles[1], bad->min, bad->max), status);
    last_error(t->s.world, status, 0, bound);
    for (i = 0; i < ROW; i++) {
        box good = t->row[i];
        t->row[i] = *bad;
        refused(msap_add_many(t->s.world, ROW, &boxes, NULL, NULL, handles), status);
        last_error(t->s.world, status, i, bound);
        refused(msap_update_many(t->s.world, ROW, t->handles, &boxes), status);
        last_error(t->s.world, status, i, bound);
        t->row[i] = good;
    }
    for (i = 0; i < ROW; i++)
        ck_assert_uint_eq(handles[i], i + 1);
    right(session_compare(&t->s));
}

START_TEST(a_nan_in_any_bound)
{
    scenario t;
    uint32_t dims = (uint32_t)_i, axis;
    size_t n;
    scenario_open(&t, dims);
    for (n = 0; n < COUNT(nans); n++)
        for (axis = 0; axis < dims; axis++) {
            box bad = cube(0, 1);
            bad.min[axis] = float_of(nans[n]);
            all_refuse(&t, &bad, MSAP_ERROR_NAN, (msap_bound)axis);
            bad.min[axis] = 0;
            bad.max[axis] = float_of(nans[n]);
            all_refuse(&t, &bad, MSAP_ERROR_NAN, (msap_bound)(axis + 3));
        }
    scenario_close(&t);
}
END_TEST

START_TEST(min_above_max_by_one_ulp)
{
    scenario t;
    uint32_t dims = (uint32_t)_i, axis;
    size_t n;
    scenario_open(&t, dims);
    for (n = 0; n < COUNT(neighbours); n++)
        for (axis = 0; axis < dims; axis++) {
            box bad = cube(0, 1);
            bad.min[axis] = float_of(neighbours[n][1]);
            bad.max[axis] = float_of(neighbours[n][0]);
            all_refuse(&t, &bad, MSAP_ERROR_INVERTED, (msap_bound)axis);
        }
    scenario_close(&t);
}
END_TEST

START_TEST(min_far_above_max)
{
    scenario t;
    box bad = box_of(0, 0, float_of(0x7F800000), 1, 1, float_of(0xFF800000));
    scenario_open(&t, 3);
    all_refuse(&t, &bad, MSAP_ERROR_INVERTED, MSAP_MIN_Z);
    scenario_close(&t);
}
END_TEST

/* Of several bad boxes the first counts, whatever is wrong with it. */
START_TEST(the_first_offender_is_named)
{
    scenario t;
    msap_handle handles[ROW];
    uint32_t flags[ROW] = {0};
    msap_boxes boxes;
    scenario_open(&t, 3);
    boxes = boxes_in_row(t.row);
    t.row[2].min[1] = 2; /* above its max, 1 */
    t.row[5].max[2] = float_of(nans[0]);
    refused(msap_add_many(t.s.world, ROW, &boxes, NULL, NULL, handles), MSAP_ERROR_INVERTED);
    last_error(t.s.world, MSAP_ERROR_INVERTED, 2, MSAP_MIN_Y);
    t.handles[1] = t.removed;
    refused(msap_update_many(t.s.world, ROW, t.handles, &boxes), MSAP_ERROR_HANDLE);
    last_error(t.s.world, MSAP_ERROR_HANDLE, 1, MSAP_NO_BOUND);
    t.row[2].min[1] = 0;
    flags[6] = 2;
    refused(msap_add_many(t.s.world, ROW, &boxes, flags, NULL, handles), MSAP_ERROR_NAN);
    last_error(t.s.world, MSAP_ERROR_NAN, 5, MSAP_MAX_Z);
    flags[4] = 0x80000000;
    refused(msap_add_many(t.s.world, ROW, &boxes, flags, NULL, handles), MSAP_ERROR_CONFIG);
    last_error(t.s.world, MSAP_ERROR_CONFIG, 4, MSAP_NO_BOUND);
    scenario_close(&t);
}
END_TEST

/* Doubles whose NaN or inversion is lost when they are made floats. */
START_TEST(doubles)
{
    uint64_t bits = UINT64_C(0x7FF0000000000001);
    double min[3] = {0, 0, 0}, max[3] = {1, 1, 1}, above = 1 + 0x1p-52;
    msap_boxes boxes = {sizeof boxes, MSAP_DOUBLE, NULL, NULL, 24, 8, 24, 8};
    scenario t;
    msap_handle handle = 77;
    scenario_open(&t, 3);
    boxes.min = min;
    boxes.max = max;
    memcpy(&min[1], &bits, sizeof bits);
    refused(msap_add_many(t.s.world, 1, &boxes, NULL, NULL, &handle), MSAP_ERROR_NAN);
    last_error(t.s.world, MSAP_ERROR_NAN, 0, MSAP_MIN_Y);
    min[1] = 0;
    bits = UINT64_C(0xFFF0000000000001);
    memcpy(&max[2], &bits, sizeof bits);
    refused(msap_update_many(t.s.world, 1, t.handles, &boxes), MSAP_ERROR_NAN);
    last_error(t.s.world, MSAP_ERROR_NAN, 0, MSAP_MAX_Z);
    max[2] = 1;
    min[0] = above; /* rounded outward it would be 1, as its max is */
    refused(msap_add_many(t.s.world, 1, &boxes, NULL, NULL, &handle), MSAP_ERROR_INVERTED);
    last_error(t.s.world, MSAP_ERROR_INVERTED, 0, MSAP_MIN_X);
    refused(msap_update_many(t.s.world, 1, t.handles, &boxes), MSAP_ERROR_INVERTED);
    ck_assert_uint_eq(handle, 77);
    scenario_close(&t);
}
END_TEST

/* What is nearly bad is good. */
START_TEST(equal_bounds_are_legal)
{
    msap_world *world = new_world(3, DEFAULT);
    float minus_zero = float_of(0x80000000);
    msap_handle a = add(world, cube(0, minus_zero)), b = add(world, cube(minus_zero, 0));
    add(world, cube(float_of(0xFF800000), float_of(0xFF800000)));
    add(world, cube(float_of(0x7F800000), float_of(0x7F800000)));
    commit(world, 0, 1, 1);
    ck_assert(is_pair(world, a, b));
    last_error(world, MSAP_OK, 0, MSAP_NO_BOUND);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("bad bounds");
    tcase_add_loop_test(tests, a_nan_in_any_bound, 2, 4);
    tcase_add_loop_test(tests, min_above_max_by_one_ulp, 2, 4);
    tcase_add_test(tests, min_far_above_max);
    tcase_add_test(tests, the_first_offender_is_named);
    tcase_add_test(tests, doubles);
    tcase_add_test(tests, equal_bounds_are_legal);
    return run_case(tests, "bad bounds");
}
