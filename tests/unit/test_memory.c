/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: memory comes from the world's allocator and goes back to it, with the
 * right sizes; when it gives none, whichever call it is, the world stays as it was
 * and the next try works; a warm commit asks for none, nor does one that only loses
 * pairs; after a trim, and after a long time in which little is left, none is held
 * that is not needed.
 *
 * A session (common.h) checks on every failed call that nothing changed, calls
 * again, and compares sizes at free and what is left at the end.
 */
#include <string.h>

#include "checks.h"

/* ------------------------------------------------------- the n-th call fails */

typedef struct scenario {
    int frames;
    uint32_t boxes;
    scene_kind scene;
    uint64_t seed;
} scenario;

/* Random frames, with the n-th allocation failing, or with all from the n-th on until a
 * call fails for it. A call that fails may change nothing, and is made again. Returns
 * whether it came to an n-th. */
static int plays_with_failure(const scenario *t, int row, size_t n, int and_more)
{
    msap_config config = config_of(t->seed % 2 ? 2 : 3, row);
    session s;
    int frame, failed;
    right(session_open(&s, &config, t->seed, t->scene));
    *(and_more ? &s.memory.fail_from : &s.memory.fail_at) = s.memory.calls + n;
    for (frame = 0; frame < t->frames; frame++) {
        right(session_step(&s, t->boxes));
        if (frame % 5 == 4) {
            right(session_trim(&s)); /* keeps what it cannot make smaller */
            right(session_compare(&s));
        }
    }
    failed = s.memory.failures > 0;
    right(session_close(&s));
    return failed;
}

static void any_allocation_may_fail(const scenario *t, int row, int and_more, size_t n, size_t step)
{
    while (plays_with_failure(t, row, n, and_more))
        n += step;
    ck_assert_uint_gt(n, 5); /* there were some */
}

/* Each set-up plays two scenarios, each of them with one kind of failure. */
START_TEST(any_allocation_of_a_scenario_may_fail)
{
    static const scenario scenarios[] = {{8, 70, SCENE_GRID, 0}, {8, 70, SCENE_SIZES, 1}, {8, 50, SCENE_HARD, 2}};
    any_allocation_may_fail(&scenarios[_i % 3], _i, 0, 1, 1);
    any_allocation_may_fail(&scenarios[(_i + 1) % 3], _i, 1, 1, 1);
}
END_TEST

/* So many boxes that the work is cut into tasks, in such a crowd that the buffers of the
 * workers overflow. Each set-up tries every third allocation. */
START_TEST(any_allocation_may_fail_with_workers)
{
    static const scenario crowd = {2, 700, SCENE_GRID, 4};
    size_t enqueued = jobs_enqueued;
    if (!setups[_i].workers)
        return;
    any_allocation_may_fail(&crowd, _i, _i % 2, 1 + (size_t)_i % 3, 3);
    ck_assert_uint_gt(jobs_enqueued, enqueued);
    ck_assert_uint_eq(jobs_enqueued, jobs_finished);
}
END_TEST

START_TEST(create_may_fail)
{
    tracker m;
    msap_config config = config_of(3, DEFAULT);
    msap_world *world = NULL;
    msap_status status;
    size_t n = 0;
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &m;
    do {
        memset(&m, 0, sizeof m);
        m.fail_at = ++n;
        status = msap_create(&config, &world);
        if (status == MSAP_OK)
            ok(msap_destroy(world));
        else {
            refused(status, MSAP_ERROR_MEMORY);
            ck_assert_ptr_null(world);
        }
        ck_assert(m.blocks == 0 && m.bytes == 0 && m.wrong == 0);
    } while (status != MSAP_OK);
    ck_assert_uint_gt(n, 1);
}
END_TEST

/* ------------------------------------------------------------ all calls fail */

