/* CGAL's box intersection, from Debian's libcgal-dev.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * It finds all pairs anew in every frame: of moving boxes, and of moving and static
 * ones. */
#include "mode.h"

#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <cstring>
#include <vector>

namespace {

struct box {
    typedef float NT;
    typedef size_t ID;
    const change *at; /* NULL: gone */
    uint32_t number;
    bool is_static;
    static int dimension() { return 3; }
    float min_coord(int k) const { return at->min[k]; }
    float max_coord(int k) const { return at->max[k]; }
    ID id() const { return number; }
};

struct boxes {
    std::vector<box> by_id;
    std::vector<box *> moving, resting;
    std::vector<id_pair> pairs;
};

void *open(const scene *s)
{
    boxes *b = new boxes;
    b->by_id.resize(s->ids);
    return b;
}

bool is_gone(const box *b) { return b->at == NULL; }

void remove_gone(std::vector<box *> &from)
{
    from.erase(std::remove_if(from.begin(), from.end(), is_gone), from.end());
}

void step(void *state, const frame *f)
{
    boxes *b = (boxes *)state;
    const std::ptrdiff_t cutoff = 200;
    const CGAL::Box_intersection_d::Topology closed = CGAL::Box_intersection_d::CLOSED;
    for (size_t i = 0; i < f->n_removed; i++) b->by_id[f->removed[i]].at = NULL;
    if (f->n_removed > 0) {
        remove_gone(b->moving);
        remove_gone(b->resting);
    }
    for (size_t i = 0; i < f->n_added; i++) {
        const change &c = f->added[i];
        box added = {&c, c.id, c.is_static != 0};
        b->by_id[c.id] = added;
        (c.is_static ? b->resting : b->moving).push_back(&b->by_id[c.id]);
    }
    for (size_t i = 0; i < f->n_moved; i++) b->by_id[f->moved[i].id].at = &f->moved[i];
    b->pairs.clear();
    auto found = [b](const box *p, const box *q) { b->pairs.push_back(id_pair{p->number, q->number}); };
    typedef CGAL::Box_intersection_d::Box_traits_d<box *> traits;
    CGAL::box_self_intersection_d(b->moving.begin(), b->moving.end(), found, traits(), cutoff, closed);
    CGAL::box_intersection_d(b->moving.begin(), b->moving.end(), b->resting.begin(), b->resting.end(), found,
                             traits(), cutoff, closed);
}

size_t pairs(void *state, id_pair *out, size_t room)
{
    const boxes *b = (const boxes *)state;
    if (!b->pairs.empty() && b->pairs.size() <= room)
        std::memcpy(out, b->pairs.data(), b->pairs.size() * sizeof *out);
    return b->pairs.size();
}

} // namespace

extern const mode modes[] = {
    {"CGAL", 0, open, step, pairs},
    {NULL, 0, NULL, NULL, NULL},
};
