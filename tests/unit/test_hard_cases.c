/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: the cases that are easy to get wrong, each with events worked out by hand,
 * in every set-up and, unless said, in every environment of hard.h.
 *
 * More of them: test_touching_boxes.c, test_hard_numbers.c, test_events.c (what
 * happens within one commit), test_bad_bounds.c; margins and doubles have files of
 * their own.
 */
#include <stdio.h>

#include "checks.h"
#include "hard.h"

#define INF float_of(0x7F800000)
#define MAX float_of(0x7F7FFFFF)
#define BELOW_MAX float_of(0x7F7FFFFE)
#define TINY float_of(0x00000001)
#define ABOVE_1 float_of(0x3F800001)

static const environment *current = environments;

/* A world in the set-up of this row; messages name the environment too. */
static msap_world *hard_world(int row)
{
    static char name[128];
    msap_world *world = new_world(3, row);
    snprintf(name, sizeof name, "%s, %s", setup_name, current->name);
    setup_name = name;
    return world;
}

static void in_all_environments(void (*hard_case)(int row), int row)
{
    size_t i;
    for (i = 0; i < ENVIRONMENTS; i++) {
        current = &environments[i];
        environment_enter(current);
        hard_case(row);
        environment_leave(current);
    }
}

/* A test of this name, played in all environments; `row` is the set-up's. */
#define HARD_CASE(name) \
    static void name##_at(int row); \
    START_TEST(name) \
    { \
        in_all_environments(name##_at, _i); \
    } \
    END_TEST \
    static void name##_at(int row)

/* `bounds` with another interval on an axis. */
static box with(box bounds, int axis, float min, float max)
{
    bounds.min[axis] = min;
    bounds.max[axis] = max;
    return bounds;
}

/* ----------------------------------------------------------------- touching */

/* One of the 27 unit cubes around and with [0, 1]^3: step -1, 0 or 1 on each axis.
 * `apart`: those beside leave the cubes before them by one ulp. */
static box cube_of_27(int i, int apart)
{
    box b = cube(0, 1);
    int axis;
    for (axis = 0; axis < 3; axis++, i /= 3)
        if (i % 3 == 0)
            b = with(b, axis, -1, apart ? -TINY : 0);
        else if (i % 3 == 2)
            b = with(b, axis, apart ? ABOVE_1 : 1, 2);
    return b;
}

/* Of two cubes, the steps on an axis must differ by 1 at most: 7 of 9 combinations,
 * so (7^3 - 27) / 2 = 158 pairs share a face, an edge or a corner. One ulp apart, no
 * two do. */
HARD_CASE(faces_edges_and_corners)
{
    msap_world *world = hard_world(row);
    msap_handle handles[27];
    int i;
    for (i = 0; i < 27; i++)
        handles[i] = add(world, cube_of_27(i, 0));
    commit(world, 0, 158, 158);
    for (i = 0; i < 27; i++)
        update(world, handles[i], cube_of_27(i, 1));
    commit(world, 158, 0, 0);
    for (i = 0; i < 27; i++)
        update(world, handles[i], cube_of_27(i, 0));
    commit(world, 0, 158, 158);
    ok(msap_destroy(world));
}

/* Of two boxes one ends where the other begins, and then one ulp before, on each axis,
 * on both sides of 0. */
HARD_CASE(one_ulp_on_every_axis)
{
    static const uint32_t at[] = {0x00000000, 0x00000001, 0x007FFFFF, 0x00800000, 0x3F800000,
                                  0x4B189680, 0x7EFFFFFF, 0x7F7FFFFE, 0x7F7FFFFF};
    msap_world *world = hard_world(row);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(0, 1));
    size_t i;
    int axis;
    commit(world, 0, 1, 1);
    for (axis = 0; axis < 3; axis++)
        for (i = 0; i < COUNT(at); i++) {
            float value = float_of(at[i]), above = float_of(at[i] + 1);
            update(world, a, with(cube(0, 1), axis, -INF, value));
            update(world, b, with(cube(0, 1), axis, above, INF));
            commit(world, 1, 0, 0);
            update(world, b, with(cube(0, 1), axis, value, INF));
            commit(world, 0, 1, 1);
            update(world, a, with(cube(0, 1), axis, -above, INF));
            update(world, b, with(cube(0, 1), axis, -INF, -above));
            commit(world, 0, 0, 1);
            update(world, a, with(cube(0, 1), axis, -value, INF));
            commit(world, 1, 0, 0);
            update(world, b, with(cube(0, 1), axis, -value, INF));
            commit(world, 0, 1, 1);
        }
    ok(msap_destroy(world));
}

