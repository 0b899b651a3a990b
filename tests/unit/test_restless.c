/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: where few boxes jump among many that stay, and these alone are pruned (restless.c), all have their pairs,
 * whoever joins them, stands still, comes or goes, until all are pruned again. It looks behind the interface to
 * see which way was taken.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { MOST = 3100, CALM = 480, WILD = 30 };

/* A session, the handles of its boxes and how many of these there are. The first ones are wild. */
typedef struct field {
    session s;
    msap_handle handles[MOST];
    box bounds[MOST];
    uint32_t n;
} field;

static void put(field *f, box bounds, uint32_t flags)
{
    f->bounds[f->n] = bounds;
    right(session_add(&f->s, &bounds, flags, &f->handles[f->n++]));
}

static void put_some(field *f, uint32_t n, uint32_t flags)
{
    for (uint32_t i = 0; i < n; i++) put(f, random_box(&f->s.random, f->s.scene), flags);
}

static void set(field *f, uint32_t i, box bounds)
{
    f->bounds[i] = bounds;
    right(session_update(&f->s, f->handles[i], &bounds));
}

static void jump(field *f, uint32_t first, uint32_t last)
{
    for (uint32_t i = first; i < last; i++) set(f, i, random_box(&f->s.random, f->s.scene));
}

/* The last box takes its place. */
static void take_away(field *f, uint32_t i)
{
    right(session_remove(&f->s, f->handles[i]));
    f->handles[i] = f->handles[--f->n];
    f->bounds[i] = f->bounds[f->n];
}

static void step(field *f)
{
    right(session_commit(&f->s));
    right(session_compare(&f->s));
    ok(msap_validate(f->s.world, NULL));
}

static struct grid *grid_of(field *f) { return &f->s.world->grid; }

static size_t count_restless(field *f) { return grid_of(f)->restless.n; }

/* Whether the set-up chooses its ways itself, in a grid. */
static int is_free(const field *f)
{
    const msap_config *c = &f->s.world->config;
    return c->grid != MSAP_GRID_NONE && c->strategy == MSAP_STRATEGY_AUTO;
}

/* A field. The first ones are not static, of the others every other one is. So many boxes touch many rows, if any; then
 * the others are a floor. */
static void put_field(field *f, int row, uint32_t dims, scene_kind scene, int wide)
{
    msap_config config = config_of(dims, row);
    f->n = 0;
    right(session_open(&f->s, &config, 70 + (uint64_t)row, scene));
    put_some(f, WILD, 0);
    for (int i = 0; i < CALM; i++) {
        float x = 1.25f * (float)(i % 24), y = 1.25f * (float)(i / 24);
        box floor = box_of(x, y, 0, x + 1, y + 1, 1);
        put(f, wide > 0 ? floor : random_box(&f->s.random, scene), i % 2 ? MSAP_STATIC : 0);
    }
    for (int i = 0; i < wide; i++)
        put(f, box_of(-99, -99, (float)(3 * i), 99, 99, (float)(3 * i + 2)), i % 2 ? MSAP_STATIC : 0);
    step(f);
}

/* One in which the first ones jump until they are restless. */
static void open_field_with(field *f, int row, uint32_t dims, scene_kind scene, int wide)
{
    put_field(f, row, dims, scene, wide);
    for (int frame = 0; frame < 20 && (frame < 2 || (is_free(f) && count_restless(f) == 0)); frame++) {
        jump(f, 0, WILD);
        step(f);
    }
    if (is_free(f) && wide == 0) ck_assert_uint_ge(count_restless(f), WILD);
}

static void open_field(field *f, int row, uint32_t dims, scene_kind scene)
{
    open_field_with(f, row, dims, scene, 0);
}

/* Some jump, and only they are restless. */
START_TEST(few_jump)
{
    field f;
    open_field(&f, _i, 3, SCENE_SPREAD);
    for (int frame = 0; frame < 6; frame++) {
        ck_assert_uint_eq(grid_of(&f)->restless.newcomers, 0); /* of the first ones neither */
        jump(&f, 0, WILD);
        step(&f);
        if (is_free(&f)) ck_assert_uint_eq(count_restless(&f), WILD);
        if (is_free(&f)) ck_assert_uint_eq(stats_of(f.s.world).moves, WILD);
    }
    right(session_close(&f.s));
}
END_TEST

