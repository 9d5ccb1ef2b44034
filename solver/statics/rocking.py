"""Free rocking of a column that is pulled aside and released: the energy kept from one side to the other."""

from __future__ import annotations

import math

import numpy as np

from ..common.errors import InputError, SolverError, check_number
from ..models.column.kinematics import chain_of
from ..models.column.linearization import undamped
from ..models.column.model import Column
from ..models.column.packing import InitialState
from ..models.column.push import BalanceCurve
from ..models.column.rest import instability, is_stable
from ..models.column.run import phase_of
from ..models.column.stepper import Stepper

RELEASE = 0.5  # of the way to the edge, the default
LOOK = 2e-3  # between two checks of the motion, in parts of the time in which the column falls
LONGEST = 100.0  # such times, within which it must turn on the other side


def housner_restitution(column: Column) -> float:
    """Rotation rate after over before an impact, of the whole column as one rigid block (Housner 1963).

    From angular momentum about the new edge: 1 - 2 m c^2 / I, with c half the width of the lowest joint and I the
    moment of inertia about an edge. Of a homogeneous rectangle that is 1 - 1.5 sin^2(alpha).
    """
    mass, inertia = 0.0, 0.0  # about the base
    below = sum(block.height for block in column.blocks)
    for block in column.blocks:
        below -= block.height
        rise = below + block.resolved_centroid
        mass += block.mass
        inertia += block.resolved_inertia + block.mass * rise * rise
    half = 0.5 * column.contacts[-1].width
    return 1.0 - 2.0 * mass * half * half / (inertia + mass * half * half)


def restitution(column: Column, release: float = RELEASE) -> float:
    """Square root of the part of its energy that a column keeps from the release to the turn on the other side.

    For a rigid block it is the rotation rate after over before the impact. The column is pulled aside as on its
    capacity curve (capacity.py) and released on a still base. release: the place, in parts of the displacement of the
    top from which it falls; from 0.02 to 0.95.

    Raises InputError for another `release` or without gravity, SolverError if the column is not stable or falls.
    """
    start, top = pulled_aside(column, release)
    return restitution_from(column, start, top)


def pulled_aside(column: Column, release: float = RELEASE) -> tuple[InitialState, float]:
    """A place of balance beyond the largest push, and its top displacement m. Raises as `restitution` does."""
    release = check_number("release", release, (0.02, 0.95), "a part of the displacement to the edge, 0.02 to 0.95")
    column = column.with_settings(formulation="exact")
    if column.g > 0.0 and not is_stable(column):
        raise SolverError(instability(column))
    curve = BalanceCurve(undamped(column))
    places = curve.follow()
    n = column.n
    tops = np.array([curve.still.row(place.q).joints.ux[0] for place in places])
    k = int(np.argmin(np.abs(tops - release * tops[-1])))
    if places[k].along[-1] > 0.0:
        at_most = tops[np.argmax([place.push for place in places])] / tops[-1]
        raise InputError(
            f"release = {release:g}: must be more than {at_most:.2g}, beyond the largest push: below, the column sways"
        )
    return InitialState(rotation=places[k].q[:n], opening=places[k].q[n:]), float(tops[k])


def restitution_from(column: Column, start: InitialState, top: float) -> float:
    """`restitution` from a place that `pulled_aside` has found. Raises SolverError."""
    column = column.with_settings(formulation="exact", integrator="auto")
    chain, stepper = chain_of(column), Stepper(column, start)
    falling = math.sqrt(float(np.sum(chain.height)) / column.g)  # s
    before, t, farthest = chain.energy(phase_of(stepper)), 0.0, 0.0
    while t < LONGEST * falling:
        stepper.advance(t, LOOK * falling)
        t += LOOK * falling
        if stepper.overturned_joint:
            raise SolverError(f"released at {top:.3g} m the column falls")
        beyond = -math.copysign(1.0, top) * float(chain.top_displacements(phase_of(stepper))[0])
        if 0.0 < beyond < farthest:
            return math.sqrt(max(0.0, chain.energy(phase_of(stepper))) / before)
        farthest = beyond
    raise SolverError(f"released at {top:.3g} m the column does not reach the other side")
