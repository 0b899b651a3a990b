# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""What is installed can be used from elsewhere, whichever build installed it."""

import pytest
from conftest import MAKE, ROOT, header_version, run


@pytest.fixture(scope="session", params=["make", "meson"])
def installed(request, tmp_path_factory):
    """The root below which /usr/local was filled."""
    destination = tmp_path_factory.mktemp("installed")
    if request.param == "make":
        run(*MAKE, "install", f"BUILD={request.getfixturevalue('made')}", f"DESTDIR={destination}")
    else:
        run("meson", "install", "-C", request.getfixturevalue("meson_made"), DESTDIR=str(destination))
    return destination


def pkg_config(installed, *arguments):
    folder = installed / "usr/local/lib/pkgconfig"
    return run("pkg-config", *arguments, PKG_CONFIG_PATH=str(folder), PKG_CONFIG_SYSROOT_DIR=str(installed)).split()


def test_both_builds_install_the_same_files(made, meson_made, tmp_path):
    def files(folder):
        return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir()}
    run(*MAKE, "install", f"BUILD={made}", f"DESTDIR={tmp_path / 'make'}")
    run("meson", "install", "-C", meson_made, DESTDIR=str(tmp_path / "meson"))
    assert files(tmp_path / "make") == files(tmp_path / "meson")


def test_a_program_builds_with_pkg_config(installed, tmp_path):
    program = tmp_path / "game_loop"
    run("gcc", ROOT / "examples/game_loop.c", "-o", program, *pkg_config(installed, "--cflags", "--libs", "multisap"))
    assert "1 began" in run(program, LD_LIBRARY_PATH=str(installed / "usr/local/lib"))


def test_pkg_config_tells_the_version(installed):
    assert pkg_config(installed, "--modversion", "multisap") == [header_version()]


def test_the_command_is_installed(installed):
    command, libraries = installed / "usr/local/bin/multisap", installed / "usr/local/lib"
    assert run(command, "--version", LD_LIBRARY_PATH=str(libraries)) == f"multisap {header_version()}\n"
