"""Ensembles of runs with varied data: shares, bounds and percentiles, in lanes and one by one."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import beta
from support.batches import run_batch
from support.probe import G, phocas

from solver import Block, Column, InitialState, InputError, Joint, Motion, Spread, simulate
from solver.commands.outcome import ensemble_lines
from solver.models.column.kinematics import chain_of
from solver.models.uncertainty import Ensemble, share_bounds, vary

MOTION = Motion.harmonic(0.05 * G, 2.0, 4.0)


def ensemble_of(*arguments: object, **options: object) -> Ensemble:
    found = simulate(*arguments, **options).ensemble  # type: ignore[call-overload]
    assert found is not None
    return found


@pytest.mark.parametrize(("count", "size"), [(0, 8), (1, 8), (8, 8), (3, 64), (517, 1000)])
def test_bounds_are_those_of_clopper_and_pearson(count: int, size: int) -> None:
    low = 0.0 if count == 0 else beta.ppf(0.025, count, size - count + 1)
    high = 1.0 if count == size else beta.ppf(0.975, count + 1, size - count)
    assert share_bounds(count, size) == pytest.approx((low, high), abs=1e-10)


def test_lanes_say_what_single_runs_say() -> None:
    """Check that an initial state that is rest keeps the runs out of the lanes."""
    column = phocas(1e-3)
    eight, alone = ensemble_of(column, MOTION, ensemble=8), ensemble_of(
        column, MOTION, ensemble=8, initial=InitialState()
    )  # fmt: skip
    assert (eight.in_lanes, alone.in_lanes) == (True, False)
    assert eight.verdicts == alone.verdicts
    assert eight.displacements == pytest.approx(alone.displacements, rel=1e-5)  # the tolerance
    assert eight.ux == pytest.approx(alone.ux, abs=1e-5 * np.max(alone.displacements))  # the tolerance
    assert eight.amplification == pytest.approx(alone.amplification, rel=1e-2)


def test_rows_closer_than_steps_are_those_of_a_single_run() -> None:
    """Check that several rows are in one step; the last instant is requested twice."""
    column, motion = phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 0.5)
    run = simulate(column, motion, tolerance=1e-6, output_step=5e-5, without=("peaks",))
    batch = run_batch([run.model] * 2, [motion] * 2, [1.0] * 2, times=np.append(run.time, run.time[-1]))
    assert 3 * batch.steps[0] < len(run.time)
    for phases in batch.phases:
        ux = chain_of(run.model).top_displacements(phases)
        assert ux[:-1] == pytest.approx(run.ux, abs=1e-5 * np.max(np.abs(run.ux)))  # 10 tolerances
        assert np.array_equal(ux[-1], ux[-2])


def test_runs_that_fall_after_the_motion_are_said_to() -> None:
    column, motion = phocas(1e-3), Motion.harmonic(0.1416 * G, 0.5, 10.0)
    run = simulate(column, motion, tolerance=1e-4, ensemble=8, spread=Spread(0.0, 0.0, 1e-9))
    assert run.overturn_time > 12.0
    assert run.ensemble is not None
    assert set(run.ensemble.verdicts) == {"overturned"}
    assert run.ensemble.overturn_time == pytest.approx(run.overturn_time, abs=0.01)


def test_columns_in_mortar_run_one_by_one() -> None:
    """Check that their dampers make explicit steps short, and lanes have no others."""
    run = simulate(phocas(0.05), Motion.harmonic(0.2 * G, 1.5, 2.0), ensemble=2)
    assert run.stats["implicit_steps"] > 0
    assert run.ensemble is not None
    assert not run.ensemble.in_lanes


def test_the_papers_formulation_has_its_ensembles() -> None:
    found = ensemble_of(phocas(1e-3), MOTION, duration=0.5, ensemble=3, formulation="paper", step=2e-4)
    assert (found.in_lanes, found.size) == (False, 3)
    assert np.all(found.displacements > 0.0)


def test_percentiles_are_those_of_the_runs() -> None:
    found = ensemble_of(phocas(1e-3), MOTION, ensemble=5, initial=InitialState())
    column = phocas(1e-3)
    rng = np.random.default_rng(0)
    runs = [simulate(*vary(column, MOTION, Spread(), rng)) for _ in range(5)]
    assert np.array_equal(found.displacements, [run.peak_top_ux for run in runs])
    points = np.percentile([run.displacements for run in runs], (16, 50, 84), axis=0)
    assert found.peaks == pytest.approx(points, rel=1e-14)
    assert found.ux == pytest.approx(np.percentile([run.ux for run in runs], (16, 50, 84), axis=0), abs=1e-15)


def test_what_varies_is_what_is_asked_for() -> None:
    column = phocas(1e-3)
    rng = np.random.default_rng(0)
    varied = [vary(column, MOTION, Spread(0.2, 0.1, 0.05), rng) for _ in range(2000)]
    joints = [block.joint for found, _ in varied for block in found.blocks]
    for values, mean, size in (
        ([joint.stiffness for joint in joints], column.blocks[0].joint.stiffness, 0.2),
        ([joint.damping for joint in joints], 1e-3, 0.1),
        ([motion.amplitude for _, motion in varied], MOTION.amplitude, 0.05),
    ):
        logarithms = np.log(np.array(values) / mean)
        assert np.std(logarithms) == pytest.approx(size, rel=0.1)
        assert np.mean(logarithms) == pytest.approx(0.0, abs=4.0 * size / math.sqrt(2000))
    assert (
        ensemble_of(column, MOTION, duration=0.5, ensemble=2, spread=Spread(0.0, 0.0, 0.0))
        .displacements.std(axis=0)
        .max()
        == 0.0
    )


def test_a_seed_is_an_ensemble() -> None:
    one, same, other = (
        ensemble_of(phocas(1e-3), MOTION, duration=1.0, ensemble=9, spread=Spread(seed=seed)) for seed in (1, 1, 2)
    )
    assert np.array_equal(one.displacements, same.displacements)
    assert not np.any(one.displacements == other.displacements)


@pytest.mark.long  # takes seconds
def test_shares_near_the_edge_contain_that_of_many_runs() -> None:
    """Check a pulse about the least that overturns: the share of 400 runs is within the bounds that 8 and 64 give."""
    time = np.linspace(0.0, 1.0, 101)
    pulse = Motion.from_samples(0.01, 0.229 * G * np.sin(math.pi * time))

    def runs(size: int, seed: int) -> Ensemble:
        spread = Spread(motion=0.05, seed=seed)
        return ensemble_of(phocas(5e-3), pulse, ensemble=size, tolerance=1e-4, output_step=0.1, spread=spread)

    many = runs(400, 0)
    assert 0.2 < many.share < 0.8
    for size in (8, 64):
        low, high = runs(size, 7).share_bounds
        assert low < many.share < high
    falls = np.array([verdict == "overturned" for verdict in many.verdicts])
    assert np.array_equal(falls, np.isfinite(many.overturn_time))
    assert np.all(many.overturn_time[falls] > 1.0)  # after the pulse


def test_percentiles_are_of_the_runs_that_stand() -> None:
    found = ensemble_of(phocas(1e-3), Motion.harmonic(0.1 * G, 0.25, 12.0), ensemble=8, output_step=0.01)
    assert found.overturned == 8
    assert np.all(np.isnan(found.peaks))
    assert "nan" not in "".join(ensemble_lines(found, [1, 2], "ux"))  # no table
    assert math.isnan(found.amplification)
    first, last = np.min(found.overturn_time), np.max(found.overturn_time)
    time = 0.01 * np.arange(1201)
    assert np.all(np.isfinite(found.ux[:, time < first]))
    assert np.all(np.isnan(found.ux[:, time > last]))


def test_ensembles_are_written(tmp_path: Path) -> None:
    run = simulate(phocas(1e-3), MOTION, duration=0.5, ensemble=3)
    assert run.ensemble is not None
    run.to_csv(tmp_path / "run.csv", digits=17)
    with open(tmp_path / "run.csv", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    for k, percent in enumerate((16, 50, 84)):
        column = header.index(f"ensemble.block[2].ux.p{percent}")
        assert np.array_equal([float(row[column]) for row in rows], run.ensemble.ux[k, :, 1])


@pytest.mark.parametrize("spread", [{"stiffness": -0.1}, {"damping": math.nan}, {"motion": 2.0}, {"seed": -1}])
def test_a_spread_that_makes_no_sense_is_refused(spread: dict[str, float]) -> None:
    with pytest.raises(InputError, match=f"spread.{next(iter(spread))} = "):
        Spread(**spread)  # type: ignore[arg-type]


@pytest.mark.parametrize("size", [-1, 1.5, 10**9])
def test_an_ensemble_of_no_number_is_refused(size: int) -> None:
    with pytest.raises(InputError, match="ensemble = "):
        simulate(phocas(1e-3), MOTION, ensemble=size)


@pytest.mark.parametrize("initial", [None, InitialState()])
def test_a_varied_column_without_a_rest_falls_at_once(initial: InitialState | None) -> None:
    """Check a block whose modulus is just above that at which it does not stand: in lanes, and from any state alone."""
    weight, inertia = 2000.0 * 0.16 * G, 0.2**4 / 12.0
    tall = Column("tall", (Block(4.0, 0.2, 0.2, 320.0, Joint(1.05 * weight * 2.0 / inertia, 2e-3)),))
    slow = Motion.from_samples(0.5, [0.0, 1e-6, 0.0])
    found = ensemble_of(tall, slow, ensemble=8, initial=initial, spread=Spread(stiffness=0.2, damping=0.0, motion=0.0))
    at_once = found.overturn_time == slow.start
    # a given state needs no rest
    assert np.sum(at_once) == (3 if initial is None else 0)
