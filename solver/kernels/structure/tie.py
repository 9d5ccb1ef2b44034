"""Ties: rods, clamps, tendons and dampers between two points."""

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import index_of, magnitude, opposite, square_root, where, with_sign, zero_like
from .kinematics import minus, point_of, push


@leaf
def _ends(scene, phase, e):
    """Return the motion of both ends of tie e, and the vector between them as built, m."""
    ties, bodies = scene.ties, scene.bodies
    a, b = index_of(ties.one[e]), index_of(ties.other[e])
    # both points of attachment
    one = point_of(scene, phase, a, ties.ax[e], ties.ay[e], ties.az[e])
    other = point_of(scene, phase, b, ties.bx[e], ties.by[e], ties.bz[e])
    # vector between them as built, m
    built = (
        bodies.x[b] + ties.bx[e] - bodies.x[a] - ties.ax[e],
        bodies.y[b] + ties.by[e] - bodies.y[a] - ties.ay[e],
        bodies.z[b] + ties.bz[e] - bodies.z[a] - ties.az[e],
    )
    return one, other, built


@kernel
def load_tie(scene, phase, e):
    """Add the force of tie e to those on its two bodies.

    A tie that yields keeps its force and stretches plastically at a rate that is stored in the scene.
    """
    ties, pulls = scene.ties, scene.pulls
    one, other, built = _ends(scene, phase, e)
    # present length, direction and rate
    moved = minus(other.moved, one.moved)
    x, y, z = built[0] + moved[0], built[1] + moved[1], built[2] + moved[2]
    length = square_root(x * x + y * y + z * z)
    x, y, z = x / length, y / length, z / length
    pace = minus(other.velocity, one.velocity)
    rate = x * pace[0] + y * pace[1] + z * pace[2]
    # elastic stretch, slack or bounded by yielding
    stretch = length - ties.length[e]
    own = stretch - scene.plastic[e]
    slackens = ties.tension_only[e] != 0.0
    is_slack = slackens & (own <= 0.0)
    yields = (ties.stiffness[e] * magnitude(own) > ties.yields_at[e]) & opposite(is_slack)
    reach = where(yields, with_sign(ties.yields_at[e] / ties.stiffness[e], own), own)
    # force and plastic rate
    force = ties.stiffness[e] * reach + ties.damping[e] * rate
    loose = is_slack | (slackens & (force <= 0.0))
    force = where(loose, 0.0, force)
    giving = where(loose, 0.0, (own - reach) / scene.settings.relaxation)
    own = reach
    # store them, and push both bodies
    pulls.force[e], pulls.stretch[e], pulls.elastic[e] = force, stretch, own
    scene.giving_plastic[e] = giving
    zero = zero_like(force)
    pull, none = (force * x, force * y, force * z), (zero, zero, zero)
    push(scene.poses, index_of(ties.one[e]), one.arm, pull, none, 1.0)
    push(scene.poses, index_of(ties.other[e]), other.arm, pull, none, -1.0)


@leaf
def tie_energy(scene, e):
    """Return the elastic energy of tie e at the last evaluation, J."""
    ties, pulls = scene.ties, scene.pulls
    stretch = pulls.elastic[e]
    slack = (ties.tension_only[e] != 0.0) & (stretch <= 0.0)
    return where(slack, 0.0, 0.5 * ties.stiffness[e] * stretch * stretch)
