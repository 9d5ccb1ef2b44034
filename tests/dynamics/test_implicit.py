"""The implicit method of `auto`: its linear solution, its coefficients, its order, and its selection."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from support.columns import off_axis_column
from support.joints import contact_regime, joint_forces
from support.probe import PHOCAS_STIFFNESS, Array, G, phocas, random_column, sliding_state
from support.sliding import SlidingReference

from solver import Block, Column, Joint, Motion, simulate
from solver.kernels.column.formulations.implicit import TANGENT, WIDEST, factorize, solve
from solver.kernels.column.integrators import rosenbrock
from solver.kernels.column.joint.regimes import OPEN
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.models.column.packing import pack_model

_model, _phase = at.MODEL.over, at.PHASE.over


@from_python
def factorized(n: int, model: Array, phase: Array, tangent: Array, part: float) -> None:
    """Call `factorize` over arrays."""
    factorize(_model(row_of(model), n), _phase(row_of(phase), n), row_of(tangent), part)


@from_python
def add_solution(n: int, model: Array, tangent: Array, a: Array, v: Array, part: float) -> None:
    """Call `solve` over arrays."""
    solve(_model(row_of(model), n), row_of(tangent), row_of(a), row_of(v), part)


def drums(n: int, eta: float = 1e-3, **changes: float) -> Column:
    """Return the shaft of the Column of Phocas cut into n drums, whose joints together are as soft as its three."""
    block = Block(14.07 / n, 1.56, 1.56, 81000.0 / n, Joint(PHOCAS_STIFFNESS * n / 3.0, eta))
    return Column("drums", (block,) * n).with_settings(**changes)  # type: ignore[arg-type]


def symmetric(tangent: SimpleNamespace, name: str, i: int) -> Array:
    """Return the 2 x 2 matrix of joint i, by (theta, delta), of the fields `name`_11, `name`_12 and `name`_22."""
    one, mixed, two = (getattr(tangent, f"{name}_{place}")[i] for place in ("11", "12", "22"))
    return np.array([[one, mixed], [mixed, two]])


def joint_matrices(column: Column, tangent: Array, part: float) -> tuple[Array, Array]:
    """Return (G, K): derivatives of the joints' forces from `factorize`, by (theta, delta), weighted and not."""
    n = column.n
    weighted, plain = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, 2 * n))
    fields = TANGENT.see(tangent, n)
    for i, block in enumerate(column.blocks):
        relative = np.zeros((2, 2 * n))
        relative[0, i] = 1.0
        if i + 1 < n:
            relative[0, i + 1] = -1.0
        relative[1, n + i] = 1.0
        own = relative.T @ symmetric(fields, "k", i) @ relative
        edge = relative.T @ symmetric(fields, "edge", i) @ relative
        plain += own + edge
        weighted += part * (part + block.joint.damping) * own + part**2 * edge
    return weighted, plain


@pytest.mark.long  # takes seconds
@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1), n=st.integers(1, 6), part=st.floats(1e-5, 1e-1))
@pytest.mark.parametrize("make", [random_column, off_axis_column])
def test_solution_is_that_of_the_dense_system(make: Callable[..., Column], seed: int, n: int, part: float) -> None:
    """Check that joints that have slid stick: slips and offsets are lengths of the chain."""
    rng = np.random.default_rng(seed)
    column = make(rng, n)
    q, rate, _ = sliding_state(rng, column, 0.3)
    q[2 * n :] *= column.has_slips
    model, tangent, phase = pack_model(column).copy(), np.zeros(TANGENT.size(n)), np.zeros(at.PHASE.size(n))
    phase[: 4 * n] = np.concatenate([q[: 2 * n], rate[: 2 * n]])
    at.PHASE.see(phase, n).slip[:] = q[2 * n :]
    factorized(n, model, phase, tangent, part)
    weighted, plain = joint_matrices(column, tangent, part)
    a, v = rng.normal(size=2 * n), rng.normal(size=2 * n)
    solved = a.copy()
    add_solution(n, model, tangent, solved, v, part)
    system = SlidingReference.of(column).mass_matrix(q)[: 2 * n, : 2 * n] + weighted
    forces = -weighted @ a - part**2 * plain @ v
    residual = system @ (solved - a) - forces
    scale = np.abs(system) @ np.abs(solved - a) + np.abs(forces)
    rounding = np.finfo(float).eps * np.max(np.abs(system) @ np.abs(a))  # digits of z lost in the sum a + z
    assert np.max(np.abs(residual)) <= 1e-7 * np.max(scale) + rounding  # measured 4e-9 over 2000 seeds


