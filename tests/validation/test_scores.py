"""Agreement, logarithmic score, halves, fragility: on verdicts drawn from known shares."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the cases are not installed

from validation import scores
from validation.cases.shaken_rocks import DEVIATIONS, MEDIANS, RATIOS, Model, ensembles, judge, judge_lognormal

PGV = np.geomspace(0.02, 0.8, 400)  # m/s


@pytest.fixture
def fallen() -> np.ndarray:
    return np.random.default_rng(5).random(len(PGV)) < scores.lognormal(PGV, 0.15, 0.4)


def test_halves_share_nothing_and_are_alike(fallen: np.ndarray) -> None:
    splits = list(scores.halves(fallen, 3, 1))
    for fit, held in splits:
        assert np.array_equal(np.sort(np.concatenate([fit, held])), np.arange(len(fallen)))
        assert abs(int(fallen[fit].sum()) - int(fallen[held].sum())) <= 1
    assert not np.array_equal(splits[0][0], splits[1][0])
    again = list(scores.halves(fallen, 3, 1))
    assert all(np.array_equal(a[0], b[0]) for a, b in zip(splits, again, strict=True))


def test_the_logarithmic_score_rewards_the_true_share() -> None:
    rng = np.random.default_rng(2)
    outcome = rng.random(20000) < 0.3
    score = {share: float(scores.log_score(np.full(20000, share), outcome)) for share in (0.2, 0.3, 0.4)}
    assert max(score, key=score.__getitem__) == 0.3
    assert score[0.3] == pytest.approx(0.3 * np.log(0.3) + 0.7 * np.log(0.7), abs=0.01)  # sampling: 0.003


def test_the_lognormal_curve_is_found_again(fallen: np.ndarray) -> None:
    median, deviation = scores.lognormal_fit(PGV, fallen)
    assert median == pytest.approx(0.15, rel=0.12)  # 400 tests: standard error 4 %
    assert deviation == pytest.approx(0.4, rel=0.35)  # 12 %


def test_bounds_hold_a_share_and_do_not_leave_0_and_1() -> None:
    low, high = scores.bounds(np.array([0.0, 5.0, 10.0]), np.full(3, 10.0))
    assert np.all((low >= -1e-12) & (high <= 1.0 + 1e-12))
    assert (low[1], high[1]) == pytest.approx((0.2366, 0.7634), abs=1e-4)  # Wilson's for 5 of 10


def test_bins_count_every_test(fallen: np.ndarray) -> None:
    rows = scores.binned(PGV, np.array([0.0, 0.1, 0.3, 1.0, 2.0]), np.full(len(PGV), 0.5), fallen)
    assert len(rows) == 3  # the last is empty
    assert rows[:, 0].sum() == len(PGV)
    assert rows[:, 2].sum() == fallen.sum()


def test_the_true_model_is_chosen_and_judged_on_what_was_not_fitted(fallen: np.ndarray) -> None:
    truth = scores.lognormal(PGV, 0.15, 0.4)
    result = judge(np.array([np.full(len(PGV), 0.5), truth, 1.0 - truth]), ["coin", "truth", "reverse"], fallen)
    assert set(result.chosen) == {"truth"}
    assert result.agreement > 0.8
    assert result.shares == pytest.approx(truth)
    curve = judge_lognormal(PGV, fallen)
    assert abs(curve.log_score - result.log_score) < 0.02  # the curve is of the same kind, fitted on 200 tests
    assert curve.log_score < result.log_score


def test_a_model_fitted_to_noise_is_not_rewarded() -> None:
    rng = np.random.default_rng(3)
    outcome = rng.random(200) < 0.5
    candidates = np.where(rng.random((300, 200)) < 0.5, 0.1, 0.9)  # the best of 300 fits half of the noise well
    assert judge(candidates, [""] * 300, outcome).agreement == pytest.approx(0.5, abs=0.08)


def test_ensembles_are_weights_about_their_median() -> None:
    weights = ensembles().reshape(len(MEDIANS), len(DEVIATIONS), len(RATIOS))
    assert weights.sum(axis=2) == pytest.approx(1.0)
    middle = np.exp(weights @ np.log(RATIOS))
    inner = (MEDIANS > 0.12) & (MEDIANS < 0.16)
    assert middle[inner][:, 2] == pytest.approx(np.repeat(MEDIANS[inner], 1), rel=0.02)


def test_a_rock_leans_by_its_part_of_the_angle() -> None:
    column = Model(lean=0.25).column(0.1)
    assert column.blocks[0].joint.inclination == pytest.approx(0.25 * np.arctan(0.1))
    assert Model(edges_only=True).column(0.1).blocks[0].joint.strips is not None
