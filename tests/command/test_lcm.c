/* libmultisap-lcm: what is published, and whether a reader can follow it.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Messages are received in this process through LCM's memory queue, checked, decoded
 * by lcm-gen's code and given to a follower, which does what pair_events_t.lcm says
 * and no more, with a set of pairs of its own. */
#define _POSIX_C_SOURCE 200809L
#include "msap_pair_events_t.h"

#include <check.h>
#include <multisap_lcm.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HEAD = 76, FIT = (60000 - HEAD) / 16, MAX_MESSAGES = 64, MAX_PAIRS = 40000 };

/* ------------------------------------------------------------ what comes in */

struct received {
    uint8_t *data;
    uint32_t size;
    msap_pair_events_t message;
};

static lcm_t *lcm;
static msap_world *world;
static msap_lcm_publisher *publisher;
static struct received received[MAX_MESSAGES];
static int n_received;

static void on_message(const lcm_recv_buf_t *buffer, const char *channel, void *user)
{
    struct received *r = &received[n_received++];
    ck_assert_int_le(n_received, MAX_MESSAGES);
    ck_assert_str_eq(channel, "MSAP_EVENTS");
    ck_assert_ptr_null(user);
    ck_assert_int_eq(msap_lcm_check(buffer->data, buffer->data_size), MSAP_LCM_OK);
    r->size = buffer->data_size;
    r->data = malloc(r->size);
    memcpy(r->data, buffer->data, r->size);
    ck_assert_int_eq(msap_pair_events_t_decode(r->data, 0, (int)r->size, &r->message), (int)r->size);
}

static void forget_messages(void)
{
    while (n_received > 0) {
        struct received *r = &received[--n_received];
        msap_pair_events_t_decode_cleanup(&r->message);
        free(r->data);
    }
}

/* Receives what has been published since the last time; returns how many messages. */
static int receive(void)
{
    forget_messages();
    while (lcm_handle_timeout(lcm, 0) > 0)
        continue;
    return n_received;
}

static void create_publisher(uint32_t snapshot_every)
{
    msap_lcm_config config;
    ck_assert_int_eq(msap_lcm_config_init(&config, sizeof config), MSAP_LCM_OK);
    config.lcm = lcm;
    config.epoch = 42;
    config.snapshot_every = snapshot_every;
    ck_assert_int_eq(msap_lcm_create(&config, &publisher), MSAP_LCM_OK);
}

static void setup(void)
{
    lcm = lcm_create("memq://");
    ck_assert_ptr_nonnull(lcm);
    lcm_subscription_set_queue_capacity(lcm_subscribe(lcm, "MSAP_EVENTS", on_message, NULL), 0);
    ck_assert_int_eq(msap_create(NULL, &world), MSAP_OK);
    create_publisher(0);
}

static void teardown(void)
{
    forget_messages();
    msap_lcm_destroy(publisher);
    msap_destroy(world);
    lcm_destroy(lcm);
}

/* ------------------------------------------------------------------- scenes */

static msap_handle add_at(float x)
{
    const float min[3] = {x, 0, 0}, max[3] = {x + 1, 1, 1};
    msap_handle box;
    ck_assert_int_eq(msap_add(world, min, max, 0, NULL, &box), MSAP_OK);
    return box;
}

static void move_to(msap_handle box, float x)
{
    const float min[3] = {x, 0, 0}, max[3] = {x + 1, 1, 1};
    ck_assert_int_eq(msap_update(world, box, min, max), MSAP_OK);
}

static void commit(void)
{
    ck_assert_int_eq(msap_commit(world, NULL, NULL), MSAP_OK);
}

static void publish(int64_t utime)
{
    ck_assert_int_eq(msap_lcm_publish(publisher, world, utime), MSAP_LCM_OK);
}

static void commit_and_publish(int64_t utime)
{
    commit();
    publish(utime);
}

/* n boxes in one place: n * (n - 1) / 2 pairs. */
static void add_crowd(msap_handle *boxes, int n)
{
    for (int i = 0; i < n; i++)
        boxes[i] = add_at(0);
}

static void scatter(const msap_handle *boxes, int n)
{
    for (int i = 0; i < n; i++)
        move_to(boxes[i], (float)(10 * i + 10));
}

/* ----------------------------------------------------------------- follower */

struct pair {
    int64_t a, b;
};

