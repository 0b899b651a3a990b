/* Pools: memory for many small arrays that grow, shrink and go.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A pool hands out arrays of 1, 2, 3, 4, 6, 8, 12, ... units for a class 0, 1, 2, ...:
 * powers of two and, between them, three halves, so that little room stays empty. Small
 * ones are cut from slabs; what is given back waits in the free list of its class.
 * Large ones come from the allocator one by one. Slabs stay with the pool, also
 * when it is emptied, so that a world that is warm asks for nothing; pool_free
 * gives them back.
 *
 * A worker, which may not allocate, is lent arrays: its stock. */
#include "internal.h"

enum { LEAST_SLAB = 512, SHARE = 32 };

/* What stands in the first line of a slab; of a free array, `next` alone. */
struct slab {
    struct slab *next;
    size_t units;
};

static size_t slab_bytes(const struct pool *p, size_t units) { return CACHE_LINE + units * p->unit; }

static void push(struct slab **list, void *array)
{
    struct slab *s = array;
    s->next = *list;
    *list = s;
}

static void *pop(struct slab **list)
{
    struct slab *s = *list;
    if (s) *list = s->next;
    return s;
}

/* A slab with room for a thirty-second of what the pool has and, if that would fill a huge page, for
 * as much: so a large pool comes in large pieces. */
static struct slab *new_slab(struct pool *p, struct memory *m)
{
    const size_t huge = (HUGE_PAGE - 2 * CACHE_LINE) / p->unit; /* memory_alloc takes one line, too */
    size_t units = larger_of(p->units / SHARE, p->units > huge ? huge : LEAST_SLAB);
    struct slab *s = msap_memory_alloc(m, slab_bytes(p, units), 1);
    if (!s) return NULL;
    s->units = units;
    p->units += units;
    return s;
}

void msap_pool_init(struct pool *p, size_t unit)
{
    memset(p, 0, sizeof *p);
    p->unit = unit;
}

/* All arrays but the large ones count as given back. */
void msap_pool_empty(struct pool *p)
{
    struct slab *s;
    while ((s = pop(&p->slabs)) != NULL) push(&p->spare, s);
    memset(p->free, 0, sizeof p->free);
    p->cut = 0;
}

/* Gives the memory of an emptied pool back. */
void msap_pool_free(struct pool *p, struct memory *m)
{
    struct slab *s;
    msap_pool_empty(p);
    while ((s = pop(&p->spare)) != NULL) msap_memory_free(m, s, slab_bytes(p, s->units), 1);
    p->units = 0;
}

static void *cut(struct pool *p, struct memory *m, unsigned class)
{
    size_t units = pool_units(class);
    if (p->cut < units) {
        struct slab *s = p->spare ? pop(&p->spare) : new_slab(p, m);
        if (!s) return NULL;
        push(&p->slabs, s);
        p->cut = s->units;
    }
    p->cut -= units;
    return (char *)p->slabs + CACHE_LINE + p->cut * p->unit;
}

/* The class of the smallest arrays of so many units or more. */
unsigned msap_pool_class_for(size_t units)
{
    unsigned class = 0;
    while (pool_units(class) < units) class ++;
    return class;
}

/* An array of the units of a class, or NULL. A stock, for which m is NULL, has no large ones, and of
 * others only what waits. */
void *msap_pool_get(struct pool *p, struct memory *m, unsigned class)
{
    if (pool_is_large(class)) return msap_memory_alloc(m, pool_units(class), p->unit);
    if (p->free[class]) return pop(&p->free[class]);
    return m ? cut(p, m, class) : NULL;
}

void msap_pool_put(struct pool *p, struct memory *m, void *array, unsigned class)
{
    if (pool_is_large(class)) msap_memory_free(m, array, pool_units(class), p->unit);
    else push(&p->free[class], array);
}

/* Lends n arrays of each of the first `classes`, or as many as there is memory for. */
void msap_pool_lend(struct pool *p, struct memory *m, struct pool *stock, unsigned classes, size_t n)
{
    for (unsigned class = 0; class < classes; class ++)
        for (size_t i = 0; i < n; i++) {
            void *array = msap_pool_get(p, m, class);
            if (!array) return;
            push(&stock->free[class], array);
        }
}

/* Takes back what a stock has. */
void msap_pool_take_back(struct pool *p, struct pool *stock)
{
    for (int class = 0; class < POOL_CLASSES; class ++)
        while (stock->free[class]) push(&p->free[class], pop(&stock->free[class]));
}
