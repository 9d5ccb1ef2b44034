"""Formulation `exact`: finite rotations (theory.md section 4) in O(n) operations.

The recursion minimizes Gauss's function (Gauss 1829; the articulated-body algorithm of Featherstone 1983 in planar
form). Everything above joint i, seen from the top face of block i+1, is a linear map from the acceleration of that
face to the force it needs. Because joint i is rigid along its tangent t and transmits the known force N along its
normal n, the map has one inertia only:

    force on the part above  =  N n + (mu * s_t + tau) t,     s = a_(i+1) + (delta_i / 2) alpha_(i+1) t + c_i

with a_(i+1) the acceleration of the centre of the top face of block i+1 and c_i the velocity terms. Going down, block
i joins the part above it and its own two unknowns (alpha_i, delta_i'') are eliminated; going up, they follow from the
base acceleration, to which gravity is added. mu at joint n is the effective mass of the column along that joint.

Components are taken along (t, n) of each joint, turned by phi_i = (theta_i + theta_(i+1)) / 2; only differences of
rotations enter until the base.

The base is the lowest body of the chain, with prescribed motion. The coordinates are rotations relative to it, so that
joints, tangents and interpolation are the same whether it rotates or not; spins in here are absolute.
"""

import math

from .jit import kernel, leaf, place
from .joint import ANY, joint_forces, regime_margin
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
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
    SCRATCH_FIELDS,
    STIFFNESS,
)

# scratch fields of a block: what the way down leaves for the way up, linear in s = s_t
ALPHA_S = 0  # alpha_i = ALPHA_S * s + ALPHA_0
ALPHA_0 = 1
OPEN_S = 2  # delta_i'' = OPEN_S * s + OPEN_0 - s_n
OPEN_0 = 3
ABOVE_S = 4  # s of the joint above = ABOVE_S * s + ABOVE_0
ABOVE_0 = 5
RISE_S = 6  # s_n of the joint above = RISE_S * s + RISE_0
RISE_0 = 7
FORCE_S = 8  # tangential force through the joint = FORCE_S * s + FORCE_0
FORCE_0 = 9
TANGENTIAL = 10  # N, that force once s is known
LOCK = 11  # regime that the joint is held in; 0 is whichever applies
REGIME = 12  # that it was last held in
LEFT = 13  # 1 if an evaluation found it outside
SMALL = 0.03  # rad: below this the polynomials are exact to rounding


@leaf
def sine_cosine(x):
    """sin(x) and cos(x); Taylor polynomials where the rest of the series is below rounding."""
    if abs(x) > SMALL:
        return math.sin(x), math.cos(x)
    y = x * x
    sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 - y * (1.0 / 5040.0))))
    cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 - y * (1.0 / 720.0)))
    return sine, cosine


