/* Claims about the single SAP and the Multi-SAP as the boxes become more (II.1, II.2):
 * what a frame costs when all move, when a thousand move among more and more others,
 * and when one box comes and goes.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Crowding and speed stay the same while the scene grows. A way is left out from the
 * size on at which a frame of it would take too long, as its last one foretells. */
#include "library.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { TYPES = 4 };

/* A kind of world, and what its last size took. */
struct type {
    const char *name;
    msap_config config;
    double last_ms;
};

struct growth {
    int types; /* the first so many are measured */
    const char *claim;
    recipe recipe; /* but for boxes and frames */
    double movers; /* 0: all */
    double too_long_ms;
};

static outcome first_commit(const void *what)
{
    world_run run = library_run(what);
    outcome o = {run.first_ms, run.check};
    return o;
}

/* One box comes, one goes, in every frame of ten. */
static outcome come_and_go(const void *what)
{
    const setting *w = what;
    outcome o = {0, 0};
    msap_world *world;
    msap_handle *handles = get(w->scene->boxes, sizeof *handles), one;
    msap_boxes boxes = boxes_of(w->scene->start);
    const aabb *again = &w->scene->start[w->scene->boxes / 2];
    if (msap_create(w->config, &world) || msap_add_many(world, w->scene->boxes, &boxes, NULL, NULL, handles) ||
        msap_commit(world, NULL, NULL))
        give_up("a world of %u boxes could not be made", (unsigned)w->scene->boxes);
    double start = clock_ms();
    for (int i = 0; i < 10; i++)
        if (msap_add(world, again->min, again->max, 0, NULL, &one) || msap_commit(world, NULL, NULL) ||
            msap_remove(world, one) || msap_commit(world, NULL, NULL))
            give_up("a box could not come and go");
    o.ms = (clock_ms() - start) / 10;
    msap_destroy(world);
    free(handles);
    return o;
}

/* Compares those types that a scene so much larger than the last does not rule out. */
static void compare_types(const struct growth *g, const scene *s, way_fn run, struct type *types, double larger,
                          unsigned rounds)
{
    way ways[TYPES];
    setting settings[TYPES];
    struct type *of[TYPES];
    double median[TYPES];
    size_t n = 0;
    char name[64];
    snprintf(name, sizeof name, "%u", (unsigned)s->boxes);
    for (int i = 0; i < g->types; i++) {
        if (types[i].last_ms * larger * sqrt(larger) > g->too_long_ms) continue;
        settings[n].scene = s;
        settings[n].config = &types[i].config;
        settings[n].has_statics = 0;
        ways[n].name = types[i].name;
        ways[n].run = run;
        ways[n].what = &settings[n];
        of[n++] = &types[i];
    }
    compare(g->claim, name, ways, n, rounds, median);
    for (size_t i = 0; i < n; i++) of[i]->last_ms = median[i];
}

static void make_types(struct type types[TYPES])
{
    const struct type made[TYPES] = {
        {"Multi-SAP", config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO), 0},
        {"single SAP", config_of(MSAP_GRID_NONE, MSAP_STRATEGY_AUTO, 0), 0},
        {"single SAP, sliding", config_of(MSAP_GRID_NONE, MSAP_STRATEGY_SLIDE, 0), 0},
        {"Multi-SAP, no margin", config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, 0), 0}};
    for (int i = 0; i < TYPES; i++) types[i] = made[i];
}

static void grow(const struct growth *g, way_fn run)
{
    static const struct {
        uint32_t boxes, frames;
        unsigned rounds;
    } size[] = {{1000, 40, 5}, {10000, 20, 5}, {100000, 8, 3}, {1000000, 8, 2}};
    struct type types[TYPES];
    make_types(types);
    for (int i = 0; i < 4; i++) {
        recipe r = g->recipe;
        r.boxes = size[i].boxes;
        r.frames = size[i].frames;
        r.moving = g->movers > 0 ? g->movers / r.boxes : 1;
        scene s = scene_make(&r);
        compare_types(g, &s, run, types, i > 0 ? 10 : 1, size[i].rounds);
        scene_free(&s);
    }
}

/* What boxes take in memory of which this share moves, the rest being static. */
static void count_bytes(const char *name, uint32_t boxes, double moving, msap_grid grid)
{
    const recipe r = {"", boxes, 4, 2, moving, 0.05, STRAIGHT, 0, 0};
    const msap_config config = config_of(grid, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO);
    scene s = scene_make(&r);
    const setting world = {&s, &config, 1};
    world_run run = library_run(&world);
    print_count("memory", name, "bytes a box, peak", (double)run.stats.bytes_peak / boxes);
    print_count("memory", name, "bytes a box, trimmed", (double)run.bytes_trimmed / boxes);
    print_count("memory", name, "pairs a box", (double)run.stats.pairs / boxes);
    if (grid != MSAP_GRID_NONE) {
        print_count("memory", name, "candidate pairs a box", (double)run.stats.candidates / boxes);
        print_count("memory", name, "cells a box", (double)run.stats.incidences / boxes);
    }
    scene_free(&s);
}

void claim_scaling(void)
{
    static const recipe in_cube = {"", 0, 0, 2, 0, 0.05, STRAIGHT, 0, 0},
                        on_floor = {"", 0, 0, 2, 0, 0.05, STRAIGHT, 1, 0};
    const struct growth cube = {4, "scaling-cube", in_cube, 0, 1000};
    const struct growth ground = {4, "scaling-floor", on_floor, 0, 1000};
    const struct growth few = {4, "scaling-movers", on_floor, 1000, 1000};
    const struct growth load = {2, "scaling-load", on_floor, 1, 10000};
    const struct growth single = {2, "scaling-insertion", on_floor, 1, 1000};
    grow(&cube, library_replay);
    grow(&ground, library_replay);
    grow(&few, library_replay);
    grow(&load, first_commit);
    grow(&single, come_and_go);
    count_bytes("single SAP, 100,000 moving", 100000, 1, MSAP_GRID_NONE);
    count_bytes("Multi-SAP, 100,000 moving", 100000, 1, MSAP_GRID_AUTO);
    count_bytes("Multi-SAP, 1,000,000 moving", 1000000, 1, MSAP_GRID_AUTO);
    count_bytes("Multi-SAP, 999,000 static, 1,000 moving", 1000000, 0.001, MSAP_GRID_AUTO);
}
