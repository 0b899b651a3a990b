/* See play.h.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "play.h"

#include <stdlib.h>
#include <string.h>

/* Boxes at once, and how many pairs brute force may test for one input: small, so that
 * many inputs are played in a second. Large scenes are for fuzz_setups.c. */
enum { MOST = 80, PATIENCE = 60000 };

typedef struct player {
    session s;
    herd herd;
    call call;
    uint64_t hash;
    size_t tested;
    int failing, meddling;
} player;

static void hash_word(player *p, uint64_t word)
{
    uint64_t mixed = p->hash ^ word;
    p->hash = random_next(&mixed);
}

/* Whether a call that came to `status` was made to fail and is to be made again, with
 * memory back; it must have changed nothing. */
static int again(player *p, msap_status status)
{
    session *s = &p->s;
    if (status != MSAP_ERROR_MEMORY || s->failures == s->memory.failures)
        return 0;
    s->failures = s->memory.failures;
    s->memory.fail_from = s->memory.limit = 0;
    fuzz_check(session_compare(s));
    return 1;
}

static void succeeded(msap_status status, const char *call)
{
    if (status != MSAP_OK)
        fuzz_check(call);
}

/* ------------------------------------------------------------------ changes */

static void give_data(player *p)
{
    size_t i;
    for (i = 0; i < p->call.k; i++)
        p->call.data[i] = (void *)p->s.next_tag++;
}

static void follow_additions(player *p)
{
    call *c = &p->call;
    size_t i;
    for (i = 0; i < c->k; i++) {
        if (c->handles[i] != reference_add(&p->s.reference, &c->bounds[i], c->flags[i], c->data[i]))
            fuzz_check("an addition gave another handle than the contract says");
        hash_word(p, c->handles[i]);
    }
}

static void add(player *p)
{
    call *c = &p->call;
    msap_status status = MSAP_OK;
    give_data(p);
    do
        if (c->k > 0)
            status = msap_add(p->s.world, c->min, c->max, c->flags[0], c->data[0], c->handles);
    while (again(p, status));
    succeeded(status, "msap_add failed");
    follow_additions(p);
}

static void add_many(player *p)
{
    call *c = &p->call;
    msap_status status;
    give_data(p);
    do
        status = msap_add_many(p->s.world, c->k, &c->boxes, c->flags, c->data, c->handles);
    while (again(p, status));
    succeeded(status, "msap_add_many failed");
    follow_additions(p);
}

static void update(player *p)
{
    call *c = &p->call;
    size_t i;
    if (c->kind == CALL_UPDATE_MANY)
        succeeded(msap_update_many(p->s.world, c->k, c->handles, &c->boxes), "msap_update_many failed");
    else if (c->k > 0)
        succeeded(msap_update(p->s.world, c->handles[0], c->min, c->max), "msap_update failed");
    for (i = 0; i < c->k; i++)
        reference_update(&p->s.reference, c->handles[i], &c->bounds[i]);
}

static void remove_boxes(player *p)
{
    call *c = &p->call;
    size_t i;
    if (c->kind == CALL_REMOVE_MANY)
        succeeded(msap_remove_many(p->s.world, c->k, c->handles), "msap_remove_many failed");
    else if (c->k > 0)
        succeeded(msap_remove(p->s.world, c->handles[0]), "msap_remove failed");
    for (i = 0; i < c->k; i++)
        reference_remove(&p->s.reference, c->handles[i]);
}

/* The reference takes the library's word for the new bounds: fuzz_bounds.c checks them. */
static void shift(player *p)
{
    size_t i;
    succeeded(msap_shift_origin(p->s.world, p->call.offset), "msap_shift_origin failed");
    for (i = 0; i < p->herd.count; i++) {
        struct member *m = &p->herd.live[i];
        succeeded(msap_get_bounds(p->s.world, m->handle, m->bounds.min, m->bounds.max), "msap_get_bounds failed");
        reference_update(&p->s.reference, m->handle, &m->bounds);
    }
}

