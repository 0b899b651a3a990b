/* Calls that must be refused and change nothing (see play.h).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "play.h"

#include <math.h>
#include <string.h>

/* What a refused call must come to. */
typedef struct expected {
    msap_status status;
    uint64_t index;
    uint32_t bound;
} expected;

static void refused(const session *s, msap_status status, expected e)
{
    msap_error error;
    error.struct_size = sizeof error;
    if (status != e.status)
        fuzz_check("a wrong call came to another status");
    if (msap_last_error(s->world, &error) != MSAP_OK || error.status != (uint32_t)status)
        fuzz_check("the last error has another status");
    if (error.index != e.index || error.bound != e.bound)
        fuzz_check("the last error names another box or bound");
}

static expected expect(msap_status status, uint64_t index, uint32_t bound)
{
    expected e = {status, index, bound};
    return e;
}

/* A NaN of any payload and sign in one of the bounds that the world reads. */
static uint32_t spoil(const session *s, box *b, uint32_t argument)
{
    uint32_t axis = argument % s->reference.dims, is_max = argument >> 4 & 1;
    float nan = float_of(0x7F800001u | (argument & 0x100) << 23 | argument << 13);
    if (is_max)
        b->max[axis] = nan;
    else
        b->min[axis] = nan;
    return axis + (is_max ? 3 : 0);
}

static void turn_over(box *b, uint32_t axis)
{
    b->min[axis] = nextafterf(b->max[axis], INFINITY);
    if (b->max[axis] == INFINITY)
        b->max[axis] = 0;
}

static void bad_bounds(session *s, const herd *h, call *c)
{
    msap_handle handle;
    uint32_t axis = c->argument >> 3 & 1;
    box b = {{0, 0, 0}, {1, 1, 1}};
    if (h->count > 0)
        b = h->live[c->argument % h->count].bounds;
    if (c->argument & 4) {
        uint32_t bound = spoil(s, &b, c->argument);
        refused(s, msap_add(s->world, b.min, b.max, 0, NULL, &handle), expect(MSAP_ERROR_NAN, 0, bound));
        return;
    }
    turn_over(&b, axis);
    refused(s, msap_add(s->world, b.min, b.max, 0, NULL, &handle), expect(MSAP_ERROR_INVERTED, 0, axis));
}

/* A batch of updates, or additions, of which one is bad. */
static void bad_bounds_in_batch(session *s, const herd *h, call *c)
{
    size_t i, bad;
    uint32_t bound;
    for (i = 0; i < h->count; i++) {
        c->handles[i] = h->live[i].handle;
        c->bounds[i] = h->live[h->count - 1 - i].bounds;
        c->flags[i] = 0;
    }
    bad = c->argument % h->count;
    bound = spoil(s, &c->bounds[bad], c->argument);
    c->boxes = boxes_in_row(c->bounds);
    if (c->argument & 4)
        refused(s, msap_update_many(s->world, h->count, c->handles, &c->boxes), expect(MSAP_ERROR_NAN, bad, bound));
    else
        refused(s, msap_add_many(s->world, h->count, &c->boxes, c->flags, NULL, c->handles),
                expect(MSAP_ERROR_NAN, bad, bound));
}

/* A batch of which the last handle is stale or comes twice. */
static void bad_handle_in_batch(session *s, const herd *h, call *c)
{
    expected e = expect(MSAP_ERROR_HANDLE, h->count, MSAP_NO_BOUND);
    size_t i;
    for (i = 0; i < h->count; i++) {
        c->handles[i] = h->live[i].handle;
        c->bounds[i] = h->live[h->count - 1 - i].bounds;
    }
    c->handles[h->count] = c->argument & 4 ? h->dead : c->handles[c->argument % h->count];
    c->bounds[h->count] = c->bounds[0];
    c->boxes = boxes_in_row(c->bounds);
    refused(s, msap_remove_many(s->world, h->count + 1, c->handles), e);
    c->handles[h->count] = h->dead;
    refused(s, msap_update_many(s->world, h->count + 1, c->handles, &c->boxes), e);
    refused(s, msap_set_user_data(s->world, h->count + 1, c->handles, c->data), e);
}

