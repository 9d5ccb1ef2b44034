"""Features that only some structures have: bearings, ports, neighbours in contact, bonds, a rotating base.

Their counts are zero in all others (layout.py, Extras). In lanes ports are not loaded and the base does not rotate: the
first version of each varied function is that of lanes, and does less.
"""

import math

from ..numba_ext.jit import kernel, leaf, varied
from ..numba_ext.views import copy
from .base import acceleration
from .bond import let_bonds_go, show_bonds
from .contact import gap_of, gap_or_bound, load_pairs, may_be_least
from .contact_in_lanes import load_pairs_in_lanes
from .layout import OF_BASE, OF_BEARING, OF_BOND, OF_PAIR, OF_PORT, PROMISE, acts_alone
from .port import is_pushed, let_ports_go, load_ports, push_ports, see_ports
from .turning import is_turned, load_turned, show_turned, stop_turning, turn_base


@varied
def taken_at(scene, k, t):
    """Return the base acceleration (ax, ay, az), m/s2, at time t (s) on segment k.

    Alone, not in lanes, also set the loads at ports and the rotation of the base, which stay until they are set again.
    """
    return acceleration(scene, k, t)


@taken_at.version(acts_alone)
def _take(scene, k, t):
    push_ports(scene, k, t)
    pushed = acceleration(scene, k, t)
    turn_base(scene, scene.base, t, pushed[0], pushed[1], pushed[2])
    return pushed


@kernel
def let_go(scene):
    """Clear all loads, the rotation of the base and the holds of bonds."""
    let_bonds_go(scene)
    let_ports_go(scene)
    stop_turning(scene)


@kernel
def is_loaded(scene, k):
    """Return True if a load at a port or a rotation of the base acts on segment k."""
    return is_pushed(scene, k) or is_turned(scene.base)


@varied
def load_extras(scene, phase):
    """Add the forces of extras to those on the bodies, after joints and ties."""
    load_pairs_in_lanes(scene, phase)


@load_extras.version(acts_alone)
def _load(scene, phase):
    load_ports(scene, phase)
    load_pairs(scene, phase)
    load_turned(scene, phase)


@varied
def see_extras(scene, phase, rates):
    """Fill the motion of the ports from a phase and its rates; nothing in lanes."""
    return


@see_extras.version(acts_alone)
def _see(scene, phase, rates):
    see_ports(scene, phase, rates)


@leaf
def first_gap(scene):
    """Return the index of the first gap of pairs in an output row."""
    behind = len(OF_BASE) + len(OF_PORT) * scene.extras.spotted + len(OF_PAIR) * scene.extras.met
    return scene.visible - behind


@kernel
def show_extras(scene, phase, shown, every_gap):
    """Fill `shown`, the part of an output row between ties and base, with bearings, bonds, pairs and ports.

    every_gap: as of `show`.
    """
    m, b = scene.m, scene.extras.b
    # displacements of bearings
    for i in range(b):
        x, y = scene.resultants.s1[m - b + i], scene.resultants.s2[m - b + i]
        shown[i], shown[b + i], shown[2 * b + i] = x, y, math.hypot(x, y)
    # bonded fractions
    of_bonds, met = shown[len(OF_BEARING) * b :], scene.extras.met
    show_bonds(scene, of_bonds)
    # gaps and contact forces of pairs, then the motion of ports
    of_pairs = of_bonds[len(OF_BOND) * scene.extras.glued :]
    place = first_gap(scene)
    for p in range(met):
        of_pairs[p], touches, least = math.inf, scene.extras.stretches.touches[p], 1.0 - scene.peaks[place + p]
        highest = scene.extras.hits.highest[p]
        least -= PROMISE * scene.settings.tolerance * max(least, 0.0)
        if every_gap:
            of_pairs[p] = gap_of(scene, phase, scene.extras.pairs, p, touches, highest)
        elif may_be_least(scene, p, least):
            of_pairs[p] = gap_or_bound(scene, phase, p, touches, least, highest)
        of_pairs[met + p] = scene.extras.hits.force[p]
    copy(of_pairs[len(OF_PAIR) * met :], scene.extras.spots.row, len(OF_PORT) * scene.extras.spotted)


@varied
def see_from_ground(scene, phase, row):
    """Transform an output row from the axes of a rotating base to fixed axes; nothing in lanes."""
    return


@see_from_ground.version(acts_alone)
def _see_from_ground(scene, phase, row):
    show_turned(scene, phase, row)
