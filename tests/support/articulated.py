"""Accelerations by the articulated body of Featherstone (1983): an independent algorithm for the kernels' results.

The part above joint i, seen from the top face of block i + 1, is a linear map from the acceleration of that face to the
force it needs. Because joint i is rigid along its tangent t and transmits the known force N along its normal n, the map
has one inertia only:

    force on the part above  =  N n + (mu * s_t + tau) t,     s = a_(i+1) + (delta_i / 2) alpha_(i+1) t + c_i

with a_(i+1) the acceleration of the centre of the top face of block i + 1 and c_i the velocity terms. The pass down
adds block i to the part above it and eliminates its two unknowns (alpha_i, delta_i''); the pass up finds them from the
base acceleration, to which gravity is added. Components are taken along (t, n) of each joint. The law of the joints is
that of the kernels, which has its own tests.
"""

from __future__ import annotations

import math

import numpy as np

from solver import Column
from support.joints import joint_forces
from support.lagrange import Array

Motion = tuple[float, float, float, float, float]  # of the base: ax, az, theta, omega, alpha


def articulated(column: Column, q: Array, rate: Array, base: Motion) -> tuple[Array, Array, float]:
    """Return the accelerations (2n,) of rotations and openings, forces along the joints on the part above (n,),
    effective mass.

    Rotations are relative to the base, which turns by theta, clockwise.
    """
    n = column.n
    ax, az, theta, omega, alpha = base
    turns, spins = np.append(q[:n], 0.0), np.append(rate[:n], 0.0) + omega
    mu = lever = push_n = push_t = torque = sin_above = c_t_above = c_n_above = 0.0
    cos_above = 1.0
    ways_up = []
    for i, block in enumerate(column.blocks):
        joint, height, mass = block.joint, block.height, block.mass
        over = height - block.resolved_centroid
        opening, opening_rate = q[n + i], rate[n + i]
        spin, mean_spin = spins[i], 0.5 * (spins[i] + spins[i + 1])
        half = 0.5 * (turns[i] - turns[i + 1])
        sine, cosine = math.sin(half), math.cos(half)
        slope_rate = cosine * (spin - spins[i + 1])
        normal, moment, _ = joint_forces(
            joint.stiffness, block.joint_width, block.joint_depth, joint.damping,
            opening, 2.0 * sine, opening_rate, slope_rate,
        )  # fmt: skip
        moment *= cosine
        b_t, b_n = 0.5 * opening + height * cosine, -height * sine  # of the top face for a unit alpha
        c_t = 2.0 * opening_rate * mean_spin - height * spin**2 * sine
        c_n = -opening * mean_spin**2 - height * spin**2 * cosine

        # the part above, turned into the frame of this joint, and the block itself
        cos_beta = cos_above * cosine - sin_above * sine
        sin_beta = sin_above * cosine + cos_above * sine
        swing = mass * over
        m_nn, m_nt, m_tt = mass + mu * sin_beta**2, -mu * sin_beta * cos_beta, mass + mu * cos_beta**2
        j_t = mu * lever * cos_beta - swing * cosine
        j_n = swing * sine - mu * lever * sin_beta
        j_a = mu * lever**2 + swing * over + block.resolved_inertia
        p_t = push_n * sin_beta + push_t * cos_beta + swing * spin**2 * sine
        p_n = push_n * cos_beta - push_t * sin_beta + swing * spin**2 * cosine
        p_a = lever * push_t - torque
        # eliminate the opening, the normal force being known, then the rotation
        free = (normal - p_n) / m_nn
        t_left, jt_left, ja_left = m_tt - m_nt**2 / m_nn, j_t - m_nt * j_n / m_nn, j_a - j_n**2 / m_nn
        p_t += m_nt * free
        p_a += j_n * free + normal * b_n + moment
        met = jt_left + b_t * t_left
        inertia = ja_left + b_t * (jt_left + met)
        alpha_s, alpha_0 = -met / inertia, -(p_a + b_t * p_t) / inertia
        at_s, at_0 = 1.0 + b_t * alpha_s, b_t * alpha_0
        an_s = -(j_n * alpha_s + m_nt * at_s) / m_nn
        an_0 = free - (j_n * alpha_0 + m_nt * at_0) / m_nn
        mu = t_left - met**2 / inertia
        tau = p_t + met * alpha_0
        ways_up.append(
            {
                "alpha": (alpha_s, alpha_0),
                "opening": (an_s - b_n * alpha_s, an_0 - b_n * alpha_0),
                "s_t": (
                    at_s * cos_beta - an_s * sin_beta + lever * alpha_s,
                    at_0 * cos_beta - an_0 * sin_beta + lever * alpha_0 + c_t_above,
                ),
                "s_n": (at_s * sin_beta + an_s * cos_beta, at_0 * sin_beta + an_0 * cos_beta + c_n_above),
                "force": (mu, tau),
            }
        )
        lever, push_n, push_t, torque = 0.5 * opening, normal, tau + mu * c_t, moment
        cos_above, sin_above, c_t_above, c_n_above = cosine, sine, c_t, c_n

    lift = az + column.g
    along, lift = ax * math.cos(theta) - lift * math.sin(theta), ax * math.sin(theta) + lift * math.cos(theta)
    s_t = along * cos_above - lift * sin_above + c_t_above + lever * alpha
    s_n = along * sin_above + lift * cos_above + c_n_above
    accelerations, forces = np.zeros(2 * n), np.zeros(n)
    for i in range(n - 1, -1, -1):
        found = {name: by_s * s_t + rest for name, (by_s, rest) in ways_up[i].items()}
        accelerations[i] = found["alpha"] - alpha
        accelerations[n + i] = found["opening"] - s_n
        forces[i] = found["force"]
        s_t, s_n = found["s_t"], found["s_n"]
    return accelerations, forces, mu
