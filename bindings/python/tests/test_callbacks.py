# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Callbacks: what they are given, what they may do, and what becomes of their exceptions."""

import numpy as np
import pytest

import multisap


@pytest.fixture
def boxes(world):
    """Four boxes in a row, each touching the next: three pairs, not yet committed."""
    lo = np.zeros((4, 3))
    lo[:, 0] = range(4)
    return world.add(lo, lo + 1, data=[10, 20, 30, -40])


def test_they_see_what_the_arrays_say(world, boxes):
    created, deleted = [], []
    events = world.commit(on_create=lambda *arguments: created.append(arguments),
                          on_delete=lambda *arguments: deleted.append(arguments))
    ids = boxes.tolist()
    assert created == [(ids[0], ids[1], 10, 20), (ids[1], ids[2], 20, 30), (ids[2], ids[3], 30, -40)]
    assert [pair[:2] for pair in created] == list(events.created) and deleted == []

    world.set_pair_data(world.pairs(), [1, 2, -3])
    world.remove(boxes[3])
    events = world.commit(on_delete=lambda *arguments: deleted.append(arguments))
    assert deleted == [(ids[2], ids[3], 30, -40, -3)]
    assert events.deleted_data.tolist() == [-3]


def test_what_on_create_returns_is_the_pairs_user_data(world, boxes):
    values = iter([-2**63, None, np.int64(2**63 - 1)])
    events = world.commit(on_create=lambda *arguments: next(values))
    assert events.created_data.tolist() == [-2**63, 0, 2**63 - 1]
    assert world.pair_data(events.created).tolist() == [-2**63, 0, 2**63 - 1]


@pytest.mark.parametrize("value, error", [("x", TypeError), (1.0, TypeError), (2**63, OverflowError)])
def test_what_is_no_user_data_is_an_error(world, boxes, value, error):
    with pytest.raises(error):
        world.commit(on_create=lambda *arguments: value)


class Stop(BaseException):
    pass


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit, Stop])
def test_the_first_exception_ends_the_callbacks_and_is_raised(world, boxes, error, capfd):
    called = []

    def on_create(a, b, data_a, data_b):
        called.append(data_a)
        if len(called) == 2:
            raise error("no more")
        return 5

    with pytest.raises(error, match="no more"):
        world.commit(on_create=on_create)
    assert called == [10, 20]
    assert capfd.readouterr() == ("", "")
    events = world.events()
    assert len(events.created) == 3 and events.created_data.tolist() == [5, 0, 0]
    assert world.stats().commits == 1 and len(world.commit().created) == 0


def test_after_an_exception_in_on_delete_on_create_is_not_called(world, boxes):
    world.commit()
    called = []

    def on_delete(*arguments):
        called.append(arguments)
        raise LookupError

    world.remove(boxes[0])
    world.add(np.full((1, 3), 1), np.full((1, 3), 2))
    with pytest.raises(LookupError):
        world.commit(on_create=lambda *arguments: called.append(arguments), on_delete=on_delete)
    assert len(called) == 1
    assert len(world.events().created) > 0


def test_the_world_can_be_read_in_a_callback(world, boxes):
    seen = []

    def on_create(a, b, data_a, data_b):
        seen.append((world.user_data([a, b]).tolist(), len(world.pairs()), world.events().active,
                     world.bounds([a])[0].shape, world.stats().boxes))
        world.validate()

    world.commit(on_create=on_create)
    assert seen == [([10, 20], 3, 3, (1, 3), 4), ([20, 30], 3, 3, (1, 3), 4), ([30, -40], 3, 3, (1, 3), 4)]


CHANGES = {
    "add": lambda world, a: world.add(np.zeros((1, 3)), np.ones((1, 3))),
    "update": lambda world, a: world.update(a, np.zeros((1, 3)), np.ones((1, 3))),
    "remove": lambda world, a: world.remove(a),
    "shift_origin": lambda world, a: world.shift_origin([1, 1, 1]),
    "set_user_data": lambda world, a: world.set_user_data(a, 1),
    "set_pair_data": lambda world, a: world.set_pair_data(world.pairs()[:1], 1),
    "commit": lambda world, a: world.commit(),
    "commit with callbacks": lambda world, a: world.commit(on_create=lambda *arguments: 0),
    "trim": lambda world, a: world.trim(),
    "close": lambda world, a: world.close(),
}


@pytest.mark.parametrize("change", CHANGES)
def test_the_world_cannot_be_changed_in_a_callback(world, boxes, change):
    with pytest.raises(multisap.BusyError) as caught:
        world.commit(on_create=lambda a, *others: CHANGES[change](world, a))
    assert caught.value.status == multisap.Status.ERROR_BUSY
    assert len(world.events().created) == 3
    world.remove(boxes)
    assert len(world.commit().deleted) == 3


def test_a_refused_change_can_be_caught_in_the_callback(world, boxes):
    refused = []

    def on_create(a, b, data_a, data_b):
        try:
            world.remove([a])
        except multisap.BusyError as error:
            refused.append(error)
        return 1

    assert world.commit(on_create=on_create).created_data.tolist() == [1, 1, 1]
    assert len(refused) == 3


def test_another_world_can_be_changed_in_a_callback(world, boxes):
    with multisap.World() as other:
        def on_create(a, b, data_a, data_b):
            other.add(np.zeros((1, 3)), np.ones((1, 3)))
            return len(other.commit(on_create=lambda *arguments: 0).created)

        assert world.commit(on_create=on_create).created_data.tolist() == [0, 1, 2]
