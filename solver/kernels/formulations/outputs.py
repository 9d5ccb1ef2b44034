"""All that a user can see of a column at one instant: one output row."""

import math

from ..jit import kernel
from ..joint.law import joint_peak_pressure
from ..joint.section import ends_of
from ..joint.sliding import opening_felt, opening_rate_felt, slip_of
from ..layout import OK
from .either import is_exact, joint_opening, joint_slope, rotation, top_motion
from .slips import evaluate_anew


@kernel
def observe(column, phase, motion, row):
    """Fill an output row with everything visible of a phase, and its accelerations. Returns a code."""
    code = evaluate_anew(column, phase, motion)
    if code != OK:
        return code
    model, work, joints, base = column.model, column.work, row.joints, row.base
    n = model.n
    blocks = model.blocks
    exact = is_exact(model)
    top_motion(model, phase, joints.ux, work.tops.between_rate, motion.theta, motion.omega)
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
            sine, cosine = math.sin(phi), math.cos(phi)
        normal, tangential = work.joints.normal[i], work.joints.tangential[i]
        joints.theta[i] = turn + motion.theta
        if exact:
            half = 0.5 * (turn + motion.theta)
            dip = -2.0 * math.sin(blocks.tilt[i] + half) * math.sin(half)  # cosine of the rotation less that as built
            rise += opening * cosine - (slip * sine - blocks.offset[i] * math.sin(blocks.lean[i]))
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
                base.My = base.My * math.cos(0.5 * (turn - turn_below)) - 0.5 * opening * tangential
                base.My += 0.5 * slip * normal
    if not exact:
        weight = 0.0
        for i in range(n):
            weight += blocks.mass[i] * (model.settings.gravity + motion.az - phase.opening_acceleration[i])
        base.Fz = -weight
    return OK