START_TEST(few_jump_in_two_dimensions)
{
    field f;
    open_field(&f, _i, 2, SCENE_GRID);
    for (int frame = 0; frame < 4; frame++) {
        jump(&f, 0, WILD);
        set(&f, 0, f.bounds[CALM - (uint32_t)frame]); /* they touch many that are static, too */
        step(&f);
    }
    right(session_close(&f.s));
}
END_TEST

/* Those that are calm move once, in some commits several of them, come and go, and so do restless ones: into slots
 * that others had. Static ones are moved too. */
START_TEST(others_join_them_and_leave)
{
    field f;
    open_field(&f, _i, 3, SCENE_GRID);
    for (int frame = 0; frame < 16; frame++) {
        uint32_t calm = WILD + random_below(&f.s.random, f.n - WILD);
        jump(&f, 0, WILD);
        jump(&f, calm, calm + 1);
        if (frame % 4 == 0) take_away(&f, WILD + random_below(&f.s.random, f.n - WILD));
        if (frame % 4 == 1) take_away(&f, random_below(&f.s.random, WILD));
        if (frame % 4 == 2) put_some(&f, 2, frame % 8 == 2 ? MSAP_STATIC : 0);
        step(&f);
    }
    right(session_close(&f.s));
}
END_TEST

/* Those that stand still stay restless, until they have cost as much as to calm them; then only those that jump are.
 * No commit prunes all. */
START_TEST(most_of_them_calm_down)
{
    field f;
    int calmed = 0, pruned = 0;
    open_field(&f, _i, 3, SCENE_SPREAD);
    for (int frame = 0; frame < 30; frame++) {
        size_t before = count_restless(&f);
        jump(&f, 0, WILD / 2);
        step(&f);
        calmed += count_restless(&f) < before;
        pruned += count_restless(&f) == 0;
        if (is_free(&f) && count_restless(&f) < before) ck_assert_uint_eq(count_restless(&f), WILD / 2);
    }
    if (is_free(&f)) ck_assert_int_eq(calmed, 1);
    if (is_free(&f)) ck_assert_int_eq(pruned, 0);
    right(session_close(&f.s));
}
END_TEST

/* Those that stand still have cost so much that they are calmed in the next commit. */
static void calm_soon(field *f) { grid_of(f)->restless.idle = count_restless(f) > 0 ? UINT32_MAX : 0; }

/* Those that stand still are calmed in every commit, while boxes of all kinds jump, stand still, come and go, into slots
 * that others had; some are wide, and stay restless, until they are so no more. */
START_TEST(they_calm_in_every_commit)
{
    enum { FRAMES = 24, WIDE = 4 };
    field f;
    size_t calmed = 0;
    open_field_with(&f, _i, 3, SCENE_GRID, WIDE);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        size_t before = count_restless(&f), n;
        uint32_t first = random_below(&f.s.random, f.n - WILD);
        jump(&f, first, first + random_below(&f.s.random, WILD));
        jump(&f, 0, 1);
        if (frame % 3 == 0) take_away(&f, random_below(&f.s.random, f.n));
        if (frame % 3 == 1) put_some(&f, 2, frame % 2 ? MSAP_STATIC : 0);
        if (frame == FRAMES / 2) jump(&f, WILD + CALM / 2, WILD + CALM / 2 + 2);
        if (frame % 8 == 4) set(&f, 1, box_of(-99, -99, 0.5f, 99, 99, 8));
        if (frame % 8 == 7) jump(&f, 1, 2);
        calm_soon(&f);
        n = f.s.world->boxes.n_changed;
        step(&f);
        if (before > 0 && count_restless(&f) > 0) ck_assert_uint_le(count_restless(&f), n + WIDE + 1);
        calmed += before > 0 && count_restless(&f) > 0;
    }
    if (_i == DEFAULT) ck_assert_uint_ge(calmed, FRAMES / 2);
    right(session_close(&f.s));
}
END_TEST

/* They are not where rows are old: then all are pruned, in new ones. */
START_TEST(rows_grow_old)
{
    field f;
    open_field(&f, _i, 3, SCENE_SPREAD);
    jump(&f, 0, 1);
    step(&f);
    calm_soon(&f);
    grid_of(&f)->rows.chosen_at -= 300;
    jump(&f, 0, 1);
    step(&f);
    if (is_free(&f)) ck_assert_uint_eq(count_restless(&f), 0);
    if (is_free(&f)) ck_assert_uint_eq(grid_of(&f)->rows.chosen_at, grid_of(&f)->commit);
    right(session_close(&f.s));
}
END_TEST