/* On each axis, of two boxes one ends at a zero and the other begins at one, of either
 * sign; then a step of the least number parts them, below zero or above. */
HARD_CASE(zeros_of_both_signs)
{
    float minus_zero = float_of(0x80000000);
    int axis, signs;
    for (axis = 0; axis < 3; axis++)
        for (signs = 0; signs < 4; signs++) {
            float ends = signs & 1 ? minus_zero : 0, begins = signs & 2 ? minus_zero : 0;
            msap_world *world = hard_world(row);
            msap_handle a = add(world, with(cube(0, 1), axis, -1, ends)),
                        b = add(world, with(cube(0, 1), axis, begins, 1));
            add(world, with(cube(0, 1), axis, begins, ends)); /* no size, whichever zero comes first */
            commit(world, 0, 3, 3);
            update(world, a, with(cube(0, 1), axis, -1, -TINY));
            commit(world, 2, 0, 1);
            update(world, b, with(cube(0, 1), axis, -TINY, 1));
            commit(world, 0, 1, 2);
            update(world, a, with(cube(0, 1), axis, -1, begins));
            update(world, b, with(cube(0, 1), axis, TINY, 1));
            commit(world, 2, 1, 1);
            ok(msap_destroy(world));
        }
}

/* A cube; a point on each of its faces, a plate on its upper face, a line on an edge.
 * The cube meets all 8; the plate the point below it and the end of the line. One ulp
 * off the cube, the plate still has its point, and the line is off its corner. */
HARD_CASE(no_size_on_a_face)
{
    msap_world *world = hard_world(row);
    box middle = cube(0.5f, 0.5f), plate = with(cube(0, 1), 2, 1, 1), line = with(with(cube(0, 1), 0, 1, 1), 1, 1, 1);
    msap_handle points[6], of_plate, of_line;
    int i;
    add(world, cube(0, 1));
    for (i = 0; i < 6; i++)
        points[i] = add(world, with(middle, i / 2, (float)(i % 2), (float)(i % 2)));
    of_plate = add(world, plate);
    of_line = add(world, line);
    commit(world, 0, 10, 10);
    for (i = 0; i < 6; i++)
        update(world, points[i], with(middle, i / 2, i % 2 ? ABOVE_1 : -TINY, i % 2 ? ABOVE_1 : -TINY));
    update(world, of_plate, with(plate, 2, ABOVE_1, ABOVE_1));
    update(world, of_line, with(line, 0, ABOVE_1, ABOVE_1));
    commit(world, 9, 0, 1);
    ck_assert(is_pair(world, of_plate, points[5]));
    ok(msap_destroy(world));
}

/* -------------------------------------------------------------- equal values */

/* As commit of checks.h, but without validation, whose cost is the cube of so many
 * neighbours. */
static void commit_crowd(msap_world *world, uint64_t deleted, uint64_t created, uint64_t active)
{
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    ok(msap_commit(world, NULL, &counts));
    ck_assert_uint_eq(counts.deleted, deleted);
    ck_assert_uint_eq(counts.created, created);
    ck_assert_uint_eq(counts.active, active);
}

/* 1200 boxes that are the same: 1200 * 1199 / 2 pairs. (In one environment: it takes
 * a while.) */
