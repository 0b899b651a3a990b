/* A small pool of POSIX threads.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * One lock guards all of it: a fixed set of jobs, each spare, waiting or taken, and
 * two conditions to sleep on. A ticket is a pointer to a job. Who waits for a job
 * does not sleep while any job waits to be run, but runs one: tasks never wait for
 * each other, so this cannot lead to a knot, and a pool without threads works.
 *
 * Jobs come in bursts, a few microseconds apart, and are as short as it takes to wake a
 * thread; and a thread that is woken may find itself on the processor of the one that woke
 * it. So who has nothing to do looks again for a while, letting others run, before it
 * sleeps. */
#include "thread_pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdlib.h>

enum { MOST_THREADS = 64, JOBS = 256, LOOKS = 1000 /* before a thread sleeps: some 0.3 ms */ };

struct job {
    msap_task_fn run;
    void *task;
    int is_done;
    struct job *next; /* in the list it is in */
};

struct thread_pool {
    pthread_mutex_t lock;
    pthread_cond_t work, done; /* a job came to wait, or the pool closes; a job is done */
    struct job job[JOBS];
    struct job *spare;
    struct job *first, *last; /* waiting; `last` means nothing if there is none */
    int is_closing;
    unsigned threads;
    pthread_t thread[MOST_THREADS];
};

/* Runs the first waiting job. The lock is held before and after. */
static void run_first(thread_pool *p)
{
    struct job *j = p->first;
    p->first = j->next;
    pthread_mutex_unlock(&p->lock);
    j->run(j->task);
    pthread_mutex_lock(&p->lock);
    j->is_done = 1;
    pthread_cond_broadcast(&p->done);
}

/* Waits a little or, after many looks, for a condition. The lock is held before and after. */
static void rest(thread_pool *p, pthread_cond_t *condition, int *looks)
{
    if (++*looks > LOOKS) {
        pthread_cond_wait(condition, &p->lock);
        return;
    }
    pthread_mutex_unlock(&p->lock);
    sched_yield();
    pthread_mutex_lock(&p->lock);
}

static void *work(void *pool)
{
    thread_pool *p = pool;
    int looks = 0;
    pthread_mutex_lock(&p->lock);
    while (p->first || !p->is_closing)
        if (p->first) {
            run_first(p);
            looks = 0;
        } else
            rest(p, &p->work, &looks);
    pthread_mutex_unlock(&p->lock);
    return NULL;
}

void *thread_pool_enqueue(void *pool, msap_task_fn run, void *task)
{
    thread_pool *p = pool;
    pthread_mutex_lock(&p->lock);
    struct job *j = p->spare;
    if (j) {
        p->spare = j->next;
        j->run = run;
        j->task = task;
        j->is_done = 0;
        j->next = NULL;
        *(p->first ? &p->last->next : &p->first) = j;
        p->last = j;
        pthread_cond_signal(&p->work);
    }
    pthread_mutex_unlock(&p->lock);
    if (!j)
        run(task);
    return j;
}

void thread_pool_finish(void *pool, void *ticket)
{
    thread_pool *p = pool;
    struct job *j = ticket;
    int looks = 0;
    pthread_mutex_lock(&p->lock);
    while (!j->is_done)
        if (p->first)
            run_first(p);
        else
            rest(p, &p->done, &looks);
    j->next = p->spare;
    p->spare = j;
    pthread_mutex_unlock(&p->lock);
}

thread_pool *thread_pool_create(unsigned threads)
{
    thread_pool *p = calloc(1, sizeof *p);
    if (!p)
        return NULL;
    pthread_mutex_init(&p->lock, NULL);
    pthread_cond_init(&p->work, NULL);
    pthread_cond_init(&p->done, NULL);
    for (size_t i = 0; i < JOBS; i++) {
        p->job[i].next = p->spare;
        p->spare = &p->job[i];
    }
    while (p->threads < threads && p->threads < MOST_THREADS
           && pthread_create(&p->thread[p->threads], NULL, work, p) == 0)
        p->threads++;
    return p;
}

void thread_pool_destroy(thread_pool *p)
{
    if (!p)
        return;
    pthread_mutex_lock(&p->lock);
    p->is_closing = 1;
    pthread_cond_broadcast(&p->work);
    pthread_mutex_unlock(&p->lock);
    for (unsigned i = 0; i < p->threads; i++)
        pthread_join(p->thread[i], NULL);
    pthread_mutex_destroy(&p->lock);
    pthread_cond_destroy(&p->work);
    pthread_cond_destroy(&p->done);
    free(p);
}
