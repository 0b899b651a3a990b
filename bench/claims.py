# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The claims of the paper, measured: runs bench/claims, and writes docs/claims.md.

    claims.py measure PROGRAM SOURCE... > RESULTS
    claims.py write RESULTS > docs/claims.md

The first runs the program, and builds it anew from its sources ($CC, $CFLAGS) with variants
of the library.

RESULTS are lines of fields separated by tabs; bench.h has those of the program, and
here is added: machine WHAT VALUE. What cannot be found or built is left out.
"""

import math
import os
import platform
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CC = shlex.split(os.environ.get("CC", "cc"))
CFLAGS = shlex.split(os.environ.get("CFLAGS", "-O2"))

# ------------------------------------------------------------------- measuring

# The library with other constants: its name, and what becomes of src/internal.h. (When all is made
# anew, a box may touch 256 cells on an axis.)
VARIANTS = [("as it is: 8", {})] + [(str(n), {"MOST_CELLS": n}) for n in (16, 64, 256)] + [
    ("8, else one list", {"LEVELS": 2})]
ROUNDS = 3


def lines_of(command):
    """The lines that a program prints, as lists of fields, while it runs."""
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        for line in program.stdout:
            yield line.rstrip("\n").split("\t")
    if program.returncode:
        sys.exit("%s failed" % command[0])


def output_of(*command):
    """The first line that a command prints, or nothing."""
    try:
        text = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError):
        return ""
    return text.split("\n")[0]


def caches():
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        level, kind, size = ((index / name).read_text().strip() for name in ("level", "type", "size"))
        kilobytes = int(size.rstrip("K"))
        if kind != "Instruction":
            yield "L%s %s" % (level, "%d KiB" % kilobytes if kilobytes < 1024 else "%d MiB" % (kilobytes // 1024))


def cpuinfo(field):
    """What Linux says of the first core, or nothing."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return ""
    return next((line.split(":", 1)[1].strip() for line in lines if line.startswith(field)), "")


def machine():
    """What matters for speed, in words."""
    compiler = output_of(*CC, "-dumpfullversion") or output_of(*CC, "-dumpversion")
    name = "clang" if "clang" in output_of(*CC, "--version") else "gcc"
    flags = cpuinfo("flags").split()
    vectors = next((text for flag, text in (("avx512f", "AVX-512"), ("avx2", "AVX2"), ("sse2", "SSE2"))
                    if flag in flags), "")
    words = [cpuinfo("model name") or platform.machine(), "%d cores" % os.cpu_count(), vectors,
             "virtual machine" if "hypervisor" in flags else ""]
    yield "processor", ", ".join(word for word in words if word)
    yield "caches", ", ".join(caches())
    yield "compiler", "%s %s, %s" % (name, compiler, " ".join(CFLAGS))
    yield "system", platform.system()


def patched(text, constants):
    """The text with other constants; None where one of them cannot be found."""
    for name, value in constants.items():
        text, found = re.subn(r"\b%s = \d+" % name, "%s = %d" % (name, value), text)
        if found != 1:
            return None
    return text


def build_variant(folder, sources, constants):
    """The program with a library of other constants, or None."""
    header = patched((ROOT / "src/internal.h").read_text(), constants)
    if header is None:
        return None
    folder.mkdir()
    for path in (ROOT / "src").glob("*.[ch]"):
        (folder / path.name).write_text(header if path.name == "internal.h" else path.read_text())
    command = [*CC, "-std=c99", *CFLAGS, "-I%s" % (ROOT / "include"), *folder.glob("*.c"), *sources,
               "-o", folder / "claims", "-pthread", "-lm"]
    return folder / "claims" if subprocess.run(command, stderr=subprocess.DEVNULL).returncode == 0 else None


def measure_cells(sources):
    """Builds the variants, runs them in turn, and gives lines as `compare` of bench.c does."""
    with tempfile.TemporaryDirectory() as folder:
        programs = [(name, build_variant(Path(folder) / str(i), sources, constants))
                    for i, (name, constants) in enumerate(VARIANTS)]
        programs = [(name, program) for name, program in programs if program]
        ms, counts = {}, []
        for round_ in range(ROUNDS):
            for name, program in programs:
                for fields in lines_of([program, "cells"]):
                    if fields[0] == "time":
                        ms.setdefault((fields[2], name), []).append(float(fields[4]))
                    elif round_ == 0:
                        counts.append(fields[:3] + ["%s: %s" % (name, fields[3]), fields[4]])
        for (scene, name), times in ms.items():
            first = ms[scene, programs[0][0]]
            ratios = sorted(a / b for a, b in zip(times, first))
            yield ["time", "cells", scene, name, statistics.median(times), statistics.median(ratios), ratios[0],
                   ratios[-1]]
        yield from counts


