/* The library's own declarations: the terms that src/ uses, and who owns what.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The way of a box through the code:
 *
 *     msap_update            resolve the handle, refuse bad bounds    (update.c)
 *       box_change           store the bounds, mark as changed        (box.c)
 *     msap_commit                                                     (commit.c)
 *       sap_update           three axes, by slide, merge or sweep     (sap.c)
 *         axis_slide         move a box's end points to their places  (slide.c)
 *         prune_...          find the pairs of new boxes              (prune.c)
 *       settle               overlapped before? overlap now?          (settle.c)
 *       pairs_apply          hash + contiguous array of pairs         (pairs.c)
 *
 * The invariant that all of it serves: every pair whose overlap changed since the
 * last commit is touched (given to settle) at least once. Touching too many pairs,
 * or one pair often, costs time and changes nothing. */
#ifndef MSAP_INTERNAL_H
#define MSAP_INTERNAL_H

#include "bounds.h"

#include <string.h>

#define NONE UINT32_MAX /* no slot, no pair */

enum { MOST_WORKERS = 64, MOST_GRID_CELLS = 4096 };

/* ---------------------------------------------------------------- memory.c */

enum { CACHE_LINE = 64, HUGE_PAGE = 2097152 }; /* bytes */

static inline size_t larger_of(size_t a, size_t b) { return a > b ? a : b; }

/* The world's allocator, and the account of what it gave. */
struct memory {
    msap_alloc_fn alloc;
    msap_free_fn free;
    void *user;
    uint64_t bytes, peak, calls;
};

msap_status msap_memory_init(struct memory *m, msap_alloc_fn alloc, msap_free_fn free, void *user);
void *msap_memory_alloc(struct memory *m, size_t count, size_t size);
void msap_memory_free(struct memory *m, void *pointer, size_t count, size_t size);
int msap_memory_resize(struct memory *m, void *pointer_to_array, size_t *room, size_t new_room, size_t used,
                       size_t size);
int msap_memory_reserve(struct memory *m, void *pointer_to_array, size_t *room, size_t need, size_t used,
                        size_t size);
void msap_memory_shrink(struct memory *m, void *pointer_to_array, size_t *room, size_t need, size_t size);

/* ------------------------------------------------------------------ pool.c */

enum { POOL_CLASSES = 14 };

/* How many units an array of a class has. */
static inline size_t pool_units(unsigned class)
{
    return class == 0 ? 1 : (size_t)(class % 2 == 0 ? 3 : 2) << (class - 1) / 2;
}

static inline int pool_is_large(unsigned class) { return class >= POOL_CLASSES; }

/* Arrays of units of so many bytes, a multiple of 16. */
struct pool {
    size_t unit;
    size_t units;                    /* of all slabs */
    size_t cut;                      /* of the first slab that are not handed out yet */
    struct slab *slabs;              /* in use; the first one is being cut */
    struct slab *spare;              /* not in use */
    struct slab *free[POOL_CLASSES]; /* arrays that were given back */
};

void msap_pool_init(struct pool *p, size_t unit);
void msap_pool_empty(struct pool *p);
void msap_pool_free(struct pool *p, struct memory *m);
unsigned msap_pool_class_for(size_t units);
void *msap_pool_get(struct pool *p, struct memory *m, unsigned class);
void msap_pool_put(struct pool *p, struct memory *m, void *array, unsigned class);
void msap_pool_lend(struct pool *p, struct memory *m, struct pool *stock, unsigned classes, size_t n);
void msap_pool_take_back(struct pool *p, struct pool *stock);

/* ------------------------------------------------------------------ sort.c */

/* A growing array of 64-bit keys. */
struct keys {
    uint64_t *at;
    size_t n, room;
};

static inline void keys_exchange(struct keys *a, struct keys *b)
{
    const struct keys c = *a;
    *a = *b;
    *b = c;
}

int msap_keys_reserve(struct keys *k, struct memory *m, size_t need);
void msap_keys_free(struct keys *k, struct memory *m);
void msap_sort_keys(uint64_t *key, size_t n, uint64_t *scratch);
void msap_sort_values(uint64_t *key, size_t n, uint64_t *scratch, float low, float extent);
void msap_sort_nearly_sorted(uint64_t *key, size_t n, uint64_t *scratch);
size_t msap_unique_keys(uint64_t *key, size_t n);

/* ---------------------------------------------------------------- number.c */

/* Where bounds come from: an msap_boxes with its struct_size checked. */
msap_status msap_bounds_read_with_care(const msap_boxes *boxes, const char *min, const char *max, uint32_t dims,
                                       struct bounds *out, uint32_t *bound);
double msap_value_of(int32_t ordered);
int32_t msap_ordered_outward(double value, unsigned up);
struct bounds msap_bounds_widened(const struct bounds *b, float margin);
msap_boxes msap_boxes_of_one(const float *min, const float *max);
msap_status msap_boxes_check(const msap_boxes *boxes, size_t k);

/* Reads row `row` of an array of boxes. Of bounds that are not legal, *bound becomes the one at
 * fault. */
static inline msap_status bounds_read(const msap_boxes *boxes, size_t row, uint32_t dims, struct bounds *out,
                                      uint32_t *bound)
{
    const char *min = (const char *)boxes->min + (ptrdiff_t)row * boxes->min_row;
    const char *max = (const char *)boxes->max + (ptrdiff_t)row * boxes->max_row;
    if (boxes->scalar == MSAP_FLOAT &&
        encode(load_floats(min, boxes->min_component, dims), load_floats(max, boxes->max_component, dims), out))
        return MSAP_OK;
    return msap_bounds_read_with_care(boxes, min, max, dims, out, bound);
}

/* ------------------------------------------------------------------- box.c */

enum {
    BOX_LIVE = 1,     /* its handle is valid: added and not removed */
    BOX_WAS = 2,      /* it took part in the last successful commit */
    BOX_STATIC = 4,   /* added with MSAP_STATIC */
    BOX_RESTLESS = 8, /* it is in no row since it moved, until it is calmed (restless.c) */
    BOX_STORED = 16,  /* its end points are in the sorted axes */
    BOX_REMOVED = 32, /* it was removed, and its slot waits for the commit that reports it */
    BOX_NEW = 64,     /* within a commit: its end points were just put in, its pairs are to be found */
    BOX_FITTED = 128  /* it has, or has had, one of the skins to come (renew.c) */
};

enum { NO_LEVEL = 255 };

/* Commits that skins are made for: a box's first one, and the first ones of all boxes together; the fewest
 * that all are made for, and the most, at first where all boxes are pruned and at all. */
enum { HORIZON_FIRST = 24, HORIZON_START = 32, HORIZON_SHORT = 3, HORIZON_TRIAL = 8, HORIZON_MOST = 64 };

/* A slot of the box table, and where the box is in the grid: one cache line. A box that
 * is not on the list of those that left lies within its fat bounds; an unchanged slot
 * without BOX_LIVE and BOX_WAS is free or retired. */
struct box {
    struct bounds now;   /* as last given; of one that is not BOX_LIVE, links of a queue */
    int32_t left;        /* LEFT if it is on the list of those that left, else STAYED */
    struct bounds fat;   /* with its skin: what its cells know of it; all space where it is in none */
    uint32_t generation; /* low half of the handle; 0: retired */
    uint32_t changed_in; /* the table's epoch exactly if it is on the changed list */
    uint8_t flags;
    uint8_t level;       /* of the grid; or NO_LEVEL: not in it */
    uint8_t horizon;     /* for how many commits its skin was made */
    unsigned wobble : 4; /* how much of its reach the skin has on all sides, in eighths */
    unsigned layout : 4; /* of which its level is */
};

