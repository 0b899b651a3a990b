/* The oracle; see oracle.h.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * It shares nothing with the library: the boxes are sorted by where they begin on x, and
 * each is compared, by the comparisons of C, with those that begin before it ends. */
#include "oracle.h"

#include <stdlib.h>
#include <string.h>

struct item {
    double min[3], max[3];
    uint32_t id;
    int is_static, is_live;
};

struct oracle {
    uint32_t ids, live;
    struct item *items[2]; /* [ids] by id: as floats, as doubles */
    struct item *sorted;
    id_pair *pairs;
    size_t n, room;
};

oracle *oracle_open(const scene *s)
{
    oracle *o = get(1, sizeof *o);
    o->ids = s->ids;
    for (int i = 0; i < 2; i++) o->items[i] = get(s->ids, sizeof **o->items);
    o->sorted = get(s->ids, sizeof *o->sorted);
    return o;
}

static void put(oracle *o, const change *c)
{
    for (int k = 0; k < 3; k++) {
        o->items[0][c->id].min[k] = c->min[k];
        o->items[0][c->id].max[k] = c->max[k];
        o->items[1][c->id].min[k] = c->true_min[k];
        o->items[1][c->id].max[k] = c->true_max[k];
    }
}

static void set_live(oracle *o, uint32_t id, int is_live, int is_static)
{
    for (int i = 0; i < 2; i++) {
        o->items[i][id].id = id;
        o->items[i][id].is_live = is_live;
        o->items[i][id].is_static = is_static;
    }
}

void oracle_step(oracle *o, const frame *f)
{
    for (size_t i = 0; i < f->n_removed; i++) set_live(o, f->removed[i], 0, 0);
    for (size_t i = 0; i < f->n_added; i++) {
        set_live(o, f->added[i].id, 1, f->added[i].is_static != 0);
        put(o, &f->added[i]);
    }
    for (size_t i = 0; i < f->n_moved; i++) put(o, &f->moved[i]);
}

static int by_min(const void *a, const void *b)
{
    const struct item *p = a, *q = b;
    return (p->min[0] > q->min[0]) - (p->min[0] < q->min[0]);
}

static int by_ids(const void *a, const void *b)
{
    const id_pair *p = a, *q = b;
    return p->a != q->a ? (p->a > q->a) - (p->a < q->a) : (p->b > q->b) - (p->b < q->b);
}

/* Lower id first. */
static id_pair in_order(uint32_t a, uint32_t b)
{
    id_pair p = {a < b ? a : b, a < b ? b : a};
    return p;
}

static int meet(const struct item *a, const struct item *b)
{
    for (int k = 0; k < 3; k++)
        if (!(a->min[k] <= b->max[k] && b->min[k] <= a->max[k]))
            return 0;
    return !(a->is_static && b->is_static);
}

static void find_true_pairs(oracle *o, const struct item *items)
{
    size_t live = 0;
    o->n = 0;
    for (uint32_t id = 0; id < o->ids; id++)
        if (items[id].is_live)
            o->sorted[live++] = items[id];
    qsort(o->sorted, live, sizeof *o->sorted, by_min);
    for (const struct item *a = o->sorted; a < o->sorted + live; a++)
        for (const struct item *b = a + 1; b < o->sorted + live && b->min[0] <= a->max[0]; b++) {
            if (!meet(a, b))
                continue;
            if (o->n == o->room) {
                o->room = 2 * o->room + 1024;
                o->pairs = realloc(o->pairs, o->room * sizeof *o->pairs);
                if (!o->pairs)
                    give_up("no memory");
            }
            o->pairs[o->n++] = in_order(a->id, b->id);
        }
    qsort(o->pairs, o->n, sizeof *o->pairs, by_ids);
}

/* Two statics are nobody's business, whoever reports them. */
static size_t tidy(const struct item *items, id_pair *found, size_t n)
{
    size_t kept = 0;
    for (size_t i = 0; i < n; i++)
        if (!(items[found[i].a].is_static && items[found[i].b].is_static))
            found[kept++] = in_order(found[i].a, found[i].b);
    qsort(found, kept, sizeof *found, by_ids);
    n = kept;
    kept = 0;
    for (size_t i = 0; i < n; i++)
        if (kept == 0 || by_ids(&found[i], &found[kept - 1]) != 0)
            found[kept++] = found[i];
    return kept;
}

verdict oracle_judge(oracle *o, int as_doubles, id_pair *found, size_t n)
{
    verdict v = {0, 0, 0};
    size_t f = 0, t = 0;
    find_true_pairs(o, o->items[as_doubles]);
    n = tidy(o->items[as_doubles], found, n);
    v.true_pairs = o->n;
    while (f < n || t < o->n) {
        int order = f == n ? 1 : t == o->n ? -1 : by_ids(&found[f], &o->pairs[t]);
        v.false_pairs += order < 0;
        v.missed += order > 0;
        f += order <= 0;
        t += order >= 0;
    }
    return v;
}
