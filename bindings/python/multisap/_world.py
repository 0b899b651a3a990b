# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""World: a world of boxes, and what its commits report."""

from __future__ import annotations

import ctypes
import weakref
from typing import Any, Callable, NamedTuple, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from . import _api, _arrays
from ._arrays import PairArray
from ._callbacks import Callbacks
from ._config import make_config
from ._errors import make_error
from ._gate import Gate
from ._library import lib


class Events:
    """What a commit changed. The arrays are copies and stay what they are.

    created        (k, 2) handles: the pairs that began to overlap, sorted
    deleted        (k, 2) handles: the pairs that ceased to, sorted
    created_data   (k,) user data of the created pairs: what on_create returned
    deleted_data   (k,) user data that the deleted pairs had
    active         how many pairs overlap now
    """

    __slots__ = ("created", "deleted", "created_data", "deleted_data", "active")

    created: PairArray
    deleted: PairArray
    created_data: np.ndarray
    deleted_data: np.ndarray
    active: int

    def __repr__(self) -> str:
        return f"<Events created={len(self.created)} deleted={len(self.deleted)} active={self.active}>"


class Stats(NamedTuple):
    """The fields of msap_world_stats; the header says more about each."""

    boxes: int  # live, pending additions included
    pairs: int  # active at the last commit
    pending: int  # boxes added, updated or removed since the last commit
    bytes: int  # held from the allocator now
    bytes_peak: int  # the most ever held
    allocations: int  # calls of alloc so far
    commits: int  # successful ones so far
    crossings: int  # of the last commit: a min and a max of two boxes changed places
    touched: int  # of the last commit: pairs looked at
    slides: int  # commits so far that used each strategy
    merges: int
    sweeps: int
    moves: int  # of the last commit: boxes put into other cells or given a new skin
    cells: int  # that hold boxes
    cells_empty: int  # that have memory for their head only
    incidences: int  # boxes counted once for every cell they are in
    largest_cell: int  # boxes in the fullest cell
    giants: int  # boxes too large for any grid
    candidates: int  # pairs of boxes whose skins overlap


# The fields of msap_world_stats behind struct_size and reserved.
_STATS_FIELDS = [name for name, _ in _api.STRUCTS["msap_world_stats"][2:]]


def _destroy(pointer, config):
    """config is here to be kept until now: it holds the allocator."""
    lib.msap_destroy(pointer)


def _first_refused(n, refused):
    """The first row of n for which a batch that ends with it is refused."""
    low, high = 0, n - 1
    while low < high:
        middle = (low + high) // 2
        if refused(middle + 1):
            high = middle
        else:
            low = middle + 1
    return low


