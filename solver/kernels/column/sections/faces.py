"""The two faces of a joint as built, and their intersection: plain Python, and leaves of kernels.

A contact is the contact face of the block above cut by the top face of the block below, their middles over each other.
"""

import math
from typing import NamedTuple

from ...numba_ext.jit import in_both

# names in input files; the code of a section is its index
SECTIONS = ("rectangle", "circle", "annulus", "strips")
RECTANGLE, CIRCLE, ANNULUS, STRIPS = range(len(SECTIONS))
FRAME = -1  # a rectangle that touches in a rim
UNKNOWN = -2  # faces whose intersection `common` does not know
# other intersections of two faces: two round ones of which one has slipped; a straight one, which may be made of
# strips, over a round one; a round one over a straight one
LENS, ON_RING, ON_BAND = range(len(SECTIONS), len(SECTIONS) + 3)

ENDLESS = 2e300  # m, width and depth of the base
ALIKE = 1.0 + 1e-9  # relative tolerance of lengths: rounding

# kinds of misfits
FITS, WIDE, DEEP, WIDE_OWN, OUTSIDE_OWN, OUTSIDE_BELOW, SOLID, SOLID_BELOW, STRIP_OWN, STRIP_BELOW = range(10)
WITHIN, AROUND = 10, 11  # one face within the bore of the other: no contact


class FaceShape(NamedTuple):
    """A face: code of its section, width, depth and bore (m); a round one is as deep as it is wide."""

    section: float
    width: float
    depth: float
    bore: float


class Misfit(NamedTuple):
    """The reason why a contact face is refused.

    Attributes
    ----------
    kind : int
        Code of the misfit, FITS if there is none.
    strip : int
        Index of the strip, -1 without strips.
    value : float
        Length that is refused, m.
    bound : float
        Bound that it breaks, m.
    """

    kind: int
    strip: int
    value: float
    bound: float


@in_both
def is_round(section: float) -> bool:
    """Return True if a section is a circle or an annulus."""
    return section in (CIRCLE, ANNULUS)


@in_both
def is_known(section: float) -> bool:
    """Return True if a section is round or straight: the shapes whose intersections and insides are known."""
    return is_round(section) or section in (RECTANGLE, STRIPS)


@in_both
def face_of(section: float, width: float, depth: float, bore: float) -> FaceShape:
    """Return a face; the depth is ignored where it is round, the bore where it is not an annulus. Lengths in m."""
    return FaceShape(section, width, width if is_round(section) else depth, bore if section == ANNULUS else 0.0)


@in_both
def across(face: FaceShape) -> float:
    """Return the largest distance (m) between two points of a face."""
    return face.width if is_round(face.section) else math.hypot(face.width, face.depth)


@in_both
def lies_within(face: FaceShape, other: FaceShape) -> bool:
    """Return True if a face lies within another one."""
    if is_round(other.section):
        return across(face) <= other.width and face.bore >= other.bore
    return face.width <= other.width and face.depth <= other.depth


@in_both
def common(own: FaceShape, below: FaceShape) -> FaceShape:
    """Return the intersection of two faces that are not made of strips.

    Its section is ON_RING or ON_BAND where it is none of SECTIONS: then width and depth are upper bounds, in m. It is
    UNKNOWN where a face is neither round nor straight.
    """
    # rectangle common to both outlines
    width, depth = min(own.width, below.width), min(own.depth, below.depth)
    if not (is_known(own.section) and is_known(below.section)):
        return FaceShape(float(UNKNOWN), width, depth, 0.0)
    # both round, then both straight
    if is_round(own.section) and is_round(below.section):
        bore = max(own.bore, below.bore)
        return FaceShape(float(ANNULUS if bore > 0.0 else CIRCLE), width, width, bore)
    if not is_round(own.section) and not is_round(below.section):
        return FaceShape(float(RECTANGLE), width, depth, 0.0)
    # one round and one straight: the inner one, or a shape of its own
    if lies_within(own, below):
        return own
    if lies_within(below, own):
        return below
    return FaceShape(float(ON_BAND if is_round(own.section) else ON_RING), width, depth, 0.0)


@in_both
def after_a_slip(own: FaceShape, below: FaceShape, section: float) -> float:
    """Return the section of the contact after a slip, from that without a slip (section)."""
    # over a round face
    if is_round(below.section):
        return float(LENS if is_round(own.section) else ON_RING)
    # a round face on a straight one, which may bound it after a slip
    if is_round(own.section) and (section == ON_BAND or own.depth > below.depth):
        return float(ON_BAND)
    return own.section


