"""Shared by the partners: their tables of variables, and how a body moves from one communication point to the next.

Everything that calculates is a plain function over numbers, tuples and rows that are written in place: a PythonFMU runs
it as it stands, numba compiles the very same for the FMU without Python (native.py). Standard library only.
"""

import keyword
import math
from collections import namedtuple
from typing import NamedTuple

PARABOLA, LINE, HELD, GIVEN = range(4)
SLOPES = ("parabola", "line", "held", "given")
ALIKE = 1e-6  # of a step: steps that differ by less are the same
BEFORE = 10  # numbers that the steps before are kept in: how many; length, s, and accelerations of the last and of one
AXES = ("ax", "az", "alpha")

MOST = 1e300
ANY = (-MOST, MOST, "a finite number")
POSITIVE = (1e-300, MOST, "a positive number")
NOT_NEGATIVE = (0.0, MOST, "a number that is not negative")


class Port(NamedTuple):
    """One variable: a row of the partner's table.

    words: what a text may be; the functions are given the number of the word, from 0. limits: least, most, "must be".
    """

    name: str
    causality: str
    unit: str
    description: str
    start: object = None
    depends_on: tuple = ()
    words: tuple = ()
    limits: tuple = ANY


def port_input(name, unit, description):
    return Port(name, "input", unit, description, 0.0)


def port_output(name, unit, description, depends_on=()):
    return Port(name, "output", unit, description, None, tuple(depends_on))


def parameter(name, unit, description, start, limits=ANY):
    return Port(name, "parameter", unit, description, start, limits=limits)


def choice(name, description, words, start):
    return Port(name, "parameter", "", f"{description}: {', '.join(words)}", words[start], words=words)


def slope_parameter(start):
    """Return the parameter for the acceleration within a step."""
    text = "Slope within a step (parabola of the steps before, line since the step before, none, inputs given.*)"
    return choice("slope", text, SLOPES, start)


def field(name):
    """Name of a variable in the functions: base.ax is base_ax."""
    return name.replace(".", "_") + "_" * keyword.iskeyword(name)


def given_of(ports):
    """Return the class of what the functions are given: inputs and parameters, as numbers, in the order of the
    table.
    """
    return namedtuple("Given", [field(port.name) for port in ports if port.causality != "output"])


def slopes(way, given, a, before):
    """Return the rates of the accelerations from here on, per s."""
    if way == GIVEN:
        return given
    return slope(way, a[0], before, 0), slope(way, a[1], before, 1), slope(way, a[2], before, 2)


def slope(way, a, before, k):
    """Return the slope of the acceleration of one axis."""
    if way == HELD or before[0] < 1.0:
        return 0.0
    step, last = before[1], before[2 + k]
    line = (a - last) / step
    if way == LINE or before[0] < 2.0 or abs(before[5] - step) > ALIKE * step:
        return line
    return (11.0 * line - 5.0 * (last - before[6 + k]) / step) / 6.0


def remember(before, a, h):
    """Remember one more step of h s that began with the accelerations a."""
    for k in range(4):
        before[5 + k] = before[1 + k]
    before[0] = min(before[0] + 1.0, 2.0)
    before[1], before[2], before[3], before[4] = h, a[0], a[1], a[2]


def power(needs, v):
    """Return the power from the body to the column, W, by the forces of the body; the column's differ by coupling
    errors.
    """
    return -(needs[0] * v[0] + needs[1] * v[1] + needs[2] * v[2])


def later(a, slope, h):
    return a[0] + h * slope[0], a[1] + h * slope[1], a[2] + h * slope[2]


def is_finite(a):
    return math.isfinite(a[0] + a[1] + a[2])


def travel(position, rate, acceleration, slope, h):
    """Return (position, rate) after h s."""
    return (
        position + h * (rate + h * (0.5 * acceleration + h * slope / 6.0)),
        rate + h * (acceleration + 0.5 * h * slope),
    )