def measure(program, sources):
    for what, value in machine():
        print("machine", what, value, sep="\t")
    for claim in ("axes", "batches", "pruning", "scaling", "statics", "parallel"):
        for fields in lines_of([program, claim]):
            print(*fields, sep="\t", flush=True)
    for fields in measure_cells(sources):
        print(*fields, sep="\t", flush=True)


# --------------------------------------------------------------------- reading

class Results:
    """time[claim][scene][way] is (ms, ratio, low, high), count[claim][scene][what] a number."""

    def __init__(self, path):
        self.machine, self.time, self.count = {}, {}, {}
        for line in Path(path).read_text().splitlines():
            kind, *fields = line.split("\t")
            if kind == "machine":
                self.machine[fields[0]] = fields[1]
            elif kind == "time":
                claim, scene, way, *numbers = fields
                self.time.setdefault(claim, {}).setdefault(scene, {})[way] = tuple(map(float, numbers))
            elif kind == "count":
                claim, scene, what, value = fields
                self.count.setdefault(claim, {}).setdefault(scene, {})[what] = float(value)

    def ratios(self, claim, way, scenes=None):
        """Of a way's time to the first way's, by scene."""
        return [ways[way][1] for scene, ways in self.time.get(claim, {}).items()
                if way in ways and (scenes is None or scene in scenes)]


def number(value):
    """Three digits."""
    if value >= 100 or value == 0:
        return "{:,.0f}".format(value)
    return "%.*f" % (min(6, 2 - math.floor(math.log10(value))), value)


def paragraph(text):
    yield from textwrap.wrap(text, 116)
    yield ""


def table(header, rows, align="---:"):
    yield "| " + " | ".join(header) + " |"
    yield "| --- |" + " %s |" % align * (len(header) - 1)
    for row in rows:
        yield "| " + " | ".join(row) + " |"
    yield ""


def label(scene):
    return "{:,}".format(int(scene)) if scene.isdigit() else scene


def ways_of(by_scene):
    ways = []
    for row in by_scene.values():
        ways += [way for way in row if way not in ways]
    return ways


def between(low, high):
    low, high = number(low), number(high)
    return low if low == high else "%s–%s" % (low, high)


def time_table(results, claim, what="milliseconds"):
    """Scenes down, ways across; behind each time its ratio to the first way's, and the spread of that."""
    by_scene = results.time.get(claim, {})
    ways = ways_of(by_scene)

    def cell(row, way):
        if way not in row:
            return "–"
        ms, ratio, low, high = row[way]
        return number(ms) if way == ways[0] else "%s (%s; %s)" % (number(ms), number(ratio), between(low, high))
    return table([what] + ways, [[label(scene)] + [cell(row, way) for way in ways] for scene, row in by_scene.items()])


def count_table(results, claim, what=""):
    by_scene = results.count.get(claim, {})
    names = ways_of(by_scene)
    return table([what] + names, [[scene] + [number(row[n]) if n in row else "–" for n in names]
                                  for scene, row in by_scene.items()])


def span(ratios):
    low, high = number(min(ratios)), number(max(ratios))
    return low if low == high else "%s to %s" % (low, high)


def verdict(ratios):
    """Whether what the claim is against takes longer."""
    mean = statistics.geometric_mean(ratios)
    if min(ratios) > 0.97 and mean > 1.05:
        return "holds"
    if max(ratios) < 1.03 and mean < 0.95:
        return "no longer holds"
    return "makes no difference" if min(ratios) > 0.9 and max(ratios) < 1.1 else "depends on the scene"


def exponent(results, claim, way, others=()):
    """The slope of log time over log boxes, by least squares; where the others were measured too."""
    points = [(math.log(float(scene)), math.log(ways[way][0]))
              for scene, ways in results.time.get(claim, {}).items() if {way, *others} <= ways.keys()]
    if len(points) < 2:
        return None
    x, y = (statistics.mean(values) for values in zip(*points))
    return sum((a - x) * (b - y) for a, b in points) / sum((a - x) ** 2 for a, b in points)


def crossover(results, kind, way):
    """The share of boxes, in per cent, from which on box pruning is faster than a way; None: it never is."""
    last = None
    for scene, ways in results.time.get("pruning", {}).items():
        if not scene.startswith(kind) or way not in ways:
            continue
        share, ratio = float(re.search(r"([\d.]+) %", scene).group(1)), ways[way][1]
        if ratio > 1:
            if last is None:
                return share
            (x, y), at = last, math.log(ratio)
            return math.exp(math.log(x) + (math.log(share) - math.log(x)) * -math.log(y) / (at - math.log(y)))
        last = share, ratio
    return None


