/* The publisher of pair events, and the check of received messages.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * The publisher keeps what a reader that lost nothing has too: the number of the
 * stream's commit, and the count and checksum of the active pairs, brought up to
 * date by the events alone. Where these do not lead from the last published state
 * to the world's (a commit left out, arrays trimmed), it starts from the full set.
 *
 * Pairs are copied into two arrays that fit one message, deleted ones first; the
 * lists of the message point into them, and lcm-gen's code encodes it. */
#define _POSIX_C_SOURCE 200809L
#include "multisap_lcm.h"
#include "msap_pair_events_t.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Where the fields of an encoded message are, in bytes. */
enum {
    AT_SEQ = 24,
    AT_BASE = 32,
    AT_PAIRS = 40,
    AT_KIND = 56,
    AT_PART = 60,
    AT_PARTS = 64,
    AT_N_DELETED = 68,
    AT_N_CREATED = 72,
    HEAD = 76,
    PAIR = 16
};

#define PAIRS_MAX ((MSAP_LCM_MESSAGE_MAX - HEAD) / PAIR)

struct msap_lcm_publisher {
    lcm_t *lcm;
    int owns_lcm;
    char channel[LCM_MAX_CHANNEL_NAME_LENGTH + 1];
    uint32_t snapshot_every;
    uint64_t commits;         /* of the world, at the last publishing */
    msap_pair_events_t state; /* epoch, seq, pairs and checksum of the last publishing */
    uint64_t messages, bytes; /* sent */
    int64_t a[PAIRS_MAX], b[PAIRS_MAX];
    uint8_t buffer[MSAP_LCM_MESSAGE_MAX];
};

/* The pairs that a message, or several parts, is to carry. */
struct payload {
    const msap_pair *deleted, *created;
    size_t n_deleted, n_created;
};

/* ----------------------------------------------------------------- checksum */

static uint64_t splitmix64(uint64_t x)
{
    x += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

uint64_t msap_lcm_pair_hash(int64_t a, int64_t b)
{
    return splitmix64(splitmix64((uint64_t)a) ^ (uint64_t)b);
}

static uint64_t hash_of(const msap_pair *pairs, size_t n)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += msap_lcm_pair_hash((int64_t)pairs[i].a, (int64_t)pairs[i].b);
    return sum;
}

/* --------------------------------------------------------------- publishing */

static void copy_pairs(msap_lcm_publisher *p, size_t at, const msap_pair *pairs, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        p->a[at + i] = (int64_t)pairs[i].a;
        p->b[at + i] = (int64_t)pairs[i].b;
    }
}

/* Puts part `message->part` of the payload into the message. */
static void fill_part(msap_lcm_publisher *p, const struct payload *load, msap_pair_events_t *message)
{
    size_t first = (size_t)message->part * PAIRS_MAX, rest = load->n_deleted + load->n_created - first;
    size_t n = rest < PAIRS_MAX ? rest : PAIRS_MAX;
    size_t deleted_left = first < load->n_deleted ? load->n_deleted - first : 0;
    size_t n_deleted = deleted_left < n ? deleted_left : n;
    if (n_deleted > 0)
        copy_pairs(p, 0, load->deleted + first, n_deleted);
    if (n > n_deleted)
        copy_pairs(p, n_deleted, load->created + (first + n_deleted - load->n_deleted), n - n_deleted);
    message->n_deleted = (int32_t)n_deleted;
    message->n_created = (int32_t)(n - n_deleted);
    message->deleted_a = p->a;
    message->deleted_b = p->b;
    message->created_a = p->a + n_deleted;
    message->created_b = p->b + n_deleted;
}

static msap_lcm_status send_message(msap_lcm_publisher *p, const msap_pair_events_t *message)
{
    int size = msap_pair_events_t_encode(p->buffer, 0, sizeof p->buffer, message);
    if (size < 0 || lcm_publish(p->lcm, p->channel, p->buffer, (unsigned int)size) != 0)
        return MSAP_LCM_ERROR_SEND;
    p->messages++;
    p->bytes += (uint64_t)size;
    return MSAP_LCM_OK;
}