/* What needs no memory works without any: all but add, add_many, commit and the first user data. */
START_TEST(without_memory)
{
    msap_config config = config_of(3, _i);
    box unit = cube(0, 1), far = cube(5, 6);
    msap_boxes boxes = boxes_in_row(&unit);
    msap_handle h[4], handle = 77;
    void *data = NULL;
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 3; i++)
        right(session_add(&s, &unit, 0, &h[i]));
    right(session_commit(&s));
    s.memory.fail_all = 1;
    right(session_update(&s, h[0], &far));
    ok(msap_update_many(s.world, 1, h, &boxes));
    reference_update(&s.reference, h[0], &unit);
    ok(msap_get_user_data(s.world, 1, h, &data));
    ok(msap_set_user_data(s.world, 1, h, &data));
    ok(msap_get_pair_data(s.world, 1, h, h + 1, &data));
    ok(msap_set_pair_data(s.world, 1, h, h + 1, &data));
    right(session_trim(&s));
    right(session_compare(&s));
    right(session_remove(&s, h[0]));
    ok(msap_remove_many(s.world, 1, &h[1]));
    reference_remove(&s.reference, h[1]);
    right(session_compare(&s));
    for (i = 0; i < 10000; i++) { /* sooner or later */
        handle = 77;
        if (msap_add(s.world, unit.min, unit.max, 0, (void *)s.next_tag, &handle) != MSAP_OK)
            break;
        ck_assert_uint_eq(handle, reference_add(&s.reference, &unit, 0, (void *)s.next_tag++));
    }
    ck_assert_int_lt(i, 10000);
    ck_assert_uint_eq(handle, 77);
    last_error(s.world, MSAP_ERROR_MEMORY, 0, MSAP_NO_BOUND);
    refused(msap_add_many(s.world, 1, &boxes, NULL, NULL, &handle), MSAP_ERROR_MEMORY);
    ck_assert_uint_eq(handle, 77);
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* Failed commits, with changes between them; then one that succeeds tells the net
 * difference to the last that did. */
START_TEST(a_failed_commit_is_as_if_it_had_not_been)
{
    msap_config config = config_of(3, _i);
    msap_handle h[100];
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 100; i++) {
        box apart = bar((float)(2 * i), (float)(2 * i + 1));
        right(session_add(&s, &apart, 0, &h[i]));
    }
    right(session_commit(&s));
    for (i = 0; i < 100; i++) { /* all in one place: 4950 new pairs */
        box unit = cube(0, 1);
        right(session_update(&s, h[i], &unit));
    }
    s.memory.fail_all = 1;
    refused(msap_commit(s.world, NULL, NULL), MSAP_ERROR_MEMORY);
    last_error(s.world, MSAP_ERROR_MEMORY, 0, MSAP_NO_BOUND);
    right(session_compare(&s));
    for (i = 0; i < 50; i++) /* half of them are removed after all */
        right(session_remove(&s, h[i]));
    refused(msap_commit(s.world, NULL, NULL), MSAP_ERROR_MEMORY);
    right(session_compare(&s));
    s.memory.fail_all = 0;
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 50 * 49 / 2);
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* A cube of a lattice of 3x3x3 that are apart, or, of giants across two axes, a thin
 * one: between two layers of the lattice, or through the first layer. */
enum { CUBES = 27, SLABS = 60 };

static box lattice_cube(int i)
{
    float x = (float)(i % 3) * 0.875f, y = (float)(i / 3 % 3) * 0.875f, z = (float)(i / 9) * 0.875f;
    return box_of(x, y, z, x + 0.625f, y + 0.625f, z + 0.625f);
}

static box slab(int i, float from)
{
    float inf = float_of(0x7F800000), x = from + (float)i / 512;
    return box_of(x, -inf, -inf, x, inf, inf);
}

/* All cubes jump, and the slabs with them, without meeting anything; then into pairs for
 * which there is no memory: cubes with cubes, or slabs with cubes. */
