/* multisap stream: replays a trace and publishes the pair events of each frame over LCM.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * Without --url the events go into an LCM log. liblcm writes it through stdio and
 * does not tell whether the last bytes reached the disk, but the size of a log
 * follows from what was sent, so the size that the file has afterwards tells. */
#define _POSIX_C_SOURCE 200809L
#define _FILE_OFFSET_BITS 64
#include "command.h"

#include <getopt.h>
#include <stdio.h>
#include <stdlib.h>

static const char usage[] =
    "Usage: multisap stream [OPTION...] FILE.trace\n"
    "\n"
    "Replays a scene and publishes the pair events of each frame over LCM.\n"
    "\n"
    "  --url URL       where to publish, as LCM spells it: udpm://239.255.76.67:7667?ttl=0\n"
    "                  (default: into the LCM log NAME.lcmlog in the current folder)\n"
    "  --channel NAME  the LCM channel (default MSAP_EVENTS)\n"
    "  --rate HZ       frames a second (default: 60; logs are written without waiting)\n"
    "  --help          this text\n";

typedef struct options {
    const char *path, *url, *channel;
    double rate; /* 0: not given */
} options;

static int run_stream(const options *o);

static int parse_option(options *o, int option, const char *value)
{
    switch (option) {
    case 'u': o->url = value; return DONE;
    case 'c': o->channel = value; return DONE;
    case 'r': return parse_positive("--rate", value, &o->rate);
    default: return MISUSED; /* getopt_long has complained */
    }
}

int stream_main(int argc, char **argv)
{
    static const struct option known[] = {{"url", required_argument, NULL, 'u'},
                                          {"channel", required_argument, NULL, 'c'},
                                          {"rate", required_argument, NULL, 'r'},
                                          {"help", no_argument, NULL, 'h'},
                                          {NULL, 0, NULL, 0}};
    options o = {NULL, NULL, "MSAP_EVENTS", 0};
    int option, result = DONE;
    while (result == DONE && (option = getopt_long(argc, argv, "h", known, NULL)) != -1) {
        if (option == 'h') {
            fputs(usage, stdout);
            return finish_output();
        }
        result = parse_option(&o, option, optarg);
    }
    if (result)
        return result;
    if (optind != argc - 1)
        return MISUSE("stream: one trace is needed (--help tells more)");
    o.path = argv[optind];
    return run_stream(&o);
}

#ifndef MSAP_WITH_LCM

static int run_stream(const options *o)
{
    return FAIL("%s: cannot be streamed: this multisap was built without LCM", o->path);
}

#else

#include "player.h"

#include <inttypes.h>
#include <math.h>
#include <multisap_lcm.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

/* What is measured on the way. */
typedef struct totals {
    uint64_t boxes, pairs; /* the most of a frame */
    uint64_t events_first, events_later, events_max;
    double ms_later, ms_max, ms_publishing;
} totals;

/* A stream on its way. */
typedef struct stream {
    char *url;
    char *file; /* the log that url names, or NULL */
    uint64_t size_before;
    double hz;
    int waits; /* for the time of each frame */
    msap_lcm_publisher *publisher;
    totals totals;
} stream;

/* ---------------------------------------------------------------- the place */

static char *join(const char *a, const char *b, const char *c)
{
    size_t room = strlen(a) + strlen(b) + strlen(c) + 1;
    char *text = malloc(room);
    if (text)
        snprintf(text, room, "%s%s%s", a, b, c);
    return text;
}

/* The file of a URL of LCM's file provider: what stands before the options. */
static char *file_of_url(const char *url)
{
    char *file = strncmp(url, "file://", 7) == 0 ? join(url + 7, "", "") : NULL;
    if (file)
        file[strcspn(file, "?")] = '\0';
    return file;
}

/* Where to publish: o->url, or a log named for the scene. */
static int choose_place(stream *s, const options *o)
{
    char *scene = scene_name(o->path);
    if (scene && !o->url && strchr(scene, '?')) {
        free(scene);
        return FAIL("%s: a ? in the name cannot be part of an LCM log's (give --url)", o->path);
    }
    s->url = o->url ? join(o->url, "", "") : scene ? join("file://", scene, ".lcmlog?mode=w") : NULL;
    free(scene);
    if (!s->url)
        return FAIL("no memory");
    s->file = file_of_url(s->url);
    s->hz = o->rate > 0 ? o->rate : 60;
    s->waits = o->rate > 0 || !s->file;
    return DONE;
}

/* The size of a log; of a device, or of what is not there, 0. */
static uint64_t file_size(const char *file)
{
    struct stat about;
    return stat(file, &about) == 0 ? (uint64_t)about.st_size : 0;
}

/* Whether it is a pipe, whose size tells nothing. */
static int is_pipe(const char *file)
{
    struct stat about;
    return stat(file, &about) == 0 && S_ISFIFO(about.st_mode);
}

