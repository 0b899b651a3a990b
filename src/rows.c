/* From boxes to rows: the first half of a pruning of all boxes (jump.c, renew.c).
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. All axes but one, the one on which boxes are finest compared with the scene, cut
 *    space into rows along that one: the paper's grid, one SAP a row (II.2). Rows wrap
 *    around, as cells do (grid.c). The boxes of each row are counted (ranges.c).
 * 2. The boxes are sorted by their min on that axis and named, in this order, in the
 *    rows that they touch: so every row is sorted. Then their bounds are written into the
 *    rows, one after another.
 *
 * Where most boxes are in the same rows as at the last pruning, these are kept (kept.c), and only the other boxes
 * are counted, sorted and named. Boxes that touch many rows, wide ones, are in none. Naming takes the calling
 * thread, the rest all workers. */
#include "rows.h"

enum { MOST_ACTIVE = 8 };

/* Where there are several rows on an axis there are so many or more: then two boxes, neither of which touches more
 * than MOST_ROWS, never meet at both ends of rows that wrap around. */
enum { LEAST_COUNT = 2 * MOST_ROWS };

/* ------------------------------------------------------------------ layout */

static uint32_t finest_axis(const struct spread s[3])
{
    uint32_t best = 0;
    for (uint32_t k = 1; k < 3; k++)
        if (s[k].extent * s[best].size > s[best].extent * s[k].size) best = k;
    return best;
}

/* The axis on which rows are widened: on which boxes come far further than on the other one or, where there is
 * no such, on which there are more rows. */
static struct spread *axis_to_widen(struct spread *y, struct spread *z)
{
    enum { FAR_MORE = 4 };
    int is_y = msap_cells_on(y) > msap_cells_on(z);
    if (y->step > FAR_MORE * z->step) is_y = msap_cells_on(y) > 1;
    if (z->step > FAR_MORE * y->step) is_y = msap_cells_on(z) <= 1;
    return is_y ? y : z;
}

/* Rows are half as wide again as most boxes or more, and wider while a sweep would meet only few
 * boxes at a time. Few boxes are all in one: to go through many takes longer than to sweep it. */
static void choose_rows(struct pruning *p, uint32_t commit)
{
    enum { IN_ONE_ROW = 320 };
    struct rows *r = p->rows;
    struct spread s[3];
    double active = (double)p->job->boxes->live;
    msap_spread_of(p->job->boxes, &p->bounds, s);
    for (uint32_t k = 0; k < 3; k++) {
        s[k].exponent = msap_exponent_for(1.5 * s[k].size);
        if (s[k].extent > 0) active *= 2 * s[k].size / s[k].extent;
    }
    for (uint32_t k = 0; k < 3; k++) r->axis[k] = (finest_axis(s) + k) % 3;
    struct spread *x = &s[r->axis[0]], *y = &s[r->axis[1]], *z = &s[r->axis[2]];
    r->low = (float)(x->low - x->extent / 8); /* with room for the others */
    r->extent = (float)(x->extent * 1.25);
    for (; active < MOST_ACTIVE && msap_cells_on(y) * msap_cells_on(z) > 1; active *= 2)
        axis_to_widen(y, z)->exponent++;
    for (uint32_t k = 0; k < 2; k++) {
        const struct spread *across = k == 0 ? y : z;
        int is_one = across->exponent > WIDEST_CELL || p->job->boxes->live <= IN_ONE_ROW;
        double cells = is_one ? 1 : msap_cells_on(across);
        r->count[k] = cells > 1 ? msap_count_for(cells < LEAST_COUNT ? LEAST_COUNT : cells) : 1;
        r->scale[k] = r->count[k] == 1 ? 0 : (float)msap_power_of_two(-across->exponent);
    }
    for (r->shift = 0; 1u << r->shift < r->count[0];) r->shift++;
    r->chosen_for = p->job->boxes->live + 1;
    r->chosen_at = commit;
}

/* Chooses rows if those there are do not suit the boxes any more, or are older than so many commits. */
void msap_rows_choose(struct pruning *p, uint32_t commit, uint32_t most)
{
    const struct rows *r = p->rows;
    if (msap_is_outgrown(r->chosen_for, p->job->boxes->live) || commit - r->chosen_at > most)
        choose_rows(p, commit);
}

/* ------------------------------------------------------------------- step 2 */

