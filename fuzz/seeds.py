#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Writes the structured seeds, fuzz/corpus/HARNESS/seed-NAME: inputs that mean something.

scene.c says what the bytes of a scene are. A seed is a set-up and a story that is told
in it; a trace and a message are what tools/trace.c and pair_events_t.lcm describe.
"""

import pathlib
import struct

CORPUS = pathlib.Path(__file__).resolve().parent / "corpus"

# ------------------------------------------------------------------- scenes

# The place of a call in take_call's table; a layout is added 18 times.
ADD, ADD_MANY, UPDATE, COMMIT, UPDATE_MANY, REMOVE, REMOVE_MANY, SHIFT, TRIM, DATA, WRONG, OTHER = (
    0, 2, 4, 6, 7, 9, 10, 11, 12, 15, 16, 17)
GRID, SPREAD, HARD, SIZES = range(4)
IN_ROW, BY_COMPONENT, DOUBLES = range(3)


def call(kind, layout=IN_ROW):
    return bytes([kind + 18 * layout])


def source(scene, exponent=0, seed=1):
    """The exponent is a place in take_source's table."""
    return bytes([scene + 4 * exponent]) + struct.pack("<H", seed)


def add_many(count, scene=GRID, exponent=0, seed=1, statics=32, layout=IN_ROW):
    return call(ADD_MANY, layout) + source(scene, exponent, seed) + bytes([statics]) + struct.pack("<H", count)


def add_crowd(count, places, seed):
    """More than 255, as MANY in scene.c has it, into a world that has so many places left."""
    return add_many(0xF000 + (count - 0xF000) % (places + 1), SPREAD, seed=seed)


def update_many(how, share=255, scene=GRID, exponent=0, seed=7, layout=IN_ROW):
    """how: 0 to anywhere, 1 a step, 2 a part of the size; and 4: one box twice."""
    return call(UPDATE_MANY, layout) + source(scene, exponent, seed) + bytes([how, share])


def remove_many(share, seed=3):
    return call(REMOVE_MANY) + bytes([seed, share])


def shift(kind, *values):
    return call(SHIFT) + bytes([kind, *values])


def commit(how=0):
    return call(COMMIT) + bytes([how])


def other(argument):
    return call(OTHER) + struct.pack("<H", argument)


def wrong(argument):
    return call(WRONG) + struct.pack("<H", argument)


def box(*six):
    """By numbers at which something happens: places in take_hard's table, twice, plus the sign."""
    return bytes([1, *six])


