"""The column's linear system with its joints stiffened: (M + G) z = forces on the joints, in O(n).

M is the mass matrix of the exact formulation at a phase. G holds, for every joint and over its loaded part, the
derivatives of its forces by relative rotation and opening and by their rates: `weight` times the second derivatives of
its potential, and the contribution of the moving edge. The elimination is that of an articulated body (Featherstone
1983) with stiff joints: the pass down eliminates the two unknowns of each block from a symmetric 3 x 3 inertia in
(rotation, tangent, normal); the pass up finds them. No joint slides meanwhile: slips are fixed lengths of the chain, as
offsets are.
"""

from typing import NamedTuple

from ...numba_ext.jit import kernel, leaf
from ...numba_ext.numbers import sine_cosine
from ...numba_ext.views import FieldTable
from ..joint.law import joint_tangent, law_of, loaded_part
from ..joint.sliding import opening_felt, opening_rate_felt, slip_of
from ..sections.section import contact_of, strip_stiffness

TANGENT = FieldTable(
    # matrix that passes the force (couple, tangent, normal) on the part above through a block and its joint
    "pass_aa",
    "pass_at",
    "pass_an",
    "pass_tt",
    "pass_tn",
    "pass_nt",
    "pass_nn",
    "turn_a",  # share of a force on the joint against its relative rotation
    "turn_t",
    "turn_n",
    "open_a",  # share of a force against its opening
    "open_t",
    "open_n",
    "lever_t",  # moment of the force above about the joint, in addition to its couple
    "lever_n",
    "lift_t",  # component of the force above that opens the joint
    "lift_n",
    "d_11",  # inverse of the 2 x 2 matrix of the block's unknowns
    "d_12",
    "d_22",
    "k_11",  # second derivatives of the potential: by rotation, mixed, by opening
    "k_12",
    "k_22",
    "u_1",  # the block's unknowns where the body below does not move
    "u_2",
    "edge_11",  # contribution to K of the moving edge where the faces part, without a dashpot of its own
    "edge_12",
    "edge_22",
)
WIDEST = 100.0  # limit of the strip's width relative to the joint's: a slope near zero moves the edge along all of it
_tangent = TANGENT.over


@leaf
def _edge_that_moves(contact, damping, opening, slope, opening_rate, slope_rate, lo, hi):
    """Return (abscissa m, width m) of the strip whose stiffness is that of the moving edge of the loaded part.

    Where the faces part only the damper presses, by damping times the rate of penetration. As the joint closes by d
    the edge moves by d / slope: that pressure over that width is the force of a strip without a dashpot.
    """
    if damping > 0.0 and slope != 0.0 and lo < hi:
        edge = opening / slope
        if edge == (lo if slope > 0.0 else hi) and contact.left < edge < contact.right:
            widest = WIDEST * (contact.right - contact.left)
            return edge, min(widest, max(0.0, damping * (edge * slope_rate - opening_rate) / abs(slope)))
    return 0.0, 0.0


@leaf
def _about(stiffness, beyond):
    """Return a stiffness (joint/law.py, `joint_tangent`) about a middle that lies `beyond` m to the left."""
    along, mixed, second = stiffness
    if beyond == 0.0:
        return stiffness
    return along, mixed + beyond * along, second + beyond * (2.0 * mixed + beyond * along)


class _Stiffness(NamedTuple):
    """The stiffness of a joint, as the rows of TANGENT name it."""

    k_11: float
    k_12: float
    k_22: float
    edge_11: float
    edge_12: float
    edge_22: float


