/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: msap_validate finds what it says that it finds; limits that no test could
 * reach by calls alone are where they should be; sorts and phases do what they should
 * with memory and without. This is the one test that looks behind the interface. To
 * validate, it breaks one thing in the insides of a sound world, asks, and puts it back.
 */
#include <string.h>

#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

/* -------------------------------------------------------------- what is broken */

/* What was overwritten. */
static struct {
    void *at;
    unsigned char was[16];
    size_t size;
} undo[16];
static size_t undo_count;

static void *note(void *at, size_t size)
{
    ck_assert(size <= sizeof undo->was && undo_count < COUNT(undo));
    memcpy(undo[undo_count].was, at, size);
    undo[undo_count].at = at;
    undo[undo_count++].size = size;
    return at;
}

static void put_back(void)
{
    while (undo_count > 0) {
        undo_count--;
        memcpy(undo[undo_count].at, undo[undo_count].was, undo[undo_count].size);
    }
}

#define SET(place, value) (note(&(place), sizeof(place)), (void)((place) = (value)))

/* The boxes of the world, by slot: three that are pairs, of which MIDDLE has been given
 * other bounds since the last commit; two static ones that overlap; one far out, above
 * all others on every axis; one that the last commit knew nothing of; a slot that is
 * free; and one whose box was removed since. */
enum { LOW, MIDDLE, HIGH, STATIC_A, STATIC_B, FAR, FRESH, FREED, REMOVED };

static msap_world *sound_world(int row)
{
    msap_world *world = new_world(3, row);
    int i;
    for (i = LOW; i <= HIGH; i++)
        add(world, cube((float)i, (float)(i + 4)));
    add_flagged(world, cube(30, 40), MSAP_STATIC);
    add_flagged(world, cube(35, 45), MSAP_STATIC);
    for (i = FAR; i <= REMOVED; i++)
        add(world, cube((float)(200 - 10 * i), (float)(205 - 10 * i)));
    ok(msap_commit(world, NULL, NULL));
    ok(msap_remove(world, (msap_handle)FRESH << 32 | 1));
    ok(msap_remove(world, (msap_handle)FREED << 32 | 1));
    commit(world, 0, 0, 3);
    add(world, cube(60, 61));
    ok(msap_remove(world, (msap_handle)REMOVED << 32 | 1));
    update(world, (msap_handle)MIDDLE << 32 | 1, cube(1, 7)); /* further than any skin */
    ok(msap_validate(world, NULL));
    return world;
}

/* Each breaks one thing; the message that must come is in the table below. */
#define BREAK(name, ...) \
    static void name(msap_world *w) \
    { \
        __VA_ARGS__; \
    }

/* ----------------------------------------------------------------------- boxes */

#define BOX(slot) (w->boxes.at[slot])
#define BEFORE(slot) (w->boxes.past[slot].before) /* of one that has changed */
BREAK(now_inverted, SET(BOX(LOW).now.min[1], BOX(LOW).now.max[1] + 1))
BREAK(before_inverted, SET(BEFORE(MIDDLE).min[1], BEFORE(MIDDLE).max[1] + 1))
BREAK(marked_new, SET(BOX(LOW).flags, BOX(LOW).flags | BOX_NEW))
BREAK(free_slot_stored, SET(BOX(FREED).flags, BOX_STORED))
BREAK(not_marked, SET(BOX(LOW).fat.max[0], BOX(LOW).now.max[0] - 1))
BREAK(left_unchanged, SET(BOX(LOW).left, LEFT))
BREAK(left_by_half, SET(BOX(LOW).left, 0))
BREAK(fat_below_infinity, SET(BOX(LOW).fat.min[1], ORDERED_MINUS_INF - 1))
BREAK(fat_above_infinity, SET(BOX(LOW).fat.max[2], ORDERED_INF + 1))
BREAK(one_less_left, SET(w->boxes.n_left, w->boxes.n_left - 1))
BREAK(stayed_in_left, SET(w->boxes.left[0], LOW))
BREAK(nothing_in_left, SET(w->boxes.left[0], (uint32_t)w->boxes.used))
BREAK(came_unmarked, SET(BOX(LOW).flags, BOX(LOW).flags & ~(uint32_t)BOX_WAS))
BREAK(queue_leads_nowhere, SET(w->boxes.free.head, (uint32_t)w->boxes.used))
BREAK(queue_is_a_ring, SET(BOX(FREED).now.min[0], FREED))
BREAK(live_in_free, SET(w->boxes.free.head, LOW))
BREAK(live_in_removed, SET(w->boxes.removed.head, LOW))
BREAK(one_more_live, SET(w->boxes.live, w->boxes.live + 1))
BREAK(one_more_static, SET(w->boxes.live_static, w->boxes.live_static + 1))
BREAK(one_less_in_queue, SET(w->boxes.removed.n, w->boxes.removed.n - 1))
BREAK(one_less_changed, SET(w->boxes.n_changed, w->boxes.n_changed - 1))
BREAK(unchanged_in_changed, SET(w->boxes.changed[0], LOW))
BREAK(nothing_in_changed, SET(w->boxes.changed[0], (uint32_t)w->boxes.used))

