/* Choosing how a Multi-SAP's commit goes: boxes put elsewhere one by one (track.c), all
 * cells and lists made anew (rebuild.c), or all boxes pruned and nothing kept (jump.c) but
 * the rows, in which they rest if few of them move then (rest.c); and whether all get new
 * skins in it or after it (renew.c).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * What each way costs is estimated from counts alone, so that every run can be repeated.
 * The unit is the test of a neighbour, some 2 nanoseconds; the weights are from recorded
 * scenes and made ones, and bench/strategies measures them on others (but for those of a renewal, which
 * are from the times of its steps, CALM_BOX, which is from the times of some commits, and RESTLESS_ROW, which
 * is estimated). What an event costs is much the same in all ways and stands in none.
 *
 * Cells and lists pay over many commits or not at all, and to make them is dear. So it is
 * done as one who skis for an unknown number of days should rent or buy: they are made
 * when they would have saved as much as that costs, and given up when they have lost
 * half of it. What they would save is told from how the boxes move.
 * Boxes that turn and tremble move more often than that says: how much more, when lists
 * last lost so much, is remembered, and little by little forgotten. If motion says that
 * lists will pay once all boxes have a skin for it, they are kept. (To make all anew then
 * would cost less, but all in one commit.)
 *
 * When so many boxes leave their places in one commit that it is cheaper to make all anew,
 * that is done if cells and lists have paid since they were made and will, or else all is
 * pruned.
 *
 * Renewals take the place of cells in worlds of 256 boxes or more, unless many boxes are wide. A world is
 * put into skins when it is loaded, before any motion is known, and into others as soon as it is: where most
 * boxes crawl that takes some commits. From then on skins are renewed when one more commit with the
 * present ones would cost more than they have cost in each so far, their renewal included: sooner, and
 * each commit would pay more for renewals; later, and each would pay more for boxes that leave. Skins that
 * last long are renewed in steps, before boxes leave them, which is told from how some of them move. Where
 * boxes turn and tremble, skins last a few commits; then all get new ones in the commit in which that is
 * due, unless that should take more than two and a half times as long as to prune all. When skins have
 * been dearer than to prune all in every commit, that is done for a while, and for twice as long after the
 * next time. Then some boxes get skins for a trial, and if few leave them, and skins promise to save a
 * quarter, all do.
 *
 * When few boxes move, the others rest as they are: at once, where that costs less than a pruning even if all
 * that move leave their places, or when it would have saved as much as it costs. If those that move are too
 * wild for that, and mostly the same again and again, only they are pruned (restless.c). Those of them that stand
 * still by then are calmed (calm.c) when they have cost as much as that does. How many others join them is told
 * from some that changed in the last commit.
 *
 * Boxes that are not static will move, and it is better that they have cells and neighbours
 * by then; but to make these for all boxes would be in vain where most are static. So a world of
 * static boxes for the most part is pruned when it is loaded, and so is all of it when many more
 * come while boxes rest; those that are not static, if they are few, leave the rows at once. */
#include "internal.h"

enum {
    TRACK_MOVE = 440,       /* a box that is put elsewhere, */
    TRACK_NEIGHBOUR = 10,   /* and each of its neighbours, */
    TRACK_SEARCH = 8,       /* and, of so many, each in the list of each other */
    TRACK_LEAVE = 90,       /* a box that leaves */
    STRAY_MOVE = 360,       /* a box in a skin that is put elsewhere, */
    STRAY_CANDIDATE = 10,   /* and each of its candidates */
    JUMP_BOX = 16,          /* a box when all are pruned, */
    JUMP_BOX_IN_LINE = 11,  /* or, where rows lie in a line, as in two dimensions, */
    JUMP_PAIR = 5,          /* and a pair; */
    WIDE_BOX = 4,           /* in one test a wide box is tested against so many others */
    RESTLESS_BOX = 48,      /* a box that is pruned while others are not, */
    RESTLESS_ROW = 8,       /* and a row, */
    KNOWN_PAIR = 2,         /* and a known pair */
    CALM_BOX = 8,           /* a box when some are put into the rows of all */
    REBUILD_BOX = 43,       /* a box when all is made anew, */
    REBUILD_NEIGHBOUR = 12, /* and a pair of neighbours */
    SKIN_BOX = 2,           /* a box while it is in its skin, */
    CANDIDATE = 1,          /* and a candidate */
    RENEW_BOX = 48,         /* a box when all get new skins, */
    RENEW_CANDIDATE = 3     /* and a candidate */
};

