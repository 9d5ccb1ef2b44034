"""Eight columns at once: lanes hold what each column has on its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.joint_states import State, states
from support.joints import joint_forces
from support.lanes import accelerate, accelerate_eight, in_lanes
from support.probe import Array, random_column, random_state

from solver.column.packing import pack_model
from solver.kernels.joint.law import joint_forces_in_lanes
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.lanes import (
    WIDTH,
    any_of,
    bits,
    greater,
    lane,
    lesser,
    magnitude,
    nearest,
    square_root,
    where,
)
from solver.kernels.numba_ext.numbers import half_sine_cosine, sine, sine_cosine
from solver.kernels.numba_ext.views import lanes_of, row_of

examples = settings(deadline=None, max_examples=200, derandomize=True)


# --- the joint


@from_python
def law_in_lanes(given: Array, found: Array) -> None:
    """`joint_forces_in_lanes` of eight joints, (8 arguments, 8 lanes), to (3, 8); both flat."""
    g, f = lanes_of(given), lanes_of(found)
    half = 0.5 * g[1]
    f[0], f[1], f[2] = joint_forces_in_lanes(-half, half, g[0] * g[2], g[3], g[4], g[5], g[6], g[7])


def assert_lanes_say_what_branches_say(eight: list[State]) -> None:
    given = np.array([astuple(state) for state in eight])
    found = np.zeros((3, WIDTH))
    law_in_lanes(np.ascontiguousarray(given.T).reshape(-1), found.reshape(-1))
    expected = np.array([joint_forces(*arguments) for arguments in given.tolist()]).T
    assert np.array_equal(found, expected)


@given(eight=st.lists(states(), min_size=WIDTH, max_size=WIDTH))
@examples
def test_law_in_lanes_is_the_law_to_the_last_bit(eight: list[State]) -> None:
    assert_lanes_say_what_branches_say(eight)


def test_law_in_lanes_is_the_law_on_the_boundaries_of_its_regimes() -> None:
    """Parallel faces, faces that touch, edges at a corner, dampers that just pull, none at all."""
    width, values = 1.5, (-0.75e-3, 0.0, 0.75e-3)
    eight = [
        State(5e9, width, 1.2, damping, opening, slope, opening_rate, slope_rate)
        for damping in (0.0, 1e-2)
        for opening in values
        for slope in (-1e-3, 0.0, 1e-3)
        for opening_rate in (-0.075, 0.0, 0.075)
        for slope_rate in (-0.1, 0.0, 0.1)
    ]
    eight += eight[: -len(eight) % WIDTH]
    for k in range(0, len(eight), WIDTH):
        assert_lanes_say_what_branches_say(eight[k : k + WIDTH])


# --- accelerations


def eight_columns(n: int, largest: float) -> tuple[Array, Array, Array]:
    """(models, phases, motions of the base) of eight columns that move, (8, length) each."""
    models, phases, motions = [], [], []
    for seed in range(WIDTH):
        rng = np.random.default_rng([seed, n])
        column = random_column(rng, n, damped=seed % 2 == 0)
        q, rate = random_state(rng, column, largest)
        models.append(pack_model(column)[: at.MODEL.size(n)])
        phases.append(np.concatenate([q, rate, np.zeros(2 * n)]))
        motions.append(rng.uniform(-1.0, 1.0, 5) * [column.g, column.g, 1.0, 2.0, 10.0])
    return np.array(models), np.array(phases), np.array(motions)


def found_in_lanes(models: Array, phases: Array, motions: Array, n: int) -> tuple[Array, Array]:
    """(phases, joints), (8, length) each, with the accelerations and resultants that lanes give."""
    interleaved, work = in_lanes(phases), np.zeros(WIDTH * at.WORK.size(n))
    accelerate_eight(n, in_lanes(models), interleaved, work, in_lanes(motions))
    rows = work.reshape(-1, WIDTH).T
    begin = sum(at.WORK.parts[name].size(n) for name in list(at.WORK.parts)[: list(at.WORK.parts).index("joints")])
    return interleaved.reshape(-1, WIDTH).T, rows[:, begin : begin + at.JOINTS.size(n)]


@pytest.mark.parametrize("largest", [1e-4, 1e-2, 0.5])
@pytest.mark.parametrize("n", [1, 3, 10, 50])
def test_accelerations_in_lanes_are_those_of_each_column(n: int, largest: float) -> None:
    models, phases, motions = eight_columns(n, largest)
    found, joints = found_in_lanes(models, phases, motions, n)
    for k in range(WIDTH):
        phase, work = phases[k].copy(), np.zeros(at.WORK.size(n))
        accelerate(n, models[k].copy(), phase, work, motions[k].copy())
        expected = phase[4 * n :]
        # measured 2.3e-16, of the sine and cosine of the base's rotation
        assert found[k, 4 * n :] == pytest.approx(expected, abs=1e-15 * np.max(np.abs(expected)))
        resultants = at.WORK.see(work, n).joints
        for name, part in vars(at.JOINTS.see(joints[k], n)).items():
            wanted = getattr(resultants, name)
            assert part == pytest.approx(wanted, abs=1e-15 * np.max(np.abs(wanted))), name


def test_a_lane_has_the_same_bits_whatever_is_in_the_others() -> None:
    n = 3
    models, phases, motions = eight_columns(n, 0.5)
    turned = np.roll(np.arange(WIDTH), 3)
    found, joints = found_in_lanes(models, phases, motions, n)
    other, other_joints = found_in_lanes(models[turned], phases[turned], motions[turned], n)
    assert np.array_equal(other, found[turned])
    assert np.array_equal(other_joints, joints[turned])
    models, phases, motions = (np.tile(rows[0], (WIDTH, 1)) for rows in (models, phases, motions))
    alone, alone_joints = found_in_lanes(models, phases, motions, n)
    assert np.array_equal(alone, np.tile(found[0], (WIDTH, 1)))
    assert np.array_equal(alone_joints, np.tile(joints[0], (WIDTH, 1)))


# --- functions


@from_python
def sines_in_lanes(count: int, x: Array, sines: Array, cosines: Array, only: Array) -> None:
    """`sine_cosine` and `sine` of `count` lanes."""
    xs, s, c, o = lanes_of(x), lanes_of(sines), lanes_of(cosines), lanes_of(only)
    for k in range(count):
        s[k], c[k] = sine_cosine(xs[k])
        o[k] = sine(xs[k])


def units(found: Array, function: Callable[[float], float], x: Array) -> float:
    """Largest difference from a function of math, in units in the last place of that."""
    expected = np.array([function(value) for value in x])
    return float(np.max(np.abs(found - expected) / np.spacing(np.abs(expected))))


@pytest.mark.parametrize("largest", [0.03, 0.8, 100.0])
def test_sine_and_cosine_in_lanes_are_those_of_math(largest: float) -> None:
    x = np.random.default_rng(1).uniform(-largest, largest, 80000)
    sines, cosines, only = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, x, sines, cosines, only)
    assert units(sines, math.sin, x) <= 1.0  # measured 1
    assert units(cosines, math.cos, x) <= 1.0  # measured 1
    assert np.array_equal(only, sines)
    mirrored, even = np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, -x, mirrored, even, only)
    assert np.array_equal(mirrored, -sines)
    assert np.array_equal(even, cosines)


def test_sine_and_cosine_in_lanes_about_the_multiples_of_a_quarter_turn() -> None:
    """Where the reduction loses most: the sine or the cosine is next to nothing."""
    x = np.repeat(np.arange(-64.0, 64.0), 8) * 0.5 * math.pi
    x += np.tile([0.0, 1e-15, 1e-9, 1e-3, -1e-9, -1e-3, 0.785, -0.785], 128)
    sines, cosines, only = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, x, sines, cosines, only)
    assert sines == pytest.approx(np.sin(x), abs=2e-16)  # measured 1.1e-16
    assert cosines == pytest.approx(np.cos(x), abs=2e-16)


@from_python
def halves(count: int, x: Array, found: Array) -> None:
    """Sine and cosine of half of each of `count` times eight numbers, in lanes and one by one, each in two ways."""
    xs, f, numbers, one_by_one = lanes_of(x), lanes_of(found), row_of(x), row_of(found)
    for k in range(count):
        f[k], f[count + k] = half_sine_cosine(xs[k])
        f[2 * count + k], f[3 * count + k] = sine_cosine(0.5 * xs[k])
    size = 8 * count
    for k in range(size):
        one_by_one[4 * size + k], one_by_one[5 * size + k] = half_sine_cosine(numbers[k])
        one_by_one[6 * size + k], one_by_one[7 * size + k] = sine_cosine(0.5 * numbers[k])


@pytest.mark.parametrize("largest", [0.1, 10.0])
def test_sine_and_cosine_of_a_half_are_those_to_the_last_bit(largest: float) -> None:
    x = np.linspace(-largest, largest, 1024)
    found = np.zeros((8, x.size))
    halves(x.size // WIDTH, x, found.reshape(-1))
    assert np.array_equal(found[[0, 1, 4, 5]], found[[2, 3, 6, 7]])


@from_python
def functions_in_lanes(x: Array, y: Array, found: Array) -> int:
    """What lanes.py offers, of eight numbers each."""
    a, b, f = lanes_of(x)[0], lanes_of(y)[0], lanes_of(found)
    f[0], f[1], f[2], f[3], f[4] = magnitude(a), square_root(magnitude(a)), lesser(a, b), greater(a, b), nearest(a)
    f[5] = where((a > b) & ~(b == 0.0) | (a <= -1.0), a, 2)
    for k in range(8):
        f[6] = f[6] + lane(a, k) if any_of(a > b) else f[6]
    return bits(a < b)


def test_functions_of_lanes_are_those_of_numpy() -> None:
    x = np.array([-2.5, -1.0, -0.0, 0.4, 1.5, 2.5, 3.5, 1e9])
    y = np.array([1.0, -1.0, 0.0, 0.3, 7.0, 0.0, -3.5, 2e9])
    found = np.zeros((7, WIDTH))
    said = functions_in_lanes(x, y, found.reshape(-1))
    assert said == sum(1 << k for k in range(WIDTH) if x[k] < y[k])
    expected = [np.abs(x), np.sqrt(np.abs(x)), np.minimum(x, y), np.maximum(x, y), np.rint(x)]
    expected += [np.where(((x > y) & (y != 0.0)) | (x <= -1.0), x, 2.0), np.full(WIDTH, np.cumsum(x)[-1])]
    assert np.array_equal(found, np.array(expected))