@settings(deadline=None, max_examples=40)
@given(seed=st.integers(0, 2**32 - 1))
def test_stiffness_of_a_joint_that_has_slid_is_the_derivative_of_its_forces(seed: int) -> None:
    """Compare with central differences of the pressures of Lagrange's equations, in full contact, without dashpots."""
    rng = np.random.default_rng(seed)
    joint = Joint(1e9, 0.0, friction=0.5)
    below = Block(2.0, 1.0, 1.0, 5000.0, Joint(1e9, 0.0, friction=0.5))
    column = Column("two", (Block(2.0, 1.0, 1.0, 5000.0, joint), below))
    reference, n = SlidingReference.of(column), 2
    q = np.array([*rng.uniform(-1e-4, 1e-4, 2), *rng.uniform(-2e-3, -1e-3, 2), *rng.uniform(-0.3, 0.3, 2)])
    phase, tangent = np.zeros(at.PHASE.size(n)), np.zeros(TANGENT.size(n))
    phase[: 2 * n] = q[: 2 * n]
    at.PHASE.see(phase, n).slip[:] = q[2 * n :]
    factorized(n, pack_model(column).copy(), phase, tangent, 1e-3)
    fields = TANGENT.see(tangent, n)

    def forces(at_q: Array) -> Array:
        """Return the generalized forces of joint 1 on its rotation and its opening, as a column, with the sign of
        resistance.
        """
        normal, moment = reference.pressures(at_q, np.zeros(6))
        half = 0.5 * (at_q[0] - at_q[1])
        return np.array([(moment[0] + 0.5 * at_q[4] * normal[0]) * np.cos(half), -normal[0]])

    change = 1e-6 * np.eye(6)
    found = np.array([(forces(q + change[k]) - forces(q - change[k])) / 2e-6 for k in (0, 2)]).T
    expected = symmetric(fields, "k", 0)
    assert found == pytest.approx(expected, abs=1e-3 * np.max(np.abs(expected)))  # but for sines of rotations


def test_stiffness_is_the_second_derivative_of_the_joint_potential_in_full_contact() -> None:
    column = phocas()
    tangent = np.zeros(TANGENT.size(3))
    phase = np.zeros(at.PHASE.size(3))
    at.PHASE.see(phase, 3).opening[:] = -1e-4
    factorized(3, pack_model(column).copy(), phase, tangent, 1e-3)
    stiffness = TANGENT.see(tangent, 3)
    assert stiffness.k_22 == pytest.approx(PHOCAS_STIFFNESS * 1.56**2, rel=1e-14)
    assert stiffness.k_11 == pytest.approx(PHOCAS_STIFFNESS * 1.56**4 / 12.0, rel=1e-14)
    assert np.all(stiffness.k_12 == 0.0)


