/* Skins: how much larger than a box its fat bounds are, so that it can move for a
 * while without touching any structure.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A box that leaves its skin gets a new one, made for the next `horizon` commits:
 * it reaches as far ahead as the box comes in that time if it goes on as in this
 * commit, and on all sides a part of that, `wobble` eighths of it. A wide skin costs
 * tests of neighbours that are no pairs, a narrow one is left soon. So both follow
 * what the last skin came to. Left long before its time, it did not fit the motion:
 * the next one is wider on the sides, or, when that has not helped, for half as
 * long. If it held, the next is for longer, unless the tests of neighbours in vain
 * outweighed the work of a move. And no such skin reaches further than the box is large:
 * boxes that jump have none. Skins that all boxes get together (renew.c) are made for the same time for all, and
 * may reach further.
 *
 * Far from the origin floats are coarse: a slow box stands still in most commits and then
 * takes a step of a whole unit in the last place, on one axis or another. Where steps are
 * so small, the motion is the mean one since the box got its last skin.
 *
 * Only the speed depends on a skin, never the answer, as long as the fat bounds
 * contain the box; that is made sure on integers at the end. */
#include "internal.h"

static const float FAR = 1e30f; /* no skin for what is larger */

enum { HORIZON_LEAST = 3, WOBBLE_MOST = 4, TESTS_OF_A_MOVE = 160, LONG = 16 /* commits, for a skin */ };

/* Learns from a skin that was left at the age of so many commits; `vain` is how many
 * of its neighbours the box does not overlap. */
static void learn(struct box *b, uint32_t age, uint32_t vain)
{
    uint32_t horizon = b->horizon;
    if (age * (horizon < LONG ? 1 : 3) < horizon) {
        if (b->wobble < WOBBLE_MOST) b->wobble++;
        else horizon -= horizon / 2;
    } else if ((uint64_t)vain * age > TESTS_OF_A_MOVE) {
        horizon -= horizon / 4;
    } else horizon += horizon / 4 + 1;
    b->horizon = (uint8_t)(horizon < HORIZON_MOST ? horizon : HORIZON_MOST);
}

static float value_of(int32_t ordered) { return float_from_bits(float_bits_from_ordered(ordered)); }

/* ------------------------------------------------------------------ motion */

/* What a box did in this commit or, between commits, in the last one. */
enum deed { NOTHING, MOVED, CAME };

static enum deed deed_of(const struct box_table *t, uint32_t slot)
{
    const struct bounds *before = &t->past[slot].before;
    if (t->at[slot].changed_in != t->epoch - (t->n_changed == 0)) return NOTHING;
    return before->min[0] > before->max[0] ? CAME : MOVED;
}

/* Where it was before. One that was not there has not moved. */
static const struct bounds *moved_from(const struct box_table *t, uint32_t slot, enum deed deed)
{
    return deed == MOVED ? &t->past[slot].before : &t->at[slot].now;
}

enum { CRAWL = 4 /* units in the last place, that one who crawls comes in a commit at the most */ };

/* For how many commits a box has had its skin, if its mean motion since then may say more than this
 * commit's; or 0. */
static inline uint32_t crawl_time(const struct grid *g, uint32_t slot, enum deed deed)
{
    uint32_t age = skin_age(g, slot);
    if (deed == CAME || age <= 1 || age >= HORIZON_MOST) return 0;
    return g->in_skins || g->boxes->at[slot].level != NO_LEVEL ? age : 0;
}

/* How the box moves: its bounds, and how far they go down and up in a commit, by this one or, where
 * it crawls, by all since it got its skin. Infinite bounds make NaNs of what depends on them. */
#if defined(__SSE2__)

struct motion {
    __m128 low, high, down, up;
    float size, step; /* the largest of all axes */
    enum deed deed;
};

/* The three floats of ordered integers, and behind them a 0. */
static inline __m128 values_of(__m128i bits)
{
    bits = _mm_xor_si128(bits, _mm_srli_epi32(_mm_srai_epi32(bits, 31), 1));
    return _mm_castsi128_ps(_mm_and_si128(bits, _mm_set_epi32(0, -1, -1, -1)));
}