/* A reader of one epoch: the set of pairs that is the state of commit `seq`. */
struct follower {
    int64_t seq;
    int n;
    struct pair pairs[MAX_PAIRS];
};

static int find(const struct follower *f, int64_t a, int64_t b)
{
    for (int i = 0; i < f->n; i++)
        if (f->pairs[i].a == a && f->pairs[i].b == b)
            return i;
    return -1;
}

static void apply(struct follower *f, const msap_pair_events_t *m)
{
    for (int32_t i = 0; i < m->n_deleted; i++) {
        int at = find(f, m->deleted_a[i], m->deleted_b[i]);
        if (at >= 0)
            f->pairs[at] = f->pairs[--f->n];
    }
    for (int32_t i = 0; i < m->n_created; i++)
        if (find(f, m->created_a[i], m->created_b[i]) < 0)
            f->pairs[f->n++] = (struct pair){m->created_a[i], m->created_b[i]};
}

static uint64_t mix(uint64_t x)
{
    x += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

static uint64_t checksum_of(const struct follower *f)
{
    uint64_t sum = 0;
    for (int i = 0; i < f->n; i++)
        sum += mix(mix((uint64_t)f->pairs[i].a) ^ (uint64_t)f->pairs[i].b);
    return sum;
}

/* Takes the message that begins at received[first] with all its parts; returns how many. */
static int follow(struct follower *f, int first)
{
    const msap_pair_events_t *m = &received[first].message;
    if (m->base <= f->seq && f->seq < m->seq) {
        if (m->kind == MSAP_PAIR_EVENTS_T_SNAPSHOT)
            f->n = 0;
        for (int part = 0; part < m->parts; part++) {
            ck_assert_int_eq(m[0].seq, received[first + part].message.seq);
            ck_assert_int_eq(part, received[first + part].message.part);
            apply(f, &received[first + part].message);
        }
        f->seq = m->seq;
        ck_assert_int_eq(f->n, m->pairs);
        ck_assert_uint_eq(checksum_of(f), (uint64_t)m->checksum);
    }
    return m->parts;
}

static void follow_all(struct follower *f)
{
    for (int at = 0; at < n_received;)
        at += follow(f, at);
}

static void check_follows_world(const struct follower *f)
{
    const msap_pair *pairs;
    size_t n;
    msap_pairs(world, &pairs, &n);
    ck_assert_uint_eq(n, f->n);
    for (size_t i = 0; i < n; i++)
        ck_assert_int_ge(find(f, (int64_t)pairs[i].a, (int64_t)pairs[i].b), 0);
}

static struct follower follower, late;

static void setup_followers(void)
{
    setup();
    follower.seq = late.seq = follower.n = late.n = 0;
}

/* -------------------------------------------------------------------- tests */

START_TEST(test_a_commit_is_one_message_with_its_events)
{
    msap_handle a = add_at(0), b = add_at(0.5f), c = add_at(1);
    commit_and_publish(1000);
    ck_assert_int_eq(receive(), 1);
    const msap_pair_events_t *m = &received[0].message;
    ck_assert_int_eq(m->utime, 1000);
    ck_assert_int_eq(m->epoch, 42);
    ck_assert_int_eq(m->seq, 1);
    ck_assert_int_eq(m->base, 0);
    ck_assert_int_eq(m->kind, MSAP_PAIR_EVENTS_T_EVENTS);
    ck_assert_int_eq(m->part, 0);
    ck_assert_int_eq(m->parts, 1);
    ck_assert_int_eq(m->pairs, 3);
    ck_assert_int_eq(m->n_deleted, 0);
    ck_assert_int_eq(m->n_created, 3);
    const msap_handle lower[] = {a, a, b}, higher[] = {b, c, c};
    for (int i = 0; i < 3; i++) {
        ck_assert_uint_eq(m->created_a[i], lower[i]);
        ck_assert_uint_eq(m->created_b[i], higher[i]);
    }

    move_to(c, 1.25f);
    commit_and_publish(2000);
    ck_assert_int_eq(receive(), 1);
    ck_assert_int_eq(m->seq, 2);
    ck_assert_int_eq(m->base, 1);
    ck_assert_int_eq(m->pairs, 2);
    ck_assert_int_eq(m->n_created, 0);
    ck_assert_int_eq(m->n_deleted, 1);
    ck_assert_uint_eq(m->deleted_a[0], a);
    ck_assert_uint_eq(m->deleted_b[0], c);
}
END_TEST

START_TEST(test_the_checksum_is_the_one_described)
{
    /* two boxes: handles 1 and 1 << 32 | 1; the sum worked out with Python's integers */
    add_at(0);
    add_at(0);
    commit_and_publish(0);
    receive();
    ck_assert_uint_eq((uint64_t)received[0].message.checksum, UINT64_C(0x9f55f71ae74e3997));
    ck_assert_uint_eq(msap_lcm_pair_hash(1, INT64_C(0x100000001)), UINT64_C(0x9f55f71ae74e3997));
}
END_TEST

START_TEST(test_an_empty_commit_is_a_message)
{
    commit_and_publish(5);
    commit_and_publish(6);
    ck_assert_int_eq(receive(), 2);
    ck_assert_uint_eq(received[1].size, HEAD);
    ck_assert_int_eq(received[1].message.seq, 2);
    ck_assert_int_eq(received[1].message.pairs, 0);
    ck_assert_int_eq(received[1].message.checksum, 0);
}
END_TEST

START_TEST(test_without_a_commit_nothing_is_sent)
{
    publish(1);
    ck_assert_int_eq(receive(), 0);
    commit_and_publish(2);
    publish(3);
    ck_assert_int_eq(receive(), 1);
}
END_TEST

START_TEST(test_many_events_go_out_in_parts)
{
    static msap_handle boxes[130], more[130];
    add_crowd(boxes, 130);
    commit_and_publish(0);
    ck_assert_int_eq(receive(), 3);
    follow_all(&follower);
    ck_assert_int_eq(follower.n, 8385);
    for (int i = 0; i < 3; i++) {
        ck_assert_uint_le(received[i].size, MSAP_LCM_MESSAGE_MAX);
        ck_assert_int_eq(received[i].message.n_created, i < 2 ? FIT : 8385 - 2 * FIT);
    }

    /* as many deleted as created ones: the middle part has some of both */
    scatter(boxes, 130);
    add_crowd(more, 130);
    commit_and_publish(0);
    ck_assert_int_eq(receive(), 5);
    ck_assert_int_eq(received[2].message.n_deleted, 8385 - 2 * FIT);
    ck_assert_int_eq(received[2].message.n_created, 3 * FIT - 8385);
    ck_assert_uint_eq(received[2].size, HEAD + 16 * FIT);
    follow_all(&follower);
    check_follows_world(&follower);
}
END_TEST

START_TEST(test_events_that_just_fill_a_message_are_one_message)
{
    static msap_handle crowd[86]; /* 3655 pairs; 90 more make 3745 */
    ck_assert_int_eq(FIT, 3745);
    add_crowd(crowd, 86);
    for (int i = 0; i < 90; i++) {
        add_at((float)(10 * i + 10));
        add_at((float)(10 * i + 10));
    }
    commit_and_publish(0);
    ck_assert_int_eq(receive(), 1);
    ck_assert_int_eq(received[0].message.n_created, FIT);
    ck_assert_int_eq(received[0].message.parts, 1);

    msap_lcm_destroy(publisher);
    create_publisher(0);
    add_at(2000);
    add_at(2000);
    commit_and_publish(0); /* an old world in a new stream: all pairs */
    ck_assert_int_eq(receive(), 2);
    ck_assert_int_eq(received[1].message.n_created, 1);
}
END_TEST

START_TEST(test_events_are_sorted_through_all_parts)
{
    static msap_handle boxes[130];
    struct pair before = {0, 0};
    add_crowd(boxes, 130);
    commit_and_publish(0);
    receive();
    for (int i = 0; i < n_received; i++)
        for (int k = 0; k < received[i].message.n_created; k++) {
            struct pair now = {received[i].message.created_a[k], received[i].message.created_b[k]};
            ck_assert(before.a < now.a || (before.a == now.a && before.b < now.b));
            ck_assert(0 < now.a && now.a < now.b);
            before = now;
        }
}
END_TEST

START_TEST(test_snapshots_show_all_pairs_of_the_last_commit)
{
    static msap_handle boxes[130];
    ck_assert_int_eq(msap_lcm_publish_snapshot(publisher, world, 0), MSAP_LCM_ERROR_UNPUBLISHED);
    add_crowd(boxes, 130);
    commit();
    ck_assert_int_eq(msap_lcm_publish_snapshot(publisher, world, 0), MSAP_LCM_ERROR_UNPUBLISHED);
    publish(1);
    ck_assert_int_eq(msap_lcm_publish_snapshot(publisher, world, 7), MSAP_LCM_OK);
    ck_assert_int_eq(receive(), 6);
    const msap_pair_events_t *m = &received[3].message;
    ck_assert_int_eq(m->kind, MSAP_PAIR_EVENTS_T_SNAPSHOT);
    ck_assert_int_eq(m->utime, 7);
    ck_assert_int_eq(m->seq, 1);
    ck_assert_int_eq(m->base, 0);
    ck_assert_int_eq(m->pairs, 8385);
    ck_assert_int_eq(m->checksum, received[0].message.checksum);
    follow(&late, 3);
    check_follows_world(&late);
    commit();
    ck_assert_int_eq(msap_lcm_publish_snapshot(publisher, world, 8), MSAP_LCM_ERROR_UNPUBLISHED);
}
END_TEST

START_TEST(test_snapshots_follow_every_so_many_commits)
{
    msap_lcm_destroy(publisher);
    create_publisher(3);
    for (int i = 0; i < 6; i++)
        commit_and_publish(i);
    ck_assert_int_eq(receive(), 8);
    for (int i = 0; i < 8; i++) {
        ck_assert_int_eq(received[i].message.kind, i == 3 || i == 7);
        ck_assert_int_eq(received[i].message.seq, i < 3 ? i + 1 : i == 7 ? 6 : i);
    }
}
END_TEST

static void check_healed_by_snapshot(int64_t seq)
{
    ck_assert_int_eq(receive(), 1);
    ck_assert_int_eq(received[0].message.kind, MSAP_PAIR_EVENTS_T_SNAPSHOT);
    ck_assert_int_eq(received[0].message.seq, seq);
    follow_all(&follower);
    check_follows_world(&follower);
}

START_TEST(test_a_commit_left_out_is_healed_by_a_snapshot)
{
    msap_handle a = add_at(0), b = add_at(0);
    add_at(0);
    commit_and_publish(0);
    receive();
    follow_all(&follower);
    move_to(a, 5);
    commit();
    move_to(b, 5);
    commit_and_publish(0);
    check_healed_by_snapshot(2);
    move_to(a, 0);
    commit_and_publish(0);
    receive();
    ck_assert_int_eq(received[0].message.kind, MSAP_PAIR_EVENTS_T_EVENTS);
    follow_all(&follower);
    check_follows_world(&follower);
}
END_TEST

START_TEST(test_a_commit_left_out_is_noticed_though_the_number_of_pairs_is_the_same)
{
    msap_handle a = add_at(0), b = add_at(10);
    add_at(0);
    add_at(10);
    move_to(b, 20);
    commit_and_publish(0);
    receive();
    follow_all(&follower);
    move_to(a, 30);
    move_to(b, 10);
    commit();
    commit_and_publish(0);
    check_healed_by_snapshot(2);
}
END_TEST

START_TEST(test_trimmed_events_are_healed_by_a_snapshot)
{
    add_at(0);
    add_at(0);
    commit();
    ck_assert_int_eq(msap_trim(world), MSAP_OK);
    publish(0);
    check_healed_by_snapshot(1);
}
END_TEST

/* As many pairs begin as end, so that only the pairs themselves tell. */
START_TEST(test_trimmed_events_are_noticed_though_the_number_of_pairs_is_the_same)
{
    msap_handle a = add_at(0), b = add_at(10);
    add_at(0);
    add_at(20);
    commit_and_publish(0);
    receive();
    follow_all(&follower);
    move_to(a, 30);
    move_to(b, 20);
    commit();
    ck_assert_int_eq(msap_trim(world), MSAP_OK);
    publish(0);
    check_healed_by_snapshot(2);
}
END_TEST

START_TEST(test_a_world_older_than_the_stream_begins_with_a_snapshot)
{
    add_at(0);
    add_at(0);
    commit();
    commit();
    publish(0);
    check_healed_by_snapshot(1);
}
END_TEST

static uint32_t random_state;

static uint32_t random_below(uint32_t n)
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) % n;
}

