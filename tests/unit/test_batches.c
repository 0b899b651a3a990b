/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a batch reads the caller's memory as its strides say, forwards, backwards,
 * interleaved, unaligned, and not a byte more; doubles are rounded outward, exactly;
 * a batch applies whole or not at all.
 */
#include <math.h>
#include <string.h>

#include "checks.h"

#define ROW 5

/* Box i, before and after some motion: x from i, y from 10 i, z from 100 i. */
static box numbered(int i, int moved)
{
    float low = (float)(i + 1000 * moved);
    return box_of(low, 10 * low, 100 * low, low + 0.5f, 10 * low + 5, 100 * low + 50);
}

/* The box must have been read as numbered(i, moved). */
static void is_numbered(const msap_world *world, msap_handle handle, int i, int moved)
{
    box expected = numbered(i, moved), bounds;
    ok(msap_get_bounds(world, handle, bounds.min, bounds.max));
    ck_assert_int_eq(memcmp(&bounds, &expected, sizeof bounds), 0);
}

static void store_number(char *to, float value, uint32_t scalar)
{
    double wide = value;
    if (scalar == MSAP_FLOAT)
        memcpy(to, &value, sizeof value);
    else
        memcpy(to, &wide, sizeof wide);
}

/* Writes the numbered boxes where the strides say, as floats or doubles. */
static void store(char *min, char *max, const msap_boxes *strides, int moved)
{
    int i, c;
    for (i = 0; i < ROW; i++) {
        box b = numbered(i, moved);
        for (c = 0; c < 3; c++) {
            char *to_min = min + i * strides->min_row + c * strides->min_component;
            char *to_max = max + i * strides->max_row + c * strides->max_component;
            store_number(to_min, b.min[c], strides->scalar);
            store_number(to_max, b.max[c], strides->scalar);
        }
    }
}

/* Box 0's min and max lie at these offsets of a block of exactly `size` bytes. */
static void layout_is_read(size_t size, size_t min, size_t max, const msap_boxes *strides)
{
    msap_world *world = new_world(3, DEFAULT);
    char *block = malloc(size);
    msap_boxes boxes = *strides;
    msap_handle handles[ROW];
    int i, moved;
    ck_assert_ptr_nonnull(block);
    memset(block, 0xFF, size); /* NaNs, should one be read */
    boxes.min = block + min;
    boxes.max = block + max;
    for (moved = 0; moved < 2; moved++) {
        store(block + min, block + max, strides, moved);
        if (moved)
            ok(msap_update_many(world, ROW, handles, &boxes));
        else
            ok(msap_add_many(world, ROW, &boxes, NULL, NULL, handles));
        for (i = 0; i < ROW; i++)
            is_numbered(world, handles[i], i, moved);
        commit(world, 0, 0, 0);
    }
    free(block);
    ok(msap_destroy(world));
}

static msap_boxes strides_of(msap_scalar scalar, ptrdiff_t min_row, ptrdiff_t min_component, ptrdiff_t max_row,
                             ptrdiff_t max_component)
{
    msap_boxes result = {sizeof result, 0, NULL, NULL, 0, 0, 0, 0};
    result.scalar = scalar;
    result.min_row = min_row;
    result.min_component = min_component;
    result.max_row = max_row;
    result.max_component = max_component;
    return result;
}

START_TEST(layouts)
{
    msap_scalar scalar = (msap_scalar)_i;
    ptrdiff_t w = scalar == MSAP_FLOAT ? 4 : 8;
    size_t s = (size_t)w, n = 6 * ROW * s;
    msap_boxes rows = strides_of(scalar, 6 * w, w, 6 * w, w);                    /* mmm MMM, mmm MMM */
    msap_boxes pairs = strides_of(scalar, 6 * w, 2 * w, 6 * w, 2 * w);           /* mM mM mM */
    msap_boxes columns = strides_of(scalar, w, ROW * w, w, ROW * w);             /* all x, all y, all z */
    msap_boxes backwards = strides_of(scalar, -6 * w, w, -6 * w, w);             /* the last box first */
    msap_boxes zyx = strides_of(scalar, 6 * w, -w, 6 * w, -w);                   /* the last axis first */
    msap_boxes mirrored = strides_of(scalar, -6 * w, -w, -6 * w, -w);            /* both */
    msap_boxes mixed = strides_of(scalar, 3 * w, w, -w, -ROW * w);               /* mins in rows, maxes in columns */
    msap_boxes unequal = strides_of(scalar, 6 * w, w, 3 * w, w);                 /* mmm..., mmm..., MMM, MMM */
    msap_boxes odd = strides_of(scalar, 6 * w + 1, w, 6 * w + 1, w);             /* records of an odd size */
    layout_is_read(n, 0, 3 * s, &rows);
    layout_is_read(n, 0, s, &pairs);
    layout_is_read(n, 0, 3 * ROW * s, &columns);
    layout_is_read(n, 6 * (ROW - 1) * s, 6 * (ROW - 1) * s + 3 * s, &backwards);
    layout_is_read(n, 2 * s, 5 * s, &zyx);
    layout_is_read(n, n - 4 * s, n - s, &mirrored);
    layout_is_read(n, 0, n - s, &mixed);
    layout_is_read(n + 3 * ROW * s, 0, n, &unequal);
    layout_is_read(n + ROW - 1, 0, 3 * s, &odd);
    layout_is_read(n + 1, 1, 3 * s + 1, &rows);
    layout_is_read(n + 3, 3, s + 3, &pairs);
}
END_TEST

