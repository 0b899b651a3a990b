# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Measures speed against error and writes the report: what `make accuracy` does.

Builds the programs of this folder, leaving out peers whose headers are not installed;
runs every mode on every scene, in rounds, so that what is compared runs at about the same
time; has every mode judged once by the oracle; and writes tables, plots and the report.
With --redraw the last run's results are taken, and only the report is written anew.
"""
import argparse
import json
import os
import platform
import shlex
import subprocess
import sys
from pathlib import Path

import report

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

SHARED = ["main.c", "scene.c", "oracle.c"]

# name: source, header that must be there, flags, libraries
PROGRAMS = {
    "ours": ("ours.c", "stdlib.h", ["-I", str(ROOT / "include")], []),
    "bullet": ("bullet.cpp", "bullet/btBulletCollisionCommon.h", ["-DNDEBUG", "-isystem", "/usr/include/bullet"],
               ["-lBulletCollision", "-lLinearMath"]),
    "ode": ("ode.c", "ode/ode.h", [], ["-lode", "-lstdc++", "-pthread"]),
    "fcl": ("fcl.cpp", "fcl/fcl.h", ["-DNDEBUG", "-isystem", "/usr/include/eigen3"],
            ["-lfcl", "-lccd", "-loctomap", "-loctomath"]),
    "cgal": ("cgal.cpp", "CGAL/box_intersection_d.h", ["-DNDEBUG", "-frounding-math"], ["-lgmp", "-lmpfr"]),
}

TRACES = ["jolt_ragdolls", "box2d_tumbler", "pybullet_tray", "ties", "edges", "churn", "giants", "level_load"]
GENERATED = ["drift", "pile", "few"]
DISTANCES = ["1e3", "1e5", "1e6", "1e7"]
SCENES = ([f"tests/scenes/{name}.trace" for name in TRACES] + GENERATED
          + [f"{name}@{distance}" for name in ("drift", "pile") for distance in DISTANCES])

BASE = "exact, margin auto"


# ------------------------------------------------------------------- building


def is_cpp(source):
    return source.endswith(".cpp")


def compile_with(arguments, source, *rest):
    """The command that compiles a source, as the Makefile's would."""
    if is_cpp(source):
        return [*shlex.split(arguments.cxx), "-std=c++17", *shlex.split(arguments.cflags), *rest]
    return [*shlex.split(arguments.cc), "-std=c99", *shlex.split(arguments.cflags), *rest]


def has_header(arguments, source, header, flags):
    command = compile_with(arguments, source, *flags, "-E", "-x", "c++" if is_cpp(source) else "c", "-", "-o", os.devnull)
    return subprocess.run(command, input=f"#include <{header}>\n", text=True, stderr=subprocess.DEVNULL).returncode == 0


def build(arguments):
    """Builds what can be built; returns {program: path}."""
    built = {}
    folder = Path(arguments.build)
    folder.mkdir(parents=True, exist_ok=True)
    for name in SHARED:
        subprocess.run(compile_with(arguments, name, "-c", str(HERE / name), "-o", str(folder / f"{name}.o")), check=True)
    objects = [str(folder / f"{name}.o") for name in SHARED]
    for name, (source, header, flags, libraries) in PROGRAMS.items():
        if not has_header(arguments, source, header, flags):
            continue
        built[name] = folder / name
        subprocess.run(compile_with(arguments, source, *flags, str(HERE / source), *objects, arguments.library,
                                    *libraries, "-lm", "-o", str(built[name])), check=True)
    subprocess.run(compile_with(arguments, "narrow.c", str(HERE / "narrow.c"), "-lm", "-o", str(folder / "narrow")),
                   check=True)
    return built


# ------------------------------------------------------------------ measuring


def run(program, *words):
    """What a program prints, or None if it crashed."""
    done = subprocess.run([str(program), *words], cwd=ROOT, capture_output=True, text=True)
    try:
        return json.loads(done.stdout) if done.returncode == 0 else None
    except json.JSONDecodeError:
        return None


def list_modes(built):
    """[(mode, program)], ours first."""
    modes = []
    for path in built.values():
        names = subprocess.run([str(path), "--list"], capture_output=True, text=True, check=True).stdout
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
            result = run(path, mode, scene, str(limit))
            if result:
                times.setdefault(name, []).append(result["ms"])
    return times


def measure(arguments, built):
    modes = list_modes(built)
    results = {"machine": describe_machine(arguments), "peers": describe_peers(built),
               "rounds": arguments.rounds, "scenes": {},
               "modes": [name for name, _ in modes], "load": [os.getloadavg()[0]]}
    for scene in arguments.scenes or SCENES:
        print(f"accuracy: {scene}", file=sys.stderr)
        times = measure_scene(scene, modes, arguments.rounds, arguments.limit)
        checks = {name: run(path, "--check", name, scene, str(arguments.limit)) for name, path in modes}
        results["scenes"][scene] = {"times": times, "checks": checks}
        results["load"].append(os.getloadavg()[0])
    results["narrow"] = run(Path(arguments.build) / "narrow")
    return results


# ----------------------------------------------------------------- the machine


def first_line(command):
    done = subprocess.run(command, capture_output=True, text=True)
    return done.stdout.splitlines()[0] if done.stdout else ""


def describe_machine(arguments):
    """Neutrally: what matters for speed, and no names."""
    flags = ""
    try:
        flags = next(line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("flags"))
    except (OSError, StopIteration):
        pass
    words = set(flags.split())
    vectors = next((text for flag, text in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("sse2", "SSE2"))
                    if flag in words), "vectors unknown")
    kind = "a virtual machine" if "hypervisor" in words else "a machine"
    system = platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    return (f"{kind}, {platform.machine()}, {os.cpu_count()} cores, {vectors}; {system}; "
            f"{first_line([*shlex.split(arguments.cc), '--version'])}, {arguments.cflags}")


def describe_peers(built):
    """The versions of the packages, where there is a dpkg."""
    packages = [f"lib{name}-dev" for name in built if name != "ours"]
    try:
        done = subprocess.run(["dpkg-query", "-W", "-f", "${Package} ${Version}\\n", *packages], capture_output=True, text=True)
    except OSError:
        return ", ".join(packages) or "none"
    return ", ".join(done.stdout.split("\n")[:-1]) or "none"


# ------------------------------------------------------------------- the whole


def parse():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", default="build/accuracy", help="folder of the programs and results")
    parser.add_argument("--library", default="build/libmultisap.a")
    parser.add_argument("--out", default="docs/accuracy", help="folder of the report")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--limit", type=float, default=5, help="seconds after which a run ends early")
    parser.add_argument("--redraw", action="store_true", help="from the last run's results")
    parser.add_argument("scenes", nargs="*", help="instead of all: traces and names of generated scenes")
    arguments = parser.parse_args()
    arguments.cc = os.environ.get("CC", "cc")
    arguments.cxx = os.environ.get("CXX", "c++")
    arguments.cflags = os.environ.get("CFLAGS", "-O2")
    arguments.library = str(Path(arguments.library).resolve())
    return arguments


def main():
    arguments = parse()
    kept = Path(arguments.build) / "results.json"
    if not arguments.redraw:
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(measure(arguments, build(arguments))))
    report.write(json.loads(kept.read_text()), Path(arguments.out), (HERE / "report.md").read_text(), BASE)


if __name__ == "__main__":
    main()
