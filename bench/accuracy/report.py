# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Makes tables, plots and the report of what run.py measured."""
import statistics
import struct
from pathlib import Path
from string import Template

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams.update({"svg.hashsalt": "multisap", "font.size": 8, "axes.grid": True, "grid.alpha": 0.3})
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)

OURS = ("exact", "fat", "16", "doubles")
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
        self.own, self.scene_errors = check["own"], check["scene"]

    def share(self, what, against="own"):
        errors = self.own if against == "own" else self.scene_errors
        return errors[what] / max(1, errors["true"])

    @property
    def error(self):
        return self.share("false") + self.share("missed")

    @property
    def false_a_frame(self):
        return self.own["false"] / self.frames


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
    return table(["mode"] + [short(scene) for scene in scenes], lines)


def speed_cell(row):
    return f"{milliseconds(row.median)} ({milliseconds(row.worst)})"


def ratio_cell(row):
    return f"{row.ratio:.2f} ({row.low:.2f} to {row.high:.2f})"


def error_cell(row):
    false, missed = row.share("false"), row.share("missed")
    return percent(false) + (f", **misses {percent(missed)}**" if missed else "")


def bytes_cell(row):
    return f"{row.bytes / 1024:,.0f}"


def price_cell(rows, base, nanoseconds):
    """What a frame costs with its false pairs, in what the exact one costs."""

    def cell(row):
        total = row.mean + row.false_a_frame * nanoseconds * 1e-6
        return f"{total / rows[row.scene, base].mean:.2f}"

    return cell


def span(values, form):
    values = sorted(values)
    return f"{form(statistics.median(values))} ({form(values[0])} to {form(values[-1])})"


def pays(rows, scenes, mode, base, nanoseconds):
    cell = price_cell(rows, base, nanoseconds)
    return f"{sum(float(cell(rows[scene, mode])) < 1 for scene in scenes)} of {len(scenes)}"


def bought_table(rows, scenes, modes, base, prices):
    """What a caller's errors buy and cost, over all scenes."""
    lines = []
    for mode in modes:
        own = [rows[scene, mode] for scene in scenes]
        lines.append([mode, span([r.ratio for r in own], lambda x: f"{x:.2f}"),
                      span([r.bytes / rows[r.scene, base].bytes for r in own], lambda x: f"{x:.2f}"),
                      span([r.share("false") for r in own], percent)]
                     + [pays(rows, scenes, mode, base, price) for price in prices])
    return table(["way", "time", "memory", "false pairs", "pays, again", "pays, turned"], lines)


def float_step(value):
    """From the float at a value to the next."""
    bits = struct.unpack("<I", struct.pack("<f", value))[0]
    return struct.unpack("<f", struct.pack("<I", bits + 1))[0] - struct.unpack("<f", struct.pack("<I", bits))[0]


def steps_table(distances):
    return table(["units from the origin", *distances],
                 [["from a float to the next", *(f"{float_step(float(d)):.2g}" for d in distances)]])


def scene_errors_cell(row):
    false, missed = row.share("false", "scene"), row.share("missed", "scene")
    return percent(false) + (f", **misses {percent(missed)}**" if missed else "")


def scene_table(rows, scenes, base):
    lines = []
    for scene in scenes:
        row = rows[scene, base]
        lines.append([short(scene), f"{row.own['true'] / row.frames:,.0f}", str(row.frames)])
    return table(["scene", "true pairs a frame", "frames"], lines)


# --------------------------------------------------------------------- plots

MARKS = "osDv^<>PXdph*8"


def style_of(modes):
    """Ours in one colour each, peers in greys and other marks."""
    colours = [colour for i, colour in enumerate(plt.get_cmap("tab10").colors) if i != 7]  # which is a grey
    ours = [mode for mode in modes if mode.startswith(OURS)]
    peers = [mode for mode in modes if mode not in ours]
    styles = {mode: {"color": colours[i % len(colours)], "marker": "o"} for i, mode in enumerate(ours)}
    for i, mode in enumerate(peers):
        styles[mode] = {"color": str(0.15 + 0.5 * i / max(1, len(peers) - 1)), "marker": MARKS[1 + i % 12]}
    return styles


