"""The shear force that the pressure on a tilted joint exerts along it (theory.md section 13).

The pressure acts along the normal of the face on which an edge of the other one slides, half of the tilt away from that
of the joint. So a slip changes the elastic energy of the bed through the edges of the contact: its negative derivative
is a force along the joint, which friction does not bear.
"""

import math

from ..numba_ext.jit import by_width, leaf
from ..numba_ext.lanes import (
    WIDTH,
    LanesType,
    any_of,
    bits,
    greater,
    index_of,
    lane,
    lesser,
    magnitude,
    where,
    with_lane,
    zero_like,
)
from .bed import plane_of_lane
from .layout import FACE, POINT
from .placed_face import corners_of_faces, rows_of_lane
from .section import has_inside, inside_of, outline_of
from .shared_disc import disc_edges_of_lower
from .shared_polygon import polygon_edges_of_lower

_face = FACE.over


@by_width
def _disc_edges(scene, j, section, those, p, way):
    """Return `disc_edges_of_lower` of a section of joint j; in lanes one lane of the mask after the other."""
    return _disc_edges_of_lanes if isinstance(p.types[0], LanesType) else _disc_edges_of_one


def _disc_edges_of_one(scene, j, section, those, p, way):
    return disc_edges_of_lower(scene.room, scene.corners, scene.slips, j, section.above, section.below, p, way)


def _disc_edges_of_lanes(scene, j, section, those, p, way):
    along_x, along_y, moment = zero_like(p.at), zero_like(p.at), zero_like(p.at)
    which = bits(those)
    for k in range(WIDTH):
        if (which >> k) & 1:
            # direction, faces and pressure of this lane
            one_way = lane(way[0], k), lane(way[1], k), lane(way[2], k)
            faces = section.above, section.below
            one = disc_edges_of_lower(*rows_of_lane(scene, k), j, *faces, plane_of_lane(p, k), one_way)
            along_x, along_y = with_lane(along_x, k, one[0]), with_lane(along_y, k, one[1])
            moment = with_lane(moment, k, one[2])
    return along_x, along_y, moment


@leaf
def _edges_of_lower(scene, j, section, those, p, way):
    """Integrate p^2 n along the edges of the lower face that bound the intersection of both faces of a section."""
    a, b, _ = corners_of_faces(scene, section.above, section.below)
    if a > 0 and b > 0:
        return polygon_edges_of_lower(scene, j, section, those, a + b, p, way)
    return _disc_edges(scene, j, section, those, p, way)


@leaf
def bound_of_pressure_shear(scene, j, p, normal):
    """Return upper bounds of the shear of the pressure, N, and of its moment, N m, by the longest edges of the contact.

    normal: N. Both bounds are 0 where the lower face has no edges.
    """
    slips, zero = scene.slips, zero_like(p.at)
    # bearings, and lower faces without edges, exert none
    if any_of(scene.joints.section[j] == POINT):
        return zero, zero
    above = _face(scene.corners[index_of(scene.joints.above[j]) :], 0)
    below = _face(scene.corners[index_of(scene.joints.below[j]) :], 0)
    if any_of(below.outer == math.inf):
        return zero, zero
    # deepest penetration within reach of the smaller face
    radius, steep = lesser(above.outer, below.outer), magnitude(p.along_x) + magnitude(p.along_y)
    lever = radius + magnitude(slips.p1[j]) + magnitude(slips.p2[j]) + magnitude(above.x) + magnitude(above.y)
    deepest = greater(p.at + steep * lever, 0.0)
    edges = where(has_inside(scene, j), 2.0 * math.pi, math.pi)  # including those of the inside
    # by the tilt of the normal force, and by the edges
    force = 0.5 * steep * normal + edges * scene.joints.stiffness[j] * radius * deepest * deepest
    return force, 2.0 * lever * force


@leaf
def pressure_shear(scene, j, near, p, normal, g1, g2, way):
    """Return the shear of the pressure on the upper block, N, and its moment about the place half-way, N m.

    Parameters
    ----------
    near : mask
        Where joint j slides or may be about to: elsewhere the edges of its lower face are left out.
    p : Plane
        Penetration, m.
    normal, g1, g2 : float or lanes
        Resultants of the pressure, N, N m.
    way : tuple
        Direction of motion of the upper block along the joint, m, m and rad, which decides about edges that coincide.
    """
    slips, zero = scene.slips, zero_like(p.at)
    # a bearing has no edges
    if any_of(scene.joints.section[j] == POINT):
        return zero, zero, zero
    # integrals along the edges of the lower face
    outline = outline_of(scene, j)
    _, _, endless = corners_of_faces(scene, outline.above, outline.below)
    edge_x, edge_y, moment = zero, zero, zero
    if not endless and any_of(near):
        edge_x, edge_y, moment = _edges_of_lower(scene, j, outline, near, p, way)
        rims = has_inside(scene, j)
        if any_of(rims):
            inside = _edges_of_lower(scene, j, inside_of(scene, j), near & rims, p, way)
            edge_x, edge_y = edge_x - where(rims, inside[0], 0.0), edge_y - where(rims, inside[1], 0.0)
            moment = moment - where(rims, inside[2], 0.0)
    # half of the edge terms, less the component of the tilted normal force
    half = 0.5 * scene.joints.stiffness[j]
    turn = half * moment - 0.5 * (p.along_x * g1 + p.along_y * g2)
    turn += 0.25 * normal * (p.along_y * slips.p1[j] - p.along_x * slips.p2[j])
    return half * edge_x - 0.5 * normal * p.along_x, half * edge_y - 0.5 * normal * p.along_y, turn
