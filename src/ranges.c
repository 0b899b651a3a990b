/* In which rows boxes are, and how many boxes are in each: step 1 of rows.c.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Of some boxes at a time it is found in which rows they are and in which they were; then those are chosen that
 * are to be listed, all or, where rows are kept (kept.c), those that are in others now; and these are counted. So
 * each loop is short, and asks little that no processor can guess. */
#include "rows.h"

/* What a worker has counted of the slots from the first on. */
struct counted {
    size_t first, n_listed, n_wide, changed, leaving; /* entries that are not kept */
    uint32_t *end;                                    /* [rows] boxes that are listed; NULL: it was not at work */
};

/* Counting at work. */
struct counting {
    const struct pruning *pruning;
    const struct row_range *last; /* [had] where boxes were */
    size_t had;
    struct counted by[1 + MOST_WORKERS];
};

/* Counts a box in its rows, where it touches two on each axis at the most: without a question. */
static inline void count_in_few(const struct rows *r, const struct row_range *range, uint32_t *end)
{
    uint32_t row = range->row, more_y = range->more[0], more_z = range->more[1];
    end[row]++;
    end[next_row(r, row)] += more_y;
    if (r->count[1] == 1) return;
    row = next_line(r, row);
    end[row] += more_z;
    end[next_row(r, row)] += more_y & more_z;
}

static void count_in_many(const struct rows *r, const struct row_range *range, uint32_t *end)
{
    for (uint32_t z = 0, row = range->row; z <= range->more[1]; z++, row = next_line(r, row))
        for (uint32_t y = 0, at = row; y <= range->more[0]; y++, at = next_row(r, at)) end[at]++;
}

static const struct row_range IN_NO_ROW = {NO_ROW, {0, 0}, 0}, IS_WIDE = {NO_ROW, {1, 1}, 0};

/* In which rows a box is, if it has the flags asked for and is not wide. */
static inline struct row_range range_of_box(const struct rows *r, const struct box *b, const struct bounds *bounds,
                                            uint32_t asked)
{
    if ((b->flags & asked) != asked) return IN_NO_ROW;
    const struct row_span s = rows_of(r, bounds);
    const struct row_range range = {
        s.row, {(uint8_t)s.more[0], (uint8_t)s.more[1]}, (uint16_t)(b->flags & BOX_STATIC)};
    if ((s.more[0] | s.more[1]) <= 1) return range;
    return rows_in(&s) <= MOST_ROWS ? range : IS_WIDE;
}

/* Four boxes, and what is pruned as their bounds. */
struct four_boxes {
    const struct box *box[4];
    const struct bounds *bounds[4];
};

/* Those of four slots; and those from a slot on. */
static ALWAYS_INLINE struct four_boxes four_of_slots(const struct pruning *j, const uint32_t slot[4])
{
    const struct box *box = j->job->boxes->at;
    const struct bounds_by_slot *all = &j->bounds;
    const struct four_boxes f = {{box + slot[0], box + slot[1], box + slot[2], box + slot[3]},
                                 {bounds_of_slot(all, slot[0]), bounds_of_slot(all, slot[1]),
                                  bounds_of_slot(all, slot[2]), bounds_of_slot(all, slot[3])}};
    return f;
}
static ALWAYS_INLINE struct four_boxes four_from_slot(const struct pruning *j, uint32_t slot)
{
    const struct box *box = &j->job->boxes->at[slot];
    const struct bounds_by_slot from = {bounds_of_slot(&j->bounds, slot), j->bounds.step, 0};
    const struct four_boxes f = {
        {box, box + 1, box + 2, box + 3},
        {bounds_of_slot(&from, 0), bounds_of_slot(&from, 1), bounds_of_slot(&from, 2), bounds_of_slot(&from, 3)}};
    return f;
}

#if defined(__SSE2__)
static ALWAYS_INLINE __m128i value_at(const struct bounds *b, size_t at)
{
    return _mm_cvtsi32_si128((int32_t)load_bits((const char *)b + at));
}

/* A value of each of four bounds, so many bytes from their start. */
static ALWAYS_INLINE __m128i values_at(const struct bounds *const b[4], size_t at)
{
    return _mm_unpacklo_epi64(_mm_unpacklo_epi32(value_at(b[0], at), value_at(b[1], at)),
                              _mm_unpacklo_epi32(value_at(b[2], at), value_at(b[3], at)));
}

