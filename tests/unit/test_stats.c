/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: msap_stats counts what the header says it counts.
 */
#include "checks.h"

START_TEST(a_new_world)
{
    msap_world *world = new_world(3, DEFAULT);
    msap_world_stats s = stats_of(world);
    ck_assert_uint_eq(s.struct_size, sizeof s);
    ck_assert(s.boxes == 0 && s.pairs == 0 && s.pending == 0 && s.commits == 0);
    ck_assert(s.crossings == 0 && s.touched == 0 && s.slides == 0 && s.merges == 0 && s.sweeps == 0);
    ck_assert(s.bytes > 0 && s.bytes_peak >= s.bytes && s.allocations > 0);
    ok(msap_destroy(world));
}
END_TEST

/* A box is pending once, whatever happens to it. */
START_TEST(pending)
{
    msap_world *world = new_world(3, DEFAULT);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1));
    ck_assert(stats_of(world).pending == 2 && stats_of(world).boxes == 2 && stats_of(world).pairs == 0);
    update(world, a, cube(0, 2));
    ck_assert_uint_eq(stats_of(world).pending, 2);
    commit(world, 0, 1, 1);
    ck_assert(stats_of(world).pending == 0 && stats_of(world).pairs == 1 && stats_of(world).commits == 1);
    update(world, a, cube(0, 3));
    update(world, a, cube(0, 4));
    ck_assert_uint_eq(stats_of(world).pending, 1);
    ok(msap_remove(world, a));
    ck_assert(stats_of(world).pending == 1 && stats_of(world).boxes == 1 && stats_of(world).pairs == 1);
    ok(msap_remove(world, b));
    ck_assert_uint_eq(stats_of(world).pending, 2);
    commit(world, 1, 0, 0);
    ck_assert(stats_of(world).pending == 0 && stats_of(world).boxes == 0 && stats_of(world).commits == 2);
    ok(msap_destroy(world));
}
END_TEST

/* Bytes and calls are the allocator's. */
START_TEST(memory_is_accounted_for)
{
    session s;
    msap_world_stats stats;
    int frame;
    right(session_open(&s, NULL, 1, SCENE_GRID));
    for (frame = 0; frame < 30; frame++) {
        right(session_step(&s, 100));
        stats = stats_of(s.world);
        ck_assert_uint_eq(stats.bytes, s.memory.bytes);
        ck_assert_uint_eq(stats.bytes_peak, s.memory.peak);
        ck_assert_uint_eq(stats.allocations, s.memory.calls);
        if (frame % 10 == 9)
            right(session_trim(&s));
    }
    right(session_close(&s));
}
END_TEST

/* Each commit that had something to do used one strategy; one that had nothing, none
 * that looked at anything. */
START_TEST(an_empty_commit_does_nothing)
{
    msap_world *world = new_world(3, _i);
    msap_world_stats s;
    add(world, cube(0, 1));
    add(world, cube(0, 1));
    commit(world, 0, 1, 1);
    s = stats_of(world);
    ck_assert_uint_eq(s.slides + s.merges + s.sweeps, 1);
    ck_assert_uint_ge(s.touched, 1);
    commit(world, 0, 0, 1);
    s = stats_of(world);
    ck_assert(s.commits == 2 && s.touched == 0 && s.crossings == 0);
    ok(msap_destroy(world));
}
END_TEST

/* A failed commit counts for nothing. */
START_TEST(refused_commits_do_not_count)
{
    msap_world *world = new_world(3, DEFAULT);
    msap_counts counts = {1, 0, 0, 0, 0};
    add(world, cube(0, 1));
    refused(msap_commit(world, NULL, &counts), MSAP_ERROR_STRUCT_SIZE);
    ck_assert(stats_of(world).commits == 0 && stats_of(world).pending == 1);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("stats");
    tcase_add_test(tests, a_new_world);
    tcase_add_test(tests, pending);
    tcase_add_test(tests, memory_is_accounted_for);
    tcase_add_loop_test(tests, an_empty_commit_does_nothing, 0, SETUPS);
    tcase_add_test(tests, refused_commits_do_not_count);
    return run_case(tests, "stats");
}
