/* The part of Check that the tests of the library use, as plain C: every test runs in
 * the program itself, and the first that fails ends it.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * For where Check cannot be linked: other machines, and sanitizers that must see all
 * code that runs. Put this folder before the system's (-Itests/trust/nocheck) and do
 * without -lcheck.
 */
#ifndef NOCHECK_CHECK_H
#define NOCHECK_CHECK_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CK_ENV 0

typedef struct TCase {
    const char *name;
    int tests;
} TCase;
typedef TCase Suite;
typedef TCase SRunner;

#define START_TEST(name) static void name(int _i) { (void)_i;
#define END_TEST }

/* ------------------------------------------------------------------ running */

static TCase nocheck_case;
static const char *nocheck_test = "";
static int nocheck_row;

static inline TCase *tcase_create(const char *name)
{
    nocheck_case.name = name;
    return &nocheck_case;
}

static inline void nocheck_run(TCase *tests, const char *name, void (*test)(int), int first, int end)
{
    nocheck_test = name;
    for (nocheck_row = first; nocheck_row < end; nocheck_row++, tests->tests++)
        test(nocheck_row);
}

#define tcase_add_loop_test(tests, test, first, end) nocheck_run(tests, #test, test, first, end)
#define tcase_add_test(tests, test) nocheck_run(tests, #test, test, 0, 1)
#define tcase_add_unchecked_fixture(tests, setup, teardown) ((void)(tests), (setup)(), (void)atexit(teardown))
#define tcase_set_timeout(tests, seconds) ((void)(tests))

static inline Suite *suite_create(const char *name)
{
    (void)name;
    return &nocheck_case;
}
static inline void suite_add_tcase(Suite *suite, TCase *tests)
{
    (void)suite;
    (void)tests;
}
static inline SRunner *srunner_create(Suite *suite) { return suite; }
static inline void srunner_run_all(SRunner *runner, int mode)
{
    (void)mode;
    printf("%s: %d checks\n", runner->name, runner->tests);
}
static inline int srunner_ntests_failed(const SRunner *runner) { return runner->tests == 0; }
static inline void srunner_free(SRunner *runner) { (void)runner; }

/* --------------------------------------------------------------- assertions */

#define nocheck_fail(...) \
    (fprintf(stderr, "%s:%d: %s, row %d: ", __FILE__, __LINE__, nocheck_test, nocheck_row), \
     fprintf(stderr, __VA_ARGS__), fputc('\n', stderr), exit(EXIT_FAILURE))

#define ck_assert_msg(condition, ...) ((condition) ? (void)0 : nocheck_fail(__VA_ARGS__))
#define ck_abort_msg(...) nocheck_fail(__VA_ARGS__)
#define ck_assert(condition) ck_assert_msg(condition, "%s", #condition)

/* Each side once. */
#define nocheck_compare(type, x, relation, y) \
    do { \
        type nocheck_x = (type)(x), nocheck_y = (type)(y); \
        ck_assert_msg(nocheck_x relation nocheck_y, "%s %s %s: %lld, %lld", #x, #relation, #y, (long long)nocheck_x, \
                      (long long)nocheck_y); \
    } while (0)

#define ck_assert_int_eq(x, y) nocheck_compare(intmax_t, x, ==, y)
#define ck_assert_int_ne(x, y) nocheck_compare(intmax_t, x, !=, y)
#define ck_assert_int_lt(x, y) nocheck_compare(intmax_t, x, <, y)
#define ck_assert_int_le(x, y) nocheck_compare(intmax_t, x, <=, y)
#define ck_assert_int_gt(x, y) nocheck_compare(intmax_t, x, >, y)
#define ck_assert_int_ge(x, y) nocheck_compare(intmax_t, x, >=, y)
#define ck_assert_uint_eq(x, y) nocheck_compare(uintmax_t, x, ==, y)
#define ck_assert_uint_ne(x, y) nocheck_compare(uintmax_t, x, !=, y)
#define ck_assert_uint_lt(x, y) nocheck_compare(uintmax_t, x, <, y)
#define ck_assert_uint_le(x, y) nocheck_compare(uintmax_t, x, <=, y)
#define ck_assert_uint_gt(x, y) nocheck_compare(uintmax_t, x, >, y)
#define ck_assert_uint_ge(x, y) nocheck_compare(uintmax_t, x, >=, y)

#define ck_assert_ptr_eq(x, y) ck_assert_msg((const void *)(x) == (const void *)(y), "%s is not %s", #x, #y)
#define ck_assert_ptr_ne(x, y) ck_assert_msg((const void *)(x) != (const void *)(y), "%s is %s", #x, #y)
#define ck_assert_ptr_null(x) ck_assert_msg((x) == NULL, "%s is not NULL", #x)
#define ck_assert_ptr_nonnull(x) ck_assert_msg((x) != NULL, "%s is NULL", #x)
#define ck_assert_str_eq(x, y) ck_assert_msg(strcmp(x, y) == 0, "%s is not %s", x, y)
#define ck_assert_str_ne(x, y) ck_assert_msg(strcmp(x, y) != 0, "%s is the same", x)

#endif
