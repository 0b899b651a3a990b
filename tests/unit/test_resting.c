/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: boxes that stay where they were pruned (rest.c) have all their pairs, whoever of them moves or
 * goes, alone or with others; they go over to the cells when they move, and not before. So it is whether
 * rows are asked for these pairs or they are noted (partners.c). It looks behind the interface to see which way was
 * taken.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { MOST = 1100 };

/* A session, the handles of its boxes and how many of these there are. */
typedef struct loaded {
    session s;
    msap_handle handles[MOST];
    box bounds[MOST];
    uint32_t n;
} loaded;

static void open_level(loaded *l, int row, uint32_t dims, scene_kind scene)
{
    msap_config config = config_of(dims, row);
    l->n = 0;
    right(session_open(&l->s, &config, 7 + (uint64_t)row, scene));
}

static void put(loaded *l, box bounds, uint32_t flags)
{
    l->bounds[l->n] = bounds;
    right(session_add(&l->s, &bounds, flags, &l->handles[l->n++]));
}

/* So many random boxes, of sixteen of which so many are static. */
static void put_some(loaded *l, uint32_t n, uint32_t statics)
{
    for (uint32_t i = 0; i < n; i++)
        put(l, random_box(&l->s.random, l->s.scene), random_below(&l->s.random, 16) < statics ? MSAP_STATIC : 0);
}

/* So many boxes side by side, 30 in a line, the first of them static. */
static void put_floor(loaded *l, int n, int statics)
{
    for (int i = 0; i < n; i++) {
        float x = (float)(i % 30), y = (float)(i / 30);
        put(l, box_of(x, y, 0, x + 1, y + 1, 1), i < statics ? MSAP_STATIC : 0);
    }
}

static void move(loaded *l, uint32_t i)
{
    l->bounds[i] = random_below(&l->s.random, 4) ? moved_box(&l->s.random, l->s.scene, &l->bounds[i])
                                                 : random_box(&l->s.random, l->s.scene);
    right(session_update(&l->s, l->handles[i], &l->bounds[i]));
}

static void take_away(loaded *l, uint32_t i)
{
    right(session_remove(&l->s, l->handles[i]));
    l->handles[i] = l->handles[--l->n];
    l->bounds[i] = l->bounds[l->n];
}

static void step(loaded *l)
{
    right(session_commit(&l->s));
    right(session_compare(&l->s));
}

/* Whether the set-up chooses its ways itself, in a grid. */
static int is_free(const loaded *l)
{
    const msap_config *c = &l->s.world->config;
    return c->grid != MSAP_GRID_NONE && c->strategy == MSAP_STRATEGY_AUTO;
}

static uint32_t count_resting(const loaded *l)
{
    const struct grid *g = &l->s.world->grid;
    uint32_t n = 0;
    for (size_t slot = 0; slot < g->boxes->used; slot++) n += (uint32_t)rests(g, &g->boxes->at[slot]);
    return n;
}

/* Static boxes rest from the start if most boxes are static, the others do not. A box that moves does not rest any
 * more, and that is all that happens. */
START_TEST(a_box_rests_until_it_moves)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_SPREAD);
    put_some(&l, 380, 16);
    put_some(&l, 20, 0);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 380);
    for (uint32_t i = 0; i < 10; i++) {
        move(&l, i);
        move(&l, 390);
        step(&l);
        if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 379 - i);
    }
    take_away(&l, 100);
    put_some(&l, 3, 16); /* what comes does not rest */
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 369);
    right(session_close(&l.s));
}
END_TEST

/* Where more are not static, they rest too, for as long as nothing moves; nothing is kept when
 * boxes only go. */
