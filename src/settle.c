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

static int has_room(const struct settler *s, struct keys *list)
{
    return list->n < list->room || (s->memory && keys_reserve(list, s->memory, list->n + 1));
}

/* Without memory the calling thread drops the repeats: then all known pairs fit. */
static void put_doomed(struct settler *s, uint64_t key)
{
    struct keys *doomed = &s->doomed;
    if (!has_room(s, doomed)) {
        s->lost |= !s->memory;
        if (!s->memory) return;
        sort_keys(doomed->at, doomed->n, NULL);
        doomed->n = unique_keys(doomed->at, doomed->n);
        if (doomed->n == doomed->room) return; /* this one is among them */
    }
    doomed->at[doomed->n++] = key;
}

static void put_fresh(struct settler *s, uint64_t key)
{
    if (has_room(s, &s->fresh)) s->fresh.at[s->fresh.n++] = key;
    else s->lost = 1;
}

/* A pair that overlaps now and did not before, or the other way round. */
void settle_change(struct settler *s, uint64_t key, int is)
{
    if (is) put_fresh(s, key);
    else put_doomed(s, key);
}

static void touch_known(void *context, struct worker *w, size_t first, size_t last)
{
    const struct job *job = context;
    const struct box *boxes = job->boxes->at;
    for (size_t i = first; i < last; i++) {
        uint32_t a = slot_of(job->pairs->at[i].a), b = slot_of(job->pairs->at[i].b);
        if ((boxes[a].flags | boxes[b].flags) & BOX_CHANGED) settle(&w->settler, a, b);
    }
}

/* Touches the known pairs of changed boxes. Returns 0 without memory. */
int touch_known_pairs(struct job *job)
{
    return phase_run(job->crew, job->memory, touch_known, job, job->pairs->active);
}
