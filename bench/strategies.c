/* Measures what the ways to bring a world up to date cost, and suggests the weights by
 * which src/sap.c (for a single SAP) and src/choose.c (for a Multi-SAP) choose among them.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The cost of a commit of a single SAP is taken to be
 *
 *     slide   P p + C q        P places that end points slide, all together
 *     merge   E m + C c + C S t    E end points in the axes, C boxes that changed
 *     sweep   E s + N S u      N boxes in all
 *
 * where S, the span, is how many end points lie between the two of a box, on average,
 * on the axis where they are fewest: so many others a box meets when pruned. The
 * factors follow from scenes of all kinds, by least squares of the relative errors.
 * What counts is not how well this foretells a time but which way is taken; so at the
 * end stands how much longer the commits take for the ways that the weights choose
 * than for the best ways.
 *
 * A Multi-SAP keeps neighbours and puts boxes elsewhere one by one, makes all anew, or
 * prunes all, or the few that jump. What each costs for each box, pair, neighbour or box put elsewhere follows
 * from scenes of several sizes and densities in the same way; the unit is what the test
 * of a neighbour costs. */
#include "library.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WAYS = 4, MOST_CASES = 128, ROUNDS = 3 };

struct measured {
    double places, boxes, changed, span;
    double ms[WAYS]; /* by msap_strategy */
};

/* A way's cost: milliseconds for each of its terms. */
enum { TERMS = 4 };
struct cost {
    double of[TERMS];
};

/* ---------------------------------------------------------------- the cases */

static uint64_t key_of(const aabb *b, int k, int is_max)
{
    return msap_encode_float(is_max ? b->max[k] : b->min[k]);
}

static size_t rank_of(const uint64_t *key, size_t n, uint64_t wanted)
{
    size_t low = 0, high = n;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (key[middle] < wanted) low = middle + 1;
        else high = middle;
    }
    return low;
}

static void sort_axis(const scene *s, const aabb *before, uint64_t *key, int k)
{
    for (uint32_t i = 0; i < s->boxes; i++) {
        key[2 * i] = key_of(&before[i], k, 0);
        key[2 * i + 1] = key_of(&before[i], k, 1);
    }
    sort_keys(key, 2 * (size_t)s->boxes, key + 2 * (size_t)s->boxes);
}

/* How many places the moves of the last frame slide end points on a sorted axis. */
static double places_on(const scene *s, const aabb *before, const uint64_t *key, int k)
{
    size_t n = 2 * (size_t)s->boxes;
    double places = 0;
    for (uint32_t i = 0; i < s->movers; i++) {
        const move *m = &scene_frame(s, s->frames - 1)[i];
        for (int e = 0; e < 2; e++)
            places += fabs((double)rank_of(key, n, key_of(&m->to, k, e)) -
                           (double)rank_of(key, n, key_of(&before[m->box], k, e)));
    }
    return places;
}

static double span_on(const scene *s, const aabb *before, const uint64_t *key, int k)
{
    size_t n = 2 * (size_t)s->boxes;
    double span = 0;
    for (uint32_t i = 0; i < s->boxes; i++)
        span += (double)(rank_of(key, n, key_of(&before[i], k, 1)) - rank_of(key, n, key_of(&before[i], k, 0)));
    return span / s->boxes;
}

/* Looks at the boxes before the last frame. */
static void count(const scene *s, struct measured *m)
{
    scene earlier = *s;
    earlier.frames--;
    aabb *before = scene_end(&earlier);
    uint64_t *key = get(4 * (size_t)s->boxes, sizeof *key);
    m->places = 0;
    m->span = INFINITY;
    for (int k = 0; k < 3; k++) {
        sort_axis(s, before, key, k);
        m->places += places_on(s, before, key, k);
        m->span = fmin(m->span, span_on(s, before, key, k));
    }
    free(key);
    free(before);
}

