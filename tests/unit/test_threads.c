/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: different worlds may be used by different threads at once, and one world
 * may be read by many at once, and the worlds may share one pool of threads for their
 * tasks. (To be run under a thread sanitizer; without one it
 * still compares everything with brute force.)
 */
#include <pthread.h>

#include "../../examples/thread_pool.h"
#include "checks.h"

#define THREADS 4

static thread_pool *shared; /* NULL: no workers */

/* A session of its own; returns what was wrong. */
static void *own_world(void *argument)
{
    msap_config config;
    session s;
    const char *wrong;
    int frame, number = *(int *)argument, frames = shared ? 8 : 50;
    msap_config_init(&config, sizeof config);
    config.dims = number % 2 ? 2 : 3;
    config.strategy = (uint32_t)number;
    if (shared) {
        config.workers = 3;
        config.task_grain = 256;
        config.enqueue = thread_pool_enqueue;
        config.finish = thread_pool_finish;
        config.jobs_user = shared;
    }
    wrong = session_open(&s, &config, (uint64_t)number, (scene_kind)(number % SCENE_COUNT));
    for (frame = 0; frame < frames && !wrong; frame++)
        wrong = session_step(&s, shared ? 1200 : 40);
    if (!wrong)
        wrong = session_close(&s);
    return (void *)wrong;
}

/* Reads all there is, again and again. */
static void *reader(void *argument)
{
    const char *wrong = NULL;
    int i;
    for (i = 0; i < 50 && !wrong; i++)
        wrong = session_compare(argument);
    return (void *)wrong;
}

static void run_at_once(void *(*run)(void *), void *const *arguments)
{
    pthread_t threads[THREADS];
    int i;
    for (i = 0; i < THREADS; i++)
        ck_assert_int_eq(pthread_create(&threads[i], NULL, run, arguments[i]), 0);
    for (i = 0; i < THREADS; i++) {
        void *wrong = NULL;
        ck_assert_int_eq(pthread_join(threads[i], &wrong), 0);
        right(wrong);
    }
}

static void run_worlds_at_once(void)
{
    int numbers[THREADS], i;
    void *arguments[THREADS];
    for (i = 0; i < THREADS; i++) {
        numbers[i] = i;
        arguments[i] = &numbers[i];
    }
    run_at_once(own_world, arguments);
}

START_TEST(different_worlds_at_once)
{
    run_worlds_at_once();
}
END_TEST

START_TEST(different_worlds_with_one_pool)
{
    shared = thread_pool_create(2);
    ck_assert_ptr_nonnull(shared);
    run_worlds_at_once();
    thread_pool_destroy(shared);
}
END_TEST

START_TEST(readers_at_once)
{
    msap_config config = config_of(3, _i);
    session s;
    void *arguments[THREADS];
    int frame, i;
    right(session_open(&s, &config, 1, SCENE_GRID));
    for (i = 0; i < THREADS; i++)
        arguments[i] = &s;
    for (frame = 0; frame < 10; frame++) {
        right(session_step(&s, 60));
        run_at_once(reader, arguments);
        right(session_change(&s, 60));
        run_at_once(reader, arguments);
    }
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("threads");
    tcase_add_test(tests, different_worlds_at_once);
    tcase_add_test(tests, different_worlds_with_one_pool);
    tcase_add_loop_test(tests, readers_at_once, DEFAULT, SINGLE_SAP + 1);
    return run_case(tests, "threads");
}
