"""The paper's first-order formulation against its own equations: the paper's matrices, solved densely."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.lagrange import Array, Reference, below, from_base, pressure_resultants
from support.probe import G, field, look, phocas, random_column, random_state, reaction, settled, with_gravity

from solver import Column, InitialState, Motion, simulate
from solver.models.column.stepper import Stepper

examples = settings(deadline=None, max_examples=50, derandomize=True)
seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 5)


class Dense:
    """[M + dM(u)] u'' = f + df(u) of theory.md section 3, u = (v, w)."""

    def __init__(self, column: Column) -> None:
        self.data = data = Reference.of(column)
        n = self.n = column.n
        self.B = np.diag(data.centroid / data.height)
        self.B[range(n - 1), range(1, n)] = (1.0 - data.centroid / data.height)[:-1]
        self.C = np.eye(n) - np.eye(n, k=1)
        self.T = np.tril(np.ones((n, n)))
        # D_ij = h_j + H_(j+1) + ... + H_i
        top = from_base(data.height)
        self.D = np.tril(np.subtract.outer(-top + data.height, -top + data.height - data.centroid))
        self.mass = np.diag(data.mass)
        # eq. 14
        self.M = np.zeros((2 * n, 2 * n))
        self.M[:n, :n] = self.D @ self.mass @ self.B + self.T @ np.diag(data.inertia / data.height) @ self.C
        self.M[n:, n:] = self.T @ self.mass

    def matrices(self, u: Array, rate: Array, ax: float, az: float) -> tuple[Array, Array]:
        """Return (dM, f + df) of equations 12 and 23, signs as in theory.md.

        A vertical base acceleration adds to gravity.
        """
        n, data = self.n, self.data
        v, w = u[:n], u[n:]
        theta = (v - below(v)) / data.height
        opening = below(w) - w
        spin = (rate[:n] - below(rate[:n])) / data.height
        opening_rate = below(rate[n:]) - rate[n:]
        # dw_i / 2 + sum of dw_k for j <= k < i
        inside = np.array([[np.sum(opening[j:i]) for j in range(n)] for i in range(n)])
        Dw = np.tril(0.5 * opening[:, None] + inside)
        E = np.tril((self.B @ v)[None, :] - below(v)[:, None])
        S = np.diag(0.5 * (theta + below(theta)))
        joints = zip(
            data.stiffness, data.width, data.depth, data.damping, opening, theta - below(theta),
            opening_rate, spin - below(spin), strict=True,
        )  # fmt: skip
        normal, moment = np.array([pressure_resultants(*joint) for joint in joints]).T
        base = np.full(n, ax)
        weight = data.mass * (data.g + az)
        dM: Array = np.block(
            [
                [Dw @ self.mass @ self.B, E @ self.mass],
                [-S @ self.T @ self.mass @ self.B, np.zeros((n, n))],
            ]
        )
        moments = -(self.D + Dw) @ self.mass @ base + E @ weight - moment
        normals = S @ self.T @ self.mass @ base - normal + self.T @ weight
        return dM, np.concatenate([moments, normals])

    def accelerations(self, u: Array, rate: Array, ax: float, az: float) -> Array:
        dM, f = self.matrices(u, rate, ax, az)
        return np.asarray(np.linalg.solve(self.M + dM, f), dtype=np.float64)


def from_exact(column: Column, q: Array) -> Array:
    """Return (v, w) of the rotations and openings q, to first order."""
    height = np.array([block.height for block in column.blocks])
    return np.concatenate([from_base(height * q[: column.n]), -from_base(q[column.n :])])


def scene(seed: int, n: int) -> tuple[Column, Array, Array, float, float]:
    rng = np.random.default_rng(seed)
    column = random_column(rng, n, "paper", softest=1e8)  # softer ones settle beyond a first-order model
    q, rate = random_state(rng, column, 2e-2)
    ax, az = rng.uniform(-1.0, 1.0, 2) * column.g
    return column, from_exact(column, q), from_exact(column, rate), ax, az


@given(seed=seeds, n=sizes)
@examples
def test_accelerations_are_those_of_the_dense_equations(seed: int, n: int) -> None:
    column, u, rate, ax, az = scene(seed, n)
    found, _ = look(column, u, rate, ax, az)
    expected = Dense(column).accelerations(u, rate, ax, az)
    assert found == pytest.approx(expected, abs=2e-12 * np.max(np.abs(expected)))  # measured 1e-13


@given(seed=seeds, n=sizes)
@examples
def test_output_row_is_the_papers(seed: int, n: int) -> None:
    column, u, rate, ax, az = scene(seed, n)
    acceleration, row = look(column, u, rate, ax, az)
    dense = Dense(column)
    v, w = u[:n], u[n:]
    assert np.array_equal(field(row, "ux", n), v)
    assert np.array_equal(field(row, "uz", n), -w)
    assert field(row, "theta", n) == pytest.approx((v - below(v)) / dense.data.height, rel=1e-15)
    push = dense.data.mass * (ax + dense.B @ acceleration[:n])  # eq. 20
    lift = dense.data.mass * (dense.data.g + az - acceleration[n:])
    scale = np.sum(np.abs(push) + np.abs(lift))
    assert field(row, "S", n) == pytest.approx(-dense.T @ push, abs=1e-13 * scale)  # measured 8e-15
    assert reaction(row, "Fx") == pytest.approx(-np.sum(push), abs=1e-13 * scale)
    assert reaction(row, "Fz") == pytest.approx(-np.sum(lift), abs=1e-13 * scale)
    assert reaction(row, "My") == field(row, "M", n)[-1]


@given(seed=seeds, n=sizes)
@examples
def test_mirrored_state_gives_the_mirrored_accelerations_to_the_last_bit(seed: int, n: int) -> None:
    column, u, rate, ax, az = scene(seed, n)
    mirror = np.concatenate([-np.ones(n), np.ones(n)])
    acceleration, _ = look(column, u, rate, ax, az)
    mirrored, _ = look(column, mirror * u, mirror * rate, -ax, az)
    assert np.array_equal(mirrored, mirror * acceleration)


def test_central_differences_are_the_papers_recursion_in_the_displacements() -> None:
    amplitude, omega, dt, steps = 0.1 * G, 2.0 * np.pi * 4.0, 2e-4, 500
    column = phocas(formulation="paper", step=dt)
    dense = Dense(column)
    rest = from_exact(column, np.concatenate([np.zeros(3), -settled(column)]))
    push = from_exact(column, np.concatenate([np.full(3, 0.02), np.zeros(3)]))

    def matrices(u: Array, t: float) -> tuple[Array, Array]:
        return dense.matrices(u, np.zeros(6), amplitude * np.sin(omega * t), 0.0)

    # eqs. 25 to 28; the usual start u(-dt) = u(0) - dt u'(0) + dt^2/2 u''(0)
    dM, f = matrices(rest, 0.0)
    history = [rest - dt * push + 0.5 * dt**2 * np.linalg.solve(dense.M + dM, f), rest]
    for k in range(steps):
        dM, f = matrices(history[-1], k * dt)
        b = (dense.M + dM) @ (2.0 * history[-1] - history[-2]) + dt**2 * f
        history.append(np.linalg.solve(np.eye(6) + np.linalg.solve(dense.M, dM), np.linalg.solve(dense.M, b)))
    expected = np.array(history[1:])

    motion = Motion.harmonic(amplitude, omega / (2.0 * np.pi), steps * dt)
    response = simulate(column, motion, output_step=dt, initial=InitialState(rotation_rate=[0.02] * 3))
    assert response.stats["steps"] == steps
    assert response.stats["rocking"] > 0.2  # the scene is not a linear one
    scale = np.max(np.abs(expected), axis=0)
    assert response.ux / scale[:3] == pytest.approx(expected[:, :3] / scale[:3], abs=1e-9)  # measured 6e-11
    assert -response.uz / scale[3:] == pytest.approx(expected[:, 3:] / scale[3:], abs=1e-9)


def test_sweeps_are_counted_and_few() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 5.0)
    stats = simulate(phocas(formulation="paper"), motion).stats
    assert 2.0 < stats["sweeps"] / stats["evaluations"] < 5.0  # measured 4.04
    assert simulate(phocas(formulation="exact"), motion).stats["sweeps"] == 0


def test_sweeps_that_do_not_settle_are_an_error() -> None:
    # displacements of more than a block's height are too large for a first-order model
    stepper = Stepper(phocas(formulation="paper"))
    stepper.state.phase.theta[:] = 2.0 * 4.69, 0.0, 2.0 * 4.69  # as rotations of 2 rad, which no start may have
    with pytest.raises(ValueError, match="sweeps"):
        stepper.observe(0.0)


@given(seed=seeds, n=sizes)
@examples
def test_exact_and_paper_differ_by_the_square_of_the_amplitude(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    unit = random_column(rng, n, "exact", softest=1e8)
    q, rate = random_state(rng, unit, 1e-2)
    ax, az = rng.uniform(-1.0, 1.0, 2) * unit.g

    def difference(scale: float) -> float:
        """Return the rotations, openings, rates, gravity and base acceleration all of the first order."""
        exact = with_gravity(unit, scale * unit.g)
        paper = exact.with_settings(formulation="paper")
        first, _ = look(exact, scale * q, scale * rate, scale * ax, scale * az)
        u, u_rate = from_exact(exact, scale * q), from_exact(exact, scale * rate)
        second, _ = look(paper, u, u_rate, scale * ax, scale * az)
        return float(np.max(np.abs(from_exact(exact, first) - second)) / np.max(np.abs(second)))

    # relative to accelerations of the first order, the difference is of the first order
    large, small = difference(1e-2), difference(1e-3)
    assert large / small == pytest.approx(10.0, rel=0.02)  # measured 10.03
