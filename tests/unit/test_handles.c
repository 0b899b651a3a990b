/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a handle names one box for as long as it lives. High half: the slot, from
 * 0; low half: its generation, from 1. Slots return after the commit that reports
 * their removal, in the order of freeing, before new ones are taken; those that are
 * forgotten return with a generation that none of them had. Stale, null and garbage
 * handles are refused everywhere.
 */
#include <string.h>

#include "checks.h"

static msap_handle handle_of(uint32_t slot, uint32_t generation)
{
    return (msap_handle)slot << 32 | generation;
}

START_TEST(slots_and_generations)
{
    msap_world *world = new_world(3, _i);
    uint32_t i;
    for (i = 0; i < 5; i++)
        ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(i, 1));
    commit(world, 0, 10, 10);
    ok(msap_remove(world, handle_of(3, 1)));
    ok(msap_remove(world, handle_of(1, 1)));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(5, 1)); /* 3 and 1 are not reported yet */
    commit(world, 7, 3, 6);                                    /* of 10 pairs the 3 of {0, 2, 4} stay */
    ok(msap_remove(world, handle_of(0, 1)));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(3, 2)); /* in the order of freeing */
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(1, 2));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(6, 1)); /* 0 is not reported yet */
    commit(world, 3, 12, 15);                                  /* 0 leaves 3; {1, 2, 3, 4, 5, 6}: 15, 3 of them old */
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(0, 2));
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_box_that_no_commit_saw)
{
    msap_world *world = new_world(3, _i);
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(0, 1));
    ok(msap_remove(world, handle_of(0, 1)));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(1, 1));
    ok(msap_remove(world, handle_of(1, 1)));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(0, 2));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(1, 2));
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(batches_give_the_handles_of_single_calls)
{
    static const uint32_t removed[] = {4, 0, 6, 2};
    msap_world *worlds[2];
    msap_handle handles[2][12];
    box bounds[12];
    msap_boxes boxes;
    int w, i;
    for (i = 0; i < 12; i++)
        bounds[i] = cube((float)i, (float)(i + 1));
    boxes = boxes_in_row(bounds);
    for (w = 0; w < 2; w++) {
        worlds[w] = new_world(3, _i);
        for (i = 0; i < 8; i++)
            add(worlds[w], cube(0, 1));
        for (i = 0; i < 4 && w == 0; i++)
            ok(msap_remove(worlds[w], handle_of(removed[i], 1)));
        if (w == 1) {
            msap_handle batch[4];
            for (i = 0; i < 4; i++)
                batch[i] = handle_of(removed[i], 1);
            ok(msap_remove_many(worlds[w], 4, batch));
        }
        commit(worlds[w], 0, 6, 6);
        ok(msap_remove(worlds[w], handle_of(7, 1)));
    }
    for (i = 0; i < 12; i++)
        handles[0][i] = add(worlds[0], bounds[i]);
    ok(msap_add_many(worlds[1], 12, &boxes, NULL, NULL, handles[1]));
    for (i = 0; i < 4; i++)
        ck_assert_uint_eq(handles[1][i], handle_of(removed[i], 2));
    for (; i < 12; i++)
        ck_assert_uint_eq(handles[1][i], handle_of((uint32_t)i + 4, 1));
    ck_assert_int_eq(memcmp(handles[0], handles[1], sizeof handles[0]), 0);
    ok(msap_destroy(worlds[0]));
    ok(msap_destroy(worlds[1]));
}
END_TEST

/* The same slot, 1000 times. */
START_TEST(generations_count_up)
{
    msap_world *world = new_world(3, _i);
    uint32_t i;
    for (i = 1; i <= 1000; i++) {
        ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(0, i));
        commit(world, 0, 0, 0);
        ok(msap_remove(world, handle_of(0, i)));
        commit(world, 0, 0, 0);
    }
    ok(msap_destroy(world));
}
END_TEST

/* ---------------------------------------------------------- forgotten slots */

START_TEST(trim_forgets_free_slots_at_the_end)
{
    msap_world *world = new_world(3, _i);
    float min[3], max[3];
    uint32_t i;
    for (i = 0; i < 5; i++)
        add(world, cube(0, 1));
    commit(world, 0, 10, 10);
    ok(msap_remove(world, handle_of(3, 1)));
    ok(msap_trim(world)); /* slot 3 is not free before the commit */
    ok(msap_remove(world, handle_of(1, 1)));
    ok(msap_remove(world, handle_of(4, 1)));
    commit(world, 9, 0, 1);
    ok(msap_trim(world));
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(1, 2)); /* in the middle: kept */
    ck_assert_uint_eq(add(world, cube(0, 1)), handle_of(3, 2)); /* at the end: forgotten, but not its generation */
    refused(msap_get_bounds(world, handle_of(3, 1), min, max), MSAP_ERROR_HANDLE);
    refused(msap_remove(world, handle_of(4, 1)), MSAP_ERROR_HANDLE);
    refused(msap_remove(world, handle_of(4, 2)), MSAP_ERROR_HANDLE);
    commit(world, 0, 5, 6);
    ok(msap_destroy(world));
}
END_TEST

