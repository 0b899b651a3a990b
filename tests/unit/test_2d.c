/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a 2D world carries two axes. It reads and writes two numbers of each
 * bound and no more, pairs boxes that overlap on x and y whatever z would be, and
 * takes less memory than a 3D world.
 */
#include "checks.h"

/* A copy with nothing behind it, so that a read too far is seen by the sanitizers. */
static float *exactly(float x, float y)
{
    float *bound = malloc(2 * sizeof *bound);
    ck_assert_ptr_nonnull(bound);
    bound[0] = x;
    bound[1] = y;
    return bound;
}

START_TEST(two_numbers_are_read_and_written)
{
    msap_world *world = new_world(2, _i);
    float *low = exactly(1, 2), *high = exactly(3, 4), *min = exactly(0, 0), *max = exactly(0, 0);
    msap_boxes boxes = {sizeof boxes, MSAP_FLOAT, NULL, NULL, 8, 4, 8, 4};
    msap_handle a, b;
    boxes.min = low;
    boxes.max = high;
    ok(msap_add(world, low, high, 0, NULL, &a));
    ok(msap_add_many(world, 1, &boxes, NULL, NULL, &b));
    commit(world, 0, 1, 1);
    ok(msap_update(world, a, high, high));
    ok(msap_update_many(world, 1, &b, &boxes));
    commit(world, 0, 0, 1);
    ok(msap_get_bounds(world, a, min, max));
    ck_assert(min[0] == 3 && min[1] == 4 && max[0] == 3 && max[1] == 4);
    ok(msap_get_bounds(world, b, min, max));
    ck_assert(min[0] == 1 && min[1] == 2 && max[0] == 3 && max[1] == 4);
    ok(msap_destroy(world));
    free(low);
    free(high);
    free(min);
    free(max);
}
END_TEST

/* z is far apart, not a number, inverted: nobody looks. */
START_TEST(z_does_not_matter)
{
    float nan = float_of(0x7FC00000);
    msap_world *world = new_world(2, _i);
    msap_handle a = add(world, box_of(0, 0, 0, 1, 1, 1)), b = add(world, box_of(1, 1, 100, 2, 2, -100)),
                c = add(world, box_of(1, 0, nan, 1, 1, nan)), d = add(world, box_of(0, 2, 0, 1, 3, 1));
    commit(world, 0, 4, 4);
    ck_assert(is_pair(world, a, b) && is_pair(world, a, c) && is_pair(world, b, c) && is_pair(world, b, d));
    update(world, c, box_of(3, 3, nan, 4, 4, 0));
    commit(world, 2, 0, 2);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(both_axes_decide)
{
    msap_world *world = new_world(2, _i);
    msap_handle a = add(world, box_of(0, 0, 0, 1, 1, 0)), b = add(world, box_of(2, 0, 0, 3, 1, 0));
    commit(world, 0, 0, 0);
    update(world, b, box_of(0, 2, 0, 1, 3, 0));
    commit(world, 0, 0, 0);
    update(world, b, box_of(1, 1, 0, 2, 2, 0));
    commit(world, 0, 1, 1);
    update(world, a, box_of(0, 0, 0, 1, float_of(0x3F7FFFFF), 0));
    commit(world, 1, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

static uint64_t peak_of_world(uint32_t dims)
{
    msap_world *world = new_world(dims, SINGLE_SAP);
    uint64_t peak;
    int i;
    for (i = 0; i < 5000; i++)
        add(world, cube((float)(2 * i), (float)(2 * i + 1)));
    commit(world, 0, 0, 0);
    peak = stats_of(world).bytes_peak;
    ok(msap_destroy(world));
    return peak;
}

START_TEST(two_axes_take_less_memory_than_three)
{
    ck_assert_uint_lt(peak_of_world(2), peak_of_world(3));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("2D");
    tcase_add_loop_test(tests, two_numbers_are_read_and_written, 0, SETUPS);
    tcase_add_loop_test(tests, z_does_not_matter, 0, SETUPS);
    tcase_add_loop_test(tests, both_axes_decide, 0, SETUPS);
    tcase_add_test(tests, two_axes_take_less_memory_than_three);
    return run_case(tests, "2D");
}