/* Turns the counts into where each row starts. */
static void start_rows(const struct pruning *j, size_t rows)
{
    uint32_t start = 0;
    for (size_t i = 0; i < rows; i++) {
        uint32_t n = j->end[i];
        j->end[i] = start; /* and moves to the end as the row is filled */
        start += n;
    }
}

/* Names a box in the rows that it touches. */
static void list_in_many(const struct rows *r, const struct row_range *range, uint32_t name, uint32_t *end,
                         uint32_t *id)
{
    for (uint32_t z = 0, line = range->row; z <= range->more[1]; z++, line = next_line(r, line))
        for (uint32_t y = 0, row = line; y <= range->more[0]; y++, row = next_row(r, row))
            id[end[row]++] = name | (y == 0 ? ROW_STARTS_1 : 0) | (z == 0 ? ROW_STARTS_2 : 0);
}

/* Names a box in a row if `is` is 1. If it is 0, what is written goes to `nowhere`, without a question. */
static inline void list_if(uint32_t is, uint32_t *end, uint32_t *id, uint32_t name, uint32_t nowhere)
{
    id[nowhere ^ ((*end ^ nowhere) & (0 - is))] = name;
    *end += is;
}

/* The same of a box that touches two rows on each axis at the most. */
static inline void list_in_few(const struct rows *r, const struct row_range *range, uint32_t name, uint32_t *end,
                               uint32_t *id, uint32_t nowhere)
{
    uint32_t more_y = range->more[0], more_z = range->more[1], row = range->row;
    id[end[row]++] = name | ROW_STARTS_1 | ROW_STARTS_2;
    list_if(more_y, &end[next_row(r, row)], id, name | ROW_STARTS_2, nowhere);
    if (r->count[1] == 1) return;
    row = next_line(r, row);
    list_if(more_z, &end[row], id, name | ROW_STARTS_1, nowhere);
    list_if(more_y & more_z, &end[next_row(r, row)], id, name, nowhere);
}

/* Names the boxes of each row that are listed, in their order. */
static void list_boxes(const struct pruning *j, uint32_t *id)
{
    enum { AHEAD = 24 };
    const struct rows rows_now = *j->rows, *r = &rows_now;
    const struct row_range *ranges = j->range;
    const uint64_t *order = j->order;
    uint32_t *end = j->end, nowhere = (uint32_t)j->entries;
    for (size_t i = 0, n = j->n_listed; i < n; i++) {
        uint32_t slot = key_box(order[i]);
        const struct row_range range = ranges[slot];
        if (n - i > AHEAD) prefetch(&ranges[key_box(order[i + AHEAD])]);
        uint32_t name = slot | (~(uint32_t)range.is_static << ROW_SHIFT & ROW_MOVES);
        if ((range.more[0] | range.more[1]) <= 1) list_in_few(r, &range, name, end, id, nowhere);
        else list_in_many(r, &range, name, end, id);
    }
}

/* Where the bounds of entries are written, by axis of the boxes. */
struct columns {
    int32_t *min[3], *max[3];
};

/* Writes the bounds of entry i. */
static inline void fill_one(const struct columns *to, size_t i, const struct bounds *b)
{
    for (int k = 0; k < 3; k++) {
        to->min[k][i] = b->min[k];
        to->max[k][i] = b->max[k];
    }
}

#if defined(__SSE2__)
/* Writes one end of the bounds of entries i ... i + 3. */
static inline void fill_ends(int32_t *const to[3], size_t i, lanes a, lanes b, lanes c, lanes d)
{
    lanes ab = _mm_unpacklo_epi32(a, b), cd = _mm_unpacklo_epi32(c, d);
    store_four(to[0] + i, _mm_unpacklo_epi64(ab, cd));
    store_four(to[1] + i, _mm_unpackhi_epi64(ab, cd));
    store_four(to[2] + i, _mm_unpacklo_epi64(_mm_unpackhi_epi32(a, b), _mm_unpackhi_epi32(c, d)));
}

