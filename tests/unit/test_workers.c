/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: work that is cut into tasks comes to the same. With any number of workers,
 * and wherever and whenever the host runs the tasks, handles, events and arrays are
 * those of one thread; every task has been waited for when a call returns; no task
 * asks the allocator for anything. (To be run under a thread sanitizer, too.)
 */
#include <pthread.h>
#include <string.h>

#include "checks.h"

#define BOXES 9000 /* enough for 16 tasks over the boxes */
#define WORLDS 9
#define SMALL_GRAIN 256

/* The same boxes in several worlds. The first has one worker. */
typedef struct choir {
    session s[WORLDS]; /* without their references */
    box bounds[BOXES];
    msap_handle handles[BOXES];
    uint64_t random;
} choir;

static const struct {
    uint32_t workers;
    job_system jobs;
} hosts[WORLDS] = {
    {1, JOBS_NONE},    {2, JOBS_AT_ONCE}, {16, JOBS_AT_ONCE}, {3, JOBS_LATE}, {64, JOBS_LATE},
    {2, JOBS_POOL},    {4, JOBS_POOL},    {16, JOBS_POOL},    {4, JOBS_THREADS},
};

static choir *choir_open(const msap_config *config, uint32_t grain)
{
    static choir c;
    int w;
    memset(&c, 0, sizeof c);
    for (w = 0; w < WORLDS; w++) {
        msap_config own = *config;
        if (hosts[w].jobs != JOBS_NONE)
            use_jobs(&own, hosts[w].workers, hosts[w].jobs);
        own.task_grain = grain;
        right(session_open(&c.s[w], &own, 0, SCENE_GRID));
    }
    c.random = 11;
    return &c;
}

static void choir_close(choir *c)
{
    int w;
    for (w = 0; w < WORLDS; w++)
        right(session_close(&c->s[w])); /* says so if the allocator was called elsewhere */
    ck_assert_uint_eq(jobs_enqueued, jobs_finished);
}

/* Boxes [first, end) come; the handles must be the same in all worlds. */
static void choir_add(choir *c, int first, int end, uint32_t flag)
{
    static msap_handle handles[BOXES];
    static uint32_t flags[BOXES];
    msap_boxes boxes = boxes_in_row(&c->bounds[first]);
    size_t k = (size_t)(end - first), i;
    int w;
    for (i = 0; i < k; i++)
        flags[i] = flag;
    for (w = 0; w < WORLDS; w++) {
        ok(msap_add_many(c->s[w].world, k, &boxes, flags, NULL, w ? handles : &c->handles[first]));
        ck_assert(!w || memcmp(handles, &c->handles[first], k * sizeof *handles) == 0);
    }
}

static void choir_update(choir *c, int first, int end)
{
    msap_boxes boxes = boxes_in_row(&c->bounds[first]);
    int w;
    for (w = 0; w < WORLDS; w++)
        ok(msap_update_many(c->s[w].world, (size_t)(end - first), &c->handles[first], &boxes));
}

static void choir_remove(choir *c, int first, int end)
{
    int w;
    for (w = 0; w < WORLDS; w++)
        ok(msap_remove_many(c->s[w].world, (size_t)(end - first), &c->handles[first]));
}

typedef msap_status (*read_pairs)(const msap_world *world, const msap_pair **pairs, size_t *count);

static void same_arrays(const msap_world *world, const msap_world *other, read_pairs read)
{
    const msap_pair *pairs, *others;
    size_t count, other_count;
    ok(read(world, &pairs, &count));
    ok(read(other, &others, &other_count));
    ck_assert_uint_eq(count, other_count);
    ck_assert(!count || memcmp(pairs, others, count * sizeof *pairs) == 0);
}

