/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: every struct tells its size, and a size or a value that this library does
 * not know is refused, never guessed at; the defaults are those of the header.
 */
#include <string.h>

#include "checks.h"

static void *some_alloc(void *user, size_t size)
{
    (void)user;
    return malloc(size);
}

static void some_free(void *user, void *pointer, size_t size)
{
    (void)user;
    (void)size;
    free(pointer);
}

/* Sizes that no version had. */
static const size_t wrong_sizes[] = {0, 1, 3, 4, 5, 7, 9, 13, sizeof(msap_config) - 1, sizeof(msap_config) + 1,
                                     sizeof(msap_config) + 8, 4096, (size_t)UINT32_MAX};

START_TEST(defaults)
{
    msap_config config;
    memset(&config, 0xFF, sizeof config);
    ok(msap_config_init(&config, sizeof config));
    ck_assert_uint_eq(config.struct_size, sizeof config);
    ck_assert_uint_eq(config.dims, 3);
    ck_assert_uint_eq(config.strategy, MSAP_STRATEGY_AUTO);
    ck_assert_uint_eq(config.filters, 1);
    ck_assert_uint_eq(config.max_boxes, MSAP_MAX_BOXES);
    ck_assert_uint_eq(config.reserved, 0);
    ck_assert(!config.alloc && !config.free && !config.allocator_user);
}
END_TEST

START_TEST(prune_defaults)
{
    msap_prune_config config;
    memset(&config, 0xFF, sizeof config);
    ok(msap_prune_config_init(&config, sizeof config));
    ck_assert_uint_eq(config.struct_size, sizeof config);
    ck_assert_uint_eq(config.dims, 3);
    ck_assert_int_eq(config.axis, MSAP_AXIS_AUTO);
    ck_assert_uint_eq(config.reserved, 0);
    ck_assert(!config.alloc && !config.free && !config.allocator_user);
}
END_TEST

/* A refused init writes nothing: the struct may be smaller than it seems. */
START_TEST(init_refuses_sizes)
{
    msap_config config, untouched;
    size_t i;
    memset(&config, 0x5A, sizeof config);
    memset(&untouched, 0x5A, sizeof untouched);
    for (i = 0; i < COUNT(wrong_sizes); i++)
        refused(msap_config_init(&config, wrong_sizes[i]), MSAP_ERROR_STRUCT_SIZE);
    ck_assert_int_eq(memcmp(&config, &untouched, sizeof config), 0);
    refused(msap_config_init(NULL, sizeof config), MSAP_ERROR_NULL);
}
END_TEST

START_TEST(prune_init_refuses_sizes)
{
    static const size_t wrong[] = {0, 1, 4, sizeof(msap_prune_config) - 1, sizeof(msap_prune_config) + 1, 4096};
    msap_prune_config config, untouched;
    size_t i;
    memset(&config, 0x5A, sizeof config);
    memset(&untouched, 0x5A, sizeof untouched);
    for (i = 0; i < COUNT(wrong); i++)
        refused(msap_prune_config_init(&config, wrong[i]), MSAP_ERROR_STRUCT_SIZE);
    ck_assert_int_eq(memcmp(&config, &untouched, sizeof config), 0);
    refused(msap_prune_config_init(NULL, sizeof config), MSAP_ERROR_NULL);
}
END_TEST

static void create_refuses(const msap_config *config, msap_status status)
{
    msap_world *world = NULL;
    refused(msap_create(config, &world), status);
    ck_assert_ptr_null(world);
}

START_TEST(create_refuses_sizes)
{
    size_t i;
    for (i = 0; i < COUNT(wrong_sizes); i++) {
        msap_config config = config_of(3, DEFAULT);
        config.struct_size = (uint32_t)wrong_sizes[i];
        create_refuses(&config, MSAP_ERROR_STRUCT_SIZE);
    }
}
END_TEST