/* ----------------------------------------------------------------------- pairs */

#define PAIRS (w->pairs)

static size_t entry_of_first(const msap_world *w)
{
    size_t entry = 0;
    while (PAIRS.first[entry] != 0)
        entry++;
    return entry;
}

BREAK(array_too_small, SET(PAIRS.room, 1))
BREAK(more_created_than_active, SET(PAIRS.created, PAIRS.active + 1))
BREAK(table_too_small, SET(PAIRS.room_next, 0))
BREAK(table_of_no_homes, SET(PAIRS.homes, 0))
BREAK(chain_without_end, SET(PAIRS.next[0], 0))
BREAK(entry_leads_nowhere, SET(PAIRS.first[entry_of_first(w)], (uint32_t)PAIRS.active))
BREAK(entry_missing, SET(PAIRS.first[entry_of_first(w)], NONE))
BREAK(pair_not_in_order, SET(PAIRS.at[0].a, PAIRS.at[0].b))
BREAK(pair_not_found, SET(PAIRS.at[0].b, (msap_handle)FAR << 32 | 1))
BREAK(stale_a, SET(BOX(LOW).generation, 2))
BREAK(stale_b, SET(BOX(HIGH).generation, 2))

/* A pair that is in the table as it should be, and should not be there. */
static void add_pair(msap_world *w, uint32_t a, uint32_t b)
{
    uint64_t key = (uint64_t)a << 32 | b;
    struct keys fresh = {NULL, 1, 1}, none = {NULL, 0, 0};
    fresh.at = &key;
    ck_assert(msap_boxes_reserve(&w->boxes, &w->memory, (size_t)b + 1));
    ck_assert(msap_pairs_reserve(&w->pairs, &w->memory, 1, 0));
    msap_pairs_apply(&w->pairs, &w->boxes, &fresh, &none);
}

BREAK(a_names_no_slot, add_pair(w, (uint32_t)w->boxes.used, (uint32_t)w->boxes.used + 1))
BREAK(b_names_no_slot, add_pair(w, LOW, (uint32_t)w->boxes.used))
BREAK(apart, add_pair(w, LOW, FAR))
BREAK(unknown_to_the_commit, add_pair(w, LOW, FRESH))
BREAK(both_static, add_pair(w, STATIC_A, STATIC_B))

/* ------------------------------------------------------------------------ axes */

#define AXIS (w->sap.axis[2])
#define LAST (2 * w->sap.stored)
BREAK(one_more_stored, SET(w->sap.stored, w->sap.stored + 1))
BREAK(no_array, SET(AXIS.room_key, 0))
BREAK(low_sentinel, SET(AXIS.key[0], 1))
BREAK(high_sentinel, SET(AXIS.key[LAST + 1], UINT64_MAX - 1))
BREAK(not_in_order, SET(AXIS.key[2], AXIS.key[1]))
BREAK(key_of_no_slot, SET(AXIS.key[LAST], AXIS.key[LAST] + (uint64_t)w->boxes.used))
BREAK(key_of_unstored, SET(AXIS.key[LAST], AXIS.key[LAST] + (FRESH - FAR)))
BREAK(rank_elsewhere, SET(AXIS.rank[2 * LOW], 2))
BREAK(min_not_its_bound, SET(BOX(LOW).now.min[2], BOX(LOW).now.min[2] - 1))
BREAK(max_not_its_bound, SET(BOX(LOW).now.max[2], BOX(LOW).now.max[2] + 1))

/* ------------------------------------------------------------------------ grid */

#define NEAR(slot) (w->grid.near.of[slot])

