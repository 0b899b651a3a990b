/* What the harnesses share: their entry, the reading of an input, and the verdict.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Each fuzz_*.c is one harness. libFuzzer and AFL++ bring a main of their own;
 * plain.c is the main of the programs that run a corpus.
 */
#ifndef FUZZ_H
#define FUZZ_H

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* Ends the program with a sentence about what is wrong; NULL: nothing is. */
void fuzz_check(const char *wrong);

/* The bytes of an input that are not used yet. */
typedef struct input {
    const uint8_t *at, *end;
} input;

/* The next bytes, at most 8, as a little-endian number; behind the end come zeros. */
uint64_t take(input *in, unsigned bytes);
float take_float(input *in);
double take_double(input *in);

/* A float of 1 byte: one of those at which something happens, by sign and order. */
float take_hard(input *in);

#endif
