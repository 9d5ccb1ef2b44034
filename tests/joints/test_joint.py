"""The joint law of rectangles against quadrature of the pressure and theory.md section 2.

test_sections.py has its energy and mirror images, of all sections.
"""

from __future__ import annotations

import math
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given
from support.joint_states import State, examples, states
from support.joints import joint_forces, joint_peak_pressure
from support.lagrange import pressure_resultants
from support.probe import PHOCAS_STIFFNESS, G


def elastic(state: State, opening: float, slope: float) -> tuple[float, float, float]:
    return joint_forces(state.stiffness, state.width, state.depth, 0.0, opening, slope, 0.0, 0.0)


@given(state=states())
@examples
def test_forces_are_the_integral_of_the_pressure(state: State) -> None:
    force, moment, _ = joint_forces(*astuple(state))
    expected_force, expected_moment = pressure_resultants(
        state.stiffness, state.width, state.depth, state.damping,
        state.opening, state.slope, state.opening_rate, state.slope_rate,
    )  # fmt: skip
    assert force == pytest.approx(expected_force, abs=1e-14 * state.force)  # measured 4e-16
    assert moment == pytest.approx(expected_moment, abs=1e-14 * state.force * state.width)  # measured 1e-16


def sampled_pressure(state: State, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the pressure in the middle of `count` strips, written as theory.md section 2 does."""
    s = (np.arange(count) + 0.5) / count * state.width - 0.5 * state.width
    pen = -(state.opening - s * state.slope)
    rate = -(state.opening_rate - s * state.slope_rate)
    pressure = np.maximum(0.0, state.stiffness * pen + state.damping * state.stiffness * rate)
    return s, np.where(pen > 0.0, pressure, 0.0)


@given(state=states())
@examples
def test_resultants_and_peak_are_those_of_the_sampled_pressure(state: State) -> None:
    count = 20000
    s, pressure = sampled_pressure(state, count)
    force, moment, length = joint_forces(*astuple(state))
    strip = state.width * state.depth / count
    # at the edge of contact the damped pressure may jump: half a strip is undecided
    slack = state.force / count
    assert force == pytest.approx(np.sum(pressure) * strip, abs=slack)  # measured 0.45 of it
    assert moment == pytest.approx(np.sum(pressure * s) * strip, abs=0.5 * slack * state.width)  # measured 0.3 of it
    peak = joint_peak_pressure(
        state.stiffness, state.width, state.damping,
        state.opening, state.slope, state.opening_rate, state.slope_rate,
    )  # fmt: skip
    highest = float(np.max(pressure))
    unit = state.force / (state.width * state.depth)
    assert peak >= highest - 1e-14 * unit
    if length > 2.0 * state.width / count:  # no sample may lie in a narrower contact
        assert peak <= highest + 2.0 * unit / count
    if highest > 1e-6 * unit:  # neither is the edge of no pressure to be seen
        loaded = np.count_nonzero(pressure) / count * state.width
        assert length == pytest.approx(loaded, abs=2.0 * state.width / count)  # measured 0.3 of it


@given(state=states())
@examples
def test_joint_never_pulls_and_the_resultant_stays_inside_it(state: State) -> None:
    force, moment, length = joint_forces(*astuple(state))
    assert force >= 0.0
    assert abs(moment) <= 0.5 * state.width * (force + 1e-14 * state.force)
    assert 0.0 <= length <= state.width
    assert (length > 0.0) >= (force > 0.0)
    _, _, touching = elastic(state, state.opening, state.slope)
    assert length <= touching  # pressure only where the faces touch


@given(state=states(damped=False))
@examples
def test_elastic_forces_are_the_closed_form_of_theory_section_2(state: State) -> None:
    k, b, t, dw, dth = state.stiffness, state.width, state.depth, state.opening, state.slope
    a, c = abs(dth), 0.5 * b
    p1, p2 = c * a - dw, -c * a - dw
    if p2 >= 0.0:
        expected = (-k * b * t * dw, k * t * b**3 / 12.0 * dth, b)
    elif p1 <= 0.0:
        expected = (0.0, 0.0, 0.0)
    else:
        length = p1 / a
        force = k * t * p1 * length / 2.0
        expected = (force, force * (c - length / 3.0) * math.copysign(1.0, dth), length)
    force, moment, length = elastic(state, dw, dth)
    assert force == pytest.approx(expected[0], abs=1e-14 * state.force)  # measured 4e-16
    assert moment == pytest.approx(expected[1], abs=1e-14 * state.force * b)  # measured 1e-16
    assert length == pytest.approx(expected[2], abs=1e-14 * b)  # measured 2e-16


BED = State(5e9, 1.5, 1.2, 0.0, 0.0, 2e-4, 0.0, 0.0)
FULL_TO_PARTIAL = -0.5 * BED.width * BED.slope
PARTIAL_TO_OPEN = 0.5 * BED.width * BED.slope


@pytest.mark.parametrize("boundary", [FULL_TO_PARTIAL, PARTIAL_TO_OPEN])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_law_is_smooth_but_for_the_second_derivative_across_regimes(boundary: float, sign: float) -> None:
    def resultants(opening: float) -> np.ndarray:
        return np.array(elastic(BED, opening, sign * BED.slope)[:2])

    lifted = 0.5 * BED.width * BED.slope
    scale = np.array([BED.force, BED.force * BED.width])
    near = 1e-9 * lifted
    assert np.all(np.abs(resultants(boundary + near) - resultants(boundary - near)) < 3e-9 * scale)  # measured 2e-9

    step = 1e-3 * lifted

    def tangent(opening: float) -> np.ndarray:
        return (resultants(opening + step) - resultants(opening - step)) / (2.0 * step)

    def curvature(opening: float) -> np.ndarray:
        return (resultants(opening + step) - 2.0 * resultants(opening) + resultants(opening - step)) / step**2

    # one side's tangent, less the other's, is nothing but curvature times distance
    left, right = boundary - step, boundary + step
    assert np.all(np.abs(tangent(right) - tangent(left)) < 1e-3 * scale / lifted)  # measured 5e-4
    # theory.md section 2: N'' is k t / a in partial contact, none in full contact and none open
    jump = BED.stiffness * BED.depth / BED.slope * (1.0 if boundary == FULL_TO_PARTIAL else -1.0)
    found = curvature(right) - curvature(left)
    assert found[0] == pytest.approx(jump, rel=1e-8)  # measured 7e-11
    assert found[1] == pytest.approx(-sign * abs(jump) * 0.5 * BED.width, rel=2e-3)  # measured 1e-3, the step


PHOCAS_WEIGHT = 81000.0 * G
PHOCAS_WIDTH = 1.56


def base_joint(turn: float) -> tuple[float, float, float]:
    """Return the Phocas base joint under the whole weight, partly open (theory.md section 5)."""
    deepest = math.sqrt(2.0 * PHOCAS_WEIGHT * turn / (PHOCAS_STIFFNESS * PHOCAS_WIDTH))
    opening = 0.5 * PHOCAS_WIDTH * turn - deepest
    return joint_forces(PHOCAS_STIFFNESS, PHOCAS_WIDTH, PHOCAS_WIDTH, 0.0, opening, turn, 0.0, 0.0)


def test_base_joint_opens_at_the_rotation_and_moment_of_theory_section_5() -> None:
    turn = 2.0 * PHOCAS_WEIGHT / (PHOCAS_STIFFNESS * PHOCAS_WIDTH**3)
    assert turn == pytest.approx(8.00597e-5, rel=1e-6)
    force, moment, length = base_joint(turn * (1.0 + 1e-12))
    assert force == pytest.approx(PHOCAS_WEIGHT, rel=1e-11)
    assert moment == pytest.approx(206.53e3, rel=2e-5)  # printed to 5 digits
    assert length == pytest.approx(PHOCAS_WIDTH, rel=1e-11)
    assert base_joint(turn * 1.001)[2] < PHOCAS_WIDTH * 0.9996


@pytest.mark.parametrize(("times", "ratio"), [(2.0, 1.58579), (10.0, 2.36754)])
def test_moment_after_opening_is_that_of_theory_section_5(times: float, ratio: float) -> None:
    turn = 2.0 * PHOCAS_WEIGHT / (PHOCAS_STIFFNESS * PHOCAS_WIDTH**3)
    force, moment, _ = base_joint(times * turn)
    assert force == pytest.approx(PHOCAS_WEIGHT, rel=1e-12)
    assert moment / (PHOCAS_WEIGHT * PHOCAS_WIDTH / 6.0) == pytest.approx(ratio, abs=5e-6)
