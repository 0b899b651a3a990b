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
#include "cells.h"

enum {
    SAMPLES = 128,
    FEW_SAMPLES = 32,
    BOXES_A_CELL = 8,
    CROWDED = 24,
    LEAST_EXPONENT = -96,
    MOST_EXPONENT = 128
};

double msap_power_of_two(int exponent)
{
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double power;
    memcpy(&power, &bits, sizeof power);
    return power;
}

/* The least exponent whose power of two is not below a value, within limits that
 * keep units_of (cells.h) right for every float. */
int msap_exponent_for(double value)
{
    int exponent = LEAST_EXPONENT;
    while (exponent < MOST_EXPONENT && msap_power_of_two(exponent) < value) exponent++;
    return exponent;
}

static int limited(int exponent) { return exponent < LEAST_EXPONENT ? LEAST_EXPONENT : exponent; }

static uint64_t sortable(double value) { return msap_encode_float((float)value); }
static double unsorted(uint64_t code) { return msap_decode_float((uint32_t)code); }

/* How far a box came on an axis in this commit, so much at the most. */
static double way_of_box(const struct box_table *t, size_t slot, uint32_t k, double most)
{
    if (!box_is_changed(t, (uint32_t)slot) || !(t->at[slot].flags & BOX_WAS)) return 0;
    double step = msap_value_of(t->at[slot].now.min[k]) - msap_value_of(t->past[slot].before.min[k]);
    step = step < 0 ? -step : step;
    return step < most ? step : most;
}

/* Looks at so many finite boxes, SAMPLES at the most. */
static void look(const struct box_table *boxes, const struct bounds_by_slot *bounds, size_t samples, uint32_t k,
                 struct spread *s)
{
    uint64_t size[SAMPLES], centre[SAMPLES], scratch[SAMPLES];
    size_t n = 0, step = boxes->used / samples + 1;
    s->size = s->low = s->extent = s->step = 0;
    for (size_t slot = 0; slot < boxes->used; slot += step) {
        if ((boxes->at[slot].flags & bounds->flags) != bounds->flags) continue;
        const struct bounds *b = bounds_of_slot(bounds, slot);
        double low = msap_value_of(b->min[k]), high = msap_value_of(b->max[k]);
        if (!(high - low < 1e30)) continue;
        s->step += way_of_box(boxes, slot, k, high - low);
        size[n] = sortable(high - low);
        centre[n++] = sortable(low / 2 + high / 2);
    }
    if (n == 0) return;
    s->step /= (double)n;
    msap_sort_keys(size, n, scratch);
    msap_sort_keys(centre, n, scratch);
    s->size = unsorted(size[n - 1 - n / 4]);
    s->low = unsorted(centre[n / 50]) - s->size / 2;
    s->extent = unsorted(centre[n - 1 - n / 50]) - unsorted(centre[n / 50]) + s->size;
}

static void spread_by(const struct box_table *boxes, const struct bounds_by_slot *bounds, size_t samples,
                      struct spread s[3])
{
    for (uint32_t k = 0; k < 3; k++) look(boxes, bounds, samples, k, &s[k]);
}

void msap_spread_of(const struct box_table *boxes, const struct bounds_by_slot *bounds, struct spread s[3])
{
    spread_by(boxes, bounds, SAMPLES, s);
}

static void spread_now(const struct box_table *boxes, size_t samples, struct spread s[3])
{
    const struct bounds_by_slot now = bounds_now(boxes);
    spread_by(boxes, &now, samples, s);
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
        double narrower = msap_power_of_two(s[k].exponent - 1);
        if (narrower < s[k].size || narrower < least_size) break;
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
static int make_levels(struct layout *l, struct memory *m, const uint32_t count[3])
{
    size_t first[LEVELS], cells = 0;
    for (uint32_t i = 0; i < LEVELS; i++) {
        struct level *level = &l->level[i];
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t coarse = i == TOP ? 1 : count[k] >> (LEVEL_SHIFT * i);
            level->count[k] = coarse ? coarse : 1;
        }
        level->boxes = 0;
        first[i] = cells;
        cells += (size_t)level->count[0] * level->count[1] * level->count[2];
    }
    if (!msap_memory_reserve(m, &l->cell, &l->room_cell, cells, 0, sizeof *l->cell)) return 0;
    memset(l->cell, 0, cells * sizeof *l->cell);
    l->n_cells = cells;
    for (uint32_t i = 0; i < LEVELS; i++) l->level[i].cell = l->cell + first[i];
    return 1;
}