static inline void fill_four(const struct columns *to, size_t i, const struct bounds *a, const struct bounds *b,
                             const struct bounds *c, const struct bounds *d)
{
    fill_ends(to->min, i, load_bounds(a->min), load_bounds(b->min), load_bounds(c->min), load_bounds(d->min));
    fill_ends(to->max, i, load_bounds(a->max), load_bounds(b->max), load_bounds(c->max), load_bounds(d->max));
}
#else
static inline void fill_four(const struct columns *to, size_t i, const struct bounds *a, const struct bounds *b,
                             const struct bounds *c, const struct bounds *d)
{
    fill_one(to, i, a);
    fill_one(to, i + 1, b);
    fill_one(to, i + 2, c);
    fill_one(to, i + 3, d);
}
#endif

/* The bounds of entry i; fetches those of one further on. (Slots may be read behind the last.) */
static inline const struct bounds *bounds_of_entry(const struct bounds_by_slot *bounds, const uint32_t *id,
                                                   size_t i)
{
    enum { AHEAD = 12 };
    prefetch(bounds_of_slot(bounds, row_slot(id[i + AHEAD])));
    return bounds_of_slot(bounds, row_slot(id[i]));
}

/* Writes the bounds of entries first ... last - 1. */
static void fill_rows(void *context, struct worker *w, size_t first, size_t last)
{
    const struct pruning *j = context;
    const struct bounds_by_slot bounds = j->bounds;
    const uint32_t *axis = j->rows->axis, *id = j->set->id;
    struct columns to;
    size_t i = first;
    (void)w;
    for (int k = 0; k < 3; k++) {
        to.min[axis[k]] = j->set->min[k];
        to.max[axis[k]] = j->set->max[k];
    }
    for (; last - i >= 4; i += 4)
        fill_four(&to, i, bounds_of_entry(&bounds, id, i), bounds_of_entry(&bounds, id, i + 1),
                  bounds_of_entry(&bounds, id, i + 2), bounds_of_entry(&bounds, id, i + 3));
    for (; i < last; i++) fill_one(&to, i, bounds_of_entry(&bounds, id, i));
}

/* ---------------------------------------------------------------- the whole */

/* Makes the set, empty, and sorts the boxes that are listed. Returns 0 without memory. */
int msap_rows_sort(struct pruning *j)
{
    const struct rows *r = j->rows;
    if (!msap_row_set_make(j->set, j->job->memory, j->entries)) return 0;
    msap_share_sort_values(j->job, j->order, j->n_listed, (uint64_t *)(void *)j->set->words, r->low, r->extent);
    return 1;
}

/* Names the boxes in their rows. */
void msap_rows_list(struct pruning *j)
{
    struct row_set *set = j->set;
    uint32_t *coming = (uint32_t *)set->max[2];
    start_rows(j, (size_t)j->rows->count[0] * j->rows->count[1]);
    list_boxes(j, j->has_moved ? coming : set->id);
    if (j->has_moved) msap_kept_merge(j, coming);
    set->slots = j->range == set->range ? j->slots : 0;
}

/* And writes them. */
void msap_rows_fill(struct pruning *j)
{
    msap_phase_run(j->job->crew, j->job->memory, fill_rows, j, j->entries, WEIGHT_FILL); /* it finds nothing */
}

/* -------------------------------------------------------------------- reach */

static void reach_in_row(struct row_set *set, size_t row)
{
    uint32_t start = row_start(set, row), end = set->end[row];
    const int32_t *max = set->max[0];
    int32_t *reach = set->reach + reach_of(row, start), most = INT32_MIN;
    for (uint32_t i = start; i < end;) {
        uint32_t last = end - i < REACH ? end : i + REACH;
        for (; i < last; i++) most = max[i] > most ? max[i] : most;
        *reach++ = most;
    }
}

/* Before rows can be asked what reaches a place. Returns 0 without memory. */
int msap_rows_note_reach(struct row_set *set, const struct rows *r, struct memory *m)
{
    size_t rows = (size_t)r->count[0] * r->count[1], n = reach_of(rows, set->end[rows - 1]) + 1;
    if (!msap_memory_reserve(m, &set->reach, &set->room_reach, n, 0, sizeof *set->reach)) return 0;
    for (size_t row = 0; row < rows; row++) reach_in_row(set, row);
    return 1;
}

/* ----------------------------------------------------------------- sweeping */

