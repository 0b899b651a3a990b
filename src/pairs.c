/* The pair manager: the active pairs as a contiguous array, found by a hash table
 * (paper I.6).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The array is the paper's: no holes, so that all pairs can be read at once. The
 * hash table chains the pairs of one home by their places in the array, so that no
 * pair is moved because another one comes or goes, and full homes cost only their own
 * pairs. A pair that is deleted changes places with the last active one. After all
 * deletions of a commit the deleted pairs stand behind the active ones, in order, and
 * the created ones are put between: the arrays of events are parts of this one, and a
 * commit that only loses pairs needs no memory.
 *
 * Only sorted events change the array, so its order follows from them alone. An event
 * may need any part of the memory, but it is known which: some events before it, that
 * part is fetched into the cache. */
#include "internal.h"

/* The upper bits of a product depend on all bits of its factors. */
static size_t home(const struct pair_table *t, uint64_t key)
{
    key ^= key >> 32;
    key *= 0x9e3779b97f4a7c15u;
    return (size_t)(key >> t->shift);
}

/* The entry of a key's pair, or the NONE at the end of its chain. */
static uint32_t *entry_of_key(const struct pair_table *t, uint64_t key)
{
    uint32_t *entry = &t->first[home(t, key)];
    while (*entry != NONE && pair_key_at(t, *entry) != key) entry = &t->next[*entry];
    return entry;
}

/* The entry of an active pair. */
static uint32_t *entry_of(const struct pair_table *t, uint32_t index)
{
    uint32_t *entry = &t->first[home(t, pair_key_at(t, index))];
    while (*entry != index) entry = &t->next[*entry];
    return entry;
}

/* The index of the pair of two slots, or NONE. */
uint32_t msap_pairs_find(const struct pair_table *t, uint32_t a, uint32_t b)
{
    return t->homes ? *entry_of_key(t, pair_key(a, b)) : NONE;
}

/* Puts a pair at the start of its chain. */
static void chain(struct pair_table *t, uint64_t key, uint32_t index)
{
    uint32_t *first = &t->first[home(t, key)];
    t->next[index] = *first;
    *first = index;
}

static void fill_table(struct pair_table *t)
{
    for (size_t i = 0; i < t->homes; i++) t->first[i] = NONE;
    for (uint32_t i = 0; i < t->active; i++) chain(t, pair_key_at(t, i), i);
}

static size_t homes_for(size_t pairs)
{
    size_t homes = 16;
    while (homes < pairs) homes *= 2;
    return pairs ? homes : 0;
}

static int resize_table(struct pair_table *t, struct memory *m, size_t homes)
{
    if (!msap_memory_resize(m, &t->first, &t->homes, homes, 0, sizeof *t->first)) return 0;
    for (t->shift = 64; homes > 1; homes /= 2) t->shift--;
    fill_table(t);
    return 1;
}

void msap_pairs_free(struct pair_table *t, struct memory *m)
{
    msap_memory_free(m, t->at, t->room, sizeof *t->at);
    msap_memory_free(m, t->first, t->homes, sizeof *t->first);
    msap_memory_free(m, t->next, t->room_next, sizeof *t->next);
    memset(t, 0, sizeof *t);
}

/* Room for a commit's events. Returns 0 without memory, the pairs being as before. The
 * array has room for the most pairs so far and, behind them, the most deleted ones. */
int msap_pairs_reserve(struct pair_table *t, struct memory *m, size_t created, size_t deleted)
{
    size_t active = t->active - deleted + created;
    size_t room = larger_of(active, t->most_active) + larger_of(deleted, t->most_deleted);
    if (!msap_memory_reserve(m, &t->at, &t->room, room, t->active + t->deleted, sizeof *t->at)) return 0;
    t->most_active = larger_of(active, t->most_active);
    t->most_deleted = larger_of(deleted, t->most_deleted);
    if (!msap_memory_reserve(m, &t->next, &t->room_next, active, t->active, sizeof *t->next)) return 0;
    return active <= t->homes || resize_table(t, m, homes_for(active));
}