/* Of two frames the second is measured. */
static struct measured measure(const recipe *r)
{
    scene s = scene_make(r);
    struct measured m = {0, s.boxes, s.movers, 0, {INFINITY, INFINITY, INFINITY, INFINITY}};
    count(&s, &m);
    for (int round = 0; round < ROUNDS; round++)
        for (uint32_t way = 0; way < WAYS; way++) {
            const msap_config config = config_of(MSAP_GRID_NONE, (msap_strategy)way, 0);
            const setting world = {&s, &config, 0};
            if (way != MSAP_STRATEGY_SLIDE || m.places < 2e8) m.ms[way] = fmin(m.ms[way], library_run(&world).ms);
        }
    scene_free(&s);
    return m;
}

/* ------------------------------------------------------------------ the fit */

/* How much of each term a commit has; 0 for a way that has fewer. */
static struct cost terms_of(const struct measured *m, int way)
{
    const struct cost slide = {{m->places, m->changed}};
    const struct cost merge = {{6 * m->boxes, m->changed, m->changed * m->span}};
    const struct cost sweep = {{6 * m->boxes, m->boxes * m->span}};
    return way == MSAP_STRATEGY_SLIDE ? slide : way == MSAP_STRATEGY_MERGE ? merge : sweep;
}

/* Solves a[n][n] x = a[.][n] by elimination; a is symmetric and positive. */
static struct cost solve(double a[TERMS][TERMS + 1], int n)
{
    struct cost x = {{0}};
    for (int i = 0; i < n; i++)
        for (int row = 0; row < n; row++) {
            double factor = row == i ? 0 : a[row][i] / a[i][i];
            for (int k = 0; k <= TERMS; k++) a[row][k] -= factor * a[i][k];
        }
    for (int i = 0; i < n; i++) x.of[i] = a[i][TERMS] / a[i][i];
    return x;
}

/* The factors with the least sum of (foretold / measured - 1)^2. */
static struct cost fit(const struct measured *m, size_t n, int way)
{
    double a[TERMS][TERMS + 1] = {{0}};
    for (size_t i = 0; i < n; i++) {
        struct cost t = terms_of(&m[i], way);
        if (!isfinite(m[i].ms[way])) continue;
        for (int row = 0; row < TERMS; row++) {
            for (int k = 0; k < TERMS; k++) a[row][k] += t.of[row] * t.of[k] / (m[i].ms[way] * m[i].ms[way]);
            a[row][TERMS] += t.of[row] / m[i].ms[way];
        }
    }
    return solve(a, way == MSAP_STRATEGY_MERGE ? 3 : 2);
}

static double foretold(const struct measured *m, const struct cost *cost, int way)
{
    struct cost t = terms_of(m, way);
    double ms = 0;
    for (int i = 0; i < TERMS; i++) ms += t.of[i] * cost[way].of[i];
    return ms;
}

static int chosen(const struct measured *m, const struct cost *cost)
{
    int best = MSAP_STRATEGY_SLIDE;
    for (int way = MSAP_STRATEGY_MERGE; way < WAYS; way++)
        if (foretold(m, cost, way) < foretold(m, cost, best)) best = way;
    return best;
}

/* --------------------------------------------------------------- the report */

static double best_of(const struct measured *m)
{
    return fmin(m->ms[MSAP_STRATEGY_SLIDE], fmin(m->ms[MSAP_STRATEGY_MERGE], m->ms[MSAP_STRATEGY_SWEEP]));
}

static void print_case(const recipe *r, const struct measured *m)
{
    printf("%-9s %7u boxes %6.2f %% move  %11.0f places  %9.3f %9.3f %9.3f %9.3f\n", r->name, (unsigned)r->boxes,
           100 * r->moving, m->places, m->ms[MSAP_STRATEGY_SLIDE], m->ms[MSAP_STRATEGY_MERGE],
           m->ms[MSAP_STRATEGY_SWEEP], m->ms[MSAP_STRATEGY_AUTO]);
    fflush(stdout);
}