# --------------------------------------------------------------------- writing

SIMPLE = [
    # claim, way that it is against, paper, title, text before the table
    ("arrays", "linked lists", "I.2", "Arrays are better than linked lists",
     "The same SAP, its end points in arrays or in doubly linked lists. A list has no ranks, so it tests overlap by "
     "bounds that are kept with the box; the third column is the arrays with that test, which tells the share of "
     "storage alone."),
    ("integers", "floats", "A", "Integer comparisons are faster than float comparisons",
     "The end points of the paper, 8 bytes with a value and an owner, compared by the value as an encoded integer or "
     "as a float; and as the library does it, value, kind and owner in one 64-bit key, which settles ties as well."),
    ("sentinels", "tests for the ends", "B", "Sentinels save the test for the ends of the arrays",
     "A dummy end point at each end of an array stops every slide, or the slide tests where it is. The library's "
     "sentinels are keys that no bound has, infinite ones included, so the paper's warning about FLT_MAX is void."),
    ("index-test", "values of the end points", "I.3", "Overlap is tested faster by indices than by values",
     "A pair that crosses on one axis is tested on the two others: by the ranks of its end points; by bounds that are "
     "kept with the boxes; by the values of the end points, found through the ranks."),
    ("removal-test", "looked up untested", "I.3", "The overlap test before a removal pays",
     "A pair that crosses on one axis may end; the overlap test on the other axes tells whether it was one. Without "
     "the test every pair that seems to end is looked up in the pair manager."),
]


def write_simple(results, claim, against, paper, title, text):
    yield from ("## %s (%s)" % (title, paper), "")
    if text:
        yield from paragraph(text)
    yield from time_table(results, claim, "milliseconds a frame")


def write_removals(results):
    yield from paragraph("The paper has seen 10,000 apparent removals become 3 real ones:")
    yield from table(["a frame", "apparent removals", "real removals", "of 10,000 apparent ones"], [
        [scene, number(row["apparent removals a frame"]), number(row["real removals a frame"]),
         number(1e4 * row["real removals a frame"] / row["apparent removals a frame"])]
        for scene, row in results.count.get("removal-test", {}).items()])


def write_batches(results):
    yield from ("## Batches are faster than single insertions and deletions (I.4b, I.5b)", "")
    yield from paragraph(
        "Boxes that come to others, or go: as a batch (merged, with box pruning for the new pairs; tagged and "
        "dropped in one pass), or one by one as the paper's simple approach has it, from or to far away. A box "
        "may also be cut out of the arrays, or of lists, after its pairs were looked up.")
    yield from time_table(results, "insertion", "milliseconds to insert")
    yield from time_table(results, "deletion", "milliseconds to delete")


def write_pruning(results):
    yield from ("## Box pruning against a SAP as more boxes move (I.4c)", "")
    yield from paragraph(
        "Box pruning takes about the same time whatever moves: less than a SAP when all boxes move, says the paper, "
        "and too much otherwise. 10,000 boxes. Box pruning starts anew in each frame, and compares its pairs with "
        "those of the frame before. \"Best way\" is the single SAP as the library runs it, which turns to batches "
        "and to pruning by itself.")
    yield from time_table(results, "pruning", "milliseconds a frame")
    ways = ("single SAP, sliding", "single SAP, best way", "Multi-SAP")
    yield from table(["box pruning is faster than"] + list(ways), [
        [text] + ["at no share" if share is None else "from %s %% on" % number(share)
                  for share in (crossover(results, kind, way) for way in ways)]
        for kind, text in (("slow", "boxes that go 5 % of their width a frame"), ("jumping", "boxes that jump"))])


SCALING = [
    ("scaling-cube", "All move, in a cube"), ("scaling-floor", "All move, on a floor"),
    ("scaling-movers", "1,000 move, on a floor"), ("scaling-load", "The first commit, of all boxes"),
    ("scaling-insertion", "One box comes and goes: two commits")]