/* Below all bounds, and above all. */
enum { LEFT = INT32_MIN, STAYED = INT32_MAX };
static inline int box_has_left(const struct box *b) { return b->left == LEFT; }

/* The gaps between boxes as they are now; on the fourth axis one that left is apart from all. (The word behind
 * a->now.max is compared with b->now.max[0] there, and b's with a's.) */
static inline gaps gaps_of_boxes(const struct box *a, const struct box *b)
{
    return gaps_and_fourth(gaps_of(&a->now, &b->now), box_has_left(a) | box_has_left(b));
}

/* From so many boxes on they outgrow caches: what is looked up is then fetched ahead of it. */
enum { MANY_BOXES = 32768 };
/* From so many on, what is worked in now and then is given back after it. */
enum { VERY_MANY_BOXES = 2 * MANY_BOXES };

/* Bounds of boxes, by slot, so many bytes apart: of those boxes that have all of the flags. */
struct bounds_by_slot {
    const void *at;
    size_t step;
    uint32_t flags;
};

static inline const struct bounds *bounds_of_slot(const struct bounds_by_slot *b, size_t slot)
{
    return (const struct bounds *)(const void *)((const char *)b->at + slot * b->step);
}

/* The slot behind this one in the queue of removed or of free slots, or NONE; and the one so many behind it, to be
 * fetched, or NONE. */
enum { QUEUE_AHEAD = 16 };
static inline uint32_t box_next(const struct box *b) { return (uint32_t)b->now.min[0]; }
static inline uint32_t box_ahead(const struct box *b) { return (uint32_t)b->now.min[1]; }

/* Slots in the order in which they came, linked through box_next. */
struct slot_queue {
    uint32_t head, tail;
    uint32_t put;                 /* how many have been put at its end, modulo 2^32; */
    uint32_t latest[QUEUE_AHEAD]; /* and the last of them, each in the place of its number */
    size_t n;
};

/* Where the box of a slot was. */
struct past {
    struct bounds before; /* of a box on the changed list: at the last successful commit; or NOWHERE */
    uint16_t start[3];    /* of one in the grid: min when it got its fat bounds, lower halves; */
    uint16_t since;       /* and in which commit, its lower half */
};

struct box_table {
    struct box *at;
    struct past *past; /* [slots] */
    void **user_data;  /* [slots]; NULL: all of them are NULL */
    uint32_t *changed; /* slots whose box was added, updated or removed since the last commit, each once,
                          in any order */
    uint32_t *left;    /* those of them that came, went or were outside their fat bounds, each once, in
                          any order */
    uint32_t epoch;    /* counts successful commits from 1; never 0 */
    size_t used;       /* slots given out so far, but for those forgotten since */
    uint32_t
        first_generation; /* of a slot that is given out for the first time; above that of any forgotten one */
    size_t room, room_past, room_user, room_changed, room_left;
    size_t live, live_static;
    size_t n_changed, n_left;
    struct slot_queue removed; /* since the last commit, in the order of removal */
    struct slot_queue free;    /* to be given out again, in this order */
};

/* A copy that vectors may read (bounds.h). */
struct readable {
    struct bounds bounds;
    int32_t fourth;
};

/* Those that live boxes have now. */
static inline struct bounds_by_slot bounds_now(const struct box_table *t)
{
    const struct bounds_by_slot now = {t->at, sizeof *t->at, BOX_LIVE}; /* `now` is first */
    return now;
}

static inline msap_handle handle_of(const struct box_table *t, uint32_t slot)
{
    return (uint64_t)slot << 32 | t->at[slot].generation;
}
static inline uint32_t slot_of(msap_handle handle) { return (uint32_t)(handle >> 32); }

/* The box of a handle if it has one of the flags, as no free or retired slot has, or NULL. */
static inline struct box *box_find(const struct box_table *t, msap_handle handle, uint32_t flags)
{
    uint32_t slot = slot_of(handle), generation = (uint32_t)handle;
    if (slot >= t->used) return NULL;
    struct box *b = &t->at[slot];
    return b->generation == generation && (b->flags & flags) ? b : NULL;
}

/* Fetches what will be changed where a box of the caller's is updated or removed. */
static inline void box_fetch(const struct box_table *t, msap_handle handle)
{
    uint32_t slot = slot_of(handle);
    if (slot >= t->used) return;
    prefetch(&t->at[slot]);
    prefetch(&t->past[slot]);
}

static inline void *box_user_data(const struct box_table *t, uint32_t slot)
{
    return t->user_data ? t->user_data[slot] : NULL;
}

static inline int box_is_changed(const struct box_table *t, uint32_t slot)
{
    return t->at[slot].changed_in == t->epoch;
}

/* The bounds of a box at the last successful commit; they mean something with BOX_WAS. */
static inline const struct bounds *box_before(const struct box_table *t, uint32_t slot)
{
    return box_is_changed(t, slot) ? &t->past[slot].before : &t->at[slot].now;
}

/* Puts a box, whose bounds before are kept, on the changed list. */
static inline void box_list_changed(struct box_table *t, uint32_t slot)
{
    t->at[slot].changed_in = t->epoch;
    t->changed[t->n_changed++] = slot;
}

/* Called before the bounds change. */
static inline void box_mark_changed(struct box_table *t, uint32_t slot)
{
    if (box_is_changed(t, slot)) return;
    t->past[slot].before = t->at[slot].now;
    box_list_changed(t, slot);
}

static inline void box_mark_left(struct box_table *t, uint32_t slot)
{
    if (box_has_left(&t->at[slot])) return;
    t->at[slot].left = LEFT;
    t->left[t->n_left++] = slot;
}

static inline void box_change(struct box_table *t, uint32_t slot, const struct bounds *bounds)
{
    struct box *b = &t->at[slot];
    box_mark_changed(t, slot);
    b->now = *bounds;
    if (!contains(&b->fat, &b->now)) box_mark_left(t, slot);
}

/* What overlaps nothing, a box without bounds neither: the bounds before of a box that was not
 * there. */
#define NOWHERE                                                                \
    {                                                                          \
        {INT32_MAX, INT32_MAX, INT32_MAX}, { INT32_MIN, INT32_MIN, INT32_MIN } \
    }

/* All space: the fat bounds of a box that is in no cell. */
#define EVERYWHERE                                                                                           \
    {                                                                                                        \
        {ORDERED_MINUS_INF, ORDERED_MINUS_INF, ORDERED_MINUS_INF}, { ORDERED_INF, ORDERED_INF, ORDERED_INF } \
    }

/* The box is in no cell. */
static inline void box_forget_place(struct box *b)
{
    static const struct bounds everywhere = EVERYWHERE;
    b->fat = everywhere;
    b->level = NO_LEVEL;
}