static msap_handle bad_handle(const herd *h, uint32_t argument)
{
    msap_handle live = h->count > 0 ? h->live[argument % h->count].handle : 1;
    switch (argument >> 3 & 7) {
    case 0: return MSAP_NULL_HANDLE;
    case 1: return h->dead;
    case 2: return live & 0xFFFFFFFF00000000u;   /* generation 0 */
    case 3: return live | 0xFFFFFFFF00000000u;   /* no such slot */
    case 4: return live ^ 0x80000000u;           /* no such generation */
    case 5: return live ^ 0x8000000000000000u;   /* no such slot */
    default: return UINT64_MAX;
    }
}

static void bad_handles(session *s, const herd *h, call *c)
{
    expected e = expect(MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    msap_handle handle = bad_handle(h, c->argument);
    box b = {{0, 0, 0}, {1, 1, 1}};
    void *data = NULL;
    refused(s, msap_update(s->world, handle, b.min, b.max), e);
    refused(s, msap_remove(s->world, handle), e);
    refused(s, msap_set_user_data(s->world, 1, &handle, &data), e);
    e.status = MSAP_ERROR_NOT_A_PAIR;
    refused(s, msap_set_pair_data(s->world, 1, &handle, &handle, &data), e);
    if (msap_get_bounds(s->world, handle, b.min, b.max) != MSAP_ERROR_HANDLE ||
        msap_get_pair_data(s->world, 1, &handle, &handle, &data) != MSAP_ERROR_NOT_A_PAIR)
        fuzz_check("a bad handle was read");
}

static void bad_arguments(session *s, const herd *h, call *c)
{
    msap_callbacks callbacks = {0, 0, NULL, NULL, NULL};
    msap_counts counts = {0, 0, 0, 0, 0};
    box b = {{0, 0, 0}, {1, 1, 1}};
    msap_boxes boxes = boxes_in_row(&b), none = boxes;
    expected size = expect(MSAP_ERROR_STRUCT_SIZE, 0, MSAP_NO_BOUND);
    double far[3] = {0, 0, 0};
    (void)h;
    callbacks.struct_size = counts.struct_size = boxes.struct_size = c->argument ? c->argument ^ (uint32_t)sizeof boxes : 1;
    refused(s, msap_add_many(s->world, 1, &boxes, NULL, NULL, c->handles), size);
    if (counts.struct_size != sizeof counts)
        refused(s, msap_commit(s->world, NULL, &counts), size);
    if (callbacks.struct_size != sizeof callbacks)
        refused(s, msap_commit(s->world, &callbacks, NULL), size);
    none.min = NULL;
    refused(s, msap_add_many(s->world, 1, &none, NULL, NULL, c->handles), expect(MSAP_ERROR_NULL, 0, MSAP_NO_BOUND));
    none = boxes_in_row(&b);
    none.scalar = 2 + c->argument;
    refused(s, msap_add_many(s->world, 1, &none, NULL, NULL, c->handles), expect(MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND));
    refused(s, msap_add(s->world, b.min, b.max, 2u << c->argument % 31, NULL, c->handles),
            expect(MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND));
    far[c->argument % 2] = c->argument & 4 ? NAN : -INFINITY;
    refused(s, msap_shift_origin(s->world, far), expect(MSAP_ERROR_CONFIG, 0, c->argument % 2));
}

void wrong_call(session *s, const herd *h, call *c)
{
    switch (c->argument >> 8 & 3) {
    case 0: bad_bounds(s, h, c); break;
    case 1: bad_handles(s, h, c); break;
    case 2: bad_arguments(s, h, c); break;
    default:
        if (h->count == 0 || h->count == MOST_BOXES)
            break;
        if (c->argument & 8)
            bad_bounds_in_batch(s, h, c);
        else
            bad_handle_in_batch(s, h, c);
    }
}
