/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: the host's rounding mode, flush-to-zero and denormals-are-zero change
 * nothing: the library compares and rounds by integers. A script of random calls
 * gives the same log under each of them as by default.
 *
 * The script is made beforehand, and the logs are compared by their bits, as the
 * test's own floats would not be safe from the modes.
 */
#include <fenv.h>
#include <string.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "checks.h"

#define BOXES 60
#define FRAMES 40
#define DOUBLES 500

typedef struct script {
    box bounds[FRAMES][BOXES];
    uint32_t action[FRAMES][BOXES]; /* 0, 1: none; 2: update; 3: remove; a missing box comes with 2 */
    double doubles[DOUBLES];
} script;

typedef struct entry {
    uint64_t what, a, b;
} entry;

#define MOST_ENTRIES 200000

typedef struct record {
    entry at[MOST_ENTRIES];
    size_t count;
} record;

static void note(record *log, uint64_t what, uint64_t a, uint64_t b)
{
    if (log->count == MOST_ENTRIES)
        ck_abort_msg("the log is full");
    log->at[log->count].what = what;
    log->at[log->count].a = a;
    log->at[log->count++].b = b;
}

/* Doubles of all kinds: any bits, and those about the ends of the floats; no NaNs. */
static double random_double(uint64_t *random)
{
    static const uint64_t about[] = {UINT64_C(0x36A0000000000000), UINT64_C(0x380FFFFFC0000000),
                                     UINT64_C(0x47EFFFFFE0000000), UINT64_C(0x3FF0000010000000), UINT64_C(0)};
    uint64_t bits = random_next(random), step = random_below(random, 5), sign = bits & UINT64_C(0x8000000000000000);
    double value;
    if (bits % 2)
        bits = sign + about[bits / 2 % COUNT(about)] + step * (bits % 3 ? 1 : 0x10000000);
    if ((bits & UINT64_C(0x7FF0000000000000)) == UINT64_C(0x7FF0000000000000))
        bits &= UINT64_C(0xFFF0000000000000);
    memcpy(&value, &bits, sizeof value);
    return value;
}

static void write_script(script *s)
{
    uint64_t random = 2026;
    int frame, i;
    for (frame = 0; frame < FRAMES; frame++)
        for (i = 0; i < BOXES; i++) {
            s->bounds[frame][i] = random_box(&random, i % 3 ? SCENE_HARD : SCENE_GRID);
            s->action[frame][i] = random_below(&random, 4);
        }
    for (i = 0; i < DOUBLES; i++)
        s->doubles[i] = random_double(&random);
}

static void note_pairs(record *log, const msap_world *world)
{
    const msap_pair *pairs;
    size_t count, i;
    ok(msap_deleted(world, &pairs, &count));
    for (i = 0; i < count; i++)
        note(log, 'd', pairs[i].a, pairs[i].b);
    ok(msap_created(world, &pairs, &count));
    for (i = 0; i < count; i++)
        note(log, 'c', pairs[i].a, pairs[i].b);
}

/* How the bounds and codes come back. */
static void note_box(record *log, const msap_world *world, msap_handle handle)
{
    float bounds[6];
    int c;
    ok(msap_get_bounds(world, handle, bounds, bounds + 3));
    for (c = 0; c < 6; c++) {
        uint32_t code = msap_encode_float(bounds[c]);
        note(log, 'b', bits_of(bounds[c]), code);
        note(log, 'f', bits_of(msap_decode_float(code)), 0);
    }
}

static void play_frame(record *log, msap_world *world, const script *s, int frame, msap_handle *handles)
{
    int i;
    for (i = 0; i < BOXES; i++) {
        const box *b = &s->bounds[frame][i];
        if (s->action[frame][i] == 2 && handles[i])
            ok(msap_update(world, handles[i], b->min, b->max));
        else if (s->action[frame][i] == 2)
            ok(msap_add(world, b->min, b->max, 0, NULL, &handles[i]));
        else if (s->action[frame][i] == 3 && handles[i]) {
            ok(msap_remove(world, handles[i]));
            handles[i] = 0;
        }
        if (handles[i])
            note_box(log, world, handles[i]);
    }
    ok(msap_commit(world, NULL, NULL));
    note_pairs(log, world);
}

static void play_doubles(record *log, const script *s)
{
    msap_world *world = new_world(3, DEFAULT);
    msap_boxes boxes = {sizeof boxes, MSAP_DOUBLE, NULL, NULL, 0, 0, 0, 0};
    static msap_handle handles[DOUBLES];
    int i;
    boxes.min = boxes.max = s->doubles;
    boxes.min_row = boxes.max_row = sizeof(double);
    ok(msap_add_many(world, DOUBLES, &boxes, NULL, NULL, handles));
    for (i = 0; i < DOUBLES; i++)
        note_box(log, world, handles[i]);
    ok(msap_commit(world, NULL, NULL));
    note_pairs(log, world);
    ok(msap_destroy(world));
}

static void play(record *log, const script *s, int row)
{
    msap_world *world = new_world(3, row);
    msap_handle handles[BOXES] = {0};
    int frame;
    log->count = 0;
    for (frame = 0; frame < FRAMES; frame++)
        play_frame(log, world, s, frame, handles);
    ok(msap_destroy(world));
    play_doubles(log, s);
}

static script the_script;
static record by_default, by_mode;

static void logs_are_the_same(void)
{
    ck_assert_uint_eq(by_mode.count, by_default.count);
    ck_assert_int_eq(memcmp(by_mode.at, by_default.at, by_mode.count * sizeof *by_mode.at), 0);
}

static void start(int row)
{
    write_script(&the_script);
    play(&by_default, &the_script, row);
    ck_assert_uint_gt(by_default.count, 10000);
}

START_TEST(rounding_modes)
{
    static const int modes[] = {
        FE_TONEAREST,
#ifdef FE_DOWNWARD
        FE_DOWNWARD,
#endif
#ifdef FE_UPWARD
        FE_UPWARD,
#endif
#ifdef FE_TOWARDZERO
        FE_TOWARDZERO,
#endif
    };
    size_t i;
    start(_i);
    for (i = 0; i < COUNT(modes); i++) {
        ck_assert_int_eq(fesetround(modes[i]), 0);
        play(&by_mode, &the_script, _i);
        ck_assert_int_eq(fegetround(), modes[i]); /* and the library leaves it alone */
        ck_assert_int_eq(fesetround(FE_TONEAREST), 0);
        logs_are_the_same();
    }
}
END_TEST

#ifdef __SSE2__
START_TEST(flush_to_zero)
{
    static const unsigned modes[] = {0x8000, 0x0040, 0x8040, 0xE040}; /* FTZ, DAZ, both, both and towards zero */
    unsigned before = _mm_getcsr();
    size_t i;
    start(_i);
    for (i = 0; i < COUNT(modes); i++) {
        _mm_setcsr(before | modes[i]);
        play(&by_mode, &the_script, _i);
        _mm_setcsr(before);
        logs_are_the_same();
    }
}
END_TEST
#endif

int main(void)
{
    TCase *tests = tcase_create("environment");
    tcase_add_loop_test(tests, rounding_modes, 0, SETUPS);
#ifdef __SSE2__
    tcase_add_loop_test(tests, flush_to_zero, 0, SETUPS);
#endif
    return run_case(tests, "environment");
}
