"""The column's linear system with its joints stiffened: (M + G) z = forces on the joints, in O(n).

M is the mass matrix of the exact formulation at a phase, G holds for every joint the derivatives of its forces, by
relative rotation and opening and by their rates, over the part that is loaded: `weight` times the second derivatives of
its potential, and what the moving edge adds. The elimination is that of an
articulated body (Featherstone 1983) with stiff joints: going down, the two unknowns of each block are eliminated from
a symmetric 3 x 3 inertia in (rotation, tangent, normal); going up, they follow.
"""

from .exact import sine_cosine
from .jit import kernel, leaf, place
from .joint import loaded_part
from .layout import (
    BLOCK_FIELDS,
    CENTROID,
    DAMPING,
    HEIGHT,
    INERTIA,
    JOINT_DEPTH,
    JOINT_WIDTH,
    MASS,
    MODEL_HEADER,
    N_BLOCKS,
    STIFFNESS,
    TANGENT_FIELDS,
)

COS_BETA = 0  # turn from the frame of this joint to that of the joint above
SIN_BETA = 1
B_T = 2  # acceleration of the top face for a unit relative rotation
B_N = 3
E_T = 4  # and for a unit rotation of the body below
H1_A = 5  # inertia met by a unit relative rotation
H1_T = 6
H1_N = 7
H2_A = 8  # and by a unit opening
H2_T = 9
H2_N = 10
D_11 = 11  # inverse of the block's own 2 x 2
D_12 = 12
D_22 = 13
K_11 = 14  # second derivatives of the potential: by rotation, mixed, by opening
K_12 = 15
K_22 = 16
U_1 = 17  # what is left of the forces on the joint
U_2 = 18
EDGE_11 = 19  # what moving the edge where the faces part adds to K, without a dashpot of its own
EDGE_12 = 20
EDGE_22 = 21
WIDEST = 100.0  # times the width of the joint: what a strip counts at most, where the edge runs along the joint at once


@leaf
def _edge_that_moves(width, damping, opening, slope, opening_rate, slope_rate, lo, hi):
    """(abscissa m, width m) of the strip of joint that is as stiff as the edge of the loaded part is by moving.

    Where the faces part the damper alone presses, by damping times the rate of penetration. As the joint closes by d
    the edge moves by d / slope: that pressure over that width is the force of a strip, and it has no dashpot.
    """
    if damping > 0.0 and slope != 0.0 and lo < hi:
        edge = opening / slope
        if edge == (lo if slope > 0.0 else hi) and abs(edge) < 0.5 * width:
            return edge, min(WIDEST * width, max(0.0, damping * (edge * slope_rate - opening_rate) / abs(slope)))
    return 0.0, 0.0


