/* What a grid holds, counted and checked.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

void msap_grid_count(const struct grid *g, msap_world_stats *stats)
{
    uint64_t neighbours = 0;
    stats->moves = g->moves;
    stats->giants = g->level[TOP].boxes;
    for (size_t i = 0; i < g->n_cells; i++) {
        const struct cell *c = &g->cell[i];
        stats->cells += c->n > 0;
        stats->cells_empty += c->n == 0;
        stats->incidences += c->n;
        if (c->n > stats->largest_cell) stats->largest_cell = c->n;
    }
    for (size_t slot = 0; slot < g->slots; slot++) neighbours += g->near.of[slot].n;
    stats->candidates = neighbours / 2;
}

/* ------------------------------------------------------------------- cells */

static uint64_t cells_of(const struct grid *g, uint32_t slot)
{
    const struct place *p = &g->place[slot];
    struct cell_walk w =
        msap_cell_walk(&g->level[p->level], msap_grid_range_on(g, msap_grid_range(g, &p->fat), p->level));
    uint64_t n = 0;
    while (cell_next(&w)) n++;
    return n;
}

static const char *row_broken(const struct grid *g, const struct box_table *boxes, const struct cell *c,
                              uint32_t row)
{
    struct bounds b;
    uint32_t slot = msap_cell_row(c, row, &b);
    if (slot >= boxes->used || g->place[slot].level == NO_LEVEL)
        return "a cell names a box that is not in the grid";
    if (memcmp(&b, &g->place[slot].fat, sizeof b) != 0) return "a cell has other bounds than the box's fat ones";
    if ((row < c->n_moving) == ((boxes->at[slot].flags & BOX_STATIC) != 0))
        return "a cell mixes static and moving";
    return NULL;
}

/* A box stands once in every cell that its fat bounds touch, and in no other. */
static const char *cells_broken(const struct grid *g, const struct box_table *boxes)
{
    uint64_t rows = 0, expected = 0;
    for (size_t i = 0; i < g->n_cells; i++) {
        const struct cell *c = &g->cell[i];
        if (c->n > c->room || c->n_moving > c->n) return "a cell is overfull";
        rows += c->n;
        for (uint32_t row = 0; row < c->n; row++) {
            const char *broken = row_broken(g, boxes, c, row);
            if (broken) return broken;
        }
    }
    for (uint32_t slot = 0; slot < boxes->used; slot++)
        if (g->place[slot].level != NO_LEVEL) expected += cells_of(g, slot);
    return rows == expected ? NULL : "a box is not in all cells that it touches";
}

/* -------------------------------------------------------------- neighbours */

static int is_near(const struct grid *g, uint32_t a, uint32_t b)
{
    const struct near_list *l = &g->near.of[a];
    uint32_t i = b > a ? 0 : l->n_above, end = b > a ? l->n_above : l->n;
    while (i < end && l->at[i] != b) i++;
    return i < end;
}

static const char *list_broken(const struct grid *g, const struct box_table *boxes, uint32_t slot)
{
    const struct near_list *l = &g->near.of[slot];
    if (l->n > l->room || l->n_above > l->n) return "a neighbour list is overfull";
    for (uint32_t i = 0; i < l->n; i++) {
        uint32_t other = l->at[i];
        if (other >= boxes->used || (other > slot) != (i < l->n_above)) return "a neighbour list is not in order";
        if (!is_near(g, other, slot)) return "a box is a neighbour, but not the other way round";
        if (boxes->at[slot].flags & boxes->at[other].flags & BOX_STATIC) return "two static boxes are neighbours";
        if (!overlap(&g->place[slot].fat, &g->place[other].fat))
            return "the fat bounds of neighbours do not overlap";
    }
    return NULL;
}

static const char *lists_broken(const struct grid *g, const struct box_table *boxes,
                                const struct pair_table *pairs)
{
    for (uint32_t slot = 0; slot < boxes->used; slot++) {
        const char *broken = list_broken(g, boxes, slot);
        if (broken) return broken;
    }
    for (size_t i = 0; i < pairs->active; i++)
        if (!is_near(g, slot_of(pairs->at[i].a), slot_of(pairs->at[i].b))) return "a pair are no neighbours";
    return NULL;
}

/* The first broken invariant of a grid that is up to date with the last commit, or
 * NULL. */
const char *msap_grid_broken(const struct grid *g, const struct box_table *boxes, const struct pair_table *pairs)
{
    for (uint32_t slot = 0; slot < boxes->used; slot++) {
        const struct box *b = &boxes->at[slot];
        int is_in = g->place[slot].level != NO_LEVEL;
        if (is_in != ((b->flags & BOX_WAS) != 0)) return "the grid holds other boxes than the last commit";
        if (is_in && !contains(&g->place[slot].fat, &b->before)) return "a box is outside its fat bounds";
    }
    const char *broken = cells_broken(g, boxes);
    return broken ? broken : lists_broken(g, boxes, pairs);
}
