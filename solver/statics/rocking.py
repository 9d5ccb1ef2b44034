"""Free rocking of a column: the energy kept by an impact, the area that bears then, and the damping critical on it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..common.errors import POSITIVE, InputError, SolverError, check_number, check_type
from ..kernels.column.sections.faces import is_round
from ..models.column.block import Block
from ..models.column.contact import Contact, contacts_of
from ..models.column.kinematics import chain_of
from ..models.column.linearization import undamped
from ..models.column.model import Column
from ..models.column.packing import InitialState
from ..models.column.push import BalanceCurve
from ..models.column.rest import instability, is_stable
from ..models.column.run import phase_of
from ..models.column.stepper import Stepper

RELEASE = 0.5  # default displacement at the release, over that on the edge
LOOK = 2e-3  # time between two checks of the motion, over the time in which the column falls
MOST_BLOCKS = 12  # largest number of blocks for which an answer includes the restitution
LONGEST = 100.0  # longest simulated time, over that in which the column falls


class RigidPart(NamedTuple):
    """The part of a column above a joint as built, as one rigid body on the edge about which it turns first."""

    joint: int  # from the top, 1 is the highest
    mass: float  # kg
    half_width: float  # m, horizontally from the edge of the joint's contact to the centroid
    centroid: float  # m, above the edge
    inertia: float  # kg m2, about the edge
    # root of the energy that an impact keeps, by angular momentum about the new edge, from either edge to the other; on
    # the axis it is Housner's ratio of the rotation rates
    restitution: float

    @property
    def slenderness(self) -> float:
        """Half the width over the height of the centroid."""
        return self.half_width / self.centroid


def parts_above(column: Column) -> list[RigidPart]:
    """Return the part above each joint, the top joint first."""
    found: list[RigidPart] = []
    mass = inertia = 0.0  # of the part above: inertia about the centroid
    x = z = 0.0  # of its centroid, from the middle of the bottom face of its lowest block
    slipped, slope = 0.0, 0.0  # of the joint under it: offset and inclination
    for number, (block, (left, right)) in enumerate(zip(column.blocks, _edges(column), strict=True), start=1):
        lean = block.joint.inclination or 0.0
        turned, own = lean + (block.tilt or 0.0), block.resolved_centroid
        x += slipped * math.cos(slope) + block.height * math.sin(turned)
        z += block.height * math.cos(turned) - slipped * math.sin(slope)
        # centroid of both
        own_x, own_z, both = own * math.sin(turned), own * math.cos(turned), mass + block.mass
        middle_x, middle_z = ((mass * a + block.mass * b) / both for a, b in ((x, own_x), (z, own_z)))
        inertia += block.resolved_inertia
        inertia += mass * ((x - middle_x) ** 2 + (z - middle_z) ** 2)
        inertia += block.mass * ((own_x - middle_x) ** 2 + (own_z - middle_z) ** 2)
        mass, x, z, slipped, slope = both, middle_x, middle_z, block.joint.offset or 0.0, lean
        # inwards from each edge, and up
        arms = [
            (way * (x - edge * math.cos(lean)), z + edge * math.sin(lean)) for way, edge in ((1, left), (-1, right))
        ]
        found.append(_part_on_edges(number, mass, inertia, arms))
    return found


def _part_on_edges(number: int, mass: float, inertia: float, arms: list[tuple[float, float]]) -> RigidPart:
    """Return the part above a joint, from the places of its centroid inwards from each of the two edges and above it.

    `inertia` is about the centroid.
    """
    (half, height), (other, above) = sorted(arms, key=lambda arm: arm[0] / arm[1])
    near, far = inertia + mass * (height**2 + half**2), inertia + mass * (above**2 + other**2)
    kept = (inertia + mass * (height * above - half * other)) / math.sqrt(near * far)
    return RigidPart(number, mass, half, height, near, kept)


def _edges(column: Column) -> list[tuple[float, float]]:
    """Return the ends of the contact under each block as built (m), from the middle of its bottom face."""
    found = []
    for block, below in zip(column.blocks, (*column.blocks[1:], None), strict=True):
        (own,), middle = contacts_of((block,)), -(block.joint.offset or 0.0)
        half = math.inf if below is None else 0.5 * below.top_face.width
        found.append((max(own.left, middle - half), min(own.right, middle + half)))
    return found


def rocking_part(column: Column) -> RigidPart:
    """Return the part that the least push sets in motion; for a statue on a pedestal this is the statue."""
    check_type("column", column, Column)
    return min(reversed(parts_above(column)), key=lambda part: part.slenderness)


def housner_restitution(column: Column) -> float:
    """Return the ratio of the rotation rates after and before an impact of Housner's rigid block (1963).

    The block is the part that rocks: 1 - 2 m c^2 / I, with c half the width of the joint under the part and I its
    moment of inertia about an edge. For a homogeneous rectangle this is 1 - 1.5 sin^2(alpha). Off the axis it is the
    geometric mean of the ratios of both impacts, the root of the energy that each keeps.
    """
    return rocking_part(column).restitution


def critical_damping(column: Column) -> float:
    """Return the eta (s) at which the rocking part is critically damped as it bounces: 2 sqrt(m / (k A))."""
    part = rocking_part(column)
    joint = column.blocks[part.joint - 1].joint
    return 2.0 * math.sqrt(part.mass / column.contacts[part.joint - 1].stiffness(joint.stiffness))


def restitution_sentence(column: Column) -> str:
    """Return the sentence that compares the restitution of the model with Housner's, or says why it is missing."""
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
    """Return the square root of the part of its energy that a column keeps from release to the turn.

    For a rigid block this is the ratio of the rotation rates after and before the impact. The column is pulled aside as
    on its capacity curve (capacity.py), released on a still base, and turns on the other side.

    Parameters
    ----------
    column : Column
        The column.
    release : float
        Displacement of the top at the release over that beyond which it falls, 0.02 to 0.95.

    Raises
    ------
    InputError
        If `release` is out of range or below the largest push, or there is no gravity.
    SolverError
        If the column is not stable or falls.
    """
    start, top = pulled_equilibrium(column, release)
    return restitution_from(column, start, top)


