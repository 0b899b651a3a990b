/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: msap_validate finds nothing wrong in a world that is sound: empty, with
 * changes pending, after failed calls and commits; it reads only and allocates
 * nothing.
 */
#include <string.h>

#include "checks.h"

static void is_valid(const session *s)
{
    const char *what = "to be cleared";
    size_t calls = s->memory.calls;
    ck_assert_msg(msap_validate(s->world, &what) == MSAP_OK, "%s", what ? what : "no reason given");
    ck_assert_ptr_null(what);
    ok(msap_validate(s->world, NULL));
    ck_assert_uint_eq(s->memory.calls, calls);
}

START_TEST(an_empty_world_is_valid)
{
    uint32_t dims;
    for (dims = 2; dims <= 3; dims++) {
        msap_config config = config_of(dims, _i);
        session s;
        right(session_open(&s, &config, 1, SCENE_GRID));
        is_valid(&s);
        right(session_trim(&s));
        is_valid(&s);
        right(session_commit(&s));
        is_valid(&s);
        right(session_trim(&s));
        is_valid(&s);
        right(session_close(&s));
    }
}
END_TEST

static void frames_are_valid(uint32_t dims, int row, scene_kind scene)
{
    msap_config config = config_of(dims, row);
    session s;
    int frame;
    right(session_open(&s, &config, (uint64_t)row, scene));
    for (frame = 0; frame < 40; frame++) {
        right(session_change(&s, 40));
        is_valid(&s);
        right(session_commit(&s));
        is_valid(&s);
        if (frame % 8 == 0)
            right(session_trim(&s));
        is_valid(&s);
    }
    right(session_close(&s));
}

START_TEST(pending_changes_are_valid)
{
    int scene;
    for (scene = 0; scene < SCENE_COUNT; scene++)
        frames_are_valid(scene % 2 ? 2 : 3, _i, (scene_kind)scene);
}
END_TEST

/* A commit that failed, at each allocation it makes, and what follows it. */
START_TEST(failed_commits_are_valid)
{
    msap_config config = config_of(3, _i);
    session s;
    int frame;
    size_t failures = 0;
    right(session_open(&s, &config, 9, SCENE_GRID));
    for (frame = 0; frame < 40; frame++) {
        right(session_change(&s, 10 + 10 * (uint32_t)frame));
        s.memory.fail_all = 1;
        failures += msap_commit(s.world, NULL, NULL) != MSAP_OK;
        is_valid(&s);
        s.memory.fail_all = 0;
        ok(msap_commit(s.world, NULL, NULL));
        reference_commit(&s.reference);
        is_valid(&s);
    }
    ck_assert_uint_gt(failures, 0);
    right(session_close(&s));
}
END_TEST

START_TEST(refused_calls_leave_it_valid)
{
    box bad = cube(1, 0);
    msap_handle handle;
    session s;
    right(session_open(&s, NULL, 3, SCENE_GRID));
    right(session_step(&s, 30));
    right(session_change(&s, 30));
    refused(msap_add(s.world, bad.min, bad.max, 0, NULL, &handle), MSAP_ERROR_INVERTED);
    refused(msap_remove(s.world, UINT64_MAX), MSAP_ERROR_HANDLE);
    is_valid(&s);
    right(session_compare(&s));
    right(session_close(&s));
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("validate");
    tcase_add_loop_test(tests, an_empty_world_is_valid, 0, SETUPS);
    tcase_add_loop_test(tests, pending_changes_are_valid, 0, SETUPS);
    tcase_add_loop_test(tests, failed_commits_are_valid, 0, SETUPS);
    tcase_add_test(tests, refused_calls_leave_it_valid);
    return run_case(tests, "validate");
}
