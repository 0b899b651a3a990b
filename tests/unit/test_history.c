/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: history does not matter. The same boxes give the same pairs, however they
 * came to be where they are, and whichever strategies brought them there.
 */
#include <string.h>

#include "checks.h"

#define BOXES 80
#define ROUTES 6 /* by which they come there; the first is straight */

/* Where the boxes are in the end. */
static box last[BOXES];
static uint32_t flags[BOXES];
static char names[BOXES]; /* a box's user data points to its name */

/* The pairs of the world must be those of brute force over `last`. */
static void pairs_are_those_of_the_last_boxes(const msap_world *world)
{
    static char paired[BOXES][BOXES];
    const msap_pair *pairs;
    size_t count, i, j;
    memset(paired, 0, sizeof paired);
    ok(msap_pairs(world, &pairs, &count));
    for (i = 0; i < count; i++) {
        msap_handle handles[2];
        void *data[2];
        handles[0] = pairs[i].a;
        handles[1] = pairs[i].b;
        ok(msap_get_user_data(world, 2, handles, data));
        paired[(char *)data[0] - names][(char *)data[1] - names] = 1;
    }
    for (i = 0; i < BOXES; i++)
        for (j = i + 1; j < BOXES; j++) {
            int expected = !(flags[i] & flags[j]) && boxes_overlap(&last[i], &last[j], 3);
            ck_assert_int_eq(paired[i][j] + paired[j][i], expected);
        }
}

static void choose_last(uint64_t *random, scene_kind scene)
{
    int i;
    for (i = 0; i < BOXES; i++) {
        last[i] = random_box(random, scene);
        flags[i] = random_below(random, 4) ? 0 : MSAP_STATIC;
    }
}

static void put(msap_world *world, msap_handle *handle, int i, const box *bounds)
{
    if (*handle)
        ok(msap_update(world, *handle, bounds->min, bounds->max));
    else
        ok(msap_add(world, bounds->min, bounds->max, flags[i], &names[i], handle));
}

/* Frames of random motion, removal and return, of a random share of the boxes. */
static void wander(msap_world *world, msap_handle *handles, uint64_t *random, scene_kind scene)
{
    int frame, i, frames = 1 + (int)random_below(random, 12);
    for (frame = 0; frame < frames; frame++) {
        uint32_t share = 1 + random_below(random, 10);
        for (i = 0; i < BOXES; i++) {
            box b = random_box(random, scene);
            if (random_below(random, share))
                continue;
            if (handles[i] && random_below(random, 4) == 0) {
                ok(msap_remove(world, handles[i]));
                handles[i] = 0;
            } else
                put(world, &handles[i], i, &b);
        }
        ok(msap_commit(world, NULL, NULL));
    }
}

/* From a random order of places to the last ones, all at once or a few a commit. */
static void arrive(msap_world *world, msap_handle *handles, uint64_t *random)
{
    uint32_t at_once = 1 + random_below(random, BOXES), start = random_below(random, BOXES), n;
    for (n = 0; n < BOXES; n++) {
        int i = (int)((start + n * 7) % BOXES); /* 7 and 80 have no common factor: each comes once */
        put(world, &handles[i], i, &last[i]);
        if (n % at_once == 0)
            ok(msap_commit(world, NULL, NULL));
    }
    ok(msap_commit(world, NULL, NULL));
}

START_TEST(all_roads_lead_to_the_same_pairs)
{
    uint64_t random = (uint64_t)_i;
    int scene, route;
    for (scene = 0; scene < SCENE_COUNT; scene++) {
        choose_last(&random, (scene_kind)scene);
        for (route = 0; route < ROUTES; route++) {
            msap_world *world = new_world(3, _i);
            msap_handle handles[BOXES] = {0};
            if (route)
                wander(world, handles, &random, (scene_kind)scene);
            arrive(world, handles, &random);
            pairs_are_those_of_the_last_boxes(world);
            ok(msap_destroy(world));
        }
    }
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("history");
    tcase_add_loop_test(tests, all_roads_lead_to_the_same_pairs, 0, SETUPS);
    return run_case(tests, "history");
}
