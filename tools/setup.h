/* How a world is to be set up, as options say it.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef SETUP_H
#define SETUP_H

#include "../examples/thread_pool.h"
#include "trace.h"

#include <multisap.h>

typedef struct setup {
    msap_strategy strategy;
    msap_grid grid;
    uint32_t cells[2]; /* of MSAP_GRID_FIXED, over the two widest axes */
    float margin;
    unsigned long threads; /* the calling one included */
    thread_pool *pool;     /* of the others */
} setup;

/* What holds without options. */
void setup_init(setup *s);

/* Take an option's value: DONE, or MISUSED with a complaint. */
int setup_strategy(setup *s, const char *text);
int setup_cells(setup *s, const char *text);
int setup_margin(setup *s, const char *text);
int setup_threads(setup *s, const char *text);

/* Fills a config for worlds that replay a trace, and starts the threads: DONE, or
 * FAILED with a complaint. The config is good until setup_end. */
int setup_config(setup *s, const trace *t, msap_config *config);

/* Ends the threads, if there are any. */
void setup_end(setup *s);

#endif
