/* FCL's broad phases, from Debian's libfcl-dev.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A geometry without a shape has the bounds as they are. FCL finds all pairs anew in
 * every frame. */
#include "mode.h"

#include <fcl/fcl.h>

#include <cstring>
#include <memory>
#include <vector>

namespace {

struct bounds_only : fcl::CollisionGeometryf {
    void computeLocalAABB() override {}
    fcl::OBJECT_TYPE getObjectType() const override { return fcl::OT_GEOM; }
    fcl::NODE_TYPE getNodeType() const override { return fcl::GEOM_BOX; }
};

struct manager {
    std::unique_ptr<fcl::BroadPhaseCollisionManagerf> fcl;
    std::vector<std::shared_ptr<bounds_only>> bounds;
    std::vector<std::unique_ptr<fcl::CollisionObjectf>> object;
    std::vector<char> is_static;
    std::vector<fcl::CollisionObjectf *> batch;
    std::vector<id_pair> pairs;
};

template <class kind> void *open(const scene *s)
{
    manager *m = new manager;
    m->fcl.reset(new kind);
    m->bounds.resize(s->ids);
    m->object.resize(s->ids);
    m->is_static.resize(s->ids);
    return m;
}

void put(manager *m, const change &c)
{
    m->bounds[c.id]->aabb_local.min_ = fcl::Vector3f(c.min[0], c.min[1], c.min[2]);
    m->bounds[c.id]->aabb_local.max_ = fcl::Vector3f(c.max[0], c.max[1], c.max[2]);
    m->object[c.id]->computeAABB();
    m->batch.push_back(m->object[c.id].get());
}

void add(manager *m, const change &c)
{
    m->bounds[c.id] = std::make_shared<bounds_only>();
    m->object[c.id].reset(new fcl::CollisionObjectf(m->bounds[c.id]));
    m->object[c.id]->setUserData((void *)(size_t)c.id);
    m->is_static[c.id] = c.is_static != 0;
    put(m, c);
}

bool found(fcl::CollisionObjectf *a, fcl::CollisionObjectf *b, void *state)
{
    manager *m = (manager *)state;
    id_pair p = {(uint32_t)(size_t)a->getUserData(), (uint32_t)(size_t)b->getUserData()};
    if (!(m->is_static[p.a] && m->is_static[p.b]))
        m->pairs.push_back(p);
    return false;
}

/* All at once if they are the first, as its documentation asks. */
void register_batch(manager *m)
{
    if (m->fcl->size() == 0)
        m->fcl->registerObjects(m->batch);
    else
        for (fcl::CollisionObjectf *o : m->batch) m->fcl->registerObject(o);
}

void step(void *state, const frame *f)
{
    manager *m = (manager *)state;
    for (size_t i = 0; i < f->n_removed; i++) m->fcl->unregisterObject(m->object[f->removed[i]].get());
    m->batch.clear();
    for (size_t i = 0; i < f->n_added; i++) add(m, f->added[i]);
    if (!m->batch.empty())
        register_batch(m);
    m->batch.clear();
    for (size_t i = 0; i < f->n_moved; i++) put(m, f->moved[i]);
    if (!m->batch.empty())
        m->fcl->update(m->batch);
    m->fcl->setup();
    m->pairs.clear();
    if (m->fcl->size() > 0)
        m->fcl->collide(m, found);
}

size_t pairs(void *state, id_pair *out, size_t room)
{
    const manager *m = (const manager *)state;
    if (!m->pairs.empty() && m->pairs.size() <= room)
        std::memcpy(out, m->pairs.data(), m->pairs.size() * sizeof *out);
    return m->pairs.size();
}

} // namespace

extern const mode modes[] = {
    {"FCL, SAP", 0, open<fcl::SSaPCollisionManagerf>, step, pairs},
    {"FCL, tree", 0, open<fcl::DynamicAABBTreeCollisionManagerf>, step, pairs},
    {NULL, 0, NULL, NULL, NULL},
};