static void jump_into_pairs(int row, int slabs_meet)
{
    msap_config config = config_of(3, row);
    msap_handle h[CUBES + SLABS];
    session s;
    int frame, i;
    right(session_open(&s, &config, 1, SCENE_HARD));
    for (frame = 0; frame < 4; frame++) {
        for (i = 0; i < CUBES + SLABS; i++) {
            box b = i < CUBES ? lattice_cube(frame < 3 || slabs_meet ? (i + frame) % CUBES : 0)
                              : slab(i - CUBES, frame < 3 || !slabs_meet ? 0.6875f + (float)frame / 1024 : 0.25f);
            right(frame ? session_update(&s, h[i], &b) : session_add(&s, &b, 0, &h[i]));
        }
        if (frame < 3)
            right(session_commit(&s));
        ck_assert_uint_eq(s.reference.pair_count, 0);
    }
    s.memory.fail_all = 1;
    refused(msap_commit(s.world, NULL, NULL), MSAP_ERROR_MEMORY);
    right(session_compare(&s));
    s.memory.fail_all = 0;
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.event_count, slabs_meet ? SLABS * 9 : CUBES * (CUBES - 1) / 2);
    right(session_compare(&s));
    right(session_close(&s));
}

START_TEST(a_jump_into_pairs_without_memory)
{
    jump_into_pairs(_i, 0);
    jump_into_pairs(_i, 1);
}
END_TEST

/* ---------------------------------------------------------------- no memory */

/* The boxes of a plane go over to other cells after many more came beside it, a few in
 * each commit, when there is no memory for that: the commits find what they should by
 * comparing what changed with all boxes. */
START_TEST(other_cells_need_memory_and_events_do_not)
{
    enum { BEFORE = 4000, BESIDE = 12000, LAST = BEFORE + BESIDE - 1 };
    static const uint32_t strategies[] = {MSAP_STRATEGY_SLIDE, MSAP_STRATEGY_MERGE};
    msap_config config = config_of(3, DEFAULT);
    tracker memory = {0};
    msap_world *world;
    int i, frame, compared_all = 0;
    config.strategy = strategies[_i];
    config.margin = 0.5f;
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &memory;
    ok(msap_create(&config, &world));
    for (i = 0; i <= LAST; i++) {
        float x = (float)(3 * (i % 100)), y = (float)(3 * (i / 100));
        if (i == BEFORE)
            commit(world, 0, 0, 0);
        add(world, box_of(x, y, 0, x + 1, y + 1, 1));
    }
    commit(world, 0, 0, 0);
    memory.fail_all = 1;
    for (frame = 1; frame < 40; frame++) { /* within its skin */
        update(world, 1, box_of(frame % 2 ? 0.25f : 0, 0, 0, 1, 1, 1));
        commit(world, 0, 0, 0);
        compared_all += stats_of(world).touched >= LAST;
    }
    ck_assert_int_gt(compared_all, 0);
    ck_assert_int_lt(compared_all, frame - 1);
    memory.fail_all = 0;
    update(world, 1, box_of(0, 0, 0, 3, 1, 1)); /* touches the next one */
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
    ck_assert(memory.bytes == 0 && memory.wrong == 0);
}
END_TEST

