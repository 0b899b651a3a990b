# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The Makefile, meson.build and the folders name the same files."""

import json
from fnmatch import fnmatch
from pathlib import Path

import pytest
from conftest import ROOT, makefile_list, run


def on_disk(pattern):
    return {str(path.relative_to(ROOT)) for path in ROOT.glob(pattern)}


@pytest.fixture(scope="module")
def in_meson(meson_made):
    """All sources that meson compiles, those that are generated left out."""
    targets = json.loads(run("meson", "introspect", "--targets", meson_made))
    groups = [group for target in targets for group in target["target_sources"]]
    return {str(Path(source).relative_to(ROOT)) for group in groups for source in group.get("sources", [])}


@pytest.mark.parametrize("name, pattern", [
    ("CORE", "src/*.c"),
    ("TOOL", "tools/*.c"),
    ("LCM_BINDING", "bindings/lcm/*.c"),
    ("LCM_TYPES", "bindings/lcm/*.lcm"),
])
def test_make_and_meson_build_every_source(in_meson, name, pattern):
    listed = set(makefile_list(name))
    assert {path for path in listed if fnmatch(path, pattern)} == on_disk(pattern)
    assert {path for path in in_meson if fnmatch(path, pattern)} == on_disk(pattern)
    assert listed <= in_meson


def test_every_example_is_built():
    assert on_disk("examples/*.c") <= set(makefile_list("EXAMPLES") + makefile_list("TOOL"))


def test_meson_runs_every_program_that_make_runs(meson_made):
    tests = {test["name"] for test in json.loads(run("meson", "introspect", "--tests", meson_made))}
    programs = on_disk("tests/unit/test_*.c")
    for name in ("EXAMPLES", "DIFFERENTIAL", "LCM_TEST"):
        programs.update(makefile_list(name))
    assert {Path(program).stem for program in programs} == tests - {"command"}
