/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: all set-ups give the same handles, events and arrays, the array of all
 * pairs in the same order included, and all are what brute force gives; a strategy
 * that is asked for is used, and AUTO chooses with sense.
 */
#include "checks.h"

#define FRAMES 60

static void same_pairs(const msap_world *world, const msap_world *other)
{
    const msap_pair *pairs, *others;
    size_t count, other_count, i;
    ok(msap_pairs(world, &pairs, &count));
    ok(msap_pairs(other, &others, &other_count));
    ck_assert_uint_eq(count, other_count);
    for (i = 0; i < count; i++) {
        ck_assert_uint_eq(pairs[i].a, others[i].a);
        ck_assert_uint_eq(pairs[i].b, others[i].b);
        ck_assert_ptr_eq(pairs[i].user_data, others[i].user_data);
    }
}

/* Random frames; the loop variable is the seed. */
START_TEST(all_set_ups_agree)
{
    static session sessions[SETUPS];
    scene_kind scene = (scene_kind)(_i % SCENE_COUNT);
    uint32_t dims = _i / SCENE_COUNT % 2 ? 2 : 3;
    int frame, i;
    for (i = 0; i < SETUPS; i++) {
        msap_config config = config_of(dims, i);
        right(session_open(&sessions[i], &config, (uint64_t)_i, scene));
    }
    for (frame = 0; frame < FRAMES; frame++)
        for (i = 0; i < SETUPS; i++) {
            setup_name = setups[i].name;
            right(session_step(&sessions[i], 50)); /* compares with brute force */
            ck_assert_uint_eq(sessions[i].random, sessions[0].random);
            same_pairs(sessions[i].world, sessions[0].world);
        }
    for (i = 0; i < SETUPS; i++)
        right(session_close(&sessions[i]));
}
END_TEST

/* ------------------------------------------------------------------- forced */

static msap_config forced(uint32_t grid, int strategy)
{
    msap_config config = config_of(3, DEFAULT);
    config.grid = grid;
    config.strategy = (uint32_t)strategy;
    return config;
}

static msap_world_stats stats_after_frames(const msap_config *config)
{
    msap_world_stats stats;
    session s;
    int frame;
    right(session_open(&s, config, 5, SCENE_GRID));
    for (frame = 0; frame < FRAMES; frame++)
        right(session_step(&s, 50));
    stats = stats_of(s.world);
    right(session_close(&s));
    return stats;
}

/* A forced strategy is the one that is used, and only that. */
START_TEST(a_single_sap_can_be_forced)
{
    msap_config config = forced(MSAP_GRID_NONE, _i);
    msap_world_stats stats = stats_after_frames(&config);
    ck_assert((stats.slides > 0) == (_i == MSAP_STRATEGY_SLIDE));
    ck_assert((stats.merges > 0) == (_i == MSAP_STRATEGY_MERGE));
    ck_assert((stats.sweeps > 0) == (_i == MSAP_STRATEGY_SWEEP));
}
END_TEST

/* But the first commit of a grid, which lays it out, is a sweep. */
START_TEST(a_grid_can_be_forced)
{
    static const uint32_t grids[] = {MSAP_GRID_AUTO, MSAP_GRID_FIXED};
    size_t i;
    for (i = 0; i < COUNT(grids); i++) {
        msap_config config = forced(grids[i], _i);
        msap_world_stats stats = stats_after_frames(&config);
        ck_assert((stats.slides > 0) == (_i == MSAP_STRATEGY_SLIDE));
        ck_assert((stats.merges > 0) == (_i == MSAP_STRATEGY_MERGE));
        ck_assert((stats.sweeps > 1) == (_i == MSAP_STRATEGY_SWEEP));
        ck_assert_uint_ge(stats.sweeps, 1);
    }
}
END_TEST

/* --------------------------------------------------------------------- AUTO */

/* AUTO does not look at all boxes when one has moved a little, and does not slide
 * 2000 boxes that jump. */
static void auto_chooses(const msap_config *config)
{
    uint64_t random = 3;
    msap_handle handles[2000];
    msap_world_stats before, after;
    box b = random_box(&random, SCENE_SPREAD);
    msap_world *world;
    int i;
    ok(msap_create(config, &world));
    handles[0] = add(world, b);
    for (i = 1; i < 2000; i++)
        handles[i] = add(world, random_box(&random, SCENE_SPREAD));
    ok(msap_commit(world, NULL, NULL));
    before = stats_of(world);
    b.max[0] += 1;
    update(world, handles[0], b);
    ok(msap_commit(world, NULL, NULL));
    after = stats_of(world);
    ck_assert_uint_eq(after.sweeps, before.sweeps);
    ck_assert_uint_eq(after.slides + after.merges, before.slides + before.merges + 1);
    before = after;
    for (i = 0; i < 2000; i++)
        update(world, handles[i], random_box(&random, SCENE_SPREAD));
    ok(msap_commit(world, NULL, NULL));
    after = stats_of(world);
    ck_assert_uint_eq(after.slides, before.slides);
    ck_assert_uint_eq(after.sweeps + after.merges, before.sweeps + before.merges + 1);
    ok(msap_destroy(world));
}

START_TEST(auto_of_a_single_sap)
{
    msap_config config = forced(MSAP_GRID_NONE, MSAP_STRATEGY_AUTO);
    auto_chooses(&config);
}
END_TEST

START_TEST(auto_of_a_grid)
{
    msap_config config = forced(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO);
    auto_chooses(&config);
    config.margin = 100;
    auto_chooses(&config);
}
END_TEST

/* Of very many boxes four hundred jump, one by one; then 2,500 go, cell by cell. */
START_TEST(auto_goes_by_cell)
{
    enum { BOXES = 9000 };
    static msap_handle handles[BOXES];
    msap_config config = forced(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO);
    msap_world_stats before, after;
    msap_world *world;
    uint64_t random = 4;
    int i;
    ok(msap_create(&config, &world));
    for (i = 0; i < BOXES; i++)
        handles[i] = add(world, bar((float)(2 * i), (float)(2 * i + 1)));
    commit(world, 0, 0, 0);
    before = stats_of(world);
    for (i = 0; i < 1200; i += 3)
        update(world, handles[i], bar((float)random_below(&random, 3 * BOXES) - 9 * BOXES, -3 * BOXES));
    ok(msap_commit(world, NULL, NULL));
    after = stats_of(world);
    ck_assert_uint_eq(after.slides, before.slides + 1);
    ok(msap_remove_many(world, 2500, handles + 4000));
    ok(msap_commit(world, NULL, NULL));
    before = after;
    after = stats_of(world);
    ck_assert_uint_eq(after.merges, before.merges + 1);
    ok(msap_validate(world, NULL));
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("strategies");
    tcase_add_loop_test(tests, all_set_ups_agree, 0, 2 * SCENE_COUNT);
    tcase_add_loop_test(tests, a_single_sap_can_be_forced, MSAP_STRATEGY_SLIDE, MSAP_STRATEGY_SWEEP + 1);
    tcase_add_loop_test(tests, a_grid_can_be_forced, MSAP_STRATEGY_SLIDE, MSAP_STRATEGY_SWEEP + 1);
    tcase_add_test(tests, auto_of_a_single_sap);
    tcase_add_test(tests, auto_of_a_grid);
    tcase_add_test(tests, auto_goes_by_cell);
    return run_case(tests, "strategies");
}
