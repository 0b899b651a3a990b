/* Harness: as fuzz_api.c, but the input also chooses which allocations fail and how
 * many bytes there are.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "play.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    play(data, size, 1);
    return 0;
}
