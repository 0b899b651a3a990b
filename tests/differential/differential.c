/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Random scenes against brute force: additions, updates, removals and reuse, over
 * all strategies, dimensions, filters and kinds of numbers; after every commit events,
 * pairs, bounds, user data and statistics are compared and the world is validated.
 * Needs nothing but the C library, so that it runs under any sanitizer or emulator.
 *
 *     differential [SEED [ROUNDS [N]]]
 *
 * ROUNDS scenes (default 20) are played in every set-up, the first with SEED (default
 * 1), the next with SEED + 1 and so on, of up to N boxes (default 60) in FRAMES
 * frames. A scene that fails is named on stderr with its seed. The last line is
 * "N passed, N failed"; the exit status is 1 if any failed.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "../unit/common.h"

#define FRAMES 30

static const char *play(const msap_config *config, uint64_t seed, scene_kind scene, uint32_t boxes)
{
    session s;
    const char *wrong = session_open(&s, config, seed, scene), *wrong_at_close;
    int frame;
    for (frame = 0; frame < FRAMES && !wrong; frame++) {
        wrong = session_step(&s, boxes);
        if (!wrong && frame % 7 == 6)
            wrong = session_trim(&s);
    }
    wrong_at_close = session_close(&s);
    return wrong ? wrong : wrong_at_close;
}

/* One scene in one set-up; returns 1 if it failed. */
static int play_and_tell(uint32_t dims, uint32_t strategy, uint32_t filters, uint64_t seed, scene_kind scene,
                         uint32_t boxes)
{
    msap_config config;
    const char *wrong;
    msap_config_init(&config, sizeof config);
    config.dims = dims;
    config.strategy = strategy;
    config.filters = filters;
    wrong = play(&config, seed, scene, boxes);
    if (wrong)
        fprintf(stderr, "seed %" PRIu64 ", n %u, scene %d, %uD, strategy %u, filters %u: %s\n", seed, boxes,
                (int)scene, dims, strategy, filters, wrong);
    return wrong != NULL;
}

/* One seed in every set-up; returns how many failed of how many. */
static unsigned long play_all(uint64_t seed, uint32_t boxes, unsigned long *played)
{
    unsigned long failed = 0;
    uint32_t dims, strategy, filters;
    int scene;
    for (dims = 2; dims <= 3; dims++)
        for (strategy = MSAP_STRATEGY_AUTO; strategy <= MSAP_STRATEGY_SWEEP; strategy++)
            for (filters = 0; filters <= 1; filters++)
                for (scene = 0; scene < SCENE_COUNT; scene++, ++*played)
                    failed += (unsigned long)play_and_tell(dims, strategy, filters, seed, (scene_kind)scene, boxes);
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
    uint64_t rounds = argc > 2 ? number(argv[2], UINT32_MAX) : 20;
    uint32_t boxes = argc > 3 ? (uint32_t)number(argv[3], 100000) : 60;
    unsigned long failed = 0, played = 0;
    if (argc > 4) {
        fprintf(stderr, "usage: differential [SEED [ROUNDS [N]]]\n");
        return 2;
    }
    for (; rounds; rounds--, seed++)
        failed += play_all(seed, boxes, &played);
    printf("%lu passed, %lu failed\n", played - failed, failed);
    return failed ? EXIT_FAILURE : EXIT_SUCCESS;
}
