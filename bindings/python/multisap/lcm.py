# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Follows a stream of pair events over LCM, live or from a log.

    for events in multisap.lcm.read_log("robot.lcmlog"):
        events.seq, events.created, events.deleted

    with multisap.lcm.subscribe("MSAP_EVENTS") as stream:
        for events in stream:
            ...

The messages and the rules for their readers are described in pair_events_t.lcm. A
message passes three steps here: decode() makes arrays of its bytes, or refuses
them; a _Stream puts parts together, finds their place in the order of commits and
checks the state that comes out; and what is handed on are the differences between
one checked state and the next. Opening a log or a subscription needs the package
lcm (pip install 'multisap[lcm]'); decode and Reader do not.
"""

from __future__ import annotations

import collections
import contextlib
import os
import re
import time
from typing import Any, Iterator, NamedTuple, Optional, Union

import numpy as np

from ._arrays import HANDLE, PairArray

EVENTS = 0
SNAPSHOT = 1

_FINGERPRINT = 0xAF4CBFD932BEEDAD
_MESSAGE_MAX = 60000
_HEAD = np.dtype([
    ("fingerprint", ">u8"), ("utime", ">i8"), ("epoch", ">i8"), ("seq", ">i8"), ("base", ">i8"),
    ("pairs", ">i8"), ("checksum", ">i8"), ("kind", ">i4"), ("part", ">i4"), ("parts", ">i4"),
    ("n_deleted", ">i4"), ("n_created", ">i4"),
])
_WORD = np.dtype(">i8")

# What is kept of messages that came too early, and of streams that ended.
_WAITING_MAX = 64
_STREAMS_MAX = 4

# How long LCM may block: it does not notice signals, such as that of Ctrl-C.
_STEP_SECONDS = 0.2


class MessageError(ValueError):
    """The bytes are no message of a pair-event stream."""


class Message(NamedTuple):
    """One message, as pair_events_t.lcm describes it."""

    utime: int
    epoch: int
    seq: int
    base: int
    pairs: int
    checksum: int
    kind: int
    part: int
    parts: int
    deleted: PairArray
    created: PairArray


class StreamEvents(NamedTuple):
    """How the pairs of commit `seq` differ from those of commit `since`.

    since = seq - 1   the events of one commit, as msap_commit reported them
    since < seq - 1   something was missed; these are the net changes over it
    since = 0         from no pairs at all: a stream begins here, or was taken up anew;
                      what was known of it before no longer holds
    """

    utime: int
    epoch: int
    seq: int
    since: int
    deleted: PairArray
    created: PairArray
    active: int


# ------------------------------------------------------------------- messages


def _pairs(words) -> PairArray:
    """The array of all a, then all b, as rows (a, b)."""
    return words.reshape(2, -1).T.astype(HANDLE, order="C").view(PairArray)


def _check(head, size) -> None:
    if head["n_deleted"] < 0 or head["n_created"] < 0:
        raise MessageError("a count is negative")
    expected = _HEAD.itemsize + 2 * _WORD.itemsize * (int(head["n_deleted"]) + int(head["n_created"]))
    if size != expected:
        raise MessageError(f"the counts ask for {expected} bytes, there are {size}")
    if size > _MESSAGE_MAX:
        raise MessageError(f"{size} bytes are more than a message may have")
    if not 0 <= head["base"] < head["seq"]:
        raise MessageError("base is not below seq")
    if not 0 <= head["part"] < head["parts"]:
        raise MessageError("part is not below parts")
    if head["n_created"] > head["pairs"]:
        raise MessageError("more pairs are created than there are")
    if head["kind"] == SNAPSHOT and (head["base"] != 0 or head["n_deleted"] != 0):
        raise MessageError("a snapshot has a base or deletes pairs")


def decode(data: bytes) -> Message:
    """The message of these bytes; raises MessageError if they say something impossible."""
    if len(data) < _HEAD.itemsize:
        raise MessageError(f"{len(data)} bytes are too few for a message")
    head = np.frombuffer(data, _HEAD, 1)[0]
    if head["fingerprint"] != _FINGERPRINT:
        raise MessageError("the fingerprint is of another type")
    _check(head, len(data))
    words = np.frombuffer(data, _WORD, offset=_HEAD.itemsize)
    middle = 2 * int(head["n_deleted"])
    return Message._make((*head.tolist()[1:10], _pairs(words[:middle]), _pairs(words[middle:])))


def _splitmix64(x):
    x = x + np.uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return x ^ (x >> np.uint64(31))


def _hash(pairs) -> int:
    """What these pairs add to a message's checksum, modulo 2^64."""
    return int(_splitmix64(_splitmix64(pairs[:, 0]) ^ pairs[:, 1]).sum(dtype=np.uint64))


# -------------------------------------------------------------------- streams


def _array(pairs) -> PairArray:
    return np.array(sorted(pairs), HANDLE).reshape(-1, 2).view(PairArray)


def _tuples(parts, which):
    return {pair for message in parts for pair in map(tuple, getattr(message, which).tolist())}