/* Commits, with tasks if `cut`. All arrays must be the same to the byte. */
static void choir_commit(choir *c, int cut)
{
    const char *what = NULL;
    int w;
    for (w = 0; w < WORLDS; w++) {
        size_t enqueued = jobs_enqueued;
        ok(msap_commit(c->s[w].world, NULL, NULL));
        ck_assert_uint_eq(jobs_enqueued, jobs_finished);
        ck_assert_int_eq(jobs_enqueued > enqueued, w && cut);
        same_arrays(c->s[w].world, c->s[0].world, msap_deleted);
        same_arrays(c->s[w].world, c->s[0].world, msap_created);
        same_arrays(c->s[w].world, c->s[0].world, msap_pairs);
        ck_assert_msg(msap_validate(c->s[w].world, &what) == MSAP_OK, "%s", what ? what : "no reason given");
    }
}

/* The pairs of the first world are those of box pruning. */
static void choir_is_right(choir *c, int end)
{
    msap_boxes boxes = boxes_in_row(c->bounds);
    msap_index_pair *found;
    const msap_pair *pairs;
    size_t count, expected;
    ok(msap_prune(NULL, (size_t)end, &boxes, &found, &expected, NULL));
    ok(msap_pairs(c->s[0].world, &pairs, &count));
    ck_assert_uint_eq(count, expected);
    while (expected--)
        ck_assert(is_pair(c->s[0].world, c->handles[found[expected].a], c->handles[found[expected].b]));
    ok(msap_prune_free(NULL, found, count));
}

/* A wide field in which some boxes are large. */
static void choose_bounds(choir *c, int first, int end)
{
    int i, k;
    for (i = first; i < end; i++) {
        float size = i % 50 ? 1 : 15;
        for (k = 0; k < 3; k++) {
            c->bounds[i].min[k] = (float)random_below(&c->random, k == 2 ? 16 : 400);
            c->bounds[i].max[k] = c->bounds[i].min[k] + size;
        }
    }
}

static void step_aside(choir *c, int first, int end, float step)
{
    int i;
    for (i = first; i < end; i++) {
        c->bounds[i].min[i % 2] += step;
        c->bounds[i].max[i % 2] += step;
    }
}

/* ------------------------------------------------------------- large scenes */

static msap_config config_for(int set_up)
{
    static const struct {
        uint32_t grid, strategy;
        float margin;
    } config[] = {
        {MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO}, {MSAP_GRID_AUTO, MSAP_STRATEGY_SLIDE, MSAP_MARGIN_AUTO},
        {MSAP_GRID_AUTO, MSAP_STRATEGY_MERGE, 0},               {MSAP_GRID_AUTO, MSAP_STRATEGY_SWEEP, 0.5f},
        {MSAP_GRID_FIXED, MSAP_STRATEGY_AUTO, 0},
    };
    static const uint32_t cells[] = {30, 27, 2};
    msap_config result = config_of(3, DEFAULT);
    int k;
    result.grid = config[set_up].grid;
    result.strategy = config[set_up].strategy;
    result.margin = config[set_up].margin;
    for (k = 0; k < 3 && result.grid == MSAP_GRID_FIXED; k++) {
        result.grid_cells[k] = cells[k];
        result.grid_max[k] = k == 2 ? 16 : 400;
    }
    return result;
}
#define CONFIGS 5

/* All come, all move a little, some jump, all jump, half goes, others come. */
START_TEST(workers_come_to_the_same)
{
    msap_config config = config_for(_i);
    choir *c = choir_open(&config, SMALL_GRAIN);
    int frame;
    choose_bounds(c, 0, BOXES);
    choir_add(c, 0, BOXES, 0);
    choir_commit(c, 1);
    choir_is_right(c, BOXES);
    for (frame = 0; frame < 6; frame++) {
        step_aside(c, 0, BOXES, 0.125f);
        choir_update(c, 0, BOXES);
        choir_commit(c, 1);
    }
    choir_is_right(c, BOXES);
    choose_bounds(c, 1000, 3000);
    choir_update(c, 1000, 3000);
    choir_commit(c, 1);
    for (frame = 0; frame < 3; frame++) {
        choose_bounds(c, 0, BOXES);
        choir_update(c, 0, BOXES);
        choir_commit(c, 1);
    }
    choir_is_right(c, BOXES);
    choir_remove(c, BOXES / 2, BOXES);
    choir_commit(c, 1);
    choir_is_right(c, BOXES / 2);
    choose_bounds(c, BOXES / 2, BOXES);
    choir_add(c, BOXES / 2, BOXES, 0);
    choir_commit(c, 1);
    choir_is_right(c, BOXES);
    choir_close(c);
}
END_TEST

