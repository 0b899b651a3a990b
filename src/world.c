/* Worlds: configuration, life and end; the last error; memory given back.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

/* What msap_config had in version 0.1. Later fields come behind and never before; who was
 * built without them gives a smaller struct, and gets their defaults. */
#define CONFIG_0_1 (offsetof(msap_config, jobs_user) + sizeof(void *))

static int is_config_size(size_t size)
{
    return size == CONFIG_0_1 || size == sizeof(msap_config); /* GCOVR_EXCL_BR_LINE: the same until it grows */
}

msap_status msap_config_init(msap_config *config, size_t struct_size)
{
    msap_config all;
    if (!config) return MSAP_ERROR_NULL;
    if (!is_config_size(struct_size)) return MSAP_ERROR_STRUCT_SIZE;
    memset(&all, 0, sizeof all);
    all.struct_size = (uint32_t)struct_size;
    all.dims = 3;
    all.filters = 1;
    all.max_boxes = MSAP_MAX_BOXES;
    all.workers = 1;
    all.margin = MSAP_MARGIN_AUTO;
    for (int k = 0; k < 3; k++) all.grid_cells[k] = 1;
    memcpy(config, &all, struct_size);
    return MSAP_OK;
}

/* As integers, so that a host that flushes to zero, and a build with -ffast-math, refuse
 * what all others refuse. */
static int32_t ordered_of(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return ordered_from_float_bits(bits);
}

static int is_finite(float value)
{
    return ordered_of(value) > ORDERED_MINUS_INF && ordered_of(value) < ORDERED_INF;
}

static int is_size(float value) { return ordered_of(value) >= 0 && is_finite(value); }

static int jobs_legal(const msap_config *c)
{
    if (!c->enqueue != !c->finish) return 0;
    return c->workers == 1 || (c->workers > 1 && c->workers <= MOST_WORKERS && c->enqueue);
}

static int grid_legal(const msap_config *c)
{
    if (c->grid > MSAP_GRID_FIXED) return 0;
    if (!is_size(c->cell_size)) return 0;
    if (ordered_of(c->margin) != ordered_of(MSAP_MARGIN_AUTO) && !is_size(c->margin)) return 0;
    for (uint32_t k = 0; k < 3 && c->grid == MSAP_GRID_FIXED; k++) {
        if (c->grid_cells[k] < 1 || c->grid_cells[k] > MOST_GRID_CELLS) return 0;
        if (!is_finite(c->grid_min[k]) || !is_finite(c->grid_max[k])) return 0;
        if (c->grid_cells[k] == 1) continue;
        if (k >= c->dims || ordered_of(c->grid_min[k]) >= ordered_of(c->grid_max[k])) return 0;
    }
    return 1;
}

static int is_legal(const msap_config *c)
{
    if (c->dims < 2 || c->dims > 3 || c->strategy > MSAP_STRATEGY_SWEEP || c->filters > 1) return 0;
    if (c->simd > MSAP_SIMD_512 || c->max_boxes > MSAP_MAX_BOXES) return 0;
    return grid_legal(c) && jobs_legal(c);
}

/* Reads a config of this or an earlier version; NULL is the defaults. */
static msap_status config_read(msap_config *to, const msap_config *from)
{
    msap_config_init(to, sizeof *to);
    if (!from) return MSAP_OK;
    if (!is_config_size(from->struct_size)) return MSAP_ERROR_STRUCT_SIZE;
    memcpy(to, from, from->struct_size);
    return is_legal(to) ? MSAP_OK : MSAP_ERROR_CONFIG;
}

msap_status msap_create(const msap_config *config, msap_world **world)
{
    msap_config c;
    struct memory memory;
    if (!world) return MSAP_ERROR_NULL;
    msap_status status = config_read(&c, config);
    if (status == MSAP_OK) status = msap_memory_init(&memory, c.alloc, c.free, c.allocator_user);
    if (status != MSAP_OK) return status;
    msap_world *w = msap_memory_alloc(&memory, 1, sizeof *w);
    if (!w) return MSAP_ERROR_MEMORY;
    memset(w, 0, sizeof *w);
    w->memory = memory;
    w->config = c;
    w->error_bound = MSAP_NO_BOUND;
    msap_crew_init(&w->crew, &w->config);
    msap_boxes_init(&w->boxes);
    msap_sap_init(&w->sap, c.dims);
    msap_grid_init(&w->grid, &w->config, &w->boxes);
    *world = w;
    return MSAP_OK;
}

msap_status msap_destroy(msap_world *world)
{
    if (!world) return MSAP_OK;
    if (world->busy) return msap_world_fail(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    struct memory m = world->memory;
    world->busy = 1;
    msap_sap_free(&world->sap, &m);
    msap_grid_free(&world->grid, &m);
    msap_boxes_free(&world->boxes, &m);
    msap_pairs_free(&world->pairs, &m);
    msap_crew_free(&world->crew, &m);
    msap_memory_free(&m, world->scratch.at, world->scratch.room, sizeof *world->scratch.at);
    msap_memory_free(&m, world, 1, sizeof *world);
    return MSAP_OK;
}

/* Opens a call that changes the world, which msap_world.busy marks until it ends. */
msap_status msap_world_begin(msap_world *w)
{
    if (!w) return MSAP_ERROR_NULL;
    if (w->busy) return msap_world_fail(w, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    w->busy = 1;
    return MSAP_OK;
}

msap_status msap_world_end(msap_world *w, msap_status status)
{
    w->busy = 0;
    return status;
}

/* Gives back what the world does not need; changes may be pending. */
void msap_world_trim(msap_world *w)
{
    struct memory *m = &w->memory;
    msap_pairs_trim(&w->pairs, m);
    msap_boxes_trim(&w->boxes, m);
    msap_crew_trim(&w->crew, m, w->boxes.used, w->pairs.active);
    msap_scratch_free(&w->scratch, m);
    if (is_grid(&w->config)) msap_grid_trim(&w->grid, m, w->boxes.used);
    else msap_sap_trim(&w->sap, m, w->boxes.used);
}

msap_status msap_trim(msap_world *world)
{
    msap_status status = msap_world_begin(world);
    if (status != MSAP_OK) return status;
    msap_world_trim(world);
    return msap_world_end(world, MSAP_OK);
}

/* Notes a failure for msap_last_error and hands the status on. */
msap_status msap_world_fail(msap_world *w, msap_status status, uint64_t index, uint32_t bound)
{
    w->error_status = status;
    w->error_index = index;
    w->error_bound = bound;
    return status;
}

msap_status msap_last_error(const msap_world *world, msap_error *error)
{
    if (!world || !error) return MSAP_ERROR_NULL;
    if (error->struct_size != sizeof *error) return MSAP_ERROR_STRUCT_SIZE;
    error->status = world->error_status;
    error->index = world->error_index;
    error->bound = world->error_bound;
    error->reserved = 0;
    return MSAP_OK;
}
