/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: what a grid derives from bounds that are legal - sizes, centres, extents,
 * velocities, margins, numbers of cells - may overflow to infinity, to no number or
 * beyond 64 bits without harm: the events stay those of brute force. In every set-up,
 * among ordinary boxes.
 */
#include "checks.h"

#define INF float_of(0x7F800000)
#define MAX float_of(0x7F7FFFFF)
#define BELOW_MAX float_of(0x7F7FFFFE)
#define TINY float_of(0x00000001)

#define CROWD 150

/* A session with a field of small boxes about 0, some of which overlap. */
typedef struct scene {
    session s;
    msap_handle crowd[CROWD];
} scene;

static box place_in_crowd(int i, int frame)
{
    float x = (float)(i % 15) + 0.25f * (float)frame, y = (float)(i / 15) - 5;
    return box_of(x, y, 0, x + 0.75f, y + 1, 1);
}

static void scene_open(scene *t, const msap_config *config)
{
    int i;
    right(session_open(&t->s, config, 1, SCENE_HARD));
    for (i = 0; i < CROWD; i++) {
        box b = place_in_crowd(i, 0);
        right(session_add(&t->s, &b, 0, &t->crowd[i]));
    }
}

static void check(scene *t)
{
    right(session_commit(&t->s));
    right(session_compare(&t->s));
}

/* The crowd walks on for some frames, as the other boxes stay. */
static void walk(scene *t, int frames)
{
    int frame, i;
    for (frame = 1; frame <= frames; frame++) {
        for (i = 0; i < CROWD; i++) {
            box b = place_in_crowd(i, frame);
            right(session_update(&t->s, t->crowd[i], &b));
        }
        check(t);
    }
}

static void scene_close(scene *t)
{
    int i;
    for (i = 0; i < CROWD; i++)
        right(session_remove(&t->s, t->crowd[i]));
    check(t);
    right(session_close(&t->s));
}

/* A box that is moved from place to place, with a commit at each. */
static void visit(scene *t, const box *places, size_t count)
{
    msap_handle box;
    size_t i;
    right(session_add(&t->s, &places[0], 0, &box));
    check(t);
    for (i = 1; i < count; i++) {
        right(session_update(&t->s, box, &places[i]));
        check(t);
    }
    right(session_remove(&t->s, box));
    check(t);
}

START_TEST(the_size_of_the_whole_range)
{
    msap_config config = config_of(3, _i);
    const box places[] = {
        cube(-MAX, MAX),
        cube(-BELOW_MAX, MAX),
        box_of(-MAX, 0, 0, MAX, 1, 1),
        box_of(-MAX, 0.5f, 0, MAX, 1.5f, 1),
        box_of(0, -MAX, 0, 1, MAX, 1),
        box_of(3, -MAX, 0, 4, MAX, BELOW_MAX),
        cube(-MAX, -BELOW_MAX),
        cube(-INF, MAX),
    };
    scene t;
    scene_open(&t, &config);
    visit(&t, places, COUNT(places));
    walk(&t, 3);
    scene_close(&t);
}
END_TEST

/* So many of them that the layout is made for them; the size of the next ones is
 * beyond a float's, and of some of them no number. */
START_TEST(layouts_of_sizes_that_overflow)
{
    msap_config config = config_of(3, _i);
    const box kinds[] = {cube(-MAX, MAX), cube(-INF, INF), cube(INF, INF), cube(-INF, -INF), box_of(-MAX, 0, 0, MAX, 1, 1)};
    size_t kind;
    int i;
    for (kind = 0; kind < COUNT(kinds); kind++) {
        msap_handle handles[100];
        session s;
        right(session_open(&s, &config, 1, SCENE_HARD));
        for (i = 0; i < 100; i++)
            right(session_add(&s, &kinds[kind], i % 10 ? MSAP_STATIC : 0, &handles[i]));
        right(session_commit(&s));
        right(session_compare(&s));
        for (i = 0; i < 100; i += 2)
            right(session_update(&s, handles[i], &kinds[(kind + 1 + (size_t)i % 2) % COUNT(kinds)]));
        right(session_commit(&s));
        right(session_compare(&s));
        right(session_close(&s));
    }
}
END_TEST

START_TEST(the_centre_of_planes_at_infinity)
{
    msap_config config = config_of(3, _i);
    const box places[] = {
        box_of(-INF, -5, 0, INF, 5, 1),   /* the centre of x is no number */
        box_of(INF, -5, 0, INF, 5, 1),    /* is infinite, as the size is none */
        box_of(-INF, -5, 0, -INF, 5, 1),
        box_of(2, -5, 0, INF, 5, 1),
        box_of(-INF, -INF, -INF, INF, INF, INF),
        box_of(2, INF, 0, 3, INF, 1),
        box_of(2, 0, -INF, 3, 0, -INF),
        box_of(2, 0, 0, 3, 0, 0.5f),
    };
    scene t;
    scene_open(&t, &config);
    visit(&t, places, COUNT(places));
    walk(&t, 3);
    scene_close(&t);
}
END_TEST

