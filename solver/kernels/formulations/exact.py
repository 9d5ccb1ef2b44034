"""Formulation `exact`: finite rotations (theory.md section 4) by the forces along the joints (section 8).

With N and M of every joint known from its motion, what is unknown are the forces T along the joints, which keep each
joint rigid in shear: a symmetric positive definite tridiagonal system. It is eliminated from the top down while the
joints are evaluated; the way up gives T, rotations and openings. The last pivot is the inverse of the mass that the
column opposes to the acceleration of the base along the base joint (theory.md section 7).

Frames are those of the joints, turned by phi_i = (theta_i + theta_(i+1)) / 2, so that only differences of rotations
enter until the base. The base is the lowest body of the chain, with prescribed motion: coordinates are rotations
relative to it, spins in here are absolute.

A joint that slides (section 9) has its T given by friction: its row leaves the system, and the acceleration of its slip
follows. Which joints slide, and which way, stands in `joints`. An offset of a block is a slip that it is built with; to
joints inclined as built, blocks stand at other angles than half of the joint's rotation (section 12).

The one function serves one column and lanes of eight.
"""

from typing import NamedTuple

from ..jit import kernel, leaf
from ..joint.law import resultants
from ..joint.sliding import bearable, can_slide, drift, opening_felt, opening_rate_felt, rim_force, slip_if
from ..lanes import any_of, magnitude, where
from ..numbers import sine_cosine


class Motion(NamedTuple):
    """Motion of the base at an instant: accelerations m/s2, rotation rad clockwise, its rate and acceleration."""

    ax: float
    az: float
    theta: float
    omega: float
    alpha: float


STILL = Motion(0.0, 0.0, 0.0, 0.0, 0.0)


class Elimination(NamedTuple):
    """What the way down leaves for the way up, rows of n."""

    coupling: object  # of T_(i-1) and T_i, 1/kg
    pivot: object  # kg, inverse
    right: object  # m/s2, right side of the system
    free_alpha: object  # rad/s2, without the T
    free_opening: object  # m/s2
    turn_below: object  # rad/s2 for a unit T_i, and
    turn_above: object  # for a unit T_(i-1)
    sine_beta: object  # over the mass: between the normals of joints i - 1 and i
    sine: object  # of the angle of block i to the normal of joint i
    sine_less: object  # less that of the angle to the block below
    given: object  # N, T of a joint that slides


@leaf
def elimination(room):
    """The fields of `room` as this formulation uses them."""
    return Elimination(room.a, room.b, room.c, room.d, room.e, room.f, room.g, room.h, room.i, room.j, room.k)


@leaf
def exact_accelerations(model, phase, motion, joints, hold, room):
    """Accelerations of a phase from its coordinates and rates, and the resultants of its joints; returns nothing."""
    if can_slide(model):  # compiled twice: the other takes a sixth less
        _accelerations(model, phase, motion, joints, hold, room, True)
    else:
        _accelerations(model, phase, motion, joints, hold, room, False)


