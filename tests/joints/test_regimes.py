"""Regimes of the joints: the range in which it is valid, and the moments at which steps are cut."""

from __future__ import annotations

import math
from dataclasses import astuple
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from support.joint_states import State, examples, states
from support.joints import contact_regime, held_forces, regime_margin
from support.probe import Array, G, coordinates, phocas

from solver import InitialState, Motion, simulate
from solver.kernels.column.api.engine import column_over
from solver.kernels.column.integrators.interpolation import begin, interpolate_phase, refine
from solver.kernels.column.integrators.traits import ORDER_8
from solver.kernels.column.joint.regimes import FULL, OPEN, RIGHT
from solver.kernels.column.stepping.advance import repeat_step
from solver.kernels.engine.samples import no_samples
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.models.column.stepper import Stepper

# a joint cannot end on both sides for the same reason, unless these are its corners
REGIMES = [OPEN, *(FULL + left + RIGHT * right for left in range(3) for right in range(3) if left != right or not left)]


def regime_of(state: State) -> int:
    _, width, _, *rest = astuple(state)
    return int(contact_regime(width, *rest))


def margin(regime: int, state: State) -> float:
    _, width, _, *rest = astuple(state)
    return float(regime_margin(regime, width, *rest))


@examples
@given(states())
def test_margin_of_the_held_law_is_that_of_the_regime(state: State) -> None:
    for regime in REGIMES:
        margin_of_law = held_forces(regime, *astuple(state))[3]
        assert margin_of_law == margin(regime, state) or math.isnan(margin(regime, state))


@examples
@given(states())
def test_only_the_regime_that_applies_has_a_margin(state: State) -> None:
    applies = regime_of(state)
    size = state.width * abs(state.slope) + abs(state.opening) + state.damping * abs(state.opening_rate)
    size += state.damping * state.width * abs(state.slope_rate)
    assume(state.slope != 0.0)
    assume(state.slope + state.damping * state.slope_rate != 0.0)  # a boundary that is a line requires one
    own = margin(applies, state)
    assert own >= -1e-12 * size
    assume(own > 1e-9 * size)  # away from the boundary
    for other in REGIMES:
        if other != applies:
            assert not margin(other, state) > 1e-12 * size


@examples
@given(states(), states(), st.floats(0.0, 1.0))
def test_margin_vanishes_where_the_regime_changes(one: State, other: State, at_fraction: float) -> None:
    """Check that along the line between two states the sign of the margin and the regime agree."""

    def between(s: float) -> State:
        mixed = [(1.0 - s) * a + s * b for a, b in zip(astuple(one)[4:], astuple(other)[4:], strict=True)]
        return State(*astuple(one)[:4], *mixed)

    state = between(at_fraction)
    regime = regime_of(one)
    value = margin(regime, state)
    size = sum(abs(part) for part in astuple(state)[4:]) * max(1.0, state.width) * max(1.0, state.damping)
    assume(abs(value) > 1e-9 * size)
    assert (value > 0.0) == (regime_of(state) == regime)


def test_steps_end_where_regimes_do_whatever_the_tolerance() -> None:
    motion = Motion.harmonic(0.05 * G, 2.0, 3.0)
    runs = [simulate(phocas(1e-3), motion, tolerance=tolerance) for tolerance in (1e-5, 1e-6, 1e-7, 1e-8)]
    counts = [run.stats["events"] for run in runs]
    assert counts[0] > 100
    assert max(counts) - min(counts) <= 2  # measured 0: a joint that opens very little may be missed


def test_order_is_that_of_the_method_across_openings() -> None:
    """Check that with regimes held the error falls with the tolerance as in smooth motion, over dozens of openings."""
    motion = Motion.harmonic(0.05 * G, 2.0, 1.5)
    reference = simulate(phocas(1e-3), motion, tolerance=1e-12).ux
    errors = {}
    for tolerance in (1e-3, 1e-5, 1e-7, 1e-9):
        run = simulate(phocas(1e-3), motion, tolerance=tolerance)
        assert run.stats["events"] > 40
        errors[tolerance] = float(np.max(np.abs(run.ux - reference)) / np.max(np.abs(reference)))
    for tolerance, error in errors.items():
        assert error < tolerance  # measured 0.001 to 0.2 of it


