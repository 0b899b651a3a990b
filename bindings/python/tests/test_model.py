# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Random histories of a world, against a model that compares each box with each."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

import brute_force
import multisap

# Few numbers, so that many boxes touch; and those that need care.
NUMBERS = [-3.0, -2.0, -1.0, -0.0, 0.0, 1.0, 1.5, 2.0, 3.0, -np.inf, np.inf,
           float(np.finfo(np.float32).max), -float(np.finfo(np.float32).max)]


@st.composite
def bounds(draw, dims, n):
    numbers = st.sampled_from(NUMBERS)
    both = np.array(draw(st.lists(numbers, min_size=2 * n * dims, max_size=2 * n * dims))).reshape(2, n, dims)
    lo, hi = both.min(axis=0), both.max(axis=0)
    dtype = draw(st.sampled_from([np.float32, np.float64]))
    order = draw(st.sampled_from("CF"))
    return np.array(lo, dtype, order=order), np.array(hi, dtype, order=order)


class Model(RuleBasedStateMachine):
    @initialize(dims=st.sampled_from([2, 3]), grid=st.sampled_from([multisap.Grid.AUTO, multisap.Grid.NONE]),
                strategy=st.sampled_from(multisap.Strategy))
    def begin(self, dims, grid, strategy):
        self.world = multisap.World(dims, grid=grid, strategy=strategy)
        self.boxes = {}  # id: lo, hi, static, data
        self.gone = {}  # ids that the next commit reports: data
        self.committed = np.empty((0, 2), np.uint64)
        self.pair_data = {}

    def choose(self, data, unique=True):
        ids = st.sampled_from(sorted(self.boxes))
        return np.array(data.draw(st.lists(ids, min_size=1, max_size=5, unique=unique)), np.uint64)

    @rule(data=st.data(), n=st.integers(0, 6))
    def add(self, data, n):
        lo, hi = data.draw(bounds(self.world.dims, n))
        static = data.draw(st.lists(st.booleans(), min_size=n, max_size=n))
        user = data.draw(st.lists(st.integers(-2**63, 2**63 - 1), min_size=n, max_size=n))
        ids = self.world.add(lo, hi, static, user).tolist()
        assert len(set(ids)) == n and not self.boxes.keys() & ids and not self.gone.keys() & ids
        self.boxes.update(zip(ids, zip(lo, hi, static, user)))

    @precondition(lambda self: self.boxes)
    @rule(data=st.data())
    def update(self, data):
        ids = self.choose(data, unique=False)
        lo, hi = data.draw(bounds(self.world.dims, len(ids)))
        self.world.update(ids, lo, hi)
        for box, new_lo, new_hi in zip(ids.tolist(), lo, hi):
            self.boxes[box] = (new_lo, new_hi, *self.boxes[box][2:])

    @precondition(lambda self: self.boxes)
    @rule(data=st.data())
    def remove(self, data):
        ids = self.choose(data)
        self.world.remove(ids)
        for box in ids.tolist():
            self.gone[box] = self.boxes.pop(box)[3]

    @rule(offset=st.lists(st.sampled_from([0.0, 1.0, -0.5, 1e-50, 3e38, -1e300]), min_size=3, max_size=3))
    def shift_origin(self, offset):
        offset = offset[:self.world.dims]
        self.world.shift_origin(offset)
        for box, (lo, hi, *rest) in self.boxes.items():
            self.boxes[box] = (brute_force.shifted(lo, offset, -np.inf),
                               brute_force.shifted(hi, offset, np.inf), *rest)

    @precondition(lambda self: self.boxes)
    @rule(data=st.data(), value=st.integers(-9, 9))
    def set_user_data(self, data, value):
        ids = self.choose(data)
        self.world.set_user_data(ids, value)
        for box in ids.tolist():
            self.boxes[box] = (*self.boxes[box][:3], value)

    @precondition(lambda self: self.boxes)
    @rule(data=st.data())
    def refuse(self, data):
        """A batch of updates with an error in it changes nothing."""
        ids = self.choose(data, unique=False)
        lo, hi = data.draw(bounds(self.world.dims, len(ids)))
        row = data.draw(st.integers(0, len(ids) - 1))
        axis = data.draw(st.integers(0, self.world.dims - 1))
        hi[row, axis] = np.nan
        try:
            self.world.update(ids, lo, hi)
        except multisap.BoundsError as error:
            assert (error.row, error.bound) == (row, multisap.Bound.MAX_X + axis)
        else:
            raise AssertionError("it was not refused")

    def expected_pairs(self):
        ids = np.array(sorted(self.boxes), np.uint64)
        if not len(ids):
            return np.empty((0, 2), np.uint64)
        lo, hi, static, _ = map(np.array, zip(*(self.boxes[box] for box in ids.tolist())))
        return brute_force.by_id(ids, brute_force.pairs(lo, hi, static))

    def check_events(self, events):
        expected = self.expected_pairs()
        assert np.array_equal(events.created, brute_force.difference(expected, self.committed))
        assert np.array_equal(events.deleted, brute_force.difference(self.committed, expected))
        assert events.active == len(expected)
        assert events.deleted_data.tolist() == [self.pair_data.pop(pair) for pair in events.deleted]
        self.pair_data.update(zip(events.created, events.created_data.tolist()))
        self.committed = expected
        self.gone.clear()

    @rule()
    def commit(self):
        events = self.world.commit()
        assert not events.created_data.any()
        self.check_events(events)

    @rule(factor=st.integers(-5, 5))
    def commit_with_callbacks(self, factor):
        calls = []
        users = {**self.gone, **{box: fields[3] for box, fields in self.boxes.items()}}

        def on_delete(a, b, data_a, data_b, pair_data):
            assert (data_a, data_b, pair_data) == (users[a], users[b], self.pair_data[a, b])
            calls.append((a, b))

        def on_create(a, b, data_a, data_b):
            assert (data_a, data_b) == (users[a], users[b])
            calls.append((a, b))
            return factor * len(calls)

        events = self.world.commit(on_create, on_delete)
        assert calls == [*events.deleted, *events.created]
        self.check_events(events)

    @precondition(lambda self: len(self.committed))
    @rule(data=st.data(), value=st.integers(-9, 9))
    def set_pair_data(self, data, value):
        row = data.draw(st.integers(0, len(self.committed) - 1))
        self.world.set_pair_data(self.committed[row:row + 1, ::-1], value)
        self.pair_data[tuple(self.committed[row].tolist())] = value

    @rule()
    def trim(self):
        self.world.trim()

    @invariant()
    def what_can_be_read_is_right(self):
        self.world.validate()
        assert sorted(self.world.pairs()) == sorted(map(tuple, self.committed.tolist()))
        assert self.world.pair_data(self.committed).tolist() == [
            self.pair_data[tuple(pair)] for pair in self.committed.tolist()]
        known = {**self.gone, **{box: fields[3] for box, fields in self.boxes.items()}}
        assert self.world.user_data(list(known)).tolist() == list(known.values())
        for box, bound in zip(self.boxes.values(), zip(*self.world.bounds(list(self.boxes)))):
            assert np.array_equal(box[:2], bound)

    def teardown(self):
        if hasattr(self, "world"):
            self.world.close()


TestModel = Model.TestCase
