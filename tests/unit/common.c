/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * See common.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "common.h"

#include <stdlib.h>
#include <string.h>

#define TRY(call) \
    do { \
        const char *wrong_ = (call); \
        if (wrong_) \
            return wrong_; \
    } while (0)

/* Room for one element more; the tests give up when memory runs out. */
static void *grow(void *array, size_t *room, size_t count, size_t size)
{
    if (count < *room)
        return array;
    *room = *room ? *room * 2 : 64;
    array = realloc(array, *room * size);
    if (!array)
        abort();
    return array;
}

/* ----------------------------------------------------------- random numbers */

uint64_t random_next(uint64_t *state)
{
    uint64_t x = *state += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

uint32_t random_below(uint64_t *state, uint32_t end)
{
    return (uint32_t)((random_next(state) >> 32) * end >> 32);
}

/* ------------------------------------------------------------------- floats */

float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

uint32_t bits_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits;
}

/* -------------------------------------------------------------------- boxes */

int boxes_overlap(const box *a, const box *b, uint32_t dims)
{
    uint32_t c;
    for (c = 0; c < dims; c++)
        if (!(a->min[c] <= b->max[c] && b->min[c] <= a->max[c]))
            return 0;
    return 1;
}

static float hard_value(uint64_t *state)
{
    static const uint32_t hard[] = {
        0xFF800000, 0xFF7FFFFF, 0xFF7FFFFE, 0xCB189680, 0xBF800001, 0xBF800000, 0xBF7FFFFF, 0x80800000, 0x807FFFFF,
        0x80000002, 0x80000001, 0x80000000, 0x00000000, 0x00000001, 0x00000002, 0x007FFFFF, 0x00800000, 0x3F7FFFFF,
        0x3F800000, 0x3F800001, 0x4B189680, 0x4B189681, 0x7F7FFFFE, 0x7F7FFFFF, 0x7F800000,
    };
    uint32_t bits = (uint32_t)random_next(state);
    if (bits % 4 || (bits & 0x7F800000) == 0x7F800000)
        bits = hard[random_below(state, COUNT(hard))];
    return float_of(bits);
}

static void hard_interval(uint64_t *state, float *min, float *max)
{
    float a = hard_value(state), b = random_below(state, 3) ? hard_value(state) : a;
    *min = a <= b ? a : b;
    *max = a <= b ? b : a;
}

/* Integers in a float: every sum and sixteenth below is exact. */
static void grid_interval(uint64_t *state, uint32_t places, uint32_t sizes, float *min, float *max)
{
    int32_t low = (int32_t)random_below(state, places) - (int32_t)(places / 2);
    *min = (float)low;
    *max = (float)(low + (int32_t)random_below(state, sizes));
}

box random_box(uint64_t *state, scene_kind scene)
{
    box result;
    uint32_t sizes = 0;
    int c;
    for (c = 0; c < 3; c++)
        switch (scene) {
        case SCENE_GRID:
            grid_interval(state, 12, 4, &result.min[c], &result.max[c]);
            break;
        case SCENE_SPREAD:
            grid_interval(state, 1u << 16, 1u << 13, &result.min[c], &result.max[c]);
            break;
        case SCENE_SIZES:
            if (c == 0)
                sizes = 2u << random_below(state, 3) * random_below(state, 5);
            grid_interval(state, 1u << 9, sizes, &result.min[c], &result.max[c]);
            break;
        default:
            hard_interval(state, &result.min[c], &result.max[c]);
        }
    return result;
}

box moved_box(uint64_t *state, scene_kind scene, const box *from)
{
    box result = *from;
    int c;
    if (scene == SCENE_HARD)
        return random_box(state, scene);
    for (c = 0; c < 3; c++) {
        int32_t step = (int32_t)random_below(state, 3) - 1;
        if (scene == SCENE_SPREAD)
            step *= 50;
        if (scene == SCENE_SIZES)
            step = ((int32_t)(from->max[c] - from->min[c]) + c) % 5 - 2;
        result.min[c] += (float)step;
        result.max[c] += (float)step;
    }
    return result;
}

