"""The responses of modes over a step, in closed form, stored for the steps that follow.

Over a step h, with g the response of a mode to a unit impulse, I_0 its integral and I_k = integral of I_(k-1): they
satisfy omega^2 I_k + beta I_(k-1) + I_(k-2) = h^k / k! with I_(-1) = g, I_(-2) = g'.
"""

import math

import numpy as np

from ..layout.modal import mode_at
from ..layout.spaces import INTERPOLATION_BOUND, RESPONSE_FIELDS, RESPONSE_HEADER, RESPONSES
from ..numba_ext.jit import kernel, leaf
from ..numba_ext.views import Numbers, Record, Space

# the responses of a mode
HALF = Record(
    "rest",  # coordinate left of a unit coordinate
    "impulse",  # coordinate for a unit rate: g
    "impulse_rate",  # rate left of a unit rate: g'
    "steady",  # coordinate for a unit force: I_0
    "ramp",  # for a force t: I_1
    "cosine",  # for a force cos(omega t), of the base
    "sine",
    "parabola",  # for a force t^2 / 2: I_2
)
STEADY = Record(
    # the steady harmonic motion for 1 m/s2, at the sine and the cosine of the phase of the base
    "sine",
    "cosine",
    "free",  # interpolation error of a free motion, relative to its amplitude, times the size of the mode
    "forced",  # and of the steady motion for 1 m/s2
    "per_rate",  # s, amplitude for a unit rate
    "per_square",  # s2, 1 / omega_k^2
)
RESPONSE = Space(half=HALF, whole=HALF, steady=STEADY)  # over half the step, over all of it
# data kept of a step: its length (s) and the frequency of the base (1/s), and the responses of all modes
STORED = Space(
    made_for=Record("count", "step", "omega", "sine", "cosine"),  # modes; of the turn of the wave in half the step
    modes=Numbers(per_n=RESPONSE_FIELDS),
)
assert RESPONSE.beside == RESPONSE_FIELDS
assert STORED.beside == RESPONSE_HEADER
_response, _stored = RESPONSE.over, STORED.over
_STORED_PER_N, _STORED_BESIDE = STORED.per_n, STORED.beside

TERMS = 24  # of the series
SERIES = 2.0  # radians (of frequency or damping) in a step up to which they give all digits
INVERSE_FACTORIALS = np.array([1.0 / math.factorial(k) for k in range(TERMS + 1)])
SPLIT = 2.0  # ratio of mode to base frequency from which its steady motion is separated from the rest
GRID = 2.0**40  # 1/s: responses are those of a step on this grid; the difference is compensated


@kernel
def respond(square, beta, h, omega, out):
    """Fill `out`, a record HALF, with the responses of a mode over h s.

    Parameters
    ----------
    square : float
        omega_k^2 of the mode (1/s2).
    beta : float
        Damping of the mode (1/s).
    h : float
        Step (s).
    omega : float
        Angular frequency of the base (1/s); omega * h is at most about 1.
    out : record HALF
        Filled.
    """
    x = square * h * h
    d = beta * h
    if x <= SERIES * SERIES and d <= SERIES:
        # i_k = I_k / h^(k + 2) by downward recurrence, in which errors of the starting values decay
        y = omega * h
        i_0, i_1, i_2 = 0.0, 0.0, 0.0  # of the last k and the two above
        even, odd = 0.0, 0.0  # i_k - y^2 i_(k+2) + y^4 i_(k+4) ..., of the last k and the one above
        for k in range(TERMS, 1, -1):
            i_0, i_1, i_2 = INVERSE_FACTORIALS[k] - d * i_0 - x * i_1, i_0, i_1
            even, odd = i_0 - y * y * odd, even
        # the recurrence for k = 0 and -1 gives the impulse and its rate
        impulse = 1.0 - d * i_0 - x * i_1
        out.impulse = h * impulse
        out.impulse_rate = 1.0 - d * impulse - x * i_0
        out.rest = 1.0 - x * i_0
        out.steady = h * h * i_0
        out.ramp = h * h * h * i_1
        out.cosine = h * h * even
        out.sine = h * h * y * odd
        out.parabola = h * h * h * h * i_2
        return
    # closed form: underdamped, or overdamped by the slow and the fast root
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
    # I_0 and I_1 by the recurrence
    steady = (1.0 - rest) / square
    ramp = (h - beta * steady - impulse) / square
    out.rest = rest
    out.impulse = impulse
    out.impulse_rate = impulse_rate
    out.steady = steady
    out.ramp = ramp
    # (exp(i omega h) - rest - i omega impulse) / (omega_k^2 - omega^2 + i beta omega): far from resonance here
    real = math.cos(omega * h) - rest
    imaginary = math.sin(omega * h) - omega * impulse
    away = square - omega * omega
    across = beta * omega
    per = 1.0 / (away * away + across * across)
    out.cosine = (real * away + imaginary * across) * per
    out.sine = (imaginary * away - real * across) * per
    out.parabola = (0.5 * h * h - beta * ramp - steady) / square


@leaf
def missed(x):
    """Return the largest error of the quintic for a motion of amplitude 1 that turns by x rad in the step."""
    cube = x * x * x
    return min(cube * cube / INTERPOLATION_BOUND, 2.0 + x * x / 40.0)


@leaf
def _stored_at(store, room, k):
    """Return stored data number k of RESPONSES; `room`: largest number of modes."""
    return _stored(store[(_STORED_PER_N * room + _STORED_BESIDE) * k :], room)


@leaf
def response_of(stored, k):
    """Return the stored responses of mode k."""
    return _response(stored.modes[RESPONSE_FIELDS * k :], 0)


@kernel
def responses_over(modal, h, omega):
    """Return the responses over `h` s (on the grid), as STORED; compute them if they are not stored.

    They follow from the modes, h and omega alone, so that the results do not depend, to the last bit, on which are
    stored.
    """
    store, latest, room, count = modal.responses, modal.latest, modal.room, modal.active
    # reuse stored responses of this step
    for k in range(RESPONSES):
        stored = _stored_at(store, room, k)
        if stored.made_for.step == h and stored.made_for.omega == omega and stored.made_for.count == count:
            latest.response = k
            return stored
    # replace the responses that were not used last
    used = (int(latest.response) + 1) % RESPONSES
    latest.response = used
    stored = _stored_at(store, room, used)
    stored.made_for.count = count
    stored.made_for.step = h
    stored.made_for.omega = omega
    stored.made_for.sine, stored.made_for.cosine = math.sin(0.5 * h * omega), math.cos(0.5 * h * omega)
    for k in range(count):
        # responses over half the step and the whole step
        mode = mode_at(modal.modes, k)
        out = response_of(stored, k)
        respond(mode.square, mode.damping, 0.5 * h, omega, out.half)
        respond(mode.square, mode.damping, h, omega, out.whole)
        steady = out.steady
        fastest = math.sqrt(mode.square)
        steady.sine = 0.0
        steady.cosine = 0.0
        # steady harmonic motion, where the mode is fast enough to separate it
        if fastest > SPLIT * omega:
            away = mode.square - omega * omega
            across = mode.damping * omega
            per = 1.0 / (away * away + across * across)
            steady.sine = away * per
            steady.cosine = -across * per
        else:
            fastest = max(fastest, omega)
        # bounds of the interpolation error
        steady.free = mode.size * missed(fastest * h)
        pushed = abs(mode.push) + abs(mode.across)
        steady.forced = mode.size * pushed * math.hypot(steady.sine, steady.cosine) * missed(omega * h)
        steady.per_rate = 1.0 / fastest
        steady.per_square = 1.0 / mode.square
    return stored
