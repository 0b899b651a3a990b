/* Scenes: recorded ones from traces, and generated ones at any distance from the origin.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 */
#ifndef SCENE_H
#define SCENE_H

#include "mode.h"

/* The scene of a file NAME.trace; or a generated one: drift, pile or few, with or
 * without @DISTANCE. It lives as long as the program. */
scene scene_of(const char *name);

#endif
