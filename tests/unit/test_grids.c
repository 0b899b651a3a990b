/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: a grid is a matter of speed alone. A pair that is seen in many cells is one
 * pair and one event; boxes that share a cell's memory but not its place are none; no
 * border between cells is seen in the events. And it is a matter of speed: the cells
 * are as large as was asked, or fit the boxes, and go on fitting them when the scene
 * grows, moves or changes its density.
 */
#include <math.h>

#include "checks.h"

/* ---------------------------------------------------------------- what is seen */

/* Two boxes over all cells of a row, or of the whole grid. */
START_TEST(a_pair_in_many_cells_is_one_event)
{
    msap_world *world = new_world(3, _i);
    msap_handle a, b;
    int i;
    for (i = 0; i < 400; i++)
        add_flagged(world, box_of((float)(i % 20), (float)(i / 20), 5, (float)(i % 20) + 0.5f, (float)(i / 20) + 0.5f, 6),
                    MSAP_STATIC); /* so that there are cells */
    commit(world, 0, 0, 0);
    a = add(world, box_of(0, 0, 0, 20, 20, 1));
    b = add(world, box_of(-5, -5, 0, 25, 25, 1));
    commit(world, 0, 1, 1);
    update(world, a, box_of(0, 0, 0.5f, 20, 20, 1.5f));
    commit(world, 0, 0, 1);
    update(world, b, box_of(19, -5, 0, 19, 25, 1)); /* still one column of cells in common */
    commit(world, 0, 0, 1);
    update(world, b, box_of(20.25f, -5, 0, 25, 25, 1));
    commit(world, 1, 0, 0);
    update(world, b, box_of(20, 20, 0, 25, 25, 1)); /* a corner */
    commit(world, 0, 1, 1);
    ok(msap_remove(world, a));
    ok(msap_remove(world, b));
    commit(world, 1, 0, 0);
    ok(msap_destroy(world));
}
END_TEST

/* Two boxes travel side by side through the cells of a field, in small steps and in
 * jumps: they part nowhere. */
START_TEST(borders_between_cells_are_not_seen)
{
    static const float steps[] = {0.125f, 0.625f, 5, 40, -0.125f, -7};
    msap_world *world = new_world(3, _i);
    msap_handle a, b;
    float at = 0.25f;
    size_t s;
    int i;
    for (i = 0; i < 400; i++)
        add_flagged(world, box_of((float)(i % 20), (float)(i / 20), 5, (float)(i % 20) + 0.5f, (float)(i / 20) + 0.5f, 6),
                    MSAP_STATIC);
    a = add(world, cube(at, at + 1));
    b = add(world, box_of(at + 1, at, at, at + 1.5f, at + 1, at + 1));
    update(world, a, box_of(at, at, 0, at + 1, at + 1, 1));
    update(world, b, box_of(at + 1, at, 0, at + 1.5f, at + 1, 1));
    commit(world, 0, 1, 1);
    for (s = 0; s < COUNT(steps); s++)
        for (i = 0; i < 60; i++) {
            at += steps[s];
            update(world, a, box_of(at, at / 2, 0, at + 1, at / 2 + 1, 1));
            update(world, b, box_of(at + 1, at / 2, 0, at + 1.5f, at / 2 + 1, 1));
            commit(world, 0, 0, 1);
        }
    ok(msap_destroy(world));
}
END_TEST

/* Boxes that are a number of cells apart, for any number up to the size of the grid and
 * beyond, share memory sooner or later, and are no pairs. */
START_TEST(wrapped_cells_are_not_one_place)
{
    msap_world *world = new_world(3, _i);
    int i;
    for (i = 0; i < 600; i++) {
        float x = (float)(i % 30) * 40, y = (float)(i / 30) * 40;
        add(world, box_of(x, y, 0, x + 1, y + 1, 1));
    }
    commit(world, 0, 0, 0);
    for (i = 0; i < 600; i++) {
        float far = (float)(1 << i % 24) * 40, x = (float)(i % 30) * 40, y = (float)(i / 30) * 40;
        add(world, box_of(x + far * (float)(i % 7 + 30), y, 0, x + far * (float)(i % 7 + 30) + 1, y + 1, 1));
    }
    ok(msap_commit(world, NULL, NULL));
    {
        const msap_pair *pairs;
        size_t count;
        ok(msap_pairs(world, &pairs, &count));
        while (count--)
            ck_assert_uint_ge(pairs[count].a >> 32, 600); /* the second ones may meet, out there */
    }
    ok(msap_destroy(world));
}
END_TEST

