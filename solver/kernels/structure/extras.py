"""What only some structures have: bearings, and ports with their loads.

One gate, by type. The scene of a structure without any has no `extras` (layout.py, Extras), and what it compiles is the
first of each pair of functions here and in bearing.py: nothing. All others compile the second, with everything in it,
whichever of the extras they have. What another extra needs is added to `Extras` and to the second functions.
"""

import math

from ..numba_ext.jit import varied
from ..numba_ext.views import copy
from .layout import OF_BEARING, OF_PORT, has_extras
from .port import is_pushed, let_ports_go, load_ports, push_ports, see_ports


@varied
def take_extras(scene, shaking, k, t):
    """Take what acts on the structure at time t, s, on segment k; it stays until something else is taken."""
    return


@take_extras.version(has_extras)
def _take(scene, shaking, k, t):
    push_ports(scene, shaking, k, t)


@varied
def let_go(scene):
    """Leave nothing that acts on the structure."""
    return


@let_go.version(has_extras)
def _let_go(scene):
    let_ports_go(scene)


@varied
def is_loaded(scene, shaking, k):
    """Whether something acts on the structure on segment k, beside the acceleration of the base."""
    return False


@is_loaded.version(has_extras)
def _is_loaded(scene, shaking, k):
    return is_pushed(scene, shaking, k)


@varied
def load_extras(scene, phase):
    """Add the forces of extras to those on the bodies; joints and ties have been loaded."""
    return


@load_extras.version(has_extras)
def _load(scene, phase):
    load_ports(scene, phase, scene.settings.gravity)


@varied
def see_extras(scene, phase, rates):
    """Fill in what is seen of extras, of a phase and its rates."""
    return


@see_extras.version(has_extras)
def _see(scene, phase, rates):
    see_ports(scene, phase, rates, scene.settings.gravity)


@varied
def show_extras(scene, shown):
    """Fill in what an output row has of extras: between ties and base, from `shown` on."""
    return


@show_extras.version(has_extras)
def _show(scene, shown):
    m, b = scene.m, scene.extras.b
    for i in range(b):
        x, y = scene.resultants.s1[m - b + i], scene.resultants.s2[m - b + i]
        shown[i], shown[b + i], shown[2 * b + i] = x, y, math.hypot(x, y)
    copy(shown[len(OF_BEARING) * b :], scene.extras.spots.row, len(OF_PORT) * scene.extras.spotted)
