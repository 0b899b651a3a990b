/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: the world has no bounds. How far out boxes are, or have been, costs neither
 * work nor memory: they fly to 1e30 and back, they fall for ever. Work is counted, not
 * timed.
 */
#include "checks.h"

#define BOXES 300

/* Set-ups that differ in more than who does the work, and how. */
static int is_of_interest(int row)
{
    return !setups[row].workers && !setups[row].simd && !setups[row].no_filters && !setups[row].strategy;
}

/* ------------------------------------------------------- to 1e30 and back */

/* Ten directions, 30 boxes on each; their distance from the origin is `far`, and all
 * are as large as at home. */
static box on_its_way(int i, float far)
{
    static const float way[10][3] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1},
                                     {0, 0, -1}, {1, 1, 0}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, -1}};
    box b;
    int c;
    for (c = 0; c < 3; c++) {
        b.min[c] = (float)((i * (7 + 4 * c) + i / 10) % 29) + far * way[i % 10][c];
        b.max[c] = b.min[c] + 1.5f;
    }
    return b;
}

static void fly_to(session *s, const msap_handle *handles, float far)
{
    int i;
    for (i = 0; i < BOXES; i++) {
        box b = on_its_way(i, far);
        right(session_update(s, handles[i], &b));
    }
    right(session_commit(s));
    right(session_compare(s));
}

/* Far out, where neighbouring floats are wide apart, the boxes of a direction come
 * together on the axes of their flight. */
static uint64_t fly_out_and_back(session *s, const msap_handle *handles)
{
    uint64_t touched = 0;
    float far;
    for (far = 1; far < 2e30f; far *= 32) {
        fly_to(s, handles, far);
        touched += stats_of(s->world).touched;
    }
    for (; far > 1; far /= 32)
        fly_to(s, handles, far);
    fly_to(s, handles, 0);
    return touched;
}

START_TEST(to_1e30_and_back)
{
    msap_config config = config_of(3, _i);
    msap_handle handles[BOXES];
    session s;
    uint64_t bytes = 0;
    int i, flight;
    right(session_open(&s, &config, 1, SCENE_HARD));
    for (i = 0; i < BOXES; i++) {
        box b = on_its_way(i, 0);
        right(session_add(&s, &b, 0, &handles[i]));
    }
    right(session_commit(&s));
    for (flight = 0; flight < 3; flight++) {
        fly_out_and_back(&s, handles);
        if (flight)
            ck_assert_uint_le(stats_of(s.world).bytes, bytes + bytes / 4);
        bytes = stats_of(s.world).bytes;
    }
    right(session_close(&s));
}
END_TEST

/* A wide field of boxes on their way along z: however far they are, a commit looks at
 * few pairs of each, and the cells stay as full as they were. */
START_TEST(a_field_that_flies_away)
{
    enum { SIDE = 60 };
    static msap_handle handles[SIDE * SIDE];
    msap_config config = config_of(3, _i);
    msap_world *world;
    float far;
    int i, frame;
    if (config.grid != MSAP_GRID_AUTO || setups[_i].cell_size > 2)
        return;
    ok(msap_create(&config, &world));
    for (i = 0; i < SIDE * SIDE; i++)
        handles[i] = add(world, box_of((float)(2 * (i % SIDE)), (float)(2 * (i / SIDE)), 0, (float)(2 * (i % SIDE) + 2),
                                       (float)(2 * (i / SIDE) + 1), 1)); /* each touches the next in its row */
    ok(msap_commit(world, NULL, NULL));
    ck_assert_uint_eq(stats_of(world).pairs, SIDE * (SIDE - 1));
    for (far = 1, frame = 0; far < 2e30f; far *= 8, frame++) {
        msap_world_stats stats;
        for (i = 0; i < SIDE * SIDE; i++)
            update(world, handles[i], box_of((float)(2 * (i % SIDE)), (float)(2 * (i / SIDE)), far,
                                             (float)(2 * (i % SIDE) + 2), (float)(2 * (i / SIDE) + 1), far + 1));
        commit(world, 0, 0, SIDE * (SIDE - 1));
        stats = stats_of(world);
        ck_assert_uint_le(stats.touched, 40 * SIDE * SIDE);
        ck_assert_uint_le(stats.largest_cell, 400);
        ck_assert_uint_le(stats.incidences, 8 * SIDE * SIDE);
    }
    ok(msap_destroy(world));
}
END_TEST

