"""Well-damped columns, as mortar makes them: error (tolerances), and amplification of small changes by the motion.

The dampers of their joints make them stiff, so that `auto` steps implicitly. Each scene is run once without implicit
steps at a tight tolerance, as its reference, and again with motion and stiffnesses changed slightly. The amplification
is the largest ratio of the change of the response to that change. A seed and a number reproduce a random column.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from solver import Block, Column, Joint, Motion, Response, SolverError, simulate

from .scenes import RECORDS, G, Scene, shaft

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
QUICK_TOLERANCES = (1e-2, 1e-3, 1e-5)
REFERENCE_TOLERANCE = 1e-9
WITHOUT = ("implicit",)
NUDGES = (1e-7, 1e-3, -1e-3)  # relative change of motion and stiffnesses: small at tight and at loose tolerances
LONGEST = 20.0  # s
BEFORE_FALL = 0.1  # s before the fall in which no error is measured
PREDICTABLE = 100.0  # amplification: errors beyond it are due to the motion
MOST_ERROR = 10.0  # tolerances, where the amplification is less

SEED = 1
CASES, QUICK_CASES = 20, 3
DENSITY = 2500.0  # kg/m3
FILES = (
    "kobe-1995-nishi-akashi-090.AT2",
    "cape-mendocino-1992-cpm000.AT2",
    "chi-chi-1999-tcu052-n.AT2",
    "elcentro-1940-ns.AT2",
    "northridge-1994-arleta-360.AT2",
)


def fixed() -> Iterator[Scene]:
    """Yield Phocas in mortar: under a harmonic motion, and under a record where there is one."""
    column = shaft(3, 0.05)
    duration = 6.0
    yield Scene("mortar", "Phocas, eta 0.05 s, 0.2 g 1.5 Hz", column, Motion.harmonic(0.2 * G, 1.5, duration), duration)
    path = RECORDS / FILES[0]
    if path.is_file():
        title = "Phocas, eta 0.05 s, Kobe x 0.8"
        yield Scene("mortar-kobe", title, column, Motion.from_at2(path).scaled(0.8), LONGEST)


def drawn(seed: int, number: int) -> Scene:
    """Return a random column under a record that makes it rock, or under a harmonic motion where there is no record."""
    rng = np.random.default_rng([seed, number])
    n = int(rng.integers(1, 7))
    side = rng.uniform(0.8, 2.0)
    blocks = []
    for _ in range(n):
        height = rng.uniform(0.5, 3.0)
        width, depth = side * rng.uniform(0.8, 1.2, 2)
        joint = Joint(10.0 ** rng.uniform(8.5, 10.0), 10.0 ** rng.uniform(math.log10(0.003), -1.0))
        blocks.append(Block(height, width, depth, DENSITY * height * width * depth, joint))
    column = Column(f"damped_{seed}_{number}", tuple(blocks))
    wanted = rng.uniform(1.2, 6.0) * G * blocks[-1].width / sum(block.height for block in blocks)  # m/s2, of the peak
    path = RECORDS / FILES[number % len(FILES)]
    frequency = rng.uniform(0.7, 3.0)
    if path.is_file():
        record = Motion.from_at2(path)
        motion = record.scaled(wanted / float(np.max(np.abs(record.ax))))
        under = path.stem
    else:
        motion = Motion.harmonic(0.2 * wanted, frequency, LONGEST)
        under = f"{frequency:.2f} Hz"
    title = f"{seed}-{number}: {n} blocks, {wanted / G:.2f} g, {under}"
    return Scene(column.name, title, column, motion, min(LONGEST, motion.duration))


def nudged(scene: Scene, part: float) -> Scene:
    """Return the scene with motion and stiffnesses changed by a relative amount, smaller than their uncertainty."""
    blocks = tuple(
        replace(block, joint=replace(block.joint, stiffness=block.joint.stiffness * (1.0 + (-1) ** i * part)))
        for i, block in enumerate(scene.column.blocks)
    )
    return replace(scene, column=replace(scene.column, blocks=blocks), motion=scene.motion.scaled(1.0 + part))


def run(scene: Scene, tolerance: float, without: tuple[str, ...] = ()) -> Response:
    """Run the scene at a tolerance."""
    return simulate(scene.column, scene.motion, scene.duration, tolerance=tolerance, without=without, settle=0.0)


def deviation(one: Response, reference: Response) -> float:
    """Return the largest difference of ux while both stand, part of the reference's peak until then."""
    falls = [response.overturn_time - BEFORE_FALL for response in (one, reference) if response.overturned]
    rows = int(np.searchsorted(reference.time, min(falls, default=math.inf)))
    if rows == 0:
        return math.inf
    peak = float(np.max(np.abs(reference.ux[:rows])))
    return float(np.max(np.abs(one.ux[:rows] - reference.ux[:rows]))) / peak


def amplification(scene: Scene, reference: Response, part: float) -> float:
    """Return the ratio of the relative change of the response to this relative change; infinity if the verdict
    changes.
    """
    other = run(nudged(scene, part), REFERENCE_TOLERANCE, WITHOUT)
    return deviation(other, reference) / abs(part) if other.overturned == reference.overturned else math.inf


def measure(scene: Scene, tolerances: tuple[float, ...] = TOLERANCES) -> dict[str, Any]:
    """Measure amplification and verdict of a scene, and a row for each tolerance: error in tolerances, verdict,
    evaluations.
    """
    reference = run(scene, REFERENCE_TOLERANCE, WITHOUT)
    rows: list[dict[str, Any]] = []
    for tolerance in tolerances:
        try:
            response = run(scene, tolerance)
        except SolverError as failure:
            rows.append({"tolerance": tolerance, "failure": str(failure)})
            continue
        rows.append(
            {
                "tolerance": tolerance,
                "error": deviation(response, reference) / tolerance,
                "overturned": response.overturned,
                "evaluations": response.stats["evaluations"],
                "implicit_steps": response.stats["implicit_steps"],
            }
        )
    return {
        "scene": scene.title,
        "amplification": max(amplification(scene, reference, part) for part in NUDGES),
        "overturned": reference.overturned,
        "rows": rows,
    }


def failures(found: dict[str, Any]) -> list[str]:
    """Return the failures: a large error or another verdict where the motion can be predicted, and any run that stopped
    early.
    """
    predictable = found["amplification"] < PREDICTABLE
    said = []
    for row in found["rows"]:
        where = f"{found['scene']} at {row['tolerance']:.0e}"
        if "failure" in row:
            said.append(f"{where}: {row['failure']}")
        elif predictable and row["overturned"] != found["overturned"]:
            said.append(f"{where}: {verdict(row)}, the reference {verdict(found)}")
        elif predictable and not row["error"] <= MOST_ERROR:
            said.append(f"{where}: {row['error']:.3g} tolerances at amplification {found['amplification']:.3g}")
    return said


def verdict(row: dict[str, Any]) -> str:
    """Return the verdict in a word."""
    return "falls" if row["overturned"] else "stands"


def summary(found: dict[str, Any]) -> str:
    """Return one scene in one line."""
    parts = [
        "gave up"
        if "failure" in row
        else f"{row['error']:.2g}{'' if row['overturned'] == found['overturned'] else '!'}"
        for row in found["rows"]
    ]
    return f"{found['scene']}: {verdict(found)}, amplification {found['amplification']:.3g}; error {' '.join(parts)}"