/* By removals and by motion, down to none, with an allocator that gives nothing. */
START_TEST(losing_pairs_needs_no_memory)
{
    msap_config config = config_of(3, _i);
    msap_handle h[120];
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 120; i++) {
        box bounds = cube(0, (float)(i % 7));
        right(session_add(&s, &bounds, 0, &h[i]));
    }
    right(session_commit(&s));
    s.memory.fail_all = 1;
    for (i = 0; i < 40; i++) { /* a third moves off, in a row */
        box apart = bar((float)(10 + 2 * i), (float)(11 + 2 * i));
        right(session_update(&s, h[i], &apart));
    }
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 80 * 79 / 2);
    right(session_remove(&s, h[40]));
    right(session_commit(&s));
    for (i = 41; i < 80; i++)
        right(session_remove(&s, h[i]));
    right(session_commit(&s));
    for (i = 80; i < 120; i++) { /* the rest jumps, past the row */
        box apart = bar((float)(1000 - 2 * i), (float)(1001 - 2 * i));
        right(session_update(&s, h[i], &apart));
    }
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 0);
    s.memory.fail_all = 0;
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* The same after a trim, and after a commit that failed. */
START_TEST(losing_pairs_needs_no_memory_at_any_time)
{
    msap_config config = config_of(3, _i);
    box unit = cube(0, 1), far = cube(8, 9);
    msap_handle h[60];
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 60; i++)
        right(session_add(&s, i < 50 ? &unit : &far, 0, &h[i]));
    right(session_commit(&s));
    right(session_trim(&s));
    s.memory.fail_all = 1;
    for (i = 0; i < 10; i++)
        right(session_update(&s, h[i], &far)); /* to ten others: new pairs, for which there is no room */
    for (i = 10; i < 60; i += 2)
        right(session_remove(&s, h[i]));
    refused(msap_commit(s.world, NULL, NULL), MSAP_ERROR_MEMORY);
    right(session_compare(&s));
    for (i = 0; i < 10; i++)
        right(session_update(&s, h[i], &unit)); /* and back: now it only loses */
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 30 * 29 / 2 + 5 * 4 / 2);
    right(session_remove(&s, h[0]));
    right(session_commit(&s));
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* All pairs at once, each parting on all axes, so that it is met three times; after a
 * trim, so that there is no room to spare. */
START_TEST(losing_all_pairs_needs_no_memory)
{
    msap_config config = config_of(3, _i);
    box unit = cube(0, 1);
    msap_handle h[40];
    session s;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 40; i++)
        right(session_add(&s, &unit, 0, &h[i]));
    right(session_commit(&s));
    right(session_trim(&s));
    s.memory.fail_all = 1;
    for (i = 0; i < 40; i++) {
        box apart = cube((float)(10 * (i - 20)), (float)(10 * (i - 20) + 1));
        right(session_update(&s, h[i], &apart));
    }
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.event_count, 40 * 39 / 2);
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

/* The most of what a commit had so far. */
typedef struct most {
    size_t boxes, in_commit, pairs, created, deleted;
} most;

/* Whether one of them is passed; takes note of it. */
static int passes(most *m, const most *now)
{
    most before = *m;
    m->boxes = now->boxes > before.boxes ? now->boxes : before.boxes;
    m->in_commit = now->in_commit > before.in_commit ? now->in_commit : before.in_commit;
    m->pairs = now->pairs > before.pairs ? now->pairs : before.pairs;
    m->created = now->created > before.created ? now->created : before.created;
    m->deleted = now->deleted > before.deleted ? now->deleted : before.deleted;
    return memcmp(m, &before, sizeof before) != 0;
}

/* Random frames: a commit of a single SAP that passes no earlier maximum of boxes (with
 * those that are removed by it), pairs or events of a kind asks for nothing. */
START_TEST(a_commit_that_passes_no_maximum_asks_for_nothing)
{
    msap_config config = config_of(3, _i);
    session s;
    most m = {0};
    int frame, warm = 0;
    if (config.grid != MSAP_GRID_NONE)
        return;
    right(session_open(&s, &config, (uint64_t)_i + 1, SCENE_GRID));
    for (frame = 0; frame < 300; frame++) {
        msap_counts counts = {sizeof counts, 0, 0, 0, 0};
        most now = {0};
        size_t calls;
        right(session_change(&s, 40));
        now.boxes = s.reference.live;
        now.in_commit = s.reference.live + s.reference.removed_count;
        calls = s.memory.calls;
        ok(msap_commit(s.world, NULL, &counts));
        reference_commit(&s.reference);
        now.pairs = counts.active;
        now.created = counts.created;
        now.deleted = counts.deleted;
        if (!passes(&m, &now)) {
            ck_assert_uint_eq(s.memory.calls, calls);
            warm++;
        }
    }
    ck_assert_int_gt(warm, 200);
    right(session_close(&s));
}
END_TEST

/* Calls of a scene's round again and again: how many there are before one that asks for
 * nothing in any of its calls, nor do the five after it. */
