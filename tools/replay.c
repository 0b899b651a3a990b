/* multisap replay: replays a trace, and prints answers, times, or a summary.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * With --answers a line a frame is printed: its number, the boxes that live, the
 * pairs, how many were created and deleted, and a hash of the pairs: the sum of
 * splitmix64(lower id << 32 | higher id) modulo 2^64. The hash is kept by adding
 * the created and taking away the deleted pairs, so it checks the events as well.
 * Pairs come with handles; a handle's upper half is the box's slot, and a slot is
 * not given to another box before the events that concern the old one are out. */
#include "command.h"
#include "player.h"
#include "setup.h"

#include <getopt.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] =
    "Usage: multisap replay [OPTION...] FILE.trace\n"
    "\n"
    "Replays a scene and prints a summary, or:\n"
    "  --answers       a line a frame: frame, boxes, pairs, created, deleted, hash\n"
    "  --json          one line of JSON with times\n"
    "\n"
    "  --rounds R      replay R times; each frame counts with its shortest time\n"
    "  --strategy S    auto, slide, merge or sweep (default auto)\n"
    "  --cells C       auto; 1: a single SAP; NxM: cells over the trace's two widest axes (default auto)\n"
    "  --margin X      auto, 0 or X: the skin around boxes in the grid's cells (default auto)\n"
    "  --threads N     1 to 64 threads to work with (default 1)\n"
    "  --help          this text\n";

typedef struct options {
    const char *path;
    int answers, json;
    unsigned long rounds;
    setup setup;
} options;

/* What the rounds came to. */
typedef struct outcome {
    double *ms; /* by frame: the shortest */
    uint64_t boxes, pairs, created, deleted, bytes;
} outcome;

/* ------------------------------------------------------------------ answers */

/* Trace ids by slot of the world, and the hash of the active pairs. */
typedef struct answers {
    uint32_t *id_of_slot;
    size_t room;
    uint64_t hash;
} answers;

static size_t slot_of(msap_handle handle) { return (size_t)(handle >> 32); }

static int note_slot(answers *a, size_t slot, uint32_t id)
{
    if (slot >= a->room) {
        size_t room = slot * 2 + 64;
        uint32_t *more = realloc(a->id_of_slot, room * sizeof *more);
        if (!more)
            return FAIL("no memory for the answers");
        a->id_of_slot = more;
        a->room = room;
    }
    a->id_of_slot[slot] = id;
    return DONE;
}

static uint64_t splitmix64(uint64_t x)
{
    x += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

static uint64_t hash_of(const answers *a, const msap_pair *pairs, size_t n)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < n; i++) {
        // a pair has boxes, which were added: NOLINTNEXTLINE(clang-analyzer-core.NullDereference)
        uint64_t x = a->id_of_slot[slot_of(pairs[i].a)], y = a->id_of_slot[slot_of(pairs[i].b)];
        sum += splitmix64(x < y ? x << 32 | y : y << 32 | x);
    }
    return sum;
}

static int print_answer(answers *a, const player *p)
{
    const trace_frame *f = &p->frame;
    for (size_t i = 0; i < f->n_add; i++) {
        uint32_t box = f->add[i * TRACE_ADDITION];
        if (note_slot(a, slot_of(p->handle_of[box]), p->trace->ids[box]))
            return FAILED;
    }
    a->hash += hash_of(a, p->created, p->n_created) - hash_of(a, p->deleted, p->n_deleted);
    printf("%" PRIu32 " %" PRIu64 " %zu %zu %zu %016" PRIx64 "\n", p->next_frame - 1, p->boxes, p->n_active,
           p->n_created, p->n_deleted, a->hash);
    return DONE;
}

/* ------------------------------------------------------------------- replay */

static uint64_t larger(uint64_t a, uint64_t b) { return a > b ? a : b; }

static uint64_t bytes_peak(const msap_world *world)
{
    msap_world_stats stats = {0};
    stats.struct_size = sizeof stats;
    msap_stats(world, &stats);
    return stats.bytes_peak;
}

static int replay_frame(player *p, outcome *r, unsigned long round, answers *a)
{
    if (player_play(p))
        return FAILED;
    double *ms = &r->ms[p->next_frame - 1];
    if (round == 0 || p->ms < *ms)
        *ms = p->ms;
    r->boxes = larger(r->boxes, p->boxes);
    r->pairs = larger(r->pairs, p->n_active);
    if (round > 0)
        return DONE;
    if (p->next_frame > 1) {
        r->created += p->n_created;
        r->deleted += p->n_deleted;
    }
    return a ? print_answer(a, p) : DONE;
}

static int replay_round(const trace *t, const options *o, msap_config *config, outcome *r,
                        unsigned long round)
{
    player p;
    answers a = {0};
    int result = player_begin(&p, t, config);
    if (result)
        return result;
    while (result == DONE && p.next_frame < t->frames)
        result = replay_frame(&p, r, round, o->answers ? &a : NULL);
    r->bytes = larger(r->bytes, bytes_peak(p.world));
    player_end(&p);
    free(a.id_of_slot);
    return result;
}

/* ---------------------------------------------------------------- the times */

/* Of the frames after the first; of none if there are none. */
typedef struct times {
    size_t n;
    double mean, median, p99, max;
} times;