msap_boxes boxes_in_row(const box *boxes)
{
    msap_boxes result = {sizeof result, MSAP_FLOAT, NULL, NULL, sizeof(box), sizeof(float), sizeof(box), sizeof(float)};
    result.min = boxes->min;
    result.max = boxes->max;
    return result;
}

/* ------------------------------------------------------------------- memory */

/* Before every block, as large as a cache line: so what the library asks for begins at
 * one and ends where the block ends, and a sanitizer sees the first byte beyond it. */
typedef union header {
    struct {
        size_t size;
        uint32_t mark;
    } block;
    char line[64];
} header;

#define BLOCK_MARK 0x5A5A1234u

void *tracked_alloc(void *user, size_t size)
{
    tracker *m = user;
    header *h;
    void *line;
    if (!m->calls++)
        m->owner = pthread_self();
    m->foreign += !pthread_equal(m->owner, pthread_self());
    if (m->fail_all || m->calls == m->fail_at || (m->fail_from && m->calls >= m->fail_from) || size > SIZE_MAX / 2 ||
        (m->limit && (size > m->limit || m->bytes > m->limit - size))) {
        m->failures++;
        return NULL;
    }
    if (posix_memalign(&line, sizeof *h, sizeof *h + size))
        abort();
    h = line;
    h->block.size = size;
    h->block.mark = BLOCK_MARK;
    memset(h + 1, 0xA5, size);
    m->blocks++;
    m->bytes += size;
    if (m->peak < m->bytes)
        m->peak = m->bytes;
    return h + 1;
}

void tracked_free(void *user, void *pointer, size_t size)
{
    tracker *m = user;
    header *h = pointer;
    m->foreign += !pthread_equal(m->owner, pthread_self());
    if (!pointer || (--h)->block.mark != BLOCK_MARK || h->block.size != size) {
        m->wrong++;
        return;
    }
    h->block.mark = 0;
    memset(h + 1, 0xDD, size);
    m->blocks--;
    m->bytes -= size;
    free(h);
}

/* ---------------------------------------------------------------- reference */

void reference_open(reference *r, uint32_t dims)
{
    memset(r, 0, sizeof *r);
    r->dims = dims;
    r->first_generation = 1;
}

void reference_close(reference *r)
{
    free(r->slots);
    free(r->removed);
    free(r->freed);
    free(r->pairs);
    free(r->events);
}

slot *reference_slot(reference *r, msap_handle handle)
{
    return &r->slots[handle >> 32];
}

/* The slot that was freed first, or a new one. */
static uint32_t reference_take_slot(reference *r)
{
    uint32_t index = (uint32_t)r->slot_count;
    if (r->freed_count) {
        index = r->freed[0];
        memmove(r->freed, r->freed + 1, --r->freed_count * sizeof *r->freed);
        r->slots[index].handle++;
        return index;
    }
    r->slots = grow(r->slots, &r->slot_room, r->slot_count++, sizeof *r->slots);
    r->slots[index].handle = (msap_handle)index << 32 | r->first_generation;
    return index;
}

msap_handle reference_add(reference *r, const box *bounds, uint32_t flags, void *data)
{
    uint32_t index = reference_take_slot(r);
    slot *s = &r->slots[index];
    s->bounds = *bounds;
    s->flags = flags;
    s->data = data;
    s->state = SLOT_LIVE;
    s->changed = 1;
    r->live++;
    return s->handle;
}

void reference_update(reference *r, msap_handle handle, const box *bounds)
{
    slot *s = reference_slot(r, handle);
    s->bounds = *bounds;
    s->changed = 1;
}

