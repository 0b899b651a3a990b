# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""multisap replay: answers, times, options."""

import json
import struct

import pytest
from traces import STATIC, addition, frame, removal, trace, update

FIELDS = ["trace", "frames", "boxes", "pairs", "ms_first_frame", "ms_per_frame_mean", "ms_per_frame_median",
          "ms_per_frame_p99", "ms_per_frame_max", "bytes"]
STRATEGIES = ["auto", "slide", "merge", "sweep"]
CELLS = ["auto", "1", "1x1", "4x4", "1x7", "64x3", "4096x1"]
INF, NAN = float("inf"), float("nan")


def write(multisap, data, name="scene.trace"):
    path = multisap.folder / name
    path.write_bytes(data)
    return path


def rows(text):
    """frame, boxes, pairs, created, deleted of each line."""
    return [tuple(map(int, line.split()[:5])) for line in text.splitlines()]


def with_hint(data, low, high):
    """A trace with other world bounds in its header."""
    return data[:20] + struct.pack("<6f", *low, *high) + data[44:]


def expect_exact(multisap, scene, *options):
    assert multisap.succeed("replay", "--answers", *options, scene) == scene.with_suffix(".answers").read_text()


@pytest.mark.parametrize("cells", ["auto", "1", "8x8"])
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_answers_are_exact_with_every_strategy(multisap, scene, strategy, cells):
    expect_exact(multisap, scene, "--strategy", strategy, "--cells", cells)


@pytest.mark.parametrize("threads", ["1", "2", "4"])
@pytest.mark.parametrize("cells", CELLS)
def test_answers_are_exact_with_any_cells_and_threads(multisap, scene, cells, threads):
    expect_exact(multisap, scene, "--cells", cells, "--threads", threads)


@pytest.mark.parametrize("margin", ["auto", "0", "0.05", "3", "3e38"])
def test_answers_are_exact_with_any_margin(multisap, scene, margin):
    expect_exact(multisap, scene, "--margin", margin, "--threads", "2")


def test_answers_of_a_small_scene(multisap):
    two = [addition(7, (0, 0, 0), (1, 1, 1)), addition(3, (1, 1, 1), (2, 2, 2))]
    apart = [update(7, (5, 0, 0), (6, 1, 1))]
    path = write(multisap, trace(frame(additions=two), frame(updates=apart), frame()))
    # One pair, 3 << 32 | 7; its hash by the reference code of splitmix64.
    assert multisap.succeed("replay", "--answers", path).splitlines() == [
        "0 2 1 1 0 950e0a0f498b7b6b", "1 2 0 0 1 0000000000000000", "2 2 0 0 0 0000000000000000"]


def test_a_box_may_be_added_and_updated_in_one_frame(multisap):
    first = frame(additions=[addition(0), addition(1, (5, 5, 5), (6, 6, 6))], updates=[update(1)])
    assert rows(multisap.succeed("replay", "--answers", write(multisap, trace(first)))) == [(0, 2, 1, 1, 0)]


def test_an_id_removed_and_added_in_one_frame_is_another_box(multisap):
    path = write(multisap, trace(frame(additions=[addition(0), addition(1)]),
                                 frame(removals=[removal(1)], additions=[addition(1)])))
    assert rows(multisap.succeed("replay", "--answers", path)) == [(0, 2, 1, 1, 0), (1, 2, 1, 1, 1)]


def test_the_last_update_of_a_frame_counts(multisap):
    updates = [update(1), update(1, (5, 5, 5), (6, 6, 6))]
    path = write(multisap, trace(frame(additions=[addition(0), addition(1)], updates=updates)))
    assert rows(multisap.succeed("replay", "--answers", path)) == [(0, 2, 0, 0, 0)]


def test_only_bit_0_of_the_flags_counts(multisap):
    other = 0xFFFFFFFE
    moving = [addition(0, flags=other), addition(1, flags=other)]
    static = [addition(2, flags=STATIC), addition(3, flags=other | STATIC)]
    path = write(multisap, trace(frame(additions=moving), frame(additions=static)))
    assert rows(multisap.succeed("replay", "--answers", path)) == [(0, 2, 1, 1, 0), (1, 4, 5, 4, 0)]


def test_2d_scenes(multisap):
    path = write(multisap, trace(frame(additions=[addition(0, (0, 0, 0), (1, 1, -0.0)),
                                                  addition(1, (1, 1, -0.0), (2, 2, 0))]), dims=2))
    assert rows(multisap.succeed("replay", "--answers", path)) == [(0, 2, 1, 1, 0)]


