/* Measures the claims of the paper: all, or those that are named.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#include "bench.h"

#include <string.h>

static const struct {
    const char *name;
    void (*run)(void);
} claims[] = {{"axes", claim_axes},        {"batches", claim_batches}, {"pruning", claim_pruning},
              {"scaling", claim_scaling},  {"cells", claim_cells},     {"statics", claim_statics},
              {"parallel", claim_parallel}};

static int is_wanted(const char *name, int argc, char **argv)
{
    int wanted = argc < 2;
    for (int i = 1; i < argc; i++) wanted |= strcmp(argv[i], name) == 0;
    return wanted;
}

int main(int argc, char **argv)
{
    for (size_t i = 0; i < sizeof claims / sizeof *claims; i++)
        if (is_wanted(claims[i].name, argc, argv)) claims[i].run();
    return 0;
}