/* The largest of three positive floats, and in lane 1 that of three others. */
static inline __m128 largest_of_both(__m128 v, __m128 u)
{
    __m128 most = _mm_max_ps(_mm_unpacklo_ps(v, u), _mm_unpackhi_ps(v, u));
    return _mm_max_ps(most, _mm_movehl_ps(most, most));
}

static inline __m128 choose_floats(__m128i which, __m128 a, __m128 b)
{
    return _mm_castsi128_ps(choose_lanes(which, _mm_castps_si128(a), _mm_castps_si128(b)));
}

/* On which axes none of the values is more than `most` from 0. */
static inline __m128i are_within(__m128i values, int32_t most)
{
    return _mm_and_si128(_mm_cmpgt_epi32(values, _mm_set1_epi32(-most - 1)),
                         _mm_cmpgt_epi32(_mm_set1_epi32(most + 1), values));
}

/* How far min has come since the box got its skin, in units; of one that crawled since it is less than 2^15. */
static inline __m128i way_of(const struct grid *g, uint32_t slot)
{
    __m128i start = _mm_loadl_epi64((const __m128i *)(const void *)g->boxes->past[slot].start);
    __m128i way = _mm_sub_epi32(load_bounds(g->boxes->at[slot].now.min), _mm_unpacklo_epi16(start, start));
    return _mm_srai_epi32(_mm_slli_epi32(way, 16), 16);
}

static ALWAYS_INLINE struct motion motion_of(const struct grid *g, uint32_t slot)
{
    struct motion m;
    m.deed = deed_of(g->boxes, slot);
    const struct bounds *now = &g->boxes->at[slot].now, *before = moved_from(g->boxes, slot, m.deed);
    const __m128 zero = _mm_setzero_ps(), sign = _mm_set1_ps(-0.0f);
    __m128i min = load_bounds(now->min), step = _mm_sub_epi32(min, load_bounds(before->min));
    m.low = values_of(min);
    m.high = values_of(load_bounds(now->max));
    m.down = _mm_sub_ps(m.low, values_of(load_bounds(before->min)));
    m.up = _mm_sub_ps(m.high, values_of(load_bounds(before->max)));
    __m128i axes = are_within(step, CRAWL);
    uint32_t commits = _mm_movemask_ps(_mm_castsi128_ps(axes)) & 7 ? crawl_time(g, slot, m.deed) : 0;
    if (commits > 0) {
        __m128i way = way_of(g, slot);
        axes = _mm_and_si128(axes, are_within(way, CRAWL * (int32_t)commits));
        __m128 mean =
            _mm_div_ps(_mm_sub_ps(m.low, values_of(_mm_sub_epi32(min, way))), _mm_set1_ps((float)commits));
        m.down = choose_floats(axes, mean, m.down);
        m.up = choose_floats(axes, mean, m.up);
    }
    __m128 steps =
        _mm_max_ps(_mm_max_ps(_mm_andnot_ps(sign, m.down), zero), _mm_max_ps(_mm_andnot_ps(sign, m.up), zero));
    __m128 most = largest_of_both(_mm_max_ps(_mm_sub_ps(m.high, m.low), zero), steps);
    m.size = _mm_cvtss_f32(most);
    m.step = _mm_cvtss_f32(_mm_shuffle_ps(most, most, _MM_SHUFFLE(1, 1, 1, 1)));
    return m;
}

/* The lower, and the higher, of integers. */
static inline __m128i lower_of(__m128i a, __m128i b) { return choose_lanes(_mm_cmpgt_epi32(b, a), a, b); }
static inline __m128i higher_of(__m128i a, __m128i b) { return choose_lanes(_mm_cmpgt_epi32(a, b), a, b); }

/* Makes the fat bounds of a box for so many commits, and wider on both sides by `aside` and so many units
 * in the last place: but never NaNs, whatever a compiler thinks of these, so limits are those of integers. */
