/* Claims about the pairs of a Multi-SAP (II.3b, II.3d): one pair manager for all
 * cells, one for each with a merge, or a cell that owns the pair.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * In each frame the cells are swept for pairs, and what comes of them is compared with
 * the frame before.
 */
#include "film.h"
#include "pair_set.h"

#include <stdlib.h>
#include <string.h>

/* Pairs: lower box << 32 | higher box. */
struct list {
    uint64_t *at;
    size_t n, room;
};

static uint64_t pair_key(uint32_t a, uint32_t b) { return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a; }
static uint32_t lower(uint64_t key) { return (uint32_t)(key >> 32); }
static uint32_t higher(uint64_t key) { return (uint32_t)key; }

static void reserve(struct list *l, size_t room)
{
    if (room <= l->room) return;
    l->room = 2 * room + 1024;
    l->at = realloc(l->at, l->room * sizeof *l->at);
    if (!l->at) give_up("no memory");
}

static void append(struct list *l, const struct list *more)
{
    reserve(l, l->n + more->n);
    memcpy(l->at + l->n, more->at, more->n * sizeof *l->at);
    l->n += more->n;
}

/* The part of the cells that a task sweeps, and what it finds. */
struct part {
    const struct film *film;
    const struct frame *frame;
    size_t first, last;
    int is_owner; /* 1: only the cell with the higher of two low corners takes the pair */
    struct list found;
};

static int owns(const struct film *f, size_t cell, struct span a, struct span b)
{
    uint32_t x = a.low[0] > b.low[0] ? a.low[0] : b.low[0], y = a.low[1] > b.low[1] ? a.low[1] : b.low[1];
    return cell == (size_t)y * f->count + x;
}

/* Sweeps the cells of a part: an msap_task_fn. */
static void sweep(void *part)
{
    struct part *p = part;
    const struct frame *f = p->frame;
    for (size_t cell = p->first; cell < p->last; cell++)
        for (uint32_t i = f->first[cell]; i < f->first[cell + 1]; i++)
            for (uint32_t j = i + 1; j < f->first[cell + 1]; j++) {
                uint32_t a = f->in[i], b = f->in[j];
                if (aabb_overlap(&f->box[a], &f->box[b]) &&
                    (!p->is_owner || owns(p->film, cell, f->span[a], f->span[b]))) {
                    reserve(&p->found, p->found.n + 1);
                    p->found.at[p->found.n++] = pair_key(a, b);
                }
            }
}

/* Sweeps all cells in so many tasks; the findings follow each other in part[0]. */
static void sweep_in_tasks(const struct film *f, const struct frame *now, struct part *part, unsigned tasks,
                           int is_owner)
{
    void *ticket[MOST_TASKS];
    for (unsigned i = 0; i < tasks; i++) {
        part[i].film = f;
        part[i].frame = now;
        part[i].first = f->cells * i / tasks;
        part[i].last = f->cells * (i + 1) / tasks;
        part[i].is_owner = is_owner;
        part[i].found.n = 0;
    }
    for (unsigned i = 1; i < tasks; i++) ticket[i] = thread_pool_enqueue(f->pool, sweep, &part[i]);
    sweep(&part[0]);
    for (unsigned i = 1; i < tasks; i++) {
        if (ticket[i]) thread_pool_finish(f->pool, ticket[i]);
        append(&part[0].found, &part[i].found);
    }
}

/* What two sorted lists do not share: adds it to a check, as created or deleted. */
static uint64_t differences(const struct list *old, const struct list *now)
{
    uint64_t check = 0;
    for (size_t i = 0, j = 0; i < old->n || j < now->n;) {
        uint64_t a = i < old->n ? old->at[i] : UINT64_MAX, b = j < now->n ? now->at[j] : UINT64_MAX;
        if (a < b) check += 3 * pair_check(lower(a), higher(a));
        if (b < a) check += pair_check(lower(b), higher(b));
        i += a <= b;
        j += b <= a;
    }
    return check;
}

/* Of a sorted list. */
static void drop_repeats(struct list *l)
{
    size_t kept = 0;
    for (size_t i = 0; i < l->n; i++)
        if (kept == 0 || l->at[i] != l->at[kept - 1]) l->at[kept++] = l->at[i];
    l->n = kept;
}

/* One pair manager a cell, each no more than what its sweep finds; merged by sorting. */
static outcome merge_cells(const struct film *f, unsigned tasks, int is_owner)
{
    struct part part[MOST_TASKS] = {{0}};
    struct list old = {0}, spare = {0};
    outcome o = {0, 0};
    for (uint32_t i = 0; i < f->frames; i++) {
        double start = wall_ms();
        sweep_in_tasks(f, &f->frame[i], part, tasks, is_owner);
        struct list now = part[0].found;
        reserve(&spare, now.n);
        sort_keys(now.at, now.n, spare.at);
        drop_repeats(&now);
        o.check += differences(&old, &now);
        part[0].found = old;
        old = now;
        o.ms += i > 0 ? wall_ms() - start : 0;
    }
    o.ms /= f->frames - 1;
    free(old.at);
    free(spare.at);
    for (unsigned i = 0; i < MOST_TASKS; i++) free(part[i].found.at);
    return o;
}

