"""Elementary functions of one number or of lanes (lanes.py)."""

import math

from .jit import by_width, leaf
from .lanes import LanesType, any_of, greater, lesser, magnitude, nearest, rarely, where

SMALL = 0.03  # rad: below this the short polynomials are exact to rounding
QUARTER = 0.25 * math.pi + 1e-3  # rad: below this the long ones are

# half of pi in three parts, of which the first two have trailing zeros
HALF_PI_1 = 1.5707963267341256
HALF_PI_2 = 6.077100506303966e-11
HALF_PI_3 = 2.0222662487959506e-21

# of the arc tangent of t over t, in pairs for t^2 and t^4, t^6 and t^8 and so on, the highest first: it interpolates at
# Chebyshev's points of t^2 up to tan(pi / 8)^2; the error is 3e-18 at most
ARC = (
    (-0.017803896394812564, 0.0),
    (-0.05035049795312439, 0.03796390316111083),
    (-0.06662950246036792, 0.05846866752275139),
    (-0.09090896801472813, 0.07692045194561481),
    (-0.14285714279244968, 0.11111110744657099),
    (-0.3333333333333312, 0.19999999999940837),
)


@leaf
def _short(x):
    y = x * x
    sine = x * (1.0 + y * (-1.0 / 6.0 + y * (1.0 / 120.0 - y * (1.0 / 5040.0))))
    cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 - y * (1.0 / 720.0)))
    return sine, cosine


@leaf
def _long(x):
    """Return sine and cosine by Taylor polynomials, for |x| up to QUARTER."""
    y = x * x
    # sine to x^17
    sine = 1.0 / 6227020800.0 - y * (1.0 / 1307674368000.0 - y * (1.0 / 355687428096000.0))
    sine = -1.0 / 5040.0 + y * (1.0 / 362880.0 + y * (-1.0 / 39916800.0 + y * sine))
    sine = x + x * (y * (-1.0 / 6.0 + y * (1.0 / 120.0 + y * sine)))
    # cosine to x^18
    cosine = -1.0 / 87178291200.0 + y * (1.0 / 20922789888000.0 - y * (1.0 / 6402373705728000.0))
    cosine = -1.0 / 720.0 + y * (1.0 / 40320.0 + y * (-1.0 / 3628800.0 + y * (1.0 / 479001600.0 + y * cosine)))
    cosine = 1.0 + y * (-0.5 + y * (1.0 / 24.0 + y * cosine))
    return sine, cosine


@leaf
def angle_of(sine, cosine):
    """Return the angle (rad), from 0 to half of pi, of a sine and a cosine; numbers and lanes give equal bits."""
    t = lesser(sine, cosine) / (1.0 + greater(sine, cosine))  # tangent of half of it, or of half of its complement
    y = t * t
    square = y * y
    # polynomial of the arc tangent, in pairs
    rest = 0.0
    for odd, even in ARC:
        rest = rest * square + (odd + even * y)
    angle = 2.0 * (t + t * (y * rest))
    return where(sine > cosine, 0.5 * math.pi - angle, angle)


@by_width
def sine_cosine(x):
    """Return sin(x) and cos(x); by polynomials where the rest of the series is below rounding."""
    return _sine_cosine_of_lanes if isinstance(x, LanesType) else _sine_cosine_of_one


@by_width
def sine(x):
    """Return sin(x) for |x| up to 1e6."""
    return _sine_of_lanes if isinstance(x, LanesType) else lambda x: math.sin(x)


@by_width
def half_sine_cosine(x):
    """Return sin(x / 2) and cos(x / 2)."""
    return _half_sine_cosine_of_lanes if isinstance(x, LanesType) else _half_sine_cosine_of_one


@leaf
def _short_half(x):
    """Return `_short` of x / 2: its coefficients times powers of two, hence equal bits without a product."""
    y = x * x
    sine = x * (0.5 + y * (-1.0 / 48.0 + y * (1.0 / 3840.0 - y * (1.0 / 645120.0))))
    cosine = 1.0 + y * (-0.125 + y * (1.0 / 384.0 - y * (1.0 / 46080.0)))
    return sine, cosine


def _half_sine_cosine_of_one(x):
    if abs(x) > 2.0 * SMALL:
        return math.sin(0.5 * x), math.cos(0.5 * x)
    return _short_half(x)


def _sine_cosine_of_one(x):
    if abs(x) > SMALL:
        return math.sin(x), math.cos(x)
    return _short(x)


@leaf
def _reduced(x):
    """Return x less the nearest multiple of half of pi, and the number of that multiple modulo 4 as a float."""
    turns = nearest(x * (2.0 / math.pi))
    rest = ((x - turns * HALF_PI_1) - turns * HALF_PI_2) - turns * HALF_PI_3
    return rest, turns - 4.0 * nearest(0.25 * turns - 0.125)


@leaf
def _of_any_size(x):
    """Return sine and cosine of lanes, by the nearest multiple of half of pi."""
    rest, quarter = _reduced(x)
    s, c = _long(rest)
    # odd quarters exchange sine and cosine
    odd = (quarter == 1.0) | (quarter == -1.0)
    back = quarter == 2.0
    return where(odd, quarter * c, where(back, -s, s)), where(odd, -(quarter * s), where(back, -c, c))


@leaf
def _with_long(short, x, most):
    """Return sine and cosine of lanes: the short polynomials where |x| is at most `most`, else the long ones."""
    first, second = short
    large = magnitude(x) > most
    # few lanes are beyond the short polynomials
    if rarely(any_of(large)):
        long_sine, long_cosine = _of_any_size(x)
        first = where(large, long_sine, first)
        second = where(large, long_cosine, second)
    return first, second


def _sine_cosine_of_lanes(x):
    return _with_long(_short(x), x, SMALL)


def _half_sine_cosine_of_lanes(x):
    return _with_long(_short_half(x), 0.5 * x, SMALL)


def _sine_of_lanes(x):
    return sine_cosine(x)[0]