/* Most boxes come when the cells have been chosen for the others, which are in those when all move. */
START_TEST(workers_move_boxes_of_an_old_layout)
{
    msap_config config = config_for(_i);
    choir *c = choir_open(&config, SMALL_GRAIN);
    choose_bounds(c, 0, BOXES);
    choir_add(c, 0, BOXES / 4, 0);
    choir_commit(c, 1);
    choir_add(c, BOXES / 4, BOXES, 0);
    choir_commit(c, 1);
    for (int frame = 0; frame < 3; frame++) {
        step_aside(c, 0, BOXES, 0.5f);
        choir_update(c, 0, BOXES);
        choir_commit(c, 1);
    }
    choir_is_right(c, BOXES);
    choir_close(c);
}
END_TEST

/* A crowd in a long tunnel along each axis: boxes with some 60 neighbours, more of whom come and go
 * in each commit than a worker has room for; one in five is static. What workers are lent comes
 * back: a world does not grow on and on. */
START_TEST(workers_move_a_crowd)
{
    enum { CROWD = 1500, LENGTH = 48, FRAMES = 12 };
    uint64_t bytes[WORLDS];
    const msap_config config = config_for(_i % 2 ? 2 : 0); /* by default; by merging, without a margin */
    choir *c = choir_open(&config, SMALL_GRAIN);
    int along = _i / 2, i, k, w, frame;
    for (i = 0; i < CROWD; i++)
        for (k = 0; k < 3; k++) {
            c->bounds[i].min[k] = (float)random_below(&c->random, k == along ? 16 * LENGTH : 32) / 16;
            c->bounds[i].max[k] = c->bounds[i].min[k] + 1;
        }
    choir_add(c, 0, CROWD / 5, MSAP_STATIC);
    choir_add(c, CROWD / 5, CROWD, 0);
    choir_commit(c, 1);
    for (frame = 0; frame < FRAMES; frame++) {
        for (w = 0; w < WORLDS && frame == FRAMES / 2; w++)
            bytes[w] = stats_of(c->s[w].world).bytes;
        for (i = frame % 2 ? CROWD / 5 : 0; i < CROWD; i++) {
            float step = (float)random_below(&c->random, 64) / 16 - 2;
            c->bounds[i].min[along] += step;
            c->bounds[i].max[along] += step;
        }
        choir_update(c, 0, CROWD);
        choir_commit(c, 1);
    }
    for (w = 0; w < WORLDS; w++)
        ck_assert_uint_le(stats_of(c->s[w].world).bytes, bytes[w] + bytes[w] / 8);
    choir_close(c);
}
END_TEST

/* Many pairs of few boxes: what the workers find is much more than what they have room
 * for. And all of it goes at once. */
START_TEST(workers_find_more_than_they_have_room_for)
{
    msap_config config = config_for(_i);
    choir *c = choir_open(&config, SMALL_GRAIN);
    int i, round;
    for (i = 0; i < 560; i++)
        c->bounds[i] = cube((float)(i / 140), (float)(i / 140) + 0.5f); /* four heaps */
    choir_add(c, 0, 560, 0);
    choir_commit(c, 1);
    ck_assert_uint_eq(stats_of(c->s[0].world).pairs, 4 * 140 * 139 / 2);
    for (round = 0; round < 2; round++) {
        step_aside(c, 0, 420, round ? -100 : 100); /* one half of each goes along x, the other along y */
        choir_update(c, 0, 420);
        choir_commit(c, 1);
        choir_is_right(c, 560);
    }
    choir_remove(c, 0, 560);
    choir_commit(c, 1);
    ck_assert_uint_eq(stats_of(c->s[0].world).pairs, 0);
    choir_close(c);
}
END_TEST

