"""The stepper alone: parameters that change during a run."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import coordinates, put_back

from solver import Column, InitialState, InputError, Motion, SolverError
from solver.common.errors import TooMuchWorkError
from solver.kernels.column.api import entries
from solver.kernels.layout import spaces as at
from solver.models.column.stepper import Stepper
from solver.models.samples import samples_of


def test_motions_of_every_kind_and_times_that_cannot_be_written_are_followed() -> None:
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    times = np.linspace(0.0, 0.2, 3)
    times.flags.writeable = False
    for motion in (
        Motion.harmonic(0.1, 2.0, 0.1),
        Motion.from_samples(0.1, [0.0, 1.0, 0.0]),
        Motion.from_samples(0.1, [0.0, 1.0], hold=True),
    ):
        whole = Stepper(column)
        rows = whole.rows_of(whole.run(motion, motion.end, times))
        stepper = Stepper(column)
        stepper.record = samples_of(motion)
        stepper.advance(0, 1)  # whole numbers are times too
        row = stepper.observe(1)
        assert np.all(np.isfinite(rows))
        assert np.all(np.isfinite(row))
        assert np.any(rows[1:, : column.n] != 0.0)


def test_a_change_of_damping_is_a_new_start_from_the_same_motion() -> None:
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml").with_settings(tolerance=1e-9)
    blocks = tuple(replace(block, joint=replace(block.joint, damping=5e-3)) for block in column.blocks)
    changed = replace(column, blocks=blocks, g=9.0)
    stepper = Stepper(column)
    stepper.base.ax = 1.0
    stepper.advance(0.0, 0.5)
    stepper.retune(changed)
    rotation, opening, spin, opening_rate = coordinates(stepper).reshape(4, column.n)
    fresh = Stepper(changed, InitialState(rotation, spin, opening, opening_rate))
    fresh.arrays.base[:] = stepper.arrays.base
    for t in (0.5, 1.0):
        stepper.advance(t, 0.5)
        fresh.advance(t, 0.5)
    difference = stepper.observe(1.5).copy() - fresh.observe(1.5)
    assert np.max(np.abs(difference[: column.n])) < 1e-7 * np.max(np.abs(fresh.observe(1.5)[: column.n]))


def test_modes_follow_a_change_of_damping_at_steps_that_stay_the_same() -> None:
    column = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml")
    blocks = tuple(replace(block, joint=replace(block.joint, damping=2e-2)) for block in column.blocks)
    changed = replace(column, blocks=blocks)
    stepper = Stepper(column)
    stepper.base.ax = 0.05
    for k in range(50):
        stepper.advance(0.01 * k, 0.01)
    stepper.retune(changed)
    other = Stepper(changed)
    put_back(stepper, other)
    for k in range(50, 60):
        stepper.advance(0.01 * k, 0.01)
        other.advance(0.01 * k, 0.01)
    assert stepper.counts.elastic_steps > 50
    assert np.array_equal(stepper.observe(0.6), other.observe(0.6))


def test_a_change_that_is_not_stable_is_refused() -> None:
    column = Column.from_toml(ROOT / "examples/columns/phocas.toml")
    stepper = Stepper(column)
    blocks = tuple(replace(block, joint=replace(block.joint, damping=1.0)) for block in column.blocks)
    with pytest.raises(InputError, match="must be at most"):
        stepper.retune(replace(column, blocks=blocks))


@pytest.mark.parametrize(
    "given",
    [{"ax": -1.1e6}, {"az": 1e14}, {"jz": 1e14}, {"jx": -1.1e8}, {"omega": 2e6}, {"alpha": 1e7}, {"theta": 2e6}],
)
def test_inputs_beyond_a_million_are_refused(given: dict[str, float]) -> None:
    """Check that under an acceleration of 1e14 m/s2 a step does not end."""
    stepper = Stepper(Column.from_toml(ROOT / "examples/columns/phocas-damped.toml"))
    stepper.drive(0.0, **given)
    before = stepper.arrays.state.copy()
    with pytest.raises(SolverError, match=r"at t = 0 s: an input of the base is, or becomes, larger than 1e6"):
        stepper.advance(0.0, 0.01)
    np.testing.assert_array_equal(stepper.arrays.state, before)


def test_the_largest_inputs_are_followed_to_the_end_or_to_the_fall() -> None:
    """Follow them in 7000 evaluations at most, as measured."""
    for given in ({"az": 1e6}, {"az": -1e6}, {"ax": 1e6}, {"jz": 1e6}, {"omega": 1e5}, {"alpha": 1e6}):
        stepper = Stepper(Column.from_toml(ROOT / "examples/columns/phocas-damped.toml"))
        stepper.drive(0.0, **given)
        stepper.advance(0.0, 1.0)
        assert stepper.counts.evaluations < 20_000, given


def test_a_step_that_does_not_end_is_given_up() -> None:
    """Start from a state that no run leaves behind: there is no step that the control could propose next."""
    stepper = Stepper(Column.from_toml(ROOT / "examples/columns/phocas-damped.toml"))
    stepper.drive(0.0, 1.0)
    stepper.advance(0.0, 0.1)
    stepper.state.control.next_step = math.nan
    stepper.drive(0.1, 2.0)
    with pytest.raises(TooMuchWorkError, match=r"at t = 0\.1 s: the motion is too fast to be followed"):
        stepper.advance(0.1, 0.01)
    assert stepper.counts.evaluations < 2_000_000  # 1e5 and 1e4 for each of its 137 first steps


def test_a_run_that_does_not_end_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check that its chunks become shorter as they cost more, each within its own bound: that of all is the run's."""
    monkeypatch.setattr("solver.models.column.stepper.most_work", lambda settings, h: 100.0)
    stepper = Stepper(Column.from_toml(ROOT / "examples/columns/phocas-damped.toml"))
    why = r"after \d\.\d+ s: .* too slow to go on: the fastest is block\[1\]\.joint"
    with pytest.raises(TooMuchWorkError, match=why):
        stepper.run(Motion.harmonic(1.0, 2.0, 20.0), 20.0, np.empty(0))


def test_a_chunk_beyond_the_limit_of_a_call_is_divided() -> None:
    """Refuse chunks above 0.3 s once they have moved the column; the run goes back and takes shorter ones."""
    column, times = Column.from_toml(ROOT / "examples/columns/phocas-damped.toml"), np.linspace(0.0, 5.0, 51)
    motion, refused = Motion.harmonic(1.0, 2.0, 5.0), []

    def limited(*given: Any) -> int:
        code: int = entries.run(*given)
        *_, h, _, _, _ = given
        refused.append(h > 0.3)
        return at.CALL_TOO_LONG if refused[-1] else code

    whole, stepper = Stepper(column).run(motion, 5.0, times), Stepper(column)
    stepper._entries = SimpleNamespace(run=limited)
    divided = stepper.run(motion, 5.0, times)
    assert any(refused)
    assert np.max(np.abs(divided - whole)[:, : 2 * column.n]) < 1e-4 * np.max(np.abs(whole[:, : 2 * column.n]))
