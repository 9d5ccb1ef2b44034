"""Either formulation behind one acceleration and one output row."""

import math

from .exact import TANGENTIAL, exact_accelerations, exact_top_motion
from .jit import kernel, leaf
from .joint import joint_peak_pressure
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
    DAMPING,
    EVALUATIONS,
    EXACT,
    FORMULATION,
    GRAVITY,
    HEIGHT,
    INPUT_AMPLITUDE,
    INPUT_AX,
    INPUT_AZ,
    INPUT_BASE_ALPHA,
    INPUT_BASE_OMEGA,
    INPUT_BASE_THETA,
    INPUT_JX,
    INPUT_JZ,
    INPUT_OMEGA,
    INPUT_PHASE,
    INPUT_T0,
    JOINT_LENGTH,
    JOINT_MOMENT,
    JOINT_NORMAL,
    JOINT_WIDTH,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    N_PHASES,
    OK,
    ROTATES,
    ROW_CONTACT,
    ROW_FIELDS,
    ROW_FX,
    ROW_FZ,
    ROW_M,
    ROW_MY,
    ROW_N,
    ROW_S,
    ROW_SIGMA,
    ROW_THETA,
    ROW_UX,
    ROW_UZ,
    SCRATCH_FIELDS,
    STIFFNESS,
    SWEEPS,
    TANGENT_FIELDS,
    TOP_BETWEEN,
    WORK_FIELDS,
)
from .paper import SUM_HORIZONTAL, paper_accelerations


@kernel
def scratch_offset(n):
    """Where the scratch of the acceleration kernels begins in the work array."""
    return 6 * N_PHASES * n


@kernel
def tangent_offset(n):
    """Where the scratch of the implicit solution begins in the work array."""
    return (6 * N_PHASES + WORK_FIELDS) * n


@kernel
def modal_offset(n):
    """Where the scratch of the modal method begins in the work array."""
    return (6 * N_PHASES + WORK_FIELDS + TANGENT_FIELDS) * n


@kernel
def base_acceleration(inputs, t):
    """Base acceleration (a_x, a_z) in m/s2 at time t."""
    past = t - inputs[INPUT_T0]
    ax = inputs[INPUT_AX] + inputs[INPUT_JX] * past
    if inputs[INPUT_AMPLITUDE] != 0.0:
        ax += inputs[INPUT_AMPLITUDE] * math.sin(inputs[INPUT_OMEGA] * t + inputs[INPUT_PHASE])
    return ax, inputs[INPUT_AZ] + inputs[INPUT_JZ] * past


@leaf
def base_rotates(inputs):
    """Whether the base is turned or turning."""
    turned = inputs[INPUT_BASE_THETA] != 0.0 or inputs[INPUT_BASE_OMEGA] != 0.0
    return turned or inputs[INPUT_BASE_ALPHA] != 0.0


@kernel
def base_motion(inputs, t):
    """Motion of the base at time t: (a_x, a_z, theta, omega, alpha), m/s2, rad clockwise, rad/s, rad/s2."""
    ax, az = base_acceleration(inputs, t)
    past = t - inputs[INPUT_T0]
    omega = inputs[INPUT_BASE_OMEGA]
    alpha = inputs[INPUT_BASE_ALPHA]
    return ax, az, inputs[INPUT_BASE_THETA] + past * (omega + 0.5 * past * alpha), omega + past * alpha, alpha


@leaf
def accelerate_on(model, x, o, base, work, counters):
    """As `accelerate`, upon a base that moves as told: as `base_motion` returns it."""
    scratch = scratch_offset(int(model[N_BLOCKS]))
    counters[EVALUATIONS] += 1
    if model[FORMULATION] == EXACT:
        exact_accelerations(model, x, o, base, work, scratch)
        return OK
    base_ax, base_az, turn, spin, alpha = base
    if turn != 0.0 or spin != 0.0 or alpha != 0.0:
        return ROTATES
    sweeps = paper_accelerations(model, x, o, base_ax, base_az, work, scratch)
    if sweeps < 0:
        return sweeps
    counters[SWEEPS] += sweeps
    return OK


@kernel
def accelerate(model, inputs, x, o, t, work, counters):
    """Accelerations of the phase at x[o:], at time t; the joints' resultants are left in the scratch. Returns a code.

    The iterated formulation takes what stands in the place of the accelerations as its first guess.
    """
    return accelerate_on(model, x, o, base_motion(inputs, t), work, counters)


@kernel
def rotation(model, x, o, i):
    """Rotation of block i of the phase at x[o:] relative to the base, rad clockwise, or its rate; i = n is the base."""
    n = int(model[N_BLOCKS])
    if i >= n:
        return 0.0
    if model[FORMULATION] == EXACT:
        return x[o + i]
    below = x[o + i + 1] if i + 1 < n else 0.0
    return (x[o + i] - below) / model[MODEL_HEADER + BLOCK_FIELDS * i + HEIGHT]