void reference_remove(reference *r, msap_handle handle)
{
    slot *s = reference_slot(r, handle);
    s->state = SLOT_REMOVED;
    s->changed = 1;
    r->removed = grow(r->removed, &r->removed_room, r->removed_count, sizeof *r->removed);
    r->removed[r->removed_count++] = (uint32_t)(handle >> 32);
    r->live--;
}

void *pair_tag(msap_handle a, msap_handle b, size_t commit)
{
    uint64_t mix = a ^ (b << 7) ^ (uint64_t)commit << 13;
    return (void *)(uintptr_t)random_next(&mix);
}

static int pair_order(const msap_pair *p, const msap_pair *q)
{
    if (p->a != q->a)
        return p->a < q->a ? -1 : 1;
    return p->b < q->b ? -1 : p->b > q->b;
}

static void reference_event(reference *r, int created, const msap_pair *pair)
{
    event *e;
    r->events = grow(r->events, &r->event_room, r->event_count, sizeof *r->events);
    e = &r->events[r->event_count++];
    e->created = created;
    e->a = pair->a;
    e->b = pair->b;
    e->data_a = reference_slot(r, pair->a)->data;
    e->data_b = reference_slot(r, pair->b)->data;
    e->pair_data = pair->user_data;
}

/* The live boxes by columns, so that a compiler makes vectors of the loop that asks them all. */
typedef struct columns {
    size_t count;
    float *low[3], *high[3]; /* a component that is not read is 0 */
    uint32_t *is_static, *overlaps;
    const slot **slot;
} columns;

static void *allocate(size_t count, size_t size)
{
    void *array = calloc(count ? count : 1, size);
    if (!array)
        abort();
    return array;
}

static void columns_open(columns *all, const reference *r)
{
    size_t i;
    uint32_t c;
    all->count = 0;
    for (c = 0; c < 3; c++) {
        all->low[c] = allocate(r->slot_count, sizeof *all->low[c]);
        all->high[c] = allocate(r->slot_count, sizeof *all->high[c]);
    }
    all->is_static = allocate(r->slot_count, sizeof *all->is_static);
    all->overlaps = allocate(r->slot_count, sizeof *all->overlaps);
    all->slot = allocate(r->slot_count, sizeof *all->slot);
    for (i = 0; i < r->slot_count; i++) {
        const slot *s = &r->slots[i];
        if (s->state != SLOT_LIVE)
            continue;
        for (c = 0; c < r->dims; c++) {
            all->low[c][all->count] = s->bounds.min[c];
            all->high[c][all->count] = s->bounds.max[c];
        }
        all->is_static[all->count] = (s->flags & MSAP_STATIC) != 0;
        all->slot[all->count++] = s;
    }
}

static void columns_close(columns *all)
{
    uint32_t c;
    for (c = 0; c < 3; c++) {
        free(all->low[c]);
        free(all->high[c]);
    }
    free(all->is_static);
    free(all->overlaps);
    free(all->slot);
}

/* Whether box i and each box after it make a pair. */
static void columns_overlap(const columns *all, size_t i)
{
    const float *restrict x = all->low[0], *restrict y = all->low[1], *restrict z = all->low[2];
    const float *restrict to_x = all->high[0], *restrict to_y = all->high[1], *restrict to_z = all->high[2];
    const uint32_t *restrict is_static = all->is_static;
    uint32_t *restrict overlaps = all->overlaps;
    const float x_i = x[i], y_i = y[i], z_i = z[i], to_x_i = to_x[i], to_y_i = to_y[i], to_z_i = to_z[i];
    const uint32_t static_i = is_static[i];
    size_t j;
    for (j = i + 1; j < all->count; j++)
        overlaps[j] = (uint32_t)((x[j] <= to_x_i) & (x_i <= to_x[j]) & (y[j] <= to_y_i) & (y_i <= to_y[j]) &
                                 (z[j] <= to_z_i) & (z_i <= to_z[j])) &
                      (1 ^ (static_i & is_static[j]));
}

