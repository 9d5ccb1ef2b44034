"""What only some structures have: bearings, ports with loads, neighbours that meet, bonds that break, a turning base.

Their numbers are zero in all others (layout.py, Extras). In lanes ports are not loaded and the base does not turn:
functions whose first version does less are those of lanes.
"""

import math

from ..numba_ext.jit import kernel, varied
from ..numba_ext.views import copy
from .base import acceleration
from .bond import let_bonds_go, show_bonds
from .contact import error_of_pairs, gap_of, load_pairs, pairs_energy
from .contact_in_lanes import load_pairs_in_lanes
from .layout import OF_BEARING, OF_BOND, OF_PAIR, OF_PORT, acts_alone
from .port import is_pushed, let_ports_go, load_ports, push_ports, see_ports
from .turning import is_turned, load_turned, show_turned, stop_turning, turn_base


@varied
def taken_at(scene, shaking, k, t):
    """(ax, ay, az) of the base at time t, s, on segment k, m/s2; take what else acts, until something else is taken."""
    return acceleration(shaking, k, t)


@taken_at.version(acts_alone)
def _take(scene, shaking, k, t):
    push_ports(scene, shaking, k, t)
    pushed = acceleration(shaking, k, t)
    turn_base(scene, shaking.base, t, pushed[0], pushed[1], pushed[2])
    return pushed


@kernel
def let_go(scene):
    """Leave nothing that acts on the structure."""
    let_bonds_go(scene)
    let_ports_go(scene)
    stop_turning(scene)


@kernel
def is_loaded(scene, shaking, k):
    """Whether something acts on the structure on segment k, beside the acceleration of the base."""
    return is_pushed(scene, shaking, k) or is_turned(shaking.base)


@varied
def load_extras(scene, phase):
    """Add the forces of extras to those on the bodies; joints and ties have been loaded."""
    load_pairs_in_lanes(scene, phase)


@load_extras.version(acts_alone)
def _load(scene, phase):
    load_ports(scene, phase)
    load_pairs(scene, phase)
    load_turned(scene, phase)


@kernel
def error_of_extras(scene, errors):
    """Largest error, m, of what extras remember, of those of all that joints and the rest remember."""
    return error_of_pairs(scene, errors)


@kernel
def extras_energy(scene):
    """Elastic energy of extras, J, of the last evaluation, but that of bearings, which are joints."""
    return pairs_energy(scene)


@varied
def see_extras(scene, phase, rates):
    """Fill in what is seen of extras, of a phase and its rates."""
    return


@see_extras.version(acts_alone)
def _see(scene, phase, rates):
    see_ports(scene, phase, rates)


@kernel
def show_extras(scene, phase, shown):
    """Fill in what an output row has of extras: between ties and base, from `shown` on."""
    m, b = scene.m, scene.extras.b
    for i in range(b):
        x, y = scene.resultants.s1[m - b + i], scene.resultants.s2[m - b + i]
        shown[i], shown[b + i], shown[2 * b + i] = x, y, math.hypot(x, y)
    of_bonds, met = shown[len(OF_BEARING) * b :], scene.extras.met
    show_bonds(scene, of_bonds)
    of_pairs = of_bonds[len(OF_BOND) * scene.extras.glued :]
    for p in range(met):
        of_pairs[p], of_pairs[met + p] = gap_of(scene, phase, scene.extras.pairs, p), scene.extras.hits.force[p]
    copy(of_pairs[len(OF_PAIR) * met :], scene.extras.spots.row, len(OF_PORT) * scene.extras.spotted)


@varied
def see_from_ground(scene, phase, row):
    """Turn an output row to fixed axes, where those of the base turn."""
    return


@see_from_ground.version(acts_alone)
def _see_from_ground(scene, phase, row):
    show_turned(scene, phase, row)
