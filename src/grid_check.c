/* What a grid holds, counted and checked.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "rows.h"

static void count_cells(const struct layout *l, msap_world_stats *stats)
{
    stats->giants += l->level[TOP].boxes;
    for (size_t i = 0; i < l->n_cells; i++) {
        const struct cell *c = &l->cell[i];
        stats->cells += c->n > 0;
        stats->cells_empty += c->n == 0;
        stats->incidences += c->n;
        if (c->n > stats->largest_cell) stats->largest_cell = c->n;
    }
}

void msap_grid_count(const struct grid *g, msap_world_stats *stats)
{
    uint64_t neighbours = 0;
    stats->moves = g->moves;
    for (int i = 0; i < 2; i++) count_cells(&g->layout[i], stats);
    for (size_t slot = 0; slot < g->slots; slot++) neighbours += g->near.of[slot].n;
    stats->candidates = neighbours / 2;
    stats->candidates += g->candidates.n;
}

static int is_in_grid(const struct grid *g, const struct box *b) { return b->level != NO_LEVEL || rests(g, b); }

/* ------------------------------------------------------------------- cells */

static uint64_t count_cells_of(const struct grid *g, uint32_t slot)
{
    const struct box *p = &g->boxes->at[slot];
    const struct layout *l = &g->layout[p->layout];
    struct range base = range_of(l, &p->fat);
    struct cell_walk w = cell_walk(&l->level[p->level], range_on(l, &base, p->level));
    uint64_t n = 0;
    while (cell_next(&w)) n++;
    return n;
}

/* Whether what a cell knows of a box is not its fat bounds, rounded. */
static int is_rounded_otherwise(const struct layout *l, const struct box *b, const struct rounded *known)
{
    struct spot spot;
    const struct rounded *r = &spot.rounded;
    spot_of(l, &b->fat, &spot);
    return b->level != spot.level || memcmp(r->low, known->low, 3 * sizeof *r->low) != 0 ||
           memcmp(r->high, known->high, 3 * sizeof *r->high) != 0;
}

static const char *row_broken(const struct layout *l, const struct box_table *boxes, const struct cell *c,
                              uint32_t row)
{
    struct rounded r;
    uint32_t slot = msap_cell_row(c, row, &r);
    if (slot >= boxes->used || boxes->at[slot].level == NO_LEVEL)
        return "a cell names a box that is not in the grid";
    if (is_rounded_otherwise(l, &boxes->at[slot], &r)) return "a cell has other bounds than the box's fat ones";
    if ((row < c->n_moving) == ((boxes->at[slot].flags & BOX_STATIC) != 0))
        return "a cell mixes static and moving";
    return NULL;
}

/* Adds the boxes of all cells of a layout to *rows. */
static const char *layout_broken(const struct layout *l, const struct box_table *boxes, uint64_t *rows)
{
    for (size_t i = 0; i < l->n_cells; i++) {
        const struct cell *c = &l->cell[i];
        if (c->n > c->room || c->n_moving > c->n) return "a cell is overfull";
        *rows += c->n;
        for (uint32_t row = 0; row < c->n; row++) {
            const char *broken = row_broken(l, boxes, c, row);
            if (broken) return broken;
        }
    }
    return NULL;
}

/* A box stands once in every cell that its fat bounds touch, and in no other. */
static const char *cells_broken(const struct grid *g, const struct box_table *boxes)
{
    uint64_t rows = 0, expected = 0, in_grid = 0;
    for (int i = 0; i < 2; i++) {
        const char *broken = layout_broken(&g->layout[i], boxes, &rows);
        if (broken) return broken;
    }
    for (uint32_t slot = 0; slot < boxes->used; slot++) {
        if (boxes->at[slot].level == NO_LEVEL) continue;
        expected += count_cells_of(g, slot);
        in_grid++;
    }
    if (in_grid != g->layout[0].boxes + g->layout[1].boxes) return "the layouts hold another number of boxes";
    return rows == expected ? NULL : "a box is not in all cells that it touches";
}

/* -------------------------------------------------------------- neighbours */

/* A number that tells pairs of slots apart; sums of them tell sets of pairs apart. */
static uint64_t mark_of(uint32_t low, uint32_t high)
{
    uint64_t x = ((uint64_t)low << 32 | high) * 0x9e3779b97f4a7c15u;
    x = (x ^ x >> 31) * 0xbf58476d1ce4e5b9u;
    return x ^ x >> 29;
}

static const char *entry_broken(const struct grid *g, uint32_t slot, uint32_t entry)
{
    const struct box_table *boxes = g->boxes;
    uint32_t other = near_slot(entry);
    if (other >= boxes->used) return "a neighbour list names no slot";
    const struct box *p = &boxes->at[slot], *q = &boxes->at[other];
    if (p->flags & q->flags & BOX_STATIC) return "two static boxes are neighbours";
    if (!overlap(bounds_in_grid(g, slot), bounds_in_grid(g, other)))
        return "the fat bounds of neighbours do not overlap";
    if (((entry & NEAR_PAIR) != 0) != (other > slot && were_pair(boxes, slot, other)))
        return "a neighbour list is wrong about a pair";
    return NULL;
}

static const char *list_broken(const struct grid *g, uint32_t slot, uint64_t *marks, size_t *pairs)
{
    const struct near_list *l = &g->near.of[slot];
    if (l->n > near_room(l) || l->n_above > l->n || l->noted) return "a neighbour list is overfull or untidy";
    for (uint32_t i = 0; i < l->n; i++) {
        uint32_t other = near_slot(l->at[i]);
        const char *broken = entry_broken(g, slot, l->at[i]);
        if (broken) return broken;
        if ((other > slot) != (i < l->n_above)) return "a neighbour list is not in order";
        *marks += i < l->n_above ? mark_of(slot, other) : 0 - mark_of(other, slot);
        *pairs += (l->at[i] & NEAR_PAIR) != 0;
    }
    return NULL;
}

