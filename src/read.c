/* Reading and setting what a world knows: bounds, user data, pairs, statistics.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

msap_status msap_get_bounds(const msap_world *world, msap_handle handle, float *min, float *max)
{
    if (!world || !min || !max) return MSAP_ERROR_NULL;
    const struct box *b = box_find(&world->boxes, handle, BOX_LIVE);
    if (!b) return MSAP_ERROR_HANDLE;
    for (uint32_t k = 0; k < world->config.dims; k++) {
        min[k] = float_from_bits(float_bits_from_ordered(b->now.min[k]));
        max[k] = float_from_bits(float_bits_from_ordered(b->now.max[k]));
    }
    return MSAP_OK;
}

/* ---------------------------------------------------------------- user data */

/* The index of the first handle without a box that has one of the flags, or k. */
static size_t first_unknown(const msap_world *w, size_t k, const msap_handle *handles, uint32_t flags)
{
    size_t i = 0;
    while (i < k && box_find(&w->boxes, handles[i], flags)) i++;
    return i;
}

msap_status msap_get_user_data(const msap_world *world, size_t k, const msap_handle *handles, void **user_data)
{
    if (!world || (k > 0 && (!handles || !user_data))) return MSAP_ERROR_NULL;
    if (first_unknown(world, k, handles, BOX_LIVE | BOX_REMOVED) < k) return MSAP_ERROR_HANDLE;
    for (size_t i = 0; i < k; i++) user_data[i] = box_user_data(&world->boxes, slot_of(handles[i]));
    return MSAP_OK;
}

msap_status msap_set_user_data(msap_world *world, size_t k, const msap_handle *handles, void *const *user_data)
{
    if (!world) return MSAP_ERROR_NULL;
    if (world->busy) return msap_world_fail(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    if (k > 0 && (!handles || !user_data)) return msap_world_fail(world, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND);
    size_t unknown = first_unknown(world, k, handles, BOX_LIVE);
    if (unknown < k) return msap_world_fail(world, MSAP_ERROR_HANDLE, unknown, MSAP_NO_BOUND);
    if (k > 0 && !msap_boxes_hold_user_data(&world->boxes, &world->memory, world->boxes.used))
        return msap_world_fail(world, MSAP_ERROR_MEMORY, 0, MSAP_NO_BOUND);
    for (size_t i = 0; i < k; i++) world->boxes.user_data[slot_of(handles[i])] = user_data[i];
    return MSAP_OK;
}

/* The active pair of two handles in any order, or NULL. */
static msap_pair *pair_of(const msap_world *w, msap_handle a, msap_handle b)
{
    msap_handle low = a < b ? a : b, high = a < b ? b : a;
    uint32_t i = msap_pairs_find(&w->pairs, slot_of(low), slot_of(high));
    if (i == NONE || w->pairs.at[i].a != low || w->pairs.at[i].b != high) return NULL;
    return &w->pairs.at[i];
}

static size_t first_unpaired(const msap_world *w, size_t k, const msap_handle *a, const msap_handle *b)
{
    size_t i = 0;
    while (i < k && pair_of(w, a[i], b[i])) i++;
    return i;
}

msap_status msap_get_pair_data(const msap_world *world, size_t k, const msap_handle *a, const msap_handle *b,
                               void **pair_data)
{
    if (!world || (k > 0 && (!a || !b || !pair_data))) return MSAP_ERROR_NULL;
    if (first_unpaired(world, k, a, b) < k) return MSAP_ERROR_NOT_A_PAIR;
    for (size_t i = 0; i < k; i++) pair_data[i] = pair_of(world, a[i], b[i])->user_data;
    return MSAP_OK;
}

msap_status msap_set_pair_data(msap_world *world, size_t k, const msap_handle *a, const msap_handle *b,
                               void *const *pair_data)
{
    if (!world) return MSAP_ERROR_NULL;
    if (world->busy) return msap_world_fail(world, MSAP_ERROR_BUSY, 0, MSAP_NO_BOUND);
    if (k > 0 && (!a || !b || !pair_data)) return msap_world_fail(world, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND);
    size_t unpaired = first_unpaired(world, k, a, b);
    if (unpaired < k) return msap_world_fail(world, MSAP_ERROR_NOT_A_PAIR, unpaired, MSAP_NO_BOUND);
    for (size_t i = 0; i < k; i++) pair_of(world, a[i], b[i])->user_data = pair_data[i];
    return MSAP_OK;
}

/* -------------------------------------------------------------------- pairs */

static msap_status give(const msap_world *w, size_t first, size_t n, const msap_pair **pairs, size_t *count)
{
    *pairs = w->pairs.at ? w->pairs.at + first : NULL;
    *count = n;
    return MSAP_OK;
}

msap_status msap_created(const msap_world *world, const msap_pair **pairs, size_t *count)
{
    if (!world || !pairs || !count) return MSAP_ERROR_NULL;
    return give(world, world->pairs.active - world->pairs.created, world->pairs.created, pairs, count);
}

msap_status msap_deleted(const msap_world *world, const msap_pair **pairs, size_t *count)
{
    if (!world || !pairs || !count) return MSAP_ERROR_NULL;
    return give(world, world->pairs.active, world->pairs.deleted, pairs, count);
}

msap_status msap_pairs(const msap_world *world, const msap_pair **pairs, size_t *count)
{
    if (!world || !pairs || !count) return MSAP_ERROR_NULL;
    return give(world, 0, world->pairs.active, pairs, count);
}

/* --------------------------------------------------------------- statistics */

/* What msap_world_stats had in version 0.1; as CONFIG_0_1 (world.c). */
#define STATS_0_1 (offsetof(msap_world_stats, candidates) + sizeof(uint64_t))

msap_status msap_stats(const msap_world *world, msap_world_stats *stats)
{
    msap_world_stats all;
    if (!world || !stats) return MSAP_ERROR_NULL;
    if (stats->struct_size != STATS_0_1 && stats->struct_size != sizeof *stats) /* GCOVR_EXCL_BR_LINE: world.c */
        return MSAP_ERROR_STRUCT_SIZE;
    memset(&all, 0, sizeof all);
    all.struct_size = stats->struct_size;
    all.boxes = world->boxes.live;
    all.pairs = world->pairs.active;
    all.pending = world->boxes.n_changed;
    all.bytes = world->memory.bytes;
    all.bytes_peak = world->memory.peak;
    all.allocations = world->memory.calls;
    all.commits = world->commits;
    all.crossings = world->crew.worker[0].settler.crossings;
    all.touched = world->crew.worker[0].settler.touched;
    all.slides = world->strategy_used[MSAP_STRATEGY_SLIDE];
    all.merges = world->strategy_used[MSAP_STRATEGY_MERGE];
    all.sweeps = world->strategy_used[MSAP_STRATEGY_SWEEP];
    if (is_grid(&world->config)) msap_grid_count(&world->grid, &all);
    memcpy(stats, &all, stats->struct_size);
    return MSAP_OK;
}
