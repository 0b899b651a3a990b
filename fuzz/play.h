/* Playing a scene in one world, against brute force.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef PLAY_H
#define PLAY_H

#include "scene.h"

/* Plays an input. After every commit, every trim and every call that failed, all that
 * can be read of the world is compared with the reference, and the world is validated.
 * With failing, the input also tells which allocations fail and how many bytes there
 * are. Returns a hash of all handles, events, pairs in their order, and statistics. */
uint64_t play(const uint8_t *data, size_t size, int failing);

/* The limit of a world for scenes of at most so many boxes: wrong calls may double them. */
#define BOX_LIMIT(most) (2 * (most))

/* Makes a call that must be refused, and checks the status and the last error. */
void wrong_call(session *s, const herd *h, call *c);

/* Makes a call from inside a callback: one that changes the world is refused, others
 * are not. a and b are the callback's boxes. */
void call_inside(session *s, msap_handle a, msap_handle b, uint32_t argument);

#endif