/* A cell that the box stands in, and its row there. */
static struct cell *cell_of(msap_world *w, uint32_t wanted, uint32_t *row)
{
    struct layout *l = &w->grid.layout[BOX(wanted).layout];
    size_t i;
    for (i = 0; i < l->n_cells; i++)
        for (*row = 0; *row < l->cell[i].n; ++*row)
            if (l->cell[i].block[*row / 8].id[*row % 8] == wanted)
                return &l->cell[i];
    ck_abort_msg("the box is in no cell");
    return NULL;
}

#define IN_CELL(slot, ...) \
    uint32_t row; \
    struct cell *c = cell_of(w, slot, &row); \
    __VA_ARGS__

BREAK(absent, SET(BOX(LOW).level, NO_LEVEL))
BREAK(out_of_its_skin, SET(BOX(MIDDLE).fat.max[0], BEFORE(MIDDLE).max[0] - 1))
BREAK(row_of_no_slot, IN_CELL(FAR, SET(c->block[row / 8].id[row % 8], (uint32_t)w->boxes.used)))
BREAK(row_of_absent, IN_CELL(FAR, SET(c->block[row / 8].id[row % 8], FRESH)))
BREAK(other_bounds_in_cell, IN_CELL(FAR, SET(c->block[row / 8].high[0][row % 8], (uint16_t)(c->block[row / 8].high[0][row % 8] + 1))))
BREAK(other_low_in_cell, IN_CELL(FAR, SET(c->block[row / 8].low[0][row % 8], (uint16_t)(c->block[row / 8].low[0][row % 8] - 1))))
BREAK(other_level, IN_CELL(FAR, (void)row; (void)c; SET(BOX(FAR).level, (uint8_t)(BOX(FAR).level + 1))))
BREAK(static_among_moving, IN_CELL(STATIC_A, SET(c->n_moving, c->n_moving + 1)))
BREAK(more_than_room, IN_CELL(FAR, (void)row; SET(c->room, 0)))
BREAK(more_moving_than_all, IN_CELL(FAR, (void)row; SET(c->n_moving, c->n + 1)))
BREAK(one_more_in_layout, SET(w->grid.layout[w->grid.current].boxes, 99))
BREAK(missing_in_a_cell, IN_CELL(STATIC_B, (void)row; SET(c->n, c->n - 1)))
BREAK(neighbour_is_no_slot, SET(NEAR(LOW).at[0], (uint32_t)w->boxes.used))
BREAK(static_neighbours, static uint32_t list[NEAR_UNIT] = {STATIC_B}; SET(NEAR(STATIC_A).at, list);
      SET(NEAR(STATIC_A).n, 1); SET(NEAR(STATIC_A).n_above, 1))
BREAK(neighbours_apart, SET(NEAR(LOW).at[0], FAR))
BREAK(pair_not_noted, SET(NEAR(LOW).at[0], NEAR(LOW).at[0] & ~(uint32_t)NEAR_PAIR))
BREAK(list_too_long, SET(NEAR(LOW).n, near_room(&NEAR(LOW)) + 1))
BREAK(more_above_than_all, SET(NEAR(LOW).n_above, NEAR(LOW).n + 1))
BREAK(left_untidy, SET(NEAR(LOW).noted, 1))
BREAK(list_not_in_order, SET(NEAR(LOW).n_above, NEAR(LOW).n_above - 1))
BREAK(not_mutual, SET(NEAR(HIGH).n, NEAR(HIGH).n - 1))
BREAK(pair_no_neighbours, SET(PAIRS.active, PAIRS.active - 1))

/* A list of known pairs as after a commit that compared, of so many of two keys. */
static uint64_t known[2];
#define KNOWS(length, first, second) \
    known[0] = (first), known[1] = (second), SET(w->grid.known.at, known), SET(w->grid.known.n, length), \
        SET(w->grid.knows_pairs, 1)
#define PAIR_AT(i) pair_key_at(&PAIRS, i)
BREAK(known_too_few, KNOWS(0, 0, 0))
BREAK(known_is_none, KNOWS(1, pair_key(FAR, FRESH), 0))
BREAK(known_twice, KNOWS(2, PAIR_AT(0), PAIR_AT(0)))

/* ------------------------------------------------------------------- the table */

