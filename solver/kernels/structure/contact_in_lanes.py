"""Contact of neighbours in lanes: pairs that touch are loaded lane by lane, by the kernel of one structure.

Few pairs touch at a time, and in few lanes. `alone` returns the view of one lane under the names of a scene.
"""

from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import WIDTH, bits
from ..numba_ext.views import numbers_of, one_lane
from .contact import load_pair
from .layout import BODIES, HITS, PAIRS, PHASE, POSES, STRETCH

_bodies, _poses, _phase = BODIES.over, POSES.over, PHASE.over
_pairs, _hits, _stretch = PAIRS.over, HITS.over, STRETCH.over


class Met(NamedTuple):
    """The pairs of one lane, with the names of Extras."""

    met: int
    pairs: object
    hits: object
    stretches: object
    giving_stretches: object


class Alone(NamedTuple):
    """The view of one lane that the contact of neighbours needs, with the names of `KernelScene`."""

    n: int
    m: int
    k: int
    stride: int
    bodies: object
    corners: object
    poses: object
    room: object
    cells: object  # shared by all lanes
    states: object
    extras: object


@leaf
def alone(scene, k):
    """Return the view of lane k for its pairs."""
    n, extras = scene.n, scene.extras
    met = extras.met
    # rows of this lane; sizes and the room of cells are those of all lanes
    return Alone(
        n,
        scene.m,
        scene.k,
        scene.stride,
        _bodies(one_lane(scene.bodies.row, k), n + 1),
        one_lane(scene.corners, k),
        _poses(one_lane(scene.poses.row, k), n + 1),
        one_lane(scene.room, k),
        numbers_of(scene.cells),
        one_lane(scene.states, k),
        Met(
            met,
            _pairs(one_lane(extras.pairs.row, k), met),
            _hits(one_lane(extras.hits.row, k), met),
            _stretch(one_lane(extras.stretches.row, k), met),
            _stretch(one_lane(extras.giving_stretches.row, k), met),
        ),
    )


@kernel
def _load_lane(scene, phase, k, p):
    one = alone(scene, k)
    load_pair(one, _phase(one_lane(phase.row, k), scene.n), one.extras, p)


@kernel
def load_pairs_in_lanes(scene, phase):
    """Add the forces of all pairs that touch in any lane."""
    touches, bears = scene.extras.stretches.touches, scene.extras.hits.bears
    for p in range(scene.extras.met):
        # lanes in which the pair touches, or has forces to clear
        busy = bits((touches[p] != 0.0) | (bears[p] != 0.0))
        if busy != 0:
            for k in range(WIDTH):
                if (busy >> k) & 1:
                    _load_lane(scene, phase, k, p)
