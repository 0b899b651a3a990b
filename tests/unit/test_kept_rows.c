/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: while all boxes are pruned in each commit and their rows are kept (kept.c), no pair is missed, whatever
 * boxes come, go, jump, grow or change their order, and the rows hold what they are said to. It looks behind the
 * interface to see that rows are kept.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { MOST = 2700 };

/* A session, and boxes that tremble. */
typedef struct crowd {
    session s;
    msap_handle handles[MOST];
    box bounds[MOST];
    uint32_t n, kept; /* commits in which rows were */
} crowd;

static struct grid *grid_of(crowd *c) { return &c->s.world->grid; }

static void open_crowd(crowd *c, int row, uint32_t dims)
{
    msap_config config = config_of(dims, row);
    c->n = c->kept = 0;
    right(session_open(&c->s, &config, 3, SCENE_SPREAD));
}

/* Whether a set-up chooses its ways itself, in a grid: others keep no rows. */
static int chooses(int row)
{
    msap_config config = config_of(3, row);
    return config.grid != MSAP_GRID_NONE && config.strategy == MSAP_STRATEGY_AUTO;
}

/* A box of about size 1 in a block. */
static box somewhere(crowd *c)
{
    static const uint32_t size[3] = {12, 10, 8};
    float low[3];
    for (int k = 0; k < 3; k++) low[k] = (float)random_below(&c->s.random, 100 * size[k]) / 100;
    return box_of(low[0], low[1], low[2], low[0] + 1, low[1] + 1.25f, low[2] + 0.75f);
}

static void put(crowd *c, box bounds, uint32_t flags)
{
    c->bounds[c->n] = bounds;
    right(session_add(&c->s, &bounds, flags, &c->handles[c->n++]));
}

static void put_some(crowd *c, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) put(c, somewhere(c), random_below(&c->s.random, 16) == 0 ? MSAP_STATIC : 0);
}

static void set(crowd *c, uint32_t i, box bounds)
{
    c->bounds[i] = bounds;
    right(session_update(&c->s, c->handles[i], &bounds));
}

static void take_away(crowd *c, uint32_t i)
{
    right(session_remove(&c->s, c->handles[i]));
    c->handles[i] = c->handles[--c->n];
    c->bounds[i] = c->bounds[c->n];
}

/* Each box goes up to so far, anywhere. */
static void tremble(crowd *c, float most)
{
    for (uint32_t i = 0; i < c->n; i++) {
        box b = c->bounds[i];
        for (int k = 0; k < 3; k++) {
            float step = most * ((float)random_below(&c->s.random, 2001) / 1000 - 1);
            b.min[k] += step;
            b.max[k] += step;
        }
        set(c, i, b);
    }
}

static void end_frame(crowd *c)
{
    const struct row_set *set = &grid_of(c)->row_set;
    size_t slots = set->slots, few = c->n / 8;
    int might = slots > 0 && set->changed <= few;
    struct rows rows = grid_of(c)->rows;
    right(session_commit(&c->s));
    right(session_compare(&c->s));
    might = might && memcmp(rows.count, set->rows.count, sizeof rows.count) == 0;
    c->kept += might && grid_of(c)->is_jumping && set->slots >= slots;
}

/* So many commits in which boxes tremble. In all but the first one, after which there are to be no skins, they are
 * pruned; then rows are kept. */
static void settle_down(crowd *c, int commits)
{
    for (int i = 0; i < commits; i++) {
        tremble(c, 0.04f);
        end_frame(c);
        grid_of(c)->upkeep.not_before = UINT32_MAX / 2;
    }
    ck_assert(grid_of(c)->is_jumping);
    ck_assert_uint_gt(c->kept, 0);
}

/* Whether rows were kept in half of so many commits or more. */
static void were_kept(crowd *c, uint32_t commits)
{
    ck_assert_uint_ge(2 * c->kept, commits);
    right(session_close(&c->s));
}

/* What happens in one commit, besides that all tremble. */
enum { NOTHING, COME, GO, COME_AND_GO, JUMP, GROW, SHRINK, HAPPENINGS };