/* ------------------------------------------------------------- cells as asked */

/* A row of 1000 boxes of size 1 from 0 to 10000. */
static uint64_t cells_of_a_row(float cell_size)
{
    msap_config config = config_of(3, DEFAULT);
    msap_world_stats stats;
    msap_world *world;
    int i;
    config.cell_size = cell_size;
    config.margin = 0;
    config.strategy = MSAP_STRATEGY_MERGE; /* by AUTO all of them would rest in rows */
    ok(msap_create(&config, &world));
    for (i = 0; i < 1000; i++)
        add(world, bar((float)(10 * i), (float)(10 * i + 1)));
    commit(world, 0, 0, 0);
    stats = stats_of(world);
    ok(msap_destroy(world));
    return stats.cells;
}

/* cell_size is the least width: there are no more cells than that, and not only one. */
START_TEST(cells_are_as_wide_as_asked)
{
    uint64_t chosen = cells_of_a_row(0);
    ck_assert(chosen >= 50 && chosen <= 1000);
    ck_assert_uint_eq(cells_of_a_row(1), chosen); /* less than would be chosen anyway */
    ck_assert(cells_of_a_row(1000) <= 11 && cells_of_a_row(1000) >= 5);
    ck_assert(cells_of_a_row(4000) <= 4 && cells_of_a_row(4000) >= 2);
    ck_assert_uint_eq(cells_of_a_row(1e6f), 1);
    ck_assert_uint_eq(cells_of_a_row(float_of(0x7F7FFFFF)), 1);
}
END_TEST

/* A fixed grid has the cells that were asked for, and boxes beyond it wrap into them, whether
 * they are put in one by one or all anew; AUTO may keep no cells for boxes that only come. */
START_TEST(a_fixed_grid_has_the_cells_that_were_asked_for)
{
    msap_config config = config_of(3, DEFAULT);
    msap_world *world;
    int i;
    config.strategy = (uint32_t)_i;
    config.grid = MSAP_GRID_FIXED;
    config.margin = 0;
    for (i = 0; i < 3; i++) {
        config.grid_cells[i] = (uint32_t)(i + 3); /* 3x4x5 */
        config.grid_max[i] = (float)(10 * (i + 3));
    }
    ok(msap_create(&config, &world));
    for (i = 0; i < 60; i++) {
        float x = (float)(10 * (i % 3) + 5), y = (float)(10 * (i / 3 % 4) + 5), z = (float)(10 * (i / 12) + 5);
        add(world, box_of(x, y, z, x, y, z));
    }
    commit(world, 0, 0, 0);
    ck_assert(stats_of(world).cells == 60 && stats_of(world).largest_cell == 1);
    for (i = 0; i < 60; i++) {
        float x = (float)(10 * (i % 3) + 4 - 30), y = (float)(10 * (i / 3 % 4) + 5 + 80), z = (float)(10 * (i / 12) + 5);
        add(world, box_of(x, y, z, x, y, z));
    }
    commit(world, 0, 0, 0);
    ck_assert(stats_of(world).cells == 60 && stats_of(world).incidences == 120 && stats_of(world).largest_cell == 2);
    ok(msap_destroy(world));
}
END_TEST

/* More cells than there can be memory for: a status code and nothing changed, or the
 * right events without them. */
START_TEST(a_grid_that_is_too_large_for_the_memory)
{
    msap_config config = config_of(3, DEFAULT);
    msap_handle a, b;
    session s;
    box unit = cube(0, 1), touching = cube(1, 2);
    int i;
    config.grid = MSAP_GRID_FIXED;
    for (i = 0; i < 3; i++) {
        config.grid_cells[i] = 4096;
        config.grid_max[i] = 1;
    }
    right(session_open(&s, &config, 1, SCENE_GRID));
    s.memory.limit = 16u << 20;
    right(session_add(&s, &unit, 0, &a));
    right(session_add(&s, &touching, 0, &b));
    for (i = 0; i < 3; i++) {
        msap_counts counts = {sizeof counts, 0, 7, 7, 7};
        msap_status status = msap_commit(s.world, NULL, &counts);
        ck_assert(status == MSAP_OK || status == MSAP_ERROR_MEMORY);
        ck_assert_uint_eq(counts.created, status != MSAP_OK ? 7 : i == 0 ? 1 : 0);
        if (status == MSAP_OK)
            reference_commit(&s.reference);
        right(session_update(&s, a, i ? &unit : &touching));
    }
    right(session_close(&s));
}
END_TEST

