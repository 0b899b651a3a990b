# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Truncated, corrupt and hostile traces: one line that says where, exit status 1, no crash."""

import random
import resource
import struct

import pytest
from traces import addition, frame, removal, trace, update

NAN, INFINITY = float("nan"), float("inf")
MANY = 0xFFFFFFFF
TWO = frame(additions=[addition(0), addition(1)])


def write(multisap, data):
    path = multisap.folder / "bad.trace"
    path.write_bytes(data)
    return path


def refused(multisap, data):
    """What the complaint says after "multisap: FILE: "."""
    path = write(multisap, data)
    line = multisap.fail(1, "replay", "--answers", path)
    start = "multisap: %s: " % path
    assert line.startswith(start)
    return line[len(start):]


def low(axis, value):
    return [value if i == axis else 0 for i in range(3)]


def high(axis, value):
    return [value if i == axis else 1 for i in range(3)]


@pytest.mark.parametrize("bound, words", [(b, w) for w in ("min", "max") for b in range(3)])
def test_nan_is_refused(multisap, bound, words):
    bounds = {"low": low(bound, NAN)} if words == "min" else {"high": high(bound, NAN)}
    complaint = "(id 1): %s %s is NaN" % (words, "xyz"[bound])
    bad_addition = trace(frame(additions=[addition(0), addition(1, **bounds)]))
    assert refused(multisap, bad_addition) == "frame 0, addition 1 " + complaint
    bad_update = trace(TWO, frame(updates=[update(0), update(0), update(1, **bounds)]))
    assert refused(multisap, bad_update) == "frame 1, update 2 " + complaint


@pytest.mark.parametrize("bits", [0x7F800001, 0x7FC00000, 0x7FFFFFFF, 0xFF800001, 0xFFFFFFFF])
def test_nan_of_any_payload_is_refused(multisap, bits):
    data = trace(TWO)
    assert "min x is NaN" in refused(multisap, data[:-24] + struct.pack("<I", bits) + data[-20:])


@pytest.mark.parametrize("axis", range(3))
def test_min_above_max_is_refused(multisap, axis):
    bad = addition(1, low(axis, 1.0000001), high(axis, 1))
    letter = "xyz"[axis]
    assert (refused(multisap, trace(frame(additions=[addition(0), bad])))
            == "frame 0, addition 1 (id 1): min %s is above max %s" % (letter, letter))


def test_infinite_bounds_are_legal(multisap):
    boxes = [addition(0, (-INFINITY,) * 3, (INFINITY,) * 3), addition(1, (INFINITY,) * 3, (INFINITY,) * 3)]
    path = write(multisap, trace(frame(additions=boxes)))
    assert multisap.succeed("replay", "--answers", path).startswith("0 2 1 1 0 ")


@pytest.mark.parametrize("data, complaint", [
    (trace(frame(additions=[addition(0), addition(0)])),
     "frame 0, addition 1 (id 0): the box is there already"),
    (trace(TWO, frame(additions=[addition(1)])), "frame 1, addition 0 (id 1): the box is there already"),
    (trace(TWO, frame(updates=[update(2)])), "frame 1, update 0 (id 2): there is no such box"),
    (trace(TWO, frame(removals=[removal(2)])), "frame 1, removal 0 (id 2): there is no such box"),
    (trace(TWO, frame(removals=[removal(1), removal(1)])), "frame 1, removal 1 (id 1): there is no such box"),
    (trace(TWO, frame(removals=[removal(1)], updates=[update(1)])),
     "frame 1, update 0 (id 1): there is no such box"),
    (trace(frame(updates=[update(0)]), TWO), "frame 0, update 0 (id 0): there is no such box"),
    (trace(TWO, frame(removals=[removal(0)]), frame(updates=[update(0)])),
     "frame 2, update 0 (id 0): there is no such box"),
    (trace(TWO, max_ids=1), "frame 0, addition 1 (id 1): the id is not below max_ids"),
    (trace(TWO, frame(removals=[removal(100)])), "frame 1, removal 0 (id 100): the id is not below max_ids"),
    (trace(TWO, frame(updates=[update(MANY)])),
     "frame 1, update 0 (id 4294967295): the id is not below max_ids"),
    (trace(frame(additions=[addition(MANY)]), max_ids=MANY),
     "frame 0, addition 0 (id 4294967295): the id is not below max_ids"),
    (trace(frame(additions=[addition(0, (0, 0, 0), (1, 1, 1e-45))]), dims=2),
     "frame 0, addition 0 (id 0): z is not 0 in a 2D trace"),
    (trace(frame(additions=[addition(0, (0, 0, 0), (1, 1, 0))]),
           frame(updates=[update(0, (0, 0, -1), (1, 1, 0))]), dims=2),
     "frame 1, update 0 (id 0): z is not 0 in a 2D trace"),
    (trace(TWO, dims=1), "header: dims is 1, not 2 or 3"),
    (trace(TWO, dims=4), "header: dims is 4, not 2 or 3"),
    (trace(TWO, magic=b"SAPTRC02"), "not a scene trace: it does not begin with SAPTRC01"),
    (b"", "not a scene trace: it does not begin with SAPTRC01"),
    (trace(TWO) + b"x", "1 bytes are left over after the last of 1 frames"),
    (trace(TWO) + bytes(12), "12 bytes are left over after the last of 1 frames"),
    (trace(TWO, n_frames=0), "76 bytes are left over after the last of 0 frames")])
