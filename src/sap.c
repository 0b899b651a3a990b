/* The single SAP: brings the sorted axes up to date and touches every pair whose
 * overlap may have changed (paper, part I).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The changed boxes of a commit are leaving (stored, not live), moving (stored and
 * live) or entering (live, not stored). Three ways lead to the same arrays:
 *
 * slide   drop the end points of the leaving, slide those of the moving, merge in
 *         those of the entering;
 * merge   drop those of the leaving and the moving, merge in those of the moving
 *         and the entering;
 * sweep   make all arrays anew.
 *
 * Boxes that were merged in are new to the arrays; box pruning finds their pairs
 * in a second pass, complete among the new ones and bipartite against the others
 * (I.4c). What has ceased to overlap without sliding is found among the known
 * pairs. Memory was reserved when boxes were added. Scratch memory makes it faster,
 * and none of it fails without: then arrays are sorted in place and pruned where
 * they stand.
 *
 * When not to use it: a single SAP pays for every crossing on every axis, also of
 * boxes that are far apart on the others (II.1). */
#include "internal.h"

void msap_sap_init(struct sap *s, uint32_t dims)
{
    memset(s, 0, sizeof *s);
    s->dims = dims;
}

void msap_sap_free(struct sap *s, struct memory *m)
{
    for (uint32_t k = 0; k < 3; k++) msap_axis_free(&s->axis[k], m);
}

/* Room for boxes in slots below `slots`. */
int msap_sap_reserve(struct sap *s, struct memory *m, size_t slots)
{
    for (uint32_t k = 0; k < s->dims; k++)
        if (!msap_axis_reserve(&s->axis[k], m, slots)) return 0;
    return 1;
}

void msap_sap_trim(struct sap *s, struct memory *m, size_t slots)
{
    for (uint32_t k = 0; k < s->dims; k++) msap_axis_trim(&s->axis[k], m, slots);
}

/* ------------------------------------------------- taking out, putting in */

/* Takes the boxes without BOX_STORED out of the arrays. */
static void drop_untagged(struct sap *s, const struct job *job, size_t n_dropped)
{
    if (n_dropped == 0) return;
    for (uint32_t k = 0; k < s->dims; k++) msap_axis_drop(&s->axis[k], s->stored, job->boxes->at);
    s->stored -= n_dropped;
}

/* Tags changed boxes for removal by clearing BOX_STORED: those that are not live,
 * and with `moving` the others too. Returns how many. */
static size_t tag_changed(const struct job *job, int moving)
{
    size_t n = 0;
    for (size_t i = 0; i < job->boxes->n_changed; i++) {
        struct box *b = &job->boxes->at[job->boxes->changed[i]];
        if (!(b->flags & BOX_STORED) || ((b->flags & BOX_LIVE) && !moving)) continue;
        b->flags &= ~(uint32_t)BOX_STORED;
        n++;
    }
    return n;
}

/* Writes the keys of the changed boxes that are live and not stored. */
static size_t entering_keys(const struct job *job, uint32_t k, uint64_t *key)
{
    size_t n = 0;
    for (size_t i = 0; i < job->boxes->n_changed; i++) {
        uint32_t slot = job->boxes->changed[i];
        const struct box *b = &job->boxes->at[slot];
        if ((b->flags & (BOX_LIVE | BOX_STORED)) != BOX_LIVE) continue;
        key[n++] = key_make(b->now.min[k], 0, slot);
        key[n++] = key_make(b->now.max[k], 1, slot);
    }
    return n;
}

static size_t mark_entering_new(const struct job *job)
{
    size_t n = 0;
    for (size_t i = 0; i < job->boxes->n_changed; i++) {
        struct box *b = &job->boxes->at[job->boxes->changed[i]];
        if ((b->flags & (BOX_LIVE | BOX_STORED)) != BOX_LIVE) continue;
        b->flags |= BOX_STORED | BOX_NEW;
        n++;
    }
    return n;
}

/* Puts the live boxes that are not stored into the arrays and marks them new. */
static void insert_entering(struct sap *s, const struct job *job)
{
    size_t n = 0;
    uint64_t *scratch = msap_scratch_get(job->scratch, job->memory, SCRATCH_WORDS(job->boxes->used));
    for (uint32_t k = 0; k < s->dims; k++) {
        struct axis *x = &s->axis[k];
        uint64_t *incoming = scratch ? scratch : x->key + 1 + 2 * s->stored;
        n = entering_keys(job, k, incoming);
        if (scratch) {
            msap_sort_keys(incoming, n, incoming + n);
            msap_axis_merge(x, s->stored, incoming, n);
        } else msap_axis_sort(x, s->stored + n / 2, NULL);
    }
    s->stored += n / 2;
    mark_entering_new(job);
}

