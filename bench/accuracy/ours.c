/* The library, exact; and what a caller may do to its boxes before the call.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Error belongs to the caller, who knows what it may cost: each of these modes changes
 * boxes in a way that reports pairs in vain and misses none, and spares calls where the
 * changed box is the same as before.
 *
 *     exact, margin auto      as they are, in the default set-up
 *     exact, margin 0         the same without skins inside the library
 *     exact, margin 10 %      with skins of that part of the scene's box size
 *     fat boxes, W            wider by W of the scene's box size on each side, and given
 *                             anew only when the box has left the fat one (margin 0)
 *     16 bits                 outward to 65536 steps over the world (margin auto)
 *     doubles                 as doubles, which the library rounds outward to floats
 *     doubles, near           the same, from an origin in the scene */
#include "mode.h"

#include <math.h>
#include <multisap.h>
#include <string.h>

/* How a mode makes the box that is given out of the box that is. Returns whether it has
 * to be given: `given` is the last one that was. */
struct ours;
typedef int (*change_fn)(const struct ours *o, const change *c, float given[6]);

struct ours {
    msap_world *world;
    uint32_t dims;
    msap_scalar scalar;
    change_fn change;        /* NULL: given as they are */
    double width;            /* of fat boxes */
    double low[3], steps[3]; /* of the 16-bit world: its beginning, and steps in a unit */
    double origin;
    msap_handle *handle; /* [ids] */
    uint32_t *id_of;     /* [slots] */
    float (*given)[6];   /* [ids] min, max; for change */
    struct batch {
        msap_handle *handle;
        float (*floats)[6];
        double (*doubles)[6];
    } batch; /* [ids] of what is given in a frame */
};

static void must(msap_status status)
{
    if (status)
        give_up("%s", msap_status_text(status));
}

/* -------------------------------------------------------------- the changes */

static int fatten(const struct ours *o, const change *c, float given[6])
{
    int is_inside = 1;
    for (int k = 0; k < 3; k++) is_inside &= given[k] <= c->min[k] && c->max[k] <= given[k + 3];
    if (is_inside)
        return 0;
    for (int k = 0; k < 3; k++) {
        given[k] = nextafterf((float)(c->min[k] - o->width), -INFINITY);
        given[k + 3] = nextafterf((float)(c->max[k] + o->width), INFINITY);
    }
    return 1;
}

/* A millionth of a step makes up for what the arithmetic may round. */
static float to_16_bits(double steps, int up)
{
    double whole = up ? ceil(steps + 1e-6) : floor(steps - 1e-6);
    return (float)(whole < 0 ? 0 : whole > 65535 ? 65535 : whole);
}

static int quantize(const struct ours *o, const change *c, float given[6])
{
    int changed = 0;
    for (int k = 0; k < 3; k++) {
        float min = to_16_bits((c->min[k] - o->low[k]) * o->steps[k], 0);
        float max = to_16_bits((c->max[k] - o->low[k]) * o->steps[k], 1);
        changed |= min != given[k] || max != given[k + 3];
        given[k] = min;
        given[k + 3] = max;
    }
    return changed;
}

/* ---------------------------------------------------------------- a frame */

static void put_doubles(const struct ours *o, const change *c, double to[6])
{
    for (int k = 0; k < 3; k++) {
        to[k] = c->true_min[k];
        to[k + 3] = c->true_max[k];
        if (o->origin != 0 && (uint32_t)k < o->dims) {
            to[k] = nextafter(to[k] - o->origin, -INFINITY);
            to[k + 3] = nextafter(to[k + 3] - o->origin, INFINITY);
        }
    }
}

/* Writes what the library is given of these boxes; returns of how many. */
static size_t fill(struct ours *o, const change *c, size_t n)
{
    size_t filled = 0;
    for (size_t i = 0; i < n; i++) {
        if (o->change && !o->change(o, &c[i], o->given[c[i].id]))
            continue;
        if (o->change)
            memcpy(o->batch.floats[filled], o->given[c[i].id], sizeof *o->given);
        else if (o->scalar == MSAP_DOUBLE)
            put_doubles(o, &c[i], o->batch.doubles[filled]);
        o->batch.handle[filled++] = o->handle[c[i].id];
    }
    return filled;
}

/* The bounds as fill left them, or, given as they are, those of the changes. */
static msap_boxes view(const struct ours *o, const change *c)
{
    msap_boxes b = {sizeof b, o->scalar, c->min, c->max, sizeof *c, sizeof(float), sizeof *c, sizeof(float)};
    if (o->change) {
        b.min = o->batch.floats[0];
        b.max = o->batch.floats[0] + 3;
        b.min_row = b.max_row = sizeof *o->batch.floats;
    } else if (o->scalar == MSAP_DOUBLE) {
        b.min = o->batch.doubles[0];
        b.max = o->batch.doubles[0] + 3;
        b.min_row = b.max_row = sizeof *o->batch.doubles;
        b.min_component = b.max_component = sizeof(double);
    }
    return b;
}

