"""Kinematics of bodies and joints: rotations, and the relative motion of joint faces (theory.md section 13)."""

import math
from typing import NamedTuple

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, index_of, square_root, where, zero_like
from ..numba_ext.numbers import half_sine_cosine

# squared sine of half the tilt of two faces, from 90 degrees but for rounding, beyond which a joint has no meaning
TIPPED = 0.5 - 1e-12


@kernel
def pose_body(scene, phase, i):
    """Fill the rotation matrix (less the identity) and the angular velocity (rad/s) of body i in the scene."""
    poses = scene.poses
    q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
    wx, wy, wz = phase.wx[i], phase.wy[i], phase.wz[i]
    # the rotation less the identity: displacements keep their digits at any distance from the origin
    r11, r12, r13 = -2.0 * (q2 * q2 + q3 * q3), 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)
    r21, r22, r23 = 2.0 * (q1 * q2 + q0 * q3), -2.0 * (q1 * q1 + q3 * q3), 2.0 * (q2 * q3 - q0 * q1)
    r31, r32, r33 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), -2.0 * (q1 * q1 + q2 * q2)
    poses.r11[i], poses.r12[i], poses.r13[i] = r11, r12, r13
    poses.r21[i], poses.r22[i], poses.r23[i] = r21, r22, r23
    poses.r31[i], poses.r32[i], poses.r33[i] = r31, r32, r33
    # angular velocity along the axes of the base
    poses.wx[i] = wx + (r11 * wx + r12 * wy + r13 * wz)
    poses.wy[i] = wy + (r21 * wx + r22 * wy + r23 * wz)
    poses.wz[i] = wz + (r31 * wx + r32 * wy + r33 * wz)


@kernel
def pose_two(scene, phase, one, other):
    """Fill the rotations and angular velocities of two bodies; the base has none."""
    for body in (one, other):
        if body < scene.n:
            pose_body(scene, phase, body)


@kernel
def pose_bodies(scene, phase):
    """Fill the rotations and angular velocities of all bodies, and clear the forces on them."""
    poses = scene.poses
    for i in range(scene.n):
        pose_body(scene, phase, i)
    # forces and couples, on the base too
    for i in range(scene.n + 1):
        poses.fx[i], poses.fy[i], poses.fz[i] = 0.0, 0.0, 0.0
        poses.mx[i], poses.my[i], poses.mz[i] = 0.0, 0.0, 0.0


@leaf
def turned(poses, i, x, y, z):
    """Return how far the rotation of body i has moved the end of a vector fixed to it, m."""
    return (
        poses.r11[i] * x + poses.r12[i] * y + poses.r13[i] * z,
        poses.r21[i] * x + poses.r22[i] * y + poses.r23[i] * z,
        poses.r31[i] * x + poses.r32[i] * y + poses.r33[i] * z,
    )


@leaf
def standing(poses, i, x, y, z):
    """Rotate a vector fixed to body i from the axes as built to those of the base."""
    return plus((x, y, z), turned(poses, i, x, y, z), 1.0)


@leaf
def seen_from(poses, i, a):
    """Transform a vector from the axes of the base to those of body i."""
    return (
        a[0] + (poses.r11[i] * a[0] + poses.r21[i] * a[1] + poses.r31[i] * a[2]),
        a[1] + (poses.r12[i] * a[0] + poses.r22[i] * a[1] + poses.r32[i] * a[2]),
        a[2] + (poses.r13[i] * a[0] + poses.r23[i] * a[1] + poses.r33[i] * a[2]),
    )


@leaf
def momentum(bodies, i, w):
    """Multiply the inertia of body i by an angular velocity, in the axes of the body."""
    return (
        bodies.jxx[i] * w[0] + bodies.jxy[i] * w[1] + bodies.jxz[i] * w[2],
        bodies.jxy[i] * w[0] + bodies.jyy[i] * w[1] + bodies.jyz[i] * w[2],
        bodies.jxz[i] * w[0] + bodies.jyz[i] * w[1] + bodies.jzz[i] * w[2],
    )


@leaf
def cross(a, b):
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@leaf
def dot(a, b):
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@leaf
def minus(a, b):
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


