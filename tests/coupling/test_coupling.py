"""The column on isolators and on soil, FMU by FMU, against the same systems solved as one and against closed form."""

from __future__ import annotations

import re
from graphlib import TopologicalSorter
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from support.child import call_with_example as example
from support.child import ended_with_example, returned
from support.fmus import REFUSED, ROOT, run
from support.inside import coupled as inside
from support.inside import systems

pytestmark = pytest.mark.long  # builds native FMUs

EXAMPLE = ROOT / "examples" / "coupling"
SPLIT = ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")
BODY = ("F0x", "F0z", "F0m", "Mxx", "Mxz", "Mxt", "Mzz", "Mzt", "Mtt")


@pytest.mark.parametrize("partner", ["isolator", "soil"])
def test_initialization_has_no_algebraic_loop(coupled: Path, partner: str) -> None:
    """Check outputs and what they follow, in initialization and later, within the FMUs and through the connections."""
    for when in ("initialUnknowns", "outputs"):
        follows: dict[tuple[str, str], set[tuple[str, str]]] = {}
        variables = {}
        for part in ("column", partner):
            description = read_model_description(systems.path_of(str(coupled), partner, part))
            variables[part] = {variable.name for variable in description.modelVariables}
            for unknown in getattr(description, when):
                assert unknown.dependencies is not None
                names = {(part, variable.name) for variable in unknown.dependencies}
                follows[part, unknown.variable.name] = names
                if when == "outputs" and re.match(r"base\.(R0|m)|body\.", unknown.variable.name):
                    assert {name for _, name in names} <= {"base.theta", "base.omega"}  # which are not connected
        for name in SPLIT:
            follows[partner, f"column.{name}"] = {("column", f"base.{name}")}
        for name in BODY:
            if f"body.{name}" in variables[partner]:
                follows["column", f"body.{name}"] = {(partner, f"body.{name}")}
        TopologicalSorter(follows).prepare()  # raises CycleError


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
@pytest.mark.parametrize("damping", [1e-3, 0.0])
def test_the_split_reaction_couples_what_the_plain_one_blows_up(coupled: Path, damping: float) -> None:
    ways = [(1e-3, "plain"), (2e-3, "line"), (1e-3, "line"), (5e-4, "line"), (1e-3, "iterated"), (1e-3, "parabola")]
    window, agreement, (plain, coarse, middle, fine, iterated, parabola) = example(
        inside.on_linear_isolators, coupled, damping, 0.01, ways
    )
    assert window > 400
    assert agreement < 1e-5
    assert plain[0] > 10.0
    assert middle[0] < 2e-3
    assert middle[1] < 2e-3
    assert np.log2(coarse[0] / fine[0]) / 2.0 > 1.6
    assert iterated[0] < 0.5 * middle[0]
    assert parabola[0] < 0.3 * middle[0]
    assert middle[2] == pytest.approx(middle[3], rel=1e-3)
    assert iterated[2] == pytest.approx(iterated[3], rel=1e-4)


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
def test_a_heavy_slab_bears_the_plain_reaction(coupled: Path) -> None:
    _, _, (plain, split) = example(inside.on_linear_isolators, coupled, 1e-3, 100.0, [(1e-3, "plain"), (1e-3, "")])
    assert plain[0] < 1.0  # stable
    assert split[0] < 2e-3


@pytest.mark.campaign  # takes 10 s and more, and changes seldom
def test_every_partner_agrees_with_the_system_solved_as_one(coupled: Path) -> None:
    ways = [(1e-3, ""), (5e-4, ""), (1e-3, "iterated")]
    for name, seen in example(inside.on_every_partner, coupled, ways).items():
        (top, other, given, taken), (finer, _, _, _), (again, _, _, _) = seen
        assert top < 2e-3, name
        assert other < (2e-2 if "soil" in name else 2e-3), name  # the foundation hardly rotates
        assert finer < 0.5 * top, name
        assert again < 2e-3, name
        assert given == pytest.approx(taken, rel=2e-3), name


def test_a_slab_alone_is_an_oscillator(coupled: Path) -> None:
    seen = example(inside.slab, coupled / "isolator.fmu")
    t = 1e-3 * np.arange(1, 4001)
    # x'' + x' + 40 x = -sin 5 t from rest
    steady = np.imag(-np.exp(5j * t) / (40.0 - 25.0 + 5j))
    start = np.imag(-1.0 / (15.0 + 5j)), np.imag(-5j / (15.0 + 5j))
    omega = np.sqrt(40.0 - 0.25)
    free = np.exp(-0.5 * t) * (start[0] * np.cos(omega * t) + (start[1] + 0.5 * start[0]) / omega * np.sin(omega * t))
    exact = steady - free
    assert np.max(np.abs(np.array(seen) - exact)) < 1e-4 * np.max(np.abs(exact))


def test_a_foundation_alone_follows_the_cones(coupled: Path) -> None:
    ends = example(inside.foundation, coupled / "soil.fmu")
    shear, r, nu = 1900.0 * 250.0**2, 3.0, 0.3
    springs = [8 * shear * r / (2 - nu), 4 * shear * r / (1 - nu), 8 * shear * r**3 / (3 * (1 - nu))]
    assert np.array(ends) == pytest.approx(np.diag(1e6 / np.array(springs)), rel=1e-6, abs=1e-12)


def test_partners_are_sound_fmus_whose_state_can_be_kept(coupled: Path) -> None:
    for name in ("isolator", "soil"):
        assert "No problems found" in run("fmpy", "validate", coupled / f"{name}.fmu")
        found = example(inside.kept_state, coupled / f"{name}.fmu")
        assert found["same"]
        assert found["moved"]
        assert f"({REFUSED})" in found["backwards"]
        assert "discard" in found["no number"].lower()


def test_a_partner_gives_the_master_one_reason(coupled: Path) -> None:
    for name in ("isolator", "soil"):
        done = ended_with_example(inside.kept_state, coupled / f"{name}.fmu")
        assert done.returncode == 0
        assert returned(done.stdout)["moved"]
        reasons = ("the step must be a positive time", "ground.ax = nan: must be a finite number")
        for text in (done.stdout, done.stderr) if REFUSED == "error" else (done.stderr,):
            lines = [line for line in text.splitlines() if "not made" in line or "Fatal" in line]
            assert [reason in line for reason, line in zip(reasons, lines, strict=True)] == [True, True], lines
