/* Scenes; see scene.h. Traces are described in docs/multisap.1.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Generated scenes are made of doubles, so that a scene far from the origin is the same
 * as the one near it, but for the last bits of a double:
 *
 *     drift  3000 boxes about 1 wide drift through a cube, each at its own speed, and
 *            meet one another now and then
 *     pile   3000 boxes lie upon each other in columns, a hundredth apart sideways, and
 *            all tremble, as resting bodies do in a simulation
 *     few    as drift, but 6000, of which one in 30 moves
 */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The nearest float that is not above (up = 0) or not below (up = 1). */
static float outward(double value, int up)
{
    float nearest = (float)value;
    if (up ? (double)nearest < value : (double)nearest > value)
        nearest = nextafterf(nearest, up ? INFINITY : -INFINITY);
    return nearest;
}

static void round_change(change *c)
{
    for (int k = 0; k < 3; k++) {
        c->min[k] = outward(c->true_min[k], 0);
        c->max[k] = outward(c->true_max[k], 1);
    }
}

/* ------------------------------------------------------------------ traces */

struct reader {
    FILE *file;
    const char *name;
};

static void take(struct reader *r, void *to, size_t size)
{
    if (fread(to, 1, size, r->file) != size)
        give_up("%s: cut short, or no trace", r->name);
}

