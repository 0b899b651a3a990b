/* Harness: the whole interface, in every set-up, against brute force; and the same
 * input once more, for the same handles, events, pairs and allocations.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "play.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t first = play(data, size, 0), second = play(data, size, 0);
    fuzz_check(first == second ? NULL : "the same input gave other results the second time");
    return 0;
}