@leaf
def _accelerations(model, phase, motion, joints, hold, room, slides):
    """The same; slides: whether slips are coordinates."""
    n = model.n
    blocks = model.blocks
    row = elimination(room)
    off_axis = slides and any_of(model.settings.off_axis != 0.0)
    # --- downwards: evaluate joint i, finish the row of the joint above it, eliminate
    normal_above = 0.0
    turned_above = 0.0  # M cos sigma
    sine_above = 0.0  # of the angle of block i to the normal of joint i - 1
    cosine_above = 1.0
    half_above = 0.0  # of its opening
    across_above = 0.0  # couple of N across half of its slip
    diagonal = 0.0
    right = 0.0
    opens = 0.0  # acceleration of the opening without the T
    turn = phase.theta[0]
    spin = phase.theta_rate[0] + motion.omega
    for i in range(n):
        opening = phase.opening[i]
        opening_rate = phase.opening_rate[i]
        turn_below = 0.0
        spin_below = motion.omega
        if i + 1 < n:
            turn_below = phase.theta[i + 1]
            spin_below = phase.theta_rate[i + 1] + motion.omega
        sine, cosine = sine_cosine(0.5 * (turn - turn_below))
        slope, slope_rate = 2.0 * sine, cosine * (spin - spin_below)
        felt, felt_rate = opening, opening_rate
        slip, slip_rate = slip_if(slides, model, phase, i)
        over_sine, over_cosine, under_sine, under_cosine = sine, cosine, sine, cosine
        if slides:
            felt = opening_felt(opening, slip, slope)
            felt_rate = opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate)
            if off_axis:
                lean, tilt_below = blocks.lean[i], blocks.tilt[i + 1] if i + 1 < n else 0.0
                over_sine, over_cosine = sine_cosine(0.5 * (turn - turn_below) + (blocks.tilt[i] - lean))
                under_sine, under_cosine = sine_cosine(0.5 * (turn - turn_below) + (lean - tilt_below))
            row.sine_less[i] = over_sine - under_sine
        normal, moment, length = resultants(blocks, hold, i, felt, slope, felt_rate, slope_rate, slip)
        lower, upper = blocks.centroid[i], blocks.upper[i]
        per_mass, per_inertia = blocks.per_mass[i], blocks.per_inertia[i]
        across = 0.0
        if slides:
            across = 0.5 * slip * normal
            moment += across
        turned = moment * cosine
        mean_spin = 0.5 * (spin + spin_below)
        square = spin * spin
        half = 0.5 * opening
        p = lower * over_cosine + half
        q = upper * cosine_above + half_above
        p_turns, q_turns = p * per_inertia, q * per_inertia
        sine_beta = (sine_above * over_cosine + cosine_above * over_sine) * per_mass
        cosine_beta = (cosine_above * over_cosine - sine_above * over_sine) * per_mass
        free_alpha = per_inertia * (
            (lower * normal * over_sine - upper * normal_above * sine_above) + (turned_above - turned)
        )
        if slides:
            free_alpha += per_inertia * (across + across_above)
        opens_below = normal * per_mass + (lower * over_cosine * square + opening * mean_spin * mean_spin)
        right_below = 2.0 * opening_rate * mean_spin + (p * free_alpha - lower * over_sine * square)
        diagonal_below = per_mass + p * p_turns
        if slides:
            opens_below += 2.0 * slip_rate * mean_spin
            right_below -= slip * mean_spin * mean_spin
            joints.drift[i] = drift(normal, sine, rim_force(blocks, i, felt, slope, slip))
            joints.bearable[i] = bearable(blocks, i, normal)
            row.given[i] = joints.drift[i] - joints.sliding[i] * joints.bearable[i]
        if i > 0:
            right += (upper * sine_above * square - normal * sine_beta) + q * free_alpha
            opens += (upper * cosine_above * square - normal * cosine_beta) + normal_above * per_mass
            pivot = 1.0 / (diagonal + (per_mass + q * q_turns))
            coupling = p * q_turns - cosine_beta
            row.pivot[i - 1] = pivot
            row.right[i - 1] = right
            row.free_opening[i - 1] = opens
            row.coupling[i] = coupling
            part = coupling * pivot
            if slides:
                slid = joints.sliding[i - 1] != 0.0
                diagonal_below -= where(slid, 0.0, part * coupling)
                right_below += normal_above * sine_beta - where(slid, coupling * row.given[i - 1], part * right)
            else:
                diagonal_below -= part * coupling
                right_below += normal_above * sine_beta - part * right
            opens_below -= normal_above * cosine_beta
        diagonal, right, opens = diagonal_below, right_below, opens_below
        row.free_alpha[i] = free_alpha
        row.turn_below[i] = p_turns
        row.turn_above[i] = q_turns
        row.sine_beta[i] = sine_beta
        row.sine[i] = over_sine
        joints.normal[i] = normal
        joints.moment[i] = moment
        joints.length[i] = length
        normal_above, turned_above = normal, turned
        sine_above, cosine_above, half_above, across_above = under_sine, under_cosine, half, across
        turn, spin = turn_below, spin_below

    # --- the base: gravity is an upward acceleration; joint n is turned against it, upright by theta_n / 2
    base_sine, base_cosine = sine_cosine(motion.theta)
    lift = motion.az + model.settings.gravity
    along = motion.ax * base_cosine - lift * base_sine
    lift = motion.ax * base_sine + lift * base_cosine
    right += (along * cosine_above - lift * sine_above) + half_above * motion.alpha
    opens -= along * sine_above + lift * cosine_above
    pivot = 1.0 / diagonal
    row.pivot[n - 1] = pivot
    force = right * pivot
    if slides:
        force = _slide(phase, row, joints, n - 1, force)

    _upwards(model, phase, motion, joints, row, force, opens, slides)


