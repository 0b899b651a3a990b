/* Claims about batches (I.4, I.5): many boxes that come or go at once, one by one or
 * as a batch.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A box that goes alone either moves far away (I.5a), or its pairs are looked up in
 * the pair manager and its end points cut out: of an array, which closes up, or of
 * a list. The pair manager has no list of the pairs of a box, so all are looked at. */
#include "paper_sap.h"

#include <stdlib.h>

/* So many of the boxes of a scene come, or go; the last ones, which lie anywhere. */
struct batch {
    const scene *scene;
    uint32_t boxes;
};

static const how arrays = {ARRAYS, KEYS, BY_INDEX, 0, 0};
static const how lists = {LISTS, KEYS, BY_BOX, 0, 0};

/* ------------------------------------------------------------------- coming */

static outcome done(paper_sap *s, double start)
{
    outcome o = {clock_ms() - start, pair_set_check(&s->pairs)};
    paper_sap_free(s);
    return o;
}

static outcome insert_singly(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes, first = all - b->boxes;
    paper_sap *s = paper_sap_make(arrays, b->scene->start, first, all);
    double start = clock_ms();
    for (uint32_t i = first; i < all; i++) insert_one(s, arrays, &b->scene->start[i]);
    return done(s, start);
}

static outcome insert_batch(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes, first = all - b->boxes;
    paper_sap *s = paper_sap_make(arrays, b->scene->start, first, all);
    double start = clock_ms();
    paper_sap_insert_batch(s, b->scene->start + first, b->boxes);
    return done(s, start);
}

/* -------------------------------------------------------------------- going */

static outcome remove_batch(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes, first = all - b->boxes;
    paper_sap *s = paper_sap_make(arrays, b->scene->start, all, all);
    unsigned char *is_doomed = get(all, 1);
    double start = clock_ms();
    memset(is_doomed + first, 1, b->boxes);
    paper_sap_remove_batch(s, is_doomed, b->boxes);
    free(is_doomed);
    return done(s, start);
}

static outcome remove_far(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes;
    paper_sap *s = paper_sap_make(arrays, b->scene->start, all, all);
    double start = clock_ms();
    for (uint32_t i = all; i-- > all - b->boxes;) remove_one(s, arrays, i);
    return done(s, start);
}

static void remove_pairs_of(paper_sap *s, uint32_t box)
{
    for (uint32_t i = 0; i < s->pairs.n;) {
        active_pair p = s->pairs.at[i];
        if (p.a == box || p.b == box) pair_set_remove(&s->pairs, p.a, p.b);
        else i++;
    }
}

/* Closes the gap that an end point leaves; the upper sentinel is at `top`. */
static void cut_out(paper_sap *s, int k, uint32_t number, uint32_t top)
{
    for (uint32_t i = s->rank[k][number]; i < top; i++) {
        s->at[k][i] = s->at[k][i + 1];
        if (i + 1 < top) s->rank[k][number_of(s->at[k][i])] = i;
    }
}

static outcome remove_from_arrays(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes;
    paper_sap *s = paper_sap_make(arrays, b->scene->start, all, all);
    double start = clock_ms();
    for (uint32_t box = all; box-- > all - b->boxes;) {
        remove_pairs_of(s, box);
        for (int k = 0; k < 3; k++) {
            cut_out(s, k, 2 * box, 2 * s->boxes + 1);
            cut_out(s, k, 2 * box + 1, 2 * s->boxes);
        }
        s->boxes--;
    }
    return done(s, start);
}

static outcome remove_from_lists(const void *what)
{
    const struct batch *b = what;
    uint32_t all = b->scene->boxes;
    paper_sap *s = paper_sap_make(lists, b->scene->start, all, all);
    double start = clock_ms();
    for (uint32_t box = all; box-- > all - b->boxes;) {
        remove_pairs_of(s, box);
        for (int k = 0; k < 3; k++)
            for (uint32_t e = 0; e < 2; e++) {
                struct node *n = &s->node[k][2 * box + e];
                n->previous->next = n->next;
                n->next->previous = n->previous;
            }
    }
    return done(s, start);
}

/* ------------------------------------------------------------------ the claim */

static void compare_batches(const scene *s, uint32_t boxes, const char *name)
{
    const struct batch b = {s, boxes};
    const way coming[] = {{"as a batch", insert_batch, &b}, {"one by one", insert_singly, &b}};
    const way going[] = {{"as a batch", remove_batch, &b},
                         {"one by one, moved far away", remove_far, &b},
                         {"one by one, cut out of arrays", remove_from_arrays, &b},
                         {"one by one, cut out of lists", remove_from_lists, &b}};
    compare("insertion", name, coming, 2, 5, NULL);
    compare("deletion", name, going, 4, 5, NULL);
}

void claim_batches(void)
{
    static const recipe r = {"10,000 boxes", 10000, 0, 2, 0, 0, STRAIGHT, 0, 0};
    scene s = scene_make(&r);
    compare_batches(&s, 1, "1 of 10,000 boxes");
    compare_batches(&s, 10, "10 of 10,000");
    compare_batches(&s, 100, "100 of 10,000");
    compare_batches(&s, 1000, "1,000 of 10,000");
    scene_free(&s);
}
