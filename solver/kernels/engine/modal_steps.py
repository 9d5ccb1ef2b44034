"""One step of linear modes corrected for a nonlinear remainder, of a column in its plane or of a structure in space.

The modes p'' + beta p' + omega^2 p = push . a(t) + r have a remainder r that holds all other terms of the exact
equations: small, and as smooth as the motion. The response of a mode to its start, to the base (linear in time plus
harmonic) and to forces 1, t, t^2 is known in closed form for a step of any length, so that the joint modes limit
neither stability nor accuracy. r is evaluated at the start, in the middle and at the end and taken as the parabola
through the three: an exponential integrator (M. Hochbruck, A. Ostermann, Exponential integrators, Acta Numerica 19
(2010) 209-286), of order 4 where the modes are slow.
"""

import math
from typing import Any, NamedTuple

from ..layout.modal import mode_at
from ..layout.spaces import INTERPOLATION_BOUND, OK
from ..numba_ext.jit import by_width, kernel, leaf
from ..numba_ext.views import copy
from .modal_responses import GRID, response_of, responses_over

ORDER = 4  # of the estimated error
INTERPOLATION_ORDER = 6
OPENS = 2  # code, beside those of spaces.py: a joint does not stay in full contact, or begins to slide

LEAST_TURN = 10.0  # rad of the fastest mode in such a step: below it the general methods are as good

# Third over second difference of a remainder that varies as fast as twice the fastest motion resolved, for one radian
# of the latter per step: the third of sin(2 x s) is (2 x)^3 / (72 sqrt 3), the second (2 x)^2 / 8.
THIRD_DIFFERENCE = 2.0 * 8.0 / (72.0 * math.sqrt(3.0))


class Modal(NamedTuple):
    """The modes of a column or structure, and its motion in modal coordinates."""

    active: int  # number of modes that move
    room: int  # number of modes that there is room for
    modes: object  # row of records (MODE)
    first: object  # modal coordinates, rates and, instead of accelerations, remainders: at the start,
    mean: object  # in the middle,
    last: object  # at the end of the step
    slopes: object  # of the remainder at the end of the step before, 1/s
    curvatures: object  # 1/s2
    trend: object  # whether these are known
    responses: object  # row, and
    latest: object  # which of the stored ones was used last


class Drive(NamedTuple):
    """The base motion over a step, its components in the order of those of a mode (push, lift, across)."""

    line: tuple[float, ...]  # m/s2, at the start
    slopes: tuple[float, ...]  # m/s3
    sines: tuple[float, ...]  # m/s2, of the wave at the start; it may have less components
    cosines: tuple[float, ...]
    amplitude: float  # m/s2, largest component of the wave
    omega: float  # 1/s
    sine: float  # of the wave at the start
    cosine: float


class Bounds(NamedTuple):
    """The error bounds of a step: coordinates, rates, coordinates between its ends; `third` as in MODAL_LIMITS."""

    place: float
    rate: float
    between: float
    third: float


@leaf
def _by_one(force, mode, components, factor):
    return force + mode.push * factor * components[0]


@leaf
def _by_two(force, mode, components, factor):
    return _by_one(force, mode, components, factor) + mode.lift * factor * components[1]


@leaf
def _by_three(force, mode, components, factor):
    return _by_two(force, mode, components, factor) + mode.across * factor * components[2]


@by_width
def _with_push(force, mode, components, factor):
    """Return a force on a mode plus that of the given components of the base acceleration, times a factor."""
    by = (_by_one, _by_two, _by_three)[len(components) - 1]
    return lambda force, mode, components, factor: by(force, mode, components, factor)


@leaf
def pushed(mode, components, factor):
    """Return the force on a mode by components of the base acceleration, times a factor."""
    return _with_push(-0.0, mode, components, factor)  # which leaves the sign of a zero


@leaf
def set_limits(limits, tolerance, part, longest, damped):
    """Fill `limits` with the limits of steps.

    Parameters
    ----------
    limits : record MODAL_LIMITS
        Filled.
    tolerance : float
        Tolerance of a step.
    part : float
        Interpolation error allowed between the ends of a step, in tolerances.
    longest : float
        Longest step (s).
    damped : bool
        True if a joint is damped: one sweep, else two.
    """
    # phase (rad) of the fastest motion, per step, that the interpolation resolves
    resolved = (INTERPOLATION_BOUND * part * tolerance) ** (1.0 / 6.0)
    limits.third = min(1.0, THIRD_DIFFERENCE * resolved)
    limits.longest = longest
    limits.sweeps = 1.0 if damped else 2.0


@leaf
def pays(limits, square):
    """Return True if steps may be long enough, relative to the fastest mode (square: 1/s2), to be worth it."""
    return limits.longest * math.sqrt(square) >= LEAST_TURN