/* All pairs of live boxes; by slot is by handle, as each slot has one box. */
static msap_pair *reference_find(const reference *r, size_t *count, size_t *room)
{
    msap_pair *pairs = NULL;
    columns all;
    size_t i, j;
    *count = *room = 0;
    columns_open(&all, r);
    for (i = 0; i < all.count; i++) {
        columns_overlap(&all, i);
        for (j = i + 1; j < all.count; j++)
            if (all.overlaps[j]) {
                msap_pair *p;
                pairs = grow(pairs, room, *count, sizeof *pairs);
                p = &pairs[(*count)++];
                p->a = all.slot[i]->handle;
                p->b = all.slot[j]->handle;
                p->user_data = pair_tag(p->a, p->b, r->commits);
            }
    }
    columns_close(&all);
    return pairs;
}

/* Events for the pairs of `from` that are not in `other`; a pair of both has the
 * user data of the older. Both are sorted. */
static void reference_difference(reference *r, msap_pair *from, size_t from_count, const msap_pair *other,
                                 size_t other_count, int created)
{
    size_t i, j = 0;
    for (i = 0; i < from_count; i++) {
        while (j < other_count && pair_order(&other[j], &from[i]) < 0)
            j++;
        if (j == other_count || pair_order(&other[j], &from[i]) != 0)
            reference_event(r, created, &from[i]);
        else if (created)
            from[i].user_data = other[j].user_data;
    }
}

static void reference_free_removed(reference *r)
{
    size_t i;
    for (i = 0; i < r->removed_count; i++) {
        r->slots[r->removed[i]].state = SLOT_FREE;
        r->freed = grow(r->freed, &r->freed_room, r->freed_count, sizeof *r->freed);
        r->freed[r->freed_count++] = r->removed[i];
    }
    r->removed_count = 0;
    for (i = 0; i < r->slot_count; i++)
        r->slots[i].changed = 0;
}

void reference_trim(reference *r)
{
    size_t i, kept = 0;
    while (r->slot_count && r->slots[r->slot_count - 1].state == SLOT_FREE) {
        uint32_t next = (uint32_t)r->slots[--r->slot_count].handle + 1;
        if (r->first_generation < next)
            r->first_generation = next;
    }
    for (i = 0; i < r->freed_count; i++)
        if (r->freed[i] < r->slot_count)
            r->freed[kept++] = r->freed[i];
    r->freed_count = kept;
}

/* A world in which fewer than an eighth of many slots were live for long trims
 * itself, once there are no events to keep. */
static void reference_idle(reference *r)
{
    int is_idle = r->slot_count > 1024 && r->live < r->slot_count / 8;
    r->idle = is_idle ? r->idle + 1 : 0;
    if (r->idle < 256 || r->event_count)
        return;
    reference_trim(r);
    r->idle = 0;
}

void reference_commit(reference *r)
{
    size_t count, room;
    msap_pair *pairs;
    r->commits++;
    r->event_count = 0;
    pairs = reference_find(r, &count, &room);
    reference_difference(r, r->pairs, r->pair_count, pairs, count, 0);
    reference_difference(r, pairs, count, r->pairs, r->pair_count, 1);
    reference_free_removed(r);
    free(r->pairs);
    r->pairs = pairs;
    r->pair_count = count;
    r->pair_room = room;
    reference_idle(r);
}

/* ------------------------------------------------------------------ session */

const char *session_open(session *s, const msap_config *config, uint64_t seed, scene_kind scene)
{
    msap_config own;
    memset(s, 0, sizeof *s);
    s->random = seed;
    s->scene = scene;
    s->next_tag = 1;
    s->statics = 4;
    msap_config_init(&own, sizeof own);
    if (config)
        own = *config;
    own.alloc = tracked_alloc;
    own.free = tracked_free;
    own.allocator_user = &s->memory;
    reference_open(&s->reference, own.dims);
    return msap_create(&own, &s->world) == MSAP_OK ? NULL : "msap_create failed";
}