@kernel
def factorize(model, x, o, work, tangent, step_part):
    """Prepare the solution at the phase x[o:]; joint i is weighted with step_part^2 + step_part * its damping."""
    n = place(int(model[N_BLOCKS]))
    j_aa = 0.0  # the part above block i, in the frame of joint i - 1
    j_t = 0.0
    j_n = 0.0
    m_tt = 0.0
    m_nt = 0.0
    m_nn = 0.0
    cos_above = 1.0
    sin_above = 0.0
    square = step_part * step_part
    for i in range(n):
        row = place(MODEL_HEADER + BLOCK_FIELDS * i)
        out = place(tangent + TANGENT_FIELDS * i)
        q = place(o + i)
        height = model[row + HEIGHT]
        mass = model[row + MASS]
        over = height - model[row + CENTROID]
        turn = x[q]
        spin = x[q + 2 * n]
        opening = x[q + n]
        turn_below = 0.0
        spin_below = 0.0
        if i + 1 < n:
            turn_below = x[q + 1]
            spin_below = x[q + 2 * n + 1]
        sin_half, cos_half = sine_cosine(0.5 * (turn - turn_below))
        # joint: stiffness of the loaded part
        eta = model[row + DAMPING]
        width = model[row + JOINT_WIDTH]
        slope = 2.0 * sin_half
        slope_rate = cos_half * (spin - spin_below)
        lo, hi = loaded_part(width, eta, opening, slope, x[q + 3 * n], slope_rate)
        length = max(0.0, hi - lo)
        middle = 0.5 * (lo + hi)
        k_22 = model[row + STIFFNESS] * model[row + JOINT_DEPTH] * length
        k_12 = -k_22 * middle * cos_half
        k_11 = k_22 * (middle * middle + length * length / 12.0) * cos_half * cos_half
        weight = step_part * (step_part + eta)
        edge, strip = _edge_that_moves(width, eta, opening, slope, x[q + 3 * n], slope_rate, lo, hi)
        edge_22 = model[row + STIFFNESS] * model[row + JOINT_DEPTH] * strip
        edge_12 = -edge_22 * edge * cos_half
        edge_11 = edge_22 * edge * edge * cos_half * cos_half
        # turn the part above into this frame, add the block
        cos_beta = cos_above * cos_half - sin_above * sin_half
        sin_beta = sin_above * cos_half + cos_above * sin_half
        # t' = c t + s n of the upper frame: components along this joint's t and n
        t_t = m_tt * cos_beta + m_nt * sin_beta
        t_n = m_nt * cos_beta + m_nn * sin_beta
        n_t = m_nt * cos_beta - m_tt * sin_beta
        n_n = m_nn * cos_beta - m_nt * sin_beta
        m_tt = t_t * cos_beta + t_n * sin_beta + mass
        m_nt = n_t * cos_beta + n_n * sin_beta
        m_nn = n_n * cos_beta - n_t * sin_beta + mass
        swing = mass * over
        j_t, j_n = (
            j_t * cos_beta + j_n * sin_beta - swing * cos_half,
            j_n * cos_beta - j_t * sin_beta + swing * sin_half,
        )
        j_aa += swing * over + model[row + INERTIA]
        # eliminate relative rotation and opening
        b_t = 0.5 * opening + height * cos_half
        b_n = -height * sin_half
        e_t = b_t + 0.5 * opening
        h1_a = j_aa + b_t * j_t + b_n * j_n
        h1_t = j_t + m_tt * b_t + m_nt * b_n
        h1_n = j_n + m_nt * b_t + m_nn * b_n
        h2_a = j_n
        h2_t = m_nt
        h2_n = m_nn
        d_11 = h1_a + b_t * h1_t + b_n * h1_n + weight * k_11 + square * edge_11
        d_12 = h1_n + weight * k_12 + square * edge_12
        d_22 = h2_n + weight * k_22 + square * edge_22
        per = 1.0 / (d_11 * d_22 - d_12 * d_12)
        d_11, d_12, d_22 = d_22 * per, -d_12 * per, d_11 * per
        w_a = d_11 * h1_a + d_12 * h2_a
        w_t = d_11 * h1_t + d_12 * h2_t
        w_n = d_11 * h1_n + d_12 * h2_n
        v_a = d_12 * h1_a + d_22 * h2_a
        v_t = d_12 * h1_t + d_22 * h2_t
        v_n = d_12 * h1_n + d_22 * h2_n
        j_aa -= h1_a * w_a + h2_a * v_a
        j_t -= h1_t * w_a + h2_t * v_a
        j_n -= h1_n * w_a + h2_n * v_a
        m_tt -= h1_t * w_t + h2_t * v_t
        m_nt -= h1_n * w_t + h2_n * v_t
        m_nn -= h1_n * w_n + h2_n * v_n
        # refer to the top face of the body below
        j_aa += 2.0 * (e_t * j_t + b_n * j_n) + e_t * (e_t * m_tt + b_n * m_nt) + b_n * (e_t * m_nt + b_n * m_nn)
        j_t += m_tt * e_t + m_nt * b_n
        j_n += m_nt * e_t + m_nn * b_n
        work[out + COS_BETA] = cos_beta
        work[out + SIN_BETA] = sin_beta
        work[out + B_T] = b_t
        work[out + B_N] = b_n
        work[out + E_T] = e_t
        work[out + H1_A] = h1_a
        work[out + H1_T] = h1_t
        work[out + H1_N] = h1_n
        work[out + H2_A] = h2_a
        work[out + H2_T] = h2_t
        work[out + H2_N] = h2_n
        work[out + D_11] = d_11
        work[out + D_12] = d_12
        work[out + D_22] = d_22
        work[out + K_11] = k_11
        work[out + K_12] = k_12
        work[out + K_22] = k_22
        work[out + EDGE_11] = edge_11
        work[out + EDGE_12] = edge_12
        work[out + EDGE_22] = edge_22
        cos_above = cos_half
        sin_above = sin_half


