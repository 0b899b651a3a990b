/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * What a program can get wrong, and what it is told in a release build: every call
 * below must come to its status, change nothing, and leave the world valid.
 *
 * NULL is the business of test_errors.c, numbers of test_bad_bounds.c and calls from
 * within callbacks of test_callbacks.c. Here are handles of all kinds in every call that
 * takes one, every size of every struct, values that no field may have, counts that
 * overflow, calls from within the allocator and from a second thread while a first one
 * is inside the library, and the end of a world with everything pending.
 *
 * Needs nothing but the C library and POSIX threads. Prints how many calls were refused.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../unit/common.h"
#include "../unit/setups.h"

static unsigned long calls_refused;

#define must(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition); \
            exit(EXIT_FAILURE); \
        } \
    } while (0)

#define refused(call, status) \
    do { \
        must((call) == (status)); \
        calls_refused++; \
    } while (0)

static const box unit = {{0, 0, 0}, {1, 1, 1}};

/* A world with a few pairs, a stale handle and changes pending, and its reference. */
static void open_world(session *s, int row, msap_handle handles[8])
{
    msap_config config = setup_config(3, row);
    int i;
    must(!session_open(s, &config, 1, SCENE_GRID));
    for (i = 0; i < 8; i++)
        must(!session_add(s, &unit, 0, &handles[i]));
    must(!session_commit(s));
    must(!session_remove(s, handles[0]));
    must(!session_commit(s));
    must(!session_remove(s, handles[1]));
    must(!session_update(s, handles[2], &unit));
}

/* ------------------------------------------------------------------ handles */

static void every_call_refuses(const session *s, msap_handle bad)
{
    msap_boxes boxes = boxes_in_row(&unit);
    float bound[3];
    void *data = NULL;
    refused(msap_update(s->world, bad, unit.min, unit.max), MSAP_ERROR_HANDLE);
    refused(msap_update_many(s->world, 1, &bad, &boxes), MSAP_ERROR_HANDLE);
    refused(msap_remove(s->world, bad), MSAP_ERROR_HANDLE);
    refused(msap_remove_many(s->world, 1, &bad), MSAP_ERROR_HANDLE);
    refused(msap_get_bounds(s->world, bad, bound, bound), MSAP_ERROR_HANDLE);
    refused(msap_set_user_data(s->world, 1, &bad, &data), MSAP_ERROR_HANDLE);
    refused(msap_get_pair_data(s->world, 1, &bad, &bad, &data), MSAP_ERROR_NOT_A_PAIR);
    refused(msap_set_pair_data(s->world, 1, &bad, &bad, &data), MSAP_ERROR_NOT_A_PAIR);
}

/* Every single bit of a live handle turned, and what a stray pointer or a small number
 * looks like. */
static void bad_handles(int row)
{
    static const msap_handle garbage[] = {
        0, 1, 2, 0xFFFFFFFF, UINT64_MAX, 0x100000000, 0x7FFFFFFF00000001, 0x8000000000000001, 0xDEADBEEFDEADBEEF, 0x7FFE3A5C1B20,
    };
    msap_handle handles[8], live, bad;
    session s;
    size_t i;
    void *data = NULL;
    open_world(&s, row, handles);
    every_call_refuses(&s, handles[0]); /* removed and reported */
    every_call_refuses(&s, handles[1]); /* removed and not yet reported: its user data can be read */
    refused(msap_get_user_data(s.world, 1, &handles[0], &data), MSAP_ERROR_HANDLE);
    must(msap_get_user_data(s.world, 1, &handles[1], &data) == MSAP_OK);
    for (i = 1; i < COUNT(garbage); i++)
        every_call_refuses(&s, garbage[i]);
    every_call_refuses(&s, MSAP_NULL_HANDLE);
    live = handles[7];
    for (i = 0; i < 64; i++) {
        bad = live ^ (msap_handle)1 << i;
        if (i >= 32 && i < 35) /* another slot that is in use */
            bad = live ^ ((msap_handle)1 << i | 2);
        every_call_refuses(&s, bad);
    }
    must(!session_compare(&s));
    must(!session_close(&s));
}