/* Zero strides: the same box k times, and the same number on every axis. */
START_TEST(zero_strides)
{
    msap_world *world = new_world(3, DEFAULT);
    float low = 2, high = 3, min[3], max[3];
    msap_boxes boxes = strides_of(MSAP_FLOAT, 0, 0, 0, 0);
    msap_handle handles[ROW];
    boxes.min = &low;
    boxes.max = &high;
    ok(msap_add_many(world, ROW, &boxes, NULL, NULL, handles));
    ok(msap_get_bounds(world, handles[ROW - 1], min, max));
    ck_assert(min[0] == 2 && min[1] == 2 && min[2] == 2 && max[0] == 3 && max[1] == 3 && max[2] == 3);
    commit(world, 0, 10, 10);
    ok(msap_destroy(world));
}
END_TEST

/* A double, and the floats below and above it (equal if it is one). */
static const struct rounding {
    double value;
    uint32_t down, up;
} roundings[] = {
    {0.0, 0x00000000, 0x00000000},
    {-0.0, 0x00000000, 0x00000000},
    {1.0, 0x3F800000, 0x3F800000},
    {1.0 + 0x1p-52, 0x3F800000, 0x3F800001},
    {1.0 - 0x1p-53, 0x3F7FFFFF, 0x3F800000},
    {-1.0 - 0x1p-52, 0xBF800001, 0xBF800000},
    {-1.0 + 0x1p-53, 0xBF800000, 0xBF7FFFFF},
    {1.0 + 0x1p-24, 0x3F800000, 0x3F800001}, /* halfway */
    {1.0 + 0x3p-24, 0x3F800001, 0x3F800002}, /* halfway, to the even above */
    {0.1, 0x3DCCCCCC, 0x3DCCCCCD},
    {-0.1, 0xBDCCCCCD, 0xBDCCCCCC},
    {16777217.0, 0x4B800000, 0x4B800001},
    {-16777217.0, 0xCB800001, 0xCB800000},
    {0x1.fffffep127, 0x7F7FFFFF, 0x7F7FFFFF}, /* FLT_MAX */
    {0x1.fffffe0000001p127, 0x7F7FFFFF, 0x7F800000},
    {0x1.ffffffp127, 0x7F7FFFFF, 0x7F800000}, /* halfway to infinity */
    {-0x1.fffffe0000001p127, 0xFF800000, 0xFF7FFFFF},
    {0x1p128, 0x7F7FFFFF, 0x7F800000},
    {1e300, 0x7F7FFFFF, 0x7F800000},
    {-1e300, 0xFF800000, 0xFF7FFFFF},
    {(double)INFINITY, 0x7F800000, 0x7F800000},
    {-(double)INFINITY, 0xFF800000, 0xFF800000},
    {0x1p-126, 0x00800000, 0x00800000}, /* FLT_MIN */
    {0x1.0000000000001p-126, 0x00800000, 0x00800001},
    {0x1p-126 - 0x1p-150, 0x007FFFFF, 0x00800000},
    {-0x1p-126 + 0x1p-150, 0x80800000, 0x807FFFFF},
    {0x1p-149, 0x00000001, 0x00000001}, /* the least subnormal */
    {-0x1p-149, 0x80000001, 0x80000001},
    {0x3p-150, 0x00000001, 0x00000002},
    {0x1.0000000000001p-149, 0x00000001, 0x00000002},
    {0x1p-150, 0x00000000, 0x00000001},
    {-0x1p-150, 0x80000001, 0x00000000},
    {0x1p-1022, 0x00000000, 0x00000001},
    {4.94e-324, 0x00000000, 0x00000001}, /* the least subnormal double */
    {-4.94e-324, 0x80000001, 0x00000000},
};