static int by_time(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts ms[n]. Percentiles are by nearest rank; the median of an even number is the middle of the two. */
static times times_of(double *ms, size_t n)
{
    times t = {n, 0, 0, 0, 0};
    if (n == 0)
        return t;
    qsort(ms, n, sizeof *ms, by_time);
    for (size_t i = 0; i < n; i++)
        t.mean += ms[i] / (double)n;
    t.median = (ms[(n - 1) / 2] + ms[n / 2]) / 2;
    t.p99 = ms[(n * 99 + 99) / 100 - 1];
    t.max = ms[n - 1];
    return t;
}

static void print_json_text(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c < 0x20)
            printf("\\u%04x", c);
        else if (c == '"' || c == '\\')
            printf("\\%c", c);
        else
            putchar(c);
    }
    putchar('"');
}

/* A time, or null where there is no such frame. */
static void print_json_ms(const char *name, double ms, int known)
{
    if (known)
        printf(", \"%s\": %.6f", name, ms);
    else
        printf(", \"%s\": null", name);
}

static void print_json(const char *scene, const trace *t, const outcome *r, double first, const times *later)
{
    fputs("{\"trace\": ", stdout);
    print_json_text(scene);
    printf(", \"frames\": %" PRIu32 ", \"boxes\": %" PRIu64 ", \"pairs\": %" PRIu64, t->frames, r->boxes,
           r->pairs);
    print_json_ms("ms_first_frame", first, t->frames > 0);
    print_json_ms("ms_per_frame_mean", later->mean, later->n > 0);
    print_json_ms("ms_per_frame_median", later->median, later->n > 0);
    print_json_ms("ms_per_frame_p99", later->p99, later->n > 0);
    print_json_ms("ms_per_frame_max", later->max, later->n > 0);
    printf(", \"bytes\": %" PRIu64 "}\n", r->bytes);
}

static void print_summary(const char *scene, const trace *t, const outcome *r, double first,
                          const times *later)
{
    double n = later->n > 0 ? (double)later->n : 1;
    printf("%s: %" PRIu32 "D, %" PRIu32 " frames\n", scene, t->dims, t->frames);
    printf("boxes         %" PRIu64 " at most\n", r->boxes);
    printf("pairs         %" PRIu64 " at most\n", r->pairs);
    printf("memory        %.2f MB at most\n", (double)r->bytes / 1e6);
    if (t->frames > 0)
        printf("first frame   %.3f ms\n", first);
    if (later->n > 0) {
        printf("later frames  %.3f ms mean, %.3f median, %.3f p99, %.3f max\n", later->mean, later->median,
               later->p99, later->max);
        printf("their events  %.1f pairs created, %.1f deleted a frame\n", (double)r->created / n,
               (double)r->deleted / n);
    }
}

static int report(const trace *t, const options *o, const outcome *r)
{
    char *scene = scene_name(t->path);
    if (!scene)
        return FAIL("no memory");
    times later = times_of(r->ms + 1, t->frames > 1 ? t->frames - 1 : 0);
    if (o->json)
        print_json(scene, t, r, r->ms[0], &later);
    else if (!o->answers)
        print_summary(scene, t, r, r->ms[0], &later);
    free(scene);
    return finish_output();
}

/* ------------------------------------------------------------------ command */

static int parse_option(options *o, int option, const char *value)
{
    switch (option) {
    case 'a': o->answers = 1; return DONE;
    case 'j': o->json = 1; return DONE;
    case 'r': return parse_count("--rounds", value, 1, 1000000, &o->rounds);
    case 's': return setup_strategy(&o->setup, value);
    case 'c': return setup_cells(&o->setup, value);
    case 'm': return setup_margin(&o->setup, value);
    case 't': return setup_threads(&o->setup, value);
    default: return MISUSED; /* getopt_long has complained */
    }
}

static int parse_options(options *o, int argc, char **argv)
{
    static const struct option known[] = {{"answers", no_argument, NULL, 'a'},
                                          {"json", no_argument, NULL, 'j'},
                                          {"rounds", required_argument, NULL, 'r'},
                                          {"strategy", required_argument, NULL, 's'},
                                          {"cells", required_argument, NULL, 'c'},
                                          {"margin", required_argument, NULL, 'm'},
                                          {"threads", required_argument, NULL, 't'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
    int option, result = DONE;
    while (result == DONE && (option = getopt_long(argc, argv, "h", known, NULL)) != -1) {
        if (option == 'h') {
            fputs(usage, stdout);
            exit(finish_output());
        }
        result = parse_option(o, option, optarg);
    }
    if (result == DONE && optind != argc - 1)
        result = MISUSE("replay: one trace is needed (--help tells more)");
    o->path = argv[optind];
    return result;
}

int replay_main(int argc, char **argv)
{
    options o = {0};
    outcome r = {0};
    msap_config config;
    trace t;
    o.rounds = 1;
    setup_init(&o.setup);
    int result = parse_options(&o, argc, argv);
    if (result == DONE)
        result = trace_load(&t, o.path);
    if (result)
        return result;
    result = setup_config(&o.setup, &t, &config);
    r.ms = calloc((size_t)t.frames + 1, sizeof *r.ms);
    if (result == DONE && !r.ms)
        result = FAIL("%s: no memory for its times", o.path);
    for (unsigned long round = 0; round < o.rounds && result == DONE; round++)
        result = replay_round(&t, &o, &config, &r, round);
    if (result == DONE)
        result = report(&t, &o, &r);
    free(r.ms);
    trace_free(&t);
    setup_end(&o.setup);
    return result;
}
