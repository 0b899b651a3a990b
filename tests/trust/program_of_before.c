/* SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A program that may have been built before the library it runs with: later.sh gives it
 * one whose structs have fields more. It must get on as before, with defaults for what
 * it does not know, and nothing may be written behind its structs. Prints the size of
 * the config that it knows.
 */
#include <multisap.h>
#include <stdio.h>
#include <string.h>

#define must(condition) \
    do { \
        if (!(condition)) { \
            fprintf(stderr, "program_of_before: line %d: %s\n", __LINE__, #condition); \
            return 1; \
        } \
    } while (0)

static const unsigned char guard[64] = {0xA5, 0x5A, 0xC3, 0x3C};

/* Structs with something behind them. */
static struct {
    msap_config config;
    unsigned char behind[sizeof guard];
} known;
static struct {
    msap_world_stats stats;
    unsigned char behind[sizeof guard];
} asked;

int main(void)
{
    const float min[3] = {0, 0, 0}, max[3] = {1, 1, 1};
    msap_counts counts = {sizeof counts, 0, 0, 0, 0};
    msap_handle a, b;
    msap_world *world;
    memcpy(known.behind, guard, sizeof guard);
    memcpy(asked.behind, guard, sizeof guard);
    must(msap_config_init(&known.config, sizeof known.config) == MSAP_OK);
    must(memcmp(known.behind, guard, sizeof guard) == 0);
    must(known.config.struct_size == sizeof known.config && known.config.dims == 3);
    known.config.dims = 2;
    must(msap_create(&known.config, &world) == MSAP_OK);
    must(msap_add(world, min, max, 0, NULL, &a) == MSAP_OK && msap_add(world, min, max, 0, NULL, &b) == MSAP_OK);
    must(msap_commit(world, NULL, &counts) == MSAP_OK && counts.created == 1);
    asked.stats.struct_size = sizeof asked.stats;
    must(msap_stats(world, &asked.stats) == MSAP_OK);
    must(asked.stats.boxes == 2 && asked.stats.struct_size == sizeof asked.stats);
    must(memcmp(asked.behind, guard, sizeof guard) == 0);
    must(msap_destroy(world) == MSAP_OK);
    known.config.struct_size += 4; /* of no version */
    must(msap_create(&known.config, &world) == MSAP_ERROR_STRUCT_SIZE);
    must(msap_config_init(&known.config, sizeof known.config - 4) == MSAP_ERROR_STRUCT_SIZE);
    printf("%lu\n", (unsigned long)sizeof known.config);
    return 0;
}