static const struct {
    int row;
    void (*break_it)(msap_world *w);
    const char *sentence;
} breaks[] = {
    {SINGLE_SAP, now_inverted, "a box is inverted"},
    {SINGLE_SAP, before_inverted, "a box is inverted"},
    {SINGLE_SAP, marked_new, "a box is still marked as new"},
    {SINGLE_SAP, free_slot_stored, "a free slot is stored"},
    {SINGLE_SAP, not_marked, "a box is outside its fat bounds, but is not on the list of those that left"},
    {SINGLE_SAP, left_unchanged, "a box left, but is not changed"},
    {SINGLE_SAP, left_by_half, "a box neither left nor stayed"},
    {SINGLE_SAP, fat_below_infinity, "a box has fat bounds beyond infinity"},
    {SINGLE_SAP, fat_above_infinity, "a box has fat bounds beyond infinity"},
    {SINGLE_SAP, one_less_left, "the list of those that left has another length than there are such boxes"},
    {SINGLE_SAP, stayed_in_left, "the list of those that left names a box that did not"},
    {SINGLE_SAP, nothing_in_left, "the list of those that left names a box that did not"},
    {SINGLE_SAP, came_unmarked, "a box came, went or is not stored, but is not changed"},
    {SINGLE_SAP, queue_leads_nowhere, "a queue of slots is damaged"},
    {SINGLE_SAP, queue_is_a_ring, "a queue of slots is damaged"},
    {SINGLE_SAP, live_in_free, "a slot is in the wrong queue"},
    {SINGLE_SAP, live_in_removed, "a slot is in the wrong queue"},
    {SINGLE_SAP, one_more_live, "the number of live boxes is wrong"},
    {SINGLE_SAP, one_more_static, "the number of live boxes is wrong"},
    {SINGLE_SAP, one_less_in_queue, "a queue of slots has another length"},
    {SINGLE_SAP, one_less_changed, "the changed list has another length than there are changed boxes"},
    {SINGLE_SAP, unchanged_in_changed, "the changed list names a box that is not changed"},
    {SINGLE_SAP, nothing_in_changed, "the changed list names a box that is not changed"},
    {SINGLE_SAP, array_too_small, "the pair array is overfull"},
    {SINGLE_SAP, more_created_than_active, "the pair array is overfull"},
    {SINGLE_SAP, table_too_small, "the pair table is overfull"},
    {SINGLE_SAP, table_of_no_homes, "the pair table is overfull"},
    {SINGLE_SAP, chain_without_end, "the pair table has another number of entries than there are pairs"},
    {SINGLE_SAP, entry_leads_nowhere, "an entry of the pair table leads nowhere"},
    {SINGLE_SAP, entry_missing, "the pair table has another number of entries than there are pairs"},
    {SINGLE_SAP, pair_not_in_order, "a pair is not in order"},
    {SINGLE_SAP, pair_not_found, "a pair cannot be found"},
    {SINGLE_SAP, stale_a, "a pair has a stale handle"},
    {SINGLE_SAP, stale_b, "a pair has a stale handle"},
    {SINGLE_SAP, a_names_no_slot, "a pair names no slot"},
    {SINGLE_SAP, b_names_no_slot, "a pair names no slot"},
    {SINGLE_SAP, apart, "a pair does not overlap"},
    {SINGLE_SAP, unknown_to_the_commit, "a pair does not overlap"},
    {SINGLE_SAP, both_static, "two static boxes are a pair"},
    {SINGLE_SAP, one_more_stored, "the axes hold another number of boxes than are stored"},
    {SINGLE_SAP, no_array, "an axis has no array"},
    {SINGLE_SAP, low_sentinel, "a sentinel of an axis is damaged"},
    {SINGLE_SAP, high_sentinel, "a sentinel of an axis is damaged"},
    {SINGLE_SAP, not_in_order, "end points are not in order"},
    {SINGLE_SAP, key_of_no_slot, "an end point has no box"},
    {SINGLE_SAP, key_of_unstored, "an end point has no box"},
    {SINGLE_SAP, rank_elsewhere, "a rank does not lead to its end point"},
    {SINGLE_SAP, min_not_its_bound, "an end point is not its box's bound"},
    {SINGLE_SAP, max_not_its_bound, "an end point is not its box's bound"},
    {DEFAULT, absent, "the grid holds other boxes than the last commit"},
    {DEFAULT, out_of_its_skin, "a box is outside its fat bounds"},
    {DEFAULT, row_of_no_slot, "a cell names a box that is not in the grid"},
    {DEFAULT, row_of_absent, "a cell names a box that is not in the grid"},
    {DEFAULT, other_bounds_in_cell, "a cell has other bounds than the box's fat ones"},
    {DEFAULT, other_low_in_cell, "a cell has other bounds than the box's fat ones"},
    {DEFAULT, other_level, "a cell has other bounds than the box's fat ones"},
    {DEFAULT, static_among_moving, "a cell mixes static and moving"},
    {DEFAULT, more_than_room, "a cell is overfull"},
    {DEFAULT, more_moving_than_all, "a cell is overfull"},
    {DEFAULT, one_more_in_layout, "the layouts hold another number of boxes"},
    {DEFAULT, missing_in_a_cell, "a box is not in all cells that it touches"},
    {DEFAULT, neighbour_is_no_slot, "a neighbour list names no slot"},
    {DEFAULT, static_neighbours, "two static boxes are neighbours"},
    {DEFAULT, neighbours_apart, "the fat bounds of neighbours do not overlap"},
    {DEFAULT, pair_not_noted, "a neighbour list is wrong about a pair"},
    {DEFAULT, list_too_long, "a neighbour list is overfull or untidy"},
    {DEFAULT, more_above_than_all, "a neighbour list is overfull or untidy"},
    {DEFAULT, left_untidy, "a neighbour list is overfull or untidy"},
    {DEFAULT, list_not_in_order, "a neighbour list is not in order"},
    {DEFAULT, not_mutual, "a box is a neighbour, but not the other way round"},
    {DEFAULT, pair_no_neighbours, "a pair are no neighbours"},
    {DEFAULT, known_too_few, "the list of known pairs is not of all"},
    {DEFAULT, known_is_none, "the list of known pairs names none or is not in order"},
    {DEFAULT, known_twice, "the list of known pairs names none or is not in order"},
};

