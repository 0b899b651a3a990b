/* Scenes to measure on: boxes that move, by a recipe.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef SCENE_H
#define SCENE_H

#include "bench.h"

#include <multisap.h>

typedef struct aabb {
    float min[3], max[3];
} aabb;

static inline int aabb_overlap(const aabb *a, const aabb *b)
{
    return (a->min[0] <= b->max[0]) & (b->min[0] <= a->max[0]) & (a->min[1] <= b->max[1]) &
           (b->min[1] <= a->max[1]) & (a->min[2] <= b->max[2]) & (b->min[2] <= a->max[2]);
}

typedef enum motion {
    STRAIGHT, /* each at a speed of its own, off the walls */
    BROWNIAN, /* each step in another direction */
    JUMPING   /* anywhere */
} motion;

/* Boxes about 1 wide in a cube, or on a floor, so crowded that each overlaps so many
 * others on average. */
typedef struct recipe {
    const char *name;
    uint32_t boxes, frames;
    double overlaps;
    double moving; /* the share of boxes that move, the same ones in each frame */
    double speed;  /* of a box in a frame; the box being about 1 wide */
    motion motion;
    int is_flat;    /* 1: on a floor: the boxes overlap on the up axis, z */
    double largest; /* sizes go up to so many times the least one, small ones being more; 0: all about 1 */
} recipe;

typedef struct move {
    uint32_t box;
    aabb to;
} move;

typedef struct scene {
    const char *name;
    uint32_t boxes, frames, movers;
    double side; /* of the cube or floor, from 0 */
    aabb *start; /* [boxes] */
    move *moves; /* [frames * movers] */
} scene;

scene scene_make(const recipe *r);
void scene_free(scene *s);

/* The moves of a frame, s->movers of them. */
static inline const move *scene_frame(const scene *s, uint32_t frame)
{
    return s->moves + (size_t)frame * s->movers;
}

/* The boxes after the last frame, to be freed. */
aabb *scene_end(const scene *s);

/* Views for the library. */
msap_boxes boxes_of(const aabb *boxes);
msap_boxes boxes_of_moves(const move *moves);

#endif
