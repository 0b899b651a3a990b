/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Random scenes against brute force: additions, updates, removals and reuse, over
 * all set-ups (see ../unit/setups.h), dimensions and kinds of numbers; after every
 * commit events, pairs, bounds, user data and statistics are compared and the world is
 * validated. Needs nothing but the C library and POSIX threads, so that it runs under
 * any sanitizer or emulator.
 *
 *     differential [SEED [ROUNDS [N]]]
 *
 * ROUNDS scenes (default 5) are played in every set-up, the first with SEED (default
 * 1), the next with SEED + 1 and so on, of up to N boxes (default 60) in FRAMES
 * frames; and in every set-up one of 20 N boxes in a few frames, which are enough for
 * workers to get tasks. A scene that fails is named on stderr with its seed. The last
 * line is "N passed, N failed"; the exit status is 1 if any failed.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "../unit/common.h"
#include "../unit/setups.h"

#define FRAMES 30
#define LARGE_FRAMES 5

typedef struct scenario {
    uint64_t seed;
    scene_kind scene;
    uint32_t dims, boxes;
    int frames;
    uint32_t statics; /* of sixteen boxes */
} scenario;

/* A quarter, three quarters, all but a few: worlds choose other ways for them. */
static const uint32_t statics[3] = {4, 12, 15};

static const char *play(const msap_config *config, const scenario *t)
{
    session s;
    const char *wrong = session_open(&s, config, t->seed, t->scene), *wrong_at_close;
    int frame;
    s.statics = t->statics;
    for (frame = 0; frame < t->frames && !wrong; frame++) {
        wrong = session_step(&s, t->boxes);
        if (!wrong && frame % 7 == 6)
            wrong = session_trim(&s);
    }
    wrong_at_close = session_close(&s);
    return wrong ? wrong : wrong_at_close;
}

/* One scene in one set-up; returns 1 if it failed. */
static unsigned long play_and_tell(int row, const scenario *t)
{
    msap_config config = setup_config(t->dims, row);
    const char *wrong = play(&config, t);
    if (wrong)
        fprintf(stderr, "seed %" PRIu64 ", n %u, scene %d, %uD, %s: %s\n", t->seed, t->boxes, (int)t->scene, t->dims,
                setups[row].name, wrong);
    return wrong != NULL;
}

/* One seed in every set-up; returns how many failed of how many. */
static unsigned long play_all(uint64_t seed, uint32_t boxes, unsigned long *played)
{
    unsigned long failed = 0;
    uint32_t dims;
    int row, scene;
    for (row = 0; row < SETUPS; row++)
        for (dims = 2; dims <= 3; dims++)
            for (scene = 0; scene < SCENE_COUNT; scene++, ++*played) {
                scenario t = {seed, (scene_kind)scene, dims, boxes, FRAMES, statics[(seed + (uint64_t)row + dims) % 3]};
                failed += play_and_tell(row, &t);
            }
    return failed;
}

/* One seed of many boxes in every set-up, each with another kind of numbers. */
static unsigned long play_large(uint64_t seed, uint32_t boxes, unsigned long *played)
{
    unsigned long failed = 0;
    int row;
    for (row = 0; row < SETUPS; row++, ++*played) {
        scenario t = {seed,
                      (scene_kind)((seed + (uint64_t)row) % SCENE_COUNT),
                      row % 3 ? 3 : 2,
                      boxes,
                      LARGE_FRAMES,
                      statics[seed % 3]};
        failed += play_and_tell(row, &t);
    }
    return failed;
}

/* The argument as a number from 1 to `most`; ends the program if it is none. */
static uint64_t number(const char *argument, uint64_t most)
{
    char *end;
    unsigned long long value = strtoull(argument, &end, 10);
    if (*argument < '0' || *argument > '9' || *end || value < 1 || value > most) {
        fprintf(stderr, "differential: '%s' is not a number from 1 to %" PRIu64 "\n", argument, most);
        exit(2);
    }
    return value;
}

int main(int argc, char **argv)
{
    uint64_t seed = argc > 1 ? number(argv[1], UINT64_MAX / 2) : 1;
    uint64_t rounds = argc > 2 ? number(argv[2], UINT32_MAX) : 5;
    uint32_t boxes = argc > 3 ? (uint32_t)number(argv[3], 100000) : 60;
    unsigned long failed = 0, played = 0;
    if (argc > 4) {
        fprintf(stderr, "usage: differential [SEED [ROUNDS [N]]]\n");
        return 2;
    }
    for (; rounds; rounds--, seed++)
        failed += play_all(seed, boxes, &played) + play_large(seed, 20 * boxes, &played);
    printf("%lu passed, %lu failed\n", played - failed, failed);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
