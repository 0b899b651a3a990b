/* Measures how the library's speed and memory depend on the size of a scene, on what
 * moves in it, and on threads; and writes scenes as traces.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     speed                   prints results, as bench.h says
 *     speed traces FOLDER     writes FOLDER/NAME.trace for each of some generated scenes,
 *                             which the programs of bench/accuracy can replay; prints
 *                             their names */
#include "../examples/thread_pool.h"
#include "library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Ways whose answers differ, as their scenes do. */
static outcome replay_alone(const void *what)
{
    outcome o = library_replay(what);
    o.check = 0;
    return o;
}

/* ------------------------------------------------------------------- growth */

/* All boxes move, as crowded and as fast whatever their number. */
static void measure_growth(const char *claim, double speed, motion motion)
{
    static const struct {
        uint32_t boxes, frames;
        unsigned rounds;
    } size[] = {{1000, 100, 9}, {10000, 40, 7}, {100000, 32, 3}, {1000000, 24, 3}};
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        char name[32];
        const recipe r = {"", size[i].boxes, size[i].frames, 2, 1, speed, motion, 0, 0};
        scene s = scene_make(&r);
        const setting world = {&s, NULL, 0};
        const way ways[] = {{"multisap", library_replay, &world}};
        snprintf(name, sizeof name, "%u", (unsigned)s.boxes);
        compare(claim, name, ways, 1, size[i].rounds, NULL);
        scene_free(&s);
    }
}

/* ------------------------------------------------------------- what moved */

enum { SIZES = 3, MOVERS = 2000 };

/* The same number of boxes moves among more and more others. */
static void measure_movers(void)
{
    static const char *const name[SIZES] = {"among 10,000", "among 100,000", "among 1,000,000"};
    scene scenes[SIZES];
    setting worlds[SIZES];
    way ways[SIZES];
    uint32_t others = 10000;
    for (int i = 0; i < SIZES; i++, others *= 10) {
        uint32_t boxes = others + MOVERS;
        const recipe r = {"", boxes, 40, 2, (double)MOVERS / boxes, 0.05, STRAIGHT, 0, 0};
        scenes[i] = scene_make(&r);
        worlds[i].scene = &scenes[i];
        worlds[i].config = NULL;
        worlds[i].has_statics = 0;
        ways[i].name = name[i];
        ways[i].run = replay_alone;
        ways[i].what = &worlds[i];
    }
    compare("movers", "2,000 movers", ways, SIZES, 5, NULL);
    for (int i = 0; i < SIZES; i++) scene_free(&scenes[i]);
}

static void demand(msap_status status)
{
    if (status) give_up("%s", msap_status_text(status));
}

/* Commits of a million boxes and pairs in which nothing or one box moved. */
static void measure_rest(void)
{
    enum { COMMITS = 1000 };
    static const recipe r = {"", 1000000, 0, 2, 0, 0, STRAIGHT, 0, 0};
    scene s = scene_make(&r);
    msap_boxes boxes = boxes_of(s.start);
    msap_handle *handles = get(s.boxes, sizeof *handles);
    msap_world *world;
    demand(msap_create(NULL, &world));
    demand(msap_add_many(world, s.boxes, &boxes, NULL, NULL, handles));
    double start = clock_ms();
    demand(msap_commit(world, NULL, NULL));
    print_count("bulk", "first commit of 1,000,000", "milliseconds", clock_ms() - start);
    start = clock_ms();
    for (int i = 0; i < COMMITS; i++) demand(msap_commit(world, NULL, NULL));
    print_count("rest", "nothing moved", "nanoseconds", 1e6 * (clock_ms() - start) / COMMITS);
    aabb *box = &s.start[s.boxes / 2];
    start = clock_ms();
    for (int i = 0; i < COMMITS; i++) {
        box->min[0] += 0.01f;
        box->max[0] += 0.01f;
        demand(msap_update(world, handles[s.boxes / 2], box->min, box->max));
        demand(msap_commit(world, NULL, NULL));
    }
    print_count("rest", "one box moved", "microseconds", 1e3 * (clock_ms() - start) / COMMITS);
    demand(msap_destroy(world));
    free(handles);
    scene_free(&s);
}