/* Moves, adds and removes some of 40 boxes. */
static void change_at_random(msap_handle *boxes)
{
    for (int k = 0; k < 6; k++) {
        msap_handle *box = &boxes[random_below(40)];
        float x = (float)random_below(30);
        if (*box == 0)
            *box = add_at(x);
        else if (random_below(3) > 0)
            move_to(*box, x);
        else {
            ck_assert_int_eq(msap_remove(world, *box), MSAP_OK);
            *box = 0;
        }
    }
}

START_TEST(test_readers_follow_a_random_world_from_the_start_and_late)
{
    static msap_handle boxes[40];
    memset(boxes, 0, sizeof boxes);
    random_state = 1;
    msap_lcm_destroy(publisher);
    create_publisher(10);
    for (int i = 1; i <= 500; i++) {
        change_at_random(boxes);
        commit_and_publish(i);
        receive();
        follow_all(&follower);
        check_follows_world(&follower);
        if (i >= 25 && i % 7 != 0) /* joins late and loses every 7th commit until the next snapshot */
            follow_all(&late);
        if (i >= 30 && i % 10 == 0 && i % 7 != 0)
            check_follows_world(&late);
    }
    ck_assert_int_eq(follower.seq, 500);
}
END_TEST

START_TEST(test_what_was_sent_is_counted)
{
    uint64_t messages = 99, bytes = 99;
    ck_assert_int_eq(msap_lcm_sent(publisher, &messages, &bytes), MSAP_LCM_OK);
    ck_assert_uint_eq(messages, 0);
    ck_assert_uint_eq(bytes, 0);
    add_at(0);
    add_at(0);
    commit_and_publish(0);
    commit_and_publish(0);
    msap_lcm_sent(publisher, &messages, &bytes);
    ck_assert_uint_eq(messages, 2);
    ck_assert_uint_eq(bytes, 2 * HEAD + 16);
}
END_TEST

