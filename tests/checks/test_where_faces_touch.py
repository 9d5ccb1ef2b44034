"""The example with three answers: its program, and the table of the page on checks."""

from __future__ import annotations

import re
import runpy
import sys
from typing import Any

import pytest
from support.fmus import ROOT

from multiblock import Plan, check, housner_restitution, natural_frequencies, restitution
from solver.models.structure.modes import modes_in_space
from solver.statics.rocking import damping_on_edge

EXAMPLE = ROOT / "examples" / "structures" / "where_faces_touch.py"
FACES = ("whole", "rim", "feet")


@pytest.fixture(scope="module")
def program() -> dict[str, Any]:
    return runpy.run_path(str(EXAMPLE))


def test_the_page_has_the_restitutions_of_the_example(program: dict[str, Any]) -> None:
    page = (ROOT / "docs" / "check.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (?:0\.\d+ g, )?(whole|rim|feet) \| (0\.\d+) \|", page, re.MULTILINE)
    assert [name for name, _ in rows] == 2 * list(FACES)
    found = {name: restitution(program["column"](name)) for name in FACES}
    for name, written in rows:
        assert found[name] == pytest.approx(float(written), abs=6e-4)  # three digits
    assert found["whole"] > found["rim"] > found["feet"] > housner_restitution(program["column"]("whole"))


def test_damping_is_critical_on_the_edge_of_the_statue(program: dict[str, Any]) -> None:
    """Check half of the face, a band of the rim, and one foot."""
    bands = {"whole": 0.25, "rim": 0.083, "feet": 0.5 / 6.0}
    inertia = 486.0 * (0.5**2 + 1.8**2) / 12.0
    for name, band in bands.items():
        expected = damping_on_edge(4.286e9, 0.5 * band, 486.0, inertia, 0.25)
        assert program["column"](name).blocks[0].joint.damping == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("name", FACES)
def test_the_statue_in_space_is_that_of_the_plane(program: dict[str, Any], name: str) -> None:
    """Compare the first frequency that sways along the width; its joints never slide, and in space shear gives way a
    little.
    """
    flat = natural_frequencies(program["column"](name))[0]
    space = modes_in_space(program["structure"](name)).frequency
    assert min(abs(space / flat - 1.0)) < 0.05


@pytest.mark.long  # takes seconds
def test_program_prints_a_table(
    program: dict[str, Any], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scope = program["main"].__globals__
    quick = Plan(ensemble=1, margin=False, joints=False)
    monkeypatch.setitem(
        scope, "check", lambda model, target, plan: check(model, target=target, plan=quick, artificial=1)
    )
    monkeypatch.setattr(sys, "argv", ["where_faces_touch.py", "0.1"])
    program["main"]()
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("| a_g = 0.1 g | restitution |")
    assert [line.split(" | ")[0] for line in lines[2:5]] == [f"| {name}" for name in FACES]
    assert all("| 0 of 1 |" in line for line in lines[2:5])
    assert lines[5] == "Housner's rigid block: 0.893"