static int rounds_until_quiet(session *s, void (*play)(session *s, msap_handle *h), msap_handle *h)
{
    enum { MOST = 100 };
    int rounds = 0, quiet = 0;
    while (quiet < 6 && rounds < MOST) {
        size_t calls = s->memory.calls;
        play(s, h);
        rounds++;
        quiet = s->memory.calls == calls ? quiet + 1 : 0;
    }
    return rounds - quiet;
}

/* Ten pairs, five of which change partners: five go and five come. */
static void change_partners(session *s, msap_handle *h)
{
    int i, round = (int)s->reference.commits;
    for (i = 0; i < 5; i++) {
        int place = 2 * ((i + round) % 5);
        box b = bar((float)place, (float)(place + 1));
        right(session_update(s, h[i], &b));
    }
    right(session_commit(s));
    ck_assert_uint_eq(s->reference.event_count, 10);
    ck_assert_uint_eq(s->reference.pair_count, 10);
}

START_TEST(as_many_pairs_come_as_go)
{
    msap_config config = config_of(3, _i);
    msap_handle h[20];
    session s;
    int i, rounds;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 20; i++) {
        box place = bar((float)(2 * (i % 10)), (float)(2 * (i % 10) + 1));
        right(session_add(&s, &place, 0, &h[i]));
    }
    right(session_commit(&s));
    rounds = rounds_until_quiet(&s, change_partners, h);
    ck_assert_int_le(rounds, config.grid == MSAP_GRID_NONE ? 1 : 50); /* no deletion was before the first */
    right(session_close(&s));
}
END_TEST

static void come_move_and_go(session *s, msap_handle *h)
{
    uint64_t random = 7;
    int frame, i;
    for (frame = 0; frame < 20; frame++) {
        for (i = 0; i < 60; i++) {
            box b = random_box(&random, SCENE_GRID);
            if (frame == 0)
                right(session_add(s, &b, 0, &h[i]));
            else if ((i + frame) % 3 == 0)
                right(session_update(s, h[i], &b));
        }
        right(session_commit(s));
    }
    for (i = 0; i < 60; i++)
        right(session_remove(s, h[i]));
    right(session_commit(s));
}

/* A scene that repeats itself asks for nothing the second time, in no call; a grid, which
 * learns, after a while. */
START_TEST(a_scene_that_repeats_itself_asks_for_nothing)
{
    msap_config config = config_of(3, _i);
    msap_handle h[60] = {0};
    session s;
    int rounds;
    right(session_open(&s, &config, 1, SCENE_GRID));
    rounds = rounds_until_quiet(&s, come_move_and_go, h);
    ck_assert_int_le(rounds, config.grid == MSAP_GRID_NONE ? 1 : 50);
    right(session_close(&s));
}
END_TEST

/* --------------------------------------------------------------------- trim */

START_TEST(trim_gives_memory_back)
{
    msap_config config = config_of(3, _i);
    const msap_pair *pairs;
    msap_handle h[500];
    session s;
    size_t full, count;
    int i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < 500; i++) {
        box b = random_box(&s.random, SCENE_GRID);
        right(session_add(&s, &b, 0, &h[i]));
    }
    right(session_commit(&s));
    full = s.memory.bytes;
    for (i = 10; i < 500; i++)
        right(session_remove(&s, h[i]));
    right(session_commit(&s));
    right(session_trim(&s));
    ck_assert_uint_lt(s.memory.bytes, full);
    right(session_compare(&s));
    ok(msap_created(s.world, &pairs, &count));
    ck_assert_uint_eq(count, 0);
    ok(msap_deleted(s.world, &pairs, &count));
    ck_assert_uint_eq(count, 0);
    for (i = 0; i < 20; i++) /* and life goes on */
        right(session_step(&s, 100));
    right(session_close(&s));
}
END_TEST

/* With changes pending, and after each frame. */
START_TEST(trim_at_any_time)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    right(session_open(&s, &config, 11, SCENE_GRID));
    right(session_trim(&s));
    for (frame = 0; frame < 60; frame++) {
        right(session_change(&s, 40));
        right(session_trim(&s));
        right(session_compare(&s));
        right(session_commit(&s));
        right(session_trim(&s));
        right(session_compare(&s));
    }
    right(session_close(&s));
}
END_TEST