const char *session_close(session *s)
{
    msap_status status = msap_destroy(s->world);
    reference_close(&s->reference);
    free(s->events);
    if (status != MSAP_OK)
        return "msap_destroy failed";
    if (s->memory.wrong)
        return "a block was freed with another size than it was allocated with";
    if (s->memory.foreign)
        return "the allocator was called on another thread";
    return s->memory.blocks || s->memory.bytes ? "memory leaked" : NULL;
}

/* Whether the call that came to `status` is to be called again: it was made to fail.
 * It must have changed nothing. */
static int session_again(session *s, msap_status status)
{
    if (status != MSAP_ERROR_MEMORY || s->memory.fail_all || s->failures == s->memory.failures)
        return 0;
    s->failures = s->memory.failures;
    s->memory.fail_from = 0;
    if (!s->wrong)
        s->wrong = session_compare(s);
    return 1;
}

const char *session_add(session *s, const box *bounds, uint32_t flags, msap_handle *handle)
{
    void *data = (void *)s->next_tag++;
    msap_status status;
    *handle = MSAP_NULL_HANDLE;
    do
        status = msap_add(s->world, bounds->min, bounds->max, flags, data, handle);
    while (session_again(s, status));
    if (status != MSAP_OK)
        return "msap_add failed";
    if (*handle != reference_add(&s->reference, bounds, flags, data))
        return "msap_add gave another handle than the contract says";
    return NULL;
}

const char *session_update(session *s, msap_handle handle, const box *bounds)
{
    if (msap_update(s->world, handle, bounds->min, bounds->max) != MSAP_OK)
        return "msap_update failed";
    reference_update(&s->reference, handle, bounds);
    return NULL;
}

const char *session_remove(session *s, msap_handle handle)
{
    if (msap_remove(s->world, handle) != MSAP_OK)
        return "msap_remove failed";
    reference_remove(&s->reference, handle);
    return NULL;
}

#define BATCH 16

static uint32_t random_flags(session *s)
{
    return random_below(&s->random, 16) < s->statics ? MSAP_STATIC : 0;
}

static const char *session_add_batch(session *s, uint32_t k)
{
    box bounds[BATCH];
    uint32_t flags[BATCH], i;
    void *data[BATCH];
    msap_handle handles[BATCH];
    msap_boxes boxes;
    msap_status status;
    for (i = 0; i < k; i++) {
        bounds[i] = random_box(&s->random, s->scene);
        flags[i] = random_flags(s);
        data[i] = (void *)s->next_tag++;
    }
    boxes = boxes_in_row(bounds);
    do
        status = msap_add_many(s->world, k, &boxes, flags, data, handles);
    while (session_again(s, status));
    if (status != MSAP_OK)
        return "msap_add_many failed";
    for (i = 0; i < k; i++)
        if (handles[i] != reference_add(&s->reference, &bounds[i], flags[i], data[i]))
            return "msap_add_many gave another handle than the contract says";
    return NULL;
}

static const char *session_add_boxes(session *s, uint32_t k)
{
    while (k) {
        uint32_t batch = 1 + random_below(&s->random, k < BATCH ? k : BATCH);
        if (batch == 1) {
            box bounds = random_box(&s->random, s->scene);
            msap_handle handle;
            TRY(session_add(s, &bounds, random_flags(s), &handle));
        } else
            TRY(session_add_batch(s, batch));
        k -= batch;
    }
    return NULL;
}

static const char *session_update_batch(session *s, size_t k, const msap_handle *handles, const box *bounds)
{
    msap_boxes boxes = boxes_in_row(bounds);
    size_t i;
    if (k == 1)
        return session_update(s, handles[0], bounds);
    if (msap_update_many(s->world, k, handles, &boxes) != MSAP_OK)
        return "msap_update_many failed";
    for (i = 0; i < k; i++)
        reference_update(&s->reference, handles[i], &bounds[i]);
    return NULL;
}

