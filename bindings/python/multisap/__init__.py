# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Which axis-aligned boxes overlap, and which pairs came and went.

    import numpy as np, multisap

    with multisap.World() as world:
        ids = world.add(lo, hi)            # boxes come: (n, 3) arrays of mins and maxes,
        world.update(ids, lo + 1, hi + 1)  # move
        world.remove(ids[:5])              # and go;
        events = world.commit()            # then the pairs are asked for
        events.created, events.deleted     # (k, 2) arrays of ids

multisap.prune finds the pairs of boxes in one shot. multisap.lcm follows a stream of
pair events over LCM. The C header multisap.h says exactly what a pair is, what
order events have, and what is promised.
"""

from ._api import (MARGIN_AUTO, MAX_BOXES, NULL_HANDLE, VERSION, Bound, Grid, Simd, Status,
                   Strategy)
from ._arrays import Pair, PairArray
from ._config import AllocFunction, EnqueueFunction, FinishFunction, FreeFunction, TaskFunction
from ._errors import (BoundsError, BusyError, ConfigError, CorruptError, FullError, HandleError,
                      MultisapError, NotAPairError, OutOfMemoryError)
from ._library import path as library_path
from ._numbers import decode_float, encode_float
from ._prune import prune
from ._world import Events, Stats, World

__version__ = ".".join(map(str, VERSION))

__all__ = [
    "MARGIN_AUTO", "MAX_BOXES", "NULL_HANDLE", "AllocFunction", "Bound", "BoundsError", "BusyError",
    "ConfigError", "CorruptError", "EnqueueFunction", "Events", "FinishFunction", "FreeFunction",
    "FullError", "Grid", "HandleError", "MultisapError", "NotAPairError", "OutOfMemoryError", "Pair",
    "PairArray", "Simd", "Stats", "Status", "Strategy", "TaskFunction", "World", "__version__",
    "decode_float", "encode_float", "library_path", "prune",
]
