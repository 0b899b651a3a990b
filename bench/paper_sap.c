/* The paper's single SAP: how it comes into being, batches, its end.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "paper_sap.h"

#include <math.h>
#include <stdlib.h>

static const how plain = {ARRAYS, KEYS, BY_INDEX, 0, 0};

static int by_key(const void *a, const void *b)
{
    uint64_t x = ((const end_point *)a)->key, y = ((const end_point *)b)->key;
    return (x > y) - (x < y);
}

/* The sorted end points of boxes first ... first + n - 1 on an axis. */
static void sorted_end_points(end_point *at, const aabb *boxes, uint32_t first, uint32_t n, int k)
{
    for (uint32_t i = 0; i < n; i++) {
        at[2 * i] = end_point_make(plain, boxes[first + i].min[k], first + i);
        at[2 * i + 1] = end_point_make(plain, boxes[first + i].max[k], (first + i) | MAX_BIT);
    }
    qsort(at, 2 * (size_t)n, sizeof *at, by_key);
}

/* From sorted keys to what is compared. */
static void convert(how h, end_point *at, size_t n, const aabb *boxes, int k)
{
    for (size_t i = 0; i < n && h.compare == FLOATS; i++) {
        const aabb *b = &boxes[box_of(at[i])];
        at[i].real.value = is_max(at[i]) ? b->max[k] : b->min[k];
    }
}

static end_point sentinel(how h, int top)
{
    end_point p;
    p.key = top ? UINT64_MAX : 0;
    if (h.compare == FLOATS) p.real.value = top ? INFINITY : -INFINITY;
    return p;
}

static void make_array(paper_sap *s, how h, const end_point *sorted, int k)
{
    uint32_t n = 2 * s->boxes;
    s->at[k] = get(2 * (size_t)s->room + 2, sizeof *s->at[k]);
    s->rank[k] = get(2 * (size_t)s->room, sizeof *s->rank[k]);
    s->at[k][0] = sentinel(h, 0);
    s->at[k][n + 1] = sentinel(h, 1);
    for (uint32_t i = 1; i <= n; i++) {
        s->at[k][i] = sorted[i - 1];
        s->rank[k][number_of(sorted[i - 1])] = i;
    }
}

static void make_list(paper_sap *s, how h, const end_point *sorted, int k)
{
    uint32_t n = 2 * s->boxes;
    s->node[k] = get(n + 2, sizeof *s->node[k]);
    struct node *last = &s->node[k][n], *top = last + 1;
    last->end = sentinel(h, 0);
    for (uint32_t i = 0; i < n; i++) {
        struct node *next = &s->node[k][number_of(sorted[i])];
        next->end = sorted[i];
        link_between(next, last, top);
        last = next;
    }
    top->end = sentinel(h, 1);
}

static void find_pairs(paper_sap *s, const aabb *boxes, uint32_t n)
{
    msap_boxes all = boxes_of(boxes);
    msap_index_pair *pairs;
    size_t count;
    if (msap_prune(NULL, n, &all, &pairs, &count, NULL)) give_up("msap_prune failed");
    for (size_t i = 0; i < count; i++) pair_set_add(&s->pairs, pairs[i].a, pairs[i].b);
    msap_prune_free(NULL, pairs, count);
}

paper_sap *paper_sap_make(how h, const aabb *boxes, uint32_t n, uint32_t room)
{
    paper_sap *s = get(1, sizeof *s);
    end_point *sorted = get(2 * (size_t)n, sizeof *sorted);
    s->boxes = n;
    s->room = room;
    s->bounds = get(room, sizeof *s->bounds);
    memcpy(s->bounds, boxes, n * sizeof *boxes);
    for (int k = 0; k < 3; k++) {
        sorted_end_points(sorted, boxes, 0, n, k);
        convert(h, sorted, 2 * (size_t)n, boxes, k);
        if (h.storage == LISTS) make_list(s, h, sorted, k);
        else make_array(s, h, sorted, k);
    }
    free(sorted);
    pair_set_begin(&s->pairs);
    find_pairs(s, boxes, n);
    return s;
}

void paper_sap_free(paper_sap *s)
{
    for (int k = 0; k < 3; k++) {
        free(s->at[k]);
        free(s->rank[k]);
        free(s->node[k]);
    }
    free(s->bounds);
    pair_set_end(&s->pairs);
    free(s);
}

/* ------------------------------------------------------------------ batches */

/* Merges n sorted end points in, from the back. */
static void merge_on(paper_sap *s, int k, const end_point *incoming, uint32_t n)
{
    uint32_t old = 2 * s->boxes + 1, to = old + n;
    while (to > 0) {
        end_point next = n > 0 && incoming[n - 1].key > s->at[k][old].key ? incoming[--n] : s->at[k][old--];
        s->at[k][to] = next;
        if (next.key != UINT64_MAX) s->rank[k][number_of(next)] = to;
        to--;
        if (n == 0) return;
    }
}

static void find_new_pairs(paper_sap *s, uint32_t n)
{
    msap_boxes old = boxes_of(s->bounds), fresh = boxes_of(s->bounds + s->boxes);
    msap_index_pair *pairs;
    size_t count;
    if (msap_prune(NULL, n, &fresh, &pairs, &count, NULL)) give_up("msap_prune failed");
    for (size_t i = 0; i < count; i++) pair_set_add(&s->pairs, s->boxes + pairs[i].a, s->boxes + pairs[i].b);
    msap_prune_free(NULL, pairs, count);
    if (msap_prune_bipartite(NULL, s->boxes, &old, n, &fresh, &pairs, &count, NULL))
        give_up("msap_prune_bipartite failed");
    for (size_t i = 0; i < count; i++) pair_set_add(&s->pairs, pairs[i].a, s->boxes + pairs[i].b);
    msap_prune_free(NULL, pairs, count);
}

void paper_sap_insert_batch(paper_sap *s, const aabb *boxes, uint32_t n)
{
    end_point *incoming = get(2 * (size_t)n, sizeof *incoming);
    memcpy(s->bounds + s->boxes, boxes, n * sizeof *boxes);
    for (int k = 0; k < 3; k++) {
        sorted_end_points(incoming, s->bounds, s->boxes, n, k);
        merge_on(s, k, incoming, 2 * n);
    }
    free(incoming);
    find_new_pairs(s, n);
    s->boxes += n;
}

void paper_sap_remove_batch(paper_sap *s, const unsigned char *is_doomed, uint32_t n)
{
    for (int k = 0; k < 3; k++) {
        uint32_t kept = 1, end = 2 * s->boxes + 1;
        for (uint32_t i = 1; i < end; i++) {
            end_point p = s->at[k][i];
            if (is_doomed[box_of(p)]) continue;
            s->rank[k][number_of(p)] = kept;
            s->at[k][kept++] = p;
        }
        s->at[k][kept] = s->at[k][end];
    }
    for (uint32_t i = 0; i < s->pairs.n;) {
        active_pair p = s->pairs.at[i];
        if (is_doomed[p.a] || is_doomed[p.b]) pair_set_remove(&s->pairs, p.a, p.b);
        else i++;
    }
    s->boxes -= n;
}
