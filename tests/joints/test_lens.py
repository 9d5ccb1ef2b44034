"""Round faces that have slipped: parts of the lens against quadrature. test_contacts.py has forces and motion."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.probe import Array

from solver.kernels.column.sections.lens import ends_of_rings, lens_part
from solver.kernels.numba_ext.jit import from_python

examples = settings(deadline=None, max_examples=300, derandomize=True)
_part, _ends = from_python(lens_part), from_python(ends_of_rings)


@dataclass(frozen=True)
class Faces:
    """Radii of the face above, which stands at 0, of its bore, and of those below, which stand at -slip; m."""

    own: float
    bore: float
    below: float
    bore_below: float
    slip: float

    def width(self, x: Array) -> Array:
        """Return the width of the contact, from the chords of the four circles."""

        def half(radius: float, place: Array) -> Array:
            return np.sqrt(np.maximum(0.0, (radius - place) * (radius + place)))

        outer = np.minimum(half(self.own, x), half(self.below, x + self.slip))
        inner = np.maximum(half(self.bore, x), half(self.bore_below, x + self.slip))
        return 2.0 * np.maximum(0.0, outer - inner)

    def kinks(self) -> list[float]:
        """Return rims, and where two of the circles cross."""
        circles = [(self.own, 0.0), (self.bore, 0.0), (self.below, -self.slip), (self.bore_below, -self.slip)]
        places = [centre + sign * radius for radius, centre in circles for sign in (-1.0, 1.0)]
        for one, _ in circles[:2]:
            for other, _ in circles[2:]:
                if self.slip != 0.0:
                    places.append((other * other - one * one - self.slip**2) / (2.0 * self.slip))
        return places

    def moments(self, lo: float, hi: float, about: float) -> Array:
        """Return the area, first and second moment about a place, by Gauss's rule; ends are drawn apart, as roots ask
        for.
        """
        x, w = np.polynomial.legendre.leggauss(60)
        edges = sorted({lo, hi, *(place for place in self.kinks() if lo < place < hi)})
        found = np.zeros(3)
        for begin, end in itertools.pairwise(edges):
            angle = 0.5 * math.pi * x
            places = 0.5 * (begin + end) + 0.5 * (end - begin) * np.sin(angle)
            weights = 0.5 * (end - begin) * np.cos(angle) * 0.5 * math.pi * w * self.width(places)
            found += [np.sum(weights * (places - about) ** k) for k in range(3)]
        return found

    def ends(self) -> tuple[float, float]:
        left, right = max(-self.own, -self.below - self.slip), min(self.own, self.below - self.slip)
        if self.bore > 0.0 and self.slip != 0.0:
            left, right = _ends(self.own, self.bore, self.below, self.bore_below, self.slip, left, right)
        return left, right


@st.composite
def faces(draw: st.DrawFn) -> Faces:
    own = 0.8
    below = own * draw(st.sampled_from([1.0, 1.0 + 1e-9, 1.01, 1.3]))
    bore = own * draw(st.sampled_from([0.0, 0.3, 0.9]))
    bore_below = bore * draw(st.sampled_from([0.0, 0.5, 1.0]))
    slip = draw(st.sampled_from([-1.0, 1.0])) * own * draw(st.sampled_from([1e-9, 1e-3, 0.05, 0.3, 0.8, 1.4]))
    return Faces(own, bore, below, bore_below, slip)


# of the contact; next to its ends quadrature is not exact, for roots begin there
PLACES = st.one_of(st.sampled_from([0.0, 1.0]), st.floats(0.01, 0.99))


@pytest.mark.long  # takes seconds
@given(found=faces(), low=PLACES, high=PLACES)
@examples
def test_parts_are_those_of_quadrature(found: Faces, low: float, high: float) -> None:
    left, right = found.ends()
    lo, hi = sorted(left + (right - left) * part for part in (low, high))
    middle, area, first, second = _part(found.own, found.bore, found.below, found.bore_below, found.slip, lo, hi)
    expected = found.moments(lo, hi, middle)
    whole = math.pi * found.own**2
    sizes = whole * np.array([1.0, found.own, found.own**2])
    assert np.max(np.abs(np.array([area, first, second]) - expected) / sizes) < 1e-12  # measured 3e-14


@pytest.mark.long  # takes seconds
@given(found=faces())
@examples
def test_beyond_the_ends_nothing_touches(found: Faces) -> None:
    left, right = found.ends()
    x = np.linspace(-2.0, 2.0, 4001)
    touching = x[found.width(x) > 1e-9]
    assert not touching.size or (touching[0] > left - 1e-9 and touching[-1] < right + 1e-9)
    whole = found.moments(-2.0, 2.0, 0.0)
    assert whole == pytest.approx(found.moments(left, right, 0.0) if left < right else np.zeros(3), abs=1e-10)
