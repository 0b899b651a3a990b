/* multisap: which axis-aligned boxes overlap, and which pairs came and went.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * This header is the manual. A world holds boxes; msap_commit brings it up to
 * date and reports the pairs of boxes that began and ceased to overlap since the
 * commit before. The method is Terdiman's persistent sweep-and-prune (SAP) and
 * Multi-SAP; "paper" below means his "Sweep-and-prune", version 0.2 (2007).
 *
 *     msap_config config;
 *     msap_world *world;
 *     msap_config_init(&config, sizeof config);
 *     msap_create(&config, &world);
 *     msap_add(world, min, max, 0, NULL, &box);     boxes come,
 *     msap_update(world, box, min, max);            move
 *     msap_remove(world, box);                      and go;
 *     msap_commit(world, &callbacks, NULL);         then the pairs are asked for
 *     msap_destroy(world);
 *
 * THE CONTRACT
 *
 * 1. Exact. After a commit the pairs are exactly the pairs of live boxes, not
 *    both static, whose bounds, as the floats that were given, overlap on every
 *    axis. Intervals are closed: boxes that touch overlap, and -0 equals +0.
 *    Nothing is quantized or padded in what is reported, whatever the set-up.
 *    The library compares integers only, so rounding modes, flush-to-zero and
 *    -ffast-math in the host change nothing.
 * 2. History does not matter. The same boxes give the same pairs, however they
 *    got there.
 * 3. Net events, in order. Per commit a pair is reported at most once, and every
 *    deletion answers an earlier creation. All deletions come first, then all
 *    creations, each sorted by (lower handle, higher handle) as integers.
 *    Callbacks run in the order of the arrays. The same calls give the same
 *    events and the same handles on every platform, with every set-up, with any
 *    number of workers.
 * 4. Nothing is dropped silently. NaN, min > max, a stale handle, a full world,
 *    no memory: each is a status code, in every build, and msap_last_error tells
 *    the index and the bound at fault. The world is then as it was before the
 *    call. Infinite bounds and +-FLT_MAX are legal. (A handle of another world is
 *    caught where slot or generation differ.)
 *    A failed commit delivers nothing: the last commit's pairs and the pending
 *    changes stay, and the next commit reports the net difference to the last
 *    successful one. A commit makes all its allocations before the first
 *    callback and cannot fail after it; a commit that only loses pairs needs no
 *    memory.
 * 5. No surprises for the host. No globals, no hidden threads, no assertions on
 *    what the caller passes, no printing. One thread per world at a time,
 *    different worlds at once; calls that take a const world may run at once with
 *    each other. Memory comes only from the world's allocator, called only on the
 *    thread that calls the library, and none is asked for in a commit that passes
 *    no earlier maximum of boxes, pairs, neighbours, events or cells; it shrinks
 *    only when use has stayed far below what is held for many commits, or by
 *    msap_trim. (So that a box takes some 200 bytes, a world of more than 65,536
 *    gives back what it has worked in once all boxes have got new skins or rest,
 *    and asks for it again the next time; without it that commit takes far
 *    longer.) From inside a callback every call that changes the world is refused
 *    with MSAP_ERROR_BUSY; const calls are allowed.
 *
 * CONVENTIONS
 *
 * Every function that can fail returns a status and gives results by out
 * pointers, which are left alone on failure. Out pointers may not be NULL unless
 * said. Costs are given with n boxes in the world, k boxes in the call and p
 * pairs. "Thread rule: owner" means the one thread that may use the world at
 * that time; "reader" means any threads at once, while no owner call runs;
 * "free" means no rule at all.
 */
#ifndef MULTISAP_H
#define MULTISAP_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(_WIN32) && defined(MSAP_SHARED)
#ifdef MSAP_BUILD
#define MSAP_API __declspec(dllexport)
#else
#define MSAP_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define MSAP_API __attribute__((visibility("default")))
#else
#define MSAP_API
#endif

/* ------------------------------------------------------------------ version */

#define MSAP_VERSION_MAJOR 0
#define MSAP_VERSION_MINOR 1
#define MSAP_VERSION_PATCH 0