/* ------------------------------------------------------------------ threads */

/* A part of a frame's moves, and a sum over them: what threads can gain at most. */
struct part {
    const move *moves;
    size_t n;
    uint64_t sum;
};

struct plain {
    const scene *scene;
    thread_pool *pool;
    int threads;
};

/* Several passes, as a commit makes; an msap_task_fn. */
static void read_part(void *part)
{
    enum { PASSES = 20 };
    struct part *p = part;
    p->sum = 0;
    for (int pass = 0; pass < PASSES; pass++)
        for (size_t i = 0; i < p->n; i++) {
            uint32_t bits[6];
            memcpy(bits, &p->moves[i].to, sizeof bits);
            for (int k = 0; k < 6; k++) p->sum += bits[k] >> pass;
        }
}

static outcome plain_loop(const void *what)
{
    const struct plain *p = what;
    const scene *s = p->scene;
    outcome o = {0, 0};
    double start = wall_ms();
    for (uint32_t frame = 0; frame < s->frames; frame++) {
        size_t half = p->threads == 2 ? s->movers / 2 : 0;
        struct part first = {scene_frame(s, frame), half, 0}, rest = {first.moves + half, s->movers - half, 0};
        void *ticket = half ? thread_pool_enqueue(p->pool, read_part, &first) : NULL;
        read_part(&rest);
        if (ticket) thread_pool_finish(p->pool, ticket);
        o.check += first.sum + rest.sum;
    }
    o.ms = (wall_ms() - start) / s->frames;
    return o;
}

static void measure_threads(const recipe *r, thread_pool *pool)
{
    scene s = scene_make(r);
    msap_config one = config_of(MSAP_GRID_AUTO, MSAP_STRATEGY_AUTO, MSAP_MARGIN_AUTO), two;
    one.enqueue = thread_pool_enqueue; /* so that both are measured by the time of day */
    one.finish = thread_pool_finish;
    one.jobs_user = pool;
    two = one;
    two.workers = 2;
    const setting serial = {&s, &one, 0}, parallel = {&s, &two, 0};
    const struct plain by_1 = {&s, pool, 1}, by_2 = {&s, pool, 2};
    const way ways[] = {{"1 thread", library_replay, &serial}, {"2 threads", library_replay, &parallel}};
    const way loops[] = {{"1 thread", plain_loop, &by_1}, {"2 threads", plain_loop, &by_2}};
    compare("threads", s.name, ways, 2, 9, NULL);
    compare("threads-plain", s.name, loops, 2, 9, NULL);
    scene_free(&s);
}

/* ------------------------------------------------------------------- memory */

static void measure_memory(const char *name, double moving, double overlaps)
{
    const recipe r = {"", 1000000, 12, overlaps, moving, 0.005, STRAIGHT, 0, 0}; /* until all have had new skins */
    scene s = scene_make(&r);
    const setting world = {&s, NULL, 1};
    world_run run = library_run(&world);
    print_count("memory", name, "bytes a box, peak", (double)run.stats.bytes_peak / s.boxes);
    print_count("memory", name, "bytes a box, then", (double)run.stats.bytes / s.boxes);
    print_count("memory", name, "bytes a box, trimmed", (double)run.bytes_trimmed / s.boxes);
    print_count("memory", name, "pairs a box", (double)run.stats.pairs / s.boxes);
    print_count("memory", name, "candidate pairs a box", (double)run.stats.candidates / s.boxes);
    scene_free(&s);
}