/* About `percent` of the live boxes get new bounds, a few of them twice. */
static const char *session_update_boxes(session *s, uint32_t percent, int far)
{
    msap_handle handles[BATCH];
    box bounds[BATCH];
    size_t i, k = 0;
    for (i = 0; i < s->reference.slot_count; i++) {
        const slot *from = &s->reference.slots[i];
        if (from->state != SLOT_LIVE || random_below(&s->random, 100) >= percent)
            continue;
        handles[k] = from->handle;
        bounds[k++] = far ? random_box(&s->random, s->scene) : moved_box(&s->random, s->scene, &from->bounds);
        if (random_below(&s->random, 20) == 0)
            i--;
        if (k == BATCH || random_below(&s->random, 8) == 0) {
            TRY(session_update_batch(s, k, handles, bounds));
            k = 0;
        }
    }
    return k ? session_update_batch(s, k, handles, bounds) : NULL;
}

static const char *session_remove_batch(session *s, size_t k, const msap_handle *handles)
{
    size_t i;
    if (k == 1)
        return session_remove(s, handles[0]);
    if (msap_remove_many(s->world, k, handles) != MSAP_OK)
        return "msap_remove_many failed";
    for (i = 0; i < k; i++)
        reference_remove(&s->reference, handles[i]);
    return NULL;
}

static const char *session_remove_boxes(session *s, uint32_t percent)
{
    msap_handle handles[BATCH];
    size_t i, k = 0;
    for (i = 0; i < s->reference.slot_count; i++) {
        const slot *from = &s->reference.slots[i];
        if (from->state != SLOT_LIVE || random_below(&s->random, 100) >= percent)
            continue;
        handles[k++] = from->handle;
        if (k == BATCH || random_below(&s->random, 4) == 0) {
            TRY(session_remove_batch(s, k, handles));
            k = 0;
        }
    }
    return k ? session_remove_batch(s, k, handles) : NULL;
}

const char *session_change(session *s, uint32_t boxes)
{
    static const uint32_t updates[] = {0, 2, 10, 50, 100, 100}, removals[] = {0, 0, 0, 3, 10, 50, 100};
    uint32_t rounds = random_below(&s->random, 3);
    while (rounds--) {
        uint32_t missing = boxes > s->reference.live ? boxes - (uint32_t)s->reference.live : 0;
        uint32_t additions = random_below(&s->random, missing + 1);
        uint32_t update = updates[random_below(&s->random, COUNT(updates))];
        uint32_t removal = removals[random_below(&s->random, COUNT(removals))];
        int far = random_below(&s->random, 3) == 0;
        TRY(session_add_boxes(s, additions));
        TRY(session_update_boxes(s, update, far));
        TRY(session_remove_boxes(s, removal));
    }
    return s->wrong;
}

const char *session_step(session *s, uint32_t boxes)
{
    TRY(session_change(s, boxes));
    TRY(session_commit(s));
    return session_compare(s);
}

/* ------------------------------------------------------ session: the commit */

static event *session_event(session *s, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    event *e;
    s->events = grow(s->events, &s->event_room, s->event_count, sizeof *s->events);
    e = &s->events[s->event_count++];
    e->a = a;
    e->b = b;
    e->data_a = data_a;
    e->data_b = data_b;
    return e;
}

static void *session_on_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    session *s = context;
    event *e = session_event(s, a, b, data_a, data_b);
    e->created = 1;
    return e->pair_data = pair_tag(a, b, s->reference.commits + 1);
}

static void session_on_delete(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b,
                              void *pair_data)
{
    event *e = session_event(context, a, b, data_a, data_b);
    e->created = 0;
    e->pair_data = pair_data;
}

