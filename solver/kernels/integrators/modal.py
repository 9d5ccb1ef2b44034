"""Exact propagation of the linear column while every joint is in full contact, corrected for what is not linear.

About rest the column is 2 n modes p'' + beta p' + omega^2 p = push * a(t) + r, with r all that the exact equations say
beyond that: small, and as smooth as the motion. The response of a mode to its start, to the base (linear in time plus
harmonic) and to forces 1, t, t^2 is known in closed form for a step of any length, so that the joint modes limit
neither stability nor accuracy. r is evaluated at the start, in the middle and at the end and taken as the parabola
through the three: an exponential integrator (M. Hochbruck, A. Ostermann, Exponential integrators, Acta Numerica 19
(2010) 209-286), of order 4 where the modes are slow.

Responses over a step h (`respond`), with g that to a unit impulse, I_0 its integral and I_k = integral of I_(k-1):
they satisfy omega^2 I_k + beta I_(k-1) + I_(k-2) = h^k / k! with I_(-1) = g, I_(-2) = g'.
"""

import math

import numpy as np

from ..dynamics import accelerate, base_acceleration, modal_offset
from ..jit import kernel, leaf, place
from ..layout import (
    BLOCK_FIELDS,
    DAMPING,
    ELASTIC,
    GRAVITY,
    INPUT_AMPLITUDE,
    INPUT_AX,
    INPUT_AZ,
    INPUT_JX,
    INPUT_JZ,
    INPUT_OMEGA,
    INPUT_PHASE,
    INPUT_T0,
    INTERPOLATION_BOUND,
    INTERPOLATION_PART,
    JOINT_WIDTH,
    MODAL,
    MODAL_HEADER,
    MODAL_LONGEST,
    MODAL_SWEEPS,
    MODAL_THIRD,
    MODE_DAMPING,
    MODE_FIELDS,
    MODE_PUSH,
    MODE_SIZE,
    MODE_SQUARE,
    MODEL_HEADER,
    N_BLOCKS,
    OK,
    PHASE_END,
    RESPONSE_FIELDS,
    RESPONSE_HEADER,
    RESPONSES,
    TOLERANCE,
    WITHOUT,
)

ORDER = 4  # of the estimated error
INTERPOLATION_ORDER = 6
OPENS = 2  # code, beside those of layout.py: a joint does not stay in full contact
MIDDLE = 1  # the phases of work that a step uses: the middle, then modal coordinates, rates and remainders
MODAL_START = 2
MODAL_MIDDLE = 3
MODAL_END = 4

# fields of the responses of a mode: over half the step from HALF, over all of it from WHOLE
HALF = 0
WHOLE = 8
REST = 0  # coordinate left of a unit coordinate
IMPULSE = 1  # coordinate for a unit rate: g
IMPULSE_RATE = 2  # rate left of a unit rate: g'
STEADY = 3  # coordinate for a unit force: I_0
RAMP = 4  # for a force t: I_1
COSINE = 5  # for a force cos(omega t), of the base
SINE = 6
PARABOLA = 7  # for a force t^2 / 2: I_2
# the steady harmonic motion for 1 m/s2, at the sine and the cosine of the phase of the base
STEADY_SINE = 16
STEADY_COSINE = 17
FREE = 18  # what interpolation misses of a free motion, in parts of its amplitude, times the size of the mode
FORCED = 19  # and of the steady motion for 1 m/s2
PER_RATE = 20  # s, amplitude for a unit rate

TERMS = 24  # of the series
SERIES = 2.0  # radians (of frequency or damping) in a step up to which they give all digits
INVERSE_FACTORIALS = np.array([1.0 / math.factorial(k) for k in range(TERMS + 1)])
SPLIT = 2.0  # a mode is so many times faster than the base before its steady motion is told from the rest
GRID = 2.0**40  # 1/s: responses are those of a step on this grid, what is left of it is made up for
LEAST_STEP = 1e-9  # s


@leaf
def available(model):
    """Whether the column may be propagated by modes."""
    return model[MODAL] > 0.0 and int(model[WITHOUT]) & ELASTIC == 0


