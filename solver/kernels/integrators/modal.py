"""Exact propagation of the linear column while every joint is in full contact, corrected for the nonlinear remainder.

About rest the column is 2 n modes p'' + beta p' + omega^2 p = push * a(t) + r. The remainder r holds all other terms of
the exact equations: small, and as smooth as the motion. The response of a mode to its start, to the base (linear in
time plus harmonic) and to forces 1, t, t^2 is known in closed form for a step of any length, so that the joint modes
limit neither stability nor accuracy. r is evaluated at the start, in the middle and at the end and taken as the
parabola through the three: an exponential integrator (M. Hochbruck, A. Ostermann, Exponential integrators, Acta
Numerica 19 (2010) 209-286), of order 4 where the modes are slow.
"""

import math
from typing import NamedTuple

from ..formulations.base_motion import base_line, base_motion_beside, wave, wave_amplitude
from ..formulations.dispatch import evaluate
from ..formulations.slips import keep_slips, shear_margin, something_slides
from ..joint.sliding import can_slide
from ..layout.modal import inverses_of, limits_of, mode_of, parts_of, shapes_of
from ..layout.spaces import INTERPOLATION_PART, OK
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import Table, copy
from ..sections.section import ends_of
from .modal_responses import GRID, response_of, responses_over
from .stage import stage

ORDER = 4  # of the estimated error
INTERPOLATION_ORDER = 6
OPENS = 2  # code, beside those of spaces.py: a joint does not stay in full contact, or begins to slide
CHANGES = 2.0  # the shear margin left at the end of a half step must be this many times its change over it

_segments = Table(first=2, second=2, third=2).over  # of 2 n numbers


@leaf
def available(model):
    """Whether the column may be propagated by modes."""
    return model.settings.has_modes != 0.0


@leaf
def _multiply(matrices, x, y, n, parts, segments):
    """Multiply one to three segments of 2 n numbers of the row x by the matrices of all parts, into the row y."""
    m = 2 * n // parts
    of, to = _segments(x, n), _segments(y, n)
    for part in range(parts):
        matrix = matrices[part * m * m :]
        for i in range(m):
            first, second, third = 0.0, 0.0, 0.0
            for j in range(m):
                factor = matrix[m * i + j]
                begin = part * m + j
                first += factor * of.first[begin]
                if segments > 1:
                    second += factor * of.second[begin]
                if segments > 2:
                    third += factor * of.third[begin]
            place = part * m + i
            to.first[place] = first
            if segments > 1:
                to.second[place] = second
            if segments > 2:
                to.third[place] = third


@leaf
def _dips(c_0, rate_0, c_1, rate_1, h):
    """Whether the cubic through values and rates at both ends of h s may reach zero."""
    lowest = min(c_0, c_1)
    if rate_0 < 0.0 and rate_1 > 0.0:
        lowest -= 4.0 / 27.0 * h * (rate_1 - rate_0)
    return not lowest > 0.0


@leaf
def _joint_turn(phase, i, n):
    """Rotation of a joint, its rate and acceleration."""
    if i + 1 == n:
        return phase.theta[i], phase.theta_rate[i], phase.theta_acceleration[i]
    return (
        phase.theta[i] - phase.theta[i + 1],
        phase.theta_rate[i] - phase.theta_rate[i + 1],
        phase.theta_acceleration[i] - phase.theta_acceleration[i + 1],
    )


@kernel
def _opens(model, p, q, h):
    """Whether a corner of a joint may open, or lose its pressure, in the h s between the phases p and q.

    The corner at +-width/2 is pressed by -opening -+ width/2 * slope, with the slope bounded from above. The corners of
    a contact that has slipped, or is off its axis, are its ends, seen from the middle of the joint.
    """
    n = model.n
    for i in range(n):
        eta = model.blocks.damping[i]
        half = 0.5 * model.blocks.width[i]
        corner, other = half, -half
        if can_slide(model):
            other, corner = ends_of(model.blocks, i, p.slip[i])
            other, corner = other + 0.5 * p.slip[i], corner + 0.5 * p.slip[i]
            half = max(corner, -other)
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
    """Least margin of shear capacity over force along the joint, N, among the joints."""
    least = shear_margin(work.joints, 0)
    for i in range(1, work.n):
        least = min(least, shear_margin(work.joints, i))
    return least


@leaf
def _keep_joints(work):
    """Store the resultants of the middle of the step, now evaluated."""
    joints, halfway = work.joints, work.joints_halfway
    for i in range(work.n):
        halfway.normal[i], halfway.tangential[i] = joints.normal[i], joints.tangential[i]
        halfway.moment[i], halfway.length[i] = joints.moment[i], joints.length[i]
    work.interpolation.knows_middle = 1.0


@kernel
def suits(column):
    """Whether a step may be tried: every joint is in full contact at its start, and sticks."""
    return not something_slides(column.work) and not _opens(column.model, column.work.start, column.work.start, 0.0)


