# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The set-up installs what is missing and nothing else; apt-get is a stand-in that notes what it is asked for."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

APT_GET = """#!/bin/sh
echo "$*" >> "${0%/*}/apt.log"
case "$*" in *" $APT_BRINGS") ln -s /bin/true "${0%/*}/$APT_BRINGS" ;; esac
"""


def script(path, text):
    path.write_text(text)
    path.chmod(0o755)


@pytest.fixture
def commands(tmp_path):
    """A folder that holds all commands of this machine, with the stand-ins in their places."""
    script(tmp_path / "apt-get", APT_GET)
    script(tmp_path / "sudo", "#!/bin/sh\nexit 1\n")
    script(tmp_path / "id", "#!/bin/sh\necho 0\n")
    script(tmp_path / "python3", f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    for folder in map(Path, os.environ["PATH"].split(":")):
        for command in folder.iterdir() if folder.is_dir() else ():
            if not os.path.lexists(tmp_path / command.name):
                (tmp_path / command.name).symlink_to(command)
    return tmp_path


def set_up(commands, what, brings=""):
    """Exit status, output, and the lines that apt-get was given."""
    done = subprocess.run([ROOT / ".ci/setup", what], env={"PATH": str(commands), "APT_BRINGS": brings}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    log = commands / "apt.log"
    return done.returncode, done.stdout, log.read_text().splitlines() if log.exists() else []


@pytest.mark.parametrize("what", ["run", "check"])
def test_it_is_quiet_when_nothing_is_missing(commands, what):
    assert set_up(commands, what) == (0, "", [])


def test_it_installs_what_is_missing_alone(commands):
    (commands / "clang").unlink()
    status, output, asked = set_up(commands, "check", brings="clang")
    assert (status, output) == (0, "setup: installing clang\n")
    assert len(asked) == 2
    assert asked[0].endswith("update") and asked[1].endswith("install --no-install-recommends clang")


def test_it_uses_sudo_where_it_is_not_root(commands):
    (commands / "clang").unlink()
    for name, text in {"id": "echo 1000", "sudo": 'touch "${0%/*}/sudo.used"; exec "$@"'}.items():
        (commands / name).unlink()
        script(commands / name, f"#!/bin/sh\n{text}\n")
    assert set_up(commands, "check", brings="clang")[0] == 0
    assert (commands / "sudo.used").exists()


def test_run_asks_for_nothing_that_only_the_tests_use(commands):
    (commands / "clang").unlink()
    assert set_up(commands, "run") == (0, "", [])


def test_it_says_when_the_installation_did_not_help(commands):
    (commands / "clang").unlink()
    status, output, _ = set_up(commands, "check")
    assert (status, output.splitlines()[-1]) == (1, "setup: still missing after the installation: clang")


def test_it_names_the_packages_where_there_is_no_apt(commands):
    (commands / "clang").unlink()
    (commands / "apt-get").unlink()
    status, output, _ = set_up(commands, "check")
    assert (status, output.count("\n")) == (1, 1) and output.endswith(": clang\n")
