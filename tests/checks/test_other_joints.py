"""Checks repeated with other joints, and the restitution beside an answer."""

import copy
import math
import tomllib
from dataclasses import replace
from itertools import pairwise

import pytest
from support.fmus import ROOT

from multiblock import (
    Block,
    Column,
    InputError,
    Joint,
    Motion,
    Plan,
    Structure,
    check,
    housner_restitution,
    restitution,
    wavelets,
)
from solver.checks.answer import PASSES
from solver.checks.limits import Limits
from solver.checks.other_joints import OtherJoints, changed, joints_sentence, other_joints
from solver.checks.table import PLAIN, Row
from solver.models.structure.modes import modes_in_space
from solver.statics.calibrate import damping_from_ratio, damping_from_restitution, with_joints
from solver.statics.rocking import critical_damping, restitution_sentence

G = 9.80665
BLOCK = Column("block", (Block(1.7, 0.45, 0.45, 700.0, Joint(3e9, 1e-3)),))
PLAN = Plan(ensemble=2, margin=False)


def shaken() -> Motion:
    return wavelets.one_sine(0.42 * G, 1.1)


@pytest.mark.long  # takes seconds
def test_runs_with_other_joints_are_those_of_checks_of_their_own() -> None:
    """Compare outcome and falls at each modulus and damping with checks of columns that have them."""
    found = check(BLOCK, [shaken()], plan=PLAN)
    assert [(one.key, one.factor) for one in found.others] == [
        ("modulus", 0.5),
        ("modulus", 2.0),
        ("damping", 0.25),
        ("damping", 4.0),
    ]
    laws = ((1.5e9, 1e-3), (6e9, 1e-3), (3e9, 2.5e-4), (3e9, 4e-3))
    for one, (stiffness, damping) in zip(found.others, laws, strict=True):
        apart = check(with_joints(BLOCK, stiffness, damping), [shaken()], plan=replace(PLAN, joints=False))
        assert one.outcome == apart.answer.partition(":")[0].split()[0]
        assert one.note == f"{apart.fallen[0]} of 2 varied ones fall"
        assert apart.others == ()
    assert "was not tried" in replace(found, others=()).of_joints[0]


def test_a_failure_without_a_fall_is_named() -> None:
    plan = replace(PLAN, limits=Limits(displacement=1e-3))
    found = check(BLOCK, [wavelets.one_sine(0.26 * G, 1.5)], plan=plan)
    assert found.fallen[0] == 0
    assert {(one.outcome, one.note) for one in found.others} == {
        ("FAILS", "0 of 2 varied ones fall; by displacement of the top")
    }


def test_sentence_says_what_the_answer_hangs_on() -> None:
    rows = [Row("overturning", 0.0, 0.0, PLAIN), Row("overturning, margin", 1.0, 0.5, PLAIN)]
    words = ("PASSES", "PASSES", "FAILS", "PASSES")
    changes = (("modulus", 0.5), ("modulus", 2.0), ("damping", 0.25), ("damping", 4.0))

    def said(*outcomes: str) -> str:
        others = [OtherJoints(*change, one, "n fall") for change, one in zip(changes, outcomes, strict=True)]
        return joints_sentence(rows, others)

    hangs = said(*words)
    assert hangs.startswith("The answer hangs on the damping: measure it. FAILS with 0.25 times the damping (n fall);")
    assert "PASSES with 4 times the damping" in hangs
    assert "hangs on the modulus and on the damping: measure them" in said("FAILS", "PASSES", "PASSES", "FAILS")
    assert said(*["PASSES"] * 4).startswith("The answer stays with other joints: 0.5 times the modulus")


def test_answer_shows_the_restitution() -> None:
    """Check the restitution of Housner's block, 1 - 1.5 sin^2(alpha), and of the model as it rocks."""
    rigid = 1.0 - 1.5 * math.sin(math.atan(0.45 / 1.7)) ** 2
    said = restitution_sentence(BLOCK)
    assert f"the model {restitution(BLOCK):.3f}, Housner's rigid block {rigid:.3f}" in said
    many = Column("many", (Block(0.1, 0.45, 0.45, 50.0, Joint(3e9, 1e-3)),) * 13)
    assert "not worked out beyond 12 blocks" in restitution_sentence(many)


def test_a_statue_on_a_pedestal_rocks_on_the_pedestal() -> None:
    """Check that its restitution and its critical damping are those of the statue alone, whose base is that joint."""
    pedestal = Block(0.9, 0.8, 0.8, 1500.0, Joint(4e9, 1e-3))
    both = Column("both", (*BLOCK.blocks, pedestal))
    assert housner_restitution(both) == pytest.approx(housner_restitution(BLOCK), rel=1e-12)
    assert critical_damping(both) == pytest.approx(2.0 * math.sqrt(700.0 / (3e9 * 0.45**2)), rel=1e-12)


def test_housner_out_of_reach_is_refused_with_the_nearest() -> None:
    """Check that no damping exceeds the critical one; the nearest is what the column has at the damping that
    is named.
    """
    stocky = Column("stocky", (Block(2.0, 1.0, 1.0, 4000.0, Joint(5e9, 1e-3)),))
    most = damping_from_ratio(stocky, 1.0)
    with pytest.raises(InputError, match="the nearest") as refused:
        damping_from_restitution(stocky)
    words = str(refused.value).replace(",", "").replace(";", "").split()
    (nearest,) = (float(b) for a, b in pairwise(words) if a == "is" and b[0].isdigit())
    eta = float(words[words.index("damping", words.index("of")) + 2])
    assert eta <= most * 1.01
    assert restitution(with_joints(stocky, damping=eta)) == pytest.approx(nearest, abs=2e-3)


def test_the_damper_of_a_bearing_follows_the_factors() -> None:
    """Compare the damping ratio of the first mode with that of files with another `damping` of the rubber."""
    given = tomllib.loads((ROOT / "examples" / "structures" / "statue-on-rubber.toml").read_text(encoding="utf-8"))

    def ratio(structure: Structure) -> float:
        return float(modes_in_space(structure).damping_ratio[0])

    for change, stiffer, wanted in (
        (("damping", 4.0), 1.0, 0.590),
        (("damping", 0.25), 1.0, 0.0369),
        (("modulus", 2.0), 2.0, 0.209),
    ):
        data = copy.deepcopy(given)
        (bearing,) = data["bearing"]
        bearing |= {"stiffness": stiffer * bearing["stiffness"], "damping": change[1] * bearing["damping"]}
        made = ratio(changed(Structure.from_dict(given), *change))
        assert made == pytest.approx(ratio(Structure.from_dict(data)), rel=5e-3)  # measured: 1.5e-3, the beds
        assert made == pytest.approx(wanted, rel=2e-3)


def test_a_damper_of_a_bearing_alone_is_varied() -> None:
    given = tomllib.loads((ROOT / "examples" / "structures" / "statue-on-rubber.toml").read_text(encoding="utf-8"))
    given["joints"]["damping"] = given["bearing"][0]["vertical_damping"] = 0.0
    model = Structure.from_dict(given)
    assert not any(law.damping for law in model.laws)
    assert model.is_damped
    tried = other_joints(model, 1.0, lambda subject: (PASSES, str(subject.model.joints[-1].bearing.dashpot)))
    assert [float(one.note) for one in tried] == [430.0, 1720.0, 215.0, 3440.0]
    given["bearing"][0]["damping"] = 0.0
    assert not Structure.from_dict(given).is_damped
