# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Box pruning: the overlapping pairs of boxes, in one shot and without a world."""

from __future__ import annotations

import ctypes
from typing import Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _api, _arrays
from ._arrays import PairArray
from ._errors import make_error
from ._library import lib


def _dims(lo):
    shape = np.shape(lo)
    if len(shape) != 2 or shape[1] not in (2, 3):
        raise ValueError(f"lo must have the shape (n, 2) or (n, 3), not {shape}")
    return shape[1]


def _make_config(dims, axis):
    config = _api.PruneConfig()
    lib.msap_prune_config_init(ctypes.byref(config), ctypes.sizeof(config))
    config.dims = dims
    if axis is not None:
        if axis not in range(dims):
            raise make_error(_api.Status.ERROR_CONFIG, text=f"axis={axis!r} is not allowed")
        config.axis = axis
    return config


def prune(a: Sequence[ArrayLike], b: Optional[Sequence[ArrayLike]] = None, *,
          axis: Optional[int] = None) -> PairArray:
    """The pairs of overlapping boxes in a, or of a box in a and one in b.

    a and b are each (lo, hi), two arrays (n, 2) or (n, 3), read as World does. The
    result is a (k, 2) uint32 array of rows, sorted: with a alone, two rows of a, the
    lower one first; else a row of a and a row of b. axis is the one to sweep along;
    None: that on which the boxes spread most.
    """
    lo, hi = a
    config = _make_config(_dims(lo), axis)
    boxes_a, n_a, keep_a = _arrays.boxes(lo, hi, config.dims)
    pairs, count = ctypes.c_void_p(), ctypes.c_size_t()
    error = _api.Error(struct_size=ctypes.sizeof(_api.Error))
    results = (ctypes.byref(pairs), ctypes.byref(count), ctypes.byref(error))
    if b is None:
        status = lib.msap_prune(ctypes.byref(config), n_a, ctypes.byref(boxes_a), *results)
    else:
        lo, hi = b
        boxes_b, n_b, keep_b = _arrays.boxes(lo, hi, config.dims)
        status = lib.msap_prune_bipartite(ctypes.byref(config), n_a, ctypes.byref(boxes_a), n_b,
                                          ctypes.byref(boxes_b), *results)
    if status:
        in_b = error.index >= n_a
        raise make_error(status, error.index - n_a if in_b else error.index, error.bound,
                         argument=None if b is None else "b" if in_b else "a")
    try:
        return _arrays.copy_index_pairs(pairs, count.value)
    finally:
        lib.msap_prune_free(ctypes.byref(config), pairs, count)