@leaf
def bounds_of(limits, tolerance, place, rate, part):
    """Return the error bounds of a step, for a tolerance relative to the largest coordinate and rate so far."""
    allowed = tolerance * place
    return Bounds(allowed, tolerance * rate, part * allowed, limits.third)


@leaf
def multiply(matrix, x, y, begin, m, segments):
    """Multiply one to three segments of x by an m x m matrix; fill the same segments of y.

    begin: index of the first element in each segment.
    """
    for i in range(m):
        # element i of each product
        first, second, third = 0.0, 0.0, 0.0
        for j in range(m):
            factor = matrix[m * i + j]
            at = begin + j
            first += factor * x.first[at]
            if segments > 1:
                second += factor * x.second[at]
            if segments > 2:
                third += factor * x.third[at]
        place = begin + i
        y.first[place] = first
        if segments > 1:
            y.second[place] = second
        if segments > 2:
            y.third[place] = third


@kernel
def _respond_to(modal, drive, responses, span, half, is_first):
    """Fill modal coordinates and rates in the middle of the step (half 0) or at its end, by the known remainders."""
    first, mean, known = modal.first, modal.mean, modal.trend.known != 0.0
    to = mean if half == 0 else modal.last
    omega, per_step = drive.omega, 1.0 / span
    for k in range(modal.active):
        mode = mode_at(modal.modes, k)
        response = response_of(responses, k)
        over = response.half if half == 0 else response.whole
        # state at the start, and base force per unit of modal mass
        p, v = first.coordinates[k], first.rates[k]
        square = mode.square
        force = pushed(mode, drive.line, 1.0)
        slope = pushed(mode, drive.slopes, 1.0)
        force_sine, force_cosine = pushed(mode, drive.sines, 1.0), pushed(mode, drive.cosines, 1.0)
        # remainder at the start: acceleration less the linear terms and the base
        if half == 0 and is_first:
            first.accelerations[k] += mode.damping * v + square * p - (force + force_sine)
        remainder = first.accelerations[k]
        # the trend of the remainder continues from the step before; at the end it is taken through the value in the
        # middle
        curvature = modal.curvatures[k] if known else 0.0
        if half == 1:
            slope += 2.0 * (mean.accelerations[k] - remainder) * per_step - 0.25 * span * curvature
        elif known:
            slope += modal.slopes[k]
        # superposition of the responses to start, force, slope, curvature and wave
        force += remainder
        to.coordinates[k] = (
            (over.rest * p + over.impulse * v)
            + (over.steady * force + over.ramp * slope + over.parabola * curvature)
            + (over.cosine * force_sine + over.sine * force_cosine)
        )
        # time derivative of the superposition
        to.rates[k] = (
            (over.impulse_rate * v - square * over.impulse * p)
            + (over.impulse * force + over.steady * slope + over.ramp * curvature)
            + ((over.impulse - omega * over.sine) * force_sine + omega * over.cosine * force_cosine)
        )


@leaf
def take_linear_part(modal, to, then):
    """Turn the accelerations of the modes in `to` into remainders; `then`: components of the base acceleration."""
    for k in range(modal.active):
        mode = mode_at(modal.modes, k)
        force = pushed(mode, then, 1.0)
        to.accelerations[k] += mode.damping * to.rates[k] + mode.square * to.coordinates[k] - force