@leaf
def spin_of(q, p):
    """Return the angular velocity, in the axes of the body, of a unit quaternion q with the rate p.

    With its second derivative as p it is the angular acceleration.
    """
    return (
        2.0 * (q[0] * p[1] - q[1] * p[0] - q[2] * p[3] + q[3] * p[2]),
        2.0 * (q[0] * p[2] - q[2] * p[0] - q[3] * p[1] + q[1] * p[3]),
        2.0 * (q[0] * p[3] - q[3] * p[0] - q[1] * p[2] + q[2] * p[1]),
    )


@leaf
def rotation_vector(q0, q1, q2, q3):
    """Return the rotation vector (axis times angle, rad) of a unit quaternion."""
    sign = -1.0 if q0 < 0.0 else 1.0
    sine = math.sqrt(q1 * q1 + q2 * q2 + q3 * q3)
    per = sign * (2.0 * math.atan2(sine, sign * q0) / sine if sine > 1e-9 else 2.0)
    return per * q1, per * q2, per * q3


@leaf
def plus(a, b, factor):
    """Return a + factor b."""
    return a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]


@leaf
def quaternion(scene, phase, i):
    """Return the rotation of body i since it was built; that of the base is the identity."""
    if i < scene.n:
        return phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
    zero = zero_like(phase.q0[0])
    return 1.0 + zero, zero, zero, zero


class Point(NamedTuple):
    """A point fixed to a body, along the axes of the base."""

    moved: object  # m, since it was built
    arm: object  # m, from the centroid
    velocity: object  # m/s


@leaf
def point_of(scene, phase, i, x, y, z):
    """Return the motion of the point of body i that was at (x, y, z), m, from its centroid as built."""
    if i == scene.n:
        # the base does not move
        none = (zero_like(x), zero_like(x), zero_like(x))
        return Point(none, (x, y, z), none)
    # displacement and velocity of the end of the arm
    turn = turned(scene.poses, i, x, y, z)
    arm = (x + turn[0], y + turn[1], z + turn[2])
    spin = (scene.poses.wx[i], scene.poses.wy[i], scene.poses.wz[i])
    swept = cross(spin, arm)
    moved = (phase.ux[i] + turn[0], phase.uy[i] + turn[1], phase.uz[i] + turn[2])
    velocity = (phase.vx[i] + swept[0], phase.vy[i] + swept[1], phase.vz[i] + swept[2])
    return Point(moved, arm, velocity)


class Relative(NamedTuple):
    """The motion of the upper face of a joint relative to the lower one, in the frame half-way between both."""

    e1: object  # axes of that frame, components along those of the base
    e2: object
    e3: object
    gap: object  # m: slips along e1 and e2, opening along e3
    gap_rate: object  # m/s
    turn: object  # rad, kappa: tilts, and the elastic twist
    turn_rate: object
    vector: object  # vector of the relative quaternion
    per_scalar: object  # 1 / (1 + scalar of the relative quaternion)
    arm_a: object  # m, from the centroids to the centres of the faces
    arm_b: object


@leaf
def along(e1, e2, e3, a):
    """Return the components of a vector in a frame."""
    return dot(e1, a), dot(e2, a), dot(e3, a)


@leaf
def out_of(e1, e2, e3, a):
    """Return the vector with the components `a` in a frame."""
    return (
        e1[0] * a[0] + e2[0] * a[1] + e3[0] * a[2],
        e1[1] * a[0] + e2[1] * a[1] + e3[1] * a[2],
        e1[2] * a[0] + e2[2] * a[1] + e3[2] * a[2],
    )


@leaf
def _frame(joints, j, q0, q1, q2, q3):
    """Rotate the axes of joint j by a unit quaternion."""
    # rotation matrix, then the first two axes
    s11, s12, s13 = 1.0 - 2.0 * (q2 * q2 + q3 * q3), 2.0 * (q1 * q2 - q0 * q3), 2.0 * (q1 * q3 + q0 * q2)
    s21, s22, s23 = 2.0 * (q1 * q2 + q0 * q3), 1.0 - 2.0 * (q1 * q1 + q3 * q3), 2.0 * (q2 * q3 - q0 * q1)
    s31, s32, s33 = 2.0 * (q1 * q3 - q0 * q2), 2.0 * (q2 * q3 + q0 * q1), 1.0 - 2.0 * (q1 * q1 + q2 * q2)
    # the first two axes, rotated
    x, y, z = joints.e1x[j], joints.e1y[j], joints.e1z[j]
    e1 = (s11 * x + s12 * y + s13 * z, s21 * x + s22 * y + s23 * z, s31 * x + s32 * y + s33 * z)
    x, y, z = joints.e2x[j], joints.e2y[j], joints.e2z[j]
    e2 = (s11 * x + s12 * y + s13 * z, s21 * x + s22 * y + s23 * z, s31 * x + s32 * y + s33 * z)
    return e1, e2, cross(e1, e2)


