# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""multisap stream: its logs, decoded here and by LCM's own tools, give the answers of the scene."""

import itertools
import resource
import shutil
import signal
import struct
import subprocess
import sys

import pytest
from conftest import ROOT
from traces import addition, frame, read_ids, splitmix64, trace, update

# fingerprint; utime, epoch, seq, base, pairs, checksum; kind, part, parts, n_deleted, n_created
HEAD = ">Q6q5i"
FINGERPRINT = 0xAF4CBFD932BEEDAD
EVENTS = 0
LCM_TYPE = ROOT / "bindings" / "lcm" / "pair_events_t.lcm"
LCM_GEN = shutil.which("lcm-gen", path="/usr/bin") or shutil.which("lcm-gen")
LCM_PLAYER = shutil.which("lcm-logplayer", path="/usr/bin") or shutil.which("lcm-logplayer")


class Message:
    """A pair_events_t, decoded from its bytes."""

    def __init__(self, data):
        (fingerprint, self.utime, self.epoch, self.seq, self.base, self.pairs, self.checksum, self.kind,
         self.part, self.parts, n_deleted, n_created) = struct.unpack_from(HEAD, data)
        assert fingerprint == FINGERPRINT
        assert len(data) == struct.calcsize(HEAD) + 16 * (n_deleted + n_created) <= 60000
        rest = struct.unpack_from(">%dq" % (2 * (n_deleted + n_created)), data, struct.calcsize(HEAD))
        cut = 2 * n_deleted
        self.deleted = list(zip(rest[:n_deleted], rest[n_deleted:cut]))
        self.created = list(zip(rest[cut:cut + n_created], rest[cut + n_created:]))


def read_log(path):
    """Channel and data of each event of an LCM log."""
    data, at, number = path.read_bytes(), 0, 0
    while at < len(data):
        sync, event, _, channel_length, length = struct.unpack_from(">IqqII", data, at)
        assert (sync, event) == (0xEDA1DA01, number)
        at += 28
        channel = data[at:at + channel_length].decode()
        at += channel_length
        yield channel, data[at:at + length]
        at += length
        number += 1


@pytest.fixture
def stream(multisap, with_lcm):
    """Streams a trace into a log and returns the command's report and its messages."""
    def run(path, *options, log=None):
        report = multisap.succeed("stream", *options, path)
        events = list(read_log(multisap.folder / (log or path.stem + ".lcmlog")))
        assert {channel for channel, _ in events} <= {"MSAP_EVENTS"}
        return report, [Message(data) for _, data in events]
    return run


def handles_by_id(data):
    """By frame: the trace id of each handle that ever was, as the library must give handles."""
    generations, free, handle_of, id_of = [], [], {}, {}
    for removed, added in read_ids(data):
        freed = [handle_of.pop(box) >> 32 for box in removed]
        for box in added:
            if not free:
                generations.append(0)
                free.append(len(generations) - 1)
            slot = free.pop(0)
            generations[slot] += 1
            handle_of[box] = slot << 32 | generations[slot]
            id_of[handle_of[box]] = box
        free += freed
        yield id_of


def answer(number, live, active, created, deleted, id_of):
    ids = (sorted((id_of[a], id_of[b])) for a, b in active)
    total = sum(splitmix64(low << 32 | high) for low, high in ids) % 2**64
    return "%d %d %d %d %d %016x\n" % (number, live, len(active), created, deleted, total)


def answers_of(data, messages, live_of):
    """The lines of an .answers file, from the messages alone; live_of has the boxes of each frame."""
    active, lines = set(), []
    groups = [list(group) for _, group in itertools.groupby(messages, lambda message: message.seq)]
    for number, (parts, id_of) in enumerate(zip(groups, handles_by_id(data))):
        deleted = [pair for part in parts for pair in part.deleted]
        created = [pair for part in parts for pair in part.created]
        assert deleted == sorted(set(deleted)) and created == sorted(set(created))
        assert all(0 < a < b for a, b in deleted + created)
        assert active.issuperset(deleted)
        active.difference_update(deleted)
        assert active.isdisjoint(created)
        active.update(created)
        checksum = sum(splitmix64(splitmix64(a) ^ b) for a, b in active) % 2**64
        for part, message in enumerate(parts):
            assert (message.seq, message.base, message.kind) == (number + 1, number, EVENTS)
            assert (message.part, message.parts) == (part, len(parts))
            assert message.pairs == len(active)
            assert message.checksum % 2**64 == checksum
            assert message.utime == number * 1000000 // 60
        lines.append(answer(number, live_of[number], active, len(created), len(deleted), id_of))
    assert len(lines) == len(groups) == len(live_of)
    return "".join(lines)


