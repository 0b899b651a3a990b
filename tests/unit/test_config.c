/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: every struct tells its size, and a size or a value that this library does
 * not know is refused, never guessed at; the defaults are those of the header.
 */
#include <math.h>
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
    ck_assert_uint_eq(config.grid, MSAP_GRID_AUTO);
    ck_assert_uint_eq(config.strategy, MSAP_STRATEGY_AUTO);
    ck_assert_uint_eq(config.filters, 1);
    ck_assert_uint_eq(config.simd, MSAP_SIMD_AUTO);
    ck_assert_uint_eq(config.max_boxes, MSAP_MAX_BOXES);
    ck_assert_uint_eq(config.workers, 1);
    ck_assert_uint_eq(config.task_grain, 0);
    ck_assert(config.margin == MSAP_MARGIN_AUTO && config.cell_size == 0);
    ck_assert(config.grid_cells[0] == 1 && config.grid_cells[1] == 1 && config.grid_cells[2] == 1);
    ck_assert(!config.alloc && !config.free && !config.allocator_user);
    ck_assert(!config.enqueue && !config.finish && !config.jobs_user);
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

/* A number in a config. */
static uint32_t *number_at(msap_config *config, size_t offset)
{
    return (uint32_t *)(void *)((char *)config + offset);
}

START_TEST(create_refuses_values)
{
    static const struct {
        size_t offset;
        uint32_t first_wrong;
    } numbers[] = {
        {offsetof(msap_config, dims), 4},     {offsetof(msap_config, grid), 3},
        {offsetof(msap_config, strategy), 4}, {offsetof(msap_config, filters), 2},
        {offsetof(msap_config, simd), 5},     {offsetof(msap_config, max_boxes), MSAP_MAX_BOXES + 1},
        {offsetof(msap_config, workers), 65},
    };
    msap_config good = config_of(3, DEFAULT), config;
    size_t i;
    use_jobs(&good, 2, JOBS_AT_ONCE);
    for (i = 0; i < COUNT(numbers); i++) {
        config = good;
        *number_at(&config, numbers[i].offset) = numbers[i].first_wrong;
        create_refuses(&config, MSAP_ERROR_CONFIG);
        *number_at(&config, numbers[i].offset) = UINT32_MAX;
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    config = good;
    config.dims = 1;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.dims = 0;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    refused(msap_create(&good, NULL), MSAP_ERROR_NULL);
    refused(msap_create(NULL, NULL), MSAP_ERROR_NULL);
}
END_TEST

START_TEST(create_refuses_half_an_allocator)
{
    msap_config config = config_of(3, DEFAULT);
    config.alloc = some_alloc;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.alloc = NULL;
    config.free = some_free;
    create_refuses(&config, MSAP_ERROR_CONFIG);
}
END_TEST

START_TEST(create_refuses_workers_without_jobs)
{
    msap_config config = config_of(3, DEFAULT), jobs = config;
    use_jobs(&jobs, 2, JOBS_AT_ONCE);
    config.workers = 2;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.enqueue = jobs.enqueue;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.workers = 1; /* half a job system is refused, needed or not */
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config.enqueue = NULL;
    config.finish = jobs.finish;
    create_refuses(&config, MSAP_ERROR_CONFIG);
    jobs.workers = 0;
    create_refuses(&jobs, MSAP_ERROR_CONFIG);
}
END_TEST

/* Infinities, NaNs and what is below 0, but for MSAP_MARGIN_AUTO. */
START_TEST(create_refuses_margins_and_cell_sizes)
{
    static const uint32_t wrong[] = {0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00001, 0x80000001, 0xBF800001, 0xC0000000};
    msap_config config;
    size_t i;
    for (i = 0; i < COUNT(wrong); i++) {
        config = config_of(3, DEFAULT);
        config.margin = float_of(wrong[i]);
        create_refuses(&config, MSAP_ERROR_CONFIG);
        config = config_of(3, DEFAULT);
        config.cell_size = float_of(wrong[i]);
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    config = config_of(3, DEFAULT);
    config.cell_size = -1;
    create_refuses(&config, MSAP_ERROR_CONFIG);
}
END_TEST

static msap_config fixed(uint32_t dims, uint32_t cells, float min, float max)
{
    msap_config config = config_of(dims, DEFAULT);
    config.grid = MSAP_GRID_FIXED;
    config.grid_cells[1] = cells;
    config.grid_min[1] = min;
    config.grid_max[1] = max;
    return config;
}

START_TEST(create_refuses_fixed_grids)
{
    static const float bounds[][2] = {{1, 1}, {2, 1}, {0, -0.0f}, {0, INFINITY}, {-INFINITY, 0}, {NAN, 1}, {0, NAN}};
    msap_config config;
    size_t i;
    for (i = 0; i < COUNT(bounds); i++) {
        config = fixed(3, 2, bounds[i][0], bounds[i][1]);
        create_refuses(&config, MSAP_ERROR_CONFIG);
    }
    config = fixed(3, 0, 0, 1);
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config = fixed(3, 4097, 0, 1);
    create_refuses(&config, MSAP_ERROR_CONFIG);
    config = fixed(2, 2, 0, 1);
    config.grid_cells[2] = 2; /* there is no third axis */
    config.grid_max[2] = 1;
    create_refuses(&config, MSAP_ERROR_CONFIG);
}
END_TEST

static void create_accepts(const msap_config *config)
{
    msap_world *world = NULL;
    ok(msap_create(config, &world));
    add(world, cube(0, 1));
    add(world, cube(1, 2));
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}

/* What is at the edge of the legal. */
START_TEST(create_accepts_edges)
{
    msap_config config = config_of(3, DEFAULT);
    config.margin = float_of(0x7F7FFFFF); /* FLT_MAX */
    config.cell_size = float_of(0x7F7FFFFF);
    create_accepts(&config);
    config.margin = -0.0f;
    config.cell_size = float_of(0x00000001);
    create_accepts(&config);
    config.margin = float_of(0x00000001);
    config.cell_size = -0.0f;
    create_accepts(&config);
    config = fixed(3, 1, 7, 7); /* an axis with one cell needs no bounds */
    create_accepts(&config);
    config = fixed(3, 4096, float_of(0xFF7FFFFF), float_of(0x7F7FFFFF));
    create_accepts(&config);
    config = fixed(2, 3, 0, float_of(0x00000001));
    create_accepts(&config);
    config = fixed(2, 3, float_of(0x7F7FFFFE), float_of(0x7F7FFFFF));
    create_accepts(&config);
    config = config_of(2, DEFAULT);
    use_jobs(&config, 64, JOBS_AT_ONCE);
    create_accepts(&config);
    config.task_grain = 1;
    create_accepts(&config);
    config.task_grain = UINT32_MAX;
    create_accepts(&config);
    config.workers = 1; /* with job hooks that are not used */
    create_accepts(&config);
}
END_TEST

/* The config is copied; without one the defaults hold. */
START_TEST(create_copies_the_config)
{
    msap_config config = config_of(2, DEFAULT);
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
    tcase_add_test(tests, create_refuses_half_an_allocator);
    tcase_add_test(tests, create_refuses_workers_without_jobs);
    tcase_add_test(tests, create_refuses_margins_and_cell_sizes);
    tcase_add_test(tests, create_refuses_fixed_grids);
    tcase_add_test(tests, create_accepts_edges);
    tcase_add_test(tests, create_copies_the_config);
    tcase_add_test(tests, calls_refuse_sizes);
    tcase_add_test(tests, batches_refuse_scalars);
    tcase_add_test(tests, add_refuses_flags);
    return run_case(tests, "config");
}
