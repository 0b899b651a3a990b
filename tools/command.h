/* What the parts of the command share: exit statuses, complaints, options.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef COMMAND_H
#define COMMAND_H

/* Exit statuses. */
enum {
    DONE = 0,
    FAILED = 1, /* a bad trace, a file that cannot be read or written, no memory */
    MISUSED = 2 /* an option or argument that makes no sense, or asks for what this version does not have */
};

/* Prints one line, "multisap: " and the message, on stderr. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
void complain(const char *format, ...);

/* Complain, and are the exit status. */
#define FAIL(...) (complain(__VA_ARGS__), FAILED)
#define MISUSE(...) (complain(__VA_ARGS__), MISUSED)

/* Take an option's value, a whole number or a finite one above 0: DONE, or MISUSED with a complaint. */
int parse_count(const char *option, const char *text, unsigned long min, unsigned long max,
                unsigned long *value);
int parse_positive(const char *option, const char *text, double *value);

/* The name of a file without its folders and the ending ".trace"; NULL without memory, else to be freed. */
char *scene_name(const char *path);

/* Flushes stdout: DONE, or FAILED with a complaint if something did not get out. */
int finish_output(void);

/* The sub-commands, with their own arguments from argv[1] on. */
int replay_main(int argc, char **argv);
int stream_main(int argc, char **argv);

#endif
