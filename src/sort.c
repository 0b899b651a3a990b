/* Sorting of 64-bit keys: end points and pairs.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A radix sort, lowest digit first, over the upper of the bits in which the keys differ:
 * of n keys that are spread over their range, log2 n bits and a few more tell nearly all
 * apart. What is then still out of order is inserted; where that is much, the keys are
 * not spread so, and all bits are sorted by; or, of some hundred keys, a heap. Few keys
 * are sorted by insertion alone.
 * The bits of floats are not spread even where the floats are: half of all patterns are for
 * what lies between -1 and 1. So values are sorted by their steps along a line.
 * Without scratch memory a heap sort does the same in place, more slowly, so that no sort
 * can run out of memory. */
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

/* Sorts by insertion, which moves keys by at most `most` places in all, and by those of one
 * key more. Returns 0 if that was not enough. */
static int insertion_sort(uint64_t *key, size_t n, size_t most)
{
    size_t moved = 0;
    for (size_t i = 1; i < n; i++) {
        uint64_t moving = key[i];
        size_t at = i;
        if (key[at - 1] <= moving) continue;
        for (; at > 0 && key[at - 1] > moving; at--) key[at] = key[at - 1];
        key[at] = moving;
        moved += i - at;
        if (moved > most) return 0;
    }
    return 1;
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

/* How the keys differ: in so many bits at the low ends of their halves, and in none above; 0
 * and 0 if they are in order. */
struct difference {
    unsigned low, high;
};

static unsigned bits_in(uint32_t value)
{
    unsigned n = 0;
    for (; value > 0; value >>= 1) n++;
    return n;
}

static struct difference difference_of(const uint64_t *key, size_t n)
{
    uint64_t differ = 0;
    int is_in_order = 1;
    for (size_t i = 1; i < n; i++) {
        differ |= key[i] ^ key[0];
        is_in_order &= key[i - 1] <= key[i];
    }
    if (is_in_order) differ = 0;
    struct difference d = {bits_in((uint32_t)differ), bits_in((uint32_t)(differ >> 32))};
    return d;
}

enum { DIGIT_MOST = 12 /* bits: the places of all digits stay in the cache */ };

/* A key without the bits that are the same in both halves of all keys, which differ in `low` bits of the
 * lower one. */
static inline uint64_t packed(uint64_t key, unsigned low)
{
    return key >> 32 << low | (key & (((uint64_t)1 << low) - 1));
}

/* Some bits of packed keys: those of the mask, from one on. */
struct digit {
    unsigned shift;
    size_t mask;
};

/* The next of so many digits that share the bits from *shift on, which becomes where it ends. */
static struct digit next_digit(unsigned *shift, unsigned all, unsigned digits)
{
    unsigned bits = digits > 0 ? (all - *shift + digits - 1) / digits : 0;
    struct digit d = {*shift, ((size_t)1 << bits) - 1};
    *shift += bits;
    return d;
}

static inline size_t digit_of(uint64_t packed_key, struct digit d)
{
    return (size_t)(packed_key >> d.shift) & d.mask;
}

/* Turns how many keys have each digit into where the first of them goes. */
static void place_digits(uint32_t *place, size_t digits)
{
    uint32_t sum = 0;
    for (size_t d = 0; d < digits; d++) {
        uint32_t here = place[d];
        place[d] = sum;
        sum += here;
    }
}

/* Counts how many keys have each digit. */
static void count_digits(const uint64_t *key, size_t n, unsigned low, struct digit d, uint32_t *count)
{
    memset(count, 0, (d.mask + 1) * sizeof *count);
    for (size_t i = 0; i < n; i++) count[digit_of(packed(key[i], low), d)]++;
}

/* Orders by a digit, keeping the order of keys with the same. */
static void place_keys(const uint64_t *from, uint64_t *to, size_t n, unsigned low, struct digit d, uint32_t *place)
{
    for (size_t i = 0; i < n; i++) to[place[digit_of(packed(from[i], low), d)]++] = from[i];
}

/* The same, and counts the next digit meanwhile. */
static void place_and_count(const uint64_t *from, uint64_t *to, size_t n, unsigned low, struct digit d,
                            uint32_t *place, struct digit next, uint32_t *count)
{
    memset(count, 0, (next.mask + 1) * sizeof *count);
    for (size_t i = 0; i < n; i++) {
        uint64_t key = packed(from[i], low);
        to[place[digit_of(key, d)]++] = from[i];
        count[digit_of(key, next)]++;
    }
}

/* Orders by the upper `bits`, of `all` in which keys differ, `low` of them in the low halves. */
static void radix_sort(uint64_t *key, size_t n, uint64_t *scratch, unsigned low, unsigned all, unsigned bits)
{
    uint32_t places[2][1 << DIGIT_MOST], *place = places[0], *count = places[1];
    unsigned passes = (bits + DIGIT_MOST - 1) / DIGIT_MOST, shift = all - bits;
    uint64_t *from = key, *to = scratch;
    if (passes == 0) return;
    struct digit d = next_digit(&shift, all, passes);
    count_digits(key, n, low, d, place);
    for (; passes > 0; passes--) {
        struct digit next = next_digit(&shift, all, passes - 1);
        place_digits(place, d.mask + 1);
        if (passes > 1) place_and_count(from, to, n, low, d, place, next, count);
        else place_keys(from, to, n, low, d, place);
        uint64_t *swap = from;
        uint32_t *swap_place = place;
        from = to;
        to = swap;
        place = count;
        count = swap_place;
        d = next;
    }
    if (from != key) memcpy(key, from, n * sizeof *key);
}

enum { FEW = 32, PLACES = 2 /* for a key, that others move when it is inserted */ };

/* Sorts so many keys that are not spread over their range. */
static void sort_lumped(uint64_t *key, size_t n, uint64_t *scratch, struct difference d)
{
    enum { NOT_WORTH_ALL_BITS = 512 };
    if (n <= NOT_WORTH_ALL_BITS) heap_sort(key, n);
    else radix_sort(key, n, scratch, d.low, d.low + d.high, d.low + d.high);
}

/* Sorts key[n] upwards, n below 2^32. scratch has room for n keys, or is NULL. */
void msap_sort_keys(uint64_t *key, size_t n, uint64_t *scratch)
{
    enum { MORE_BITS = 7 };
    if (n <= FEW) insertion_sort(key, n, SIZE_MAX);
    else if (!scratch) heap_sort(key, n);
    else {
        struct difference d = difference_of(key, n);
        unsigned all = d.low + d.high, enough = bits_in((uint32_t)n) + MORE_BITS;
        radix_sort(key, n, scratch, d.low, all, all < enough ? all : enough);
        if (!insertion_sort(key, n, PLACES * n)) sort_lumped(key, n, scratch, d);
    }
}

/* The same, of keys that are in order, but for a few places each. */
void msap_sort_nearly_sorted(uint64_t *key, size_t n, uint64_t *scratch)
{
    enum { MOST_PLACES = 16 };
    if (!insertion_sort(key, n, MOST_PLACES * n)) msap_sort_keys(key, n, scratch);
}

/* ------------------------------------------------------------------ values */

enum { STEP_DIGIT = 11 /* bits at the most */ };

/* Steps of values along a line: `scale` to a unit from `low` on, 0 to `last`. */
struct line {
    float low, scale, last;
};

/* The value of a key_make. A higher one has no lower step, however the machine rounds. */
static inline uint32_t step_of(struct line line, uint64_t key)
{
    float step = (float_from_bits(float_bits_from_ordered(key_value(key))) - line.low) * line.scale;
    step = step > 0 ? step : 0;
    return (uint32_t)(step < line.last ? step : line.last);
}

/* Whether most of some of the keys lie between the ends of the line: boxes may have gone elsewhere since it was
 * drawn. */
static int are_on(struct line line, const uint64_t *key, size_t n)
{
    enum { SAMPLES = 16 };
    size_t step = n / SAMPLES + 1, on = 0, off = 0;
    for (size_t i = 0; i < n; i += step) {
        uint32_t at = step_of(line, key[i]);
        if (at > 0 && at < (uint32_t)line.last) on++;
        else off++;
    }
    return on > off;
}

/* Orders by steps of two digits of so many bits: by the lower digit, then by the upper one. scratch has room
 * for 2 n, which is fetched in order before it is written here and there. */
static void sort_by_steps(uint64_t *key, size_t n, uint64_t *scratch, struct line line, unsigned digit)
{
    uint32_t lower[1 << STEP_DIGIT], upper[1 << STEP_DIGIT], digits = 1u << digit, mask = digits - 1;
    uint32_t *step = (uint32_t *)(void *)(scratch + n), *sorted_step = step + n;
    memset(lower, 0, digits * sizeof *lower);
    memset(upper, 0, digits * sizeof *upper);
    for (size_t i = 0; i < n; i++) {
        prefetch(scratch + i);
        prefetch(sorted_step + i);
        step[i] = step_of(line, key[i]);
        lower[step[i] & mask]++;
        upper[step[i] >> digit]++;
    }
    place_digits(lower, digits);
    place_digits(upper, digits);
    for (size_t i = 0; i < n; i++) {
        uint32_t at = lower[step[i] & mask]++;
        scratch[at] = key[i];
        sorted_step[at] = step[i];
    }
    for (size_t i = 0; i < n; i++) key[upper[sorted_step[i] >> digit]++] = scratch[i];
}

/* Sorts keys that are values above and slots below, as key_make has them, the slots being in order.
 * Most values lie within `extent` from `low` on. scratch has room for 2 n. */
void msap_sort_values(uint64_t *key, size_t n, uint64_t *scratch, float low, float extent)
{
    enum { MORE_BITS = 4 };
    const float least = 1e-30f, most = 1e30f;
    unsigned digit = (bits_in((uint32_t)n) + MORE_BITS + 1) / 2;
    if (n > FEW && digit <= STEP_DIGIT && extent > least && extent < most) {
        float steps = (float)(1u << 2 * digit);
        struct line line = {low, steps / extent, steps - 1};
        if (are_on(line, key, n)) {
            sort_by_steps(key, n, scratch, line, digit);
            if (insertion_sort(key, n, PLACES * n)) return;
        }
    }
    msap_sort_keys(key, n, scratch);
}

/* Drops the repeats of a sorted array, which has none mostly; returns how many keys are left. */
size_t msap_unique_keys(uint64_t *key, size_t n)
{
    size_t last = 0;
    if (n == 0) return 0;
    while (last + 1 < n && key[last] != key[last + 1]) last++;
    for (size_t i = last + 1; i < n; i++)
        if (key[i] != key[last]) key[++last] = key[i];
    return last + 1;
}
