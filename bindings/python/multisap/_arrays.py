# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""NumPy arrays on their way into the library and out of it.

Into it: bounds are handed over where they lie if they are float32 or float64,
whatever their strides; everything else becomes an array of the type that the
library reads. Out of it: the library's arrays live until the next commit, so they
are always copied.
"""

from __future__ import annotations

import ctypes
import operator
from typing import Iterator, NamedTuple

import numpy as np

from . import _api

# User data are pointers to C and signed integers of the same size here.
DATA = np.dtype(np.intp)
HANDLE = np.dtype(np.uint64)

_BOXES_SIZE = ctypes.sizeof(_api.Boxes)
_PAIR_WORDS = ctypes.sizeof(_api.Pair) // HANDLE.itemsize


class Pair(NamedTuple):
    """Two overlapping boxes, a < b."""

    a: int
    b: int


class PairArray(np.ndarray):
    """A (k, 2) array of pairs; iterating over it gives Pair tuples of Python integers.

    A column or an element is what it is in any array, and so is a row when iterating
    over something in which the two numbers of a pair no longer lie side by side,
    such as the transposed array.
    """

    def __iter__(self) -> Iterator:
        if self.ndim == 2 and self.shape[1] == 2 and self.strides[1] == self.itemsize:
            return map(Pair._make, self.tolist())
        return super().__iter__()


def address(array) -> int:
    return array.__array_interface__["data"][0]


# --------------------------------------------------------------------- bounds


def _outward(array, direction):
    """As float64; a number that float64 does not hold moves in the direction given."""
    if array.dtype.kind not in "iuf":
        raise TypeError(f"bounds must be numbers, not {array.dtype}")
    with np.errstate(invalid="ignore", over="ignore"):
        double = array.astype(np.float64)
        inexact = double.astype(array.dtype) != array
    if inexact.any():
        double[inexact] = np.nextafter(double[inexact], direction)
    return double


def _bound_arrays(lo, hi, dims):
    lo, hi = np.asarray(lo), np.asarray(hi)
    for name, array in (("lo", lo), ("hi", hi)):
        if array.ndim != 2 or array.shape[1] != dims:
            raise ValueError(f"{name} must have the shape (n, {dims}), not {array.shape}")
    if len(lo) != len(hi):
        raise ValueError(f"lo has {len(lo)} rows and hi has {len(hi)}")
    if lo.dtype == hi.dtype and lo.dtype in (np.float32, np.float64):
        return lo, hi
    return _outward(lo, -np.inf), _outward(hi, np.inf)


def boxes(lo, hi, dims):
    """An msap_boxes for two (n, dims) arrays, n, and what must live as long as the msap_boxes."""
    lo, hi = _bound_arrays(lo, hi, dims)
    scalar = _api.Scalar.FLOAT if lo.dtype == np.float32 else _api.Scalar.DOUBLE
    described = _api.Boxes(_BOXES_SIZE, scalar, address(lo), address(hi), *lo.strides, *hi.strides)
    return described, len(lo), (lo, hi)


# ---------------------------------------------------------- handles and data


_as_integers = np.frompyfunc(operator.index, 1, 1)


def _integers(values, dtype, what):
    """As a contiguous array of this type, or an error where a number would change."""
    array = np.asarray(values)
    if array.dtype == dtype:
        return np.asarray(array, order="C")
    if array.dtype.kind not in "iu":
        # such as an empty list, or one of NumPy's and Python's integers: floats to NumPy
        try:
            array = np.asarray(_as_integers(np.asarray(values, object)))
        except TypeError:
            raise TypeError(f"{what} must be integers, not {array.dtype}") from None
    converted = array.astype(dtype, order="C")
    if (converted != array).any():
        raise OverflowError(f"{what} must fit into {dtype}")
    return converted


def handles(ids):
    """The library's handles: a one-dimensional contiguous array. One id may come without an array."""
    array = np.atleast_1d(_integers(ids, HANDLE, "ids"))
    if array.ndim != 1:
        raise ValueError(f"ids must be one-dimensional, not of the shape {array.shape}")
    return array


def handle_columns(pairs):
    """The two columns of a (k, 2) array of handles, each contiguous."""
    array = _integers(pairs, HANDLE, "pairs")
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"pairs must have the shape (k, 2), not {array.shape}")
    return np.ascontiguousarray(array[:, 0]), np.ascontiguousarray(array[:, 1])


def _of_rows(array, n, what):
    """One value for all rows, or one for each."""
    if array.ndim > 1 or (array.ndim == 1 and len(array) != n):
        raise ValueError(f"{what} must be one value or {n}, not of the shape {array.shape}")
    return np.ascontiguousarray(np.broadcast_to(array, (n,)))


def user_data(values, n):
    return _of_rows(_integers(values, DATA, "user data"), n, "user data")


def flags(static, n):
    array = np.asarray(static)
    if array.size and array.dtype.kind != "b":
        raise TypeError(f"static must be bool, not {array.dtype}")
    return _of_rows(array.astype(np.uint32) * np.uint32(_api.STATIC), n, "static")


# -------------------------------------------------------------------- results


def _copy(pointer, count, words, dtype):
    block = np.empty((count, words), dtype)
    if count:
        ctypes.memmove(address(block), pointer, block.nbytes)
    return block


def copy_pairs(pointer, count):
    """The pairs of an array of msap_pair, and their user data: both views of one copy."""
    block = _copy(pointer, count, _PAIR_WORDS, HANDLE)
    return block[:, :2].view(PairArray), block[:, 2].view(DATA)


def copy_index_pairs(pointer, count):
    return _copy(pointer, count, 2, np.uint32).view(PairArray)