@leaf
def _stiffness_of(model, phase, i, slope, slope_rate, cos_half):
    """Return the stiffness of the loaded part of joint i, and of its moving edge."""
    blocks = model.blocks
    eta = blocks.damping[i]
    # motion in the middle of the contact, and the loaded part
    slip, slip_rate = slip_of(model, phase, i)
    contact = contact_of(blocks, i, slip)
    felt = opening_felt(phase.opening[i], slip, slope)
    felt_rate = opening_rate_felt(phase.opening_rate[i], slip, slip_rate, slope, slope_rate)
    lo, hi = loaded_part(contact.left, contact.right, eta, felt, slope, felt_rate, slope_rate)
    # stiffness of the loaded part, then of the moving edge
    mean, gradient = felt + eta * felt_rate, slope + eta * slope_rate
    k_22, k_12, k_11 = _about(joint_tangent(contact, law_of(blocks, i), lo, hi, mean, gradient), 0.5 * slip)
    edge, strip = _edge_that_moves(contact, eta, felt, slope, felt_rate, slope_rate, lo, hi)
    edge_22, edge_12, edge_11 = 0.0, 0.0, 0.0
    if strip != 0.0:
        edge_22, edge_12, edge_11 = _about(strip_stiffness(contact, blocks.stiffness[i], edge, strip), 0.5 * slip)
    square = cos_half * cos_half
    return _Stiffness(k_11 * square, k_12 * -cos_half, k_22, edge_11 * square, edge_12 * -cos_half, edge_22)


class _Part(NamedTuple):
    """The inertia of the part above a joint in its frame: by rotation, tangent and normal."""

    aa: float
    at: float
    an: float
    tt: float
    nt: float
    nn: float


@leaf
def _with_block(part, cosine, sine, mass, inertia, arm_t, arm_n):
    """Return the part turned into the frame of the joint below, plus the block, whose centroid is at the arm (m)."""
    # rotate the inertia: t' = c t + s n of the upper frame, along this joint's t and n
    t_t = part.tt * cosine + part.nt * sine
    t_n = part.nt * cosine + part.nn * sine
    n_t = part.nt * cosine - part.tt * sine
    n_n = part.nn * cosine - part.nt * sine
    return _Part(
        part.aa + inertia,
        (part.at * cosine + part.an * sine) - arm_t,
        (part.an * cosine - part.at * sine) + arm_n,
        mass + (t_t * cosine + t_n * sine),
        n_t * cosine + n_n * sine,
        mass + (n_n * cosine - n_t * sine),
    )


@leaf
def _half_turns(model, phase, i):
    """Return (sine, cosine) of half the rotation of joint i, and of its tangent's angle to both blocks."""
    below = phase.theta[i + 1] if i + 1 < model.n else 0.0
    half = 0.5 * (phase.theta[i] - below)
    middle = sine_cosine(half)
    if model.settings.off_axis == 0.0:
        return middle, middle, middle
    blocks = model.blocks
    lean, tilt_below = blocks.lean[i], blocks.tilt[i + 1] if i + 1 < model.n else 0.0
    return middle, sine_cosine(half + (blocks.tilt[i] - lean)), sine_cosine(half + (lean - tilt_below))