static const char *compare_callbacks(const session *s)
{
    size_t i;
    const reference *r = &s->reference;
    for (i = 0; i < s->event_count && i < r->event_count; i++) {
        const event *e = &s->events[i], *f = &r->events[i];
        if (e->created != f->created || e->a != f->a || e->b != f->b)
            return "a callback's event is not the reference's";
        if (e->data_a != f->data_a || e->data_b != f->data_b)
            return "a callback got wrong user data of a box";
        if (e->pair_data != f->pair_data)
            return "a delete callback got wrong user data of the pair";
    }
    return s->event_count == r->event_count ? NULL : "there were not as many callbacks as events in the reference";
}

/* An array of events with those of the reference from `first` to before `end`. */
static const char *compare_array(const reference *r, size_t first, size_t end, const msap_pair *pairs, size_t count)
{
    size_t i;
    if (count != end - first)
        return "an event array is not as long as the reference's";
    for (i = 0; i < count; i++) {
        const event *e = &r->events[first + i];
        if (e->a != pairs[i].a || e->b != pairs[i].b)
            return "an event array has another pair than the reference";
        if (e->pair_data != pairs[i].user_data)
            return "an event array has other user data than the callback";
    }
    return NULL;
}

/* The last commit's events as arrays. */
static const char *compare_arrays(const session *s)
{
    const reference *r = &s->reference;
    const msap_pair *created, *deleted;
    size_t created_count, deleted_count, deletes = 0;
    while (deletes < r->event_count && !r->events[deletes].created)
        deletes++;
    if (msap_created(s->world, &created, &created_count) || msap_deleted(s->world, &deleted, &deleted_count))
        return "the events could not be read";
    TRY(compare_array(r, 0, deletes, deleted, deleted_count));
    return compare_array(r, deletes, r->event_count, created, created_count);
}

static const char *compare_counts(const session *s, const msap_counts *counts)
{
    const reference *r = &s->reference;
    size_t i, created = 0;
    for (i = 0; i < r->event_count; i++)
        created += r->events[i].created != 0;
    if (counts->created != created || counts->deleted != r->event_count - created || counts->active != r->pair_count)
        return "the counts of the commit are not the reference's";
    return NULL;
}

const char *session_commit(session *s)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, session_on_create, session_on_delete};
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    msap_status status;
    callbacks.context = s;
    s->event_count = 0;
    do {
        status = msap_commit(s->world, &callbacks, &counts);
        if (status != MSAP_OK && s->event_count)
            return "a commit that failed had called back";
    } while (session_again(s, status));
    if (status != MSAP_OK)
        return "msap_commit failed";
    reference_commit(&s->reference);
    TRY(s->wrong);
    TRY(compare_callbacks(s));
    return compare_counts(s, &counts);
}

const char *session_trim(session *s)
{
    if (msap_trim(s->world) != MSAP_OK)
        return "msap_trim failed";
    s->reference.event_count = 0;
    reference_trim(&s->reference);
    return NULL;
}

/* -------------------------------------------------- session: the comparison */

static int compare_pairs(const void *p, const void *q)
{
    return pair_order(p, q);
}

/* Sorts few pairs. */
static void insert_pairs(msap_pair *pairs, size_t count)
{
    size_t i, k;
    for (i = 1; i < count; i++) {
        const msap_pair inserted = pairs[i];
        for (k = i; k > 0 && pair_order(&pairs[k - 1], &inserted) > 0; k--)
            pairs[k] = pairs[k - 1];
        pairs[k] = inserted;
    }
}

