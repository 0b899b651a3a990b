/* Sharing moves: workers put boxes elsewhere at the same time (paper II.3d).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The boxes are sorted by the layer of cells, along the axis that has most of them, in which
 * they start, and each worker takes a contiguous part. Its region is the layers from that of
 * its first box on, before that of the next worker's first box. A box belongs to a region if all
 * its cells do. Two boxes that overlap have a point in common and so a cell: boxes of
 * different regions are no neighbours, before and after. So a worker may move the boxes of its
 * region and change the lists of others in it, and what it reads and writes of cells, boxes and
 * lists no other one writes.
 *
 * All that is done twice, with the regions' ends elsewhere, since boxes at the ends stay where they
 * are. A box whose list was not finished the first time may have neighbours anywhere: it is not
 * touched the second time. It is left to the calling thread, as is what belongs to no region or
 * would take memory (move.c). */
#include "cells.h"

/* The axis across which layers lie: of axes that are as long, the one on which cells that are side by
 * side are furthest apart in memory. */
static uint32_t longest_axis(const struct level *l)
{
    uint32_t best = 2;
    for (uint32_t k = 2; k-- > 0;)
        if (l->count[k] > l->count[best]) best = k;
    return best;
}

/* Cells are numbered layer after layer: how far apart, by axis, are the numbers of those that are
 * side by side. */
static void number_cells(const struct level *l, uint32_t apart[3])
{
    uint32_t z = longest_axis(l), y = (z + 2) % 3, x = (z + 1) % 3;
    apart[x] = 1;
    apart[y] = l->count[x];
    apart[z] = l->count[x] * l->count[y];
}

static uint32_t number_of(const struct level *l, const uint32_t apart[3], const int32_t at[3])
{
    return wrap(at[0], l->count[0]) * apart[0] + wrap(at[1], l->count[1]) * apart[1] +
           wrap(at[2], l->count[2]) * apart[2];
}

/* Orders n boxes by the cell that they were in or, of those that come, are in now, so that what is
 * near in space is near in time. Returns the keys by which they were sorted, cell << 32 | slot, in
 * scratch memory of which the first 2 n words are taken; or NULL without it: then they stay as
 * they are. */
const uint64_t *msap_order_by_cell(const struct grid *g, const struct job *job, uint32_t *slot, size_t n)
{
    const struct layout *l = &g->layout[g->current];
    uint64_t *key = msap_scratch_get(job->scratch, job->memory, GRID_WORDS(n));
    uint32_t apart[3];
    if (!key || n == 0) return NULL;
    number_cells(&l->level[0], apart);
    for (size_t i = 0; i < n; i++) {
        const struct box *b = &job->boxes->at[slot[i]];
        struct range base = range_of(l, b->level == NO_LEVEL ? &b->now : &b->fat);
        key[i] = (uint64_t)number_of(&l->level[0], apart, base.low) << 32 | slot[i];
    }
    msap_sort_keys(key, n, key + n);
    for (size_t i = 0; i < n; i++) slot[i] = (uint32_t)key[i];
    return key;
}

/* The moves of a commit at work. */
struct sharing {
    struct grid *grid;
    const struct job *job;
    const uint64_t *key; /* [n] the cells in which the boxes start << 32, in order */
    const uint32_t *slot;
    uint8_t *state;
    size_t n, turn;       /* item i of the phase is box (i + turn) % n */
    uint32_t axis, layer; /* cells of a layer */
};

static size_t box_of_item(const struct sharing *s, size_t i) { return (i + s->turn) % s->n; }

static uint32_t layer_of_item(const struct sharing *s, size_t i)
{
    return (uint32_t)(s->key[box_of_item(s, i)] >> 32) / s->layer;
}

/* How many layers there are from one to another, around the end. */
static uint32_t layers_between(const struct sharing *s, uint32_t first, uint32_t end)
{
    uint32_t all = s->grid->layout[s->grid->current].level[0].count[s->axis];
    return end >= first ? end - first : end + all - first;
}

/* A worker moves the boxes of its part, items first ... last - 1, as far as they lie in its region. */
static void move_own(void *context, struct worker *w, size_t first, size_t last)
{
    const struct sharing *s = context;
    uint32_t start = layer_of_item(s, first), layers = layers_between(s, start, layer_of_item(s, last));
    const struct region own = {s->axis, start, layers};
    struct job job = *s->job;
    job.worker = w;
    job.memory = NULL;
    for (size_t i = first, n; i < last; i += n) {
        size_t at = box_of_item(s, i), end = at + (last - i) < s->n ? at + (last - i) : s->n;
        n = end - at < MOVES_AT_ONCE ? end - at : MOVES_AT_ONCE;
        msap_move_few(s->grid, &job, &own, s->slot + at, s->state + at, n);
    }
}

/* Room for what each worker finds. Where it is not enough, the calling thread has the
 * more to do. */
static void equip(struct grid *g, const struct job *job, size_t tasks, size_t n)
{
    enum { FOUND = 256, DOOMED = 512, ONE_IN = 4, CLASSES = 6 /* up to 32 neighbours */ };
    for (size_t i = 1; i <= tasks; i++) {
        struct worker *w = &job->crew->worker[i];
        msap_memory_reserve(job->memory, &w->found, &w->room_found, FOUND, 0, sizeof *w->found);
        msap_keys_reserve(&w->settler.doomed, job->memory, DOOMED);
        msap_pool_lend(&g->near.pool, job->memory, &w->stock, CLASSES, n / ONE_IN / tasks);
    }
}

/* Two rounds, the regions of the second half a region further on. */
static void share(struct sharing *s, size_t tasks)
{
    const struct job *job = s->job;
    equip(s->grid, job, tasks, s->n);
    for (int i = 0; i < 2; i++, s->turn = s->n / tasks / 2)
        msap_phase_run(job->crew, job->memory, move_own, s, s->n, WEIGHT_MOVE);
    for (size_t i = 1; i <= tasks; i++) msap_pool_take_back(&s->grid->near.pool, &job->crew->worker[i].stock);
}

/* Orders n boxes, which are to be put elsewhere, by cell and, where it is worth it, lets the
 * workers do so with most of them. Returns how far each has come, in scratch memory, or NULL: none
 * of them anywhere. */
uint8_t *msap_share_moves(struct grid *g, const struct job *job, uint32_t *slot, size_t n)
{
    enum { LAYERS = 4 /* of a worker, at least: of fewer, too many are at an end */ };
    const struct level *l = &g->layout[g->current].level[0];
    const uint64_t *key = msap_order_by_cell(g, job, slot, n);
    struct sharing s = {.grid = g, .job = job, .key = key, .slot = slot, .n = n, .axis = longest_axis(l)};
    size_t tasks = msap_phase_tasks(job->crew, n, WEIGHT_MOVE);
    uint32_t apart[3];
    number_cells(l, apart);
    s.layer = apart[s.axis];
    if (!key || tasks < 2 || l->count[s.axis] < LAYERS * tasks || g->layout[1 - g->current].boxes > 0) return NULL;
    s.state = (uint8_t *)(job->scratch->at + 2 * n);
    memset(s.state, MOVE_WAITS, n);
    share(&s, tasks);
    return s.state;
}