@kernel
def respond(square, beta, h, omega, out, at):
    """Responses of a mode (omega^2 = square, 1/s2; beta, 1/s) over h s at out[at:], eight fields.

    omega: that of the base, 1/s; omega * h is at most about 1.
    """
    x = square * h * h
    d = beta * h
    if x <= SERIES * SERIES and d <= SERIES:
        # i_k = I_k / h^(k + 2) by the recurrence downwards, which forgets how it began
        y = omega * h
        i_0, i_1, i_2 = 0.0, 0.0, 0.0  # of the last k and those above
        even, odd = 0.0, 0.0  # i_k - y^2 i_(k+2) + y^4 i_(k+4) ..., of the last k and that above
        for k in range(TERMS, 1, -1):
            i_0, i_1, i_2 = INVERSE_FACTORIALS[k] - d * i_0 - x * i_1, i_0, i_1
            even, odd = i_0 - y * y * odd, even
        impulse = 1.0 - d * i_0 - x * i_1
        out[at + IMPULSE] = h * impulse
        out[at + IMPULSE_RATE] = 1.0 - d * impulse - x * i_0
        out[at + REST] = 1.0 - x * i_0
        out[at + STEADY] = h * h * i_0
        out[at + RAMP] = h * h * h * i_1
        out[at + COSINE] = h * h * even
        out[at + SINE] = h * h * y * odd
        out[at + PARABOLA] = h * h * h * h * i_2
        return
    half = 0.5 * beta
    split = half * half - square
    if split < 0.0:
        turn = math.sqrt(-split)
        left = math.exp(-half * h)
        sine = math.sin(turn * h) / turn
        cosine = math.cos(turn * h)
        impulse = left * sine
        impulse_rate = left * (cosine - half * sine)
        rest = left * (cosine + half * sine)
    else:
        root = math.sqrt(split)
        slow = square / (half + root)
        left = math.exp(-slow * h)
        sine = -math.expm1(-2.0 * root * h) / (2.0 * root) if root > 0.0 else h
        impulse = left * sine
        impulse_rate = left * (1.0 - (half + root) * sine)
        rest = left * (1.0 + slow * sine)
    steady = (1.0 - rest) / square
    ramp = (h - beta * steady - impulse) / square
    out[at + REST] = rest
    out[at + IMPULSE] = impulse
    out[at + IMPULSE_RATE] = impulse_rate
    out[at + STEADY] = steady
    out[at + RAMP] = ramp
    # (exp(i omega h) - rest - i omega impulse) / (omega_k^2 - omega^2 + i beta omega): far from resonance here
    real = math.cos(omega * h) - rest
    imaginary = math.sin(omega * h) - omega * impulse
    away = square - omega * omega
    across = beta * omega
    per = 1.0 / (away * away + across * across)
    out[at + COSINE] = (real * away + imaginary * across) * per
    out[at + SINE] = (imaginary * away - real * across) * per
    out[at + PARABOLA] = (0.5 * h * h - beta * ramp - steady) / square


@leaf
def missed(x):
    """What the quintic between two steps misses of a motion of amplitude 1 that turns by x rad in the step, at most."""
    cube = x * x * x
    return min(cube * cube / INTERPOLATION_BOUND, 2.0 + x * x / 40.0)


@kernel
def _responses(model, work, h, omega):
    """Where in work the responses over h s (on the grid) stand; they are made where they are not kept from before.

    They follow from model, h and omega alone, so that it does not matter to the last bit which are kept.
    """
    n = int(model[N_BLOCKS])
    latest = modal_offset(n) + 1 + 4 * n  # holds the number of the place used last
    length = RESPONSE_HEADER + RESPONSE_FIELDS * 2 * n
    for i in range(RESPONSES):
        slot = latest + 1 + length * i
        if work[slot] == h and work[slot + 1] == omega:
            work[latest] = i
            return slot
    place_used = (int(work[latest]) + 1) % RESPONSES
    work[latest] = place_used
    slot = latest + 1 + length * place_used
    work[slot] = h
    work[slot + 1] = omega
    mode = int(model[MODAL]) + MODAL_HEADER
    out = slot + RESPONSE_HEADER
    for _ in range(2 * n):
        square = model[mode + MODE_SQUARE]
        beta = model[mode + MODE_DAMPING]
        size = model[mode + MODE_SIZE]
        respond(square, beta, 0.5 * h, omega, work, out + HALF)
        respond(square, beta, h, omega, work, out + WHOLE)
        fastest = math.sqrt(square)
        sine = 0.0
        cosine = 0.0
        if fastest > SPLIT * omega:
            away = square - omega * omega
            across = beta * omega
            per = 1.0 / (away * away + across * across)
            sine = away * per
            cosine = -across * per
        else:
            fastest = max(fastest, omega)
        work[out + STEADY_SINE] = sine
        work[out + STEADY_COSINE] = cosine
        work[out + FREE] = size * missed(fastest * h)
        work[out + FORCED] = size * abs(model[mode + MODE_PUSH]) * math.hypot(sine, cosine) * missed(omega * h)
        work[out + PER_RATE] = 1.0 / fastest
        mode += MODE_FIELDS
        out += RESPONSE_FIELDS
    return slot


