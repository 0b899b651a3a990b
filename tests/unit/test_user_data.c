/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: the user's pointers of boxes and pairs come back unchanged, in callbacks,
 * by the getters, after the setters, and for removed boxes until the commit that
 * reports them has returned; the getters and setters do all or nothing.
 */
#include "checks.h"

static int marks[8];

typedef struct calls {
    msap_world *world;
    int created, deleted;
    void *data_a, *data_b, *pair_data;
} calls;

static void *on_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    calls *c = context;
    (void)a;
    (void)b;
    c->created++;
    c->data_a = data_a;
    c->data_b = data_b;
    return &marks[7];
}

static void on_delete(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b, void *pair_data)
{
    calls *c = context;
    void *data = NULL;
    c->deleted++;
    c->data_a = data_a;
    c->data_b = data_b;
    c->pair_data = pair_data;
    ok(msap_get_user_data(c->world, 1, &a, &data)); /* though the box is removed */
    ck_assert_ptr_eq(data, data_a);
    ok(msap_get_user_data(c->world, 1, &b, &data));
    ck_assert_ptr_eq(data, data_b);
}

/* Two boxes that overlap, with marks 0 and 1. */
static calls two_boxes(int row, msap_handle *a, msap_handle *b)
{
    calls c = {NULL, 0, 0, NULL, NULL, NULL};
    box unit = cube(0, 1);
    c.world = new_world(3, row);
    ok(msap_add(c.world, unit.min, unit.max, 0, &marks[0], a));
    ok(msap_add(c.world, unit.min, unit.max, 0, &marks[1], b));
    return c;
}

static void call_commit(calls *c)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, on_create, on_delete};
    callbacks.context = c;
    ok(msap_commit(c->world, &callbacks, NULL));
}

START_TEST(callbacks_get_what_was_given)
{
    msap_handle a, b;
    calls c = two_boxes(_i, &a, &b);
    call_commit(&c);
    ck_assert_int_eq(c.created, 1);
    ck_assert(c.data_a == &marks[0] && c.data_b == &marks[1]);
    ok(msap_remove(c.world, a));
    ok(msap_remove(c.world, b));
    call_commit(&c);
    ck_assert_int_eq(c.deleted, 1);
    ck_assert(c.data_a == &marks[0] && c.data_b == &marks[1] && c.pair_data == &marks[7]);
    ok(msap_destroy(c.world));
}
END_TEST

/* What is set before the commit is what the commit hands out. */
START_TEST(set_before_the_commit)
{
    msap_handle handles[2];
    void *in[2] = {&marks[2], NULL}, *out[2];
    calls c = two_boxes(_i, &handles[0], &handles[1]);
    ok(msap_set_user_data(c.world, 2, handles, in));
    ok(msap_get_user_data(c.world, 2, handles, out));
    ck_assert(out[0] == &marks[2] && out[1] == NULL);
    call_commit(&c);
    ck_assert(c.data_a == &marks[2] && c.data_b == NULL);
    ok(msap_set_pair_data(c.world, 1, &handles[1], &handles[0], &in[0])); /* in any order */
    ok(msap_remove(c.world, handles[0]));
    in[0] = &marks[3];
    ok(msap_set_user_data(c.world, 1, &handles[1], in));
    call_commit(&c);
    ck_assert(c.data_a == &marks[2] && c.data_b == &marks[3] && c.pair_data == &marks[2]);
    ok(msap_destroy(c.world));
}
END_TEST

START_TEST(pair_data_in_any_order)
{
    msap_handle a, b, first[2], second[2];
    void *in[2] = {&marks[4], &marks[5]}, *out[2] = {NULL, NULL};
    const msap_pair *pairs;
    size_t count;
    calls c = two_boxes(_i, &a, &b);
    call_commit(&c);
    first[0] = second[1] = a;
    first[1] = second[0] = b;
    ok(msap_get_pair_data(c.world, 2, first, second, out));
    ck_assert(out[0] == &marks[7] && out[1] == &marks[7]);
    ok(msap_set_pair_data(c.world, 2, first, second, in)); /* the same pair twice: the last counts */
    ok(msap_get_pair_data(c.world, 1, &b, &a, out));
    ck_assert_ptr_eq(out[0], &marks[5]);
    ok(msap_pairs(c.world, &pairs, &count));
    ck_assert(count == 1 && pairs[0].user_data == &marks[5]);
    ok(msap_remove(c.world, a)); /* still a pair of the last commit */
    ok(msap_set_pair_data(c.world, 1, &a, &b, in));
    call_commit(&c);
    ck_assert_ptr_eq(c.pair_data, &marks[4]);
    ok(msap_deleted(c.world, &pairs, &count));
    ck_assert(count == 1 && pairs[0].user_data == &marks[4]);
    ok(msap_destroy(c.world));
}
END_TEST

START_TEST(pair_data_outlives_motion)
{
    msap_handle a, b;
    void *out = NULL;
    calls c = two_boxes(_i, &a, &b);
    call_commit(&c);
    update(c.world, a, cube(8, 9));
    update(c.world, a, cube(1, 2));
    call_commit(&c);
    ok(msap_get_pair_data(c.world, 1, &a, &b, &out));
    ck_assert_ptr_eq(out, &marks[7]);
    update(c.world, a, cube(8, 9));
    ok(msap_commit(c.world, NULL, NULL));
    update(c.world, a, cube(1, 2));
    ok(msap_commit(c.world, NULL, NULL)); /* a new pair, made without a callback */
    ok(msap_get_pair_data(c.world, 1, &a, &b, &out));
    ck_assert_ptr_null(out);
    ok(msap_destroy(c.world));
}
END_TEST