/* On an axis across: in which row each of four boxes starts; *more becomes in how many more it is. */
static ALWAYS_INLINE __m128i starts_of_four(const struct rows *r, int k, const struct bounds *const bounds[4],
                                            __m128i *more)
{
    __m128 scale = _mm_set1_ps(r->scale[k]);
    size_t at = r->axis[k + 1] * sizeof(int32_t);
    __m128i low = units_lanes(scale, values_at(bounds, offsetof(struct bounds, min) + at));
    __m128i high = units_lanes(scale, values_at(bounds, offsetof(struct bounds, max) + at));
    *more = _mm_sub_epi32(high, low);
    return _mm_and_si128(low, _mm_set1_epi32((int32_t)r->count[k] - 1));
}

/* In which rows four boxes are, the bounds of which are read even if they lack a flag. Returns 0 if one of them
 * does, or touches more than two on an axis; then what stands there means nothing. */
static ALWAYS_INLINE int ranges_of_four(const struct rows *r, const struct four_boxes *f, uint32_t asked,
                                        struct row_range range[4])
{
    const struct box *const *b = f->box;
    __m128i more_y, more_z, y = starts_of_four(r, 0, f->bounds, &more_y),
                            z = starts_of_four(r, 1, f->bounds, &more_z);
    __m128i flags = _mm_set_epi32(b[3]->flags, b[2]->flags, b[1]->flags, b[0]->flags);
    __m128i lacks = _mm_andnot_si128(flags, _mm_set1_epi32((int32_t)asked)),
            are_many = _mm_srli_epi32(_mm_or_si128(more_y, more_z), 1);
    __m128i row = _mm_add_epi32(_mm_sll_epi32(z, _mm_cvtsi32_si128((int)r->shift)), y);
    __m128i is_static = _mm_slli_epi32(_mm_and_si128(flags, _mm_set1_epi32(BOX_STATIC)), 16);
    __m128i rest = _mm_or_si128(_mm_or_si128(more_y, _mm_slli_epi32(more_z, 8)), is_static);
    _mm_storeu_si128((__m128i *)(void *)range, _mm_unpacklo_epi32(row, rest));
    _mm_storeu_si128((__m128i *)(void *)(range + 2), _mm_unpackhi_epi32(row, rest));
    return _mm_movemask_epi8(_mm_cmpeq_epi32(_mm_or_si128(lacks, are_many), _mm_setzero_si128())) == 0xffff;
}
#else
/* The same, where it may touch more. */
static int ranges_of_four(const struct rows *r, const struct four_boxes *f, uint32_t asked,
                          struct row_range range[4])
{
    int are_in = 1;
    for (int i = 0; i < 4; i++) {
        range[i] = range_of_box(r, f->box[i], f->bounds[i], asked);
        are_in &= range[i].row != NO_ROW;
    }
    return are_in;
}
#endif

enum { AT_ONCE = 64 };

/* Some boxes: in which rows they are and were. */
struct some_boxes {
    uint32_t slot[AT_ONCE];
    size_t n;
    struct row_range now[AT_ONCE], before[AT_ONCE];
    uint32_t listed[AT_ONCE]; /* [n_listed] those that are to be listed, by index */
    size_t n_listed;
};

static inline int is_in_same(const struct row_range *a, const struct row_range *b, size_t n)
{
    return memcmp(a, b, n * sizeof *a) == 0;
}

/* Finds in which rows they are, and names the wide ones. If they are in order, they are all from one slot on. */
static ALWAYS_INLINE void find_ranges(const struct pruning *j, struct counted *c, struct some_boxes *some,
                                      int are_in_order)
{
    const struct rows rows_now = *j->rows, *r = &rows_now;
    const uint32_t *slot = some->slot, asked = j->bounds.flags;
    for (size_t i = 0, n = some->n; i < n; i += 4) {
        if (n - i >= 4) {
            const struct four_boxes f = are_in_order ? four_from_slot(j, slot[i]) : four_of_slots(j, slot + i);
            if (ranges_of_four(r, &f, asked, some->now + i)) continue;
        }
        for (size_t k = i; k < n && k < i + 4; k++) {
            some->now[k] =
                range_of_box(r, &j->job->boxes->at[slot[k]], bounds_of_slot(&j->bounds, slot[k]), asked);
            if (is_in_same(&some->now[k], &IS_WIDE, 1)) j->wide[c->first + c->n_wide++] = slot[k];
        }
    }
}

/* Finds in which they were, and notes in which they are: all from one slot on. */
static void exchange_ranges(const struct counting *all, struct some_boxes *some)
{
    size_t slot = some->slot[0], n = some->n, known = slot < all->had ? all->had - slot : 0;
    if (known > n) known = n;
    if (known > 0) memcpy(some->before, all->last + slot, known * sizeof *some->before);
    for (size_t i = known; i < n; i++) some->before[i] = IN_NO_ROW;
    memcpy(all->pruning->range + slot, some->now, n * sizeof *some->now);
}

