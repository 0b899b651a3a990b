/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: the same calls give the same handles and events, on every platform, with
 * every set-up, in every version. A fixed random scene, made of integers, is hashed
 * as it goes (FNV-1a over the handles and events); the hash is pinned below.
 *
 * On failure the hash that came out is printed. Events may never change; the pinned
 * value may only if the scene below does.
 */
#include "checks.h"

#define GOLDEN_2D UINT64_C(0xA9D04DCF395CFD08)
#define GOLDEN_3D UINT64_C(0xA583116BEC16C1B5)

#define BOXES 64
#define FRAMES 200

static void hash(uint64_t *sum, uint64_t word)
{
    int byte;
    for (byte = 0; byte < 8; byte++) {
        *sum ^= word >> (8 * byte) & 0xFF;
        *sum *= UINT64_C(0x100000001B3);
    }
}

/* One random change of a random box: it comes, moves or goes. */
static void change(session *s, msap_handle *handles, uint64_t *random, scene_kind scene, uint64_t *sum)
{
    uint32_t i = random_below(random, BOXES), what = random_below(random, 6);
    box b = random_box(random, scene);
    if (!handles[i]) {
        right(session_add(s, &b, what ? 0 : MSAP_STATIC, &handles[i]));
        hash(sum, handles[i]);
    } else if (what)
        right(session_update(s, handles[i], &b));
    else {
        right(session_remove(s, handles[i]));
        handles[i] = MSAP_NULL_HANDLE;
    }
}

static uint64_t hash_of_scene(uint32_t dims, int row)
{
    msap_config config = config_of(dims, row);
    msap_handle handles[BOXES] = {0};
    static const scene_kind scenes[] = {SCENE_GRID, SCENE_SPREAD, SCENE_HARD, SCENE_GRID};
    uint64_t sum = UINT64_C(0xCBF29CE484222325), random = 2007;
    session s;
    int frame;
    right(session_open(&s, &config, 0, SCENE_GRID));
    for (frame = 0; frame < FRAMES; frame++) {
        uint32_t changes = random_below(&random, frame % 10 ? 16 : 256);
        size_t i;
        while (changes--)
            change(&s, handles, &random, scenes[frame / 50], &sum);
        right(session_commit(&s)); /* the reference agrees */
        for (i = 0; i < s.event_count; i++) {
            hash(&sum, (uint64_t)s.events[i].created);
            hash(&sum, s.events[i].a);
            hash(&sum, s.events[i].b);
        }
    }
    right(session_close(&s));
    return sum;
}

static void is_golden(uint32_t dims, int row, uint64_t golden)
{
    uint64_t sum = hash_of_scene(dims, row);
    ck_assert_msg(sum == golden, "%s: 0x%08lX%08lX", setup_name, (unsigned long)(sum >> 32),
                  (unsigned long)(sum & 0xFFFFFFFF));
}

START_TEST(golden_2d)
{
    is_golden(2, _i, GOLDEN_2D);
}
END_TEST

START_TEST(golden_3d)
{
    is_golden(3, _i, GOLDEN_3D);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("golden events");
    tcase_add_loop_test(tests, golden_2d, 0, SETUPS);
    tcase_add_loop_test(tests, golden_3d, 0, SETUPS);
    return run_case(tests, "golden events");
}
