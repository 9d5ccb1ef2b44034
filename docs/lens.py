"""A straight cut beside the lens in which two slipped drums overlap: `python docs/lens.py` prints the table.

Two equal circles touch in a lens; a straight cut takes off the upper one what lies beyond the rim of the lower one.
Moments of both by quadrature; a joint begins to open where the resultant leaves the kern.
"""

from collections.abc import Callable

import numpy as np
from scipy.integrate import quad

SLIPS = (0.01, 0.02, 0.05, 0.1, 0.2)  # of the diameter
Width = Callable[[float], float]  # of a contact over the place along the motion, radii


def chord(x: float) -> float:
    """Of a circle of radius 1."""
    return 2.0 * float(np.sqrt(max(0.0, 1.0 - x * x)))


def moments(width: Width, slip: float) -> tuple[float, float, float]:
    """Area, middle, second moment about it of what lies between the rims, by the radius."""

    def over(f: Callable[[float], float]) -> float:
        parts = ((-1.0, -0.5 * slip), (-0.5 * slip, 1.0 - slip))
        return float(sum(quad(lambda x: width(x) * f(x), *part, limit=200)[0] for part in parts))

    area = over(lambda x: 1.0)
    middle = over(lambda x: x) / area
    return area, middle, over(lambda x: (x - middle) ** 2)


def lever(found: tuple[float, float, float], slip: float, side: int) -> float:
    """How far from the middle of the overlap the resultant is when the joint begins to open, towards a side."""
    area, middle, second = found
    opposite = 1.0 + middle if side > 0 else 1.0 - slip - middle
    return side * (middle + 0.5 * slip) + second / (area * opposite)


if __name__ == "__main__":
    heads = "slip, diameters", "overlap, part of the face", "area", "stiffness against rotation"
    print("| " + " | ".join((*heads, "opens, over the rim that cuts", "opens, the other way")) + " |")
    print("|---" * 6 + "|")
    for part in SLIPS:
        slip = 2.0 * part
        lens = moments(lambda x, slip=slip: min(chord(x), chord(x + slip)), slip)  # type: ignore[misc]
        cut = moments(chord, slip)
        ratios = [cut[0] / lens[0], cut[2] / lens[2], *(lever(cut, slip, k) / lever(lens, slip, k) for k in (1, -1))]
        print(
            f"| {part:g} | {lens[0] / np.pi:.3f} | " + " | ".join(f"{100.0 * (x - 1.0):+.1f} %" for x in ratios) + " |"
        )