/* The version of this header as one number: major * 10000 + minor * 100 + patch. */
#define MSAP_VERSION_NUMBER (MSAP_VERSION_MAJOR * 10000 + MSAP_VERSION_MINOR * 100 + MSAP_VERSION_PATCH)

/* The version of the library that is running, as MSAP_VERSION_NUMBER was when it
 * was built. Cannot fail. Thread rule: free. Cost: constant. */
MSAP_API uint32_t msap_version(void);

/* The same as text, "0.1.0", owned by the library. Thread rule: free. */
MSAP_API const char *msap_version_text(void);

/* ------------------------------------------------------------------- status */

/* What a call came to. The numbers are pinned: they never change or get a new
 * meaning, so that bindings can map them once. */
typedef enum msap_status {
    MSAP_OK = 0,
    MSAP_ERROR_NULL = 1,        /* a pointer that must not be NULL was */
    MSAP_ERROR_STRUCT_SIZE = 2, /* struct_size is none that this library knows */
    MSAP_ERROR_CONFIG = 3,      /* a field or argument holds a value that is not allowed */
    MSAP_ERROR_MEMORY = 4,      /* the allocator returned NULL, or a size overflowed */
    MSAP_ERROR_NAN = 5,         /* a bound is not a number */
    MSAP_ERROR_INVERTED = 6,    /* a min is above its max */
    MSAP_ERROR_HANDLE = 7,      /* null, stale or garbage handle */
    MSAP_ERROR_FULL = 8,        /* the limit of boxes or pairs is reached */
    MSAP_ERROR_BUSY = 9,        /* called from inside a callback, or while another call runs */
    MSAP_ERROR_NOT_A_PAIR = 10, /* the two boxes were no pair at the last commit */
    MSAP_ERROR_CORRUPT = 11     /* msap_validate found a broken invariant: a bug or a stray write */
} msap_status;

/* One past the largest status of this version. */
#define MSAP_STATUS_COUNT 12

/* A sentence about a status in English, owned by the library; for a number that
 * is no status, a sentence that says so. Never NULL. Thread rule: free. */
MSAP_API const char *msap_status_text(msap_status status);

/* ------------------------------------------------------------------ handles */

/* A box of a world. High 32 bits: the index of its slot; low 32 bits: the
 * generation of the slot, from 1. 0 is no box. A removed box's slot is not given
 * out again before the commit that reports the removal, then in the order of
 * freeing. A slot whose generation would wrap is retired. When memory is given back
 * (msap_trim), free slots at the end of the table are forgotten; slots that take
 * their place later begin with a generation that none of them had. */
typedef uint64_t msap_handle;

#define MSAP_NULL_HANDLE ((msap_handle)0)

/* The most boxes a world can hold: an end point has 31 bits for its box. */
#define MSAP_MAX_BOXES 2147483647u

/* ------------------------------------------------------------------- config */

/* What holds the boxes. The events are the same with each. */
typedef enum msap_grid {
    MSAP_GRID_AUTO = 0, /* a Multi-SAP: a wrapped grid over all space; its cells follow from the boxes (II) */
    MSAP_GRID_NONE = 1, /* a single SAP (I): three sorted axes over all boxes */
    MSAP_GRID_FIXED = 2 /* a Multi-SAP of grid_cells between grid_min and grid_max, wrapped beyond (II.3a) */
} msap_grid;

/* Ways to bring a world up to date. All give the same events; AUTO chooses for each
 * commit by estimated cost. In a Multi-SAP, SLIDE moves the boxes that left their
 * skins one by one, MERGE does so cell by cell, and SWEEP rebuilds all cells. */
typedef enum msap_strategy {
    MSAP_STRATEGY_AUTO = 0,
    MSAP_STRATEGY_SLIDE = 1, /* move each end point to its place (I.3): little motion */
    MSAP_STRATEGY_MERGE = 2, /* take the changed boxes out and batch-insert them (I.4b, I.5b): few boxes jump */
    MSAP_STRATEGY_SWEEP = 3  /* sort anew and prune everything (I.4c): most boxes jump */
} msap_strategy;

/* Which vector instructions may be used; for tests. More than the machine has is
 * taken as the best it has. */
