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
    uint32_t dims;
    size_t count, most; /* boxes now, and at once */
    msap_handle dead;   /* a handle that is stale, or MSAP_NULL_HANDLE */
    struct member {
        msap_handle handle;
        box bounds;
    } live[MOST_BOXES];
} herd;

/* For a new scene of at most MOST_BOXES boxes at once. */
void herd_begin(herd *h, uint32_t dims, size_t most);

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
    const float *min, *max; /* of the first box */
    msap_boxes boxes;       /* the bounds in one of many layouts */
} call;

/* Where the library reads bounds: in blocks that end with what it may read, so that a
 * sanitizer sees it read further. A block lasts until the next one of its kind. */
msap_boxes lay_out(const box *from, size_t k, uint32_t layout);
void set_first(call *c, uint32_t dims);

/* Takes the next call; returns 0 when the input is at its end. */
int take_call(input *in, const herd *h, call *c);

/* Makes a call of the library; what is none is MSAP_OK. handles: for additions. */
msap_status carry_out(msap_world *world, const call *c, msap_handle *handles);

/* Brings the herd up to date with a call that the library has carried out; for
 * additions, c->handles are what it gave. */
void herd_follow(herd *h, const call *c);

#endif
