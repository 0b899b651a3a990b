/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: box pruning, complete and bipartite, finds what brute force finds, sorted,
 * along any axis, in 2D and 3D; refuses bad boxes by their index; and takes memory
 * from the caller's allocator only.
 */
#include <string.h>

#include "checks.h"

#define MOST 300

static msap_prune_config prune_config(uint32_t dims, int32_t axis, tracker *m)
{
    msap_prune_config config;
    ok(msap_prune_config_init(&config, sizeof config));
    config.dims = dims;
    config.axis = axis;
    if (m) {
        config.alloc = tracked_alloc;
        config.free = tracked_free;
        config.allocator_user = m;
    }
    return config;
}

static void random_boxes(uint64_t *random, scene_kind scene, box *boxes, size_t k)
{
    while (k--)
        *boxes++ = random_box(random, scene);
}

/* The pairs must be those of brute force: all i < j, or all of two sets. */
static void are_all_pairs(const msap_index_pair *pairs, size_t count, const box *a, size_t k_a, const box *b,
                          size_t k_b, uint32_t dims)
{
    size_t i, j, n = 0;
    for (i = 0; i < k_a; i++)
        for (j = b ? 0 : i + 1; j < (b ? k_b : k_a); j++)
            if (boxes_overlap(&a[i], b ? &b[j] : &a[j], dims)) {
                ck_assert_uint_lt(n, count);
                ck_assert_uint_eq(pairs[n].a, i);
                ck_assert_uint_eq(pairs[n].b, j);
                n++;
            }
    ck_assert_uint_eq(n, count);
}

/* One random set, or two if k_b is not negative, along every axis. */
static void prune_and_compare(uint64_t *random, scene_kind scene, uint32_t dims, size_t k_a, int k_b)
{
    static box a[MOST], b[MOST];
    msap_boxes boxes_a = boxes_in_row(a), boxes_b = boxes_in_row(b);
    int32_t axis;
    random_boxes(random, scene, a, k_a);
    if (k_b >= 0)
        random_boxes(random, scene, b, (size_t)k_b);
    for (axis = MSAP_AXIS_AUTO; axis < (int32_t)dims; axis++) {
        tracker m = {0};
        msap_prune_config config = prune_config(dims, axis, &m);
        msap_index_pair *pairs = NULL;
        size_t count = 77;
        if (k_b >= 0)
            ok(msap_prune_bipartite(&config, k_a, &boxes_a, (size_t)k_b, &boxes_b, &pairs, &count, NULL));
        else
            ok(msap_prune(&config, k_a, &boxes_a, &pairs, &count, NULL));
        are_all_pairs(pairs, count, a, k_a, k_b >= 0 ? b : NULL, (size_t)k_b, dims);
        ck_assert_int_eq(pairs == NULL, count == 0);
        ck_assert(m.blocks == (pairs != NULL) && m.bytes <= count * sizeof *pairs + 64); /* nothing else is kept */
        ok(msap_prune_free(&config, pairs, count));
        ck_assert(m.blocks == 0 && m.bytes == 0 && m.wrong == 0);
    }
}

START_TEST(complete_is_brute_force)
{
    static const size_t sizes[] = {0, 1, 2, 3, 7, 8, 9, 15, 16, 17, 33, 64, 100, MOST};
    uint64_t random = (uint64_t)_i;
    size_t i;
    int scene;
    for (scene = 0; scene < SCENE_COUNT; scene++)
        for (i = 0; i < COUNT(sizes); i++)
            prune_and_compare(&random, (scene_kind)scene, (uint32_t)_i, sizes[i], -1);
}
END_TEST

START_TEST(bipartite_is_brute_force)
{
    static const int sizes[] = {0, 1, 2, 8, 33, MOST};
    uint64_t random = (uint64_t)_i;
    size_t i, j;
    int scene;
    for (scene = 0; scene < SCENE_COUNT; scene++)
        for (i = 0; i < COUNT(sizes); i++)
            for (j = 0; j < COUNT(sizes); j++)
                prune_and_compare(&random, (scene_kind)scene, (uint32_t)_i, (size_t)sizes[i], sizes[j]);
}
END_TEST

