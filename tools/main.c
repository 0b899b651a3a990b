/* The command `multisap`: finds the sub-command and hands on.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * replay.c   replays a trace, checks or times it     trace.c    reads a trace
 * stream.c   replays a trace, publishes its events   player.c   brings it into a world
 * setup.c    options that set a world up             main.c     this file, and what all share
 */
#include "command.h"

#include <multisap.h>

#include <ctype.h>
#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char usage[] = "Usage: multisap COMMAND [OPTION...] FILE.trace\n"
                            "       multisap --help | --version\n"
                            "\n"
                            "Finds which boxes of a recorded scene overlap, frame by frame.\n"
                            "\n"
                            "Commands:\n"
                            "  replay   replay a scene, print answers or times\n"
                            "  stream   replay a scene, publish its pair events over LCM\n"
                            "\n"
                            "multisap COMMAND --help tells a command's options.\n";

static char program[] = "multisap"; /* in argv[0], where getopt_long takes it from for its complaints */

void complain(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("multisap: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

int parse_count(const char *option, const char *text, unsigned long min, unsigned long max,
                unsigned long *value)
{
    char *end;
    errno = 0;
    *value = strtoul(text, &end, 10);
    if (!isdigit((unsigned char)text[0]) || *end != '\0' || errno || *value < min || *value > max)
        return MISUSE("%s %s: not a whole number from %lu to %lu", option, text, min, max);
    return DONE;
}

int parse_positive(const char *option, const char *text, double *value)
{
    char *end;
    *value = strtod(text, &end);
    if (end == text || *end != '\0' || !isfinite(*value) || *value <= 0)
        return MISUSE("%s %s: not a number above 0", option, text);
    return DONE;
}

char *scene_name(const char *path)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    size_t length = strlen(base);
    if (length > 6 && strcmp(base + length - 6, ".trace") == 0)
        length -= 6;
    char *name = calloc(length + 1, 1);
    return name ? memcpy(name, base, length) : NULL; // NOLINT(bugprone-not-null-terminated-result): calloc put the end
}

int finish_output(void)
{
    if (fflush(stdout) != 0 || ferror(stdout))
        return FAIL("the output could not be written: %s", strerror(errno));
    return DONE;
}

static int run_command(int argc, char **argv)
{
    static const struct {
        const char *name;
        int (*run)(int argc, char **argv);
    } commands[] = {{"replay", replay_main}, {"stream", stream_main}};
    if (argc == 0) {
        fputs(usage, stderr);
        return MISUSED;
    }
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++)
        if (strcmp(argv[0], commands[i].name) == 0) {
            argv[0] = program;
            optind = 0; /* getopt_long starts anew, on the sub-command's arguments */
            return commands[i].run(argc, argv);
        }
    return MISUSE("%s: no such command (multisap --help lists them)", argv[0]);
}

int main(int argc, char **argv)
{
    static const struct option options[] = {
        {"help", no_argument, NULL, 'h'}, {"version", no_argument, NULL, 'V'}, {NULL, 0, NULL, 0}};
    if (argc > 0)
        argv[0] = program;
    switch (getopt_long(argc, argv, "+hV", options, NULL)) {
    case -1: return run_command(argc - optind, argv + optind);
    case 'h': fputs(usage, stdout); return finish_output();
    case 'V': printf("multisap %s\n", msap_version_text()); return finish_output();
    default: return MISUSED;
    }
}
