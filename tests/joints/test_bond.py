"""The law of brittle joints (docs/mortar.md) against quadrature, fibres that break one by one, and its closed form."""

from __future__ import annotations

from dataclasses import astuple, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq
from support.joint_states import State, examples, states
from support.joints import NO_STRIPS, _rectangle, joint_forces, law_of

from solver.kernels.column.joint import bond as law_of_bonds
from solver.kernels.column.joint.bond import GROWS_LEFT, GROWS_RIGHT, Bond
from solver.kernels.numba_ext.jit import from_python

PARTS = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(0.0, 2.0))  # of the width; of the stretch


@from_python
def _forces(own, width, depth, bond, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law_of_bonds.bonded_forces(contact, own, bond, opening, slope, opening_rate, slope_rate)


@from_python
def _held(regime, own, width, depth, bond, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, depth, strips)
    return law_of_bonds.held_bonded_forces(regime, contact, own, bond, opening, slope, opening_rate, slope_rate)


@from_python
def _regime(width, damping, bond, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, 1.0, strips)
    return law_of_bonds.bond_regime(contact, damping, bond, opening, slope, opening_rate, slope_rate)


@from_python
def _margin(regime, width, damping, bond, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, 1.0, strips)
    return law_of_bonds.bond_margin(regime, contact, damping, bond, opening, slope, opening_rate, slope_rate)


@from_python
def _peak_pressure(own, width, left, right, opening, slope, opening_rate, slope_rate, strips):
    contact = _rectangle(width, 1.0, strips)
    return law_of_bonds.bonded_peak_pressure(contact, own, left, right, opening, slope, opening_rate, slope_rate)


class Found(NamedTuple):
    """Resultants and what is bonded then."""

    force: float
    moment: float
    length: float
    left: float
    right: float


def forces(state: State, bond: Bond) -> Found:
    own = law_of(state.stiffness, state.damping)
    motion = (state.opening, state.slope, state.opening_rate, state.slope_rate)
    return Found(*_forces(own, state.width, state.depth, bond, *motion, NO_STRIPS))


def bond_of(state: State, parts: tuple[float, float, float]) -> Bond:
    """Return a bonded part of a joint; its reach is a part of the largest stretch of the contact."""
    stretch = abs(state.opening) + 0.5 * state.width * abs(state.slope)
    one, other, reach = parts
    return Bond(state.width * min(one, other), state.width * max(one, other), reach * stretch)


def by_pieces(state: State, bond: Bond) -> tuple[float, float]:
    """Return N and M by two Gauss points between all places where the pressure bends or jumps: exact."""
    half = 0.5 * state.width

    def pen(s: float) -> float:
        return -state.opening + s * state.slope

    def felt(s: float) -> float:
        return pen(s) + state.damping * (-state.opening_rate + s * state.slope_rate)

    places = [-half, half, bond.left, bond.right]
    gradient = state.slope + state.damping * state.slope_rate
    if state.slope:
        places += [state.opening / state.slope, (state.opening - bond.reach) / state.slope]
    if gradient:
        places.append((state.opening + state.damping * state.opening_rate) / gradient)
    places = sorted(min(max(place, -half), half) for place in places)
    force = moment = 0.0
    for lo, hi in pairwise(places):
        middle, part = 0.5 * (lo + hi), 0.5 * (hi - lo)
        whole = bond.left < middle < bond.right and pen(middle) >= -bond.reach
        bears = whole or (pen(middle) > 0.0 and felt(middle) > 0.0)
        for s in (middle - part / np.sqrt(3.0), middle + part / np.sqrt(3.0)):
            pressure = state.stiffness * felt(s) * state.depth * part if bears else 0.0
            force, moment = force + pressure, moment + pressure * s
    return force, moment


@given(state=states(), parts=PARTS)
@examples
def test_forces_are_the_integral_of_the_pressure(state: State, parts: tuple[float, float, float]) -> None:
    bond = bond_of(state, parts)
    force, moment, *_ = forces(state, bond)
    expected_force, expected_moment = by_pieces(state, bond)
    assert force == pytest.approx(expected_force, abs=1e-13 * state.force)  # measured 3e-16
    assert moment == pytest.approx(expected_moment, abs=1e-13 * state.force * state.width)  # measured 6e-17


@given(state=states(), parts=PARTS)
@examples
def test_mirror_images_have_mirrored_forces_to_the_last_bit(state: State, parts: tuple[float, float, float]) -> None:
    bond = bond_of(state, parts)
    image = replace(state, slope=-state.slope, slope_rate=-state.slope_rate)
    one, other = forces(state, bond), forces(image, Bond(-bond.right, -bond.left, bond.reach))
    assert (one.force, one.moment, one.length) == (other.force, -other.moment, other.length)
    assert (one.left, one.right) == (-other.right, -other.left)


@given(state=states())
@examples
def test_a_broken_joint_is_the_dry_one_to_the_last_bit(state: State) -> None:
    force, moment, length, left, right = forces(state, Bond(0.0, 0.0, 1.0))
    assert (force, moment, length) == joint_forces(*astuple(state))
    assert left == right


@given(state=states(), parts=PARTS)
@examples
def test_held_in_its_regime_a_joint_has_the_same_forces(state: State, parts: tuple[float, float, float]) -> None:
    bond = bond_of(state, parts)
    before = forces(state, bond)
    if not before.left < before.right:
        return
    left = Bond(before.left, before.right, bond.reach)  # as a step stores it
    motion = (state.opening, state.slope, state.opening_rate, state.slope_rate)
    regime = _regime(state.width, state.damping, left, *motion, NO_STRIPS)
    own = law_of(state.stiffness, state.damping)
    *held, margin = _held(regime, own, state.width, state.depth, left, *motion, NO_STRIPS)
    size = state.force
    assert held[0] == pytest.approx(before.force, abs=1e-14 * size)  # measured 0
    assert held[1] == pytest.approx(before.moment, abs=1e-14 * size * state.width)  # measured 0
    stretch = abs(state.opening) + state.width * abs(state.slope)
    assert margin >= -1e-12 * stretch  # rounding of the front
    assert margin == _margin(regime, state.width, state.damping, left, *motion, NO_STRIPS)


def test_a_crack_grows_while_its_front_is_pulled() -> None:
    bond = Bond(-0.5, 0.5, 1e-4)
    at_the_edge = (-4e-4, 1e-3)  # the fibre at -0.5 m is stretched by 1e-4 m
    for rate, grows in ((1e-3, True), (-1e-3, False)):
        regime = _regime(1.0, 0.0, bond, *at_the_edge, 0.0, rate, NO_STRIPS)
        assert bool(regime & GROWS_LEFT) is grows
        image = _regime(1.0, 0.0, bond, at_the_edge[0], -at_the_edge[1], 0.0, -rate, NO_STRIPS)
        assert bool(image & GROWS_RIGHT) is grows
        if grows:  # its margin is how fast the fibre at the front is pulled, until nothing remains
            margin = _margin(regime, 1.0, 0.0, bond, *at_the_edge, 0.0, rate, NO_STRIPS)
            assert margin == pytest.approx(0.5 * rate, rel=1e-12)
            assert _margin(regime, 1.0, 0.0, bond, 7e-4, 1e-3, 0.0, rate, NO_STRIPS) < 0.0


def test_the_largest_pressure_is_that_of_the_pieces() -> None:
    own = law_of(1e9, 0.0)
    # bonded right of the middle, dry on the left, pressed there; and pulled where it is bonded
    assert _peak_pressure(own, 1.0, 0.0, 0.5, -1e-4, -2e-4, 0.0, 0.0, NO_STRIPS) == pytest.approx(2e5, rel=1e-14)
    assert _peak_pressure(own, 1.0, 0.0, 0.5, 1e-4, 0.0, 0.0, 0.0, NO_STRIPS) == 0.0


# --- moment against rotation under a constant force

STIFFNESS, WIDTH, DEPTH = 1e9, 1.2, 0.8
NORMAL = 1e5  # N


class Quasistatic:
    """A joint that is turned under a constant force; its memory shrinks."""

    def __init__(self, strength: float) -> None:
        self.strength, self.left, self.right = strength, -0.5 * WIDTH, 0.5 * WIDTH

    def at(self, theta: float, normal: float = NORMAL) -> tuple[float, float]:
        """Return the opening and moment."""
        own, reach = law_of(STIFFNESS), self.strength / STIFFNESS

        def of(opening: float) -> Found:
            bond = Bond(self.left, self.right, reach)
            return Found(*_forces(own, WIDTH, DEPTH, bond, opening, theta, 0.0, 0.0, NO_STRIPS))

        area = WIDTH * DEPTH * STIFFNESS
        # the least opening that balances: from the compressed side on
        low, step = -2.0 * normal / area - WIDTH * abs(theta), 1e-3 * normal / area
        high = low + step
        while of(high).force > normal:
            high += step
        opening = brentq(lambda x: of(x).force - normal, low, high, xtol=1e-18, rtol=1e-15)
        found = of(opening)
        self.left, self.right = found.left, found.right
        return opening, found.moment


def turned_and_moment(a: float, strength: float, normal: float = NORMAL) -> tuple[float, float]:
    """Return the rotation and moment where the length a bears: docs/notes/structures.md."""
    theta = (2.0 * normal / (a * DEPTH) + 2.0 * strength) / (STIFFNESS * a)
    return theta, normal * (0.5 * WIDTH - a / 3.0) + strength * DEPTH * a * a / 6.0


@pytest.mark.parametrize("strength", [0.0, 5e4, 2e5])
def test_moment_follows_its_closed_form_and_back(strength: float) -> None:
    joint = Quasistatic(strength)
    first = 2.0 * (NORMAL / (WIDTH * DEPTH) + strength) / (STIFFNESS * WIDTH)
    assert turned_and_moment(WIDTH, strength)[0] == pytest.approx(first, rel=1e-15)
    for part in (0.2, 0.7, 0.999):  # whole: linear
        _, moment = joint.at(part * first)
        assert moment == pytest.approx(STIFFNESS * DEPTH * WIDTH**3 / 12.0 * part * first, rel=1e-12)  # 2e-16
        assert joint.right - joint.left == WIDTH
    for a in (1.1, 0.9, 0.6, 0.4):
        theta, expected = turned_and_moment(a, strength)
        _, moment = joint.at(theta)
        assert moment == pytest.approx(expected, rel=1e-12)  # measured 4e-16
        assert joint.right - joint.left == pytest.approx(a, rel=1e-12)  # measured 3e-16
    left = joint.right - joint.left
    # back: what is left bears a straight line, until the crack closes
    whole = 2.0 * NORMAL / (DEPTH * STIFFNESS * left**2)  # at which the pressure at the tip is 0
    for part in (1.0, 0.99):
        _, moment = joint.at(whole * (1.0 + part * strength * left * DEPTH / NORMAL))
        middle = 0.5 * (WIDTH - left)
        turning = STIFFNESS * DEPTH * left**3 / 12.0 * whole * (1.0 + part * strength * left * DEPTH / NORMAL)
        assert moment == pytest.approx(NORMAL * middle + turning, rel=1e-12)  # measured 7e-16
    closed = 2.0 * NORMAL / (WIDTH * DEPTH) / (STIFFNESS * WIDTH)
    for part in (0.9, 0.1, -0.5):
        _, moment = joint.at(part * closed)
        assert moment == pytest.approx(STIFFNESS * DEPTH * WIDTH**3 / 12.0 * part * closed, rel=1e-12)  # 9e-16
    assert joint.right - joint.left == pytest.approx(left, rel=1e-12)


def test_fibres_that_break_one_by_one_bear_the_same() -> None:
    strength, count = 2e5, 40_001
    places = ((np.arange(count) + 0.5) / count - 0.5) * WIDTH
    area, whole, joint = WIDTH * DEPTH / count, np.ones(count, dtype=bool), Quasistatic(strength)
    first = 2.0 * (NORMAL / (WIDTH * DEPTH) + strength) / (STIFFNESS * WIDTH)
    path = first * np.array([0.5, 1.2, 1.9, 0.4, 2.6, -1.3, -2.4, 0.7])
    for theta in path:
        opening, moment = joint.at(theta)
        pen = -opening + places * theta
        whole &= STIFFNESS * pen >= -strength
        pressure = np.where(whole, STIFFNESS * pen, STIFFNESS * np.maximum(pen, 0.0))
        # a fibre more or less at the front: strength times its area
        assert np.sum(pressure) * area == pytest.approx(NORMAL, abs=2.0 * strength * area)  # measured 0.24 of it
        assert np.sum(pressure * places) * area == pytest.approx(
            moment, abs=2.0 * strength * area * WIDTH
        )  # 0.05 of it
        assert np.sum(whole) / count * WIDTH == pytest.approx(joint.right - joint.left, abs=2.0 * WIDTH / count)
    assert joint.right - joint.left < 0.6 * WIDTH


@pytest.mark.long  # takes seconds
def test_what_a_crack_takes_is_that_of_its_fibres() -> None:
    """Compare the work of moment and force, less the elastic energy, with strength^2 / (2 stiffness) times the broken
    area.
    """
    strength = 5e4
    nodes, weights = np.polynomial.legendre.leggauss(12)
    joint = Quasistatic(strength)
    theta, _ = turned_and_moment(WIDTH, strength)
    opening, _ = joint.at(theta)
    begun, work = (opening, theta), 0.0
    lengths = np.linspace(WIDTH, 0.5 * WIDTH, 9)
    for one, other in pairwise(lengths):
        for node, weight in zip(nodes, weights, strict=True):
            a = 0.5 * (one + other) + 0.5 * (other - one) * node
            theta, _ = turned_and_moment(a, strength)
            _, moment = joint.at(theta)
            slope = -(4.0 * NORMAL / (a * DEPTH) + 2.0 * strength) / (STIFFNESS * a * a)  # d theta / d a
            work += 0.5 * (other - one) * weight * moment * slope
    theta, _ = turned_and_moment(lengths[-1], strength)
    opening, _ = joint.at(theta)
    work -= NORMAL * (opening - begun[0])  # of the force, which presses

    def elastic(a: float, opening: float, theta: float) -> float:
        """Return the resultants of a straight line of pressure over the length a at the right end."""
        one, other = -opening + (0.5 * WIDTH - a) * theta, -opening + 0.5 * WIDTH * theta
        return STIFFNESS * DEPTH * a * (one * one + one * other + other * other) / 6.0

    stored = elastic(lengths[-1], opening, theta) - elastic(WIDTH, *begun)
    lost = strength**2 / (2.0 * STIFFNESS) * DEPTH * (WIDTH - lengths[-1])
    assert work - stored == pytest.approx(lost, rel=1e-10)  # measured 4e-15
