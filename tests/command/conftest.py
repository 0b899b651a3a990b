# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Runs the command under test: $MULTISAP, or build/multisap."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMMAND = os.path.abspath(os.environ.get("MULTISAP", ROOT / "build" / "multisap"))


class Command:
    """The command, run in a folder of the test's own."""

    def __init__(self, folder):
        self.folder = folder

    def run(self, *arguments, stdout=subprocess.PIPE, **keywords):
        environment = dict(os.environ, LC_ALL="C")
        environment.pop("LCM_DEFAULT_URL", None)
        return subprocess.run(
            [COMMAND, *map(str, arguments)], cwd=self.folder, env=environment, text=True, timeout=120,
            stdin=subprocess.DEVNULL, stdout=stdout, stderr=subprocess.PIPE, **keywords)

    def succeed(self, *arguments, **keywords):
        """Runs it, expects exit status 0 and nothing on stderr, returns stdout."""
        done = self.run(*arguments, **keywords)
        assert (done.returncode, done.stderr) == (0, ""), done
        return done.stdout

    def fail(self, status, *arguments, **keywords):
        """Runs it, expects an exit status and one line on stderr alone, returns the line."""
        done = self.run(*arguments, **keywords)
        assert done.returncode == status, done
        assert done.stdout == "", done
        assert done.stderr.count("\n") == 1 and done.stderr.startswith("multisap: "), done
        return done.stderr.rstrip("\n")


@pytest.fixture
def multisap(tmp_path):
    return Command(tmp_path)


@pytest.fixture(params=sorted((ROOT / "tests" / "scenes").glob("*.trace")), ids=lambda path: path.stem)
def scene(request):
    """Each scene that comes with the project."""
    return request.param


@pytest.fixture
def with_lcm(multisap):
    """For tests that stream: a build without LCM only says that it cannot (test_without_lcm)."""
    if "without LCM" in multisap.run("stream", "any.trace").stderr:
        pytest.skip("this build of the command has no LCM")