/* --------------------------------------------------------------- cells that fit */

enum { MOST = 12000 };
static msap_handle handles[MOST];
static box at[MOST];

/* Boxes of a size at random places in a square; few of them overlap. */
static box in_square(uint64_t *random, float side, float size)
{
    float x = side * (float)random_below(random, 1 << 16) / (1 << 16);
    float y = side * (float)random_below(random, 1 << 16) / (1 << 16);
    return box_of(x, y, 0, x + size, y + size, 1);
}

static box scaled(const box *b, float scale)
{
    return box_of(b->min[0] * scale, b->min[1] * scale, b->min[2] * scale, b->max[0] * scale, b->max[1] * scale,
                  b->max[2] * scale);
}

/* The cells fit the boxes: none holds many, few boxes are in many, and cells without
 * boxes are not many more than those with. */
static void cells_fit(const msap_world *world, const char *when)
{
    msap_world_stats s = stats_of(world);
    ck_assert_msg(s.largest_cell <= 120, "%s: %lu of %lu boxes in a cell", when, (unsigned long)s.largest_cell,
                  (unsigned long)s.boxes);
    ck_assert_msg(s.incidences <= 6 * s.boxes, "%s: %lu boxes count for %lu", when, (unsigned long)s.boxes,
                  (unsigned long)s.incidences);
    ck_assert_msg(s.cells_empty <= 8 * s.boxes, "%s: %lu empty cells for %lu boxes", when,
                  (unsigned long)s.cells_empty, (unsigned long)s.boxes);
    ck_assert_msg(s.candidates <= 40 * s.boxes, "%s: %lu candidates for %lu boxes", when,
                  (unsigned long)s.candidates, (unsigned long)s.boxes);
}

/* A field of so many boxes; the loop variable of these tests is the strategy: AUTO, or
 * SWEEP, which makes the cells anew in each commit. */
static msap_world *field(int strategy, int boxes, float side, uint64_t *random)
{
    msap_config config = config_of(3, DEFAULT);
    msap_world *world;
    int i;
    config.strategy = (uint32_t)strategy;
    ok(msap_create(&config, &world));
    for (i = 0; i < boxes; i++) {
        at[i] = in_square(random, side, 1);
        handles[i] = add(world, at[i]);
    }
    ok(msap_commit(world, NULL, NULL));
    return world;
}

/* Time goes by, in which of so many boxes one in twenty takes a small step at a time. */
static void go_on(msap_world *world, int boxes, int frames)
{
    int frame, i;
    for (frame = 0; frame < frames; frame++) {
        for (i = frame % 20; i < boxes; i += 20) {
            float step = (at[i].max[0] - at[i].min[0]) / 16;
            at[i].min[i % 2] += step;
            at[i].max[i % 2] += step;
            update(world, handles[i], at[i]);
        }
        ok(msap_commit(world, NULL, NULL));
    }
}

/* Long enough that the cells must have been looked at again. */
#define AGES 100

START_TEST(cells_fit_a_field)
{
    static const int boxes[] = {50, 400, 3000, MOST};
    size_t i;
    for (i = 0; i < COUNT(boxes); i++) {
        uint64_t random = 1;
        msap_world *world = field(_i, boxes[i], 3 * sqrtf((float)boxes[i]), &random);
        cells_fit(world, "at first");
        go_on(world, boxes[i], 20);
        cells_fit(world, "later");
        ok(msap_destroy(world));
    }
}
END_TEST

/* A hundred times as many boxes, at the same density, not all at once. */
START_TEST(a_scene_that_grows)
{
    uint64_t random = 1;
    msap_world *world = field(_i, 120, 30, &random);
    int n = 120, end;
    while (n < MOST) {
        for (end = n + 99; n < end; n++) {
            at[n] = in_square(&random, 30 * sqrtf((float)n / 120), 1);
            handles[n] = add(world, at[n]);
        }
        go_on(world, n, 3);
    }
    cells_fit(world, "when it has grown");
    ok(msap_destroy(world));
}
END_TEST

/* Nearly all boxes go; the cells do not stay for ever. */
START_TEST(a_scene_that_empties)
{
    uint64_t random = 2;
    msap_world *world = field(_i, MOST, 300, &random);
    int n = MOST, end;
    while (n > 200) {
        for (end = n - 100; n > end;)
            ok(msap_remove(world, handles[--n]));
        go_on(world, n, 1);
    }
    go_on(world, n, AGES);
    cells_fit(world, "when little is left");
    ok(msap_destroy(world));
}
END_TEST

