/* Scenes replayed by the library.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef LIBRARY_H
#define LIBRARY_H

#include "scene.h"

/* A scene and the world to replay it in; NULL for the defaults. */
typedef struct setting {
    const scene *scene;
    const msap_config *config;
    int has_statics; /* 1: boxes that do not move are static */
} setting;

typedef struct world_run {
    double first_ms, ms;    /* of the first commit, with all boxes; of a frame in the later half */
    uint64_t check;         /* of the pairs in the end */
    msap_world_stats stats; /* in the end */
    size_t events;          /* of the last frame */
    uint64_t bytes_trimmed; /* what is held after msap_trim */
} world_run;

world_run library_run(const setting *s);

/* A way_fn; `what` is a setting. Its time is that of a frame. */
outcome library_replay(const void *what);

msap_config config_of(msap_grid grid, msap_strategy strategy, float margin);

#endif
