/* An axis: the end points of all stored boxes on one axis, kept sorted.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The array holds one key for each end point (internal.h) between the sentinels 0
 * and UINT64_MAX, and `rank` leads from an end point to its key. Here is what
 * treats all end points at once: batch insertion (paper I.4b), batch deletion
 * (I.5b) and sorting anew. Moving one end point, which is where overlaps are
 * noticed, is in slide.c.
 *
 * Arrays and not linked lists: a key is 8 bytes, as much as the links alone would
 * be, and neighbours are in the same cache line (I.2). */
#include "internal.h"

static void put_sentinels(struct axis *x, size_t stored)
{
    x->key[0] = 0;
    x->key[2 * stored + 1] = UINT64_MAX;
}

/* Room for the end points of boxes in slots below `slots`. */
int msap_axis_reserve(struct axis *x, struct memory *m, size_t slots)
{
    if (slots > SIZE_MAX / 2 - 1) return 0;
    int is_first = x->room_key == 0;
    if (!msap_memory_reserve(m, &x->key, &x->room_key, 2 * slots + 2, x->room_key, sizeof *x->key)) return 0;
    if (is_first) put_sentinels(x, 0);
    return msap_memory_reserve(m, &x->rank, &x->room_rank, 2 * slots, x->room_rank, sizeof *x->rank);
}

void msap_axis_trim(struct axis *x, struct memory *m, size_t slots)
{
    msap_memory_shrink(m, &x->key, &x->room_key, 2 * slots + 2, sizeof *x->key);
    msap_memory_shrink(m, &x->rank, &x->room_rank, 2 * slots, sizeof *x->rank);
}

void msap_axis_free(struct axis *x, struct memory *m)
{
    msap_memory_free(m, x->key, x->room_key, sizeof *x->key);
    msap_memory_free(m, x->rank, x->room_rank, sizeof *x->rank);
    memset(x, 0, sizeof *x);
}

static void put(struct axis *x, size_t at, uint64_t key)
{
    x->key[at] = key;
    x->rank[key_end(key)] = (uint32_t)at;
}

/* Batch deletion: of the end points of `stored` boxes, drops those of boxes without
 * BOX_STORED (the tag of paper I.5b) in one pass. */
void msap_axis_drop(struct axis *x, size_t stored, const struct box *boxes)
{
    size_t kept = 1;
    for (size_t i = 1; i <= 2 * stored; i++)
        if (boxes[key_box(x->key[i])].flags & BOX_STORED) put(x, kept++, x->key[i]);
    put_sentinels(x, (kept - 1) / 2);
}

/* Batch insertion: merges n sorted keys into those of `stored` boxes, from the back,
 * so that every key moves once (paper I.4b). */
void msap_axis_merge(struct axis *x, size_t stored, uint64_t *incoming, size_t n)
{
    size_t old = 2 * stored, to = old + n;
    put_sentinels(x, stored + n / 2);
    for (size_t i = n; i > 0; to--)
        if (x->key[old] > incoming[i - 1]) { /* the sentinel 0 is above nothing */
            put(x, to, x->key[old]);
            old--;
        } else {
            put(x, to, incoming[i - 1]);
            i--;
        }
}

/* Sorts the keys at 1 ... 2 * stored, whatever their order; scratch as in sort_keys. */
void msap_axis_sort(struct axis *x, size_t stored, uint64_t *scratch)
{
    put_sentinels(x, stored);
    msap_sort_keys(x->key + 1, 2 * stored, scratch);
    for (size_t i = 1; i <= 2 * stored; i++) x->rank[key_end(x->key[i])] = (uint32_t)i;
}

/* The first broken invariant of axis k over boxes that are stored, or NULL. The
 * array holds the bounds that its boxes had when they were last brought up to date:
 * those of now if they have not changed since. */
const char *msap_axis_broken(const struct axis *x, size_t stored, const struct box_table *boxes, uint32_t k)
{
    if (x->room_key == 0) return stored ? "an axis has no array" : NULL;
    if (x->key[0] != 0 || x->key[2 * stored + 1] != UINT64_MAX) return "a sentinel of an axis is damaged";
    for (size_t i = 1; i <= 2 * stored; i++) {
        uint64_t key = x->key[i];
        uint32_t box = key_box(key);
        if (key <= x->key[i - 1]) return "end points are not in order";
        if (box >= boxes->used || !(boxes->at[box].flags & BOX_STORED)) return "an end point has no box";
        if (x->rank[key_end(key)] != i) return "a rank does not lead to its end point";
        const struct box *b = &boxes->at[box];
        int32_t value = key & KEY_MAX_BIT ? b->now.max[k] : b->now.min[k];
        if ((b->flags & BOX_WAS) && !box_is_changed(boxes, box) && key != key_make(value, key_end(key) & 1, box))
            return "an end point is not its box's bound";
    }
    return NULL;
}