START_TEST(a_level_is_loaded_and_unloaded)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    put_some(&l, 500, 11);
    step(&l);
    for (uint32_t i = 0; i < 250; i++) take_away(&l, random_below(&l.s.random, l.n));
    step(&l);
    if (is_free(&l)) ck_assert(l.s.world->grid.is_jumping && count_resting(&l) == 0);
    put_some(&l, 1, 16); /* into a slot that the rows still name */
    move(&l, 3);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 249);
    put_some(&l, 250, 11);
    step(&l);
    right(session_close(&l.s));
}
END_TEST

/* Where a quarter of the boxes or more are new, the pairs of all are compared with those that are known, and are
 * known in order from then on. Where fewer are, each pair is asked for what it was. */
START_TEST(pairs_of_many_that_come_are_compared)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    put_some(&l, 160, 16);
    put_some(&l, 80, 0); /* so many are not static that nothing rests */
    step(&l);
    const struct grid *g = &l.s.world->grid;
    if (is_free(&l)) ck_assert(g->is_jumping && g->knows_pairs);
    put_some(&l, 40, 4);
    step(&l);
    if (is_free(&l)) ck_assert(g->is_jumping && !g->knows_pairs);
    for (uint32_t i = 0; i < 80; i++) take_away(&l, random_below(&l.s.random, l.n));
    put_some(&l, 80, 4);
    step(&l);
    if (is_free(&l)) ck_assert(g->is_jumping && g->knows_pairs);
    right(session_close(&l.s));
}
END_TEST

/* All sorts of changes, at first of boxes that rest: of one or some or most in a commit. */
static void change(loaded *l)
{
    uint32_t some = 1 + random_below(&l->s.random, random_below(&l->s.random, 8) ? 8 : l->n);
    for (uint32_t i = 0; i < some; i++) {
        uint32_t at = random_below(&l->s.random, l->n);
        if (random_below(&l->s.random, 6) || l->n < 40) move(l, at);
        else take_away(l, at);
    }
    if (l->n + 8 < MOST) put_some(l, random_below(&l->s.random, 8), 8);
}

START_TEST(all_pairs_of_boxes_that_rest)
{
    uint32_t rested = 0;
    int chooses = 0;
    for (uint32_t scene = 0; scene < SCENE_COUNT; scene++)
        for (uint32_t statics = 9; statics <= 16; statics += 3) {
            loaded l;
            open_level(&l, _i, 2 + (scene + statics) % 2, (scene_kind)scene);
            put_some(&l, 150, statics);
            step(&l);
            for (int frame = 0; frame < 12; frame++) {
                change(&l);
                step(&l);
                rested += count_resting(&l);
            }
            chooses = is_free(&l);
            right(session_close(&l.s));
        }
    ck_assert(!chooses || rested > 0);
}
END_TEST

/* When many boxes come, or go, all that are static rest anew; who does not, does not. */
START_TEST(more_is_loaded)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_SPREAD);
    put_some(&l, 180, 16);
    put_some(&l, 20, 0);
    step(&l);
    for (uint32_t i = 0; i < 3; i++) move(&l, i);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 177);
    put_some(&l, 380, 16);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 560);
    for (uint32_t i = 0; i < 10; i++) move(&l, 180 + i);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 560);
    while (l.n > 100) take_away(&l, 99);
    step(&l);
    if (is_free(&l)) ck_assert_uint_ge(count_resting(&l), 80);
    right(session_close(&l.s));
}
END_TEST

/* Boxes that touch many rows are in none: they move, and go, while others do and while none does, and whether
 * boxes rest from the first commit on or from that one. */
