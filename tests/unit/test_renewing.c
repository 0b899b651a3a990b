/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: while all boxes get new skins together (renew.c), none of their pairs is missed and none is told
 * twice, whatever happens between the steps: boxes come, go and come again in the same slots, jump, stand
 * still or grow. It looks behind the interface to see which step is next.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { MOST = 1200 };

/* A session, and boxes that walk: each on its way, back and forth. */
typedef struct walkers {
    session s;
    msap_handle handles[MOST];
    box bounds[MOST];
    float step[MOST][3];
    uint32_t n, turn; /* after so many commits all turn around */
    uint32_t commits;
} walkers;

static void open_walk(walkers *w, int row, uint32_t dims, uint64_t seed)
{
    msap_config config = config_of(dims, row);
    w->n = w->commits = 0;
    w->turn = 40;
    right(session_open(&w->s, &config, seed, SCENE_SPREAD));
}

static void put(walkers *w, box bounds, float step, uint32_t flags)
{
    w->bounds[w->n] = bounds;
    for (int k = 0; k < 3; k++)
        w->step[w->n][k] = flags ? 0 : step * ((float)random_below(&w->s.random, 2001) / 1000 - 1);
    right(session_add(&w->s, &bounds, flags, &w->handles[w->n++]));
}

/* A box of about size 1 in a block that is so large. */
static box in_block(walkers *w, const uint32_t size[3])
{
    float low[3];
    for (int k = 0; k < 3; k++) low[k] = (float)random_below(&w->s.random, 100 * size[k]) / 100;
    return box_of(low[0], low[1], low[2], low[0] + 1, low[1] + 1.25f, low[2] + 0.75f);
}

/* So many boxes, in about four times the room that they take; of sixteen of them so many are static. */
static void put_some(walkers *w, uint32_t n, float step, uint32_t statics)
{
    const uint32_t size[3] = {16, 12, 8};
    for (uint32_t i = 0; i < n; i++)
        put(w, in_block(w, size), step, random_below(&w->s.random, 16) < statics ? MSAP_STATIC : 0);
}

static void set(walkers *w, uint32_t i, box bounds)
{
    w->bounds[i] = bounds;
    right(session_update(&w->s, w->handles[i], &bounds));
}

/* All go on by a step, but for one in so many. */
static void walk(walkers *w, uint32_t but)
{
    float way = w->commits / w->turn % 2 ? -1.0f : 1.0f;
    for (uint32_t i = 0; i < w->n; i++) {
        box b = w->bounds[i];
        if (but > 0 && i % but == 0) continue;
        for (int k = 0; k < 3; k++) {
            b.min[k] += way * w->step[i][k];
            b.max[k] += way * w->step[i][k];
        }
        set(w, i, b);
    }
}

static const struct grid *grid_of(const walkers *w) { return &w->s.world->grid; }

static void end_frame(walkers *w)
{
    right(session_commit(&w->s));
    right(session_compare(&w->s));
    if (grid_of(w)->in_skins) {
        ck_assert_uint_ge(grid_of(w)->upkeep.made_for, HORIZON_SHORT);
        ck_assert_uint_le(grid_of(w)->upkeep.made_for, HORIZON_MOST);
    }
    w->commits++;
}

/* All go on for so many commits. */
static void walk_on(walkers *w, int commits)
{
    for (int i = 0; i < commits; i++) {
        walk(w, 0);
        end_frame(w);
    }
}

/* Whether a set-up chooses its ways itself, in a grid: others never renew skins. */
static int chooses(int row)
{
    msap_config c = config_of(3, row);
    return c.grid != MSAP_GRID_NONE && c.strategy == MSAP_STRATEGY_AUTO;
}

/* The same, and skins are made for motion. */
static int is_free(const walkers *w)
{
    const msap_config *c = &w->s.world->config;
    return c->grid != MSAP_GRID_NONE && c->strategy == MSAP_STRATEGY_AUTO && c->margin < 0;
}

static void take_away(walkers *w, uint32_t i)
{
    right(session_remove(&w->s, w->handles[i]));
    w->n--;
    w->handles[i] = w->handles[w->n];
    w->bounds[i] = w->bounds[w->n];
    memcpy(w->step[i], w->step[w->n], sizeof w->step[i]);
}

/* Boxes that walk get new skins again and again, and are pruned in one commit no more. */
START_TEST(all_walk)
{
    for (uint32_t dims = 2; dims <= 3; dims++) {
        walkers w;
        int steps[CHANGE_SKINS + 1] = {0};
        open_walk(&w, _i, dims, 1);
        put_some(&w, 320, 0.02f, 2);
        for (int frame = 0; frame < 120; frame++) {
            walk(&w, 0);
            end_frame(&w);
            steps[grid_of(&w)->renewal.next]++;
            if (is_free(&w) && frame > 10) ck_assert(grid_of(&w)->in_skins);
        }
        for (int step = 0; step <= CHANGE_SKINS && is_free(&w); step++)
            if (step == NO_RENEWAL || step > MAKE_SKINS) ck_assert_int_ge(steps[step], 2);
        right(session_close(&w.s));
    }
}
END_TEST

/* In the first renewal of a loaded world, in which boxes lie in a block so many times as long and go up to so far in
 * each commit, these of three steps, a bit each, wait for a commit of their own. */
static void wait_for_commits(uint32_t expected, int row, uint32_t times, float step)
{
    const uint32_t size[3] = {16 * times, 12 * times, 8 * times};
    const uint32_t three = 1u << MAKE_MORE_SKINS | 1u << LIST_ROWS | 1u << FILL_ROWS;
    uint32_t waited = 0;
    walkers w;
    open_walk(&w, row, 3, 7);
    for (int i = 0; i < 320; i++) put(&w, in_block(&w, size), step, 0);
    for (int frame = 0; !(waited & 1u << CHANGE_SKINS) && frame < 20; frame++) {
        walk(&w, 0);
        end_frame(&w);
        waited |= 1u << grid_of(&w)->renewal.next;
    }
    if (is_free(&w)) ck_assert_uint_eq(waited & (three | 1u << CHANGE_SKINS), expected | 1u << CHANGE_SKINS);
    right(session_close(&w.s));
}

