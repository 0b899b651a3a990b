# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""An interpreter that ends while worlds are there says nothing."""

import pytest

START = """
import numpy as np, multisap
world = multisap.World()
lo = np.random.default_rng(1).random((300, 3)) * 5
ids = world.add(lo, lo + 1)
world.commit()
"""

ENDINGS = {
    "a global world": "",
    "in a cycle": "world.me = world",
    "in a module": "import multisap as m; m.world = world; del world",
    "kept by an object with __del__": """
class Keeper:
    def __init__(self, world): self.world = world
    def __del__(self): self.world.close()
keeper = Keeper(world)
""",
    "closed at exit": "import atexit; atexit.register(world.close)",
    "collected at exit": "import atexit, gc; atexit.register(lambda: (globals().pop('world'), gc.collect()))",
    "with an allocator in Python": """
import ctypes
held = {}
def alloc(user, size):
    block = ctypes.create_string_buffer(size)
    held[ctypes.addressof(block)] = block
    return ctypes.addressof(block)
def free(user, pointer, size):
    del held[pointer]
mine = multisap.World(alloc=multisap.AllocFunction(alloc), free=multisap.FreeFunction(free))
mine.add(lo, lo + 1)
mine.commit()
""",
    "while a daemon thread commits": """
import threading
started = threading.Event()
def run():
    while True:
        world.update(ids, lo, lo + 1)
        world.commit()
        started.set()
threading.Thread(target=run, daemon=True).start()
started.wait()
""",
    "after fork": """
import os
child = os.fork()
if child:
    assert os.waitpid(child, 0)[1] == 0
world.update(ids, lo + 1, lo + 2)
world.commit()
""",
}


@pytest.mark.parametrize("ending", ENDINGS)
def test_exit_is_quiet(python, ending):
    result = python(START + ENDINGS[ending])
    assert (result.returncode, result.stdout, result.stderr) == (0, "", "")


def test_exit_from_a_callback(python):
    result = python(START + """
import sys
world.remove(ids)
world.commit(on_delete=lambda *arguments: sys.exit(7))
""")
    assert (result.returncode, result.stdout, result.stderr) == (7, "", "")
