# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Arrays on their way in: shapes, strides and number types."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import multisap
from multisap import _arrays


def bounds_of(lo, hi):
    with multisap.World(dims=np.shape(lo)[1]) as world:
        return world.bounds(world.add(lo, hi))


def layouts(array):
    """The same numbers in memory in many ways."""
    n, dims = array.shape
    wide = np.zeros((2 * n, 3 * dims), array.dtype)
    wide[::2, ::3] = array
    record = np.zeros(n, [("tag", "u1"), ("bounds", array.dtype, dims)])
    record["bounds"] = array
    return {
        "rows": array.copy(),
        "columns": np.asfortranarray(array),
        "gaps": wide[::2, ::3],
        "backwards": array[::-1].copy()[::-1],
        "components backwards": array[:, ::-1].copy()[:, ::-1],
        "transposed": array.T.copy().T,
        "unaligned": record["bounds"],
        "read only": np.frombuffer(array.tobytes(), array.dtype).reshape(n, dims),
    }


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("dims", [2, 3])
def test_any_layout_gives_the_same_boxes(rng, dtype, dims):
    lo = rng.integers(-50, 50, (20, dims)).astype(dtype)
    hi = lo + 1
    for name, lo_there in layouts(lo).items():
        for other, hi_there in layouts(hi).items():
            lo_read, hi_read = bounds_of(lo_there, hi_there)
            assert np.array_equal(lo_read, lo) and np.array_equal(hi_read, hi), (name, other)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_broadcast_row_is_read_again_and_again(dtype):
    lo = np.broadcast_to(np.array([1, 2, 3], dtype), (5, 3))
    hi = np.broadcast_to(dtype(4), (5, 3))
    assert lo.strides[0] == 0 and hi.strides == (0, 0)
    lo_read, hi_read = bounds_of(lo, hi)
    assert (lo_read == [1, 2, 3]).all() and (hi_read == 4).all()


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_floats_are_not_copied(rng, dtype):
    for name, array in layouts(rng.random((7, 3)).astype(dtype)).items():
        described, n, keep = _arrays.boxes(array, array, 3)
        assert (described.min, described.max) == (_arrays.address(array),) * 2, name
        assert (described.min_row, described.min_component) == array.strides, name
        assert n == 7


@pytest.mark.parametrize("dtype", ["i1", "u1", "i2", "i4", "u4", "i8", "u8", "f2", ">f4", ">f8", "g"])
def test_other_numbers_become_floats(dtype):
    lo = np.array([[1, 2, 3], [4, 5, 6]]).astype(dtype)
    lo_read, hi_read = bounds_of(lo, lo + 1)
    assert np.array_equal(lo_read, lo.astype(float)) and np.array_equal(hi_read, lo.astype(float) + 1)


def test_lists_and_mixed_types():
    lo_read, hi_read = bounds_of([[1, 2, 3]], np.array([[2, 2.5, 3]], np.float32))
    assert lo_read.tolist() == [[1, 2, 3]] and hi_read.tolist() == [[2, 2.5, 3]]


finite = st.floats(-3e38, 3e38)


@given(hnp.arrays(np.float64, (1, 3), elements=finite))
def test_doubles_are_rounded_outward(bounds):
    lo, hi = bounds_of(bounds, bounds)
    assert (lo <= bounds).all() and (hi >= bounds).all()
    assert (np.nextafter(lo, np.float32(np.inf)) > bounds).all()
    assert (np.nextafter(hi, np.float32(-np.inf)) < bounds).all()


@given(hnp.arrays(np.int64, (1, 2)))
def test_large_integers_are_rounded_outward(bounds):
    lo, hi = bounds_of(bounds, bounds)
    for i in range(2):
        assert int(lo[0, i]) <= int(bounds[0, i]) <= int(hi[0, i])


def test_long_doubles_are_rounded_outward():
    one = np.full((1, 2), np.longdouble(1) + np.finfo(np.longdouble).eps)
    lo, hi = bounds_of(one, one)
    assert (lo <= one).all() and (hi >= one).all()
    huge = np.full((1, 2), np.finfo(np.longdouble).max)
    lo, hi = bounds_of(-huge, huge)
    assert (lo == -np.inf).all() and (hi == np.inf).all()


