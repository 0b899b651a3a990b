# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Recorded scenes: reading a trace, replaying it through Python, and its answers.

The format is in the manual of the command multisap.
"""

import pathlib
from typing import NamedTuple

import numpy as np

import multisap

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "tests/scenes"

_HEAD = np.dtype([("magic", "S8"), ("frames", "<u4"), ("max_ids", "<u4"), ("dims", "<u4"), ("world", "<f4", 6)])
_COUNTS = np.dtype("<u4")
_REMOVED = np.dtype("<u4")
_ADDED = np.dtype([("id", "<u4"), ("flags", "<u4"), ("min", "<f4", 3), ("max", "<f4", 3)])
_MOVED = np.dtype([("id", "<u4"), ("min", "<f4", 3), ("max", "<f4", 3)])


class Frame(NamedTuple):
    removed: np.ndarray
    added: np.ndarray
    moved: np.ndarray


class Trace:
    def __init__(self, path):
        self._data = pathlib.Path(path).read_bytes()
        head = np.frombuffer(self._data, _HEAD, 1)[0]
        assert head["magic"] == b"SAPTRC01"
        self.frames, self.max_ids, self.dims = (int(head[name]) for name in ("frames", "max_ids", "dims"))

    def __iter__(self):
        at = _HEAD.itemsize
        for _ in range(self.frames):
            counts = np.frombuffer(self._data, _COUNTS, 3, at).tolist()
            at += 3 * _COUNTS.itemsize
            records = []
            for count, dtype in zip(counts, (_REMOVED, _ADDED, _MOVED)):
                records.append(np.frombuffer(self._data, dtype, count, at))
                at += count * dtype.itemsize
            yield Frame(*records)
        assert at == len(self._data)


def replay(trace, world):
    """Yields, for each frame, its Events and the trace's id by slot. Bounds go from the file's bytes
    to the library."""
    handle_of = np.zeros(trace.max_ids, np.uint64)
    id_of_slot = np.zeros(trace.max_ids * 2, np.uint64)
    dims = trace.dims
    for frame in trace:
        world.remove(handle_of[frame.removed])
        ids = world.add(frame.added["min"][:, :dims], frame.added["max"][:, :dims],
                        (frame.added["flags"] & 1).astype(bool))
        handle_of[frame.added["id"]] = ids
        id_of_slot[ids >> np.uint64(32)] = frame.added["id"]
        world.update(handle_of[frame.moved["id"]], frame.moved["min"][:, :dims], frame.moved["max"][:, :dims])
        yield world.commit(), id_of_slot


def _splitmix64(x):
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def _hash(pairs, id_of_slot):
    ids = np.sort(id_of_slot[np.asarray(pairs) >> np.uint64(32)], axis=1)
    return int(_splitmix64(ids[:, 0] << np.uint64(32) | ids[:, 1]).sum(dtype=np.uint64))


def answers(trace, world):
    """The lines that `multisap replay --answers` prints."""
    total, lines = 0, []
    for frame, (events, id_of_slot) in enumerate(replay(trace, world)):
        total += _hash(events.created, id_of_slot) - _hash(events.deleted, id_of_slot)
        lines.append(f"{frame} {world.stats().boxes} {events.active} {len(events.created)} "
                     f"{len(events.deleted)} {total % 2**64:016x}")
    return lines


def paths():
    return sorted(FOLDER.glob("*.trace"))


def answers_of(path):
    return path.with_suffix(".answers").read_text().splitlines()


def world_for(trace, **options):
    return multisap.World(trace.dims, **options)