static void wide_boxes(int row, int from_the_start)
{
    const int first = from_the_start ? 900 : 1060;
    loaded l;
    open_level(&l, row, 3, SCENE_GRID);
    put_floor(&l, first, 900);
    for (int i = 0; i < 20; i++) put(&l, box_of(-99, -99, (float)i / 2, 99, 99, (float)i), i % 3 ? 0 : MSAP_STATIC);
    step(&l);
    if (is_free(&l)) ck_assert_int_eq(l.s.world->grid.is_resting, from_the_start);
    if (is_free(&l) && l.s.world->config.grid == MSAP_GRID_AUTO) ck_assert_uint_eq(l.s.world->grid.n_wide, 20);
    move(&l, 3);
    right(session_update(&l.s, l.handles[first + 1], &l.bounds[first + 3])); /* wide, elsewhere */
    right(session_update(&l.s, l.handles[first + 4], &l.bounds[5]));         /* not wide any more */
    right(session_update(&l.s, l.handles[first + 5], &l.bounds[first + 19])); /* a pair of wide ones parts */
    right(session_update(&l.s, l.handles[first + 7], &l.bounds[9]));
    take_away(&l, (uint32_t)first + 10);
    take_away(&l, (uint32_t)first + 11);
    take_away(&l, 7);
    step(&l);
    if (is_free(&l)) ck_assert_uint_gt(count_resting(&l), 890);
    for (uint32_t i = (uint32_t)first; i < l.n; i++)
        right(session_update(&l.s, l.handles[i], &l.bounds[i - (uint32_t)first + 10]));
    step(&l);
    right(session_close(&l.s));
}

START_TEST(wide_boxes_do_not_rest)
{
    wide_boxes(_i, 0);
    wide_boxes(_i, 1);
}
END_TEST

/* A box that rests and has very many neighbours, which leave it together. */
START_TEST(a_crowd_leaves_a_box_that_rests)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    for (int i = 0; i < 900; i++) {
        float x = (float)(3 * (i % 30)), y = (float)(3 * (i / 30));
        put(&l, box_of(x, y, 0, x + 1, y + 1, 1), MSAP_STATIC);
    }
    put(&l, box_of(0, 0, 5, 5, 5, 6), MSAP_STATIC);
    for (int i = 0; i < 100; i++) put(&l, cube(0.25f, 5.5f), 0);
    step(&l);
    if (is_free(&l)) ck_assert_uint_eq(count_resting(&l), 901);
    for (uint32_t i = 901; i < l.n; i++) {
        float x = (float)(3 * (i - 900));
        box away = box_of(x, 60, 50, x + 1, 61, 51);
        if (i % 10) right(session_update(&l.s, l.handles[i], &away));
    }
    step(&l);
    right(session_close(&l.s));
}
END_TEST

/* Many of a crowd around a box that moves go in one commit, while others rest. */
START_TEST(many_of_a_crowd_go)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    put_floor(&l, 900, 900);
    put(&l, box_of(0, 0, 5, 5, 5, 6), 0);
    for (int i = 0; i < 100; i++) put(&l, cube(1, 5.5f), 0);
    step(&l);
    for (uint32_t i = 900; i < l.n; i++) {
        l.bounds[i].max[2] += 0.0625f;
        right(session_update(&l.s, l.handles[i], &l.bounds[i]));
    }
    step(&l);
    for (int i = 0; i < 60; i++) take_away(&l, l.n - 1);
    step(&l);
    right(session_close(&l.s));
}
END_TEST

static size_t count_noted(const loaded *l) { return l->s.world->grid.partners.slots; }

/* Boxes from one on move, one in each commit, until partners are noted. */
static void move_until_noted(loaded *l, uint32_t first, uint32_t last)
{
    for (uint32_t i = first; i < last && is_free(l) && count_noted(l) == 0; i++) {
        move(l, i);
        step(l);
    }
    if (is_free(l)) ck_assert_uint_ge(count_noted(l), l->n);
}

/* Where very many boxes touch many rows, nothing is pruned, and boxes rest no more when that was tried: so they have
 * no partners. */