/* Centres at both ends of the range: the extent of the scene overflows a float. */
START_TEST(an_extent_beyond_the_range)
{
    msap_config config = config_of(3, _i);
    scene t;
    int i;
    scene_open(&t, &config);
    for (i = 0; i < CROWD; i++) {
        float x = i % 2 ? BELOW_MAX : -BELOW_MAX, y = i % 3 ? BELOW_MAX : -MAX;
        box b = i % 4 ? box_of(x, y, 0, x, y, 1) : box_of(x, y, -MAX, i % 2 ? MAX : x, y, -MAX);
        msap_handle handle;
        right(session_add(&t.s, &b, 0, &handle));
    }
    check(&t);
    walk(&t, 3);
    scene_close(&t);
}
END_TEST

START_TEST(from_one_infinity_to_the_other)
{
    msap_config config = config_of(3, _i);
    const box places[] = {
        box_of(-INF, 0, 0, -INF, 1, 1), box_of(INF, 0, 0, INF, 1, 1),   box_of(-INF, 0, 0, -INF, 1, 1),
        box_of(-INF, 0, 0, INF, 1, 1),  box_of(INF, 0, 0, INF, 1, 1),   box_of(3, 0, 0, 4, 1, 1),
        box_of(-INF, 0, 0, 4, 1, 1),    box_of(-INF, 0, 0, INF, 1, 1),  box_of(3, 0, 0, INF, 1, 1),
        cube(-INF, -INF),               cube(INF, INF),                 cube(-1, 1),
        cube(-MAX, -MAX),               cube(MAX, MAX),                 box_of(-MAX, 0, 0, 1, 1, 1),
    };
    scene t;
    scene_open(&t, &config);
    visit(&t, places, COUNT(places));
    walk(&t, 3);
    visit(&t, places, COUNT(places));
    scene_close(&t);
}
END_TEST

/* A box that stays at an infinity on one axis, where its velocity is no number, while it
 * goes on quietly on another; then it comes in among the others. */
static void along_a_plane(scene *t, int axis, int along, float at)
{
    box b = box_of(2, -3, 0, 8, 3, 6);
    float low = b.min[axis], high = b.max[axis];
    msap_handle handle;
    int i;
    b.min[axis] = b.max[axis] = at;
    right(session_add(&t->s, &b, 0, &handle));
    check(t);
    for (i = 0; i < 12; i++) {
        b.min[along] += 0.0625f;
        b.max[along] += 0.0625f;
        right(session_update(&t->s, handle, &b));
        check(t);
    }
    b.min[axis] = low;
    b.max[axis] = high;
    right(session_update(&t->s, handle, &b));
    check(t);
    right(session_remove(&t->s, handle));
    check(t);
}

START_TEST(staying_at_infinity_while_moving)
{
    msap_config config = config_of(3, _i);
    scene t;
    int axis, along;
    scene_open(&t, &config);
    for (axis = 0; axis < 3; axis++)
        for (along = 0; along < 3; along++)
            if (along != axis) {
                along_a_plane(&t, axis, along, INF);
                along_a_plane(&t, axis, along, -INF);
            }
    scene_close(&t);
}
END_TEST

START_TEST(velocities_that_overflow)
{
    msap_config config = config_of(3, _i);
    scene t;
    msap_handle handle;
    float at = 1;
    int i;
    box b = cube(-MAX, -1e30f);
    scene_open(&t, &config);
    right(session_add(&t.s, &b, 0, &handle));
    for (i = 0; i < 60; i++) { /* a box that grows and flies ever faster, beyond the range */
        check(&t);
        at *= -6;
        b = at < 0 ? cube(at, -at / 2) : cube(-at / 8, at);
        if (at != at || at - at != 0)
            b = i % 2 ? cube(-INF, -MAX) : cube(MAX, INF);
        right(session_update(&t.s, handle, &b));
    }
    check(&t);
    walk(&t, 3);
    scene_close(&t);
}
END_TEST

START_TEST(margins_that_overflow)
{
    static const uint32_t margins[] = {0x7F7FFFFF, 0x7F000000, 0x7E967699, 0x00000001, 0x00800000};
    const box places[] = {
        cube(-MAX, MAX),           cube(MAX, INF), cube(-INF, -MAX), cube(BELOW_MAX, BELOW_MAX), cube(-BELOW_MAX, -BELOW_MAX),
        cube(-INF, -INF),          cube(INF, INF), cube(-TINY, TINY), box_of(0, 0, 0, MAX, 1, 1),
        box_of(-INF, 0, 0, 1, 1, 1),
    };
    size_t i;
    for (i = 0; i < COUNT(margins); i++) {
        msap_config config = config_of(3, _i);
        scene t;
        config.margin = float_of(margins[i]);
        scene_open(&t, &config);
        visit(&t, places, COUNT(places));
        walk(&t, 2);
        scene_close(&t);
    }
}
END_TEST