/* In a batch the first bad one is named and nothing is done. */
static void bad_handles_in_batches(int row)
{
    msap_handle handles[8], batch[4];
    box four[4] = {{{0, 0, 0}, {1, 1, 1}}, {{5, 5, 5}, {6, 6, 6}}, {{5, 5, 5}, {6, 6, 6}}, {{0, 0, 0}, {9, 9, 9}}};
    msap_boxes boxes = boxes_in_row(four);
    msap_error error;
    session s;
    uint64_t bad;
    void *data[4] = {NULL, NULL, NULL, NULL};
    open_world(&s, row, handles);
    error.struct_size = sizeof error;
    for (bad = 0; bad < 4; bad++) {
        memcpy(batch, handles + 3, sizeof batch);
        batch[bad] = handles[0];
        refused(msap_update_many(s.world, 4, batch, &boxes), MSAP_ERROR_HANDLE);
        must(msap_last_error(s.world, &error) == MSAP_OK && error.index == bad);
        refused(msap_remove_many(s.world, 4, batch), MSAP_ERROR_HANDLE);
        must(msap_last_error(s.world, &error) == MSAP_OK && error.index == bad);
        refused(msap_set_user_data(s.world, 4, batch, data), MSAP_ERROR_HANDLE);
        refused(msap_get_user_data(s.world, 4, batch, data), MSAP_ERROR_HANDLE);
        refused(msap_set_pair_data(s.world, 4, batch, handles + 2, data), MSAP_ERROR_NOT_A_PAIR);
        must(!session_compare(&s));
    }
    batch[0] = batch[3] = handles[3];
    refused(msap_remove_many(s.world, 4, batch), MSAP_ERROR_HANDLE);
    must(!session_compare(&s));
    must(!session_close(&s));
}

/* ------------------------------------------------------------------ structs */

/* Every wrong size of a struct up to 1000, and some that are absurd. */
static const uint32_t absurd[] = {0x1000, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};

static uint32_t size_of(uint32_t i) { return i < 1000 ? i : absurd[i - 1000]; }

#define for_sizes(i, right) \
    for (i = 0; i < 1000 + COUNT(absurd); i++) \
        if (size_of(i) != (right))

