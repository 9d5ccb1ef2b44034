"""The formulation `exact`: finite rotations (theory.md section 4) by the forces along the joints (section 8).

N and M of every joint follow from its motion. The unknowns are the forces T along the joints, which keep each joint
rigid in shear: a symmetric positive definite tridiagonal system. The joints are evaluated independently, which a
processor does in parallel; then the system is eliminated from the top down; the pass up gives T, rotations and
openings. The last pivot is the inverse of the mass that the column opposes to the acceleration of the base along the
base joint (theory.md section 7).

Frames are those of the joints, turned by phi_i = (theta_i + theta_(i+1)) / 2, so that only differences of rotations
enter until the base. The base is the lowest body of the chain, with prescribed motion: coordinates are rotations
relative to it, spins in this module are absolute.

The T of a joint that slides (section 9) is given by friction: its row leaves the system, and the acceleration of its
slip follows. `joints` holds which joints slide, and which way. An offset of a block is a slip that it is built with;
joints inclined as built change the angles between blocks and joints (section 12).

One function serves one column and lanes of eight. Loads on blocks enter by `with_couple` and `with_push` (loads.py).
"""

from typing import NamedTuple

from ...numba_ext.jit import kernel, leaf
from ...numba_ext.lanes import any_of, greater, magnitude, where
from ...numba_ext.numbers import half_sine_cosine, sine_cosine
from ...numba_ext.views import Record
from ..joint.resultants import resultants_of, shear_capacity
from ..joint.sliding import (
    BARELY,
    can_slide,
    edges_coincide,
    opening_felt,
    opening_rate_felt,
    pressure_shear,
    rim_force,
    slip_if,
    slip_towards,
)
from .loads import with_couple, with_push


class Motion(NamedTuple):
    """The motion of the base at an instant: accelerations (m/s2), rotation (rad clockwise), its derivatives."""

    ax: float
    az: float
    theta: float
    omega: float
    alpha: float


STILL = Motion(0.0, 0.0, 0.0, 0.0, 0.0)

# results of an evaluation for one joint
JOINT_ROW = Record(
    # from the joint's motion
    "sine",  # of the angle of the block above to the normal of the joint
    "cosine",
    "turned",  # N m, M cos sigma: moment of the joint on the block above and, reversed, on that below
    # of the elimination
    "part",  # coefficient of -T_i in T_(i-1)
    "alone",  # N, T_i without the part from T_(i+1)
    "pivot",  # kg, inverse; kept for the last joint, and for all where they may slide
    "free_alpha",  # rad/s2 of the block above, without the T
    "free_opening",  # m/s2
    "turn_below",  # rad/s2 for a unit T_i, and
    "turn_above",  # for a unit T_(i-1)
    "sine_beta",  # over the mass: between the normals of joints i - 1 and i
    # where joints may slide, or are off the axis
    "under_sine",  # of the angle of the block below to the normal of the joint
    "under_cosine",
    "across",  # N m, couple of N across half of the slip
    "given",  # N, T of a joint that slides
    "at_edges",  # N, more than the force of edges that coincide; 0 if none do
)
_over = JOINT_ROW.over
_SIZE = JOINT_ROW.beside


@leaf
def joint_row(room, i):
    """Return the results of an evaluation for joint i in `room`."""
    return _over(room.row[_SIZE * i :], 0)


@leaf
def exact_accelerations(model, phase, motion, loads, bonds, joints, hold, room):
    """Fill in the accelerations of a phase from its coordinates and rates, and the resultants of its joints.

    loads: those on the ports (`Loads`); bonds: those of the joints (`Bonds`). With None a version is compiled without
    them, which is faster by up to a sixth.
    """
    if can_slide(model):  # compiled twice: the one without slips is a sixth faster
        _accelerations(model, phase, motion, loads, bonds, joints, hold, room, True)
    else:
        _accelerations(model, phase, motion, loads, bonds, joints, hold, room, False)


@leaf
def _accelerations(model, phase, motion, loads, bonds, joints, hold, room, slides):
    """Compute `exact_accelerations` for either kind of column; slides: whether slips are coordinates."""
    _turn(phase, room, model.n)
    _bear(model, phase, bonds, joints, hold, room, slides)
    right, opens = _downwards(model, phase, motion, loads, joints, room, slides)
    _upwards(model, phase, motion, joints, room, right, opens, slides)


@leaf
def _turn(phase, room, n):
    """Compute sine and cosine of half the rotation of each joint: in a separate loop of independent iterations."""
    for i in range(n):
        here, turn = joint_row(room, i), phase.theta[i]
        if i + 1 < n:
            turn -= phase.theta[i + 1]
        here.sine, here.cosine = half_sine_cosine(turn)


