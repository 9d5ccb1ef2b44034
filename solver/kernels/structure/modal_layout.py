"""What lies where in the modal data of a structure, and in the room that steps by modes need, by name (modal.py)."""

from typing import NamedTuple

from ..integrators.modal_steps import Modal
from ..layout.spaces import MODAL_LIMITS, MODE, RESPONSE_FIELDS, RESPONSE_HEADER, RESPONSES
from ..numba_ext.jit import in_both, leaf
from ..numba_ext.views import Record, Table
from .layout import MEMORY

AXES = 6  # coordinates of a body: three displacements, three rotations
LIMITS = Record(
    *MODAL_LIMITS.fields,  # parts: groups of coordinates
    "flat_parts",  # of them in the plane x, z
    *("count", "flat_count"),  # modes; of them in the plane
    "matrices",  # numbers of all shapes
    *("cost", "flat_cost"),  # of a step over one by the explicit method
    "ready",  # 1: damping and limits are worked out
)
COORDINATES = Table(
    "place",  # in a phase
    "rest",  # the number of the phase there
    "group",  # sizes of the groups
)
MOTION = Table("coordinates", "rates", "accelerations")  # of modes
THREE = Table("first", "second", "third")  # the same
_limits, _coordinates, _motion, _three = LIMITS.over, COORDINATES.over, MOTION.over, THREE.over
_trend, _latest = Record("known").over, Record("response").over
_PER_JOINT, _LIMITS, _MODE = MEMORY.per_n, LIMITS.beside, MODE.beside
_COORDINATE = COORDINATES.per_n
_OF_COORDINATE = _MODE + _COORDINATE


@in_both
def modal_size(n: int, m: int, k: int, matrices: int) -> int:
    """Length of the modal data; matrices: numbers of all shapes."""
    size: int = _LIMITS + _OF_COORDINATE * AXES * n + _PER_JOINT * m + 2 * k + 2 * matrices
    return size


@in_both
def room_size(n: int, k: int) -> int:
    """Numbers behind a work array that modes need."""
    size: int = (4 * 3 + 2 + RESPONSES * RESPONSE_FIELDS) * AXES * n + k + 2 + RESPONSES * RESPONSE_HEADER
    return size


class Data(NamedTuple):
    """The modal data by name."""

    limits: object
    modes: object
    coordinates: object
    memory: object  # what joints and ties remember at rest
    taut: object  # of ties: 1 if they pull at rest
    shapes: object  # square matrices, by rows, one for each group
    inverses: object


class Body(NamedTuple):
    """A structure in the coordinates of its modes."""

    scene: object
    shaking: object
    segment: int
    data: object
    parts: int  # groups that move
    active: int  # number of their coordinates
    x: object  # coordinates, rates, accelerations
    elastic: object  # m, elastic stretches of the ties in the middle of the step


@leaf
def data_of(scene):
    """The modal data of a scene that has them."""
    size, m, k = AXES * scene.n, scene.m, scene.k
    limits = _limits(scene.modal, 0)
    modes = scene.modal[_LIMITS:]
    coordinates = modes[_MODE * size :]
    memory = coordinates[_COORDINATE * size :]
    taut = memory[_PER_JOINT * m + k :]
    shapes = taut[k:]
    inverses = shapes[int(limits.matrices) :]
    return Data(limits, modes, _coordinates(coordinates, size), memory, taut, shapes, inverses)


@leaf
def body_of(scene, shaking, segment, flat):
    """The structure, and its modes; flat: whether it moves in the plane x, z alone."""
    data, size = data_of(scene), AXES * scene.n
    limits, room = data.limits, scene.modal_room
    parts = int(limits.flat_parts) if flat else int(limits.parts)
    count = int(limits.flat_count) if flat else int(limits.count)
    slopes = room[12 * size :]
    curvatures, trend = slopes[size:], slopes[2 * size :]
    latest = trend[1:]
    responses = latest[1:]
    elastic = responses[RESPONSES * (RESPONSE_FIELDS * size + RESPONSE_HEADER) :]
    body = Body(scene, shaking, segment, data, parts, count, _three(room, size), elastic)
    rows = _motion(room[3 * size :], size), _motion(room[6 * size :], size), _motion(room[9 * size :], size)
    modal = Modal(count, size, data.modes, *rows, slopes, curvatures, _trend(trend, 0), responses, _latest(latest, 0))
    return body, modal
