/* The pair manager: the active pairs as a contiguous array, found by a hash table
 * (paper I.6).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The array is the paper's: no holes, so that all pairs can be read at once. The
 * hash table maps a pair of slots to its place in the array, by linear probing; an
 * erased entry is filled from behind, so that there are no tombstones. A pair that
 * is deleted changes places with the last active one. After all deletions of a
 * commit the deleted pairs stand behind the active ones, in order, and the created
 * ones are put between: the arrays of events are parts of this one, and a commit
 * that only loses pairs needs no memory.
 *
 * Only sorted events change the table, so its order follows from them alone. */
#include "internal.h"

static size_t home(const struct pair_table *t, uint64_t key)
{
    key ^= key >> 32;
    key *= 0x9e3779b97f4a7c15u;
    return (size_t)(key >> 32) & (t->slots - 1);
}

static uint64_t key_at(const struct pair_table *t, uint32_t index)
{
    return (uint64_t)slot_of(t->at[index].a) << 32 | slot_of(t->at[index].b);
}

/* Where the key is in the hash table, or the free entry where it would be. */
static size_t probe(const struct pair_table *t, uint64_t key)
{
    size_t i = home(t, key);
    while (t->slot[i] != NONE && key_at(t, t->slot[i]) != key) i = (i + 1) & (t->slots - 1);
    return i;
}

/* The index of the pair of two slots, or NONE. */
uint32_t msap_pairs_find(const struct pair_table *t, uint32_t a, uint32_t b)
{
    return t->slots ? t->slot[probe(t, pair_key(a, b))] : NONE;
}

/* Frees entry `hole` and moves those behind it that may not stand behind a gap. */
static void erase(struct pair_table *t, size_t hole)
{
    for (size_t i = (hole + 1) & (t->slots - 1); t->slot[i] != NONE; i = (i + 1) & (t->slots - 1)) {
        size_t from_home = (i - home(t, key_at(t, t->slot[i]))) & (t->slots - 1);
        if (from_home < ((i - hole) & (t->slots - 1))) continue;
        t->slot[hole] = t->slot[i];
        hole = i;
    }
    t->slot[hole] = NONE;
}

static void fill_table(struct pair_table *t)
{
    for (size_t i = 0; i < t->slots; i++) t->slot[i] = NONE;
    for (size_t i = 0; i < t->active; i++) t->slot[probe(t, key_at(t, (uint32_t)i))] = (uint32_t)i;
}

static size_t slots_for(size_t pairs)
{
    size_t slots = 16;
    while (slots / 2 < pairs) slots *= 2;
    return pairs ? slots : 0;
}

static int resize_table(struct pair_table *t, struct memory *m, size_t slots)
{
    if (!msap_memory_resize(m, &t->slot, &t->slots, slots, 0, sizeof *t->slot)) return 0;
    fill_table(t);
    return 1;
}

void msap_pairs_free(struct pair_table *t, struct memory *m)
{
    msap_memory_free(m, t->at, t->room, sizeof *t->at);
    msap_memory_free(m, t->slot, t->slots, sizeof *t->slot);
    memset(t, 0, sizeof *t);
}

static size_t larger(size_t a, size_t b) { return a > b ? a : b; }

/* Room for a commit's events. Returns 0 without memory, the pairs being as before. The
 * array has room for the most pairs so far and, behind them, the most deleted ones. */
int msap_pairs_reserve(struct pair_table *t, struct memory *m, size_t created, size_t deleted)
{
    size_t active = t->active - deleted + created;
    size_t room = larger(active, t->most_active) + larger(deleted, t->most_deleted);
    if (!msap_memory_reserve(m, &t->at, &t->room, room, t->active + t->deleted, sizeof *t->at)) return 0;
    t->most_active = larger(active, t->most_active);
    t->most_deleted = larger(deleted, t->most_deleted);
    return slots_for(active) <= t->slots || resize_table(t, m, slots_for(active));
}

/* Gives room back; forgets the events. */
void msap_pairs_trim(struct pair_table *t, struct memory *m)
{
    t->created = t->deleted = 0;
    t->most_active = t->active;
    t->most_deleted = 0;
    msap_memory_shrink(m, &t->at, &t->room, t->active, sizeof *t->at);
    if (slots_for(t->active) < t->slots) resize_table(t, m, slots_for(t->active));
}

/* Deletes the pair of a key: it changes places with the last active one. */
static void delete_pair(struct pair_table *t, uint64_t key)
{
    size_t entry = probe(t, key);
    uint32_t at = t->slot[entry], last = (uint32_t)--t->active;
    erase(t, entry);
    if (at == last) return;
    t->slot[probe(t, key_at(t, last))] = at;
    msap_pair deleted = t->at[at];
    t->at[at] = t->at[last];
    t->at[last] = deleted;
}

/* Applies sorted events for which there is room. */
void msap_pairs_apply(struct pair_table *t, const struct box_table *boxes, const struct keys *fresh,
                      const struct keys *doomed)
{
    for (size_t i = doomed->n; i-- > 0;) delete_pair(t, doomed->at[i]); /* the first ends up first */
    if (fresh->n > 0) memmove(t->at + t->active + fresh->n, t->at + t->active, doomed->n * sizeof *t->at);
    for (size_t i = 0; i < fresh->n; i++) {
        uint64_t key = fresh->at[i];
        msap_pair *p = &t->at[t->active];
        t->slot[probe(t, key)] = (uint32_t)t->active++;
        p->a = handle_of(boxes, (uint32_t)(key >> 32));
        p->b = handle_of(boxes, (uint32_t)key);
        p->user_data = NULL;
    }
    t->created = fresh->n;
    t->deleted = doomed->n;
}

/* The first broken invariant, or NULL. */
const char *msap_pairs_broken(const struct pair_table *t)
{
    size_t entries = 0;
    if (t->active + t->deleted > t->room || t->created > t->active) return "the pair array is overfull";
    for (size_t i = 0; i < t->slots; i++) {
        if (t->slot[i] == NONE) continue;
        entries++;
        if (t->slot[i] >= t->active) return "an entry of the pair table leads nowhere";
    }
    if (entries != t->active) return "the pair table has another number of entries than there are pairs";
    for (size_t i = 0; i < t->active; i++) {
        if (t->at[i].a >= t->at[i].b) return "a pair is not in order";
        if (msap_pairs_find(t, slot_of(t->at[i].a), slot_of(t->at[i].b)) != i) return "a pair cannot be found";
    }
    return NULL;
}
