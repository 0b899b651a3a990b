/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: what was once wrong stays right. Each test says what it was; where a test
 * elsewhere fails without the repair too, there is none here.
 */
#include "checks.h"

/* ------------------------------------------------- calls from the allocator */

/* An allocator that calls the library on the world whose call it serves. */
typedef struct caller {
    msap_world *world;
    int armed, served;
} caller;

static void call(caller *c)
{
    box unit = cube(0, 1);
    msap_handle handle = 77;
    if (!c->armed)
        return;
    c->armed = 0;
    c->served++;
    refused(msap_add(c->world, unit.min, unit.max, 0, NULL, &handle), MSAP_ERROR_BUSY);
    refused(msap_commit(c->world, NULL, NULL), MSAP_ERROR_BUSY);
    refused(msap_trim(c->world), MSAP_ERROR_BUSY);
    refused(msap_destroy(c->world), MSAP_ERROR_BUSY);
    ck_assert_uint_eq(handle, 77);
}

static void *calling_alloc(void *user, size_t size)
{
    call(user);
    return malloc(size);
}

static void calling_free(void *user, void *pointer, size_t size)
{
    (void)size;
    call(user);
    free(pointer);
}

/* Trim and destroy did not count as calls that run. */
START_TEST(trim_and_destroy_are_calls_that_run)
{
    msap_config config = config_of(3, _i);
    caller c = {NULL, 0, 0};
    int i;
    config.alloc = calling_alloc;
    config.free = calling_free;
    config.allocator_user = &c;
    ok(msap_create(&config, &c.world));
    for (i = 0; i < 200; i++)
        add(c.world, cube((float)(3 * i), (float)(3 * i + 1)));
    commit(c.world, 0, 0, 0);
    c.armed = 1;
    ok(msap_trim(c.world));
    ck_assert_int_eq(c.served, 1);
    c.armed = 1;
    ok(msap_destroy(c.world));
    ck_assert_int_eq(c.served, 2);
}
END_TEST

/* ------------------------------------------------------ after a failed commit */

/* A commit for which there was no memory kept all that it had taken, so that there was
 * none for a smaller one either; and it had asked again for each pair that it found. */
START_TEST(a_failed_commit_asks_seldom_and_keeps_nothing)
{
    enum { MANY = 1500, FEW = 200 };
    static msap_handle handles[MANY];
    msap_config config = config_of(3, _i);
    box unit = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&unit);
    tracker memory = {0};
    msap_world *world;
    size_t before;
    boxes.min_row = boxes.max_row = 0;
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &memory;
    ok(msap_create(&config, &world));
    ok(msap_add_many(world, MANY, &boxes, NULL, NULL, handles));
    before = memory.bytes;
    memory.limit = before + (4u << 20);
    refused(msap_commit(world, NULL, NULL), MSAP_ERROR_MEMORY);
    ck_assert_uint_le(memory.bytes, before + (1u << 20));
    ck_assert_uint_le(memory.failures, 100);
    ok(msap_remove_many(world, MANY - FEW, handles));
    commit(world, 0, FEW * (FEW - 1) / 2, FEW * (FEW - 1) / 2);
    ok(msap_destroy(world));
    ck_assert(memory.blocks == 0 && memory.wrong == 0);
}
END_TEST

/* ------------------------------------------------------ memory that is new */

/* The skin of a slot without a box was read, and what was read dropped, before anything had been written there. Only
 * a sanitizer for uninitialized memory sees it, and only with an allocator that leaves it so. */
START_TEST(a_box_goes_before_it_was_ever_there)
{
    enum { MANY = 400, SIDE = 20 };
    msap_handle handles[MANY];
    msap_world *world = new_world(3, _i);
    int i;
    for (i = 0; i < MANY; i++) {
        float x = (float)(2 * (i % SIDE)), y = (float)(2 * (i / SIDE));
        handles[i] = add(world, box_of(x, y, 0, x + 1, y + 1, 1));
    }
    ok(msap_remove(world, handles[100]));
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("regressions");
    tcase_add_loop_test(tests, trim_and_destroy_are_calls_that_run, 0, SETUPS);
    tcase_add_loop_test(tests, a_failed_commit_asks_seldom_and_keeps_nothing, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_goes_before_it_was_ever_there, 0, SETUPS);
    return run_case(tests, "regressions");
}