static int open_publisher(stream *s, const options *o)
{
    msap_lcm_config config;
    msap_lcm_config_init(&config, sizeof config);
    config.url = s->url;
    config.channel = o->channel;
    msap_lcm_status status = msap_lcm_create(&config, &s->publisher);
    if (status == MSAP_LCM_ERROR_CONFIG)
        return MISUSE("--channel %s: not 1 to %d bytes", o->channel, LCM_MAX_CHANNEL_NAME_LENGTH);
    if (status)
        return FAIL("%s: %s", s->url, msap_lcm_status_text(status));
    s->size_before = s->file ? file_size(s->file) : 0;
    return DONE;
}

/* Closes a log and looks whether all of it is there. */
static int close_publisher(stream *s, const options *o, uint64_t messages, uint64_t bytes)
{
    uint64_t size = s->size_before + bytes + messages * (28 + strlen(o->channel));
    msap_lcm_destroy(s->publisher);
    s->publisher = NULL;
    if (s->file && !is_pipe(s->file) && file_size(s->file) != size)
        return FAIL("%s: the log is not whole: %" PRIu64 " bytes of %" PRIu64 " were written",
                    s->file, file_size(s->file), size);
    return DONE;
}

/* --------------------------------------------------------------- the frames */

static void wait_until(double ms)
{
    double left = ms - clock_ms();
    if (left > 0) {
        struct timespec pause = {(time_t)(left / 1e3), (long)(fmod(left, 1e3) * 1e6)};
        nanosleep(&pause, NULL);
    }
}

static void count_frame(totals *t, const player *p)
{
    uint64_t events = p->n_created + p->n_deleted;
    if (p->boxes > t->boxes)
        t->boxes = p->boxes;
    if (p->n_active > t->pairs)
        t->pairs = p->n_active;
    if (p->next_frame == 1) {
        t->events_first = events;
        return;
    }
    t->events_later += events;
    t->ms_later += p->ms;
    if (events > t->events_max)
        t->events_max = events;
    if (p->ms > t->ms_max)
        t->ms_max = p->ms;
}

static int publish_frame(stream *s, const player *p)
{
    int64_t utime = (int64_t)((double)(p->next_frame - 1) * 1e6 / s->hz);
    double start = clock_ms();
    msap_lcm_status status = msap_lcm_publish(s->publisher, p->world, utime);
    s->totals.ms_publishing += clock_ms() - start;
    if (status)
        return FAIL("%s: frame %u: %s", s->url, (unsigned)p->next_frame - 1,
                    msap_lcm_status_text(status));
    count_frame(&s->totals, p);
    return DONE;
}

static int publish_frames(stream *s, const trace *t)
{
    player p;
    msap_config config;
    msap_config_init(&config, sizeof config);
    int result = player_begin(&p, t, &config);
    if (result)
        return result;
    double start = clock_ms();
    while (result == DONE && p.next_frame < t->frames) {
        if (s->waits)
            wait_until(start + p.next_frame * 1e3 / s->hz);
        result = player_play(&p);
        if (result == DONE)
            result = publish_frame(s, &p);
    }
    player_end(&p);
    return result;
}

/* --------------------------------------------------------------- the report */

static void print_report(const stream *s, const trace *t, const options *o, uint64_t messages,
                         uint64_t bytes)
{
    const totals *n = &s->totals;
    double later = t->frames > 1 ? (double)t->frames - 1 : 1, all = t->frames ? (double)t->frames : 1;
    printf("%s: %" PRIu32 "D, %" PRIu32 " frames\n", t->path, t->dims, t->frames);
    printf("boxes   %" PRIu64 " at most\n", n->boxes);
    printf("pairs   %" PRIu64 " at most\n", n->pairs);
    printf("events  %" PRIu64 " in the first frame, then %.1f a frame, %" PRIu64 " at most\n",
           n->events_first, (double)n->events_later / later, n->events_max);
    printf("time    %.3f ms a frame after the first, %.3f ms at most; publishing %.3f ms\n",
           n->ms_later / later, n->ms_max, n->ms_publishing / all);
    printf("sent    %" PRIu64 " messages, %.2f MB, on channel %s to %s\n", messages, (double)bytes / 1e6,
           o->channel, s->file ? s->file : s->url);
    if (s->file)
        printf("\n"
               "Look into the log with Python (pip install lcm):\n"
               "    import lcm\n"
               "    for event in lcm.EventLog(\"%s\"): print(event.timestamp, event.channel, len(event.data))\n"
               "or play it to subscribers, lcm-spy among them: lcm-logplayer %s\n",
               s->file, s->file);
}

static int stream_trace(stream *s, const trace *t, const options *o)
{
    uint64_t messages, bytes;
    int result = open_publisher(s, o);
    if (result == DONE)
        result = publish_frames(s, t);
    if (result)
        return result;
    msap_lcm_sent(s->publisher, &messages, &bytes);
    result = close_publisher(s, o, messages, bytes);
    if (result)
        return result;
    print_report(s, t, o, messages, bytes);
    return finish_output();
}

static int run_stream(const options *o)
{
    stream s;
    trace t;
    memset(&s, 0, sizeof s);
    int result = trace_load(&t, o->path);
    if (result)
        return result;
    result = choose_place(&s, o);
    if (result == DONE)
        result = stream_trace(&s, &t, o);
    msap_lcm_destroy(s.publisher);
    free(s.url);
    free(s.file);
    trace_free(&t);
    return result;
}

#endif
