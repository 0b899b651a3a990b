/* Rebuilding a grid: all boxes into cells at once, all neighbours from sweeps of
 * whole cells. What the paper's batch insertion and complete box pruning (I.4) are
 * to a single SAP, this is to a grid of them.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * 1. Each box gets its fat bounds, its level and the span of its cells.
 * 2. From the spans alone, the boxes of each cell are counted, the cells get memory of
 *    the right size, and the boxes are named in them, in the order of slots.
 * 3. Cell by cell, the rows are filled, and the cell, which is at hand now, is
 *    swept. Two boxes that meet in several cells of their level are taken
 *    in the first of them that the walk over the cells of one comes to.
 * 4. Boxes of different levels are found by asking: for each box the coarser levels or,
 *    where few boxes are on coarse levels, for each of those the finer ones.
 *
 * A pair that is found is settled at once and becomes two entries of neighbour lists.
 * Steps 1 and 3 and the asking are done by all workers (II.3d). */
#include "cells.h"

/* The boxes of a cell, moving and static: how many, then in which row the next one is named. */
struct tally {
    uint32_t of[2]; /* by is_static */
};

/* Where the box of a slot is to be: its cells, and its fat bounds, rounded for them. */
struct place {
    struct span span;
    uint16_t low[3], high[3];
};

/* While a cell is swept, its rows are named by their numbers instead of slots and, with them,
 * marked on each axis on which the box comes into no cell before this one. */
#define FIRST_X 0x80000000u
#define FIRST_Y 0x40000000u
#define FIRST_Z 0x20000000u
#define FIRST (FIRST_X | FIRST_Y | FIRST_Z)

struct rebuild {
    struct grid *grid;
    struct layout *layout; /* the current one */
    struct job *job;
    struct place *place; /* [slots] */
    struct tally *tally; /* [cells] */
};

/* ------------------------------------------------------------------ step 1 */

/* Whether a box has left its skin or, since that costs little now, soon will. */
static int needs_skin(const struct grid *g, uint32_t slot)
{
    const struct box *b = &g->boxes->at[slot];
    if (!contains(&b->fat, &b->now) || skin_is_baggy(g, slot)) return 1;
    return skin_is_old(g, slot) && box_is_changed(g->boxes, slot);
}

/* Fits the skins of the boxes in slots first ... last - 1 and finds their cells. Boxes that
 * were not in the grid have no past in it. */
static void fit(void *context, struct worker *w, size_t first, size_t last)
{
    struct rebuild *r = context;
    struct grid *g = r->grid;
    (void)w;
    for (size_t slot = first; slot < last; slot++) {
        struct box *b = &g->boxes->at[slot];
        struct place *p = &r->place[slot];
        if (!(b->flags & BOX_LIVE)) {
            box_forget_place(b);
            p->span.level = NO_LEVEL;
            continue;
        }
        if (b->level == NO_LEVEL) msap_skin_first(g, (uint32_t)slot);
        else if (needs_skin(g, (uint32_t)slot)) msap_skin_renew(g, (uint32_t)slot, 0);
        struct spot spot;
        steps_of(r->layout, &b->fat, &spot);
        p->span = span_on(r->layout, &spot.base, spot.level);
        p->span.is_static = (b->flags & BOX_STATIC) != 0;
        b->layout = g->current & 1;
        b->level = (uint8_t)spot.level;
        memcpy(p->low, spot.rounded.low, sizeof p->low);
        memcpy(p->high, spot.rounded.high, sizeof p->high);
    }
}

/* ------------------------------------------------------------------ step 2 */

/* Counts the boxes of each cell. */
static void count(const struct rebuild *r)
{
    struct layout *l = r->layout;
    uint32_t cell[MOST_CELLS];
    memset(r->tally, 0, l->n_cells * sizeof *r->tally);
    for (size_t slot = 0; slot < r->job->boxes->used; slot++) {
        const struct span *s = &r->place[slot].span;
        if (s->level == NO_LEVEL) continue;
        l->level[s->level].boxes++;
        l->boxes++;
        for (uint32_t n = cells_of(l, s, cell); n-- > 0;) r->tally[cell[n]].of[s->is_static]++;
    }
}

/* Turns the counts into cells with room and into rows. Returns 0 without memory, and if a cell would be
 * too large for marks. */
static int make_cells(const struct rebuild *r)
{
    uint32_t most = 0;
    for (size_t i = 0; i < r->layout->n_cells; i++) {
        struct cell *c = &r->layout->cell[i];
        struct tally *t = &r->tally[i];
        uint32_t moving = t->of[0], all = moving + t->of[1];
        t->of[0] = 0;
        t->of[1] = moving;
        most = all > most ? all : most;
        if (all > 0 && !msap_cell_make_room(c, &r->grid->pool, r->job->memory, all)) return 0;
        c->n = all;
        c->n_moving = moving;
    }
    return most <= ~FIRST && /* GCOVR_EXCL_BR_LINE: 2^31 boxes in a cell */
           msap_crew_room_to_find(r->job->crew, r->job->memory, most);
}

