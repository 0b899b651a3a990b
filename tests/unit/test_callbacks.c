/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: from inside a callback the world can be read but not changed: every call
 * that would change it is refused with MSAP_ERROR_BUSY and changes nothing, destroy
 * included; another world is free.
 */
#include "checks.h"

typedef struct calls {
    msap_world *world, *other;
    msap_handle box, removed;
    int count;
} calls;

static void changes_are_refused(calls *c)
{
    box unit = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&unit);
    msap_counts counts = {sizeof counts, 0, 7, 7, 7};
    msap_handle handle = 77;
    void *data = c;
    refused(msap_add(c->world, unit.min, unit.max, 0, NULL, &handle), MSAP_ERROR_BUSY);
    last_error(c->world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    refused(msap_add_many(c->world, 1, &boxes, NULL, NULL, &handle), MSAP_ERROR_BUSY);
    refused(msap_update(c->world, c->box, unit.min, unit.max), MSAP_ERROR_BUSY);
    refused(msap_update_many(c->world, 1, &c->box, &boxes), MSAP_ERROR_BUSY);
    refused(msap_remove(c->world, c->box), MSAP_ERROR_BUSY);
    refused(msap_remove_many(c->world, 1, &c->box), MSAP_ERROR_BUSY);
    refused(msap_set_user_data(c->world, 1, &c->box, &data), MSAP_ERROR_BUSY);
    refused(msap_commit(c->world, NULL, &counts), MSAP_ERROR_BUSY);
    refused(msap_trim(c->world), MSAP_ERROR_BUSY);
    refused(msap_destroy(c->world), MSAP_ERROR_BUSY);
    last_error(c->world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    ck_assert_uint_eq(handle, 77);
    ck_assert(counts.created == 7 && counts.deleted == 7 && counts.active == 7);
}

static void pair_changes_are_refused(calls *c, msap_handle a, msap_handle b)
{
    void *data = c;
    refused(msap_set_pair_data(c->world, 1, &a, &b, &data), MSAP_ERROR_BUSY);
}

static void reads_are_allowed(calls *c, msap_handle a, void *data_a)
{
    const msap_pair *pairs;
    const char *what = NULL;
    size_t count;
    float min[3], max[3];
    void *data;
    ok(msap_get_bounds(c->world, c->box, min, max));
    ok(msap_get_user_data(c->world, 1, &a, &data));
    ck_assert_ptr_eq(data, data_a);
    ok(msap_created(c->world, &pairs, &count));
    ok(msap_deleted(c->world, &pairs, &count));
    ok(msap_pairs(c->world, &pairs, &count));
    stats_of(c->world);
    ck_assert_msg(msap_validate(c->world, &what) == MSAP_OK, "%s", what ? what : "no reason given");
}

/* Adds to the other world, and commits it. */
static void another_world_is_free(calls *c)
{
    add(c->other, cube(0, 1));
    ok(msap_commit(c->other, NULL, NULL));
}

static void look_around(calls *c, msap_handle a, msap_handle b, void *data_a)
{
    changes_are_refused(c);
    pair_changes_are_refused(c, a, b);
    reads_are_allowed(c, a, data_a);
    another_world_is_free(c);
    c->count++;
}

static void *on_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    (void)data_b;
    look_around(context, a, b, data_a);
    return context;
}

static void on_delete(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b, void *pair_data)
{
    (void)data_b;
    ck_assert_ptr_eq(pair_data, context);
    look_around(context, a, b, data_a);
}

START_TEST(the_world_can_be_read_but_not_changed)
{
    calls c = {NULL, NULL, 0, 0, 0};
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, on_create, on_delete};
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    box unit = cube(0, 1);
    msap_handle a, b;
    callbacks.context = &c;
    c.world = new_world(3, _i);
    c.other = new_world(3, _i);
    c.box = add(c.world, cube(5, 6));
    ok(msap_add(c.world, unit.min, unit.max, 0, &c.box, &a));
    ok(msap_add(c.world, unit.min, unit.max, 0, &c.count, &b));
    ok(msap_commit(c.world, &callbacks, &counts));
    ck_assert(counts.created == 1 && counts.deleted == 0 && counts.active == 1);
    ok(msap_remove(c.world, a));
    update(c.world, b, cube(5, 6));
    ok(msap_commit(c.world, &callbacks, &counts));
    ck_assert(counts.created == 1 && counts.deleted == 1 && counts.active == 1);
    ck_assert_int_eq(c.count, 3);
    ck_assert_uint_eq(stats_of(c.world).pending, 0);
    ck_assert_uint_eq(stats_of(c.world).boxes, 2);
    ck_assert_uint_eq(stats_of(c.other).boxes, 3);
    commit(c.world, 0, 0, 1);
    ok(msap_remove(c.world, c.box)); /* and now the world can be changed again */
    commit(c.world, 1, 0, 0);
    ok(msap_destroy(c.world));
    ok(msap_destroy(c.other));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("callbacks");
    tcase_add_loop_test(tests, the_world_can_be_read_but_not_changed, 0, SETUPS);
    return run_case(tests, "callbacks");
}
