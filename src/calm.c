/* Calming: restless boxes that stand still by now go back to the rows of those that do.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * While a few are pruned (restless.c), they become ever more: each box that moves once is one of them. Some of them
 * that stand still are no reason to prune all again, since what they are to the others is known. So they are only
 * put into the rows of the others (a batch insertion, paper I.4b), once they have cost as much as that does:
 *
 * 1. Those that stand still are sorted into rows of their own, but for wide ones, which stay restless.
 * 2. Row by row, these are merged with the others, of which what is of restless boxes is left out. (What is of boxes
 *    that were removed stays: another box that gets such a slot is restless.) */
#include "rows.h"

/* Rows in the making: merged from two sets. */
struct merging {
    const uint32_t *tag; /* [slots] of boxes that were restless: */
    uint32_t token;      /* this one */
    const struct row_set *kept, *coming;
    struct row_set *to;
    uint32_t n; /* entries that it has by now */
};

/* Entries first ... last - 1 of a set come next, by fours: what is written behind them is slack or overwritten. */
static inline void put(struct merging *m, const struct row_set *from, uint32_t first, uint32_t last)
{
    enum { ARRAYS = 7 };
    const int32_t *read = from->words + first;
    int32_t *write = m->to->words + m->n;
    ptrdiff_t read_step = from->max[0] - from->min[0], write_step = m->to->max[0] - m->to->min[0];
    for (uint32_t i = first; i < last; i += 4, read += 4, write += 4)
        for (int k = 0; k < ARRAYS; k++) memcpy(write + k * write_step, read + k * read_step, 4 * sizeof *write);
    m->n += last - first;
}

/* From entry i of a row on, behind the last of those that are kept and start before a value. */
static inline uint32_t end_of_kept(const struct merging *m, uint32_t i, uint32_t end, int32_t before)
{
    const uint32_t *id = m->kept->id, *tag = m->tag, token = m->token;
    const int32_t *min = m->kept->min[0];
    while (i < end && tag[row_slot(id[i])] != token && min[i] <= before) i++;
    return i;
}

/* What comes to a row is put before what starts behind it. */
static void merge_row(struct merging *m, size_t row)
{
    const struct row_set *kept = m->kept, *coming = m->coming;
    uint32_t j = row_start(coming, row), last = coming->end[row], end = kept->end[row];
    for (uint32_t i = row_start(kept, row), k; i < end; i = k) {
        k = end_of_kept(m, i, end, j < last ? coming->min[0][j] : INT32_MAX);
        put(m, kept, i, k);
        if (k == end) break;
        if (m->tag[row_slot(kept->id[k])] == m->token) {
            k++; /* it is left out */
        } else {
            put(m, coming, j, j + 1);
            j++;
        }
    }
    put(m, coming, j, last);
    m->to->end[row] = m->n;
}

static void tag_restless(struct worker *w, const struct restless *r)
{
    msap_worker_new_token(w);
    for (size_t i = 0; i < r->n; i++) w->tag[r->slot[i]] = w->token;
}

/* Puts restless boxes, which have rows of their own, into those of the calm ones. They are written to the set for
 * the rows of a renewal, of which there is none while boxes are restless; then both sets change places. In which row
 * a box is, is not known from then on. Returns 0 without memory. */
static int merge(struct grid *g, const struct job *job, const struct row_set *coming)
{
    struct row_set *to = &g->renewal.set, merged;
    size_t rows = (size_t)g->rows.count[0] * g->rows.count[1];
    size_t most = (size_t)g->row_set.end[rows - 1] + coming->end[rows - 1];
    struct merging m = {job->worker->tag, 0, &g->row_set, coming, to, 0};
    if (!msap_row_set_make(to, job->memory, most) ||
        !msap_memory_reserve(job->memory, &to->end, &to->room_end, rows, 0, sizeof *to->end))
        return 0;
    tag_restless(job->worker, &g->restless);
    m.token = job->worker->token;
    for (size_t row = 0; row < rows; row++) merge_row(&m, row);
    msap_row_set_close(to, m.n);
    to->rows = g->rows;
    to->slots = 0;
    merged = *to;
    *to = g->row_set;
    g->row_set = merged;
    return msap_rows_note_reach(&g->row_set, &g->rows, job->memory);
}

/* Puts those of the restless boxes that changed first. Returns how many they are. */
static size_t changed_first(struct restless *r, const struct box_table *t)
{
    size_t n = 0;
    for (size_t i = 0; i < r->n; i++) {
        uint32_t slot = r->slot[i];
        if (!box_is_changed(t, slot)) continue;
        r->slot[i] = r->slot[n];
        r->slot[n++] = slot;
    }
    return n;
}

/* Restless boxes that have not changed become calm, but for wide ones. Returns 0 without memory. */
int msap_calm(struct grid *g, struct job *job)
{
    struct restless *r = &g->restless;
    struct box *box = job->boxes->at;
    struct pruning p;
    size_t n = changed_first(r, job->boxes), last = r->n;
    if (!msap_restless_list(g, job, &p, r->slot + n, last - n) || !merge(g, job, p.set)) return 0;
    for (size_t i = n; i < last; i++) box[r->slot[i]].flags &= ~(uint32_t)BOX_RESTLESS;
    for (size_t i = 0; i < p.n_wide; i++) {
        box[p.wide[i]].flags |= BOX_RESTLESS;
        r->slot[n++] = p.wide[i];
    }
    r->n = n;
    r->idle = 0;
    return 1;
}
