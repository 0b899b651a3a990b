/* See scene.h.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ------------------------------------------------------------------ set-ups */

static float take_of(input *in, const float *values, size_t count) { return values[take(in, 1) % count]; }

static void take_fixed_grid(input *in, msap_config *config)
{
    static const float lows[] = {-10, 0, -1e30f, 1, 1e-40f, -3.4e38f};
    static const float sizes[] = {30, 1, 2e30f, 1e-3f, 1e-38f, 3.3e38f};
    uint32_t c;
    for (c = 0; c < config->dims; c++) {
        config->grid_cells[c] = 1 + (uint32_t)take(in, 1) % 17;
        config->grid_min[c] = take_of(in, lows, COUNT(lows));
        config->grid_max[c] = config->grid_min[c] + take_of(in, sizes, COUNT(sizes));
        if (!(config->grid_min[c] < config->grid_max[c]))
            config->grid_cells[c] = 1;
    }
}

msap_config take_config(input *in, uint32_t dims)
{
    static const float margins[] = {MSAP_MARGIN_AUTO, MSAP_MARGIN_AUTO, 0, 0.1f, 3, 1e-40f, 1e30f, 3.4e38f};
    static const float widths[] = {0, 0, 2, 1e-30f, 1e30f, 100};
    static const uint32_t workers[] = {1, 1, 2, 3, 16, 64};
    static const job_system jobs[] = {JOBS_AT_ONCE, JOBS_LATE};
    uint32_t kind = (uint32_t)take(in, 1), crew = workers[take(in, 1) % COUNT(workers)];
    msap_config config;
    msap_config_init(&config, sizeof config);
    config.dims = dims;
    config.grid = kind % 3;
    config.strategy = kind / 3 % 4;
    config.filters = kind / 12 % 2;
    config.simd = kind / 24 % 4;
    config.margin = take_of(in, margins, COUNT(margins));
    config.cell_size = take_of(in, widths, COUNT(widths));
    if (config.grid == MSAP_GRID_FIXED)
        take_fixed_grid(in, &config);
    if (crew > 1)
        use_jobs(&config, crew, jobs[kind / 96 % COUNT(jobs)]);
    config.task_grain = 16; /* so that the few boxes get tasks */
    return config;
}

/* -------------------------------------------------------------------- boxes */

static void order(box *b)
{
    int c;
    for (c = 0; c < 3; c++) {
        float low = isnan(b->min[c]) ? 0 : b->min[c], high = isnan(b->max[c]) ? 0 : b->max[c];
        b->min[c] = low <= high ? low : high;
        b->max[c] = low <= high ? high : low;
    }
}

/* Bounds by integers; by numbers at which something happens; by any bits. */
static box take_box(input *in)
{
    uint32_t shape = (uint32_t)take(in, 1);
    box b;
    int c;
    for (c = 0; c < 3; c++) {
        if (shape % 3 == 0) {
            b.min[c] = (float)((int)take(in, 1) % 16 - 8);
            b.max[c] = b.min[c] + (float)(shape >> (2 + 2 * c) & 3);
        } else {
            b.min[c] = shape % 3 == 1 ? take_hard(in) : take_float(in);
            b.max[c] = shape & 128 ? b.min[c] : shape % 3 == 1 ? take_hard(in) : take_float(in);
        }
    }
    order(&b);
    return b;
}

/* Where the bounds of many boxes come from. */
typedef struct source {
    uint64_t random;
    scene_kind scene;
    int exponent; /* of what all bounds are multiplied with */
} source;

static source take_source(input *in)
{
    static const int exponents[] = {0, 0, 0, 0, 1, -20, 60, 110, 118, 124, -120, -149};
    source s;
    uint32_t byte = (uint32_t)take(in, 1);
    s.scene = (scene_kind)(byte % SCENE_COUNT);
    s.exponent = s.scene == SCENE_HARD ? 0 : exponents[byte / SCENE_COUNT % COUNT(exponents)];
    s.random = take(in, 2);
    return s;
}