static msap_lcm_status send_parts(msap_lcm_publisher *p, const struct payload *load, int32_t kind,
                                  int64_t utime)
{
    msap_pair_events_t message = p->state;
    size_t total = load->n_deleted + load->n_created;
    message.utime = utime;
    message.kind = kind;
    message.base = kind == MSAP_PAIR_EVENTS_T_SNAPSHOT ? 0 : message.seq - 1;
    message.parts = total == 0 ? 1 : (int32_t)((total - 1) / PAIRS_MAX + 1);
    for (message.part = 0; message.part < message.parts; message.part++) {
        fill_part(p, load, &message);
        msap_lcm_status status = send_message(p, &message);
        if (status)
            return status;
    }
    return MSAP_LCM_OK;
}

static msap_lcm_status send_snapshot(msap_lcm_publisher *p, const msap_world *world, int64_t utime)
{
    struct payload load = {NULL, NULL, 0, 0};
    msap_pairs(world, &load.created, &load.n_created);
    return send_parts(p, &load, MSAP_PAIR_EVENTS_T_SNAPSHOT, utime);
}

/* Brings the checksum from the last published state (at first the empty set of
 * commit 0) to that of the world by the events; 0 if they do not lead there. */
static int follow_events(msap_lcm_publisher *p, uint64_t commits, const struct payload *load,
                         const msap_pair *pairs, size_t active)
{
    if (commits != p->commits + 1 ||
        (uint64_t)p->state.pairs + load->n_created != active + (uint64_t)load->n_deleted)
        return 0;
    if (load->n_created + load->n_deleted == 0)
        return hash_of(pairs, active) == (uint64_t)p->state.checksum;
    p->state.checksum = (int64_t)((uint64_t)p->state.checksum + hash_of(load->created, load->n_created) -
                                  hash_of(load->deleted, load->n_deleted));
    return 1;
}

static uint64_t commits_of(const msap_world *world)
{
    msap_world_stats stats;
    memset(&stats, 0, sizeof stats);
    stats.struct_size = sizeof stats;
    msap_stats(world, &stats);
    return stats.commits;
}

msap_lcm_status msap_lcm_publish(msap_lcm_publisher *p, const msap_world *world, int64_t utime)
{
    struct payload load;
    const msap_pair *pairs;
    size_t active;
    if (!p || !world)
        return MSAP_LCM_ERROR_NULL;
    uint64_t commits = commits_of(world);
    if (commits == p->commits)
        return MSAP_LCM_OK;
    msap_deleted(world, &load.deleted, &load.n_deleted);
    msap_created(world, &load.created, &load.n_created);
    msap_pairs(world, &pairs, &active);

    int followed = follow_events(p, commits, &load, pairs, active);
    if (!followed)
        p->state.checksum = (int64_t)hash_of(pairs, active);
    p->state.pairs = (int64_t)active;
    p->state.seq++;
    p->commits = commits;
    if (!followed)
        return send_snapshot(p, world, utime);
    msap_lcm_status status = send_parts(p, &load, MSAP_PAIR_EVENTS_T_EVENTS, utime);
    if (status == MSAP_LCM_OK && p->snapshot_every > 0 && p->state.seq % p->snapshot_every == 0)
        status = send_snapshot(p, world, utime);
    return status;
}

msap_lcm_status msap_lcm_publish_snapshot(msap_lcm_publisher *p, const msap_world *world, int64_t utime)
{
    if (!p || !world)
        return MSAP_LCM_ERROR_NULL;
    if (p->state.seq == 0 || commits_of(world) != p->commits)
        return MSAP_LCM_ERROR_UNPUBLISHED;
    return send_snapshot(p, world, utime);
}

msap_lcm_status msap_lcm_sent(const msap_lcm_publisher *p, uint64_t *messages, uint64_t *bytes)
{
    if (!p || !messages || !bytes)
        return MSAP_LCM_ERROR_NULL;
    *messages = p->messages;
    *bytes = p->bytes;
    return MSAP_LCM_OK;
}

/* ------------------------------------------------------- beginning and end */

msap_lcm_status msap_lcm_config_init(msap_lcm_config *config, size_t struct_size)
{
    if (!config)
        return MSAP_LCM_ERROR_NULL;
    if (struct_size != sizeof *config)
        return MSAP_LCM_ERROR_STRUCT_SIZE;
    memset(config, 0, sizeof *config);
    config->struct_size = (uint32_t)struct_size;
    config->channel = "MSAP_EVENTS";
    return MSAP_LCM_OK;
}

static msap_lcm_status config_check(const msap_lcm_config *config)
{
    if (config->struct_size != sizeof *config)
        return MSAP_LCM_ERROR_STRUCT_SIZE;
    if (!config->channel || config->channel[0] == '\0' ||
        strlen(config->channel) > LCM_MAX_CHANNEL_NAME_LENGTH || (config->lcm && config->url))
        return MSAP_LCM_ERROR_CONFIG;
    return MSAP_LCM_OK;
}

