/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: every public function refuses NULL where it may not be, says so in the
 * last error, and writes nothing; every status has a text of its own; the numbers
 * that bindings rely on are pinned; the last error stays until the next.
 */
#include <stdio.h>
#include <string.h>

#include "checks.h"

START_TEST(every_status_has_a_text)
{
    int i, j;
    for (i = 0; i < MSAP_STATUS_COUNT; i++) {
        const char *text = msap_status_text((msap_status)i);
        ck_assert_ptr_nonnull(text);
        ck_assert_uint_gt(strlen(text), 0);
        for (j = 0; j < i; j++)
            ck_assert_str_ne(text, msap_status_text((msap_status)j));
    }
}
END_TEST

START_TEST(no_status_has_one_too)
{
    static const int none[] = {-1, MSAP_STATUS_COUNT, 1000, INT32_MAX, INT32_MIN};
    size_t i;
    int j;
    for (i = 0; i < COUNT(none); i++) {
        const char *text = msap_status_text((msap_status)none[i]);
        ck_assert_ptr_nonnull(text);
        for (j = 0; j < MSAP_STATUS_COUNT; j++)
            ck_assert_str_ne(text, msap_status_text((msap_status)j));
    }
}
END_TEST

START_TEST(numbers_are_pinned)
{
    ck_assert_int_eq(MSAP_OK, 0);
    ck_assert_int_eq(MSAP_ERROR_NULL, 1);
    ck_assert_int_eq(MSAP_ERROR_STRUCT_SIZE, 2);
    ck_assert_int_eq(MSAP_ERROR_CONFIG, 3);
    ck_assert_int_eq(MSAP_ERROR_MEMORY, 4);
    ck_assert_int_eq(MSAP_ERROR_NAN, 5);
    ck_assert_int_eq(MSAP_ERROR_INVERTED, 6);
    ck_assert_int_eq(MSAP_ERROR_HANDLE, 7);
    ck_assert_int_eq(MSAP_ERROR_FULL, 8);
    ck_assert_int_eq(MSAP_ERROR_BUSY, 9);
    ck_assert_int_eq(MSAP_ERROR_NOT_A_PAIR, 10);
    ck_assert_int_eq(MSAP_ERROR_CORRUPT, 11);
    ck_assert_int_eq(MSAP_STATUS_COUNT, 12);
    ck_assert(MSAP_STRATEGY_SLIDE == 1 && MSAP_STRATEGY_MERGE == 2 && MSAP_STRATEGY_SWEEP == 3);
    ck_assert(MSAP_FLOAT == 0 && MSAP_DOUBLE == 1 && MSAP_STATIC == 1);
    ck_assert(MSAP_MIN_X == 0 && MSAP_MAX_X == 3 && MSAP_NO_BOUND == 6 && MSAP_AXIS_AUTO == -1);
    ck_assert(offsetof(msap_pair, b) == 8 && offsetof(msap_pair, user_data) == 16 && sizeof(msap_index_pair) == 8);
}
END_TEST

START_TEST(the_version_is_that_of_the_header)
{
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", MSAP_VERSION_MAJOR, MSAP_VERSION_MINOR, MSAP_VERSION_PATCH);
    ck_assert_uint_eq(msap_version(), MSAP_VERSION_NUMBER);
    ck_assert_str_eq(msap_version_text(), text);
}
END_TEST

/* ---------------------------------------------------------- NULL, by groups */

static const float zero[3] = {0, 0, 0}, one[3] = {1, 1, 1};

/* An owner call that must refuse a NULL, and leave it as the last error of the world
 * `w` in which it is used. */
#define refuses_null(call) \
    do { \
        refused(msap_remove(w, MSAP_NULL_HANDLE), MSAP_ERROR_HANDLE); \
        refused(call, MSAP_ERROR_NULL); \
        last_error(w, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND); \
    } while (0)

