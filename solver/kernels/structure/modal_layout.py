"""The layout of the modal data of a structure and of the room for steps by modes, by name (modal.py)."""

from typing import NamedTuple

from ..engine.modal_steps import Modal
from ..layout.spaces import MODAL_LIMITS, MODE, RESPONSE_FIELDS, RESPONSE_HEADER, RESPONSES
from ..numba_ext.jit import leaf
from ..numba_ext.views import FieldTable, Numbers, Record, Space
from .layout import EACH, MEMORY

AXES = 6  # coordinates of a body: three displacements, three rotations
LIMITS = Record(
    *MODAL_LIMITS.fields,  # parts: groups of coordinates
    "flat_parts",  # those in the plane x, z
    *("count", "flat_count"),  # modes; those in the plane
    "matrices",  # length of all shapes
    *("cost", "flat_cost"),  # of a step over one by the explicit method
    "ready",  # 1: damping and limits are computed
)
COORDINATES = FieldTable(
    "place",  # index in a phase
    "rest",  # the number of the phase there, at rest
    "group",  # sizes of the groups
)
MOTION = FieldTable("coordinates", "rates", "accelerations")  # of modes
THREE = FieldTable("first", "second", "third")  # generic names of the segments of MOTION
# `size` coordinates; remembered: memory of joints and ties at rest; taut: of ties, 1 if they pull at rest; shapes,
# inverses: square matrices by rows, one for each group of coordinates
_SIZES = "size", "remembered", "k", "matrices"
MODAL = Space(
    *_SIZES,
    limits=LIMITS,
    modes=Numbers(MODE.beside),
    coordinates=COORDINATES,
    remembered=(EACH, "remembered"),
    taut=(EACH, "k"),
    shapes=(EACH, "matrices"),
    inverses=(EACH, "matrices"),
)
MODAL_ROOM = Space(
    "size",
    "k",
    x=THREE,
    first=MOTION,
    mean=MOTION,
    last=MOTION,
    slopes=EACH,
    curvatures=EACH,
    trend=Record("known"),
    latest=Record("response"),
    responses=Numbers(RESPONSES * RESPONSE_FIELDS, RESPONSES * RESPONSE_HEADER),
    elastic=(EACH, "k"),  # m, elastic stretches of the ties in the middle of the step
)
_modal, _room, _limits, _PER_JOINT = MODAL.over, MODAL_ROOM.over, LIMITS.over, MEMORY.per_n


class ModalBody(NamedTuple):
    """A structure in the coordinates of its modes."""

    scene: object
    segment: int
    data: object
    parts: int  # groups that move
    active: int  # number of coordinates that move
    x: object  # coordinates, rates, accelerations
    elastic: object  # m, elastic stretches of the ties in the middle of the step


@leaf
def data_of(scene):
    """Return the modal data of a scene that has them."""
    matrices = int(_limits(scene.modal, 0).matrices)
    return _modal(scene.modal, (AXES * scene.n, _PER_JOINT * scene.m + scene.k, scene.k, matrices))


@leaf
def room_of(scene):
    """Return the room for steps by modes."""
    return _room(scene.modal_room, (AXES * scene.n, scene.k))


@leaf
def body_of(scene, segment, flat):
    """Return the structure in modal coordinates, and its modes; flat: True if it moves in the plane x, z alone."""
    data, room = data_of(scene), room_of(scene)
    limits = data.limits
    # groups and modes that move
    parts = int(limits.flat_parts) if flat else int(limits.parts)
    count = int(limits.flat_count) if flat else int(limits.count)
    body = ModalBody(scene, segment, data, parts, count, room.x, room.elastic)
    # rows of the step
    steps = room.first, room.mean, room.last, room.slopes, room.curvatures, room.trend
    return body, Modal(count, AXES * scene.n, data.modes, *steps, room.responses, room.latest)
