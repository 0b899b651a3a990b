/* Bullet's broad phases, from Debian's libbullet-dev.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The two sweep-and-prunes are told the world's bounds and round boxes to steps of
 * them; the pair of trees fattens boxes. All keep the pairs and change them. */
#include "mode.h"

#include <BulletCollision/BroadphaseCollision/btAxisSweep3.h>
#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>

#include <algorithm>
#include <vector>

namespace {

struct broad_phase {
    btHashedOverlappingPairCache cache;
    btBroadphaseInterface *bullet;
    std::vector<btBroadphaseProxy *> proxy;
};

btVector3 vector_of(const float *p) { return btVector3(p[0], p[1], p[2]); }

uint32_t id_of(const btBroadphaseProxy *p) { return (uint32_t)(size_t)p->m_clientObject; }

/* A flat world would have no steps. */
void world_of(const scene *s, btVector3 *low, btVector3 *high)
{
    *low = vector_of(s->world_min);
    *high = vector_of(s->world_max);
    for (int k = 0; k < 3; k++) {
        btScalar room = ((*high)[k] - (*low)[k]) / 1000;
        (*low)[k] -= room > 0 ? room : 1;
        (*high)[k] += room > 0 ? room : 1;
    }
}

broad_phase *open(const scene *s)
{
    broad_phase *p = new broad_phase;
    p->proxy.resize(s->ids);
    return p;
}

void *open_tree(const scene *s)
{
    broad_phase *p = open(s);
    p->bullet = new btDbvtBroadphase(&p->cache);
    return p;
}

void *open_16(const scene *s)
{
    broad_phase *p = open(s);
    btVector3 low, high;
    world_of(s, &low, &high);
    p->bullet = new btAxisSweep3(low, high, (unsigned short)std::max(s->ids + 1, 16u), &p->cache, true);
    return p;
}

void *open_32(const scene *s)
{
    broad_phase *p = open(s);
    btVector3 low, high;
    world_of(s, &low, &high);
    p->bullet = new bt32BitAxisSweep3(low, high, std::max(s->ids + 1, 16u), &p->cache, true);
    return p;
}

void step(void *state, const frame *f)
{
    broad_phase *p = (broad_phase *)state;
    for (size_t i = 0; i < f->n_removed; i++) p->bullet->destroyProxy(p->proxy[f->removed[i]], 0);
    for (size_t i = 0; i < f->n_added; i++) {
        const change &c = f->added[i];
        int is = c.is_static ? btBroadphaseProxy::StaticFilter : btBroadphaseProxy::DefaultFilter;
        int meets = c.is_static ? ~btBroadphaseProxy::StaticFilter : btBroadphaseProxy::AllFilter;
        p->proxy[c.id] =
            p->bullet->createProxy(vector_of(c.min), vector_of(c.max), 0, (void *)(size_t)c.id, is, meets, 0);
    }
    for (size_t i = 0; i < f->n_moved; i++)
        p->bullet->setAabb(p->proxy[f->moved[i].id], vector_of(f->moved[i].min), vector_of(f->moved[i].max), 0);
    p->bullet->calculateOverlappingPairs(0);
}

size_t pairs(void *state, id_pair *out, size_t room)
{
    const btBroadphasePairArray &all = ((broad_phase *)state)->cache.getOverlappingPairArray();
    size_t n = (size_t)all.size();
    for (size_t i = 0; i < n && n <= room; i++) {
        out[i].a = id_of(all[(int)i].m_pProxy0);
        out[i].b = id_of(all[(int)i].m_pProxy1);
    }
    return n;
}

} // namespace

extern const mode modes[] = {
    {"Bullet, trees", 0, open_tree, step, pairs},
    {"Bullet, 16-bit SAP", 0, open_16, step, pairs},
    {"Bullet, 32-bit SAP", 0, open_32, step, pairs},
    {NULL, 0, NULL, NULL, NULL},
};
