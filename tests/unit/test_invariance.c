/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: what must not matter does not. A movie of random boxes is played, and played
 * again with its boxes in another order, mirrored, with axes swapped, larger or smaller
 * by a power of two, one change a commit, or backwards: the pairs of every frame, as
 * the events add up to them, must be the same.
 *
 * The pairs are also compared with brute force, so that two wrongs do not make a right.
 */
#include <string.h>

#include "checks.h"

#define BOXES 60
#define FRAMES 30

typedef struct movie {
    box at[FRAMES][BOXES];
    char live[FRAMES][BOXES];
    uint32_t flags[BOXES];
    int order[BOXES]; /* in which the boxes are added and updated */
} movie;

typedef char pair_set[BOXES][BOXES]; /* [a][b] for a < b */

/* A world that shows frames; it knows its pairs from the events alone. */
typedef struct screen {
    msap_world *world;
    msap_handle handles[BOXES];
    int names[BOXES];
    pair_set pairs;
    int wrong; /* events that did not fit */
    int one_by_one;
} screen;

/* ------------------------------------------------------------------ movies */

static void shoot(movie *m, uint64_t seed, scene_kind scene)
{
    uint64_t random = seed;
    int frame, i;
    for (i = 0; i < BOXES; i++) {
        m->flags[i] = random_below(&random, 5) ? 0 : MSAP_STATIC;
        m->order[i] = i;
    }
    for (frame = 0; frame < FRAMES; frame++)
        for (i = 0; i < BOXES; i++) {
            int is_new = frame == 0 || random_below(&random, 20) == 0;
            m->at[frame][i] = is_new ? random_box(&random, scene) : moved_box(&random, scene, &m->at[frame - 1][i]);
            m->live[frame][i] = random_below(&random, 8) > 0;
        }
}

typedef box (*transform)(const box *from, int parameter);

static void change_all(movie *m, transform change, int parameter)
{
    int frame, i;
    for (frame = 0; frame < FRAMES; frame++)
        for (i = 0; i < BOXES; i++)
            m->at[frame][i] = change(&m->at[frame][i], parameter);
}

static box mirror(const box *from, int axis)
{
    box to = *from;
    to.min[axis] = -from->max[axis];
    to.max[axis] = -from->min[axis];
    return to;
}

/* The axes in one of their six orders. */
static box swap_axes(const box *from, int order)
{
    box to;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        int other = (order % 2 ? 3 - axis + order / 2 : axis + order / 2) % 3;
        to.min[axis] = from->min[other];
        to.max[axis] = from->max[other];
    }
    return to;
}

static box scale(const box *from, int exponent)
{
    double power = 1;
    box to;
    int axis;
    for (; exponent > 0; exponent--)
        power *= 2;
    for (; exponent < 0; exponent++)
        power /= 2;
    for (axis = 0; axis < 3; axis++) {
        to.min[axis] = (float)(from->min[axis] * power);
        to.max[axis] = (float)(from->max[axis] * power);
    }
    return to;
}

static void shuffle(movie *m, uint64_t seed)
{
    int i;
    for (i = BOXES - 1; i > 0; i--) {
        int other = (int)random_below(&seed, (uint32_t)i + 1), swap = m->order[i];
        m->order[i] = m->order[other];
        m->order[other] = swap;
    }
}

/* ----------------------------------------------------------------- screens */

/* Notes that a pair has come or gone; it must have been the other way before. */
static void note(screen *s, const void *data_a, const void *data_b, int comes)
{
    int a = *(const int *)data_a, b = *(const int *)data_b;
    char *pair = a < b ? &s->pairs[a][b] : &s->pairs[b][a];
    s->wrong += *pair == comes;
    *pair = (char)comes;
}

static void *on_create(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    (void)a;
    (void)b;
    note(context, data_a, data_b, 1);
    return NULL;
}

static void on_delete(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b, void *pair_data)
{
    (void)a;
    (void)b;
    (void)pair_data;
    note(context, data_a, data_b, 0);
}

static void screen_open(screen *s, int row)
{
    int i;
    memset(s, 0, sizeof *s);
    s->world = new_world(3, row);
    for (i = 0; i < BOXES; i++)
        s->names[i] = i;
}

static void screen_close(screen *s)
{
    ck_assert_int_eq(s->wrong, 0);
    ok(msap_destroy(s->world));
}

static void screen_commit(screen *s)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, on_create, on_delete};
    callbacks.context = s;
    ok(msap_commit(s->world, &callbacks, NULL));
}

/* Brings one box to where it is in the frame. */
static void bring(screen *s, const movie *m, int frame, int i)
{
    const box *b = &m->at[frame][i];
    if (!m->live[frame][i] && s->handles[i]) {
        ok(msap_remove(s->world, s->handles[i]));
        s->handles[i] = MSAP_NULL_HANDLE;
    } else if (m->live[frame][i] && s->handles[i])
        ok(msap_update(s->world, s->handles[i], b->min, b->max));
    else if (m->live[frame][i])
        ok(msap_add(s->world, b->min, b->max, m->flags[i], &s->names[i], &s->handles[i]));
}

