"""Exact propagation of the linear column while every joint is in full contact (modal_steps.py).

About its rest the column has 2 n modes, excited by the base along x, and along z with gravity.
"""

from ...engine.modal_steps import (
    OPENS,
    ORDER,
    Drive,
    Modal,
    attempt_of,
    bounds_of,
    multiply,
    sweep_of,
)
from ...layout.modal import inverses_of, limits_of, modes_of, parts_of, shapes_of
from ...layout.spaces import INTERPOLATION_PART, OK
from ...numba_ext.jit import kernel, leaf
from ...numba_ext.views import FieldTable
from ..formulations.base_motion import base_line, base_motion_beside, wave, wave_amplitude
from ..formulations.dispatch import evaluate
from ..formulations.slips import keep_slips, shear_margin, something_slides
from ..joint.sliding import can_slide
from ..sections.section import ends_of
from .stage import stage

__all__ = ["OPENS", "ORDER", "attempt", "available", "forget", "longest_step", "suits"]
CHANGES = 2.0  # the shear margin left at the end of a half step must be this many times its change over it

_segments = FieldTable(first=2, second=2, third=2).over_begin  # of 2 n numbers


@leaf
def available(model):
    """Return True if the model has modal data."""
    return model.settings.has_modes != 0.0


@kernel
def _multiply(model, matrices, x, y, segments):
    """Multiply one to three segments of 2 n numbers of row x by the matrices of all parts; fill row y."""
    n, parts = model.n, parts_of(model)
    m = 2 * n // parts
    for part in range(parts):
        multiply(matrices[part * m * m :], _segments(x, n), _segments(y, n), part * m, m, segments)


@leaf
def _dips(c_0, rate_0, c_1, rate_1, h):
    """Return True if the cubic through values and rates at both ends of `h` s may reach zero."""
    # a cubic falls below its ends by 4/27 of h times the change of the rate at most
    lowest = min(c_0, c_1)
    if rate_0 < 0.0 and rate_1 > 0.0:
        lowest -= 4.0 / 27.0 * h * (rate_1 - rate_0)
    return not lowest > 0.0


@leaf
def _joint_turn(phase, i, n):
    """Return the rotation of joint i (rad), its rate and its acceleration."""
    # the joint over the base
    if i + 1 == n:
        return phase.theta[i], phase.theta_rate[i], phase.theta_acceleration[i]
    return (
        phase.theta[i] - phase.theta[i + 1],
        phase.theta_rate[i] - phase.theta_rate[i + 1],
        phase.theta_acceleration[i] - phase.theta_acceleration[i + 1],
    )


@kernel
def _opens(model, p, q, h):
    """Return True if a corner of a joint may open or lose its pressure in the `h` s between the phases p and q.

    The corner at +-width/2 is pressed by -opening -+ width/2 * slope, with an upper bound of the slope. The corners of
    a contact that has slipped, or is off its axis, are its ends, measured from the middle of the joint.
    """
    n = model.n
    for i in range(n):
        # corners of the contact, m
        eta = model.blocks.damping[i]
        half = 0.5 * model.blocks.width[i]
        corner, other = half, -half
        # ends after a slip, from half-way between the middles of both faces
        if can_slide(model):
            other, corner = ends_of(model.blocks, i, p.slip[i])
            other, corner = other + 0.5 * p.slip[i], corner + 0.5 * p.slip[i]
            half = max(corner, -other)
        # rotation of the joint in both phases, with rate and acceleration
        turn_p, spin_p, turned_p = _joint_turn(p, i, n)
        turn_q, spin_q, turned_q = _joint_turn(q, i, n)
        # far from opening: neither corner can reach it
        rate = half * max(abs(spin_p), abs(spin_q)) + max(abs(p.opening_rate[i]), abs(q.opening_rate[i]))
        reach = h * rate
        if eta > 0.0:
            reach += eta * rate
            opened = max(abs(p.opening_acceleration[i]), abs(q.opening_acceleration[i]))
            reach += h * eta * (half * max(abs(turned_p), abs(turned_q)) + opened)
        if -max(p.opening[i], q.opening[i]) - half * max(abs(turn_p), abs(turn_q)) > reach:
            continue
        # each corner: depth and, with damping, pressure over the stiffness
        for _ in range(2):
            c_p = corner * turn_p - p.opening[i]
            c_q = corner * turn_q - q.opening[i]
            v_p = corner * spin_p - p.opening_rate[i]
            v_q = corner * spin_q - q.opening_rate[i]
            if _dips(c_p, v_p, c_q, v_q, h):
                return True
            if eta > 0.0:
                a_p = corner * turned_p - p.opening_acceleration[i]
                a_q = corner * turned_q - q.opening_acceleration[i]
                if _dips(c_p + eta * v_p, v_p + eta * a_p, c_q + eta * v_q, v_q + eta * a_q, h):
                    return True
            corner = other
    return False