void msap_boxes_init(struct box_table *t);
void msap_boxes_free(struct box_table *t, struct memory *m);
int msap_boxes_reserve(struct box_table *t, struct memory *m, size_t slots);
void msap_boxes_trim(struct box_table *t, struct memory *m);
size_t msap_boxes_slots_for(const struct box_table *t, size_t k);
int msap_boxes_hold_user_data(struct box_table *t, struct memory *m, size_t slots);
void msap_box_add(struct box_table *t, const struct bounds *bounds, uint32_t flags, void *user_data);
void msap_boxes_undo_add(struct box_table *t, size_t used, size_t n_changed, size_t n_left);
void msap_box_remove(struct box_table *t, uint32_t slot);
void msap_boxes_complete_before(struct box_table *t);
void msap_boxes_committed(struct box_table *t);
void msap_boxes_free_removed(struct box_table *t);

/* ---------------------------------------------------------------- settle.c */

struct job;

/* Takes touched pairs and keeps those whose overlap changed: the one place where a
 * pair is decided. Reads the box table only. */
struct settler {
    const struct box_table *boxes;
    struct memory *memory; /* to grow the lists; NULL on a worker, which may not */
    struct keys fresh;     /* pairs that overlap now and did not before; repeats until sorted */
    struct keys doomed;    /* pairs that overlapped before and do not now; as many fit as there are pairs */
    struct keys notes;     /* where lists, slot << 32 | index, tell of a change */
    int has_repeats;       /* 1: a pair may be touched often, as by a single SAP */
    int lost;              /* 1: a list could not grow, something was lost */
    int has_all_doomed;    /* 1: the doomed list holds every known pair */
    int has_no_notes;      /* 1: there was no memory for all of them */
    int are_events;        /* 1: both lists are sorted and without repeats */
    uint64_t touched, crossings;
};

static inline uint64_t pair_key(uint32_t a, uint32_t b)
{
    uint64_t key = (uint64_t)a << 32 | b, other = (uint64_t)b << 32 | a;
    return key < other ? key : other;
}

void msap_settle_change(struct settler *s, uint64_t key, int is);
void msap_settle_note(struct settler *s, uint32_t slot, uint32_t index);

/* Whether two boxes that are not both static overlapped at the last commit. */
static inline int were_pair(const struct box_table *t, uint32_t a, uint32_t b)
{
    return ((t->at[a].flags & t->at[b].flags & BOX_WAS) != 0) & overlap(box_before(t, a), box_before(t, b));
}

/* Takes a touched pair of boxes, a != b, in any order and as often as it comes. */
static inline void settle(struct settler *s, uint32_t a, uint32_t b)
{
    const struct box *p = &s->boxes->at[a], *q = &s->boxes->at[b];
    uint32_t both = p->flags & q->flags;
    int is = ((both & BOX_LIVE) != 0) & overlap(&p->now, &q->now);
    s->touched++;
    if (were_pair(s->boxes, a, b) != is && !(both & BOX_STATIC)) msap_settle_change(s, pair_key(a, b), is);
}

void msap_touch_known_pairs(struct job *job);

/* A pair that is known to overlap now, not both static, when the bounds before of all boxes
 * are in `past`. */
static inline void settle_found(struct settler *s, uint32_t a, uint32_t b)
{
    const struct box_table *t = s->boxes;
    if (!overlap(&t->past[a].before, &t->past[b].before)) msap_settle_change(s, pair_key(a, b), 1);
}

/* Which of four pairs overlapped before, a bit each. */
static inline uint32_t known_among(const struct past *past, const uint32_t *a, const uint32_t *b)
{
    return overlaps_of(
        gaps_of(&past[a[0]].before, &past[b[0]].before), gaps_of(&past[a[1]].before, &past[b[1]].before),
        gaps_of(&past[a[2]].before, &past[b[2]].before), gaps_of(&past[a[3]].before, &past[b[3]].before));
}

struct pair_buffer;
void msap_settle_found(struct settler *s, const struct pair_buffer *found);
void msap_touch_all_boxes(const struct job *job);

/* ----------------------------------------------------------------- pairs.c */

/* The active pairs: a hash table over a contiguous array (paper I.6). Behind the
 * active pairs stand those that the last commit deleted; the last `created` of the
 * active ones are those that it created. The table has one entry for each active pair,
 * in the chain of the pair's home: what `first` or `next` hold there, its index. */
struct pair_table {
    msap_pair *at;
    size_t room;
    size_t active, created, deleted;
    size_t most_active, most_deleted; /* so far; there is room for both at once */
    uint32_t *first;                  /* [homes] the first pair of each chain, or NONE */
    uint32_t *next;                   /* [room_next] the pair behind each pair in its chain, or NONE */
    size_t homes, room_next;          /* homes: 0 or a power of two, at least as many as active pairs */
    unsigned shift;                   /* homes == 1 << (64 - shift), unless 0 */
};

static inline uint64_t pair_key_at(const struct pair_table *t, uint32_t index)
{
    return (uint64_t)slot_of(t->at[index].a) << 32 | slot_of(t->at[index].b);
}

void msap_pairs_free(struct pair_table *t, struct memory *m);
int msap_pairs_reserve(struct pair_table *t, struct memory *m, size_t created, size_t deleted);
void msap_pairs_trim(struct pair_table *t, struct memory *m);
void msap_pairs_apply(struct pair_table *t, const struct box_table *boxes, const struct keys *fresh,
                      const struct keys *doomed);
uint32_t msap_pairs_find(const struct pair_table *t, uint32_t a, uint32_t b);
const char *msap_pairs_broken(const struct pair_table *t);

/* -------------------------------------------------------- axis.c, slide.c */

struct sap;
struct job;

/* An end point is one key, value:32 | is_max:1 | box:31, so that one integer
 * comparison orders by value, mins before maxes at equal values (boxes that touch
 * overlap), boxes last. The order is total: a set of boxes has one right array. 0
 * and UINT64_MAX are the sentinels: no legal bound encodes to them (paper,
 * appendix B), so infinities are ordinary values. */
#define KEY_MAX_BIT ((uint64_t)1 << 31)

static inline uint64_t key_make(int32_t value, uint32_t is_max, uint32_t box)
{
    return (uint64_t)((uint32_t)value ^ 0x80000000u) << 32 | (uint64_t)is_max << 31 | box;
}
static inline int32_t key_value(uint64_t key) { return (int32_t)((uint32_t)(key >> 32) ^ 0x80000000u); }
static inline uint32_t key_box(uint64_t key) { return (uint32_t)key & 0x7fffffffu; }
/* A box's min is end point 2 * box, its max 2 * box + 1. */
static inline uint32_t key_end(uint64_t key) { return (uint32_t)key << 1 | (uint32_t)key >> 31; }

/* One axis: the end points of the stored boxes, sorted, between two sentinels. */
struct axis {
    uint64_t *key;  /* [1 + 2 * stored + 1] */
    uint32_t *rank; /* the index of each end point's key: key_end(key[rank[e]]) == e */
    size_t room_key, room_rank;
};

int msap_axis_reserve(struct axis *x, struct memory *m, size_t slots);
void msap_axis_trim(struct axis *x, struct memory *m, size_t slots);
void msap_axis_slide(struct sap *s, uint32_t k, uint32_t box, const struct job *job);
void msap_axis_free(struct axis *x, struct memory *m);
void msap_axis_drop(struct axis *x, size_t stored, const struct box *boxes);
void msap_axis_merge(struct axis *x, size_t stored, uint64_t *incoming, size_t n);
void msap_axis_sort(struct axis *x, size_t stored, uint64_t *scratch);
const char *msap_axis_broken(const struct axis *x, size_t stored, const struct box_table *boxes, uint32_t k);

