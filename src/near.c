/* Neighbour lists: which fat boxes overlap, from the side of each box.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * b is in the list of a exactly if a is in the list of b, and they are exactly if
 * the fat bounds of a and b overlap, not both are static and not both rest (rest.c); of
 * a box that rests its bounds at the last commit count. While boxes rest in skins, no box has a list
 * (candidates.c). A list holds the
 * slots above its own first, so that a walk over all pairs can visit each from
 * its lower box alone. Within the two parts the order is free. The entry for a
 * neighbour above has NEAR_PAIR exactly if the two boxes are a pair, since the last
 * commit: so a touch that finds the pair as it was needs to look at nothing else. */
#include "internal.h"

static int give_room(struct near_list *l, struct pool *p, struct memory *m, uint32_t room)
{
    unsigned class = msap_pool_class_for((room + NEAR_UNIT - 1) / NEAR_UNIT);
    l->at = msap_pool_get(p, m, class);
    l->class = (uint8_t) class;
    return l->at != NULL;
}

/* To twice the room: the smaller arrays that are left behind come to no more than that. */
static int grow(struct near_list *l, struct pool *p, struct memory *m)
{
    struct near_list old = *l;
    if (!give_room(l, p, m, old.at ? 2 * near_room(&old) : 1)) {
        *l = old;
        return 0;
    }
    if (!old.at) return 1;
    memcpy(l->at, old.at, old.n * sizeof *l->at);
    msap_pool_put(p, m, old.at, old.class);
    return 1;
}

/* Puts an entry into the list of `self`, where it is not yet and which has room. */
static void put(struct near_list *l, uint32_t self, uint32_t entry)
{
    l->at[l->n] = entry;
    if (near_slot(entry) > self) {
        l->at[l->n] = l->at[l->n_above];
        l->at[l->n_above++] = entry;
    }
    l->n++;
}

static int has_room(struct near_list *l, struct pool *p, struct memory *m)
{
    return l->n < near_room(l) || grow(l, p, m);
}

/* Makes two boxes neighbours, which they are not yet. Room comes from the pool of the lists or a
 * stock of it. Returns 0 without memory, the lists being as before. */
int msap_near_join(struct near_lists *all, struct pool *p, struct memory *m, uint32_t a, uint32_t b, int is_pair)
{
    uint32_t low = a < b ? a : b, high = a < b ? b : a;
    struct near_list *of_low = &all->of[low], *of_high = &all->of[high];
    if (!has_room(of_low, p, m) || !has_room(of_high, p, m)) return 0;
    put(of_low, low, is_pair ? high | NEAR_PAIR : high);
    put(of_high, high, low);
    return 1;
}

/* Counts the neighbours of each box. */
static void count(struct near_lists *all, const struct keys *pairs)
{
    for (size_t i = 0; i < pairs->n; i++) {
        uint32_t a = (uint32_t)(pairs->at[i] >> 32), b = near_slot((uint32_t)pairs->at[i]);
        all->of[a].n++;
        all->of[b].n++;
        all->of[a < b ? a : b].n_above++;
    }
}

/* Makes the lists, which are empty, from pairs of slots in any order, each once; the lower
 * half of a key has NEAR_PAIR as the entry shall have it. Returns 0 without memory. */
int msap_near_make(struct near_lists *all, struct memory *m, const struct keys *pairs, size_t slots)
{
    if (pairs->n == 0) return 1;
    count(all, pairs);
    for (size_t slot = 0; slot < slots; slot++) {
        struct near_list *l = &all->of[slot];
        if (l->n > 0 && !give_room(l, &all->pool, m, l->n)) return 0;
        l->n = l->n_above; /* where the next one below is put, and n_above where the next one above */
        l->n_above = 0;
    }
    for (size_t i = 0; i < pairs->n; i++) {
        uint32_t a = (uint32_t)(pairs->at[i] >> 32), b = (uint32_t)pairs->at[i], is_pair = b & NEAR_PAIR;
        uint32_t low = a < near_slot(b) ? a : near_slot(b), high = a ^ near_slot(b) ^ low;
        struct near_list *of_low = &all->of[low], *of_high = &all->of[high];
        of_low->at[of_low->n_above++] = high | is_pair;
        of_high->at[of_high->n++] = low;
    }
    return 1;
}