START_TEST(identical_boxes_by_the_thousand)
{
    static msap_handle handles[1200];
    msap_world *world = new_world(3, _i);
    int i;
    for (i = 0; i < 1200; i++)
        handles[i] = add(world, cube(1, 2));
    commit_crowd(world, 0, 719400, 719400);
    update(world, handles[600], with(cube(1, 2), 1, 3, 4));
    commit_crowd(world, 1199, 0, 718201);
    for (i = 0; i < 1200; i++)
        update(world, handles[i], cube(-5, -5));
    commit_crowd(world, 0, 1199, 719400);
    ok(msap_destroy(world));
}
END_TEST

/* 300 bars in a row, each touching the next, that have all their end points on another
 * axis at 7. What moves there by one ulp leaves those that do not. */
HARD_CASE(all_end_points_equal_on_one_axis)
{
    float at = float_of(0x40E00000), above = float_of(0x40E00001);
    int axis, i;
    for (axis = 0; axis < 3; axis++) {
        msap_world *world = hard_world(row);
        msap_handle handles[300];
        box bars[300];
        for (i = 0; i < 300; i++) {
            bars[i] = with(with(cube(0, 1), axis, at, at), (axis + 1) % 3, (float)i, (float)(i + 1));
            handles[i] = add(world, bars[i]);
        }
        commit(world, 0, 299, 299);
        for (i = 0; i < 300; i++)
            update(world, handles[i], with(bars[i], axis, at, i % 2 ? above : at));
        commit(world, 0, 0, 299);
        for (i = 1; i < 300; i += 2)
            update(world, handles[i], with(bars[i], axis, above, above));
        commit(world, 299, 0, 0);
        for (i = 0; i < 300; i += 2)
            update(world, handles[i], with(bars[i], axis, above, above));
        commit(world, 0, 299, 299);
        ok(msap_destroy(world));
    }
}

/* ---------------------------------------------------------------- infinities */

/* Three planes, each infinite on two axes, and 10 cubes in a row along x that stand on
 * two of them: each plane meets the others, and those two meet the cubes. The third
 * passes through the row. */
HARD_CASE(infinite_planes_cross)
{
    msap_world *world = hard_world(row);
    box all = cube(-INF, INF);
    msap_handle plane = add(world, with(all, 0, -5, -5));
    int i;
    add(world, with(all, 1, 0, 0));
    add(world, with(all, 2, 0, 0));
    for (i = 0; i < 10; i++)
        add(world, bar((float)(2 * i), (float)(2 * i + 1)));
    commit(world, 0, 23, 23);
    update(world, plane, with(all, 0, 0, 0));
    commit(world, 0, 1, 24);
    for (i = 1; i < 10; i++) {
        update(world, plane, with(all, 0, (float)(2 * i), (float)(2 * i)));
        commit(world, 1, 1, 24);
    }
    update(world, plane, all);
    commit(world, 0, 9, 33);
    update(world, plane, with(all, 0, INF, INF));
    commit(world, 10, 0, 23);
    update(world, plane, with(all, 0, -INF, 4));
    commit(world, 0, 3, 26);
    ok(msap_destroy(world));
}

/* All and nothing: 3 boxes of everything, 3 at +inf, 3 at -inf, and the two halves of
 * space. The first 3 meet each other and all others (3 + 24), each 3 at an end meet
 * each other and their half (12), and the halves meet at 0. Then those at the ends
 * change places, again and again. */
HARD_CASE(nothing_but_infinities)
{
    msap_world *world = hard_world(row);
    msap_handle end[6];
    int i, frame;
    for (i = 0; i < 3; i++)
        add(world, cube(-INF, INF));
    for (i = 0; i < 6; i++)
        end[i] = add(world, i < 3 ? cube(INF, INF) : cube(-INF, -INF));
    add(world, cube(0, INF));
    add(world, cube(-INF, 0));
    commit(world, 0, 40, 40);
    for (frame = 0; frame < 40; frame++) {
        for (i = 0; i < 6; i++)
            update(world, end[i], (i < 3) == frame % 2 ? cube(INF, INF) : cube(-INF, -INF));
        commit(world, 6, 6, 40);
    }
    ok(msap_destroy(world));
}