def live_boxes(answers):
    return [int(line.split()[1]) for line in answers.splitlines()]


def test_the_log_of_a_scene_gives_its_answers(stream, scene):
    _, messages = stream(scene)
    answers = scene.with_suffix(".answers").read_text()
    assert answers_of(scene.read_bytes(), messages, live_boxes(answers)) == answers
    assert len({message.epoch for message in messages}) == 1 and messages[0].epoch > 0


def test_many_events_go_out_in_parts(stream, multisap):
    n = 130  # all overlap: 8385 pairs, three messages
    boxes = [addition(i, (i / 1000, 0, 0)) for i in range(n)]
    apart = [update(i, (10 * i, 0, 0), (10 * i + 1, 1, 1)) for i in range(n)]
    path = multisap.folder / "crowd.trace"
    path.write_bytes(trace(frame(additions=boxes), frame(updates=apart), frame(), max_ids=n))
    _, messages = stream(path)
    pairs = n * (n - 1) // 2
    assert [(m.seq, m.part, m.parts) for m in messages] == [
        (1, 0, 3), (1, 1, 3), (1, 2, 3), (2, 0, 3), (2, 1, 3), (2, 2, 3), (3, 0, 1)]
    assert [sum(len(m.created) for m in messages if m.seq == seq) for seq in (1, 2, 3)] == [pairs, 0, 0]
    assert [sum(len(m.deleted) for m in messages if m.seq == seq) for seq in (1, 2, 3)] == [0, pairs, 0]
    assert answers_of(path.read_bytes(), messages, [n] * 3).splitlines()[2] == "2 %d 0 0 0 %016x" % (n, 0)


def test_the_report_says_what_was_sent(stream, scene, multisap):
    report, messages = stream(scene)
    text = scene.with_suffix(".answers").read_text()
    answers = [list(map(int, line.split()[1:5])) for line in text.splitlines()]
    events = [created + deleted for _, _, created, deleted in answers]
    lines = report.splitlines()
    assert lines[1] == "boxes   %d at most" % max(row[0] for row in answers)
    assert lines[2] == "pairs   %d at most" % max(row[1] for row in answers)
    assert lines[3] == "events  %d in the first frame, then %.1f a frame, %d at most" % (
        events[0], sum(events[1:]) / (len(events) - 1), max(events[1:]))
    assert lines[5].startswith("sent    %d messages, " % len(messages))
    assert lines[5].endswith(" on channel MSAP_EVENTS to %s.lcmlog" % scene.stem)


def test_a_log_is_overwritten_and_another_is_appended_to(stream, multisap):
    path = multisap.folder / "small.trace"
    path.write_bytes(trace(frame(additions=[addition(0), addition(1)]), frame()))
    assert len(stream(path)[1]) == 2
    assert len(stream(path)[1]) == 2
    log = "log with a space & more"
    assert len(stream(path, "--url", "file://%s?mode=w" % log, log=log)[1]) == 2
    multisap.succeed("stream", "--url", "file://%s?mode=a" % log, path)
    size = len((multisap.folder / log).read_bytes())
    assert size == 2 * len((multisap.folder / "small.lcmlog").read_bytes())


def test_rate_sets_the_time_of_frames(stream, multisap):
    path = multisap.folder / "small.trace"
    path.write_bytes(trace(*[frame()] * 4))
    _, messages = stream(path, "--rate", "500")
    assert [message.utime for message in messages] == [0, 2000, 4000, 6000]


def test_channels(stream, multisap):
    path = multisap.folder / "small.trace"
    path.write_bytes(trace(frame()))
    stream(path)
    multisap.succeed("stream", "--channel", "C" * 63, path)
    assert [channel for channel, _ in read_log(multisap.folder / "small.lcmlog")] == ["C" * 63]
    assert "not 1 to 63 bytes" in multisap.fail(2, "stream", "--channel", "C" * 64, path)
    assert "not 1 to 63 bytes" in multisap.fail(2, "stream", "--channel", "", path)


