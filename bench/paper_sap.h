/* The paper's single SAP (part I), and the alternatives it argues against.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * It works as the paper says, not as the library does: a box is moved at once, on
 * one axis after the other, and a pair is added or removed while its end points
 * pass each other. What can be done in several ways is said by a `how`, which every
 * function gets as a constant and which the compiler is made to resolve, so that
 * each combination becomes code of its own, as if it were the only one. */
#ifndef PAPER_SAP_H
#define PAPER_SAP_H

#include "pair_set.h"
#include "scene.h"

#include <string.h>

#if defined(__GNUC__)
#define RESOLVED static inline __attribute__((always_inline))
#else
#define RESOLVED static inline
#endif

enum { ARRAYS, LISTS };                  /* how.storage */
enum { KEYS, INTEGERS, FLOATS };         /* how.compare: all 64 bits, the value as an integer, as a float */
enum { BY_INDEX, BY_END_POINT, BY_BOX }; /* how.test: ranks, values of the end points, bounds kept with the box */

typedef struct how {
    int storage, compare, test;
    int no_sentinels;     /* 1: the ends of the arrays are looked for */
    int removes_untested; /* 1: a pair is looked for in the set whenever it seems to end */
} how;

/* 8 bytes; on little-endian machines the value is the upper half of the key. */
typedef union end_point {
    uint64_t key;
    struct {
        uint32_t owner; /* box, and MAX_BIT for a max */
        uint32_t code;  /* the bound as an integer of the same order */
    } integer;
    struct {
        uint32_t owner;
        float value;
    } real;
} end_point;

#define MAX_BIT 0x80000000u

/* The number of an end point: 2 * box, plus 1 for a max. */
RESOLVED uint32_t number_of(end_point p) { return p.integer.owner << 1 | p.integer.owner >> 31; }
RESOLVED uint32_t box_of(end_point p) { return p.integer.owner & ~MAX_BIT; }
RESOLVED int is_max(end_point p) { return (p.integer.owner & MAX_BIT) != 0; }

struct node {
    struct node *previous, *next;
    end_point end;
};

typedef struct paper_sap {
    uint32_t boxes, room; /* that are stored: 0 ... boxes - 1 */
    end_point *at[3];     /* arrays: [1 + 2 * room + 1] sorted, between two sentinels */
    uint32_t *rank[3];    /* arrays: where the end points are in them */
    struct node *node[3]; /* lists: of each end point, and two sentinels */
    aabb *bounds;         /* of the boxes, brought up to date axis by axis */
    pair_set pairs;
    uint64_t crossings, seeming, removed; /* pairs that seemed to end; pairs that did */
} paper_sap;

paper_sap *paper_sap_make(how h, const aabb *boxes, uint32_t n, uint32_t room);
void paper_sap_free(paper_sap *s);

/* Batch insertion (I.4b): merges n new boxes into the arrays, and prunes for their
 * pairs (I.4c). Batch deletion (I.5b): n boxes, which are tagged, go. Both for arrays
 * and keys. */
void paper_sap_insert_batch(paper_sap *s, const aabb *boxes, uint32_t n);
void paper_sap_remove_batch(paper_sap *s, const unsigned char *is_doomed, uint32_t n);

/* ------------------------------------------------------------- comparisons */

/* A float as an integer of the same order (appendix A). */
RESOLVED uint32_t encoded(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits & 0x80000000u ? ~bits : bits | 0x80000000u;
}

RESOLVED end_point end_point_make(how h, float value, uint32_t owner)
{
    end_point p;
    p.integer.owner = owner;
    if (h.compare == FLOATS) p.real.value = value;
    else p.integer.code = encoded(value);
    return p;
}

RESOLVED int is_above(how h, end_point a, end_point b)
{
    if (h.compare == FLOATS) return a.real.value > b.real.value;
    return h.compare == INTEGERS ? a.integer.code > b.integer.code : a.key > b.key;
}

RESOLVED end_point end_of(const paper_sap *s, how h, int k, uint32_t number)
{
    return h.storage == LISTS ? s->node[k][number].end : s->at[k][s->rank[k][number]];
}

RESOLVED int overlap_on(const paper_sap *s, how h, int k, uint32_t a, uint32_t b)
{
    if (h.test == BY_INDEX)
        return (s->rank[k][2 * a] < s->rank[k][2 * b + 1]) & (s->rank[k][2 * b] < s->rank[k][2 * a + 1]);
    if (h.test == BY_BOX)
        return (s->bounds[a].min[k] <= s->bounds[b].max[k]) & (s->bounds[b].min[k] <= s->bounds[a].max[k]);
    return !is_above(h, end_of(s, h, k, 2 * a), end_of(s, h, k, 2 * b + 1)) &&
           !is_above(h, end_of(s, h, k, 2 * b), end_of(s, h, k, 2 * a + 1));
}

/* Whether boxes overlap on the two axes that are not k. */
RESOLVED int overlap_beside(const paper_sap *s, how h, int k, uint32_t a, uint32_t b)
{
    return overlap_on(s, h, k == 0, a, b) && overlap_on(s, h, k == 2 ? 1 : 2, a, b);
}

/* ------------------------------------------------------------------ moving */

