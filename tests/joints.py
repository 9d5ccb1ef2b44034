"""The joint law for tests: of joints described by numbers, a rectangle where nothing else is said."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from solver.kernels.jit import from_python
from solver.kernels.joint import law, regimes, section
from solver.kernels.layout import STRIP_NUMBERS
from solver.kernels.views import row_of

Array = NDArray[np.float64]

NO_STRIPS = np.zeros(STRIP_NUMBERS)


@from_python
def _rectangle(width, depth, strips):
    return section.Contact(section.RECTANGLE, -0.5 * width, 0.5 * width, depth, 0.0, row_of(strips), 0.0, 0.0, 0.0)


@from_python
def _forces(k, width, depth, eta, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law.joint_forces(contact, k, eta, opening, slope, opening_rate, slope_rate)


@from_python
def _held(regime, k, width, depth, eta, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law.held_forces(regime, contact, k, eta, opening, slope, opening_rate, slope_rate)


@from_python
def _potential(k, width, depth, opening, slope, strips):
    return law.joint_potential(_rectangle(width, depth, strips), k, opening, slope)


_peak_pressure = from_python(law.joint_peak_pressure)
_regime = from_python(regimes.contact_regime)
_margin = from_python(regimes.regime_margin)


def joint_forces(*numbers: float) -> tuple[float, float, float]:
    """N, M and loaded length by stiffness, width, depth, damping, opening, slope and their rates."""
    n, m, length = _forces(*map(float, numbers), NO_STRIPS)
    return n, m, length


def held_forces(regime: int, *numbers: float) -> tuple[float, float, float, float]:
    """The same in a regime, and its margin."""
    n, m, length, margin = _held(regime, *map(float, numbers), NO_STRIPS)
    return n, m, length, margin


def joint_potential(*numbers: float) -> float:
    """Elastic energy by stiffness, width, depth, opening and slope."""
    return float(_potential(*map(float, numbers), NO_STRIPS))


def joint_peak_pressure(k: float, width: float, *rest: float) -> float:
    """Largest pressure by stiffness, width, damping, opening, slope and their rates."""
    return float(_peak_pressure(-0.5 * width, 0.5 * width, k, *rest))


def contact_regime(width: float, *rest: float) -> int:
    """Regime by width, damping, opening, slope and their rates."""
    return int(_regime(-0.5 * width, 0.5 * width, *rest))


def regime_margin(regime: int, width: float, *rest: float) -> float:
    """Its margin, by the same."""
    return float(_margin(regime, -0.5 * width, 0.5 * width, *rest))