/* On recorded scenes neighbours are one and a half to five times as many as pairs, mostly twice. */
enum { NEIGHBOURS_A_PAIR = 2 };

enum { ONE = 16, MOST_DOUBT = 16 * ONE, FORGETTING = 32 };

/* What the ways cost, in tests. */
struct costs {
    int64_t track, jump, rebuild;
};

/* How much dearer it is to look up one box after another, in sixteenths, where there are so many that
 * they outgrow one cache after the other. To prune all is to read them in order, which is less so. */
static int64_t dearness(size_t boxes)
{
    int64_t more = 0;
    for (; boxes > 4 * MANY_BOXES; boxes /= 2) more += ONE / 2;
    if (boxes > 2 * MANY_BOXES) more += (int64_t)(boxes - 2 * MANY_BOXES) * (ONE / 4) / MANY_BOXES;
    return ONE + more;
}

/* What it costs to keep track of the boxes that changed if so many of them must be put elsewhere
 * and so many leave. */
static int64_t cost_of_tracking(const struct job *job, int64_t moves, int64_t leaving)
{
    int64_t boxes = (int64_t)job->boxes->live + 1, changed = (int64_t)job->boxes->n_changed;
    int64_t near = NEIGHBOURS_A_PAIR * (int64_t)job->pairs->active, of_a_box = 2 * near / boxes;
    if (of_a_box > boxes) of_a_box = boxes; /* most others have just been removed */
    int64_t tests = near * changed / boxes + leaving * TRACK_LEAVE +
                    moves * (TRACK_MOVE + of_a_box * (TRACK_NEIGHBOUR + of_a_box / TRACK_SEARCH));
    return tests * dearness((size_t)boxes) / ONE;
}

/* Whether wide boxes have been counted lately: those that were there long ago may have gone. */
static int are_wide_known(const struct grid *g)
{
    enum { LONG_AGO = 256 };
    return g->commit - g->wide_found_in < LONG_AGO;
}

/* How many boxes are wide, and how many with skins, as far as is known. */
static int64_t count_wide(const struct grid *g) { return are_wide_known(g) ? (int64_t)g->wide_found : 0; }
static int64_t count_wide_skins(const struct grid *g) { return are_wide_known(g) ? (int64_t)g->wide_pruned : 0; }

static struct costs costs_of(const struct grid *g, const struct job *job)
{
    int64_t boxes = (int64_t)job->boxes->live, pairs = (int64_t)job->pairs->active;
    int64_t jump_box = (g->rows.count[1] == 1 ? JUMP_BOX_IN_LINE : JUMP_BOX) + count_wide(g) / WIDE_BOX;
    struct costs c = {0, boxes * jump_box + pairs * JUMP_PAIR,
                      boxes * REBUILD_BOX + pairs * NEIGHBOURS_A_PAIR * REBUILD_NEIGHBOUR};
    return c;
}

/* Whether what should cost so much in each commit, instead of to prune all, promises enough to begin with it: that
 * takes a commit which is dear, and foresight is no more than that. */
static int promises(int64_t upkeep, int64_t jump) { return 4 * upkeep < 3 * jump; }

/* ----------------------------------------------------------- pruning a few */

/* After a commit, while its changed boxes are still listed: some of them are watched, but where most change. */
void msap_watch(struct grid *g)
{
    const struct box_table *t = g->boxes;
    struct watch *w = &g->watch;
    size_t step = t->n_changed / MOST_WATCHED + 1;
    w->n = 0;
    w->of = 2 * t->n_changed <= t->live ? t->n_changed : 0;
    for (size_t i = 0; i < w->of; i += step) w->slot[w->n++] = t->changed[i];
}

/* How many boxes change that did not in the last commit: estimated from those that are watched or, while some are
 * restless, how many joined them in the last one. Where none is watched, nothing is known, and none is expected. */