/* ------------------------------------------------------- nothing is left */

static uint64_t bytes_of_empty_world(int row)
{
    msap_world *world = new_world(3, row);
    uint64_t bytes;
    commit(world, 0, 0, 0);
    bytes = stats_of(world).bytes;
    ok(msap_destroy(world));
    return bytes;
}

enum { CROWD = 2000 };

/* A crowd came, moved, jumped and is gone, but for so many. */
static msap_world *deserted_world(int row, int left)
{
    static msap_handle handles[CROWD];
    msap_world *world = new_world(3, row);
    uint64_t random = 8;
    int i, frame;
    for (i = 0; i < CROWD; i++)
        handles[i] = add(world, random_box(&random, SCENE_SIZES));
    for (frame = 0; frame < 3; frame++) {
        ok(msap_commit(world, NULL, NULL));
        for (i = frame; i < CROWD; i += 3)
            update(world, handles[i], random_box(&random, SCENE_SIZES));
    }
    ok(msap_commit(world, NULL, NULL));
    ok(msap_remove_many(world, (size_t)(CROWD - left), handles + left));
    ok(msap_commit(world, NULL, NULL));
    return world;
}

/* After a trim, a world that has been emptied holds hardly more than one that never held
 * a box. */
START_TEST(an_emptied_world_holds_little_after_a_trim)
{
    msap_world *world = deserted_world(_i, 0);
    uint64_t empty = bytes_of_empty_world(_i);
    ck_assert_uint_gt(stats_of(world).bytes, 1024 * 1024);
    ok(msap_trim(world));
    ck_assert_uint_le(stats_of(world).bytes, empty + 8192);
    commit(world, 0, 0, 0);
    add(world, cube(0, 1)); /* it can be used again */
    add(world, cube(1, 2));
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

/* Or after a long time, by itself, also when a little is left and goes on. */
START_TEST(an_emptied_world_holds_little_after_a_while)
{
    msap_world *world = deserted_world(_i, 0);
    uint64_t empty = bytes_of_empty_world(_i);
    int i;
    for (i = 0; i < 300; i++)
        commit(world, 0, 0, 0);
    ck_assert_uint_le(stats_of(world).bytes, empty + 8192);
    ok(msap_destroy(world));
    world = deserted_world(_i, 5);
    for (i = 0; i < 300; i++) {
        update(world, 1, cube((float)i, (float)(i + 1)));
        ok(msap_commit(world, NULL, NULL));
    }
    ck_assert_uint_le(stats_of(world).bytes, empty + 160 * 1024); /* as a grid of few boxes does */
    ok(msap_destroy(world));
}
END_TEST

/* Not while there are events, which a trim would lose: it waits for a quiet commit. */
START_TEST(an_emptied_world_keeps_its_events)
{
    msap_world *world = deserted_world(_i, 5);
    const msap_pair *pairs;
    size_t created, deleted, held;
    int i;
    for (i = 0; i < 300; i++) {
        update(world, 1, i % 2 ? cube(-900, -899) : cube(-2000, 2000));
        ok(msap_commit(world, NULL, NULL));
        ok(msap_created(world, &pairs, &created));
        ok(msap_deleted(world, &pairs, &deleted));
        ck_assert_uint_ge(created + deleted, i ? 1 : 0);
    }
    held = stats_of(world).bytes;
    ok(msap_commit(world, NULL, NULL));
    ck_assert_uint_lt(stats_of(world).bytes, held);
    ok(msap_destroy(world));
}
END_TEST

/* Emptied and filled again many times: it never holds more than after some times. */
START_TEST(a_world_that_is_emptied_again_and_again)
{
    msap_config config = config_of(3, _i);
    msap_handle handles[400];
    uint64_t first = 0;
    session s;
    int round, frame, i;
    right(session_open(&s, &config, 1, SCENE_SIZES));
    for (round = 0; round < 24; round++) {
        uint64_t random = 5;
        for (i = 0; i < 400; i++) {
            box b = random_box(&random, SCENE_SIZES);
            right(session_add(&s, &b, 0, &handles[i]));
        }
        for (frame = 0; frame < 6; frame++) {
            right(session_commit(&s));
            for (i = frame % 3; i < 400; i += 3) {
                box b = random_box(&random, SCENE_SIZES);
                right(session_update(&s, handles[i], &b));
            }
        }
        for (i = 0; i < 400; i++)
            right(session_remove(&s, handles[i]));
        right(session_commit(&s));
        if (round == 11)
            first = s.memory.peak;
    }
    ck_assert_uint_le(s.memory.peak, first + first / 10);
    right(session_close(&s));
}
END_TEST

/* ----------------------------------------------------------------- balanced */

/* Whatever is pending, destroy gives everything back. */
START_TEST(destroy_with_changes_pending)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    for (frame = 0; frame < 10; frame++) {
        int i;
        right(session_open(&s, &config, (uint64_t)frame, SCENE_GRID));
        for (i = 0; i < frame; i++)
            right(session_step(&s, 30));
        right(session_change(&s, 30));
        right(session_close(&s));
    }
}
END_TEST

