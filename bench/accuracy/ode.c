/* ODE's spaces, from Debian's libode-dev.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A geometry class of our own tells ODE the boxes as they are, without a centre and
 * lengths that would round them. ODE finds all pairs anew in every frame. */
#include "mode.h"

#include <math.h>
#include <ode/ode.h>
#include <stdlib.h>
#include <string.h>

struct space {
    dSpaceID space;
    dGeomID *geom;         /* [ids] */
    const change **bounds; /* [ids] */
    id_pair *pairs;
    size_t n, room;
};

static int geom_class;

static void tell_bounds(dGeomID geom, dReal out[6])
{
    const change *c = *(const change *const *)dGeomGetData(geom);
    for (int k = 0; k < 6; k++) out[k] = k % 2 ? c->max[k / 2] : c->min[k / 2];
}

static dColliderFn *no_collider(int other)
{
    (void)other;
    return NULL;
}

static struct space *open_space(const scene *s, dSpaceID (*make)(void))
{
    struct space *p = get(1, sizeof *p);
    dGeomClass class = {0, no_collider, tell_bounds, NULL, NULL};
    dInitODE2(0);
    geom_class = dCreateGeomClass(&class);
    p->space = make();
    p->geom = get(s->ids, sizeof *p->geom);
    p->bounds = get(s->ids, sizeof *p->bounds);
    return p;
}

static dSpaceID make_sap(void) { return dSweepAndPruneSpaceCreate(0, dSAP_AXES_XYZ); }
static dSpaceID make_hash(void) { return dHashSpaceCreate(0); }

static void *open_sap(const scene *s) { return open_space(s, make_sap); }

/* Its cells go from an eighth of the scene's box size to 128 times that. */
static void *open_hash(const scene *s)
{
    struct space *p = open_space(s, make_hash);
    int level = (int)ceil(log2(s->size));
    dHashSpaceSetLevels(p->space, level - 3, level + 7);
    return p;
}

/* To set a position, whatever it is, is how ODE learns that the bounds have changed. */
static void put(struct space *p, const change *c)
{
    p->bounds[c->id] = c;
    dGeomSetPosition(p->geom[c->id], c->min[0], c->min[1], c->min[2]);
}

static void add(struct space *p, const change *c)
{
    dGeomID geom = p->geom[c->id] = dCreateGeom(geom_class);
    dGeomSetData(geom, &p->bounds[c->id]);
    dGeomSetCategoryBits(geom, c->is_static ? 2 : 1);
    dGeomSetCollideBits(geom, c->is_static ? 1 : 3);
    put(p, c);
    dSpaceAdd(p->space, geom);
}

static void found(void *state, dGeomID a, dGeomID b)
{
    struct space *p = state;
    if (p->n == p->room) {
        p->room = 2 * p->room + 1024;
        p->pairs = realloc(p->pairs, p->room * sizeof *p->pairs);
        if (!p->pairs)
            give_up("no memory");
    }
    p->pairs[p->n].a = (uint32_t)((const change **)dGeomGetData(a) - p->bounds);
    p->pairs[p->n++].b = (uint32_t)((const change **)dGeomGetData(b) - p->bounds);
}

static void step(void *state, const frame *f)
{
    struct space *p = state;
    for (size_t i = 0; i < f->n_removed; i++) dGeomDestroy(p->geom[f->removed[i]]);
    for (size_t i = 0; i < f->n_added; i++) add(p, &f->added[i]);
    for (size_t i = 0; i < f->n_moved; i++) put(p, &f->moved[i]);
    p->n = 0;
    dSpaceCollide(p->space, p, found);
}

static size_t pairs(void *state, id_pair *out, size_t room)
{
    const struct space *p = state;
    if (p->n > 0 && p->n <= room)
        memcpy(out, p->pairs, p->n * sizeof *out);
    return p->n;
}

const mode modes[] = {
    {"ODE, SAP", 0, open_sap, step, pairs},
    {"ODE, hash", 0, open_hash, step, pairs},
    {NULL, 0, NULL, NULL, NULL},
};
