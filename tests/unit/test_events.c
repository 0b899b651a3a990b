/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: events are net and in order. What came and went between two commits is
 * not reported; deletes come before creates, each sorted by (lower handle, higher
 * handle); callbacks run in the order of the arrays, with the right user data.
 */
#include "checks.h"

/* The next call of the callbacks in order: 'c' or 'd', then the slots of the pair. */
static char seen[64];
static size_t seen_count;

static void note(char kind, msap_handle a, msap_handle b)
{
    ck_assert_uint_lt(seen_count, sizeof seen - 4);
    seen[seen_count++] = kind;
    seen[seen_count++] = (char)('0' + (a >> 32));
    seen[seen_count++] = (char)('0' + (b >> 32));
}

static void *on_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    (void)data_a;
    (void)data_b;
    note('c', a, b);
    return context;
}

static void on_delete(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b, void *pair_data)
{
    (void)data_a;
    (void)data_b;
    ck_assert_ptr_eq(pair_data, context); /* as on_create returned it */
    note('d', a, b);
}

/* Commits, and the callbacks must be called like this. */
static void commit_gives(msap_world *world, const char *expected)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, on_create, on_delete};
    callbacks.context = seen;
    seen_count = 0;
    ok(msap_commit(world, &callbacks, NULL));
    seen[seen_count] = 0;
    ck_assert_str_eq(seen, expected);
}

START_TEST(an_empty_commit_has_no_events)
{
    msap_world *world = new_world(3, _i);
    const msap_pair *pairs;
    size_t count = 7;
    commit_gives(world, "");
    add(world, cube(0, 1));
    add(world, cube(0, 1));
    commit_gives(world, "c01");
    commit_gives(world, "");
    ok(msap_created(world, &pairs, &count));
    ck_assert_uint_eq(count, 0);
    ok(msap_deleted(world, &pairs, &count));
    ck_assert_uint_eq(count, 0);
    ok(msap_pairs(world, &pairs, &count));
    ck_assert_uint_eq(count, 1);
    ok(msap_destroy(world));
}
END_TEST

/* Four bars meet on a heap, part, and meet in other company: all events at once. */
START_TEST(deletes_come_first_and_both_are_sorted)
{
    msap_world *world = new_world(3, _i);
    msap_handle h[6];
    int i;
    for (i = 0; i < 6; i++)
        h[i] = add(world, bar((float)(10 * i), (float)(10 * i + 1)));
    commit_gives(world, "");
    update(world, h[5], bar(0, 1));
    update(world, h[3], bar(0, 1));
    update(world, h[1], bar(0, 1));
    commit_gives(world, "c01c03c05c13c15c35");
    update(world, h[0], bar(40, 41));
    update(world, h[1], bar(20, 21));
    commit_gives(world, "d01d03d05d13d15c04c12");
    update(world, h[3], bar(20, 21)); /* leaves 5, meets 1 and 2 */
    update(world, h[5], bar(40, 41)); /* meets 0 and 4 */
    update(world, h[4], bar(20, 41)); /* keeps 0, meets 1, 2, 3, 5 */
    commit_gives(world, "d35c05c13c14c23c24c34c45");
    ok(msap_destroy(world));
}
END_TEST

/* Order is that of the handles as numbers, not of age: slot 0 returns last. */
START_TEST(a_reused_slot_is_sorted_by_its_number)
{
    msap_world *world = new_world(3, _i);
    msap_handle h[3];
    int i;
    for (i = 0; i < 3; i++)
        h[i] = add(world, cube(0, 1));
    commit_gives(world, "c01c02c12");
    ok(msap_remove(world, h[0]));
    commit_gives(world, "d01d02");
    add(world, cube(0, 1));
    commit_gives(world, "c01c02");
    ok(msap_destroy(world));
}
END_TEST

START_TEST(removal_and_addition_in_one_commit)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1));
    add(world, cube(0, 1));
    commit_gives(world, "c01");
    ok(msap_remove(world, a));
    add(world, cube(0, 1)); /* the same box, but another handle: slot 2 */
    commit_gives(world, "d01c12");
    ok(msap_destroy(world));
}
END_TEST

START_TEST(through_each_other_in_one_commit)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(0, 1)), b = add(world, bar(5, 6));
    commit_gives(world, "");
    update(world, a, bar(5, 6));
    update(world, b, bar(0, 1));
    commit_gives(world, "");
    update(world, b, bar(5.5f, 6)); /* there */
    update(world, b, bar(0, 1));    /* and back */
    commit_gives(world, "");
    update(world, b, box_of(0, 9, 9, 9, 10, 10)); /* over its head */
    commit_gives(world, "");
    ok(msap_destroy(world));
}
END_TEST

/* A diagonal motion that overlaps on each axis at some time, never on all. */
START_TEST(past_each_other_diagonally)
{
    msap_world *world = new_world(3, _i);
    msap_handle a;
    add(world, cube(0, 1));
    a = add(world, box_of(-3, 0, 0, -2, 1, 1));
    commit_gives(world, "");
    update(world, a, box_of(0, 3, 0, 1, 4, 1));
    commit_gives(world, "");
    update(world, a, box_of(3, 0, 0, 4, 1, 1));
    commit_gives(world, "");
    update(world, a, box_of(0, 0, -3, 1, 1, -2));
    commit_gives(world, "");
    ok(msap_destroy(world));
}
END_TEST