/* All lengths become a hundred times as large, in one commit and in many, and then as
 * small again. */
START_TEST(a_scene_that_swells)
{
    static const int steps[] = {1, 50};
    size_t s;
    int i, frame, back;
    for (s = 0; s < COUNT(steps); s++) {
        uint64_t random = 3;
        msap_world *world = field(_i, 2000, 120, &random);
        for (back = 0; back < 2; back++) {
            for (frame = 1; frame <= steps[s]; frame++) {
                for (i = 0; i < 2000; i++) {
                    at[i] = scaled(&at[i], powf(back ? 0.01f : 100, 1 / (float)steps[s]));
                    update(world, handles[i], at[i]);
                }
                ok(msap_commit(world, NULL, NULL));
            }
            go_on(world, 2000, AGES);
            cells_fit(world, back ? "when it is small again" : "when it has swollen");
        }
        ok(msap_destroy(world));
    }
}
END_TEST

/* The boxes gather in a small part of the field, then spread out again. */
START_TEST(a_density_that_changes)
{
    uint64_t random = 4;
    msap_world *world = field(_i, 2000, 120, &random);
    int i, frame, back;
    for (back = 0; back < 2; back++) {
        for (frame = 0; frame < 60; frame++) {
            for (i = 0; i < 2000; i++) {
                box b = scaled(&at[i], back ? 1 / 0.97f : 0.97f);
                at[i] = box_of(b.min[0], b.min[1], 0, b.min[0] + 0.25f, b.min[1] + 0.25f, 1);
                update(world, handles[i], at[i]);
            }
            ok(msap_commit(world, NULL, NULL));
        }
        go_on(world, 2000, AGES);
        cells_fit(world, back ? "when they have spread" : "when they have gathered");
    }
    ok(msap_destroy(world));
}
END_TEST

/* Boxes that were as large as the scene, for a while, and are small now. */
START_TEST(boxes_that_shrink)
{
    uint64_t random = 5;
    msap_world *world = field(_i, 0, 0, &random);
    int i;
    for (i = 0; i < 600; i++) {
        at[i] = cube(-1000, 1000);
        handles[i] = add(world, at[i]);
    }
    ok(msap_commit(world, NULL, NULL));
    go_on(world, 600, 3);
    ck_assert_uint_eq(stats_of(world).pairs, 600 * 599 / 2);
    for (i = 0; i < 600; i++) {
        at[i] = in_square(&random, 80, 1);
        update(world, handles[i], at[i]);
    }
    ok(msap_commit(world, NULL, NULL));
    go_on(world, 600, AGES);
    cells_fit(world, "when they are small");
    ck_assert_uint_eq(stats_of(world).giants, 0);
    ok(msap_destroy(world));
}
END_TEST

/* ----------------------------------------------------------- work that is in order */

/* At how many pairs five commits look, in all: of a field in which a box in twenty is
 * large, all of them jump, or all of them walk after a first jump. */
static uint64_t touched(int strategy, int boxes, int jump)
{
    uint64_t random = 6, sum = 0;
    float side = sqrtf((float)boxes);
    msap_world *world = field(strategy, boxes, side, &random);
    int i, frame;
    for (frame = 0; frame < 6; frame++) {
        for (i = 0; i < boxes; i++) {
            if (jump || frame == 0)
                at[i] = in_square(&random, side, i % 20 ? 1 : 20);
            at[i].min[i % 2] += 0.03125f;
            at[i].max[i % 2] += 0.03125f;
            update(world, handles[i], at[i]);
        }
        ok(msap_commit(world, NULL, NULL));
        sum += frame ? stats_of(world).touched : 0;
    }
    ok(msap_destroy(world));
    return sum;
}

/* Four times as many boxes at the same density are four times the work, not sixteen. */
static void work_follows_boxes(int strategy, int jump)
{
    uint64_t few = touched(strategy, MOST / 4, jump), many = touched(strategy, MOST, jump);
    ck_assert_msg(many <= 6 * few, "%lu pairs are looked at for %d boxes, %lu for %d", (unsigned long)few, MOST / 4,
                  (unsigned long)many, MOST);
}

START_TEST(work_follows_boxes_that_jump)
{
    work_follows_boxes(_i, 1);
}
END_TEST

