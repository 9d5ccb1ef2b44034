"""FMUs of structures whose neighbours hit and whose joints crack, against `simulate`, and their states amid it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.child import call
from support.fmus import ROOT, Fmus, built_once
from support.followed import native_of, outputs
from support.inside import structures as inside

from solver import Motion, simulate
from solver.models.structure.model import Structure

CASKS = (ROOT / "examples" / "structures" / "casks.toml").read_text(encoding="utf-8")
PAIRS = "".join(f'[[neighbours.pair]]\nbetween = ["cask{k}", "cask{k + 1}"]\ngap = 5e-5\n\n' for k in range(1, 5))
PARAPET = """
[[block]]
name = "parapet"
on = "base"
at = [20.0, 0.0]
width = 0.45
depth = 1.0
height = 1.2
density = 1800.0
joint = {tensile_strength = 1e4, cohesion = 1e5}
"""
# they hit as they sway, and the parapet cracks far from them
CLOSE = CASKS.replace('[[block]]\nname = "pallet1"', f'{PAIRS}[[block]]\nname = "pallet1"') + PARAPET
H, DURATION = 0.01, 1.0  # s
T = H * np.arange(round(DURATION / H) + 1)
SAMPLES = np.column_stack([2.0 * np.sin(8.8 * T), 0.9 * np.sin(7.1 * T), 0.3 * np.sin(26.0 * T)])  # m/s2


@pytest.fixture(scope="module")
def casks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU of casks that stand 0.05 mm apart, and a parapet."""
    file = tmp_path_factory.mktemp("casks") / "casks.toml"
    file.write_text(CLOSE, encoding="utf-8")
    return built_once(tmp_path_factory, "close-casks.fmu", lambda path: Fmus.build(file, path))


def test_an_fmu_follows_a_run_through_hits_and_cracks(casks: Path, tmp_path: Path) -> None:
    seen = outputs(casks, SAMPLES, H, tmp_path, {"solver.tolerance": 1e-8})
    (tmp_path / "casks.toml").write_text(CLOSE, encoding="utf-8")
    motion = Motion.from_samples(H, SAMPLES[:, 0], ay=SAMPLES[:, 1], az=SAMPLES[:, 2])
    structure = Structure.from_toml(tmp_path / "casks.toml")
    response = simulate(structure, motion, DURATION, tolerance=1e-8, output_step=H, settle=0.0)
    assert np.sum(response.peaks["hit"] > 0.0) == 4  # the casks, not their pallets
    assert 0.1 < response.peaks["bond"][0] < 0.9
    size = response.rows.shape[1]
    largest = np.max(np.abs(response.rows), axis=0)
    apart = np.max(np.abs(seen[:, :size] - response.rows[1:]), axis=0)
    assert np.max(apart[largest > 0.0] / largest[largest > 0.0]) < 1e-5  # measured 7.1e-7


@pytest.mark.long  # takes seconds
def test_states_amid_contacts_and_cracks(casks: Path) -> None:
    found = call(inside.life, casks)
    assert all(found.values()), found


@pytest.mark.long  # builds a native FMU
def test_the_native_fmu_has_the_same_bits_through_hits_and_cracks(casks: Path, tmp_path: Path) -> None:
    native = native_of(CLOSE, tmp_path)
    assert np.array_equal(outputs(casks, SAMPLES, H, tmp_path), outputs(native, SAMPLES, H, tmp_path))
    assert all(call(inside.life, native).values())
