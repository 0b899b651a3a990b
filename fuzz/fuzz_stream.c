/* Harness: scenes whose events are published over LCM, and two readers that follow the
 * stream with the messages alone: one that gets all, and one that loses some.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The readers do what pair_events_t.lcm says and no more. After every publishing the
 * first has the world's pairs, and the second has them if it says that it is up to
 * date. The input chooses what is lost, which commits are left out, and when snapshots
 * are sent.
 */
#include "scene.h"

#include "msap_pair_events_t.h"
#include "multisap_lcm.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 120, MOST_PAIRS = MOST * (MOST - 1) / 2, PATIENCE = 100000 };

typedef struct pair {
    int64_t a, b;
} pair;

/* The state of commit seq, sorted, and the parts that have come of a message. */
typedef struct reader {
    int64_t seq;
    size_t count, n_deleted, n_created;
    int32_t parts;
    pair pairs[2 * MOST_PAIRS], deleted[MOST_PAIRS], created[MOST_PAIRS];
} reader;

typedef struct stream {
    msap_world *world;
    msap_lcm_publisher *publisher;
    reader sure, unsure;
    uint64_t messages, bytes, losses; /* a bit for each message to come: lost to the unsure reader */
    int is_published, leave_out;
    size_t work;
    herd herd;
    call call;
} stream;

static stream s;
static lcm_t *lcm;

/* ------------------------------------------------------------------ reading */

static int pair_order(const void *p, const void *q)
{
    const pair *x = p, *y = q;
    if (x->a != y->a)
        return x->a < y->a ? -1 : 1;
    return x->b < y->b ? -1 : x->b > y->b;
}

static void append(pair *to, size_t *count, const int64_t *a, const int64_t *b, int32_t n)
{
    int32_t i;
    if (*count + (size_t)n > MOST_PAIRS)
        fuzz_check("a message has more pairs than there can be");
    for (i = 0; i < n; i++) {
        to[*count].a = a[i];
        to[(*count)++].b = b[i];
    }
}

static const pair *find(const reader *r, size_t count, const pair *p)
{
    return bsearch(p, r->pairs, count, sizeof *p, pair_order);
}

/* Takes the deleted pairs away and puts the created ones in that are not there. */
static void change(reader *r)
{
    static char is_gone[2 * MOST_PAIRS];
    size_t i, before = r->count, kept = 0;
    memset(is_gone, 0, before);
    for (i = 0; i < r->n_created; i++)
        if (!find(r, before, &r->created[i])) {
            is_gone[r->count] = 0;
            r->pairs[r->count++] = r->created[i];
        }
    for (i = 0; i < r->n_deleted; i++) {
        const pair *p = find(r, before, &r->deleted[i]);
        if (p)
            is_gone[p - r->pairs] = 1;
    }
    for (i = 0; i < r->count; i++)
        if (!is_gone[i])
            r->pairs[kept++] = r->pairs[i];
    r->count = kept;
    qsort(r->pairs, r->count, sizeof *r->pairs, pair_order);
}

static void is_state(const reader *r, const msap_pair_events_t *m)
{
    uint64_t sum = 0;
    size_t i;
    for (i = 0; i < r->count; i++)
        sum += msap_lcm_pair_hash(r->pairs[i].a, r->pairs[i].b);
    if ((int64_t)r->count != m->pairs || sum != (uint64_t)m->checksum)
        fuzz_check("a reader has another number of pairs, or another checksum, than the message");
}

/* Parts of a message come one after another; if one is missing, all are of no use. */
static void take_part(reader *r, const msap_pair_events_t *m)
{
    if (m->part == 0)
        r->n_deleted = r->n_created = 0;
    r->parts = m->part == 0 ? 1 : r->parts + 1;
    append(r->deleted, &r->n_deleted, m->deleted_a, m->deleted_b, m->n_deleted);
    append(r->created, &r->n_created, m->created_a, m->created_b, m->n_created);
    if (m->part + 1 < m->parts || r->parts != m->parts || m->base > r->seq || r->seq >= m->seq)
        return;
    if (m->kind == MSAP_PAIR_EVENTS_T_SNAPSHOT)
        r->count = 0;
    change(r);
    r->seq = m->seq;
    is_state(r, m);
}

/* What has come of the message and what follows are of no use. */
static void lose_part(reader *r)
{
    r->parts = INT32_MIN / 2;
    r->n_deleted = r->n_created = 0;
}

static void receive(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    msap_pair_events_t m;
    (void)channel;
    (void)user;
    if (msap_lcm_check(buffer->data, buffer->data_size) != MSAP_LCM_OK ||
        msap_pair_events_t_decode(buffer->data, 0, (int)buffer->data_size, &m) != (int)buffer->data_size)
        fuzz_check("a message that was published cannot be read");
    s.messages++;
    s.bytes += buffer->data_size;
    take_part(&s.sure, &m);
    if (s.losses & 1)
        lose_part(&s.unsure);
    else
        take_part(&s.unsure, &m);
    s.losses >>= 1;
    msap_pair_events_t_decode_cleanup(&m);
}

