# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Errors carry the status, the row and the bound, and change nothing."""

import pickle

import numpy as np
import pytest

import multisap
from multisap import Bound, Status
from multisap._errors import make_error

LO = np.zeros((5, 3))
HI = np.ones((5, 3))
BOUNDS = [(array, axis) for array in ("lo", "hi") for axis in range(3)]


def spoiled(array, row, axis, value):
    array = array.copy()
    array[row, axis] = value
    return array


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("which, axis", BOUNDS)
def test_nan_is_named(world, which, axis, dtype):
    lo = spoiled(LO, 3, axis, np.nan) if which == "lo" else LO
    hi = spoiled(HI, 3, axis, np.nan) if which == "hi" else HI
    ids = world.add(LO, HI)
    for call in (lambda: world.add(lo.astype(dtype), hi.astype(dtype)),
                 lambda: world.update(ids, lo.astype(dtype), hi.astype(dtype))):
        with pytest.raises(multisap.BoundsError) as caught:
            call()
        error = caught.value
        assert (error.status, error.row) == (Status.ERROR_NAN, 3)
        assert error.bound == (Bound.MIN_X if which == "lo" else Bound.MAX_X) + axis
        name = ("min " if which == "lo" else "max ") + "xyz"[axis]
        assert str(error) == f"row 3: a bound is not a number ({name})"
    assert world.stats().boxes == 5


@pytest.mark.parametrize("axis", range(3))
def test_inverted_bounds_are_named(world, axis):
    with pytest.raises(multisap.BoundsError) as caught:
        world.add(spoiled(LO, 4, axis, 2), HI)
    error = caught.value
    assert (error.status, error.row, error.bound) == (Status.ERROR_INVERTED, 4, Bound.MIN_X + axis)
    assert isinstance(error, ValueError) and isinstance(error, multisap.MultisapError)


def test_stale_handles_are_named(world):
    ids = world.add(LO, HI)
    world.remove(ids[2])
    calls = [lambda: world.update(ids, LO, HI), lambda: world.remove(ids), lambda: world.bounds(ids),
             lambda: world.set_user_data(ids, 1)]
    for call in calls:
        with pytest.raises(multisap.HandleError) as caught:
            call()
        error = caught.value
        assert (error.status, error.row, error.bound) == (Status.ERROR_HANDLE, 2, None)
        assert isinstance(error, LookupError)
    assert world.stats().boxes == 4


@pytest.mark.parametrize("bad", [0, 2, 2**52 + 1, 2**64 - 1])
@pytest.mark.parametrize("row", range(6))
def test_the_row_of_reading_calls_is_found(world, bad, row):
    ids = np.insert(world.add(LO, HI), row, bad)
    for call in (world.user_data, world.bounds):
        with pytest.raises(multisap.HandleError) as caught:
            call(ids)
        assert caught.value.row == row


def test_a_box_removed_twice_in_a_batch(world):
    ids = world.add(LO, HI)
    with pytest.raises(multisap.HandleError) as caught:
        world.remove([ids[0], ids[1], ids[0]])
    assert caught.value.row == 2 and world.stats().boxes == 5


@pytest.mark.parametrize("row", range(3))
def test_what_is_no_pair_is_named(world, row):
    ids = world.add(np.arange(12).reshape(4, 3) * 10, np.arange(12).reshape(4, 3) * 10 + 30)
    pairs = world.commit().created
    assert pairs.tolist() == [ids[0:2].tolist(), ids[1:3].tolist(), ids[2:4].tolist()]
    wrong = pairs.copy()
    wrong[row] = ids[0], ids[3]
    for call in (lambda: world.pair_data(wrong), lambda: world.set_pair_data(wrong, 1)):
        with pytest.raises(multisap.NotAPairError) as caught:
            call()
        assert (caught.value.status, caught.value.row) == (Status.ERROR_NOT_A_PAIR, row)
        assert isinstance(caught.value, LookupError)
    assert world.pair_data(pairs).tolist() == [0, 0, 0]


@pytest.mark.parametrize("bad", [[1, 2], [[1, 2, 3]], [], np.zeros((2, 1), np.uint64)])
def test_shapes_of_pairs(world, bad):
    with pytest.raises(ValueError, match="pairs must have the shape"):
        world.pair_data(bad)


@pytest.mark.parametrize("row", [0, 4])
def test_pruning_tells_whose_row_it_is(row):
    good, bad = (LO, HI), (spoiled(LO, row, 2, np.nan), HI)
    for arguments, argument in (((bad,), None), ((bad, good), "a"), ((good, bad), "b")):
        with pytest.raises(multisap.BoundsError) as caught:
            multisap.prune(*arguments)
        assert (caught.value.row, caught.value.bound, caught.value.argument) == (row, Bound.MIN_Z, argument)
    assert str(caught.value) == f"row {row} of b: a bound is not a number (min z)"


def test_every_status_has_a_text_and_an_exception():
    for status in Status:
        error = make_error(status, row=1, bound=Bound.MAX_Y)
        assert isinstance(error, multisap.MultisapError)
        assert error.status is status and error.text


def test_errors_can_be_pickled():
    error = make_error(Status.ERROR_INVERTED, 3, Bound.MIN_Z, argument="a")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is multisap.BoundsError and str(again) == str(error)
    assert (again.status, again.row, again.bound, again.argument) == (Status.ERROR_INVERTED, 3, Bound.MIN_Z, "a")
