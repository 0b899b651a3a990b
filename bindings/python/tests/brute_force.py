# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The pairs of boxes by comparing each box with each, in NumPy."""

from fractions import Fraction

import numpy as np


def overlap_matrix(lo_a, hi_a, lo_b, hi_b):
    below = (lo_a[:, None] <= hi_b[None]).all(axis=2)
    return below & (lo_b[None] <= hi_a[:, None]).all(axis=2)


def pairs(lo, hi, static=None):
    """Rows (i, j), i < j, sorted; two static boxes are no pair."""
    lo, hi = np.asarray(lo, np.float32), np.asarray(hi, np.float32)
    found = np.triu(overlap_matrix(lo, hi, lo, hi), 1)
    if static is not None:
        static = np.asarray(static, bool)
        found &= ~(static[:, None] & static[None])
    return np.argwhere(found)


def pairs_between(a, b):
    return np.argwhere(overlap_matrix(*a, *b))


def difference(pairs, others):
    """The rows of pairs that are not among the others, sorted."""
    rows = sorted(set(map(tuple, np.asarray(pairs).tolist())) - set(map(tuple, np.asarray(others).tolist())))
    return np.array(rows, np.uint64).reshape(-1, 2)


def by_id(ids, rows):
    """Rows of indices as rows of ids, lower id first, sorted."""
    named = np.sort(np.asarray(ids)[rows.reshape(-1, 2)], axis=1)
    return named[np.lexsort((named[:, 1], named[:, 0]))]


def shifted(bounds, offset, direction):
    """float32 bounds minus an offset, exactly, then rounded in the direction given: -inf or +inf."""
    return np.array([_rounded(bound, shift, direction) for bound, shift in zip(bounds, offset)], np.float32)


def _rounded(bound, shift, direction):
    if np.isinf(bound):
        return bound
    exact = Fraction(float(bound)) - Fraction(shift)
    with np.errstate(over="ignore"):
        near = np.float32(float(exact))
        wrong = near > exact if direction < 0 else near < exact
        return np.nextafter(near, np.float32(direction)) if wrong else near
