/* The layout of the grid: how large its cells are and how many have memory.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Chosen from a sample of the boxes. On each axis a cell is a power of two, twice as
 * wide as most boxes or more: then a box touches few cells. Cells are widened, first
 * on the axis that has most of them, until there is one for every few boxes; an axis
 * that is down to one cell is not divided at all. So flat scenes get a grid over two
 * axes, towers one over one, and crowds in a cube one over three. */
#include "internal.h"

enum { SAMPLES = 512, BOXES_A_CELL = 8, CROWDED = 24, LEAST_EXPONENT = -96, MOST_EXPONENT = 120 };

double msap_power_of_two(int exponent)
{
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* The least exponent whose power of two is not below a value, within limits that
 * keep msap_units_of (grid.c) right for every float. */
int msap_exponent_for(double value)
{
    int exponent = LEAST_EXPONENT;
    while (exponent < MOST_EXPONENT && msap_power_of_two(exponent) < value) exponent++;
    return exponent;
}

static int limited(int exponent) { return exponent < LEAST_EXPONENT ? LEAST_EXPONENT : exponent; }

static uint64_t sortable(double value) { return msap_encode_float((float)value); }
static double unsorted(uint64_t code) { return msap_decode_float((uint32_t)code); }

/* Looks at up to SAMPLES finite boxes. */
static void look(const struct box_table *boxes, uint32_t k, struct spread *s)
{
    uint64_t size[SAMPLES], centre[SAMPLES];
    size_t n = 0, step = boxes->used / SAMPLES + 1;
    for (size_t slot = 0; slot < boxes->used && n < SAMPLES; slot += step) {
        const struct box *b = &boxes->at[slot];
        double low = msap_value_of(b->now.min[k]), high = msap_value_of(b->now.max[k]);
        if (!(b->flags & BOX_LIVE) || !(high - low < 1e30)) continue;
        size[n] = sortable(high - low);
        centre[n++] = sortable(low / 2 + high / 2);
    }
    s->size = s->extent = 0;
    if (n == 0) return;
    msap_sort_keys(size, n, NULL);
    msap_sort_keys(centre, n, NULL);
    s->size = unsorted(size[n - 1 - n / 4]);
    s->extent = unsorted(centre[n - 1 - n / 50]) - unsorted(centre[n / 50]) + s->size;
}

void msap_spread_of(const struct box_table *boxes, struct spread s[3])
{
    for (uint32_t k = 0; k < 3; k++) look(boxes, k, &s[k]);
}

double msap_cells_on(const struct spread *s)
{
    double cells = s->extent / msap_power_of_two(s->exponent);
    return cells > 1 ? cells : 1;
}

static double cells_on_all(const struct spread s[3])
{
    return msap_cells_on(&s[0]) * msap_cells_on(&s[1]) * msap_cells_on(&s[2]);
}

static uint32_t finest(const struct spread s[3])
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < 3; k++)
        if (msap_cells_on(&s[k]) > msap_cells_on(&s[best])) best = k;
    return best;
}

/* Widens or, in a crowd, narrows the cells until they hold a few boxes each. */
static void choose_cells(struct spread s[3], double boxes, double least_size)
{
    for (uint32_t k = 0; k < 3; k++) {
        double width = 2 * s[k].size;
        if (width < s[k].extent / 65536) width = s[k].extent / 65536;
        s[k].exponent = msap_exponent_for(width > least_size ? width : least_size);
    }
    while (cells_on_all(s) > 1 && cells_on_all(s) * BOXES_A_CELL > boxes) s[finest(s)].exponent++;
    for (int round = 0; round < 3 && cells_on_all(s) * CROWDED < boxes; round++) {
        uint32_t k = finest(s);
        if (msap_power_of_two(s[k].exponent - 1) < s[k].size) break;
        s[k].exponent--;
    }
}

uint32_t msap_count_for(double cells)
{
    uint32_t count = 1;
    while (count < cells && count < 65536) count *= 2;
    return count;
}

/* Gives the levels their cells. Returns 0 without memory. */
static int make_levels(struct grid *g, struct memory *m, const uint32_t count[3])
{
    size_t first[LEVELS], cells = 0;
    for (uint32_t level = 0; level < LEVELS; level++) {
        struct level *l = &g->level[level];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t coarse = level == TOP ? 1 : count[k] >> (LEVEL_SHIFT * level);
            l->count[k] = coarse ? coarse : 1;
        }
        first[level] = cells;
        cells += (size_t)l->count[0] * l->count[1] * l->count[2];
    }
    g->n_cells = 0;
    if (!msap_memory_reserve(m, &g->cell, &g->room_cell, cells, 0, sizeof *g->cell)) return 0;
    memset(g->cell, 0, cells * sizeof *g->cell);
    g->n_cells = cells;
    for (uint32_t level = 0; level < LEVELS; level++) g->level[level].cell = g->cell + first[level];
    return 1;
}

/* From the boxes: powers of two. */
static void lay_out_for_boxes(struct grid *g, const struct box_table *boxes, uint32_t count[3])
{
    struct spread s[3];
    msap_spread_of(boxes, s);
    choose_cells(s, (double)boxes->live, g->config->cell_size);
    for (uint32_t k = 0; k < 3; k++) {
        count[k] = msap_count_for(msap_cells_on(&s[k]));
        g->scale[k] = count[k] == 1 ? 0 : (float)msap_power_of_two(-s[k].exponent);
    }
}

static double larger(double a, double b) { return a > b ? a : b; }

/* As configured. The larger of the bounds is 2^24 units, as much as a float can tell
 * apart; a cell is a whole number of them. */
static void lay_out_as_told(struct grid *g, uint32_t count[3])
{
    const msap_config *c = g->config;
    g->is_told = 1;
    for (uint32_t k = 0; k < 3; k++) {
        double min = c->grid_min[k], max = c->grid_max[k];
        count[k] = c->grid_cells[k];
        g->scale[k] = 0;
        g->origin[k] = 0;
        g->width[k] = 1;
        if (count[k] == 1) continue;
        int unit = msap_exponent_for(larger(larger(min, -min), larger(max, -max))) - 24;
        g->scale[k] = (float)msap_power_of_two(-limited(unit));
        g->origin[k] = (int32_t)(min * g->scale[k]);
        g->width[k] = (int32_t)((max - min) * g->scale[k] / count[k]) + 1;
    }
}

/* A layout is good for a while, and for about as many boxes as it was made for. */
int msap_layout_is_old(size_t chosen_for, uint32_t chosen_at, uint32_t now, size_t boxes)
{
    enum { COMMITS = 64 };
    return chosen_for == 0 || boxes > chosen_for * 2 || boxes * 2 < chosen_for || now - chosen_at > COMMITS;
}

/* Lays an empty grid out. Returns 0 without memory. */
int msap_grid_layout(struct grid *g, struct memory *m, const struct box_table *boxes)
{
    uint32_t count[3];
    if (g->config->grid == MSAP_GRID_FIXED) lay_out_as_told(g, count);
    else lay_out_for_boxes(g, boxes, count);
    g->laid_out_for = 0;
    if (!make_levels(g, m, count)) return 0;
    g->laid_out_for = boxes->live + 1;
    g->laid_out_at = g->commit;
    return 1;
}
