/* Reading an input.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "fuzz.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void fuzz_check(const char *wrong)
{
    if (!wrong)
        return;
    fprintf(stderr, "wrong: %s\n", wrong);
    abort();
}

uint64_t take(input *in, unsigned bytes)
{
    uint64_t value = 0;
    unsigned i;
    for (i = 0; i < bytes && in->at < in->end; i++)
        value |= (uint64_t)*in->at++ << (8 * i);
    return value;
}

float take_float(input *in)
{
    uint32_t bits = (uint32_t)take(in, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

double take_double(input *in)
{
    uint64_t bits = take(in, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

float take_hard(input *in)
{
    static const uint32_t magnitudes[] = {
        0x00000000, 0x00000001, 0x00000002, 0x007FFFFF, 0x00800000, 0x00800001, 0x2B8CBCCC, 0x3F7FFFFF,
        0x3F800000, 0x3F800001, 0x4B7FFFFF, 0x4E800000, 0x7149F2CA, 0x7E800000, 0x7F7FFFFE, 0x7F7FFFFF,
        0x7F800000, 0x7F800001, 0x7FBFFFFF, 0x7FC00000, 0x7FFFFFFF, 0x40000000, 0x40400000, 0x41200000,
    };
    uint32_t byte = (uint32_t)take(in, 1);
    uint32_t bits = magnitudes[(byte >> 1) % (sizeof magnitudes / sizeof *magnitudes)];
    float value;
    bits |= (byte & 1) << 31;
    memcpy(&value, &bits, sizeof value);
    return value;
}