/* What is not put back by the log, since it was done by calls, is lost with the world. */
START_TEST(what_is_broken_is_named)
{
    msap_world *world = sound_world(breaks[_i].row);
    size_t active = world->pairs.active;
    const char *what = NULL;
    breaks[_i].break_it(world);
    refused(msap_validate(world, &what), MSAP_ERROR_CORRUPT);
    refused(msap_validate(world, NULL), MSAP_ERROR_CORRUPT);
    ck_assert_ptr_nonnull(what);
    ck_assert_str_eq(what, breaks[_i].sentence);
    put_back();
    if (world->pairs.active == active)
        ok(msap_validate(world, &what));
    ok(msap_destroy(world));
}
END_TEST

/* ---------------------------------------------------------------------- limits */

/* Sizes that overflow are refused before anything is asked for. */
START_TEST(sizes_that_overflow)
{
    msap_world *world = sound_world(_i);
    struct memory *m = &world->memory;
    uint64_t calls = m->calls;
    ck_assert_ptr_null(msap_memory_alloc(m, SIZE_MAX / 8, 16));
    ck_assert(!msap_memory_reserve(m, &world->scratch.at, &world->scratch.room, SIZE_MAX - 8, 0, 8));
    ck_assert(!msap_axis_reserve(&world->sap.axis[0], m, SIZE_MAX / 2));
    ck_assert(!msap_grid_reserve(&world->grid, m, SIZE_MAX / 2));
    ck_assert(!msap_row_set_make(&world->grid.row_set, m, UINT32_MAX));
    ck_assert_uint_eq(m->calls, calls);
    ok(msap_validate(world, NULL));
    ok(msap_destroy(world));
}
END_TEST

/* Once a pool has as much as a huge page, it comes in pieces that fill one to the last unit: with what the
 * memory takes for itself, too. What is written into arrays stays there. Loop variable: bytes of a unit. */
START_TEST(large_pools_come_in_huge_pages)
{
    const size_t unit = (size_t)_i, arrays = 6 * HUGE_PAGE / unit;
    struct memory m;
    struct pool p;
    size_t huge = 0;
    unsigned char **array = calloc(arrays, sizeof *array);
    ck_assert_ptr_nonnull(array);
    ok(msap_memory_init(&m, NULL, NULL, NULL));
    msap_pool_init(&p, unit);
    for (size_t i = 0; i < arrays; i++) {
        uint64_t bytes = m.bytes;
        array[i] = msap_pool_get(&p, &m, 0);
        ck_assert(array[i] != NULL);
        memset(array[i], (int)(i % 251), unit);
        if (m.bytes == bytes) continue;
        if (bytes > HUGE_PAGE) ck_assert_uint_gt(m.bytes - bytes + unit, HUGE_PAGE);
        ck_assert_uint_le(m.bytes - bytes, bytes > HUGE_PAGE ? HUGE_PAGE : HUGE_PAGE / 4);
        huge += bytes > HUGE_PAGE;
    }
    ck_assert_uint_ge(huge, 4);
    for (size_t i = 0; i < arrays; i++)
        if (array[i][0] != i % 251 || array[i][unit - 1] != i % 251) ck_abort_msg("array %zu was written to", i);
    free(array);
    msap_pool_free(&p, &m);
    ck_assert_uint_eq(m.bytes, 0);
}
END_TEST