STORIES = {
    "coming": add_many(30) + commit() + add_many(20, SPREAD) + commit(1) + add_many(9, HARD) + commit(2),
    "steps": add_many(60) + b"".join(update_many(1, seed=i) + commit() for i in range(8)),
    "drift": add_many(60, SPREAD) + b"".join(update_many(2, 200, seed=3) + commit(1) for _ in range(12)),
    "jumps": add_many(75, SPREAD) + b"".join(update_many(0, scene=SPREAD, seed=i) + commit() for i in range(5)),
    "going": add_many(60) + commit() + remove_many(99) + commit() + add_many(30) + remove_many(255) + commit()
             + add_many(10) + commit(),
    "sizes": add_many(70, SIZES) + commit() + update_many(1, 99, SIZES) + commit() + remove_many(50) + commit(),
    "hard": add_many(60, HARD) + commit() + update_many(0, 255, HARD) + commit() + update_many(4, 90, HARD) + commit(),
    "huge": add_many(24, GRID, 9) + commit() + update_many(2) + commit() + add_many(40, SPREAD, 7) + commit(),
    "tiny": add_many(60, GRID, 11) + commit() + update_many(2) + commit() + update_many(0, 255, GRID, 10) + commit(),
    "shift": add_many(40, GRID) + commit() + shift(0, 130, 1, 128) + commit() + shift(1, 8, 20, 30) + commit()
             + shift(2, *struct.pack("<3d", 0.1, -1e-30, 1e30)) + commit(),
    "trim": add_many(70) + commit() + remove_many(230) + commit() + call(TRIM) + add_many(30) + call(TRIM) + commit()
            + call(TRIM) + commit(),
    "layouts": add_many(20, layout=BY_COMPONENT) + add_many(20, layout=DOUBLES) + commit()
               + update_many(0, layout=DOUBLES) + commit() + update_many(0, layout=BY_COMPONENT) + commit(),
    "single": (call(ADD) + b"\1" + box(0, 2, 4, 6, 8, 10) + call(ADD) + b"\0" + box(33, 32, 31, 30, 1, 0) + commit()
               + call(UPDATE) + b"\0\0" + box(32, 33, 32, 33, 32, 33) + commit() + call(REMOVE) + b"\1\0" + commit()),
    "data": add_many(20) + commit() + commit(1) + b"".join(call(DATA) + bytes([i, 3 * i]) for i in range(8)) + commit(2),
    "inside": add_many(30) + b"".join(commit(8 * i + 5) + update_many(1, seed=i) for i in range(12)),
    "wrong": add_many(12) + commit() + remove_many(60) + commit()
             + b"".join(wrong(i * 0x9D % 256 + (i % 7 << 8)) for i in range(42)) + commit(),
    "memory": b"".join(other(4 * i + i % 4) + add_many(6 + i, seed=i) + update_many(i % 3) + other(4 * i + 1) + commit()
                       for i in range(9)),
    "trouble": b"".join(other(8 * i + i % 8) + add_many(90 * i, SPREAD, seed=i) + update_many(i % 3, seed=i) + commit()
                        for i in range(1, 8)),
}

# kind, workers, margin, width [cells, low, size on each axis], as take_config reads them
SETUPS = {
    "auto": bytes([0, 0, 0, 0]),
    "single": bytes([1, 0, 0, 0]),
    "fixed": bytes([2, 0, 0, 0, 4, 0, 0, 4, 0, 0, 1, 0, 0]),
    "slide": bytes([3, 0, 3, 0]),
    "merge": bytes([6, 0, 2, 2]),
    "sweep": bytes([9, 0, 0, 0]),
    "single-slide": bytes([4, 0, 0, 0]),
    "single-merge": bytes([7 + 12, 0, 0, 0]),
    "single-sweep": bytes([10, 2, 0, 0]),
    "portable": bytes([24, 0, 0, 0]),
    "workers": bytes([0, 3, 0, 0]),
    "late": bytes([96 + 6, 4, 4, 0]),
}


def scenes():
    """Every story in a few set-ups, and every set-up in a few stories."""
    for i, (story, told) in enumerate(STORIES.items()):
        for j, (setup, config) in enumerate(SETUPS.items()):
            if (i + j) % 5 == 0:
                yield f"{story}-{setup}", bytes([(i + j) % 2]) + config + told


def streams():
    """Stories with snapshots, losses and commits that are left out."""
    trouble = [other(1 | 0b1010110 << 2), other(0), other(2 | 2 << 2), other(3)]
    for i, (story, told) in enumerate(STORIES.items()):
        parts = told.split(commit())
        told = b"".join(part + commit() + trouble[(i + j) % 4] for j, part in enumerate(parts))
        yield story, bytes([i % 2 | 2 * (i % 5) | 16 * (i % 7)]) + SETUPS["auto"] + told
    crowd = add_many(120, GRID, 8) + commit() + update_many(0, 255, SPREAD) + commit()
    yield "parts", bytes([3]) + SETUPS["auto"] + crowd + other(1 | 2 << 2) + update_many(0, 255, GRID, 8) + commit()


