"""Structures in space that several tests share."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from solver.ground.motion import Motion
from solver.models.protocol import RunPlan
from solver.models.structure.blocks.parts import SpatialJoint
from solver.models.structure.model import Structure
from solver.models.structure.response import SpatialResponse
from solver.models.structure.run import SpatialState, single_run
from solver.statics.rocking import damping_on_edge

MODULUS = 533.0 * 9.80665e6  # N/m3, of the paper's column


def stack(
    n: int = 3, section: str = "rectangle", damping: float = 1e-3, ratio: float = 0.4, **options: Any
) -> Structure:
    """Return blocks of the size of the paper's, boxes or drums; the lowest first."""
    shape: dict[str, Any] = (
        {"shape": "drum", "diameter": 1.56} if section == "circle" else {"width": 1.56, "depth": 1.56}
    )
    blocks = [
        {"name": f"b{i}", "height": 4.69, "mass": 27000.0, "on": f"b{i - 1}" if i else "base", **shape}
        for i in range(n)
    ]
    law = {"stiffness": MODULUS, "damping": damping, "shear_ratio": ratio}
    return replace(Structure.from_dict({"name": "stack", "joints": law, "block": blocks}), **options)


def law_on_edge(
    stiffness: float, size: tuple[float, float, float], density: float, rim: float | None
) -> dict[str, float]:
    """Return the law of a joint that is critically damped as a block stands on its edge.

    size: width, depth and height of the block, m; rim: m, None for the whole face, of which half counts.
    """
    width, depth, height = size
    mass = density * width * depth * height
    half, inertia = 0.5 * width, mass * (width**2 + height**2) / 12.0
    damping = damping_on_edge(stiffness, depth * (rim or half), mass, inertia, half)
    return {"stiffness": stiffness, "damping": damping, **({"rim": rim} if rim else {})}


def with_law(structure: Structure, **changes: Any) -> Structure:
    """Return the structure with other numbers in the law of every joint."""

    def changed(joint: SpatialJoint) -> SpatialJoint:
        return replace(joint, bed=replace(joint.bed, **changes))

    return replace(structure, joints=tuple(map(changed, structure.joints)))


def run(
    structure: Structure, motion: Motion, duration: float | None = None, initial: SpatialState | None = None
) -> SpatialResponse:
    """Return a run with rows every 5 ms; it is not followed after its end."""
    duration = motion.duration if duration is None else duration
    times = motion.start + 0.005 * np.arange(int(duration / 0.005) + 1, dtype=np.float64)
    return single_run(structure, RunPlan(motion, duration, times, initial))
