"""Draw the structures of examples/structures under one motion: `python docs/make_structure_images.py`.

Each as it stands where it moves most, and the orbit of its highest block in plan.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from multiblock import Motion, Structure, simulate
from solver.ground.motion import STANDARD_GRAVITY
from solver.plotting.structures import draw_blocks
from solver.plotting.style import INK

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parent / "examples" / "structures"
NAMES = ("trilith", "colonnade", "doric-in-space", "podium", "arch", "casks")
MOTION = Motion.harmonic(0.25 * STANDARD_GRAVITY, 1.2, 4.0, direction=0.4)
SHOWN = 0.06  # of the height: how far the block that moves most is drawn


def main() -> None:
    """Write images/structures.png."""
    figure = Figure(figsize=(13.5, 9.2), layout="constrained")
    grid = figure.add_gridspec(4, 3, height_ratios=(2.0, 1.0, 2.0, 1.0))
    for k, name in enumerate(NAMES):
        structure = Structure.from_toml(EXAMPLES / f"{name}.toml")
        response = simulate(structure, MOTION, settle=0.0)
        row, column = 2 * (k // 3), k % 3
        apart = np.hypot(response.ux, response.uy)
        at = int(np.argmax(np.max(apart, axis=1)))
        height = float(np.max([block.corners[:, 2].max() for block in structure.blocks]))
        scale = max(1, round(SHOWN * height / float(apart[at].max())))
        axes = figure.add_subplot(grid[row, column], projection="3d")
        u = np.stack([response.ux[at], response.uy[at], response.uz[at]], axis=1)
        draw_blocks(axes, structure, scale * u, scale * response.rotation[at])
        times = f", deformation x {scale}" if scale > 1 else ""
        axes.set_title(f"{name}, {response.time[at]:.2f} s{times}", fontsize=10)
        top = int(np.argmax([block.centroid[2] for block in structure.blocks]))
        plan = figure.add_subplot(grid[row + 1, column])
        plan.plot(1e3 * response.ux[:, top], 1e3 * response.uy[:, top], color=INK, linewidth=0.8)
        plan.set_aspect("equal", adjustable="datalim")
        plan.set_xlabel(f"$u_x$ of {structure.names[top]} (mm)", fontsize=8)
        plan.set_ylabel("$u_y$ (mm)", fontsize=8)
        plan.tick_params(labelsize=7)
        plan.grid(alpha=0.3)
        print(f"{name}: {apart.max() * 1e3:.0f} mm, {response.verdict}")
    figure.savefig(HERE / "images" / "structures.png", dpi=90)


if __name__ == "__main__":
    main()