/* From the boxes: powers of two. */
static void lay_out_for_boxes(struct layout *l, const msap_config *c, struct spread s[3], size_t boxes,
                              uint32_t count[3])
{
    choose_cells(s, (double)boxes, c->cell_size);
    for (uint32_t k = 0; k < 3; k++) {
        count[k] = s[k].exponent > WIDEST_CELL ? 1 : msap_count_for(msap_cells_on(&s[k]));
        l->scale[k] = count[k] == 1 ? 0 : (float)msap_power_of_two(-s[k].exponent);
    }
}

static double larger(double a, double b) { return a > b ? a : b; }
static double within(double value, double most) { return value < -most ? -most : value < most ? value : most; }

/* As configured. The larger of the bounds is 2^24 units, as much as a float can tell
 * apart; a cell is a whole number of them. */
static void lay_out_as_told(struct layout *l, const msap_config *c, uint32_t count[3])
{
    l->is_told = 1;
    for (uint32_t k = 0; k < 3; k++) {
        double min = c->grid_min[k], max = c->grid_max[k];
        count[k] = c->grid_cells[k];
        l->scale[k] = 0;
        l->origin[k] = 0;
        l->width[k] = 1;
        if (count[k] == 1) continue;
        int unit = msap_exponent_for(larger(larger(min, -min), larger(max, -max))) - 24;
        l->scale[k] = (float)msap_power_of_two(-limited(unit));
        l->origin[k] = (int32_t)(min * l->scale[k]);
        l->width[k] = (int32_t)((max - min) * l->scale[k] / count[k]) + 1;
    }
}

/* The steps of an axis. Where it is divided, a step is from a 256th of a cell up to twice that, and all
 * steps count, as far as cells do: no box is longer than some cells of its level. Where it is not, and on the
 * top level, boxes are of any length, so what is far from the middle counts as if it were nearer. */
static void choose_steps(struct layout *l, const struct spread *s, uint32_t k, int is_divided)
{
    enum { STEPS_BITS = 8, HALF = MOST_STEPS / 2 };
    const double most = (1 << 30) - 1;
    int step;
    if (is_divided) step = msap_exponent_for((l->is_told ? l->width[k] : 1) / (double)l->scale[k]) - STEPS_BITS;
    else step = msap_exponent_for(larger(s->size / (1 << STEPS_BITS), s->extent / MOST_STEPS));
    double fine = msap_power_of_two(-step); /* spread tells of no size above 1e30, of no extent above 2^129 */
    double middle = within((s->low + s->extent / 2) * fine, most);
    double end = is_divided ? within(MOST_UNITS / l->scale[k] * fine, most) : 0;
    l->fine[k] = (float)fine;
    for (uint32_t i = 0; i < LEVELS; i++) {
        struct level *level = &l->level[i];
        int is_open = !is_divided || i == TOP;
        int32_t at = floor_shift((int32_t)middle, LEVEL_SHIFT * i);
        level->first_step[k] = is_open ? at - HALF : floor_shift(-(int32_t)end, LEVEL_SHIFT * i);
        level->last_step[k] = is_open ? at + HALF : floor_shift((int32_t)end, LEVEL_SHIFT * i);
    }
}

/* A layout is good for about as many boxes as it was chosen for. */
int msap_is_outgrown(size_t chosen_for, size_t boxes)
{
    return chosen_for == 0 || boxes > chosen_for * 2 || boxes * 4 < chosen_for;
}

/* Chooses the current layout, which holds no boxes, anew for n of the boxes. Returns 0 without memory. */
int msap_layout_choose(struct grid *g, struct memory *m, const struct box_table *boxes, size_t n)
{
    struct layout *l = &g->layout[g->current];
    struct spread s[3];
    uint32_t count[3];
    spread_now(boxes, SAMPLES, s);
    if (g->config->grid == MSAP_GRID_FIXED) lay_out_as_told(l, g->config, count);
    else lay_out_for_boxes(l, g->config, s, n, count);
    l->chosen_for = l->n_cells = l->boxes = 0;
    if (!make_levels(l, m, count)) return 0;
    for (uint32_t k = 0; k < 3; k++) choose_steps(l, &s[k], k, count[k] > 1);
    l->chosen_for = n + 1;
    l->chosen_at = g->commit;
    return 1;
}