/* How many entries name a box in the rows that it is in. */
static inline size_t entries_of(const struct row_range *range)
{
    return range->row == NO_ROW ? 0 : (size_t)(range->more[0] + 1) * (size_t)(range->more[1] + 1);
}

/* Where rows are kept: lists those that are in others than they were. */
static void list_moved(const struct pruning *j, struct counted *c, struct some_boxes *some)
{
    uint8_t *has_moved = j->has_moved + some->slot[0];
    size_t n = 0;
    memset(has_moved, 0, some->n);
    for (size_t i = 0; i < some->n; i++) {
        if (some->n - i >= 4 && is_in_same(some->now + i, some->before + i, 4)) {
            i += 3;
            continue;
        }
        int is_same = is_in_same(some->now + i, some->before + i, 1);
        has_moved[i] = (uint8_t)!is_same;
        c->changed += (size_t)!is_same;
        c->leaving += is_same ? 0 : entries_of(&some->before[i]);
        some->listed[n] = (uint32_t)i;
        n += !is_same & (some->now[i].row != NO_ROW);
    }
    some->n_listed = n;
}

/* Where they are made anew: lists all. */
static void list_all(struct some_boxes *some)
{
    size_t n = 0;
    for (size_t i = 0; i < some->n; i++) {
        some->listed[n] = (uint32_t)i;
        n += some->now[i].row != NO_ROW;
    }
    some->n_listed = n;
}

/* How many are in others than they were. */
static size_t count_moved(const struct some_boxes *some)
{
    size_t n = 0;
    for (size_t i = 0; i < some->n; i++) n += !is_in_same(some->now + i, some->before + i, 1);
    return n;
}

/* Counts those that are listed, each in the rows that it is in. */
static void count_listed(const struct pruning *j, struct counted *c, const struct some_boxes *some)
{
    const struct rows rows_now = *j->rows, *r = &rows_now;
    const struct bounds_by_slot all = j->bounds;
    uint64_t *order = j->order + c->first + c->n_listed;
    uint32_t *end = c->end, sweep_axis = r->axis[0];
    for (size_t i = 0, n = some->n_listed; i < n; i++) {
        uint32_t k = some->listed[i], slot = some->slot[k];
        const struct row_range *now = &some->now[k];
        if ((now->more[0] | now->more[1]) <= 1) count_in_few(r, now, end);
        else count_in_many(r, now, end);
        order[i] = key_make(bounds_of_slot(&all, slot)->min[sweep_axis], 0, slot);
    }
    c->n_listed += some->n_listed;
}

/* Finds the rows of the boxes in slots first ... last - 1, counts those that are listed in each row, and names
 * the wide ones in the worker's part of the list. */
static void count_some(void *context, struct worker *w, size_t first, size_t last)
{
    struct counting *all = context;
    const struct pruning *j = all->pruning;
    size_t worker = (size_t)(w - j->job->crew->worker), rows = (size_t)j->rows->count[0] * j->rows->count[1];
    struct counted c = {first, 0, 0, 0, 0, worker == 0 ? j->end : j->end_by + (worker - 1) * rows};
    struct some_boxes some;
    memset(c.end, 0, rows * sizeof *c.end);
    for (size_t slot = first; slot < last; slot += some.n) {
        some.n = last - slot < AT_ONCE ? last - slot : AT_ONCE;
        for (size_t i = 0; i < AT_ONCE; i += 4) count_four(some.slot + i, (uint32_t)(slot + i));
        find_ranges(j, &c, &some, 1);
        exchange_ranges(all, &some);
        if (j->has_moved) {
            list_moved(j, &c, &some);
        } else {
            c.changed += count_moved(&some);
            list_all(&some);
        }
        count_listed(j, &c, &some);
    }
    all->by[worker] = c;
}

/* Adds what the workers have counted up. */
static void add_up(struct pruning *j, const struct counting *all)
{
    size_t rows = (size_t)j->rows->count[0] * j->rows->count[1];
    if (!all->by[0].end) memset(j->end, 0, rows * sizeof *j->end);
    for (uint32_t i = 0; i <= MOST_WORKERS; i++) {
        const struct counted *c = &all->by[i];
        if (!c->end) continue;
        if (c->first > j->n_listed)
            memmove(j->order + j->n_listed, j->order + c->first, c->n_listed * sizeof *j->order);
        memmove(j->wide + j->n_wide, j->wide + c->first, c->n_wide * sizeof *j->wide);
        j->n_listed += c->n_listed;
        j->n_wide += c->n_wide;
        j->set->changed += c->changed;
        j->entries -= c->leaving;
        for (size_t row = 0; i > 0 && row < rows; row++) j->end[row] += c->end[row];
    }
    for (size_t row = 0; row < rows; row++) j->entries += j->end[row];
}