static void remove_boxes(struct ours *o, const frame *f)
{
    for (size_t i = 0; i < f->n_removed; i++) o->batch.handle[i] = o->handle[f->removed[i]];
    must(msap_remove_many(o->world, f->n_removed, o->batch.handle));
}

/* One call for each: a fat box of an id that was removed must not be taken for the new
 * one's, and flags differ. */
static void add_boxes(struct ours *o, const frame *f)
{
    for (const change *c = f->added; c < f->added + f->n_added; c++) {
        uint32_t flags = c->is_static ? MSAP_STATIC : 0;
        for (int k = 0; k < 6 && o->change; k++) o->given[c->id][k] = NAN;
        fill(o, c, 1);
        msap_boxes boxes = view(o, c);
        must(msap_add_many(o->world, 1, &boxes, &flags, NULL, &o->handle[c->id]));
        o->id_of[o->handle[c->id] >> 32] = c->id;
    }
}

static void step(void *state, const frame *f)
{
    struct ours *o = state;
    remove_boxes(o, f);
    add_boxes(o, f);
    size_t n = fill(o, f->moved, f->n_moved);
    msap_boxes boxes = view(o, f->moved);
    must(msap_update_many(o->world, n, o->batch.handle, &boxes));
    must(msap_commit(o->world, NULL, NULL));
}

/* Slots are given out anew only after the commit, so an id is looked up by slot. */
static size_t pairs(void *state, id_pair *out, size_t room)
{
    const struct ours *o = state;
    const msap_pair *p;
    size_t n;
    must(msap_pairs(o->world, &p, &n));
    for (size_t i = 0; i < n && n <= room; i++) {
        out[i].a = o->id_of[p[i].a >> 32];
        out[i].b = o->id_of[p[i].b >> 32];
    }
    return n;
}

/* -------------------------------------------------------------- the modes */

static struct ours *open_with(const scene *s, float margin)
{
    struct ours *o = get(1, sizeof *o);
    msap_config config;
    must(msap_config_init(&config, sizeof config));
    config.dims = s->dims;
    config.margin = margin;
    must(msap_create(&config, &o->world));
    o->dims = s->dims;
    o->handle = get(s->ids, sizeof *o->handle);
    o->id_of = get(2 * (size_t)s->ids, sizeof *o->id_of);
    o->batch.handle = get(s->ids, sizeof *o->batch.handle);
    return o;
}

static void *open_auto(const scene *s) { return open_with(s, MSAP_MARGIN_AUTO); }
static void *open_bare(const scene *s) { return open_with(s, 0); }
static void *open_skins(const scene *s) { return open_with(s, 0.1f * s->size); }

static void set_change(struct ours *o, const scene *s, change_fn change)
{
    o->change = change;
    o->given = get(s->ids, sizeof *o->given);
    o->batch.floats = get(s->ids, sizeof *o->batch.floats);
}

static void *open_fat(const scene *s, double width)
{
    struct ours *o = open_with(s, 0);
    set_change(o, s, fatten);
    o->width = width * s->size;
    return o;
}

static void *open_fat_2(const scene *s) { return open_fat(s, 0.02); }
static void *open_fat_10(const scene *s) { return open_fat(s, 0.1); }
static void *open_fat_50(const scene *s) { return open_fat(s, 0.5); }

static void *open_16_bits(const scene *s)
{
    struct ours *o = open_with(s, MSAP_MARGIN_AUTO);
    set_change(o, s, quantize);
    for (int k = 0; k < 3; k++) {
        double extent = (double)s->world_max[k] - s->world_min[k];
        o->low[k] = s->world_min[k];
        o->steps[k] = extent > 0 ? 65535 / extent : 0;
    }
    return o;
}

static void *open_doubles(const scene *s)
{
    struct ours *o = open_with(s, MSAP_MARGIN_AUTO);
    o->scalar = MSAP_DOUBLE;
    o->batch.doubles = get(s->ids, sizeof *o->batch.doubles);
    return o;
}

static void *open_doubles_near(const scene *s)
{
    struct ours *o = open_doubles(s);
    o->origin = s->distance;
    return o;
}

const mode modes[] = {
    {"exact, margin auto", 0, open_auto, step, pairs},
    {"exact, margin 0", 0, open_bare, step, pairs},
    {"exact, margin 10 %", 0, open_skins, step, pairs},
    {"fat boxes, 2 %", 0, open_fat_2, step, pairs},
    {"fat boxes, 10 %", 0, open_fat_10, step, pairs},
    {"fat boxes, 50 %", 0, open_fat_50, step, pairs},
    {"16 bits", 0, open_16_bits, step, pairs},
    {"doubles", 1, open_doubles, step, pairs},
    {"doubles, near", 1, open_doubles_near, step, pairs},
    {NULL, 0, NULL, NULL, NULL},
};