def test_ids_may_be_sparse_and_large(multisap):
    ids = [0, 5, 4_000_000_000, 4_294_967_294]
    path = write(multisap, trace(frame(additions=[addition(i) for i in ids]), max_ids=4_294_967_295))
    assert rows(multisap.succeed("replay", "--answers", path)) == [(0, 4, 6, 6, 0)]


def test_scenes_without_frames_or_boxes(multisap):
    assert multisap.succeed("replay", "--answers", write(multisap, trace())) == ""
    assert rows(multisap.succeed("replay", "--answers", write(multisap, trace(frame())))) == [(0, 0, 0, 0, 0)]


def test_json_has_the_fields(multisap, scene):
    line = multisap.succeed("replay", "--json", scene)
    assert line.count("\n") == 1
    record, answers = json.loads(line), rows(scene.with_suffix(".answers").read_text())
    assert list(record) == FIELDS
    assert record["trace"] == scene.stem
    assert record["frames"] == len(answers)
    assert record["boxes"] == max(row[1] for row in answers)
    assert record["pairs"] == max(row[2] for row in answers)
    assert record["bytes"] > 0
    assert 0 <= record["ms_first_frame"]
    assert 0 <= record["ms_per_frame_median"] <= record["ms_per_frame_p99"] <= record["ms_per_frame_max"]
    assert 0 <= record["ms_per_frame_mean"] <= record["ms_per_frame_max"]


def test_json_has_no_statistics_of_no_frames(multisap):
    record = json.loads(multisap.succeed("replay", "--json", write(multisap, trace(frame()))))
    assert record["ms_first_frame"] >= 0
    assert [record[name] for name in FIELDS if "per_frame" in name] == [None] * 4


def test_json_escapes_the_name(multisap):
    path = write(multisap, trace(frame()), 'a "b"\\\n.trace')
    assert json.loads(multisap.succeed("replay", "--json", path))["trace"] == 'a "b"\\\n'


def test_rounds_print_answers_once(multisap, scene):
    text = multisap.succeed("replay", "--answers", "--json", "--rounds", "3", scene)
    answers = scene.with_suffix(".answers").read_text()
    assert text.startswith(answers)
    assert json.loads(text[len(answers):])["frames"] == answers.count("\n")


def test_summary(multisap, scene):
    answers = rows(scene.with_suffix(".answers").read_text())
    text = multisap.succeed("replay", scene)
    assert text.startswith("%s: " % scene.stem)
    assert "boxes         %d at most\n" % max(row[1] for row in answers) in text
    assert "pairs         %d at most\n" % max(row[2] for row in answers) in text


@pytest.mark.parametrize("options", [
    ["--cells", "4096x4096"], ["--margin", "0.0"], ["--margin", "1e-45"], ["--threads", "64"], ["--rounds", "2"]])
def test_options_at_their_limits(multisap, options):
    two = frame(additions=[addition(0), addition(1)])
    assert rows(multisap.succeed("replay", "--answers", *options, write(multisap, trace(two)))) == [(0, 2, 1, 1, 0)]


# The scene: three boxes along one axis, two of them touching, and one far away.
@pytest.mark.parametrize("low, high", [
    ((-3e38, -3e38, 0), (3e38, 3e38, 1)),  # the widths are above FLT_MAX
    ((0, 0, 0), (1e-45, 1e-45, 0)),
    ((1, 2, 3), (1, 5, 8)),                # the narrowest axis may have no width
    ((-1, -1, -1), (-0.5, -0.5, -0.5))])   # boxes beyond the bounds
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_cells_lie_over_whatever_the_hint_says(multisap, low, high, axis):
    def at(*along):
        return tuple(tuple(value if k == axis else k for k in range(3)) for value in along)
    boxes = [addition(0, *at(0, 1)), addition(1, *at(1, 2)), addition(2, *at(3, 4)), addition(3, *at(3e38, INF))]
    path = write(multisap, with_hint(trace(frame(additions=boxes)), low, high))
    assert rows(multisap.succeed("replay", "--answers", "--cells", "4x6", path)) == [(0, 4, 1, 1, 0)]


@pytest.mark.parametrize("width, fits, refused, axis", [
    ((9, 0, 0), "4x1", "1x4", "y"), ((0, 9, 0), "1x4", "4x1", "x"), ((0, 0, 9), "1x4", "4x1", "x"),
    ((9, 0, 1), "4x4", "", ""), ((1, 9, 0), "4x4", "", ""), ((0, 1, 9), "4x4", "", "")])