START_TEST(giants_where_boxes_rest)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    put_floor(&l, 900, 900);
    step(&l);
    move_until_noted(&l, 0, 60);
    for (int i = 0; i < 70; i++) {
        put(&l, box_of(-99, -99, (float)i, 99, 99, (float)i + 1), 0);
        if (i % 10 == 9) step(&l);
    }
    put_some(&l, 40, 0);
    for (int frame = 0; frame < 12; frame++) {
        for (uint32_t i = 900; i < l.n; i++) {
            float z = (float)random_below(&l.s.random, 70);
            box bounds = i < 970 ? box_of(-99, -99, z, 99, 99, z + 1) : random_box(&l.s.random, SCENE_GRID);
            right(session_update(&l.s, l.handles[i], &bounds));
        }
        move(&l, random_below(&l.s.random, 900));
        step(&l);
    }
    right(session_close(&l.s));
}
END_TEST

/* Two boxes that rested and were a pair: both part, both go, one goes and one moves, all in one commit; before
 * partners are noted, and after it. */
START_TEST(two_that_rested_together)
{
    for (int how = 0; how < 18; how++) {
        loaded l;
        open_level(&l, _i, 3, SCENE_GRID);
        box far_off = box_of(500, 500, 500, 501, 501, 501);
        for (int i = 0; i < 300; i++) {
            float x = (float)(2 * i);
            put(&l, box_of(x, 0, 0, x + 1, 1, 1), i < 2 ? 0 : MSAP_STATIC);
        }
        l.bounds[1] = box_of(0.5f, 0.5f, 0.5f, 0.75f, 0.75f, 0.75f);
        right(session_update(&l.s, l.handles[1], &l.bounds[1]));
        for (int i = 0; i < 120; i++) put(&l, box_of((float)(2 * i), 8, 8, (float)(2 * i) + 1, 9, 9), 0);
        step(&l);
        if (is_free(&l)) ck_assert(l.s.world->grid.is_jumping);
        move(&l, 100);
        if (how >= 9) step(&l);
        if (how >= 9) move_until_noted(&l, 300, 400);
        for (uint32_t i = 0, does = (uint32_t)how; i < 2; i++, does /= 3) {
            if (does % 3 == 1) right(session_update(&l.s, l.handles[i], &far_off));
            if (does % 3 == 2) right(session_remove(&l.s, l.handles[i]));
        }
        step(&l);
        if (is_free(&l)) ck_assert_uint_gt(count_resting(&l), how < 9 ? 400 : 300);
        right(session_close(&l.s));
    }
}
END_TEST

/* Partners move, go, and come back to where others are; when all have jumped, nobody has any. */
START_TEST(partners_are_noted)
{
    loaded l;
    open_level(&l, _i, 3, SCENE_GRID);
    put_some(&l, 600, 12);
    step(&l);
    move_until_noted(&l, 0, 200);
    for (int frame = 0; frame < 12; frame++) {
        for (int i = 0; i < 6; i++) move(&l, random_below(&l.s.random, l.n));
        for (int i = 0; i < 3; i++) take_away(&l, random_below(&l.s.random, l.n));
        put_some(&l, 3, 8);
        step(&l);
    }
    if (is_free(&l)) ck_assert_uint_gt(count_resting(&l), 400);
    if (is_free(&l)) ck_assert_uint_gt(count_noted(&l), 0);
    for (int frame = 0; frame < 3; frame++) {
        for (uint32_t i = 0; i < l.n; i++) move(&l, i);
        step(&l);
    }
    if (is_free(&l)) ck_assert_uint_eq(count_noted(&l), 0);
    right(session_close(&l.s));
}
END_TEST

/* Many of those that rest go at once, with some that do not. */
static void many_that_go(int row, uint32_t not_static)
{
    loaded l;
    open_level(&l, row, 3, SCENE_GRID);
    put_some(&l, MOST - not_static, 16);
    put_some(&l, not_static, 0);
    step(&l);
    for (uint32_t i = 0; i < 10; i++) move(&l, i);
    step(&l);
    if (is_free(&l)) ck_assert_uint_gt(count_resting(&l), MOST - 80);
    for (uint32_t i = 0; i < 200; i++) take_away(&l, 5 * i % l.n);
    move(&l, 50);
    step(&l);
    right(session_close(&l.s));
}

