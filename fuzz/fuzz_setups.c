/* Harness: large scenes in several set-ups at once, which must agree on every handle,
 * bound, event and pair, and on the order of the pairs.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The first world has it easy. The second is called with another rounding mode, and
 * with subnormals flushed to zero, as the input says; the third runs out of memory
 * when the input says so. There is no brute force here, so that scenes may be large
 * enough for tasks, levels and the pruning of everything.
 */
#include "scene.h"

#include <fenv.h>
#include <string.h>
#if defined(__SSE__)
#include <xmmintrin.h>
#endif

enum { WORLDS = 3, MOST = 1200, PATIENCE = 16000 };

typedef struct rival {
    msap_world *world;
    tracker memory;
} rival;

typedef struct contest {
    rival rivals[WORLDS];
    herd herd;
    call call;
    uint32_t environment; /* of the second world */
    uint32_t dims;
    uint64_t work;
} contest;

/* -------------------------------------------------------------- environment */

enum { FLUSH_BITS = 0x8040 };

static void enter_environment(uint32_t environment)
{
    static const int modes[] = {FE_TONEAREST, FE_DOWNWARD, FE_UPWARD, FE_TOWARDZERO};
    fesetround(modes[environment % COUNT(modes)]);
#if defined(__SSE__)
    if (environment & 4)
        _mm_setcsr(_mm_getcsr() | FLUSH_BITS);
#endif
}

static void leave_environment(void)
{
    fesetround(FE_TONEAREST);
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() & ~(unsigned)FLUSH_BITS);
#endif
}

/* -------------------------------------------------------------------- calls */

static void is_valid(const rival *r)
{
    const char *what = NULL;
    if (msap_validate(r->world, &what) != MSAP_OK)
        fuzz_check(what ? what : "a world is broken");
}

/* Makes the call, again if it was made to fail; the world is valid in between. */
static void call_rival(contest *t, int number, msap_handle *handles)
{
    rival *r = &t->rivals[number];
    msap_status status;
    for (;;) {
        size_t failures = r->memory.failures;
        if (number == 1)
            enter_environment(t->environment);
        status = carry_out(r->world, &t->call, handles);
        leave_environment();
        if (status != MSAP_ERROR_MEMORY || r->memory.failures == failures)
            break;
        r->memory.fail_from = r->memory.limit = 0;
        is_valid(r);
    }
    if (status != MSAP_OK)
        fuzz_check("a call failed");
}

/* --------------------------------------------------------------- comparison */

static void same_array(const contest *t, msap_status (*read)(const msap_world *, const msap_pair **, size_t *),
                       const char *wrong)
{
    const msap_pair *pairs[WORLDS];
    size_t count[WORLDS];
    int i;
    for (i = 0; i < WORLDS; i++) {
        if (read(t->rivals[i].world, &pairs[i], &count[i]) != MSAP_OK)
            fuzz_check("an array could not be read");
        if (count[i] != count[0] || (count[0] > 0 && memcmp(pairs[i], pairs[0], count[0] * sizeof **pairs) != 0))
            fuzz_check(wrong);
    }
}

static void compare_commits(contest *t)
{
    int i;
    same_array(t, msap_deleted, "worlds disagree on the deleted pairs");
    same_array(t, msap_created, "worlds disagree on the created pairs");
    same_array(t, msap_pairs, "worlds disagree on the pairs or their order");
    for (i = 0; i < WORLDS; i++) {
        msap_world_stats stats;
        stats.struct_size = sizeof stats;
        is_valid(&t->rivals[i]);
        if (msap_stats(t->rivals[i].world, &stats) != MSAP_OK || stats.boxes != t->herd.count)
            fuzz_check("a world has lost count of its boxes");
        t->work += stats.boxes + stats.touched + stats.candidates;
    }
}