/* ------------------------------------------------------------------- sap.c */

/* A single SAP: one sorted array of end points for each axis. A box is in all of
 * them exactly if it has BOX_STORED. */
struct sap {
    uint32_t dims;
    size_t stored; /* boxes in the arrays */
    struct axis axis[3];
};

/* Room that a commit works in; its contents mean nothing between commits. */
struct scratch {
    uint64_t *at;
    size_t room;
};
void *msap_scratch_get(struct scratch *s, struct memory *m, size_t words);
void msap_scratch_free(struct scratch *s, struct memory *m);
#define SCRATCH_WORDS(slots) (4 * (slots) + 4) /* enough for most that is done to all boxes of a single SAP */
#define GRID_WORDS(slots) (3 * (slots) + (slots) / 4 + 4) /* and to those of a grid */

/* What a commit works on. */
struct job {
    struct box_table *boxes;
    struct pair_table *pairs;
    struct worker *worker; /* the calling thread's or, within a phase, the one at work */
    struct memory *memory;
    struct scratch *scratch;
    struct crew *crew;
    uint32_t filters;
};

void msap_sap_init(struct sap *s, uint32_t dims);
void msap_sap_free(struct sap *s, struct memory *m);
int msap_sap_reserve(struct sap *s, struct memory *m, size_t slots);
void msap_sap_trim(struct sap *s, struct memory *m, size_t slots);
uint32_t msap_sap_choose(const struct sap *s, const struct job *job);
void msap_sap_update(struct sap *s, struct job *job, uint32_t strategy);
const char *msap_sap_broken(const struct sap *s, const struct box_table *boxes);

/* ----------------------------------------------------------------- phase.c */

enum { FOUND_SLACK = 8 /* what a sweep may write behind the last that it finds */ };

/* What one thread of a phase writes. */
struct worker {
    struct settler settler;
    struct keys pairs; /* pairs of slots that were found */
    struct pool stock; /* while it moves boxes: room for neighbour lists */
    uint32_t *found;   /* [room_found] what sweeps have found */
    uint32_t *tag;     /* [slots] `token` marks what was found for a box */
    uint32_t token;
    size_t slots; /* that tags are ready for */
    size_t room_found, room_tag;
    size_t wanted; /* room to find that it lacked last */
};

/* Worker 0 is the calling thread; workers 1 ... size, if size > 1, run the tasks of
 * a phase, the first of them on the calling thread too. */
struct crew {
    uint32_t size;
    uint32_t grain; /* how many boxes' touches are worth a task */
    struct worker worker[1 + MOST_WORKERS];
    msap_enqueue_fn enqueue;
    msap_finish_fn finish;
    void *jobs_user;
};

/* Pairs on their way from where they are found to where they are settled: in between,
 * nothing depends on how many belong to one box, which no processor can guess. */
enum { MOST_BUFFERED = 512, BUFFER_SLACK = 16 /* what may be written behind the last */ };
struct pair_buffer {
    uint32_t a[MOST_BUFFERED + BUFFER_SLACK], b[MOST_BUFFERED + BUFFER_SLACK];
    size_t n;
};

/* What an item of a phase costs, roughly, in boxes that are touched and have few pairs:
 * some 6 nanoseconds each. Measured on scenes of 3,000 to 100,000 boxes. */
enum {
    WEIGHT_TOUCH = 1,    /* a box that is touched; two of its pairs; a test of a wide box */
    WEIGHT_KNOWN = 1,    /* a known pair */
    WEIGHT_FILL = 1,     /* a box that is written into a row */
    WEIGHT_ROWS = 2,     /* a box whose rows are found */
    WEIGHT_SORT = 2,     /* a key that is sorted */
    WEIGHT_UPDATE = 2,   /* a box that gets other bounds */
    WEIGHT_ROW_BOX = 2,  /* a box in the rows that are swept */
    WEIGHT_LEVELS = 4,   /* a box that asks other levels, where most need not */
    WEIGHT_SKIN = 6,     /* a skin that is fitted */
    WEIGHT_CELL_BOX = 8, /* a box in the cells that are swept */
    WEIGHT_QUERY = 16,   /* a box that asks its cells */
    WEIGHT_MOVE = 32     /* a box that gets a new skin: more, but boxes and lists change caches with it */
};

/* Works on items first ... last - 1. */
typedef void (*phase_fn)(void *context, struct worker *w, size_t first, size_t last);
void msap_crew_init(struct crew *crew, const msap_config *config);
int msap_crew_reserve(struct crew *crew, struct memory *m, size_t slots);
int msap_crew_room_to_find(struct crew *crew, struct memory *m, size_t n);
void msap_crew_trim(struct crew *crew, struct memory *m, size_t slots, size_t pairs);
void msap_crew_free(struct crew *crew, struct memory *m);
size_t msap_phase_tasks(const struct crew *crew, size_t n, size_t weight);
int msap_phase_run(struct crew *crew, struct memory *m, phase_fn run, void *context, size_t n, size_t weight);
int msap_worker_has_room(struct worker *w, size_t n, size_t slack);
void msap_worker_put(struct worker *w, uint64_t key);
void msap_worker_put_found(struct worker *w, uint32_t self, size_t n);
void msap_worker_new_token(struct worker *w);
int msap_worker_room_to_find(struct worker *w, size_t n, size_t more);

/* How many pairs a box has, by the last commit. */
static inline size_t pairs_of_a_box(const struct job *job) { return job->pairs->active / (job->boxes->live + 1); }

/* In how many steps candidates are found (renew.c). */
static inline size_t sweep_steps(const struct job *job)
{
    enum { FEW = 3, MOST = 4 };
    size_t steps = 1 + pairs_of_a_box(job) / FEW;
    return steps < MOST ? steps : MOST;
}

/* ----------------------------------------------------------------- merge.c */

void msap_share_sort_keys(const struct job *job, uint64_t *key, size_t n, uint64_t *scratch);
void msap_share_sort_values(const struct job *job, uint64_t *key, size_t n, uint64_t *scratch, float low,
                            float extent);

/* ----------------------------------------------------------------- prune.c */

/* Boxes in split arrays, sorted by their min on the sweep axis, which is stored as
 * axis 0; axis 2 of 2D boxes is all zeros. */
struct prune_set {
    size_t n;
    int32_t *min[3], *max[3];
    uint32_t *id;
};
#define PRUNE_SET_WORDS(n) (((n)*7 + 1) / 2) /* of 64 bits, for n boxes */

/* Receives the pairs that are found. */
typedef void (*prune_found)(void *context, uint32_t id_a, uint32_t id_b);

void msap_prune_set_place(struct prune_set *set, uint64_t *words, size_t n);
void msap_prune_set_put(struct prune_set *set, size_t row, const struct bounds *bounds, uint32_t axis,
                        uint32_t id);
void msap_prune_within(const struct prune_set *set, prune_found found, void *context);
void msap_prune_between(const struct prune_set *a, const struct prune_set *b, prune_found found, void *context);

/* ------------------------------------------------------------------ near.c */

enum {
    NEAR_UNIT = 4, /* entries of the smallest list */
    NEAR_LONG = 64 /* entries of a list that is not searched often */
};

/* In the entry for a neighbour above, besides its slot: exactly if the two boxes are a
 * pair, since the last commit. What of this changes in a commit is noted by the settler. */