START_TEST(many_go)
{
    many_that_go(_i, 60);
    many_that_go(_i, 400);
}
END_TEST

/* The validator sees what is wrong with rows. */
START_TEST(broken_rows)
{
    loaded l;
    open_level(&l, DEFAULT, 3, SCENE_SPREAD);
    put_some(&l, 200, 16);
    step(&l);
    struct grid *g = &l.s.world->grid;
    size_t last = (size_t)g->rows.count[0] * g->rows.count[1] - 1;
    for (int k = 0; k < 3; k++) {
        g->row_set.min[k][7]--;
        is_broken(l.s.world, "a row has other bounds than a box in it");
        g->row_set.min[k][7]++;
        if (k == 0) continue;
        g->row_set.max[k][7]--;
        is_broken(l.s.world, "a row has other bounds than a box in it");
        g->row_set.max[k][7]++;
    }
    uint32_t end = g->row_set.end[last];
    g->row_set.end[last] = last > 0 ? g->row_set.end[last - 1] : 0;
    is_broken(l.s.world, "a box is not in all rows that it touches");
    g->row_set.end[last] = end;
    g->row_set.reach[0]++;
    is_broken(l.s.world, "a row reaches elsewhere than is told");
    g->row_set.reach[0]--;
    right(session_compare(&l.s));
    right(session_close(&l.s));
}
END_TEST

/* And with partners. */
START_TEST(broken_partners)
{
    loaded l;
    open_level(&l, DEFAULT, 3, SCENE_GRID);
    put_some(&l, 300, 10);
    step(&l);
    struct grid *g = &l.s.world->grid;
    struct partners *p = &g->partners;
    p->slots = 1;
    is_broken(l.s.world, "partners are noted while no box rests as it is");
    g->is_resting = g->in_skins = 1;
    is_broken(l.s.world, "partners are noted while no box rests as it is");
    g->is_resting = g->in_skins = 0;
    p->slots = 0;
    move_until_noted(&l, 0, 100);
    int n = 0;
    for (uint32_t slot = 0; slot < 300; slot++) { /* each pair is told by both boxes */
        uint32_t i = slot > 0 ? p->end[slot - 1] : 0;
        if (p->end[slot] != i + 1 || !rests(g, &l.s.world->boxes.at[slot])) continue;
        uint32_t other = p->other[i];
        if (!rests(g, &l.s.world->boxes.at[other])) continue;
        p->other[i] = slot;
        is_broken(l.s.world, "a pair that rests is not noted");
        p->other[i] = other;
        n++;
    }
    ck_assert_int_gt(n, 9);
    right(session_compare(&l.s));
    right(session_close(&l.s));
}
END_TEST

/* ---------------------------------------------------------- without memory */

/* Plays a scene with the n-th allocation failing, for n = 1, 2, ... until it needs no n-th: the commit fails or
 * not, and nothing is lost. */
static void fail_each(int row, void (*play)(loaded *l, size_t n))
{
    size_t failures = 1;
    for (size_t n = 1; failures > 0; n++) {
        loaded l;
        open_level(&l, row, 3, SCENE_GRID);
        play(&l, n);
        failures = l.s.memory.failures;
        right(session_close(&l.s));
    }
}

/* Three commits in which some move and one of the first so many goes. */
static void play_on(loaded *l, uint32_t goes)
{
    for (int frame = 0; frame < 3; frame++) {
        for (uint32_t i = 0; i < 5; i++) move(l, random_below(&l->s.random, l->n));
        take_away(l, random_below(&l->s.random, goes));
        step(l);
    }
}

static void rest_from_the_start(loaded *l, size_t n)
{
    put_some(l, 230, 16);
    put_some(l, 20, 0);
    l->s.memory.fail_at = l->s.memory.calls + n;
    step(l);
    play_on(l, 200);
}

