# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""docs/python.md shows what is true, and the examples print what it says."""

import doctest
import os
import re
import subprocess
import sys

import pytest

import multisap
from conftest import PROJECT

TEXT = (PROJECT / "docs/python.md").read_text()
EXAMPLES = PROJECT / "examples/python"

# A program, its name, and the output that is shown for it.
SHOWN = {name: (code, printed) for name, code, printed in re.findall(
    r"^```python (\S+)\n(.*?)^```$.*?^```text\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)}


def test_every_example_is_shown():
    assert SHOWN.keys() == {path.name for path in EXAMPLES.glob("*.py")}
    assert len(re.findall(r"^```python", TEXT, re.MULTILINE)) == len(SHOWN)


@pytest.mark.parametrize("name", SHOWN)
def test_what_is_shown_is_the_example(name):
    source = (EXAMPLES / name).read_text()
    assert source.split("SPDX-License-Identifier: MIT\n\n", 1)[1] == SHOWN[name][0]


def run(name, folder, *arguments):
    return subprocess.run([sys.executable, str(EXAMPLES / name), *arguments], cwd=folder, check=True, text=True,
                          stdout=subprocess.PIPE).stdout


def test_particles(tmp_path):
    assert run("particles.py", tmp_path) == SHOWN["particles.py"][1]


def test_check_scene(tmp_path):
    trimesh = pytest.importorskip("trimesh")  # tests from source do without it
    assert run("check_scene.py", tmp_path) == SHOWN["check_scene.py"][1]
    scene = trimesh.Scene([trimesh.creation.box((1, 1, 1)), trimesh.creation.icosphere(radius=3)])
    scene.export(tmp_path / "scene.glb")
    assert run("check_scene.py", tmp_path, "scene.glb") == "geometry_0 and geometry_1\n"


def test_follow_stream(tmp_path, command):
    pytest.importorskip("lcm")  # an extra: tests from source do without it
    line = re.search(r"^multisap (stream .*)$", TEXT, re.MULTILINE).group(1)
    url, scene = re.fullmatch(r"stream --url '(.*)' (\S+)", line).groups()
    subprocess.run([command, "stream", "--url", url, str(PROJECT / scene)], cwd=tmp_path, check=True,
                   stdout=subprocess.DEVNULL)
    (log,) = os.listdir(tmp_path)
    assert run("follow_stream.py", tmp_path, log) == SHOWN["follow_stream.py"][1]


def test_sessions():
    """All sessions of the manual are one, from top to bottom."""
    sessions = re.findall(r"^```pycon\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)
    assert len(sessions) > 5
    test = doctest.DocTestParser().get_doctest("".join(sessions), {}, "python.md", "python.md", 0)
    report = []
    assert doctest.DocTestRunner().run(test, out=report.append).failed == 0, "".join(report)


def test_every_exception_and_option_is_named():
    errors = {name for name in multisap.__all__ if name.endswith("Error")} - {"MultisapError"}
    assert errors == set(re.findall(r"^\| `(\w+Error)` \|", TEXT, re.MULTILINE))
    table = TEXT.split("| keyword | |")[1].split("\n\n")[0]
    options = set(multisap.World.__init__.__annotations__) - {"return"}
    assert options <= set(re.findall(r"`(\w+)`", table))


def test_links():
    for target in re.findall(r"\]\(([^)]+)\)", TEXT):
        assert (PROJECT / "docs" / target).exists(), target
