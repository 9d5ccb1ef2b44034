"""Ports: points of blocks at which loads act and whose motion is an output (theory.md section 16).

A load is a force and a couple along the axes of the base: samples joined by straight lines, with jumps between them
where there are any, plus the inputs of an FMU. Not used in lanes (extras.py).
"""

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import index_of
from ..numba_ext.views import clear
from .kinematics import cross, plus, point_of, push, turned
from .layout import LOAD

_COMPONENTS = len(LOAD)


@kernel
def push_ports(scene, k, t):
    """Set the loads on the ports at time t, s, on segment k; they stay until they are set again."""
    count, taken, given = _COMPONENTS * scene.extras.spotted, scene.extras.pushes.row, scene.extras.inputs
    samples, past = scene.samples, t - scene.base.t0
    # inputs
    for i in range(count):
        taken[i] = given[i] + past * given[count + i]
    # samples
    if samples.loaded != 0 and 0 <= k < samples.size - 1:
        line, past = samples.loads[2 * count * k :], t - samples.times[k]
        for i in range(count):
            taken[i] += line[i] + past * line[count + i]


@leaf
def let_ports_go(scene):
    """Clear the loads on all ports."""
    clear(scene.extras.pushes.row, _COMPONENTS * scene.extras.spotted)


@kernel
def is_pushed(scene, k):
    """Return True if a load acts on a port on segment k."""
    count, samples = 2 * _COMPONENTS * scene.extras.spotted, scene.samples
    # inputs
    for i in range(count):
        if scene.extras.inputs[i] != 0.0:
            return True
    # samples
    if samples.loaded != 0 and 0 <= k < samples.size - 1:
        line = samples.loads[count * k :]
        for i in range(count):
            if line[i] != 0.0:
                return True
    return False


@kernel
def load_ports(scene, phase):
    """Add the loads on the ports to the forces on their blocks."""
    ports, loads = scene.extras.ports, scene.extras.pushes
    for p in range(scene.extras.spotted):
        i = index_of(ports.body[p])
        # lever of the port about the centroid, m
        arm = point_of(scene, phase, i, ports.x[p], ports.y[p], ports.z[p]).arm
        force, couple = (loads.fx[p], loads.fy[p], loads.fz[p]), (loads.mx[p], loads.my[p], loads.mz[p])
        push(scene.poses, i, arm, force, couple, 1.0)


@kernel
def see_ports(scene, phase, rates):
    """Fill the motion of the ports relative to the base (m, m/s, m/s2) from a phase and its rates."""
    ports, seen, poses = scene.extras.ports, scene.extras.spots, scene.poses
    for p in range(scene.extras.spotted):
        i = index_of(ports.body[p])
        point = point_of(scene, phase, i, ports.x[p], ports.y[p], ports.z[p])
        # angular acceleration along the axes of the base
        own = rates.wx[i], rates.wy[i], rates.wz[i]
        grows = plus(own, turned(poses, i, own[0], own[1], own[2]), 1.0)
        spin = poses.wx[i], poses.wy[i], poses.wz[i]
        # acceleration of the end of the arm
        swept = plus(cross(grows, point.arm), cross(spin, cross(spin, point.arm)), 1.0)
        seen.x[p], seen.y[p], seen.z[p] = point.moved[0], point.moved[1], point.moved[2]
        seen.vx[p], seen.vy[p], seen.vz[p] = point.velocity[0], point.velocity[1], point.velocity[2]
        seen.ax[p], seen.ay[p], seen.az[p] = rates.vx[i] + swept[0], rates.vy[i] + swept[1], rates.vz[i] + swept[2]