/* Steps are taken by twos where skins do not last long: some where those to come do not, as where many overlap; most
 * where first ones would be left. */
START_TEST(some_are_in_a_hurry)
{
    wait_for_commits(1u << MAKE_MORE_SKINS | 1u << LIST_ROWS | 1u << FILL_ROWS, _i, 1, 0.01f);
    wait_for_commits(1u << LIST_ROWS, _i, 1, 0.06f);
    wait_for_commits(1u << FILL_ROWS, _i, 3, 0.06f);
}
END_TEST

/* Boxes that go straight on, where few overlap, stay in skins however soon they would leave them: it takes long to renew
 * these in one commit, so it is done in steps. */
START_TEST(sparse_boxes_drift)
{
    const uint32_t size[3] = {22, 22, 10};
    for (int speed = 1; speed <= 4; speed++) {
        walkers w;
        open_walk(&w, DEFAULT, 3, 16);
        w.turn = 100;
        for (int i = 0; i < 1000; i++) put(&w, in_block(&w, size), 0.025f * (float)speed, 0);
        for (int frame = 0; frame < 40; frame++) {
            walk(&w, 0);
            right(session_commit(&w.s));
            w.commits++;
            ck_assert(grid_of(&w)->in_skins);
        }
        right(session_compare(&w.s));
        right(session_close(&w.s));
    }
}
END_TEST

/* Boxes that were wide and many, so that no others could have skins, go: some time later these do. */
START_TEST(giants_go)
{
    walkers w;
    int frames = 0;
    open_walk(&w, _i, 3, 24);
    put_some(&w, 300, 0.02f, 0);
    for (int i = 0; i < MOST_WIDE + 20; i++)
        put(&w, box_of(0.0625f * (float)i, -90, -90, 0.0625f * (float)i + 0.03125f, 90, 90), 0, 0);
    walk_on(&w, 3);
    ck_assert(!grid_of(&w)->in_skins);
    while (w.n > 300) take_away(&w, w.n - 1);
    for (; frames < 600 && !grid_of(&w)->in_skins; frames++) {
        walk(&w, 0);
        end_frame(&w);
    }
    ck_assert(grid_of(&w)->in_skins || !is_free(&w));
    right(session_close(&w.s));
}
END_TEST

/* ------------------------------------------------------- between the steps */

/* What happens in one commit, besides that all walk. */
enum { COME, GO, COME_AND_GO, JUMP, GROW, SHRINK, STOP, ALL_JUMP, HAPPENINGS };

static void happen(walkers *w, int what)
{
    const uint32_t size[3] = {16, 12, 8};
    for (uint32_t i = 0; i < 12 && w->n > 270 && (what == GO || what == COME_AND_GO); i++)
        take_away(w, random_below(&w->s.random, w->n));
    if ((what == COME || what == COME_AND_GO) && w->n + 12 < MOST) put_some(w, 12, 0.05f, 4);
    for (uint32_t i = 0; i < w->n; i++) {
        uint32_t one_in = what == ALL_JUMP ? 1 : 20;
        if (random_below(&w->s.random, one_in) > 0) continue;
        box b = w->bounds[i];
        if (what == JUMP || what == ALL_JUMP) b = in_block(w, size);
        if (what == GROW) b = box_of(-3, -3, -3, 19, 15, b.max[2]);
        if (what == SHRINK) b = box_of(b.min[0], b.min[1], b.min[2], b.min[0], b.min[1], b.min[2]);
        set(w, i, b);
    }
}

/* Whether a step is next; TRY_SKINS is for as long as some boxes are tried, and the commit after that. */
static int is_next(const walkers *w, int step)
{
    const struct grid *g = grid_of(w);
    return step == TRY_SKINS ? !g->in_skins && g->commit - g->upkeep.tried < 4 : (int)g->renewal.next == step;
}

/* A scene in which something happens before each time that a step comes. Returns how often. */
static int walk_through(walkers *w, int what, int step, int frames)
{
    int times = 0;
    for (int frame = 0; frame < frames; frame++) {
        walk(w, what == STOP ? 2 : 0);
        if (is_next(w, step) && frame > 1) happen(w, times++ % 2 ? GO : what);
        end_frame(w);
    }
    return times;
}

/* Everything happens before each step, and before each two. */
START_TEST(all_happens_between_the_steps)
{
    if (!chooses(_i)) return;
    for (int what = 0; what < HAPPENINGS; what++)
        for (int step = NO_RENEWAL; step <= CHANGE_SKINS; step++) {
            walkers w;
            if (step != NO_RENEWAL && step <= MAKE_SKINS) continue; /* see below */
            open_walk(&w, _i, 2 + (uint32_t)(what + step) % 2, (uint64_t)(10 * what + step));
            put_some(&w, 300, 0.02f, 2);
            int times = walk_through(&w, what, step, 18);
            if (is_free(&w)) ck_assert_int_gt(times, 0);
            right(session_close(&w.s));
        }
}
END_TEST

/* The same after all have jumped about: skins are tried, while all are pruned, before they are used. In each set-up
 * something else happens, in the default one everything and before later steps too. */
START_TEST(all_happens_in_a_trial)
{
    if (!chooses(_i)) return;
    for (int what = 0; what < HAPPENINGS; what++)
        for (int step = TRY_SKINS; step <= CHANGE_SKINS; step++) {
            walkers w;
            if (_i != DEFAULT && (_i % HAPPENINGS != what || step > TRY_SKINS)) continue;
            open_walk(&w, _i, 2 + (uint32_t)(what + step) % 2, (uint64_t)(10 * what + step));
            put_some(&w, 300, 0.08f, 2);
            for (int frame = 0; frame < 4; frame++) {
                happen(&w, ALL_JUMP);
                end_frame(&w);
            }
            int times = walk_through(&w, what, step, 50);
            if (is_free(&w) && step == TRY_SKINS) ck_assert_int_gt(times, 0);
            right(session_close(&w.s));
        }
}
END_TEST

/* All go on by a step, one by more and another by less. */
static void shake(walkers *w)
{
    for (uint32_t i = 0; i < w->n; i++) {
        float part = (float)random_below(&w->s.random, 2001) / 1000;
        box b = w->bounds[i];
        for (int k = 0; k < 3; k++) {
            b.min[k] += part * w->step[i][k];
            b.max[k] += part * w->step[i][k];
        }
        set(w, i, b);
    }
}

