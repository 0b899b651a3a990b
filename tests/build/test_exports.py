# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""What the libraries show to a linker, and what they ask of it."""

import re

from conftest import ROOT, header_version, makefile_list, run


def exported(library):
    """(kind, name) of what a shared library defines, its version node left out."""
    lines = run("nm", "-D", "--defined-only", library).splitlines()
    return {(kind, name.split("@")[0]) for _, kind, name in map(str.split, lines) if kind != "A"}


def dynamic_entries(library, tag):
    return re.findall(rf"\({tag}\).*\[(.*)\]", run("readelf", "-d", library))


def test_the_library_exports_the_listed_functions_and_no_data(made, meson_made):
    listed = {("T", name) for name in (ROOT / "src/multisap.symbols").read_text().split()}
    assert exported(made / "libmultisap.so") == listed
    assert exported(meson_made / "libmultisap.so") == listed


def test_the_list_is_what_the_header_declares():
    header = re.sub(r"/\*.*?\*/", "", (ROOT / "include/multisap.h").read_text(), flags=re.DOTALL)
    declared = re.findall(r"^MSAP_API [^(;]*?(msap_\w+)\(", header, re.MULTILINE)
    assert (ROOT / "src/multisap.symbols").read_text().split() == sorted(declared)


def test_the_core_needs_libc_alone(made, meson_made):
    for folder in (made, meson_made):
        needed = dynamic_entries(folder / "libmultisap.so", "NEEDED")
        assert all(name.startswith("libc.so") for name in needed), needed


def test_the_soname_is_that_of_the_interface(made, meson_made):
    for folder in (made, meson_made):
        assert dynamic_entries(folder / "libmultisap.so", "SONAME") == ["libmultisap.so.0"]
        assert (folder / "libmultisap.so").resolve().name == f"libmultisap.so.{header_version()}"


def test_the_core_has_no_global_that_can_be_written(tmp_path):
    """Built without -fPIC, which would move constant tables of pointers into writable sections."""
    sources = [ROOT / source for source in makefile_list("CORE")]
    run("gcc", "-std=c99", "-fno-pic", f"-I{ROOT / 'include'}", "-c", *sources, cwd=tmp_path)
    symbols = run("nm", "--defined-only", "--no-sort", *tmp_path.glob("*.o"))
    assert re.findall(r"^\w+ [BbCcDdGgSs] (\w+)", symbols, re.MULTILINE) == []


def test_what_the_static_library_adds_to_a_program_begins_with_msap(made):
    lines = run("nm", "-g", "--defined-only", made / "libmultisap.a").splitlines()
    names = [line.split()[2] for line in lines if len(line.split()) == 3]
    assert names and all(name.startswith("msap_") for name in names)
