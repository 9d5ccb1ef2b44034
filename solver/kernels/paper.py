"""Formulation `paper`: the first-order model (theory.md section 3) solved by Gauss-Seidel reanalysis.

The paper's rows, joint by joint, are premultiplied by T^-1 and divided by the heights (theory.md section 3, last
paragraph): horizontally the constant mass matrix is then tridiagonal and symmetric, vertically diagonal, and it is
factorized once (packing). A sweep solves the horizontal rows with the latest vertical accelerations and then the
vertical rows with the latest horizontal ones, everything that depends on the displacements (dM and df of eqs. 22-23)
taken from the last iterate: the block form of eqs. 28-31, O(n) a sweep. It is written for the accelerations; with
central differences in time the displacements of eq. 27 follow from them.
"""

from .jit import kernel
from .joint import joint_forces
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
    COUPLING,
    DAMPING,
    GRAVITY,
    HEIGHT,
    INERTIA,
    JOINT_DEPTH,
    JOINT_LENGTH,
    JOINT_MOMENT,
    JOINT_NORMAL,
    JOINT_WIDTH,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    NOT_CONVERGED,
    PIVOT,
    SCRATCH_FIELDS,
    STIFFNESS,
)

# scratch fields, n numbers each
THETA = 0
OPENING = 1
SUM_HORIZONTAL = 2  # sum of m_j a_gj over the blocks above joint i: minus the shear (eq. 20)
RESIDUAL = 3

MAX_SWEEPS = 100
SWEEP_TOLERANCE = 1e-13  # of the largest acceleration
REST_TOLERANCE = 1e-15  # of gravity


@kernel
def paper_accelerations(model, x, o, base_ax, base_az, work, scratch):
    """Accelerations of the phase at x[o:]; what stands there on entry is the first guess. Returns the sweeps made.

    NOT_CONVERGED when the sweeps do not settle: the displacements are beyond a first-order model.
    """
    n = int(model[N_BLOCKS])
    lift = model[GRAVITY] + base_az
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        turn = x[o + i] / model[row + HEIGHT]
        spin = x[o + 2 * n + i] / model[row + HEIGHT]
        opening = -x[o + n + i]
        opening_rate = -x[o + 3 * n + i]
        slope = turn
        slope_rate = spin
        if i + 1 < n:
            below = row + BLOCK_FIELDS
            turn = (x[o + i] - x[o + i + 1]) / model[row + HEIGHT]
            spin = (x[o + 2 * n + i] - x[o + 2 * n + i + 1]) / model[row + HEIGHT]
            next_v = 0.0
            next_rate = 0.0
            if i + 2 < n:
                next_v = x[o + i + 2]
                next_rate = x[o + 2 * n + i + 2]
            slope = turn - (x[o + i + 1] - next_v) / model[below + HEIGHT]
            slope_rate = spin - (x[o + 2 * n + i + 1] - next_rate) / model[below + HEIGHT]
            opening += x[o + n + i + 1]
            opening_rate += x[o + 3 * n + i + 1]
        normal, moment, length = joint_forces(
            model[row + STIFFNESS],
            model[row + JOINT_WIDTH],
            model[row + JOINT_DEPTH],
            model[row + DAMPING],
            opening,
            slope,
            opening_rate,
            slope_rate,
        )
        work[scratch + SCRATCH_FIELDS * i + THETA] = turn
        work[scratch + SCRATCH_FIELDS * i + OPENING] = opening
        work[scratch + SCRATCH_FIELDS * i + JOINT_NORMAL] = normal
        work[scratch + SCRATCH_FIELDS * i + JOINT_MOMENT] = moment
        work[scratch + SCRATCH_FIELDS * i + JOINT_LENGTH] = length

    for sweep in range(1, MAX_SWEEPS + 1):
        change = _horizontal_sweep(model, x, o, base_ax, lift, work, scratch, n)
        change = max(change, _vertical_sweep(model, x, o, base_ax, lift, work, scratch, n))
        largest = 0.0
        for i in range(2 * n):
            largest = max(largest, abs(x[o + 4 * n + i]))
        if change <= SWEEP_TOLERANCE * largest + REST_TOLERANCE * abs(lift):
            return sweep
    return NOT_CONVERGED