static int64_t clock_microseconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000000 + now.tv_nsec / 1000;
}

msap_lcm_status msap_lcm_create(const msap_lcm_config *config, msap_lcm_publisher **publisher)
{
    msap_lcm_config defaults;
    msap_lcm_config_init(&defaults, sizeof defaults);
    if (!publisher)
        return MSAP_LCM_ERROR_NULL;
    if (!config)
        config = &defaults;
    msap_lcm_status status = config_check(config);
    if (status)
        return status;

    msap_lcm_publisher *p = calloc(1, sizeof *p);
    if (!p)
        return MSAP_LCM_ERROR_MEMORY;
    p->owns_lcm = !config->lcm;
    p->lcm = config->lcm ? config->lcm : lcm_create(config->url);
    if (!p->lcm) {
        free(p);
        return MSAP_LCM_ERROR_CONNECT;
    }
    memcpy(p->channel, config->channel, strlen(config->channel)); /* calloc has put a 0 behind it */
    p->snapshot_every = config->snapshot_every;
    p->state.epoch = config->epoch ? config->epoch : clock_microseconds();
    *publisher = p;
    return MSAP_LCM_OK;
}

void msap_lcm_destroy(msap_lcm_publisher *p)
{
    if (p && p->owns_lcm)
        lcm_destroy(p->lcm);
    free(p);
}

/* ------------------------------------------------------------------ reading */

static uint64_t big_endian(const uint8_t *at, int bytes)
{
    uint64_t value = 0;
    for (int i = 0; i < bytes; i++)
        value = value << 8 | at[i];
    return value;
}

static int64_t field64(const uint8_t *message, int at)
{
    return (int64_t)big_endian(message + at, 8);
}

static int64_t field32(const uint8_t *message, int at)
{
    return (int32_t)(uint32_t)big_endian(message + at, 4);
}

msap_lcm_status msap_lcm_check(const void *data, size_t size)
{
    const uint8_t *m = data;
    if (!m)
        return MSAP_LCM_ERROR_NULL;
    if (size < 8 || big_endian(m, 8) != MSAP_LCM_FINGERPRINT)
        return MSAP_LCM_ERROR_FINGERPRINT;
    if (size < HEAD || size > MSAP_LCM_MESSAGE_MAX)
        return MSAP_LCM_ERROR_MESSAGE;
    int64_t n_deleted = field32(m, AT_N_DELETED), n_created = field32(m, AT_N_CREATED);
    int64_t base = field64(m, AT_BASE), part = field32(m, AT_PART), kind = field32(m, AT_KIND);
    if (n_deleted < 0 || n_created < 0 || (int64_t)size != HEAD + PAIR * (n_deleted + n_created))
        return MSAP_LCM_ERROR_MESSAGE;
    if (base < 0 || base >= field64(m, AT_SEQ) || part < 0 || part >= field32(m, AT_PARTS) ||
        n_created > field64(m, AT_PAIRS))
        return MSAP_LCM_ERROR_MESSAGE;
    if (kind != MSAP_PAIR_EVENTS_T_EVENTS &&
        (kind != MSAP_PAIR_EVENTS_T_SNAPSHOT || base != 0 || n_deleted != 0))
        return MSAP_LCM_ERROR_MESSAGE;
    return MSAP_LCM_OK;
}

const char *msap_lcm_status_text(msap_lcm_status status)
{
    switch (status) {
    case MSAP_LCM_OK: return "no error";
    case MSAP_LCM_ERROR_NULL: return "a pointer that must not be NULL was";
    case MSAP_LCM_ERROR_STRUCT_SIZE: return "struct_size is none that this library knows";
    case MSAP_LCM_ERROR_CONFIG: return "a field of the configuration holds a value that is not allowed";
    case MSAP_LCM_ERROR_MEMORY: return "no memory";
    case MSAP_LCM_ERROR_CONNECT: return "LCM could not open the URL";
    case MSAP_LCM_ERROR_SEND: return "LCM could not send a message";
    case MSAP_LCM_ERROR_UNPUBLISHED: return "the world's last commit has not been published";
    case MSAP_LCM_ERROR_FINGERPRINT: return "the bytes are no message of this type";
    case MSAP_LCM_ERROR_MESSAGE: return "the message contradicts itself or its length";
    }
    return "this number is no status";
}