/* Names each box in its cells. */
static void name_boxes(const struct rebuild *r)
{
    uint32_t cell[MOST_CELLS];
    for (uint32_t slot = 0; slot < r->job->boxes->used; slot++) {
        const struct span *s = &r->place[slot].span;
        if (s->level == NO_LEVEL) continue;
        for (uint32_t n = cells_of(r->layout, s, cell); n-- > 0;) {
            uint32_t row = r->tally[cell[n]].of[s->is_static]++;
            r->layout->cell[cell[n]].block[row / 8].id[row % 8] = slot;
        }
    }
}

/* ------------------------------------------------------------------ step 3 */

/* Takes a pair of boxes that are neighbours and not both static. Whether they are a pair
 * goes with them into their lists. */
static uint64_t settled(const struct rebuild *r, struct settler *settler, uint32_t a, uint32_t b)
{
    const struct box *p = &r->job->boxes->at[a], *q = &r->job->boxes->at[b];
    int is = overlap(&p->now, &q->now);
    settler->touched++;
    if (is && !were_pair(r->job->boxes, a, b)) msap_settle_change(settler, pair_key(a, b), 1);
    return (uint64_t)a << 32 | b | (is ? NEAR_PAIR : 0);
}

/* A cell at work. */
struct sweeping {
    const struct rebuild *rebuild;
    const struct level *level;
    struct worker *worker;
    struct cell *cell;
    uint32_t *slot; /* of each row */
    uint32_t at[3]; /* where the cell is in its level */
    struct pair_buffer found;
};

/* Whether a cell is the one in which two of its boxes, a and b, are taken, as far as axis k
 * goes: the first, in the order of a's cells, that both touch. `at` is its place on the axis. */
static inline int is_first_on(uint32_t k, uint32_t at, uint32_t count, const struct span *a, const struct span *b)
{
    uint32_t low = a->low[k], other = b->low[k];
    uint32_t ahead = low + (low < other ? count : 0) - other; /* of b's lowest is a's */
    return (at == low) | ((at == other) & (ahead > b->more[k]));
}

/* Whether two boxes may meet at both ends of an axis, since together they can go around it. */
static int is_narrow(const struct level *l)
{
    int narrow = 0;
    for (int k = 0; k < 3; k++) narrow |= l->count[k] > 1 && l->count[k] < 2 * MOST_CELLS;
    return narrow;
}

/* Drops those of the taken pairs that are taken in another cell. Of two boxes, the one whose
 * row is the first is the same in all cells: rows are in the order of slots, those of moving
 * boxes first. */
static void drop_twice_taken(struct sweeping *s)
{
    struct pair_buffer *f = &s->found;
    const uint32_t *count = s->level->count;
    size_t n = 0;
    for (size_t i = 0; i < f->n; i++) {
        const struct span *a = &s->rebuild->place[f->a[i]].span, *b = &s->rebuild->place[f->b[i]].span;
        f->a[n] = f->a[i];
        f->b[n] = f->b[i];
        n += (size_t)(is_first_on(0, s->at[0], count[0], a, b) & is_first_on(1, s->at[1], count[1], a, b) &
                      is_first_on(2, s->at[2], count[2], a, b));
    }
    f->n = n;
}

/* Settles those of the taken pairs that are near and puts them into the worker's buffer. What they are follows no
 * pattern, so nothing but a change asks for it. */
static void settle_taken(struct sweeping *s)
{
    const struct box_table *t = s->rebuild->job->boxes;
    struct worker *w = s->worker;
    struct pair_buffer *f = &s->found;
    size_t n = 0;
    for (size_t i = 0; i < f->n; i++) {
        const struct box *p = &t->at[f->a[i]], *q = &t->at[f->b[i]];
        f->a[n] = f->a[i];
        f->b[n] = f->b[i] | (uint32_t)overlap(&p->now, &q->now) * NEAR_PAIR;
        n += (size_t)overlap(&p->fat, &q->fat);
    }
    w->settler.touched += f->n = n;
    if (msap_worker_has_room(w, f->n, 0))
        for (size_t i = 0; i < f->n; i++) w->pairs.at[w->pairs.n++] = (uint64_t)f->a[i] << 32 | f->b[i];
    n = 0;
    for (size_t i = 0; i < f->n; i++) {
        uint32_t entry = f->b[i];
        f->a[n] = f->a[i];
        f->b[n] = near_slot(entry);
        n += entry >> 31;
    }
    for (size_t i = 0; i < n; i++)
        if (!were_pair(t, f->a[i], f->b[i])) msap_settle_change(&w->settler, pair_key(f->a[i], f->b[i]), 1);
}