/* As many slots as there can be, of which most are retired. */
START_TEST(no_slot_is_left)
{
    msap_world *world = sound_world(_i);
    box unit = cube(0, 1);
    msap_handle handle = 77;
    SET(world->boxes.used, MSAP_MAX_BOXES);
    SET(world->boxes.free.head, NONE);
    SET(world->boxes.free.n, 0);
    SET(world->boxes.live, 3);
    refused(msap_add(world, unit.min, unit.max, 0, NULL, &handle), MSAP_ERROR_FULL);
    put_back();
    ck_assert_uint_eq(handle, 77);
    ok(msap_validate(world, NULL));
    ok(msap_destroy(world));
}
END_TEST

/* One pair more than there can be; when there are fewer, the commit succeeds. */
START_TEST(no_pair_is_left)
{
    msap_config config = config_of(3, _i);
    msap_world *world;
    msap_handle a, b;
    config.strategy = MSAP_STRATEGY_SLIDE;
    ok(msap_create(&config, &world));
    a = add(world, cube(0, 1));
    b = add(world, cube(2, 3));
    commit(world, 0, 0, 0);
    update(world, b, cube(1, 2));
    SET(world->pairs.active, MSAP_MAX_BOXES);
    refused(msap_commit(world, NULL, NULL), MSAP_ERROR_FULL);
    put_back();
    commit(world, 0, 1, 1);
    ck_assert(is_pair(world, a, b));
    ok(msap_destroy(world));
}
END_TEST

/* A slot whose generation would wrap is retired, and stays so in a trim. */
START_TEST(generations_end)
{
    msap_world *world = new_world(3, _i);
    msap_handle last = (msap_handle)1 << 32 | UINT32_MAX;
    add(world, cube(0, 1));
    add(world, cube(0, 1));
    world->boxes.at[1].generation = UINT32_MAX;
    commit(world, 0, 1, 1);
    ok(msap_remove(world, last));
    commit(world, 1, 0, 0);
    refused(msap_remove(world, last), MSAP_ERROR_HANDLE);
    ok(msap_trim(world));
    ck_assert_uint_eq(add(world, cube(0, 1)), (msap_handle)2 << 32 | 1);
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

/* A box that last changed in the first epoch, when that number comes again. */
START_TEST(an_epoch_comes_again)
{
    msap_world *world = new_world(3, _i);
    msap_handle a = add(world, cube(0, 1));
    commit(world, 0, 0, 0);
    world->boxes.epoch = UINT32_MAX;
    add(world, cube(5, 6));
    commit(world, 0, 0, 0);
    ck_assert_uint_eq(world->boxes.epoch, 1);
    ok(msap_validate(world, NULL));
    update(world, a, cube(4, 5));
    commit(world, 0, 1, 1);
    ok(msap_destroy(world));
}
END_TEST

/* The numbers that tell which boxes have changed, and how old a skin is, wrap around within a
 * few commits. */
START_TEST(epochs_end)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    right(session_open(&s, &config, 5, SCENE_GRID));
    right(session_step(&s, 60));
    s.world->boxes.epoch = UINT32_MAX - 4;
    s.world->grid.commit = UINT16_MAX - 8;
    for (frame = 0; frame < 20; frame++) {
        right(session_step(&s, 20));
        ok(msap_validate(s.world, NULL));
    }
    ck_assert_uint_lt(s.world->boxes.epoch, 20);
    right(session_close(&s));
}
END_TEST

/* The number that marks what was found for a box wraps around within a few commits. */
START_TEST(tokens_end)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    right(session_open(&s, &config, 5, SCENE_GRID));
    right(session_step(&s, 60));
    s.world->crew.worker[0].token = UINT32_MAX - 41;
    for (frame = 0; frame < 10; frame++)
        right(session_step(&s, 60));
    right(session_close(&s));
}
END_TEST

