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

/* A call that was made to fail may say so, before it sees what is wrong. */
static int lacked_memory(session *s, msap_status status)
{
    int is_new = s->memory.failures > s->failures;
    s->failures = s->memory.failures;
    return is_new && status == MSAP_ERROR_MEMORY;
}

static void refused(session *s, msap_status status, expected e)
{
    msap_error error;
    error.struct_size = sizeof error;
    if (lacked_memory(s, status))
        return;
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
    c->boxes = lay_out(c->bounds, h->count, c->argument >> 10);
    if (c->argument & 4)
        refused(s, msap_update_many(s->world, h->count, c->handles, &c->boxes),
                expect(MSAP_ERROR_NAN, bad, bound));
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
    c->boxes = lay_out(c->bounds, h->count + 1, c->argument >> 10);
    refused(s, msap_remove_many(s->world, h->count + 1, c->handles), e);
    c->handles[h->count] = h->dead;
    refused(s, msap_update_many(s->world, h->count + 1, c->handles, &c->boxes), e);
    refused(s, msap_set_user_data(s->world, h->count + 1, c->handles, c->data), e);
}

/* More boxes than the world may hold: the first that has no place is named. */
static void too_many(session *s, const herd *h, call *c)
{
    size_t places = BOX_LIMIT(h->most) - h->count, k = places + 1 + c->argument % 8;
    memset(c->bounds, 0, k * sizeof *c->bounds);
    c->boxes = lay_out(c->bounds, k, c->argument >> 10);
    refused(s, msap_add_many(s->world, k, &c->boxes, NULL, NULL, c->handles),
            expect(MSAP_ERROR_FULL, places, MSAP_NO_BOUND));
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
    boxes.struct_size = c->argument ? c->argument ^ (uint32_t)sizeof boxes : 1;
    callbacks.struct_size = counts.struct_size = boxes.struct_size;
    refused(s, msap_add_many(s->world, 1, &boxes, NULL, NULL, c->handles), size);
    if (counts.struct_size != sizeof counts)
        refused(s, msap_commit(s->world, NULL, &counts), size);
    if (callbacks.struct_size != sizeof callbacks)
        refused(s, msap_commit(s->world, &callbacks, NULL), size);
    none.min = NULL;
    refused(s, msap_add_many(s->world, 1, &none, NULL, NULL, c->handles),
            expect(MSAP_ERROR_NULL, 0, MSAP_NO_BOUND));
    none = boxes_in_row(&b);
    none.scalar = 2 + c->argument;
    refused(s, msap_add_many(s->world, 1, &none, NULL, NULL, c->handles),
            expect(MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND));
    refused(s, msap_add(s->world, b.min, b.max, 2u << c->argument % 31, NULL, c->handles),
            expect(MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND));
    far[c->argument % 2] = c->argument & 4 ? NAN : -INFINITY;
    refused(s, msap_shift_origin(s->world, far), expect(MSAP_ERROR_CONFIG, 0, c->argument % 2));
}

/* ------------------------------------------------------------------ set-ups */

/* Spoils one field of a config; returns what creation must come to. */
static msap_status spoil_config(msap_config *config, uint32_t argument)
{
    uint32_t n = argument >> 4 & 15;
    switch (argument & 15) {
    case 0: config->struct_size ^= 1 + n; return MSAP_ERROR_STRUCT_SIZE;
    case 1: config->dims = n & 1 ? 4 + n : n & 2 ? 0 : 1; break;
    case 2: config->grid = MSAP_GRID_FIXED + 1 + n; break;
    case 3: config->strategy = MSAP_STRATEGY_SWEEP + 1 + n; break;
    case 4: config->filters = 2 + n; break;
    case 5: config->simd = MSAP_SIMD_512 + 1 + n; break;
    case 6: config->max_boxes = MSAP_MAX_BOXES + 1 + n; break;
    case 7: config->workers = n & 1 ? 0 : 65 + n; break;
    case 8: config->margin = n & 1 ? NAN : n & 2 ? -0.5f : INFINITY; break;
    case 9: config->cell_size = n & 1 ? NAN : n & 2 ? -1 : INFINITY; break;
    case 10: config->alloc = NULL; break;
    case 11: config->free = NULL; break;
    case 12: config->workers = 2; break; /* without jobs */
    case 13:
        config->grid = MSAP_GRID_FIXED;
        config->grid_cells[n & 1] = n & 2 ? 0 : 4097 + n;
        break;
    case 14:
        config->grid = MSAP_GRID_FIXED;
        config->grid_cells[n & 1] = 2;
        config->grid_max[n & 1] = n & 2 ? NAN : 0;
        break;
    default: ((tracker *)config->allocator_user)->fail_all = 1; return MSAP_ERROR_MEMORY;
    }
    return MSAP_ERROR_CONFIG;
}

