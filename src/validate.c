/* Validation: every invariant of a world, checked without changing or allocating.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

static const char *box_broken(const struct box_table *t, uint32_t slot)
{
    const struct box *b = &t->at[slot];
    const struct bounds *before = box_before(t, slot);
    for (int k = 0; k < 3 && b->flags & BOX_LIVE; k++)
        if (b->now.min[k] > b->now.max[k] || ((b->flags & BOX_WAS) && before->min[k] > before->max[k]))
            return "a box is inverted";
    if (b->flags & BOX_LIVE && !box_has_left(b) && !contains(&b->fat, &b->now))
        return "a box is outside its fat bounds, but is not on the list of those that left";
    for (int k = 0; k < 3 && b->flags & BOX_LIVE; k++)
        if (b->fat.min[k] < ORDERED_MINUS_INF || b->fat.max[k] > ORDERED_INF)
            return "a box has fat bounds beyond infinity";
    if (b->flags & BOX_NEW) return "a box is still marked as new";
    if (b->left != LEFT && b->left != STAYED) return "a box neither left nor stayed";
    if (box_is_changed(t, slot)) return NULL;
    if (box_has_left(b)) return "a box left, but is not changed";
    if (!(b->flags & (BOX_LIVE | BOX_WAS))) return b->flags & BOX_STORED ? "a free slot is stored" : NULL;
    if ((b->flags & (BOX_LIVE | BOX_WAS)) != (BOX_LIVE | BOX_WAS))
        return "a box came, went or is not stored, but is not changed";
    return NULL;
}

static const char *queue_broken(const struct box_table *t, const struct slot_queue *q, uint32_t flags)
{
    size_t n = 0;
    for (uint32_t slot = q->head; slot != NONE; slot = box_next(&t->at[slot])) {
        if (slot >= t->used || n++ > t->used) return "a queue of slots is damaged";
        if ((t->at[slot].flags & (BOX_LIVE | BOX_REMOVED)) != flags) return "a slot is in the wrong queue";
    }
    return n == q->n ? NULL : "a queue of slots has another length";
}

static const char *boxes_broken(const struct box_table *t)
{
    size_t live = 0, live_static = 0, changed = 0, left = 0;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        const char *broken = box_broken(t, slot);
        if (broken) return broken;
        live += (t->at[slot].flags & BOX_LIVE) != 0;
        live_static += (t->at[slot].flags & (BOX_LIVE | BOX_STATIC)) == (BOX_LIVE | BOX_STATIC);
        changed += (size_t)box_is_changed(t, slot);
        left += (size_t)box_has_left(&t->at[slot]);
    }
    if (live != t->live || live_static != t->live_static) return "the number of live boxes is wrong";
    if (changed != t->n_changed) return "the changed list has another length than there are changed boxes";
    if (left != t->n_left) return "the list of those that left has another length than there are such boxes";
    for (size_t i = 0; i < t->n_changed; i++)
        if (t->changed[i] >= t->used || !box_is_changed(t, t->changed[i]))
            return "the changed list names a box that is not changed";
    for (size_t i = 0; i < t->n_left; i++)
        if (t->left[i] >= t->used || !box_has_left(&t->at[t->left[i]]))
            return "the list of those that left names a box that did not";
    const char *broken = queue_broken(t, &t->removed, BOX_REMOVED);
    return broken ? broken : queue_broken(t, &t->free, 0);
}

/* Each active pair's boxes overlapped at the last commit. */
static const char *overlaps_broken(const struct pair_table *t, const struct box_table *boxes)
{
    for (size_t i = 0; i < t->active; i++) {
        uint32_t a = slot_of(t->at[i].a), b = slot_of(t->at[i].b);
        if (a >= boxes->used || b >= boxes->used) return "a pair names no slot";
        const struct box *p = &boxes->at[a], *q = &boxes->at[b];
        if (p->generation != (uint32_t)t->at[i].a || q->generation != (uint32_t)t->at[i].b)
            return "a pair has a stale handle";
        if (!were_pair(boxes, a, b)) return "a pair does not overlap";
        if (p->flags & q->flags & BOX_STATIC) return "two static boxes are a pair";
    }
    return NULL;
}

msap_status msap_validate(const msap_world *world, const char **what)
{
    if (!world) return MSAP_ERROR_NULL;
    const char *broken = boxes_broken(&world->boxes);
    if (!broken && !is_grid(&world->config)) broken = msap_sap_broken(&world->sap, &world->boxes);
    if (!broken && is_grid(&world->config) && !world->stale && world->grid.is_tracking)
        broken = msap_grid_broken(&world->grid, &world->boxes, &world->pairs);
    if (!broken) broken = msap_row_set_broken(&world->grid.row_set);
    if (!broken) broken = msap_restless_broken(&world->grid);
    if (!broken) broken = msap_pairs_broken(&world->pairs);
    if (!broken) broken = msap_known_broken(&world->grid, &world->pairs);
    if (!broken) broken = msap_partners_broken(&world->grid, &world->pairs);
    if (!broken) broken = overlaps_broken(&world->pairs, &world->boxes);
    if (what) *what = broken;
    return broken ? MSAP_ERROR_CORRUPT : MSAP_OK;
}
