/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: two static boxes never pair, however they move; a static box pairs with
 * any other; being static lasts as long as the box and no longer.
 */
#include "checks.h"

START_TEST(two_statics_never_pair)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add_flagged(world, cube(0, 1), MSAP_STATIC), b = add_flagged(world, cube(0, 1), MSAP_STATIC);
    commit(world, 0, 0, 0);
    update(world, a, cube(5, 6));
    commit(world, 0, 0, 0);
    update(world, b, cube(5.5f, 7));
    commit(world, 0, 0, 0);
    ck_assert(!is_pair(world, a, b));
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_static_pairs_with_a_mover)
{
    msap_world *world = new_world(3, _i);
    msap_handle ground = add_flagged(world, box_of(-9, -9, -1, 9, 9, 0), MSAP_STATIC);
    msap_handle mover = add(world, cube(0, 1)), wall;
    commit(world, 0, 1, 1);
    wall = add_flagged(world, box_of(-9, -9, -9, -8, 9, 9), MSAP_STATIC); /* into the ground */
    commit(world, 0, 0, 1);
    update(world, mover, box_of(-9, 0, 1, -8, 1, 2)); /* off the ground, into the wall */
    commit(world, 1, 1, 1);
    ck_assert(is_pair(world, wall, mover));
    update(world, ground, box_of(-9, -9, -1, 9, 9, 1)); /* a static box may be moved */
    commit(world, 0, 1, 2);
    update(world, ground, box_of(-9, -9, -1, 9, 9, 0.5f));
    commit(world, 1, 0, 1);
    ok(msap_destroy(world));
}
END_TEST

/* The flag goes with its box, not with its slot. */
START_TEST(a_reused_slot_is_not_static)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add_flagged(world, cube(0, 1), MSAP_STATIC), b = add_flagged(world, cube(0, 1), MSAP_STATIC);
    commit(world, 0, 0, 0);
    ok(msap_remove(world, a));
    commit(world, 0, 0, 0);
    a = add(world, cube(0, 1));
    ck_assert_uint_eq(a >> 32, 0);
    commit(world, 0, 1, 1);
    ok(msap_remove(world, a));
    ok(msap_remove(world, b));
    commit(world, 1, 0, 0);
    add_flagged(world, cube(0, 1), MSAP_STATIC);
    add_flagged(world, cube(0, 1), MSAP_STATIC);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

/* 30 boxes in one place, every third static: 435 pairs without the 45 among them. */
START_TEST(a_heap)
{
    msap_world *world = new_world(3, _i);
    uint32_t flags[30], i;
    box bounds[30];
    msap_handle handles[30];
    msap_boxes boxes;
    for (i = 0; i < 30; i++) {
        bounds[i] = cube(0, (float)i);
        flags[i] = i % 3 ? 0 : MSAP_STATIC;
    }
    boxes = boxes_in_row(bounds);
    ok(msap_add_many(world, 30, &boxes, flags, NULL, handles));
    commit(world, 0, 390, 390);
    for (i = 0; i < 30; i++) /* in a row, apart */
        update(world, handles[i], cube((float)(2 * i), (float)(2 * i + 1)));
    commit(world, 390, 0, 0);
    for (i = 0; i < 30; i++)
        update(world, handles[i], flags[i] ? cube(0, 1) : cube(9, 10));
    commit(world, 0, 190, 190); /* the 20 others among themselves */
    ok(msap_destroy(world));
}
END_TEST

START_TEST(many_statics_one_mover)
{
    msap_world *world = new_world(3, _i);
    msap_handle mover;
    int i;
    for (i = 0; i < 1000; i++)
        add_flagged(world, cube((float)(i % 10), (float)(i % 10 + 2)), MSAP_STATIC);
    commit(world, 0, 0, 0);
    mover = add(world, cube(4.5f, 4.75f)); /* in the cubes from 3 and from 4 */
    commit(world, 0, 200, 200);
    update(world, mover, cube(20, 21));
    commit(world, 200, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("static boxes");
    tcase_add_loop_test(tests, two_statics_never_pair, 0, SETUPS);
    tcase_add_loop_test(tests, a_static_pairs_with_a_mover, 0, SETUPS);
    tcase_add_loop_test(tests, a_reused_slot_is_not_static, 0, SETUPS);
    tcase_add_loop_test(tests, a_heap, 0, SETUPS);
    tcase_add_loop_test(tests, many_statics_one_mover, 0, SETUPS);
    return run_case(tests, "static boxes");
}