/* A thousand half-spaces that every other box asks for. */
START_TEST(workers_ask_for_giants)
{
    const float infinity = float_of(0x7F800000);
    msap_config config = config_for(_i);
    choir *c = choir_open(&config, SMALL_GRAIN);
    int i, frame;
    choose_bounds(c, 0, 1600);
    for (i = 0; i < 1000; i++)
        c->bounds[i] = i % 2 ? box_of((float)(4 * i), -infinity, -infinity, infinity, infinity, infinity)
                             : box_of(-infinity, -infinity, -infinity, infinity, (float)(400 - 4 * i), infinity);
    choir_add(c, 1000, 1600, 0);
    choir_commit(c, 1);
    choir_add(c, 0, 1000, MSAP_STATIC);
    choir_commit(c, 1);
    for (frame = 0; frame < 2; frame++) {
        choose_bounds(c, 1000, 1600);
        choir_update(c, 1000, 1600);
        choir_commit(c, 1);
    }
    choir_close(c);
}
END_TEST

/* ------------------------------------------------------------------ updates */

/* A batch that is refused, by all worlds for the same reason. */
static void choir_refuses(choir *c, const msap_handle *handles, msap_status status, uint64_t index,
                          msap_bound bound)
{
    msap_boxes boxes = boxes_in_row(c->bounds);
    int w;
    for (w = 0; w < WORLDS; w++) {
        ck_assert_int_eq(msap_update_many(c->s[w].world, BOXES, handles, &boxes), status);
        last_error(c->s[w].world, status, index, bound);
    }
}

/* Nothing of a batch remains if a bound or a handle is not as it should be. */
START_TEST(workers_undo_what_is_refused)
{
    static msap_handle handles[BOXES];
    msap_config config = config_for(0);
    choir *c = choir_open(&config, SMALL_GRAIN);
    choose_bounds(c, 0, BOXES);
    choir_add(c, 0, BOXES, 0);
    choir_commit(c, 1);
    memcpy(handles, c->handles, sizeof handles);
    choose_bounds(c, 0, BOXES);
    handles[4000] = (msap_handle)BOXES << 32 | 1; /* no slot at all */
    choir_refuses(c, handles, MSAP_ERROR_HANDLE, 4000, MSAP_NO_BOUND);
    handles[4000] = c->handles[4000] + 1; /* of another box in its slot */
    choir_refuses(c, handles, MSAP_ERROR_HANDLE, 4000, MSAP_NO_BOUND);
    c->bounds[BOXES - 1].min[1] = c->bounds[BOXES - 1].max[1] + 1;
    c->bounds[BOXES / 2].max[2] = float_of(0x7FC00000);
    choir_refuses(c, c->handles, MSAP_ERROR_NAN, BOXES / 2, MSAP_MAX_Z);
    c->bounds[BOXES / 2].max[2] = c->bounds[BOXES / 2].min[2];
    choir_refuses(c, c->handles, MSAP_ERROR_INVERTED, BOXES - 1, MSAP_MIN_Y);
    choir_commit(c, 0); /* nothing has changed */
    choir_close(c);
}
END_TEST

/* Boxes in any order, some twice, some not; again before the commit; and as doubles. */
START_TEST(workers_update_in_any_order)
{
    static msap_handle handles[BOXES];
    static double doubles[BOXES][6];
    const msap_boxes in_doubles = {sizeof in_doubles, MSAP_DOUBLE, NULL, NULL, 48, 8, 48, 8};
    msap_config config = config_for(0);
    choir *c = choir_open(&config, SMALL_GRAIN);
    int way, w, i, k;
    choose_bounds(c, 0, BOXES);
    choir_add(c, 0, BOXES, 0);
    choir_commit(c, 1);
    for (way = 0; way < 4; way++) {
        msap_boxes boxes = boxes_in_row(c->bounds);
        choose_bounds(c, 0, BOXES);
        for (i = 0; i < BOXES; i++) {
            handles[i] = c->handles[way == 0 ? BOXES - 1 - i : way == 1 ? i * 7 % BOXES : i];
            for (k = 0; k < 3; k++) {
                doubles[i][k] = c->bounds[i].min[k];
                doubles[i][k + 3] = c->bounds[i].max[k];
            }
        }
        handles[BOXES - 1] = handles[way == 1 ? 20 : BOXES - 1];
        if (way == 2)
            choir_update(c, BOXES / 2, BOXES);
        if (way == 3) {
            boxes = in_doubles;
            boxes.min = doubles[0];
            boxes.max = doubles[0] + 3;
        }
        for (w = 0; w < WORLDS; w++)
            ok(msap_update_many(c->s[w].world, BOXES, handles, &boxes));
        choir_commit(c, 1);
    }
    choir_close(c);
}
END_TEST

