# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The plots of the report, as SVG and PNG.

Errors have a logarithmic axis with a band for none at its beginning. In the band the
modes have a place each, in the order of the legend, so that none hides another.
"""
import math

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams.update({"svg.hashsalt": "multisap", "font.size": 8, "axes.grid": True, "grid.alpha": 0.3})
import matplotlib.pyplot as plt  # noqa: E402 (after the choice of the backend)
from matplotlib.ticker import LogLocator, NullFormatter  # noqa: E402

MARKS = "sDv^<>PXd"
LEAST, MOST, BAND = -5.2, 3.3, 3.0  # decades of the shares, and the width of the band for none
TICKS = {-4: "0.01 %", -2: "1 %", 0: "100 %", 2: "10,000 %"}


def styles_of(ours, peers):
    """Ours a colour each, the others in greys and other marks."""
    colours = [colour for i, colour in enumerate(plt.get_cmap("tab10").colors) if i != 7]  # which is a grey
    styles = {mode: {"color": colours[i % len(colours)], "marker": "o"} for i, mode in enumerate(ours)}
    for i, mode in enumerate(peers):
        styles[mode] = {"color": str(0.1 + 0.5 * i / max(1, len(peers) - 1)), "marker": MARKS[i % len(MARKS)]}
    return styles


def place_of(error, number, among):
    """Where an error goes on the axis: its decade, or the mode's own place in the band."""
    if error == 0:
        return LEAST - BAND * (1 - (number + 1) / (among + 1))
    return max(LEAST, math.log10(error))


def set_error_axis(axis, set_limits, shade):
    axis.set_ticks([LEAST - BAND / 2, *TICKS], labels=["none", *TICKS.values()])
    set_limits(LEAST - BAND, MOST)
    shade(LEAST - BAND, LEAST, color="0.94", zorder=0)


def save(figure, out, name):
    figure.savefig(out / f"{name}.svg", metadata={"Date": None})
    figure.savefig(out / f"{name}.png", dpi=110)
    plt.close(figure)


def legend_of(figure, axes, columns=5):
    handles = {}
    for ax in axes:
        for handle, label in zip(*ax.get_legend_handles_labels()):
            handles.setdefault(label, handle)
    figure.legend(handles.values(), handles.keys(), loc="lower center", ncol=columns, frameon=False)


# ------------------------------------------------------------- speed and error


def draw_point(ax, row, x, style):
    missed = row.share("missed") > 0
    ax.errorbar(x, row.median, yerr=[[0], [row.worst - row.median]], linestyle="none", markersize=5, elinewidth=0.6,
                markerfacecolor="none" if missed else style["color"], label=row.mode, **style)


def draw_panel(ax, title, rows, styles):
    for number, row in enumerate(rows):
        if row.works:
            draw_point(ax, row, place_of(row.error(), number, len(rows)), styles[row.mode])
    set_error_axis(ax.xaxis, ax.set_xlim, ax.axvspan)
    ax.set_yscale("log")
    ax.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.yaxis.set_minor_formatter(NullFormatter())
    ax.set_title(title)


def draw_speed_and_error(rows, titles, modes, styles, out):
    """A panel for each scene of titles: what a mode gets wrong across, what it takes up."""
    columns = 3
    lines = -(-len(titles) // columns)
    figure, axes = plt.subplots(lines, columns, figsize=(10.5, 3 * lines + 1), squeeze=False)
    for ax, (scene, title) in zip(axes.flat, titles.items()):
        draw_panel(ax, title, [rows[scene, mode] for mode in modes], styles)
    for ax in list(axes.flat)[len(titles):]:
        ax.set_visible(False)
    for ax in axes[:, 0]:
        ax.set_ylabel("ms a frame: median, bar to the worst")
    for ax in axes[-1]:
        ax.set_xlabel("false and missed pairs, share of the true")
    legend_of(figure, axes.flat)
    figure.tight_layout(rect=(0, 0.9 / (3 * lines + 1), 1, 1))
    save(figure, out, "speed-error")


# ------------------------------------------------------- far from the origin


def draw_lines(ax, rows, name, distances, modes, styles, against):
    for number, mode in enumerate(modes):
        works = [(i, rows[f"{name}@{d}", mode]) for i, d in enumerate(distances) if rows[f"{name}@{d}", mode].works]
        points = [(i, place_of(row.error(against), number, len(modes))) for i, row in works]
        missed = any(row.share("missed", against) for _, row in works)
        if points:
            ax.plot(*zip(*points), markersize=4, linewidth=0.8, label=mode, **styles[mode],
                    markerfacecolor="none" if missed else styles[mode]["color"])
    set_error_axis(ax.yaxis, ax.set_ylim, ax.axhspan)
    ax.set_xticks(range(len(distances)), distances)
    ax.set_xlabel("units from the origin")


def draw_distance(rows, names, distances, modes, styles, out):
    """Errors over the distance from the origin: against the boxes given, and against the
    scene's doubles."""
    figure, axes = plt.subplots(len(names), 2, figsize=(10.5, 4 * len(names) + 1), squeeze=False)
    of_floats = [mode for mode in modes if not mode.startswith("doubles")]
    for (left, right), name in zip(axes, names):
        draw_lines(left, rows, name, distances, of_floats, styles, "own")
        draw_lines(right, rows, name, distances, modes, styles, "scene")
        left.set_title(f"{name}: against the boxes given")
        right.set_title(f"{name}: against the scene's doubles")
        left.set_ylabel("false and missed pairs, share of the true")
    legend_of(figure, axes[:, 1])
    figure.tight_layout(rect=(0, 0.9 / (4 * len(names) + 1), 1, 1))
    save(figure, out, "distance")
