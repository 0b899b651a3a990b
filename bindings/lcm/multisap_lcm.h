/* multisap over LCM: the pair events of a world as a stream of messages.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     msap_lcm_config config;
 *     msap_lcm_publisher *publisher;
 *     msap_lcm_config_init(&config, sizeof config);
 *     msap_lcm_create(&config, &publisher);
 *     ... msap_commit(world, ...);
 *     msap_lcm_publish(publisher, world, utime);    after each commit
 *     msap_lcm_destroy(publisher);
 *
 * The message, and how a reader follows the stream, is described in
 * pair_events_t.lcm; a message is at most MSAP_LCM_MESSAGE_MAX bytes, so that it
 * fits into one datagram, and what is longer goes out in parts.
 *
 * Functions return a status and give results by out pointers, which are left alone
 * on failure and may not be NULL. This library prints nothing and keeps no globals;
 * liblcm, below it, prints a line on stderr when it fails. One thread per publisher
 * at a time, and while it publishes nobody may change the world (to the world,
 * publishing is a const call). Link with -lmultisap-lcm -lmultisap -llcm.
 */
#ifndef MULTISAP_LCM_H
#define MULTISAP_LCM_H

#include <lcm/lcm.h>
#include <multisap.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The most bytes of a message. */
#define MSAP_LCM_MESSAGE_MAX 60000u

/* The first eight bytes of every message, big-endian: LCM's fingerprint of its type. */
#define MSAP_LCM_FINGERPRINT UINT64_C(0xaf4cbfd932beedad)

/* What a call came to. The numbers are pinned; those below 100 mean what the
 * msap_status of the same number means. */
typedef enum msap_lcm_status {
    MSAP_LCM_OK = 0,
    MSAP_LCM_ERROR_NULL = 1,        /* a pointer that must not be NULL was */
    MSAP_LCM_ERROR_STRUCT_SIZE = 2, /* struct_size is none that this library knows */
    MSAP_LCM_ERROR_CONFIG = 3,      /* a field holds a value that is not allowed */
    MSAP_LCM_ERROR_MEMORY = 4,      /* malloc returned NULL */
    MSAP_LCM_ERROR_CONNECT = 100,   /* liblcm could not open the URL */
    MSAP_LCM_ERROR_SEND = 101,      /* liblcm could not send a message; to readers it is lost */
    MSAP_LCM_ERROR_UNPUBLISHED = 102, /* the world's last commit is not the last that was published */
    MSAP_LCM_ERROR_FINGERPRINT = 103, /* the bytes are no message of this type */
    MSAP_LCM_ERROR_MESSAGE = 104      /* the message contradicts itself or its length */
} msap_lcm_status;

/* A sentence about a status in English, owned by the library; for a number that is
 * no status, a sentence that says so. Never NULL. Thread rule: free. */
MSAP_API const char *msap_lcm_status_text(msap_lcm_status status);

/* ---------------------------------------------------------------- publisher */

typedef struct msap_lcm_config {
    uint32_t struct_size;    /* set by msap_lcm_config_init */
    uint32_t snapshot_every; /* a snapshot follows the events of every so many-th commit, so that readers can
                                join late or heal; default 0: only msap_lcm_publish_snapshot sends one */
    lcm_t *lcm;              /* the caller's, used and not destroyed; default NULL: opened from url */
    const char *url;         /* as for lcm_create; default NULL: $LCM_DEFAULT_URL, or LCM's own default.
                                Must be NULL if lcm is given */
    const char *channel;     /* 1 to LCM_MAX_CHANNEL_NAME_LENGTH bytes, copied; default "MSAP_EVENTS" */
    int64_t epoch;           /* names the stream; default 0: the clock, in microseconds since 1970 */
} msap_lcm_config;

typedef struct msap_lcm_publisher msap_lcm_publisher;

/* Fills *config with the defaults; struct_size must be sizeof(msap_lcm_config) as
 * the caller knows it. Errors: MSAP_LCM_ERROR_NULL, _STRUCT_SIZE. */
MSAP_API msap_lcm_status msap_lcm_config_init(msap_lcm_config *config, size_t struct_size);

/* Makes a publisher, which begins a new stream; *publisher is the caller's, to be
 * given to msap_lcm_destroy. config may be NULL for the defaults. It takes about
 * 120 kB from malloc once; publishing takes nothing more (liblcm may). Errors:
 * MSAP_LCM_ERROR_STRUCT_SIZE, _CONFIG, _NULL, _MEMORY, _CONNECT. */
MSAP_API msap_lcm_status msap_lcm_create(const msap_lcm_config *config, msap_lcm_publisher **publisher);

/* Ends the stream and closes what msap_lcm_create opened: this writes the rest of
 * a log to disk, and liblcm does not tell whether that went well; a file's size
 * does (see msap_lcm_sent). NULL is allowed. */
MSAP_API void msap_lcm_destroy(msap_lcm_publisher *publisher);

/* Sends the pairs that the world's last commit deleted and created, also if there
 * are none. To be called after each commit, always with the same world; utime is
 * the time of the commit, in microseconds, handed on to the readers. If commits
 * were left out, or the world is older than the stream, or msap_trim has emptied
 * the arrays of events, a snapshot is sent in their place. Without a new commit
 * nothing is sent. Errors: MSAP_LCM_ERROR_NULL; _SEND, after which the stream goes
 * on and readers miss this commit. Cost: follows the events; a snapshot or a commit without events, the pairs. */
MSAP_API msap_lcm_status msap_lcm_publish(msap_lcm_publisher *publisher, const msap_world *world,
                                          int64_t utime);

/* Sends all pairs of the last commit, which must have been published. Errors:
 * MSAP_LCM_ERROR_NULL, _UNPUBLISHED, _SEND. Cost: follows the pairs. */
MSAP_API msap_lcm_status msap_lcm_publish_snapshot(msap_lcm_publisher *publisher, const msap_world *world,
                                                   int64_t utime);

/* How many messages were sent so far, and how many bytes they have together. In an
 * LCM log each takes 28 bytes and its channel's name more. Errors:
 * MSAP_LCM_ERROR_NULL. */
MSAP_API msap_lcm_status msap_lcm_sent(const msap_lcm_publisher *publisher, uint64_t *messages,
                                       uint64_t *bytes);

/* ------------------------------------------------------------------ reading */

/* Whether the bytes, as lcm_subscribe delivers them, are one whole message that
 * says nothing impossible: fingerprint, counts and length agree, kind and part are
 * in range, 0 <= base < seq. What passes can be given to lcm-gen's decoder, which
 * does not look at the length. Errors: MSAP_LCM_ERROR_NULL, _FINGERPRINT, _MESSAGE.
 * Thread rule: free. Cost: constant. */
MSAP_API msap_lcm_status msap_lcm_check(const void *data, size_t size);

/* What a pair adds to the checksum of a message. Thread rule: free. */
MSAP_API uint64_t msap_lcm_pair_hash(int64_t a, int64_t b);

#ifdef __cplusplus
}
#endif

#endif
