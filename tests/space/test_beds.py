"""Pressure on sections of joints in space: against integrals that share nothing with the kernels."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from support.beds import bed_and_square
from support.structures import stack

from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.model import Structure

SCALE = 1e-4  # m, of penetrations


def drum(bore: float = 0.0) -> Structure:
    block = {"name": "d", "shape": "drum", "diameter": 2.0, "height": 1.0, "mass": 1000.0, "on": "base", "bore": bore}
    return Structure.from_dict({"name": "drum", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]})


# --- polygons, in rational numbers


def _clip(points: list[tuple[Fraction, ...]], place: int) -> list[tuple[Fraction, ...]]:
    """Return the part of a polygon of (x, y, p, q) where number `place` is positive."""
    kept: list[tuple[Fraction, ...]] = []
    for k, point in enumerate(points):
        before = points[k - 1]
        if (before[place] > 0) != (point[place] > 0):
            part = before[place] / (before[place] - point[place])
            kept.append(tuple(b + part * (a - b) for a, b in zip(point, before, strict=True)))
        if point[place] > 0:
            kept.append(point)
    return kept


def exact_bed(outline: FloatArray, p: FloatArray, q: FloatArray) -> tuple[FloatArray, float]:
    """Return (force, first_x, first_y, area, largest) in rational numbers, by Green's formulas; and their scale."""
    planes = [[Fraction(float(value)) for value in plane] for plane in (p, q)]
    corners = []
    for x, y in outline.tolist():
        fx, fy = Fraction(x), Fraction(y)
        corners.append((fx, fy, *(c + a * fx + b * fy for c, a, b in planes)))
    points = _clip(_clip(corners, 2), 3)
    area = sx = sy = xx = xy = yy = Fraction(0)
    for k, (x1, y1, *_) in enumerate(points):
        x0, y0 = points[k - 1][:2]
        d = x0 * y1 - x1 * y0
        area += d / 2
        sx, sy = sx + d * (x0 + x1) / 6, sy + d * (y0 + y1) / 6
        xx, yy = xx + d * (x0 * x0 + x0 * x1 + x1 * x1) / 12, yy + d * (y0 * y0 + y0 * y1 + y1 * y1) / 12
        xy += d * (2 * x0 * y0 + x0 * y1 + x1 * y0 + 2 * x1 * y1) / 24
    c, a, b = planes[1]
    parts = (c * area + a * sx + b * sy, c * sx + a * xx + b * xy, c * sy + a * xy + b * yy, area)
    largest = max((point[3] for point in points), default=Fraction(0))
    return np.array([float(part) for part in (*parts, largest)]), float(parts[0])


@pytest.mark.long  # takes 10 s and more
@pytest.mark.parametrize("seed", range(40))
def test_polygon_against_rational_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    structure = stack(1)
    outline = structure.joints[0].face.outline
    p, q = (SCALE * rng.normal(size=3) * (1.0, 2.0, 2.0) for _ in range(2))
    if seed % 4 == 0:
        q = p  # without damping
    if seed % 4 == 1:
        q = p * (1.0 + 0.1 * rng.normal(size=3))
    found, (expected, force) = bed_and_square(structure, p, q), exact_bed(outline, p, q)
    size = np.array([force, force, force, 2.5, SCALE]) + 1e-30
    assert np.max(np.abs(found[:5] - expected) / size) <= 1e-12  # measured 3e-15


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6])
def test_sliver_of_a_polygon_keeps_its_digits(depth: float) -> None:
    structure = stack(1)
    p = np.array([-SCALE * (0.78 - depth), SCALE, 0.0])
    expected = 0.5 * SCALE * depth**2 * 1.56
    # the rounding of the edge, 1e-16, counts over the depth of the sliver, twice: a difference of two lengths
    assert bed_and_square(structure, p, p)[0] == pytest.approx(expected, rel=1e-15 / depth + 1e-14)


# --- discs, by quadrature over x of what is exact over y


