"""The paper's first-order model (theory.md section 3), solved by Gauss-Seidel reanalysis.

The paper's rows, joint by joint, are premultiplied by T^-1 and divided by the heights (theory.md section 3, last
paragraph): horizontally the constant mass matrix is then tridiagonal and symmetric, vertically diagonal, and it is
factorized once. A sweep solves the horizontal rows with the latest vertical accelerations and then the
vertical rows with the latest horizontal ones; all terms that depend on the displacements (dM and df of eqs. 22-23) are
taken from the last iterate: the block form of eqs. 28-31, O(n) a sweep. It is written for the accelerations; with
central differences in time the displacements of eq. 27 follow from them.

In a phase the displacements v replace the rotations and the settlements w the openings. The sweeps serve one column and
lanes of eight (lanes.py).
"""

from ..column.formulations.base_motion import base_motion
from ..column.formulations.dispatch import evaluate_at
from ..column.formulations.slips import evaluate_after_jump
from ..column.joint.law import resultants
from ..column.joint.sliding import less_below
from ..column.model.assembly import settle_joints
from ..layout import spaces as at
from ..layout.spaces import NOT_CONVERGED, OK, ROTATES
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import greater, magnitude
from ..numba_ext.views import FieldTable, Numbers, Space

MODEL = Space(**at.MODEL.parts, paper=Numbers())  # as `exact`; the empty part selects versions at compile time

MAX_SWEEPS = 100
SWEEP_TOLERANCE = 1e-13  # relative to the largest acceleration
REST_TOLERANCE = 1e-15  # relative to gravity


def is_paper(model, *_):
    """Return True if a model is the paper's, from numba's type of it."""
    return "paper" in model.names


def of_paper(column, *_):
    """Return True if the model of a column is the paper's, from numba's type of it."""
    return is_paper(column.types[0])


sweep_rows = FieldTable(  # scratch of the sweeps, over the row of work.room
    "theta",  # rad
    "opening",  # m
    "horizontal",  # N, sum of m_j a_gj over the blocks above joint i: minus the shear (eq. 20)
    "residual",
).over


@leaf
def tilt(blocks, row, i, n):
    """Return the rotation of block i (rad) from displacements in a row, or its rate from velocities; 0 for the base."""
    return less_below(row, i, n) / blocks.height[i] if i < n else 0.0


@kernel
def factorize_mass(model):
    """Factorize the tridiagonal B' m B + C' H^-1 I H^-1 C as LDL' (theory.md section 3).

    `blocks` holds the inverse pivots (1/kg) and the multipliers.
    """
    blocks = model.blocks
    above = 0.0  # contribution of the block above to the diagonal
    side = 0.0  # between it and this block
    pivot = 1.0
    for i in range(model.n):
        mass, height = blocks.mass[i], blocks.height[i]
        # elements of the block in the matrix
        low = blocks.centroid[i] / height
        high = 1.0 - low
        turning = blocks.inertia[i] / (height * height)
        # eliminate the block above
        multiplier = side / pivot
        pivot = mass * (low * low) + turning + above - side * multiplier
        above = mass * (high * high) + turning
        side = mass * low * high - turning
        blocks.pivot[i] = 1.0 / pivot
        blocks.coupling[i] = multiplier


@kernel
def settle(model, phase):
    """Fill in the settlements (m) at rest under gravity; other values stay."""
    settle_joints(model, phase)
    settled = 0.0
    for i in range(model.n - 1, -1, -1):
        settled += phase.opening[i]
        phase.opening[i] = -settled


@kernel
def evaluate(column, phase, motion):
    """Compute the accelerations of a phase; those on entry are the first guess. Return a code.

    The code is NOT_CONVERGED when the sweeps do not settle: the displacements are too large for a first-order model.
    `work.joints` holds the resultants.
    """
    model, joints, counts = column.model, column.work.joints, column.counts
    counts.evaluations += 1
    if motion.theta != 0.0 or motion.omega != 0.0 or motion.alpha != 0.0:
        return ROTATES
    # resultants, constant during the sweeps
    n = model.n
    sweeps = sweep_rows(column.work.room.row, n)
    lift = model.settings.gravity + motion.az
    bear(model, phase, joints, column.work.hold, sweeps)
    # sweeps of eqs. 28-31 until the accelerations settle
    for sweep in range(1, MAX_SWEEPS + 1):
        if has_settled(phase, sweep_once(model, phase, motion, joints, sweeps), lift, n):
            # force along each joint: the shear less the part of N
            for i in range(n):
                below = sweeps.theta[i + 1] if i + 1 < n else 0.0
                joints.tangential[i] = sweeps.horizontal[i] - joints.normal[i] * (0.5 * (sweeps.theta[i] + below))
            counts.sweeps += sweep
            return OK
    return NOT_CONVERGED


@evaluate_at.version(of_paper)
def _evaluate_at(column, phase, t):
    return evaluate(column, phase, base_motion(column, t))


@evaluate_after_jump.version(of_paper)
def _evaluate_after_jump(column, phase, motion):
    return evaluate(column, phase, motion)