/* ------------------------------------------------------------------- commit */

static void *tag_pair(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    const player *p = context;
    (void)data_a;
    (void)data_b;
    return pair_tag(a, b, p->s.reference.commits + 1);
}

/* The first few callbacks of a commit make a call. */
static void meddle(player *p, msap_handle a, msap_handle b)
{
    if (p->meddling == 0)
        return;
    p->meddling--;
    call_inside(&p->s, a, b, p->call.argument + p->meddling);
}

static void *meddle_and_tag(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b)
{
    meddle(context, a, b);
    return tag_pair(context, a, b, data_a, data_b);
}

static void only_meddle(void *context, msap_handle a, msap_handle b, void *data_a, void *data_b, void *pair_data)
{
    (void)data_a;
    (void)data_b;
    (void)pair_data;
    meddle(context, a, b);
}

/* Without a look at the callbacks' order: the events are read as arrays. */
static void commit_for_arrays(player *p)
{
    msap_callbacks callbacks = {sizeof callbacks, 0, NULL, tag_pair, NULL};
    msap_status status;
    callbacks.context = p;
    p->meddling = p->call.argument & 4 ? 2 : 0;
    if (p->meddling) {
        callbacks.on_create = meddle_and_tag;
        callbacks.on_delete = only_meddle;
    }
    do
        status = msap_commit(p->s.world, &callbacks, NULL);
    while (again(p, status));
    succeeded(status, "msap_commit failed");
    reference_commit(&p->s.reference);
}

/* Without callbacks: the pairs get their user data afterwards. */
static void commit_without_callbacks(player *p)
{
    const msap_pair *created;
    size_t count, i;
    msap_status status;
    do
        status = msap_commit(p->s.world, NULL, NULL);
    while (again(p, status));
    succeeded(status, "msap_commit failed");
    reference_commit(&p->s.reference);
    succeeded(msap_created(p->s.world, &created, &count), "msap_created failed");
    for (i = 0; i < count; i++) {
        void *tag = pair_tag(created[i].a, created[i].b, p->s.reference.commits);
        succeeded(msap_set_pair_data(p->s.world, 1, &created[i].b, &created[i].a, &tag),
                  "msap_set_pair_data failed");
    }
}

static void hash_pairs(player *p, msap_status (*read)(const msap_world *, const msap_pair **, size_t *))
{
    const msap_pair *pairs;
    size_t count, i;
    succeeded(read(p->s.world, &pairs, &count), "an array could not be read");
    hash_word(p, count);
    for (i = 0; i < count; i++) {
        hash_word(p, pairs[i].a);
        hash_word(p, pairs[i].b);
    }
}

static void commit(player *p)
{
    msap_world_stats stats;
    if (p->s.memory.limit || p->call.argument % 4 == 1)
        commit_for_arrays(p);
    else if (p->call.argument % 4 == 2)
        commit_without_callbacks(p);
    else
        fuzz_check(session_commit(&p->s));
    hash_pairs(p, msap_deleted);
    hash_pairs(p, msap_created);
    hash_pairs(p, msap_pairs);
    stats.struct_size = sizeof stats;
    succeeded(msap_stats(p->s.world, &stats), "msap_stats failed");
    hash_word(p, stats.allocations ^ stats.bytes << 32);
    p->tested += p->s.reference.slot_count * p->s.reference.slot_count / 2;
}

/* ---------------------------------------------------------------- user data */

/* Of some boxes in a row. */
static void exchange_box_data(player *p)
{
    call *c = &p->call;
    size_t first = c->argument % p->herd.count, i;
    void *back[MOST];
    c->k = 1 + (c->argument >> 8) % (p->herd.count - first);
    give_data(p);
    for (i = 0; i < c->k; i++)
        c->handles[i] = p->herd.live[first + i].handle;
    succeeded(msap_set_user_data(p->s.world, c->k, c->handles, c->data), "msap_set_user_data failed");
    succeeded(msap_get_user_data(p->s.world, c->k, c->handles, back), "msap_get_user_data failed");
    for (i = 0; i < c->k; i++)
        reference_slot(&p->s.reference, c->handles[i])->data = c->data[i];
    if (memcmp(c->data, back, c->k * sizeof *back) != 0)
        fuzz_check("a box has other user data than it was given");
}

