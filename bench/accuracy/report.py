# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Makes tables and the report of what run.py measured; plots.py draws."""
import statistics
import struct
from pathlib import Path
from string import Template

import plots

OURS = ("exact", "fat", "16", "doubles")
CALLERS = ("fat", "16")
NARROW = ("again", "turned")


# ------------------------------------------------------------------- numbers


def short(scene):
    return Path(scene).stem if scene.endswith(".trace") else scene


def is_near(scene):
    return "@" not in scene


class Row:
    """One mode on one scene: times in ms, errors as shares of the true pairs."""

    def __init__(self, scene, mode, times, base, check):
        self.scene, self.mode = scene, mode
        self.works = bool(times and check)
        if not self.works:
            return
        frames = min(len(t) for t in times + base)
        best = [min(column) for column in zip(*[t[:frames] for t in times])][1:] or [times[0][0]]
        self.median, self.worst, self.mean = statistics.median(best), max(best), statistics.mean(best)
        ratios = sorted(statistics.mean(t[1:frames] or t[:1]) / statistics.mean(b[1:frames] or b[:1])
                        for t, b in zip(times, base))
        self.ratio, self.low, self.high = statistics.median(ratios), ratios[0], ratios[-1]
        self.frames, self.bytes = check["frames"], check["bytes"]
        self.errors = {"own": check["own"], "scene": check["scene"]}

    def share(self, what, against="own"):
        errors = self.errors[against]
        return errors[what] / max(1, errors["true"])

    def error(self, against="own"):
        return self.share("false", against) + self.share("missed", against)

    @property
    def false_a_frame(self):
        return self.errors["own"]["false"] / self.frames


def rows_of(results, base):
    """{(scene, mode): Row}"""
    rows = {}
    for scene, found in results["scenes"].items():
        for mode in results["modes"] + [base + " (again)"]:
            check = found["checks"].get(mode.removesuffix(" (again)"))
            rows[scene, mode] = Row(scene, mode, found["times"].get(mode), found["times"][base], check)
    return rows


# -------------------------------------------------------------------- tables


def percent(share):
    if share == 0:
        return "0"
    return f"{share * 100:.2g} %" if share < 1 else f"{share * 100:,.0f} %"


def milliseconds(ms):
    return f"{ms:.3f}" if ms < 1 else f"{ms:.2f}" if ms < 100 else f"{ms:.0f}"


def table(head, lines):
    text = ["| " + " | ".join(head) + " |", "| --- |" + " ---: |" * (len(head) - 1)]
    return "\n".join(text + ["| " + " | ".join(line) + " |" for line in lines])


def matrix(rows, scenes, modes, cell):
    """Modes down, scenes across; a mode that crashed or stopped has a dash."""
    lines = [[mode] + [cell(rows[scene, mode]) if rows[scene, mode].works else "-" for scene in scenes] for mode in modes]
    return table(["way"] + [short(scene) for scene in scenes], lines)


def speed_cell(row):
    return f"{milliseconds(row.median)} ({milliseconds(row.worst)})"


def error_cell(against):
    def cell(row):
        false, missed = row.share("false", against), row.share("missed", against)
        return percent(false) + (f", **misses {percent(missed)}**" if missed else "")

    return cell


def bytes_cell(row):
    return f"{row.bytes / 1024:,.0f}"


def price(rows, base, nanoseconds):
    """What a frame costs with its false pairs, in what the exact one costs."""

    def of(row):
        return (row.mean + row.false_a_frame * nanoseconds * 1e-6) / rows[row.scene, base].mean

    return of


def price_cell(rows, base, nanoseconds):
    of = price(rows, base, nanoseconds)
    return lambda row: f"{of(row):.2f}"


def span(values, form):
    values = sorted(values)
    return f"{form(statistics.median(values))} ({form(values[0])} to {form(values[-1])})"


def pays(rows, scenes, mode, base, nanoseconds):
    """On how many scenes the price is less than the exact library's by more than a tenth."""
    of = price(rows, base, nanoseconds)
    won = [short(scene) for scene in scenes if of(rows[scene, mode]) < 0.9]
    return f"{len(won)} of {len(scenes)}" + (f" ({', '.join(won)})" if won else "")


def bought_table(rows, scenes, modes, base, prices):
    """What a caller's errors buy and cost, over all scenes."""
    lines = []
    for mode in modes:
        own = [rows[scene, mode] for scene in scenes]
        lines.append([mode, span([r.mean / rows[r.scene, base].mean for r in own], lambda x: f"{x:.2f}"),
                      span([r.bytes / rows[r.scene, base].bytes for r in own], lambda x: f"{x:.2f}"),
                      span([r.share("false") for r in own], percent)]
                     + [pays(rows, scenes, mode, base, nanoseconds) for nanoseconds in prices])
    return table(["way", "time", "memory", "false pairs", "pays, again", "pays, turned"], lines)


def float_step(value):
    """From the float at a value to the next."""
    bits = struct.unpack("<I", struct.pack("<f", value))[0]
    return struct.unpack("<f", struct.pack("<I", bits + 1))[0] - struct.unpack("<f", struct.pack("<I", bits))[0]


def steps_table(distances):
    return table(["units from the origin", *distances],
                 [["from a float to the next", *(f"{float_step(float(d)):.2g}" for d in distances)]])


