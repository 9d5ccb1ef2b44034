"""Draw the pictures of the README and the docs: `python docs/make_images.py`."""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from solver import Column, Motion, Response, simulate, wavelets
from solver.record_plots import plot_records

HERE = Path(__file__).resolve().parent
EXAGGERATION = 60.0
STONE = "#cdbfa7"
INK = "#3b3a38"
BLUE = "#0072b2"
RED = "#d55e00"
ARROW = {"arrowstyle": "-|>", "color": RED, "linewidth": 1.6, "mutation_scale": 12}


def block_corners(response: Response, k: int) -> list[np.ndarray]:
    """Corners of every block at row k, rotations and openings exaggerated, from the base up."""
    corners = []
    foot = np.zeros(2)
    blocks = response.column.blocks
    below = 0.0
    for i in range(len(blocks) - 1, -1, -1):
        block = blocks[i]
        turn = EXAGGERATION * response.theta[k, i]
        # a joint that turns about one edge lifts its middle
        foot = foot + np.array([0.0, 0.5 * block.joint_width * abs(np.sin(turn - below))])
        up, along = np.array([np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), -np.sin(turn)])
        half = 0.5 * block.width * along
        corners.append(
            np.array([foot - half, foot + half, foot + half + block.height * up, foot - half + block.height * up])
        )
        foot = foot + block.height * up
        below = turn
    return corners


def arrow(axes: Axes, tail: tuple[float, float], tip: tuple[float, float], bend: float = 0.0) -> None:
    axes.annotate("", tip, tail, arrowprops=ARROW | {"connectionstyle": f"arc3,rad={bend}"})


def block(axes: Axes, foot: tuple[float, float], lean: float, height: float = 1.4) -> None:
    """A block on the lower right corner `foot`, 1.2 wide, turned clockwise by `lean` rad."""
    up, along = np.array([np.sin(lean), np.cos(lean)]), np.array([np.cos(lean), -np.sin(lean)])
    corner = np.array(foot)
    outline = np.array([corner, corner + height * up, corner + height * up - 1.2 * along, corner - 1.2 * along])
    axes.add_patch(Polygon(outline, facecolor=STONE, edgecolor=INK, linewidth=1.2))


def signs() -> None:
    """signs.png: numbers of blocks and joints on the left, on the right the resultants of one joint."""
    figure = Figure(figsize=(9.0, 4.9), layout="constrained")
    column, cut = figure.subplots(1, 2, width_ratios=(1.0, 1.0))
    lean = (0.14, 0.09, 0.04)  # of the blocks from the top down
    foot = np.array([0.6, 0.0])
    for i in (3, 2, 1):
        turn = lean[i - 1]
        block(column, (foot[0], foot[1]), turn)
        up, along = np.array([np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), -np.sin(turn)])
        middle = foot + 0.7 * up - 0.6 * along
        column.text(*middle, f"block {i}", ha="center", va="center", color=INK)
        column.text(foot[0] - 1.45, foot[1] + 0.09, f"joint {i}", ha="right", va="center", color=INK)
        foot = foot + 1.4 * up
    top = foot - 0.6 * along
    column.plot([0.0, 0.0], [0.0, 4.75], color=INK, linewidth=0.8, linestyle=":")
    column.plot([-2.6, 2.6], [-0.03, -0.03], color=INK, linewidth=3.0)
    column.plot([top[0], top[0]], [top[1], 4.75], color=INK, linewidth=0.8, linestyle=":")
    arrow(column, (0.0, 4.6), (top[0], 4.6))
    column.text(top[0] + 0.1, 4.6, "ux", color=RED, va="center")
    arrow(column, (1.45, 4.2), (1.75, 3.3), -0.35)
    column.text(1.85, 3.75, "theta,\nclockwise", color=RED, va="center")
    arrow(column, (-0.5, -0.45), (0.5, -0.45))
    column.text(0.6, -0.45, "base.ax", color=RED, va="center")
    for tip, name, place in (((-1.9, 0.45), "x", (-1.82, 0.45)), ((-2.45, 1.0), "z", (-2.45, 1.12))):
        arrow(column, (-2.45, 0.45), tip)
        column.text(*place, name, color=RED, ha="left" if name == "x" else "center", va="center")
    block(cut, (0.6, 0.0), 0.0)
    block(cut, (0.75, 2.25), 0.1)
    cut.text(0.0, 0.7, "block i+1", ha="center", va="center", color=INK)
    cut.text(0.22, 3.0, "block i", ha="center", va="center", color=INK)
    arrow(cut, (0.35, 2.1), (0.35, 1.45))
    cut.text(0.7, 1.75, "N, compression", color=RED, va="center")
    arrow(cut, (-1.3, 1.4), (-0.65, 1.4))
    cut.text(-1.4, 1.4, "S, horizontal,\non the part below", color=RED, ha="right", va="center")
    arrow(cut, (1.5, 2.5), (1.2, 3.4), 0.45)
    cut.text(1.62, 3.0, "M rights the\npart above", color=RED, va="center")
    cut.plot([-0.6, 0.6], [1.42, 1.42], color=BLUE, linewidth=2.5)
    cut.plot([-2.6, 2.6], [-0.03, -0.03], color=INK, linewidth=3.0)
    for axes, title in ((column, "blocks and joints count from the top"), (cut, "joint i, cut: its resultants")):
        axes.text(0.0, 5.2, title, ha="center", va="center", color=INK)
        axes.set(xlim=(-2.8, 2.8), ylim=(-0.7, 5.4), aspect="equal")
        axes.set_axis_off()
    figure.savefig(HERE / "images" / "signs.png", dpi=110)


