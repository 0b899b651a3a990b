/* Boxes that move, frame by frame put into the cells of a grid.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef FILM_H
#define FILM_H

#include "../examples/thread_pool.h"
#include "scene.h"

enum { CELL_WIDTH = 4, MOST_TASKS = 4 };

/* Low and high cell on both axes of the floor. */
struct span {
    uint16_t low[2], high[2];
};

/* A frame: the boxes, the cells that each touches, and cell by cell the boxes in it. */
struct frame {
    aabb *box;
    struct span *span;
    uint32_t *first, *in; /* [cells + 1], [entries] */
};

struct film {
    const scene *scene;
    uint32_t count; /* cells in a row, and rows */
    size_t cells;
    uint32_t frames;
    struct frame *frame;
    thread_pool *pool; /* for who works on it */
};

struct film film_make(const scene *s, thread_pool *pool);
void film_free(struct film *f);
struct span span_of(const struct film *f, const aabb *b);

/* Parts of claim_parallel. */
void compare_pairs(const struct film *f);
void compare_queues(const struct film *f);

#endif
