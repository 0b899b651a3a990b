/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * What the tests of the library share; it needs nothing but the C library, POSIX
 * threads and multisap.h.
 *
 *   random numbers  an integer generator, so that every machine tests the same
 *   tracker         an allocator that fails on demand and checks what it gets back,
 *                   and from which thread
 *   reference       the contract by brute force: which handles, pairs and events
 *   session         a world and a reference that are given the same calls and
 *                   compared after every commit
 *
 * What checks something returns NULL if all is right, else a sentence about what
 * is not.
 */
#ifndef COMMON_H
#define COMMON_H

#include <pthread.h>
#include <stddef.h>
#include <stdint.h>

#include "multisap.h"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* ----------------------------------------------------------- random numbers */

uint64_t random_next(uint64_t *state);                /* splitmix64 */
uint32_t random_below(uint64_t *state, uint32_t end); /* 0 ... end - 1; end > 0 */

/* ------------------------------------------------------------------- floats */

float float_of(uint32_t bits);
uint32_t bits_of(float value);

/* -------------------------------------------------------------------- boxes */

typedef struct box {
    float min[3], max[3];
} box;

/* Closed intervals, compared as floats. */
int boxes_overlap(const box *a, const box *b, uint32_t dims);

/* The kinds of random boxes. */
typedef enum scene_kind {
    SCENE_GRID,   /* small integers: equal end points, touching and empty boxes abound */
    SCENE_SPREAD, /* many values, few overlaps */
    SCENE_HARD,   /* infinities, FLT_MAX, subnormals, neighbours, zeros of both signs, any bits */
    SCENE_SIZES,  /* sizes of many orders of magnitude; all that are of a size go the same way */
    SCENE_COUNT
} scene_kind;

box random_box(uint64_t *state, scene_kind scene);

/* A small motion: in SCENE_HARD there is none, so a new random box. */
box moved_box(uint64_t *state, scene_kind scene, const box *from);

/* `k` boxes in a row, as msap_add_many takes them. */
msap_boxes boxes_in_row(const box *boxes);

/* ------------------------------------------------------------------- memory */

typedef struct tracker {
    size_t blocks, bytes, peak; /* out now, and the most bytes ever */
    size_t calls;               /* of tracked_alloc so far */
    size_t fail_at;             /* the call that fails, counted from 1; 0: none */
    size_t fail_from;           /* the first of those that fail until memory is back; 0: none */
    int fail_all;
    size_t limit;    /* bytes that may be out at once; 0: any */
    size_t failures; /* calls that failed so far */
    size_t wrong;    /* blocks that came back with another size, or were none */
    size_t foreign;  /* calls from another thread than the first */
    pthread_t owner; /* the thread of the first call */
} tracker;

void *tracked_alloc(void *user, size_t size); /* user: a tracker; the block is filled with junk */
void tracked_free(void *user, void *pointer, size_t size);

/* ---------------------------------------------------------------- reference */

typedef struct event {
    int created; /* else deleted */
    msap_handle a, b;
    void *data_a, *data_b, *pair_data;
} event;

typedef struct slot {
    box bounds;
    msap_handle handle; /* of the box that holds the slot or held it last */
    void *data;
    uint32_t flags;
    enum { SLOT_FREE, SLOT_LIVE, SLOT_REMOVED } state;
    int changed; /* since the last commit */
} slot;

typedef struct reference {
    uint32_t dims;
    slot *slots;
    uint32_t *removed; /* slots in the order of removal since the last commit */
    uint32_t *freed;   /* slots to be given out again, the next one first */
    msap_pair *pairs;  /* at the last commit, sorted by (a, b) */
    event *events;     /* of the last commit, in order */
    size_t slot_count, removed_count, freed_count, pair_count, event_count;
    size_t slot_room, removed_room, freed_room, pair_room, event_room;
    size_t live, commits;
    uint32_t first_generation; /* of a slot that is new */
    size_t idle;               /* commits in a row with few of many slots live */
} reference;

void reference_open(reference *r, uint32_t dims);
void reference_close(reference *r);
msap_handle reference_add(reference *r, const box *bounds, uint32_t flags, void *data);
void reference_update(reference *r, msap_handle handle, const box *bounds);
void reference_remove(reference *r, msap_handle handle);
void reference_commit(reference *r);

/* Forgets the free slots at the end. */
void reference_trim(reference *r);

slot *reference_slot(reference *r, msap_handle handle);

/* The user data that the tests' create callback gives a pair: another at every
 * commit. */
void *pair_tag(msap_handle a, msap_handle b, size_t commit);

/* ------------------------------------------------------------------ session */

typedef struct session {
    msap_world *world;
    reference reference;
    tracker memory;
    uint64_t random;
    scene_kind scene;
    event *events; /* what the callbacks of the last commit were called with */
    size_t event_count, event_room;
    size_t failures;    /* of memory.failures, those that were answered by calling again */
    uintptr_t next_tag; /* user data of the next box */
    uint32_t statics;   /* of sixteen random boxes so many are static; when it is opened, 4 */
    const char *wrong;  /* what a failed call changed */
} session;

/* config may be NULL; its allocator is replaced by the session's memory. */
const char *session_open(session *s, const msap_config *config, uint64_t seed, scene_kind scene);
const char *session_close(session *s);

/* One box, with the reference's opinion on status and handle. A call that fails
 * because memory.fail_at or fail_from said so must leave the world alone, and is
 * called again with memory back. */
const char *session_add(session *s, const box *bounds, uint32_t flags, msap_handle *handle);
const char *session_update(session *s, msap_handle handle, const box *bounds);
const char *session_remove(session *s, msap_handle handle);

/* Commits and compares callbacks and counts with the reference. */
const char *session_commit(session *s);

/* Trims, after which the events of the last commit are no more. */
const char *session_trim(session *s);

/* Compares all that can be read of the world, pending changes and the last commit's
 * events included, with the reference, and validates. */
const char *session_compare(session *s);

/* The changes of one frame: random additions, updates and removals, single and in
 * batches, few or many, about `boxes` boxes in all. */
const char *session_change(session *s, uint32_t boxes);

/* session_change, session_commit and session_compare. */
const char *session_step(session *s, uint32_t boxes);

#endif