@leaf
def _bear(model, phase, bonds, joints, hold, room, slides):
    """Compute N and M of each joint, and T of those that slide, from the joint's motion alone."""
    n, blocks = model.n, model.blocks
    off_axis = slides and any_of(model.settings.off_axis != 0.0)
    for i in range(n):
        here = joint_row(room, i)
        sine, cosine = here.sine, here.cosine
        # motion of the joint: slope, opening in the middle of the contact, slip
        spin = phase.theta_rate[i]
        if i + 1 < n:
            spin -= phase.theta_rate[i + 1]
        slope, slope_rate = 2.0 * sine, cosine * spin
        felt, felt_rate = phase.opening[i], phase.opening_rate[i]
        slip, slip_rate = slip_if(slides, model, phase, i)
        if slides:
            felt = opening_felt(felt, slip, slope)
            felt_rate = opening_rate_felt(felt_rate, slip, slip_rate, slope, slope_rate)
        # forces of the pressure
        motion = felt, slope, felt_rate, slope_rate, slip
        normal, moment, length = resultants_of(model, bonds, joints, hold, i, *motion)
        if slides:
            here.under_sine, here.under_cosine = sine, cosine
            # angles of both blocks to the normal of the joint, as built (section 12)
            if off_axis:
                turn = phase.theta[i] - phase.theta[i + 1] if i + 1 < n else phase.theta[i]
                lean, tilt_below = blocks.lean[i], blocks.tilt[i + 1] if i + 1 < n else 0.0
                here.sine, here.cosine = sine_cosine(0.5 * turn + (blocks.tilt[i] - lean))
                here.under_sine, here.under_cosine = sine_cosine(0.5 * turn + (lean - tilt_below))
            # couple of N across half of the slip; friction (section 9)
            across = 0.5 * slip * normal
            moment += across
            here.across = across
            coincide = edges_coincide(blocks, i, slip)
            ahead = slip_towards(slip, joints.sliding[i], coincide)
            joints.pressure_shear[i] = pressure_shear(normal, sine, rim_force(blocks, i, felt, slope, ahead))
            pressed = greater(magnitude(slope) * greater(blocks.own_right[i], -blocks.own_left[i]) - felt, 0.0)
            here.at_edges = where(coincide, blocks.stiffness[i] * blocks.own_depth[i] * pressed * pressed, 0.0)
            joints.shear_capacity[i] = shear_capacity(model, bonds, joints, i, normal)
            here.given = joints.pressure_shear[i] - joints.sliding[i] * joints.shear_capacity[i]
        here.turned = moment * cosine
        joints.normal[i] = normal
        joints.moment[i] = moment
        joints.length[i] = length


@leaf
def _downwards(model, phase, motion, loads, joints, room, slides):
    """Finish and eliminate the row of the joint above each block; return right side and opening of the base joint.

    Both are without the acceleration of the base.
    """
    n, blocks = model.n, model.blocks
    spin = phase.theta_rate[0] + motion.omega
    spin_below = _spin_below(phase, motion, 0, n)
    # the top block
    half, _, _, diagonal, right, opens = _over_joint(
        model, phase, motion, loads, joints, room, 0, spin, spin_below, 0.0, slides
    )
    for i in range(1, n):
        spin = spin_below
        spin_below = _spin_below(phase, motion, i, n)
        # joints below and above block i
        here, above = joint_row(room, i), joint_row(room, i - 1)
        per_mass = blocks.per_mass[i]
        normal, normal_above = joints.normal[i], joints.normal[i - 1]
        sine, cosine = here.sine, here.cosine
        sine_above, cosine_above = _under(above, slides)
        upper_sine, upper_cosine = blocks.upper[i] * sine_above, blocks.upper[i] * cosine_above
        couple = above.turned - normal_above * upper_sine
        if slides:
            couple += above.across
        # contribution of the block to the row of the joint below it
        half_above = half
        half, p, free_alpha, diagonal_below, right_below, opens_below = _over_joint(
            model, phase, motion, loads, joints, room, i, spin, spin_below, couple, slides
        )
        # and to the row of the joint above it
        q = upper_cosine + half_above
        q_turns = q * blocks.per_inertia[i]
        square = spin * spin
        sine_beta = (sine_above * cosine + cosine_above * sine) * per_mass
        cosine_beta = (cosine_above * cosine - sine_above * sine) * per_mass
        right += (upper_sine * square - normal * sine_beta) + q * free_alpha
        opens += upper_cosine * square - normal * cosine_beta
        if loads is not None:
            right, opens = with_push(loads, motion, model, phase, i, i - 1, right, opens)
        # eliminate that row (section 8)
        pivot = 1.0 / (diagonal + q * q_turns)
        coupling = p * q_turns - cosine_beta
        part = coupling * pivot
        alone = right * pivot
        above.alone = alone
        above.free_opening = opens
        here.part = part
        here.turn_above = q_turns
        here.sine_beta = sine_beta
        # a joint that slides has a given T
        passed, taken = alone, part * coupling
        if slides:
            above.pivot = pivot
            slid = joints.sliding[i - 1] != 0.0
            passed, taken = where(slid, above.given, alone), where(slid, 0.0, taken)
        # the row of the joint below
        diagonal = diagonal_below - taken
        right = right_below + (normal_above * sine_beta - coupling * passed)
        opens = opens_below - normal_above * cosine_beta
    joint_row(room, n - 1).pivot = 1.0 / diagonal
    return right, opens