START_TEST(work_follows_boxes_that_walk)
{
    work_follows_boxes(_i, 0);
}
END_TEST

/* --------------------------------------------------------------- the way of a commit */

enum { CROWD = 1000, FAST = 1, FEW = 2, SOME = 4, ALL = 8, RARE = 16 };

/* How many boxes a field has, and how wide it is: so few that each has cells, or so many that they rest in
 * skins. */
static int crowd;
static uint32_t side;

static void choose_crowd(int many)
{
    crowd = many ? CROWD : 200;
    side = many ? 42 : 19;
}

/* A field whose boxes move by a step: ALL, forth and back; SOME, every eighth one, back; FEW, every
 * sixty-fourth; RARE, one in 250; FAST: far.
 * Returns how many of so many commits kept cells. */
static int commits_that_track(session *s, int which, float step, int commits)
{
    int i, frame, tracked = 0;
    uint64_t sweeps;
    for (frame = 0; frame < commits; frame++) {
        for (i = 0; i < crowd; i++) {
            float by = (frame + i) % 2 ? step : -step;
            if (!(which & ALL) && (i + frame) % (which & SOME ? 8 : which & RARE ? 250 : 64) != 0)
                continue;
            if (which & FAST)
                at[i] = in_square(&s->random, side, 1);
            at[i].min[i % 3] += by;
            at[i].max[i % 3] += by;
            right(session_update(s, handles[i], &at[i]));
        }
        sweeps = stats_of(s->world).sweeps;
        right(session_commit(s));
        tracked += stats_of(s->world).sweeps == sweeps;
    }
    right(session_compare(s));
    return tracked;
}

static void open_crowd(session *s, float margin)
{
    msap_config config = config_of(3, DEFAULT);
    int i;
    config.margin = margin;
    right(session_open(s, &config, 31, SCENE_SPREAD));
    for (i = 0; i < crowd; i++) {
        at[i] = in_square(&s->random, side, 1);
        right(session_add(s, &at[i], 0, &handles[i]));
    }
    right(session_commit(s));
}

/* Cells and lists are given up when boxes leave them faster than they pay, a few or all, and made
 * again when the boxes have calmed down. */
START_TEST(cells_are_kept_while_they_pay)
{
    session s;
    choose_crowd(_i);
    open_crowd(&s, MSAP_MARGIN_AUTO);
    ck_assert_int_eq(commits_that_track(&s, ALL, 0.0078125f, 20), 20);
    ck_assert_int_lt(commits_that_track(&s, ALL | FAST, 0, 20), 5);
    ck_assert_int_eq(commits_that_track(&s, ALL | FAST, 0, 20), 0);
    ck_assert_int_gt(commits_that_track(&s, ALL, 0.0078125f, 40), 10); /* skins are tried first */
    ck_assert_int_eq(commits_that_track(&s, ALL, 0.0078125f, 20), 20);
    ck_assert_int_lt(commits_that_track(&s, SOME | FAST, 0, 30), 25);
    ck_assert_int_eq(commits_that_track(&s, SOME | FAST, 0, 10), 0);
    ck_assert_int_gt(commits_that_track(&s, ALL, 0.0078125f, 100), 50);
    right(session_close(&s));
}
END_TEST

static void step_all(session *s, float step)
{
    int i;
    for (i = 0; i < crowd; i++) {
        at[i].min[i % 3] += step;
        at[i].max[i % 3] += step;
        right(session_update(s, handles[i], &at[i]));
    }
}

/* Boxes that are all near the ends of their margins, from where a little motion that seems to
 * last takes some of them out; and boxes that go far within their margins, but only some of them
 * leave. What the lists cost is not what motion says; they are given up, and nothing is lost. */
START_TEST(motion_can_deceive)
{
    session s;
    int round, tracked;
    choose_crowd(_i);
    for (round = 0; round < 2; round++) {
        open_crowd(&s, 1);
        ck_assert_int_ge(commits_that_track(&s, RARE, 3, 64), 60); /* they leave their first skins */
        step_all(&s, -0.97f);
        right(session_commit(&s));
        tracked = commits_that_track(&s, SOME, round ? 0.04f : 0.2f, 16);
        ck_assert_msg(_i || round > 0 || tracked < 16, "%d of 16 commits", tracked); /* or all get new skins, or a few are pruned */
        at[0].max[0] = float_of(0x7F800000); /* infinity, whose motion is none */
        ck_assert_int_gt(commits_that_track(&s, ALL, 0.0078125f, 200), 100);
        right(session_close(&s));
    }
    open_crowd(&s, 4);
    for (round = 0; round < 20; round++) {
        step_all(&s, (round % 2 ? -2.0f : 2.0f) * (_i ? 4 : 1)); /* where all rest in skins, further */
        commits_that_track(&s, SOME | FAST, 0, 1);
    }
    ck_assert_uint_eq(stats_of(s.world).cells, 0);
    right(session_close(&s));
}
END_TEST