static box scaled(box b, int exponent)
{
    int c;
    for (c = 0; c < 3 && exponent; c++) {
        b.min[c] = ldexpf(b.min[c], exponent);
        b.max[c] = ldexpf(b.max[c], exponent);
    }
    return b;
}

/* A step for bounds that may be anything: a part of the box's size, or nothing. */
static box stepped(source *s, const box *from)
{
    box b = *from;
    int c;
    for (c = 0; c < 3; c++) {
        float step = (from->max[c] - from->min[c]) * (float)((int)random_below(&s->random, 5) - 2) / 8;
        if (!(fabsf(step) < 1e37f))
            continue;
        b.min[c] += step;
        b.max[c] += step;
    }
    order(&b);
    return b;
}

/* ------------------------------------------------------------------ layouts */

/* A block of this size in place of the old one. */
static void *renew(void *old, size_t size)
{
    void *block = malloc(size + !size);
    free(old);
    if (!block)
        fuzz_check("there is no memory");
    return block;
}

/* Box after box. */
static void in_row(const box *from, size_t k, unsigned char *to, msap_boxes *boxes)
{
    memcpy(to, from, k * sizeof *from);
    boxes->min_row = boxes->max_row = sizeof *from;
    boxes->max = to + 3 * sizeof(float);
}

/* All mins of an axis behind each other, and so on. */
static void by_component(const box *from, size_t k, unsigned char *to, msap_boxes *boxes)
{
    size_t i, c;
    boxes->min_component = boxes->max_component = (ptrdiff_t)(k * sizeof(float));
    boxes->max = to + 3 * k * sizeof(float);
    for (i = 0; i < k; i++)
        for (c = 0; c < 3; c++) {
            memcpy(to + (c * k + i) * sizeof(float), &from[i].min[c], sizeof(float));
            memcpy(to + ((3 + c) * k + i) * sizeof(float), &from[i].max[c], sizeof(float));
        }
}

/* Doubles, the last box first, at odd addresses; maxes before mins, and these from the last axis. */
static void doubles_backwards(const box *from, size_t k, unsigned char *to, msap_boxes *boxes)
{
    enum { ROW = 6 * sizeof(double) };
    size_t i, c;
    boxes->scalar = MSAP_DOUBLE;
    boxes->min_row = boxes->max_row = -ROW;
    boxes->min_component = -(int)sizeof(double);
    boxes->max_component = sizeof(double);
    boxes->max = to + 1 + (k ? k - 1 : 0) * ROW;
    boxes->min = (const unsigned char *)boxes->max + (k ? 5 * sizeof(double) : 0);
    for (i = 0; i < k; i++)
        for (c = 0; c < 3; c++) {
            double min = from[i].min[c], max = from[i].max[c];
            unsigned char *row = to + 1 + (k - 1 - i) * ROW;
            memcpy(row + (5 - c) * sizeof min, &min, sizeof min);
            memcpy(row + c * sizeof max, &max, sizeof max);
        }
}

msap_boxes lay_out(const box *from, size_t k, uint32_t layout)
{
    static unsigned char *blocks[2];
    static unsigned turn; /* two blocks, as pruning takes two sets */
    enum { STEP = sizeof(float) };
    msap_boxes boxes = {sizeof boxes, MSAP_FLOAT, NULL, NULL, STEP, STEP, STEP, STEP};
    size_t size = k * sizeof *from;
    unsigned char *to = renew(blocks[turn], layout % 3 < 2 ? size : 2 * size + 1);
    blocks[turn] = to;
    turn = !turn;
    boxes.min = to;
    switch (layout % 3) {
    case 0: in_row(from, k, to, &boxes); break;
    case 1: by_component(from, k, to, &boxes); break;
    default: doubles_backwards(from, k, to, &boxes);
    }
    return boxes;
}

