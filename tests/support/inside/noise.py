"""Filtered noise made in another process."""

from __future__ import annotations

from solver.ground.wavelets import filtered_noise


def samples(seed: int) -> str:
    """Return every bit of 5 s of noise."""
    return filtered_noise(1.0, 2.5, 5.0, seed).ax.tobytes().hex()
