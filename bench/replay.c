/* The library replaying a scene in several set-ups, and the floor below all of them:
 * modes for bench/accuracy/main.c, so that a scene is replayed in the same way as by
 * the peers of that folder.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     multisap                the defaults
 *     multisap, 2 threads     with one more thread
 *     multisap, single SAP    no grid
 *     floor                   plain loops that read every bound that is given once, and
 *                             write every event once: nothing that is told of the moves
 *                             and tells the events can take less */
#include "../examples/thread_pool.h"
#include "accuracy/mode.h"

#include <multisap.h>
#include <stdlib.h>
#include <string.h>

struct replay {
    msap_world *world;
    msap_handle *handle; /* [ids] */
    uint32_t *id_of;     /* [slots] */
    msap_handle *batch;  /* [ids] handles of a call, */
    uint32_t *flags;     /* and their flags */
};

static void must(msap_status status)
{
    if (status) give_up("%s", msap_status_text(status));
}

/* ------------------------------------------------------------------ library */

static msap_boxes view(const change *c)
{
    msap_boxes b = {sizeof b, MSAP_FLOAT, c->min, c->max, sizeof *c, sizeof(float), sizeof *c, sizeof(float)};
    return b;
}

static void add_boxes(struct replay *r, const change *c, size_t n)
{
    msap_boxes boxes = view(c);
    for (size_t i = 0; i < n; i++) r->flags[i] = c[i].is_static ? MSAP_STATIC : 0;
    must(msap_add_many(r->world, n, &boxes, r->flags, NULL, r->batch));
    for (size_t i = 0; i < n; i++) {
        r->handle[c[i].id] = r->batch[i];
        r->id_of[r->batch[i] >> 32] = c[i].id;
    }
}

static void update_boxes(struct replay *r, const change *c, size_t n)
{
    msap_boxes boxes = view(c);
    for (size_t i = 0; i < n; i++) r->batch[i] = r->handle[c[i].id];
    must(msap_update_many(r->world, n, r->batch, &boxes));
}

static void step(void *replay, const frame *f)
{
    struct replay *r = replay;
    for (size_t i = 0; i < f->n_removed; i++) r->batch[i] = r->handle[f->removed[i]];
    must(msap_remove_many(r->world, f->n_removed, r->batch));
    if (f->n_added > 0) add_boxes(r, f->added, f->n_added);
    if (f->n_moved > 0) update_boxes(r, f->moved, f->n_moved);
    must(msap_commit(r->world, NULL, NULL));
}

/* Slots are given out anew only after the commit, so an id is looked up by slot. */
static size_t pairs(void *replay, id_pair *out, size_t room)
{
    const struct replay *r = replay;
    const msap_pair *p;
    size_t n;
    must(msap_pairs(r->world, &p, &n));
    for (size_t i = 0; i < n && n <= room; i++) {
        out[i].a = r->id_of[p[i].a >> 32];
        out[i].b = r->id_of[p[i].b >> 32];
    }
    return n;
}

static struct replay *open_with(const scene *s, msap_config *config)
{
    struct replay *r = get(1, sizeof *r);
    config->dims = s->dims;
    must(msap_create(config, &r->world));
    r->handle = get(s->ids, sizeof *r->handle);
    r->id_of = get(2 * (size_t)s->ids, sizeof *r->id_of);
    r->batch = get(s->ids, sizeof *r->batch);
    r->flags = get(s->ids, sizeof *r->flags);
    return r;
}

static void *open_default(const scene *s)
{
    msap_config config;
    must(msap_config_init(&config, sizeof config));
    return open_with(s, &config);
}

static void *open_threads(const scene *s)
{
    msap_config config;
    must(msap_config_init(&config, sizeof config));
    config.workers = 2;
    config.enqueue = thread_pool_enqueue;
    config.finish = thread_pool_finish;
    config.jobs_user = thread_pool_create(1);
    return open_with(s, &config);
}

static void *open_single(const scene *s)
{
    msap_config config;
    must(msap_config_init(&config, sizeof config));
    config.grid = MSAP_GRID_NONE;
    return open_with(s, &config);
}

/* -------------------------------------------------------------------- floor */

struct ground {
    const scene *scene;
    size_t *events; /* [frames] */
    msap_pair *out;
    uint32_t sum;
};

/* The library tells beforehand how many events there are. */
static void *open_floor(const scene *s)
{
    struct ground *g = get(1, sizeof *g);
    struct replay *r = open_default(s);
    size_t most = 0;
    g->scene = s;
    g->events = get(s->n_frames, sizeof *g->events);
    for (uint32_t i = 0; i < s->n_frames; i++) {
        const msap_pair *p;
        size_t created, deleted;
        step(r, &s->frames[i]);
        must(msap_created(r->world, &p, &created));
        must(msap_deleted(r->world, &p, &deleted));
        g->events[i] = created + deleted;
        most = g->events[i] > most ? g->events[i] : most;
    }
    msap_destroy(r->world);
    g->out = get(most, sizeof *g->out);
    return g;
}

static uint32_t read_bounds(const change *c, size_t n)
{
    uint32_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        uint32_t bits[6];
        memcpy(bits, c[i].min, 3 * sizeof *bits);
        memcpy(bits + 3, c[i].max, 3 * sizeof *bits);
        for (int k = 0; k < 6; k++) sum += bits[k];
        sum += c[i].id;
    }
    return sum;
}

static void step_floor(void *ground, const frame *f)
{
    struct ground *g = ground;
    g->sum += read_bounds(f->added, f->n_added) + read_bounds(f->moved, f->n_moved);
    for (size_t i = 0; i < f->n_removed; i++) g->sum += f->removed[i];
    for (size_t i = 0; i < g->events[f - g->scene->frames]; i++) {
        msap_pair p = {g->sum, i, NULL};
        g->out[i] = p;
    }
}

static size_t no_pairs(void *ground, id_pair *out, size_t room)
{
    (void)ground;
    (void)out;
    (void)room;
    return 0;
}

const mode modes[] = {
    {"multisap", 0, open_default, step, pairs},
    {"multisap, 2 threads", 0, open_threads, step, pairs},
    {"multisap, single SAP", 0, open_single, step, pairs},
    {"floor", 0, open_floor, step_floor, no_pairs},
    {NULL, 0, NULL, NULL, NULL},
};
