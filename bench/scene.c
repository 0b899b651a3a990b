/* Scenes to measure on.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * All frames are made beforehand, so that a run does nothing but what is measured.
 * n boxes about 1 wide in a cube of side L overlap about 8 n / L^3 others each, on a
 * floor, where few are above others, 4 n / L^2; from that follows L. */
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A scene in the making: where the centres are and where they go. */
struct maker {
    const recipe *recipe;
    uint64_t random;
    double side, height; /* centres lie below these, on the up axis below the second */
    double (*centre)[3], (*velocity)[3], (*half)[3];
};

static double between(struct maker *m, double low, double high)
{
    return low + (high - low) * random_unit(&m->random);
}

static double side_for(const recipe *r)
{
    return r->is_flat ? sqrt(4.0 * r->boxes / r->overlaps) : cbrt(8.0 * r->boxes / r->overlaps);
}

static void place(struct maker *m, uint32_t i)
{
    for (int k = 0; k < 3; k++) m->centre[i][k] = between(m, 0, k == 2 ? m->height : m->side);
}

static void direct(struct maker *m, uint32_t i)
{
    double length = 0, speed = m->recipe->speed * between(m, 0.5, 1.5);
    for (int k = 0; k < 3; k++) {
        m->velocity[i][k] = between(m, -1, 1) * (k == 2 && m->recipe->is_flat ? 0.1 : 1);
        length += m->velocity[i][k] * m->velocity[i][k];
    }
    for (int k = 0; k < 3; k++) m->velocity[i][k] *= speed / sqrt(length + 1e-9);
}

static void size(struct maker *m, uint32_t i)
{
    double scale = 1;
    if (m->recipe->largest > 0) {
        double u = random_unit(&m->random);
        scale = pow(m->recipe->largest, pow(u, 8));
    }
    for (int k = 0; k < 3; k++) m->half[i][k] = scale * between(m, 0.35, 0.65);
}

static void step(struct maker *m, uint32_t i)
{
    if (m->recipe->motion == JUMPING) {
        place(m, i);
        return;
    }
    if (m->recipe->motion == BROWNIAN) direct(m, i);
    for (int k = 0; k < 3; k++) {
        double wall = k == 2 ? m->height : m->side, *at = &m->centre[i][k];
        *at += m->velocity[i][k];
        if (*at < 0 || *at > wall) m->velocity[i][k] = -m->velocity[i][k];
    }
}

static aabb box_of(const struct maker *m, uint32_t i)
{
    aabb b;
    for (int k = 0; k < 3; k++) {
        b.min[k] = (float)(m->centre[i][k] - m->half[i][k]);
        b.max[k] = (float)(m->centre[i][k] + m->half[i][k]);
    }
    return b;
}

static struct maker maker_begin(const recipe *r)
{
    struct maker m = {r, r->boxes, side_for(r), 0, NULL, NULL, NULL};
    m.height = r->is_flat ? 2 : m.side;
    m.centre = get(r->boxes, sizeof *m.centre);
    m.velocity = get(r->boxes, sizeof *m.velocity);
    m.half = get(r->boxes, sizeof *m.half);
    for (uint32_t i = 0; i < r->boxes; i++) {
        place(&m, i);
        direct(&m, i);
        size(&m, i);
    }
    return m;
}

static void maker_end(struct maker *m)
{
    free(m->centre);
    free(m->velocity);
    free(m->half);
}

scene scene_make(const recipe *r)
{
    struct maker m = maker_begin(r);
    uint32_t movers = (uint32_t)(r->moving * r->boxes + 0.5);
    scene s = {r->name, r->boxes, r->frames, movers, m.side, NULL, NULL};
    s.start = get(r->boxes, sizeof *s.start);
    s.moves = get((size_t)s.frames * movers, sizeof *s.moves);
    for (uint32_t i = 0; i < r->boxes; i++) s.start[i] = box_of(&m, i);
    move *next = s.moves;
    for (uint32_t frame = 0; frame < s.frames; frame++)
        for (uint32_t i = 0; i < movers; i++, next++) {
            next->box = (uint32_t)((uint64_t)i * r->boxes / movers);
            step(&m, next->box);
            next->to = box_of(&m, next->box);
        }
    maker_end(&m);
    return s;
}

void scene_free(scene *s)
{
    free(s->start);
    free(s->moves);
}

aabb *scene_end(const scene *s)
{
    aabb *boxes = get(s->boxes, sizeof *boxes);
    memcpy(boxes, s->start, s->boxes * sizeof *boxes);
    for (size_t i = 0; i < (size_t)s->frames * s->movers; i++) boxes[s->moves[i].box] = s->moves[i].to;
    return boxes;
}

msap_boxes boxes_of(const aabb *boxes)
{
    msap_boxes b = {sizeof b,      MSAP_FLOAT,    boxes->min,    boxes->max,
                    sizeof *boxes, sizeof(float), sizeof *boxes, sizeof(float)};
    return b;
}

msap_boxes boxes_of_moves(const move *moves)
{
    msap_boxes b = {sizeof b,      MSAP_FLOAT,    moves->to.min, moves->to.max,
                    sizeof *moves, sizeof(float), sizeof *moves, sizeof(float)};
    return b;
}
