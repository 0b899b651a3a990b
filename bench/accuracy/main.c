/* Runs one mode over one scene, and measures or judges it.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     PROGRAM --list                       the modes that this program has
 *     PROGRAM MODE SCENE [SECONDS]         the time of each frame
 *     PROGRAM --check MODE SCENE [SECONDS] errors and memory, frame by frame
 *
 * SCENE is as in scene.h. Prints one line of JSON. A run ends early when its frames have
 * taken so many seconds; the line then has fewer frames than the scene. "own" errors
 * are those against the boxes that the mode was given, "scene" errors those against
 * the scene's doubles. Memory is what the heap holds beyond what it held before. */
#define _POSIX_C_SOURCE 200809L
#include "oracle.h"
#include "scene.h"

#include <malloc.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

void give_up(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("accuracy: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

void *get(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory)
        give_up("no memory");
    return memory;
}

static double clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static double step_ms(const mode *m, void *state, const frame *f)
{
    double start = clock_ms();
    m->step(state, f);
    return clock_ms() - start;
}

static void measure(const mode *m, const scene *s, double limit_ms)
{
    void *state = m->open(s);
    double total = 0;
    printf("\"ms\": [");
    for (uint32_t f = 0; f < s->n_frames && total < limit_ms; f++) {
        double ms = step_ms(m, state, &s->frames[f]);
        total += ms;
        printf("%s%.5f", f ? ", " : "", ms);
    }
    printf("]");
}

/* ----------------------------------------------------------------- judging */

/* The pairs of a mode, and what the array that they are put in takes of the heap. */
struct found {
    id_pair *at;
    size_t n, room;
};

static void ask(struct found *found, const mode *m, void *state)
{
    while ((found->n = m->pairs(state, found->at, found->room)) > found->room) {
        free(found->at);
        found->room = found->n * 2;
        found->at = get(found->room, sizeof *found->at);
    }
}

static size_t heap(void)
{
    struct mallinfo2 now = mallinfo2();
    return now.uordblks + now.hblkhd;
}

static void add(verdict *sum, verdict v)
{
    sum->true_pairs += v.true_pairs;
    sum->false_pairs += v.false_pairs;
    sum->missed += v.missed;
}

static void print_verdict(const char *name, verdict v)
{
    printf(", \"%s\": {\"true\": %llu, \"false\": %llu, \"missed\": %llu}", name, (unsigned long long)v.true_pairs,
           (unsigned long long)v.false_pairs, (unsigned long long)v.missed);
}

static void check(const mode *m, const scene *s, double limit_ms)
{
    oracle *o = oracle_open(s);
    struct found found = {NULL, 0, 0};
    verdict own = {0, 0, 0}, of_scene = {0, 0, 0};
    size_t others = heap(), most = 0;
    void *state = m->open(s);
    double total = 0;
    uint32_t f;
    for (f = 0; f < s->n_frames && total < limit_ms; f++) {
        total += step_ms(m, state, &s->frames[f]);
        size_t held = heap() - others, before;
        most = held > most ? held : most;
        before = heap();
        oracle_step(o, &s->frames[f]);
        ask(&found, m, state);
        add(&of_scene, oracle_judge(o, 1, found.at, found.n));
        ask(&found, m, state);
        add(&own, oracle_judge(o, m->takes_doubles, found.at, found.n));
        others += heap() - before;
    }
    printf("\"frames\": %u, \"boxes\": %u, \"dims\": %u, \"bytes\": %zu", f, s->ids, s->dims, most);
    print_verdict("own", own);
    print_verdict("scene", of_scene);
}

static int list(void)
{
    for (const mode *m = modes; m->name; m++) puts(m->name);
    return 0;
}

int main(int argc, char **argv)
{
    int is_check = argc > 1 && strcmp(argv[1], "--check") == 0;
    const mode *m = modes;
    if (argc == 2 && strcmp(argv[1], "--list") == 0)
        return list();
    argv += is_check;
    argc -= is_check;
    if (argc < 3 || argc > 4)
        give_up("usage: [--check] MODE SCENE [SECONDS]");
    while (m->name && strcmp(m->name, argv[1]) != 0) m++;
    if (!m->name)
        give_up("there is no mode %s", argv[1]);
    scene s = scene_of(argv[2]);
    printf("{");
    (is_check ? check : measure)(m, &s, argc == 4 ? atof(argv[3]) * 1e3 : 1e9);
    printf("}\n");
    return 0;
}