static ALWAYS_INLINE void reach_out(const struct bounds *now, struct bounds *fat, const struct motion *m,
                                    float horizon, float aside, int32_t units)
{
    const __m128 zero = _mm_setzero_ps(), ahead = _mm_set1_ps(horizon), more = _mm_set1_ps(aside);
    const __m128i most = _mm_set1_epi32(ORDERED_INF), least = _mm_set1_epi32(ORDERED_MINUS_INF);
    __m128 low = _mm_sub_ps(_mm_add_ps(m->low, _mm_mul_ps(_mm_min_ps(m->down, zero), ahead)), more);
    __m128 high = _mm_add_ps(_mm_add_ps(m->high, _mm_mul_ps(_mm_max_ps(m->up, zero), ahead)), more);
    __m128i min = _mm_sub_epi32(encode_lanes(_mm_castps_si128(low)), _mm_set1_epi32(units)),
            max = _mm_add_epi32(encode_lanes(_mm_castps_si128(high)), _mm_set1_epi32(units));
    min = lower_of(higher_of(min, least), load_bounds(now->min));
    max = higher_of(lower_of(max, most), load_bounds(now->max));
    store_bounds(fat, min, max);
}

#else

struct motion {
    float low[3], high[3], down[3], up[3];
    float size, step; /* the largest of all axes */
    enum deed deed;
};

static float larger(float a, float b) { return a > b ? a : b; }
static float magnitude(float x) { return x < 0 ? -x : x; }

static int is_within(int64_t value, int64_t most) { return -most <= value && value <= most; }

/* How far min has come on an axis since the box got its skin, in units; of one that crawled since it is less than
 * 2^15. */
static int32_t way_of(const struct grid *g, uint32_t slot, int k)
{
    uint32_t way = ((uint32_t)g->boxes->at[slot].now.min[k] - g->boxes->past[slot].start[k]) & 0xffff;
    return (int32_t)way - (way > 0x7fff ? 0x10000 : 0);
}

static ALWAYS_INLINE struct motion motion_of(const struct grid *g, uint32_t slot)
{
    struct motion m;
    m.deed = deed_of(g->boxes, slot);
    const struct bounds *now = &g->boxes->at[slot].now, *before = moved_from(g->boxes, slot, m.deed);
    uint32_t commits = crawl_time(g, slot, m.deed);
    m.size = m.step = 0;
    for (int k = 0; k < 3; k++) {
        int32_t way = way_of(g, slot, k);
        m.low[k] = value_of(now->min[k]);
        m.high[k] = value_of(now->max[k]);
        m.down[k] = m.low[k] - value_of(before->min[k]);
        m.up[k] = m.high[k] - value_of(before->max[k]);
        if (commits > 0 && is_within((int64_t)now->min[k] - before->min[k], CRAWL) &&
            is_within(way, CRAWL * (int64_t)commits))
            m.down[k] = m.up[k] =
                (m.low[k] - value_of((int32_t)((uint32_t)now->min[k] - (uint32_t)way))) / (float)commits;
        m.size = larger(m.high[k] - m.low[k], m.size);
        m.step = larger(magnitude(m.down[k]), larger(magnitude(m.up[k]), m.step));
    }
    return m;
}

/* Encoded and moved by so many units, but never as a NaN. */
static int32_t ordered_of(float value, int32_t units)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    int64_t ordered = (int64_t)ordered_from_float_bits(bits) + units;
    if (ordered < ORDERED_MINUS_INF) return ORDERED_MINUS_INF;
    return ordered > ORDERED_INF ? ORDERED_INF : (int32_t)ordered;
}

/* Makes the fat bounds of a box for so many commits, and wider on both sides by `aside` and so many units
 * in the last place. */
static void reach_out(const struct bounds *now, struct bounds *fat, const struct motion *m, float horizon,
                      float aside, int32_t units)
{
    for (int k = 0; k < 3; k++) {
        float low = m->low[k] + (m->down[k] < 0 ? m->down[k] * horizon : 0) - aside;
        float high = m->high[k] + (m->up[k] > 0 ? m->up[k] * horizon : 0) + aside;
        int32_t min = ordered_of(low, -units), max = ordered_of(high, units);
        fat->min[k] = min < now->min[k] ? min : now->min[k];
        fat->max[k] = max > now->max[k] ? max : now->max[k];
    }
}