def pulled_equilibrium(column: Column, release: float = RELEASE) -> tuple[InitialState, float]:
    """Return an equilibrium beyond the largest push, and its top displacement (m).

    `release` and errors are those of `restitution`.
    """
    check_type("column", column, Column)
    release = check_number("release", release, (0.02, 0.95), "a part of the displacement to the edge, 0.02 to 0.95")
    column = column.with_settings(formulation="exact")
    if column.g > 0.0 and not is_stable(column):
        raise SolverError(instability(column))
    # the equilibrium of the curve that is nearest to the wanted displacement
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
    """Return the restitution of a column that is released from a state of `pulled_equilibrium`, its top at `top` (m).

    Raises SolverError if the column falls or does not reach the other side.
    """
    column = column.with_settings(formulation="exact", integrator="auto")
    chain, stepper = chain_of(column), Stepper(column, start)
    falling = math.sqrt(float(np.sum(chain.height)) / column.g)  # s
    before, t, farthest = chain.energy(phase_of(stepper)), 0.0, 0.0
    # follow the motion until the top turns back on the other side
    while t < LONGEST * falling:
        stepper.advance(t, LOOK * falling)
        t += LOOK * falling
        if stepper.fallen:
            raise SolverError(f"released at {top:.3g} m the column falls")
        beyond = -math.copysign(1.0, top) * float(chain.top_displacements(phase_of(stepper))[0])
        if 0.0 < beyond < farthest:
            return math.sqrt(max(0.0, chain.energy(phase_of(stepper))) / before)
        farthest = beyond
    raise SolverError(f"released at {top:.3g} m the column does not reach the other side")


# --- impact on an edge


def damping_on_edge(stiffness: float, area: float, mass: float, inertia: float, half_width: float) -> float:
    """Return the eta (s) that is critical for a block that stands on the band along one of its edges.

    There the block moves up and down with the frequency omega^2 = k A (1 / m + b^2 / I), and eta = 2 / omega.

    Parameters
    ----------
    stiffness : float
        Winkler modulus of the joint, k (N/m3).
    area : float
        Area of the band along the edge, A (m2): rim times depth; half of the face if all of it touches.
    mass : float
        Mass of the block, m (kg).
    inertia : float
        Moment of inertia of the block about its centroid, I (kg m2).
    half_width : float
        Horizontal distance of the edge from the centroid, b (m).

    Raises
    ------
    InputError
        If a value is not positive.
    """
    k = check_number("stiffness", stiffness, POSITIVE, "a positive modulus in N/m3")
    bears = check_number("area", area, POSITIVE, "a positive area in m2")
    m = check_number("mass", mass, POSITIVE, "a positive mass in kg")
    about = check_number("inertia", inertia, POSITIVE, "a positive moment of inertia in kg m2")
    b = check_number("half_width", half_width, POSITIVE, "a positive length in m")
    return 2.0 / math.sqrt(k * bears * (1.0 / m + b * b / about))


def column_damping_on_edge(column: Column) -> float:
    """Return the eta (s) that is critical for the rocking part of a column on its edge."""
    part = rocking_part(column)
    k = part.joint - 1
    block, contact = column.blocks[k], column.contacts[k]
    inertia = part.inertia - part.mass * (part.centroid**2 + part.half_width**2)
    return damping_on_edge(block.joint.stiffness, area_on_edge(block, contact), part.mass, inertia, part.half_width)


def area_on_edge(block: Block, contact: Contact) -> float:
    """Return the area (m2) of the band along the edge about which a block rocks.

    Without a rim it is half of the contact. A band along an arc is the segment whose height is the width of the rim.
    """
    half = 0.5 * contact.width
    if not 0.0 < contact.rim < half:
        return 0.5 * contact.area
    face = block.contact_face
    if not is_round(face.section) or face.width > contact.width * (1.0 + 1e-9):  # ends at a straight edge
        return contact.rim * contact.depth
    inner = 0.5 * contact.bore
    return _segment(half, contact.rim) - _segment(inner, contact.rim - (half - inner))


def _segment(radius: float, height: float) -> float:
    """Return the area of a segment of a disc (m2); 0 for a height (m) that is not positive."""
    if height <= 0.0:
        return 0.0
    beyond = radius - height
    return radius**2 * math.acos(beyond / radius) - beyond * math.sqrt(radius**2 - beyond**2)
