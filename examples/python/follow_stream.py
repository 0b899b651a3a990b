# Follows the pair events of a robot: live, given a URL of LCM, or from a log, given a
# file. Needs multisap[lcm]. docs/python.md shows this program.
#
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT

import sys

import multisap.lcm


def follow(place):
    if "://" in place:
        return multisap.lcm.subscribe("MSAP_EVENTS", place, timeout=10)
    return multisap.lcm.read_log(place)


touching = set()
for events in follow(sys.argv[1]):
    if events.since == 0:
        touching.clear()
    touching.difference_update(events.deleted)
    touching.update(events.created)
    if len(events.created) > 70:
        print(f"commit {events.seq}: {len(events.created)} pairs began, {len(touching)} overlap now")
