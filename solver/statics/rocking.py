"""Free rocking of a column that is pulled aside and released: the energy kept from one side to the other."""

from __future__ import annotations

import math
from typing import NamedTuple

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
MOST_BLOCKS = 12  # of which the restitution is worked out beside an answer
LONGEST = 100.0  # such times, within which it must turn on the other side


class Part(NamedTuple):
    """The part of a column above a joint, as one rigid body that stands straight."""

    joint: int  # from the top, 1 is the highest
    mass: float  # kg
    half_width: float  # m, from below the centroid to the nearer edge of the joint's contact
    centroid: float  # m, above the joint
    inertia: float  # kg m2, about the edge

    @property
    def slenderness(self) -> float:
        """Half the width over the height of the centroid."""
        return self.half_width / self.centroid


def parts_above(column: Column) -> list[Part]:
    """Return the part above each joint, the top joint first."""
    found: list[Part] = []
    mass = height = inertia = 0.0  # of the part above: its centroid above the joint, inertia about the centroid
    for number, (block, contact) in enumerate(zip(column.blocks, column.contacts, strict=True), start=1):
        both, own, raised = mass + block.mass, block.resolved_centroid, height + block.height
        middle = (mass * raised + block.mass * own) / both
        inertia += block.resolved_inertia + mass * (raised - middle) ** 2 + block.mass * (own - middle) ** 2
        mass, height = both, middle
        half = min(-contact.left, contact.right)
        found.append(Part(number, mass, half, height, inertia + mass * (height**2 + half**2)))
    return found


def rocking_part(column: Column) -> Part:
    """Return the part that the least push sets in motion: a statue rocks on its pedestal."""
    return min(reversed(parts_above(column)), key=lambda part: part.slenderness)


def housner_restitution(column: Column) -> float:
    """Return the rotation rate after over before an impact, of the part that rocks as one rigid block (Housner 1963).

    From angular momentum about the new edge: 1 - 2 m c^2 / I, with c half the width of the joint under the part and I
    the moment of inertia about an edge. Of a homogeneous rectangle that is 1 - 1.5 sin^2(alpha).
    """
    part = rocking_part(column)
    return 1.0 - 2.0 * part.mass * part.half_width**2 / part.inertia


def critical_damping(column: Column) -> float:
    """Return the eta, s, at which the part that rocks is critically damped as it bounces: 2 sqrt(m / (k A))."""
    part = rocking_part(column)
    joint = column.blocks[part.joint - 1].joint
    return 2.0 * math.sqrt(part.mass / column.contacts[part.joint - 1].stiffness(joint.stiffness))


def restitution_sentence(column: Column) -> str:
    """Return the restitution of the model beside that of Housner's block, or why there is none, in a sentence."""
    rigid = f"Housner's rigid block {housner_restitution(column):.3f}"
    if column.n > MOST_BLOCKS:
        return f"Restitution: {rigid}; that of the model is not worked out beyond {MOST_BLOCKS} blocks."
    try:
        own = restitution(column)
    except (InputError, SolverError) as why:
        return f"Restitution: {rigid}; that of the model is not found: {why}."
    dry = " without its mortar" if column.is_brittle else ""
    return f"Restitution (rotation rate after over before an impact, in the plane): the model{dry} {own:.3f}, {rigid}."


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
