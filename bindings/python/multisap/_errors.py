# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""One exception for each kind of failure, with what the library knows of it."""

from __future__ import annotations

from typing import Optional

from ._api import Bound, Status
from ._library import lib


class MultisapError(Exception):
    """A call of the library failed; the world is as it was before the call.

    status    the library's status
    row       the first offending row of the arrays that were given, or None
    bound     the offending bound, or None
    argument  prune(a, b): whose row it is, "a" or "b"; else None
    """

    def __init__(self, status: Status, text: Optional[str] = None, row: Optional[int] = None,
                 bound: Optional[Bound] = None, argument: Optional[str] = None):
        self.status = Status(status)
        self.row = row
        self.bound = bound
        self.argument = argument
        self.text = text or lib.msap_status_text(status).decode()
        super().__init__(self._sentence())

    def _sentence(self) -> str:
        of = f" of {self.argument}" if self.argument else ""
        where = "" if self.row is None else f"row {self.row}{of}: "
        which = "" if self.bound is None else f" ({self.bound.name.lower().replace('_', ' ')})"
        return where + self.text + which

    def __reduce__(self):
        return type(self), (self.status, self.text, self.row, self.bound, self.argument)


class ConfigError(MultisapError, ValueError):
    """An option has a value that is not allowed."""


class OutOfMemoryError(MultisapError, MemoryError):
    """The allocator has no memory."""


class BoundsError(MultisapError, ValueError):
    """A bound is NaN, or a min is above its max."""


class HandleError(MultisapError, LookupError):
    """There is no such box: the id is null, stale or was never given."""


class FullError(MultisapError):
    """The limit of boxes or pairs is reached."""


class BusyError(MultisapError, RuntimeError):
    """The world was to be changed from inside a callback, or is in use by another thread."""


class NotAPairError(MultisapError, LookupError):
    """The two boxes were no pair at the last commit."""


class CorruptError(MultisapError, RuntimeError):
    """World.validate found a broken invariant."""


_CLASSES = {
    Status.ERROR_CONFIG: ConfigError,
    Status.ERROR_MEMORY: OutOfMemoryError,
    Status.ERROR_NAN: BoundsError,
    Status.ERROR_INVERTED: BoundsError,
    Status.ERROR_HANDLE: HandleError,
    Status.ERROR_FULL: FullError,
    Status.ERROR_BUSY: BusyError,
    Status.ERROR_NOT_A_PAIR: NotAPairError,
    Status.ERROR_CORRUPT: CorruptError,
}

# Those that are about one row.
_OF_A_ROW = (Status.ERROR_NAN, Status.ERROR_INVERTED, Status.ERROR_HANDLE, Status.ERROR_FULL,
             Status.ERROR_NOT_A_PAIR)


def make_error(status, row=None, bound=Bound.NO_BOUND, text=None, argument=None) -> MultisapError:
    """The exception for a status; row and bound are left out where they say nothing."""
    status = Status(status)
    return _CLASSES.get(status, MultisapError)(
        status, text,
        row if status in _OF_A_ROW else None,
        Bound(bound) if bound != Bound.NO_BOUND else None,
        argument)
