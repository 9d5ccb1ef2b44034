"""The Modelica package: its syntax, and that it names what the FMU has. It is not compiled here."""

from __future__ import annotations

import importlib.util
import re

import pytest
from support.fmus import ROOT

from fmu_src.references import REFERENCES

FILE = ROOT / "examples" / "modelica" / "MultiblockColumn.mo"
REACTION = {"R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt"}
MOTION = {"ax", "az", "jx", "jz", "theta", "omega", "alpha"}


def test_a_parser_reads_it() -> None:
    if importlib.util.find_spec("pymoca") is None:
        pytest.skip("pymoca is not installed: the extra masters")
    from pymoca import parser

    tree = parser.parse(FILE.read_text(encoding="utf-8"))
    assert tree is not None, "a mistake of syntax"
    models = tree.classes["MultiblockColumn"].classes
    assert set(models) == {"BaseFlange", "Slab", "Example"}
    flange = models["BaseFlange"]
    by_prefix = {
        kind: {name for name, symbol in flange.symbols.items() if kind in symbol.prefixes}
        for kind in ("input", "output")
    }
    assert by_prefix == {"input": REACTION, "output": MOTION}
    assert {f"base.{name}" for name in REACTION | MOTION} <= set(REFERENCES)


def test_the_reaction_is_symmetric_and_opposite() -> None:
    """Check that each cut force is -(R0 - row of m times a), with the rows of a symmetric matrix."""
    text = FILE.read_text(encoding="utf-8")
    rows = {
        "x.f": ("R0x", "mxx", "mxz", "mxt"),
        "z.f": ("R0z", "mxz", "mzz", "mzt"),
        "turn.tau": ("R0m", "mxt", "mzt", "mtt"),
    }
    for force, (own, *masses) in rows.items():
        terms = " - ".join(f"{m} * {a}" for m, a in zip(masses, ("a_x", "a_z", "a_t"), strict=True))
        assert re.search(rf"{re.escape(force)} = -\({own} - {re.escape(terms)}\);", text), force


def test_every_input_of_a_component_has_a_binding() -> None:
    """Check the rule of Modelica: inputs that are no connectors are bound where their component is declared."""
    text = re.sub(r"//.*", "", FILE.read_text(encoding="utf-8"))
    models = dict(re.findall(r"model (\w+) (.*?)end \1;", text, re.DOTALL))
    inputs = {name: set(re.findall(r"input [\w.]+ (\w+)", body)) for name, body in models.items()}
    assert inputs == {"BaseFlange": REACTION, "Slab": REACTION | {"ground_ax"}, "Example": set()}
    for owner, kind, component in (("Slab", "BaseFlange", "base"), ("Example", "Slab", "slab")):
        (binding,) = re.findall(rf"{kind} {component}\((.*?)\);", models[owner], re.DOTALL)
        assert set(re.findall(r"(\w+) = ", binding)) == inputs[kind]
        assert not re.search(rf"^\s*{component}\.[\w.]+ =", models[owner], re.MULTILINE)
