/* The claim about static boxes (II.2c): they are put into all cells that they touch,
 * or into a structure of their own, a tree. In between: into cells of a size that
 * suits them, on several levels, as the library does.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Measured is what a box that moves must ask in each frame: which static boxes it
 * overlaps. (The library asks less often, by its skins.) The cells are squares of a
 * grid over the floor; the static boxes of a cell stand in one array, cell by cell. */
#include "scene.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LEVELS = 6, FEW = 8, CELL = 2 };

/* A scene whose boxes move among static ones. */
struct place {
    const scene *movers;
    const aabb *fixed;
    uint32_t n;
};

/* --------------------------------------------------------------------- grid */

struct level {
    double width;    /* of a cell */
    int32_t count;   /* cells in a row, and rows */
    uint32_t *first; /* [cells + 1] where each cell begins in `box` */
    uint32_t *box;
};

struct grid {
    const struct place *place;
    struct level level[LEVELS];
    uint8_t *level_of; /* of each static box */
    int levels;
};

/* Cells from low to high, on both axes. */
struct span {
    int32_t low[2], high[2];
};

static int32_t cell_of(const struct level *l, float at)
{
    double cell = at / l->width;
    return cell < 0 ? 0 : cell >= l->count ? l->count - 1 : (int32_t)cell;
}

static struct span span_of(const struct level *l, const aabb *b)
{
    struct span s;
    for (int k = 0; k < 2; k++) {
        s.low[k] = cell_of(l, b->min[k]);
        s.high[k] = cell_of(l, b->max[k]);
    }
    return s;
}

static int64_t cells_in(struct span s) { return (int64_t)(s.high[0] - s.low[0] + 1) * (s.high[1] - s.low[1] + 1); }

/* Counts the boxes of each cell in first[cell + 1] (pass 0), or writes them (pass 1),
 * by which first[cell] becomes the end of the cell. */
static void enter(struct grid *g, int level, int pass)
{
    struct level *l = &g->level[level];
    for (uint32_t i = 0; i < g->place->n; i++) {
        struct span s = span_of(l, &g->place->fixed[i]);
        if (g->level_of[i] != level) continue;
        for (int32_t y = s.low[1]; y <= s.high[1]; y++)
            for (int32_t x = s.low[0]; x <= s.high[0]; x++) {
                uint32_t *first = &l->first[y * l->count + x];
                if (pass == 0) first[1]++;
                else l->box[(*first)++] = i;
            }
    }
}

static void fill_level(struct grid *g, int level)
{
    struct level *l = &g->level[level];
    size_t cells = (size_t)l->count * (size_t)l->count;
    l->first = get(cells + 1, sizeof *l->first);
    enter(g, level, 0);
    for (size_t i = 1; i <= cells; i++) l->first[i] += l->first[i - 1];
    l->box = get(l->first[cells], sizeof *l->box);
    enter(g, level, 1);
    memmove(l->first + 1, l->first, cells * sizeof *l->first);
    l->first[0] = 0;
}

/* A grid of 1 level, or of LEVELS, where a box goes to the first on which it touches
 * few cells, or to the last. */
static struct grid grid_make(const struct place *p, int levels)
{
    struct grid g = {p, {{0, 0, NULL, NULL}}, get(p->n, 1), levels};
    double width = CELL;
    for (int i = 0; i < levels; i++, width *= 4) {
        g.level[i].width = width;
        g.level[i].count = (int32_t)(p->movers->side / width) + 1;
    }
    for (uint32_t i = 0; i < p->n; i++)
        while (g.level_of[i] < levels - 1 && cells_in(span_of(&g.level[g.level_of[i]], &p->fixed[i])) > FEW)
            g.level_of[i]++;
    for (int i = 0; i < levels; i++) fill_level(&g, i);
    return g;
}

static void grid_free(struct grid *g)
{
    for (int i = 0; i < g->levels; i++) {
        free(g->level[i].first);
        free(g->level[i].box);
    }
    free(g->level_of);
}

static uint32_t entries_on(const struct level *l) { return l->first[l->count * l->count]; }

/* Whether a cell is the one in which two boxes count: the highest of those in which
 * either of them begins. */
static int is_theirs(const struct level *l, int32_t x, int32_t y, const aabb *a, const aabb *b)
{
    int32_t ax = cell_of(l, a->min[0]), bx = cell_of(l, b->min[0]);
    int32_t ay = cell_of(l, a->min[1]), by = cell_of(l, b->min[1]);
    return x == (ax > bx ? ax : bx) && y == (ay > by ? ay : by);
}