/* A world that cannot be made; and what has no arguments, or one. */
static void bad_set_up(session *s, const herd *h, call *c)
{
    tracker memory = {0};
    msap_config config;
    msap_world *world = s->world;
    msap_status expected, number = (msap_status)c->argument;
    (void)h;
    if (msap_config_init(&config, sizeof config + 1 + c->argument) != MSAP_ERROR_STRUCT_SIZE ||
        msap_config_init(&config, sizeof config) != MSAP_OK)
        fuzz_check("msap_config_init came to another status");
    config.alloc = tracked_alloc;
    config.free = tracked_free;
    config.allocator_user = &memory;
    expected = spoil_config(&config, c->argument);
    if (msap_create(&config, &world) != expected || world != s->world || memory.blocks)
        fuzz_check("a bad config made a world, or came to another status");
    if (!*msap_status_text(number) || !*msap_version_text() || msap_version() != MSAP_VERSION_NUMBER)
        fuzz_check("a text is empty, or the version another");
}

/* ------------------------------------------------------------------- inside */

static msap_status change_inside(session *s, msap_handle a, msap_handle b, uint32_t which)
{
    static const double nowhere[3] = {1, 2, 3};
    box bounds = {{0, 0, 0}, {1, 1, 1}};
    msap_boxes boxes = boxes_in_row(&bounds);
    msap_handle handle;
    void *data = NULL;
    switch (which % 12) {
    case 0: return msap_add(s->world, bounds.min, bounds.max, 0, NULL, &handle);
    case 1: return msap_add_many(s->world, 1, &boxes, NULL, NULL, &handle);
    case 2: return msap_update(s->world, a, bounds.min, bounds.max);
    case 3: return msap_update_many(s->world, 1, &b, &boxes);
    case 4: return msap_remove(s->world, b);
    case 5: return msap_remove_many(s->world, 1, &a);
    case 6: return msap_shift_origin(s->world, nowhere);
    case 7: return msap_set_user_data(s->world, 1, &a, &data);
    case 8: return msap_set_pair_data(s->world, 1, &a, &b, &data);
    case 9: return msap_commit(s->world, NULL, NULL);
    case 10: return msap_trim(s->world);
    default: return msap_destroy(s->world);
    }
}

void call_inside(session *s, msap_handle a, msap_handle b, uint32_t argument)
{
    msap_handle both[2];
    void *data[2];
    both[0] = a;
    both[1] = b;
    refused(s, change_inside(s, a, b, argument), expect(MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND));
    if (msap_validate(s->world, NULL) != MSAP_OK || msap_get_user_data(s->world, 2, both, data) != MSAP_OK)
        fuzz_check("a world cannot be read from inside a callback");
}

/* -------------------------------------------------------------------- whole */

void wrong_call(session *s, const herd *h, call *c)
{
    static void (*const wrong[])(session *, const herd *, call *) = {
        bad_bounds, bad_handles, bad_arguments, bad_bounds_in_batch, bad_handle_in_batch, too_many, bad_set_up,
    };
    uint32_t which = (c->argument >> 8) % COUNT(wrong);
    if (h->count > 0 || (wrong[which] != bad_bounds_in_batch && wrong[which] != bad_handle_in_batch))
        wrong[which](s, h, c);
}