START_TEST(null_in_box_calls)
{
    msap_world *w = new_world(3, DEFAULT);
    msap_handle a = add(w, cube(0, 1)), out = 77;
    void *data = w;
    refused(msap_add(NULL, zero, one, 0, NULL, &out), MSAP_ERROR_NULL);
    refuses_null(msap_add(w, NULL, one, 0, NULL, &out));
    refuses_null(msap_add(w, zero, NULL, 0, NULL, &out));
    refuses_null(msap_add(w, zero, one, 0, NULL, NULL));
    refused(msap_update(NULL, a, zero, one), MSAP_ERROR_NULL);
    refuses_null(msap_update(w, a, NULL, one));
    refuses_null(msap_update(w, a, zero, NULL));
    refused(msap_remove(NULL, a), MSAP_ERROR_NULL);
    refused(msap_remove_many(NULL, 1, &a), MSAP_ERROR_NULL);
    refuses_null(msap_remove_many(w, 1, NULL));
    refused(msap_set_user_data(NULL, 1, &a, &data), MSAP_ERROR_NULL);
    refuses_null(msap_set_user_data(w, 1, NULL, &data));
    refuses_null(msap_set_user_data(w, 1, &a, NULL));
    ck_assert_uint_eq(out, 77);
    ck_assert_uint_eq(stats_of(w).pending, 1);
    ok(msap_destroy(w));
}
END_TEST

START_TEST(null_in_batches)
{
    msap_world *w = new_world(3, DEFAULT);
    box unit = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&unit), no_min = boxes, no_max = boxes;
    msap_handle a = add(w, unit), out = 77;
    no_min.min = NULL;
    no_max.max = NULL;
    refused(msap_add_many(NULL, 1, &boxes, NULL, NULL, &out), MSAP_ERROR_NULL);
    refuses_null(msap_add_many(w, 1, NULL, NULL, NULL, &out));
    refuses_null(msap_add_many(w, 1, &no_min, NULL, NULL, &out));
    refuses_null(msap_add_many(w, 1, &no_max, NULL, NULL, &out));
    refuses_null(msap_add_many(w, 1, &boxes, NULL, NULL, NULL));
    refused(msap_update_many(NULL, 1, &a, &boxes), MSAP_ERROR_NULL);
    refuses_null(msap_update_many(w, 1, NULL, &boxes));
    refuses_null(msap_update_many(w, 1, &a, NULL));
    refuses_null(msap_update_many(w, 1, &a, &no_min));
    refuses_null(msap_update_many(w, 1, &a, &no_max));
    ck_assert_uint_eq(out, 77);
    ck_assert_uint_eq(stats_of(w).boxes, 1);
    ok(msap_destroy(w));
}
END_TEST

START_TEST(null_in_commit_and_pair_calls)
{
    msap_world *w = new_world(3, DEFAULT);
    msap_handle a = add(w, cube(0, 1)), b = add(w, cube(0, 1));
    void *data = w;
    refused(msap_commit(NULL, NULL, NULL), MSAP_ERROR_NULL);
    ok(msap_commit(w, NULL, NULL));
    refused(msap_get_pair_data(NULL, 1, &a, &b, &data), MSAP_ERROR_NULL);
    refused(msap_get_pair_data(w, 1, NULL, &b, &data), MSAP_ERROR_NULL);
    refused(msap_get_pair_data(w, 1, &a, NULL, &data), MSAP_ERROR_NULL);
    refused(msap_get_pair_data(w, 1, &a, &b, NULL), MSAP_ERROR_NULL);
    refused(msap_set_pair_data(NULL, 1, &a, &b, &data), MSAP_ERROR_NULL);
    refuses_null(msap_set_pair_data(w, 1, NULL, &b, &data));
    refuses_null(msap_set_pair_data(w, 1, &a, NULL, &data));
    refuses_null(msap_set_pair_data(w, 1, &a, &b, NULL));
    refused(msap_trim(NULL), MSAP_ERROR_NULL);
    ok(msap_destroy(NULL));
    ok(msap_destroy(w));
}
END_TEST