START_TEST(doubles_are_rounded_outward)
{
    const struct rounding *r = &roundings[_i];
    msap_world *world = new_world(3, DEFAULT);
    double other = 0;
    float min[3], max[3];
    msap_boxes boxes = strides_of(MSAP_DOUBLE, 8, 0, 8, 0);
    msap_handle handle;
    int c;
    boxes.min = boxes.max = &r->value;
    ok(msap_add_many(world, 1, &boxes, NULL, NULL, &handle));
    ok(msap_get_bounds(world, handle, min, max));
    for (c = 0; c < 3; c++) {
        ck_assert_uint_eq(bits_of(min[c]), r->down);
        ck_assert_uint_eq(bits_of(max[c]), r->up);
    }
    boxes.min = boxes.max = &other;
    ok(msap_update_many(world, 1, &handle, &boxes));
    boxes.min = boxes.max = &r->value;
    ok(msap_update_many(world, 1, &handle, &boxes));
    ok(msap_get_bounds(world, handle, min, max));
    ck_assert_uint_eq(bits_of(min[0]), r->down);
    ck_assert_uint_eq(bits_of(max[0]), r->up);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(a_batch_of_none)
{
    msap_world *world = new_world(3, DEFAULT);
    box bounds = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&bounds);
    msap_handle handle = 77;
    void *data = NULL;
    ok(msap_add_many(world, 0, &boxes, NULL, NULL, &handle));
    ok(msap_update_many(world, 0, &handle, &boxes));
    ok(msap_remove_many(world, 0, &handle));
    ok(msap_get_user_data(world, 0, &handle, &data));
    ok(msap_set_user_data(world, 0, &handle, &data));
    ok(msap_get_pair_data(world, 0, &handle, &handle, &data));
    ok(msap_set_pair_data(world, 0, &handle, &handle, &data));
    ck_assert_uint_eq(handle, 77);
    ck_assert_uint_eq(stats_of(world).pending, 0);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(of_a_handle_twice_the_last_update_counts)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, bar(0, 1)), b = add(world, bar(5, 6)), handles[4];
    box bounds[4];
    msap_boxes boxes;
    commit(world, 0, 0, 0);
    handles[0] = handles[2] = handles[3] = a;
    handles[1] = b;
    bounds[0] = bar(5, 6);
    bounds[1] = bar(20, 21);
    bounds[2] = bar(0, 1);
    bounds[3] = bar(21, 22);
    boxes = boxes_in_row(bounds);
    ok(msap_update_many(world, 4, handles, &boxes));
    ck_assert_uint_eq(stats_of(world).pending, 2);
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

/* A box in an order that is none of the table, among which is one that never was. */
START_TEST(a_box_that_never_was)
{
    enum { MANY = 300 };
    static msap_handle handles[MANY];
    static box bounds[MANY];
    msap_world *world = new_world(3, _i);
    msap_boxes boxes = boxes_in_row(bounds);
    msap_error error = {.struct_size = sizeof error};
    for (int i = 0; i < MANY; i++) {
        bounds[i] = bar((float)(2 * i), (float)(2 * i) + 1);
        handles[i * 7 % MANY] = add(world, bounds[i]);
    }
    handles[200] += (msap_handle)100000 << 32;
    refused(msap_update_many(world, MANY, handles, &boxes), MSAP_ERROR_HANDLE);
    ok(msap_last_error(world, &error));
    ck_assert_uint_eq(error.index, 200);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

/* The second time it is stale, and nothing is removed. */
START_TEST(a_handle_twice_in_removals)
{
    session s;
    msap_handle handles[4];
    box unit = cube(0, 1);
    int i;
    right(session_open(&s, NULL, 1, SCENE_GRID));
    for (i = 0; i < 4; i++)
        right(session_add(&s, &unit, 0, &handles[i]));
    right(session_commit(&s));
    handles[2] = handles[0];
    refused(msap_remove_many(s.world, 4, handles), MSAP_ERROR_HANDLE);
    last_error(s.world, MSAP_ERROR_HANDLE, 2, MSAP_NO_BOUND);
    right(session_compare(&s));
    handles[2] = handles[1];
    handles[3] = handles[0]; /* two are twice: the earlier second one is named */
    refused(msap_remove_many(s.world, 4, handles), MSAP_ERROR_HANDLE);
    last_error(s.world, MSAP_ERROR_HANDLE, 2, MSAP_NO_BOUND);
    right(session_compare(&s));
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 6);
    right(session_close(&s));
}
END_TEST

