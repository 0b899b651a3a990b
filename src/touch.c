/* Touching neighbours: every pair of which a box has changed is settled.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Lists are short and of all lengths, and a loop over each would end in a surprise for
 * the processor every time, which costs as much as several tests. So their pairs first go
 * into one buffer, by fours and without a question, and the buffer is settled in one loop.
 *
 * A list tells whether two boxes were a pair. Which of its entries do not tell any more is
 * kept with the events; they are put right once the commit has succeeded. */
#include "internal.h"

/* A part of a commit over the lists, and over changed slots. */
struct touching {
    const struct near_list *of;
    const struct box_table *boxes;
    const uint32_t *slot;
};

/* Pairs of boxes with neighbours above, whose entries tell whether they were, and where the
 * entries stand in their lists. */
struct above {
    struct pair_buffer pair;
    uint32_t index[MOST_BUFFERED + BUFFER_SLACK];
};

static void settle_above(struct settler *s, const struct above *p, size_t n)
{
    const struct box *boxes = s->boxes->at;
    s->touched += n;
    for (size_t i = 0; i < n && s->boxes->used > MANY_BOXES; i++) prefetch(&boxes[near_slot(p->pair.b[i])]);
    for (size_t i = 0; i < n; i++) {
        uint32_t a = p->pair.a[i], entry = p->pair.b[i], b = near_slot(entry);
        int is = overlap(&boxes[a].now, &boxes[b].now);
        if (is == (int)(entry >> 31)) continue;
        msap_settle_change(s, (uint64_t)a << 32 | b, is);
        msap_settle_note(s, a, p->index[i]);
    }
}

/* Appends the pairs of a box with neighbours above to the n that are buffered: four at a
 * time, whether or not there are as many, since a list has room for fours. Returns how
 * many are buffered then. */
static inline size_t buffer_above(struct settler *s, struct above *p, size_t n, uint32_t slot,
                                  const struct near_list *l)
{
    for (uint32_t i = 0; l->at; i += 4) {
        uint32_t left = l->n_above - i;
        set_four(p->pair.a + n, slot);
        copy_four(p->pair.b + n, l->at + i);
        count_four(p->index + n, i);
        n += left < 4 ? left : 4;
        if (n >= MOST_BUFFERED) {
            settle_above(s, p, n);
            n = 0;
        }
        if (left <= 4) break;
    }
    return n;
}

/* Every pair once, from the lower box, whether or not a box of it changed. The first boxes have
 * more neighbours above than the last: so a part is some of the first half and, counted from the
 * end, as many of the other. */
static void touch_all(void *context, struct worker *w, size_t first, size_t last)
{
    const struct touching *t = context;
    uint32_t used = (uint32_t)t->boxes->used, from = used - (uint32_t)last, to = used - (uint32_t)first;
    struct above above;
    size_t n = 0;
    for (uint32_t slot = (uint32_t)first; slot < last; slot++)
        n = buffer_above(&w->settler, &above, n, slot, &t->of[slot]);
    for (uint32_t slot = from > last ? from : (uint32_t)last; slot < to; slot++)
        n = buffer_above(&w->settler, &above, n, slot, &t->of[slot]);
    settle_above(&w->settler, &above, n);
}

/* A pair with a neighbour below that did not change: its list tells. */
static void touch_below(const struct touching *t, struct settler *s, uint32_t slot, uint32_t below)
{
    const struct box *p = &t->boxes->at[slot], *q = &t->boxes->at[below];
    const struct near_list *l = &t->of[below];
    int is = overlap(&p->now, &q->now);
    s->touched++;
    if (were_pair(t->boxes, slot, below) == is) return;
    msap_settle_change(s, pair_key(slot, below), is);
    msap_settle_note(s, below, msap_near_find(l, below, slot));
}

