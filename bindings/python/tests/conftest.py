# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""What the tests of the Python package share.

They test the package that Python finds: an installed one, or the source folder on
PYTHONPATH with MULTISAP_LIBRARY naming a library. MULTISAP names the command
multisap, MULTISAP_DESCRIPTION the description of the header that the build made;
without the first some tests are skipped, without the second it is made here.
"""

import json
import os
import pathlib
import subprocess
import sys
import tempfile

import hypothesis
import numpy as np
import pytest

import multisap

# The same examples in every run, no clock, and nothing left in the folder of the caller.
os.environ.setdefault("HYPOTHESIS_STORAGE_DIRECTORY", os.path.join(tempfile.gettempdir(), "hypothesis"))
hypothesis.settings.register_profile("multisap", deadline=None, database=None, derandomize=True)
hypothesis.settings.load_profile("multisap")

PROJECT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture
def world():
    with multisap.World() as world:
        yield world
        world.validate()


@pytest.fixture
def rng():
    return np.random.default_rng(1)


@pytest.fixture(scope="session")
def description(tmp_path_factory):
    path = os.environ.get("MULTISAP_DESCRIPTION")
    if not path:
        path = tmp_path_factory.mktemp("header") / "multisap.json"
        tool = PROJECT / "bindings/python/describe_header.py"
        header = os.environ.get("MULTISAP_HEADER", PROJECT / "include/multisap.h")
        subprocess.run([sys.executable, str(tool), str(header), str(path)], check=True)
    return json.loads(pathlib.Path(path).read_text())


@pytest.fixture(scope="session")
def command():
    path = os.environ.get("MULTISAP")
    if not path:  # the package is also tested where only it is installed
        pytest.skip("MULTISAP does not name the command")
    return path


@pytest.fixture
def python(tmp_path):
    """Runs a script in another interpreter, in a folder of its own."""

    def run(script, **environment):
        return subprocess.run([sys.executable, "-c", script], cwd=tmp_path, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              env={**os.environ, **environment})

    return run