static void happen(crowd *c, int what)
{
    for (uint32_t i = 0; i < 6 && c->n > 280 && (what == GO || what == COME_AND_GO); i++)
        take_away(c, random_below(&c->s.random, c->n));
    if ((what == COME || what == COME_AND_GO) && c->n + 6 < MOST) put_some(c, 6);
    for (uint32_t k = 0; k < 5; k++) {
        uint32_t i = random_below(&c->s.random, c->n);
        box b = c->bounds[i];
        if (what == JUMP) b = somewhere(c);
        if (what == GROW) b = box_of(-3, -3, -3, 16, 14, b.max[2]); /* and is wide */
        if (what == SHRINK) b = box_of(b.min[0], b.min[1], b.min[2], b.min[0], b.min[1], b.min[2]);
        set(c, i, b);
    }
}

START_TEST(all_happens_to_kept_rows)
{
    enum { COMMITS = 48 };
    for (int what = 0; what < HAPPENINGS; what++) {
        crowd c;
        if (!chooses(_i) || (_i != DEFAULT && _i % HAPPENINGS != what)) continue;
        open_crowd(&c, _i, 2 + (uint32_t)what % 2);
        put_some(&c, 401);
        settle_down(&c, 12);
        c.kept = 0;
        for (int frame = 0; frame < COMMITS; frame++) {
            tremble(&c, 0.04f);
            if (frame % 3 == 0) happen(&c, what);
            end_frame(&c);
        }
        were_kept(&c, COMMITS);
    }
}
END_TEST

/* All jump in one commit: what is kept is nothing. And once more, when rows are kept again. */
START_TEST(all_jump_out_of_kept_rows)
{
    crowd c;
    if (!chooses(_i)) return;
    open_crowd(&c, _i, 3);
    put_some(&c, 400);
    for (int time = 0; time < 3; time++) {
        settle_down(&c, 12);
        for (uint32_t i = 0; i < c.n; i++) set(&c, i, somewhere(&c));
        end_frame(&c);
        c.kept = 0;
    }
    right(session_close(&c.s));
}
END_TEST

/* The order in all rows is turned around, on each axis: one of them is the one that is swept. */
START_TEST(kept_rows_turn_around)
{
    for (int axis = 0; axis < 3; axis++) {
        crowd c;
        if (!chooses(_i) || (_i != DEFAULT && _i % 3 != axis)) continue;
        open_crowd(&c, _i, 3);
        put_some(&c, 400);
        settle_down(&c, 8);
        for (int frame = 0; frame < 2; frame++) {
            for (uint32_t i = 0; i < c.n; i++) {
                box b = c.bounds[i];
                b.min[axis] = 10 - c.bounds[i].max[axis];
                b.max[axis] = 10 - c.bounds[i].min[axis];
                set(&c, i, b);
            }
            end_frame(&c);
        }
        right(session_close(&c.s));
    }
}
END_TEST

/* Coordinates are exchanged, as in `from`; on each axis places and lengths are taken so many times. */
static void remake(crowd *c, const int from[3], const float place[3], const float length[3])
{
    for (uint32_t i = 0; i < c->n; i++) {
        box b = c->bounds[i], old = b;
        for (int k = 0; k < 3; k++) {
            b.min[k] = place[k] * old.min[from[k]];
            b.max[k] = b.min[k] + length[k] * (old.max[from[k]] - old.min[from[k]]);
        }
        set(c, i, b);
    }
}

/* Other rows are chosen, in which boxes are elsewhere: wider ones or more of them, on either axis across, or on other
 * axes. */
START_TEST(other_rows_are_chosen)
{
    static const int same[3] = {0, 1, 2}, turned[3] = {1, 2, 0};
    static const float as_is[3] = {1, 1, 1}, long_x[3] = {6, 1, 1}, twice_y[3] = {1, 2, 1}, twice_z[3] = {1, 1, 2};
    static const struct {
        const int *from;
        const float *place, *length;
    } ways[] = {{same, twice_y, twice_y}, {same, twice_z, twice_z}, {same, twice_y, as_is}, {same, twice_z, as_is},
                {turned, as_is, as_is}};
    for (int way = 0; way < (int)COUNT(ways); way++) {
        crowd c;
        if (!chooses(_i) || (_i != DEFAULT && _i % (int)COUNT(ways) != way)) continue;
        open_crowd(&c, _i, 3);
        put_some(&c, 400);
        remake(&c, same, long_x, as_is); /* this is the axis that is swept */
        for (int time = 0; time < 2; time++) {
            settle_down(&c, 20);
            remake(&c, ways[way].from, ways[way].place, ways[way].length);
            end_frame(&c);
        }
        settle_down(&c, 20);
        right(session_close(&c.s));
    }
}
END_TEST