/* How much longer than the best way: the geometric mean and the worst. */
static void print_regret(const char *what, const struct measured *m, size_t n, const struct cost *cost)
{
    double sum = 0, worst = 0;
    for (size_t i = 0; i < n; i++) {
        double ms = m[i].ms[cost ? chosen(&m[i], cost) : MSAP_STRATEGY_AUTO];
        sum += log(ms / best_of(&m[i]));
        worst = fmax(worst, ms / best_of(&m[i]));
    }
    printf("%-20s %.3f on average, %.2f at worst\n", what, exp(sum / (double)n), worst);
}

static void print_weights(const struct measured *m, size_t n)
{
    struct cost cost[WAYS] = {{{0}}};
    for (int way = MSAP_STRATEGY_SLIDE; way < WAYS; way++) cost[way] = fit(m, n, way);
    const double *slide = cost[MSAP_STRATEGY_SLIDE].of, *merge = cost[MSAP_STRATEGY_MERGE].of;
    const double *sweep = cost[MSAP_STRATEGY_SWEEP].of, p = slide[0];
    printf("\na place takes %.2f ns; in places:\n", 1e6 * p);
    printf("slide   P + %.1f C\n", slide[1] / p);
    printf("merge   %.2f E + %.1f C + %.3f C S\n", merge[0] / p, merge[1] / p, merge[2] / p);
    printf("sweep   %.2f E + %.3f N S\n", sweep[0] / p, sweep[1] / p);
    printf("\ntimes the best way:\n");
    print_regret("as built", m, n, NULL);
    print_regret("with these weights", m, n, cost);
}

/* ----------------------------------------------------------- the Multi-SAP */

/* Scenes of several sizes and densities. */
enum { GRID_CASES = 12 };

/* What one commit has of some things; returns of how many. */
typedef int (*terms_fn)(const world_run *run, double terms[TERMS]);

static int boxes_and_candidates(const world_run *run, double terms[TERMS])
{
    terms[0] = (double)run->stats.boxes;
    terms[1] = (double)run->stats.candidates;
    return 2;
}

static int boxes_and_pairs(const world_run *run, double terms[TERMS])
{
    terms[0] = (double)run->stats.boxes;
    terms[1] = (double)run->stats.pairs;
    terms[2] = (double)run->events;
    return 3;
}

static int moves_and_neighbours(const world_run *run, double terms[TERMS])
{
    terms[0] = (double)run->stats.moves;
    terms[1] = terms[0] * 2 * (double)run->stats.candidates / (double)run->stats.boxes;
    terms[2] = (double)run->stats.candidates;
    terms[3] = (double)run->events;
    return 4;
}

static int moves_and_pairs(const world_run *run, double terms[TERMS])
{
    terms[0] = (double)run->stats.moves;
    terms[1] = (double)run->stats.pairs;
    terms[2] = (double)run->events;
    return 3;
}

/* The factors with the least sum of squares of the relative errors, in nanoseconds. */
static struct cost fit_grid(const recipe *kind, const msap_config *config, terms_fn terms_of_run)
{
    static const uint32_t sizes[] = {2000, 10000, 40000};
    static const double overlaps[] = {1, 4, 16, 64};
    double a[TERMS][TERMS + 1] = {{0}};
    int n = 0;
    for (size_t i = 0; i < GRID_CASES; i++) {
        recipe r = *kind;
        double terms[TERMS], ms = INFINITY;
        r.boxes = sizes[i % 3];
        r.overlaps = overlaps[i / 3];
        r.speed *= (i + i / 3) % 2 ? 3 : 1; /* else events would follow from pairs */
        scene s = scene_make(&r);
        const setting world = {&s, config, 0};
        for (int round = 0; round < ROUNDS; round++) {
            world_run run = library_run(&world);
            ms = fmin(ms, run.ms);
            n = terms_of_run(&run, terms);
        }
        for (int row = 0; row < n; row++) {
            for (int k = 0; k < n; k++) a[row][k] += terms[row] * terms[k] / (ms * ms);
            a[row][TERMS] += 1e6 * terms[row] / ms;
        }
        scene_free(&s);
    }
    return solve(a, n);
}

