"""The terms that a bearing adds to its joint: contact at a point, and forces in parallel to the slider (theory.md 13).

Each function returns its argument unchanged if joint j is no bearing.
"""

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, greater, index_of, square_root, where, zero_like
from .bed import Bed, Plane
from .kinematics import pose_two, relative_motion
from .layout import POINT

TINY = 1e-300  # m


@leaf
def bed_of_point(joints, j, p, q):
    """Return the bed of a bearing: a normal spring without couples, which bears tension if the bearing holds."""
    # in contact, or held down
    bears = ((p.at > 0.0) & (q.at > 0.0)) | (joints.holds[j] != 0.0)
    area, pressed, zero = where(bears, joints.area[j], 0.0), where(bears, q.at, 0.0), zero_like(q.at)
    return Bed(area * pressed, zero, zero, area, pressed)


@leaf
def lifted(scene, j, p, gap, by):
    """Return the penetration p of joint j, m, or its rate, increased by the rise of the pendulum.

    A pendulum of radius R rises by u^2 / 2R at the displacement u, so that its force is conservative. The rise is the
    scalar product of `gap` and `by` over R; by: half of `gap` for the penetration, the rate of `gap` for its rate.
    """
    if any_of(scene.joints.section[j] == POINT):
        rises = gap[0] * by[0] + gap[1] * by[1]
        p = Plane(p.at + scene.joints.pendulum[j] * rises, p.along_x, p.along_y)
    return p


@leaf
def _beyond_ring(joints, j, x, y):
    """Return how far the displacement (x, y) of bearing j is beyond its ring, and its size, both in m."""
    out = square_root(x * x + y * y)
    return greater(out - joints.ring[j], 0.0), greater(out, TINY)


@leaf
def _restoring(joints, j, motion, normal):
    """Return the force (N) of pendulum, spring, dashpot and ring of a bearing, parallel to its slider."""
    x, y, v1, v2 = motion.gap[0], motion.gap[1], motion.gap_rate[0], motion.gap_rate[1]
    # pendulum, spring and dashpot
    stiffness, dashpot = joints.pendulum[j] * normal + joints.spring[j], joints.dashpot[j]
    t1, t2 = -(stiffness * x + dashpot * v1), -(stiffness * y + dashpot * v2)
    # the ring pushes radially inwards and never pulls
    beyond, out = _beyond_ring(joints, j, x, y)
    touches = beyond > 0.0
    if any_of(touches):
        pace = (x * v1 + y * v2) / out
        push = joints.ring_stiffness[j] * greater(beyond + joints.ring_damping[j] * pace, 0.0)
        per = where(touches, push / out, 0.0)
        t1, t2 = t1 - per * x, t2 - per * y
    return t1, t2


@leaf
def with_parallel_forces(scene, j, motion, normal, t1, t2):
    """Return the slider forces (t1, t2) along joint j, N, plus those of a bearing in parallel."""
    if any_of(scene.joints.section[j] == POINT):
        beside = _restoring(scene.joints, j, motion, normal)
        t1, t2 = t1 + beside[0], t2 + beside[1]
    return t1, t2


@leaf
def with_bearing(scene, j, doubled):
    """Return twice the elastic energy of joint j, J, plus that of a bearing's spring and ring.

    The energy of a pendulum is contained in that of the penetration.
    """
    joints, found = scene.joints, scene.resultants
    if any_of(joints.section[j] == POINT):
        s1, s2 = found.s1[j], found.s2[j]
        # spring and ring
        beyond, _ = _beyond_ring(joints, j, s1, s2)
        doubled += joints.spring[j] * (s1 * s1 + s2 * s2) + joints.ring_stiffness[j] * beyond * beyond
    return doubled


@leaf
def stiffness_along(scene, j, normal):
    """Return the stiffness along joint j while it sticks, N/m."""
    joints = scene.joints
    return joints.shear[j] + joints.spring[j] + joints.pendulum[j] * normal


@leaf
def _is_left(scene, j):
    """Return True if the last evaluation was beyond the capacity of bearing j, in any direction."""
    x, y, capacity = scene.resultants.s1[j], scene.resultants.s2[j], scene.joints.capacity[j]
    return x * x + y * y > capacity * capacity


@kernel
def come_off(scene, found):
    """Return the number, from 1, of a block that has left its bearing at the last evaluation; else `found`."""
    for j in range(scene.m - scene.extras.b, scene.m):
        found = where(_is_left(scene, j), index_of(scene.joints.upper[j]) + 1.0, found)
    return found


@kernel
def left_bearing(scene, block):
    """Return the number, from 1, of the bearing that a block (number from 1) has left as by `come_off`; 0 if none."""
    for b in range(scene.extras.b):
        j = scene.m - scene.extras.b + b
        if scene.joints.upper[j] + 1.0 == block and _is_left(scene, j):
            return b + 1
    return 0


@kernel
def travel_left(scene, phase, j):
    """Return how much further the faces of bearing j may be displaced, m, until what it bears has come off."""
    pose_two(scene, phase, index_of(scene.joints.upper[j]), index_of(scene.joints.lower[j]))
    x, y, _ = relative_motion(scene, phase, j).gap
    return scene.joints.capacity[j] - square_root(x * x + y * y)


@kernel
def raise_displacements(scene, peaks, lanes):
    """Raise the largest displacement of each bearing, m, in the lanes of a mask by the last evaluation."""
    first = scene.m - scene.extras.b
    for i in range(scene.extras.b):
        x, y = scene.resultants.s1[first + i], scene.resultants.s2[first + i]
        peaks[i] = where(lanes, greater(peaks[i], square_root(x * x + y * y)), peaks[i])
