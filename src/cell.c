/* A cell: the fat boxes that touch it, as a short array that is swept whole.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * This is the SAP of a few dozen boxes: to sort so few costs more than to test
 * them all, eight at a time (simd.c). They stand in blocks of eight, since a row
 * is written about as often as a block is swept, and their bounds are rounded, so that
 * a block is two cache lines: boxes that are apart by less than a step are found, too,
 * and told apart by who asked. Boxes that are not static stand first, so that a static box is tested against
 * them alone. */
#include "internal.h"

static unsigned class_for(uint32_t rows) { return msap_pool_class_for((rows + 7) / 8); }

/* Reads a row; returns the slot. */
uint32_t msap_cell_row(const struct cell *c, uint32_t row, struct rounded *r)
{
    const struct cell_block *block = &c->block[row / 8];
    uint32_t column = row % 8;
    r->low[0] = block->low[0][column];
    r->low[1] = block->low[1][column];
    r->low[2] = block->low[2][column];
    r->low[3] = 0;
    r->high[0] = block->high[0][column];
    r->high[1] = block->high[1][column];
    r->high[2] = block->high[2][column];
    r->high[3] = 0;
    return block->id[column];
}

static void move_row(struct cell *c, uint32_t from, uint32_t to)
{
    struct rounded r;
    if (from == to) return;
    uint32_t slot = msap_cell_row(c, from, &r);
    cell_put_row(c, to, r.low, r.high, slot);
}

/* Room for n boxes in a cell that has none. Returns 0 without memory. */
int msap_cell_make_room(struct cell *c, struct pool *p, struct memory *m, uint32_t n)
{
    unsigned class = class_for(n);
    c->block = msap_pool_get(p, m, class);
    if (!c->block) return 0;
    c->room = 8 * (uint32_t)pool_units(class);
    return 1;
}

/* To twice the room: the smaller arrays that are left behind come to no more than that. */
static int grow(struct cell *c, struct pool *p, struct memory *m)
{
    struct cell old = *c;
    if (!msap_cell_make_room(c, p, m, old.room > 0 ? 2 * old.room : 1)) {
        *c = old;
        return 0;
    }
    if (old.room == 0) return 1;
    memcpy(c->block, old.block, old.room / 8 * sizeof *c->block);
    msap_pool_put(p, m, old.block, class_for(old.room));
    return 1;
}

/* Returns 0 without memory, the cell being as before. */
int msap_cell_insert(struct cell *c, struct pool *p, struct memory *m, const struct rounded *r, uint32_t slot,
                     int is_static)
{
    if (c->n == c->room && !grow(c, p, m)) return 0;
    uint32_t row = c->n++;
    if (row % 8 == 0) memset(c->block[row / 8].id, 0xff, sizeof c->block->id); /* row_of reads whole blocks */
    if (!is_static) {
        move_row(c, c->n_moving, row);
        row = c->n_moving++;
    }
    cell_put_row(c, row, r->low, r->high, slot);
    return 1;
}

/* The column of a slot in a block, or 8. */
static inline uint32_t column_of(const struct cell_block *b, uint32_t slot)
{
#if defined(__SSE2__)
    const __m128i *id = (const __m128i *)(const void *)b->id, wanted = _mm_set1_epi32((int)slot);
    __m128i low = _mm_cmpeq_epi32(_mm_loadu_si128(id), wanted),
            high = _mm_cmpeq_epi32(_mm_loadu_si128(id + 1), wanted);
    unsigned found = (unsigned)_mm_movemask_epi8(_mm_packs_epi16(_mm_packs_epi32(low, high), _mm_setzero_si128()));
    return found ? (uint32_t)__builtin_ctz(found) : 8;
#else
    uint32_t column = 0;
    while (column < 8 && b->id[column] != slot) column++;
    return column;
#endif
}

/* The row of a box, which is in the cell: the first that names it, since what stands
 * behind the last row means nothing. */
static uint32_t row_of(const struct cell *c, uint32_t slot, int is_static)
{
    uint32_t block = is_static ? c->n_moving / 8 : 0, column;
    while ((column = column_of(&c->block[block], slot)) == 8) block++;
    return block * 8 + column;
}

/* Gives a box of the cell other bounds. */
void msap_cell_update(struct cell *c, const struct rounded *r, uint32_t slot, int is_static)
{
    cell_put_row(c, row_of(c, slot, is_static), r->low, r->high, slot);
}

static void drop(struct cell *c, struct pool *p, struct memory *m)
{
    if (c->room > 0) /* GCOVR_EXCL_BR_LINE: so it is wherever a cell is dropped now */
        msap_pool_put(p, m, c->block, class_for(c->room));
    memset(c, 0, sizeof *c);
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
    if (c->n == 0) drop(c, p, m);
}

/* Takes the boxes out whose tag is the token. An empty cell's memory goes back to the
 * pool. */
void msap_cell_sift(struct cell *c, struct pool *p, struct memory *m, const uint32_t *tag, uint32_t token)
{
    uint32_t n = 0, n_moving = 0;
    for (uint32_t row = 0; row < c->n; row++) {
        if (tag[c->block[row / 8].id[row % 8]] == token) continue;
        n_moving += row < c->n_moving;
        move_row(c, row, n++);
    }
    if (n == 0 && c->n > 0) drop(c, p, m);
    c->n = n;
    c->n_moving = n_moving;
}

/* Empties cells whose pool is to be emptied: only large arrays go back one by one. */
void msap_cells_empty(struct cell *c, size_t n, struct pool *p, struct memory *m)
{
    for (size_t i = 0; i < n; i++)
        if (pool_is_large(class_for(c[i].room))) drop(&c[i], p, m);
    memset(c, 0, n * sizeof *c);
}
