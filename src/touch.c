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

static inline gaps gaps_above(const struct box *boxes, const struct pair_buffer *p, size_t i)
{
    return gaps_of(&boxes[p->a[i]].now, &boxes[near_slot(p->b[i])].now);
}

/* Which of four of them are not what they were, a bit each. */
static inline uint32_t changed_above(const struct box *boxes, const struct pair_buffer *p, size_t i)
{
    return upper_bits_of_four(p->b + i) ^ overlaps_of(gaps_above(boxes, p, i), gaps_above(boxes, p, i + 1),
                                                      gaps_above(boxes, p, i + 2), gaps_above(boxes, p, i + 3));
}

/* Pairs that are not what they were any more: their entries tell which. */
static void settle_changed(struct settler *s, const struct above *p, size_t i, uint32_t changed)
{
    for (; changed > 0; i++, changed >>= 1) {
        if (!(changed & 1)) continue;
        uint32_t a = p->pair.a[i], entry = p->pair.b[i];
        msap_settle_change(s, (uint64_t)a << 32 | near_slot(entry), !(entry & NEAR_PAIR));
        msap_settle_note(s, a, p->index[i]);
    }
}

/* Nearly all are what they were: so they are looked at by fours. */
static void settle_above(struct settler *s, const struct above *p, size_t n)
{
    const struct box *boxes = s->boxes->at;
    size_t i = 0;
    s->touched += n;
    for (size_t k = 0; k < n && s->boxes->used > MANY_BOXES; k++) prefetch(&boxes[near_slot(p->pair.b[k])]);
    for (; n - i >= 4; i += 4) settle_changed(s, p, i, changed_above(boxes, &p->pair, i));
    for (; i < n; i++) {
        int is = overlap(&boxes[p->pair.a[i]].now, &boxes[near_slot(p->pair.b[i])].now);
        settle_changed(s, p, i, (uint32_t)is ^ p->pair.b[i] >> 31);
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

/* Where there are many boxes, fetches the neighbours of one. */
static void fetch_neighbours(const struct touching *t, uint32_t slot)
{
    const struct near_list *l = &t->of[slot];
    if (t->boxes->used <= MANY_BOXES) return;
    for (uint32_t i = 0; i < l->n; i++) prefetch(&t->boxes->at[near_slot(l->at[i])]);
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
        if (c + 3 * AHEAD < last) prefetch(&t->of[t->slot[c + 3 * AHEAD]]);
        if (c + 2 * AHEAD < last) prefetch(t->of[t->slot[c + 2 * AHEAD]].at);
        if (c + AHEAD < last) fetch_neighbours(t, t->slot[c + AHEAD]);
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

/* ------------------------------------------------------------------ events */

/* Lets lists tell of a pair what it is; one that is no more may be in none. */
static void tell(const struct grid *g, uint64_t pair, uint32_t is)
{
    const struct near_list *l = &g->near.of[pair >> 32];
    uint32_t i = msap_near_find(l, (uint32_t)(pair >> 32), (uint32_t)pair);
    if (i < l->n) l->at[i] = near_slot(l->at[i]) | is;
}

/* Lists learn what has changed: by the notes or, where memory lacked for these, by the events. */
static void catch_up(const struct grid *g, const struct settler *s)
{
    for (size_t i = 0; !s->has_no_notes && i < s->notes.n; i++) {
        uint32_t slot = (uint32_t)(s->notes.at[i] >> 32), index = (uint32_t)s->notes.at[i];
        g->near.of[slot].at[index] ^= NEAR_PAIR;
    }
    for (size_t i = 0; s->has_no_notes && i < s->fresh.n; i++) tell(g, s->fresh.at[i], NEAR_PAIR);
    for (size_t i = 0; s->has_no_notes && i < s->doomed.n; i++) tell(g, s->doomed.at[i], 0);
}

/* After a commit that succeeded lists are to know the pairs, and a list of all that is not of
 * this commit does not know them any more. */
void msap_grid_committed(struct grid *g, const struct settler *s)
{
    msap_watch(g);
    if (g->will_know_pairs || s->fresh.n + s->doomed.n > 0) g->knows_pairs = g->will_know_pairs;
    catch_up(g, s);
}
