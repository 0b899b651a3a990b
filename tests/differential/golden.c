/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The same calls give the same events: a fixed scenario is played in every set-up, and
 * all that the library answers is hashed (FNV-1a): statuses, handles, bounds, events,
 * pairs, errors, the results of box pruning.
 *
 *     golden [SIMD]
 *
 * prints the hash for 2 and 3 axes. The exit status is 1 if a set-up gave another hash
 * than the first, or the hash is not the one below; then stderr says which. SIMD, an
 * msap_simd, replaces that of the set-ups.
 *
 * All numbers are made as bits, and no float is ever computed with here, so that the
 * program itself means the same with any compiler, flags and machine. It needs nothing
 * but the C library and POSIX threads; portable.sh builds it in many ways. What is
 * pinned may change with the scenario, never with the library.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "multisap.h"

#include "../unit/setups.h"

#define GOLDEN_2D UINT64_C(0x113DAD0C3030CCA5)
#define GOLDEN_3D UINT64_C(0xD800ADF91749F83C)

enum { BOXES = 200, FRAMES = 50, BATCH = 20 };

typedef struct game {
    msap_world *world;
    msap_handle handles[BOXES];
    uint64_t random, hash;
} game;

/* ----------------------------------------------------------------- numbers */

static uint64_t next(game *g)
{
    uint64_t x = g->random += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

static uint32_t below(game *g, uint32_t end)
{
    return (uint32_t)((next(g) >> 32) * end >> 32);
}

static void hash(game *g, uint64_t word)
{
    int byte;
    for (byte = 0; byte < 8; byte++) {
        g->hash ^= word >> (8 * byte) & 0xFF;
        g->hash *= UINT64_C(0x100000001B3);
    }
}

/* An integer of the order of the floats, as in appendix A of the paper, and its bits. */
static uint32_t bits_of_code(uint32_t code)
{
    return code >> 31 ? code ^ 0x80000000u : ~code;
}

/* The bits of a whole number, at most 2^23 in size. */
static uint32_t bits_of_whole(int32_t number)
{
    uint32_t size = (uint32_t)(number < 0 ? -number : number), exponent = 127 + 23;
    if (size == 0)
        return 0;
    for (; size < 0x800000; size <<= 1)
        exponent--;
    return (number < 0 ? 0x80000000u : 0) | exponent << 23 | (size & 0x7FFFFF);
}

/* One interval: whole numbers near 0; neighbours anywhere among all floats; from and to
 * any float. One time in 500 it is a NaN or inverted. */
static void make_interval(game *g, uint32_t *min, uint32_t *max)
{
    uint32_t kind = below(g, 8), low = 0x007FFFFF, high = 0xFF800000; /* the codes of -inf, +inf */
    int32_t at = (int32_t)below(g, 40) - 20;
    *min = bits_of_whole(at);
    *max = bits_of_whole(at + (int32_t)below(g, 6));
    if (kind > 1) {
        if (below(g, 1000) == 0)
            *max = 0x7F800001 + (uint32_t)next(g) % 0x7FFFFF;
        if (below(g, 1000) == 0)
            *min = bits_of_whole(at + 6);
        return;
    }
    low += below(g, high - low);
    *min = bits_of_code(low);
    *max = bits_of_code(kind || low > high - 9 ? high - below(g, high - low + 1) : low + below(g, 9));
}

typedef struct bounds {
    float min[3], max[3];
} bounds;

static bounds make_box(game *g)
{
    bounds b;
    int axis;
    for (axis = 0; axis < 3; axis++) {
        uint32_t min, max;
        make_interval(g, &min, &max);
        memcpy(&b.min[axis], &min, sizeof min);
        memcpy(&b.max[axis], &max, sizeof max);
    }
    return b;
}

/* The double of a float that is not subnormal, with bits below the float's. */
static uint64_t widen(game *g, uint32_t bits)
{
    uint64_t sign = (uint64_t)(bits >> 31) << 63, exponent = bits >> 23 & 0xFF, mantissa = bits & 0x7FFFFF;
    if (exponent == 0)
        return sign | (uint64_t)below(g, 0x380) << 52 | (uint64_t)below(g, 3); /* 0 to beyond the least float */
    if (exponent == 0xFF)
        return sign | UINT64_C(0x7FF0000000000000) | mantissa << 29;
    return sign | (exponent + 896) << 52 | mantissa << 29 | below(g, 3);
}

/* ------------------------------------------------------------------- calls */

static void hash_error(game *g, msap_status status)
{
    msap_error error;
    error.struct_size = sizeof error;
    hash(g, status);
    if (status && msap_last_error(g->world, &error) == MSAP_OK) {
        hash(g, error.status);
        hash(g, error.index);
        hash(g, error.bound);
    }
}

static void hash_pairs(game *g, msap_status (*list)(const msap_world *, const msap_pair **, size_t *))
{
    const msap_pair *pairs;
    size_t count, i;
    hash(g, list(g->world, &pairs, &count));
    hash(g, count);
    for (i = 0; i < count; i++) {
        hash(g, pairs[i].a);
        hash(g, pairs[i].b);
    }
}

static void hash_box(game *g, msap_handle handle, uint32_t dims)
{
    float value[6];
    uint32_t bits[6], axis;
    hash(g, msap_get_bounds(g->world, handle, value, value + 3));
    memcpy(bits, value, sizeof bits);
    for (axis = 0; axis < dims; axis++) {
        hash(g, bits[axis]);
        hash(g, bits[axis + 3]);
    }
}

/* Adds, moves or removes a box. */
static void change_one(game *g, uint32_t dims)
{
    uint32_t i = below(g, BOXES), what = below(g, 10);
    bounds b = make_box(g);
    if (!g->handles[i]) {
        hash_error(g, msap_add(g->world, b.min, b.max, what ? 0 : MSAP_STATIC, NULL, &g->handles[i]));
        hash(g, g->handles[i]);
        return;
    }
    if (what)
        hash_error(g, msap_update(g->world, g->handles[i], b.min, b.max));
    hash_box(g, g->handles[i], dims);
    if (!what) {
        hash_error(g, msap_remove(g->world, g->handles[i]));
        g->handles[i] = MSAP_NULL_HANDLE;
    }
}

/* Moves boxes to doubles; of a batch with a bad box or handle, none. */
static void change_many(game *g)
{
    uint64_t wide[BATCH][6];
    msap_handle handles[BATCH];
    msap_boxes boxes = {sizeof boxes, MSAP_DOUBLE, NULL, NULL, sizeof wide[0], 8, sizeof wide[0], 8};
    size_t i, axis, n = 1 + below(g, BATCH);
    for (i = 0; i < n; i++) {
        bounds b = make_box(g);
        uint32_t bits[6];
        memcpy(bits, &b, sizeof bits);
        for (axis = 0; axis < 6; axis++)
            wide[i][axis] = widen(g, bits[axis]);
        handles[i] = g->handles[below(g, BOXES)];
        if (!handles[i])
            handles[i] = g->handles[i];
    }
    boxes.min = wide[0];
    boxes.max = wide[0] + 3;
    hash_error(g, msap_update_many(g->world, n, handles, &boxes));
}

/* By a whole number or by any double. */
static void shift(game *g)
{
    double offset[3];
    int axis;
    for (axis = 0; axis < 3; axis++) {
        uint64_t bits = widen(g, bits_of_whole((int32_t)below(g, 9) - 4));
        if (below(g, 20) == 0)
            bits = next(g);
        memcpy(&offset[axis], &bits, sizeof bits);
    }
    hash_error(g, msap_shift_origin(g->world, offset));
}

static void play_frame(game *g, uint32_t dims, int frame)
{
    uint32_t changes = frame % 7 == 0 ? 3 * BOXES : below(g, 40);
    while (changes--)
        change_one(g, dims);
    if (frame % 3 == 0)
        change_many(g);
    if (frame % 10 == 5)
        shift(g);
    hash(g, msap_commit(g->world, NULL, NULL));
    hash_pairs(g, msap_deleted);
    hash_pairs(g, msap_created);
    hash_pairs(g, msap_pairs);
    hash(g, msap_validate(g->world, NULL));
    if (frame % 20 == 19)
        hash(g, msap_trim(g->world));
}

/* The axis is chosen by the library. */
static void prune(game *g)
{
    static bounds b[BOXES];
    msap_boxes boxes = {sizeof boxes, MSAP_FLOAT, b->min, b->max, sizeof *b, 4, sizeof *b, 4};
    msap_error error = {sizeof error, 0, 0, 0, 0};
    msap_index_pair *pairs = NULL;
    size_t count = 0, i;
    for (i = 0; i < BOXES; i++)
        b[i] = make_box(g);
    hash(g, msap_prune(NULL, BOXES, &boxes, &pairs, &count, &error));
    hash(g, error.index);
    hash(g, error.bound);
    for (i = 0; i < count; i++)
        hash(g, (uint64_t)pairs[i].a << 32 | pairs[i].b);
    hash(g, msap_prune_free(NULL, pairs, count));
}

/* Which margins and cell sizes are refused. */
static void configure(game *g)
{
    static const uint32_t values[] = {0x00000000, 0x00000001, 0x80000001, 0x80000000, 0x3F800000, 0xBF800000,
                                      0xBF800001, 0x7F7FFFFF, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00000};
    size_t i, j;
    for (i = 0; i < sizeof values / sizeof *values; i++)
        for (j = 0; j < 2; j++) {
            msap_config config;
            msap_world *world = NULL;
            msap_config_init(&config, sizeof config);
            memcpy(j ? &config.margin : &config.cell_size, &values[i], sizeof values[i]);
            hash(g, msap_create(&config, &world));
            msap_destroy(world);
        }
}

/* ---------------------------------------------------------------- the whole */

static uint64_t play(const msap_config *config)
{
    game g = {0};
    int frame;
    g.random = config->dims;
    g.hash = UINT64_C(0xCBF29CE484222325);
    if (msap_create(config, &g.world))
        abort();
    for (frame = 0; frame < FRAMES; frame++)
        play_frame(&g, config->dims, frame);
    for (frame = 0; frame < 5; frame++)
        prune(&g);
    configure(&g);
    msap_destroy(g.world);
    return g.hash;
}

/* In all set-ups; returns whether they agree with each other and with what is pinned. */
static int play_all(uint32_t dims, const char *simd, uint64_t golden)
{
    uint64_t first = 0;
    int row, agree = 1;
    for (row = 0; row < SETUPS; row++) {
        msap_config config = setup_config(dims, row);
        uint64_t this;
        if (simd)
            config.simd = (uint32_t)atoi(simd);
        this = play(&config);
        if (row == 0)
            first = this;
        if (this != first) {
            fprintf(stderr, "golden: %uD, %s: %016" PRIX64 "\n", dims, setups[row].name, this);
            agree = 0;
        }
    }
    printf("%uD %016" PRIX64 "\n", dims, first);
    if (first != golden)
        fprintf(stderr, "golden: %uD: expected %016" PRIX64 "\n", dims, golden);
    return agree && first == golden;
}

int main(int argc, char **argv)
{
    const char *simd = argc > 1 ? argv[1] : NULL;
    int good = play_all(2, simd, GOLDEN_2D);
    return play_all(3, simd, GOLDEN_3D) && good ? EXIT_SUCCESS : EXIT_FAILURE;
}