def phocas() -> None:
    """phocas.png: the Column of Phocas, damped, at 0.05 g and 2 Hz."""
    column = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-damped.toml")
    response = simulate(column, Motion.harmonic(0.05 * column.g, 2.0, 10.0), output_step=0.002)
    figure = Figure(figsize=(9.0, 4.0), layout="constrained")
    drawing, histories = figure.subfigures(1, 2, width_ratios=(1.0, 2.6))
    axes = drawing.add_subplot()
    k = int(np.argmax(np.abs(response.ux[:, 0])))
    for corners in block_corners(response, k):
        axes.add_patch(Polygon(corners, facecolor=STONE, edgecolor=INK, linewidth=1.2))
    axes.axhline(0.0, color=INK, linewidth=3.0)
    axes.annotate("", (1.6, -0.9), (-1.6, -0.9), arrowprops={"arrowstyle": "<->", "color": RED, "linewidth": 1.8})
    axes.text(0.0, -1.25, "base acceleration", color=RED, ha="center", va="top")
    axes.set(xlim=(-4.0, 4.0), ylim=(-2.4, 15.5), aspect="equal")
    axes.set_axis_off()
    axes.set_title(f"Column of Phocas, 14 m\n(rotations x {EXAGGERATION:.0f})", fontsize=9)
    top, contact = histories.subplots(2, 1, sharex=True)
    top.plot(response.time, 1e3 * response.ux[:, 0], color=BLUE, linewidth=0.9)
    top.set_ylabel("top moves by, mm")
    contact.fill_between(response.time, response.contact[:, -1], color=BLUE, alpha=0.35, linewidth=0.0)
    contact.set(ylabel="base in contact", xlabel="time, s", ylim=(0.0, 1.05), xlim=(0.0, response.time[-1]))
    for panel in (top, contact):
        panel.grid(alpha=0.3)
        panel.spines[["top", "right"]].set_visible(False)
    top.set_title("0.05 g at 2 Hz", fontsize=9)
    figure.savefig(HERE / "images" / "phocas.png", dpi=130)
    records()


def records() -> None:
    """Three motions by formula, each of 0.3 g, as `record --plot` draws records."""
    pga = 0.3 * 9.80665
    motions = {
        "Ricker, 1 Hz": wavelets.ricker(pga, 1.0),
        "Mavroeidis-Papageorgiou, 0.5 Hz, 2 cycles, 90 degrees": wavelets.mavroeidis_papageorgiou(
            1.0, 0.5, 2.0, 0.5 * np.pi
        ).scaled_to(pga),
        "noise, 2.5 Hz, 20 s, seed 7": wavelets.filtered_noise(pga, 2.5, 20.0, 7),
    }
    plot_records(motions, HERE / "images" / "records.png")


if __name__ == "__main__":
    signs()
    phocas()
