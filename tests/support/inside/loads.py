"""A kernel of the smallest group of machine code, loaded from the project in the current folder."""

from __future__ import annotations


def area_of_disc() -> float:
    """Return the area of a disc of radius 1 m, from its first moment about a tangent, m3."""
    import numpy as np

    from solver.kernels.api.entries import rings_beyond

    first, second = np.empty(1), np.empty(1)
    rings_beyond(np.ones(1), np.zeros(1), np.array([-1.0]), first, second)
    return float(first[0])
