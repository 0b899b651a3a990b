/* Boxes that move, frame by frame put into the cells of a grid.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The cells are squares over the floor. A box beyond the floor counts to its rim.
 */
#include "film.h"

#include <stdlib.h>
#include <string.h>

static uint16_t cell_number(const struct film *f, float at)
{
    double cell = at / CELL_WIDTH;
    return cell < 0 ? 0 : cell >= f->count ? (uint16_t)(f->count - 1) : (uint16_t)cell;
}

struct span span_of(const struct film *f, const aabb *b)
{
    struct span s;
    for (int k = 0; k < 2; k++) {
        s.low[k] = cell_number(f, b->min[k]);
        s.high[k] = cell_number(f, b->max[k]);
    }
    return s;
}

/* Calls visit(frame, cell, box) for each cell of each box's span. */
static void for_each_entry(const struct film *f, struct frame *frame,
                           void (*visit)(struct frame *frame, size_t cell, uint32_t box))
{
    for (uint32_t i = 0; i < f->scene->boxes; i++) {
        struct span s = frame->span[i];
        for (uint32_t y = s.low[1]; y <= s.high[1]; y++)
            for (uint32_t x = s.low[0]; x <= s.high[0]; x++) visit(frame, (size_t)y * f->count + x, i);
    }
}

static void count_entry(struct frame *frame, size_t cell, uint32_t box)
{
    (void)box;
    frame->first[cell + 1]++;
}
static void write_entry(struct frame *frame, size_t cell, uint32_t box) { frame->in[frame->first[cell]++] = box; }

/* Puts the boxes of a frame into cells. */
static void rasterise(const struct film *f, struct frame *now)
{
    now->span = get(f->scene->boxes, sizeof *now->span);
    for (uint32_t i = 0; i < f->scene->boxes; i++) now->span[i] = span_of(f, &now->box[i]);
    now->first = get(f->cells + 1, sizeof *now->first);
    for_each_entry(f, now, count_entry);
    for (size_t i = 1; i <= f->cells; i++) now->first[i] += now->first[i - 1];
    now->in = get(now->first[f->cells], sizeof *now->in);
    for_each_entry(f, now, write_entry);
    memmove(now->first + 1, now->first, f->cells * sizeof *now->first);
    now->first[0] = 0;
}

struct film film_make(const scene *s, thread_pool *pool)
{
    struct film f = {s, (uint32_t)(s->side / CELL_WIDTH) + 1, 0, s->frames + 1, NULL, pool};
    f.cells = (size_t)f.count * f.count;
    f.frame = get(f.frames, sizeof *f.frame);
    for (uint32_t i = 0; i < f.frames; i++) {
        struct frame *now = &f.frame[i];
        now->box = get(s->boxes, sizeof *now->box);
        memcpy(now->box, i == 0 ? s->start : f.frame[i - 1].box, s->boxes * sizeof *now->box);
        for (uint32_t m = 0; i > 0 && m < s->movers; m++)
            now->box[scene_frame(s, i - 1)[m].box] = scene_frame(s, i - 1)[m].to;
        rasterise(&f, now);
    }
    return f;
}

void film_free(struct film *f)
{
    for (uint32_t i = 0; i < f->frames; i++) {
        free(f->frame[i].box);
        free(f->frame[i].span);
        free(f->frame[i].first);
        free(f->frame[i].in);
    }
    free(f->frame);
}
