/* Sorting of 64-bit keys: end points and pairs.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A byte-wise radix sort, lowest byte first, over the bytes in which the keys
 * differ. Few keys are sorted by insertion. Without scratch memory a heap sort
 * does the same in place, more slowly, so that no sort can run out of memory. */
#include "internal.h"

int msap_keys_reserve(struct keys *k, struct memory *m, size_t need)
{
    return msap_memory_reserve(m, &k->at, &k->room, need, k->n, sizeof *k->at);
}

void msap_keys_free(struct keys *k, struct memory *m)
{
    msap_memory_free(m, k->at, k->room, sizeof *k->at);
    memset(k, 0, sizeof *k);
}

static void insertion_sort(uint64_t *key, size_t n)
{
    for (size_t i = 1; i < n; i++) {
        uint64_t moving = key[i];
        size_t at = i;
        for (; at > 0 && key[at - 1] > moving; at--) key[at] = key[at - 1];
        key[at] = moving;
    }
}

/* Lets key[at] sink to its place in the heap of n. */
static void sink(uint64_t *key, size_t at, size_t n)
{
    uint64_t moving = key[at];
    for (size_t child; (child = 2 * at + 1) < n; at = child) {
        if (child + 1 < n && key[child + 1] > key[child]) child++;
        if (key[child] <= moving) break;
        key[at] = key[child];
    }
    key[at] = moving;
}

static void heap_sort(uint64_t *key, size_t n)
{
    for (size_t i = n / 2; i-- > 0;) sink(key, i, n);
    for (size_t last = n; last-- > 1;) {
        uint64_t top = key[0];
        key[0] = key[last];
        key[last] = top;
        sink(key, 0, last);
    }
}

static void radix_pass(const uint64_t *from, uint64_t *to, size_t n, unsigned shift)
{
    size_t place[256] = {0}, sum = 0;
    for (size_t i = 0; i < n; i++) place[from[i] >> shift & 255]++;
    for (size_t d = 0; d < 256; d++) {
        size_t here = place[d];
        place[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < n; i++) to[place[from[i] >> shift & 255]++] = from[i];
}

/* Sorts key[n] upwards. scratch has room for n keys, or is NULL. */
void msap_sort_keys(uint64_t *key, size_t n, uint64_t *scratch)
{
    if (n <= 32) {
        insertion_sort(key, n);
        return;
    }
    if (!scratch) {
        heap_sort(key, n);
        return;
    }
    uint64_t differ = 0, *from = key, *to = scratch;
    for (size_t i = 1; i < n; i++) differ |= key[i] ^ key[0];
    for (unsigned shift = 0; shift < 64; shift += 8) {
        if (!(differ >> shift & 255)) continue;
        radix_pass(from, to, n, shift);
        uint64_t *swap = from;
        from = to;
        to = swap;
    }
    if (from != key) memcpy(key, from, n * sizeof *key);
}

static void wide_radix_pass(const uint64_t *from, uint64_t *to, size_t n, unsigned shift)
{
    enum { DIGITS = 1 << 11 };
    uint32_t place[DIGITS] = {0}, sum = 0;
    for (size_t i = 0; i < n; i++) place[from[i] >> shift & (DIGITS - 1)]++;
    for (size_t d = 0; d < DIGITS; d++) {
        uint32_t here = place[d];
        place[d] = sum;
        sum += here;
    }
    for (size_t i = 0; i < n; i++) to[place[from[i] >> shift & (DIGITS - 1)]++] = from[i];
}

/* Sorts fewer than 2^32 keys, whose low halves are in order, by their high halves:
 * three passes, so the result is in scratch and is copied back. */
void msap_sort_values(uint64_t *key, size_t n, uint64_t *scratch)
{
    if (n <= 32) {
        insertion_sort(key, n);
        return;
    }
    wide_radix_pass(key, scratch, n, 32);
    wide_radix_pass(scratch, key, n, 43);
    wide_radix_pass(key, scratch, n, 54);
    memcpy(key, scratch, n * sizeof *key);
}

/* Drops the repeats of a sorted array; returns how many keys are left. */
size_t msap_unique_keys(uint64_t *key, size_t n)
{
    size_t kept = 0;
    for (size_t i = 0; i < n; i++)
        if (kept == 0 || key[i] != key[kept - 1]) key[kept++] = key[i];
    return kept;
}