@kernel
def reach_of(model, x, o, i):
    """No less than what block i adds to |u_x|, m, or to its rate where x[o:] are rates."""
    n = int(model[N_BLOCKS])
    if model[FORMULATION] == EXACT:
        return model[MODEL_HEADER + BLOCK_FIELDS * i + HEIGHT] * abs(x[o + i]) + abs(x[o + n + i])
    below = x[o + i + 1] if i + 1 < n else 0.0
    return abs(x[o + i] - below)


@kernel
def top_motion(model, x, o, out, at, base_turn=0.0, base_spin=0.0):
    """Displacement (m) and velocity (m/s) of the top faces relative to the base: out[at:at + 2 n]."""
    n = int(model[N_BLOCKS])
    if model[FORMULATION] == EXACT:
        exact_top_motion(model, x, o, out, at, base_turn, base_spin)
    else:
        for i in range(n):
            out[at + i] = x[o + i]
            out[at + n + i] = x[o + 2 * n + i]


@kernel
def observe(model, x, o, base, work, counters, rows, r):
    """Fill output row r with everything visible of the phase at x[o:], and its accelerations. Returns a code.

    base: as `base_motion` returns it.
    """
    n = int(model[N_BLOCKS])
    exact = model[FORMULATION] == EXACT
    code = accelerate_on(model, x, o, base, work, counters)
    if code != OK:
        return code
    base_turn = base[2]
    scratch = scratch_offset(n)
    top = scratch + TOP_BETWEEN * n
    top_motion(model, x, o, work, top, base_turn, base[3])
    tail = ROW_FIELDS * n
    rise = 0.0  # of the top face of the block below
    lift = model[GRAVITY] + base[1]
    for i in range(n - 1, -1, -1):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        turn = rotation(model, x, o, i)
        turn_below = rotation(model, x, o, i + 1)
        spin = rotation(model, x, o + 2 * n, i)
        spin_below = rotation(model, x, o + 2 * n, i + 1)
        normal = work[scratch + SCRATCH_FIELDS * i + JOINT_NORMAL]
        opening = x[o + n + i]
        opening_rate = x[o + 3 * n + i]
        if exact:
            half = 0.5 * (turn - turn_below)
            slope = 2.0 * math.sin(half)
            slope_rate = math.cos(half) * (spin - spin_below)
            phi = 0.5 * (turn + turn_below) + base_turn
            dip = -2.0 * math.sin(0.5 * (turn + base_turn)) ** 2  # cos(turn) - 1
            rise += opening * math.cos(phi)
            rows[r, ROW_UZ * n + i] = rise + model[row + CENTROID] * dip
            rise += model[row + HEIGHT] * dip
            tangential = work[scratch + SCRATCH_FIELDS * i + TANGENTIAL]
            rows[r, ROW_S * n + i] = -(normal * math.sin(phi) + tangential * math.cos(phi))
            if i == n - 1:
                rows[r, tail + ROW_FZ] = -(normal * math.cos(phi) - tangential * math.sin(phi))
                moment = work[scratch + SCRATCH_FIELDS * i + JOINT_MOMENT] * math.cos(half)
                rows[r, tail + ROW_MY] = moment - 0.5 * opening * tangential
        else:
            slope = turn - turn_below
            slope_rate = spin - spin_below
            rows[r, ROW_UZ * n + i] = -opening
            below = x[o + n + i + 1] if i + 1 < n else 0.0
            below_rate = x[o + 3 * n + i + 1] if i + 1 < n else 0.0
            opening = below - opening
            opening_rate = below_rate - opening_rate
            rows[r, ROW_S * n + i] = -work[scratch + SCRATCH_FIELDS * i + SUM_HORIZONTAL]
            if i == n - 1:
                rows[r, tail + ROW_MY] = work[scratch + SCRATCH_FIELDS * i + JOINT_MOMENT]
        rows[r, ROW_UX * n + i] = work[top + i]
        rows[r, ROW_THETA * n + i] = turn + base_turn
        rows[r, ROW_N * n + i] = normal
        rows[r, ROW_M * n + i] = work[scratch + SCRATCH_FIELDS * i + JOINT_MOMENT]
        rows[r, ROW_CONTACT * n + i] = work[scratch + SCRATCH_FIELDS * i + JOINT_LENGTH] / model[row + JOINT_WIDTH]
        rows[r, ROW_SIGMA * n + i] = joint_peak_pressure(
            model[row + STIFFNESS],
            model[row + JOINT_WIDTH],
            model[row + DAMPING],
            opening,
            slope,
            opening_rate,
            slope_rate,
        )
    if not exact:
        weight = 0.0
        for i in range(n):
            weight += model[MODEL_HEADER + BLOCK_FIELDS * i + MASS] * (lift - x[o + 5 * n + i])
        rows[r, tail + ROW_FZ] = -weight
    rows[r, tail + ROW_FX] = rows[r, ROW_S * n + n - 1]
    return OK
