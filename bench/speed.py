# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Measures speed and memory, beside peers where there are any: what `make bench` does.

Runs bench/speed, and replays scenes by the programs that have modes (bench/replay and
those of bench/accuracy), in rounds, so that what is compared runs at about the same time.
A frame's time is the shortest of all rounds. A ratio is of the sums over all frames after
the first, since both pay alike for what else the machine does; the median of the rounds
counts. Prints the tables, writes them into the page's measured part, and beside the
programs all figures as CSV; beside the page a plot, if there is matplotlib.
"""
import argparse
import csv
import json
import math
import statistics
import struct
import subprocess
import sys
from pathlib import Path

import claims

ROOT = Path(__file__).resolve().parents[1]
RECORDED = ["jolt_ragdolls", "box2d_tumbler", "pybullet_tray"]
MADE = ["churn", "giants", "level_load"]
BASE, THREADS, FLOOR = "multisap", "multisap, 2 threads", "floor"
BEGIN, END = "<!-- measured -->", "<!-- end of what was measured -->"

# ------------------------------------------------------------------- measuring


def scenes_in(folder, speed):
    """{name: trace}: recorded ones, made ones, and the generator's, which are written into the folder."""
    folder.mkdir(exist_ok=True)
    names = subprocess.run([speed, "traces", folder], capture_output=True, text=True, check=True).stdout.split()
    traces = {name: ROOT / "tests/scenes" / (name + ".trace") for name in RECORDED + MADE}
    return traces | {name: folder / (name + ".trace") for name in names}


def list_modes(programs):
    """Yields (mode, program)."""
    for program in programs:
        names = subprocess.run([program, "--list"], stdout=subprocess.PIPE, text=True, check=True).stdout
        yield from ((mode, program) for mode in names.splitlines())


def run(*command):
    """The milliseconds of each frame; nothing if the program crashed or never ended."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=60)
        return json.loads(done.stdout)["ms"] if done.returncode == 0 else []
    except (json.JSONDecodeError, subprocess.TimeoutExpired):
        return []


def replay(scene, modes, rounds, limit):
    """{mode: [[ms of each frame] of each round]}; who has crashed or run out of time once is not asked again."""
    times, lost = {}, set()
    for number in range(rounds):
        turn = number * 5 % len(modes)
        for mode, program in modes[turn:] + modes[:turn]:
            ms = [] if mode in lost else run(program, mode, scene, str(limit))
            if len(ms) > 2:
                times.setdefault(mode, []).append(ms)
            else:
                lost.add(mode)
    return times


def ratio_of(frames, base):
    """How many times the base's time all frames after the first take, as far as both have them."""
    both = min(len(frames), len(base))
    return sum(frames[1:both]) / sum(base[1:both])


class Replay:
    """A mode's frames in a scene, beside the base's."""

    def __init__(self, rounds, base):
        frames = [min(ms) for ms in zip(*rounds)]
        self.frames, self.first, rest = len(frames), frames[0], sorted(frames[1:])
        self.median, self.mean, self.worst = statistics.median(rest), statistics.mean(rest), rest[-1]
        self.p99 = rest[math.ceil(0.99 * len(rest)) - 1]
        self.ratios = sorted(map(ratio_of, rounds, base))
        self.ratio = statistics.median(self.ratios)


def boxes_of(trace):
    """How many ids the header of a trace has."""
    with open(trace, "rb") as file:
        return struct.unpack("<8s3I", file.read(20))[2]


def replay_all(traces, modes, arguments):
    """{scene: {mode: Replay}}"""
    found = {}
    for name, trace in traces.items():
        print("bench: %s" % name, file=sys.stderr)
        times = replay(trace, modes, arguments.rounds, arguments.limit)
        if {BASE, FLOOR, THREADS} <= times.keys():
            found[name] = {mode: Replay(rounds, times[BASE]) for mode, rounds in times.items()}
    return found


# --------------------------------------------------------------------- tables


def over(part, whole):
    """How many times the whole; nothing where that is too short for the clock."""
    return claims.number(part / whole) if whole > 1e-4 else "–"


def frame_table(replays, traces):
    yield from claims.table(
        ["scene", "boxes", "median", "mean", "p99", "worst", "first frame", "p99 / median", "floor", "times the floor",
         "2 threads"],
        [[name, claims.number(boxes_of(traces[name]))]
         + [claims.number(getattr(row[BASE], what)) for what in ("median", "mean", "p99", "worst", "first")]
         + [over(row[BASE].p99, row[BASE].median), claims.number(row[FLOOR].median),
            over(row[BASE].median, row[FLOOR].median), claims.number(row[THREADS].ratio)]
         for name, row in replays.items()])


def ratio_cell(row):
    return "%s (%s)" % (claims.number(row.ratio), claims.between(row.ratios[0], row.ratios[-1]))


def mean_ratio(replays, mode):
    ratios = [row[mode].ratio for row in replays.values() if mode in row]
    return claims.number(statistics.geometric_mean(ratios)) if ratios else "–"


def peer_table(replays, modes):
    """Times the base's: scenes down, modes across."""
    names = [mode for mode, _ in modes if mode not in (BASE, FLOOR, THREADS)]
    rows = [[scene] + [ratio_cell(row[mode]) if mode in row else "–" for mode in names]
            for scene, row in replays.items()]
    rows.append(["geometric mean"] + [mean_ratio(replays, mode) for mode in names])
    yield from claims.table(["times multisap"] + names, rows)