@leaf
def _vector_between(a, b):
    """Return the vector of conj(b) a, in which the rounding of both quaternions cancels."""
    return (
        b[0] * a[1] - b[1] * a[0] - b[2] * a[3] + b[3] * a[2],
        b[0] * a[2] - b[2] * a[0] - b[3] * a[1] + b[1] * a[3],
        b[0] * a[3] - b[3] * a[0] - b[1] * a[2] + b[2] * a[1],
    )


@leaf
def tilt_left(scene, phase, j):
    """Return `TIPPED` less the `tilt_square` of joint j: negative if its faces are tilted by more than 90 degrees."""
    return TIPPED - tilt_square(scene, phase, j)


@leaf
def tilt_square(scene, phase, j):
    """Return the squared sine of half the tilt between the faces of joint j, whatever their twist."""
    joints = scene.joints
    a = quaternion(scene, phase, index_of(joints.upper[j]))
    vector = _vector_between(a, quaternion(scene, phase, index_of(joints.lower[j])))
    # components across the normal: the sum of their squares is sin^2 of half the tilt, whatever the twist
    x = dot((joints.e1x[j], joints.e1y[j], joints.e1z[j]), vector)
    y = dot((joints.e2x[j], joints.e2y[j], joints.e2z[j]), vector)
    return x * x + y * y


@leaf
def _turned_about(q, axis, sine, cosine):
    """Multiply a quaternion from the right by the rotation about an axis; sine, cosine: of half its angle."""
    # product with the quaternion (cosine, sine axis)
    v = (q[1], q[2], q[3])
    across, along_axis = cross(v, axis), dot(v, axis)
    return (
        cosine * q[0] - sine * along_axis,
        cosine * q[1] + sine * (q[0] * axis[0] + across[0]),
        cosine * q[2] + sine * (q[0] * axis[1] + across[1]),
        cosine * q[3] + sine * (q[0] * axis[2] + across[2]),
    )


@leaf
def _faces_of(scene, phase, j):
    """Return the rotations of both faces of joint j since they were built, without the twist of its slider.

    Each face is rotated back by half of that twist, so that tilt and elastic twist are left: nothing is singular
    however far a block spins as it slides.
    """
    joints, p3 = scene.joints, scene.slips.p3[j]
    a = quaternion(scene, phase, index_of(joints.upper[j]))
    b = quaternion(scene, phase, index_of(joints.lower[j]))
    # half of the twist of the slider to each face
    if any_of(p3 != 0.0):
        sine, cosine = half_sine_cosine(0.5 * p3)
        axis = (joints.e3x[j], joints.e3y[j], joints.e3z[j])
        a, b = _turned_about(a, axis, -sine, cosine), _turned_about(b, axis, sine, cosine)
    return a, b


