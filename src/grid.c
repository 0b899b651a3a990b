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

static uint64_t cells_in(const struct range *r, uint32_t shift)
{
    uint64_t cells = 1;
    for (uint32_t k = 0; k < 3; k++) {
        uint64_t wide = (uint64_t)((int64_t)floor_shift(r->high[k], shift) - floor_shift(r->low[k], shift) + 1);
        cells *= wide < 65536 ? wide : 65536;
    }
    return cells;
}

/* The finest level on which a box touches no more than MOST_CELLS. */
uint32_t msap_level_for(const struct range *base)
{
    uint32_t level = 0;
    const int32_t *low = base->low, *high = base->high;
    if ((high[0] <= low[0] + 1) & (high[1] <= low[1] + 1) & (high[2] <= low[2] + 1)) return 0; /* 8 at the most */
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
    g->upkeep.horizon = HORIZON_START;
    g->sweeps = msap_sweeps_for(config->simd);
    msap_pool_init(&g->pool, sizeof(struct cell_block));
    msap_pool_init(&g->near.pool, NEAR_UNIT * sizeof(uint32_t));
}

/* Room for boxes in slots below `slots`. */
int msap_grid_reserve(struct grid *g, struct memory *m, size_t slots)
{
    size_t had = g->slots;
    if (slots <= had) return 1;
    if (slots > SIZE_MAX / 2 - 8) return 0;
    if (!msap_memory_reserve(m, &g->near.of, &g->near.room, slots, had, sizeof *g->near.of)) return 0;
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
    if (!g->in_skins) msap_near_empty(&g->near, m, g->slots); /* else no box has a list */
    g->candidates.n = g->untold = 0;
    g->is_empty = 1;
}

/* Takes all boxes out of the grid. */
void msap_grid_empty(struct grid *g, struct memory *m)
{
    msap_grid_empty_cells(g, m);
    for (size_t slot = 0; slot < g->boxes->used; slot++) box_forget_place(&g->boxes->at[slot]);
    forget_rows_of_skins(g);
    msap_restless_forget(g);
    msap_partners_forget(g);
    g->is_tracking = g->is_jumping = g->is_resting = g->in_skins = 0;
    g->renewal.next = NO_RENEWAL;
    g->quiet = 0;
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
    msap_keys_free(&g->candidates, m);
    msap_renewal_free(&g->renewal, m);
    msap_restless_free(g, m);
    msap_partners_free(g, m);
    g->knows_pairs = 0;
    g->rows.chosen_for = 0;
    g->wide_found = g->wide_pruned = 0;
    g->watch.n = 0; /* watched boxes are in slots of the table, which may be shorter now */
    g->slots = slots;
    msap_memory_shrink(m, &g->near.of, &g->near.room, slots, sizeof *g->near.of);
}

void msap_grid_free(struct grid *g, struct memory *m)
{
    msap_grid_trim(g, m, g->slots);
    msap_memory_free(m, g->near.of, g->near.room, sizeof *g->near.of);
    memset(g, 0, sizeof *g);
}

/* -------------------------------------------------- entering, kept and left */

/* Writes a box into its cells. Returns 0 without memory. */
static int enter(struct grid *g, struct memory *m, uint32_t slot, int is_static, const struct spot *spot)
{
    struct layout *l = &g->layout[g->current];
    for (uint32_t i = 0; i < spot->cells; i++)
        if (!msap_cell_insert(&l->cell[spot->cell[i]], &g->pool, m, &spot->rounded, slot, is_static)) return 0;
    return 1;
}

/* Puts a box that has its fat bounds, layout and level into its cells. Returns 0 without memory. */
int msap_grid_put(struct grid *g, struct memory *m, uint32_t slot, int is_static, const struct spot *spot)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    if (!enter(g, m, slot, is_static, spot)) return 0;
    l->level[p->level].boxes++;
    l->boxes++;
    return 1;
}

/* Takes a box out of the cells that it is in. */
static void exit_from(struct grid *g, struct memory *m, uint32_t slot, int is_static, const struct range *base)
{
    const struct box *b = &g->boxes->at[slot];
    struct layout *l = &g->layout[b->layout];
    struct span span = span_on(l, base, b->level);
    uint32_t cell[MOST_CELLS], n = cells_of(l, &span, cell);
    for (uint32_t i = 0; i < n; i++) msap_cell_remove(&l->cell[cell[i]], &g->pool, m, slot, is_static);
}

/* A box leaves its cells. */
void msap_grid_take(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range base)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    exit_from(g, m, slot, is_static, &base);
    l->level[p->level].boxes--;
    l->boxes--;
    p->level = NO_LEVEL;
}

/* Brings the cells of a box up to date with its fat bounds: they were `from` of its layout and
 * are to be those of a spot_of the current one. Cells left, kept and entered (paper II.3c): mostly all are
 * kept, else all are left and all are entered. Returns 0 without memory. */
