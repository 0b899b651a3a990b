/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Guards: whichever sweep goes over a row (simd.c) gives the pairs that overlap and have each
 * mark on one side or the other, all of them, once and in order; however long the row is, wherever
 * a sweep starts and ends, and however often the buffer was full. The same of what a question to a row finds. It looks
 * behind the interface.
 */
#define box inner_box /* the tests have a struct of that name */
#include "../../src/internal.h"
#undef box
#include "checks.h"

enum { MOST_ENTRIES = 150, MOST_PAIRS = MOST_ENTRIES * MOST_ENTRIES };

static const uint32_t simd[] = {MSAP_SIMD_AUTO, MSAP_SIMD_NONE, MSAP_SIMD_128, MSAP_SIMD_256, MSAP_SIMD_512};

struct pairs {
    uint32_t a[MOST_PAIRS], b[MOST_PAIRS];
    size_t n;
};

/* ---------------------------------------------------------------------- rows */

/* A row of n entries between 0 and `space` that are as long as `longest` at the most; behind it in memory,
 * other rows. Small whole numbers, so that many bounds are equal. */
static void fill_row(struct row_set *set, struct memory *m, uint64_t *random, uint32_t n, uint32_t space,
                     uint32_t longest)
{
    ck_assert(msap_row_set_make(set, m, MOST_ENTRIES));
    for (uint32_t i = 0; i < MOST_ENTRIES; i++) {
        for (int k = 0; k < 3; k++) {
            int32_t low = (int32_t)random_below(random, space) - (int32_t)space / 2;
            if (k == 0 && i > 0 && i < n && low < set->min[0][i - 1]) low = set->min[0][i - 1];
            set->min[k][i] = low;
            set->max[k][i] = low + (int32_t)random_below(random, longest + 1);
        }
        set->id[i] = i * 7 | (random_below(random, 4) ? ROW_MARKS : random_below(random, 8) * ROW_MOVES);
    }
}

/* Entry i of a row and j of the same one in another set, or in the same. */
static int are_pair(const struct row_set *s, uint32_t i, const struct row_set *other, uint32_t j)
{
    int overlap = 1;
    for (int k = 0; k < 3; k++) overlap &= s->min[k][i] <= other->max[k][j] && other->min[k][j] <= s->max[k][i];
    return overlap && ((s->id[i] | other->id[j]) & ROW_MARKS) == ROW_MARKS;
}

/* From entries first ... last - 1 to those behind them before `end`, by brute force. */
static void find_pairs(const struct row_set *s, uint32_t first, uint32_t last, uint32_t end, struct pairs *found)
{
    found->n = 0;
    for (uint32_t i = first; i < last; i++)
        for (uint32_t j = i + 1; j < end; j++)
            if (are_pair(s, i, s, j)) {
                found->a[found->n] = s->id[i] & ~ROW_MARKS;
                found->b[found->n++] = s->id[j] & ~ROW_MARKS;
            }
}

/* The same by a sweep. */
static void sweep_pairs(sweep_row_fn sweep, const struct row_set *s, uint32_t first, uint32_t last, uint32_t end,
                        struct pairs *found)
{
    struct row_sweep at = {first, first + 1, last, end};
    struct pair_buffer out;
    found->n = 0;
    while (at.i < at.last) {
        sweep(s, &at, &out);
        ck_assert_uint_le(out.n, MOST_BUFFERED);
        ck_assert_uint_le(found->n + out.n, MOST_PAIRS);
        memcpy(found->a + found->n, out.a, out.n * sizeof *out.a);
        memcpy(found->b + found->n, out.b, out.n * sizeof *out.b);
        found->n += out.n;
    }
}

/* From entries first ... last - 1 to those of another set from `start` to before `end`, by brute force. */
static void find_pairs_between(const struct row_set *s, uint32_t first, uint32_t last, const struct row_set *other,
                               uint32_t start, uint32_t end, struct pairs *found)
{
    found->n = 0;
    for (uint32_t i = first; i < last; i++)
        for (uint32_t j = start; j < end; j++)
            if (are_pair(s, i, other, j)) {
                found->a[found->n] = s->id[i] & ~ROW_MARKS;
                found->b[found->n++] = other->id[j] & ~ROW_MARKS;
            }
}

