/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a full world says so, names the first box that has no place, and changes
 * nothing; absurd sizes are refused at once.
 */
#include "checks.h"

static msap_config limited(int row, uint32_t max_boxes)
{
    msap_config config = config_of(3, row);
    config.max_boxes = max_boxes;
    return config;
}

START_TEST(a_full_world_refuses_boxes)
{
    msap_config config = limited(_i, 4);
    box bounds[5] = {{{0, 0, 0}, {1, 1, 1}}};
    msap_handle handle, handles[5] = {1, 2, 3, 4, 5};
    msap_boxes boxes = boxes_in_row(bounds);
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 2; i++)
        right(session_add(&s, &bounds[0], 0, &handle));
    refused(msap_add_many(s.world, 5, &boxes, NULL, NULL, handles), MSAP_ERROR_FULL);
    last_error(s.world, MSAP_ERROR_FULL, 2, MSAP_NO_BOUND);
    for (i = 0; i < 5; i++)
        ck_assert_uint_eq(handles[i], (msap_handle)i + 1);
    right(session_compare(&s));
    for (i = 0; i < 2; i++)
        right(session_add(&s, &bounds[0], 0, &handle));
    handle = 77;
    refused(msap_add(s.world, bounds[0].min, bounds[0].max, 0, NULL, &handle), MSAP_ERROR_FULL);
    last_error(s.world, MSAP_ERROR_FULL, 0, MSAP_NO_BOUND);
    ck_assert_uint_eq(handle, 77);
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 6);
    right(session_close(&s));
}
END_TEST

/* After the commit that reports a removal there is room again, any number of times. */
START_TEST(removal_makes_room)
{
    msap_config config = limited(_i, 2);
    box unit = cube(0, 1);
    msap_handle a, b;
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    right(session_add(&s, &unit, 0, &a));
    for (i = 0; i < 20; i++) {
        right(session_add(&s, &unit, 0, &b));
        right(session_commit(&s));
        refused(msap_add(s.world, unit.min, unit.max, 0, NULL, &a), MSAP_ERROR_FULL);
        right(session_remove(&s, b));
        right(session_commit(&s));
    }
    right(session_close(&s));
}
END_TEST

/* More boxes than there can be, given by zero strides: refused before they are read. */
START_TEST(absurd_sizes)
{
    msap_config config = config_of(3, _i);
    box unit = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&unit);
    msap_index_pair *pairs = NULL;
    size_t count = 77;
    msap_handle handle = 77;
    session s;
    boxes.min_row = boxes.max_row = 0;
    right(session_open(&s, &config, 1, SCENE_GRID));
    refused(msap_add_many(s.world, SIZE_MAX, &boxes, NULL, NULL, &handle), MSAP_ERROR_FULL);
    refused(msap_prune(NULL, SIZE_MAX, &boxes, &pairs, &count, NULL), MSAP_ERROR_FULL);
    refused(msap_prune_bipartite(NULL, SIZE_MAX, &boxes, SIZE_MAX, &boxes, &pairs, &count, NULL), MSAP_ERROR_FULL);
    ck_assert(handle == 77 && count == 77 && pairs == NULL);
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("limits");
    tcase_add_loop_test(tests, a_full_world_refuses_boxes, 0, SETUPS);
    tcase_add_loop_test(tests, removal_makes_room, 0, SETUPS);
    tcase_add_loop_test(tests, absurd_sizes, 0, SETUPS);
    return run_case(tests, "limits");
}