typedef enum msap_simd {
    MSAP_SIMD_AUTO = 0, /* the best that the machine has */
    MSAP_SIMD_NONE = 1, /* portable C */
    MSAP_SIMD_128 = 2,  /* four boxes at a time: SSE2, NEON */
    MSAP_SIMD_256 = 3,  /* eight boxes at a time: AVX2 */
    MSAP_SIMD_512 = 4   /* sixteen where that pays, else eight: AVX-512 */
} msap_simd;

#define MSAP_MARGIN_AUTO (-1.0f) /* each box has a skin that follows its own motion */

/* Gives `size` bytes, aligned for any type, or NULL. `user` is config.allocator_user. */
typedef void *(*msap_alloc_fn)(void *user, size_t size);

/* Takes back what msap_alloc_fn gave; `size` is the size that was asked for. Never called with NULL. */
typedef void (*msap_free_fn)(void *user, void *pointer, size_t size);

/* A piece of work of a commit or of msap_update_many. Tasks may run at the same time, in any
 * order, on any thread; they never wait for each other and never allocate. */
typedef void (*msap_task_fn)(void *task);

/* Runs run(task) on another thread and returns a ticket for msap_finish_fn, or runs it
 * at once and returns NULL. Called on the thread that called the library. */
typedef void *(*msap_enqueue_fn)(void *user, msap_task_fn run, void *task);

/* Returns when the task of a ticket has run, and what it wrote can be read. */
typedef void (*msap_finish_fn)(void *user, void *ticket);

/* How a world is set up. Fill it with msap_config_init, then change fields. */
typedef struct msap_config {
    uint32_t struct_size; /* set by msap_config_init */
    uint32_t dims;        /* 2 or 3 axes; default 3. A 2D world reads and pays for two */
    uint32_t grid;        /* an msap_grid; default MSAP_GRID_AUTO */
    uint32_t strategy;    /* an msap_strategy; default MSAP_STRATEGY_AUTO */
    uint32_t filters;     /* single SAP: 1 drops touched pairs early by the paper's overlap tests (I.3), 0 settles
                             them all; default 1 */
    uint32_t simd;        /* an msap_simd; default MSAP_SIMD_AUTO */
    uint32_t max_boxes;   /* msap_add refuses more with MSAP_ERROR_FULL; default MSAP_MAX_BOXES */
    uint32_t workers;     /* into how many tasks a commit, or an update of most boxes, may be cut, 1 to 64;
                             default 1: none. Needs enqueue */
    uint32_t task_grain;  /* how much work is worth a task, in boxes touched; 0 (the default): 24576, about 150
                             microseconds. Less is for hosts whose tasks start sooner */
    float margin;         /* Multi-SAP: by how much the cells' idea of a box is wider than the box, in the unit of
                             the bounds, 0 or more; or MSAP_MARGIN_AUTO (the default). Never seen in the events */
    float cell_size;      /* MSAP_GRID_AUTO: least width of a cell; 0 (the default): chosen from the boxes */
    uint32_t grid_cells[3]; /* MSAP_GRID_FIXED: cells on each axis, 1 to 4096 each; default 1, 1, 1 */
    float grid_min[3], grid_max[3]; /* MSAP_GRID_FIXED: finite, min < max on axes with more than one cell */
    msap_alloc_fn alloc;  /* both NULL (the default): malloc and free; on Linux, arrays that fill half of a
                             huge page (2 MB) or more stand in their own (madvise), so more may be resident than
                             is counted */
    msap_free_fn free;
    void *allocator_user; /* handed to alloc and free; default NULL */
    msap_enqueue_fn enqueue; /* the host's job system; both NULL (the default): everything runs on the caller */
    msap_finish_fn finish;
    void *jobs_user; /* handed to enqueue and finish; default NULL */
} msap_config;

/* Fills *config with the defaults; struct_size must be sizeof(msap_config) as the
 * caller knows it. Returns MSAP_ERROR_NULL, or MSAP_ERROR_STRUCT_SIZE for a size
 * that no version up to this one had. Thread rule: free. Cost: constant. */
MSAP_API msap_status msap_config_init(msap_config *config, size_t struct_size);

/* -------------------------------------------------------------------- world */

typedef struct msap_world msap_world;