/* The same of more rows on one axis, of which the set tells: then nothing else that it tells is looked at. */
START_TEST(more_rows_are_chosen)
{
    for (int k = 0; k < 2; k++) {
        crowd c;
        open_crowd(&c, DEFAULT, 3);
        put_some(&c, 400);
        settle_down(&c, 12);
        struct row_set *set = &grid_of(&c)->row_set;
        set->rows.count[k] *= 2;
        memset(set->range, 0, set->slots * sizeof *set->range);
        settle_down(&c, 3);
        right(session_close(&c.s));
    }
}
END_TEST

/* All go, and others come into their slots, in the same commit or in the next one. */
START_TEST(all_go_and_others_come)
{
    crowd c;
    if (!chooses(_i)) return;
    open_crowd(&c, _i, 3);
    put_some(&c, 400);
    settle_down(&c, 12);
    for (int time = 0; time < 2; time++) {
        while (c.n > 0) take_away(&c, c.n - 1);
        if (time == 1) end_frame(&c);
        put_some(&c, 410);
        end_frame(&c);
        settle_down(&c, 4);
    }
    right(session_close(&c.s));
}
END_TEST

/* Boxes tremble a little, and cells and lists, if there are any, are not given up. */
static void calm_down(crowd *c)
{
    grid_of(c)->gain = INT32_MAX;
    tremble(c, 0.01f);
    end_frame(c);
}

/* Many boxes become wide while a renewal in steps is to keep rows, and boxes are in cells: rows are counted anew, in
 * vain, and the renewal is given up. */
START_TEST(rows_are_overwritten_between_the_steps)
{
    static const int same[3] = {0, 1, 2};
    static const float twice[3] = {2, 2, 2}, longer[3] = {1.5f, 1.5f, 1.5f};
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    put_some(&c, 2600);
    settle_down(&c, 12);
    remake(&c, same, twice, longer);
    c.s.world->stale = 1; /* so cells and lists are made, as after a commit without memory */
    for (int frame = 0; frame < 15; frame++) calm_down(&c);
    struct grid *g = grid_of(&c);
    struct job job = {&c.s.world->boxes, &c.s.world->pairs, &c.s.world->crew.worker[0], &c.s.world->memory,
                      &c.s.world->scratch, &c.s.world->crew, c.s.world->config.filters};
    g->upkeep.horizon = 40;
    msap_renewal_begin(g, &job);
    for (int frame = 0; frame < 20 && g->renewal.next != SORT_ROWS; frame++) calm_down(&c);
    ck_assert(g->renewal.next == SORT_ROWS && g->is_tracking && !g->is_resting);
    for (uint32_t i = 0; i <= MOST_WIDE; i++) set(&c, i, box_of((float)i / 8, -3, -3, (float)i / 8, 30, 30));
    g->gain = INT32_MIN;
    g->rows.chosen_for = 0;
    end_frame(&c);
    ck_assert(g->renewal.next == NO_RENEWAL && g->is_tracking);
    for (int frame = 0; frame < 5; frame++) calm_down(&c);
    right(session_close(&c.s));
}
END_TEST

/* Each box goes to where the next one was. */
static void shift_places(crowd *c)
{
    box first = c->bounds[0];
    for (uint32_t i = 0; i + 1 < c->n; i++) set(c, i, c->bounds[i + 1]);
    set(c, c->n - 1, first);
    end_frame(c);
}

/* Rows hold as many boxes as before, but others: no memory is asked for. */
START_TEST(boxes_change_places)
{
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    put_some(&c, 700);
    tremble(&c, 0);
    end_frame(&c);
    grid_of(&c)->upkeep.not_before = UINT32_MAX / 2;
    shift_places(&c);
    shift_places(&c);
    for (int frame = 0; frame < 12; frame++) {
        tremble(&c, 0);
        end_frame(&c);
    }
    ck_assert_uint_eq(grid_of(&c)->row_set.changed, 0);
    size_t calls = c.s.memory.calls;
    shift_places(&c);
    ck_assert_uint_eq(c.s.memory.calls, calls);
    right(session_close(&c.s));
}
END_TEST

