"""Columns whose joints slide, or that are off their axis, eight at once: closed forms, `simulate`, the same bits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, sin
from pathlib import Path

import numpy as np
import pytest
from support.columns import flat_block, off_axis_column, shaken, sliding_column
from support.lanes import (
    accelerating,
    assert_nothing_depends_on_the_others,
    assert_sliding_accelerations_are_those_of_each,
    assert_the_tolerance_is_kept,
)
from support.probe import G, monolith, phocas

from solver import Block, Column, InputError, Joint, Motion, Settings, simulate, simulate_many
from solver.dynamics.kinematics import Chain
from solver.kernels.batch.runs import SLIPPING_SPACE
from solver.runs.batch import run_batch
from solver.runs.single_run import single_run

# --- accelerations


accelerate_lanes = accelerating(SLIPPING_SPACE)


@pytest.mark.parametrize("make", [sliding_column, off_axis_column])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_accelerations_are_those_of_each_column(make: Callable[[np.random.Generator, int], Column], n: int) -> None:
    assert_sliding_accelerations_are_those_of_each(make, n, SLIPPING_SPACE, accelerate_lanes)


# --- closed forms


@pytest.mark.long  # compiles the lanes, as all below
def test_newmarks_sliding_block_under_a_triangular_pulse() -> None:
    """The block lags behind from where the base exceeds mu g until it has caught up with it."""
    a, half = 0.6 * G, 0.1  # the base accelerates up to a within 0.1 s, and down to nothing in as many
    motion = Motion.from_samples(half, [0.0, a, *[0.0] * 5])
    coefficients = (0.15, 0.2, 0.3)
    result = run_batch([flat_block(mu, tolerance=1e-5) for mu in coefficients], [motion] * 3)
    for k, mu in enumerate(coefficients):
        begin = half * mu * G / a
        slow, fast = 0.5 * a * begin**2 / half, a * half
        lasts = (fast - slow) / (mu * G)  # until both are equally fast again
        base = a * (half**3 - begin**3) / (6.0 * half) + 5.0 / 6.0 * a * half**2 + fast * (begin + lasts - 2.0 * half)
        assert begin + lasts > 2.0 * half
        block = slow * lasts + 0.5 * mu * G * lasts**2
        assert result.ends[k, 4] == pytest.approx(block - base, rel=1e-3)  # of the elastic bed
        assert result.ends[k, 5] == 0.0


@pytest.mark.long
def test_on_an_inclined_joint() -> None:
    angle = 0.3
    blocks = [Block(0.5, 2.0, 1.0, 2000.0, Joint(5e8, 1e-3, friction=mu, inclination=angle)) for mu in (0.1, 0.2, 0.4)]
    columns = [Column("plane", (block,), Settings(tolerance=1e-6)) for block in blocks]
    result = run_batch(columns, [Motion.from_samples(0.01, np.zeros(101))] * 3)
    for k, mu in enumerate((0.1, 0.2)):
        assert result.ends[k, 4] == pytest.approx(0.5 * G * (sin(angle) - mu * cos(angle)), rel=2e-3)  # after 1 s
    assert result.ends[2, 4] == 0.0


# --- beside single runs


@pytest.mark.long
@pytest.mark.parametrize("off_axis", [False, True])
@pytest.mark.parametrize("n", [1, 3])
def test_the_tolerance_is_kept_within_ten_times(n: int, off_axis: bool, records: Path) -> None:
    assert_the_tolerance_is_kept(*shaken(1, n, 8, off_axis, records), tame=6, slid=3)


@pytest.mark.long
def test_an_ordinary_column_whose_friction_is_never_reached_has_the_bits_of_ordinary_lanes() -> None:
    motions = [Motion.harmonic(0.06 * G, f, 2.0) for f in (1.3, 2.0, 2.4)]
    column = phocas(1e-3)
    rough = replace(
        column, blocks=tuple(replace(block, joint=replace(block.joint, friction=9.0)) for block in column.blocks)
    )
    plain, slipping = (run_batch([made] * 3, motions, tolerance=1e-4) for made in (column, rough))
    assert np.array_equal(plain.steps, slipping.steps)
    assert np.array_equal(plain.peak_ux, slipping.peak_ux)
    assert np.array_equal(plain.ends, slipping.ends[:, :12])


@pytest.mark.long
def test_what_comes_of_a_run_depends_on_no_other_nor_on_order_and_threads() -> None:
    columns, motions = [], []
    for seed in range(11):
        rng = np.random.default_rng(seed)
        joints = [Joint(1e9, 2e-3, friction=rng.uniform(0.1, 0.3), offset=0.05 if seed % 3 == 0 else None)] * 2
        columns.append(Column("two", tuple(Block(1.0, 1.0, 1.0, 2400.0, joint) for joint in joints)))
        motions.append(Motion.harmonic(rng.uniform(0.2, 0.5) * G, rng.uniform(1.0, 3.0), 1.0 + 0.1 * seed))
    together = assert_nothing_depends_on_the_others(columns, motions)
    assert np.count_nonzero(np.abs(together.ends[:, 8]) > 1e-3) > 5  # they slide


@pytest.mark.long
def test_many_runs_and_ensembles_are_made_in_lanes() -> None:
    top = Block(1.2, 0.8, 0.8, 1800.0, Joint(4e8, 3e-3, friction=0.25))
    low = Block(1.5, 1.0, 1.0, 3500.0, Joint(6e8, 3e-3, friction=0.3, offset=0.02))
    column = Column("two", (top, low), Settings(tolerance=1e-5))
    motions = [Motion.harmonic(a * G, 2.0, 1.0) for a in (0.3, 0.46, 0.6)]
    keep = ("peak_ux", "residual_ux", "residual_slip", "residual_theta", "energy", "verdict", "path")
    table = simulate_many([column, phocas(1e-3), column, column], [motions[0], *motions], keep=keep, settle=0.0)
    assert list(table["path"]) == ["lanes"] * 4
    for k, motion in ((0, motions[0]), (2, motions[1]), (3, motions[2])):
        single = simulate(column, motion, tolerance=1e-8, settle=0.0)
        largest = np.max(single.peak_ux)
        assert table["verdict"][k] == single.verdict
        for name, expected in (("peak_ux", single.peak_ux), ("residual_ux", single.ux[-1])):
            assert table[name][k, :2] == pytest.approx(expected, abs=1e-3 * largest), name
        assert table["residual_slip"][k, :2] == pytest.approx(single.slip[-1], abs=1e-3 * largest)
    found = simulate(column, motions[0], ensemble=3, settle=0.0).ensemble
    assert found is not None
    assert found.in_lanes


@pytest.mark.long
def test_columns_with_slips_and_without_are_no_batch() -> None:
    with pytest.raises(InputError, match=r"columns\[1\]: must slide or be off its axis as all others"):
        run_batch([flat_block(), monolith()], [Motion.harmonic(1.0, 2.0, 0.1)] * 2)


@pytest.mark.long
def test_columns_that_begin_by_modes_go_on_in_lanes_once_they_open_or_slide() -> None:
    """Off the axis or on it, in contact all the time, opening by resonance, sliding below that."""
    motions = [Motion.harmonic(a * G, f, 3.0) for a, f in ((0.004, 2.0), (0.03, 2.0), (0.03, 2.0), (0.03, 2.9))]
    columns = []
    for offset, friction in ((0.05, None), (0.05, 0.7), (0.05, 0.02), (None, 0.025)):
        joint = replace(phocas(1e-3).blocks[0].joint, offset=offset, friction=friction)
        column = phocas(1e-3)
        columns.append(replace(column, blocks=(replace(column.blocks[0], joint=joint), *column.blocks[1:])))
    times = np.linspace(0.0, 2.9, 30)
    slid = []
    for tolerance in (1e-3, 1e-5):
        result = run_batch(columns, motions, tolerance=tolerance, times=times)
        for k, (column, motion) in enumerate(zip(columns, motions, strict=True)):
            truth, phases = single_run(column.with_settings(tolerance=1e-10), motion, 3.0, times, None, 0.0)
            size = np.max(np.abs(truth.peak_ux))
            tops = Chain(column).top_displacements(result.phases[k]) - Chain(column).top_displacements(phases)
            slips = result.phases[k][:, 12:15] - phases[:, 12:15]
            assert max(np.max(np.abs(tops)), np.max(np.abs(slips))) < 2.0 * tolerance * size  # measured 0.14
            slid.append(np.ptp(phases[:, 12]) > 1e-4)
    assert slid == 2 * [False, False, True, True]
    assert result.steps[0] < 300  # by modes, 123; explicit ones are 1,000
    assert_nothing_depends_on_the_others(columns, motions)
