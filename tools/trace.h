/* Scene traces: what a scene asks of a broad phase, frame by frame, read from a file.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef TRACE_H
#define TRACE_H

#include <stddef.h>
#include <stdint.h>

/* Sizes in 32-bit words. */
enum { TRACE_HEAD = 11, TRACE_COUNTS = 3, TRACE_ADDITION = 8, TRACE_UPDATE = 7 };

/* A trace whose every record was checked. Its boxes are numbered 0 ... boxes - 1;
 * ids[i] is the id that the file gives to box i. An id that is removed and added
 * again stays the same box here. */
typedef struct trace {
    const char *path;
    uint32_t frames, max_ids, dims;
    float world_min[3], world_max[3]; /* a hint, not checked: any bits of floats */
    uint32_t boxes;      /* ids that the file adds */
    uint32_t *ids;       /* of each box, ascending */
    size_t most_records; /* most removals, additions or updates of one frame */
    size_t bytes;        /* of the file */
    size_t n_words;
    uint32_t *words; /* the file's, in the host's byte order, ids replaced by box numbers */
} trace;

/* The records of a frame, in the trace's words:
 * removal: box; addition: box, flags, min[3], max[3]; update: box, min[3], max[3].
 * The bounds are the bits of floats. */
typedef struct trace_frame {
    uint32_t n_remove, n_add, n_update;
    const uint32_t *remove, *add, *update;
} trace_frame;

/* Reads and checks a whole trace: DONE, or FAILED after a line on stderr that says
 * what is wrong in which frame and record. What it allocates follows the file's
 * size, whatever the file says of itself. path must live as long as the trace. */
int trace_load(trace *t, const char *path);
void trace_free(trace *t);

/* Where the first frame starts; and one frame, with where the next one starts. */
const uint32_t *trace_begin(const trace *t);
const uint32_t *trace_next(const uint32_t *at, trace_frame *frame);

#endif
