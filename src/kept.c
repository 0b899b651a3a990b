/* Keeping rows: those of the last pruning are brought up to date, instead of being made anew (rows.c).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * From one pruning to the next most boxes stay in the same rows, and in nearly the same order: that is what makes
 * a persistent SAP worth it (paper I.3, there of end points; and I.4b, batch insertion). So a set of rows knows in
 * which of them each box is. While these are the same rows,
 *
 * 1. only the boxes that are in others than before, or come or go, are counted, sorted and named, as rows.c does.
 * 2. Each row is what is kept of it, sorted by insertion, merged with what comes to it.
 *
 * What is kept is that of all boxes whose rows are the same. Where at the last pruning many were in others, all
 * are listed anew. The last rows stay as they are from the first of these steps to the second, between which, in a
 * renewal (renew.c), commits may lie: one that makes others gives the renewal up. */
#include "rows.h"

/* Whether it is known where boxes were in as many rows; and in these, since on other axes, or in wider rows,
 * hardly one would be where it was. */
int msap_kept_are_told(const struct pruning *p)
{
    const struct rows *now = p->rows, *then = &p->last->rows;
    return p->last->slots > 0 && now->axis[0] == then->axis[0] && /* the other axes follow from this one */
           now->scale[0] == then->scale[0] && now->scale[1] == then->scale[1] && now->count[0] == then->count[0] &&
           now->count[1] == then->count[1];
}

/* Whether, by the last pruning, most will be where they were. Where more move, to bring rows up to date takes
 * fewer instructions still, but not less time: which boxes move, and how far, no processor can guess. */
int msap_kept_are_most(const struct pruning *p)
{
    enum { SHARE = 8 };
    return p->last->changed * SHARE <= p->job->boxes->live;
}

/* How many entries there are in the rows of the last pruning. */
static size_t entries_of(const struct row_set *set)
{
    return set->end[(size_t)set->rows.count[0] * set->rows.count[1] - 1];
}

/* How many words the arrays take. */
size_t msap_kept_words(const struct pruning *p)
{
    size_t rows = (size_t)p->rows->count[0] * p->rows->count[1];
    size_t copied = p->last == p->set ? rows + entries_of(p->last) : 0;
    return p->slots / 8 + 1 + (rows + copied) / 2 + 1;
}

/* Places them. Where the last rows are in the same set they are copied. Returns what is behind them. */
uint64_t *msap_kept_place(struct pruning *p, uint64_t *words)
{
    size_t rows = (size_t)p->rows->count[0] * p->rows->count[1], entries = entries_of(p->last);
    p->has_moved = (uint8_t *)words;
    words += p->slots / 8 + 1;
    p->end = (uint32_t *)(void *)words;
    p->kept_end = p->last->end;
    p->kept_id = p->last->id;
    p->entries = entries;
    if (p->last == p->set) {
        p->kept_end = p->end + rows;
        p->kept_id = p->kept_end + rows;
        memcpy(p->kept_end, p->last->end, rows * sizeof *p->kept_end);
        memcpy(p->kept_id, p->last->id, entries * sizeof *p->kept_id);
    }
    return words + (rows + (p->last == p->set ? rows + entries : 0)) / 2 + 1;
}

/* The key of a box that is named in a row: by its min on the sweep axis. */
static inline uint64_t key_of(const struct pruning *p, uint32_t axis, uint32_t name)
{
    return key_make(bounds_of_slot(&p->bounds, row_slot(name))->min[axis], 0, 0) | name;
}

/* Writes the keys of those of n names of which the boxes have not moved. Returns how many they are. */
static size_t keep(const struct pruning *p, const uint32_t *name, size_t n, uint64_t *key)
{
    const uint8_t *has_moved = p->has_moved;
    uint32_t axis = p->rows->axis[0];
    size_t kept = 0;
    for (size_t i = 0; i < n; i++) {
        key[kept] = key_of(p, axis, name[i]);
        kept += !has_moved[row_slot(name[i])];
    }
    return kept;
}

/* Puts so many boxes, named in order, into their places among the n keys, from behind. */
static void insert_coming(const struct pruning *p, const uint32_t *name, size_t coming, uint64_t *key, size_t n)
{
    uint32_t axis = p->rows->axis[0];
    while (coming > 0) {
        uint64_t inserted = key_of(p, axis, name[coming - 1]);
        for (; n > 0 && key[n - 1] > inserted; n--) key[n - 1 + coming] = key[n - 1];
        key[n - 1 + coming--] = inserted;
    }
}

/* Makes the rows of what is kept and what comes, whose names stand there row after row. The keys of a row stand
 * where those of what comes stood, and are sorted with the room for bounds, which are yet to be written. */
void msap_kept_merge(struct pruning *p, const uint32_t *coming)
{
    struct row_set *set = p->set;
    size_t rows = (size_t)p->rows->count[0] * p->rows->count[1];
    uint64_t *key = p->order, *scratch = (uint64_t *)(void *)set->words;
    uint32_t from = 0, next = 0, at = 0;
    for (size_t row = 0; row < rows; row++) {
        size_t n = keep(p, p->kept_id + from, p->kept_end[row] - from, key), more = p->end[row] - next;
        msap_sort_nearly_sorted(key, n, scratch);
        insert_coming(p, coming + next, more, key, n);
        for (size_t i = 0; i < n + more; i++) set->id[at + i] = (uint32_t)key[i];
        from = p->kept_end[row];
        next = p->end[row];
        set->end[row] = at += (uint32_t)(n + more);
    }
}
