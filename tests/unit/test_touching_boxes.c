/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: intervals are closed. Boxes that share only a face, an edge or a corner
 * are a pair, whichever way they came to touch; one unit in the last place between
 * them and they are none.
 */
#include "checks.h"

/* The unit cube at 0, and one beyond its side `axis` in direction `up`. */
static box neighbour(int axis, int up)
{
    box result = cube(0, 1);
    result.min[axis] = up ? 1 : -1;
    result.max[axis] = up ? 2 : 0;
    return result;
}

START_TEST(faces_touch)
{
    int axis, up;
    for (axis = 0; axis < 3; axis++)
        for (up = 0; up < 2; up++) {
            msap_world *world = new_world(3, _i);
            msap_handle a = add(world, cube(0, 1)), b = add(world, neighbour(axis, up));
            commit(world, 0, 1, 1);
            ck_assert(is_pair(world, a, b));
            ok(msap_destroy(world));
        }
}
END_TEST

START_TEST(edges_and_corners_touch)
{
    static const float edge[6] = {1, 1, 0, 2, 2, 1}, corner[6] = {-1, 1, -1, 0, 2, 0};
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), b, c;
    ok(msap_add(world, edge, edge + 3, 0, NULL, &b));
    ok(msap_add(world, corner, corner + 3, 0, NULL, &c));
    commit(world, 0, 2, 2);
    ck_assert(is_pair(world, a, b));
    ck_assert(is_pair(world, a, c));
    ck_assert(!is_pair(world, b, c)); /* x: [1, 2] and [-1, 0] */
    ok(msap_destroy(world));
}
END_TEST

START_TEST(one_ulp_apart_is_no_pair)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(0, 1)), b = add(world, bar(float_of(0x3F800001), 2));
    commit(world, 0, 0, 0);
    update(world, a, bar(0, float_of(0x3F800001)));
    commit(world, 0, 1, 1);
    update(world, b, bar(float_of(0x3F800002), 2));
    commit(world, 1, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(zeros_of_both_signs_touch)
{
    float zero = float_of(0x80000000);
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(-1, 0)), b = add(world, bar(0, 1)), c = add(world, bar(-1, zero)),
                d = add(world, bar(zero, 1));
    commit(world, 0, 6, 6);
    ok(msap_remove(world, b));
    ok(msap_remove(world, c));
    commit(world, 5, 0, 1);
    ck_assert(is_pair(world, a, d));
    update(world, a, bar(-1, zero));
    update(world, d, bar(0, 1));
    commit(world, 0, 0, 1);
    ok(msap_destroy(world));
}
END_TEST

/* Approaching until they touch begins a pair; parting until they touch ends none. */
START_TEST(approaching_and_parting)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(0, 1)), b = add(world, bar(5, 6));
    commit(world, 0, 0, 0);
    update(world, b, bar(1, 2)); /* from the right, to touch */
    commit(world, 0, 1, 1);
    update(world, b, bar(0.5f, 1.5f));
    commit(world, 0, 0, 1);
    update(world, b, bar(1, 2)); /* parting, to touch */
    commit(world, 0, 0, 1);
    update(world, b, bar(-1, 0)); /* to touch on the other side */
    commit(world, 0, 0, 1);
    update(world, b, bar(-2, -1));
    commit(world, 1, 0, 0);
    update(world, a, bar(-1, 0)); /* the other comes after */
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_box_without_size_touches)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), point = add(world, cube(1, 1)), twin = add(world, cube(1, 1));
    commit(world, 0, 3, 3);
    ck_assert(is_pair(world, a, point));
    ck_assert(is_pair(world, twin, point));
    update(world, point, box_of(1, 1, 1.25f, 1, 1, 1.25f));
    commit(world, 2, 0, 1);
    update(world, point, box_of(0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f));
    commit(world, 0, 1, 2);
    ok(msap_destroy(world));
}
END_TEST

/* 100 bars in a row, each touching the next: 99 pairs, and still so when all move. */
START_TEST(a_row_of_boxes)
{
    msap_world *world = new_world(3, _i);
    msap_handle handles[100];
    int i;
    for (i = 0; i < 100; i++)
        handles[i] = add(world, bar((float)i, (float)(i + 1)));
    commit(world, 0, 99, 99);
    for (i = 0; i < 100; i++)
        update(world, handles[i], bar((float)(i + 1), (float)(i + 2)));
    commit(world, 0, 0, 99);
    for (i = 0; i < 100; i++)
        update(world, handles[i], bar((float)(2 * i), (float)(2 * i + 1)));
    commit(world, 99, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("touching boxes");
    tcase_add_loop_test(tests, faces_touch, 0, SETUPS);
    tcase_add_loop_test(tests, edges_and_corners_touch, 0, SETUPS);
    tcase_add_loop_test(tests, one_ulp_apart_is_no_pair, 0, SETUPS);
    tcase_add_loop_test(tests, zeros_of_both_signs_touch, 0, SETUPS);
    tcase_add_loop_test(tests, approaching_and_parting, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_without_size_touches, 0, SETUPS);
    tcase_add_loop_test(tests, a_row_of_boxes, 0, SETUPS);
    return run_case(tests, "touching boxes");
}