#define NEAR_PAIR 0x80000000u

static inline uint32_t near_slot(uint32_t entry) { return entry & ~NEAR_PAIR; }

/* Whether a candidate that does not know yet what it is means nothing: a box of it was not there, or in cells,
 * when all others got skins. */
static inline int candidate_is_void(const struct box_table *t, uint32_t a, uint32_t b)
{
    const struct box *p = &t->at[a], *q = &t->at[b];
    return !(p->flags & q->flags & BOX_WAS) | ((p->level & q->level) != NO_LEVEL); /* which has all bits */
}

/* The neighbours of a box: slots above its own first. */
struct near_list {
    uint32_t *at; /* entries; NULL: no room */
    uint32_t n_above, n;
    uint32_t noted;   /* the list holds boxes that are not near any more: 1 + the next such list, else 0 */
    uint8_t class;    /* of its room in the pool */
    uint8_t searches; /* for boxes to be taken out of it, in round `round` */
    uint16_t round;
};

static inline uint32_t near_room(const struct near_list *l)
{
    return l->at ? NEAR_UNIT * (uint32_t)pool_units(l->class) : 0;
}

/* b is in the list of a exactly if a is in the list of b, and they are exactly if
 * the fat bounds of a and b overlap, not both are static and not both rest (near.c). */
struct near_lists {
    struct near_list *of; /* [slots] */
    size_t room;
    uint32_t first_noted; /* 1 + the slot of the first noted list; 0: none, as between commits */
    uint16_t round;       /* counts the times that the noted ones were tidied */
    struct pool pool;
};

int msap_near_join(struct near_lists *all, struct pool *p, struct memory *m, uint32_t a, uint32_t b, int is_pair);
int msap_near_make(struct near_lists *all, struct memory *m, const struct keys *pairs, size_t slots);
uint32_t msap_near_find(const struct near_list *l, uint32_t self, uint32_t other);
void msap_near_remove(struct near_lists *all, uint32_t self, uint32_t other);
void msap_near_tidy(struct near_lists *all, int (*is_near)(const void *context, uint32_t a, uint32_t b),
                    const void *context);
void msap_near_drop(struct near_lists *all, struct memory *m, uint32_t self);
void msap_near_take_out(struct near_list *l, uint32_t i);
void msap_near_empty(struct near_lists *all, struct memory *m, size_t slots);

/* ---------------------------------------------------------- cell.c, simd.c */

/* Fat bounds as a cell knows them: in steps of its level, rounded down, modulo 2^16. */
struct rounded {
    uint16_t low[4];  /* of min; the fourth means nothing */
    uint16_t high[4]; /* of max, negated */
};
enum { MOST_STEPS = 30000 }; /* that a box may be long which others are compared with */

/* What other boxes are compared with: they are apart from this one exactly if one of their values
 * is above, that is, if the difference of 16 bits has the upper one set. */
static inline struct rounded facing(const struct rounded *r)
{
    struct rounded f = {{0}, {0}};
    for (int k = 0; k < 3; k++) {
        f.low[k] = (uint16_t)(0u - r->high[k]);
        f.high[k] = (uint16_t)(0u - r->low[k]);
    }
    return f;
}

/* Eight boxes of a cell, each in a column. */
struct cell_block {
    uint16_t low[3][8], high[3][8]; /* rounded */
    uint32_t id[8];
};

/* The fat boxes that touch a cell; row r is column r % 8 of block r / 8. The first
 * n_moving rows are those of boxes that are not static. */
struct cell {
    struct cell_block *block;
    uint32_t n, n_moving, room;
};

/* low[3] and high[3] are rounded. */
static inline void cell_put_row(struct cell *c, uint32_t row, const uint16_t *low, const uint16_t *high,
                                uint32_t slot)
{
    struct cell_block *block = &c->block[row / 8];
    uint32_t column = row % 8;
    block->low[0][column] = low[0];
    block->low[1][column] = low[1];
    block->low[2][column] = low[2];
    block->high[0][column] = high[0];
    block->high[1][column] = high[1];
    block->high[2][column] = high[2];
    block->id[column] = slot;
}

int msap_cell_make_room(struct cell *c, struct pool *p, struct memory *m, uint32_t n);
int msap_cell_insert(struct cell *c, struct pool *p, struct memory *m, const struct rounded *r, uint32_t slot,
                     int is_static);
void msap_cell_update(struct cell *c, const struct rounded *r, uint32_t slot, int is_static);
void msap_cell_remove(struct cell *c, struct pool *p, struct memory *m, uint32_t slot, int is_static);
void msap_cell_sift(struct cell *c, struct pool *p, struct memory *m, const uint32_t *tag, uint32_t token);
void msap_cells_empty(struct cell *c, size_t n, struct pool *p, struct memory *m);
uint32_t msap_cell_row(const struct cell *c, uint32_t row, struct rounded *r);

typedef size_t (*sweep_fn)(const struct cell *c, uint32_t first, uint32_t last, const struct rounded *r,
                           uint32_t *out);

/* ---------------------------------------------------- grid.c, layout.c, skin.c */

enum { CELL_LIMIT = INT32_MAX / 2 + 1 }; /* no cell of a box is below its negative */

enum { LEVELS = 6, LEVEL_SHIFT = 2, TOP = LEVELS - 1, MOST_CELLS = 8 };
/* Cells of an axis-aligned block of the grid, low and high included. The fourth of each means nothing. */
struct range {
    int32_t low[4], high[4];
};

/* The cells of a box on its level: from which one, as wrapped, and how many more on each
 * axis. */
struct span {
    uint16_t low[3];
    uint8_t more[3];
    uint8_t level; /* NO_LEVEL: the slot has no live box */
    uint8_t is_static;
};

/* Where fat bounds are in a layout: their cells, and what these know of them. */
struct spot {
    struct range base;         /* the cells of level 0 */
    int32_t low[4], high[4];   /* in steps of level 0 */
    uint32_t level, cells;     /* on which they are to be, and in how many cells */
    struct rounded rounded;    /* what these know */
    uint32_t cell[MOST_CELLS]; /* their numbers among all */
};

/* A wrapped grid of count[0] * count[1] * count[2] cells: cell x of an axis is the
 * same as cell x + count. A cell of a level is 4 cells of the level before wide. */
struct level {
    struct cell *cell; /* the first of its cells among all */
    uint32_t count[4];
    size_t boxes;                        /* that are in this level */
    int32_t first_step[4], last_step[4]; /* what is beyond counts as there */
};

/* A choice of cells, and what is in them. */
struct layout {
    float scale[4];    /* floor(x * scale) counts units of an axis: powers of two; 0: all is one unit */
    float fine[4];     /* floor(x * fine) counts steps of level 0; those of the next are 4 times as wide */
    int is_told;       /* a unit is a cell of level 0, unless the grid is as told: then */
    int32_t origin[3]; /* from this unit on */
    int32_t width[3];  /* so many are */
    struct level level[LEVELS];
    struct cell *cell; /* of all levels */
    size_t n_cells, room_cell;
    size_t boxes;       /* in all levels */
    size_t chosen_for;  /* boxes in the world when it was chosen, and one; 0: there is no layout */
    uint32_t chosen_at; /* the commit in which it was */
};

enum { MOST_WIDE = 256 }; /* boxes that touch too many rows to be in any */