/* Takes those of the pairs found that have each mark on one side or the other. */
static void take_found(struct sweeping *s)
{
    struct pair_buffer *f = &s->found;
    size_t n = 0;
    for (size_t i = 0; i < f->n; i++) {
        uint32_t a = f->a[i], b = f->b[i];
        f->a[n] = s->slot[a & ~FIRST];
        f->b[n] = s->slot[b & ~FIRST];
        n += ((a | b) & FIRST) == FIRST;
    }
    f->n = n;
    if (is_narrow(s->level)) drop_twice_taken(s);
    settle_taken(s);
    f->n = 0;
}

/* Takes the names of the rows down, which marks will take the place of. */
static void note_names(const struct sweeping *s)
{
    for (uint32_t row = 0; row < s->cell->n; row += 8)
        memcpy(s->slot + row, s->cell->block[row / 8].id, sizeof s->cell->block->id);
}

/* Names the rows by their slots; those that follow in the last block name no box, for whole
 * blocks are read. */
static void name_rows(const struct sweeping *s)
{
    struct cell *c = s->cell;
    for (uint32_t row = c->n; row % 8 != 0; row++) s->slot[row] = NONE;
    for (uint32_t row = 0; row < c->n; row += 8) memcpy(c->block[row / 8].id, s->slot + row, sizeof c->block->id);
}

/* Sweeps a cell whose rows are marked: from each row that is not static over those behind it,
 * so many at a time as fit into the buffer. */
static void sweep_cell(struct sweeping *s)
{
    struct cell *c = s->cell;
    for (uint32_t row = 0; row < c->n_moving; row++) {
        struct rounded rounded;
        uint32_t id = msap_cell_row(c, row, &rounded);
        for (uint32_t first = row + 1, last; first < c->n; first = last) {
            last = c->n - first < MOST_BUFFERED ? c->n : first + MOST_BUFFERED;
            if (s->found.n + (last - first) > MOST_BUFFERED) take_found(s);
            size_t n = s->rebuild->grid->sweeps.cell(c, first, last, &rounded, s->found.b + s->found.n);
            for (size_t i = 0; i < n; i += 4) set_four(s->found.a + s->found.n + i, id);
            s->found.n += n;
        }
    }
    take_found(s);
}

/* Writes the rows of a cell with their marks. */
static void fill_cell(const struct sweeping *s)
{
    const struct box *boxes = s->rebuild->job->boxes->at;
    for (uint32_t row = 0; row < s->cell->n; row++) {
        const struct place *p = &s->rebuild->place[s->slot[row]];
        const uint16_t *low = p->span.low;
        uint32_t marks = (low[0] == s->at[0] ? FIRST_X : 0) | (low[1] == s->at[1] ? FIRST_Y : 0) |
                         (low[2] == s->at[2] ? FIRST_Z : 0);
        prefetch(&boxes[s->slot[row]]); /* for those that are found */
        cell_put_row(s->cell, row, p->low, p->high, row | marks);
    }
}

/* Fills and sweeps cells first ... last - 1 of all levels. */
static void make_rows(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    const struct layout *l = r->layout;
    struct sweeping s = {.rebuild = r, .level = l->level, .worker = w, .slot = w->found};
    for (size_t i = first; i < last; i++) {
        struct cell *c = s.cell = &l->cell[i];
        while (s.level < &l->level[TOP] && c >= s.level[1].cell) s.level++;
        if (c->n == 0) continue;
        const uint32_t *count = s.level->count, at = (uint32_t)(c - s.level->cell);
        s.at[0] = at % count[0];
        s.at[1] = at / count[0] % count[1];
        s.at[2] = at / count[0] / count[1];
        note_names(&s);
        fill_cell(&s);
        sweep_cell(&s);
        name_rows(&s);
    }
}

/* ------------------------------------------------------------------ step 4 */

/* Asks the coarser levels for the boxes in slots first ... last - 1. */
static void ask_coarser(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    for (size_t slot = first; slot < last; slot++)
        if (r->place[slot].span.level != NO_LEVEL)
            msap_grid_query(r->grid, w, (uint32_t)slot, r->place[slot].span.is_static,
                            r->place[slot].span.level + 1u, LEVELS);
}

/* Asks the finer levels for the boxes in slots first ... last - 1. */
static void ask_finer(void *context, struct worker *w, size_t first, size_t last)
{
    const struct rebuild *r = context;
    for (size_t slot = first; slot < last; slot++)
        if (r->place[slot].span.level != NO_LEVEL && r->place[slot].span.level > 0)
            msap_grid_query(r->grid, w, (uint32_t)slot, r->place[slot].span.is_static, 0,
                            r->place[slot].span.level);
}