/* A grid has a power of two of cells on each axis, not fewer than are wanted unless they
 * are too many. */
START_TEST(numbers_of_cells_end)
{
    ck_assert_uint_eq(msap_count_for(1), 1);
    ck_assert_uint_eq(msap_count_for(1.5), 2);
    ck_assert_uint_eq(msap_count_for(8), 8);
    ck_assert_uint_eq(msap_count_for(65535.5), 65536);
    ck_assert_uint_eq(msap_count_for(65537), 65536);
    ck_assert_uint_eq(msap_count_for(1e300), 65536);
}
END_TEST

/* --------------------------------------------------------------------- sorting */

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Few keys and many, with repeats and without, with memory to sort in and without. Keys that differ
 * in few bits high up and many low down crowd where the upper bits tell nothing apart. */
START_TEST(keys_are_sorted)
{
    enum { MOST = 3000 };
    static uint64_t key[MOST], expected[MOST], scratch[MOST];
    static const uint64_t mask[4] = {UINT64_MAX, 0xFF00FF0300000000u, 0x000003FF0000FFFFu, 0x0000000F0000003Fu};
    uint64_t random = 3;
    size_t n, i;
    for (n = 0; n < MOST; n += 1 + n / 3) {
        int way;
        for (way = 0; way < 8; way++) {
            for (i = 0; i < n; i++) {
                uint64_t crowded = i % 500 == 499 ? (uint64_t)3 << 62 : 0;
                key[i] = random_next(&random) & mask[way / 2];
                if (way / 2 == 2)
                    key[i] |= crowded;
                expected[i] = key[i];
            }
            qsort(expected, n, sizeof *expected, compare_keys);
            msap_sort_keys(key, n, way % 2 == 0 ? scratch : NULL);
            for (i = 0; i < n; i++)
                ck_assert_uint_eq(key[i], expected[i]);
            for (i = 0; i + 40 < n; i += 1 + random_below(&random, 4000 >> way)) { /* nearly, or hardly */
                uint64_t moved = key[i];
                key[i] = key[i + 40];
                key[i + 40] = moved;
            }
            msap_sort_nearly_sorted(key, n, scratch);
            for (i = 0; i < n; i++)
                ck_assert_uint_eq(key[i], expected[i]);
        }
    }
}
END_TEST

enum { KINDS = 5, LINES = 6, MOST_VALUES = 300000 };

/* Sorts n values of a kind by one of the lines, and by its whole keys to compare. */
static void sort_values(int kind, int by, size_t n, uint64_t *random)
{
    static uint64_t key[MOST_VALUES], expected[MOST_VALUES], scratch[2 * MOST_VALUES];
    static const float line[LINES][2] = {{-50, 100}, {-5, 10}, {3e38f, 1}, {0, 0}, {0, 1e38f}, {0, 1e-38f}};
    size_t i;
    for (i = 0; i < n; i++) {
        float value = (float)random_below(random, 100000) / 1000 - 50;
        value = kind == 1 && i % 4 ? 0.0001f * value : kind == 2 ? 1 : value;
        if (kind >= 3 && i % 5 == 0)
            value = float_of(i % 2 ? 0x7F800000 : 0xFF800000);
        key[i] = key_make(ordered_from_float_bits(bits_of(value)), 0, (uint32_t)i);
        if (kind == 4)
            key[i] = (random_next(random) & ~(uint64_t)UINT32_MAX) | i;
        expected[i] = key[i];
    }
    qsort(expected, n, sizeof *expected, compare_keys);
    msap_sort_values(key, n, scratch, line[by][0], line[by][1]);
    for (i = 0; i < n; i++)
        ck_assert_uint_eq(key[i], expected[i]);
}

/* Values of all kinds, in the order of the lower halves of their keys: on the line that they are said to
 * lie on, beyond both of its ends, in a crowd, all the same, infinite, any bits; lines that are
 * none; and more values than have steps. */
START_TEST(values_are_sorted)
{
    uint64_t random = 3;
    size_t n;
    int way;
    for (n = 0; n < 3000; n += 1 + n / 3)
        for (way = 0; way < KINDS * LINES; way++)
            sort_values(way / LINES, way % LINES, n, &random);
    sort_values(0, 0, MOST_VALUES, &random);
}
END_TEST

/* ---------------------------------------------------------------------- phases */

enum { ITEMS = 2000, EARLIER = 5 };