/* Rows along a sweep axis, by cells on the other two (jump.c). */
struct rows {
    uint32_t axis[3];   /* the sweep axis first */
    float low, extent;  /* most boxes lie from there on, within so much, on the sweep axis */
    float scale[2];     /* on the axes across, as layout.scale */
    uint32_t count[2];  /* powers of two */
    uint32_t shift;     /* count[0] is 1 << shift */
    size_t chosen_for;  /* boxes when they were chosen, and one; 0: not yet */
    uint32_t chosen_at; /* the commit in which they were */
};

/* Besides a slot in a row: its box starts in this row on the first or the second axis across;
 * it is not static. Two boxes are taken where one of them or the other has each mark. */
#define ROW_STARTS_1 0x80000000u
#define ROW_STARTS_2 0x40000000u
#define ROW_MOVES ((uint32_t)BOX_STATIC << ROW_SHIFT)
#define ROW_MARKS (ROW_STARTS_1 | ROW_STARTS_2 | ROW_MOVES)
enum { ROW_SHIFT = 27 }; /* from a flag to the mark of the boxes that do not have it */

static inline uint32_t row_slot(uint32_t id) { return id & ~ROW_MARKS; }

/* Boxes row after row, each row sorted by min[0], the sweep axis; split arrays. So that those can be found that
 * reach a place, `reach` tells of each REACH boxes of a row where they and those before them in the row end at
 * most on that axis, which only grows along a row. */
struct row_set {
    int32_t *min[3], *max[3];
    uint32_t *id;            /* slots with marks */
    int32_t *words;          /* all of them, one after the other, equally far apart */
    uint32_t *end;           /* [rows] behind the last entry of each row */
    int32_t *reach;          /* if it was noted (rows.c) */
    struct rows rows;        /* which rows these are */
    struct row_range *range; /* [slots] in which of them each box is; so that they can be kept (kept.c) */
    size_t slots;            /* 0: that is not known */
    size_t changed;          /* boxes that are in others than at the pruning before; all if that is not known */
    size_t room, room_end, room_reach, room_range;
};
enum { REACH = 8 };
enum { ROW_SLACK = 16 }; /* entries that may be read behind the last, and whose slots may be written */

int msap_row_set_make(struct row_set *set, struct memory *m, size_t entries);
void msap_row_set_close(struct row_set *set, size_t entries);
void msap_row_set_free(struct row_set *set, struct memory *m);
const char *msap_row_set_broken(const struct row_set *set);

/* Where the sweep of a row stands: entry i is to be tested against those from j on that are
 * before `end`, the row's, and then the others before `last`. Of a question only i and `end` mean something. */
struct row_sweep {
    uint32_t i, j, last, end;
};

/* Bounds that ask a row. */
struct row_question {
    int32_t min[3], max[3]; /* by axis of the rows */
    uint32_t lacks;         /* marks that what is taken has */
    uint32_t self;          /* the slot of the box that asks, if that is wanted */
};
/* Goes on with a sweep until i is `last` or `out` is full. Gives the slots of the pairs that are
 * taken. */
typedef void (*sweep_row_fn)(const struct row_set *set, struct row_sweep *at, struct pair_buffer *out);

/* How far the entries of a row reach, from its first one, `start`, on; those before `first` reach nobody who is still to
 * be tested. */
struct row_reach {
    const int32_t *at;
    uint32_t start, first;
};
/* The same from entries of a set through those of another one, of which `at` tells where j and `end` are. */
typedef void (*sweep_between_fn)(const struct row_set *set, const struct row_set *other, struct row_reach *reach,
                                 struct row_sweep *at, struct pair_buffer *out);

enum { ENTRIES_ASKED = 64 }; /* at a time */

/* Goes on with a question to a row: finds, among the next ENTRIES_ASKED entries from i on, those that have the
 * marks and overlap the bounds. Gives their slots, and writes up to FOUND_SLACK more behind them; returns how many
 * they are. i is `end` then if no other entry can overlap. */
typedef size_t (*ask_row_fn)(const struct row_set *set, const struct row_question *q, struct row_sweep *at,
                             uint32_t *out);

/* What goes over a cell, over a row, from one row over another, and what asks a row. */
struct sweeps {
    sweep_fn cell;
    sweep_row_fn row;
    sweep_between_fn between;
    ask_row_fn ask_row;
};
struct sweeps msap_sweeps_for(uint32_t simd);

/* The rows that a box is in: from which one and how many more on each axis across. */
struct row_range {
    uint32_t row; /* or NO_ROW: it is not pruned, or wide */
    uint8_t more[2];
    uint16_t is_static; /* BOX_STATIC or 0 */
};
#define NO_ROW UINT32_MAX

/* Rows in the making (rows.c). */
struct pruning {
    struct job *job;
    struct rows *rows;
    struct row_set *set;
    const struct row_set *last;   /* the rows of the pruning before, in the same set or in another one */
    size_t slots;                 /* of the boxes */
    struct bounds_by_slot bounds; /* of those that are pruned, in larger structs */
    uint64_t *order;              /* [n_listed] keys, by min on the sweep axis, of the boxes that are listed: */
    struct row_range *range;      /* [slots] */
    uint32_t *wide;               /* [n_wide] slots of the wide boxes */
    size_t n_listed, n_wide, entries;
    uint32_t *end;      /* [rows] behind the last box of each row that is listed */
    uint32_t *end_by;   /* [rows] the same of each worker but the calling thread's */
    uint8_t *has_moved; /* [slots] while rows are kept: 1: a box is not in the same ones any more; else NULL */
    uint32_t *kept_id;  /* and then: the last rows' slots with marks, */
    uint32_t *kept_end; /* [rows] and ends; if they are in another set, these are its own */
};

/* Skins, rows and candidates to come (renew.c). */
enum renewal_step {
    NO_RENEWAL,
    TRY_SKINS,
    MAKE_SKINS,
    MAKE_MORE_SKINS,
    COUNT_ROWS,
    SORT_ROWS,
    LIST_ROWS,
    FILL_ROWS,
    SWEEP_ROWS,
    CHANGE_SKINS
};
enum renewal_pace { AT_EASE, IN_A_HURRY, IN_A_RUSH }; /* one after each commit; some by twos; most */
struct renewal {
    enum renewal_step next;
    int is_told; /* 1: the candidates that are found know what they are */
    enum renewal_pace pace;
    struct bounds *fat; /* [slots] the skins of boxes that are fitted */
    size_t slots, room_fat;
    struct rows rows;
    struct row_set set;
    struct pruning pruning;   /* of all boxes by these, from one step to the next; */
    struct scratch words;     /* what it works in */
    uint32_t wide[MOST_WIDE]; /* the wide boxes of it */
    size_t swept;             /* entries and then, each as so many (renew.c), wide boxes that were; */
    struct keys found;        /* candidates of these, */
    size_t by_rows;           /* the first of which so many are of entries */
};

/* What skins cost (choose.c), in tests, and how long they last. */
struct upkeep {
    uint32_t since;      /* the commit in which the present skins were made, or cells and lists, */
    uint32_t begun;      /* and that in which those to come were */
    int is_first;        /* 1: they are the first ones, for no motion */
    uint32_t made_for;   /* so many commits */
    uint32_t horizon;    /* and as many the next ones */
    uint32_t not_before; /* the commit from which on there may be a renewal */
    uint32_t tried;      /* the commit after which skins were tried; 0: none */
    uint32_t wait;       /* for how many commits there was none when it had not paid last; 0: it has */
    int64_t pruning;     /* what it would have cost in the last commit to prune instead */
    int64_t move;        /* what it costs to put a box elsewhere, */
    int64_t lately;      /* those that were in each of the last few commits, */
    int64_t spent;       /* and since `since` */
};