#endif

/* From 0 to 255, by slot and commit. */
static inline uint32_t chance(uint32_t slot, uint32_t commit)
{
    return ((slot ^ commit * 0x85ebca6bu) * 0x9e3779b1u) >> 24;
}

/* From 1/2 to 1: so that boxes that set out together do not all
 * leave their skins in one commit. */
static float spread(uint32_t slot, uint32_t commit) { return 0.5f + (float)chance(slot, commit) / 512; }

/* For how many commits the box would go on within so many times its own size, `most` at the most. */
static float reach(const struct motion *m, float most, float sizes)
{
    return m->step * most <= m->size * sizes ? most : m->size * sizes / m->step;
}

/* ------------------------------------------------------------------- skins */

/* Makes the skin for a box's motion. */
static void follow(struct box *b, const struct motion *m, float part)
{
    float horizon = reach(m, b->horizon, 1);
    if (!(horizon >= HORIZON_LEAST && m->size < FAR)) return;
    b->horizon = (uint8_t)horizon;
    horizon *= part;
    reach_out(&b->now, &b->fat, m, horizon, m->step * horizon * (float)b->wobble / 8, 0);
}

/* The skin that a box is about to get starts in this commit, where the box is now; it counts as so
 * many commits old. */
static void start(const struct grid *g, uint32_t slot, uint32_t age)
{
    const struct box *b = &g->boxes->at[slot];
    struct past *past = &g->boxes->past[slot];
    past->since = (uint16_t)(g->commit - age);
    for (int k = 0; k < 3; k++) past->start[k] = (uint16_t)b->now.min[k];
}

/* Gives a box that has left its skin in this commit a new one. */
void msap_skin_renew(const struct grid *g, uint32_t slot, uint32_t vain)
{
    struct box *b = &g->boxes->at[slot];
    if (g->config->margin >= 0) {
        start(g, slot, 0);
        b->fat = msap_bounds_widened(&b->now, g->config->margin);
        return;
    }
    struct motion m = motion_of(g, slot);
    learn(b, skin_age(g, slot), vain);
    start(g, slot, 0);
    b->fat = b->now;
    follow(b, &m, spread(slot, g->commit));
}

/* Whether the fat bounds are far wider on every axis than any skin is made. */
int msap_skin_is_far_wider(const struct grid *g, uint32_t slot)
{
    enum { FAR_WIDER = 8 };
    const struct box *b = &g->boxes->at[slot];
    if (g->config->margin >= 0) return 0;
    for (uint32_t k = 0; k < g->config->dims; k++)
        if (!(value_of(b->fat.max[k]) - value_of(b->fat.min[k]) >
              FAR_WIDER * (value_of(b->now.max[k]) - value_of(b->now.min[k]))))
            return 0;
    return 1;
}

/* For how many commits the skin would last that a box got in this one, if it moved on. */
float msap_skin_lifetime(const struct grid *g, uint32_t slot)
{
    struct motion m = motion_of(g, slot);
    float margin = g->config->margin, horizon;
    if (margin >= 0) {
        horizon = m.step * HORIZON_MOST <= margin ? HORIZON_MOST : margin / m.step;
        return horizon >= 1 ? horizon : 1;
    }
    horizon = reach(&m, HORIZON_MOST, 1);
    return horizon >= HORIZON_LEAST ? horizon * 3 / 4 : 1;
}

/* A box that comes into the grid has no past to learn from. Unless a margin is given or
 * it is static, it gets a skin for its motion or, if it has none yet, up to three eighths of
 * its size on all sides: of all widths, so that boxes that are put in together and then
 * start to move do not all leave their first skins in one commit. */