/* The row of an entry. */
static size_t row_of(const struct row_set *set, const struct rows *r, size_t entry)
{
    size_t low = 0, high = (size_t)r->count[0] * r->count[1] - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (set->end[middle] <= entry) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Sweeps from entries first ... last - 1; what is found is taken. */
void msap_rows_sweep(const struct row_set *set, const struct rows *r, sweep_row_fn sweep, size_t first,
                     size_t last, take_pairs_fn take, const void *context, struct worker *w)
{
    struct pair_buffer found;
    for (size_t row = row_of(set, r, first), i = first; i < last; i = set->end[row++]) {
        uint32_t end = set->end[row];
        struct row_sweep at = {(uint32_t)i, (uint32_t)i + 1, end < last ? end : (uint32_t)last, end};
        while (at.i < at.last) {
            sweep(set, &at, &found);
            take(context, w, &found);
        }
    }
}

/* The same from entries of a set through those of another one in the same rows, which has noted its reach. */
void msap_rows_sweep_between(const struct row_set *set, const struct row_set *other, const struct rows *r,
                             sweep_between_fn sweep, size_t first, size_t last, take_pairs_fn take,
                             const void *context, struct worker *w)
{
    struct pair_buffer found;
    for (size_t row = row_of(set, r, first), i = first; i < last; i = set->end[row++]) {
        uint32_t end = set->end[row], start = row_start(other, row);
        struct row_reach reach = {other->reach + reach_of(row, start), start, start};
        struct row_sweep at = {(uint32_t)i, 0, end < last ? end : (uint32_t)last, other->end[row]};
        while (at.i < at.last) {
            sweep(set, other, &reach, &at, &found);
            take(context, w, &found);
        }
    }
}

/* ------------------------------------------------------------------- asking */

/* Asks the rows that bounds touch what in them overlaps, has what the question tells, and lies in no row before:
 * so, in most cases, each box is found once. The first n have been found already; returns how many are then, or
 * SIZE_MAX without room. */
size_t msap_rows_ask(const struct rows *r, const struct bounds *where, const struct row_question *q,
                     ask_one_row_fn ask, const void *context, struct worker *w, size_t n)
{
    struct row_span span = rows_of(r, where);
    struct row_question here = *q;
    for (int k = 0; k < 3; k++) {
        here.min[k] = where->min[r->axis[k]];
        here.max[k] = where->max[r->axis[k]];
    }
    for (uint32_t z = 0, line = span.row; z <= span.more[1]; z++, line = next_line(r, line))
        for (uint32_t y = 0, row = line; y <= span.more[0] && n != SIZE_MAX; y++, row = next_row(r, row)) {
            here.lacks = q->lacks | (y > 0 ? ROW_STARTS_1 : 0) | (z > 0 ? ROW_STARTS_2 : 0);
            n = ask(context, w, &here, row, n);
        }
    return n;
}

/* ------------------------------------------------------------------ the set */

/* Behind so many entries, as many or fewer than there is room for, is slack that can be read. */
void msap_row_set_close(struct row_set *set, size_t entries)
{
    for (size_t k = 0; k < 3; k++) {
        memset(set->min[k] + entries, 0, ROW_SLACK * sizeof *set->min[k]);
        memset(set->max[k] + entries, 0, ROW_SLACK * sizeof *set->max[k]);
    }
    memset(set->id + entries, 0, ROW_SLACK * sizeof *set->id);
}

/* Room for so many entries, and slack behind them that can be read. Returns 0 without
 * memory. */
int msap_row_set_make(struct row_set *set, struct memory *m, size_t entries)
{
    if (entries > UINT32_MAX - ROW_SLACK) return 0;
    if (!msap_memory_reserve(m, &set->words, &set->room, 7 * (entries + ROW_SLACK), 0, sizeof *set->words))
        return 0;
    for (size_t k = 0; k < 3; k++) {
        set->min[k] = set->words + 2 * k * (entries + ROW_SLACK);
        set->max[k] = set->min[k] + entries + ROW_SLACK;
    }
    set->id = (uint32_t *)(void *)(set->max[2] + entries + ROW_SLACK);
    msap_row_set_close(set, entries);
    return 1;
}

void msap_row_set_free(struct row_set *set, struct memory *m)
{
    msap_memory_free(m, set->words, set->room, sizeof *set->words);
    msap_memory_free(m, set->end, set->room_end, sizeof *set->end);
    msap_memory_free(m, set->reach, set->room_reach, sizeof *set->reach);
    msap_memory_free(m, set->range, set->room_range, sizeof *set->range);
    memset(set, 0, sizeof *set);
}
