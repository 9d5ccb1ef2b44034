"""The exchange of a base with the bodies that drive it: history of its acceleration, and its slope over a step."""

from ..layout.spaces import (
    SLOPE_HELD,
    SLOPE_LINE,
)
from ..numba_ext.jit import leaf

SINGULAR = 1e-12  # relative to a mass: a smaller remainder counts as zero


ALIKE = 1e-6  # relative to a step: closer steps are equal


ROUNDING = 1e-12  # relative to the time


@leaf
def are_silent(inputs, first, count):
    """Return True if the bodies have sent nothing yet: hosts that exchange after steps alone begin with zeros."""
    silent = True
    for k in range(first, first + count):
        silent = silent and inputs[k] == 0.0
    return silent


@leaf
def slope_of(way, steps, step, before, here, last, earlier):
    """Return the slope (per s) of an acceleration from here on, from those at the `steps` steps before.

    From three instants it is that of the line that gives the same velocity as their parabola after an equal step.

    Parameters
    ----------
    way : float
        Code of SLOPES.
    steps : float
        Number of steps before, at most 2.
    step, before : float
        Lengths of the last step and of the one before, s.
    here, last, earlier : float
        The acceleration now and at the two exchanges before.
    """
    if way == SLOPE_HELD or steps < 1.0:
        return 0.0
    # slope of the last step
    line = (here - last) / step
    if way == SLOPE_LINE or steps < 2.0 or abs(before - step) > ALIKE * step:
        return line
    return (11.0 * line - 5.0 * (last - earlier) / step) / 6.0


@leaf
def goes_on(base, t):
    """Return True if time has advanced to t since the last exchange, by more than rounding; then count a step more."""
    step = t - base.t0
    is_later = base.coupled != 0.0 and step > ALIKE * base.last_step + ROUNDING * abs(t)
    if is_later:
        # lengths of the last two communication steps
        base.steps = min(base.steps + 1.0, 2.0)
        base.before_step, base.last_step = base.last_step, step
    return is_later


@leaf
def gone_on(place, rate, acceleration, slope, past):
    """Return (place, rate, acceleration) `past` s later, with a constant slope of the acceleration."""
    return (
        place + past * (rate + past * (0.5 * acceleration + past * (slope / 6.0))),
        rate + past * (acceleration + 0.5 * past * slope),
        acceleration + past * slope,
    )
