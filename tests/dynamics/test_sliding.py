"""Joints that slide and blocks off their axis, state by state, against Lagrange's equations."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.columns import off_axis_column, sliding_column
from support.lagrange import Array
from support.probe import field, reaction, sliding_state
from support.sliding import SlidingReference

from solver import Block, Column, InitialState, Joint, Motion, simulate
from solver.kernels.column.formulations.exact import JOINT_ROW
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper

examples = settings(deadline=None, max_examples=50, derandomize=True)
seeds = st.integers(0, 2**32 - 1)


def put(stepper: Stepper, q: Array, rate: Array, direction: Array) -> None:
    n, phase = stepper.n, stepper.state.phase
    phase.theta[:], phase.opening[:], phase.slip[:] = np.split(q, 3)
    phase.theta_rate[:], phase.opening_rate[:], phase.slip_rate[:] = np.split(rate, 3)
    phase.sliding[:] = direction
    assert n == len(direction)


@given(seed=seeds, n=st.integers(1, 5), largest=st.sampled_from([1e-4, 1e-2, 0.5]))
@examples
@pytest.mark.parametrize("make", [sliding_column, off_axis_column])
def test_accelerations_and_forces_are_those_of_lagranges_equations(
    make: Callable[[np.random.Generator, int], Column], seed: int, n: int, largest: float
) -> None:
    rng = np.random.default_rng(seed)
    column = make(rng, n)
    q, rate, direction = sliding_state(rng, column, largest)
    ax, az = rng.uniform(-0.3, 0.3, 2) * column.g
    stepper = Stepper(column)
    put(stepper, q, rate, direction)
    stepper.drive(0.0, ax=ax, az=az)
    row = stepper.observe(0.0)
    between = at.WORK.see(stepper.arrays.work, n).between
    decided = between.sliding.copy()  # sticking joints may have been let go
    moving = direction != 0.0
    assert np.array_equal(decided[moving], direction[moving])
    reference = SlidingReference.of(column)
    expected, tangential, drift, bears = reference.solve(q, rate, decided, ax, az)
    found = np.concatenate([between.theta_acceleration, between.opening_acceleration, between.slip_acceleration])
    scale = np.max(np.abs(expected))
    assert found == pytest.approx(expected, abs=1e-11 * scale)
    force = np.max(np.abs(tangential)) + np.max(field(row, "N", n)) + reference.g * np.sum(reference.mass)
    assert -field(row, "T", n) == pytest.approx(tangential, abs=1e-11 * force)
    # a sticking joint carries its force, one let go slides the way that it is pushed
    sticks = decided == 0.0
    assert np.all(np.abs(tangential - drift)[sticks] <= bears[sticks] + 1e-9 * force)
    let_go = ~moving & ~sticks
    assert np.all((decided * expected[2 * n :])[let_go] >= -1e-9 * scale)
    assert field(row, "slip", n) == pytest.approx(q[2 * n :] - reference.offset, abs=0.0)
    size = np.sum(reference.height)
    assert field(row, "ux", n) == pytest.approx(
        reference.tops(q)[0] - reference.tops(reference.built)[0], abs=1e-14 * size
    )
    rise = reference.centroids(q)[1] - reference.centroids(reference.built)[1]
    assert field(row, "uz", n) == pytest.approx(rise, abs=1e-14 * size)
    # the reaction is the force of the base on the blocks
    x, z = reference.jacobians(q)
    dx, dz = (part.imag @ rate / 1e-30 for part in reference.jacobians(q + 1e-30j * rate))
    push = reference.mass * (x @ expected + dx + ax)
    lift = reference.mass * (z @ expected + dz + az + reference.g)
    assert reaction(row, "Fx") == pytest.approx(-np.sum(push), abs=1e-11 * force)
    assert reaction(row, "Fz") == pytest.approx(-np.sum(lift), abs=1e-11 * force)
    place_x, place_z = reference.centroids(q)
    moment = np.sum(push * place_z - lift * place_x + reference.inertia * expected[:n])
    assert reaction(row, "My") == pytest.approx(-moment, abs=1e-11 * force * size)


@given(seed=seeds, n=st.integers(1, 5))
@examples
def test_the_split_of_the_reaction_holds_where_joints_slide(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    column = sliding_column(rng, n)
    q, rate, direction = sliding_state(rng, column, 1e-2)
    direction = np.where(direction == 0.0, 1.0, direction)  # none that sticks, since its state would change
    rate[2 * n :] = direction * np.abs(rate[2 * n :] + 0.1)
    if rng.random() < 0.5:
        rate[-1] = direction[-1] = 0.0
    stepper = Stepper(column)
    put(stepper, q, rate, direction)
    base = rng.uniform(-0.01, 0.01, 2) * column.g
    rows = []
    for ax, az in (base, base + np.array([1e-3, 0.0])):
        stepper.drive(0.0, ax=ax, az=az)
        row = stepper.observe(0.0).copy()
        rows.append((reaction(row, "Fx"), at.WORK.see(stepper.arrays.work, n).between.sliding[-1]))
        split = at.SPLIT.see(stepper.split.copy())
        assert reaction(row, "Fx") == pytest.approx(split.R0x - split.mxx * ax - split.mxz * az, rel=1e-11)
        assert (split.mxx == 0.0) == (rows[-1][1] != 0.0)


def test_the_row_of_a_joint_fits_into_the_scratch_of_an_evaluation() -> None:
    assert JOINT_ROW.beside <= at.ROOM.per_n


def test_the_block_that_slid_off_is_the_one_that_fell() -> None:
    """Slide the top block off while a lower joint has rotated more; the times in regimes add up to that of the fall."""
    joints = (Joint(1e9, 2e-3, friction=0.01), Joint(1e9, 2e-3), Joint(1e9, 2e-3))
    column = Column("slides", tuple(Block(1.0, 1.0, 1.0, 2500.0, joint) for joint in joints))
    initial = InitialState(slip=[0.99, 0.0, 0.0], slip_rate=[2.0, 0.0, 0.0], rotation_rate=[2.0, 2.0, 2.0])
    found = simulate(column, Motion.from_samples(0.5, np.zeros(3)), initial=initial, settle=0.0)
    assert 0.004 < found.overturn_time < 0.01  # s: until it has slid by 10 mm
    assert np.argmax(np.abs(np.diff(found.ry[-1], append=0.0))) == 2
    assert found.what_fell == "block 1 over joint 1"
    shares = sum(float(found.stats[name]) for name in ("full_contact", "rocking", "flight"))
    assert shares == pytest.approx(1.0, abs=1e-9)