@kernel
def _correct(modal, drive, responses, bounds, then, span, excess, is_last):
    """Correct the end for the remainder as a parabola; return the error in tolerances, of that or of interpolation."""
    first, mean, last, known = modal.first, modal.mean, modal.last, modal.trend.known != 0.0
    omega, per_step = drive.omega, 1.0 / span
    wrong, wrong_rate, hidden = 0.0, 0.0, 0.0
    for k in range(modal.active):
        mode = mode_at(modal.modes, k)
        response = response_of(responses, k)
        over, still = response.whole, response.steady
        beta, square = mode.damping, mode.square
        # remainder at start, middle and end
        r_0, r_1 = first.accelerations[k], last.accelerations[k]
        bend = 2.0 * (r_0 - 2.0 * mean.accelerations[k] + r_1)  # r = r_0 + (...) s + bend s^2, s from 0 to 1
        # responses to s and s^2: coordinates, rates
        line, parabola = over.ramp * per_step, 2.0 * over.parabola * per_step * per_step
        line_rate, parabola_rate = over.steady * per_step, 2.0 * over.ramp * per_step * per_step
        change = bend - 0.5 * span * span * (modal.curvatures[k] if known else 0.0)
        p = last.coordinates[k] + change * (parabola - 0.5 * line)
        v = last.rates[k] + change * (parabola_rate - 0.5 * line_rate)
        # force per unit of modal mass at the end
        force = pushed(mode, then, 1.0) + r_1
        # advance from the grid to the end of the step
        v += excess * (force - beta * v - square * p)
        p += excess * v
        last.coordinates[k] = p
        last.rates[k] = v
        last.accelerations[k] = force - beta * v - square * p

        # error: response to the bend of the remainder
        wrong += mode.size * abs(bend * (line - parabola))
        wrong_rate += mode.size * abs(bend * (line_rate - parabola_rate))
        # the free motion: without the response to the forces
        slope = (r_1 - r_0 - bend) * per_step
        modal.slopes[k] = slope + 2.0 * bend * per_step if is_last else slope
        modal.curvatures[k] = 2.0 * bend * per_step * per_step
        force = _with_push(r_0, mode, drive.line, 1.0)
        slope += pushed(mode, drive.slopes, 1.0)
        per_square = still.per_square
        hidden += still.forced * abs(drive.amplitude)
        slope *= per_square
        forced = pushed(mode, drive.sines, still.sine) + pushed(mode, drive.cosines, still.cosine)
        turning = pushed(mode, drive.cosines, still.sine) - pushed(mode, drive.sines, still.cosine)
        p = first.coordinates[k] - per_square * (force - beta * slope) - forced
        v = first.rates[k] - slope - omega * turning
        hidden += still.free * (abs(p) + still.per_rate * abs(v))
    error = bounds.third * max(wrong / bounds.place, wrong_rate / bounds.rate)
    hidden /= bounds.between
    return max(error, hidden ** (ORDER / INTERPOLATION_ORDER)) if hidden > 0.0 else error


def sweep_of(begin: Any, reach: Any, end: Any) -> Any:
    """Return a kernel: one sweep over a step of a body, which returns (code, error in tolerances).

    The remainder found by a sweep serves the next one, that of the last sweep the next step.

    Parameters
    ----------
    begin : kernel
        `begin(body, modal)` fills `modal.first` from the start of the step.
    reach : kernel
        `reach(body, modal, half, t, h, sine)` moves the body to the modal state in the middle (half 0) or at the end,
        evaluates it, fills in the accelerations of the modes, and returns a code and the components of the base
        acceleration.
    end : kernel
        `end(body, modal)` moves the body to the end of the step.
    """

    @kernel
    def sweep(body, modal, drive, bounds, t, h, is_first, is_last):
        known = modal.trend.known
        # length of the step on the grid, and the excess of the step over it
        span = math.floor(h * GRID + 0.5) / GRID
        excess = h - span
        responses = responses_over(modal, span, drive.omega)
        if is_first and known != 0.0:  # the last step has ended here
            copy(modal.first.row, modal.last.row, 3 * modal.room)
        elif is_first:
            begin(body, modal)
        # turn of the wave in half the step
        late = 0.5 * drive.omega * excess
        turn_sine = responses.made_for.sine + late * responses.made_for.cosine
        turn_cosine = responses.made_for.cosine - late * responses.made_for.sine
        sine, cosine, then = drive.sine, drive.cosine, drive.line
        for half in range(2):  # in the middle, then at the end with the values known by then
            _respond_to(modal, drive, responses, span, half, is_first)
            # sine and cosine of the wave half a step later
            sine, cosine = sine * turn_cosine + cosine * turn_sine, cosine * turn_cosine - sine * turn_sine
            code, then = reach(body, modal, half, t + (0.5 * h if half == 0 else h), h, sine)
            if code != OK:
                modal.trend.known = 0.0
                return code, 0.0
            take_linear_part(modal, modal.mean if half == 0 else modal.last, then)
        # correct the end by the remainder, and estimate the error
        error = _correct(modal, drive, responses, bounds, then, span, excess, is_last)
        end(body, modal)
        modal.trend.known = 1.0 if error <= 1.0 else 0.0
        return (OK if math.isfinite(error) else OPENS), error

    return sweep


def attempt_of(sweep: Any) -> Any:
    """Return a kernel: one step by a kernel of `sweep_of`, which returns (code, error in tolerances).

    The error is that of the correction or of interpolation, whichever limits the step more. The code is OPENS where a
    joint does not stay in full contact. If no joint is damped a second sweep makes the step symmetric in time, which
    keeps the energy over any number of steps; one leaves a drift of 6e-11 in a period.
    """

    @kernel
    def attempt(body, modal, drive, bounds, sweeps, t, h):
        code, error = OK, 0.0
        # sweeps, as long as each succeeds
        for number in range(sweeps):
            if code == OK and error <= 1.0:
                code, error = sweep(body, modal, drive, bounds, t, h, number == 0, number + 1 == sweeps)
        return code, error

    return attempt