/* The same where skins do not last long, since boxes shake: all get new ones within a commit, in which more
 * happens. In each set-up something else does, in the default one everything. */
START_TEST(all_happens_at_once)
{
    int meetings = 0;
    if (!chooses(_i)) return;
    for (int what = 0; what < ALL_JUMP; what++) {
        walkers w;
        if (_i != DEFAULT && _i % ALL_JUMP != what) continue;
        open_walk(&w, _i, 2 + (uint32_t)what % 2, (uint64_t)what + 20);
        for (int i = 0; i < 3; i++) put(&w, box_of(-9, -9, (float)i - 4, 29, 29, (float)i), 0.02f, i == 0 ? MSAP_STATIC : 0);
        put_some(&w, 400, what % 2 ? 0.12f : 0.06f, 2);
        for (int frame = 0; frame < 60; frame++) {
            int was_in_skins = grid_of(&w)->in_skins && grid_of(&w)->renewal.next == NO_RENEWAL;
            shake(&w);
            if (frame % 3 == 2) happen(&w, frame % 2 ? GO : what);
            end_frame(&w);
            meetings += frame % 3 == 2 && was_in_skins && grid_of(&w)->upkeep.since == grid_of(&w)->commit;
        }
        right(session_close(&w.s));
    }
    ck_assert(_i != DEFAULT || meetings > 3);
}
END_TEST

/* Slots are given out again at once, to boxes of another kind: static ones, and none that walk. */
START_TEST(slots_are_given_out_again)
{
    if (!chooses(_i)) return;
    walkers w;
    open_walk(&w, _i, 3, 5);
    put_some(&w, 300, 0.08f, 8);
    for (int frame = 0; frame < 60; frame++) {
        walk(&w, 0);
        for (int i = 0; i < 8; i++) take_away(&w, random_below(&w.s.random, w.n));
        put_some(&w, 8, 0.08f, frame % 3 * 8);
        end_frame(&w);
    }
    right(session_close(&w.s));
}
END_TEST

/* Before each step many boxes on a wide static ground go, and static ones come in their slots and places: two
 * static boxes are never near, whatever the rows say of the slots. */
START_TEST(boxes_freeze)
{
    if (!chooses(_i)) return;
    for (int step = COUNT_ROWS; step <= CHANGE_SKINS; step++) {
        walkers w;
        int has_frozen = 0, waits = 0;
        open_walk(&w, _i, 3, 12);
        put(&w, box_of(-5, -5, -1, 40, 40, 3), 0, MSAP_STATIC);
        for (int i = 0; i < 150; i++) put(&w, box_of(0.1f * (float)i, 1, 0, 0.1f * (float)i + 1, 2, 1), 0.02f, 0);
        put_some(&w, 800, 0.03f, 0);
        for (int frame = 0; frame < 8; frame++) {
            walk(&w, 0);
            if (waits > 0 && --waits == 0)
                for (int i = 0; i < 110; i++)
                    put(&w, box_of(0.1f * (float)i, 1, 0, 0.1f * (float)i + 1, 2, 1), 0, MSAP_STATIC);
            if ((int)grid_of(&w)->renewal.next == step && !has_frozen && frame > 1) {
                for (uint32_t i = 110; i > 0; i--) take_away(&w, i);
                has_frozen = waits = 1;
            }
            end_frame(&w);
        }
        while (w.n > 700) take_away(&w, w.n - 1);
        end_frame(&w);
        right(session_close(&w.s));
    }
}
END_TEST

/* ----------------------------------------------------------------- all sorts */

