/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: slide, merge, sweep and auto, with and without filters, give the same
 * handles, events and arrays, the array of all pairs in the same order included;
 * and all are what brute force gives.
 */
#include "checks.h"

#define SET_UPS (2 * STRATEGIES)
#define FRAMES 60

static void open_all(session *sessions, uint32_t dims, uint64_t seed, scene_kind scene)
{
    int i;
    for (i = 0; i < SET_UPS; i++) {
        msap_config config = config_of(dims, i / 2);
        config.filters = i % 2;
        right(session_open(&sessions[i], &config, seed, scene));
    }
}

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
    session sessions[SET_UPS];
    scene_kind scene = (scene_kind)(_i % SCENE_COUNT);
    uint32_t dims = _i % 2 ? 2 : 3;
    int frame, i;
    open_all(sessions, dims, (uint64_t)_i, scene);
    for (frame = 0; frame < FRAMES; frame++)
        for (i = 0; i < SET_UPS; i++) {
            right(session_step(&sessions[i], 50)); /* compares with brute force */
            ck_assert_uint_eq(sessions[i].random, sessions[0].random);
            same_pairs(sessions[i].world, sessions[0].world);
        }
    for (i = 0; i < SET_UPS; i++)
        right(session_close(&sessions[i]));
}
END_TEST

/* A forced strategy is the one that is used, and only that. */
START_TEST(a_strategy_can_be_forced)
{
    msap_config config = config_of(3, _i);
    msap_world_stats stats;
    session s;
    int frame;
    right(session_open(&s, &config, 5, SCENE_GRID));
    for (frame = 0; frame < FRAMES; frame++)
        right(session_step(&s, 50));
    stats = stats_of(s.world);
    ck_assert((stats.slides > 0) == (_i == MSAP_STRATEGY_SLIDE));
    ck_assert((stats.merges > 0) == (_i == MSAP_STRATEGY_MERGE));
    ck_assert((stats.sweeps > 0) == (_i == MSAP_STRATEGY_SWEEP));
    right(session_close(&s));
}
END_TEST

/* AUTO does not look at all boxes when one has moved a little, and does not slide
 * 2000 boxes that jump. */
START_TEST(auto_chooses)
{
    msap_world *world = new_world(3, MSAP_STRATEGY_AUTO);
    uint64_t random = 3;
    msap_handle handles[2000];
    msap_world_stats before, after;
    box b = random_box(&random, SCENE_SPREAD);
    int i;
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
END_TEST

int main(void)
{
    TCase *tests = tcase_create("strategies");
    tcase_add_loop_test(tests, all_set_ups_agree, 0, 6);
    tcase_add_loop_test(tests, a_strategy_can_be_forced, MSAP_STRATEGY_SLIDE, STRATEGIES);
    tcase_add_test(tests, auto_chooses);
    return run_case(tests, "strategies");
}
