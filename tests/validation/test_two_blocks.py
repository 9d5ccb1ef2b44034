"""The rigid truth of two blocks: its energy, and the single block that it becomes."""

from __future__ import annotations

import math
import sys
from dataclasses import replace

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the cases are not installed

from validation.cases.housner import quarter_period
from validation.cases.two_blocks import LOWER, MODULI, PATTERNS, UPPER, landing, released, tilts
from validation.two_blocks import G, Pair


@pytest.mark.parametrize("sides", PATTERNS.values(), ids=PATTERNS)
def test_energy_is_kept(sides: tuple[int, int]) -> None:
    pair = Pair(LOWER, UPPER, sides)
    time, angles = pair.released(*tilts())
    rates = np.gradient(angles, time, axis=0, edge_order=2)
    first, later = pair.energy(angles[0], np.zeros(2)), pair.energy(angles[-10], rates[-10])
    still = pair.energy(angles[-10], np.zeros(2))
    assert later == pytest.approx(first, abs=1e-3 * (first - still))  # measured 2e-5: rates by differences


def test_under_a_block_without_mass_the_lower_one_is_housners() -> None:
    pair = Pair(LOWER, replace(UPPER, mass=1e-9), (1, 1))
    tilt, _ = tilts()
    time, _ = pair.released(tilt, 0.4)
    alpha, half = math.atan(LOWER.width / LOWER.height), 0.5 * math.hypot(LOWER.width, LOWER.height)
    assert time[-1] == pytest.approx(quarter_period(tilt, alpha, math.sqrt(0.75 * G / half)), rel=1e-8)


@pytest.mark.parametrize("sides", PATTERNS.values(), ids=PATTERNS)
def test_stiff_blocks_land_as_rigid_ones(sides: tuple[int, int]) -> None:
    pair = Pair(LOWER, UPPER, sides)
    time, _ = pair.released(*tilts())
    end = float(time[-1])
    assert landing(*released(MODULI[1], pair, 1.2 * end), pair) == pytest.approx(end, rel=5e-3)  # 3e-3, 9e-4