def write_scaling(results):
    yield from ("## A Multi-SAP scales better than a single SAP (II.1, II.2)", "")
    yield from paragraph(
        "In a single SAP a box meets on each axis others that are far away on the rest, so that each update costs "
        "more the more boxes there are; a grid of SAPs keeps each of them small. "
        "The library with a single SAP (`MSAP_GRID_NONE`) and with a grid (`MSAP_GRID_AUTO`); each box overlaps "
        "two others, whatever the number of boxes. \"Sliding\" is the paper's update of I.3 for every box; the other "
        "single SAP chooses among the ways of I.3, I.4b and I.4c. A way that has become hopeless is not measured at "
        "the next size: one that its last frame foretells to take more than 1 second (10 seconds for a load), a dash "
        "in the table. The exponent e of the cost, which grows as N^e, is the slope over the sizes that were "
        "measured. A box takes some hundred bytes (see Memory), so that the sizes outgrow one cache after the other, "
        "which is a part of the slope.")
    for claim, title in SCALING:
        ways = ways_of(results.time.get(claim, {}))
        exponents = [exponent(results, claim, way) for way in ways]
        lines = list(time_table(results, claim, title + ", milliseconds"))
        lines.insert(-1, "| exponent | " + " | ".join("–" if e is None else "%.2f" % e for e in exponents) + " |")
        yield from lines


def write_memory(results):
    yield from ("## Memory", "")
    yield from paragraph(
        "By the library's own count of what it holds from its allocator (`msap_stats`): the most that it ever held, "
        "with room to grow, and what it holds after `msap_trim`. A candidate pair is one "
        "whose skins overlap.")
    yield from count_table(results, "memory")


def write_cells(results):
    yield from ("## A mover should touch few cells (II.2b)", "")
    yield from paragraph(
        "The library, built with other limits of the cells that a box may touch on its level: 8 as it is. A box "
        "over the limit goes to a coarser level, whose cells are four times as wide; or, last column, into one "
        "list for all of them. The paper would forbid such boxes; here they cost what they touch.")
    yield from time_table(results, "cells", "milliseconds a frame")
    ways = ways_of(results.time["cells"])
    yield from table(["cells a box is in"] + ways, [
        [scene] + [number(row[way + ": cells a box"]) for way in ways]
        for scene, row in results.count["cells"].items()])


def write_statics(results):
    yield from ("## Static boxes in all cells, or in a structure of their own (II.2c)", "")
    yield from paragraph(
        "The paper puts static boxes into all cells that they touch, with good results, and names a tree as "
        "another way. "
        "10,000 boxes that move ask in each frame for the static ones that they overlap; of 10,000 static "
        "ones, some cover the whole map or reach across it. In cells of one size; in cells of several sizes, "
        "each box in those that suit it, as the library does; in a tree of bounding boxes.")
    yield from time_table(results, "statics", "milliseconds a frame")
    yield from time_table(results, "statics-build", "milliseconds to build")
    yield from count_table(results, "statics")


def write_pairs(results):
    yield from ("## One pair manager for all cells, or one for each (II.3b, II.3d)", "")
    yield from paragraph(
        "Boxes on a floor; in each frame all cells are swept. One shared pair manager takes every pair at "
        "once. One for each cell is a list, and the lists are merged by sorting, repeats dropped. An owner cell, "
        "the one with the higher of the two boxes' low corners, keeps repeats from arising.")
    yield from time_table(results, "owner", "milliseconds a frame")
    yield from paragraph(
        "The paper says that a shared pair manager needs no extra code. That is so for pairs that begin. A pair "
        "that lasts may leave one of the cells that see it and stay in another, and the removal from the first "
        "must not end it; a test of the whole boxes, as before any removal, is what keeps it:")
    yield from count_table(results, "owner")


def write_threads(results):
    yield from ("## The queues, and cells at the same time (II.3d)", "")
    yield from paragraph(
        "What several threads can give at most on this machine, while it does what else it does:")
    yield from time_table(results, "threads")
    yield from paragraph(
        "Rasterising the boxes and recording, for each cell, who enters, stays and leaves: the paper does it "
        "on one thread.")
    yield from time_table(results, "queues", "milliseconds a frame")
    yield from paragraph(
        "The library's commit as a whole, on one thread and on several:")
    yield from time_table(results, "parallel", "milliseconds a frame")


SECTIONS = [("removal-test", write_removals), ("insertion", write_batches), ("pruning", write_pruning),
            ("scaling-cube", write_scaling), ("memory", write_memory), ("cells", write_cells),
            ("statics", write_statics), ("owner", write_pairs), ("queues", write_threads)]


