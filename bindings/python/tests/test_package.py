# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""What `pip install .` installs."""

import importlib.metadata
import pathlib
import re

import pytest

import multisap
from conftest import PROJECT

SOURCE = PROJECT / "bindings/python/multisap"


@pytest.fixture(scope="module")
def installed():
    try:
        distribution = importlib.metadata.distribution("multisap")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("multisap is not installed here")
    if pathlib.Path(multisap.__file__) != pathlib.Path(distribution.locate_file("multisap/__init__.py")):
        pytest.skip("the package under test is not the installed one")
    return distribution


def test_the_wheel_is_for_every_python_of_the_platform(installed):
    (tag,) = re.findall("^Tag: (.*)$", installed.read_text("WHEEL"), re.MULTILINE)
    assert re.fullmatch(r"py3-none-(?!any)\w+", tag)


def test_the_library_inside_the_wheel_is_used(installed):
    folder = installed.locate_file(".multisap.mesonpy.libs")
    assert pathlib.Path(multisap.library_path).parent == pathlib.Path(folder)


def test_the_wheel_holds_the_package_and_the_library(installed):
    files = [str(file) for file in installed.files
             if ".dist-info/" not in str(file) and "__pycache__" not in str(file)]
    libraries = [file for file in files if file.startswith(".multisap.mesonpy.libs/")]
    assert len(libraries) == 1
    assert {file for file in files if file not in libraries} == {
        f"multisap/{path.name}" for path in SOURCE.iterdir() if path.is_file()}


def test_numpy_is_all_that_is_needed(installed):
    needed = [requirement for requirement in installed.requires if "extra" not in requirement]
    assert len(needed) == 1 and needed[0].startswith("numpy")
    assert any(re.fullmatch(r"lcm.*extra == .lcm.", requirement) for requirement in installed.requires)


def test_the_version_is_the_librarys(installed):
    assert installed.version == multisap.__version__


def test_the_build_lists_every_file_of_the_package():
    listed = re.findall(r"'multisap/([\w.]+)'", (SOURCE.parent / "meson.build").read_text())
    assert sorted(listed) == sorted(path.name for path in SOURCE.iterdir() if path.is_file())