/* By hand: 0-1 touch, 1-2 overlap, 3 is far; the two sets meet in 1-0 only. */
START_TEST(a_named_case)
{
    box a[4], b[2];
    msap_boxes boxes_a, boxes_b;
    msap_index_pair *pairs = NULL;
    size_t count = 0;
    a[0] = bar(0, 1);
    a[1] = bar(1, 3);
    a[2] = bar(2, 4);
    a[3] = bar(9, 10);
    b[0] = bar(1.5f, 1.75f);
    b[1] = bar(20, 21);
    boxes_a = boxes_in_row(a);
    boxes_b = boxes_in_row(b);
    ok(msap_prune(NULL, 4, &boxes_a, &pairs, &count, NULL));
    ck_assert_uint_eq(count, 2);
    ck_assert(pairs[0].a == 0 && pairs[0].b == 1 && pairs[1].a == 1 && pairs[1].b == 2);
    ok(msap_prune_free(NULL, pairs, count));
    ok(msap_prune_bipartite(NULL, 4, &boxes_a, 2, &boxes_b, &pairs, &count, NULL));
    ck_assert_uint_eq(count, 1);
    ck_assert(pairs[0].a == 1 && pairs[0].b == 0);
    ok(msap_prune_free(NULL, pairs, count));
    ok(msap_prune_free(NULL, NULL, 0));
}
END_TEST

/* Doubles are rounded outward, here to touching. */
START_TEST(doubles)
{
    static const double min[2][3] = {{0, 0, 0}, {1 + 0x1p-52, 0, 0}}, max[2][3] = {{1, 1, 1}, {2, 1, 1}};
    msap_boxes boxes = {sizeof boxes, MSAP_DOUBLE, NULL, NULL, 24, 8, 24, 8};
    msap_index_pair *pairs = NULL;
    size_t count = 0;
    boxes.min = min;
    boxes.max = max;
    ok(msap_prune(NULL, 2, &boxes, &pairs, &count, NULL));
    ck_assert_uint_eq(count, 1);
    ok(msap_prune_free(NULL, pairs, count));
}
END_TEST

/* Both calls refuse, and *error tells index and bound. */
static void both_refuse(const msap_prune_config *config, const box *boxes, size_t k, msap_status status,
                        uint64_t index, msap_bound bound)
{
    box first = cube(0, 1);
    msap_boxes ones = boxes_in_row(&first), many = boxes_in_row(boxes);
    msap_error error = {sizeof error, 0, 77, 77, 0};
    msap_index_pair *pairs = NULL;
    size_t count = 77;
    ones.min_row = ones.max_row = 0;
    refused(msap_prune(config, k, &many, &pairs, &count, &error), status);
    ck_assert(error.status == (uint32_t)status && error.index == index && error.bound == (uint32_t)bound);
    refused(msap_prune_bipartite(config, k, &many, 10, &ones, &pairs, &count, &error), status);
    ck_assert(error.status == (uint32_t)status && error.index == index && error.bound == (uint32_t)bound);
    refused(msap_prune_bipartite(config, 10, &ones, k, &many, &pairs, &count, &error), status);
    ck_assert(error.status == (uint32_t)status && error.index == index + 10 && error.bound == (uint32_t)bound);
    refused(msap_prune(config, k, &many, &pairs, &count, NULL), status);
    ck_assert(pairs == NULL && count == 77);
}

