"""Loads on ports of columns in their plane, state by state and as motions: virtual work, closed forms, energy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.columns import off_axis_column, sliding_column
from support.lagrange import Array, Reference
from support.loads import accelerations, generalized, motion_of
from support.probe import coordinates, field, observed_accelerations, random_column, random_state, sliding_state
from support.sliding import SlidingReference

from solver import Column
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper
from solver.models.ports import Port

examples = settings(deadline=None, max_examples=30, derandomize=True)
seeds = st.integers(0, 2**32 - 1)


def with_ports(rng: np.random.Generator, column: Column) -> tuple[Column, Array]:
    """Return the column with three ports anywhere, and loads on them (3, 3) of up to the weight."""
    weight = column.g * sum(block.mass for block in column.blocks)
    at_points = rng.uniform(-2.0, 2.0, (3, 2)).tolist()
    ports = tuple(Port(f"p{k}", int(rng.integers(column.n)), tuple(point)) for k, point in enumerate(at_points))
    return replace(column, ports=ports), weight * rng.uniform(-1.0, 1.0, (3, 3))


def spots(row: Array, n: int) -> Array:
    """Return what is seen of each port, (ports, 6)."""
    return row[at.ROW.size(n) :].reshape(6, -1).T


@given(seed=seeds, n=st.integers(1, 5), largest=st.sampled_from([1e-4, 1e-2, 0.5]))
@examples
def test_accelerations_are_those_of_lagranges_equations_with_virtual_work(seed: int, n: int, largest: float) -> None:
    rng = np.random.default_rng(seed)
    column, loads = with_ports(rng, random_column(rng, n))
    q, rate = random_state(rng, column, largest)
    ax, az = rng.uniform(-1.0, 1.0, 2) * column.g
    stepper = Stepper(column)
    coordinates(stepper)[:] = np.concatenate([q, rate])
    slopes = rng.uniform(-1.0, 1.0, 9) * np.max(np.abs(loads))
    early = loads.T.ravel() - 0.3 * slopes  # set 0.3 s before
    stepper.drive(0.7, ax, az, 0.0, 0.0, 0.0, 0.0, 0.0, *early, *slopes, since=0.4)
    row = stepper.observe(0.7).copy()
    expected = accelerations(column, q, rate, ax, az, loads)
    found = observed_accelerations(stepper)
    assert found == pytest.approx(expected, abs=1e-11 * np.max(np.abs(expected)))
    scale = np.array([10.0, 10.0, 10.0, 10.0, 100.0, 100.0]) * (1.0 + np.max(np.abs(rate)) + np.max(np.abs(expected)))
    for number, seen in enumerate(spots(row, n)):
        assert np.all(np.abs(seen - motion_of(column, q, rate, found, number)) < 1e-12 * scale)


@given(seed=seeds, n=st.integers(1, 4))
@examples
def test_the_axes_of_loads_do_not_turn_with_the_base(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    column, loads = with_ports(rng, random_column(rng, n))
    q, rate = random_state(rng, column, 0.1)
    ax, az = rng.uniform(-1.0, 1.0, 2) * column.g
    turn, spin, alpha = rng.uniform(-1.0, 1.0, 3)
    stepper = Stepper(column)
    coordinates(stepper)[:] = np.concatenate([q, rate])
    stepper.state.control.base_theta, stepper.state.control.base_omega = turn, spin
    stepper.drive(0.0, ax, az, 0.0, 0.0, turn, spin, alpha, *loads.T.ravel(), *np.zeros(9))
    stepper.observe(0.0)
    base = Reference.of(column).on_rotating_base()
    whole = np.concatenate([q[:n] + turn, [turn], q[n:], [0.0]])
    speed = np.concatenate([rate[:n] + spin, [spin], rate[n:], [0.0]])
    work = generalized(column, q, loads, turn)
    pushed = np.concatenate([work[:n], [0.0], work[n:], [0.0]])
    matrix, free = base.mass_matrix(whole), np.delete(np.arange(2 * n + 2), [n, 2 * n + 1])
    given_alpha = np.zeros(2 * n + 2)
    given_alpha[n] = alpha
    rest = base.forces(whole, speed, ax, az) + pushed - matrix @ given_alpha
    expected = np.linalg.solve(matrix[np.ix_(free, free)], rest[free])
    expected[:n] -= alpha
    assert observed_accelerations(stepper) == pytest.approx(expected, abs=1e-11 * np.max(np.abs(expected)))


class Pushed(SlidingReference):
    """The reference for columns that slide or lean, with loads."""

    column: Column
    loads: Array

    def inertial(self, q: Array, rate: Array, ax: float, az: float) -> Array:
        return super().inertial(q, rate, ax, az) + generalized(self.column, q, self.loads)


@given(seed=seeds, n=st.integers(1, 5), largest=st.sampled_from([1e-4, 1e-2, 0.5]))
@examples
@pytest.mark.parametrize("make", [sliding_column, off_axis_column])
def test_loads_on_columns_that_slide_or_lean(
    make: Callable[[np.random.Generator, int], Column], seed: int, n: int, largest: float
) -> None:
    rng = np.random.default_rng(seed)
    column, loads = with_ports(rng, make(rng, n))
    q, rate, direction = sliding_state(rng, column, largest)
    ax, az = rng.uniform(-0.3, 0.3, 2) * column.g
    stepper = Stepper(column)
    phase = stepper.state.phase
    phase.theta[:], phase.opening[:], phase.slip[:] = np.split(q, 3)
    phase.theta_rate[:], phase.opening_rate[:], phase.slip_rate[:] = np.split(rate, 3)
    phase.sliding[:] = direction
    stepper.drive(0.0, ax, az, 0.0, 0.0, 0.0, 0.0, 0.0, *loads.T.ravel(), *np.zeros(9))
    row = stepper.observe(0.0).copy()
    between = at.WORK.see(stepper.arrays.work, n).between
    reference = Pushed.of(column)
    object.__setattr__(reference, "column", column)
    object.__setattr__(reference, "loads", loads)
    expected, tangential, _, _ = reference.solve(q, rate, between.sliding.copy(), ax, az)
    found = np.concatenate([between.theta_acceleration, between.opening_acceleration, between.slip_acceleration])
    assert found == pytest.approx(expected, abs=1e-11 * np.max(np.abs(expected)))
    force = np.max(np.abs(tangential)) + np.max(field(row, "N", n)) + reference.g * np.sum(reference.mass)
    assert -field(row, "T", n) == pytest.approx(tangential, abs=1e-11 * force)
    scale = np.array([10.0, 10.0, 10.0, 10.0, 100.0, 100.0]) * (1.0 + np.max(np.abs(rate)) + np.max(np.abs(expected)))
    for number, seen in enumerate(spots(row, n)):
        assert np.all(np.abs(seen - motion_of(column, q, rate, found, number)) < 1e-12 * scale)