@leaf
def bear(model, phase, joints, hold, sweeps):
    """Compute rotations, openings and resultants of a phase, which are constant during the sweeps."""
    n, blocks = model.n, model.blocks
    turn, spin = tilt(blocks, phase.theta, 0, n), tilt(blocks, phase.theta_rate, 0, n)
    for i in range(n):
        # opening of joint i, and the rotation of the block below
        opening = -less_below(phase.opening, i, n)
        opening_rate = -less_below(phase.opening_rate, i, n)
        turn_below, spin_below = tilt(blocks, phase.theta, i + 1, n), tilt(blocks, phase.theta_rate, i + 1, n)
        sweeps.theta[i] = turn
        sweeps.opening[i] = opening
        joints.normal[i], joints.moment[i], joints.length[i] = resultants(
            blocks, hold, i, opening, turn - turn_below, opening_rate, spin - spin_below
        )
        turn, spin = turn_below, spin_below


@leaf
def sweep_once(model, phase, motion, joints, sweeps):
    """Do one sweep over the accelerations of a phase; return the largest change (m/s2)."""
    blocks, n, lift = model.blocks, model.n, model.settings.gravity + motion.az
    change = _horizontal_sweep(blocks, phase, motion.ax, lift, joints, sweeps, n)
    return greater(change, _vertical_sweep(blocks, phase, motion.ax, lift, joints, sweeps, n))


@leaf
def has_settled(phase, change, lift, n):
    """Return True if a sweep that changed accelerations by `change` (m/s2) was the last one needed."""
    largest = 0.0 * lift
    for i in range(n):
        largest = greater(largest, magnitude(phase.theta_acceleration[i]))
        largest = greater(largest, magnitude(phase.opening_acceleration[i]))
    return change <= SWEEP_TOLERANCE * largest + REST_TOLERANCE * magnitude(lift)


@leaf
def _inertial(blocks, phase, base_ax, i, n):
    """Return mass times horizontal acceleration of the centroid of block i (N)."""
    top = phase.theta_acceleration[i]
    below = phase.theta_acceleration[i + 1] if i + 1 < n else 0.0
    share = (blocks.centroid[i] * top + blocks.upper[i] * below) / blocks.height[i]
    return blocks.mass[i] * (base_ax + share)


@kernel
def _horizontal_sweep(blocks, phase, base_ax, lift, joints, sweeps, n):
    """Solve the moment equations, v'' -= M_v^-1 residual; return the largest change (m/s2)."""
    # residual of row i about joint i, less row i - 1, divided by H_i, less that of block i - 1
    shear = 0.0  # sum of m_j a_gj, blocks above
    weight = 0.0  # sum of m_j (g - w''_j)
    moment_above = 0.0
    opening_above = 0.0
    row_above = 0.0
    pushed = 0.0  # forward substitution with the unit lower factor
    for i in range(n):
        height, centroid = blocks.height[i], blocks.centroid[i]
        inertial = _inertial(blocks, phase, base_ax, i, n)
        opening = sweeps.opening[i]
        heavy = blocks.mass[i] * (lift - phase.opening_acceleration[i])
        moment = joints.moment[i]
        residual = (
            (centroid + 0.5 * opening) * inertial
            + (height + 0.5 * (opening + opening_above)) * shear
            + blocks.inertia[i] * less_below(phase.theta_acceleration, i, n) / height
            + (moment - moment_above)
            - sweeps.theta[i] * (centroid * heavy + height * weight)
        ) / height
        pushed = residual - row_above - blocks.coupling[i] * pushed
        sweeps.residual[i] = pushed
        row_above = residual
        shear += inertial
        weight += heavy
        moment_above = moment
        opening_above = opening
    change = 0.0
    correction = 0.0
    # back substitution, and correction of the accelerations
    for i in range(n - 1, -1, -1):
        here = sweeps.residual[i] * blocks.pivot[i]
        if i + 1 < n:
            here -= blocks.coupling[i + 1] * correction
        correction = here
        phase.theta_acceleration[i] -= correction
        change = greater(change, magnitude(correction))
    return change


@kernel
def _vertical_sweep(blocks, phase, base_ax, lift, joints, sweeps, n):
    """Solve the normal equations, m_i w''_i from joint forces and latest shears; return the largest change (m/s2)."""
    change = 0.0
    shear = 0.0
    carried = 0.0  # thbar * sum of m_j a_gj, joint above
    normal_above = 0.0
    for i in range(n):
        theta_below = sweeps.theta[i + 1] if i + 1 < n else 0.0
        shear += _inertial(blocks, phase, base_ax, i, n)
        sweeps.horizontal[i] = shear
        # vertical component of the shear along the inclined joint
        tilted = 0.5 * (sweeps.theta[i] + theta_below) * shear
        normal = joints.normal[i]
        value = lift + ((normal_above - normal) + (tilted - carried)) / blocks.mass[i]
        change = greater(change, magnitude(value - phase.opening_acceleration[i]))
        phase.opening_acceleration[i] = value
        carried = tilted
        normal_above = normal
    return change
