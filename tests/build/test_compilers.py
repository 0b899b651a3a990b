# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The sources build bare, without any of our own flags, and the headers stand alone."""

import pytest
from conftest import MAKE, ROOT, makefile_list, run

STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror")


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_core_builds_with_one_bare_line(compiler, tmp_path):
    sources = [ROOT / source for source in makefile_list("CORE")]
    run(compiler, *STRICT, f"-I{ROOT / 'include'}", "-c", *sources, cwd=tmp_path)
    assert len(list(tmp_path.glob("*.o"))) == len(sources)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_header_is_c99_by_itself(compiler):
    run(compiler, *STRICT, "-x", "c", "-fsyntax-only", ROOT / "include/multisap.h")


@pytest.mark.parametrize("standard", ["c++98", "c++11", "c++20"])
def test_the_header_is_cpp_by_itself(standard, tmp_path):
    source = tmp_path / "user.cpp"
    source.write_text("#include <multisap.h>\nint main() { return msap_version() == 0; }\n")
    run("g++", f"-std={standard}", "-Wall", "-Wextra", "-Werror", f"-I{ROOT / 'include'}", "-fsyntax-only", source)


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_examples_build_without_a_warning(compiler):
    run(compiler, *STRICT, f"-I{ROOT / 'include'}", "-fsyntax-only", *ROOT.glob("examples/*.c"))


def test_the_core_builds_without_lcm(tmp_path):
    run(*MAKE, "all", f"BUILD={tmp_path}", "LCM=no")
    assert (tmp_path / "libmultisap.so").exists()
    assert not list(tmp_path.glob("libmultisap-lcm*"))
    assert "lcm" not in run("readelf", "-d", tmp_path / "multisap")
