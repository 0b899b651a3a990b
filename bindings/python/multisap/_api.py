# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""multisap.h, as ctypes needs it.

Everything is written down once, in the words of the header: types as C spells
them, so that a test can compare this file with a description of the header that
is made by a C compiler. From these tables the ctypes classes are made.

A pointer is a c_void_p for ctypes, whatever it points to: this takes addresses of
NumPy arrays, byref(...) and None alike, and costs the least.
"""

from __future__ import annotations

import ctypes
import enum

VERSION = (0, 1, 0)

# ------------------------------------------------------------------ constants


class Status(enum.IntEnum):
    """What a call came to: msap_status."""

    OK = 0
    ERROR_NULL = 1
    ERROR_STRUCT_SIZE = 2
    ERROR_CONFIG = 3
    ERROR_MEMORY = 4
    ERROR_NAN = 5
    ERROR_INVERTED = 6
    ERROR_HANDLE = 7
    ERROR_FULL = 8
    ERROR_BUSY = 9
    ERROR_NOT_A_PAIR = 10
    ERROR_CORRUPT = 11


class Grid(enum.IntEnum):
    """What holds the boxes: msap_grid."""

    AUTO = 0
    NONE = 1
    FIXED = 2


class Strategy(enum.IntEnum):
    """How a world is brought up to date: msap_strategy."""

    AUTO = 0
    SLIDE = 1
    MERGE = 2
    SWEEP = 3


class Simd(enum.IntEnum):
    """Which vector instructions may be used: msap_simd."""

    AUTO = 0
    NONE = 1
    SIMD_128 = 2
    SIMD_256 = 3
    SIMD_512 = 4


class Scalar(enum.IntEnum):
    """Number formats of bounds: msap_scalar."""

    FLOAT = 0
    DOUBLE = 1


class Bound(enum.IntEnum):
    """A bound of a box, as errors name it: msap_bound."""

    MIN_X = 0
    MIN_Y = 1
    MIN_Z = 2
    MAX_X = 3
    MAX_Y = 4
    MAX_Z = 5
    NO_BOUND = 6


# Each with the header's type and the prefix of its names there.
ENUMS = {
    "msap_status": (Status, "MSAP_"),
    "msap_grid": (Grid, "MSAP_GRID_"),
    "msap_strategy": (Strategy, "MSAP_STRATEGY_"),
    "msap_simd": (Simd, "MSAP_"),
    "msap_scalar": (Scalar, "MSAP_"),
    "msap_bound": (Bound, "MSAP_"),
}

STATUS_COUNT = 12
NULL_HANDLE = 0
MAX_BOXES = 2147483647
MARGIN_AUTO = -1.0
STATIC = 1
AXIS_AUTO = -1

# ---------------------------------------------------------------------- types

_SCALARS = {
    "void": None,
    "float": ctypes.c_float,
    "int32_t": ctypes.c_int32,
    "uint32_t": ctypes.c_uint32,
    "uint64_t": ctypes.c_uint64,
    "size_t": ctypes.c_size_t,
    "ptrdiff_t": ctypes.c_ssize_t,
    "msap_handle": ctypes.c_uint64,
    "msap_status": ctypes.c_int,
    "const char *": ctypes.c_char_p,
}

# What a callback returns, and what it is given.
CALLBACKS = {
    "msap_alloc_fn": ("void *", "void *", "size_t"),
    "msap_free_fn": ("void", "void *", "void *", "size_t"),
    "msap_task_fn": ("void", "void *"),
    "msap_enqueue_fn": ("void *", "void *", "msap_task_fn", "void *"),
    "msap_finish_fn": ("void", "void *", "void *"),
    "msap_create_fn": ("void *", "void *", "msap_handle", "msap_handle", "void *", "void *"),
    "msap_delete_fn": ("void", "void *", "msap_handle", "msap_handle", "void *", "void *", "void *"),
}

_callback_types: dict[str, type] = {}


def ctype(name):
    """The ctypes class for a type of the header; None for void."""
    if name in _SCALARS:
        return _SCALARS[name]
    if name in CALLBACKS:
        if name not in _callback_types:
            _callback_types[name] = ctypes.CFUNCTYPE(*map(ctype, CALLBACKS[name]))
        return _callback_types[name]
    if name.endswith("]"):
        item, count = name[:-1].split("[")
        return ctype(item) * int(count)
    if name.endswith("*"):
        return ctypes.c_void_p
    raise TypeError(f"{name}: not a type of multisap.h")


STRUCTS = {
    "msap_config": [
        ("struct_size", "uint32_t"),
        ("dims", "uint32_t"),
        ("grid", "uint32_t"),
        ("strategy", "uint32_t"),
        ("filters", "uint32_t"),
        ("simd", "uint32_t"),
        ("max_boxes", "uint32_t"),
        ("workers", "uint32_t"),
        ("task_grain", "uint32_t"),
        ("margin", "float"),
        ("cell_size", "float"),
        ("grid_cells", "uint32_t[3]"),
        ("grid_min", "float[3]"),
        ("grid_max", "float[3]"),
        ("alloc", "msap_alloc_fn"),
        ("free", "msap_free_fn"),
        ("allocator_user", "void *"),
        ("enqueue", "msap_enqueue_fn"),
        ("finish", "msap_finish_fn"),
        ("jobs_user", "void *"),
    ],
    "msap_boxes": [
        ("struct_size", "uint32_t"),
        ("scalar", "uint32_t"),
        ("min", "const void *"),
        ("max", "const void *"),
        ("min_row", "ptrdiff_t"),
        ("min_component", "ptrdiff_t"),
        ("max_row", "ptrdiff_t"),
        ("max_component", "ptrdiff_t"),
    ],
    "msap_pair": [
        ("a", "msap_handle"),
        ("b", "msap_handle"),
        ("user_data", "void *"),
    ],
    "msap_callbacks": [
        ("struct_size", "uint32_t"),
        ("reserved", "uint32_t"),
        ("context", "void *"),
        ("on_create", "msap_create_fn"),
        ("on_delete", "msap_delete_fn"),
    ],
    "msap_counts": [
        ("struct_size", "uint32_t"),
        ("reserved", "uint32_t"),
        ("created", "uint64_t"),
        ("deleted", "uint64_t"),
        ("active", "uint64_t"),
    ],
    "msap_error": [
        ("struct_size", "uint32_t"),
        ("status", "uint32_t"),
        ("index", "uint64_t"),
        ("bound", "uint32_t"),
        ("reserved", "uint32_t"),
    ],
    "msap_world_stats": [
        ("struct_size", "uint32_t"),
        ("reserved", "uint32_t"),
        ("boxes", "uint64_t"),
        ("pairs", "uint64_t"),
        ("pending", "uint64_t"),
        ("bytes", "uint64_t"),
        ("bytes_peak", "uint64_t"),
        ("allocations", "uint64_t"),
        ("commits", "uint64_t"),
        ("crossings", "uint64_t"),
        ("touched", "uint64_t"),
        ("slides", "uint64_t"),
        ("merges", "uint64_t"),
        ("sweeps", "uint64_t"),
        ("moves", "uint64_t"),
        ("cells", "uint64_t"),
        ("cells_empty", "uint64_t"),
        ("incidences", "uint64_t"),
        ("largest_cell", "uint64_t"),
        ("giants", "uint64_t"),
        ("candidates", "uint64_t"),
    ],
    "msap_index_pair": [
        ("a", "uint32_t"),
        ("b", "uint32_t"),
    ],
    "msap_prune_config": [
        ("struct_size", "uint32_t"),
        ("dims", "uint32_t"),
        ("axis", "int32_t"),
        ("reserved", "uint32_t"),
        ("alloc", "msap_alloc_fn"),
        ("free", "msap_free_fn"),
        ("allocator_user", "void *"),
    ],
}


def _structure(name):
    fields = [(field, ctype(type_name)) for field, type_name in STRUCTS[name]]
    return type(name, (ctypes.Structure,), {"_fields_": fields})


Config = _structure("msap_config")
Boxes = _structure("msap_boxes")
Pair = _structure("msap_pair")
Callbacks = _structure("msap_callbacks")
Counts = _structure("msap_counts")
Error = _structure("msap_error")
WorldStats = _structure("msap_world_stats")
IndexPair = _structure("msap_index_pair")
PruneConfig = _structure("msap_prune_config")

# ------------------------------------------------------------------ functions

# What a function returns, and its arguments.
FUNCTIONS = {
    "msap_version": ("uint32_t",),
    "msap_version_text": ("const char *",),
    "msap_status_text": ("const char *", "msap_status"),
    "msap_config_init": ("msap_status", "msap_config *", "size_t"),
    "msap_create": ("msap_status", "const msap_config *", "msap_world **"),
    "msap_destroy": ("msap_status", "msap_world *"),
    "msap_add": ("msap_status", "msap_world *", "const float *", "const float *", "uint32_t", "void *",
                 "msap_handle *"),
    "msap_add_many": ("msap_status", "msap_world *", "size_t", "const msap_boxes *", "const uint32_t *",
                      "void *const *", "msap_handle *"),
    "msap_update": ("msap_status", "msap_world *", "msap_handle", "const float *", "const float *"),
    "msap_update_many": ("msap_status", "msap_world *", "size_t", "const msap_handle *",
                         "const msap_boxes *"),
    "msap_remove": ("msap_status", "msap_world *", "msap_handle"),
    "msap_remove_many": ("msap_status", "msap_world *", "size_t", "const msap_handle *"),
    "msap_shift_origin": ("msap_status", "msap_world *", "const double *"),
    "msap_get_bounds": ("msap_status", "const msap_world *", "msap_handle", "float *", "float *"),
    "msap_get_user_data": ("msap_status", "const msap_world *", "size_t", "const msap_handle *", "void **"),
    "msap_set_user_data": ("msap_status", "msap_world *", "size_t", "const msap_handle *",
                           "void *const *"),
    "msap_commit": ("msap_status", "msap_world *", "const msap_callbacks *", "msap_counts *"),
    "msap_created": ("msap_status", "const msap_world *", "const msap_pair **", "size_t *"),
    "msap_deleted": ("msap_status", "const msap_world *", "const msap_pair **", "size_t *"),
    "msap_pairs": ("msap_status", "const msap_world *", "const msap_pair **", "size_t *"),
    "msap_get_pair_data": ("msap_status", "const msap_world *", "size_t", "const msap_handle *",
                           "const msap_handle *", "void **"),
    "msap_set_pair_data": ("msap_status", "msap_world *", "size_t", "const msap_handle *",
                           "const msap_handle *", "void *const *"),
    "msap_last_error": ("msap_status", "const msap_world *", "msap_error *"),
    "msap_stats": ("msap_status", "const msap_world *", "msap_world_stats *"),
    "msap_validate": ("msap_status", "const msap_world *", "const char **"),
    "msap_trim": ("msap_status", "msap_world *"),
    "msap_prune_config_init": ("msap_status", "msap_prune_config *", "size_t"),
    "msap_prune": ("msap_status", "const msap_prune_config *", "size_t", "const msap_boxes *",
                   "msap_index_pair **", "size_t *", "msap_error *"),
    "msap_prune_bipartite": ("msap_status", "const msap_prune_config *", "size_t", "const msap_boxes *",
                             "size_t", "const msap_boxes *", "msap_index_pair **", "size_t *",
                             "msap_error *"),
    "msap_prune_free": ("msap_status", "const msap_prune_config *", "msap_index_pair *", "size_t"),
    "msap_encode_float": ("uint32_t", "float"),
    "msap_decode_float": ("float", "uint32_t"),
}


def declare(library):
    """Gives the functions of a loaded library their types."""
    for name, (result, *arguments) in FUNCTIONS.items():
        function = getattr(library, name)
        function.restype = ctype(result)
        function.argtypes = [ctype(argument) for argument in arguments]
