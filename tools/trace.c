/* Reads a scene trace and checks every record before anything is replayed.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The format: the 8 bytes "SAPTRC01", then nothing but little-endian 32-bit words:
 *
 *     frames, max_ids, dims, world_min[3], world_max[3]     (a hint, not checked)
 *     for each frame:
 *         n_remove, n_add, n_update
 *         n_remove times  id
 *         n_add    times  id, flags, min[3], max[3]
 *         n_update times  id, min[3], max[3]
 *
 * So the file is read whole, its words are put into the host's byte order, and four
 * passes go over them: do the counts fit the file; which ids are added at all
 * (sorted, so that an id's place in the list numbers the box: memory follows the
 * file and not max_ids); is every record legal, whereby ids become box numbers. */
#include "trace.h"
#include "command.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAGIC = 8 };

static float float_of(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* --------------------------------------------------------------- the bytes */

static int grow(unsigned char **bytes, size_t *room)
{
    size_t more = *room ? *room * 2 : 1 << 16;
    unsigned char *bigger = more > *room ? realloc(*bytes, more) : NULL;
    if (!bigger)
        return 0;
    *bytes = bigger;
    *room = more;
    return 1;
}

static int read_all(FILE *file, trace *t, unsigned char **bytes)
{
    size_t room = 0;
    do {
        if (t->bytes == room && !grow(bytes, &room))
            return FAIL("%s: no memory to read it", t->path);
        t->bytes += fread(*bytes + t->bytes, 1, room - t->bytes, file);
    } while (!ferror(file) && !feof(file));
    if (ferror(file))
        return FAIL("%s: cannot be read: %s", t->path, strerror(errno));
    return DONE;
}

/* The words take the place of the bytes that they are made from. */
static void bytes_to_words(trace *t, unsigned char *bytes)
{
    size_t n = t->bytes < MAGIC ? 0 : (t->bytes - MAGIC) / 4;
    for (size_t i = 0; i < n; i++) {
        const unsigned char *b = bytes + MAGIC + 4 * i;
        uint32_t word = b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
        memcpy(bytes + 4 * i, &word, sizeof word);
    }
    t->n_words = n;
    t->words = (uint32_t *)(void *)bytes;
}

static int read_file(trace *t)
{
    unsigned char *bytes = NULL;
    FILE *file = fopen(t->path, "rb");
    if (!file)
        return FAIL("%s: cannot be opened: %s", t->path, strerror(errno));
    int result = read_all(file, t, &bytes);
    fclose(file);
    if (result == DONE && (t->bytes < MAGIC || memcmp(bytes, "SAPTRC01", MAGIC) != 0))
        result = FAIL("%s: not a scene trace: it does not begin with SAPTRC01", t->path);
    if (result == DONE)
        bytes_to_words(t, bytes);
    else
        free(bytes);
    return result;
}

/* ------------------------------------------------------------- the structure */

static int read_head(trace *t)
{
    if (t->n_words < TRACE_HEAD - MAGIC / 4)
        return FAIL("%s: the file ends in the header, after %zu bytes", t->path, t->bytes);
    t->frames = t->words[0];
    t->max_ids = t->words[1];
    t->dims = t->words[2];
    if (t->dims != 2 && t->dims != 3)
        return FAIL("%s: header: dims is %u, not 2 or 3", t->path, (unsigned)t->dims);
    for (int k = 0; k < 3; k++) {
        t->world_min[k] = float_of(t->words[3 + k]);
        t->world_max[k] = float_of(t->words[6 + k]);
    }
    return DONE;
}

const uint32_t *trace_begin(const trace *t)
{
    return t->words + TRACE_HEAD - MAGIC / 4;
}

const uint32_t *trace_next(const uint32_t *at, trace_frame *f)
{
    f->n_remove = at[0];
    f->n_add = at[1];
    f->n_update = at[2];
    f->remove = at + TRACE_COUNTS;
    f->add = f->remove + f->n_remove;
    f->update = f->add + (size_t)TRACE_ADDITION * f->n_add;
    return f->update + (size_t)TRACE_UPDATE * f->n_update;
}

static int ends_early(const trace *t, uint32_t frame, const char *record, size_t index, uint32_t count)
{
    return FAIL("%s: frame %u, %s %zu of %u: the file ends too early, after %zu bytes", t->path,
                (unsigned)frame, record, index, (unsigned)count, t->bytes);
}

/* Whether the records that a frame's counts announce are all there. */
static int check_counts(trace *t, uint32_t frame, const uint32_t *at)
{
    static const char *const record[TRACE_COUNTS] = {"removal", "addition", "update"};
    static const size_t words[TRACE_COUNTS] = {1, TRACE_ADDITION, TRACE_UPDATE};
    size_t left = t->n_words - (size_t)(at - t->words);
    if (left < TRACE_COUNTS)
        return FAIL("%s: frame %u of %u: the file ends too early, after %zu bytes", t->path,
                    (unsigned)frame, (unsigned)t->frames, t->bytes);
    left -= TRACE_COUNTS;
    for (int i = 0; i < TRACE_COUNTS; i++) {
        if (at[i] > left / words[i])
            return ends_early(t, frame, record[i], left / words[i], at[i]);
        left -= at[i] * words[i];
        if (at[i] > t->most_records)
            t->most_records = at[i];
    }
    return DONE;
}

static int check_structure(trace *t)
{
    const uint32_t *at = trace_begin(t);
    for (uint32_t frame = 0; frame < t->frames; frame++) {
        trace_frame f;
        int result = check_counts(t, frame, at);
        if (result)
            return result;
        at = trace_next(at, &f);
    }
    size_t used = MAGIC + 4 * (size_t)(at - t->words);
    if (used != t->bytes)
        return FAIL("%s: %zu bytes are left over after the last of %u frames", t->path,
                    t->bytes - used, (unsigned)t->frames);
    return DONE;
}

/* ---------------------------------------------------------------------- ids */

static int by_value(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}

/* Gathers the ids of all additions into ids, or only counts them if ids is NULL. */
static size_t gather_ids(const trace *t, uint32_t *ids)
{
    const uint32_t *at = trace_begin(t);
    size_t n = 0;
    for (uint32_t frame = 0; frame < t->frames; frame++) {
        trace_frame f;
        at = trace_next(at, &f);
        for (uint32_t i = 0; ids && i < f.n_add; i++)
            ids[n + i] = f.add[(size_t)TRACE_ADDITION * i];
        n += f.n_add;
    }
    return n;
}

static int number_boxes(trace *t)
{
    size_t n = gather_ids(t, NULL), unique = 0;
    t->ids = malloc((n + 1) * sizeof *t->ids);
    if (!t->ids)
        return FAIL("%s: no memory for its ids", t->path);
    gather_ids(t, t->ids);
    qsort(t->ids, n, sizeof *t->ids, by_value);
    for (size_t i = 0; i < n; i++)
        if (unique == 0 || t->ids[unique - 1] != t->ids[i])
            t->ids[unique++] = t->ids[i];
    t->boxes = (uint32_t)unique;
    return DONE;
}

/* The box of an id, or t->boxes if the file adds no such id. */
static uint32_t box_of(const trace *t, uint32_t id)
{
    if (id < t->boxes && t->ids[id] == id) /* most traces use all ids from 0 on */
        return id;
    const uint32_t *found = bsearch(&id, t->ids, t->boxes, sizeof *t->ids, by_value);
    return found ? (uint32_t)(found - t->ids) : t->boxes;
}

/* ------------------------------------------------------------------ records */

/* A record under check, to be named in a complaint. */
struct place {
    const trace *trace;
    const char *record;
    uint32_t frame, index, id;
};

static int refuse(const struct place *p, const char *why)
{
    return FAIL("%s: frame %u, %s %u (id %u): %s", p->trace->path, (unsigned)p->frame, p->record,
                (unsigned)p->index, (unsigned)p->id, why);
}

static int check_bounds(const struct place *p, const uint32_t *words)
{
    static const char *const nan_bound[6] = {"min x is NaN", "min y is NaN", "min z is NaN",
                                             "max x is NaN", "max y is NaN", "max z is NaN"};
    static const char *const inverted[3] = {"min x is above max x", "min y is above max y",
                                            "min z is above max z"};
    float bound[6];
    for (int i = 0; i < 6; i++) {
        bound[i] = float_of(words[i]);
        if (isnan(bound[i]))
            return refuse(p, nan_bound[i]);
    }
    for (int i = 0; i < 3; i++)
        if (bound[i] > bound[i + 3])
            return refuse(p, inverted[i]);
    if (p->trace->dims == 2 && (bound[2] != 0 || bound[5] != 0))
        return refuse(p, "z is not 0 in a 2D trace");
    return DONE;
}

/* Checks the id of a record, live telling which boxes are there and must be
 * (wanted 1) or not (0), and puts the box's number in its place. */
static int check_id(struct place *p, uint32_t *word, const unsigned char *live, int wanted)
{
    const trace *t = p->trace;
    p->id = *word;
    if (p->id >= t->max_ids)
        return refuse(p, "the id is not below max_ids");
    uint32_t box = box_of(t, p->id);
    if (wanted && (box == t->boxes || !live[box]))
        return refuse(p, "there is no such box");
    if (!wanted && live[box])
        return refuse(p, "the box is there already");
    *word = box;
    return DONE;
}

/* The words may be written to: they are the trace's own. */
static uint32_t *own_words(const trace *t, const uint32_t *at)
{
    return t->words + (at - t->words);
}

static int check_removals(const trace *t, uint32_t frame, const trace_frame *f, unsigned char *live)
{
    struct place p = {t, "removal", frame, 0, 0};
    uint32_t *at = own_words(t, f->remove);
    for (; p.index < f->n_remove; p.index++, at++) {
        if (check_id(&p, at, live, 1))
            return FAILED;
        live[*at] = 0;
    }
    return DONE;
}

static int check_additions(const trace *t, uint32_t frame, const trace_frame *f, unsigned char *live)
{
    struct place p = {t, "addition", frame, 0, 0};
    uint32_t *at = own_words(t, f->add);
    for (; p.index < f->n_add; p.index++, at += TRACE_ADDITION) {
        if (check_id(&p, at, live, 0) || check_bounds(&p, at + 2))
            return FAILED;
        live[*at] = 1;
    }
    return DONE;
}

static int check_updates(const trace *t, uint32_t frame, const trace_frame *f, const unsigned char *live)
{
    struct place p = {t, "update", frame, 0, 0};
    uint32_t *at = own_words(t, f->update);
    for (; p.index < f->n_update; p.index++, at += TRACE_UPDATE)
        if (check_id(&p, at, live, 1) || check_bounds(&p, at + 1))
            return FAILED;
    return DONE;
}

static int check_records(const trace *t)
{
    const uint32_t *at = trace_begin(t);
    unsigned char *live = calloc((size_t)t->boxes + 1, 1);
    int result = DONE;
    if (!live)
        return FAIL("%s: no memory to check it", t->path);
    for (uint32_t frame = 0; frame < t->frames && result == DONE; frame++) {
        trace_frame f;
        at = trace_next(at, &f);
        if (check_removals(t, frame, &f, live) || check_additions(t, frame, &f, live) ||
            check_updates(t, frame, &f, live))
            result = FAILED;
    }
    free(live);
    return result;
}

/* ---------------------------------------------------------------- interface */

int trace_load(trace *t, const char *path)
{
    memset(t, 0, sizeof *t);
    t->path = path;
    int result = read_file(t);
    if (result == DONE)
        result = read_head(t);
    if (result == DONE)
        result = check_structure(t);
    if (result == DONE)
        result = number_boxes(t);
    if (result == DONE)
        result = check_records(t);
    if (result)
        trace_free(t);
    return result;
}

void trace_free(trace *t)
{
    free(t->words);
    free(t->ids);
    memset(t, 0, sizeof *t);
}
