# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Box pruning and the encoding of floats, against NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import brute_force
import multisap


@st.composite
def boxes(draw, dims):
    lo = draw(hnp.arrays(np.float32, (draw(st.integers(0, 12)), dims), elements=st.integers(-3, 3).map(float)))
    return lo, lo + draw(hnp.arrays(np.float32, lo.shape, elements=st.sampled_from([0.0, 1.0, 5.0, np.inf])))


@pytest.mark.parametrize("dims", [2, 3])
def test_all_pairs(dims):
    @given(boxes(dims), st.sampled_from([None, *range(dims)]))
    def check(a, axis):
        pairs = multisap.prune(a, axis=axis)
        assert pairs.dtype == np.uint32
        assert np.array_equal(pairs, brute_force.pairs(*a))

    check()


@pytest.mark.parametrize("dims", [2, 3])
def test_pairs_between_two_sets(dims):
    @given(boxes(dims), boxes(dims), st.sampled_from([None, *range(dims)]))
    def check(a, b, axis):
        assert np.array_equal(multisap.prune(a, b, axis=axis), brute_force.pairs_between(a, b))

    check()


def test_pairs_have_names(rng):
    lo = rng.random((50, 3))
    pairs = multisap.prune((lo, lo + 0.3))
    assert all(pair.a < pair.b for pair in pairs) and len(list(pairs)) == len(pairs) > 0


def test_arrays_of_both_bounds(rng):
    """A (2, n, dims) array is a pair of arrays too."""
    both = np.sort(rng.random((2, 30, 2)), axis=0)
    assert np.array_equal(multisap.prune(both), multisap.prune((both[0], both[1])))


def test_results_are_the_callers(rng):
    lo = rng.random((50, 3))
    pairs = multisap.prune((lo, lo + 0.3))
    copied = pairs.copy()
    for _ in range(10):
        multisap.prune((lo, lo + 0.5))
    assert np.array_equal(pairs, copied) and pairs.flags.writeable


@pytest.mark.parametrize("axis", [-1, 3, "x", 1.5])
def test_axes_that_there_are_not(axis):
    with pytest.raises(multisap.ConfigError, match="axis="):
        multisap.prune((np.zeros((1, 3)), np.ones((1, 3))), axis=axis)


@pytest.mark.parametrize("shape", [(3,), (2, 1), (2, 4), ()])
def test_shapes(shape):
    with pytest.raises(ValueError, match=r"\(n, 2\) or \(n, 3\)"):
        multisap.prune((np.zeros(shape), np.zeros(shape)))


def test_both_sets_have_the_same_dimensions():
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        multisap.prune((np.zeros((1, 3)), np.ones((1, 3))), (np.zeros((1, 2)), np.ones((1, 2))))


ordered = np.array([-np.inf, -3e38, -1, -1e-45, 0, 1e-45, 1, 3e38, np.inf], np.float32)


def test_codes_have_the_order_of_the_floats():
    codes = multisap.encode_float(ordered)
    assert codes.dtype == np.uint32 and (np.diff(codes.astype(np.int64)) > 0).all()
    assert np.array_equal(multisap.decode_float(codes), ordered)


def test_one_number():
    assert multisap.encode_float(-0.0) == multisap.encode_float(0.0)
    assert multisap.decode_float(multisap.encode_float(1.5)) == np.float32(1.5)


def test_shapes_of_numbers_stay():
    assert multisap.encode_float(np.zeros((2, 3))).shape == (2, 3)
    assert multisap.decode_float(multisap.encode_float(np.zeros((0, 3)))).shape == (0, 3)


@pytest.mark.parametrize("codes", [-1, 2**32, [1.5]])
def test_what_is_no_code(codes):
    with pytest.raises(OverflowError):
        multisap.decode_float(codes)