/* Above the generations of all slots that were forgotten, not only its own. */
START_TEST(a_slot_after_forgotten_ones_has_a_new_generation)
{
    msap_world *world = new_world(3, _i);
    uint32_t i;
    add(world, cube(0, 1));
    for (i = 1; i <= 3; i++) {
        ck_assert_uint_eq(add(world, cube(5, 6)), handle_of(1, i));
        ok(msap_remove(world, handle_of(1, i)));
        commit(world, 0, 0, 0);
    }
    ok(msap_trim(world));
    ck_assert_uint_eq(add(world, cube(5, 6)), handle_of(1, 4));
    ck_assert_uint_eq(add(world, cube(7, 8)), handle_of(2, 4)); /* though it is there for the first time */
    ok(msap_remove(world, handle_of(2, 4)));
    commit(world, 0, 0, 0);
    ok(msap_trim(world));
    ok(msap_trim(world));
    ck_assert_uint_eq(add(world, cube(7, 8)), handle_of(2, 5));
    ck_assert_uint_eq(add(world, cube(7, 8)), handle_of(3, 5));
    ok(msap_destroy(world));
}
END_TEST

/* Of 2000 boxes 10 stay; the slots return in the order in which they were freed. */
static msap_world *deserted_world(int row, msap_handle *handles)
{
    msap_world *world = new_world(3, row);
    int i;
    for (i = 0; i < 2000; i++)
        handles[i] = add(world, bar((float)(2 * i), (float)(2 * i + 1)));
    ok(msap_commit(world, NULL, NULL));
    for (i = 1999; i >= 10; i--)
        ok(msap_remove(world, handles[i]));
    ok(msap_commit(world, NULL, NULL));
    return world;
}

/* Slots are forgotten by itself after 256 commits in a row with little left. */
START_TEST(slots_are_forgotten_after_a_long_time)
{
    static msap_handle handles[2000];
    msap_world *world = deserted_world(_i, handles);
    int i;
    for (i = 0; i < 254; i++) /* after the one that removed them */
        commit(world, 0, 0, 0);
    ck_assert_uint_eq(add(world, cube(5, 6)), handle_of(1999, 2));
    ck_assert_uint_eq(add(world, cube(5, 6)), handle_of(1998, 2));
    ok(msap_remove(world, handle_of(1999, 2)));
    ok(msap_remove(world, handle_of(1998, 2)));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(add(world, cube(5, 6)), handle_of(10, 3));
    refused(msap_remove(world, handle_of(1999, 2)), MSAP_ERROR_HANDLE);
    ok(msap_destroy(world));
}
END_TEST

/* Batches give the handles of single calls, also when slots have been forgotten. */
START_TEST(forgetting_does_not_depend_on_batches)
{
    static msap_handle handles[2][800];
    static box bounds[800];
    msap_boxes boxes = boxes_in_row(bounds);
    msap_world *worlds[2];
    int w, i;
    for (i = 0; i < 800; i++)
        bounds[i] = bar((float)(2 * i), (float)(2 * i + 1));
    for (w = 0; w < 2; w++) {
        worlds[w] = new_world(3, _i);
        for (i = 0; i < 800 && w == 0; i++)
            handles[w][i] = add(worlds[w], bounds[i]);
        if (w == 1)
            ok(msap_add_many(worlds[w], 800, &boxes, NULL, NULL, handles[w]));
        ok(msap_commit(worlds[w], NULL, NULL));
        for (i = 799; i >= 10; i--)
            ok(msap_remove(worlds[w], handles[w][i]));
        for (i = 0; i < 300; i++)
            ok(msap_commit(worlds[w], NULL, NULL));
        handles[w][0] = add(worlds[w], bounds[0]);
        ok(msap_destroy(worlds[w]));
    }
    ck_assert_uint_eq(handles[0][0], handles[1][0]);
}
END_TEST

/* ------------------------------------------------------------- bad handles */

