# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Decoding messages, and following a stream that loses, repeats and reorders them."""

import importlib
import random
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import multisap.lcm
from conftest import PROJECT
from messages import SNAPSHOT, Publisher, checksum, encode
from multisap.lcm import MessageError, Reader, decode

A, B, C, D = (1, 2), (1, 3), (2, 3), (2**62, 2**63 - 1)


def as_set(pairs):
    return set(map(tuple, np.asarray(pairs).tolist()))


def feed(reader, *messages):
    return [events for message in messages for events in reader.feed(message)]


# ------------------------------------------------------------------- messages


def test_decode():
    message = decode(encode([A, B], [D], utime=-5, epoch=9, seq=7, base=3, pairs=4, checksum=-6, kind=0, part=1,
                            parts=2))
    assert message[:9] == (-5, 9, 7, 3, 4, -6, 0, 1, 2)
    assert list(message.deleted) == [A, B] and list(message.created) == [D]
    assert message.created.dtype == np.uint64 and message.created.flags.writeable


@pytest.mark.parametrize("data, complaint", [
    (b"", "too few"),
    (encode()[:-1], "too few"),
    (encode(fingerprint=1), "fingerprint"),
    (encode([A]) + b"\0", "the counts ask for 92 bytes, there are 93"),
    (encode([A])[:-8], "the counts ask for"),
    (encode([A], n_deleted=2), "the counts ask for"),
    (encode(n_deleted=-1), "negative"),
    (encode([A, B], [C], n_deleted=-1, n_created=4, pairs=4), "negative"),
    (encode(n_created=2**31 - 1, n_deleted=2**31 - 1, pairs=2**62), "the counts ask for"),
    (encode([A] * 3746), "60012 bytes are more"),
    (encode(seq=0), "base"), (encode(seq=3, base=3), "base"), (encode(base=-1), "base"),
    (encode(part=1), "part"), (encode(part=-1), "part"), (encode(parts=0), "part"),
    (encode([], [A]), "more pairs"),
    (encode(kind=SNAPSHOT, seq=2, base=1), "snapshot"), (encode([A], kind=SNAPSHOT), "snapshot"),
])
def test_what_is_impossible_is_refused(data, complaint):
    reader = Reader()
    with pytest.raises(MessageError, match=complaint):
        reader.feed(data)
    assert reader.pairs().shape == (0, 2) and reader.behind == 0


@given(st.binary(max_size=200), st.booleans())
def test_any_bytes_are_decoded_or_refused(data, with_fingerprint):
    data = encode()[:8] + data if with_fingerprint else data
    try:
        decode(data)
    except MessageError:
        pass


@pytest.fixture(scope="session")
def generated(tmp_path_factory):
    """The message type as lcm-gen makes it."""
    lcm = pytest.importorskip("lcm")  # an extra: tests from source do without it
    folder = tmp_path_factory.mktemp("lcm-gen")
    subprocess.run([lcm.LCM_BIN_DIR + "/lcm-gen", "--python", "--ppath", str(folder),
                    str(PROJECT / "bindings/lcm/pair_events_t.lcm")], check=True)
    sys.path.insert(0, str(folder))
    try:
        return importlib.import_module("msap").pair_events_t
    finally:
        sys.path.remove(str(folder))


def test_decode_reads_what_lcm_encodes(generated):
    theirs = generated()
    theirs.utime, theirs.epoch, theirs.seq, theirs.base, theirs.pairs = 1, 2, 4, 3, 5
    theirs.checksum, theirs.kind, theirs.part, theirs.parts = -7, generated.EVENTS, 0, 2
    theirs.n_deleted, (theirs.deleted_a, theirs.deleted_b) = 2, zip(A, C)
    theirs.n_created, (theirs.created_a, theirs.created_b) = 1, zip(D)
    ours = decode(theirs.encode())
    assert ours[:9] == (1, 2, 4, 3, 5, -7, multisap.lcm.EVENTS, 0, 2)
    assert list(ours.deleted) == [A, C] and list(ours.created) == [D]
    assert (generated.EVENTS, generated.SNAPSHOT) == (multisap.lcm.EVENTS, multisap.lcm.SNAPSHOT)


# -------------------------------------------------------------------- streams


def test_events_of_each_commit():
    publisher, reader = Publisher(), Reader()
    (first,) = feed(reader, *publisher.events([A, B]))
    assert (first.utime, first.epoch, first.seq, first.since, first.active) == (100, 1, 1, 0, 2)
    assert list(first.created) == [A, B] and list(first.deleted) == []
    (second,) = feed(reader, *publisher.events([B, D]))
    assert (second.seq, second.since) == (2, 1)
    assert list(second.created) == [D] and list(second.deleted) == [A]
    (third,) = feed(reader, *publisher.events([B, D]))
    assert (third.seq, third.since, len(third.created), len(third.deleted)) == (3, 2, 0, 0)
    assert list(reader.pairs()) == [B, D] and reader.behind == 0