@settings(deadline=None, max_examples=100)
@given(
    turn=st.floats(-1e-2, 1e-2),
    opening=st.floats(-5e-3, 5e-3),
    spin=st.floats(-0.5, 0.5),
    rate=st.floats(-0.2, 0.2),
    eta=st.floats(1e-3, 0.1),
)
def test_matrices_of_a_damped_joint_are_the_derivatives_of_its_forces(
    turn: float, opening: float, spin: float, rate: float, eta: float
) -> None:
    """Compare with central differences of the law itself, with the moving edge, wherever it is smooth."""
    assume(abs(turn) > 1e-4)
    column = Column("one", (Block(2.0, 1.0, 1.0, 5000.0, Joint(1e9, eta)),))
    tangent = np.zeros(TANGENT.size(1))
    factorized(1, pack_model(column).copy(), np.array([turn, opening, spin, rate, 0.0, 0.0]), tangent, 1e-3)
    fields = TANGENT.see(tangent, 1)

    def law(x: Array) -> Array:
        normal, moment, _ = joint_forces(1e9, 1.0, 1.0, eta, *x)
        return np.array([moment, -normal])  # of slope and opening

    cosine = np.cos(0.5 * turn)
    state = np.array([opening, 2.0 * np.sin(0.5 * turn), rate, cosine * spin])
    regime = contact_regime(1.0, eta, *state)
    near = 1e-4 * np.array([[5e-3], [1e-2], [0.2], [0.5]]) * np.eye(4)
    assume(all(contact_regime(1.0, eta, *(state + sign * step)) == regime for step in near for sign in (1.0, -1.0)))
    assume(regime != OPEN)
    derivatives = [(law(state + 1e-2 * step) - law(state - 1e-2 * step)) / (2e-2 * np.max(step)) for step in near]
    by_coordinates = np.array([derivatives[1], derivatives[0]])  # slope, opening
    by_rates = np.array([derivatives[3], derivatives[2]])
    size = np.diag([1.0 / cosine, 1.0])  # from rotations to slopes
    k = size @ symmetric(fields, "k", 0) @ size
    edge = size @ symmetric(fields, "edge", 0) @ size
    assume(edge[1, 1] < 0.9 * WIDEST * 1e9)  # narrower than the limit of a strip's width
    scale = np.max(np.abs(k)) + np.max(np.abs(edge))
    assert np.max(np.abs(by_coordinates - k - edge)) < 1e-4 * scale
    assert np.max(np.abs(by_rates - eta * k)) < 1e-4 * eta * scale


def test_coefficients_fulfil_the_order_conditions_of_a_w_method() -> None:
    b, alpha, gamma = rosenbrock.WEIGHTS, rosenbrock.ALPHA, rosenbrock.GAMMAS
    one = np.ones(rosenbrock.STAGES)
    order_1_and_2 = {"b": (one, 1.0), "b a": (alpha @ one, 0.5), "b g": (gamma @ one, 0.0)}
    order_3 = {
        "b a a": ((alpha @ one) ** 2, 1.0 / 3.0),
        "b aa": (alpha @ alpha @ one, 1.0 / 6.0),
        "b ag": (alpha @ gamma @ one, 0.0),
        "b ga": (gamma @ alpha @ one, 0.0),
        "b gg": (gamma @ gamma @ one, 0.0),
    }
    for name, (vector, expected) in (order_1_and_2 | order_3).items():
        assert b @ vector == pytest.approx(expected, abs=1e-14), name  # measured 4e-16
    for name, (vector, expected) in order_1_and_2.items():
        assert rosenbrock.EMBEDDED @ vector == pytest.approx(expected, abs=1e-14), name
    # stiffly accurate: nothing of an infinitely stiff mode is left after a step
    assert alpha[-1] + gamma[-1] == pytest.approx(b, abs=1e-15)
    assert b @ np.linalg.solve(alpha + gamma, one) == pytest.approx(1.0, abs=1e-14)


def test_transformed_coefficients_belong_to_the_printed_ones() -> None:
    inverse = np.linalg.inv(rosenbrock.GAMMAS)
    assert pytest.approx(rosenbrock.ALPHA @ inverse, abs=1e-14) == rosenbrock.A
    assert pytest.approx(np.eye(4) / rosenbrock.GAMMA - inverse, abs=1e-14) == rosenbrock.C
    assert pytest.approx(rosenbrock.WEIGHTS @ inverse, abs=1e-14) == rosenbrock.M


def test_a_finely_cut_column_is_stepped_implicitly_and_to_its_tolerance() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 1.0)
    reference = simulate(drums(20), motion, tolerance=1e-7)
    errors = []
    for tolerance in (1e-2, 1e-3, 1e-4):
        response = simulate(drums(20), motion, tolerance=tolerance)
        # the length of stretches with explicit steps depends on details: the median of neighbouring tolerances
        stats = [simulate(drums(20), motion, tolerance=tolerance * (1.0 + 0.02 * k)).stats for k in range(-2, 3)]
        assert np.median([run["implicit_steps"] / run["steps"] for run in stats]) > 0.5  # measured 0.64 to 0.77
        assert response.stats["steps"] < 3000  # the explicit limit, 8e-5 s, asks for 12,000
        errors.append(np.max(np.abs(response.ux - reference.ux)) / reference.peak_top_ux[0])
        assert errors[-1] < tolerance  # measured 0.06 of it
    assert errors[0] > errors[1] > errors[2]


