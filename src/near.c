/* Neighbour lists: which fat boxes overlap, from the side of each box.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * b is in the list of a exactly if a is in the list of b, and they are exactly if
 * the fat bounds of a and b overlap and not both are static. A list holds the
 * slots above its own first, so that a walk over all pairs can visit each from
 * its lower box alone. Within the two parts the order is free. */
#include "internal.h"

static unsigned class_for(uint32_t room)
{
    unsigned class = 0;
    while (((uint32_t)NEAR_UNIT << class) < room) class ++;
    return class;
}

static int grow(struct near_list *l, struct near_lists *all, struct memory *m, uint32_t room)
{
    unsigned class = class_for(room);
    uint32_t *grown = msap_pool_get(&all->pool, m, class);
    if (!grown) return 0;
    if (l->n > 0) memcpy(grown, l->at, l->n * sizeof *grown);
    if (l->room > 0) msap_pool_put(&all->pool, m, l->at, class_for(l->room));
    l->at = grown;
    l->room = (uint32_t)NEAR_UNIT << class;
    return 1;
}

/* Puts `other` into the list of `self`, where it is not yet. Returns 0 without memory. */
int msap_near_add(struct near_lists *all, struct memory *m, uint32_t self, uint32_t other)
{
    struct near_list *l = &all->of[self];
    if (l->n == l->room && !grow(l, all, m, l->n + 1)) return 0;
    l->at[l->n] = other;
    if (other > self) {
        l->at[l->n] = l->at[l->n_above];
        l->at[l->n_above++] = other;
    }
    l->n++;
    return 1;
}

/* Takes what stands at index i out of the list. */
void msap_near_take_out(struct near_list *l, uint32_t i)
{
    if (i < l->n_above) {
        l->at[i] = l->at[--l->n_above];
        i = l->n_above;
    }
    l->at[i] = l->at[--l->n];
}

/* Takes `other` out of the list of `self`, where it is. */
void msap_near_remove(struct near_lists *all, uint32_t self, uint32_t other)
{
    struct near_list *l = &all->of[self];
    uint32_t i = other > self ? 0 : l->n_above;
    while (l->at[i] != other) i++;
    msap_near_take_out(l, i);
}

/* Gives the memory of an empty list back. */
void msap_near_drop(struct near_lists *all, struct memory *m, uint32_t self)
{
    struct near_list *l = &all->of[self];
    if (l->room > 0) msap_pool_put(&all->pool, m, l->at, class_for(l->room));
    memset(l, 0, sizeof *l);
}

/* Empties all lists. */
void msap_near_empty(struct near_lists *all, struct memory *m, size_t slots)
{
    for (uint32_t slot = 0; slot < slots; slot++) {
        struct near_list *l = &all->of[slot];
        if (l->room > 0 && msap_pool_is_large(class_for(l->room)))
            msap_pool_put(&all->pool, m, l->at, class_for(l->room));
        memset(l, 0, sizeof *l);
    }
    msap_pool_empty(&all->pool);
}