/* Points at the ends of the floats, neighbours of each other; and what spans them. */
HARD_CASE(about_flt_max)
{
    static const uint32_t at[] = {0xFF800000, 0xFF7FFFFF, 0xFF7FFFFE, 0x7F7FFFFE, 0x7F7FFFFF, 0x7F800000};
    msap_world *world = hard_world(row);
    msap_handle points[6], all, upper, lower;
    int i;
    for (i = 0; i < 6; i++)
        points[i] = add(world, with(cube(0, 1), 1, float_of(at[i]), float_of(at[i])));
    commit(world, 0, 0, 0);
    all = add(world, with(cube(0, 1), 1, -MAX, MAX));
    upper = add(world, with(cube(0, 1), 1, MAX, INF));
    lower = add(world, with(cube(0, 1), 1, -INF, -MAX));
    commit(world, 0, 10, 10); /* 4 points and 2 ends; 2 points; 2 points */
    update(world, points[5], with(cube(0, 1), 1, -INF, -INF)); /* from the upper to the lower, onto point 0 */
    commit(world, 1, 2, 11);
    update(world, all, with(cube(0, 1), 1, -BELOW_MAX, BELOW_MAX)); /* leaves 2 points and both ends */
    commit(world, 4, 0, 7);
    ok(msap_remove(world, upper));
    ok(msap_remove(world, lower));
    commit(world, 4, 0, 3);
    ok(msap_destroy(world));
}

/* ---------------------------------------------------------- within one commit */

/* From a to c, by way of nothing, of everything, and through b. */
HARD_CASE(shrinks_grows_and_passes_through)
{
    msap_world *world = hard_world(row);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(3, 4)), c = add(world, cube(6, 7)),
                it = add(world, cube(-1, 0));
    commit(world, 0, 1, 1);
    ck_assert(is_pair(world, a, it));
    update(world, it, cube(0, 0));
    update(world, it, cube(-INF, INF));
    update(world, it, cube(3, 4));
    update(world, it, cube(7, 8));
    commit(world, 1, 1, 1);
    ck_assert(is_pair(world, c, it));
    update(world, it, cube(-INF, INF));
    commit(world, 0, 2, 3);
    update(world, it, cube(8, 8)); /* from everything to nothing */
    commit(world, 3, 0, 0);
    update(world, it, cube(3.5f, 3.5f));
    update(world, b, cube(5, 5)); /* left before it came */
    commit(world, 0, 0, 0);
    update(world, it, cube(-INF, INF));
    update(world, it, cube(3.5f, 3.5f));
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}

/* A box goes and comes back where it was, with another handle: the pair ends, and
 * another begins. Its slot, 0, is given out from the next commit on. */
HARD_CASE(removed_and_added_again)
{
    msap_world *world = hard_world(row);
    msap_handle a = add(world, cube(0, 1)), b = add(world, cube(1, 2)), again;
    commit(world, 0, 1, 1);
    ok(msap_remove(world, a));
    again = add(world, cube(0, 1));
    ck_assert_uint_eq(again >> 32, 2);
    commit(world, 1, 1, 1);
    ck_assert(is_pair(world, b, again));
    ok(msap_remove(world, again));
    a = add(world, cube(0, 1));
    ck_assert_uint_eq(a, 2); /* slot 0, generation 2 */
    ok(msap_remove(world, a));
    a = add(world, cube(-INF, INF));
    ck_assert_uint_eq(a >> 32, 3);
    commit(world, 1, 1, 1);
    ck_assert(is_pair(world, b, a));
    ok(msap_destroy(world));
}

/* Where a box of the swaps is: at 0 or at `far`, on the axes of the mask. */
static box place_of_swap(int axes, float far)
{
    box b = cube(0, 1);
    int axis;
    for (axis = 0; axis < 3; axis++)
        if (axes >> axis & 1)
            b = with(b, axis, far, far + 1);
    return b;
}

/* Two boxes, each upon a floor tile of its own, change places on one, two or three
 * axes; then they do so touching, which is no change to the two. */