@pytest.mark.parametrize("bad", [np.full((1, 3), "1"), np.ones((1, 3), complex), np.ones((1, 3), bool),
                                 [[None, 1, 2]]])
def test_what_is_no_number_is_refused(world, bad):
    with pytest.raises(TypeError, match="bounds must be numbers"):
        world.add(bad, np.ones((1, 3)))


@pytest.mark.parametrize("shape", [(), (3,), (2, 2), (2, 4), (1, 2, 3), (0,)])
def test_shapes_of_bounds(world, shape):
    with pytest.raises(ValueError, match=r"lo must have the shape \(n, 3\), not"):
        world.add(np.zeros(shape), np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"hi must have the shape \(n, 3\), not"):
        world.add(np.zeros((2, 3)), np.zeros(shape))


def test_numbers_of_rows_must_agree(world):
    with pytest.raises(ValueError, match="lo has 2 rows and hi has 3"):
        world.add(np.zeros((2, 3)), np.zeros((3, 3)))
    ids = world.add(np.zeros((2, 3)), np.zeros((2, 3)))
    with pytest.raises(ValueError, match="there are 2 ids and bounds of 3 boxes"):
        world.update(ids, np.zeros((3, 3)), np.zeros((3, 3)))


def test_no_boxes_at_all(world):
    none = np.empty((0, 3), np.float32)
    assert world.add(none, none).shape == (0,)
    world.update([], none, none)
    world.remove([])
    world.set_user_data([], [])
    assert world.user_data([]).shape == world.pair_data(np.empty((0, 2), np.uint64)).shape == (0,)
    assert [array.shape for array in world.bounds([])] == [(0, 3)] * 2
    assert len(world.commit().created) == 0


@pytest.mark.parametrize("form", [
    lambda ids: ids, lambda ids: ids.tolist(), lambda ids: tuple(ids), lambda ids: ids.astype(np.int64),
    lambda ids: ids.astype(">u8"), lambda ids: np.repeat(ids, 2)[::2], lambda ids: ids[::-1].copy()[::-1],
    lambda ids: [ids[0], *ids[1:].tolist()],
])
def test_forms_of_ids(world, form):
    ids = world.add(np.zeros((4, 3)), np.ones((4, 3)), data=[5, 6, 7, 8])
    assert world.user_data(form(ids)).tolist() == [5, 6, 7, 8]


def test_one_id_needs_no_array(world):
    ids = world.add(np.zeros((2, 3)), np.ones((2, 3)), data=[5, 6])
    assert world.user_data(ids[1]).tolist() == world.user_data(int(ids[1])).tolist() == [6]


@pytest.mark.parametrize("bad, error", [(1.0, TypeError), ([1.0, 2.0], TypeError), ("1", TypeError),
                                        (None, TypeError), (-1, OverflowError), ([2**64], OverflowError),
                                        ([[1, 2]], ValueError)])
def test_what_is_no_id_is_refused(world, bad, error):
    with pytest.raises(error):
        world.remove(bad)


@pytest.mark.parametrize("bad, error", [(1.5, TypeError), (2**63, OverflowError), (-2**63 - 1, OverflowError),
                                        (np.uint64(2**63), OverflowError), ([1, 2], ValueError),
                                        ([[1, 2, 3]], ValueError)])
def test_what_is_no_user_data_is_refused(world, bad, error):
    ids = world.add(np.zeros((3, 3)), np.ones((3, 3)))
    with pytest.raises(error):
        world.set_user_data(ids, bad)


@pytest.mark.parametrize("data", [0, -1, 2**63 - 1, -2**63, np.uint64(7), [1, -2, 3], np.array([1, 2, 3], "u1"),
                                  np.arange(6)[::2]])
def test_user_data_come_back(world, data):
    ids = world.add(np.zeros((3, 3)), np.ones((3, 3)), data=data)
    assert world.user_data(ids).tolist() == np.broadcast_to(np.asarray(data), (3,)).tolist()
    assert world.user_data(ids).dtype == np.intp


@pytest.mark.parametrize("bad, error", [(1, TypeError), ([True], ValueError), ("yes", TypeError)])
def test_what_is_no_static_is_refused(world, bad, error):
    with pytest.raises(error, match="static"):
        world.add(np.zeros((3, 3)), np.ones((3, 3)), static=bad)