/* Takes everything out of its cells, whose pool is to be emptied. */
void msap_layout_empty(struct layout *l, struct pool *p, struct memory *m)
{
    if (l->n_cells > 0) msap_cells_empty(l->cell, l->n_cells, p, m);
    for (uint32_t level = 0; level < LEVELS; level++) l->level[level].boxes = 0;
    l->boxes = 0;
}

void msap_layout_free(struct layout *l, struct memory *m)
{
    msap_memory_free(m, l->cell, l->room_cell, sizeof *l->cell);
    memset(l, 0, sizeof *l);
}

/* -------------------------------------------------------------- adapting */

/* For how many boxes cells are to be good: all, or as many as have left the rows and more. */
static size_t boxes_to_hold(const struct grid *g, const struct box_table *boxes)
{
    const struct layout *l = &g->layout[g->current];
    return g->is_resting ? larger_of(l->boxes, l->chosen_for) : boxes->live;
}

/* Whether the boxes, by a sample of so many, would be laid out otherwise now, by more than chance: cells
 * four times as wide or as narrow on some axis. */
static int would_differ(const struct grid *g, const struct box_table *boxes, size_t samples)
{
    struct layout now = g->layout[g->current];
    const struct layout *then = &g->layout[g->current];
    struct spread s[3];
    uint32_t count[3];
    spread_now(boxes, samples, s);
    lay_out_for_boxes(&now, g->config, s, boxes_to_hold(g, boxes), count);
    for (int k = 0; k < 3; k++)
        if (now.scale[k] > 3 * then->scale[k] || then->scale[k] > 3 * now.scale[k]) return 1;
    return 0;
}

/* Whether another layout is to be chosen. Now and then a few boxes are asked, and if these say so, as many as it
 * would be chosen by. */
static int is_unsuitable(const struct grid *g, const struct box_table *boxes)
{
    enum { COMMITS = 16 };
    const struct layout *then = &g->layout[g->current];
    if (msap_is_outgrown(then->chosen_for, boxes_to_hold(g, boxes))) return 1;
    return (g->commit - then->chosen_at) % COMMITS == COMMITS - 1 && would_differ(g, boxes, FEW_SAMPLES) &&
           would_differ(g, boxes, SAMPLES);
}

/* Moves boxes from the other layout to the current one: a few, so that no commit takes
 * long, and more where there are more, so that it comes to an end. */
static int move_over(struct grid *g, struct memory *m, const struct box_table *boxes)
{
    struct layout *other = &g->layout[1 - g->current];
    size_t n = 64 + boxes->used / 64;
    for (; n > 0 && other->boxes > 0; n--, g->next_to_move++) {
        if (g->next_to_move >= boxes->used) g->next_to_move = 0;
        uint32_t slot = g->next_to_move;
        const struct box *p = &boxes->at[slot];
        if (p->level == NO_LEVEL || p->layout == g->current) continue;
        struct range from = range_of(other, &p->fat);
        struct spot to;
        spot_of(&g->layout[g->current], &p->fat, &to);
        if (!msap_grid_move(g, m, slot, (boxes->at[slot].flags & BOX_STATIC) != 0, from, &to)) return 0;
    }
    if (other->boxes == 0) msap_layout_free(other, m);
    return 1;
}

/* Follows the scene: when the layout does not suit the boxes any more, another one is
 * chosen and they go over to it little by little. Returns 0 without memory. */
int msap_layout_adapt(struct grid *g, struct memory *m, const struct box_table *boxes)
{
    struct layout *other = &g->layout[1 - g->current];
    if (other->boxes > 0) return move_over(g, m, boxes);
    if (g->config->grid == MSAP_GRID_FIXED || !is_unsuitable(g, boxes)) return 1;
    size_t n = boxes_to_hold(g, boxes);
    if (g->is_resting) n = larger_of(n, 2 * g->layout[g->current].boxes); /* more are likely to leave the rows */
    g->current = 1 - g->current;
    return msap_layout_choose(g, m, boxes, n);
}
