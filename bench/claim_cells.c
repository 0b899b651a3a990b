/* The claim that movers should touch few cells (II.2b): the library as it was built,
 * on scenes in which boxes are of different sizes. claims.py builds it with other
 * limits, and compares.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "library.h"

static msap_world_stats last; /* of the last replay */

static outcome replay(const void *what)
{
    world_run run = library_run(what);
    outcome o = {run.ms, run.check};
    last = run.stats;
    return o;
}

static void measure(const scene *s)
{
    const setting multi = {s, NULL, 0};
    const way ways[] = {{"as built", replay, &multi}};
    compare("cells", s->name, ways, 1, 1, NULL);
    print_count("cells", s->name, "cells a box", (double)last.incidences / s->boxes);
    print_count("cells", s->name, "largest cell", (double)last.largest_cell);
}

void claim_cells(void)
{
    static const recipe scenes[] = {
        {"all about 1 wide", 20000, 16, 2, 1, 0.05, STRAIGHT, 0, 0},
        {"1 to 20 wide", 20000, 16, 1, 1, 0.05, STRAIGHT, 0, 20},
        {"1 to 300 wide, on a floor", 20000, 16, 0.3, 1, 0.05, STRAIGHT, 1, 300},
        {"1 to 20 wide, wobbling", 20000, 16, 1, 1, 0.05, BROWNIAN, 0, 20},
    };
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        scene s = scene_make(&scenes[i]);
        measure(&s);
        scene_free(&s);
    }
}
