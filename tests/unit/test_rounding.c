/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: cells know their boxes in rounded bounds, and no box that overlaps is missed for
 * that, however large, small or far out it is, whatever the layout and whichever sweep; what
 * is found besides is nearer than a step; and boxes that are too long to be compared so are
 * known to be. It looks behind the interface.
 */
#include <math.h>
#include <string.h>

#define box inner_box /* the tests have a struct of that name */
#include "../../src/cells.h"
#undef box
#include "checks.h"

enum { BOXES = 240 };

static const uint32_t simd[] = {MSAP_SIMD_NONE, MSAP_SIMD_128, MSAP_SIMD_256, MSAP_SIMD_512};

/* Boxes that are in no world, and where they are in a layout. */
static struct inner_box inner[BOXES];
static struct spot spots[BOXES];

static struct inner_box inner_of(box b)
{
    struct inner_box in;
    memset(&in, 0, sizeof in);
    ck_assert(encode(load_floats((const char *)b.min, sizeof(float), 3),
                     load_floats((const char *)b.max, sizeof(float), 3), &in.fat));
    return in;
}

/* ------------------------------------------------------------------- scenes */

/* Mostly like the boxes of a scene; also a hundred times as large or far out, or endless. */
static float any_of_scene(uint64_t *random, float scale)
{
    static const float kinds[] = {1, 1, 1, 1, 1, 30, 1000, 1e6f, 1e20f};
    float at = ((float)random_below(random, 2001) / 1000 - 1) * scale;
    return at * kinds[random_below(random, COUNT(kinds))];
}

static box any_box(uint64_t *random, float scale)
{
    float low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = any_of_scene(random, scale);
        high[k] = low[k] + fabsf(any_of_scene(random, random_below(random, 2) ? scale / 40 : scale));
        if (random_below(random, 60) == 0) low[k] = -INFINITY;
        if (random_below(random, 60) == 0) high[k] = INFINITY;
    }
    return box_of(low[0], low[1], low[2], high[0], high[1], high[2]);
}

/* The layout of a world with small boxes in a cube, on a floor, in a row or all far away; or as told. */
static msap_world *world_with(int row)
{
    msap_config config = config_of(3, DEFAULT);
    uint64_t random = 7 + (uint64_t)row;
    msap_world *world;
    config.strategy = MSAP_STRATEGY_MERGE; /* by AUTO boxes rest in rows */
    if (row >= 4) {
        config.grid = MSAP_GRID_FIXED;
        for (int k = 0; k < 3; k++) {
            config.grid_min[k] = row == 4 ? -100 : -0.001f;
            config.grid_max[k] = row == 4 ? 100 : 0.001f;
            config.grid_cells[k] = row == 4 ? 7 + 3 * (uint32_t)k : k < 2 ? 5 : 1;
        }
    }
    ok(msap_create(&config, &world));
    for (int i = 0; i < 3000; i++) {
        float at[3];
        for (int k = 0; k < 3; k++) at[k] = (float)random_below(&random, 2001) / 10 - 100 + (row == 3 ? 1e6f : 0);
        if (row == 1) at[1] = 0;
        if (row == 2) at[0] = at[2] = 0;
        add(world, box_of(at[0], at[1], at[2], at[0] + 5, at[1] + 5, at[2] + 5));
    }
    ok(msap_commit(world, NULL, NULL));
    return world;
}
enum { WORLDS = 6 };

/* -------------------------------------------------------------------- cells */

/* A cell of the boxes on a level. */
static struct cell_block block[BOXES / 8 + 1];
static uint32_t fill_cell(struct cell *c, uint32_t level)
{
    memset(c, 0, sizeof *c);
    c->block = block;
    for (uint32_t i = 0; i < BOXES; i++)
        if (spots[i].level == level) cell_put_row(c, c->n++, spots[i].rounded.low, spots[i].rounded.high, i);
    return c->n;
}

/* Sweeps rows first ... last - 1 in all ways; tags what is found. */
static void sweep(const struct cell *c, uint32_t first, uint32_t last, const struct rounded *r, char found[BOXES])
{
    uint32_t list[BOXES + 8], other[BOXES + 8];
    size_t n = msap_sweeps_for(simd[0]).cell(c, first, last, r, list);
    for (size_t s = 1; s < COUNT(simd); s++) {
        ck_assert_uint_eq(msap_sweeps_for(simd[s]).cell(c, first, last, r, other), n);
        ck_assert_int_eq(memcmp(list, other, n * sizeof *list), 0);
    }
    memset(found, 0, BOXES);
    for (size_t i = 0; i < n; i++) found[list[i]] = 1;
}