@leaf
def _spin_below(phase, motion, i, n):
    """Return the rate of rotation of the body below joint i (rad/s)."""
    if i + 1 < n:
        return phase.theta_rate[i + 1] + motion.omega
    return motion.omega


@leaf
def _over_joint(model, phase, motion, loads, joints, room, i, spin, spin_below, couple, slides):
    """Return the contribution of block i to the row of the joint under it; couple: N m, on the block from above.

    Returns half of the opening (m), the lever of T_i (m), free alpha (rad/s2), and the block's part of diagonal, right
    side and opening.
    """
    blocks, here = model.blocks, joint_row(room, i)
    normal, per_masses, per_inertia = joints.normal[i], blocks.per_masses[i], blocks.per_inertia[i]
    both_spins = spin + spin_below
    square = spin * spin
    lower_sine, lower_cosine = blocks.centroid[i] * here.sine, blocks.centroid[i] * here.cosine
    quarter = 0.25 * phase.opening[i]  # avoids a product that a half would need below
    half = quarter + quarter
    p = lower_cosine + half
    p_turns = p * per_inertia
    # rotation of the block without T
    couple = (normal * lower_sine - here.turned) + couple
    if slides:
        couple += here.across
    if loads is not None:
        couple = with_couple(loads, motion, model, phase, i, couple)
    free_alpha = per_inertia * couple
    # its part of the row
    diagonal = per_masses + p * p_turns
    right = phase.opening_rate[i] * both_spins + (p * free_alpha - lower_sine * square)
    opens = normal * per_masses + (lower_cosine * square + quarter * both_spins * both_spins)
    if slides:
        opens += phase.slip_rate[i] * both_spins
        right -= 0.25 * phase.slip[i] * both_spins * both_spins
    if loads is not None:
        right, opens = with_push(loads, motion, model, phase, i, i, right, opens)
    here.free_alpha = free_alpha
    here.turn_below = p_turns
    return half, p, free_alpha, diagonal, right, opens


@leaf
def _under(row, slides):
    """Return sine and cosine of the angle of the block below to the normal of a joint."""
    if slides:
        return row.under_sine, row.under_cosine
    return row.sine, row.cosine


@leaf
def _upwards(model, phase, motion, joints, room, right, opens, slides):
    """Compute the forces along the joints from the base joint upwards, and the accelerations that follow from them.

    right, opens: of the base joint, without the acceleration of the base.
    """
    n, blocks = model.n, model.blocks
    last = joint_row(room, n - 1)
    # the base: gravity is an upward acceleration; joint n is turned relative to the base, by theta_n / 2 if upright
    along, lift = motion.ax, motion.az + model.settings.gravity
    if any_of(motion.theta != 0.0):
        base_sine, base_cosine = sine_cosine(motion.theta)
        along, lift = along * base_cosine - lift * base_sine, along * base_sine + lift * base_cosine
    sine_above, cosine_above = _under(last, slides)
    right += (along * cosine_above - lift * sine_above) + 0.5 * phase.opening[n - 1] * motion.alpha
    opens -= along * sine_above + lift * cosine_above
    force = right * last.pivot
    if slides:
        force = _slide(blocks, phase, last, joints, n - 1, n, force)

    swung_below = 0.0  # alpha of the block below times the height of its top face above its centroid
    alpha_below = motion.alpha
    # T of the joint above block i, then its rotation and opening
    for i in range(n - 1, 0, -1):
        here, above = joint_row(room, i), joint_row(room, i - 1)
        force_above = above.alone - here.part * force
        if slides:
            force_above = _slide(blocks, phase, above, joints, i - 1, n, force_above)
        alpha = here.free_alpha - here.turn_below * force - here.turn_above * force_above
        opens += here.sine_beta * force_above
        _move(phase, motion, here, blocks, i, alpha, alpha_below, swung_below, opens, slides)
        joints.tangential[i] = force
        opens = above.free_opening - here.sine_beta * force
        swung_below = blocks.upper[i] * alpha
        force, alpha_below = force_above, alpha
    # the top block
    here = joint_row(room, 0)
    alpha = here.free_alpha - here.turn_below * force
    _move(phase, motion, here, blocks, 0, alpha, alpha_below, swung_below, opens, slides)
    joints.tangential[0] = force