/* ------------------------------------------------------------- small scenes */

/* What is too little for a task is done without one: by default, the commits of a few
 * hundred boxes. */
START_TEST(little_work_is_not_cut)
{
    msap_config config = config_for(_i);
    choir *c = choir_open(&config, 0);
    choose_bounds(c, 0, 500);
    choir_add(c, 0, 500, 0);
    choir_commit(c, 0);
    step_aside(c, 0, 500, 1);
    choir_update(c, 0, 500);
    choir_commit(c, 0);
    choose_bounds(c, 0, 500);
    choir_update(c, 0, 500);
    choir_commit(c, 0);
    choir_is_right(c, 500);
    choir_close(c);
}
END_TEST

/* A single SAP has tasks, too: the pairs that a sweep looks at once more. */
START_TEST(a_single_sap_with_workers)
{
    msap_config config = config_of(3, SINGLE_SAP);
    choir *c;
    int i, round;
    config.strategy = MSAP_STRATEGY_SWEEP;
    c = choir_open(&config, SMALL_GRAIN);
    for (i = 0; i < 200; i++)
        c->bounds[i] = cube((float)(i % 5), (float)(i % 5 + 1));
    choir_add(c, 0, 200, 0);
    choir_commit(c, 0); /* no pairs yet */
    for (round = 0; round < 3; round++) {
        step_aside(c, 0, 100, 3);
        choir_update(c, 0, 200);
        choir_commit(c, 1);
        choir_is_right(c, 200);
    }
    choir_close(c);
}
END_TEST

/* ------------------------------------------------------------ who calls what */

static pthread_t caller;
static int is_committing;

/* Hands the task to the threads of the set-up, but looks at who gives it and when. */
static msap_config inner;

static void *watched_enqueue(void *user, msap_task_fn run, void *task)
{
    ck_assert_ptr_eq(user, &caller);
    ck_assert(is_committing && pthread_equal(pthread_self(), caller));
    return inner.enqueue(inner.jobs_user, run, task);
}

static void watched_finish(void *user, void *ticket)
{
    ck_assert_ptr_eq(user, &caller);
    ck_assert_ptr_nonnull(ticket);
    ck_assert(is_committing && pthread_equal(pthread_self(), caller));
    inner.finish(inner.jobs_user, ticket);
}

static void watched_commit(session *s)
{
    is_committing = 1;
    right(session_commit(s));
    is_committing = 0;
    ck_assert_uint_eq(jobs_enqueued, jobs_finished);
}

/* The hooks are called on the thread that commits, not from updates of a box, with the host's
 * pointer; and the allocator on that thread only, which the session checks. */
START_TEST(hooks_and_allocator_are_called_by_the_caller)
{
    msap_config config = config_of(3, DEFAULT);
    session s;
    int frame;
    config.strategy = (uint32_t)_i;
    inner = config;
    use_jobs(&inner, 4, JOBS_THREADS);
    config.workers = 4;
    config.task_grain = inner.task_grain;
    config.enqueue = watched_enqueue;
    config.finish = watched_finish;
    config.jobs_user = &caller;
    caller = pthread_self();
    right(session_open(&s, &config, 3, SCENE_SPREAD));
    for (frame = 0; frame < 12; frame++) {
        right(session_change(&s, 1500));
        watched_commit(&s);
        right(session_compare(&s));
        if (frame % 4 == 3)
            right(session_trim(&s));
    }
    ck_assert_uint_gt(jobs_enqueued, 0);
    right(session_close(&s));
}
END_TEST

/* No more tasks at once than there are workers, the calling thread being one of them. */
static size_t at_once, most_at_once;

