/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: boxes that are large compared with the others - half-spaces, ground planes,
 * a static box over the whole map, boxes over a million cells - cost a grid no more
 * than their pairs: not a cell for each place that they cover, nor a look at each.
 * Work and memory are counted, not timed.
 */
#include "checks.h"

#define INF float_of(0x7F800000)

/* What a commit may look at: some times the pairs that there are, and some pairs for
 * each box. */
static void work_is_bounded(const msap_world *world, const msap_config *config)
{
    msap_world_stats stats = stats_of(world);
    if (config->grid == MSAP_GRID_NONE)
        return; /* there is no such promise */
    ck_assert_msg(stats.touched <= 8 * (stats.pairs + 10 * stats.boxes), "%s: %lu touched, %lu pairs, %lu boxes",
                  setup_name, (unsigned long)stats.touched, (unsigned long)stats.pairs, (unsigned long)stats.boxes);
    ck_assert_msg(stats.incidences <= 10 * stats.boxes, "%s: %lu incidences", setup_name,
                  (unsigned long)stats.incidences);
}

/* ------------------------------------------------------------- half-spaces */

enum { HALF_SPACES = 1000, MOVERS = 1000 };

static box half_space(int i)
{
    float c = (float)(i / 6) / 8; /* near the outside of the cube from 0 to 1000 */
    switch (i % 6) {
    case 0:
        return box_of(-INF, -INF, -INF, c, INF, INF);
    case 1:
        return box_of(1000 - c, -INF, -INF, INF, INF, INF);
    case 2:
        return box_of(-INF, -INF, -INF, INF, c, INF);
    case 3:
        return box_of(-INF, 1000 - c, -INF, INF, INF, INF);
    case 4:
        return box_of(-INF, -INF, -INF, INF, INF, c);
    default:
        return box_of(-INF, -INF, 1000 - c, INF, INF, INF);
    }
}

static box mover(int i, int frame)
{
    float x = (float)(i * 37 % 1000), y = (float)(i * 101 % 997), z = (float)(i * 13 % 991);
    float step = (float)frame * (i % 2 ? 0.25f : -0.25f);
    return box_of(x + step, y, z - step, x + step + 2, y + 2, z - step + 2);
}

