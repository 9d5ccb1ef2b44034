"""The versions of numba: private parts in one place, a range that is named."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from support.child import ended, returned
from support.fmus import ROOT
from support.inside import imports

from solver.kernels.numba_ext import numba_parts

SMOKE = ROOT / "tests" / "project" / "numba_smoke.py"
ALLOWED = {
    "solver/kernels/numba_ext/numba_parts.py",
    "solver/kernels/numba_ext/linking.py",
}
PUBLIC = {"numba", "numba.extending", "numba.types", "llvmlite", "llvmlite.binding", "llvmlite.ir"}  # documented


def imported(file: Path) -> set[str]:
    """Return the modules of numba and llvmlite that a file imports."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {item.name for item in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            found |= {node.module}
            found |= {f"{node.module}.{item.name}" for item in node.names if node.module in ("numba", "llvmlite")}
    return {name for name in found if name.partition(".")[0] in ("numba", "llvmlite")}


def test_this_numba_has_every_part_that_linking_uses() -> None:
    assert numba_parts.missing_for_linking() == []


def test_a_part_that_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    parts = (
        ("numba.core.codegen", "JITCodeLibrary", "finalize no_such_attribute"),
        ("numba.core.codegen", "NoSuchLibrary", ""),
        ("numba.core.no_such_module", "Environment", ""),
    )
    monkeypatch.setattr(numba_parts, "_LINKING", parts)
    assert numba_parts.missing_for_linking() == [
        "numba.core.codegen.JITCodeLibrary.no_such_attribute",
        "numba.core.codegen.NoSuchLibrary",
        "numba.core.no_such_module.Environment",
    ]


@pytest.mark.long  # takes seconds
def test_private_parts_are_imported_in_one_place() -> None:
    public = {"numba.cfunc", "numba.njit"}
    for folder in ("solver", "fmu_src", "multiblock"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            if file.relative_to(ROOT).as_posix() not in ALLOWED:
                assert imported(file) <= PUBLIC | public, file


def test_every_module_that_linking_imports_is_listed() -> None:
    listed = {place for place, _, _ in numba_parts._LINKING}
    private = imported(ROOT / "solver" / "kernels" / "numba_ext" / "linking.py") - PUBLIC
    assert private <= listed


@pytest.mark.parametrize("version", ["0.60.0", "0.9.0"])
def test_a_numba_that_is_too_old_is_named_with_what_to_install(version: str) -> None:
    done = ended(imports.with_numba, version)
    assert returned(done.stdout) == (
        f"numba {version} is too old, needs numba 0.61 or newer: pip install 'numba>=0.61,<1'"
    )
