/* Harness: the bytes are a message of a pair-event stream as it comes from the
 * network. What msap_lcm_check lets through, and only that, lcm-gen's code decodes,
 * and encodes to the same bytes again.
 *
 * SPDX-FileCopyrightText: 2026 the multisap authors
 * SPDX-License-Identifier: MIT
 *
 * So that not every input fails at the fingerprint, one that begins with a byte below
 * 128 is read as a message without its fingerprint.
 */
#include "fuzz.h"

#include "msap_pair_events_t.h"
#include "multisap_lcm.h"

#include <stdlib.h>
#include <string.h>

/* Whether the message says what the type's rules let it say. */
static int is_sound(const msap_pair_events_t *m)
{
    int is_events = m->kind == MSAP_PAIR_EVENTS_T_EVENTS, is_snapshot = m->kind == MSAP_PAIR_EVENTS_T_SNAPSHOT;
    return (is_events || (is_snapshot && m->base == 0 && m->n_deleted == 0)) && m->base >= 0 && m->base < m->seq &&
           m->part >= 0 && m->part < m->parts && m->n_deleted >= 0 && m->n_created >= 0 &&
           m->n_created <= m->pairs;
}

static void decode(const uint8_t *bytes, size_t size)
{
    msap_pair_events_t message;
    uint8_t *again = malloc(size);
    int used = msap_pair_events_t_decode(bytes, 0, (int)size, &message);
    if (used != (int)size)
        fuzz_check("a message that passed the check could not be decoded");
    if (!is_sound(&message))
        fuzz_check("a message that passed the check breaks the rules");
    if (!again || msap_pair_events_t_encode(again, 0, (int)size, &message) != (int)size ||
        memcmp(bytes, again, size) != 0)
        fuzz_check("a message is another when it is encoded again");
    msap_pair_events_t_decode_cleanup(&message);
    free(again);
}

static void receive(const uint8_t *bytes, size_t size)
{
    msap_lcm_status status = msap_lcm_check(bytes, size);
    if (status == MSAP_LCM_OK)
        decode(bytes, size);
    else if (status != MSAP_LCM_ERROR_FINGERPRINT && status != MSAP_LCM_ERROR_MESSAGE)
        fuzz_check("the check came to a status that is not its own");
    if (!*msap_lcm_status_text(status) || !*msap_lcm_status_text((msap_lcm_status)size))
        fuzz_check("a status has no text");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    uint64_t fingerprint = MSAP_LCM_FINGERPRINT;
    uint8_t *bytes;
    int i;
    if (size == 0 || data[0] >= 128) {
        receive(data, size);
        return 0;
    }
    bytes = malloc(size + 7);
    if (!bytes)
        fuzz_check("there is no memory");
    for (i = 0; i < 8; i++)
        bytes[i] = (uint8_t)(fingerprint >> (56 - 8 * i));
    memcpy(bytes + 8, data + 1, size - 1);
    receive(bytes, size + 7);
    free(bytes);
    return 0;
}