@pytest.mark.parametrize("rate", ["0", "-60", "fast", "nan", "inf", "60Hz", ""])
def test_rates_that_make_no_sense_are_refused(multisap, rate):
    assert "--rate" in multisap.fail(2, "stream", "--rate", rate, "any.trace")


def last_line_of_failure(multisap, *arguments, **keywords):
    """liblcm may print lines of its own before ours."""
    done = multisap.run("stream", *arguments, **keywords)
    assert (done.returncode, done.stdout) == (1, ""), done
    line = done.stderr.splitlines()[-1]
    assert line.startswith("multisap: ")
    return line


def test_a_place_that_cannot_be_opened_is_an_error(stream, scene, multisap):
    assert "LCM could not open the URL" in last_line_of_failure(multisap, "--url", "nonsense", scene)
    assert "LCM could not open the URL" in last_line_of_failure(
        multisap, "--url", "file://no/such/folder?mode=w", scene)
    (multisap.folder / (scene.stem + ".lcmlog")).mkdir()
    assert "LCM could not open the URL" in last_line_of_failure(multisap, scene)


def test_a_full_disk_is_an_error(stream, multisap):
    path = multisap.folder / "small.trace"
    path.write_bytes(trace(frame()))
    assert "0 bytes of 115 were written" in last_line_of_failure(
        multisap, "--url", "file:///dev/full?mode=w", path)

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
    path = ROOT / "tests" / "scenes" / "ties.trace"
    assert "ties.lcmlog: the log is not whole: 8192 bytes of " in last_line_of_failure(
        multisap, path, preexec_fn=limit)


def test_a_name_that_a_url_cannot_hold_is_an_error(stream, multisap):
    path = multisap.folder / "what?.trace"
    path.write_bytes(trace(frame()))
    assert "cannot be part of an LCM log's" in multisap.fail(1, "stream", path)


def test_without_lcm(multisap, scene):
    done = multisap.run("stream", scene)
    assert done.returncode == 0 or (done.returncode, done.stderr) == (
        1, "multisap: %s: cannot be streamed: this multisap was built without LCM\n" % scene)


# ------------------------------------------------------------ LCM's own tools

@pytest.mark.skipif(not LCM_PLAYER, reason="needs LCM's log player")
def test_the_log_player_of_lcm_reads_it(stream, multisap):
    stream(ROOT / "tests" / "scenes" / "ties.trace")
    subprocess.run([LCM_PLAYER, "--lcm-url=file://copy.lcmlog?mode=w", "ties.lcmlog"], cwd=multisap.folder,
                   check=True, timeout=120, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    assert list(read_log(multisap.folder / "copy.lcmlog")) == list(read_log(multisap.folder / "ties.lcmlog"))


@pytest.mark.skipif(not LCM_GEN, reason="needs LCM's code generator")
def test_the_decoder_that_lcm_gen_makes_reads_it(stream, multisap, monkeypatch):
    _, messages = stream(ROOT / "tests" / "scenes" / "churn.trace")
    subprocess.run([LCM_GEN, "-p", "--ppath", str(multisap.folder), str(LCM_TYPE)], check=True)
    monkeypatch.syspath_prepend(str(multisap.folder))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    decode = __import__("msap").pair_events_t.decode
    for mine, (_, data) in zip(messages, read_log(multisap.folder / "churn.lcmlog")):
        theirs = decode(data)
        for name in ("utime", "epoch", "seq", "base", "pairs", "checksum", "kind", "part", "parts"):
            assert getattr(theirs, name) == getattr(mine, name)
        assert list(zip(theirs.deleted_a, theirs.deleted_b)) == mine.deleted
        assert list(zip(theirs.created_a, theirs.created_b)) == mine.created


def test_the_python_module_of_lcm_reads_it(stream, multisap):
    lcm = pytest.importorskip("lcm", reason="needs the Python package lcm, which Debian does not have")
    stream(ROOT / "tests" / "scenes" / "ties.trace")
    path = multisap.folder / "ties.lcmlog"
    theirs = [(event.channel, event.data) for event in lcm.EventLog(str(path), "r")]
    assert theirs == list(read_log(path))