static void bad_sizes(int row)
{
    msap_config config;
    msap_prune_config prune;
    msap_boxes boxes = boxes_in_row(&unit);
    msap_callbacks callbacks = {0, 0, NULL, NULL, NULL};
    msap_counts counts = {0, 0, 7, 7, 7};
    msap_world_stats stats;
    msap_error error = {0, 0, 7, 7, 0};
    msap_handle handles[8], out = 77;
    msap_index_pair *pairs = NULL;
    msap_world *none = NULL;
    session s;
    size_t count = 77;
    uint32_t i;
    open_world(&s, row, handles);
    for_sizes(i, sizeof config) {
        refused(msap_config_init(&config, size_of(i)), MSAP_ERROR_STRUCT_SIZE);
        must(msap_config_init(&config, sizeof config) == MSAP_OK);
        config.struct_size = size_of(i);
        refused(msap_create(&config, &none), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof prune) {
        refused(msap_prune_config_init(&prune, size_of(i)), MSAP_ERROR_STRUCT_SIZE);
        must(msap_prune_config_init(&prune, sizeof prune) == MSAP_OK);
        prune.struct_size = size_of(i);
        refused(msap_prune(&prune, 1, &boxes, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune_free(&prune, NULL, 0), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof boxes) {
        msap_boxes bad = boxes;
        bad.struct_size = size_of(i);
        refused(msap_add_many(s.world, 1, &bad, NULL, NULL, &out), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_update_many(s.world, 1, &handles[3], &bad), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune(NULL, 1, &bad, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune_bipartite(NULL, 1, &boxes, 1, &bad, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof callbacks) {
        callbacks.struct_size = size_of(i);
        refused(msap_commit(s.world, &callbacks, NULL), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof counts) {
        counts.struct_size = size_of(i);
        refused(msap_commit(s.world, NULL, &counts), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof stats) {
        stats.struct_size = size_of(i);
        refused(msap_stats(s.world, &stats), MSAP_ERROR_STRUCT_SIZE);
    }
    for_sizes(i, sizeof error) {
        error.struct_size = size_of(i);
        refused(msap_last_error(s.world, &error), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune(NULL, 1, &boxes, &pairs, &count, &error), MSAP_ERROR_STRUCT_SIZE);
    }
    must(!none && !pairs && count == 77 && out == 77 && counts.created == 7 && error.index == 7);
    must(!session_compare(&s));
    must(!session_close(&s));
}

/* ------------------------------------------------------------------- values */

/* A config with one field changed. */
#define bad_config(change) \
    do { \
        msap_config c = config; \
        change; \
        refused(msap_create(&c, &none), MSAP_ERROR_CONFIG); \
    } while (0)

static void *never_alloc(void *user, size_t size)
{
    (void)user;
    (void)size;
    return NULL;
}
static void *never_enqueue(void *user, msap_task_fn run, void *task)
{
    (void)user;
    (void)run;
    (void)task;
    return NULL;
}

static void bad_values(int row)
{
    msap_config config = setup_config(3, row);
    msap_world *none = NULL;
    must(config.grid <= MSAP_GRID_FIXED);
    bad_config(c.dims = 0);
    bad_config(c.dims = 1);
    bad_config(c.dims = 4);
    bad_config(c.dims = UINT32_MAX);
    bad_config(c.grid = 3);
    bad_config(c.grid = UINT32_MAX);
    bad_config(c.strategy = 4);
    bad_config(c.filters = 2);
    bad_config(c.simd = 5);
    bad_config(c.max_boxes = MSAP_MAX_BOXES + 1);
    bad_config(c.workers = 0);
    bad_config(c.workers = 65);
    bad_config((c.workers = 2, c.enqueue = NULL, c.finish = NULL));
    bad_config((c.enqueue = never_enqueue, c.finish = NULL));
    bad_config(c.margin = -0.5f);
    bad_config(c.margin = INFINITY);
    bad_config(c.margin = NAN);
    bad_config(c.cell_size = -1);
    bad_config(c.cell_size = NAN);
    bad_config((c.alloc = never_alloc, c.free = NULL));
    bad_config((c.grid = MSAP_GRID_FIXED, c.grid_cells[0] = 0));
    bad_config((c.grid = MSAP_GRID_FIXED, c.grid_cells[2] = 4097));
    bad_config((c.grid = MSAP_GRID_FIXED, c.grid_cells[1] = 2, c.grid_min[1] = 1, c.grid_max[1] = 1));
    bad_config((c.grid = MSAP_GRID_FIXED, c.grid_cells[1] = 2, c.grid_min[1] = NAN));
    bad_config((c.grid = MSAP_GRID_FIXED, c.grid_cells[1] = 2, c.grid_max[1] = INFINITY));
    must(!none);
}

/* -------------------------------------------------------------------- sizes */

/* Counts with which some size or sum overflows. All strides are 0, so that the arrays
 * are never left, and handles have room for one: nothing may be written. */
static void bad_counts(int row)
{
    static const size_t counts[] = {SIZE_MAX, SIZE_MAX - 1, SIZE_MAX / 2 + 1, MSAP_MAX_BOXES + (size_t)1};
    msap_boxes boxes = boxes_in_row(&unit);
    msap_handle handles[8], out = 77;
    msap_index_pair *pairs = NULL;
    size_t count = 77, i;
    session s;
    boxes.min_row = boxes.max_row = 0;
    open_world(&s, row, handles);
    for (i = 0; i < COUNT(counts); i++) {
        refused(msap_add_many(s.world, counts[i], &boxes, NULL, NULL, &out), MSAP_ERROR_FULL);
        refused(msap_prune(NULL, counts[i], &boxes, &pairs, &count, NULL), MSAP_ERROR_FULL);
        refused(msap_prune_bipartite(NULL, 1, &boxes, counts[i], &boxes, &pairs, &count, NULL), MSAP_ERROR_FULL);
        refused(msap_prune_bipartite(NULL, counts[i], &boxes, 1, &boxes, &pairs, &count, NULL), MSAP_ERROR_FULL);
    }
    must(out == 77 && count == 77 && !pairs);
    must(!session_compare(&s));
    must(!session_close(&s));
}

/* -------------------------------------------------- inside, on two threads */

/* A world whose allocator or callback stops inside the library, and another thread that
 * calls it meanwhile. The two never run at the same time: what is tested is that the
 * call is refused, not a race. */
typedef struct meeting {
    msap_world *world;
    msap_handle handle;
    int armed, met;
} meeting;

static void *call_from_outside(void *argument)
{
    meeting *m = argument;
    msap_boxes boxes = boxes_in_row(&unit);
    msap_handle out = 77;
    double offset[3] = {1, 1, 1};
    void *data = m;
    refused(msap_add(m->world, unit.min, unit.max, 0, NULL, &out), MSAP_ERROR_BUSY);
    refused(msap_add_many(m->world, 1, &boxes, NULL, NULL, &out), MSAP_ERROR_BUSY);
    refused(msap_update(m->world, m->handle, unit.min, unit.max), MSAP_ERROR_BUSY);
    refused(msap_update_many(m->world, 1, &m->handle, &boxes), MSAP_ERROR_BUSY);
    refused(msap_remove(m->world, m->handle), MSAP_ERROR_BUSY);
    refused(msap_remove_many(m->world, 1, &m->handle), MSAP_ERROR_BUSY);
    refused(msap_shift_origin(m->world, offset), MSAP_ERROR_BUSY);
    refused(msap_set_user_data(m->world, 1, &m->handle, &data), MSAP_ERROR_BUSY);
    refused(msap_set_pair_data(m->world, 1, &m->handle, &m->handle, &data), MSAP_ERROR_BUSY);
    refused(msap_commit(m->world, NULL, NULL), MSAP_ERROR_BUSY);
    refused(msap_trim(m->world), MSAP_ERROR_BUSY);
    refused(msap_destroy(m->world), MSAP_ERROR_BUSY);
    must(out == 77);
    return NULL;
}

static void meet(meeting *m)
{
    pthread_t other;
    if (!m->armed)
        return;
    m->armed = 0;
    m->met++;
    call_from_outside(m); /* from inside, on this thread */
    must(pthread_create(&other, NULL, call_from_outside, m) == 0 && pthread_join(other, NULL) == 0);
}

static void *meeting_alloc(void *user, size_t size)
{
    meet(user);
    return malloc(size);
}

static void meeting_free(void *user, void *pointer, size_t size)
{
    (void)size;
    meet(user);
    free(pointer);
}

static void *meeting_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    (void)a;
    (void)b;
    (void)data_a;
    (void)data_b;
    meet(context);
    return NULL;
}

static void *meeting_enqueue(void *user, msap_task_fn run, void *task)
{
    meet(user);
    run(task);
    return NULL;
}

static void meeting_finish(void *user, void *ticket)
{
    (void)user;
    (void)ticket;
}

/* Runs `call` with a meeting inside; it must have come to one. */
#define meeting_in(call) \
    do { \
        m.armed = 1; \
        must((call) == MSAP_OK); \
        must(!m.armed); \
    } while (0)

static void busy_worlds(int row)
{
    msap_config config = setup_config(3, row);
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, meeting_create, NULL};
    msap_handle handles[3000];
    meeting m = {NULL, 0, 0, 0};
    box many[3000];
    msap_boxes boxes = boxes_in_row(many);
    size_t i;
    for (i = 0; i < 3000; i++) {
        many[i] = unit;
        many[i].min[0] = (float)(i / 2 * 3);
        many[i].max[0] = many[i].min[0] + 1;
    }
    config.alloc = meeting_alloc;
    config.free = meeting_free;
    config.allocator_user = config.jobs_user = &m;
    config.enqueue = meeting_enqueue;
    config.finish = meeting_finish;
    callbacks.context = &m;
    must(msap_create(&config, &m.world) == MSAP_OK);
    must(msap_add(m.world, unit.min, unit.max, 0, NULL, &m.handle) == MSAP_OK);
    meeting_in(msap_add_many(m.world, 3000, &boxes, NULL, NULL, handles)); /* in its allocations */
    meeting_in(msap_commit(m.world, NULL, NULL));                         /* or in its tasks */
    must(msap_remove_many(m.world, 2990, handles) == MSAP_OK && msap_commit(m.world, NULL, NULL) == MSAP_OK);
    meeting_in(msap_trim(m.world));
    must(msap_add(m.world, unit.min, unit.max, 0, NULL, &handles[0]) == MSAP_OK);
    meeting_in(msap_commit(m.world, &callbacks, NULL)); /* in its callbacks */
    must(msap_validate(m.world, NULL) == MSAP_OK);
    meeting_in(msap_destroy(m.world));
    must(m.met == 5);
}

/* ------------------------------------------------------------------ the end */

/* With events not read, changes pending, and every kind of change among them. */
static void sudden_end(int row)
{
    msap_handle handles[8], handle;
    session s;
    open_world(&s, row, handles);
    must(!session_add(&s, &unit, MSAP_STATIC, &handle));
    must(!session_remove(&s, handle));
    must(!session_close(&s));
}

int main(void)
{
    int row;
    for (row = 0; row < SETUPS; row++) {
        bad_handles(row);
        bad_handles_in_batches(row);
        bad_counts(row);
        sudden_end(row);
        busy_worlds(row);
    }
    bad_sizes(0);
    bad_values(0);
    printf("bad programs: %lu calls refused\n", calls_refused);
    return EXIT_SUCCESS;
}