/* An end point that goes up or down has passed another, of the other kind. */
RESOLVED void cross(paper_sap *s, how h, int k, end_point mover, end_point other, int up)
{
    uint32_t a = box_of(mover), b = box_of(other);
    s->crossings++;
    if (is_max(mover) == up) {
        if (overlap_beside(s, h, k, a, b)) pair_set_add(&s->pairs, a, b);
        return;
    }
    s->seeming++;
    if (h.removes_untested || overlap_beside(s, h, k, a, b))
        s->removed += (uint64_t)pair_set_remove(&s->pairs, a, b);
}

/* `silent`: no pairs are made or ended. */
RESOLVED void slide_in_array(paper_sap *s, how h, int k, end_point mover, int up, int silent)
{
    end_point *at = s->at[k];
    uint32_t *rank = s->rank[k], i = rank[number_of(mover)];
    for (;;) {
        uint32_t next = up ? i + 1 : i - 1;
        if (h.no_sentinels && (up ? next > 2 * s->boxes : next == 0)) break;
        end_point other = at[next];
        if (!(up ? is_above(h, mover, other) : is_above(h, other, mover))) break;
        at[i] = other;
        rank[number_of(other)] = i;
        i = next;
        if (!silent && is_max(mover) != is_max(other)) cross(s, h, k, mover, other, up);
    }
    at[i] = mover;
    rank[number_of(mover)] = i;
}

RESOLVED void link_between(struct node *n, struct node *previous, struct node *next)
{
    n->previous = previous;
    n->next = next;
    previous->next = n;
    next->previous = n;
}

RESOLVED void slide_in_list(paper_sap *s, how h, int k, end_point mover, int up, int silent)
{
    struct node *n = &s->node[k][number_of(mover)], *other = up ? n->next : n->previous;
    n->end = mover;
    while (up ? is_above(h, mover, other->end) : is_above(h, other->end, mover)) {
        if (!silent && is_max(mover) != is_max(other->end)) cross(s, h, k, mover, other->end, up);
        other = up ? other->next : other->previous;
    }
    if (other == (up ? n->next : n->previous)) return;
    n->previous->next = n->next;
    n->next->previous = n->previous;
    if (up) link_between(n, other->previous, other);
    else link_between(n, other, other->next);
}

RESOLVED void slide(paper_sap *s, how h, int k, end_point mover, int up, int silent)
{
    if (h.storage == LISTS) slide_in_list(s, h, k, mover, up, silent);
    else slide_in_array(s, h, k, mover, up, silent);
}

RESOLVED void slide_to(paper_sap *s, how h, int k, end_point to, int silent)
{
    slide(s, h, k, to, is_above(h, to, end_of(s, h, k, number_of(to))), silent);
}

/* Moves a box on one axis; the end that leads goes first. */
RESOLVED void move_on(paper_sap *s, how h, int k, uint32_t box, const aabb *to, int silent)
{
    end_point min = end_point_make(h, to->min[k], box), max = end_point_make(h, to->max[k], box | MAX_BIT);
    int up = is_above(h, max, end_of(s, h, k, 2 * box + 1));
    s->bounds[box].min[k] = to->min[k];
    s->bounds[box].max[k] = to->max[k];
    slide_to(s, h, k, up ? max : min, silent);
    slide_to(s, h, k, up ? min : max, silent);
}

RESOLVED void move_box(paper_sap *s, how h, uint32_t box, const aabb *to)
{
    for (int k = 0; k < 3; k++) move_on(s, h, k, box, to, 0);
}

/* ------------------------------------------------- coming and going (I.4, I.5) */

/* Puts both end points of a new box behind all others. */
RESOLVED void append_on(paper_sap *s, how h, int k, uint32_t box)
{
    uint32_t behind = 2 * s->boxes + 1;
    end_point last = s->at[k][behind];
    for (uint32_t e = 0; e < 2; e++) {
        s->at[k][behind + e] = end_point_make(h, 3e38f, box | e << 31);
        s->rank[k][2 * box + e] = behind + e;
    }
    s->at[k][behind + 2] = last;
}

/* The simple approach (I.4a): the box comes into being far away and moves in, and only
 * on the last axis pairs are looked for. Its number is s->boxes. */
RESOLVED void insert_one(paper_sap *s, how h, const aabb *to)
{
    uint32_t box = s->boxes;
    for (int k = 0; k < 3; k++) append_on(s, h, k, box);
    s->boxes++;
    for (int k = 0; k < 3; k++) move_on(s, h, k, box, to, k < 2);
}

/* The simple approach (I.5a): the box moves far away, which ends its pairs, and its end
 * points, the last then, are cut off. Only on the first axis pairs can end. The number
 * of the box is not used again. */
RESOLVED void remove_one(paper_sap *s, how h, uint32_t box)
{
    const aabb far = {{3e38f, 3e38f, 3e38f}, {3e38f, 3e38f, 3e38f}};
    for (int k = 0; k < 3; k++) move_on(s, h, k, box, &far, k > 0);
    s->boxes--;
    for (int k = 0; k < 3; k++) s->at[k][2 * s->boxes + 1] = s->at[k][2 * s->boxes + 3];
}

#endif
