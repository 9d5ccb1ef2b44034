"""Whether runs of a column are made in lanes, in which kind of lanes, and how they begin there: policy alone."""

from __future__ import annotations

import math

from ...ground.motion import Motion
from ...kernels.integrators import dormand_prince
from .model import Column

MOST_BLOCKS = 64  # in lanes; the data of more do not fit into the cache
TIGHTEST = 1e-7  # tolerance: below it, single runs with the explicit method of order 8 are no slower
# Explicit steps of a joint damped beyond its critical damping are short: 1 / (0.25 damping frequency^2). Lanes gain
# while there are no more of them than this a second, at a tolerance of 1e-3; at a tighter one all steps are shorter.
# Measured (Phocas, eta 1e-3 to 5e-2 s): as fast as `simulate` at 5000 of them (1e-3) and 15000 (1e-5).
MOST_STEPS = 2500.0  # 1/s
CRITICAL = 2.0  # damping times frequency
# A modal step ends at every sample of a record, and costs as much as six in lanes: with more samples a second than
# this, modes are slower, unless explicit steps are short. Measured (the shaft of Phocas in six drums, five records of
# 50 to 200 samples a second): twice as slow, and five times where joints stay closed.
SAMPLES, AT_ONCE = 20.0, 1500.0  # 1/s: of a record; explicit steps
HELD = "held samples"  # why a run is not made in lanes


def why_not_in_lanes(column: Column) -> str:
    """Why runs of a column are not made in lanes; empty where they are, unless the motion has HELD samples."""
    settings = column.settings
    if why := why_no_lanes(column):
        return why
    if settings.tolerance < TIGHTEST:
        return "tight tolerance"
    if column.has_bands:
        return "a round face on a straight one"
    return "stiff joints" if "implicit" not in settings.without and _is_stiff(column) else ""


def why_no_lanes(column: Column) -> str:
    """What of `why_not_in_lanes` holds for columns of any formulation."""
    if set(column.settings.without) - {"peaks", "implicit"}:
        return "short cuts left out"
    if column.other_law:  # the kernels of lanes have the linear law only
        return f"joint.{column.other_law}"
    if column.is_brittle:
        return "brittle joints"
    return f"more than {MOST_BLOCKS} blocks" if column.n > MOST_BLOCKS else ""


def first_step_of(column: Column) -> float:
    """A step, s, of about the length of the explicit ones."""
    return 0.1 / math.sqrt(2.0 * _dampers(column)[1])


def kind_of(column: Column) -> str:
    """The kind of lanes that makes the runs of a column, a name of KINDS."""
    if column.has_rims:
        return "rims, slipping"
    if column.has_strips:
        return "strips, slipping"
    if column.has_rectangles_only:
        return "slipping" if column.has_slips else "plain"
    return "round, slipping" if column.has_slips else "round"


def _is_stiff(column: Column) -> bool:
    """Whether damping makes explicit steps so short that single implicit runs are no slower."""
    damping, squares = _dampers(column)
    if damping * math.sqrt(2.0 * squares) <= CRITICAL:
        return False
    most: float = MOST_STEPS * (1e-3 / column.settings.tolerance) ** 0.25
    return 0.5 * damping * squares > most


def _dampers(column: Column) -> tuple[float, float]:
    """The largest damping, s, and half the square of a bound of the frequencies, 1/s2 (kernels/column/assembly.py)."""
    squares, above = 0.0, 0.0
    for block, spring in zip(column.blocks, column.springs, strict=True):
        squares, above = max(squares, (spring + above) / block.mass), spring
    return max(block.joint.damping for block in column.blocks), squares


def enters_at_once(column: Column, order: float, motion: Motion, samples: int) -> bool:
    """Whether a run enters its lane at once, without a first part made by modes."""
    if order != dormand_prince.ORDER:
        return False
    if samples:
        damping, squares = _dampers(column)
        steps = max(0.3 * math.sqrt(2.0 * squares), 0.5 * damping * squares)
        return samples > SAMPLES * (motion.time[-1] - motion.time[0]) and steps < AT_ONCE
    return motion.amplitude > _opening_acceleration(column)


def _opening_acceleration(column: Column) -> float:
    """Steady base acceleration, m/s2, at which the first joint opens."""
    least, carried, moment = math.inf, 0.0, 0.0  # kg above the joint; kg m of them about it
    for block, contact in zip(column.blocks, column.contacts, strict=True):
        moment += carried * block.height + block.mass * block.resolved_centroid
        carried += block.mass
        kern = contact.second / (0.5 * contact.width * contact.area)  # m, how far off the middle the load may be
        least = min(least, column.g * carried * kern / moment)
    return least