static void measure_all(void)
{
    static const recipe crowds[] = {{"10,000 drift", 10000, 40, 2, 1, 0.05, STRAIGHT, 0, 0},
                                    {"100,000 drift", 100000, 16, 2, 1, 0.05, STRAIGHT, 0, 0},
                                    {"100,000 jump", 100000, 8, 2, 1, 0, JUMPING, 0, 0}};
    thread_pool *pool = thread_pool_create(1);
    if (!pool) give_up("no memory for threads");
    measure_growth("growth-drift", 0.05, STRAIGHT);
    measure_growth("growth-jump", 0, JUMPING);
    measure_movers();
    measure_rest();
    for (size_t i = 0; i < sizeof crowds / sizeof *crowds; i++) measure_threads(&crowds[i], pool);
    measure_memory("1,000,000 moving, sparse", 1, 0.1);
    measure_memory("1,000,000 moving", 1, 2);
    measure_memory("1,000,000 moving, crowded", 1, 8);
    measure_memory("999,000 static, 1,000 moving", 0.001, 2);
    thread_pool_destroy(pool);
}

/* ------------------------------------------------------------------- traces */

static void put_u32(FILE *file, uint32_t value)
{
    for (int i = 0; i < 4; i++) putc((int)(value >> 8 * i & 255), file);
}

static void put_box(FILE *file, const aabb *b)
{
    for (int k = 0; k < 6; k++) {
        uint32_t bits;
        memcpy(&bits, k < 3 ? &b->min[k] : &b->max[k - 3], sizeof bits);
        put_u32(file, bits);
    }
}

static void put_counts(FILE *file, uint32_t added, uint32_t moved)
{
    put_u32(file, 0);
    put_u32(file, added);
    put_u32(file, moved);
}

/* The format is described in docs/multisap.1. All boxes come in the first frame. */
static void put_trace(FILE *file, const scene *s)
{
    float side = (float)s->side;
    const aabb world = {{0, 0, 0}, {side, side, side}};
    fputs("SAPTRC01", file);
    put_u32(file, s->frames + 1);
    put_u32(file, s->boxes);
    put_u32(file, 3);
    put_box(file, &world);
    put_counts(file, s->boxes, 0);
    for (uint32_t i = 0; i < s->boxes; i++) {
        put_u32(file, i);
        put_u32(file, 0);
        put_box(file, &s->start[i]);
    }
    for (uint32_t frame = 0; frame < s->frames; frame++) {
        put_counts(file, 0, s->movers);
        for (uint32_t i = 0; i < s->movers; i++) {
            put_u32(file, scene_frame(s, frame)[i].box);
            put_box(file, &scene_frame(s, frame)[i].to);
        }
    }
}

static void write_trace(const char *folder, const recipe *r)
{
    char path[1024];
    if (snprintf(path, sizeof path, "%s/%s.trace", folder, r->name) >= (int)sizeof path)
        give_up("%s is too long", folder);
    FILE *file = fopen(path, "wb");
    if (!file) give_up("%s cannot be written", path);
    scene s = scene_make(r);
    put_trace(file, &s);
    if (ferror(file) | fclose(file)) give_up("%s cannot be written", path);
    puts(r->name);
    scene_free(&s);
}

static void write_traces(const char *folder)
{
    static const recipe recipes[] = {
        {"drift_1k", 1000, 120, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"drift_10k", 10000, 60, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"floor_10k", 10000, 60, 2, 1, 0.05, STRAIGHT, 1, 0},
        {"few_50k", 50000, 60, 2, 0.02, 0.05, STRAIGHT, 0, 0},
        {"crowd_2k", 2000, 60, 60, 1, 0.02, BROWNIAN, 0, 0},
        {"sizes_10k", 10000, 60, 1, 1, 0.05, STRAIGHT, 0, 10},
        {"wobble_10k", 10000, 60, 2, 1, 0.5, BROWNIAN, 0, 0},
        {"jump_5k", 5000, 30, 2, 1, 0, JUMPING, 0, 0},
    };
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; i++) write_trace(folder, &recipes[i]);
}

int main(int argc, char **argv)
{
    if (argc == 1) measure_all();
    else if (argc == 3 && strcmp(argv[1], "traces") == 0) write_traces(argv[2]);
    else give_up("usage: speed [traces FOLDER]");
    return 0;
}
