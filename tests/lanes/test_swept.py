"""The paper's scheme through the lanes of a vector: each has the steps of a single run, whatever runs beside it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.probe import G, monolith, phocas

from solver import Column, Motion, simulate, simulate_many

pytestmark = pytest.mark.long  # compiles the lanes

KEEP = ("peak_ux", "residual_ux", "residual_theta", "energy", "verdict", "overturn_time", "overturned_joint", "steps",
        "path")  # fmt: skip


def swept(column: Column, step: float = 2e-4) -> Column:
    return column.with_settings(formulation="paper", integrator="central-difference", step=step)


def eleven() -> tuple[list[Column], list[Motion], list[float]]:
    """More runs than lanes: damped and not, other steps, harmonics and records, one that falls."""
    columns = [swept(phocas(eta), step) for eta in (0.0, 1e-4, 1e-3) for step in (1e-4, 2e-4, 1.7e-4)]
    columns += [swept(phocas(1e-3))] * 2
    time = 0.01 * np.arange(51)
    ax = 0.1 * G * np.sin(9.0 * time) * np.sin(math.pi * time / 0.5)
    records = [Motion.from_samples(0.01, ax), Motion.from_samples(0.01, 0.5 * ax, 0.3 * ax)]
    motions = [Motion.harmonic(0.05 * G, f, 1.0) for f in (0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0)]
    motions += [*records, Motion.harmonic(0.6 * G, 0.4, 3.0)]
    return columns, motions, [1.0, 0.8, 1.0, 0.3, 0.9, 1.0, 0.55, 1.0, 0.7, 0.45, 3.0]


def test_runs_are_those_of_simulate() -> None:
    columns, motions, durations = eleven()
    table = simulate_many(columns, motions, duration=durations, keep=KEEP)
    assert table.stats["lanes"] == len(table) == 11
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        single = simulate(column, motion, duration, output_step=duration)
        # `simulate` divides a run into calls and these into steps: the steps differ by rounding, and by one a call
        assert table["steps"][k] == pytest.approx(single.stats["steps"], abs=100)
        assert table["peak_ux"][k] == pytest.approx(single.peak_ux, rel=1e-7)  # measured 9e-10
        assert table["verdict"][k] == ("standing", "overturned")[single.overturned]
        assert table["overturned_joint"][k] == single.overturned_joint
        if single.overturned:
            assert table["overturn_time"][k] == pytest.approx(single.overturn_time, abs=1e-6)
        else:
            largest = float(np.max(single.peak_ux))
            assert table["residual_ux"][k] == pytest.approx(single.ux[-1], abs=1e-5 * largest)


def test_what_comes_of_a_run_depends_on_no_other_nor_on_order_and_threads() -> None:
    columns, motions, durations = eleven()
    together = simulate_many(columns, motions, duration=durations, keep=KEEP)
    order = np.random.default_rng(1).permutation(len(columns))
    shuffled = simulate_many(
        [columns[k] for k in order], [motions[k] for k in order], duration=[durations[k] for k in order], keep=KEEP,
        threads=2,
    )  # fmt: skip
    for place, k in enumerate(order):
        alone = simulate_many(columns[k], motions[k], duration=durations[k], keep=KEEP)
        for name in KEEP:
            assert np.array_equal(together[name][k], shuffled[name][place], equal_nan=name not in ("verdict", "path"))
            assert np.array_equal(together[name][k], alone[name][0], equal_nan=name not in ("verdict", "path"))


def test_one_block_and_a_run_that_cannot_go_on() -> None:
    """The sweeps of a motion beyond any first-order model do not settle; the run beside it is unaffected."""
    motions = [Motion.harmonic(0.1 * G, 2.0, 0.2), Motion.harmonic(1e5 * G, 50.0, 0.2)]
    table = simulate_many(swept(monolith(eta=1e-3)), motions, keep=("peak_ux", "verdict"))
    single = simulate(swept(monolith(eta=1e-3)), motions[0])
    assert table["peak_ux"][0] == pytest.approx(single.peak_ux, rel=1e-6)
    assert table["verdict"][0] == single.verdict


def test_the_papers_formulation_at_other_steps_is_not_in_lanes() -> None:
    table = simulate_many(phocas(1e-3, formulation="paper"), [Motion.harmonic(0.02 * G, 2.0, 0.1)] * 2)
    assert table.stats["why_scalar"] == {"formulation paper with the integrator auto": 2}