static outcome merged(const void *film) { return merge_cells(film, 1, 0); }
static outcome owned(const void *film) { return merge_cells(film, 1, 1); }
static outcome merged_by_2(const void *film) { return merge_cells(film, 2, 0); }
static outcome owned_by_2(const void *film) { return merge_cells(film, 2, 1); }

/* One pair manager for all: what a sweep finds is added at once, and looked at again
 * in the next frame, when it may be gone. */
static uint64_t drop_gone(pair_set *pairs, const struct frame *now)
{
    uint64_t check = 0;
    for (uint32_t i = 0; i < pairs->n;) {
        active_pair p = pairs->at[i];
        if (aabb_overlap(&now->box[p.a], &now->box[p.b])) {
            i++;
            continue;
        }
        check += 3 * pair_check(p.a, p.b);
        pair_set_remove(pairs, p.a, p.b);
    }
    return check;
}

static uint64_t add_found(pair_set *pairs, const struct list *found)
{
    uint64_t check = 0;
    for (size_t i = 0; i < found->n; i++) {
        uint32_t a = lower(found->at[i]), b = higher(found->at[i]);
        if (pair_set_add(pairs, a, b)) check += pair_check(a, b);
    }
    return check;
}

static outcome shared(const void *what)
{
    const struct film *f = what;
    outcome o = {0, 0};
    pair_set pairs;
    pair_set_begin(&pairs);
    struct part cell = {f, NULL, 0, 0, 0, {NULL, 0, 0}};
    for (uint32_t i = 0; i < f->frames; i++) {
        double start = wall_ms();
        o.check += drop_gone(&pairs, &f->frame[i]);
        cell.frame = &f->frame[i];
        for (cell.first = 0; cell.first < f->cells; cell.first++) {
            cell.last = cell.first + 1;
            cell.found.n = 0;
            sweep(&cell);
            o.check += add_found(&pairs, &cell.found);
        }
        o.ms += i > 0 ? wall_ms() - start : 0;
    }
    o.ms /= f->frames - 1;
    free(cell.found.at);
    pair_set_end(&pairs);
    return o;
}

/* -------------------------------------------------- what a shared one misses */

/* The cells that both spans cover. */
static struct span common(struct span a, struct span b)
{
    struct span s;
    for (int k = 0; k < 2; k++) {
        s.low[k] = a.low[k] > b.low[k] ? a.low[k] : b.low[k];
        s.high[k] = a.high[k] < b.high[k] ? a.high[k] : b.high[k];
    }
    return s;
}

static double cells_in(struct span s)
{
    int x = s.high[0] - s.low[0] + 1, y = s.high[1] - s.low[1] + 1;
    return x > 0 && y > 0 ? (double)x * y : 0;
}

/* A pair that lasts may leave one of the cells that see it and stay in others. Whoever
 * takes the leaving for the end of the pair is wrong: how often does that happen? */
static void count_leavings(const struct film *f, const char *name)
{
    struct part all = {f, NULL, 0, f->cells, 1, {NULL, 0, 0}};
    double pairs = 0, seen = 0, leavings = 0;
    for (uint32_t i = 1; i < f->frames; i++) {
        const struct frame *old = &f->frame[i - 1], *now = &f->frame[i];
        all.frame = old;
        all.found.n = 0;
        sweep(&all);
        pairs += (double)all.found.n;
        for (size_t j = 0; j < all.found.n; j++) {
            uint32_t a = lower(all.found.at[j]), b = higher(all.found.at[j]);
            struct span before = common(old->span[a], old->span[b]), after = common(now->span[a], now->span[b]);
            seen += cells_in(before);
            leavings +=
                aabb_overlap(&now->box[a], &now->box[b]) && cells_in(common(before, after)) < cells_in(before);
        }
    }
    print_count("owner", name, "pairs", pairs / (f->frames - 1));
    print_count("owner", name, "cells that see a pair", seen / pairs);
    print_count("owner", name, "lasting pairs that leave a cell in a frame", leavings / (f->frames - 1));
    free(all.found.at);
}

void compare_pairs(const struct film *f)
{
    const way ways[] = {{"one shared", shared, f},
                        {"one a cell, merged", merged, f},
                        {"by an owner cell", owned, f},
                        {"one a cell, 2 threads", merged_by_2, f},
                        {"by an owner cell, 2 threads", owned_by_2, f}};
    compare("owner", f->scene->name, ways, 5, 7, NULL);
    count_leavings(f, f->scene->name);
}