START_TEST(test_a_message_that_cannot_be_sent_is_an_error_and_the_stream_goes_on)
{
    /* a log that is open for reading takes no messages */
    char path[] = "multisap-XXXXXX", url[64];
    msap_lcm_config config;
    msap_lcm_publisher *writer, *reader;
    int file = mkstemp(path);
    ck_assert_int_ge(file, 0);
    close(file);
    snprintf(url, sizeof url, "file://%s?mode=w", path);
    msap_lcm_config_init(&config, sizeof config);
    config.url = url;
    ck_assert_int_eq(msap_lcm_create(&config, &writer), MSAP_LCM_OK);
    commit();
    ck_assert_int_eq(msap_lcm_publish(writer, world, 0), MSAP_LCM_OK);
    msap_lcm_destroy(writer);

    snprintf(url, sizeof url, "file://%s?mode=r", path);
    ck_assert_int_eq(msap_lcm_create(&config, &reader), MSAP_LCM_OK);
    ck_assert_int_eq(msap_lcm_publish(reader, world, 0), MSAP_LCM_ERROR_SEND);
    ck_assert_int_eq(msap_lcm_publish_snapshot(reader, world, 0), MSAP_LCM_ERROR_SEND);
    uint64_t messages = 1, bytes = 1;
    msap_lcm_sent(reader, &messages, &bytes);
    ck_assert_uint_eq(messages + bytes, 0);
    msap_lcm_destroy(reader);
    ck_assert_int_eq(remove(path), 0);
}
END_TEST

