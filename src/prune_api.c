/* Box pruning as a function of its own: boxes in, sorted pairs out, no state.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The boxes are read, sorted by their min on the sweep axis and pruned (prune.c);
 * the pairs are collected as keys and sorted. */
#include "internal.h"

/* One call at work. */
struct prune_call {
    struct memory memory;
    uint32_t dims, axis;
    int bipartite;
    struct keys pairs;
    int lost; /* 1: a pair was found for which there was no memory */
};

/* One set of boxes: as read, and in sweep order. The indices of the second set of two
 * begin behind those of the first, so that a pair names its lower set first. */
struct input {
    size_t n, base; /* number of boxes; index of the first */
    struct bounds *bounds;
    uint64_t *words;
    struct prune_set set;
};

msap_status msap_prune_config_init(msap_prune_config *config, size_t struct_size)
{
    if (!config) return MSAP_ERROR_NULL;
    if (struct_size != sizeof *config) return MSAP_ERROR_STRUCT_SIZE;
    memset(config, 0, sizeof *config);
    config->struct_size = (uint32_t)sizeof *config;
    config->dims = 3;
    config->axis = MSAP_AXIS_AUTO;
    return MSAP_OK;
}

static msap_status begin(struct prune_call *p, const msap_prune_config *config)
{
    msap_prune_config defaults;
    msap_prune_config_init(&defaults, sizeof defaults);
    if (!config) config = &defaults;
    memset(p, 0, sizeof *p);
    if (config->struct_size != sizeof *config) return MSAP_ERROR_STRUCT_SIZE;
    if (config->dims < 2 || config->dims > 3 || config->reserved != 0) return MSAP_ERROR_CONFIG;
    if (config->axis < MSAP_AXIS_AUTO || config->axis >= (int32_t)config->dims) return MSAP_ERROR_CONFIG;
    p->dims = config->dims;
    p->axis = (uint32_t)config->axis; /* AUTO is above every axis */
    return msap_memory_init(&p->memory, config->alloc, config->free, config->allocator_user);
}

static msap_status fail(msap_error *error, msap_status status, uint64_t index, uint32_t bound)
{
    if (error) {
        error->status = status;
        error->index = index;
        error->bound = bound;
        error->reserved = 0;
    }
    return status;
}

/* Reads n boxes, the first of which has the index `base`. */
static msap_status read_input(struct prune_call *p, struct input *in, size_t n, const msap_boxes *boxes,
                              size_t base, msap_error *error)
{
    msap_status status = msap_boxes_check(boxes, n);
    if (status == MSAP_OK && n > MSAP_MAX_BOXES - base) status = MSAP_ERROR_FULL;
    if (status != MSAP_OK) return fail(error, status, base, MSAP_NO_BOUND);
    in->n = n;
    in->base = base;
    if (n == 0) return MSAP_OK;
    in->bounds = msap_memory_alloc(&p->memory, n, sizeof *in->bounds);
    if (!in->bounds) return fail(error, MSAP_ERROR_MEMORY, base, MSAP_NO_BOUND);
    for (size_t i = 0; i < n; i++) {
        uint32_t bound = MSAP_NO_BOUND;
        status = bounds_read(boxes, i, p->dims, &in->bounds[i], &bound);
        if (status != MSAP_OK) return fail(error, status, base + i, bound);
    }
    return MSAP_OK;
}

static void free_input(struct prune_call *p, struct input *in)
{
    msap_memory_free(&p->memory, in->bounds, in->n, sizeof *in->bounds);
    msap_memory_free(&p->memory, in->words, PRUNE_SET_WORDS(in->n), sizeof *in->words);
}

/* ------------------------------------------------------------ sweep order */

static double centre(const struct bounds *b, uint32_t k)
{
    const double far = 1e30; /* for infinite bounds */
    double low = float_from_bits(float_bits_from_ordered(b->min[k]));
    double high = float_from_bits(float_bits_from_ordered(b->max[k]));
    return ((low < -far ? -far : low) + (high > far ? far : high)) / 2;
}

/* The spread of the boxes' centres on an axis. It decides about speed only. */
static double variance(const struct input *a, const struct input *b, uint32_t k)
{
    double sum = 0, squares = 0, n = (double)(a->n + b->n);
    const struct input *sets[2] = {a, b};
    for (int s = 0; s < 2; s++)
        for (size_t i = 0; i < sets[s]->n; i++) {
            double c = centre(&sets[s]->bounds[i], k);
            sum += c;
            squares += c * c;
        }
    return n > 0 ? squares / n - sum / n * (sum / n) : 0;
}

static void choose_axis(struct prune_call *p, const struct input *a, const struct input *b)
{
    double best = -1;
    if (p->axis < p->dims) return;
    p->axis = 0;
    for (uint32_t k = 0; k < p->dims; k++) {
        double spread = variance(a, b, k);
        if (spread > best) {
            best = spread;
            p->axis = k;
        }
    }
}

