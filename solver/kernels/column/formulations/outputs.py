"""The output row: all quantities of a column at one instant that a user can see."""

from ...layout.spaces import OK, PORTS, ROW, SPOTS
from ...numba_ext.jit import kernel, leaf, varied
from ...numba_ext.numbers import half_sine_cosine, sine_cosine
from ..joint.law import law_of
from ..joint.resultants import largest_pressure
from ..joint.sliding import can_slide, opening_felt, opening_rate_felt, slip_if
from ..sections.section import contact_of
from .bonds import lost_share
from .dispatch import evaluate, top_motion
from .loads import places_of_ports, ports_of
from .ports import see_points
from .slips import evaluate_after_jump

_ports, _spots, _SEEN = PORTS.over, SPOTS.over, len(SPOTS.fields)
_ROW_PER_N, _ROW_BESIDE = ROW.per_n, ROW.beside


@kernel
def observe(column, phase, motion, row):
    """Fill an output row with all outputs of a phase, and the phase with its accelerations; return a code."""
    code = evaluate_after_jump(column, phase, motion)
    if code == OK:
        _show_all(column, phase, motion, row)
    return code


@kernel
def observe_as_it_slides(column, phase, motion, row):
    """Run `observe` with the joints that slid in the last evaluation, whatever the forces; return a code."""
    code = evaluate(column, phase, motion)
    if code == OK:
        _show_all(column, phase, motion, row)
    return code


@kernel
def _show_all(column, phase, motion, row):
    """Fill an output row with all outputs of an evaluated phase."""
    top_motion(column, phase, row.joints.ux, column.work.tops.between_rate, motion.theta, motion.omega)
    show(column, phase, column.work.joints, motion, row)
    # outputs of ports, then of bonds, behind the row
    behind = row.buffer[_ROW_PER_N * column.model.n + _ROW_BESIDE :]
    show_ports(column, phase, motion, behind)
    _show_bonds(column, behind[_SEEN * ports_of(column) :])


@leaf
def show_ports(column, phase, motion, row):
    """Fill a row with the motion of the ports (SPOTS) in an evaluated phase."""
    count = ports_of(column)
    if count > 0:
        see_points(motion, column.model, phase, _ports(places_of_ports(column), count), _spots(row, count))


@leaf
def _show_bonds(column, row):
    """Fill a row with the share of each bond that is left in the last evaluation."""
    joints = column.work.joints
    for i in range(int(column.work.slips.bonds)):
        row[i] = 1.0 - lost_share(column.model, i, joints.bonded_left[i], joints.bonded_right[i])


@varied
def show(column, phase, resultants, motion, row):
    """Fill an output row, except u_x, of a phase already evaluated; resultants: those of its joints, as work.joints."""
    model, joints, base = column.model, row.joints, row.base
    n, blocks = model.n, model.blocks
    slides = can_slide(model)
    rise = 0.0  # m, of the top face of the block below
    turn_below, spin_below = 0.0, 0.0
    for i in range(n - 1, -1, -1):
        # motion of block and joint
        turn, spin = phase.theta[i], phase.theta_rate[i]
        opening, opening_rate = phase.opening[i], phase.opening_rate[i]
        slip, slip_rate = slip_if(slides, model, phase, i)
        theta, phi = turn + motion.theta, 0.5 * (turn + turn_below) + motion.theta
        if slides:
            phi += blocks.lean[i]
        sine, cosine = sine_cosine(phi)
        sine_slope, cosine_slope = half_sine_cosine(turn - turn_below)
        slope, slope_rate = 2.0 * sine_slope, cosine_slope * (spin - spin_below)
        # rise of the centroid, without the loss of digits in 1 - cos
        sine_half, _ = half_sine_cosine(theta)
        sine_built = sine_half
        rise += opening * cosine
        if slides:
            sine_built, _ = sine_cosine(blocks.tilt[i] + 0.5 * theta)
            sine_lean, _ = sine_cosine(blocks.lean[i])
            rise -= slip * sine - blocks.offset[i] * sine_lean
        dip = -2.0 * sine_built * sine_half  # cosine of the inclination less that as built
        joints.uz[i] = rise + blocks.centroid[i] * dip
        rise += blocks.height[i] * dip
        # outputs of the joint
        felt, felt_rate = opening, opening_rate
        if slides:
            felt = opening_felt(opening, slip, slope)
            felt_rate = opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate)
        joints.theta[i] = theta
        show_joint(model, i, resultants, sine, cosine, felt, slope, felt_rate, slope_rate, slip, joints)
        # base reaction
        if i == n - 1:
            normal, moment, tangential = resultants.normal[i], resultants.moment[i], resultants.tangential[i]
            base.Fx = joints.S[i]
            base.Fz = -(normal * cosine - tangential * sine)
            base.My = moment * cosine_slope - 0.5 * opening * tangential + 0.5 * slip * normal
        turn_below, spin_below = turn, spin


@leaf
def show_joint(model, i, resultants, sine, cosine, opening, slope, opening_rate, slope_rate, slip, joints):
    """Fill the outputs of joint i, whose normal is turned by an angle of this sine and cosine."""
    normal, moment, tangential = resultants.normal[i], resultants.moment[i], resultants.tangential[i]
    blocks = model.blocks
    contact, law, length = contact_of(blocks, i, slip), law_of(blocks, i), resultants.length[i]
    # forces, then contact, pressure and slip
    joints.N[i] = normal
    joints.M[i] = moment
    joints.S[i] = -(normal * sine + tangential * cosine)
    joints.T[i] = -tangential
    joints.contact[i] = length / (contact.right - contact.left)
    motion = opening, slope, opening_rate, slope_rate
    joints.sigma_max[i] = largest_pressure(model, resultants, i, contact, law, length, *motion)
    joints.slip[i] = slip - blocks.offset[i]
