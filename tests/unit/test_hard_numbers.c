/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: there is no value that the library gives a meaning of its own. Infinities,
 * FLT_MAX and its neighbours, subnormals, equal end points and empty boxes are
 * ordinary, by the thousand, too.
 */
#include "checks.h"

#define INF float_of(0x7F800000)
#define MAX float_of(0x7F7FFFFF)
#define TINY float_of(0x00000001)

START_TEST(infinite_boxes)
{
    msap_world *world = new_world(3, _i);
    msap_handle all = add(world, cube(-INF, INF)), left = add(world, bar(-INF, 0)), right = add(world, bar(1, INF)),
                at_end = add(world, bar(INF, INF)), at_start = add(world, bar(-INF, -INF)),
                last = add(world, bar(MAX, MAX));
    /* all with 5; left with at_start; right with at_end and last */
    commit(world, 0, 8, 8);
    ck_assert(is_pair(world, left, at_start) && is_pair(world, right, at_end) && is_pair(world, right, last));
    ck_assert(!is_pair(world, at_end, last));
    update(world, right, bar(1, MAX));
    commit(world, 1, 0, 7);
    update(world, left, bar(-INF, INF)); /* meets right, at_end, last */
    commit(world, 0, 3, 10);
    ok(msap_remove(world, all));
    commit(world, 5, 0, 5);
    ok(msap_destroy(world));
}
END_TEST

/* All that is between the infinities, forty times, and points here and there. */
START_TEST(boxes_as_large_as_can_be)
{
    msap_world *world = new_world(3, _i);
    for (int i = 0; i < 40; i++) add(world, cube(-MAX, MAX));
    commit(world, 0, 780, 780);
    for (int i = 0; i < 10; i++) add(world, cube((float)i * (MAX / 10), (float)i * (MAX / 10)));
    commit(world, 0, 400, 1180);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(the_whole_space_leaves_and_returns)
{
    msap_world *world = new_world(3, _i);
    msap_handle all[3];
    int i, round;
    for (i = 0; i < 10; i++)
        add(world, cube((float)(2 * i), (float)(2 * i + 1)));
    for (round = 0; round < 3; round++) {
        for (i = 0; i < 3; i++)
            all[i] = add(world, cube(-INF, INF));
        commit(world, 0, 33, 33);
        for (i = 0; i < 3; i++)
            update(world, all[i], cube(INF, INF));
        commit(world, 30, 0, 3);
        for (i = 0; i < 3; i++)
            ok(msap_remove(world, all[i]));
        commit(world, 3, 0, 0);
    }
    ok(msap_destroy(world));
}
END_TEST

/* Bars that touch at `at`, then part by one unit in the last place. */
static void touch_and_part(int row, uint32_t at)
{
    msap_world *world = new_world(3, row);
    float value = float_of(at), above = float_of(at + 1);
    msap_handle b;
    add(world, bar(-MAX, value));
    b = add(world, bar(value, INF));
    commit(world, 0, 1, 1);
    update(world, b, bar(above, INF));
    commit(world, 1, 0, 0);
    add(world, bar(value, above)); /* bridges both */
    commit(world, 0, 2, 2);
    ok(msap_destroy(world));
}

START_TEST(one_ulp_apart)
{
    touch_and_part(_i, 0x00000000); /* 0 */
    touch_and_part(_i, 0x00000001); /* subnormals */
    touch_and_part(_i, 0x007FFFFF); /* the last of them */
    touch_and_part(_i, 0x3F800000); /* 1 */
    touch_and_part(_i, 0x4B189680); /* 1e7 */
    touch_and_part(_i, 0x7EFFFFFF); /* FLT_MAX / 2 */
    touch_and_part(_i, 0x7F7FFFFE); /* below FLT_MAX */
    touch_and_part(_i, 0x7F7FFFFF); /* FLT_MAX, and then infinity */
}
END_TEST

START_TEST(subnormals_are_not_zero)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(-1, -TINY)), zero = add(world, bar(0, 0)), b = add(world, bar(TINY, 1));
    commit(world, 0, 0, 0);
    update(world, zero, bar(0, TINY));
    commit(world, 0, 1, 1);
    update(world, zero, bar(-TINY, 0));
    commit(world, 1, 1, 1);
    ck_assert(is_pair(world, a, zero));
    update(world, b, bar(-TINY, -TINY));
    commit(world, 0, 2, 3);
    ok(msap_destroy(world));
}
END_TEST

/* 520 boxes that are the same: 134940 pairs; half of them steps aside and back. */
START_TEST(identical_boxes)
{
    static msap_handle handles[520];
    msap_world *world = new_world(3, _i);
    int i;
    for (i = 0; i < 520; i++)
        handles[i] = add(world, cube(1, 2));
    commit(world, 0, 134940, 134940);
    for (i = 0; i < 260; i++)
        update(world, handles[i], cube(3, 4));
    commit(world, 67600, 0, 67340);
    for (i = 0; i < 260; i++)
        update(world, handles[i], cube(2, 3)); /* touching */
    commit(world, 0, 67600, 134940);
    for (i = 0; i < 519; i++)
        ok(msap_remove(world, handles[i]));
    commit(world, 134940, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

/* 3000 points on one spot, in two layers that do not meet. */
START_TEST(points_on_a_spot)
{
    static msap_handle handles[3000];
    msap_world *world = new_world(2, _i);
    int i;
    for (i = 0; i < 3000; i++)
        handles[i] = add_flagged(world, i < 30 ? cube(5, 5) : box_of(5, 6, 0, 5, 6, 0), i < 30 ? 0 : MSAP_STATIC);
    commit(world, 0, 435, 435); /* the first 30 */
    for (i = 0; i < 3000; i++)
        update(world, handles[i], box_of(7, 7, 0, 7, 7, 0));
    commit(world, 0, 30 * 2970, 435 + 30 * 2970);
    ok(msap_destroy(world));
}
END_TEST

/* Random boxes of hard numbers, against brute force. */
START_TEST(random_hard_boxes)
{
    int seed, frame;
    for (seed = 0; seed < 6; seed++) {
        msap_config config = config_of(seed % 2 ? 2 : 3, _i);
        session s;
        right(session_open(&s, &config, (uint64_t)seed, SCENE_HARD));
        for (frame = 0; frame < 30; frame++)
            right(session_step(&s, 60));
        right(session_close(&s));
    }
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("hard numbers");
    tcase_add_loop_test(tests, infinite_boxes, 0, SETUPS);
    tcase_add_loop_test(tests, boxes_as_large_as_can_be, 0, SETUPS);
    tcase_add_loop_test(tests, the_whole_space_leaves_and_returns, 0, SETUPS);
    tcase_add_loop_test(tests, one_ulp_apart, 0, SETUPS);
    tcase_add_loop_test(tests, subnormals_are_not_zero, 0, SETUPS);
    tcase_add_loop_test(tests, identical_boxes, 0, SETUPS);
    tcase_add_loop_test(tests, points_on_a_spot, 0, SETUPS);
    tcase_add_loop_test(tests, random_hard_boxes, 0, SETUPS);
    return run_case(tests, "hard numbers");
}