@kernel
def _horizontal_sweep(model, x, o, base_ax, lift, work, scratch, n):
    """Moment equations: v'' -= M_v^-1 residual; returns the largest change, m/s2."""
    # residual of row i about joint i, less row i - 1, divided by H_i; less the same of block i - 1
    shear = 0.0  # sum of m_j a_gj, blocks above
    weight = 0.0  # sum of m_j (g - w''_j)
    moment_above = 0.0
    opening_above = 0.0
    row_above = 0.0
    pushed = 0.0  # forward substitution with the unit lower factor
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        height = model[row + HEIGHT]
        centroid = model[row + CENTROID]
        mass = model[row + MASS]
        a_below = 0.0
        if i + 1 < n:
            a_below = x[o + 4 * n + i + 1]
        a_top = x[o + 4 * n + i]
        inertial = mass * (base_ax + (centroid * a_top + (height - centroid) * a_below) / height)
        theta = work[scratch + SCRATCH_FIELDS * i + THETA]
        opening = work[scratch + SCRATCH_FIELDS * i + OPENING]
        heavy = mass * (lift - x[o + 5 * n + i])
        moment = work[scratch + SCRATCH_FIELDS * i + JOINT_MOMENT]
        residual = (
            (centroid + 0.5 * opening) * inertial
            + (height + 0.5 * (opening + opening_above)) * shear
            + model[row + INERTIA] * (a_top - a_below) / height
            + (moment - moment_above)
            - theta * (centroid * heavy + height * weight)
        ) / height
        pushed = residual - row_above - model[row + COUPLING] * pushed
        work[scratch + SCRATCH_FIELDS * i + RESIDUAL] = pushed
        row_above = residual
        shear += inertial
        weight += heavy
        moment_above = moment
        opening_above = opening
    change = 0.0
    correction = 0.0
    for i in range(n - 1, -1, -1):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        correction_here = work[scratch + SCRATCH_FIELDS * i + RESIDUAL] * model[row + PIVOT]
        if i + 1 < n:
            correction_here -= model[row + BLOCK_FIELDS + COUPLING] * correction
        correction = correction_here
        x[o + 4 * n + i] -= correction
        change = max(change, abs(correction))
    return change


@kernel
def _vertical_sweep(model, x, o, base_ax, lift, work, scratch, n):
    """Normal equations: m_i w''_i from the joint forces and the latest shears; returns the largest change, m/s2."""
    change = 0.0
    shear = 0.0
    carried = 0.0  # thbar * sum of m_j a_gj, joint above
    normal_above = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        height = model[row + HEIGHT]
        centroid = model[row + CENTROID]
        mass = model[row + MASS]
        a_below = 0.0
        theta_below = 0.0
        if i + 1 < n:
            a_below = x[o + 4 * n + i + 1]
            theta_below = work[scratch + SCRATCH_FIELDS * (i + 1) + THETA]
        shear += mass * (base_ax + (centroid * x[o + 4 * n + i] + (height - centroid) * a_below) / height)
        work[scratch + SCRATCH_FIELDS * i + SUM_HORIZONTAL] = shear
        tilt = 0.5 * (work[scratch + SCRATCH_FIELDS * i + THETA] + theta_below) * shear
        normal = work[scratch + SCRATCH_FIELDS * i + JOINT_NORMAL]
        value = lift + ((normal_above - normal) + (tilt - carried)) / mass
        change = max(change, abs(value - x[o + 5 * n + i]))
        x[o + 5 * n + i] = value
        carried = tilt
        normal_above = normal
    return change
