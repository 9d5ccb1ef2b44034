"""The equations of motion of a structure, its energy, and all outputs at one instant."""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, zero_like
from ..numba_ext.views import copy
from .contact import pairs_energy
from .extras import load_extras, see_extras, see_from_ground, show_extras
from .joint import joint_energy, load_joint
from .kinematics import accelerate_bodies, pose_bodies, rotation_vector
from .layout import OF_BASE, OF_BLOCK, OF_JOINT, PHASE
from .tie import load_tie, tie_energy

_phase = PHASE.over
_PER_BODY = PHASE.per_n
_BLOCKS, _JOINTS, _BASE = len(OF_BLOCK), len(OF_JOINT), len(OF_BASE)


@leaf
def moving(scene):
    """Return the length of the integrated part of a state: the phase, and the memory if something slides or yields."""
    count = _PER_BODY * scene.n
    if any_of(scene.settings.gives_way != 0.0):
        count += scene.remembered
    return count


@kernel
def recall(scene, state):
    """Copy the memory of joints, ties and pairs from a state into the scene."""
    # the memory follows the phase in a state
    copy(scene.memory, state[_PER_BODY * scene.n :], scene.remembered)


@kernel
def settle_memory(scene, state):
    """Set the memory of the state just evaluated to the plastic parts beyond the limits, as after a long rest."""
    found, slips = scene.resultants, scene.slips
    # slips of joints
    for j in range(scene.m):
        slips.p1[j] = found.s1[j] - found.z1[j]
        slips.p2[j] = found.s2[j] - found.z2[j]
        slips.p3[j] = found.s3[j] - found.z3[j]
    # plastic stretches of ties
    for e in range(scene.k):
        scene.plastic[e] = scene.pulls.stretch[e] - scene.pulls.elastic[e]
    copy(state[_PER_BODY * scene.n :], scene.memory, scene.remembered)


@kernel
def evaluate_state(scene, state, rates, ax, ay, az):
    """Fill `rates` with the rates of a whole state under a base acceleration (m/s2), memory included."""
    n, gives_way = scene.n, any_of(scene.settings.gives_way != 0.0)
    # memory
    if gives_way:
        recall(scene, state)
    evaluate(scene, _phase(state, n), _phase(rates, n), ax, ay, az)
    if gives_way:
        copy(rates[_PER_BODY * n :], scene.giving, scene.remembered)


@kernel
def evaluate(scene, phase, rates, ax, ay, az):
    """Fill `rates` with the rates of a phase under a base acceleration (m/s2).

    Forces on bodies and resultants of joints and ties are left in the scene.
    """
    # rotations, then forces of joints, ties and extras
    pose_bodies(scene, phase)
    for j in range(scene.m):
        load_joint(scene, phase, j)
    for e in range(scene.k):
        load_tie(scene, phase, e)
    load_extras(scene, phase)
    # accelerations
    accelerate_bodies(scene, phase, rates, ax, ay, az)
    see_extras(scene, phase, rates)


@kernel
def energy(scene, phase):
    """Return the mechanical energy of a phase that has just been evaluated, J; the weight has none as built."""
    bodies, total = scene.bodies, zero_like(phase.uz[0])
    # kinetic energy and weight
    for i in range(scene.n):
        v = phase.vx[i] * phase.vx[i] + phase.vy[i] * phase.vy[i] + phase.vz[i] * phase.vz[i]
        x, y, z = phase.wx[i], phase.wy[i], phase.wz[i]
        # rotational energy from the inertia tensor
        turning = bodies.jxx[i] * x * x + bodies.jyy[i] * y * y + bodies.jzz[i] * z * z
        turning += 2.0 * (bodies.jxy[i] * x * y + bodies.jxz[i] * x * z + bodies.jyz[i] * y * z)
        total += 0.5 * (bodies.mass[i] * v + turning) + bodies.mass[i] * scene.settings.gravity * phase.uz[i]
    # elastic energy
    for j in range(scene.m):
        total += joint_energy(scene, phase, j)
    for e in range(scene.k):
        total += tie_energy(scene, e)
    return total + pairs_energy(scene, phase)


@leaf
def show_block(scene, phase, i, row):
    """Fill the output row with the displacements (m) and the rotation vector (rad) of block i."""
    n = scene.n
    row[i], row[n + i], row[2 * n + i] = phase.ux[i], phase.uy[i], phase.uz[i]
    turn = rotation_vector(phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i])
    row[3 * n + i], row[4 * n + i], row[5 * n + i] = turn


@leaf
def show_joint(scene, j, row):
    """Fill the output row with the resultants of joint j, which has just been loaded."""
    m, found, of_joints = scene.m, scene.resultants, row[_BLOCKS * scene.n :]
    # size of the slip
    slip = math.hypot(scene.slips.p1[j], scene.slips.p2[j])
    # N, Mx, My, Tx, Ty, Mz
    of_joints[j] = found.normal[j]
    of_joints[m + j], of_joints[2 * m + j] = found.g1[j], found.g2[j]
    of_joints[3 * m + j], of_joints[4 * m + j] = -found.t1[j], -found.t2[j]
    of_joints[5 * m + j] = found.g3[j]
    # contact, sigma_max, slip
    of_joints[6 * m + j] = min(1.0, found.area[j] / scene.joints.area[j])
    of_joints[7 * m + j], of_joints[8 * m + j] = found.pressure[j], slip


@kernel
def show(scene, phase, row, every_gap):
    """Fill an output row from a phase that has just been evaluated: by field, then by block or joint.

    every_gap: fill all gaps of pairs; else a gap is infinite that cannot be the least so far.
    """
    n, m, k = scene.n, scene.m, scene.k
    # blocks, joints, ties and extras
    for i in range(n):
        show_block(scene, phase, i, row)
    for j in range(m):
        show_joint(scene, j, row)
    of_ties = row[_BLOCKS * n + _JOINTS * m :]
    for e in range(k):
        of_ties[e] = scene.pulls.force[e]
    show_extras(scene, phase, of_ties[k:], every_gap)
    # force and moment on the base
    base, poses = row[scene.visible - _BASE :], scene.poses
    base[0], base[1], base[2] = poses.fx[n], poses.fy[n], poses.fz[n]
    base[3], base[4], base[5] = poses.mx[n], poses.my[n], poses.mz[n]
    see_from_ground(scene, phase, row)