static uint32_t take_u32(struct reader *r)
{
    unsigned char b[4];
    take(r, b, sizeof b);
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static float take_float(struct reader *r)
{
    uint32_t bits = take_u32(r);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static change *take_changes(struct reader *r, size_t n, int has_flags)
{
    change *all = get(n, sizeof *all);
    for (change *c = all; c < all + n; c++) {
        c->id = take_u32(r);
        c->is_static = has_flags ? take_u32(r) & 1 : 0;
        for (int k = 0; k < 6; k++) *(k < 3 ? &c->true_min[k] : &c->true_max[k - 3]) = take_float(r);
        round_change(c);
    }
    return all;
}

static frame take_frame(struct reader *r)
{
    frame f = {0};
    f.n_removed = take_u32(r);
    f.n_added = take_u32(r);
    f.n_moved = take_u32(r);
    uint32_t *removed = get(f.n_removed, sizeof *removed);
    for (size_t i = 0; i < f.n_removed; i++) removed[i] = take_u32(r);
    f.removed = removed;
    f.added = take_changes(r, f.n_added, 1);
    f.moved = take_changes(r, f.n_moved, 0);
    return f;
}

static scene read_trace(const char *name)
{
    struct reader r = {fopen(name, "rb"), name};
    char magic[8];
    scene s = {0};
    if (!r.file)
        give_up("%s cannot be opened", name);
    take(&r, magic, sizeof magic);
    if (memcmp(magic, "SAPTRC01", sizeof magic) != 0)
        give_up("%s is no trace", name);
    s.n_frames = take_u32(&r);
    s.ids = take_u32(&r);
    s.dims = take_u32(&r);
    for (int k = 0; k < 6; k++) take_float(&r); /* the world's bounds, giants and all */
    s.frames = get(s.n_frames, sizeof *s.frames);
    for (uint32_t f = 0; f < s.n_frames; f++) s.frames[f] = take_frame(&r);
    fclose(r.file);
    return s;
}

/* --------------------------------------------------------------- generated */

struct body {
    double centre[3], velocity[3], half[3];
};

struct generator {
    uint64_t random;
    double side; /* the bodies stay between 0 and this, if they drift */
    struct body *bodies;
};

/* From low to high; splitmix64. */
static double between(struct generator *g, double low, double high)
{
    uint64_t x = g->random += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return low + (high - low) * (double)((x ^ (x >> 31)) >> 11) / 9007199254740992.0;
}

/* Boxes about 1 wide in a cube of this side meet 8 n / side^3 others: one. */
static void scatter(struct generator *g, uint32_t n)
{
    g->side = 2 * cbrt(n);
    for (uint32_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            g->bodies[i].centre[k] = between(g, 0, g->side);
            g->bodies[i].velocity[k] = between(g, -0.03, 0.03);
            g->bodies[i].half[k] = between(g, 0.35, 0.65);
        }
}

static void pile_up(struct generator *g, uint32_t n)
{
    uint32_t rows = (uint32_t)ceil(sqrt(n / 10.0));
    g->side = rows;
    for (uint32_t i = 0; i < n; i++) {
        struct body *b = &g->bodies[i];
        b->centre[0] = i % rows * 1.01;
        b->centre[1] = i / rows % rows * 1.01;
        b->centre[2] = i / (rows * rows);
        b->half[0] = b->half[1] = b->half[2] = 0.5;
    }
}

static void drift(struct generator *g, struct body *b)
{
    for (int k = 0; k < 3; k++) {
        b->centre[k] += b->velocity[k];
        if (b->centre[k] < 0 || b->centre[k] > g->side)
            b->velocity[k] = -b->velocity[k];
    }
}

static change box_of(struct generator *g, uint32_t id, double tremble, double distance)
{
    const struct body *b = &g->bodies[id];
    change c = {0};
    c.id = id;
    for (int k = 0; k < 3; k++) {
        double at = distance + b->centre[k] + (tremble > 0 ? between(g, -tremble, tremble) : 0);
        c.true_min[k] = at - b->half[k];
        c.true_max[k] = at + b->half[k];
    }
    round_change(&c);
    return c;
}

/* What a kind of generated scene is like. */
static const struct recipe {
    const char *name;
    uint32_t boxes, frames, one_in; /* of how many boxes one moves */
    double tremble;                 /* 0: they drift */
} recipes[] = {
    {"drift", 3000, 60, 1, 0},
    {"pile", 3000, 60, 1, 0.003},
    {"few", 6000, 60, 30, 0},
};

static scene generate(const struct recipe *r, double distance)
{
    struct generator g = {r->boxes, 0, get(r->boxes, sizeof *g.bodies)};
    uint32_t movers = r->boxes / r->one_in;
    scene s = {0};
    change *at = get(r->boxes + (size_t)movers * (r->frames - 1), sizeof *at);
    (r->tremble > 0 ? pile_up : scatter)(&g, r->boxes);
    s.dims = 3;
    s.ids = r->boxes;
    s.n_frames = r->frames;
    s.frames = get(s.n_frames, sizeof *s.frames);
    s.frames[0].added = at;
    s.frames[0].n_added = r->boxes;
    for (uint32_t i = 0; i < r->boxes; i++) *at++ = box_of(&g, i, r->tremble, distance);
    for (uint32_t f = 1; f < r->frames; f++) {
        s.frames[f].moved = at;
        s.frames[f].n_moved = movers;
        for (uint32_t i = 0; i < movers; i++) {
            drift(&g, &g.bodies[i * r->one_in]);
            *at++ = box_of(&g, i * r->one_in, r->tremble, distance);
        }
    }
    s.distance = distance;
    free(g.bodies);
    return s;
}

static scene generate_by_name(const char *name)
{
    size_t length = strcspn(name, "@");
    double distance = name[length] ? strtod(name + length + 1, NULL) : 0;
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; i++)
        if (strlen(recipes[i].name) == length && strncmp(name, recipes[i].name, length) == 0)
            return generate(&recipes[i], distance);
    give_up("there is no scene %s", name);
    exit(1);
}

/* --------------------------------------------------------------- the whole */

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The widest side; infinite if a bound is infinite or nearly so. */
static float widest(const change *c)
{
    float side = 0;
    for (int k = 0; k < 3; k++) {
        if (!(c->min[k] > -1e30f && c->max[k] < 1e30f))
            return INFINITY;
        side = fmaxf(side, c->max[k] - c->min[k]);
    }
    return side;
}

/* The median over the first frame that has boxes of the widest side of those that are
 * finite and not static. */
static float size_of(const scene *s)
{
    for (uint32_t f = 0; f < s->n_frames; f++) {
        const frame *now = &s->frames[f];
        float *sizes = get(now->n_added, sizeof *sizes), size = 0;
        size_t n = 0;
        for (const change *c = now->added; c < now->added + now->n_added; c++) {
            sizes[n] = widest(c);
            n += !c->is_static && sizes[n] < 1e30f;
        }
        qsort(sizes, n, sizeof *sizes, by_value);
        if (n > 0)
            size = sizes[n / 2];
        free(sizes);
        if (size > 0)
            return size;
    }
    return 1;
}

static void grow_world(scene *s, const change *changes, size_t n)
{
    for (const change *c = changes; c < changes + n; c++)
        for (int k = 0; k < 3 && widest(c) <= 1000 * s->size; k++) {
            s->world_min[k] = fminf(s->world_min[k], c->min[k]);
            s->world_max[k] = fmaxf(s->world_max[k], c->max[k]);
        }
}

static void set_world(scene *s)
{
    for (int k = 0; k < 3; k++) {
        s->world_min[k] = INFINITY;
        s->world_max[k] = -INFINITY;
    }
    for (const frame *f = s->frames; f < s->frames + s->n_frames; f++) {
        grow_world(s, f->added, f->n_added);
        grow_world(s, f->moved, f->n_moved);
    }
}

scene scene_of(const char *name)
{
    size_t length = strlen(name);
    int is_trace = length > 6 && strcmp(name + length - 6, ".trace") == 0;
    scene s = is_trace ? read_trace(name) : generate_by_name(name);
    s.name = name;
    s.size = size_of(&s);
    set_world(&s);
    return s;
}