HARD_CASE(swaps_on_one_two_and_three_axes)
{
    int axes;
    for (axes = 1; axes < 8; axes++) {
        msap_world *world = hard_world(row);
        box here = cube(0, 1), there = place_of_swap(axes, 5), beside = place_of_swap(axes, 1);
        msap_handle tile = add_flagged(world, here, MSAP_STATIC), a = add(world, here), b = add(world, there);
        add_flagged(world, there, MSAP_STATIC);
        commit(world, 0, 2, 2);
        update(world, a, there);
        update(world, b, here);
        commit(world, 2, 2, 2);
        ck_assert(is_pair(world, tile, b) && !is_pair(world, tile, a) && !is_pair(world, a, b));
        update(world, a, beside); /* touches b and the tile */
        commit(world, 1, 2, 3);
        update(world, a, here);
        update(world, b, beside);
        commit(world, 0, 0, 3);
        ok(msap_destroy(world));
    }
}

/* --------------------------------------------- environments that come and go */

static void same_pairs(const msap_world *world, const msap_world *other,
                       msap_status (*list)(const msap_world *, const msap_pair **, size_t *))
{
    const msap_pair *pairs, *others;
    size_t count, other_count, i, differ = 0;
    ok(list(world, &pairs, &count));
    ok(list(other, &others, &other_count));
    ck_assert_uint_eq(count, other_count);
    for (i = 0; i < count; i++)
        differ += pairs[i].a != others[i].a || pairs[i].b != others[i].b;
    ck_assert_uint_eq(differ, 0);
}

/* Hard numbers; or, of the second kind, subnormals about 0 alone. */
static box random_bounds(uint64_t *random, int kind)
{
    box b = random_box(random, kind ? SCENE_GRID : SCENE_HARD);
    int axis;
    for (axis = 0; axis < 3 && kind; axis++) {
        b.min[axis] *= TINY;
        b.max[axis] *= TINY;
    }
    return b;
}

/* Of two worlds, one is called in one environment, the other in another at every frame:
 * what was put into a structure in one must be found there in the next. */
START_TEST(environments_change_between_commits)
{
    uint64_t random = 1;
    int kind, frame, i;
    for (kind = 0; kind < 2; kind++) {
        msap_world *world = new_world(3, _i), *other = new_world(3, _i);
        msap_handle handles[80];
        for (frame = 0; frame < 30; frame++) {
            box boxes[80];
            for (i = 0; i < 80; i++) {
                boxes[i] = random_bounds(&random, kind);
                if (frame == 0)
                    handles[i] = add(world, boxes[i]);
                else if (i % 30 > frame)
                    update(world, handles[i], boxes[i]);
            }
            ok(msap_commit(world, NULL, NULL));
            environment_enter(&environments[frame % (int)ENVIRONMENTS]);
            for (i = 0; i < 80; i++)
                if (frame == 0)
                    add(other, boxes[i]);
                else if (i % 30 > frame)
                    update(other, handles[i], boxes[i]);
            ok(msap_commit(other, NULL, NULL));
            ok(msap_validate(other, NULL));
            environment_leave(&environments[frame % (int)ENVIRONMENTS]);
            same_pairs(world, other, msap_deleted);
            same_pairs(world, other, msap_created);
        }
        ok(msap_destroy(world));
        ok(msap_destroy(other));
    }
}
END_TEST

/* ------------------------------------------------------------------- refusals */

/* Bounds that differ by one ulp where the host may take both for 0, and others that
 * look wrong and are not. */
