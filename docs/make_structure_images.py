"""Draw pictures of structures without a browser: `python docs/make_structure_images.py`.

The colonnade under a pulse; the statue from a mesh beside its hull and its convex parts, and its foot.
"""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from multiblock import Structure, simulate, wavelets
from solver.commands.new_mesh import edges_of
from solver.common.files import toml_of
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.structure.hull_tables import in_folder
from solver.plotting.structures import draw_blocks
from solver.plotting.style import INK

HERE = Path(__file__).resolve().parent
PARTS = 8
EXAMPLES = HERE.parent / "examples" / "structures"


def main() -> None:
    """Write images/colonnade.png and images/statue-mesh.png."""
    draw_colonnade()
    draw_statue()


def draw_colonnade() -> None:
    """The colonnade where a pulse from 30 degrees moves it most."""
    motion = wavelets.ricker(0.4 * STANDARD_GRAVITY, 1.0).turned(np.radians(30.0))
    response = simulate(Structure.from_toml(EXAMPLES / "colonnade.toml"), motion)
    response.plot_model(HERE / "images" / "colonnade.png", scale=2.0)
    print(f"colonnade.png: {1e3 * response.peaks['u'].max():.0f} mm, {response.verdict}")


def draw_statue() -> None:
    """The mesh of `statue-mesh.toml`, the hull or the parts that others meet, and the foot that it stands on."""
    statue = Structure.from_toml(EXAMPLES / "statue-mesh.toml")
    data = in_folder(toml_of(EXAMPLES / "statue-mesh.toml"), EXAMPLES)
    mesh = {**data["block"][1], "parts": PARTS}
    split = Structure.from_dict({**data, "block": [data["block"][0], mesh]})
    hull, parts = (Structure.from_dict(made.to_dict()) for made in (statue, split))  # which hold no mesh
    figure = Figure(figsize=(13.0, 6.2), layout="constrained")
    grid = figure.add_gridspec(1, 4, width_ratios=(1.0, 1.0, 1.0, 1.1))
    zero = np.zeros((statue.n, 3))
    drawn = (
        (statue, "as it is drawn and weighs"),
        (hull, "its hull, which others meet,"),
        (parts, f"or {len(split.blocks[1].parts)} convex parts"),
    )
    for k, (structure, what) in enumerate(drawn):
        axes = figure.add_subplot(grid[k], projection="3d")
        draw_blocks(axes, structure, zero, zero)
        axes.tick_params(labelsize=6, pad=-2)
        axes.set_xlabel("x (m)", fontsize=7, labelpad=-6)
        axes.set_ylabel("y (m)", fontsize=7, labelpad=-4)
        axes.set_title(what, fontsize=10)
    block = statue.blocks[1]
    corners = block.faces[0].points()[:, :2]
    plan = figure.add_subplot(grid[3])
    plan.fill(*corners.T, facecolor="#d9d2c3", edgecolor=INK, linewidth=1.0)
    plan.plot(*block.centroid[:2], "o", color=INK, markersize=4)
    plan.annotate("centroid", block.centroid[:2], xytext=(5, 18), textcoords="offset points", fontsize=9)
    height = block.centroid[2] - block.faces[0].centre[2]
    for edge in edges_of(block):
        way = np.array([np.cos(np.radians(edge.direction)), np.sin(np.radians(edge.direction))])
        end = block.centroid[:2] + edge.lever * way
        plan.plot(*np.array([block.centroid[:2], end]).T, color=INK, linewidth=0.7, linestyle=":")
        plan.annotate(
            f"{edge.slenderness:.3f} rad",
            block.centroid[:2] + 0.65 * edge.lever * way,
            ha="center",
            va="center",
            fontsize=9,
            backgroundcolor="#d9d2c3",
        )
    plan.set_aspect("equal")
    plan.margins(0.12)
    plan.set_xlabel("x (m)")
    plan.set_ylabel("y (m)")
    plan.set_title(f"foot; centroid {height:.3f} m over it", fontsize=10)
    figure.savefig(HERE / "images" / "statue-mesh.png", dpi=110, bbox_inches="tight")


if __name__ == "__main__":
    main()
