# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""One scene, one and the same events: from C, from Python, and out of an LCM log."""

import subprocess

import numpy as np
import pytest

import multisap.lcm
import scenes

EVERY_SCENE = pytest.mark.parametrize("path", scenes.paths(), ids=lambda path: path.stem)


def test_there_are_scenes():
    assert len(scenes.paths()) >= 8


@EVERY_SCENE
@pytest.mark.parametrize("grid", [multisap.Grid.AUTO, multisap.Grid.NONE], ids=lambda grid: grid.name)
def test_python_gives_the_answers(path, grid):
    trace = scenes.Trace(path)
    with scenes.world_for(trace, grid=grid) as world:
        assert scenes.answers(trace, world) == scenes.answers_of(path)


@EVERY_SCENE
def test_c_gives_the_answers(path, command):
    printed = subprocess.run([command, "replay", "--answers", str(path)], check=True, text=True,
                             stdout=subprocess.PIPE).stdout
    assert printed.splitlines() == scenes.answers_of(path)


@EVERY_SCENE
def test_the_log_of_c_has_the_events_of_python(path, command, tmp_path):
    pytest.importorskip("lcm")  # an extra: tests from source do without it
    log = tmp_path / "scene.lcmlog"
    result = subprocess.run([command, "stream", "--url", f"file://{log}?mode=w", str(path)], text=True,
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    if "built without LCM" in result.stderr:
        pytest.skip("the command was built without LCM")
    assert result.returncode == 0, result.stderr
    trace = scenes.Trace(path)
    with scenes.world_for(trace) as world:
        logged = list(multisap.lcm.read_log(log))
        assert [events.seq for events in logged] == list(range(1, trace.frames + 1))
        for there, (here, _) in zip(logged, scenes.replay(trace, world)):
            assert there.since == there.seq - 1 and there.active == here.active
            assert np.array_equal(there.created, here.created)
            assert np.array_equal(there.deleted, here.deleted)