/* By how many steps of the level the boxes are apart, on the axis on which they are most. */
static double steps_apart(const struct layout *l, uint32_t level, const struct bounds *a, const struct bounds *b)
{
    double most = 0;
    for (int k = 0; k < 3; k++) {
        double gap = fmax(msap_value_of(a->min[k]) - msap_value_of(b->max[k]),
                          msap_value_of(b->min[k]) - msap_value_of(a->max[k]));
        most = fmax(most, ldexp(gap * (double)l->fine[k], -(LEVEL_SHIFT * (int)level)));
    }
    return most;
}

/* Makes boxes: any, or such as the layout is for. */
static void place_boxes(const struct layout *l, uint64_t *random, float scale, int is_plain)
{
    for (int i = 0; i < BOXES; i++) {
        box b = any_box(random, scale);
        for (int k = 0; is_plain && k < 3; k++) {
            b.min[k] = (float)random_below(random, 1001) / 5 - 100;
            b.max[k] = b.min[k] + (float)random_below(random, 1001) / 100;
        }
        inner[i] = inner_of(b);
        spot_of(l, &inner[i].fat, &spots[i]);
    }
}

/* -------------------------------------------------------------------- tests */

START_TEST(what_overlaps_is_found)
{
    msap_world *world = world_with(_i);
    const struct layout *l = &world->grid.layout[world->grid.current];
    uint64_t random = 1;
    int compared = 0, are_long = 0;
    for (int round = 0; round < 4; round++) {
        place_boxes(l, &random, round % 3 == 0 ? 100 : round % 3 == 1 ? 1 : 3000, 0);
        for (uint32_t level = 0; level < LEVELS; level++) {
            struct cell c;
            uint32_t n = fill_cell(&c, level);
            for (uint32_t i = 0; i < BOXES; i++) {
                char found[BOXES];
                struct rounded r;
                if (!rounded_on(l, level, &spots[i], &r)) {
                    ck_assert_uint_ne(spots[i].level, level); /* what stands in a cell is short */
                    are_long++;
                    continue;
                }
                uint32_t first = n ? i % n : 0;
                sweep(&c, first, n, &r, found);
                for (uint32_t row = first; row < n; row++) {
                    uint32_t other = c.block[row / 8].id[row % 8];
                    compared++;
                    ck_assert(found[other] || !overlap(&inner[i].fat, &inner[other].fat));
                }
            }
        }
    }
    ck_assert_int_gt(compared, 30000);
    ck_assert_int_gt(are_long, 30);
    ok(msap_destroy(world));
}
END_TEST

START_TEST(what_is_found_is_near)
{
    msap_world *world = world_with(_i);
    const struct layout *l = &world->grid.layout[world->grid.current];
    uint64_t random = 1;
    int near = 0;
    for (int round = 0; round < 12; round++) {
        struct cell c;
        char found[BOXES];
        place_boxes(l, &random, 100, 1);
        fill_cell(&c, 0);
        for (uint32_t i = 0; i < BOXES; i++) {
            if (spots[i].level != 0) continue;
            sweep(&c, 0, c.n, &spots[i].rounded, found);
            for (uint32_t row = 0; row < c.n; row++) {
                uint32_t other = c.block[row / 8].id[row % 8];
                if (!found[other]) continue;
                near += !overlap(&inner[i].fat, &inner[other].fat);
                ck_assert(steps_apart(l, 0, &inner[i].fat, &inner[other].fat) < 1);
            }
        }
    }
    ck_assert(near > 0 || _i > 0); /* where steps are finer, boxes that are apart are so by more */
    ok(msap_destroy(world));
}
END_TEST

/* One box lies along a row of boxes, over more cells than rounded bounds can tell, and moves aside. */
START_TEST(a_box_along_very_many_cells)
{
    enum { ROW = 2000 };
    msap_world *world = new_world(3, _i);
    msap_handle across;
    for (int i = 0; i < ROW; i++) {
        float at = (float)(2 * i);
        add(world, box_of(at, 0, 0, at + 1, 1, 1));
    }
    commit(world, 0, 0, 0);
    across = add(world, box_of(1.5f, 0.5f, 0.5f, 2 * ROW, 0.6f, 0.6f));
    commit(world, 0, ROW - 1, ROW - 1);
    update(world, across, box_of(11.5f, 0.5f, 0.5f, 2 * ROW, 0.6f, 0.6f));
    commit(world, 5, 0, ROW - 6);
    update(world, across, box_of(11.5f, 1.0625f, 0.5f, 2 * ROW, 1.5f, 0.6f));
    commit(world, ROW - 6, 0, 0);
    update(world, across, box_of(-5, 1, 0.5f, 2 * ROW, 1.5f, 0.6f));
    commit(world, 0, ROW, ROW);
    ok(msap_destroy(world));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("rounding");
    tcase_add_loop_test(tests, what_overlaps_is_found, 0, WORLDS);
    tcase_add_loop_test(tests, what_is_found_is_near, 0, 3);
    tcase_add_loop_test(tests, a_box_along_very_many_cells, 0, SETUPS);
    return run_case(tests, "rounding");
}