size_t msap_count_newcomers(const struct grid *g)
{
    const struct box_table *t = g->boxes;
    const struct watch *w = &g->watch;
    size_t again = 0;
    if (g->restless.n > 0) return g->restless.newcomers;
    for (size_t i = 0; i < w->n; i++) again += box_is_changed(t, w->slot[i]);
    if (w->n == 0) return 0;
    again = again * w->of / w->n;
    return again < t->n_changed ? t->n_changed - again : 0;
}

/* What it costs to prune so many boxes, wide ones, and no others. */
static int64_t cost_of_restless(const struct grid *g, const struct job *job, int64_t n)
{
    int64_t of_wide = (int64_t)job->boxes->live * count_wide(g) / WIDE_BOX;
    int64_t rows = (int64_t)g->rows.count[0] * g->rows.count[1];
    return n * RESTLESS_BOX + rows * RESTLESS_ROW + of_wide + (int64_t)job->pairs->active * KNOWN_PAIR;
}

/* What it costs to put those that stand still into the rows of the others (calm.c). */
static int64_t cost_of_calming(const struct job *job) { return (int64_t)job->boxes->live * CALM_BOX; }

/* What a commit would cost if those boxes alone that change were pruned over and over, and those that stand still by
 * then with them until they are calmed: when that is done best. */
static int64_t cost_of_a_few(const struct grid *g, const struct job *job)
{
    enum { LONGEST = 6 };
    int64_t idle = (int64_t)msap_count_newcomers(g) * RESTLESS_BOX, most = INT64_MAX;
    for (int k = 0; k <= LONGEST; k++) { /* in every 2^k-th commit */
        int64_t more = idle * ((1 << k) - 1) / 2 + (cost_of_calming(job) >> k);
        if (more < most) most = more;
    }
    return cost_of_restless(g, job, (int64_t)job->boxes->n_changed) + most;
}

/* What it costs to prune what must be: all or, where it is known that this is less, a few. */
static int64_t cost_of_pruning(const struct grid *g, const struct job *job, const struct costs *c)
{
    int is_known = g->watch.n > 0 || g->restless.n > 0;
    int64_t few = is_known ? cost_of_a_few(g, job) : c->jump;
    return few < c->jump ? few : c->jump;
}

/* ------------------------------------------------------------------ foresight */

/* How many boxes would be put elsewhere in each commit if all moved on as in this one and
 * had their skins: estimated from some of the changed boxes, others in each commit. Those that come do not
 * count: who knows whether they will move. */
static double foreseen_moves(const struct grid *g)
{
    enum { SAMPLES = 16 };
    const struct box_table *t = g->boxes;
    size_t step = t->n_changed / SAMPLES + 1;
    double moves = 0;
    for (size_t i = g->commit % step; i < t->n_changed; i += step) {
        const struct box *b = &t->at[t->changed[i]];
        if ((b->flags & (BOX_LIVE | BOX_WAS)) == (BOX_LIVE | BOX_WAS))
            moves += 1.0 / (double)msap_skin_lifetime(g, t->changed[i]);
    }
    return moves * (double)step; /* each stands for so many */
}

/* Those that set out are put elsewhere, too. */
static int64_t foreseen_cost(const struct grid *g, const struct job *job)
{
    int64_t moves = (int64_t)(foreseen_moves(g) * (ONE + g->doubt) / ONE);
    return cost_of_tracking(job, moves + (int64_t)msap_count_newcomers(g), 0);
}

/* Lists have lost much: remembers how many more moves there were than are foreseen. */
static void learn_doubt(struct grid *g, int64_t moves)
{
    double foreseen = foreseen_moves(g), doubt = ONE * ((double)moves / (foreseen + 1) - 1);
    g->doubt = doubt < 0 ? 0 : doubt > MOST_DOUBT ? MOST_DOUBT : (uint32_t)doubt;
}

/* ------------------------------------------------------------------ resting */

static int is_mostly_static(const struct box_table *t) { return 2 * t->live_static >= t->live; }

/* All are pruned; those that are not static leave the rows at once if they are few (rest.c). */
static enum way prune_and_rest(struct grid *g, const struct box_table *t)
{
    enum { FEW = 8 };
    g->will_rest = FEW * (t->live - t->live_static) <= t->live;
    return JUMP_OR_REBUILD;
}

