/* What a program of the accuracy report is made of: a scene, and ways to find its pairs.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each program links main.c, scene.c and oracle.c with one file that has modes: ours.c,
 * or a peer's. All modes are given the same frames; the time of `step` is measured,
 * with all that a caller must do to its boxes before and to get the pairs. */
#ifndef MODE_H
#define MODE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A box that came or moved: as the scene has it, and rounded outward to floats. */
typedef struct change {
    uint32_t id, is_static;
    float min[3], max[3];
    double true_min[3], true_max[3];
} change;

/* Removals come first, then additions, then moves. */
typedef struct frame {
    const uint32_t *removed;
    const change *added, *moved;
    size_t n_removed, n_added, n_moved;
} frame;

typedef struct scene {
    const char *name;
    uint32_t dims, ids, n_frames; /* ids are below `ids`; in 2D all z are 0 */
    frame *frames;
    float size;      /* half of the boxes that are not static are not wider */
    double distance; /* of the scene from the origin, on all axes */

    /* Of all boxes up to 1000 times that wide, for those that must be told where the
     * world ends. */
    float world_min[3], world_max[3];
} scene;

/* A pair of ids. */
typedef struct id_pair {
    uint32_t a, b;
} id_pair;

typedef struct mode {
    const char *name;
    int takes_doubles; /* it is given true_min and true_max, and answers for those */
    void *(*open)(const scene *s);
    void (*step)(void *state, const frame *f);
    size_t (*pairs)(void *state, id_pair *out, size_t room); /* how many there are; not timed */
} mode;

/* Those that a program has, up to one without a name. */
extern const mode modes[];

/* malloc that ends the program if there is no memory; the block is zeroed. */
void *get(size_t count, size_t size);

/* Ends the program with a line on stderr. */
void give_up(const char *format, ...);

#ifdef __cplusplus
}
#endif

#endif
