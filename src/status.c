/* Status texts and the version.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT */
#include "internal.h"

static const char *const texts[MSAP_STATUS_COUNT] = {
    "no error",
    "a pointer is NULL that must not be",
    "a struct_size is none that this library knows",
    "a field or argument holds a value that is not allowed",
    "out of memory",
    "a bound is not a number",
    "a min is above its max",
    "the handle is null, stale or garbage",
    "the world holds as many boxes or pairs as it can",
    "the world is in use: called from inside a callback or while another call runs",
    "the boxes were no pair at the last commit",
    "an invariant of the world is broken",
};

const char *msap_status_text(msap_status status)
{
    unsigned number = (unsigned)status;
    return number < MSAP_STATUS_COUNT ? texts[number] : "not a status of this version";
}

#define TEXT_OF(number) #number
#define TEXT(number) TEXT_OF(number)

uint32_t msap_version(void) { return MSAP_VERSION_NUMBER; }

const char *msap_version_text(void)
{
    return TEXT(MSAP_VERSION_MAJOR) "." TEXT(MSAP_VERSION_MINOR) "." TEXT(MSAP_VERSION_PATCH);
}