/* ---------------------------------------------------------------- the whole */

/* Of very many boxes no set knows where they are. */
static int are_known(size_t slots) { return slots <= VERY_MANY_BOXES; }

/* How many words the arrays take. */
static size_t words_of(const struct pruning *j, int keeps)
{
    size_t slots = j->slots, rows = (size_t)j->rows->count[0] * j->rows->count[1];
    size_t ends = rows * msap_phase_tasks(j->job->crew, slots, WEIGHT_ROWS);
    return slots + (are_known(slots) ? 0 : slots) + slots / 2 + 1 + ends / 2 + 1 +
           (keeps ? msap_kept_words(j) : 0);
}

/* Places the arrays in the memory of `words`, which grows as needed, and in the set, of which so many ranges are
 * still to be read. Returns 0 without memory. */
static int place_arrays(struct pruning *j, struct scratch *words, size_t had, int keeps)
{
    struct memory *m = j->job->memory;
    struct row_set *set = j->set;
    size_t slots = j->slots, rows = (size_t)j->rows->count[0] * j->rows->count[1];
    uint64_t *at = msap_scratch_get(words, m, words_of(j, keeps));
    if (!at || !msap_memory_reserve(m, &set->end, &set->room_end, rows, 0, sizeof *set->end)) return 0;
    if (are_known(slots) && !msap_memory_reserve(m, &set->range, &set->room_range, slots, had, sizeof *set->range))
        return 0;
    j->order = at;
    j->range = are_known(slots) ? set->range : (struct row_range *)(void *)(at + slots);
    at += are_known(slots) ? slots : 2 * slots;
    j->wide = (uint32_t *)(void *)at;
    j->end = set->end;
    at += slots / 2 + 1;
    j->end_by = (uint32_t *)(void *)(keeps ? msap_kept_place(j, at) : at);
    return 1;
}

/* Finds the rows of n boxes, counts them in these, and names the wide ones. */
static void count_few(const struct pruning *j, struct counted *c, const uint32_t *slot, size_t n)
{
    struct some_boxes some;
    for (size_t i = 0; i < n; i += some.n) {
        some.n = n - i < AT_ONCE ? n - i : AT_ONCE;
        memcpy(some.slot, slot + i, some.n * sizeof *slot);
        find_ranges(j, c, &some, 0);
        for (size_t k = 0; k < some.n; k++) j->range[some.slot[k]] = some.now[k];
        list_all(&some);
        count_listed(j, c, &some);
    }
}

/* Step 1 of so many boxes alone, by their slots, and which of them are wide. What it makes stands in `words`; the set
 * holds nothing from then on. Returns 0 without memory. */
int msap_rows_count_few(struct pruning *j, const uint32_t *slot, size_t n, struct scratch *words)
{
    struct row_set *set = j->set;
    size_t slots = j->slots, rows = (size_t)j->rows->count[0] * j->rows->count[1];
    uint64_t *at = msap_scratch_get(words, j->job->memory, n + slots + n / 2 + 1);
    if (!at || !msap_memory_reserve(j->job->memory, &set->end, &set->room_end, rows, 0, sizeof *set->end))
        return 0;
    j->order = at;
    j->range = (struct row_range *)(void *)(at + n);
    j->wide = (uint32_t *)(void *)(at + n + slots);
    j->end = set->end;
    struct counting all = {.pruning = j, .by = {{.end = j->end}}};
    memset(j->end, 0, rows * sizeof *j->end);
    count_few(j, &all.by[0], slot, n);
    add_up(j, &all);
    return 1;
}

/* Step 1, and which boxes are wide. What it makes stands in `words`; the set holds nothing from then on. Returns 0
 * without memory. */
int msap_rows_count(struct pruning *j, struct scratch *words)
{
    struct row_set *set = j->set;
    int are_told = msap_kept_are_told(j), keeps = are_told && msap_kept_are_most(j);
    struct counting all = {.pruning = j, .had = are_told ? j->last->slots : 0};
    set->rows = *j->rows;
    set->slots = set->changed = 0;
    if (!place_arrays(j, words, j->last == set ? all.had : 0, keeps)) return 0;
    all.last = j->last->range;
    /* It finds nothing, so it cannot lack memory. */
    msap_phase_run(j->job->crew, j->job->memory, count_some, &all, j->slots, WEIGHT_ROWS);
    add_up(j, &all);
    if (!are_told) set->changed = j->slots;
    return 1;
}
