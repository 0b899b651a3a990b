# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Finds and loads the C library, once, and checks that it is the right one.

Looked for, in this order: what the environment variable MULTISAP_LIBRARY names (and
then nothing else); the library inside the wheel; the system's. It is loaded as a
CDLL, which lets other threads run while the library works.
"""

from __future__ import annotations

import ctypes
import os
import pathlib
import sys

from . import _api


def _system_name():
    """By soname: this is the library of this ABI, or none."""
    if sys.platform == "win32":
        return "multisap-0.dll"
    if sys.platform == "darwin":
        return "libmultisap.0.dylib"
    return "libmultisap.so.0"


def _candidates():
    named = os.environ.get("MULTISAP_LIBRARY")
    if named:
        return [named]
    wheel = pathlib.Path(__file__).parent.parent / ".multisap.mesonpy.libs"
    return [*sorted(map(str, wheel.glob("*multisap*"))), _system_name()]


def _check_version(library, path):
    """The tables are of one major and minor version; patches differ in nothing that is seen here."""
    try:
        library.msap_version.restype = ctypes.c_uint32
        number = library.msap_version()
    except AttributeError:
        raise ImportError(f"{path} is not a multisap library: it has no msap_version") from None
    found = (number // 10000, number // 100 % 100, number % 100)
    if found[:2] != _api.VERSION[:2]:
        raise ImportError("the Python package multisap {}.{}.{} needs the library multisap {}.{}.x, "
                          "but {} is {}.{}.{}".format(*_api.VERSION, *_api.VERSION[:2], path, *found))


def _load():
    complaints = []
    for path in _candidates():
        try:
            library = ctypes.CDLL(path)
        except OSError as error:
            complaints.append(str(error))
            continue
        _check_version(library, path)
        _api.declare(library)
        return library, path
    raise ImportError("no multisap library was found (MULTISAP_LIBRARY can name one): "
                      + "; ".join(complaints))


lib, path = _load()
