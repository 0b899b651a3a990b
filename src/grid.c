/* The grid: boxes rasterised into the cells that they touch (paper II.3).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Space is cut into cells of one size, and cell x of an axis shares its memory with
 * cell x + count: the paper's wrapped grid, or its hashed grid with the remainder as
 * the hash function. So the grid has no bounds, and what is far outside costs no
 * more than what is inside. Boxes that merely share memory are told apart by the
 * sweep of the cell, which tests their bounds in full.
 *
 * A box that would touch more than MOST_CELLS cells goes to a coarser level, whose
 * cells are 4 times as wide; level TOP is one cell, for giants. To find what a box
 * overlaps, the cells that it covers on every level that holds boxes are swept. A
 * level has no more cells to visit than it has memory for, however large the box. */
#include "cells.h"

/* ------------------------------------------------------------ ranges of cells */

static int32_t floor_divide(int32_t a, int32_t b)
{
    int32_t quotient = a / b;
    return quotient - (a % b < 0);
}

/* Cells of a grid that is as told, from units. */
struct range msap_range_as_told(const struct layout *l, struct range units)
{
    for (int k = 0; k < 3; k++) {
        units.low[k] = floor_divide(units.low[k] - l->origin[k], l->width[k]);
        units.high[k] = floor_divide(units.high[k] - l->origin[k], l->width[k]);
    }
    return units;
}

static uint64_t cells_in(struct range r, uint32_t shift)
{
    uint64_t cells = 1;
    for (uint32_t k = 0; k < 3; k++) {
        uint64_t wide = (uint64_t)((int64_t)floor_shift(r.high[k], shift) - floor_shift(r.low[k], shift) + 1);
        cells *= wide < 65536 ? wide : 65536;
    }
    return cells;
}

/* The finest level on which a box touches no more than MOST_CELLS. */
uint32_t msap_level_for(struct range base)
{
    uint32_t level = 0;
    if (base.high[0] <= base.low[0] + 1 && base.high[1] <= base.low[1] + 1 && base.high[2] <= base.low[2] + 1)
        return 0; /* 8 cells at the most */
    while (level < TOP && cells_in(base, LEVEL_SHIFT * level) > MOST_CELLS) level++;
    return level;
}

/* -------------------------------------------------------------- life and end */

/* The config and the boxes live as long as the grid. */
void msap_grid_init(struct grid *g, const msap_config *config, struct box_table *boxes)
{
    memset(g, 0, sizeof *g);
    g->config = config;
    g->boxes = boxes;
    g->is_empty = 1;
    g->sweep = msap_sweep_for(config->simd);
    g->sweep_row = msap_sweep_row_for(config->simd);
    msap_pool_init(&g->pool, sizeof(struct cell_block));
    msap_pool_init(&g->near.pool, NEAR_UNIT * sizeof(uint32_t));
}

/* Room for boxes in slots below `slots`. */
int msap_grid_reserve(struct grid *g, struct memory *m, size_t slots)
{
    size_t had = g->slots;
    if (slots <= had) return 1;
    if (slots > SIZE_MAX / 2 - 8) return 0;
    if (!msap_memory_reserve(m, &g->near.of, &g->near.room, slots, had, sizeof *g->near.of) ||
        !msap_memory_reserve(m, &g->start, &g->room_start, slots, had, sizeof *g->start))
        return 0;
    memset(g->near.of + had, 0, (slots - had) * sizeof *g->near.of);
    g->slots = slots;
    return 1;
}

/* Empties all cells and lists; the boxes keep their skins. */
void msap_grid_empty_cells(struct grid *g, struct memory *m)
{
    if (g->is_empty) return;
    for (int i = 0; i < 2; i++) msap_layout_empty(&g->layout[i], &g->pool, m);
    msap_pool_empty(&g->pool);
    msap_near_empty(&g->near, m, g->slots);
    g->is_empty = 1;
}

/* Takes all boxes out of the grid. */
void msap_grid_empty(struct grid *g, struct memory *m)
{
    msap_grid_empty_cells(g, m);
    for (size_t slot = 0; slot < g->boxes->used; slot++) box_forget_place(&g->boxes->at[slot]);
    g->is_tracking = g->is_jumping = 0;
}

/* Gives back all that boxes in slots below `slots` do not need; the next commit makes
 * cells and lists anew. */
