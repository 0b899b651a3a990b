/* A harness as a plain program: runs every file that is named, or is in a folder that
 * is named, through it once; and inputs made of random bytes.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 *     fuzz_api [-n COUNT] [FILE|FOLDER]...
 *
 * The last line is "N inputs". An input that shows something wrong ends the program and
 * is named: by its path, or by its number, from 1, among the random ones.
 */
#define _POSIX_C_SOURCE 200809L
#include "fuzz.h"

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST_RANDOM = 256 }; /* bytes of a random input */

static unsigned long inputs;
static char running[4096]; /* the name of the input at work */

/* fuzz_check aborts, and so do sanitizers with abort_on_error=1. */
static void name_input(int number)
{
    ssize_t written = write(STDERR_FILENO, running, strlen(running));
    written += write(STDERR_FILENO, "\n", 1);
    _exit(written > 0 ? number : EXIT_FAILURE);
}

static void give_up(const char *path, const char *why)
{
    fprintf(stderr, "%s: %s\n", path, why);
    exit(EXIT_FAILURE);
}

static void run(const uint8_t *bytes, size_t size)
{
    LLVMFuzzerTestOneInput(bytes, size);
    inputs++;
}

/* -------------------------------------------------------------------- files */

/* The whole file; *size bytes, to be freed. */
static uint8_t *read_file(const char *path, size_t *size)
{
    FILE *file = fopen(path, "rb");
    uint8_t *bytes = NULL;
    long end = 0;
    if (!file || fseek(file, 0, SEEK_END) || (end = ftell(file)) < 0 || fseek(file, 0, SEEK_SET))
        give_up(path, "cannot be read");
    *size = (size_t)end;
    bytes = malloc(*size + !*size); /* no more than there is: a sanitizer sees a read behind it */
    if (!bytes || fread(bytes, 1, *size, file) != *size)
        give_up(path, "cannot be read");
    fclose(file);
    return bytes;
}

static void run_file(const char *path)
{
    size_t size;
    uint8_t *bytes = read_file(path, &size);
    snprintf(running, sizeof running, "%s", path);
    run(bytes, size);
    free(bytes);
}

static int is_visible(const struct dirent *entry) { return entry->d_name[0] != '.'; }

/* A folder's files in the order of their names. */
static void run_path(const char *path)
{
    struct dirent **entries;
    int count = scandir(path, &entries, is_visible, alphasort), i;
    if (count < 0) {
        run_file(path);
        return;
    }
    for (i = 0; i < count; i++) {
        char name[sizeof running];
        snprintf(name, sizeof name, "%s/%s", path, entries[i]->d_name);
        run_file(name);
        free(entries[i]);
    }
    free(entries);
}

/* ------------------------------------------------------------------- random */

static uint64_t splitmix64(uint64_t x)
{
    x += UINT64_C(0x9E3779B97F4A7C15);
    x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
    return x ^ (x >> 31);
}

/* Every machine has the same input under the same number. */
static void run_random(unsigned long number)
{
    uint8_t bytes[MOST_RANDOM], *own;
    size_t size = (size_t)(splitmix64(number) % MOST_RANDOM) + 1, i;
    for (i = 0; i < size; i++)
        bytes[i] = (uint8_t)(splitmix64(number << 9 | (i + 1)) >> 32);
    own = malloc(size);
    if (!own)
        give_up("input", "there is no memory");
    memcpy(own, bytes, size);
    snprintf(running, sizeof running, "random input %lu", number);
    run(own, size);
    free(own);
}

int main(int argc, char **argv)
{
    unsigned long number, count = 0;
    int option;
    signal(SIGABRT, name_input);
    while ((option = getopt(argc, argv, "n:")) != -1) {
        if (option != 'n')
            return 2;
        count = strtoul(optarg, NULL, 10);
    }
    for (number = 1; number <= count; number++)
        run_random(number);
    for (; optind < argc; optind++)
        run_path(argv[optind]);
    printf("%lu inputs\n", inputs);
    return inputs > 0 ? EXIT_SUCCESS : EXIT_FAILURE;
}
