# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Writes and reads scene traces, independently of the command (docs/multisap.1 has the format)."""

import struct

STATIC = 1


def removal(box):
    return struct.pack("<I", box)


def addition(box, low=(0, 0, 0), high=(1, 1, 1), flags=0):
    return struct.pack("<II6f", box, flags, *low, *high)


def update(box, low=(0, 0, 0), high=(1, 1, 1)):
    return struct.pack("<I6f", box, *low, *high)


def frame(removals=(), additions=(), updates=(), counts=None):
    """A frame; `counts` in place of the true ones, to tell lies."""
    counts = counts or (len(removals), len(additions), len(updates))
    return struct.pack("<3I", *counts) + b"".join((*removals, *additions, *updates))


def trace(*frames, max_ids=100, dims=3, n_frames=None, magic=b"SAPTRC01"):
    n_frames = len(frames) if n_frames is None else n_frames
    return magic + struct.pack("<3I6f", n_frames, max_ids, dims, 0, 0, 0, 1, 1, 1) + b"".join(frames)


def read_ids(data):
    """Of each frame the ids that are removed and those that are added."""
    n_frames, at = struct.unpack_from("<I", data, 8)[0], 44
    for _ in range(n_frames):
        n_remove, n_add, n_update = struct.unpack_from("<3I", data, at)
        at += 12
        removed = struct.unpack_from("<%dI" % n_remove, data, at)
        at += 4 * n_remove
        added = [struct.unpack_from("<I", data, at + 32 * i)[0] for i in range(n_add)]
        at += 32 * n_add + 28 * n_update
        yield removed, added


def splitmix64(x):
    mask = (1 << 64) - 1
    x = (x + 0x9E3779B97F4A7C15) & mask
    x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & mask
    x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & mask
    return x ^ (x >> 31)