@from_python
def look_inside(
    n: int,
    model: Array,
    state: Array,
    counts: Array,
    base: Array,
    work: Array,
    bump: bool,
    t: float,
    h: float,
    s: float,
) -> None:
    """Leave in work.between the interpolation at fraction s of the step of h seconds from t."""
    silence = no_samples(row_of(base))
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), silence, row_of(work))
    begin(column.work, bump)
    refine(column, t, h)
    interpolate_phase(column.work, h, s)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.long  # compiles the interpolation, as the next a step
def test_interpolation_with_the_bump_is_of_a_higher_order() -> None:
    """Compare a free vibration in full contact with a run that lands on the middle of the step."""
    gains = []
    for step in (2e-3, 1e-3):
        stepper = Stepper(phocas(0.0, tolerance=1e-13))
        n = stepper.n
        phase = stepper.arrays.state[at.CONTROL.beside :][: at.PHASE.size(n)]
        stepper.base.wave_amplitude, stepper.base.wave_omega = 0.005 * G, 40.0
        stepper.advance(0.0, 0.1)
        start = phase.copy()
        fraction = 0.3
        stepper.advance(0.1, fraction * step)
        inside = phase[: 2 * n].copy()
        stepper.advance(0.1 + fraction * step, (1.0 - fraction) * step)
        work = at.WORK.see(stepper.arrays.work, n)
        found = []
        for bump in (False, True):
            fill(work.start, start)
            fill(work.end, phase)
            look_inside(n, *stepper.arrays, bump, 0.1, step, fraction)
            between = np.concatenate([work.between.theta, work.between.opening])
            found.append(np.max(np.abs(between - inside)))
        gains.append(found[0] / found[1])
    assert min(gains) > 3.0


@from_python
def _repeat(n, model, state, counts, base, work, t, step):
    silence = no_samples(row_of(base))
    column = column_over(n, row_of(model), row_of(state), row_of(counts), row_of(base), silence, row_of(work))
    return repeat_step(column, ORDER_8, t, step)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.long
def test_a_step_made_again_up_to_a_change_is_judged_again() -> None:
    """Check that a step beyond the limit of stability throws small stiff blocks away at 1e9 rad/s."""
    stepper = Stepper(phocas(), InitialState(rotation_rate=[0.03] * 3))
    stepper.advance(0.0, 0.1)
    rejected = int(stepper.counts.rejected)
    long, short = 0.2, 1e-5
    assert _repeat(stepper.n, *stepper.arrays, 0.1, long) == (at.OK, 0.0)
    assert stepper.counts.rejected == rejected + 1
    assert 0.0 < stepper.state.control.next_step < long
    assert _repeat(stepper.n, *stepper.arrays, 0.1, short) == (at.OK, short)
    assert stepper.counts.rejected == rejected + 1
    work = at.WORK.see(stepper.arrays.work, stepper.n)
    np.testing.assert_allclose(
        work.end.theta, work.start.theta + short * work.start.theta_rate, rtol=0.0, atol=1e-9
    )  # measured 2e-10


def fill(phase: SimpleNamespace, values: Array) -> None:
    """Give a phase, seen by name, the values of a row."""
    for name, part in zip(at.PHASE.fields, values.reshape(at.PHASE.per_n, -1), strict=True):
        getattr(phase, name)[:] = part


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_undamped_column_run_backwards_returns_to_where_it_came_from(tolerance: float) -> None:
    """Run half a second of free rocking, some 35 openings and closings, and as many back."""
    stepper = Stepper(phocas(0.0, tolerance=tolerance), InitialState(rotation_rate=[0.03] * 3))
    phase = coordinates(stepper)
    start = phase.copy()
    stepper.advance(0.0, 0.5)
    there = int(stepper.counts.events)
    farthest = float(np.max(np.abs(phase[:3])))
    phase[6:] *= -1.0
    stepper.advance(0.5, 0.5)
    assert there > 20
    assert stepper.counts.events == 2 * there
    assert np.max(np.abs(phase[:3] - start[:3])) < tolerance * farthest  # measured 0.01 and 0.03 of it
    assert np.max(np.abs(phase[6:9] + start[6:9])) < tolerance * 0.03  # measured 0.2 and 0.6 of it
