/* A small pool of POSIX threads: what a host gives to config.enqueue and
 * config.finish if it has no job system of its own.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     thread_pool *pool = thread_pool_create(3);
 *     config.workers = 4;                        the calling thread works too
 *     config.enqueue = thread_pool_enqueue;
 *     config.finish = thread_pool_finish;
 *     config.jobs_user = pool;
 *     ... the worlds live ...
 *     thread_pool_destroy(pool);
 *
 * Several worlds, also on several threads, may use one pool at once.
 */
#ifndef THREAD_POOL_H
#define THREAD_POOL_H

#include <multisap.h>

typedef struct thread_pool thread_pool;

/* A pool with so many threads, or with fewer if the system gives no more: it does
 * its work with any number, even none. NULL without memory. */
thread_pool *thread_pool_create(unsigned threads);

/* Ends the threads; NULL is allowed. No task may be waiting or running. */
void thread_pool_destroy(thread_pool *pool);

/* An msap_enqueue_fn and an msap_finish_fn; `pool` is a thread_pool. */
void *thread_pool_enqueue(void *pool, msap_task_fn run, void *task);
void thread_pool_finish(void *pool, void *ticket);

#endif