/* Every pair of a changed box; of two changed boxes from the lower one. */
static void touch_changed(void *context, struct worker *w, size_t first, size_t last)
{
    enum { AHEAD = 8 };
    const struct touching *t = context;
    struct above above;
    size_t n = 0;
    for (size_t c = first; c < last; c++) {
        uint32_t slot = t->slot[c];
        const struct near_list *l = &t->of[slot];
        if (c + 2 * AHEAD < last) prefetch(&t->of[t->slot[c + 2 * AHEAD]]);
        if (c + AHEAD < last) prefetch(t->of[t->slot[c + AHEAD]].at);
        n = buffer_above(&w->settler, &above, n, slot, l);
        for (uint32_t i = l->n_above; i < l->n; i++)
            if (!box_is_changed(t->boxes, l->at[i])) touch_below(t, &w->settler, slot, l->at[i]);
    }
    settle_above(&w->settler, &above, n);
}

/* Touches all neighbours of the changed boxes. Returns 0 without memory. */
int msap_grid_touch(const struct grid *g, struct job *job)
{
    const struct box_table *t = job->boxes;
    struct touching all = {g->near.of, t, t->changed};
    size_t weight = WEIGHT_TOUCH * (1 + pairs_of_a_box(job) / 2);
    if (t->n_changed * 4 >= t->live * 3)
        return msap_phase_run(job->crew, job->memory, touch_all, &all, (t->used + 1) / 2, 2 * weight);
    return msap_phase_run(job->crew, job->memory, touch_changed, &all, t->n_changed, weight);
}

/* -------------------------------------------------------------- candidates */

/* Where there are many boxes, those of a candidate further on are fetched. */
static inline void fetch_candidate(const struct box *boxes, const uint64_t *c, size_t i, size_t last)
{
    enum { AHEAD = 16 };
    if (i + AHEAD >= last) return;
    prefetch(&boxes[c[i + AHEAD] >> 32]);
    prefetch(&boxes[candidate_slot((uint32_t)c[i + AHEAD])]);
}

/* Settles candidates first ... last - 1; names those with a box that left. */
static void touch_candidates(void *context, struct worker *w, size_t first, size_t last)
{
    const struct grid *g = context;
    const struct box *boxes = g->boxes->at;
    uint64_t *c = g->candidates.at;
    int are_many = g->boxes->used > MANY_BOXES;
    w->settler.touched += last - first;
    for (size_t i = first; i < last; i++) {
        uint32_t a = (uint32_t)(c[i] >> 32), entry = (uint32_t)c[i], b = candidate_slot(entry);
        const struct box *p = &boxes[a], *q = &boxes[b];
        if (are_many) fetch_candidate(boxes, c, i, last);
        int is = overlap(&p->now, &q->now), left = (p->flags | q->flags) & BOX_LEFT;
        if ((is == (int)(entry >> 31)) & !left || entry & NEAR_GONE) continue;
        if (left) {
            msap_worker_put(w, i);
        } else {
            msap_settle_change(&w->settler, pair_key(a, b), is);
            msap_settle_note(&w->settler, NONE, (uint32_t)i);
        }
    }
}

/* The candidates that the worker has named go over to lists. Returns 0 without memory. */
static int hand_over_named(struct grid *g, const struct job *job)
{
    const struct keys *named = &job->worker->pairs;
    for (size_t i = 0; i < named->n; i++) {
        uint64_t *c = &g->candidates.at[named->at[i]];
        uint32_t a = (uint32_t)(*c >> 32), b = candidate_slot((uint32_t)*c);
        if (!msap_near_join(&g->near, &g->near.pool, job->memory, a, b, (*c & NEAR_PAIR) != 0)) return 0;
        *c |= NEAR_GONE;
    }
    return 1;
}

/* Touches the candidates, before any of the boxes that left is put elsewhere: those that such a box has go over to
 * lists. Returns 0 without memory. */