/* Every call that takes a handle, refusing this one among good ones. */
static void all_refuse(msap_world *world, msap_handle good, msap_handle bad)
{
    box bounds[3] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    msap_boxes boxes = boxes_in_row(bounds);
    msap_handle handles[3];
    int marks[3];
    void *in[3], *out[3];
    float min[3] = {7, 7, 7}, max[3] = {7, 7, 7};
    size_t i;
    for (i = 0; i < 3; i++) {
        handles[i] = good;
        in[i] = out[i] = &marks[i];
    }
    handles[2] = bad;
    refused(msap_update(world, bad, bounds[0].min, bounds[0].max), MSAP_ERROR_HANDLE);
    last_error(world, MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    refused(msap_update_many(world, 3, handles, &boxes), MSAP_ERROR_HANDLE);
    last_error(world, MSAP_ERROR_HANDLE, 2, MSAP_NO_BOUND);
    refused(msap_remove(world, bad), MSAP_ERROR_HANDLE);
    last_error(world, MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    handles[0] = bad;
    refused(msap_remove_many(world, 3, handles), MSAP_ERROR_HANDLE);
    last_error(world, MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    handles[0] = good;
    refused(msap_set_user_data(world, 3, handles, in), MSAP_ERROR_HANDLE);
    last_error(world, MSAP_ERROR_HANDLE, 2, MSAP_NO_BOUND);
    refused(msap_get_user_data(world, 3, handles, out), MSAP_ERROR_HANDLE);
    refused(msap_get_bounds(world, bad, min, max), MSAP_ERROR_HANDLE);
    refused(msap_get_pair_data(world, 1, &good, &bad, out), MSAP_ERROR_NOT_A_PAIR);
    refused(msap_set_pair_data(world, 1, &bad, &good, in), MSAP_ERROR_NOT_A_PAIR);
    last_error(world, MSAP_ERROR_NOT_A_PAIR, 0, MSAP_NO_BOUND);
    ck_assert_int_eq(memcmp(in, out, sizeof in), 0);
    ck_assert(min[0] == 7 && max[2] == 7);
}

START_TEST(bad_handles_are_refused)
{
    msap_config config = config_of(3, _i);
    session s;
    msap_handle good, stale, reused, bad[12];
    box unit = cube(0, 1);
    size_t i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    right(session_add(&s, &unit, 0, &good));
    right(session_add(&s, &unit, 0, &stale));
    right(session_commit(&s));
    right(session_remove(&s, stale));
    right(session_commit(&s));
    right(session_add(&s, &unit, 0, &reused));
    right(session_commit(&s));
    ck_assert_uint_eq(reused, stale + 1);
    bad[0] = MSAP_NULL_HANDLE;
    bad[1] = stale;
    bad[2] = reused + 1;            /* a generation to come */
    bad[3] = handle_of(0, 0);       /* no generation */
    bad[4] = handle_of(1, 0);       /* no generation */
    bad[5] = handle_of(2, 1);       /* a slot to come */
    bad[6] = handle_of(3, 1);       /* two slots to come */
    bad[7] = handle_of(1000000, 1); /* a slot far away */
    bad[8] = UINT64_MAX;
    bad[9] = handle_of(UINT32_MAX, 1);
    bad[10] = handle_of(0x80000000, 1); /* the slot with a bit too much */
    bad[11] = handle_of(0, UINT32_MAX);
    for (i = 0; i < COUNT(bad); i++)
        all_refuse(s.world, good, bad[i]);
    right(session_compare(&s));
    right(session_commit(&s));
    right(session_close(&s));
}
END_TEST

START_TEST(an_empty_world_knows_no_handle)
{
    msap_world *world = new_world(2, _i);
    float bound[2] = {0, 0};
    refused(msap_remove(world, handle_of(0, 1)), MSAP_ERROR_HANDLE);
    refused(msap_update(world, handle_of(0, 1), bound, bound), MSAP_ERROR_HANDLE);
    refused(msap_remove(world, MSAP_NULL_HANDLE), MSAP_ERROR_HANDLE);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_removed_handle_is_stale_at_once)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1));
    float bounds[3] = {0, 0, 0};
    int mark = 0;
    void *data = &mark;
    commit(world, 0, 1, 1);
    ok(msap_remove(world, a));
    refused(msap_remove(world, a), MSAP_ERROR_HANDLE);
    refused(msap_update(world, a, bounds, bounds), MSAP_ERROR_HANDLE);
    refused(msap_get_bounds(world, a, bounds, bounds), MSAP_ERROR_HANDLE);
    refused(msap_set_user_data(world, 1, &a, &data), MSAP_ERROR_HANDLE);
    ok(msap_get_user_data(world, 1, &a, &data)); /* to be read until the commit */
    ck_assert_ptr_null(data);
    ck_assert(is_pair(world, a, b)); /* as of the last commit */
    commit(world, 1, 0, 0);
    refused(msap_get_user_data(world, 1, &a, &data), MSAP_ERROR_HANDLE);
    ck_assert(!is_pair(world, a, b));
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("handles");
    tcase_add_loop_test(tests, slots_and_generations, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_that_no_commit_saw, 0, SETUPS);
    tcase_add_loop_test(tests, batches_give_the_handles_of_single_calls, 0, SETUPS);
    tcase_add_loop_test(tests, generations_count_up, 0, SETUPS);
    tcase_add_loop_test(tests, trim_forgets_free_slots_at_the_end, 0, SETUPS);
    tcase_add_loop_test(tests, a_slot_after_forgotten_ones_has_a_new_generation, 0, SETUPS);
    tcase_add_loop_test(tests, slots_are_forgotten_after_a_long_time, 0, SETUPS);
    tcase_add_loop_test(tests, forgetting_does_not_depend_on_batches, 0, SETUPS);
    tcase_add_loop_test(tests, bad_handles_are_refused, 0, SETUPS);
    tcase_add_loop_test(tests, an_empty_world_knows_no_handle, 0, SETUPS);
    tcase_add_loop_test(tests, a_removed_handle_is_stale_at_once, 0, SETUPS);
    return run_case(tests, "handles");
}
