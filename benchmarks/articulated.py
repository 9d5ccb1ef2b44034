"""The articulated-body recursion that the evaluation by forces along the joints replaced, for comparison in one run.

It minimizes Gauss's function (Gauss 1829; the articulated-body algorithm of Featherstone 1983 in planar form). The part
above joint i, seen from the top face of block i + 1, is a linear map from the acceleration of that face to the force it
needs. The pass down adds to block i the part above it and eliminates its two unknowns; the pass up finds them from the
acceleration of the base. It shares no kernel with the solver; its joint law is also the one of that time.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from solver import Column
from solver.kernels.layout import spaces as at

PHASE_FIELDS = at.PHASE.per_n

Array = NDArray[np.float64]
OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False, "nogil": True, "_nrt": False}
_leaf = njit(forceinline=True, **OPTIONS)

# data of a block and of the joint under it, one row each
HEIGHT, CENTROID, MASS, INERTIA, STIFFNESS, WIDTH, DEPTH, DAMPING = range(8)
BLOCK_FIELDS = 8
# results of the pass down for the pass up, linear in the acceleration s along the joint: one row for each block
ALPHA_S, ALPHA_0, OPEN_S, OPEN_0, ABOVE_S, ABOVE_0, RISE_S, RISE_0, FORCE_S, FORCE_0 = range(10)
TANGENTIAL, NORMAL, MOMENT, LENGTH = range(10, 14)
SCRATCH_FIELDS = 14
SMALL = 0.03  # rad: below this the polynomials are exact to rounding


def rows_of(column: Column) -> Array:
    """Return the column as `accelerations` takes it, (n * BLOCK_FIELDS,)."""
    rows = [
        (
            block.height,
            block.resolved_centroid,
            block.mass,
            block.resolved_inertia,
            block.joint.stiffness,
            block.joint_width,
            block.joint_depth,
            block.joint.damping,
        )
        for block in column.blocks
    ]
    return np.array(rows).ravel()


def scratch_of(column: Column) -> Array:
    """Return scratch array for `accelerations`."""
    return np.zeros(SCRATCH_FIELDS * column.n)


@_leaf
def _place(index):
    """Return the index, known not to be negative."""
    return index & 0xFFFFFFFFFF


@_leaf
def _sine_cosine(x):
    if abs(x) > SMALL:
        return math.sin(x), math.cos(x)
    y = x * x
    sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 - y * (1.0 / 5040.0))))
    cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 - y * (1.0 / 720.0)))
    return sine, cosine


@_leaf
def _positive_part(value, slope, lo, hi):
    if slope > 0.0:
        return max(lo, -value / slope), hi
    if slope < 0.0:
        return lo, min(hi, -value / slope)
    if value > 0.0:
        return lo, hi
    return hi, hi


@_leaf
def _joint_forces(stiffness, width, depth, damping, opening, slope, opening_rate, slope_rate):
    lo, hi = _positive_part(-opening, slope, -0.5 * width, 0.5 * width)
    if damping > 0.0 and lo < hi:
        lo, hi = _positive_part(-opening - damping * opening_rate, slope + damping * slope_rate, lo, hi)
    if not hi > lo:
        return 0.0, 0.0, 0.0
    length = hi - lo
    mean = -(opening + damping * opening_rate)
    gradient = slope + damping * slope_rate
    middle = 0.5 * (lo + hi)
    rigidity = stiffness * depth * length
    force = rigidity * (mean + gradient * middle)
    return force, middle * force + rigidity * gradient * (length * length) / 12.0, length


@njit(**OPTIONS)
def accelerations(rows, n, gravity, x, o, base, work):
    """Compute the accelerations of the phase at x[o:] (6 n) from its coordinates and rates.

    base: (a_x, a_z, theta, omega, alpha), m/s2, rad clockwise, rad/s, rad/s2. work holds the resultants afterwards.
    """
    along, lift, base_turn, base_spin, base_alpha = base
    n = _place(n)
    mu = 0.0  # the part above block i, in the frame of joint i - 1
    lever = 0.0  # half the opening of joint i - 1
    push_n = 0.0
    push_t = 0.0
    torque = 0.0
    cos_above = 1.0  # of half the relative rotation of joint i - 1
    sin_above = 0.0
    c_t_above = 0.0  # velocity terms of the top face of block i - 1, in the frame of joint i - 1
    c_n_above = 0.0
    turn = x[_place(o)]
    spin = x[_place(o) + 2 * n] + base_spin
    for i in range(n):
        row = _place(BLOCK_FIELDS * i)
        out = _place(SCRATCH_FIELDS * i)
        q = _place(o + i)
        height = rows[row + HEIGHT]
        mass = rows[row + MASS]
        over = height - rows[row + CENTROID]
        opening = x[q + n]
        opening_rate = x[q + 3 * n]
        turn_below = 0.0
        spin_below = base_spin
        if i + 1 < n:
            turn_below = x[q + 1]
            spin_below += x[q + 2 * n + 1]
        sin_half, cos_half = _sine_cosine(0.5 * (turn - turn_below))
        mean_spin = 0.5 * (spin + spin_below)
        normal, moment, length = _joint_forces(
            rows[row + STIFFNESS],
            rows[row + WIDTH],
            rows[row + DEPTH],
            rows[row + DAMPING],
            opening,
            2.0 * sin_half,
            opening_rate,
            cos_half * (spin - spin_below),
        )
        moment_turn = moment * cos_half
        half_opening = 0.5 * opening
        b_t = half_opening + height * cos_half  # acceleration of the top face for a unit alpha
        b_n = -height * sin_half
        fling = height * spin * spin
        c_t = 2.0 * opening_rate * mean_spin - fling * sin_half
        c_n = -opening * mean_spin * mean_spin - fling * cos_half
        # the part above, turned into the frame of this joint, and the block itself
        cos_beta = cos_above * cos_half - sin_above * sin_half
        sin_beta = sin_above * cos_half + cos_above * sin_half
        swing = mass * over
        centripetal = swing * spin * spin
        pull = mu * lever
        m_nn = mass + mu * (sin_beta * sin_beta)
        m_nt = -mu * (sin_beta * cos_beta)
        j_t = pull * cos_beta - swing * cos_half
        j_n = swing * sin_half - pull * sin_beta
        j_a = pull * lever + (swing * over + rows[row + INERTIA])
        p_t = (push_n * sin_beta + push_t * cos_beta) + centripetal * sin_half
        p_n = (push_n * cos_beta - push_t * sin_beta) + centripetal * cos_half
        p_a = lever * push_t - torque
        # eliminate the opening, then the rotation
        per_mass = 1.0 / m_nn
        t_scaled = mass * (mass + mu)
        jt_scaled = mass * j_t - swing * mu * (sin_beta * sin_above)
        ja_scaled = j_a * m_nn - j_n * j_n
        free = (normal - p_n) * per_mass
        p_t += m_nt * free
        p_a += j_n * free + (normal * b_n + moment_turn)
        g_scaled = jt_scaled + b_t * t_scaled
        inertia_scaled = ja_scaled + b_t * (jt_scaled + g_scaled)
        per_inertia = 1.0 / inertia_scaled
        alpha_s = -g_scaled * per_inertia
        alpha_0 = -(p_a + b_t * p_t) * (per_inertia * m_nn)
        at_s = 1.0 + b_t * alpha_s
        at_0 = b_t * alpha_0
        an_s = -(j_n * alpha_s + m_nt * at_s) * per_mass
        an_0 = free - (j_n * alpha_0 + m_nt * at_0) * per_mass
        work[out + ALPHA_S] = alpha_s
        work[out + ALPHA_0] = alpha_0
        work[out + OPEN_S] = an_s - b_n * alpha_s
        work[out + OPEN_0] = an_0 - b_n * alpha_0
        work[out + ABOVE_S] = (at_s * cos_beta - an_s * sin_beta) + lever * alpha_s
        work[out + ABOVE_0] = (at_0 * cos_beta - an_0 * sin_beta) + (lever * alpha_0 + c_t_above)
        work[out + RISE_S] = at_s * sin_beta + an_s * cos_beta
        work[out + RISE_0] = at_0 * sin_beta + an_0 * cos_beta + c_n_above
        mu = (t_scaled * ja_scaled - jt_scaled * jt_scaled) / (m_nn * inertia_scaled)
        tau = p_t + g_scaled * per_mass * alpha_0
        work[out + FORCE_S] = mu
        work[out + FORCE_0] = tau
        work[out + NORMAL] = normal
        work[out + MOMENT] = moment
        work[out + LENGTH] = length
        lever = half_opening
        push_n = normal
        push_t = tau + mu * c_t
        torque = moment_turn
        cos_above = cos_half
        sin_above = sin_half
        c_t_above = c_t
        c_n_above = c_n
        turn = turn_below
        spin = spin_below

    # --- upwards: gravity is an upward acceleration of the base, whose joint is turned by theta_n / 2
    lift += gravity
    sine, cosine = _sine_cosine(base_turn)
    along, lift = along * cosine - lift * sine, along * sine + lift * cosine
    c_t_above += lever * base_alpha
    s_t = (along * cos_above - lift * sin_above) + c_t_above
    s_n = (along * sin_above + lift * cos_above) + c_n_above
    for i in range(n - 1, -1, -1):
        out = _place(SCRATCH_FIELDS * i)
        q = _place(o + i)
        x[q + 4 * n] = work[out + ALPHA_S] * s_t + (work[out + ALPHA_0] - base_alpha)
        x[q + 5 * n] = work[out + OPEN_S] * s_t + (work[out + OPEN_0] - s_n)
        work[out + TANGENTIAL] = work[out + FORCE_S] * s_t + work[out + FORCE_0]
        s_n = work[out + RISE_S] * s_t + work[out + RISE_0]
        s_t = work[out + ABOVE_S] * s_t + work[out + ABOVE_0]


@njit(**OPTIONS)
def repeat(rows, n, gravity, phases, rounds, base, work):
    """Compute the accelerations of the phases, flat, one after the other, `rounds` times."""
    for _ in range(rounds):
        for k in range(phases.size // (PHASE_FIELDS * n)):
            accelerations(rows, n, gravity, phases, k * PHASE_FIELDS * n, base, work)
