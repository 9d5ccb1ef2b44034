"""The joint law for tests: joints described by numbers, by default rectangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solver.kernels.column.joint import law, regimes
from solver.kernels.column.sections import faces, section
from solver.kernels.layout.spaces import STRIP_NUMBERS
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of

Array = NDArray[np.float64]

NO_STRIPS = np.zeros(STRIP_NUMBERS)


@from_python
def _rectangle(width, depth, strips):
    return section.ContactSection(
        faces.RECTANGLE, -0.5 * width, 0.5 * width, depth, 0.0, row_of(strips), 0.0, 0.0, 0.0, 0.0
    )


@from_python
def _forces(own, width, depth, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law.joint_forces(contact, own, opening, slope, opening_rate, slope_rate)


@from_python
def _held(regime, own, width, depth, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law.held_forces(regime, contact, own, opening, slope, opening_rate, slope_rate)


@from_python
def _tangent(own, width, depth, lo, hi, mean, gradient, strips):
    return law.joint_tangent(_rectangle(width, depth, strips), own, lo, hi, mean, gradient)


@from_python
def _potential(own, width, depth, opening, slope, strips):
    return law.joint_potential(_rectangle(width, depth, strips), own, opening, slope)


@from_python
def _peak_pressure(own, width, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, 1.0, strips)
    _, _, length = law.joint_forces(contact, own, opening, slope, opening_rate, slope_rate)
    return law.joint_peak_pressure(contact, own, length, opening, slope, opening_rate, slope_rate)


_regime = from_python(regimes.contact_regime)
_margin = from_python(regimes.regime_margin)


def law_of(stiffness: float, damping: float = 0.0, **others: float) -> law.PressureLaw:
    """Return a law; parameters that are not given are 0."""
    given = {"stiffness": stiffness, "damping": damping} | others
    return law.PressureLaw(*(float(given.get(name, 0.0)) for name in law.PressureLaw._fields))


def joint_forces(
    k: float, width: float, depth: float, eta: float, *motion: float, **others: float
) -> tuple[float, float, float]:
    """Return N, M and loaded length by stiffness, width, depth, damping, opening, slope and their rates.

    others: here and below, parameters of another law, by name.
    """
    n, m, length = _forces(law_of(k, eta, **others), float(width), float(depth), *map(float, motion), NO_STRIPS)
    return n, m, length


def held_forces(
    regime: int, k: float, width: float, depth: float, eta: float, *motion: float, **others: float
) -> tuple[float, float, float, float]:
    """Return `joint_forces` held in a regime, and the margin of that regime."""
    own = law_of(k, eta, **others)
    n, m, length, margin = _held(regime, own, float(width), float(depth), *map(float, motion), NO_STRIPS)
    return n, m, length, margin


def joint_tangent(k: float, width: float, depth: float, *part: float, **others: float) -> tuple[float, float, float]:
    """Return the derivatives of N and M by stiffness, width, depth, both ends of the loaded part, mean and gradient."""
    along, mixed, second = _tangent(law_of(k, **others), float(width), float(depth), *map(float, part), NO_STRIPS)
    return along, mixed, second


def joint_potential(k: float, *numbers: float, **others: float) -> float:
    """Return the elastic energy by stiffness, width, depth, opening and slope."""
    return float(_potential(law_of(k, **others), *map(float, numbers), NO_STRIPS))


def joint_peak_pressure(k: float, width: float, eta: float, *motion: float, **others: float) -> float:
    """Return the largest pressure by stiffness, width, damping, opening, slope and their rates."""
    return float(_peak_pressure(law_of(k, eta, **others), float(width), *map(float, motion), NO_STRIPS))


def contact_regime(width: float, *rest: float) -> int:
    """Return the regime by width, damping, opening, slope and their rates."""
    return int(_regime(-0.5 * width, 0.5 * width, *rest))


def regime_margin(regime: int, width: float, *rest: float) -> float:
    """Return the margin of a regime, by width, damping, opening, slope and their rates."""
    return float(_margin(regime, -0.5 * width, 0.5 * width, *rest))
