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
"""

import math

from .jit import kernel
from .joint import joint_forces
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
    STIFFNESS,
)

# scratch fields of the recursion, n numbers each
COS_BETA = 0  # turn from the frame of joint i to the frame of joint i - 1
SIN_BETA = 1
C_T = 2  # velocity terms of the top face of block i
C_N = 3
B_T = 4  # acceleration of the top face for a unit alpha_i
B_N = 5
ALPHA_S = 6  # alpha_i = ALPHA_S * s_t + ALPHA_0
ALPHA_0 = 7
NORMAL_0 = 8  # a_n = NORMAL_0 + NORMAL_A * alpha_i + NORMAL_T * a_t
NORMAL_A = 9
NORMAL_T = 10
MU = 11  # tangential force through the joint = MU * s_t + TAU
TAU = 12


@kernel
def exact_accelerations(model, x, o, base_ax, base_az, work, scratch):
    """Accelerations of the phase at x[o:], from its coordinates and rates; returns nothing.

    base_ax, base_az: m/s2. The scratch fields hold the resultants of every joint afterwards.
    """
    n = int(model[N_BLOCKS])
    # --- downwards: collect the part above, eliminate the block's own unknowns
    mu = 0.0  # the part above block i, in the frame of joint i - 1
    lever = 0.0  # half the opening of joint i - 1
    push_n = 0.0
    push_t = 0.0
    torque = 0.0
    cos_above = 1.0  # of half the relative rotation of joint i - 1
    sin_above = 0.0
    for i in range(n):
        row = MODEL_HEADER + BLOCK_FIELDS * i
        height = model[row + HEIGHT]
        mass = model[row + MASS]
        over = height - model[row + CENTROID]  # from the centroid to the top face
        turn = x[o + i]
        spin = x[o + 2 * n + i]
        opening = x[o + n + i]
        opening_rate = x[o + 3 * n + i]
        turn_below = 0.0
        spin_below = 0.0
        if i + 1 < n:
            turn_below = x[o + i + 1]
            spin_below = x[o + 2 * n + i + 1]
        half = 0.5 * (turn - turn_below)
        cos_half = math.cos(half)
        sin_half = math.sin(half)
        mean_spin = 0.5 * (spin + spin_below)
        normal, moment, length = joint_forces(
            model[row + STIFFNESS],
            model[row + JOINT_WIDTH],
            model[row + JOINT_DEPTH],
            model[row + DAMPING],
            opening,
            2.0 * sin_half,
            opening_rate,
            cos_half * (spin - spin_below),
        )
        moment_turn = moment * cos_half  # conjugate to the relative rotation

        # the part above, turned into the frame of this joint
        cos_beta = cos_above * cos_half - sin_above * sin_half
        sin_beta = sin_above * cos_half + cos_above * sin_half
        m_tt = mu * cos_beta * cos_beta
        m_nt = -mu * sin_beta * cos_beta
        m_nn = mu * sin_beta * sin_beta
        j_t = mu * lever * cos_beta
        j_n = -mu * lever * sin_beta
        j_a = mu * lever * lever
        p_t = push_n * sin_beta + push_t * cos_beta
        p_n = push_n * cos_beta - push_t * sin_beta
        p_a = lever * push_t - torque
        # the block itself
        swing = mass * over
        centripetal = swing * spin * spin
        m_tt += mass
        m_nn += mass
        j_t -= swing * cos_half
        j_n += swing * sin_half
        j_a += swing * over + model[row + INERTIA]
        p_t += centripetal * sin_half
        p_n += centripetal * cos_half
        # eliminate the opening: the normal force is known
        b_t = 0.5 * opening + height * cos_half
        b_n = -height * sin_half
        free = (normal - p_n) / m_nn
        per_alpha = -j_n / m_nn
        per_t = -m_nt / m_nn
        m_tt += m_nt * per_t
        j_t += m_nt * per_alpha
        j_a += j_n * per_alpha
        p_t += m_nt * free
        p_a += j_n * free + normal * b_n + moment_turn
        # eliminate the rotation
        g = j_t + b_t * m_tt
        inertia = j_a + b_t * (j_t + g)
        alpha_s = -g / inertia
        alpha_0 = -(p_a + b_t * p_t) / inertia
        mu = m_tt + g * alpha_s
        tau = p_t + g * alpha_0
        # hand over to the block below
        c_t = 2.0 * opening_rate * mean_spin - height * spin * spin * sin_half
        c_n = -opening * mean_spin * mean_spin - height * spin * spin * cos_half
        lever = 0.5 * opening
        push_n = normal
        push_t = tau + mu * c_t
        torque = moment_turn
        cos_above = cos_half
        sin_above = sin_half

        work[scratch + COS_BETA * n + i] = cos_beta
        work[scratch + SIN_BETA * n + i] = sin_beta
        work[scratch + C_T * n + i] = c_t
        work[scratch + C_N * n + i] = c_n
        work[scratch + B_T * n + i] = b_t
        work[scratch + B_N * n + i] = b_n
        work[scratch + ALPHA_S * n + i] = alpha_s
        work[scratch + ALPHA_0 * n + i] = alpha_0
        work[scratch + NORMAL_0 * n + i] = free
        work[scratch + NORMAL_A * n + i] = per_alpha
        work[scratch + NORMAL_T * n + i] = per_t
        work[scratch + MU * n + i] = mu
        work[scratch + TAU * n + i] = tau
        work[scratch + JOINT_NORMAL * n + i] = normal
        work[scratch + JOINT_MOMENT * n + i] = moment
        work[scratch + JOINT_LENGTH * n + i] = length

    # --- upwards: gravity is an upward acceleration of the base
    phi = 0.5 * x[o + n - 1]
    cos_phi = math.cos(phi)
    sin_phi = math.sin(phi)
    lift = base_az + model[GRAVITY]
    a_t = base_ax * cos_phi - lift * sin_phi
    a_n = base_ax * sin_phi + lift * cos_phi
    alpha = 0.0
    for i in range(n - 1, -1, -1):
        s_t = a_t + 0.5 * x[o + n + i] * alpha + work[scratch + C_T * n + i]
        s_n = a_n + work[scratch + C_N * n + i]
        alpha = work[scratch + ALPHA_S * n + i] * s_t + work[scratch + ALPHA_0 * n + i]
        a_t = s_t + work[scratch + B_T * n + i] * alpha
        a_n = (
            work[scratch + NORMAL_0 * n + i]
            + work[scratch + NORMAL_A * n + i] * alpha
            + work[scratch + NORMAL_T * n + i] * a_t
        )
        x[o + 4 * n + i] = alpha
        x[o + 5 * n + i] = a_n - s_n - work[scratch + B_N * n + i] * alpha
        work[scratch + TAU * n + i] += work[scratch + MU * n + i] * s_t  # now the tangential force
        # into the frame of the joint above; the turn there is stored with this block
        cos_beta = work[scratch + COS_BETA * n + i]
        sin_beta = work[scratch + SIN_BETA * n + i]
        a_t, a_n = a_t * cos_beta - a_n * sin_beta, a_t * sin_beta + a_n * cos_beta


@kernel
def exact_top_motion(model, x, o, out, at):
    """Horizontal displacement (m) and velocity (m/s) of the top faces, relative to the base: out[at:at + 2 n]."""
    n = int(model[N_BLOCKS])
    displacement = 0.0
    velocity = 0.0
    turn_below = 0.0
    spin_below = 0.0
    for i in range(n - 1, -1, -1):
        height = model[MODEL_HEADER + BLOCK_FIELDS * i + HEIGHT]
        turn = x[o + i]
        opening = x[o + n + i]
        spin = x[o + 2 * n + i]
        phi = 0.5 * (turn + turn_below)
        sin_phi = math.sin(phi)
        displacement += opening * sin_phi + height * math.sin(turn)
        velocity += (
            x[o + 3 * n + i] * sin_phi
            + opening * 0.5 * (spin + spin_below) * math.cos(phi)
            + height * spin * math.cos(turn)
        )
        out[at + i] = displacement
        out[at + n + i] = velocity
        turn_below = turn
        spin_below = spin