START_TEST(test_live_over_udp_multicast)
{
    lcm_t *sender = lcm_create("udpm://239.255.76.67:17667?ttl=0");
    lcm_t *listener = sender ? lcm_create("udpm://239.255.76.67:17667?ttl=0") : NULL;
    if (!listener) {
        fprintf(stderr, "live_over_udp_multicast: not run, as this machine has no route for multicast\n");
        return;
    }
    lcm_subscribe(listener, "MSAP_EVENTS", on_message, NULL);
    msap_lcm_destroy(publisher);
    lcm_t *memory_queue = lcm;
    lcm = sender;
    create_publisher(0);
    lcm = memory_queue;
    add_at(0);
    add_at(0);
    commit_and_publish(3);
    ck_assert_int_gt(lcm_handle_timeout(listener, 10000), 0); /* it is there at once, or never */
    ck_assert_int_eq(n_received, 1);
    ck_assert_int_eq(received[0].message.pairs, 1);
    lcm_destroy(listener);
    lcm_destroy(sender);
}
END_TEST

/* ------------------------------------------------------------------- errors */

START_TEST(test_null_pointers_are_refused)
{
    msap_lcm_publisher *none = NULL;
    uint64_t n;
    ck_assert_int_eq(msap_lcm_config_init(NULL, sizeof(msap_lcm_config)), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_create(NULL, NULL), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_publish(NULL, world, 0), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_publish(publisher, NULL, 0), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_publish_snapshot(NULL, world, 0), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_publish_snapshot(publisher, NULL, 0), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_sent(none, &n, &n), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_sent(publisher, NULL, &n), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_sent(publisher, &n, NULL), MSAP_LCM_ERROR_NULL);
    ck_assert_int_eq(msap_lcm_check(NULL, 0), MSAP_LCM_ERROR_NULL);
    msap_lcm_destroy(NULL);
}
END_TEST