void msap_skin_first(const struct grid *g, uint32_t slot)
{
    struct box *b = &g->boxes->at[slot];
    start(g, slot, HORIZON_MOST); /* however soon it is left, it was good enough */
    if (g->config->margin >= 0) {
        b->fat = msap_bounds_widened(&b->now, g->config->margin);
        return;
    }
    b->fat = b->now;
    if (b->flags & BOX_STATIC) return;
    struct motion m = motion_of(g, slot);
    float part = spread(slot, g->commit), aside = m.size * (part - 0.5f) * 3 / 4;
    if (m.step > 0) follow(b, &m, part);
    else if (aside < FAR) reach_out(&b->now, &b->fat, &m, 0, aside, 0);
}

/* ------------------------------------------------------------------ renewals */

enum { STEADY_SIZES = 3 /* of its own that a box may reach ahead if it moves as foreseen */, LEAST_PART = 32 };

/* Makes the skin of a box, which is its bounds before, to last as long as all others', between commits: it may be
 * far longer than the box if that moved as was foreseen before. A box that is new may move anywhere; one that
 * stands still may tremble; and a step of floats that are far apart is soon made. The skin of one that is larger
 * than `largest` is as if it were not. */
static ALWAYS_INLINE void skin_ahead(const struct grid *g, uint32_t slot, float largest, struct bounds *fat)
{
    enum { STEP_ASIDE = 2 };
    const struct box *b = &g->boxes->at[slot];
    if (g->config->margin >= 0 || b->flags & BOX_STATIC) {
        *fat = g->config->margin >= 0 ? msap_bounds_widened(&b->now, g->config->margin) : b->now;
        return;
    }
    struct motion m = motion_of(g, slot);
    int has_end = m.size < FAR;
    if (m.size > largest) m.size = largest;
    float horizon = reach(&m, (float)g->upkeep.horizon, b->wobble == 0 ? STEADY_SIZES : 1),
          aside = m.step * horizon * (float)b->wobble / 8;
    float least = m.size * (float)(m.deed == CAME ? 12 : 1 + 2 * b->wobble) / LEAST_PART;
    if (has_end) reach_out(&b->now, fat, &m, horizon, aside > least ? aside : least, STEP_ASIDE);
    else *fat = b->now;
}

/* Makes the skins of the boxes that are live in every step-th slot from `first` on; what others get means nothing.
 * A box that has left its last one in this commit has learnt: the next one is wider. */
void msap_skins_make(const struct grid *g, struct bounds *fat, size_t first, size_t last, size_t step)
{
    for (size_t slot = first; slot < last; slot += step) {
        struct box *b = &g->boxes->at[slot];
        if (!(b->flags & BOX_LIVE)) {
            fat[slot] = b->now;
            continue;
        }
        if (box_has_left(b) && b->flags & BOX_FITTED && b->wobble < WOBBLE_MOST) b->wobble++;
        skin_ahead(g, (uint32_t)slot, FAR, &fat[slot]);
        b->flags |= BOX_FITTED;
    }
}

/* Makes the skin of a box that is far larger than most others: it meets so many that its skin must not be wider
 * than theirs are, which are mostly not larger than so. */
void msap_skin_make_wide(const struct grid *g, struct bounds *fat, uint32_t slot, float others)
{
    skin_ahead(g, slot, others, &fat[slot]);
}

/* How many times the size of the box such a skin would be, made for so many commits: on all axes in which the box
 * is wide, each counted four times at the most. *commits becomes for how many it would last. */
double msap_skin_growth(const struct grid *g, uint32_t slot, float *commits)
{
    enum { MOST = 4 };
    const struct box *b = &g->boxes->at[slot];
    struct bounds skin = b->now;
    struct motion m = motion_of(g, slot);
    double growth = 1;
    if (!(m.size < FAR)) return 1;
    *commits = reach(&m, *commits, STEADY_SIZES);
    reach_out(&b->now, &skin, &m, *commits, m.size / LEAST_PART, 0);
    for (int k = 0; k < 3; k++) {
        double size = (double)value_of(b->now.max[k]) - (double)value_of(b->now.min[k]);
        double wide = (double)value_of(skin.max[k]) - (double)value_of(skin.min[k]);
        if (size > 0) growth *= wide < MOST * size ? wide / size : MOST;
    }
    return growth;
}