/* Grids whose max - min overflows a float, whose bounds a float can hardly tell apart,
 * and whose cells are smaller than anything: with every other field of the set-up. */
START_TEST(fixed_grids_at_the_ends_of_the_range)
{
    static const uint32_t bounds[][2] = {
        {0xFF7FFFFF, 0x7F7FFFFF}, /* -FLT_MAX to FLT_MAX */
        {0xFF7FFFFF, 0x00000000}, {0xFEFFFFFF, 0x7F7FFFFF}, {0x7F7FFFFE, 0x7F7FFFFF}, {0xFF7FFFFF, 0xFF7FFFFE},
        {0x00000000, 0x00000001}, {0x80000001, 0x00000001}, {0x4B7FFFFF, 0x4B800000}, {0x7E800000, 0x7F000000},
    };
    static const uint32_t cells[][3] = {{2, 3, 1}, {5, 4, 3}, {4096, 1, 1}};
    const box places[] = {
        cube(-MAX, MAX), cube(-INF, -MAX), cube(-INF, INF), cube(MAX, INF), cube(1, 2), cube(1e30f, 2e30f),
        box_of(-1e38f, 0, 0, 1e38f, 1, 1), cube(BELOW_MAX, MAX), cube(-TINY, TINY),
    };
    size_t i, c;
    for (i = 0; i < COUNT(bounds); i++) {
        msap_config config = config_of(3, _i);
        scene t;
        config.grid = MSAP_GRID_FIXED;
        for (c = 0; c < 3; c++) {
            config.grid_cells[c] = cells[i % COUNT(cells)][c];
            config.grid_min[c] = float_of(bounds[i][0]);
            config.grid_max[c] = float_of(bounds[i][1]);
        }
        scene_open(&t, &config);
        visit(&t, places, COUNT(places));
        walk(&t, 2);
        scene_close(&t);
    }
}
END_TEST

/* Boxes over more cells than 64 bits can count, on every axis. */
START_TEST(more_cells_than_can_be_counted)
{
    msap_config config = config_of(3, _i);
    const box places[] = {
        cube(-1e30f, 1e30f),
        cube(-1e38f, 3e38f),
        box_of(-1e30f, 2, 0, 1e30f, 2, 0),
        box_of(2, 2, 0, 1e30f, 1e30f, 1e30f),
        box_of(-1e30f, -1e30f, -1e30f, -1e29f, -1e29f, -1e29f),
        cube(-INF, INF),
    };
    scene t;
    config.cell_size = config.cell_size != 0 ? config.cell_size : 1e-30f;
    scene_open(&t, &config);
    visit(&t, places, COUNT(places));
    walk(&t, 3);
    scene_close(&t);
}
END_TEST

/* A scene in which no size is a normal number. */
START_TEST(sizes_that_underflow)
{
    msap_config config = config_of(3, _i);
    session s;
    msap_handle handles[CROWD];
    int i, frame;
    right(session_open(&s, &config, 1, SCENE_HARD));
    for (frame = 0; frame < 4; frame++) {
        for (i = 0; i < CROWD; i++) {
            uint32_t x = (uint32_t)(i % 15) * 8 + (uint32_t)frame, y = (uint32_t)(i / 15) * 100000;
            box b = box_of(float_of(x), float_of(y), 0, float_of(x + 8), float_of(y + 5), TINY);
            right(frame ? session_update(&s, handles[i], &b) : session_add(&s, &b, 0, &handles[i]));
        }
        right(session_commit(&s));
        right(session_compare(&s));
    }
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("overflow");
    tcase_add_loop_test(tests, the_size_of_the_whole_range, 0, SETUPS);
    tcase_add_loop_test(tests, layouts_of_sizes_that_overflow, 0, SETUPS);
    tcase_add_loop_test(tests, the_centre_of_planes_at_infinity, 0, SETUPS);
    tcase_add_loop_test(tests, an_extent_beyond_the_range, 0, SETUPS);
    tcase_add_loop_test(tests, from_one_infinity_to_the_other, 0, SETUPS);
    tcase_add_loop_test(tests, staying_at_infinity_while_moving, 0, SETUPS);
    tcase_add_loop_test(tests, velocities_that_overflow, 0, SETUPS);
    tcase_add_loop_test(tests, margins_that_overflow, 0, SETUPS);
    tcase_add_loop_test(tests, fixed_grids_at_the_ends_of_the_range, 0, SETUPS);
    tcase_add_loop_test(tests, more_cells_than_can_be_counted, 0, SETUPS);
    tcase_add_loop_test(tests, sizes_that_underflow, 0, SETUPS);
    return run_case(tests, "overflow");
}