/* Makes an empty world; *world is the caller's, to be given to msap_destroy.
 * config may be NULL for the defaults; it is copied. Errors: MSAP_ERROR_NULL,
 * _STRUCT_SIZE, _CONFIG, _MEMORY. Thread rule: free. Cost: constant. */
MSAP_API msap_status msap_create(const msap_config *config, msap_world **world);

/* Frees the world and all it holds, pending changes and events included. Calls no
 * callback. NULL is allowed. Refused with MSAP_ERROR_BUSY from inside a callback.
 * Thread rule: owner. Cost: the number of allocations, not of boxes. */
MSAP_API msap_status msap_destroy(msap_world *world);

/* -------------------------------------------------------------------- boxes */

/* Flags of a box. */
#define MSAP_STATIC 1u /* two static boxes never pair. A static box may be moved; being static cannot change */

/* Number formats of bounds in a batch. */
typedef enum msap_scalar {
    MSAP_FLOAT = 0, /* IEEE-754 binary32 */
    MSAP_DOUBLE = 1 /* IEEE-754 binary64, rounded outward to float (mins down, maxes up): nothing is missed */
} msap_scalar;

/* Bounds of k boxes in the caller's memory, with signed strides in bytes and any
 * alignment: component c of the min of box i is read at
 * (const char *)min + i * min_row + c * min_component. */
typedef struct msap_boxes {
    uint32_t struct_size; /* sizeof(msap_boxes) */
    uint32_t scalar;      /* an msap_scalar */
    const void *min;
    const void *max;
    ptrdiff_t min_row, min_component;
    ptrdiff_t max_row, max_component;
} msap_boxes;

/* Adds one box with bounds min[dims], max[dims] (floats, any unit), flags (0 or
 * MSAP_STATIC) and the user's pointer. The box takes part from the next commit
 * on. *handle names it until it is removed. Errors: MSAP_ERROR_NULL, _CONFIG
 * (unknown flags), _NAN, _INVERTED, _FULL, _MEMORY, _BUSY. Thread rule: owner.
 * Cost: constant, amortized. Paper I.4; the work is done by msap_commit. */
MSAP_API msap_status msap_add(msap_world *world, const float *min, const float *max, uint32_t flags,
                              void *user_data, msap_handle *handle);

/* Adds k boxes, all or none, and gives the handles that k calls of msap_add would.
 * flags and user_data are arrays of k, or NULL for 0 and NULL; handles has room
 * for k. Errors: as msap_add, and MSAP_ERROR_STRUCT_SIZE; msap_last_error names
 * the first offender. Thread rule: owner. Cost: O(k). Paper I.4b. */
MSAP_API msap_status msap_add_many(msap_world *world, size_t k, const msap_boxes *boxes, const uint32_t *flags,
                                   void *const *user_data, msap_handle *handles);

/* Gives a box new bounds, in effect at the next commit; of several updates between
 * two commits the last counts. Never allocates. Errors: MSAP_ERROR_NULL, _HANDLE,
 * _NAN, _INVERTED, _BUSY. Thread rule: owner. Cost: constant. Paper I.3. */
MSAP_API msap_status msap_update(msap_world *world, msap_handle handle, const float *min, const float *max);

/* Updates k boxes, all or none; of a handle that comes twice the last counts.
 * Errors: as msap_update, and MSAP_ERROR_STRUCT_SIZE, _CONFIG (scalar);
 * msap_last_error names the first offender. Most boxes of a world of many are updated
 * by its workers, unless they were updated since the last commit or come as doubles.
 * Thread rule: owner. Cost: O(k). Paper II.3d. */
MSAP_API msap_status msap_update_many(msap_world *world, size_t k, const msap_handle *handles,
                                      const msap_boxes *boxes);

/* Removes a box. Its handle is stale at once; its pairs are reported as deleted by
 * the next commit, and until that has run its user data can still be read. Never
 * allocates. Errors: MSAP_ERROR_NULL, _HANDLE, _BUSY. Thread rule: owner. Cost:
 * constant. Paper I.5. */
MSAP_API msap_status msap_remove(msap_world *world, msap_handle handle);

/* Removes k boxes, all or none: a handle that comes twice is stale the second time
 * and nothing is removed. Errors: as msap_remove. Thread rule: owner. Cost: O(k).
 * Paper I.5b. */
