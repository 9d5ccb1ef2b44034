"""Structures in space within 3 % of the motion that overturns them, as boundary.py does it for columns.

A structure and a motion in any horizontal direction are drawn; the scale between standing and falling is bisected, and
the structure is run at random scales within `BAND` of it, alone and in lanes. One that is said to stand is followed for
`LONGER`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from multiblock import InputError, Motion, SolverError, Structure, arch, colonnade, wall
from solver.common.executors import cores
from solver.ground.wavelets import one_sine
from solver.models.protocol import OVERTURNED, SETTLE, STANDING, Run
from solver.models.still_base import settled
from solver.models.structure.lanes import follow_in_lanes
from solver.models.structure.outputs import FROM_LANES
from solver.models.structure.rest import rest_of
from solver.models.structure.run import SpatialSettling, begun

from .boundary import BAND, GROW, LONGER, MOST, WIDTH
from .scenes import G

FRICTION = ", friction"
KINDS = {  # of structures: how many structures are drawn
    "eccentric stacks": 20,
    "drums": 15,
    "podia": 15,
    "triliths": 15,
    "colonnades": 10,
    "arches": 19,
    "arches" + FRICTION: 19,
    "walls": 6,
    "walls" + FRICTION: 6,
}
QUICK_KINDS = dict.fromkeys(("eccentric stacks", "arches" + FRICTION), 1)
SCALES = 8  # of each structure
SEED, FIRST = 11, 0.3
TOLERANCE = 1e-4
FAILED = "failed"
DENSITY = 2500.0  # kg/m3


class Case(NamedTuple):
    """A structure and the motion near the boundary."""

    structure: Structure
    motion: Motion


class Judged(NamedTuple):
    """Verdicts alone and in lanes; when a structure that is said to stand falls after all, s, else NaN.

    word is FAILED, or late_failed True, if the run, or the longer one of a structure that stands, ended with an error.
    """

    word: str
    in_lanes: str
    late: float
    late_failed: bool = False


class Near(NamedTuple):
    """Verdicts near the boundary of a structure, and the drawn ones passed over before it."""

    judged: list[Judged]
    without_rest: int = 0
    never_fell: int = 0
    failed: int = 0  # in the search for the boundary


def drawn(rng: np.random.Generator, kind: str) -> Case:
    """Return a damped structure of a kind, and a sine or a burst that tips a block of its slenderness."""
    law: dict[str, Any] = {"stiffness": 10.0 ** rng.uniform(8.7, 10.0), "damping": 10.0 ** rng.uniform(-3.0, -2.3)}
    if kind.endswith(FRICTION):
        law["friction"] = float(rng.uniform(0.3, 0.8))
    slenderness = float(rng.uniform(3.0, 7.0))
    structure = DRAWN[kind.removesuffix(FRICTION)](rng, law, slenderness)
    top = max(float(np.max(block.corners[:, 2])) for block in structure.blocks)
    frequency = 10.0 ** rng.uniform(-0.3, 0.7) * math.sqrt(0.75 * G / top) / (2.0 * math.pi)
    direction = 0.0 if kind.startswith("arches") else float(rng.uniform(0.0, 2.0 * math.pi))
    peak = G / slenderness
    if rng.random() < 0.5:
        motion = one_sine(peak, frequency)
        motion = replace(motion, ax=math.cos(direction) * motion.ax, ay=math.sin(direction) * motion.ax)
    else:
        motion = Motion.harmonic(peak, frequency, float(rng.integers(2, 9)) / frequency, direction=direction)
    return Case(structure.with_settings(tolerance=TOLERANCE, without=("peaks",)), motion)


def _box(name: str, width: float, depth: float, height: float, on: str, at: tuple[float, float]) -> dict[str, Any]:
    size = {"width": width, "depth": depth, "height": height, "density": DENSITY}
    return {"name": name, "on": on, "at": [float(place) for place in at], **size}


def _made(law: dict[str, Any], blocks: list[dict[str, Any]]) -> Structure:
    return Structure.from_dict({"name": "drawn", "joints": law, "block": blocks})


def _eccentric(rng: np.random.Generator, law: dict[str, Any], slenderness: float) -> Structure:
    n, height = int(rng.integers(1, 5)), 10.0 ** rng.uniform(0.2, 0.9)
    width, x, y, blocks = height / slenderness, 0.0, 0.0, []
    for k in range(n):
        blocks.append(
            _box(f"b{k}", width, width * rng.uniform(0.8, 1.2), height / n, f"b{k - 1}" if k else "base", (x, y))
        )
        x, y = x + rng.uniform(-0.15, 0.15) * width, y + rng.uniform(-0.15, 0.15) * width
    return _made(law, blocks)


def _drums(rng: np.random.Generator, law: dict[str, Any], slenderness: float) -> Structure:
    n, height = int(rng.integers(1, 7)), 10.0 ** rng.uniform(0.2, 0.9)
    wide = [height / slenderness * (1.0 - 0.2 * k / n) for k in range(n + 1)]
    size = {"shape": "drum", "height": height / n, "density": DENSITY}
    return _made(
        law,
        [
            {"name": f"b{k}", "diameter": wide[k], "top_diameter": wide[k + 1], "on": f"b{k - 1}" if k else "base"}
            | size
            for k in range(n)
        ],
    )


def _podium(rng: np.random.Generator, law: dict[str, Any], slenderness: float) -> Structure:
    height = float(rng.uniform(1.0, 3.0))
    wide = height / slenderness
    slab = _box("podium", 3.0 * wide, 2.5 * wide, wide * rng.uniform(1.0, 3.0), "base", (0.0, 0.0))
    left = _box("left", wide, wide, height, "podium", (-0.9 * wide, 0.0))
    right = _box("right", wide, wide, height * rng.uniform(0.7, 1.2), "podium", (0.9 * wide, 0.0))
    return _made(law, [slab, left, right])


def _columns(columns: int, rng: np.random.Generator, law: dict[str, Any]) -> Structure:
    beam = rng.uniform(0.4, 1.2), rng.uniform(0.6, 1.0)
    sizes = 3.0, rng.uniform(0.5, 1.0), rng.uniform(2.5, 5.0)
    return colonnade(columns, int(rng.integers(1, 4)), *sizes, law, architrave=beam, density=DENSITY)


def _arch(rng: np.random.Generator, law: dict[str, Any], slenderness: float) -> Structure:
    radius = float(rng.uniform(2.0, 8.0))
    thickness = radius * rng.uniform(0.12, 0.22)
    return arch(int(rng.integers(7, 16)), radius, thickness, 1.0, law, angle=rng.uniform(2.4, 3.14))


def _wall(rng: np.random.Generator, law: dict[str, Any], slenderness: float) -> Structure:
    stone = rng.uniform(0.5, 1.0), rng.uniform(0.2, 0.5), rng.uniform(0.25, 0.4)
    softer = {**law, "stiffness": 0.1 * law["stiffness"]}  # many joints: stiff ones take long to follow
    return wall(int(rng.integers(3, 5)), 2, stone, softer)


DRAWN = {
    "eccentric stacks": _eccentric,
    "drums": _drums,
    "podia": _podium,
    "triliths": lambda rng, law, slenderness: _columns(2, rng, law),
    "colonnades": lambda rng, law, slenderness: _columns(3, rng, law),
    "arches": _arch,
    "walls": _wall,
}


def judged(case: Case) -> Judged:
    """Return the verdicts of a case, and whether it falls after all."""
    structure, motion = case
    stepper, _ = begun(structure, motion)
    try:
        stepper.run(motion, motion.start, motion.end, np.zeros(0))
        word, _, now = settled(SpatialSettling(stepper), motion.end, SETTLE)
    except SolverError:
        word, now = FAILED, motion.end
    run = Run(structure, motion, motion.duration)
    lanes: list[dict[str, Any]] = [{}]
    if not structure.kind.lanes(structure, FROM_LANES).why_not:
        lanes = follow_in_lanes([run], [rest_of(structure)], SETTLE)
    late = math.nan
    if word == STANDING:
        try:
            stepper.run(None, now, now + LONGER, np.zeros(0))
        except SolverError:
            return Judged(word, str(lanes[0].get("verdict", "")), late, late_failed=True)
        late = float(stepper.control.fall_time) - now if stepper.counts.fallen else math.nan
    return Judged(word, str(lanes[0].get("verdict", "")), late)


def falls(case: Case, scale: float) -> bool:
    """Return True if a structure overturns under its motion at this scale. Raises SolverError."""
    motion = case.motion.scaled(scale)
    stepper, _ = begun(case.structure, motion)
    stepper.run(motion, motion.start, motion.end, np.zeros(0))
    return settled(SpatialSettling(stepper), motion.end, SETTLE).word == OVERTURNED


def judged_near(kind: str, number: int) -> Near:
    """Return the verdicts of `SCALES` runs near the boundary of a structure, the first drawn that rests and falls."""
    rng = np.random.default_rng([SEED, list(KINDS).index(kind), number])
    passed_over = Near([])
    while True:
        case = drawn(rng, kind)
        try:
            rest_of(case.structure)
        except InputError:
            passed_over = passed_over._replace(without_rest=passed_over.without_rest + 1)
            continue
        try:
            low, high = FIRST, math.nan
            while not high - low < WIDTH * low and not low > MOST:
                scale = GROW * low if math.isnan(high) else 0.5 * (low + high)
                low, high = (low, scale) if falls(case, scale) else (scale, high)
        except SolverError:  # its steps become too small: another one
            passed_over = passed_over._replace(failed=passed_over.failed + 1)
            continue
        if math.isnan(high):
            passed_over = passed_over._replace(never_fell=passed_over.never_fell + 1)
            continue
        scales = 0.5 * (low + high) * rng.uniform(1.0 - BAND, 1.0 + BAND, SCALES)
        cases = [Case(case.structure, case.motion.scaled(float(scale))) for scale in scales]
        return passed_over._replace(judged=[judged(case) for case in cases])


def measure_kind(kind: str, count: int) -> dict[str, Any]:
    """Count how many structures of a kind are undecided, how many of those that stand fall later."""
    with ThreadPoolExecutor(cores()) as pool:
        near = list(pool.map(lambda number: judged_near(kind, number), range(count)))
    found = [one for boundary in near for one in boundary.judged]
    words, in_lanes = (Counter(getattr(one, name) for one in found) for name in ("word", "in_lanes"))
    late = sum(not math.isnan(one.late) for one in found)
    against = sum({one.word, one.in_lanes} == {STANDING, OVERTURNED} for one in found)
    row = {"kind": kind, "columns": len(found), "words": dict(words), "wrong": late}
    row["failed_later"] = sum(one.late_failed for one in found)
    row["passed_over"] = {name: sum(getattr(one, name) for one in near) for name in Near._fields[1:]}
    return row | {"in_lanes": dict(in_lanes), "against": against}


def measure(quick: bool) -> Iterator[dict[str, Any]]:
    """Measure all kinds, one after the other."""
    for kind, count in (QUICK_KINDS if quick else KINDS).items():
        yield measure_kind(kind, count)