static uint64_t ask_cell(const struct grid *g, const struct level *l, int32_t x, int32_t y, uint32_t self,
                         const aabb *box)
{
    size_t cell = (size_t)y * (size_t)l->count + (size_t)x;
    uint64_t check = 0;
    for (uint32_t i = l->first[cell]; i < l->first[cell + 1]; i++) {
        const aabb *fixed = &g->place->fixed[l->box[i]];
        if (aabb_overlap(box, fixed) && is_theirs(l, x, y, box, fixed))
            check += pair_check(self, UINT32_MAX - l->box[i]);
    }
    return check;
}

static uint64_t ask_grid(const void *grid, uint32_t self, const aabb *box)
{
    const struct grid *g = grid;
    uint64_t check = 0;
    for (int i = 0; i < g->levels; i++) {
        if (entries_on(&g->level[i]) == 0) continue;
        struct span s = span_of(&g->level[i], box);
        for (int32_t y = s.low[1]; y <= s.high[1]; y++)
            for (int32_t x = s.low[0]; x <= s.high[0]; x++) check += ask_cell(g, &g->level[i], x, y, self, box);
    }
    return check;
}

/* --------------------------------------------------------------------- tree */

/* A tree of boxes, halved at the middle one of the longest axis; in an array, each
 * node before its two halves. */
struct node {
    aabb around;
    uint32_t first, n; /* a leaf's boxes */
    uint32_t second;   /* a fork's second half; 0: a leaf */
};

struct tree {
    const struct place *place;
    uint32_t *box; /* in the order of the leaves */
    struct node *node;
    uint32_t nodes;
};

struct centre {
    float at;
    uint32_t box;
};

static int by_centre(const void *a, const void *b)
{
    float x = ((const struct centre *)a)->at, y = ((const struct centre *)b)->at;
    return (x > y) - (x < y);
}

static aabb around(const struct tree *t, uint32_t first, uint32_t n)
{
    aabb all = t->place->fixed[t->box[first]];
    for (uint32_t i = 1; i < n; i++) {
        const aabb *b = &t->place->fixed[t->box[first + i]];
        for (int k = 0; k < 3; k++) {
            all.min[k] = b->min[k] < all.min[k] ? b->min[k] : all.min[k];
            all.max[k] = b->max[k] > all.max[k] ? b->max[k] : all.max[k];
        }
    }
    return all;
}

static void sort_by_centre(struct tree *t, uint32_t first, uint32_t n, const aabb *all)
{
    struct centre *centre = get(n, sizeof *centre);
    int axis = 0;
    for (int k = 1; k < 3; k++) axis = all->max[k] - all->min[k] > all->max[axis] - all->min[axis] ? k : axis;
    for (uint32_t i = 0; i < n; i++) {
        const aabb *b = &t->place->fixed[t->box[first + i]];
        centre[i].at = b->min[axis] / 2 + b->max[axis] / 2;
        centre[i].box = t->box[first + i];
    }
    qsort(centre, n, sizeof *centre, by_centre);
    for (uint32_t i = 0; i < n; i++) t->box[first + i] = centre[i].box;
    free(centre);
}

static uint32_t build(struct tree *t, uint32_t first, uint32_t n)
{
    enum { LEAF = 4 };
    uint32_t self = t->nodes++;
    struct node node = {around(t, first, n), first, n, 0};
    if (n > LEAF) {
        sort_by_centre(t, first, n, &node.around);
        build(t, first, n / 2);
        node.second = build(t, first + n / 2, n - n / 2);
    }
    t->node[self] = node;
    return self;
}

static struct tree tree_make(const struct place *p)
{
    struct tree t = {p, get(p->n, sizeof *t.box), get(2 * (size_t)p->n, sizeof *t.node), 0};
    for (uint32_t i = 0; i < p->n; i++) t.box[i] = i;
    build(&t, 0, p->n);
    return t;
}

static void tree_free(struct tree *t)
{
    free(t->box);
    free(t->node);
}

static uint64_t ask_leaf(const struct tree *t, const struct node *leaf, uint32_t self, const aabb *box)
{
    uint64_t check = 0;
    for (uint32_t i = leaf->first; i < leaf->first + leaf->n; i++)
        if (aabb_overlap(box, &t->place->fixed[t->box[i]])) check += pair_check(self, UINT32_MAX - t->box[i]);
    return check;
}

