# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The callbacks of a commit.

An exception cannot cross C. So the first one is kept, no callback is called after
it, and the commit raises it when the library has returned.
"""

from __future__ import annotations

import ctypes
import operator

from . import _api
from ._arrays import DATA

_CreateFunction = _api.ctype("msap_create_fn")
_DeleteFunction = _api.ctype("msap_delete_fn")
_LIMIT = 1 << (8 * DATA.itemsize - 1)


def _number(pointer):
    """User data as the signed integer that it is in Python."""
    return ctypes.c_ssize_t(pointer or 0).value


def _user_data(value):
    number = 0 if value is None else operator.index(value)
    if not -_LIMIT <= number < _LIMIT:
        raise OverflowError(f"user data must fit into {DATA}, not {number}")
    return number


class Callbacks:
    """Two Python functions, or None, as an msap_callbacks that lives as long as this object."""

    def __init__(self, gate, on_create, on_delete):
        self.error = None
        self._gate = gate
        self._on_create = on_create
        self._on_delete = on_delete
        self.struct = _api.Callbacks(
            ctypes.sizeof(_api.Callbacks), 0, None,
            _CreateFunction(self._create) if on_create else _CreateFunction(),
            _DeleteFunction(self._delete) if on_delete else _DeleteFunction())

    def _create(self, context, a, b, data_a, data_b):
        return self._call(self._on_create, a, b, _number(data_a), _number(data_b))

    def _delete(self, context, a, b, data_a, data_b, pair_data):
        self._call(self._on_delete, a, b, _number(data_a), _number(data_b), _number(pair_data))

    def _call(self, function, *arguments):
        if self.error is not None:
            return 0
        try:
            with self._gate.callback:
                result = function(*arguments)
            return _user_data(result) if function is self._on_create else 0
        except BaseException as error:
            self.error = error
            return 0
