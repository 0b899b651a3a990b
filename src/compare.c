/* Comparing: the events between two sets of pairs, by their sorted lists.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Where all pairs are found anew (jump.c) and many of them are others than before, as they
 * are in every commit or since many boxes have come, to ask of each what it was costs more
 * than to sort them all: the list of the last commit's pairs and that of this one's, walked
 * side by side, give the events, and these are in order. No bounds are looked at. This is
 * the pair manager of the paper's chapter I.6 done in a batch; the list is kept for the
 * next commit. */
#include "internal.h"

/* Whether a quarter of the boxes or more were not there at the last commit: then nearly half of the pairs or more
 * were not. */
static int have_many_come(const struct box_table *t)
{
    enum { SHARE = 4 };
    size_t n = 0;
    if (t->n_left < t->live / SHARE) return 0;
    for (size_t i = 0; i < t->n_left; i++) n += (t->at[t->left[i]].flags & (BOX_LIVE | BOX_WAS)) == BOX_LIVE;
    return n >= t->live / SHARE;
}

/* Whether this should cost less than settling the known pairs and those found: by how many pairs
 * came and went in the last commit, and how many boxes have come since. */
int msap_compare_is_worth_it(const struct grid *g, const struct job *job)
{
    const struct pair_table *pairs = job->pairs;
    size_t both = pairs->created < pairs->deleted ? pairs->created : pairs->deleted;
    return both > pairs->active / (g->knows_pairs ? 8 : 4) || have_many_come(job->boxes);
}

/* The first broken invariant, or NULL, of a world whose pairs can be found. */
const char *msap_known_broken(const struct grid *g, const struct pair_table *pairs)
{
    const struct keys *k = &g->known;
    if (!g->knows_pairs) return NULL;
    for (size_t i = 0; i < k->n; i++)
        if ((i > 0 && k->at[i - 1] >= k->at[i]) ||
            msap_pairs_find(pairs, (uint32_t)(k->at[i] >> 32), (uint32_t)k->at[i]) == NONE)
            return "the list of known pairs names none or is not in order";
    return k->n == pairs->active ? NULL : "the list of known pairs is not of all";
}

/* Makes the list of the known pairs from the pairs themselves. Returns 0 without memory. */
static int list_known(struct grid *g, const struct job *job)
{
    const struct pair_table *t = job->pairs;
    if (g->knows_pairs) return 1;
    if (!msap_keys_reserve(&g->known, job->memory, t->active)) return 0;
    for (uint32_t i = 0; i < t->active; i++) g->known.at[i] = pair_key_at(t, i);
    g->known.n = t->active;
    msap_sort_keys(g->known.at, t->active, msap_scratch_get(job->scratch, job->memory, t->active));
    return 1;
}

/* What is only in the list of pairs now is fresh, what is only in that of before is doomed. The
 * lists of events have room for both: that of the doomed always has for all known pairs. */
static void find_events(struct settler *s, const struct keys *before, const struct keys *now)
{
    size_t i = 0, j = 0, fresh = 0, doomed = 0;
    while (i < before->n && j < now->n) {
        uint64_t was = before->at[i], is = now->at[j];
        s->doomed.at[doomed] = was;
        s->fresh.at[fresh] = is;
        doomed += was < is;
        fresh += is < was;
        i += was <= is;
        j += is <= was;
    }
    for (; i < before->n; i++) s->doomed.at[doomed++] = before->at[i];
    for (; j < now->n; j++) s->fresh.at[fresh++] = now->at[j];
    s->doomed.n = doomed;
    s->fresh.n = fresh;
    s->are_events = 1;
}

/* Fills the lists of events by the pairs that overlap now, which worker 0 has, in any order
 * and as often as they were found. Returns 0 without memory. */
int msap_compare(struct grid *g, struct job *job)
{
    struct keys *now = &job->worker->pairs, before;
    struct settler *s = &job->worker->settler;
    if (!list_known(g, job) || !msap_keys_reserve(&s->fresh, job->memory, now->n)) return 0;
    s->touched += g->known.n + now->n;
    msap_share_sort_keys(job, now->at, now->n, msap_scratch_get(job->scratch, job->memory, now->n));
    now->n = msap_unique_keys(now->at, now->n);
    find_events(s, &g->known, now);
    before = g->known;
    g->known = *now;
    *now = before;
    g->knows_pairs = 0;
    g->will_know_pairs = 1;
    return 1;
}
