/* Claims about the queues of operations (II.3d): filled by one thread or by several.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Boxes are rasterised, and what each does to the cells that it enters, keeps or leaves
 * is recorded in the queues of the cells. Each task has queues of its own, for its
 * part of the boxes; a cell would work through them in the order of the tasks.
 */
#include "film.h"

#include <stdlib.h>
#include <string.h>

enum { ADD, UPDATE, REMOVE };

/* An operation on a cell. */
struct operation {
    uint32_t cell, box : 30, kind : 2;
};

/* The queues of all cells, for a part of the boxes. */
struct queues {
    const struct film *film;
    const struct frame *old, *now;
    uint32_t first, last; /* boxes */
    struct operation *made, *sorted;
    uint32_t n, *end; /* [cells + 1] where each cell's queue ends in `sorted` */
};

static int holds(struct span s, uint32_t x, uint32_t y)
{
    return x >= s.low[0] && x <= s.high[0] && y >= s.low[1] && y <= s.high[1];
}

/* Records an operation for each cell of `in`: `both` or `one`, as it is in `other` too
 * or not; but none for `both` being REMOVE. */
static void record(struct queues *q, uint32_t box, struct span in, struct span other, uint32_t both, uint32_t one)
{
    for (uint32_t y = in.low[1]; y <= in.high[1]; y++)
        for (uint32_t x = in.low[0]; x <= in.high[0]; x++) {
            int is_both = holds(other, x, y);
            if (is_both && both == REMOVE) continue;
            struct operation o = {y * q->film->count + x, box, is_both ? both : one};
            q->made[q->n++] = o;
        }
}

static void sort_by_cell(struct queues *q)
{
    size_t cells = q->film->cells;
    memset(q->end, 0, (cells + 1) * sizeof *q->end);
    for (uint32_t i = 0; i < q->n; i++) q->end[q->made[i].cell + 1]++;
    for (size_t i = 1; i <= cells; i++) q->end[i] += q->end[i - 1];
    for (uint32_t i = 0; i < q->n; i++) q->sorted[q->end[q->made[i].cell]++] = q->made[i];
}

/* Records what the boxes of a part do to the cells that they enter, keep and leave: an
 * msap_task_fn. */
static void fill_queues(void *queues)
{
    struct queues *q = queues;
    q->n = 0;
    for (uint32_t i = q->first; i < q->last; i++) {
        struct span now = span_of(q->film, &q->now->box[i]);
        record(q, i, now, q->old->span[i], UPDATE, ADD);
        record(q, i, q->old->span[i], now, REMOVE, REMOVE);
    }
    sort_by_cell(q);
}

static struct queues queues_make(const struct film *f, uint32_t first, uint32_t last)
{
    enum { OPERATIONS_A_BOX = 8 }; /* a box about 1 wide is in no more than 4 cells, before and after */
    size_t room = (size_t)OPERATIONS_A_BOX * (last - first);
    struct queues q = {f, NULL, NULL, first, last, NULL, NULL, 0, NULL};
    q.made = get(room, sizeof *q.made);
    q.sorted = get(room, sizeof *q.sorted);
    q.end = get(f->cells + 1, sizeof *q.end);
    return q;
}

static void fill_frame(const struct film *f, uint32_t frame, struct queues *q, unsigned tasks)
{
    void *ticket[MOST_TASKS];
    for (unsigned i = 0; i < tasks; i++) {
        q[i].old = &f->frame[frame - 1];
        q[i].now = &f->frame[frame];
        ticket[i] = i > 0 ? thread_pool_enqueue(f->pool, fill_queues, &q[i]) : NULL;
    }
    fill_queues(&q[0]);
    for (unsigned i = 0; i < tasks; i++)
        if (ticket[i]) thread_pool_finish(f->pool, ticket[i]);
}

static outcome fill(const struct film *f, unsigned tasks)
{
    struct queues q[MOST_TASKS];
    outcome o = {0, 0};
    uint32_t n = f->scene->boxes;
    for (unsigned i = 0; i < tasks; i++) q[i] = queues_make(f, n * i / tasks, n * (i + 1) / tasks);
    for (uint32_t frame = 1; frame < f->frames; frame++) {
        double start = wall_ms();
        fill_frame(f, frame, q, tasks);
        o.ms += frame > 1 ? wall_ms() - start : 0; /* the first one touches new memory */
        for (unsigned i = 0; i < tasks; i++) o.check += q[i].n;
    }
    o.ms /= f->frames - 2;
    for (unsigned i = 0; i < tasks; i++) {
        free(q[i].made);
        free(q[i].sorted);
        free(q[i].end);
    }
    return o;
}

static outcome by_1(const void *film) { return fill(film, 1); }
static outcome by_2(const void *film) { return fill(film, 2); }
static outcome by_4(const void *film) { return fill(film, 4); }

void compare_queues(const struct film *f)
{
    const way ways[] = {{"1 thread", by_1, f}, {"2 threads", by_2, f}, {"4 threads", by_4, f}};
    compare("queues", f->scene->name, ways, 3, 7, NULL);
}
