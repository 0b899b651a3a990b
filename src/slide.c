/* Sliding: moving the end points of a box to their places on one axis (paper I.3).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * An end point moves past its neighbours one by one, like a key in an insertion
 * sort. What two boxes do on an axis changes only when a min and a max of theirs
 * change places: a crossing. A min and a min, or two maxes, never matter. So a
 * crossing touches the pair, and nothing else does. The sentinels end each move.
 *
 * The end that leads goes first: upwards the max, else the min; so a box never
 * crosses itself.
 *
 * The filter. Axes are brought up to date one after another, each wholly, so while
 * one slides the axes before it are wholly new and those behind it wholly old, and
 * two boxes' ranks on them tell rightly whether they overlap there: now on the
 * first kind, before on the second (the paper's index-only test, I.3). A crossing
 * may be dropped unless they overlap on all other axes by these ranks, for
 * - a pair that is created crosses on the last axis on which its boxes come
 *   together; on the axes before it they overlap now, and on those behind it they
 *   overlap now and did so before;
 * - a pair that is deleted crosses on the first axis on which its boxes part; on
 *   the axes before it they overlap now (and did), behind it they did before.
 * Either crossing passes the filter, and one touch is enough. */
#include "internal.h"

static int overlap_by_rank(const struct axis *x, uint32_t a, uint32_t b)
{
    const uint32_t *rank = x->rank;
    return rank[2 * a] < rank[2 * b + 1] && rank[2 * b] < rank[2 * a + 1];
}

static void cross(const struct sap *s, uint32_t k, uint32_t a, uint32_t b, const struct job *job)
{
    job->worker->settler.crossings++;
    if (job->filters)
        for (uint32_t other = 0; other < s->dims; other++)
            if (other != k && !overlap_by_rank(&s->axis[other], a, b)) return;
    settle(&job->worker->settler, a, b);
}

/* Moves an end point to where `key`, its new key, belongs; step is 1 or -1. */
static void slide_end_point(struct sap *s, uint32_t k, uint64_t key, int step, const struct job *job)
{
    struct axis *x = &s->axis[k];
    uint32_t at = x->rank[key_end(key)];
    for (;;) {
        uint64_t other = x->key[at + (uint32_t)step];
        if (step > 0 ? other > key : other < key) break;
        x->key[at] = other;
        x->rank[key_end(other)] = at;
        at += (uint32_t)step;
        if ((other ^ key) & KEY_MAX_BIT) cross(s, k, key_box(key), key_box(other), job);
    }
    x->key[at] = key;
    x->rank[key_end(key)] = at;
}

static void slide_to(struct sap *s, uint32_t k, uint64_t key, const struct job *job)
{
    const struct axis *x = &s->axis[k];
    uint64_t old = x->key[x->rank[key_end(key)]];
    if (key != old) slide_end_point(s, k, key, key > old ? 1 : -1, job);
}

/* Moves both end points of a stored box to its bounds `now`. */
void msap_axis_slide(struct sap *s, uint32_t k, uint32_t box, const struct job *job)
{
    const struct axis *x = &s->axis[k];
    const struct bounds *to = &job->boxes->at[box].now;
    uint64_t min = key_make(to->min[k], 0, box), max = key_make(to->max[k], 1, box);
    int up = max > x->key[x->rank[2 * box + 1]];
    slide_to(s, k, up ? max : min, job);
    slide_to(s, k, up ? min : max, job);
}