def save(figure, out, name):
    figure.savefig(out / f"{name}.svg", metadata={"Date": None})
    figure.savefig(out / f"{name}.png", dpi=110)
    plt.close(figure)


def legend_of(figure, axes, columns=4):
    handles = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=columns, frameon=False)


def draw_point(ax, row, style):
    missed = row.share("missed") > 0
    ax.errorbar(row.error, row.median, yerr=[[0], [row.worst - row.median]], linestyle="none", markersize=5,
                elinewidth=0.6, markerfacecolor="none" if missed else style["color"], label=row.mode, **style)


def draw_speed_and_error(rows, scenes, modes, out):
    """A panel for each scene: what a mode gets wrong across, what it takes up."""
    columns = 3
    lines = -(-len(scenes) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(10, 2.6 * lines + 1.2), squeeze=False)
    styles = style_of(modes)
    for ax, scene in zip(axes.flat, scenes):
        for mode in modes:
            if rows[scene, mode].works:
                draw_point(ax, rows[scene, mode], styles[mode])
        ax.set_xscale("symlog", linthresh=1e-5, linscale=0.4)
        ax.set_xlim(left=-4e-6)
        ax.set_xticks([0, 1e-4, 1e-2, 1, 100], ["0", "0.01 %", "1 %", "100 %", "10,000 %"])
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")
        ax.set_title(short(scene))
    for ax in list(axes.flat)[len(scenes):]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("ms a frame: median, bar to the worst")
    for ax in axes[-1]:
        ax.set_xlabel("false and missed pairs, share of the true ones")
    legend_of(figure, axes.flat)
    figure.tight_layout(rect=(0, 1.0 / (2.6 * lines + 1.2), 1, 1))
    save(figure, out, "speed-error")


def draw_distance(rows, names, distances, modes, out):
    """Errors over the distance from the origin: own ones, and those against the doubles."""
    figure, axes = plt.subplots(len(names), 2, figsize=(10, 3 * len(names) + 1.2), squeeze=False)
    styles = style_of(modes)
    for line, name in zip(axes, names):
        for ax, against in zip(line, ("own", "scene")):
            for mode in modes:
                if against == "own" and mode.startswith("doubles"):
                    continue
                points = [(i, rows[f"{name}@{d}", mode]) for i, d in enumerate(distances)]
                points = [(i, row.share("false", against) + row.share("missed", against)) for i, row in points if row.works]
                if points:
                    ax.plot(*zip(*points), markersize=4, linewidth=0.8, label=mode, **styles[mode])
            ax.set_yscale("symlog", linthresh=1e-5, linscale=0.4)
            ax.set_ylim(bottom=-4e-6)
            ax.set_yticks([0, 1e-4, 1e-2, 1, 100], ["0", "0.01 %", "1 %", "100 %", "10,000 %"])
            ax.set_xticks(range(len(distances)), distances)
            ax.set_xlabel("units from the origin")
            ax.set_title(f"{name}: " + ("against the boxes given" if against == "own" else "against the scene's doubles"))
        line[0].set_ylabel("false and missed, share of the true pairs")
    legend_of(figure, axes.flat)
    figure.tight_layout(rect=(0, 1.0 / (3 * len(names) + 1.2), 1, 1))
    save(figure, out, "distance")


# ----------------------------------------------------------------- the report


def english(words):
    words = list(words)
    if not words:
        return "none"
    return ", ".join(words[:-1]) + (" and " if len(words) > 1 else "") + words[-1]


def with_error(rows, scenes, modes, what):
    """The modes that have such errors on some of the scenes, with those scenes."""
    found = []
    for mode in modes:
        where = [short(scene) for scene in scenes if rows[scene, mode].works and rows[scene, mode].own[what]]
        if where:
            found.append(f"{mode} ({english(where)})")
    return found


def without_error(rows, scenes, modes):
    return [mode for mode in modes
            if all(rows[scene, mode].works and rows[scene, mode].error == 0 for scene in scenes)]


