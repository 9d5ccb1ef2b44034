"""Rims in the validation: stiffness and damping in closed form, scores of models whose contact is known."""

from __future__ import annotations

import math
import sys

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the cases are not installed

from solver import Block, Column, Joint
from validation import command_line
from validation.cases import CASES, codes, free_rocking, shaken_rocks, structures
from validation.cases.shaken_rocks import Model
from validation.rims import WHOLE, label_of, on_rims
from validation.scores import with_lapse

SHARES = (0.01, 0.1, WHOLE)


def drum(section: str = "rectangle") -> Column:
    return Column("drum", (Block(1.5, 0.6, 0.6, 1200.0, Joint(1e9, 1e-3), section=section),))


@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("section", ["rectangle", "circle"])
def test_a_rim_is_as_stiff_in_all_as_the_whole_face(section: str, share: float) -> None:
    whole, rimmed = drum(section), on_rims(drum(section), share)
    stiffness = [column.contacts[0].area * column.blocks[0].joint.stiffness for column in (whole, rimmed)]
    assert stiffness[1] == pytest.approx(stiffness[0], rel=1e-12)
    assert rimmed.blocks[0].joint.rim == (None if share >= WHOLE else pytest.approx(share * 0.6))


@pytest.mark.parametrize("share", SHARES)
def test_damping_is_critical_as_the_block_lands_on_its_edge(share: float) -> None:
    block = on_rims(drum(), share).blocks[0]
    # a free body with one spring beside its centroid: its vibration is the only mode that is not rigid
    spring = block.joint.stiffness * share * 0.6 * 0.6 * np.array([[1.0, 0.3], [0.3, 0.09]])
    inertia = 1200.0 * (0.6**2 + 1.5**2) / 12.0
    square = np.max(np.linalg.eigvals(np.diag([1.0 / 1200.0, 1.0 / inertia]) @ spring).real)
    assert 0.5 * block.joint.damping * math.sqrt(square) == pytest.approx(1.0, rel=1e-12)
    half = on_rims(drum(), share, 0.5).blocks[0].joint
    assert half.damping == pytest.approx(0.5 * block.joint.damping, rel=1e-12)


def test_cases_without_rims_are_skipped_and_say_so(capsys: pytest.CaptureFixture[str], tmp_path: object) -> None:
    assert {case.name for case in CASES if case.takes_rims} == {
        *("rocks", "rocks-in-space", "free-rocking", "codes", "failure-amplitudes", "structures", "drums")
    }
    assert command_line.main(["--only", "size", "--rim", "0.1", "--output-folder", str(tmp_path)]) == 0
    assert "size: skipped: has no faces that could touch in a rim" in capsys.readouterr().out


@pytest.mark.parametrize("share", ["0.6", "0", "wide"])
def test_a_rim_wider_than_half_of_the_face_is_refused(share: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        command_line.main(["--rim", share])
    assert "must be a part of the width, 0.001 to 0.5" in capsys.readouterr().err


@pytest.mark.long  # takes seconds; tests/commands/test_new.py has other blocks of granite
def test_granite_is_nearer_to_what_was_measured_on_a_rim_than_on_its_whole_face() -> None:
    for name in ("granite 0.25 m", "granite 0.17 m", "granite 0.12 m"):
        measured = free_rocking.MEASURED[name][3]
        whole, rim = (abs(free_rocking.predicted_restitution(name, 1e10, share) - measured) for share in (WHOLE, 0.1))
        assert rim < 0.0055  # measured 0.0023, 0.0051, 0.0045
        assert whole > 1.4 * rim  # measured 0.0231, 0.0074, 0.0099


def test_drums_on_edges_move_as_those_of_the_program_that_has_such_contacts() -> None:
    _, ux = codes.here(codes.on_planar_rims(codes.column(5e10, 0.0), 0.01))
    assert np.max(np.abs(ux)) == pytest.approx(0.185, rel=0.06)  # m, HybriDFEM; 0.194, whole faces 0.451


@pytest.mark.long
def test_frames_on_rims_lose_what_rigid_ones_lose() -> None:
    for gamma in (0.0, 1.0):
        rigid = structures.rigid_restitution(gamma)
        whole, rim = (structures.frame_restitution(gamma, 1e10, share) / rigid for share in (WHOLE, 0.01))
        assert rim == pytest.approx(1.0, abs=2e-3)  # 1.0010, 1.0015
        assert whole > 1.02  # 1.023, 1.031


def test_restitution_of_a_frame_without_a_beam_is_that_of_housner() -> None:
    slope = math.atan2(structures.WIDTH, structures.HEIGHT)
    assert structures.rigid_restitution(0.0) == pytest.approx(free_rocking.housner(slope), rel=1e-12)


def test_the_best_rim_is_chosen_where_rocks_touch_in_it() -> None:
    rng = np.random.default_rng(0)
    truth = Model(rim=0.1)
    level = rng.uniform(0.0, 1.0, 60)
    fallen = level > 0.5
    bad = np.tile(rng.uniform(0.0, 1.0, 60) > 0.5, (len(truth.ratios), 1)).astype(float)
    good = np.tile(fallen, (len(truth.ratios), 1)).astype(float)
    rims = {label_of(0.1): {"upright, rim 10 %": good}, label_of(0.01): {"upright, rim 1 %": bad}}
    found = shaken_rocks.judged_on_rims(rims, {"upright": bad}, shaken_rocks.ensembles(), fallen)
    assert set(found["best of whole faces and rims"].chosen) == {"upright, rim 10 %"}
    assert found["best of all, rim 10 %"].log_score == pytest.approx(math.log(with_lapse(np.ones(1))[0]))
    assert found["one block, one ratio, rim 1 %"].agreement < 0.7