/* Boxes that are pruned in every commit while all others, calm ones, are not (restless.c). While there are some, the
 * bounds before of a calm box that has not changed are what it is now, and the rows hold all calm boxes as they are. */
struct restless {
    uint32_t *slot; /* [n] in any order; none while the rows hold all boxes */
    size_t n, room;
    struct row_set set; /* them alone, in the same rows, for a commit */
    size_t wide;        /* how many touched too many rows in the last commit: they stay restless */
    size_t idle;        /* how many others stood still, in all commits since all were pruned or some calmed */
    size_t newcomers;   /* how many joined them in the last commit */
};

enum { MOST_WATCHED = 16 };

/* Some of the boxes that changed in the last commit: whether it will be the same ones again (choose.c). */
struct watch {
    uint32_t slot[MOST_WATCHED]; /* watched boxes are in slots of the table */
    size_t n, of; /* so many of so many */
};

/* With which others each box made a pair when this was noted; while boxes rest as they are (partners.c). */
struct partners {
    uint32_t *end;   /* [slots] where those of a box end; those of the next one follow */
    uint32_t *other; /* slots */
    size_t room_end, room_other;
    size_t slots; /* 0: it was not noted */
    size_t asked; /* for so many boxes that moved rows were asked instead */
};

/* A Multi-SAP: boxes with a skin in the cells that they touch, and the neighbour
 * lists that follow from them. New cells are those of the current layout; while the
 * other one still holds boxes, they are moved over, some in each commit. */
struct grid {
    const msap_config *config;
    struct box_table *boxes; /* the world's */
    struct sweeps sweeps;
    struct layout layout[2];
    uint32_t current;
    uint32_t next_to_move; /* slot */
    struct pool pool;      /* of the cells */
    struct near_lists near;
    size_t slots;    /* of the box table that lists are ready for */
    uint32_t commit; /* counts commits, for the age of skins */
    size_t moves;    /* boxes that the last commit put into other cells or gave a new skin */
    int is_empty;    /* no box is in any cell or list */
    int is_tracking; /* cells and lists are up to date; 0 after a commit that kept nothing */
    int is_jumping;  /* the last commit kept nothing but rows, because that was cheaper */
    int is_resting; /* while is_tracking: boxes of the last commit that are in no cell rest in the rows (rest.c) */
    int in_skins;   /* while is_resting: in their skins (renew.c), which the rows hold */
    int rows_hold_skins;    /* while is_resting: so they do, even if boxes rest as they are */
    struct keys candidates; /* while in_skins: see candidates.c; a << 32 | entry for b */
    size_t untold;          /* so many of them, the first ones, do not know yet what they are */
    uint32_t quiet;         /* while in_skins: for how many commits so few changed that skins do not pay */
    struct renewal renewal;
    struct upkeep upkeep;
    int64_t gain;   /* in tests: what cells and lists have saved since they were made or could be again; or,
                        while nothing is kept, would have since */
    uint32_t doubt; /* how many boxes more than one move for each that is foreseen to, in sixteenths */
    struct rows rows;
    struct row_set row_set;   /* of all boxes that were pruned last, as they were then or with their skins, */
    uint32_t wide[MOST_WIDE]; /* but for these; while is_jumping, and but for restless ones */
    size_t n_wide;
    struct restless restless;
    struct watch watch;
    struct partners partners;
    size_t wide_found;      /* how many wide boxes there were, even if more, when they were counted last; */
    size_t wide_pruned;     /* and how many, if they had skins, with these; */
    uint32_t wide_found_in; /* in which commit */
    struct keys known;      /* if knows_pairs, the keys of all active pairs, sorted */
    int knows_pairs;
    int will_know_pairs; /* within a commit: once it has succeeded, it knows them */
    int will_rest;       /* the same: static boxes rest from then on, and all others are put into cells */
};

/* Whether a box rests: it is in no cell, and the rows hold it, as it was at the last commit or with its
 * skin. One that was removed does until the commit is over. */
static inline int rests(const struct grid *g, const struct box *b)
{
    return g->is_resting && b->level == NO_LEVEL && (b->flags & BOX_WAS);
}

/* The bounds by which a box has neighbours. */
static inline const struct bounds *bounds_in_grid(const struct grid *g, uint32_t slot)
{
    const struct box *b = &g->boxes->at[slot];
    return rests(g, b) && !g->in_skins ? box_before(g->boxes, slot) : &b->fat;
}

/* The rows are not for skins any more: other ones suit boxes as they are. */
static inline void forget_rows_of_skins(struct grid *g)
{
    if (g->rows_hold_skins) g->rows.chosen_for = 0;
    g->rows_hold_skins = 0;
}

void msap_grid_init(struct grid *g, const msap_config *config, struct box_table *boxes);
void msap_grid_empty_cells(struct grid *g, struct memory *m);
void msap_grid_empty(struct grid *g, struct memory *m);
void msap_grid_free(struct grid *g, struct memory *m);
void msap_grid_trim(struct grid *g, struct memory *m, size_t slots);
int msap_grid_reserve(struct grid *g, struct memory *m, size_t slots);
struct range msap_range_as_told(const struct layout *l, struct range units);
uint32_t msap_level_for(const struct range *base);
int msap_grid_put(struct grid *g, struct memory *m, uint32_t slot, int is_static, const struct spot *spot);
void msap_grid_take(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range base);
int msap_grid_move(struct grid *g, struct memory *m, uint32_t slot, int is_static, struct range from,
                   const struct spot *to);
size_t msap_grid_find(const struct grid *g, struct worker *w, uint32_t self, int is_static,
                      const struct spot *spot);
void msap_grid_query(const struct grid *g, struct worker *w, uint32_t self, int is_static, uint32_t first,
                     uint32_t last);
int msap_layout_choose(struct grid *g, struct memory *m, const struct box_table *boxes, size_t n);
void msap_layout_empty(struct layout *l, struct pool *p, struct memory *m);
void msap_layout_free(struct layout *l, struct memory *m);
int msap_layout_adapt(struct grid *g, struct memory *m, const struct box_table *boxes);

enum { WIDEST_CELL = 120 }; /* 2^WIDEST_CELL; wider ones would need a subnormal scale */

/* What a sample of the boxes says about an axis. */
struct spread {
    double size;   /* three in four boxes are not wider */
    double low;    /* most boxes lie from here on */
    double extent; /* within so much */
    double step;   /* so far do they come in this commit, in the mean, but none further than it is wide */
    int exponent;  /* a cell is 2^exponent wide */
};
void msap_spread_of(const struct box_table *boxes, const struct bounds_by_slot *bounds, struct spread s[3]);
double msap_power_of_two(int exponent);
int msap_exponent_for(double value);
double msap_cells_on(const struct spread *s);
uint32_t msap_count_for(double cells);
int msap_is_outgrown(size_t chosen_for, size_t boxes);

