"""All that a user can see of a column at one instant: one output row."""

from ..jit import kernel
from ..joint.law import joint_peak_pressure
from ..joint.section import ends_of
from ..joint.sliding import can_slide, opening_felt, opening_rate_felt, slip_of
from ..layout import OK
from ..numbers import sine_cosine
from .either import is_exact, joint_opening, joint_slope, rotation, top_motion
from .slips import evaluate_anew


@kernel
def observe(column, phase, motion, row):
    """Fill an output row with everything visible of a phase, and its accelerations. Returns a code."""
    code = evaluate_anew(column, phase, motion)
    if code == OK:
        top_motion(column.model, phase, row.joints.ux, column.work.tops.between_rate, motion.theta, motion.omega)
        show(column, phase, motion, row)
    return code


@kernel
def show(column, phase, motion, row):
    """The same, but u_x, of a phase that has been evaluated: work.joints holds its resultants."""
    model, work, joints, base = column.model, column.work, row.joints, row.base
    n = model.n
    blocks = model.blocks
    exact, slides = is_exact(model), can_slide(model)
    rise = 0.0  # of the top face of the block below
    for i in range(n - 1, -1, -1):
        turn = rotation(model, phase.theta, i)
        turn_below = rotation(model, phase.theta, i + 1)
        opening, opening_rate = joint_opening(model, phase.opening, i), joint_opening(model, phase.opening_rate, i)
        slope, slope_rate = joint_slope(model, phase, i)
        slip, slip_rate = slip_of(model, phase, i)
        phi = 0.5 * (turn + turn_below) + motion.theta + blocks.lean[i]
        sine, cosine = phi, 1.0  # in the first-order model
        if exact:
            sine, cosine = sine_cosine(phi)
        normal, tangential = work.joints.normal[i], work.joints.tangential[i]
        joints.theta[i] = turn + motion.theta
        if exact:
            half = 0.5 * (turn + motion.theta)
            sine_half, _ = sine_cosine(half)
            sine_built = sine_half
            rise += opening * cosine
            if slides:
                sine_built, _ = sine_cosine(blocks.tilt[i] + half)
                sine_lean, _ = sine_cosine(blocks.lean[i])
                rise -= slip * sine - blocks.offset[i] * sine_lean
            dip = -2.0 * sine_built * sine_half  # cosine of the rotation less that as built
            joints.uz[i] = rise + blocks.centroid[i] * dip
            rise += blocks.height[i] * dip
        else:
            joints.uz[i] = -phase.opening[i]
        joints.N[i] = normal
        joints.M[i] = work.joints.moment[i]
        joints.S[i] = -(normal * sine + tangential * cosine)
        joints.T[i] = -tangential
        left, right = ends_of(blocks, i, slip)
        joints.contact[i] = work.joints.length[i] / (right - left)
        joints.sigma_max[i] = joint_peak_pressure(
            left,
            right,
            blocks.stiffness[i],
            blocks.damping[i],
            opening_felt(opening, slip, slope),
            slope,
            opening_rate_felt(opening_rate, slip, slip_rate, slope, slope_rate),
            slope_rate,
        )
        joints.slip[i] = slip - blocks.offset[i]
        if i == n - 1:
            base.Fx = joints.S[i]
            base.Fz = -(normal * cosine - tangential * sine)
            base.My = work.joints.moment[i]
            if exact:
                _, cosine_turn = sine_cosine(0.5 * (turn - turn_below))
                base.My = base.My * cosine_turn - 0.5 * opening * tangential
                base.My += 0.5 * slip * normal
    if not exact:
        weight = 0.0
        for i in range(n):
            weight += blocks.mass[i] * (model.settings.gravity + motion.az - phase.opening_acceleration[i])
        base.Fz = -weight