@kernel
def factorize(model, phase, tangent, step_part):
    """Factorize M + G at a phase and store it in `tangent` (TANGENT).

    The weight of joint i is step_part^2 + step_part * its damping (s2); step_part in s.
    """
    n, blocks, rows = model.n, model.blocks, _tangent(tangent, model.n)
    part = _Part(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # above block i, in the frame of joint i - 1
    cos_above, sin_above = 1.0, 0.0
    square = step_part * step_part
    for i in range(n):
        # stiffness of the joint, and angles of its blocks
        mass, over, opening = blocks.mass[i], blocks.upper[i], phase.opening[i]
        spin_below = phase.theta_rate[i + 1] if i + 1 < n else 0.0
        (sin_half, cos_half), (sin_over, cos_over), (sin_under, cos_under) = _half_turns(model, phase, i)
        slope_rate = cos_half * (phase.theta_rate[i] - spin_below)
        joint = _stiffness_of(model, phase, i, 2.0 * sin_half, slope_rate, cos_half)
        weight = step_part * (step_part + blocks.damping[i])
        # the part above with the block, in the frame of the joint
        cos_beta = cos_above * cos_over - sin_above * sin_over
        sin_beta = sin_above * cos_over + cos_above * sin_over
        swing = mass * over
        inertia = swing * over + blocks.inertia[i]
        part = _with_block(part, cos_beta, sin_beta, mass, inertia, swing * cos_over, swing * sin_over)
        j_aa, j_t, j_n, m_tt, m_nt, m_nn = part
        # eliminate relative rotation and opening
        slip, _ = slip_of(model, phase, i)
        b_t = 0.5 * opening + blocks.height[i] * cos_over
        b_n = -blocks.height[i] * sin_over - 0.5 * slip
        e_t = b_t + 0.5 * opening
        e_n = b_n - 0.5 * slip
        h1_a = j_aa + (b_t * j_t + b_n * j_n)
        h1_t = j_t + (m_tt * b_t + m_nt * b_n)
        h1_n = j_n + (m_nt * b_t + m_nn * b_n)
        h2_a, h2_t, h2_n = j_n, m_nt, m_nn
        d_11 = (b_t * h1_t + b_n * h1_n) + (h1_a + (weight * joint.k_11 + square * joint.edge_11))
        d_12 = h1_n + (weight * joint.k_12 + square * joint.edge_12)
        d_22 = h2_n + (weight * joint.k_22 + square * joint.edge_22)
        per = 1.0 / (d_11 * d_22 - d_12 * d_12)
        d_11, d_12, d_22 = d_22 * per, -d_12 * per, d_11 * per
        w_a, w_t, w_n = d_11 * h1_a + d_12 * h2_a, d_11 * h1_t + d_12 * h2_t, d_11 * h1_n + d_12 * h2_n
        v_a, v_t, v_n = d_12 * h1_a + d_22 * h2_a, d_12 * h1_t + d_22 * h2_t, d_12 * h1_n + d_22 * h2_n
        j_aa -= h1_a * w_a + h2_a * v_a
        j_t -= h1_t * w_a + h2_t * v_a
        j_n -= h1_n * w_a + h2_n * v_a
        m_tt -= h1_t * w_t + h2_t * v_t
        m_nt -= h1_n * w_t + h2_n * v_t
        m_nn -= h1_n * w_n + h2_n * v_n
        # refer to the top face of the body below
        up_t, up_n = j_t + (m_tt * e_t + m_nt * e_n), j_n + (m_nt * e_t + m_nn * e_n)
        part = _Part(j_aa + (e_t * (j_t + up_t) + e_n * (j_n + up_n)), up_t, up_n, m_tt, m_nt, m_nn)
        # combine these steps in one matrix, which `solve` applies faster
        lever_t, lever_n = b_t * cos_beta - b_n * sin_beta, b_t * sin_beta + b_n * cos_beta
        turn_a, open_a = -(w_a + e_t * w_t + e_n * w_n), -(v_a + e_t * v_t + e_n * v_n)
        rows.turn_a[i], rows.turn_t[i], rows.turn_n[i] = turn_a, -w_t, -w_n
        rows.open_a[i], rows.open_t[i], rows.open_n[i] = open_a, -v_t, -v_n
        rows.lever_t[i], rows.lever_n[i] = lever_t, lever_n
        rows.lift_t[i], rows.lift_n[i] = -sin_beta, cos_beta
        rows.pass_aa[i] = 1.0 + turn_a
        rows.pass_at[i] = (e_t * cos_beta - e_n * sin_beta) + (turn_a * lever_t - open_a * sin_beta)
        rows.pass_an[i] = (e_t * sin_beta + e_n * cos_beta) + (turn_a * lever_n + open_a * cos_beta)
        rows.pass_tt[i] = cos_beta - (w_t * lever_t - v_t * sin_beta)
        rows.pass_tn[i] = sin_beta - (w_t * lever_n + v_t * cos_beta)
        rows.pass_nt[i] = -sin_beta - (w_n * lever_t - v_n * sin_beta)
        rows.pass_nn[i] = cos_beta - (w_n * lever_n + v_n * cos_beta)
        rows.d_11[i], rows.d_12[i], rows.d_22[i] = d_11, d_12, d_22
        rows.k_11[i], rows.k_12[i], rows.k_22[i] = joint.k_11, joint.k_12, joint.k_22
        rows.edge_11[i], rows.edge_12[i], rows.edge_22[i] = joint.edge_11, joint.edge_12, joint.edge_22
        cos_above, sin_above = cos_under, sin_under


@kernel
def solve(model, tangent, a, v, step_part):
    """Add to the row a (2 n) the solution z of (M + G) z = -G a - step_part^2 K v for the factorized phase.

    G = step_part (step_part K + D): K the derivatives of the joints' forces by coordinates, D by rates.
    """
    n = model.n
    blocks = model.blocks
    rows = _tangent(tangent, n)
    p_a = 0.0  # force needed by the part above, in the frame of joint i - 1
    p_t = 0.0
    p_n = 0.0
    square = step_part * step_part
    # pass down
    for i in range(n):
        turn_a = a[i]
        turn_v = v[i]
        if i + 1 < n:
            turn_a -= a[i + 1]
            turn_v -= v[i + 1]
        # forces of the joint's springs and dashpots
        weight = step_part * (step_part + blocks.damping[i])
        r_1 = weight * turn_a + square * turn_v
        r_2 = weight * a[n + i] + square * v[n + i]
        e_1 = square * (turn_a + turn_v)
        e_2 = square * (a[n + i] + v[n + i])
        k_12 = rows.k_12[i]
        edge_12 = rows.edge_12[i]
        f_1 = rows.k_11[i] * r_1 + k_12 * r_2 + (rows.edge_11[i] * e_1 + edge_12 * e_2)
        f_2 = k_12 * r_1 + rows.k_22[i] * r_2 + (edge_12 * e_1 + rows.edge_22[i] * e_2)
        # the two unknowns of the joint, and the force on the part below
        turn_t, turn_n = rows.turn_t[i], rows.turn_n[i]
        u_1 = f_1 + (p_a + rows.lever_t[i] * p_t + rows.lever_n[i] * p_n)
        u_2 = f_2 + (rows.lift_t[i] * p_t + rows.lift_n[i] * p_n)
        rows.u_1[i] = -(rows.d_11[i] * u_1 + rows.d_12[i] * u_2)
        rows.u_2[i] = -(rows.d_12[i] * u_1 + rows.d_22[i] * u_2)
        p_a, p_t, p_n = (
            (rows.pass_aa[i] * p_a + rows.pass_at[i] * p_t)
            + (rows.pass_an[i] * p_n + (rows.turn_a[i] * f_1 + rows.open_a[i] * f_2)),
            (turn_t * p_a + rows.pass_tt[i] * p_t) + (rows.pass_tn[i] * p_n + (turn_t * f_1 + rows.open_t[i] * f_2)),
            (turn_n * p_a + rows.pass_nt[i] * p_t) + (rows.pass_nn[i] * p_n + (turn_n * f_1 + rows.open_n[i] * f_2)),
        )
    alpha = 0.0
    a_t = 0.0
    a_n = 0.0
    # pass up: acceleration of the body below gives that of the block
    for i in range(n - 1, -1, -1):
        u_1, u_2 = rows.u_1[i], rows.u_2[i]
        opened = u_2 + (rows.open_a[i] * alpha + rows.open_t[i] * a_t + rows.open_n[i] * a_n)
        # the transposed matrix of the pass down
        alpha, a_t, a_n = (
            (rows.pass_aa[i] * alpha + rows.turn_t[i] * a_t) + (rows.turn_n[i] * a_n + u_1),
            (rows.pass_at[i] * alpha + rows.pass_tt[i] * a_t)
            + (rows.pass_nt[i] * a_n + (rows.lever_t[i] * u_1 + rows.lift_t[i] * u_2)),
            (rows.pass_an[i] * alpha + rows.pass_tn[i] * a_t)
            + (rows.pass_nn[i] * a_n + (rows.lever_n[i] * u_1 + rows.lift_n[i] * u_2)),
        )
        a[i] += alpha
        a[n + i] += opened