/* Fills the arrays anew with all live boxes and marks them new. */
static void rebuild(struct sap *s, const struct job *job)
{
    struct box_table *t = job->boxes;
    s->stored = t->live;
    for (uint32_t k = 0; k < s->dims; k++) {
        uint64_t *key = s->axis[k].key + 1;
        size_t n = 0;
        for (uint32_t slot = 0; slot < t->used; slot++) {
            if (!(t->at[slot].flags & BOX_LIVE)) continue;
            key[n++] = key_make(t->at[slot].now.min[k], 0, slot);
            key[n++] = key_make(t->at[slot].now.max[k], 1, slot);
        }
        msap_axis_sort(&s->axis[k], s->stored,
                       msap_scratch_get(job->scratch, job->memory, SCRATCH_WORDS(t->used)));
    }
    for (uint32_t slot = 0; slot < t->used; slot++) {
        uint8_t *flags = &t->at[slot].flags;
        if (*flags & BOX_LIVE) *flags |= BOX_STORED | BOX_NEW;
        else *flags &= ~(uint32_t)BOX_STORED;
    }
}

/* ------------------------------------------------------------------ pruning */

/* The axis on which the new boxes span the fewest end points: what the ranks say
 * about the length of a sweep, instead of a variance. */
static uint32_t sweep_axis(const struct sap *s, const struct job *job)
{
    uint64_t span[3] = {0, 0, 0};
    uint32_t best = 0;
    for (uint32_t slot = 0; slot < job->boxes->used; slot++)
        if (job->boxes->at[slot].flags & BOX_NEW)
            for (uint32_t k = 0; k < s->dims; k++)
                span[k] += s->axis[k].rank[2 * slot + 1] - s->axis[k].rank[2 * slot];
    for (uint32_t k = 1; k < s->dims; k++)
        if (span[k] < span[best]) best = k;
    return best;
}

static void touch(void *context, uint32_t a, uint32_t b) { settle(context, a, b); }

/* Splits the stored boxes, in the order of their mins on axis k, into new and old. */
static void split_new(const struct sap *s, const struct job *job, uint32_t k, struct prune_set *fresh,
                      struct prune_set *old)
{
    size_t n_fresh = 0, n_old = 0;
    for (size_t i = 1; i <= 2 * s->stored; i++) {
        uint64_t key = s->axis[k].key[i];
        if (key & KEY_MAX_BIT) continue;
        const struct box *b = &job->boxes->at[key_box(key)];
        if (b->flags & BOX_NEW) msap_prune_set_put(fresh, n_fresh++, &b->now, k, key_box(key));
        else msap_prune_set_put(old, n_old++, &b->now, k, key_box(key));
    }
}

/* Without scratch: sweeps the axis itself, key by key. */
static void prune_in_place(const struct sap *s, const struct job *job, uint32_t k)
{
    const struct axis *x = &s->axis[k];
    for (size_t i = 1; i <= 2 * s->stored; i++) {
        uint32_t a = key_box(x->key[i]);
        if (x->key[i] & KEY_MAX_BIT) continue;
        for (size_t j = i + 1; j < x->rank[2 * a + 1]; j++) {
            uint32_t b = key_box(x->key[j]);
            if (!(x->key[j] & KEY_MAX_BIT) && ((job->boxes->at[a].flags | job->boxes->at[b].flags) & BOX_NEW))
                settle(&job->worker->settler, a, b);
        }
    }
}

/* Touches every pair of a new box with any box that it overlaps now. */
static void prune_new(const struct sap *s, const struct job *job, size_t n_new)
{
    if (n_new == 0) return;
    uint32_t k = sweep_axis(s, job);
    size_t n_old = s->stored - n_new;
    uint64_t *words = msap_scratch_get(job->scratch, job->memory, SCRATCH_WORDS(job->boxes->used));
    if (!words) {
        prune_in_place(s, job, k);
        return;
    }
    struct prune_set fresh, old;
    msap_prune_set_place(&fresh, words, n_new);
    msap_prune_set_place(&old, words + PRUNE_SET_WORDS(n_new), n_old);
    split_new(s, job, k, &fresh, &old);
    msap_prune_within(&fresh, touch, &job->worker->settler);
    msap_prune_between(&fresh, &old, touch, &job->worker->settler);
}