MSAP_API msap_status msap_remove_many(msap_world *world, size_t k, const msap_handle *handles);

/* Moves the origin of the whole world to `offset` (dims doubles, finite, in the unit of
 * the bounds): every bound b of every live box becomes b - offset, computed exactly and
 * then rounded outward to the nearest float, a min down and a max up; so a box grows by
 * less than one float on each side, and never misses what it touched. Infinite bounds
 * stay; a min beyond -FLT_MAX becomes -inf, a max beyond FLT_MAX becomes +inf, and where
 * the whole box is beyond, both do their outward part. Handles, pairs and user data
 * stay; pairs that rounding makes are events of the next commit. Counts as an update of
 * every box. Never allocates. Errors: MSAP_ERROR_NULL, _CONFIG (offset not finite),
 * _BUSY. Thread rule: owner. Cost: O(n). */
MSAP_API msap_status msap_shift_origin(msap_world *world, const double *offset);

/* The bounds as last given (pending updates included), with -0 as +0; min and max
 * have room for dims floats. Errors: MSAP_ERROR_NULL, _HANDLE. Thread rule:
 * reader. Cost: constant. */
MSAP_API msap_status msap_get_bounds(const msap_world *world, msap_handle handle, float *min, float *max);

/* Reads the user pointers of k boxes into user_data[k], all or none. A box that
 * was removed can be read until the commit that reports it has returned. Errors:
 * MSAP_ERROR_NULL, _HANDLE. Thread rule: reader. Cost: O(k). */
MSAP_API msap_status msap_get_user_data(const msap_world *world, size_t k, const msap_handle *handles,
                                        void **user_data);

/* Sets the user pointers of k live boxes, all or none. Room for them is taken with the
 * first that is given, here or to msap_add_many. Errors: MSAP_ERROR_NULL, _HANDLE,
 * _BUSY, _MEMORY. Thread rule: owner. Cost: O(k), the first time O(boxes). */
MSAP_API msap_status msap_set_user_data(msap_world *world, size_t k, const msap_handle *handles,
                                        void *const *user_data);

/* ------------------------------------------------------------------- commit */

/* A pair of overlapping boxes, a < b. This struct is frozen. */
typedef struct msap_pair {
    msap_handle a, b;
    void *user_data; /* what the create callback returned, or was set since */
} msap_pair;

/* Called for a pair that began to overlap; what it returns becomes the pair's user
 * data. a < b; data_a and data_b are the boxes' user data. */
typedef void *(*msap_create_fn)(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b);

/* Called for a pair that ceased to overlap, or lost a box. */
typedef void (*msap_delete_fn)(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b,
                               void *pair_data);

typedef struct msap_callbacks {
    uint32_t struct_size;     /* sizeof(msap_callbacks) */
    uint32_t reserved;        /* 0 */
    void *context;            /* handed to both */
    msap_create_fn on_create; /* NULL: the pair's user data is NULL */
    msap_delete_fn on_delete; /* NULL: none */
} msap_callbacks;

typedef struct msap_counts {
    uint32_t struct_size; /* sizeof(msap_counts), set by the caller */
    uint32_t reserved;    /* 0 */
    uint64_t created;     /* pairs that began to overlap */
    uint64_t deleted;     /* pairs that ceased to */
    uint64_t active;      /* pairs that overlap now */
} msap_counts;

/* Applies the pending changes and reports the events: on_delete for every deleted
 * pair, then on_create for every created one, each in order (contract, 3).
 * callbacks and counts may be NULL; the events can be read as arrays afterwards.
 * Errors: MSAP_ERROR_STRUCT_SIZE, _MEMORY, _FULL (more than 2^31 - 1 pairs),
 * _BUSY, each before the first callback. Thread rule: owner; callbacks run on the
 * calling thread. Cost: follows what changed; nothing changed, nothing done.
 * Paper I.3 to I.6. */
MSAP_API msap_status msap_commit(msap_world *world, const msap_callbacks *callbacks, msap_counts *counts);

/* The pairs that the last successful commit created, in order; *pairs is the
 * world's and valid until the next commit, trim or destroy. Errors:
 * MSAP_ERROR_NULL. Thread rule: reader. Cost: constant. */
