"""The rule that code knows the protocol of a model only: classes are asked for where files and arguments are read."""

from __future__ import annotations

import ast
import inspect
from pathlib import Path

from support.fmus import ROOT

from solver.models import protocol
from solver.models.column.kind import KIND as COLUMNS
from solver.models.structure.kind import STRUCTURES

CLASSES = {"Column", "Structure", "Response", "SpatialResponse"}
MOST = 2


def asked(file: Path) -> list[str]:
    """Return the lines of a file that ask whether something is a column or a structure, or the response of one."""
    found, text = [], file.read_text(encoding="utf-8")
    if "isinstance" not in text or not any(name in text for name in CLASSES):
        return []  # spared the parser
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "isinstance":
            names = {name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name)}
            if names & CLASSES:
                found.append(f"{file.relative_to(ROOT)}:{node.lineno}")
    return found


def test_classes_of_models_are_hardly_asked_for() -> None:
    files = [*(ROOT / "solver").rglob("*.py"), *(ROOT / "fmu_src").rglob("*.py"), ROOT / "build_fmu.py"]
    lines = [line for file in files for line in asked(file)]
    assert len(lines) <= MOST, lines


def test_kinds_answer_what_their_protocol_leaves_open() -> None:
    """Find fields without a value, and methods that raise NotImplementedError."""
    values, methods = vars(protocol.Kind), inspect.getmembers(protocol.Kind, inspect.isfunction)
    open_fields = {name for name in protocol.Kind.__annotations__ if name not in values}
    open_methods = {name for name, method in methods if "raise NotImplementedError" in inspect.getsource(method)}
    assert {"word", "outputs", "largest", "kept"} <= open_fields
    assert "single_run" in open_methods
    for kind in (COLUMNS, STRUCTURES):
        assert all(hasattr(kind, name) for name in open_fields)
        assert [name for name in open_methods if getattr(type(kind), name) is values[name]] == []