/* Two worlds keep apart what is whose. */
START_TEST(each_world_has_its_own_allocator)
{
    msap_config config = config_of(3, _i);
    session a, b;
    size_t bytes;
    right(session_open(&a, &config, 1, SCENE_GRID));
    right(session_open(&b, &config, 2, SCENE_GRID));
    right(session_step(&a, 50));
    bytes = a.memory.bytes;
    right(session_step(&b, 50));
    ck_assert_uint_eq(a.memory.bytes, bytes);
    right(session_close(&b));
    right(session_step(&a, 50));
    right(session_close(&a));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("memory");
    tcase_add_loop_test(tests, any_allocation_of_a_scenario_may_fail, 0, SETUPS);
    tcase_add_loop_test(tests, any_allocation_may_fail_with_workers, 0, SETUPS);
    tcase_add_test(tests, create_may_fail);
    tcase_add_loop_test(tests, without_memory, 0, SETUPS);
    tcase_add_loop_test(tests, a_failed_commit_is_as_if_it_had_not_been, 0, SETUPS);
    tcase_add_loop_test(tests, a_jump_into_pairs_without_memory, 0, SETUPS);
    tcase_add_loop_test(tests, other_cells_need_memory_and_events_do_not, 0, 2);
    tcase_add_loop_test(tests, losing_pairs_needs_no_memory, 0, SETUPS);
    tcase_add_loop_test(tests, losing_pairs_needs_no_memory_at_any_time, 0, SETUPS);
    tcase_add_loop_test(tests, losing_all_pairs_needs_no_memory, 0, SETUPS);
    tcase_add_loop_test(tests, a_commit_that_passes_no_maximum_asks_for_nothing, 0, SETUPS);
    tcase_add_loop_test(tests, as_many_pairs_come_as_go, 0, SETUPS);
    tcase_add_loop_test(tests, a_scene_that_repeats_itself_asks_for_nothing, 0, SETUPS);
    tcase_add_loop_test(tests, trim_gives_memory_back, 0, SETUPS);
    tcase_add_loop_test(tests, trim_at_any_time, 0, SETUPS);
    tcase_add_loop_test(tests, an_emptied_world_holds_little_after_a_trim, 0, SETUPS);
    tcase_add_loop_test(tests, an_emptied_world_holds_little_after_a_while, 0, SETUPS);
    tcase_add_loop_test(tests, an_emptied_world_keeps_its_events, 0, SETUPS);
    tcase_add_loop_test(tests, a_world_that_is_emptied_again_and_again, 0, SETUPS);
    tcase_add_loop_test(tests, destroy_with_changes_pending, 0, SETUPS);
    tcase_add_loop_test(tests, each_world_has_its_own_allocator, 0, SETUPS);
    return run_case(tests, "memory");
}
