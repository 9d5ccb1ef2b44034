"""The section of a joint, and the inside that its rim leaves open (theory.md section 13).

Two faces that touch in a rim along their edges share (A and B) less (A_i and B_i); the insides are inset by the rim. So
the bed of such a joint is that of its outline less that of its inside.
"""

from typing import Any, NamedTuple

from ..numba_ext.jit import leaf
from ..numba_ext.lanes import any_of, index_of, zero_like
from .bed import Moments
from .layout import INSIDE, POLYGON

_inside, _INSIDE = INSIDE.over, INSIDE.beside


class Section(NamedTuple):
    """A plane figure about the centre of a joint."""

    is_polygon: bool
    corners: Any  # row, of a polygon
    corners_count: int
    area: Any  # m2
    moments: Moments
    outer: Any  # m, radii of a disc or ring
    inner: Any
    above: int  # indices of the faces of the upper and lower body, if the joint may slide
    below: int


@leaf
def has_inside(scene, j):
    """Return True, or the mask of lanes, where joint j bears in a rim only."""
    return scene.joints.inside[j] != 0.0


@leaf
def bearing_area(scene, j):
    """Return the area (m2) and the moments about its centroid of the part of joint j that bears."""
    joints, zero = scene.joints, zero_like(scene.joints.area[j])
    return joints.area[j], Moments(zero, zero, joints.ixx[j], joints.ixy[j], joints.iyy[j])


@leaf
def outline_of(scene, j):
    """Return the outline of the section of joint j, the inside of a rim included."""
    joints = scene.joints
    area, moments = bearing_area(scene, j)
    rims = has_inside(scene, j)
    if any_of(rims):
        # add what the rim leaves open
        inside = _inside(scene.corners[index_of(joints.inside[j]) - 1 :], 0)
        area = area + inside.area
        moments = Moments(inside.x, inside.y, moments.xx + inside.ixx, moments.xy + inside.ixy, moments.yy + inside.iyy)
    # places of its corners and of its faces
    return Section(
        any_of(joints.section[j] == POLYGON),
        scene.corners[2 * index_of(joints.first[j]) :],
        index_of(joints.corners[j]),
        area,
        moments,
        joints.outer[j],
        joints.inner[j],
        index_of(joints.above[j]),
        index_of(joints.below[j]),
    )


@leaf
def inside_of(scene, j):
    """Return the inside of joint j, which bears in a rim."""
    # its record, with the corners behind it
    row = scene.corners[index_of(scene.joints.inside[j]) - 1 :]
    inside = _inside(row, 0)
    return Section(
        any_of(inside.section == POLYGON),
        row[_INSIDE:],
        index_of(inside.corners),
        inside.area,
        Moments(inside.x, inside.y, inside.ixx, inside.ixy, inside.iyy),
        inside.outer,
        inside.inner,
        index_of(inside.above),
        index_of(inside.below),
    )