def growth_table(results):
    rows = []
    for claim, text in (("growth-drift", "all drift"), ("growth-jump", "all jump anywhere")):
        by_size = results.time[claim]
        rows.append([text] + [claims.number(ways[BASE][0]) for ways in by_size.values()]
                    + ["%.2f" % claims.exponent(results, claim, BASE)])
    sizes = [claims.label(size) for size in results.time["growth-drift"]]
    yield from claims.table(["milliseconds a frame"] + sizes + ["exponent"], rows)


def threads_table(results):
    """The gain of the second thread: of the library's, and of a plain loop's over the same data."""
    rows = []
    for scene, ways in results.time["threads"].items():
        gain, plain = (1 / of[scene]["2 threads"][1] for of in (results.time["threads"], results.time["threads-plain"]))
        rows.append([scene, claims.number(ways["1 thread"][0]), claims.number(ways["2 threads"][0]),
                     claims.number(gain), claims.number(plain), claims.number(gain / plain)])
    yield from claims.table(
        ["scene", "1 thread, ms", "2 threads, ms", "gain", "gain of a plain loop", "share of it"], rows)


def rest_table(results):
    rows = [[scene, claims.number(value) + " " + what] for claim in ("bulk", "rest")
            for scene, row in results.count[claim].items() for what, value in row.items()]
    yield from claims.table(["1,000,000 boxes", "a commit"], rows)


def memory_lines(results):
    yield from claims.count_table(results, "memory")
    yield from claims.paragraph(
        "By the library's own count: the most that it ever held, with room to grow, an eighth of each array; what it "
        "held after the last frame; and what after `msap_trim`, until the next commit makes all that it keeps anew. "
        "Where most boxes move, rows and candidate pairs, pairs whose skins overlap, are held twice while new ones are "
        "made and the present ones serve.")


def measured(results, replays, traces, modes, rounds):
    """What stands between the marks of the page."""
    yield from ("- %s: %s" % item for item in results.machine.items() if item[1])
    yield "- rounds: %d" % rounds
    yield from ("", "### Frames", "")
    yield from claims.paragraph(
        "Milliseconds a frame with the defaults, each frame's the shortest of the rounds; all but the first frame, "
        "in which the boxes come. The floor reads every update once and writes every event once in plain loops. "
        "The last column is the time with two threads, times that with one, by the clock.")
    yield from frame_table(replays, traces)
    yield from ("### Beside others", "")
    yield from claims.paragraph(
        "What others take for the same frames: the median of the rounds, and the least and the most; a dash where "
        "one crashed or had not done three frames in the time that it was given, which ends longer runs early. Who "
        "among them reports false pairs or misses some stands in the [accuracy report](accuracy/README.md).")
    yield from peer_table(replays, modes)
    yield from ("### Growth", "")
    yield from growth_table(results)
    yield from ("### What moved", "")
    yield from claims.time_table(results, "movers", "milliseconds a frame")
    yield from rest_table(results)
    yield from ("### Threads", "")
    yield from threads_table(results)
    yield from ("### Memory", "")
    yield from memory_lines(results)


def write_page(path, lines):
    """Puts the lines between the marks of a page."""
    text = path.read_text()
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    path.write_text(before + BEGIN + "\n" + "\n".join(lines).rstrip("\n") + "\n" + END + after)


def write_csv(path, replays):
    with open(path, "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["scene", "mode", "frames", "first_ms", "median_ms", "mean_ms", "p99_ms", "worst_ms", "ratio",
                        "ratio_low", "ratio_high"])
        for scene, row in replays.items():
            for mode, r in row.items():
                values = (r.first, r.median, r.mean, r.p99, r.worst, r.ratio, r.ratios[0], r.ratios[-1])
                table.writerow([scene, mode, r.frames] + ["%.6g" % value for value in values])


def plot(path, replays, modes):
    """A dot for each mode and scene: times the base's time, in powers of ten. Nothing without matplotlib."""
    try:
        import matplotlib
    except ImportError:
        return
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "multisap"
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(9, 0.45 * len(replays) + 1.5))
    names = [mode for mode, _ in modes if mode not in (FLOOR, THREADS)]
    for index, mode in enumerate(names):
        points = [(row[mode].ratio, scene) for scene, row in enumerate(replays.values()) if mode in row]
        if points:
            axes.plot(*zip(*points), "osD^v<>pP*Xhd"[index % 13], label=mode)
    axes.set_xscale("log")
    axes.set_yticks(range(len(replays)), replays)
    axes.invert_yaxis()
    axes.grid(alpha=0.3)
    axes.set_xlabel("time of the frames after the first, times that of multisap")
    axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})


# ------------------------------------------------------------------- the whole


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--limit", type=float, default=1, help="seconds after which a replay ends early")
    parser.add_argument("--page", type=Path, default=ROOT / "docs/performance.md")
    parser.add_argument("speed", type=Path, help="the program bench/speed; figures go into its folder")
    parser.add_argument("programs", nargs="+", help="those that have modes, bench/replay first")
    return parser.parse_args()


def main():
    arguments = parse()
    folder = arguments.speed.resolve().parent
    modes = list(list_modes(Path(program).resolve() for program in arguments.programs))
    lines = [["machine", *item] for item in claims.machine()]
    print("bench: sizes, movers, threads, memory", file=sys.stderr)
    lines += claims.lines_of([arguments.speed.resolve()])
    (folder / "speed.tsv").write_text("".join("\t".join(line) + "\n" for line in lines))
    traces = scenes_in(folder / "traces", arguments.speed.resolve())
    replays = replay_all(traces, modes, arguments)
    page = list(measured(claims.Results(folder / "speed.tsv"), replays, traces, modes, arguments.rounds))
    print("\n".join(page))
    write_csv(folder / "speed.csv", replays)
    write_page(arguments.page, page)
    plot(arguments.page.with_suffix(".svg"), replays, modes)


if __name__ == "__main__":
    main()
