/* Settling: what a touched pair comes to (the decision itself is in internal.h, since
 * it is made for every touch).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Whatever touched the pair, and in which order axes and boxes were processed, the
 * decision is made from the boxes alone, as they were at the last commit and
 * as they are now. So nothing is ever decided by half-updated data, a pair that
 * begins and ceases to overlap between two commits leaves no trace, and "start
 * before stop" (paper I.3) is no rule that anybody must keep. The test of `before`
 * is the paper's overlap test prior to a removal (I.3): of all the crossings that
 * look like removals it lets only the real ones through. */
#include "internal.h"

/* The pair may stand in the list already; it is dropped only if it surely does. */
static void put_doomed(struct settler *s, uint64_t key)
{
    struct keys *doomed = &s->doomed;
    if (doomed->n == doomed->room && !keys_reserve(doomed, s->memory, doomed->n + 1)) {
        sort_keys(doomed->at, doomed->n, NULL);
        doomed->n = unique_keys(doomed->at, doomed->n);
        if (doomed->n == doomed->room) return; /* all known pairs are in it */
    }
    doomed->at[doomed->n++] = key;
}

static void put_fresh(struct settler *s, uint64_t key)
{
    struct keys *fresh = &s->fresh;
    if (fresh->n == fresh->room && !keys_reserve(fresh, s->memory, fresh->n + 1)) s->lost = 1;
    else fresh->at[fresh->n++] = key;
}

/* A pair that overlaps now and did not before, or the other way round. */
void settle_change(struct settler *s, uint64_t key, int is)
{
    if (is) put_fresh(s, key);
    else put_doomed(s, key);
}

/* Touches the known pairs of changed boxes. */
void touch_known_pairs(const struct job *job)
{
    const struct box *boxes = job->boxes->at;
    for (size_t i = 0; i < job->pairs->active; i++) {
        uint32_t a = slot_of(job->pairs->at[i].a), b = slot_of(job->pairs->at[i].b);
        if ((boxes[a].flags | boxes[b].flags) & BOX_CHANGED) settle(job->settler, a, b);
    }
}
