/* Claims about the sorted axes (I.2, I.3, appendices A and B): arrays against linked
 * lists, comparisons, sentinels, the index-only overlap test, the test before a
 * removal.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "paper_sap.h"

/* Moves all movers of all frames, and counts what crossed. */
RESOLVED outcome replay(const scene *s, how h, paper_sap **sap)
{
    outcome o;
    *sap = paper_sap_make(h, s->start, s->boxes, s->boxes);
    double start = clock_ms();
    for (size_t i = 0; i < (size_t)s->frames * s->movers; i++) move_box(*sap, h, s->moves[i].box, &s->moves[i].to);
    o.ms = (clock_ms() - start) / s->frames;
    o.check = pair_set_check(&(*sap)->pairs);
    return o;
}

RESOLVED outcome replay_once(const scene *s, how h)
{
    paper_sap *sap;
    outcome o = replay(s, h, &sap);
    paper_sap_free(sap);
    return o;
}

/* way_fn NAME, which does it as the initializer of a `how` says. */
#define WAY(name, ...)                 \
    static outcome name(const void *s) \
    {                                  \
        const how h = {__VA_ARGS__};   \
        return replay_once(s, h);      \
    }
WAY(arrays, ARRAYS, KEYS, BY_INDEX, 0, 0)
WAY(arrays_without_ranks, ARRAYS, KEYS, BY_BOX, 0, 0)
WAY(lists, LISTS, KEYS, BY_BOX, 0, 0)
WAY(integers, ARRAYS, INTEGERS, BY_INDEX, 0, 0)
WAY(floats, ARRAYS, FLOATS, BY_INDEX, 0, 0)
WAY(bounds_tests, ARRAYS, KEYS, BY_INDEX, 1, 0)
WAY(by_end_point, ARRAYS, KEYS, BY_END_POINT, 0, 0)
WAY(removes_untested, ARRAYS, KEYS, BY_INDEX, 0, 1)

static void count_removals(const scene *s)
{
    const how h = {ARRAYS, KEYS, BY_INDEX, 0, 0};
    paper_sap *sap;
    replay(s, h, &sap);
    print_count("removal-test", s->name, "apparent removals a frame", (double)sap->seeming / s->frames);
    print_count("removal-test", s->name, "real removals a frame", (double)sap->removed / s->frames);
    paper_sap_free(sap);
}

static void compare_on(const scene *s, unsigned rounds)
{
    const way storage[] = {{"arrays", arrays, s},
                           {"linked lists", lists, s},
                           {"arrays, but the test of the lists", arrays_without_ranks, s}};
    const way compares[] = {{"integers", integers, s}, {"floats", floats, s}, {"one 64-bit key", arrays, s}};
    const way ends[] = {{"sentinels", arrays, s}, {"tests for the ends", bounds_tests, s}};
    const way tests[] = {{"indices", arrays, s},
                         {"bounds of the boxes", arrays_without_ranks, s},
                         {"values of the end points", by_end_point, s}};
    const way removals[] = {{"tested before", arrays, s}, {"looked up untested", removes_untested, s}};
    compare("arrays", s->name, storage, 3, rounds, NULL);
    compare("integers", s->name, compares, 3, rounds, NULL);
    compare("sentinels", s->name, ends, 2, rounds, NULL);
    compare("index-test", s->name, tests, 3, rounds, NULL);
    compare("removal-test", s->name, removals, 2, rounds, NULL);
    count_removals(s);
}

void claim_axes(void)
{
    static const recipe scenes[] = {
        {"1,000 boxes, slow", 1000, 40, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"10,000 boxes, slow", 10000, 6, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"10,000 boxes, fast", 10000, 1, 2, 1, 1, BROWNIAN, 0, 0},
        {"10,000 boxes on a floor", 10000, 6, 2, 1, 0.05, STRAIGHT, 1, 0},
        {"2,000 boxes in a crowd", 2000, 10, 60, 1, 0.02, BROWNIAN, 0, 0},
        {"100,000 boxes, 1 in 100 moves", 100000, 10, 2, 0.01, 0.05, STRAIGHT, 0, 0},
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        scene s = scene_make(&scenes[i]);
        compare_on(&s, 5);
        scene_free(&s);
    }
}
