"""The truths that cases compare with: Housner's block against closed forms of others."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import arch
from solver import Block, Column, Joint
from solver.statics.rocking import restitution

sys.path.insert(0, str(ROOT))  # the cases are not installed

from validation.cases.closed_forms import COLUMNS, similar
from validation.cases.free_rocking import EDGES, FULL, block, housner
from validation.cases.housner import decay, peaks_of, quarter_period
from validation.cases.overturning import around, edges
from validation.cases.reference_study import FRICTION, round_and_sliding
from validation.cases.structures import by_ratio, extrapolated, largest_steady_push, pushed
from validation.limits import largest_push
from validation.rigid_block import overturning


# amplitude over alpha g: falls without an impact from, with one impact (restitution 0.9) from; closed forms, to 1e-4
@pytest.mark.parametrize(
    ("speed", "without", "with_one"),
    [(1.0, 1.4183, 1.1320), (2.0, 2.3499, 1.2252), (4.0, 5.2390, 1.7954), (6.0, 9.4170, 5.1642)],
)
def test_a_slender_rigid_block_falls_at_the_closed_forms(speed: float, without: float, with_one: float) -> None:
    # just below and above each closed form; the integration errs by less than 2e-4
    amplitude = np.array([with_one - 3e-4, with_one + 3e-4, without + 3e-4, without + 0.2])
    impacts = overturning(amplitude, np.full(4, speed), 0.01, 0.9, slender=True)
    assert impacts.tolist() == [-1, 1, 0, 0]


def test_a_pulse_that_cannot_lift_the_block_leaves_it() -> None:
    assert overturning(np.array([0.5, 1.0]), np.array([1e-2, 1e-2]), 0.2, 0.9).tolist() == [-1, -1]


def test_quarter_periods_are_those_of_exact_angles() -> None:
    alpha, p = 0.110423, 1.019371  # printed to 5 digits
    for part, known in ((0.1, 0.45866), (0.5, 1.29239), (0.9, 2.93661)):
        assert quarter_period(part * alpha, alpha, p) == pytest.approx(known, abs=2e-5)


def test_decay_is_that_of_housner() -> None:
    assert decay(0.5, 0.936, 4, 1e-3) == pytest.approx(
        [0.4144, 0.3486, 0.2960, 0.2529], abs=5e-5
    )  # printed to 4 digits


def test_peaks_between_zeros() -> None:
    time = np.linspace(0.0, 2.0, 2001)
    theta = np.exp(-time) * np.cos(2.0 * np.pi * time)  # peaks every half a second, the last one unfinished
    assert peaks_of(theta) == pytest.approx(np.exp(-0.5 * np.arange(4)), rel=0.02)  # damping moves them by 1 %


def test_edges_of_a_line_of_the_map() -> None:
    amplitudes = np.array([1.0, 2.0, 3.0, 4.0])
    assert edges(np.array([False, True, True, False]), amplitudes) == [1.5, 3.5]
    assert around([2.0])[[0, -1]] == pytest.approx([1.6, 2.16], abs=0.021)


def test_a_similar_column_has_the_same_material() -> None:
    column = Column("one", (Block(2.0, 1.0, 1.0, 5000.0, Joint(1e9, 1e-3)),))
    block = similar(column, 0.25).blocks[0]
    assert (block.height, block.mass / (block.height * block.width * block.depth)) == pytest.approx((0.5, 2500.0))
    assert (block.joint.stiffness, block.joint.damping) == pytest.approx((1e9, 1e-3 * math.sqrt(0.25)))


def test_a_face_that_bears_at_its_edges_loses_as_much_as_housner() -> None:
    width, height = 0.365, 1.0  # m: alpha 0.35
    rigid = housner(math.atan(width / height))
    everywhere, edges_alone = (restitution(block(width, height, 1e11, 0.1, face)) for face in (FULL, EDGES))
    assert edges_alone == pytest.approx(rigid, rel=0.04)  # 0.02 to 0.03 above
    assert everywhere > 1.07 * rigid  # 0.09 above: the contact rolls from edge to edge


def test_round_drums_keep_their_mass_and_modulus() -> None:
    column = Column.from_toml(COLUMNS / "pronaos.toml")
    drums = round_and_sliding(column).blocks
    assert [drum.mass for drum in drums] == [block.mass for block in column.blocks]
    assert all(drum.joint.friction == FRICTION and drum.section == "circle" for drum in drums)
    pairs = zip(drums, column.blocks, strict=True)
    areas = [0.25 * math.pi * drum.width**2 / (old.width * old.depth) for drum, old in pairs]
    assert areas == pytest.approx(np.ones(len(areas)), rel=1e-3)  # depths of the file have four digits


def _semicircle_stands(thickness: float) -> bool:
    return math.isfinite(largest_push(arch(60, 10.0, 10.0 * thickness, 1.0, {"stiffness": 1e10, "damping": 1e-3})))


def test_limit_analysis_has_the_thickness_of_milankovitch() -> None:
    # 0.1075 of a continuous arch; 60 voussoirs with hinges at their joints alone: 0.10745
    assert not _semicircle_stands(0.1070)
    assert _semicircle_stands(0.1076)


def test_an_arch_on_soft_joints_gives_way_below_limit_analysis() -> None:
    limit, (soft, stiff) = largest_push(pushed(1e10)), map(largest_steady_push, (1e9, 1e10))
    assert 0.75 * limit < soft < stiff < limit  # measured 0.78, 0.89


def test_extrapolation_is_exact_for_what_goes_as_one_over_the_root() -> None:
    assert extrapolated((1e9, 1e11), [3.0 + 1e-1, 3.0 + 1e-2]) == pytest.approx(3.0, abs=1e-12)
    assert by_ratio([3.0 + 0.4**i for i in range(4)]) == pytest.approx(3.0, abs=1e-12)