enum { DRIFTING = 150000 }; /* more than any choice tells apart */

/* How many of the last four commits prune a world of so many boxes while they all drift; its pairs must be
 * those of box pruning. */
static uint64_t sweeps_of_a_drift(int n)
{
    static box bounds[DRIFTING];
    static msap_handle names[DRIFTING];
    msap_boxes boxes = boxes_in_row(bounds);
    float wide = 1;
    msap_index_pair *pairs;
    msap_world *world;
    uint64_t random = 5, sweeps = 0;
    size_t count;
    int i, k, frame;
    while (wide * wide * wide < 4 * (float)n)
        wide++;
    for (i = 0; i < n; i++)
        for (k = 0; k < 3; k++) {
            bounds[i].min[k] = wide * (float)random_below(&random, 65536) / 65536;
            bounds[i].max[k] = bounds[i].min[k] + 1;
        }
    ok(msap_create(NULL, &world));
    ok(msap_add_many(world, (size_t)n, &boxes, NULL, NULL, names));
    for (frame = 0; frame < 12; frame++) {
        ok(msap_commit(world, NULL, NULL));
        sweeps = frame == 8 ? stats_of(world).sweeps : sweeps;
        for (i = 0; i < n; i++) {
            bounds[i].min[i % 3] += 0.085f;
            bounds[i].max[i % 3] = bounds[i].min[i % 3] + 1;
        }
        ok(msap_update_many(world, (size_t)n, names, &boxes));
    }
    ok(msap_commit(world, NULL, NULL));
    ok(msap_prune(NULL, (size_t)n, &boxes, &pairs, &count, NULL));
    ck_assert_uint_eq(stats_of(world).pairs, count);
    ok(msap_prune_free(NULL, pairs, count));
    sweeps = stats_of(world).sweeps - sweeps;
    ok(msap_destroy(world));
    return sweeps;
}

/* However many boxes drift, and although they leave the first skins before they have others, all are pruned no more
 * after a few commits. */
START_TEST(drifting_boxes_are_not_pruned)
{
    ck_assert_uint_eq(sweeps_of_a_drift(2000), 0);
    ck_assert_uint_eq(sweeps_of_a_drift(20000), 0);
    ck_assert_uint_eq(sweeps_of_a_drift(DRIFTING), 0);
}
END_TEST

/* Adds box i of a scene or, from then on, updates it. */
static void put(session *s, int i, const box *b, int is_new)
{
    if (is_new)
        right(session_add(s, b, 0, &handles[i]));
    else
        right(session_update(s, handles[i], b));
}

/* How many boxes are put elsewhere in 420 commits, and at how many pairs those look, once a crowd has drifted
 * for 60. */
static void drift(float from, uint64_t *moves, uint64_t *looks)
{
    msap_config config = config_of(3, DEFAULT);
    session s;
    int i, frame;
    *moves = *looks = 0;
    right(session_open(&s, &config, 31, SCENE_SPREAD));
    for (i = 0; i < CROWD; i++)
        at[i] = in_square(&s.random, 64, 1);
    for (frame = 0; frame < 480; frame++) {
        for (i = 0; i < CROWD; i++) {
            float x = from + at[i].min[0] + (float)(i % 3 + 1) * 0.0137f * (float)frame;
            float y = from + at[i].min[1] + (float)(i % 5 - 2) * 0.0119f * (float)frame;
            box b = box_of(x, y, 0, x + 1, y + 1, 1);
            put(&s, i, &b, frame == 0);
        }
        right(session_commit(&s));
        *moves += frame < 60 ? 0 : stats_of(s.world).moves;
        *looks += frame < 60 ? 0 : stats_of(s.world).touched;
    }
    right(session_compare(&s));
    right(session_close(&s));
}

/* Where floats are so far apart that a box stands still and then makes a step, it moves as smoothly as
 * elsewhere in the long run, and its skin is made for that. */