def test_implicit_and_explicit_steps_lead_to_the_same_motion() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 0.5)
    implicit = simulate(drums(20), motion, tolerance=1e-4)
    explicit = simulate(drums(20), motion, tolerance=1e-8, without=("implicit", "elastic"))
    assert explicit.stats["implicit_steps"] == 0
    assert implicit.stats["implicit_steps"] > 100
    difference = np.max(np.abs(implicit.ux - explicit.ux)) / explicit.peak_top_ux[0]
    print(f"{difference:.1e} of the peak")
    assert difference < 3e-5  # measured 3e-6


def test_a_finely_cut_column_off_its_axis_is_stepped_implicitly_and_to_its_tolerance() -> None:
    """Compare offset drums, one of whose joints could slide but does not, with explicit steps at a tight tolerance."""
    column = drums(12, 2e-3, tolerance=1e-4)
    blocks = list(column.blocks)
    blocks[3] = replace(blocks[3], joint=replace(blocks[3].joint, offset=0.05, friction=0.7))
    blocks[8] = replace(blocks[8], joint=replace(blocks[8].joint, offset=-0.03, inclination=0.003))
    column = replace(column, blocks=tuple(blocks))
    motion = Motion.harmonic(0.05 * G, 2.0, 1.0)
    reference = simulate(column, motion, tolerance=1e-7, without=("implicit",), settle=0.0)
    for tolerance in (1e-3, 1e-4):
        response = simulate(column, motion, tolerance=tolerance, settle=0.0)
        assert response.stats["implicit_steps"] > 0.3 * response.stats["steps"]
        assert np.max(np.abs(response.ux - reference.ux)) < tolerance * reference.peak_top_ux[0]


def test_a_column_that_is_not_stiff_is_stepped_explicitly() -> None:
    response = simulate(phocas(), Motion.harmonic(0.05 * G, 2.0, 2.0), tolerance=1e-7)
    assert response.stats["implicit_steps"] == 0


def test_two_hundred_drums_are_followed_in_a_few_thousand_steps() -> None:
    response = simulate(drums(200), Motion.harmonic(0.05 * G, 2.0, 1.0), tolerance=1e-3)
    assert response.stats["steps"] + response.stats["rejected"] < 2000  # explicit: 2.5 million
    reference = simulate(drums(200), Motion.harmonic(0.05 * G, 2.0, 1.0), tolerance=1e-5)
    assert np.max(np.abs(response.ux - reference.ux)) < 1e-3 * reference.peak_top_ux[0]  # measured 5e-5


def error_in_tolerances(column: Column, motion: Motion, duration: float, tolerance: float) -> float:
    """Return the largest deviation of ux from a run without implicit steps, in tolerances of its peak."""
    reference = simulate(column, motion, duration, tolerance=1e-9, without=("implicit",))
    response = simulate(column, motion, duration, tolerance=tolerance)
    assert reference.stats["implicit_steps"] == 0
    assert response.stats["implicit_steps"] > 0.1 * response.stats["steps"]
    return float(np.max(np.abs(response.ux - reference.ux)) / np.max(np.abs(reference.ux))) / tolerance


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5])
def test_implicit_steps_of_a_rocking_column_in_mortar_err_little(tolerance: float) -> None:
    """Check that moving edges of contact count in the derivative of the forces: without them 0.17 to 0.38 tolerances
    here.
    """
    motion = Motion.harmonic(0.2 * G, 1.5, 6.0)
    assert error_in_tolerances(phocas(0.05), motion, 6.0, tolerance) < 0.15  # measured 0.03 to 0.08


@pytest.mark.parametrize(
    "tolerance", [1e-3, *(pytest.param(tolerance, marks=pytest.mark.long) for tolerance in (1e-2, 1e-4, 1e-5, 1e-6))]
)
def test_phocas_in_mortar_under_a_record_keeps_the_tolerance(records: Path, tolerance: float) -> None:
    """Check that the motion amplifies a change of it by 200; without moving edges errors are 30 to 52 tolerances down
    to 1e-5.
    """
    motion = Motion.from_at2(records / "kobe-1995-nishi-akashi-090.AT2").scaled(0.8)
    assert error_in_tolerances(phocas(0.05), motion, 20.0, tolerance) < 10.0  # measured 4.3, 7.6, 6.7, 3.4, 0.2
