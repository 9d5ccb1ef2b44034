"""Draw the pictures of the README and the docs: `python docs/make_images.py`."""

from pathlib import Path

import numpy as np
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


def main() -> None:
    """The Column of Phocas, damped, at 0.05 g and 2 Hz."""
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
    main()