/* The same by a sweep, which is told how far the others reach. */
static void sweep_pairs_between(sweep_between_fn sweep, const struct row_set *s, uint32_t first, uint32_t last,
                                const struct row_set *other, uint32_t start, uint32_t end, struct pairs *found)
{
    int32_t reach[MOST_ENTRIES / REACH + 1], most = INT32_MIN;
    for (uint32_t j = start; j < end; j++) {
        most = other->max[0][j] > most ? other->max[0][j] : most;
        reach[(j - start) / REACH] = most;
    }
    struct row_reach where = {reach, start, start};
    struct row_sweep at = {first, 0, last, end};
    struct pair_buffer out;
    found->n = 0;
    while (at.i < at.last) {
        sweep(s, other, &where, &at, &out);
        ck_assert_uint_le(out.n, MOST_BUFFERED);
        ck_assert_uint_le(found->n + out.n, MOST_PAIRS);
        memcpy(found->a + found->n, out.a, out.n * sizeof *out.a);
        memcpy(found->b + found->n, out.b, out.n * sizeof *out.b);
        found->n += out.n;
    }
}

/* --------------------------------------------------------------------- tests */

static void compare_sweeps_between(const struct row_set *set, uint32_t first, uint32_t last,
                                   const struct row_set *other, uint32_t start, uint32_t end)
{
    static struct pairs right_ones, found;
    find_pairs_between(set, first, last, other, start, end, &right_ones);
    for (size_t i = 0; i < COUNT(simd); i++) {
        sweep_pairs_between(msap_sweeps_for(simd[i]).between, set, first, last, other, start, end, &found);
        ck_assert_uint_eq(found.n, right_ones.n);
        ck_assert(memcmp(found.a, right_ones.a, found.n * sizeof *found.a) == 0);
        ck_assert(memcmp(found.b, right_ones.b, found.n * sizeof *found.b) == 0);
    }
}

static void compare_sweeps(const struct row_set *set, uint32_t first, uint32_t last, uint32_t end)
{
    static struct pairs right_ones, found;
    find_pairs(set, first, last, end, &right_ones);
    for (size_t i = 0; i < COUNT(simd); i++) {
        sweep_pairs(msap_sweeps_for(simd[i]).row, set, first, last, end, &found);
        ck_assert_uint_eq(found.n, right_ones.n);
        ck_assert(memcmp(found.a, right_ones.a, found.n * sizeof *found.a) == 0);
        ck_assert(memcmp(found.b, right_ones.b, found.n * sizeof *found.b) == 0);
    }
}

static int is_asked_for(const struct row_set *s, const struct row_question *q, uint32_t i)
{
    int overlap = 1;
    for (int k = 0; k < 3; k++) overlap &= s->min[k][i] <= q->max[k] && q->min[k] <= s->max[k][i];
    return overlap && (s->id[i] & q->lacks) == q->lacks;
}

/* Asks entries first ... end - 1 in each way; as by brute force. */
static void compare_answers(const struct row_set *set, const struct row_question *q, uint32_t first, uint32_t end)
{
    uint32_t right_ones[MOST_ENTRIES], n_right = 0;
    for (uint32_t i = first; i < end; i++)
        if (is_asked_for(set, q, i)) right_ones[n_right++] = row_slot(set->id[i]);
    for (size_t i = 0; i < COUNT(simd); i++) {
        uint32_t found[MOST_ENTRIES + ENTRIES_ASKED + FOUND_SLACK];
        size_t n = 0;
        struct row_sweep at = {.i = first, .end = end};
        while (at.i < at.end) {
            uint32_t from = at.i;
            n += msap_sweeps_for(simd[i]).ask_row(set, q, &at, found + n);
            ck_assert(at.i == end || at.i == from + ENTRIES_ASKED);
        }
        ck_assert_uint_eq(n, n_right);
        ck_assert(memcmp(found, right_ones, n * sizeof *found) == 0);
    }
}