/* ----------------------------------------------------------------- renewals */

/* Commits or more that skins are made for which are renewed in steps; and in as many steps as there are. */
enum { IN_STEPS = 12, UNHURRIED = 32 };

static int is_in_steps(uint32_t horizon) { return horizon >= IN_STEPS; }

/* A step after each commit; in a hurry some by twos. (First ones in a rush take fewer commits.) */
static int64_t renewal_steps(const struct job *job, uint32_t horizon)
{
    int64_t steps = CHANGE_SKINS - MAKE_SKINS + (int64_t)sweep_steps(job);
    return !is_in_steps(horizon) ? 0 : horizon < UNHURRIED ? steps - 2 : steps;
}

/* How many candidates there are or, while there are no skins, would be at least. */
static int64_t count_candidates(const struct grid *g, const struct job *job)
{
    return g->in_skins ? (int64_t)g->candidates.n : (int64_t)job->pairs->active * 5 / 4;
}

/* What it costs to give all boxes new skins in one commit, as dear as to prune them, and what in steps
 * between others. */
static int64_t cost_at_once(const struct grid *g, const struct job *job, int64_t candidates)
{
    int64_t box = RENEW_BOX + count_wide_skins(g) / WIDE_BOX;
    return box * (int64_t)job->boxes->live + RENEW_CANDIDATE * candidates;
}

static int64_t cost_of_renewal(const struct grid *g, const struct job *job, int64_t candidates)
{
    return cost_at_once(g, job, candidates) * dearness(job->boxes->live) / ONE;
}

/* What a commit costs in which no box leaves its skin. */
static int64_t cost_in_skins(const struct job *job, int64_t candidates)
{
    return SKIN_BOX * (int64_t)job->boxes->live + CANDIDATE * candidates;
}

/* Whether skins may ever be renewed together. Few boxes are not worth it. */
static int can_renew(const struct grid *g, const struct job *job)
{
    enum { FEW = 256 };
    return job->boxes->live >= FEW && count_wide_skins(g) <= MOST_WIDE &&
           g->config->strategy == MSAP_STRATEGY_AUTO;
}

/* Whether they may be now. */
static int may_renew(const struct grid *g, const struct job *job)
{
    return can_renew(g, job) && g->commit >= g->upkeep.not_before;
}

/* What it costs to put a box elsewhere that has left its skin. */
static int64_t cost_of_stray(const struct job *job, int64_t candidates)
{
    int64_t boxes = (int64_t)job->boxes->live + 1, of_a_box = 2 * candidates / boxes;
    return (STRAY_MOVE + of_a_box * STRAY_CANDIDATE) * dearness((size_t)boxes) / ONE;
}

/* Whether a quarter of the boxes or more have moved: estimated from some of those that changed. */
static int do_many_move(const struct box_table *t)
{
    enum { SAMPLES = 64, SHARE = 4 };
    size_t step = t->n_changed / SAMPLES + 1, n = 0;
    for (size_t i = 0; i < t->n_changed; i += step)
        n += (t->at[t->changed[i]].flags & (BOX_LIVE | BOX_WAS)) == (BOX_LIVE | BOX_WAS);
    return n * step * SHARE >= t->live;
}

/* What skins would be if made for so many commits: by those that some boxes would get. */
struct foresight {
    double growth;  /* so many times as many candidates as pairs there would be where boxes lie at random */
    double leaving; /* such a part of all boxes would leave before, in each commit */
};

static struct foresight foresee(const struct grid *g, uint32_t horizon)
{
    enum { SAMPLES = 32 };
    const struct box_table *t = g->boxes;
    struct foresight f = {0, 0};
    size_t step = t->used / SAMPLES + 1, n = 0;
    for (uint32_t slot = 0; slot < t->used; slot += (uint32_t)step) {
        float commits = (float)horizon;
        if (!(t->at[slot].flags & BOX_LIVE)) continue;
        f.growth += msap_skin_growth(g, slot, &commits);
        if (commits < (float)horizon) f.leaving += commits < 1 ? 1 : 1 / (double)commits;
        n++;
    }
    f.growth = n > 0 ? f.growth / (double)n : 1;
    f.leaving = n > 0 ? f.leaving / (double)n : 0;
    return f;
}