def summary_rows(results):
    for claim, against, paper, title, _ in SIMPLE:
        ratios = results.ratios(claim, against)
        if ratios:
            yield title, paper, "%s: times %s" % (against, span(ratios)), verdict(ratios)
    many = [scene for scene in results.time.get("insertion", {}) if not scene.startswith("1 of")]
    for claim, title, way in (("insertion", "Batch insertion is faster", "one by one"),
                              ("deletion", "Batch deletion is faster", "one by one, moved far away")):
        ratios = results.ratios(claim, way, many)
        if ratios:
            yield title, "I.4b" if claim == "insertion" else "I.5b", "%s, 10 or more: times %s" % (way, span(ratios)), \
                verdict(ratios)
    yield from summary_of_pruning(results)
    yield from summary_of_scaling(results)
    yield from summary_of_cells(results)
    yield from summary_of_threads(results)


def summary_of_pruning(results):
    for way in ("single SAP, sliding", "Multi-SAP"):
        share = crossover(results, "slow", way)
        if results.time.get("pruning"):
            yield ("Box pruning is faster than a SAP when all move", "I.4c",
                   "%s, slow boxes: %s" % (way, "at no share" if share is None else "from %s %% on" % number(share)),
                   "no longer holds" if share is None else "holds")


def summary_of_scaling(results):
    for claim, title in SCALING:
        ways = "Multi-SAP", "single SAP"
        multi, single = (exponent(results, claim, way, ways) for way in ways)
        if multi is not None and single is not None:
            yield ("A Multi-SAP scales better: " + title[0].lower() + title[1:], "II.1",
                   "exponents %.2f and %.2f of the single one, over the sizes that both have" % (multi, single),
                   "holds" if multi < single - 0.1 else "no longer holds")


def summary_of_cells(results):
    ratios = results.ratios("cells", "256")
    if ratios:
        yield "A mover should touch few cells", "II.2b", "256 instead of 8: times " + span(ratios), verdict(ratios)
    ratios = results.ratios("statics", "in a tree")
    if ratios:
        yield ("Static boxes in all cells give good results", "II.2c", "in a tree: times " + span(ratios),
               verdict(ratios))


def summary_of_threads(results):
    merged, owned = results.ratios("owner", "one a cell, merged"), results.ratios("owner", "by an owner cell")
    if merged and owned:
        yield ("One pair manager a cell, and a merge, cost little more than a shared one", "II.3d",
               "times " + span(merged), "holds" if statistics.geometric_mean(merged) < 1.1 else "no longer holds")
        owned = [o / m for o, m in zip(owned, merged)]
        yield ("An owner for each pair instead of the merge is not worth it", "II.3d", "times " + span(owned),
               "holds" if statistics.geometric_mean(owned) > 0.95 else "no longer holds")
    highs = [ways["2 threads"][3] for ways in results.time.get("threads", {}).values()]
    idle = max(highs, default=1) < 0.75
    for claim, way, title in (("queues", "2 threads", "The queues may be filled on one thread"),
                              ("parallel", "2 workers", "Several threads bring the cells up to date sooner")):
        ratios = results.ratios(claim, way)
        if ratios:
            pays = statistics.geometric_mean(ratios) < 0.9
            yield (title, "II.3d", "%s: times %s" % (way, span(ratios)),
                   "not measured: no core was idle" if not idle else
                   "holds" if pays == (claim == "parallel") else "no longer holds")


HEAD = """<!-- SPDX-FileCopyrightText: 2026 the multisap authors -->
<!-- SPDX-License-Identifier: MIT -->
<!-- Written by bench/claims.py: make claims -->

# The paper's claims, measured

What Terdiman's "Sweep-and-prune" (version 0.2, 2007) claims, on a machine of today. `make claims` measures all of it
anew, in some minutes, and writes this file; the code is in `bench/`, also of what is slower and not in the library.

All ways of a row run one after another, in several rounds, and find the same pairs. A time is the median of the
rounds; in parentheses stands the median of its ratio to the first column in the same round, and the quartiles of that
ratio. Times are of the processor, those of several threads by the clock."""


def write(path):
    results = Results(path)
    yield from (*HEAD.split("\n"), "")
    yield from ("- %s: %s" % item for item in results.machine.items() if item[1])
    yield from ("", "## Summary", "")
    yield from table(["claim", "paper", "measured", "today"], summary_rows(results), "---")
    for claim, *rest in SIMPLE:
        if claim in results.time:
            yield from write_simple(results, claim, *rest)
    for claim, section in SECTIONS:
        if claim in results.time or claim in results.count:
            yield from section(results)


def main(arguments):
    if len(arguments) > 2 and arguments[0] == "measure":
        measure(arguments[1], arguments[2:])
    elif len(arguments) == 2 and arguments[0] == "write":
        print("\n".join(write(arguments[1])).rstrip("\n"))
    else:
        sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])