/* When others jump in each commit, those before them are calmed now and then, or, where they are many, all are pruned
 * in most. */
START_TEST(others_each_time)
{
    field f;
    int calmed = 0, several = 0;
    open_field(&f, _i, 3, SCENE_SPREAD);
    for (uint32_t frame = 0; frame < 12; frame++) {
        size_t before = count_restless(&f);
        jump(&f, frame * WILD, (frame + 1) * WILD);
        step(&f);
        if (before > 0 && count_restless(&f) > 0)
            ck_assert_uint_eq(grid_of(&f)->restless.newcomers, frame > 0 ? WILD : 0);
        calmed += before > count_restless(&f);
    }
    for (uint32_t frame = 0; frame < 12; frame++) {
        uint32_t first = frame % 3 * 5 * WILD;
        jump(&f, first, first + 5 * WILD);
        step(&f);
        several += count_restless(&f) > 0;
    }
    if (is_free(&f)) ck_assert_int_ge(calmed, 2);
    if (is_free(&f)) ck_assert_int_lt(several, 6);
    right(session_close(&f.s));
}
END_TEST

/* Where others jump in each commit, but few of very many, these are put elsewhere one by one: to prune them, and to
 * calm those before, would cost more. */
START_TEST(few_others_of_many_each_time)
{
    enum { MORE = 2500, FEW = 16, FRAMES = 40 };
    static field f;
    int resting = 0;
    put_field(&f, DEFAULT, 3, SCENE_SPREAD, 0);
    for (int i = 0; i < MORE; i++) {
        float x = 2 * (float)(i % 50), y = 2 * (float)(i / 50);
        put(&f, box_of(x, y, 50, x + 1, y + 1, 51), 0);
    }
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        jump(&f, frame * FEW, (frame + 1) * FEW);
        right(session_commit(&f.s));
        resting += grid_of(&f)->is_resting;
    }
    step(&f);
    ck_assert_int_ge(resting, FRAMES - 8);
    right(session_close(&f.s));
}
END_TEST

/* Boxes are awake for three commits each, one after the other, and in the others calm: that others will wake is known,
 * so that boxes do not rest while each that wakes would have to be put elsewhere. */
START_TEST(a_wave_passes)
{
    enum { WAKE = 16, FRAMES = 60 };
    field f;
    int resting = 0;
    put_field(&f, _i, 3, SCENE_SPREAD, 0);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        for (uint32_t i = frame * WAKE; i < (frame + 3) * WAKE; i++) {
            box b = f.bounds[i % f.n];
            float step = (float)random_below(&f.s.random, 9) - 4;
            b.min[frame % 3] += step;
            b.max[frame % 3] += step;
            set(&f, i % f.n, b);
        }
        step(&f);
        resting += grid_of(&f)->is_resting && !grid_of(&f)->in_skins;
    }
    if (is_free(&f)) ck_assert_int_le(resting, 5);
    right(session_close(&f.s));
}
END_TEST

/* All set out at once; or those that jumped go straight on, and the others rest. */
START_TEST(it_passes)
{
    field f;
    open_field(&f, _i, 3, SCENE_SPREAD);
    jump(&f, 0, f.n);
    step(&f);
    ck_assert_uint_eq(count_restless(&f), 0);
    for (int frame = 0; frame < 4; frame++) {
        jump(&f, 0, WILD);
        step(&f);
    }
    for (int frame = 0; frame < 60; frame++) {
        for (uint32_t i = 0; i < WILD; i++) {
            box b = f.bounds[i];
            b.min[i % 3] += 0.0078125f;
            b.max[i % 3] += 0.0078125f;
            set(&f, i, b);
        }
        step(&f);
    }
    if (_i == DEFAULT) ck_assert(grid_of(&f)->is_tracking);
    if (_i == DEFAULT) ck_assert_uint_eq(count_restless(&f), 0);
    right(session_close(&f.s));
}
END_TEST

/* Boxes that are in no row are restless from the start. One of them is removed, and others take its slot; another
 * comes. */
