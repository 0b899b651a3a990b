/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * See setups.h.
 */
#include "setups.h"

#include <pthread.h>
#include <stdlib.h>

#include "../../examples/thread_pool.h"

/* ------------------------------------------------------------------ the table */

#define NONE MSAP_GRID_NONE
#define FIXED MSAP_GRID_FIXED
#define SLIDE MSAP_STRATEGY_SLIDE
#define MERGE MSAP_STRATEGY_MERGE
#define SWEEP MSAP_STRATEGY_SWEEP

const setup setups[SETUPS] = {
    {.name = "the default"},
    {.name = "single SAP", .grid = NONE},
    {.name = "single SAP, slide", .grid = NONE, .strategy = SLIDE},
    {.name = "single SAP, merge", .grid = NONE, .strategy = MERGE},
    {.name = "single SAP, sweep", .grid = NONE, .strategy = SWEEP},
    {.name = "single SAP, no filters", .grid = NONE, .no_filters = 1},
    {.name = "single SAP, slide, no filters", .grid = NONE, .strategy = SLIDE, .no_filters = 1},
    {.name = "single SAP, merge, no filters", .grid = NONE, .strategy = MERGE, .no_filters = 1},
    {.name = "single SAP, sweep, no filters", .grid = NONE, .strategy = SWEEP, .no_filters = 1},
    {.name = "slide", .strategy = SLIDE},
    {.name = "merge", .strategy = MERGE},
    {.name = "sweep", .strategy = SWEEP},
    {.name = "margin 0", .margin = NO_MARGIN},
    {.name = "margin 0, slide", .margin = NO_MARGIN, .strategy = SLIDE},
    {.name = "margin 0.1, merge", .margin = 0.1f, .strategy = MERGE},
    {.name = "margin 3", .margin = 3},
    {.name = "margin 3, sweep", .margin = 3, .strategy = SWEEP},
    {.name = "cells of 2", .cell_size = 2},
    {.name = "cells of 1e30", .cell_size = 1e30f, .strategy = MERGE},
    {.name = "4x4", .grid = FIXED, .cells = {4, 4, 1}, .low = -10, .high = 30},
    {.name = "3x5x2", .grid = FIXED, .cells = {3, 5, 2}, .low = -10, .high = 20},
    {.name = "3x5x2, slide", .grid = FIXED, .cells = {3, 5, 2}, .low = -10, .high = 20, .strategy = SLIDE},
    {.name = "7x6x9 within a thousandth, merge", .grid = FIXED, .cells = {7, 6, 9}, .low = 1, .high = 1.001f,
     .margin = NO_MARGIN, .strategy = MERGE},
    {.name = "16x32 within a unit, sweep", .grid = FIXED, .cells = {16, 32, 1}, .high = 1, .strategy = SWEEP},
    {.name = "no vectors", .simd = MSAP_SIMD_NONE},
    {.name = "vectors of 4", .simd = MSAP_SIMD_128},
    {.name = "vectors of 8", .simd = MSAP_SIMD_256},
    {.name = "2 workers at once", .workers = 2, .jobs = JOBS_AT_ONCE},
    {.name = "16 workers at once, sweep", .workers = 16, .jobs = JOBS_AT_ONCE, .strategy = SWEEP},
    {.name = "4 workers late", .workers = 4, .jobs = JOBS_LATE},
    {.name = "4 workers late, merge, margin 0", .workers = 4, .jobs = JOBS_LATE, .strategy = MERGE,
     .margin = NO_MARGIN},
    {.name = "16 workers late, 3x5x2, slide", .workers = 16, .jobs = JOBS_LATE, .strategy = SLIDE, .grid = FIXED,
     .cells = {3, 5, 2}, .low = -10, .high = 20},
    {.name = "4 workers in a pool", .workers = 4, .jobs = JOBS_POOL},
    {.name = "16 workers in a pool, sweep", .workers = 16, .jobs = JOBS_POOL, .strategy = SWEEP},
    {.name = "2 workers in threads, merge", .workers = 2, .jobs = JOBS_THREADS, .strategy = MERGE},
    {.name = "single SAP, sweep, 4 workers in a pool", .grid = NONE, .strategy = SWEEP, .workers = 4,
     .jobs = JOBS_POOL},
};

