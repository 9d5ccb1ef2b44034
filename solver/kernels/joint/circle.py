"""Parts of a circle and of an annulus, in closed form (theory.md section 10).

A part of the unit circle from lo to hi is seen from the centre under the angles m - d to m + d, measured from the
diameter across the motion: lo = sin(m - d), hi = sin(m + d). Its moments about the middle of lo and hi are

    area   = E + 4 u sin d cos d
    first  = sin m (G - 4/3 u sin^3 d)
    second = H + u cos d G + 4/3 u^2 sin^3 d cos d          u = cos^2 m

with E = 2 d - sin 2d, G = 4/3 sin^3 d - E cos d, H = d/2 - sin(4d)/8 + E cos^2 d - 8/3 sin^3 d cos d. These are the
moments of the segment less the parts that cancel: no sum here is of numbers that nearly cancel, from the whole circle
to a sliver at its rim. E, G and H themselves, of third, fifth and seventh order in d, are taken from series where d is
small: dE/dd = 4 sin^2 d, dG/dd = E sin d, dH/dd = 2 G sin d.
"""

import math
from fractions import Fraction

from ..jit import kernel, leaf

SMALL = 0.2  # sin d: below it the series are exact to rounding
TERMS = 11


def _series() -> tuple[tuple[float, float, float], ...]:
    """Coefficients of E / sin^3 d, G / sin^5 d and H / sin^7 d in powers of sin^2 d, the highest power first."""
    # 1 / cos d = sum of these times sin^2k d
    secant = [Fraction(math.comb(2 * k, k), 4**k) for k in range(TERMS)]

    def integrated(factor: int, inner: list[Fraction], power: int) -> list[Fraction]:
        """Of factor * inner / cos d, inner beginning at the power of sin d below `power`."""
        terms = [[inner[j] * secant[k - j] for j in range(k + 1)] for k in range(TERMS)]
        return [factor * sum(parts, Fraction(0)) / (power + 2 * k) for k, parts in enumerate(terms)]

    e = integrated(4, [Fraction(1)] + [Fraction(0)] * (TERMS - 1), 3)
    g = integrated(1, e, 5)
    h = integrated(2, g, 7)
    return tuple((float(a), float(b), float(c)) for a, b, c in zip(e[::-1], g[::-1], h[::-1], strict=True))


SERIES = _series()


@leaf
def _by_series(s):
    """E, G and H for a small sin d."""
    square = s * s
    e = g = h = 0.0
    for coefficients in SERIES:
        e = e * square + coefficients[0]
        g = g * square + coefficients[1]
        h = h * square + coefficients[2]
    cube = s * square
    return e * cube, g * (cube * square), h * (cube * square * square)


@leaf
def _by_angle(s, c):
    """E, G and H from sin d and cos d."""
    angle = math.asin(s) if s < c else 0.5 * math.pi - math.asin(c)
    cube = s * s * s
    e = 2.0 * (angle - s * c)
    g = 4.0 / 3.0 * cube - c * e
    h = 0.5 * (angle - s * c * (c - s) * (c + s)) + c * (c * e - 8.0 / 3.0 * cube)
    return e, g, h


@leaf
def _unit_part(lo, hi):
    """Area, first and second moment about the middle, of the part of the unit circle from lo to hi > lo."""
    chords = math.sqrt((1.0 - lo) * (1.0 + lo)) + math.sqrt((1.0 - hi) * (1.0 + hi))  # half of both
    if chords == 0.0:
        return math.pi, 0.0, 0.25 * math.pi
    ends = lo + hi
    span = math.sqrt(ends * ends + chords * chords)  # 2 cos d
    c = 0.5 * span
    s = 0.5 * span * (hi - lo) / chords
    sine, cosine = ends / span, chords / span  # of m
    u = cosine * cosine
    e, g, h = _by_series(s) if s < SMALL else _by_angle(s, c)
    cube = 4.0 / 3.0 * u * (s * s * s)
    return e + 4.0 * u * (s * c), sine * (g - cube), h + u * c * (g + cube)


@kernel
def circle_part(radius, lo, hi):
    """Middle, area, first and second moment about it, of the part of a circle between two abscissas, m from the centre.

    Nothing lies beyond the rim.
    """
    square = radius * radius
    if lo <= -radius and hi >= radius:
        area = math.pi * square
        return 0.0, area, 0.0, 0.25 * area * square
    lo, hi = max(lo, -radius), min(hi, radius)
    middle = 0.5 * (lo + hi)
    if not lo < hi:
        return middle, 0.0, 0.0, 0.0
    per = 1.0 / radius
    area, first, second = _unit_part(max(lo * per, -1.0), min(hi * per, 1.0))
    return middle, area * square, first * (square * radius), second * (square * square)


@kernel
def ring_part(outer, inner, lo, hi):
    """The same of an annulus between two radii: a circle less another one, which may be none."""
    middle = 0.5 * (max(lo, -outer) + min(hi, outer))
    area = first = second = 0.0
    radius, sign = outer, 1.0
    while radius > 0.0:
        own, a, b, c = circle_part(radius, lo, hi)
        off = own - middle
        area += sign * a
        first += sign * (b + off * a)
        second += sign * (c + off * (2.0 * b + off * a))
        radius = inner if sign > 0.0 else 0.0
        sign = -1.0
    return middle, area, first, second
