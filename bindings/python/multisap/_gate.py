# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Who may use a world: one owner, or any number of readers, at a time.

The library leaves this rule to its caller, and lets other Python threads run while
it works. So each call on a world goes through its gate, which turns away, at once,
who comes at the wrong time. Nobody waits, so nobody can wait for ever.

Inside a callback everything is let through: the library itself knows then what is
allowed, and refuses the rest.
"""

from __future__ import annotations

import threading

from ._api import Status
from ._errors import make_error


class Gate:
    """`with gate.owner:` and `with gate.reader:` around calls; `with gate.callback:` in callbacks."""

    def __init__(self) -> None:
        # Reentrant, because a signal handler may run between any two lines here.
        self._mutex = threading.RLock()
        self._readers = 0
        self._owner = False
        self._callback_thread: int | None = None
        self.owner = _Turn(self._enter_owner, self._leave_owner)
        self.reader = _Turn(self._enter_reader, self._leave_reader)
        self.callback = _Turn(self._enter_callback, self._leave_callback)

    def _in_callback(self) -> bool:
        return self._callback_thread == threading.get_ident()

    def _enter_owner(self) -> None:
        with self._mutex:
            if not self._in_callback():
                if self._owner or self._readers:
                    raise _busy()
                self._owner = True

    def _leave_owner(self) -> None:
        with self._mutex:
            if not self._in_callback():
                self._owner = False

    def _enter_reader(self) -> None:
        with self._mutex:
            if not self._in_callback():
                if self._owner:
                    raise _busy()
                self._readers += 1

    def _leave_reader(self) -> None:
        with self._mutex:
            if not self._in_callback():
                self._readers -= 1

    def _enter_callback(self) -> None:
        self._callback_thread = threading.get_ident()

    def _leave_callback(self) -> None:
        self._callback_thread = None


class _Turn:
    """What a with statement needs, from two functions."""

    __slots__ = ("_enter", "_leave")

    def __init__(self, enter, leave) -> None:
        self._enter = enter
        self._leave = leave

    def __enter__(self) -> None:
        self._enter()

    def __exit__(self, *error) -> None:
        self._leave()


def _busy():
    return make_error(Status.ERROR_BUSY, text="the world is in use by another call")
