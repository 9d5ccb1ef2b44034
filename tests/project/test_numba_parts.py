"""The versions of numba: private parts in one place, a range that is named, equal bits without linking."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import pytest
from support.child import ended, returned
from support.fmus import ROOT, Fmus, finish
from support.inside import failures, imports

import build_fmu
from solver import InputError
from solver.kernels.numba_ext import numba_parts

SMOKE = ROOT / "tests" / "project" / "numba_smoke.py"
ALLOWED = {
    "solver/kernels/numba_ext/numba_parts.py",
    "solver/kernels/numba_ext/linking.py",
}
PUBLIC = {"numba", "numba.extending", "numba.types", "llvmlite", "llvmlite.binding"}  # llvmlite.binding is documented


def imported(file: Path) -> set[str]:
    """Modules of numba and llvmlite that a file imports."""
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


def test_private_parts_are_imported_in_one_place() -> None:
    public = {"numba.cfunc", "numba.njit", "numba.typeof", "numba.core.event"}  # the last is documented
    for folder in ("solver", "fmu_src", "multiblock"):
        for file in sorted((ROOT / folder).rglob("*.py")):
            if file.relative_to(ROOT).as_posix() not in ALLOWED:
                assert imported(file) <= PUBLIC | public, file


def test_every_module_that_linking_imports_is_listed() -> None:
    listed = {place for place, _, _ in numba_parts._LINKING}
    private = imported(ROOT / "solver" / "kernels" / "numba_ext" / "linking.py") - PUBLIC
    assert private <= listed


@pytest.mark.parametrize("version", ["0.58.1", "0.9.0"])
def test_a_numba_that_is_too_old_is_named_with_what_to_install(version: str) -> None:
    done = ended(imports.with_numba, version)
    assert returned(done.stdout) == (
        f"numba {version} is too old, needs numba 0.59 or newer: pip install 'numba>=0.59,<1'"
    )


@pytest.mark.long
def test_an_fmu_under_a_numba_that_is_too_old_says_what_to_install(fmus: Fmus) -> None:
    done = ended(failures.under_numba, fmus.damped, "0.58.1")
    assert done.returncode == 1
    first = done.stderr.splitlines()[0]
    assert first.startswith("phocas_damped: needs Python 3.11 or newer with numpy and numba 0.59 or newer")
    assert "pip install 'numba>=0.59,<1'" in first
    assert "numba 0.58.1 is too old" in first


def test_a_native_fmu_is_refused_where_kernels_cannot_be_linked(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_fmu, "LINKING", False)
    with pytest.raises(InputError, match=r"--native: needs kernels that are linked, and numba .* does not"):
        build_fmu.build_native_fmu(build_fmu.DEFAULT_COLUMN)


@pytest.mark.campaign  # compiles all kernels by numba's own pipeline, a few minutes
def test_the_bits_are_the_same_without_linking_and_all_is_cached(tmp_path: Path) -> None:
    folders = {"1": {}, "0": {"NUMBA_CACHE_DIR": str(tmp_path / "numba"), "XDG_CACHE_HOME": str(tmp_path)}}
    printed = {}
    for linking, places in folders.items():
        done = finish(sys.executable, SMOKE, "--without-fmu", MULTIBLOCK_LINKING=linking, **places)
        assert done.returncode == 0, done.stderr
        assert f"linking {linking == '1'}" in done.stderr
        assert "Cannot cache" not in done.stderr  # numba's warning
        printed[linking] = done.stdout
    assert printed["0"] == printed["1"]
    assert len(printed["1"].split()) > 2 + 3 * 16  # a run, and the peaks of 16 in lanes
    assert list((tmp_path / "numba").rglob("*run_lanes_*_plain-*.nbc"))
