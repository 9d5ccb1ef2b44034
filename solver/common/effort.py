"""Limits on the work of a run, counted in evaluations, and the causes of short steps.

A run that would take days ends within seconds or minutes: at the maximum number of evaluations, or as soon as its
progress shows that this number cannot suffice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

# maximum evaluations of a run of a column and of a structure: some minutes for a few blocks. Runs of the examples,
# benchmarks and validation take 1e4 to 1e7 (a tolerance of 1e-11)
MOST, MOST_IN_SPACE = 2e8, 5e7
LEAST_RATE = 1e-300  # 1/s
EARLY = 1e6  # evaluations before which the rate of progress is not checked
HOPELESS = 20.0  # times the maximum. A run ends early if its extrapolated work exceeds this multiple once the maximum
# is done; before, the multiple is larger, as a run that begins without motion takes short steps at first
MOST_FIRST_STEPS = 1e8  # steps in the duration of a run in lanes, which do not count evaluations


class Cause(NamedTuple):
    """A quantity that limits the step."""

    rate: float  # 1/s, which steps have to follow
    words: str  # the description for a message


def is_too_much(work: float, part: float, most: float) -> bool:
    """Return True if a run exceeds its maximum number of evaluations, or its extrapolated work does by far.

    Parameters
    ----------
    work : float
        The evaluations so far.
    part : float
        The fraction of the duration that is done.
    most : float
        The maximum number of evaluations.
    """
    return work > most or (work > EARLY and work * (work / most) > HOPELESS * most * part)


def too_many_steps(duration: float, first_step: float, omega: float) -> bool:
    """Return True if a run has too many steps for lanes.

    Parameters
    ----------
    duration : float
        The duration of the run (s).
    first_step : float
        The first step of the model (s).
    omega : float
        The angular frequency of a harmonic base motion (rad/s), 0 without one.
    """
    return duration * max(1.0 / first_step, omega) > MOST_FIRST_STEPS


def of_dashpot(key: str, damping: float, unit: str, rate: float) -> Cause:
    """Describe a dashpot as a cause of short steps.

    Parameters
    ----------
    key : str
        The key of the damping in the model's file.
    damping : float
        The damping, in `unit`.
    unit : str
        The unit for the message.
    rate : float
        The decay rate of the lighter of the two bodies (1/s).
    """
    return Cause(rate, f"{key} = {damping:g} {unit}, which stops a block within {1.0 / max(rate, LEAST_RATE):.3g} s")


def of_joint(key: str, stiffness: float, area: float, mass: float, damping: float) -> Cause:
    """Describe a joint as a cause of short steps: by the oscillation of its lighter block, or the decay rate.

    Parameters
    ----------
    key : str
        The key of the joint in the model's file.
    stiffness : float
        The Winkler modulus (N/m3).
    area : float
        The contact area (m2).
    mass : float
        The mass of the lighter block (kg).
    damping : float
        The damping (s).
    """
    omega = math.sqrt(2.0 * stiffness * area / mass)
    law = f"stiffness = {stiffness:g} N/m3, damping = {damping:g} s"
    words = f"{key}: {law}, {omega / (2.0 * math.pi):.3g} Hz on {area:.3g} m2 with {mass:.3g} kg"
    return Cause(max(omega, 0.5 * damping * omega * omega), words)


def of_harmonic(frequency: float) -> Cause:
    """Describe a harmonic base motion of this frequency (Hz) as a cause of short steps."""
    return Cause(2.0 * math.pi * frequency, f"the base motion's frequency = {frequency:g} Hz")


def slowness(work: float, part: float, causes: Iterable[Cause]) -> str:
    """Return the message of a run that is aborted as too slow, after the fraction `part` of its duration."""
    return f"{work:.3g} evaluations for {part:.2g} of the run, too slow to go on: the fastest is {_fastest(causes)}"


def work_message(needed: float, most: float, causes: Iterable[Cause]) -> str:
    """Return the message of a run that is refused because it needs too many evaluations."""
    return f"it needs {needed:.3g} evaluations, more than {most:g}: the fastest is {_fastest(causes)}"


def _fastest(causes: Iterable[Cause]) -> str:
    return max(causes, key=lambda cause: cause.rate).words
