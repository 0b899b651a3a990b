/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * What the Check programs share: short ways to call the library where it must
 * succeed, and to run a test case as a program.
 */
#ifndef CHECKS_H
#define CHECKS_H

#include <check.h>
#include <stdlib.h>

#include "common.h"
#include "setups.h"

/* A call that must come to this status. Check takes a note of every assertion, and reads the notes in a time
 * that is quadratic in their number; so what is asserted by the million is asserted only where it fails. */
#define refused(call, status) \
    do { \
        msap_status came_ = (call); \
        if (came_ != (status)) ck_abort_msg("%s: %s came to %d, not %s", setup_name, #call, (int)came_, #status); \
    } while (0)
#define ok(call) refused(call, MSAP_OK)

/* The name of the set-up that was asked for last, for messages. */
static const char *setup_name = "no set-up";

/* A comparison (see common.h) that must find nothing wrong. */
#define right(comparison) \
    do { \
        const char *wrong_ = (comparison); \
        if (wrong_) ck_abort_msg("%s: %s", setup_name, wrong_); \
    } while (0)

/* The rows of setups.h that tests name. */
enum { DEFAULT, SINGLE_SAP };

/* In loop tests over the SETUPS, the loop variable is the row. */
static inline msap_config config_of(uint32_t dims, int row)
{
    setup_name = setups[row].name;
    return setup_config(dims, row);
}

static inline msap_world *new_world(uint32_t dims, int row)
{
    msap_config config = config_of(dims, row);
    msap_world *world = NULL;
    ok(msap_create(&config, &world));
    ck_assert_ptr_nonnull(world);
    return world;
}

static inline box box_of(float x0, float y0, float z0, float x1, float y1, float z1)
{
    box result;
    result.min[0] = x0;
    result.min[1] = y0;
    result.min[2] = z0;
    result.max[0] = x1;
    result.max[1] = y1;
    result.max[2] = z1;
    return result;
}

/* A cube: from `low` to `high` on all axes. */
static inline box cube(float low, float high)
{
    return box_of(low, low, low, high, high, high);
}

/* From `low` to `high` on x, [0, 1] on the others. */
static inline box bar(float low, float high)
{
    return box_of(low, 0, 0, high, 1, 1);
}

static inline msap_handle add_flagged(msap_world *world, box bounds, uint32_t flags)
{
    msap_handle handle = MSAP_NULL_HANDLE;
    ok(msap_add(world, bounds.min, bounds.max, flags, NULL, &handle));
    ck_assert_uint_ne(handle, MSAP_NULL_HANDLE);
    return handle;
}

static inline msap_handle add(msap_world *world, box bounds)
{
    return add_flagged(world, bounds, 0);
}

static inline void update(msap_world *world, msap_handle handle, box bounds)
{
    ok(msap_update(world, handle, bounds.min, bounds.max));
}

/* A commit that must come to these events and leave these pairs. */
static inline void commit(msap_world *world, uint64_t deleted, uint64_t created, uint64_t active)
{
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    const char *what = NULL;
    ok(msap_commit(world, NULL, &counts));
    ck_assert_msg(counts.deleted == deleted && counts.created == created && counts.active == active,
                  "%s: %lu deleted, %lu created, %lu active", setup_name, (unsigned long)counts.deleted,
                  (unsigned long)counts.created, (unsigned long)counts.active);
    ck_assert_msg(msap_validate(world, &what) == MSAP_OK, "%s: %s", setup_name, what ? what : "no reason given");
}

static inline int is_pair(const msap_world *world, msap_handle a, msap_handle b)
{
    void *data;
    msap_status status = msap_get_pair_data(world, 1, &a, &b, &data);
    ck_assert(status == MSAP_OK || status == MSAP_ERROR_NOT_A_PAIR);
    return status == MSAP_OK;
}

static inline msap_world_stats stats_of(const msap_world *world)
{
    msap_world_stats stats;
    stats.struct_size = sizeof stats;
    ok(msap_stats(world, &stats));
    return stats;
}

/* The last error must be this one. */
static inline void last_error(const msap_world *world, msap_status status, uint64_t index, msap_bound bound)
{
    msap_error error;
    error.struct_size = sizeof error;
    ok(msap_last_error(world, &error));
    ck_assert_uint_eq(error.struct_size, sizeof error);
    ck_assert_uint_eq(error.status, status);
    ck_assert_uint_eq(error.index, index);
    ck_assert_uint_eq(error.bound, bound);
}

/* The validator must say this of a world. */
static inline void is_broken(const msap_world *world, const char *sentence)
{
    const char *what = NULL;
    refused(msap_validate(world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, sentence);
}

/* Runs the tests of one case; what main returns. There is no time limit: how long
 * a test takes says nothing about whether it passes. */
static inline int run_case(TCase *tests, const char *name)
{
    Suite *suite = suite_create(name);
    SRunner *runner = srunner_create(suite);
    int failed;
    tcase_set_timeout(tests, 0);
    suite_add_tcase(suite, tests);
    srunner_run_all(runner, CK_ENV);
    failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}

#endif
