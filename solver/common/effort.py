"""How much work a run may take, in counts rather than seconds, and which of its numbers makes it so slow.

A run that would take days ends within seconds or minutes: at its last evaluation that is allowed, or as soon as its
pace leaves no hope that these suffice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

# evaluations of a run of a column and of a structure, which take some minutes of a few blocks. Runs of the examples,
# benchmarks and validation take 1e4 to 1e7 (a tolerance of 1e-11)
MOST, MOST_IN_SPACE = 2e8, 5e7
LEAST_RATE = 1e-300  # 1/s
EARLY = 1e6  # evaluations from which its pace is looked at
HOPELESS = 20.0  # times the most: what a run may need, at its pace so far, when the most is done; before it, more, as
# steps of a run that begins without motion are short at first
MOST_FIRST_STEPS = 1e8  # in the duration of a run in lanes, which watch nothing of this


class Cause(NamedTuple):
    """A number that steps have to follow: 1/s, and what it is, for a message."""

    rate: float
    words: str


def is_too_much(work: float, part: float, most: float) -> bool:
    """Whether a run has taken more than `most` evaluations, or will have; part: of its time that is done."""
    return work > most or (work > EARLY and work * (work / most) > HOPELESS * most * part)


def too_many_steps(duration: float, first_step: float, omega: float) -> bool:
    """Whether a run is too long for lanes; first_step: s, of the model; omega: rad/s, of a harmonic base motion."""
    return duration * max(1.0 / first_step, omega) > MOST_FIRST_STEPS


def of_dashpot(key: str, damping: float, unit: str, rate: float) -> Cause:
    """Return the cause of short steps by a damper; rate: 1/s, at which the lighter of its bodies is stopped."""
    return Cause(rate, f"{key} = {damping:g} {unit}, which stops a block within {1.0 / max(rate, LEAST_RATE):.3g} s")


def of_joint(key: str, stiffness: float, area: float, mass: float, damping: float) -> Cause:
    """Of a joint: its oscillation with the lighter of its blocks, kg, and how fast that dies out."""
    omega = math.sqrt(2.0 * stiffness * area / mass)
    law = f"stiffness = {stiffness:g} N/m3, damping = {damping:g} s"
    words = f"{key}: {law}, {omega / (2.0 * math.pi):.3g} Hz on {area:.3g} m2 with {mass:.3g} kg"
    return Cause(max(omega, 0.5 * damping * omega * omega), words)


def of_harmonic(frequency: float) -> Cause:
    """Of a harmonic base motion, Hz."""
    return Cause(2.0 * math.pi * frequency, f"the base motion's frequency = {frequency:g} Hz")


def slowness(work: float, part: float, causes: Iterable[Cause]) -> str:
    """Why a run of too much work was given up, in one line."""
    return f"{work:.3g} evaluations for {part:.2g} of the run, too slow to go on: the fastest is {_fastest(causes)}"


def too_much(needed: float, most: float, causes: Iterable[Cause]) -> str:
    """Return why a run is not begun, in one line."""
    return f"it needs {needed:.3g} evaluations, more than {most:g}: the fastest is {_fastest(causes)}"


def _fastest(causes: Iterable[Cause]) -> str:
    return max(causes, key=lambda cause: cause.rate).words
