/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A hard limit of bytes, which is never lifted.
 *
 *     memory_limit [BOXES]
 *
 * 1. In every set-up a scene grows and moves under one limit after another. A call for
 *    which there is no memory must leave the world as it was; boxes are then removed
 *    until a commit succeeds, and the scene goes on.
 * 2. The n-th allocation fails, or all from it on, n = 1, 2, ... until none does, through
 *    the first commits of a scene that is large enough for tasks, levels and the pruning
 *    of everything.
 * 3. The pair explosion: BOXES boxes (default 20000) at one point would be a pair each
 *    with each, far more than the limit allows. The commit must say so; when most boxes
 *    have been removed, it must succeed.
 *
 * Test_memory.c does the second for smaller and longer scenes. Needs nothing but the C
 * library and POSIX threads. Prints how many allocations failed.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../unit/common.h"
#include "../unit/setups.h"

static unsigned long failed;

/* Ends the program if there is something wrong. */
static void right(const char *what, int row, size_t limit)
{
    if (!what)
        return;
    fprintf(stderr, "%s, limit %lu: %s\n", setups[row].name, (unsigned long)limit, what);
    exit(EXIT_FAILURE);
}

#define is(condition) ((condition) ? NULL : #condition)

/* -------------------------------------------------- 1. a scene under a limit */

/* 0 without memory: the world must be as it was. */
static int had_memory(session *s, msap_status status, int row)
{
    if (status == MSAP_OK)
        return 1;
    right(is(status == MSAP_ERROR_MEMORY), row, s->memory.limit);
    right(is(s->memory.peak <= s->memory.limit), row, s->memory.limit);
    right(session_compare(s), row, s->memory.limit);
    return 0;
}

static void add_some(session *s, int row)
{
    enum { K = 40 };
    box bounds[K];
    msap_handle handles[K];
    msap_boxes boxes = boxes_in_row(bounds);
    int i;
    for (i = 0; i < K; i++)
        bounds[i] = random_box(&s->random, s->scene);
    if (!had_memory(s, msap_add_many(s->world, K, &boxes, NULL, NULL, handles), row))
        return;
    for (i = 0; i < K; i++)
        right(is(handles[i] == reference_add(&s->reference, &bounds[i], 0, NULL)), row, s->memory.limit);
}

/* Each of the live boxes with a chance of 1 in `chance`. */
static void move_some(session *s, uint32_t chance, int row)
{
    size_t i;
    for (i = 0; i < s->reference.slot_count; i++) {
        const slot *from = &s->reference.slots[i];
        box to;
        if (from->state != SLOT_LIVE || random_below(&s->random, chance))
            continue;
        to = random_below(&s->random, 3) ? moved_box(&s->random, s->scene, &from->bounds)
                                         : random_box(&s->random, s->scene);
        right(session_update(s, from->handle, &to), row, s->memory.limit);
    }
}

static void remove_some(session *s, uint32_t chance, int row)
{
    size_t i;
    for (i = 0; i < s->reference.slot_count; i++)
        if (s->reference.slots[i].state == SLOT_LIVE && random_below(&s->random, chance) == 0)
            right(session_remove(s, s->reference.slots[i].handle), row, s->memory.limit);
}

static void *tag(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    const session *s = context;
    (void)data_a;
    (void)data_b;
    return pair_tag(a, b, s->reference.commits + 1);
}

/* Removes boxes until there is memory for what is left. */
static void commit_somehow(session *s, int row)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, tag, NULL};
    callbacks.context = s;
    while (!had_memory(s, msap_commit(s->world, &callbacks, NULL), row)) {
        right(is(s->reference.live > 0), row, s->memory.limit);
        remove_some(s, s->reference.live > 3 ? 3 : 1, row);
    }
    reference_commit(&s->reference);
    right(session_compare(s), row, s->memory.limit);
}

