/* The true pairs of a scene, for comparison.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef ORACLE_H
#define ORACLE_H

#include "mode.h"

/* The boxes of a scene, twice: as it has them and as floats. */
typedef struct oracle oracle;

oracle *oracle_open(const scene *s);
void oracle_step(oracle *o, const frame *f);

/* Of some pairs, which may repeat, those that are false and those that are missing. */
typedef struct verdict {
    uint64_t true_pairs, false_pairs, missed;
} verdict;

/* Compares with the boxes as doubles or as floats; orders `found`. */
verdict oracle_judge(oracle *o, int as_doubles, id_pair *found, size_t n);

#endif