HARD_CASE(refused_and_accepted)
{
    static const struct {
        uint32_t min, max, status, bound_of_y;
    } cases[] = {
        {0x00000002, 0x00000001, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x00000001, 0x00000002, MSAP_OK, 0},
        {0x00000001, 0x80000000, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x80000001, 0x00000000, MSAP_OK, 0},
        {0x80000001, 0x80000002, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x80000002, 0x80000001, MSAP_OK, 0},
        {0x00000000, 0x80000001, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x00000000, 0x80000000, MSAP_OK, 0},
        {0x00800000, 0x007FFFFF, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x80000000, 0x00000000, MSAP_OK, 0},
        {0x7F800000, 0x7F7FFFFF, MSAP_ERROR_INVERTED, MSAP_MIN_Y}, {0x7F800000, 0x7F800000, MSAP_OK, 0},
        {0x7F800001, 0x7F800001, MSAP_ERROR_NAN, MSAP_MIN_Y},      {0xFF800000, 0xFF800000, MSAP_OK, 0},
        {0xFF800000, 0x7FC00000, MSAP_ERROR_NAN, MSAP_MAX_Y},      {0xFF800000, 0x7F800000, MSAP_OK, 0},
        {0xFFFFFFFF, 0x7F800000, MSAP_ERROR_NAN, MSAP_MIN_Y},      {0x00000000, 0x7F800000, MSAP_OK, 0},
    };
    msap_world *world = hard_world(row);
    msap_handle handle = add(world, cube(0, 1));
    size_t i;
    for (i = 0; i < COUNT(cases); i++) {
        msap_handle handles[2] = {handle, handle};
        box two[2];
        msap_boxes boxes = boxes_in_row(two);
        two[0] = cube(0, 1);
        two[1] = with(cube(0, 1), 1, float_of(cases[i].min), float_of(cases[i].max));
        ck_assert_uint_eq(msap_update(world, handle, two[1].min, two[1].max), cases[i].status);
        ck_assert_uint_eq(msap_update_many(world, 2, handles, &boxes), cases[i].status);
        if (cases[i].status)
            last_error(world, (msap_status)cases[i].status, 1, (msap_bound)cases[i].bound_of_y);
    }
    commit(world, 0, 0, 0);
    ok(msap_destroy(world));
}

/* ------------------------------------------------------------------- set-ups */

/* Where it is legal, three boxes meet at 0, and then one leaves by one ulp. */
static void create_and_use(const msap_config *config, uint32_t status)
{
    msap_world *world = NULL;
    msap_handle handle;
    ck_assert_uint_eq(msap_create(config, &world), status);
    if (status)
        return;
    add(world, cube(0, 1));
    add(world, cube(-1, 0));
    handle = add(world, cube(0, 0));
    commit(world, 0, 3, 3);
    update(world, handle, cube(TINY, TINY));
    commit(world, 1, 0, 2);
    ok(msap_destroy(world));
}

/* What msap_create says to a margin, a cell size and the ends of a grid. */
static void set_ups(int row)
{
    static const struct {
        uint32_t value, as_margin, as_cell_size;
    } sizes[] = {
        {0x00000000, MSAP_OK, MSAP_OK},
        {0x80000000, MSAP_OK, MSAP_OK},
        {0x00000001, MSAP_OK, MSAP_OK},
        {0x80000001, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG}, /* below 0 */
        {0x7F7FFFFF, MSAP_OK, MSAP_OK},
        {0x7F800000, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG},
        {0xFF800000, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG},
        {0x7FC00000, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG},
        {0xFFC00001, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG},
        {0xBF800000, MSAP_OK, MSAP_ERROR_CONFIG}, /* MSAP_MARGIN_AUTO */
        {0xBF800001, MSAP_ERROR_CONFIG, MSAP_ERROR_CONFIG},
    };
    static const struct {
        uint32_t min, max, status;
    } ends[] = {
        {0x00000000, 0x00000001, MSAP_OK}, {0x00000001, 0x00000000, MSAP_ERROR_CONFIG},
        {0x80000001, 0x00000000, MSAP_OK}, {0x00000000, 0x80000001, MSAP_ERROR_CONFIG},
        {0x007FFFFF, 0x00800000, MSAP_OK}, {0x00000000, 0x80000000, MSAP_ERROR_CONFIG},
        {0xFF7FFFFF, 0x7F7FFFFF, MSAP_OK}, {0x00000001, 0x00000001, MSAP_ERROR_CONFIG},
        {0x7F7FFFFE, 0x7F7FFFFF, MSAP_OK}, {0x7F7FFFFF, 0x7F800000, MSAP_ERROR_CONFIG},
    };
    size_t i;
    for (i = 0; i < COUNT(sizes); i++) {
        msap_config margin = config_of(3, row), cell_size = config_of(3, row);
        margin.margin = float_of(sizes[i].value);
        cell_size.cell_size = float_of(sizes[i].value);
        create_and_use(&margin, sizes[i].as_margin);
        create_and_use(&cell_size, sizes[i].as_cell_size);
    }
    for (i = 0; i < COUNT(ends); i++) {
        msap_config config = config_of(3, row);
        config.grid = MSAP_GRID_FIXED;
        config.grid_cells[1] = 4;
        config.grid_min[1] = float_of(ends[i].min);
        config.grid_max[1] = float_of(ends[i].max);
        create_and_use(&config, ends[i].status);
    }
}