def scene_table(rows, scenes, base, boxes):
    lines = []
    for scene in scenes:
        row = rows[scene, base]
        true_pairs = row.errors["own"]["true"] / row.frames
        lines.append([short(scene), f"{boxes[scene]:,}", f"{true_pairs:,.0f}", str(row.frames)])
    return table(["scene", "boxes in all", "true pairs a frame", "frames"], lines)


# ------------------------------------------------------------------ sentences


def english(words):
    words = list(words)
    if not words:
        return "none"
    return ", ".join(words[:-1]) + (" and " if len(words) > 1 else "") + words[-1]


def with_error(rows, scenes, modes, what):
    """The modes that have such errors on some of the scenes, with those scenes."""
    found = []
    for mode in modes:
        where = [short(scene) for scene in scenes if rows[scene, mode].works and rows[scene, mode].share(what)]
        if where:
            found.append(f"*{mode}*: on {english(where)}")
    return found


def without_error(rows, scenes, modes):
    return [f"*{mode}*" for mode in modes
            if all(rows[scene, mode].works and rows[scene, mode].error() == 0 for scene in scenes)]


def crashed(rows, scenes, modes):
    return [f"*{mode}*: on {english(short(s) for s in scenes if not rows[s, mode].works)}" for mode in modes
            if not all(rows[s, mode].works for s in scenes)]


def bullets(lines):
    return "\n".join(f"- {line}" for line in lines) or "- none"


# ----------------------------------------------------------------- the report


def write_tsv(rows, scenes, modes, out):
    head = ["scene", "way", "median_ms", "worst_ms", "mean_ms", "ratio", "ratio_low", "ratio_high", "bytes", "frames",
            "true", "false", "missed", "true_doubles", "false_doubles", "missed_doubles"]
    lines = ["\t".join(head)]
    for scene in scenes:
        for mode in modes:
            r = rows[scene, mode]
            if r.works:
                numbers = [r.median, r.worst, r.mean, r.ratio, r.low, r.high]
                counts = [r.bytes, r.frames, *r.errors["own"].values(), *r.errors["scene"].values()]
                lines.append("\t".join([short(scene), mode] + [f"{x:.5g}" for x in numbers] + [str(x) for x in counts]))
    (out / "results.tsv").write_text("\n".join(lines) + "\n")


def noise_of(rows, scenes, base):
    again = [rows[scene, base + " (again)"] for scene in scenes]
    best = [row.mean / rows[row.scene, base].mean for row in again]
    return f"{min(best):.2f} to {max(best):.2f}", f"{min(r.low for r in again):.2f} to {max(r.high for r in again):.2f}"


def write(results, out, template, base):
    out.mkdir(parents=True, exist_ok=True)
    rows = rows_of(results, base)
    scenes, modes = list(results["scenes"]), results["modes"]
    near = [scene for scene in scenes if is_near(scene)]
    far = [scene for scene in scenes if not is_near(scene)]
    finite = [scene for scene in near if short(scene) != "edges"]
    ours = [mode for mode in modes if mode.startswith(OURS)]
    peers = [mode for mode in modes if mode not in ours]
    callers = [mode for mode in ours if mode.startswith(CALLERS)]
    at_home = [mode for mode in modes if mode != "doubles, near"]  # near the origin that is "doubles"
    boxes = {scene: results["scenes"][scene]["checks"][base]["boxes"] for scene in scenes}
    names = list(dict.fromkeys(scene.split("@")[0] for scene in far))
    distances = list(dict.fromkeys(scene.split("@")[1] for scene in far))
    busy = [scene for scene in finite if rows[scene, base].median > 1e-3]
    styles = plots.styles_of(ours, peers)
    plots.draw_speed_and_error(rows, {scene: short(scene) for scene in busy}, at_home, styles, out)
    plots.draw_distance(rows, names, distances, modes, styles, out)
    write_tsv(rows, scenes, modes + [base + " (again)"], out)
    noise, spread = noise_of(rows, finite, base)
    prices = [results["narrow"][name] for name in NARROW]
    fields = {
        "machine": results["machine"], "peers": results["peers"], "rounds": results["rounds"],
        "noise": noise, "spread": spread, "load": f"{min(results['load']):.1f} to {max(results['load']):.1f}",
        "again_ns": f"{prices[0]:.0f}", "turned_ns": f"{prices[1]:.0f}",
        "scenes": scene_table(rows, near, base, boxes),
        "speed": matrix(rows, finite, at_home, speed_cell),
        "errors": matrix(rows, near, at_home, error_cell("own")),
        "bytes": matrix(rows, finite, at_home, bytes_cell),
        "n_finite": len(finite), "steps": steps_table(distances),
        "bought": bought_table(rows, finite, callers, base, prices),
        "price_again": matrix(rows, finite, [base] + callers, price_cell(rows, base, prices[0])),
        "price_turned": matrix(rows, finite, [base] + callers, price_cell(rows, base, prices[1])),
        "far_own": matrix(rows, far, [m for m in modes if not m.startswith("doubles")], error_cell("own")),
        "far_scene": matrix(rows, far, [base, "doubles", "doubles, near"] + peers, error_cell("scene")),
        "exact_peers": english(without_error(rows, finite + far, peers)),
        "false_peers": bullets(with_error(rows, finite + far, peers, "false")),
        "missing_modes": bullets(with_error(rows, scenes, modes, "missed")),
        "crashed": bullets(crashed(rows, scenes, modes)),
    }
    (out / "README.md").write_text(Template(template).substitute(fields))