@leaf
def forget(work):
    """Mark the trend of the remainder as unknown: this is the first step of a call, or follows other methods."""
    work.trend.known = 0.0


@leaf
def longest_step(model):
    """Longest step, s; beyond it the coupling of the modes is not small."""
    return limits_of(model).longest


@kernel
def attempt(column, t, h):
    """One step of h seconds from work.start to work.end; returns (code, error in tolerances).

    The error is that of the correction or of interpolation, whichever limits the step more. The code is OPENS where a
    joint does not stay in full contact. If no joint is damped a second sweep makes the step symmetric in time, which
    keeps the energy over any number of steps; one leaves a drift of 6e-11 in a period.
    """
    code, error = OK, 0.0
    if can_slide(column.model):
        keep_slips(column.work, stage(column.work, 1))
        keep_slips(column.work, column.work.end)
    sweeps = int(limits_of(column.model).sweeps)
    for sweep in range(sweeps):
        if code == OK and error <= 1.0:
            code, error = _sweep(column, t, h, sweep == 0, sweep + 1 == sweeps)
    return code, error


class _Drive(NamedTuple):
    """The base over a step: at its start, with gravity, in the line and the wave that it follows; and the step."""

    ax: float  # m/s2
    jx: float  # m/s3
    lift: float  # m/s2, of gravity too
    jz: float
    amplitude: float  # m/s2, of the wave
    omega: float  # 1/s
    wave_sine: float  # m/s2
    wave_cosine: float
    known: bool  # whether the trend of the remainder is that of the step before
    span: float  # s, the step on the grid, and
    excess: float  # the rest of it


@kernel
def _respond_to(column, drive, responses, half, is_first):
    """Modal coordinates and rates in the middle of the step (half 0), or at its end by the values known by then."""
    model, work = column.model, column.work
    first, mean = stage(work, 2), stage(work, 3)
    to = mean if half == 0 else stage(work, 4)
    omega, per_step = drive.omega, 1.0 / drive.span
    for k in range(2 * work.n):
        mode = mode_of(model, k)
        response = response_of(responses, k)
        over = response.half if half == 0 else response.whole
        p, v = first.coordinates[k], first.rates[k]
        square, push, lift = mode.square, mode.push, mode.lift
        force = push * drive.ax + lift * drive.lift
        slope = push * drive.jx + lift * drive.jz
        force_sine, force_cosine = push * drive.wave_sine, push * drive.wave_cosine
        if half == 0 and is_first:
            first.accelerations[k] += mode.damping * v + square * p - (force + force_sine)
        remainder = first.accelerations[k]
        # the trend of the remainder continues from the step before; at the end it is taken through the value in the
        # middle
        curvature = work.curvatures[k] if drive.known else 0.0
        if half == 1:
            slope += 2.0 * (mean.accelerations[k] - remainder) * per_step - 0.25 * drive.span * curvature
        elif drive.known:
            slope += work.slopes[k]
        force += remainder
        to.coordinates[k] = (
            (over.rest * p + over.impulse * v)
            + (over.steady * force + over.ramp * slope + over.parabola * curvature)
            + (over.cosine * force_sine + over.sine * force_cosine)
        )
        to.rates[k] = (
            (over.impulse_rate * v - square * over.impulse * p)
            + (over.impulse * force + over.steady * slope + over.ramp * curvature)
            + ((over.impulse - omega * over.sine) * force_sine + omega * over.cosine * force_cosine)
        )