def _breaks(radius: float, p: FloatArray, q: FloatArray) -> list[float]:
    """Return the places along x where the integrand over x is not smooth."""
    found = [-radius, radius]
    for c, a, b in (p, q):
        slope = math.hypot(a, b)
        off, half = -c / slope, math.sqrt(max(0.0, radius**2 - (c / slope) ** 2))
        for way in (1.0, -1.0):
            found.append(off * a / slope + way * half * b / slope)
    (c0, a0, b0), (c1, a1, b1) = p, q
    turn = a0 * b1 - a1 * b0
    if turn != 0.0:
        found.append((b0 * c1 - b1 * c0) / turn)
    return sorted(min(radius, max(-radius, place)) for place in found)


def disc_bed(radius: float, p: FloatArray, q: FloatArray) -> FloatArray:
    nodes, weights = np.polynomial.legendre.leggauss(60)
    total = np.zeros(4)
    for lo, hi in np.lib.stride_tricks.sliding_window_view(_breaks(radius, p, q), 2):
        if hi <= lo:
            continue
        begin, end = math.asin(lo / radius), math.asin(hi / radius)
        angle = 0.5 * (begin + end) + 0.5 * (end - begin) * nodes
        x, rim = radius * np.sin(angle), radius * np.cos(angle)
        low, high = -rim, rim.copy()
        for c, a, b in (p, q):
            value = c + a * x
            if b > 0.0:
                low = np.maximum(low, -value / b)
            elif b < 0.0:
                high = np.minimum(high, -value / b)
            else:
                high = np.where(value > 0.0, high, low)
        high = np.maximum(low, high)
        c, a, b = q
        height, square, cube = high - low, 0.5 * (high**2 - low**2), (high**3 - low**3) / 3.0
        force = (c + a * x) * height + b * square
        columns = force, x * force, (c + a * x) * square + b * cube, height
        total += 0.5 * (end - begin) * np.array([np.sum(weights * rim * part) for part in columns])
    return total


@pytest.mark.parametrize("bore", [0.0, 0.8])
@pytest.mark.parametrize("seed", range(30))
def test_disc_and_ring_against_quadrature(seed: int, bore: float) -> None:
    rng = np.random.default_rng(100 + seed)
    p, q = (SCALE * rng.normal(size=3) * (0.7, 1.0, 1.0) for _ in range(2))
    if seed % 3 == 0:
        q = p * 1.5  # without damping, but for a factor
    if seed % 3 == 1:
        q = p + 0.05 * SCALE * rng.normal(size=3)
    found, expected = bed_and_square(drum(bore), p, q), disc_bed(1.0, p, q)
    if bore:
        expected = expected - disc_bed(0.5 * bore, p, q)
    size = np.array([SCALE, SCALE, SCALE, 3.0])
    assert np.max(np.abs(found[:4] - expected) / size) <= 1e-12  # measured 6e-15


def test_disc_against_the_segment_of_the_planar_functions() -> None:
    for depth in (1e-5, 1e-3, 0.3, 1.0, 1.7):
        p = SCALE * np.array([depth - 1.0, math.cos(0.7), math.sin(0.7)])
        found = bed_and_square(drum(), p, p)
        angle = math.acos(1.0 - depth)
        exact = (math.sin(angle) * (2.0 + math.cos(angle) ** 2) / 3.0) - angle * math.cos(angle)
        if depth < 1e-2:  # the first terms of the series
            exact = 2.0 * angle**5 / 15.0 * (1.0 - angle**2 * 5.0 / 42.0)
        assert found[0] == pytest.approx(SCALE * exact, rel=2e-6 if depth < 1e-2 else 1e-12)


def test_squares_are_the_energy_whose_derivative_is_the_force() -> None:
    for structure in (stack(1), drum(), drum(0.8)):
        for seed in range(5):
            p = SCALE * np.random.default_rng(seed).normal(size=3) * (0.5, 1.0, 1.0)
            for k in range(3):
                step = np.zeros(3)
                step[k] = 1e-3 * SCALE
                up, down = bed_and_square(structure, p + step, p)[5], bed_and_square(structure, p - step, p)[5]
                slope = 0.25 * (up - down) / step[k]
                # central differences of a function that is cubic where the contact is partial: measured 3e-7
                assert slope == pytest.approx(bed_and_square(structure, p, p)[k], rel=1e-5, abs=1e-6 * SCALE)