/* Opens a session in which three boxes were committed. */
static void open_with(session *s, const box bounds[3], msap_handle handles[3])
{
    int i;
    right(session_open(s, NULL, 1, SCENE_GRID));
    for (i = 0; i < 3; i++)
        right(session_add(s, &bounds[i], 0, &handles[i]));
    right(session_commit(s));
}

/* A refused batch after pending updates leaves those as they were. */
START_TEST(a_refused_batch_keeps_what_was_pending)
{
    session s;
    msap_handle handles[3];
    box bounds[3] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}}, far = cube(8, 9);
    msap_boxes boxes = boxes_in_row(bounds);
    open_with(&s, bounds, handles);
    right(session_update(&s, handles[0], &far));
    bounds[2].min[0] = 7; /* above its max, 1 */
    refused(msap_update_many(s.world, 3, handles, &boxes), MSAP_ERROR_INVERTED);
    right(session_compare(&s));
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.event_count, 2);
    right(session_close(&s));
}
END_TEST

/* A refused batch leaves the slots of boxes that went free, as they were, and those are given out next. */
START_TEST(a_refused_batch_gives_slots_back)
{
    session s;
    msap_handle handles[3];
    box bounds[3] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    msap_boxes boxes = boxes_in_row(bounds);
    int i;
    open_with(&s, bounds, handles);
    right(session_remove(&s, handles[2]));
    right(session_remove(&s, handles[0]));
    right(session_commit(&s));
    bounds[2].min[0] = 7; /* above its max, 1 */
    refused(msap_add_many(s.world, 3, &boxes, NULL, NULL, handles), MSAP_ERROR_INVERTED);
    right(session_compare(&s));
    for (i = 0; i < 2; i++)
        right(session_add(&s, &bounds[i], 0, &handles[i]));
    right(session_commit(&s));
    ck_assert_uint_eq(s.reference.pair_count, 3);
    right(session_close(&s));
}
END_TEST

/* flags and user_data are read per box. */
START_TEST(flags_and_user_data_of_a_batch)
{
    msap_world *world = new_world(3, DEFAULT);
    box bounds[3] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    msap_boxes boxes = boxes_in_row(bounds);
    static const uint32_t flags[3] = {MSAP_STATIC, 0, MSAP_STATIC};
    int marks[3];
    void *in[3] = {&marks[0], NULL, &marks[2]}, *out[3] = {&marks[1], &marks[1], &marks[1]};
    msap_handle handles[3];
    ok(msap_add_many(world, 3, &boxes, flags, in, handles));
    ok(msap_get_user_data(world, 3, handles, out));
    ck_assert_int_eq(memcmp(in, out, sizeof in), 0);
    commit(world, 0, 2, 2);
    ck_assert(!is_pair(world, handles[0], handles[2]));
    ok(msap_add_many(world, 3, &boxes, NULL, NULL, handles));
    ok(msap_get_user_data(world, 3, handles, out));
    ck_assert(out[0] == NULL && out[1] == NULL && out[2] == NULL);
    commit(world, 0, 12, 14); /* 3 among themselves, 9 with the others */
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("batches");
    tcase_add_loop_test(tests, layouts, MSAP_FLOAT, MSAP_DOUBLE + 1);
    tcase_add_test(tests, zero_strides);
    tcase_add_loop_test(tests, doubles_are_rounded_outward, 0, COUNT(roundings));
    tcase_add_test(tests, a_batch_of_none);
    tcase_add_loop_test(tests, of_a_handle_twice_the_last_update_counts, 0, SETUPS);
    tcase_add_loop_test(tests, a_box_that_never_was, 0, SETUPS);
    tcase_add_test(tests, a_handle_twice_in_removals);
    tcase_add_test(tests, a_refused_batch_keeps_what_was_pending);
    tcase_add_test(tests, a_refused_batch_gives_slots_back);
    tcase_add_test(tests, flags_and_user_data_of_a_batch);
    return run_case(tests, "batches");
}