/* The same with bounds and marks at random. */
static void ask_at_random(const struct row_set *set, uint64_t *random, uint32_t first, uint32_t end)
{
    struct row_question q = {.lacks = random_below(random, 8) * ROW_MOVES};
    for (int k = 0; k < 3; k++) {
        q.min[k] = (int32_t)random_below(random, 64) - 32;
        q.max[k] = q.min[k] + (int32_t)random_below(random, 64);
    }
    compare_answers(set, &q, first, end);
}

/* Loop variable: how long boxes are in a space of 64, from points to nearly all of it. */
START_TEST(every_sweep_gives_the_pairs_of_a_row)
{
    uint64_t random = 11 + (uint64_t)_i;
    struct row_set set;
    struct memory m;
    memset(&set, 0, sizeof set);
    ok(msap_memory_init(&m, NULL, NULL, NULL));
    for (uint32_t n = 1; n <= MOST_ENTRIES; n++) {
        fill_row(&set, &m, &random, n, 64, 1u << _i);
        uint32_t first = random_below(&random, n), last = first + 1 + random_below(&random, n - first);
        compare_sweeps(&set, 0, n, n);
        compare_sweeps(&set, first, last, n);
        for (int i = 0; i < 8; i++) ask_at_random(&set, &random, i < 4 ? 0 : first, n);
    }
    msap_row_set_free(&set, &m);
    ck_assert_uint_eq(m.bytes, 0);
}
END_TEST

/* The same from one row through another one, which may be of any length, or empty. */
START_TEST(every_sweep_gives_the_pairs_of_two_rows)
{
    uint64_t random = 31 + (uint64_t)_i;
    struct row_set set, other;
    struct memory m;
    memset(&set, 0, sizeof set);
    memset(&other, 0, sizeof other);
    ok(msap_memory_init(&m, NULL, NULL, NULL));
    for (uint32_t n = 1; n <= MOST_ENTRIES; n++) {
        uint32_t n_other = 1 + random_below(&random, MOST_ENTRIES);
        fill_row(&set, &m, &random, n, 64, 1u << random_below(&random, 7));
        fill_row(&other, &m, &random, n_other, 64, 1u << _i);
        uint32_t first = random_below(&random, n), last = first + 1 + random_below(&random, n - first);
        uint32_t start = random_below(&random, n_other), end = start + random_below(&random, n_other - start + 1);
        compare_sweeps_between(&set, 0, n, &other, 0, n_other);
        compare_sweeps_between(&set, first, last, &other, start, end);
    }
    msap_row_set_free(&set, &m);
    msap_row_set_free(&other, &m);
    ck_assert_uint_eq(m.bytes, 0);
}
END_TEST

/* Numbers at both ends of what bounds are encoded to. */
START_TEST(bounds_may_be_any_numbers)
{
    uint64_t random = 5;
    struct row_set set;
    struct memory m;
    memset(&set, 0, sizeof set);
    ok(msap_memory_init(&m, NULL, NULL, NULL));
    for (int round = 0; round < 200; round++) {
        fill_row(&set, &m, &random, MOST_ENTRIES, 6, 2);
        for (uint32_t i = 0; i < MOST_ENTRIES; i++)
            for (int k = 0; k < 3; k++) {
                if (set.min[k][i] < -1) set.min[k][i] = ORDERED_MINUS_INF;
                if (set.max[k][i] > 1) set.max[k][i] = ORDERED_INF;
            }
        compare_sweeps(&set, 0, MOST_ENTRIES, MOST_ENTRIES);
        struct row_question all = {.lacks = 0, .min = {ORDERED_MINUS_INF, ORDERED_MINUS_INF, ORDERED_MINUS_INF}};
        for (int k = 0; k < 3; k++) all.max[k] = round % 2 ? ORDERED_INF : ORDERED_MINUS_INF;
        compare_answers(&set, &all, 0, MOST_ENTRIES);
    }
    msap_row_set_free(&set, &m);
}
END_TEST

int main(void)
{
    TCase *tests = tcase_create("row sweeps");
    tcase_add_loop_test(tests, every_sweep_gives_the_pairs_of_a_row, 0, 7);
    tcase_add_loop_test(tests, every_sweep_gives_the_pairs_of_two_rows, 0, 7);
    tcase_add_test(tests, bounds_may_be_any_numbers);
    return run_case(tests, "row sweeps");
}