def contests():
    """The same for three set-ups at once, with more boxes."""
    setups = list(SETUPS.values())
    for i, (story, told) in enumerate(STORIES.items()):
        three = setups[i % len(setups)] + setups[(i + 4) % len(setups)] + setups[(i + 7) % len(setups)]
        crowd = add_crowd(600, 1200, i) if story in ("steps", "jumps", "going", "trouble", "trim") else b""
        yield story, bytes([i % 2]) + three + crowd + told
    crowded = add_crowd(1040, 1200, 5) + commit() + remove_many(250) + commit()
    for i in (0, 1):
        yield f"rest{i}", (b"\0" + setups[i] + setups[i + 4] + setups[i + 7] + crowded + other(8 * 5 + i) + other(3)
                          + add_many(50) + commit())


# ------------------------------------------------------------------ numbers

def bounds():
    """what % 8: 0 encoding, 1 shift, 2 or 3 commit, else boxes; as fuzz_bounds.c reads them."""
    start = b"\0" + SETUPS["auto"]
    floats = [0, 1, 0x80000000, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0xFFC00000, 0x00800000, 0x3F800000]
    yield "encoding", start + b"".join(b"\x08" + struct.pack("<I", f) for f in floats)
    yield "floats", start + b"".join(bytes([4, 12, 8 + i % 4]) + bytes(range(i, i + 24)) for i in range(6)) + b"\2"
    yield "doubles", start + b"".join(
        bytes([4, 1 + 4 * i, 9]) + struct.pack("<6d", -0.1 * i, 1e-40, 1e39, 0.1, 1e-320, 1.7e308) for i in range(4)) + b"\3"
    yield "shift", start + b"".join(
        bytes([4, 0, 8, *range(6 * i, 6 * i + 6)]) for i in range(4)) + b"\2\1\2" + bytes(6) + b"\2\1\1" + struct.pack(
            "<3d", 0.1, 3e38, -1e-45) + b"\3"


def prune():
    """how, [failing allocation], two sets of boxes, spoiled bounds; as fuzz_prune.c reads them."""
    for how in range(16):
        yield f"how{how}", bytes([how]) + bytes([how % 4, how, 0, 40 + 8 * how]) + bytes([(how + 1) % 4, 9, 9, 100])
    for how in (8, 9, 8 + 64, 9 + 128):
        yield f"touching{how}", bytes([how]) + bytes([GRID, 1, 0, 60]) + bytes([GRID, 2, 0, 60])
    yield "failing", bytes([16, 3]) + bytes([0, 1, 0, 150]) + bytes([1, 2, 0, 150])
    yield "limit", bytes([32 + 8, 0, 8]) + bytes([0, 1, 0, 150]) + bytes([1, 2, 0, 150])
    yield "nan", bytes([0]) + bytes([1, 1, 0, 50]) + bytes([1, 2, 0, 50]) + bytes([1, 7, 4]) + struct.pack("<f", float("nan"))


# ------------------------------------------------------------------- traces

def trace_of(frames, max_ids=16, dims=3):
    out = b"SAPTRC01" + struct.pack("<3I6f", len(frames), max_ids, dims, 0, 0, 0, 9, 9, 9)
    for removed, added, updated in frames:
        out += struct.pack("<3I", len(removed), len(added), len(updated))
        out += b"".join(struct.pack("<I", i) for i in removed)
        out += b"".join(struct.pack("<2I6f", i, flags, *six) for i, flags, six in added)
        out += b"".join(struct.pack("<I6f", i, *six) for i, six in updated)
    return out


def cube(low, size=1.0):
    return [low] * 3 + [low + size] * 3


