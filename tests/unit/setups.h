/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Set-ups: a table of the ways in which a world can be configured. The contract is
 * the same for all, so the tests run over the table; a number in a test's output is
 * a row of it. Row 0 is the default.
 *
 * And the job systems of those set-ups that have workers, each with another idea of
 * when and where a task runs.
 */
#ifndef SETUPS_H
#define SETUPS_H

#include "multisap.h"

typedef enum job_system {
    JOBS_NONE,
    JOBS_AT_ONCE, /* enqueue runs the task and gives no ticket */
    JOBS_LATE,    /* finish runs all tasks, the last one first */
    JOBS_POOL,    /* the pool of examples/thread_pool.c, with 3 threads */
    JOBS_THREADS, /* each task has a thread of its own, so that no two of them share a lock */
    JOBS_COUNT
} job_system;

/* Sets the config's workers and hooks, and so small a grain that a few hundred boxes get
 * tasks. */
void use_jobs(msap_config *config, uint32_t workers, job_system jobs);

/* Tasks that were enqueued so far and tasks that were waited for, in all job systems;
 * a task that ran at once counts as waited for. Not for several threads at once. */
extern size_t jobs_enqueued, jobs_finished;

typedef struct setup {
    const char *name;
    uint32_t grid, strategy, no_filters, simd;
    float margin; /* 0: the default; NO_MARGIN: 0 */
    float cell_size;
    uint32_t cells[3]; /* of MSAP_GRID_FIXED */
    float low, high;   /* its bounds on all axes */
    uint32_t workers;  /* 0: the default */
    job_system jobs;
} setup;

#define NO_MARGIN (-2.0f)

enum { SETUPS = 36 };
extern const setup setups[SETUPS];

/* A config for 2 or 3 axes. */
msap_config setup_config(uint32_t dims, int row);

#endif
