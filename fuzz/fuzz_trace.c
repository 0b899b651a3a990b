/* Harness: the bytes are a scene trace, as the command reads it. What is accepted is
 * replayed by the command's player and compared with brute force.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#define _GNU_SOURCE /* memfd_create: a file without a disk */
#include "../tests/unit/common.h"
#include "../tools/command.h"
#include "../tools/player.h"
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* What the command would print is not looked at. */
void complain(const char *format, ...) { (void)format; }

/* The file of the input, the same one for all; returns its path. */
static const char *write_file(const uint8_t *data, size_t size)
{
    static char path[32];
    static int file = -1;
    if (file < 0)
        file = memfd_create("trace", 0);
    if (file < 0 || ftruncate(file, 0) != 0 || pwrite(file, data, size, 0) != (ssize_t)size)
        fuzz_check("there is no place for a file");
    snprintf(path, sizeof path, "/dev/fd/%d", file);
    return path;
}

static box bounds_of(const uint32_t *words)
{
    box b;
    int c;
    for (c = 0; c < 3; c++) {
        b.min[c] = float_of(words[c]);
        b.max[c] = float_of(words[3 + c]);
    }
    return b;
}

static void follow(reference *r, const trace_frame *f, msap_handle *handle_of)
{
    uint32_t i;
    for (i = 0; i < f->n_remove; i++)
        reference_remove(r, handle_of[f->remove[i]]);
    for (i = 0; i < f->n_add; i++) {
        const uint32_t *record = f->add + (size_t)i * TRACE_ADDITION;
        box b = bounds_of(record + 2);
        handle_of[record[0]] = reference_add(r, &b, record[1] & MSAP_STATIC, NULL);
    }
    for (i = 0; i < f->n_update; i++) {
        const uint32_t *record = f->update + (size_t)i * TRACE_UPDATE;
        box b = bounds_of(record + 1);
        reference_update(r, handle_of[record[0]], &b);
    }
    reference_commit(r);
}

static void compare(const player *p, const reference *r)
{
    size_t i;
    if (p->n_deleted + p->n_created != r->event_count || p->n_active != r->pair_count || p->boxes != r->live)
        fuzz_check("a frame has another number of boxes, pairs or events");
    for (i = 0; i < r->event_count; i++) {
        const msap_pair *pair = i < p->n_deleted ? &p->deleted[i] : &p->created[i - p->n_deleted];
        if (r->events[i].created != (i >= p->n_deleted) || r->events[i].a != pair->a || r->events[i].b != pair->b)
            fuzz_check("a frame has another event");
    }
}

static void replay(const trace *t)
{
    msap_handle *handle_of = calloc((size_t)t->boxes + 1, sizeof *handle_of);
    msap_config config;
    reference r;
    player p;
    uint32_t frame;
    msap_config_init(&config, sizeof config);
    if (!handle_of || player_begin(&p, t, &config))
        fuzz_check("a trace could not be begun");
    reference_open(&r, t->dims);
    for (frame = 0; frame < t->frames; frame++) {
        if (player_play(&p))
            fuzz_check("a frame of a legal trace could not be played");
        follow(&r, &p.frame, handle_of);
        compare(&p, &r);
        if (msap_validate(p.world, NULL) != MSAP_OK)
            fuzz_check("the world is broken");
    }
    player_end(&p);
    reference_close(&r);
    free(handle_of);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    trace t;
    if (trace_load(&t, write_file(data, size)) == DONE) {
        replay(&t);
        trace_free(&t);
    }
    return 0;
}
