/* Wide boxes: those that touch too many rows to be in any.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Where all boxes are pruned (jump.c, renew.c), each wide box is tested against those before it and against all
 * rows: what a giant meets are most boxes, however they are sorted. Few boxes are wide; where many are, boxes are
 * tracked in cells of several levels instead (track.c). While boxes rest in rows, wide ones are in cells. */
#include "rows.h"

/* Wide boxes that are tested by a worker. */
struct testing {
    const struct pruning *pruning;
    const struct sweeps *sweeps;
    struct pair_buffer *found;
    take_pairs_fn take;
    const void *context;
};

/* What was found is taken, unless there is room for more than so many. */
static inline void take_unless_room(const struct testing *t, struct worker *w, size_t more)
{
    if (t->found->n + more < MOST_BUFFERED) return;
    t->take(t->context, w, t->found);
    t->found->n = 0;
}

/* A wide box has met another one. */
static inline void put(const struct testing *t, uint32_t wide, uint32_t other)
{
    struct pair_buffer *f = t->found;
    f->a[f->n] = wide;
    f->b[f->n++] = other;
}

/* Asks a row for a wide box. Some boxes are found in two rows. */
static size_t ask_row(const void *context, struct worker *w, const struct row_question *q, size_t row, size_t n)
{
    const struct testing *t = context;
    const struct row_set *set = t->pruning->set;
    uint32_t found[ENTRIES_ASKED + FOUND_SLACK];
    struct row_sweep at = {.i = row_start(set, row), .end = set->end[row]};
    while (at.i < at.end) {
        size_t more = t->sweeps->ask_row(set, q, &at, found);
        take_unless_room(t, w, more);
        for (size_t i = 0; i < more; i++) {
            if (w->tag[found[i]] == w->token) continue;
            w->tag[found[i]] = w->token;
            put(t, q->self, found[i]);
        }
        n += more;
    }
    return n;
}

/* The bounds by which a wide box is pruned. */
static inline struct readable bounds_of_wide(const struct pruning *p, size_t i)
{
    const struct readable r = {*bounds_of_slot(&p->bounds, p->wide[i]), 0};
    return r;
}

/* Tests a wide box against those before it. */
static void test_wide_ones(const struct testing *t, struct worker *w, size_t i, const struct bounds *own)
{
    const struct pruning *p = t->pruning;
    const struct box *box = p->job->boxes->at;
    for (size_t k = 0; k < i; k++) {
        const struct readable other = bounds_of_wide(p, k);
        uint32_t both = box[p->wide[i]].flags & box[p->wide[k]].flags;
        take_unless_room(t, w, 1);
        if (overlap(own, &other.bounds) && !(both & BOX_STATIC)) put(t, p->wide[i], p->wide[k]);
    }
}

/* Tests wide boxes first ... last - 1 against those before and against all rows, which are written; what they
 * meet is taken. */
void msap_wide_test(const struct pruning *p, const struct sweeps *sweeps, size_t first, size_t last,
                    take_pairs_fn take, const void *context, struct worker *w)
{
    struct pair_buffer found;
    const struct testing t = {p, sweeps, &found, take, context};
    found.n = 0;
    for (size_t i = first; i < last; i++) {
        const struct readable own = bounds_of_wide(p, i);
        uint32_t slot = p->wide[i], is_static = p->job->boxes->at[slot].flags & BOX_STATIC;
        const struct row_question q = {.lacks = is_static ? ROW_MOVES : 0, .self = slot};
        test_wide_ones(&t, w, i, &own.bounds);
        msap_worker_new_token(w);
        msap_rows_ask(p->rows, &own.bounds, &q, ask_row, &t, w, 0);
    }
    take(context, w, &found);
}

/* Whether a box, as it is now, touches too many rows to be in any. */
static int is_wide(const struct rows *r, const struct box_table *t, uint32_t slot)
{
    const struct readable now = {t->at[slot].now, 0};
    struct row_span span = rows_of(r, &now.bounds);
    return rows_in(&span) > MOST_ROWS;
}

/* Notes how many there are in a pruning, of boxes or of skins. */
void msap_wide_note(struct grid *g, const struct pruning *p)
{
    g->wide_found = 0;
    for (size_t i = 0; i < p->n_wide; i++) g->wide_found += (size_t)is_wide(p->rows, g->boxes, p->wide[i]);
    g->wide_pruned = p->n_wide;
    g->wide_found_in = g->commit;
}

/* How many of the pairs have a wide box: estimated from some. */
int64_t msap_wide_pairs(const struct grid *g, const struct pair_table *pairs)
{
    enum { SAMPLES = 64 };
    size_t step = pairs->active / SAMPLES + 1, n = 0;
    for (size_t i = 0; i < pairs->active; i += step)
        n += is_wide(&g->rows, g->boxes, slot_of(pairs->at[i].a)) ||
             is_wide(&g->rows, g->boxes, slot_of(pairs->at[i].b));
    return (int64_t)(n * step < pairs->active ? n * step : pairs->active);
}
