/* Phases: work over a range of items that may be cut into tasks and run on the
 * host's threads (paper II.3d).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A phase reads what no task of it writes, and writes only what belongs to its own
 * items and the buffers of its worker. Each worker takes a contiguous part of the
 * items, so that the buffers one after another hold what one worker alone would
 * have written: the merge is a concatenation, and the same at any number of workers.
 *
 * Waking a thread takes as long as touching thousands of boxes. So a phase is cut only
 * into parts that are worth it, by what an item of it costs.
 *
 * Workers do not allocate. One whose buffers overflow goes on and counts what it finds;
 * the calling thread then gives it that much room, and the task is run again. On one
 * worker, which is the calling thread, the buffers simply grow. */
#include "internal.h"

enum { DEFAULT_GRAIN = 24576 };

void msap_crew_init(struct crew *crew, const msap_config *config)
{
    memset(crew, 0, sizeof *crew);
    crew->size = config->workers;
    crew->grain = config->task_grain ? config->task_grain : DEFAULT_GRAIN;
    crew->enqueue = config->enqueue;
    crew->finish = config->finish;
    crew->jobs_user = config->jobs_user;
}

static uint32_t count_of(const struct crew *crew) { return crew->size > 1 ? crew->size + 1 : 1; }

/* A tag for each of so many slots. */
int msap_crew_reserve(struct crew *crew, struct memory *m, size_t slots)
{
    for (uint32_t i = 0; i < count_of(crew); i++) {
        struct worker *w = &crew->worker[i];
        if (slots <= w->slots) continue;
        if (!msap_memory_reserve(m, &w->tag, &w->room_tag, slots, w->slots, sizeof *w->tag)) return 0;
        memset(w->tag + w->slots, 0, (slots - w->slots) * sizeof *w->tag);
        w->slots = slots;
    }
    return 1;
}

/* Room for what a sweep can find among n boxes. */
int msap_crew_room_to_find(struct crew *crew, struct memory *m, size_t n)
{
    for (uint32_t i = 0; i < count_of(crew); i++) {
        struct worker *w = &crew->worker[i];
        if (!msap_memory_reserve(m, &w->found, &w->room_found, n + FOUND_SLACK, 0, sizeof *w->found)) return 0;
    }
    return 1;
}

/* Gives back all but room for what boxes in so many slots need, and on the list of the
 * doomed of the calling thread for every pair. */
void msap_crew_trim(struct crew *crew, struct memory *m, size_t slots, size_t pairs)
{
    for (uint32_t i = 0; i < count_of(crew); i++) {
        struct worker *w = &crew->worker[i];
        struct keys *doomed = &w->settler.doomed;
        msap_keys_free(&w->settler.fresh, m);
        msap_keys_free(&w->settler.notes, m);
        msap_keys_free(&w->pairs, m);
        doomed->n = 0;
        msap_memory_shrink(m, &doomed->at, &doomed->room, i == 0 ? pairs : 0, sizeof *doomed->at);
        msap_memory_shrink(m, &w->found, &w->room_found, 0, sizeof *w->found);
        msap_memory_shrink(m, &w->tag, &w->room_tag, slots, sizeof *w->tag);
        w->slots = slots < w->slots ? slots : w->slots;
        w->wanted = 0;
    }
}

void msap_crew_free(struct crew *crew, struct memory *m)
{
    for (uint32_t i = 0; i < count_of(crew); i++) {
        struct worker *w = &crew->worker[i];
        msap_keys_free(&w->settler.fresh, m);
        msap_keys_free(&w->settler.doomed, m);
        msap_keys_free(&w->settler.notes, m);
        msap_keys_free(&w->pairs, m);
        msap_memory_free(m, w->found, w->room_found, sizeof *w->found);
        msap_memory_free(m, w->tag, w->room_tag, sizeof *w->tag);
    }
}

struct task {
    phase_fn run;
    void *context;
    struct worker *worker;
    size_t first, last;
};

static void run_task(void *pointer)
{
    struct task *t = pointer;
    t->run(t->context, t->worker, t->first, t->last);
}

static void forget(struct worker *w)
{
    w->settler.fresh.n = w->settler.doomed.n = w->settler.notes.n = w->pairs.n = 0;
    w->settler.touched = 0;
    w->settler.lost = w->settler.has_all_doomed = 0;
}

/* Gives the buffers of a worker room for more than it had for them. Returns 0 without
 * memory. */
static int enlarge(struct worker *w, struct memory *m)
{
    struct keys *buffers[4] = {&w->settler.fresh, &w->settler.doomed, &w->settler.notes, &w->pairs};
    for (int i = 0; i < 4; i++) {
        size_t wanted = buffers[i]->n + buffers[i]->n / 4 + 256;
        buffers[i]->n = 0;
        if (!msap_keys_reserve(buffers[i], m, wanted)) return 0;
    }
    return msap_memory_reserve(m, &w->found, &w->room_found, w->wanted, 0, sizeof *w->found);
}

/* Appends what a worker found to what the calling thread has. */
static int append(struct keys *to, const struct keys *from, struct memory *m)
{
    if (from->n == 0) return 1;
    if (!msap_keys_reserve(to, m, to->n + from->n)) return 0;
    memcpy(to->at + to->n, from->at, from->n * sizeof *to->at);
    to->n += from->n;
    return 1;
}

