# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""From keyword arguments to an msap_config."""

from __future__ import annotations

import ctypes
import operator

from . import _api
from ._errors import make_error
from ._library import lib

# For those who write hooks in Python, and for annotations.
AllocFunction = _api.ctype("msap_alloc_fn")
FreeFunction = _api.ctype("msap_free_fn")
TaskFunction = _api.ctype("msap_task_fn")
EnqueueFunction = _api.ctype("msap_enqueue_fn")
FinishFunction = _api.ctype("msap_finish_fn")

_FIELDS = dict(_api.STRUCTS["msap_config"])


def _refusal(name, value):
    return make_error(_api.Status.ERROR_CONFIG, text=f"{name}={value!r} is not allowed")


def _uint32(name, value):
    """ctypes would cut off what does not fit."""
    number = operator.index(value)
    if not 0 <= number < 1 << 32:
        raise _refusal(name, value)
    return number


def _pointer(name, value, kind):
    try:
        return ctypes.cast(value, kind)
    except ctypes.ArgumentError:
        raise TypeError(f"{name} must be a pointer or a C function, not {type(value).__name__}") from None


def _set(config, name, value):
    kind = _FIELDS[name]
    if kind.endswith("]"):
        row = getattr(config, name)
        if len(value) > len(row):
            raise _refusal(name, value)
        for i, item in enumerate(value):
            row[i] = _uint32(name, item) if kind.startswith("uint32_t") else item
    elif kind == "uint32_t":
        setattr(config, name, _uint32(name, value))
    elif kind == "float":
        setattr(config, name, value)
    else:
        setattr(config, name, _pointer(name, value, _api.ctype(kind)))


def make_config(options):
    """The defaults, with those options in place that are not None. It must outlive the world:
    it keeps the hooks alive."""
    config = _api.Config()
    status = lib.msap_config_init(ctypes.byref(config), ctypes.sizeof(config))
    if status:
        raise make_error(status)
    for name, value in options.items():
        if value is not None:
            _set(config, name, value)
    return config