/* Lays the set out in sweep order. Returns 0 without memory. */
static int sort_input(struct prune_call *p, struct input *in)
{
    size_t n = in->n;
    if (n == 0) {
        in->set.n = 0;
        return 1;
    }
    in->words = msap_memory_alloc(&p->memory, PRUNE_SET_WORDS(n), sizeof *in->words);
    uint64_t *key = msap_memory_alloc(&p->memory, 2 * n, sizeof *key);
    if (in->words && key) {
        for (size_t i = 0; i < n; i++) key[i] = key_make(in->bounds[i].min[p->axis], 0, (uint32_t)i);
        msap_sort_keys(key, n, key + n);
        msap_prune_set_place(&in->set, in->words, n);
        for (size_t i = 0; i < n; i++)
            msap_prune_set_put(&in->set, i, &in->bounds[key_box(key[i])], p->axis,
                               (uint32_t)in->base + key_box(key[i]));
    }
    int done = in->words && key;
    msap_memory_free(&p->memory, key, 2 * n, sizeof *key);
    return done;
}

/* ------------------------------------------------------------------ results */

static void put_pair(struct prune_call *p, uint64_t key)
{
    if (p->lost || !msap_keys_reserve(&p->pairs, &p->memory, p->pairs.n + 1)) p->lost = 1;
    else p->pairs.at[p->pairs.n++] = key;
}

static void found(void *context, uint32_t a, uint32_t b) { put_pair(context, pair_key(a, b)); }

/* Hands the pairs out; the second index of each counts from `base`. */
static msap_status give_pairs(struct prune_call *p, size_t base, msap_index_pair **pairs, size_t *count)
{
    size_t n = p->pairs.n;
    msap_index_pair *out = NULL;
    if (p->lost) return MSAP_ERROR_MEMORY;
    if (n > 0) {
        uint64_t *scratch = msap_memory_alloc(&p->memory, n, sizeof *scratch);
        msap_sort_keys(p->pairs.at, n, scratch);
        msap_memory_free(&p->memory, scratch, n, sizeof *scratch);
        out = msap_memory_alloc(&p->memory, n, sizeof *out);
        if (!out) return MSAP_ERROR_MEMORY;
    }
    for (size_t i = 0; i < n; i++) {
        out[i].a = (uint32_t)(p->pairs.at[i] >> 32);
        out[i].b = (uint32_t)p->pairs.at[i] - (uint32_t)base;
    }
    *pairs = out;
    *count = n;
    return MSAP_OK;
}

/* ------------------------------------------------------------------ the calls */

/* Prunes a against b, or a within itself, once both have been read. */
static msap_status prune_inputs(struct prune_call *p, struct input *a, struct input *b, msap_index_pair **pairs,
                                size_t *count)
{
    choose_axis(p, a, b);
    if (!sort_input(p, a) || !sort_input(p, b)) return MSAP_ERROR_MEMORY;
    if (p->bipartite) msap_prune_between(&a->set, &b->set, found, p);
    else msap_prune_within(&a->set, found, p);
    return give_pairs(p, b->base, pairs, count);
}

static msap_status run(struct prune_call *p, size_t k_a, const msap_boxes *boxes_a, size_t k_b,
                       const msap_boxes *boxes_b, msap_index_pair **pairs, size_t *count, msap_error *error)
{
    struct input a, b;
    memset(&a, 0, sizeof a);
    memset(&b, 0, sizeof b);
    msap_status status = read_input(p, &a, k_a, boxes_a, 0, error);
    if (status == MSAP_OK && p->bipartite) status = read_input(p, &b, k_b, boxes_b, k_a, error);
    if (status == MSAP_OK) {
        status = prune_inputs(p, &a, &b, pairs, count);
        if (status != MSAP_OK) fail(error, status, 0, MSAP_NO_BOUND);
    }
    free_input(p, &a);
    free_input(p, &b);
    msap_keys_free(&p->pairs, &p->memory);
    return status;
}

static msap_status check_call(struct prune_call *p, const msap_prune_config *config, msap_index_pair **pairs,
                              const size_t *count, msap_error *error)
{
    if (error && error->struct_size != sizeof *error) return MSAP_ERROR_STRUCT_SIZE;
    if (!pairs || !count) return fail(error, MSAP_ERROR_NULL, 0, MSAP_NO_BOUND);
    msap_status status = begin(p, config);
    return status == MSAP_OK ? status : fail(error, status, 0, MSAP_NO_BOUND);
}

msap_status msap_prune(const msap_prune_config *config, size_t k, const msap_boxes *boxes, msap_index_pair **pairs,
                       size_t *count, msap_error *error)
{
    struct prune_call p;
    msap_status status = check_call(&p, config, pairs, count, error);
    return status == MSAP_OK ? run(&p, k, boxes, 0, NULL, pairs, count, error) : status;
}

msap_status msap_prune_bipartite(const msap_prune_config *config, size_t k_a, const msap_boxes *boxes_a,
                                 size_t k_b, const msap_boxes *boxes_b, msap_index_pair **pairs, size_t *count,
                                 msap_error *error)
{
    struct prune_call p;
    msap_status status = check_call(&p, config, pairs, count, error);
    p.bipartite = 1;
    return status == MSAP_OK ? run(&p, k_a, boxes_a, k_b, boxes_b, pairs, count, error) : status;
}

msap_status msap_prune_free(const msap_prune_config *config, msap_index_pair *pairs, size_t count)
{
    struct prune_call p;
    msap_status status = begin(&p, config);
    if (status == MSAP_OK) msap_memory_free(&p.memory, pairs, count, sizeof *pairs);
    return status;
}