def test_cells_lie_over_the_two_widest_axes_in_order(multisap, width, fits, refused, axis):
    path = write(multisap, with_hint(trace(frame(additions=[addition(0)])), (0, 0, 0), width))
    assert multisap.succeed("replay", "--answers", "--cells", fits, path)
    if refused:
        assert "axis %s, 0 to 0, have no width" % axis in multisap.fail(1, "replay", "--cells", refused, path)


@pytest.mark.parametrize("low, high, words", [
    ((NAN, 0, 0), (1, 1, 1), "axis x, nan to 1, are not finite"),
    ((0, 0, 0), (1, 1, NAN), "axis z, 0 to nan, are not finite"),
    ((0, -INF, 0), (1, 1, 1), "axis y, -inf to 1, are not finite"),
    ((0, 0, 2), (1, 1, -2), "axis z, 2 to -2, are inverted"),
    ((0, 5, 0), (1, 5, 0), "axis y, 5 to 5, have no width"),
    ((0, 0, 0), (0, 0, 0), "axis x, 0 to 0, have no width")])
def test_hints_that_no_cells_fit_are_refused(multisap, low, high, words):
    path = write(multisap, with_hint(trace(frame(additions=[addition(0)])), low, high))
    assert words in multisap.fail(1, "replay", "--cells", "4x4", path)
    for cells in "auto", "1", "1x1":
        assert rows(multisap.succeed("replay", "--answers", "--cells", cells, path)) == [(0, 1, 0, 0, 0)]


def test_one_row_of_cells_needs_no_second_width(multisap):
    path = write(multisap, with_hint(trace(frame(additions=[addition(0)])), (0, 0, 0), (1, 0, 0)))
    assert multisap.succeed("replay", "--answers", "--cells", "4x1", path)
    assert "axis y, 0 to 0, have no width" in multisap.fail(1, "replay", "--cells", "4x2", path)


def test_a_2d_scene_has_cells_in_its_plane(multisap):
    flat = trace(frame(additions=[addition(0, (0, 0, 0), (1, 1, 0))]), dims=2)
    path = write(multisap, with_hint(flat, (0, 0, -9), (1, 1, NAN)))  # z is not looked at
    assert multisap.succeed("replay", "--answers", "--cells", "4x4", path)


@pytest.mark.parametrize("options", [
    ["--cells", ""], ["--cells", "0"], ["--cells", "2"], ["--cells", "0x4"], ["--cells", "4x"],
    ["--cells", "x4"], ["--cells", "4x4x4"], ["--cells", "-1"], ["--cells", "1x99999999999999999999"],
    ["--cells", " 1"], ["--cells", "4097x1"], ["--cells", "4x4097"], ["--cells", "4 x4"], ["--cells", "4294967300x1"],
    ["--margin", "-1"], ["--margin", "nan"], ["--margin", "inf"], ["--margin", "1mm"], ["--margin", ""],
    ["--margin", "1e39"], ["--margin", "-0.0001"],
    ["--threads", "0"], ["--threads", "65"], ["--threads", "-1"], ["--threads", "two"], ["--threads", "1.5"],
    ["--rounds", "0"], ["--rounds", "-3"], ["--rounds", ""], ["--rounds", "99999999999999999999"],
    ["--strategy", "fast"], ["--strategy", ""], ["--speed"], ["-q"], ["--rounds"], ["--json=yes"]])
def test_options_that_make_no_sense_are_refused(multisap, options):
    line = multisap.fail(2, "replay", write(multisap, trace(frame())), *options)
    assert options[0].lstrip("-").split("=")[0] in line


@pytest.mark.parametrize("arguments, words", [
    (["replay"], "one trace is needed"), (["replay", "a", "b"], "one trace is needed"),
    (["stream"], "one trace is needed"), (["dance"], "no such command"),
    (["--dance"], "unrecognized option")])
def test_wrong_arguments_are_refused(multisap, arguments, words):
    assert words in multisap.fail(2, *arguments)


def test_without_a_command_the_usage_is_shown(multisap):
    done = multisap.run()
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("Usage: multisap ")


@pytest.mark.parametrize("command", [[], ["replay"], ["stream"]])
def test_help(multisap, command):
    assert multisap.succeed(*command, "--help").startswith("Usage: multisap " + " ".join(command))


def test_version(multisap):
    words = multisap.succeed("--version").split()
    assert words[0] == "multisap" and len(words[1].split(".")) == 3


def test_output_that_cannot_be_written_is_an_error(multisap, scene):
    with open("/dev/full", "w") as full:
        done = multisap.run("replay", "--answers", scene, stdout=full)
    assert done.returncode == 1
    assert "could not be written" in done.stderr and done.stderr.count("\n") == 1