@kernel
def solve(model, work, tangent, rates, to, step_part):
    """Add to work[to:] the solution z of (M + G) z = -G a - step_part^2 K v for the factorized phase.

    G = step_part (step_part K + D): K the derivatives of the joints' forces by coordinates, D by rates.

    work[to:to + 2 n] holds a on entry and a + z on return, work[rates:rates + 2 n] holds v.
    """
    n = place(int(model[N_BLOCKS]))
    p_a = 0.0  # force needed by the part above, in the frame of joint i - 1
    p_t = 0.0
    p_n = 0.0
    square = step_part * step_part
    for i in range(n):
        row = place(MODEL_HEADER + BLOCK_FIELDS * i)
        out = place(tangent + TANGENT_FIELDS * i)
        a = place(to + i)
        v = place(rates + i)
        turn_a = work[a]
        turn_v = work[v]
        if i + 1 < n:
            turn_a -= work[a + 1]
            turn_v -= work[v + 1]
        eta = model[row + DAMPING]
        weight = step_part * (step_part + eta)
        r_1 = weight * turn_a + square * turn_v
        r_2 = weight * work[a + n] + square * work[v + n]
        e_1 = square * (turn_a + turn_v)
        e_2 = square * (work[a + n] + work[v + n])
        k_12 = work[out + K_12]
        edge_12 = work[out + EDGE_12]
        cos_beta = work[out + COS_BETA]
        sin_beta = work[out + SIN_BETA]
        p_t, p_n = p_t * cos_beta + p_n * sin_beta, p_n * cos_beta - p_t * sin_beta
        b_t = work[out + B_T]
        b_n = work[out + B_N]
        f_1 = work[out + K_11] * r_1 + k_12 * r_2 + (work[out + EDGE_11] * e_1 + edge_12 * e_2)
        f_2 = k_12 * r_1 + work[out + K_22] * r_2 + (edge_12 * e_1 + work[out + EDGE_22] * e_2)
        u_1 = -f_1 - (p_a + b_t * p_t + b_n * p_n)
        u_2 = -f_2 - p_n
        x_1 = work[out + D_11] * u_1 + work[out + D_12] * u_2
        x_2 = work[out + D_12] * u_1 + work[out + D_22] * u_2
        p_a += work[out + H1_A] * x_1 + work[out + H2_A] * x_2
        p_t += work[out + H1_T] * x_1 + work[out + H2_T] * x_2
        p_n += work[out + H1_N] * x_1 + work[out + H2_N] * x_2
        p_a += work[out + E_T] * p_t + b_n * p_n
        work[out + U_1] = x_1
        work[out + U_2] = x_2
    alpha = 0.0
    a_t = 0.0
    a_n = 0.0
    for i in range(n - 1, -1, -1):
        out = place(tangent + TANGENT_FIELDS * i)
        a = place(to + i)
        b_n = work[out + B_N]
        s_t = a_t + work[out + E_T] * alpha
        s_n = a_n + b_n * alpha
        g_1 = work[out + H1_A] * alpha + work[out + H1_T] * s_t + work[out + H1_N] * s_n
        g_2 = work[out + H2_A] * alpha + work[out + H2_T] * s_t + work[out + H2_N] * s_n
        turned = work[out + U_1] - (work[out + D_11] * g_1 + work[out + D_12] * g_2)
        opened = work[out + U_2] - (work[out + D_12] * g_1 + work[out + D_22] * g_2)
        alpha += turned
        a_t = s_t + work[out + B_T] * turned
        a_n = s_n + b_n * turned + opened
        work[a] += alpha
        work[a + n] += opened
        cos_beta = work[out + COS_BETA]
        sin_beta = work[out + SIN_BETA]
        a_t, a_n = a_t * cos_beta - a_n * sin_beta, a_t * sin_beta + a_n * cos_beta