/* Here all from the n-th on. */
static void rest_later(loaded *l, size_t n)
{
    put_some(l, 300, 10);
    step(l);
    l->s.memory.fail_from = l->s.memory.calls + n;
    play_on(l, 297);
}

static void many_rest_and_go(loaded *l, size_t n)
{
    put_some(l, 400, 10);
    step(l);
    move(l, 0);
    step(l);
    l->s.memory.fail_at = l->s.memory.calls + n;
    for (uint32_t i = 0; i < 80; i++) take_away(l, 4 * i % l->n);
    step(l);
}

/* When it was loaded rows were asked for those that are not static; in the next commit partners are noted, if there
 * is memory for it. */
static void partners_are_to_be_noted(loaded *l, size_t n)
{
    put_some(l, 300, 15);
    step(l);
    if (is_free(l)) ck_assert_uint_eq(count_noted(l), 0);
    l->s.memory.fail_at = l->s.memory.calls + n;
    for (uint32_t i = 0; i < 10; i++) move(l, i);
    step(l);
    if (is_free(l) && l->s.memory.failures == 0) ck_assert_uint_gt(count_noted(l), 0);
}

static void wide_boxes_enter_cells(loaded *l, size_t n)
{
    put_floor(l, 900, 600);
    for (int i = 0; i < 4; i++) put(l, box_of(-99, -99, (float)i, 99, 99, (float)i + 1), 0);
    step(l);
    l->s.memory.fail_at = l->s.memory.calls + n;
    move(l, 7);
    step(l);
}

static void only_wide_boxes_have_pairs(loaded *l, size_t n)
{
    for (int i = 0; i < 300; i++) {
        float x = (float)(2 * (i % 30)), y = (float)(i / 30 * 2);
        put(l, box_of(x, y, 0, x + 1, y + 1, 1), 0);
    }
    for (int i = 0; i < 4; i++) put(l, box_of(-99, -99, 0, 99, 99, 1), 0);
    l->s.memory.fail_at = l->s.memory.calls + n;
    step(l);
}

START_TEST(without_memory)
{
    fail_each(_i, rest_from_the_start);
    fail_each(_i, rest_later);
    fail_each(_i, many_rest_and_go);
    fail_each(_i, partners_are_to_be_noted);
    fail_each(_i, wide_boxes_enter_cells);
    fail_each(_i, only_wide_boxes_have_pairs);
}
END_TEST

/* So many boxes that they are fetched ahead: every other of the movers hits one that rests. */
START_TEST(very_many_boxes)
{
    enum { SIDE = 260, BOXES = SIDE * SIDE, MOVERS = 40 };
    static box bounds[BOXES];
    static uint32_t flags[BOXES];
    static msap_handle handles[BOXES];
    msap_world *world = new_world(2, _i);
    msap_boxes boxes = boxes_in_row(bounds);
    const setup *s = &setups[_i];
    for (int i = 0; i < BOXES; i++) {
        float x = (float)(3 * (i % SIDE)), y = (float)(3 * (i / SIDE));
        bounds[i] = box_of(x, y, 0, x + 1, y + 1, 0);
        flags[i] = i < MOVERS ? 0 : MSAP_STATIC;
    }
    if (s->grid == MSAP_GRID_AUTO && s->strategy == MSAP_STRATEGY_AUTO) {
        ok(msap_add_many(world, BOXES, &boxes, flags, NULL, handles));
        commit(world, 0, 0, 0);
        for (int frame = 0; frame < 6; frame++) {
            for (int i = 0; i < MOVERS; i++) {
                float x = (float)(3 * (5 * i + frame)), y = (float)(300 + 3 * frame) + (i % 2 ? 0.5f : 1.5f);
                update(world, handles[i], box_of(x + 1.25f * (float)(i % 2 == 0), y, 0, x + 1.75f, y + 0.25f, 0));
            }
            commit(world, frame ? MOVERS / 2 : 0, MOVERS / 2, MOVERS / 2);
        }
        for (int frame = 0; frame < 2; frame++) { /* many that rested move; so many slots have no partners */
            for (int i = 0; i < 8 * MOVERS; i++) {
                box moved = bounds[BOXES - 1 - i];
                moved.max[0] += 0.25f * (float)(1 + frame);
                update(world, handles[BOXES - 1 - i], moved);
            }
            commit(world, 0, 0, MOVERS / 2);
        }
        ck_assert_uint_eq(world->grid.partners.slots, 0);
    }
    ok(msap_destroy(world));
}
END_TEST

