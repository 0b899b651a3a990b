/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: doubles become floats by exact rounding outward, so that nothing that
 * overlaps is missed; msap_shift_origin moves every bound by exactly the offset and
 * rounds outward, keeps handles, pairs and user data, and reports the pairs that its
 * rounding makes. All of it in any environment of hard.h.
 *
 * The oracle for a rounded bound is two comparisons of doubles, which are exact: the
 * float is not on the wrong side of the value, and the next float is. For a difference
 * of two doubles, the rounding error is known exactly (Knuth's two-sum).
 *
 * More on doubles: layouts and single values in test_batches.c.
 */
#include <string.h>

#include "checks.h"
#include "hard.h"

#define INF float_of(0x7F800000)

static double double_of(uint64_t bits)
{
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Any bits; or near a float; or within a float of 1, FLT_MAX, the subnormals or 0. Not
 * a NaN. */
static double random_double(uint64_t *random)
{
    static const uint64_t about[] = {UINT64_C(0x3FF0000000000000), UINT64_C(0x47EFFFFFE0000000),
                                     UINT64_C(0x36A0000000000000), UINT64_C(0x380FFFFFC0000000), UINT64_C(0)};
    uint64_t bits = random_next(random), sign = bits & UINT64_C(0x8000000000000000);
    switch (random_below(random, 4)) {
    case 0:
        bits = sign + about[random_below(random, COUNT(about))] + random_below(random, 3);
        break;
    case 1:
        bits = sign + about[random_below(random, COUNT(about))] + random_below(random, 0x40000000);
        break;
    case 2:
        bits = (bits & UINT64_C(0xFFFFFFFFE0000000)) + random_below(random, 3);
        break;
    }
    if ((bits & UINT64_C(0x7FF0000000000000)) == UINT64_C(0x7FF0000000000000))
        bits &= UINT64_C(0xFFF0000000000000);
    return double_of(bits);
}

static float float_next(float value, int up)
{
    return msap_decode_float(msap_encode_float(value) + (up ? 1u : UINT32_MAX));
}

/* Whether value + error <= limit, |error| being at most half a step of value. */
static int not_above(double value, double error, double limit)
{
    return value < limit || (value == limit && error <= 0);
}

/* `low` must be the greatest float that is not above value + error. */
static void is_rounded_down(float low, double value, double error)
{
    ck_assert(not_above(-value, -error, -(double)low));
    if (low < INF)
        ck_assert(!not_above(-value, -error, -(double)float_next(low, 1)));
}

static void is_rounded_up(float high, double value, double error)
{
    is_rounded_down(-high, -value, -error);
}

static msap_boxes boxes_of_doubles(const double *first)
{
    msap_boxes boxes = {sizeof boxes, MSAP_DOUBLE, NULL, NULL, 48, 8, 48, 8};
    boxes.min = first;
    boxes.max = first + 3;
    return boxes;
}

/* ----------------------------------------------------------------- rounding */

#define VALUES 3000

static void order(double *low, double *high)
{
    if (*low > *high) {
        double swap = *low;
        *low = *high;
        *high = swap;
    }
}

START_TEST(rounding_is_outward_and_no_further)
{
    static double bounds[VALUES][6];
    static box read[VALUES];
    static msap_handle handles[VALUES];
    msap_world *world = new_world(3, DEFAULT);
    msap_boxes boxes = boxes_of_doubles(bounds[0]);
    uint64_t random = (uint64_t)_i;
    int i, axis;
    for (i = 0; i < VALUES; i++)
        for (axis = 0; axis < 3; axis++) {
            bounds[i][axis] = random_double(&random);
            bounds[i][axis + 3] = random_double(&random);
            order(&bounds[i][axis], &bounds[i][axis + 3]);
        }
    environment_enter(&environments[_i]);
    ok(msap_add_many(world, VALUES, &boxes, NULL, NULL, handles));
    for (i = 0; i < VALUES; i++)
        ok(msap_get_bounds(world, handles[i], read[i].min, read[i].max));
    environment_leave(&environments[_i]);
    for (i = 0; i < VALUES; i++)
        for (axis = 0; axis < 3; axis++) {
            is_rounded_down(read[i].min[axis], bounds[i][axis], 0);
            is_rounded_up(read[i].max[axis], bounds[i][axis + 3], 0);
        }
    ok(msap_destroy(world));
}
END_TEST

/* 0.1 lies between the floats 0x3DCCCCCC and 0x3DCCCCCD. What begins at it or up to
 * the upper one meets what ends at it; what begins at the float above that does not. */
START_TEST(within_a_float_doubles_meet)
{
    static const struct {
        double begins;
        uint64_t meets;
    } cases[] = {
        {0.1, 1},
        {0x1.999999999999bp-4, 1},  /* the double above */
        {0x1.99999ap-4, 1},         /* 0x3DCCCCCD */
        {0x1.99999bffffffp-4, 1},   /* rounded down to it */
        {0x1.99999cp-4, 0},         /* 0x3DCCCCCE */
        {0x1.99999c0000001p-4, 0},  /* rounded down to it */
    };
    double bounds[2][6] = {{0, 0, 0, 0.1, 1, 1}, {0, 0, 0, 1, 1, 1}};
    msap_boxes boxes = boxes_of_doubles(bounds[0]);
    size_t i;
    for (i = 0; i < COUNT(cases); i++) {
        msap_world *world = new_world(3, _i);
        msap_handle handles[2];
        bounds[1][0] = cases[i].begins;
        ok(msap_add_many(world, 2, &boxes, NULL, NULL, handles));
        commit(world, 0, cases[i].meets, cases[i].meets);
        ok(msap_destroy(world));
    }
}
END_TEST

#define CROWD 150

static int doubles_overlap(const double *a, const double *b)
{
    int axis;
    for (axis = 0; axis < 3; axis++)
        if (!(a[axis] <= b[axis + 3] && b[axis] <= a[axis + 3]))
            return 0;
    return 1;
}

/* A crowd about a point, of boxes that are some floats wide there. */
static void make_crowd(double (*bounds)[6], double at, uint64_t *random)
{
    double step = (at > 1 ? at : 1) * 0x1p-24;
    int i, axis;
    for (i = 0; i < CROWD; i++)
        for (axis = 0; axis < 3; axis++) {
            bounds[i][axis] = at + step * (double)random_below(random, 1 << 20) * 0x1p-16;
            bounds[i][axis + 3] = bounds[i][axis] + step * (double)random_below(random, 1 << 20) * 0x1p-17;
        }
}

/* is_pair for many pairs: without an assertion for each. */
static int are_paired(const msap_world *world, msap_handle a, msap_handle b)
{
    void *data;
    return msap_get_pair_data(world, 1, &a, &b, &data) == MSAP_OK;
}

/* Near the origin and far from it: all that overlap as doubles are pairs, in the first
 * commit and after all have moved. */
START_TEST(nothing_is_missed)
{
    static const double at[] = {0, 1e-40, 1, 1e3, 1e5, 1e6, 1e7, 1e15, 1e30};
    static double bounds[CROWD][6];
    msap_boxes boxes = boxes_of_doubles(bounds[0]);
    uint64_t random = 5;
    size_t n;
    for (n = 0; n < COUNT(at); n++) {
        msap_world *world = new_world(3, _i);
        msap_handle handles[CROWD];
        int frame, a, b, overlaps = 0, pairs = 0, missed = 0;
        make_crowd(bounds, at[n], &random);
        ok(msap_add_many(world, CROWD, &boxes, NULL, NULL, handles));
        for (frame = 0; frame < 3; frame++) {
            ok(msap_commit(world, NULL, NULL));
            for (a = 0; a < CROWD; a++)
                for (b = a + 1; b < CROWD; b++) {
                    int overlap = doubles_overlap(bounds[a], bounds[b]);
                    int pair = are_paired(world, handles[a], handles[b]);
                    overlaps += overlap;
                    pairs += pair;
                    missed += overlap && !pair;
                }
            make_crowd(bounds, at[n], &random);
            ok(msap_update_many(world, CROWD, handles, &boxes));
        }
        ck_assert_int_eq(missed, 0);
        ck_assert_int_gt(overlaps, 50);
        ck_assert_int_gt(at[n] < 1 ? pairs + 1 : pairs, overlaps); /* it is the floats that are compared */
        ok(msap_destroy(world));
    }
}
END_TEST

/* ----------------------------------------------------------------- refusals */

#define ROW 4

/* Both batch calls refuse the row of doubles, for this box and bound. */
static void batch_is_refused(double (*row)[6], msap_status status, uint64_t index, int bound)
{
    msap_world *world = new_world(3, DEFAULT);
    msap_boxes boxes = boxes_of_doubles(row[0]);
    msap_handle handles[ROW], one;
    int i;
    for (i = 0; i < ROW; i++)
        handles[i] = add(world, bar((float)(2 * i), (float)(2 * i + 1)));
    one = handles[0];
    refused(msap_add_many(world, ROW, &boxes, NULL, NULL, &one), status);
    last_error(world, status, index, (msap_bound)bound);
    ck_assert_uint_eq(one, handles[0]);
    refused(msap_update_many(world, ROW, handles, &boxes), status);
    last_error(world, status, index, (msap_bound)bound);
    ck_assert_uint_eq(stats_of(world).boxes, ROW);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}

static void good_row(double (*row)[6])
{
    int i, c;
    for (i = 0; i < ROW; i++)
        for (c = 0; c < 6; c++)
            row[i][c] = c < 3 ? -1 : 1;
}

/* Signs and payloads of which nothing may be left in the bits that a float has. */
START_TEST(a_nan_in_any_bound)
{
    static const uint64_t nans[] = {UINT64_C(0x7FF8000000000000), UINT64_C(0xFFF8000000000000),
                                    UINT64_C(0x7FF0000000000001), UINT64_C(0xFFF0000000000001),
                                    UINT64_C(0x7FF000001FFFFFFF), UINT64_C(0xFFFFFFFFFFFFFFFF)};
    double row[ROW][6];
    size_t n;
    int i, c;
    environment_enter(&environments[_i]);
    for (n = 0; n < COUNT(nans); n++)
        for (i = 0; i < ROW; i++)
            for (c = 0; c < 6; c++) {
                good_row(row);
                memcpy(&row[i][c], &nans[n], sizeof nans[n]);
                batch_is_refused(row, MSAP_ERROR_NAN, (uint64_t)i, c);
            }
    environment_leave(&environments[_i]);
}
END_TEST

/* Neighbours as doubles, the lower first; most of them one as floats. */
START_TEST(min_above_max_by_one_ulp)
{
    static const uint64_t neighbours[][2] = {
        {UINT64_C(0x3FF0000000000000), UINT64_C(0x3FF0000000000001)}, /* 1 */
        {UINT64_C(0xBFF0000000000001), UINT64_C(0xBFF0000000000000)}, /* -1 */
        {UINT64_C(0x0000000000000000), UINT64_C(0x0000000000000001)}, /* 0 and the least */
        {UINT64_C(0x8000000000000001), UINT64_C(0x8000000000000000)}, /* minus the least and -0 */
        {UINT64_C(0x0000000000000001), UINT64_C(0x0000000000000002)}, /* subnormals */
        {UINT64_C(0x000FFFFFFFFFFFFF), UINT64_C(0x0010000000000000)}, /* the last of them */
        {UINT64_C(0x47EFFFFFE0000000), UINT64_C(0x47EFFFFFE0000001)}, /* FLT_MAX */
        {UINT64_C(0x7FEFFFFFFFFFFFFE), UINT64_C(0x7FEFFFFFFFFFFFFF)}, /* DBL_MAX */
        {UINT64_C(0x7FEFFFFFFFFFFFFF), UINT64_C(0x7FF0000000000000)}, /* and infinity */
        {UINT64_C(0xFFF0000000000000), UINT64_C(0xFFEFFFFFFFFFFFFF)},
    };
    double row[ROW][6];
    size_t n;
    int c;
    environment_enter(&environments[_i]);
    for (n = 0; n < COUNT(neighbours); n++)
        for (c = 0; c < 3; c++) {
            good_row(row);
            memcpy(&row[2][c], &neighbours[n][1], 8);
            memcpy(&row[2][c + 3], &neighbours[n][0], 8);
            batch_is_refused(row, MSAP_ERROR_INVERTED, 2, c);
        }
    environment_leave(&environments[_i]);
}
END_TEST

/* -------------------------------------------------------- shifting the origin */

/* A float, an offset, and the floats below and above their exact difference. */
static const struct shift {
    uint32_t from;
    double offset;
    uint32_t down, up;
} shifts[] = {
    {0x3F800000, 0, 0x3F800000, 0x3F800000},
    {0x3F800000, 1, 0x00000000, 0x00000000},
    {0x3F800000, -1, 0x40000000, 0x40000000},
    {0x3F800000, 0x1p-60, 0x3F7FFFFF, 0x3F800000},  /* below 1 */
    {0x3F800000, -0x1p-60, 0x3F800000, 0x3F800001}, /* above 1 */
    {0xBF800000, 0x1p-60, 0xBF800001, 0xBF800000},
    {0xBF800000, -0x1p-60, 0xBF800000, 0xBF7FFFFF},
    {0x4B800000, 0.5, 0x4B7FFFFF, 0x4B800000},           /* 2^24 - 0.5 */
    {0x4B800000, 1, 0x4B7FFFFF, 0x4B7FFFFF},             /* 2^24 - 1 */
    {0x4B800000, -1, 0x4B800000, 0x4B800001},            /* 2^24 + 1 */
    {0x4B189680, 9999999.9990234375, 0x3A800000, 0x3A800000}, /* 1e7: what is left is 2^-10 */
    {0x4B189680, -0.25, 0x4B189680, 0x4B189681},
    {0x3DCCCCCD, 0.1, 0x30CCCCCC, 0x30CCCCCD},           /* the float 0.1 less the double 0.1: 0x3.333333p-31 */
    {0x00000001, 0x1p-149, 0x00000000, 0x00000000},
    {0x00000001, 0x1p-150, 0x00000000, 0x00000001},      /* half of the least is left */
    {0x00000001, -0x1p-149, 0x00000002, 0x00000002},
    {0x00800000, 0x1p-149, 0x007FFFFF, 0x007FFFFF},      /* to the subnormals */
    {0x007FFFFF, -0x1p-149, 0x00800000, 0x00800000},     /* and back */
    {0x00000000, 0x0.0000000000001p-1022, 0x80000001, 0x00000000}, /* the least double */
    {0x00000000, -0x0.0000000000001p-1022, 0x00000000, 0x00000001},
    {0x3F800000, 0x0.0000000000001p-1022, 0x3F7FFFFF, 0x3F800000},
    {0x7F7FFFFF, 0x0.0000000000001p-1022, 0x7F7FFFFE, 0x7F7FFFFF},
    {0x7F7FFFFF, 0x1p104, 0x7F7FFFFE, 0x7F7FFFFE},       /* FLT_MAX less one ulp */
    {0x7F7FFFFF, -0x1p-1022, 0x7F7FFFFF, 0x7F800000},    /* beyond FLT_MAX by nearly nothing */
    {0x7F7FFFFF, -0x1.fffffep127, 0x7F7FFFFF, 0x7F800000},
    {0x7F7FFFFF, 0x1.fffffep127, 0x00000000, 0x00000000},
    {0xFF7FFFFF, 0x1.fffffep127, 0xFF800000, 0xFF7FFFFF},
    {0x3F800000, 1e308, 0xFF800000, 0xFF7FFFFF},
    {0x3F800000, -0x1.fffffffffffffp1023, 0x7F7FFFFF, 0x7F800000}, /* DBL_MAX */
    {0x7F800000, 0x1.fffffffffffffp1023, 0x7F800000, 0x7F800000},  /* infinity stays */
    {0xFF800000, -0x1.fffffffffffffp1023, 0xFF800000, 0xFF800000},
};

static void shift(msap_world *world, double x, double y, double z)
{
    double offset[3];
    offset[0] = x;
    offset[1] = y;
    offset[2] = z;
    ok(msap_shift_origin(world, offset));
}

/* The same bound on each axis. */
START_TEST(shifts_by_hand)
{
    size_t i;
    int axis;
    environment_enter(&environments[_i]);
    for (i = 0; i < COUNT(shifts); i++) {
        const struct shift *s = &shifts[i];
        msap_world *world = new_world(3, DEFAULT);
        msap_handle handle = add(world, cube(float_of(s->from), float_of(s->from)));
        box b;
        shift(world, s->offset, s->offset, s->offset);
        ok(msap_get_bounds(world, handle, b.min, b.max));
        for (axis = 0; axis < 3; axis++) {
            uint32_t down = bits_of(b.min[axis]), up = bits_of(b.max[axis]);
            ck_assert_msg(down == s->down, "shift %lu: min 0x%08X", (unsigned long)i, (unsigned)down);
            ck_assert_msg(up == s->up, "shift %lu: max 0x%08X", (unsigned long)i, (unsigned)up);
        }
        ok(msap_destroy(world));
    }
    environment_leave(&environments[_i]);
}
END_TEST

#define SHIFTS 40

/* a - b as value + error, exactly; both are finite, and so is a - b. */
static double subtract(double a, double b, double *error)
{
    volatile double difference = a - b, part = a - difference;
    volatile double rest_a = a - (part + difference), rest_b = part - b;
    *error = rest_a + rest_b;
    return difference;
}

/* A bound that was `then` must be less by the offset, exactly, and then rounded. */
static void is_shifted(float now, float then, double offset, void (*is_rounded)(float, double, double))
{
    double error, value = subtract((double)then, offset, &error);
    if (then > -INF && then < INF)
        is_rounded(now, value, error);
    else
        ck_assert_uint_eq(bits_of(now), bits_of(then));
}

/* Random boxes and offsets; of the offsets, some cancel a bound. */
START_TEST(random_shifts_are_exact)
{
    static box then[CROWD], now[CROWD];
    msap_handle handles[CROWD];
    msap_boxes boxes = boxes_in_row(then);
    uint64_t random = 17 + (uint64_t)_i;
    int round, i, axis;
    for (round = 0; round < SHIFTS; round++) {
        msap_world *world = new_world(3, DEFAULT);
        double offset[3];
        for (i = 0; i < CROWD; i++)
            then[i] = random_box(&random, i % 2 ? SCENE_HARD : SCENE_SPREAD);
        for (axis = 0; axis < 3; axis++) {
            offset[axis] = random_double(&random);
            if (round % 3 == 0)
                offset[axis] = (double)then[1 + 2 * round].min[axis] * (1 + 0x1p-30);
            if (!(offset[axis] - offset[axis] == 0))
                offset[axis] = 1e9 / 7;
        }
        ok(msap_add_many(world, CROWD, &boxes, NULL, NULL, handles));
        environment_enter(&environments[_i]);
        ok(msap_shift_origin(world, offset));
        for (i = 0; i < CROWD; i++)
            ok(msap_get_bounds(world, handles[i], now[i].min, now[i].max));
        environment_leave(&environments[_i]);
        for (i = 0; i < CROWD; i++)
            for (axis = 0; axis < 3; axis++) {
                is_shifted(now[i].min[axis], then[i].min[axis], offset[axis], is_rounded_down);
                is_shifted(now[i].max[axis], then[i].max[axis], offset[axis], is_rounded_up);
            }
        ok(msap_destroy(world));
    }
}
END_TEST

/* The pairs must be those of the bounds as the world tells them, by brute force. */
static void pairs_are_those_of_the_bounds(const msap_world *world, const msap_handle *handles)
{
    static box boxes[CROWD];
    int a, b, wrong = 0;
    for (a = 0; a < CROWD; a++)
        ok(msap_get_bounds(world, handles[a], boxes[a].min, boxes[a].max));
    for (a = 0; a < CROWD; a++)
        for (b = a + 1; b < CROWD; b++)
            wrong += are_paired(world, handles[a], handles[b]) != boxes_overlap(&boxes[a], &boxes[b], 3);
    ck_assert_int_eq(wrong, 0);
}

/* No shift ends a pair; where it makes some, they are events of the next commit. */
START_TEST(a_shift_loses_no_pair)
{
    static const double offsets[] = {0.3, -1e5 / 3, 1e9 / 7, -1e-30, 1e20, -1e38};
    uint64_t random = 3;
    msap_world *world = new_world(3, _i);
    msap_handle handles[CROWD];
    uint64_t made = 0;
    size_t n;
    int i;
    for (i = 0; i < CROWD; i++)
        handles[i] = add(world, random_box(&random, i % 8 ? SCENE_GRID : SCENE_HARD));
    ok(msap_commit(world, NULL, NULL));
    for (n = 0; n < COUNT(offsets); n++) {
        msap_counts counts = {sizeof counts, 0, 0, 0, 0};
        shift(world, offsets[n], -offsets[n], offsets[n] / 3);
        ok(msap_commit(world, NULL, &counts));
        ck_assert_uint_eq(counts.deleted, 0);
        made += counts.created;
        ok(msap_validate(world, NULL));
        pairs_are_those_of_the_bounds(world, handles);
    }
    ck_assert_uint_gt(made, 1000);
    ok(msap_destroy(world));
}
END_TEST

/* Whole numbers, shifted by whole numbers, and back: no float is rounded, so nothing
 * happens to the pairs, and the bounds are as before. */
START_TEST(there_and_back)
{
    uint64_t random = 11;
    msap_world *world = new_world(3, _i);
    msap_handle handles[CROWD];
    box boxes[CROWD], b;
    int i, round;
    for (i = 0; i < CROWD; i++) {
        boxes[i] = random_box(&random, SCENE_SPREAD);
        handles[i] = add(world, boxes[i]);
    }
    ok(msap_commit(world, NULL, NULL));
    for (round = 0; round < 4; round++) {
        msap_counts counts = {sizeof counts, 0, 0, 0, 0};
        shift(world, round % 2 ? -1e6 : 1e6, round % 2 ? 3e5 : -3e5, 0);
        ok(msap_commit(world, NULL, &counts));
        ck_assert(counts.deleted == 0 && counts.created == 0);
    }
    for (i = 0; i < CROWD; i++) {
        ok(msap_get_bounds(world, handles[i], b.min, b.max));
        ck_assert_int_eq(memcmp(&b, &boxes[i], sizeof b), 0);
    }
    ok(msap_destroy(world));
}
END_TEST

static void *mark_pair(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    (void)a;
    (void)b;
    (void)data_a;
    (void)data_b;
    return context;
}

/* Of three boxes two are a pair, and the third begins 2^-20 behind their end at 1.
 * About 129 the floats are 2^-16 apart: there the end is rounded up and the beginning
 * down, and they meet. */
START_TEST(a_shift_keeps_identity_and_reports_what_it_makes)
{
    msap_world *world = new_world(3, _i);
    int first, second;
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, mark_pair, NULL};
    msap_handle a = add(world, bar(0, 1)), b = add(world, bar(0, 1)), c = add(world, bar(1 + 0x1p-20f, 2)), d;
    void *data = &first;
    ok(msap_set_user_data(world, 1, &a, &data));
    callbacks.context = &first;
    ok(msap_commit(world, &callbacks, NULL));
    shift(world, -128 - 0x1p-18, 0, 0);
    commit(world, 0, 2, 3);
    ok(msap_get_pair_data(world, 1, &a, &b, &data));
    ck_assert_ptr_eq(data, &first);
    ok(msap_get_user_data(world, 1, &a, &data));
    ck_assert_ptr_eq(data, &first);
    d = add(world, bar(500, 501));
    callbacks.context = &second;
    ok(msap_remove(world, c));
    shift(world, 400, 0, 0); /* what is pending is shifted too */
    update(world, a, bar(100, 101)); /* and of the two, the last counts */
    ok(msap_commit(world, &callbacks, NULL));
    ck_assert(is_pair(world, a, d) && !is_pair(world, a, b));
    ok(msap_get_pair_data(world, 1, &d, &a, &data));
    ck_assert_ptr_eq(data, &second);
    ck_assert_uint_eq(stats_of(world).pairs, 1);
    ok(msap_destroy(world));
}
END_TEST

/* Planes stay; a box that is pushed over the end of the floats reaches from there to
 * infinity; static boxes stay static. */
START_TEST(infinite_and_static_boxes)
{
    msap_world *world = new_world(3, _i);
    box plane = cube(-INF, INF), b;
    msap_handle near = add(world, cube(0, 1)), handle;
    plane.min[2] = plane.max[2] = 0;
    handle = add_flagged(world, plane, MSAP_STATIC);
    add_flagged(world, bar(5, 6), MSAP_STATIC);
    commit(world, 0, 1, 1);
    shift(world, -1e300, 1e300, 0);
    commit(world, 0, 1, 2); /* near and the bar are both beyond FLT_MAX */
    ok(msap_get_bounds(world, near, b.min, b.max));
    ck_assert(bits_of(b.min[0]) == 0x7F7FFFFF && bits_of(b.max[0]) == 0x7F800000);
    ck_assert(bits_of(b.min[1]) == 0xFF800000 && bits_of(b.max[1]) == 0xFF7FFFFF);
    ck_assert(bits_of(b.min[2]) == 0x00000000 && bits_of(b.max[2]) == 0x3F800000);
    ok(msap_get_bounds(world, handle, b.min, b.max));
    ck_assert(bits_of(b.min[0]) == 0xFF800000 && bits_of(b.max[1]) == 0x7F800000 && b.max[2] == 0);
    shift(world, 0, 0, 2); /* the ball goes through the floor with the floor */
    commit(world, 0, 0, 2);
    ok(msap_destroy(world));
}
END_TEST

static msap_world *shifted_from_inside;

static void *shift_from_inside(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    static const double offset[3] = {1, 1, 1};
    refused(msap_shift_origin(shifted_from_inside, offset), MSAP_ERROR_BUSY);
    return mark_pair(context, a, b, data_a, data_b);
}

/* An offset that is not finite is refused, by axis, and nothing has moved. */
START_TEST(refused_shifts)
{
    static const uint64_t bad[] = {UINT64_C(0x7FF0000000000000), UINT64_C(0xFFF0000000000000),
                                   UINT64_C(0x7FF0000000000001), UINT64_C(0xFFF8000000000000)};
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, shift_from_inside, NULL};
    msap_world *world = new_world(3, _i);
    msap_handle handle = add(world, cube(0, 1));
    box b;
    size_t n;
    int axis;
    add(world, cube(1, 2));
    refused(msap_shift_origin(NULL, NULL), MSAP_ERROR_NULL);
    refused(msap_shift_origin(world, NULL), MSAP_ERROR_NULL);
    for (n = 0; n < COUNT(bad); n++)
        for (axis = 0; axis < 3; axis++) {
            double offset[3] = {1, 1, 1};
            memcpy(&offset[axis], &bad[n], sizeof bad[n]);
            refused(msap_shift_origin(world, offset), MSAP_ERROR_CONFIG);
            last_error(world, MSAP_ERROR_CONFIG, 0, (msap_bound)axis);
        }
    shifted_from_inside = world;
    ok(msap_commit(world, &callbacks, NULL));
    last_error(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    ok(msap_get_bounds(world, handle, b.min, b.max));
    ck_assert(b.min[0] == 0 && b.max[2] == 1);
    commit(world, 0, 0, 1);
    ok(msap_destroy(world));
}
END_TEST

/* Two doubles are read of the offset, and nothing is allocated. */
START_TEST(a_shift_in_2d)
{
    msap_world *world = new_world(2, _i);
    msap_handle handle = add(world, cube(0, 1));
    double *offset = malloc(2 * sizeof *offset);
    uint64_t allocations;
    float min[2], max[2];
    ck_assert_ptr_nonnull(offset);
    offset[0] = 4;
    offset[1] = -2;
    commit(world, 0, 0, 0);
    allocations = stats_of(world).allocations;
    ok(msap_shift_origin(world, offset));
    ck_assert_uint_eq(stats_of(world).allocations, allocations);
    ck_assert_uint_eq(stats_of(world).pending, 1);
    ok(msap_get_bounds(world, handle, min, max));
    ck_assert(min[0] == -4 && min[1] == 2 && max[0] == -3 && max[1] == 3);
    commit(world, 0, 0, 0);
    free(offset);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("doubles");
    tcase_add_loop_test(tests, rounding_is_outward_and_no_further, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, within_a_float_doubles_meet, 0, SETUPS);
    tcase_add_loop_test(tests, nothing_is_missed, 0, SETUPS);
    tcase_add_loop_test(tests, a_nan_in_any_bound, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, min_above_max_by_one_ulp, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, shifts_by_hand, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, random_shifts_are_exact, 0, (int)ENVIRONMENTS);
    tcase_add_loop_test(tests, a_shift_loses_no_pair, 0, SETUPS);
    tcase_add_loop_test(tests, there_and_back, 0, SETUPS);
    tcase_add_loop_test(tests, a_shift_keeps_identity_and_reports_what_it_makes, 0, SETUPS);
    tcase_add_loop_test(tests, infinite_and_static_boxes, 0, SETUPS);
    tcase_add_loop_test(tests, refused_shifts, 0, SETUPS);
    tcase_add_loop_test(tests, a_shift_in_2d, 0, SETUPS);
    return run_case(tests, "doubles");
}