static int compare_keys(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* No candidate comes twice, whichever of its boxes comes first. */
static void candidates_are_distinct(const walkers *w)
{
    static uint64_t key[420 * 419 / 2];
    const struct keys *all = &grid_of(w)->candidates;
    if (grid_of(w)->untold > 0) return; /* until the next commit */
    ck_assert_uint_le(all->n, COUNT(key));
    for (size_t i = 0; i < all->n; i++)
        key[i] = pair_key((uint32_t)(all->at[i] >> 32), near_slot((uint32_t)all->at[i]));
    qsort(key, all->n, sizeof *key, compare_keys);
    for (size_t i = 1; i < all->n; i++) ck_assert_uint_lt(key[i - 1], key[i]);
}

/* The scene is a few rows wide, and boxes as wide as several: two that lie at both ends of rows that wrapped
 * around would meet there twice. */
START_TEST(boxes_lie_in_all_rows)
{
    if (!chooses(_i)) return;
    walkers w;
    size_t most = 0;
    open_walk(&w, _i, 3, 6);
    for (uint32_t i = 0; i < 300; i++) {
        float x = (float)random_below(&w.s.random, 2000) / 100, y = (float)random_below(&w.s.random, 300) / 100;
        float z = (float)random_below(&w.s.random, 300) / 100, wide = i % 3 ? 0.5f : 2.5f;
        put(&w, box_of(x, y, z, x + 1, y + wide, z + wide), 0.04f, 0);
    }
    for (int frame = 0; frame < 50; frame++) {
        walk(&w, 0);
        end_frame(&w);
        candidates_are_distinct(&w);
        most = grid_of(&w)->candidates.n > most ? grid_of(&w)->candidates.n : most;
    }
    if (is_free(&w)) ck_assert_uint_gt(most, 300);
    right(session_close(&w.s));
}
END_TEST

/* Some boxes touch many rows; or so many do that there are no rows. */
static void walk_with_wide(int row, int wide)
{
    walkers w;
    open_walk(&w, row, 3, 7);
    put_some(&w, 900, 0.05f, 2);
    for (int i = 0; i < wide; i++) {
        float z = (float)i / 8;
        put(&w, box_of(-9, -9, z - 4, 29, 29, z + 4), 0.05f, 0);
    }
    for (int frame = 0; frame < 16; frame++) {
        walk(&w, 0);
        end_frame(&w);
        if (is_free(&w) && frame == 0) ck_assert_uint_eq(grid_of(&w)->wide_pruned, (size_t)wide);
        if (is_free(&w) && frame == 0) ck_assert_uint_eq(grid_of(&w)->wide_found, (size_t)wide);
    }
    if (is_free(&w)) ck_assert_int_eq(grid_of(&w)->in_skins, wide <= MOST_WIDE);
    right(session_close(&w.s));
}

START_TEST(wide_boxes_walk)
{
    if (!chooses(_i)) return;
    walk_with_wide(_i, 5);
    walk_with_wide(_i, 70);
    if (_i == DEFAULT) walk_with_wide(_i, MOST_WIDE + 20);
}
END_TEST

/* A slab through all rows. */
static box slab(walkers *w)
{
    float low = (float)random_below(&w->s.random, 1600) / 100;
    return box_of(low, -9, -9, low + 0.25f, 29, 29);
}

/* What happens to a slab before a step of a renewal: it goes, and another one comes in its slot, or a box that is
 * not wide; or it jumps; or it shrinks. */
static void happen_to_slab(walkers *w, uint32_t i)
{
    uint32_t what = random_below(&w->s.random, 8);
    if (what == 0) take_away(w, i);
    else if (what == 1) set(w, i, slab(w));
    else if (what == 2) set(w, i, cube(5, 6));
    if (what == 0 && w->n % 2) put(w, slab(w), 0.03f, w->n % 3 ? 0 : MSAP_STATIC);
    else if (what == 0) put_some(w, 1, 0.03f, 4);
}

/* Many boxes are wide, and get skins in steps with all others. Their candidates are found together with those of
 * others, and told when the skins change; meanwhile the slabs come, go, jump and shrink. */
START_TEST(wide_boxes_get_skins_in_steps)
{
    if (!chooses(_i)) return;
    walkers w;
    int changes = 0, with_wide = 0;
    open_walk(&w, _i, _i == DEFAULT ? 3 : 2 + (uint32_t)_i % 2, 12);
    for (int i = 0; i < 80; i++) put(&w, slab(&w), 0.03f, i % 8 ? 0 : MSAP_STATIC);
    put_some(&w, 300, 0.02f, 2);
    for (int i = 0; i < 40; i++) { /* where rows begin anew */
        float at = (float)i / 8;
        put(&w, box_of(at, at / 4 - 1, at / 8 - 0.75f, at + 1, at / 4, at / 8 + 0.25f), 0.02f, 0);
    }
    for (int frame = 0; frame < 40; frame++) {
        int changed = grid_of(&w)->renewal.next == CHANGE_SKINS;
        size_t wide = grid_of(&w)->renewal.pruning.n_wide;
        walk(&w, 0);
        for (uint32_t i = 0; i < 80 && frame > 3; i += 1 + random_below(&w.s.random, 20)) happen_to_slab(&w, i);
        end_frame(&w);
        if (frame % 8 == 0) candidates_are_distinct(&w);
        changes += changed && grid_of(&w)->upkeep.since < grid_of(&w)->commit;
        with_wide += changed && wide > 20;
    }
    if (is_free(&w)) ck_assert(changes >= 2 && with_wide >= 1);
    right(session_close(&w.s));
}
END_TEST

/* Giants meet most others, so their pairs are many however long skins last: these last long, and no commit takes a
 * renewal of all. */
START_TEST(giants_do_not_shorten_skins)
{
    walkers w;
    int at_once = 0;
    open_walk(&w, DEFAULT, 3, 15);
    w.turn = 1000;
    put_some(&w, 900, 0.02f, 0);
    for (int i = 0; i < 70; i++) {
        float x = (float)random_below(&w.s.random, 80) / 10;
        put(&w, box_of(x, x / 2, 0, x + 8, x / 2 + 8, 8), 0.02f, 0);
    }
    for (int frame = 0; frame < 60; frame++) {
        walk(&w, 0);
        end_frame(&w);
        at_once += frame > 0 && grid_of(&w)->upkeep.since == grid_of(&w)->commit;
        ck_assert(grid_of(&w)->in_skins);
    }
    ck_assert_int_eq(at_once, 0);
    ck_assert_uint_gt(grid_of(&w)->wide_found, 64);
    right(session_close(&w.s));
}
END_TEST

static int is_renewing(walkers *w) { return grid_of(w)->renewal.next != NO_RENEWAL; }

/* When most boxes stop, all rest as they are, whether or not new skins are being made; when they walk on, they get
 * skins; and when they jump, nothing is kept but for a while. */
START_TEST(boxes_stop_and_walk_on)
{
    if (!chooses(_i)) return;
    walkers w;
    open_walk(&w, _i, 3, 8);
    put_some(&w, 400, 0.02f, 0);
    for (int round = 0; round < 2; round++) {
        for (int frame = 0; frame < (round == 0 ? 30 : 90); frame++) { /* then skins are tried before */
            walk(&w, 0);
            end_frame(&w);
        }
        if (is_free(&w)) ck_assert(grid_of(&w)->in_skins);
        for (int frame = 0; is_free(&w) && round == 0 && !is_renewing(&w); frame++) {
            ck_assert_int_lt(frame, 100);
            walk(&w, 0);
            end_frame(&w);
        }
        for (int frame = 0; frame < 12; frame++) {
            set(&w, (uint32_t)frame, w.bounds[50 + frame]);
            end_frame(&w);
            if (!is_free(&w) || frame < 5) continue;
            ck_assert(grid_of(&w)->is_resting && !grid_of(&w)->in_skins && !is_renewing(&w));
            ck_assert_uint_eq(grid_of(&w)->candidates.n, 0);
        }
        for (int frame = 0; frame < 3; frame++) {
            happen(&w, ALL_JUMP);
            end_frame(&w);
        }
        if (is_free(&w)) ck_assert(!grid_of(&w)->is_resting);
    }
    right(session_close(&w.s));
}
END_TEST

/* Most boxes stop while some are in cells, wide ones and such as have left their skins: those get lists. Then
 * some come, some walk and, at first not, some go, among them such as are in cells. Loop variable: a set-up, and whether
 * boxes stop after the first commit or later. */
START_TEST(boxes_in_cells_get_lists)
{
    int row = _i / 2, later = _i % 2;
    if (!chooses(row)) return;
    int with_lists = 0;
    walkers w;
    open_walk(&w, row, 3, 14);
    for (int i = 0; i < 5; i++) put(&w, box_of(-9, -9, (float)i - 4, 29, 29, (float)i), 0.02f, 0);
    put_some(&w, 500, 0.02f, 2);
    for (int frame = 0; frame < (later ? 20 : 1); frame++) {
        walk(&w, 0);
        if (frame == 12) happen(&w, JUMP);
        end_frame(&w);
    }
    for (int frame = 0; frame < 40; frame++) {
        set(&w, 5, w.bounds[6 + frame]);
        if (frame % 4 == 1) set(&w, 300 + (uint32_t)frame, w.bounds[7 + frame]);
        if (frame % 3 == 2) put_some(&w, 1, 0, 0);
        if (frame == (later ? 4 : 0)) take_away(&w, 4 * (uint32_t)(row % 2) + 40 * (uint32_t)(row % 3)); /* when lists would be made */
        if (frame > 9) take_away(&w, frame % 8 == 7 ? 0 : random_below(&w.s.random, w.n - 60) + 50);
        end_frame(&w);
        with_lists += grid_of(&w)->is_resting && !grid_of(&w)->in_skins && grid_of(&w)->rows_hold_skins;
    }
    if (is_free(&w)) ck_assert_int_ge(with_lists, 8);
    right(session_close(&w.s));
}
END_TEST

/* Each allocation of the commits in which boxes in cells get lists fails once, as above. */
START_TEST(lists_without_memory)
{
    if (!chooses(_i)) return;
    size_t failures = 1;
    for (size_t n = 1; failures > 0; n++) {
        walkers w;
        open_walk(&w, _i, 3, 15);
        for (int i = 0; i < 4; i++) put(&w, box_of(-9, -9, (float)i - 4, 29, 29, (float)i), 0.04f, 0);
        put_some(&w, 340, 0.04f, 2); /* fewer are in one row, and none is wide */
        end_frame(&w);
        w.s.memory.fail_at = w.s.memory.calls + n;
        for (uint32_t frame = 0; frame < 4; frame++) {
            set(&w, frame, w.bounds[frame + 1]);
            set(&w, frame + 9, w.bounds[frame + 30]);
            end_frame(&w);
        }
        failures = w.s.memory.failures;
        right(session_close(&w.s));
    }
}
END_TEST

/* Boxes that come and go but do not move get no skins: a level is loaded, half of it goes, more of it comes. */
START_TEST(who_does_not_move_needs_no_skin)
{
    walkers w;
    if (!chooses(_i)) return;
    open_walk(&w, _i, 3, 13);
    put_some(&w, 800, 0.05f, 11);
    end_frame(&w);
    for (int i = 0; i < 400; i++) take_away(&w, random_below(&w.s.random, w.n));
    end_frame(&w);
    ck_assert(!grid_of(&w)->in_skins);
    put_some(&w, 400, 0.05f, 11);
    end_frame(&w);
    ck_assert(!grid_of(&w)->in_skins);
    right(session_close(&w.s));
}
END_TEST

/* Trimmed between the steps, or emptied. */
START_TEST(memory_is_given_back_between_the_steps)
{
    if (!chooses(_i)) return;
    for (int step = NO_RENEWAL; step <= CHANGE_SKINS; step++) {
        walkers w;
        open_walk(&w, _i, 3, 9);
        put_some(&w, 300, 0.05f, 2);
        for (int frame = 0; frame < 40; frame++) {
            walk(&w, 0);
            end_frame(&w);
            if ((int)grid_of(&w)->renewal.next == step && frame % 3 == 1) right(session_trim(&w.s));
            if ((int)grid_of(&w)->renewal.next == step && frame == 25)
                while (w.n > 0) take_away(&w, w.n - 1);
        }
        right(session_close(&w.s));
    }
}
END_TEST

enum { AT_ONCE, LATER, SPARSE, TURNING, WITH_MORE, WITH_WIDE, WALKS };

/* Boxes walk by up to `step`, and the n-th allocation fails, from the commit on in which all come and are put in
 * skins; or from the next one on: then few may overlap; they may turn soon, so that the skins to come do not suit them
 * any more; or more may come in each commit; or, from the start, some are wide. Returns whether there was such an
 * allocation. */
static size_t walk_without_memory(int row, float step, int how, size_t n)
{
    const uint32_t size[2][3] = {{16, 12, 8}, {48, 36, 24}};
    const int boxes = how == WITH_WIDE ? 340 : 260; /* fewer are in one row */
    walkers w;
    open_walk(&w, row, 3, 10);
    for (int i = 0; i < boxes; i++) put(&w, in_block(&w, size[how == SPARSE]), step, i % 8 ? 0 : MSAP_STATIC);
    for (int i = 0; how == WITH_WIDE && i < 12; i++) put(&w, slab(&w), step, i % 8 ? 0 : MSAP_STATIC);
    walk(&w, 0);
    if (how != AT_ONCE && how != WITH_WIDE) end_frame(&w);
    if (how == TURNING) w.turn = 3;
    w.s.memory.fail_at = w.s.memory.calls + n;
    for (int frame = 0; frame < 15; frame++) {
        struct grid *g = &w.s.world->grid;
        if (how == WITH_MORE) put_some(&w, 12, step, 2);
        if (how >= WITH_MORE && frame == 2) g->layout[g->current].chosen_for = 1; /* and cells suit no more */
        if (how == LATER && g->renewal.next == NO_RENEWAL) msap_renewal_free(&g->renewal, &w.s.world->memory);
        walk(&w, 0);
        end_frame(&w);
    }
    size_t failures = w.s.memory.failures;
    if (how == WITH_WIDE && is_free(&w) && failures == 0) ck_assert_uint_gt(grid_of(&w)->wide_pruned, 0);
    right(session_close(&w.s));
    return failures;
}

/* In each commit of a renewal, at once or in steps, each allocation fails once; the commit fails or not, and nothing
 * is lost. */
START_TEST(without_memory)
{
    static const float step[] = {0.08f, 0.05f, 0.01f};
    if (!chooses(_i) || setups[_i].simd) return; /* vectors take no memory */
    for (size_t k = 0; k < COUNT(step); k++)
        for (int how = AT_ONCE; how < (_i == DEFAULT ? WALKS : SPARSE); how++)
            for (size_t n = 1; walk_without_memory(_i, step[k], how, n) > 0;) n++;
}
END_TEST

/* While all boxes are pruned more come, and skins are to be tried: the n-th allocation fails. Returns whether there
 * was one. */
static size_t try_without_memory(size_t n)
{
    walkers w;
    open_walk(&w, DEFAULT, 3, 18);
    put_some(&w, 260, 3, 0);
    walk_on(&w, 6);
    ck_assert(grid_of(&w)->is_jumping);
    put_some(&w, 500, 3, 0);
    w.s.world->grid.upkeep.not_before = 0;
    w.s.memory.fail_at = w.s.memory.calls + n;
    walk_on(&w, 6);
    size_t failures = w.s.memory.failures;
    right(session_close(&w.s));
    return failures;
}

START_TEST(a_trial_without_memory)
{
    for (size_t n = 1; try_without_memory(n) > 0;) n++;
}
END_TEST

/* ------------------------------------------------------------------ choosing */

/* Boxes that drift where few overlap, until they have been in the same skins for so many commits or more. */
static void drift_for(walkers *w, uint32_t n, uint32_t commits)
{
    const uint32_t size[3] = {22, 22, 10};
    const struct grid *g = grid_of(w);
    w->turn = 1000;
    for (uint32_t i = 0; i < n; i++) put(w, in_block(w, size), 0.025f, 0);
    for (int frame = 0; frame < 100; frame++) {
        walk(w, 0);
        end_frame(w);
        if (!g->upkeep.is_first && g->commit - g->upkeep.since >= commits && g->renewal.next == NO_RENEWAL) return;
    }
    ck_abort_msg("skins did not last");
}

/* Skins that lasted long are left by a third of the boxes in one commit. */
START_TEST(long_skins_are_left_at_once)
{
    const uint32_t size[3] = {22, 22, 10};
    walkers w;
    open_walk(&w, DEFAULT, 3, 19);
    drift_for(&w, 1000, 14);
    for (uint32_t i = 0; i < w.n; i += 3) set(&w, i, in_block(&w, size));
    end_frame(&w);
    ck_assert_uint_ge(grid_of(&w)->moves, w.n); /* all are pruned */
    walk_on(&w, 8);
    right(session_close(&w.s));
}
END_TEST

/* Where few boxes are left there are no skins any more, whether these have paid or not. */
START_TEST(few_are_left)
{
    static const float step[] = {0.15f, 0.02f};
    for (size_t k = 0; k < COUNT(step); k++) {
        walkers w;
        open_walk(&w, DEFAULT, 3, 20);
        put_some(&w, 300, step[k], 0);
        for (int frame = 0; frame < 60; frame++) {
            walk(&w, 0);
            if (frame == 20)
                while (w.n > 240) take_away(&w, w.n - 1);
            end_frame(&w);
        }
        ck_assert(!grid_of(&w)->in_skins);
        right(session_close(&w.s));
    }
}
END_TEST

/* Skins that lasted are to be left soon: all get new ones if that has paid; if boxes that left them have cost more
 * than to prune all, none does for a while; and if they have cost very much, one commit more does not matter. */
START_TEST(skins_that_have_not_paid)
{
    int begun = 0, given_up = 0, ignored = 0;
    for (int64_t spent = 400000; spent <= 2400000; spent += 100000) {
        walkers w;
        open_walk(&w, DEFAULT, 3, 21);
        drift_for(&w, 1000, 26);
        struct grid *g = &w.s.world->grid;
        for (int i = 0; i < 1000; i++)
            for (int k = 0; k < 3; k++) w.step[i][k] *= 4;
        g->upkeep.spent = spent;
        g->upkeep.wait = 0;
        uint32_t since = g->upkeep.since;
        for (int frame = 0; frame < 3 && g->renewal.next == NO_RENEWAL && g->upkeep.wait == 0; frame++) {
            walk(&w, 0);
            end_frame(&w);
        }
        begun += g->renewal.next != NO_RENEWAL || g->upkeep.since != since;
        given_up += g->upkeep.wait > 0;
        ignored += g->renewal.next == NO_RENEWAL && g->upkeep.since == since && g->upkeep.wait == 0;
        right(session_close(&w.s));
    }
    ck_assert_msg(begun > 0 && given_up > 0 && ignored > 0, "%d, %d, %d", begun, given_up, ignored);
}
END_TEST

/* How skins would do is estimated from the boxes in some slots: there may be none in these. */
START_TEST(no_box_is_asked_about_skins)
{
    enum { ASKED = MOST / 32 + 1 /* one slot in so many */ };
    walkers w;
    open_walk(&w, DEFAULT, 3, 22);
    put_some(&w, MOST, 0.05f, 0);
    walk(&w, 0);
    end_frame(&w);
    for (uint32_t i = w.n; i-- > 0;)
        if ((w.handles[i] >> 32) % ASKED == 0) take_away(&w, i);
    walk_on(&w, 20);
    right(session_close(&w.s));
}
END_TEST

/* A skin reaches to infinity at the most, of boxes in the last places before it, too. */
START_TEST(skins_end_at_infinity)
{
    enum { FARTHEST_OUT = 0x7f7fffff };
    float most;
    uint32_t bits = FARTHEST_OUT;
    walkers w;
    memcpy(&most, &bits, sizeof most);
    open_walk(&w, _i, 3, 26);
    put_some(&w, 320, 0.02f, 2);
    put(&w, box_of(most, most, most, most, most, most), 0, 0);
    put(&w, box_of(-most, -most, -most, -most, -most, -most), 0, 0);
    put(&w, box_of(0, -most, 0, 1, most, 1), 0, 0);
    walk_on(&w, 30);
    right(session_close(&w.s));
}
END_TEST

/* Boxes that move by next to nothing and leave their margins all the same: how far motion is thought to deceive has
 * a limit. */
START_TEST(motion_says_next_to_nothing)
{
    enum { LONELY = 250, GROUP = 24, STEPS = 11, MOST_DOUBT = 256 };
    uint32_t doubt = 0;
    walkers w;
    open_walk(&w, DEFAULT, 3, 25);
    w.s.world->config.margin = 1;
    for (int i = 0; i < LONELY; i++) {
        float x = (float)(8 * (i % 16)), y = (float)(8 * (i / 16));
        put(&w, box_of(x, y, 0, x + 1, y + 1, 1), 0, 0);
    }
    end_frame(&w);
    for (int step = 0; step < 2 * STEPS; step++) {
        for (uint32_t i = 0; i < LONELY; i++) { /* all go nearly to the ends, then one group after the other beyond */
            int first = step % STEPS == 0, leaves = (int)i / GROUP == step % STEPS - 1;
            box b = w.bounds[i];
            if (step > STEPS && !leaves) continue; /* before, all move: then nobody knows who sets out */
            b.min[2] += first ? 0.999f : leaves ? 0.002f : 0.000001f;
            b.max[2] += first ? 0.999f : leaves ? 0.002f : 0.000001f;
            set(&w, i, b);
        }
        end_frame(&w);
        doubt = grid_of(&w)->doubt > doubt ? grid_of(&w)->doubt : doubt;
    }
    ck_assert_uint_eq(doubt, MOST_DOUBT);
    right(session_close(&w.s));
}
END_TEST

/* Far away, where a step is a few units in the last place. */
START_TEST(boxes_crawl)
{
    walkers w;
    open_walk(&w, _i, 3, 23);
    for (int i = 0; i < 320; i++) {
        const uint32_t size[3] = {16, 12, 8};
        box b = in_block(&w, size);
        for (int k = 0; k < 3; k++) {
            b.min[k] = 16777216 + 64 * b.min[k];
            b.max[k] = b.min[k] + 64;
        }
        put(&w, b, 2, 0);
    }
    walk_on(&w, 60);
    right(session_close(&w.s));
}
END_TEST

/* Boxes far from the origin, each of which takes a step of one unit in the last place in some commits: one commit does
 * not tell how fast they are, so they keep their first skins until more does. */
START_TEST(first_skins_wait_for_those_who_crawl)
{
    enum { KNOWN = 8, ULP = 2 };
    const uint32_t size[3] = {16, 12, 8};
    walkers w;
    open_walk(&w, DEFAULT, 3, 31);
    for (int i = 0; i < 320; i++) {
        box b = in_block(&w, size);
        for (int k = 0; k < 3; k++) {
            b.min[k] = 16777216 + ULP * (float)(int)(32 * b.min[k]);
            b.max[k] = b.min[k] + 64;
        }
        put(&w, b, 1, 0);
    }
    for (int frame = 0; frame < 30; frame++) {
        for (uint32_t i = 0; i < w.n; i++) {
            box b = w.bounds[i];
            for (int k = 0; k < 3; k++) {
                float now = (float)(int)((float)(frame + 1) * w.step[i][k]), before = (float)(int)((float)frame * w.step[i][k]);
                b.min[k] += ULP * (now - before);
                b.max[k] += ULP * (now - before);
            }
            set(&w, i, b);
        }
        end_frame(&w);
        ck_assert(grid_of(&w)->in_skins);
        if (frame < KNOWN) ck_assert(grid_of(&w)->upkeep.is_first && grid_of(&w)->renewal.next == NO_RENEWAL);
        else if (frame == KNOWN) ck_assert(grid_of(&w)->upkeep.is_first && grid_of(&w)->renewal.next != NO_RENEWAL);
    }
    ck_assert(!grid_of(&w)->upkeep.is_first);
    right(session_close(&w.s));
}
END_TEST

/* However often skins have not paid, they are tried again one day. */
START_TEST(all_is_tried_again)
{
    walkers w;
    open_walk(&w, DEFAULT, 3, 17);
    struct grid *g = &w.s.world->grid;
    for (int i = 0; i < 40; i++) {
        uint32_t wait = g->upkeep.wait;
        msap_renewal_failed(g);
        ck_assert_uint_ge(g->upkeep.wait, wait);
        ck_assert(g->upkeep.not_before > g->commit && g->upkeep.not_before - g->commit <= 4096);
    }
    right(session_close(&w.s));
}
END_TEST

/* Memory that holds the number *user over and over. */
static void *junk_alloc(void *user, size_t bytes)
{
    uint16_t *memory = malloc(bytes + 1);
    for (size_t i = 0; memory && i < (bytes + 1) / 2; i++) memory[i] = *(const uint16_t *)user;
    return memory;
}

static void junk_free(void *user, void *memory, size_t bytes)
{
    (void)user;
    (void)bytes;
    free(memory);
}

/* Boxes jump about, some of them wide, more come, then all walk but for a few, which jump, and still more come. Gives
 * what each commit looked at. */
static void jump_and_walk(uint64_t seed, uint16_t junk, uint64_t touched[60], uint64_t candidates[60])
{
    static box bounds[430];
    static msap_handle names[430];
    const uint32_t size[3] = {16, 12, 8};
    msap_config config = config_of(3, DEFAULT);
    walkers w;
    msap_world *world;
    w.s.random = seed;
    config.alloc = junk_alloc;
    config.free = junk_free;
    config.allocator_user = &junk;
    memset(names, 0, sizeof names);
    ok(msap_create(&config, &world));
    for (int frame = 0; frame < 60; frame++) {
        uint32_t n = frame < 4 ? 330 : frame < 20 ? 400 : 400 + (uint32_t)(frame - 19) / 2;
        for (uint32_t i = 0; i < n; i++) {
            int is_new = names[i] == MSAP_NULL_HANDLE, jumps = frame < 8 || random_below(&w.s.random, 50) == 0;
            if (is_new || jumps) bounds[i] = in_block(&w, size);
            if (i < 3) bounds[i].max[0] = bounds[i].max[1] = bounds[i].max[2] = 99;
            for (int k = 0; k < 3 && !jumps; k++) {
                bounds[i].min[k] += 0.01f * (float)((int)i % (3 + k) - 1);
                bounds[i].max[k] += 0.01f * (float)((int)i % (3 + k) - 1);
            }
            if (is_new) names[i] = add(world, bounds[i]);
            else update(world, names[i], bounds[i]);
        }
        ok(msap_commit(world, NULL, NULL));
        touched[frame] = stats_of(world).touched;
        candidates[frame] = stats_of(world).candidates;
    }
    ok(msap_destroy(world));
}

/* What skins boxes get never depends on what memory held. */
START_TEST(junk_in_memory_means_nothing)
{
    uint64_t touched[2][60], candidates[2][60];
    for (uint64_t seed = 1; seed <= 60; seed++) {
        jump_and_walk(seed, 40000, touched[0], candidates[0]);
        jump_and_walk(seed, (uint16_t)seed, touched[1], candidates[1]);
        ck_assert(memcmp(touched[0], touched[1], sizeof touched[0]) == 0);
        ck_assert(memcmp(candidates[0], candidates[1], sizeof candidates[0]) == 0);
    }
}
END_TEST

/* ------------------------------------------------------------------ checking */

/* The validator sees what is wrong with candidates. */
START_TEST(broken_candidates)
{
    walkers w;
    open_walk(&w, DEFAULT, 3, 11);
    put_some(&w, 400, 0.05f, 4);
    walk_on(&w, 8);
    uint32_t gone = (uint32_t)(w.handles[7] >> 32);
    take_away(&w, 7);
    end_frame(&w);
    struct grid *g = &w.s.world->grid;
    uint64_t *c = g->candidates.at, was = *c;
    struct inner_box *p = &g->boxes->at[was >> 32], *q = &g->boxes->at[near_slot((uint32_t)was)];
    ck_assert(g->in_skins);
    *c ^= NEAR_PAIR;
    is_broken(w.s.world, "a candidate is wrong about a pair");
    *c = was;
    size_t last = g->candidates.n - 1, pair = 0;
    while (!(c[pair] & NEAR_PAIR)) ck_assert_uint_lt(pair++, last);
    uint64_t one = c[pair];
    c[pair] = c[last];
    g->candidates.n--;
    is_broken(w.s.world, "a pair are no candidates");
    g->candidates.n++;
    c[pair] = one;
    g->near.of[0].n = 1;
    is_broken(w.s.world, "a box in a skin has a list");
    g->near.of[0].n = 0;
    uint16_t flags[2] = {p->flags, q->flags};
    size_t live_static = g->boxes->live_static;
    p->flags = (uint16_t)(flags[0] | BOX_STATIC);
    q->flags = (uint16_t)(flags[1] | BOX_STATIC);
    g->boxes->live_static += (p->flags != flags[0]) + (q->flags != flags[1]);
    is_broken(w.s.world, "two static boxes are candidates");
    g->boxes->live_static = live_static;
    p->flags = flags[0];
    q->flags = flags[1];
    *c = (uint64_t)g->boxes->used << 32 | (uint32_t)was;
    is_broken(w.s.world, "a candidate is not in the grid");
    *c = (was & ~(uint64_t)0x7fffffff) | g->boxes->used;
    is_broken(w.s.world, "a candidate is not in the grid");
    *c = (uint64_t)gone << 32 | (uint32_t)was;
    is_broken(w.s.world, "a candidate is not in the grid");
    *c = (was & ~(uint64_t)0x7fffffff) | gone;
    is_broken(w.s.world, "a candidate is not in the grid");
    *c = (was & 0xffffffff) | (uint64_t)0 << 32;
    for (uint32_t i = 0; i < g->boxes->used; i++)
        if (rests(g, &g->boxes->at[i]) && !overlap(&g->boxes->at[i].fat, &q->fat) &&
            !(g->boxes->at[i].flags & BOX_STATIC))
            *c = (uint64_t)i << 32 | (uint32_t)was;
    is_broken(w.s.world, "the skins of candidates do not overlap");
    *c = was;
    right(session_compare(&w.s));
    right(session_close(&w.s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("renewing");
    tcase_add_loop_test(tests, all_walk, 0, SETUPS);
    tcase_add_loop_test(tests, some_are_in_a_hurry, 0, SETUPS);
    tcase_add_test(tests, sparse_boxes_drift);
    tcase_add_loop_test(tests, giants_go, 0, SETUPS);
    tcase_add_loop_test(tests, all_happens_between_the_steps, 0, SETUPS);
    tcase_add_loop_test(tests, all_happens_in_a_trial, 0, SETUPS);
    tcase_add_loop_test(tests, all_happens_at_once, 0, SETUPS);
    tcase_add_loop_test(tests, slots_are_given_out_again, 0, SETUPS);
    tcase_add_loop_test(tests, boxes_freeze, 0, SETUPS);
    tcase_add_loop_test(tests, boxes_lie_in_all_rows, 0, SETUPS);
    tcase_add_loop_test(tests, wide_boxes_walk, 0, SETUPS);
    tcase_add_loop_test(tests, wide_boxes_get_skins_in_steps, 0, SETUPS);
    tcase_add_test(tests, giants_do_not_shorten_skins);
    tcase_add_loop_test(tests, boxes_stop_and_walk_on, 0, SETUPS);
    tcase_add_loop_test(tests, boxes_in_cells_get_lists, 0, 2 * SETUPS);
    tcase_add_loop_test(tests, lists_without_memory, 0, SETUPS);
    tcase_add_loop_test(tests, who_does_not_move_needs_no_skin, 0, SETUPS);
    tcase_add_loop_test(tests, memory_is_given_back_between_the_steps, 0, SETUPS);
    tcase_add_loop_test(tests, without_memory, 0, SETUPS);
    tcase_add_test(tests, a_trial_without_memory);
    tcase_add_test(tests, long_skins_are_left_at_once);
    tcase_add_test(tests, few_are_left);
    tcase_add_test(tests, skins_that_have_not_paid);
    tcase_add_test(tests, no_box_is_asked_about_skins);
    tcase_add_loop_test(tests, skins_end_at_infinity, 0, SETUPS);
    tcase_add_test(tests, motion_says_next_to_nothing);
    tcase_add_loop_test(tests, boxes_crawl, 0, SETUPS);
    tcase_add_test(tests, first_skins_wait_for_those_who_crawl);
    tcase_add_test(tests, all_is_tried_again);
    tcase_add_test(tests, junk_in_memory_means_nothing);
    tcase_add_test(tests, broken_candidates);
    return run_case(tests, "renewing");
}
