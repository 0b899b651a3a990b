/* Sorting by all workers: each sorts a part of the keys, and the parts are merged.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

/* A sort at work: of keys as they are or, with an extent, of values (sort.c). */
struct sorting {
    uint64_t *key, *scratch;
    int are_values;
    float low, extent;
};

static void sort_part(void *context, struct worker *w, size_t first, size_t last)
{
    const struct sorting *s = context;
    (void)w;
    if (s->are_values) msap_sort_values(s->key + first, last - first, s->scratch + 2 * first, s->low, s->extent);
    else msap_sort_keys(s->key + first, last - first, s->scratch ? s->scratch + first : NULL);
}

/* Merges n sorted keys with the sorted keys behind them, up to `end`, without a question: which of two
 * is less follows no pattern. */
static void merge(uint64_t *key, size_t n, size_t end, uint64_t *scratch)
{
    size_t i = 0, j = n, to = 0;
    memcpy(scratch, key, n * sizeof *key);
    while (i < n && j < end) {
        uint64_t a = scratch[i], b = key[j];
        size_t is_first = a <= b;
        key[to++] = is_first ? a : b;
        i += is_first;
        j += !is_first;
    }
    memcpy(key + to, scratch + i, (n - i) * sizeof *key);
}

/* Where part i of so many of n keys starts, as phase_run cuts them. */
static size_t start_of(size_t n, size_t i, size_t parts) { return n * (i < parts ? i : parts) / parts; }

static void sort(const struct job *job, const struct sorting *s, size_t n)
{
    struct sorting own = *s;
    size_t parts = s->scratch ? msap_phase_tasks(job->crew, n, WEIGHT_SORT) : 0;
    if (n == 0) return; /* there may be no array */
    if (parts < 2) {
        sort_part(&own, job->worker, 0, n);
        return;
    }
    msap_phase_run(job->crew, job->memory, sort_part, &own, n, WEIGHT_SORT); /* it finds nothing */
    for (size_t apart = 1; apart < parts; apart *= 2)
        for (size_t i = 0; i + apart < parts; i += 2 * apart) {
            size_t first = start_of(n, i, parts), middle = start_of(n, i + apart, parts);
            merge(s->key + first, middle - first, start_of(n, i + 2 * apart, parts) - first, s->scratch);
        }
}

/* As msap_sort_keys. */
void msap_share_sort_keys(const struct job *job, uint64_t *key, size_t n, uint64_t *scratch)
{
    const struct sorting s = {key, scratch, 0, 0, 0};
    sort(job, &s, n);
}

/* As msap_sort_values. */
void msap_share_sort_values(const struct job *job, uint64_t *key, size_t n, uint64_t *scratch, float low,
                            float extent)
{
    const struct sorting s = {key, scratch, 1, low, extent};
    sort(job, &s, n);
}