void set_first(call *c, uint32_t dims)
{
    static float *min, *max;
    size_t size = dims * sizeof(float);
    min = renew(min, size);
    max = renew(max, size);
    c->min = memcpy(min, c->bounds[0].min, size);
    c->max = memcpy(max, c->bounds[0].max, size);
}

/* -------------------------------------------------------------------- calls */

/* Most numbers of boxes are small: scenes of many are slow. */
enum { MANY = 0xF000 };

static void take_additions(input *in, const herd *h, call *c)
{
    source s = take_source(in);
    size_t places = h->most - h->count, i;
    uint32_t statics = (uint32_t)take(in, 1), count = (uint32_t)take(in, 2);
    c->k = (count < MANY ? count & 63 : count) % (places + 1);
    for (i = 0; i < c->k; i++) {
        c->bounds[i] = scaled(random_box(&s.random, s.scene), s.exponent);
        c->flags[i] = (random_next(&s.random) & 255) < statics ? MSAP_STATIC : 0;
    }
}

/* Some of the boxes, in order or backwards. */
static void take_members(input *in, const herd *h, call *c, uint64_t *random)
{
    uint32_t share = (uint32_t)take(in, 1), i;
    c->k = 0;
    for (i = 0; i < h->count; i++)
        if ((random_next(random) & 255) <= share)
            c->member[c->k++] = share & 1 ? i : h->count - 1 - i;
    for (i = 0; i < c->k; i++)
        c->handles[i] = h->live[c->member[i]].handle;
}

/* By a step each, or to anywhere; and one of them twice. */
static void take_updates(input *in, const herd *h, call *c)
{
    source s = take_source(in);
    uint32_t how = (uint32_t)take(in, 1);
    size_t i;
    take_members(in, h, c, &s.random);
    if (c->k > 1 && (how & 4))
        c->member[c->k - 1] = c->member[0];
    for (i = 0; i < c->k; i++) {
        const struct member *m = &h->live[c->member[i]];
        c->handles[i] = m->handle;
        if (how % 4 == 0)
            c->bounds[i] = scaled(random_box(&s.random, s.scene), s.exponent);
        else
            c->bounds[i] = how % 4 == 1 ? moved_box(&s.random, SCENE_GRID, &m->bounds) : stepped(&s, &m->bounds);
        order(&c->bounds[i]);
    }
}

static void take_one(input *in, const herd *h, call *c)
{
    size_t member = take(in, 2);
    c->k = h->count > 0;
    if (c->k == 0)
        return;
    c->member[0] = member % h->count;
    c->handles[0] = h->live[c->member[0]].handle;
}

static void take_offset(input *in, call *c)
{
    uint32_t kind = (uint32_t)take(in, 1);
    int axis;
    for (axis = 0; axis < 3; axis++) {
        if (kind % 3 == 0)
            c->offset[axis] = (double)(int)take(in, 1) - 128;
        else
            c->offset[axis] = kind % 3 == 1 ? take_hard(in) : take_double(in);
        if (!isfinite(c->offset[axis]))
            c->offset[axis] = 0.1;
    }
}

static void take_arguments(input *in, const herd *h, call *c)
{
    uint64_t random = 1;
    switch (c->kind) {
    case CALL_ADD:
        c->k = h->count < h->most;
        c->flags[0] = (uint32_t)take(in, 1) & MSAP_STATIC;
        c->bounds[0] = take_box(in);
        break;
    case CALL_ADD_MANY: take_additions(in, h, c); break;
    case CALL_UPDATE:
        take_one(in, h, c);
        c->bounds[0] = take_box(in);
        break;
    case CALL_UPDATE_MANY: take_updates(in, h, c); break;
    case CALL_REMOVE: take_one(in, h, c); break;
    case CALL_REMOVE_MANY:
        random = take(in, 1);
        take_members(in, h, c, &random);
        break;
    case CALL_SHIFT: take_offset(in, c); break;
    default: break;
    }
}