/* How many candidates there would be if skins were so many times as large as boxes. Those of wide boxes grow as on
 * one axis: as those of a wall do. */
static int64_t foreseen_candidates(const struct grid *g, const struct job *job, double growth)
{
    int64_t pairs = (int64_t)job->pairs->active, of_wide = count_wide(g) > 0 ? msap_wide_pairs(g, job->pairs) : 0;
    double more = (double)(pairs - of_wide) * (growth - 1) + (double)of_wide * (growth - 1) / 3;
    return pairs + (int64_t)more;
}

/* What a commit costs if skins are made for so many commits and renewed over and over. */
static int64_t foreseen_upkeep(const struct grid *g, const struct job *job, uint32_t horizon)
{
    struct foresight f = foresee(g, horizon);
    int64_t commits = (int64_t)horizon - renewal_steps(job, horizon);
    int64_t candidates = foreseen_candidates(g, job, f.growth);
    return cost_in_skins(job, candidates) + cost_of_renewal(g, job, candidates) / (commits < 1 ? 1 : commits) +
           (int64_t)(f.leaving * (double)job->boxes->live * (double)cost_of_stray(job, candidates));
}

/* Before skins are made for motion for the first time: chooses for how many commits, `most` or fewer, it is best.
 * Such as are renewed at once count for somewhat more, since then some commits take long. Returns what each commit
 * would cost. */
static int64_t choose_horizon(struct grid *g, const struct job *job, uint32_t most)
{
    enum { STALLS = 16 };
    static const uint32_t horizon[] = {HORIZON_SHORT, 4, 6, 8, IN_STEPS, 16, 24, 32, 48, HORIZON_MOST};
    int64_t best = INT64_MAX;
    for (size_t i = 0; i < sizeof horizon / sizeof *horizon && horizon[i] <= most; i++) {
        int64_t upkeep = foreseen_upkeep(g, job, horizon[i]);
        if (!is_in_steps(horizon[i])) upkeep += upkeep / STALLS;
        if (upkeep < best) g->upkeep.horizon = horizon[i];
        if (upkeep < best) best = upkeep;
    }
    return best;
}

/* Skins are made in this commit. */
void msap_upkeep_begins(struct grid *g)
{
    struct upkeep *u = &g->upkeep;
    u->horizon = u->horizon < HORIZON_SHORT  ? HORIZON_SHORT
                 : u->horizon > HORIZON_MOST ? HORIZON_MOST
                                             : u->horizon;
    u->begun = g->commit;
    u->made_for = u->horizon;
}

/* They serve from now on. */
void msap_upkeep_starts(struct grid *g)
{
    g->upkeep.since = g->upkeep.begun;
    g->upkeep.spent = g->upkeep.lately = 0;
}

/* n boxes are put elsewhere in this commit, each of which costs so much. Returns what they cost. */
static int64_t account(struct upkeep *u, int64_t n, int64_t move)
{
    enum { A_FEW = 4 };
    int64_t moves = n * move;
    u->move = move;
    u->lately += (moves - u->lately) / A_FEW;
    u->spent += moves;
    return moves;
}

/* How many boxes would leave their skins within so many commits if they moved on as in the last one:
 * estimated from some. */
static size_t foreseen_to_leave(const struct grid *g, uint32_t commits)
{
    enum { SAMPLES = 64 };
    size_t step = g->boxes->used / SAMPLES + 1, n = 0;
    for (size_t slot = g->commit % step; slot < g->boxes->used; slot += step)
        n += msap_skin_will_be_left(g, (uint32_t)slot, commits);
    return n * step; /* each stands for so many */
}

/* How one that begins goes on: in fewer commits for skins that do not last long, and in still fewer where first
 * ones would be left before. */
enum renewal_pace msap_renewal_pace(const struct grid *g, const struct job *job)
{
    const struct upkeep *u = &g->upkeep;
    if (u->is_first && foreseen_to_leave(g, (uint32_t)renewal_steps(job, u->horizon)) > 0) return IN_A_RUSH;
    return u->horizon < UNHURRIED ? IN_A_HURRY : AT_EASE;
}

