# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""What Python adds to the cost of a frame: moving boxes, a commit, and reading its events.

    python3 measure_commit.py [BOXES [FRAMES]]

Two worlds get the same boxes. One is driven as a user would, the other by the bare
functions of the library, with all arguments made beforehand. They take turns, frame by
frame, and the medians of their times are compared.
"""

import ctypes
import statistics
import sys
import time

import numpy as np

import multisap
from multisap import _api, _arrays
from multisap._library import lib


def frames(n, count):
    """Bounds of n boxes in motion; each overlaps few others, and each moves in each frame."""
    rng = np.random.default_rng(1)
    lo = (rng.random((n, 3)) * n ** (1 / 3) * 1.5).astype(np.float32)
    speed = rng.normal(0, 0.02, (n, 3)).astype(np.float32)
    for _ in range(count):
        yield lo.copy(), lo + 1
        lo += speed


def python_frame(world, ids, lo, hi):
    start = time.perf_counter()
    world.update(ids, lo, hi)
    events = world.commit()
    return time.perf_counter() - start, len(events.created), len(events.deleted)


def bare_frame(world, ids, lo, hi):
    boxes, n, keep = _arrays.boxes(lo, hi, 3)
    at, pairs = ctypes.byref(boxes), ctypes.byref(ctypes.c_void_p())
    created, deleted = ctypes.c_size_t(), ctypes.c_size_t()
    handles, n_created, n_deleted = _arrays.address(ids), ctypes.byref(created), ctypes.byref(deleted)
    start = time.perf_counter()
    lib.msap_update_many(world, n, handles, at)
    lib.msap_commit(world, None, None)
    lib.msap_created(world, pairs, n_created)
    lib.msap_deleted(world, pairs, n_deleted)
    return time.perf_counter() - start, created.value, deleted.value


def main(n=10000, count=300):
    one, other = multisap.World(), multisap.World()
    times = [], []
    ids = None
    for number, (lo, hi) in enumerate(frames(n, count)):
        if ids is None:
            ids = one.add(lo, hi)
            assert (other.add(lo, hi) == ids).all()
            for world in (one, other):
                world.commit()
            continue
        turns = [lambda: python_frame(one, ids, lo, hi), lambda: bare_frame(other._world, ids, lo, hi)]
        results = {turn: turns[turn]() for turn in ((0, 1) if number % 2 else (1, 0))}
        assert results[0][1:] == results[1][1:]
        for turn, result in results.items():
            times[turn].append(result[0])
    python, bare = map(statistics.median, times)
    print(f"{n} boxes, {count - 1} frames: Python {python * 1e3:.3f} ms, library {bare * 1e3:.3f} ms, "
          f"ratio {python / bare:.3f}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
