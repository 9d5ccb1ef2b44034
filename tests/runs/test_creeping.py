"""Columns that may slide and still rock: how far it may creep, and with how much energy it cannot fall from there."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from support.barriers import barrier
from support.probe import G, monolith, phocas, settled

from solver import Column, InitialState, Motion, simulate
from solver.models.column.kinematics import Chain
from solver.models.column.leaning import PARTS, least_energy
from solver.models.column.run import phase_of
from solver.models.column.stepper import Stepper
from solver.models.column.verdict import (
    CREEPS,
    CREEPS_UNDER,
    cannot_creep_to_fall,
    cannot_fall,
    on_its_axis,
    remaining_lever_fraction,
)


def rough(column: Column, friction: float | None, offsets: np.ndarray | None = None, **others: float) -> Column:
    """Return the column with these joints."""
    shifts = np.zeros(column.n) if offsets is None else offsets
    blocks = (
        replace(
            block,
            joint=replace(block.joint, friction=friction, offset=float(shift) or None, **others),  # type: ignore[arg-type]
        )
        for block, shift in zip(column.blocks, shifts, strict=True)
    )
    return replace(column, blocks=tuple(blocks))


def spinning(column: Column, spin: np.ndarray, energy: float) -> np.ndarray:
    """Return a phase at the upright rest, all slips zero, that turns with this energy, J, in the direction `spin`."""
    n, zeros = column.n, np.zeros(column.n)
    phase = np.concatenate([zeros, -settled(column), spin, *(zeros,) * 3])
    phase[2 * n : 3 * n] *= math.sqrt(energy / Chain(column).energy(phase))
    return phase


def test_a_block_may_slide_by_its_energy_over_the_friction() -> None:
    column = rough(monolith(eta=1e-3), 0.4)
    weight, half = 81000.0 * G, 0.78
    assert remaining_lever_fraction(column, np.array([-0.1]), 0.0) == pytest.approx(1.0 - 0.1 / half, rel=1e-12)
    reach = 2000.0 / (CREEPS_UNDER * 0.4 * weight)
    assert remaining_lever_fraction(column, np.array([0.1]), 2000.0) == pytest.approx(
        1.0 - (0.1 + reach) / half, rel=1e-12
    )
    pinned = rough(monolith(eta=1e-3), 1e-6, dowel=5e4)
    assert remaining_lever_fraction(pinned, np.zeros(1), 2000.0) == pytest.approx(1.0 - 2000.0 / 5e4 / half, rel=1e-6)
    assert remaining_lever_fraction(column, np.array([0.8]), 0.0) == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_levers_that_slips_have_shortened_hold_no_more_than_the_least_energy_there(seed: int) -> None:
    """Compare with the least energy of the column that stands off its axis by these slips, on a grid (leaning.py)."""
    rng = np.random.default_rng(seed)
    column = phocas(1e-3)
    slips = rng.uniform(-0.3, 0.3, 3) * 0.78 * rng.uniform(0.1, 1.0)
    moved = rough(column, None, slips)
    above = max(least_energy(moved, part)[0] for part in PARTS)
    left = remaining_lever_fraction(rough(column, 0.6), slips, 0.0)
    assert CREEPS * left**2 * barrier(column).energy < above


def test_a_column_with_less_energy_than_it_may_have_does_not_fall() -> None:
    """Push it in random directions, as hard as is allowed, with friction that lets it slide."""
    rng = np.random.default_rng(5)
    slid = 0
    for friction in (0.12, 0.3, 0.7):
        column = rough(phocas(0.0, tolerance=1e-4), friction)
        for _ in range(4):
            spin = rng.normal(size=3)
            low, high = 0.0, barrier(phocas()).energy
            for _ in range(20):
                middle = 0.5 * (low + high)
                held = cannot_creep_to_fall(column, spinning(column, spin, middle))
                low, high = (middle, high) if held else (low, middle)
            assert low > 0.0
            phase = spinning(column, spin, 0.999 * low)
            start = InitialState(rotation_rate=phase[6:9])
            run = simulate(column, Motion.harmonic(1e-9, 1.0, 8.0), initial=start, output_step=0.1)
            assert run.verdict == "standing"
            slid += bool(np.max(np.abs(run.slip)) > 1e-5)
    assert slid >= 4


def test_a_column_that_rocks_with_friction_is_soon_known_to_stand() -> None:
    """Check that it is known before no joint can open any more, 140 s later."""
    run = simulate(rough(phocas(1e-3), 0.7), Motion.harmonic(0.15 * G, 1.0, 10.0))
    assert run.verdict == "standing"
    assert run.stats["settled_for"] < 10.0


def test_an_inclined_joint_is_not_judged_by_energy() -> None:
    leaning = rough(phocas(1e-3), 0.6, inclination=0.01)
    assert on_its_axis(leaning) is None
    assert not cannot_creep_to_fall(leaning, phase_of(Stepper(leaning)))
    assert cannot_fall(leaning, phase_of(Stepper(leaning)))  # it sticks