static void grow_under_limit(int row, size_t limit, scene_kind scene)
{
    msap_config config = setup_config(row % 2 ? 2 : 3, row);
    session s;
    int frame;
    right(session_open(&s, &config, limit, scene), row, limit);
    s.memory.limit = s.memory.bytes + limit;
    for (frame = 0; frame < 16; frame++) {
        add_some(&s, row);
        move_some(&s, frame % 3 ? 8 : 2, row);
        commit_somehow(&s, row);
        if (frame % 5 == 4) {
            right(session_trim(&s), row, limit);
            right(session_compare(&s), row, limit);
        }
    }
    failed += s.memory.failures;
    right(session_close(&s), row, limit);
}

/* ----------------------------------------- 2. every allocation of a large scene */

static void add_row(session *s, uint32_t n, int row)
{
    msap_handle handle;
    uint32_t i;
    for (i = 0; i < n; i++) {
        box b = random_box(&s->random, SCENE_SIZES);
        b.min[0] += (float)(i % 64 * 32);
        b.max[0] += (float)(i % 64 * 32);
        right(session_add(s, &b, i % 16 ? 0 : MSAP_STATIC, &handle), row, 0);
    }
}

/* Returns whether it came to an n-th allocation. */
static int large_scene(int row, size_t n, int and_more)
{
    msap_config config = setup_config(3, row);
    session s;
    size_t failures;
    int frame;
    right(session_open(&s, &config, 3, SCENE_SIZES), row, n);
    add_row(&s, 700, row);
    *(and_more ? &s.memory.fail_from : &s.memory.fail_at) = s.memory.calls + n;
    for (frame = 0; frame < 4; frame++) {
        right(session_commit(&s), row, n);
        right(session_compare(&s), row, n);
        move_some(&s, frame == 2 ? 64 : 1, row);
    }
    failures = s.memory.failures;
    failed += failures;
    right(session_close(&s), row, n);
    return failures > 0;
}

/* ----------------------------------------------------- 3. the pair explosion */

static void explode(int row, uint32_t n)
{
    enum { LEFT = 1000 };
    size_t limit = (size_t)64 << 20;
    msap_config config = setup_config(3, row);
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    msap_handle *handles = malloc(n * sizeof *handles);
    tracker memory = {0};
    msap_world *world = NULL;
    msap_boxes boxes;
    box unit = {{0, 0, 0}, {1, 1, 1}};
    msap_status status;
    if (!handles)
        abort();
    boxes = boxes_in_row(&unit);
    boxes.min_row = boxes.max_row = 0; /* one box, n times */
    memory.limit = limit;
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &memory;
    right(is(msap_create(&config, &world) == MSAP_OK), row, limit);
    right(is(msap_add_many(world, n, &boxes, NULL, NULL, handles) == MSAP_OK), row, limit);
    status = msap_commit(world, NULL, &counts);
    right(is(status == MSAP_ERROR_MEMORY && memory.peak <= limit), row, limit);
    right(is(msap_validate(world, NULL) == MSAP_OK), row, limit);
    right(is(msap_remove_many(world, n - LEFT, handles) == MSAP_OK), row, limit);
    right(is(msap_commit(world, NULL, &counts) == MSAP_OK), row, limit);
    right(is(counts.created == LEFT * (LEFT - 1) / 2 && counts.active == counts.created), row, limit);
    right(is(msap_validate(world, NULL) == MSAP_OK), row, limit);
    right(is(msap_destroy(world) == MSAP_OK && memory.bytes == 0 && memory.wrong == 0), row, limit);
    failed += memory.failures;
    free(handles);
}

int main(int argc, char **argv)
{
    unsigned long boxes = argc > 1 ? strtoul(argv[1], NULL, 10) : 20000;
    size_t n;
    int row, and_more;
    for (row = 0; row < SETUPS; row++) {
        for (n = 1000; n < 400000; n += n / 4)
            grow_under_limit(row, n, (scene_kind)(n / 4 % SCENE_COUNT));
        for (and_more = 0; and_more < 2; and_more++)
            for (n = 1; large_scene(row, n, and_more); n++)
                ;
        if (row < 2 || setups[row].jobs == JOBS_POOL) /* the default, the single SAP, and with threads */
            explode(row, (uint32_t)boxes);
    }
    printf("memory limit: %lu allocations failed\n", failed);
    return EXIT_SUCCESS;
}