static void *counting_enqueue(void *user, msap_task_fn run, void *task)
{
    (void)user;
    if (++at_once > most_at_once)
        most_at_once = at_once;
    run(task);
    return user;
}

static void counting_finish(void *user, void *ticket)
{
    ck_assert_ptr_eq(user, ticket);
    at_once--;
}

/* Into how many tasks a commit cut any part of its work at most: one in which so many boxes
 * come or, if `come` is 0, are updated to where they were. */
static size_t most_tasks(msap_world *world, msap_handle *handles, int boxes, int come)
{
    int n;
    most_at_once = 0;
    for (n = 0; n < boxes; n++) {
        box b = bar((float)(2 * n), (float)(2 * n + 1));
        if (come)
            handles[n] = add(world, b);
        else
            update(world, handles[n], b);
    }
    ok(msap_commit(world, NULL, NULL));
    ck_assert_uint_eq(at_once, 0);
    return most_at_once + 1;
}

static msap_world *counted_world(uint32_t workers, uint32_t grain, uint32_t strategy)
{
    msap_config config = config_of(3, DEFAULT);
    msap_world *world;
    config.workers = workers;
    config.task_grain = grain;
    config.strategy = strategy;
    config.enqueue = counting_enqueue;
    config.finish = counting_finish;
    config.jobs_user = &at_once;
    ok(msap_create(&config, &world));
    return world;
}

static msap_handle counted[20000];

START_TEST(so_many_tasks_as_workers)
{
    static const uint32_t workers[] = {1, 2, 5, 16, 64};
    size_t i;
    for (i = 0; i < COUNT(workers); i++) {
        msap_world *world = counted_world(workers[i], 512, MSAP_STRATEGY_AUTO);
        ck_assert_uint_eq(most_tasks(world, counted, 20000, 1), workers[i]);
        ok(msap_destroy(world));
    }
}
END_TEST

/* Where all boxes are updated and stay in their skins, once these suit them, the list of each is gone through, and
 * that is all. */
START_TEST(so_many_tasks_as_are_worth_it)
{
    static const struct {
        uint32_t grain;
        int boxes;
        size_t tasks;
    } cases[] = {
        {0, 20000, 1},   {16384, 20000, 1}, {10001, 20000, 1}, {10000, 20000, 2}, {6667, 20000, 2},
        {1000, 6000, 6}, {1001, 6000, 5},   {1, 3, 2},         {1, 1, 1},         {UINT32_MAX, 20000, 1},
    };
    size_t i;
    int n;
    for (i = 0; i < COUNT(cases); i++) {
        msap_world *world = counted_world(64, cases[i].grain, MSAP_STRATEGY_SLIDE);
        most_tasks(world, counted, cases[i].boxes, 1);
        for (n = 0; n < 8; n++)
            most_tasks(world, counted, cases[i].boxes, 0);
        ck_assert_uint_eq(most_tasks(world, counted, cases[i].boxes, 0), cases[i].tasks);
        ok(msap_destroy(world));
    }
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("workers");
    tcase_add_loop_test(tests, workers_come_to_the_same, 0, CONFIGS);
    tcase_add_loop_test(tests, workers_move_boxes_of_an_old_layout, 0, CONFIGS);
    tcase_add_loop_test(tests, workers_move_a_crowd, 0, 3 * 2);
    tcase_add_test(tests, workers_undo_what_is_refused);
    tcase_add_test(tests, workers_update_in_any_order);
    tcase_add_loop_test(tests, workers_find_more_than_they_have_room_for, 0, CONFIGS);
    tcase_add_loop_test(tests, workers_ask_for_giants, 0, CONFIGS);
    tcase_add_loop_test(tests, little_work_is_not_cut, 0, CONFIGS);
    tcase_add_test(tests, a_single_sap_with_workers);
    tcase_add_loop_test(tests, hooks_and_allocator_are_called_by_the_caller, 0, MSAP_STRATEGY_SWEEP + 1);
    tcase_add_test(tests, so_many_tasks_as_workers);
    tcase_add_test(tests, so_many_tasks_as_are_worth_it);
    return run_case(tests, "workers");
}
