"""Columns within 3 % of the motion that overturns them: how many verdicts are undecided, and whether any is wrong.

A column and a motion are drawn; the scale of the motion between the column that stands and the one that falls is
bisected, and the column is run at random scales within `BAND` of it. A column that is said to stand is followed for
`LONGER`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from solver import Block, Column, Joint, Motion, simulate_many
from solver.ground.wavelets import mavroeidis_papageorgiou, one_sine, ricker
from solver.models.column.kinematics import chain_of
from solver.models.column.rest import is_stable
from solver.models.column.run import phase_of, settled_verdict
from solver.models.column.stepper import Stepper
from solver.models.protocol import OVERTURNED, SETTLE, STANDING, UNDECIDED

from .scenes import G

KINDS = ("on its axis", "off its axis", "sliding")
COUNTS, QUICK_COUNTS = (1000, 200, 800), (4, 2, 4)
SEED = 7
BAND = 0.03  # of the boundary, either way
SCALES = 4  # within it, of each column
WIDTH = 0.02  # within which the boundary is bisected, of the scale
FIRST, MOST, GROW = 0.5, 20.0, 1.4  # scales, of a motion whose peak tips the column if it lasts
DRAWN_PER_WANTED = 1.2  # number drawn for each that is wanted: some overturn at no scale that is tried
LONGER = 60.0  # s


class Case(NamedTuple):
    """A column and the motion near the boundary."""

    column: Column
    motion: Motion


def drawn(rng: np.random.Generator, kind: str) -> Case:
    """Return a column of 1 to 6 drums or blocks, slender, damped; a wavelet or a burst, with a peak that tips the
    column.
    """
    n = int(rng.integers(1, 7))
    height, slenderness = 10.0 ** rng.uniform(0.2, 1.2), rng.uniform(3.5, 10.0)
    width = height / slenderness
    heights = height * rng.dirichlet(np.full(n, 8.0))
    widths = width * np.sort(rng.uniform(rng.uniform(0.6, 1.0), 1.0, n))
    section = "circle" if rng.random() < 0.5 else "rectangle"
    stiffness, damping = 10.0 ** rng.uniform(8.7, 10.0), 10.0 ** rng.uniform(-3.0, -2.3)
    friction = rng.uniform(max(0.15, 0.9 / slenderness), 0.9) * 10.0 ** rng.uniform(-0.1, 0.1, n)
    blocks = []
    for high, wide, rough in zip(heights.tolist(), widths.tolist(), friction.tolist(), strict=True):
        joint = Joint(
            stiffness * 10.0 ** rng.uniform(-0.1, 0.1),
            damping,
            friction=rough if kind == "sliding" else None,
            offset=float(rng.uniform(-0.05, 0.05)) * wide if kind == "off its axis" else None,
        )
        area = wide**2 * (math.pi / 4.0 if section == "circle" else 1.0)
        blocks.append(Block(high, wide, wide, 2500.0 * area * high, joint, section=section))
    # 0.5 to 5 times the frequency at which the whole column would swing hung up
    frequency = 10.0 ** rng.uniform(-0.3, 0.7) * math.sqrt(0.75 * G / math.hypot(height, width)) / (2.0 * math.pi)
    peak = G / slenderness
    shape = int(rng.integers(4))
    if shape == 0:
        motion = ricker(peak, frequency)
    elif shape == 1:
        motion = one_sine(peak, frequency)
    elif shape == 2:
        cycles = float(rng.uniform(1.2, 3.0))
        motion = mavroeidis_papageorgiou(peak / (2.0 * math.pi * frequency), frequency, cycles, rng.uniform(0.0, 6.0))
    else:
        motion = Motion.harmonic(peak, frequency, float(rng.integers(2, 9)) / frequency)
    return Case(Column("drawn", tuple(blocks)), motion)


def cases(kind: str, count: int, seed: int = SEED) -> list[Case]:
    """Return `count` cases, `SCALES` of each column that stands at rest and overturns at some scale."""
    rng = np.random.default_rng([seed, KINDS.index(kind)])
    tried: list[Case] = []
    while len(tried) < math.ceil(DRAWN_PER_WANTED * count / SCALES):
        case = drawn(rng, kind)
        if is_stable(case.column):
            tried.append(case)
    low, high = np.full(len(tried), FIRST), np.full(len(tried), math.nan)
    while True:
        scale = np.where(np.isnan(high), GROW * low, 0.5 * (low + high))
        open_ = np.flatnonzero((scale < MOST) & ~(high - low < WIDTH * low))
        if not open_.size:
            break
        runs = [tried[k] for k in open_.tolist()]
        motions = [case.motion.scaled(float(factor)) for case, factor in zip(runs, scale[open_], strict=True)]
        words = simulate_many([case.column for case in runs], motions, keep=("verdict",))["verdict"]
        fell = np.array([word == OVERTURNED for word in words])
        high[open_[fell]], low[open_[~fell]] = scale[open_[fell]], scale[open_[~fell]]
    factors = rng.uniform(1.0 - BAND, 1.0 + BAND, (len(tried), SCALES)) * (0.5 * (low + high))[:, None]
    found = [
        Case(tried[k].column, tried[k].motion.scaled(float(factor)))
        for k in np.flatnonzero(~np.isnan(high)).tolist()
        for factor in factors[k]
    ]
    return found[:count]


def judged(case: Case) -> tuple[str, float, float]:
    """Return the verdict at the default settings; of a column said to stand how far, and when it falls after all.

    How far: the largest slip of a joint since, over what the energy then left would move it by against friction under
    its whole weight. When: s after the motion, NaN if it stands for `LONGER`.
    """
    column, motion = case
    stepper, joints = Stepper(column), [block.joint for block in column.blocks]
    stepper.run(motion, motion.end, np.empty(0))
    verdict = settled_verdict(stepper, motion.end, SETTLE)
    if verdict.word != STANDING:
        return verdict.word, 0.0, math.nan
    chain, phase, crept = chain_of(column), phase_of(stepper), 0.0
    slip, energy = chain.places(phase).slip, chain.energy(phase)
    stepper.rest_until(verdict.time, verdict.time + LONGER)
    if column.slides and energy > 0.0:
        moved = np.abs(chain.places(phase_of(stepper)).slip - slip)
        friction = np.array([joint.friction or 0.0 for joint in joints])
        crept = float(np.max(moved * friction * chain.weight)) / energy
    return verdict.word, crept, stepper.fall_time - motion.end


def measure_kind(kind: str, count: int) -> dict[str, Any]:
    """Count how many columns of a kind are undecided, how many that stand fall later, and how far they creep."""
    found = [judged(case) for case in cases(kind, count)]
    words = Counter(word for word, _, _ in found)
    late = sum(word == STANDING and not math.isnan(fall) for word, _, fall in found)
    crept = max(size for _, size, _ in found)
    return {"kind": kind, "columns": len(found), "words": dict(words), "wrong": late, "crept": crept}


def line_of(row: dict[str, Any]) -> str:
    """Return a kind in a line."""
    words = ", ".join(f"{count} {word}" for word, count in sorted(row["words"].items()))
    share = row["words"].get(UNDECIDED, 0) / row["columns"]
    text = f"{row['columns']} runs {row['kind']}: {words} ({share:.1%} undecided); {row['wrong']} of those that stand "
    text += f"fell within {LONGER:g} s"
    if "in_lanes" in row:
        lanes = ", ".join(f"{count} {word or 'not made'}" for word, count in sorted(row["in_lanes"].items()))
        text += f"; in lanes {lanes}, {row['against']} standing in one and overturned in the other"
        passed_over = ", ".join(f"{count} {name.replace('_', ' ')}" for name, count in row["passed_over"].items())
        return text + f"; {row['failed_later']} longer runs failed; structures passed over: {passed_over}"
    return text + f"; crept by at most {row['crept']:.2g} of energy over friction"


def measure(quick: bool) -> Iterator[dict[str, Any]]:
    """Measure all kinds, one after the other."""
    for kind, count in zip(KINDS, QUICK_COUNTS if quick else COUNTS, strict=True):
        yield measure_kind(kind, count)
