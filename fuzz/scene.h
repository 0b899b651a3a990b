/* Scenes: bytes become a set-up and then calls of the library.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A byte chooses a call, those behind it its arguments. Boxes are named by the order
 * in which they were added; whatever the bytes are, the calls are legal ones, except
 * for CALL_WRONG. What a call of many boxes is given comes from a random number that
 * the input seeds, so that few bytes make a large scene.
 */
#ifndef SCENE_H
#define SCENE_H

#include "../tests/unit/common.h"
#include "../tests/unit/setups.h"
#include "fuzz.h"

enum { MOST_BOXES = 1536 };

/* A config of all that can be chosen. */
msap_config take_config(input *in, uint32_t dims);

/* The boxes that a scene has. */
typedef struct herd {
    struct member {
        msap_handle handle;
        box bounds;
    } live[MOST_BOXES];
    size_t count;
    msap_handle dead; /* a handle that is stale, or MSAP_NULL_HANDLE */
    size_t most;      /* boxes at once */
} herd;

typedef enum call_kind {
    CALL_ADD,
    CALL_ADD_MANY,
    CALL_UPDATE,
    CALL_UPDATE_MANY,
    CALL_REMOVE,
    CALL_REMOVE_MANY,
    CALL_SHIFT,
    CALL_TRIM,
    CALL_COMMIT,
    CALL_DATA,
    CALL_WRONG,
    CALL_OTHER /* means what the harness makes of `argument` */
} call_kind;

/* A call with its arguments; those of a call of one box come first in the arrays. */
typedef struct call {
    call_kind kind;
    uint32_t argument; /* 2 bytes that mean something to the harness */
    size_t k;
    size_t member[MOST_BOXES]; /* of the herd; of updates and removals */
    msap_handle handles[MOST_BOXES];
    box bounds[MOST_BOXES];
    uint32_t flags[MOST_BOXES];
    void *data[MOST_BOXES];
    double offset[3];
    msap_boxes boxes; /* the bounds in one of many layouts */
} call;

/* Takes the next call; returns 0 when the input is at its end. */
int take_call(input *in, const herd *h, call *c);

/* Brings the herd up to date with a call that the library has carried out; for
 * additions, c->handles are what it gave. */
void herd_follow(herd *h, const call *c);

#endif