/* After a commit that tracked boxes: whether to renew all skins in steps. That is so when one more commit with the
 * present ones would cost more than their upkeep has cost in each since they were made, renewal included; of
 * first skins at once or, where boxes crawl, when their motion is known; and when most boxes move but each still has
 * cells of its own, if that has cost more than renewals would. */
int msap_renewal_is_due(struct grid *g, const struct job *job)
{
    enum { SELDOM = 16, NOW_AND_THEN = 2, KNOWN = 8 };
    struct upkeep *u = &g->upkeep;
    if (!may_renew(g, job) || g->quiet > 0) return 0;
    if (g->in_skins && u->is_first) choose_horizon(g, job, HORIZON_MOST);
    int64_t age = g->commit - u->since, renewal = cost_of_renewal(g, job, count_candidates(g, job)),
            steps = renewal_steps(job, u->horizon);
    if (!g->is_resting) return age % SELDOM == 1 && u->spent * (u->horizon - steps) > renewal * age;
    if (!g->in_skins || steps == 0) return 0;
    if (u->is_first) return age >= KNOWN || !msap_most_crawl(g);
    int is_over = u->lately * age > renewal + u->spent; /* not only soon */
    if (!is_over && age % NOW_AND_THEN != 0) return 0;
    int64_t next = u->move * (int64_t)foreseen_to_leave(g, (uint32_t)steps + 1) / steps;
    if (!is_over && next * age <= renewal + u->spent) return 0;
    if (is_over && 2 * (age + steps) < u->made_for) u->horizon = (uint32_t)(age + steps);
    int64_t life = age + steps, tests = cost_in_skins(job, (int64_t)g->candidates.n);
    int has_paid = renewal + u->spent + tests * life < u->pruning * life;
    if (!has_paid) msap_renewal_failed(g);
    return has_paid;
}

/* It cannot be done, or has not paid: there is none for a while, and twice as long the time after that. */
void msap_renewal_failed(struct grid *g)
{
    enum { LEAST_WAIT = 32, MOST_WAIT = 4096 };
    struct upkeep *u = &g->upkeep;
    u->wait = u->wait == 0 ? LEAST_WAIT : u->wait < MOST_WAIT ? 2 * u->wait : MOST_WAIT;
    u->not_before = g->commit + u->wait;
}

/* All boxes have got new skins. The longer these are made for, the more candidates are tested in vain: as many as
 * a renewal costs is best. */
void msap_renewal_was_made(struct grid *g, const struct job *job, int is_at_once)
{
    struct upkeep *u = &g->upkeep;
    int64_t vain = (int64_t)g->candidates.n - (int64_t)job->pairs->active;
    int64_t renewal = cost_of_renewal(g, job, (int64_t)g->candidates.n);
    msap_upkeep_starts(g);
    if (u->is_first && is_at_once) return; /* the first skins say little about those for motion */
    u->is_first = 0;
    vain *= u->made_for - renewal_steps(job, u->made_for);
    if (vain > 4 * renewal) u->horizon /= 2;
    else if (vain > renewal) u->horizon -= u->horizon / 4;
    else if (!is_at_once) u->horizon += u->horizon / 2;
}

/* -------------------------------------------------------------------- choosing */

/* While nothing is kept: whether to track boxes would have saved more by now than it costs to begin. */
static int would_have_paid(struct grid *g, const struct job *job, const struct costs *c, int64_t beginning)
{
    g->doubt -= (g->doubt + FORGETTING - 1) / FORGETTING;
    g->gain += cost_of_pruning(g, job, c) - foreseen_cost(g, job);
    if (g->gain < 0) g->gain = 0;
    return g->gain > beginning;
}

/* While nothing is kept, and skins may be renewed: some boxes are tried. */
static enum way try_or_jump(struct grid *g, const struct job *job, const struct costs *c)
{
    enum { WAIT = 8, TRIAL = 3 };
    struct upkeep *u = &g->upkeep;
    if (u->tried == 0 || g->commit - u->tried > TRIAL) {
        u->tried = g->commit + 1;
        g->renewal.next = TRY_SKINS;
    }
    if (g->commit + 1 - u->tried < TRIAL) return JUMP_OR_REBUILD;
    int64_t n = msap_trial_count(g), leaving = n * cost_of_stray(job, (int64_t)job->pairs->active) / TRIAL;
    int64_t upkeep = choose_horizon(g, job, n == 0 ? HORIZON_MOST : HORIZON_TRIAL);
    if (promises(upkeep + leaving, c->jump)) return JUMP_INTO_SKINS;
    u->not_before = g->commit + WAIT;
    return JUMP_OR_REBUILD;
}