START_TEST(a_thousand_half_spaces)
{
    static msap_handle planes[HALF_SPACES], movers[MOVERS];
    msap_config config = config_of(3, _i);
    session s;
    int i, frame;
    right(session_open(&s, &config, 1, SCENE_HARD));
    for (i = 0; i < HALF_SPACES; i++) {
        box b = half_space(i);
        right(session_add(&s, &b, MSAP_STATIC, &planes[i]));
    }
    for (i = 0; i < MOVERS; i++) {
        box b = mover(i, 0);
        right(session_add(&s, &b, 0, &movers[i]));
    }
    right(session_commit(&s));
    for (frame = 1; frame < 5; frame++) {
        for (i = 0; i < MOVERS; i++) {
            box b = mover(i, frame);
            right(session_update(&s, movers[i], &b));
        }
        right(session_commit(&s));
        work_is_bounded(s.world, &config);
    }
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* ------------------------------------------------------- a million cells each */

enum { LARGE = 100, SMALL = 2000 };

/* Small boxes all over the square from 0 to 1000; each large one covers all of it, at a
 * height of its own where only every tenth small one is. */
static box small_box(int i)
{
    float x = (float)(i * 389 % 1000), y = (float)(i * 211 % 1000), z = (float)(i % 1000);
    return box_of(x, y, z, x + 0.5f, y + 0.5f, z + 0.25f);
}

static box large_box(int i, int frame)
{
    float z = (float)(10 * i) + 0.125f * (float)frame;
    return box_of(0, 0, z, 1000, 1000, z);
}

static void boxes_over_a_million_cells(const msap_config *config, uint64_t most_bytes)
{
    static msap_handle large[LARGE], small[SMALL];
    session s;
    int i, frame;
    right(session_open(&s, config, 1, SCENE_HARD));
    for (i = 0; i < SMALL; i++) {
        box b = small_box(i);
        right(session_add(&s, &b, 0, &small[i]));
    }
    right(session_commit(&s));
    for (frame = 0; frame < 4; frame++) {
        for (i = 0; i < LARGE; i++) { /* later a quarter of them moves */
            box b = large_box(i, frame);
            if (frame && i % 4 != frame)
                continue;
            right(frame ? session_update(&s, large[i], &b) : session_add(&s, &b, 0, &large[i]));
        }
        right(session_commit(&s));
        work_is_bounded(s.world, config);
        ck_assert_uint_le(s.memory.peak, most_bytes);
    }
    ck_assert_uint_gt(s.reference.pair_count, 100);
    for (i = 0; i < LARGE; i++)
        right(session_remove(&s, large[i]));
    right(session_commit(&s));
    right(session_compare(&s));
    right(session_close(&s));
}

/* A fixed grid: the cells have memory for their heads, and no more. The default, and
 * what differs from it by the margin alone. */
START_TEST(a_million_cells_that_are_there)
{
    msap_config config = config_of(3, _i);
    int c;
    if (_i != DEFAULT && (setups[_i].margin == 0 || config.strategy != MSAP_STRATEGY_AUTO))
        return;
    config.grid = MSAP_GRID_FIXED;
    for (c = 0; c < 3; c++) {
        config.grid_cells[c] = c < 2 ? 1000 : 1;
        config.grid_min[c] = 0;
        config.grid_max[c] = 1000;
    }
    boxes_over_a_million_cells(&config, 64u << 20);
}
END_TEST

/* Cells of a width that is given, or is chosen for the small boxes: a large one covers
 * millions of them in space, whatever has memory. */
START_TEST(a_million_cells_in_space)
{
    msap_config config = config_of(3, _i);
    boxes_over_a_million_cells(&config, 4u << 20);
}
END_TEST

/* --------------------------------------------------------------- static boxes */

enum { STATICS = 10000, WALKERS = 400 };

/* A map of 100x100 static tiles, apart from each other, under one static box that covers
 * all of it; some walk about on them, by turns. Every walker is on the ground, and on
 * the tile that it is over. */
START_TEST(many_statics_and_one_over_the_whole_map)
{
    static msap_handle walkers[WALKERS];
    msap_config config = config_of(3, _i);
    msap_world_stats before, after;
    msap_world *world;
    int i, frame;
    ok(msap_create(&config, &world));
    add_flagged(world, box_of(0, 0, -1, 1000, 1000, 0), MSAP_STATIC);
    for (i = 0; i < STATICS; i++) {
        float x = (float)(10 * (i % 100)), y = (float)(10 * (i / 100));
        add_flagged(world, box_of(x + 1, y + 1, -0.5f, x + 9, y + 9, 0.5f), MSAP_STATIC);
    }
    for (i = 0; i < WALKERS; i++) {
        float x = (float)(10 * (i * 7 % 100) + 4), y = (float)(10 * (i * 3 % 97) + 4);
        walkers[i] = add(world, box_of(x, y, 0, x + 0.5f, y + 0.5f, 2));
    }
    commit(world, 0, 2 * WALKERS, 2 * WALKERS);
    before = stats_of(world);
    for (frame = 1; frame <= 20; frame++) {
        for (i = frame % 2; i < WALKERS; i += 2) {
            float x = (float)(10 * (i * 7 % 100) + 4) + 0.125f * (float)frame, y = (float)(10 * (i * 3 % 97) + 4);
            update(world, walkers[i], box_of(x, y, 0, x + 0.5f, y + 0.5f, 2));
        }
        commit(world, 0, 0, 2 * WALKERS);
        if (config.grid == MSAP_GRID_AUTO && config.strategy != MSAP_STRATEGY_SWEEP && config.cell_size < 100)
            ck_assert_uint_le(stats_of(world).touched, 20 * WALKERS); /* not by the number of static boxes */
    }
    after = stats_of(world);
    if (config.grid == MSAP_GRID_AUTO && config.cell_size < 100 && setups[_i].margin != 3) {
        ck_assert_uint_le(after.candidates, 8 * WALKERS); /* two static boxes are never neighbours */
        ck_assert_uint_le(after.incidences, 8 * after.boxes);
    }
    ck_assert_uint_le(after.bytes, before.bytes + before.bytes / 4);
    ok(msap_destroy(world));
}
END_TEST

/* A plane that covers everything comes, moves and goes, many times. */
START_TEST(a_ground_plane_comes_and_goes)
{
    msap_config config = config_of(3, _i);
    msap_world *world;
    msap_handle plane;
    uint64_t bytes = 0;
    int i, round;
    ok(msap_create(&config, &world));
    for (i = 0; i < 2000; i++) {
        float x = (float)(3 * (i % 50)), y = (float)(3 * (i / 50));
        add(world, box_of(x, y, 0, x + 1, y + 1, 1));
    }
    commit(world, 0, 0, 0);
    for (round = 0; round < 6; round++) {
        plane = add_flagged(world, box_of(-INF, -INF, -INF, INF, INF, 0), round % 2 ? MSAP_STATIC : 0);
        commit(world, 0, 2000, 2000);
        update(world, plane, box_of(-INF, -INF, -INF, INF, INF, -1));
        commit(world, 2000, 0, 0);
        update(world, plane, box_of(-INF, 0, -INF, INF, 0, INF));
        commit(world, 0, 50, 50);
        ok(msap_remove(world, plane));
        commit(world, 50, 0, 0);
        if (round == 1)
            bytes = stats_of(world).bytes;
    }
    ck_assert_uint_le(stats_of(world).bytes, bytes + bytes / 4);
    ok(msap_destroy(world));
}
END_TEST

/* ---------------------------------------------------------------- all jumps */

/* All boxes jump in every frame: the small ones anywhere, or all to the same place; from
 * the third on some are giants, of all kinds. */
static box jumper(uint64_t *random, int is_giant, int is_heap, int frame)
{
    float x = (float)random_below(random, 500), y = (float)random_below(random, 500), far = (float)(3000 * frame);
    if (is_giant)
        return box_of(-INF, -INF, y, INF, random_below(random, 2) ? INF : x, y + 1);
    if (is_heap)
        return cube(far + x / 1000, far + 1 + y / 1000);
    return box_of(x, y, y - x, x + 2, y + 2, y - x + 2);
}

START_TEST(giants_where_all_jumps)
{
    static const struct {
        int small, giants, is_heap;
    } scenes[] = {{300, 0, 1}, {300, 10, 0}, {25, 60, 0}, {100, 100, 0}, {300, 1, 1}};
    size_t scene;
    for (scene = 0; scene < COUNT(scenes); scene++) {
        static msap_handle handles[400];
        msap_config config = config_of(scene % 2 ? 2 : 3, _i);
        session s;
        int frame, i, n = scenes[scene].small + scenes[scene].giants;
        right(session_open(&s, &config, 3 + scene, SCENE_HARD));
        for (frame = 0; frame < 6; frame++) {
            for (i = 0; i < n; i++) {
                int is_giant = frame > 1 && i >= scenes[scene].small;
                box b = jumper(&s.random, is_giant, scenes[scene].is_heap, frame);
                right(frame ? session_update(&s, handles[i], &b)
                            : session_add(&s, &b, i % 3 ? 0 : MSAP_STATIC, &handles[i]));
            }
            right(session_commit(&s));
        }
        right(session_compare(&s));
        right(session_close(&s));
    }
}
END_TEST

/* A crowd over many rows; each of the last ones spans all of them in the frames in
 * which they are giants. */
enum { JUMPERS = 900, GIANTS = 300 };

static box in_crowd(uint64_t *random, int is_giant)
{
    float x = (float)random_below(random, 192) / 8, y = (float)random_below(random, 160) / 8;
    return is_giant ? box_of(x, -INF, 0, x + 0.125f, INF, 1) : box_of(x, y, 0, x + 1, y + 1, 1);
}

/* Where all jumps nothing is kept, so there are no neighbours; but three hundred giants are too
 * many to be compared with all: then neighbours are found in cells. */
START_TEST(many_giants_where_all_jumps)
{
    static msap_handle handles[JUMPERS];
    msap_config config = config_of(_i % 2 ? 2 : 3, _i);
    session s;
    int frame, i;
    right(session_open(&s, &config, 9, SCENE_HARD));
    for (frame = 0; frame < 6; frame++) {
        int are_giants = frame == 2 || frame == 3;
        for (i = 0; i < JUMPERS; i++) {
            box b = in_crowd(&s.random, are_giants && i >= JUMPERS - GIANTS);
            right(frame ? session_update(&s, handles[i], &b) : session_add(&s, &b, 0, &handles[i]));
        }
        right(session_commit(&s));
        if (_i == DEFAULT && frame > 0)
            ck_assert_int_eq(stats_of(s.world).candidates > 0, are_giants);
    }
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("giants");
    tcase_add_loop_test(tests, giants_where_all_jumps, 0, SETUPS);
    tcase_add_loop_test(tests, many_giants_where_all_jumps, 0, SETUPS);
    tcase_add_loop_test(tests, a_thousand_half_spaces, 0, SETUPS);
    tcase_add_loop_test(tests, a_million_cells_that_are_there, 0, SETUPS);
    tcase_add_loop_test(tests, a_million_cells_in_space, 0, SETUPS);
    tcase_add_loop_test(tests, many_statics_and_one_over_the_whole_map, 0, SETUPS);
    tcase_add_loop_test(tests, a_ground_plane_comes_and_goes, 0, SETUPS);
    return run_case(tests, "giants");
}