msap_config setup_config(uint32_t dims, int row)
{
    const setup *from = &setups[row];
    msap_config config;
    uint32_t c;
    msap_config_init(&config, sizeof config);
    config.dims = dims;
    config.grid = from->grid;
    config.strategy = from->strategy;
    config.filters = !from->no_filters;
    config.simd = from->simd;
    if (from->margin != 0)
        config.margin = from->margin == NO_MARGIN ? 0 : from->margin;
    config.cell_size = from->cell_size;
    for (c = 0; c < dims && from->grid == MSAP_GRID_FIXED; c++) {
        config.grid_cells[c] = from->cells[c];
        config.grid_min[c] = from->low;
        config.grid_max[c] = from->high;
    }
    if (from->workers)
        use_jobs(&config, from->workers, from->jobs);
    return config;
}

/* -------------------------------------------------------------------- at once */

size_t jobs_enqueued, jobs_finished;

static void *at_once_enqueue(void *user, msap_task_fn run, void *task)
{
    (void)user;
    jobs_enqueued++;
    run(task);
    jobs_finished++;
    return NULL;
}

/* There is no ticket to finish. */
static void at_once_finish(void *user, void *ticket)
{
    (void)user;
    (void)ticket;
    abort();
}

/* ----------------------------------------------------------------------- late */

enum { MOST_JOBS = 64 };

static struct {
    msap_task_fn run[MOST_JOBS];
    void *task[MOST_JOBS];
    size_t waiting;
} late;

static void *late_enqueue(void *user, msap_task_fn run, void *task)
{
    (void)user;
    if (late.waiting == MOST_JOBS)
        abort();
    jobs_enqueued++;
    late.run[late.waiting] = run;
    late.task[late.waiting++] = task;
    return &late;
}

static void late_finish(void *user, void *ticket)
{
    (void)user;
    if (ticket != &late)
        abort();
    while (late.waiting) {
        late.waiting--;
        late.run[late.waiting](late.task[late.waiting]);
    }
    jobs_finished++;
}

/* ----------------------------------------------------------------------- pool */

static thread_pool *pool;

static void end_pool(void)
{
    thread_pool_destroy(pool);
}

/* The pool begins with its first task and ends with the program. */
static void *pool_enqueue(void *user, msap_task_fn run, void *task)
{
    void *ticket;
    (void)user;
    if (!pool) {
        pool = thread_pool_create(3);
        if (!pool || atexit(end_pool))
            abort();
    }
    jobs_enqueued++;
    ticket = thread_pool_enqueue(pool, run, task);
    jobs_finished += ticket == NULL;
    return ticket;
}

static void pool_finish(void *user, void *ticket)
{
    (void)user;
    thread_pool_finish(pool, ticket);
    jobs_finished++;
}

/* -------------------------------------------------------------------- threads */

typedef struct threaded {
    pthread_t thread;
    msap_task_fn run;
    void *task;
} threaded;

static void *run_threaded(void *argument)
{
    threaded *t = argument;
    t->run(t->task);
    return NULL;
}

static void *threads_enqueue(void *user, msap_task_fn run, void *task)
{
    threaded *t = malloc(sizeof *t);
    (void)user;
    if (!t)
        abort();
    t->run = run;
    t->task = task;
    jobs_enqueued++;
    if (pthread_create(&t->thread, NULL, run_threaded, t))
        abort();
    return t;
}

static void threads_finish(void *user, void *ticket)
{
    threaded *t = ticket;
    (void)user;
    if (pthread_join(t->thread, NULL))
        abort();
    free(t);
    jobs_finished++;
}

void use_jobs(msap_config *config, uint32_t workers, job_system jobs)
{
    static const msap_enqueue_fn enqueue[JOBS_COUNT] = {NULL, at_once_enqueue, late_enqueue, pool_enqueue,
                                                        threads_enqueue};
    static const msap_finish_fn finish[JOBS_COUNT] = {NULL, at_once_finish, late_finish, pool_finish, threads_finish};
    config->workers = workers;
    config->task_grain = 256;
    config->enqueue = enqueue[jobs];
    config->finish = finish[jobs];
}
