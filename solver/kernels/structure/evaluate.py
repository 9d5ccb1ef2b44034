"""The equations of motion of a structure, its energy, and all that a user sees of it at one instant."""

import math

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import any_of, zero_like
from ..numba_ext.views import copy
from .extras import extras_energy, load_extras, see_extras, see_from_ground, show_extras
from .joint import joint_energy, load_joint
from .kinematics import accelerate_bodies, pose_bodies, rotation_vector
from .layout import OF_BASE, OF_BLOCK, OF_JOINT, PHASE
from .tie import load_tie, tie_energy

_phase = PHASE.over
_PER_BODY = PHASE.per_n
_BLOCKS, _JOINTS, _BASE = len(OF_BLOCK), len(OF_JOINT), len(OF_BASE)


@leaf
def moving(scene):
    """How many numbers of a state move: those of the phase, and the memory where something gives way."""
    count = _PER_BODY * scene.n
    if any_of(scene.settings.gives_way != 0.0):
        count += scene.remembered
    return count


@kernel
def recall(scene, state):
    """Take what joints, ties and pairs remember from a state."""
    copy(scene.memory, state[_PER_BODY * scene.n :], scene.remembered)


@kernel
def settle_memory(scene, state):
    """Let the state that has just been evaluated remember elastic parts within their limits, as after a long rest."""
    found, slips = scene.resultants, scene.slips
    for j in range(scene.m):
        slips.p1[j] = found.s1[j] - found.z1[j]
        slips.p2[j] = found.s2[j] - found.z2[j]
        slips.p3[j] = found.s3[j] - found.z3[j]
    for e in range(scene.k):
        scene.plastic[e] = scene.pulls.stretch[e] - scene.pulls.elastic[e]
    copy(state[_PER_BODY * scene.n :], scene.memory, scene.remembered)


@kernel
def evaluate_state(scene, state, rates, ax, ay, az):
    """`evaluate`, with the memory of the state where it moves, and its rates."""
    n, gives_way = scene.n, any_of(scene.settings.gives_way != 0.0)
    if gives_way:
        recall(scene, state)
    evaluate(scene, _phase(state, n), _phase(rates, n), ax, ay, az)
    if gives_way:
        copy(rates[_PER_BODY * n :], scene.giving, scene.remembered)


@kernel
def evaluate(scene, phase, rates, ax, ay, az):
    """Rates of a phase under an acceleration of the base, m/s2; forces and resultants are left in the scene."""
    pose_bodies(scene, phase)
    for j in range(scene.m):
        load_joint(scene, phase, j)
    for e in range(scene.k):
        load_tie(scene, phase, e)
    load_extras(scene, phase)
    accelerate_bodies(scene, phase, rates, ax, ay, az)
    see_extras(scene, phase, rates)


@kernel
def energy(scene, phase):
    """Mechanical energy of a phase that has just been evaluated, J; zero of weight as built."""
    bodies, total = scene.bodies, zero_like(phase.uz[0])
    for i in range(scene.n):
        v = phase.vx[i] * phase.vx[i] + phase.vy[i] * phase.vy[i] + phase.vz[i] * phase.vz[i]
        x, y, z = phase.wx[i], phase.wy[i], phase.wz[i]
        turning = bodies.jxx[i] * x * x + bodies.jyy[i] * y * y + bodies.jzz[i] * z * z
        turning += 2.0 * (bodies.jxy[i] * x * y + bodies.jxz[i] * x * z + bodies.jyz[i] * y * z)
        total += 0.5 * (bodies.mass[i] * v + turning) + bodies.mass[i] * scene.settings.gravity * phase.uz[i]
    for j in range(scene.m):
        total += joint_energy(scene, phase, j)
    for e in range(scene.k):
        total += tie_energy(scene, e)
    return total + extras_energy(scene)


@leaf
def show_block(scene, phase, i, row):
    """Fill in what an output row has of block i."""
    n = scene.n
    row[i], row[n + i], row[2 * n + i] = phase.ux[i], phase.uy[i], phase.uz[i]
    turn = rotation_vector(phase.q0[i], phase.q1[i], phase.q2[i], phase.q3[i])
    row[3 * n + i], row[4 * n + i], row[5 * n + i] = turn


@leaf
def show_joint(scene, j, row):
    """Fill in what an output row has of joint j, which has just been loaded."""
    m, found, of_joints = scene.m, scene.resultants, row[_BLOCKS * scene.n :]
    slip = math.hypot(scene.slips.p1[j], scene.slips.p2[j])
    of_joints[j] = found.normal[j]
    of_joints[m + j], of_joints[2 * m + j] = found.g1[j], found.g2[j]
    of_joints[3 * m + j], of_joints[4 * m + j] = -found.t1[j], -found.t2[j]
    of_joints[5 * m + j] = found.g3[j]
    of_joints[6 * m + j] = min(1.0, found.area[j] / scene.joints.area[j])
    of_joints[7 * m + j], of_joints[8 * m + j] = found.pressure[j], slip


@kernel
def show(scene, phase, row):
    """Fill an output row from a phase that has just been evaluated: by field, then by block or joint."""
    n, m, k = scene.n, scene.m, scene.k
    for i in range(n):
        show_block(scene, phase, i, row)
    for j in range(m):
        show_joint(scene, j, row)
    of_ties = row[_BLOCKS * n + _JOINTS * m :]
    for e in range(k):
        of_ties[e] = scene.pulls.force[e]
    show_extras(scene, phase, of_ties[k:])
    base, poses = row[scene.visible - _BASE :], scene.poses
    base[0], base[1], base[2] = poses.fx[n], poses.fy[n], poses.fz[n]
    base[3], base[4], base[5] = poses.mx[n], poses.my[n], poses.mz[n]
    see_from_ground(scene, phase, row)
