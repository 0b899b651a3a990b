/* Claims about a Multi-SAP's pairs and threads (II.3b, II.3d), of which this file
 * measures the library's own: a commit at 1, 2 and 4 workers.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "film.h"
#include "library.h"

static void compare_pairs_and_queues(const recipe *r, thread_pool *pool)
{
    scene s = scene_make(r);
    struct film f = film_make(&s, pool);
    compare_pairs(&f);
    compare_queues(&f);
    film_free(&f);
    scene_free(&s);
}

/* What the machine has to give: a sum, cut into so many tasks. */
struct sum {
    thread_pool *pool;
    unsigned tasks;
};

struct terms {
    uint32_t n;
    double total;
};

static void add_up(void *terms)
{
    struct terms *t = terms;
    double total = 0;
    for (uint32_t i = 0; i < t->n; i++) total += i;
    t->total = total;
}

static outcome sum_up(const void *what)
{
    const struct sum *s = what;
    struct terms terms[MOST_TASKS];
    void *ticket[MOST_TASKS] = {NULL};
    outcome o = {0, 0};
    for (unsigned i = 0; i < s->tasks; i++) terms[i].n = 20000000 / s->tasks;
    double start = wall_ms();
    for (unsigned i = 1; i < s->tasks; i++) ticket[i] = thread_pool_enqueue(s->pool, add_up, &terms[i]);
    add_up(&terms[0]);
    for (unsigned i = 1; i < s->tasks; i++)
        if (ticket[i]) thread_pool_finish(s->pool, ticket[i]);
    o.ms = wall_ms() - start;
    return o;
}

static void compare_threads(thread_pool *pool)
{
    const struct sum by_1 = {pool, 1}, by_2 = {pool, 2}, by_4 = {pool, 4};
    const way ways[] = {{"1 thread", sum_up, &by_1}, {"2 threads", sum_up, &by_2}, {"4 threads", sum_up, &by_4}};
    compare("threads", "a sum of 20,000,000 numbers", ways, 3, 7, NULL);
}

static void compare_workers(const recipe *r, thread_pool *pool)
{
    static const char *const name[] = {"1 worker", "2 workers", "4 workers"};
    scene s = scene_make(r);
    msap_config config[3];
    setting settings[3];
    way ways[3];
    for (int i = 0; i < 3; i++) {
        config[i] = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO);
        config[i].workers = 1u << i;
        config[i].enqueue = thread_pool_enqueue;
        config[i].finish = thread_pool_finish;
        config[i].jobs_user = pool;
        settings[i].scene = &s;
        settings[i].config = &config[i];
        settings[i].has_statics = 0;
        ways[i].name = name[i];
        ways[i].run = library_replay;
        ways[i].what = &settings[i];
    }
    compare("parallel", s.name, ways, 3, 5, NULL);
    scene_free(&s);
}

void claim_parallel(void)
{
    static const recipe floors[] = {
        {"10,000 boxes, slow", 10000, 6, 2, 1, 0.05, STRAIGHT, 1, 0},
        {"100,000 boxes, slow", 100000, 6, 2, 1, 0.05, STRAIGHT, 1, 0},
        {"100,000 boxes, crowded", 100000, 6, 10, 1, 0.05, STRAIGHT, 1, 0},
        {"100,000 boxes, fast", 100000, 6, 2, 1, 1, BROWNIAN, 1, 0},
    };
    static const recipe cubes[] = {
        {"10,000 boxes, slow", 10000, 40, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"100,000 boxes, slow", 100000, 12, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"100,000 boxes, jumping", 100000, 6, 2, 1, 0, JUMPING, 0, 0},
    };
    thread_pool *pool = thread_pool_create(3);
    if (!pool) give_up("no memory for threads");
    compare_threads(pool);
    for (size_t i = 0; i < sizeof floors / sizeof *floors; i++) compare_pairs_and_queues(&floors[i], pool);
    for (size_t i = 0; i < sizeof cubes / sizeof *cubes; i++) compare_workers(&cubes[i], pool);
    thread_pool_destroy(pool);
}