static msap_lcm_status create_with(lcm_t *with, const char *url, const char *channel)
{
    msap_lcm_config config;
    msap_lcm_publisher *made = NULL;
    msap_lcm_config_init(&config, sizeof config);
    config.lcm = with;
    config.url = url;
    config.channel = channel;
    msap_lcm_status status = msap_lcm_create(&config, &made);
    ck_assert_int_eq(status == MSAP_LCM_OK, made != NULL);
    msap_lcm_destroy(made);
    return status;
}

START_TEST(test_bad_configs_are_refused)
{
    msap_lcm_config config;
    char longest[65] = "";
    memset(longest, 'C', 64);
    ck_assert_int_eq(create_with(lcm, NULL, longest), MSAP_LCM_ERROR_CONFIG);
    longest[63] = '\0';
    ck_assert_int_eq(create_with(lcm, NULL, longest), MSAP_LCM_OK);
    ck_assert_int_eq(create_with(NULL, "memq://", "C"), MSAP_LCM_OK);
    ck_assert_int_eq(create_with(lcm, NULL, ""), MSAP_LCM_ERROR_CONFIG);
    ck_assert_int_eq(create_with(lcm, NULL, NULL), MSAP_LCM_ERROR_CONFIG);
    ck_assert_int_eq(create_with(lcm, "memq://", "C"), MSAP_LCM_ERROR_CONFIG);
    ck_assert_int_eq(create_with(NULL, "nonsense", "C"), MSAP_LCM_ERROR_CONNECT);
    ck_assert_int_eq(msap_lcm_config_init(&config, sizeof config - 1), MSAP_LCM_ERROR_STRUCT_SIZE);
    msap_lcm_config_init(&config, sizeof config);
    config.lcm = lcm;
    config.struct_size++;
    msap_lcm_publisher *made = NULL;
    ck_assert_int_eq(msap_lcm_create(&config, &made), MSAP_LCM_ERROR_STRUCT_SIZE);
    ck_assert_ptr_null(made);
}
END_TEST

START_TEST(test_defaults)
{
    msap_lcm_config config;
    msap_lcm_publisher *one, *two;
    msap_lcm_config_init(&config, sizeof config);
    ck_assert_str_eq(config.channel, "MSAP_EVENTS");
    ck_assert_int_eq(config.epoch, 0);
    ck_assert_uint_eq(config.snapshot_every, 0);
    config.lcm = lcm;
    ck_assert_int_eq(msap_lcm_create(&config, &one), MSAP_LCM_OK);
    commit();
    ck_assert_int_eq(msap_lcm_publish(one, world, 0), MSAP_LCM_OK);
    receive();
    ck_assert_int_gt(received[0].message.epoch, INT64_C(1577836800000000)); /* the clock, since 2020 */
    msap_lcm_destroy(one);
    ck_assert_int_eq(setenv("LCM_DEFAULT_URL", "memq://", 1), 0);
    ck_assert_int_eq(msap_lcm_create(NULL, &two), MSAP_LCM_OK);
    msap_lcm_destroy(two);
}
END_TEST