void msap_skin_renew(const struct grid *g, uint32_t slot, uint32_t vain);
void msap_skins_make(const struct grid *g, struct bounds *fat, size_t first, size_t last, size_t step);
int msap_most_crawl(const struct grid *g);
double msap_skin_growth(const struct grid *g, uint32_t slot, float *commits);
int msap_skin_will_be_left(const struct grid *g, uint32_t slot, uint32_t commits);
void msap_skin_make_wide(const struct grid *g, struct bounds *fat, uint32_t slot, float others);
void msap_skins_put_on(const struct grid *g, struct box_table *t, int are_new);
void msap_skin_first(const struct grid *g, uint32_t slot);
int msap_skin_is_far_wider(const struct grid *g, uint32_t slot);
float msap_skin_lifetime(const struct grid *g, uint32_t slot);

/* In commits; after very many it starts again. */
static inline uint32_t skin_age(const struct grid *g, uint32_t slot)
{
    return (uint16_t)(g->commit - g->boxes->past[slot].since);
}

/* Whether a skin is older than any is made for, as first ones are from the start. */
static inline int skin_is_old(const struct grid *g, uint32_t slot) { return skin_age(g, slot) > HORIZON_MOST; }

/* Whether the box has shrunk so much in its skin that it needs a new one. */
static inline int skin_is_baggy(const struct grid *g, uint32_t slot)
{
    return skin_is_old(g, slot) && msap_skin_is_far_wider(g, slot);
}

/* --------------------------------------------------------- move.c, share.c */

/* So many layers of the cells of level 0 across an axis, from the first on and around the end: what
 * one of several workers that move boxes may change. */
struct region {
    uint32_t axis, first, layers;
};

/* How far a move has come. */
enum {
    MOVE_WAITS,
    MOVE_PLACED, /* within msap_move_few: the box has its new skin and is in its cells */
    MOVE_DONE,   /* and it has a list of its neighbours */
    MOVE_STUCK   /* placed, and its list is left to the calling thread */
};

enum { MOVES_AT_ONCE = 32 }; /* boxes whose cells are still in the cache when they are asked */

int msap_move_few(struct grid *g, const struct job *job, const struct region *own, const uint32_t *slot,
                  uint8_t *state, size_t n);
int msap_enter_all(struct grid *g, const struct job *job, const uint32_t *slot, size_t n);
int msap_place_all(struct grid *g, const struct job *job, const uint32_t *slot, size_t n);
int msap_finish_move(struct grid *g, const struct job *job, uint32_t slot);
int msap_is_near(const void *grid, uint32_t a, uint32_t b);
const uint64_t *msap_order_by_cell(const struct grid *g, const struct job *job, uint32_t *slot, size_t n);
uint8_t *msap_share_moves(struct grid *g, const struct job *job, uint32_t *slot, size_t n);

/* ------ choose.c, rebuild.c, jump.c, compare.c, track.c, touch.c, grid_check.c */

enum way {
    TRACK,
    REST,
    REBUILD,
    JUMP_OR_TRACK, /* where a scene is not suited */
    JUMP_OR_REBUILD,
    JUMP_INTO_SKINS,
    PRUNE_RESTLESS,
    CALM_AND_PRUNE
};
void msap_watch(struct grid *g);
size_t msap_count_newcomers(const struct grid *g);
enum way msap_choose(struct grid *g, const struct job *job, size_t misplaced);
int msap_grid_rebuild(struct grid *g, struct job *job);
enum { UNSUITED = 2 };
int msap_grid_jump(struct grid *g, struct job *job);
int msap_grid_jump_into_skins(struct grid *g, struct job *job);
void msap_partners_note(struct grid *g, const struct job *job);
int msap_partners_settle(struct grid *g, struct settler *s, uint32_t slot);
void msap_partners_forget(struct grid *g);
void msap_partners_free(struct grid *g, struct memory *m);
const char *msap_partners_broken(const struct grid *g, const struct pair_table *pairs);
int msap_grid_prune_restless(struct grid *g, struct job *job, int calms);
void msap_wide_note(struct grid *g, const struct pruning *p);
int64_t msap_wide_pairs(const struct grid *g, const struct pair_table *pairs);
void msap_restless_forget(struct grid *g);
void msap_restless_free(struct grid *g, struct memory *m);
const char *msap_restless_broken(const struct grid *g);
void msap_renewal_begin(struct grid *g, struct job *job);
void msap_renewal_go_on(struct grid *g, struct job *job);
int64_t msap_trial_count(const struct grid *g);
int msap_renewal_at_once(struct grid *g, struct job *job);
void msap_renewal_free(struct renewal *r, struct memory *m);
void msap_upkeep_begins(struct grid *g);
void msap_upkeep_starts(struct grid *g);
enum renewal_pace msap_renewal_pace(const struct grid *g, const struct job *job);
int msap_renewal_is_due(struct grid *g, const struct job *job);
void msap_renewal_was_made(struct grid *g, const struct job *job, int is_at_once);
void msap_renewal_failed(struct grid *g);
int msap_candidates_touch(struct grid *g, struct job *job);
int msap_candidates_find(struct grid *g, struct job *job, const uint32_t *slot, size_t n);
int msap_rest_begin(struct grid *g, struct job *job, size_t n);
void msap_rest_mark(const struct grid *g, struct box_table *t);
int msap_rest_part(struct grid *g, const struct job *job, uint32_t slot);
size_t msap_rest_ask(const struct grid *g, struct worker *w, const struct bounds *where, int is_static, size_t n);
size_t msap_rest_find(const struct grid *g, struct worker *w, const struct bounds *where, int is_static,
                      uint32_t flags, size_t n);
const char *msap_rest_broken(const struct grid *g);
int msap_compare_is_worth_it(const struct grid *g, const struct job *job);
int msap_compare(struct grid *g, struct job *job);
const char *msap_known_broken(const struct grid *g, const struct pair_table *pairs);
uint32_t msap_grid_update(struct grid *g, struct job *job, uint32_t strategy);
void msap_grid_prepare(struct grid *g, struct job *job);
int msap_grid_touch(const struct grid *g, struct job *job);
void msap_grid_committed(struct grid *g, const struct settler *s);
void msap_grid_count(const struct grid *g, msap_world_stats *stats);
const char *msap_grid_broken(const struct grid *g, const struct box_table *boxes, const struct pair_table *pairs);

/* ----------------------------------------------------------------- world.c */

static inline int is_grid(const msap_config *c) { return c->grid != MSAP_GRID_NONE; }

struct msap_world {
    struct memory memory;
    msap_config config; /* as it was created with */
    struct box_table boxes;
    struct sap sap;   /* if config.grid is MSAP_GRID_NONE */
    struct grid grid; /* if not */
    struct pair_table pairs;
    struct crew crew;
    struct scratch scratch;
    int busy;  /* 1 while an owner call runs: calls from inside its callbacks are refused */
    int stale; /* 1: axes or cells fell behind the boxes for want of memory; the next commit makes them anew */
    uint32_t idle_commits; /* in a row in which the world used far less than it holds */
    uint64_t commits, strategy_used[4];
    uint32_t error_status, error_bound;
    uint64_t error_index;
};

msap_status msap_world_begin(msap_world *w);
msap_status msap_world_end(msap_world *w, msap_status status);
void msap_world_trim(msap_world *w);
msap_status msap_world_fail(msap_world *w, msap_status status, uint64_t index, uint32_t bound);

#endif