@kernel
def exact_accelerations(model, x, o, base, work, scratch):
    """Accelerations of the phase at x[o:], from its coordinates and rates; returns nothing.

    base: motion of the centre of its face, (a_x, a_z, theta, omega, alpha), m/s2, rad clockwise, rad/s, rad/s2. The
    scratch fields hold the resultants of every joint afterwards.
    """
    n = place(int(model[N_BLOCKS]))
    along, lift, base_turn, base_spin, base_alpha = base
    # --- downwards: collect the part above, eliminate the block's own unknowns
    mu = 0.0  # the part above block i, in the frame of joint i - 1
    lever = 0.0  # half the opening of joint i - 1
    push_n = 0.0
    push_t = 0.0
    torque = 0.0
    cos_above = 1.0  # of half the relative rotation of joint i - 1
    sin_above = 0.0
    c_t_above = 0.0  # velocity terms of the top face of block i - 1, in the frame of joint i - 1
    c_n_above = 0.0
    turn = x[place(o)]
    spin = x[place(o) + 2 * n] + base_spin
    for i in range(n):
        row = place(MODEL_HEADER + BLOCK_FIELDS * i)
        out = place(scratch + SCRATCH_FIELDS * i)
        q = place(o + i)
        height = model[row + HEIGHT]
        mass = model[row + MASS]
        over = height - model[row + CENTROID]  # from the centroid to the top face
        opening = x[q + n]
        opening_rate = x[q + 3 * n]
        turn_below = 0.0
        spin_below = base_spin
        if i + 1 < n:
            turn_below = x[q + 1]
            spin_below += x[q + 2 * n + 1]
        sin_half, cos_half = sine_cosine(0.5 * (turn - turn_below))
        mean_spin = 0.5 * (spin + spin_below)
        width = model[row + JOINT_WIDTH]
        damping = model[row + DAMPING]
        slope = 2.0 * sin_half
        slope_rate = cos_half * (spin - spin_below)
        regime = int(work[out + LOCK])
        normal, moment, length = joint_forces(
            model[row + STIFFNESS],
            width,
            model[row + JOINT_DEPTH],
            damping,
            opening,
            slope,
            opening_rate,
            slope_rate,
            regime,
        )
        if regime != ANY and regime_margin(regime, width, damping, opening, slope, opening_rate, slope_rate) < 0.0:
            work[out + LEFT] = 1.0
        moment_turn = moment * cos_half  # conjugate to the relative rotation
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
        j_a = pull * lever + (swing * over + model[row + INERTIA])
        p_t = (push_n * sin_beta + push_t * cos_beta) + centripetal * sin_half
        p_n = (push_n * cos_beta - push_t * sin_beta) + centripetal * cos_half
        p_a = lever * push_t - torque
        # eliminate the opening, the normal force being known; inertias are scaled by m_nn, in which form the
        # determinant of the translational inertia is simple: the part above is inert in one direction only
        per_mass = 1.0 / m_nn
        t_scaled = mass * (mass + mu)
        jt_scaled = mass * j_t - swing * mu * (sin_beta * sin_above)
        ja_scaled = j_a * m_nn - j_n * j_n
        free = (normal - p_n) * per_mass
        p_t += m_nt * free
        p_a += j_n * free + (normal * b_n + moment_turn)
        # eliminate the rotation
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
        work[out + JOINT_NORMAL] = normal
        work[out + JOINT_MOMENT] = moment
        work[out + JOINT_LENGTH] = length
        # hand over to the block below
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
    lift += model[GRAVITY]
    sine, cosine = sine_cosine(base_turn)
    along, lift = along * cosine - lift * sine, along * sine + lift * cosine
    c_t_above += lever * base_alpha
    s_t = (along * cos_above - lift * sin_above) + c_t_above
    s_n = (along * sin_above + lift * cos_above) + c_n_above
    for i in range(n - 1, -1, -1):
        out = place(scratch + SCRATCH_FIELDS * i)
        q = place(o + i)
        x[q + 4 * n] = work[out + ALPHA_S] * s_t + (work[out + ALPHA_0] - base_alpha)
        x[q + 5 * n] = work[out + OPEN_S] * s_t + (work[out + OPEN_0] - s_n)
        work[out + TANGENTIAL] = work[out + FORCE_S] * s_t + work[out + FORCE_0]
        s_n = work[out + RISE_S] * s_t + work[out + RISE_0]
        s_t = work[out + ABOVE_S] * s_t + work[out + ABOVE_0]


@kernel
def exact_top_motion(model, x, o, out, at, base_turn=0.0, base_spin=0.0):
    """Horizontal displacement (m) and velocity (m/s) of the top faces, relative to the base: out[at:at + 2 n].

    base_turn, base_spin: rotation of the base, rad clockwise, and its rate.
    """
    n = int(model[N_BLOCKS])
    displacement = 0.0
    velocity = 0.0
    turn_below = base_turn
    spin_below = base_spin
    for i in range(n - 1, -1, -1):
        height = model[MODEL_HEADER + BLOCK_FIELDS * i + HEIGHT]
        turn = x[o + i] + base_turn
        opening = x[o + n + i]
        spin = x[o + 2 * n + i] + base_spin
        sine, cosine = sine_cosine(turn)
        sin_phi, cos_phi = sine_cosine(0.5 * (turn + turn_below))
        displacement += opening * sin_phi + height * sine
        velocity += x[o + 3 * n + i] * sin_phi + opening * 0.5 * (spin + spin_below) * cos_phi + height * spin * cosine
        out[at + i] = displacement
        out[at + n + i] = velocity
        turn_below = turn
        spin_below = spin