/* While nothing is kept: whether only the restless boxes are pruned. Those of them that stand still by now are
 * pruned in vain, until that has cost as much as to calm them: again one who rents or buys. Rows that do not suit the
 * boxes any more are made anew. */
static enum way prune(const struct grid *g, const struct job *job, const struct costs *c)
{
    enum { COMMITS = 256 };
    const struct rows *rows = &g->rows;
    int64_t idle = (int64_t)g->restless.idle * RESTLESS_BOX;
    if (cost_of_a_few(g, job) >= c->jump) return JUMP_OR_REBUILD;
    if (idle < cost_of_calming(job)) return PRUNE_RESTLESS;
    int are_old = msap_is_outgrown(rows->chosen_for, job->boxes->live) || g->commit - rows->chosen_at > COMMITS;
    return are_old ? JUMP_OR_REBUILD : CALM_AND_PRUNE;
}

/* While nothing is kept, and few boxes move: they rest if, even should all be put elsewhere once, it takes less
 * than to prune all, or when it would have paid. Where some are restless all must be pruned before. */
static enum way rest_or_prune(struct grid *g, const struct job *job, const struct costs *c)
{
    int are_calm = g->restless.n == 0;
    int64_t beginning = cost_of_tracking(job, (int64_t)job->boxes->n_changed, 0);
    if (!are_calm) beginning += c->jump;
    else if (beginning < c->jump) beginning = 0;
    if (!would_have_paid(g, job, c, beginning)) return prune(g, job, c);
    return are_calm ? REST : JUMP_OR_REBUILD;
}

/* While nothing is kept. */
static enum way choose_untracked(struct grid *g, const struct job *job, const struct costs *c)
{
    int is_quiet = cost_of_tracking(job, (int64_t)job->boxes->n_changed, 0) < c->jump;
    if (is_quiet || (can_renew(g, job) && !do_many_move(job->boxes))) return rest_or_prune(g, job, c);
    g->upkeep.is_first = 0;
    if (!can_renew(g, job)) return would_have_paid(g, job, c, c->rebuild) ? REBUILD : JUMP_OR_REBUILD;
    g->gain = 0;
    return may_renew(g, job) ? try_or_jump(g, job, c) : JUMP_OR_REBUILD;
}

/* What a commit would cost with skins for so many more commits that they are renewed in steps, if the
 * present ones, which last so many, have shown how many candidates are tested in vain. */
static int64_t upkeep_in_steps(const struct grid *g, const struct job *job, int64_t commits)
{
    int64_t pairs = (int64_t)job->pairs->active, vain = (int64_t)g->candidates.n - pairs;
    int64_t n = commits < IN_STEPS ? pairs + vain * IN_STEPS / commits : pairs + vain;
    int64_t left = IN_STEPS - renewal_steps(job, IN_STEPS);
    return cost_in_skins(job, n) + cost_of_renewal(g, job, n) / (left < 1 ? 1 : left);
}

/* While boxes rest in their skins. All get new ones in this commit if the present ones have come to cost more in
 * it than in each so far, renewal included, or than to prune all; such as last long may for once. But if to
 * prune all would have been cheaper all along, or new ones would take long at once and not pay in steps, nothing
 * is kept for a while. */