def test_illegal_records_are_refused(multisap, data, complaint):
    assert refused(multisap, data) == complaint


WHOLE = trace(TWO, frame(removals=[removal(1)], additions=[addition(1)], updates=[update(0), update(1)]))


def place_of_end(length):
    """Which record a file of the whole trace's first bytes breaks off in."""
    if length < 8:
        return "not a scene trace"
    if length < 44:
        return "the file ends in the header"
    marks = [(56, "frame 0 of 2"), (88, "frame 0, addition 0 of 2"), (120, "frame 0, addition 1 of 2"),
             (132, "frame 1 of 2"), (136, "frame 1, removal 0 of 1"), (168, "frame 1, addition 0 of 1"),
             (196, "frame 1, update 0 of 2"), (224, "frame 1, update 1 of 2")]
    return next(words + ": the file ends too early" for end, words in marks if length < end)


def test_truncation_at_every_byte(multisap):
    assert len(WHOLE) == 224
    assert multisap.succeed("replay", "--answers", write(multisap, WHOLE))
    for length in range(len(WHOLE)):
        complaint = refused(multisap, WHOLE[:length])
        assert complaint.startswith(place_of_end(length)), (length, complaint)


@pytest.mark.parametrize("counts, words", [
    ((MANY, 0, 0), "removal 16 of 4294967295"), ((0, MANY, 0), "addition 2 of 4294967295"),
    ((0, 0, MANY), "update 2 of 4294967295"), ((MANY, MANY, MANY), "removal 16 of 4294967295"),
    ((0x40000000, 0, 0), "removal 16 of 1073741824"),  # times 4 is 2^32
    ((0, 0x08000000, 0), "addition 2 of 134217728"),   # times 32 is 2^32
    ((0, 0, 0x09249250), "update 2 of 153391696"),     # times 28 is 2^32 + 1984
    ((0, 0x80000000, 0x80000000), "addition 2 of 2147483648")])
def test_counts_that_overflow_are_refused(multisap, counts, words):
    data = trace(frame(additions=[addition(0), addition(1)], counts=counts))
    assert refused(multisap, data).startswith("frame 0, %s: the file ends too early" % words)


def under_limit(multisap):
    """Keywords that run the command in 256 MB, if it can run at all in it (sanitizers need far more)."""
    def limit():
        resource.setrlimit(resource.RLIMIT_AS, (256 << 20, 256 << 20))
    keywords = {"preexec_fn": limit}
    return keywords if multisap.run("--version", **keywords).returncode == 0 else {}


def test_memory_does_not_follow_what_the_header_says(multisap):
    keywords = under_limit(multisap)
    path = write(multisap, trace(TWO, max_ids=MANY))
    assert multisap.succeed("replay", "--answers", path, **keywords).startswith("0 2 1 1 0 ")
    path = write(multisap, trace(TWO, n_frames=MANY))
    assert "frame 1 of 4294967295" in multisap.fail(1, "replay", path, **keywords)


def test_any_damage_ends_in_an_answer_or_a_complaint(multisap):
    rng = random.Random(1)
    for _ in range(300):
        data = bytearray(WHOLE)
        for _ in range(rng.randrange(1, 4)):
            data[rng.randrange(len(data))] = rng.choice([0, 1, 0x7F, 0x80, 0xFF, rng.randrange(256)])
        done = multisap.run("replay", "--answers", write(multisap, data))
        lines = done.stderr.count("\n")
        assert (done.returncode, lines) in [(0, 0), (1, 1)], (bytes(data), done)


def test_files_that_cannot_be_read(multisap):
    assert "cannot be opened: No such file" in multisap.fail(1, "replay", "nothing.trace")
    assert "cannot be read: Is a directory" in multisap.fail(1, "replay", multisap.folder)


def test_stream_refuses_them_too(multisap, with_lcm):
    assert "(id 0): the box is there already" in multisap.fail(
        1, "stream", write(multisap, trace(frame(additions=[addition(0), addition(0)]))))
    assert [path.name for path in multisap.folder.iterdir()] == ["bad.trace"]
