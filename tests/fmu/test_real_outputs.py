"""FMUs for hosts that read every output as a real, and stop at the first that is none."""

from __future__ import annotations

import sys
import zipfile
from pathlib import Path

import pytest
from fmpy import read_model_description
from support.child import call
from support.fmus import LINUX, Fmus, run, stack_file
from support.inside import lives

pytestmark = pytest.mark.long  # builds FMUs

KINDS: dict[str, tuple[str, ...]] = {
    "python": (),
    "native": LINUX,
    "native3": ("--native", "--platforms", "x86_64-linux", "--fmi", "3"),
}


@pytest.mark.parametrize("kind", KINDS)
def test_every_output_is_a_real(kind: str, tmp_path: Path) -> None:
    """Check that it is valid, with the outputs of the usual FMU that are reals, which give the same; and another
    identity.
    """
    if kind != "python" and not sys.platform.startswith("linux"):
        pytest.skip("built for Linux")
    file = stack_file(tmp_path, 2)
    usual = Fmus.build(file, tmp_path / "usual.fmu", *KINDS[kind])
    reals = Fmus.build(file, tmp_path / "reals.fmu", "--real-outputs", *KINDS[kind])
    assert "No problems found" in run("fmpy", "validate", reals)
    before, after = (read_model_description(str(fmu)) for fmu in (usual, reals))
    seen = [[v for v in about.modelVariables if v.causality == "output"] for about in (before, after)]
    kinds = {"Float64" if kind == "native3" else "Real"}
    assert {v.type for v in seen[1]} == kinds
    left_out = {v.name for v in seen[0]} - {v.name for v in seen[1]}
    assert left_out == {"overturn_joint", "overturned", "verdict"}
    assert {v.name for v in seen[0] if v.type in kinds} == {v.name for v in seen[1]}
    assert before.guid != after.guid
    with zipfile.ZipFile(reals) as archive:
        assert "<code>verdict</code>" not in archive.read("documentation/index.html").decode()
    if kind == "native3":
        return
    names = [v.name for v in seen[1]]
    first, second = (call(lives.read_as_reals, fmu, names) for fmu in (usual, reals))
    assert first == second
    assert max(map(abs, first)) > 0.0
