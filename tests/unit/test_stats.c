/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: msap_stats counts what the header says it counts.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

START_TEST(a_new_world)
{
    msap_world *world = new_world(3, _i);
    msap_world_stats s = stats_of(world);
    ck_assert_uint_eq(s.struct_size, sizeof s);
    ck_assert(s.boxes == 0 && s.pairs == 0 && s.pending == 0 && s.commits == 0);
    ck_assert(s.crossings == 0 && s.touched == 0 && s.slides == 0 && s.merges == 0 && s.sweeps == 0);
    ck_assert(s.moves == 0 && s.cells == 0 && s.cells_empty == 0 && s.incidences == 0 && s.largest_cell == 0);
    ck_assert(s.giants == 0 && s.candidates == 0);
    ck_assert(s.bytes > 0 && s.bytes_peak >= s.bytes && s.allocations > 0);
    ok(msap_destroy(world));
}
END_TEST

/* A box is pending once, whatever happens to it. */
START_TEST(pending)
{
    msap_world *world = new_world(3, _i);
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
    msap_config config = config_of(3, _i);
    session s;
    msap_world_stats stats;
    int frame;
    right(session_open(&s, &config, 1, SCENE_GRID));
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
    msap_world *world = new_world(3, _i);
    msap_counts counts = {1, 0, 0, 0, 0};
    add(world, cube(0, 1));
    refused(msap_commit(world, NULL, &counts), MSAP_ERROR_STRUCT_SIZE);
    ck_assert(stats_of(world).commits == 0 && stats_of(world).pending == 1);
    ok(msap_destroy(world));
}
END_TEST

/* -------------------------------------------------------------------- grids */

/* 4x4 cells of width 4, and a box in the middle of each. */
static msap_world *one_box_a_cell(void)
{
    msap_config config = config_of(2, DEFAULT);
    msap_world *world;
    int i, c;
    config.grid = MSAP_GRID_FIXED;
    config.margin = 0;
    for (c = 0; c < 2; c++) {
        config.grid_cells[c] = 4;
        config.grid_max[c] = 16;
    }
    ok(msap_create(&config, &world));
    for (i = 0; i < 16; i++) {
        float x = (float)(4 * (i % 4) + 1), y = (float)(4 * (i / 4) + 1);
        add(world, box_of(x, y, 0, x + 1, y + 1, 0));
    }
    commit(world, 0, 0, 0);
    return world;
}

START_TEST(cells_are_counted)
{
    msap_world *world = one_box_a_cell();
    msap_world_stats s = stats_of(world);
    msap_handle crossing;
    ck_assert(s.cells == 16 && s.incidences == 16 && s.largest_cell == 1 && s.giants == 0 && s.candidates == 0);
    crossing = add(world, box_of(3, 3, 0, 5, 5, 0)); /* over a corner of four cells; touches one box */
    commit(world, 0, 1, 1);
    s = stats_of(world);
    ck_assert(s.cells == 16 && s.incidences == 20 && s.largest_cell == 2 && s.candidates == 1);
    ok(msap_remove(world, crossing));
    commit(world, 1, 0, 0);
    s = stats_of(world);
    ck_assert(s.cells == 16 && s.incidences == 16 && s.largest_cell == 1 && s.candidates == 0);
    ok(msap_remove(world, (msap_handle)5 << 32 | 1));
    commit(world, 0, 0, 0);
    s = stats_of(world);
    ck_assert(s.cells == 15 && s.incidences == 15);
    ok(msap_destroy(world));
}
END_TEST

/* A move is a box that is put elsewhere; a margin makes some motion none. */
START_TEST(moves_are_counted)
{
    msap_config config = config_of(3, DEFAULT);
    msap_handle handles[100];
    msap_world *world;
    int i;
    config.margin = 1;
    config.strategy = MSAP_STRATEGY_SLIDE;
    ok(msap_create(&config, &world));
    for (i = 0; i < 100; i++)
        handles[i] = add(world, bar((float)(10 * i), (float)(10 * i + 1)));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(stats_of(world).moves, 100);
    for (i = 0; i < 100; i++)
        update(world, handles[i], bar((float)(10 * i) + 0.75f, (float)(10 * i) + 1.75f));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(stats_of(world).moves, 0);
    for (i = 0; i < 30; i++)
        update(world, handles[i], bar((float)(10 * i) + 1.5f, (float)(10 * i) + 2.5f));
    ok(msap_remove(world, handles[99]));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(stats_of(world).moves, 31);
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(stats_of(world).moves, 0);
    ok(msap_destroy(world));
}
END_TEST

/* Boxes that rest are in no cell, and two of them no neighbours. */
static void boxes_of_cells(const msap_world *world, uint64_t *boxes, uint64_t *pairs)
{
    const struct grid *g = &world->grid;
    for (size_t slot = 0; slot < world->boxes.used; slot++) *boxes -= (uint64_t)rests(g, &world->boxes.at[slot]);
    for (size_t i = 0; i < world->pairs.active; i++) {
        uint32_t a = slot_of(world->pairs.at[i].a), b = slot_of(world->pairs.at[i].b);
        *pairs -= (uint64_t)(rests(g, &world->boxes.at[a]) && rests(g, &world->boxes.at[b]));
    }
}

/* What is counted fits together, whatever the set-up and whatever was done to the
 * boxes; of a single SAP nothing of it is counted. */
START_TEST(counts_of_a_grid_fit_together)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    right(session_open(&s, &config, 5, SCENE_SIZES));
    for (frame = 0; frame < 40; frame++) {
        msap_world_stats stats;
        right(session_step(&s, 150));
        stats = stats_of(s.world);
        if (config.grid == MSAP_GRID_NONE) {
            ck_assert(!stats.moves && !stats.cells && !stats.cells_empty && !stats.incidences);
            ck_assert(!stats.largest_cell && !stats.giants && !stats.candidates);
            continue;
        }
        ck_assert_uint_le(stats.cells, stats.incidences);
        ck_assert_uint_le(stats.largest_cell, stats.boxes);
        ck_assert_uint_le(stats.giants, stats.boxes);
        ck_assert_uint_eq(stats.incidences == 0, stats.cells == 0);
        ck_assert_uint_eq(stats.incidences == 0, stats.largest_cell == 0);
        if (stats.incidences) { /* not so after a commit that pruned everything and kept no cells */
            boxes_of_cells(s.world, &stats.boxes, &stats.pairs);
            ck_assert_uint_ge(stats.incidences, stats.boxes);
            ck_assert_uint_ge(stats.candidates, stats.pairs);
        }
    }
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("stats");
    tcase_add_loop_test(tests, a_new_world, 0, SETUPS);
    tcase_add_loop_test(tests, pending, 0, SETUPS);
    tcase_add_loop_test(tests, memory_is_accounted_for, 0, SETUPS);
    tcase_add_loop_test(tests, an_empty_commit_does_nothing, 0, SETUPS);
    tcase_add_loop_test(tests, refused_commits_do_not_count, 0, SETUPS);
    tcase_add_test(tests, cells_are_counted);
    tcase_add_test(tests, moves_are_counted);
    tcase_add_loop_test(tests, counts_of_a_grid_fit_together, 0, SETUPS);
    return run_case(tests, "stats");
}
