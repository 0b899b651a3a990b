/* A player: replays a trace into a world, frame by frame, and takes the time.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef PLAYER_H
#define PLAYER_H

#include "trace.h"

#include <multisap.h>

typedef struct player {
    const trace *trace;
    msap_world *world;
    const uint32_t *at;     /* where the next frame starts */
    uint32_t next_frame;    /* its number */
    uint64_t boxes;         /* live after the frame played last */
    msap_handle *handle_of; /* by box of the trace; of those that are there */

    trace_frame frame;                 /* the one played last, and what came of it */
    const msap_pair *created, *deleted; /* the world's, until the next frame */
    size_t n_created, n_deleted, n_active;
    double ms; /* that the library took for it */

    msap_handle *handles; /* of the records at hand, in their order */
    uint32_t *flags;
} player;

/* Makes a player and its empty world: DONE, or FAILED with a complaint. config's
 * dims become the trace's. */
int player_begin(player *p, const trace *t, msap_config *config);

/* Plays the next frame, of which there must be one: DONE, or FAILED with a complaint. */
int player_play(player *p);

void player_end(player *p);

/* Milliseconds of a clock that only ever goes forward. */
double clock_ms(void);

#endif