/* The weights of src/choose.c. */
static void measure_grid(void)
{
    const recipe still = {"", 0, 8, 0, 1, 1e-5, STRAIGHT, 0, 0}, swift = {"", 0, 24, 0, 1, 0.25, BROWNIAN, 0, 0},
                 flat = {"", 0, 24, 0, 1, 0.25, BROWNIAN, 1, 0}, some = {"", 0, 24, 0, 1, 0.1, BROWNIAN, 0, 0},
                 few = {"", 0, 24, 0, 0.05, 0, JUMPING, 0, 0};
    const msap_config lists = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_SLIDE, 0.25f),
                      pruned = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO),
                      anew = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_SWEEP, MSAP_MARGIN_AUTO),
                      moved = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_MERGE, MSAP_MARGIN_AUTO);
    struct cost keep = fit_grid(&still, &lists, boxes_and_candidates);
    struct cost jump = fit_grid(&swift, &pruned, boxes_and_pairs);
    struct cost line = fit_grid(&flat, &pruned, boxes_and_pairs);
    struct cost restless = fit_grid(&few, &pruned, moves_and_pairs);
    struct cost rebuild = fit_grid(&still, &anew, boxes_and_candidates);
    struct cost track = fit_grid(&some, &moved, moves_and_neighbours);
    double test = keep.of[1];
    printf("\nin a Multi-SAP the test of a neighbour takes %.1f ns; in tests:\n", test);
    printf("TRACK_MOVE %.0f, TRACK_NEIGHBOUR %.1f\n", track.of[0] / test, track.of[1] / test);
    printf("JUMP_BOX %.1f, JUMP_BOX_IN_LINE %.1f, JUMP_PAIR %.1f\n", jump.of[0] / test, line.of[0] / test,
           jump.of[1] / test);
    printf("RESTLESS_BOX %.0f, KNOWN_PAIR %.1f\n", restless.of[0] / test, restless.of[1] / test);
    printf("REBUILD_BOX %.0f, REBUILD_NEIGHBOUR %.1f\n", rebuild.of[0] / test, rebuild.of[1] / test);
}

/* --------------------------------------------------------------- everything */

static void measure_single(void)
{
    static const recipe kinds[] = {{"slow", 0, 2, 2, 0, 0.05, STRAIGHT, 0, 0},
                                   {"fast", 0, 2, 2, 0, 1, BROWNIAN, 0, 0},
                                   {"floor", 0, 2, 2, 0, 0.05, STRAIGHT, 1, 0},
                                   {"crowd", 0, 2, 30, 0, 0.02, BROWNIAN, 0, 0},
                                   {"jumping", 0, 2, 2, 0, 0, JUMPING, 0, 0}};
    static const uint32_t sizes[] = {300, 3000, 30000};
    static const double shares[] = {0.003, 0.03, 0.3, 1};
    static struct measured m[MOST_CASES];
    size_t n = 0;
    printf("milliseconds of a commit:%42s %9s %9s %9s %9s\n", "", "slide", "merge", "sweep", "auto");
    for (size_t kind = 0; kind < sizeof kinds / sizeof *kinds; kind++)
        for (size_t size = 0; size < sizeof sizes / sizeof *sizes; size++)
            for (size_t share = 0; share < sizeof shares / sizeof *shares; share++) {
                recipe r = kinds[kind];
                r.boxes = sizes[size];
                r.moving = shares[share];
                m[n] = measure(&r);
                print_case(&r, &m[n++]);
            }
    print_weights(m, n);
}

int main(void)
{
    measure_single();
    measure_grid();
    return 0;
}