static uint64_t ask_tree(const void *tree, uint32_t self, const aabb *box)
{
    const struct tree *t = tree;
    uint32_t wait[64], waiting = 1;
    uint64_t check = 0;
    wait[0] = 0;
    while (waiting > 0) {
        uint32_t at = wait[--waiting];
        const struct node *n = &t->node[at];
        if (!aabb_overlap(box, &n->around)) continue;
        if (n->second == 0) {
            check += ask_leaf(t, n, self, box);
            continue;
        }
        wait[waiting++] = n->second;
        wait[waiting++] = at + 1;
    }
    return check;
}

/* ---------------------------------------------------------------- the claim */

static outcome ask_for_all(const struct place *p, const void *structure,
                           uint64_t (*ask)(const void *structure, uint32_t self, const aabb *box))
{
    const scene *s = p->movers;
    outcome o = {0, 0};
    double start = clock_ms();
    for (size_t i = 0; i < (size_t)s->frames * s->movers; i++)
        o.check += ask(structure, s->moves[i].box, &s->moves[i].to);
    o.ms = (clock_ms() - start) / s->frames;
    return o;
}

static outcome with_grid(const struct place *p, int levels)
{
    struct grid g = grid_make(p, levels);
    outcome o = ask_for_all(p, &g, ask_grid);
    grid_free(&g);
    return o;
}

static outcome in_all_cells(const void *place) { return with_grid(place, 1); }
static outcome on_levels(const void *place) { return with_grid(place, LEVELS); }

static outcome in_a_tree(const void *place)
{
    struct tree t = tree_make(place);
    outcome o = ask_for_all(place, &t, ask_tree);
    tree_free(&t);
    return o;
}

static outcome build_all_cells(const void *place)
{
    outcome o = {0, 0};
    double start = clock_ms();
    struct grid g = grid_make(place, 1);
    o.ms = clock_ms() - start;
    grid_free(&g);
    return o;
}

static outcome build_levels(const void *place)
{
    outcome o = {0, 0};
    double start = clock_ms();
    struct grid g = grid_make(place, LEVELS);
    o.ms = clock_ms() - start;
    grid_free(&g);
    return o;
}

static outcome build_tree(const void *place)
{
    outcome o = {0, 0};
    double start = clock_ms();
    struct tree t = tree_make(place);
    o.ms = clock_ms() - start;
    tree_free(&t);
    return o;
}

static void count_entries(const struct place *p, const char *name, int levels, const char *what)
{
    struct grid g = grid_make(p, levels);
    double entries = 0;
    for (int i = 0; i < levels; i++) entries += entries_on(&g.level[i]);
    print_count("statics", name, what, entries / p->n);
    grid_free(&g);
}

/* The first of them cover the map, the next are walls across it. */
static void compare_places(const scene *movers, const aabb *small, uint32_t covers, uint32_t walls,
                           const char *name)
{
    aabb *fixed = scene_end(movers);
    float side = (float)movers->side;
    struct place p = {movers, fixed, movers->boxes};
    const way ways[] = {
        {"in all cells", in_all_cells, &p}, {"on levels", on_levels, &p}, {"in a tree", in_a_tree, &p}};
    const way builds[] = {
        {"in all cells", build_all_cells, &p}, {"on levels", build_levels, &p}, {"in a tree", build_tree, &p}};
    memcpy(fixed, small, p.n * sizeof *fixed);
    for (uint32_t i = 0; i < covers + walls; i++) {
        fixed[i].min[0] = i < covers ? -1e30f : 0;
        fixed[i].max[0] = i < covers ? 1e30f : side;
        fixed[i].min[1] = i < covers ? -1e30f : fixed[i].min[1];
        fixed[i].max[1] = i < covers ? 1e30f : fixed[i].max[1];
    }
    compare("statics", name, ways, 3, 9, NULL);
    compare("statics-build", name, builds, 3, 5, NULL);
    count_entries(&p, name, 1, "entries a box, in all cells");
    count_entries(&p, name, LEVELS, "entries a box, on levels");
    free(fixed);
}

void claim_statics(void)
{
    static const recipe moving = {"", 10000, 4, 1, 1, 0.05, STRAIGHT, 1, 0};
    static const recipe fixed = {"", 10000, 1, 1, 1, 0.05, JUMPING, 1, 0};
    scene movers = scene_make(&moving), small = scene_make(&fixed);
    aabb *boxes = scene_end(&small);
    compare_places(&movers, boxes, 0, 0, "10,000 small ones");
    compare_places(&movers, boxes, 1, 0, "and 1 over the map");
    compare_places(&movers, boxes, 1, 100, "and 100 walls across it");
    compare_places(&movers, boxes, 20, 0, "and 20 over the map");
    free(boxes);
    scene_free(&movers);
    scene_free(&small);
}