/* Gives room back; forgets the events. */
void msap_pairs_trim(struct pair_table *t, struct memory *m)
{
    t->created = t->deleted = 0;
    t->most_active = t->active;
    t->most_deleted = 0;
    msap_memory_shrink(m, &t->at, &t->room, t->active, sizeof *t->at);
    msap_memory_shrink(m, &t->next, &t->room_next, t->active, sizeof *t->next);
    if (homes_for(t->active) < t->homes) resize_table(t, m, homes_for(t->active));
}

/* Deletes the pair of a key: it changes places with the last active one. */
static void delete_pair(struct pair_table *t, uint64_t key)
{
    uint32_t *entry = entry_of_key(t, key), at = *entry, last = (uint32_t)--t->active;
    *entry = t->next[at];
    if (at == last) return;
    *entry_of(t, last) = at;
    t->next[at] = t->next[last];
    msap_pair deleted = t->at[at];
    t->at[at] = t->at[last];
    t->at[last] = deleted;
}

static void create_pair(struct pair_table *t, const struct box_table *boxes, uint64_t key)
{
    chain(t, key, (uint32_t)t->active);
    msap_pair *p = &t->at[t->active++];
    p->a = handle_of(boxes, (uint32_t)(key >> 32));
    p->b = handle_of(boxes, (uint32_t)key);
    p->user_data = NULL;
}

/* Fetches what deleting the pair of a key will look up: soon, and then, when that is there, next. */
static void fetch_soon(const struct pair_table *t, uint64_t key) { prefetch(&t->first[home(t, key)]); }
static void fetch_next(const struct pair_table *t, uint64_t key)
{
    uint32_t index = t->first[home(t, key)]; /* of this pair or of another one: it is active */
    prefetch(&t->at[index]);
    prefetch(&t->next[index]);
}

/* Applies sorted events for which there is room. */
void msap_pairs_apply(struct pair_table *t, const struct box_table *boxes, const struct keys *fresh,
                      const struct keys *doomed)
{
    enum { AHEAD = 24, NEXT = 12 };
    for (size_t i = doomed->n; i-- > 0;) { /* the first ends up first */
        if (i >= AHEAD) fetch_soon(t, doomed->at[i - AHEAD]);
        if (i >= AHEAD) fetch_soon(t, pair_key_at(t, (uint32_t)t->active - AHEAD)); /* more than i are active */
        if (i >= NEXT) fetch_next(t, doomed->at[i - NEXT]);
        delete_pair(t, doomed->at[i]);
    }
    if (fresh->n > 0) memmove(t->at + t->active + fresh->n, t->at + t->active, doomed->n * sizeof *t->at);
    for (size_t i = 0; i < fresh->n; i++) {
        if (fresh->n - i > AHEAD) {
            fetch_soon(t, fresh->at[i + AHEAD]);
            prefetch(&boxes->at[fresh->at[i + AHEAD] >> 32].generation);
            prefetch(&boxes->at[(uint32_t)fresh->at[i + AHEAD]].generation);
        }
        create_pair(t, boxes, fresh->at[i]);
    }
    t->created = fresh->n;
    t->deleted = doomed->n;
}

/* The first broken invariant, or NULL. */
const char *msap_pairs_broken(const struct pair_table *t)
{
    size_t entries = 0;
    if (t->active + t->deleted > t->room || t->created > t->active) return "the pair array is overfull";
    if (t->active > t->homes || t->active > t->room_next) return "the pair table is overfull";
    for (size_t h = 0; h < t->homes; h++)
        for (uint32_t i = t->first[h]; i != NONE && entries <= t->active; i = t->next[i], entries++)
            if (i >= t->active) return "an entry of the pair table leads nowhere";
    if (entries != t->active) return "the pair table has another number of entries than there are pairs";
    for (size_t i = 0; i < t->active; i++) {
        if (t->at[i].a >= t->at[i].b) return "a pair is not in order";
        if (msap_pairs_find(t, slot_of(t->at[i].a), slot_of(t->at[i].b)) != i) return "a pair cannot be found";
    }
    return NULL;
}