class World:
    """A world of boxes in 2 or 3 dimensions.

    Boxes come, move and go in batches; commit() brings the world up to date and
    reports the pairs that began and ceased to overlap. Bounds are two arrays
    (n, dims) of mins and maxes. float32 and float64 are read where they are, with
    any strides; float64 and what else there is are rounded outward to float32, so
    that nothing is missed. A box is named by its id, the handle that add() gives.

    A world is closed by close(), at the end of a with statement, or when it is
    collected. One thread may change it at a time, or any number may read; what
    comes at the wrong time is refused with BusyError. Errors of the library are
    raised as MultisapError, before anything has changed.

    The options are those of msap_config; None is the library's default. grid,
    strategy and simd are a Grid, Strategy and Simd. The hooks alloc, free, enqueue
    and finish are C functions: from another library, or made with AllocFunction
    and so on from functions in Python.
    """

    def __init__(
        self,
        dims: int = 3,
        *,
        grid: Optional[int] = None,
        strategy: Optional[int] = None,
        filters: Optional[bool] = None,
        simd: Optional[int] = None,
        max_boxes: Optional[int] = None,
        workers: Optional[int] = None,
        task_grain: Optional[int] = None,
        margin: Optional[float] = None,
        cell_size: Optional[float] = None,
        grid_cells: Optional[Sequence[int]] = None,
        grid_min: Optional[Sequence[float]] = None,
        grid_max: Optional[Sequence[float]] = None,
        alloc: Any = None,
        free: Any = None,
        allocator_user: Any = None,
        enqueue: Any = None,
        finish: Any = None,
        jobs_user: Any = None,
    ) -> None:
        options = {name: value for name, value in locals().items() if name != "self"}
        self._gate = Gate()
        self._config = make_config(options)
        pointer = ctypes.c_void_p()
        self._check(lib.msap_create(ctypes.byref(self._config), ctypes.byref(pointer)))
        self._own(pointer.value)

    def _own(self, pointer) -> None:
        self._world = pointer
        self._finalizer = weakref.finalize(self, _destroy, pointer, self._config)
        # The end of the process frees the memory; threads may use the world until then.
        self._finalizer.atexit = False

    # ------------------------------------------------------------ beginning and end

    def close(self) -> None:
        """Frees the world. Closing it twice is allowed."""
        with self._gate.owner:
            pointer, self._world = self._world, None
            if pointer is None:
                return
            self._finalizer.detach()
            status = lib.msap_destroy(pointer)
            if status:
                self._own(pointer)
                raise make_error(status)

    def __enter__(self) -> World:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    def __reduce__(self):
        raise TypeError("a World can be neither copied nor pickled")

    def __repr__(self) -> str:
        return f"<multisap.World dims={self.dims}{'' if self._world else ' closed'}>"

    @property
    def dims(self) -> int:
        """2 or 3."""
        return self._config.dims

    # ----------------------------------------------------------------------- calls

    @property
    def _pointer(self):
        if self._world is None:
            raise make_error(_api.Status.ERROR_NULL, text="the world is closed")
        return self._world

    def _check(self, status) -> None:
        if status:
            raise make_error(status)

    def _check_rows(self, status) -> None:
        """For calls that change rows: the library knows which one it refused."""
        if status:
            error = _api.Error(struct_size=ctypes.sizeof(_api.Error))
            lib.msap_last_error(self._world, ctypes.byref(error))
            raise make_error(status, error.index, error.bound)

    # ----------------------------------------------------------------------- boxes

    def add(self, lo: ArrayLike, hi: ArrayLike, static: ArrayLike = False, data: ArrayLike = 0) -> np.ndarray:
        """Adds n boxes, all or none, and returns their ids, (n,) uint64.

        static says, of all or of each, whether it is static: two static boxes never
        pair. data are integers of yours, one for all or one for each.
        """
        with self._gate.owner:
            world = self._pointer
            boxes, n, keep = _arrays.boxes(lo, hi, self.dims)
            flags, user = _arrays.flags(static, n), _arrays.user_data(data, n)
            ids = np.empty(n, _arrays.HANDLE)
            self._check_rows(lib.msap_add_many(
                world, n, ctypes.byref(boxes), _arrays.address(flags), _arrays.address(user),
                _arrays.address(ids)))
            return ids

    def update(self, ids: ArrayLike, lo: ArrayLike, hi: ArrayLike) -> None:
        """Gives boxes new bounds, all or none; of an id that comes twice the last counts."""
        with self._gate.owner:
            world = self._pointer
            handles = _arrays.handles(ids)
            boxes, n, keep = _arrays.boxes(lo, hi, self.dims)
            if n != len(handles):
                raise ValueError(f"there are {len(handles)} ids and bounds of {n} boxes")
            self._check_rows(lib.msap_update_many(world, n, _arrays.address(handles), ctypes.byref(boxes)))

    def remove(self, ids: ArrayLike) -> None:
        """Removes boxes, all or none. Their pairs are reported as deleted by the next commit."""
        with self._gate.owner:
            world = self._pointer
            handles = _arrays.handles(ids)
            self._check_rows(lib.msap_remove_many(world, len(handles), _arrays.address(handles)))

    def shift_origin(self, offset: ArrayLike) -> None:
        """Moves the origin to offset, (dims,): it is subtracted from every bound, rounded outward."""
        with self._gate.owner:
            world = self._pointer
            array = np.ascontiguousarray(offset, np.float64)
            if array.shape != (self.dims,):
                raise ValueError(f"offset must have the shape ({self.dims},), not {np.shape(offset)}")
            self._check(lib.msap_shift_origin(world, _arrays.address(array)))

    def bounds(self, ids: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """The bounds as last given, two (n, dims) float32 arrays. One call of the library for each id."""
        with self._gate.reader:
            world = self._pointer
            handles = _arrays.handles(ids)
            lo, hi = np.empty((2, len(handles), self.dims), np.float32)
            for row, handle in enumerate(handles.tolist()):
                at = row * lo.strides[0]
                status = lib.msap_get_bounds(world, handle, _arrays.address(lo) + at,
                                             _arrays.address(hi) + at)
                if status:
                    raise make_error(status, row)
            return lo, hi

    def user_data(self, ids: ArrayLike) -> np.ndarray:
        """The user data of boxes, (n,) int64. Of removed ones, until the commit that reports it."""
        with self._gate.reader:
            world = self._pointer
            handles = _arrays.handles(ids)
            data = np.empty(len(handles), _arrays.DATA)

            def read(n):
                return lib.msap_get_user_data(world, n, _arrays.address(handles), _arrays.address(data))

            status = read(len(handles))
            if status:
                raise make_error(status, _first_refused(len(handles), read))
            return data

    def set_user_data(self, ids: ArrayLike, data: ArrayLike) -> None:
        """Sets the user data of boxes, all or none."""
        with self._gate.owner:
            world = self._pointer
            handles = _arrays.handles(ids)
            user = _arrays.user_data(data, len(handles))
            self._check_rows(lib.msap_set_user_data(
                world, len(handles), _arrays.address(handles), _arrays.address(user)))

    # ---------------------------------------------------------------------- commit

    def commit(
        self,
        on_create: Optional[Callable[[int, int, int, int], Optional[int]]] = None,
        on_delete: Optional[Callable[[int, int, int, int, int], object]] = None,
    ) -> Events:
        """Applies what was added, moved and removed, and returns what changed.

        on_delete(a, b, data_a, data_b, pair_data) is called for every deleted pair,
        then on_create(a, b, data_a, data_b) for every created one; the integer that
        it returns becomes the pair's user data (None: 0). In them the world can be
        read and not changed. After an exception in one no other is called; it is
        raised when the commit is done, and events() tells what it would have returned.
        """
        with self._gate.owner:
            world = self._pointer
            if on_create is None and on_delete is None:
                self._check(lib.msap_commit(world, None, None))
                return self._read_events(world)
            callbacks = Callbacks(self._gate, on_create, on_delete)
            self._check(lib.msap_commit(world, ctypes.byref(callbacks.struct), None))
            if callbacks.error is not None:
                raise callbacks.error
            return self._read_events(world)

    def events(self) -> Events:
        """What the last commit returned. Empty after trim()."""
        with self._gate.reader:
            return self._read_events(self._pointer)

    def pairs(self) -> PairArray:
        """All pairs that overlapped at the last commit, (k, 2) handles, a < b in each row."""
        with self._gate.reader:
            return _arrays.copy_pairs(*self._array(lib.msap_pairs, self._pointer))[0]

    def _array(self, function, world):
        pointer, count = ctypes.c_void_p(), ctypes.c_size_t()
        self._check(function(world, ctypes.byref(pointer), ctypes.byref(count)))
        return pointer, count.value

    def _read_events(self, world) -> Events:
        events = Events()
        events.created, events.created_data = _arrays.copy_pairs(*self._array(lib.msap_created, world))
        events.deleted, events.deleted_data = _arrays.copy_pairs(*self._array(lib.msap_deleted, world))
        events.active = self._array(lib.msap_pairs, world)[1]
        return events

    def pair_data(self, pairs: ArrayLike) -> np.ndarray:
        """The user data of pairs, (k, 2) handles in any order: (k,) int64."""
        with self._gate.reader:
            world = self._pointer
            a, b = _arrays.handle_columns(pairs)
            data = np.empty(len(a), _arrays.DATA)

            def read(n):
                return lib.msap_get_pair_data(world, n, _arrays.address(a), _arrays.address(b),
                                              _arrays.address(data))

            status = read(len(a))
            if status:
                raise make_error(status, _first_refused(len(a), read))
            return data

    def set_pair_data(self, pairs: ArrayLike, data: ArrayLike) -> None:
        """Sets the user data of pairs, all or none."""
        with self._gate.owner:
            world = self._pointer
            a, b = _arrays.handle_columns(pairs)
            user = _arrays.user_data(data, len(a))
            self._check_rows(lib.msap_set_pair_data(
                world, len(a), _arrays.address(a), _arrays.address(b), _arrays.address(user)))

    # ------------------------------------------------------------ looking after it

    def stats(self) -> Stats:
        """Numbers about the world."""
        with self._gate.reader:
            stats = _api.WorldStats(struct_size=ctypes.sizeof(_api.WorldStats))
            self._check(lib.msap_stats(self._pointer, ctypes.byref(stats)))
            return Stats._make(getattr(stats, name) for name in _STATS_FIELDS)

    def validate(self) -> None:
        """Checks every invariant of the world; raises CorruptError if one is broken."""
        with self._gate.reader:
            what = ctypes.c_char_p()
            status = lib.msap_validate(self._pointer, ctypes.byref(what))
            if status:
                raise make_error(status, text=what.value.decode() if what.value else None)

    def trim(self) -> None:
        """Gives memory back that the world does not need. events() is empty afterwards."""
        with self._gate.owner:
            self._check(lib.msap_trim(self._pointer))