@leaf
def _move(phase, motion, here, blocks, i, alpha, alpha_below, swung_below, opens, slides):
    """Store the accelerations of block i."""
    opening = opens + here.sine * (blocks.centroid[i] * alpha - swung_below)
    if slides:
        opening += 0.5 * phase.slip[i] * (alpha + alpha_below) + (here.sine - here.under_sine) * swung_below
    phase.theta_acceleration[i] = alpha - motion.alpha
    phase.opening_acceleration[i] = opening


@kernel
def _shear_towards(blocks, phase, joints, i, n, towards):
    """Return the shear of the pressure of joint i (N), whose edges coincide, as it begins to slide in a direction."""
    sine, _ = half_sine_cosine(phase.theta[i] - phase.theta[i + 1] if i + 1 < n else phase.theta[i])
    felt = opening_felt(phase.opening[i], phase.slip[i], 2.0 * sine)
    at_rim = rim_force(blocks, i, felt, 2.0 * sine, phase.slip[i] + BARELY * towards)
    return pressure_shear(joints.normal[i], sine, at_rim)


@leaf
def _slide(blocks, phase, row, joints, i, n, needed):
    """Return T of joint i and store the acceleration of its slip; needed: the force that would prevent sliding (N)."""
    way, bears, given = joints.sliding[i], joints.shear_capacity[i], row.given
    sticks = way == 0.0
    # edges of both faces that coincide: of the lower one those count towards which the joint may begin to slide
    beyond = magnitude(needed - joints.pressure_shear[i]) > bears - row.at_edges
    begins = sticks & (row.at_edges > 0.0) & beyond
    if any_of(begins):
        # the direction whose bound on T, of its own edges, is exceeded or nearer
        forwards = _shear_towards(blocks, phase, joints, i, n, 1.0)
        backwards = _shear_towards(blocks, phase, joints, i, n, -1.0)
        found = where(needed > 0.5 * (forwards + backwards), backwards, forwards)
        joints.pressure_shear[i] = where(begins, found, joints.pressure_shear[i])
    # flag a joint that sticks although its capacity is exceeded
    beyond = magnitude(needed - joints.pressure_shear[i]) > bears
    joints.overcome[i] = where(sticks & beyond, 1.0, joints.overcome[i])
    phase.slip_acceleration[i] = where(sticks, 0.0, (given - needed) / row.pivot)
    phase.friction_power[i] = where(sticks, 0.0, way * phase.slip_rate[i] * bears)
    return where(sticks, needed, given)


@kernel
def exact_top_motion(model, phase, ux, rate, turn=0.0, spin=0.0):
    """Fill `ux` (m) and `rate` (m/s) with horizontal displacement and velocity of the top faces: rows of n.

    Relative to the column as built and to the base. turn, spin: rotation of the base, rad clockwise, and its rate.
    """
    displacement = 0.0
    velocity = 0.0
    turn_below, spin_below = turn, spin
    slides = can_slide(model)
    for i in range(model.n - 1, -1, -1):
        # rotations of block and joint
        height = model.blocks.height[i]
        theta = phase.theta[i] + turn
        omega = phase.theta_rate[i] + spin
        opening = phase.opening[i]
        phi = 0.5 * (theta + turn_below)
        turn_below, spin_under = theta, spin_below
        # angles as built
        if slides:
            theta, phi = theta + model.blocks.tilt[i], phi + model.blocks.lean[i]
        # opening along the normal of the joint, height along the block
        sine, cosine = sine_cosine(theta)
        sine_phi, cosine_phi = sine_cosine(phi)
        displacement += opening * sine_phi + height * sine
        velocity += phase.opening_rate[i] * sine_phi + opening * 0.5 * (omega + spin_under) * cosine_phi
        velocity += height * omega * cosine
        # slip along the joint
        if slides:
            displacement += phase.slip[i] * cosine_phi
            velocity += phase.slip_rate[i] * cosine_phi - phase.slip[i] * 0.5 * (omega + spin_under) * sine_phi
        ux[i] = displacement - model.blocks.built_x[i] if slides else displacement
        rate[i] = velocity
        spin_below = omega