static size_t clear_new(struct box_table *t)
{
    size_t n = 0;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        n += (t->at[slot].flags & BOX_NEW) != 0;
        t->at[slot].flags &= ~(uint32_t)BOX_NEW;
    }
    return n;
}

/* ----------------------------------------------------------------- updating */

static void slide_moving(struct sap *s, const struct job *job)
{
    const struct box_table *t = job->boxes;
    for (uint32_t k = 0; k < s->dims; k++)
        for (size_t i = 0; i < t->n_changed; i++)
            if (t->at[t->changed[i]].flags & BOX_STORED) msap_axis_slide(s, k, t->changed[i], job);
}

/* Brings the axes up to date by one of the strategies (not AUTO). */
void msap_sap_update(struct sap *s, struct job *job, uint32_t strategy)
{
    size_t n_tagged = 0, n_before;
    if (strategy != MSAP_STRATEGY_SWEEP) {
        n_tagged = tag_changed(job, strategy == MSAP_STRATEGY_MERGE);
        drop_untagged(s, job, n_tagged);
    }
    if (strategy == MSAP_STRATEGY_SLIDE) slide_moving(s, job);
    n_before = s->stored;
    if (strategy == MSAP_STRATEGY_SWEEP) {
        n_before = 0;
        rebuild(s, job);
    } else if (job->boxes->live > s->stored) insert_entering(s, job);
    prune_new(s, job, s->stored - n_before);
    if (s->stored > n_before) clear_new(job->boxes);
    if (n_tagged > 0 || strategy == MSAP_STRATEGY_SWEEP) msap_touch_known_pairs(job);
}

/* ----------------------------------------------------------------- choosing */

static uint64_t distance(const struct axis *x, size_t stored, uint64_t key)
{
    size_t low = 1, high = 2 * stored + 1, from = x->rank[key_end(key)];
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (x->key[middle] < key) low = middle + 1;
        else high = middle;
    }
    return low > from ? low - from : from - low;
}

/* How many places the end points of all moving boxes have to slide, estimated from
 * some of them. */
static uint64_t estimate_slide(const struct sap *s, const struct box_table *t)
{
    enum { SAMPLES = 64 };
    uint64_t sum = 0;
    size_t step = t->n_changed / SAMPLES + 1;
    for (size_t i = 0; i < t->n_changed; i += step) {
        uint32_t slot = t->changed[i];
        const struct box *b = &t->at[slot];
        if ((b->flags & (BOX_STORED | BOX_LIVE)) != (BOX_STORED | BOX_LIVE)) continue;
        for (uint32_t k = 0; k < s->dims; k++)
            sum += distance(&s->axis[k], s->stored, key_make(b->now.min[k], 0, slot)) +
                   distance(&s->axis[k], s->stored, key_make(b->now.max[k], 1, slot));
    }
    return sum * step; /* each stands for so many */
}

/* The strategy with the least estimated cost. One place of sliding counts 1; merging
 * moves every end point once and prunes the changed boxes; sweeping sorts and prunes
 * all. Weights from bench/strategies. */
uint32_t msap_sap_choose(const struct sap *s, const struct job *job)
{
    const struct box_table *t = job->boxes;
    uint64_t end_points = 2 * (uint64_t)s->dims * s->stored;
    uint64_t slide = estimate_slide(s, t);
    uint64_t merge = 2 * end_points + 64 * (uint64_t)t->n_changed;
    uint64_t sweep = 16 * 2 * (uint64_t)s->dims * t->live;
    if (slide <= merge && slide <= sweep) return MSAP_STRATEGY_SLIDE;
    return merge <= sweep ? MSAP_STRATEGY_MERGE : MSAP_STRATEGY_SWEEP;
}

/* The first broken invariant of the arrays, or NULL. */
const char *msap_sap_broken(const struct sap *s, const struct box_table *boxes)
{
    size_t stored = 0;
    for (size_t slot = 0; slot < boxes->used; slot++) stored += (boxes->at[slot].flags & BOX_STORED) != 0;
    if (stored != s->stored) return "the axes hold another number of boxes than are stored";
    for (uint32_t k = 0; k < s->dims; k++) {
        const char *broken = msap_axis_broken(&s->axis[k], s->stored, boxes, k);
        if (broken) return broken;
    }
    return NULL;
}