START_TEST(not_a_pair)
{
    msap_handle a, b, far, first[3], second[3];
    void *in[3] = {&marks[4], &marks[4], &marks[4]}, *out[3] = {NULL, NULL, NULL};
    calls c = two_boxes(_i, &a, &b);
    far = add(c.world, cube(5, 6));
    refused(msap_get_pair_data(c.world, 1, &a, &b, out), MSAP_ERROR_NOT_A_PAIR); /* not before the commit */
    call_commit(&c);
    first[0] = first[1] = first[2] = a;
    second[0] = second[1] = second[2] = b;
    second[1] = far;
    refused(msap_get_pair_data(c.world, 3, first, second, out), MSAP_ERROR_NOT_A_PAIR);
    refused(msap_set_pair_data(c.world, 3, first, second, in), MSAP_ERROR_NOT_A_PAIR);
    last_error(c.world, MSAP_ERROR_NOT_A_PAIR, 1, MSAP_NO_BOUND);
    second[1] = a; /* with itself */
    refused(msap_get_pair_data(c.world, 3, first, second, out), MSAP_ERROR_NOT_A_PAIR);
    refused(msap_set_pair_data(c.world, 3, first, second, in), MSAP_ERROR_NOT_A_PAIR);
    ck_assert(out[0] == NULL && out[1] == NULL && out[2] == NULL);
    ok(msap_get_pair_data(c.world, 1, &a, &b, out));
    ck_assert_ptr_eq(out[0], &marks[7]); /* nothing was set */
    ok(msap_destroy(c.world));
}
END_TEST

/* The same handle twice in one call: the last counts. */
/* The slots are those of a pair, the boxes are others. */
START_TEST(not_a_pair_any_more)
{
    msap_handle a, b, stale, h[2];
    calls c = two_boxes(_i, &a, &b);
    void *data = &marks[6];
    call_commit(&c);
    for (int i = 0; i < 2; i++) {
        h[0] = a;
        h[1] = b;
        stale = h[i];
        ok(msap_remove(c.world, stale));
        call_commit(&c);
        (void)add(c.world, cube(0, 1));
        call_commit(&c);
        refused(msap_get_pair_data(c.world, 1, &h[0], &h[1], &data), MSAP_ERROR_NOT_A_PAIR);
        refused(msap_get_pair_data(c.world, 1, &h[1], &h[0], &data), MSAP_ERROR_NOT_A_PAIR);
        h[i]++; /* the next generation */
        ok(msap_get_pair_data(c.world, 1, &h[0], &h[1], &data));
        ck_assert_ptr_eq(data, &marks[7]);
        a = h[0];
        b = h[1];
    }
    ok(msap_destroy(c.world));
}
END_TEST

START_TEST(a_handle_twice)
{
    msap_handle a, b, twice[2];
    void *in[2] = {&marks[5], &marks[6]}, *out[2];
    calls c = two_boxes(_i, &a, &b);
    twice[0] = twice[1] = a;
    ok(msap_set_user_data(c.world, 2, twice, in));
    ok(msap_get_user_data(c.world, 2, twice, out));
    ck_assert(out[0] == &marks[6] && out[1] == &marks[6]);
    ok(msap_destroy(c.world));
}
END_TEST

static void *data_of(const msap_world *world, msap_handle handle)
{
    void *data = &marks[5];
    ok(msap_get_user_data(world, 1, &handle, &data));
    return data;
}

/* Room is taken with the first pointer that is not NULL: those of other boxes are NULL before and after,
 * also when there is no memory for it. */
START_TEST(data_that_comes_late)
{
    enum { BOXES = 40 };
    tracker memory = {0};
    msap_config config = config_of(3, _i);
    msap_world *world;
    msap_handle h[BOXES];
    box unit = cube(0, 1);
    void *data = &marks[2];
    int i;
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &memory;
    ok(msap_create(&config, &world));
    for (i = 0; i < BOXES / 2; i++)
        h[i] = add(world, unit);
    ck_assert_ptr_null(data_of(world, h[1]));
    memory.fail_all = 1;
    refused(msap_set_user_data(world, 1, &h[1], &data), MSAP_ERROR_MEMORY);
    last_error(world, MSAP_ERROR_MEMORY, 0, MSAP_NO_BOUND);
    ck_assert_ptr_null(data_of(world, h[1]));
    memory.fail_all = 0;
    if (_i % 2)
        ok(msap_set_user_data(world, 1, &h[1], &data));
    else
        ok(msap_add(world, unit.min, unit.max, 0, data, &h[1]));
    for (i = BOXES / 2; i < BOXES; i++)
        h[i] = add(world, unit);
    for (i = 0; i < BOXES; i++)
        ck_assert_ptr_eq(data_of(world, h[i]), i == 1 ? data : NULL);
    ok(msap_commit(world, NULL, NULL));
    ok(msap_trim(world));
    ck_assert_ptr_eq(data_of(world, h[1]), data);
    ok(msap_destroy(world));
    ck_assert(memory.blocks == 0 && memory.wrong == 0);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("user data");
    tcase_add_loop_test(tests, data_that_comes_late, 0, SETUPS);
    tcase_add_loop_test(tests, callbacks_get_what_was_given, 0, SETUPS);
    tcase_add_loop_test(tests, set_before_the_commit, 0, SETUPS);
    tcase_add_loop_test(tests, pair_data_in_any_order, 0, SETUPS);
    tcase_add_loop_test(tests, pair_data_outlives_motion, 0, SETUPS);
    tcase_add_loop_test(tests, not_a_pair, 0, SETUPS);
    tcase_add_loop_test(tests, not_a_pair_any_more, 0, SETUPS);
    tcase_add_loop_test(tests, a_handle_twice, 0, SETUPS);
    return run_case(tests, "user data");
}
