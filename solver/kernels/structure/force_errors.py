"""The error of a step in terms of the joint forces.

Stiff beds and dashpots turn a small error of a displacement or rate into a large one of a force: d and d' of the
opening or slip of a joint into stiffness times (d + damping d'). The embedded error of a step gives both without
another evaluation.
"""

import math

from ..numba_ext.jit import kernel, leaf
from .bearing import stiffness_along
from .kinematics import cross, dot, minus, plus, standing, turned
from .layout import PHASE
from .watch import END, row

_phase = PHASE.over
LEAST_SHEAR = 0.01  # least reference of shear errors, over the largest normal force
LEAST_NORMAL = 0.1  # least reference of normal errors, over the mean weight on a joint
LEAST_GRAVITY = 1e-3  # m/s2, replaces that of a structure without weight


@kernel
def _convert_errors(scene, error):
    """Replace quaternion errors by rotation vectors, rad, and transform angular velocities to the axes of the base."""
    end = _phase(row(scene, END), scene.n)
    for i in range(scene.n):
        q, d = (end.q1[i], end.q2[i], end.q3[i]), (error.q1[i], error.q2[i], error.q3[i])
        # half the rotation vector: the vector of the error times the conjugate quaternion
        half = plus(plus(cross(q, d), d, end.q0[i]), q, -error.q0[i])
        error.q1[i], error.q2[i], error.q3[i] = 2.0 * half[0], 2.0 * half[1], 2.0 * half[2]
        spin = error.wx[i], error.wy[i], error.wz[i]
        error.wx[i], error.wy[i], error.wz[i] = plus(spin, turned(scene.poses, i, *spin), 1.0)


@leaf
def _error_of_motion(scene, error, i, arm, damping):
    """Return the error of d + damping d' of body i: that of the end of an arm, m, and that of its rotation, rad."""
    # the base has no error
    if i == scene.n:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    # errors of the centroid and of the rotation, with their rates
    place = plus((error.ux[i], error.uy[i], error.uz[i]), (error.vx[i], error.vy[i], error.vz[i]), damping)
    turn = plus((error.q1[i], error.q2[i], error.q3[i]), (error.wx[i], error.wy[i], error.wz[i]), damping)
    return plus(place, cross(turn, arm), 1.0), turn


@kernel
def _least_normal(scene):
    """Return the least normal force, N, that errors are measured against: a run may begin without any."""
    # total mass
    mass = 0.0
    for i in range(scene.n):
        mass += scene.bodies.mass[i]
    return LEAST_NORMAL * mass * max(scene.settings.gravity, LEAST_GRAVITY) / max(1, scene.m)


@kernel
def error_of_forces(scene, errors):
    """Return the largest error of a joint's normal or shear force over the tolerance times the largest so far.

    errors: of the state just evaluated at the end of a step; they are changed. The pressure is evaluated at its centre
    over the loaded area; axes are those of the lower body. Joints that slide are left out in shear: friction sets their
    force.
    """
    joints, found, poses, control = scene.joints, scene.resultants, scene.poses, scene.control
    error, across, along = _phase(errors, scene.n), 0.0, 0.0
    _convert_errors(scene, error)
    for j in range(scene.m):
        a, b = int(joints.upper[j]), int(joints.lower[j])
        # axes and arms as they stand
        e1 = standing(poses, b, joints.e1x[j], joints.e1y[j], joints.e1z[j])
        e2 = standing(poses, b, joints.e2x[j], joints.e2y[j], joints.e2z[j])
        e3 = cross(e1, e2)
        arm_a = standing(poses, a, joints.ax[j], joints.ay[j], joints.az[j])
        arm_b = standing(poses, b, joints.bx[j], joints.by[j], joints.bz[j])
        for kind in range(2):  # a loop, so that it is compiled once
            damping = joints.damping[j] if kind == 0 else joints.shear_damping[j]
            # error of the relative displacement and rotation of the faces
            place_a, turn_a = _error_of_motion(scene, error, a, arm_a, damping)
            place_b, turn_b = _error_of_motion(scene, error, b, arm_b, damping)
            gap, turn = minus(place_a, place_b), minus(turn_a, turn_b)
            normal, k1, k2 = found.normal[j], dot(e1, turn), dot(e2, turn)
            # normal force
            if kind == 0 and normal > 0.0:
                opening = dot(e3, gap) - (k1 * found.g1[j] + k2 * found.g2[j]) / normal
                bent = joints.arm[j] * found.area[j] / joints.area[j] * math.sqrt(k1 * k1 + k2 * k2)
                across = max(across, joints.stiffness[j] * found.area[j] * (abs(opening) + bent))
            # shear force of a joint that sticks
            elif kind == 1 and scene.giving_slips.p1[j] == 0.0 and scene.giving_slips.p2[j] == 0.0:
                along = max(along, stiffness_along(scene, j, normal) * math.sqrt(dot(e1, gap) ** 2 + dot(e2, gap) ** 2))
            # twisting couple of a joint that does not twist
            if kind == 1 and scene.giving_slips.p3[j] == 0.0:
                along = max(along, joints.twist[j] / joints.arm[j] * abs(dot(e3, turn)))
    # relative to the largest force so far
    largest = max(control.largest_normal, _least_normal(scene))
    shear = max(control.largest_shear, LEAST_SHEAR * largest)
    return max(across / largest, along / shear) / scene.settings.tolerance