START_TEST(set_ups_refused_and_accepted)
{
    in_all_environments(set_ups, DEFAULT);
}
END_TEST

/* -------------------------------------------------------------------- pruning */

/* The boxes of nothing_but_infinities, along an axis that is chosen from centres and
 * spreads that are none, then along each axis. (No set-up: one run.) */
static void prune_infinities(int row)
{
    box boxes[11];
    msap_boxes view;
    msap_prune_config config;
    int i;
    (void)row;
    for (i = 0; i < 11; i++)
        boxes[i] = i < 3 ? cube(-INF, INF) : i < 6 ? cube(INF, INF) : cube(-INF, i < 9 ? -INF : 0);
    boxes[10] = cube(0, INF);
    view = boxes_in_row(boxes);
    ok(msap_prune_config_init(&config, sizeof config));
    for (config.axis = MSAP_AXIS_AUTO; config.axis < 3; config.axis++) {
        msap_index_pair *pairs = NULL;
        size_t count = 0;
        ok(msap_prune(&config, 11, &view, &pairs, &count, NULL));
        ck_assert_uint_eq(count, 40);
        ok(msap_prune_free(&config, pairs, count));
        ok(msap_prune_bipartite(&config, 11, &view, 11, &view, &pairs, &count, NULL));
        ck_assert_uint_eq(count, 91); /* each pair in both orders, and each box with itself */
        ok(msap_prune_free(&config, pairs, count));
    }
}

START_TEST(pruning_nothing_but_infinities)
{
    in_all_environments(prune_infinities, DEFAULT);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("hard cases");
    tcase_add_loop_test(tests, faces_edges_and_corners, 0, SETUPS);
    tcase_add_loop_test(tests, one_ulp_on_every_axis, 0, SETUPS);
    tcase_add_loop_test(tests, zeros_of_both_signs, 0, SETUPS);
    tcase_add_loop_test(tests, no_size_on_a_face, 0, SETUPS);
    tcase_add_loop_test(tests, identical_boxes_by_the_thousand, 0, SETUPS);
    tcase_add_loop_test(tests, all_end_points_equal_on_one_axis, 0, SETUPS);
    tcase_add_loop_test(tests, infinite_planes_cross, 0, SETUPS);
    tcase_add_loop_test(tests, nothing_but_infinities, 0, SETUPS);
    tcase_add_loop_test(tests, about_flt_max, 0, SETUPS);
    tcase_add_loop_test(tests, shrinks_grows_and_passes_through, 0, SETUPS);
    tcase_add_loop_test(tests, removed_and_added_again, 0, SETUPS);
    tcase_add_loop_test(tests, swaps_on_one_two_and_three_axes, 0, SETUPS);
    tcase_add_loop_test(tests, environments_change_between_commits, 0, SETUPS);
    tcase_add_loop_test(tests, refused_and_accepted, 0, SETUPS);
    tcase_add_test(tests, set_ups_refused_and_accepted);
    tcase_add_test(tests, pruning_nothing_but_infinities);
    return run_case(tests, "hard cases");
}