def test_parts_are_put_together():
    publisher, reader = Publisher(), Reader()
    feed(reader, *publisher.events([A, B]))
    parts = publisher.events([C, D], parts=4)
    assert feed(reader, *parts[:3], parts[1]) == []
    assert reader.behind == 1
    (events,) = feed(reader, parts[3])
    assert list(events.deleted) == [A, B] and list(events.created) == [C, D]


def test_parts_in_any_order():
    publisher, reader = Publisher(), Reader()
    (events,) = feed(reader, *reversed(publisher.events([A, B, C, D], parts=3)))
    assert list(events.created) == [A, B, C, D]


def test_repetitions_say_nothing_new():
    publisher, reader = Publisher(), Reader()
    first, second = publisher.events([A]), publisher.events([B])
    assert len(feed(reader, *first, *second)) == 2
    assert feed(reader, *first, *second, *publisher.snapshot()) == []


def test_messages_that_overtake_others():
    publisher, reader = Publisher(), Reader()
    messages = [message for pairs in ([A], [A, B], [B], [C]) for message in publisher.events(pairs)]
    assert [events.seq for events in feed(reader, messages[0], messages[3], messages[2])] == [1]
    assert reader.behind == 3
    late = feed(reader, messages[1])
    assert [(events.since, events.seq) for events in late] == [(1, 2), (2, 3), (3, 4)]
    assert list(reader.pairs()) == [C]


def test_a_lost_message_is_healed_by_a_snapshot():
    publisher, reader = Publisher(), Reader()
    feed(reader, *publisher.events([A, B]))
    publisher.events([A])
    publisher.events([A, C])
    assert feed(reader, *publisher.events([A, D])) == []
    assert reader.behind == 3
    (events,) = feed(reader, *publisher.snapshot(parts=2))
    assert (events.since, events.seq) == (1, 4)
    assert list(events.deleted) == [B] and list(events.created) == [D]
    assert feed(reader, *publisher.events([D]))[0].since == 4


def test_a_lost_message_is_healed_by_changes_from_an_earlier_commit():
    """They name C too, which came and went in between, and a B that this reader has lost already."""
    publisher, reader = Publisher(), Reader()
    for active in ([A, B], [A, C]):
        feed(reader, *publisher.events(active))
    publisher.events([A, C, D])
    publisher.events([A, D])
    message = encode([B, C], [D], seq=4, base=1, pairs=2, checksum=checksum([A, D]))
    (events,) = feed(reader, message)
    assert (events.since, events.seq) == (2, 4)
    assert list(events.deleted) == [C] and list(events.created) == [D]


def test_who_comes_late_begins_with_a_snapshot():
    publisher, reader = Publisher(), Reader()
    publisher.events([A])
    assert feed(reader, *publisher.events([A, B])) == []
    (events,) = feed(reader, *publisher.snapshot())
    assert (events.since, events.seq, events.active) == (0, 2, 2)


@pytest.mark.parametrize("fields", [dict(pairs=3), dict(checksum=1), dict(created=[C])])
def test_a_state_that_is_not_the_publishers_is_given_up(fields):
    publisher, reader = Publisher(), Reader()
    feed(reader, *publisher.events([A]))
    publisher.events([A, B])
    good = dict(created=[B], seq=2, base=1, pairs=2, checksum=checksum([A, B]))
    assert feed(reader, encode(**{**good, **fields})) == []
    assert reader.pairs().shape == (0, 2) and reader.behind == 2
    assert feed(reader, *publisher.events([A, B, C])) == []
    (events,) = feed(reader, *publisher.snapshot())
    assert events.since == 0 and list(events.created) == [A, B, C]


def test_a_publisher_that_starts_anew():
    old, new, reader = Publisher(epoch=5), Publisher(epoch=6), Reader()
    feed(reader, *old.events([A, B]))
    (events,) = feed(reader, *new.events([C]))
    assert (events.epoch, events.since) == (6, 0) and list(reader.pairs()) == [C]
    (late,) = feed(reader, *old.events([A]))
    assert (late.epoch, late.since) == (5, 1) and list(late.deleted) == [B]


def test_unknown_kinds_are_left_alone():
    publisher, reader = Publisher(), Reader()
    feed(reader, *publisher.events([A]))
    assert feed(reader, encode(kind=2, seq=2, base=1)) == []
    assert len(feed(reader, *publisher.events([B]))) == 1


def test_what_waits_is_bounded():
    """What came last is kept: with the commit before, it is reached."""
    reader = Reader()
    for seq in range(2, 1000):
        feed(reader, encode(seq=seq, base=seq - 1))
    (stream,) = reader._streams.values()
    assert len(stream._waiting) <= 64
    late = feed(reader, encode(seq=990, kind=SNAPSHOT))
    assert [events.seq for events in late] == list(range(990, 1000))


def test_streams_that_are_kept():
    """As many as are needed for a publisher that starts anew, and those that were heard last."""
    reader = Reader()
    for epoch in (1, 2, 3, 4):
        feed(reader, encode(created=[A], epoch=epoch, pairs=1, checksum=checksum([A])))
    feed(reader, encode(created=[B], epoch=1, seq=2, base=1, pairs=2, checksum=checksum([A, B])))
    assert list(reader.pairs()) == [A, B]
    feed(reader, encode(epoch=5))
    assert list(reader._streams) == [3, 4, 1, 5] and len(reader.pairs()) == 0


