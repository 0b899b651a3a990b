/* Replays a trace into a world.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A frame is one batch of removals, one of additions, one of updates, a commit and
 * a look at its events. Only these calls are timed: a host has its arrays ready,
 * so the handles are looked up before each batch, outside the clock. */
#define _POSIX_C_SOURCE 200809L
#include "player.h"
#include "command.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

double clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static int failed(const player *p, const char *call, msap_status status)
{
    return FAIL("%s: frame %u: %s: %s", p->trace->path, (unsigned)p->next_frame, call,
                msap_status_text(status));
}

int player_begin(player *p, const trace *t, msap_config *config)
{
    memset(p, 0, sizeof *p);
    p->trace = t;
    p->at = trace_begin(t);
    p->handle_of = malloc(((size_t)t->boxes + 1) * sizeof *p->handle_of);
    p->handles = malloc((t->most_records + 1) * sizeof *p->handles);
    p->flags = malloc((t->most_records + 1) * sizeof *p->flags);
    config->dims = t->dims;
    msap_status status = p->handle_of && p->handles && p->flags ? msap_create(config, &p->world)
                                                                : MSAP_ERROR_MEMORY;
    if (status == MSAP_OK)
        return DONE;
    player_end(p);
    return FAIL("%s: msap_create: %s", t->path, msap_status_text(status));
}

void player_end(player *p)
{
    msap_destroy(p->world);
    free(p->handle_of);
    free(p->handles);
    free(p->flags);
}

/* Gathers the handles of the boxes that n records of so many words name first. */
static void gather_handles(player *p, const uint32_t *record, uint32_t n, size_t words)
{
    for (size_t i = 0; i < n; i++)
        p->handles[i] = p->handle_of[record[i * words]];
}

/* The bounds in records of so many words, the first of which has its min at `min`. */
static msap_boxes bounds_in(const uint32_t *min, size_t words)
{
    ptrdiff_t row = (ptrdiff_t)(words * sizeof *min), component = sizeof *min;
    msap_boxes boxes = {sizeof boxes, MSAP_FLOAT, min, min + 3, row, component, row, component};
    return boxes;
}

static int remove_boxes(player *p)
{
    const trace_frame *f = &p->frame;
    gather_handles(p, f->remove, f->n_remove, 1);
    double start = clock_ms();
    msap_status status = f->n_remove ? msap_remove_many(p->world, f->n_remove, p->handles) : MSAP_OK;
    p->ms += clock_ms() - start;
    return status ? failed(p, "msap_remove_many", status) : DONE;
}

static int add_boxes(player *p)
{
    const trace_frame *f = &p->frame;
    msap_boxes boxes = bounds_in(f->add + 2, TRACE_ADDITION);
    for (size_t i = 0; i < f->n_add; i++)
        p->flags[i] = f->add[i * TRACE_ADDITION + 1] & MSAP_STATIC;
    double start = clock_ms();
    msap_status status =
        f->n_add ? msap_add_many(p->world, f->n_add, &boxes, p->flags, NULL, p->handles) : MSAP_OK;
    p->ms += clock_ms() - start;
    if (status)
        return failed(p, "msap_add_many", status);
    for (size_t i = 0; i < f->n_add; i++)
        p->handle_of[f->add[i * TRACE_ADDITION]] = p->handles[i];
    return DONE;
}

static int update_and_commit(player *p)
{
    const trace_frame *f = &p->frame;
    const msap_pair *pairs;
    msap_boxes boxes = bounds_in(f->update + 1, TRACE_UPDATE);
    gather_handles(p, f->update, f->n_update, TRACE_UPDATE);
    double start = clock_ms();
    msap_status status =
        f->n_update ? msap_update_many(p->world, f->n_update, p->handles, &boxes) : MSAP_OK;
    if (status)
        return failed(p, "msap_update_many", status);
    status = msap_commit(p->world, NULL, NULL);
    if (status)
        return failed(p, "msap_commit", status);
    msap_deleted(p->world, &p->deleted, &p->n_deleted);
    msap_created(p->world, &p->created, &p->n_created);
    p->ms += clock_ms() - start;
    msap_pairs(p->world, &pairs, &p->n_active);
    return DONE;
}

int player_play(player *p)
{
    p->at = trace_next(p->at, &p->frame);
    p->ms = 0;
    if (remove_boxes(p) || add_boxes(p) || update_and_commit(p))
        return FAILED;
    p->boxes += p->frame.n_add;
    p->boxes -= p->frame.n_remove;
    p->next_frame++;
    return DONE;
}
