# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Tests of the build: they make the project by both ways, each once, in folders of their own.

Nearly nothing is run that is made here, so it is made without optimization."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MAKE = ("make", "CFLAGS=-O0")


def run(*command, cwd=ROOT, **environment):
    """The standard output of a command that must succeed; nothing of an outer make is handed on."""
    clean = {k: v for k, v in os.environ.items() if k not in ("MAKEFLAGS", "MFLAGS", "MAKEOVERRIDES", "MAKELEVEL")}
    done = subprocess.run([str(word) for word in command], cwd=cwd, env={**clean, **environment}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, f"{' '.join(map(str, command))}\n{done.stdout}"
    return done.stdout


def makefile_list(name):
    """The words of a variable of the Makefile, as they are written there."""
    text = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    return re.search(rf"^{name} = (.*)$", text, re.MULTILINE).group(1).split()


def header_version():
    header = (ROOT / "include/multisap.h").read_text()
    return ".".join(re.search(rf"#define MSAP_VERSION_{part} (\d+)", header).group(1)
                    for part in ("MAJOR", "MINOR", "PATCH"))


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    """The output folder of make."""
    folder = tmp_path_factory.mktemp("make")
    run(*MAKE, "all", f"BUILD={folder}")
    return folder


@pytest.fixture(scope="session")
def meson_made(tmp_path_factory):
    """The output folder of meson."""
    folder = tmp_path_factory.mktemp("meson")
    run("meson", "setup", folder, "--prefix=/usr/local", "--libdir=lib", "-Doptimization=0")
    run("meson", "compile", "-C", folder)
    return folder