pairs = st.sets(st.sampled_from([A, B, C, D, (5, 6), (5, 7)]))


@given(st.lists(st.tuples(pairs, st.integers(1, 3), st.booleans()), min_size=1, max_size=12),
       st.integers(0, 2**32), st.floats(0, 0.5))
def test_what_a_reader_says_leads_to_what_was_published(commits, seed, loss):
    """Whatever the network does, events lead from one published state to a later one."""
    publisher, reader, noise = Publisher(), Reader(), random.Random(seed)
    states, sent = {0: set()}, []
    for active, parts, with_snapshot in commits:
        messages = publisher.events(active, parts) + (publisher.snapshot(parts) if with_snapshot else [])
        sent += [(len(sent) + noise.random() * 8, message) for message in messages for _ in range(2)]
        states[publisher.seq] = set(active)
    arrived = [message for _, message in sorted(sent) if noise.random() >= loss]
    last = 0
    for events in feed(reader, *arrived, *publisher.snapshot()):
        assert events.since == last < events.seq
        assert as_set(events.deleted) == states[events.since] - states[events.seq]
        assert as_set(events.created) == states[events.seq] - states[events.since]
        assert events.active == len(states[events.seq])
        last = events.seq
    assert last == publisher.seq and as_set(reader.pairs()) == publisher.pairs and reader.behind == 0


# ----------------------------------------------------- logs and subscriptions


@pytest.fixture
def lc():
    lcm = pytest.importorskip("lcm")  # an extra: tests from source do without it
    return lcm.LCM("memq://")


def test_a_subscription(lc):
    publisher = Publisher()
    with multisap.lcm.subscribe("PAIRS", lc=lc, timeout=0) as stream:
        assert list(stream) == []
        for active in ([A], [A, B], [B]):
            for message in publisher.events(active, parts=2):
                lc.publish("PAIRS", message)
        lc.publish("PAIRS", b"something else")
        lc.publish("PAIRS_OF_ANOTHER", Publisher(epoch=2).events([D])[0])
        assert [events.seq for events in stream] == [1, 2, 3]
        assert stream.refused == 1 and list(stream.reader.pairs()) == [B]
        lc.publish("PAIRS", publisher.events([])[0])
        assert [list(events.deleted) for events in stream] == [[B]]
    stream.close()
    lc.publish("PAIRS", publisher.events([A])[0])
    assert lc.handle_timeout(0) == 0


def test_a_channel_is_no_pattern(lc):
    with multisap.lcm.subscribe("A.B", lc=lc, timeout=0) as stream:
        lc.publish("AxB", Publisher().events([A])[0])
        assert list(stream) == [] and stream.refused == 0
        lc.publish("A.B", Publisher().events([A])[0])
        assert len(list(stream)) == 1


def test_a_subscription_queues_any_number_of_messages():
    """LCM's own limit is 30, beyond which it drops messages without a word; 0 is none."""
    capacities = []

    class Network:
        def subscribe(self, channel, handler):
            return self

        def set_queue_capacity(self, messages):
            capacities.append(messages)

    multisap.lcm.subscribe(lc=Network())
    assert capacities == [0]


def test_a_subscription_without_an_end(lc):
    with multisap.lcm.subscribe(lc=lc) as stream:
        lc.publish("MSAP_EVENTS", Publisher().events([A])[0])
        assert next(iter(stream)).active == 1


def test_a_subscription_of_its_own():
    pytest.importorskip("lcm")  # an extra: tests from source do without it
    with multisap.lcm.subscribe(url="memq://", timeout=0) as stream:
        assert list(stream) == []


def test_a_log(tmp_path):
    lcm = pytest.importorskip("lcm")  # an extra: tests from source do without it
    path, publisher = tmp_path / "events.lcmlog", Publisher()
    log = lcm.EventLog(str(path), "w")
    for active in ([A], [A, B]):
        log.write_event(0, "OTHER", b"not ours")
        log.write_event(0, "MSAP_EVENTS", publisher.events(active)[0])
    log.close()
    assert [list(events.created) for events in multisap.lcm.read_log(path)] == [[A], [B]]
    assert list(multisap.lcm.read_log(str(path), channel="NOBODY")) == []
    with pytest.raises(MessageError):
        list(multisap.lcm.read_log(path, channel="OTHER"))


def test_a_log_that_is_not_there(tmp_path):
    pytest.importorskip("lcm")  # an extra: tests from source do without it
    with pytest.raises(OSError):
        list(multisap.lcm.read_log(tmp_path / "none.lcmlog"))


def test_without_the_package_lcm(monkeypatch):
    monkeypatch.setitem(sys.modules, "lcm", None)
    with pytest.raises(ImportError, match=r"needs the package lcm, as in multisap\[lcm\]"):
        multisap.lcm.subscribe()
    assert decode(encode()).seq == 1