int msap_grid_move(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range from,
                   const struct spot *to)
{
    struct box *p = &g->boxes->at[slot];
    struct layout *l = &g->layout[p->layout];
    if (p->layout == g->current && is_same_range(&from, &to->base)) {
        for (uint32_t i = 0; i < to->cells; i++)
            msap_cell_update(&l->cell[to->cell[i]], &to->rounded, slot, is_static);
        return 1;
    }
    if (p->layout == g->current && p->level == to->level) { /* as many boxes are in it as before */
        exit_from(g, m, slot, is_static, &from);
        return enter(g, m, slot, is_static, to);
    }
    msap_grid_take(g, m, slot, is_static, from);
    p->layout = g->current & 1;
    p->level = (uint8_t)to->level;
    return msap_grid_put(g, m, slot, is_static, to);
}

/* ------------------------------------------------------------------ asking */

/* A box that asks cells. */
struct asking {
    const struct grid *grid;
    const struct bounds *fat;
    struct rounded rounded; /* for the level that is asked */
    int is_short, is_static;
};

static inline struct asking asking_for(const struct grid *g, uint32_t self, int is_static, const struct spot *spot)
{
    struct asking a = {g, &g->boxes->at[self].fat, spot->rounded, 1, is_static};
    return a;
}

/* The way through the cells of a level that it touches. */
static inline struct cell_walk walk_on(struct asking *a, const struct layout *l, uint32_t level,
                                       const struct spot *spot)
{
    a->is_short = rounded_on(l, level, spot, &a->rounded);
    return cell_walk(&l->level[level], range_on(l, &spot->base, level));
}

/* How many rows of a cell are asked. */
static inline uint32_t rows_asked(const struct asking *a, const struct cell *c)
{
    return a->is_static ? c->n_moving : c->n;
}

/* Asks a cell. Of a box that is too long for its rounded bounds to be compared, the bounds are. */
static inline size_t ask_cell(const struct asking *a, const struct cell *c, uint32_t *out)
{
    uint32_t rows = rows_asked(a, c);
    size_t n = 0;
    if (rows == 0) return 0;
    if (a->is_short) return a->grid->sweeps.cell(c, 0, rows, &a->rounded, out);
    for (uint32_t row = 0; row < rows; row++) {
        out[n] = c->block[row / 8].id[row % 8];
        n += (size_t)overlap(&a->grid->boxes->at[out[n]].fat, a->fat);
    }
    return n;
}

/* Asks a cell and puts what is found behind the *n that the worker has found. Returns 0 without room. */
static inline int find_in(const struct asking *a, struct worker *w, const struct cell *c, size_t *n)
{
    if (w->room_found < *n + c->n + FOUND_SLACK && !msap_worker_room_to_find(w, *n, c->n)) return 0;
    *n += ask_cell(a, c, w->found + *n);
    return 1;
}

/* Asks the levels of a layout but `but`. */
static int find_on_others(struct asking *a, struct worker *w, const struct layout *l, uint32_t but,
                          const struct spot *spot, size_t *n)
{
    for (uint32_t level = 0; level < LEVELS; level++) {
        if (level == but || l->level[level].boxes == 0) continue;
        struct cell_walk walk = walk_on(a, l, level, spot);
        for (const struct cell *c; (c = cell_next(&walk)) != NULL;)
            if (!find_in(a, w, c, n)) return 0;
    }
    return 1;
}

/* Writes into the worker's list what boxes there are whose fat bounds, rounded, overlap those of `self`,
 * itself among them; for a static box, those that are not static. A box that is met in several cells is
 * written several times. Returns how many; or, without room, SIZE_MAX. */
size_t msap_grid_find(const struct grid *g, struct worker *w, uint32_t self, int is_static,
                      const struct spot *spot)
{
    const struct layout *l = &g->layout[g->current], *other = &g->layout[1 - g->current];
    struct asking a = asking_for(g, self, is_static, spot);
    size_t n = 0;
    for (uint32_t i = 0; i < spot->cells; i++)
        if (!find_in(&a, w, &l->cell[spot->cell[i]], &n)) return SIZE_MAX;
    if (l->boxes > l->level[spot->level].boxes && !find_on_others(&a, w, l, spot->level, spot, &n))
        return SIZE_MAX;
    if (other->boxes > 0) {
        struct spot there;
        spot_of(other, a.fat, &there);
        if (!find_on_others(&a, w, other, LEVELS, &there, &n)) return SIZE_MAX;
    }
    for (size_t i = 0; i < n; i++) prefetch(&g->boxes->at[w->found[i]]);
    return g->is_resting ? msap_rest_find(g, w, a.fat, is_static, BOX_LIVE | BOX_WAS, n) : n;
}

/* The same on levels from `first` to `last` - 1 of the current layout, which is the only one: they are
 * written, behind each other, as pairs with `self`. There is room to find what is in any cell. */
void msap_grid_query(const struct grid *g, struct worker *w, uint32_t self, int is_static, uint32_t first,
                     uint32_t last)
{
    const struct layout *l = &g->layout[g->current];
    struct spot spot;
    spot_of(l, &g->boxes->at[self].fat, &spot);
    struct asking a = asking_for(g, self, is_static, &spot);
    for (uint32_t level = first; level < last; level++) {
        if (l->level[level].boxes == 0) continue;
        struct cell_walk walk = walk_on(&a, l, level, &spot);
        for (struct cell *c; (c = cell_next(&walk)) != NULL;)
            msap_worker_put_found(w, self, ask_cell(&a, c, w->found));
    }
}