START_TEST(test_every_status_has_a_text_of_its_own)
{
    static const msap_lcm_status all[] = {
        MSAP_LCM_OK, MSAP_LCM_ERROR_NULL, MSAP_LCM_ERROR_STRUCT_SIZE, MSAP_LCM_ERROR_CONFIG,
        MSAP_LCM_ERROR_MEMORY, MSAP_LCM_ERROR_CONNECT, MSAP_LCM_ERROR_SEND, MSAP_LCM_ERROR_UNPUBLISHED,
        MSAP_LCM_ERROR_FINGERPRINT, MSAP_LCM_ERROR_MESSAGE, (msap_lcm_status)5, (msap_lcm_status)99};
    int n = (int)(sizeof all / sizeof *all);
    for (int i = 0; i < n - 1; i++)
        for (int k = i + 1; k < n - 1; k++)
            ck_assert_str_ne(msap_lcm_status_text(all[i]), msap_lcm_status_text(all[k]));
    ck_assert_str_eq(msap_lcm_status_text(all[n - 1]), msap_lcm_status_text(all[n - 2]));
    ck_assert_int_eq(MSAP_LCM_ERROR_MEMORY, MSAP_ERROR_MEMORY);
}
END_TEST

/* ----------------------------------------------------- checking of messages */

START_TEST(test_the_fingerprint_is_pinned)
{
    ck_assert_uint_eq((uint64_t)__msap_pair_events_t_get_hash(), MSAP_LCM_FINGERPRINT);
}
END_TEST

/* A message with one deleted and two created pairs, in a copy of its exact size
 * (so that a sanitizer or valgrind sees what is read beyond it). */
static uint8_t *good_message(size_t *size)
{
    msap_handle a = add_at(0), b = add_at(0);
    commit_and_publish(0);
    move_to(a, 10);
    move_to(b, 20);
    add_at(30);
    add_at(30);
    add_at(40);
    add_at(40);
    commit_and_publish(0);
    ck_assert_int_eq(receive(), 2);
    *size = received[1].size;
    ck_assert_uint_eq(*size, HEAD + 3 * 16);
    uint8_t *copy = malloc(*size);
    return memcpy(copy, received[1].data, *size);
}

static void put(uint8_t *message, int at, int bytes, int64_t value)
{
    for (int i = 0; i < bytes; i++)
        message[at + i] = (uint8_t)((uint64_t)value >> (8 * (bytes - 1 - i)));
}

START_TEST(test_only_whole_messages_pass)
{
    size_t size;
    uint8_t *good = good_message(&size);
    ck_assert_int_eq(msap_lcm_check(good, size), MSAP_LCM_OK);
    for (size_t n = 0; n < size; n++) {
        uint8_t *cut = malloc(n + 1);
        memcpy(cut + 1, good, n);
        ck_assert_int_eq(msap_lcm_check(cut + 1, n),
                         n < 8 ? MSAP_LCM_ERROR_FINGERPRINT : MSAP_LCM_ERROR_MESSAGE);
        free(cut);
    }
    uint8_t *longer = calloc(size + 16, 1);
    memcpy(longer, good, size);
    for (size_t n = size + 1; n <= size + 16; n++)
        ck_assert_int_eq(msap_lcm_check(longer, n), MSAP_LCM_ERROR_MESSAGE);
    free(longer);
    free(good);
}
END_TEST

/* Offsets: 24 seq, 32 base, 40 pairs, 56 kind, 60 part, 64 parts, 68 n_deleted, 72 n_created. */
static const struct {
    int at, bytes;
    int64_t value;
} lies[] = {{0, 8, 0},           {7, 1, 0xaf},        {24, 8, 0},          {24, 8, 1},
            {24, 8, -1},         {24, 8, INT64_MIN},  {32, 8, 2},          {32, 8, -1},
            {40, 8, 1},          {40, 8, -1},         {56, 4, 1},          {56, 4, 2},
            {56, 4, -1},         {60, 4, -1},         {60, 4, 1},          {64, 4, 0},
            {64, 4, -1},         {68, 4, 0},          {68, 4, 2},          {68, 4, -1},
            {68, 4, INT32_MAX},  {68, 4, INT32_MIN},  {68, 4, 0x10000001}, {72, 4, 1},
            {72, 4, 3},          {72, 4, -1},         {72, 4, 0x10000002}, {72, 4, INT32_MAX},
            {72, 4, INT32_MIN}};

START_TEST(test_messages_that_contradict_themselves_do_not_pass)
{
    size_t size;
    uint8_t *message = good_message(&size);
    put(message, lies[_i].at, lies[_i].bytes, lies[_i].value);
    ck_assert_int_eq(msap_lcm_check(message, size),
                     lies[_i].at < 8 ? MSAP_LCM_ERROR_FINGERPRINT : MSAP_LCM_ERROR_MESSAGE);
    free(message);
}
END_TEST