/* Of some pairs in a row, named backwards. */
static void exchange_pair_data(player *p)
{
    call *c = &p->call;
    size_t count = p->s.reference.pair_count, first = c->argument % count, i;
    msap_pair *pairs = &p->s.reference.pairs[first];
    msap_handle others[MOST];
    void *back[MOST];
    c->k = 1 + (c->argument >> 8) % (count - first < MOST ? count - first : MOST);
    for (i = 0; i < c->k; i++) {
        c->handles[i] = pairs[i].b;
        others[i] = pairs[i].a;
    }
    succeeded(msap_get_pair_data(p->s.world, c->k, c->handles, others, back), "msap_get_pair_data failed");
    give_data(p);
    for (i = 0; i < c->k; i++) {
        if (back[i] != pairs[i].user_data)
            fuzz_check("a pair has other user data than it was given");
        pairs[i].user_data = c->data[i];
    }
    succeeded(msap_set_pair_data(p->s.world, c->k, others, c->handles, c->data), "msap_set_pair_data failed");
}

static void exchange_data(player *p)
{
    if (p->herd.count > 0 && (p->call.argument & 1))
        exchange_box_data(p);
    /* the events show what a pair had when it was created, so only pairs that are older are changed */
    if (p->s.reference.pair_count > 0 && p->s.reference.event_count == 0)
        exchange_pair_data(p);
}

/* ----------------------------------------------------------------- failures */

static void plan_failure(player *p)
{
    tracker *m = &p->s.memory;
    uint32_t n = p->call.argument >> 2;
    switch (p->call.argument % 4) {
    case 0: m->fail_at = m->calls + 1 + n % 32; break;
    case 1: m->fail_from = m->calls + 1 + n % 32; break;
    case 2: m->limit = m->bytes + 1 + n; break;
    default: m->limit = m->bytes + 1 + 16 * n; break;
    }
}

/* -------------------------------------------------------------------- whole */

static void next_call(player *p)
{
    switch (p->call.kind) {
    case CALL_ADD: add(p); break;
    case CALL_ADD_MANY: add_many(p); break;
    case CALL_UPDATE:
    case CALL_UPDATE_MANY: update(p); break;
    case CALL_REMOVE:
    case CALL_REMOVE_MANY: remove_boxes(p); break;
    case CALL_SHIFT: shift(p); break;
    case CALL_TRIM: fuzz_check(session_trim(&p->s)); break;
    case CALL_COMMIT: commit(p); break;
    case CALL_DATA: exchange_data(p); break;
    case CALL_WRONG: wrong_call(&p->s, &p->herd, &p->call); break;
    case CALL_OTHER:
        if (p->failing)
            plan_failure(p);
        break;
    }
    herd_follow(&p->herd, &p->call);
    if (p->call.kind == CALL_COMMIT || p->call.kind == CALL_TRIM || p->call.kind == CALL_WRONG)
        fuzz_check(session_compare(&p->s));
}

uint64_t play(const uint8_t *data, size_t size, int failing)
{
    static player p;
    input in = {data, data + size};
    msap_config config = take_config(&in, take(&in, 1) & 1 ? 2 : 3);
    config.max_boxes = BOX_LIMIT(MOST);
    p.failing = failing;
    p.hash = p.tested = 0;
    herd_begin(&p.herd, config.dims, MOST);
    fuzz_check(session_open(&p.s, &config, 1, SCENE_GRID));
    while (p.tested < PATIENCE && take_call(&in, &p.herd, &p.call))
        next_call(&p);
    p.call.argument = 0;
    p.s.memory.limit = 0;
    commit(&p);
    fuzz_check(session_compare(&p.s));
    fuzz_check(session_close(&p.s));
    return p.hash;
}
