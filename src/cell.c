/* A cell: the fat boxes that touch it, as a short array that is swept whole.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * This is the SAP of a few dozen boxes: to sort so few costs more than to test
 * them all, eight at a time (simd.c). The bounds stand in split arrays one behind
 * the other: the mins on three axes, the maxes, the slots. Boxes that are not
 * static stand first, so that a static box is tested against them alone. */
#include "internal.h"

static unsigned class_for(uint32_t room)
{
    unsigned class = 0;
    while (((uint32_t)CELL_UNIT << class) < room) class ++;
    return class;
}

static uint32_t *ids(const struct cell *c) { return (uint32_t *)(void *)(c->at + 6 * (size_t)c->room); }

void msap_cell_put_row(struct cell *c, uint32_t row, const struct bounds *b, uint32_t slot)
{
    for (uint32_t k = 0; k < 3; k++) {
        c->at[k * (size_t)c->room + row] = b->min[k];
        c->at[(3 + k) * (size_t)c->room + row] = b->max[k];
    }
    ids(c)[row] = slot;
}

/* Reads a row; returns the slot. */
uint32_t msap_cell_row(const struct cell *c, uint32_t row, struct bounds *b)
{
    for (uint32_t k = 0; k < 3; k++) {
        b->min[k] = c->at[k * (size_t)c->room + row];
        b->max[k] = c->at[(3 + k) * (size_t)c->room + row];
    }
    return ids(c)[row];
}

static void move_row(struct cell *c, uint32_t from, uint32_t to)
{
    for (uint32_t array = 0; array < 7; array++)
        c->at[array * (size_t)c->room + to] = c->at[array * (size_t)c->room + from];
}

/* Room for n boxes in a cell that has none. Returns 0 without memory. */
int msap_cell_make_room(struct cell *c, struct pool *p, struct memory *m, uint32_t n)
{
    unsigned class = class_for(n);
    c->at = msap_pool_get(p, m, class);
    if (!c->at) return 0;
    c->room = (uint32_t)CELL_UNIT << class;
    return 1;
}

static int grow(struct cell *c, struct pool *p, struct memory *m)
{
    struct cell old = *c;
    if (!msap_cell_make_room(c, p, m, old.n + 1)) {
        *c = old;
        return 0;
    }
    for (uint32_t array = 0; old.n > 0 && array < 7; array++)
        memcpy(c->at + array * (size_t)c->room, old.at + array * (size_t)old.room, old.n * sizeof *c->at);
    if (old.room > 0) msap_pool_put(p, m, old.at, class_for(old.room));
    return 1;
}

/* Returns 0 without memory, the cell being as before. */
int msap_cell_insert(struct cell *c, struct pool *p, struct memory *m, const struct bounds *b, uint32_t slot,
                     int is_static)
{
    if (c->n == c->room && !grow(c, p, m)) return 0;
    uint32_t row = c->n++;
    if (!is_static) {
        move_row(c, c->n_moving, row);
        row = c->n_moving++;
    }
    msap_cell_put_row(c, row, b, slot);
    return 1;
}

static uint32_t row_of(const struct cell *c, uint32_t slot, int is_static)
{
    const uint32_t *id = ids(c);
    uint32_t row = is_static ? c->n_moving : 0;
    while (id[row] != slot) row++;
    return row;
}

/* Gives a box of the cell other bounds. */
void msap_cell_update(struct cell *c, const struct bounds *b, uint32_t slot, int is_static)
{
    msap_cell_put_row(c, row_of(c, slot, is_static), b, slot);
}

/* An empty cell's memory goes back to the pool. */
void msap_cell_remove(struct cell *c, struct pool *p, struct memory *m, uint32_t slot, int is_static)
{
    uint32_t row = row_of(c, slot, is_static);
    if (!is_static) {
        move_row(c, --c->n_moving, row);
        row = c->n_moving;
    }
    move_row(c, --c->n, row);
    if (c->n == 0) msap_cell_drop(c, p, m);
}

void msap_cell_drop(struct cell *c, struct pool *p, struct memory *m)
{
    if (c->room > 0) msap_pool_put(p, m, c->at, class_for(c->room));
    memset(c, 0, sizeof *c);
}