static int merge(struct worker *to, const struct worker *from, struct memory *m)
{
    to->settler.touched += from->settler.touched;
    return append(&to->settler.fresh, &from->settler.fresh, m) &&
           append(&to->settler.doomed, &from->settler.doomed, m) &&
           append(&to->settler.notes, &from->settler.notes, m) && append(&to->pairs, &from->pairs, m);
}

/* Runs n tasks, the first of them here. */
static void run_all(const struct crew *crew, struct task *const *task, size_t n)
{
    void *ticket[MOST_WORKERS];
    for (size_t i = 0; i < n; i++) forget(task[i]->worker);
    for (size_t i = 1; i < n; i++) ticket[i] = crew->enqueue(crew->jobs_user, run_task, task[i]);
    run_task(task[0]);
    for (size_t i = 1; i < n; i++)
        if (ticket[i]) crew->finish(crew->jobs_user, ticket[i]);
}

/* Runs n tasks, and those that found more than they had room for once more. Returns 0
 * without memory. */
static int run_until_complete(const struct crew *crew, struct memory *m, struct task **task, size_t n)
{
    while (n > 0) {
        size_t again = 0;
        run_all(crew, task, n);
        for (size_t i = 0; i < n; i++) {
            if (!task[i]->worker->settler.lost) continue;
            if (!enlarge(task[i]->worker, m)) return 0;
            task[again++] = task[i];
        }
        n = again;
    }
    return 1;
}

static int run_in_tasks(struct crew *crew, struct memory *m, phase_fn run, void *context, size_t n, size_t tasks)
{
    struct task task[MOST_WORKERS], *to_run[MOST_WORKERS];
    int done;
    for (size_t i = 0; i < tasks; i++) {
        struct task t = {run, context, &crew->worker[i + 1], n * i / tasks, n * (i + 1) / tasks};
        task[i] = t;
        to_run[i] = &task[i];
        t.worker->settler.boxes = crew->worker[0].settler.boxes;
    }
    done = run_until_complete(crew, m, to_run, tasks);
    for (size_t i = 0; i < tasks; i++) done = done && merge(&crew->worker[0], task[i].worker, m);
    return done;
}

/* Into how many tasks n items of a weight are worth being cut: no more than there are workers
 * or items; less than 2: into none. */
size_t msap_phase_tasks(const struct crew *crew, size_t n, size_t weight)
{
    double worth = (double)n * (double)weight / (double)crew->grain;
    size_t most = n < crew->size ? n : crew->size;
    return worth < (double)most ? (size_t)worth : most;
}

/* Runs a phase over n items of a weight (internal.h); its output is appended to that of
 * worker 0. Without the memory for tasks the calling thread does all. Returns 0 if that
 * lacks memory too. */
int msap_phase_run(struct crew *crew, struct memory *m, phase_fn run, void *context, size_t n, size_t weight)
{
    struct worker *own = &crew->worker[0];
    size_t fresh = own->settler.fresh.n, doomed = own->settler.doomed.n, notes = own->settler.notes.n,
           pairs = own->pairs.n;
    size_t tasks = msap_phase_tasks(crew, n, weight);
    if (tasks > 1 && run_in_tasks(crew, m, run, context, n, tasks)) return 1;
    own->settler.fresh.n = fresh;
    own->settler.doomed.n = doomed;
    own->settler.notes.n = notes;
    own->pairs.n = pairs;
    run(context, own, 0, n);
    return !own->settler.lost;
}

/* Whether the worker's buffer has room for n more pairs and some slack; if not they are
 * counted. A buffer that lacked memory once is not asked for it again. */
int msap_worker_has_room(struct worker *w, size_t n, size_t slack)
{
    size_t need = w->pairs.n + n + slack;
    if (need <= w->pairs.room) return 1;
    if (!w->settler.lost && w->settler.memory && msap_keys_reserve(&w->pairs, w->settler.memory, need)) return 1;
    w->settler.lost = 1;
    w->pairs.n += n;
    return 0;
}

/* Appends a pair to the worker's buffer. */
void msap_worker_put(struct worker *w, uint64_t key)
{
    if (msap_worker_has_room(w, 1, 0)) w->pairs.at[w->pairs.n++] = key;
}

/* Appends the pairs of a slot with the first n that a sweep has found: four at a time,
 * whether or not there are as many. */
void msap_worker_put_found(struct worker *w, uint32_t self, size_t n)
{
    if (!msap_worker_has_room(w, n, 4)) return;
    uint64_t *pair = w->pairs.at + w->pairs.n;
    for (size_t i = 0; i < n; i += 4) pairs_of_four(pair + i, self, w->found + i);
    w->pairs.n += n;
}

/* Whether the worker has room for what a sweep can find among `more` boxes behind the n that are
 * found. */
int msap_worker_room_to_find(struct worker *w, size_t n, size_t more)
{
    size_t need = n + more + FOUND_SLACK;
    if (need <= w->room_found) return 1;
    w->wanted = need;
    return w->settler.memory &&
           msap_memory_reserve(w->settler.memory, &w->found, &w->room_found, need, n, sizeof *w->found);
}

/* A token that no tag of the worker carries, nor the one after it. */
void msap_worker_new_token(struct worker *w)
{
    w->token += 2;
    if (w->token < UINT32_MAX - 2) return;
    memset(w->tag, 0, w->slots * sizeof *w->tag);
    w->token = 2;
}
