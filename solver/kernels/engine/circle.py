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

from ..numba_ext.jit import kernel, leaf
from ..numba_ext.lanes import (
    any_of,
    greater,
    lesser,
    rarely,
    square_root,
    where,
)
from ..numba_ext.numbers import angle_of

SMALL = 0.125  # sin d: below it the series are exact to rounding
TERMS = 8


def _series() -> tuple[tuple[float, float, float], ...]:
    """Return the coefficients of E / sin^3 d, G / sin^5 d and H / sin^7 d in powers of sin^2 d, highest power first."""
    # 1 / cos d = sum of these times sin^2k d
    secant = [Fraction(math.comb(2 * k, k), 4**k) for k in range(TERMS)]

    def integrated(factor: int, inner: list[Fraction], power: int) -> list[Fraction]:
        """Integrate factor * inner / cos d; the series inner begins at the power of sin d below `power`."""
        terms = [[inner[j] * secant[k - j] for j in range(k + 1)] for k in range(TERMS)]
        return [factor * sum(parts, Fraction(0)) / (power + 2 * k) for k, parts in enumerate(terms)]

    # G is an integral of E, H one of G
    e = integrated(4, [Fraction(1)] + [Fraction(0)] * (TERMS - 1), 3)
    g = integrated(1, e, 5)
    h = integrated(2, g, 7)
    return tuple((float(a), float(b), float(c)) for a, b, c in zip(e[::-1], g[::-1], h[::-1], strict=True))


SERIES = _series()


@leaf
def _by_series(s):
    """Return E, G and H by their series, for a small sin d."""
    square = s * s
    e = g = h = 0.0
    # Horner's rule for all three
    for coefficients in SERIES:
        e = e * square + coefficients[0]
        g = g * square + coefficients[1]
        h = h * square + coefficients[2]
    cube = s * square
    return e * cube, g * (cube * square), h * (cube * square * square)


@leaf
def _by_angle(s, c):
    """Return E, G and H from sin d and cos d in closed form."""
    angle = angle_of(s, c)
    cube = s * s * s
    # closed forms; exact enough where the angle is not small
    e = 2.0 * (angle - s * c)
    g = 4.0 / 3.0 * cube - c * e
    h = 0.5 * (angle - s * c * (c - s) * (c + s)) + c * (c * e - 8.0 / 3.0 * cube)
    return e, g, h


@kernel
def _curved(s, c):
    """Return E, G and H; in lanes either form is evaluated where any lane needs it."""
    e = g = h = 0.0
    small, large = s < SMALL, s >= SMALL
    if any_of(large):
        e, g, h = _by_angle(s, c)
    if any_of(small):
        first, second, third = _by_series(s)
        e, g, h = where(small, first, e), where(small, second, g), where(small, third, h)
    return e, g, h


@leaf
def _segment(radius, below, cut):
    """Return sin d, cos d, sin m and cos m of the segment beyond a chord at `cut` (m), or of its mirror image."""
    per = 0.5 / radius
    s, c = square_root((radius - cut) * per), square_root((radius + cut) * per)
    return s, c, where(below, c, -c), s


@kernel
def _between(radius, lo, hi):
    """Return sin d, cos d, sin m and cos m of the part between two chords."""
    # sum of the abscissas, and of the half chords
    ends = lo + hi
    chords = square_root((radius - lo) * (radius + lo)) + square_root((radius - hi) * (radius + hi))  # half of both
    span = square_root(ends * ends + chords * chords)  # 2 radius cos d
    per = 1.0 / (span * chords)  # one division for all
    c = 0.5 * span / radius
    return c * (hi - lo) * (span * per), c, ends * (chords * per), chords * (chords * per)


@leaf
def circle_part(radius, lo, hi):
    """Return middle, area, first and second moment about it of the part of a circle between two abscissas.

    In m from the centre, m2, m3 and m4; of one circle or of lanes. The interval is clipped to the circle.
    """
    # clip the interval to the circle
    lo, hi = greater(lo, -radius), lesser(hi, radius)
    # the whole circle
    ends, square = lo + hi, radius * radius
    area = math.pi * square
    first, second = 0.0 * area, 0.25 * area * square
    below, above = lo > -radius, hi < radius
    cut_off = below | above
    # angles of a segment, or of a part between two chords
    if any_of(cut_off):
        s, c, sine, cosine = _segment(radius, below, where(below, lo, -hi))
        between = below & above
        if rarely(any_of(between)):
            found = _between(radius, lo, hi)
            s, c = where(between, found[0], s), where(between, found[1], c)
            sine, cosine = where(between, found[2], sine), where(between, found[3], cosine)
        # moments by E, G and H as in the module's text
        u = cosine * cosine
        e, g, h = _curved(s, c)
        cube = 4.0 / 3.0 * u * (s * s * s)
        some = lo < hi
        area = where(cut_off, where(some, (e + 4.0 * u * (s * c)) * square, 0.0), area)
        first = where(cut_off & some, sine * (g - cube) * (square * radius), 0.0)
        second = where(cut_off, where(some, (h + u * c * (g + cube)) * (square * square), 0.0), second)
    return 0.5 * ends, area, first, second


@kernel
def ring_part(outer, inner, lo, hi):
    """Return `circle_part` of an annulus between two radii (m): a circle less another one, whose radius may be 0."""
    # middle of the clipped interval
    about = 0.5 * (greater(lo, -outer) + lesser(hi, outer))
    area = first = second = 0.0 * about
    hollow = inner > 0.0
    # the outer circle, then the bore: a loop, so that it is compiled once
    for k in range(2):
        if k == 1 and not any_of(hollow):
            break
        middle, a, b, c = circle_part(outer if k == 0 else inner, lo, hi)
        off, sign = middle - about, 1.0 if k == 0 else -1.0
        area += sign * a  # zero without a bore
        first += sign * (b + off * a)
        second += sign * (c + off * (2.0 * b + off * a))
    return about, area, first, second
