"""Make the mesh of `statue-mesh.toml`, a draped figure of 1.9 m on its plinth: rings of corners, one above the other.

    python examples/structures/statue_mesh.py [statue.obj] [--sides 32] [--rings 40]

No scan: a shape to try `shape = "mesh"` with. Lengths in m, z up. Of 40 rings of 32 corners, 2600 triangles, 70 kB.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

PLINTH = 0.14  # m, its height
CROWN = 1.9
# height (m), middle x, y, half widths along x and y (m), depth of the folds over the half width
FIGURE = np.array(
    [
        [0.14, 0.00, 0.00, 0.20, 0.17, 0.12],
        [0.30, 0.01, 0.00, 0.18, 0.15, 0.14],
        [0.60, 0.02, 0.00, 0.17, 0.14, 0.12],
        [0.90, 0.03, 0.00, 0.19, 0.15, 0.08],
        [1.15, 0.02, 0.01, 0.16, 0.12, 0.05],
        [1.40, 0.01, 0.01, 0.22, 0.14, 0.03],
        [1.52, 0.01, 0.00, 0.21, 0.12, 0.01],
        [1.58, 0.01, 0.01, 0.08, 0.07, 0.00],
        [1.63, 0.01, 0.02, 0.07, 0.08, 0.00],
        [1.70, 0.01, 0.03, 0.09, 0.11, 0.00],
        [1.80, 0.01, 0.03, 0.10, 0.12, 0.00],
        [1.87, 0.01, 0.02, 0.07, 0.09, 0.00],
        [1.90, 0.01, 0.02, 0.02, 0.03, 0.00],
    ]
)
PLINTH_SIZE = 0.28, 0.24  # m, half of its widths
FOLDS = 9


def mesh(sides: int, rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners (n, 3) m, and triangles (k, 3) by number from 0, outside anticlockwise; sides: a multiple of
    8.
    """
    angle = 2.0 * np.pi * np.arange(sides) / sides
    around = np.column_stack([np.cos(angle), np.sin(angle)])
    square = around / np.max(np.abs(around), axis=1, keepdims=True) * PLINTH_SIZE
    levels = [np.column_stack([square, np.full(sides, z)]) for z in (0.0, PLINTH)]
    for z in np.linspace(PLINTH, CROWN, rings):
        x, y, wide, deep, fold = (np.interp(z, FIGURE[:, 0], FIGURE[:, k]) for k in range(1, 6))
        reach = 1.0 + fold * np.cos(FOLDS * angle + 2.0 * z)
        points = np.array([x, y]) + around * [wide, deep] * reach[:, None]
        levels.append(np.column_stack([points, np.full(sides, z)]))
    corners = np.concatenate([*levels, [[0.0, 0.0, 0.0], [*np.mean(levels[-1], axis=0)]]])
    k = np.arange(sides)
    after, last = (k + 1) % sides, sides * (len(levels) - 1)
    below, above = np.full(sides, len(corners) - 2), np.full(sides, len(corners) - 1)
    triangles = [np.column_stack([below, after, k]), np.column_stack([above, last + k, last + after])]
    for low in range(0, last, sides):
        triangles.append(np.column_stack([low + k, low + after, low + sides + after]))
        triangles.append(np.column_stack([low + k, low + sides + after, low + sides + k]))
    return corners, np.concatenate(triangles)


def write(path: Path, sides: int = 32, rings: int = 40) -> None:
    """Write the mesh as OBJ."""
    corners, triangles = mesh(sides, rings)
    lines = [f"v {x:.4f} {y:.4f} {z:.4f}" for x, y, z in corners]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    path.write_text("# made by statue_mesh.py\n" + "\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    """Write it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("path", type=Path, nargs="?", default=Path("statue.obj"))
    parser.add_argument("--sides", type=int, default=32, help="corners of a ring, a multiple of 8")
    parser.add_argument("--rings", type=int, default=40)
    options = parser.parse_args()
    write(options.path, options.sides, options.rings)
    print(f"{options.path}: {options.path.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
