/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a world that outgrows caches, in which much is fetched before it is looked at and what was worked in is
 * given back, answers as a small one and holds no more than it is said to: boxes that all move, that move now and
 * then, and that go elsewhere at once. There are too many for brute force, so they stand where it is known who
 * overlaps: two at each place, which come together and part. It looks behind the interface for how many boxes are
 * many.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { PLACES = VERY_MANY_BOXES / 2 + 1000, BOXES = 2 * PLACES, LINE = 32, APART = 5 };

/* Box i stands at place i / 2, the odd one so far to the right of the other. In a batch boxes stand in another order
 * than in the table. */
typedef struct scene {
    msap_world *world;
    msap_handle handles[BOXES], batch[BOXES];
    box bounds[BOXES], batch_bounds[BOXES];
    float offset[PLACES];
    size_t n; /* in the batch */
} scene;

static scene many;

static box bounds_of_box(int i, float shift)
{
    int place = i / 2;
    float x = (float)(place % LINE * APART) + shift + (i % 2 ? many.offset[place] : 0);
    float y = (float)(place / LINE % LINE) * 1.25f, z = (float)(place / LINE / LINE) * 1.25f;
    return box_of(x, y, z, x + 1, y + 1, z + 1);
}

static void put_into_batch(int i, float shift)
{
    many.batch[many.n] = many.handles[i];
    many.batch_bounds[many.n++] = bounds_of_box(i, shift);
}

static void commit_batch(void)
{
    msap_boxes boxes = boxes_in_row(many.batch_bounds);
    ok(msap_update_many(many.world, many.n, many.batch, &boxes));
    ok(msap_commit(many.world, NULL, NULL));
    many.n = 0;
}

/* Exactly the boxes of a place are a pair that are no more than their width apart. */
static void has_its_pairs(void)
{
    const msap_pair *pairs;
    size_t count, expected = 0;
    ok(msap_pairs(many.world, &pairs, &count));
    for (int place = 0; place < PLACES; place++) expected += many.offset[place] <= 1;
    ck_assert_uint_eq(count, expected);
    for (size_t k = 0; k < count; k++) {
        size_t a = pairs[k].a >> 32, b = pairs[k].b >> 32; /* the slots, in which box 0 ... stand */
        if (a / 2 != b / 2 || many.offset[a / 2] > 1) ck_abort_msg("%zu and %zu are a pair", a, b);
    }
}

/* The even boxes get these flags. */
static void load(uint32_t flags)
{
    static uint32_t flags_of[BOXES];
    msap_config config = config_of(3, DEFAULT);
    msap_boxes boxes = boxes_in_row(many.bounds);
    uint64_t random = 3;
    for (int place = 0; place < PLACES; place++) many.offset[place] = (float)random_below(&random, 48) / 16;
    for (int i = 0; i < BOXES; i++) {
        many.bounds[i] = bounds_of_box(i, 0);
        flags_of[i] = i % 2 ? 0 : flags;
    }
    many.n = 0;
    ok(msap_create(&config, &many.world));
    ok(msap_add_many(many.world, BOXES, &boxes, flags_of, NULL, many.handles));
    ok(msap_commit(many.world, NULL, NULL));
    has_its_pairs();
}

/* By then all is as it stays. A box takes up to 200 bytes, and a pair, or a candidate for one, up to 48, with an
 * eighth more to spare. */
static void leave(void)
{
    msap_world_stats stats = stats_of(many.world);
    uint64_t pairs = stats.candidates > stats.pairs ? stats.candidates : stats.pairs;
    ck_assert_uint_le(stats.bytes, (200 * (uint64_t)BOXES + 48 * pairs) * 9 / 8);
    ok(msap_validate(many.world, NULL));
    ok(msap_destroy(many.world));
}

/* The k-th box in an order in which none stands beside its neighbours in the table. */
static int scattered(int k) { return (int)((uint64_t)k * 7919 % BOXES); }

START_TEST(all_drift)
{
    const struct grid *g;
    size_t untold = 0;
    load(0);
    g = &many.world->grid;
    for (int frame = 1; frame <= 30 || g->renewal.next != NO_RENEWAL || g->untold > 0; frame++) {
        for (int place = 0; place < PLACES; place++) {
            float *offset = &many.offset[place];
            *offset += (float)(place % 5 - 2) / 64;
            if (*offset < 0 || *offset > 3) *offset = 1;
        }
        for (int k = 0; k < BOXES; k++) put_into_batch(frame % 2 ? k : scattered(k), (float)frame / 32);
        commit_batch();
        has_its_pairs();
        if (frame >= 15) ck_assert_uint_le(g->candidates.room, 3 * g->candidates.n);
        untold += g->untold;
    }
    ck_assert(g->in_skins);
    ck_assert_uint_gt(untold, 0); /* candidates that learnt what they are in the commit after the steps */
    leave();
}
END_TEST

/* In each frame others of some come together or part, by much or by little. Loop variable: whether half of all boxes
 * are static, which are loaded without skins. */
START_TEST(some_move)
{
    uint64_t random = 5;
    load(_i ? MSAP_STATIC : 0);
    for (int frame = 0; frame < 30; frame++) {
        for (int k = 0; k < 300; k++) {
            int place = (int)random_below(&random, 900) * 37 % PLACES;
            many.offset[place] = frame % 3 ? (float)random_below(&random, 48) / 16 : many.offset[place];
            many.offset[place] += many.offset[place] < 2 ? 1.0f / 64 : 0;
            put_into_batch(2 * place + 1, 0);
        }
        commit_batch();
        has_its_pairs();
    }
    ck_assert(many.world->grid.is_resting && !many.world->grid.in_skins);
    ck_assert_int_eq(many.world->grid.rows_hold_skins, !_i);
    ck_assert_uint_lt(many.world->scratch.room, BOXES);
    leave();
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("many boxes");
    tcase_add_test(tests, all_drift);
    tcase_add_loop_test(tests, some_move, 0, 2);
    return run_case(tests, "many boxes");
}
