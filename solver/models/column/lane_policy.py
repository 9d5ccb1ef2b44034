"""The policy for lanes: whether runs of a column are made in lanes, of which kind, and how they enter them."""

from __future__ import annotations

import math

from ...ground.motion import Motion
from ...kernels.column.sections.faces import ANNULUS, CIRCLE, FRAME, LENS, ON_BAND, ON_RING, RECTANGLE, STRIPS
from ...kernels.engine import dormand_prince
from .model import Column

MOST_BLOCKS = 64  # in lanes; the data of more exceed the cache
TIGHTEST = 1e-7  # tolerance below which single runs with the explicit method of order 8 are as fast
# Explicit steps of a joint damped beyond critical are short: 1 / (0.25 damping frequency^2). Lanes are faster up to
# this number of steps per second at a tolerance of 1e-3; at a tighter one all steps are shorter. Measured (Phocas, eta
# 1e-3 to 5e-2 s): as fast as `simulate` at 5000 steps per second (1e-3) and 15000 (1e-5).
MOST_STEPS = 2500.0  # 1/s
CRITICAL = 2.0  # damping times frequency
# A modal step ends at every sample of a record, and costs as much as six steps in lanes: with more samples per second
# than this, modes are slower, unless explicit steps are short. Measured (the shaft of Phocas in six drums, five records
# of 50 to 200 samples per second): twice as slow, and five times if joints stay closed.
SAMPLES, AT_ONCE = 20.0, 1500.0  # 1/s: samples of a record; explicit steps
IN_LANES = frozenset((RECTANGLE, CIRCLE, ANNULUS, STRIPS, FRAME, LENS))  # sections with kernels for lanes
HELD = "held samples"  # the reason to run alone


def reason_against_lanes(column: Column) -> str:
    """Return the reason against lanes for a column; "" if they are used, unless the motion has HELD samples."""
    settings = column.settings
    if why := common_reason_against_lanes(column):
        return why
    if settings.tolerance < TIGHTEST:
        return "tight tolerance"
    return "stiff joints" if "implicit" not in settings.without and _is_stiff(column) else ""


def common_reason_against_lanes(column: Column) -> str:
    """Return the reason common to all formulations, or ""."""
    if set(column.settings.without) - {"peaks", "implicit"}:
        return "short cuts left out"
    if column.other_law:  # the kernels of lanes have the linear law only
        return f"joint.{column.other_law}"
    if column.is_brittle:
        return "brittle joints"
    if not column.sections.isdisjoint((ON_RING, ON_BAND)):
        return "a round face on a straight one"
    if not column.sections <= IN_LANES:
        return "a section without kernels for lanes"
    return f"more than {MOST_BLOCKS} blocks" if column.n > MOST_BLOCKS else ""


def first_step_of(column: Column) -> float:
    """Return a step (s) of about the length of the explicit ones."""
    return 0.1 / math.sqrt(2.0 * _dampers(column)[1])


def kind_of(column: Column) -> str:
    """Return the kind of lanes for the runs of a column, a name of KINDS."""
    if column.has_rims:
        return "rims, slipping"
    if STRIPS in column.sections:
        return "strips, slipping"
    if column.sections <= {RECTANGLE}:
        return "slipping" if column.has_slips else "plain"
    return "round, slipping" if column.has_slips else "round"


def _is_stiff(column: Column) -> bool:
    """Return True if damping makes explicit steps so short that single implicit runs are as fast."""
    damping, squares = _dampers(column)
    if damping * math.sqrt(2.0 * squares) <= CRITICAL:
        return False
    most: float = MOST_STEPS * (1e-3 / column.settings.tolerance) ** 0.25
    return 0.5 * damping * squares > most


def _dampers(column: Column) -> tuple[float, float]:
    """Return the largest damping (s) and half the square of a bound of the frequencies (1/s2).

    See kernels/column/model/assembly.py.
    """
    squares, above = 0.0, 0.0
    for block, spring in zip(column.blocks, column.springs, strict=True):
        squares, above = max(squares, (spring + above) / block.mass), spring
    return max(block.joint.damping for block in column.blocks), squares


def enters_at_once(column: Column, order: float, motion: Motion, samples: int) -> bool:
    """Return True if a run enters its lane at once, without a first part made by modes.

    `order` is that of its explicit method; `samples` are those that the kernels follow, 0 for a harmonic part alone.
    """
    if order != dormand_prince.ORDER:
        return False
    if samples:
        damping, squares = _dampers(column)
        steps = max(0.3 * math.sqrt(2.0 * squares), 0.5 * damping * squares)
        return samples > SAMPLES * (motion.time[-1] - motion.time[0]) and steps < AT_ONCE
    return abs(motion.amplitude) > _opening_acceleration(column)


def _opening_acceleration(column: Column) -> float:
    """Return the steady base acceleration at which the first joint opens (m/s2)."""
    least, carried, moment = math.inf, 0.0, 0.0  # kg above the joint; kg m of them about it
    for block, contact in zip(column.blocks, column.contacts, strict=True):
        moment += carried * block.height + block.mass * block.resolved_centroid
        carried += block.mass
        kern = contact.second / (0.5 * contact.width * contact.area)  # m, largest eccentricity in full contact
        least = min(least, column.g * carried * kern / moment)
    return least
