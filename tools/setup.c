/* From options to a config.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * A fixed grid lies over the two widest axes of the world bounds that the trace's
 * header hints at; boxes need not keep to them, the grid is wrapped. */
#include "setup.h"
#include "command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_CELLS = 4096, MOST_THREADS = 64 };

void setup_init(setup *s)
{
    memset(s, 0, sizeof *s);
    s->strategy = MSAP_STRATEGY_AUTO;
    s->grid = MSAP_GRID_AUTO;
    s->margin = MSAP_MARGIN_AUTO;
    s->threads = 1;
}

/* ------------------------------------------------------------------ options */

int setup_strategy(setup *s, const char *text)
{
    static const struct {
        const char *name;
        msap_strategy strategy;
    } known[] = {{"auto", MSAP_STRATEGY_AUTO},
                 {"slide", MSAP_STRATEGY_SLIDE},
                 {"merge", MSAP_STRATEGY_MERGE},
                 {"sweep", MSAP_STRATEGY_SWEEP}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(text, known[i].name) == 0) {
            s->strategy = known[i].strategy;
            return DONE;
        }
    return MISUSE("--strategy %s: not auto, slide, merge or sweep", text);
}

/* A number of cells: digits only. Leaves *text behind them; 0 if it is none or too large. */
static uint32_t take_cells(const char **text)
{
    char *end;
    unsigned long n = **text >= '0' && **text <= '9' ? strtoul(*text, &end, 10) : 0;
    if (n == 0 || n > MOST_CELLS)
        return 0;
    *text = end;
    return (uint32_t)n;
}

int setup_cells(setup *s, const char *text)
{
    const char *at = text;
    s->grid = strcmp(text, "auto") == 0 ? MSAP_GRID_AUTO
              : strcmp(text, "1") == 0  ? MSAP_GRID_NONE
                                        : MSAP_GRID_FIXED;
    if (s->grid != MSAP_GRID_FIXED)
        return DONE;
    s->cells[0] = take_cells(&at);
    if (s->cells[0] && *at++ == 'x') {
        s->cells[1] = take_cells(&at);
        if (s->cells[1] && *at == '\0')
            return DONE;
    }
    return MISUSE("--cells %s: not auto, 1 or NxM, with N and M from 1 to %d", text, MOST_CELLS);
}

int setup_margin(setup *s, const char *text)
{
    char *end;
    s->margin = MSAP_MARGIN_AUTO;
    if (strcmp(text, "auto") == 0)
        return DONE;
    s->margin = strtof(text, &end);
    if (end == text || *end != '\0' || !isfinite(s->margin) || s->margin < 0)
        return MISUSE("--margin %s: not auto or a number from 0 on", text);
    return DONE;
}

int setup_threads(setup *s, const char *text)
{
    return parse_count("--threads", text, 1, MOST_THREADS, &s->threads);
}

/* ----------------------------------------------------------------- a config */

/* In double the widths of finite floats are finite. */
static double width_of(const trace *t, uint32_t axis)
{
    return (double)t->world_max[axis] - t->world_min[axis];
}

/* The two widest axes of a trace, in ascending order. */
static void widest_axes(const trace *t, uint32_t axis[2])
{
    uint32_t narrowest = 2;
    for (uint32_t k = 2; k-- > 0 && t->dims == 3;)
        if (width_of(t, k) < width_of(t, narrowest))
            narrowest = k;
    axis[0] = narrowest == 0;
    axis[1] = narrowest == 2 ? 1 : 2;
}

static int bad_hint(const trace *t, uint32_t axis, const char *why)
{
    return FAIL("%s: no grid of cells: the header's world bounds on axis %c, %g to %g, %s", t->path,
                "xyz"[axis], (double)t->world_min[axis], (double)t->world_max[axis], why);
}

static int check_hint(const trace *t)
{
    for (uint32_t k = 0; k < t->dims; k++) {
        if (!isfinite(t->world_min[k]) || !isfinite(t->world_max[k]))
            return bad_hint(t, k, "are not finite");
        if (t->world_min[k] > t->world_max[k])
            return bad_hint(t, k, "are inverted");
    }
    return DONE;
}

static int fixed_grid(const setup *s, const trace *t, msap_config *config)
{
    uint32_t axis[2];
    if (s->cells[0] == 1 && s->cells[1] == 1)
        return DONE;
    if (check_hint(t))
        return FAILED;
    widest_axes(t, axis);
    for (int i = 0; i < 2; i++) {
        uint32_t k = axis[i];
        if (s->cells[i] > 1 && width_of(t, k) == 0)
            return bad_hint(t, k, "have no width");
        config->grid_cells[k] = s->cells[i];
        config->grid_min[k] = t->world_min[k];
        config->grid_max[k] = t->world_max[k];
    }
    return DONE;
}

static int start_threads(setup *s, msap_config *config)
{
    if (s->threads == 1)
        return DONE;
    if (!s->pool)
        s->pool = thread_pool_create((unsigned)s->threads - 1);
    if (!s->pool)
        return FAIL("no memory for %lu threads", s->threads);
    config->workers = (uint32_t)s->threads;
    config->enqueue = thread_pool_enqueue;
    config->finish = thread_pool_finish;
    config->jobs_user = s->pool;
    return DONE;
}

int setup_config(setup *s, const trace *t, msap_config *config)
{
    msap_config_init(config, sizeof *config);
    config->strategy = s->strategy;
    config->grid = s->grid;
    config->margin = s->margin;
    if (s->grid == MSAP_GRID_FIXED && fixed_grid(s, t, config))
        return FAILED;
    return start_threads(s, config);
}

void setup_end(setup *s)
{
    thread_pool_destroy(s->pool);
    s->pool = NULL;
}