/* When those that rested no more have gone far away or come back, other cells suit the boxes. However often that
 * is, there are not more and more of them. */
START_TEST(cells_follow_and_stay_few)
{
    enum { ALL = 300, STATIC = 288, COMMITS = 20, ROUNDS = 20 };
    loaded l;
    uint64_t chosen = 0, rested = 0;
    open_level(&l, DEFAULT, 3, SCENE_SPREAD);
    put_floor(&l, ALL, STATIC);
    step(&l);
    for (int frame = 0; frame < ROUNDS * COMMITS; frame++) {
        const struct layout *now = &l.s.world->grid.layout[l.s.world->grid.current];
        uint32_t chosen_at = now->chosen_at;
        for (int i = STATIC; i < ALL; i++) { /* a few in a commit go or come back */
            float far = (frame + i % 15) / COMMITS % 2 ? 4096 : 0, jitter = (float)(frame % 2) / 64;
            float x = (float)(i % 30) + far + jitter, y = (float)(i / 30) + far;
            l.bounds[i] = box_of(x, y, 0, x + 1, y + 1, 1);
            right(session_update(&l.s, l.handles[i], &l.bounds[i]));
        }
        step(&l);
        now = &l.s.world->grid.layout[l.s.world->grid.current];
        chosen += now->chosen_at != chosen_at;
        rested += (uint64_t)l.s.world->grid.is_resting;
        if (now->n_cells > 2 * ALL) ck_abort_msg("%zu cells", now->n_cells);
    }
    ck_assert_uint_ge(rested, ROUNDS * COMMITS / 2);
    ck_assert_uint_ge(chosen, ROUNDS / 2);
    right(session_close(&l.s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("resting");
    tcase_add_loop_test(tests, a_box_rests_until_it_moves, 0, SETUPS);
    tcase_add_loop_test(tests, a_level_is_loaded_and_unloaded, 0, SETUPS);
    tcase_add_loop_test(tests, pairs_of_many_that_come_are_compared, 0, SETUPS);
    tcase_add_loop_test(tests, all_pairs_of_boxes_that_rest, 0, SETUPS);
    tcase_add_loop_test(tests, more_is_loaded, 0, SETUPS);
    tcase_add_loop_test(tests, wide_boxes_do_not_rest, 0, SETUPS);
    tcase_add_loop_test(tests, a_crowd_leaves_a_box_that_rests, 0, SETUPS);
    tcase_add_loop_test(tests, many_of_a_crowd_go, 0, SETUPS);
    tcase_add_loop_test(tests, giants_where_boxes_rest, 0, SETUPS);
    tcase_add_loop_test(tests, two_that_rested_together, 0, SETUPS);
    tcase_add_loop_test(tests, partners_are_noted, 0, SETUPS);
    tcase_add_loop_test(tests, many_go, 0, SETUPS);
    tcase_add_test(tests, broken_rows);
    tcase_add_test(tests, broken_partners);
    tcase_add_test(tests, cells_follow_and_stay_few);
    tcase_add_loop_test(tests, without_memory, 0, SETUPS);
    tcase_add_loop_test(tests, very_many_boxes, 0, SETUPS);
    return run_case(tests, "resting");
}