/* A sorted copy of pairs, or NULL if one of them names no slot: by the lower box first, of which most have few. */
static msap_pair *sorted_pairs(const msap_pair *pairs, size_t count, size_t slots)
{
    enum { FEW = 32 };
    msap_pair *sorted = malloc(count * sizeof *sorted);
    size_t *end = calloc(slots + 1, sizeof *end), i;
    if (!sorted || !end)
        abort();
    for (i = 0; i < count && pairs[i].a >> 32 < slots; i++)
        end[(pairs[i].a >> 32) + 1]++;
    for (slots = i < count ? 0 : slots, i = 0; i < slots; i++)
        end[i + 1] += end[i];
    for (i = 0; i < count && slots > 0; i++)
        sorted[end[pairs[i].a >> 32]++] = pairs[i]; /* ends are where the next ones start then */
    for (i = 0; i < slots; i++) {
        size_t start = i > 0 ? end[i - 1] : 0, n = end[i] - start;
        if (n > FEW)
            qsort(sorted + start, n, sizeof *sorted, compare_pairs);
        else
            insert_pairs(sorted + start, n);
    }
    free(end);
    if (slots > 0)
        return sorted;
    free(sorted);
    return NULL;
}

static const char *compare_active(const session *s)
{
    const reference *r = &s->reference;
    const msap_pair *pairs;
    msap_pair *sorted;
    size_t count, i;
    const char *wrong = NULL;
    if (msap_pairs(s->world, &pairs, &count) != MSAP_OK)
        return "the pairs could not be read";
    if (count != r->pair_count)
        return "there are not as many active pairs as in the reference";
    if (!count)
        return NULL;
    sorted = sorted_pairs(pairs, count, r->slot_count);
    if (!sorted)
        return "an active pair names no slot";
    for (i = 0; i < count && !wrong; i++)
        if (pair_order(&sorted[i], &r->pairs[i]) != 0)
            wrong = "an active pair is not the reference's";
        else if (sorted[i].user_data != r->pairs[i].user_data)
            wrong = "an active pair has wrong user data";
    free(sorted);
    return wrong;
}

static const char *compare_box(const session *s, const slot *expected)
{
    box bounds;
    void *data = NULL;
    uint32_t c;
    msap_status status = msap_get_user_data(s->world, 1, &expected->handle, &data);
    if (status != (expected->state == SLOT_FREE ? MSAP_ERROR_HANDLE : MSAP_OK))
        return "msap_get_user_data has another opinion on which handles are alive";
    if (status == MSAP_OK && data != expected->data)
        return "a box has wrong user data";
    status = msap_get_bounds(s->world, expected->handle, bounds.min, bounds.max);
    if (status != (expected->state == SLOT_LIVE ? MSAP_OK : MSAP_ERROR_HANDLE))
        return "msap_get_bounds has another opinion on which handles are alive";
    for (c = 0; c < s->reference.dims && status == MSAP_OK; c++)
        if (bounds.min[c] != expected->bounds.min[c] || bounds.max[c] != expected->bounds.max[c])
            return "a box has wrong bounds";
    return NULL;
}

static const char *compare_stats(const session *s)
{
    msap_world_stats stats;
    size_t i, pending = 0;
    stats.struct_size = sizeof stats;
    if (msap_stats(s->world, &stats) != MSAP_OK)
        return "msap_stats failed";
    for (i = 0; i < s->reference.slot_count; i++)
        pending += s->reference.slots[i].changed != 0;
    if (stats.boxes != s->reference.live || stats.pairs != s->reference.pair_count)
        return "msap_stats counts other boxes or pairs than the reference";
    if (stats.pending != pending)
        return "msap_stats counts other pending boxes than the reference";
    if (stats.commits != s->reference.commits)
        return "msap_stats counts other commits than there were";
    if (stats.bytes != s->memory.bytes || stats.bytes_peak != s->memory.peak)
        return "msap_stats counts other bytes than the allocator";
    return NULL;
}

const char *session_compare(session *s)
{
    const char *what = NULL;
    size_t i;
    if (msap_validate(s->world, &what) != MSAP_OK)
        return what ? what : "msap_validate found something but did not say what";
    for (i = 0; i < s->reference.slot_count; i++)
        TRY(compare_box(s, &s->reference.slots[i]));
    TRY(compare_stats(s));
    TRY(compare_arrays(s));
    return compare_active(s);
}