/* The n-th allocation fails while more boxes come to kept rows. Returns whether there was one. */
static size_t come_without_memory(size_t n)
{
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    put_some(&c, 360);
    settle_down(&c, 8);
    c.s.memory.fail_at = c.s.memory.calls + n;
    for (int frame = 0; frame < 6; frame++) {
        tremble(&c, 0.04f);
        put_some(&c, 30);
        end_frame(&c);
    }
    size_t failures = c.s.memory.failures;
    right(session_close(&c.s));
    return failures;
}

START_TEST(without_memory)
{
    for (size_t n = 1; come_without_memory(n) > 0;) n++;
}
END_TEST

/* What the rows of the last pruning hold wrongly, they do after the next one: so they were kept. */
START_TEST(rows_are_kept)
{
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    put_some(&c, 400);
    settle_down(&c, 12);
    struct row_set *rows = &grid_of(&c)->row_set;
    rows->id[5] = rows->id[6];
    tremble(&c, 0);
    ok(msap_commit(c.s.world, NULL, NULL));
    ck_assert(grid_of(&c)->is_jumping);
    is_broken(c.s.world, "rows name other boxes than are said to be in them");
    right(session_close(&c.s));
}
END_TEST

/* The validator sees what rows should hold and do not. */
START_TEST(broken_ranges)
{
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    put_some(&c, 400);
    settle_down(&c, 12);
    struct row_set *rows = &grid_of(&c)->row_set;
    uint32_t id = rows->id[5];
    rows->id[5] ^= ROW_STARTS_1;
    is_broken(c.s.world, "rows name other boxes than are said to be in them");
    rows->id[5] = rows->id[6];
    is_broken(c.s.world, "rows name other boxes than are said to be in them");
    rows->id[5] = id;
    uint32_t row = rows->range[7].row;
    rows->range[7].row = NO_ROW;
    is_broken(c.s.world, "rows name other boxes than are said to be in them");
    rows->range[7].row = row;
    uint32_t last = rows->end[0] - 1; /* of the first row, which has several boxes */
    int32_t min = rows->min[0][last];
    rows->min[0][last] = INT32_MIN;
    is_broken(c.s.world, "a row is not sorted");
    rows->min[0][last] = min;
    right(session_compare(&c.s));
    right(session_close(&c.s));
}
END_TEST

/* A sheet of boxes each of which goes up and down by much: there is one row for all heights, since they would leave
 * others in each commit, and the boxes stay where they are. So it is whatever the axis is. */
START_TEST(a_sheet_goes_up_and_down)
{
    enum { SIDE = 24, FRAMES = 24 };
    int up = _i;
    crowd c;
    open_crowd(&c, DEFAULT, 3);
    for (int frame = 0; frame < FRAMES; frame++) {
        for (uint32_t i = 0; i < SIDE * SIDE; i++) {
            float at[3];
            at[up] = (float)random_below(&c.s.random, 600) / 100;
            at[(up + 1) % 3] = 1.0625f * (float)(i % SIDE);
            at[(up + 2) % 3] = 1.0625f * (float)(i / SIDE);
            box b = box_of(at[0], at[1], at[2], at[0] + 1, at[1] + 1, at[2] + 1);
            if (frame == 0) put(&c, b, 0);
            else set(&c, i, b);
        }
        end_frame(&c);
        grid_of(&c)->upkeep.not_before = UINT32_MAX / 2;
    }
    ck_assert(grid_of(&c)->is_jumping);
    ck_assert_uint_eq(grid_of(&c)->row_set.changed, 0);
    ck_assert_uint_gt(grid_of(&c)->rows.count[0] * grid_of(&c)->rows.count[1], 1);
    right(session_close(&c.s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("kept rows");
    tcase_add_loop_test(tests, a_sheet_goes_up_and_down, 0, 3);
    tcase_add_loop_test(tests, all_happens_to_kept_rows, 0, SETUPS);
    tcase_add_loop_test(tests, all_jump_out_of_kept_rows, 0, SETUPS);
    tcase_add_loop_test(tests, kept_rows_turn_around, 0, SETUPS);
    tcase_add_loop_test(tests, other_rows_are_chosen, 0, SETUPS);
    tcase_add_test(tests, more_rows_are_chosen);
    tcase_add_loop_test(tests, all_go_and_others_come, 0, SETUPS);
    tcase_add_test(tests, rows_are_overwritten_between_the_steps);
    tcase_add_test(tests, boxes_change_places);
    tcase_add_test(tests, without_memory);
    tcase_add_test(tests, rows_are_kept);
    tcase_add_test(tests, broken_ranges);
    return run_case(tests, "kept rows");
}
