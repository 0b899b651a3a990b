/* What the measurements share.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A machine that does other things as well makes a program slower, and mostly for
 * longer than one run takes. So the ways are run in turn, two of them are compared
 * within a round, where they ran one after the other, and medians of the rounds count. */
#define _POSIX_C_SOURCE 200809L
#include "bench.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double read_clock(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

double clock_ms(void) { return read_clock(CLOCK_THREAD_CPUTIME_ID); }
double wall_ms(void) { return read_clock(CLOCK_MONOTONIC); }

static uint64_t splitmix64(uint64_t x)
{
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

uint64_t random_next(uint64_t *state)
{
    *state += UINT64_C(0x9E3779B97F4A7C15);
    return splitmix64(*state);
}

double random_unit(uint64_t *state) { return (double)(random_next(state) >> 11) / 9007199254740992.0; }

uint64_t pair_check(uint32_t a, uint32_t b)
{
    uint64_t low = a < b ? a : b, high = a < b ? b : a;
    return splitmix64((low << 32 | high) + UINT64_C(0x9E3779B97F4A7C15));
}

/* The library's sort once more: these programs use the library by its interface alone. */
static void radix_pass(const uint64_t *from, uint64_t *to, size_t n, unsigned shift)
{
    size_t place[256] = {0}, sum = 0;
    for (size_t i = 0; i < n; i++) place[from[i] >> shift & 255]++;
    for (size_t d = 0; d < 256; d++) {
        size_t here = place[d];
        place[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < n; i++) to[place[from[i] >> shift & 255]++] = from[i];
}

void sort_keys(uint64_t *key, size_t n, uint64_t *scratch)
{
    uint64_t differ = 0, *from = key, *to = scratch;
    for (size_t i = 1; i < n; i++) differ |= key[i] ^ key[0];
    for (unsigned shift = 0; shift < 64; shift += 8) {
        if (!(differ >> shift & 255)) continue;
        radix_pass(from, to, n, shift);
        uint64_t *swap = from;
        from = to;
        to = swap;
    }
    if (from != key) memcpy(key, from, n * sizeof *key);
}

void give_up(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("bench: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

void *get(size_t count, size_t size)
{
    void *memory = calloc(count ? count : 1, size);
    if (!memory) give_up("no memory");
    return memory;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the times of the rounds upwards, and returns the median. */
static double print_time(const char *claim, const char *scene, const char *name, double *ms, const double *first,
                         unsigned rounds)
{
    double ratio[MOST_ROUNDS];
    for (unsigned r = 0; r < rounds; r++) ratio[r] = ms[r] / first[r];
    qsort(ratio, rounds, sizeof *ratio, by_value);
    qsort(ms, rounds, sizeof *ms, by_value);
    printf("time\t%s\t%s\t%s\t%.6g\t%.4g\t%.4g\t%.4g\n", claim, scene, name, ms[rounds / 2], ratio[rounds / 2],
           ratio[rounds / 4], ratio[rounds - 1 - rounds / 4]);
    fflush(stdout);
    return ms[rounds / 2];
}

void compare(const char *claim, const char *scene, const way *ways, size_t n, unsigned rounds, double *median)
{
    double ms[MOST_WAYS][MOST_ROUNDS] = {{0}}, first[MOST_ROUNDS];
    uint64_t check = 0;
    for (unsigned r = 0; r < rounds; r++)
        for (size_t i = 0; i < n; i++) {
            outcome o = ways[i].run(ways[i].what);
            ms[i][r] = o.ms;
            if (i == 0) check = o.check;
            if (o.check != check)
                give_up("%s, %s: %s finds something else than %s", claim, scene, ways[i].name, ways[0].name);
        }
    memcpy(first, ms[0], sizeof first);
    for (size_t i = 0; i < n; i++) {
        double ms_of = print_time(claim, scene, ways[i].name, ms[i], first, rounds);
        if (median) median[i] = ms_of;
    }
}

void print_count(const char *claim, const char *scene, const char *what, double value)
{
    printf("count\t%s\t%s\t%s\t%.10g\n", claim, scene, what, value);
    fflush(stdout);
}