static enum way choose_in_skins(struct grid *g, const struct job *job, const struct costs *c)
{
    enum { LONG = 4 };
    struct upkeep *u = &g->upkeep;
    int is_quiet = cost_of_tracking(job, (int64_t)job->boxes->n_changed, 0) < c->jump;
    int64_t pruning = u->pruning = is_quiet ? c->jump : cost_of_pruning(g, job, c); /* or they will rest soon */
    int are_all_live = job->boxes->removed.head == NONE; /* so that lists can be made of them */
    g->quiet = is_quiet ? g->quiet + 1 : 0;
    if (g->quiet > (u->is_first ? 0 : LONG) && are_all_live) return REST;
    if (g->commit < u->not_before) return JUMP_OR_REBUILD;
    int64_t age = g->commit + 1 - u->since; /* this is the age-th commit with them */
    int64_t tests = cost_in_skins(job, (int64_t)g->candidates.n), moves = c->track - tests;
    int64_t renewal = cost_at_once(g, job, (int64_t)g->candidates.n);
    int64_t cost = renewal + u->spent - moves + tests * (age - 1);
    int is_short = !is_in_steps(u->is_first ? u->horizon : u->made_for);
    int is_due =
        is_short ? c->track > pruning || c->track * age > cost : c->track > renewal || u->lately + tests > pruning;
    if (!is_due) return TRACK;
    int is_stall = 2 * renewal > 5 * c->jump;
    int has_paid = cost < pruning * age && (!is_stall || upkeep_in_steps(g, job, age) < pruning);
    if (u->is_first) has_paid = promises(choose_horizon(g, job, HORIZON_MOST), pruning);
    else u->horizon = is_stall && age < IN_STEPS ? IN_STEPS : (uint32_t)age;
    u->is_first = 0;
    if (has_paid) u->wait = 0;
    else msap_renewal_failed(g);
    return has_paid && can_renew(g, job) ? JUMP_INTO_SKINS : JUMP_OR_REBUILD;
}

/* While cells and lists are kept. `early` are the boxes that left a skin made for their motion:
 * if lists do not pay because of others, that will pass. */
static enum way choose_tracked(struct grid *g, const struct job *job, const struct costs *c, int64_t early)
{
    int64_t pruning = cost_of_pruning(g, job, c);
    int has_paid = g->gain > 0, is_upheaval = c->track > c->rebuild;
    g->gain += pruning - c->track;
    if (g->gain > c->rebuild / 4) g->gain = c->rebuild / 4;
    if (!is_upheaval && g->gain > -(g->is_resting ? c->jump : c->rebuild) / 2) return TRACK;
    g->gain = 0;
    if (is_upheaval && g->is_resting) return prune_and_rest(g, job->boxes);
    if (is_upheaval) return has_paid && foreseen_cost(g, job) < c->jump ? REBUILD : JUMP_OR_REBUILD;
    learn_doubt(g, early);
    return foreseen_cost(g, job) < pruning ? TRACK : JUMP_OR_TRACK;
}

/* A world that is not mostly static is loaded. */
static enum way load(struct grid *g, const struct job *job)
{
    g->upkeep.is_first = may_renew(g, job);
    return g->upkeep.is_first ? JUMP_INTO_SKINS : REBUILD;
}

/* The way for AUTO, if the first `misplaced` of the boxes that left must be put elsewhere. */
enum way msap_choose(struct grid *g, const struct job *job, size_t misplaced)
{
    enum { FEW = 64 };
    const struct box_table *t = job->boxes;
    int64_t leaving = 0, early = 0;
    struct costs c = costs_of(g, job);
    if (!g->is_tracking && !g->is_jumping) return is_mostly_static(t) ? prune_and_rest(g, t) : load(g, job);
    if (!g->is_tracking) return choose_untracked(g, job, &c);
    for (size_t i = 0; i < misplaced; i++) {
        const struct box *b = &t->at[t->left[i]];
        leaving += !(b->flags & BOX_LIVE);
        early += b->level != NO_LEVEL && skin_age(g, t->left[i]) < HORIZON_MOST;
    }
    int64_t moves = (int64_t)misplaced - leaving;
    if (g->in_skins) {
        c.track = account(&g->upkeep, moves, cost_of_stray(job, (int64_t)g->candidates.n)) +
                  cost_in_skins(job, (int64_t)g->candidates.n);
    } else {
        account(&g->upkeep, moves, cost_of_tracking(job, 1, 0) - cost_of_tracking(job, 0, 0));
        c.track = cost_of_tracking(job, moves, leaving);
    }
    if (t->live <= FEW) return TRACK;
    return g->in_skins ? choose_in_skins(g, job, &c) : choose_tracked(g, job, &c, early);
}