START_TEST(wide_ones)
{
    enum { WIDE = 6 };
    field f;
    open_field_with(&f, _i, 3, SCENE_GRID, WIDE);
    if (_i == DEFAULT) ck_assert_uint_eq(count_restless(&f), WILD + WIDE);
    grid_of(&f)->restless.idle = 0;
    for (int frame = 0; frame < 4; frame++) {
        jump(&f, 0, WILD);
        step(&f);
    }
    ck_assert_uint_eq(grid_of(&f)->restless.idle, 0); /* it is no matter that they stand still */
    for (int frame = 0; frame < 8; frame++) {
        jump(&f, 0, WILD);
        for (uint32_t i = 0; i < 3; i++) { /* some touch several rows, but are not wide */
            float x = 2.0f * (float)frame, y = (float)frame, size = 5.0f + 4.0f * (float)i;
            set(&f, i, box_of(x, y, 0.5f, x + size, y + size, 1));
        }
        if (frame == 2) take_away(&f, f.n - 2);
        if (frame == 3) put_some(&f, 1, 0);
        if (frame == 4) put(&f, box_of(-99, -99, 0.5f, 99, 99, 8), 0); /* it meets those that are calm */
        if (frame == 5) set(&f, WILD + CALM + 1, box_of(-99, -99, 0.25f, 99, 99, 8)); /* and so does a static one */
        step(&f);
    }
    right(session_close(&f.s));
}
END_TEST

/* While a few are pruned, more boxes than a buffer has room for become wide in one commit, and all meet. */
START_TEST(many_become_wide)
{
    enum { MORE = 2500, WIDE = MOST_BUFFERED + 2 * BUFFER_SLACK };
    static field f;
    put_field(&f, DEFAULT, 3, SCENE_SPREAD, 0);
    put_some(&f, MORE, 0);
    for (int frame = 0; frame < 40 && count_restless(&f) == 0; frame++) {
        jump(&f, 0, 4 * WILD);
        right(session_commit(&f.s));
    }
    jump(&f, 0, 4 * WILD);
    right(session_commit(&f.s));
    ck_assert_uint_gt(count_restless(&f), 0);
    for (uint32_t i = 0; i < WIDE; i++) set(&f, WILD + i, box_of(-1e30f, -1e30f, -1e30f, 1e30f, 1e30f, -1e29f));
    step(&f);
    ck_assert_uint_ge(count_restless(&f), WIDE);
    right(session_close(&f.s));
}
END_TEST

/* The world is trimmed, or all boxes are given again where they are, or most go, between two commits. */
START_TEST(what_else_may_come_between)
{
    for (int how = 0; how < 4; how++) {
        field f;
        open_field(&f, _i, 3, SCENE_SPREAD);
        jump(&f, 0, WILD);
        if (how == 3) {
            put_some(&f, 6, 0); /* restless ones in the last slots, which the table forgets */
            ok(msap_validate(f.s.world, NULL));
            step(&f);
        }
        if (how == 0) right(session_trim(&f.s));
        for (uint32_t i = 0; how == 1 && i < f.n; i++) set(&f, i, f.bounds[i]);
        if (how >= 2)
            while (f.n > WILD + 20) take_away(&f, how == 2 ? 0 : f.n - 1);
        ok(msap_validate(f.s.world, NULL));
        step(&f);
        if (how >= 2) right(session_trim(&f.s));
        jump(&f, 0, WILD / 2);
        step(&f);
        right(session_close(&f.s));
    }
}
END_TEST

/* Boxes in the last slots go, which the trimmed table forgets; so these are not watched any more. */
START_TEST(watched_ones_are_forgotten)
{
    field f;
    put_field(&f, _i, 3, SCENE_SPREAD, 0);
    put_some(&f, WILD, 0);
    step(&f);
    for (int i = 0; i < WILD; i++) take_away(&f, f.n - 1);
    step(&f);
    if (is_free(&f)) ck_assert_uint_gt(grid_of(&f)->watch.n, 0);
    right(session_trim(&f.s));
    ok(msap_validate(f.s.world, NULL));
    for (int frame = 0; frame < 3; frame++) {
        jump(&f, 0, f.n);
        step(&f);
    }
    right(session_close(&f.s));
}
END_TEST

/* ---------------------------------------------------------- without memory */

/* Gives back what the world has worked in. */
static void forget_room(field *f)
{
    struct memory *m = &f->s.world->memory;
    struct worker *w = &f->s.world->crew.worker[0];
    msap_memory_resize(m, &w->found, &w->room_found, 0, 0, sizeof *w->found);
    msap_keys_free(&w->settler.fresh, m);
    msap_scratch_free(&f->s.world->scratch, m);
    msap_renewal_free(&grid_of(f)->renewal, m);
}

