/* Pools: memory for many small arrays that grow, shrink and go.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A pool hands out arrays of unit << c bytes for a class c = 0, 1, 2, ... Small
 * ones are cut from slabs; what is given back waits in the free list of its class.
 * Large ones come from the allocator one by one. Slabs stay with the pool, also
 * when it is emptied, so that a world that is warm asks for nothing; pool_free
 * gives them back. */
#include "internal.h"

enum { SLAB_UNITS = 2 << POOL_CLASSES };

/* What stands at the beginning of a slab, and of a free array. */
struct slab {
    struct slab *next;
};

static size_t slab_bytes(const struct pool *p) { return POOL_ALIGN + SLAB_UNITS * p->unit; }

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
    void *s;
    msap_pool_empty(p);
    while ((s = pop(&p->spare)) != NULL) msap_memory_free(m, s, slab_bytes(p), 1);
}

static void *cut(struct pool *p, struct memory *m, unsigned class)
{
    size_t units = (size_t)1 << class;
    if (p->cut < units) {
        void *s = p->spare ? pop(&p->spare) : msap_memory_alloc(m, slab_bytes(p), 1);
        if (!s) return NULL;
        push(&p->slabs, s);
        p->cut = SLAB_UNITS;
    }
    p->cut -= units;
    return (char *)p->slabs + POOL_ALIGN + p->cut * p->unit;
}

int msap_pool_is_large(unsigned class) { return class >= POOL_CLASSES; }

/* An array of unit << class bytes, or NULL. */
void *msap_pool_get(struct pool *p, struct memory *m, unsigned class)
{
    if (msap_pool_is_large(class)) return msap_memory_alloc(m, p->unit, (size_t)1 << class);
    return p->free[class] ? pop(&p->free[class]) : cut(p, m, class);
}

void msap_pool_put(struct pool *p, struct memory *m, void *array, unsigned class)
{
    if (msap_pool_is_large(class)) msap_memory_free(m, array, p->unit, (size_t)1 << class);
    else push(&p->free[class], array);
}