@leaf
def relative_motion(scene, phase, j):
    """Return the relative motion of the faces of joint j (`Relative`); its twist is the elastic part."""
    joints, poses = scene.joints, scene.poses
    a, b = index_of(joints.upper[j]), index_of(joints.lower[j])
    # the relative quaternion
    (a0, a1, a2, a3), (b0, b1, b2, b3) = _faces_of(scene, phase, j)
    scalar = a0 * b0 + a1 * b1 + a2 * b2 + a3 * b3
    sign = where(scalar < 0.0, -1.0, 1.0 + zero_like(scalar))  # of both equivalent quaternions the nearer one
    a0, a1, a2, a3, scalar = sign * a0, sign * a1, sign * a2, sign * a3, sign * scalar
    v1, v2, v3 = _vector_between((a0, a1, a2, a3), (b0, b1, b2, b3))
    # the frame half-way, by the mean quaternion
    norm = 1.0 / square_root(2.0 + 2.0 * scalar)
    e1, e2, e3 = _frame(joints, j, norm * (a0 + b0), norm * (a1 + b1), norm * (a2 + b2), norm * (a3 + b3))
    vector = (
        joints.e1x[j] * v1 + joints.e1y[j] * v2 + joints.e1z[j] * v3,
        joints.e2x[j] * v1 + joints.e2y[j] * v2 + joints.e2z[j] * v3,
        joints.e3x[j] * v1 + joints.e3y[j] * v2 + joints.e3z[j] * v3,
    )
    # gap of the centres
    on_a = point_of(scene, phase, a, joints.ax[j], joints.ay[j], joints.az[j])
    on_b = point_of(scene, phase, b, joints.bx[j], joints.by[j], joints.bz[j])
    gap = along(e1, e2, e3, minus(on_a.moved, on_b.moved))
    # relative angular velocity, and that of the frame
    spin_a = along(e1, e2, e3, (poses.wx[a], poses.wy[a], poses.wz[a]))
    spin_b = along(e1, e2, e3, (poses.wx[b], poses.wy[b], poses.wz[b]))
    spin = minus(spin_a, spin_b)
    per_scalar = 1.0 / (1.0 + scalar)
    lag = cross(vector, spin)
    mean = (
        0.5 * (spin_a[0] + spin_b[0] - per_scalar * lag[0]),
        0.5 * (spin_a[1] + spin_b[1] - per_scalar * lag[1]),
        0.5 * (spin_a[2] + spin_b[2] - per_scalar * lag[2]),
    )
    # rates in the rotating frame
    gap_rate = minus(along(e1, e2, e3, minus(on_a.velocity, on_b.velocity)), cross(mean, gap))
    turn_rate = plus(spin, vector, -per_scalar * dot(vector, spin))
    turn = (2.0 * vector[0], 2.0 * vector[1], 2.0 * vector[2])
    return Relative(e1, e2, e3, gap, gap_rate, turn, turn_rate, vector, per_scalar, on_a.arm, on_b.arm)


@leaf
def push(poses, i, arm, force, couple, sign):
    """Add a force (N) at the end of an arm (m), and a couple (N m), to what acts on body i, along the axes of the base.

    sign: factor on the force, not on the couple.
    """
    moment = cross(arm, force)
    poses.fx[i] += sign * force[0]
    poses.fy[i] += sign * force[1]
    poses.fz[i] += sign * force[2]
    poses.mx[i] += sign * moment[0] + couple[0]
    poses.my[i] += sign * moment[1] + couple[1]
    poses.mz[i] += sign * moment[2] + couple[2]


@kernel
def accelerate_bodies(scene, phase, rates, ax, ay, az):
    """Fill `rates` with the rates of the phase under the forces on the bodies and a base acceleration, m/s2."""
    bodies, poses, gravity = scene.bodies, scene.poses, scene.settings.gravity
    flat = any_of(scene.settings.in_plane != 0.0)
    for i in range(scene.n):
        q0, q1, q2, q3 = phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i]
        w = phase.wx[i], phase.wy[i], phase.wz[i]
        # kinematics
        rates.ux[i], rates.uy[i], rates.uz[i] = phase.vx[i], phase.vy[i], phase.vz[i]
        rates.q0[i] = -0.5 * (q1 * w[0] + q2 * w[1] + q3 * w[2])
        rates.q1[i] = 0.5 * (q0 * w[0] + q2 * w[2] - q3 * w[1])
        rates.q2[i] = 0.5 * (q0 * w[1] + q3 * w[0] - q1 * w[2])
        rates.q3[i] = 0.5 * (q0 * w[2] + q1 * w[1] - q2 * w[0])
        # Newton's and Euler's equations
        per_mass = bodies.per_mass[i]
        rates.vx[i] = poses.fx[i] * per_mass - ax
        rates.vy[i] = poses.fy[i] * per_mass - ay
        rates.vz[i] = poses.fz[i] * per_mass - gravity - az
        # moments along the axes of the body, less the gyroscopic one
        m = poses.mx[i], poses.my[i], poses.mz[i]
        left = minus(seen_from(poses, i, m), cross(w, momentum(bodies, i, w)))
        rates.wx[i] = bodies.ixx[i] * left[0] + bodies.ixy[i] * left[1] + bodies.ixz[i] * left[2]
        rates.wy[i] = bodies.ixy[i] * left[0] + bodies.iyy[i] * left[1] + bodies.iyz[i] * left[2]
        rates.wz[i] = bodies.ixz[i] * left[0] + bodies.iyz[i] * left[1] + bodies.izz[i] * left[2]
        if flat:  # components that vanish by symmetry stay exactly zero
            rates.vy[i], rates.wx[i], rates.wz[i] = 0.0, 0.0, 0.0
