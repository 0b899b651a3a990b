/* Box pruning: the overlapping pairs of one set of boxes (complete) or of two
 * (bipartite), by a sweep along one axis (paper I.4c).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The boxes are sorted by their min on the sweep axis. Of two boxes that overlap
 * there, one starts first, and the other starts before that one ends; so from each
 * box the sweep runs over those behind it until one starts after its end, and
 * tests the remaining axes. Of a bipartite pair either box may start first: one
 * sweep runs from each set through the other, and the second leaves out equal mins,
 * so that every pair is found once.
 *
 * The bounds stand in split arrays, since the sweep reads the mins of the sweep
 * axis far more often than all the rest. */
#include "internal.h"

/* Lays the arrays of n boxes out in `words`, PRUNE_SET_WORDS(n) of them. */
void msap_prune_set_place(struct prune_set *set, uint64_t *words, size_t n)
{
    int32_t *at = (int32_t *)(void *)words;
    set->n = n;
    for (int k = 0; k < 3; k++) {
        set->min[k] = at + (size_t)(2 * k) * n;
        set->max[k] = at + (size_t)(2 * k + 1) * n;
    }
    set->id = (uint32_t *)(void *)(at + 6 * n);
}

/* Writes one row; `axis` becomes the first. */
void msap_prune_set_put(struct prune_set *set, size_t row, const struct bounds *bounds, uint32_t axis, uint32_t id)
{
    for (uint32_t k = 0; k < 3; k++) {
        uint32_t from = axis + k < 3 ? axis + k : axis + k - 3;
        set->min[k][row] = bounds->min[from];
        set->max[k][row] = bounds->max[from];
    }
    set->id[row] = id;
}

static int meet(const struct prune_set *a, size_t i, const struct prune_set *b, size_t j)
{
    return (a->min[1][i] <= b->max[1][j]) & (b->min[1][j] <= a->max[1][i]) & (a->min[2][i] <= b->max[2][j]) &
           (b->min[2][j] <= a->max[2][i]);
}

/* Sweeps from row i of a through b, from `first` on. */
static void sweep_from(const struct prune_set *a, size_t i, const struct prune_set *b, size_t first,
                       prune_found found, void *context)
{
    int32_t end = a->max[0][i];
    for (size_t j = first; j < b->n && b->min[0][j] <= end; j++)
        if (meet(a, i, b, j)) found(context, a->id[i], b->id[j]);
}

void msap_prune_within(const struct prune_set *set, prune_found found, void *context)
{
    for (size_t i = 0; i < set->n; i++) sweep_from(set, i, set, i + 1, found, context);
}

void msap_prune_between(const struct prune_set *a, const struct prune_set *b, prune_found found, void *context)
{
    for (size_t i = 0, first = 0; i < a->n; i++) {
        while (first < b->n && b->min[0][first] < a->min[0][i]) first++;
        sweep_from(a, i, b, first, found, context);
    }
    for (size_t j = 0, first = 0; j < b->n; j++) {
        while (first < a->n && a->min[0][first] <= b->min[0][j]) first++;
        sweep_from(b, j, a, first, found, context);
    }
}
