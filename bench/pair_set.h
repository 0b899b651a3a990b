/* A pair manager as the paper has it (I.6): the active pairs in an array without
 * holes, found through a hash table with chains.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef PAIR_SET_H
#define PAIR_SET_H

#include <stddef.h>
#include <stdint.h>

typedef struct active_pair {
    uint32_t a, b; /* a < b */
    uint32_t next; /* in its chain, or PAIR_NONE */
} active_pair;

#define PAIR_NONE UINT32_MAX

typedef struct pair_set {
    active_pair *at;
    uint32_t n, room;
    uint32_t *head; /* [heads] of chains */
    uint32_t heads; /* a power of two */
} pair_set;

void pair_set_begin(pair_set *s);
void pair_set_end(pair_set *s);

/* 1 if the pair was not there, or was; a != b in any order. */
int pair_set_add(pair_set *s, uint32_t a, uint32_t b);
int pair_set_remove(pair_set *s, uint32_t a, uint32_t b);

uint64_t pair_set_check(const pair_set *s);

#endif
