"""The solids between two parallel faces of a section: centroid and inertia of blocks, drums and hollow drums."""

import math
from typing import NamedTuple

from ...numba_ext.jit import in_both
from ..sections.faces import RECTANGLE
from ..sections.section import face

# Gauss's rule with three points is exact to the fifth order in the height; integrands here are of at most the fourth
_OFF = 0.5 * math.sqrt(0.6)
POINTS = ((0.5 - _OFF, 5.0 / 18.0), (0.5, 4.0 / 9.0), (0.5 + _OFF, 5.0 / 18.0))


class SolidProperties(NamedTuple):
    """A homogeneous solid of density 1: volume (m3), centroid above the bottom face (m), inertia about it (m5).

    The inertia is that of rotation in the plane of the motion.
    """

    volume: float
    centroid: float
    inertia: float


@in_both
def solid_between(
    section: float,
    height: float,
    width: float,
    depth: float,
    top_width: float = 0.0,
    top_depth: float = 0.0,
    bore: float = 0.0,
) -> SolidProperties:
    """Return the solid between a bottom face and a top face that tapers evenly.

    Parameters
    ----------
    section : float
        Code of the section of both faces.
    height, width, depth : float
        Height of the solid, and width and depth of its bottom face, m.
    top_width, top_depth : float
        Width and depth of the top face, m; 0: those of the bottom face.
    bore : float
        Inner diameter of an annulus, m, constant over the height.

    Returns
    -------
    SolidProperties
        Volume, centroid and inertia.
    """
    # taper of width and depth from bottom to top
    wider = 0.0 if top_width == 0.0 else top_width - width
    deeper = 0.0 if top_depth == 0.0 else top_depth - depth
    volume, first, second = 0.0, 0.0, 0.0
    # integrals over the height by Gauss's rule
    for part, weight in POINTS:
        area, own = face(section, width + part * wider, depth + part * deeper, bore)
        z = part * height
        volume += weight * area
        first += weight * (area * z)
        second += weight * own
    centroid = first / volume
    # inertia of the slices about the centroid
    for part, weight in POINTS:
        area, _ = face(section, width + part * wider, depth + part * deeper, bore)
        off = part * height - centroid
        second += weight * (area * off * off)
    return SolidProperties(height * volume, centroid, height * second)


@in_both
def homogeneous(
    mass: float,
    section: float,
    height: float,
    width: float,
    depth: float,
    top_width: float,
    top_depth: float,
    bore: float,
) -> tuple[float, float]:
    """Return centroid above the bottom face (m) and inertia about it (kg m2) of a homogeneous block.

    The arguments are those of `solid_between`, and the mass in kg.
    """
    # in closed form for a rectangular prism
    if section == RECTANGLE and top_width == 0.0 and top_depth == 0.0:
        return 0.5 * height, mass * (height * height + width * width) / 12.0
    solid = solid_between(section, height, width, depth, top_width, top_depth, bore)
    return solid.centroid, mass / solid.volume * solid.inertia