/* The index of the one of the first n <= 4 of four entries that is for `other`, or 4. */
static inline uint32_t find_in_four(const uint32_t *entry, uint32_t n, uint32_t other)
{
#if defined(__SSE2__)
    __m128i same =
        _mm_xor_si128(_mm_loadu_si128((const __m128i *)(const void *)entry), _mm_set1_epi32((int)other));
    same = _mm_cmpeq_epi32(_mm_slli_epi32(same, 1), _mm_setzero_si128());
    unsigned found = (unsigned)_mm_movemask_ps(_mm_castsi128_ps(same)) & ((1u << n) - 1);
    return found ? (uint32_t)__builtin_ctz(found) : 4;
#else
    uint32_t i = 0;
    while (i < n && near_slot(entry[i]) != other) i++;
    return i < n ? i : 4;
#endif
}

/* The index of the entry for `other` in the list of `self`, or l->n. Fours are read whole:
 * a list has room for them. */
uint32_t msap_near_find(const struct near_list *l, uint32_t self, uint32_t other)
{
    uint32_t end = other > self ? l->n_above : l->n;
    for (uint32_t i = other > self ? 0 : l->n_above & ~3u; i < end; i += 4) {
        uint32_t left = end - i, at = find_in_four(l->at + i, left < 4 ? left : 4, other);
        if (at < 4) return i + at;
    }
    return l->n;
}

/* Takes what stands at index i out of the list. */
void msap_near_take_out(struct near_list *l, uint32_t i)
{
    if (i < l->n_above) {
        l->at[i] = l->at[--l->n_above];
        i = l->n_above;
    }
    l->at[i] = l->at[--l->n];
}

/* Whether a list may be searched once more in this round. */
static int may_search(struct near_list *l, uint16_t round)
{
    enum { MOST_SEARCHES = 8 };
    if (l->round != round) {
        l->round = round;
        l->searches = 0;
    }
    return l->searches++ < MOST_SEARCHES;
}

/* Takes `other` out of the list of `self`, if it is still there, now that their fat
 * bounds do not overlap any more. A long list that is searched often is only noted, to
 * be gone through once for all that left it: else boxes that leave a crowd together
 * would search each other's lists in turn. */
void msap_near_remove(struct near_lists *all, uint32_t self, uint32_t other)
{
    struct near_list *l = &all->of[self];
    if (l->noted) return;
    if (l->n > NEAR_LONG && !may_search(l, all->round)) {
        l->noted = all->first_noted + 1;
        all->first_noted = self + 1;
        return;
    }
    uint32_t i = msap_near_find(l, self, other);
    if (i < l->n) msap_near_take_out(l, i);
}

/* Takes out of the noted lists what is not near any more, as is_near says. */
void msap_near_tidy(struct near_lists *all, int (*is_near)(const void *context, uint32_t a, uint32_t b),
                    const void *context)
{
    all->round = (uint16_t)(all->round + 1);
    while (all->first_noted != 0) {
        uint32_t self = all->first_noted - 1;
        struct near_list *l = &all->of[self];
        all->first_noted = l->noted - 1;
        l->noted = 0;
        for (uint32_t i = l->n; i-- > 0;)
            if (!is_near(context, self, near_slot(l->at[i]))) msap_near_take_out(l, i);
    }
}

/* Gives the memory of an empty list back. */
void msap_near_drop(struct near_lists *all, struct memory *m, uint32_t self)
{
    struct near_list *l = &all->of[self];
    if (l->at) msap_pool_put(&all->pool, m, l->at, l->class);
    uint32_t noted = l->noted;
    memset(l, 0, sizeof *l);
    l->noted = noted;
}

/* Empties all lists. */
void msap_near_empty(struct near_lists *all, struct memory *m, size_t slots)
{
    for (size_t slot = 0; slot < slots; slot++) {
        struct near_list *l = &all->of[slot];
        if (pool_is_large(l->class) && l->at) /* GCOVR_EXCL_BR_LINE: what has a large class has an array */
            msap_pool_put(&all->pool, m, l->at, l->class);
    }
    if (slots > 0) /* GCOVR_EXCL_BR_LINE: who empties lists has some */
        memset(all->of, 0, slots * sizeof *all->of);
    all->first_noted = 0;
    msap_pool_empty(&all->pool);
}
