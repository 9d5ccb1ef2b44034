"""The longest stable step of an exchange (theory.md, section 15), by the roots of a recurrence."""

import math

from ..layout.spaces import SLOPE_HELD, SLOPE_LINE
from ..numba_ext.jit import kernel, leaf

GROWTH = 1.005  # largest root of a recurrence that counts as stable: amplitude after a step over that before it


MIDDLE, WIDER, TINY = 1e-5, 1.05, 1e-6  # s, ratio: geometric series of the steps that are tried, down to TINY h


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
def _stays_within(a, b, c, d, e):
    """Return True if all roots of a z^4 + b z^3 + c z^2 + d z + e, where a > 0, are within the unit circle (Schur)."""
    if not abs(e) < a:
        return False
    a, b, c, d = a * a - e * e, a * b - e * d, a * c - e * c, a * d - e * b
    if not abs(d) < a:
        return False
    a, b, c = a * a - d * d, a * b - d * c, a * c - d * b
    return abs(c) < a and abs(b) < a + c


@leaf
def _grows(way, h, dashpot, spring, moved, mass):
    """Return True if the recurrence grows by more than GROWTH at each step of h s.

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
    # free motion over a step: (d, v) becomes (dd d + dv v, vd d + vv v)
    if rest > 0.0:
        rate = math.sqrt(rest)
        slow, fast = math.exp((rate - half) * h), math.exp(-(rate + half) * h)
        mean, dv = 0.5 * (slow + fast), 0.5 * (slow - fast) / rate
    else:
        rate = math.sqrt(-rest)
        fading = math.exp(-half * h)
        mean = fading * math.cos(rate * h)
        dv = fading * (math.sin(rate * h) / rate if rate > 0.0 else h)
    dd, vd, vv = mean + half * dv, -square * dv, mean - half * dv
    # what an acceleration of the base of 1, and a slope of 1 / h, add to d and v
    place, drift = decay / (square * square), -1.0 / square
    d_by_a, v_by_a = (dd - 1.0) / square, vd / square
    d_by_line = (place * (1.0 - dd) + drift * (h - dv)) / h
    v_by_line = (drift * (1.0 - vv) - place * vd) / h
    # the same as accelerations of the base, (spring d + dashpot v) / mass, and those of the adjugate of the free motion
    by_d, by_v = spring / mass, dashpot / mass
    adjugate_d, adjugate_v = by_d * vv - by_v * vd, by_v * dd - by_d * dv
    force, turned = by_d * d_by_a + by_v * v_by_a, adjugate_d * d_by_a + adjugate_v * v_by_a
    line, turned_line = by_d * d_by_line + by_v * v_by_line, adjugate_d * d_by_line + adjugate_v * v_by_line
    # differences of the accelerations of this exchange and the two before it, times h: the slope
    now, last, before = 1.0, -1.0, 0.0
    if way == SLOPE_HELD:
        now, last = 0.0, 0.0
    elif way != SLOPE_LINE:
        now, last, before = 11.0 / 6.0, -16.0 / 6.0, 5.0 / 6.0
    # characteristic polynomial, its roots divided by GROWTH
    a, b = GROWTH**4, GROWTH**3 * (-(dd + vv) - force - now * line)
    c = GROWTH**2 * (math.exp(-decay * h) + turned + now * turned_line - last * line)
    d, e = GROWTH * (last * turned_line - before * line), before * turned_line
    return not _stays_within(a, b, c, d, e)


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