START_TEST(create_refuses_values)
{
    static const uint32_t dims[] = {0, 1, 4, UINT32_MAX}, strategies[] = {4, 5, UINT32_MAX};
    static const uint32_t filters[] = {2, UINT32_MAX};
    const msap_config good = config_of(3, DEFAULT);
    msap_config config;
    size_t i;
    for (i = 0; i < COUNT(dims); i++) {
        config = good;
        config.dims = dims[i];
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    for (i = 0; i < COUNT(strategies); i++) {
        config = good;
        config.strategy = strategies[i];
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    for (i = 0; i < COUNT(filters); i++) {
        config = good;
        config.filters = filters[i];
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    config = good;
    config.reserved = 1;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config = good;
    config.max_boxes = MSAP_MAX_BOXES + 1;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config = good;
    config.alloc = some_alloc;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.alloc = NULL;
    config.free = some_free;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    refused(msap_create(&good, NULL), MSAP_ERROR_NULL);
    refused(msap_create(NULL, NULL), MSAP_ERROR_NULL);
}
END_TEST

/* The config is copied; without one the defaults hold. */
START_TEST(create_copies_the_config)
{
    msap_config config = config_of(2, MSAP_STRATEGY_SWEEP);
    msap_world *world = NULL;
    float bound[2] = {0, 0};
    msap_handle handle;
    config.alloc = some_alloc;
    config.free = some_free;
    ok(msap_create(&config, &world));
    memset(&config, 0xFF, sizeof config);
    ok(msap_add(world, bound, bound, 0, NULL, &handle));
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
    ok(msap_create(NULL, &world));
    add(world, box_of(0, 0, 0, 1, 1, 1));
    add(world, box_of(0, 0, 2, 1, 1, 3)); /* apart on z: the default is 3D */
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

/* The structs of the other calls. */
START_TEST(calls_refuse_sizes)
{
    static const int offsets[] = {-8, -4, -1, 1, 4, 8, 1000};
    msap_world *world = new_world(3, DEFAULT);
    box unit = cube(0, 1);
    msap_handle handle = add(world, unit), other = 77;
    size_t i;
    add(world, unit);
    for (i = 0; i < COUNT(offsets); i++) {
        msap_boxes boxes = boxes_in_row(&unit);
        msap_callbacks callbacks = {sizeof callbacks, 0, NULL, NULL, NULL};
        msap_counts counts = {sizeof counts, 0, 7, 7, 7};
        msap_world_stats stats;
        msap_error error;
        memset(&stats, 0x5A, sizeof stats);
        memset(&error, 0x5A, sizeof error);
        boxes.struct_size += (uint32_t)offsets[i];
        callbacks.struct_size += (uint32_t)offsets[i];
        refused(msap_add_many(world, 1, &boxes, NULL, NULL, &other), MSAP_ERROR_STRUCT_SIZE);
        last_error(world, MSAP_ERROR_STRUCT_SIZE, 0, MSAP_NO_BOUND);
        refused(msap_update_many(world, 1, &handle, &boxes), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_commit(world, &callbacks, NULL), MSAP_ERROR_STRUCT_SIZE);
        counts.struct_size += (uint32_t)offsets[i];
        refused(msap_commit(world, NULL, &counts), MSAP_ERROR_STRUCT_SIZE);
        ck_assert(counts.created == 7 && counts.deleted == 7 && counts.active == 7);
        stats.struct_size = (uint32_t)((int)sizeof stats + offsets[i]);
        error.struct_size = (uint32_t)((int)sizeof error + offsets[i]);
        refused(msap_stats(world, &stats), MSAP_ERROR_STRUCT_SIZE);
        refused(msap_last_error(world, &error), MSAP_ERROR_STRUCT_SIZE);
        ck_assert_uint_eq(stats.boxes, UINT64_C(0x5A5A5A5A5A5A5A5A));
        ck_assert_uint_eq(error.status, 0x5A5A5A5A);
    }
    ck_assert_uint_eq(other, 77);
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(batches_refuse_scalars)
{
    msap_world *world = new_world(3, DEFAULT);
    box unit = cube(0, 1);
    msap_boxes boxes = boxes_in_row(&unit);
    msap_handle handle = add(world, unit), other = 77;
    boxes.scalar = 2;
    refused(msap_add_many(world, 1, &boxes, NULL, NULL, &other), MSAP_ERROR_CONFIG);
    last_error(world, MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND);
    refused(msap_update_many(world, 1, &handle, &boxes), MSAP_ERROR_CONFIG);
    boxes.scalar = UINT32_MAX;
    refused(msap_update_many(world, 1, &handle, &boxes), MSAP_ERROR_CONFIG);
    ck_assert_uint_eq(other, 77);
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(add_refuses_flags)
{
    msap_world *world = new_world(3, DEFAULT);
    box unit = cube(0, 1);
    msap_handle handle = 77;
    uint32_t flag;
    for (flag = 2; flag; flag <<= 1) {
        refused(msap_add(world, unit.min, unit.max, flag, NULL, &handle), MSAP_ERROR_CONFIG);
        refused(msap_add(world, unit.min, unit.max, flag | MSAP_STATIC, NULL, &handle), MSAP_ERROR_CONFIG);
    }
    last_error(world, MSAP_ERROR_CONFIG, 0, MSAP_NO_BOUND);
    ck_assert_uint_eq(handle, 77);
    ck_assert_uint_eq(stats_of(world).boxes, 0);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("config");
    tcase_add_test(tests, defaults);
    tcase_add_test(tests, prune_defaults);
    tcase_add_test(tests, init_refuses_sizes);
    tcase_add_test(tests, prune_init_refuses_sizes);
    tcase_add_test(tests, create_refuses_sizes);
    tcase_add_test(tests, create_refuses_values);
    tcase_add_test(tests, create_copies_the_config);
    tcase_add_test(tests, calls_refuse_sizes);
    tcase_add_test(tests, batches_refuse_scalars);
    tcase_add_test(tests, add_refuses_flags);
    return run_case(tests, "config");
}
