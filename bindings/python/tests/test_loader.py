# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Which library is loaded, and what is said if it is the wrong one."""

import os
import shlex
import subprocess

import multisap

IMPORT = """
try:
    import multisap
except ImportError as error:
    print(error)
else:
    print("loaded", multisap.library_path)
"""


def library(tmp_path, source):
    """A shared library made of this C source."""
    path = tmp_path / "libother.so"
    path.with_suffix(".c").write_text(source)
    compiler = shlex.split(os.environ.get("CC", "cc"))
    subprocess.run([*compiler, "-shared", "-fPIC", "-o", str(path), str(path.with_suffix(".c"))], check=True)
    return str(path)


def said(python, path):
    result = python(IMPORT, MULTISAP_LIBRARY=path)
    assert (result.returncode, result.stderr) == (0, "")
    return result.stdout


def test_the_variable_names_the_library(python):
    path = os.path.abspath(multisap.library_path)
    assert said(python, path) == f"loaded {path}\n"


def test_no_other_library_takes_the_place_of_the_named_one(python):
    answer = said(python, "/nowhere/libmultisap.so")
    assert answer.startswith("no multisap library was found (MULTISAP_LIBRARY can name one): ")
    assert "/nowhere/libmultisap.so" in answer


def test_a_library_of_another_version(python, tmp_path):
    path = library(tmp_path, "unsigned msap_version(void) { return 10203; }\n")
    assert said(python, path) == (f"the Python package multisap {multisap.__version__} needs the library "
                                  f"multisap 0.1.x, but {path} is 1.2.3\n")


def test_another_patch_is_no_other_version(python, tmp_path):
    """It passes the check, and only then the rest of the library is missed."""
    path = library(tmp_path, "unsigned msap_version(void) { return 107; }\n")
    result = python(IMPORT, MULTISAP_LIBRARY=path)
    assert "AttributeError" in result.stderr and "msap_version_text" in result.stderr


def test_a_library_that_is_none_of_ours(python, tmp_path):
    path = library(tmp_path, "int other(void) { return 0; }\n")
    assert said(python, path) == f"{path} is not a multisap library: it has no msap_version\n"


def test_a_file_that_is_no_library(python, tmp_path):
    path = tmp_path / "text.so"
    path.write_text("text")
    assert str(path) in said(python, str(path))