/* Whether a box has made a step of a few units in the last place, on each axis. */
static int has_crawled(const struct box_table *t, uint32_t slot)
{
    const struct bounds *now = &t->at[slot].now, *before = moved_from(t, slot, deed_of(t, slot));
    int n = 0;
    for (int k = 0; k < 3; k++) {
        int64_t way = (int64_t)now->min[k] - before->min[k];
        n += -CRAWL <= way && way <= CRAWL;
    }
    return n == 3;
}

/* Whether, of the boxes that moved in the last commit, more crawled than did not: then little is known yet of how they
 * move. By some of them. */
int msap_most_crawl(const struct grid *g)
{
    enum { SAMPLES = 64 };
    const struct box_table *t = g->boxes;
    size_t step = t->used / SAMPLES + 1, crawling = 0, moving = 0;
    for (uint32_t slot = 0; slot < t->used; slot += (uint32_t)step) {
        if (!(t->at[slot].flags & BOX_LIVE) || deed_of(t, slot) != MOVED) continue;
        moving++;
        crawling += (size_t)has_crawled(t, slot);
    }
    return 2 * crawling > moving;
}

/* Whether a box that is not static leaves its skin within so many commits if it moves on as in the last
 * one. Of one that crawls nothing is foreseen soon after it got its skin. */
int msap_skin_will_be_left(const struct grid *g, uint32_t slot, uint32_t commits)
{
    enum { SOON = 8 };
    const struct box *b = &g->boxes->at[slot];
    struct readable then = {.fourth = 0};
    if (!(b->flags & BOX_LIVE) || b->flags & BOX_STATIC || deed_of(g->boxes, slot) == NOTHING) return 0;
    if (skin_age(g, slot) < SOON && has_crawled(g->boxes, slot)) return 0;
    struct motion m = motion_of(g, slot);
    reach_out(&b->now, &then.bounds, &m, (float)commits, 0, 0);
    return !contains(&b->fat, &then.bounds);
}

/* A box has not left its skin before all get new ones: little by little the next ones are narrower. */
static inline void skin_was_right(const struct grid *g, uint32_t slot)
{
    struct box *b = &g->boxes->at[slot];
    if (b->wobble > 0 && chance(slot, g->commit) * HORIZON_START < 256 * g->upkeep.made_for) b->wobble--;
}

/* The skin of a box that it got with all others starts. Where the box was counts from an earlier one, unless that
 * is long ago or there was none, as of all boxes if `are_new`: so one who crawls is known better and better. The
 * first skins that a world gets are good enough however soon they are left. */
static inline void skin_starts(const struct grid *g, uint32_t slot, int are_new)
{
    enum { SHORT = 8, LONG_AGO = 24 };
    struct box *b = &g->boxes->at[slot];
    b->horizon = (uint8_t)(g->upkeep.is_first ? SHORT : g->upkeep.made_for);
    if (are_new || deed_of(g->boxes, slot) == CAME || skin_age(g, slot) > LONG_AGO) start(g, slot, 0);
}

/* All boxes rest in their new skins. Those that are outside, or have none, are put on the list of those that
 * left, which is empty. */
void msap_skins_put_on(const struct grid *g, struct box_table *t, int are_new)
{
    const struct renewal *r = &g->renewal;
    for (uint32_t slot = 0; slot < t->used; slot++) {
        struct box *b = &t->at[slot];
        if (!(b->flags & BOX_LIVE)) {
            box_forget_place(b);
            continue;
        }
        /* What has just been written is slow to read as a vector: so this is asked before it is copied. */
        int is_within = b->flags & BOX_FITTED && contains(&r->fat[slot], &b->now);
        if (b->level == NO_LEVEL) skin_was_right(g, slot);
        b->level = NO_LEVEL;
        b->fat = b->flags & BOX_FITTED ? r->fat[slot] : b->now;
        if (is_within) {
            skin_starts(g, slot, are_new);
        } else {
            if (are_new) b->flags &= ~(uint32_t)BOX_FITTED; /* it has had no skin from which to learn */
            box_mark_left(t, slot);
        }
    }
}