/* After a shift: and the herd learns the new bounds. */
static void compare_bounds(contest *t)
{
    size_t i, size = t->dims * sizeof(float);
    int world;
    for (i = 0; i < t->herd.count; i++) {
        struct member *m = &t->herd.live[i];
        for (world = 0; world < WORLDS; world++) {
            box b;
            if (msap_get_bounds(t->rivals[world].world, m->handle, b.min, b.max) != MSAP_OK)
                fuzz_check("msap_get_bounds failed");
            if (world > 0 && (memcmp(b.min, m->bounds.min, size) != 0 || memcmp(b.max, m->bounds.max, size) != 0))
                fuzz_check("worlds disagree on the bounds of a box");
            memcpy(m->bounds.min, b.min, size);
            memcpy(m->bounds.max, b.max, size);
        }
    }
}

/* -------------------------------------------------------------------- whole */

/* So many commits without a change that worlds trim themselves. */
static void rest(contest *t)
{
    enum { LONG = 260 };
    int i, n;
    t->call.kind = CALL_COMMIT;
    for (i = 0; i < WORLDS; i++)
        for (n = 0; n < LONG; n++)
            call_rival(t, i, NULL);
    compare_commits(t);
}

static void plan_trouble(contest *t)
{
    tracker *m = &t->rivals[2].memory;
    uint32_t n = t->call.argument >> 3;
    switch (t->call.argument & 7) {
    case 0: m->fail_at = m->calls + 1 + n % 64; break;
    case 1: m->fail_from = m->calls + 1 + n % 64; break;
    case 2: m->limit = m->bytes + 1 + 16 * n; break;
    case 3: rest(t); break;
    default: t->environment = n; break;
    }
}

static void next_call(contest *t)
{
    static msap_handle handles[MOST_BOXES];
    int i;
    for (i = 0; i < WORLDS; i++) {
        memset(handles, 0, t->call.k * sizeof *handles);
        call_rival(t, i, handles);
        if (t->call.kind != CALL_ADD && t->call.kind != CALL_ADD_MANY)
            continue;
        if (i > 0 && memcmp(handles, t->call.handles, t->call.k * sizeof *handles) != 0)
            fuzz_check("worlds disagree on the handles");
        memcpy(t->call.handles, handles, t->call.k * sizeof *handles);
    }
    herd_follow(&t->herd, &t->call);
    if (t->call.kind == CALL_SHIFT)
        compare_bounds(t);
    if (t->call.kind == CALL_COMMIT || t->call.kind == CALL_TRIM)
        compare_commits(t);
    if (t->call.kind == CALL_OTHER)
        plan_trouble(t);
}

/* Whether there are too many pairs for a fast commit, by a sample. */
static int is_crowded(const contest *t)
{
    enum { SAMPLES = 256, FEW = 128, MOST_PAIRS = 6000 };
    const herd *h = &t->herd;
    size_t i, hits = 0, n = h->count;
    if (n <= FEW)
        return 0;
    for (i = 0; i < SAMPLES; i++)
        hits += (size_t)boxes_overlap(&h->live[i * 7 % n].bounds, &h->live[(i * 13 + n / 2) % n].bounds, t->dims);
    return hits * n * n > (size_t)2 * SAMPLES * MOST_PAIRS;
}

static void begin(contest *t, input *in)
{
    int i;
    t->dims = take(in, 1) & 1 ? 2 : 3;
    t->environment = 0;
    t->work = 0;
    herd_begin(&t->herd, t->dims, MOST);
    memset(t->rivals, 0, sizeof t->rivals);
    for (i = 0; i < WORLDS; i++) {
        msap_config config = take_config(in, t->dims);
        config.alloc = tracked_alloc;
        config.free = tracked_free;
        config.allocator_user = &t->rivals[i].memory;
        if (msap_create(&config, &t->rivals[i].world) != MSAP_OK)
            fuzz_check("msap_create failed");
    }
}

static void end(contest *t)
{
    int i;
    for (i = 0; i < WORLDS; i++)
        if (msap_destroy(t->rivals[i].world) != MSAP_OK || t->rivals[i].memory.blocks || t->rivals[i].memory.wrong)
            fuzz_check("a world's memory did not come back");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static contest t;
    input in = {data, data + size};
    begin(&t, &in);
    while (t.work < PATIENCE && !is_crowded(&t) && take_call(&in, &t.herd, &t.call))
        next_call(&t);
    t.call.kind = CALL_COMMIT;
    if (!is_crowded(&t))
        next_call(&t);
    end(&t);
    return 0;
}
