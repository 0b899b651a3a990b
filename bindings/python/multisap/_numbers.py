# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The library's encoding of floats as integers of the same order."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ._library import lib

_encode = np.vectorize(lib.msap_encode_float, otypes=[np.uint32])
_decode = np.vectorize(lib.msap_decode_float, otypes=[np.float32])


def encode_float(values: ArrayLike) -> Any:
    """float32 numbers as uint32 of the same order; -0 as +0. One call of the library for each."""
    return _encode(np.asarray(values, np.float32))[()]


def decode_float(codes: ArrayLike) -> Any:
    """The float32 numbers that encode_float maps to these codes. One call of the library for each."""
    array = np.asarray(codes)
    codes = array.astype(np.uint32)
    if (codes != array).any():
        raise OverflowError("codes must fit into uint32")
    return _decode(codes)[()]
