"""The bed of a joint that has slid: the intersection of its two faces (theory.md section 13).

Each face moves with its block by half of the slip and twist of the slider.
"""

import math

from ..numba_ext.jit import by_width, leaf
from ..numba_ext.lanes import MaskType, any_of, index_of
from .bed import Bed, Plane, value
from .disc import round_bed
from .placed_face import corners_of_faces
from .shared_disc_in_lanes import round_bed_after_slip
from .shared_polygon import polygon_bed_after_slip


@leaf
def _moved_disc_bed(scene, j, section, p, q):
    """Return the bed of a disc or ring that has slid on an unbounded face, relative to the place half-way."""
    x, y = 0.5 * scene.slips.p1[j], 0.5 * scene.slips.p2[j]
    # p and q about the moved centre
    moved_p = Plane(value(p, x, y), p.along_x, p.along_y)
    moved_q = Plane(value(q, x, y), q.along_x, q.along_y)
    bed = round_bed(section.outer, section.inner, section.area, section.moments, moved_p, moved_q)
    # moments about the place half-way
    return Bed(bed.force, bed.first_x + x * bed.force, bed.first_y + y * bed.force, bed.area, bed.largest)


@by_width
def goes_by_faces(scene, j, slid):
    """Return the mask of where the bed of joint j is that of the intersection of its faces: alone, where it has `slid`.

    In lanes it is wherever the joint may slide, if the faces are polygons: both kinds of lanes would double the cost.
    """
    return _lanes_go_by_faces if isinstance(slid, MaskType) else lambda scene, j, slid: slid


def _lanes_go_by_faces(scene, j, slid):
    # wherever a polygon may slide
    may_slide = scene.joints.friction[j] != math.inf
    if any_of(may_slide):
        a, b, endless = corners_of_faces(scene, index_of(scene.joints.above[j]), index_of(scene.joints.below[j]))
        # polygons, or a polygon on an unbounded face
        if a > 0 and (b > 0 or endless):
            return may_slide
    return slid


@leaf
def bed_after_slip(scene, j, section, slid, p, q):
    """Return the bed of a section of joint j after slips, by the intersection of its faces; slid: mask of where."""
    a, b, endless = corners_of_faces(scene, section.above, section.below)
    # polygons, a disc on an unbounded face, or other round faces
    if a > 0 and (b > 0 or endless):
        return polygon_bed_after_slip(scene, j, section, slid, a + b, p, q)
    if endless:
        return _moved_disc_bed(scene, j, section, p, q)
    return round_bed_after_slip(scene, j, section, slid, p, q)