static void show(screen *s, const movie *m, int frame)
{
    int i;
    for (i = 0; i < BOXES; i++) {
        bring(s, m, frame, m->order[i]);
        if (s->one_by_one)
            screen_commit(s);
    }
    if (!s->one_by_one)
        screen_commit(s);
}

/* --------------------------------------------------------------- comparing */

static pair_set expected[FRAMES];

/* What is expected of a movie, by brute force. */
static void expect(const movie *m)
{
    int frame, a, b;
    memset(expected, 0, sizeof expected);
    for (frame = 0; frame < FRAMES; frame++)
        for (a = 0; a < BOXES; a++)
            for (b = a + 1; b < BOXES; b++)
                expected[frame][a][b] = m->live[frame][a] && m->live[frame][b] && !(m->flags[a] & m->flags[b]) &&
                                        boxes_overlap(&m->at[frame][a], &m->at[frame][b], 3);
}

static void is_as_expected(const screen *s, int frame, const char *how)
{
    ck_assert_msg(memcmp(s->pairs, expected[frame], sizeof s->pairs) == 0, "%s, %s: frame %d", setup_name, how, frame);
}

static void play(const movie *m, int row, const char *how)
{
    screen s;
    int frame;
    screen_open(&s, row);
    for (frame = 0; frame < FRAMES; frame++) {
        show(&s, m, frame);
        is_as_expected(&s, frame, how);
    }
    screen_close(&s);
}

static movie original, changed;

/* Shoots a movie of this kind and plays it; `changed` is a copy. */
static void start(int row, scene_kind scene)
{
    shoot(&original, (uint64_t)(100 * scene + row), scene);
    expect(&original);
    play(&original, row, "as it is");
    changed = original;
}

START_TEST(the_order_of_the_boxes)
{
    int scene, round;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        start(_i, (scene_kind)scene);
        for (round = 0; round < 3; round++) {
            shuffle(&changed, (uint64_t)round);
            play(&changed, _i, "in another order");
        }
    }
}
END_TEST

START_TEST(mirrored_axes)
{
    int scene, axis;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        start(_i, (scene_kind)scene);
        for (axis = 0; axis < 3; axis++) { /* one, two, three axes */
            change_all(&changed, mirror, axis);
            play(&changed, _i, "mirrored");
        }
    }
}
END_TEST

START_TEST(swapped_axes)
{
    int scene, order;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        start(_i, (scene_kind)scene);
        for (order = 1; order < 6; order++) {
            changed = original;
            change_all(&changed, swap_axes, order);
            play(&changed, _i, "with other axes");
        }
    }
}
END_TEST

/* By powers of two that leave each number exact: the scenes' numbers are whole, and
 * below 2^17. */
START_TEST(scales)
{
    static const int exponents[] = {-149, -140, -40, -1, 3, 50, 110};
    static const scene_kind scenes[] = {SCENE_GRID, SCENE_SPREAD, SCENE_SIZES};
    size_t i, n;
    for (n = 0; n < COUNT(scenes); n++) {
        start(_i, scenes[n]);
        for (i = 0; i < COUNT(exponents); i++) {
            changed = original;
            change_all(&changed, scale, exponents[i]);
            play(&changed, _i, "scaled");
        }
    }
}
END_TEST

START_TEST(one_commit_or_many)
{
    int scene, frame;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        screen s;
        start(_i, (scene_kind)scene);
        screen_open(&s, _i);
        s.one_by_one = 1;
        for (frame = 0; frame < FRAMES; frame++) {
            show(&s, &original, frame);
            is_as_expected(&s, frame, "one by one");
        }
        screen_close(&s);
    }
}
END_TEST

/* To the end and back to the beginning, in the same world. */
START_TEST(backwards)
{
    int scene, frame;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        screen s;
        start(_i, (scene_kind)scene);
        screen_open(&s, _i);
        for (frame = 0; frame < FRAMES; frame++)
            show(&s, &original, frame);
        for (frame = FRAMES - 1; frame >= 0; frame--) {
            show(&s, &original, frame);
            is_as_expected(&s, frame, "backwards");
        }
        screen_close(&s);
    }
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("invariance");
    tcase_add_loop_test(tests, the_order_of_the_boxes, 0, SETUPS);
    tcase_add_loop_test(tests, mirrored_axes, 0, SETUPS);
    tcase_add_loop_test(tests, swapped_axes, 0, SETUPS);
    tcase_add_loop_test(tests, scales, 0, SETUPS);
    tcase_add_loop_test(tests, one_commit_or_many, 0, SETUPS);
    tcase_add_loop_test(tests, backwards, 0, SETUPS);
    return run_case(tests, "invariance");
}
