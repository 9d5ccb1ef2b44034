"""Pictures: error against time, and cost per block against the number of blocks."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from .competitors import UX_ONLY
from .work_precision import EQUAL_ERRORS, pairs

# colour, marker, line of each competitor; others are drawn in grey
STYLES: dict[str, tuple[str, str, str]] = {
    "auto": ("#c0392b", "o", "-"),
    "DOP853 (numbalsoda)": ("#1f4e8c", "v", "-"),
    "LSODA (numbalsoda)": ("#3a8fb7", "^", "-"),
    "CVODE BDF (SUNDIALS)": ("#2e7d4f", "D", "-"),
    "CVODE Adams (SUNDIALS)": ("#8bbf5a", "P", "-"),
    "DOP853 (scipy)": ("#777777", "v", ":"),
    "LSODA (scipy)": ("#999999", "^", ":"),
    "regularized friction, LSODA (scipy)": ("#3a8fb7", "^", "-"),
    "Radau (scipy)": ("#bbbbbb", "x", ":"),
}
OTHER_STYLE = ("#555555", ".", "--")
PEERS: dict[str, tuple[str, str, str]] = {  # by how a name begins, the longest first
    "here, plane, whole": ("#e59a90", "s", ":"),
    "here, plane, strips": ("#c0392b", "s", "-"),
    "here, plane, rim": ("#7b241c", "D", "-"),
    "here, space, whole faces of 5e+09": ("#d4ac0d", "s", ":"),
    "here, space, whole": ("#f0b27a", "o", ":"),
    "here, space, rim 1 mm, square": ("#e67e22", "v", "--"),
    "here, space, rim 1 mm, deep": ("#b9770e", "o", "-"),
    "here, space, two strips": ("#e67e22", "^", "-"),
    "MuJoCo, contacts of two": ("#1f4e8c", "P", "-"),
    "MuJoCo, contacts of 20": ("#3a8fb7", "X", "--"),
    "LMGC90": ("#2e7d4f", "*", "-"),
}
COLUMNS = 4  # of pictures in a row
README_SCENES = ("Phocas, 0.05 g 2 Hz", "Phocas, El Centro")
LARGEST_ERROR, SMALLEST_ERROR = 0.5, 1e-10  # parts of the peak: range that is drawn
GREY = "0.92"  # errors smaller than the difference of the references


def work_precision(scenes: list[dict[str, Any]], path: Path, cost: str = "seconds") -> None:
    """Draw one picture a scene with all competitors but UX_ONLY: error over time or evaluations."""
    drawn = [scene for scene in scenes if "points" in scene]
    columns = min(COLUMNS, len(drawn))
    rows = math.ceil(len(drawn) / columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(4.3 * columns, 3.7 * rows + 0.9), squeeze=False, sharey=True, layout="constrained"
    )
    handles: dict[str, Any] = {}
    for axis, scene in zip(axes.flat, drawn, strict=False):
        for name, points in scene["points"].items():
            found = [(c, e) for e, c in pairs(points, cost) if SMALLEST_ERROR <= e <= LARGEST_ERROR]
            if found and name != UX_ONLY:
                handles.setdefault(name, _draw(axis, name, found, 1e3 if cost == "seconds" else 1.0))
        _label(axis, scene)
        if cost == "evaluations":
            axis.xaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axis.xaxis.set_major_formatter("{x:.0f}")
            axis.xaxis.set_minor_formatter("{x:.0f}")
        else:
            axis.xaxis.set_minor_formatter(NullFormatter())  # labels would overlap
    for axis in list(axes.flat)[len(drawn) :]:
        axis.set_visible(False)
    label = "time, ms" if cost == "seconds" else "evaluations of the accelerations"
    for column in range(columns):
        last = max(row for row in range(rows) if row * columns + column < len(drawn))
        axes[last][column].set_xlabel(label)
    for row in axes:
        row[0].set_ylabel("largest error, part of the peak")
    handles["references disagree"] = Patch(color=GREY)
    figure.legend(
        list(handles.values()),
        list(handles),
        loc="outside upper center",
        ncols=columns + (columns > 1),
        frameon=False,
        fontsize=10,
    )
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw(axis: Axes, name: str, points: list[tuple[float, float]], factor: float) -> Any:
    colour, marker, line = STYLES.get(name, OTHER_STYLE)
    own = name == "auto"
    (handle,) = axis.loglog(
        [factor * cost for cost, _ in points],
        [error for _, error in points],
        color=colour,
        marker=marker,
        linestyle=line,
        markersize=5 if own else 3.5,
        linewidth=2.2 if own else 1.1,
        zorder=3 if own else 2,
    )
    return handle


def _label(axis: Axes, scene: dict[str, Any]) -> None:
    regimes = scene["regimes"]
    shares = [
        f"{share:.0%} {name}"
        for name, share in (
            ("contact", regimes["full_contact"]),
            ("rocking", regimes["rocking"]),
            ("flight", regimes["flight"]),
        )
        if share >= 0.005
    ]
    axis.set_title(f"{scene['title']}\n{scene['window']:.3g} s, {', '.join(shares)}", fontsize=10)
    axis.set_ylim(SMALLEST_ERROR, 1.0)
    for error in EQUAL_ERRORS:
        axis.axhline(error, color="0.8", linewidth=0.8, zorder=1)
    axis.axhspan(SMALLEST_ERROR, max(scene["disagreement"], SMALLEST_ERROR), color=GREY, zorder=0)
    axis.grid(True, which="major", axis="x", color="0.9", linewidth=0.6)


def scaling(rows: list[dict[str, Any]], path: Path) -> None:
    """Draw the cost per block of one evaluation and of a second of motion, against the number of blocks."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.plot([r["n"] for r in rows], [1e9 * r["evaluation"] for r in rows], color=STYLES["auto"][0], marker="o")
    left.set_ylabel("one evaluation, ns per block")
    simulated = [r for r in rows if "simulated" in r]
    right.plot(
        [r["n"] for r in simulated], [1e3 * r["simulated"] for r in simulated], color=STYLES["auto"][0], marker="o"
    )
    right.set_ylabel("a second of motion, ms per block")
    for axis in (left, right):
        axis.set_xscale("log")
        axis.set_ylim(bottom=0.0)
        axis.set_xlabel("blocks")
        axis.set_xticks([r["n"] for r in rows], [str(r["n"]) for r in rows])
        axis.minorticks_off()
        axis.grid(True, color="0.9", linewidth=0.6)
    left.set_title("the compiled kernel, shafts in n blocks", fontsize=10)
    right.set_title("simulate, auto at 1e-5, towers of n drums", fontsize=10)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def peers(panels: dict[str, dict[str, list[tuple[float, float]]]], path: Path) -> None:
    """Draw error over time of each program, a panel for each task."""
    figure, axes = plt.subplots(1, len(panels), figsize=(5.0 * len(panels), 5.6), squeeze=False, layout="constrained")
    handles: dict[str, Any] = {}
    for axis, (title, points) in zip(axes[0], panels.items(), strict=True):
        for name, pairs_of in points.items():
            style = next((style for key, style in PEERS.items() if name.startswith(key)), OTHER_STYLE)
            colour, marker, line = style
            (handle,) = axis.loglog(
                [pace for pace, _ in pairs_of],
                [error for _, error in pairs_of],
                color=colour,
                marker=marker,
                linestyle=line,
                markersize=5,
            )
            handles.setdefault(name, handle)
        axis.set_title(title, fontsize=10)
        axis.set_xlabel("ms of one core for a second of motion")
        axis.grid(True, color="0.9", linewidth=0.6)
    axes[0][0].set_ylabel("error, as a ratio")
    figure.legend(list(handles.values()), list(handles), loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    figure.savefig(path, dpi=90)
    plt.close(figure)