START_TEST(null_in_reads)
{
    msap_world *w = new_world(3, DEFAULT);
    msap_handle a = add(w, cube(0, 1));
    const msap_pair *pairs = NULL;
    msap_world_stats stats = stats_of(w);
    msap_error error = {sizeof error, 0, 0, 0, 0};
    float bound[3];
    void *data;
    size_t count = 77;
    refused(msap_get_bounds(NULL, a, bound, bound), MSAP_ERROR_NULL);
    refused(msap_get_bounds(w, a, NULL, bound), MSAP_ERROR_NULL);
    refused(msap_get_bounds(w, a, bound, NULL), MSAP_ERROR_NULL);
    refused(msap_get_user_data(NULL, 1, &a, &data), MSAP_ERROR_NULL);
    refused(msap_get_user_data(w, 1, NULL, &data), MSAP_ERROR_NULL);
    refused(msap_get_user_data(w, 1, &a, NULL), MSAP_ERROR_NULL);
    refused(msap_created(NULL, &pairs, &count), MSAP_ERROR_NULL);
    refused(msap_created(w, NULL, &count), MSAP_ERROR_NULL);
    refused(msap_created(w, &pairs, NULL), MSAP_ERROR_NULL);
    refused(msap_deleted(NULL, &pairs, &count), MSAP_ERROR_NULL);
    refused(msap_deleted(w, NULL, &count), MSAP_ERROR_NULL);
    refused(msap_deleted(w, &pairs, NULL), MSAP_ERROR_NULL);
    refused(msap_pairs(NULL, &pairs, &count), MSAP_ERROR_NULL);
    refused(msap_pairs(w, NULL, &count), MSAP_ERROR_NULL);
    refused(msap_pairs(w, &pairs, NULL), MSAP_ERROR_NULL);
    refused(msap_stats(NULL, &stats), MSAP_ERROR_NULL);
    refused(msap_stats(w, NULL), MSAP_ERROR_NULL);
    refused(msap_last_error(NULL, &error), MSAP_ERROR_NULL);
    refused(msap_last_error(w, NULL), MSAP_ERROR_NULL);
    refused(msap_validate(NULL, NULL), MSAP_ERROR_NULL);
    ck_assert(count == 77 && pairs == NULL);
    last_error(w, MSAP_OK, 0, MSAP_NO_BOUND); /* reads leave no error */
    ok(msap_destroy(w));
}
END_TEST

/* ------------------------------------------------------------ the last error */

START_TEST(the_last_error_stays_until_the_next)
{
    msap_world *w = new_world(3, DEFAULT);
    msap_handle a;
    float bound[3];
    void *data;
    last_error(w, MSAP_OK, 0, MSAP_NO_BOUND);
    a = add(w, cube(0, 1));
    refused(msap_update(w, a, one, zero), MSAP_ERROR_INVERTED);
    last_error(w, MSAP_ERROR_INVERTED, 0, MSAP_MIN_X);
    update(w, a, cube(1, 2)); /* success does not clear it */
    commit(w, 0, 0, 0);
    last_error(w, MSAP_ERROR_INVERTED, 0, MSAP_MIN_X);
    refused(msap_get_bounds(w, 99, bound, bound), MSAP_ERROR_HANDLE); /* nor does a read set it */
    refused(msap_get_pair_data(w, 1, &a, &a, &data), MSAP_ERROR_NOT_A_PAIR);
    last_error(w, MSAP_ERROR_INVERTED, 0, MSAP_MIN_X);
    refused(msap_remove(w, 99), MSAP_ERROR_HANDLE);
    last_error(w, MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    ok(msap_destroy(w));
}
END_TEST

START_TEST(each_world_has_its_own_last_error)
{
    msap_world *a = new_world(3, DEFAULT), *b = new_world(3, DEFAULT);
    refused(msap_remove(a, 1), MSAP_ERROR_HANDLE);
    last_error(a, MSAP_ERROR_HANDLE, 0, MSAP_NO_BOUND);
    last_error(b, MSAP_OK, 0, MSAP_NO_BOUND);
    ok(msap_destroy(a));
    ok(msap_destroy(b));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("errors");
    tcase_add_test(tests, every_status_has_a_text);
    tcase_add_test(tests, no_status_has_one_too);
    tcase_add_test(tests, numbers_are_pinned);
    tcase_add_test(tests, the_version_is_that_of_the_header);
    tcase_add_test(tests, null_in_box_calls);
    tcase_add_test(tests, null_in_batches);
    tcase_add_test(tests, null_in_commit_and_pair_calls);
    tcase_add_test(tests, null_in_reads);
    tcase_add_test(tests, the_last_error_stays_until_the_next);
    tcase_add_test(tests, each_world_has_its_own_last_error);
    return run_case(tests, "errors");
}