@kernel
def _correct(column, drive, responses, ax_then, lift_then, is_last):
    """Correct the end for the remainder as a parabola; the error in tolerances, of that or of interpolation."""
    model, work, settings = column.model, column.work, column.model.settings
    first, mean, last = stage(work, 2), stage(work, 3), stage(work, 4)
    omega, span, per_step = drive.omega, drive.span, 1.0 / drive.span
    wrong, wrong_rate, hidden = 0.0, 0.0, 0.0
    for k in range(2 * work.n):
        mode = mode_of(model, k)
        response = response_of(responses, k)
        over, still = response.whole, response.steady
        beta, square, push, lift = mode.damping, mode.square, mode.push, mode.lift
        r_0, r_1 = first.accelerations[k], last.accelerations[k]
        bend = 2.0 * (r_0 - 2.0 * mean.accelerations[k] + r_1)  # r = r_0 + (...) s + bend s^2, s from 0 to 1
        # responses to s and s^2: coordinates, rates
        line, parabola = over.ramp * per_step, 2.0 * over.parabola * per_step * per_step
        line_rate, parabola_rate = over.steady * per_step, 2.0 * over.ramp * per_step * per_step
        change = bend - 0.5 * span * span * (work.curvatures[k] if drive.known else 0.0)
        p = last.coordinates[k] + change * (parabola - 0.5 * line)
        v = last.rates[k] + change * (parabola_rate - 0.5 * line_rate)
        force = push * ax_then + lift * lift_then + r_1
        v += drive.excess * (force - beta * v - square * p)
        p += drive.excess * v
        last.coordinates[k] = p
        last.rates[k] = v
        last.accelerations[k] = force - beta * v - square * p

        wrong += mode.size * abs(bend * (line - parabola))
        wrong_rate += mode.size * abs(bend * (line_rate - parabola_rate))
        # the free motion: without the response to the forces
        slope = (r_1 - r_0 - bend) * per_step
        work.slopes[k] = slope + 2.0 * bend * per_step if is_last else slope
        work.curvatures[k] = 2.0 * bend * per_step * per_step
        force = r_0 + push * drive.ax + lift * drive.lift
        slope += push * drive.jx + lift * drive.jz
        per_square, in_phase, across = still.per_square, push * still.sine, push * still.cosine
        hidden += still.forced * abs(drive.amplitude)
        slope *= per_square
        forced = in_phase * drive.wave_sine + across * drive.wave_cosine
        p = first.coordinates[k] - per_square * (force - beta * slope) - forced
        v = first.rates[k] - slope - omega * (in_phase * drive.wave_cosine - across * drive.wave_sine)
        hidden += still.free * (abs(p) + still.per_rate * abs(v))
    control = column.state.control
    allowed, allowed_rate = settings.tolerance * control.rotation_scale, settings.tolerance * control.rate_scale
    error = limits_of(model).third * max(wrong / allowed, wrong_rate / allowed_rate)
    hidden /= INTERPOLATION_PART * allowed
    return max(error, hidden ** (ORDER / INTERPOLATION_ORDER)) if hidden > 0.0 else error


@kernel
def _sweep(column, t, h, is_first, is_last):
    """One sweep of `attempt`; the remainder it finds serves the next sweep, that of the last one the next step."""
    model, base, samples, work = column.model, column.base, column.samples, column.work
    n, gravity = model.n, model.settings.gravity
    size = 2 * n
    middle, end = stage(work, 1), work.end
    # modal coordinates, rates and, instead of accelerations, remainders: at the start, in the middle, at the end
    first, mean, last = stage(work, 2), stage(work, 3), stage(work, 4)
    shapes, inverses, parts = shapes_of(model), inverses_of(model), parts_of(model)
    known = work.trend.known != 0.0
    work.trend.known = 0.0
    amplitude = wave_amplitude(base, samples)
    omega = base.wave_omega if amplitude != 0.0 else 0.0
    span = math.floor(h * GRID + 0.5) / GRID
    responses = responses_over(model, work, span, omega)

    if is_first and known:  # the last step has ended here
        copy(first.row, last.row, 3 * size)
    elif is_first:
        _multiply(inverses, work.start.row, first.row, n, parts, 3)
    ax, jx, az, jz = base_line(base, samples, t)
    sine, cosine = wave(base, t) if amplitude != 0.0 else (0.0, 0.0)
    waves = (amplitude * sine, amplitude * cosine)
    drive = _Drive(ax, jx, gravity + az, jz, amplitude, omega, waves[0], waves[1], known, span, h - span)
    late = 0.5 * omega * drive.excess
    turn_sine = responses.made_for.sine + late * responses.made_for.cosine
    turn_cosine = responses.made_for.cosine - late * responses.made_for.sine
    ax_then, lift_then, margin = 0.0, 0.0, 0.0
    for half in range(2):  # in the middle, then at the end with the values known by then
        here = middle if half == 0 else end
        to = mean if half == 0 else last
        _respond_to(column, drive, responses, half, is_first)
        _multiply(shapes, to.row, here.row, n, parts, 2)
        then = t + (0.5 * h if half == 0 else h)
        sine, cosine = sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine
        motion = base_motion_beside(base, samples, then, sine)
        ax_then, lift_then = motion.ax, gravity + motion.az
        code = evaluate(column, here, motion)
        if code != OK:
            return code, 0.0
        if _opens(model, work.start if half == 0 else middle, here, 0.5 * h):
            return OPENS, 0.0
        if half == 0:
            _keep_joints(work)
        if can_slide(model):
            before, margin = margin, _least_margin(work)
            if not margin > 0.0 or (half == 1 and min(margin, before) <= CHANGES * abs(margin - before)):
                return OPENS, 0.0
        _multiply(inverses, here.accelerations, to.accelerations, n, parts, 1)
        for k in range(size):
            mode = mode_of(model, k)
            pushed = mode.push * ax_then + mode.lift * lift_then
            to.accelerations[k] += mode.damping * to.rates[k] + mode.square * to.coordinates[k] - pushed
    error = _correct(column, drive, responses, ax_then, lift_then, is_last)
    _multiply(shapes, last.row, end.row, n, parts, 3)
    work.trend.known = 1.0 if error <= 1.0 else 0.0
    return (OK if math.isfinite(error) else OPENS), error
