# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Measures speed against error and writes the report: what `make accuracy` does.

Runs every mode of the programs of this folder on every scene, in rounds, so that what is
compared runs at about the same time; has every mode judged once by the oracle; and writes
tables, plots and the report. With --redraw the last run's results are taken, and only the
report is written anew.
"""
import argparse
import json
import os
import platform
import subprocess
import sys
from pathlib import Path

import report

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

TRACES = ["jolt_ragdolls", "box2d_tumbler", "pybullet_tray", "ties", "edges", "churn", "giants", "level_load"]
GENERATED = ["drift", "pile", "few"]
DISTANCES = ["1e3", "1e5", "1e6", "1e7"]
SCENES = ([f"tests/scenes/{name}.trace" for name in TRACES] + GENERATED
          + [f"{name}@{distance}" for name in ("drift", "pile") for distance in DISTANCES])

BASE = "exact, margin auto"


# ------------------------------------------------------------------ measuring


def run(program, *words):
    """What a program prints, or None if it crashed or never ended."""
    try:
        done = subprocess.run([program, *words], cwd=ROOT, capture_output=True, text=True, timeout=60)
        return json.loads(done.stdout) if done.returncode == 0 else None
    except (json.JSONDecodeError, subprocess.TimeoutExpired):
        return None


def list_modes(programs):
    """[(mode, program)], ours first."""
    modes = []
    for path in programs:
        names = subprocess.run([path, "--list"], capture_output=True, text=True, check=True).stdout
        modes += [(name, path) for name in names.splitlines()]
    return modes


def measure_scene(scene, modes, rounds, limit):
    """{mode: [[ms of each frame] of each round]}; the base runs twice in each round."""
    times = {}
    again = [(BASE + " (again)", path, BASE) for name, path in modes if name == BASE]
    runs = [(name, path, name) for name, path in modes] + again
    for number in range(rounds):
        turn = number * 5 % len(runs)
        for name, path, mode in runs[turn:] + runs[:turn]:
            result = run(path, mode, scene, limit)
            if result:
                times.setdefault(name, []).append(result["ms"])
    return times


def measure(arguments):
    folder = arguments.folder.resolve()
    modes = list_modes(str(folder / name) for name in arguments.programs)
    results = {"machine": describe_machine(arguments), "peers": describe_peers(arguments.programs),
               "rounds": arguments.rounds, "scenes": {}, "modes": [name for name, _ in modes],
               "load": [os.getloadavg()[0]], "narrow": run(str(folder / "narrow"))}
    for scene in arguments.scenes.split() or SCENES:
        print(f"accuracy: {scene}", file=sys.stderr)
        times = measure_scene(scene, modes, arguments.rounds, arguments.limit)
        checks = {name: run(path, "--check", name, scene, arguments.limit) for name, path in modes}
        results["scenes"][scene] = {"times": times, "checks": checks}
        results["load"].append(os.getloadavg()[0])
    return results


# ----------------------------------------------------------------- the machine


def first_line(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stdout.splitlines()[0] if done.stdout else ""


def describe_machine(arguments):
    """What matters for speed, and no names."""
    try:
        words = set(Path("/proc/cpuinfo").read_text().split())
    except OSError:
        words = set()
    vectors = next((text for flag, text in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("sse2", "SSE2"))
                    if flag in words), "vectors unknown")
    kind = "a virtual machine" if "hypervisor" in words else "a machine"
    system = platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    compiler = first_line(*arguments.compiler.split(), "--version")
    return f"{kind}, {platform.machine()}, {os.cpu_count()} cores, {vectors}; {system}; {compiler}, {arguments.flags}"


def describe_peers(programs):
    """The versions of the packages, where there is a dpkg."""
    packages = [f"lib{name}-dev" for name in programs if name != "ours"]
    try:
        listed = first_line("dpkg-query", "-W", "-f", "${Package} ${Version}, ", *packages) if packages else ""
    except OSError:
        listed = ""
    return listed.removesuffix(", ") or ", ".join(packages) or "none"


# ------------------------------------------------------------------- the whole


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default="docs/accuracy", help="folder of the report")
    parser.add_argument("--compiler", default="cc", help="that the programs were built with")
    parser.add_argument("--flags", default="-O2", help="that they were built with")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--limit", default="2", help="seconds after which a run ends early")
    parser.add_argument("--scenes", default="", help="instead of all: traces and names of generated scenes")
    parser.add_argument("--redraw", action="store_true", help="from the last run's results")
    parser.add_argument("folder", type=Path, help="where the programs are and the results go")
    parser.add_argument("programs", nargs="+", help="those that have modes, ours first")
    return parser.parse_args()


def main():
    arguments = parse()
    kept = arguments.folder / "results.json"
    if not arguments.redraw:
        kept.write_text(json.dumps(measure(arguments)))
    report.write(json.loads(kept.read_text()), arguments.out, (HERE / "report.md").read_text(), BASE)


if __name__ == "__main__":
    main()
