"""The longest stable step of an exchange (theory.md, section 15), by the growth of a recurrence."""

import math

from ..layout.spaces import SLOPE_HELD, SLOPE_LINE
from ..numba_ext.jit import kernel, leaf

STEPS = 200  # number of steps of the recurrence; growth is measured over the second half


GROWTH = 1.005  # per step


MIDDLE, WIDER, TINY = 1e-5, 1.05, 1e-6  # s, ratio: geometric series of the steps that are tried, down to TINY h


FAR = 1e100


SOFTEST = 1e-8  # (frequency times step)^2: a softer spring has no effect within a step, and would be lost in rounding


LONGER, LIGHTER = 1.0 + 1e-6, 0.99  # ratios to the step and mass examined before, beyond which a step is examined


@leaf
def is_new(base, h, mass):
    """Return True if a step of h s must be examined: longer, or at a lower mass (kg), than any before.

    Notes both. No step is examined once `base.allowed_step` is set.
    """
    # no longer step and no lower mass than before
    if base.allowed_step != 0.0 or (h <= LONGER * base.checked_step and mass >= LIGHTER * base.checked_mass):
        return False
    base.checked_mass = mass if base.checked_step == 0.0 else min(mass, base.checked_mass)
    base.checked_step = max(h, base.checked_step)
    return True


@leaf
def _grows(way, h, dashpot, spring, moved, mass):
    """Return True if the recurrence grows at steps of h s.

    Parameters
    ----------
    way : float
        Code of SLOPES: the rule for the slope of the acceleration.
    h : float
        Step, s.
    dashpot, spring, moved, mass : float
        N s/m, N/m and kg of the mass on the joint, and mass of the base, kg.
    """
    # decay (1/s) and squared frequency (1/s2) of the body on the base
    decay, square = dashpot / moved, max(spring / moved, SOFTEST / (h * h))
    # free motion: roots of s^2 + decay s + square
    half = 0.5 * decay
    rest = half * half - square
    # free motion over a step: coefficients of d and v
    if rest > 0.0:
        rate = math.sqrt(rest)
        slow, fast = math.exp((rate - half) * h), math.exp(-(rate + half) * h)
        of_place, of_rate = 0.5 * (slow + fast), 0.5 * (slow - fast) / rate
    else:
        rate = math.sqrt(-rest)
        fading = math.exp(-half * h)
        of_place = fading * math.cos(rate * h)
        of_rate = fading * (math.sin(rate * h) / rate if rate > 0.0 else h)
    # start from a displacement of 1 and a rate, without earlier accelerations
    d, v, last, last_line, middle, size = 1.0, 0.5 * math.sqrt(square), 0.0, 0.0, 0.0, 0.0
    for n in range(STEPS):
        # the acceleration at the exchange and its slope
        a = (dashpot * v + spring * d) / mass
        line = (a - last) / h if n > 0 else 0.0
        slope = line
        if way == SLOPE_HELD:
            slope = 0.0
        elif way != SLOPE_LINE and n > 1:
            slope = (11.0 * line - 5.0 * last_line) / 6.0
        last, last_line = a, line
        # particular solution place + drift s, plus the free motion from the remainder (x, y)
        drift = -slope / square
        place = (-a - decay * drift) / square
        x, y = d - place, v - drift
        d = place + drift * h + of_place * x + of_rate * (y + half * x)
        v = drift + of_place * y - of_rate * (square * x + half * y)
        # amplitude as a velocity, and that half-way
        size = math.hypot(d * math.sqrt(square), v)
        if n == STEPS // 2:
            middle = size
        if not size < FAR:
            return True
    return size > middle * GROWTH ** (STEPS // 2 - 1)


@kernel
def longest_step(way, h, dashpot, spring, moved, mass):
    """Return the longest stable step (s) below h where h is too long; else infinity.

    Rotations are treated alike, with N m s, N m and kg m2.

    Parameters
    ----------
    way : float
        Code of SLOPES: the rule for the slope of the acceleration.
    h : float
        Step that is asked for, s.
    dashpot, spring, moved, mass : float
        N s/m, N/m and kg of the mass on the joint, and mass of the base, kg.
    """
    holds = spring >= 0.0 and spring + dashpot > 0.0  # a dashpot alone, too
    if not (holds and moved > 0.0 and mass > 0.0) or not _grows(way, h, dashpot, spring, moved, mass):
        return math.inf
    # a stable step of a geometric series, then the last one before they grow
    step = min(MIDDLE, h)
    while step > TINY * h and _grows(way, step, dashpot, spring, moved, mass):
        step /= WIDER
    while step * WIDER < h and not _grows(way, step * WIDER, dashpot, spring, moved, mass):
        step *= WIDER
    return step