/* Settles the pairs that asking has found, from `first` on, and drops those that are not near and
 * repeats, which come together by box. */
static void settle_asked(const struct rebuild *r, struct worker *w, size_t first)
{
    const struct box *box = r->job->boxes->at;
    uint64_t *pair = w->pairs.at;
    size_t n = first;
    for (size_t i = first; i < w->pairs.n; i++) {
        uint32_t a = (uint32_t)(pair[i] >> 32), b = (uint32_t)pair[i];
        if (n == first || a != pair[n - 1] >> 32) msap_worker_new_token(w);
        if (w->tag[b] == w->token) continue;
        w->tag[b] = w->token;
        if (overlap(&box[a].fat, &box[b].fat)) pair[n++] = settled(r, &w->settler, a, b);
    }
    w->pairs.n = n;
}

/* Returns 0 without memory. */
static int ask(struct rebuild *r)
{
    enum { FEW = 64 }; /* cells that a coarse box would have to visit, more or less */
    struct worker *w = r->job->worker;
    size_t coarse = r->layout->boxes - r->layout->level[0].boxes, found = w->pairs.n;
    int are_few = coarse < r->layout->boxes / FEW;
    if (coarse == 0) return 1;
    if (!msap_phase_run(r->job->crew, r->job->memory, are_few ? ask_finer : ask_coarser, r, r->job->boxes->used,
                        are_few ? WEIGHT_LEVELS : WEIGHT_QUERY))
        return 0;
    settle_asked(r, w, found);
    return !w->settler.lost;
}

/* ---------------------------------------------------------------- the whole */

/* Cuts the arrays of a call out of scratch memory. Returns 0 without it. */
static int place_arrays(struct rebuild *r)
{
    size_t places = (r->job->boxes->used * sizeof *r->place + 7) / 8;
    uint64_t *at = msap_scratch_get(r->job->scratch, r->job->memory, places + r->layout->n_cells);
    if (!at) return 0;
    r->place = (struct place *)(void *)at;
    r->tally = (struct tally *)(void *)(at + places);
    return 1;
}

/* Steps 1 and 2. Returns 0 without memory. */
static int make_grid(struct rebuild *r)
{
    struct job *job = r->job;
    if (!place_arrays(r)) return 0;
    /* It finds nothing, so it cannot lack memory. */
    msap_phase_run(job->crew, job->memory, fit, r, job->boxes->used, WEIGHT_SKIN);
    count(r);
    if (!make_cells(r)) return 0;
    name_boxes(r);
    return 1;
}

/* Finds and settles all neighbours. Returns 0 without memory. */
static int find_neighbours(struct rebuild *r)
{
    struct keys *pairs = &r->job->worker->pairs;
    struct memory *m = r->job->memory;
    size_t n = r->layout->n_cells, weight = r->layout->boxes * WEIGHT_CELL_BOX / n + 1;
    pairs->n = 0;
    return msap_phase_run(r->job->crew, m, make_rows, r, n, weight) && ask(r) &&
           msap_near_make(&r->grid->near, m, pairs, r->job->boxes->used);
}

/* Whether the layout should be chosen again, since it costs little now. */
static int is_stale(const struct layout *l, uint32_t commit, size_t boxes)
{
    enum { COMMITS = 4 };
    return msap_is_outgrown(l->chosen_for, boxes) || commit - l->chosen_at > COMMITS;
}

/* Touches all pairs that overlap and all that did. Returns 0 without memory. */
int msap_grid_rebuild(struct grid *g, struct job *job)
{
    struct box_table *t = job->boxes;
    struct layout *l = &g->layout[g->current];
    struct rebuild r = {.grid = g, .layout = l, .job = job};
    msap_restless_forget(g);
    msap_partners_forget(g);
    msap_grid_empty_cells(g, job->memory);
    forget_rows_of_skins(g);
    g->is_tracking = g->is_jumping = g->is_resting = g->in_skins = 0;
    g->renewal.next = NO_RENEWAL;
    g->quiet = 0;
    msap_upkeep_begins(g);
    msap_upkeep_starts(g);
    g->gain = 0;
    g->moves = t->live;
    msap_layout_free(&g->layout[1 - g->current], job->memory);
    if (is_stale(l, g->commit, t->live) && !msap_layout_choose(g, job->memory, t, t->live)) return 0;
    g->is_empty = 0;
    g->is_tracking = make_grid(&r) && find_neighbours(&r);
    if (g->is_tracking) msap_touch_known_pairs(job);
    return g->is_tracking;
}