int take_call(input *in, const herd *h, call *c)
{
    static const uint8_t kinds[] = {
        CALL_ADD,    CALL_ADD,         CALL_ADD_MANY,    CALL_ADD_MANY, CALL_UPDATE, CALL_UPDATE,
        CALL_COMMIT, CALL_UPDATE_MANY, CALL_UPDATE_MANY, CALL_REMOVE,   CALL_REMOVE_MANY, CALL_SHIFT,
        CALL_TRIM,   CALL_COMMIT,      CALL_COMMIT,      CALL_DATA,     CALL_WRONG,  CALL_OTHER,
    };
    uint32_t layout;
    if (in->at == in->end)
        return 0;
    layout = (uint32_t)take(in, 1);
    c->kind = (call_kind)kinds[layout % COUNT(kinds)];
    c->k = 0;
    c->argument = 0;
    if (c->kind == CALL_WRONG || c->kind == CALL_OTHER || c->kind == CALL_DATA || c->kind == CALL_COMMIT)
        c->argument = (uint32_t)take(in, c->kind == CALL_COMMIT ? 1 : 2);
    take_arguments(in, h, c);
    if (c->kind == CALL_ADD || c->kind == CALL_UPDATE)
        set_first(c, h->dims);
    else
        c->boxes = lay_out(c->bounds, c->kind == CALL_ADD_MANY || c->kind == CALL_UPDATE_MANY ? c->k : 0,
                           layout / COUNT(kinds));
    return 1;
}

msap_status carry_out(msap_world *world, const call *c, msap_handle *handles)
{
    switch (c->kind) {
    case CALL_ADD:
        return c->k > 0 ? msap_add(world, c->min, c->max, c->flags[0], NULL, handles) : MSAP_OK;
    case CALL_ADD_MANY: return msap_add_many(world, c->k, &c->boxes, c->flags, NULL, handles);
    case CALL_UPDATE:
        return c->k > 0 ? msap_update(world, c->handles[0], c->min, c->max) : MSAP_OK;
    case CALL_UPDATE_MANY: return msap_update_many(world, c->k, c->handles, &c->boxes);
    case CALL_REMOVE: return c->k > 0 ? msap_remove(world, c->handles[0]) : MSAP_OK;
    case CALL_REMOVE_MANY: return msap_remove_many(world, c->k, c->handles);
    case CALL_SHIFT: return msap_shift_origin(world, c->offset);
    case CALL_TRIM: return msap_trim(world);
    case CALL_COMMIT: return msap_commit(world, NULL, NULL);
    default: return MSAP_OK;
    }
}

/* ----------------------------------------------------------------- the herd */

void herd_begin(herd *h, uint32_t dims, size_t most)
{
    h->dims = dims;
    h->count = 0;
    h->most = most;
    h->dead = MSAP_NULL_HANDLE;
}

static void herd_add(herd *h, const call *c)
{
    size_t i;
    for (i = 0; i < c->k; i++) {
        h->live[h->count].handle = c->handles[i];
        h->live[h->count++].bounds = c->bounds[i];
    }
}

/* Members that are named in rising or falling order. */
static void herd_remove(herd *h, const call *c)
{
    size_t i, kept = 0, gone = 0;
    for (i = 0; i < c->k; i++) {
        h->dead = c->handles[i];
        h->live[c->member[i]].handle = MSAP_NULL_HANDLE;
    }
    for (i = 0; i < h->count; i++)
        if (h->live[i].handle != MSAP_NULL_HANDLE)
            h->live[kept++] = h->live[i];
        else
            gone++;
    h->count -= gone;
}

void herd_follow(herd *h, const call *c)
{
    size_t i;
    switch (c->kind) {
    case CALL_ADD:
    case CALL_ADD_MANY: herd_add(h, c); break;
    case CALL_UPDATE:
    case CALL_UPDATE_MANY:
        for (i = 0; i < c->k; i++)
            h->live[c->member[i]].bounds = c->bounds[i];
        break;
    case CALL_REMOVE:
    case CALL_REMOVE_MANY: herd_remove(h, c); break;
    default: break;
    }
}