@leaf
def _upwards(model, phase, motion, joints, row, force, opens, slides):
    """The forces along the joints above the base joint, which has `force`, and what follows from them.

    opens: acceleration of the opening of the base joint without the T.
    """
    n, blocks = model.n, model.blocks
    drawn_below = 0.0  # what T of the joint below does to the opening
    swung_below = 0.0  # alpha of the block below times the height of its top face above its centroid
    alpha_below = motion.alpha
    for i in range(n - 1, -1, -1):
        force_above = 0.0
        if i > 0:
            force_above = (row.right[i - 1] - row.coupling[i] * force) * row.pivot[i - 1]
            if slides:
                force_above = _slide(phase, row, joints, i - 1, force_above)
        if i + 1 < n:
            opens = row.free_opening[i]
        alpha = row.free_alpha[i] - (row.turn_below[i] * force + row.turn_above[i] * force_above)
        drawn = row.sine_beta[i]
        phase.theta_acceleration[i] = alpha - motion.alpha
        phase.opening_acceleration[i] = opens + (
            (drawn * force_above - drawn_below) + row.sine[i] * (blocks.centroid[i] * alpha - swung_below)
        )
        if slides:
            phase.opening_acceleration[i] += 0.5 * phase.slip[i] * (alpha + alpha_below)
            phase.opening_acceleration[i] += row.sine_less[i] * swung_below
            alpha_below = alpha
        joints.tangential[i] = force
        drawn_below = drawn * force
        swung_below = blocks.upper[i] * alpha
        force = force_above


@leaf
def _slide(phase, row, joints, i, needed):
    """T of joint i, for which the force that keeps it from sliding is `needed`; how its slip accelerates."""
    way, bears, given = joints.sliding[i], joints.bearable[i], row.given[i]
    sticks = way == 0.0
    beyond = magnitude(needed - joints.drift[i]) > bears
    joints.overcome[i] = where(sticks & beyond, 1.0, joints.overcome[i])
    phase.slip_acceleration[i] = where(sticks, 0.0, (given - needed) / row.pivot[i])
    phase.friction_power[i] = where(sticks, 0.0, way * phase.slip_rate[i] * bears)
    return where(sticks, needed, given)


@kernel
def exact_top_motion(model, phase, ux, rate, turn=0.0, spin=0.0):
    """Horizontal displacement (m) and velocity (m/s) of the top faces, as built and relative to the base: rows of n.

    turn, spin: rotation of the base, rad clockwise, and its rate.
    """
    displacement = 0.0
    velocity = 0.0
    turn_below, spin_below = turn, spin
    slides = can_slide(model)
    for i in range(model.n - 1, -1, -1):
        height = model.blocks.height[i]
        theta = phase.theta[i] + turn
        omega = phase.theta_rate[i] + spin
        opening = phase.opening[i]
        phi = 0.5 * (theta + turn_below)
        turn_below, spin_under = theta, spin_below
        if slides:
            theta, phi = theta + model.blocks.tilt[i], phi + model.blocks.lean[i]
        sine, cosine = sine_cosine(theta)
        sine_phi, cosine_phi = sine_cosine(phi)
        displacement += opening * sine_phi + height * sine
        velocity += phase.opening_rate[i] * sine_phi + opening * 0.5 * (omega + spin_under) * cosine_phi
        velocity += height * omega * cosine
        if slides:
            displacement += phase.slip[i] * cosine_phi
            velocity += phase.slip_rate[i] * cosine_phi - phase.slip[i] * 0.5 * (omega + spin_under) * sine_phi
        ux[i] = displacement - model.blocks.built_x[i] if slides else displacement
        rate[i] = velocity
        spin_below = omega
