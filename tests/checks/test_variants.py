"""Variants of a check: pairs of runs, bounds of their mean difference, and the sentence."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from multiblock import Block, Column, Joint, check, wavelets
from solver.checks.check import Check
from solver.checks.limits import Plan
from solver.checks.variants import POINTS, _bounded, described, difference, mean_bounds, pairs_of, student

G = 9.80665
MOTIONS = {f"{frequency} Hz": wavelets.ricker(0.35 * G, frequency) for frequency in (0.8, 1.0, 1.2, 1.5)}


def checked(name: str, width: float) -> Check:
    block = Block(2.0, width, 1.0, 5000.0, Joint(stiffness=2e9, damping=2e-3))
    return check(Column(name, (block,)), MOTIONS, plan=Plan(ensemble=4, margin=False, joints=False))


@pytest.fixture(scope="module")
def given() -> Check:
    return checked("given", 0.6)


def test_quantiles_of_student() -> None:
    """Compare with known quantiles: measured 3e-9 with 10,000 strips up to 100 degrees of freedom."""
    for free in (1, 2, 6, 30, 100):
        assert student(free) == pytest.approx(stats.t.ppf(0.975, free), rel=1e-6)


def test_bounds_contain_the_mean_as_often_as_they_say() -> None:
    """Check that of 4000 draws of seven numbers 95 % +- 1 % (three standard deviations) have the true mean within the
    bounds.
    """
    draws = np.random.default_rng(5).normal(0.3, 2.0, (4000, 7))
    hit = [low <= 0.3 <= high for low, high in map(mean_bounds, draws)]
    assert np.mean(hit) == pytest.approx(0.95, abs=0.0104)


def test_pairs_that_say_nothing_are_left_out() -> None:
    one, other = np.array([[3.0, np.nan], [np.nan, np.nan], [4.0, 6.0]]), np.ones((3, 2))
    np.testing.assert_array_equal(pairs_of(one, other), [2.0, 4.0])
    np.testing.assert_array_equal(pairs_of(one[:1], other[:1]), [2.0])  # of one motion each pair is a trial


def test_equal_differences_have_no_bounds() -> None:
    """Check that trials without spread, from which Student's bounds would have no width, give none."""
    assert _bounded("fewer", np.array([-1.0, -1.0]), POINTS, "motions") == (
        "fewer (no bounds, all differ by the same, 2 motions)",
        "better",
    )
    assert "percentage points at 95 % confidence" in _bounded("fewer", np.array([-1.0, -0.5]), POINTS, "motions")[0]


def test_a_column_against_itself_cannot_be_distinguished(given: Check) -> None:
    assert "against given: cannot be distinguished. It moves 0 mm more (+0 to +0 mm" in difference(given, given)


def test_wider_is_better_and_narrower_worse(given: Check) -> None:
    wider = "wider (block[1].width 0.6 to 0.75) against given: better. "
    assert difference(given, checked("wider", 0.75)).startswith(wider)
    narrow = difference(given, checked("narrow", 0.3))
    assert narrow.startswith("narrow (block[1].width 0.6 to 0.3) against given: worse. ")
    fell = [int(count) for count in re.findall(r"runs fall: (\d+) of 20 instead of (\d+)", narrow)[0]]
    assert f"{5 * (fell[0] - fell[1]):.3g} percentage points more runs fall" in narrow


def test_changes_of_several_blocks_are_said_once() -> None:
    block = Block(1.0, 1.0, 1.0, 2000.0, Joint(stiffness=2e9, damping=2e-3))
    rough = replace(block, joint=replace(block.joint, friction=0.7))
    plain, sliding = Column("plain", (block,) * 3), Column("sliding", (rough,) * 3)
    assert described(plain, sliding) == "block.joint.friction none to 0.7, 3 times"
    assert described(plain, Column("one", (rough, block, block))) == "block[1].joint.friction none to 0.7"
    assert described(plain, plain) == ""
    assert described(plain, Column("two", (block,) * 2)) == "2 blocks in place of 3"


def test_the_governing_run_says_which_it_is_and_what_counts(given: Check) -> None:
    said, place = given.governing_sentence, given.governing
    assert said.startswith(f"The run of the column as described under {given.action.motions[place].name}: ")
    (row,) = (row for row in given.rows if row.name == "displacement of the top")
    assert row.demand == pytest.approx(row.values[place])
    assert "this motion moves it most" in said
