"""The integrators: coefficients, orders, reversibility, agreement with scipy's, independence of the caller's steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from types import ModuleType

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.lagrange import Array, Reference
from support.probe import G, coordinates, forced, phocas, put_back, walk

from solver import Block, Column, InitialState, Joint, Settings
from solver.kernels.engine import dormand_prince, order_8
from solver.models.column.stepper import Stepper

FORMULATIONS = ["exact", "paper"]


# --- coefficients

Tree = tuple["Tree", ...]  # a rooted tree is the tuple of the trees on its root


def forests(order: int, largest: Tree | None = None) -> Iterator[tuple[Tree, ...]]:
    """Yield every multiset of rooted trees with `order` nodes in all."""
    if order == 0:
        yield ()
    for first in range(1, order + 1):
        for tree in trees(first):
            if largest is None or (nodes(tree), tree) <= (nodes(largest), largest):
                for rest in forests(order - first, tree):
                    yield (tree, *rest)


def trees(order: int) -> list[Tree]:
    return list(forests(order - 1))


def nodes(tree: Tree) -> int:
    return 1 + sum(nodes(branch) for branch in tree)


def density(tree: Tree) -> int:
    return nodes(tree) * math.prod(density(branch) for branch in tree)


def stage_table(method: ModuleType) -> tuple[Array, Array, Array]:
    """Return the stage weights (s, s), nodes (s,) and weights (s,) of an explicit method, the evaluation at the end
    included.
    """
    if method is order_8:
        last = order_8.END
        a = np.zeros((last + 1, last + 1))
        a[: last + 1, :last] = order_8.WEIGHTS[: last + 1]
        return a, np.append(order_8.NODES, 1.0), a[last]
    numbers = {name: value for name, value in vars(method).items() if isinstance(value, float)}
    stages = 1 + sum(name.startswith("C") for name in numbers)
    a = np.zeros((stages + 1, stages + 1))
    for i in range(1, stages):
        a[i, :i] = [numbers.get(f"A{i}_{j}", 0.0) for j in range(i)]
    a[stages, :stages] = [numbers.get(f"B_{j}", 0.0) for j in range(stages)]
    c = np.array([0.0, *(numbers[f"C{i}"] for i in range(1, stages)), 1.0])
    return a, c, a[stages]


def error_weights(method: ModuleType, prefix: str, stages: int) -> Array:
    """Return the row of the error estimate of that name, (s,)."""
    if method is order_8:
        return np.append(order_8.WEIGHTS[getattr(order_8, prefix)], 0.0)
    row = [getattr(method, f"{prefix}_{j}", 0.0) for j in range(stages)]
    row[-1] = getattr(method, f"{prefix}_LAST", 0.0)
    return np.array(row)


def residual(a: Array, weights: Array, tree: Tree) -> float:
    """Return the defect of Butcher's order condition of a tree: sum of weights times elementary weights, less 1 /
    density.
    """

    def stage_values(at_root: Tree) -> Array:
        found = np.ones(len(weights))
        for branch in at_root:
            found *= a @ stage_values(branch)
        return found

    return float(weights @ stage_values(tree)) - 1.0 / density(tree)


@pytest.mark.parametrize(
    ("method", "estimates", "rounding"),
    [(dormand_prince, {"ERROR": 4}, 2e-15), (order_8, {"ERROR_5": 5, "ERROR_3": 3}, 2e-13)],  # measured 4e-16, 2e-14
)
def test_tableau_satisfies_the_order_conditions(method: ModuleType, estimates: dict[str, int], rounding: float) -> None:
    assert [len(trees(order)) for order in range(1, 9)] == [1, 1, 2, 4, 9, 20, 48, 115]
    a, c, weights = stage_table(method)
    assert np.sum(a, axis=1) == pytest.approx(c, abs=rounding)
    candidates = {method.ORDER: weights}
    candidates |= {order: weights - error_weights(method, name, len(weights)) for name, order in estimates.items()}
    for order, row in candidates.items():
        for below in range(1, order + 1):
            assert max(abs(residual(a, row, tree)) for tree in trees(below)) < rounding
        assert max(abs(residual(a, row, tree)) for tree in trees(order + 1)) > 1e-6  # not of a higher order


# --- orders, in full contact where the forces are smooth


def smooth_run(column: Column) -> tuple[Array, float]:
    """Return the rotations (displacements, paper) after 0.5 s of 0.005 g at 2 Hz, which opens no joint, and the largest
    one.
    """
    stepper = forced(Stepper(column), 0.005 * G, 2.0)
    stepper.advance(0.0, 0.5)
    assert stepper.state.control.time_full == pytest.approx(0.5, rel=1e-12)
    return coordinates(stepper)[: column.n].copy(), float(stepper.state.control.rotation_scale)


@pytest.mark.parametrize("eta", [0.0, 1e-3])
def test_central_differences_are_of_order_two(eta: float) -> None:
    runs = [smooth_run(phocas(eta, formulation="paper", step=2e-4 / 2**k))[0] for k in range(5)]
    expected = runs[-1] + (runs[-1] - runs[-2]) / 3.0  # Richardson
    errors = [np.max(np.abs(run - expected)) for run in runs[:3]]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert orders == pytest.approx(np.full(2, 2.0), abs=0.05)


@pytest.mark.parametrize("eta", [0.0, 1e-3])
def test_error_of_auto_is_proportional_to_the_tolerance(eta: float) -> None:
    expected, peak = smooth_run(phocas(eta, tolerance=1e-13, without=("elastic",)))
    errors = []
    for tolerance in (1e-8, 1e-9, 1e-10):  # at larger ones stability limits the step
        column = phocas(eta, tolerance=tolerance, without=("elastic",))
        errors.append(np.max(np.abs(smooth_run(column)[0] - expected)) / peak)
        assert errors[-1] == pytest.approx(0.0, abs=tolerance)  # measured 1e-4 to 0.03
    slopes = np.log10(np.array(errors[:-1]) / errors[1:])
    assert slopes == pytest.approx(np.ones(2), abs=0.35)  # measured 0.77 to 1.17


def test_central_differences_run_backwards_retrace_their_path() -> None:
    stepper = Stepper(phocas(formulation="paper"), InitialState(rotation_rate=[0.03, 0.02, 0.01]))
    begin = coordinates(stepper).copy()
    stepper.advance(0.0, 0.3)
    assert stepper.state.control.time_rocking > 0.25  # joints open and close on the way
    coordinates(stepper)[6:] *= -1.0
    far = np.max(np.abs(coordinates(stepper)[:3]))
    stepper.advance(0.3, 0.3)
    # to rounding, measured 1e-14 of the way
    assert coordinates(stepper)[:3] == pytest.approx(begin[:3], abs=1e-12 * far)


# --- an independent integrator on independent equations


@pytest.mark.long  # takes seconds
def test_auto_agrees_with_dop853_on_lagranges_equations() -> None:
    upper = Block(2.0, 1.0, 1.0, 4000.0, Joint(2e8, 1e-3))
    lower = Block(1.5, 1.2, 1.0, 5000.0, Joint(3e8, 1e-3))
    column = Column("two", (upper, lower), Settings(tolerance=1e-10))
    amplitude, frequency, end = 0.3 * G, 2.0, 0.3
    stepper = forced(Stepper(column), amplitude, frequency)
    reference = Reference.of(column)

    def rates(t: float, y: Array) -> Array:
        ax = amplitude * math.sin(2.0 * math.pi * frequency * t)
        return np.concatenate([y[4:], reference.accelerations(y[:4], y[4:], ax)])

    path = solve_ivp(rates, (0.0, end), coordinates(stepper).copy(), method="DOP853", rtol=1e-11, atol=1e-14).y
    stepper.advance(0.0, end)
    assert stepper.state.control.time_rocking > 0.2
    scale = np.max(np.abs(path), axis=1)
    assert coordinates(stepper) / scale == pytest.approx(path[:, -1] / scale, abs=1e-8)  # measured 1.4e-9


# --- communication steps


def scene(formulation: str) -> Stepper:
    """Return a damped column, pushed, under a constant base acceleration: it rocks."""
    column = phocas(1e-3, formulation=formulation, tolerance=1e-8)
    stepper = Stepper(column, InitialState(rotation_rate=[0.03, 0.02, 0.01]))
    stepper.base.ax = 0.2
    return stepper


@pytest.mark.parametrize("h", [0.009999999999999998, 0.01, 0.010000000000000002])
def test_step_that_arrives_with_a_rounding_error_is_cut_into_as_many(h: float) -> None:
    stepper = scene("paper")
    stepper.advance(0.0, h)
    assert stepper.counts.steps == 100


def test_step_that_does_not_fit_is_cut_into_equal_shorter_ones() -> None:
    cut, fine = scene("paper"), scene("paper")
    fine.model.settings.step = 1.05e-3 / 11
    for stepper in (cut, fine):
        stepper.advance(0.0, 1.05e-3)
        assert stepper.counts.steps == 11
    assert np.array_equal(coordinates(cut), coordinates(fine))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_communication_step_does_not_matter(formulation: str) -> None:
    rng = np.random.default_rng(1)
    grids = [
        np.linspace(0.0, 0.5, 51),
        np.linspace(0.0, 0.5, 501),
        # uneven, on the grid of the fixed step
        np.concatenate([[0.0], np.sort(rng.choice(np.arange(1, 5000), 60, replace=False)) * 1e-4, [0.5]]),
    ]
    whole = scene(formulation)
    whole.advance(0.0, 0.5)
    assert whole.state.control.time_rocking > 0.4
    for grid in grids:
        stepper = scene(formulation)
        found = walk(stepper, grid)
        # exact: measured 4e-9 of the largest rotation; paper, of the largest displacement: 2e-12
        bound = 5e-8 if formulation == "exact" else 1e-10
        assert found[:3] == pytest.approx(coordinates(whole)[:3], abs=bound * stepper.state.control.rotation_scale)


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_advance_lands_exactly(formulation: str) -> None:
    stepper = scene(formulation)
    stepper.base.jx, stepper.base.jz = 7.0, -3.0
    times = np.array([0.0, 1.0 / 3.0, 0.7, 0.7 + 1e-7])
    for begin, end in pairwise(times):
        stepper.advance(begin, end - begin)
        # the stored acceleration of the base is that of the end, to the last bit
        assert stepper.state.control.base_ax == 0.2 + 7.0 * (begin + (end - begin))
        assert stepper.state.control.base_az == -3.0 * (begin + (end - begin))
    spent = stepper.time_spent
    assert spent == pytest.approx(times[-1], rel=1e-12)  # measured 1e-14


# --- bits


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_same_input_gives_the_same_bits_also_after_a_restore(formulation: str) -> None:
    times = np.linspace(0.0, 0.4, 41)
    first, second, restored = (scene(formulation) for _ in range(3))
    walk(first, times)
    walk(second, times[:21])
    put_back(second, restored)
    walk(second, times[20:])
    walk(restored, times[20:])
    for other in (second, restored):
        assert np.array_equal(first.arrays.state, other.arrays.state)
        assert np.array_equal(first.arrays.counts, other.arrays.counts)
    rows = [stepper.observe(0.4).copy() for stepper in (first, second, restored)]
    assert np.array_equal(rows[0], rows[1])
    assert np.array_equal(rows[0], rows[2])


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_looking_at_a_column_does_not_change_its_way(formulation: str) -> None:
    times = np.linspace(0.0, 0.2, 21)
    watched, unseen = scene(formulation), scene(formulation)
    walk(unseen, times)
    for begin, end in pairwise(times):
        watched.observe(begin)
        watched.advance(begin, end - begin)
    assert np.array_equal(watched.arrays.state, unseen.arrays.state)