static void has_pairs_of_world(const reader *r)
{
    const msap_pair *pairs;
    size_t count, i;
    msap_pairs(s.world, &pairs, &count);
    if (count != r->count)
        fuzz_check("a reader has another number of pairs than the world");
    for (i = 0; i < count; i++) {
        pair p;
        p.a = (int64_t)pairs[i].a;
        p.b = (int64_t)pairs[i].b;
        if (!find(r, r->count, &p))
            fuzz_check("a reader lacks a pair");
    }
}

/* --------------------------------------------------------------- publishing */

static void deliver(msap_lcm_status status)
{
    uint64_t messages, bytes;
    fuzz_check(status == MSAP_LCM_OK ? NULL : msap_lcm_status_text(status));
    while (lcm_handle_timeout(lcm, 0) > 0)
        continue;
    if (msap_lcm_sent(s.publisher, &messages, &bytes) != MSAP_LCM_OK || messages != s.messages || bytes != s.bytes)
        fuzz_check("other messages came than were sent");
}

static void publish(void)
{
    deliver(msap_lcm_publish(s.publisher, s.world, (int64_t)s.work));
    s.is_published = s.sure.seq > 0;
    has_pairs_of_world(&s.sure);
    if (s.unsure.seq == s.sure.seq)
        has_pairs_of_world(&s.unsure);
}

static void publish_snapshot(void)
{
    msap_lcm_status status = msap_lcm_publish_snapshot(s.publisher, s.world, 7);
    if (status == MSAP_LCM_ERROR_UNPUBLISHED && !s.is_published)
        return;
    deliver(status);
    has_pairs_of_world(&s.sure);
}

static void after_commit(void)
{
    msap_world_stats stats;
    stats.struct_size = sizeof stats;
    msap_stats(s.world, &stats);
    s.work += stats.boxes + stats.touched + stats.pairs;
    s.is_published = 0;
    if (s.leave_out > 0)
        s.leave_out--;
    else
        publish();
}

static void other(uint32_t argument)
{
    switch (argument & 3) {
    case 0: publish_snapshot(); break;
    case 1: s.losses = argument >> 2; break;
    case 2: s.leave_out = argument >> 2 & 3; break;
    default: publish();
    }
}

/* -------------------------------------------------------------------- whole */

static void next_call(void)
{
    if (carry_out(s.world, &s.call, s.call.handles) != MSAP_OK)
        fuzz_check("a call failed");
    herd_follow(&s.herd, &s.call);
    if (s.call.kind == CALL_COMMIT)
        after_commit();
    if (s.call.kind == CALL_OTHER)
        other(s.call.argument);
}

/* Configs that are refused, by one field. */
static void check_refusals(msap_lcm_config config, uint32_t which)
{
    msap_lcm_publisher *publisher = NULL;
    msap_lcm_status expected = MSAP_LCM_ERROR_CONFIG;
    switch (which & 3) {
    case 0: config.url = "memq://"; break;
    case 1: config.channel = which & 4 ? "" : NULL; break;
    case 2: config.channel = "a name that is longer than any channel may have, as LCM counts its bytes: 63"; break;
    default:
        config.struct_size += which;
        expected = MSAP_LCM_ERROR_STRUCT_SIZE;
    }
    if (msap_lcm_create(&config, &publisher) != expected || publisher)
        fuzz_check("a bad config made a publisher, or came to another status");
}

static void begin(input *in)
{
    uint32_t how = (uint32_t)take(in, 1), dims = how & 1 ? 2 : 3;
    msap_config config = take_config(in, dims);
    msap_lcm_config lcm_config;
    memset(&s.sure, 0, offsetof(reader, pairs));
    memset(&s.unsure, 0, offsetof(reader, pairs));
    s.messages = s.bytes = s.losses = s.work = 0;
    s.is_published = s.leave_out = 0;
    herd_begin(&s.herd, dims, MOST);
    if (!lcm && ((lcm = lcm_create("memq://")) == NULL || !lcm_subscribe(lcm, "MSAP_EVENTS", receive, NULL)))
        fuzz_check("LCM has no queue in memory");
    msap_lcm_config_init(&lcm_config, sizeof lcm_config);
    lcm_config.lcm = lcm;
    lcm_config.epoch = 42;
    lcm_config.snapshot_every = how >> 1 & 7;
    check_refusals(lcm_config, how >> 4);
    if (msap_create(&config, &s.world) != MSAP_OK || msap_lcm_create(&lcm_config, &s.publisher) != MSAP_LCM_OK)
        fuzz_check("a world or its publisher cannot be made");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    input in = {data, data + size};
    begin(&in);
    while (s.work < PATIENCE && take_call(&in, &s.herd, &s.call))
        next_call();
    s.leave_out = 0;
    s.call.kind = CALL_COMMIT;
    next_call();
    msap_lcm_destroy(s.publisher);
    msap_destroy(s.world);
    return 0;
}