def traces():
    inf, nan = float("inf"), float("nan")
    flat = [0, 0, 0, 1, 1, 0]
    yield "empty", trace_of([])
    yield "one", trace_of([([], [(0, 0, cube(0)), (1, 1, cube(0.5))], [(0, cube(3))])])
    yield "life", trace_of([([], [(i, i & 1, cube(i)) for i in range(8)], []), ([1, 3], [(3, 0, cube(1))], [(0, cube(2))]),
                            ([], [], []), ([0, 2, 4], [], [(5, cube(6)), (5, cube(7))])])
    yield "flat", trace_of([([], [(5, 0, flat), (2, 0, flat)], []), ([5], [], [(2, [2, 2, 0, 3, 3, 0])])], dims=2)
    yield "infinite", trace_of([([], [(0, 0, [-inf] * 3 + [inf] * 3), (1, 0, [inf] * 6), (2, 0, cube(-0.0, 0))], [])])
    yield "nan", trace_of([([], [(0, 0, [0, nan, 0, 1, 1, 1])], [])])
    yield "inverted", trace_of([([], [(0, 0, [2, 0, 0, 1, 1, 1])], [])])
    yield "no-such-box", trace_of([([4], [], [])])
    yield "large-id", trace_of([([], [(4000000000, 0, cube(0))], [])], max_ids=0xFFFFFFFF)
    yield "cut", trace_of([([], [(0, 0, cube(0))], [])])[:-5]
    yield "one-axis", trace_of([([], [(0, 0, cube(0))], [])], dims=1)
    yield "four-axes", trace_of([([], [(0, 0, cube(0))], [])], dims=4)
    yield "twice-there", trace_of([([], [(0, 0, cube(0)), (0, 0, cube(1))], [])])
    yield "twice-gone", trace_of([([], [(0, 0, cube(0))], []), ([0, 0], [], [])])
    yield "gone-and-moved", trace_of([([], [(0, 0, cube(0))], []), ([0], [], [(0, cube(1))])])
    yield "flags", trace_of([([], [(0, 2, cube(0))], [])])
    yield "left-over", trace_of([([], [(0, 0, cube(0))], [])]) + b"\0\0"


# ----------------------------------------------------------------- messages

def message(kind=0, seq=5, base=4, pairs=9, part=0, parts=1, deleted=(), created=(), counts=None):
    counts = counts or (len(deleted), len(created))
    words = [pair[side] for pairs_ in (deleted, created) for side in (0, 1) for pair in pairs_]
    return struct.pack(">6q5i", 1, 2, seq, base, pairs, 77, kind, part, parts, *counts) + struct.pack(f">{len(words)}q", *words)


def messages():
    some = [(1 << 32 | 1, 2 << 32 | 1), (1 << 32 | 1, 3 << 32 | 4)]
    # without the fingerprint, behind a byte that says so
    yield "events", b"\0" + message(deleted=some[:1], created=some)
    yield "snapshot", b"\0" + message(kind=1, base=0, created=some)
    yield "quiet", b"\0" + message()
    yield "part", b"\0" + message(part=2, parts=3, created=some)
    yield "too-many", b"\0" + message(counts=(1 << 30, 1 << 30))
    yield "negative", b"\0" + message(counts=(-1, 1))
    yield "more-than-all", b"\0" + message(pairs=1, created=some)
    yield "base-below", b"\0" + message(base=-1)
    yield "base-of-later", b"\0" + message(base=5)
    yield "part-below", b"\0" + message(part=-1)
    yield "part-beyond", b"\0" + message(part=3, parts=3)
    yield "kind", b"\0" + message(kind=2)
    yield "snapshot-of-later", b"\0" + message(kind=1, base=1, created=some)
    yield "snapshot-deletes", b"\0" + message(kind=1, base=0, deleted=some)
    yield "longer", b"\0" + message(created=some) + b"\0"
    yield "stranger", struct.pack(">Q", 0xAF4CBFD932BEEDAC) + message()


def main():
    for harness, seeds in (("api", scenes()), ("alloc", scenes()), ("setups", contests()), ("bounds", bounds()),
                           ("prune", prune()), ("trace", traces()), ("lcm", messages()), ("stream", streams())):
        folder = CORPUS / harness
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("seed-*"):
            old.unlink()
        for name, seed in seeds:
            (folder / f"seed-{name}").write_bytes(seed)


if __name__ == "__main__":
    main()