/* Whether the two boxes of a pair rest as they are: then they are no neighbours. */
static int both_rest(const struct grid *g, const msap_pair *pair)
{
    return rests(g, &g->boxes->at[slot_of(pair->a)]) && rests(g, &g->boxes->at[slot_of(pair->b)]);
}

/* The marks of all pairs, added from the lower box and taken off from the higher one,
 * leave nothing if lists are mutual. */
static const char *lists_broken(const struct grid *g, const struct pair_table *pairs)
{
    uint64_t marks = 0;
    size_t in_lists = 0;
    for (uint32_t slot = 0; slot < g->boxes->used; slot++) {
        const char *broken = list_broken(g, slot, &marks, &in_lists);
        if (broken) return broken;
    }
    if (marks != 0) return "a box is a neighbour, but not the other way round";
    for (size_t i = 0; i < pairs->active; i++) in_lists += both_rest(g, &pairs->at[i]);
    return in_lists == pairs->active ? NULL : "a pair are no neighbours";
}

/* -------------------------------------------------------------- candidates */

static const char *candidate_broken(const struct grid *g, uint32_t a, uint32_t entry, int is_told)
{
    uint32_t b = near_slot(entry);
    const struct box *p = &g->boxes->at[a], *q = &g->boxes->at[b];
    if (a >= g->boxes->used || b >= g->boxes->used || !is_in_grid(g, p) || !is_in_grid(g, q))
        return "a candidate is not in the grid";
    if (p->flags & q->flags & BOX_STATIC) return "two static boxes are candidates";
    if (!overlap(&p->fat, &q->fat)) return "the skins of candidates do not overlap";
    if (is_told && ((entry & NEAR_PAIR) != 0) != were_pair(g->boxes, a, b))
        return "a candidate is wrong about a pair";
    return NULL;
}

/* While boxes rest in skins. */
static const char *candidates_broken(const struct grid *g, const struct pair_table *pairs)
{
    size_t found = 0;
    for (size_t i = 0; i < g->candidates.n; i++) {
        uint32_t a = (uint32_t)(g->candidates.at[i] >> 32), entry = (uint32_t)g->candidates.at[i];
        int is_told = i >= g->untold;
        if (!is_told && candidate_is_void(g->boxes, a, near_slot(entry))) continue;
        const char *broken = candidate_broken(g, a, entry, is_told);
        if (broken) return broken;
        found += (size_t)were_pair(g->boxes, a, near_slot(entry));
    }
    for (size_t slot = 0; slot < g->slots; slot++)
        if (g->near.of[slot].n > 0) return "a box in a skin has a list";
    return found == pairs->active ? NULL : "a pair are no candidates";
}

/* -------------------------------------------------------------------- rows */

/* Adds the marks of a box in the rows that it is said to be in. */
static uint64_t marks_in_rows(const struct rows *r, const struct row_range *range, uint32_t slot)
{
    uint32_t name = slot | (range->is_static ? 0 : ROW_MOVES);
    uint64_t marks = 0;
    for (uint32_t z = 0, line = range->row; z <= range->more[1]; z++, line = next_line(r, line))
        for (uint32_t y = 0, row = line; y <= range->more[0]; y++, row = next_row(r, row))
            marks += mark_of(name | (y == 0 ? ROW_STARTS_1 : 0) | (z == 0 ? ROW_STARTS_2 : 0), row);
    return marks;
}

/* Of rows that can be kept: each is sorted; and the marks of all boxes in the rows that they are said to be in,
 * less those of all entries, leave nothing. */
const char *msap_row_set_broken(const struct row_set *set)
{
    uint64_t marks = 0;
    size_t rows = (size_t)set->rows.count[0] * set->rows.count[1];
    if (set->slots == 0) return NULL;
    for (uint32_t slot = 0; slot < set->slots; slot++)
        if (set->range[slot].row != NO_ROW) marks += marks_in_rows(&set->rows, &set->range[slot], slot);
    for (size_t row = 0; row < rows; row++)
        for (uint32_t i = row_start(set, row); i < set->end[row]; i++) {
            if (i > row_start(set, row) && set->min[0][i] < set->min[0][i - 1]) return "a row is not sorted";
            marks -= mark_of(set->id[i], (uint32_t)row);
        }
    return marks == 0 ? NULL : "rows name other boxes than are said to be in them";
}

/* The first broken invariant of a grid that is up to date with the last commit, or
 * NULL. */
const char *msap_grid_broken(const struct grid *g, const struct box_table *boxes, const struct pair_table *pairs)
{
    for (uint32_t slot = 0; slot < boxes->used; slot++) {
        const struct box *b = &boxes->at[slot];
        int is_in = is_in_grid(g, b);
        if (is_in != ((b->flags & BOX_WAS) != 0)) return "the grid holds other boxes than the last commit";
        if (is_in && !contains(&b->fat, box_before(boxes, slot))) return "a box is outside its fat bounds";
    }
    const char *broken = g->is_resting ? msap_rest_broken(g) : NULL;
    if (!broken) broken = cells_broken(g, boxes);
    if (broken) return broken;
    return g->in_skins ? candidates_broken(g, pairs) : lists_broken(g, pairs);
}
