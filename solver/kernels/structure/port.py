"""Ports: points of blocks at which loads act, and whose motion is an output (theory.md section 15).

A load is a force and a couple along the axes of the base: samples that lines join, with jumps between them where there
are any, and the inputs of an FMU beside them. Scenes with extras alone get here (extras.py), and lanes have no loads.
"""

from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.lanes import LanesType, index_of
from ..numba_ext.views import clear
from .kinematics import cross, plus, point_of, push, turned
from .layout import LOAD

_COMPONENTS = len(LOAD)


@by_width
def push_ports(scene, shaking, k, t):
    """Take the loads on the ports at time t, s, on segment k; they stay until others are taken."""
    return _nothing_at if isinstance(t, LanesType) else _push_at


def _nothing_at(scene, shaking, k, t):
    return


def _push_at(scene, shaking, k, t):
    if scene.extras.spotted > 0:
        _take_loads(scene, shaking, k, t)


@kernel
def _take_loads(scene, shaking, k, t):
    count, taken, given = _COMPONENTS * scene.extras.spotted, scene.extras.pushes.row, shaking.inputs
    past = t - shaking.base.t0
    for i in range(count):
        taken[i] = given[i] + past * given[count + i]
    if shaking.loaded > 0 and 0 <= k < shaking.size - 1:
        samples, past = shaking.loads[2 * count * k :], t - shaking.times[k]
        for i in range(count):
            taken[i] += samples[i] + past * samples[count + i]


@leaf
def let_ports_go(scene):
    """Leave no load on any port."""
    clear(scene.extras.pushes.row, _COMPONENTS * scene.extras.spotted)


@kernel
def is_pushed(scene, shaking, k):
    """Whether a load acts on segment k."""
    count = 2 * _COMPONENTS * scene.extras.spotted
    for i in range(count):
        if shaking.inputs[i] != 0.0:
            return True
    if shaking.loaded > 0 and 0 <= k < shaking.size - 1:
        samples = shaking.loads[count * k :]
        for i in range(count):
            if samples[i] != 0.0:
                return True
    return False


@by_width
def load_ports(scene, phase, like):
    """Add the loads on the ports to the forces on their blocks; like: a number of the scene."""
    return _nothing_on if isinstance(like, LanesType) else _load_on


def _nothing_on(scene, phase, like):
    return


def _load_on(scene, phase, like):
    if scene.extras.spotted > 0:
        _load_blocks(scene, phase)


@kernel
def _load_blocks(scene, phase):
    ports, loads = scene.extras.ports, scene.extras.pushes
    for p in range(scene.extras.spotted):
        i = index_of(ports.body[p])
        arm = point_of(scene, phase, i, ports.x[p], ports.y[p], ports.z[p]).arm
        force, couple = (loads.fx[p], loads.fy[p], loads.fz[p]), (loads.mx[p], loads.my[p], loads.mz[p])
        push(scene.poses, i, arm, force, couple, 1.0)


@by_width
def see_ports(scene, phase, rates, like):
    """Fill in the motion of the ports, of a phase and its rates; like: a number of the scene."""
    return _nothing_seen if isinstance(like, LanesType) else _see_on


def _nothing_seen(scene, phase, rates, like):
    return


def _see_on(scene, phase, rates, like):
    if scene.extras.spotted > 0:
        _see_points(scene, phase, rates)


@kernel
def _see_points(scene, phase, rates):
    ports, seen, poses = scene.extras.ports, scene.extras.spots, scene.poses
    for p in range(scene.extras.spotted):
        i = index_of(ports.body[p])
        point = point_of(scene, phase, i, ports.x[p], ports.y[p], ports.z[p])
        own = rates.wx[i], rates.wy[i], rates.wz[i]
        grows = plus(own, turned(poses, i, own[0], own[1], own[2]), 1.0)
        spin = poses.wx[i], poses.wy[i], poses.wz[i]
        swept = plus(cross(grows, point.arm), cross(spin, cross(spin, point.arm)), 1.0)
        seen.x[p], seen.y[p], seen.z[p] = point.moved[0], point.moved[1], point.moved[2]
        seen.vx[p], seen.vy[p], seen.vz[p] = point.velocity[0], point.velocity[1], point.velocity[2]
        seen.ax[p], seen.ay[p], seen.az[p] = rates.vx[i] + swept[0], rates.vy[i] + swept[1], rates.vz[i] + swept[2]