void msap_grid_trim(struct grid *g, struct memory *m, size_t slots)
{
    msap_grid_empty(g, m);
    msap_pool_free(&g->pool, m);
    msap_pool_free(&g->near.pool, m);
    for (int i = 0; i < 2; i++) msap_layout_free(&g->layout[i], m);
    msap_row_set_free(&g->row_set, m);
    msap_keys_free(&g->known, m);
    g->knows_pairs = 0;
    g->rows.chosen_for = 0;
    g->slots = slots;
    msap_memory_shrink(m, &g->near.of, &g->near.room, slots, sizeof *g->near.of);
    msap_memory_shrink(m, &g->start, &g->room_start, slots, sizeof *g->start);
}

void msap_grid_free(struct grid *g, struct memory *m)
{
    msap_grid_trim(g, m, g->slots);
    msap_memory_free(m, g->near.of, g->near.room, sizeof *g->near.of);
    msap_memory_free(m, g->start, g->room_start, sizeof *g->start);
    memset(g, 0, sizeof *g);
}

/* -------------------------------------------------- entering, kept and left */

static inline struct cell_walk cells_of(struct layout *l, uint32_t level, struct range base)
{
    return cell_walk(&l->level[level], range_on(l, base, level));
}

/* Writes a box into cells. Returns 0 without memory. */
static int enter(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct cell_walk w)
{
    for (struct cell *c; (c = cell_next(&w)) != NULL;)
        if (!msap_cell_insert(c, &g->pool, m, &g->boxes->at[slot].fat, slot, is_static)) return 0;
    return 1;
}

/* Puts a box that has its fat bounds, layout and level into its cells: base, as
 * msap_range_of gives them. Returns 0 without memory. */
int msap_grid_put(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range base)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    if (!enter(g, m, slot, is_static, cells_of(l, p->level, base))) return 0;
    l->level[p->level].boxes++;
    l->boxes++;
    return 1;
}

static void exit_from(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct cell_walk w)
{
    for (struct cell *c; (c = cell_next(&w)) != NULL;) msap_cell_remove(c, &g->pool, m, slot, is_static);
}

/* Takes a box out of its cells. */
void msap_grid_take(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range base)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    exit_from(g, m, slot, is_static, cells_of(l, p->level, base));
    l->level[p->level].boxes--;
    l->boxes--;
    p->level = NO_LEVEL;
}

static int same_range(const struct range *a, const struct range *b) { return memcmp(a, b, sizeof *a) == 0; }

/* Brings the cells of a box up to date with its fat bounds: they were `from` of its layout and
 * are to be `to` of the current one. Cells left, kept and entered (paper II.3c): mostly all are
 * kept, else all are left and all are entered. Returns 0 without memory. */
int msap_grid_move(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range from,
                   struct range to)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    if (p->layout == g->current && same_range(&from, &to)) {
        struct cell_walk w = cells_of(l, p->level, to);
        for (struct cell *c; (c = cell_next(&w)) != NULL;) msap_cell_update(c, &p->fat, slot, is_static);
        return 1;
    }
    if (p->layout == g->current && p->level == msap_level_for(to)) { /* as many boxes are in it as before */
        exit_from(g, m, slot, is_static, cells_of(l, p->level, from));
        return enter(g, m, slot, is_static, cells_of(l, p->level, to));
    }
    msap_grid_take(g, m, slot, is_static, from);
    p->layout = (uint8_t)g->current;
    p->level = (uint8_t)msap_level_for(to);
    return msap_grid_put(g, m, slot, is_static, to);
}

/* ------------------------------------------------------------------ asking */

/* The part of a query (below) over some cells. */
static void query_cells(const struct grid *g, struct worker *w, struct cell_walk walk, uint32_t self,
                        int is_static)
{
    const struct bounds *fat = &g->boxes->at[self].fat;
    for (struct cell *c; (c = cell_next(&walk)) != NULL;) {
        if (c->n == 0) continue;
        msap_worker_put_found(w, self, g->sweep(c, 0, is_static ? c->n_moving : c->n, fat, w->found));
    }
}

/* Writes, behind each other as pairs with `self`, the boxes on levels from `first` to
 * `last` - 1 whose fat bounds overlap those of `self`, itself among them; for a static box,
 * those that are not static. A box that is met in several cells is written several times. */
void msap_grid_query(const struct grid *g, struct worker *w, uint32_t self, int is_static, uint32_t first,
                     uint32_t last)
{
    for (int i = 0; i < 2; i++) {
        const struct layout *l = &g->layout[i];
        if (l->boxes == 0) continue;
        struct range base = range_of(l, &g->boxes->at[self].fat);
        for (uint32_t level = first; level < last; level++)
            if (l->level[level].boxes > 0)
                query_cells(g, w, cell_walk(&l->level[level], range_on(l, base, level)), self, is_static);
    }
}