class _Stream:
    """The state of one epoch: the pairs of commit `seq`, and the messages that wait for their turn."""

    def __init__(self):
        self.newest = 0
        self._begin()

    def _begin(self):
        self.seq = 0
        self.active = set()
        self._hash = 0
        self._waiting = {}

    def take(self, message) -> list[StreamEvents]:
        """What can be said now that this message is there."""
        self.newest = max(self.newest, message.seq)
        if message.seq > self.seq and message.kind in (EVENTS, SNAPSHOT):
            name = (message.seq, -message.base, message.kind, message.parts)
            self._waiting.setdefault(name, {})[message.part] = message
            if len(self._waiting) > _WAITING_MAX:
                del self._waiting[min(self._waiting)]
        return list(self._advance())

    def _advance(self) -> Iterator[StreamEvents]:
        """Takes whole messages that lead on from here, the next commit first, the smallest step first."""
        while True:
            ready = [name for name, parts in self._waiting.items()
                     if len(parts) == name[3] and -name[1] <= self.seq]
            if not ready:
                return
            parts = self._waiting.pop(min(ready))
            events = self._apply(list(parts.values()))
            if events is None:
                self._begin()
                return
            yield events
            self._waiting = {name: parts for name, parts in self._waiting.items() if name[0] > self.seq}

    def _apply(self, parts) -> Optional[StreamEvents]:
        """Goes on to the commit of these parts; None if the state that comes out is not theirs."""
        message = parts[0]
        created = _tuples(parts, "created")
        if message.kind == SNAPSHOT:
            deleted = self.active - created
        else:
            deleted = _tuples(parts, "deleted") & self.active
        created -= self.active
        self.active -= deleted
        self.active |= created
        gone, come = _array(deleted), _array(created)
        self._hash = (self._hash + _hash(come) - _hash(gone)) % 2**64
        if len(self.active) != message.pairs or self._hash != message.checksum % 2**64:
            return None
        since, self.seq = self.seq, message.seq
        return StreamEvents(message.utime, message.epoch, message.seq, since, gone, come, len(self.active))


class Reader:
    """Follows what is published on one channel, message by message.

    Give it all messages, also repeated ones and those out of order. If one is missed
    it waits for a repetition or for the next snapshot, and `behind` says by how many
    commits. A publisher that starts anew is a new stream, with another epoch.
    """

    def __init__(self) -> None:
        self._streams: collections.OrderedDict[int, _Stream] = collections.OrderedDict()

    def feed(self, data: bytes) -> list[StreamEvents]:
        """The events that follow from this message, often one, sometimes none or several.

        Raises MessageError, and stays as it is, if the bytes are no message.
        """
        message = decode(data)
        stream = self._streams.setdefault(message.epoch, _Stream())
        self._streams.move_to_end(message.epoch)
        if len(self._streams) > _STREAMS_MAX:
            self._streams.popitem(last=False)
        return stream.take(message)

    def _last(self) -> _Stream:
        return next(reversed(self._streams.values()), None) or _Stream()

    def pairs(self) -> PairArray:
        """The active pairs of the stream that was fed last, sorted."""
        return _array(self._last().active)

    @property
    def behind(self) -> int:
        """How many commits of the stream that was fed last are known of and not reached."""
        return self._last().newest - self._last().seq


# ------------------------------------------------------------ logs, subscribing


def _import_lcm() -> Any:
    try:
        import lcm
    except ImportError as error:
        raise ImportError(f"multisap.lcm needs the package lcm, as in multisap[lcm]: {error}") from error
    return lcm


def read_log(path: Union[str, os.PathLike[str]], channel: str = "MSAP_EVENTS") -> Iterator[StreamEvents]:
    """The events of an LCM log. Raises MessageError for a message of another type on the channel."""
    reader = Reader()
    with contextlib.closing(_import_lcm().EventLog(os.fspath(path))) as log:
        for event in log:
            if event.channel == channel:
                yield from reader.feed(event.data)


class Subscription:
    """A live stream. Iterating over it gives StreamEvents as they come.

    reader    the Reader behind it
    refused   how many messages on the channel were none of a pair-event stream
    """

    def __init__(self, channel: str, url: Optional[str], lc: Any, timeout: Optional[float]) -> None:
        self.reader = Reader()
        self.refused = 0
        self._timeout = timeout
        self._ready: collections.deque[StreamEvents] = collections.deque()
        self._lcm = _import_lcm().LCM(url) if lc is None else lc
        self._subscription = self._lcm.subscribe(re.escape(channel), self._receive)
        self._subscription.set_queue_capacity(0)

    def _receive(self, channel: str, data: bytes) -> None:
        try:
            self._ready.extend(self.reader.feed(data))
        except MessageError:
            self.refused += 1

    def _wait(self) -> bool:
        """Waits for events; False if no message comes in time."""
        heard = time.monotonic()
        while not self._ready:
            left = _STEP_SECONDS
            if self._timeout is not None:
                left = max(0.0, heard + self._timeout - time.monotonic())
            if self._lcm.handle_timeout(int(min(left, _STEP_SECONDS) * 1000)):
                heard = time.monotonic()
            elif left == 0:
                return False
        return True

    def __iter__(self) -> Iterator[StreamEvents]:
        while self._wait():
            yield self._ready.popleft()

    def close(self) -> None:
        """Ends the subscription. Closing it twice is allowed."""
        if self._lcm is not None:
            self._lcm.unsubscribe(self._subscription)
            self._lcm = None

    def __enter__(self) -> Subscription:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def subscribe(channel: str = "MSAP_EVENTS", url: Optional[str] = None, *, lc: Any = None,
              timeout: Optional[float] = None) -> Subscription:
    """Subscribes to a channel of an LCM network.

    url is as LCM spells it; None: what LCM_DEFAULT_URL says, or LCM's default. lc is
    an lcm.LCM of yours to be used instead. Iterating ends when no message has come
    for `timeout` seconds (None: never) and may then be begun again; with 0 it gives
    what has come and does not wait.
    """
    return Subscription(channel, url, lc, timeout)
