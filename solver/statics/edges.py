"""The impact of a block on its edge: the area that bears there, and the damping that is critical on it."""

from __future__ import annotations

import math

from ..common.errors import POSITIVE, check_number
from ..kernels.column.sections.faces import is_round
from ..models.column.block import Block
from ..models.column.contact import Contact
from ..models.column.model import Column
from .rocking import rocking_part


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