@in_both
def has_inside(face: FaceShape, rim: float) -> bool:
    """Return True if some of a face is farther than the rim (m) from all of its edges."""
    if is_round(face.section):
        return face.width - face.bore > (4.0 if face.bore > 0.0 else 2.0) * rim
    return min(face.width, face.depth) > 2.0 * rim


@in_both
def deepest(face: FaceShape, begin: float, end: float) -> float:
    """Return the largest depth (m) of a face between two abscissas, m from its middle, without its bore."""
    # distances of the interval from the middle
    near = max(0.0, begin, -end)
    far = max(-begin, end)
    if not is_round(face.section):
        return face.depth if near < 0.5 * face.width else 0.0
    # chord of the circle less that of its bore
    outer, inner = 0.5 * face.width, 0.5 * face.bore
    place = min(max(inner, near), far)  # the abscissa of the largest depth beside the bore
    if place >= outer:
        return 0.0
    hollow = math.sqrt(inner * inner - place * place) if place < inner else 0.0
    return 2.0 * (math.sqrt((outer - place) * (outer + place)) - hollow)


@in_both
def misfit(
    own: FaceShape, bottom: FaceShape, below: FaceShape, is_wide: bool, is_deep: bool, count: int, depths
) -> Misfit:  # type: ignore[no-untyped-def]
    """Return why a contact face does not fit between the bottom face of its block and the face below (FITS if it does).

    Parameters
    ----------
    own, bottom, below : FaceShape
        The contact face, the bottom face of its block and the top face below.
    is_wide, is_deep : bool
        Whether width and depth of the contact face are given; one that is not given ends with the face below.
    count : int
        Number of strips of the contact face.
    depths : sequence of float
        Depths of the strips, m.
    """
    if own.section == STRIPS:
        found: Misfit = _misfit_of_strips(own, bottom, below, count, depths)
        return found
    # against the face below
    width = below.width if not is_round(own.section) else min(below.width, below.depth)
    if is_wide and own.width > width * ALIKE:
        return Misfit(WIDE, -1, own.width, width)
    # a round face in its block, and its bore in those of both faces
    if is_round(own.section):
        if own.width > bottom.depth * ALIKE:
            return Misfit(WIDE_OWN, -1, own.width, bottom.depth)
        if own.bore * ALIKE < bottom.bore:
            return Misfit(SOLID, -1, own.bore, bottom.bore)
        if own.section == ANNULUS and own.bore != bottom.bore and own.bore * ALIKE < below.bore:
            return Misfit(SOLID_BELOW, -1, own.bore, below.bore)
    else:
        # a straight face in the face below and in its block
        if is_deep and own.depth > below.depth * ALIKE:
            return Misfit(DEEP, -1, own.depth, below.depth)
        if bottom.bore > 0.0:
            return Misfit(SOLID, -1, 0.0, bottom.bore)
        if is_round(bottom.section) and across(own) > bottom.width * ALIKE:
            return Misfit(OUTSIDE_OWN, -1, across(own), bottom.width)
        if is_wide and is_deep and is_round(below.section) and across(own) > below.width * ALIKE:
            return Misfit(OUTSIDE_BELOW, -1, across(own), below.width)
    # one face within the bore of the other: nothing touches
    if across(own) <= below.bore:
        return Misfit(WITHIN, -1, across(own), below.bore)
    if across(below) <= own.bore:
        return Misfit(AROUND, -1, own.bore, across(below))
    return Misfit(FITS, -1, 0.0, 0.0)


@in_both
def _misfit_of_strips(own: FaceShape, bottom: FaceShape, below: FaceShape, count: int, depths) -> Misfit:  # type: ignore[no-untyped-def]
    """Return the misfit of strips: none may be deeper than the greatest depth of either face along it."""
    reach, pitch = 0.0, own.width / max(count, 1)
    for k in range(count):
        depth = depths[k]
        if depth > 0.0:
            # largest depth of each face over the strip
            begin, end = pitch * (k - 0.5 * count), pitch * (k + 1 - 0.5 * count)
            most = deepest(bottom, begin, end)
            if depth > most * ALIKE:
                return Misfit(STRIP_OWN, k, depth, most)
            most = deepest(below, begin, end)
            if depth > most * ALIKE:
                return Misfit(STRIP_BELOW, k, depth, most)
            reach = max(reach, 2.0 * math.hypot(max(-begin, end), 0.5 * depth))
    # all strips within the bore: nothing touches
    if reach <= below.bore:
        return Misfit(WITHIN, -1, reach, below.bore)
    return Misfit(FITS, -1, 0.0, 0.0)