MSAP_API msap_status msap_created(const msap_world *world, const msap_pair **pairs, size_t *count);

/* The pairs that the last successful commit deleted, in order, with the user data
 * they had; their boxes may be gone. As msap_created otherwise. */
MSAP_API msap_status msap_deleted(const msap_world *world, const msap_pair **pairs, size_t *count);

/* All pairs that overlapped at the last successful commit, as one array without
 * holes (paper I.6). Its order follows from the sequence of events alone, so it is
 * the same with every set-up. As msap_created otherwise. */
MSAP_API msap_status msap_pairs(const msap_world *world, const msap_pair **pairs, size_t *count);

/* Reads the user data of k pairs (a[i], b[i]), the two handles in any order, all or
 * none. Errors: MSAP_ERROR_NULL, _NOT_A_PAIR. Thread rule: reader. Cost: O(k). */
MSAP_API msap_status msap_get_pair_data(const msap_world *world, size_t k, const msap_handle *a,
                                        const msap_handle *b, void **pair_data);

/* Sets the user data of k pairs, all or none. Errors: MSAP_ERROR_NULL, _NOT_A_PAIR,
 * _BUSY. Thread rule: owner. Cost: O(k). */
MSAP_API msap_status msap_set_pair_data(msap_world *world, size_t k, const msap_handle *a, const msap_handle *b,
                                        void *const *pair_data);

/* ------------------------------------------------------------------- errors */

/* A bound of a box, as msap_last_error names it: axis, plus 3 for a max. */
typedef enum msap_bound {
    MSAP_MIN_X = 0,
    MSAP_MIN_Y = 1,
    MSAP_MIN_Z = 2,
    MSAP_MAX_X = 3,
    MSAP_MAX_Y = 4,
    MSAP_MAX_Z = 5,
    MSAP_NO_BOUND = 6
} msap_bound;

typedef struct msap_error {
    uint32_t struct_size; /* sizeof(msap_error), set by the caller */
    uint32_t status;      /* an msap_status: what the last failed owner call on this world returned; MSAP_OK if none */
    uint64_t index;       /* of the first offender in a batch; 0 for a call with one box */
    uint32_t bound;       /* an msap_bound: the NaN, or the min that is above its max; else MSAP_NO_BOUND */
    uint32_t reserved;    /* 0 */
} msap_error;

/* What the last owner call that failed on this world failed for; calls that succeed
 * do not clear it, and const calls do not set it. Errors: MSAP_ERROR_NULL,
 * _STRUCT_SIZE. Thread rule: reader. Cost: constant. */
MSAP_API msap_status msap_last_error(const msap_world *world, msap_error *error);

/* -------------------------------------------------------- looking after it */

typedef struct msap_world_stats {
    uint32_t struct_size;       /* sizeof(msap_world_stats), set by the caller */
    uint32_t reserved;          /* 0 */
    uint64_t boxes;             /* live, pending additions included */
    uint64_t pairs;             /* active at the last commit */
    uint64_t pending;           /* boxes added, updated or removed since the last commit */
    uint64_t bytes;             /* held from the allocator now */
    uint64_t bytes_peak;        /* the most ever held */
    uint64_t allocations;       /* calls of alloc so far */
    uint64_t commits;           /* successful ones so far */
    uint64_t crossings;         /* of the last commit: a min and a max of two boxes changed places */
    uint64_t touched;           /* of the last commit: pairs looked at, repeats included */
    uint64_t slides, merges, sweeps; /* commits so far that used each strategy */
    uint64_t moves;             /* Multi-SAP, of the last commit: boxes put into other cells or given a new skin */
    uint64_t cells;             /* Multi-SAP: cells that hold boxes */
    uint64_t cells_empty;       /* and those that have memory for their head only */
    uint64_t incidences;        /* boxes counted once for every cell they are in; over boxes: the replication */
    uint64_t largest_cell;      /* boxes in the fullest cell */
    uint64_t giants;            /* boxes too large for any grid, kept in one cell of their own */
    uint64_t candidates;        /* pairs of neighbours: boxes whose skins overlap */
} msap_world_stats;