@leaf
def _multiply(model, matrices, work, x, y, n, segments):
    """One to three segments of 2 n numbers at work[x:] times the matrices of rotations and openings, to work[y:]."""
    size = 2 * n
    matrix = place(matrices)
    for half in range(2):
        begin = place(x + half * n)
        for i in range(n):
            first, second, third = 0.0, 0.0, 0.0
            for j in range(n):
                factor = model[matrix + j]
                first += factor * work[begin + j]
                if segments > 1:
                    second += factor * work[begin + size + j]
                if segments > 2:
                    third += factor * work[begin + 2 * size + j]
            matrix += n
            to = place(y + half * n + i)
            work[to] = first
            if segments > 1:
                work[to + size] = second
            if segments > 2:
                work[to + 2 * size] = third


@leaf
def _dips(c_0, rate_0, c_1, rate_1, h):
    """Whether the cubic through values and rates at both ends of h s may reach zero."""
    lowest = min(c_0, c_1)
    if rate_0 < 0.0 and rate_1 > 0.0:
        lowest -= 4.0 / 27.0 * h * (rate_1 - rate_0)
    return not lowest > 0.0


@kernel
def _opens(model, work, a, b, h):
    """Whether a corner of a joint may open, or lose its pressure, in the h s between the phases work[a:] and work[b:].

    The corner at +-width/2 is pressed by -opening -+ width/2 * slope, of which the slope is taken from above.
    """
    n = place(int(model[N_BLOCKS]))
    for i in range(n):
        row = place(MODEL_HEADER + BLOCK_FIELDS * i)
        eta = model[row + DAMPING]
        half = 0.5 * model[row + JOINT_WIDTH]
        p, q = place(a + i), place(b + i)
        turn_p, spin_p, turned_p = work[p], work[p + 2 * n], work[p + 4 * n]
        turn_q, spin_q, turned_q = work[q], work[q + 2 * n], work[q + 4 * n]
        if i + 1 < n:
            turn_p -= work[p + 1]
            spin_p -= work[p + 2 * n + 1]
            turned_p -= work[p + 4 * n + 1]
            turn_q -= work[q + 1]
            spin_q -= work[q + 2 * n + 1]
            turned_q -= work[q + 4 * n + 1]
        # far from opening, neither corner can come to it
        rate = half * max(abs(spin_p), abs(spin_q)) + max(abs(work[p + 3 * n]), abs(work[q + 3 * n]))
        reach = h * rate
        if eta > 0.0:
            reach += eta * rate
            reach += (
                h * eta * (half * max(abs(turned_p), abs(turned_q)) + max(abs(work[p + 5 * n]), abs(work[q + 5 * n])))
            )
        if -max(work[p + n], work[q + n]) - half * max(abs(turn_p), abs(turn_q)) > reach:
            continue
        for _ in range(2):
            c_p = half * turn_p - work[p + n]
            c_q = half * turn_q - work[q + n]
            v_p = half * spin_p - work[p + 3 * n]
            v_q = half * spin_q - work[q + 3 * n]
            if _dips(c_p, v_p, c_q, v_q, h):
                return True
            if eta > 0.0:
                a_p = half * turned_p - work[p + 5 * n]
                a_q = half * turned_q - work[q + 5 * n]
                if _dips(c_p + eta * v_p, v_p + eta * a_p, c_q + eta * v_q, v_q + eta * a_q, h):
                    return True
            half = -half
    return False


@kernel
def suits(model, work):
    """Whether a step from the phase PHASE_START may be tried: every joint is in full contact there."""
    return not _opens(model, work, 0, 0, 0.0)


@kernel
def forget(model, work):
    """The trend of the remainder is not that of the step before: this is the first step of a call, or after others."""
    work[modal_offset(int(model[N_BLOCKS]))] = 0.0


@kernel
def longest_step(model):
    """s; beyond it what couples the modes is not small."""
    return model[int(model[MODAL]) + MODAL_LONGEST]


