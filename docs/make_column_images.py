"""Draw a picture of each column of examples/columns: `python docs/make_column_images.py`, or some by their names."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from multiblock import Block, Column, capacity_curve, natural_frequencies
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.packing import FloatArray
from solver.plotting.drawings import DisplacementHistories, corners_of
from solver.plotting.style import INK, STONE

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "examples" / "columns"
MEASURE = "#0072b2"  # colour of dimensions
MAN = 1.75  # m, drawn beside for the scale


def outlines_of(column: Column) -> list[FloatArray]:
    """Corners of the blocks as built, m (4, 2) each."""
    return corners_of(DisplacementHistories(column, *np.zeros((3, 1, column.n))), 0, 1.0)


def built_off(column: Column) -> float:
    """How far off the axis the middle of the top is as built, m to +x."""
    return float(np.mean(outlines_of(column)[0][2:, 0])) if column.off_axis else 0.0


def draw_elevation(axes: Axes, column: Column) -> None:
    """The column as built, with its height, its widths below and above, and a man."""
    outlines = outlines_of(column)
    for outline in outlines:
        axes.add_patch(Polygon(outline, facecolor=STONE, edgecolor=INK, linewidth=0.7))
    corners = np.concatenate(outlines)
    (left, _), (right, _) = corners.min(axis=0), corners.max(axis=0)
    top = sum(block.height for block in column.blocks)
    wide = 0.12 * top + right - left
    axes.axhline(0.0, color=INK, linewidth=2.0)
    place = left - 0.06 * top
    axes.annotate("", (place, top), (place, 0.0), arrowprops={"arrowstyle": "<->", "color": MEASURE, "linewidth": 0.8})
    axes.text(
        place - 0.015 * top, 0.5 * top, f"{top:.2f} m", color=MEASURE, fontsize=8, ha="right", va="center", rotation=90
    )
    for outline, ends, below in ((outlines[-1], (0, 1), True), (outlines[0], (3, 2), False)):
        (x0, z0), (x1, _) = outline[ends[0]], outline[ends[1]]
        height = -0.035 * top if below else z0 + 0.03 * top
        axes.annotate(
            "",
            (x0, height),
            (x1, height),
            arrowprops={"arrowstyle": "<->", "color": MEASURE, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0},
        )
        axes.text(
            0.5 * (x0 + x1),
            height + (-0.015 if below else 0.015) * top,
            f"{x1 - x0:.2f} m",
            color=MEASURE,
            fontsize=8,
            ha="center",
            va="top" if below else "bottom",
        )
    if column.off_axis:
        axes.plot([0.0, 0.0], [0.0, 1.02 * top], color=INK, linewidth=0.7, linestyle=":")
    man = right + 0.5
    axes.add_patch(Rectangle((man - 0.18, 0.0), 0.36, 0.86 * MAN, color="0.75", linewidth=0.0))
    axes.add_patch(Circle((man, 0.93 * MAN), 0.07 * MAN, color="0.75", linewidth=0.0))
    axes.set(
        xlim=(left - 0.2 * top - 0.1, max(man + 0.4, left + wide)),
        ylim=(-0.09 * top, 1.09 * max(top, MAN)),
        aspect="equal",
    )
    axes.set_axis_off()


def draw_contact(axes: Axes, block: Block) -> None:
    """Draw the contact under a block, seen from above."""
    half, deep = 0.5 * block.width, 0.5 * block.depth
    section = block.joint.section or block.section
    if section in ("circle", "annulus"):
        axes.add_patch(Circle((0.0, 0.0), 0.5 * block.joint_width, facecolor=STONE, edgecolor=INK, linewidth=0.8))
        if section == "annulus":
            axes.add_patch(Circle((0.0, 0.0), 0.5 * block.joint_bore, facecolor="white", edgecolor=INK, linewidth=0.8))
    elif section == "strips":
        axes.add_patch(
            Rectangle((-half, -deep), 2.0 * half, 2.0 * deep, fill=False, edgecolor=INK, linestyle=":", linewidth=0.8)
        )
        strips = block.joint.strips or ()
        width = block.width / len(strips)
        for k, depth in enumerate(strips):
            axes.add_patch(Rectangle((-half + k * width, -0.5 * depth), width, depth, facecolor=STONE, linewidth=0.0))
    else:
        wide, deep = block.joint_width, block.joint_depth
        axes.add_patch(Rectangle((-0.5 * wide, -0.5 * deep), wide, deep, facecolor=STONE, edgecolor=INK, linewidth=0.8))
    reach = 0.55 * max(block.width, block.depth)
    axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
    axes.set_axis_off()


def picture(name: str) -> Figure:
    """The column, its lowest contact, or one of strips, and when its joints open under a steady acceleration."""
    column = Column.from_toml(EXAMPLES / f"{name}.toml")
    curve = capacity_curve(column)
    frequencies = natural_frequencies(column)
    uplift = np.nanmin(curve.uplift) / STANDARD_GRAVITY
    shown = next((k for k, block in enumerate(column.blocks) if block.joint.strips), column.n - 1)
    figure = Figure(figsize=(4.6, 4.4), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=(1.35, 1.0), height_ratios=(1.0, 1.0))
    draw_elevation(figure.add_subplot(grid[:, 0]), column)
    contact = figure.add_subplot(grid[0, 1])
    draw_contact(contact, column.blocks[shown])
    contact.set_title(f"joint {shown + 1} from above", fontsize=8)
    text_axes = figure.add_subplot(grid[1, 1])
    text_axes.set_axis_off()
    mass = sum(block.mass for block in column.blocks)
    lines: tuple[str, ...] = (
        f"{column.n} blocks, {1e-3 * mass:.3g} t",
        f"{frequencies[0]:.3g} and {frequencies[1]:.3g} Hz",
        f"a joint opens at {uplift:.3g} g",
        f"balances {curve.largest_acceleration / STANDARD_GRAVITY:.3g} g",
    )
    leaning = built_off(column)
    if leaning:
        lines += (f"its top stands off by {1e3 * leaning:.3g} mm",)
    text_axes.text(0.0, 0.9, "\n".join(lines), fontsize=8, va="top", linespacing=1.6, color=INK)
    figure.suptitle(name, fontsize=10)
    return figure


if __name__ == "__main__":
    names = sys.argv[1:] or sorted(path.stem for path in EXAMPLES.glob("*.toml"))
    for name in names:
        picture(name).savefig(HERE / "images" / f"column-{name}.png", dpi=90)