/* From the commit on after which all were pruned, before the first ones are restless. */
static void play(field *f, int row, int wide, int all, size_t n)
{
    put_field(f, row, 3, wide > 0 ? SCENE_GRID : SCENE_SPREAD, wide);
    for (int frame = 0; frame < 20 && !grid_of(f)->is_jumping; frame++) {
        jump(f, 0, WILD);
        step(f);
    }
    forget_room(f);
    struct row_set *set = &grid_of(f)->row_set;
    msap_memory_resize(&f->s.world->memory, &set->reach, &set->room_reach, 0, 0, sizeof *set->reach);
    *(all ? &f->s.memory.fail_from : &f->s.memory.fail_at) = f->s.memory.calls + n;
    for (int frame = 0; frame < 4; frame++) {
        jump(f, 0, WILD + 20 * (uint32_t)frame);
        put_some(f, 4, 0);
        step(f);
    }
    forget_room(f);
    calm_soon(f);
    jump(f, 0, WILD);
    step(f);
}

/* The n-th allocation fails, for n = 1, 2, ... until it needs no n-th, or all from the n-th on: the commit fails or
 * not, and nothing is lost. */
START_TEST(without_memory)
{
    for (int how = 0; how < 4; how++) {
        size_t failures = 1;
        for (size_t n = 1; failures > 0; n++) {
            field f;
            play(&f, _i, how / 2 * 6, how % 2, n);
            failures = f.s.memory.failures;
            right(session_close(&f.s));
        }
    }
}
END_TEST

/* ------------------------------------------------------------------ checking */

/* The validator tells what is wrong. */
START_TEST(broken)
{
    const char *what;
    field f;
    open_field(&f, DEFAULT, 3, SCENE_SPREAD);
    struct restless *r = &grid_of(&f)->restless;
    struct past *calm = &f.s.world->boxes.past[slot_of(f.handles[WILD])];
    calm->before.min[0]--;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, "a calm box was elsewhere before");
    calm->before.min[0]++;
    r->n--;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, "a restless box is not listed");
    r->n++;
    grid_of(&f)->row_set.max[1][0]++;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    grid_of(&f)->row_set.max[1][0]--;
    grid_of(&f)->is_jumping = 0;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, "boxes are restless while others are tracked");
    grid_of(&f)->is_jumping = 1;
    grid_of(&f)->renewal.next = SORT_ROWS;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, "boxes are restless during a renewal");
    grid_of(&f)->renewal.next = NO_RENEWAL;
    grid_of(&f)->watch.n = 1;
    grid_of(&f)->watch.slot[0] = f.s.world->boxes.used;
    ck_assert_int_eq(msap_validate(f.s.world, &what), MSAP_ERROR_CORRUPT);
    ck_assert_str_eq(what, "a watched box is in no slot of the table");
    grid_of(&f)->watch.n = 0;
    ok(msap_validate(f.s.world, &what));
    right(session_close(&f.s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("restless");
    tcase_add_loop_test(tests, few_jump, 0, SETUPS);
    tcase_add_loop_test(tests, few_jump_in_two_dimensions, 0, SETUPS);
    tcase_add_loop_test(tests, others_join_them_and_leave, 0, SETUPS);
    tcase_add_loop_test(tests, most_of_them_calm_down, 0, SETUPS);
    tcase_add_loop_test(tests, they_calm_in_every_commit, 0, SETUPS);
    tcase_add_loop_test(tests, rows_grow_old, 0, SETUPS);
    tcase_add_loop_test(tests, others_each_time, 0, SETUPS);
    tcase_add_test(tests, few_others_of_many_each_time);
    tcase_add_loop_test(tests, a_wave_passes, 0, SETUPS);
    tcase_add_loop_test(tests, it_passes, 0, SETUPS);
    tcase_add_loop_test(tests, wide_ones, 0, SETUPS);
    tcase_add_test(tests, many_become_wide);
    tcase_add_loop_test(tests, what_else_may_come_between, 0, SETUPS);
    tcase_add_loop_test(tests, watched_ones_are_forgotten, 0, SETUPS);
    tcase_add_loop_test(tests, without_memory, 0, 1);
    tcase_add_test(tests, broken);
    return run_case(tests, "restless");
}
