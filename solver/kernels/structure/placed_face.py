"""The faces of a joint that has slid, each at its present place."""

import math
from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, index_of
from ..numba_ext.numbers import half_sine_cosine
from ..numba_ext.views import one_lane
from .layout import FACE, MEMORY

_face, _memory = FACE.over, MEMORY.over
_FACE = FACE.beside


class _Placed(NamedTuple):
    """A face at its present place: rotated by the angle of this sine and cosine, then moved by dx, dy (m)."""

    record: object
    corners: object
    sine: float
    cosine: float
    dx: float
    dy: float


@leaf
def placed(corners, place, slips, j, half):
    """Return the face at an index of the corners, moved by `half` times the slip and twist of joint j."""
    part, (sine, cosine) = corners[place:], half_sine_cosine(2.0 * half * slips.p3[j])
    return _Placed(_face(part, 0), part[_FACE:], sine, cosine, half * slips.p1[j], half * slips.p2[j])


@leaf
def _moved(face, x, y):
    return face.dx + (face.cosine * x - face.sine * y), face.dy + (face.sine * x + face.cosine * y)


@leaf
def _corner_of(face, k):
    return _moved(face, face.corners[2 * k], face.corners[2 * k + 1])


@leaf
def centre_of(face):
    """Return the centre of a disc or ring, m."""
    return _moved(face, face.record.x, face.record.y)


@leaf
def is_round(face):
    """Return True if a face is a disc or a ring."""
    return index_of(face.record.corners) == 0


@kernel
def put_corners(room, face):
    """Fill the room with the corners of a polygon; return their number."""
    # at their present places
    count = index_of(face.record.corners)
    for k in range(count):
        room[2 * k], room[2 * k + 1] = _corner_of(face, k)
    return count


@leaf
def corners_of_faces(scene, above, below):
    """Return the numbers of corners of two faces, 0 of a round one, and whether the lower one is unbounded.

    above, below: their indices among the corners.
    """
    above, below = _face(scene.corners[above:], 0), _face(scene.corners[below:], 0)
    return index_of(above.corners), index_of(below.corners), any_of(below.outer == math.inf)


@leaf
def rows_of_lane(scene, k):
    """Return the room, corners and slips of lane k."""
    slips = _memory(one_lane(scene.slips.row, k), scene.m)
    return one_lane(scene.room, k), one_lane(scene.corners, k), slips