@leaf
def _least_margin(work):
    """Return the least margin of shear capacity over tangential force (N) among the joints."""
    least = shear_margin(work.joints, 0)
    for i in range(1, work.n):
        least = min(least, shear_margin(work.joints, i))
    return least


@leaf
def _keep_joints(work):
    """Copy the resultants of the joints, just evaluated, to those of the middle of the step."""
    joints, halfway = work.joints, work.joints_halfway
    # normal and tangential force, moment, loaded length
    for i in range(work.n):
        halfway.normal[i], halfway.tangential[i] = joints.normal[i], joints.tangential[i]
        halfway.moment[i], halfway.length[i] = joints.moment[i], joints.length[i]
    work.interpolation.knows_middle = 1.0


@kernel
def suits(column):
    """Return True if a modal step may be attempted: every joint is in full contact at its start and sticks."""
    return not something_slides(column.work) and not _opens(column.model, column.work.start, column.work.start, 0.0)


@leaf
def forget(work):
    """Mark the trend of the remainder as unknown: at the first step of a call, or after other methods."""
    work.trend.known = 0.0


@leaf
def longest_step(model):
    """Return the longest step (s); beyond it the coupling of the modes is not small."""
    return limits_of(model).longest


@leaf
def _modal_of(model, work):
    size, rows = 2 * model.n, (stage(work, 2), stage(work, 3), stage(work, 4))
    trend = work.slopes, work.curvatures, work.trend
    return Modal(size, size, modes_of(model), *rows, *trend, work.responses, work.latest)


@leaf
def _drive(column, t):
    base, samples = column.base, column.samples
    amplitude = wave_amplitude(base, samples)
    omega = base.wave_omega if amplitude != 0.0 else 0.0
    # straight line and harmonic part of the base acceleration
    ax, jx, az, jz = base_line(base, samples, t)
    sine, cosine = wave(base, t) if amplitude != 0.0 else (0.0, 0.0)
    line = ax, column.model.settings.gravity + az
    return Drive(line, (jx, jz), (amplitude * sine,), (amplitude * cosine,), amplitude, omega, sine, cosine)


@kernel
def _begin(column, modal):
    _multiply(column.model, inverses_of(column.model), column.work.start.row, modal.first.row, 3)


@kernel
def _reach(column, modal, half, t, h, sine):
    """Evaluate the column at the modal state in the middle (half 0) or at the end; check its joints (`sweep_of`)."""
    model, work = column.model, column.work
    # from modal to block coordinates
    here, to = (stage(work, 1), modal.mean) if half == 0 else (work.end, modal.last)
    _multiply(model, shapes_of(model), to.row, here.row, 2)
    # evaluate on the base
    motion = base_motion_beside(column, t, sine)
    then = motion.ax, model.settings.gravity + motion.az
    evaluate(column, here, motion)
    if _opens(model, work.start if half == 0 else stage(work, 1), here, 0.5 * h):
        return OPENS, then
    if half == 0:
        _keep_joints(work)
    # margin against sliding
    if can_slide(model):
        before, margin = work.trend.margin, _least_margin(work)
        work.trend.margin = margin
        if not margin > 0.0 or (half == 1 and min(margin, before) <= CHANGES * abs(margin - before)):
            return OPENS, then
    # accelerations of the modes
    _multiply(model, inverses_of(model), here.accelerations, to.accelerations, 1)
    return OK, then


@kernel
def _end(column, modal):
    _multiply(column.model, shapes_of(column.model), modal.last.row, column.work.end.row, 3)


_attempt = attempt_of(sweep_of(_begin, _reach, _end))


@kernel
def attempt(column, t, h):
    """Make one step of `h` s from `work.start` to `work.end`; return (code, error in tolerances)."""
    model, work, control = column.model, column.work, column.state.control
    if can_slide(model):
        keep_slips(work, stage(work, 1))
        keep_slips(work, work.end)
    # error bounds of the step
    limits = limits_of(model)
    scales = control.rotation_scale, control.rate_scale
    bounds = bounds_of(limits, model.settings.tolerance, *scales, INTERPOLATION_PART)
    return _attempt(column, _modal_of(model, work), _drive(column, t), bounds, int(limits.sweeps), t, h)
