/* A pair manager as the paper has it.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "pair_set.h"
#include "bench.h"

#include <stdlib.h>
#include <string.h>

enum { FIRST_ROOM = 1024 };

static uint32_t *chain_of(const pair_set *s, uint32_t a, uint32_t b)
{
    uint64_t mixed = ((uint64_t)a << 32 | b) * UINT64_C(0x9E3779B97F4A7C15);
    return &s->head[(mixed >> 32) & (s->heads - 1)];
}

static void link_all(pair_set *s)
{
    memset(s->head, 0xff, s->heads * sizeof *s->head);
    for (uint32_t i = 0; i < s->n; i++) {
        uint32_t *head = chain_of(s, s->at[i].a, s->at[i].b);
        s->at[i].next = *head;
        *head = i;
    }
}

void pair_set_begin(pair_set *s)
{
    s->n = 0;
    s->room = s->heads = FIRST_ROOM;
    s->at = get(s->room, sizeof *s->at);
    s->head = get(s->heads, sizeof *s->head);
    link_all(s);
}

void pair_set_end(pair_set *s)
{
    free(s->at);
    free(s->head);
}

static void grow(pair_set *s)
{
    pair_set old = *s;
    s->room = s->heads = 2 * old.room;
    s->at = get(s->room, sizeof *s->at);
    s->head = get(s->heads, sizeof *s->head);
    memcpy(s->at, old.at, old.n * sizeof *s->at);
    pair_set_end(&old);
    link_all(s);
}

static void order(uint32_t *a, uint32_t *b)
{
    if (*a < *b) return;
    uint32_t higher = *a;
    *a = *b;
    *b = higher;
}

/* The link that leads to a pair, or to PAIR_NONE at the end of its chain. */
static uint32_t *link_to(const pair_set *s, uint32_t a, uint32_t b)
{
    uint32_t *link = chain_of(s, a, b);
    while (*link != PAIR_NONE && (s->at[*link].a != a || s->at[*link].b != b)) link = &s->at[*link].next;
    return link;
}

int pair_set_add(pair_set *s, uint32_t a, uint32_t b)
{
    order(&a, &b);
    if (*link_to(s, a, b) != PAIR_NONE) return 0;
    if (s->n == s->room) grow(s);
    uint32_t *head = chain_of(s, a, b);
    active_pair pair = {a, b, *head};
    *head = s->n;
    s->at[s->n++] = pair;
    return 1;
}

/* The last pair takes the place of the one that goes. */
int pair_set_remove(pair_set *s, uint32_t a, uint32_t b)
{
    order(&a, &b);
    uint32_t *link = link_to(s, a, b), place = *link;
    if (place == PAIR_NONE) return 0;
    *link = s->at[place].next;
    active_pair last = s->at[--s->n];
    if (place != s->n) {
        *link_to(s, last.a, last.b) = place;
        s->at[place] = last;
    }
    return 1;
}

uint64_t pair_set_check(const pair_set *s)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < s->n; i++) sum += pair_check(s->at[i].a, s->at[i].b);
    return sum;
}