START_TEST(bad_boxes_are_named)
{
    box boxes[7] = {{{0, 0, 0}, {1, 1, 1}}};
    tracker m = {0};
    msap_prune_config config = prune_config(3, MSAP_AXIS_AUTO, &m);
    int i, axis;
    for (i = 0; i < 7; i++)
        for (axis = 0; axis < 3; axis++) {
            boxes[i] = cube(0, 1);
            boxes[i].min[axis] = float_of(0xFFC00001);
            both_refuse(&config, boxes, 7, MSAP_ERROR_NAN, (uint64_t)i, (msap_bound)axis);
            boxes[i] = cube(0, 1);
            boxes[i].max[axis] = float_of(0x7F800001);
            both_refuse(&config, boxes, 7, MSAP_ERROR_NAN, (uint64_t)i, (msap_bound)(axis + 3));
            boxes[i] = cube(1, 1);
            boxes[i].min[axis] = float_of(0x3F800001);
            both_refuse(&config, boxes, 7, MSAP_ERROR_INVERTED, (uint64_t)i, (msap_bound)axis);
            boxes[i] = cube(0, 1);
        }
    ck_assert(m.blocks == 0 && m.wrong == 0);
}
END_TEST

START_TEST(bad_config)
{
    static const uint32_t sizes[] = {0, 1, sizeof(msap_prune_config) - 1, sizeof(msap_prune_config) + 1};
    static const struct {
        uint32_t dims;
        int32_t axis;
    } wrong[] = {{0, -1}, {1, -1}, {4, -1}, {3, -2}, {3, 3}, {2, 2}, {3, INT32_MAX}, {3, INT32_MIN}};
    tracker m = {0};
    box boxes[1] = {{{0, 0, 0}, {1, 1, 1}}};
    msap_prune_config config;
    size_t i;
    for (i = 0; i < COUNT(sizes); i++) {
        msap_index_pair *pairs = NULL;
        size_t count = 77;
        msap_boxes row = boxes_in_row(boxes);
        config = prune_config(3, MSAP_AXIS_AUTO, &m);
        config.struct_size = sizes[i];
        refused(msap_prune(&config, 1, &row, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune_bipartite(&config, 1, &row, 1, &row, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_prune_free(&config, NULL, 0), MSAP_ERROR_STRUCT_SIZE);
        ck_assert(pairs == NULL && count == 77);
    }
    for (i = 0; i < COUNT(wrong); i++) {
        msap_boxes row = boxes_in_row(boxes);
        msap_index_pair *pairs = NULL;
        size_t count;
        config = prune_config(wrong[i].dims, wrong[i].axis, &m);
        refused(msap_prune(&config, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
        refused(msap_prune_bipartite(&config, 1, &row, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    }
    ck_assert_uint_eq(m.calls, 0);
}
END_TEST

START_TEST(bad_config_values)
{
    box boxes[1] = {{{0, 0, 0}, {1, 1, 1}}};
    msap_boxes row = boxes_in_row(boxes);
    msap_prune_config config = prune_config(3, MSAP_AXIS_AUTO, NULL);
    msap_index_pair *pairs = NULL;
    size_t count;
    config.reserved = 1;
    refused(msap_prune(&config, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    config.reserved = 0;
    config.alloc = tracked_alloc;
    refused(msap_prune(&config, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    config.alloc = NULL;
    config.free = tracked_free;
    refused(msap_prune(&config, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    ck_assert_ptr_null(pairs);
}
END_TEST

START_TEST(bad_arguments)
{
    box boxes[1] = {{{0, 0, 0}, {1, 1, 1}}};
    msap_boxes row = boxes_in_row(boxes), size = row, scalar = row, no_min = row, no_max = row;
    msap_index_pair *pairs = NULL;
    size_t count = 77;
    msap_error error = {sizeof error + 1, 0, 0, 0, 0};
    size.struct_size--;
    scalar.scalar = 2;
    no_min.min = NULL;
    no_max.max = NULL;
    refused(msap_prune(NULL, 1, NULL, &pairs, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune(NULL, 1, &row, NULL, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune(NULL, 1, &row, &pairs, NULL, NULL), MSAP_ERROR_NULL);
    refused(msap_prune(NULL, 1, &no_min, &pairs, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune(NULL, 1, &no_max, &pairs, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune(NULL, 1, &size, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
    refused(msap_prune(NULL, 1, &scalar, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    refused(msap_prune(NULL, 1, &row, &pairs, &count, &error), MSAP_ERROR_STRUCT_SIZE);
    refused(msap_prune_bipartite(NULL, 1, NULL, 1, &row, &pairs, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune_bipartite(NULL, 1, &row, 1, NULL, &pairs, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune_bipartite(NULL, 1, &row, 1, &row, NULL, &count, NULL), MSAP_ERROR_NULL);
    refused(msap_prune_bipartite(NULL, 1, &row, 1, &row, &pairs, NULL, NULL), MSAP_ERROR_NULL);
    refused(msap_prune_bipartite(NULL, 1, &row, 1, &size, &pairs, &count, NULL), MSAP_ERROR_STRUCT_SIZE);
    refused(msap_prune_bipartite(NULL, 1, &scalar, 1, &row, &pairs, &count, NULL), MSAP_ERROR_CONFIG);
    refused(msap_prune_bipartite(NULL, 1, &row, 1, &row, &pairs, &count, &error), MSAP_ERROR_STRUCT_SIZE);
    ck_assert(pairs == NULL && count == 77);
}
END_TEST

/* The n-th allocation fails: a status, no leak; or all is well, where it can do without
 * it. */
START_TEST(any_allocation_may_fail)
{
    static box boxes[MOST];
    msap_boxes row = boxes_in_row(boxes);
    msap_status status;
    uint64_t random = 4;
    size_t n = 0, failures = 0, came = 1;
    random_boxes(&random, SCENE_GRID, boxes, MOST);
    while (came) {
        tracker m = {0};
        msap_prune_config config = prune_config(3, MSAP_AXIS_AUTO, &m);
        msap_error error = {sizeof error, 0, 0, 0, 0};
        msap_index_pair *pairs = NULL;
        size_t count = 77;
        m.fail_at = ++n;
        status = _i ? msap_prune_bipartite(&config, MOST, &row, MOST, &row, &pairs, &count, &error)
                    : msap_prune(&config, MOST, &row, &pairs, &count, &error);
        if (status == MSAP_OK) {
            ck_assert_uint_gt(count, 0);
            ok(msap_prune_free(&config, pairs, count));
        } else {
            refused(status, MSAP_ERROR_MEMORY);
            ck_assert(pairs == NULL && count == 77 && error.status == MSAP_ERROR_MEMORY);
        }
        ck_assert(m.blocks == 0 && m.bytes == 0 && m.wrong == 0);
        came = m.failures;
        failures += status != MSAP_OK;
    }
    ck_assert_uint_gt(failures, 4);
}
END_TEST

/* In a row along one axis, each touching the next; in one place on the others. */
START_TEST(a_row_of_boxes)
{
    static box boxes[10000];
    msap_boxes row = boxes_in_row(boxes);
    msap_index_pair *pairs = NULL;
    size_t i, count = 0;
    for (i = 0; i < COUNT(boxes); i++) {
        boxes[i] = cube(0, 1);
        boxes[i].min[_i] = (float)(2 * i);
        boxes[i].max[_i] = (float)(2 * i + 2);
    }
    ok(msap_prune(NULL, COUNT(boxes), &row, &pairs, &count, NULL));
    ck_assert_uint_eq(count, COUNT(boxes) - 1);
    for (i = 0; i < count; i++)
        ck_assert(pairs[i].a == i && pairs[i].b == i + 1);
    ok(msap_prune_free(NULL, pairs, count));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("prune");
    tcase_add_loop_test(tests, complete_is_brute_force, 2, 4);
    tcase_add_loop_test(tests, bipartite_is_brute_force, 2, 4);
    tcase_add_test(tests, a_named_case);
    tcase_add_test(tests, doubles);
    tcase_add_test(tests, bad_boxes_are_named);
    tcase_add_test(tests, bad_config);
    tcase_add_test(tests, bad_config_values);
    tcase_add_test(tests, bad_arguments);
    tcase_add_loop_test(tests, any_allocation_may_fail, 0, 2);
    tcase_add_loop_test(tests, a_row_of_boxes, 0, 3);
    return run_case(tests, "prune");
}
