/* What the measurements share: a clock, random numbers, interleaved rounds, output.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Results go to stdout, a line each, fields separated by tabs; claims.py makes the
 * tables from them:
 *
 *     time   CLAIM  SCENE  WAY  MS  RATIO  LOW  HIGH
 *     count  CLAIM  SCENE  WHAT  VALUE
 *
 * MS is the median time of the rounds; RATIO is the median over the rounds of the way's
 * time to that of the first way in the same round, LOW and HIGH are its quartiles.
 */
#ifndef BENCH_H
#define BENCH_H

#include <stddef.h>
#include <stdint.h>

/* Milliseconds: of processor time of the calling thread, which does not go on while
 * other programs have the processor; and of the time of day, for work on several
 * threads. */
double clock_ms(void);
double wall_ms(void);

/* splitmix64: the next of a sequence, and a number from 0 to below 1. */
uint64_t random_next(uint64_t *state);
double random_unit(uint64_t *state);

/* What two boxes add to the check of a set of pairs: the sum tells sets apart. */
uint64_t pair_check(uint32_t a, uint32_t b);

/* Sorts key[n] upwards; scratch has room for n keys. */
void sort_keys(uint64_t *key, size_t n, uint64_t *scratch);

/* malloc that ends the program if there is no memory. */
void *get(size_t count, size_t size);

/* Ends the program with a line on stderr. */
void give_up(const char *format, ...);

/* What a way of doing something took, and a number that says what came out: it must
 * be the same for all ways that are compared. */
typedef struct outcome {
    double ms;
    uint64_t check;
} outcome;

typedef outcome (*way_fn)(const void *what);

typedef struct way {
    const char *name;
    way_fn run;
    const void *what;
} way;

enum { MOST_WAYS = 8, MOST_ROUNDS = 15 };

/* Runs the ways in turn, so many times, and prints their times. Gives up if their
 * checks differ. median, if it is not NULL, gets the time of each way. */
void compare(const char *claim, const char *scene, const way *ways, size_t n, unsigned rounds, double *median);

void print_count(const char *claim, const char *scene, const char *what, double value);

/* The claims, each a set of comparisons. */
void claim_axes(void);
void claim_batches(void);
void claim_pruning(void);
void claim_scaling(void);
void claim_cells(void);
void claim_statics(void);
void claim_parallel(void);

#endif
