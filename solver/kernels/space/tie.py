"""Ties: rods, clamps, tendons and dampers between two points."""

import math

from ..numba_ext.jit import kernel, leaf
from .kinematics import minus, point_of, push


@leaf
def _ends(scene, phase, e):
    """The two ends of tie e, and the vector between them as built, m."""
    ties, bodies = scene.ties, scene.bodies
    a, b = int(ties.one[e]), int(ties.other[e])
    one = point_of(scene, phase, a, ties.ax[e], ties.ay[e], ties.az[e])
    other = point_of(scene, phase, b, ties.bx[e], ties.by[e], ties.bz[e])
    built = (
        bodies.x[b] + ties.bx[e] - bodies.x[a] - ties.ax[e],
        bodies.y[b] + ties.by[e] - bodies.y[a] - ties.ay[e],
        bodies.z[b] + ties.bz[e] - bodies.z[a] - ties.az[e],
    )
    return one, other, built


@kernel
def load_tie(scene, phase, e):
    """Add the force of tie e to those on its two bodies.

    A tie that yields keeps its force, and grows at a rate that is left in the scene.
    """
    ties, pulls = scene.ties, scene.pulls
    one, other, built = _ends(scene, phase, e)
    moved = minus(other.moved, one.moved)
    x, y, z = built[0] + moved[0], built[1] + moved[1], built[2] + moved[2]
    length = math.sqrt(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    pace = minus(other.velocity, one.velocity)
    rate = x * pace[0] + y * pace[1] + z * pace[2]
    stretch = length - ties.length[e]
    own, giving = stretch - scene.plastic[e], 0.0
    elastic, is_slack = ties.stiffness[e] * own, ties.tension_only[e] != 0.0 and own <= 0.0
    if abs(elastic) > ties.yields_at[e] and not is_slack:
        reach = math.copysign(ties.yields_at[e] / ties.stiffness[e], own)
        giving = (own - reach) / scene.settings.relaxation
        elastic, own = ties.stiffness[e] * reach, reach
    force = elastic + ties.damping[e] * rate
    if is_slack or (ties.tension_only[e] != 0.0 and force <= 0.0):
        force, giving = 0.0, 0.0
    pulls.force[e], pulls.stretch[e], pulls.elastic[e] = force, stretch, own
    scene.giving_plastic[e] = giving
    pull, none = (force * x, force * y, force * z), (0.0, 0.0, 0.0)
    push(scene.poses, int(ties.one[e]), one.arm, pull, none, 1.0)
    push(scene.poses, int(ties.other[e]), other.arm, pull, none, -1.0)


@leaf
def tie_energy(scene, e):
    """Elastic energy of tie e, J, of the last evaluation."""
    ties, pulls = scene.ties, scene.pulls
    stretch = pulls.elastic[e]
    if ties.tension_only[e] != 0.0 and stretch <= 0.0:
        return 0.0
    return 0.5 * ties.stiffness[e] * stretch * stretch
