/* Scenes replayed by the library.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "library.h"

#include <stdlib.h>

static void demand(msap_status status)
{
    if (status) give_up("%s", msap_status_text(status));
}

/* The handles of the boxes that a frame moves. */
static void gather(msap_handle *to, const msap_handle *of, const move *moves, uint32_t n)
{
    for (uint32_t i = 0; i < n; i++) to[i] = of[moves[i].box];
}

static void play_frame(msap_world *world, const scene *s, uint32_t frame, const msap_handle *handles)
{
    msap_boxes to = boxes_of_moves(scene_frame(s, frame));
    if (s->movers > 0) demand(msap_update_many(world, s->movers, handles, &to));
    demand(msap_commit(world, NULL, NULL));
}

/* The first half of the frames warms up: skins have learnt, memory is there. */
static double play_frames(msap_world *world, const scene *s, const msap_handle *of, double (*now)(void))
{
    double ms = 0;
    uint32_t cold = s->frames / 2;
    msap_handle *handles = get(s->movers, sizeof *handles);
    for (uint32_t frame = 0; frame < s->frames; frame++) {
        gather(handles, of, scene_frame(s, frame), s->movers);
        double start = now();
        play_frame(world, s, frame, handles);
        ms += frame < cold ? 0 : now() - start;
    }
    free(handles);
    return s->frames ? ms / (s->frames - cold) : 0;
}

/* Flags for the boxes, to be freed. */
static uint32_t *flags_for(const setting *w)
{
    uint32_t *flags = get(w->scene->boxes, sizeof *flags);
    for (uint32_t i = 0; i < w->scene->boxes; i++) flags[i] = w->has_statics ? MSAP_STATIC : 0;
    for (uint32_t i = 0; i < w->scene->movers; i++) flags[w->scene->moves[i].box] = 0;
    return flags;
}

static msap_world_stats stats_of(const msap_world *world)
{
    msap_world_stats stats;
    stats.struct_size = sizeof stats;
    demand(msap_stats(world, &stats));
    return stats;
}

/* Boxes have the slots 0, 1, ... in the order of their additions. */
static uint64_t check_of(const msap_world *world)
{
    const msap_pair *pairs;
    size_t n;
    uint64_t sum = 0;
    demand(msap_pairs(world, &pairs, &n));
    for (size_t i = 0; i < n; i++) sum += pair_check((uint32_t)(pairs[i].a >> 32), (uint32_t)(pairs[i].b >> 32));
    return sum;
}

static size_t events_of(const msap_world *world)
{
    const msap_pair *pairs;
    size_t created, deleted;
    demand(msap_created(world, &pairs, &created));
    demand(msap_deleted(world, &pairs, &deleted));
    return created + deleted;
}

world_run library_run(const setting *w)
{
    const scene *s = w->scene;
    world_run run = {0};
    msap_world *world;
    msap_handle *handles = get(s->boxes, sizeof *handles);
    uint32_t *flags = flags_for(w);
    msap_boxes boxes = boxes_of(s->start);
    demand(msap_create(w->config, &world));
    double start = clock_ms();
    demand(msap_add_many(world, s->boxes, &boxes, flags, NULL, handles));
    demand(msap_commit(world, NULL, NULL));
    run.first_ms = clock_ms() - start;
    run.ms = play_frames(world, s, handles, w->config && w->config->enqueue ? wall_ms : clock_ms);
    run.check = check_of(world);
    run.stats = stats_of(world);
    run.events = events_of(world);
    demand(msap_trim(world));
    run.bytes_trimmed = stats_of(world).bytes;
    demand(msap_destroy(world));
    free(flags);
    free(handles);
    return run;
}

outcome library_replay(const void *what)
{
    world_run run = library_run(what);
    outcome o = {run.ms, run.check};
    return o;
}

msap_config config_of(msap_grid grid, msap_strategy strategy, float margin)
{
    msap_config c;
    demand(msap_config_init(&c, sizeof c));
    c.grid = grid;
    c.strategy = strategy;
    c.margin = margin;
    return c;
}