START_TEST(boxes_that_crawl_far_away)
{
    uint64_t near_moves, near_looks, far_moves, far_looks;
    drift(0, &near_moves, &near_looks);
    drift(524288, &far_moves, &far_looks); /* floats are a sixteenth apart */
    ck_assert_msg(far_moves <= near_moves * 3 / 2 && far_looks <= near_looks * 3 / 2,
                  "%lu moves near, %lu far; %lu pairs looked at near, %lu far", (unsigned long)near_moves,
                  (unsigned long)far_moves, (unsigned long)near_looks, (unsigned long)far_looks);
}
END_TEST

/* Boxes that begin to walk leave their first skins in great numbers, but only once. */
START_TEST(first_skins_do_not_count)
{
    session s;
    int frame;
    choose_crowd(_i);
    open_crowd(&s, MSAP_MARGIN_AUTO);
    for (frame = 0; frame < 20; frame++) {
        step_all(&s, 0.02f);
        right(session_commit(&s));
    }
    right(session_compare(&s));
    ck_assert_uint_eq(stats_of(s.world).sweeps, 1);
    right(session_close(&s));
}
END_TEST

/* Boxes that come while all are pruned make pairs with a box that is infinite on all axes, too,
 * where that is in a row like others. */
START_TEST(all_of_space_and_boxes_that_come)
{
    enum { BOXES = 100, QUIET = 6, COMMITS = 9 }; /* without many events, pairs are settled */
    msap_config config = config_of(3, _i);
    float infinity = float_of(0x7F800000);
    box all = box_of(-infinity, -infinity, -infinity, infinity, infinity, infinity);
    session s;
    int i, frame;
    right(session_open(&s, &config, 37, SCENE_SPREAD));
    right(session_add(&s, &all, 0, &handles[BOXES]));
    for (frame = 0; frame < COMMITS; frame++) {
        for (i = 0; i < (frame < QUIET ? BOXES : 1); i++) {
            box b = in_square(&s.random, 12, 4);
            put(&s, i, &b, frame == 0 || frame > QUIET);
        }
        right(session_commit(&s));
        right(session_compare(&s));
    }
    right(session_close(&s));
}
END_TEST

/* Where very many boxes reach through all, cells are kept even if they do not pay. */
START_TEST(giants_are_not_pruned)
{
    session s;
    msap_handle giant;
    box all = box_of(0, 0, 0, 60, 60, 1);
    uint64_t sweeps;
    int i;
    choose_crowd(1);
    open_crowd(&s, MSAP_MARGIN_AUTO);
    for (i = 0; i < 300; i++)
        right(session_add(&s, &all, 0, &giant));
    right(session_commit(&s));
    commits_that_track(&s, FEW | FAST, 0, 2);
    sweeps = stats_of(s.world).sweeps;
    ck_assert_int_eq(commits_that_track(&s, FEW | FAST, 0, 12), 12);
    ck_assert_uint_eq(stats_of(s.world).sweeps, sweeps);
    commits_that_track(&s, ALL | FAST, 0, 3);
    ck_assert_uint_gt(stats_of(s.world).cells, 0);
    right(session_close(&s));
}
END_TEST

/* ------------------------------------------------------------- mass removal */

/* Many boxes leave in one commit, in some while others come and move; in the last one all do. */
START_TEST(many_boxes_leave_together)
{
    msap_config config = config_of(3, _i);
    session s;
    int round, step;
    uint32_t slot;
    right(session_open(&s, &config, 11, SCENE_SIZES));
    for (round = 0; round < 6; round++) {
        for (step = 0; step < 4; step++)
            right(session_step(&s, 500));
        for (slot = 0; slot < s.reference.slot_count; slot++)
            if (s.reference.slots[slot].state == SLOT_LIVE && random_below(&s.random, 8) < (round == 5 ? 8 : 3))
                right(session_remove(&s, s.reference.slots[slot].handle));
        if (round % 2 == 1 && round < 5)
            right(session_change(&s, 400));
        right(session_commit(&s));
        right(session_compare(&s));
    }
    right(session_close(&s));
}
END_TEST

/* ------------------------------------------------------ pairs that are others each time */

/* All boxes are somewhere else in most commits, ever closer together, but for one without any
 * change and one in which a single box moves; some are static, some reach through all along one axis,
 * and some come and go. The n-th allocation fails, and all after it until a call does; 0: none.
 * Returns whether one did. */
