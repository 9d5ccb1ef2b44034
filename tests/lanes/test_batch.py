"""Many runs through the lanes of a vector: each has the motion of a single run, whatever runs beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.lanes import assert_nothing_depends_on_the_others
from support.probe import G, monolith, phocas, random_column

from solver import Column, InputError, Motion, simulate
from solver.column.rest import is_stable
from solver.runs.batch import run_batch

pytestmark = pytest.mark.long  # compiles the lanes


def shaking(seed: int, seconds: float = 4.0, step: float = 0.01) -> Motion:
    """Noise up to some 5 Hz that makes Phocas rock, in both directions."""
    rng = np.random.default_rng(seed)
    time = step * np.arange(round(seconds / step) + 1)
    waves = [np.sin(2.0 * math.pi * f * time + rng.uniform(0.0, 6.0)) * rng.normal() for f in rng.uniform(0.5, 5.0, 8)]
    ax = 0.05 * G * sum(waves) * np.sin(math.pi * time / seconds)
    return Motion.from_samples(step, ax, 0.3 * ax)


def eleven() -> tuple[list[Column], list[Motion], list[float]]:
    """More runs than lanes: columns that differ, harmonics and records of several lengths, one that falls."""
    columns = [phocas(1e-3), phocas(5e-3), phocas(2e-2), *(phocas(eta) for eta in (1e-3, 2e-3, 3e-3, 1e-2, 3e-2))]
    columns += [phocas(1e-3)] * 3
    motions = [Motion.harmonic(0.05 * G, f, 4.0) for f in (1.0, 2.0, 3.0)] + [shaking(seed) for seed in range(7)]
    motions.append(Motion.harmonic(0.4 * G, 0.4, 4.0))
    durations = [4.0, 3.0, 2.0, 4.0, 2.5, 4.0, 4.0, 3.3, 4.0, 1.0, 4.0]
    return columns, motions, durations


def test_runs_are_those_of_simulate() -> None:
    columns, motions, durations = eleven()
    times = 0.1 * np.arange(11, dtype=np.float64)
    result = run_batch(columns, motions, durations, tolerance=1e-6, times=times)
    assert np.all(result.finished)
    assert np.count_nonzero(result.overturned_joint) == 1
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        single = simulate(column, motion, duration, tolerance=1e-9, output_step=0.1)
        assert result.overturned_joint[k] == single.overturned_joint
        if single.overturned:
            assert result.overturn_time[k] == pytest.approx(single.overturn_time, abs=1e-4)
        # changes of regime are not located in lanes (measured 1e-4)
        assert result.peak_ux[k] == pytest.approx(single.peak_ux, rel=1e-4)
        largest = np.max(np.abs(single.theta[:11]))
        assert result.phases[k][:, :3] == pytest.approx(single.theta[:11], abs=1e-3 * largest)


def test_what_comes_of_a_run_depends_on_no_other_nor_on_order_and_threads() -> None:
    assert_nothing_depends_on_the_others(*eleven())


@pytest.mark.parametrize("n", [1, 2, 5])
def test_any_number_of_blocks(n: int) -> None:
    rng = np.random.default_rng(n)
    drawn = (random_column(rng, n, softest=1e8) for _ in range(100))
    columns = [column for column in drawn if is_stable(column)][:9]
    motion = Motion.harmonic(0.02 * G, 2.0, 0.5)
    result = run_batch(columns, [motion] * 9, tolerance=1e-7)
    for k, column in enumerate(columns):
        single = simulate(column, motion, tolerance=1e-9)
        assert result.overturned_joint[k] == single.overturned_joint
        assert result.peak_ux[k] == pytest.approx(single.peak_ux, rel=1e-3, abs=1e-9)


def test_what_a_batch_cannot_take_is_refused_in_one_line() -> None:
    motion = Motion.harmonic(0.1, 1.0, 1.0)
    held = Motion(np.array([0.0, 0.5]), np.array([0.1, 0.2]), np.zeros(2), 1.0, hold=True)
    for columns, motions, key in (
        ([phocas(1e-3), monolith(eta=1e-3)], [motion] * 2, "columns[1]"),
        ([phocas(1e-3, formulation="paper")], [motion], "columns[0]"),
        ([phocas(1e-3)], [held], "motions[0]"),
        ([phocas(1e-3)] * 2, [motion], "2 columns, 1 motions"),
    ):
        with pytest.raises(InputError, match=key.replace("[", r"\[").replace("]", r"\]")):
            run_batch(columns, motions)
