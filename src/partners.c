/* Partners: with whom boxes that rest make pairs.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A box that rests and moves must settle what it was to others that rest, and no neighbour list tells who
 * they are (rest.c). To ask the rows costs as much as to note some tens of pairs. So when they have been asked
 * so often that to note all pairs costs no more, that is done, once for all boxes: two that rest then are
 * partners if they are a pair, as long as both rest. */
#include "internal.h"

/* Counts how many partners each box has, and turns that into where they start. */
static void start(struct partners *p, const struct pair_table *pairs)
{
    uint32_t sum = 0;
    memset(p->end, 0, p->slots * sizeof *p->end);
    for (size_t i = 0; i < pairs->active; i++) {
        p->end[slot_of(pairs->at[i].a)]++;
        p->end[slot_of(pairs->at[i].b)]++;
    }
    for (size_t slot = 0; slot < p->slots; slot++) {
        uint32_t n = p->end[slot];
        p->end[slot] = sum; /* and moves to the end as they are noted */
        sum += n;
    }
}

/* Notes them if that is worth it: before boxes move in a commit. Of very many boxes, for which it would take much
 * memory, and without memory they are not noted. */
void msap_partners_note(struct grid *g, const struct job *job)
{
    enum { ASKING = 32, SLOTS = 16 }; /* as dear as so many pairs, and as one pair for so many slots */
    struct partners *p = &g->partners;
    struct memory *m = job->memory;
    const struct pair_table *pairs = job->pairs;
    size_t slots = job->boxes->used, n = 2 * pairs->active;
    if (p->slots > 0 || p->asked * ASKING <= pairs->active + slots / SLOTS) return;
    p->asked = 0;
    if (slots > VERY_MANY_BOXES || n > UINT32_MAX) return; /* GCOVR_EXCL_BR_LINE: so many pairs take 64 GB */
    if (!msap_memory_reserve(m, &p->end, &p->room_end, slots, 0, sizeof *p->end) ||
        !msap_memory_reserve(m, &p->other, &p->room_other, n, 0, sizeof *p->other))
        return;
    p->slots = slots;
    start(p, pairs);
    for (size_t i = 0; i < pairs->active; i++) {
        uint32_t a = slot_of(pairs->at[i].a), b = slot_of(pairs->at[i].b);
        p->other[p->end[a]++] = b;
        p->other[p->end[b]++] = a;
    }
}

/* Where those of a box start. */
static uint32_t first_of(const struct partners *p, uint32_t slot) { return slot > 0 ? p->end[slot - 1] : 0; }

/* Settles a box that rests, and is about to go elsewhere, with its partners. Returns 0, and counts it, if they are
 * not noted. */
int msap_partners_settle(struct grid *g, struct settler *s, uint32_t slot)
{
    struct partners *p = &g->partners;
    p->asked += p->slots == 0;
    if (p->slots == 0) return 0;
    for (uint32_t i = first_of(p, slot); i < p->end[slot]; i++)
        if (rests(g, &g->boxes->at[p->other[i]])) settle(s, slot, p->other[i]);
    return 1;
}

/* Other boxes rest from now on, or none. */
void msap_partners_forget(struct grid *g) { g->partners.slots = g->partners.asked = 0; }

void msap_partners_free(struct grid *g, struct memory *m)
{
    struct partners *p = &g->partners;
    msap_memory_free(m, p->end, p->room_end, sizeof *p->end);
    msap_memory_free(m, p->other, p->room_other, sizeof *p->other);
    memset(p, 0, sizeof *p);
}

/* ------------------------------------------------------------------ checking */

static int has_partner(const struct partners *p, uint32_t slot, uint32_t other)
{
    for (uint32_t i = first_of(p, slot); i < p->end[slot]; i++)
        if (p->other[i] == other) return 1;
    return 0;
}

/* The first broken invariant, or NULL. */
const char *msap_partners_broken(const struct grid *g, const struct pair_table *pairs)
{
    const struct partners *p = &g->partners;
    if (p->slots > 0 && (!g->is_resting || g->in_skins)) return "partners are noted while no box rests as it is";
    for (size_t i = 0; p->slots > 0 && i < pairs->active; i++) {
        uint32_t a = slot_of(pairs->at[i].a), b = slot_of(pairs->at[i].b);
        if (!rests(g, &g->boxes->at[a]) || !rests(g, &g->boxes->at[b])) continue;
        if (!has_partner(p, a, b) || !has_partner(p, b, a)) return "a pair that rests is not noted";
    }
    return NULL;
}