static int jumps_with_failure(int row, int boxes, size_t n)
{
    enum { COMMITS = 9, QUIET = 4, SINGLE = 6 };
    msap_config config = config_of(3, row);
    float side = 0.8f * sqrtf((float)boxes);
    session s;
    int i, frame, failed;
    right(session_open(&s, &config, 21, SCENE_SPREAD));
    s.memory.fail_from = n ? s.memory.calls + n : 0;
    for (frame = 0; frame < COMMITS; frame++) {
        for (i = 0; i < (frame == QUIET ? 0 : frame == SINGLE ? 1 : boxes); i++) {
            box b = in_square(&s.random, side * (float)(16 - frame) / 16, 1.5f);
            b.max[i % 2] += i % 200 < 2 ? 2 * side : 0;
            b.max[2] += (float)random_below(&s.random, 3);
            if (frame == 0 || (i + frame) % 40 == 0) {
                if (frame > 0)
                    right(session_remove(&s, handles[i]));
                right(session_add(&s, &b, i % 7 == 0 ? MSAP_STATIC : 0, &handles[i]));
            } else
                right(session_update(&s, handles[i], &b));
        }
        right(session_commit(&s));
        right(session_compare(&s));
    }
    failed = s.memory.failures > 0;
    right(session_close(&s));
    return failed;
}

START_TEST(pairs_that_are_others_each_time)
{
    ck_assert(!jumps_with_failure(_i, setups[_i].strategy == MSAP_STRATEGY_AUTO ? 2500 : 250, 0));
}
END_TEST

START_TEST(pairs_that_are_others_each_time_and_failures)
{
    size_t n = 1, step = _i == DEFAULT ? 1 : 15;
    while (jumps_with_failure(_i, 100, n))
        n += step;
    ck_assert_uint_gt(n, 5);
}
END_TEST

int main(void)
{
    static const int strategies[] = {MSAP_STRATEGY_AUTO, MSAP_STRATEGY_SWEEP};
    TCase *tests = tcase_create("grids");
    size_t s;
    tcase_add_loop_test(tests, a_pair_in_many_cells_is_one_event, 0, SETUPS);
    tcase_add_loop_test(tests, borders_between_cells_are_not_seen, 0, SETUPS);
    tcase_add_loop_test(tests, wrapped_cells_are_not_one_place, 0, SETUPS);
    tcase_add_loop_test(tests, many_boxes_leave_together, 0, SETUPS);
    tcase_add_loop_test(tests, pairs_that_are_others_each_time, 0, SETUPS);
    tcase_add_loop_test(tests, pairs_that_are_others_each_time_and_failures, 0, SETUPS);
    tcase_add_test(tests, cells_are_as_wide_as_asked);
    tcase_add_loop_test(tests, a_fixed_grid_has_the_cells_that_were_asked_for, MSAP_STRATEGY_SLIDE,
                        MSAP_STRATEGY_SWEEP + 1);
    tcase_add_test(tests, a_grid_that_is_too_large_for_the_memory);
    for (s = 0; s < COUNT(strategies); s++) {
        int i = strategies[s];
        tcase_add_loop_test(tests, cells_fit_a_field, i, i + 1);
        tcase_add_loop_test(tests, a_scene_that_grows, i, i + 1);
        tcase_add_loop_test(tests, a_scene_that_empties, i, i + 1);
        tcase_add_loop_test(tests, a_scene_that_swells, i, i + 1);
        tcase_add_loop_test(tests, a_density_that_changes, i, i + 1);
        tcase_add_loop_test(tests, boxes_that_shrink, i, i + 1);
    }
    tcase_add_loop_test(tests, cells_are_kept_while_they_pay, 0, 2);
    tcase_add_loop_test(tests, motion_can_deceive, 0, 2);
    tcase_add_test(tests, drifting_boxes_are_not_pruned);
    tcase_add_test(tests, boxes_that_crawl_far_away);
    tcase_add_loop_test(tests, first_skins_do_not_count, 0, 2);
    tcase_add_loop_test(tests, all_of_space_and_boxes_that_come, 0, SETUPS);
    tcase_add_test(tests, giants_are_not_pruned);
    tcase_add_loop_test(tests, work_follows_boxes_that_jump, 0, MSAP_STRATEGY_SWEEP + 1);
    tcase_add_loop_test(tests, work_follows_boxes_that_walk, 0, MSAP_STRATEGY_SWEEP + 1);
    return run_case(tests, "grids");
}
