/* Harness: box pruning, complete and bipartite, against brute force; with bad bounds
 * and with allocations that fail.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "scene.h"

#include <string.h>

enum { MOST = 160 };

typedef struct question {
    msap_prune_config config;
    tracker memory;
    box a[MOST], b[MOST];
    msap_boxes boxes_a, boxes_b;
    size_t n_a, n_b;
    int bipartite;
} question;

static size_t take_boxes(input *in, box *boxes)
{
    uint32_t kind = (uint32_t)take(in, 1);
    scene_kind scene = (scene_kind)(kind % SCENE_COUNT);
    uint64_t random = take(in, 2);
    size_t n = take(in, 1) % (MOST + 1), i;
    for (i = 0; i < n; i++)
        boxes[i] = random_box(&random, scene);
    return n;
}

/* One bound becomes any float, with bytes left. */
static void take_spoiled(input *in, box *boxes, size_t n)
{
    size_t at = take(in, 1), axis = take(in, 1) % 6;
    if (n == 0)
        return;
    if (axis < 3)
        boxes[at % n].min[axis] = take_float(in);
    else
        boxes[at % n].max[axis - 3] = take_float(in);
}

static void take_question(input *in, question *q)
{
    uint32_t how = (uint32_t)take(in, 1);
    memset(q, 0, sizeof *q);
    msap_prune_config_init(&q->config, sizeof q->config);
    q->config.dims = how & 1 ? 2 : 3;
    q->config.axis = (int32_t)(how >> 1 & 3) - 1;
    q->bipartite = how >> 3 & 1;
    if (how & 16)
        q->memory.fail_at = 1 + take(in, 1) % 16;
    if (how & 32)
        q->memory.limit = 1 + take(in, 2);
    q->config.alloc = tracked_alloc;
    q->config.free = tracked_free;
    q->config.allocator_user = &q->memory;
    q->n_a = take_boxes(in, q->a);
    q->n_b = take_boxes(in, q->b);
    while (in->at < in->end) {
        int first = (int)(take(in, 1) & 1);
        take_spoiled(in, first ? q->a : q->b, first ? q->n_a : q->n_b);
    }
    q->boxes_a = lay_out(q->a, q->n_a, how >> 6);
    q->boxes_b = lay_out(q->b, q->n_b, how >> 7);
}

/* What is wrong with the boxes, and where. */
static msap_status verdict(const question *q, const box *boxes, size_t n, size_t base, msap_error *error)
{
    size_t i;
    uint32_t c, dims = q->config.dims;
    for (i = 0; i < n; i++) {
        error->index = base + i;
        for (c = 0; c < 6; c++) {
            float bound = c < 3 ? boxes[i].min[c] : boxes[i].max[c - 3];
            error->bound = c;
            if (c % 3 < dims && bound != bound)
                return MSAP_ERROR_NAN;
        }
        for (c = 0; c < dims; c++) {
            error->bound = c;
            if (boxes[i].min[c] > boxes[i].max[c])
                return MSAP_ERROR_INVERTED;
        }
    }
    return MSAP_OK;
}

/* Arguments that are refused whatever the boxes are; nothing is given then. */
static void check_refusals(const question *q)
{
    msap_prune_config config;
    msap_boxes boxes = q->boxes_a;
    msap_index_pair *pairs = NULL;
    size_t count = 77;
    if (msap_prune_config_init(&config, 1) != MSAP_ERROR_STRUCT_SIZE ||
        msap_prune_config_init(&config, sizeof config) != MSAP_OK)
        fuzz_check("msap_prune_config_init came to another status");
    config.dims = 4 - q->config.dims / 3 * 3;
    if (msap_prune(&config, q->n_a, &boxes, &pairs, &count, NULL) != MSAP_ERROR_CONFIG)
        fuzz_check("another number of axes was not refused");
    boxes.struct_size++;
    if (msap_prune_bipartite(NULL, q->n_a, &boxes, q->n_b, &q->boxes_b, &pairs, &count, NULL) !=
        MSAP_ERROR_STRUCT_SIZE)
        fuzz_check("a struct of another size was not refused");
    boxes = q->boxes_a;
    boxes.max = NULL;
    if (q->n_a > 0 && msap_prune(NULL, q->n_a, &boxes, &pairs, &count, NULL) != MSAP_ERROR_NULL)
        fuzz_check("boxes without maxes were not refused");
    if (pairs || count != 77)
        fuzz_check("a call that was refused gave something");
}

static void compare_pairs(const question *q, const msap_index_pair *pairs, size_t count)
{
    const box *others = q->bipartite ? q->b : q->a;
    size_t n = q->bipartite ? q->n_b : q->n_a, found = 0, i, j;
    for (i = 0; i < q->n_a; i++)
        for (j = q->bipartite ? 0 : i + 1; j < n; j++) {
            if (!boxes_overlap(&q->a[i], &others[j], q->config.dims))
                continue;
            if (found == count || pairs[found].a != i || pairs[found].b != j)
                fuzz_check("a pair is missing, wrong or out of order");
            found++;
        }
    fuzz_check(found == count ? NULL : "there are too many pairs");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static question q;
    input in = {data, data + size};
    msap_error error = {sizeof error, 0, 0, 0, 0}, expected = {sizeof error, 0, 0, 0, 0};
    msap_index_pair *pairs = NULL;
    size_t count = 77;
    msap_status status, wanted;
    take_question(&in, &q);
    check_refusals(&q);
    wanted = q.config.axis >= (int32_t)q.config.dims ? MSAP_ERROR_CONFIG : verdict(&q, q.a, q.n_a, 0, &expected);
    if (wanted == MSAP_OK && q.bipartite)
        wanted = verdict(&q, q.b, q.n_b, q.n_a, &expected);
    if (q.bipartite)
        status = msap_prune_bipartite(&q.config, q.n_a, &q.boxes_a, q.n_b, &q.boxes_b, &pairs, &count, &error);
    else
        status = msap_prune(&q.config, q.n_a, &q.boxes_a, &pairs, &count, &error);
    if (status == MSAP_OK) {
        compare_pairs(&q, pairs, count);
        msap_prune_free(&q.config, pairs, count);
    } else if (pairs || count != 77 || error.status != (uint32_t)status)
        fuzz_check("a call that failed gave something");
    if (status != wanted && (status != MSAP_ERROR_MEMORY || q.memory.failures == 0))
        fuzz_check("pruning came to another status");
    if ((status == MSAP_ERROR_NAN || status == MSAP_ERROR_INVERTED) &&
        (error.index != expected.index || error.bound != expected.bound))
        fuzz_check("another box or bound is named");
    if (q.memory.blocks || q.memory.wrong)
        fuzz_check("memory leaked");
    return 0;
}
