"""Every law, section, output, method and format is in all the tables that docs/extending.md names.

A test fails with lines that begin with the file to change.
"""

from __future__ import annotations

import importlib
import re
from pathlib import Path

from support.fmus import ROOT
from support.record_files import CASES

from solver.ground import records

RECORDS = ROOT / "solver" / "ground" / "records"


def text_of(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


def modules_with(function: str, folder: Path) -> list[str]:
    """The names of the modules in a folder that define a function."""
    return sorted(file.stem for file in folder.glob("*.py") if f"\ndef {function}(" in file.read_text(encoding="utf-8"))


def test_files_named_here_are_in_the_recipes() -> None:
    page = text_of("docs/extending.md")
    named = set(re.findall(r"[\"']((?:docs|solver|fmu_src|tests)/[\w/.]+\.\w+)[:\"']", text_of(f"{Path(__file__)}")))
    assert len(named) > 3
    assert [name for name in sorted(named) if f"`{name}`" not in page and name != "docs/extending.md"] == []


def test_formats_of_records_are_complete() -> None:
    forgotten = []
    for name in modules_with("recognised", RECORDS):
        module = importlib.import_module(f"solver.ground.records.{name}")
        if getattr(module, "NAME", "CSV") not in records.NAMES:
            forgotten.append(f"solver/ground/records/reader.py: _FORMATS or _OF_CHANNELS lacks {name}")
    for name in records.NAMES:
        if name not in {case.format for case in CASES.values()}:
            forgotten.append(f"tests/support/record_files.py: CASES has no file of {name}")
        if f"\n| {name} " not in text_of("docs/records.md"):
            forgotten.append(f"docs/records.md: the table has no row of {name}")
    assert forgotten == []
