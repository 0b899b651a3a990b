# A particle game loop: particles fly about in a room, and two that meet swap their
# speeds. docs/python.md shows this program.
#
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT

import numpy as np

import multisap

N, WIDTH, ROOM = 1000, 0.5, 20
rng = np.random.default_rng(1)
lo = rng.random((N, 3), np.float32) * (ROOM - WIDTH)
speed = rng.random((N, 3), np.float32) - 0.5

with multisap.World() as world:
    ids = world.add(lo, lo + WIDTH, data=np.arange(N))
    for frame in range(5):
        events = world.commit()
        print(f"frame {frame}: {len(events.created)} pairs began, {len(events.deleted)} ended")
        a, b = world.user_data(events.created.ravel()).reshape(-1, 2).T
        speed[a], speed[b] = speed[b], speed[a]
        lo += speed
        outside = (lo < 0) | (lo > ROOM - WIDTH)
        speed[outside] *= -1
        world.update(ids, lo, lo + WIDTH)