int msap_touch_candidates(struct grid *g, struct job *job)
{
    job->worker->pairs.n = 0;
    return msap_phase_run(job->crew, job->memory, touch_candidates, g, g->candidates.n, WEIGHT_TOUCH) &&
           hand_over_named(g, job);
}

/* Lets candidates first ... last - 1, which are new, know whether they are pairs. Their boxes may be
 * others by now than those that were swept: such are on the list of those that left. */
static void tell_candidates(void *context, struct worker *w, size_t first, size_t last)
{
    const struct grid *g = context;
    const struct box *boxes = g->boxes->at;
    uint64_t *c = g->candidates.at;
    int are_many = g->boxes->used > MANY_BOXES;
    for (size_t i = first; i < last; i++) {
        const struct box *p = &boxes[c[i] >> 32], *q = &boxes[candidate_slot((uint32_t)c[i])];
        uint32_t both = p->flags & q->flags, either = p->flags | q->flags;
        if (are_many) fetch_candidate(boxes, c, i, last);
        c[i] |= overlap(&p->now, &q->now) ? NEAR_PAIR : 0;
        if ((both & BOX_LIVE) && !(either & BOX_LEFT)) continue;
        int are_near = (both & BOX_LIVE) && !(both & BOX_STATIC) && overlap(&p->fat, &q->fat);
        if (are_near) msap_worker_put(w, i);
        else c[i] |= NEAR_GONE;
    }
}

/* The same for all of them; those with a box that left go over to lists. Returns 0 without memory. */
int msap_tell_candidates(struct grid *g, struct job *job)
{
    job->worker->pairs.n = 0;
    return msap_phase_run(job->crew, job->memory, tell_candidates, g, g->candidates.n, WEIGHT_TOUCH) &&
           hand_over_named(g, job);
}

/* ------------------------------------------------------------------ events */

/* Lets lists tell of a pair what it is; one that is no more may be in none. */
static void tell(const struct grid *g, uint64_t pair, uint32_t is)
{
    const struct near_list *l = &g->near.of[pair >> 32];
    uint32_t i = msap_near_find(l, (uint32_t)(pair >> 32), (uint32_t)pair);
    if (i < l->n) l->at[i] = near_slot(l->at[i]) | is;
}

/* The same of a candidate. */
static void tell_candidate(const struct grid *g, size_t i)
{
    uint64_t *c = &g->candidates.at[i];
    const struct box *p = &g->boxes->at[*c >> 32], *q = &g->boxes->at[candidate_slot((uint32_t)*c)];
    *c = (*c & ~(uint64_t)NEAR_PAIR) | (overlap(&p->now, &q->now) ? NEAR_PAIR : 0);
}

/* Lists learn what has changed: by the notes or, where memory lacked for these, by the events. */
static void catch_up(const struct grid *g, const struct settler *s)
{
    for (size_t i = 0; !s->has_no_notes && i < s->notes.n; i++) {
        uint32_t slot = (uint32_t)(s->notes.at[i] >> 32), index = (uint32_t)s->notes.at[i];
        if (slot == NONE) g->candidates.at[index] ^= NEAR_PAIR;
        else g->near.of[slot].at[index] ^= NEAR_PAIR;
    }
    for (size_t i = 0; s->has_no_notes && i < g->candidates.n; i++) tell_candidate(g, i);
    for (size_t i = 0; s->has_no_notes && i < s->fresh.n; i++) tell(g, s->fresh.at[i], NEAR_PAIR);
    for (size_t i = 0; s->has_no_notes && i < s->doomed.n; i++) tell(g, s->doomed.at[i], 0);
}

/* After a commit that succeeded lists are to know the pairs, and a list of all that is not of
 * this commit does not know them any more. */
void msap_grid_committed(struct grid *g, const struct settler *s)
{
    if (g->will_know_pairs || s->fresh.n + s->doomed.n > 0) g->knows_pairs = g->will_know_pairs;
    catch_up(g, s);
}