def crashed(rows, scenes, modes):
    return [f"{mode} ({english(short(s) for s in scenes if not rows[s, mode].works)})" for mode in modes
            if not all(rows[s, mode].works for s in scenes)]


def bullets(lines):
    return "\n".join(f"- {line}" for line in lines) or "- none"


def write_tsv(rows, scenes, modes, out):
    head = ["scene", "mode", "median_ms", "worst_ms", "mean_ms", "ratio", "ratio_low", "ratio_high", "bytes", "frames",
            "true", "false", "missed", "true_doubles", "false_doubles", "missed_doubles"]
    lines = ["\t".join(head)]
    for scene in scenes:
        for mode in modes:
            r = rows[scene, mode]
            if r.works:
                numbers = [r.median, r.worst, r.mean, r.ratio, r.low, r.high]
                counts = [r.bytes, r.frames, *r.own.values(), *r.scene_errors.values()]
                lines.append("\t".join([short(scene), mode] + [f"{x:.5g}" for x in numbers] + [str(x) for x in counts]))
    (out / "results.tsv").write_text("\n".join(lines) + "\n")


def noise_of(rows, scenes, base):
    again = [rows[scene, base + " (again)"] for scene in scenes]
    ratios = [row.ratio for row in again]
    return f"{min(ratios):.2f} to {max(ratios):.2f}", f"{min(r.low for r in again):.2f} to {max(r.high for r in again):.2f}"


def write(results, out, template, base):
    out.mkdir(parents=True, exist_ok=True)
    rows = rows_of(results, base)
    scenes, modes = list(results["scenes"]), results["modes"]
    near = [scene for scene in scenes if is_near(scene)]
    far = [scene for scene in scenes if not is_near(scene)]
    finite = [scene for scene in near if short(scene) != "edges"]
    ours = [mode for mode in modes if mode.startswith(OURS)]
    peers = [mode for mode in modes if mode not in ours]
    callers = [mode for mode in ours if mode.startswith(("fat", "16"))]
    names = list(dict.fromkeys(scene.split("@")[0] for scene in far))
    distances = list(dict.fromkeys(scene.split("@")[1] for scene in far))
    draw_speed_and_error(rows, [s for s in finite if rows[s, base].median > 1e-3], modes, out)
    draw_distance(rows, names, distances, modes, out)
    write_tsv(rows, scenes, modes + [base + " (again)"], out)
    noise, spread = noise_of(rows, finite, base)
    fields = {
        "machine": results["machine"], "peers": results["peers"], "rounds": results["rounds"], "noise": noise, "spread": spread,
        "load": f"{min(results['load']):.1f} to {max(results['load']):.1f}",
        "again_ns": f"{results['narrow']['again']:.0f}", "turned_ns": f"{results['narrow']['turned']:.0f}",
        "scenes": scene_table(rows, near, base),
        "speed": matrix(rows, finite, modes, speed_cell),
        "ratio": matrix(rows, finite, modes, ratio_cell),
        "errors": matrix(rows, near, modes, error_cell),
        "bytes": matrix(rows, finite, modes, bytes_cell),
        "n_finite": len(finite), "steps": steps_table(distances),
        "bought": bought_table(rows, finite, callers, base, [results["narrow"][name] for name in NARROW]),
        "price_again": matrix(rows, finite, [base] + callers, price_cell(rows, base, results["narrow"]["again"])),
        "price_turned": matrix(rows, finite, [base] + callers, price_cell(rows, base, results["narrow"]["turned"])),
        "far_own": matrix(rows, far, [m for m in modes if not m.startswith("doubles")], error_cell),
        "far_scene": matrix(rows, far, [m for m in ours if not m.startswith(("fat", "16"))], scene_errors_cell),
        "exact_peers": english(without_error(rows, finite + far, peers)),
        "false_peers": bullets(with_error(rows, finite + far, peers, "false")),
        "missing_modes": bullets(with_error(rows, scenes, modes, "missed")),
        "crashed": bullets(crashed(rows, scenes, modes)),
    }
    (out / "README.md").write_text(Template(template).substitute(fields))