/* Every item comes to a fresh key, a doomed one, a note and a pair. */
static void find_all(void *context, struct worker *w, size_t first, size_t last)
{
    const size_t *before = context;
    size_t i;
    for (i = *before + first; i < *before + last; i++) {
        msap_settle_change(&w->settler, i, 1);
        msap_settle_change(&w->settler, i, 0);
        msap_settle_note(&w->settler, 0, (uint32_t)i);
        msap_worker_put(w, i);
    }
}

static void holds_all(const struct keys *list)
{
    size_t i;
    ck_assert_uint_eq(list->n, EARLIER + ITEMS);
    for (i = 0; i < list->n; i++)
        ck_assert_uint_eq(list->at[i], i);
}

/* Runs the phase in tasks, with the n-th allocation failing, or all from it on; returns
 * whether it came to an n-th. What it finds stands whole and in order behind what was
 * found earlier, or it says that it had no memory; the list of the doomed, which always
 * has room for those that there can be, says that of its own. */
static int phase_is_whole(size_t n, int and_more)
{
    msap_config config = config_of(3, DEFAULT);
    struct memory m;
    struct crew crew;
    struct worker *own = &crew.worker[0];
    tracker t = {0};
    size_t before = 0;
    int done;
    use_jobs(&config, 3, JOBS_AT_ONCE);
    ok(msap_memory_init(&m, tracked_alloc, tracked_free, &t));
    msap_crew_init(&crew, &config);
    own->settler.memory = &m;
    find_all(&before, own, 0, EARLIER);
    before = EARLIER;
    *(and_more ? &t.fail_from : &t.fail_at) = t.calls + n;
    done = msap_phase_run(&crew, &m, find_all, &before, ITEMS, 512);
    ck_assert((done && !own->settler.has_all_doomed) || t.failures > 0);
    if (done) {
        holds_all(&own->settler.fresh);
        holds_all(&own->settler.notes);
        holds_all(&own->pairs);
    }
    if (done && !own->settler.has_all_doomed)
        holds_all(&own->settler.doomed);
    msap_crew_free(&crew, &m);
    ck_assert(t.bytes == 0 && t.wrong == 0);
    return t.failures > 0;
}

START_TEST(any_allocation_of_a_phase_may_fail)
{
    size_t n = 1, enqueued = jobs_enqueued;
    while (phase_is_whole(n, _i))
        n++;
    ck_assert_uint_gt(n, 10);
    ck_assert_uint_ge(jobs_enqueued, enqueued + 2 * n);
}
END_TEST

/* In a row, an entry has three bits besides its slot. */
START_TEST(slots_with_too_many_bits_do_not_go_into_rows)
{
    msap_config config = config_of(3, DEFAULT);
    struct box_table boxes = {0};
    struct job job = {0};
    msap_world *world;
    ok(msap_create(&config, &world));
    boxes.used = ((size_t)1 << 29) + 1;
    job.boxes = &boxes;
    ck_assert_int_eq(msap_grid_jump(&world->grid, &job), UNSUITED);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("internals");
    tcase_add_test(tests, slots_with_too_many_bits_do_not_go_into_rows);
    tcase_add_loop_test(tests, what_is_broken_is_named, 0, COUNT(breaks));
    tcase_add_loop_test(tests, sizes_that_overflow, DEFAULT, SINGLE_SAP + 1);
    tcase_add_loop_test(tests, large_pools_come_in_huge_pages, 16, 17);
    tcase_add_loop_test(tests, large_pools_come_in_huge_pages, 128, 129);
    tcase_add_loop_test(tests, no_slot_is_left, DEFAULT, SINGLE_SAP + 1);
    tcase_add_loop_test(tests, no_pair_is_left, DEFAULT, SINGLE_SAP + 1);
    tcase_add_loop_test(tests, generations_end, 0, SETUPS);
    tcase_add_loop_test(tests, an_epoch_comes_again, 0, SETUPS);
    tcase_add_loop_test(tests, epochs_end, 0, SETUPS);
    tcase_add_loop_test(tests, tokens_end, 0, SETUPS);
    tcase_add_test(tests, numbers_of_cells_end);
    tcase_add_test(tests, keys_are_sorted);
    tcase_add_test(tests, values_are_sorted);
    tcase_add_loop_test(tests, any_allocation_of_a_phase_may_fail, 0, 2);
    return run_case(tests, "internals");
}
