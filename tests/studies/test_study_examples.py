"""Every study of the examples can be read, and some of its runs be made."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest
from support.fmus import ROOT

from solver.studies import Study, chunks

FILES = sorted((ROOT / "examples" / "studies").glob("*.toml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_some_runs_of_each(path: Path) -> None:
    for table in tomllib.loads(path.read_text(encoding="utf-8"))["motion"]:
        if "record" in table and not (path.parent / table["record"]).is_file():
            pytest.skip(f"no record {table['record']}")
    study = Study.from_toml(path)
    numbers = [int(k) for k in np.linspace(0, study.runs - 1, 4)]
    rows = chunks.make(study, numbers).rows
    assert [row[0] for row in rows] == numbers
    for _, values, measures, outputs, failure in rows:
        assert failure == ""
        assert len(values) == len(study.varied)
        assert all(measure > 0.0 for measure in measures)
        assert max(outputs["peak_u" if study.in_space else "peak_ux"]) > 0.0


def test_numbers_of_runs() -> None:
    """Compare with their first lines and with the pages."""
    wanted = {"fragility": 100_000, "reference": 10_000, "reference-pulses": 2000, "montecarlo": 2000}
    wanted |= {"figure3": 960, "spectrum": 1008, "casks": 1680}
    found = {path.stem: Study.from_toml(path).runs for path in FILES if path.stem in wanted}
    assert found == wanted
