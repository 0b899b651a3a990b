/* Claims about box pruning (I.4c): it takes about the same time whatever moves, less
 * than a SAP when everything does, and more when little does. Where do they cross?
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "library.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The pairs of a frame, sorted, as msap_prune gives them. */
struct pairs {
    msap_index_pair *at;
    size_t n;
};

static uint64_t key_of(msap_index_pair p) { return (uint64_t)p.a << 32 | p.b; }

/* How many pairs came and went: what makes box pruning tell what changed. */
static size_t count_changes(const struct pairs *old, const struct pairs *now)
{
    size_t i = 0, j = 0, same = 0;
    while (i < old->n && j < now->n) {
        uint64_t a = key_of(old->at[i]), b = key_of(now->at[j]);
        same += a == b;
        i += a <= b;
        j += b <= a;
    }
    return old->n + now->n - 2 * same;
}

static struct pairs prune(const aabb *boxes, uint32_t n)
{
    struct pairs p;
    msap_boxes all = boxes_of(boxes);
    if (msap_prune(NULL, n, &all, &p.at, &p.n, NULL)) give_up("msap_prune failed");
    return p;
}

static outcome prune_each_frame(const void *what)
{
    const scene *s = what;
    outcome o = {0, 0};
    aabb *boxes = get(s->boxes, sizeof *boxes);
    memcpy(boxes, s->start, s->boxes * sizeof *boxes);
    struct pairs old = prune(boxes, s->boxes);
    double start = clock_ms();
    for (uint32_t frame = 0; frame < s->frames; frame++) {
        const move *m = scene_frame(s, frame);
        for (uint32_t i = 0; i < s->movers; i++) boxes[m[i].box] = m[i].to;
        struct pairs now = prune(boxes, s->boxes);
        count_changes(&old, &now);
        msap_prune_free(NULL, old.at, old.n);
        old = now;
    }
    o.ms = (clock_ms() - start) / s->frames;
    for (size_t i = 0; i < old.n; i++) o.check += pair_check(old.at[i].a, old.at[i].b);
    msap_prune_free(NULL, old.at, old.n);
    free(boxes);
    return o;
}

static void compare_share(const char *kind, motion motion, double speed, double percent)
{
    char name[64];
    const recipe r = {"", 10000, motion == JUMPING ? 2 : 12, 2, percent / 100, speed, motion, 0, 0};
    const msap_config slide = config_of(MSAP_GRID_NONE, MSAP_STRATEGY_SLIDE, 0);
    const msap_config best = config_of(MSAP_GRID_NONE, MSAP_STRATEGY_AUTO, 0);
    scene s = scene_make(&r);
    const setting single = {&s, &slide, 0}, single_best = {&s, &best, 0}, multi = {&s, NULL, 0};
    const way ways[] = {{"box pruning", prune_each_frame, &s},
                        {"single SAP, sliding", library_replay, &single},
                        {"single SAP, best way", library_replay, &single_best},
                        {"Multi-SAP", library_replay, &multi}};
    snprintf(name, sizeof name, "%s, %g %% move", kind, percent);
    compare("pruning", name, ways, 4, motion == JUMPING ? 3 : 5, NULL);
    scene_free(&s);
}

void claim_pruning(void)
{
    static const double percents[] = {0.1, 1, 3, 10, 30, 100};
    for (size_t i = 0; i < sizeof percents / sizeof *percents; i++)
        compare_share("slow", STRAIGHT, 0.05, percents[i]);
    for (size_t i = 0; i < sizeof percents / sizeof *percents; i++)
        compare_share("jumping", JUMPING, 0, percents[i]);
}
