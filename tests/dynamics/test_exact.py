"""The exact formulation against Lagrange's equations and against Newton's laws, state by state."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.articulated import articulated
from support.lagrange import Array, Reference, below
from support.probe import (
    coordinates,
    field,
    look,
    observed_accelerations,
    random_column,
    random_state,
    reaction,
)

from solver import Column
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper

examples = settings(deadline=None, max_examples=50, derandomize=True)
seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 5)
amplitudes = st.sampled_from([1e-4, 1e-2, 0.5])  # rad, of a joint; five of them turn the top block upside down


def scene(seed: int, n: int, largest: float, damped: bool = True) -> tuple[Column, Array, Array, float, float]:
    """Return a random column, a random state and a random base acceleration."""
    rng = np.random.default_rng(seed)
    column = random_column(rng, n, damped=damped)
    q, rate = random_state(rng, column, largest)
    ax, az = rng.uniform(-1.0, 1.0, 2) * column.g
    return column, q, rate, ax, az


@given(seed=seeds, n=sizes, largest=amplitudes)
@examples
def test_accelerations_are_those_of_lagranges_equations(seed: int, n: int, largest: float) -> None:
    column, q, rate, ax, az = scene(seed, n, largest)
    found, _ = look(column, q, rate, ax, az)
    expected = Reference.of(column).accelerations(q, rate, ax, az)
    assert found == pytest.approx(expected, abs=5e-12 * np.max(np.abs(expected)))  # measured 4e-13


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("largest", [1e-4, 1e-2, 0.5])
@pytest.mark.parametrize("n", [1, 3, 10, 50])
def test_accelerations_and_forces_are_those_of_the_articulated_body(n: int, largest: float) -> None:
    """Compare with another elimination of the same equations, also on a rotating base; stacks of 50 blocks too."""
    for seed in range(20):
        column, q, rate, ax, az = scene(seed, n, largest)
        turned = np.random.default_rng(seed).uniform(-1.0, 1.0, 3) * [1.0, 2.0, 10.0]
        base = (ax, az, float(turned[0]), float(turned[1]), float(turned[2]))
        stepper = Stepper(column)
        coordinates(stepper)[:] = np.concatenate([q, rate])
        stepper.state.control.base_theta, stepper.state.control.base_omega = base[2:4]
        stepper.drive(0.0, ax=ax, az=az, theta=base[2], omega=base[3], alpha=base[4])
        row = stepper.observe(0.0)
        expected, forces, mu = articulated(column, q, rate, base)
        found = observed_accelerations(stepper)
        scale = np.max(np.abs(forces)) + np.max(field(row, "N", n))
        assert found == pytest.approx(expected, abs=4e-13 * np.max(np.abs(expected)))  # measured 4e-14, mostly 4e-15
        assert field(row, "T", n) == pytest.approx(-forces, abs=5e-14 * scale)  # measured 6e-15
        split = at.SPLIT.see(stepper.split)
        assert split.mxx + split.mzz == pytest.approx(mu, rel=2e-12)  # measured 2e-13, 50 blocks


@given(seed=seeds, n=sizes, largest=amplitudes)
@examples
def test_output_row_shows_the_geometry_and_the_joint_forces(seed: int, n: int, largest: float) -> None:
    column, q, rate, ax, az = scene(seed, n, largest)
    _, row = look(column, q, rate, ax, az)
    reference = Reference.of(column)
    assert np.array_equal(field(row, "theta", n), q[:n])
    size = np.sum(reference.height)
    assert field(row, "ux", n) == pytest.approx(reference.tops(q)[0], abs=1e-14 * size)  # measured 1e-16
    rise = reference.centroids(q)[1] - reference.centroids(np.zeros(2 * n))[1]
    assert field(row, "uz", n) == pytest.approx(rise, abs=1e-14 * size)  # measured 5e-16
    normal, moment = reference.resultants(q, rate)
    rounding = 1e-13 * max(np.max(normal), reference.g * np.sum(reference.mass))
    assert field(row, "N", n) == pytest.approx(normal, abs=rounding)  # measured 1e-14
    assert field(row, "M", n) == pytest.approx(moment, abs=rounding * np.max(reference.width))


@given(seed=seeds, n=sizes, largest=amplitudes)
@examples
def test_resultants_balance_the_motion_of_the_blocks_above_each_joint(seed: int, n: int, largest: float) -> None:
    column, q, rate, ax, az = scene(seed, n, largest)
    acceleration, row = look(column, q, rate, ax, az)
    reference = Reference.of(column)
    along, upwards = reference.centroid_accelerations(q, rate, acceleration)
    push = reference.mass * (along + ax)  # forces that the blocks need, gravity being an upward acceleration
    lift = reference.mass * (upwards + az + reference.g)
    scale = np.sum(np.abs(push) + np.abs(lift)) + np.max(field(row, "N", n))
    shear = field(row, "S", n)
    assert shear == pytest.approx(-np.cumsum(push), abs=1e-12 * scale)  # measured 7e-14

    # along the joint's mean tangent and normal, and about the middle of the joint
    phi = 0.5 * (q[:n] + below(q[:n]))
    tangential = np.cos(phi) * np.cumsum(push) - np.sin(phi) * np.cumsum(lift)
    assert field(row, "T", n) == pytest.approx(-tangential, abs=5e-12 * scale)
    along_x = field(row, "T", n) * np.cos(phi) - field(row, "N", n) * np.sin(phi)
    assert shear == pytest.approx(along_x, abs=1e-15 * scale)
    normal = np.sin(phi) * np.cumsum(push) + np.cos(phi) * np.cumsum(lift)
    assert field(row, "N", n) == pytest.approx(normal, abs=5e-12 * scale)  # measured 3e-13
    x, z = reference.centroids(q)
    for i, (x0, z0) in enumerate(np.array(reference.joint_middles(q)).T):
        part = slice(i + 1)
        turning = np.sum((z - z0)[part] * push[part] - (x - x0)[part] * lift[part])
        turning += np.sum((reference.inertia * acceleration[:n])[part])
        couple = field(row, "M", n)[i] * np.cos(0.5 * (q[:n] - below(q[:n]))[i])
        size = scale * np.sum(reference.height)
        assert -couple == pytest.approx(turning, abs=1e-12 * size)  # measured 4e-14

    # the base feels the whole reaction, at the centre of its own face
    assert reaction(row, "Fx") == pytest.approx(-np.sum(push), abs=1e-12 * scale)  # measured 7e-14
    assert reaction(row, "Fz") == pytest.approx(-np.sum(lift), abs=5e-12 * scale)  # measured 3e-13
    turning = np.sum(z * push - x * lift + reference.inertia * acceleration[:n])
    assert reaction(row, "My") == pytest.approx(-turning, abs=1e-12 * scale * np.sum(reference.height))


@given(seed=seeds, n=sizes, largest=amplitudes)
@examples
def test_mirrored_state_gives_the_mirrored_row_to_the_last_bit(seed: int, n: int, largest: float) -> None:
    column, q, rate, ax, az = scene(seed, n, largest)
    mirror = np.concatenate([-np.ones(n), np.ones(n)])
    acceleration, row = look(column, q, rate, ax, az)
    mirrored_acceleration, mirrored_row = look(column, mirror * q, mirror * rate, -ax, az)
    assert np.array_equal(mirrored_acceleration, mirror * acceleration)
    sign = np.ones(row.size)
    for name in ("ux", "theta", "M", "S", "T"):
        field(sign, name, n)[:] = -1.0
    felt = at.ROW.see(sign, n).base
    felt.Fx = felt.My = -1.0
    assert np.array_equal(mirrored_row, sign * row)
