# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Messages of a pair-event stream, made as pair_events_t.lcm describes them."""

import struct

FINGERPRINT = 0xAF4CBFD932BEEDAD
EVENTS, SNAPSHOT = 0, 1
MASK = 2**64 - 1
HEAD = ">Qqqqqqqiiiii"


def splitmix64(x):
    x = x + 0x9E3779B97F4A7C15 & MASK
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9 & MASK
    x = (x ^ x >> 27) * 0x94D049BB133111EB & MASK
    return x ^ x >> 31


def checksum(pairs):
    total = sum(splitmix64(splitmix64(a) ^ b) for a, b in pairs) & MASK
    return total - 2**64 if total >> 63 else total


def encode(deleted=(), created=(), *, fingerprint=FINGERPRINT, utime=0, epoch=1, seq=1, base=0, pairs=0,
           checksum=0, kind=EVENTS, part=0, parts=1, n_deleted=None, n_created=None):
    columns = [pair[side] for list_ in (deleted, created) for side in (0, 1) for pair in list_]
    head = struct.pack(HEAD, fingerprint, utime, epoch, seq, base, pairs, checksum, kind, part, parts,
                       len(deleted) if n_deleted is None else n_deleted,
                       len(created) if n_created is None else n_created)
    return head + struct.pack(f">{len(columns)}q", *columns)


def split(deleted, created, parts):
    """The two lists in so many parts: deleted pairs first, then created ones."""
    tagged = [(pair, False) for pair in deleted] + [(pair, True) for pair in created]
    size = max(1, -(-len(tagged) // parts))
    for i in range(parts):
        here = tagged[i * size:(i + 1) * size]
        yield [pair for pair, new in here if not new], [pair for pair, new in here if new]


class Publisher:
    """Says of a sequence of pair sets what a publisher would."""

    def __init__(self, epoch=1):
        self.epoch = epoch
        self.seq = 0
        self.pairs = set()

    def _messages(self, deleted, created, parts, **fields):
        return [encode(d, c, epoch=self.epoch, utime=self.seq * 100, seq=self.seq, pairs=len(self.pairs),
                       checksum=checksum(self.pairs), part=i, parts=parts, **fields)
                for i, (d, c) in enumerate(split(deleted, created, parts))]

    def events(self, pairs, parts=1):
        """The messages of a commit after which these pairs overlap."""
        before, self.pairs = self.pairs, set(pairs)
        self.seq += 1
        return self._messages(sorted(before - self.pairs), sorted(self.pairs - before), parts,
                              base=self.seq - 1)

    def snapshot(self, parts=1):
        return self._messages([], sorted(self.pairs, reverse=True), parts, kind=SNAPSHOT)