/* Grains in a row that is a billion times as long as they are: there are no more cells
 * for it than are worth it. Each meets the next when it comes along. */
START_TEST(grains_far_apart)
{
    enum { GRAINS = 400 };
    msap_config config = config_of(3, _i);
    msap_handle handles[GRAINS];
    session s;
    int i, frame;
    right(session_open(&s, &config, 1, SCENE_HARD));
    for (i = 0; i < GRAINS; i++) {
        box b = box_of((float)(2500 * i), 0, 0, (float)(2500 * i) + 0.125f, 0.001f, 0.001f);
        right(session_add(&s, &b, 0, &handles[i]));
    }
    right(session_commit(&s));
    for (frame = 1; frame < 6; frame++) {
        for (i = 0; i < GRAINS; i++) {
            float x = (float)(2500 * (i + frame * (i % 2)));
            box b = box_of(x, 0, 0, x + 0.125f, 0.001f, 0.001f);
            right(session_update(&s, handles[i], &b));
        }
        right(session_commit(&s));
        ck_assert_uint_le(s.memory.bytes, 16u << 20);
    }
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* ---------------------------------------------------------- falling for ever */

/* On a ground of 400 static boxes 60 others walk about; the last falls through, and on,
 * the faster if `faster`. What the world holds half-way is all that it ever holds. */
static void fall(int row, int commits, int faster)
{
    msap_config config = config_of(3, row);
    msap_handle walkers[60], falling;
    uint64_t random = 5, bytes = 0;
    float height = 10;
    msap_world *world;
    int i, n;
    ok(msap_create(&config, &world));
    for (i = 0; i < 400; i++)
        add_flagged(world, box_of((float)(i % 20), (float)(i / 20), -1, (float)(i % 20 + 1), (float)(i / 20 + 1), 0),
                    MSAP_STATIC);
    for (i = 0; i < 60; i++)
        walkers[i] = add(world, cube((float)i, (float)i + 0.5f));
    falling = add(world, cube(5, 6));
    for (n = 0; n < commits; n++) {
        float x = (float)random_below(&random, 18), y = (float)random_below(&random, 18);
        update(world, walkers[n % 60], box_of(x, y, 0.5f, x + 1, y + 1, 1.5f));
        height -= faster ? 400 * (float)n / (float)commits : 1; /* up to 400 a commit */
        update(world, falling, box_of(5, 5, height, 6, 6, height + 1));
        ok(msap_commit(world, NULL, NULL));
        if (n == commits / 2)
            bytes = stats_of(world).bytes;
    }
    ck_assert_uint_le(stats_of(world).bytes, bytes + bytes / 20);
    update(world, falling, box_of(5.25f, 5.25f, -1, 5.75f, 5.75f, 0));
    ok(msap_commit(world, NULL, NULL));
    ck_assert(is_pair(world, falling, (msap_handle)105 << 32 | 1)); /* the box of the ground at 5, 5 */
    ok(msap_destroy(world));
}

/* The default for long, the others for a fifth of it. */
START_TEST(a_box_that_falls_for_200000_commits)
{
    if (is_of_interest(_i))
        fall(_i, _i == DEFAULT ? 200000 : 40000, 0);
}
END_TEST

START_TEST(a_box_that_falls_faster_and_faster)
{
    if (is_of_interest(_i))
        fall(_i, 40000, 1);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("far boxes");
    tcase_add_loop_test(tests, to_1e30_and_back, 0, SETUPS);
    tcase_add_loop_test(tests, a_field_that_flies_away, 0, SETUPS);
    tcase_add_loop_test(tests, grains_far_apart, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_that_falls_for_200000_commits, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_that_falls_faster_and_faster, 0, SETUPS);
    return run_case(tests, "far boxes");
}
