/* Touching neighbours: every pair of which a box has changed is settled.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Lists are short and of all lengths, and a loop over each would end in a surprise for
 * the processor every time, which costs as much as several tests. So their pairs first go
 * into one buffer, by fours and without a question, and the buffer is settled in one loop.
 *
 * A list tells whether two boxes were a pair; once the events of a commit are known, they
 * are noted there for the next one. */
#include "internal.h"

/* A part of a commit over the lists, and over changed slots. */
struct touching {
    const struct near_list *of;
    const struct box_table *boxes;
    const uint32_t *slot;
};

/* The pairs of boxes with neighbours above, whose entries tell whether they were. */
static void settle_above(struct settler *s, const struct pair_buffer *p, size_t n)
{
    const struct box *boxes = s->boxes->at;
    s->touched += n;
    for (size_t i = 0; i < n; i++) {
        uint32_t a = p->a[i], entry = p->b[i], b = near_slot(entry);
        int is = overlap(&boxes[a].now, &boxes[b].now);
        if (is != (int)(entry >> 31)) msap_settle_change(s, (uint64_t)a << 32 | b, is);
    }
}

/* Appends the pairs of a box with neighbours above to the n that are buffered: four at a
 * time, whether or not there are as many, since a list has room for fours. Returns how
 * many are buffered then. */
static inline size_t buffer_above(struct settler *s, struct pair_buffer *p, size_t n, uint32_t slot,
                                  const struct near_list *l)
{
    for (uint32_t i = 0; l->at; i += 4) {
        uint32_t left = l->n_above - i;
        set_four(p->a + n, slot);
        copy_four(p->b + n, l->at + i);
        n += left < 4 ? left : 4;
        if (n >= MOST_BUFFERED) {
            settle_above(s, p, n);
            n = 0;
        }
        if (left <= 4) break;
    }
    return n;
}

/* Every pair once, from the lower box, whether or not a box of it changed. */
static void touch_all(void *context, struct worker *w, size_t first, size_t last)
{
    const struct near_list *of = ((const struct touching *)context)->of;
    struct pair_buffer above;
    size_t n = 0;
    for (uint32_t slot = (uint32_t)first; slot < last; slot++)
        n = buffer_above(&w->settler, &above, n, slot, &of[slot]);
    settle_above(&w->settler, &above, n);
}

/* Every pair of a changed box; of two changed boxes from the lower one. */
static void touch_changed(void *context, struct worker *w, size_t first, size_t last)
{
    enum { AHEAD = 8 };
    const struct touching *t = context;
    struct pair_buffer above;
    size_t n = 0;
    for (size_t c = first; c < last; c++) {
        uint32_t slot = t->slot[c];
        const struct near_list *l = &t->of[slot];
        if (c + 2 * AHEAD < last) prefetch(&t->of[t->slot[c + 2 * AHEAD]]);
        if (c + AHEAD < last) prefetch(t->of[t->slot[c + AHEAD]].at);
        n = buffer_above(&w->settler, &above, n, slot, l);
        for (uint32_t i = l->n_above; i < l->n; i++)
            if (!box_is_changed(t->boxes, l->at[i])) settle(&w->settler, slot, l->at[i]);
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
        return msap_phase_run(job->crew, job->memory, touch_all, &all, t->used, weight);
    return msap_phase_run(job->crew, job->memory, touch_changed, &all, t->n_changed, weight);
}

/* ------------------------------------------------------------------ events */

/* Notes n events of one lower box in its list: many in one walk. */
static void note_events_of_one(struct grid *g, const uint64_t *event, size_t n, int is_pair)
{
    enum { MANY = 4 };
    if (n < MANY) {
        for (size_t i = 0; i < n; i++) msap_near_mark(&g->near, event[i], is_pair);
        return;
    }
    struct near_list *l = &g->near.of[event[0] >> 32];
    msap_grid_new_token(g);
    for (size_t i = 0; i < n; i++) g->tag[(uint32_t)event[i]] = g->token;
    for (uint32_t i = 0; i < l->n_above; i++) {
        uint32_t other = near_slot(l->at[i]);
        if (g->tag[other] == g->token) l->at[i] = is_pair ? other | NEAR_PAIR : other;
    }
}

static void note_events(struct grid *g, const struct keys *events, int is_pair)
{
    for (size_t first = 0, last; first < events->n; first = last) {
        uint64_t low = events->at[first] >> 32;
        for (last = first + 1; last < events->n && events->at[last] >> 32 == low; last++) continue;
        note_events_of_one(g, events->at + first, last - first, is_pair);
    }
}

/* The events of a commit that succeeded: lists are to know the pairs, and a list of all that
 * is not of this commit does not know them any more. */
void msap_grid_note_events(struct grid *g, const struct keys *fresh, const struct keys *doomed)
{
    if (g->will_know_pairs || fresh->n + doomed->n > 0) g->knows_pairs = g->will_know_pairs;
    if (!g->is_tracking || g->lists_are_anew) return;
    note_events(g, fresh, 1);
    note_events(g, doomed, 0);
}