/* Fills *stats. Boxes may be in no cell: those that have not moved since a commit that pruned
 * all boxes, as static ones of a world that was loaded, two of which are no candidates, and
 * those that have not left a skin that they got together with all others.
 * Errors: MSAP_ERROR_NULL, _STRUCT_SIZE. Thread rule: reader. Cost: O(n + cells). */
MSAP_API msap_status msap_stats(const msap_world *world, msap_world_stats *stats);

/* Checks every invariant of the world; reads only, allocates nothing, and is legal
 * with changes pending. *what, if what is not NULL, becomes a sentence about the
 * first broken invariant, or NULL. Returns MSAP_OK or MSAP_ERROR_CORRUPT (or _NULL).
 * Thread rule: reader. Cost: O(n + p). */
MSAP_API msap_status msap_validate(const msap_world *world, const char **what);

/* Gives memory that the world does not need back to the allocator. The event
 * arrays of the last commit become empty. Errors: MSAP_ERROR_NULL, _BUSY; when no
 * memory can be had for a smaller block, the larger one is kept. Thread rule:
 * owner. Cost: O(n + p). */
MSAP_API msap_status msap_trim(msap_world *world);

/* -------------------------------------------------------------- box pruning */

/* An entry of box pruning's result: two indices into the arrays. Frozen. */
typedef struct msap_index_pair {
    uint32_t a, b;
} msap_index_pair;

#define MSAP_AXIS_AUTO (-1) /* sweep along the axis on which the boxes spread most */

typedef struct msap_prune_config {
    uint32_t struct_size; /* set by msap_prune_config_init */
    uint32_t dims;        /* 2 or 3; default 3 */
    int32_t axis;         /* 0 ... dims - 1, or MSAP_AXIS_AUTO (the default): by variance of the centres */
    uint32_t reserved;    /* 0 */
    msap_alloc_fn alloc;  /* both NULL (the default): malloc and free */
    msap_free_fn free;
    void *allocator_user;
} msap_prune_config;

/* Fills *config with the defaults; as msap_config_init. */
MSAP_API msap_status msap_prune_config_init(msap_prune_config *config, size_t struct_size);

/* Complete box pruning (paper I.4c): all overlapping pairs among k boxes, a < b,
 * sorted by (a, b). One shot, no state. *pairs becomes an array of *count from the
 * allocator, to be given to msap_prune_free, or NULL if there is none. config may
 * be NULL for the defaults; error may be NULL, else (with its struct_size set) it
 * tells index and bound of the first offender. Errors: MSAP_ERROR_NULL,
 * _STRUCT_SIZE, _CONFIG, _NAN, _INVERTED, _FULL, _MEMORY. Thread rule: free. Cost:
 * O(k log k + pairs that overlap on the sweep axis). */
MSAP_API msap_status msap_prune(const msap_prune_config *config, size_t k, const msap_boxes *boxes,
                                msap_index_pair **pairs, size_t *count, msap_error *error);

/* Bipartite box pruning (paper I.4c): the overlapping pairs of a box a of the first
 * set and a box b of the second, sorted by (a, b). In *error the indices of the
 * second set follow those of the first. As msap_prune otherwise. */
MSAP_API msap_status msap_prune_bipartite(const msap_prune_config *config, size_t k_a, const msap_boxes *boxes_a,
                                          size_t k_b, const msap_boxes *boxes_b, msap_index_pair **pairs,
                                          size_t *count, msap_error *error);

/* Frees a result of msap_prune or msap_prune_bipartite, made with the same config.
 * Thread rule: free. */
MSAP_API msap_status msap_prune_free(const msap_prune_config *config, msap_index_pair *pairs, size_t count);

/* ------------------------------------------------------------------ numbers */

/* A float as an unsigned integer of the same order (paper, appendix A): a < b as
 * floats exactly if encode(a) < encode(b), and encode(-0) is encode(+0). NaNs are
 * encoded too, above +inf or below -inf by sign. Thread rule: free. */
MSAP_API uint32_t msap_encode_float(float value);

/* The float that msap_encode_float maps to code. Thread rule: free. */
MSAP_API float msap_decode_float(uint32_t code);

#ifdef __cplusplus
}
#endif

#endif