@kernel
def attempt(model, inputs, work, counters, scale, rate_scale, t, h):
    """One step and its error, relative to tolerance times scale (rad) and rate_scale (rad/s).

    The error is that of the correction or what interpolation would miss, whichever limits the step more. The code is
    OPENS where a joint does not stay in full contact. Where nothing is damped a second sweep makes the step symmetric
    in time, which keeps the energy over any number of steps; one leaves a drift of 6e-11 in a period.
    """
    code, error = OK, 0.0
    sweeps = int(model[int(model[MODAL]) + MODAL_SWEEPS])
    for sweep in range(sweeps):
        if code == OK and error <= 1.0:
            last = sweep + 1 == sweeps
            code, error = _sweep(model, inputs, work, counters, scale, rate_scale, t, h, sweep == 0, last)
    return code, error


@kernel
def _sweep(model, inputs, work, counters, scale, rate_scale, t, h, is_first, is_last):
    """As `attempt`; what it finds of the remainder serves the next sweep, that of the last one the next step."""
    n = place(int(model[N_BLOCKS]))
    size = 2 * n
    phase = 3 * size
    middle, end = phase * MIDDLE, phase * PHASE_END
    first, mean, last = phase * MODAL_START, phase * MODAL_MIDDLE, phase * MODAL_END
    modal = int(model[MODAL])
    modes = modal + MODAL_HEADER
    shapes = modes + size * MODE_FIELDS
    inverses = shapes + 2 * n * n
    trend = modal_offset(n)  # flag, then slopes and curvatures of the remainder
    known = work[trend] != 0.0
    work[trend] = 0.0
    trend = place(trend + 1)
    amplitude = inputs[INPUT_AMPLITUDE]
    omega = inputs[INPUT_OMEGA] if amplitude != 0.0 else 0.0
    on_grid = math.floor(h * GRID + 0.5) / GRID
    excess = h - on_grid
    responses = _responses(model, work, on_grid, omega) + RESPONSE_HEADER

    if is_first and known:  # the last step has ended here
        for i in range(phase):
            work[first + i] = work[last + i]
    elif is_first:
        _multiply(model, inverses, work, 0, first, n, 3)
    past = t - inputs[INPUT_T0]
    angle = omega * t + inputs[INPUT_PHASE]
    wave_sine = amplitude * math.sin(angle) if amplitude != 0.0 else 0.0
    wave_cosine = amplitude * math.cos(angle) if amplitude != 0.0 else 0.0
    for stage in range(2):  # in the middle, then at the end with what is known by then
        here = middle if stage == 0 else end
        to = mean if stage == 0 else last
        for k in range(size):
            mode = place(modes + MODE_FIELDS * k)
            out = place(responses + RESPONSE_FIELDS * k + (HALF if stage == 0 else WHOLE))
            at = place(first + k)
            p, v = work[at], work[at + size]
            square, push = model[mode + MODE_SQUARE], model[mode + MODE_PUSH]
            if k < n:
                force = push * (inputs[INPUT_AX] + inputs[INPUT_JX] * past)
                slope = push * inputs[INPUT_JX]
                force_sine, force_cosine = push * wave_sine, push * wave_cosine
            else:
                force = push * (model[GRAVITY] + inputs[INPUT_AZ] + inputs[INPUT_JZ] * past)
                slope = push * inputs[INPUT_JZ]
                force_sine, force_cosine = 0.0, 0.0
            if stage == 0 and is_first:
                beta = model[mode + MODE_DAMPING]
                work[at + 2 * size] += beta * v + square * p - (force + force_sine)
            # the remainder goes on as in the step before; at the end, through its value in the middle
            curvature = work[trend + size + k] if known else 0.0
            if stage == 1:
                slope += 2.0 * (work[mean + k + 2 * size] - work[at + 2 * size]) / on_grid - 0.25 * on_grid * curvature
            elif known:
                slope += work[trend + k]
            force += work[at + 2 * size]
            impulse, cosine, sine = work[out + IMPULSE], work[out + COSINE], work[out + SINE]
            steady = work[out + STEADY]
            work[to + k] = (
                (work[out + REST] * p + impulse * v)
                + (steady * force + work[out + RAMP] * slope + work[out + PARABOLA] * curvature)
                + (cosine * force_sine + sine * force_cosine)
            )
            work[to + size + k] = (
                (work[out + IMPULSE_RATE] * v - square * impulse * p)
                + (impulse * force + steady * slope + work[out + RAMP] * curvature)
                + ((impulse - omega * sine) * force_sine + omega * cosine * force_cosine)
            )
        _multiply(model, shapes, work, to, here, n, 2)
        then = t + (0.5 * h if stage == 0 else h)
        base_ax, base_az = base_acceleration(inputs, then)
        code = accelerate(model, inputs, work, here, then, work, counters)
        if code != OK:
            return code, 0.0
        if _opens(model, work, 0 if stage == 0 else middle, here, 0.5 * h):
            return OPENS, 0.0
        _multiply(model, inverses, work, here + 2 * size, to + 2 * size, n, 1)
        for k in range(size):
            mode = place(modes + MODE_FIELDS * k)
            at = place(to + k)
            beta, square = model[mode + MODE_DAMPING], model[mode + MODE_SQUARE]
            base = base_ax if k < n else model[GRAVITY] + base_az
            work[at + 2 * size] += beta * work[at + size] + square * work[at] - model[mode + MODE_PUSH] * base

    per_step = 1.0 / on_grid
    wrong, wrong_rate, hidden = 0.0, 0.0, 0.0
    for k in range(size):
        mode = place(modes + MODE_FIELDS * k)
        out = place(responses + RESPONSE_FIELDS * k)
        at = place(first + k)
        to = place(last + k)
        beta, square, push = model[mode + MODE_DAMPING], model[mode + MODE_SQUARE], model[mode + MODE_PUSH]
        r_0, r_1 = work[at + 2 * size], work[to + 2 * size]
        bend = 2.0 * (r_0 - 2.0 * work[mean + k + 2 * size] + r_1)  # r = r_0 + (...) s + bend s^2, s from 0 to 1
        impulse, steady = work[out + WHOLE + IMPULSE], work[out + WHOLE + STEADY]
        # responses to s and s^2: coordinates, rates
        line, parabola = work[out + WHOLE + RAMP] * per_step, 2.0 * work[out + WHOLE + PARABOLA] * per_step * per_step
        line_rate, parabola_rate = steady * per_step, 2.0 * work[out + WHOLE + RAMP] * per_step * per_step
        change = bend - 0.5 * on_grid * on_grid * (work[trend + size + k] if known else 0.0)
        p = work[to] + change * (parabola - 0.5 * line)
        v = work[to + size] + change * (parabola_rate - 0.5 * line_rate)
        base = base_ax if k < n else model[GRAVITY] + base_az
        force = push * base + r_1
        v += excess * (force - beta * v - square * p)
        p += excess * v
        work[to] = p
        work[to + size] = v
        work[to + 2 * size] = force - beta * v - square * p

        wrong += model[mode + MODE_SIZE] * abs(bend * (line - parabola))
        wrong_rate += model[mode + MODE_SIZE] * abs(bend * (line_rate - parabola_rate))
        # the free motion: without that which the forces make
        slope = (r_1 - r_0 - bend) * per_step
        work[trend + k] = slope + 2.0 * bend * per_step if is_last else slope
        work[trend + size + k] = 2.0 * bend * per_step * per_step
        if k < n:
            force = r_0 + push * (inputs[INPUT_AX] + inputs[INPUT_JX] * past)
            slope += push * inputs[INPUT_JX]
            sine, cosine = push * work[out + STEADY_SINE], push * work[out + STEADY_COSINE]
            hidden += work[out + FORCED] * abs(amplitude)
        else:
            force = r_0 + push * (model[GRAVITY] + inputs[INPUT_AZ] + inputs[INPUT_JZ] * past)
            slope += push * inputs[INPUT_JZ]
            sine, cosine = 0.0, 0.0
        slope /= square
        p = work[at] - (force / square - beta / square * slope) - (sine * wave_sine + cosine * wave_cosine)
        v = work[at + size] - slope - omega * (sine * wave_cosine - cosine * wave_sine)
        hidden += work[out + FREE] * (abs(p) + work[out + PER_RATE] * abs(v))
    _multiply(model, shapes, work, last, end, n, 3)
    allowed = model[TOLERANCE] * scale
    error = model[modal + MODAL_THIRD] * max(wrong / allowed, wrong_rate / (model[TOLERANCE] * rate_scale))
    hidden /= INTERPOLATION_PART * allowed
    if hidden > 0.0:
        error = max(error, hidden ** (ORDER / INTERPOLATION_ORDER))
    work[trend - 1] = 1.0 if error <= 1.0 else 0.0
    return (OK if math.isfinite(error) else OPENS), error