START_TEST(apart_and_together_in_one_commit)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1));
    add(world, cube(0, 1));
    commit_gives(world, "c01");
    update(world, a, cube(8, 9));
    update(world, a, cube(1, 2));
    commit_gives(world, "");
    ok(msap_remove(world, a));
    commit_gives(world, "d01");
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_box_that_no_commit_saw_has_no_events)
{
    msap_world *world = new_world(3, _i);
    msap_handle a;
    add(world, cube(0, 1));
    a = add(world, cube(0, 1));
    ok(msap_remove(world, a));
    commit_gives(world, "");
    a = add(world, cube(0, 1)); /* moved before it is seen */
    update(world, a, cube(5, 6));
    commit_gives(world, "");
    update(world, a, cube(0, 1)); /* would meet, but is removed */
    ok(msap_remove(world, a));
    commit_gives(world, "");
    ok(msap_destroy(world));
}
END_TEST

/* An update before a removal does not touch the pairs that the removal ends. */
START_TEST(update_before_removal)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(0, 1));
    add(world, bar(0, 1));
    add(world, bar(5, 6));
    commit_gives(world, "c01");
    update(world, a, bar(5, 6));
    ok(msap_remove(world, a));
    commit_gives(world, "d01");
    ok(msap_destroy(world));
}
END_TEST

START_TEST(everything_leaves)
{
    msap_world *world = new_world(3, _i);
    msap_handle h[3];
    int i;
    for (i = 0; i < 3; i++)
        h[i] = add(world, cube(0, 1));
    commit_gives(world, "c01c02c12");
    ok(msap_remove_many(world, 3, h));
    commit_gives(world, "d01d02d12");
    commit_gives(world, "");
    ok(msap_destroy(world));
}
END_TEST

/* The arrays tell the same as the callbacks, and one frame is not the next. */
START_TEST(arrays_are_those_of_the_last_commit)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1)), c;
    const msap_pair *pairs;
    size_t count;
    commit(world, 0, 1, 1);
    c = add(world, cube(0, 1));
    ok(msap_remove(world, b));
    ok(msap_created(world, &pairs, &count)); /* pending changes do not show */
    ck_assert(count == 1 && pairs[0].a == a && pairs[0].b == b);
    ok(msap_pairs(world, &pairs, &count));
    ck_assert(count == 1 && pairs[0].a == a && pairs[0].b == b);
    commit(world, 1, 1, 1);
    ok(msap_deleted(world, &pairs, &count));
    ck_assert(count == 1 && pairs[0].a == a && pairs[0].b == b);
    ok(msap_created(world, &pairs, &count));
    ck_assert(count == 1 && pairs[0].a == a && pairs[0].b == c && pairs[0].user_data == NULL);
    ok(msap_destroy(world));
}
END_TEST

/* The arrays stay where they are while changes are made, until the next commit. */
START_TEST(arrays_outlive_changes)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1));
    const msap_pair *pairs, *again;
    size_t count;
    int i;
    commit(world, 0, 1, 1);
    ok(msap_pairs(world, &pairs, &count));
    for (i = 0; i < 1000; i++)
        add(world, cube(0, 1));
    update(world, a, cube(5, 6));
    ok(msap_remove(world, b));
    ck_assert(count == 1 && pairs[0].a == a && pairs[0].b == b);
    ok(msap_pairs(world, &again, &count));
    ck_assert_ptr_eq(again, pairs);
    ok(msap_destroy(world));
}
END_TEST

/* Each callback may be missing. */
START_TEST(callbacks_may_be_null)
{
    msap_callbacks none = {sizeof none, 0, NULL, NULL, NULL}, create = none, delete = none;
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1));
    void *data = seen;
    ok(msap_commit(world, &none, NULL));
    ok(msap_get_pair_data(world, 1, &a, &b, &data));
    ck_assert_ptr_null(data);
    update(world, a, cube(5, 6));
    create.context = seen;
    create.on_create = on_create;
    ok(msap_commit(world, &create, NULL));
    update(world, a, cube(0, 1));
    ok(msap_commit(world, &create, NULL));
    ok(msap_get_pair_data(world, 1, &a, &b, &data));
    ck_assert_ptr_eq(data, seen);
    delete.context = seen;
    delete.on_delete = on_delete;
    ok(msap_remove(world, b));
    seen_count = 0;
    ok(msap_commit(world, &delete, NULL));
    ck_assert_uint_eq(seen_count, 3);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(destroy_calls_no_callback)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1));
    add(world, cube(0, 1));
    commit_gives(world, "c01");
    ok(msap_remove(world, a));
    ok(msap_destroy(world));
    ck_assert_uint_eq(seen_count, 3);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("events");
    tcase_add_loop_test(tests, an_empty_commit_has_no_events, 0, SETUPS);
    tcase_add_loop_test(tests, deletes_come_first_and_both_are_sorted, 0, SETUPS);
    tcase_add_loop_test(tests, a_reused_slot_is_sorted_by_its_number, 0, SETUPS);
    tcase_add_loop_test(tests, removal_and_addition_in_one_commit, 0, SETUPS);
    tcase_add_loop_test(tests, through_each_other_in_one_commit, 0, SETUPS);
    tcase_add_loop_test(tests, past_each_other_diagonally, 0, SETUPS);
    tcase_add_loop_test(tests, apart_and_together_in_one_commit, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_that_no_commit_saw_has_no_events, 0, SETUPS);
    tcase_add_loop_test(tests, update_before_removal, 0, SETUPS);
    tcase_add_loop_test(tests, everything_leaves, 0, SETUPS);
    tcase_add_loop_test(tests, arrays_are_those_of_the_last_commit, 0, SETUPS);
    tcase_add_loop_test(tests, arrays_outlive_changes, 0, SETUPS);
    tcase_add_loop_test(tests, callbacks_may_be_null, 0, SETUPS);
    tcase_add_loop_test(tests, destroy_calls_no_callback, 0, SETUPS);
    return run_case(tests, "events");
}