START_TEST(test_counts_below_zero_do_not_pass_though_their_sum_is_right)
{
    size_t size;
    uint8_t *message = good_message(&size);
    put(message, 40, 8, 100);
    put(message, 68, 4, _i == 0 ? -1 : 4);
    put(message, 72, 4, _i == 0 ? 4 : -1);
    ck_assert_int_eq(msap_lcm_check(message, size), MSAP_LCM_ERROR_MESSAGE);
    free(message);
}
END_TEST

START_TEST(test_snapshots_that_contradict_themselves_do_not_pass)
{
    add_at(0);
    add_at(0);
    commit_and_publish(0);
    msap_lcm_publish_snapshot(publisher, world, 0);
    receive();
    uint8_t *message = received[1].data;
    ck_assert_int_eq(msap_lcm_check(message, received[1].size), MSAP_LCM_OK);
    put(message, 24, 8, 5);
    ck_assert_int_eq(msap_lcm_check(message, received[1].size), MSAP_LCM_OK);
    put(message, 32, 8, 4); /* base is not 0 */
    ck_assert_int_eq(msap_lcm_check(message, received[1].size), MSAP_LCM_ERROR_MESSAGE);
    put(message, 32, 8, 0);
    put(message, 68, 4, 1); /* a deleted pair */
    put(message, 72, 4, 0);
    ck_assert_int_eq(msap_lcm_check(message, received[1].size), MSAP_LCM_ERROR_MESSAGE);
}
END_TEST

int main(void)
{
    Suite *suite = suite_create("lcm");
    TCase *stream = tcase_create("stream"), *errors = tcase_create("errors"), *checks = tcase_create("checks");
    tcase_add_checked_fixture(stream, setup_followers, teardown);
    tcase_add_checked_fixture(errors, setup, teardown);
    tcase_add_checked_fixture(checks, setup, teardown);
    tcase_set_timeout(stream, 120);
    tcase_add_test(stream, test_a_commit_is_one_message_with_its_events);
    tcase_add_test(stream, test_the_checksum_is_the_one_described);
    tcase_add_test(stream, test_an_empty_commit_is_a_message);
    tcase_add_test(stream, test_without_a_commit_nothing_is_sent);
    tcase_add_test(stream, test_many_events_go_out_in_parts);
    tcase_add_test(stream, test_events_that_just_fill_a_message_are_one_message);
    tcase_add_test(stream, test_events_are_sorted_through_all_parts);
    tcase_add_test(stream, test_snapshots_show_all_pairs_of_the_last_commit);
    tcase_add_test(stream, test_snapshots_follow_every_so_many_commits);
    tcase_add_test(stream, test_a_commit_left_out_is_healed_by_a_snapshot);
    tcase_add_test(stream, test_a_commit_left_out_is_noticed_though_the_number_of_pairs_is_the_same);
    tcase_add_test(stream, test_trimmed_events_are_healed_by_a_snapshot);
    tcase_add_test(stream, test_trimmed_events_are_noticed_though_the_number_of_pairs_is_the_same);
    tcase_add_test(stream, test_a_world_older_than_the_stream_begins_with_a_snapshot);
    tcase_add_test(stream, test_readers_follow_a_random_world_from_the_start_and_late);
    tcase_add_test(stream, test_what_was_sent_is_counted);
    tcase_add_test(stream, test_a_message_that_cannot_be_sent_is_an_error_and_the_stream_goes_on);
    tcase_add_test(stream, test_live_over_udp_multicast);
    tcase_add_test(errors, test_null_pointers_are_refused);
    tcase_add_test(errors, test_bad_configs_are_refused);
    tcase_add_test(errors, test_defaults);
    tcase_add_test(errors, test_every_status_has_a_text_of_its_own);
    tcase_add_test(checks, test_the_fingerprint_is_pinned);
    tcase_add_test(checks, test_only_whole_messages_pass);
    tcase_add_loop_test(checks, test_messages_that_contradict_themselves_do_not_pass, 0,
                        (int)(sizeof lies / sizeof *lies));
    tcase_add_loop_test(checks, test_counts_below_zero_do_not_pass_though_their_sum_is_right, 0, 2);
    tcase_add_test(checks, test_snapshots_that_contradict_themselves_do_not_pass);
    suite_add_tcase(suite, stream);
    suite_add_tcase(suite, errors);
    suite_add_tcase(suite, checks);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}
